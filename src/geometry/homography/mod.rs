//! Homographies: maps of one plane onto another that keep lines straight.
//!
//! A plane seen by a camera, or by two, is a homography; so is a rectangle of texture drawn in perspective. The type is
//! [`Homography`]. It is made from four corners in closed form, from n points by least squares
//! ([`Homography::fit`], [`Homography::fit_robust`]), or from any regular 3×3 matrix, and [`decompose`](mod@decompose)
//! takes it apart into poses.
//!
#![doc = include_str!("../../../docs/figures/homography.svg")]

pub mod decompose;
mod fit;
mod quad;
mod robust;
mod transfer;

use core::ops::Mul;

use nalgebra::{Matrix2, Matrix3, Point2};

pub use fit::{FitOptions, HomographyFit, TransferCost};
pub use robust::RobustHomography;

use super::Affine2;
use crate::error::{Error, ProjectionError};
use crate::numeric::float::{self, unit_power};
use crate::numeric::scalar::Scalar;
use crate::numeric::twofold::{Twofold, determinant};

/// A projective map of the plane, with a front and a back.
///
/// ```text
/// (u′, v′, w)ᵀ = H (x, y, 1)ᵀ,   u = u′/w,   v = v′/w
///
/// u = (P₀ + P₁ S + P₂ L) / (R₀ + R₁ S + R₂ L)
/// v = (Q₀ + Q₁ S + Q₂ L) / (R₀ + R₁ S + R₂ L)        Weinhaus & Devarajan 1997, eq. 1
/// ```
///
/// *Orientation.* H and −H map every point alike, but only one of them has w > 0 on the side of the horizon that is
/// seen. That sign is part of the value: [`apply`](Self::apply) refuses points with w ≤ 0, which lie behind the camera
/// although the division would give them a plausible image. Constructors from points choose the sign so that the points
/// given lie in front.
///
/// *Scale.* Any positive factor of H is the same map. R₀ is not assumed to be one; a map that sends the origin to
/// infinity (R₀ = 0) is as good as any other.
///
/// *Domain.* The matrix is finite and regular.
///
/// # Example
/// The texture square onto a quad, with the numbers of `PerspectiveTransformTestCase` of zxing (Owen):
/// ```
/// use collinear::geometry::Homography;
/// use nalgebra::Point2;
///
/// let corners = [(2.0, 3.0), (10.0, 4.0), (16.0, 15.0), (4.0, 9.0)].map(|(x, y)| Point2::new(x, y));
/// let map = Homography::from_unit_square(&corners)?;
/// let centre = map.apply(&Point2::new(0.5, 0.5))?;
/// assert!((centre - Point2::new(6.535211, 6.8873234)).norm() < 1e-6);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias("perspective transform", "projective transform", "collineation", "plane map"))]
pub struct Homography {
    matrix: Matrix3<f64>,
}

/// The measure below which a matrix counts as singular: a change of its entries by two roundings makes it so.
const SINGULAR: f64 = 2.0 * f64::EPSILON;

impl Homography {
    /// The identity.
    #[must_use]
    pub fn identity() -> Self {
        Self { matrix: Matrix3::identity() }
    }

    /// From a matrix on columns (x, y, 1). Its sign says which side of the horizon is in front.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::Degenerate`] for a singular matrix. The measure is |det H| / Σ|hᵢⱼ cᵢⱼ| with
    /// the cofactors cᵢⱼ: the smallest relative change of the entries that makes H singular, to first order. No scaling
    /// of rows or columns alters it.
    pub fn from_matrix(matrix: Matrix3<f64>) -> Result<Self, Error> {
        regular(&matrix)?;
        Ok(Self { matrix })
    }

    /// From an affine map.
    ///
    /// # Errors
    /// As [`from_matrix`](Self::from_matrix).
    pub fn from_affine(affine: &Affine2) -> Result<Self, Error> {
        Self::from_matrix(affine.to_matrix())
    }

    /// From the coefficients (P₀, P₁, P₂), (Q₀, Q₁, Q₂) and (R₀, R₁, R₂) of \[WD\] eq. 1.
    ///
    /// # Errors
    /// As [`from_matrix`](Self::from_matrix).
    pub fn from_coefficients(p: [f64; 3], q: [f64; 3], r: [f64; 3]) -> Result<Self, Error> {
        let row = |c: [f64; 3]| [c[1], c[2], c[0]];
        let rows = [row(p), row(q), row(r)];
        Self::from_matrix(Matrix3::from_fn(|i, j| rows[i][j]))
    }

    /// The coefficients of \[WD\] eq. 1: (P₀, P₁, P₂), (Q₀, Q₁, Q₂), (R₀, R₁, R₂).
    #[must_use]
    pub fn coefficients(&self) -> [[f64; 3]; 3] {
        let m = &self.matrix;
        [0, 1, 2].map(|i| [m[(i, 2)], m[(i, 0)], m[(i, 1)]])
    }

    /// H.
    #[must_use]
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// H divided by its last entry, or by its Frobenius norm where that entry is zero: the form other programs print.
    /// The division drops the orientation where R₀ < 0.
    #[must_use]
    #[doc(alias = "h33")]
    pub fn normalised(&self) -> Matrix3<f64> {
        let (largest, last) = (self.matrix.amax(), self.matrix.m33);
        let by_last = self.matrix / last;
        if by_last.iter().all(|e| e.is_finite()) {
            by_last
        } else {
            let scaled = self.matrix / largest;
            scaled / scaled.norm()
        }
    }

    /// The entries row by row, in a scalar that may carry derivatives.
    fn entries<S: Scalar>(&self) -> [S; 9] {
        let m = &self.matrix;
        core::array::from_fn(|k| S::constant(m[(k / 3, k % 3)]))
    }

    /// The denominator w = R₀ + R₁ x + R₂ y: positive in front of the horizon, zero on it. Along the map of a plane by a
    /// camera it is proportional to the depth of the point (or its inverse, for the map back).
    #[must_use]
    pub fn w(&self, p: &Point2<f64>) -> f64 {
        let [_, _, w] = homogeneous(&self.entries(), [p.x, p.y]);
        w
    }

    /// The image of a point in front of the horizon.
    ///
    /// # Errors
    /// [`ProjectionError::BeyondHorizon`] for w ≤ 0; [`ProjectionError::NotFinite`] where the point, or its image, is
    /// not finite.
    #[inline]
    pub fn apply(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [u, v, w] = homogeneous(&self.entries(), [p.x, p.y]);
        if w <= 0.0 {
            return Err(ProjectionError::BeyondHorizon { w });
        }
        finite(Point2::new(u / w, v / w))
    }

    /// The image of a point on either side of the horizon: the map of the whole projective plane, without orientation.
    ///
    /// # Errors
    /// [`ProjectionError::BeyondHorizon`] on the horizon itself, w = 0; [`ProjectionError::NotFinite`].
    #[inline]
    pub fn apply_unoriented(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [u, v, w] = homogeneous(&self.entries(), [p.x, p.y]);
        if w == 0.0 {
            return Err(ProjectionError::BeyondHorizon { w });
        }
        finite(Point2::new(u / w, v / w))
    }

    /// ∂(u, v)/∂(x, y): rows (Pₗ − u Rₗ)/w.
    ///
    /// # Errors
    /// As [`apply`](Self::apply).
    pub fn jacobian(&self, p: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let (image, w, m) = (self.apply(p)?, self.w(p), &self.matrix);
        let j = Matrix2::new(
            (m.m11 - image.x * m.m31) / w,
            (m.m12 - image.x * m.m32) / w,
            (m.m21 - image.y * m.m31) / w,
            (m.m22 - image.y * m.m32) / w,
        );
        if j.iter().all(|e| e.is_finite()) { Ok(j) } else { Err(ProjectionError::NotFinite) }
    }

    /// The line a x + b y + c = 0 whose points have no image, with (a, b) a unit vector towards the front; `None` for an
    /// affine map, whose horizon is at infinity.
    #[must_use]
    #[doc(alias = "vanishing line")]
    pub fn horizon(&self) -> Option<[f64; 3]> {
        let (a, b) = (self.matrix.m31, self.matrix.m32);
        let length = float::hypot(a, b);
        let line = [a / length, b / length, self.matrix.m33 / length];
        line.iter().all(|c| c.is_finite()).then_some(line)
    }

    /// The map back, H⁻¹. The images of the points in front lie in front of it: at the image of a point with denominator
    /// w its own denominator is 1/w. Every entry is accurate to a few roundings.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where a composition has lost its regularity (see [`from_matrix`](Self::from_matrix)) or the
    /// inverse leaves the range of floats.
    pub fn inverse(&self) -> Result<Self, Error> {
        let matrix = regular(&self.matrix)?.inverse();
        if matrix.iter().all(|e| e.is_finite()) {
            Ok(Self { matrix })
        } else {
            Err(Error::Degenerate {
                what: "inverse of a homography",
                measure: 0.0,
                limit: SINGULAR,
            })
        }
    }

    /// This map after `first`: `c_from_b.after(b_from_a)` is `c_from_a`. The denominators multiply, so that a point is in
    /// front of the composition where it is in front (or behind) in both.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        let product = self.matrix * first.matrix;
        let size = product.amax();
        if size.is_finite() && size > 1e-280 {
            return Self { matrix: product };
        }
        // Long chains drift in scale, which is free.
        let unit = |m: &Matrix3<f64>| m / m.amax();
        Self { matrix: unit(&self.matrix) * unit(&first.matrix) }
    }
}

impl Mul for Homography {
    type Output = Self;
    /// [`after`](Homography::after).
    fn mul(self, first: Self) -> Self {
        self.after(&first)
    }
}

/// H (x, y, 1)ᵀ.
#[inline]
fn homogeneous<S: Scalar>(h: &[S; 9], [x, y]: [S; 2]) -> [S; 3] {
    [h[0] * x + h[1] * y + h[2], h[3] * x + h[4] * y + h[5], h[6] * x + h[7] * y + h[8]]
}

#[inline]
fn finite(p: Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
    if p.x.is_finite() && p.y.is_finite() { Ok(p) } else { Err(ProjectionError::NotFinite) }
}

/// A regular matrix brought to entries near one by powers of two: M = diag(rows) A diag(columns).
struct Equilibrated {
    rows: [f64; 3],
    columns: [f64; 3],
    cofactors: Matrix3<f64>,
    determinant: f64,
}

/// The cofactors and the determinant, each to a few roundings, of a matrix that is not singular.
fn regular(matrix: &Matrix3<f64>) -> Result<Equilibrated, Error> {
    if !matrix.iter().all(|e| e.is_finite()) {
        return Err(Error::NotFinite { what: "homography matrix" });
    }
    let mut a = *matrix;
    let (mut rows, mut columns) = ([1.0; 3], [1.0; 3]);
    for (i, row) in rows.iter_mut().enumerate() {
        let power = unit_power(a.row(i).amax());
        *row = 1.0 / power;
        a.row_mut(i).scale_mut(power);
    }
    for (j, column) in columns.iter_mut().enumerate() {
        let power = unit_power(a.column(j).amax());
        *column = 1.0 / power;
        a.column_mut(j).scale_mut(power);
    }
    let cofactors = Matrix3::from_fn(|i, j| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        determinant(a[(i1, j1)], a[(i1, j2)], a[(i2, j1)], a[(i2, j2)])
    });
    let exact = |i, j| Twofold::new(a[(i, j)]);
    let minor = |j: usize| {
        let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
        exact(1, j1) * exact(2, j2) - exact(1, j2) * exact(2, j1)
    };
    let determinant =
        (exact(0, 0) * minor(0) + exact(0, 1) * minor(1) + exact(0, 2) * minor(2)).round();
    let weight: f64 = a.iter().zip(&cofactors).map(|(a, c)| (a * c).abs()).sum();
    let measure = if weight > 0.0 { determinant.abs() / weight } else { 0.0 };
    if measure.is_nan() || measure <= SINGULAR {
        return Err(Error::Degenerate { what: "homography matrix", measure, limit: SINGULAR });
    }
    Ok(Equilibrated { rows, columns, cofactors, determinant })
}

impl Equilibrated {
    fn inverse(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| {
            self.cofactors[(j, i)] / self.determinant / self.columns[i] / self.rows[j]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn jacobian_is_that_of_the_formula() {
        let h =
            Homography::from_coefficients([3.0, 1.5, -0.2], [-7.0, 0.3, 2.5], [1.2, 0.01, -0.03])
                .unwrap();
        let (x, y) = (4.0, -2.5);
        let [u, v, w] =
            homogeneous(&h.entries::<Dual<2>>(), [Dual::variable(x, 0), Dual::variable(y, 1)]);
        let j = h.jacobian(&Point2::new(x, y)).unwrap();
        for (row, dual) in [(0, u / w), (1, v / w)] {
            for column in 0..2 {
                assert!((j[(row, column)] - dual.gradient[column]).abs() < 1e-15);
            }
        }
    }
}
