//! Work on the parts of a problem, on one thread or on those of the caller's pool.
//!
//! Parts are cut by the problem's size alone, and what they sum is added in their order: the numbers are the same on any
//! number of threads.

use alloc::vec::Vec;
use core::ops::Range;

/// Calls `work` for each part with its number.
#[cfg(not(feature = "rayon"))]
pub(super) fn for_each<T: Send>(parts: &mut [T], work: impl Fn(usize, &mut T) + Sync + Send) {
    for (i, part) in parts.iter_mut().enumerate() {
        work(i, part);
    }
}

/// Calls `work` for each part with its number.
#[cfg(feature = "rayon")]
pub(super) fn for_each<T: Send>(parts: &mut [T], work: impl Fn(usize, &mut T) + Sync + Send) {
    use rayon::prelude::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
    if parts.len() < 2 || rayon::current_num_threads() < 2 {
        for (i, part) in parts.iter_mut().enumerate() {
            work(i, part);
        }
        return;
    }
    parts.par_iter_mut().enumerate().with_max_len(1).for_each(|(i, part)| work(i, part));
}

/// So many short tasks, as of a point each, make a part.
pub(super) const MANY: usize = 2048;
/// No more parts than this, so that their sums take little memory.
const MOST_PARTS: usize = 32;
/// A part with fewer observations is not worth a thread.
const SMALLEST_PART: usize = 512;

/// Ranges of points of about equal numbers of observations, from where the observations of each begin.
pub(super) fn parts(first: &[usize]) -> Vec<Range<usize>> {
    let points = first.len().saturating_sub(1);
    let observations = first.last().copied().unwrap_or(0);
    let wanted = (observations / MOST_PARTS).max(SMALLEST_PART);
    let mut ranges = Vec::with_capacity(MOST_PARTS + 1);
    let mut begin = 0;
    for end in 1..=points {
        if first[end] - first[begin] >= wanted || end == points {
            ranges.push(begin..end);
            begin = end;
        }
    }
    ranges
}

/// The first elements of a slice, which is left with the rest.
pub(super) fn take<'a, T>(slice: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let all = core::mem::take(slice);
    let (head, rest) = all.split_at_mut(count.min(all.len()));
    *slice = rest;
    head
}
