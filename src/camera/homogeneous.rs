//! Cameras without lens errors as matrices, perspective and parallel alike.

use nalgebra::{Matrix2x3, Matrix3x4, Matrix4x3, Point2, Point3, Vector3, Vector4};

use super::{ExteriorOrientation, InteriorOrientation, SensorModel, collinearity};
use crate::error::ProjectionError;
use crate::geometry::{Affine2, Locus, Ray, Surface};

/// A camera that is linear in homogeneous coordinates.
///
/// ```text
/// (x w, y w, w)ᵀ = M (X − O, 1)ᵀ          image from world, M 3×4
/// (X − O, 1)ᵀ ∝ B (x, y, 1)ᵀ + μ c        the line of sight, M B = I, M c = 0
/// ```
///
/// O is a point near the camera (its projection centre where it has one) and everything is stated about it, so that map
/// coordinates of 10⁶ lose nothing. For a perspective camera c = (0, 0, 0, 1) and w is the depth; for a parallel one
/// c is the viewing direction and w = 1. What a plane and two cameras share
/// ([`FractionalLinear::from_plane`](crate::mapping::FractionalLinear::from_plane)) is derived from this form alone.
///
/// It comes from [`Frame::homogeneous`](super::Frame::homogeneous) and
/// [`Orthographic::homogeneous`](super::Orthographic::homogeneous).
///
/// # Example
/// A level camera 10 m above a floor, c = 1000 px, its horizon in line 400. By similar triangles line L shows the floor at
/// the depth 1000 · 10 / (L − 400), so 1/Z is linear in L:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
/// use collinear::geometry::Plane;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let level = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 10.0), Point3::new(0.0, 1.0, 10.0), Vector3::z())?;
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0)?;
/// let camera = Frame::new(level, interior).homogeneous();
/// let floor = Plane::from_point_and_normal(Point3::origin(), Vector3::z())?;
/// let [n0, n1, n2] = camera.nearness(&floor)?;
/// assert!((n0 + 0.04).abs() < 1e-15 && n1.abs() < 1e-15 && (n2 - 1e-4).abs() < 1e-18);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("projection matrix", "P matrix", "camera matrix"))]
pub struct HomogeneousCamera {
    /// O.
    pub(crate) origin: Point3<f64>,
    /// M.
    pub(crate) image_from_world: Matrix3x4<f64>,
    /// B.
    pub(crate) back_projection: Matrix4x3<f64>,
    /// c.
    pub(crate) center: Vector4<f64>,
}

impl HomogeneousCamera {
    pub(super) fn perspective(
        exterior: &ExteriorOrientation,
        interior: &InteriorOrientation,
    ) -> Self {
        let rotation = exterior.camera_from_world();
        let m = interior.matrix() * rotation.matrix();
        let b = rotation.matrix().transpose() * interior.inverse_matrix();
        let mut image_from_world = Matrix3x4::zeros();
        image_from_world.fixed_view_mut::<3, 3>(0, 0).copy_from(&m);
        let mut back_projection = Matrix4x3::zeros();
        back_projection.fixed_view_mut::<3, 3>(0, 0).copy_from(&b);
        Self {
            origin: exterior.projection_center(),
            image_from_world,
            back_projection,
            center: Vector4::new(0.0, 0.0, 0.0, 1.0),
        }
    }

    pub(super) fn orthographic(
        exterior: &ExteriorOrientation,
        pixel_from_plane: &Affine2,
        plane_from_pixel: &Affine2,
    ) -> Self {
        let rotation = exterior.camera_from_world();
        let axes = rotation.matrix().fixed_view::<2, 3>(0, 0).into_owned();
        let mut image_from_world = Matrix3x4::zeros();
        image_from_world.fixed_view_mut::<2, 3>(0, 0).copy_from(&(pixel_from_plane.linear * axes));
        image_from_world.fixed_view_mut::<2, 1>(0, 3).copy_from(&pixel_from_plane.translation);
        image_from_world[(2, 3)] = 1.0;
        let mut back_projection = Matrix4x3::zeros();
        back_projection
            .fixed_view_mut::<3, 2>(0, 0)
            .copy_from(&(axes.transpose() * plane_from_pixel.linear));
        back_projection
            .fixed_view_mut::<3, 1>(0, 2)
            .copy_from(&(axes.transpose() * plane_from_pixel.translation));
        back_projection[(3, 2)] = 1.0;
        let direction: Vector3<f64> = rotation.inverse() * Vector3::z();
        Self {
            origin: exterior.projection_center(),
            image_from_world,
            back_projection,
            center: direction.push(0.0),
        }
    }

    /// Whether the projection is parallel: it has no centre, and w = 1.
    #[must_use]
    pub fn is_parallel(&self) -> bool {
        self.center.w == 0.0
    }

    /// M, image from (X − O, 1).
    #[must_use]
    pub fn image_from_world(&self) -> &Matrix3x4<f64> {
        &self.image_from_world
    }

    /// O, in world coordinates.
    #[must_use]
    pub fn origin(&self) -> Point3<f64> {
        self.origin
    }

    /// The pixel of a world point, given from this camera's origin, and w.
    ///
    /// # Errors
    /// [`ProjectionError::BehindCamera`], [`ProjectionError::NotFinite`].
    pub(crate) fn project_offset(
        &self,
        from_origin: &Vector3<f64>,
    ) -> Result<(Point2<f64>, f64), ProjectionError> {
        let h = self.image_from_world * from_origin.push(1.0);
        if h.z > 0.0 {
            Ok((Point2::new(h.x / h.z, h.y / h.z), h.z))
        } else if h.z.is_nan() {
            Err(ProjectionError::NotFinite)
        } else {
            Err(ProjectionError::BehindCamera { depth: h.z })
        }
    }

    fn line(&self, image: &Point2<f64>) -> Result<Ray, ProjectionError> {
        let on_line = (self.back_projection * Vector3::new(image.x, image.y, 1.0)).xyz();
        let (origin, direction) = if self.is_parallel() {
            (self.origin + on_line, self.center.xyz())
        } else {
            (self.origin, on_line)
        };
        Ray::new(origin, direction).map_err(|_| ProjectionError::NotFinite)
    }
}

impl SensorModel for HomogeneousCamera {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        collinearity::finite(self.project_offset(&(world - self.origin))?.0)
    }

    /// ∂(x, y)/∂X = (M₁₂ − (x, y) M₃)/w.
    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let (image, w) = self.project_offset(&(world - self.origin))?;
        let m = self.image_from_world.fixed_columns::<3>(0);
        let jacobian = (m.fixed_rows::<2>(0) - image.coords * m.row(2)) / w;
        if jacobian.iter().all(|e| e.is_finite()) {
            Ok((collinearity::finite(image)?, jacobian))
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        self.line(image).map(Locus::Ray)
    }

    /// Along a parallel line of sight the first point from O's plane on; failing that, the first against it.
    fn ground(
        &self,
        image: &Point2<f64>,
        surface: &dyn Surface,
    ) -> Result<Point3<f64>, ProjectionError> {
        let ray = self.line(image)?;
        if self.is_parallel() { ray.meet_either_way(surface) } else { surface.meet_ray(&ray) }
    }
}
