//! A whole picture through a map.

use super::border::Border;
use super::image::{ImageView, ImageViewMut, Sample};
use super::sampler::{Filter, Visit, constant, visit_row};
use crate::mapping::{Map, RowCoords};

struct RowPainter<'a, T, const C: usize>(&'a mut [T]);

impl<T: Sample, const C: usize> Visit<T, C> for RowPainter<'_, T, C> {
    #[inline]
    fn wants(&mut self, _: i32) -> bool {
        true
    }
    #[inline]
    fn paint(&mut self, x: i32, value: [T; C]) {
        let start = x as usize * C;
        if let Some(pixel) = self.0.get_mut(start..start + C) {
            pixel.copy_from_slice(&value);
        }
    }
}

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
    if source.width() == 0 || source.height() == 0 {
        return;
    }
    let mut coords = RowCoords::new();
    let width = target.width() as i32;
    for y in 0..target.height() {
        let row = target.row_mut(y);
        if let Border::Constant(_) = border {
            let value: [T; C] = constant(border);
            for pixel in row.chunks_exact_mut(C) {
                pixel.copy_from_slice(&value);
            }
        }
        map.row(y as i32, 0..width, &mut coords);
        let _ = visit_row(source, filter, border, &coords, &mut RowPainter::<T, C>(row));
    }
}
