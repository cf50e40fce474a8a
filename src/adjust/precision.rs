//! How good an observation is.

use nalgebra::{Const, OMatrix, SMatrix};

use crate::error::Error;
use crate::numeric::float;

/// The precision of an observation of `N` numbers: of an image point, `N` = 2, in pixels; of an object point, `N` = 3,
/// in world units.
///
/// ```text
/// P = Σ⁻¹,   one number: p = 1/σ²
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Precision<const N: usize> {
    /// The same standard deviation σ > 0 in every coordinate, without correlation.
    Sigma(f64),
    /// A weight p = 1/σ² > 0.
    Weight(f64),
    /// A standard deviation for each coordinate, without correlation.
    Sigmas([f64; N]),
    /// A covariance matrix, symmetric and positive definite.
    Covariance(SMatrix<f64, N, N>),
}

impl<const N: usize> Default for Precision<N> {
    /// σ = 1: a pixel, or a world unit.
    fn default() -> Self {
        Self::Sigma(1.0)
    }
}

impl<const N: usize> Precision<N> {
    /// Σ.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a standard deviation, a weight or a variance that is not a positive
    /// number, an infinite weight among them; [`Error::Degenerate`] where a covariance matrix is not positive definite, its measure
    /// the smallest pivot of the matrix with a unit diagonal; [`Error::Inconsistent`] where it is not symmetric.
    ///
    /// # Example
    /// ```
    /// use collinear::adjust::Precision;
    ///
    /// let weighted = Precision::<2>::Weight(4.0).covariance()?;
    /// assert_eq!((weighted.m11, weighted.m12, weighted.m22), (0.25, 0.0, 0.25));
    /// assert!(Precision::<2>::Weight(f64::INFINITY).covariance().is_err());
    /// # Ok::<(), collinear::Error>(())
    /// ```
    pub fn covariance(&self) -> Result<SMatrix<f64, N, N>, Error> {
        let diagonal =
            |variance: [f64; N]| SMatrix::from_fn(|i, j| if i == j { variance[i] } else { 0.0 });
        match *self {
            Self::Sigma(s) => Ok(diagonal([squared(s)?; N])),
            Self::Sigmas(s) => {
                let mut variance = [0.0; N];
                for (v, s) in variance.iter_mut().zip(s) {
                    *v = squared(s)?;
                }
                Ok(diagonal(variance))
            }
            Self::Weight(p) => {
                let variance = 1.0 / positive("weight", p)?;
                Ok(diagonal([positive("weight", variance).map(|_| variance)?; N]))
            }
            Self::Covariance(c) => checked(&c),
        }
    }

    /// P = Σ⁻¹.
    ///
    /// # Errors
    /// As [`covariance`](Self::covariance).
    pub fn weight(&self) -> Result<SMatrix<f64, N, N>, Error> {
        Ok(inverse(&self.covariance()?))
    }
}

/// A precision as the matrices that an adjustment needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weighting<const N: usize> {
    /// Σ.
    pub(super) covariance: SMatrix<f64, N, N>,
    /// P = Σ⁻¹.
    pub(super) weight: SMatrix<f64, N, N>,
    /// U with UᵀU = P.
    pub(super) root: SMatrix<f64, N, N>,
}

impl<const N: usize> Weighting<N> {
    /// The matrices of a precision; `what` it is of.
    pub(super) fn new(precision: &Precision<N>, what: &'static str) -> Result<Self, Error> {
        let covariance = precision.covariance()?;
        let weight = inverse(&covariance);
        let root = weight.cholesky().ok_or(Error::NotFinite { what })?.l().transpose();
        Ok(Self { covariance, weight, root })
    }
}

/// The inverse of a covariance matrix that [`Precision::covariance`] has checked.
#[inline]
pub(super) fn inverse<const N: usize>(covariance: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let diagonal = (0..N).all(|i| (0..i).all(|j| covariance[(i, j)] == 0.0));
    if diagonal {
        return SMatrix::from_fn(|i, j| if i == j { 1.0 / covariance[(i, i)] } else { 0.0 });
    }
    let scale = covariance.diagonal().map(|d| 1.0 / float::sqrt(d));
    let unit = covariance.component_mul(&(scale * scale.transpose()));
    let inverse: OMatrix<f64, Const<N>, Const<N>> = match unit.cholesky() {
        Some(factor) => factor.inverse(),
        None => SMatrix::from_element(f64::NAN),
    };
    inverse.component_mul(&(scale * scale.transpose()))
}

fn positive(what: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else if value.is_nan() {
        Err(Error::NotFinite { what })
    } else {
        Err(Error::OutOfRange { what, value, expected: "a positive number" })
    }
}

fn squared(sigma: f64) -> Result<f64, Error> {
    let variance = positive("standard deviation", sigma)? * sigma;
    // 10⁻²⁰⁰ is positive, its square is not.
    if variance > 0.0 && variance.is_finite() {
        return Ok(variance);
    }
    Err(Error::OutOfRange {
        what: "standard deviation",
        value: sigma,
        expected: "a number whose square is a number",
    })
}

fn checked<const N: usize>(c: &SMatrix<f64, N, N>) -> Result<SMatrix<f64, N, N>, Error> {
    if !c.iter().all(|v| v.is_finite()) {
        return Err(Error::NotFinite { what: "covariance matrix" });
    }
    for i in 0..N {
        positive("variance", c[(i, i)])?;
        for j in 0..i {
            let size = float::sqrt(c[(i, i)]) * float::sqrt(c[(j, j)]);
            let (residual, limit) = ((c[(i, j)] - c[(j, i)]).abs(), 1e-9 * size);
            if residual > limit {
                return Err(Error::Inconsistent {
                    what: "halves of a covariance matrix",
                    residual,
                    limit,
                });
            }
        }
    }
    // Pivots of the correlation matrix.
    let scale = c.diagonal().map(|d| 1.0 / float::sqrt(d));
    let mut unit = c.component_mul(&(scale * scale.transpose()));
    let limit = 16.0 * f64::EPSILON;
    for k in 0..N {
        let measure = unit[(k, k)];
        if !(measure > limit) {
            return Err(Error::Degenerate { what: "covariance matrix", measure, limit });
        }
        for i in k + 1..N {
            for j in k + 1..=i {
                unit[(i, j)] -= unit[(i, k)] * unit[(j, k)] / measure;
            }
        }
    }
    Ok((c + c.transpose()) * 0.5)
}
