//! Cartesian frames whose place on the Earth is known, and the Earth's surfaces seen from them.

use nalgebra::{Point3, UnitVector3};

use super::constant_height::ConstantHeight;
use super::ellipsoid::Ellipsoid;
use super::geoid::GeoidGrid;
use super::geoid_surface::ConstantOrthometric;
use super::local::LocalFrame;
use super::position::{EllipsoidalHeight, Geodetic, OrthometricHeight};
use crate::error::{Error, ProjectionError};
use crate::geometry::pose::Pose;
use crate::geometry::ray::{HeightCurve, Ray};
use crate::geometry::surface::Surface;

/// A Cartesian frame whose place on the Earth is known: the geocentric one, or a [`LocalFrame`].
///
/// ```
/// use collinear::geometry::Surface;
/// use collinear::geometry::geodetic::{EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame};
/// use nalgebra::Point3;
///
/// let origin = Geodetic::from_degrees(44.17, 5.28, EllipsoidalHeight(0.0))?;
/// let frame = EarthFrame::Local(LocalFrame::east_north_up(Ellipsoid::WGS84, origin));
/// // The ellipsoid falls away below the tangent plane: by d²/2R, 8 m at 10 km to the east.
/// let sea = frame.at_height(EllipsoidalHeight(0.0))?;
/// assert!((sea.height_above(&Point3::new(1e4, 0.0, 0.0)) - 1e8 / (2.0 * 6_388_531.0)).abs() < 1e-3);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EarthFrame {
    /// Geocentric coordinates on an ellipsoid.
    Geocentric(Ellipsoid),
    /// Coordinates about a point of the Earth.
    Local(LocalFrame),
}

impl EarthFrame {
    /// The ellipsoid.
    #[must_use]
    pub fn ellipsoid(&self) -> Ellipsoid {
        match self {
            Self::Geocentric(ellipsoid) => *ellipsoid,
            Self::Local(frame) => frame.ellipsoid(),
        }
    }

    /// The motion from geocentric coordinates to the frame's.
    #[must_use]
    pub fn pose(&self) -> Pose {
        match self {
            Self::Geocentric(_) => Pose::identity(),
            Self::Local(frame) => frame.pose(),
        }
    }

    /// Coordinates of a geodetic position.
    #[must_use]
    pub fn world_from_geodetic(&self, geodetic: &Geodetic) -> Point3<f64> {
        self.pose().apply(&self.ellipsoid().geocentric_from_geodetic(geodetic))
    }

    /// Geodetic position of a point.
    ///
    /// # Errors
    /// As [`Ellipsoid::geodetic_from_geocentric`].
    pub fn geodetic_from_world(&self, world: &Point3<f64>) -> Result<Geodetic, ProjectionError> {
        self.ellipsoid().geodetic_from_geocentric(&self.pose().apply_inverse(world))
    }

    /// The surface at a constant height above the ellipsoid.
    ///
    /// # Errors
    /// As [`Ellipsoid::at_height`].
    pub fn at_height(&self, height: EllipsoidalHeight) -> Result<Placed<ConstantHeight>, Error> {
        Ok(self.place(self.ellipsoid().at_height(height)?))
    }

    /// The surface at a constant height above the geoid.
    ///
    /// # Errors
    /// As [`ConstantOrthometric::new`].
    pub fn above_geoid(
        &self,
        geoid: GeoidGrid,
        height: OrthometricHeight,
    ) -> Result<Placed<ConstantOrthometric>, Error> {
        Ok(self.place(ConstantOrthometric::new(self.ellipsoid(), geoid, height)?))
    }

    /// A surface that is known in geocentric coordinates, in the frame's.
    #[must_use]
    pub fn place<S: Surface>(&self, surface: S) -> Placed<S> {
        Placed { surface, pose: self.pose() }
    }
}

/// A geocentric surface in the coordinates of an [`EarthFrame`], which makes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed<S> {
    surface: S,
    /// From geocentric coordinates to the frame's.
    pose: Pose,
}

impl<S> Placed<S> {
    /// The surface in geocentric coordinates.
    #[must_use]
    pub fn surface(&self) -> &S {
        &self.surface
    }
}

impl<S: Surface> Surface for Placed<S> {
    fn height_above(&self, world: &Point3<f64>) -> f64 {
        self.surface.height_above(&self.pose.apply_inverse(world))
    }

    fn normal(&self, world: &Point3<f64>) -> Result<UnitVector3<f64>, ProjectionError> {
        let normal = self.surface.normal(&self.pose.apply_inverse(world))?;
        Ok(self.pose.rotation * normal)
    }

    fn meet_ray(&self, ray: &Ray) -> Result<Point3<f64>, ProjectionError> {
        let origin = self.pose.apply_inverse(&ray.origin);
        let direction = self.pose.rotation.inverse() * ray.direction.into_inner();
        let moved = Ray::new(origin, direction).map_err(|_| ProjectionError::NotFinite)?;
        Ok(self.pose.apply(&self.surface.meet_ray(&moved)?))
    }

    fn meet_curve(&self, curve: &HeightCurve) -> Result<Point3<f64>, ProjectionError> {
        let turn = self.pose.rotation.inverse();
        let [c0, c1, c2, c3] = curve.coefficients;
        let start = self.pose.apply_inverse(&Point3::from(c0)).coords;
        let coefficients = [start, turn * c1, turn * c2, turn * c3];
        Ok(self.pose.apply(&self.surface.meet_curve(&HeightCurve { coefficients, ..*curve })?))
    }
}
