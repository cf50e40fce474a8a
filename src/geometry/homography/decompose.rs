//! What a homography says about the cameras that made it.
//!
//! A calibrated picture of a plane gives the camera's pose ([`pose_from_plane`]). Two calibrated pictures of one plane
//! give the motion between them in up to four ways ([`decompose`]), of which [`visible`] keeps those that show the plane
//! to the first camera.
//!
//! The calibration K takes directions in camera axes (x right, y down, z forward) to pixels:
//!
//! ```text
//!     ⎛ fx  s   cx ⎞
//! K = ⎜ 0   fy  cy ⎟ ,   fx, fy > 0
//!     ⎝ 0   0   1  ⎠
//! ```

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point2, Rotation3, Unit, UnitVector3, Vector3};

use super::Homography;
use crate::error::Error;
use crate::geometry::Pose;
use crate::geometry::rotation::orthonormalised;
use crate::numeric::float;
use crate::numeric::triangular::Triangular;

/// The pose found from one picture of a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePose {
    /// `camera_from_plane`: the plane is z = 0 of its own frame, whose z axis completes the plane's x and y to a right-handed
    /// system.
    pub pose: Pose,
    /// How far the picture's two axes are from orthogonal and equally long: (σ₁ − σ₂)/(σ₁ + σ₂) of the first two columns
    /// of K⁻¹H. Zero for exact data and the right calibration.
    pub residual: f64,
}

/// A motion between two cameras that see one plane.
///
/// ```text
/// X₂ = R X₁ + t,   n·X₁ = d,   d > 0:      X₂ = (R + (t/d) nᵀ) X₁
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneMotion {
    /// R, `second_from_first`.
    pub rotation: Rotation3<f64>,
    /// t/d: the translation in units of the first camera's distance from the plane.
    pub translation: Vector3<f64>,
    /// n, from the first camera towards the plane; `None` for a pure rotation, which says nothing about the plane.
    pub normal: Option<UnitVector3<f64>>,
}

/// A translation below this fraction of the plane's distance counts as none.
const ROTATION: f64 = 1e-10;

/// Below this sine between translation and normal the two pairs of solutions are one: they part as its square root.
const ALONG_NORMAL: f64 = 1e-7;

/// The pose of a camera from the picture of a plane with known coordinates.
///
/// ```text
/// K⁻¹ H ∝ ( r₁  r₂  t )
/// ```
///
/// (r₁, r₂) are the orthonormal columns nearest to those given. The orientation of H tells which side of the camera the
/// plane is on: points with w > 0 lie in front. A homography fitted to points is oriented; with a matrix of unknown sign
/// make sure that `w` is positive at a visible point.
///
/// *Frames and units.* `image_from_plane` maps plane coordinates (world units) to pixels; the pose's origin is the
/// projection centre in the plane's frame.
///
/// *Accuracy.* The algebraic solution, exact for exact data; with noise it is a start for an adjustment.
///
/// # Errors
/// [`Error::OutOfRange`] or [`Error::NotFinite`] for a K of another form, [`Error::Degenerate`] where K⁻¹H has lost its
/// regularity, [`Error::Inconsistent`] where so few digits are left that no rotation is near.
///
/// # Example
/// ```
/// use collinear::geometry::Homography;
/// use collinear::geometry::homography::decompose::pose_from_plane;
/// use nalgebra::{Matrix3, Point3};
///
/// // A camera 10 above a floor looking straight down: x to the right, y up the picture; 100 px per unit at depth 1.
/// let k = Matrix3::new(100.0, 0.0, 320.0, 0.0, 100.0, 240.0, 0.0, 0.0, 1.0);
/// let h = Homography::from_matrix(Matrix3::new(10.0, 0.0, 320.0, 0.0, -10.0, 240.0, 0.0, 0.0, 1.0))?;
/// let found = pose_from_plane(&h, &k)?;
/// assert!((found.pose.origin - Point3::new(0.0, 0.0, 10.0)).norm() < 1e-14);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("planar PnP", "IPPE"))]
pub fn pose_from_plane(
    image_from_plane: &Homography,
    calibration: &Matrix3<f64>,
) -> Result<PlanePose, Error> {
    let m = inverse_calibration(calibration)? * image_from_plane.matrix();
    let m = m / m.amax();
    let (a, b) = (m.column(0).into_owned(), m.column(1).into_owned());
    // Polar decomposition of the 3×2 matrix (a b) = Q P: P² is its Gram matrix, det P = |a × b|, tr P = σ₁ + σ₂.
    let (aa, ab, bb) = (a.norm_squared(), a.dot(&b), b.norm_squared());
    let area = a.cross(&b).norm();
    let sum = float::sqrt(aa + bb + 2.0 * area);
    let measure = area / (aa + bb);
    let limit = 4.0 * f64::EPSILON;
    if measure.is_nan() || measure <= limit {
        let measure = if measure.is_finite() { measure } else { 0.0 };
        return Err(Error::Degenerate { what: "picture of a plane", measure, limit });
    }
    let (paa, pab, pbb) = ((aa + area) / sum, ab / sum, (bb + area) / sum);
    let r1 = (a * pbb - b * pab) / area;
    let r2 = (b * paa - a * pab) / area;
    let rotation = Matrix3::from_columns(&[r1, r2, r1.cross(&r2)]);
    let difference = float::hypot(aa - bb, 2.0 * ab);
    Ok(PlanePose {
        pose: Pose::from_rotation_translation(
            orthonormalised(&rotation)?,
            m.column(2) / (0.5 * sum),
        ),
        residual: difference / (sum * sum),
    })
}

/// The motions between two cameras from the homography that a plane induces between their pictures.
///
/// ```text
/// K₂⁻¹ H K₁ ∝ R + (t/d) nᵀ
/// ```
///
/// *Model.* Singular values σ₁ ≥ σ₂ ≥ σ₃, the second of which is the unknown factor; the two planes whose vectors keep
/// their length; a rotation for each, and both signs of t and n: Ma, Soatto, Košecká & Sastry (2004), An Invitation to 3-D
/// Vision, §5.3; first by Faugeras & Lustman (1988).
///
/// Four motions in general, two where t is parallel to n (to 1e-7), one with t = 0 where the singular values agree to
/// 1e-10. The orientation of H is used: points in front of its horizon are in front of both cameras, so that no motion
/// with a plane behind one of them is among the four but for the sign of n, which [`visible`] settles. det H may be
/// negative: the cameras then stand on different sides of the plane.
///
/// # Errors
/// [`Error::OutOfRange`] or [`Error::NotFinite`] for a K of another form; [`Error::Degenerate`] where the matrix is singular
/// to rounding or a reflection, with σ₃/σ₁ as the measure; [`Error::Inconsistent`] where so few digits are left that no
/// rotation is near.
///
/// # Example
/// ```
/// use collinear::geometry::Homography;
/// use collinear::geometry::homography::decompose::{decompose, visible};
/// use nalgebra::{Matrix3, Point2};
///
/// // A camera that moves half the way to a wall it faces: I + t nᵀ/d with t = (0, 0, −½), n = (0, 0, 1).
/// let h = Homography::from_matrix(Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5))?;
/// let k = Matrix3::identity();
/// let motions = visible(&decompose(&h, &k, &k)?, &[Point2::origin()], &k)?;
/// assert_eq!(motions.len(), 1);
/// assert!((motions[0].translation.z + 0.5).abs() < 1e-15);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("decomposeHomographyMat"))]
pub fn decompose(
    second_from_first: &Homography,
    first: &Matrix3<f64>,
    second: &Matrix3<f64>,
) -> Result<Vec<PlaneMotion>, Error> {
    inverse_calibration(first)?;
    let g = inverse_calibration(second)? * second_from_first.matrix() * first;
    let g = g / g.amax();
    let mut rows = Triangular::<3>::new();
    for i in 0..3 {
        rows.add_row([g[(i, 0)], g[(i, 1)], g[(i, 2)]]);
    }
    let (sigma, v) = rows.singular();
    let measure = if sigma[0] > 0.0 { sigma[2] / sigma[0] } else { 0.0 };
    let limit = 8.0 * f64::EPSILON;
    let degenerate = Error::Degenerate { what: "homography of a plane", measure, limit };
    if measure.is_nan() || measure <= limit {
        return Err(degenerate);
    }
    let a = g / sigma[1];
    let [s1, s3] = [sigma[0] / sigma[1], sigma[2] / sigma[1]];
    if s1 - s3 <= ROTATION {
        if a.determinant() < 0.0 {
            return Err(degenerate);
        }
        let scaled = Matrix3::from_fn(|i, j| v[(i, j)] * sigma[1] / sigma[j]);
        let rotation = orthonormalised(&(a * scaled * v.transpose()))?;
        return Ok(alloc::vec![PlaneMotion {
            rotation,
            translation: Vector3::zeros(),
            normal: None
        }]);
    }
    let spread = float::sqrt((s1 - s3) * (s1 + s3));
    let mut along1 = float::sqrt(((1.0 - s3) * (1.0 + s3)).max(0.0)) / spread;
    let mut along3 = float::sqrt(((s1 - 1.0) * (s1 + 1.0)).max(0.0)) / spread;
    let signs: &[f64] = if along1.min(along3) > ALONG_NORMAL {
        &[1.0, -1.0]
    } else {
        (along1, along3) = if along1 > along3 { (1.0, 0.0) } else { (0.0, 1.0) };
        &[1.0]
    };
    let [v1, v2, v3]: [Vector3<f64>; 3] = [0, 1, 2].map(|j| v.column(j).into_owned());
    let mut motions = Vec::with_capacity(4);
    for sign in signs {
        // v₂ and u span a plane in which A only turns: the plane itself, seen from the first camera.
        let u = v1 * along1 + v3 * (along3 * sign);
        let (n, v2_turned, u_turned) = (v2.cross(&u), a * v2, a * u);
        let from = Matrix3::from_columns(&[v2, u, n]);
        let to = Matrix3::from_columns(&[v2_turned, u_turned, v2_turned.cross(&u_turned)]);
        let rotation = orthonormalised(&(to * from.transpose()))?;
        let translation = a * n - rotation * n;
        for side in [1.0, -1.0] {
            motions.push(PlaneMotion {
                rotation,
                translation: translation * side,
                normal: Some(Unit::new_unchecked(n * side)),
            });
        }
    }
    Ok(motions)
}

/// The motions whose plane lies in front of the first camera at every one of its image points (pixels).
///
/// # Errors
/// [`Error::OutOfRange`] or [`Error::NotFinite`] for a K of another form.
#[doc(alias("filterHomographyDecompByVisibleRefpoints"))]
pub fn visible(
    motions: &[PlaneMotion],
    points: &[Point2<f64>],
    first: &Matrix3<f64>,
) -> Result<Vec<PlaneMotion>, Error> {
    let inverse = inverse_calibration(first)?;
    let sees =
        |n: &UnitVector3<f64>| points.iter().all(|p| n.dot(&(inverse * p.to_homogeneous())) > 0.0);
    Ok(motions.iter().filter(|m| m.normal.as_ref().is_none_or(sees)).copied().collect())
}

fn inverse_calibration(k: &Matrix3<f64>) -> Result<Matrix3<f64>, Error> {
    if !k.iter().all(|e| e.is_finite()) {
        return Err(Error::NotFinite { what: "calibration matrix" });
    }
    let checks = [
        (k.m11, k.m11 > 0.0, "positive"),
        (k.m22, k.m22 > 0.0, "positive"),
        (k.m21, k.m21 == 0.0, "zero below the diagonal"),
        (k.m31, k.m31 == 0.0, "zero below the diagonal"),
        (k.m32, k.m32 == 0.0, "zero below the diagonal"),
        (k.m33, k.m33 == 1.0, "one as the last"),
    ];
    if let Some(&(value, _, expected)) = checks.iter().find(|c| !c.1) {
        return Err(Error::OutOfRange { what: "calibration matrix entry", value, expected });
    }
    let (x, y) = (1.0 / k.m11, 1.0 / k.m22);
    Ok(Matrix3::new(
        x,
        -k.m12 * x * y,
        (k.m12 * k.m23 * y - k.m13) * x,
        0.0,
        y,
        -k.m23 * y,
        0.0,
        0.0,
        1.0,
    ))
}
