//! Phi, omega, kappa.

use nalgebra::{Matrix3, Rotation3};

use super::sequence;
use crate::numeric::float;

const AXES: sequence::Axes = [1, 0, 2];

/// The angles φ, ω, κ of a photograph, with y as first axis: the form of Chinese and of older German texts.
///
/// ```text
/// R = Rφ Rω Rκ
///
/// a₁ = cosφ cosκ − sinφ sinω sinκ    a₂ = −cosφ sinκ − sinφ sinω cosκ    a₃ = −sinφ cosω
/// b₁ = cosω sinκ                     b₂ = cosω cosκ                      b₃ = −sinω
/// c₁ = sinφ cosκ + cosφ sinω sinκ    c₂ = −sinφ sinκ + cosφ sinω cosκ    c₃ = cosφ cosω
/// ```
///
/// R has the rows a, b, c and is `world_from_photo` (X = R x); [`photo_from_world`](Self::photo_from_world) is its
/// transpose. φ has the sign opposite to the φ of [`OmegaPhiKappa`](super::OmegaPhiKappa): it is positive from Z towards −X,
/// which makes Rᵀ = R₃(κ) R₁(ω) R₂(−φ).
///
/// Angles are radians. A NaN or infinite angle gives a matrix with NaN in it.
///
/// # Example
/// The single-photo resection of Wuhan University's textbook Photogrammetry: the computed angles, and R to five decimals.
/// ```
/// use collinear::geometry::rotation::PhiOmegaKappa;
///
/// let angles = PhiOmegaKappa { phi: -0.0039869, omega: 0.0021139, kappa: -0.0675780 };
/// let r = angles.world_from_photo();
/// let printed =
///     [[0.99771, 0.06753, 0.00399], [-0.06753, 0.99772, -0.00211], [-0.00412, 0.00184, 0.99999]];
/// for i in 0..3 {
///     for j in 0..3 {
///         assert!((r[(i, j)] - printed[i][j]).abs() < 0.5e-5);
///     }
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhiOmegaKappa {
    /// φ, about y, positive from Z towards −X.
    pub phi: f64,
    /// ω, about the x axis that φ has turned.
    pub omega: f64,
    /// κ, about the z axis that φ and ω have turned; positive turns the photograph counter-clockwise.
    pub kappa: f64,
}

impl PhiOmegaKappa {
    fn turns(&self) -> [(f64, f64); 3] {
        [-self.phi, self.omega, self.kappa].map(float::sin_cos)
    }

    /// Rᵀ.
    #[must_use]
    pub fn photo_from_world(&self) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(sequence::to_matrix3(sequence::matrix(AXES, self.turns())))
    }

    /// R, the matrix of a₁ … c₃.
    #[must_use]
    pub fn world_from_photo(&self) -> Rotation3<f64> {
        self.photo_from_world().inverse()
    }

    /// The angles of a rotation, φ and κ in (−π, π], ω in [−π/2, π/2].
    ///
    /// Where cos ω ≤ 2.2e-16 (gimbal lock) only κ ± φ is determined: φ is set to zero. The angles give the matrix back
    /// within 4 ε in every element. All three are NaN where an element is NaN or infinite.
    #[must_use]
    pub fn from_photo_from_world(photo_from_world: &Rotation3<f64>) -> Self {
        let [turn, omega, kappa] = sequence::angles(AXES, photo_from_world.matrix());
        // The first turn of the sequence is by −φ.
        Self { phi: sequence::opposite(turn), omega, kappa }
    }

    /// The matrix whose columns are the left rotation vectors of a unit change of φ, ω, κ: with M = `photo_from_world`,
    /// δM = \[δθ\]× M and δθ = J (δφ, δω, δκ)ᵀ. Singular where cos ω = 0.
    #[must_use]
    pub fn left_from_angles(&self) -> Matrix3<f64> {
        let mut left = sequence::left(AXES, self.turns());
        left.column_mut(0).neg_mut();
        left
    }
}
