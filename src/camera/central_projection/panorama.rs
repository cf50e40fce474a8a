//! Panoramas of one centre.

use core::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

use super::CentralProjection;
use crate::camera::collinearity::finite;
use crate::camera::parameters;
use crate::error::ProjectionError;
use crate::numeric::float;

/// A panorama: the sphere or the cylinder unrolled about the camera's y axis.
///
#[doc = include_str!("../../../docs/figures/lenses/panorama.svg")]
///
/// # Model
/// ```text
/// equirectangular  x = λ,  y = φ           λ = atan2(X, Z),   φ = atan2(Y, √(X² + Z²)), positive downwards
/// cylindrical      x = λ,  y = tan φ
/// ```
/// in radians: a whole panorama of w × h pixels has an interior orientation with fx = w/2π, fy = h/π and the principal point in
/// the middle ([`InteriorOrientation::from_whole_panorama`](crate::camera::InteriorOrientation::from_whole_panorama)).
///
/// # Domain
/// All directions; cylindrical not straight up or down. The seam is straight behind, at λ = ±π.
///
/// # Example
/// Straight up is a quarter turn above the middle; to the right, a quarter turn right of it.
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use collinear::camera::{CentralProjection, Panorama};
/// use nalgebra::{Point2, Vector3};
///
/// let p = Panorama::Equirectangular.plane(&-Vector3::y())?;
/// assert_eq!(p, Point2::new(0.0, -FRAC_PI_2));
/// let p = Panorama::Cylindrical.plane(&Vector3::new(2.0, 3.0, 0.0))?;
/// assert_eq!(p, Point2::new(FRAC_PI_2, 1.5));
/// # Ok::<(), collinear::ProjectionError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(alias("360", "spherical", "EQUIRECTANGULAR", "plate carrée"))]
pub enum Panorama {
    /// Longitude and latitude.
    Equirectangular,
    /// Longitude and height on a cylinder of radius one.
    Cylindrical,
}

impl Panorama {
    /// The principal distances (fx, fy), in pixels, of a panorama of w × h pixels that is a full turn wide: w/2π, and h/π of an
    /// equirectangular one, which is half a turn high.
    #[must_use]
    pub fn principal_distance(self, width: f64, height: f64) -> [f64; 2] {
        let turn = width / core::f64::consts::TAU;
        match self {
            Self::Equirectangular => [turn, height / PI],
            Self::Cylindrical => [turn, turn],
        }
    }
}

parameters::no_parameters!(Panorama, "panorama");

impl CentralProjection for Panorama {
    fn plane(&self, d: &Vector3<f64>) -> Result<Point2<f64>, ProjectionError> {
        if !d.iter().all(|c| c.is_finite()) || *d == Vector3::zeros() {
            return Err(ProjectionError::NotFinite);
        }
        let level = float::hypot(d.x, d.z);
        // Straight up and down every longitude is as good, and a zero's sign is none.
        let longitude = if level > 0.0 { float::atan2(d.x, d.z) } else { 0.0 };
        finite(match self {
            Self::Equirectangular => Point2::new(longitude, float::atan2(d.y, level)),
            Self::Cylindrical => Point2::new(longitude, d.y / level),
        })
    }

    fn plane_jacobian(
        &self,
        d: &Vector3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        let plane = self.plane(d)?;
        let level = float::hypot(d.x, d.z);
        // The unit vector that is level and ahead.
        let (s, c) = (d.x / level, d.z / level);
        let (by_level, by_y) = match self {
            Self::Equirectangular => {
                let length = float::hypot(level, d.y);
                (-(d.y / length) / length, (level / length) / length)
            }
            Self::Cylindrical => (-plane.y / level, 1.0 / level),
        };
        let jacobian = Matrix2x3::new(c / level, 0.0, -s / level, by_level * s, by_y, by_level * c);
        // Straight up and down the longitude has no derivative.
        let finite = jacobian.iter().all(|e| e.is_finite());
        if finite { Ok((plane, jacobian)) } else { Err(ProjectionError::NotFinite) }
    }

    fn direction(&self, p: &Point2<f64>) -> Result<Vector3<f64>, ProjectionError> {
        let outside = |value: f64, limit| Err(ProjectionError::OutsideDomain { value, limit });
        finite(*p)?;
        if p.x.abs() > PI {
            return outside(p.x.abs(), PI);
        }
        let (sine, cosine) = match self {
            Self::Equirectangular if p.y.abs() > FRAC_PI_2 => {
                return outside(p.y.abs(), FRAC_PI_2);
            }
            Self::Equirectangular => float::sin_cos(p.y),
            Self::Cylindrical => {
                let length = float::hypot(1.0, p.y);
                (p.y / length, 1.0 / length)
            }
        };
        let (s, c) = float::sin_cos(p.x);
        Ok(Vector3::new(cosine * s, sine, cosine * c))
    }

    fn parameter_partials(&self, _: &Vector3<f64>, _: &mut [Vector2<f64>]) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::{Dual, Scalar};

    #[test]
    fn slopes_agree_with_dual_numbers() {
        for d in [[0.3, -0.4, 1.1], [2.0, 0.5, -0.7], [-0.2, 3.0, -0.1]] {
            let [x, y, z]: [Dual<3>; 3] = core::array::from_fn(|i| Dual::variable(d[i], i));
            let level = (x * x + z * z).sqrt();
            let longitude = x.atan2(z);
            for (panorama, dual) in [
                (Panorama::Equirectangular, [longitude, y.atan2(level)]),
                (Panorama::Cylindrical, [longitude, y / level]),
            ] {
                let (plane, jacobian) = panorama.plane_jacobian(&Vector3::from(d)).unwrap();
                for row in 0..2 {
                    assert_eq!(plane[row], dual[row].value);
                    for i in 0..3 {
                        let exact = dual[row].gradient[i];
                        assert!((exact - jacobian[(row, i)]).abs() < 1e-14 * (1.0 + exact.abs()));
                    }
                }
            }
        }
    }
}
