//! Projections that are the same all around the axis.

use nalgebra::{Matrix2x3, Point2, Vector2, Vector3};

use crate::camera::collinearity::finite;
use crate::camera::{Parametrised, parameters};
use crate::error::ProjectionError;
use crate::numeric::float;

/// A projection given by its radius over ρ = √(X² + Y²) and Z.
///
/// The radius is homogeneous of degree 0: it depends on the direction alone.
pub(super) trait Radial: Parametrised {
    /// r, ∂r/∂ρ and ∂r/∂z.
    ///
    /// # Errors
    /// Why this direction has no radius.
    fn radius(&self, rho: f64, z: f64) -> Result<[f64; 3], ProjectionError>;

    /// A direction (ρ, z) of unit length with radius r ≥ 0.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] for a radius that no direction has.
    fn ray(&self, r: f64) -> Result<[f64; 2], ProjectionError>;

    /// ∂r/∂ of each parameter.
    fn radius_partials(&self, _rho: f64, _z: f64, _out: &mut [f64]) {}
}

/// ρ, and refuses what is no direction.
fn across(d: &Vector3<f64>) -> Result<f64, ProjectionError> {
    let rho = float::hypot(d.x, d.y);
    if !(rho.is_finite() && d.z.is_finite()) {
        return Err(ProjectionError::NotFinite);
    }
    if rho == 0.0 && d.z <= 0.0 {
        // Straight back, all directions around meet; and no length is no direction.
        return Err(ProjectionError::BehindCamera { depth: d.z });
    }
    Ok(rho)
}

pub(super) fn plane(
    projection: &impl Radial,
    d: &Vector3<f64>,
) -> Result<Point2<f64>, ProjectionError> {
    let rho = across(d)?;
    let [r, ..] = projection.radius(rho, d.z)?;
    let (c, s) = if rho > 0.0 { (d.x / rho, d.y / rho) } else { (1.0, 0.0) };
    finite(Point2::new(r * c, r * s))
}

pub(super) fn plane_jacobian(
    projection: &impl Radial,
    d: &Vector3<f64>,
) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
    let rho = across(d)?;
    let [r, along, by_z] = projection.radius(rho, d.z)?;
    let (c, s, around) =
        if rho > 0.0 { (d.x / rho, d.y / rho, r / rho) } else { (1.0, 0.0, along) };
    let off = (along - around) * c * s;
    let jacobian = Matrix2x3::new(
        along * c * c + around * s * s,
        off,
        by_z * c,
        off,
        along * s * s + around * c * c,
        by_z * s,
    );
    if jacobian.iter().all(|e| e.is_finite()) {
        Ok((finite(Point2::new(r * c, r * s))?, jacobian))
    } else {
        Err(ProjectionError::NotFinite)
    }
}

pub(super) fn direction(
    projection: &impl Radial,
    p: &Point2<f64>,
) -> Result<Vector3<f64>, ProjectionError> {
    let r = float::hypot(p.x, p.y);
    if !r.is_finite() {
        return Err(ProjectionError::NotFinite);
    }
    below(r, LARGEST_RADIUS)?;
    let [rho, z] = projection.ray(r)?;
    if rho <= 0.0 && z < 0.0 {
        // So near to straight back that the numbers do not tell it apart.
        return Err(ProjectionError::OutsideDomain { value: r, limit: r });
    }
    let (c, s) = if r > 0.0 { (p.x / r, p.y / r) } else { (1.0, 0.0) };
    Ok(Vector3::new(rho * c, rho * s, z))
}

pub(super) fn parameter_partials(
    projection: &impl Radial,
    d: &Vector3<f64>,
    out: &mut [Vector2<f64>],
) {
    let rho = float::hypot(d.x, d.y);
    let mut radii = [0.0; parameters::MOST];
    projection.radius_partials(rho, d.z, &mut radii);
    let around = if rho > 0.0 { Vector2::new(d.x, d.y) / rho } else { Vector2::zeros() };
    for (o, radius) in out.iter_mut().zip(radii) {
        *o = around * radius;
    }
}

/// Squares of a plane point's radius stay within the numbers.
const LARGEST_RADIUS: f64 = 1e100;

/// The unit vector along (ρ, z).
pub(super) fn unit(rho: f64, z: f64) -> [f64; 2] {
    let length = float::hypot(rho, z);
    [rho / length, z / length]
}

/// Refuses a radius at or beyond a limit.
pub(super) fn below(r: f64, limit: f64) -> Result<(), ProjectionError> {
    if r < limit { Ok(()) } else { Err(ProjectionError::OutsideDomain { value: r, limit }) }
}

/// [`CentralProjection`](super::CentralProjection) of a [`Radial`] one.
macro_rules! radial_projection {
    ($name:ident) => {
        impl $crate::camera::CentralProjection for $name {
            fn plane(
                &self,
                direction: &nalgebra::Vector3<f64>,
            ) -> Result<nalgebra::Point2<f64>, $crate::error::ProjectionError> {
                super::radial::plane(self, direction)
            }

            fn plane_jacobian(
                &self,
                direction: &nalgebra::Vector3<f64>,
            ) -> Result<
                (nalgebra::Point2<f64>, nalgebra::Matrix2x3<f64>),
                $crate::error::ProjectionError,
            > {
                super::radial::plane_jacobian(self, direction)
            }

            fn direction(
                &self,
                plane: &nalgebra::Point2<f64>,
            ) -> Result<nalgebra::Vector3<f64>, $crate::error::ProjectionError> {
                super::radial::direction(self, plane)
            }

            fn parameter_partials(
                &self,
                direction: &nalgebra::Vector3<f64>,
                out: &mut [nalgebra::Vector2<f64>],
            ) {
                super::radial::parameter_partials(self, direction, out);
            }
        }
    };
}
pub(super) use radial_projection;

/// Checks the derivatives of a radius against dual numbers of its formula, and its inverse.
#[cfg(test)]
pub(super) fn check<R: Radial, const N: usize>(
    projection: &R,
    formula: impl Fn(
        [crate::numeric::scalar::Dual<8>; 2],
        [crate::numeric::scalar::Dual<8>; N],
    ) -> crate::numeric::scalar::Dual<8>,
    rays: &[[f64; 2]],
) {
    use crate::numeric::scalar::Dual;
    let mut values = [0.0; parameters::MOST];
    projection.values(&mut values);
    for &[rho, z] in rays {
        let dual = formula(
            [Dual::variable(rho, 0), Dual::variable(z, 1)],
            core::array::from_fn(|i| Dual::variable(values[i], 2 + i)),
        );
        let [r, along, by_z] = projection.radius(rho, z).unwrap();
        let size = 1.0 + r.abs();
        assert!((dual.value - r).abs() < 4e-15 * size, "{projection:?} {} {r}", dual.value);
        assert!((dual.gradient[0] - along).abs() < 1e-13 * size, "{projection:?} {rho} {z}");
        assert!((dual.gradient[1] - by_z).abs() < 1e-13 * size, "{projection:?} {rho} {z}");
        let mut partials = [0.0; N];
        projection.radius_partials(rho, z, &mut partials);
        for (i, partial) in partials.iter().enumerate() {
            let exact = dual.gradient[2 + i];
            assert!((exact - partial).abs() < 1e-12 * (1.0 + exact.abs()), "{projection:?} {i}");
        }
        let [back_rho, back_z] = projection.ray(r).unwrap();
        let [rho, z] = unit(rho, z);
        assert!((back_rho - rho).abs() + (back_z - z).abs() < 4e-14, "{projection:?} {rho} {z}");
    }
}
