//! The enhanced unified model.

use super::radial::{Radial, below, radial_projection, unit};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The enhanced unified projection: onto an ellipsoid instead of a sphere (Khomutenko, Garcia & Martinet 2016, eq. 6).
///
#[doc = include_str!("../../../docs/figures/lenses/enhanced_unified.svg")]
///
/// # Model
/// ```text
/// r = ρ / (α √(βρ² + Z²) + (1 − α) Z),   ρ = √(X² + Y²)
/// ```
/// α = 0 is the perspective; with β = 1 it is the [unified](super::UnifiedSphere) model of ξ = α/(1 − α), its radius divided by
/// 1 − α. COLMAP's `EUCM`.
///
/// # Domain
/// With d = √(βρ² + Z²): Z > −d α/(1 − α) up to α = ½, Z > −d (1 − α)/α above, where the radius is largest.
///
/// # Example
/// By hand: (2, 0, 3) with β = 4 has d = 5; with α = ½, r = 2/4.
///
/// ```
/// use collinear::camera::{CentralProjection, EnhancedUnified};
/// use nalgebra::{Point2, Vector3};
///
/// let lens = EnhancedUnified::new(0.5, 4.0)?;
/// assert!((lens.plane(&Vector3::new(2.0, 0.0, 3.0))? - Point2::new(0.5, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("EUCM"))]
pub struct EnhancedUnified {
    alpha: f64,
    beta: f64,
}

radial_projection!(EnhancedUnified);

/// The cosine, measured with d, beyond which a model of this α ends: Z > −w d.
pub(super) fn limit(alpha: f64) -> f64 {
    if alpha <= 0.5 { alpha / (1.0 - alpha) } else { (1.0 - alpha) / alpha }
}

pub(super) fn check_alpha(alpha: f64) -> Result<(), Error> {
    if (0.0..=1.0).contains(&alpha) {
        return Ok(());
    }
    let expected = "between 0 and 1";
    Err(Error::OutOfRange { what: "alpha of the projection", value: alpha, expected })
}

impl EnhancedUnified {
    /// From α and β.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an α that is not between 0 and 1, or a β that is not between 10⁻⁶ and 10⁶.
    pub fn new(alpha: f64, beta: f64) -> Result<Self, Error> {
        check_alpha(alpha)?;
        if !(1e-6..=1e6).contains(&beta) {
            return Err(Error::OutOfRange {
                what: "beta of the enhanced unified projection",
                value: beta,
                expected: "between 1e-6 and 1e6",
            });
        }
        Ok(Self { alpha, beta })
    }

    /// d/R, and the denominator over R, for a direction of unit length.
    fn denominator(&self, rho: f64, z: f64) -> [f64; 2] {
        let d = float::sqrt(self.beta * rho * rho + z * z);
        [d, self.alpha * d + (1.0 - self.alpha) * z]
    }
}

impl Parametrised for EnhancedUnified {
    const NAME: &'static str = "enhanced unified projection";
    const PARAMETERS: &'static [&'static str] = &["alpha", "beta"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.alpha, self.beta], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [alpha, beta] = parameters::read(values)?;
        Self::new(alpha, beta)
    }
}

impl Radial for EnhancedUnified {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        let length = float::hypot(rho, z);
        let (rho, z) = (rho / length, z / length);
        let [d, depth] = self.denominator(rho, z);
        let past = z + limit(self.alpha) * d;
        if !(past > 0.0 && depth > 0.0) {
            return Err(ProjectionError::BehindCamera { depth: past * length });
        }
        let slope = (self.alpha * z / d + 1.0 - self.alpha) / (depth * depth * length);
        Ok([rho / depth, z * slope, -rho * slope])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        let (alpha, beta) = (self.alpha, self.beta);
        let inner = 1.0 - (2.0 * alpha - 1.0) * beta * r * r;
        if !(inner > 0.0) {
            below(r, 1.0 / float::sqrt((2.0 * alpha - 1.0) * beta))?;
        }
        let z = (1.0 - beta * alpha * alpha * r * r) / (alpha * float::sqrt(inner) + 1.0 - alpha);
        Ok(unit(r, z))
    }

    fn radius_partials(&self, rho: f64, z: f64, out: &mut [f64]) {
        let length = float::hypot(rho, z);
        let (rho, z) = (rho / length, z / length);
        let [d, depth] = self.denominator(rho, z);
        let slope = -rho / (depth * depth);
        parameters::write(&[slope * (d - z), slope * 0.5 * self.alpha * rho * rho / d], out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let formula = |[rho, z]: [Dual<8>; 2], [alpha, beta]: [Dual<8>; 2]| {
            let d = (beta * rho * rho + z * z).sqrt();
            rho / (alpha * d + (Dual::constant(1.0) - alpha) * z)
        };
        let rays = [[1e-9, 1.0], [0.3, 1.0], [4.0, 0.1], [2.0, -0.1]];
        for (alpha, beta) in [(0.31, 0.8), (0.57, 1.13), (0.9, 1.0)] {
            check(&EnhancedUnified::new(alpha, beta).unwrap(), formula, &rays);
        }
    }
}
