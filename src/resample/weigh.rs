//! What filters do with the taps of a block of pixels: stages of short loops without branches, which compilers turn into vector
//! instructions. Weights are computed, taps are loaded as words, and the words are weighed. Only the loads go one by one.

use super::image::Sample;
use super::kernel::{Kernel, bilinear, dot};
use super::taps::Places;
use crate::mapping::span::BLOCK;

/// A number for each pixel of a block.
type Each<V> = [V; BLOCK];

/// The most taps along an axis.
const MOST_TAPS: usize = 8;
/// The most words a row of taps takes: eight texels of four floats.
const MOST_WORDS: usize = 4 * MOST_TAPS;

/// Where the taps of a block are weighed.
#[repr(align(64))]
pub(super) struct Work {
    words: Words,
    /// A second row, for filters of two.
    below: Words,
    across: [Each<f32>; MOST_TAPS],
    down: [Each<f32>; MOST_TAPS],
    sums: [Each<f32>; 4],
}

impl Work {
    pub(super) const EMPTY: Self = Self {
        words: Words::EMPTY,
        below: Words::EMPTY,
        across: [[0.0; BLOCK]; MOST_TAPS],
        down: [[0.0; BLOCK]; MOST_TAPS],
        sums: [[0.0; BLOCK]; 4],
    };
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
pub(super) struct Taps<'a, T> {
    pub(super) places: Places<'a, T>,
    /// Samples from a row of taps to the next.
    pub(super) stride: usize,
    /// The fractions of the pixels' u and v.
    pub(super) fractions: [&'a Each<f32>; 2],
}

/// A filter over a block.
pub(super) trait BlockFilter<T: Sample, const C: usize> {
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

pub(super) struct Nearest;

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

pub(super) struct Bilinear;

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
pub(super) struct Separable<K, const N: usize>(pub(super) K);

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
        for (fractions, weights) in
            taps.fractions.into_iter().zip([&mut work.across, &mut work.down])
        {
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
