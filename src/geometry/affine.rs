//! Affine maps of the plane.

use alloc::vec::Vec;

use nalgebra::{Matrix2, Matrix3, Point2, Vector2};

use crate::error::Error;
use crate::numeric::least_squares::unit_weight;
use crate::numeric::triangular::Triangular;

/// An affine map of the plane: x ↦ A x + b, \[WD\] table 2's first row.
///
/// ```text
/// x = A₀ + A₁ X + A₂ Y
/// y = B₀ + B₁ X + B₂ Y
/// ```
///
/// It takes comparator or pixel coordinates to fiducial coordinates, and a triangle to a triangle. As a
/// [`Map`](crate::mapping::Map) it is defined everywhere.
///
/// # Example
/// Four fiducial marks in pixels and millimetres, with the coefficients that NooBeeD's interior orientation report prints
/// for them (noobeed.com, `nb_ex_ph_or_io_95`):
///
/// ```
/// use collinear::geometry::Affine2;
/// use nalgebra::Point2;
///
/// let pixel = [(227.5, 2038.5), (2062.5, 205.5), (2061.5, 3873.5), (3895.5, 2041.5)];
/// let mm = [(-110.022, -0.255), (0.256, -110.021), (-0.254, 110.024), (110.015, 0.258)];
/// let points = |c: [(f64, f64); 4]| c.map(|(x, y)| Point2::new(x, y));
/// let fit = Affine2::fit(&points(pixel), &points(mm))?;
/// assert!((fit.map.linear.m11 - 0.059988375432533).abs() < 1e-14);
/// assert!((fit.map.linear.m12 + 0.000122683929039).abs() < 1e-14);
/// assert!((fit.map.linear.m22 - 0.059990480540713).abs() < 1e-14);
/// assert!((fit.map.translation.x + 123.432).abs() < 5e-4);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine2 {
    /// A: ((A₁, A₂), (B₁, B₂)).
    pub linear: Matrix2<f64>,
    /// b: (A₀, B₀).
    pub translation: Vector2<f64>,
}

impl Affine2 {
    /// From table 2's coefficients (A₀, A₁, A₂) and (B₀, B₁, B₂).
    #[must_use]
    pub fn from_coefficients(a: [f64; 3], b: [f64; 3]) -> Self {
        Self { linear: Matrix2::new(a[1], a[2], b[1], b[2]), translation: Vector2::new(a[0], b[0]) }
    }

    /// The identity.
    #[must_use]
    pub fn identity() -> Self {
        Self { linear: Matrix2::identity(), translation: Vector2::zeros() }
    }

    /// The image of a point.
    #[must_use]
    pub fn apply(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.linear * p.coords + self.translation)
    }

    /// The map back.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the determinant vanishes against the product of the columns' lengths;
    /// [`Error::NotFinite`] where a coefficient, of the map or of its inverse, is not a number that can be written.
    pub fn inverse(&self) -> Result<Self, Error> {
        let area = self.linear.column(0).norm() * self.linear.column(1).norm();
        let determinant = self.linear.determinant();
        let limit = 8.0 * f64::EPSILON * area;
        let not_finite = Error::NotFinite { what: "affine map or its inverse" };
        if !(area.is_finite() && determinant.is_finite()) {
            return Err(not_finite);
        }
        match self.linear.try_inverse() {
            Some(inverse) if determinant.abs() > limit => {
                let back = Self { linear: inverse, translation: -(inverse * self.translation) };
                let finite = back.linear.iter().chain(&back.translation).all(|c| c.is_finite());
                if finite { Ok(back) } else { Err(not_finite) }
            }
            _ => Err(Error::Degenerate { what: "affine map", measure: determinant.abs(), limit }),
        }
    }

    /// This map after `first`.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            linear: self.linear * first.linear,
            translation: self.linear * first.translation + self.translation,
        }
    }

    /// The 3×3 matrix on homogeneous columns.
    #[must_use]
    pub fn to_matrix(&self) -> Matrix3<f64> {
        let (l, t) = (self.linear, self.translation);
        Matrix3::new(l.m11, l.m12, t.x, l.m21, l.m22, t.y, 0.0, 0.0, 1.0)
    }

    /// The map with the least sum of squared residuals at n ≥ 3 points: image ≈ A · object + b.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::TooFewPoints`], [`Error::NotFinite`], and [`Error::Degenerate`] where the
    /// object points lie on one line.
    pub fn fit(object: &[Point2<f64>], image: &[Point2<f64>]) -> Result<AffineFit, Error> {
        if object.len() != image.len() {
            return Err(Error::LengthMismatch {
                what: "object and image points",
                left: object.len(),
                right: image.len(),
            });
        }
        let n = object.len();
        if n < 3 {
            return Err(Error::TooFewPoints { needed: 3, got: n });
        }
        if !object.iter().chain(image).all(|p| p.coords.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "affine control point" });
        }
        // About the centroids: map coordinates of 10⁶ must not cost digits.
        let mean = |points: &[Point2<f64>]| {
            points[0] + points.iter().fold(Vector2::zeros(), |s, p| s + (p - points[0])) / n as f64
        };
        let (from, to) = (mean(object), mean(image));
        let mut rows = [Triangular::<3>::new(), Triangular::<3>::new()];
        for (o, i) in object.iter().zip(image) {
            let (d, e) = (o - from, i - to);
            rows[0].add_row([d.x, d.y, e.x]);
            rows[1].add_row([d.x, d.y, e.y]);
        }
        let limit = 1e-14;
        let degenerate =
            Error::Degenerate { what: "affine fit: points on one line", measure: 0.0, limit };
        let a = rows[0].solve(limit).ok_or(degenerate)?;
        let b = rows[1].solve(limit).ok_or(degenerate)?;
        let linear = Matrix2::new(a[0], a[1], b[0], b[1]);
        let map = Self { linear, translation: to.coords - linear * from.coords };
        // Residuals about the centroids as well, where they are exact.
        let residuals: Vec<Vector2<f64>> =
            object.iter().zip(image).map(|(o, i)| (i - to) - linear * (o - from)).collect();
        let sum: f64 = residuals.iter().map(|r| r.norm_squared()).sum();
        let redundancy = 2 * n - 6;
        let sigma0 = unit_weight(sum, redundancy);
        Ok(AffineFit { map, residuals, sigma0 })
    }
}

/// An affine map fitted to points, with what is left.
#[derive(Clone, Debug, PartialEq)]
pub struct AffineFit {
    /// The map, image from object.
    pub map: Affine2,
    /// Image point minus mapped object point, for each pair.
    pub residuals: Vec<Vector2<f64>>,
    /// √(Σ‖v‖² / (2n − 6)), the standard deviation of one coordinate; `None` for three points.
    pub sigma0: Option<f64>,
}
