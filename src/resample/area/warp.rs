//! A whole picture through a map, each pixel by its area.

use alloc::boxed::Box;

use super::lookup::Footprint;
use crate::mapping::span::BLOCK;
use crate::mapping::{FootprintBlock, Map};
use crate::resample::bands::{for_each_band, samples_at};
use crate::resample::border::Border;
use crate::resample::image::{ImageViewMut, Sample};

/// Writes values to pixels of a row.
#[doc(hidden)]
pub trait Paint<T> {
    /// Writes the values of neighbouring pixels; a pixel without one as [`fill`](Self::fill).
    fn paint(&mut self, block: &FootprintBlock<'_>, pixels: &mut [T]);
    /// Writes pixels that no position is known for: the border's constant, and nothing where it has none.
    fn fill(&self, pixels: &mut [T]);
}

/// A picture that was prepared for averages over areas.
///
/// Prepared are a [`Pyramid`](super::Pyramid), a [`SummedAreaTable`](super::SummedAreaTable) and a
/// [`RepeatedIntegral`](super::RepeatedIntegral); [`warp_area`] and [`sample_area`] take
/// any of them, each with a choice of its own.
pub trait AreaSource<T: Sample, const C: usize> {
    /// How averages are taken.
    type Filter: Copy + Sync;

    /// The value of one pixel; `None` outside a transparent border, for NaN, and in a picture without pixels.
    fn area(&self, pixel: &Footprint, filter: Self::Filter, border: Border) -> Option<[T; C]>;

    /// What paints rows; `None` for a picture without pixels.
    #[doc(hidden)]
    fn painter<'a>(
        &'a self,
        filter: Self::Filter,
        border: Border,
    ) -> Option<Box<dyn Paint<T> + 'a>>;
}

/// The average of a picture over a pixel's area; `None` outside a transparent border, for NaN, and in a picture without
/// pixels.
///
/// The same as [`warp_area`] paints, bit for bit. An example is that of [`AreaFilter`](super::AreaFilter).
#[must_use]
pub fn sample_area<S: AreaSource<T, C>, T: Sample, const C: usize>(
    source: &S,
    pixel: &Footprint,
    filter: S::Filter,
    border: Border,
) -> Option<[T; C]> {
    source.area(pixel, filter, border)
}

/// Paints `target` with the averages of `source` over the areas that its pixels cover under `map`.
///
/// As [`warp`](crate::resample::warp), for pictures that the map makes smaller: no detail between samples is missed, and none
/// aliases. Areas are taken from the map's derivatives at each pixel's centre ([`Map::footprints`]); beyond the horizon
/// there are none. A pixel depends on its own position alone: targets may be cut into rows anyhow.
///
/// With the feature `rayon` bands of rows are painted on the threads of the caller's pool, with the same bytes whatever
/// their number.
///
/// *Cost.* benches/README.md has the speeds. Pixels at a level's edge cost several times as much as those within.
///
/// ```
/// use collinear::geometry::Affine2;
/// use collinear::resample::{AreaFilter, Border, ImageView, ImageViewMut, Pyramid, warp_area};
///
/// // A checkerboard of single pixels at a quarter of its size is grey.
/// let board: Vec<u8> = (0..32 * 32).map(|i| if (i / 32 + i) % 2 == 0 { 0 } else { 200 }).collect();
/// let pyramid = Pyramid::new(ImageView::<u8, 1>::new(&board, 32, 32)?)?;
/// let quarter = Affine2::from_coefficients([0.0, 4.0, 0.0], [0.0, 0.0, 4.0]);
/// let mut small = [0; 8 * 8];
/// let mut target = ImageViewMut::new(&mut small, 8, 8)?;
/// warp_area(&pyramid, &quarter, AreaFilter::Trilinear, Border::Clamp, &mut target);
/// assert_eq!(small, [100; 64]);
/// # Ok::<(), collinear::Error>(())
/// ```
pub fn warp_area<S: AreaSource<T, C> + Sync, T: Sample, const C: usize>(
    source: &S,
    map: &dyn Map,
    filter: S::Filter,
    border: Border,
    target: &mut ImageViewMut<'_, T, C>,
) {
    let painter = || source.painter(filter, border);
    for_each_band(target, painter, |painter, line, rows| {
        let Some(painter) = painter else { return };
        for (row, line) in rows.iter_mut().zip(line..) {
            let mut done = 0;
            map.footprints(line, 0..(row.len() / C) as i32, &mut |block| {
                let place = samples_at::<C>(block.x, block.u.len(), done, row.len());
                let Some(place) = place.filter(|_| is_even(block)) else { return };
                painter.fill(&mut row[done..place.start]);
                done = place.end;
                painter.paint(block, &mut row[place]);
            });
            painter.fill(&mut row[done..]);
        }
    });
}

/// Whether a block is one: all slices of one length, of 1 to 64.
fn is_even(block: &FootprintBlock<'_>) -> bool {
    let ([a, b], [c, d]) = (block.by_sample, block.by_line);
    let n = block.u.len();
    (1..=BLOCK).contains(&n) && [block.v, a, b, c, d].iter().all(|s| s.len() == n)
}
