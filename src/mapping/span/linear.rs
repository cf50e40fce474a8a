//! A linear form on the pixels of a row, evaluated as if once rounded.

/// a + b x for integer x, without cancellation.
///
/// The step is split into two 26-bit halves, b = bₕ + bₗ (Veltkamp), so that bₕ x and bₗ x are exact for
/// |x| ≤ 2²⁷, and a + bₕ x is summed with its error e (Knuth): s + e = a + bₕ x. The value is fl(s + fl(e + bₗ x)).
///
/// ```text
/// |computed − (a + b x)| ≤ u (1 + 2⁻²³) |a + b x|,   u = 2⁻⁵³
/// ```
///
/// Proof. If −bₕ x / a lies in [½, 2], s is exact and e = 0 (Sterbenz), and one rounding remains. Otherwise
/// |a + bₕ x| ≥ ½ |bₕ x|, so |e + bₗ x| ≤ (u + 2⁻²⁵) |a + bₕ x|, whose rounding adds less than u 2⁻²⁴ |a + bₕ x|, and
/// |a + b x| ≥ (1 − 2⁻²⁵) |a + bₕ x|. ∎ In particular the sign is exact, and so the computed values rise or fall with x.
/// Coefficients are zero or between 2⁻⁸⁰⁰ and 2⁸⁰⁰, which keeps clear of underflow and overflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Linear {
    pub(super) at_origin: f64,
    pub(super) step: f64,
    high: f64,
    low: f64,
}

/// The relative error of [`Linear::at`].
pub(super) const LINEAR_ERROR: f64 = 0.5 * f64::EPSILON * (1.0 + 1.0 / 8_388_608.0);

impl Linear {
    /// The smallest and the largest magnitude of a coefficient that is not zero.
    pub(super) const MAGNITUDES: [f64; 2] =
        [f64::from_bits((1023 - 800) << 52), f64::from_bits((1023 + 800) << 52)];

    pub(super) fn new(at_origin: f64, step: f64) -> Self {
        let c = 134_217_729.0 * step; // 2²⁷ + 1
        let high = c - (c - step);
        Self { at_origin, step, high, low: step - high }
    }

    /// The value at an integer |x| ≤ 2²⁷.
    #[inline(always)]
    pub(super) fn at(&self, x: f64) -> f64 {
        let (a, p) = (self.at_origin, self.high * x);
        let sum = a + p;
        let p_part = sum - a;
        let error = (a - (sum - p_part)) + (p - p_part);
        sum + (error + self.low * x)
    }

    /// The values at x, x + 1, ….
    #[inline(always)]
    pub(super) fn fill(&self, x: f64, values: &mut [f64]) {
        let count = values.len().min(RAMP.len());
        let (values, ramp) = (&mut values[..count], &RAMP[..count]);
        for i in 0..count {
            values[i] = self.at(x + ramp[i]);
        }
    }
}

/// 0, 1, 2, …: integers as floats, so that a loop over pixels needs no conversion.
pub(super) const RAMP: [f64; super::BLOCK] = {
    let mut ramp = [0.0; super::BLOCK];
    let mut i = 0;
    while i < super::BLOCK {
        ramp[i] = i as f64;
        i += 1;
    }
    ramp
};
