//! Rigid motions.

use nalgebra::{Matrix4, Point3, Rotation3, Vector3};

use crate::numeric::scalar::Scalar;

/// R (X − O).
pub(crate) fn rotate_about<S: Scalar>(point: [S; 3], origin: [S; 3], rows: [[S; 3]; 3]) -> [S; 3] {
    let d: [S; 3] = core::array::from_fn(|i| point[i] - origin[i]);
    rows.map(|r| r[0] * d[0] + r[1] * d[1] + r[2] * d[2])
}

/// A rigid change of frame, from a `from` frame into a `to` frame.
///
/// ```text
/// X_to = R (X_from − O)
/// ```
///
/// R turns, O is the origin of the `to` frame given in `from` coordinates. For a camera O is its projection centre and R
/// its camera_from_world. The subtraction comes first, so that coordinates of 10⁶ m keep their millimetres.
///
/// ```
/// use collinear::geometry::Pose;
/// use nalgebra::{Point3, Rotation3, Vector3};
///
/// // Turned a quarter about z: what lay along y lies along x.
/// let pose = Pose::new(Rotation3::from_axis_angle(&Vector3::z_axis(), -std::f64::consts::FRAC_PI_2), Point3::new(1.0, 1.0, 0.0));
/// assert!((pose.apply(&Point3::new(1.0, 3.0, 0.0)) - Point3::new(2.0, 0.0, 0.0)).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Isometry", "SE3", "extrinsics"))]
pub struct Pose {
    /// R, to_from.
    pub rotation: Rotation3<f64>,
    /// O, the origin of the `to` frame in `from` coordinates.
    pub origin: Point3<f64>,
}

impl Pose {
    /// A pose from its rotation and the origin of its target frame.
    #[must_use]
    pub fn new(rotation: Rotation3<f64>, origin: Point3<f64>) -> Self {
        Self { rotation, origin }
    }

    /// No motion.
    #[must_use]
    pub fn identity() -> Self {
        Self::new(Rotation3::identity(), Point3::origin())
    }

    /// From the form X_to = R X_from + t: O = −Rᵀ t.
    #[must_use]
    #[doc(alias("rvec", "tvec"))]
    pub fn from_rotation_translation(rotation: Rotation3<f64>, translation: Vector3<f64>) -> Self {
        Self::new(rotation, Point3::from(-(rotation.inverse() * translation)))
    }

    /// t of X_to = R X_from + t.
    #[must_use]
    pub fn translation(&self) -> Vector3<f64> {
        -(self.rotation * self.origin.coords)
    }

    /// A point into the `to` frame.
    #[must_use]
    #[inline]
    pub fn apply(&self, from: &Point3<f64>) -> Point3<f64> {
        let r = self.rotation.matrix();
        let rows = [0, 1, 2].map(|i| [r[(i, 0)], r[(i, 1)], r[(i, 2)]]);
        Point3::from(rotate_about(
            [from.x, from.y, from.z],
            [self.origin.x, self.origin.y, self.origin.z],
            rows,
        ))
    }

    /// A point back into the `from` frame.
    #[must_use]
    pub fn apply_inverse(&self, to: &Point3<f64>) -> Point3<f64> {
        self.origin + self.rotation.inverse() * to.coords
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self::new(self.rotation.inverse(), Point3::from(self.translation()))
    }

    /// This motion after `first`: c_from_a = c_from_b.after(b_from_a).
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self::new(self.rotation * first.rotation, first.apply_inverse(&self.origin))
    }

    /// The 4×4 matrix on homogeneous columns.
    #[must_use]
    pub fn to_matrix(&self) -> Matrix4<f64> {
        let mut m = self.rotation.to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation());
        m
    }
}
