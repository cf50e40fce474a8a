//! Positions as whole texels and fractions.
//!
//! A position is rounded to 2⁻³² texel by adding 1.5 · 2²⁰: the sum's upper 32 bits are then its floor and the lower ones its
//! fraction, which costs an addition where a conversion, a comparison and a difference would be needed otherwise. So a
//! position that misses a texel's edge by no more than the rounding of its computation lies on it.

use crate::mapping::span::BLOCK;

/// 1.5 · 2²⁰: sums with numbers below 2¹⁹ have the unit 2⁻³².
pub(super) const FIXED: f64 = 1_572_864.0;
/// The upper half of its bits.
pub(super) const FIXED_HIGH: u32 = 0x4138_0000;
/// Positions below this magnitude are split by addition; so pictures with sides below it have the fast path.
pub(super) const LARGEST: f64 = 524_288.0;
/// The fraction's unit where it becomes `f32`.
pub(super) const UNIT: f32 = 1.0 / 16_777_216.0;

/// ⌊x⌋ for |x| ≤ 2³⁰.
#[inline]
pub(super) fn floor(x: f64) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(x < f64::from(truncated))
}

/// The floor and the fraction of x less `shift`, to 2⁻²⁴ texel; |x| ≤ 2³⁰.
#[inline]
pub(super) fn split(x: f64, shift: f64) -> (i32, f32) {
    if x.abs() < LARGEST {
        let (whole, fraction) = split_near(x, shift);
        (whole as i32, fraction)
    } else {
        let x = x - shift;
        let whole = floor(x);
        // Truncated to the same unit.
        (whole, ((x - f64::from(whole)) * 16_777_216.0) as i32 as f32 * UNIT)
    }
}

/// [`split`] for |x| < [`LARGEST`]; far outside any picture for what is larger or no number.
#[inline(always)]
pub(super) fn split_near(x: f64, shift: f64) -> (u32, f32) {
    let bits = (x + (FIXED - shift)).to_bits();
    (((bits >> 32) as u32).wrapping_sub(FIXED_HIGH), fraction(bits as u32))
}

/// The fraction in the lower half of a sum's bits.
#[inline(always)]
pub(super) fn fraction(low: u32) -> f32 {
    // 24 bits, which f32 holds.
    (low >> 8) as i32 as f32 * UNIT
}

/// The first 64 positions of a slice, which is not empty, where those beyond its end repeat the last one.
#[inline(always)]
pub(super) fn whole_block(positions: &[f64]) -> [f64; BLOCK] {
    if let Some(block) = positions.first_chunk() {
        return *block;
    }
    let mut block = [positions.last().copied().unwrap_or(f64::NAN); BLOCK];
    block[..positions.len()].copy_from_slice(positions);
    block
}
