//! The camera of a GeoTIFF: tag 50844, RPCCoefficientTag.
//!
//! One directory is read and one tag of it, at most some hundred kilobytes of a picture of any size. A TIFF library would
//! bring decoders of pixels, which this needs none of.

use std::io::{ErrorKind as IoKind, Read, Seek, SeekFrom};

use super::RpcFile;
use crate::error::{Error, ErrorKind, RpcProblem};
use collinear::camera::rpc::Rpc00b;

const TAG: u16 = 50844;
const DOUBLE: u16 = 12;
const VALUES: u64 = 92;

/// More tags than any directory has.
const MAX_TAGS: u64 = 4096;

/// The byte order and the size of offsets.
#[derive(Clone, Copy)]
struct Layout {
    little: bool,
    big_tiff: bool,
}

/// Whether a file with these first bytes is a TIFF, of either byte order and offset size.
pub(super) fn is_tiff(start: [u8; 4]) -> bool {
    layout(start).is_some()
}

fn layout(start: [u8; 4]) -> Option<Layout> {
    let (little, version) = match start {
        [b'I', b'I', a, b] => (true, u16::from_le_bytes([a, b])),
        [b'M', b'M', a, b] => (false, u16::from_be_bytes([a, b])),
        _ => return None,
    };
    matches!(version, 42 | 43).then_some(Layout { little, big_tiff: version == 43 })
}

/// Reads the camera of a GeoTIFF, classic or BigTIFF, from the first directory.
///
/// The tag has 92 numbers: the two errors, the offsets and scales in the order line, sample, latitude, longitude, height,
/// and the four polynomials (<https://geotiff.maptools.org/rpc_prop.html>). An error below zero is an unknown one.
///
/// # Errors
/// [`RpcProblem::Tiff`] and [`RpcProblem::TiffCutOff`], [`ErrorKind::Library`], [`ErrorKind::Read`].
pub fn read_geotiff(file: &mut (impl Read + Seek)) -> Result<RpcFile, Error> {
    let start: [u8; 4] = bytes(file, "header", 0)?;
    let Some(layout) = layout(start) else { return Err(RpcProblem::NotAnRpc.into()) };
    let directory = if layout.big_tiff {
        let sizes: [u8; 4] = bytes(file, "header", 4)?;
        let size = layout.whole(&sizes[..2]);
        if size != 8 {
            let (what, expected) = ("size of offsets", "8");
            return Err(RpcProblem::Tiff { what, found: size, expected }.into());
        }
        layout.whole(&bytes::<8>(file, "header", 8)?)
    } else {
        layout.whole(&bytes::<4>(file, "header", 4)?)
    };
    let (head, entry) = if layout.big_tiff { (8, 20) } else { (2, 12) };
    let what = "directory";
    let count = if layout.big_tiff {
        layout.whole(&bytes::<8>(file, what, directory)?)
    } else {
        layout.whole(&bytes::<2>(file, what, directory)?)
    };
    if count > MAX_TAGS {
        let (what, expected) = ("number of tags", "4096 at most");
        return Err(RpcProblem::Tiff { what, found: count, expected }.into());
    }
    for i in 0..count {
        let at = directory.saturating_add(head + i * entry);
        let fields: [u8; 4] = bytes(file, what, at)?;
        if layout.whole(&fields[..2]) != u64::from(TAG) {
            continue;
        }
        let kind = layout.whole(&fields[2..]);
        let (found, values) = if layout.big_tiff {
            (
                layout.whole(&bytes::<8>(file, what, at + 4)?),
                bytes::<8>(file, what, at + 12)?.to_vec(),
            )
        } else {
            (
                layout.whole(&bytes::<4>(file, what, at + 4)?),
                bytes::<4>(file, what, at + 8)?.to_vec(),
            )
        };
        if kind != u64::from(DOUBLE) {
            let (what, expected) = ("type of tag 50844", "12, doubles");
            return Err(RpcProblem::Tiff { what, found: kind, expected }.into());
        }
        if found != VALUES {
            let (what, expected) = ("number of values of tag 50844", "92");
            return Err(RpcProblem::Tiff { what, found, expected }.into());
        }
        let numbers: [u8; 8 * VALUES as usize] = bytes(file, "tag 50844", layout.whole(&values))?;
        return camera(layout, &numbers);
    }
    let (what, expected) = ("number of cameras (tag 50844)", "one");
    Err(RpcProblem::Tiff { what, found: 0, expected }.into())
}

impl Layout {
    /// A whole number of up to eight bytes.
    fn whole(self, bytes: &[u8]) -> u64 {
        let add = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
        if self.little { bytes.iter().rev().fold(0, add) } else { bytes.iter().fold(0, add) }
    }
}

fn bytes<const N: usize>(
    file: &mut (impl Read + Seek),
    what: &'static str,
    offset: u64,
) -> Result<[u8; N], Error> {
    let mut found = [0; N];
    let cut_off = || Error::from(RpcProblem::TiffCutOff { what, offset });
    // Past the largest offset that a file can have.
    if i64::try_from(offset).is_err() {
        return Err(cut_off());
    }
    file.seek(SeekFrom::Start(offset)).map_err(ErrorKind::Read)?;
    match file.read_exact(&mut found) {
        Ok(()) => Ok(found),
        Err(e) if e.kind() == IoKind::UnexpectedEof => Err(cut_off()),
        Err(e) => Err(ErrorKind::Read(e).into()),
    }
}

fn camera(layout: Layout, bytes: &[u8]) -> Result<RpcFile, Error> {
    let mut v = [0.0; VALUES as usize];
    for (value, b) in v.iter_mut().zip(bytes.chunks_exact(8)) {
        *value = f64::from_bits(layout.whole(b));
    }
    let polynomial = |from: usize| core::array::from_fn(|i| v[from + i]);
    let file = RpcFile::from_record(&Rpc00b {
        error_bias: Some(v[0]).filter(|e| !(*e < 0.0)),
        error_random: Some(v[1]).filter(|e| !(*e < 0.0)),
        line_offset: v[2],
        sample_offset: v[3],
        latitude_offset_deg: v[4],
        longitude_offset_deg: v[5],
        height_offset: v[6],
        line_scale: v[7],
        sample_scale: v[8],
        latitude_scale_deg: v[9],
        longitude_scale_deg: v[10],
        height_scale: v[11],
        line_numerator: polynomial(12),
        line_denominator: polynomial(32),
        sample_numerator: polynomial(52),
        sample_denominator: polynomial(72),
    });
    file.rpc()?;
    Ok(file)
}
