//! The corrections of photogrammetric calibration reports, which lead from the measured point to the ideal one.

use nalgebra::{Matrix2, Point2, Vector2};

use super::one_to_one::{OneToOne, invert};
use super::planar::Planar;
use super::{Distortion, Undistorted};
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// Corrections of measured image coordinates: radial, decentering, affinity and shear (Fraser 1997).
///
#[doc = include_str!("../../../docs/figures/lenses/fraser.svg")]
///
/// # Model
/// ```text
/// x̂ = x̄ + x̄ (K₁r² + K₂r⁴ + K₃r⁶) + P₁ (r² + 2x̄²) + 2 P₂ x̄ȳ + b₁x̄ + b₂ȳ
/// ŷ = ȳ + ȳ (K₁r² + K₂r⁴ + K₃r⁶) + 2 P₁ x̄ȳ + P₂ (r² + 2ȳ²)                    r² = x̄² + ȳ²
/// ```
/// (x̄, ȳ) is measured from the principal point, y up; (x̂, ŷ) is what the collinearity equations take. Computer vision's lenses
/// lead the other way. So here *undistorting* is the formula and distorting is its iteration, to the rounding floor.
///
/// # Units
/// Calibration reports give millimetres: [`from_millimetres`](Self::from_millimetres). Inside, coordinates are in units of the
/// principal distance and y points down.
///
/// # Domain
/// Measured points within a disc on which the formula is one to one, found when the lens is made.
///
/// # Example
/// By hand, with c = 10 mm at (x̄, ȳ) = (3, 4) mm: r² = 25, so that K₁ = 10⁻⁴ mm⁻² adds 0.0025 of each coordinate.
///
/// ```
/// use collinear::camera::{Distortion, Fraser};
/// use nalgebra::Point2;
///
/// let lens = Fraser::from_millimetres(10.0, [1e-4, 0.0, 0.0], [0.0; 2], [0.0; 2])?;
/// let ideal = lens.undistort(&Point2::new(0.3, -0.4))?.point; // y down
/// assert!((ideal - Point2::new(0.30075, -0.401)).norm() < 1e-16);
/// assert!((lens.distort(&ideal)? - Point2::new(0.3, -0.4)).norm() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("Australis", "self-calibration", "additional parameters"))]
pub struct Fraser {
    planar: Planar<3, 0, 1, 0>,
    /// b₁ and b₂ with y down.
    linear: [f64; 2],
}

impl Fraser {
    /// From K₁ to K₃, P₁ and P₂, b₁ and b₂, in units of the principal distance, y up.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold.
    pub fn new(k: [f64; 3], p: [f64; 2], b: [f64; 2]) -> Result<Self, Error> {
        if !b.iter().all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "affinity or shear" });
        }
        // The smallest eigenvalue of ((b₁, b₂/2), (b₂/2, 0)).
        let lowered = 0.5 * (float::hypot(b[0], b[1]) - b[0]);
        // With y down P₁ keeps its sign and P₂ changes it; Brown's p₁ goes with y.
        let planar = Planar::new(k, [], [-p[1], p[0]], [0.0; 2], [0.0; 4], lowered)?;
        Ok(Self { planar, linear: [b[0], -b[1]] })
    }

    /// From a calibration in millimetres: K₁ in mm⁻², K₂ in mm⁻⁴, K₃ in mm⁻⁶, P₁ and P₂ in mm⁻¹, b₁ and b₂ without unit.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a principal distance that is not positive, and as [`new`](Self::new).
    pub fn from_millimetres(
        c_mm: f64,
        k: [f64; 3],
        p: [f64; 2],
        b: [f64; 2],
    ) -> Result<Self, Error> {
        if !(c_mm > 0.0) {
            return Err(Error::OutOfRange {
                what: "principal distance",
                value: c_mm,
                expected: "c > 0",
            });
        }
        let c2 = c_mm * c_mm;
        let [k1, k2, k3] = k;
        Self::new([k1 * c2, k2 * c2 * c2, k3 * c2 * c2 * c2], p.map(|p| p * c_mm), b)
    }
}

impl OneToOne for Fraser {
    fn value(&self, p: &Point2<f64>) -> Point2<f64> {
        let [b1, b2] = self.linear;
        self.planar.value(p) + Vector2::new(b1 * p.x + b2 * p.y, 0.0)
    }

    fn jacobian(&self, p: &Point2<f64>) -> Matrix2<f64> {
        let [b1, b2] = self.linear;
        self.planar.jacobian(p) + Matrix2::new(b1, b2, 0.0, 0.0)
    }

    fn fold_radius(&self) -> f64 {
        self.planar.fold_radius()
    }

    fn reach(&self, radius: f64) -> f64 {
        self.planar.reach(radius) + float::hypot(self.linear[0], self.linear[1]) * radius
    }

    fn radial(&self, radius: f64) -> [f64; 2] {
        self.planar.radial(radius)
    }

    fn is_radial(&self) -> bool {
        false
    }

    /// In the order K₁, K₂, K₃, P₁, P₂, b₁, b₂.
    fn columns(&self, p: &Point2<f64>, out: &mut [Vector2<f64>]) {
        let mut all = [Vector2::zeros(); 7];
        self.planar.columns(p, &mut all);
        // Brown's (p₁, p₂) are (−P₂, P₁).
        all.swap(3, 4);
        all[4] = -all[4];
        all[5] = Vector2::new(p.x, 0.0);
        all[6] = Vector2::new(-p.y, 0.0);
        parameters::write(&all, out);
    }
}

impl Parametrised for Fraser {
    const NAME: &'static str = "lens distortion";
    const PARAMETERS: &'static [&'static str] = &["K1", "K2", "K3", "P1", "P2", "b1", "b2"];

    fn values(&self, out: &mut [f64]) {
        let ([k1, k2, k3], [p_y, p_x], [b1, b2]) = (self.planar.k, self.planar.p, self.linear);
        parameters::write(&[k1, k2, k3, p_x, -p_y, b1, -b2], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k1, k2, k3, p1, p2, b1, b2] = parameters::read(values)?;
        Self::new([k1, k2, k3], [p1, p2], [b1, b2])
    }
}

impl Distortion for Fraser {
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        Ok(invert(self, ideal)?.point)
    }

    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        let measured = invert(self, ideal)?.point;
        let inverse = self.jacobian(&measured).try_inverse();
        Ok((measured, inverse.ok_or(ProjectionError::NotFinite)?))
    }

    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        Ok(Undistorted { point: self.checked(distorted)?, iterations: 0, residual: 0.0 })
    }

    fn parameter_partials(&self, ideal: &Point2<f64>, out: &mut [Vector2<f64>]) {
        // F(measured) = ideal stays as a parameter moves: ∂measured = −J⁻¹ ∂F.
        let Ok(measured) = invert(self, ideal) else { return };
        let Some(inverse) = self.jacobian(&measured.point).try_inverse() else { return };
        self.columns(&measured.point, out);
        for column in out.iter_mut() {
            *column = -(inverse * *column);
        }
    }

    /// Of measured points.
    fn fold_radius(&self) -> f64 {
        OneToOne::fold_radius(&self.planar)
    }
}
