//! Rows put together from pieces, handed out in blocks.

use core::ops::Range;

use nalgebra::Point2;

use super::BlockSink;
use super::span::BLOCK;
use crate::error::ProjectionError;
use crate::numeric::float;

/// Collects neighbouring pixels of a row, whatever piece they come from, and hands them out 64 at a time.
pub(super) struct Gather<'a, 'b> {
    emit: &'a mut BlockSink<'b>,
    u: [f64; BLOCK],
    v: [f64; BLOCK],
    first: i32,
    count: usize,
}

impl<'a, 'b> Gather<'a, 'b> {
    pub(super) fn new(emit: &'a mut BlockSink<'b>) -> Self {
        Self { emit, u: [0.0; BLOCK], v: [0.0; BLOCK], first: 0, count: 0 }
    }

    /// Takes the pixels `samples`: `fill` is given the first x of some of them and the slices that their coordinates go to.
    #[inline(always)]
    pub(super) fn run(
        &mut self,
        samples: Range<i32>,
        mut fill: impl FnMut(i32, &mut [f64], &mut [f64]),
    ) {
        let mut x = samples.start;
        while x < samples.end {
            if self.count == BLOCK || self.first.wrapping_add(self.count as i32) != x {
                self.flush();
            }
            if self.count == 0 {
                self.first = x;
            }
            let left = samples.end.wrapping_sub(x) as u32 as usize;
            let end = self.count + left.min(BLOCK - self.count);
            let place = self.count..end;
            fill(x, &mut self.u[place.clone()], &mut self.v[place.clone()]);
            self.count = end;
            x += place.len() as i32;
        }
    }

    /// Hands out what is there.
    pub(super) fn flush(&mut self) {
        if self.count > 0 {
            (self.emit)(self.first, &self.u[..self.count], &self.v[..self.count]);
            self.count = 0;
        }
    }
}

/// A row by its pixels, one at a time.
pub(super) fn pointwise(
    at: impl Fn(&Point2<f64>) -> Result<Point2<f64>, ProjectionError>,
    line: i32,
    samples: Range<i32>,
    emit: &mut BlockSink<'_>,
) {
    let y = centre(line);
    let mut row = Gather::new(emit);
    for x in samples {
        if let Ok(p) = at(&Point2::new(centre(x), y)) {
            row.run(x..x + 1, |_, u, v| (u[0], v[0]) = (p.x, p.y));
        }
    }
    row.flush();
}

/// The continuous coordinate of a pixel's centre.
#[inline(always)]
pub(super) fn centre(index: i32) -> f64 {
    f64::from(index) + 0.5
}

/// The first pixel whose centre is not left of `x`, within `samples`; their end for NaN.
#[inline]
pub(super) fn first_from(x: f64, samples: &Range<i32>) -> i32 {
    let first = float::ceil(x - 0.5);
    if first.is_nan() { samples.end } else { (first as i32).clamp(samples.start, samples.end) }
}

/// The first pixel whose centre is right of `x`, within `samples`; their end for NaN.
#[inline]
pub(super) fn first_beyond(x: f64, samples: &Range<i32>) -> i32 {
    let last = float::floor(x - 0.5);
    if last.is_nan() {
        samples.end
    } else {
        (last as i32).saturating_add(1).clamp(samples.start, samples.end)
    }
}
