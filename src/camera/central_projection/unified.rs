//! The sphere and the shifted centre: the unified model.

use super::radial::{Radial, below, radial_projection};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The unified projection: onto the unit sphere, and from a point ξ behind its centre onto the plane (Geyer & Daniilidis 2000;
/// Mei & Rives 2007, eq. 6).
///
#[doc = include_str!("../../../docs/figures/lenses/unified.svg")]
///
/// # Model
/// ```text
/// r = ρ / (Z + ξ R),   ρ = √(X² + Y²),   R = √(X² + Y² + Z²)
/// ```
/// ξ = 0 is the perspective, ξ = 1 half the stereographic radius; mirrors and fisheyes lie in between and above. With
/// [`Brown`](crate::camera::Brown) after it this is OpenCV's `omnidir` camera.
///
/// # Domain
/// ξ ≤ 1: Z > −ξ R. ξ > 1: Z > −R/ξ, where the radius is largest.
///
/// # Example
/// By hand: (3, 0, 4) has R = 5; with ξ = 0.4, r = 3/6.
///
/// ```
/// use collinear::camera::{CentralProjection, UnifiedSphere};
/// use nalgebra::{Point2, Vector3};
///
/// let lens = UnifiedSphere::new(0.4)?;
/// assert!((lens.plane(&Vector3::new(3.0, 0.0, 4.0))? - Point2::new(0.5, 0.0)).norm() < 1e-15);
/// assert!((lens.direction(&Point2::new(0.5, 0.0))? - Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Mei", "UCM", "omnidir", "catadioptric"))]
pub struct UnifiedSphere {
    xi: f64,
}

radial_projection!(UnifiedSphere);

impl UnifiedSphere {
    /// From ξ.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a ξ that is negative or beyond 10⁶.
    pub fn new(xi: f64) -> Result<Self, Error> {
        if !(0.0..=1e6).contains(&xi) {
            return Err(Error::OutOfRange {
                what: "xi of the unified projection",
                value: xi,
                expected: "between 0 and 1e6",
            });
        }
        Ok(Self { xi })
    }

    /// ξ.
    #[must_use]
    pub fn xi(&self) -> f64 {
        self.xi
    }
}

impl Parametrised for UnifiedSphere {
    const NAME: &'static str = "unified projection";
    const PARAMETERS: &'static [&'static str] = &["xi"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.xi], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [xi] = parameters::read(values)?;
        Self::new(xi)
    }
}

impl Radial for UnifiedSphere {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        let xi = self.xi;
        let length = float::hypot(rho, z);
        let (rho, z) = (rho / length, z / length);
        let limit = if xi > 1.0 { -1.0 / xi } else { -xi };
        if !(z > limit) {
            return Err(ProjectionError::BehindCamera { depth: (z - limit) * length });
        }
        let depth = z + xi;
        let slope = (1.0 + xi * z) / (depth * depth * length);
        Ok([rho / depth, z * slope, -rho * slope])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        let xi = self.xi;
        let inner = 1.0 + (1.0 - xi * xi) * r * r;
        if !(inner > 0.0) {
            below(r, 1.0 / float::sqrt(xi * xi - 1.0))?;
        }
        let eta = (xi + float::sqrt(inner)) / (1.0 + r * r);
        Ok([eta * r, eta - xi])
    }

    fn radius_partials(&self, rho: f64, z: f64, out: &mut [f64]) {
        let length = float::hypot(rho, z);
        let depth = z / length + self.xi;
        parameters::write(&[-(rho / length) / (depth * depth)], out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let formula = |[rho, z]: [Dual<8>; 2], [xi]: [Dual<8>; 1]| {
            rho / (z + xi * (rho * rho + z * z).sqrt())
        };
        let rays = [[1e-9, 1.0], [0.3, 1.0], [4.0, 0.1], [2.0, -0.3]];
        for xi in [0.4, 1.0, 1.7] {
            check(&UnifiedSphere::new(xi).unwrap(), formula, &rays);
        }
        check(&UnifiedSphere::new(0.0).unwrap(), formula, &rays[..3]);
    }
}
