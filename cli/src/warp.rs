//! A picture through a map.

use std::ops::Range;

use anyhow::{Result, bail};
use collinear::ProjectionError;
use collinear::geometry::Affine2;
use collinear::geometry::homography::Homography;
use collinear::mapping::polynomial::{Bilinear, Cubic, Quadratic};
use collinear::mapping::span::Span;
use collinear::mapping::{BlockSink, FootprintSink, FractionalLinear, Map};
use collinear::nalgebra::{Matrix2, Matrix3, Point2};
use collinear::resample::{
    Alpha, AreaFilter, Border, Coding, Filter, ImageView, ImageViewMut, Light, Pyramid, Sample,
    light_of, samples_of, warp, warp_area,
};
use collinear_io::map::MapFile;
use collinear_io::picture::Picture;
use rayon::ThreadPool;

/// Rows painted between two reports of progress.
const STEP: usize = 256;

/// What a value between texels is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AnyFilter {
    /// The texels around a position.
    Point(Filter),
    /// All texels that a pixel covers.
    Area(AreaFilter),
}

/// What lies beyond the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Beyond {
    /// A border of [`collinear`]'s; a transparent one makes a picture with opacity.
    Border(Border),
    /// Nothing may: a pixel that looks there is an error.
    Refused,
}

/// How a picture is painted.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    /// Width of the new picture, pixels.
    pub width: u32,
    /// Its height.
    pub height: u32,
    /// What a value between texels is made of.
    pub filter: AnyFilter,
    /// What lies beyond the picture.
    pub beyond: Beyond,
    /// What its samples mean.
    pub light: Light,
}

/// The map of a file.
///
/// # Errors
/// Coefficients that are no map.
pub fn map_of(file: &MapFile) -> Result<Box<dyn Map>> {
    Ok(match file {
        MapFile::Homography { matrix } => {
            let matrix = Matrix3::from_fn(|i, j| matrix[i][j]);
            Box::new(FractionalLinear::from_homography(&Homography::from_matrix(matrix)?))
        }
        MapFile::Affine { a, b } => Box::new(Affine2::from_coefficients(*a, *b)),
        MapFile::Bilinear { a, b } => Box::new(Bilinear::from_coefficients(*a, *b)?),
        MapFile::Quadratic { a, b } => Box::new(Quadratic::from_coefficients(*a, *b)?),
        MapFile::Cubic { a, b } => Box::new(Cubic::from_coefficients(*a, *b)?),
    })
}

/// The map from a new picture of some size, whose corners are four points of the old one: clockwise from the top left.
///
/// # Errors
/// Corners of which three lie on a line, or that cross.
pub fn map_of_quad(corners: &[Point2<f64>; 4], width: u32, height: u32) -> Result<Box<dyn Map>> {
    let (w, h) = (f64::from(width), f64::from(height));
    let screen = [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)].map(|(x, y)| Point2::new(x, y));
    let homography = Homography::from_quads(&screen, corners)?;
    Ok(Box::new(FractionalLinear::from_homography(&homography)))
}

/// How many pixels of the new picture look into the old one, and the first one that does not.
fn inside(map: &dyn Map, job: &Job, size: [u32; 2]) -> (u64, Option<[u32; 2]>) {
    let [w, h] = size.map(f64::from);
    let (mut count, mut outside) = (0, None);
    for y in 0..job.height {
        let mut next = 0;
        let mut look = |x: u32, is_inside: bool| {
            if is_inside {
                count += 1;
            } else if outside.is_none() {
                outside = Some([x, y]);
            }
        };
        map.blocks(y as i32, 0..job.width as i32, &mut |x, u, v| {
            (next..x as u32).for_each(|x| look(x, false));
            for (x, (u, v)) in (x as u32..).zip(u.iter().zip(v)) {
                look(x, (0.0..w).contains(u) && (0.0..h).contains(v));
                next = x + 1;
            }
        });
        (next..job.width).for_each(|x| look(x, false));
    }
    (count, outside)
}

impl Job {
    /// Paints the new picture, with the old one's channels; and how many of its pixels look into the old one.
    ///
    /// On the threads of a pool. Opacity is taken for what it is: colours are weighed by it. `progress` is called with the rows done and all rows.
    ///
    /// # Errors
    /// A picture whose samples do not fill it; a map that leads no pixel into it; where nothing may lie beyond it, a pixel
    /// that looks there.
    pub fn paint(
        &self,
        pool: &ThreadPool,
        picture: &Picture,
        map: &dyn Map,
        progress: &dyn Fn(usize, usize),
    ) -> Result<(Picture, u64)> {
        let (seen, outside) = inside(map, self, [picture.width, picture.height]);
        let all = u64::from(self.width) * u64::from(self.height);
        if seen == 0 {
            bail!("the map leads none of the {} × {} pixels into it", self.width, self.height);
        }
        let border = match (self.beyond, outside) {
            (Beyond::Refused, Some([x, y])) => bail!(
                "{} of {all} pixels look beyond it, the first in column {x} of row {y}",
                all - seen
            ),
            (Beyond::Refused, None) => Border::Clamp,
            (Beyond::Border(border), _) => border,
        };
        let clear = border == Border::Transparent && outside.is_some();
        let data = match (picture.channels, clear) {
            (1, false) => self.run::<1>(pool, &picture.data, picture, map, border, progress),
            (3, false) => self.run::<3>(pool, &picture.data, picture, map, border, progress),
            (1, true) => self.run::<2>(pool, &opaque::<1>(picture), picture, map, border, progress),
            (3, true) => self.run::<4>(pool, &opaque::<3>(picture), picture, map, border, progress),
            (2, _) => self.run::<2>(pool, &picture.data, picture, map, border, progress),
            (4, _) => self.run::<4>(pool, &picture.data, picture, map, border, progress),
            (other, _) => bail!("has {other} channels, 1 to 4 are read"),
        }?;
        let channels = (data.len() as u64 / all) as u8;
        let (width, height) = (self.width, self.height);
        Ok((Picture { width, height, channels, data, orientation: 1 }, seen))
    }

    fn run<const C: usize>(
        &self,
        pool: &ThreadPool,
        data: &[u8],
        picture: &Picture,
        map: &dyn Map,
        border: Border,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<u8>> {
        let (w, h) = (picture.width as usize, picture.height as usize);
        let view = ImageView::<u8, C>::new(data, w, h)?;
        let alpha = if C.is_multiple_of(2) { Alpha::Straight } else { Alpha::None };
        let coding = Coding { light: self.light, alpha };
        let (width, height) = (self.width as usize, self.height as usize);
        let mut made = vec![0; width * height * C];
        let bands = made.chunks_mut(STEP * width * C).zip((0..).step_by(STEP));
        if coding.is_plain() {
            let source = Source::new(view, self.filter)?;
            for (band, first) in bands {
                let rows = band.len() / (width * C);
                let mut target = ImageViewMut::<u8, C>::new(band, width, rows)?;
                pool.install(|| source.paint(&Below { map, first }, border, &mut target));
                progress(first as usize + rows, height);
            }
            return Ok(made);
        }
        let lights = light_of(view, coding)?;
        let source = Source::new(ImageView::<f32, C>::new(&lights, w, h)?, self.filter)?;
        let border = border.by_light::<u8, C>(coding);
        let mut light = vec![0.0; STEP.min(height) * width * C];
        for (band, first) in bands {
            let rows = band.len() / (width * C);
            let light = &mut light[..band.len()];
            // What stays so is not painted.
            light.fill(f32::NAN);
            let mut target = ImageViewMut::<f32, C>::new(light, width, rows)?;
            pool.install(|| source.paint(&Below { map, first }, border, &mut target));
            samples_of(light, coding, &mut ImageViewMut::<u8, C>::new(band, width, rows)?)?;
            progress(first as usize + rows, height);
        }
        Ok(made)
    }
}

/// A picture of one sample a pixel more: opaque.
fn opaque<const C: usize>(picture: &Picture) -> Vec<u8> {
    let mut data = Vec::with_capacity(picture.data.len() / C * (C + 1));
    for pixel in picture.data.chunks_exact(C) {
        data.extend_from_slice(pixel);
        data.push(u8::MAX);
    }
    data
}

/// A picture and how it is looked up.
enum Source<'a, T, const C: usize> {
    Point(ImageView<'a, T, C>, Filter),
    Area(Pyramid<T, C>, AreaFilter),
}

impl<'a, T: Sample, const C: usize> Source<'a, T, C> {
    fn new(view: ImageView<'a, T, C>, filter: AnyFilter) -> Result<Self, collinear::Error> {
        Ok(match filter {
            AnyFilter::Point(filter) => Self::Point(view, filter),
            AnyFilter::Area(filter) => Self::Area(Pyramid::new(view)?, filter),
        })
    }

    fn paint(&self, map: &dyn Map, border: Border, target: &mut ImageViewMut<'_, T, C>) {
        match self {
            Self::Point(view, filter) => warp(*view, map, *filter, border, target),
            Self::Area(pyramid, filter) => warp_area(pyramid, map, *filter, border, target),
        }
    }
}

/// The rows of a map from one on.
#[derive(Debug)]
struct Below<'a> {
    map: &'a dyn Map,
    first: i32,
}

impl Below<'_> {
    fn whole(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::new(p.x, p.y + f64::from(self.first))
    }
}

impl Map for Below<'_> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.map.at(&self.whole(screen))
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.map.jacobian(&self.whole(screen))
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        self.map.blocks(line + self.first, samples, emit);
    }

    fn footprints(&self, line: i32, samples: Range<i32>, emit: &mut FootprintSink<'_>) {
        self.map.footprints(line + self.first, samples, emit);
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        self.map.span(line + self.first, samples)
    }
}
