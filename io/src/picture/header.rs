//! What a picture file says about itself, read without decoding it.

use std::io::Cursor;
use std::path::Path;

use image::ImageDecoder;
use image::codecs::tiff::TiffDecoder;

use crate::error::{Error, ErrorKind, PictureProblem};

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Lossless, 1 to 4 channels.
    Png,
    /// Lossy, 1 or 3 channels.
    Jpeg,
    /// Lossless, 1, 3 or 4 channels.
    Tiff,
}

impl PictureFormat {
    /// The format of an output, by its extension: `.png`, `.jpg`, `.jpeg`, `.tif` or `.tiff` in any case.
    ///
    /// # Errors
    /// [`ErrorKind::Extension`] for any other, or none.
    pub fn from_path(path: &Path) -> Result<Self, Error> {
        let found = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match found.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("jpg" | "jpeg") => Ok(Self::Jpeg),
            Some("tif" | "tiff") => Ok(Self::Tiff),
            _ => {
                let expected = ".png, .jpg, .jpeg, .tif or .tiff";
                Err(Error::from(ErrorKind::Extension { found, expected }).in_file(path))
            }
        }
    }
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) format: PictureFormat,
    pub(super) width: u32,
    pub(super) height: u32,
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG: &[u8] = &[0xff, SOI, 0xff];
/// Little and big endian.
const TIFF: [&[u8]; 2] = [b"II*\0", b"MM\0*"];

/// Format and size; for a JPEG also that its end is there, since its decoder paints what is missing grey.
pub(super) fn read(bytes: &[u8]) -> Result<Header, PictureProblem> {
    let truncated = || PictureProblem::Truncated { bytes: bytes.len() };
    if bytes.starts_with(PNG) {
        let size = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_be_bytes(*b));
        let (width, height) = size(16).zip(size(20)).ok_or_else(truncated)?;
        Ok(Header { format: PictureFormat::Png, width, height })
    } else if bytes.starts_with(JPEG) {
        let (width, height) = jpeg(bytes)?;
        Ok(Header { format: PictureFormat::Jpeg, width, height })
    } else if TIFF.iter().any(|start| bytes.starts_with(start)) {
        let decoder =
            TiffDecoder::new(Cursor::new(bytes)).map_err(|e| super::damaged(bytes, &e))?;
        let (width, height) = decoder.dimensions();
        Ok(Header { format: PictureFormat::Tiff, width, height })
    } else {
        const SHOWN: usize = 8;
        let start: Vec<String> = bytes.iter().take(SHOWN).map(|b| format!("{b:02x}")).collect();
        let start = if start.is_empty() { "nothing".into() } else { start.join(" ") };
        Err(PictureProblem::NotAPicture { start })
    }
}

// Marker bytes, ITU-T T.81 table B.1.
const SOI: u8 = 0xd8;
const EOI: u8 = 0xd9;
const SOS: u8 = 0xda;
const TEM: u8 = 0x01;

/// Walks the markers to the end of the image.
fn jpeg(bytes: &[u8]) -> Result<(u32, u32), PictureProblem> {
    let truncated = || PictureProblem::Truncated { bytes: bytes.len() };
    let byte = |at: usize| bytes.get(at).copied().ok_or_else(truncated);
    let pair = |at: usize| Ok::<_, PictureProblem>(u16::from_be_bytes([byte(at)?, byte(at + 1)?]));
    let mut size = None;
    let mut at = 2;
    loop {
        // To the next marker: past coded data, whose bytes of ff are followed by 00 or by a restart marker, and past
        // fill bytes of ff.
        while byte(at)? != 0xff || matches!(byte(at + 1)?, 0x00 | 0xff | 0xd0..=0xd7) {
            at += 1;
        }
        let marker = byte(at + 1)?;
        at += 2;
        match marker {
            EOI => {
                let reason = "it has no frame header".into();
                return size.ok_or(PictureProblem::Damaged { reason });
            }
            SOI | TEM => {}
            _ => {
                // SOF0 … SOF15 without the tables that share their numbers.
                if matches!(marker, 0xc0..=0xcf)
                    && !matches!(marker, 0xc4 | 0xc8 | 0xcc)
                    && size.is_none()
                {
                    size = Some((pair(at + 5)?.into(), pair(at + 3)?.into()));
                }
                if marker == SOS && size.is_none() {
                    let reason = "a scan stands before the frame header".into();
                    return Err(PictureProblem::Damaged { reason });
                }
                at += usize::from(pair(at)?);
            }
        }
    }
}
