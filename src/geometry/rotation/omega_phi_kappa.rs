//! Omega, phi, kappa.

use nalgebra::{Matrix3, Rotation3};

use super::sequence;
use crate::numeric::float;

const AXES: sequence::Axes = [0, 1, 2];

/// The angles ω, φ, κ of a photograph: turns about x, then the turned y, then the turned z.
///
/// ```text
///                        ⎛  cosκ  sinκ  0 ⎞ ⎛ cosφ  0  −sinφ ⎞ ⎛ 1    0      0   ⎞
/// M = R₃(κ)R₂(φ)R₁(ω) =  ⎜ −sinκ  cosκ  0 ⎟ ⎜  0    1    0   ⎟ ⎜ 0   cosω   sinω ⎟
///                        ⎝   0     0    1 ⎠ ⎝ sinφ  0   cosφ ⎠ ⎝ 0  −sinω   cosω ⎠
/// ```
///
/// M is `photo_from_world`, from the world (X east, Y north, Z up) into the photogrammetric system (x right, y up,
/// looking along −z). It is the M of Wolf & Dewitt and of Mikhail, Bethel & McGlone. Its transpose, `world_from_photo`, is
/// the R of Kraus, of PATB and of Pix4D, with the same three angles.
///
/// Angles are radians. A NaN or infinite angle gives a matrix with NaN in it.
///
/// # Example
/// Set 1 of `demo/testRSpincalc.R` of the R package RSpincalc 1.0.2 (sequence xyz), with the matrix its manual prints.
/// ```
/// use collinear::geometry::rotation::OmegaPhiKappa;
///
/// let angles = OmegaPhiKappa { omega: 2.07603606, phi: -0.7402790, kappa: -1.376712 };
/// let m = angles.photo_from_world();
/// let printed = [
///     [0.1423907, 0.3610947, -0.9215940],
///     [0.7244189, -0.6724915, -0.1515663],
///     [-0.6744939, -0.6460385, -0.3573404],
/// ];
/// for i in 0..3 {
///     for j in 0..3 {
///         assert!((m[(i, j)] - printed[i][j]).abs() < 1.5e-7);
///     }
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("opk", "euler"))]
pub struct OmegaPhiKappa {
    /// ω, about x; positive lifts the photograph's +y edge.
    pub omega: f64,
    /// φ, about the y axis that ω has turned.
    pub phi: f64,
    /// κ, about the z axis that ω and φ have turned; positive turns the photograph counter-clockwise.
    pub kappa: f64,
}

impl OmegaPhiKappa {
    fn turns(&self) -> [(f64, f64); 3] {
        [self.omega, self.phi, self.kappa].map(float::sin_cos)
    }

    /// M.
    #[must_use]
    pub fn photo_from_world(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(sequence::to_matrix3(sequence::matrix(AXES, self.turns())))
    }

    /// The angles of M, ω and κ in (−π, π], φ in [−π/2, π/2].
    ///
    /// Where cos φ ≤ 2.2e-16 (gimbal lock) only κ ± ω is determined: ω is set to zero. The angles give M back within 4 ε in
    /// every element, near the lock too. All three are NaN where an element is NaN or infinite.
    #[must_use]
    pub fn from_photo_from_world(photo_from_world: &Rotation3<f64>) -> Self {
        let [omega, phi, kappa] = sequence::angles(AXES, photo_from_world.matrix());
        Self { omega, phi, kappa }
    }

    /// The matrix whose columns are the left rotation vectors of a unit change of ω, φ, κ.
    ///
    /// ```text
    /// δM = \[δθ\]× M,    δθ = J (δω, δφ, δκ)ᵀ,    J = −( R₃R₂e₁  R₃e₂  e₃ )
    /// ```
    ///
    /// An adjustment that solves for δθ turns its result, and its covariance, into angles by J⁻¹. J is singular where
    /// cos φ = 0.
    #[must_use]
    pub fn left_from_angles(&self) -> Matrix3<f64> {
        sequence::left(AXES, self.turns())
    }
}
