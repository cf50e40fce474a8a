//! The Earth's curvature in photographs that are worked up in a map system.

use nalgebra::{Point2, UnitVector3, Vector3};

use super::{Ray, moved};
use crate::camera::{CentralModel, Frame};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The Earth's curvature, of an aerial photograph that is worked up in a map system as if the Earth were flat.
///
/// A map system has easting and northing, lengths along the curved ground, beside the height, and treats the three as Cartesian. A
/// photograph obeys the collinearity equations in true Cartesian coordinates, where the ground falls away from the tangent plane: by
/// s²/2R, 20 cm at 1.6 km. **A picture shows points nearer to the nadir point than a flat Earth's would be, and the correction moves
/// them away from it.** The nadir point stays.
///
/// # Model
/// About the vertical of the projection centre, with the centre H above the sphere of radius R and the ground h above it, a ray at the
/// angle α from the nadir meets the ground at the angle θ from it at the Earth's centre, and the map has the point at (R + m) θ:
///
/// ```text
/// (R + h) sin(α + θ) = (R + H) sin α
/// tan α′ = (R + m) θ / (H − h)
/// ```
///
/// exact for every ray that meets the ground. m is the height at which the map's lengths are true: the ground's, if nothing else is said
/// ([`with_lengths_at`](Self::with_lengths_at)). The photogrammetric formula for vertical photographs is its first term:
///
/// ```text
/// r′ = r + (H − h) r³ / (2 R c²)
/// ```
///
/// which leaves out the reduction (R + m)/(R + h) of lengths to the map's height, the terms of (H − h)²/R², and the tilt of the
/// photograph: at 60° from the nadir from 9 km, 0.5 % of the correction.
///
/// # What it is not
/// A map projection has its own scale and convergence: what is left, across one photograph, is of the order s³/R². Where that matters, and
/// for whole blocks, work in a true Cartesian system instead ([`LocalFrame`](crate::geometry::geodetic::LocalFrame)), where
/// there is nothing to correct. Correct refraction first ([`Refraction`](super::Refraction)), then the curvature.
///
/// # Example
/// c = 152 mm, 3 km above ground, R = 6370 km, r = 130 mm: 3 · 130³ / (2 · 6370 · 152²) = 0.0224 mm.
///
/// ```
/// use collinear::camera::{EarthCurvature, ExteriorOrientation, Frame, InteriorOrientation};
/// use collinear::geometry::Affine2;
/// use collinear::geometry::rotation::OmegaPhiKappa;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let camera = InteriorOrientation::from_photogrammetric(152.0, Point2::origin(), &Affine2::identity())?;
/// let level = OmegaPhiKappa { omega: 0.0, phi: 0.0, kappa: 0.0 };
/// let exterior = ExteriorOrientation::from_omega_phi_kappa(Point3::new(0.0, 0.0, 3000.0), &level);
/// let frame = Frame::new(exterior, camera);
///
/// let curvature = EarthCurvature::new(6_370_000.0, 3000.0, 0.0)?;
/// let corrected = curvature.corrected(&frame, &Vector3::z_axis(), &Point2::new(0.0, 130.0))?;
/// assert!((corrected.y - 130.0224).abs() < 5e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("earth curvature", "flat earth"))]
pub struct EarthCurvature {
    /// Of the ground, from the Earth's centre.
    ground: f64,
    /// Of the camera above the ground.
    above: f64,
    /// At which the map's lengths are true, from the Earth's centre.
    map: f64,
    radius: f64,
}

impl EarthCurvature {
    /// For a sphere of this radius, and a camera and ground at these heights above it, all in world units. The sphere is the ellipsoid's
    /// osculating one at the place, √(M N), within 0.5 % of 6 371 km
    /// ([`meridian_radius`](crate::geometry::geodetic::Ellipsoid::meridian_radius),
    /// [`prime_vertical_radius`](crate::geometry::geodetic::Ellipsoid::prime_vertical_radius)).
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a radius that is not positive, ground at or below the sphere's centre, a camera
    /// that is not above the ground.
    pub fn new(radius: f64, camera_height: f64, ground_height: f64) -> Result<Self, Error> {
        for (what, value) in [
            ("radius of the Earth", radius),
            ("height of the camera", camera_height),
            ("height of the ground", ground_height),
        ] {
            if !value.is_finite() {
                return Err(Error::NotFinite { what });
            }
        }
        // The squares of the lengths must be numbers.
        if !(1e-100..=1e100).contains(&radius) {
            let (what, value) = ("radius of the Earth", radius);
            return Err(Error::OutOfRange { what, value, expected: "positive" });
        }
        let ground = radius + ground_height;
        if !(ground > 0.0) {
            let (what, value) = ("height of the ground", ground_height);
            return Err(Error::OutOfRange { what, value, expected: "above the Earth's centre" });
        }
        let above = camera_height - ground_height;
        if !(above > 0.0 && above <= 1e100) {
            let (what, value) = ("height of the camera", camera_height);
            return Err(Error::OutOfRange { what, value, expected: "above the ground" });
        }
        Ok(Self { ground, above, map: ground, radius })
    }

    /// For a map whose lengths are true at this height above the sphere: 0 for lengths reduced to sea level.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for a height at or below the sphere's centre.
    pub fn with_lengths_at(self, height: f64) -> Result<Self, Error> {
        let map = self.radius + height;
        if !map.is_finite() {
            return Err(Error::NotFinite { what: "height of the map" });
        }
        if !(map > 0.0) {
            return Err(Error::OutOfRange {
                what: "height of the map",
                value: height,
                expected: "above the Earth's centre",
            });
        }
        Ok(Self { map, ..self })
    }

    /// The direction in which the map system has what is seen in a direction: away from the nadir. Both from the projection centre, in
    /// any axes in which `up` is the vertical there; of unit length.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`], in radians, at and above the horizon of the curved ground; [`ProjectionError::NotFinite`].
    pub fn flat(
        &self,
        direction: &Vector3<f64>,
        up: &UnitVector3<f64>,
    ) -> Result<Vector3<f64>, ProjectionError> {
        let ray = Ray::new(direction, up)?;
        let center = self.ground + self.above;
        let along = center * ray.down;
        let rest = along * along - self.power();
        if !(ray.down > 0.0 && rest > 0.0) {
            return Err(ray.beyond(float::atan2(self.ground, float::sqrt(self.power()))));
        }
        // The nearer of the two points where the ray meets the sphere.
        let distance = self.power() / (along + float::sqrt(rest));
        let theta = float::atan2(distance * ray.sine, center - distance * ray.down);
        let by_sine = if ray.sine > 0.0 { theta / ray.sine } else { 0.0 };
        ray.with_tangent_times(self.map * by_sine * ray.down / self.above)
    }

    /// The direction in which a place of the map system is seen: the inverse of [`flat`](Self::flat).
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`], in radians, for places of the map at and beyond the horizon; [`ProjectionError::NotFinite`].
    pub fn curved(
        &self,
        direction: &Vector3<f64>,
        up: &UnitVector3<f64>,
    ) -> Result<Vector3<f64>, ProjectionError> {
        let ray = Ray::new(direction, up)?;
        let horizon = float::atan2(float::sqrt(self.power()), self.ground);
        let theta = ray.tangent() * self.above / self.map;
        if !(ray.down > 0.0 && theta < horizon) {
            return Err(ray.beyond(float::atan2(self.map * horizon, self.above)));
        }
        let half = float::sin(theta / 2.0);
        let depth = self.above + 2.0 * self.ground * half * half;
        let tangent = ray.tangent();
        let by_tangent = if tangent > 0.0 { float::sin(theta) / tangent } else { 0.0 };
        ray.with_tangent_times(self.ground * by_tangent / depth)
    }

    /// The image point (pixels) as it would be over a flat Earth, from the measured one; `up` is the vertical at the projection centre
    /// in world axes, [`Vector3::z_axis`] in a map system.
    ///
    /// # Errors
    /// As [`flat`](Self::flat), and those of the camera.
    pub fn corrected<C: CentralModel>(
        &self,
        frame: &Frame<C>,
        up: &UnitVector3<f64>,
        image: &Point2<f64>,
    ) -> Result<Point2<f64>, ProjectionError> {
        moved(frame, image, |direction| self.flat(direction, up))
    }

    /// The image point as the curved Earth gives it, from that of the map system: the inverse of [`corrected`](Self::corrected).
    ///
    /// # Errors
    /// As [`curved`](Self::curved), and those of the camera.
    pub fn displaced<C: CentralModel>(
        &self,
        frame: &Frame<C>,
        up: &UnitVector3<f64>,
        image: &Point2<f64>,
    ) -> Result<Point2<f64>, ProjectionError> {
        moved(frame, image, |direction| self.curved(direction, up))
    }

    /// (R + H)² − (R + h)², the square of the distance to the horizon.
    fn power(&self) -> f64 {
        self.above * (2.0 * self.ground + self.above)
    }
}
