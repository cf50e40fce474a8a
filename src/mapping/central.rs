//! A plane seen by any camera of one centre.

use nalgebra::{Matrix2, Matrix3x2, Point2, Vector3};

use super::{Composed, FractionalLinear, Map};
use crate::camera::{
    CentralModel, ExteriorOrientation, Frame, HomogeneousCamera, InteriorOrientation, Orthographic,
};
use crate::error::{Error, ProjectionError};
use crate::geometry::{Affine2, Plane, axes};

/// From the coordinates of a plane to the image that a camera of one centre takes of it, of whichever model.
///
/// ```text
/// (x, y)  →  direction O + x a + y b  →  image            a ⊥ b, both ⊥ O and of unit length
/// ```
/// O leads from the centre to the foot of the centre on the plane. A fisheye sees more than the half-space in which a plane has an ideal
/// picture; so the way leads through the plane itself.
///
/// *Domain.* That of the camera.
///
/// # Example
/// An equidistant fisheye with c = 100 px shows what lies (1, 0) off the axis on the plane one ahead, at 45°, in 100 π/4:
///
/// ```
/// use collinear::camera::{CentralCamera, Fisheye, InteriorOrientation};
/// use collinear::mapping::{CentralMap, Map};
/// use nalgebra::Point2;
///
/// let interior = InteriorOrientation::new([100.0; 2], Point2::new(300.0, 200.0), 0.0)?;
/// let map = CentralMap::ahead(CentralCamera::ideal(interior, Fisheye::Equidistant));
/// let image = map.at(&Point2::new(1.0, 0.0))?;
/// assert!((image - Point2::new(378.53981633974483, 200.0)).norm() < 1e-13);
/// assert!((map.plane_point(&image)? - Point2::new(1.0, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentralMap<C> {
    origin: Vector3<f64>,
    axes: Matrix3x2<f64>,
    camera: C,
}

impl<C: CentralModel> CentralMap<C> {
    /// Of the plane one before the camera: (x, y) is (X/Z, Y/Z).
    #[must_use]
    pub fn ahead(camera: C) -> Self {
        let axes = Matrix3x2::from_columns(&[Vector3::x(), Vector3::y()]);
        Self { origin: Vector3::z(), axes, camera }
    }

    /// Of a plane of the world, with the parallel projection to its coordinates. Their origin is the foot of the projection
    /// centre, so that nothing is lost where both are far from the world's.
    fn of_plane(plane: &Plane, photograph: &Frame<C>) -> Result<(Self, Orthographic), Error>
    where
        C: Clone,
    {
        let center = photograph.exterior.projection_center();
        let world_from_plane = axes(&plane.normal());
        let exterior = ExteriorOrientation::new(plane.foot(&center), world_from_plane.inverse());
        let coordinates = Orthographic::new(exterior, Affine2::identity())?;
        let rotation = photograph.exterior.camera_from_world();
        let axes = (rotation * world_from_plane).into_inner().fixed_columns::<2>(0).into_owned();
        let distance = plane.signed_distance(&center);
        let origin = -(rotation * plane.normal().into_inner()) * distance;
        Ok((Self { origin, axes, camera: photograph.camera.clone() }, coordinates))
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &C {
        &self.camera
    }

    /// The point of the plane that images here: the inverse of [`at`](Map::at).
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`] where the ray leads away from the plane, and those of
    /// [`CentralModel::direction`].
    pub fn plane_point(&self, image: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let d = self.camera.direction(image)?;
        let depth = self.origin.dot(&d);
        if !(depth > 0.0) {
            return Err(ProjectionError::BehindCamera { depth });
        }
        let along = self.origin.norm_squared() / depth;
        Ok(Point2::from(self.axes.tr_mul(&d) * along))
    }

    fn direction(&self, plane: &Point2<f64>) -> Vector3<f64> {
        self.origin + self.axes * plane.coords
    }
}

impl<C: CentralModel> Map for CentralMap<C> {
    fn at(&self, plane: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.camera.project_direction(&self.direction(plane))
    }

    fn jacobian(&self, plane: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Ok(self.camera.project_direction_jacobian(&self.direction(plane))?.1 * self.axes)
    }
}

/// The map into a photograph of any central model: \[WD\] eq. 1 into the plane's own coordinates, then the camera.
///
/// [`PhotographMap`](super::PhotographMap) is the quicker one of a perspective with a lens; both agree.
///
/// # Example
/// An equidistant fisheye 100 m above a field, c = 100 px, textures a map of the field at 1 m a pixel. What lies 100 m to the east
/// is at 45° and 100 π/4 px to the right of the principal point; 1 km away, it is still in the picture:
///
/// ```
/// use collinear::camera::{CentralCamera, ExteriorOrientation, Fisheye, Frame, InteriorOrientation, Orthographic};
/// use collinear::geometry::{Affine2, Plane};
/// use collinear::mapping::{CentralPhotographMap, Map};
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let above = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 100.0), Point3::origin(), Vector3::y())?;
/// let interior = InteriorOrientation::new([100.0; 2], Point2::new(300.0, 200.0), 0.0)?;
/// let photograph = Frame::new(above, CentralCamera::ideal(interior, Fisheye::Equidistant));
/// let field = Plane::from_point_and_normal(Point3::origin(), Vector3::z())?;
/// let screen = Orthographic::new(above, Affine2::identity())?;
/// let map = CentralPhotographMap::from_plane(&field, &photograph, &screen.homogeneous())?;
/// assert!((map.at(&Point2::new(100.0, 0.0))? - Point2::new(378.53981633974483, 200.0)).norm() < 1e-12);
/// assert!((map.at(&Point2::new(1000.0, 0.0))? - Point2::new(447.1127674303735, 200.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type CentralPhotographMap<C> = Composed<CentralMap<C>, FractionalLinear>;

impl<C: CentralModel + Clone> CentralPhotographMap<C> {
    /// The map that a plane, a photograph and a screen share.
    ///
    /// # Errors
    /// As [`FractionalLinear::from_plane`].
    pub fn from_plane(
        plane: &Plane,
        photograph: &Frame<C>,
        screen: &HomogeneousCamera,
    ) -> Result<Self, Error> {
        // A pinhole in the camera's place says whether the plane is clear of it.
        let pinhole = InteriorOrientation::new([1.0; 2], Point2::origin(), 0.0)?;
        let pinhole = Frame::new(photograph.exterior, pinhole).homogeneous();
        FractionalLinear::from_plane(plane, &pinhole, screen)?;
        let (outer, coordinates) = CentralMap::of_plane(plane, photograph)?;
        let inner = FractionalLinear::from_plane(plane, &coordinates.homogeneous(), screen)?;
        Ok(Self { outer, inner })
    }
}
