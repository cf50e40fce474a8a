//! The surface at a constant height above the geoid.

use nalgebra::Point3;

use super::ellipsoid::Ellipsoid;
use super::geoid::GeoidGrid;
use super::position::{EllipsoidalHeight, OrthometricHeight};
use crate::error::{Error, ProjectionError};
use crate::geometry::ray::Ray;
use crate::geometry::surface::Surface;

/// The points at one height above a geoid, in geocentric coordinates.
///
/// A ray is met at the ellipsoidal height H + N, with the undulation N where the last height led, until it settles.
///
/// *Accuracy*: the height of the point returned is within 10⁻⁸ m.
///
/// *Domain*: where the geoid grid has values; [`height_above`](Surface::height_above) is NaN elsewhere, and a ray that
/// leaves the grid meets nothing.
///
/// ```
/// use collinear::geometry::geodetic::{ConstantOrthometric, Ellipsoid, GeoidGrid, GeoidLayout, OrthometricHeight};
/// use collinear::geometry::{Ray, Surface};
/// use nalgebra::{Point3, Vector3};
///
/// // A geoid 40 m above the ellipsoid, seen down the x axis.
/// let layout = GeoidLayout {
///     south_deg: -1.0, west_deg: -1.0, latitude_step_deg: 1.0, longitude_step_deg: 1.0, rows: 3, columns: 3,
/// };
/// let geoid = GeoidGrid::new(layout, vec![40.0; 9])?;
/// let surface = ConstantOrthometric::new(Ellipsoid::WGS84, geoid, OrthometricHeight(100.0))?;
/// let ray = Ray::new(Point3::new(7e6, 0.0, 0.0), Vector3::new(-1.0, 0.0, 0.0))?;
/// assert!((surface.meet_ray(&ray)?.x - 6_378_277.0).abs() < 1e-8);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantOrthometric {
    ellipsoid: Ellipsoid,
    geoid: GeoidGrid,
    height: OrthometricHeight,
}

/// The rounds in which the height settles; three are usual, grazing rays need more.
const MAX_ITERATIONS: u32 = 100;

/// How far a settled height may be from H + N, in metres.
const TOLERANCE: f64 = 1e-8;

impl ConstantOrthometric {
    /// The surface at `height` above the geoid, whose undulations count from the ellipsoid.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`] for a height that is not within ±10⁷ m.
    pub fn new(
        ellipsoid: Ellipsoid,
        geoid: GeoidGrid,
        height: OrthometricHeight,
    ) -> Result<Self, Error> {
        let value = height.0;
        if !value.is_finite() {
            return Err(Error::NotFinite { what: "height" });
        }
        if value.abs() > 1e7 {
            return Err(Error::OutOfRange { what: "height", value, expected: "within ±10⁷ m" });
        }
        // Refused here, so that a ray only meets heights that the ellipsoid takes.
        ellipsoid.at_height(EllipsoidalHeight(value))?;
        Ok(Self { ellipsoid, geoid, height })
    }

    /// The height.
    #[must_use]
    pub fn height(&self) -> OrthometricHeight {
        self.height
    }

    /// H + N below or above a point.
    fn ellipsoidal(&self, world: &Point3<f64>) -> Result<f64, ProjectionError> {
        let place = self.ellipsoid.geodetic_from_geocentric(world)?;
        let undulation = self.geoid.undulation(place.latitude(), place.longitude());
        undulation.map(|n| self.height.0 + n).map_err(|_| ProjectionError::MissesSurface)
    }
}

impl Surface for ConstantOrthometric {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        let place = self.ellipsoid.geodetic_from_geocentric(world);
        match (place, self.ellipsoidal(world)) {
            (Ok(place), Ok(surface)) => place.height().0 - surface,
            _ => f64::NAN,
        }
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        let mut height = self.height.0;
        let mut change = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let surface = self
                .ellipsoid
                .at_height(EllipsoidalHeight(height))
                .map_err(|_| ProjectionError::MissesSurface)?;
            let hit = surface.meet_ray(ray)?;
            let next = self.ellipsoidal(&hit)?;
            let last = change;
            change = (next - height).abs();
            if change == 0.0 || (change >= last && last <= TOLERANCE) {
                return Ok(hit);
            }
            height = next;
        }
        Err(ProjectionError::NotConverged { iterations: MAX_ITERATIONS, residual: change })
    }
}
