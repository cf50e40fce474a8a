//! Similarities of space.

use nalgebra::{Matrix4, Point3, Rotation3, Vector3};

use super::Pose;
use crate::error::Error;

/// A change of frame that keeps shapes: a rotation, a scale, a shift.
///
/// ```text
/// X_to = B + s R (X_from − A)
/// ```
///
/// A, in the `from` frame, and B, in the `to` frame, are one and the same place. The subtraction comes first, so that map coordinates of
/// 10⁶ m keep their millimetres.
///
/// *Domain.* s > 0: a similarity does not mirror.
///
/// # Example
/// Twice as large, turned a quarter about z (x to y), the place (1, 1, 0) brought to (10, 0, 5):
/// ```
/// use collinear::geometry::Similarity;
/// use nalgebra::{Point3, Rotation3, Vector3};
///
/// let quarter = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
/// let map = Similarity::new(2.0, quarter, Point3::new(1.0, 1.0, 0.0), Point3::new(10.0, 0.0, 5.0))?;
/// assert!((map.apply(&Point3::new(4.0, 1.0, 0.0)) - Point3::new(10.0, 6.0, 5.0)).norm() < 1e-14);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Sim3", "Helmert transformation", "seven-parameter transformation", "conformal"))]
pub struct Similarity {
    scale: f64,
    rotation: Rotation3<f64>,
    from: Point3<f64>,
    to: Point3<f64>,
}

impl Similarity {
    /// From s, R, and a place in both frames, A and B.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for a scale that is not positive.
    pub fn new(
        scale: f64,
        rotation: Rotation3<f64>,
        from: Point3<f64>,
        to: Point3<f64>,
    ) -> Result<Self, Error> {
        let finite = scale.is_finite()
            && rotation.matrix().iter().chain(from.iter()).chain(to.iter()).all(|c| c.is_finite());
        if !finite {
            return Err(Error::NotFinite { what: "similarity" });
        }
        if scale <= 0.0 {
            let what = "scale of a similarity";
            return Err(Error::OutOfRange { what, value: scale, expected: "more than 0" });
        }
        Ok(Self { scale, rotation, from, to })
    }

    /// s: units of the `to` frame per unit of the `from` frame.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// R, to_from.
    #[must_use]
    pub fn rotation(&self) -> Rotation3<f64> {
        self.rotation
    }

    /// A and B: one place in both frames.
    #[must_use]
    pub fn places(&self) -> (Point3<f64>, Point3<f64>) {
        (self.from, self.to)
    }

    /// T of X_to = s R X_from + T: where the origin goes.
    #[must_use]
    pub fn translation(&self) -> Vector3<f64> {
        self.apply(&Point3::origin()).coords
    }

    /// A point into the `to` frame.
    #[must_use]
    pub fn apply(&self, from: &Point3<f64>) -> Point3<f64> {
        self.to + self.rotation * (from - self.from) * self.scale
    }

    /// A point back into the `from` frame.
    #[must_use]
    pub fn apply_inverse(&self, to: &Point3<f64>) -> Point3<f64> {
        self.from + self.rotation.inverse() * (to - self.to) / self.scale
    }

    /// The map back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        Self {
            scale: 1.0 / self.scale,
            rotation: self.rotation.inverse(),
            from: self.to,
            to: self.from,
        }
    }

    /// A camera of the `from` frame in the `to` frame: its centre moved, its axes turned. What it sees stays the same.
    ///
    /// ```
    /// use collinear::geometry::{Pose, Similarity};
    /// use nalgebra::{Point3, Rotation3, Vector3};
    ///
    /// let quarter = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    /// let map = Similarity::new(2.0, quarter, Point3::origin(), Point3::new(10.0, 0.0, 5.0))?;
    /// let camera = Pose::new(Rotation3::identity(), Point3::new(1.0, 0.0, 0.0));
    /// let moved = map.apply_to_pose(&camera);
    /// // What was 3 to the right of it is 6 to the right.
    /// let seen = moved.apply(&map.apply(&Point3::new(4.0, 0.0, 0.0)));
    /// assert!((seen - Point3::new(6.0, 0.0, 0.0)).norm() < 1e-14);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[must_use]
    pub fn apply_to_pose(&self, camera_from_from: &Pose) -> Pose {
        let rotation = camera_from_from.rotation * self.rotation.inverse();
        Pose::new(rotation, self.apply(&camera_from_from.origin))
    }

    /// The 4×4 matrix on homogeneous columns.
    #[must_use]
    pub fn to_matrix(&self) -> Matrix4<f64> {
        let mut m = (self.rotation.matrix() * self.scale).to_homogeneous();
        m.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation());
        m
    }
}
