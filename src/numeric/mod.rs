//! Numbers without geometry: least squares, robust losses, consensus, small polynomials.
//!
//! [`least_squares`] is the Levenberg–Marquardt driver that every estimator of the crate runs, [`robust_loss`] the
//! losses it can weigh residuals with, [`consensus`] the robust search for a model that most observations agree on.
//!
#![doc = include_str!("../../docs/figures/numeric.svg")]

pub mod consensus;
pub(crate) mod float;
pub mod least_squares;
pub(crate) mod polynomial;
pub mod robust_loss;
pub(crate) mod scalar;
pub(crate) mod triangular;
pub(crate) mod twofold;
mod vector;

pub(crate) use vector::vectorised;
#[cfg(feature = "std")]
pub(crate) use vector::vectorised_by_half;
