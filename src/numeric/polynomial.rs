//! Real roots of small polynomials.

use super::float;

/// The real roots of a x² + b x + c, smaller first, without cancellation; `None` where there is none or every
/// coefficient of x vanishes. A linear equation has its one root twice.
pub(crate) fn quadratic_roots(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    if a == 0.0 {
        return (b != 0.0).then(|| [-c / b; 2]);
    }
    let half = -0.5 * b;
    let discriminant = half * half - a * c;
    if !(discriminant >= 0.0) {
        return None;
    }
    // The root of larger magnitude adds numbers of one sign; the other follows from the product of the roots, c/a.
    let q = half + float::sqrt(discriminant).copysign(half);
    if q == 0.0 {
        return Some([0.0; 2]);
    }
    let (x1, x2) = (q / a, c / q);
    Some(if x1 <= x2 { [x1, x2] } else { [x2, x1] })
}

/// Of the real roots of c₀ + c₁ x + c₂ x² + c₃ x³, c₃ ≠ 0, the one farthest from the mean of all three: it is simple where
/// the other two coincide.
///
/// ```text
/// x = t + m,  m = −c₂/(3 c₃):   t³ + p t + q = 0,   t has the sign of −q and the largest |t|
/// ```
///
/// Newton's iteration from 2 √(−p/3), which bounds it where three roots are real, or from Cardano's formula.
#[cfg(feature = "std")]
pub(crate) fn outer_cubic_root([c0, c1, c2, c3]: [f64; 4]) -> f64 {
    let (a, b, c) = (c2 / c3, c1 / c3, c0 / c3);
    let mean = -a / 3.0;
    let p = b + a * mean;
    let q = c + mean * (b + mean * (a + mean));
    let (third, half) = (p / 3.0, 0.5 * q.abs());
    let discriminant = half * half + third * third * third;
    let mut t = if discriminant <= 0.0 {
        2.0 * (-third).sqrt()
    } else {
        let u = (half + discriminant.sqrt()).cbrt();
        u - third / u
    };
    for _ in 0..12 {
        let slope = 3.0 * t * t + p;
        let step = (t * (t * t + p) - 2.0 * half) / slope;
        if !(step.abs() <= 2.0 * t) {
            break;
        }
        t -= step;
        if step.abs() <= 1e-15 * t {
            break;
        }
    }
    let x = mean - t.copysign(q);
    // Taking the mean off has rounded p and q: one step on the given polynomial.
    let slope = b + x * (2.0 * a + 3.0 * x);
    let corrected = x - (c + x * (b + x * (a + x))) / slope;
    if (corrected - x).abs() <= 1e-6 * (x.abs() + mean.abs()) { corrected } else { x }
}

/// Value of the polynomial c₀ + c₁ x + c₂ x² + … (Horner).
pub(crate) fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The largest number of coefficients [`roots_in`] takes.
pub(crate) const MAX_COEFFICIENTS: usize = 18;

/// The real roots of c₀ + c₁ x + … in the open interval (low, high), ascending, written to `roots`; returns how many.
///
/// Between two neighbouring extrema a polynomial is monotone and has at most one root, so the roots of the derivative,
/// found the same way, bracket those of the polynomial. Double roots, where the sign does not change, are not
/// returned. `low` and `high` are finite; `roots` holds at least `coefficients.len() - 1` numbers.
pub(crate) fn roots_in(coefficients: &[f64], low: f64, high: f64, roots: &mut [f64]) -> usize {
    let n = coefficients.len().min(MAX_COEFFICIENTS);
    if n < 2 {
        return 0;
    }
    let mut derivative = [0.0; MAX_COEFFICIENTS];
    for i in 1..n {
        derivative[i - 1] = coefficients[i] * i as f64;
    }
    let mut extrema = [0.0; MAX_COEFFICIENTS];
    let m = roots_in(&derivative[..n - 1], low, high, &mut extrema);
    let mut count = 0;
    let mut left = low;
    for right in extrema[..m].iter().copied().chain([high]) {
        if let Some(root) = monotone_root(coefficients, left, right) {
            roots[count] = root;
            count += 1;
        }
        left = right;
    }
    count
}

/// The root in (left, right) of a polynomial that is monotone there: bisection down to neighbouring floats.
fn monotone_root(coefficients: &[f64], left: f64, right: f64) -> Option<f64> {
    let (mut a, mut b) = (left, right);
    let (fa, fb) = (evaluate(coefficients, a), evaluate(coefficients, b));
    if fa == 0.0 || fb == 0.0 || fa.is_sign_negative() == fb.is_sign_negative() {
        return None;
    }
    loop {
        let middle = 0.5 * (a + b);
        if !(middle > a && middle < b) {
            return Some(middle);
        }
        let f = evaluate(coefficients, middle);
        if f == 0.0 {
            return Some(middle);
        }
        if f.is_sign_negative() == fa.is_sign_negative() {
            a = middle;
        } else {
            b = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_keeps_the_small_root() {
        // x² − 1e8 x + 1: the textbook formula loses the small root; 1.0000000000000001e-8 and 99999999.99999999 to 17 digits.
        let [small, large] = quadratic_roots(1.0, -1e8, 1.0).unwrap();
        assert!((small - 1e-8).abs() < 2e-24 && (large - 99_999_999.999_999_99).abs() < 3e-8);
        assert!(quadratic_roots(1.0, 0.0, 1.0).is_none());
        assert!(quadratic_roots(f64::NAN, 0.0, 1.0).is_none());
    }

    #[cfg(feature = "std")]
    #[test]
    fn the_root_of_a_cubic_farthest_from_the_mean() {
        for (coefficients, root) in [
            ([-8.0, 14.0, -7.0, 1.0], 4.0),      // 1, 2, 4: mean 7/3
            ([8.0, 14.0, 7.0, 1.0], -4.0),       // −1, −2, −4
            ([-10.0, 22.0, -14.0, 2.0], 5.0),    // 1, 1, 5, twice
            ([-3.0, 1.0, -3.0, 1.0], 3.0),       // 3, ±i
            ([-8.0, 12.0, -6.0, 1.0], 2.0),      // 2, 2, 2
            ([0.0, 1e6, 1e-3, 1e-9], 0.0),       // 0, and a complex pair
            ([-1e-9, 1.0, -1e-12, 1e-12], 1e-9), // 10⁻⁹, and a complex pair of about 10⁶
        ] {
            let found = outer_cubic_root(coefficients);
            assert!((found - root).abs() <= 4e-16 * f64::abs(root), "{coefficients:?} {found}");
        }
    }

    #[test]
    fn roots_of_a_quintic() {
        let exact = |x: f64| (x - 1.0) * (x - 2.0) * (x - 3.0) * (x + 4.0) * (x - 5.5);
        let mut c = [0.0; 6];
        // Coefficients by repeated multiplication, independent of `evaluate`.
        c[0] = 1.0;
        for (k, r) in [1.0, 2.0, 3.0, -4.0, 5.5].into_iter().enumerate() {
            for i in (0..=k + 1).rev() {
                c[i] = (if i > 0 { c[i - 1] } else { 0.0 }) - r * if i <= k { c[i] } else { 0.0 };
            }
        }
        assert!((evaluate(&c, 0.3) - exact(0.3)).abs() < 1e-11, "{c:?}");
        let mut roots = [0.0; 5];
        assert_eq!(roots_in(&c, -10.0, 10.0, &mut roots), 5);
        for (r, e) in roots.iter().zip([-4.0, 1.0, 2.0, 3.0, 5.5]) {
            assert!((r - e).abs() < 1e-12, "{r} {e}");
        }
        assert_eq!(roots_in(&c, 1.5, 2.5, &mut roots), 1);
    }
}
