//! `transforms.json` of radiance fields: nerfstudio, instant-ngp, the synthetic scenes of NeRF.
//!
//! Each frame has the matrix from eye axes (x right, y up, looking along −z) to the world's. Pixels count as COLMAP's do, from the
//! top-left corner of the top-left pixel; `k1`, `k2`, `k3`, `p1`, `p2` are OpenCV's, and with `camera_model` `OPENCV_FISHEYE` `k1` to `k4` are those of
//! its `fisheye` (nerfstudio, *Data conventions*). What a frame does not say the file does. Without `fl_x`
//! the focal length is W/(2 tan(camera_angle_x/2)), without `cx` and `cy` the principal point is in the middle. The world is that
//! of the file, after an `applied_transform` if it has one.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::camera::{CameraFile, FisheyeProjection, Interior, Lens};
use crate::check::in_range;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::eye::{exterior, world_from_eye};
use crate::json::{Document, from_text};

#[derive(Deserialize)]
struct File {
    camera_model: Option<String>,
    #[serde(flatten)]
    shared: Intrinsics,
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    file_path: String,
    transform_matrix: Vec<[f64; 4]>,
    #[serde(flatten)]
    own: Intrinsics,
}

/// What stands in a frame, or in the file for all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Intrinsics {
    #[serde(skip_serializing_if = "Option::is_none")]
    w: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    h: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fl_x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fl_y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    camera_angle_x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    camera_angle_y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cx: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p2: Option<f64>,
}

fn unsupported(field: &str, found: impl Into<String>, expected: &'static str) -> FieldError {
    FieldError::new(field, FieldProblem::Unsupported { found: found.into(), expected })
}

/// Whether text is a list of frames.
pub(crate) fn is_like(text: &str) -> bool {
    text.starts_with('{') && ["\"frames\"", "\"transform_matrix\""].iter().all(|w| text.contains(w))
}

/// The frames' cameras, named by their `file_path`; for pictures of this size where the file does not say it.
///
/// # Errors
/// [`ErrorKind::NoPictureSize`]; [`ErrorKind::Json`] and [`ErrorKind::Field`] with the path in the file.
///
/// # Example
/// NeRF's own form, 90° across 400 × 300: f = 200. From 4 above the origin, 1 to the right and 0.5 up is (200 + 50, 150 − 25).
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
///
/// let text = r#"{ "camera_angle_x": 1.5707963267948966, "frames": [{ "file_path": "r_0",
///   "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]] }] }"#;
/// let (name, camera) = collinear_io::nerf::parse(text, Some([400, 300]))?.remove(0);
/// let image = camera.camera()?.sensor().project(&Point3::new(1.0, 0.5, 0.0))?;
/// assert!((image - Point2::new(250.0, 125.0)).norm() < 1e-12);
/// assert_eq!(name, "r_0");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse(text: &str, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    let file: File = from_text(text)?;
    let fisheye = match file.camera_model.as_deref() {
        None | Some("OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" | "SIMPLE_RADIAL" | "RADIAL") => false,
        Some("OPENCV_FISHEYE") => true,
        Some(other) => {
            let expected = "OPENCV, PINHOLE, RADIAL and OPENCV_FISHEYE are read";
            let found: String = other.chars().take(40).collect();
            return Err(unsupported("camera_model", found, expected).into());
        }
    };
    let mut photographs = Vec::with_capacity(file.frames.len());
    for (i, frame) in file.frames.iter().enumerate() {
        let under = |e: FieldError| Error::from(e.under(&format!("frames[{i}]")));
        let intrinsics = frame.own.or(&file.shared);
        let [width, height] = match intrinsics.size().map_err(under)? {
            Some(size) => size,
            None => size.ok_or(ErrorKind::NoPictureSize)?,
        };
        let interior = intrinsics.interior(fisheye, [width, height]).map_err(under)?;
        let rows = match &frame.transform_matrix[..] {
            [a, b, c] | [a, b, c, [0.0, 0.0, 0.0, 1.0]] => [*a, *b, *c, [0.0, 0.0, 0.0, 1.0]],
            other => {
                let found = format!("{} rows", other.len());
                let expected = "three rows, or four of which the last is 0, 0, 0, 1, are needed";
                return Err(under(unsupported("transform_matrix", found, expected)));
            }
        };
        let matrix = collinear::nalgebra::Matrix4::from_fn(|i, j| rows[i][j]);
        let exterior = exterior(&matrix).map_err(|e| under(e.under("transform_matrix")))?;
        let camera = CameraFile { width, height, interior, exterior };
        camera.check().map_err(under)?;
        photographs.push((frame.file_path.clone(), camera));
    }
    Ok(photographs)
}

impl Intrinsics {
    /// Its own numbers, or those of all frames.
    fn or(&self, all: &Self) -> Self {
        Self {
            w: self.w.or(all.w),
            h: self.h.or(all.h),
            fl_x: self.fl_x.or(all.fl_x),
            fl_y: self.fl_y.or(all.fl_y),
            camera_angle_x: self.camera_angle_x.or(all.camera_angle_x),
            camera_angle_y: self.camera_angle_y.or(all.camera_angle_y),
            cx: self.cx.or(all.cx),
            cy: self.cy.or(all.cy),
            k1: self.k1.or(all.k1),
            k2: self.k2.or(all.k2),
            k3: self.k3.or(all.k3),
            k4: self.k4.or(all.k4),
            p1: self.p1.or(all.p1),
            p2: self.p2.or(all.p2),
        }
    }

    /// Programs write whole numbers with a point.
    fn size(&self) -> Result<Option<[u32; 2]>, FieldError> {
        let (Some(w), Some(h)) = (self.w, self.h) else { return Ok(None) };
        for (field, value) in [("w", w), ("h", h)] {
            let whole = |v: f64| v.fract() == 0.0 && (1.0..=4e9).contains(&v);
            in_range(field, value, "a whole number of pixels", whole)?;
        }
        Ok(Some([w as u32, h as u32]))
    }

    fn interior(&self, fisheye: bool, size: [u32; 2]) -> Result<Interior, FieldError> {
        let [width, height] = size.map(f64::from);
        let from_angle = |field: &str, angle: Option<f64>, side: f64| {
            let Some(angle) = angle else { return Ok(None) };
            let inside = |v| v > 0.0 && v < std::f64::consts::PI;
            in_range(field, angle, "an angle between 0 and 3.141592653589793", inside)?;
            Ok(Some(0.5 * side / (0.5 * angle).tan()))
        };
        let fx = match self.fl_x {
            Some(f) => Some(f),
            None => from_angle("camera_angle_x", self.camera_angle_x, width)?,
        };
        let fx =
            fx.ok_or_else(|| unsupported("fl_x", "missing", "fl_x or camera_angle_x is needed"))?;
        let fy = match (self.fl_y, self.fl_x) {
            (Some(f), _) => f,
            // An angle up beside a focal length across is rounded more than it is.
            (None, Some(f)) => f,
            (None, None) => {
                from_angle("camera_angle_y", self.camera_angle_y, height)?.unwrap_or(fx)
            }
        };
        let principal_distance = [fx, fy];
        let principal_point = [self.cx.unwrap_or(0.5 * width), self.cy.unwrap_or(0.5 * height)];
        let skew = 0.0;
        let k = [self.k1, self.k2, self.k3, self.k4].map(Option::unwrap_or_default);
        let p = [self.p1, self.p2].map(Option::unwrap_or_default);
        if fisheye {
            if p != [0.0; 2] {
                let expected = "a fisheye has k1 to k4 alone";
                return Err(unsupported("p1", format!("{}, {}", p[0], p[1]), expected));
            }
            let lens = Box::new(Lens::Fisheye { projection: FisheyeProjection::Equidistant, k });
            return Ok(Interior::Lens { principal_distance, principal_point, skew, lens });
        }
        let [k1, k2, k3, k4] = k;
        if k4 != 0.0 {
            let expected = "a perspective has k1, k2, k3, p1, p2";
            return Err(unsupported("k4", k4.to_string(), expected));
        }
        if k == [0.0; 4] && p == [0.0; 2] {
            return Ok(Interior::Pinhole { principal_distance, principal_point, skew });
        }
        Ok(Interior::Brown { principal_distance, principal_point, skew, k: [k1, k2, k3], p })
    }

    /// Of a camera, with whether it is a fisheye; none where the format has no such camera.
    fn of(camera: &CameraFile) -> Option<(bool, Self)> {
        let plain = camera.interior.plain([camera.width, camera.height]);
        let (fisheye, f, c, k, p) = match plain {
            Interior::Pinhole { principal_distance: f, principal_point: c, skew: 0.0 } => {
                (false, f, c, [0.0; 4], [0.0; 2])
            }
            Interior::Brown { principal_distance: f, principal_point: c, skew: 0.0, k, p } => {
                (false, f, c, [k[0], k[1], k[2], 0.0], p)
            }
            Interior::Lens { principal_distance: f, principal_point: c, skew: 0.0, lens } => {
                let Lens::Fisheye { projection: FisheyeProjection::Equidistant, k } = *lens else {
                    return None;
                };
                (true, f, c, k, [0.0; 2])
            }
            _ => return None,
        };
        let [k1, k2, k3, k4] = k.map(Some);
        let [p1, p2] = p.map(Some);
        let ([fl_x, fl_y], [cx, cy]) = (f.map(Some), c.map(Some));
        let (w, h) = (Some(camera.width.into()), Some(camera.height.into()));
        let none = Self::default();
        Some((fisheye, Self { w, h, fl_x, fl_y, cx, cy, k1, k2, k3, k4, p1, p2, ..none }))
    }
}

/// `transforms.json` of photographs, each a frame; what all frames share stands above them.
///
/// # Errors
/// [`FieldProblem::Unsupported`] for a camera that is neither a perspective with Brown's lens or none nor OpenCV's fisheye, and for
/// photographs of both kinds together.
pub fn to_text(photographs: &[(String, CameraFile)]) -> Result<String, Error> {
    let mut frames: Vec<(Intrinsics, Value)> = Vec::with_capacity(photographs.len());
    let mut kind = None;
    for (name, camera) in photographs {
        camera.check().map_err(|e| e.under(name))?;
        let refused = |expected| {
            unsupported(&format!("{name}.interior.model"), camera.interior.model(), expected)
        };
        let (fisheye, intrinsics) = Intrinsics::of(camera).ok_or_else(|| {
            refused("transforms.json has OPENCV's k1, k2, k3, p1, p2 and OPENCV_FISHEYE's k1 to k4")
        })?;
        if *kind.get_or_insert(fisheye) != fisheye {
            return Err(refused("transforms.json has one camera_model for all frames").into());
        }
        let turn = world_from_eye(&camera.exterior)?;
        let center = camera.exterior.projection_center;
        let row = |i: usize| [turn[(i, 0)], turn[(i, 1)], turn[(i, 2)], center[i]];
        let matrix = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
        frames.push((intrinsics, json!({ "file_path": name, "transform_matrix": matrix })));
    }
    let foreign = |e: serde_json::Error| {
        Error::from(ErrorKind::Foreign { program: "nerfstudio", reason: e.to_string() })
    };
    let model = if kind == Some(true) { "OPENCV_FISHEYE" } else { "OPENCV" };
    let mut file = json!({ "camera_model": model });
    let first = frames.first().map(|(intrinsics, _)| *intrinsics).unwrap_or_default();
    let shared = frames.iter().all(|(intrinsics, _)| *intrinsics == first);
    let add = |to: &mut Value, intrinsics: Intrinsics| -> Result<(), Error> {
        if let (Value::Object(to), Value::Object(from)) =
            (to, serde_json::to_value(intrinsics).map_err(foreign)?)
        {
            to.extend(from);
        }
        Ok(())
    };
    if shared {
        add(&mut file, first)?;
    }
    let mut all = Vec::with_capacity(frames.len());
    for (intrinsics, mut frame) in frames {
        if !shared {
            add(&mut frame, intrinsics)?;
        }
        all.push(frame);
    }
    file["frames"] = all.into();
    Ok(format!("{file:#}\n"))
}
