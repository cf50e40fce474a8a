//! OpenSfM: `reconstruction.json` and `tracks.csv`.
//!
//! OpenSfM's image coordinates are normalised: the origin is the middle of the picture and one unit is its longer side,
//!
//! ```text
//! pixel = x · max(W, H) + (W/2, H/2)
//! ```
//!
//! in pixels from the top-left corner of the top-left pixel. Its camera axes are this crate's: x right, y down,
//! z forward. Format: <https://opensfm.org/docs/dataset.html>. Its camera types, as its `camera_projections_functions.h` and
//! `camera_distortions_functions.h` compute them, with x = X/Z, y = Y/Z, θ the angle from the axis:
//!
//! | `projection_type` | equation | fields | interior |
//! | --- | --- | --- | --- |
//! | `perspective` | (x, y) (1 + k₁r² + k₂r⁴) · focal | focal, k1, k2 | [`Interior::Brown`] |
//! | `simple_radial`, `radial` | the same, and a principal point | focal_x, focal_y, c_x, c_y, k1, k2 | [`Interior::Brown`] |
//! | `brown` | Brown's, in OpenCV's order | the same, k3, p1, p2 | [`Interior::Brown`] |
//! | `fisheye` | r = θ (1 + k₁θ² + k₂θ⁴) · focal | focal, k1, k2 | [`Lens::Fisheye`] |
//! | `fisheye_opencv` | … + k₃θ⁶ + k₄θ⁸, and a principal point | focal_x, focal_y, c_x, c_y, k1 to k4 | [`Lens::Fisheye`] |
//! | `fisheye62` | … + k₅θ¹⁰ + k₆θ¹², and p₁, p₂ | the same, k5, k6, p1, p2 | [`Lens::ThinPrismFisheye`], [`Lens::Fisheye624`] |
//! | `fisheye624` | … and s₀r² + s₁r⁴, s₂r² + s₃r⁴ | the same, s0 to s3 | the same |
//! | `dual` | transition · perspective + (1 − transition) · fisheye | focal, k1, k2, transition | where transition is 1 or 0 |
//! | `spherical`, `equirectangular` | longitude and latitude over 2π | | [`Interior::Panorama`] |
//!
//! The last two fisheyes decentre the undistorted point. COLMAP's and Project Aria's *Fisheye624* decentres the radially
//! distorted one, which is another lens wherever both are there: of OpenSfM's those are read in which k₅, k₆, s₁ and s₃ are 0,
//! or p and s, or all k.
//!
//! [`Lens::Fisheye`]: crate::camera::Lens::Fisheye
//! [`Lens::ThinPrismFisheye`]: crate::camera::Lens::ThinPrismFisheye
//! [`Lens::Fisheye624`]: crate::camera::Lens::Fisheye624

mod models;
mod tracks;

use std::collections::BTreeMap;
use std::path::Path;

use collinear::geometry::rotation::RotationVector;
use collinear::nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde::Deserialize;
use serde_json::{Map, Value, json};

pub use tracks::{Observation, parse_tracks, read_tracks};

use crate::atomic::write_atomically;
use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::check::finite;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::{Document, from_text, read_text, to_text};

use models::RawCamera;

/// One reconstruction: cameras, shots and points in one frame of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// The cameras by name.
    pub cameras: BTreeMap<String, Camera>,
    /// The photographs by file name.
    pub shots: BTreeMap<String, Shot>,
    /// The points by the name of their track.
    pub points: BTreeMap<String, ScenePoint>,
    /// Where the frame's origin is on the earth, where the file says so.
    pub reference: Option<Reference>,
}

/// A camera of a reconstruction.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Width of its pictures, pixels.
    pub width: u32,
    /// Height of its pictures, pixels.
    pub height: u32,
    /// What its [type](self) is here, in pixels.
    pub interior: Interior,
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
/// camera of a type that is not read ([`FieldProblem::Unsupported`] names it), for a shot of an unknown camera
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
    /// The camera of a photograph, with C = −Rᵀ t.
    ///
    /// # Errors
    /// [`FieldProblem::UnknownName`] where there is no such photograph, or its camera is not there; those of
    /// [`CameraFile::check`](Document::check).
    pub fn camera(&self, shot: &str) -> Result<CameraFile, Error> {
        let pose = find(&self.shots, "a photograph", "shots", shot)?;
        let camera =
            find(&self.cameras, "a camera", &format!("shots[{shot:?}].camera"), &pose.camera)?;
        let rotation = Rotation3::new(Vector3::from(pose.rotation));
        let center = -(rotation.inverse() * Vector3::from(pose.translation));
        let q = UnitQuaternion::from_scaled_axis(Vector3::from(pose.rotation));
        let file = CameraFile {
            width: camera.width,
            height: camera.height,
            interior: camera.interior.clone(),
            exterior: Exterior {
                projection_center: center.into(),
                rotation: Rotation::QuaternionWxyz([q.w, q.i, q.j, q.k]),
            },
        };
        file.check().map_err(|e| e.under(&format!("shots[{shot:?}]")))?;
        Ok(file)
    }

    /// A reconstruction without points, of photographs with their cameras. Photographs with one camera share it; cameras are
    /// named `camera 1`, `camera 2`, …
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] with the photograph's name for a camera that is of none of OpenSfM's types,
    /// [`FieldProblem::DuplicateName`] for a second photograph of a name, and those of [`CameraFile::check`](Document::check).
    ///
    /// # Example
    /// f = 3600 on 4000 × 3000 is 0.9 of the longer side; a camera at (0, 0, −5) has t = (0, 0, 5).
    ///
    /// ```
    /// use collinear_io::opensfm::{Reconstruction, parse_reconstruction};
    ///
    /// let text = r#"[{
    ///   "cameras": { "c": { "projection_type": "perspective", "width": 4000, "height": 3000, "focal": 0.9 } },
    ///   "shots": { "1.jpg": { "camera": "c", "rotation": [0, 0, 0], "translation": [0, 0, 5] } }
    /// }]"#;
    /// let camera = parse_reconstruction(text, 0)?.camera("1.jpg")?;
    /// let written = Reconstruction::from_photographs(&[("a.jpg".into(), camera)])?;
    /// assert!(written.to_json()?.contains("\"focal\": 0.9,"));
    /// assert_eq!(written.shots["a.jpg"].translation, [0.0, 0.0, 5.0]);
    /// # Ok::<(), collinear_io::Error>(())
    /// ```
    pub fn from_photographs(photographs: &[(String, CameraFile)]) -> Result<Self, Error> {
        let mut all: Vec<Camera> = Vec::new();
        let (mut cameras, mut shots) = (BTreeMap::new(), BTreeMap::new());
        for (name, file) in photographs {
            let under = |e: FieldError| Error::from(e.under(name));
            file.check().map_err(under)?;
            let interior = file.interior.plain([file.width, file.height]);
            let camera = Camera { width: file.width, height: file.height, interior };
            let number = match all.iter().position(|c| *c == camera) {
                Some(number) => number,
                None => {
                    models::fields(&camera).map_err(under)?;
                    cameras.insert(camera_name(all.len()), camera.clone());
                    all.push(camera);
                    all.len() - 1
                }
            };
            let exterior = file.exterior.orientation()?;
            let turn = RotationVector::from_rotation(&exterior.camera_from_world());
            let shot = Shot {
                camera: camera_name(number),
                rotation: turn.vector().into(),
                translation: exterior.pose().translation().into(),
            };
            finite("translation", &shot.translation).map_err(under)?;
            if shots.insert(name.clone(), shot).is_some() {
                let first = "an earlier photograph's".into();
                let problem = FieldProblem::DuplicateName { name: name.clone(), first };
                return Err(FieldError::new("shots", problem).into());
            }
        }
        Ok(Self { cameras, shots, points: BTreeMap::new(), reference: None })
    }

    /// The text of a `reconstruction.json` that holds this reconstruction alone.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] for a camera that is of none of OpenSfM's [types](self), and
    /// [`FieldProblem::OutOfRange`] for numbers that are not finite.
    pub fn to_json(&self) -> Result<String, Error> {
        let mut cameras = Map::new();
        for (name, camera) in &self.cameras {
            let field = format!("cameras[{name:?}]");
            camera.interior.check().map_err(|e| e.under("interior").under(&field))?;
            let fields = models::fields(camera).map_err(|e| e.under(&field))?;
            cameras.insert(name.clone(), Value::Object(fields));
        }
        let mut shots = Map::new();
        for (name, Shot { camera, rotation, translation }) in &self.shots {
            finite(&format!("shots[{name:?}].rotation"), rotation)?;
            finite(&format!("shots[{name:?}].translation"), translation)?;
            let fields =
                json!({ "rotation": rotation, "translation": translation, "camera": camera });
            shots.insert(name.clone(), fields);
        }
        let mut points = Map::new();
        for (name, ScenePoint { coordinates, color }) in &self.points {
            finite(&format!("points[{name:?}].coordinates"), coordinates)?;
            let fields = json!({ "color": color.map(f64::from), "coordinates": coordinates });
            points.insert(name.clone(), fields);
        }
        let mut all = json!({ "cameras": cameras, "shots": shots, "points": points });
        if let Some(Reference { latitude_deg, longitude_deg, altitude_m }) = self.reference {
            finite("reference_lla", &[latitude_deg, longitude_deg, altitude_m])?;
            all["reference_lla"] = json!({
                "latitude": latitude_deg, "longitude": longitude_deg, "altitude": altitude_m
            });
        }
        to_text(&[all])
    }

    /// To a file, atomically.
    ///
    /// # Errors
    /// As [`to_json`](Self::to_json) and [`write_atomically`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let text = self.to_json().map_err(|e| e.in_file(path))?;
        write_atomically(path, |w| w.write_all(text.as_bytes()))
    }
}

fn camera_name(index: usize) -> String {
    format!("camera {}", index + 1)
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
