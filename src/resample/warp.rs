//! A whole picture through a map.

use super::block::{BlockSampler, Positions};
use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, ImageViewMut, Sample};
use crate::mapping::Map;

/// Paints `target` with what `map` finds in `source` at each pixel's centre.
///
/// Pixels that the map has no value for (beyond the horizon, behind the texture camera, outside its domain) are painted
/// with a [`Border::Constant`] and left alone with any other border, as are all pixels where `source` is empty.
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
    let Some(mut sampler) = BlockSampler::new(source, filter, border) else { return };
    let width = target.width() as i32;
    for y in 0..target.height() {
        let row = target.row_mut(y);
        if let Some((span, valid)) = map.span(y as i32, 0..width) {
            // A map may say anything of where it is valid.
            let start = valid.start.clamp(0, width);
            let valid = start..valid.end.clamp(start, width);
            let (before, rest) = row.split_at_mut(start as usize * C);
            let (seen, after) = rest.split_at_mut(valid.len() * C);
            sampler.fill(before);
            sampler.paint(&Positions::Span(span, valid), seen);
            sampler.fill(after);
            continue;
        }
        let mut done = 0;
        map.blocks(y as i32, 0..width, &mut |x, u, v| {
            let start = usize::try_from(x).unwrap_or(usize::MAX).saturating_mul(C);
            let end = start.saturating_add(u.len().min(v.len()).saturating_mul(C));
            // What is not right of what came before, or beyond the row, is no pixel of it.
            if start < done || end > row.len() {
                return;
            }
            sampler.fill(&mut row[done..start]);
            sampler.paint(&Positions::Each(u, v), &mut row[start..end]);
            done = end;
        });
        sampler.fill(&mut row[done..]);
    }
}
