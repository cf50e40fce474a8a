//! The polynomial maps of \[WD\] table 2: bilinear, quadratic and cubic, fitted to control points and inverted.
//!
//! ```text
//! x = Σ Aₖ φₖ(X, Y),   y = Σ Bₖ φₖ(X, Y)                                            [WD] table 2
//! φ = 1, X, Y, XY | X², Y² | X²Y, XY², X³, Y³          4 terms bilinear, 6 quadratic, 10 cubic
//! ```
//!
//! The affine map, with three terms, is [`Affine2`](crate::geometry::Affine2). A polynomial takes one picture into
//! another without a camera: it follows distortions that a projection cannot, and knows nothing of depth.
//!
//! Inside, object coordinates are taken relative to the centre of the control points' bounding rectangle and scaled by
//! its half sides, so map coordinates of 10⁶ keep their millimetres.
//!
#![doc = include_str!("../../../docs/figures/polynomial.svg")]
#![allow(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "a comparison that must fail for NaN is written negated"
)]
#![allow(clippy::needless_range_loop, reason = "parallel arrays are walked by one index")]

mod bilinear;
mod fit;
mod inverse;

use nalgebra::{Matrix2, Point2, Vector2};

pub use bilinear::InverseBilinear;
pub(super) use bilinear::{cross, solve_bilinear};
pub use fit::PolynomialFit;
pub use inverse::Inversion;

use super::Map;
use crate::error::{Error, ProjectionError};
use crate::numeric::scalar::Scalar;

/// The exponents (i, j) of the terms `XⁱYʲ`, in the order of table 2.
pub(super) const EXPONENTS: [(usize, usize); 10] =
    [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3)];

/// A rectangle by its centre and half sides.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rectangle {
    centre: [f64; 2],
    half: [f64; 2],
}

/// A polynomial as it is evaluated: offset + Σ (aₖ, bₖ) φₖ((X − centre) / half).
#[derive(Clone, Copy, Debug)]
pub(super) struct Terms<'a> {
    pub(super) centre: [f64; 2],
    pub(super) half: [f64; 2],
    pub(super) offset: [f64; 2],
    pub(super) a: &'a [f64],
    pub(super) b: &'a [f64],
}

impl Rectangle {
    const UNIT: Self = Self { centre: [0.5; 2], half: [0.5; 2] };

    /// The point in coordinates that are ±1 on the rectangle's sides.
    fn normalise(&self, p: [f64; 2]) -> [f64; 2] {
        core::array::from_fn(|i| (p[i] - self.centre[i]) / self.half[i])
    }

    /// max(|ξ|, |η|): at most one inside.
    fn distance(&self, p: [f64; 2]) -> f64 {
        let [x, y] = self.normalise(p);
        x.abs().max(y.abs())
    }
}

/// The first N terms of table 2 in ξ = (X − centre) / half, plus an offset.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Polynomial<const N: usize> {
    /// What X and Y are taken relative to; the unit about zero for raw coefficients.
    frame: Rectangle,
    offset: [f64; 2],
    a: [f64; N],
    b: [f64; N],
    /// Where the map is meant to be used.
    domain: Rectangle,
}

fn powers<S: Scalar>(x: S) -> [S; 4] {
    let square = x * x;
    [S::constant(1.0), x, square, square * x]
}

impl<const N: usize> Polynomial<N> {
    fn from_coefficients(a: [f64; N], b: [f64; N]) -> Result<Self, Error> {
        if !a.iter().chain(&b).all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "polynomial coefficient" });
        }
        let frame = Rectangle { centre: [0.0; 2], half: [1.0; 2] };
        Ok(Self { frame, offset: [0.0; 2], a, b, domain: Rectangle::UNIT })
    }

    fn set_domain(&mut self, low: &Point2<f64>, high: &Point2<f64>) -> Result<(), Error> {
        let centre = [low.x + 0.5 * (high.x - low.x), low.y + 0.5 * (high.y - low.y)];
        let half = [0.5 * (high.x - low.x), 0.5 * (high.y - low.y)];
        if !centre.iter().chain(&half).all(|c| c.is_finite()) {
            return Err(Error::NotFinite { what: "corner of a polynomial map's domain" });
        }
        if let Some(side) = half.iter().find(|h| !(**h > 0.0)) {
            return Err(Error::OutOfRange {
                what: "side of a polynomial map's domain",
                value: 2.0 * side,
                expected: "a positive length",
            });
        }
        self.domain = Rectangle { centre, half };
        Ok(())
    }

    /// The value without the offset, at coordinates of the frame.
    fn value<S: Scalar>(&self, x: S, y: S) -> [S; 2] {
        let (px, py) = (powers(x), powers(y));
        let mut sums = [S::constant(0.0); 2];
        // The high powers first: they are the small ones within the frame.
        for k in (0..N).rev() {
            let (i, j) = EXPONENTS[k];
            let term = px[i] * py[j];
            sums[0] = sums[0] + term.scale(self.a[k]);
            sums[1] = sums[1] + term.scale(self.b[k]);
        }
        sums
    }

    /// ∂(x, y)/∂(ξ, η) in the frame.
    fn frame_jacobian(&self, x: f64, y: f64) -> Matrix2<f64> {
        let (px, py) = (powers(x), powers(y));
        let mut m = Matrix2::zeros();
        for k in (1..N).rev() {
            let (i, j) = EXPONENTS[k];
            let (dx, dy) = (
                if i > 0 { i as f64 * px[i - 1] * py[j] } else { 0.0 },
                if j > 0 { j as f64 * px[i] * py[j - 1] } else { 0.0 },
            );
            m += Matrix2::new(self.a[k] * dx, self.a[k] * dy, self.b[k] * dx, self.b[k] * dy);
        }
        m
    }

    fn at(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [x, y] = self.frame.normalise([p.x, p.y]);
        let [u, v] = self.value(x, y);
        let image = Point2::new(u + self.offset[0], v + self.offset[1]);
        if image.x.is_finite() && image.y.is_finite() {
            Ok(image)
        } else {
            Err(ProjectionError::NotFinite)
        }
    }

    fn jacobian(&self, p: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let [x, y] = self.frame.normalise([p.x, p.y]);
        let [hx, hy] = self.frame.half;
        let m = self.frame_jacobian(x, y) * Matrix2::new(1.0 / hx, 0.0, 0.0, 1.0 / hy);
        if m.iter().all(|c| c.is_finite()) { Ok(m) } else { Err(ProjectionError::NotFinite) }
    }

    fn terms(&self) -> Terms<'_> {
        let Rectangle { centre, half } = self.frame;
        Terms { centre, half, offset: self.offset, a: &self.a, b: &self.b }
    }

    /// The coefficients in raw X and Y, by the binomial theorem.
    fn coefficients(&self) -> [[f64; N]; 2] {
        const CHOOSE: [[f64; 4]; 4] = [
            [1.0, 0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0, 0.0],
            [1.0, 2.0, 1.0, 0.0],
            [1.0, 3.0, 3.0, 1.0],
        ];
        let Rectangle { centre: [cx, cy], half: [hx, hy] } = self.frame;
        let (shift_x, shift_y, scale_x, scale_y) =
            (powers(-cx), powers(-cy), powers(1.0 / hx), powers(1.0 / hy));
        let mut raw = [[0.0; N]; 2];
        for (k, (i, j)) in EXPONENTS.into_iter().take(N).enumerate() {
            for (l, (p, q)) in EXPONENTS.into_iter().take(N).enumerate() {
                if p <= i && q <= j {
                    let factor = CHOOSE[i][p] * CHOOSE[j][q] * shift_x[i - p] * shift_y[j - q];
                    let factor = factor * scale_x[i] * scale_y[j];
                    raw[0][l] += self.a[k] * factor;
                    raw[1][l] += self.b[k] * factor;
                }
            }
        }
        raw[0][0] += self.offset[0];
        raw[1][0] += self.offset[1];
        raw
    }
}

macro_rules! polynomial_map {
    ($(#[$doc:meta])* $name:ident, $terms:literal, $columns:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name(Polynomial<$terms>);

        impl $name {
            /// The number of terms, and of control points that determine the map.
            pub const TERMS: usize = $terms;

            /// From table 2's coefficients A and B. The domain is the unit square.
            ///
            /// # Errors
            /// [`Error::NotFinite`].
            pub fn from_coefficients(a: [f64; $terms], b: [f64; $terms]) -> Result<Self, Error> {
                Polynomial::from_coefficients(a, b).map(Self)
            }

            /// Table 2's coefficients A and B, in raw X and Y.
            ///
            /// Expanding about a far origin cancels: with coordinates of 10⁶ the raw form has lost what the map keeps.
            #[must_use]
            pub fn coefficients(&self) -> [[f64; $terms]; 2] {
                self.0.coefficients()
            }

            /// The map with another rectangle in which it is meant to be used: the inverse prefers it. A fitted map
            /// has the bounding rectangle of its object points.
            ///
            /// # Errors
            /// [`Error::NotFinite`], and [`Error::OutOfRange`] for a side that is not positive.
            pub fn with_domain(mut self, low: &Point2<f64>, high: &Point2<f64>) -> Result<Self, Error> {
                self.0.set_domain(low, high)?;
                Ok(self)
            }

            pub(super) fn terms(&self) -> Terms<'_> {
                self.0.terms()
            }

            /// The map with the least sum of squared residuals at the control points: image ≈ map(object).
            ///
            /// The rows are reduced by rotations in normalised coordinates; no normal equations are formed.
            ///
            /// # Errors
            /// [`Error::LengthMismatch`], [`Error::TooFewPoints`], [`Error::NotFinite`], and [`Error::Degenerate`]
            /// where the object points do not determine the terms (they lie on one curve of the map's own degree); the
            /// measure is the ratio of the smallest singular value to the largest.
            pub fn fit(
                object: &[Point2<f64>],
                image: &[Point2<f64>],
            ) -> Result<PolynomialFit<Self>, Error> {
                fit::fit::<$terms, $columns, Self>(object, image, Self)
            }
        }

        impl Map for $name {
            fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
                self.0.at(screen)
            }

            fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
                self.0.jacobian(screen)
            }
        }
    };
}

polynomial_map!(
    /// The bilinear map.
    ///
    /// ```text
    /// x = A₀ + A₁X + A₂Y + A₃XY,   y = B₀ + B₁X + B₂Y + B₃XY                              [WD] table 2
    /// ```
    ///
    /// Lines parallel to the axes stay straight, and points equally spaced on them equally spaced. Any other line
    /// X = X₀ + p t, Y = Y₀ + q t becomes quadratic in t, a parabola (table 2 says hyperbolic curves; that holds for
    /// the inverse).
    ///
    /// ```
    /// use collinear::mapping::{Map, polynomial::Bilinear};
    /// use nalgebra::Point2;
    ///
    /// // The quad of ZXing's PerspectiveTransformTestCase: a bilinear map takes the square's centre to the mean of the
    /// // corners (8, 7.75), where the projective one gives (6.535, 6.887).
    /// let quad = [(2.0, 3.0), (10.0, 4.0), (16.0, 15.0), (4.0, 9.0)].map(|(x, y)| Point2::new(x, y));
    /// let map = Bilinear::from_quad(&quad)?;
    /// assert_eq!(map.at(&Point2::new(0.5, 0.5))?, Point2::new(8.0, 7.75));
    /// assert!((map.inverse(&Point2::new(8.0, 7.75))? - Point2::new(0.5, 0.5)).norm() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    Bilinear, 4, 5
);

polynomial_map!(
    /// The quadratic map, six terms a coordinate.
    ///
    /// ```text
    /// x = A₀ + A₁X + A₂Y + A₃XY + A₄X² + A₅Y²,   y likewise with B                        [WD] table 2
    /// ```
    ///
    /// ```
    /// use collinear::mapping::{Map, polynomial::Quadratic};
    /// use nalgebra::Point2;
    ///
    /// let map = Quadratic::from_coefficients([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])?;
    /// // 1 + 2·2 + 3·3 + 4·6 + 5·4 + 6·9
    /// assert_eq!(map.at(&Point2::new(2.0, 3.0))?, Point2::new(112.0, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    Quadratic, 6, 7
);

polynomial_map!(
    /// The cubic map, ten terms a coordinate.
    ///
    /// ```text
    /// x = A₀ + A₁X + A₂Y + A₃XY + A₄X² + A₅Y² + A₆X²Y + A₇XY² + A₈X³ + A₉Y³,   y likewise with B    [WD] table 2
    /// ```
    ///
    /// ```
    /// use collinear::mapping::{Map, polynomial::Cubic};
    /// use nalgebra::Point2;
    ///
    /// let a = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];
    /// let map = Cubic::from_coefficients(a, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    /// // 112 as the quadratic, and 7·12 + 8·18 + 9·8 + 10·27
    /// assert_eq!(map.at(&Point2::new(2.0, 3.0))?, Point2::new(682.0, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    Cubic, 10, 11
);

impl Quadratic {
    /// The object point that maps to `image`, sought from the domain's centre.
    ///
    /// # Errors
    /// As [`inverse_from`](Self::inverse_from).
    pub fn inverse(&self, image: &Point2<f64>) -> Result<Inversion, ProjectionError> {
        self.0.inverse(image, None)
    }

    /// The object point that maps to `image`, by damped Newton steps from `start`.
    ///
    /// Up to four points share an image; the iteration finds one that `start` leads to.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`], and [`ProjectionError::NotConverged`] with the distance in the image that was
    /// reached, where the iteration meets a fold or nothing maps there.
    pub fn inverse_from(
        &self,
        image: &Point2<f64>,
        start: &Point2<f64>,
    ) -> Result<Inversion, ProjectionError> {
        self.0.inverse(image, Some(start))
    }
}

impl Cubic {
    /// The object point that maps to `image`, sought from the domain's centre.
    ///
    /// # Errors
    /// As [`inverse_from`](Self::inverse_from).
    pub fn inverse(&self, image: &Point2<f64>) -> Result<Inversion, ProjectionError> {
        self.0.inverse(image, None)
    }

    /// The object point that maps to `image`, by damped Newton steps from `start`.
    ///
    /// Up to nine points share an image; the iteration finds one that `start` leads to.
    ///
    /// # Errors
    /// [`ProjectionError::NotFinite`], and [`ProjectionError::NotConverged`] with the distance in the image that was
    /// reached, where the iteration meets a fold or nothing maps there.
    pub fn inverse_from(
        &self,
        image: &Point2<f64>,
        start: &Point2<f64>,
    ) -> Result<Inversion, ProjectionError> {
        self.0.inverse(image, Some(start))
    }
}

/// v as an array.
fn array(v: &Vector2<f64>) -> [f64; 2] {
    [v.x, v.y]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    #[test]
    fn jacobian_equals_dual_numbers() {
        let a = [0.3, -1.1, 0.7, 0.25, -0.4, 0.9, 0.15, -0.35, 0.2, 0.05];
        let b = [1.0, 0.2, -0.8, 0.6, 0.1, -0.3, 0.45, 0.55, -0.65, 0.75];
        let p = Polynomial::from_coefficients(a, b).unwrap();
        for (x, y) in [(0.0, 0.0), (0.7, -1.3), (-2.0, 0.4)] {
            let dual = p.value(Dual::<2>::variable(x, 0), Dual::<2>::variable(y, 1));
            let m = p.frame_jacobian(x, y);
            for r in 0..2 {
                for c in 0..2 {
                    assert!((dual[r].gradient[c] - m[(r, c)]).abs() < 1e-14);
                }
            }
        }
    }
}
