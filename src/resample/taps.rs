//! Texels from memory, for 64 pixels at once.
//!
//! The one place of the module with `unsafe`: eight loads whose places the compiler cannot know cost as much as the rest of
//! a filter, and a test before each half as much again. Here the places are brought into the picture all together,
//! before they are read.
#![allow(unsafe_code, reason = "loads without a test each, from places that were clamped before")]

use core::marker::PhantomData;

use crate::mapping::span::BLOCK;

/// How the samples of a picture are carried through a filter: one, two or four in a word.
pub trait Packed: Sized {
    /// Samples in a word.
    const PER_WORD: usize;

    /// The first `PER_WORD` samples as a word; zero where there are fewer.
    #[doc(hidden)]
    fn first_word(samples: &[Self]) -> u32;

    /// The `PER_WORD` samples from `at` on.
    ///
    /// # Safety
    /// That many samples can be read there.
    #[doc(hidden)]
    unsafe fn word(at: *const Self) -> u32;

    /// The first two samples from `at` on, where a word holds four; the first one, where it holds less.
    ///
    /// # Safety
    /// That many samples can be read there.
    #[doc(hidden)]
    unsafe fn half_word(at: *const Self) -> u32;

    /// Twice `PER_WORD` samples from `at` on, the first in the lowest bits.
    ///
    /// # Safety
    /// That many samples can be read there.
    #[doc(hidden)]
    unsafe fn two_words(at: *const Self) -> u64;

    /// Sample `k` of a word.
    #[doc(hidden)]
    fn unpack(word: u32, k: usize) -> f32;

    /// A word with the sample nearest to `value` at place `k` and zeros elsewhere.
    #[doc(hidden)]
    fn pack(value: f32, k: usize) -> u32;

    /// The first samples of a word, as many as `samples` has room for.
    #[doc(hidden)]
    fn unload(word: u32, samples: &mut [Self]);

    /// The nearest sample: see [`Sample::from_f32`](super::Sample::from_f32).
    #[doc(hidden)]
    fn rounded(value: f32) -> Self;
}

/// ⌊value + ½⌋ within 0 and `most`, which is below 2³¹; 0 for NaN.
#[inline(always)]
fn rounded(value: f32, most: f32) -> i32 {
    let value = value + 0.5;
    let value = if value > 0.0 { value } else { 0.0 };
    let value = if value < most { value } else { most };
    // SAFETY: a number from 0 to `most`. The checked conversion keeps loops from becoming vectors.
    unsafe { value.to_int_unchecked() }
}

impl Packed for u8 {
    const PER_WORD: usize = 4;
    #[inline(always)]
    fn first_word(samples: &[Self]) -> u32 {
        samples.first_chunk().map_or(0, |s| u32::from_le_bytes(*s))
    }
    #[inline(always)]
    unsafe fn word(at: *const Self) -> u32 {
        // SAFETY: the caller's; an array of bytes needs no alignment.
        u32::from_le_bytes(unsafe { at.cast::<[Self; 4]>().read() })
    }
    #[inline(always)]
    unsafe fn half_word(at: *const Self) -> u32 {
        // SAFETY: the caller's; an array of bytes needs no alignment.
        u32::from(u16::from_le_bytes(unsafe { at.cast::<[Self; 2]>().read() }))
    }
    #[inline(always)]
    fn unpack(word: u32, k: usize) -> f32 {
        // By way of i32, whose conversion is an instruction everywhere.
        (word >> (8 * k) & 0xff) as i32 as f32
    }
    #[inline(always)]
    unsafe fn two_words(at: *const Self) -> u64 {
        // SAFETY: the caller's; an array of bytes needs no alignment.
        u64::from_le_bytes(unsafe { at.cast::<[Self; 8]>().read() })
    }
    #[inline(always)]
    fn pack(value: f32, k: usize) -> u32 {
        u32::from(Self::rounded(value)) << (8 * k)
    }
    #[inline(always)]
    fn unload(word: u32, samples: &mut [Self]) {
        for (sample, byte) in samples.iter_mut().zip(word.to_le_bytes()) {
            *sample = byte;
        }
    }
    #[inline(always)]
    fn rounded(value: f32) -> Self {
        rounded(value, 255.0) as Self
    }
}

impl Packed for u16 {
    const PER_WORD: usize = 2;
    #[inline(always)]
    fn first_word(samples: &[Self]) -> u32 {
        samples.first_chunk().map_or(0, |[a, b]| u32::from(*a) | u32::from(*b) << 16)
    }
    #[inline(always)]
    unsafe fn word(at: *const Self) -> u32 {
        // SAFETY: the caller's; a slice of such samples is aligned.
        let [a, b] = unsafe { at.cast::<[Self; 2]>().read() };
        u32::from(a) | u32::from(b) << 16
    }
    #[inline(always)]
    unsafe fn half_word(at: *const Self) -> u32 {
        // SAFETY: the caller's.
        u32::from(unsafe { at.read() })
    }
    #[inline(always)]
    fn unpack(word: u32, k: usize) -> f32 {
        (word >> (16 * k) & 0xffff) as i32 as f32
    }
    #[inline(always)]
    unsafe fn two_words(at: *const Self) -> u64 {
        // SAFETY: the caller's; a slice of such samples is aligned.
        let [a, b, c, d] = unsafe { at.cast::<[Self; 4]>().read() }.map(u64::from);
        a | b << 16 | c << 32 | d << 48
    }
    #[inline(always)]
    fn pack(value: f32, k: usize) -> u32 {
        u32::from(Self::rounded(value)) << (16 * k)
    }
    #[inline(always)]
    fn unload(word: u32, samples: &mut [Self]) {
        for (sample, half) in samples.iter_mut().zip([word as Self, (word >> 16) as Self]) {
            *sample = half;
        }
    }
    #[inline(always)]
    fn rounded(value: f32) -> Self {
        rounded(value, 65_535.0) as Self
    }
}

impl Packed for f32 {
    const PER_WORD: usize = 1;
    #[inline(always)]
    fn first_word(samples: &[Self]) -> u32 {
        samples.first().map_or(0, |s| s.to_bits())
    }
    #[inline(always)]
    unsafe fn word(at: *const Self) -> u32 {
        // SAFETY: the caller's.
        unsafe { at.read() }.to_bits()
    }
    #[inline(always)]
    unsafe fn half_word(at: *const Self) -> u32 {
        // SAFETY: the caller's.
        unsafe { Self::word(at) }
    }
    #[inline(always)]
    fn unpack(word: u32, _: usize) -> f32 {
        Self::from_bits(word)
    }
    #[inline(always)]
    unsafe fn two_words(at: *const Self) -> u64 {
        // SAFETY: the caller's; a slice of such samples is aligned.
        let [a, b] = unsafe { at.cast::<[Self; 2]>().read() }.map(Self::to_bits);
        u64::from(a) | u64::from(b) << 32
    }
    #[inline(always)]
    fn pack(value: f32, _: usize) -> u32 {
        value.to_bits()
    }
    #[inline(always)]
    fn unload(word: u32, samples: &mut [Self]) {
        if let Some(sample) = samples.first_mut() {
            *sample = Self::from_bits(word);
        }
    }
    #[inline(always)]
    fn rounded(value: f32) -> Self {
        value
    }
}

/// Blocks of 64 pixels whose places are found at once.
pub(super) const BLOCKS: usize = 8;

/// How many samples the first taps of the pixels of some blocks lie behind a window's first one.
///
/// *Invariant.* None is more than the limit.
#[repr(align(64))]
pub(super) struct Offsets {
    offsets: [[u32; BLOCK]; BLOCKS],
    limit: u32,
}

impl Offsets {
    /// All zero.
    pub(super) fn new(limit: u32) -> Self {
        Self { offsets: [[0; BLOCK]; BLOCKS], limit }
    }

    /// Makes `limit` the limit.
    #[inline(always)]
    pub(super) fn restrict(&mut self, limit: u32) {
        if self.limit != limit {
            *self = Self::new(limit);
        }
    }

    /// Makes room for the places of a block's pixels in a picture of `stride` samples a row.
    #[inline(always)]
    pub(super) fn block(&mut self, block: usize, stride: u32) -> OffsetsMut<'_> {
        OffsetsMut { limit: self.limit, stride, offsets: &mut self.offsets[block] }
    }
}

/// Offsets to write. The limit stands beside them, so that no compiler thinks that it changes with them.
pub(super) struct OffsetsMut<'a> {
    offsets: &'a mut [u32; BLOCK],
    limit: u32,
    stride: u32,
}

impl OffsetsMut<'_> {
    /// Takes the places of some pixels from number `start` on by column and row of their first taps, in a picture of C
    /// channels; the limit for what is more.
    #[inline(always)]
    pub(super) fn set<const L: usize, const C: usize>(
        &mut self,
        start: usize,
        [x, y]: &[[u32; L]; 2],
    ) {
        let mut offsets = [0; L];
        for i in 0..L {
            offsets[i] = x[i].wrapping_mul(C as u32).wrapping_add(y[i].wrapping_mul(self.stride));
        }
        let to = &mut self.offsets[start..start + L];
        for i in 0..L {
            to[i] = offsets[i].min(self.limit);
        }
    }
}

#[cfg(all(feature = "simd", target_arch = "x86_64"))]
impl OffsetsMut<'_> {
    /// As [`set`](Self::set), of sixteen pixels.
    #[inline(always)]
    pub(super) fn set_wide<S: fearless_simd::Simd, const C: usize>(
        &mut self,
        start: usize,
        [x, y]: [fearless_simd::u32x16<S>; 2],
    ) {
        use fearless_simd::SimdBase;
        let offsets = (x * C as u32 + y * self.stride).min(self.limit);
        offsets.store_slice(&mut self.offsets[start..start + 16]);
    }
}

/// The places of 64 pixels' first taps among the samples of a picture, each with `reach` samples from there on.
///
/// *Invariant.* offset + reach ≤ samples, by those of [`Window`] and [`Offsets`]. Both hold for any numbers, so a wrong place
/// reads a wrong texel and never beyond the picture.
pub(super) struct Places<'a, T> {
    window: Window<'a, T>,
    offsets: &'a [u32; BLOCK],
}

/// A picture's samples, of which `reach` are read from each place on.
///
/// *Invariant.* limit + reach ≤ samples.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, T> {
    samples: &'a [T],
    reach: usize,
    limit: u32,
}

impl<'a, T: Packed> Window<'a, T> {
    /// `None` if there are fewer than `reach` samples.
    #[inline(always)]
    pub(super) fn new(samples: &'a [T], reach: usize) -> Option<Self> {
        let limit = u32::try_from(samples.len().checked_sub(reach)?).unwrap_or(u32::MAX);
        Some(Self { samples, reach, limit })
    }

    /// The largest offset of a place.
    #[inline(always)]
    pub(super) fn limit(&self) -> u32 {
        self.limit
    }

    /// The places at the offsets of a block; `None` if their limit is larger than the window's.
    #[inline(always)]
    pub(super) fn places(self, offsets: &'a Offsets, block: usize) -> Option<Places<'a, T>> {
        let limited = offsets.limit <= self.limit;
        limited.then(|| Places { window: self, offsets: &offsets.offsets[block] })
    }
}

impl<T: Packed> Places<'_, T> {
    /// The pointer `skip` samples behind the base, if `count` samples from there on are within reach.
    #[inline(always)]
    fn start(&self, skip: usize, count: usize) -> Option<*const T> {
        // SAFETY: skip ≤ reach ≤ samples.
        (skip.checked_add(count)? <= self.window.reach)
            .then(|| unsafe { self.window.samples.as_ptr().add(skip) })
    }

    /// The word `skip` samples behind each place; nothing beyond reach.
    #[inline(always)]
    pub(super) fn words(&self, skip: usize, words: &mut [u32; BLOCK]) {
        let Some(start) = self.start(skip, T::PER_WORD) else { return };
        for (word, offset) in words.iter_mut().zip(self.offsets) {
            // SAFETY: by the invariant, and as skip + PER_WORD ≤ reach.
            *word = unsafe { T::word(start.add(*offset as usize)) };
        }
    }

    /// The words `skip` and `skip + step` samples behind each place, step at most `PER_WORD`; nothing beyond reach.
    #[inline(always)]
    pub(super) fn pairs(&self, skip: usize, step: usize, pairs: &mut [[u32; 2]; BLOCK]) {
        let Some(start) = self.start(skip, 2 * T::PER_WORD) else { return };
        let shift = step * (32 / T::PER_WORD);
        for (pair, offset) in pairs.iter_mut().zip(self.offsets) {
            // SAFETY: by the invariant, and as skip + 2 PER_WORD ≤ reach.
            let both = unsafe { T::two_words(start.add(*offset as usize)) };
            *pair = [both as u32, (both >> shift) as u32];
        }
    }

    /// The half words `skip` and `skip + below` samples behind each place, the second in the upper half; nothing beyond reach.
    #[inline(always)]
    pub(super) fn halves(&self, skip: usize, below: usize, words: &mut [u32; BLOCK]) {
        let half = T::PER_WORD.div_ceil(2);
        let (Some(upper), Some(lower)) =
            (self.start(skip, half), self.start(skip.saturating_add(below), half))
        else {
            return;
        };
        for (word, offset) in words.iter_mut().zip(self.offsets) {
            let offset = *offset as usize;
            // SAFETY: by the invariant, and as both skips + half ≤ reach.
            *word =
                unsafe { T::half_word(upper.add(offset)) | T::half_word(lower.add(offset)) << 16 };
        }
    }

    /// Squares of N × N texels of C samples, rows of them `stride` samples apart, of each of which L samples are read; `None` if
    /// they reach too far.
    #[inline(always)]
    pub(super) fn squares<const N: usize, const C: usize, const L: usize>(
        &self,
        stride: usize,
    ) -> Option<Squares<'_, T, N, C, L>> {
        let last = stride.checked_mul(N - 1)?.checked_add((N - 1) * C)?;
        self.start(last, L)?;
        Some(Squares {
            start: self.start(0, L)?,
            offsets: self.offsets,
            stride,
            texels: PhantomData,
        })
    }

    /// The pixel of `C` samples at each place, to neighbouring pixels.
    #[inline(always)]
    pub(super) fn copy<const C: usize>(&self, pixels: &mut [T])
    where
        T: Copy,
    {
        let Some(start) = self.start(0, C) else { return };
        let (pixels, _) = pixels.as_chunks_mut::<C>();
        let Some(pixels) = pixels.first_chunk_mut::<BLOCK>() else { return };
        for i in 0..BLOCK {
            // SAFETY: by the invariant, and as C ≤ reach.
            pixels[i] = unsafe { start.add(self.offsets[i] as usize).cast::<[T; C]>().read() };
        }
    }
}

/// The squares of texels at the places of 64 pixels.
///
/// *Invariant.* As that of [`Places`], where (N − 1) (stride + C) + L ≤ reach.
pub(super) struct Squares<'a, T, const N: usize, const C: usize, const L: usize> {
    start: *const T,
    offsets: &'a [u32; BLOCK],
    stride: usize,
    texels: PhantomData<&'a [T]>,
}

impl<T: Copy + Default, const N: usize, const C: usize, const L: usize> Squares<'_, T, N, C, L> {
    /// The first L samples of the texels of row `y` of pixel i's square.
    #[inline(always)]
    pub(super) fn row(&self, i: usize, y: usize) -> [[T; L]; N] {
        let mut texels = [[T::default(); L]; N];
        if y < N {
            let offset = self.offsets[i] as usize + y * self.stride;
            for x in 0..N {
                // SAFETY: by the invariant; an array is as aligned as its samples.
                texels[x] = unsafe { self.start.add(offset + x * C).cast::<[T; L]>().read() };
            }
        }
        texels
    }
}
