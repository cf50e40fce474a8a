//! Losses that keep blunders from ruling a fit.

use super::float;
#[cfg(feature = "std")]
use crate::error::Error;

/// How a squared residual enters the cost: ρ(s) with s = (residual / scale)².
///
/// ```text
/// squared    ρ = s
/// Huber      ρ = s for s ≤ 1, 2√s − 1 beyond                    (Huber 1964)
/// Cauchy     ρ = ln(1 + s)
/// Tukey      ρ = (1 − (1 − s)³)/3 for s ≤ 1, 1/3 beyond            (biweight: Beaton & Tukey 1974)
/// truncated  ρ = min(s, 1)                                       (MSAC: Torr & Zisserman 2000)
/// ```
///
/// The weight of an observation is ρ′(s) (iteratively reweighted least squares).
///
/// ```
/// use collinear::numeric::robust_loss::RobustLoss;
///
/// // Huber (1964) at three scales: the weight is 1/3.
/// assert!((RobustLoss::Huber { scale: 2.0 }.weight(36.0) - 1.0 / 3.0).abs() < 1e-15);
/// // Tukey's biweight at half its scale: (1 − 1/4)².
/// assert_eq!(RobustLoss::Tukey { scale: 2.0 }.weight(1.0), 0.5625);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[non_exhaustive]
pub enum RobustLoss {
    /// Plain least squares.
    #[default]
    Squared,
    /// Linear growth beyond `scale`.
    Huber {
        /// The residual where the loss turns linear, in the residual's units.
        scale: f64,
    },
    /// Logarithmic growth.
    Cauchy {
        /// The residual whose weight is one half, in the residual's units.
        scale: f64,
    },
    /// A smooth descent to no growth at `scale`: 4.685 standard deviations leave 95 % of the efficiency of least squares.
    Tukey {
        /// The residual beyond which an observation has no say, in the residual's units.
        scale: f64,
    },
    /// No growth beyond `scale`: observations farther off have no say.
    Truncated {
        /// The residual beyond which an observation is ignored, in the residual's units.
        scale: f64,
    },
}

impl RobustLoss {
    /// Refuses a scale that is not a positive number.
    #[cfg(feature = "std")]
    pub(crate) fn check(&self) -> Result<(), Error> {
        match *self {
            Self::Huber { scale }
            | Self::Cauchy { scale }
            | Self::Tukey { scale }
            | Self::Truncated { scale } => {
                let what = "scale of a robust loss";
                if scale.is_nan() {
                    return Err(Error::NotFinite { what });
                }
                if !(scale > 0.0 && scale.is_finite()) {
                    let expected = "a positive number";
                    return Err(Error::OutOfRange { what, value: scale, expected });
                }
                Ok(())
            }
            Self::Squared => Ok(()),
        }
    }

    /// The loss of a squared residual, in squared units of the residual.
    #[must_use]
    pub fn cost(&self, squared: f64) -> f64 {
        match *self {
            Self::Squared => squared,
            Self::Huber { scale } => {
                let s = squared / (scale * scale);
                if s <= 1.0 { squared } else { scale * scale * (2.0 * float::sqrt(s) - 1.0) }
            }
            Self::Cauchy { scale } => scale * scale * float::ln_1p(squared / (scale * scale)),
            Self::Tukey { scale } => {
                // (1 − (1 − s)³)/3 without its cancellation.
                let s = (squared / (scale * scale)).min(1.0);
                scale * scale * s * (1.0 - s + s * s / 3.0)
            }
            Self::Truncated { scale } => squared.min(scale * scale),
        }
    }

    /// The weight ρ′ of an observation with this squared residual, in [0, 1].
    #[must_use]
    pub fn weight(&self, squared: f64) -> f64 {
        match *self {
            Self::Squared => 1.0,
            Self::Huber { scale } => {
                let s = squared / (scale * scale);
                if s <= 1.0 { 1.0 } else { 1.0 / float::sqrt(s) }
            }
            Self::Cauchy { scale } => 1.0 / (1.0 + squared / (scale * scale)),
            Self::Tukey { scale } => {
                let left = (1.0 - squared / (scale * scale)).max(0.0);
                left * left
            }
            Self::Truncated { scale } => f64::from(squared < scale * scale),
        }
    }
    /// A loss of the same scale that grows everywhere, to begin with where this one is flat beyond its scale.
    #[cfg(feature = "std")]
    pub(crate) fn monotone(&self) -> Option<Self> {
        match *self {
            Self::Tukey { scale } | Self::Truncated { scale } => Some(Self::Huber { scale }),
            Self::Squared | Self::Huber { .. } | Self::Cauchy { .. } => None,
        }
    }

    /// 2 s ρ″(s)/ρ′(s) at this squared residual: how far the loss bends from its tangent, 0 for the squared loss, −1 where it
    /// grows linearly with the residual. 0 where the weight is 0.
    #[cfg(feature = "std")]
    pub(crate) fn curvature(&self, squared: f64) -> f64 {
        match *self {
            Self::Squared | Self::Truncated { .. } => 0.0,
            Self::Huber { scale } => {
                if squared <= scale * scale {
                    0.0
                } else {
                    -1.0
                }
            }
            Self::Cauchy { scale } => -2.0 * squared / (scale * scale + squared),
            Self::Tukey { scale } => {
                let left = scale * scale - squared;
                if left > 0.0 { -4.0 * squared / left } else { 0.0 }
            }
        }
    }
}
