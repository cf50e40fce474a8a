//! The collinearity equations: object point, image point and projection centre lie on one line.
//!
//! ```text
//! (x, y, f)ᵀ = μ R (X − Xc, Y − Yc, Z − Zc)ᵀ                                   [WD] eq. 4a
//! (X, Y, Z)ᵀ = (Xc, Yc, Zc)ᵀ + λ M (x, y, f)ᵀ,   M = Rᵀ                         [WD] eq. 4b
//! ```
//!
//! \[WD\] writes +f for a camera that looks along +z, as the camera axes of this crate do; the photogrammetric camera
//! looks along −z and has −c in that place. Dividing by the third component removes μ:
//!
//! ```text
//! x = X′/Z′,  y = Y′/Z′,   X′ = R (X − C)
//! ```
//!
//! X′ is [`Pose::apply`](crate::geometry::Pose::apply). The functions here are private; [`Frame`](super::Frame) and the central models are their public face.

use nalgebra::{Matrix2x3, Matrix3, Point2, Vector3};

use crate::error::ProjectionError;
use crate::numeric::float;
use crate::numeric::scalar::Scalar;

/// \[WD\] eq. 4a with μ divided out.
pub(super) fn normalised<S: Scalar>(direction: [S; 3]) -> [S; 2] {
    [direction[0] / direction[2], direction[1] / direction[2]]
}

/// The normalised image point (X/Z, Y/Z) of a direction before the camera.
#[inline]
pub(super) fn normalised_point(direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
    if !(direction.z > 0.0) {
        return Err(if direction.iter().any(|c| c.is_nan()) {
            ProjectionError::NotFinite
        } else {
            ProjectionError::BehindCamera { depth: direction.z }
        });
    }
    let [x, y] = normalised([direction.x, direction.y, direction.z]);
    finite(Point2::new(x, y))
}

/// The unit vector along (x, y, 1) of a normalised image point.
#[inline]
pub(super) fn unit_direction(normalised: &Point2<f64>) -> Vector3<f64> {
    let direction = Vector3::new(normalised.x, normalised.y, 1.0);
    let squared = direction.norm_squared();
    if squared.is_finite() {
        return direction / float::sqrt(squared);
    }
    // The squares of 10¹⁵⁵ have left the numbers, its direction has not.
    (direction / direction.amax()).normalize()
}

/// ∂(X/Z, Y/Z)/∂(X, Y, Z), from the normalised point and the depth.
#[inline]
pub(super) fn normalised_jacobian(n: &Point2<f64>, depth: f64) -> Matrix2x3<f64> {
    let i = 1.0 / depth;
    Matrix2x3::new(i, 0.0, -n.x * i, 0.0, i, -n.y * i)
}

/// ∂(δ × v)/∂δ = −[v]×: how a camera-frame vector moves with a left rotation.
#[inline]
pub(super) fn rotation_partials(v: &Vector3<f64>) -> Matrix3<f64> {
    -v.cross_matrix()
}

/// The point, or `NotFinite`.
#[inline]
pub(super) fn finite(p: Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
    if p.x.is_finite() && p.y.is_finite() { Ok(p) } else { Err(ProjectionError::NotFinite) }
}

/// A 2×3 matrix as two rows of three.
#[inline]
pub(super) fn write_rows(m: &Matrix2x3<f64>, out: &mut [f64; 6]) {
    *out = [m.m11, m.m12, m.m13, m.m21, m.m22, m.m23];
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;
    use crate::geometry::pose::rotate_about;
    use crate::numeric::scalar::Dual;

    #[test]
    fn partials_of_centre_and_rotation_agree_with_dual_numbers() {
        let rotation = *Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7)).matrix();
        let (world, center) = ([3.0, -4.0, 7.0], [0.5, 1.5, -2.0]);
        // (I + [δ]×) R: the first order is exact at δ = 0, where partials are taken.
        let [a, b, c] = [3, 4, 5].map(|i| Dual::<6>::variable(0.0, i));
        let one = Dual::constant(1.0);
        let turn = [[one, -c, b], [c, one, -a], [-b, a, one]];
        let rows: [[Dual<6>; 3]; 3] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                (0..3).fold(Dual::constant(0.0), |s, k| s + turn[i][k].scale(rotation[(k, j)]))
            })
        });
        let centre = core::array::from_fn(|i| Dual::<6>::variable(center[i], i));
        let dual = rotate_about(world.map(Dual::constant), centre, rows);
        let v = Vector3::from(dual.map(Scalar::value));
        let n = normalised(dual);
        let by_direction = normalised_jacobian(&Point2::new(v.x / v.z, v.y / v.z), v.z);
        let by_center: Matrix2x3<f64> = -(by_direction * rotation);
        let by_rotation = by_direction * rotation_partials(&v);
        for row in 0..2 {
            for i in 0..3 {
                assert!((n[row].gradient[i] - by_center[(row, i)]).abs() < 1e-15);
                assert!((n[row].gradient[3 + i] - by_rotation[(row, i)]).abs() < 1e-15);
            }
        }
    }
}
