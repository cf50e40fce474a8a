//! A camera whose interior orientation is not to be estimated.

use nalgebra::{Matrix2x3, Point2, Point3, Vector3};

use super::{Adjustable, CentralModel, ParameterGroup, collinearity, no_group};
use crate::error::{Error, ProjectionError};

/// A central model without parameters: what an adjustment takes of a camera that it is to leave as it is, or whose model has
/// no partial derivatives of its own.
///
/// # Example
/// A camera behind a pointer, whose kind is known at run time only, can be oriented:
///
/// ```
/// use collinear::adjust::{ControlPoint, ResectionOptions, resect};
/// use collinear::camera::{CentralModel, Held, InteriorOrientation};
/// use nalgebra::{Point2, Point3};
/// use std::sync::Arc;
///
/// let camera: Arc<dyn CentralModel> = Arc::new(InteriorOrientation::new([1000.0; 2], Point2::origin(), 0.0)?);
/// // Seen from (0, 0, 10) straight down, y up the picture.
/// let control = [(1.0, 1.0, 0.0), (-2.0, 1.0, 0.0), (1.0, -1.0, 5.0), (-1.0, -2.0, 2.0)].map(|(x, y, z)| {
///     ControlPoint::new(Point3::new(x, y, z), Point2::new(1000.0 * x / (10.0 - z), -1000.0 * y / (10.0 - z)))
/// });
/// let found = resect(&Held(camera), &control, &ResectionOptions::default())?;
/// assert!((found.sensor.exterior.projection_center() - Point3::new(0.0, 0.0, 10.0)).norm() < 1e-12);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<C>(pub C);

impl<C: CentralModel> CentralModel for Held<C> {
    fn project_direction(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.0.project_direction(direction)
    }

    fn project_direction_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        self.0.project_direction_jacobian(direction)
    }

    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        self.0.direction(image)
    }
}

impl<C: CentralModel> Adjustable for Held<C> {
    fn parameter_group(&self, _: usize) -> Option<ParameterGroup> {
        None
    }

    fn parameters(&self, _: usize, _: &mut [f64]) {}

    fn adjust(&mut self, group: usize, _: &[f64]) -> Result<(), Error> {
        Err(no_group(group))
    }

    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        _: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        let (image, jacobian) = self.0.project_direction_jacobian(&object.coords)?;
        collinearity::write_rows(&jacobian, by_object);
        Ok(image)
    }
}
