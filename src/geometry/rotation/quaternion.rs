//! Quaternions, scalar first.

use nalgebra::{Rotation3, Vector3};

use super::sequence::to_matrix3;
use crate::error::Error;
use crate::numeric::float;
use crate::numeric::scalar::Scalar;

/// A quaternion w + x i + y j + z k, scalar part first, of any non-zero length.
///
/// ```text
/// q = cos(θ/2) + sin(θ/2) (u₁ i + u₂ j + u₃ k),    R v = q v q⁻¹
///
///      1   ⎛ w² + x² − y² − z²   2(xy − wz)          2(xz + wy)        ⎞
/// R = ──── ⎜ 2(xy + wz)          w² − x² + y² − z²   2(yz − wx)        ⎟
///     |q|² ⎝ 2(xz − wy)          2(yz + wx)          w² − x² − y² + z² ⎠
/// ```
///
/// Hamilton's product, ij = k, and vectors turned by θ about u: the convention of COLMAP, Eigen and SciPy (which puts the
/// scalar last). MathWorks' `quat2dcm` and the R package RSpincalc turn the axes instead; their matrix is Rᵀ. The
/// quaternion says nothing about frames; whatever holds it names them.
///
/// # Example
/// MathWorks' page on `quat2dcm` prints the transpose for the quaternion (1, 0.5, 0.3, 0.1).
/// ```
/// use collinear::geometry::rotation::Quaternion;
///
/// let r = Quaternion { w: 1.0, x: 0.5, y: 0.3, z: 0.1 }.rotation()?;
/// let printed =
///     [[0.8519, 0.3704, -0.3704], [0.0741, 0.6148, 0.7852], [0.5185, -0.6963, 0.4963]];
/// for i in 0..3 {
///     for j in 0..3 {
///         assert!((r[(j, i)] - printed[i][j]).abs() < 0.5e-4);
///     }
/// }
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("qvec", "Euler parameters"))]
pub struct Quaternion {
    /// The scalar part, cos(θ/2).
    pub w: f64,
    /// The coefficient of i.
    pub x: f64,
    /// The coefficient of j.
    pub y: f64,
    /// The coefficient of k.
    pub z: f64,
}

/// R of a quaternion whose length is neither huge nor tiny. Dividing by |q|² keeps R orthonormal where |q| is rounded.
pub(super) fn matrix<S: Scalar>([w, x, y, z]: [S; 4]) -> [[S; 3]; 3] {
    let (ww, xx, yy, zz) = (w * w, x * x, y * y, z * z);
    let square = ww + xx + yy + zz;
    let twice = |a: S| a.scale(2.0) / square;
    [
        [(ww + xx - yy - zz) / square, twice(x * y - w * z), twice(x * z + w * y)],
        [twice(x * y + w * z), (ww - xx + yy - zz) / square, twice(y * z - w * x)],
        [twice(x * z - w * y), twice(y * z + w * x), (ww - xx - yy + zz) / square],
    ]
}

impl Quaternion {
    /// The components divided by the largest, so that their squares neither overflow nor vanish, and the sum of their
    /// squares.
    fn scaled(&self) -> Result<([f64; 4], f64), Error> {
        let parts = [self.w, self.x, self.y, self.z];
        if !parts.iter().all(|p| p.is_finite()) {
            return Err(Error::NotFinite { what: "quaternion" });
        }
        let largest = parts.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        if largest == 0.0 {
            return Err(Error::Degenerate { what: "quaternion", measure: 0.0, limit: 0.0 });
        }
        let parts = parts.map(|p| p / largest);
        Ok((parts, parts.iter().map(|p| p * p).sum()))
    }

    /// The quaternion divided by its length.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::Degenerate`] where all four components are zero.
    pub fn normalised(&self) -> Result<Self, Error> {
        let (parts, square) = self.scaled()?;
        let length = float::sqrt(square);
        let [w, x, y, z] = parts.map(|p| p / length);
        Ok(Self { w, x, y, z })
    }

    /// R.
    ///
    /// # Errors
    /// As [`normalised`](Self::normalised).
    pub fn rotation(&self) -> Result<Rotation3<f64>, Error> {
        let (parts, _) = self.scaled()?;
        Ok(Rotation3::from_matrix_unchecked(to_matrix3(matrix(parts))))
    }

    /// The unit quaternion of R with w ≥ 0; for a half turn (w = 0) the first non-zero component of x, y, z is positive.
    ///
    /// The largest component is taken from the diagonal and the others from it (Shepperd 1978), so that nothing cancels.
    /// It gives R back within 4 ε in every element. All four are NaN where an element is NaN or infinite.
    #[must_use]
    pub fn from_rotation(rotation: &Rotation3<f64>) -> Self {
        let m = rotation.matrix();
        if !m.iter().all(|e| e.is_finite()) {
            return Self { w: f64::NAN, x: f64::NAN, y: f64::NAN, z: f64::NAN };
        }
        let d = m.diagonal();
        let trace = d.sum();
        let imax = d.imax();
        let (w, v) = if trace >= d[imax] {
            (
                1.0 + trace,
                Vector3::new(m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]),
            )
        } else {
            let (i, j, k) = (imax, (imax + 1) % 3, (imax + 2) % 3);
            let mut v = Vector3::zeros();
            v[i] = 1.0 + (d[i] - d[j] - d[k]);
            v[j] = m[(j, i)] + m[(i, j)];
            v[k] = m[(k, i)] + m[(i, k)];
            (m[(k, j)] - m[(j, k)], v)
        };
        let length = float::sqrt(w * w + v.norm_squared());
        let first = [w, v.x, v.y, v.z].into_iter().find(|p| *p != 0.0).unwrap_or(1.0);
        let length = length.copysign(first);
        Self {
            w: w / length + 0.0,
            x: v.x / length + 0.0,
            y: v.y / length + 0.0,
            z: v.z / length + 0.0,
        }
    }
}
