//! Azimuth, tilt and swing.

use nalgebra::{Matrix3, Rotation3};

use super::sequence;
use crate::numeric::float;

const AXES: sequence::Axes = [2, 0, 2];

/// The azimuth α, tilt t and swing s of a photograph.
///
/// ```text
/// M = R₃(s − π) R₁(t) R₃(−α)
///
/// m₁₁ = −cosα coss − sinα cost sins    m₁₂ =  sinα coss − cosα cost sins    m₁₃ = −sint sins
/// m₂₁ =  cosα sins − sinα cost coss    m₂₂ = −sinα sins − cosα cost coss    m₂₃ = −sint coss
/// m₃₁ = −sinα sint                     m₃₂ = −cosα sint                     m₃₃ =  cost
/// ```
///
/// The elements are those of B. A. Dewitt's program 3DCONF (1998), the implementation of Dewitt, *Initial
/// approximations for the three-dimensional conformal coordinate transformation*, PE&RS 62 (1996). M is
/// `photo_from_world` in the photogrammetric system (x right, y up, looking along −z).
///
/// The coastal imaging toolbox CIRN (Bruder & Brodie 2020) has the same azimuth and tilt, and a swing that is 0 for an
/// upright photograph: s − π. Its camera axes are x left, y up, z forward.
///
/// The principal plane holds the optical axis and the vertical. Angles are radians. A NaN or infinite angle gives a
/// matrix with NaN in it.
///
/// # Example
/// Set 2 of RSpincalc's `demo/testRSpincalc.R`, a moderately tilted photograph: its zxz triple is (−α, t, s − π), and
/// its xyz triple the ω, φ, κ of the same matrix.
/// ```
/// use collinear::geometry::rotation::{AzimuthTiltSwing, OmegaPhiKappa};
/// use std::f64::consts::PI;
///
/// let tilted = AzimuthTiltSwing { azimuth: -1.6193689, tilt: 0.4818253, swing: -2.523541 + PI };
/// let angles = OmegaPhiKappa::from_photo_from_world(&tilted.photo_from_world());
/// assert!((angles.omega + 0.02538478).abs() < 1e-6);
/// assert!((angles.phi - 0.4812086).abs() < 1e-6);
/// assert!((angles.kappa + 0.897943).abs() < 1e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AzimuthTiltSwing {
    /// α, of the principal plane: clockwise from +Y (north) to the direction in which the optical axis leans.
    pub azimuth: f64,
    /// t, between the optical axis and the plumb line: 0 is vertical, π/2 is horizontal.
    pub tilt: f64,
    /// s, in the photograph: clockwise from +y to the principal line on the nadir side. π for an upright photograph.
    pub swing: f64,
}

impl AzimuthTiltSwing {
    fn turns(&self) -> [(f64, f64); 3] {
        let (sine, cosine) = float::sin_cos(self.swing);
        [float::sin_cos(-self.azimuth), float::sin_cos(self.tilt), (-sine, -cosine)]
    }

    /// M.
    #[must_use]
    pub fn photo_from_world(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(sequence::to_matrix3(sequence::matrix(AXES, self.turns())))
    }

    /// The angles of M, azimuth and swing in (−π, π], tilt in [0, π].
    ///
    /// Where sin t ≤ 2.2e-16 (a vertical photograph) the principal plane is not determined: the azimuth is set to zero and
    /// the swing carries the whole turn. The angles give M back within 4 ε in every element. All three are NaN where an
    /// element is NaN or infinite.
    #[must_use]
    pub fn from_photo_from_world(photo_from_world: &Rotation3<f64>) -> Self {
        let [azimuth, tilt, swing] = sequence::angles_azimuth_tilt_swing(photo_from_world.matrix());
        Self { azimuth, tilt, swing }
    }

    /// The matrix whose columns are the left rotation vectors of a unit change of azimuth, tilt, swing: δM = \[δθ\]× M and
    /// δθ = J (δα, δt, δs)ᵀ. Singular for a vertical photograph.
    #[must_use]
    pub fn left_from_angles(&self) -> Matrix3<f64> {
        let mut left = sequence::left(AXES, self.turns());
        left.column_mut(0).neg_mut();
        left
    }
}
