//! Cameras: what is where in a photograph, and where in the world a pixel comes from.
//!
//! Three contracts. A [`CentralModel`] turns a direction into an image point and back, without a pose; a
//! [`SensorModel`] does so for points of the world, and need not have one projection centre; [`Adjustable`] gives the
//! partial derivatives by which either is found from points. [`Frame`] is a pose and a central model; [`Scanner`] is a
//! central model along a [`Trajectory`].
//!
//! Camera axes: x right, y down, z forward. Image coordinates: pixels, from the top-left corner of the top-left pixel,
//! whose centre is (0.5, 0.5). The photogrammetric system (millimetres, y up, looking along −z) enters by named
//! constructors.
//!
#![doc = include_str!("../../docs/figures/camera.svg")]

mod aerial;
mod central;
pub mod central_projection;
mod collinearity;
mod colmap;
pub mod distortion;
mod exterior;
mod frame;
mod held;
mod homogeneous;
mod interior;
mod orthographic;
mod parameters;
pub mod rpc;
mod scanning;

use alloc::boxed::Box;
use alloc::sync::Arc;
use core::fmt::Debug;

use nalgebra::{Matrix2x3, Point2, Point3, Vector3};

pub use aerial::{EarthCurvature, Refraction};
pub use central::{BrownCamera, CentralCamera, FisheyeCamera};
pub use central_projection::{
    CentralProjection, Division, DoubleSphere, EnhancedUnified, FieldOfView, Fisheye, Gnomonic,
    Panorama, UnifiedSphere,
};
pub use colmap::{COLMAP_MODELS, brown_from_colmap, from_colmap};
pub use distortion::{
    Brown, Distortion, EvenRadial, Fraser, ImageMotionCompensation, Metashape, NoDistortion,
    RadialTangentialThinPrism, Rational, ThinPrism, Undistorted, UndistortedMany,
};
pub use exterior::ExteriorOrientation;
pub use frame::Frame;
pub use held::Held;
pub use homogeneous::HomogeneousCamera;
pub use interior::InteriorOrientation;
pub use orthographic::Orthographic;
pub use parameters::Parametrised;
pub use rpc::{Rpc, RpcSensor};
pub use scanning::{
    Ephemeris, Interpolation, PlatformState, PolynomialTrajectory, ScanTime, Scanner, Trajectory,
};

use crate::error::{Error, ProjectionError};
use crate::geometry::{Locus, Surface};

/// A camera with one projection centre, seen from that centre: direction ⇄ image.
///
/// No pose, and no "behind" of its own: a fisheye sees more than a half-space. Where the model has a limit it says so
/// ([`ProjectionError::BehindCamera`], [`ProjectionError::OutsideDomain`]).
///
/// [`project_direction`](Self::project_direction) after [`direction`](Self::direction) is the identity, and the other
/// way around up to the direction's length, within the domain.
///
/// # Example
/// A model of one's own: the equidistant fisheye r = f θ, at 60° from its axis and 30° right of down.
///
/// ```
/// use collinear::ProjectionError;
/// use collinear::camera::CentralModel;
/// use nalgebra::{Matrix2x3, Point2, Vector3};
///
/// #[derive(Debug)]
/// struct Equidistant(f64);
///
/// impl CentralModel for Equidistant {
///     fn project_direction(&self, d: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
///         let across = d.x.hypot(d.y);
///         let r = self.0 * across.atan2(d.z) / across.max(f64::MIN_POSITIVE);
///         Ok(Point2::new(r * d.x, r * d.y))
///     }
///     fn project_direction_jacobian(
///         &self,
///         d: &Vector3<f64>,
///     ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
///         let (across, all) = (d.x.hypot(d.y), d.norm());
///         let (s, c) = (d.x / across, d.y / across);
///         let along = self.0 * d.z / (all * all);
///         let around = self.0 * across.atan2(d.z) / across;
///         let by_z = -self.0 * across / (all * all);
///         let off = (along - around) * s * c;
///         let rows = [
///             [along * s * s + around * c * c, off, by_z * s],
///             [off, along * c * c + around * s * s, by_z * c],
///         ];
///         Ok((self.project_direction(d)?, Matrix2x3::from_fn(|i, j| rows[i][j])))
///     }
///     fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
///         let r = image.coords.norm();
///         let (sine, cosine) = (r / self.0).sin_cos();
///         Ok(Vector3::new(sine * image.x / r, sine * image.y / r, cosine))
///     }
/// }
///
/// let camera = Equidistant(300.0);
/// let (across, along) = (60f64.to_radians().sin(), 60f64.to_radians().cos());
/// let (right, down) = (across * 30f64.to_radians().sin(), across * 30f64.to_radians().cos());
/// let (p, slopes) = camera.project_direction_jacobian(&Vector3::new(right, down, along))?;
/// // 300 · π/3 = 314.159…, half of it to the right
/// assert!((p - Point2::new(157.07963267948966, 272.0699046351327)).norm() < 1e-12);
/// assert!((camera.direction(&p)? - Vector3::new(right, down, along)).norm() < 1e-15);
/// // Along the direction itself nothing changes.
/// assert!((slopes * Vector3::new(right, down, along)).norm() < 1e-12);
/// # Ok::<(), ProjectionError>(())
/// ```
pub trait CentralModel: Debug + Send + Sync {
    /// The image (pixels) of a direction in camera axes, of any positive length.
    ///
    /// # Errors
    /// The reason why this direction has no image.
    fn project_direction(&self, direction: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError>;

    /// The image with its partial derivatives ∂(x, y)/∂(X, Y, Z).
    ///
    /// # Errors
    /// As [`project_direction`](Self::project_direction).
    fn project_direction_jacobian(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError>;

    /// The direction in camera axes, of unit length, that images at this point (pixels).
    ///
    /// # Errors
    /// The reason why no direction does, [`ProjectionError::NotConverged`] among them.
    #[doc(alias("unproject", "backproject", "undistortPoints"))]
    fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError>;
}

/// A sensor in the world: world ⇄ image, with any number of projection centres or none.
///
/// [`project`](Self::project) after [`ground`](Self::ground) is the identity on every surface within the domain.
///
/// # Example
/// Monoplotting. From 100 m, with c = 1000 px, a pixel 100 px right of the principal point shows a terrace 20 m high
/// 80 · 0.1 = 8 m to the east:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation, SensorModel};
/// use collinear::geometry::Plane;
/// use nalgebra::{Point2, Point3, Vector3};
///
/// let above = ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 100.0), Point3::origin(), Vector3::y())?;
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0)?;
/// let sensor: Box<dyn SensorModel> = Box::new(Frame::new(above, interior));
/// let terrace = Plane::from_point_and_normal(Point3::new(0.0, 0.0, 20.0), Vector3::z())?;
/// let hit = sensor.ground(&Point2::new(600.0, 400.0), &terrace)?;
/// assert!((hit - Point3::new(8.0, 0.0, 20.0)).norm() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait SensorModel: Debug + Send + Sync {
    /// The image (pixels) of a world point.
    ///
    /// # Errors
    /// The reason why this point has no image.
    #[doc(alias("image_from_ground", "groundToImage", "projectPoints"))]
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError>;

    /// The image with its partial derivatives ∂(x, y)/∂(X, Y, Z).
    ///
    /// # Errors
    /// As [`project`](Self::project).
    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError>;

    /// The points of the world that image here: a ray, or a curve over height with its error bound.
    ///
    /// # Errors
    /// The reason why there are none.
    #[doc(alias("imageToProximateImagingLocus"))]
    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError>;

    /// The point of a surface that images here (monoplotting).
    ///
    /// # Errors
    /// As [`locus`](Self::locus), and [`ProjectionError::MissesSurface`].
    #[doc(alias("imageToGround", "monoplotting"))]
    fn ground(
        &self,
        image: &Point2<f64>,
        surface: &dyn Surface,
    ) -> Result<Point3<f64>, ProjectionError> {
        surface.meet(&self.locus(image)?)
    }
}

/// A sensor behind a pointer is that sensor, and so is a central model.
macro_rules! behind_a_pointer {
    ($($pointer:ty),*) => {$(
        impl<S: CentralModel + ?Sized> CentralModel for $pointer {
            fn project_direction(
                &self,
                direction: &Vector3<f64>,
            ) -> Result<Point2<f64>, ProjectionError> {
                (**self).project_direction(direction)
            }
            fn project_direction_jacobian(
                &self,
                direction: &Vector3<f64>,
            ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
                (**self).project_direction_jacobian(direction)
            }
            fn direction(&self, image: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
                (**self).direction(image)
            }
        }

        impl<S: SensorModel + ?Sized> SensorModel for $pointer {
            fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
                (**self).project(world)
            }
            fn project_jacobian(
                &self,
                world: &Point3<f64>,
            ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
                (**self).project_jacobian(world)
            }
            fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
                (**self).locus(image)
            }
            fn ground(
                &self,
                image: &Point2<f64>,
                surface: &dyn Surface,
            ) -> Result<Point3<f64>, ProjectionError> {
                (**self).ground(image, surface)
            }
        }
    )*};
}

behind_a_pointer!(&S, Box<S>, Arc<S>);

/// A group of parameters that an adjustment estimates, or holds, together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterGroup {
    /// What the group is, as `"exterior orientation"`.
    pub name: &'static str,
    /// The number of parameters.
    pub len: usize,
}

/// Why a group past the last cannot be moved.
fn no_group(group: usize) -> Error {
    Error::OutOfRange {
        what: "parameter group",
        value: group as f64,
        expected: "a group that the model has",
    }
}

/// A model whose parameters can be estimated from points.
///
/// Parameters come in groups, so that a whole group can be shared between photographs or held. The object point is a
/// direction in camera axes for a [`CentralModel`] and a world point for a [`SensorModel`].
///
/// # Example
/// x = fx X/Z + x₀ at (1, 2, 8) with fx = 1000, differentiated by hand:
///
/// ```
/// use collinear::camera::{Adjustable, InteriorOrientation};
/// use nalgebra::{Point2, Point3};
///
/// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0)?;
/// let (mut by_object, mut by_interior) = ([0.0; 6], [0.0; 10]);
/// interior.partials(&Point3::new(1.0, 2.0, 8.0), &mut by_object, &mut [&mut by_interior])?;
/// assert_eq!(by_object[..3], [125.0, 0.0, -15.625]); // fx/Z, 0, −fx X/Z²
/// assert_eq!(by_interior[..5], [0.125, 0.0, 1.0, 0.0, 0.25]); // by fx, fy, x₀, y₀, s
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Adjustable {
    /// The `group`-th group, in a fixed order; `None` past the last.
    fn parameter_group(&self, group: usize) -> Option<ParameterGroup>;

    /// The current values of a group, written to a slice of its length. For a rotation, which is estimated as a small
    /// vector about the current one, the values are zero. Nothing is written past the last group.
    fn parameters(&self, group: usize, values: &mut [f64]);

    /// Moves a group by a step.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where the result is no valid model, as a principal distance of zero, or the group does not
    /// exist; [`Error::LengthMismatch`]; [`Error::NotFinite`]. The model is then unchanged.
    fn adjust(&mut self, group: usize, step: &[f64]) -> Result<(), Error>;

    /// The image of an object point with its partial derivatives.
    ///
    /// `by_object` receives ∂(x, y)/∂(X, Y, Z), two rows of three. `by_group[g]` receives the derivatives with respect
    /// to group g, two rows of the group's length, or is empty: then the group is held and nothing is computed for it.
    ///
    /// # Errors
    /// As the model's projection. The slices then hold no meaningful numbers.
    fn partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError>;

    /// [`partials`](Self::partials) by the bare formula, outside the model's domain too where the formula has a value there:
    /// behind a perspective camera, beyond the fold of a lens. For comparison with programs that know no domain; a point has
    /// no image there. By default as [`partials`](Self::partials).
    ///
    /// # Errors
    /// As the model's projection, for what the formula has no value.
    ///
    /// # Example
    /// (1, 2, −8) is no point before the camera; X/Z and Y/Z are −1/8 and −1/4.
    ///
    /// ```
    /// use collinear::InteriorOrientation;
    /// use collinear::camera::{Adjustable, CentralCamera, Gnomonic};
    /// use nalgebra::{Point2, Point3};
    ///
    /// let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0)?;
    /// let camera = CentralCamera::ideal(interior, Gnomonic);
    /// let (point, mut slopes) = (Point3::new(1.0, 2.0, -8.0), [0.0; 6]);
    /// assert!(camera.partials(&point, &mut slopes, &mut []).is_err());
    /// assert_eq!(camera.formula_partials(&point, &mut slopes, &mut [])?, Point2::new(375.0, 150.0));
    /// assert_eq!(slopes[..3], [-125.0, 0.0, -15.625]); // fx/Z, 0, −fx X/Z²
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn formula_partials(
        &self,
        object: &Point3<f64>,
        by_object: &mut [f64; 6],
        by_group: &mut [&mut [f64]],
    ) -> Result<Point2<f64>, ProjectionError> {
        self.partials(object, by_object, by_group)
    }
}
