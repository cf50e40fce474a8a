//! Samples as words: neighbouring texels of a row loaded with few instructions and taken apart in vectors.

use crate::mapping::span::BLOCK;

/// Samples that are carried four, two or one in a word.
pub trait Words: Copy {
    /// Samples in a word.
    #[doc(hidden)]
    const IN_WORD: usize;

    /// The first `IN_WORD` samples as a word; zero where there are fewer.
    #[doc(hidden)]
    fn read_word(samples: &[Self]) -> u32;

    /// Sample `k` of a word.
    #[doc(hidden)]
    fn of_word(word: u32, k: usize) -> f32;
}

impl Words for u8 {
    const IN_WORD: usize = 4;
    #[inline(always)]
    fn read_word(samples: &[Self]) -> u32 {
        samples.first_chunk().map_or(0, |s| u32::from_le_bytes(*s))
    }
    #[inline(always)]
    fn of_word(word: u32, k: usize) -> f32 {
        // By way of i32, whose conversion is an instruction everywhere.
        (word >> (8 * k) & 0xff) as i32 as f32
    }
}

impl Words for u16 {
    const IN_WORD: usize = 2;
    #[inline(always)]
    fn read_word(samples: &[Self]) -> u32 {
        samples.first_chunk().map_or(0, |[a, b]| u32::from(*a) | u32::from(*b) << 16)
    }
    #[inline(always)]
    fn of_word(word: u32, k: usize) -> f32 {
        (word >> (16 * k) & 0xffff) as i32 as f32
    }
}

impl Words for f32 {
    const IN_WORD: usize = 1;
    #[inline(always)]
    fn read_word(samples: &[Self]) -> u32 {
        samples.first().map_or(0, |s| s.to_bits())
    }
    #[inline(always)]
    fn of_word(word: u32, _: usize) -> f32 {
        Self::from_bits(word)
    }
}

/// The most words of a group: four texels of four floats.
pub(super) const MOST_WORDS: usize = 16;

/// A group of neighbouring texels for each of 64 pixels, as words.
#[repr(align(64))]
pub(super) struct Group([[u32; BLOCK]; MOST_WORDS]);

impl Group {
    pub(super) const EMPTY: Self = Self([[0; BLOCK]; MOST_WORDS]);

    /// Samples that are read from an offset on.
    pub(super) const fn reach<T: Words, const C: usize, const N: usize>() -> usize {
        (N * C).div_ceil(T::IN_WORD) * T::IN_WORD
    }

    /// Loads N texels of C channels from each offset on; zeros where they reach beyond the samples.
    #[inline(always)]
    pub(super) fn load<T: Words, const C: usize, const N: usize>(
        &mut self,
        samples: &[T],
        offsets: &[u32; BLOCK],
    ) {
        let reach = Self::reach::<T, C, N>();
        for i in 0..BLOCK {
            let start = offsets[i] as usize;
            let Some(texels) = samples.get(start..start + reach) else { continue };
            for w in 0..reach / T::IN_WORD {
                self.0[w][i] = T::read_word(&texels[w * T::IN_WORD..]);
            }
        }
    }

    /// Channel k of texel t for pixel i.
    #[inline(always)]
    pub(super) fn sample<T: Words, const C: usize>(&self, t: usize, k: usize, i: usize) -> f32 {
        let n = t * C + k;
        T::of_word(self.0[n / T::IN_WORD][i], n % T::IN_WORD)
    }
}
