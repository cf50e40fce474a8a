//! Cameras and points from measurements, by least squares, with a report of how good they are.
//!
//! Every estimator minimises the weighted sum of squared residuals vᵀPv of what was observed, P the inverse of the
//! observations' covariance: the maximum-likelihood answer where errors are normal. What it found comes with a
//! [`Report`]: the residuals, σ₀, the covariance of the unknowns, and for each observation how far the others control it.

pub mod bundle;
mod precision;
mod report;
mod unknowns;

pub use precision::Precision;
pub use report::{CRITICAL_VALUE, NONCENTRALITY, ObservationReport, Report};
pub use unknowns::Unknown;
