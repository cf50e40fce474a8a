//! The central perspective.

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

use super::CentralProjection;
use crate::camera::{collinearity, parameters};
use crate::error::ProjectionError;

/// The central perspective, as of a pinhole: straight lines stay straight.
///
#[doc = include_str!("../../../docs/figures/lenses/gnomonic.svg")]
///
/// # Model
/// ```text
/// x = X/Z,   y = Y/Z                                                        [WD] eq. 4a
/// ```
/// # Domain
/// Z > 0.
///
/// # Example
/// ```
/// use collinear::camera::{CentralProjection, Gnomonic};
/// use nalgebra::{Point2, Vector3};
///
/// assert_eq!(Gnomonic.plane(&Vector3::new(1.0, -3.0, 4.0))?, Point2::new(0.25, -0.75));
/// # Ok::<(), collinear::ProjectionError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(alias("pinhole", "perspective", "rectilinear"))]
pub struct Gnomonic;

parameters::no_parameters!(Gnomonic, "central perspective");

impl CentralProjection for Gnomonic {
    #[inline]
    fn plane(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        collinearity::normalised_point(direction)
    }

    #[inline]
    fn plane_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let plane = collinearity::normalised_point(direction)?;
        Ok((plane, collinearity::normalised_jacobian(&plane, direction.z)))
    }

    #[inline]
    fn plane_formula_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        if !(direction.z < 0.0) {
            return self.plane_jacobian(direction);
        }
        // The antipode has the same image and the opposite slopes.
        let (plane, jacobian) = self.plane_jacobian(&-direction)?;
        Ok((plane, -jacobian))
    }

    #[inline]
    fn direction(&self, plane: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        Ok(collinearity::unit_direction(&collinearity::finite(*plane)?))
    }

    fn parameter_partials(&self, _: &Vector3<f64>, _: &mut [Vector2<f64>]) {}
}
