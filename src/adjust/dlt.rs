//! The direct linear transformation: a camera without initial values from points in space.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Matrix3x4, Point2, Point3, Vector2, Vector3};

use crate::camera::{Frame, InteriorOrientation, SensorModel};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::triangular::Triangular;

/// A camera found by [`dlt`].
#[derive(Clone, Debug)]
pub struct DltCamera {
    /// The camera: exterior orientation and (fx, fy, x₀, y₀, s).
    pub frame: Frame<InteriorOrientation>,
    /// Image point minus projected object point, in pixels.
    pub residuals: Vec<Vector2<f64>>,
    /// √(Σ v² / (2n − 11)), in pixels. It exceeds that of a least-squares adjustment, which makes the residuals themselves least.
    pub sigma0: f64,
    /// The eleventh singular value of the linear equations over the first, in the normalised frames: near one for points well
    /// spread in space, zero where they do not determine the camera.
    pub condition: f64,
}

impl DltCamera {
    /// The eleven coefficients L₁ to L₁₁ of Abdel-Aziz & Karara for object coordinates counted from `origin`:
    ///
    /// ```text
    /// x = (L₁ X + L₂ Y + L₃ Z + L₄) / (L₉ X + L₁₀ Y + L₁₁ Z + 1)
    /// y = (L₅ X + L₆ Y + L₇ Z + L₈) / (L₉ X + L₁₀ Y + L₁₁ Z + 1)
    /// ```
    ///
    /// `None` where the origin lies in the camera's focal plane, so that no such coefficients exist.
    #[must_use]
    pub fn coefficients(&self, origin: &Point3<f64>) -> Option<[f64; 11]> {
        let m = self.frame.camera.matrix() * self.frame.exterior.camera_from_world().matrix();
        let last = m * (origin - self.frame.exterior.projection_center());
        let mut l = [0.0; 11];
        for i in 0..3 {
            for j in 0..3 {
                l[4 * i + j] = m[(i, j)] / last.z;
            }
            if i < 2 {
                l[4 * i + 3] = last[i] / last.z;
            }
        }
        l.iter().all(|c| c.is_finite()).then_some(l)
    }
}

/// The camera that n ≥ 6 points in space and their images determine, by linear equations.
///
/// *Model.* With every factor free the projection is linear in homogeneous coordinates (Abdel-Aziz & Karara 1971, Direct linear
/// transformation from comparator coordinates into object space coordinates):
///
/// ```text
/// (x w, y w, w)ᵀ = P (X, Y, Z, 1)ᵀ       P = K R (I | −C)        eleven ratios
/// minimise Σ ‖w (x, y)ᵀ − P₁₂ (X, Y, Z, 1)ᵀ‖²      over ‖P‖ = 1, in normalised coordinates (Hartley 1997)
/// ```
///
/// The object is brought to its principal axes with unit variance along each, the image centred and scaled, so that map coordinates
/// of 10⁶ and flat objects are as good as any. P is the singular vector of the smallest singular value; a camera is taken out of
/// it by [`Frame::from_projection_matrix`]. Exact data give the exact camera; with noise the result is a start for an adjustment, since not
/// the residuals in the image but their products with the depth are made least.
///
/// Two dimensions, the DLT of eight parameters, are
/// [`Homography::fit`](crate::geometry::Homography::fit) and
/// [`pose_from_plane`](crate::geometry::homography::decompose::pose_from_plane).
///
/// # Errors
/// [`Error::LengthMismatch`], [`Error::TooFewPoints`], [`Error::NotFinite`]; [`Error::Degenerate`] where the object points lie in a
/// plane (the measure is their extent across it over the largest), where image points coincide, or where points and centre
/// leave the camera open, as on a twisted cubic or where all but one lie in a plane
/// (the measure is [`DltCamera::condition`]); [`Error::OutOfRange`] for a picture that is mirrored;
/// [`Error::Projection`] where points end up on both sides of the camera.
///
/// # Example
/// The corners of a cube of side 2 seen from (0, 0, −10) along z, fx = 900, fy = 1000, x₀ = 500, y₀ = 400: the corner (1, 1, −1)
/// is at depth 9, 100 right of the principal point.
/// ```
/// use collinear::adjust::dlt;
/// use collinear::nalgebra::{Point2, Point3};
///
/// let sides = [-1.0, 1.0];
/// let cube: Vec<_> = (0..8).map(|i| Point3::new(sides[i & 1], sides[i >> 1 & 1], sides[i >> 2])).collect();
/// let image: Vec<_> = cube.iter().map(|p| {
///     Point2::new(500.0 + 900.0 * p.x / (p.z + 10.0), 400.0 + 1000.0 * p.y / (p.z + 10.0))
/// }).collect();
/// let found = dlt(&cube, &image)?;
/// let interior = found.frame.camera;
/// assert!((interior.principal_distance()[0] - 900.0).abs() < 1e-9);
/// assert!((interior.principal_point() - Point2::new(500.0, 400.0)).norm() < 1e-9);
/// let center = found.frame.exterior.projection_center();
/// assert!((center - Point3::new(0.0, 0.0, -10.0)).norm() < 1e-11);
/// // x = (90 X + 50 Z + 500) / (0.1 Z + 1)
/// let l = found.coefficients(&Point3::origin()).ok_or("no coefficients")?;
/// assert!((l[0] - 90.0).abs() < 1e-10 && (l[2] - 50.0).abs() < 1e-10 && (l[10] - 0.1).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("DLT", "direct linear transformation", "calibrateCamera", "resectioning"))]
pub fn dlt(object: &[Point3<f64>], image: &[Point2<f64>]) -> Result<DltCamera, Error> {
    let n = object.len();
    if n != image.len() {
        let what = "object and image points";
        return Err(Error::LengthMismatch { what, left: n, right: image.len() });
    }
    if n < 6 {
        return Err(Error::TooFewPoints { needed: 6, got: n });
    }
    let space = Principal::new(object)?;
    let (mean, pixel, rounding) = image_scale(image)?;
    let mut triangle = Triangular::<12>::new();
    for (point, seen) in object.iter().zip(image) {
        let s = space.apply(point).push(1.0);
        let t = (seen - mean) / pixel;
        for axis in 0..2 {
            let mut row = [0.0; 12];
            for k in 0..4 {
                row[4 * axis + k] = s[k];
                row[8 + k] = -t[axis] * s[k];
            }
            triangle.add_row(row);
        }
    }
    let (values, vectors) = triangle.singular();
    let condition = values[10] / values[0];
    let limit = 64.0 * (f64::EPSILON + space.rounding + rounding);
    if !(condition > limit) {
        let what = "points that leave the camera open";
        return Err(Error::Degenerate { what, measure: condition, limit });
    }
    let p = vectors.column(11);
    let normalised = Matrix3x4::from_fn(|i, j| p[4 * i + j]);
    let back = Matrix3::new(pixel, 0.0, mean.x, 0.0, pixel, mean.y, 0.0, 0.0, 1.0);
    let mut matrix = back * normalised;
    let linear = matrix.fixed_columns::<3>(0) * space.matrix;
    matrix.fixed_columns_mut::<3>(0).copy_from(&linear);
    let frame = Frame::from_projection_matrix(&matrix, &space.mean)?;
    let depth = |x: &Point3<f64>| frame.exterior.pose().apply(x).z;
    if object.iter().all(|x| depth(x) < 0.0) {
        let what = "determinant of the camera before which the points lie";
        let value = -linear.determinant().abs();
        return Err(Error::OutOfRange { what, value, expected: "a picture that is not mirrored" });
    }
    let residuals = object
        .iter()
        .zip(image)
        .map(|(x, seen)| Ok(seen - frame.project(x)?))
        .collect::<Result<Vec<_>, ProjectionError>>()?;
    let sum: f64 = residuals.iter().map(Vector2::norm_squared).sum();
    Ok(DltCamera { frame, residuals, sigma0: float::sqrt(sum / (2 * n - 11) as f64), condition })
}

/// Points about their centroid, along their principal axes, with unit variance along each: X ↦ A (X − m).
struct Principal {
    mean: Point3<f64>,
    matrix: Matrix3<f64>,
    /// ε times the largest coordinate over the smallest spread.
    rounding: f64,
}

impl Principal {
    fn new(points: &[Point3<f64>]) -> Result<Self, Error> {
        let n = points.len() as f64;
        let first = points[0];
        let mean = first + points.iter().fold(Vector3::zeros(), |s, p| s + (p - first) / n);
        let extent = points.iter().map(|p| (p - mean).amax()).fold(0.0, f64::max);
        let finite = points.iter().all(|p| p.iter().all(|c| c.is_finite()));
        if !(finite && extent.is_finite() && mean.coords.amax().is_finite()) {
            return Err(Error::NotFinite { what: "object point" });
        }
        let what = "object points in a plane";
        if extent == 0.0 {
            return Err(Error::Degenerate { what, measure: 0.0, limit: 4.0 * f64::EPSILON });
        }
        let mut triangle = Triangular::<3>::new();
        for p in points {
            triangle.add_row(((p - mean) / extent).into());
        }
        let (spread, axes) = triangle.singular();
        let largest = (mean.coords.amax() + extent) / extent;
        let measure = spread[2] / spread[0];
        let limit = f64::EPSILON * (4.0 + 2.0 * largest * float::sqrt(n) / spread[0]);
        if !(measure > limit) {
            return Err(Error::Degenerate { what, measure, limit });
        }
        let scale = spread.map(|s| float::sqrt(n) / (s * extent));
        Ok(Self {
            mean,
            matrix: Matrix3::from_diagonal(&scale) * axes.transpose(),
            rounding: f64::EPSILON * largest * float::sqrt(n) / spread[2],
        })
    }

    fn apply(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.matrix * (p - self.mean)
    }
}

/// Centroid, root mean square distance along an axis, and what rounding does to coordinates so scaled.
fn image_scale(image: &[Point2<f64>]) -> Result<(Point2<f64>, f64, f64), Error> {
    let n = image.len() as f64;
    let first = image[0];
    let mean = first + image.iter().fold(Vector2::zeros(), |s, p| s + (p - first) / n);
    let extent = image.iter().map(|p| (p - mean).amax()).fold(0.0, f64::max);
    let finite = image.iter().all(|p| p.iter().all(|c| c.is_finite()));
    if !(finite && extent.is_finite() && mean.coords.amax().is_finite()) {
        return Err(Error::NotFinite { what: "image point" });
    }
    let largest = mean.coords.amax() + extent;
    let limit = 8.0 * f64::EPSILON * largest;
    if !(extent > limit) {
        let what = "image points that coincide";
        return Err(Error::Degenerate { what, measure: extent, limit });
    }
    let squares: f64 = image.iter().map(|p| ((p - mean) / extent).norm_squared()).sum();
    let pixel = extent * float::sqrt(squares / (2.0 * n));
    Ok((mean, pixel, f64::EPSILON * largest / pixel))
}
