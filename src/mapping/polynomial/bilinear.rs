//! The bilinear map of a quad, and its inverse: the roots of a quadratic.

use nalgebra::{Matrix2, Point2, Vector2};

use super::{Bilinear, Polynomial, Rectangle, array};
use crate::error::{Error, ProjectionError};
use crate::mapping::Map;
use crate::numeric::polynomial::quadratic_roots;
use crate::numeric::twofold::Twofold;

/// a × b, as if rounded once.
pub(in crate::mapping) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    let product = |a: f64, b: f64| Twofold::new(a) * Twofold::new(b);
    (product(a[0], b[1]) - product(a[1], b[0])).round()
}

/// The real (ξ, η) with e = b ξ + c η + d ξ η, at most two; or, where there is none, by how much the discriminant over
/// the square of the linear term falls short of zero.
///
/// (e − b ξ) is parallel to (c + d ξ), so that (b×d) ξ² + (b×c − e×d) ξ − e×c = 0. A root at which c + d ξ vanishes
/// belongs to a whole line of points or to none, and is left out.
pub(in crate::mapping) fn solve_bilinear(
    e: [f64; 2],
    b: [f64; 2],
    c: [f64; 2],
    d: [f64; 2],
) -> Result<[Option<[f64; 2]>; 2], f64> {
    let (square, linear, constant) = (cross(b, d), cross(b, c) - cross(e, d), -cross(e, c));
    let Some(roots) = quadratic_roots(square, linear, constant) else {
        let short = 4.0 * square * constant / (linear * linear) - 1.0;
        return Err(if short.is_nan() { 0.0 } else { short });
    };
    let complete = |xi: f64| {
        let v = [c[0] + d[0] * xi, c[1] + d[1] * xi];
        let rest = [e[0] - b[0] * xi, e[1] - b[1] * xi];
        let eta = (rest[0] * v[0] + rest[1] * v[1]) / (v[0] * v[0] + v[1] * v[1]);
        let size = e[0].abs() + e[1].abs() + (b[0].abs() + b[1].abs()) * xi.abs();
        let left = (rest[0] - v[0] * eta).abs() + (rest[1] - v[1] * eta).abs();
        // False for NaN: a root at infinity, or a collapsed line.
        (left <= SPURIOUS * size && eta.is_finite()).then(|| polish([xi, eta], e, b, c, d))
    };
    let second = if roots[0] == roots[1] { None } else { complete(roots[1]) };
    Ok([complete(roots[0]), second])
}

/// A root of the quadratic that leaves more than this share of e is the one that c + d ξ = 0 adds. A double root is
/// found to about the square root of the rounding, 1e-8.
const SPURIOUS: f64 = 1e-6;

/// One Newton step, kept if it brings the point nearer.
fn polish(p: [f64; 2], e: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> [f64; 2] {
    let miss = |[x, y]: [f64; 2]| -> [f64; 2] {
        core::array::from_fn(|i| (b[i] * x - e[i]) + (c[i] + d[i] * x) * y)
    };
    let length = |m: [f64; 2]| m[0].abs() + m[1].abs();
    let f = miss(p);
    let (bx, cy) =
        ([b[0] + d[0] * p[1], b[1] + d[1] * p[1]], [c[0] + d[0] * p[0], c[1] + d[1] * p[0]]);
    let determinant = cross(bx, cy);
    let next = [p[0] - cross(f, cy) / determinant, p[1] - cross(bx, f) / determinant];
    // False for NaN.
    if length(miss(next)) < length(f) { next } else { p }
}

impl Bilinear {
    /// The map of the unit square's corners (0, 0), (1, 0), (1, 1), (0, 1) to the corners of a convex quad.
    ///
    /// # Errors
    /// [`Error::NotFinite`], and [`Error::FoldedQuad`] where the map would fold inside the square: the Jacobian's
    /// determinant is linear in X and Y, so it does if it does not have one sign in the corners.
    pub fn from_quad(corners: &[Point2<f64>; 4]) -> Result<Self, Error> {
        if !corners.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
            return Err(Error::NotFinite { what: "quad corner" });
        }
        let [p0, p1, p2, p3] = corners;
        let weights: [f64; 4] = core::array::from_fn(|i| {
            let (next, last) =
                (corners[(i + 1) % 4] - corners[i], corners[(i + 3) % 4] - corners[i]);
            cross(array(&next), array(&last))
        });
        if !(weights.iter().all(|w| *w > 0.0) || weights.iter().all(|w| *w < 0.0)) {
            return Err(Error::FoldedQuad { weights });
        }
        let (b, c) = (p1 - p0, p3 - p0);
        let d: Vector2<f64> = (p2 - p1) - (p3 - p0);
        let mut polynomial =
            Polynomial::from_coefficients([0.0, b.x, c.x, d.x], [0.0, b.y, c.y, d.y])?;
        polynomial.offset = [p0.x, p0.y];
        polynomial.domain = Rectangle::UNIT;
        Ok(Self(polynomial))
    }

    /// The object points that map to `image`, the preferred one first.
    ///
    /// *Model.* With e = image − (A₀, B₀), b = (A₁, B₁), c = (A₂, B₂), d = (A₃, B₃):
    ///
    /// ```text
    /// (b×d) X² + (b×c − e×d) X − e×c = 0,   Y = (e − bX)·(c + dX) / |c + dX|²
    /// ```
    ///
    /// Preferred is the point with the smaller max(|ξ|, |η|), where ξ and η are ±1 on the sides of the domain: one
    /// inside the domain before one outside, else the one nearest to the domain. (Of a map that does not fold in its
    /// domain at most one is inside.)
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`]; [`ProjectionError::OutsideDomain`] where no real point maps to `image`, with 4
    /// times the products of the quadratic's outer coefficients over the square of the inner one, and its limit 1; or
    /// where the map is degenerate there (value and limit 0).
    pub fn roots(&self, image: &Point2<f64>) -> Result<[Option<Point2<f64>>; 2], ProjectionError> {
        let p = &self.0;
        let term = |k: usize| [p.a[k], p.b[k]];
        let e = [image.x - p.offset[0] - p.a[0], image.y - p.offset[1] - p.b[0]];
        if !(e[0].is_finite() && e[1].is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let roots = solve_bilinear(e, term(1), term(2), term(3))
            .map_err(|short| ProjectionError::OutsideDomain { value: 1.0 + short, limit: 1.0 })?;
        let object = |r: [f64; 2]| {
            let c: [f64; 2] = core::array::from_fn(|i| p.frame.centre[i] + p.frame.half[i] * r[i]);
            Point2::new(c[0], c[1])
        };
        let far = |q: &Point2<f64>| p.domain.distance([q.x, q.y]);
        match roots.map(|r| r.map(object)) {
            [None, None] => Err(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 }),
            [Some(a), Some(b)] if far(&b) < far(&a) => Ok([Some(b), Some(a)]),
            [None, Some(b)] => Ok([Some(b), None]),
            ordered => Ok(ordered),
        }
    }

    /// The object point that maps to `image`: the first of [`roots`](Self::roots).
    ///
    /// # Errors
    /// As [`roots`](Self::roots).
    pub fn inverse(&self, image: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [first, _] = self.roots(image)?;
        first.ok_or(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 })
    }

    /// The inverse as a map of its own.
    #[must_use]
    pub fn inverted(self) -> InverseBilinear {
        InverseBilinear(self)
    }
}

/// The inverse of a bilinear map as a map: a texture stretched bilinearly onto a quad of the screen, looked up from the
/// screen.
///
/// Straight lines of the screen become hyperbolas in the texture.
///
/// *Domain and errors.* As [`Bilinear::roots`]: of two texture points that a screen point can show, the one inside the
/// square.
///
/// # Example
/// A trapezoid with the values of a published test of inverse bilinear elements (square [−1, 1]², corners in turn; here
/// the square is [0, 1]²):
///
/// ```
/// use collinear::mapping::{Map, polynomial::Bilinear};
/// use nalgebra::Point2;
///
/// let quad = [(1.0, 2.0), (0.0, 1.0), (0.0, 0.0), (1.0, -1.0)].map(|(x, y)| Point2::new(x, y));
/// let map = Bilinear::from_quad(&quad)?.inverted();
/// assert!((map.at(&Point2::new(0.75, 1.125))? - Point2::new(0.25, 0.25)).norm() < 1e-15);
/// assert!((map.at(&Point2::new(0.25, 0.125))? - Point2::new(0.75, 0.75)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseBilinear(Bilinear);

impl InverseBilinear {
    /// The map that this one inverts.
    #[must_use]
    pub fn forward(&self) -> &Bilinear {
        &self.0
    }
}

impl Map for InverseBilinear {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.0.inverse(screen)
    }

    /// The inverse of the forward map's Jacobian; [`ProjectionError::OutsideDomain`] on the fold.
    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let forward = self.0.jacobian(&self.at(screen)?)?;
        forward.try_inverse().ok_or(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 })
    }
}
