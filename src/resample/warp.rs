//! A whole picture through a map.

use alloc::vec::Vec;
use core::ops::Range;

use super::bands::{for_each_band, samples_at};
use super::block::{BlockSampler, Positions};
use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, ImageViewMut, Sample};
use crate::mapping::Map;
use crate::mapping::span::Span;

/// Paints `target` with what `map` finds in `source` at each pixel's centre.
///
/// Pixels that the map has no value for (beyond the horizon, behind the texture camera, outside its domain) are painted
/// with a [`Border::Constant`] and left alone with any other border, as are all pixels where `source` is empty.
///
/// With the feature `rayon` bands of rows are painted on the threads of the caller's pool, with the same bytes whatever
/// their number.
///
/// ```
/// use collinear::mapping::FractionalLinear;
/// use collinear::resample::{Border, Filter, ImageView, ImageViewMut, warp};
///
/// // u = 2 − S mirrors a row of two pixels.
/// let mirror = FractionalLinear::from_coefficients(
///     [2.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0])?;
/// let source = ImageView::<u8, 1>::new(&[10, 90], 2, 1)?;
/// let mut pixels = [0; 2];
/// warp(source, &mirror, Filter::Nearest, Border::Clamp, &mut ImageViewMut::new(&mut pixels, 2, 1)?);
/// assert_eq!(pixels, [90, 10]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("warpPerspective", "remap", "warpAffine"))]
pub fn warp<T: Sample, const C: usize>(
    source: ImageView<'_, T, C>,
    map: &dyn Map,
    filter: Filter,
    border: Border,
    target: &mut ImageViewMut<'_, T, C>,
) {
    let sampler = || BlockSampler::new(source, filter, border);
    for_each_band(target, sampler, |sampler, line, rows| {
        if let Some(sampler) = sampler {
            paint_band(sampler, map, line, rows);
        }
    });
}

/// Pixels of a strip of rows that run across so many pages of the picture's memory that processors lose sight of them before
/// the next row comes by. A multiple of a span's blocks.
const STRIP: i32 = 256;
/// A page of memory, and so many of them are kept in sight: measured, rows that touch up to 2700 suffer from strips, and rows
/// that touch 3800 take two thirds of the time with them, or half.
const PAGE: f64 = 4096.0;
const PAGES: f64 = 3072.0;

/// Paints neighbouring rows from `line` on.
fn paint_band<T: Sample, const C: usize>(
    sampler: &mut BlockSampler<'_, T, C>,
    map: &dyn Map,
    line: i32,
    rows: &mut [&mut [T]],
) {
    let mut spans: Vec<(&mut [T], Span<2>, Range<i32>)> = Vec::with_capacity(rows.len());
    let mut across = false;
    let width = rows.first().map_or(0, |row| row.len() / C) as i32;
    for (row, line) in rows.iter_mut().zip(line..) {
        if let Some((span, valid)) = map.span(line, 0..width) {
            // A map may say anything of where it is valid.
            let start = valid.start.clamp(0, width);
            let valid = span.valid_interval(start..valid.end.clamp(start, width));
            across |= pages_crossed(&span, &valid, sampler.bytes_a_row()) > PAGES;
            spans.push((row, span, valid));
        } else {
            paint_by_blocks(sampler, map, line, row);
        }
    }
    let strip = if across { STRIP } else { width.max(1) };
    for x in (0..width).step_by(strip as usize) {
        let end = width.min(x.saturating_add(strip));
        for (row, span, valid) in &mut spans {
            let row = &mut row[x as usize * C..end as usize * C];
            let start = valid.start.clamp(x, end);
            let valid = start..valid.end.clamp(start, end);
            let (before, rest) = row.split_at_mut((start - x) as usize * C);
            let (seen, after) = rest.split_at_mut(valid.len() * C);
            sampler.fill(before);
            sampler.paint(&Positions::Span(*span, valid), seen);
            sampler.fill(after);
        }
    }
}

/// How many pages the positions of a row touch, of a picture with so many bytes a row.
fn pages_crossed(span: &Span<2>, valid: &Range<i32>, bytes: usize) -> f64 {
    if valid.len() <= STRIP as usize {
        return 0.0;
    }
    let [first, last] = [valid.start, valid.end - 1].map(|x| span.at(x));
    let (Ok([_, first]), Ok([_, last])) = (first, last) else { return 0.0 };
    (last - first).abs().min(valid.len() as f64) * (bytes as f64 / PAGE).min(1.0)
}

/// Paints a row by the positions that the map hands out.
fn paint_by_blocks<T: Sample, const C: usize>(
    sampler: &mut BlockSampler<'_, T, C>,
    map: &dyn Map,
    line: i32,
    row: &mut [T],
) {
    let mut done = 0;
    map.blocks(line, 0..(row.len() / C) as i32, &mut |x, u, v| {
        let count = u.len().min(v.len());
        let Some(place) = samples_at::<C>(x, count, done, row.len()) else { return };
        sampler.fill(&mut row[done..place.start]);
        done = place.end;
        sampler.paint(&Positions::Each(u, v), &mut row[place]);
    });
    sampler.fill(&mut row[done..]);
}
