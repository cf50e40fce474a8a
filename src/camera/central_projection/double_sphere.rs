//! The double sphere model.

use super::enhanced_unified::{check_alpha, limit};
use super::radial::{Radial, below, radial_projection, unit};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The double sphere projection: onto two spheres, ξ apart, then onto the plane (Usenko, Demmel & Cremers 2018, eq. 40 to 48).
///
#[doc = include_str!("../../../docs/figures/lenses/double_sphere.svg")]
///
/// # Model
/// ```text
/// r = ρ / (α √(ρ² + w²) + (1 − α) w),   w = ξ R + Z,   ρ = √(X² + Y²),   R = √(X² + Y² + Z²)
/// ```
/// ξ = 0 is the [unified](super::UnifiedSphere) model in α, its radius divided by 1 − α.
///
/// # Domain
/// w > −w₁ √(ρ² + w²), with w₁ = α/(1 − α) up to α = ½, where the radius grows beyond all bounds, and (1 − α)/α above, where it
/// is largest. As a bound of Z that is Z > −(ξ + w₁d) R with d = √(1 − ξ² (1 − w₁²)) − w₁ξ. (The paper's eq. 45 shifts the
/// bound by ξ times the wrong one of the two lengths and cuts a few degrees off.)
///
/// # Example
/// By hand: (6, 0, 8) has R = 10; with ξ = 0 and α = ½ the radius is 6/(½ · 10 + ½ · 8).
///
/// ```
/// use collinear::camera::{CentralProjection, DoubleSphere};
/// use nalgebra::{Point2, Vector3};
///
/// let lens = DoubleSphere::new(0.0, 0.5)?;
/// let p = lens.plane(&Vector3::new(6.0, 0.0, 8.0))?;
/// assert!((p - Point2::new(2.0 / 3.0, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("DS"))]
pub struct DoubleSphere {
    xi: f64,
    alpha: f64,
    /// ξ + w₁d
    limit: f64,
}

radial_projection!(DoubleSphere);

impl DoubleSphere {
    /// From ξ and α.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a ξ that is not between −1 and 1, or an α that is not between 0 and 1.
    pub fn new(xi: f64, alpha: f64) -> Result<Self, Error> {
        check_alpha(alpha)?;
        if !(xi > -1.0 && xi < 1.0) {
            let expected = "between -1 and 1";
            return Err(Error::OutOfRange { what: "xi of the double sphere", value: xi, expected });
        }
        let w1 = limit(alpha);
        let d = float::sqrt(1.0 - xi * xi * (1.0 - w1 * w1)) - w1 * xi;
        let limit = xi + w1 * d;
        Ok(Self { xi, alpha, limit })
    }

    /// w and the denominator for a direction of unit length, with d₂.
    fn denominator(&self, rho: f64, z: f64) -> [f64; 3] {
        let w = self.xi + z;
        let d2 = float::sqrt(rho * rho + w * w);
        [w, d2, self.alpha * d2 + (1.0 - self.alpha) * w]
    }
}

impl Parametrised for DoubleSphere {
    const NAME: &'static str = "double sphere projection";
    const PARAMETERS: &'static [&'static str] = &["xi", "alpha"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.xi, self.alpha], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [xi, alpha] = parameters::read(values)?;
        Self::new(xi, alpha)
    }
}

impl Radial for DoubleSphere {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        let (xi, alpha) = (self.xi, self.alpha);
        let length = float::hypot(rho, z);
        let (rho, z) = (rho / length, z / length);
        let past = z + self.limit;
        let [w, d2, depth] = self.denominator(rho, z);
        if !(past > 0.0 && depth > 0.0) {
            return Err(ProjectionError::BehindCamera { depth: past * length });
        }
        // ∂depth/∂ρ and ∂depth/∂Z at R = 1: ∂w = (ξρ, ξz + 1).
        let by_w = alpha * w / d2 + 1.0 - alpha;
        let by_rho = alpha * rho / d2 + by_w * xi * rho;
        let by_z = by_w * (xi * z + 1.0);
        let scale = depth * depth * length;
        Ok([rho / depth, (depth - rho * by_rho) / scale, -rho * by_z / scale])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        let (xi, alpha) = (self.xi, self.alpha);
        let inner = 1.0 - (2.0 * alpha - 1.0) * r * r;
        if !(inner > 0.0) {
            below(r, 1.0 / float::sqrt(2.0 * alpha - 1.0))?;
        }
        let m = (1.0 - alpha * alpha * r * r) / (alpha * float::sqrt(inner) + 1.0 - alpha);
        // On the second sphere (r, m); back to the first, whose centre lies ξ away.
        let [rho, w] = unit(r, m);
        let second = w * xi + float::sqrt(1.0 - xi * xi * rho * rho);
        Ok(unit(second * rho, second * w - xi))
    }

    fn radius_partials(&self, rho: f64, z: f64, out: &mut [f64]) {
        let length = float::hypot(rho, z);
        let (rho, z) = (rho / length, z / length);
        let [w, d2, depth] = self.denominator(rho, z);
        let slope = -rho / (depth * depth);
        let by_w = self.alpha * w / d2 + 1.0 - self.alpha;
        parameters::write(&[slope * by_w, slope * (d2 - w)], out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let formula = |[rho, z]: [Dual<8>; 2], [xi, alpha]: [Dual<8>; 2]| {
            let w = xi * (rho * rho + z * z).sqrt() + z;
            rho / (alpha * (rho * rho + w * w).sqrt() + (Dual::constant(1.0) - alpha) * w)
        };
        let rays = [[1e-9, 1.0], [0.3, 1.0], [4.0, 0.1], [2.0, -0.1]];
        for (xi, alpha) in [(-0.18, 0.59), (0.3, 0.4), (-0.27, 0.57)] {
            check(&DoubleSphere::new(xi, alpha).unwrap(), formula, &rays);
        }
    }
}
