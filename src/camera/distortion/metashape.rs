//! Agisoft Metashape's lens.

use super::planar::Planar;
use super::planar_distortion;
use crate::camera::{Parametrised, parameters};
use crate::error::Error;

/// Agisoft Metashape's radial and decentering distortion.
///
#[doc = include_str!("../../../docs/figures/lenses/metashape.svg")]
///
/// # Model
/// ```text
/// x′ = x (1 + K₁r² + K₂r⁴ + K₃r⁶ + K₄r⁸) + (P₁ (r² + 2x²) + 2 P₂ x y) (1 + P₃r² + P₄r⁴)
/// y′ = y (1 + K₁r² + K₂r⁴ + K₃r⁶ + K₄r⁸) + (P₂ (r² + 2y²) + 2 P₁ x y) (1 + P₃r² + P₄r⁴)
/// ```
/// (Agisoft, Metashape user manual, appendix *Camera models*, frame cameras), x right and y down. P₁ and P₂ change places
/// against OpenCV's p₁ and p₂. The manual's b₁ and b₂ belong to the interior orientation:
/// [`InteriorOrientation::from_metashape`](crate::camera::InteriorOrientation::from_metashape).
///
/// # Domain
/// A disc on which the map is one to one, found when the lens is made.
///
/// # Example
/// By hand at (½, 0): x′ = ½ (1 + 0.1/4) + ¾ P₁ (1 + P₃/4).
///
/// ```
/// use collinear::camera::{Distortion, Metashape};
/// use nalgebra::Point2;
///
/// let lens = Metashape::new([0.1, 0.0, 0.0, 0.0], [0.004, 0.0, 0.4, 0.0])?;
/// let p = lens.distort(&Point2::new(0.5, 0.0))?;
/// assert!((p - Point2::new(0.5125 + 0.003 * 1.1, 0.0)).norm() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("PhotoScan", "Agisoft"))]
pub struct Metashape(Planar<4, 0, 2, 0>);

planar_distortion!(Metashape);

impl Metashape {
    /// From K₁ to K₄ and P₁ to P₄.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 4], p: [f64; 4]) -> Result<Self, Error> {
        let [p1, p2, p3, p4] = p;
        Planar::new(k, [], [p2, p1], [p3, p4], [0.0; 4], 0.0).map(Self)
    }
}

impl Parametrised for Metashape {
    const NAME: &'static str = "lens distortion";
    // P₂ stands before P₁, as the formula's partial derivatives come.
    const PARAMETERS: &'static [&'static str] = &["K1", "K2", "K3", "K4", "P2", "P1", "P3", "P4"];

    fn values(&self, out: &mut [f64]) {
        let ([k1, k2, k3, k4], [p2, p1], [p3, p4]) = (self.0.k, self.0.p, self.0.q);
        parameters::write(&[k1, k2, k3, k4, p2, p1, p3, p4], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k1, k2, k3, k4, p2, p1, p3, p4] = parameters::read(values)?;
        Self::new([k1, k2, k3, k4], [p1, p2, p3, p4])
    }
}
