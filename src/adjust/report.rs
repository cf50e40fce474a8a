//! How good an adjustment is: σ₀, covariance, redundancy numbers, tests for blunders.

use alloc::vec::Vec;

use nalgebra::{DMatrix, SMatrix, SVector};

use super::precision::inverse;
use crate::error::Error;
use crate::numeric::float;
use crate::numeric::least_squares::Convergence;

/// The critical value of Baarda's w: in 1 of 1000 good observations |w| exceeds it by chance (normal distribution, two sides).
pub const CRITICAL_VALUE: f64 = 3.290_526_731_491_895;

/// δ₀: a blunder that moves w by so much is found, by [`CRITICAL_VALUE`], in 80 of 100 cases (Baarda 1968): 3.2905 + 0.8416.
pub const NONCENTRALITY: f64 = 4.132_147_965_064_809;

/// What an adjustment found out about itself.
///
/// *In words.* **σ₀** is the standard deviation of an observation of unit weight, from the residuals: 1 where the stated
/// precisions were right, 2 where everything is twice as bad as stated. The **redundancy** is how many observations there are
/// more than needed. The **covariance** says how far the unknowns can be trusted; its square roots are their standard
/// deviations. The **condition** warns: near 10¹² the unknowns are told apart by rounding only.
///
/// ```text
/// σ₀² = vᵀPv / r,    r = n − u + d,    Σ = s² Q,    Q = (AᵀPA)⁻¹
/// ```
///
/// n observations, u unknowns, d conditions. s is [`sigma`](Self::sigma).
#[derive(Clone, Debug)]
pub struct Report {
    /// n: observed numbers, two for an image point, and the coordinates of control points and the values of parameters that
    /// were given with a precision.
    pub observations: usize,
    /// u: unknowns, the coordinates of control points that were given with a precision among them.
    pub unknowns: usize,
    /// r: how many observations more than needed.
    pub redundancy: usize,
    /// vᵀPv, without dimension.
    pub weighted_sum: f64,
    /// σ₀ = √(vᵀPv / r); `None` where nothing is redundant.
    #[doc(alias("reference standard deviation", "unit weight", "RMSE"))]
    pub sigma0: Option<f64>,
    /// s, by which the covariances are scaled and the observations tested: σ₀ where it was to be estimated, there is redundancy and
    /// the residuals are not all zero; else 1, which is to believe the stated precisions.
    pub sigma: f64,
    /// Σ of the estimated parameters, in their order and units.
    pub covariance: DMatrix<f64>,
    /// ‖N‖₁ ‖N⁻¹‖₁ of the normal matrix N scaled to a unit diagonal: 1 where the unknowns do not depend on each other.
    pub condition: f64,
    /// For each observed number, in the order the estimator states.
    pub values: Vec<ObservationReport>,
    /// How the iteration ended; the cost is half of vᵀPv, or the sum of losses.
    pub convergence: Convergence,
}

impl Report {
    /// The standard deviation of an estimated parameter; NaN past the last.
    #[must_use]
    pub fn standard_deviation(&self, parameter: usize) -> f64 {
        self.covariance.get((parameter, parameter)).map_or(f64::NAN, |v| float::sqrt(*v))
    }

    /// The correlation of two estimated parameters, in [−1, 1]; NaN past the last.
    #[must_use]
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        let covariance = self.covariance.get((a, b)).copied().unwrap_or(f64::NAN);
        covariance / (self.standard_deviation(a) * self.standard_deviation(b))
    }

    /// Σ rᵢ over the observed numbers: the redundancy r again, by another way.
    #[must_use]
    pub fn redundancy_sum(&self) -> f64 {
        self.values.iter().map(|v| v.redundancy).sum()
    }

    /// The observed number with the largest |w|, which is the first to suspect; `None` where none is tested.
    #[must_use]
    #[doc(alias("data snooping"))]
    pub fn most_suspect(&self) -> Option<usize> {
        let tested = self.values.iter().enumerate().filter(|(_, v)| v.w.is_finite());
        tested.max_by(|a, b| a.1.w.abs().total_cmp(&b.1.w.abs())).map(|(i, _)| i)
    }
}

/// What an adjustment found out about one observed number.
///
/// *In words.* The **redundancy number** rᵢ says which part of an error in this number shows in its own residual, the rest
/// being swallowed by the unknowns: 1 is fully controlled by the others, 0 not at all (then the residual is zero whatever
/// was measured). **w** is the residual over its own standard deviation: beyond ±3.3 it is a blunder, but for one chance in a
/// thousand. The **detectable blunder** is the smallest error in this number that the test finds with a probability of
/// 80 %. The **influence** says how many of its own standard deviations an undetected blunder of that size can move
/// any unknown or any function of them.
///
/// ```text
/// v = l − l̂     Qᵥᵥ = P⁻¹ − A Q Aᵀ     rᵢ = (Qᵥᵥ P)ᵢᵢ          Σ rᵢ = r
/// wᵢ = (P v)ᵢ / (s √(P Qᵥᵥ P)ᵢᵢ)                                    (Baarda 1968)
/// ∇ᵢ = s δ₀ / √(P Qᵥᵥ P)ᵢᵢ     δ̄ᵢ = δ₀ √((1 − rᵢ)/rᵢ)                 for uncorrelated observations ∇ᵢ = σᵢ δ₀/√rᵢ
/// ```
///
/// With s = σ₀ from the residuals themselves w is Pope's τ (1976), which cannot exceed √r. Adjustment texts call −v
/// the correction: observed plus correction is adjusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservationReport {
    /// v: observed minus computed, in the observation's unit.
    pub residual: f64,
    /// vᵢ (P v)ᵢ, without dimension: its part of vᵀPv.
    pub weighted_square: f64,
    /// rᵢ, in [0, 1] for uncorrelated observations.
    pub redundancy: f64,
    /// w; NaN where rᵢ = 0: an observation that nothing controls cannot be tested.
    #[doc(alias("standardised residual", "tau", "Baarda"))]
    pub w: f64,
    /// ∇: the minimal detectable blunder, in the observation's unit; infinite where rᵢ = 0.
    #[doc(alias("MDB", "internal reliability"))]
    pub detectable: f64,
    /// δ̄: the influence of an undetected blunder, in standard deviations; infinite where rᵢ = 0.
    #[doc(alias("external reliability"))]
    pub influence: f64,
}

/// Below this an observation counts as controlled by nothing: rounding of 1 − a·Q·a.
const UNCONTROLLED: f64 = 1e-11;

/// The reports of `N` correlated numbers: Qᵥᵥ, the cofactors of their residuals; their covariance Σ = P⁻¹ a priori; the
/// residuals; s. A robust weight ρ′ enters as a covariance that is larger by 1/ρ′.
#[inline]
pub(super) fn observed<const N: usize>(
    unexplained: &SMatrix<f64, N, N>,
    covariance: &SMatrix<f64, N, N>,
    residual: &SVector<f64, N>,
    sigma: f64,
) -> [ObservationReport; N] {
    let weight = inverse(covariance);
    let reduced = unexplained * weight;
    let tested = weight * reduced;
    core::array::from_fn(|i| {
        let redundancy = reduced[(i, i)];
        let weighted: f64 = (0..N).map(|j| weight[(i, j)] * residual[j]).sum();
        let weighted_square = residual[i] * weighted;
        if !(redundancy.abs() > UNCONTROLLED && tested[(i, i)] > 0.0) {
            return ObservationReport {
                residual: residual[i],
                weighted_square,
                redundancy,
                w: f64::NAN,
                detectable: f64::INFINITY,
                influence: f64::INFINITY,
            };
        }
        let root = float::sqrt(tested[(i, i)]);
        ObservationReport {
            residual: residual[i],
            weighted_square,
            redundancy,
            w: weighted / (sigma * root),
            detectable: sigma * NONCENTRALITY / root,
            influence: NONCENTRALITY * float::sqrt(((1.0 - redundancy) / redundancy).max(0.0)),
        }
    })
}

/// What the covariances are scaled by and the observations tested with: σ₀ where it is to be estimated and not zero, else 1.
pub(super) fn sigma(sigma0: Option<f64>, estimate: bool) -> f64 {
    sigma0.filter(|s| estimate && *s > 0.0).unwrap_or(1.0)
}

/// Normal equations that are singular, with how nearly.
pub(super) fn undetermined(measure: f64, limit: f64) -> Error {
    let what = "normal equations: the observations do not determine the unknowns";
    Error::Degenerate { what, measure, limit }
}

/// [`cofactor`] of a matrix whose size is known.
pub(super) fn fixed_cofactor<const N: usize>(
    normal: &SMatrix<f64, N, N>,
) -> Result<(SMatrix<f64, N, N>, f64), Error> {
    let (q, condition) = cofactor(&DMatrix::from_fn(N, N, |i, j| normal[(i, j)]))?;
    Ok((SMatrix::from_fn(|i, j| q[(i, j)]), condition))
}

/// Σ of the estimated parameters from their cofactors.
pub(super) fn covariance<const N: usize>(q: &SMatrix<f64, N, N>, sigma: f64) -> DMatrix<f64> {
    DMatrix::from_fn(N, N, |i, j| q[(i, j)] * (sigma * sigma))
}

/// Q of a normal matrix, with the condition of the matrix scaled to a unit diagonal.
pub(super) fn cofactor(normal: &DMatrix<f64>) -> Result<(DMatrix<f64>, f64), Error> {
    let n = normal.nrows();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / float::sqrt(normal[(i, i)])).collect();
    let unit = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let norm = |m: &DMatrix<f64>| {
        (0..n).map(|j| m.column(j).iter().map(|v| v.abs()).sum()).fold(0.0, f64::max)
    };
    let inverse = unit.clone().cholesky().map(|c| c.inverse());
    let condition = inverse.as_ref().map_or(f64::INFINITY, |i| norm(&unit) * norm(i));
    let measure = 1.0 / condition;
    match inverse.filter(|_| measure > LEAST_CONDITION) {
        Some(inverse) => {
            Ok((DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]), condition))
        }
        None => Err(undetermined(if measure > 0.0 { measure } else { 0.0 }, LEAST_CONDITION)),
    }
}

/// One over the largest condition of normal equations whose inverse has a digit left.
const LEAST_CONDITION: f64 = 1e-15;

#[cfg(test)]
mod tests {
    use super::*;

    /// Two unknowns of correlation 1 − ε/2: the inverse exists in floats, its condition is 2 · 2/ε = 1.8 · 10¹⁶.
    #[test]
    fn an_inverse_without_a_digit_left_is_refused() {
        let a = 1.0 - 0.5 * f64::EPSILON;
        let normal = DMatrix::from_row_slice(2, 2, &[4.0, 6.0 * a, 6.0 * a, 9.0]);
        match cofactor(&normal) {
            Err(Error::Degenerate { measure, limit, .. }) => {
                assert!((0.0..1e-15).contains(&measure) && limit == LEAST_CONDITION, "{measure}");
            }
            other => panic!("{other:?}"),
        }
        // Correlation 0.6: N⁻¹ = ((25, −15·2/3), (…, 100/9)) / 64, condition 1.6²/0.64 = 4.
        let (q, condition) =
            cofactor(&DMatrix::from_row_slice(2, 2, &[4.0, 3.6, 3.6, 9.0])).unwrap();
        let expected = [0.390_625, -0.156_25, -0.156_25, 0.173_611_111_111_111_1];
        assert!(q.iter().zip(expected).all(|(q, e)| (q - e).abs() < 1e-15), "{q}");
        assert!((condition - 4.0).abs() < 1e-14);
    }
}
