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
use super::margin::Margin;
use super::position::{LARGEST, whole_block};
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

/// A picture, or the strip along one of its edges, that blocks find all their taps in.
#[derive(Clone, Copy)]
struct Region<'a, T> {
    window: Window<'a, T>,
    plan: Plan,
    /// The pixels of a row that do, from the first to beyond the last.
    pixels: [i32; 2],
}

impl<'a, T: Sample> Region<'a, T> {
    /// For no pixels yet; `None` if it is too small or too large.
    fn new<F: BlockFilter<T, C>, const C: usize>(
        samples: &'a [T],
        stride: usize,
        [width, height]: [usize; 2],
        origin: [i32; 2],
    ) -> Option<Self> {
        // An offset counts samples in 32 bits.
        let countable = u32::try_from(samples.len()).is_ok();
        if width < F::TAPS || width.max(height) >= LARGEST as usize || !countable {
            return None;
        }
        // Words may reach beyond the last row's texels, and then beyond the picture.
        let last = (height - 1) * stride + (width - F::TAPS) * C;
        let rows = height - usize::from(samples.len() - last < F::REACH);
        let within = Within {
            before: origin.map(|origin| F::TAPS.div_ceil(2) as i32 - 1 + origin),
            last: [(width - F::TAPS) as u32, rows.checked_sub(F::TAPS)? as u32],
        };
        let window = Window::new(samples, (F::TAPS - 1) * stride + F::REACH)?;
        let (fractions, stride) = (F::FRACTIONS, stride as u32);
        let plan = Plan { within, shift: F::SHIFT, fractions, channels: C, stride };
        Some(Self { window, plan, pixels: [0; 2] })
    }

    /// For those pixels of a range of a span that have all their taps here.
    fn along(self, span: &Span<2>, range: &Range<i32>) -> Self {
        let pixels = self.plan.within.interval(span, self.plan.shift, range.clone());
        Self { pixels: [pixels.start, pixels.end], ..self }
    }
}

/// A picture that rows of pixels are looked up in.
pub(super) struct BlockSampler<'a, T, const C: usize> {
    single: Sampler<'a, T, C>,
    scratch: Box<Scratch<T>>,
    /// Made when many pixels were looked up alone.
    margins: Option<Box<[Margin<T>; 4]>>,
    mended: usize,
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
        Some(Self { single, scratch, margins: None, mended: 0 })
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

    fn paint_with<F: BlockFilter<T, C>>(
        &mut self,
        filter: &F,
        positions: &Positions<'_>,
        pixels: &mut [T],
    ) {
        let view = self.single.view;
        let (samples, stride) = view.samples();
        let size = [view.width(), view.height()];
        let Some(picture) = Region::new::<F, C>(samples, stride, size, [0; 2]) else {
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
        // Out of the sampler, which is worked with meanwhile.
        let margins = self.margins.take();
        match positions {
            Positions::Each(u, v) => self.paint_each_block(filter, &picture, u, v, pixels),
            Positions::Span(span, valid) => {
                self.paint_span(filter, picture, margins.as_deref(), span, valid, pixels);
            }
        }
        self.margins = margins;
        if self.margins.is_none() && self.mended > Margin::texels(&self.single, F::TAPS) / 16 {
            self.margins = Some(Box::new(Margin::all(&self.single, F::TAPS)));
        }
    }

    fn paint_span<F: BlockFilter<T, C>>(
        &mut self,
        filter: &F,
        picture: Region<'_, T>,
        margins: Option<&[Margin<T>; 4]>,
        span: &Span<2>,
        valid: &Range<i32>,
        pixels: &mut [T],
    ) {
        // The pixels whose filters see the picture, and those of them whose filters see nothing else, or an edge's strip.
        let seen = self.single.seen(span, valid, F::TAPS);
        let picture = picture.along(span, &seen);
        let mut regions = [Some(picture), None, None, None, None];
        if picture.pixels != [seen.start, seen.end]
            && let Some(margins) = margins
        {
            let filtered = self.single.filtered(span, &seen, F::TAPS);
            for (region, margin) in regions[1..].iter_mut().zip(margins) {
                let stride = margin.size()[0] * C;
                let whole =
                    Region::new::<F, C>(margin.samples(), stride, margin.size(), margin.origin());
                *region = whole.map(|region| region.along(span, &filtered));
            }
        }
        let (before, rest) = pixels.split_at_mut((seen.start - valid.start) as usize * C);
        let (mut rest, after) = rest.split_at_mut(seen.len() * C);
        self.fill(before);
        self.fill(after);
        let mut x = seen.start;
        while x < seen.end {
            let anchor = x & !(BLOCK as i32 - 1);
            let blocks = |region: &Region<'_, T>| {
                let [start, end] = region.pixels;
                if start <= anchor { (end - x).max(0) as usize / BLOCK } else { 0 }
            };
            let region = regions.iter().flatten().find(|region| x == anchor && blocks(region) > 0);
            let Scratch { located, work, pixels: scratch } = &mut *self.scratch;
            let count = if let Some(region) = region {
                let whole = blocks(region).min(BLOCKS);
                let (pixels, after) = core::mem::take(&mut rest).split_at_mut(whole * BLOCK * C);
                located.offsets.restrict(region.window.limit());
                located.span(&region.plan, span, anchor, whole, false);
                weigh(filter, region, located, work, pixels);
                rest = after;
                whole * BLOCK
            } else {
                let from = (x - anchor) as usize;
                let count = ((seen.end - x) as usize).min(BLOCK - from);
                let (pixels, after) = core::mem::take(&mut rest).split_at_mut(count * C);
                located.offsets.restrict(picture.window.limit());
                located.span(&picture.plan, span, anchor, 1, true);
                weigh(filter, &picture, located, work, &mut scratch[..C * BLOCK]);
                self.mend(&picture.plan.within, F::TAPS, from, pixels);
                rest = after;
                count
            };
            x += count as i32;
        }
    }

    fn paint_each_block<F: BlockFilter<T, C>>(
        &mut self,
        filter: &F,
        picture: &Region<'_, T>,
        u: &[f64],
        v: &[f64],
        pixels: &mut [T],
    ) {
        let blocks = u.chunks(BLOCK).zip(v.chunks(BLOCK));
        for ((u, v), pixels) in blocks.zip(pixels.chunks_mut(BLOCK * C)) {
            let positions = [whole_block(u), whole_block(v)];
            let [u, v] = &positions;
            let Scratch { located, work, pixels: scratch } = &mut *self.scratch;
            located.offsets.restrict(picture.window.limit());
            if located.each(&picture.plan, [u, v], false) && pixels.len() == BLOCK * C {
                weigh(filter, picture, located, work, pixels);
            } else {
                located.each(&picture.plan, [u, v], true);
                weigh(filter, picture, located, work, &mut scratch[..C * BLOCK]);
                self.mend(&picture.plan.within, F::TAPS, 0, pixels);
            }
        }
    }

    /// Pixels of a block from number `from` on: from the scratch those whose taps lie within, the others one by one.
    #[inline(never)]
    fn mend(&mut self, within: &Within, taps: usize, from: usize, pixels: &mut [T]) {
        let Scratch { located, pixels: whole, .. } = &*self.scratch;
        for (i, pixel) in (from..).zip(pixels.chunks_exact_mut(C)) {
            let first = located.first(i);
            if within.holds(first) {
                pixel.copy_from_slice(&whole[i * C..(i + 1) * C]);
            } else if self.single.sees_border(first, taps as i32) {
                self.single.paint_border(pixel);
            } else {
                self.mended += 1;
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
        self.single.border.fill::<T, C>(pixels);
    }
}

/// The values of the blocks of `pixels`, whose places are found.
#[inline(never)]
fn weigh<T: Sample, F: BlockFilter<T, C>, const C: usize>(
    filter: &F,
    region: &Region<'_, T>,
    located: &Located,
    work: &mut Work,
    pixels: &mut [T],
) {
    let stride = region.plan.stride as usize;
    vectorised_by_half(
        #[inline(always)]
        || {
            for (block, pixels) in pixels.chunks_exact_mut(C * BLOCK).enumerate() {
                let Some(places) = region.window.places(&located.offsets, block) else { return };
                let taps = Taps { places, stride, fractions: located.fractions(block) };
                filter.weigh(&taps, work, pixels);
            }
        },
    );
}
