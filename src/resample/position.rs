//! Positions as whole texels and fractions.
//!
//! A position is rounded to 2⁻³² texel by adding 1.5 · 2²⁰: the sum's upper 32 bits are then its floor and the lower ones its
//! fraction, which costs an addition where a conversion, a comparison and a difference would be needed otherwise. So a
//! position that misses a texel's edge by no more than the rounding of its computation lies on it.

use core::ops::Range;

use crate::mapping::span::{BLOCK, Span};

/// 1.5 · 2²⁰: sums with numbers below 2¹⁹ have the unit 2⁻³².
const FIXED: f64 = 1_572_864.0;
/// The upper half of its bits.
const FIXED_HIGH: u32 = 0x4138_0000;
/// Positions below this magnitude are split by addition; so pictures with sides below it have the fast path.
pub(super) const LARGEST: f64 = 524_288.0;
/// The fraction's unit where it becomes `f32`.
const UNIT: f32 = 1.0 / 16_777_216.0;
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
        let bits = (x + (FIXED - shift)).to_bits();
        ((((bits >> 32) as u32).wrapping_sub(FIXED_HIGH)) as i32, fraction(bits as u32))
    } else {
        let x = x - shift;
        let whole = floor(x);
        // Truncated to the same unit.
        (whole, ((x - f64::from(whole)) * 16_777_216.0) as i32 as f32 * UNIT)
    }
}

#[inline(always)]
fn fraction(low: u32) -> f32 {
    // 24 bits, which f32 holds.
    (low >> 8) as i32 as f32 * UNIT
}

/// The texels whose filters lie within a picture: first taps from (0, 0) to a last one.
#[derive(Clone, Copy)]
pub(super) struct Within {
    /// Taps before the position along an axis.
    pub(super) before: u32,
    /// The last column and row of a first tap.
    pub(super) last: [u32; 2],
}

/// The positions of 64 pixels, split into whole texels and fractions.
///
/// Kept from block to block, so that no memory is cleared for what is written anyway.
#[repr(align(64))]
pub(super) struct Split {
    /// The columns and the rows of first taps; far outside the picture where there are none.
    first: [[u32; BLOCK]; 2],
    /// The positions.
    positions: [[f64; BLOCK]; 2],
    /// The fractions of u and of v.
    pub(super) fractions: [[f32; BLOCK]; 2],
}

impl Split {
    pub(super) fn new() -> Self {
        Self { first: [[0; BLOCK]; 2], positions: [[0.0; BLOCK]; 2], fractions: [[0.0; BLOCK]; 2] }
    }

    /// Splits the positions of some neighbouring pixels from number `start` on, less `shift`, with or without fractions;
    /// the columns and rows of their first taps. These and the positions are kept if `keep` says so.
    #[inline(always)]
    pub(super) fn set<const L: usize>(
        &mut self,
        start: usize,
        [u, v]: [&[f64; L]; 2],
        shift: f64,
        within: &Within,
        [with_fractions, keep]: [bool; 2],
    ) -> [[u32; L]; 2] {
        let (fixed, bias) = (FIXED - shift, FIXED_HIGH + within.before);
        let (mut u_bits, mut v_bits) = ([0; L], [0; L]);
        for i in 0..L {
            u_bits[i] = (u[i] + fixed).to_bits();
            v_bits[i] = (v[i] + fixed).to_bits();
        }
        let mut first = [[0; L]; 2];
        for i in 0..L {
            first[0][i] = ((u_bits[i] >> 32) as u32).wrapping_sub(bias);
            first[1][i] = ((v_bits[i] >> 32) as u32).wrapping_sub(bias);
        }
        let range = start..start + L;
        if keep {
            for (to, first) in self.first.iter_mut().zip(&first) {
                to[range.clone()].copy_from_slice(first);
            }
            for (to, positions) in self.positions.iter_mut().zip([u, v]) {
                to[range.clone()].copy_from_slice(positions);
            }
        }
        if with_fractions {
            let [fu, fv] = &mut self.fractions;
            let (fu, fv) = (&mut fu[range.clone()], &mut fv[range]);
            for i in 0..L {
                fu[i] = fraction(u_bits[i] as u32);
                fv[i] = fraction(v_bits[i] as u32);
            }
        }
        first
    }

    /// Column and row of a pixel's first tap, where they were kept.
    #[inline(always)]
    pub(super) fn first(&self, i: usize) -> [u32; 2] {
        [self.first[0][i], self.first[1][i]]
    }

    /// A pixel's position, where it was kept.
    #[inline(always)]
    pub(super) fn position(&self, i: usize) -> [f64; 2] {
        [self.positions[0][i], self.positions[1][i]]
    }
}

impl Within {
    /// Whether the taps from a first one on lie within the picture.
    #[inline(always)]
    pub(super) fn holds(&self, [x, y]: [u32; 2]) -> bool {
        // What is negative, too large for the split, or no number, is a large number here.
        (x <= self.last[0]) & (y <= self.last[1])
    }

    /// The pixels of an interval whose taps, less `shift`, all lie within and not at its edge, so that those of positions that
    /// are rounded otherwise do too; perhaps a few less.
    pub(super) fn interval(&self, span: &Span<2>, shift: f64, range: Range<i32>) -> Range<i32> {
        let first = f64::from(self.before) + shift;
        let [columns, rows] = self.last.map(|last| [first + 1.0, first + f64::from(last) - 1.0]);
        let range = span.interval_within(0, columns, range, -2);
        span.interval_within(1, rows, range, -2)
    }
}
