//! Rational polynomial cameras: a JSON document of the program's own, and the files of vendors and other programs.
//!
//! | format | read by its | lines and samples count from |
//! | --- | --- | --- |
//! | JSON, `docs/formats.md` | header | the centre of the first pixel at 0 |
//! | DigitalGlobe `.RPB` | `BEGIN_GROUP` | the same |
//! | `_RPC.TXT` of GeoEye, Ikonos and GDAL | `LINE_OFF` | the same |
//! | OSSIM `.geom` | `line_off`, `polynomial_format` | the same |
//! | DIMAP 2, Pléiades and SPOT 6, 7 | XML, `Inverse_Model` | the centre of the first pixel at 1 |
//! | DIMAP 3, Pléiades Neo | XML, `GroundtoImage_Values` | what the file says: 0 or 1 |
//! | GDAL's `.vrt` and `.aux.xml` | XML, `Metadata domain="RPC"` | at 0 |
//! | GeoTIFF, tag 50844 | its first bytes | at 0 |
//!
//! [`read`] tells them by their content, whatever their extension. An [`RpcFile`] always counts from 0 at the centre of
//! the first pixel; [`RpcFile::rpc`] crosses to the library's pixels. RPC00A, where the file says so, is brought to the
//! order of RPC00B.

mod dimap;
mod fields;
mod geotiff;
mod rpb;
mod text;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use collinear::camera::rpc::{ImageCorrection, Rpc, Rpc00b, RpcSensor};
use collinear::geometry::geodetic::{
    EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame,
};
use collinear::nalgebra::{Matrix2, Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::atomic::write_atomically;
use crate::check::{finite, in_range};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, RpcProblem};
use crate::json::{Document, object, read_bytes, read_rest};

pub use dimap::parse_xml;
pub use geotiff::read_geotiff;
pub use rpb::parse_rpb;
pub use text::{parse_geom, parse_rpc_txt};

/// A rational polynomial camera as a file states it. Fields, units and defaults: `docs/formats.md`, "rpc".
///
/// ```
/// use collinear_io::rpc::parse_rpc_txt;
///
/// let error = parse_rpc_txt("LINE_OFF: 4199.0 pixels\nSAMP_OFF: many pixels\n").unwrap_err();
/// assert_eq!(error.to_string(), "line 2: SAMP_OFF is `many`, expected a finite number");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RpcFile {
    /// Pixels, from the centre of the first one.
    pub line_offset: f64,
    /// Pixels, from the centre of the first one.
    pub sample_offset: f64,
    /// Degrees, north positive.
    pub latitude_offset_deg: f64,
    /// Degrees, east positive.
    pub longitude_offset_deg: f64,
    /// Metres above the WGS84 ellipsoid.
    pub height_offset: f64,
    /// Pixels.
    pub line_scale: f64,
    /// Pixels.
    pub sample_scale: f64,
    /// Degrees.
    pub latitude_scale_deg: f64,
    /// Degrees.
    pub longitude_scale_deg: f64,
    /// Metres.
    pub height_scale: f64,
    /// In the order of RPC00B.
    pub line_numerator: [f64; 20],
    /// In the order of RPC00B.
    pub line_denominator: [f64; 20],
    /// In the order of RPC00B.
    pub sample_numerator: [f64; 20],
    /// In the order of RPC00B.
    pub sample_denominator: [f64; 20],
    /// Metres, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_bias: Option<f64>,
    /// Metres, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_random: Option<f64>,
    /// What control points added.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "object::optional"
    )]
    pub correction: Option<Correction>,
    /// Width of the picture, pixels, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Height of the picture, pixels, where it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// The Cartesian world that the camera is to stand in, where there is one.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "object::optional"
    )]
    pub world: Option<World>,
}

/// A Cartesian frame on WGS84.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "frame", rename_all = "snake_case", deny_unknown_fields)]
pub enum World {
    /// Geocentric coordinates.
    Geocentric {},
    /// x to the east, y to the north, z up, from a place.
    EastNorthUp {
        /// Degrees, north positive.
        latitude_deg: f64,
        /// Degrees, east positive.
        longitude_deg: f64,
        /// Metres above the ellipsoid.
        height: f64,
    },
}

impl World {
    /// The library's frame.
    ///
    /// # Errors
    /// [`ErrorKind::Library`] for a place that is none.
    pub fn frame(&self) -> Result<EarthFrame, Error> {
        Ok(match *self {
            Self::Geocentric {} => EarthFrame::Geocentric(Ellipsoid::WGS84),
            Self::EastNorthUp { latitude_deg, longitude_deg, height } => {
                let height = EllipsoidalHeight(height);
                let origin = Geodetic::from_degrees(latitude_deg, longitude_deg, height)
                    .map_err(|source| ErrorKind::Library { field: "world".into(), source })?;
                EarthFrame::Local(LocalFrame::east_north_up(Ellipsoid::WGS84, origin))
            }
        })
    }
}

/// An affine correction of the image, p = q + shift + linear (q − about), in pixels from the corner of the first one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correction {
    /// The point about which the linear part acts, pixels.
    pub about: [f64; 2],
    /// Pixels.
    pub shift: [f64; 2],
    /// Two rows of two, pixels a pixel.
    pub linear: [[f64; 2]; 2],
}

/// The longest text that is read: a camera has some kilobytes, a VRT around it some megabytes.
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Reads a rational polynomial camera from a file of any of the [formats](self), told by its content.
///
/// # Errors
/// [`ErrorKind::Rpc`] with the line and the field, those of [`Document`] for JSON, [`ErrorKind::Library`] for numbers
/// that no camera has, [`ErrorKind::Read`], [`ErrorKind::TooLong`], [`ErrorKind::NotText`].
pub fn read(path: &Path) -> Result<RpcFile, Error> {
    read_any(path).map_err(|e| e.in_file(path))
}

/// As [`read`], or `None` where the file is something else: JSON of another kind, any text without a camera's fields, or
/// not there. For callers that read other cameras too, whose reader then says what is wrong.
///
/// # Errors
/// As [`read`], for a file that is a rational polynomial camera's.
pub fn read_if_rpc(path: &Path) -> Result<Option<RpcFile>, Error> {
    let not_one = |e: &Error| match e.kind() {
        ErrorKind::Rpc(RpcProblem::NotAnRpc)
        | ErrorKind::NotOurs { .. }
        | ErrorKind::WrongKind { .. }
        | ErrorKind::Read(_)
        | ErrorKind::NotText { .. }
        | ErrorKind::TooLong { .. } => true,
        // JSON that is broken before it says what it is.
        ErrorKind::Json { .. } => !says_rpc(path),
        _ => false,
    };
    match read(path) {
        Ok(file) => Ok(Some(file)),
        Err(e) if not_one(&e) => Ok(None),
        Err(e) => Err(e),
    }
}

fn says_rpc(path: &Path) -> bool {
    #[derive(Deserialize)]
    struct Header {
        collinear: Option<String>,
    }
    let bytes = read_bytes(path, MAX_TEXT_BYTES).unwrap_or_default();
    let header = serde_json::from_slice::<Header>(&bytes).ok();
    header.and_then(|h| h.collinear).is_some_and(|kind| kind == RpcFile::KIND)
}

fn read_any(path: &Path) -> Result<RpcFile, Error> {
    let mut file = File::open(path).map_err(ErrorKind::Read)?;
    let mut start = [0; 4];
    let known = file.read(&mut start).map_err(ErrorKind::Read)?;
    if known == 4 && geotiff::is_tiff(start) {
        return read_geotiff(&mut file);
    }
    // The rest of the same file: a pipe cannot be opened twice.
    parse(&read_rest(&mut file, start[..known].to_vec(), MAX_TEXT_BYTES)?)
}

/// As [`read`], from the bytes of a text file.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8]) -> Result<RpcFile, Error> {
    let text = std::str::from_utf8(bytes)
        .map_err(|e| ErrorKind::NotText { valid_up_to: e.valid_up_to() })?;
    let text = text.trim_start_matches('\u{feff}');
    let has = |word: &str| text.contains(word);
    match text.trim_start().chars().next() {
        Some('{') => {
            let file = RpcFile::parse(text)?;
            file.rpc()?;
            Ok(file)
        }
        Some('<') => parse_xml(text),
        _ if has("BEGIN_GROUP") || has("lineOffset") => parse_rpb(text),
        _ if has("LINE_OFF") => parse_rpc_txt(text),
        _ if has("polynomial_format") || has("line_off") => parse_geom(text),
        _ => Err(RpcProblem::NotAnRpc.into()),
    }
}

impl RpcFile {
    /// The library's camera, in its own pixels.
    ///
    /// # Errors
    /// [`ErrorKind::Library`] where it refuses the numbers.
    pub fn rpc(&self) -> Result<Rpc, Error> {
        let refused = |field: &str| {
            let field = field.to_owned();
            move |source| ErrorKind::Library { field, source }
        };
        let rpc = Rpc::from_rpc00b(&self.record()).map_err(refused(""))?;
        let Some(c) = &self.correction else { return Ok(rpc) };
        let [[a, b], [d, e]] = c.linear;
        let linear = Matrix2::new(a, b, d, e);
        let correction =
            ImageCorrection::new(Point2::from(c.about), Vector2::from(c.shift), linear)
                .map_err(refused("correction"))?;
        Ok(rpc.with_correction(correction))
    }

    /// The library's sensor in the file's world, and the size of its picture.
    ///
    /// # Errors
    /// [`FieldProblem::NotGiven`] where the file has no `width`, `height` or `world`; as [`rpc`](Self::rpc) and [`World::frame`].
    pub fn sensor(&self) -> Result<RpcSensor, Error> {
        let missing = |field| FieldError::new(field, FieldProblem::NotGiven);
        let world = self.world.ok_or_else(|| missing("world"))?;
        self.size()?;
        Ok(RpcSensor::new(self.rpc()?, world.frame()?))
    }

    /// Width and height of the picture, pixels.
    ///
    /// # Errors
    /// [`FieldProblem::NotGiven`] where the file does not say.
    pub fn size(&self) -> Result<[u32; 2], FieldError> {
        let missing = |field| FieldError::new(field, FieldProblem::NotGiven);
        let width = self.width.ok_or_else(|| missing("width"))?;
        Ok([width, self.height.ok_or_else(|| missing("height"))?])
    }

    /// The file of a camera, with its correction where it has one.
    #[must_use]
    pub fn from_rpc(rpc: &Rpc) -> Self {
        let mut file = Self::from_record(&rpc.to_rpc00b());
        let c = rpc.correction();
        if c != ImageCorrection::none() {
            let m = c.linear();
            let linear = [[m.m11, m.m12], [m.m21, m.m22]];
            file.correction =
                Some(Correction { about: c.about().into(), shift: c.shift().into(), linear });
        }
        file
    }

    fn record(&self) -> Rpc00b {
        Rpc00b {
            line_offset: self.line_offset,
            sample_offset: self.sample_offset,
            latitude_offset_deg: self.latitude_offset_deg,
            longitude_offset_deg: self.longitude_offset_deg,
            height_offset: self.height_offset,
            line_scale: self.line_scale,
            sample_scale: self.sample_scale,
            latitude_scale_deg: self.latitude_scale_deg,
            longitude_scale_deg: self.longitude_scale_deg,
            height_scale: self.height_scale,
            line_numerator: self.line_numerator,
            line_denominator: self.line_denominator,
            sample_numerator: self.sample_numerator,
            sample_denominator: self.sample_denominator,
            error_bias: self.error_bias,
            error_random: self.error_random,
        }
    }

    fn from_record(r: &Rpc00b) -> Self {
        Self {
            line_offset: r.line_offset,
            sample_offset: r.sample_offset,
            latitude_offset_deg: r.latitude_offset_deg,
            longitude_offset_deg: r.longitude_offset_deg,
            height_offset: r.height_offset,
            line_scale: r.line_scale,
            sample_scale: r.sample_scale,
            latitude_scale_deg: r.latitude_scale_deg,
            longitude_scale_deg: r.longitude_scale_deg,
            height_scale: r.height_scale,
            line_numerator: r.line_numerator,
            line_denominator: r.line_denominator,
            sample_numerator: r.sample_numerator,
            sample_denominator: r.sample_denominator,
            error_bias: r.error_bias,
            error_random: r.error_random,
            correction: None,
            width: None,
            height: None,
            world: None,
        }
    }

    /// The text of an `_RPC.TXT`, whose numbers read back to the same bits.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for a number that is not finite, and for a correction, which the format has no place for.
    pub fn to_rpc_txt(&self) -> Result<String, Error> {
        self.check_plain()?;
        Ok(text::to_rpc_txt(self))
    }

    /// Writes an `_RPC.TXT`, atomically.
    ///
    /// # Errors
    /// As [`to_rpc_txt`](Self::to_rpc_txt) and [`write_atomically`].
    pub fn write_rpc_txt(&self, path: &Path) -> Result<(), Error> {
        let text = self.to_rpc_txt().map_err(|e| e.in_file(path))?;
        write_atomically(path, |w| w.write_all(text.as_bytes()))
    }

    /// The text of an RPB, whose numbers read back to the same bits.
    ///
    /// # Errors
    /// As [`to_rpc_txt`](Self::to_rpc_txt).
    pub fn to_rpb(&self) -> Result<String, Error> {
        self.check_plain()?;
        Ok(rpb::to_rpb(self))
    }

    /// Writes an RPB, atomically.
    ///
    /// # Errors
    /// As [`to_rpb`](Self::to_rpb) and [`write_atomically`].
    pub fn write_rpb(&self, path: &Path) -> Result<(), Error> {
        let text = self.to_rpb().map_err(|e| e.in_file(path))?;
        write_atomically(path, |w| w.write_all(text.as_bytes()))
    }

    /// Refuses what only the program's own format can say.
    fn check_plain(&self) -> Result<(), Error> {
        self.check()?;
        if self.correction.is_some() {
            let found = "a correction".to_owned();
            let expected = "this format has no place for it, write JSON or fit the corrected model";
            let problem = FieldProblem::Unsupported { found, expected };
            return Err(FieldError::new("correction", problem).into());
        }
        Ok(())
    }
}

impl Document for RpcFile {
    const KIND: &'static str = "rpc";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        for (field, value) in [
            ("line_offset", self.line_offset),
            ("sample_offset", self.sample_offset),
            ("latitude_offset_deg", self.latitude_offset_deg),
            ("longitude_offset_deg", self.longitude_offset_deg),
            ("height_offset", self.height_offset),
        ] {
            finite(field, &[value])
                .map_err(|e| FieldError { field: field.to_owned(), problem: e.problem })?;
        }
        for (field, value) in [
            ("line_scale", self.line_scale),
            ("sample_scale", self.sample_scale),
            ("latitude_scale_deg", self.latitude_scale_deg),
            ("longitude_scale_deg", self.longitude_scale_deg),
            ("height_scale", self.height_scale),
        ] {
            in_range(field, value, "a finite number above 0", |v| v > 0.0)?;
        }
        for (field, coefficients) in [
            ("line_numerator", &self.line_numerator),
            ("line_denominator", &self.line_denominator),
            ("sample_numerator", &self.sample_numerator),
            ("sample_denominator", &self.sample_denominator),
        ] {
            finite(field, coefficients)?;
        }
        for (field, value) in [("error_bias", self.error_bias), ("error_random", self.error_random)]
        {
            in_range(field, value.unwrap_or(0.0), "a finite number", |_| true)?;
        }
        if let Some(c) = &self.correction {
            finite("correction.about", &c.about)?;
            finite("correction.shift", &c.shift)?;
            finite("correction.linear", &c.linear.concat())?;
        }
        for (field, size) in [("width", self.width), ("height", self.height)] {
            in_range(field, size.unwrap_or(1).into(), "at least 1 pixel", |v| v >= 1.0)?;
        }
        if let Some(World::EastNorthUp { latitude_deg, longitude_deg, height }) = self.world {
            let expected = "from −90 to 90";
            in_range("world.latitude_deg", latitude_deg, expected, |v| v.abs() <= 90.0)?;
            finite("world.longitude_deg", &[longitude_deg])?;
            finite("world.height", &[height])?;
        }
        Ok(())
    }
}
