//! Cameras and points from measurements, by least squares, with a report of how good they are.
//!
//! Every estimator minimises the weighted sum of squared residuals vᵀPv of what was observed, P the inverse of the
//! observations' covariance: the maximum-likelihood answer where errors are normal. What it found comes with a
//! [`Report`]: the residuals, σ₀, the covariance of the unknowns, and for each observation how far the others control it.
//!
#![doc = include_str!("../../docs/figures/adjust.svg")]
//!
//! | known | sought | |
//! | --- | --- | --- |
//! | places of points, their images | the camera's pose, perhaps its interior and lens | [`resect`], [`resect_from`], [`resect_robust`] |
//! | the same, exactly as many as needed | every pose | [`p3p`], [`p4pf`] with the principal distance |
//! | the same, without any camera | the projection matrix | [`dlt`] |
//! | cameras and images | the point | [`intersect`], [`nearest_point`] |
//! | images of the same points in two cameras | the motion between them | [`relative_orientation`], [`five_point`] |
//! | points in two frames | the similarity | [`absolute_orientation`] |
//! | images, and whatever else was observed | cameras, poses and points at once | [`bundle`] |
//!
//! What σ₀, redundancy numbers and w mean: [`_adjustment`](crate::_adjustment).

mod absolute_orientation;
mod agreement;
pub mod bundle;
mod dlt;
mod five_point;
mod intersection;
mod p3p;
mod p4pf;
mod precision;
mod relative_orientation;
mod report;
mod resection;
mod roots;
mod settle;
mod unknowns;

pub use absolute_orientation::{
    AbsoluteOrientation, AbsoluteOrientationOptions, PointPair, absolute_orientation,
};
pub use dlt::{DltCamera, dlt};
pub use five_point::{MotionRoots, five_point};
pub use intersection::{
    ImageObservation, Intersection, IntersectionOptions, NearestPoint, intersect, nearest_point,
};
pub use p3p::{PoseRoots, p3p};
pub use p4pf::{FocalPose, p4pf};
pub use precision::Precision;
pub use relative_orientation::{
    ImagePair, RelativeOrientation, RelativeOrientationOptions, RobustRelativeOrientation,
    relative_orientation, relative_orientation_robust,
};
pub use report::{CRITICAL_VALUE, NONCENTRALITY, ObservationReport, Report};
pub use resection::{
    ControlPoint, OtherPose, Resection, ResectionOptions, RobustResection, resect, resect_from,
    resect_robust,
};
pub use roots::Roots;
pub use unknowns::Unknown;
