//! Exterior orientation: where the camera stands and how it is turned.

use nalgebra::{Matrix2x3, Matrix3, Point3, Rotation3, Vector3};

use super::{ParameterGroup, parameters};
use crate::error::Error;
use crate::geometry::Pose;
use crate::geometry::rotation::{self, OmegaPhiKappa, RotationVector, orthonormalised};

/// Exterior orientation: the projection centre and the rotation camera_from_world.
///
/// ```text
/// X_camera = R (X_world − C)
/// ```
///
/// Camera axes: x right, y down, z forward. Other conventions enter by name: photogrammetric angles by
/// [`from_omega_phi_kappa`](Self::from_omega_phi_kappa), a rotation and translation of computer vision by
/// [`from_rotation_translation`](Self::from_rotation_translation). The centre is in world units, angles are radians.
///
/// *Accuracy.* The subtraction comes first: with a centre of 10⁶ m a point keeps its millimetres.
///
/// # Example
/// OpenCV 5.0.0, `Rodrigues` of the rvec (0.1, −0.2, 0.3) and tvec (1, 2, 3), applied to (4, 5, 6):
///
/// ```
/// use collinear::camera::ExteriorOrientation;
/// use nalgebra::{Point3, Rotation3, Vector3};
///
/// let rotation = Rotation3::from_scaled_axis(Vector3::new(0.1, -0.2, 0.3));
/// let e = ExteriorOrientation::from_rotation_translation(rotation, Vector3::new(1.0, 2.0, 3.0));
/// let p = e.pose().apply(&Point3::new(4.0, 5.0, 6.0));
/// assert!((p - Point3::new(2.145115185932103, 7.12155548228497, 10.032665259545945)).norm() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("extrinsics", "camera pose", "view matrix"))]
pub struct ExteriorOrientation {
    pose: Pose,
}

impl ExteriorOrientation {
    /// From the projection centre (world units) and camera_from_world.
    #[must_use]
    pub fn new(projection_center: Point3<f64>, camera_from_world: Rotation3<f64>) -> Self {
        Self { pose: Pose::new(camera_from_world, projection_center) }
    }

    /// From R and t of X_camera = R X_world + t (OpenCV's rvec and tvec, COLMAP's cam_from_world).
    #[must_use]
    #[doc(alias("rvec", "tvec", "cam_from_world"))]
    pub fn from_rotation_translation(rotation: Rotation3<f64>, translation: Vector3<f64>) -> Self {
        Self { pose: Pose::from_rotation_translation(rotation, translation) }
    }

    /// From the projection centre and photogrammetric angles: M = Mκ Mφ Mω turns the world into the photo system (x right,
    /// y up, looking along −z), which half a turn about x takes to camera axes.
    ///
    /// ```
    /// use collinear::camera::ExteriorOrientation;
    /// use collinear::geometry::rotation::OmegaPhiKappa;
    /// use nalgebra::{Point3, Vector3};
    ///
    /// // A vertical photograph looks down; κ = 90° turns the photo's x axis to the world's y.
    /// let angles = OmegaPhiKappa { omega: 0.0, phi: 0.0, kappa: std::f64::consts::FRAC_PI_2 };
    /// let e = ExteriorOrientation::from_omega_phi_kappa(Point3::new(0.0, 0.0, 100.0), &angles);
    /// let p = e.pose().apply(&Point3::new(0.0, 7.0, 0.0));
    /// assert!((p - Point3::new(7.0, 0.0, 100.0)).norm() < 1e-14);
    /// ```
    #[must_use]
    pub fn from_omega_phi_kappa(projection_center: Point3<f64>, angles: &OmegaPhiKappa) -> Self {
        Self::new(projection_center, rotation::camera_from_photo() * angles.photo_from_world())
    }

    /// ω, φ, κ of this orientation.
    #[must_use]
    pub fn omega_phi_kappa(&self) -> OmegaPhiKappa {
        OmegaPhiKappa::from_photo_from_world(
            &(rotation::camera_from_photo().inverse() * self.pose.rotation),
        )
    }

    /// The chain from angles to this crate's rotation parameters: δ = (∂δ/∂(ω, φ, κ)) d(ω, φ, κ), with
    /// camera_from_world ← exp(\[δ\]×) R. Multiplied from the right it turns partials by δ into partials by the angles.
    #[must_use]
    pub fn rotation_from_omega_phi_kappa(&self) -> Matrix3<f64> {
        rotation::camera_from_photo().matrix() * self.omega_phi_kappa().left_from_angles()
    }

    /// A camera at `center` that looks at `target` with the world direction `up` upwards in its picture.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::Degenerate`] where target and centre coincide or `up` lies along the line of
    /// sight; the measure is the sine of their angle.
    ///
    /// ```
    /// use collinear::camera::ExteriorOrientation;
    /// use nalgebra::{Point3, Vector3};
    ///
    /// // From (10, 0, 10) towards the origin: what lies 1 to the north is 1 to the right.
    /// let e = ExteriorOrientation::look_at(Point3::new(10.0, 0.0, 10.0), Point3::origin(), Vector3::z())?;
    /// let p = e.pose().apply(&Point3::new(0.0, 1.0, 0.0));
    /// assert!((p - Point3::new(1.0, 0.0, 200f64.sqrt())).norm() < 1e-14);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("lookAt"))]
    pub fn look_at(
        center: Point3<f64>,
        target: Point3<f64>,
        up: Vector3<f64>,
    ) -> Result<Self, Error> {
        let forward = target - center;
        let (forward_length, up_length) = (forward.norm(), up.norm());
        if !(forward_length.is_finite() && up_length.is_finite()) {
            return Err(Error::NotFinite { what: "look_at" });
        }
        let limit = 1e-12;
        let forward = forward / forward_length;
        let right = forward.cross(&(up / up_length));
        let sine = right.norm();
        if !(sine > limit) {
            let measure = if sine.is_finite() { sine } else { 0.0 };
            return Err(Error::Degenerate { what: "look_at directions", measure, limit });
        }
        let right = right / sine;
        let down = forward.cross(&right);
        let rows = Matrix3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
        Ok(Self::new(center, Rotation3::from_matrix_unchecked(rows)))
    }

    /// The projection centre, in world units.
    #[must_use]
    pub fn projection_center(&self) -> Point3<f64> {
        self.pose.origin
    }

    /// R.
    #[must_use]
    pub fn camera_from_world(&self) -> Rotation3<f64> {
        self.pose.rotation
    }

    /// The whole as a rigid motion, camera_from_world.
    #[must_use]
    #[inline]
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// The values of the parameter group: the centre, and a rotation vector that is zero, as it counts from the current rotation.
    pub(super) fn values(&self) -> [f64; 6] {
        let c = self.pose.origin;
        [c.x, c.y, c.z, 0.0, 0.0, 0.0]
    }

    /// Moved by a step of the centre and a left rotation vector δ: camera_from_world ← exp(\[δ\]×) R.
    pub(crate) fn moved(&self, step: &[f64]) -> Result<Self, Error> {
        let [x, y, z, a, b, c] = parameters::read(step)?;
        if !step.iter().all(|s| s.is_finite()) {
            return Err(Error::NotFinite { what: "exterior orientation step" });
        }
        let center = self.pose.origin + Vector3::new(x, y, z);
        if !center.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "projection centre after a step" });
        }
        let turn = RotationVector { x: a, y: b, z: c }.rotation();
        // Products of many small turns drift from orthonormal; renormalising at each step keeps them there.
        let product = turn.matrix() * self.pose.rotation.matrix();
        Ok(Self::new(center, orthonormalised(&product)?))
    }
}

/// The group of an exterior orientation.
pub(super) const EXTERIOR: ParameterGroup = ParameterGroup { name: "exterior orientation", len: 6 };

/// ∂(x, y) by the group, two rows of six, where the slice has their length: by the centre the opposite of that by the world.
#[inline]
pub(super) fn write_partials(by_world: &Matrix2x3<f64>, by_turn: &Matrix2x3<f64>, out: &mut [f64]) {
    if out.len() != 2 * EXTERIOR.len {
        return;
    }
    for row in 0..2 {
        for i in 0..3 {
            out[row * 6 + i] = -by_world[(row, i)];
            out[row * 6 + 3 + i] = by_turn[(row, i)];
        }
    }
}
