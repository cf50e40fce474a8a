//! Rows of pixels, looked up a few blocks of 64 at once.
//!
//! Where blocks look is found first ([`Located`]), then a filter weighs their taps ([`BlockFilter`]). Pixels whose taps are not
//! all within the picture are looked up alone.

use alloc::boxed::Box;
use core::ops::Range;

use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, Sample};
use super::located::{Located, Plan, Within};
use super::position::LARGEST;
use super::sampler::{Prepared, Sampler};
use super::taps::{BLOCKS, Window};
use super::weigh::{Bilinear, BlockFilter, Nearest, Separable, Taps, Work};
use crate::mapping::span::{BLOCK, Span};
use crate::numeric::vectorised_by_half;

/// Where blocks are worked on; kept from row to row. Vectors that cross cache lines would be slow to read back.
#[repr(align(64))]
struct Scratch<T> {
    located: Located,
    work: Work,
    /// A block's pixels of up to four channels.
    pixels: [T; 4 * BLOCK],
}

/// Where neighbouring pixels look.
pub(super) enum Positions<'a> {
    /// u and v of each.
    Each(&'a [f64], &'a [f64]),
    /// The pixels of an interval in which the span is valid.
    Span(Span<2>, Range<i32>),
}

/// What blocks of a row share.
struct Context<'a, T, F> {
    filter: &'a F,
    window: Window<'a, T>,
    plan: Plan,
}

/// A picture that rows of pixels are looked up in.
pub(super) struct BlockSampler<'a, T, const C: usize> {
    single: Sampler<'a, T, C>,
    scratch: Box<Scratch<T>>,
}

impl<'a, T: Sample, const C: usize> BlockSampler<'a, T, C> {
    /// `None` for a picture without pixels.
    pub(super) fn new(view: ImageView<'a, T, C>, filter: Filter, border: Border) -> Option<Self> {
        let single = Sampler::new(view, filter, border)?;
        let scratch = Box::new(Scratch {
            located: Located::new(),
            work: Work::EMPTY,
            pixels: [T::default(); 4 * BLOCK],
        });
        Some(Self { single, scratch })
    }

    /// Bytes from one row of the picture to the next.
    pub(super) fn bytes_a_row(&self) -> usize {
        self.single.view.samples().1.saturating_mul(size_of::<T>())
    }

    /// Writes the values at the positions to `pixels`; as [`Sampler::at`] for each.
    ///
    /// A pixel without a value becomes the border's constant and is left alone where it has none.
    pub(super) fn paint(&mut self, positions: &Positions<'_>, pixels: &mut [T]) {
        match self.single.filter {
            Prepared::Nearest => self.paint_with(&Nearest, positions, pixels),
            Prepared::Bilinear => self.paint_with(&Bilinear, positions, pixels),
            Prepared::Cubic(k) => self.paint_with(&Separable::<_, 4>(k), positions, pixels),
            Prepared::Lanczos2(k) => self.paint_with(&Separable::<_, 4>(k), positions, pixels),
            Prepared::Lanczos3(k) => self.paint_with(&Separable::<_, 6>(k), positions, pixels),
            Prepared::Lanczos4(k) => self.paint_with(&Separable::<_, 8>(k), positions, pixels),
        }
    }

    /// Where all taps lie within the picture; nowhere if it is too small or too large.
    fn within<F: BlockFilter<T, C>>(&self) -> Option<Within> {
        let view = &self.single.view;
        let (samples, stride) = view.samples();
        let [width, height] = [view.width(), view.height()];
        // An offset counts samples in 32 bits.
        let countable = u32::try_from(samples.len()).is_ok();
        if width < F::TAPS || width.max(height) >= LARGEST as usize || !countable {
            return None;
        }
        // Words may reach beyond the last row's texels, and then beyond the picture.
        let last = (height - 1) * stride + (width - F::TAPS) * C;
        let rows = height - usize::from(samples.len() - last < F::REACH);
        (rows >= F::TAPS).then(|| Within {
            before: F::TAPS.div_ceil(2) as u32 - 1,
            last: [(width - F::TAPS) as u32, (rows - F::TAPS) as u32],
        })
    }

    fn paint_with<F: BlockFilter<T, C>>(
        &mut self,
        filter: &F,
        positions: &Positions<'_>,
        pixels: &mut [T],
    ) {
        let Some(within) = self.within::<F>() else {
            match positions {
                Positions::Each(u, v) => self.paint_each(u, v, pixels),
                Positions::Span(span, valid) => {
                    span.walk(valid.clone(), |x, [u, v]| {
                        self.paint_each(u, v, &mut pixels[(x - valid.start) as usize * C..]);
                    });
                }
            }
            return;
        };
        let (samples, stride) = self.single.view.samples();
        let reach = (F::TAPS - 1) * stride + F::REACH;
        let Some(window) = Window::new(samples, reach) else { return };
        self.scratch.located.offsets.restrict(window.limit());
        let plan = Plan {
            within,
            shift: F::SHIFT,
            fractions: F::FRACTIONS,
            channels: C,
            stride: stride as u32,
        };
        self.paint_blocks(&Context { filter, window, plan }, positions, pixels);
    }

    fn paint_blocks<F: BlockFilter<T, C>>(
        &mut self,
        context: &Context<'_, T, F>,
        positions: &Positions<'_>,
        pixels: &mut [T],
    ) {
        let plan = &context.plan;
        // The first pixel's x, those whose filters see the picture, and those of them whose filters see nothing else.
        let (first, seen, inside) = match positions {
            Positions::Each(u, v) => (0, 0..u.len().min(v.len()) as i32, 0..0),
            Positions::Span(span, valid) => {
                let seen = self.single.seen(span, valid, F::TAPS);
                let inside = plan.within.interval(span, plan.shift, seen.clone());
                (valid.start, seen, inside)
            }
        };
        let (before, rest) = pixels.split_at_mut((seen.start - first) as usize * C);
        let (mut rest, after) = rest.split_at_mut(seen.len() * C);
        self.fill(before);
        self.fill(after);
        let mut x = seen.start;
        while x < seen.end {
            let anchor = x & !(BLOCK as i32 - 1);
            let whole = if x == anchor && inside.contains(&x) {
                ((inside.end - x) as usize / BLOCK).min(BLOCKS)
            } else {
                0
            };
            let from = (x - anchor) as usize;
            let count = if whole > 0 { whole * BLOCK } else { seen.len().min(BLOCK - from) };
            let count = count.min((seen.end - x) as usize);
            let (pixels, after) = core::mem::take(&mut rest).split_at_mut(count * C);
            let located = &mut self.scratch.located;
            let straight = match positions {
                Positions::Each(u, v) => {
                    let (u, v) = (part(u, x), part(v, x));
                    let straight = located.each(plan, [&u, &v], false) && count == BLOCK;
                    if !straight {
                        located.each(plan, [&u, &v], true);
                    }
                    straight
                }
                Positions::Span(span, _) => {
                    located.span(plan, span, anchor, whole.max(1), whole == 0);
                    whole > 0
                }
            };
            let Scratch { located, work, pixels: scratch } = &mut *self.scratch;
            if straight {
                weigh(context, located, work, pixels);
            } else {
                weigh(context, located, work, &mut scratch[..C * BLOCK]);
                self.mend(&plan.within, F::TAPS, from, pixels);
            }
            rest = after;
            x += count as i32;
        }
    }

    /// Pixels of a block from number `from` on: from the scratch those whose taps lie within, the others one by one.
    #[inline(never)]
    fn mend(&self, within: &Within, taps: usize, from: usize, pixels: &mut [T]) {
        let Scratch { located, pixels: whole, .. } = &*self.scratch;
        for (i, pixel) in (from..).zip(pixels.chunks_exact_mut(C)) {
            let first = located.first(i);
            if within.holds(first) {
                pixel.copy_from_slice(&whole[i * C..(i + 1) * C]);
            } else if self.single.sees_border(first, taps as i32) {
                self.single.paint_border(pixel);
            } else {
                let [u, v] = located.position(i);
                self.single.paint(self.single.at(u, v), pixel);
            }
        }
    }

    #[inline(never)]
    fn paint_each(&self, u: &[f64], v: &[f64], pixels: &mut [T]) {
        for ((u, v), pixel) in u.iter().zip(v).zip(pixels.chunks_exact_mut(C)) {
            self.single.paint(self.single.at(*u, *v), pixel);
        }
    }

    /// Paints pixels that no position is known for.
    pub(super) fn fill(&self, pixels: &mut [T]) {
        if let Border::Constant(_) = self.single.border {
            let (pixels, _) = pixels.as_chunks_mut::<C>();
            pixels.fill(self.single.constant);
        }
    }
}

/// The values of the blocks of `pixels`, whose places are found.
#[inline(never)]
fn weigh<T: Sample, F: BlockFilter<T, C>, const C: usize>(
    context: &Context<'_, T, F>,
    located: &Located,
    work: &mut Work,
    pixels: &mut [T],
) {
    let stride = context.plan.stride as usize;
    vectorised_by_half(
        #[inline(always)]
        || {
            for (block, pixels) in pixels.chunks_exact_mut(C * BLOCK).enumerate() {
                let Some(places) = context.window.places(&located.offsets, block) else { return };
                let taps = Taps { places, stride, fractions: located.fractions(block) };
                context.filter.weigh(&taps, work, pixels);
            }
        },
    );
}

/// The 64 positions from number `x` on, where those beyond the end repeat the last one.
#[inline(always)]
fn part(all: &[f64], x: i32) -> [f64; BLOCK] {
    let all = all.get(x as usize..).unwrap_or_default();
    if let Some(part) = all.first_chunk() {
        return *part;
    }
    let mut part = [all.last().copied().unwrap_or_default(); BLOCK];
    part[..all.len()].copy_from_slice(all);
    part
}
