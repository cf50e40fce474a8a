//! Pictures: PNG, JPEG and TIFF, to plain bytes and back.
//!
//! A picture is recognised by its content, whatever its extension says. It is refused before any pixel is decoded where
//! its header says that it has none, or more than the [`Limits`], and where its end is missing.
//!
//! - Of a TIFF the first picture is read.
//! - Samples of 16 bits are rounded to 8; floats are refused. Palettes become colours. CMYK becomes RGB.
//! - Colour profiles and gamma are passed over: samples are taken as they stand.
//! - The EXIF orientation is **not applied**, only told: a camera's calibration is that of the sensor's rows and columns.

mod header;

use std::io::{self, Cursor, Write};
use std::path::Path;

use image::codecs::jpeg::{JpegDecoder, JpegEncoder};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::codecs::tiff::{TiffDecoder, TiffEncoder};
use image::error::{ImageFormatHint, UnsupportedError, UnsupportedErrorKind};
use image::{ExtendedColorType, ImageDecoder, ImageEncoder, ImageError};

pub use header::PictureFormat;

use crate::atomic::write_atomically;
use crate::error::{Error, ErrorKind, PictureProblem};
use crate::json::read_bytes;

/// The quality of a written JPEG, of 100: no artefacts at a glance, a sixth of the samples' size.
const JPEG_QUALITY: u8 = 92;

/// The longest side that JPEG can state.
const JPEG_SIDE: u32 = 65_535;

/// A picture as its samples: 8 bits each, row by row from the top, the channels of a pixel together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples in a pixel: 1 grey, 2 grey and opacity, 3 red, green and blue, 4 with opacity.
    pub channels: u8,
    /// width × height × channels samples.
    pub data: Vec<u8>,
    /// How the picture should be turned to be looked at, 1 to 8 as EXIF numbers it; 1 is upright. It is not applied, and
    /// not written.
    pub orientation: u8,
}

/// What a reader refuses before it allocates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Pixels.
    pub pixels: u64,
    /// Bytes of the file.
    pub file_bytes: u64,
}

impl Default for Limits {
    /// 2²⁸ pixels (16,384 × 16,384, a gibibyte with opacity) from a file of at most a gibibyte.
    fn default() -> Self {
        Self { pixels: 1 << 28, file_bytes: 1 << 30 }
    }
}

impl Picture {
    fn check(&self) -> Result<(), PictureProblem> {
        let Self { width, height, channels, .. } = *self;
        if width == 0 || height == 0 {
            return Err(PictureProblem::Empty { width, height });
        }
        if !(1..=4).contains(&channels) {
            return Err(PictureProblem::Channels {
                channels,
                format: "a picture",
                allowed: "1 to 4",
            });
        }
        let expected = (u64::from(width) * u64::from(height)).saturating_mul(channels.into());
        if self.data.len() as u64 != expected {
            return Err(PictureProblem::SampleCount { found: self.data.len(), expected });
        }
        Ok(())
    }
}

/// Reads a PNG, JPEG or TIFF file within the default [`Limits`].
///
/// # Errors
/// [`ErrorKind::Picture`], [`ErrorKind::Read`] or [`ErrorKind::TooLong`].
pub fn read_picture(path: &Path) -> Result<Picture, Error> {
    read_picture_within(path, Limits::default())
}

/// Reads a PNG, JPEG or TIFF file within limits of the caller's.
///
/// # Errors
/// As [`read_picture`].
pub fn read_picture_within(path: &Path, limits: Limits) -> Result<Picture, Error> {
    read_bytes(path, limits.file_bytes)
        .and_then(|bytes| decode_picture(&bytes, limits))
        .map_err(|e| e.in_file(path))
}

/// Decodes the bytes of a PNG, JPEG or TIFF file.
///
/// # Errors
/// [`ErrorKind::Picture`].
pub fn decode_picture(bytes: &[u8], limits: Limits) -> Result<Picture, Error> {
    let header = header::read(bytes)?;
    let (width, height) = (header.width, header.height);
    if width == 0 || height == 0 {
        return Err(PictureProblem::Empty { width, height }.into());
    }
    if u64::from(width) * u64::from(height) > limits.pixels {
        let limit = format!("{} pixels", limits.pixels);
        return Err(PictureProblem::TooLarge { width, height, limit }.into());
    }
    let problem = |e: ImageError| damaged(bytes, &e);
    let picture = match header.format {
        PictureFormat::Png => {
            decode(PngDecoder::new(Cursor::new(bytes)).map_err(problem)?).map_err(problem)?
        }
        PictureFormat::Jpeg => {
            decode(JpegDecoder::new(Cursor::new(bytes)).map_err(problem)?).map_err(problem)?
        }
        PictureFormat::Tiff => {
            decode(TiffDecoder::new(Cursor::new(bytes)).map_err(problem)?).map_err(problem)?
        }
    };
    picture.check()?;
    Ok(picture)
}

/// Decodes into one allocation, which a conversion to 8 bits makes shorter.
fn decode(mut decoder: impl ImageDecoder) -> Result<Picture, ImageError> {
    // A broken EXIF block is no reason to refuse the pixels.
    let orientation = decoder.orientation().map_or(1, image::metadata::Orientation::to_exif);
    let (width, height) = decoder.dimensions();
    let (channels, bytes) =
        (decoder.color_type().channel_count(), decoder.color_type().bytes_per_pixel());
    if bytes > 2 * channels {
        let kind = UnsupportedErrorKind::Color(decoder.color_type().into());
        let hint = ImageFormatHint::Unknown;
        return Err(ImageError::Unsupported(UnsupportedError::from_format_and_kind(hint, kind)));
    }
    let length = usize::try_from(decoder.total_bytes()).map_err(|_| {
        let kind = image::error::LimitErrorKind::InsufficientMemory;
        ImageError::Limits(image::error::LimitError::from_kind(kind))
    })?;
    // Zeros from the system cost no memory until they are written: a header alone takes none.
    let mut data = vec![0; length];
    decoder.read_image(&mut data)?;
    if bytes == 2 * channels {
        round_to_8_bits(&mut data);
    }
    Ok(Picture { width, height, channels, data, orientation })
}

/// Samples of 16 bits, in the machine's order, as 8: 255 s / 65,535 = s / 257, rounded. In place.
fn round_to_8_bits(data: &mut Vec<u8>) {
    let count = data.len() / 2;
    for i in 0..count {
        if let Some(&[a, b]) = data.get(2 * i..).and_then(<[u8]>::first_chunk)
            && let Some(sample) = data.get_mut(i)
        {
            *sample = ((u32::from(u16::from_ne_bytes([a, b])) + 128) / 257) as u8;
        }
    }
    data.truncate(count);
    data.shrink_to_fit();
}

fn damaged(bytes: &[u8], error: &ImageError) -> PictureProblem {
    match error {
        ImageError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            PictureProblem::Truncated { bytes: bytes.len() }
        }
        other => PictureProblem::Damaged { reason: other.to_string() },
    }
}

/// Writes a picture as its extension says, atomically. To refuse a wrong extension before any work is done, ask
/// [`PictureFormat::from_path`] first.
///
/// ```
/// use collinear_io::picture::{Picture, read_picture, write_picture};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("ramp.png");
/// let ramp = Picture { width: 4, height: 1, channels: 1, data: vec![0, 85, 170, 255], orientation: 1 };
/// write_picture(&path, &ramp)?;
/// assert_eq!(read_picture(&path)?, ramp);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ErrorKind::Extension`]; [`ErrorKind::Picture`] where the samples do not fill the picture, or the format cannot hold
/// it (JPEG has 1 or 3 channels and sides up to 65,535, TIFF 1, 3 or 4 channels); and as [`write_atomically`].
pub fn write_picture(path: &Path, picture: &Picture) -> Result<(), Error> {
    let format = PictureFormat::from_path(path)?;
    check_for(format, picture).map_err(|e| Error::from(ErrorKind::from(e)).in_file(path))?;
    write_atomically(path, |w| encode(w, format, picture))
}

fn check_for(format: PictureFormat, picture: &Picture) -> Result<(), PictureProblem> {
    picture.check()?;
    let Picture { width, height, channels, .. } = *picture;
    if format == PictureFormat::Tiff && channels == 2 {
        let allowed = "1, 3 or 4: write a PNG, or drop the opacity";
        return Err(PictureProblem::Channels { channels, format: "TIFF", allowed });
    }
    if format == PictureFormat::Jpeg {
        if !matches!(channels, 1 | 3) {
            let allowed = "1 or 3: write a PNG, or drop the opacity";
            return Err(PictureProblem::Channels { channels, format: "JPEG", allowed });
        }
        if width.max(height) > JPEG_SIDE {
            let limit = format!("{JPEG_SIDE} a side in a JPEG");
            return Err(PictureProblem::TooLarge { width, height, limit });
        }
    }
    Ok(())
}

fn encode(w: &mut dyn Write, format: PictureFormat, picture: &Picture) -> io::Result<()> {
    let color = match picture.channels {
        1 => ExtendedColorType::L8,
        2 => ExtendedColorType::La8,
        3 => ExtendedColorType::Rgb8,
        _ => ExtendedColorType::Rgba8,
    };
    let Picture { width, height, data, .. } = picture;
    let result = match format {
        PictureFormat::Png => PngEncoder::new(w).write_image(data, *width, *height, color),
        PictureFormat::Jpeg => {
            JpegEncoder::new_with_quality(w, JPEG_QUALITY).write_image(data, *width, *height, color)
        }
        PictureFormat::Tiff => {
            // Its directory stands behind the pixels and its place before them: it is written back and forth.
            let mut file = Cursor::new(Vec::new());
            let written = TiffEncoder::new(&mut file).write_image(data, *width, *height, color);
            written.and_then(|()| w.write_all(file.get_ref()).map_err(ImageError::IoError))
        }
    };
    result.map_err(|e| match e {
        ImageError::IoError(e) => e,
        other => io::Error::other(other),
    })
}
