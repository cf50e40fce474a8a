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
        let [(i, fu), (j, fv)] = [u, v].map(|x| position::split(x, self.shift()));
        self.at_split([i, j], [fu, fv])
    }

    /// What a position is moved by before it is split: to the texel's centre before it, where the filter has taps beside it.
    #[inline(always)]
    fn shift(&self) -> f64 {
        if let Prepared::Nearest = self.filter { 0.0 } else { 0.5 }
    }

    /// The value at a position that is split; `None` outside a transparent border.
    #[inline]
    pub(super) fn at_split(&self, at: [i32; 2], fractions: [f32; 2]) -> Option<[T; C]> {
        if self.border == Border::Transparent {
            let texel = match self.filter {
                Prepared::Nearest => at,
                _ => [0, 1].map(|k| at[k] + i32::from(fractions[k] >= 0.5)),
            };
            if self.outside(texel) {
                return None;
            }
        }
        Some(match &self.filter {
            Prepared::Nearest => self.texel(at),
            Prepared::Bilinear => self.bilinear(at, fractions),
            Prepared::Cubic(k) => self.separable(k, at, fractions),
            Prepared::Lanczos2(k) => self.separable(k, at, fractions),
            Prepared::Lanczos3(k) => self.separable(k, at, fractions),
            Prepared::Lanczos4(k) => self.separable(k, at, fractions),
        })
    }

    /// Writes a value: where there is none the border's constant, and nothing where it has none.
    #[inline(always)]
    pub(super) fn paint(&self, value: Option<[T; C]>, pixel: &mut [T]) {
        match value {
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
        let columns = span.interval_within(0, [-margin, w + margin], valid.clone(), 2);
        span.interval_within(1, [-margin, h + margin], columns, 2)
    }

    /// The pixels of an interval whose value is made by a filter of `taps` texels, and perhaps a few less: those within a
    /// transparent border, and those that see more than the constant one.
    pub(super) fn filtered(&self, span: &Span<2>, range: &Range<i32>, taps: usize) -> Range<i32> {
        let beyond = match self.border {
            Border::Transparent => 0.0,
            Border::Constant(_) => (taps as f64 - 1.0) / 2.0,
            _ => return range.clone(),
        };
        let [w, h] = self.size.map(|n| [1e-6 - beyond, f64::from(n) + beyond - 1e-6]);
        let columns = span.interval_within(0, w, range.clone(), -2);
        span.interval_within(1, h, columns, -2)
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
    pub(super) fn texel(&self, [i, j]: [i32; 2]) -> [T; C] {
        let [[texel]]: [[[T; C]; 1]; 1] = self.texels([i, j]);
        texel
    }

    /// N × N texels from a first one on, rows of them; what lies outside is found by the border, an axis by itself.
    #[inline(always)]
    fn texels<const N: usize>(&self, first: [i32; 2]) -> [[[T; C]; N]; N] {
        // No column or row of a picture has this number: it stands for the constant.
        let mut places = [[usize::MAX; N]; 2];
        for axis in 0..2 {
            for k in 0..N {
                let (i, n) = (first[axis] + k as i32, self.size[axis]);
                // One unsigned comparison tests both ends.
                if (i as u32) < n as u32 {
                    places[axis][k] = i as usize;
                } else if let Some(i) = self.border.texel(i, n) {
                    places[axis][k] = i;
                }
            }
        }
        let [columns, rows] = places;
        let mut texels = [[self.constant; N]; N];
        for y in 0..N {
            for x in 0..N {
                if let Some(texel) = self.view.pixel(columns[x], rows[y]) {
                    texels[y][x] = texel;
                }
            }
        }
        texels
    }

    #[inline]
    fn bilinear(&self, at: [i32; 2], [fu, fv]: [f32; 2]) -> [T; C] {
        let [[a, b], [c, d]]: [[[T; C]; 2]; 2] = self.texels(at);
        let mut value = [T::default(); C];
        for k in 0..C {
            let taps = [a[k].to_f32(), b[k].to_f32(), c[k].to_f32(), d[k].to_f32()];
            value[k] = T::from_f32(bilinear(taps, fu, fv));
        }
        value
    }

    #[inline]
    fn separable<const N: usize>(
        &self,
        kernel: &impl Kernel<N>,
        at: [i32; 2],
        [fu, fv]: [f32; 2],
    ) -> [T; C] {
        let first = at.map(|k| k - (N as i32 / 2 - 1));
        if self.sees_border(first.map(|k| k as u32), N as i32) && self.border != Border::Transparent
        {
            // Not the constant times a sum of weights, which rounding takes a little from one.
            return self.constant;
        }
        let (columns, rows) = (kernel.weights(fu), kernel.weights(fv));
        let texels: [[[T; C]; N]; N] = self.texels(first);
        let mut value = [T::default(); C];
        for k in 0..C {
            let (mut sums, mut taps) = ([0.0; N], [0.0; N]);
            for y in 0..N {
                for x in 0..N {
                    taps[x] = texels[y][x][k].to_f32();
                }
                sums[y] = dot(&columns, &taps);
            }
            value[k] = T::from_f32(dot(&rows, &sums));
        }
        value
    }

    /// The filter is chosen once a row.
    fn visit(&self, coords: &RowCoords, visit: &mut impl Visit<T, C>) {
        match &self.filter {
            Prepared::Nearest => self.visit_with(coords, visit, |at, _, _| self.texel(at)),
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
