//! Sums over rectangles in constant time.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::marker::PhantomData;

use super::lookup::Footprint;
use super::single::OneByOne;
use super::warp::{AreaSource, Paint};
use crate::mapping::RowCoords;
use crate::resample::border::Border;
use crate::resample::image::{ImageView, Sample};

/// The sums of a picture over all rectangles from its corner (Crow 1984): the mean of any rectangle from four of them.
///
/// With texels as squares of one value, F(x, y) = ∫∫ of the picture over [0, x] × [0, y], and the sum over a rectangle is
/// F(x₁, y₁) − F(x₀, y₁) − F(x₁, y₀) + F(x₀, y₀). Between texels' corners F is bilinear, so rectangles may begin and end
/// anywhere.
///
/// *Reproduces* a constant; a ramp where rectangles are whole texels wide, and within ⅛ texel where not. A rectangle is never
/// smaller than a texel: magnified, the mean over one texel is [`Bilinear`](crate::resample::Filter::Bilinear). *Cost.* 16 numbers a
/// channel and rectangle, whatever its size; more where it crosses an edge. *Memory.* 8 bytes a sample. *Accuracy.* Sums are
/// `f64`: exact for pictures of `u8` and `u16`, relative to the sum of all samples 10⁻¹⁶ for `f32`.
///
/// ```
/// use collinear::nalgebra::{Matrix2, Point2};
/// use collinear::resample::{Border, Footprint, ImageView, SummedAreaTable, TableFilter, sample_area};
///
/// let view = ImageView::<f32, 1>::new(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3, 2)?;
/// let table = SummedAreaTable::new(view)?;
/// // [½, 2½] × [0, 2]: half of 1 + 4, all of 2 + 5 and half of 3 + 6, over an area of 4.
/// let pixel = Footprint { position: Point2::new(1.5, 1.0), jacobian: Matrix2::identity() * 2.0 };
/// assert_eq!(sample_area(&table, &pixel, TableFilter::Rectangle, Border::Clamp), Some([14.0 / 4.0]));
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("integral image", "SAT", "cumulative sum"))]
pub struct SummedAreaTable<T, const C: usize> {
    /// F at the corners of texels, a row and a column more than the picture has.
    sums: Vec<[f64; C]>,
    size: [usize; 2],
    samples: PhantomData<T>,
}

/// Which rectangles stand for a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TableFilter {
    /// The one around the parallelogram that the pixel's square becomes. Where that is long and oblique it blurs.
    #[default]
    Rectangle,
    /// Up to so many around pieces of it, as Glassner 1986 refines rectangles where they fit badly: the square is cut across its
    /// longer side into as many strips as the rectangle's area is larger than the parallelogram's. Zero counts as one.
    Strips(u8),
}

/// Pieces of an interval within the picture, each with how often it counts.
struct Pieces {
    pieces: [[f64; 3]; 5],
    count: usize,
}

impl Pieces {
    fn new() -> Self {
        Self { pieces: [[0.0; 3]; 5], count: 0 }
    }

    fn push(&mut self, start: f64, end: f64, times: f64) {
        if end > start && times > 0.0 && self.count < self.pieces.len() {
            self.pieces[self.count] = [start, end, times];
            self.count += 1;
        }
    }

    /// What the interval from `start` to `end` reads of `n` texels.
    fn of(border: Border, start: f64, end: f64, n: f64) -> Self {
        let mut of = Self::new();
        match border {
            Border::Constant(_) => of.push(start.max(0.0), end.min(n), 1.0),
            Border::Transparent | Border::Clamp => {
                of.push(0.0, 1.0, end.min(0.0) - start);
                of.push(start.clamp(0.0, n), end.clamp(0.0, n), 1.0);
                of.push(n - 1.0, n, end - start.max(n));
            }
            Border::Repeat => {
                let length = end - start;
                let whole = (length / n).floor();
                let from = start.rem_euclid(n);
                let to = from + (length - whole * n).clamp(0.0, n);
                of.push(0.0, n, whole);
                of.push(from, to.min(n), 1.0);
                of.push(0.0, to - n, 1.0);
            }
            Border::Mirror => {
                let length = end - start;
                let whole = (length / (2.0 * n)).floor();
                let from = start.rem_euclid(2.0 * n);
                let to = from + (length - whole * 2.0 * n).clamp(0.0, 2.0 * n);
                of.push(0.0, n, 2.0 * whole);
                of.push(from, to.min(n), 1.0);
                // [n, 2n) is mirrored, [2n, 3n) is not, [3n, 4n) is.
                of.push(2.0 * n - to.min(2.0 * n), 2.0 * n - from.max(n), 1.0);
                of.push((from - 2.0 * n).max(0.0), (to - 2.0 * n).min(n), 1.0);
                of.push(4.0 * n - to, n, 1.0);
            }
        }
        of
    }

    fn iter(&self) -> impl Iterator<Item = &[f64; 3]> {
        self.pieces[..self.count].iter()
    }
}

impl<T: Sample, const C: usize> SummedAreaTable<T, C> {
    /// The sums of a picture.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) where there is not enough memory.
    pub fn new(picture: ImageView<'_, T, C>) -> Result<Self, crate::error::Error> {
        let size = [picture.width(), picture.height()];
        let row = size[0] + 1;
        let total = row.saturating_mul(size[1] + 1);
        let mut sums = Vec::new();
        if sums.try_reserve_exact(total).is_err() {
            return Err(crate::error::Error::OutOfRange {
                what: "entries of a summed-area table",
                value: total as f64,
                expected: "what memory holds",
            });
        }
        sums.resize(row, [0.0; C]);
        let (all, stride) = picture.samples();
        for y in 0..size[1] {
            let mut of_row = [0.0; C];
            sums.push(of_row);
            for (x, texel) in all[y * stride..][..size[0] * C].as_chunks::<C>().0.iter().enumerate()
            {
                let above = sums[y * row + x + 1];
                for k in 0..C {
                    of_row[k] += f64::from(texel[k].to_f32());
                }
                sums.push(core::array::from_fn(|k| above[k] + of_row[k]));
            }
        }
        Ok(Self { sums, size, samples: PhantomData })
    }

    /// F(x, y) for 0 ≤ x ≤ w, 0 ≤ y ≤ h.
    fn at(&self, x: f64, y: f64) -> [f64; C] {
        let [w, h] = self.size;
        let (i, j) = ((x as usize).min(w - 1), (y as usize).min(h - 1));
        let (fx, fy) = (x - i as f64, y - j as f64);
        let corner = |dx: usize, dy: usize| &self.sums[(j + dy) * (w + 1) + i + dx];
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
        core::array::from_fn(|k| {
            let upper = a[k] + fx * (b[k] - a[k]);
            let lower = c[k] + fx * (d[k] - c[k]);
            upper + fy * (lower - upper)
        })
    }

    /// The mean of a rectangle about a position.
    fn mean(&self, [u, v]: [f64; 2], [width, height]: [f64; 2], border: Border) -> [f64; C] {
        let [w, h] = self.size.map(|n| n as f64);
        let columns = Pieces::of(border, u - 0.5 * width, u + 0.5 * width, w);
        let rows = Pieces::of(border, v - 0.5 * height, v + 0.5 * height, h);
        let (mut sums, mut covered) = ([0.0; C], 0.0);
        for &[x0, x1, across] in columns.iter() {
            for &[y0, y1, down] in rows.iter() {
                let (a, b) = (self.at(x0, y0), self.at(x1, y0));
                let (c, d) = (self.at(x0, y1), self.at(x1, y1));
                covered += across * down * (x1 - x0) * (y1 - y0);
                for k in 0..C {
                    sums[k] += across * down * ((d[k] - c[k]) - (b[k] - a[k]));
                }
            }
        }
        let area = width * height;
        if let Border::Constant(values) = border {
            for k in 0..C {
                let constant = values.get(k).copied().unwrap_or(0.0);
                sums[k] += (area - covered).max(0.0) * f64::from(constant);
            }
        }
        sums.map(|sum| sum / area)
    }
}

/// What is beyond has no place in a sum.
const LARGEST: f64 = 1e9;

impl<T: Sample, const C: usize> AreaSource<T, C> for SummedAreaTable<T, C> {
    type Filter = TableFilter;

    fn area(&self, pixel: &Footprint, filter: TableFilter, border: Border) -> Option<[T; C]> {
        let (u, v) = (pixel.position.x, pixel.position.y);
        let limit = RowCoords::COORDINATE_LIMIT;
        let [w, h] = self.size.map(|n| n as f64);
        let inside = (0.0..w).contains(&u) && (0.0..h).contains(&v);
        if !(u.abs() <= limit && v.abs() <= limit)
            || self.size.contains(&0)
            || (border == Border::Transparent && !inside)
        {
            return None;
        }
        let [us, vs, ul, vl] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|at| {
            let derivative = pixel.jacobian[at];
            if derivative.is_nan() { 0.0 } else { derivative.clamp(-LARGEST, LARGEST) }
        });
        let strips = match filter {
            TableFilter::Rectangle => 1,
            TableFilter::Strips(most) => {
                let around = (us.abs() + ul.abs()).max(1.0) * (vs.abs() + vl.abs()).max(1.0);
                let within = (us * vl - vs * ul).abs().max(1.0);
                ((around / within).ceil() as usize).clamp(1, usize::from(most.max(1)))
            }
        };
        let n = strips as f64;
        // The longer side, which is cut, and the other one.
        let (long, other) =
            if us.hypot(vs) >= ul.hypot(vl) { ([us, vs], [ul, vl]) } else { ([ul, vl], [us, vs]) };
        let size = [0, 1].map(|k| (long[k].abs() / n + other[k].abs()).max(1.0));
        let mut sums = [0.0; C];
        for strip in 0..strips {
            let along = (strip as f64 + 0.5) / n - 0.5;
            let mean = self.mean([u + along * long[0], v + along * long[1]], size, border);
            for k in 0..C {
                sums[k] += mean[k];
            }
        }
        Some(sums.map(|sum| T::from_f32((sum / n) as f32)))
    }

    fn painter<'a>(
        &'a self,
        filter: TableFilter,
        border: Border,
    ) -> Option<Box<dyn Paint<T> + 'a>> {
        let painter = OneByOne::<_, _, C> { source: self, filter, border };
        (!self.size.contains(&0)).then(|| Box::new(painter) as Box<dyn Paint<T> + 'a>)
    }
}
