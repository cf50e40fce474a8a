//! Interior orientation: from a direction to the picture's pixels, without lens errors.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Point3, Vector3};

use super::{Adjustable, CentralModel, Panorama, ParameterGroup, collinearity, no_group};
use crate::error::{Error, ProjectionError};
use crate::geometry::Affine2;

/// Interior orientation: principal distance, principal point and the picture's axes, in pixels.
///
/// # Model
/// ```text
/// x = fx · X/Z + s · Y/Z + x₀
/// y = t · X/Z + fy · Y/Z + y₀
/// ```
/// (X, Y, Z) is a direction in camera axes (x right, y down, z forward). A digital camera has t = 0; a scanned film
/// whose fiducial axes are turned against the scanner's has not. By itself this is the ideal pinhole camera, a
/// [`CentralModel`]; [`BrownCamera`](super::BrownCamera) puts a lens before it.
///
/// # Frames and units
/// Pixels from the top-left corner of the top-left pixel. OpenCV, whose integer coordinates are pixel centres, has
/// cx = x₀ − ½: see [`from_opencv`](Self::from_opencv).
///
/// # Domain
/// Z > 0, else [`ProjectionError::BehindCamera`].
///
/// # Example
/// A photogrammetric camera, c = 153.24 mm, scanned at 20 µm a pixel, the fiducial centre at pixel (5700, 5700):
///
/// ```
/// use collinear::camera::{CentralModel, InteriorOrientation};
/// use collinear::geometry::Affine2;
/// use nalgebra::{Point2, Vector3};
///
/// let pixel_from_mm = Affine2::from_coefficients([5700.0, 50.0, 0.0], [5700.0, 0.0, -50.0]);
/// let interior = InteriorOrientation::from_photogrammetric(153.24, Point2::new(0.0, 0.0), &pixel_from_mm)?;
/// // A ray that leaves the photo's centre at 45° to the right: x = 153.24 mm, 7662 pixels.
/// let p = interior.project_direction(&Vector3::new(1.0, 0.0, 1.0))?;
/// assert!((p - Point2::new(13362.0, 5700.0)).norm() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("intrinsics", "K", "calibration matrix", "Pinhole"))]
pub struct InteriorOrientation {
    axes: Matrix2<f64>,
    inverse_axes: Matrix2<f64>,
    principal_point: Point2<f64>,
}

/// The group of (fx, fy, x₀, y₀, s).
pub(super) const INTERIOR: ParameterGroup = ParameterGroup { name: "interior orientation", len: 5 };

impl InteriorOrientation {
    /// From principal distances along x and y, principal point and skew, in pixels.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a principal distance that is not positive.
    #[doc(alias("fx", "fy", "cx", "cy", "focal length"))]
    pub fn new(
        principal_distance: [f64; 2],
        principal_point: Point2<f64>,
        skew: f64,
    ) -> Result<Self, Error> {
        let [fx, fy] = principal_distance;
        for value in principal_distance {
            if value <= 0.0 {
                return Err(Error::OutOfRange {
                    what: "principal distance",
                    value,
                    expected: "more than 0",
                });
            }
        }
        Self::from_axes(Matrix2::new(fx, skew, 0.0, fy), principal_point)
    }

    /// From the 3×3 calibration matrix K of computer vision, whose third row is (0, 0, 1), in this crate's pixel
    /// coordinates.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`Error::OutOfRange`] for another third row.
    pub fn from_matrix(k: &Matrix3<f64>) -> Result<Self, Error> {
        for (value, expected) in [(k.m31, 0.0), (k.m32, 0.0), (k.m33, 1.0)] {
            if value != expected {
                return Err(Error::OutOfRange {
                    what: "third row of K",
                    value,
                    expected: "(0, 0, 1)",
                });
            }
        }
        if k.m21 != 0.0 {
            return Err(Error::OutOfRange {
                what: "second row of K",
                value: k.m21,
                expected: "(0, fy, y₀)",
            });
        }
        Self::new([k.m11, k.m22], Point2::new(k.m13, k.m23), k.m12)
    }

    /// From OpenCV's fx, fy, cx, cy, where the centre of the first pixel is (0, 0): x₀ = cx + ½, y₀ = cy + ½.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_opencv(fx: f64, fy: f64, cx: f64, cy: f64) -> Result<Self, Error> {
        Self::new([fx, fy], Point2::new(cx + 0.5, cy + 0.5), 0.0)
    }

    /// Of a whole equirectangular panorama of w × h pixels: fx = w/2π, fy = h/π, the principal point in the middle.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_whole_panorama(width: f64, height: f64) -> Result<Self, Error> {
        let distance = Panorama::Equirectangular.principal_distance(width, height);
        Self::new(distance, Point2::new(0.5 * width, 0.5 * height), 0.0)
    }

    /// Of a dome master: the equidistant fisheye picture, `size` × `size` pixels, whose circle fills it and holds a field of view given in
    /// radians, π for a hemisphere. With [`Fisheye::Equidistant`](super::Fisheye::Equidistant).
    ///
    /// ```text
    /// c = size/field,   principal point (size/2, size/2)
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Example
    /// ```
    /// use collinear::camera::{CentralCamera, CentralModel, Fisheye, InteriorOrientation};
    /// use nalgebra::{Point2, Vector3};
    ///
    /// let interior = InteriorOrientation::from_dome_master(4096.0, std::f64::consts::PI)?;
    /// let master = CentralCamera::ideal(interior, Fisheye::Equidistant);
    /// // The rim to the right of the axis.
    /// let rim = master.project_direction(&Vector3::x())?;
    /// assert!((rim - Point2::new(4096.0, 2048.0)).norm() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias("fulldome", "domemaster", "angular fisheye"))]
    pub fn from_dome_master(size: f64, field_of_view: f64) -> Result<Self, Error> {
        Self::new([size / field_of_view; 2], Point2::new(0.5 * size, 0.5 * size), 0.0)
    }

    /// From Agisoft Metashape's f, cx, cy, b₁ and b₂ in pixels and the picture's size.
    ///
    /// ```text
    /// u = w/2 + cx + x′ (f + b₁) + y′ b₂,   v = h/2 + cy + y′ f
    /// ```
    /// (Agisoft, Metashape user manual, appendix *Camera models*; u, v from the picture's top-left corner.)
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_metashape(
        size: [f64; 2],
        f: f64,
        [cx, cy]: [f64; 2],
        [b1, b2]: [f64; 2],
    ) -> Result<Self, Error> {
        let principal = Point2::new(0.5 * size[0] + cx, 0.5 * size[1] + cy);
        Self::new([f + b1, f], principal, b2)
    }

    /// From a photogrammetric calibration: principal distance c > 0 and principal point in millimetres in the photo
    /// system (x right, y up), and the affine map from photo millimetres to pixels that the fiducial marks give.
    ///
    /// ```text
    /// photo = (x₀, y₀) + c · (X/Z, −Y/Z)        pixel = A · photo + b
    /// ```
    ///
    /// Any affine map is taken, a film turned or mirrored on the scanner too. With the identity the "pixels" are photo
    /// millimetres, y up.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_photogrammetric(
        c_mm: f64,
        principal_point_mm: Point2<f64>,
        pixel_from_mm: &Affine2,
    ) -> Result<Self, Error> {
        if !(c_mm > 0.0 && c_mm.is_finite()) {
            return Err(Error::OutOfRange {
                what: "principal distance",
                value: c_mm,
                expected: "c > 0",
            });
        }
        let axes = pixel_from_mm.linear * Matrix2::new(c_mm, 0.0, 0.0, -c_mm);
        Self::from_axes(axes, pixel_from_mm.apply(&principal_point_mm))
    }

    fn from_axes(axes: Matrix2<f64>, principal_point: Point2<f64>) -> Result<Self, Error> {
        if !axes.iter().chain(principal_point.coords.iter()).all(|v| v.is_finite()) {
            return Err(Error::NotFinite { what: "interior orientation" });
        }
        let inverse =
            Affine2 { linear: axes, translation: nalgebra::Vector2::zeros() }.inverse()?;
        Ok(Self { axes, inverse_axes: inverse.linear, principal_point })
    }

    /// Principal distances (fx, fy) in pixels.
    #[must_use]
    pub fn principal_distance(&self) -> [f64; 2] {
        [self.axes.m11, self.axes.m22]
    }

    /// The image of the optical axis, in pixels.
    #[must_use]
    pub fn principal_point(&self) -> Point2<f64> {
        self.principal_point
    }

    /// s, in pixels.
    #[must_use]
    pub fn skew(&self) -> f64 {
        self.axes.m12
    }

    /// The calibration matrix K.
    #[must_use]
    pub fn matrix(&self) -> Matrix3<f64> {
        let (a, p) = (&self.axes, &self.principal_point);
        Matrix3::new(a.m11, a.m12, p.x, a.m21, a.m22, p.y, 0.0, 0.0, 1.0)
    }

    /// K⁻¹: (x, y, 1) to the direction (X/Z, Y/Z, 1).
    #[must_use]
    pub fn inverse_matrix(&self) -> Matrix3<f64> {
        let a = &self.inverse_axes;
        let t = -(a * self.principal_point.coords);
        Matrix3::new(a.m11, a.m12, t.x, a.m21, a.m22, t.y, 0.0, 0.0, 1.0)
    }

    /// Pixel of the normalised image point (X/Z, Y/Z).
    #[inline]
    #[must_use]
    pub fn pixel_from_normalised(&self, normalised: &Point2<f64>) -> Point2<f64> {
        self.principal_point + self.axes * normalised.coords
    }

    /// Normalised image point (X/Z, Y/Z) of a pixel.
    #[inline]
    #[must_use]
    pub fn normalised_from_pixel(&self, pixel: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.inverse_axes * (pixel - self.principal_point))
    }

    /// A Jacobian of normalised points as one of pixels: A J A⁻¹.
    pub(crate) fn conjugate(&self, normalised: &Matrix2<f64>) -> Matrix2<f64> {
        self.axes * normalised * self.inverse_axes
    }

    /// ∂pixel/∂normalised.
    #[inline]
    pub(super) fn axes(&self) -> Matrix2<f64> {
        self.axes
    }

    /// Writes ∂(x, y)/∂(fx, fy, x₀, y₀, s) at a normalised point, two rows of five.
    #[inline]
    pub(super) fn write_partials(normalised: &Point2<f64>, out: &mut [f64]) {
        let rows = [normalised.x, 0.0, 1.0, 0.0, normalised.y, 0.0, normalised.y, 0.0, 1.0, 0.0];
        for (o, v) in out.iter_mut().zip(rows) {
            *o = v;
        }
    }

    /// This orientation with (fx, fy, x₀, y₀, s) moved by a step.
    pub(super) fn moved(&self, step: &[f64]) -> Result<Self, Error> {
        let &[fx, fy, x0, y0, s] = step else {
            return Err(Error::LengthMismatch {
                what: "parameter group and step",
                left: INTERIOR.len,
                right: step.len(),
            });
        };
        let axes = self.axes + Matrix2::new(fx, s, 0.0, fy);
        // A step must not turn the picture over.
        for (value, old) in [(axes.m11, self.axes.m11), (axes.m22, self.axes.m22)] {
            if value * old < 0.0 {
                return Err(Error::OutOfRange {
                    what: "principal distance",
                    value,
                    expected: "the sign it had",
                });
            }
        }
        Self::from_axes(axes, self.principal_point + nalgebra::Vector2::new(x0, y0))
    }

    /// (fx, fy, x₀, y₀, s).
    pub(super) fn values(&self) -> [f64; 5] {
        let (a, p) = (&self.axes, &self.principal_point);
        [a.m11, a.m22, p.x, p.y, a.m12]
    }
}

impl CentralModel for InteriorOrientation {
    #[inline]
    fn project_direction(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        let n = collinearity::normalised_point(direction)?;
        collinearity::finite(self.pixel_from_normalised(&n))
    }

    #[inline]
    fn project_direction_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let n = collinearity::normalised_point(direction)?;
        let p = collinearity::finite(self.pixel_from_normalised(&n))?;
        Ok((p, self.axes * collinearity::normalised_jacobian(&n, direction.z)))
    }

    #[inline]
    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        let n = collinearity::finite(self.normalised_from_pixel(image))?;
        Ok(collinearity::unit_direction(&n))
    }
}

impl Adjustable for InteriorOrientation {
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup> {
        (group == 0).then_some(INTERIOR)
    }

    fn parameters(&self, group: usize, values: &mut [f64]) {
        if group > 0 {
            return;
        }
        for (v, p) in values.iter_mut().zip(self.values()) {
            *v = p;
        }
    }

    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error> {
        if group > 0 {
            return Err(no_group(group));
        }
        *self = self.moved(step)?;
        Ok(())
    }

    #[inline]
    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let (image, jacobian) = self.project_direction_jacobian(&object.coords)?;
        collinearity::write_rows(&jacobian, by_object);
        if let Some(out) = by_group.first_mut().filter(|out| !out.is_empty()) {
            Self::write_partials(&collinearity::normalised_point(&object.coords)?, out);
        }
        Ok(image)
    }
}
