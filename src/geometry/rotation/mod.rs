//! Rotations in every convention of the field, and the axes that stand behind them.
//!
//! Each type is a value with public fields. It gives its matrix under the name of what the matrix does
//! (`photo_from_world`), comes back from it (`from_photo_from_world`) with a documented choice in gimbal lock, and says
//! how a change of its angles turns the frame (`left_from_angles`). From one convention to another the way leads over
//! the matrix.
//!
//! | Type                 | Matrix                                    | Sense              | In gimbal lock |
//! |----------------------|-------------------------------------------|--------------------|----------------|
//! | [`OmegaPhiKappa`]    | R₃(κ) R₂(φ) R₁(ω)                         | `photo_from_world` | ω = 0          |
//! | [`PhiOmegaKappa`]    | (Rφ Rω Rκ)ᵀ = R₃(κ) R₁(ω) R₂(−φ)          | `photo_from_world` | φ = 0          |
//! | [`AzimuthTiltSwing`] | R₃(s − π) R₁(t) R₃(−α)                    | `photo_from_world` | α = 0          |
//! | [`YawPitchRoll`]     | R₁(φ) R₂(θ) R₃(ψ)                         | `body_from_ned`    | φ (roll) = 0   |
//! | [`Quaternion`]       | v ↦ q v q⁻¹                               | its user's         | none           |
//! | [`RotationVector`]   | exp(\[r\]×)                                 | its user's         | none           |
//!
//! R₁, R₂, R₃ turn the axes about x, y, z by a counter-clockwise angle:
//!
//! ```text
//!         ⎛ 1   0     0   ⎞           ⎛ cosθ  0  −sinθ ⎞           ⎛  cosθ  sinθ  0 ⎞
//! R₁(θ) = ⎜ 0  cosθ  sinθ ⎟   R₂(θ) = ⎜  0    1    0   ⎟   R₃(θ) = ⎜ −sinθ  cosθ  0 ⎟
//!         ⎝ 0 −sinθ  cosθ ⎠           ⎝ sinθ  0   cosθ ⎠           ⎝   0     0    1 ⎠
//! ```
//!
//! | Frame  | x       | y     | z       | Used by |
//! |--------|---------|-------|---------|---------|
//! | camera | right   | down  | forward | every camera of this crate, OpenCV, COLMAP |
//! | photo  | right   | up    | back    | photogrammetry; OpenGL's eye axes are the same |
//! | body   | forward | right | down    | aircraft |
//! | ENU    | east    | north | up      | maps |
//! | NED    | north   | east  | down    | navigation |
//!
#![doc = include_str!("../../../docs/figures/rotation.svg")]

mod azimuth_tilt_swing;
mod omega_phi_kappa;
mod orthonormalised;
mod phi_omega_kappa;
mod quaternion;
mod rotation_vector;
mod sequence;
mod yaw_pitch_roll;

use nalgebra::{Matrix3, Rotation3};

pub use azimuth_tilt_swing::AzimuthTiltSwing;
pub use omega_phi_kappa::OmegaPhiKappa;
pub use orthonormalised::orthonormalised;
pub use phi_omega_kappa::PhiOmegaKappa;
pub use quaternion::Quaternion;
pub use rotation_vector::RotationVector;
pub use yaw_pitch_roll::YawPitchRoll;

/// diag(1, −1, −1): from the photogrammetric system (x right, y up, looking along −z), which is OpenGL's eye system too,
/// into camera axes (x right, y down, z forward). It is its own inverse.
///
/// ```
/// use collinear::geometry::rotation::{OmegaPhiKappa, camera_from_photo};
/// use collinear::nalgebra::Vector3;
///
/// // A vertical photograph, ω = φ = κ = 0: the camera looks down, and north is up in the picture.
/// let vertical = OmegaPhiKappa { omega: 0.0, phi: 0.0, kappa: 0.0 };
/// let camera_from_world = camera_from_photo() * vertical.photo_from_world();
/// assert_eq!(camera_from_world * Vector3::new(0.0, 0.0, -1.0), Vector3::new(0.0, 0.0, 1.0));
/// assert_eq!(camera_from_world * Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, -1.0, 0.0));
/// ```
#[must_use]
pub const fn camera_from_photo() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0))
}

/// From east-north-up axes into north-east-down. It is its own inverse.
///
/// ```
/// use collinear::geometry::rotation::ned_from_enu;
/// use collinear::nalgebra::Vector3;
///
/// // North and up.
/// assert_eq!(ned_from_enu() * Vector3::new(0.0, 1.0, 2.0), Vector3::new(1.0, 0.0, -2.0));
/// ```
#[must_use]
#[doc(alias = "enu_from_ned")]
pub const fn ned_from_enu() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0))
}

/// The mounting of a camera that looks through the floor of its aircraft, the top of the image towards the nose: from body
/// axes (x forward, y right, z down) into camera axes.
///
/// With it, yaw 0 puts north at the top of the image and yaw 90° east, pitch 90° makes the camera look forward: the
/// angles of Pix4D's geolocation files (support article 202558969).
///
/// ```
/// use collinear::geometry::rotation::{
///     OmegaPhiKappa, YawPitchRoll, camera_from_photo, nadir_camera_from_body, ned_from_enu,
/// };
///
/// // Level flight on a heading of 30°: κ = −30°.
/// let attitude = YawPitchRoll { yaw: 30f64.to_radians(), pitch: 0.0, roll: 0.0 };
/// let camera_from_enu = nadir_camera_from_body() * attitude.body_from_ned() * ned_from_enu();
/// let angles = OmegaPhiKappa::from_photo_from_world(&(camera_from_photo().inverse() * camera_from_enu));
/// assert!(angles.omega.abs() < 1e-15 && angles.phi.abs() < 1e-15);
/// assert!((angles.kappa + 30f64.to_radians()).abs() < 1e-15);
/// ```
#[must_use]
pub const fn nadir_camera_from_body() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
}

/// The mounting of a camera that looks forward along the nose, the top of the image upwards, as a gimbal's at pitch 0:
/// from body axes (x forward, y right, z down) into camera axes.
///
/// ```
/// use collinear::geometry::rotation::forward_camera_from_body;
/// use collinear::nalgebra::Vector3;
///
/// // 1 forward, 2 right, 3 down.
/// assert_eq!(forward_camera_from_body() * Vector3::new(1.0, 2.0, 3.0), Vector3::new(2.0, 3.0, 1.0));
/// ```
#[must_use]
pub const fn forward_camera_from_body() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0))
}
