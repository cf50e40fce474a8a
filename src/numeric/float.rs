//! Float functions with or without the standard library.
//!
//! With `std` they are the inherent methods; without, those of the `libm` crate.

macro_rules! unary {
    ($($name:ident),*) => {$(
        #[inline]
        pub(crate) fn $name(x: f64) -> f64 {
            #[cfg(feature = "std")]
            { x.$name() }
            #[cfg(not(feature = "std"))]
            { libm::$name(x) }
        }
    )*};
}
unary!(sqrt, sin, floor, ceil, round, exp);

/// ln(1 + x), exact for small x.
#[inline]
pub(crate) fn ln_1p(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.ln_1p();
    #[cfg(not(feature = "std"))]
    return libm::log1p(x);
}

/// Natural logarithm.
#[inline]
pub(crate) fn ln(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.ln();
    #[cfg(not(feature = "std"))]
    return libm::log(x);
}

/// The angle of the vector (x, y), in (−π, π].
#[inline]
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    #[cfg(feature = "std")]
    return y.atan2(x);
    #[cfg(not(feature = "std"))]
    return libm::atan2(y, x);
}

/// √(x² + y²) without overflow.
#[inline]
pub(crate) fn hypot(x: f64, y: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.hypot(y);
    #[cfg(not(feature = "std"))]
    return libm::hypot(x, y);
}

/// Sine and cosine.
#[inline]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    #[cfg(feature = "std")]
    return x.sin_cos();
    #[cfg(not(feature = "std"))]
    return libm::sincos(x);
}

/// The remainder of `x` by a positive `period`, in [0, period).
#[inline]
pub(crate) fn wrap(x: f64, period: f64) -> f64 {
    let r = x - floor(x / period) * period;
    if r >= period || r < 0.0 { 0.0 } else { r }
}

/// The power of two p for which p · `size` lies in [1, 2); one for zero, infinity and numbers near the ends of the range.
#[inline]
pub(crate) fn unit_power(size: f64) -> f64 {
    let exponent = (size.to_bits() >> 52) & 0x7ff;
    if (1..2046).contains(&exponent) { f64::from_bits((2046 - exponent) << 52) } else { 1.0 }
}
