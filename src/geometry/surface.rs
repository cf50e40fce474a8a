//! What a line of sight can meet.

use alloc::boxed::Box;
use alloc::sync::Arc;

use nalgebra::{Point3, UnitVector3, Vector3};

use super::ray::{HeightCurve, Locus, Ray};
use crate::error::ProjectionError;

/// A surface of the world: a plane, an ellipsoid, a height field.
///
/// The trait is object-safe, so that a sensor can be asked for the ground point on any surface.
///
/// # Example
/// The locus of a sensor without a projection centre, (10 + 2 (h − 100), 0, h), on the level plane z = 104:
///
/// ```
/// use collinear::geometry::{HeightCurve, Locus, Plane, Surface};
/// use nalgebra::{Point3, Vector3};
///
/// let curve = HeightCurve {
///     coefficients: [Vector3::new(10.0, 0.0, 100.0), Vector3::new(2.0, 0.0, 1.0), Vector3::zeros(), Vector3::zeros()],
///     reference_height: 100.0,
///     heights: [90.0, 120.0],
///     error_bound: 0.0,
/// };
/// let terrace = Plane::from_point_and_normal(Point3::new(0.0, 0.0, 104.0), Vector3::z())?;
/// let surface: &dyn Surface = &terrace;
/// let hit = surface.meet(&Locus::Curve(curve))?;
/// assert!((hit - Point3::new(18.0, 0.0, 104.0)).norm() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Surface: core::fmt::Debug + Send + Sync {
    /// A function that is zero on the surface, positive above it and negative below, in world units near the surface;
    /// NaN where the surface is not defined.
    fn height_above(&self, world: &Point3<f64>) -> f64;

    /// The first point of the surface along the ray.
    ///
    /// # Errors
    /// [`ProjectionError::MissesSurface`] where there is none in front of the ray's origin.
    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError>;

    /// The highest point of the curve that lies on the surface.
    ///
    /// # Errors
    /// [`ProjectionError::MissesSurface`] where the curve does not cross the surface within its interval.
    fn meet_curve(&self, curve: &HeightCurve) -> Result<Point3<f64>, ProjectionError> {
        first_crossing(curve, |p| self.height_above(p))
    }

    /// The point of the surface on a locus of either kind.
    ///
    /// # Errors
    /// As [`meet_ray`](Self::meet_ray) and [`meet_curve`](Self::meet_curve).
    fn meet(&self, locus: &Locus) -> Result<Point3<f64>, ProjectionError> {
        match locus {
            Locus::Ray(ray) => self.meet_ray(ray),
            Locus::Curve(curve) => self.meet_curve(curve),
        }
    }

    /// The normal at a point of the surface, of unit length, pointing above it.
    ///
    /// By default the gradient of [`height_above`](Self::height_above) by central differences over 6·10⁻⁶ of the largest
    /// coordinate (at least 6·10⁻⁶ units): to eight digits where the surface is smooth over that length. Planes, spheres, domes,
    /// meshes and ellipsoids have theirs in closed form.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`] where there is none.
    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        // ∛ε balances the truncation of the differences against their rounding.
        let step = 6.055e-6 * world.coords.amax().max(1.0);
        let gradient = Vector3::from_fn(|i, _| {
            let offset = Vector3::ith(i, step);
            self.height_above(&(world + offset)) - self.height_above(&(world - offset))
        });
        unit_normal(gradient)
    }
}

/// A vector at unit length.
pub(super) fn unit_normal(vector: Vector3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
    let length = vector.norm();
    if length > 0.0 && length.is_finite() {
        Ok(UnitVector3::new_unchecked(vector / length))
    } else {
        Err(ProjectionError::NotFinite)
    }
}

/// A surface behind a pointer is that surface.
macro_rules! behind_a_pointer {
    ($($pointer:ty),*) => {$(
        impl<S: Surface + ?Sized> Surface for $pointer {
            fn height_above(&self, world: &Point3<f64>) -> f64 {
                (**self).height_above(world)
            }
            fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
                (**self).meet_ray(ray)
            }
            fn meet_curve(&self, curve: &HeightCurve) -> Result<Point3<f64>, ProjectionError> {
                (**self).meet_curve(curve)
            }
            fn meet(&self, locus: &Locus) -> Result<Point3<f64>, ProjectionError> {
                (**self).meet(locus)
            }
            fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
                (**self).normal(world)
            }
        }
    )*};
}

behind_a_pointer!(&S, Box<S>, Arc<S>);

/// The steps in which a curve is searched from its top for a change of sign.
const STEPS: u32 = 64;

/// Searches the curve from above for the first change of sign, then closes in on it to neighbouring floats.
fn first_crossing(
    curve: &HeightCurve,
    height_above: impl Fn(&Point3<f64>) -> f64,
) -> Result<Point3<f64>, ProjectionError> {
    let [low, high] = curve.heights;
    let at = |k: u32| high + (low - high) * (f64::from(k) / f64::from(STEPS));
    let mut above = at(0);
    let mut above_value = height_above(&curve.at(above));
    for k in 1..=STEPS {
        let below = at(k);
        let value = height_above(&curve.at(below));
        // From either side, as a ray meets it: a plane may face down.
        let sign = if above_value >= 0.0 && value <= 0.0 { 1.0 } else { -1.0 };
        if sign > 0.0 || (above_value <= 0.0 && value >= 0.0) {
            let height = crossing([above, below], [above_value, value].map(|v| sign * v), |h| {
                sign * height_above(&curve.at(h))
            });
            return Ok(curve.at(height));
        }
        (above, above_value) = (below, value);
    }
    Err(ProjectionError::MissesSurface)
}

/// Where a function that is not negative at the first end changes its sign: regula falsi after Illinois (Dowell & Jarratt 1971), with
/// a bisection every third time, so that a jump is found too.
fn crossing(ends: [f64; 2], values: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    let ([mut a, mut b], [mut fa, mut fb]) = (ends, values);
    // The end that stayed in the last round; of one that stays twice the value is halved.
    let mut stayed = None;
    for round in 1_u32.. {
        let middle = 0.5 * (a + b);
        let between = |h: f64| h > a.min(b) && h < a.max(b);
        if !between(middle) {
            return middle;
        }
        let secant = b - fb * ((b - a) / (fb - fa));
        let h = if round % 3 != 0 && between(secant) { secant } else { middle };
        let f = value(h);
        if f > 0.0 {
            (a, fa) = (h, f);
            if stayed == Some(1) {
                fb *= 0.5;
            }
            stayed = Some(1);
        } else if f == 0.0 {
            return h;
        } else {
            (b, fb) = (h, f);
            if stayed == Some(0) {
                fa *= 0.5;
            }
            stayed = Some(0);
        }
    }
    0.5 * (a + b)
}
