//! Space and its projections: planes and rays, rotations and poses, projection matrices, homographies, the Earth.
//!
//! Everything is `f64`. Right-handed frames, radians, column vectors; a transformation is named `<to>_from_<from>`.
//!
#![doc = include_str!("../../docs/figures/geometry.svg")]

pub mod affine;
pub mod geodetic;
pub mod homography;
mod plane;
pub(crate) mod pose;
pub mod projection;
mod ray;
pub mod rotation;
mod surface;

pub use affine::Affine2;
pub use homography::Homography;
pub use plane::{Plane, PlaneFit};
pub use pose::Pose;
pub use ray::{HeightCurve, Locus, Ray};
pub use surface::Surface;
