//! A plane of the world seen face-on, from a photograph.

use anyhow::{Result, bail, ensure};
use collinear::ProjectionError;
use collinear::camera::{ExteriorOrientation, HomogeneousCamera, Orthographic};
use collinear::error::Brief;
use collinear::geometry::{Affine2, Homography};
use collinear::mapping::Map;
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, RowVector3};
use collinear::resample::{Border, Filter};
use collinear_io::convert::Camera;
use collinear_io::picture::Picture;
use collinear_io::plane::{PlaneFile, Rectangle};
use collinear_io::sensor::SensorFile;

use crate::lookup::{Drawn, Lookup};
use crate::photograph::{Photograph, PlaneMap};
use crate::picture::check_size;

/// A rectangle's size may exceed a whole number of pixels by this much of one before another pixel is added.
const PART_OF_PIXEL: f64 = 1e-6;

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
        camera: &SensorFile,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        check_size(width, height)?;
        let screen = face_on(plane, rectangle, width, height)?;
        let photograph = Photograph::new(camera)?;
        let map = PlaneMap::new(&plane.plane()?, &photograph, &screen)?;
        Ok(Self {
            width,
            height,
            homography: map.homography()?,
            through_lens: map.through_lens(),
            map: map.boxed(),
            mirrored: is_behind(&photograph, camera.size(), plane)?,
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
        camera: Option<&SensorFile>,
        width: u32,
        height: u32,
    ) -> Result<Self> {
        check_size(width, height)?;
        let photograph = match camera {
            None => None,
            Some(SensorFile::Camera(camera)) => Some(camera.camera()?),
            Some(SensorFile::Scanner(_) | SensorFile::Rpc(_)) => bail!(
                "the sensor has no lens that corners could go through: leave --camera out, or give a --plane"
            ),
        };
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

    /// Draws the rectified picture, as [`Lookup::draw`].
    ///
    /// # Errors
    /// As [`Lookup::draw`].
    pub fn apply(
        &self,
        photograph: &Picture,
        filter: Filter,
        border: Border,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Drawn> {
        let lookup = Lookup { width: self.width, height: self.height, map: self.map.as_ref() };
        lookup.draw(photograph, filter, border, progress)
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

/// Whether a sensor sees a plane from behind: by where it is, in a parallel projection by where it looks.
fn is_behind(photograph: &Photograph, size: [u32; 2], plane: &PlaneFile) -> Result<bool> {
    let plane = plane.plane()?;
    let line_of_sight = photograph.middle(size);
    Ok(match photograph.camera() {
        Some(Camera::Orthographic(_)) => {
            line_of_sight.is_some_and(|ray| ray.direction.dot(&plane.normal()) > 0.0)
        }
        _ => photograph.eye(size).is_some_and(|eye| plane.signed_distance(&eye) < 0.0),
    })
}

/// The rectangle of a plane that a photograph shows: the box about its border, traced pixel by pixel to the plane.
///
/// # Errors
/// A camera that lies in the plane. A border that does not meet the plane, since its horizon is in view: state a rectangle
/// then.
pub fn footprint(plane: &PlaneFile, camera: &SensorFile) -> Result<Rectangle> {
    let photograph = Photograph::new(camera)?;
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
    for p in border(camera.size()) {
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
pub(crate) fn border([width, height]: [u32; 2]) -> impl Iterator<Item = Point2<f64>> {
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
