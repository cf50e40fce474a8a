//! The division model.

use super::radial::{Radial, below, radial_projection, unit};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The division lens: one parameter, closed in both directions (Fitzgibbon 2001, eq. 1).
///
#[doc = include_str!("../../../docs/figures/lenses/division.svg")]
///
/// # Model
/// ```text
/// (ρ, Z) ∝ (r, 1 + λ r²)        ρ = √(X² + Y²)
/// ```
/// λ < 0 is a barrel, up to a fisheye of almost the whole sphere. Forward, λρ r² − Z r + ρ = 0 is solved for its root next to
/// ρ/Z.
///
/// # Domain
/// λ ≤ 0: all directions but straight back (λ = 0: Z > 0). λ > 0: Z > 2 √λ ρ, where the two roots meet.
///
/// # Example
/// By hand: r = ½ with λ = −1 is the direction (½, 0, ¾).
///
/// ```
/// use collinear::camera::{CentralProjection, Division};
/// use nalgebra::{Point2, Vector3};
///
/// let lens = Division::new(-1.0)?;
/// let p = lens.plane(&Vector3::new(0.5, 0.0, 0.75))?;
/// assert!((p - Point2::new(0.5, 0.0)).norm() < 1e-15);
/// // r = 2: beyond a right angle, (2, 0, −3).
/// assert!((lens.plane(&Vector3::new(2.0, 0.0, -3.0))? - Point2::new(2.0, 0.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Fitzgibbon", "SIMPLE_DIVISION", "DIVISION"))]
pub struct Division {
    lambda: f64,
}

radial_projection!(Division);

impl Division {
    /// From λ, for radii in units of the principal distance.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] beyond 10³⁰.
    pub fn new(lambda: f64) -> Result<Self, Error> {
        if !lambda.is_finite() {
            return Err(Error::NotFinite { what: "lambda of a division lens" });
        }
        if lambda.abs() > 1e30 {
            return Err(Error::OutOfRange {
                what: "lambda of a division lens",
                value: lambda,
                expected: "at most 1e30 in magnitude",
            });
        }
        Ok(Self { lambda })
    }

    /// λ.
    #[must_use]
    pub fn lambda(&self) -> f64 {
        self.lambda
    }

    /// r, and the root S = Z − 2λρr of the discriminant, for a direction of unit length.
    fn root(&self, rho: f64, z: f64) -> Result<[f64; 2], ProjectionError> {
        let discriminant = z * z - 4.0 * self.lambda * rho * rho;
        let in_front = if self.lambda < 0.0 { rho > 0.0 || z > 0.0 } else { z > 0.0 };
        if !in_front {
            return Err(ProjectionError::BehindCamera { depth: z });
        }
        if !(discriminant > 0.0) {
            let limit = 1.0 / (2.0 * float::sqrt(self.lambda));
            return Err(ProjectionError::OutsideDomain { value: rho / z, limit });
        }
        let s = float::sqrt(discriminant);
        // Either form of the root, the one whose terms have one sign.
        let r = if z > 0.0 { 2.0 * rho / (z + s) } else { (z - s) / (2.0 * self.lambda * rho) };
        Ok([r, s])
    }
}

impl Parametrised for Division {
    const NAME: &'static str = "division projection";
    const PARAMETERS: &'static [&'static str] = &["lambda"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.lambda], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [lambda] = parameters::read(values)?;
        Self::new(lambda)
    }
}

impl Radial for Division {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        let length = float::hypot(rho, z);
        let [r, s] = self.root(rho / length, z / length)?;
        // The equation's own derivatives: −S dr + (1 + λr²) dρ − r dZ = 0.
        let s = s * length;
        Ok([r, (1.0 + self.lambda * r * r) / s, -r / s])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        if self.lambda > 0.0 {
            below(r, 1.0 / float::sqrt(self.lambda))?;
        }
        Ok(unit(r, 1.0 + self.lambda * r * r))
    }

    fn radius_partials(&self, rho: f64, z: f64, out: &mut [f64]) {
        let length = float::hypot(rho, z);
        let rho = rho / length;
        if let Ok([r, s]) = self.root(rho, z / length) {
            parameters::write(&[rho * r * r / s], out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let formula = |[rho, z]: [Dual<8>; 2], [lambda]: [Dual<8>; 1]| {
            let s = (z * z - (lambda * rho * rho).scale(4.0)).sqrt();
            rho.scale(2.0) / (z + s)
        };
        let front = [[0.0, 2.0], [1e-9, 1.0], [0.3, 1.0], [1.0, 2.0]];
        let wide = [[0.3, 1.0], [4.0, 0.1], [2.0, -0.3]];
        check(&Division::new(0.11).unwrap(), formula, &front);
        check(&Division::new(-0.13).unwrap(), formula, &front);
        check(&Division::new(-0.5).unwrap(), formula, &wide);
        check(&Division::new(0.0).unwrap(), formula, &front);
    }
}
