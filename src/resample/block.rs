//! Filters over 64 neighbouring pixels at once.
//!
//! A block goes through four stages, each a loop without branches that compilers turn into vector instructions: positions are
//! split into texels and fractions, weights are computed, taps are loaded as words, and the words are weighed. Only the loads
//! go one by one. Pixels whose taps are not all within the picture are looked up alone.

use alloc::boxed::Box;
use core::ops::Range;

use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, Sample};
use super::kernel::{Kernel, bilinear, dot};
use super::position::{LARGEST, Split, Within};
use super::sampler::{Prepared, Sampler};
use super::taps::{Offsets, Places, Window};
use crate::mapping::span::{BLOCK, LANES, Span};
use crate::numeric::vectorised;

/// A number for each pixel of a block.
type Each<V> = [V; BLOCK];

/// The most taps along an axis.
const MOST_TAPS: usize = 8;
/// The most words a row of taps takes: eight texels of four floats.
const MOST_WORDS: usize = 4 * MOST_TAPS;

/// Where a block works; kept from block to block. Vectors that cross cache lines would be slow to read back.
#[repr(align(64))]
struct Scratch<T> {
    split: Split,
    offsets: Offsets,
    work: Work,
    /// A block's pixels of up to four channels.
    pixels: [T; 4 * BLOCK],
}

/// Where the taps of a block are weighed.
#[repr(align(64))]
struct Work {
    words: Words,
    /// A second row, for filters of two.
    below: Words,
    across: [Each<f32>; MOST_TAPS],
    down: [Each<f32>; MOST_TAPS],
    sums: [Each<f32>; 4],
}

/// A row of taps a pixel: words two by two, and the last one where their number is odd.
#[repr(align(64))]
struct Words {
    pairs: [Each<[u32; 2]>; MOST_WORDS / 2],
    last: Each<u32>,
}

impl Words {
    const EMPTY: Self = Self { pairs: [[[0; 2]; BLOCK]; MOST_WORDS / 2], last: [0; BLOCK] };
}

/// The taps of a block.
struct Taps<'a, T> {
    places: Places<'a, T>,
    /// Samples from a row of taps to the next.
    stride: usize,
    /// The fractions of the pixels' u and v.
    fractions: &'a [Each<f32>; 2],
}

/// A filter over a block.
trait BlockFilter<T: Sample, const C: usize> {
    /// Texels along an axis.
    const TAPS: usize;
    /// What is taken off a position before it is split.
    const SHIFT: f64;
    /// Samples that are read from the first tap of a row on.
    const REACH: usize;
    /// Whether it reads fractions.
    const FRACTIONS: bool = true;

    /// The values of 64 pixels from their taps and the fractions of their positions.
    fn weigh(&self, taps: &Taps<'_, T>, work: &mut Work, pixels: &mut [T]);
}

/// How the samples of a row of N texels lie in words.
struct Layout<T, const C: usize, const N: usize>(core::marker::PhantomData<T>);

impl<T: Sample, const C: usize, const N: usize> Layout<T, C, N> {
    /// Whether the channels of a pixel are worked on side by side, and not those of neighbouring pixels: floats are
    /// vectors as they stand in memory.
    const SIDE_BY_SIDE: bool = T::PER_WORD == 1 && C > 1;
    /// How many they are then; the fourth of three belongs to the next texel.
    const CHANNELS: usize = if C == 2 { 2 } else { 4 };
    /// Texels in a word; 0 where a texel takes several.
    const TEXELS: usize = T::PER_WORD / C;
    /// Words a texel.
    const WORDS_A_TEXEL: usize = C.div_ceil(T::PER_WORD);
    /// Words a row.
    const WORDS: usize =
        if Self::TEXELS > 0 { N.div_ceil(Self::TEXELS) } else { N * Self::WORDS_A_TEXEL };
    /// Samples that are read of a row; a little beyond its texels where they do not fill the words.
    const REACH: usize = if Self::SIDE_BY_SIDE {
        (N - 1) * C + Self::CHANNELS
    } else if Self::WORDS % 2 == 0 {
        Self::skip(Self::WORDS - 2) + 2 * T::PER_WORD
    } else {
        Self::skip(Self::WORDS - 1) + T::PER_WORD
    };

    /// Samples before a word.
    const fn skip(word: usize) -> usize {
        if Self::TEXELS > 0 {
            word * Self::TEXELS * C
        } else {
            word / Self::WORDS_A_TEXEL * C + word % Self::WORDS_A_TEXEL * T::PER_WORD
        }
    }

    /// The words of the row `down` samples below the first taps.
    #[inline(always)]
    fn load(places: &Places<'_, T>, down: usize, words: &mut Words) {
        for pair in 0..Self::WORDS / 2 {
            let skip = Self::skip(2 * pair);
            places.pairs(down + skip, Self::skip(2 * pair + 1) - skip, &mut words.pairs[pair]);
        }
        if Self::WORDS % 2 == 1 {
            places.words(down + Self::skip(Self::WORDS - 1), &mut words.last);
        }
    }

    /// The sample of a texel and a channel among the words.
    #[inline(always)]
    fn sample(words: &Words, texel: usize, channel: usize, pixel: usize) -> f32 {
        let (word, k) = match texel.checked_div(Self::TEXELS) {
            Some(word) => (word, texel % Self::TEXELS * C + channel),
            None => (texel * Self::WORDS_A_TEXEL + channel / T::PER_WORD, channel % T::PER_WORD),
        };
        let word = if word + 1 == Self::WORDS && Self::WORDS % 2 == 1 {
            words.last[pixel]
        } else {
            words.pairs[word / 2][pixel][word % 2]
        };
        T::unpack(word, k)
    }
}

struct Nearest;

impl<T: Sample, const C: usize> BlockFilter<T, C> for Nearest {
    const TAPS: usize = 1;
    const SHIFT: f64 = 0.0;
    const REACH: usize = C;
    const FRACTIONS: bool = false;

    #[inline(always)]
    fn weigh(&self, taps: &Taps<'_, T>, _: &mut Work, pixels: &mut [T]) {
        taps.places.copy::<C>(pixels);
    }
}

struct Bilinear;

impl Bilinear {
    /// Whether a word holds all four taps.
    const fn in_a_word<T: Sample, const C: usize>() -> bool {
        C == 1 && T::PER_WORD == 4
    }

    #[inline(always)]
    fn side_by_side<T: Sample, const C: usize, const L: usize>(
        taps: &Taps<'_, T>,
        pixels: &mut [T],
    ) {
        let Some(squares) = taps.places.squares::<2, C, L>(taps.stride) else { return };
        let Some(pixels) = pixels.as_chunks_mut::<C>().0.first_chunk_mut::<BLOCK>() else { return };
        let [fu, fv] = taps.fractions;
        for i in 0..BLOCK {
            let ([a, b], [c, d]) = (squares.row(i, 0), squares.row(i, 1));
            let mut value = [0.0; L];
            for k in 0..L {
                let taps = [a[k].to_f32(), b[k].to_f32(), c[k].to_f32(), d[k].to_f32()];
                value[k] = bilinear(taps, fu[i], fv[i]);
            }
            pixels[i] = rounded(&value);
        }
    }
}

/// The samples of C channels of L.
#[inline(always)]
fn rounded<T: Sample, const C: usize, const L: usize>(value: &[f32; L]) -> [T; C] {
    let mut pixel = [T::default(); C];
    for k in 0..C.min(L) {
        pixel[k] = T::from_f32(value[k]);
    }
    pixel
}

impl<T: Sample, const C: usize> BlockFilter<T, C> for Bilinear {
    const TAPS: usize = 2;
    const SHIFT: f64 = 0.5;
    const REACH: usize = if Self::in_a_word::<T, C>() { 2 } else { Layout::<T, C, 2>::REACH };

    #[inline(always)]
    fn weigh(&self, taps: &Taps<'_, T>, work: &mut Work, pixels: &mut [T]) {
        let Taps { places, stride, fractions: [fu, fv] } = taps;
        let Work { words: upper, below: lower, .. } = work;
        if Self::in_a_word::<T, C>() {
            let words = &mut upper.last;
            places.halves(0, *stride, words);
            let Some(pixels) = pixels.first_chunk_mut::<BLOCK>() else { return };
            for i in 0..BLOCK {
                let taps = [0, 1, 2, 3].map(|k| T::unpack(words[i], k));
                pixels[i] = T::from_f32(bilinear(taps, fu[i], fv[i]));
            }
            return;
        }
        if Layout::<T, C, 2>::SIDE_BY_SIDE {
            match C {
                2 => Self::side_by_side::<T, C, 2>(taps, pixels),
                _ => Self::side_by_side::<T, C, 4>(taps, pixels),
            }
            return;
        }
        Layout::<T, C, 2>::load(places, 0, upper);
        Layout::<T, C, 2>::load(places, *stride, lower);
        for (k, values) in work.sums.iter_mut().enumerate().take(C) {
            for i in 0..BLOCK {
                let tap = |words, texel| Layout::<T, C, 2>::sample(words, texel, k, i);
                let taps = [tap(upper, 0), tap(upper, 1), tap(lower, 0), tap(lower, 1)];
                values[i] = bilinear(taps, fu[i], fv[i]);
            }
        }
        store::<T, C>(work, pixels);
    }
}

/// A separable filter of N taps along an axis.
struct Separable<K, const N: usize>(K);

impl<K, const N: usize> Separable<K, N> {
    #[inline(always)]
    fn side_by_side<T: Sample, const C: usize, const L: usize>(
        taps: &Taps<'_, T>,
        work: &Work,
        pixels: &mut [T],
    ) {
        let Some(squares) = taps.places.squares::<N, C, L>(taps.stride) else { return };
        let Some(pixels) = pixels.as_chunks_mut::<C>().0.first_chunk_mut::<BLOCK>() else { return };
        for i in 0..BLOCK {
            let mut sums = [0.0; L];
            for y in 0..N {
                let texels = squares.row(i, y);
                let mut of_row = [0.0; L];
                for x in 0..N {
                    for k in 0..L {
                        let product = work.across[x][i] * texels[x][k].to_f32();
                        of_row[k] = if x == 0 { product } else { of_row[k] + product };
                    }
                }
                for k in 0..L {
                    let product = work.down[y][i] * of_row[k];
                    sums[k] = if y == 0 { product } else { sums[k] + product };
                }
            }
            pixels[i] = rounded(&sums);
        }
    }
}

impl<T: Sample, const C: usize, K: Kernel<N>, const N: usize> BlockFilter<T, C>
    for Separable<K, N>
{
    const TAPS: usize = N;
    const SHIFT: f64 = 0.5;
    const REACH: usize = Layout::<T, C, N>::REACH;

    #[inline(always)]
    fn weigh(&self, taps: &Taps<'_, T>, work: &mut Work, pixels: &mut [T]) {
        for (fractions, weights) in taps.fractions.iter().zip([&mut work.across, &mut work.down]) {
            for i in 0..BLOCK {
                let of_pixel = self.0.weights(fractions[i]);
                for k in 0..N {
                    weights[k][i] = of_pixel[k];
                }
            }
        }
        if Layout::<T, C, N>::SIDE_BY_SIDE {
            match C {
                2 => Self::side_by_side::<T, C, 2>(taps, work, pixels),
                _ => Self::side_by_side::<T, C, 4>(taps, work, pixels),
            }
            return;
        }
        for y in 0..N {
            Layout::<T, C, N>::load(&taps.places, y * taps.stride, &mut work.words);
            for (k, sums) in work.sums.iter_mut().enumerate().take(C) {
                for i in 0..BLOCK {
                    let weights = core::array::from_fn(|x| work.across[x][i]);
                    let taps =
                        core::array::from_fn(|x| Layout::<T, C, N>::sample(&work.words, x, k, i));
                    let of_row = work.down[y][i] * dot::<N>(&weights, &taps);
                    sums[i] = if y == 0 { of_row } else { sums[i] + of_row };
                }
            }
        }
        store::<T, C>(work, pixels);
    }
}

/// The sums of the channels to interleaved samples.
#[inline(always)]
fn store<T: Sample, const C: usize>(work: &mut Work, pixels: &mut [T]) {
    let (pixels, _) = pixels.as_chunks_mut::<C>();
    let Some(pixels) = pixels.first_chunk_mut::<BLOCK>() else { return };
    if C == 1 || C > T::PER_WORD {
        for i in 0..BLOCK {
            for k in 0..C {
                pixels[i][k] = T::from_f32(work.sums[k][i]);
            }
        }
        return;
    }
    // Pixels of several samples are put together as words, and leave as such.
    let words = &mut work.words.last;
    for i in 0..BLOCK {
        let mut word = 0;
        for k in 0..C {
            word |= T::pack(work.sums[k][i], k);
        }
        words[i] = word;
    }
    for i in 0..BLOCK {
        T::unload(words[i], &mut pixels[i]);
    }
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
    within: Within,
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
            split: Split::new(),
            offsets: Offsets::new(0),
            work: Work {
                words: Words::EMPTY,
                below: Words::EMPTY,
                across: [[0.0; BLOCK]; MOST_TAPS],
                down: [[0.0; BLOCK]; MOST_TAPS],
                sums: [[0.0; BLOCK]; 4],
            },
            pixels: [T::default(); 4 * BLOCK],
        });
        Some(Self { single, scratch })
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
        self.scratch.offsets.restrict(window.limit());
        let context = Context { filter, window, within };
        vectorised(
            #[inline(always)]
            || self.paint_blocks(&context, positions, pixels),
        );
    }

    #[inline(always)]
    fn paint_blocks<F: BlockFilter<T, C>>(
        &mut self,
        context: &Context<'_, T, F>,
        positions: &Positions<'_>,
        pixels: &mut [T],
    ) {
        let within = &context.within;
        // The first pixel's x, those whose filters see the picture, and those of them whose filters see nothing else.
        let (first, seen, inside) = match positions {
            Positions::Each(u, v) => (0, 0..u.len().min(v.len()) as i32, 0..0),
            Positions::Span(span, valid) => {
                let seen = self.single.seen(span, valid, F::TAPS);
                let inside = within.interval(span, F::SHIFT, seen.clone());
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
            let from = (x - anchor) as usize;
            let count = ((seen.end - x) as usize).min(BLOCK - from);
            let (pixels, after) = core::mem::take(&mut rest).split_at_mut(count * C);
            let straight = match positions {
                Positions::Each(u, v) => {
                    let (u, v) = (part(u, x), part(v, x));
                    let straight = self.split_each::<F>(within, [&u, &v], false) && count == BLOCK;
                    if !straight {
                        self.split_each::<F>(within, [&u, &v], true);
                    }
                    straight
                }
                Positions::Span(span, _) => {
                    let straight = inside.start <= anchor && x + BLOCK as i32 <= inside.end;
                    self.split_span::<F>(within, span, anchor, !straight);
                    straight
                }
            };
            self.weigh(context, straight, pixels);
            if !straight {
                self.mend(within, F::TAPS, from, pixels);
            }
            rest = after;
            x += count as i32;
        }
    }

    /// Splits 64 positions, keeps them if `keep` says so, and says whether the taps of all lie within.
    #[inline(always)]
    fn split_each<F: BlockFilter<T, C>>(
        &mut self,
        within: &Within,
        positions: [&Each<f64>; 2],
        keep: bool,
    ) -> bool {
        let stride = self.single.view.samples().1 as u32;
        let Scratch { split, offsets, .. } = &mut *self.scratch;
        let first @ [x, y] = split.set(0, positions, F::SHIFT, within, [F::FRACTIONS, keep]);
        offsets.places(stride).set::<BLOCK, C>(0, &first);
        let [last_x, last_y] = within.last;
        let mut beyond = 0;
        for i in 0..BLOCK {
            // Zero where x and y are at most the last.
            beyond |= (x[i].max(last_x) ^ last_x) | (y[i].max(last_y) ^ last_y);
        }
        beyond == 0
    }

    /// Splits the positions of a span's block, and keeps them if `keep` says so.
    #[inline(always)]
    fn split_span<F: BlockFilter<T, C>>(
        &mut self,
        within: &Within,
        span: &Span<2>,
        anchor: i32,
        keep: bool,
    ) {
        let stride = self.single.view.samples().1 as u32;
        let Scratch { split, offsets, .. } = &mut *self.scratch;
        // By value, so that no compiler thinks that they change with what is written.
        let (within, span, mut offsets) = (*within, *span, offsets.places(stride));
        span.walk_block(
            anchor,
            #[inline(always)]
            move |start, [u, v]| {
                let first = split.set(start, [&u, &v], F::SHIFT, &within, [F::FRACTIONS, keep]);
                offsets.set::<LANES, C>(start, &first);
            },
        );
    }

    /// The values of the block that is split: straight to its pixels, or to the scratch.
    #[inline(always)]
    fn weigh<F: BlockFilter<T, C>>(
        &mut self,
        context: &Context<'_, T, F>,
        straight: bool,
        pixels: &mut [T],
    ) {
        let (_, stride) = self.single.view.samples();
        let Scratch { split, offsets, work, pixels: whole } = &mut *self.scratch;
        let Some(places) = context.window.places(offsets) else { return };
        let values = if straight { pixels } else { &mut whole[..C * BLOCK] };
        let taps = Taps { places, stride, fractions: &split.fractions };
        context.filter.weigh(&taps, work, values);
    }

    /// Pixels of a block from number `from` on: from the scratch those whose taps lie within, the others one by one.
    #[inline(never)]
    fn mend(
        &self,
        within: &Within,
        taps: usize,
        from: usize,
        pixels: &mut [T],
    ) {
        let Scratch { split, pixels: whole, .. } = &*self.scratch;
        for (i, pixel) in (from..).zip(pixels.chunks_exact_mut(C)) {
            let first = split.first(i);
            if within.holds(first) {
                pixel.copy_from_slice(&whole[i * C..(i + 1) * C]);
            } else if self.single.sees_border(first, taps as i32) {
                self.single.paint_border(pixel);
            } else {
                let [u, v] = split.position(i);
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

/// The 64 positions from number `x` on, where those beyond the end repeat the last one.
#[inline(always)]
fn part(all: &[f64], x: i32) -> Each<f64> {
    let all = all.get(x as usize..).unwrap_or_default();
    if let Some(part) = all.first_chunk() {
        return *part;
    }
    let mut part = [all.last().copied().unwrap_or_default(); BLOCK];
    part[..all.len()].copy_from_slice(all);
    part
}
