//! Brown's radial and decentering distortion.

use super::planar::Planar;
use super::planar_distortion;
use crate::camera::{Parametrised, parameters};
use crate::error::Error;

/// Radial and decentering distortion of normalised image points (Brown 1971).
///
#[doc = include_str!("../../../docs/figures/lenses/brown.svg")]
///
/// # Model
/// ```text
/// x″ = x (1 + k₁r² + k₂r⁴ + k₃r⁶) + 2 p₁ x y + p₂ (r² + 2x²)
/// y″ = y (1 + k₁r² + k₂r⁴ + k₃r⁶) + p₁ (r² + 2y²) + 2 p₂ x y        r² = x² + y²
/// ```
/// with the signs and the order of p₁, p₂ of OpenCV and COLMAP. (x, y) = (X/Z, Y/Z) in camera axes, y down.
///
/// # Domain
/// The Jacobian is symmetric, so the map is the gradient of a potential, which is convex as long as both eigenvalues
/// stay positive. The *fold radius* is the smallest positive root of
///
/// ```text
/// 1 − 6 √(p₁² + p₂²) r + 3 k₁ r² + 5 k₂ r⁴ + 7 k₃ r⁶ = 0
/// 1 − 6 √(p₁² + p₂²) r +   k₁ r² +   k₂ r⁴ +   k₃ r⁶ = 0
/// ```
///
/// Where the first has it, as that of every barrel, an eigenvalue vanishes on this circle; the second is a lower bound, which lenses of
/// weak decentering meet far outside any picture. Within the fold radius the map is one to one; beyond it the polynomial runs back and would place points from outside the field in
/// the middle of the picture. Such points are refused.
///
/// # Accuracy
/// The inverse is found by damped Newton steps, which always converge inside the fold; it ends when the residual is at the
/// rounding floor. Its error is the residual over the smallest eigenvalue of the Jacobian.
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` of (0.31, −0.22, 1) with these coefficients:
///
/// ```
/// use collinear::camera::{Brown, Distortion};
/// use nalgebra::Point2;
///
/// let lens = Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4])?;
/// let p = lens.distort(&Point2::new(0.31, -0.22))?;
/// assert!((p - Point2::new(0.2976076220865975, -0.21111218341629498)).norm() < 1e-15);
/// let back = lens.undistort(&p)?;
/// assert!((back.point - Point2::new(0.31, -0.22)).norm() < 1e-15 && back.iterations <= 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Brown-Conrady", "radtan", "plumb bob", "OPENCV", "Pix4D"))]
pub struct Brown(Planar<3, 0, 1, 0>);

planar_distortion!(Brown);

impl Brown {
    /// From k₁, k₂, k₃ and p₁, p₂.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 3], p: [f64; 2]) -> Result<Self, Error> {
        Planar::new(k, [], p, [0.0; 2], [0.0; 4], 0.0).map(Self)
    }

    /// No distortion.
    #[must_use]
    pub fn none() -> Self {
        Self(Planar::none())
    }

    /// (k₁, k₂, k₃).
    #[must_use]
    pub fn radial(&self) -> [f64; 3] {
        self.0.k
    }

    /// (p₁, p₂).
    #[must_use]
    pub fn decentering(&self) -> [f64; 2] {
        self.0.p
    }
}

impl Parametrised for Brown {
    const NAME: &'static str = "lens distortion";
    const PARAMETERS: &'static [&'static str] = &["k1", "k2", "k3", "p1", "p2"];

    fn values(&self, out: &mut [f64]) {
        let ([k1, k2, k3], [p1, p2]) = (self.0.k, self.0.p);
        parameters::write(&[k1, k2, k3, p1, p2], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k1, k2, k3, p1, p2] = parameters::read(values)?;
        Self::new([k1, k2, k3], [p1, p2])
    }
}
