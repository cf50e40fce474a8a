//! What lies beyond a picture's edge.

use super::image::Sample;

/// What a filter reads where there is no texel.
///
/// A position further away than 2³⁰ texels, or that is no number, has no value before any border.
///
/// ```
/// use collinear::resample::{Border, Filter, ImageView, sample};
/// use nalgebra::Point2;
///
/// // The second texel left of the row 10, 20, 30, 40.
/// let row = ImageView::<u8, 1>::new(&[10, 20, 30, 40], 4, 1)?;
/// let at = |border| sample(row, &Point2::new(-1.5, 0.5), Filter::Nearest, border);
/// assert_eq!(at(Border::Transparent), None);
/// assert_eq!(at(Border::Constant([7.0; 4])), Some([7]));
/// assert_eq!(at(Border::Clamp), Some([10]));
/// assert_eq!(at(Border::Repeat), Some([30]));
/// assert_eq!(at(Border::Mirror), Some([20]));
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Border {
    /// Nothing is painted for a position outside the picture, [0, width) × [0, height). Within it, taps beyond the edge
    /// read the edge texel.
    #[default]
    Transparent,
    /// Taps beyond the edge read this value (the first channels of it); a position with no map is painted with it.
    #[doc(alias = "BORDER_CONSTANT")]
    Constant([f32; 4]),
    /// Taps beyond the edge read the edge texel.
    #[doc(alias("BORDER_REPLICATE", "CLAMP_TO_EDGE"))]
    Clamp,
    /// The picture is repeated without end.
    #[doc(alias("BORDER_WRAP", "REPEAT"))]
    Repeat,
    /// The picture is repeated, every second time mirrored; the edge texel stands twice.
    #[doc(alias("BORDER_REFLECT", "MIRRORED_REPEAT"))]
    Mirror,
}

impl Border {
    /// The texel that a tap at `i` reads along an axis of `n` ≥ 1 texels; `None` for the constant.
    #[inline]
    pub(super) fn texel(self, i: i32, n: i32) -> Option<usize> {
        match self {
            Self::Constant(_) => (0..n).contains(&i).then_some(i as usize),
            Self::Transparent | Self::Clamp => Some(i.clamp(0, n - 1) as usize),
            Self::Repeat => Some(i.rem_euclid(n) as usize),
            Self::Mirror => {
                let (i, n) = (i64::from(i), i64::from(n));
                let k = i.rem_euclid(2 * n);
                Some(if k < n { k } else { 2 * n - 1 - k } as usize)
            }
        }
    }

    /// Paints pixels that no position is known for: with the constant, and not at all where there is none.
    pub(super) fn fill<T: Sample, const C: usize>(self, pixels: &mut [T]) {
        if let Self::Constant(_) = self {
            pixels.as_chunks_mut::<C>().0.fill(self.constant());
        }
    }

    /// The constant in the picture's own samples; zero for the other borders.
    #[inline]
    pub(super) fn constant<T: Sample, const C: usize>(self) -> [T; C] {
        match self {
            Self::Constant(value) => {
                core::array::from_fn(|k| T::from_f32(value.get(k).copied().unwrap_or(0.0)))
            }
            _ => [T::default(); C],
        }
    }
}
