//! OpenCV: calibrations as its `FileStorage` writes them, YAML, JSON or XML, and ROS's `camera_info`.
//!
//! OpenCV's pixel (0, 0) is the *centre* of the first pixel, which is (0.5, 0.5) here: x₀ = cx + ½, y₀ = cy + ½. Its camera axes
//! are this crate's; rvec and tvec are x = R X + t. Its coefficients in order are k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄ τx τy.

use std::path::Path;

use collinear::camera::ExteriorOrientation;
use collinear::geometry::rotation::RotationVector;
use collinear::nalgebra::Vector3;
use serde_json::{Map, Value, json};

use crate::atomic::write_atomically;
use crate::camera::{CameraFile, Exterior, FisheyeProjection, Interior, Lens};
use crate::check::finite;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::{Document, read_text};
use crate::xml;

/// What YAML starts with.
const YAML_HEADER: &str = "%YAML:1.0\n---\n";

/// YAML, JSON or XML.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Read by every OpenCV.
    Yaml,
    /// Read by OpenCV 3.2 and later.
    Json,
    /// Read by every OpenCV.
    Xml,
}

impl Form {
    /// The form of a file's name: JSON or XML where its extension says so.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let is = |known| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(known));
        match () {
            () if is("json") => Self::Json,
            () if is("xml") => Self::Xml,
            () => Self::Yaml,
        }
    }
}

/// The cameras of a calibration: one for each row of `extrinsic_parameters` (`view_0`, …), or one where `rvec` and `tvec` say,
/// or at the origin.
///
/// | field | names that are read |
/// | --- | --- |
/// | size of the pictures | `image_width`, `image_height` |
/// | camera matrix, 3 × 3 | `camera_matrix`, `cameraMatrix`, `K` |
/// | coefficients: 4, 5, 8, 12 or 14 | `distortion_coefficients`, `dist_coeffs`, `distCoeffs`, `D` |
/// | `fisheye` module: 4 coefficients | `fisheye_model` other than 0, or ROS's `distortion_model` `equidistant` or `fisheye` |
/// | `omnidir` module | `xi` |
/// | pose | `rvec` and `tvec`; `extrinsic_parameters`, six numbers a row |
///
/// # Errors
/// [`ErrorKind::Foreign`] for text of another form, [`ErrorKind::Field`] with the field's name.
///
/// # Example
/// OpenCV 5.0.0, `projectPoints` of (0.31, −0.22, 1), half a pixel on:
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
///
/// let text = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n\
///     camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1000., 0., 319.5, 0., 1000., 239.5, 0., 0., 1. ]\n\
///     distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ -0.28, 0.07, 1e-3, -5e-4, 0.002 ]\n";
/// let (_, camera) = collinear_io::opencv::parse(text)?.remove(0);
/// let p = camera.camera()?.sensor().project(&Point3::new(0.31, -0.22, 1.0))?;
/// assert!((p - Point2::new(617.6076220865975, 28.88781658370502)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse(text: &str) -> Result<Vec<(String, CameraFile)>, Error> {
    let calibration = Calibration(tree(text)?);
    let interior = calibration.interior()?;
    let (width, height) = (calibration.size("image_width")?, calibration.size("image_height")?);
    let mut cameras = Vec::new();
    for (name, exterior) in calibration.exteriors()? {
        let file = CameraFile { width, height, interior: interior.clone(), exterior };
        file.check()?;
        cameras.push((name, file));
    }
    Ok(cameras)
}

/// As [`parse`], from a file.
///
/// # Errors
/// As [`parse`], and those of reading.
pub fn read(path: &Path) -> Result<Vec<(String, CameraFile)>, Error> {
    read_text(path).and_then(|text| parse(&text)).map_err(|e| e.in_file(path))
}

/// Whether text looks like a calibration of OpenCV's.
pub(crate) fn is_like(text: &str) -> bool {
    text.starts_with("%YAML")
        || ["camera_matrix", "cameraMatrix", "opencv-matrix"].iter().any(|w| text.contains(w))
}

/// Whether XML is OpenCV's.
pub(crate) fn is_storage(text: &str) -> bool {
    text.contains("<opencv_storage")
}

/// The object that any of the forms is.
fn tree(text: &str) -> Result<Map<String, Value>, Error> {
    let foreign = |reason: String| Error::from(ErrorKind::Foreign { program: "OpenCV", reason });
    let object = if text.trim_start().starts_with('<') {
        let document = xml::parse(text).map_err(|e| foreign(e.to_string()))?;
        let root = document.root_element();
        if !root.has_tag_name("opencv_storage") {
            return Err(foreign("its root is no opencv_storage".into()));
        }
        storage(root, MAX_DEPTH).ok_or_else(|| foreign("it is nested too deeply".into()))?
    } else if text.trim_start().starts_with('{') {
        serde_json::from_str(text).map_err(|e| foreign(e.to_string()))?
    } else {
        // "%YAML:1.0" is no directive of YAML.
        let start = text.trim_start();
        let body = if start.starts_with("%YAML:") {
            start.split_once('\n').map_or("", |(_, rest)| rest)
        } else {
            start
        };
        serde_saphyr::from_str(body).map_err(|e| {
            let reason = e.to_string();
            foreign(reason.lines().next().unwrap_or_default().to_owned())
        })?
    };
    match object {
        Value::Object(object) => Ok(object),
        _ => Err(foreign("it is no list of named values".into())),
    }
}

/// No calibration is nested this deeply.
const MAX_DEPTH: usize = 16;

/// An element of `opencv_storage`: an object of its children, a list where they are called `_`, else its number, its numbers
/// or its text. None beyond a depth.
fn storage(node: roxmltree::Node<'_, '_>, depth: usize) -> Option<Value> {
    let depth = depth.checked_sub(1)?;
    let mut children = node.children().filter(|n| n.is_element()).peekable();
    if let Some(first) = children.peek() {
        return if first.has_tag_name("_") {
            children.map(|n| storage(n, depth)).collect::<Option<Vec<_>>>().map(Value::Array)
        } else {
            let named = |n: roxmltree::Node<'_, '_>| {
                Some((n.tag_name().name().to_owned(), storage(n, depth)?))
            };
            children.map(named).collect::<Option<Map<_, _>>>().map(Value::Object)
        };
    }
    let text = node.text().unwrap_or_default().trim();
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    Some(match numbers.as_deref() {
        Ok([one]) => json!(one),
        Ok(all) => json!(all),
        Err(_) => Value::String(text.trim_matches('"').to_owned()),
    })
}

struct Calibration(Map<String, Value>);

fn unsupported(field: &str, found: impl Into<String>, expected: &'static str) -> FieldError {
    FieldError::new(field, FieldProblem::Unsupported { found: found.into(), expected })
}

impl Calibration {
    fn get<'a>(&'a self, names: &[&'a str]) -> Option<(&'a str, &'a Value)> {
        names.iter().find_map(|name| self.0.get(*name).map(|v| (*name, v)))
    }

    fn size(&self, field: &str) -> Result<u32, FieldError> {
        let missing = "the size of the pictures is needed: add it to the file";
        let value = self.0.get(field).ok_or_else(|| unsupported(field, "missing", missing))?;
        let whole = value
            .as_u64()
            .or_else(|| value.as_f64().filter(|v| v.fract() == 0.0).map(|v| v as u64));
        whole.and_then(|v| u32::try_from(v).ok()).filter(|v| *v > 0).ok_or_else(|| {
            unsupported(field, value.to_string(), "a whole number of pixels is needed")
        })
    }

    fn numbers(&self, names: &[&str]) -> Result<Option<Vec<f64>>, FieldError> {
        let Some((name, value)) = self.get(names) else { return Ok(None) };
        let mut all = Vec::new();
        // A matrix, or numbers in brackets of any depth.
        flatten(value.get("data").unwrap_or(value), &mut all)
            .ok_or_else(|| unsupported(name, brief(value), "a matrix of numbers is needed"))?;
        finite(name, &all)?;
        Ok(Some(all))
    }

    fn interior(&self) -> Result<Interior, FieldError> {
        let names = ["camera_matrix", "cameraMatrix", "K"];
        let matrix = self.numbers(&names)?;
        let name = self.get(&names).map_or("camera_matrix", |(name, _)| name);
        let expected = "the rows (fx, s, cx), (0, fy, cy), (0, 0, 1) are needed";
        let Some(&[fx, skew, cx, zero, fy, cy, a, b, one]) = matrix.as_deref() else {
            let found = matrix.map_or("missing".into(), |m| format!("{} numbers", m.len()));
            return Err(unsupported(name, found, expected));
        };
        if [zero, a, b, one] != [0.0, 0.0, 0.0, 1.0] {
            return Err(unsupported(name, format!("{zero}, {a}, {b}, {one} below"), expected));
        }
        let principal_distance = [fx, fy];
        let principal_point = [cx + 0.5, cy + 0.5];
        let names = ["distortion_coefficients", "dist_coeffs", "distCoeffs", "D"];
        let coefficients = self.numbers(&names)?.unwrap_or_default();
        let name = self.get(&names).map_or(names[0], |(name, _)| name);
        let count = coefficients.len();
        let refused = |expected| Err(unsupported(name, format!("{count} numbers"), expected));
        let lens = |lens| Interior::Lens {
            principal_distance,
            principal_point,
            skew,
            lens: Box::new(lens),
        };
        if let Some(xi) = self.numbers(&["xi"])? {
            let (&[xi], &[k1, k2, p1, p2]) = (&xi[..], &coefficients[..]) else {
                return refused("omnidir has one xi and four coefficients, k1 k2 p1 p2");
            };
            return Ok(lens(Lens::Unified { xi, k: [k1, k2, 0.0], p: [p1, p2] }));
        }
        if self.is_fisheye()? {
            let k = match coefficients[..] {
                [] => [0.0; 4],
                [k1, k2, k3, k4] => [k1, k2, k3, k4],
                _ => return refused("a fisheye has four coefficients"),
            };
            let projection = FisheyeProjection::Equidistant;
            return Ok(lens(Lens::Fisheye { projection, k }));
        }
        let mut c = [0.0; 14];
        if ![0, 4, 5, 8, 12, 14].contains(&count) {
            return refused("OpenCV's models have 4, 5, 8, 12 or 14 coefficients");
        }
        c[..count].copy_from_slice(&coefficients);
        let [k1, k2, p1, p2, k3, k4, k5, k6, s @ .., tx, ty] = c;
        Ok(match count {
            0 => Interior::Pinhole { principal_distance, principal_point, skew },
            4 | 5 => Interior::Brown {
                principal_distance,
                principal_point,
                skew,
                k: [k1, k2, k3],
                p: [p1, p2],
            },
            _ => {
                lens(Lens::Rational { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2], s, tau: [tx, ty] })
            }
        })
    }

    fn is_fisheye(&self) -> Result<bool, FieldError> {
        let flag = match self.0.get("fisheye_model") {
            Some(Value::Bool(flag)) => *flag,
            Some(value) => value.as_f64().is_some_and(|v| v != 0.0),
            None => false,
        };
        match self.0.get("distortion_model").and_then(Value::as_str) {
            Some("equidistant" | "fisheye") => Ok(true),
            None | Some("plumb_bob" | "rational_polynomial" | "thin_prism" | "none" | "") => {
                Ok(flag)
            }
            Some(other) => Err(unsupported(
                "distortion_model",
                other,
                "plumb_bob, rational_polynomial, thin_prism, equidistant and fisheye are read",
            )),
        }
    }

    /// The poses by names of photographs.
    fn exteriors(&self) -> Result<Vec<(String, Exterior)>, Error> {
        let pose = |r: &[f64], t: &[f64]| {
            let turn = RotationVector::new(Vector3::from_column_slice(r)).rotation();
            let t = Vector3::from_column_slice(t);
            let exterior = ExteriorOrientation::from_rotation_translation(turn, t);
            Exterior::from_orientation(&exterior)
        };
        if let Some(rows) = self.numbers(&["extrinsic_parameters"])? {
            if rows.is_empty() || rows.len() % 6 != 0 {
                let found = format!("{} numbers", rows.len());
                let expected = "rows of rvec and tvec, six numbers each, are needed";
                return Err(unsupported("extrinsic_parameters", found, expected).into());
            }
            let views = rows.chunks(6).enumerate();
            return Ok(views.map(|(i, v)| (format!("view_{i}"), pose(&v[..3], &v[3..]))).collect());
        }
        let (turn, shift) = (self.numbers(&["rvec"])?, self.numbers(&["tvec"])?);
        match (turn.as_deref(), shift.as_deref()) {
            (None, None) => Ok(vec![("camera".into(), pose(&[0.0; 3], &[0.0; 3]))]),
            (Some(r @ [_, _, _]), Some(t @ [_, _, _])) => Ok(vec![("camera".into(), pose(r, t))]),
            _ => {
                let expected = "rvec and tvec of three numbers each are needed, or neither";
                Err(unsupported("rvec", "not both vectors", expected).into())
            }
        }
    }
}

fn flatten(value: &Value, into: &mut Vec<f64>) -> Option<()> {
    match value {
        Value::Array(list) => list.iter().try_for_each(|v| flatten(v, into)),
        other => {
            into.push(other.as_f64()?);
            Some(())
        }
    }
}

/// The start of a value, for a message.
fn brief(value: &Value) -> String {
    value.to_string().chars().take(40).collect()
}

/// The calibration file of a camera, with its pose as `rvec` and `tvec`.
///
/// # Errors
/// [`FieldProblem::Unsupported`] for a model that OpenCV does not have, and those of [`CameraFile::check`](Document::check).
pub fn to_text(camera: &CameraFile, form: Form) -> Result<String, Error> {
    camera.check()?;
    let plain = camera.interior.plain([camera.width, camera.height]);
    let refused = |expected| Err(unsupported("interior.model", plain.model(), expected).into());
    let (f, c, skew, lens): (_, _, _, Vec<(&str, Vec<f64>)>) = match &plain {
        Interior::Pinhole { principal_distance, principal_point, skew } => (
            principal_distance,
            principal_point,
            skew,
            vec![("distortion_coefficients", vec![0.0; 5])],
        ),
        Interior::Brown { principal_distance, principal_point, skew, k, p } => {
            let coefficients = vec![k[0], k[1], p[0], p[1], k[2]];
            let lens = vec![("distortion_coefficients", coefficients)];
            (principal_distance, principal_point, skew, lens)
        }
        Interior::Lens { principal_distance, principal_point, skew, lens } => {
            let lens = match &**lens {
                Lens::Rational { k, p, s, tau } => {
                    let mut all = vec![k[0], k[1], p[0], p[1], k[2], k[3], k[4], k[5]];
                    if *s != [0.0; 4] || *tau != [0.0; 2] {
                        all.extend(s);
                    }
                    if *tau != [0.0; 2] {
                        all.extend(tau);
                    }
                    vec![("distortion_coefficients", all)]
                }
                Lens::Fisheye { projection: FisheyeProjection::Equidistant, k } => {
                    vec![("distortion_coefficients", k.to_vec()), ("fisheye_model", vec![])]
                }
                Lens::Unified { xi, k: [k1, k2, 0.0], p } => {
                    vec![("distortion_coefficients", vec![*k1, *k2, p[0], p[1]]), ("xi", vec![*xi])]
                }
                _ => return refused("OpenCV has no such model"),
            };
            (principal_distance, principal_point, skew, lens)
        }
        _ => return refused("OpenCV has no such model"),
    };
    // `projectPoints` and `undistortPoints` pass over the skew in the matrix; `omnidir` has it.
    if *skew != 0.0 && lens.iter().all(|(name, _)| *name != "xi") {
        return Err(unsupported("interior.skew", skew.to_string(), "OpenCV has no skew").into());
    }
    let exterior = camera.exterior.orientation()?;
    let turn = RotationVector::from_rotation(&exterior.camera_from_world());
    let matrix = vec![f[0], *skew, c[0] - 0.5, 0.0, f[1], c[1] - 0.5, 0.0, 0.0, 1.0];
    let mut fields: Vec<(&str, [usize; 2], Vec<f64>)> = vec![("camera_matrix", [3, 3], matrix)];
    for (name, values) in lens {
        fields.push((name, [1, values.len()], values));
    }
    fields.push(("rvec", [3, 1], turn.vector().as_slice().to_vec()));
    fields.push(("tvec", [3, 1], exterior.pose().translation().as_slice().to_vec()));
    Ok(match form {
        Form::Yaml => yaml(camera, &fields),
        Form::Json => json_text(camera, &fields),
        Form::Xml => xml_text(camera, &fields),
    })
}

/// To a file, in the form that its name says, atomically.
///
/// # Errors
/// As [`to_text`] and [`write_atomically`].
pub fn write(camera: &CameraFile, path: &Path) -> Result<(), Error> {
    let text = to_text(camera, Form::of(path)).map_err(|e| e.in_file(path))?;
    write_atomically(path, |w| w.write_all(text.as_bytes()))
}

fn yaml(camera: &CameraFile, fields: &[(&str, [usize; 2], Vec<f64>)]) -> String {
    use std::fmt::Write as _;
    let mut text = String::from(YAML_HEADER);
    let _ = writeln!(text, "image_width: {}\nimage_height: {}", camera.width, camera.height);
    for (name, [rows, cols], values) in fields {
        if values.is_empty() {
            let _ = writeln!(text, "{name}: 1");
            continue;
        }
        // A number without a point is an integer to OpenCV.
        let list: Vec<_> = values.iter().map(|v| format!("{v:?}")).collect();
        let _ = writeln!(
            text,
            "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {} ]",
            list.join(", ")
        );
    }
    text
}

fn xml_text(camera: &CameraFile, fields: &[(&str, [usize; 2], Vec<f64>)]) -> String {
    use std::fmt::Write as _;
    let mut text = String::from("<?xml version=\"1.0\"?>\n<opencv_storage>\n");
    for (name, size) in [("image_width", camera.width), ("image_height", camera.height)] {
        let _ = writeln!(text, "<{name}>{size}</{name}>");
    }
    for (name, [rows, cols], values) in fields {
        if values.is_empty() {
            let _ = writeln!(text, "<{name}>1</{name}>");
            continue;
        }
        // As in YAML.
        let list: Vec<_> = values.iter().map(|v| format!("{v:?}")).collect();
        let _ = writeln!(
            text,
            "<{name} type_id=\"opencv-matrix\">\n  <rows>{rows}</rows>\n  <cols>{cols}</cols>\n  <dt>d</dt>\n  \
             <data>\n    {}</data></{name}>",
            list.join(" ")
        );
    }
    text.push_str("</opencv_storage>\n");
    text
}

fn json_text(camera: &CameraFile, fields: &[(&str, [usize; 2], Vec<f64>)]) -> String {
    let mut object = Map::new();
    object.insert("image_width".into(), camera.width.into());
    object.insert("image_height".into(), camera.height.into());
    for (name, [rows, cols], values) in fields {
        let value = if values.is_empty() {
            json!(1)
        } else {
            json!({ "type_id": "opencv-matrix", "rows": rows, "cols": cols, "dt": "d", "data": values })
        };
        object.insert((*name).into(), value);
    }
    format!("{:#}\n", Value::Object(object))
}
