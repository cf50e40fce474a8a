//! `_RPC.TXT` and OSSIM's keyword lists: a name, a colon, a number.

use std::fmt::Write;

use collinear::camera::rpc::Rpc00b;

use super::RpcFile;
use super::fields::{Fields, Names, short};
use crate::error::{Error, RpcProblem};

pub(super) const TXT: Names = Names {
    scalars: [
        "LINE_OFF",
        "SAMP_OFF",
        "LAT_OFF",
        "LONG_OFF",
        "HEIGHT_OFF",
        "LINE_SCALE",
        "SAMP_SCALE",
        "LAT_SCALE",
        "LONG_SCALE",
        "HEIGHT_SCALE",
        "ERR_BIAS",
        "ERR_RAND",
    ],
    polynomials: ["LINE_NUM_COEFF", "LINE_DEN_COEFF", "SAMP_NUM_COEFF", "SAMP_DEN_COEFF"],
    first: 1,
};

const GEOM: Names = Names {
    scalars: [
        "line_off",
        "samp_off",
        "lat_off",
        "long_off",
        "height_off",
        "line_scale",
        "samp_scale",
        "lat_scale",
        "long_scale",
        "height_scale",
        "bias_error",
        "rand_error",
    ],
    polynomials: ["line_num_coeff", "line_den_coeff", "samp_num_coeff", "samp_den_coeff"],
    first: 0,
};

/// The unit of each scalar of [`TXT`].
const UNITS: [&str; 12] = [
    "pixels", "pixels", "degrees", "degrees", "meters", "pixels", "pixels", "degrees", "degrees",
    "meters", "meters", "meters",
];

/// Parses an `_RPC.TXT` (GeoEye, Ikonos, GDAL): lines `NAME: number unit`, the unit perhaps missing.
///
/// Other names are passed over.
///
/// # Errors
/// As [`read`](super::read).
pub fn parse_rpc_txt(text: &str) -> Result<RpcFile, Error> {
    let mut fields = Fields::new(&TXT);
    for (line, name, value) in statements(text) {
        let mut words = value.split_whitespace();
        let (number, unit) = (words.next().unwrap_or_default(), words.next());
        if fields.scalar(name, line, number)? {
            check_unit(name, line, unit)?;
        } else {
            fields.coefficient(name, line, number)?;
        }
    }
    if !fields.any() {
        return Err(RpcProblem::NotAnRpc.into());
    }
    fields.finish(|p| *p)
}

/// Parses an OSSIM keyword list of a rational polynomial camera: lines `name: value`.
///
/// # Errors
/// As [`read`](super::read); [`RpcProblem::Convention`] for a `polynomial_format` that is neither A nor B.
pub fn parse_geom(text: &str) -> Result<RpcFile, Error> {
    let mut fields = Fields::new(&GEOM);
    let mut older = false;
    for (line, name, value) in statements(text) {
        let value = value.trim();
        if name == "polynomial_format" {
            older = match value {
                "A" => true,
                "B" => false,
                other => {
                    let (field, found) = (name.to_owned(), short(other));
                    let expected = "A or B";
                    return Err(RpcProblem::Convention { line, field, found, expected }.into());
                }
            };
        } else if !fields.scalar(name, line, value)? {
            fields.coefficient(name, line, value)?;
        }
    }
    if !fields.any() {
        return Err(RpcProblem::NotAnRpc.into());
    }
    fields.finish(|p| if older { Rpc00b::from_rpc00a_order(p) } else { *p })
}

/// The lines with a colon or an equals sign: number from 1, name, value.
fn statements(text: &str) -> impl Iterator<Item = (usize, &str, &str)> {
    text.lines().enumerate().filter_map(|(i, line)| {
        let (name, value) = line.split_once([':', '='])?;
        Some((i + 1, name.trim(), value))
    })
}

/// Feet would be taken for metres.
fn check_unit(name: &str, line: usize, unit: Option<&str>) -> Result<(), Error> {
    let needed = TXT.scalars.iter().zip(UNITS).find(|(n, _)| **n == name).map(|(_, u)| u);
    let (Some(needed), Some(unit)) = (needed, unit) else { return Ok(()) };
    let lower = unit.to_ascii_lowercase();
    let (known, expected): (&[&str], _) = match needed {
        "pixels" => (&["pixels", "pixel", "px", "lines", "samples"], "pixels"),
        "degrees" => (&["degrees", "degree", "deg"], "degrees"),
        _ => (&["meters", "meter", "metres", "metre", "m"], "meters"),
    };
    if known.contains(&lower.as_str()) {
        return Ok(());
    }
    let (field, found) = (format!("the unit of {name}"), short(unit));
    Err(RpcProblem::Convention { line, field, found, expected }.into())
}

pub(super) fn to_rpc_txt(file: &RpcFile) -> String {
    let (scalars, polynomials) = numbers(file);
    let mut text = String::new();
    for ((name, unit), value) in TXT.scalars.iter().zip(UNITS).zip(scalars) {
        if let Some(value) = value {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name}: {value:e} {unit}");
        }
    }
    for (name, polynomial) in TXT.polynomials.iter().zip(polynomials) {
        for (i, value) in polynomial.iter().enumerate() {
            let _ = writeln!(text, "{name}_{}: {value:e}", i + 1);
        }
    }
    text
}

/// The numbers in the order of [`Names`].
pub(super) fn numbers(f: &RpcFile) -> ([Option<f64>; 12], [&[f64; 20]; 4]) {
    let scalars = [
        f.line_offset,
        f.sample_offset,
        f.latitude_offset_deg,
        f.longitude_offset_deg,
        f.height_offset,
        f.line_scale,
        f.sample_scale,
        f.latitude_scale_deg,
        f.longitude_scale_deg,
        f.height_scale,
    ];
    let mut all = [f.error_bias; 12];
    for (slot, value) in all.iter_mut().zip(scalars) {
        *slot = Some(value);
    }
    all[11] = f.error_random;
    let polynomials =
        [&f.line_numerator, &f.line_denominator, &f.sample_numerator, &f.sample_denominator];
    (all, polynomials)
}
