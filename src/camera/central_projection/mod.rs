//! Central projections: from a direction to the image plane and back.
//!
//! The first link of a [`CentralCamera`](super::CentralCamera). The perspective of a normal lens is [`Gnomonic`]; a fisheye
//! bends a half-space or more into a disc, a panorama unrolls the sphere. Plane coordinates are in units of the principal
//! distance, x right and y down; near the axis all of them, panoramas included, are (X/Z, Y/Z).

mod division;
mod double_sphere;
mod enhanced_unified;
mod field_of_view;
mod fisheye;
mod gnomonic;
mod panorama;
mod radial;
mod unified;

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

pub use division::Division;
pub use double_sphere::DoubleSphere;
pub use enhanced_unified::EnhancedUnified;
pub use field_of_view::FieldOfView;
pub use fisheye::Fisheye;
pub use gnomonic::Gnomonic;
pub use panorama::Panorama;
pub use unified::UnifiedSphere;

use super::Parametrised;
use crate::error::ProjectionError;

/// From a direction to the image plane and back.
///
/// Directions are in camera axes (x right, y down, z forward) and of any positive length. Each projection is one to one on
/// its domain and refuses the rest.
pub trait CentralProjection: Parametrised {
    /// The plane point of a direction.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] and [`ProjectionError::OutsideDomain`] for a direction out of the domain,
    /// [`ProjectionError::NotFinite`].
    fn plane(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError>;

    /// The plane point with its partial derivatives ∂(x, y)/∂(X, Y, Z).
    ///
    /// # Errors
    /// As [`plane`](Self::plane).
    fn plane_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError>;

    /// The bare formula with its partial derivatives, beyond the domain too where it has a value there: X/Z and Y/Z of a
    /// direction behind a perspective camera, which are those of its antipode. By default as
    /// [`plane_jacobian`](Self::plane_jacobian).
    ///
    /// # Errors
    /// As [`plane`](Self::plane), for what the formula has no value.
    fn plane_formula_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        self.plane_jacobian(direction)
    }

    /// The direction, of unit length, of a plane point.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] for a point that no direction has, [`ProjectionError::NotFinite`].
    fn direction(&self, plane: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError>;

    /// ∂(x, y)/∂ of each parameter at a direction of the domain.
    fn parameter_partials(&self, direction: &Vector3<f64>, out: &mut [Vector2<f64>]);
}
