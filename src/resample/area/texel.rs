//! Neighbouring texels of a row, loaded with few instructions and taken apart in vectors.

use crate::mapping::span::BLOCK;
use crate::resample::taps::Packed;

/// The most words of a group: four texels of four floats.
pub(super) const MOST_WORDS: usize = 16;

/// A group of neighbouring texels for each of 64 pixels, as words.
#[repr(align(64))]
pub(super) struct Group([[u32; BLOCK]; MOST_WORDS]);

impl Group {
    pub(super) const EMPTY: Self = Self([[0; BLOCK]; MOST_WORDS]);

    /// Samples that are read from an offset on.
    pub(super) const fn reach<T: Packed, const C: usize, const N: usize>() -> usize {
        (N * C).div_ceil(T::PER_WORD) * T::PER_WORD
    }

    /// Loads N texels of C channels from each offset on; zeros where they reach beyond the samples.
    #[inline(always)]
    pub(super) fn load<T: Packed, const C: usize, const N: usize>(
        &mut self,
        samples: &[T],
        offsets: &[u32; BLOCK],
    ) {
        let reach = Self::reach::<T, C, N>();
        for i in 0..BLOCK {
            let start = offsets[i] as usize;
            let Some(texels) = samples.get(start..start + reach) else { continue };
            for w in 0..reach / T::PER_WORD {
                self.0[w][i] = T::first_word(&texels[w * T::PER_WORD..]);
            }
        }
    }

    /// Channel k of texel t for pixel i.
    #[inline(always)]
    pub(super) fn sample<T: Packed, const C: usize>(&self, t: usize, k: usize, i: usize) -> f32 {
        let n = t * C + k;
        T::unpack(self.0[n / T::PER_WORD][i], n % T::PER_WORD)
    }
}
