//! The one formula behind the polynomial lenses.

use nalgebra::{Matrix2, Point2, Vector2};

use super::one_to_one::OneToOne;
use crate::error::Error;
use crate::numeric::float;
use crate::numeric::polynomial::MAX_COEFFICIENTS;
use crate::numeric::scalar::Scalar;

/// Radial, decentering and thin-prism distortion, as much of each as the constants say.
///
/// ```text
/// x″ = x N/D + m (2 p₁ x y + p₂ (s + 2x²)) + s₁ s + s₂ s²
/// y″ = y N/D + m (p₁ (s + 2y²) + 2 p₂ x y) + s₃ s + s₄ s²        s = r² = x² + y²
/// N = 1 + k₁ s + k₂ s² + …,   D = 1 + d₁ s + d₂ s² + …,   m = 1 + q₁ s + q₂ s²
/// ```
///
/// `N` and `D` are the numbers of coefficients above and below; `T` is 0 without decentering, 1 with p and 2 with p and q;
/// `S` is 0 without a thin prism, 1 with s₁ and s₃ and 2 with all four. What is absent costs nothing.
///
/// # Domain
/// The map is one to one on a disc on which the symmetric part of its Jacobian is positive definite: on a segment from a to
/// b within it, (F(b) − F(a))·(b − a) > 0. The eigenvalues of the radial part are (r N/D)′ and N/D; the other parts lower
/// them by no more than
///
/// ```text
/// T(r) = |p| (6 r + 12 |q₁| r³ + 18 |q₂| r⁵) + 2 |(s₁, s₃)| r + 4 |(s₂, s₄)| r³
/// ```
///
/// which decentering with q = 0 attains in one direction. The fold radius is the first root of the smaller eigenvalue
/// less T, multiplied by D²: a polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Planar<const N: usize, const D: usize, const T: u8, const S: u8> {
    pub(super) k: [f64; N],
    pub(super) d: [f64; D],
    pub(super) p: [f64; 2],
    pub(super) q: [f64; 2],
    pub(super) s: [f64; 4],
    fold_radius: f64,
}

/// 1 + c₁ s + c₂ s² + …
#[inline(always)]
fn series<V: Scalar>(coefficients: &[V], s: V) -> V {
    let one = V::constant(1.0);
    let Some((last, rest)) = coefficients.split_last() else { return one };
    rest.iter().rev().fold(*last, |sum, c| sum * s + *c) * s + one
}

/// The slope of [`series`] in s.
#[inline(always)]
fn series_slope<V: Scalar>(coefficients: &[V], s: V) -> V {
    let Some((last, rest)) = coefficients.split_last() else { return V::constant(0.0) };
    let last = last.scale(coefficients.len() as f64);
    rest.iter().enumerate().rev().fold(last, |sum, (i, c)| sum * s + c.scale((i + 1) as f64))
}

/// The parts of the formula at a point: x″ = x (N/D + `along`) + `across` s.
struct Parts<V> {
    /// N, D.
    ratio: [V; 2],
    /// 2 m (p₂ x + p₁ y)
    along: V,
    /// m (p₂, p₁) + (s₁ + s₂ s, s₃ + s₄ s)
    across: [V; 2],
    /// s
    r2: V,
}

impl<V: Scalar> Parts<V> {
    #[inline(always)]
    fn new<const N: usize, const D: usize, const T: u8, const S: u8>(
        [x, y]: [V; 2],
        k: &[V; N],
        d: &[V; D],
        p: &[V; 2],
        q: &[V; 2],
        s: &[V; 4],
    ) -> Self {
        let zero = V::constant(0.0);
        let r2 = x * x + y * y;
        let (mut along, mut across) = (zero, [zero; 2]);
        if T > 0 {
            across = [p[1], p[0]];
            if T > 1 {
                let m = series(q, r2);
                across = across.map(|p| p * m);
            }
            let [a, b] = across.map(|c| c.scale(2.0));
            along = a * x + b * y;
        }
        if S > 0 {
            let of = |first: V, second: V| if S > 1 { first + second * r2 } else { first };
            let prism = [of(s[0], s[1]), of(s[2], s[3])];
            across = if T > 0 { [across[0] + prism[0], across[1] + prism[1]] } else { prism };
        }
        Self { ratio: [series(k, r2), series(d, r2)], along, across, r2 }
    }
}

/// The formula.
#[inline(always)]
fn distort<V: Scalar, const N: usize, const D: usize, const T: u8, const S: u8>(
    [x, y]: [V; 2],
    k: &[V; N],
    d: &[V; D],
    p: &[V; 2],
    q: &[V; 2],
    s: &[V; 4],
) -> [V; 2] {
    let parts = Parts::new::<N, D, T, S>([x, y], k, d, p, q, s);
    let [mut radial, below] = parts.ratio;
    if D > 0 {
        radial = radial / below;
    }
    if T > 0 {
        radial = radial + parts.along;
    }
    let mut out = [x * radial, y * radial];
    if T > 0 || S > 0 {
        let [a, b] = parts.across;
        out = [out[0] + a * parts.r2, out[1] + b * parts.r2];
    }
    out
}

/// The largest coefficient: their products in the fold's polynomial stay within the numbers.
const LARGEST: f64 = 1e30;

/// A polynomial in r.
type InRadius = [f64; MAX_COEFFICIENTS];

fn add(a: &mut InRadius, b: &InRadius, factor: f64) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}

/// a·b; the formulas' degrees stay below the length.
fn multiply(a: &InRadius, b: &InRadius) -> InRadius {
    let mut product = [0.0; MAX_COEFFICIENTS];
    for (i, a) in a.iter().enumerate().filter(|(_, a)| **a != 0.0) {
        for (out, b) in product[i..].iter_mut().zip(b) {
            *out += a * b;
        }
    }
    product
}

/// 1 + c₁ r² + …, and r times its derivative in r.
fn even(coefficients: &[f64]) -> [InRadius; 2] {
    let mut out = [[0.0; MAX_COEFFICIENTS]; 2];
    out[0][0] = 1.0;
    for (i, c) in (1..).zip(coefficients) {
        out[0][2 * i] = *c;
        out[1][2 * i] = 2.0 * i as f64 * c;
    }
    out
}

impl<const N: usize, const D: usize, const T: u8, const S: u8> Planar<N, D, T, S> {
    /// From its coefficients; `lowered` is what a linear part outside this formula takes from the eigenvalues.
    pub(super) fn new(
        k: [f64; N],
        d: [f64; D],
        p: [f64; 2],
        q: [f64; 2],
        s: [f64; 4],
        lowered: f64,
    ) -> Result<Self, Error> {
        let finite = |c: &f64| c.is_finite();
        let given = [&k[..], &d, &p, &q, &s];
        if !given.iter().all(|c| c.iter().all(finite)) {
            return Err(Error::NotFinite { what: "distortion coefficient" });
        }
        if let Some(value) = given.into_iter().flatten().find(|c| c.abs() > LARGEST) {
            return Err(Error::OutOfRange {
                what: "distortion coefficient",
                value: *value,
                expected: "at most 1e30 in magnitude",
            });
        }
        let ([n, rn], [den, rd]) = (even(&k), even(&d));
        let size = |a: f64, b: f64| float::hypot(a, b);
        let mut taken = [0.0; MAX_COEFFICIENTS];
        let [p_size, q1, q2] = [size(p[0], p[1]), q[0].abs(), q[1].abs()];
        taken[0] = lowered;
        taken[1] = 6.0 * p_size + 2.0 * size(s[0], s[2]);
        taken[3] = 12.0 * p_size * q1 + 4.0 * size(s[1], s[3]);
        taken[5] = 18.0 * p_size * q2;
        let taken = multiply(&taken, &multiply(&den, &den));
        // D² N/D, and D² (r N/D)′ = N D + (r N′) D − N (r D′).
        let mut tangential = multiply(&n, &den);
        let mut radial = tangential;
        add(&mut radial, &multiply(&rn, &den), 1.0);
        add(&mut radial, &multiply(&n, &rd), -1.0);
        add(&mut tangential, &taken, -1.0);
        add(&mut radial, &taken, -1.0);
        let fold_radius = [radial, tangential, den]
            .iter()
            .map(|polynomial| super::first_root(polynomial))
            .fold(f64::INFINITY, f64::min);
        let usable = [radial, tangential].iter().all(|c| c.iter().all(finite) && c[0] > 0.0);
        if !(usable && fold_radius > 0.0) {
            return Err(Error::OutOfRange {
                what: "distortion fold radius",
                value: if usable { fold_radius } else { 0.0 },
                expected: "more than 0: smaller coefficients",
            });
        }
        Ok(Self { k, d, p, q, s, fold_radius })
    }

    /// All coefficients zero.
    pub(super) fn none() -> Self {
        let (k, d, [p, q], s) = ([0.0; N], [0.0; D], [[0.0; 2]; 2], [0.0; 4]);
        Self { k, d, p, q, s, fold_radius: f64::INFINITY }
    }

    /// The coefficients as another kind of number: k, d, p, q, s.
    #[inline(always)]
    #[allow(clippy::type_complexity, reason = "five groups of one formula")]
    fn lifted<V: Scalar>(&self) -> ([V; N], [V; D], [V; 2], [V; 2], [V; 4]) {
        (
            self.k.map(V::constant),
            self.d.map(V::constant),
            self.p.map(V::constant),
            self.q.map(V::constant),
            self.s.map(V::constant),
        )
    }

    /// N/D and its slope in s.
    #[inline(always)]
    fn ratio<V: Scalar>(&self, r2: V) -> [V; 2] {
        let (k, d, ..) = self.lifted::<V>();
        let (value, slope) = (series(&k, r2), series_slope(&k, r2));
        if D == 0 {
            return [value, slope];
        }
        let below = series(&d, r2);
        let ratio = value / below;
        [ratio, (slope - ratio * series_slope(&d, r2)) / below]
    }

    /// D times the distorted point less a target, and D: no division, for those who compare with zero.
    #[inline(always)]
    pub(super) fn miss<V: Scalar>(&self, [x, y]: [V; 2], target: [V; 2]) -> ([V; 2], V) {
        let (k, d, p, q, s) = self.lifted::<V>();
        let parts = Parts::new::<N, D, T, S>([x, y], &k, &d, &p, &q, &s);
        let [mut radial, below] = parts.ratio;
        if T > 0 {
            radial = radial + if D > 0 { below * parts.along } else { parts.along };
        }
        let mut rest = target;
        if T > 0 || S > 0 {
            let [a, b] = parts.across;
            rest = [target[0] - a * parts.r2, target[1] - b * parts.r2];
        }
        if D > 0 {
            rest = rest.map(|c| below * c);
        }
        ([x * radial - rest[0], y * radial - rest[1]], below)
    }

    /// D.
    #[inline(always)]
    pub(super) fn below<V: Scalar>(&self, [x, y]: [V; 2]) -> V {
        series(&self.d.map(V::constant), x * x + y * y)
    }

    /// What decentering and prism add.
    #[inline(always)]
    pub(super) fn beside_radial<V: Scalar>(&self, [x, y]: [V; 2]) -> [V; 2] {
        let (.., p, q, s) = self.lifted::<V>();
        let parts = Parts::new::<0, 0, T, S>([x, y], &[], &[], &p, &q, &s);
        let ([a, b], along) = (parts.across, parts.along);
        [x * along + a * parts.r2, y * along + b * parts.r2]
    }

    /// ∂(x″, y″)/∂(x, y), by rows.
    #[inline(always)]
    pub(super) fn jacobian_of<V: Scalar>(&self, point: [V; 2]) -> [V; 4] {
        let ratio = self.ratio(point[0] * point[0] + point[1] * point[1]);
        self.jacobian_from(point, ratio, V::constant(1.0))
    }

    /// D² ∂(x″, y″)/∂(x, y), by rows: no division.
    #[inline(always)]
    pub(super) fn jacobian_numerator<V: Scalar>(&self, point: [V; 2]) -> [V; 4] {
        let r2 = point[0] * point[0] + point[1] * point[1];
        if D == 0 {
            return self.jacobian_from(point, self.ratio(r2), V::constant(1.0));
        }
        let (k, d, ..) = self.lifted::<V>();
        let (above, below) = (series(&k, r2), series(&d, r2));
        let slope = series_slope(&k, r2) * below - above * series_slope(&d, r2);
        self.jacobian_from(point, [above * below, slope], below * below)
    }

    /// The Jacobian times a weight, from N/D and its slope times the weight.
    ///
    /// With a = N/D + along, g = ∇a and c = across: ∂/∂(x, y) of (x, y) a + c s is a I + (x, y) gᵀ + (2 c + 2 s c′) (x, y)ᵀ.
    #[inline(always)]
    fn jacobian_from<V: Scalar>(&self, [x, y]: [V; 2], ratio: [V; 2], weight: V) -> [V; 4] {
        let (.., p, q, s) = self.lifted::<V>();
        let [mut a, slope] = ratio;
        let mut slope = slope.scale(2.0);
        if T == 0 && S == 0 {
            let off = slope * x * y;
            return [a + slope * x * x, off, off, a + slope * y * y];
        }
        let parts = Parts::new::<0, 0, T, S>([x, y], &[], &[], &p, &q, &s);
        let weighted = |c: V| if D > 0 { c * weight } else { c };
        // 2 m (p₂, p₁), and the halves of 2 c and of 2 s c′.
        let mut by_p = [V::constant(0.0); 2];
        let mut by_c = parts.across;
        if T > 0 {
            a = a + weighted(parts.along);
            by_p = [p[1], p[0]];
            if T > 1 {
                let (m, m_slope) = (series(&q, parts.r2), series_slope(&q, parts.r2));
                let along = (p[1] * x + p[0] * y).scale(4.0);
                slope = slope + weighted(along * m_slope);
                by_c = core::array::from_fn(|i| by_c[i] + by_p[i] * (parts.r2 * m_slope));
                by_p = by_p.map(|p| p * m);
            }
        }
        if S > 1 {
            by_c = [by_c[0] + s[1] * parts.r2, by_c[1] + s[3] * parts.r2];
        }
        let double = |c: V| weighted(c).scale(2.0);
        let h = by_c.map(double);
        let mut g = [slope * x, slope * y];
        if T > 0 {
            g = [g[0] + double(by_p[0]), g[1] + double(by_p[1])];
        }
        [a + x * (g[0] + h[0]), x * g[1] + h[0] * y, y * g[0] + h[1] * x, a + y * (g[1] + h[1])]
    }
}

impl<const N: usize, const D: usize, const T: u8, const S: u8> OneToOne for Planar<N, D, T, S> {
    #[inline]
    fn value(&self, p: &Point2<f64>) -> Point2<f64> {
        Point2::from(distort::<f64, N, D, T, S>(
            [p.x, p.y],
            &self.k,
            &self.d,
            &self.p,
            &self.q,
            &self.s,
        ))
    }

    #[inline]
    fn jacobian(&self, point: &Point2<f64>) -> Matrix2<f64> {
        let [a, b, c, d] = self.jacobian_of([point.x, point.y]);
        Matrix2::new(a, b, c, d)
    }

    #[inline]
    fn fold_radius(&self) -> f64 {
        self.fold_radius
    }

    fn reach(&self, radius: f64) -> f64 {
        let r2 = radius * radius;
        let mut reach = self.radial(radius)[0];
        if T > 0 {
            let q = self.q.map(f64::abs);
            reach += 3.0 * float::hypot(self.p[0], self.p[1]) * r2 * series(&q, r2);
        }
        if S > 0 {
            let [s1, s2, s3, s4] = self.s;
            reach += (float::hypot(s1, s3) + float::hypot(s2, s4) * r2) * r2;
        }
        reach
    }

    #[inline]
    fn radial(&self, radius: f64) -> [f64; 2] {
        let r2 = radius * radius;
        let [ratio, slope] = self.ratio(r2);
        [radius * ratio, ratio + 2.0 * r2 * slope]
    }

    #[inline]
    fn is_radial(&self) -> bool {
        T == 0 && S == 0
    }

    /// In the order k, d, p, q, s.
    #[inline]
    fn columns(&self, point: &Point2<f64>, out: &mut [Vector2<f64>]) {
        let (x, y) = (point.x, point.y);
        let (here, r2) = (point.coords, x * x + y * y);
        let below = if D > 0 { series(&self.d, r2) } else { 1.0 };
        let mut out = out.iter_mut();
        let mut put = |column: Vector2<f64>| {
            if let Some(place) = out.next() {
                *place = column;
            }
        };
        let mut term = here / below;
        for _ in 0..N {
            term *= r2;
            put(term);
        }
        let mut term = here * (-self.ratio(r2)[0] / below);
        for _ in 0..D {
            term *= r2;
            put(term);
        }
        if T > 0 {
            let m = if T > 1 { series(&self.q, r2) } else { 1.0 };
            put(Vector2::new(2.0 * x * y, r2 + 2.0 * y * y) * m);
            put(Vector2::new(r2 + 2.0 * x * x, 2.0 * x * y) * m);
        }
        if T > 1 {
            let [p1, p2] = self.p;
            let t = here * (2.0 * (p2 * x + p1 * y)) + Vector2::new(p2, p1) * r2;
            put(t * r2);
            put(t * (r2 * r2));
        }
        if S > 0 {
            for axis in [Vector2::x(), Vector2::y()] {
                put(axis * r2);
                if S > 1 {
                    put(axis * (r2 * r2));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    fn agrees<const N: usize, const D: usize, const T: u8, const S: u8>() {
        const SMALL: [f64; 6] = [-0.13, 0.021, 0.017, -0.0063, 0.0019, -0.0007];
        let k: [f64; N] = core::array::from_fn(|i| SMALL[i]);
        let d: [f64; D] = core::array::from_fn(|i| 0.7 * SMALL[5 - i] + 0.011);
        let p = [1.1e-3, -6e-4].map(|c| if T > 0 { c } else { 0.0 });
        let q = [0.31, -0.12].map(|c| if T > 1 { c } else { 0.0 });
        let s = match S {
            0 => [0.0; 4],
            1 => [8e-4, 0.0, -7e-4, 0.0],
            _ => [8e-4, -4e-4, -7e-4, 3e-4],
        };
        let lens = Planar::<N, D, T, S>::new(k, d, p, q, s, 0.0).unwrap();
        for point in [[0.31, -0.22], [-0.4, -0.1], [0.05, 0.5], [0.0, 0.0]] {
            let variable = |value, i| Dual::<20>::variable(value, i);
            let dual = distort::<_, N, D, T, S>(
                core::array::from_fn(|i| variable(point[i], i)),
                &core::array::from_fn(|i| variable(k[i], 2 + i)),
                &core::array::from_fn(|i| variable(d[i], 8 + i)),
                &core::array::from_fn(|i| variable(p[i], 11 + i)),
                &core::array::from_fn(|i| variable(q[i], 13 + i)),
                &core::array::from_fn(|i| variable(s[i], 15 + i)),
            );
            let point = Point2::from(point);
            let jacobian = lens.jacobian(&point);
            let mut columns = [Vector2::zeros(); 17];
            lens.columns(&point, &mut columns);
            let variables = (2..2 + N)
                .chain(8..8 + D)
                .chain(if T > 0 { 11..13 } else { 0..0 })
                .chain(if T > 1 { 13..15 } else { 0..0 })
                .chain((15..19).step_by(if S == 1 { 2 } else { 1 }).filter(|_| S > 0));
            for row in 0..2 {
                for i in 0..2 {
                    assert!((dual[row].gradient[i] - jacobian[(row, i)]).abs() < 1e-15);
                }
                for (variable, column) in variables.clone().zip(&columns) {
                    let exact = dual[row].gradient[variable];
                    assert!((exact - column[row]).abs() < 1e-15, "{variable}");
                }
            }
            // Freed of their denominators both are the same numbers.
            let at = [point.x, point.y];
            let (miss, below) = lens.miss(at, [0.2, -0.3]);
            let distorted = [dual[0].value, dual[1].value];
            for (i, target) in [0.2, -0.3].into_iter().enumerate() {
                assert!((miss[i] - below * (distorted[i] - target)).abs() < 1e-15);
            }
            let numerator = Matrix2::from_row_slice(&lens.jacobian_numerator(at));
            assert!((numerator - jacobian * (below * below)).norm() < 4e-15, "{numerator}");
            let r = point.coords.norm();
            let [value, slope] = lens.radial(r);
            let far = lens.radial(r + 1e-6)[0];
            assert!(((far - value) / 1e-6 - slope).abs() < 1e-5);
        }
    }

    #[test]
    fn jacobians_agree_with_dual_numbers() {
        agrees::<3, 0, 1, 0>();
        agrees::<3, 3, 1, 2>();
        agrees::<4, 0, 0, 0>();
        agrees::<4, 0, 1, 1>();
        agrees::<6, 0, 0, 0>();
        agrees::<0, 0, 1, 2>();
        agrees::<4, 0, 2, 0>();
    }
}
