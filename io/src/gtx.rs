//! Geoid grids in GTX, the format of PROJ and NOAA.
//!
//! A header of 40 bytes, big-endian: latitude and longitude of the south-west node and the two steps, degrees (`f64`);
//! rows and columns (`i32`). Then the heights, metres (`f32`), row by row from the south, each row from the west.

use std::path::Path;

use collinear::geometry::geodetic::GeoidLayout;

use crate::error::{Error, ErrorKind, GridProblem};
use crate::json::read_bytes;

/// The height of the geoid above the ellipsoid, at the nodes of a grid of latitude and longitude.
#[derive(Clone, Debug, PartialEq)]
pub struct GtxFile {
    /// Where the nodes lie.
    pub layout: GeoidLayout,
    /// Undulations in metres, row by row from the south, each row from the west; NaN where the grid has none.
    pub undulations_m: Vec<f32>,
}

const HEADER_BYTES: usize = 40;
const VALUE_BYTES: usize = 4;

/// A gibibyte: a grid of one arc minute over the whole earth has 0.9.
const MAX_BYTES: u64 = 1 << 30;

/// What GTX writes where it has no value, and what PROJ takes for the same: some grids have large numbers instead.
const VOID: f32 = -88.8888;
const LARGEST: f32 = 1000.0;

/// Reads a GTX file.
///
/// # Errors
/// [`ErrorKind::Grid`] where the header makes no sense or the length is not what it says.
pub fn read_gtx(path: &Path) -> Result<GtxFile, Error> {
    read_bytes(path, MAX_BYTES).and_then(|b| parse_gtx(&b)).map_err(|e| e.in_file(path))
}

/// As [`read_gtx`], from the bytes of a file.
///
/// # Errors
/// As [`read_gtx`].
pub fn parse_gtx(bytes: &[u8]) -> Result<GtxFile, Error> {
    let too_short = || ErrorKind::from(GridProblem::NoHeader { bytes: bytes.len() });
    let (header, body) = bytes.split_at_checked(HEADER_BYTES).ok_or_else(too_short)?;
    let real = |i: usize| take(header, 8 * i).map(f64::from_be_bytes).ok_or_else(too_short);
    let whole = |i: usize| take(header, 32 + 4 * i).map(i32::from_be_bytes).ok_or_else(too_short);
    let (south, west, latitude_step, longitude_step) = (real(0)?, real(1)?, real(2)?, real(3)?);
    let (rows, columns) = (whole(0)?, whole(1)?);

    // A thousandth of a step: room for steps that are no exact binary number, as an arc minute.
    let slack = |step: f64| 1e-3 * step;
    domain("the south latitude", south, "−90 … 90 degrees", south.abs() <= 90.0)?;
    domain("the west longitude", west, "−360 … 360 degrees", west.abs() <= 360.0)?;
    let step = "above 0 and up to 90 degrees";
    domain("the latitude step", latitude_step, step, latitude_step > 0.0 && latitude_step <= 90.0)?;
    domain(
        "the longitude step",
        longitude_step,
        step,
        longitude_step > 0.0 && longitude_step <= 90.0,
    )?;
    let count = "at least 2";
    domain("the number of rows", rows.into(), count, rows >= 2)?;
    domain("the number of columns", columns.into(), count, columns >= 2)?;
    let north = south + f64::from(rows - 1) * latitude_step;
    domain("the north latitude", north, "up to 90 degrees", north <= 90.0 + slack(latitude_step))?;
    let width = f64::from(columns - 1) * longitude_step;
    // The last column may repeat the first.
    domain("the width", width, "up to 360 degrees", width <= 360.0 + slack(longitude_step))?;

    let expected =
        u64::from(rows.unsigned_abs()) * u64::from(columns.unsigned_abs()) * VALUE_BYTES as u64
            + HEADER_BYTES as u64;
    if bytes.len() as u64 != expected {
        return Err(
            GridProblem::FileLength { bytes: bytes.len() as u64, rows, columns, expected }.into()
        );
    }
    let undulations_m = body
        .chunks_exact(VALUE_BYTES)
        .map(|b| take(b, 0).map_or(f32::NAN, |v| undulation(f32::from_be_bytes(v))))
        .collect();
    let layout = GeoidLayout {
        south_deg: south,
        west_deg: west,
        latitude_step_deg: latitude_step,
        longitude_step_deg: longitude_step,
        rows: rows.unsigned_abs() as usize,
        columns: columns.unsigned_abs() as usize,
    };
    Ok(GtxFile { layout, undulations_m })
}

fn undulation(value: f32) -> f32 {
    let valid = value != VOID && value.abs() <= LARGEST;
    if valid { value } else { f32::NAN }
}

fn take<const N: usize>(bytes: &[u8], from: usize) -> Option<[u8; N]> {
    bytes.get(from..)?.first_chunk().copied()
}

fn domain(
    what: &'static str,
    value: f64,
    expected: &'static str,
    inside: bool,
) -> Result<(), GridProblem> {
    if inside { Ok(()) } else { Err(GridProblem::Header { what, value, expected }) }
}
