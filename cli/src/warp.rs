//! A picture through a map.

use anyhow::{Result, bail};
use collinear::geometry::Affine2;
use collinear::geometry::homography::Homography;
use collinear::mapping::polynomial::{Bilinear, Cubic, Quadratic};
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::{Matrix3, Point2};
use collinear::resample::{
    Alpha, AreaFilter, Border, Coding, Filter, ImageView, ImageViewMut, Light, Pyramid, Sample,
    light_of, samples_of, warp, warp_area,
};
use collinear_io::map::MapFile;
use collinear_io::picture::{Picture, PictureFormat};
use rayon::ThreadPool;

use crate::lookup::{Below, STEP};

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
    /// The format it is written in, which may have no opacity, or none of grey.
    pub format: PictureFormat,
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

/// Where the pixels of a new picture look.
struct Found {
    /// How many into the old one.
    inside: u64,
    /// How many anywhere at all.
    somewhere: u64,
    /// Column and row of the first one that does not look into it.
    outside: Option<[u32; 2]>,
}

/// Half of what positions are rounded to before they are looked up.
const ROUNDING: f64 = 1.0 / 8_589_934_592.0;

fn inside(map: &dyn Map, job: &Job, size: [u32; 2]) -> Found {
    let [w, h] = size.map(|n| -ROUNDING..f64::from(n) - ROUNDING);
    let mut found = Found { inside: 0, somewhere: 0, outside: None };
    for y in 0..job.height {
        let mut next = 0;
        map.blocks(y as i32, 0..job.width as i32, &mut |x, u, v| {
            for (x, (u, v)) in (x as u32..).zip(u.iter().zip(v)) {
                if x > next {
                    found.outside = found.outside.or(Some([next, y]));
                }
                next = x + 1;
                found.somewhere += 1;
                if w.contains(u) && h.contains(v) {
                    found.inside += 1;
                } else {
                    found.outside = found.outside.or(Some([x, y]));
                }
            }
        });
        if next < job.width {
            found.outside = found.outside.or(Some([next, y]));
        }
    }
    found
}

impl Job {
    /// Paints the new picture, with the old one's channels; and how many of its pixels look into the old one.
    ///
    /// On the threads of a pool. Opacity is taken for what it is: colours are weighed by it; grey becomes colour where
    /// the border or the format asks for it. `progress` is called with the rows done and all rows.
    ///
    /// # Errors
    /// A picture whose samples do not fill it; a map that leads no pixel into it before a transparent border,
    /// or none anywhere; opacity in a JPEG; where nothing may lie beyond it, a pixel
    /// that looks there.
    pub fn paint(
        &self,
        pool: &ThreadPool,
        picture: &Picture,
        map: &dyn Map,
        progress: &dyn Fn(usize, usize),
    ) -> Result<(Picture, u64)> {
        let found = inside(map, self, [picture.width, picture.height]);
        let all = u64::from(self.width) * u64::from(self.height);
        let border = match (self.beyond, found.outside) {
            (Beyond::Refused, Some([x, y])) => bail!(
                "{} of {all} pixels look beyond it, the first in column {x} of row {y}",
                all - found.inside
            ),
            (Beyond::Refused, None) => Border::Clamp,
            (Beyond::Border(border), _) => border,
        };
        let (width, height) = (self.width, self.height);
        if found.inside == 0 && border == Border::Transparent {
            bail!("the map leads none of the {width} × {height} pixels into it");
        }
        if found.somewhere == 0 {
            bail!("the map leads none of the {width} × {height} pixels anywhere");
        }
        let given = picture.channels;
        if !(1..=4).contains(&given) {
            bail!("has {given} channels, 1 to 4 are read");
        }
        let clear = border == Border::Transparent && found.outside.is_some();
        let opacity = given.is_multiple_of(2) || clear;
        if opacity && self.format == PictureFormat::Jpeg {
            bail!("has opacity, which no JPEG has: write a PNG or TIFF");
        }
        let coloured = matches!(border, Border::Constant([r, g, b, _]) if r != g || g != b);
        let with_grey = self.format == PictureFormat::Png || !opacity;
        let channels = if given > 2 || coloured || !with_grey { 3 } else { 1 } + u8::from(opacity);
        let border = match border {
            // Grey and its opacity.
            Border::Constant([grey, ..]) if channels == 2 => {
                Border::Constant([grey, 255.0, 0.0, 0.0])
            }
            other => other,
        };
        let spread = (channels != given).then(|| with_channels(picture, channels.into()));
        let samples = spread.as_deref().unwrap_or(&picture.data);
        let size = [picture.width as usize, picture.height as usize];
        let data = match channels {
            1 => self.run::<1>(pool, samples, size, map, border, progress),
            2 => self.run::<2>(pool, samples, size, map, border, progress),
            3 => self.run::<3>(pool, samples, size, map, border, progress),
            _ => self.run::<4>(pool, samples, size, map, border, progress),
        }?;
        Ok((Picture { width, height, channels, data, orientation: 1 }, found.inside))
    }

    fn run<const C: usize>(
        &self,
        pool: &ThreadPool,
        data: &[u8],
        [w, h]: [usize; 2],
        map: &dyn Map,
        border: Border,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Vec<u8>> {
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

/// A picture's samples with more channels: grey as colour, and opaque.
fn with_channels(picture: &Picture, channels: usize) -> Vec<u8> {
    let given = usize::from(picture.channels);
    let colours = channels - usize::from(channels.is_multiple_of(2));
    let mut data = Vec::with_capacity(picture.data.len() / given * channels);
    for pixel in picture.data.chunks_exact(given) {
        data.extend((0..colours).filter_map(|k| pixel.get(if given > 2 { k } else { 0 })));
        if channels > colours {
            let opacity = pixel.last().filter(|_| given.is_multiple_of(2));
            data.push(opacity.copied().unwrap_or(u8::MAX));
        }
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
