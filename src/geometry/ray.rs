//! Half-lines, and the curves that stand in for them where a sensor has no ray.

use nalgebra::{Point3, UnitVector3, Vector3};

use super::surface::Surface;
use crate::error::{Error, ProjectionError};

/// A half-line in the world: origin + t · direction, t ≥ 0.
///
/// The direction has unit length, so t is a distance in world units.
///
/// ```
/// use collinear::geometry::Ray;
/// use nalgebra::{Point3, Vector3};
///
/// // Three and four make five.
/// let ray = Ray::new(Point3::new(1.0, 1.0, 1.0), Vector3::new(30.0, 40.0, 0.0))?;
/// assert!((ray.at(5.0) - Point3::new(4.0, 5.0, 1.0)).norm() < 1e-15);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts: for a camera its projection centre.
    pub origin: Point3<f64>,
    /// Where it goes.
    pub direction: UnitVector3<f64>,
}

impl Ray {
    /// A ray along any non-zero vector.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for NaN or infinite coordinates, [`Error::Degenerate`] for a direction of length zero.
    pub fn new(origin: Point3<f64>, direction: Vector3<f64>) -> Result<Self, Error> {
        if !(origin.coords + direction).iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "ray" });
        }
        // Scaled by the largest entry first: the square of a tiny vector must not vanish.
        let largest = direction.amax();
        if largest == 0.0 {
            return Err(Error::Degenerate { what: "ray direction", measure: 0.0, limit: 0.0 });
        }
        Ok(Self { origin, direction: UnitVector3::new_normalize(direction / largest) })
    }

    /// The point at distance `t` from the origin.
    #[must_use]
    pub fn at(&self, t: f64) -> Point3<f64> {
        self.origin + self.direction.into_inner() * t
    }

    /// The first point of a surface along the ray; failing that, the first against it. For parallel projections, whose lines of sight
    /// begin nowhere.
    pub(crate) fn meet_either_way(
        &self,
        surface: &dyn Surface,
    ) -> Result<Point3<f64>, ProjectionError> {
        surface.meet_ray(self).or_else(|_| {
            surface.meet_ray(&Self { origin: self.origin, direction: -self.direction })
        })
    }
}

/// The points of the world that one image point may show, parametrised by height.
///
/// A rational polynomial camera has no projection centre: the points that image at one pixel form a curve. It is given
/// as a cubic in the parameter h over the interval where it holds,
/// X(h) = c₀ + c₁ s + c₂ s² + c₃ s³ with s = h − h₀, and `error_bound` says how far it may be from the sensor's own
/// equations.
///
/// # Example
/// A line of sight that leans by 3 in 4 and bends by 10⁻³ s², on a terrace at 20: s = 10, x = 7.5 + 0.1.
///
/// ```
/// use collinear::geometry::{HeightCurve, Plane, Surface};
/// use nalgebra::{Point3, Vector3};
///
/// let curve = HeightCurve {
///     coefficients: [
///         Vector3::new(0.0, 0.0, 10.0),
///         Vector3::new(0.75, 0.0, 1.0),
///         Vector3::new(1e-3, 0.0, 0.0),
///         Vector3::zeros(),
///     ],
///     reference_height: 10.0,
///     heights: [0.0, 50.0],
///     error_bound: 1e-6,
/// };
/// let terrace = Plane::from_point_and_normal(Point3::new(0.0, 0.0, 20.0), Vector3::z())?;
/// assert!((terrace.meet_curve(&curve)? - Point3::new(7.6, 0.0, 20.0)).norm() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightCurve {
    /// c₀ to c₃, in world units.
    pub coefficients: [Vector3<f64>; 4],
    /// h₀, where the curve was developed.
    pub reference_height: f64,
    /// Lowest and highest h for which the curve holds.
    pub heights: [f64; 2],
    /// The largest distance from the exact locus within that interval, in world units.
    pub error_bound: f64,
}

impl HeightCurve {
    /// The point at height parameter `h`.
    #[must_use]
    pub fn at(&self, h: f64) -> Point3<f64> {
        let [c0, c1, c2, c3] = self.coefficients;
        let s = h - self.reference_height;
        Point3::from(c0 + (c1 + (c2 + c3 * s) * s) * s)
    }
}

/// Where in the world an image point comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Locus {
    /// A straight line of sight.
    Ray(Ray),
    /// A curve over height.
    Curve(HeightCurve),
}
