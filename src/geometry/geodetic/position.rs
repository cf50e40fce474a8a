//! Latitude, longitude, and heights that say what they count from.

use core::f64::consts::{FRAC_PI_2, TAU};

use crate::error::Error;

/// A height above the ellipsoid, along its normal, in metres.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[doc(alias("geodetic height", "HAE"))]
pub struct EllipsoidalHeight(pub f64);

/// A height above the geoid, roughly above sea level, in metres.
///
/// There is no conversion without a [`GeoidGrid`](super::GeoidGrid).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[doc(alias("MSL", "elevation", "sea level"))]
pub struct OrthometricHeight(pub f64);

/// A place on an ellipsoid and a height above it.
///
/// The latitude is geodetic: the angle between the equator's plane and the ellipsoid's normal. Which ellipsoid is not
/// part of the value.
///
/// ```
/// use collinear::geometry::geodetic::{EllipsoidalHeight, Geodetic};
///
/// // Degrees where radians are expected are noticed.
/// assert!(Geodetic::new(48.8562, 2.3508, EllipsoidalHeight(67.4)).is_err());
/// assert!(Geodetic::from_degrees(48.8562, 2.3508, EllipsoidalHeight(67.4)).is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("LLA", "geographic"))]
pub struct Geodetic {
    latitude: f64,
    longitude: f64,
    height: EllipsoidalHeight,
}

impl Geodetic {
    /// From latitude in [−π/2, π/2] and longitude in [−2π, 2π], both in radians.
    ///
    /// # Errors
    /// [`Error::NotFinite`] and [`Error::OutOfRange`].
    pub fn new(latitude: f64, longitude: f64, height: EllipsoidalHeight) -> Result<Self, Error> {
        if !height.0.is_finite() {
            return Err(Error::NotFinite { what: "height" });
        }
        let latitude = bounded("latitude", latitude, FRAC_PI_2, "within ±π/2")?;
        let longitude = bounded("longitude", longitude, TAU, "within ±2π")?;
        Ok(Self { latitude, longitude, height })
    }

    /// From latitude in [−90, 90] and longitude in [−360, 360], both in degrees.
    ///
    /// # Errors
    /// As [`new`](Self::new); the value in the error is in degrees.
    pub fn from_degrees(
        latitude: f64,
        longitude: f64,
        height: EllipsoidalHeight,
    ) -> Result<Self, Error> {
        let latitude = bounded("latitude", latitude, 90.0, "within ±90°")?;
        let longitude = bounded("longitude", longitude, 360.0, "within ±360°")?;
        Self::new(latitude.to_radians(), longitude.to_radians(), height)
    }

    /// What a conversion has found; the caller vouches for the ranges.
    pub(super) fn found(latitude: f64, longitude: f64, height: f64) -> Self {
        Self { latitude, longitude, height: EllipsoidalHeight(height) }
    }

    /// Latitude in radians, north positive.
    #[must_use]
    pub fn latitude(&self) -> f64 {
        self.latitude
    }

    /// Longitude in radians, east positive.
    #[must_use]
    pub fn longitude(&self) -> f64 {
        self.longitude
    }

    /// Height above the ellipsoid.
    #[must_use]
    pub fn height(&self) -> EllipsoidalHeight {
        self.height
    }
}

/// The value, if it lies within ±`limit`.
fn bounded(
    what: &'static str,
    value: f64,
    limit: f64,
    expected: &'static str,
) -> Result<f64, Error> {
    if !value.is_finite() {
        return Err(Error::NotFinite { what });
    }
    if value.abs() > limit {
        return Err(Error::OutOfRange { what, value, expected });
    }
    Ok(value)
}
