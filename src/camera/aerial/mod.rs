//! What the air and the Earth's shape do to the image points of aerial photographs, about the vertical of the projection centre.

mod earth_curvature;
mod refraction;

use nalgebra::{Point2, UnitVector3, Vector3};

pub use earth_curvature::EarthCurvature;
pub use refraction::Refraction;

use super::{CentralModel, Frame, collinearity};
use crate::error::ProjectionError;
use crate::numeric::float;

/// A ray from the projection centre, taken apart about the vertical.
struct Ray {
    /// Downwards, cos α.
    down: f64,
    /// The horizontal part, of length sin α.
    across: Vector3<f64>,
    /// sin α.
    sine: f64,
    up: UnitVector3<f64>,
}

impl Ray {
    /// The parts of a direction of any positive length.
    fn new(direction: &Vector3<f64>, up: &UnitVector3<f64>) -> Result<Self, ProjectionError> {
        let scaled = direction / direction.amax();
        let unit = scaled / scaled.norm();
        let along = unit.dot(up);
        let across = unit - up.as_ref() * along;
        let sine = across.norm();
        if !(along.is_finite() && sine.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        Ok(Self { down: -along, across, sine, up: *up })
    }

    /// α, from the nadir.
    fn angle(&self) -> f64 {
        float::atan2(self.sine, self.down)
    }

    /// tan α, of a ray below the horizon.
    fn tangent(&self) -> f64 {
        self.sine / self.down
    }

    /// The direction, of unit length, whose tan α is so many times that of this one.
    fn with_tangent_times(&self, factor: f64) -> Result<Vector3<f64>, ProjectionError> {
        let direction = self.across * factor - self.up.as_ref() * self.down;
        let unit = direction / direction.norm();
        if unit.iter().all(|c| c.is_finite()) { Ok(unit) } else { Err(ProjectionError::NotFinite) }
    }

    /// The error of a ray that is not nearer to the nadir than `limit`.
    fn beyond(&self, limit: f64) -> ProjectionError {
        ProjectionError::OutsideDomain { value: self.angle(), limit }
    }
}

/// The image point whose ray is what `changed` makes of the ray of `image`.
fn moved<C: CentralModel>(
    frame: &Frame<C>,
    image: &Point2<f64>,
    changed: impl FnOnce(&Vector3<f64>) -> Result<Vector3<f64>, ProjectionError>,
) -> Result<Point2<f64>, ProjectionError> {
    let camera_from_world = frame.exterior.camera_from_world();
    let direction = camera_from_world.inverse_transform_vector(&frame.camera.direction(image)?);
    let changed = camera_from_world.transform_vector(&changed(&direction)?);
    collinearity::finite(frame.camera.project_direction(&changed)?)
}
