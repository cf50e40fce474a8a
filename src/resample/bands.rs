//! The rows of a picture to paint, band by band, on one thread or on those of the caller's pool.

use alloc::vec::Vec;
use core::ops::Range;

use super::image::{ImageViewMut, Sample};

/// Rows that are painted together.
const BAND: usize = 32;

/// Calls `paint` with what a thread works with, the number of a first row, and that row and those below it, until all rows
/// are painted.
pub(super) fn for_each_band<T: Sample, S, const C: usize>(
    target: &mut ImageViewMut<'_, T, C>,
    state: impl Fn() -> S + Sync + Send,
    paint: impl Fn(&mut S, i32, &mut [&mut [T]]) + Sync + Send,
) {
    let width = target.width() * C;
    if width == 0 {
        return;
    }
    let (samples, stride) = target.samples_mut();
    let mut bands: Vec<(i32, &mut [T])> =
        (0..).step_by(BAND).zip(samples.chunks_mut(BAND.saturating_mul(stride))).collect();
    let paint_band = |state: &mut S, (line, band): &mut (i32, &mut [T])| {
        let mut rows: Vec<&mut [T]> =
            band.chunks_mut(stride).map(|row| &mut row[..width]).collect();
        paint(state, *line, &mut rows);
    };
    #[cfg(feature = "rayon")]
    if bands.len() > 1 && rayon::current_num_threads() > 1 {
        use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};
        bands.par_iter_mut().for_each_init(state, paint_band);
        return;
    }
    let mut state = state();
    bands.iter_mut().for_each(|band| paint_band(&mut state, band));
}

/// The samples of `count` pixels from pixel `x` on that a map hands out, of a row of `len` samples of which those before `done`
/// are painted; `None` for what is not right of what came before, or beyond the row, and so no pixel of it.
pub(super) fn samples_at<const C: usize>(
    x: i32,
    count: usize,
    done: usize,
    len: usize,
) -> Option<Range<usize>> {
    let start = usize::try_from(x).ok()?.checked_mul(C)?;
    let end = start.checked_add(count.checked_mul(C)?)?;
    (start >= done && end <= len).then_some(start..end)
}
