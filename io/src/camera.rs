//! Camera files: one picture size, an interior and an exterior orientation.

mod lens;
mod plain;
mod raw;

use std::path::Path;

use collinear::camera::{COLMAP_MODELS, Panorama};
use serde::{Deserialize, Serialize};

pub use lens::{FisheyeProjection, Lens};

use raw::RawInterior;

use crate::check::{all_in_range, determinant, dot, finite, in_range, norm, one_size};
use crate::error::{Error, FieldError, FieldProblem};
use crate::json::Document;
use crate::json::object::Object;

/// How far a quaternion's length or a matrix's R Rᵀ may be off: numbers printed with four digits pass, a mistaken one
/// does not.
const ROTATION_TOLERANCE: f64 = 1e-3;

/// The smallest and the largest principal distance, in pixels. Far beyond either end the squares of numbers that a camera is
/// computed with leave `f64`.
const PRINCIPAL_DISTANCE: [f64; 2] = [1e-6, 1e9];

/// The largest magnitude of a principal point and of a skew, in pixels.
const FARTHEST_PIXEL: f64 = 1e9;

/// The smallest and the largest scale of a parallel projection, in pixels for each unit, whatever the unit is.
const PIXELS_PER_UNIT: [f64; 2] = [1e-100, 1e100];

/// A camera as its file states it. Fields, units and defaults: `docs/formats.md`, "camera".
///
/// ```
/// use collinear_io::Document;
/// use collinear_io::camera::{CameraFile, Exterior, Interior, Rotation};
///
/// let camera = CameraFile {
///     width: 640,
///     height: 480,
///     interior: Interior::Pinhole {
///         principal_distance: [500.0, 500.0],
///         principal_point: [320.0, 240.0],
///         skew: 0.0,
///     },
///     exterior: Exterior {
///         projection_center: [0.0, 0.0, 10.0],
///         rotation: Rotation::QuaternionWxyz([0.0, 1.0, 0.0, 0.0]),
///     },
/// };
/// assert_eq!(CameraFile::parse(&camera.to_json()?)?, camera);
/// # Ok::<(), collinear_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraFile {
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// From camera axes to pixels.
    pub interior: Interior,
    /// From world to camera axes.
    pub exterior: Exterior,
}

/// From camera axes (x right, y down, z forward) to pixels from the top-left corner.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Object<RawInterior>", into = "RawInterior")]
pub enum Interior {
    /// A central perspective.
    Pinhole {
        /// fx and fy, pixels.
        principal_distance: [f64; 2],
        /// Pixels.
        principal_point: [f64; 2],
        /// Pixels of x for each unit of y/z.
        skew: f64,
    },
    /// A central perspective through a lens with Brown's distortion.
    Brown {
        /// fx and fy, pixels.
        principal_distance: [f64; 2],
        /// Pixels.
        principal_point: [f64; 2],
        /// Pixels of x for each unit of y/z.
        skew: f64,
        /// Radial: k1, k2, k3, of the powers r², r⁴, r⁶ of the normalised radius.
        k: [f64; 3],
        /// Decentring: p1, p2, in OpenCV's order.
        p: [f64; 2],
    },
    /// A camera of one projection centre with another lens.
    Lens {
        /// fx and fy, pixels for each unit of the lens's plane.
        principal_distance: [f64; 2],
        /// Pixels.
        principal_point: [f64; 2],
        /// Pixels of x for each unit of the lens's y.
        skew: f64,
        /// Projection and distortion.
        lens: Box<Lens>,
    },
    /// A panorama about the camera's y axis.
    Panorama {
        /// Equirectangular or cylindrical.
        projection: Panorama,
        /// Pixels for each radian, and down the cylinder for each radius. Without it the picture is a full turn wide, and an
        /// equirectangular one half a turn high.
        principal_distance: Option<[f64; 2]>,
        /// The image of the z axis, pixels; without it the middle.
        principal_point: Option<[f64; 2]>,
    },
    /// A scanned photograph of a film camera, a central perspective; its fiducial marks say where the scan's pixels are on the film.
    Film {
        /// c, millimetres.
        principal_distance_mm: f64,
        /// Millimetres in the frame of the fiducial marks, x right, y up.
        principal_point_mm: [f64; 2],
        /// The marks, three or more: x, y as calibrated, millimetres; x, y as measured in the scan, pixels.
        fiducials: Vec<[f64; 4]>,
    },
    /// A camera as COLMAP's `cameras.txt` has it.
    Colmap {
        /// COLMAP's name of the model.
        model: String,
        /// In COLMAP's order.
        parameters: Vec<f64>,
    },
    /// A parallel projection along the z axis.
    Orthographic {
        /// Pixels for each world unit, along x and y.
        pixels_per_unit: [f64; 2],
        /// The image of the projection centre, pixels.
        principal_point: [f64; 2],
    },
}

/// From world to camera axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Object<RawExterior>", into = "RawExterior")]
pub struct Exterior {
    /// World coordinates.
    pub projection_center: [f64; 3],
    /// The rotation in one of its forms.
    pub rotation: Rotation,
}

/// The rotation `camera_from_world` in the form that the file gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// w, x, y, z of `camera_from_world`; of length one within 10⁻³.
    QuaternionWxyz([f64; 4]),
    /// ω, φ, κ in radians: R₃(κ) R₂(φ) R₁(ω), from the world to photogrammetric axes (x right, y up, z backwards).
    OmegaPhiKappa([f64; 3]),
    /// The rows of `camera_from_world`; orthonormal within 10⁻³.
    RotationMatrix([[f64; 3]; 3]),
}

impl Document for CameraFile {
    const KIND: &'static str = "camera";
    const VERSION: u64 = 1;

    fn check(&self) -> Result<(), FieldError> {
        for (field, size) in [("width", self.width), ("height", self.height)] {
            in_range(field, size.into(), "at least 1 pixel", |v| v >= 1.0)?;
        }
        self.interior.check().map_err(|e| e.under("interior"))?;
        self.exterior.check().map_err(|e| e.under("exterior"))
    }
}

/// A camera file whose camera may have no place yet.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct UnplacedCamera {
    width: u32,
    height: u32,
    interior: Interior,
    #[serde(default)]
    exterior: Option<Exterior>,
}

impl UnplacedCamera {
    fn placed(&self) -> CameraFile {
        let nowhere = Exterior {
            projection_center: [0.0; 3],
            rotation: Rotation::QuaternionWxyz([1.0, 0.0, 0.0, 0.0]),
        };
        CameraFile {
            width: self.width,
            height: self.height,
            interior: self.interior.clone(),
            exterior: self.exterior.clone().unwrap_or(nowhere),
        }
    }
}

impl Document for UnplacedCamera {
    const KIND: &'static str = CameraFile::KIND;
    const VERSION: u64 = CameraFile::VERSION;

    fn check(&self) -> Result<(), FieldError> {
        self.placed().check()
    }
}

impl CameraFile {
    /// Reads a camera whose `exterior` may be missing, as one that is still to be oriented: it then stands in the origin.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub fn read_without_exterior(path: &Path) -> Result<Self, Error> {
        Ok(UnplacedCamera::read(path)?.placed())
    }

    /// As [`read_without_exterior`](Self::read_without_exterior), from text.
    ///
    /// ```
    /// use collinear_io::camera::CameraFile;
    ///
    /// let camera = CameraFile::parse_without_exterior(
    ///     r#"{ "collinear": "camera", "version": 1, "width": 640, "height": 480,
    ///     "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 240] } }"#,
    /// )?;
    /// assert_eq!(camera.exterior.projection_center, [0.0; 3]);
    /// # Ok::<(), collinear_io::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Document::parse`].
    pub fn parse_without_exterior(text: &str) -> Result<Self, Error> {
        Ok(UnplacedCamera::parse(text)?.placed())
    }

    /// Refuses a picture of another size than the camera's.
    ///
    /// # Errors
    /// [`ErrorKind::PictureSize`](crate::ErrorKind::PictureSize).
    pub fn check_picture_size(&self, width: u32, height: u32) -> Result<(), Error> {
        one_size([width, height], [self.width, self.height])
    }
}

impl Interior {
    /// The model's name in a file.
    #[must_use]
    pub fn model(&self) -> &'static str {
        match self {
            Self::Pinhole { .. } => "pinhole",
            Self::Brown { .. } => "brown",
            Self::Lens { lens, .. } => lens.model(),
            Self::Panorama { projection: Panorama::Equirectangular, .. } => "equirectangular",
            Self::Panorama { projection: Panorama::Cylindrical, .. } => "cylindrical",
            Self::Film { .. } => "film",
            Self::Colmap { .. } => "colmap",
            Self::Orthographic { .. } => "orthographic",
        }
    }

    pub(crate) fn check(&self) -> Result<(), FieldError> {
        let distances = |values: &[f64]| {
            let [least, most] = PRINCIPAL_DISTANCE;
            let expected = "a number from 1e-6 to 1e9 (pixels)";
            all_in_range("principal_distance", values, expected, |v| (least..=most).contains(&v))
        };
        let pixels = |field: &str, values: &[f64]| {
            let expected = "a number from -1e9 to 1e9 (pixels)";
            all_in_range(field, values, expected, |v| v.abs() <= FARTHEST_PIXEL)
        };
        let skewed = |skew| {
            in_range("skew", skew, "a number from -1e9 to 1e9", |v| v.abs() <= FARTHEST_PIXEL)
        };
        match self {
            Self::Pinhole { principal_distance, principal_point, skew } => {
                distances(principal_distance)?;
                pixels("principal_point", principal_point)?;
                skewed(*skew)
            }
            Self::Brown { principal_distance, principal_point, skew, k, p } => {
                distances(principal_distance)?;
                pixels("principal_point", principal_point)?;
                skewed(*skew)?;
                finite("k", k)?;
                finite("p", p)
            }
            Self::Lens { principal_distance, principal_point, skew, lens } => {
                distances(principal_distance)?;
                pixels("principal_point", principal_point)?;
                skewed(*skew)?;
                lens.check()
            }
            Self::Panorama { principal_distance, principal_point, .. } => {
                distances(principal_distance.as_ref().map_or(&[], |d| d))?;
                pixels("principal_point", principal_point.as_ref().map_or(&[], |p| p))
            }
            Self::Film { principal_distance_mm, principal_point_mm, fiducials } => {
                let expected = "a number from 1e-6 to 1e9 (millimetres)";
                let [least, most] = PRINCIPAL_DISTANCE;
                let within = |v| (least..=most).contains(&v);
                in_range("principal_distance_mm", *principal_distance_mm, expected, within)?;
                pixels("principal_point_mm", principal_point_mm)?;
                for (i, mark) in fiducials.iter().enumerate() {
                    pixels(&format!("fiducials[{i}]"), mark)?;
                }
                let marks = fiducials.len() as f64;
                in_range("fiducials", marks, "3 marks or more", |v| v >= 3.0)
            }
            Self::Colmap { model, parameters } => check_colmap(model, parameters),
            Self::Orthographic { pixels_per_unit, principal_point } => {
                let [least, most] = PIXELS_PER_UNIT;
                let expected = "a number from 1e-100 to 1e100";
                all_in_range("pixels_per_unit", pixels_per_unit, expected, |v| {
                    (least..=most).contains(&v)
                })?;
                pixels("principal_point", principal_point)
            }
        }
    }
}

/// Refuses a model that COLMAP does not have, another number of parameters, and those that the other models refuse.
fn check_colmap(model: &str, parameters: &[f64]) -> Result<(), FieldError> {
    let Some((_, names)) = COLMAP_MODELS.iter().find(|(name, _)| *name == model) else {
        let known = COLMAP_MODELS.iter().map(|(name, _)| (*name).to_owned()).collect();
        let problem =
            FieldProblem::UnknownName { what: "a COLMAP camera model", name: model.into(), known };
        return Err(FieldError::new("colmap_model", problem));
    };
    let (found, expected) = (parameters.len(), names.len());
    if found != expected {
        let of = "the COLMAP model's parameters";
        return Err(FieldError::new("parameters", FieldProblem::Count { found, expected, of }));
    }
    for (i, (name, value)) in names.iter().zip(parameters).enumerate() {
        let field = format!("parameters[{i}]");
        match *name {
            "f" | "fx" | "fy" | "w" | "h" => {
                let [least, most] = PRINCIPAL_DISTANCE;
                let expected = "a number from 1e-6 to 1e9 (pixels)";
                in_range(&field, *value, expected, |v| (least..=most).contains(&v))?;
            }
            "cx" | "cy" => {
                let expected = "a number from -1e9 to 1e9 (pixels)";
                in_range(&field, *value, expected, |v| v.abs() <= FARTHEST_PIXEL)?;
            }
            _ => in_range(&field, *value, "a finite number", |_| true)?,
        }
    }
    Ok(())
}

impl Exterior {
    pub(crate) fn check(&self) -> Result<(), FieldError> {
        finite("projection_center", &self.projection_center)?;
        match &self.rotation {
            Rotation::QuaternionWxyz(q) => check_quaternion("quaternion_wxyz", q),
            Rotation::OmegaPhiKappa(angles) => finite("omega_phi_kappa", angles),
            Rotation::RotationMatrix(rows) => check_rotation("rotation_matrix", rows),
        }
    }
}

/// Refuses a quaternion whose length is not one.
pub(crate) fn check_quaternion(field: &str, q: &[f64; 4]) -> Result<(), FieldError> {
    finite(field, q)?;
    let length = norm(q);
    if (length - 1.0).abs() > ROTATION_TOLERANCE {
        let expected = "1 within 0.001";
        return Err(FieldError::new(field, FieldProblem::Length { norm: length, expected }));
    }
    Ok(())
}

fn check_rotation(field: &str, rows: &[[f64; 3]; 3]) -> Result<(), FieldError> {
    for (i, row) in rows.iter().enumerate() {
        finite(&format!("{field}[{i}]"), row)?;
    }
    let mut deviation = 0.0_f64;
    for (i, a) in rows.iter().enumerate() {
        for (j, b) in rows.iter().enumerate() {
            deviation = deviation.max((dot(a, b) - f64::from(u8::from(i == j))).abs());
        }
    }
    // Entries of 1e200 overflow to infinity or, where infinities meet, to NaN.
    if deviation.is_nan() || deviation > ROTATION_TOLERANCE {
        return Err(FieldError::new(field, FieldProblem::NotARotation { deviation }));
    }
    if determinant(rows) < 0.0 {
        return Err(FieldError::new(field, FieldProblem::Mirrors));
    }
    Ok(())
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawExterior {
    projection_center: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    quaternion_wxyz: Option<[f64; 4]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    omega_phi_kappa: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rotation_matrix: Option<[[f64; 3]; 3]>,
}

impl TryFrom<Object<RawExterior>> for Exterior {
    type Error = String;

    fn try_from(Object(raw): Object<RawExterior>) -> Result<Self, String> {
        let rotation = match (raw.quaternion_wxyz, raw.omega_phi_kappa, raw.rotation_matrix) {
            (Some(q), None, None) => Rotation::QuaternionWxyz(q),
            (None, Some(a), None) => Rotation::OmegaPhiKappa(a),
            (None, None, Some(m)) => Rotation::RotationMatrix(m),
            (q, a, m) => {
                let n = [q.is_some(), a.is_some(), m.is_some()].iter().filter(|b| **b).count();
                return Err(format!(
                    "has {n} rotations: give exactly one of `quaternion_wxyz`, `omega_phi_kappa`, `rotation_matrix`"
                ));
            }
        };
        Ok(Self { projection_center: raw.projection_center, rotation })
    }
}

impl From<Exterior> for RawExterior {
    fn from(exterior: Exterior) -> Self {
        let mut raw = Self {
            projection_center: exterior.projection_center,
            quaternion_wxyz: None,
            omega_phi_kappa: None,
            rotation_matrix: None,
        };
        match exterior.rotation {
            Rotation::QuaternionWxyz(q) => raw.quaternion_wxyz = Some(q),
            Rotation::OmegaPhiKappa(a) => raw.omega_phi_kappa = Some(a),
            Rotation::RotationMatrix(m) => raw.rotation_matrix = Some(m),
        }
        raw
    }
}
