//! Sums of sums: smooth weights in constant time.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::lookup::Footprint;
use super::single::OneByOne;
use super::warp::{AreaSource, Paint};
use crate::error::Error;
use crate::mapping::RowCoords;
use crate::resample::border::Border;
use crate::resample::image::{ImageView, Sample};

/// A picture summed n times along each axis (Heckbert 1986, *Filtering by repeated integration*): averages weighted by n boxes, one
/// after another, from (n + 1)² sums whatever their size.
///
/// n = 1 is a box (Crow 1984), 2 a hat, 3 a piecewise parabola: the B-splines, along u and along v. With S the n-fold sums
///
/// ```text
/// Σⱼ bₙ(j) f(a + j) = Σₖ (−1)ᵏ (n over k) S(e − k w),   e = a + n (w − 1),   k = 0 … n
/// ```
///
/// and the same along the other axis. A weight's widths are whole texels, those whose variances are next to J Jᵀ/12 on the axes;
/// between whole positions the four nearest averages are interpolated.
///
/// *Accuracy.* n-fold sums of large pictures have more digits than floats, which is what limits the method elsewhere. Here they are
/// integers modulo 2¹²⁸, and their differences exact; `f32` pictures are rounded to 2⁻⁴⁰ of their largest sample.
///
/// *Reproduces* a constant and ramps; magnified it is bilinear. *Cost.* 4 (n + 1)² numbers a channel; where a weight reaches
/// beyond the picture, once each texel below it. Weights are no larger than the picture. *Memory.* 16 bytes a sample, and the picture.
///
/// ```
/// use collinear::nalgebra::{Matrix2, Point2};
/// use collinear::resample::{Border, Footprint, ImageView, RepeatedIntegral, sample_area};
///
/// // One bright texel under a hat of two texels' boxes, ½ · (¼, ½, ¼) along both axes.
/// let mut texels = [0u8; 49];
/// texels[3 * 7 + 3] = 160;
/// let integral = RepeatedIntegral::new(ImageView::<u8, 1>::new(&texels, 7, 7)?, 2)?;
/// let pixel = |x, y| Footprint { position: Point2::new(x, y), jacobian: Matrix2::identity() * 8f64.sqrt() };
/// assert_eq!(sample_area(&integral, &pixel(3.5, 3.5), (), Border::Clamp), Some([160 / 4]));
/// assert_eq!(sample_area(&integral, &pixel(4.5, 3.5), (), Border::Clamp), Some([160 / 8]));
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct RepeatedIntegral<T, const C: usize> {
    order: usize,
    sums: Vec<[i128; C]>,
    size: [usize; 2],
    /// A sample's value per unit of the sums.
    unit: f64,
    /// The picture, for weights that reach beyond it.
    texels: Vec<T>,
}

/// (−1)ᵏ (n over k) for n up to 3.
const SIGNED_BINOMIALS: [[i128; 4]; 4] =
    [[1, 0, 0, 0], [1, -1, 0, 0], [1, -2, 1, 0], [1, -3, 3, -1]];
/// The widest box: the sums of three along each axis of 40 bits stay below 2¹²⁷.
const WIDEST: usize = 1 << 14;

/// The boxes along an axis at a position.
#[derive(Clone, Copy)]
struct Axis {
    /// A box's width.
    width: usize,
    /// The first texel of the weights, and the share of those that begin one later.
    start: i64,
    share: f64,
    /// Texels that have weight.
    length: usize,
}

impl Axis {
    fn new(order: usize, position: f64, squared: f64, n: usize) -> Self {
        let boxes = order as f64;
        // n (w² − 1)/12 + 1/6 is the variance; the last term from the interpolation.
        let width = (1.0 + (squared - 2.0) / boxes).max(1.0).sqrt().round();
        let most = ((n - 1) / order + 1).min(WIDEST);
        let width = (width as usize).clamp(1, most);
        let length = order * (width - 1) + 1;
        let first = position - 0.5 * length as f64;
        let start = first.floor();
        Self { width, start: start as i64, share: first - start, length }
    }

    /// Whether both weights lie within n texels.
    fn within(&self, n: usize) -> bool {
        self.start >= 0 && self.start as usize + self.length < n
    }

    /// The weights from `start` on, both put together, in w⁻ⁿ.
    fn weights(&self, order: usize) -> Vec<f64> {
        let mut weights = vec![1.0];
        for _ in 0..order {
            let mut wider = vec![0.0; weights.len() + self.width - 1];
            for (k, weight) in weights.iter().enumerate() {
                for to in &mut wider[k..k + self.width] {
                    *to += weight;
                }
            }
            weights = wider;
        }
        let mut both = vec![0.0; weights.len() + 1];
        for (k, weight) in weights.iter().enumerate() {
            both[k] += (1.0 - self.share) * weight;
            both[k + 1] += self.share * weight;
        }
        both
    }

    /// The weights that n texels have, those beyond the edge by the border, and their sum.
    fn folded(&self, order: usize, n: usize, border: Border) -> (Vec<f64>, f64) {
        let mut folded = vec![0.0; n];
        for (k, weight) in (self.start..).zip(self.weights(order)) {
            let texel = k.clamp(-(1 << 30), 1 << 30) as i32;
            if let Some(i) = border.texel(texel, n as i32) {
                folded[i] += weight;
            }
        }
        let sum = folded.iter().sum();
        (folded, sum)
    }
}

impl<T: Sample, const C: usize> RepeatedIntegral<T, C> {
    /// The sums of a picture of the order 1, 2 or 3.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for another order and where there is not enough memory, [`Error::NotFinite`] for a sample that is
    /// NaN or infinite.
    pub fn new(picture: ImageView<'_, T, C>, order: u8) -> Result<Self, Error> {
        if !(1..=3).contains(&order) {
            let value = f64::from(order);
            let expected = "1, 2 or 3";
            return Err(Error::OutOfRange { what: "order of integration", value, expected });
        }
        let size = [picture.width(), picture.height()];
        let total = size[0].saturating_mul(size[1]);
        let mut sums: Vec<[i128; C]> = Vec::new();
        if sums.try_reserve_exact(total).is_err() {
            return Err(Error::OutOfRange {
                what: "entries of a repeated integral",
                value: total as f64,
                expected: "what memory holds",
            });
        }
        let (all, stride) = picture.samples();
        let rows = || (0..size[1]).flat_map(|y| &all[y * stride..][..size[0] * C]);
        let mut largest = 0.0f64;
        let mut whole = true;
        for sample in rows() {
            let value = f64::from(sample.to_f32());
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "sample of a repeated integral" });
            }
            largest = largest.max(value.abs());
            whole &= value.fract() == 0.0;
        }
        // Whole numbers stay what they are.
        let unit = if whole && largest <= 65_535.0 { 1.0 } else { largest / (1u64 << 40) as f64 };
        let mut texels = Vec::with_capacity(total * C);
        for y in 0..size[1] {
            let row = &all[y * stride..][..size[0] * C];
            texels.extend_from_slice(row);
            sums.extend(
                row.as_chunks::<C>()
                    .0
                    .iter()
                    .map(|texel| texel.map(|s| (f64::from(s.to_f32()) / unit).round() as i128)),
            );
        }
        for _ in 0..order {
            for row in sums.chunks_exact_mut(size[0].max(1)) {
                for x in 1..row.len() {
                    row[x] = added(row[x], row[x - 1]);
                }
            }
            for i in size[0]..sums.len() {
                sums[i] = added(sums[i], sums[i - size[0]]);
            }
        }
        Ok(Self { order: usize::from(order), sums, size, unit, texels })
    }

    /// How many times the picture is summed.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// Σ Σ (−1)ᵏ⁺ˡ (n over k) (n over l) S(x − k w, y − l h).
    fn difference(&self, [x, y]: [i64; 2], [w, h]: [usize; 2]) -> [i128; C] {
        let signs = &SIGNED_BINOMIALS[self.order];
        let mut sum = [0i128; C];
        for (l, down) in (0..=self.order).zip(signs) {
            let Ok(j) = usize::try_from(y - (l * h) as i64) else { break };
            for (k, across) in (0..=self.order).zip(signs) {
                let Ok(i) = usize::try_from(x - (k * w) as i64) else { break };
                let term = self.sums[j * self.size[0] + i];
                for c in 0..C {
                    sum[c] = sum[c].wrapping_add((across * down).wrapping_mul(term[c]));
                }
            }
        }
        sum
    }

    /// The weighted mean where all weights lie within the picture.
    fn inside(&self, [u, v]: [Axis; 2]) -> [f64; C] {
        let mut sums = [0.0; C];
        for (dy, down) in [(0, 1.0 - v.share), (1, v.share)] {
            for (dx, across) in [(0, 1.0 - u.share), (1, u.share)] {
                let end = [u.start + dx + u.length as i64 - 1, v.start + dy + v.length as i64 - 1];
                let of = self.difference(end, [u.width, v.width]);
                for c in 0..C {
                    sums[c] += across * down * of[c] as f64;
                }
            }
        }
        sums.map(|sum| sum * self.unit)
    }

    /// The same, texel by texel.
    fn across_border(&self, axes: [Axis; 2], border: Border) -> [f64; C] {
        let [(columns, u), (rows, v)] =
            [0, 1].map(|k| axes[k].folded(self.order, self.size[k], border));
        let constant = border.constant::<T, C>().map(|s| f64::from(s.to_f32()));
        let total: f64 = axes.iter().map(|a| (a.width as f64).powi(self.order as i32)).product();
        let beyond = (total - u * v).max(0.0);
        let mut sums = constant.map(|value| value * beyond);
        let row = self.size[0] * C;
        for (texels, down) in self.texels.chunks_exact(row).zip(&rows).filter(|(_, w)| **w > 0.0) {
            let texels = texels.as_chunks::<C>().0;
            for (texel, across) in texels.iter().zip(&columns).filter(|(_, w)| **w > 0.0) {
                for c in 0..C {
                    sums[c] += across * down * f64::from(texel[c].to_f32());
                }
            }
        }
        sums
    }
}

fn added<const C: usize>(a: [i128; C], b: [i128; C]) -> [i128; C] {
    core::array::from_fn(|k| a[k].wrapping_add(b[k]))
}

impl<T: Sample, const C: usize> AreaSource<T, C> for RepeatedIntegral<T, C> {
    type Filter = ();

    fn area(&self, pixel: &Footprint, (): (), border: Border) -> Option<[T; C]> {
        let at = [pixel.position.x, pixel.position.y];
        let limit = RowCoords::COORDINATE_LIMIT;
        let inside = at.iter().zip(self.size).all(|(x, n)| (0.0..n as f64).contains(x));
        if !at.iter().all(|x| x.abs() <= limit)
            || self.size.contains(&0)
            || (border == Border::Transparent && !inside)
        {
            return None;
        }
        let j = &pixel.jacobian;
        let axes = [0, 1].map(|axis| {
            let squared = j[(axis, 0)].powi(2) + j[(axis, 1)].powi(2);
            let squared = if squared.is_nan() { 0.0 } else { squared };
            Axis::new(self.order, at[axis], squared, self.size[axis])
        });
        let sums = if axes[0].within(self.size[0]) && axes[1].within(self.size[1]) {
            self.inside(axes)
        } else {
            self.across_border(axes, border)
        };
        let total: f64 = axes.iter().map(|a| (a.width as f64).powi(self.order as i32)).product();
        Some(sums.map(|sum| T::from_f32((sum / total) as f32)))
    }

    fn painter<'a>(&'a self, (): (), border: Border) -> Option<Box<dyn Paint<T> + 'a>> {
        let painter = OneByOne::<_, _, C> { source: self, filter: (), border };
        (!self.size.contains(&0)).then(|| Box::new(painter) as Box<dyn Paint<T> + 'a>)
    }
}
