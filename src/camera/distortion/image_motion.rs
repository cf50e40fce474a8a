//! Image motion compensation of panoramic cameras.

use nalgebra::{Matrix2, Point2, Vector2};

use super::{Distortion, Undistorted};
use crate::camera::collinearity::finite;
use crate::camera::{Parametrised, parameters};
use crate::error::{Error, ProjectionError};
use crate::numeric::float;

/// The shift of a panoramic camera's lens or film that keeps the moving ground still while the slit passes.
///
/// # Model
/// ```text
/// x″ = x,   y″ = y + p sin x            x: scan angle in radians, y: across, in units of the principal distance
/// ```
/// The ground moves through the slit at V cos x / H, for a vertical camera at height H with velocity V along y; integrated over a scan of ω
/// radians a second that is p = V / (H ω). Zero is no compensation.
///
/// # Domain
/// The whole plane; the inverse is closed.
///
/// # Example
/// ```
/// use collinear::camera::{Distortion, ImageMotionCompensation};
/// use nalgebra::Point2;
///
/// let p = ImageMotionCompensation::new(0.02)?.distort(&Point2::new(std::f64::consts::FRAC_PI_6, 0.1))?;
/// assert!((p.y - 0.11).abs() < 1e-15); // sin 30° = ½
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(alias("IMC", "motion compensation factor"))]
pub struct ImageMotionCompensation {
    p: f64,
}

impl ImageMotionCompensation {
    /// From p.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn new(p: f64) -> Result<Self, Error> {
        if p.is_finite() {
            Ok(Self { p })
        } else {
            Err(Error::NotFinite { what: "image motion compensation" })
        }
    }

    /// p.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.p
    }

    fn shift(&self, x: f64) -> f64 {
        self.p * float::sin(x)
    }
}

impl Parametrised for ImageMotionCompensation {
    const NAME: &'static str = "image motion compensation";
    const PARAMETERS: &'static [&'static str] = &["p"];

    fn values(&self, out: &mut [f64]) {
        parameters::write(&[self.p], out);
    }

    fn with_values(&self, values: &[f64]) -> Result<Self, Error> {
        let [p] = parameters::read(values)?;
        Self::new(p)
    }
}

impl Distortion for ImageMotionCompensation {
    fn distort(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        finite(Point2::new(ideal.x, ideal.y + self.shift(ideal.x)))
    }

    fn distort_jacobian(
        &self,
        ideal: &Point2<f64>,
    ) -> Result<(Point2<f64>, Matrix2<f64>), ProjectionError> {
        let slope = self.p * float::sin_cos(ideal.x).1;
        Ok((self.distort(ideal)?, Matrix2::new(1.0, 0.0, slope, 1.0)))
    }

    fn undistort(&self, distorted: &Point2<f64>) -> Result<Undistorted, ProjectionError> {
        let point = finite(Point2::new(distorted.x, distorted.y - self.shift(distorted.x)))?;
        Ok(Undistorted { point, iterations: 0, residual: 0.0 })
    }

    fn parameter_partials(&self, ideal: &Point2<f64>, out: &mut [Vector2<f64>]) {
        parameters::write(&[Vector2::new(0.0, float::sin(ideal.x))], out);
    }

    fn fold_radius(&self) -> f64 {
        f64::INFINITY
    }
}
