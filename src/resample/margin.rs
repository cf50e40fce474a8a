//! The edges of a picture with what its border says beside them, as pictures of their own.
//!
//! A row that runs along an edge would be looked up pixel by pixel. In a strip along the edge, filled up with the border's
//! texels, it is a row like others.

use alloc::vec::Vec;
use core::ops::Range;

use super::image::Sample;
use super::sampler::Sampler;

/// Texels beyond the taps of a filter on either side of an edge: rows lie well within a strip or within the picture.
const SPARE: i32 = 3;

/// A strip along an edge.
pub(super) struct Margin<T> {
    samples: Vec<T>,
    /// The picture's column and row of its first texel.
    origin: [i32; 2],
    size: [usize; 2],
}

impl<T: Sample> Margin<T> {
    /// The strips along the four edges, for a filter of `taps` texels along an axis; they overlap at the corners.
    pub(super) fn all<const C: usize>(picture: &Sampler<'_, T, C>, taps: usize) -> [Self; 4] {
        let around = taps as i32 + SPARE;
        let [w, h] = picture.size;
        let (across, down) = (-around..w + around, -around..h + around);
        [
            Self::new(picture, across.clone(), -around..around),
            Self::new(picture, across, h - around..h + around),
            Self::new(picture, -around..around, down.clone()),
            Self::new(picture, w - around..w + around, down),
        ]
    }

    /// How many texels all strips have together.
    pub(super) fn texels<const C: usize>(picture: &Sampler<'_, T, C>, taps: usize) -> usize {
        let around = taps + SPARE as usize;
        4 * around * picture.size.map(|n| n as usize + 2 * around).iter().sum::<usize>()
    }

    fn new<const C: usize>(
        picture: &Sampler<'_, T, C>,
        columns: Range<i32>,
        rows: Range<i32>,
    ) -> Self {
        let (origin, size) = ([columns.start, rows.start], [columns.len(), rows.len()]);
        let mut samples = Vec::with_capacity(size[0] * size[1] * C);
        let [w, h] = picture.size;
        let inner = columns.start.clamp(0, w)..columns.end.clamp(0, w);
        for y in rows {
            samples.extend((columns.start..inner.start).flat_map(|x| picture.texel([x, y])));
            let row = picture.border.texel(y, h).and_then(|y| picture.view.row(y));
            match row {
                Some(row) => samples
                    .extend_from_slice(&row[inner.start as usize * C..inner.end as usize * C]),
                None => samples.extend(inner.clone().flat_map(|_| picture.constant)),
            }
            samples.extend((inner.end..columns.end).flat_map(|x| picture.texel([x, y])));
        }
        Self { samples, origin, size }
    }

    pub(super) fn samples(&self) -> &[T] {
        &self.samples
    }

    pub(super) fn origin(&self) -> [i32; 2] {
        self.origin
    }

    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }
}
