//! Scanner files: a camera that moves while it exposes.

use serde::{Deserialize, Serialize};

use crate::camera::{Exterior, Interior};
use crate::check::{all_in_range, finite, in_range};
use crate::error::{FieldError, FieldProblem};
use crate::json::Document;
use crate::json::object::{self, Object};

/// The largest magnitude of a row, in pixels.
const FARTHEST_PIXEL: f64 = 1e9;

/// A scanning camera as its file states it. Fields, units and defaults: `docs/formats.md`, "scanner".
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
/// use collinear_io::Document;
/// use collinear_io::scanner::ScannerFile;
///
/// // 600 up, a line each 0.2 along y, c = 1000 px.
/// let file = ScannerFile::parse(
///     r#"{ "collinear": "scanner", "version": 1, "width": 1000, "height": 2000,
///     "scan": { "kind": "pushbroom", "row": 0.5, "per_line": 1 },
///     "interior": { "model": "pinhole", "principal_distance": [1000, 1000], "principal_point": [500, 0.5] },
///     "trajectory": {
///         "exterior": { "projection_center": [0, 0, 600], "rotation_matrix": [[-1, 0, 0], [0, 1, 0], [0, 0, -1]] },
///         "position_polynomial": [[0, 0, 0], [0, 0.2, 0]]
///     } }"#,
/// )?;
/// let image = file.sensor()?.project(&Point3::new(-60.0, 12.0, 0.0))?;
/// assert!((image - Point2::new(600.0, 60.0)).norm() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScannerFile {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Which pixel is exposed when.
    pub scan: Scan,
    /// From camera axes to pixels.
    pub interior: Interior,
    /// From world to camera axes at each time.
    pub trajectory: TrajectoryFile,
}

/// Which pixel is exposed when. Times are in the trajectory's unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Object<RawScan>", into = "RawScan")]
pub struct Scan {
    /// What scans.
    pub kind: ScanKind,
    /// The time of x = 0, y = 0.
    pub start: f64,
    /// How far beyond the picture a point is looked for, pixels along the scan.
    pub margin: f64,
}

/// What scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ScanKind {
    /// A line of detectors at y = `row` of the interior orientation, or film drawn past a slit.
    Line {
        /// A film rather than detectors; the equations are the same.
        strip: bool,
        /// Pixels.
        row: f64,
        /// The time of a line.
        per_line: f64,
    },
    /// A mirror.
    Whiskbroom {
        /// Pixels.
        row: f64,
        /// The time of a column.
        per_column: f64,
        /// The time of a line.
        per_line: f64,
    },
    /// A rotating slit.
    Panoramic {
        /// The time of a column.
        per_column: f64,
        /// p of the image motion compensation.
        compensation: f64,
    },
    /// A frame that is read line by line.
    RollingShutter {
        /// The time of a line.
        per_line: f64,
    },
}

/// A pose for each time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Object<RawTrajectory>", into = "RawTrajectory")]
pub struct TrajectoryFile {
    /// What the polynomials move.
    pub base: TrajectoryBase,
    /// t₀ of the polynomials.
    pub reference_time: f64,
    /// T of the polynomials, whose variable is (t − t₀)/T.
    pub time_unit: f64,
    /// What is added to the projection centre: a vector a power, world units and axes.
    pub position_polynomial: Vec<[f64; 3]>,
    /// The rotation vector by which the camera is turned: a vector a power, radians, camera axes.
    pub attitude_polynomial: Vec<[f64; 3]>,
}

/// What a trajectory's polynomials move.
#[derive(Clone, Debug, PartialEq)]
pub enum TrajectoryBase {
    /// A pose that stands still.
    Exterior(Exterior),
    /// A table.
    Ephemeris(EphemerisFile),
}

/// Positions and attitudes at given times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EphemerisFile {
    /// Times of the positions, ascending.
    pub position_times: Vec<f64>,
    /// Projection centres, world coordinates.
    pub positions: Vec<[f64; 3]>,
    /// Nodes of Lagrange's polynomial; without it straight lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_nodes: Option<u32>,
    /// Times of the attitudes, ascending.
    pub attitude_times: Vec<f64>,
    /// w, x, y, z of `camera_from_world`, of length one within 10⁻³.
    pub quaternions_wxyz: Vec<[f64; 4]>,
    /// Nodes of Lagrange's polynomial; without it great circles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attitude_nodes: Option<u32>,
}

impl Document for ScannerFile {
    const KIND: &'static str = "scanner";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        for (field, size) in [("width", self.width), ("height", self.height)] {
            in_range(field, size.into(), "at least 1 pixel", |v| v >= 1.0)?;
        }
        self.scan.check().map_err(|e| e.under("scan"))?;
        self.interior.check().map_err(|e| e.under("interior"))?;
        let unsupported = |expected| {
            let problem =
                FieldProblem::Unsupported { found: self.interior.model().into(), expected };
            Err(FieldError::new("interior.model", problem))
        };
        match (&self.interior, &self.scan.kind) {
            (Interior::Orthographic { .. }, _) => {
                return unsupported("a model with a projection centre");
            }
            (Interior::Panorama { projection, .. }, ScanKind::Panoramic { .. })
                if *projection == collinear::camera::Panorama::Cylindrical => {}
            (_, ScanKind::Panoramic { .. }) => {
                return unsupported("`cylindrical`: a slit that turns exposes a cylinder");
            }
            _ => {}
        }
        self.trajectory.check().map_err(|e| e.under("trajectory"))
    }
}

impl Scan {
    fn check(&self) -> Result<(), FieldError> {
        let time = |field, value| in_range(field, value, "a finite number", |_| true);
        let step = |field, value| in_range(field, value, "a number other than 0", |v| v != 0.0);
        let pixels = |row| {
            let expected = "a number from -1e9 to 1e9 (pixels)";
            in_range("row", row, expected, |v| v.abs() <= FARTHEST_PIXEL)
        };
        time("start", self.start)?;
        let expected = "a number from 0 to 1e9 (pixels)";
        in_range("margin", self.margin, expected, |v| (0.0..=FARTHEST_PIXEL).contains(&v))?;
        match self.kind {
            ScanKind::Line { row, per_line, .. } => {
                pixels(row)?;
                step("per_line", per_line)
            }
            ScanKind::Whiskbroom { row, per_column, per_line } => {
                pixels(row)?;
                time("per_column", per_column)?;
                step("per_line", per_line)
            }
            ScanKind::Panoramic { per_column, compensation } => {
                step("per_column", per_column)?;
                time("compensation", compensation)
            }
            ScanKind::RollingShutter { per_line } => step("per_line", per_line),
        }
    }
}

impl TrajectoryFile {
    fn check(&self) -> Result<(), FieldError> {
        match &self.base {
            TrajectoryBase::Exterior(exterior) => exterior.check().map_err(|e| e.under("exterior")),
            TrajectoryBase::Ephemeris(table) => table.check().map_err(|e| e.under("ephemeris")),
        }?;
        in_range("reference_time", self.reference_time, "a finite number", |_| true)?;
        in_range("time_unit", self.time_unit, "a number other than 0", |v| v != 0.0)?;
        vectors("position_polynomial", &self.position_polynomial)?;
        vectors("attitude_polynomial", &self.attitude_polynomial)
    }
}

fn vectors(field: &str, values: &[[f64; 3]]) -> Result<(), FieldError> {
    values.iter().enumerate().try_for_each(|(i, v)| finite(&format!("{field}[{i}]"), v))
}

impl EphemerisFile {
    fn check(&self) -> Result<(), FieldError> {
        for (times, values, of, found) in [
            (&self.position_times, "positions", "`position_times`", self.positions.len()),
            (
                &self.attitude_times,
                "quaternions_wxyz",
                "`attitude_times`",
                self.quaternions_wxyz.len(),
            ),
        ] {
            if found != times.len() {
                let expected = times.len();
                return Err(FieldError::new(values, FieldProblem::Count { found, expected, of }));
            }
        }
        let any = |_| true;
        all_in_range("position_times", &self.position_times, "a finite number", any)?;
        all_in_range("attitude_times", &self.attitude_times, "a finite number", any)?;
        vectors("positions", &self.positions)?;
        for (i, q) in self.quaternions_wxyz.iter().enumerate() {
            crate::camera::check_quaternion(&format!("quaternions_wxyz[{i}]"), q)?;
        }
        Ok(())
    }
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum RawKind {
    Pushbroom,
    Strip,
    Whiskbroom,
    Panoramic,
    RollingShutter,
}

impl RawKind {
    fn name(self) -> &'static str {
        match self {
            Self::Pushbroom => "pushbroom",
            Self::Strip => "strip",
            Self::Whiskbroom => "whiskbroom",
            Self::Panoramic => "panoramic",
            Self::RollingShutter => "rolling_shutter",
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScan {
    kind: RawKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    row: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    per_line: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    per_column: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    compensation: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    margin: Option<f64>,
}

impl TryFrom<Object<RawScan>> for Scan {
    type Error = String;

    fn try_from(Object(raw): Object<RawScan>) -> Result<Self, String> {
        let (start, margin) = (raw.start.unwrap_or(0.0), raw.margin.unwrap_or(0.0));
        let name = raw.kind.name();
        let needed = |value: Option<f64>, field: &str| {
            value.ok_or_else(|| format!("a scan `{name}` needs `{field}`"))
        };
        let kind = match raw.kind {
            RawKind::Pushbroom | RawKind::Strip => ScanKind::Line {
                strip: matches!(raw.kind, RawKind::Strip),
                row: needed(raw.row, "row")?,
                per_line: needed(raw.per_line, "per_line")?,
            },
            RawKind::Whiskbroom => ScanKind::Whiskbroom {
                row: needed(raw.row, "row")?,
                per_column: needed(raw.per_column, "per_column")?,
                per_line: needed(raw.per_line, "per_line")?,
            },
            RawKind::Panoramic => ScanKind::Panoramic {
                per_column: needed(raw.per_column, "per_column")?,
                compensation: raw.compensation.unwrap_or(0.0),
            },
            RawKind::RollingShutter => {
                ScanKind::RollingShutter { per_line: needed(raw.per_line, "per_line")? }
            }
        };
        let scan = Self { kind, start, margin };
        let own = RawScan::from(scan);
        for (field, given, has) in [
            ("row", raw.row, own.row),
            ("per_line", raw.per_line, own.per_line),
            ("per_column", raw.per_column, own.per_column),
            ("compensation", raw.compensation, own.compensation),
        ] {
            if given.is_some() && has.is_none() {
                return Err(format!("a scan `{name}` has no `{field}`"));
            }
        }
        Ok(scan)
    }
}

impl From<Scan> for RawScan {
    fn from(Scan { kind, start, margin }: Scan) -> Self {
        let empty = |kind| Self {
            kind,
            row: None,
            start: Some(start),
            per_line: None,
            per_column: None,
            compensation: None,
            margin: (margin != 0.0).then_some(margin),
        };
        match kind {
            ScanKind::Line { strip, row, per_line } => Self {
                row: Some(row),
                per_line: Some(per_line),
                ..empty(if strip { RawKind::Strip } else { RawKind::Pushbroom })
            },
            ScanKind::Whiskbroom { row, per_column, per_line } => Self {
                row: Some(row),
                per_column: Some(per_column),
                per_line: Some(per_line),
                ..empty(RawKind::Whiskbroom)
            },
            ScanKind::Panoramic { per_column, compensation } => Self {
                per_column: Some(per_column),
                compensation: Some(compensation),
                ..empty(RawKind::Panoramic)
            },
            ScanKind::RollingShutter { per_line } => {
                Self { per_line: Some(per_line), ..empty(RawKind::RollingShutter) }
            }
        }
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTrajectory {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    exterior: Option<Exterior>,
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "object::optional"
    )]
    ephemeris: Option<EphemerisFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference_time: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    time_unit: Option<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    position_polynomial: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    attitude_polynomial: Vec<[f64; 3]>,
}

impl TryFrom<Object<RawTrajectory>> for TrajectoryFile {
    type Error = &'static str;

    fn try_from(Object(raw): Object<RawTrajectory>) -> Result<Self, Self::Error> {
        Ok(Self {
            base: match (raw.exterior, raw.ephemeris) {
                (Some(exterior), None) => TrajectoryBase::Exterior(exterior),
                (None, Some(table)) => TrajectoryBase::Ephemeris(table),
                (None, None) => return Err("a trajectory needs `exterior` or `ephemeris`"),
                (Some(_), Some(_)) => {
                    return Err("a trajectory has one of `exterior` and `ephemeris`, found both");
                }
            },
            reference_time: raw.reference_time.unwrap_or(0.0),
            time_unit: raw.time_unit.unwrap_or(1.0),
            position_polynomial: raw.position_polynomial,
            attitude_polynomial: raw.attitude_polynomial,
        })
    }
}

impl From<TrajectoryFile> for RawTrajectory {
    fn from(file: TrajectoryFile) -> Self {
        let (exterior, ephemeris) = match file.base {
            TrajectoryBase::Exterior(exterior) => (Some(exterior), None),
            TrajectoryBase::Ephemeris(table) => (None, Some(table)),
        };
        Self {
            exterior,
            ephemeris,
            reference_time: (file.reference_time != 0.0).then_some(file.reference_time),
            time_unit: (file.time_unit != 1.0).then_some(file.time_unit),
            position_polynomial: file.position_polynomial,
            attitude_polynomial: file.attitude_polynomial,
        }
    }
}
