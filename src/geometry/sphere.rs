//! Spheres, and the part of one that a dome is.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::ray::Ray;
use super::surface::{Surface, unit_normal};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// A sphere: |X − C| = r. Above it is outside.
///
/// # Equation
/// ```text
/// X = O + t d,   t² + 2 b t + c = 0,   b = (O − C)·d,   c = |O − C|² − r²
/// ```
/// The discriminant is taken from the foot of the centre on the line of sight, and the root that would cancel from c and the
/// other one (Haines, Günther & Akenine-Möller 2019, "Precision improvements for ray/sphere intersection"): from a thousand radii away
/// the point is still on the sphere to rounding of its distance.
///
/// # Example
/// From (0, 0, 12) along (3, 0, −4)/5 a sphere of radius 10 about the origin is met where t² − 19.2 t + 44 = 0:
///
/// ```
/// use collinear::geometry::{Ray, Sphere, Surface};
/// use nalgebra::{Point3, Vector3};
///
/// let sphere = Sphere::new(Point3::origin(), 10.0)?;
/// let ray = Ray::new(Point3::new(0.0, 0.0, 12.0), Vector3::new(3.0, 0.0, -4.0))?;
/// let hit = sphere.meet_ray(&ray)?;
/// assert!((hit - Point3::new(1.5961556225046066, 0.0, 9.871792503327191)).norm() < 1e-14);
/// assert!((sphere.normal(&hit)?.z - 0.9871792503327191).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center: Point3<f64>,
    radius: f64,
}

impl Sphere {
    /// About the origin, of radius 1.
    pub const UNIT: Self = Self { center: Point3::new(0.0, 0.0, 0.0), radius: 1.0 };

    /// From centre and radius, world units.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for a radius that is not positive.
    pub fn new(center: Point3<f64>, radius: f64) -> Result<Self, Error> {
        if !center.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "centre of a sphere" });
        }
        if !(radius > 0.0 && radius.is_finite()) {
            let (what, expected) = ("radius of a sphere", "a finite number above 0");
            return Err(Error::OutOfRange { what, value: radius, expected });
        }
        Ok(Self { center, radius })
    }

    /// The centre.
    #[must_use]
    pub fn center(&self) -> Point3<f64> {
        self.center
    }

    /// The radius.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The distances along the ray's line at which it meets the sphere, the smaller first.
    fn crossings(&self, ray: &Ray) -> Option<[f64; 2]> {
        let offset = ray.origin - self.center;
        let along = offset.dot(&ray.direction);
        let across = (offset - ray.direction.into_inner() * along).norm();
        let squared = (self.radius - across) * (self.radius + across);
        if !(squared >= 0.0) {
            return None;
        }
        let half = float::sqrt(squared);
        // The root of the larger magnitude has no difference in it.
        let larger = if along < 0.0 { half - along } else { -along - half };
        let distance = offset.norm();
        let product = (distance - self.radius) * (distance + self.radius);
        let smaller = if larger == 0.0 { 0.0 } else { product / larger };
        Some([larger.min(smaller), larger.max(smaller)])
    }

    /// The first point in front of the ray's origin, or at it, that is wanted. A ray that begins on the sphere and goes in, as of a
    /// projector that stands on its dome, does not meet where it begins.
    fn first(
        &self,
        ray: &Ray,
        wanted: impl Fn(&Point3<f64>) -> bool,
    ) -> Result<Point3<f64>, ProjectionError> {
        let [near, far] = self.crossings(ray).ok_or(ProjectionError::MissesSurface)?;
        // What rounding of the origin and of the centre leaves of a distance of zero.
        let size = self.radius.max(self.center.coords.amax()).max(ray.origin.coords.amax());
        let none = |length: f64| length.abs() <= 8.0 * f64::EPSILON * size;
        let begins_on_it = none((ray.origin - self.center).norm() - self.radius);
        let goes_in = begins_on_it && none(near) && !none(far);
        let crossings = [near, far].into_iter().skip(usize::from(goes_in));
        let mut hits = crossings.filter(|t| *t >= 0.0).map(|t| ray.at(t));
        hits.find(|hit| hit.iter().all(|c| c.is_finite()) && wanted(hit))
            .ok_or(ProjectionError::MissesSurface)
    }
}

impl Surface for Sphere {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        (world - self.center).norm() - self.radius
    }

    /// From outside the near side, from inside the only one.
    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        self.first(ray, |_| true)
    }

    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        unit_normal(world - self.center)
    }
}

/// A dome: the part of a sphere within an angle of its axis, as a planetarium's screen.
///
/// Where the sphere is open a line of sight passes through: a projector outside, or below the rim, meets the far side.
///
/// # Example
/// A hemisphere of radius 10, open below. A projector under its rim shines past it on the opposite side:
///
/// ```
/// use collinear::geometry::{Dome, Ray, Surface};
/// use nalgebra::{Point3, Vector3};
///
/// let dome = Dome::new(Point3::origin(), 10.0, Vector3::z(), 90f64.to_radians())?;
/// let projector = Point3::new(-10.0, 0.0, -20.0);
/// let hit = dome.meet_ray(&Ray::new(projector, Vector3::new(1.0, 0.0, 2.0))?)?;
/// // X = −10 + s, Z = −20 + 2s: 5 s² − 100 s + 400 = 0.
/// assert!((hit - Point3::new(-10.0 + 14.47213595499958, 0.0, 8.94427190999916)).norm() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("planetarium", "hemisphere", "spherical cap"))]
pub struct Dome {
    sphere: Sphere,
    axis: UnitVector3<f64>,
    half_angle: f64,
    cosine: f64,
}

impl Dome {
    /// From the sphere's centre and radius (world units), the direction of the dome's middle, of any length, and the angle from there
    /// to the rim as seen from the centre: radians, π/2 for a hemisphere.
    ///
    /// # Errors
    /// As [`Sphere::new`]; [`Error::Degenerate`] for an axis without a direction, [`Error::OutOfRange`] for an angle that is not
    /// above 0 and at most π.
    pub fn new(
        center: Point3<f64>,
        radius: f64,
        axis: Vector3<f64>,
        half_angle: f64,
    ) -> Result<Self, Error> {
        let sphere = Sphere::new(center, radius)?;
        if !(half_angle > 0.0 && half_angle <= core::f64::consts::PI) {
            let (what, expected) = ("half angle of a dome", "above 0, at most π");
            return Err(Error::OutOfRange { what, value: half_angle, expected });
        }
        let axis = Ray::new(center, axis).map_err(|e| match e {
            Error::Degenerate { measure, limit, .. } => {
                Error::Degenerate { what: "axis of a dome", measure, limit }
            }
            _ => Error::NotFinite { what: "axis of a dome" },
        })?;
        let cosine = float::sin_cos(half_angle).1;
        Ok(Self { sphere, axis: axis.direction, half_angle, cosine })
    }

    /// The whole sphere.
    #[must_use]
    pub fn sphere(&self) -> &Sphere {
        &self.sphere
    }

    /// The direction of the dome's middle from the centre, of unit length.
    #[must_use]
    pub fn axis(&self) -> UnitVector3<f64> {
        self.axis
    }

    /// The angle from the axis to the rim, radians.
    #[must_use]
    pub fn half_angle(&self) -> f64 {
        self.half_angle
    }

    /// Whether the direction of a point from the centre is within the rim.
    fn covers(&self, world: &Point3<f64>) -> bool {
        let offset = world - self.sphere.center;
        // A whole sphere has no rim to be beyond by rounding.
        self.cosine <= -1.0 || self.axis.dot(&offset) >= self.cosine * offset.norm()
    }
}

impl Surface for Dome {
    /// NaN below the rim, as seen from the centre.
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        if self.covers(world) { self.sphere.height_above(world) } else { f64::NAN }
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        self.sphere.first(ray, |hit| self.covers(hit))
    }

    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        self.sphere.normal(world)
    }
}
