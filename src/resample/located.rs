//! Where blocks of pixels look in a picture: first taps, as places in memory, and fractions.
//!
//! It knows nothing of samples but how many a texel has, so that it is compiled once for all kinds of pictures and filters.

use core::ops::Range;

#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use super::position::UNIT;
use super::position::{FIXED, FIXED_HIGH, fraction};
use super::taps::{BLOCKS, Offsets, OffsetsMut};
use crate::mapping::span::{BLOCK, LANES, Span};
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
use crate::mapping::span::{Form, Forms};
use crate::numeric::vectorised_by_half;

/// How positions become places of taps.
#[derive(Clone, Copy)]
pub(super) struct Plan {
    pub(super) within: Within,
    /// What is taken off a position before it is split.
    pub(super) shift: f64,
    /// Whether fractions are wanted.
    pub(super) fractions: bool,
    /// Samples a texel, and from one row to the next.
    pub(super) channels: usize,
    pub(super) stride: u32,
}

/// The texels whose filters lie within a picture: first taps from (0, 0) to a last one.
#[derive(Clone, Copy)]
pub(super) struct Within {
    /// Taps before the position along an axis, and the texels of the picture at hand's corner.
    pub(super) before: [i32; 2],
    /// The last column and row of a first tap.
    pub(super) last: [u32; 2],
}

/// The positions of some blocks of 64 pixels, split into whole texels and fractions.
///
/// Kept from row to row, so that no memory is cleared for what is written anyway.
#[repr(align(64))]
pub(super) struct Located {
    /// The fractions of u and of v.
    fractions: [[[f32; BLOCK]; 2]; BLOCKS],
    pub(super) offsets: Offsets,
    kept: Kept,
}

/// What a block with pixels at the picture's edge is looked up with.
#[repr(align(64))]
struct Kept {
    /// The columns and the rows of first taps; far outside the picture where there are none.
    first: [[u32; BLOCK]; 2],
    positions: [[f64; BLOCK]; 2],
}

impl Located {
    pub(super) fn new() -> Self {
        Self {
            fractions: [[[0.0; BLOCK]; 2]; BLOCKS],
            offsets: Offsets::new(0),
            kept: Kept { first: [[0; BLOCK]; 2], positions: [[0.0; BLOCK]; 2] },
        }
    }

    /// Takes the positions of some blocks of a span from pixel `anchor` on, a multiple of 64; keeps those of a single one.
    pub(super) fn span(
        &mut self,
        plan: &Plan,
        span: &Span<2>,
        anchor: i32,
        blocks: usize,
        keep: bool,
    ) {
        // Here and not where pixels are painted, so that it is compiled once for all kinds of them.
        match plan.channels {
            1 => self.span_of::<1>(plan, span, anchor, blocks, keep),
            2 => self.span_of::<2>(plan, span, anchor, blocks, keep),
            3 => self.span_of::<3>(plan, span, anchor, blocks, keep),
            _ => self.span_of::<4>(plan, span, anchor, blocks, keep),
        }
    }

    #[inline(always)]
    fn span_of<const C: usize>(
        &mut self,
        plan: &Plan,
        span: &Span<2>,
        anchor: i32,
        blocks: usize,
        keep: bool,
    ) {
        #[cfg(all(feature = "simd", target_arch = "x86_64"))]
        if !keep && let Some(simd) = fearless_simd::Level::new().as_avx512() {
            return self.span_wide::<C>(simd, plan, span, anchor, blocks);
        }
        vectorised_by_half(
            #[inline(always)]
            || {
                for block in 0..blocks.min(BLOCKS) {
                    self.span_block::<C>(plan, span, anchor + (block * BLOCK) as i32, block, keep);
                }
            },
        );
    }

    /// Takes the positions of a block.
    #[inline(always)]
    fn span_block<const C: usize>(
        &mut self,
        plan: &Plan,
        span: &Span<2>,
        anchor: i32,
        block: usize,
        keep: bool,
    ) {
        let (fractions, mut offsets, kept) = self.block(plan, block, keep);
        let (plan, mut to) = (*plan, Split { fractions, kept });
        span.walk_block(
            anchor,
            #[inline(always)]
            |start, [u, v]| {
                offsets.set::<LANES, C>(start, &to.set(start, [&u, &v], &plan));
            },
        );
    }

    /// As [`span`](Self::span), by vectors of eight doubles, of which compilers make none of that length by themselves.
    #[cfg(all(feature = "simd", target_arch = "x86_64"))]
    fn span_wide<const C: usize>(
        &mut self,
        simd: fearless_simd::Avx512,
        plan: &Plan,
        span: &Span<2>,
        anchor: i32,
        blocks: usize,
    ) {
        use fearless_simd::Simd;
        simd.vectorize(
            #[inline(always)]
            || {
                for block in 0..blocks.min(BLOCKS) {
                    let anchor = anchor + (block * BLOCK) as i32;
                    if let Some(forms) = span.forms(anchor) {
                        let (fractions, offsets, _) = self.block(plan, block, false);
                        locate_wide::<_, C>(simd, &forms, plan, offsets, fractions);
                    } else {
                        self.span_block::<C>(plan, span, anchor, block, false);
                    }
                }
            },
        );
    }

    /// Takes 64 positions, keeps them if `keep` says so, and says whether the taps of all lie within.
    pub(super) fn each(&mut self, plan: &Plan, positions: [&[f64; BLOCK]; 2], keep: bool) -> bool {
        match plan.channels {
            1 => self.each_of::<1>(plan, positions, keep),
            2 => self.each_of::<2>(plan, positions, keep),
            3 => self.each_of::<3>(plan, positions, keep),
            _ => self.each_of::<4>(plan, positions, keep),
        }
    }

    #[inline(always)]
    fn each_of<const C: usize>(
        &mut self,
        plan: &Plan,
        positions: [&[f64; BLOCK]; 2],
        keep: bool,
    ) -> bool {
        vectorised_by_half(
            #[inline(always)]
            || {
                let (fractions, mut offsets, kept) = self.block(plan, 0, keep);
                let first @ [x, y] = Split { fractions, kept }.set(0, positions, plan);
                offsets.set::<BLOCK, C>(0, &first);
                let [last_x, last_y] = plan.within.last;
                let mut beyond = 0;
                for i in 0..BLOCK {
                    // Zero where x and y are at most the last.
                    beyond |= (x[i].max(last_x) ^ last_x) | (y[i].max(last_y) ^ last_y);
                }
                beyond == 0
            },
        )
    }

    /// What is written of a block.
    #[inline(always)]
    fn block(
        &mut self,
        plan: &Plan,
        block: usize,
        keep: bool,
    ) -> (Option<&mut [[f32; BLOCK]; 2]>, OffsetsMut<'_>, Option<&mut Kept>) {
        let fractions = plan.fractions.then_some(&mut self.fractions[block]);
        (fractions, self.offsets.block(block, plan.stride), keep.then_some(&mut self.kept))
    }

    /// The fractions of the u and of the v of a block.
    #[inline(always)]
    pub(super) fn fractions(&self, block: usize) -> [&[f32; BLOCK]; 2] {
        self.fractions[block].each_ref()
    }

    /// Column and row of the first tap of a pixel that was kept.
    #[inline(always)]
    pub(super) fn first(&self, i: usize) -> [u32; 2] {
        [self.kept.first[0][i], self.kept.first[1][i]]
    }

    /// The position of a pixel that was kept.
    #[inline(always)]
    pub(super) fn position(&self, i: usize) -> [f64; 2] {
        [self.kept.positions[0][i], self.kept.positions[1][i]]
    }
}

/// [`Span::walk_block`] and [`Split::set`] by sixteen pixels, with the same bits.
#[cfg(all(feature = "simd", target_arch = "x86_64"))]
#[inline(always)]
fn locate_wide<S: fearless_simd::Simd, const C: usize>(
    simd: S,
    forms: &Forms<2>,
    plan: &Plan,
    mut offsets: OffsetsMut<'_>,
    mut fractions: Option<&mut [[f32; BLOCK]; 2]>,
) {
    use fearless_simd::{Bytes, SimdBase, SimdInt, f32x16, f64x8, i32x16, u32x16};
    let lanes = |form: &Form| f64x8::from_slice(simd, &form.lanes());
    let mut depths = lanes(&forms.depth);
    let mut sums = forms.numerators.each_ref().map(lanes);
    let depth_step = forms.depth.step_of_lanes();
    let steps = forms.numerators.each_ref().map(Form::step_of_lanes);
    let (fixed, bias) = (FIXED - plan.shift, plan.within.bias());
    let constant = f64x8::splat(simd, forms.reciprocal);
    for start in (0..BLOCK).step_by(2 * LANES) {
        let mut reciprocals = [constant; 2];
        if depth_step != 0.0 {
            let a = depths;
            let b = a + depth_step;
            depths = b + depth_step;
            let of_both = 1.0 / (a * b);
            reciprocals = [of_both * b, of_both * a];
        }
        let mut first = [u32x16::splat(simd, 0); 2];
        for k in 0..2 {
            let a = sums[k];
            let b = a + steps[k];
            sums[k] = b + steps[k];
            let bits = [a * reciprocals[0] + fixed, b * reciprocals[1] + fixed];
            let [a, b]: [u32x16<S>; 2] = bits.map(|sums| sums.bitcast());
            first[k] = a.unzip_high(b) - bias[k];
            if let Some(fractions) = &mut fractions {
                let low: i32x16<S> = (a.unzip_low(b) >> 8).bitcast();
                let fraction: f32x16<S> = low.to_float::<f32x16<S>>() * UNIT;
                fraction.store_slice(&mut fractions[k][start..start + 2 * LANES]);
            }
        }
        offsets.set_wide::<S, C>(start, first);
    }
}

/// Where the parts of a block's positions go.
struct Split<'a> {
    fractions: Option<&'a mut [[f32; BLOCK]; 2]>,
    kept: Option<&'a mut Kept>,
}

impl Split<'_> {
    /// Splits the positions of some neighbouring pixels from number `start` on; the columns and rows of their first taps.
    #[inline(always)]
    fn set<const L: usize>(
        &mut self,
        start: usize,
        [u, v]: [&[f64; L]; 2],
        plan: &Plan,
    ) -> [[u32; L]; 2] {
        let (fixed, bias) = (FIXED - plan.shift, plan.within.bias());
        let (mut u_bits, mut v_bits) = ([0; L], [0; L]);
        for i in 0..L {
            u_bits[i] = (u[i] + fixed).to_bits();
            v_bits[i] = (v[i] + fixed).to_bits();
        }
        let mut first = [[0; L]; 2];
        for i in 0..L {
            first[0][i] = ((u_bits[i] >> 32) as u32).wrapping_sub(bias[0]);
            first[1][i] = ((v_bits[i] >> 32) as u32).wrapping_sub(bias[1]);
        }
        let range = start..start + L;
        if let Some(kept) = &mut self.kept {
            for (to, first) in kept.first.iter_mut().zip(&first) {
                to[range.clone()].copy_from_slice(first);
            }
            for (to, positions) in kept.positions.iter_mut().zip([u, v]) {
                to[range.clone()].copy_from_slice(positions);
            }
        }
        if let Some([fu, fv]) = &mut self.fractions {
            let (fu, fv) = (&mut fu[range.clone()], &mut fv[range]);
            for i in 0..L {
                fu[i] = fraction(u_bits[i] as u32);
                fv[i] = fraction(v_bits[i] as u32);
            }
        }
        first
    }
}

impl Within {
    /// What is taken off the upper half of a sum's bits for the first tap along each axis.
    #[inline(always)]
    fn bias(&self) -> [u32; 2] {
        self.before.map(|before| FIXED_HIGH.wrapping_add_signed(before))
    }

    /// Whether the taps from a first one on lie within the picture.
    #[inline(always)]
    pub(super) fn holds(&self, [x, y]: [u32; 2]) -> bool {
        // What is negative, too large for the split, or no number, is a large number here.
        (x <= self.last[0]) & (y <= self.last[1])
    }

    /// The pixels of an interval whose taps, less `shift`, all lie within and not at its edge, so that those of positions that
    /// are rounded otherwise do too; perhaps a few less.
    pub(super) fn interval(&self, span: &Span<2>, shift: f64, range: Range<i32>) -> Range<i32> {
        let mut range = range;
        for axis in 0..2 {
            let first = f64::from(self.before[axis]) + shift;
            let ends = [first + 1.0, first + f64::from(self.last[axis]) - 1.0];
            range = span.interval_within(axis, ends, range, -2);
        }
        range
    }
}
