//! Frames that touch the ellipsoid at an origin.

use nalgebra::{Matrix3, Point3, Rotation3};

use super::ellipsoid::Ellipsoid;
use super::position::Geodetic;
use crate::error::ProjectionError;
use crate::geometry::pose::Pose;
use crate::numeric::float;

/// A topocentric frame: right-handed axes along east, north and the ellipsoid's normal, from an origin.
///
/// ```text
///     ⎡ −sin λ          cos λ         0     ⎤
/// R = ⎢ −sin φ cos λ   −sin φ sin λ   cos φ ⎥      X_local = R (X_geocentric − X_origin)
///     ⎣  cos φ cos λ    cos φ sin λ   sin φ ⎦
/// ```
///
/// (IOGP Guidance Note 7-2, method EPSG 9836). North-east-down is the same frame with its axes renamed. "Up" is the
/// ellipsoid's normal at the origin: 10 km away the frame's plane is 8 m above the ellipsoid.
///
/// ```
/// use collinear::geometry::geodetic::{Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame};
///
/// // A summit seen from a village (MathWorks Mapping Toolbox, geodetic2enu).
/// let village = Geodetic::from_degrees(46.017, 7.750, EllipsoidalHeight(1673.0))?;
/// let summit = Geodetic::from_degrees(45.976, 7.658, EllipsoidalHeight(4531.0))?;
/// let enu = LocalFrame::east_north_up(Ellipsoid::WGS84, village).local_from_geodetic(&summit);
/// assert!((enu.x + 7134.8).abs() < 0.05 && (enu.y + 4556.3).abs() < 0.05);
/// assert!((enu.z - 2852.4).abs() < 0.05);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("ENU", "NED", "topocentric"))]
pub struct LocalFrame {
    ellipsoid: Ellipsoid,
    origin: Geodetic,
    pose: Pose,
}

impl LocalFrame {
    /// x east, y north, z up.
    #[must_use]
    #[doc(alias("ENU", "geodetic2enu"))]
    pub fn east_north_up(ellipsoid: Ellipsoid, origin: Geodetic) -> Self {
        Self::with_axes(ellipsoid, origin, |[east, north, up]| [east, north, up])
    }

    /// x north, y east, z down.
    #[must_use]
    #[doc(alias("NED", "geodetic2ned"))]
    pub fn north_east_down(ellipsoid: Ellipsoid, origin: Geodetic) -> Self {
        Self::with_axes(ellipsoid, origin, |[east, north, up]| [north, east, up.map(|c| -c)])
    }

    fn with_axes(
        ellipsoid: Ellipsoid,
        origin: Geodetic,
        arrange: impl Fn([[f64; 3]; 3]) -> [[f64; 3]; 3],
    ) -> Self {
        let (sp, cp) = float::sin_cos(origin.latitude());
        let (sl, cl) = float::sin_cos(origin.longitude());
        let rows = arrange([[-sl, cl, 0.0], [-sp * cl, -sp * sl, cp], [cp * cl, cp * sl, sp]]);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&rows.concat()));
        let centre = ellipsoid.geocentric_from_geodetic(&origin);
        Self { ellipsoid, origin, pose: Pose::new(rotation, centre) }
    }

    /// The frame's origin.
    #[must_use]
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// The ellipsoid.
    #[must_use]
    pub fn ellipsoid(&self) -> Ellipsoid {
        self.ellipsoid
    }

    /// The motion from geocentric to local coordinates.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Local coordinates of a geocentric point. Differences are taken first: neighbours keep their nanometres.
    #[must_use]
    #[doc(alias = "ecef2enu")]
    pub fn local_from_geocentric(&self, geocentric: &Point3<f64>) -> Point3<f64> {
        self.pose.apply(geocentric)
    }

    /// Geocentric coordinates of a local point.
    #[must_use]
    #[doc(alias = "enu2ecef")]
    pub fn geocentric_from_local(&self, local: &Point3<f64>) -> Point3<f64> {
        self.pose.apply_inverse(local)
    }

    /// Local coordinates of a geodetic position (method EPSG 9837).
    #[must_use]
    pub fn local_from_geodetic(&self, geodetic: &Geodetic) -> Point3<f64> {
        self.local_from_geocentric(&self.ellipsoid.geocentric_from_geodetic(geodetic))
    }

    /// Geodetic position of a local point.
    ///
    /// # Errors
    /// As [`Ellipsoid::geodetic_from_geocentric`].
    #[doc(alias = "enu2geodetic")]
    pub fn geodetic_from_local(&self, local: &Point3<f64>) -> Result<Geodetic, ProjectionError> {
        self.ellipsoid.geodetic_from_geocentric(&self.geocentric_from_local(local))
    }
}
