//! Borrowed pictures.

use crate::error::Error;

use super::taps::Packed;

/// A sample of a picture: `u8` (0 to 255), `u16` (0 to 65,535) or `f32` (any range).
pub trait Sample:
    Copy + Default + Send + Sync + core::fmt::Debug + PartialEq + Into<f32> + Packed + 'static
{
    /// Full light, full opacity: 255, 65,535 or 1.
    const FULL: f32;
    /// Whether samples are integers.
    const IS_INTEGER: bool;

    /// The value as a float: 0 to 255 for `u8`, 0 to 65,535 for `u16`.
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self.into()
    }
    /// The nearest sample: integers round half up and clamp to their range, NaN becomes 0.
    #[must_use]
    #[inline(always)]
    fn from_f32(value: f32) -> Self {
        Self::rounded(value)
    }
}

impl Sample for u8 {
    const FULL: f32 = 255.0;
    const IS_INTEGER: bool = true;
}
impl Sample for u16 {
    const FULL: f32 = 65_535.0;
    const IS_INTEGER: bool = true;
}
impl Sample for f32 {
    const FULL: Self = 1.0;
    const IS_INTEGER: bool = false;
}

/// A picture to read: samples of `C` interleaved channels, rows `stride` samples apart.
///
/// ```
/// use collinear::resample::ImageView;
///
/// // Two rows of three grey pixels, each row padded to four bytes.
/// let bytes = [1u8, 2, 3, 0, 4, 5, 6, 0];
/// let view = ImageView::<u8, 1>::with_stride(&bytes, 3, 2, 4)?;
/// assert_eq!(view.pixel(2, 1), Some([6]));
/// assert_eq!(view.pixel(3, 1), None);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ImageView<'a, T, const C: usize> {
    data: &'a [T],
    width: usize,
    height: usize,
    stride: usize,
}

/// A picture to write: as [`ImageView`].
///
/// ```
/// use collinear::resample::ImageViewMut;
///
/// // The lower right quarter of a picture of 4 × 2 grey pixels.
/// let mut bytes = [0u8; 8];
/// let mut quarter = ImageViewMut::<u8, 1>::with_stride(&mut bytes[4 + 2..], 2, 1, 4)?;
/// quarter.row_mut(0).fill(9);
/// assert_eq!(bytes, [0, 0, 0, 0, 0, 0, 9, 9]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Debug)]
pub struct ImageViewMut<'a, T, const C: usize> {
    data: &'a mut [T],
    width: usize,
    height: usize,
    stride: usize,
}

/// The largest width and height of a picture, which keeps pixel positions within `i32`.
const LARGEST_SIDE: usize = 1 << 30;

/// Checks that the samples hold the picture.
fn check<const C: usize>(
    len: usize,
    width: usize,
    height: usize,
    stride: usize,
) -> Result<(), Error> {
    if C == 0 || C > 4 {
        return Err(Error::OutOfRange { what: "channels", value: C as f64, expected: "1 to 4" });
    }
    for side in [width, height] {
        if side > LARGEST_SIDE {
            return Err(Error::OutOfRange {
                what: "picture side",
                value: side as f64,
                expected: "at most 2³⁰",
            });
        }
    }
    if stride < width * C {
        return Err(Error::LengthMismatch {
            what: "stride and row",
            left: stride,
            right: width * C,
        });
    }
    let needed = match height {
        0 => 0,
        h => stride.checked_mul(h - 1).and_then(|n| n.checked_add(width * C)).unwrap_or(usize::MAX),
    };
    if len < needed {
        return Err(Error::LengthMismatch {
            what: "samples and picture",
            left: len,
            right: needed,
        });
    }
    Ok(())
}

impl<'a, T: Sample, const C: usize> ImageView<'a, T, C> {
    /// A picture whose rows follow each other without padding.
    ///
    /// # Errors
    /// As [`with_stride`](Self::with_stride).
    pub fn new(data: &'a [T], width: usize, height: usize) -> Result<Self, Error> {
        Self::with_stride(data, width, height, width.saturating_mul(C))
    }

    /// A picture whose rows begin `stride` samples apart.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] where the slice is too short or the stride shorter than a row, [`Error::OutOfRange`]
    /// for a side over 2³⁰ or a channel count other than 1 to 4.
    pub fn with_stride(
        data: &'a [T],
        width: usize,
        height: usize,
        stride: usize,
    ) -> Result<Self, Error> {
        check::<C>(data.len(), width, height, stride)?;
        Ok(Self { data, width, height, stride })
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// All samples, and how many lie between the beginnings of two rows.
    #[inline]
    pub(super) fn samples(&self) -> (&'a [T], usize) {
        (self.data, self.stride)
    }

    /// The samples of a row; `None` below the picture.
    pub(super) fn row(&self, y: usize) -> Option<&'a [T]> {
        if y >= self.height {
            return None;
        }
        let start = y * self.stride;
        self.data.get(start..start + self.width * C)
    }

    /// The samples of a pixel; `None` outside the picture.
    #[inline]
    #[must_use]
    pub fn pixel(&self, x: usize, y: usize) -> Option<[T; C]> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let start = y * self.stride + x * C;
        self.data.get(start..start + C)?.first_chunk().copied()
    }
}

impl<'a, T: Sample, const C: usize> ImageViewMut<'a, T, C> {
    /// A picture whose rows follow each other without padding.
    ///
    /// # Errors
    /// As [`ImageView::with_stride`].
    pub fn new(data: &'a mut [T], width: usize, height: usize) -> Result<Self, Error> {
        Self::with_stride(data, width, height, width.saturating_mul(C))
    }

    /// A picture whose rows begin `stride` samples apart.
    ///
    /// # Errors
    /// As [`ImageView::with_stride`].
    pub fn with_stride(
        data: &'a mut [T],
        width: usize,
        height: usize,
        stride: usize,
    ) -> Result<Self, Error> {
        check::<C>(data.len(), width, height, stride)?;
        Ok(Self { data, width, height, stride })
    }

    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// The samples of one row; empty below the picture.
    #[inline]
    #[must_use]
    pub fn row_mut(&mut self, y: usize) -> &mut [T] {
        if y >= self.height {
            return &mut [];
        }
        let start = y * self.stride;
        self.data.get_mut(start..start + self.width * C).unwrap_or_default()
    }

    /// The samples of all rows, the last one without what follows it, and how many lie between the beginnings of two.
    pub(super) fn samples_mut(&mut self) -> (&mut [T], usize) {
        let needed = match self.height {
            0 => 0,
            height => (height - 1) * self.stride + self.width * C,
        };
        (self.data.get_mut(..needed).unwrap_or_default(), self.stride)
    }

    /// The picture to read.
    #[must_use]
    pub fn as_view(&self) -> ImageView<'_, T, C> {
        ImageView { data: self.data, width: self.width, height: self.height, stride: self.stride }
    }
}
