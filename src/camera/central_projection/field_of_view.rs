//! The one-parameter fisheye of Devernay and Faugeras.

use core::f64::consts::{FRAC_PI_2, PI};

use super::radial::{Radial, below, radial_projection, unit};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
#[cfg(test)]
use crate::numeric::scalar::Scalar;

/// The field-of-view lens: a fisheye of one parameter (Devernay & Faugeras 2001, eq. 13).
///
#[doc = include_str!("../../../docs/figures/lenses/field_of_view.svg")]
///
/// # Model
/// ```text
/// r = atan(2 r_u tan(ω/2)) / ω,   r_u = √(X² + Y²)/Z
/// ```
/// ω is the angle of an ideal fisheye that the lens comes near to; as it vanishes, r becomes r_u.
///
/// # Domain
/// Z > 0, 0 < ω < π.
///
/// # Example
/// By hand, ω = π/2 at 45°: tan(ω/2) = 1, r = atan(2)/(π/2).
///
/// ```
/// use collinear::camera::{CentralProjection, FieldOfView};
/// use nalgebra::Vector3;
///
/// let lens = FieldOfView::new(std::f64::consts::FRAC_PI_2)?;
/// let p = lens.plane(&Vector3::new(0.0, 1.0, 1.0))?;
/// assert!((p.y - 2f64.atan() / std::f64::consts::FRAC_PI_2).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("FOV", "ATAN"))]
pub struct FieldOfView {
    omega: f64,
    /// 2 tan(ω/2)
    spread: f64,
}

radial_projection!(FieldOfView);

impl FieldOfView {
    /// From ω in radians.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an ω that is not between 0 and π.
    pub fn new(omega: f64) -> Result<Self, Error> {
        if !(omega > 0.0 && omega < PI) {
            return Err(Error::OutOfRange {
                what: "omega of a field-of-view lens",
                value: omega,
                expected: "between 0 and π",
            });
        }
        let (sine, cosine) = float::sin_cos(0.5 * omega);
        Ok(Self { omega, spread: 2.0 * sine / cosine })
    }

    /// ω in radians.
    #[must_use]
    pub fn omega(&self) -> f64 {
        self.omega
    }
}

impl Parametrised for FieldOfView {
    const NAME: &'static str = "field-of-view projection";
    const PARAMETERS: &'static [&'static str] = &["omega"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.omega], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [omega] = parameters::read(values)?;
        Self::new(omega)
    }
}

impl Radial for FieldOfView {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        if !(z > 0.0) {
            return Err(ProjectionError::BehindCamera { depth: z });
        }
        let t = self.spread;
        let r = float::atan2(rho * t, z) / self.omega;
        let length = float::hypot(rho * t, z);
        let slope = t / (length * self.omega);
        Ok([r, slope * (z / length), -slope * (rho / length)])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        below(r, FRAC_PI_2 / self.omega)?;
        let (sine, cosine) = float::sin_cos(r * self.omega);
        Ok(unit(sine, cosine * self.spread))
    }

    fn radius_partials(&self, rho: f64, z: f64, out: &mut [f64]) {
        let t = self.spread;
        let length = float::hypot(rho * t, z);
        let by_spread = (rho / length) * (z / length);
        let r = float::atan2(rho * t, z) / self.omega;
        parameters::write(&[(by_spread * (1.0 + 0.25 * t * t) - r) / self.omega], out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let rays = [[1e-9, 1.0], [0.3, 1.0], [4.0, 0.1], [70.0, 0.2]];
        for omega in [0.02, 0.93, 2.4] {
            check(
                &FieldOfView::new(omega).unwrap(),
                |[rho, z], [omega]: [_; 1]| {
                    let (sine, cosine) = omega.scale(0.5).sin_cos();
                    (rho * sine.scale(2.0)).atan2(z * cosine) / omega
                },
                &rays,
            );
        }
    }
}
