//! Rows painted pixel by pixel.

use super::lookup::Footprint;
use super::warp::{AreaSource, Paint};
use crate::mapping::FootprintBlock;
use crate::resample::border::Border;
use crate::resample::image::Sample;
use nalgebra::{Matrix2, Point2};

/// A source whose rows are lookups one by one.
pub(super) struct OneByOne<'a, S, F, const C: usize> {
    pub(super) source: &'a S,
    pub(super) filter: F,
    pub(super) border: Border,
}

impl<T: Sample, S: AreaSource<T, C>, const C: usize> Paint<T> for OneByOne<'_, S, S::Filter, C> {
    fn paint(&mut self, block: &FootprintBlock<'_>, pixels: &mut [T]) {
        let Self { source, filter, border } = *self;
        for (i, pixel) in pixels.chunks_exact_mut(C).enumerate().take(block.u.len()) {
            let [us, vs] = block.by_sample.map(|d| d[i]);
            let [ul, vl] = block.by_line.map(|d| d[i]);
            let footprint = Footprint {
                position: Point2::new(block.u[i], block.v[i]),
                jacobian: Matrix2::new(us, ul, vs, vl),
            };
            match source.area(&footprint, filter, border) {
                Some(value) => pixel.copy_from_slice(&value),
                None => self.fill(pixel),
            }
        }
    }

    fn fill(&self, pixels: &mut [T]) {
        self.border.fill::<T, C>(pixels);
    }
}
