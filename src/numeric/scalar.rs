//! The scalar that formulas are written over: `f64`, or a dual number that carries derivatives.
//!
//! Each formula of the crate is one private function over [`Scalar`]. The hand-written Jacobian beside it is checked
//! against the dual numbers of that very function; the formula itself has an oracle outside the crate.

use core::ops::{Add, Div, Mul, Neg, Sub};

use super::float;

/// A number that a formula can be evaluated in.
pub(crate) trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A constant.
    fn constant(value: f64) -> Self;
    /// The value without derivatives.
    fn value(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// The angle of (x, y) = (`other`, `self`), in (−π, π].
    #[cfg_attr(
        not(test),
        allow(dead_code, reason = "duals check the projections' slopes in tests")
    )]
    fn atan2(self, other: Self) -> Self;
    /// Multiplied by a constant.
    fn scale(self, factor: f64) -> Self {
        self * Self::constant(factor)
    }
}

impl Scalar for f64 {
    #[inline]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        float::sqrt(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        float::sin_cos(self)
    }
    #[inline]
    fn atan2(self, other: Self) -> Self {
        float::atan2(self, other)
    }
}

/// For what an iteration in `f64` makes exact: a register holds twice as many.
impl Scalar for f32 {
    #[inline]
    fn constant(value: f64) -> Self {
        value as Self
    }
    #[inline]
    fn value(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        Self::constant(float::sqrt(f64::from(self)))
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = float::sin_cos(f64::from(self));
        (Self::constant(sine), Self::constant(cosine))
    }
    #[inline]
    fn atan2(self, other: Self) -> Self {
        Self::constant(float::atan2(f64::from(self), f64::from(other)))
    }
}

/// A dual number: a value and its derivatives with respect to `N` variables (Clifford 1873).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    not(test),
    allow(dead_code, reason = "formulas are differentiated by hand; duals check them in tests")
)]
pub(crate) struct Dual<const N: usize> {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; N],
}

#[cfg_attr(
    not(test),
    allow(dead_code, reason = "formulas are differentiated by hand; duals check them in tests")
)]
impl<const N: usize> Dual<N> {
    /// The `index`-th variable at `value`.
    pub(crate) fn variable(value: f64, index: usize) -> Self {
        let mut gradient = [0.0; N];
        gradient[index] = 1.0;
        Self { value, gradient }
    }

    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, gradient: self.gradient.map(|g| g * slope) }
    }

    fn zip(self, other: Self, value: f64, f: impl Fn(f64, f64) -> f64) -> Self {
        Self { value, gradient: core::array::from_fn(|i| f(self.gradient[i], other.gradient[i])) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.zip(o, self.value + o.value, |a, b| a + b)
    }
}
impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.zip(o, self.value - o.value, |a, b| a - b)
    }
}
#[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.zip(o, self.value * o.value, |a, b| a * o.value + b * self.value)
    }
}
#[allow(clippy::suspicious_arithmetic_impl, reason = "the quotient rule subtracts and multiplies")]
impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let q = self.value / o.value;
        self.zip(o, q, |a, b| (a - q * b) / o.value)
    }
}
impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N] }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Self {
        let root = float::sqrt(self.value);
        self.chain(root, 0.5 / root)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = float::sin_cos(self.value);
        (self.chain(s, c), self.chain(c, -s))
    }
    fn atan2(self, other: Self) -> Self {
        let squared = self.value * self.value + other.value * other.value;
        self.zip(other, float::atan2(self.value, other.value), |y, x| {
            (y * other.value - x * self.value) / squared
        })
    }
}
