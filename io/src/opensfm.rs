//! OpenSfM: `reconstruction.json` and `tracks.csv`.
//!
//! OpenSfM's image coordinates are normalised: the origin is the middle of the picture and one unit is its longer side,
//!
//! ```text
//! pixel = x · max(W, H) + (W/2, H/2)
//! ```
//!
//! in pixels from the top-left corner of the top-left pixel. Its camera axes are this crate's: x right, y down,
//! z forward. Format: <https://opensfm.org/docs/dataset.html>.

mod tracks;

use std::collections::BTreeMap;
use std::path::Path;

use collinear::nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;

pub use tracks::{Observation, parse_tracks, read_tracks};

use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::check::{finite, in_range};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::{Document, from_text, read_text};

/// One reconstruction: cameras, shots and points in one frame of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The cameras by name.
    pub cameras: BTreeMap<String, PerspectiveCamera>,
    /// The photographs by file name.
    pub shots: BTreeMap<String, Shot>,
    /// The points by the name of their track.
    pub points: BTreeMap<String, ScenePoint>,
    /// Where the frame's origin is on the earth, where the file says so.
    pub reference: Option<Reference>,
}

/// OpenSfM's camera model "perspective".
///
/// ```text
/// x = X/Z,  y = Y/Z,  r² = x² + y²,  image = focal · (1 + k1 r² + k2 r⁴) · (x, y)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerspectiveCamera {
    /// Width of its pictures, pixels.
    pub width: u32,
    /// Height of its pictures, pixels.
    pub height: u32,
    /// The principal distance in units of the longer side.
    pub focal: f64,
    /// Radial distortion of the second order.
    pub k1: f64,
    /// Radial distortion of the fourth order.
    pub k2: f64,
}

/// A photograph of a reconstruction.
///
/// ```text
/// X_camera = R X_world + t
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The name of its camera.
    pub camera: String,
    /// R as axis times angle, radians.
    pub rotation: [f64; 3],
    /// t, world units.
    pub translation: [f64; 3],
}

/// A point of a reconstruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePoint {
    /// World coordinates.
    pub coordinates: [f64; 3],
    /// Red, green, blue.
    pub color: [u8; 3],
}

/// A place on the earth: the origin of a frame with x to the east, y to the north, z up.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct Reference {
    /// Degrees, north positive.
    #[serde(rename = "latitude")]
    pub latitude_deg: f64,
    /// Degrees, east positive.
    #[serde(rename = "longitude")]
    pub longitude_deg: f64,
    /// Metres.
    #[serde(rename = "altitude")]
    pub altitude_m: f64,
}

/// Reads one reconstruction of a `reconstruction.json`, by its number from 0. OpenSfM writes the largest first.
///
/// # Errors
/// [`ErrorKind::Json`] with the path to the bad field, [`ErrorKind::NoReconstruction`], and [`ErrorKind::Field`] for a
/// camera of another projection type ([`FieldProblem::Unsupported`] names it), for a shot of an unknown camera
/// ([`FieldProblem::UnknownName`]) and for numbers outside their domain.
pub fn read_reconstruction(path: &Path, index: usize) -> Result<Reconstruction, Error> {
    read_text(path).and_then(|t| parse_reconstruction(&t, index)).map_err(|e| e.in_file(path))
}

/// As [`read_reconstruction`], from text.
///
/// ```
/// use collinear_io::opensfm::parse_reconstruction;
///
/// let text = r#"[{
///   "cameras": { "c": { "projection_type": "perspective", "width": 4000, "height": 3000, "focal": 0.9, "k1": 0, "k2": 0 } },
///   "shots": { "1.jpg": { "camera": "c", "rotation": [0, 0, 0], "translation": [0, 0, 5] } },
///   "points": {}
/// }]"#;
/// let camera = parse_reconstruction(text, 0)?.camera("1.jpg")?;
/// assert_eq!(camera.exterior.projection_center, [0.0, 0.0, -5.0]);
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_reconstruction`].
pub fn parse_reconstruction(text: &str, index: usize) -> Result<Reconstruction, Error> {
    let all: Vec<RawReconstruction> = from_text(text)?;
    let count = all.len();
    let raw = all.into_iter().nth(index).ok_or(ErrorKind::NoReconstruction { index, count })?;
    raw.check().map_err(|e| e.under(&format!("[{index}]")).into())
}

impl Reconstruction {
    /// The camera of a photograph.
    ///
    /// ```text
    /// fx = fy = focal · max(W, H),   principal point (W/2, H/2),   k = (k1, k2, 0),   C = −Rᵀ t
    /// ```
    ///
    /// # Errors
    /// [`FieldProblem::UnknownName`] where there is no such photograph, or its camera is not there.
    pub fn camera(&self, shot: &str) -> Result<CameraFile, Error> {
        let pose = find(&self.shots, "a photograph", "shots", shot)?;
        let camera =
            find(&self.cameras, "a camera", &format!("shots[{shot:?}].camera"), &pose.camera)?;
        let rotation = Rotation3::new(Vector3::from(pose.rotation));
        let center = -(rotation.inverse() * Vector3::from(pose.translation));
        let q = UnitQuaternion::from_scaled_axis(Vector3::from(pose.rotation));
        let (w, h) = (f64::from(camera.width), f64::from(camera.height));
        let file = CameraFile {
            width: camera.width,
            height: camera.height,
            interior: Interior::Brown {
                principal_distance: [camera.focal * w.max(h); 2],
                principal_point: [w / 2.0, h / 2.0],
                skew: 0.0,
                k: [camera.k1, camera.k2, 0.0],
                p: [0.0, 0.0],
            },
            exterior: Exterior {
                projection_center: center.into(),
                rotation: Rotation::QuaternionWxyz([q.w, q.i, q.j, q.k]),
            },
        };
        file.check().map_err(|e| e.under(&format!("shots[{shot:?}]")))?;
        Ok(file)
    }
}

fn find<'a, T>(
    map: &'a BTreeMap<String, T>,
    what: &'static str,
    field: &str,
    name: &str,
) -> Result<&'a T, FieldError> {
    map.get(name).ok_or_else(|| {
        let known = map.keys().cloned().collect();
        FieldError::new(field, FieldProblem::UnknownName { what, name: name.to_owned(), known })
    })
}

// OpenSfM's files carry more fields than are needed here, and new ones with each version: unknown fields pass.

#[derive(Deserialize)]
struct RawReconstruction {
    cameras: BTreeMap<String, RawCamera>,
    shots: BTreeMap<String, RawShot>,
    #[serde(default)]
    points: BTreeMap<String, RawPoint>,
    reference_lla: Option<Reference>,
}

#[derive(Deserialize)]
struct RawCamera {
    // Files from before there were other types have none.
    projection_type: Option<String>,
    width: u32,
    height: u32,
    focal: Option<f64>,
    #[serde(default)]
    k1: f64,
    #[serde(default)]
    k2: f64,
}

#[derive(Deserialize)]
struct RawShot {
    camera: String,
    rotation: [f64; 3],
    translation: [f64; 3],
}

#[derive(Deserialize)]
struct RawPoint {
    coordinates: [f64; 3],
    #[serde(default)]
    color: [f64; 3],
}

impl RawReconstruction {
    fn check(self) -> Result<Reconstruction, FieldError> {
        let mut cameras = BTreeMap::new();
        for (name, raw) in self.cameras {
            let camera = raw.check().map_err(|e| e.under(&format!("cameras[{name:?}]")))?;
            cameras.insert(name, camera);
        }
        let mut shots = BTreeMap::new();
        for (name, raw) in self.shots {
            let field = format!("shots[{name:?}]");
            find(&cameras, "a camera", &format!("{field}.camera"), &raw.camera)?;
            finite(&format!("{field}.rotation"), &raw.rotation)?;
            finite(&format!("{field}.translation"), &raw.translation)?;
            let RawShot { camera, rotation, translation } = raw;
            shots.insert(name, Shot { camera, rotation, translation });
        }
        let mut points = BTreeMap::new();
        for (name, raw) in self.points {
            finite(&format!("points[{name:?}].coordinates"), &raw.coordinates)?;
            // A cast saturates, and takes NaN to zero.
            let color = raw.color.map(|c| c.round() as u8);
            points.insert(name, ScenePoint { coordinates: raw.coordinates, color });
        }
        Ok(Reconstruction { cameras, shots, points, reference: self.reference_lla })
    }
}

impl RawCamera {
    fn check(self) -> Result<PerspectiveCamera, FieldError> {
        const SUPPORTED: &str = "perspective";
        if let Some(found) = self.projection_type.filter(|t| t != SUPPORTED) {
            let expected = "OpenSfM cameras are read where their type is `perspective`";
            return Err(FieldError::new(
                "projection_type",
                FieldProblem::Unsupported { found, expected },
            ));
        }
        for (field, size) in [("width", self.width), ("height", self.height)] {
            in_range(field, size.into(), "at least 1 pixel", |v| v >= 1.0)?;
        }
        let focal = self.focal.unwrap_or(f64::NAN);
        in_range("focal", focal, "a finite number above 0", |v| v > 0.0)?;
        finite("k1", &[self.k1]).and(finite("k2", &[self.k2]))?;
        let Self { width, height, k1, k2, .. } = self;
        Ok(PerspectiveCamera { width, height, focal, k1, k2 })
    }
}
