//! `tracks.csv`: which point is seen where.

use std::path::Path;

use crate::error::{Error, ErrorKind, LineProblem};
use crate::json::read_text;

/// What the first line starts with, before the version; the first version has no such line.
const HEADER: &str = "OPENSFM_TRACKS_VERSION_v";

/// A point seen in a photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The photograph's file name.
    pub image: String,
    /// The track: the name of the point in the reconstruction, if it was reconstructed.
    pub track: String,
    /// The number of the feature in the photograph.
    pub feature: i64,
    /// Normalised image coordinates; [`pixel`](Self::pixel) makes pixels of them.
    pub normalized: [f64; 2],
    /// The size of the feature, normalised like the coordinates; zero in files of version 0, which have none.
    pub scale: f64,
    /// Red, green, blue.
    pub color: [u8; 3],
}

impl Observation {
    /// Pixels from the top-left corner of the top-left pixel, in a photograph of this size.
    ///
    /// ```text
    /// pixel = x · max(W, H) + (W/2, H/2)
    /// ```
    #[must_use]
    pub fn pixel(&self, width: u32, height: u32) -> [f64; 2] {
        let size = [f64::from(width), f64::from(height)];
        let longer = size[0].max(size[1]);
        [self.normalized[0] * longer + size[0] / 2.0, self.normalized[1] * longer + size[1] / 2.0]
    }
}

/// Reads a `tracks.csv` of version 0 (no header), 1 or 2.
///
/// # Errors
/// [`ErrorKind::Line`] with the line and field, [`LineProblem::Version`] for a later version.
pub fn read_tracks(path: &Path) -> Result<Vec<Observation>, Error> {
    read_text(path).and_then(|text| parse_tracks(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_tracks`], from text.
///
/// ```
/// let text = "OPENSFM_TRACKS_VERSION_v2\na.jpg\t7\t12\t0.25\t-0.125\t0.001\t155\t145\t143\t-1\t-1\n";
/// let seen = collinear_io::opensfm::parse_tracks(text)?;
/// assert_eq!(seen[0].pixel(400, 300), [300.0, 100.0]);
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_tracks`].
pub fn parse_tracks(text: &str) -> Result<Vec<Observation>, Error> {
    let first = text.lines().next().unwrap_or_default();
    let (version, skip) = match first.strip_prefix(HEADER) {
        None => ("0", 0),
        Some(version) => (version.trim_end(), 1),
    };
    let columns = match version {
        "0" => &["image", "track", "feature", "x", "y", "r", "g", "b"][..],
        "1" => &["image", "track", "feature", "x", "y", "scale", "r", "g", "b"],
        "2" => &[
            "image",
            "track",
            "feature",
            "x",
            "y",
            "scale",
            "r",
            "g",
            "b",
            "segmentation",
            "instance",
        ],
        _ => {
            let expected = "OPENSFM_TRACKS_VERSION_v1 or _v2: write the tracks with one of these";
            return Err(at(1, None, LineProblem::Version { found: first.into(), expected }));
        }
    };
    let mut observations = Vec::new();
    for (i, line) in text.lines().enumerate().skip(skip) {
        if !line.trim().is_empty() {
            observations.push(observation(&Line {
                number: i + 1,
                columns,
                fields: line.split('\t').collect(),
            })?);
        }
    }
    Ok(observations)
}

fn observation(line: &Line<'_>) -> Result<Observation, Error> {
    let (found, expected) = (line.fields.len(), line.columns.len());
    if found != expected {
        return Err(at(line.number, None, LineProblem::FieldCount { found, expected }));
    }
    // A cast saturates: a colour beyond a byte is its nearest byte.
    let byte = |name| line.number(name).map(|v: f64| v.round() as u8);
    Ok(Observation {
        image: line.text("image").into(),
        track: line.text("track").into(),
        feature: line.number("feature")? as i64,
        normalized: [line.number("x")?, line.number("y")?],
        scale: if line.columns.contains(&"scale") { line.number("scale")? } else { 0.0 },
        color: [byte("r")?, byte("g")?, byte("b")?],
    })
}

struct Line<'a> {
    number: usize,
    columns: &'a [&'static str],
    fields: Vec<&'a str>,
}

impl Line<'_> {
    fn text(&self, name: &str) -> &str {
        let field = self.columns.iter().zip(&self.fields).find(|(c, _)| **c == name);
        field.map_or("", |(_, f)| f.trim())
    }

    fn number(&self, name: &str) -> Result<f64, Error> {
        let text = self.text(name);
        match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => {
                let column = self.columns.iter().position(|c| *c == name).map(|c| c + 1);
                let problem = LineProblem::NotANumber { name: name.into(), text: text.into() };
                Err(at(self.number, column, problem))
            }
        }
    }
}

fn at(line: usize, column: Option<usize>, problem: LineProblem) -> Error {
    ErrorKind::Line { line, column, problem }.into()
}
