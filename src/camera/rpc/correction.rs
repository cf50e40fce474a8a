//! What control points add to a rational polynomial camera: an affine map of its image.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::error::{Error, ProjectionError};

/// The correction of a rational polynomial camera in its image (Grodecki & Dial 2003; Fraser & Hanley 2003).
///
/// # Model
/// ```text
/// p = q + s + A (q − c)
/// ```
/// with q the point that the polynomials give and p the corrected one, both in the crate's pixels. s is the **shift**,
/// the second column of A, by the line, is the **drift**, its first column, by the sample, completes the affine model.
/// Grodecki & Dial write the same with s at the picture's corner: Δ = a₀ + a_S · sample + a_L · line.
///
/// The inverse is exact: q = c + (1 + A)⁻¹ (p − c − s).
///
/// ```
/// use collinear::camera::rpc::ImageCorrection;
/// use nalgebra::{Matrix2, Point2, Vector2};
///
/// // A picture whose points lie 3 px right, and 1 px more for each 1000 lines below line 500.
/// let drift = Matrix2::new(0.0, 1e-3, 0.0, 0.0);
/// let correction = ImageCorrection::new(Point2::new(500.0, 500.0), Vector2::new(3.0, 0.0), drift)?;
/// let p = correction.apply(&Point2::new(100.0, 1500.0));
/// assert!((p - Point2::new(104.0, 1500.0)).norm() < 1e-12);
/// assert!((correction.remove(&p)? - Point2::new(100.0, 1500.0)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("bias correction", "bias compensation"))]
pub struct ImageCorrection {
    about: Point2<f64>,
    shift: Vector2<f64>,
    linear: Matrix2<f64>,
}

/// The least determinant of 1 + A: a correction does not turn a picture into a line, or over.
const LEAST_DETERMINANT: f64 = 1e-3;

impl ImageCorrection {
    /// No correction.
    #[must_use]
    pub fn none() -> Self {
        Self { about: Point2::origin(), shift: Vector2::zeros(), linear: Matrix2::zeros() }
    }

    /// From the point c (pixels) about which the linear part acts, the shift s (pixels) and A (pixels a pixel).
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::OutOfRange`] past 10⁹ pixels, and [`Error::Degenerate`] where the determinant of
    /// 1 + A is not above 10⁻³.
    pub fn new(
        about: Point2<f64>,
        shift: Vector2<f64>,
        linear: Matrix2<f64>,
    ) -> Result<Self, Error> {
        let numbers = about.iter().chain(shift.iter()).chain(linear.iter());
        for &value in numbers {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "image correction" });
            }
            if value.abs() > 1e9 {
                let what = "image correction";
                return Err(Error::OutOfRange { what, value, expected: "within ±10⁹" });
            }
        }
        let measure = (Matrix2::identity() + linear).determinant();
        if !(measure > LEAST_DETERMINANT) {
            let what = "image correction";
            return Err(Error::Degenerate { what, measure, limit: LEAST_DETERMINANT });
        }
        Ok(Self { about, shift, linear })
    }

    /// c, in pixels.
    #[must_use]
    pub fn about(&self) -> Point2<f64> {
        self.about
    }

    /// s, in pixels.
    #[must_use]
    pub fn shift(&self) -> Vector2<f64> {
        self.shift
    }

    /// A, in pixels a pixel.
    #[must_use]
    pub fn linear(&self) -> Matrix2<f64> {
        self.linear
    }

    /// The corrected image point of one that the polynomials give.
    #[must_use]
    pub fn apply(&self, q: &Point2<f64>) -> Point2<f64> {
        q + self.shift + self.linear * (q - self.about)
    }

    /// The point that the polynomials give for a corrected one: the inverse of [`apply`](Self::apply), within two units
    /// in the last place of the largest coordinate.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`].
    pub fn remove(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        // As a difference from p, so that nothing is lost of a coordinate where A is small.
        let d = p - self.about - self.shift;
        let m = Matrix2::identity() + self.linear;
        let determinant = m.determinant();
        let a = &self.linear;
        // (1 + A)⁻¹ d = d − (1 + A)⁻¹ A d
        let v = a * d;
        let x = (m.m22 * v.x - m.m12 * v.y) / determinant;
        let y = (m.m11 * v.y - m.m21 * v.x) / determinant;
        let q = p - self.shift - Vector2::new(x, y);
        if q.x.is_finite() && q.y.is_finite() { Ok(q) } else { Err(ProjectionError::NotFinite) }
    }
}

impl Default for ImageCorrection {
    fn default() -> Self {
        Self::none()
    }
}
