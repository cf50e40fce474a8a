//! Space and its projections: planes and rays, rotations and poses, projection matrices, homographies, the Earth.
//!
//! Everything is `f64`. Right-handed frames, radians, column vectors; a transformation is named `<to>_from_<from>`.
//!
#![doc = include_str!("../../docs/figures/geometry.svg")]

pub mod affine;
pub mod geodetic;
pub mod homography;
pub mod mesh;
mod plane;
pub(crate) mod pose;
pub mod projection;
mod ray;
pub mod rotation;
mod similarity;
mod sphere;
mod surface;

pub use affine::Affine2;
pub use homography::Homography;
pub use mesh::TriangleMesh;
pub(crate) use plane::axes;
pub use plane::{Plane, PlaneFit};
pub use pose::Pose;
pub use ray::{HeightCurve, Locus, Ray};
pub use similarity::Similarity;
pub use sphere::{Dome, Sphere};
pub use surface::Surface;
