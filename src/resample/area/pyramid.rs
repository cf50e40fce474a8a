//! A picture at every size.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use super::block::PyramidPainter;
use super::filter::AreaFilter;
use super::lookup::{Footprint, Lookup};
use super::warp::{AreaSource, Paint};
use crate::error::Error;
use crate::resample::border::Border;
use crate::resample::image::{ImageView, Sample};

/// Samples behind the last level, so that whole groups of texels can be read at its end.
const SPARE: usize = 64;

/// A picture and its reductions, each by the same ratio from the one before, down to one texel.
///
/// Level k has ⌊w/rᵏ⌋ × ⌊h/rᵏ⌋ texels, at least one (for r = 2 the sizes of OpenGL, Direct3D and Vulkan). All levels cover the
/// same picture: a position u of the picture is u wₖ/w in level k, whose texel i covers [i, i+1) w/wₖ there. So nothing
/// shifts, whatever the sizes.
///
/// A texel is the mean of the picture over the area it covers, parts of texels counted as parts (Williams 1983's pyramid,
/// without its powers of two). A level is made from the last one that is at least twice as fine; with ratios below 2
/// (\[WD\] reports about 1.12 as the best for moving views) blur does not add up from level to level. Means are carried on
/// in `f32` and rounded to samples once a level. A constant picture stays constant.
///
/// *Memory.* The picture times r²/(r² − 1): ⁴⁄₃ for 2, 4.9 for 1.12; while it is made the `f32` levels of one
/// factor of two besides. *Cost.* About r²/(r² − 1) times the picture's samples for 2, four times that for ratios near 1.
///
/// ```
/// use collinear::resample::{ImageView, Pyramid};
///
/// // Five texels to two: each is 2½ texels wide.
/// let row = ImageView::<f32, 1>::new(&[10.0, 20.0, 30.0, 40.0, 50.0], 5, 1)?;
/// let pyramid = Pyramid::new(row)?;
/// let level = pyramid.level(1).ok_or("a second level")?;
/// // (10 + 20 + 30/2)/2½ and (30/2 + 40 + 50)/2½.
/// assert_eq!([level.pixel(0, 0), level.pixel(1, 0)], [Some([18.0]), Some([42.0])]);
/// assert_eq!(pyramid.levels(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("mipmap", "MIP map", "image pyramid"))]
pub struct Pyramid<T, const C: usize> {
    /// All levels, rows without padding, and some samples more.
    samples: Vec<T>,
    levels: Vec<Level>,
    ratio: f64,
}

/// One level's place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub(super) start: usize,
    pub(super) size: [usize; 2],
    /// Texels of this level per texel of the picture, along each axis.
    pub(super) scale: [f64; 2],
}

impl<T: Sample, const C: usize> Pyramid<T, C> {
    /// The least and the largest ratio between two levels.
    pub const RATIOS: [f64; 2] = [1.01, 16.0];

    /// Levels by halves.
    ///
    /// # Errors
    /// As [`with_ratio`](Self::with_ratio).
    pub fn new(picture: ImageView<'_, T, C>) -> Result<Self, Error> {
        Self::with_ratio(picture, 2.0)
    }

    /// Levels by any ratio.
    ///
    /// A picture without texels has no levels.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a ratio outside [`RATIOS`](Self::RATIOS) and where there is not enough memory.
    pub fn with_ratio(picture: ImageView<'_, T, C>, ratio: f64) -> Result<Self, Error> {
        let [least, most] = Self::RATIOS;
        if !(least..=most).contains(&ratio) {
            let expected = "1.01 to 16";
            return Err(Error::OutOfRange { what: "pyramid ratio", value: ratio, expected });
        }
        let levels = plan::<C>([picture.width(), picture.height()], ratio);
        let total = levels.iter().map(|l| l.size[0] * l.size[1] * C).sum::<usize>();
        let mut samples = Vec::new();
        if samples.try_reserve_exact(total + SPARE).is_err() {
            return Err(Error::OutOfRange {
                what: "samples of a pyramid",
                value: total as f64,
                expected: "what memory holds",
            });
        }
        // How many levels up at least twice as fine a one is.
        let back = (core::f64::consts::LN_2 / ratio.ln() - 1e-9).ceil().max(1.0) as usize;
        let mut floats: Vec<Vec<f32>> = Vec::new();
        for (k, level) in levels.iter().enumerate() {
            if k == 0 {
                let (all, stride) = picture.samples();
                for y in 0..level.size[1] {
                    samples.extend_from_slice(&all[y * stride..][..level.size[0] * C]);
                }
                floats.push(Vec::new());
                continue;
            }
            let from = k.saturating_sub(back);
            let size = levels[from].size;
            let reduced = if from == 0 {
                reduce::<T, C>(&samples[..size[0] * size[1] * C], size, level.size)
            } else {
                reduce::<f32, C>(&floats[from], size, level.size)
            };
            samples.extend(reduced.iter().map(|&value| T::from_f32(value)));
            floats.push(reduced);
            // Levels before this one's are not needed any more.
            floats[from.saturating_sub(1)] = Vec::new();
        }
        samples.resize(samples.len() + SPARE, T::default());
        Ok(Self { samples, levels, ratio })
    }

    /// How many levels there are, the picture included.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The ratio between the sizes of two levels.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// A level; 0 is the picture.
    #[must_use]
    pub fn level(&self, level: usize) -> Option<ImageView<'_, T, C>> {
        let Level { start, size: [width, height], .. } = *self.levels.get(level)?;
        ImageView::new(&self.samples[start..start + width * height * C], width, height).ok()
    }

    /// All samples, with spare ones behind the last level, and where the levels are.
    pub(super) fn parts(&self) -> (&[T], &[Level]) {
        (&self.samples, &self.levels)
    }
}

/// Sizes and places of the levels.
fn plan<const C: usize>(picture: [usize; 2], ratio: f64) -> Vec<Level> {
    let mut levels = Vec::new();
    if picture.contains(&0) {
        return levels;
    }
    let (mut start, mut factor) = (0, 1.0);
    loop {
        let size = picture.map(|n| ((n as f64 / factor) as usize).max(1));
        let scale = [0, 1].map(|axis| size[axis] as f64 / picture[axis] as f64);
        levels.push(Level { start, size, scale });
        if size == [1, 1] {
            return levels;
        }
        start += size[0] * size[1] * C;
        factor *= ratio;
    }
}

/// The texels of a finer axis below each texel of a coarser one: number of the first, and their shares.
pub(super) struct Shares {
    first: Vec<usize>,
    /// Where each texel's shares begin; one more at the end.
    starts: Vec<usize>,
    shares: Vec<f32>,
}

impl Shares {
    pub(super) fn new(fine: usize, coarse: usize) -> Self {
        let mut of = Self { first: vec![], starts: vec![0], shares: vec![] };
        for i in 0..coarse {
            // In units of 1/coarse texel: the coarse texel is `fine` long, a fine one `coarse`.
            let (start, end) = (i * fine, (i + 1) * fine);
            of.first.push(start / coarse);
            for j in start / coarse..end.div_ceil(coarse) {
                let overlap = end.min((j + 1) * coarse) - start.max(j * coarse);
                of.shares.push((overlap as f64 / fine as f64) as f32);
            }
            of.starts.push(of.shares.len());
        }
        of
    }

    pub(super) fn texel(&self, i: usize) -> (usize, &[f32]) {
        (self.first[i], &self.shares[self.starts[i]..self.starts[i + 1]])
    }
}

/// The means of a picture over the texels of a coarser one that covers the same.
pub(super) fn reduce<S: Sample, const C: usize>(
    from: &[S],
    fine: [usize; 2],
    coarse: [usize; 2],
) -> Vec<f32> {
    let (columns, rows) = (Shares::new(fine[0], coarse[0]), Shares::new(fine[1], coarse[1]));
    let row_length = coarse[0] * C;
    let mut to = vec![0.0f32; row_length * coarse[1]];
    let mut across = vec![0.0f32; row_length];
    // A row that two coarse ones share is reduced once.
    let mut reduced = usize::MAX;
    for (i, sums) in to.chunks_exact_mut(row_length).enumerate() {
        let (first, shares) = rows.texel(i);
        for (j, share) in (first..).zip(shares) {
            if reduced != j {
                let row = &from[j * fine[0] * C..][..fine[0] * C];
                for (x, texel) in across.as_chunks_mut::<C>().0.iter_mut().enumerate() {
                    let (first, shares) = columns.texel(x);
                    *texel = mean::<S, C>(&row[first * C..], shares);
                }
                reduced = j;
            }
            for (sum, value) in sums.iter_mut().zip(&across) {
                *sum += share * value;
            }
        }
    }
    to
}

/// Σ shareᵢ texelᵢ.
#[inline]
fn mean<S: Sample, const C: usize>(texels: &[S], shares: &[f32]) -> [f32; C] {
    let mut sums = [0.0; C];
    for (texel, share) in texels.as_chunks::<C>().0.iter().zip(shares) {
        for k in 0..C {
            sums[k] += share * texel[k].to_f32();
        }
    }
    sums
}

impl<T: Sample, const C: usize> AreaSource<T, C> for Pyramid<T, C> {
    type Filter = AreaFilter;

    fn area(&self, pixel: &Footprint, filter: AreaFilter, border: Border) -> Option<[T; C]> {
        let lookup = Lookup::new(self, filter, border)?;
        lookup.at(pixel.position.x, pixel.position.y, pixel.derivatives())
    }

    fn painter<'a>(&'a self, filter: AreaFilter, border: Border) -> Option<Box<dyn Paint<T> + 'a>> {
        Some(Box::new(PyramidPainter::new(self, filter, border)?))
    }
}
