//! Twofold precision: a number as the unevaluated sum of two floats, about 32 decimal digits.
//!
//! Used where a closed form cancels: the error-free sum of Knuth (1969) and product of Dekker (1971), without fused
//! multiply-add, so that every machine computes the same bits.

use core::ops::{Add, Mul, Neg, Sub};

use super::float;

/// The unevaluated sum high + low, |low| ≤ ½ ulp(high).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twofold {
    high: f64,
    low: f64,
}

/// a + b exactly, as rounded sum and error (Knuth).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// a as the sum of two 26-bit numbers (Veltkamp).
#[inline]
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2²⁷ + 1
    let high = c - (c - a);
    (high, a - high)
}

/// a · b exactly, as rounded product and error (Dekker).
#[inline]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
}

/// a d − b c, to a relative error of two roundings however far it cancels.
#[inline]
pub(crate) fn determinant(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let ((p, e), (q, f)) = (two_product(a, d), two_product(b, c));
    (p - q) + (e - f)
}

impl Twofold {
    /// a − b, exactly.
    #[inline]
    pub(crate) fn difference(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, -b);
        Self { high, low }
    }

    /// Times a power of two, exactly.
    #[inline]
    pub(crate) fn scale(self, power: f64) -> Self {
        Self { high: self.high * power, low: self.low * power }
    }

    /// An exact float.
    pub(crate) fn new(value: f64) -> Self {
        Self { high: value, low: 0.0 }
    }

    /// The nearest float.
    pub(crate) fn round(self) -> f64 {
        self.high + self.low
    }

    /// The quotient, to about 30 digits: one correction of the float quotient.
    pub(crate) fn div(self, other: Self) -> Self {
        let q = self.high / other.high;
        let rest = self - other * Self::new(q);
        let (high, low) = two_sum(q, rest.high / other.high);
        Self { high, low }
    }

    /// The square root of a number that is not negative, to about 30 digits: one correction of the float root.
    pub(crate) fn sqrt(self) -> Self {
        let root = float::sqrt(self.high);
        if root == 0.0 {
            return Self::new(0.0);
        }
        let rest = self - Self::new(root) * Self::new(root);
        let (high, low) = two_sum(root, rest.high / (2.0 * root));
        Self { high, low }
    }
}

impl Add for Twofold {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        let (s, e) = two_sum(self.high, o.high);
        let (t, f) = two_sum(self.low, o.low);
        let (s, e) = two_sum(s, e + t);
        let (high, low) = two_sum(s, e + f);
        Self { high, low }
    }
}
impl Neg for Twofold {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}
impl Sub for Twofold {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + -o
    }
}
impl Mul for Twofold {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        let (p, e) = two_product(self.high, o.high);
        let (high, low) = two_sum(p, e + (self.high * o.low + self.low * o.high));
        Self { high, low }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cancelling_determinant() {
        // (1 + 2⁻³⁰)(1 − 2⁻³⁰) − 1 = −2⁻⁶⁰: a float determinant returns 0.
        let h = 2f64.powi(-30);
        let d = Twofold::new(1.0 + h) * Twofold::new(1.0 - h) - Twofold::new(1.0);
        assert_eq!(d.round(), -(2f64.powi(-60)));
        // 1/3 to 30 digits: 3 · (1/3) − 1 vanishes to 2⁻¹⁰⁰.
        let third = Twofold::new(1.0).div(Twofold::new(3.0));
        assert!((Twofold::new(3.0) * third - Twofold::new(1.0)).round().abs() < 1e-30);
        let root = Twofold::new(2.0).sqrt();
        assert!((root * root - Twofold::new(2.0)).round().abs() < 1e-30);
    }
}
