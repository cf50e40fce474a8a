//! The surface at a constant height above an ellipsoid.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::ellipsoid::Ellipsoid;
use super::position::EllipsoidalHeight;
use crate::error::{Error, ProjectionError};
use crate::geometry::ray::Ray;
use crate::geometry::surface::Surface;
use crate::numeric::float;
use crate::numeric::polynomial::quadratic_roots;

/// The points at one height above an ellipsoid, in geocentric coordinates.
///
/// It is not the ellipsoid with semi-axes a + h and b + h: on WGS84 at 45° that one lies 14 mm lower at h = 10 km, and
/// 0.77 m lower at h = 600 km.
///
/// Along a straight line the height above a convex body is a convex function of the distance, so Newton's method,
/// started outside, approaches the first point without passing it, and shows by the sign of the slope that there is
/// none. It starts at the quadric.
///
/// *Accuracy*: the height of the point returned is within 2 ε (|origin| + a + |h|), 6 nm near the Earth. A ray that
/// starts on the surface, or grazes it, within that distance meets it.
///
/// *Domain*: rays from within 10⁶ a of the centre.
///
/// ```
/// use collinear::geometry::geodetic::{Ellipsoid, EllipsoidalHeight};
/// use collinear::geometry::{Ray, Surface};
/// use nalgebra::{Point3, UnitVector3, Vector3};
///
/// // Down the equator's plane from 8000 km to 1000 m above it.
/// let surface = Ellipsoid::WGS84.at_height(EllipsoidalHeight(1000.0))?;
/// let ray = Ray::new(Point3::new(8e6, 0.0, 0.0), Vector3::new(-1.0, 0.0, 0.0))?;
/// assert!((surface.meet_ray(&ray)?.x - 6_379_137.0).abs() < 1e-8);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantHeight {
    ellipsoid: Ellipsoid,
    height: f64,
}

/// Farther than this many semi-major axes a ray's points are too coarse to lie on a surface of the Earth's size.
const FARTHEST: f64 = 1e6;

/// A grazing ray halves its distance at each step; 60 steps go from 10⁹ m to 10⁻⁹ m.
const MAX_ITERATIONS: u32 = 100;

impl ConstantHeight {
    pub(super) fn new(ellipsoid: Ellipsoid, height: EllipsoidalHeight) -> Result<Self, Error> {
        let value = height.0;
        if !value.is_finite() {
            return Err(Error::NotFinite { what: "height" });
        }
        if value <= -ellipsoid.semi_minor_axis() || value > FARTHEST * ellipsoid.semi_major_axis() {
            return Err(Error::OutOfRange {
                what: "height",
                value,
                expected: "above −b, to 10⁶ a",
            });
        }
        Ok(Self { ellipsoid, height: value })
    }

    /// The ellipsoid.
    #[must_use]
    pub fn ellipsoid(&self) -> Ellipsoid {
        self.ellipsoid
    }

    /// The height.
    #[must_use]
    pub fn height(&self) -> EllipsoidalHeight {
        EllipsoidalHeight(self.height)
    }

    /// Height above the surface at distance t along the ray, and its derivative by t: the cosine of the angle between
    /// ray and normal.
    fn along(&self, ray: &Ray, t: f64) -> Result<(f64, f64), ProjectionError> {
        let geodetic = self.ellipsoid.geodetic_from_geocentric(&ray.at(t))?;
        let up = Ellipsoid::normal(geodetic.latitude(), geodetic.longitude());
        Ok((geodetic.height().0 - self.height, up.dot(&ray.direction)))
    }

    /// The distances at which the line of the ray meets the quadric with semi-axes a + h and b + h.
    fn quadric(&self, ray: &Ray) -> Option<[f64; 2]> {
        let across = self.ellipsoid.semi_major_axis() + self.height;
        let along = self.ellipsoid.semi_minor_axis() + self.height;
        let scale = Vector3::new(across, across, along);
        let o = ray.origin.coords.component_div(&scale);
        let d = ray.direction.component_div(&scale);
        quadratic_roots(d.dot(&d), 2.0 * o.dot(&d), o.dot(&o) - 1.0)
    }

    /// Newton's method from `start`, from the side on which it does not pass the root: `sense` is −1 where the ray
    /// comes from above, 1 where it comes from below. `None` where it finds itself on the wrong side of the minimum.
    fn newton(
        &self,
        ray: &Ray,
        start: f64,
        sense: f64,
        resolution: f64,
    ) -> Result<Option<Point3<f64>>, ProjectionError> {
        let mut t = start;
        let mut residual = f64::INFINITY;
        for step in 0..MAX_ITERATIONS {
            let (value, slope) = self.along(ray, t)?;
            residual = value;
            if slope * sense <= 0.0 {
                return Ok((value.abs() <= resolution).then(|| ray.at(t)));
            }
            let next = t - value / slope;
            // Only the first step may come from the surface's far side; later ones do so by rounding, at the end.
            let passed = step > 0 && value < 0.0;
            if passed || (next - t).abs() <= f64::EPSILON * t.abs() {
                return Ok(Some(ray.at(t)));
            }
            t = next;
        }
        if residual.abs() <= resolution {
            return Ok(Some(ray.at(t)));
        }
        Err(ProjectionError::NotConverged { iterations: MAX_ITERATIONS, residual })
    }
}

impl Surface for ConstantHeight {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        match self.ellipsoid.geodetic_from_geocentric(world) {
            Ok(geodetic) => geodetic.height().0 - self.height,
            Err(_) => f64::NAN,
        }
    }

    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        let place = self.ellipsoid.geodetic_from_geocentric(world)?;
        Ok(Ellipsoid::normal(place.latitude(), place.longitude()))
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        let a = self.ellipsoid.semi_major_axis();
        let distance = float::hypot(float::hypot(ray.origin.x, ray.origin.y), ray.origin.z);
        if distance.is_nan() {
            return Err(ProjectionError::NotFinite);
        }
        if distance > FARTHEST * a {
            return Err(ProjectionError::OutsideDomain { value: distance, limit: FARTHEST * a });
        }
        let reach = distance + a + self.height.abs();
        let resolution = 2.0 * f64::EPSILON * reach;
        let (value, slope) = self.along(ray, 0.0)?;
        if value.abs() <= resolution {
            return Ok(ray.origin);
        }
        let quadric = self.quadric(ray);
        let hit = if value < 0.0 {
            let start = quadric.map_or(reach, |[_, last]| last.max(0.0));
            match self.newton(ray, start, 1.0, resolution)? {
                Some(hit) => Some(hit),
                None => self.newton(ray, reach, 1.0, resolution)?,
            }
        } else if slope >= 0.0 {
            None
        } else {
            let start = quadric.map_or(0.0, |[first, _]| first.max(0.0));
            match self.newton(ray, start, -1.0, resolution)? {
                Some(hit) => Some(hit),
                None if start > 0.0 => self.newton(ray, 0.0, -1.0, resolution)?,
                None => None,
            }
        };
        hit.ok_or(ProjectionError::MissesSurface)
    }
}
