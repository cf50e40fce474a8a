//! Yaw, pitch and roll.

use nalgebra::{Matrix3, Rotation3};

use super::sequence;
use crate::numeric::float;

const AXES: sequence::Axes = [2, 1, 0];

/// The yaw ψ, pitch θ and roll φ of an aircraft: turns about z, then the turned y, then the turned x.
///
/// ```text
/// body_from_ned = R₁(φ) R₂(θ) R₃(ψ)
///
/// ⎛ cosθ cosψ                      cosθ sinψ                     −sinθ      ⎞
/// ⎜ sinφ sinθ cosψ − cosφ sinψ     sinφ sinθ sinψ + cosφ cosψ     sinφ cosθ ⎟
/// ⎝ cosφ sinθ cosψ + sinφ sinψ     cosφ sinθ sinψ − sinφ cosψ     cosφ cosθ ⎠
/// ```
///
/// From the local level frame (x north, y east, z down) into the body (x forward, y right, z down). Yaw is clockwise
/// from north seen from above, pitch positive nose up, roll positive right wing down. MathWorks' `angle2dcm` is this matrix,
/// `eul2rotm` its transpose.
///
/// Angles are radians. A NaN or infinite angle gives a matrix with NaN in it. How the camera sits in the body is a second
/// rotation: [`nadir_camera_from_body`](super::nadir_camera_from_body) and
/// [`forward_camera_from_body`](super::forward_camera_from_body) are the two common ones.
///
/// # Example
/// The first example of MathWorks' page on `angle2dcm` (Aerospace Toolbox).
/// ```
/// use collinear::geometry::rotation::YawPitchRoll;
///
/// let m = YawPitchRoll { yaw: 0.7854, pitch: 0.1, roll: 0.0 }.body_from_ned();
/// let printed = [[0.7036, 0.7036, -0.0998], [-0.7071, 0.7071, 0.0], [0.0706, 0.0706, 0.9950]];
/// for i in 0..3 {
///     for j in 0..3 {
///         assert!((m[(i, j)] - printed[i][j]).abs() < 0.5e-4);
///     }
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("heading", "attitude", "ypr", "euler"))]
pub struct YawPitchRoll {
    /// ψ, about z (down): clockwise from north, seen from above.
    pub yaw: f64,
    /// θ, about the y axis that ψ has turned: positive nose up.
    pub pitch: f64,
    /// φ, about the x axis of the body: positive right wing down.
    pub roll: f64,
}

impl YawPitchRoll {
    fn turns(&self) -> [(f64, f64); 3] {
        [self.yaw, self.pitch, self.roll].map(float::sin_cos)
    }

    /// From north-east-down axes into the body's.
    #[must_use]
    pub fn body_from_ned(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(sequence::to_matrix3(sequence::matrix(AXES, self.turns())))
    }

    /// The angles of a rotation, yaw and roll in (−π, π], pitch in [−π/2, π/2].
    ///
    /// Where cos θ ≤ 2.2e-16 (gimbal lock, a body that points straight down or up) only yaw ± roll is determined: the roll is
    /// set to zero, so that a camera on a gimbal at pitch −90° keeps its heading. The angles give the matrix back within
    /// 4 ε in every element. All three are NaN where an element is NaN or infinite.
    #[must_use]
    pub fn from_body_from_ned(body_from_ned: &Rotation3<f64>) -> Self {
        // The transpose is the sequence of the opposite turns from the last to the first; its first angle is the roll.
        let [c, b, a] = AXES;
        let [roll, pitch, yaw] = sequence::angles([a, b, c], &body_from_ned.matrix().transpose());
        let opposite = sequence::opposite;
        Self { yaw: opposite(yaw), pitch: -pitch, roll: opposite(roll) }
    }

    /// The matrix whose columns are the left rotation vectors of a unit change of yaw, pitch, roll: with B =
    /// `body_from_ned`, δB = \[δθ\]× B and δθ = J (δψ, δθ, δφ)ᵀ. Singular where cos θ = 0.
    #[must_use]
    pub fn left_from_angles(&self) -> Matrix3<f64> {
        sequence::left(AXES, self.turns())
    }
}
