//! Pictures in three dimensions.

use alloc::vec::Vec;

use nalgebra::Point3;

use super::pyramid::{Shares, reduce};
use crate::error::Error;
use crate::mapping::RowCoords;
use crate::resample::border::Border;
use crate::resample::image::Sample;
use crate::resample::kernel::bilinear;

/// A volume of texels (a solid texture) and its reductions by halves, down to one texel.
///
/// As [`Pyramid`](super::Pyramid), with a third axis: slice k of the volume covers [k, k+1), its centre is at k + ½, and level
/// l has ⌊w/2ˡ⌋ × ⌊h/2ˡ⌋ × ⌊d/2ˡ⌋ texels, at least one along each axis. *Memory.* ⁸⁄₇ of the volume; while it is made two
/// levels in `f32` besides.
///
/// ```
/// use collinear::nalgebra::Point3;
/// use collinear::resample::{Border, VolumePyramid};
///
/// // Eight texels: 80 z + 40 y + 20 x.
/// let texels: Vec<u8> = (0..8).map(|i| 20 * i).collect();
/// let volume = VolumePyramid::<u8, 1>::new(&texels, [2, 2, 2])?;
/// let at = |x, y, z, size| volume.sample(&Point3::new(x, y, z), size, Border::Clamp);
/// assert_eq!(at(1.5, 0.5, 1.0, 0.0), Some([60]));
/// // A texel of 1½ is half way from one to two: half the corner's 140, half the mean of all, 70.
/// assert_eq!(at(1.5, 1.5, 1.5, 1.5 * 3f64.sqrt()), Some([105]));
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("3D texture", "solid texture", "quadlinear"))]
pub struct VolumePyramid<T, const C: usize> {
    levels: Vec<Block<T>>,
}

#[derive(Clone, Debug)]
struct Block<T> {
    size: [usize; 3],
    samples: Vec<T>,
}

impl<T: Sample, const C: usize> VolumePyramid<T, C> {
    /// The levels of a volume of texels, x fastest, then y, then z.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] where the samples are not those of w × h × d texels of C channels, [`Error::OutOfRange`] for
    /// a side over 2³⁰ or a channel count other than 1 to 4.
    pub fn new(texels: &[T], size: [usize; 3]) -> Result<Self, Error> {
        if C == 0 || C > 4 {
            let expected = "1 to 4";
            return Err(Error::OutOfRange { what: "channels", value: C as f64, expected });
        }
        if let Some(side) = size.into_iter().find(|side| *side > 1 << 30) {
            return Err(Error::OutOfRange {
                what: "volume side",
                value: side as f64,
                expected: "at most 2³⁰",
            });
        }
        let needed = size.into_iter().try_fold(C, usize::checked_mul).unwrap_or(usize::MAX);
        if texels.len() != needed {
            return Err(Error::LengthMismatch {
                what: "samples and volume",
                left: texels.len(),
                right: needed,
            });
        }
        let mut levels = Vec::new();
        if needed == 0 {
            return Ok(Self { levels });
        }
        levels.push(Block { size, samples: texels.to_vec() });
        let mut fine = Block { size, samples: texels.iter().map(|s| s.to_f32()).collect() };
        while fine.size != [1, 1, 1] {
            fine = fine.halved::<C>();
            levels.push(Block {
                size: fine.size,
                samples: fine.samples.iter().map(|&s| T::from_f32(s)).collect(),
            });
        }
        Ok(Self { levels })
    }

    /// How many levels there are, the volume included.
    #[must_use]
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// The quadlinear value at a position: trilinear in each of two levels, and linear between them; `None` outside a
    /// transparent border, for NaN, and in a volume without texels.
    ///
    /// `size` is how many texels a pixel is long where it is longest, ρ. As for
    /// [`AreaFilter::Trilinear`](super::AreaFilter::Trilinear) the texel that is looked up is s = ρ/√3, of the same variance; the
    /// levels are those below and above it, the coarser one with the share s/2ˡ − 1. *Cost.* 16 texels.
    #[must_use]
    pub fn sample(&self, position: &Point3<f64>, size: f64, border: Border) -> Option<[T; C]> {
        let first = self.levels.first()?;
        let at = [position.x, position.y, position.z];
        if !at.iter().all(|x| x.abs() <= RowCoords::COORDINATE_LIMIT) {
            return None;
        }
        let inside = at.iter().zip(first.size).all(|(x, n)| (0.0..n as f64).contains(x));
        if border == Border::Transparent && !inside {
            return None;
        }
        let texel = if size.is_nan() { 1.0 } else { (size / 3f64.sqrt()).max(1.0) };
        let last = self.levels.len() - 1;
        let level = (texel.log2() as usize).min(last);
        let share = (texel / (1u64 << level) as f64 - 1.0).clamp(0.0, 1.0) as f32;
        let fine = self.trilinear(level, at, border);
        let coarse = self.trilinear((level + 1).min(last), at, border);
        Some(core::array::from_fn(|k| T::from_f32(fine[k] + share * (coarse[k] - fine[k]))))
    }

    fn trilinear(&self, level: usize, at: [f64; 3], border: Border) -> [f32; C] {
        let (block, whole) = (&self.levels[level], self.levels[0].size);
        let constant = border.constant::<T, C>().map(T::to_f32);
        let [x, y, z] = core::array::from_fn(|axis| {
            let scale = block.size[axis] as f64 / whole[axis] as f64;
            crate::resample::position::split(at[axis] * scale, 0.5)
        });
        let texel = |dx: i32, dy: i32, dz: i32| -> [f32; C] {
            let along = |axis: usize, i: i32| border.texel(i, block.size[axis] as i32);
            match (along(0, x.0 + dx), along(1, y.0 + dy), along(2, z.0 + dz)) {
                (Some(i), Some(j), Some(k)) => {
                    let start = ((k * block.size[1] + j) * block.size[0] + i) * C;
                    core::array::from_fn(|c| block.samples[start + c].to_f32())
                }
                _ => constant,
            }
        };
        let slice = |dz| {
            let taps = [texel(0, 0, dz), texel(1, 0, dz), texel(0, 1, dz), texel(1, 1, dz)];
            core::array::from_fn::<f32, C, _>(|k| bilinear(taps.map(|t| t[k]), x.1, y.1))
        };
        let (before, behind) = (slice(0), slice(1));
        core::array::from_fn(|k| before[k] + z.1 * (behind[k] - before[k]))
    }
}

impl Block<f32> {
    fn halved<const C: usize>(&self) -> Self {
        let size = self.size.map(|n| (n / 2).max(1));
        let shares = Shares::new(self.size[2], size[2]);
        let plane = self.size[0] * self.size[1] * C;
        let mut samples = alloc::vec![0.0; size[0] * size[1] * size[2] * C];
        for (k, to) in samples.chunks_exact_mut(size[0] * size[1] * C).enumerate() {
            let (first, shares) = shares.texel(k);
            for (z, share) in (first..).zip(shares) {
                let slice = &self.samples[z * plane..][..plane];
                let reduced =
                    reduce::<f32, C>(slice, [self.size[0], self.size[1]], [size[0], size[1]]);
                for (sum, value) in to.iter_mut().zip(&reduced) {
                    *sum += share * value;
                }
            }
        }
        Self { size, samples }
    }
}
