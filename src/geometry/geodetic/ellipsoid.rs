//! Ellipsoids of revolution, and the way between geodetic and geocentric coordinates.

use core::f64::consts::FRAC_PI_2;

use nalgebra::{Point3, UnitVector3, Vector3};

use super::constant_height::ConstantHeight;
use super::position::{EllipsoidalHeight, Geodetic};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::twofold::Twofold;

/// An ellipsoid of revolution, flattened at the poles or a sphere.
///
/// ```text
/// b = a (1 − f),   e² = f (2 − f),   e′² = e² / (1 − e²)
/// ```
///
/// ```
/// use collinear::geometry::geodetic::Ellipsoid;
///
/// // Moritz (1980), Geodetic Reference System 1980: b and e² as published.
/// assert!((Ellipsoid::GRS80.semi_minor_axis() - 6_356_752.3141).abs() < 5e-5);
/// assert!((Ellipsoid::GRS80.eccentricity_squared() - 0.006_694_380_022_90).abs() < 5e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("spheroid", "datum"))]
pub struct Ellipsoid {
    semi_major: f64,
    flattening: f64,
}

/// The iterations in which the foot of a point is sought; four are usual, the rest are for points of the evolute.
const MAX_ITERATIONS: u32 = 100;

impl Ellipsoid {
    /// World Geodetic System 1984: a = 6 378 137 m, 1/f = 298.257 223 563 (EPSG 7030).
    pub const WGS84: Self = Self { semi_major: 6_378_137.0, flattening: 1.0 / 298.257_223_563 };
    /// Geodetic Reference System 1980: a = 6 378 137 m, 1/f = 298.257 222 101 (EPSG 7019).
    pub const GRS80: Self = Self { semi_major: 6_378_137.0, flattening: 1.0 / 298.257_222_101 };
    /// Bessel 1841: a = 6 377 397.155 m, 1/f = 299.152 812 8 (EPSG 7004).
    pub const BESSEL_1841: Self =
        Self { semi_major: 6_377_397.155, flattening: 1.0 / 299.152_812_8 };
    /// Clarke 1866: a = 6 378 206.4 m, b = 6 356 583.8 m (EPSG 7008).
    pub const CLARKE_1866: Self =
        Self { semi_major: 6_378_206.4, flattening: (6_378_206.4 - 6_356_583.8) / 6_378_206.4 };
    /// International 1924 (Hayford): a = 6 378 388 m, 1/f = 297 (EPSG 7022).
    pub const INTERNATIONAL_1924: Self = Self { semi_major: 6_378_388.0, flattening: 1.0 / 297.0 };
    /// Airy 1830: a = 6 377 563.396 m, 1/f = 299.324 964 6 (EPSG 7001).
    pub const AIRY_1830: Self = Self { semi_major: 6_377_563.396, flattening: 1.0 / 299.324_964_6 };
    /// Krassowsky 1940: a = 6 378 245 m, 1/f = 298.3 (EPSG 7024).
    pub const KRASSOWSKY_1940: Self = Self { semi_major: 6_378_245.0, flattening: 1.0 / 298.3 };

    /// From the semi-major axis a > 0 and the flattening 0 ≤ f < 1; a sphere has f = 0.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`].
    pub fn new(semi_major_axis: f64, flattening: f64) -> Result<Self, Error> {
        if !(semi_major_axis.is_finite() && flattening.is_finite()) {
            return Err(Error::NotFinite { what: "ellipsoid" });
        }
        if !(f64::MIN_POSITIVE..=1e300).contains(&semi_major_axis) {
            let (what, value) = ("semi-major axis", semi_major_axis);
            return Err(Error::OutOfRange { what, value, expected: "positive" });
        }
        if !(0.0..1.0).contains(&flattening) {
            let (what, value) = ("flattening", flattening);
            return Err(Error::OutOfRange { what, value, expected: "at least 0 and below 1" });
        }
        Ok(Self { semi_major: semi_major_axis, flattening })
    }

    /// a, the equator's radius.
    #[must_use]
    pub fn semi_major_axis(&self) -> f64 {
        self.semi_major
    }

    /// b, the distance of a pole from the centre.
    #[must_use]
    pub fn semi_minor_axis(&self) -> f64 {
        self.semi_major * (1.0 - self.flattening)
    }

    /// f = (a − b) / a.
    #[must_use]
    pub fn flattening(&self) -> f64 {
        self.flattening
    }

    /// e² = (a² − b²) / a², the first eccentricity squared.
    #[must_use]
    pub fn eccentricity_squared(&self) -> f64 {
        self.flattening * (2.0 - self.flattening)
    }

    /// e′² = (a² − b²) / b², the second eccentricity squared.
    #[must_use]
    pub fn second_eccentricity_squared(&self) -> f64 {
        let k = 1.0 - self.flattening;
        self.eccentricity_squared() / (k * k)
    }

    /// N = a / √(1 − e² sin² φ), the radius of curvature across the meridian: along the normal from the ellipsoid to
    /// the axis.
    #[must_use]
    pub fn prime_vertical_radius(&self, latitude: f64) -> f64 {
        let s = float::sin(latitude);
        self.semi_major / float::sqrt(1.0 - self.eccentricity_squared() * (s * s))
    }

    /// M = a (1 − e²) / (1 − e² sin² φ)^{3/2}, the radius of curvature along the meridian.
    #[must_use]
    pub fn meridian_radius(&self, latitude: f64) -> f64 {
        let n = self.prime_vertical_radius(latitude) / self.semi_major;
        self.semi_minor_axis() * (1.0 - self.flattening) * (n * n * n)
    }

    /// The outward normal at a latitude and longitude (radians), in geocentric axes.
    #[must_use]
    pub fn normal(latitude: f64, longitude: f64) -> UnitVector3<f64> {
        let ((sp, cp), (sl, cl)) = (float::sin_cos(latitude), float::sin_cos(longitude));
        UnitVector3::new_unchecked(Vector3::new(cp * cl, cp * sl, sp))
    }

    /// Geocentric coordinates, in closed form (IOGP Guidance Note 7-2, method EPSG 9602).
    ///
    /// ```text
    /// X = (N + h) cos φ cos λ,   Y = (N + h) cos φ sin λ,   Z = ((1 − e²) N + h) sin φ
    /// ```
    ///
    /// Exact to a few units in the last place: 2 nm on the Earth's surface.
    #[must_use]
    #[doc(alias("ECEF", "geodetic2ecef", "lla2ecef"))]
    pub fn geocentric_from_geodetic(&self, geodetic: &Geodetic) -> Point3<f64> {
        let (sl, cl) = float::sin_cos(geodetic.longitude());
        let (sp, cp) = float::sin_cos(geodetic.latitude());
        let n = self.prime_vertical_radius(geodetic.latitude());
        let h = geodetic.height().0;
        let k = 1.0 - self.flattening;
        let across = (n + h) * cp;
        Point3::new(across * cl, across * sl, (k * k * n + h) * sp)
    }

    /// Geodetic coordinates of a geocentric point: the ellipsoid's point nearest to it, and the distance from there.
    ///
    /// With p the distance from the axis, the normal at the foot is parallel to (p s, z (s + a e²)), where s is the
    /// largest root of
    ///
    /// ```text
    /// (p / (s + a e²))² + ((1 − f) z / s)² = 1
    /// ```
    ///
    /// The left side falls and is convex for s > 0, so Newton's method from the left rises to the root from any point
    /// (the distance from a point to an ellipse after Eberly, 2013). The height follows from the normal in doubled
    /// precision: p cos φ + z sin φ − a √(1 − e² sin² φ).
    ///
    /// *Domain*: every point. Below the evolute of the meridian (for the Earth: nearer than 43 km to the centre) more
    /// than one normal passes through a point and the nearest foot is taken; where two are equally near, the northern.
    /// The centre lies below the north pole; on the axis the longitude is 0.
    ///
    /// *Accuracy*: height within 10⁻⁹ m or one unit in its last place, the larger; angles within 10⁻¹⁵ rad, 100 km and
    /// more from the Earth's centre. Nearer, the latitude itself is ill-conditioned (the foot moves faster than the
    /// point), but the coordinates still lead back to the point.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`] for NaN and infinite coordinates and for a height beyond the largest float.
    ///
    /// # Example
    /// ```
    /// use collinear::geometry::geodetic::Ellipsoid;
    /// use nalgebra::Point3;
    ///
    /// // IOGP Guidance Note 7-2, method EPSG 9602.
    /// let point = Point3::new(3_771_793.968, 140_253.342, 5_124_304.349);
    /// let geodetic = Ellipsoid::WGS84.geodetic_from_geocentric(&point)?;
    /// let latitude = 53.0 + 48.0 / 60.0 + 33.82 / 3600.0;
    /// assert!((geodetic.latitude().to_degrees() - latitude).abs() < 1e-8);
    /// assert!((geodetic.height().0 - 73.0).abs() < 1e-3);
    /// # Ok::<(), collinear::ProjectionError>(())
    /// ```
    #[doc(alias("ecef2geodetic", "ecef2lla"))]
    pub fn geodetic_from_geocentric(
        &self,
        geocentric: &Point3<f64>,
    ) -> Result<Geodetic, ProjectionError> {
        let largest = self.semi_major.max(geocentric.coords.amax());
        if !(largest.is_finite() && geocentric.iter().all(|c| c.is_finite())) {
            return Err(ProjectionError::NotFinite);
        }
        // A power of two near the largest length divides without rounding, and no square overflows.
        let unit = f64::from_bits(largest.to_bits() & (0x7ff << 52));
        let [x, y, z] = [geocentric.x / unit, geocentric.y / unit, geocentric.z / unit];
        let a = self.semi_major / unit;
        let (xx, yy, zz) = (Twofold::new(x), Twofold::new(y), Twofold::new(z.abs()));
        let p = (xx * xx + yy * yy).sqrt();
        let (c, s) = self.foot_normal(a, p.round(), z.abs());

        let (cc, ss) = (Twofold::new(c), Twofold::new(s));
        let square = cc * cc + ss * ss;
        let e2 = Twofold::new(self.eccentricity_squared());
        let support = Twofold::new(a) * (square - e2 * ss * ss).sqrt();
        let height = (p * cc + zz * ss - support).div(square.sqrt()).round() * unit;
        if !height.is_finite() {
            return Err(ProjectionError::NotFinite);
        }
        let latitude = float::atan2(s, c).min(FRAC_PI_2);
        let longitude = if x == 0.0 && y == 0.0 { 0.0 } else { float::atan2(y, x) };
        Ok(Geodetic::found(if z < 0.0 { -latitude } else { latitude }, longitude, height))
    }

    /// The direction (away from the axis, along it) of the normal whose foot is nearest to (p, z), z ≥ 0: a unit
    /// vector to rounding. Lengths are scaled to be near one at most.
    fn foot_normal(&self, a: f64, p: f64, z: f64) -> (f64, f64) {
        let k = 1.0 - self.flattening;
        let gap = a * self.eccentricity_squared();
        let zk = k * z;
        let mut s = (float::hypot(p, zk) - gap).max(zk);
        if s > 0.0 {
            for _ in 0..MAX_ITERATIONS {
                let (u, v) = (p / (s + gap), zk / s);
                let excess = u * u + v * v - 1.0;
                let next = s + 0.5 * excess / (u * u / (s + gap) + v * v / s);
                if next <= s || next.is_nan() {
                    break;
                }
                s = next;
            }
            let (c, s) = (p * s, z * (s + gap));
            let length = float::hypot(c, s);
            if length > 0.0 {
                return (c / length, s / length);
            }
        }
        // In the equator's plane below the evolute: the feet lie off the plane, at this distance from the axis.
        let u = if gap > 0.0 { (p / gap).min(1.0) } else { 0.0 };
        let (c, s) = (k * u, float::sqrt((1.0 - u) * (1.0 + u)));
        let length = float::hypot(c, s);
        (c / length, s / length)
    }

    /// The surface of constant height above the ellipsoid, in geocentric coordinates.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::OutOfRange`] for a height at or below the centre (−b) or above 10⁶ a.
    pub fn at_height(&self, height: EllipsoidalHeight) -> Result<ConstantHeight, Error> {
        ConstantHeight::new(*self, height)
    }
}
