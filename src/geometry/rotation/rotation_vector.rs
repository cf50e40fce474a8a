//! Rotation vectors.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::quaternion::{self, Quaternion};
use super::sequence::to_matrix3;
use crate::numeric::float;
use crate::numeric::scalar::Scalar;

/// A rotation by the angle θ = |r| about the axis u = r / θ.
///
/// ```text
/// R = exp([r]×) = I + sinθ [u]× + 2 sin²(θ/2) [u]×²            (Rodrigues 1840)
/// ```
///
/// Vectors are turned counter-clockwise about u: the convention of OpenCV's `rvec` and of SciPy. The components are
/// radians. A NaN or infinite component gives a matrix of NaN.
///
/// # Example
/// SciPy's documentation of `Rotation.as_rotvec`: the quaternion 1 + i + j of length √3 has the rotation vector
/// (1.35102172, 1.35102172, 0).
/// ```
/// use collinear::geometry::rotation::{Quaternion, RotationVector};
///
/// let turned = Quaternion { w: 1.0, x: 1.0, y: 1.0, z: 0.0 }.rotation()?;
/// let vector = RotationVector::from_rotation(&turned);
/// assert!((vector.x - 1.35102172).abs() < 0.5e-8);
/// assert!((vector.y - 1.35102172).abs() < 0.5e-8);
/// assert_eq!(vector.z, 0.0);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("rvec", "axis-angle", "Rodrigues", "exponential map"))]
pub struct RotationVector {
    /// θ u₁.
    pub x: f64,
    /// θ u₂.
    pub y: f64,
    /// θ u₃.
    pub z: f64,
}

/// θ and u; u is zero where θ is. Scaled by a power of two, so that squares neither overflow nor vanish.
fn angle_axis<S: Scalar>(r: [S; 3]) -> (S, [S; 3]) {
    if !r.iter().all(|c| c.value().is_finite()) {
        return (S::constant(f64::NAN), [S::constant(f64::NAN); 3]);
    }
    let largest = r.iter().fold(0.0, |m: f64, c| m.max(c.value().abs()));
    if largest == 0.0 {
        return (S::constant(0.0), r);
    }
    // The power of two below it, by which nothing is rounded.
    let power = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
    let u = r.map(|c| c / S::constant(power));
    let length = (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).sqrt();
    (length.scale(power), u.map(|c| c / length))
}

/// By the half angle's quaternion, whose matrix is orthonormal however u is rounded.
fn matrix<S: Scalar>(r: [S; 3]) -> [[S; 3]; 3] {
    let (angle, [x, y, z]) = angle_axis(r);
    let (sine, cosine) = angle.scale(0.5).sin_cos();
    quaternion::matrix([cosine, sine * x, sine * y, sine * z])
}

impl RotationVector {
    /// From any vector.
    #[must_use]
    pub fn new(vector: Vector3<f64>) -> Self {
        Self { x: vector.x, y: vector.y, z: vector.z }
    }

    /// r.
    #[must_use]
    pub fn vector(&self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, self.z)
    }

    /// θ = |r| ≥ 0.
    #[must_use]
    pub fn angle(&self) -> f64 {
        angle_axis([self.x, self.y, self.z]).0
    }

    /// R.
    #[must_use]
    pub fn rotation(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(to_matrix3(matrix([self.x, self.y, self.z])))
    }

    /// The rotation vector of R with θ in [0, π]; for a half turn the first non-zero component is positive.
    ///
    /// It gives R back within 6 ε in every element: near π the vector's own rounding is one ε. NaN where an element is NaN or infinite.
    #[must_use]
    pub fn from_rotation(rotation: &Rotation3<f64>) -> Self {
        let Quaternion { w, x, y, z } = Quaternion::from_rotation(rotation);
        let (sine, axis) = angle_axis([x, y, z]);
        let angle = 2.0 * float::atan2(sine, w);
        Self::new(Vector3::from(axis) * angle)
    }

    /// R, and the matrix of [`left_from_vector`](Self::left_from_vector), in less time than both.
    pub(crate) fn rotation_with_left(&self) -> (Rotation3<f64>, Matrix3<f64>) {
        let (angle, axis) = angle_axis([self.x, self.y, self.z]);
        let (sine, cosine) = float::sin_cos(0.5 * angle);
        let [x, y, z] = axis.map(|a| sine * a);
        let rotation =
            Rotation3::from_matrix_unchecked(to_matrix3(quaternion::matrix([cosine, x, y, z])));
        (rotation, left(angle, axis, [sine, cosine]))
    }

    /// The matrix whose columns are the left rotation vectors of a unit change of x, y, z.
    ///
    /// ```text
    /// δR = [δθ]× R,    δθ = J δr,    J = (sinθ/θ) I + (1 − sinθ/θ) u uᵀ + ((1 − cosθ)/θ) [u]×
    /// ```
    ///
    /// J is singular where θ is a non-zero multiple of 2π.
    #[must_use]
    pub fn left_from_vector(&self) -> Matrix3<f64> {
        let (angle, axis) = angle_axis([self.x, self.y, self.z]);
        let (sine, cosine) = float::sin_cos(0.5 * angle);
        left(angle, axis, [sine, cosine])
    }
}

/// J of θ, u, and the sine and cosine of θ/2.
fn left(angle: f64, axis: [f64; 3], [half, cosine]: [f64; 2]) -> Matrix3<f64> {
    if angle == 0.0 {
        return Matrix3::identity();
    }
    let u = Vector3::from(axis);
    let ratio = 2.0 * half * cosine / angle;
    Matrix3::identity() * ratio
        + u * u.transpose() * (1.0 - ratio)
        + u.cross_matrix() * (2.0 * half * (half / angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn left_rotation_vectors_are_the_derivatives() {
        for r in [[0.3, -0.7, 2.5], [1e-9, 2e-9, -1e-9], [-4.0, 3.0, 1.0], [1e-200, 0.0, 0.0]] {
            let vector = RotationVector { x: r[0], y: r[1], z: r[2] };
            let m = vector.rotation();
            let left = vector.left_from_vector();
            let dual = matrix([0, 1, 2].map(|i| Dual::<3>::variable(r[i], i)));
            for k in 0..3 {
                let column: Vector3<f64> = left.column(k).into_owned();
                let expected = column.cross_matrix() * m.matrix();
                for i in 0..3 {
                    for j in 0..3 {
                        let got = dual[i][j].gradient[k];
                        assert!((got - expected[(i, j)]).abs() < 4e-15, "{r:?} {got}");
                    }
                }
            }
        }
    }
}
