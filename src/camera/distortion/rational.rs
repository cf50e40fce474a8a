//! OpenCV's lens of up to fourteen coefficients.

use nalgebra::{Matrix2, Point2, Vector2};

use super::many::undistort_many;
use super::one_to_one::{OneToOne, invert};
use super::planar::Planar;
use super::{Distortion, Undistorted, UndistortedMany};
use crate::camera::collinearity::finite;
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;
use crate::numeric::scalar::Scalar;

/// Rational radial, decentering and thin-prism distortion on a tilted sensor: OpenCV's model of 4, 5, 8, 12 or 14
/// coefficients.
///
#[doc = include_str!("../../../docs/figures/lenses/rational.svg")]
///
/// # Model
/// ```text
/// x′ = x (1 + k₁r² + k₂r⁴ + k₃r⁶)/(1 + k₄r² + k₅r⁴ + k₆r⁶) + 2 p₁ x y + p₂ (r² + 2x²) + s₁r² + s₂r⁴
/// y′ = y (1 + k₁r² + k₂r⁴ + k₃r⁶)/(1 + k₄r² + k₅r⁴ + k₆r⁶) + p₁ (r² + 2y²) + 2 p₂ x y + s₃r² + s₄r⁴
/// x″ = x′ cosτx / w,   y″ = (y′ cosτy − x′ sinτx sinτy) / w,   w = cosτx cosτy + x′ sinτy − y′ sinτx cosτy
/// ```
/// The last line is the homography of a sensor turned by τx about its x axis and then by τy about its y axis against a plane
/// across the optical axis (Scheimpflug; Louhichi et al. 2007), OpenCV's two matrices multiplied out.
///
/// # Domain
/// A disc on which the first two lines are one to one, found when the lens is made, without the points that the tilt sends to
/// infinity.
///
/// # Accuracy
/// Forward within a few roundings of the formula. The inverse undoes the tilt in closed form and ends at the rounding floor of
/// the rest; its residual is measured before the tilt.
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` of (0.31, −0.22, 1) with these fourteen coefficients and the identity for K:
///
/// ```
/// use collinear::camera::{Distortion, Rational};
/// use nalgebra::Point2;
///
/// let lens = Rational::from_opencv(&[
///     -0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036, // k1 k2 p1 p2 k3 k4 k5 k6
///     8.3e-4, -4.1e-4, -7.7e-4, 2.9e-4, 0.031, -0.047, // s1 s2 s3 s4 τx τy
/// ])?;
/// let p = lens.distort(&Point2::new(0.31, -0.22))?;
/// assert!((p - Point2::new(0.2995878506583936, -0.21197180390517079)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias(
    "OPENCV",
    "FULL_OPENCV",
    "CALIB_RATIONAL_MODEL",
    "CALIB_TILTED_MODEL",
    "thin prism",
    "Scheimpflug"
))]
pub struct Rational {
    planar: Planar<3, 3, 1, 2>,
    tilt: [f64; 2],
}

/// The tilt of the sensor.
fn tilted<S: Scalar>([x, y]: [S; 2], tilt: [S; 2]) -> ([S; 2], S) {
    let ((sx, cx), (sy, cy)) = (tilt[0].sin_cos(), tilt[1].sin_cos());
    let w = cx * cy + x * sy - y * (sx * cy);
    ([x * cx / w, (y * cy - x * (sx * sy)) / w], w)
}

impl Rational {
    /// From k₁ to k₆, p₁ and p₂, s₁ to s₄, and the tilt (τx, τy) in radians.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::OutOfRange`] for coefficients so large that nothing is left inside the fold, and for
    /// angles of a quarter turn or more.
    pub fn new(k: [f64; 6], p: [f64; 2], s: [f64; 4], tilt: [f64; 2]) -> Result<Self, Error> {
        for value in tilt {
            if !(value.abs() < core::f64::consts::FRAC_PI_2) {
                return Err(Error::OutOfRange {
                    what: "tilt of the sensor",
                    value,
                    expected: "less than a quarter turn",
                });
            }
        }
        let [k1, k2, k3, k4, k5, k6] = k;
        let planar = Planar::new([k1, k2, k3], [k4, k5, k6], p, [0.0; 2], s, 0.0)?;
        Ok(Self { planar, tilt })
    }

    /// From OpenCV's vector of 4, 5, 8, 12 or 14 coefficients, in its order k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄ τx τy.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] for another number of coefficients, and as [`new`](Self::new).
    #[doc(alias("distCoeffs"))]
    pub fn from_opencv(coefficients: &[f64]) -> Result<Self, Error> {
        if ![4, 5, 8, 12, 14].contains(&coefficients.len()) {
            return Err(Error::LengthMismatch {
                what: "OpenCV's 4, 5, 8, 12 or 14 coefficients",
                left: 14,
                right: coefficients.len(),
            });
        }
        let mut c = [0.0; 14];
        parameters::write(coefficients, &mut c);
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty] = c;
        Self::new([k1, k2, k3, k4, k5, k6], [p1, p2], [s1, s2, s3, s4], [tx, ty])
    }

    /// OpenCV's fourteen coefficients, in its order.
    #[must_use]
    pub fn to_opencv(&self) -> [f64; 14] {
        let ([k1, k2, k3], [k4, k5, k6]) = (self.planar.k, self.planar.d);
        let ([p1, p2], [s1, s2, s3, s4], [tx, ty]) = (self.planar.p, self.planar.s, self.tilt);
        [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty]
    }

    fn tilted(&self, p: &Point2<f64>) -> Result<(Point2<f64>, f64), ProjectionError> {
        let (tilted, w) = tilted([p.x, p.y], self.tilt);
        if w > 0.0 {
            Ok((finite(Point2::from(tilted))?, w))
        } else {
            Err(ProjectionError::BeyondHorizon { w })
        }
    }

    fn untilted(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let ((sx, cx), (sy, cy)) = (float::sin_cos(self.tilt[0]), float::sin_cos(self.tilt[1]));
        // (x′, y′, 1)/w from the triangular matrix of the homography.
        let x = p.x / cx;
        let y = (p.y + sx * sy * x) / cy;
        let inverse_w = (1.0 - sy * x + cy * sx * y) / (cy * cx);
        if inverse_w > 0.0 {
            finite(Point2::new(x / inverse_w, y / inverse_w))
        } else {
            Err(ProjectionError::BeyondHorizon { w: inverse_w })
        }
    }

    /// ∂(x″, y″)/∂(x′, y′).
    fn tilt_jacobian(&self, tilted: &Point2<f64>, w: f64) -> Matrix2<f64> {
        let ((sx, cx), (sy, cy)) = (float::sin_cos(self.tilt[0]), float::sin_cos(self.tilt[1]));
        let (wx, wy) = (sy, -sx * cy);
        Matrix2::new(
            cx - tilted.x * wx,
            -tilted.x * wy,
            -sx * sy - tilted.y * wx,
            cy - tilted.y * wy,
        ) / w
    }

    /// ∂(x″, y″)/∂(τx, τy).
    fn tilt_columns(&self, p: &Point2<f64>, tilted: &Point2<f64>, w: f64) -> [Vector2<f64>; 2] {
        let ((sx, cx), (sy, cy)) = (float::sin_cos(self.tilt[0]), float::sin_cos(self.tilt[1]));
        let (x, y) = (p.x, p.y);
        let by_x = (Vector2::new(-x * sx, -x * cx * sy), -sx * cy - y * cx * cy);
        let by_y = (Vector2::new(0.0, -y * sy - x * sx * cy), -cx * sy + x * cy + y * sx * sy);
        [by_x, by_y].map(|(numerators, w_slope)| (numerators - tilted.coords * w_slope) / w)
    }
}

impl Parametrised for Rational {
    const NAME: &'static str = "lens distortion";
    const PARAMETERS: &'static [&'static str] =
        &["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4", "tau_x", "tau_y"];

    fn values(&self, out: &mut [f64]) {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty] = self.to_opencv();
        parameters::write(&[k1, k2, k3, k4, k5, k6, p1, p2, s1, s2, s3, s4, tx, ty], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [k1, k2, k3, k4, k5, k6, p1, p2, s1, s2, s3, s4, tx, ty] = parameters::read(values)?;
        Self::new([k1, k2, k3, k4, k5, k6], [p1, p2], [s1, s2, s3, s4], [tx, ty])
    }
}

impl Distortion for Rational {
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        Ok(self.tilted(&self.planar.checked(ideal)?)?.0)
    }

    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        let (distorted, w) = self.tilted(&self.planar.checked(ideal)?)?;
        let by_planar = self.tilt_jacobian(&distorted, w);
        Ok((distorted, by_planar * self.planar.jacobian(ideal)))
    }

    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        invert(&self.planar, &self.untilted(distorted)?)
    }

    fn undistort_many(&self, points: &mut [Point2<f64>]) -> UndistortedMany {
        if self.tilt != [0.0; 2] {
            for point in points.iter_mut() {
                *point = self.untilted(point).unwrap_or(Point2::new(f64::NAN, f64::NAN));
            }
        }
        undistort_many(&self.planar, points)
    }

    fn parameter_partials(&self, ideal: &Point2<f64>, out: &mut [Vector2<f64>]) {
        let planar = self.planar.value(ideal);
        let (tilted, w) = tilted([planar.x, planar.y], self.tilt);
        let tilted = Point2::from(tilted);
        let through = self.tilt_jacobian(&tilted, w);
        let mut all = [Vector2::zeros(); 14];
        self.planar.columns(ideal, &mut all[..12]);
        for column in &mut all[..12] {
            *column = through * *column;
        }
        all[12..].copy_from_slice(&self.tilt_columns(&planar, &tilted, w));
        parameters::write(&all, out);
    }

    fn fold_radius(&self) -> f64 {
        self.planar.fold_radius()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn partials_of_the_tilt_agree_with_dual_numbers() {
        let tilt = [0.031, -0.047];
        let lens = Rational::new([0.0; 6], [0.0; 2], [0.0; 4], tilt).unwrap();
        for point in [[0.31, -0.22], [-0.4, -0.1], [0.05, 0.5], [0.0, 0.0]] {
            let variable = |value, i| Dual::<4>::variable(value, i);
            let (dual, w) = tilted(
                [variable(point[0], 0), variable(point[1], 1)],
                [variable(tilt[0], 2), variable(tilt[1], 3)],
            );
            let (value, w) = (Point2::new(dual[0].value, dual[1].value), w.value);
            let point = Point2::from(point);
            let jacobian = lens.tilt_jacobian(&value, w);
            let columns = lens.tilt_columns(&point, &value, w);
            for row in 0..2 {
                for i in 0..2 {
                    assert!((dual[row].gradient[i] - jacobian[(row, i)]).abs() < 1e-15);
                    assert!((dual[row].gradient[2 + i] - columns[i][row]).abs() < 1e-15);
                }
            }
            assert!((lens.untilted(&value).unwrap() - point).norm() < 1e-15);
        }
    }
}
