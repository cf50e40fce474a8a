//! A plane of the world seen face-on, from a photograph.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use anyhow::{Error, Result, anyhow, bail, ensure};
use collinear::ProjectionError;
use collinear::camera::{ExteriorOrientation, HomogeneousCamera, Orthographic};
use collinear::error::Brief;
use collinear::geometry::{Affine2, Homography};
use collinear::mapping::{Map, RowCoords};
use collinear::nalgebra::{Matrix2, Matrix3, Point2, Point3, Rotation3, RowVector3, Vector3};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut, warp};
use collinear_io::camera::{CameraFile, Interior};
use collinear_io::picture::Picture;
use collinear_io::plane::{PlaneFile, Rectangle};

use crate::photograph::PlaneMap;
use crate::picture::check_size;

/// Rows drawn between two reports of progress.
const BAND: usize = 64;

/// A rectangle's size may exceed a whole number of pixels by this much of one before another pixel is added.
const PART_OF_PIXEL: f64 = 1e-6;

/// A rectified picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rectified {
    /// The picture.
    pub picture: Picture,
    /// Its pixels that lie in the photograph; at least one.
    pub seen: u64,
}

/// What leads from a rectified picture into its photograph.
#[derive(Debug)]
pub struct Rectification {
    width: u32,
    height: u32,
    homography: Option<Homography>,
    map: Box<dyn Map>,
    through_lens: bool,
    mirrored: bool,
}

impl Rectification {
    /// The part of a plane in `rectangle`, face-on, its up upwards, in a picture of the given size.
    ///
    /// The picture's edges are the rectangle's. The screen is a parallel projection along the plane's normal, the map that
    /// of [`FractionalLinear::from_plane`](collinear::mapping::FractionalLinear::from_plane), followed by the photograph's
    /// lens.
    ///
    /// # Errors
    /// A size that [`check_size`] refuses; a camera or a plane out of their domain; a plane through the camera.
    pub fn of_plane(
        plane: &PlaneFile,
        rectangle: &Rectangle,
        camera: &CameraFile,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        check_size(width, height)?;
        let screen = face_on(plane, rectangle, width, height)?;
        let photograph = camera.camera()?;
        let map = PlaneMap::new(&plane.plane()?, &photograph, &screen)?;
        Ok(Self {
            width,
            height,
            homography: map.homography()?,
            through_lens: map.through_lens(),
            map: map.boxed(),
            mirrored: is_behind(camera, plane)?,
        })
    }

    /// The quadrilateral of a photograph with these corners, clockwise from the top left one, in pixels, as a rectangle.
    ///
    /// With a camera the corners and the map go through its lens; its place is not used.
    ///
    /// # Errors
    /// A size that [`check_size`] refuses; a quadrilateral that is concave, crosses itself or has three corners on a line; a
    /// corner that the lens has no image of.
    pub fn of_quad(
        corners: &[Point2<f64>; 4],
        camera: Option<&CameraFile>,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        check_size(width, height)?;
        let photograph = camera.map(CameraFile::camera).transpose()?;
        let (w, h) = (f64::from(width), f64::from(height));
        let sides = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(Point2::from);
        let (map, mirrored) = PlaneMap::of_quad(&sides, corners, photograph.as_ref())?;
        let (homography, through_lens) = (map.homography()?, map.through_lens());
        Ok(Self { width, height, homography, map: map.boxed(), through_lens, mirrored })
    }

    /// The map, photograph from rectified picture.
    #[must_use]
    pub fn map(&self) -> &dyn Map {
        self.map.as_ref()
    }

    /// The homography in it: the whole map where the photograph's camera has no lens, else the map into the ideal picture,
    /// to be followed by the lens. None for a camera other than pinhole, Brown's and orthographic.
    #[must_use]
    pub fn homography(&self) -> Option<&Homography> {
        self.homography.as_ref()
    }

    /// Whether the map goes through a lens, so that it is more than its homography.
    #[must_use]
    pub fn through_lens(&self) -> bool {
        self.through_lens
    }

    /// Whether left and right are exchanged: the photograph was taken from behind the plane, or the corners go
    /// counter-clockwise.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        self.mirrored
    }

    /// Draws the rectified picture.
    ///
    /// Grey stays grey unless the border has a colour; the photograph's opacity is passed over. With
    /// [`Border::Transparent`] the picture has a channel of opacity, 0 where the photograph shows nothing. `progress` is
    /// called with the rows done and all rows.
    ///
    /// Nothing but the new picture is allocated, apart from a few rows: photographs are large.
    ///
    /// # Errors
    /// A photograph whose samples do not fill it; a picture none of whose pixels lies in the photograph, whatever the
    /// border.
    pub fn apply(
        &self,
        photograph: &Picture,
        filter: Filter,
        border: Border,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Rectified> {
        let colored = match border {
            Border::Constant([r, g, b, _]) => r != g || g != b,
            _ => false,
        };
        let colors = if photograph.channels > 2 || colored { 3 } else { 1 };
        let opacity = border == Border::Transparent;
        let job =
            Job { rectification: self, photograph, colors, opacity, filter, border, progress };
        let (data, seen) = match photograph.channels {
            1 => job.run::<1>(),
            2 => job.run::<2>(),
            3 => job.run::<3>(),
            4 => job.run::<4>(),
            other => bail!("has {other} channels, 1 to 4 are read"),
        }?;
        if seen == 0 {
            return Err(self.unseen(photograph));
        }
        let (width, height, channels) = (self.width, self.height, job.channels() as u8);
        let picture = Picture { width, height, channels, data, orientation: 1 };
        Ok(Rectified { picture, seen })
    }

    /// Why nothing is seen, from the picture's corners and middle.
    fn unseen(&self, photograph: &Picture) -> Error {
        let (w, h) = (f64::from(self.width), f64::from(self.height));
        let mut reason = String::new();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (x, y) in [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h), (w / 2.0, h / 2.0)] {
            match self.map.at(&Point2::new(x, y)) {
                Ok(p) => {
                    for (k, c) in [p.x, p.y].into_iter().enumerate() {
                        (low[k], high[k]) = (low[k].min(c), high[k].max(c));
                    }
                }
                Err(e) => reason = e.to_string(),
            }
        }
        if low[0] <= high[0] {
            let [left, top] = low.map(Brief);
            let [right, bottom] = high.map(Brief);
            reason = format!(
                "they lie at x from {left} to {right}, y from {top} to {bottom}, and the photograph has {} × {} pixels",
                photograph.width, photograph.height
            );
        }
        anyhow!(
            "none of the {} × {} pixels lies in the photograph: {reason}",
            self.width,
            self.height
        )
    }
}

struct Job<'a> {
    rectification: &'a Rectification,
    photograph: &'a Picture,
    /// Samples of a new pixel, without its opacity.
    colors: usize,
    /// Whether a new pixel has an opacity.
    opacity: bool,
    filter: Filter,
    border: Border,
    progress: &'a dyn Fn(usize, usize),
}

impl Job<'_> {
    fn channels(&self) -> usize {
        self.colors + usize::from(self.opacity)
    }

    /// The new picture's samples, and how many of its pixels lie in the photograph.
    ///
    /// The photograph is looked up as it is, with all of its channels, and the rows of a band then get what they need of
    /// them: no copy of the photograph with other channels is made.
    fn run<const C: usize>(&self) -> Result<(Vec<u8>, u64)> {
        let Rectification { width, height, map, .. } = self.rectification;
        let (width, height, channels) = (*width as usize, *height as usize, self.channels());
        let (w, h) = (self.photograph.width as usize, self.photograph.height as usize);
        let source = ImageView::<u8, C>::new(&self.photograph.data, w, h)?;
        let mut data = vec![0; width * height * channels];
        let mut found = vec![0; width * height.min(BAND) * C];
        let mut seen = 0;
        (self.progress)(0, height);
        for (i, rows) in data.chunks_mut(width * channels * BAND).enumerate() {
            let first = i * BAND;
            let count = rows.len() / (width * channels);
            let found = found.get_mut(..width * count * C).unwrap_or_default();
            let inside = Mutex::new(vec![false; width * count]);
            let size = [self.photograph.width, self.photograph.height];
            let band = Band { map: map.as_ref(), first: first as i32, width, size, inside };
            for (target, border) in self.passes::<C>() {
                found.fill(0);
                let mut view = ImageViewMut::<u8, C>::new(found, width, count)?;
                warp(source, &band, self.filter, border, &mut view);
                match target.len() {
                    3 => copy_samples::<3, C>(rows, channels, target.start, found),
                    _ => copy_samples::<1, C>(rows, channels, target.start, found),
                }
            }
            let inside = band.inside.into_inner().unwrap_or_else(PoisonError::into_inner);
            seen += inside.iter().filter(|i| **i).count() as u64;
            if self.opacity {
                for (new, inside) in rows.chunks_exact_mut(channels).zip(inside) {
                    if let Some(last) = new.last_mut().filter(|_| inside) {
                        *last = u8::MAX;
                    }
                }
            }
            (self.progress)(first + count, height);
        }
        Ok((data, seen))
    }

    /// The new samples that each lookup fills, and its border. A grey photograph before a border with a colour is looked up
    /// once for each of the three.
    fn passes<const C: usize>(&self) -> Vec<(Range<usize>, Border)> {
        match self.border {
            Border::Constant(color) if C < self.colors => {
                let pass = |(k, c)| (k..k + 1, Border::Constant([c; 4]));
                color.into_iter().take(self.colors).enumerate().map(pass).collect()
            }
            border => vec![(0..self.colors, border)],
        }
    }
}

/// The first N samples of each pixel of C, to pixels of another number of channels, from sample `start` on.
fn copy_samples<const N: usize, const C: usize>(
    to: &mut [u8],
    channels: usize,
    start: usize,
    from: &[u8],
) {
    for (new, old) in to.chunks_exact_mut(channels).zip(from.chunks_exact(C)) {
        let new = new.get_mut(start..).and_then(<[u8]>::first_chunk_mut::<N>);
        if let (Some(new), Some(old)) = (new, old.first_chunk::<N>()) {
            *new = *old;
        }
    }
}

/// A map's rows from `first` on, which marks the pixels that lie in the photograph.
#[derive(Debug)]
struct Band<'a> {
    map: &'a dyn Map,
    first: i32,
    width: usize,
    /// The photograph's.
    size: [u32; 2],
    inside: Mutex<Vec<bool>>,
}

impl Band<'_> {
    fn whole(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::new(p.x, p.y + f64::from(self.first))
    }
}

impl Map for Band<'_> {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.map.at(&self.whole(screen))
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.map.jacobian(&self.whole(screen))
    }

    fn row(&self, line: i32, samples: Range<i32>, out: &mut RowCoords) {
        self.map.row(line + self.first, samples, out);
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        let start = line as usize * self.width;
        // As a lookup with a transparent border decides: by the texel that contains the point.
        let within = |origin: i32, offset: f32, size: i64| {
            let truncated = offset as i32;
            let texel = origin + truncated - i32::from(offset < truncated as f32);
            (0..size).contains(&i64::from(texel))
        };
        let [w, h] = self.size.map(i64::from);
        for run in out.runs() {
            let (u, v) = out.offsets(run);
            for ((x, u), v) in run.pixels().zip(u).zip(v) {
                if let Some(mark) = inside.get_mut(start + x as usize) {
                    *mark = within(run.origin[0], *u, w) && within(run.origin[1], *v, h);
                }
            }
        }
    }
}

/// The parallel projection of a plane along its normal, its rectangle filling the picture.
fn face_on(
    plane: &PlaneFile,
    rectangle: &Rectangle,
    width: u32,
    height: u32,
) -> Result<HomogeneousCamera> {
    let axes = plane.axes().map_err(collinear_io::Error::from)?;
    let row = |v: [f64; 3], sign: f64| RowVector3::from(v) * sign;
    let rows = [row(axes.right, 1.0), row(axes.up, -1.0), row(axes.normal, -1.0)];
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_rows(&rows));
    let exterior = ExteriorOrientation::new(Point3::from(plane.point), rotation);
    let Rectangle { left, bottom, right, top } = *rectangle;
    let (sx, sy) = (f64::from(width) / (right - left), f64::from(height) / (top - bottom));
    let scale = Affine2::from_coefficients([-left * sx, sx, 0.0], [top * sy, 0.0, sy]);
    Ok(Orthographic::new(exterior, scale)?.homogeneous())
}

/// Whether a camera sees a plane from behind.
fn is_behind(camera: &CameraFile, plane: &PlaneFile) -> Result<bool> {
    let (exterior, plane) = (camera.exterior.orientation()?, plane.plane()?);
    Ok(match camera.interior {
        Interior::Orthographic { .. } => {
            let along = exterior.camera_from_world().inverse() * Vector3::z();
            along.dot(&plane.normal()) > 0.0
        }
        _ => plane.signed_distance(&exterior.projection_center()) < 0.0,
    })
}

/// The rectangle of a plane that a photograph shows: the box about its border, traced pixel by pixel to the plane.
///
/// # Errors
/// A camera that lies in the plane. A border that does not meet the plane, since its horizon is in view: state a rectangle
/// then.
pub fn footprint(plane: &PlaneFile, camera: &CameraFile) -> Result<Rectangle> {
    let photograph = camera.camera()?;
    let surface = plane.plane()?;
    let unit = Rectangle { left: 0.0, bottom: 0.0, right: 1.0, top: 1.0 };
    // A camera in the plane sees no rectangle of it, and no advice to give one helps.
    PlaneMap::new(&surface, &photograph, &face_on(plane, &unit, 1, 1)?)?;
    let mut found = Rectangle {
        left: f64::INFINITY,
        bottom: f64::INFINITY,
        right: f64::NEG_INFINITY,
        top: f64::NEG_INFINITY,
    };
    for p in border(camera) {
        let world = match photograph.sensor().ground(&p, &surface) {
            Ok(world) => world,
            Err(ProjectionError::MissesSurface) => bail!(
                "the plane's horizon is in view of the photograph, its border at ({}, {}) does not meet the plane: \
                 the plane file needs a `rectangle`",
                Brief(p.x),
                Brief(p.y)
            ),
            Err(e) => bail!(
                "the photograph's border at ({}, {}) has no place on the plane, the plane file needs a `rectangle`: {e}",
                Brief(p.x),
                Brief(p.y)
            ),
        };
        let [right, up] =
            plane.plane_from_world(&world.into()).map_err(collinear_io::Error::from)?;
        found.left = found.left.min(right);
        found.right = found.right.max(right);
        found.bottom = found.bottom.min(up);
        found.top = found.top.max(up);
    }
    let Rectangle { left, bottom, right, top } = found;
    ensure!(
        right > left && top > bottom,
        "what the photograph shows of the plane has no width or no height in numbers of 64 bits: \
         the plane file needs a `rectangle`"
    );
    Ok(found)
}

/// The corners of the pixels along a picture's border.
pub(crate) fn border(camera: &CameraFile) -> impl Iterator<Item = Point2<f64>> {
    let (width, height) = (camera.width, camera.height);
    let (w, h) = (f64::from(width), f64::from(height));
    let across = (0..=width).map(f64::from).flat_map(move |x| [[x, 0.0], [x, h]]);
    let down = (1..height).map(f64::from).flat_map(move |y| [[0.0, y], [w, y]]);
    across.chain(down).map(Point2::from)
}

/// The size of a picture of a rectangle at so many units a pixel, and the rectangle grown to the right and downwards to whole
/// pixels.
///
/// # Errors
/// A size that [`check_size`] refuses.
pub fn size_at(rectangle: &Rectangle, units_per_pixel: f64) -> Result<(Rectangle, u32, u32)> {
    let Rectangle { left, bottom, right, top } = *rectangle;
    let pixels = |length: f64| (length / units_per_pixel - PART_OF_PIXEL).ceil().max(1.0);
    let (w, h) = (pixels(right - left), pixels(top - bottom));
    let largest = f64::from(crate::LARGEST_SIDE);
    ensure!(
        w <= largest && h <= largest,
        "at {} units a pixel the rectangle has {} × {} pixels: a side must be from 1 to {largest}",
        Brief(units_per_pixel),
        Brief(w),
        Brief(h)
    );
    let (width, height) = (w as u32, h as u32);
    check_size(width, height)?;
    let grown = Rectangle {
        left,
        top,
        right: left + w * units_per_pixel,
        bottom: top - h * units_per_pixel,
    };
    Ok((grown, width, height))
}
