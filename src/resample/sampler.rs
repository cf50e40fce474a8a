//! The value of a picture at one position, its taps looked up one by one: what lies at an edge, and what is drawn by pixels.

use core::ops::Range;

use nalgebra::Point2;

use super::border::Border;
use super::filter::Filter;
use super::image::{ImageView, Sample};
use super::kernel::{CubicWeights, Kernel, LanczosWeights, bilinear, dot};
use super::position;
use crate::mapping::RowCoords;
use crate::mapping::span::Span;

/// Called for each pixel of a row that a filter has a value for.
pub(crate) trait Visit<T, const C: usize> {
    /// Whether the pixel is wanted; asked before the texels are read.
    fn wants(&mut self, x: i32) -> bool;
    /// The pixel's value.
    fn paint(&mut self, x: i32, value: [T; C]);
}

/// A filter with its weights' coefficients.
#[derive(Clone, Copy)]
pub(super) enum Prepared {
    Nearest,
    Bilinear,
    Cubic(CubicWeights),
    Lanczos2(LanczosWeights<4>),
    Lanczos3(LanczosWeights<6>),
    Lanczos4(LanczosWeights<8>),
}

impl Prepared {
    pub(super) fn new(filter: Filter) -> Self {
        match filter {
            Filter::Nearest => Self::Nearest,
            Filter::Bilinear => Self::Bilinear,
            Filter::Bicubic(cubic) => Self::Cubic(CubicWeights::new(cubic)),
            Filter::Lanczos2 => Self::Lanczos2(LanczosWeights::new()),
            Filter::Lanczos3 => Self::Lanczos3(LanczosWeights::new()),
            Filter::Lanczos4 => Self::Lanczos4(LanczosWeights::new()),
        }
    }
}

/// A picture with at least one pixel, a border and a filter.
pub(super) struct Sampler<'a, T, const C: usize> {
    pub(super) view: ImageView<'a, T, C>,
    pub(super) border: Border,
    pub(super) constant: [T; C],
    pub(super) filter: Prepared,
    pub(super) size: [i32; 2],
}

impl<'a, T: Sample, const C: usize> Sampler<'a, T, C> {
    /// `None` for a picture without pixels.
    pub(super) fn new(view: ImageView<'a, T, C>, filter: Filter, border: Border) -> Option<Self> {
        let size = [view.width() as i32, view.height() as i32];
        (size[0] > 0 && size[1] > 0).then(|| Self {
            view,
            border,
            constant: border.constant(),
            filter: Prepared::new(filter),
            size,
        })
    }

    /// The value at a position; `None` outside a transparent border, for NaN and beyond
    /// [`COORDINATE_LIMIT`](RowCoords::COORDINATE_LIMIT).
    #[inline]
    pub(super) fn at(&self, u: f64, v: f64) -> Option<[T; C]> {
        let limit = RowCoords::COORDINATE_LIMIT;
        if !(u.abs() <= limit && v.abs() <= limit) {
            return None;
        }
        let texel = [u, v].map(|x| position::split(x, 0.0).0);
        if self.border == Border::Transparent && self.outside(texel) {
            return None;
        }
        let [(i, fu), (j, fv)] = [u, v].map(|x| position::split(x, 0.5));
        let (at, fractions) = ([i, j], [fu, fv]);
        Some(match &self.filter {
            Prepared::Nearest => self.texel(texel[0], texel[1]),
            Prepared::Bilinear => self.bilinear(at, fractions),
            Prepared::Cubic(k) => self.separable(k, at, fractions),
            Prepared::Lanczos2(k) => self.separable(k, at, fractions),
            Prepared::Lanczos3(k) => self.separable(k, at, fractions),
            Prepared::Lanczos4(k) => self.separable(k, at, fractions),
        })
    }

    /// Writes the value at a position: where there is none the border's constant, and nothing where it has none.
    #[inline(never)]
    pub(super) fn paint(&self, u: f64, v: f64, pixel: &mut [T]) {
        match self.at(u, v) {
            Some(value) => pixel.copy_from_slice(&value),
            None => self.paint_border(pixel),
        }
    }

    /// Writes what a pixel without a position gets: the border's constant, and nothing where it has none.
    #[inline(always)]
    pub(super) fn paint_border(&self, pixel: &mut [T]) {
        if let Border::Constant(_) = self.border {
            pixel.copy_from_slice(&self.constant);
        }
    }

    /// The pixels of an interval whose filter of `taps` texels sees more than the border, and perhaps some beyond them.
    #[inline]
    pub(super) fn seen(&self, span: &Span<2>, valid: &Range<i32>, taps: usize) -> Range<i32> {
        match self.border {
            Border::Transparent | Border::Constant(_) => {}
            _ => return valid.clone(),
        }
        // A texel more, so that rounding takes no pixel away.
        let margin = taps as f64 / 2.0 + 1.0;
        let [w, h] = self.size.map(f64::from);
        let columns = span.interval_within(0, [-margin, w + margin], valid.clone());
        span.interval_within(1, [-margin, h + margin], columns)
    }

    /// Whether a filter of `taps` texels whose first one stands in this column and row sees nothing but the border.
    #[inline(always)]
    pub(super) fn sees_border(&self, first: [u32; 2], taps: i32) -> bool {
        let [low, high] = match self.border {
            // The position lies beyond the middle taps.
            Border::Transparent => [-1 - (taps + 1) / 2, 1 - (taps + 1) / 2],
            Border::Constant(_) => [-taps, 0],
            _ => return false,
        };
        let beyond = |first: u32, size: i32| {
            let first = first as i32;
            first <= low || first >= size + high
        };
        beyond(first[0], self.size[0]) || beyond(first[1], self.size[1])
    }

    #[inline]
    fn outside(&self, [i, j]: [i32; 2]) -> bool {
        // One unsigned comparison tests both ends.
        i as u32 >= self.size[0] as u32 || j as u32 >= self.size[1] as u32
    }

    #[inline]
    fn texel(&self, i: i32, j: i32) -> [T; C] {
        if !self.outside([i, j]) {
            return self.view.pixel(i as usize, j as usize).unwrap_or(self.constant);
        }
        match (self.border.texel(i, self.size[0]), self.border.texel(j, self.size[1])) {
            (Some(x), Some(y)) => self.view.pixel(x, y).unwrap_or(self.constant),
            _ => self.constant,
        }
    }

    #[inline]
    fn bilinear(&self, [i, j]: [i32; 2], [fu, fv]: [f32; 2]) -> [T; C] {
        let taps = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| self.texel(i, j));
        core::array::from_fn(|k| T::from_f32(bilinear(taps.map(|t| t[k].to_f32()), fu, fv)))
    }

    #[inline]
    fn separable<const N: usize>(
        &self,
        kernel: &impl Kernel<N>,
        [i, j]: [i32; 2],
        [fu, fv]: [f32; 2],
    ) -> [T; C] {
        let first = N as i32 / 2 - 1;
        let corner = [i, j].map(|k| (k - first) as u32);
        if self.sees_border(corner, N as i32) && self.border != Border::Transparent {
            // Not the constant times a sum of weights, which rounding takes a little from one.
            return self.constant;
        }
        let (columns, rows) = (kernel.weights(fu), kernel.weights(fv));
        let mut sums = [[0.0; N]; C];
        for (y, j) in (0..N).zip(j - first..) {
            let mut taps = [[0.0; N]; C];
            for (x, i) in (0..N).zip(i - first..) {
                let texel = self.texel(i, j);
                for k in 0..C {
                    taps[k][x] = texel[k].to_f32();
                }
            }
            for k in 0..C {
                sums[k][y] = dot(&columns, &taps[k]);
            }
        }
        sums.map(|sums| T::from_f32(dot(&rows, &sums)))
    }

    /// The filter is chosen once a row.
    fn visit(&self, coords: &RowCoords, visit: &mut impl Visit<T, C>) {
        match &self.filter {
            Prepared::Nearest => self.visit_with(coords, visit, |[i, j], _, _| self.texel(i, j)),
            Prepared::Bilinear => self.visit_split(coords, visit, |at, f| self.bilinear(at, f)),
            Prepared::Cubic(k) => self.visit_split(coords, visit, |at, f| self.separable(k, at, f)),
            Prepared::Lanczos2(k) => {
                self.visit_split(coords, visit, |at, f| self.separable(k, at, f));
            }
            Prepared::Lanczos3(k) => {
                self.visit_split(coords, visit, |at, f| self.separable(k, at, f));
            }
            Prepared::Lanczos4(k) => {
                self.visit_split(coords, visit, |at, f| self.separable(k, at, f));
            }
        }
    }

    /// `lookup` takes the texel centre before a position and the fractions behind it.
    #[inline(always)]
    fn visit_split(
        &self,
        coords: &RowCoords,
        visit: &mut impl Visit<T, C>,
        lookup: impl Fn([i32; 2], [f32; 2]) -> [T; C],
    ) {
        self.visit_with(coords, visit, |_, [ou, ov], [u, v]| {
            // Half a texel is exact in f32: offsets are below 2⁷.
            let (u, v) = (u - 0.5, v - 0.5);
            let (i, j) = (floor(u), floor(v));
            lookup([ou + i, ov + j], [u - i as f32, v - j as f32])
        });
    }

    /// `lookup` takes the texel that contains a position, and its origin and offset.
    #[inline(always)]
    fn visit_with(
        &self,
        coords: &RowCoords,
        visit: &mut impl Visit<T, C>,
        lookup: impl Fn([i32; 2], [i32; 2], [f32; 2]) -> [T; C],
    ) {
        let transparent = self.border == Border::Transparent;
        for run in coords.runs() {
            let (u, v) = coords.offsets(run);
            let [ou, ov] = run.origin;
            for ((x, &u), &v) in run.pixels().zip(u).zip(v) {
                if !visit.wants(x) {
                    continue;
                }
                let texel = [ou + floor(u), ov + floor(v)];
                if !(transparent && self.outside(texel)) {
                    visit.paint(x, lookup(texel, run.origin, [u, v]));
                }
            }
        }
    }
}

/// ⌊x⌋ for |x| < 2³¹. The cast truncates; without SSE4.1 it is cheaper than the library's floor.
#[inline]
fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(x < truncated as f32)
}

/// The position has no value in a picture without pixels.
pub(crate) struct Nothing;

/// Looks up every pixel of a row and hands the values to `visit`.
///
/// # Errors
/// [`Nothing`] for a picture without pixels.
pub(crate) fn visit_row<T: Sample, const C: usize>(
    view: ImageView<'_, T, C>,
    filter: Filter,
    border: Border,
    coords: &RowCoords,
    visit: &mut impl Visit<T, C>,
) -> Result<(), Nothing> {
    Sampler::new(view, filter, border).ok_or(Nothing)?.visit(coords, visit);
    Ok(())
}

/// The value of a picture at one position, in pixels from its top-left corner; `None` outside a transparent border, for
/// NaN, and in a picture without pixels.
///
/// ```
/// use collinear::nalgebra::Point2;
/// use collinear::resample::{Border, Filter, ImageView, sample};
///
/// // Texel centres lie at 0.5 and 1.5: a quarter of the way between them is 10 + 0.25 · 80.
/// let view = ImageView::<u8, 1>::new(&[10, 90], 2, 1)?;
/// assert_eq!(sample(view, &Point2::new(0.75, 0.5), Filter::Bilinear, Border::Clamp), Some([30]));
/// assert_eq!(sample(view, &Point2::new(2.0, 0.5), Filter::Nearest, Border::Transparent), None);
/// # Ok::<(), collinear::Error>(())
/// ```
#[must_use]
pub fn sample<T: Sample, const C: usize>(
    view: ImageView<'_, T, C>,
    position: &Point2<f64>,
    filter: Filter,
    border: Border,
) -> Option<[T; C]> {
    Sampler::new(view, filter, border)?.at(position.x, position.y)
}
