//! The rotation nearest to a printed matrix.

use nalgebra::{Matrix3, Rotation3};

use crate::error::Error;

/// The largest element of M Mᵀ − I that passes for rounding: two printed decimals give up to 2 · √3 · 0.005 = 0.0173.
const LIMIT: f64 = 0.02;

/// The rotation nearest to a matrix whose elements were rounded, in the sum of squared differences.
///
/// ```text
/// M = U Σ Vᵀ  →  R = U Vᵀ
/// ```
///
/// U Vᵀ is the orthogonal factor of the polar decomposition. It is found without the singular values, as the limit of
/// X ← (X + X⁻ᵀ)/2 (Higham 1986), which converges quadratically. R is orthonormal within 4 ε.
///
/// # Errors
/// [`Error::NotFinite`]; [`Error::Inconsistent`] where an element of M Mᵀ − I exceeds 0.02, the residual being the largest of
/// them; [`Error::OutOfRange`] with the determinant where the matrix is a reflection.
///
/// # Example
/// The matrix of the `dcm2quat` example on MathWorks' pages, printed to four decimals; its quaternion there is
/// (0.8224, 0.2006, 0.5320, 0.0223).
/// ```
/// use collinear::geometry::rotation::{Quaternion, orthonormalised};
/// use collinear::nalgebra::Matrix3;
///
/// let printed = Matrix3::new(0.4330, 0.2500, -0.8660, 0.1768, 0.9186, 0.3536, 0.8839, -0.3062, 0.3536);
/// let q = Quaternion::from_rotation(&orthonormalised(&printed)?.inverse());
/// assert!((q.w - 0.8224).abs() < 1e-4 && (q.x - 0.2006).abs() < 1e-4);
/// assert!((q.y - 0.5320).abs() < 1e-4 && (q.z - 0.0223).abs() < 1e-4);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("polar", "procrustes", "SVD"))]
pub fn orthonormalised(matrix: &Matrix3<f64>) -> Result<Rotation3<f64>, Error> {
    if !matrix.iter().all(|e| e.is_finite()) {
        return Err(Error::NotFinite { what: "rotation matrix" });
    }
    let residual = (matrix * matrix.transpose() - Matrix3::identity())
        .iter()
        .fold(0.0, |m: f64, e| if e.is_nan() { f64::INFINITY } else { m.max(e.abs()) });
    if residual > LIMIT {
        return Err(Error::Inconsistent {
            what: "rows of a rotation matrix",
            residual,
            limit: LIMIT,
        });
    }
    let determinant = matrix.determinant();
    if determinant < 0.0 {
        return Err(Error::OutOfRange {
            what: "determinant of a rotation matrix",
            value: determinant,
            expected: "+1, a reflection is no rotation",
        });
    }
    // Singular values start within 1 ± 0.04 and their distance from 1 is squared and halved by a step: 4 steps reach ε.
    let mut x = *matrix;
    for _ in 0..4 {
        let cofactors = Matrix3::from_columns(&[
            x.column(1).cross(&x.column(2)),
            x.column(2).cross(&x.column(0)),
            x.column(0).cross(&x.column(1)),
        ]);
        let determinant = x.column(0).dot(&cofactors.column(0));
        x = (x + cofactors / determinant) * 0.5;
    }
    Ok(Rotation3::from_matrix_unchecked(x))
}
