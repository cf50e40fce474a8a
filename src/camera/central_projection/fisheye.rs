//! The four classical fisheye projections.

use core::f64::consts::{FRAC_PI_2, PI};

use super::radial::{Radial, below, radial_projection};
use crate::camera::parameters;
use crate::error::ProjectionError;
use crate::numeric::float;

/// A fisheye without errors: the radius is a function of the angle θ from the axis.
///
#[doc = include_str!("../../../docs/figures/lenses/fisheye.svg")]
///
/// # Model
/// ```text
/// equidistant   r = θ                 equal angles are equal lengths
/// stereographic r = 2 tan(θ/2)        small circles stay circles
/// equisolid     r = 2 sin(θ/2)        equal solid angles are equal areas
/// orthographic  r = sin θ             as a mirror ball is seen from afar
/// ```
/// (Kannala & Brandt 2006, eq. 2 to 5, in units of the principal distance.)
///
/// # Domain
/// θ < π, all but straight back; orthographic θ < π/2.
///
/// # Example
/// At 60° from the axis, to the right: π/3, 2 tan 30° = 1.1547, 2 sin 30° = 1, sin 60° = 0.8660.
///
/// ```
/// use collinear::camera::{CentralProjection, Fisheye};
/// use nalgebra::Vector3;
///
/// let d = Vector3::new(3f64.sqrt(), 0.0, 1.0);
/// assert!((Fisheye::Equidistant.plane(&d)?.x - std::f64::consts::FRAC_PI_3).abs() < 1e-15);
/// assert!((Fisheye::Stereographic.plane(&d)?.x - 1.1547005383792515).abs() < 1e-15);
/// assert!((Fisheye::Equisolid.plane(&d)?.x - 1.0).abs() < 1e-15);
/// assert!((Fisheye::Orthographic.plane(&d)?.x - 0.8660254037844386).abs() < 1e-15);
/// # Ok::<(), collinear::ProjectionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(alias("SIMPLE_FISHEYE", "FISHEYE", "Kannala-Brandt", "dome master"))]
pub enum Fisheye {
    /// r = θ.
    #[doc(alias("f-theta"))]
    Equidistant,
    /// r = 2 tan(θ/2).
    Stereographic,
    /// r = 2 sin(θ/2).
    #[doc(alias("equal area"))]
    Equisolid,
    /// r = sin θ.
    Orthographic,
}

radial_projection!(Fisheye);

parameters::no_parameters!(Fisheye, "fisheye projection");

impl Radial for Fisheye {
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError> {
        let length = float::hypot(rho, z);
        // (sin, cos) of θ/2, without cancellation on either side.
        let half = |near: f64| float::sqrt(0.5 * (1.0 + near / length));
        let (sine, cosine) = if z > 0.0 {
            let cosine = half(z);
            (0.5 * (rho / length) / cosine, cosine)
        } else {
            let sine = half(-z);
            (sine, 0.5 * (rho / length) / sine)
        };
        let (r, slope) = match self {
            Self::Equidistant => (float::atan2(rho, z), 1.0),
            Self::Stereographic => (2.0 * sine / cosine, 1.0 / (cosine * cosine)),
            Self::Equisolid => (2.0 * sine, cosine),
            Self::Orthographic if z > 0.0 => (rho / length, z / length),
            Self::Orthographic => return Err(ProjectionError::BehindCamera { depth: z }),
        };
        // ∂θ/∂(ρ, z) = (z, −ρ)/(ρ² + z²)
        Ok([r, slope * (z / length) / length, -slope * (rho / length) / length])
    }

    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError> {
        let (limit, half) = match self {
            Self::Equidistant => (PI, 0.5 * r),
            Self::Stereographic => (f64::INFINITY, float::atan2(0.5 * r, 1.0)),
            Self::Equisolid => {
                below(r, 2.0)?;
                (2.0, float::atan2(0.5 * r, float::sqrt((1.0 - 0.5 * r) * (1.0 + 0.5 * r))))
            }
            Self::Orthographic => {
                below(r, 1.0)?;
                return Ok([r, float::sqrt((1.0 - r) * (1.0 + r))]);
            }
        };
        if half >= FRAC_PI_2 {
            return Err(ProjectionError::OutsideDomain { value: r, limit });
        }
        let (sine, cosine) = float::sin_cos(2.0 * half);
        Ok([sine, cosine])
    }
}

#[cfg(test)]
mod tests {
    use super::super::radial::check;
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        let front = [[0.0, 2.0], [1e-9, 1.0], [0.3, 1.0], [4.0, 0.1]];
        let all = [[0.3, 1.0], [4.0, 0.1], [2.0, -0.3], [0.02, -3.0]];
        type Rays = [Dual<8>; 2];
        let length = |[rho, z]: Rays| (rho * rho + z * z).sqrt();
        let tangent = move |[rho, z]: Rays| rho / (length([rho, z]) + z);
        check(&Fisheye::Equidistant, |[rho, z]: Rays, _: [_; 0]| rho.atan2(z), &all);
        check(&Fisheye::Stereographic, |v: Rays, _: [_; 0]| tangent(v).scale(2.0), &all[..3]);
        let equisolid = |v: Rays, _: [Dual<8>; 0]| {
            let t = tangent(v);
            t.scale(2.0) / (t * t + Dual::constant(1.0)).sqrt()
        };
        check(&Fisheye::Equisolid, equisolid, &all[..3]);
        let orthographic = |v: Rays, _: [Dual<8>; 0]| v[0] / length(v);
        check(&Fisheye::Orthographic, orthographic, &front[2..]);
        check(&Fisheye::Orthographic, orthographic, &front[1..2]);
    }
}
