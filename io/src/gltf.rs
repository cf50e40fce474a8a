//! Cameras of glTF 2.0, as text and as GLB.
//!
//! A node's camera looks along the node's −z with y up; `yfov` is the angle from the picture's lower edge to its upper one:
//!
//! ```text
//! f = H / (2 tan(yfov/2)),   principal point (W/2, H/2),   W/H = aspectRatio
//! ```
//! (Khronos, *glTF 2.0 Specification*, 3.10). The picture's size comes from outside, or from `width` and `height` in the camera's
//! `extras`, where [`to_text`] writes them. World coordinates are those of the file as they stand, both ways: a camera that is
//! written into a scene lines up with a model in the photographs' own world, whichever of its axes points up. glTF calls y
//! up, and programs may turn all of a file on import; they turn model and cameras alike.

use collinear::geometry::rotation::Quaternion;
use collinear::nalgebra::{Matrix4, Rotation3, Vector3};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::camera::{CameraFile, Interior};
use crate::check::in_range;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::eye::{Ideal, exterior, ideal, world_from_eye};
use crate::json::{Document, from_text};

/// How far from the middle of the picture, in pixels, a principal point may lie for glTF.
const OFF_THE_MIDDLE: f64 = 1e-6;

#[derive(Deserialize)]
struct File {
    asset: Asset,
    #[serde(default)]
    nodes: Vec<Node>,
    #[serde(default)]
    cameras: Vec<Camera>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

#[derive(Deserialize)]
struct Node {
    name: Option<String>,
    camera: Option<usize>,
    #[serde(default)]
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize)]
struct Camera {
    name: Option<String>,
    perspective: Option<Perspective>,
    orthographic: Option<Orthographic>,
    extras: Option<Value>,
}

#[derive(Deserialize)]
struct Perspective {
    #[serde(rename = "aspectRatio")]
    aspect_ratio: Option<f64>,
    yfov: f64,
}

#[derive(Deserialize)]
struct Orthographic {
    xmag: f64,
    ymag: f64,
}

/// Whether text is glTF's JSON.
pub(crate) fn is_like(text: &str) -> bool {
    text.starts_with('{') && ["\"asset\"", "\"version\""].iter().all(|w| text.contains(w))
}

/// The JSON of a GLB.
///
/// # Errors
/// [`ErrorKind::Foreign`] for a file that is cut off, or of another version.
pub fn json_of_glb(bytes: &[u8]) -> Result<&str, Error> {
    let foreign = |reason: String| Error::from(ErrorKind::Foreign { program: "glTF", reason });
    let word = |at: usize| -> Result<usize, Error> {
        let four = bytes.get(at..at + 4).and_then(|b| <[u8; 4]>::try_from(b).ok());
        let four = four.ok_or_else(|| foreign(format!("it is cut off at byte {at}")))?;
        Ok(u32::from_le_bytes(four) as usize)
    };
    if !bytes.starts_with(b"glTF") {
        return Err(foreign("it does not start with glTF".into()));
    }
    let (version, length, kind) = (word(4)?, word(12)?, word(16)?);
    if version != 2 {
        return Err(foreign(format!("it has version {version} of GLB, 2 is read")));
    }
    // "JSON".
    if kind != 0x4e4f_534a {
        return Err(foreign(format!("its first chunk is {kind:#x}, not JSON")));
    }
    let chunk = bytes.get(20..).and_then(|rest| rest.get(..length));
    let chunk = chunk.ok_or_else(|| foreign(format!("its JSON of {length} bytes is cut off")))?;
    std::str::from_utf8(chunk)
        .map_err(|e| ErrorKind::NotText { valid_up_to: 20 + e.valid_up_to() }.into())
}

/// The cameras of the nodes that have one, named like the node, for pictures of this size; without it `extras` must say theirs.
///
/// # Errors
/// [`ErrorKind::NoPictureSize`]; [`ErrorKind::Json`] and [`ErrorKind::Field`] with the path in the file;
/// [`ErrorKind::Foreign`] for another version, nodes that are their own ancestors, and a file without cameras.
///
/// # Example
/// yfov = 90° on 400 × 300: f = 150. The parent is 10 up; 3 right, 4 up and 30 away is pixel (200 + 15, 150 − 20).
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
///
/// let text = r#"{ "asset": { "version": "2.0" },
///   "nodes": [{ "children": [1], "translation": [0, 10, 0] }, { "name": "front", "camera": 0 }],
///   "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.5707963267948966, "znear": 0.1 } }] }"#;
/// let (name, camera) = collinear_io::gltf::parse(text, Some([400, 300]))?.remove(0);
/// let image = camera.camera()?.sensor().project(&Point3::new(3.0, 14.0, -30.0))?;
/// assert!((image - Point2::new(215.0, 130.0)).norm() < 1e-12);
/// assert_eq!(name, "front");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse(text: &str, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    let file: File = from_text(text)?;
    let foreign = |reason: String| Error::from(ErrorKind::Foreign { program: "glTF", reason });
    if !file.asset.version.starts_with("2.") {
        let version: String = file.asset.version.chars().take(40).collect();
        return Err(foreign(format!("it has version {version}, 2.0 is read")));
    }
    let worlds = worlds(&file.nodes)?;
    let mut photographs = Vec::new();
    for (i, (node, world)) in file.nodes.iter().zip(worlds).enumerate() {
        let Some(index) = node.camera else { continue };
        let field = format!("nodes[{i}]");
        let camera = file.cameras.get(index).ok_or_else(|| {
            unknown(format!("{field}.camera"), "a camera", index, file.cameras.len())
        })?;
        let Some(world) = world else {
            return Err(foreign(format!("node {i} is among its own ancestors")));
        };
        let size = size.or_else(|| camera.size()).ok_or(ErrorKind::NoPictureSize)?;
        let interior = camera.interior(size).map_err(|e| e.under(&format!("cameras[{index}]")))?;
        let exterior = exterior(&world).map_err(|e| e.under(&field))?;
        let file = CameraFile { width: size[0], height: size[1], interior, exterior };
        file.check().map_err(|e| e.under(&field))?;
        let name = node.name.as_ref().or(camera.name.as_ref());
        photographs.push((name.cloned().unwrap_or_else(|| format!("node {i}")), file));
    }
    if photographs.is_empty() {
        return Err(foreign("no node of it has a camera".into()));
    }
    Ok(photographs)
}

fn unknown(field: String, what: &'static str, index: usize, count: usize) -> FieldError {
    let known = if count == 0 { vec![] } else { vec![format!("0 to {}", count - 1)] };
    FieldError::new(field, FieldProblem::UnknownName { what, name: index.to_string(), known })
}

/// The world matrix of each node; none where a node is among its own ancestors.
fn worlds(nodes: &[Node]) -> Result<Vec<Option<Matrix4<f64>>>, Error> {
    let mut is_child = vec![false; nodes.len()];
    for (i, node) in nodes.iter().enumerate() {
        for (j, child) in node.children.iter().enumerate() {
            let field = format!("nodes[{i}].children[{j}]");
            match is_child.get_mut(*child) {
                None => return Err(unknown(field, "a node", *child, nodes.len()).into()),
                Some(true) => {
                    let expected = "a node has one parent";
                    let found = child.to_string();
                    let problem = FieldProblem::Unsupported { found, expected };
                    return Err(FieldError::new(field, problem).into());
                }
                Some(is_child) => *is_child = true,
            }
        }
    }
    let mut worlds = vec![None; nodes.len()];
    let roots = is_child.iter().enumerate().filter(|(_, child)| !**child);
    let mut open: Vec<_> = roots.map(|(i, _)| (i, Matrix4::identity())).collect();
    while let Some((i, parent)) = open.pop() {
        let Some(node) = nodes.get(i) else { continue };
        let world = parent * node.local().map_err(|e| e.under(&format!("nodes[{i}]")))?;
        if let Some(entry) = worlds.get_mut(i) {
            *entry = Some(world);
        }
        open.extend(node.children.iter().map(|c| (*c, world)));
    }
    Ok(worlds)
}

impl Node {
    /// M = T R S, or the matrix, column after column.
    fn local(&self) -> Result<Matrix4<f64>, FieldError> {
        if let Some(matrix) = &self.matrix {
            return Ok(Matrix4::from_column_slice(matrix));
        }
        let [x, y, z, w] = self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        crate::camera::check_quaternion("rotation", &[w, x, y, z])?;
        let rotation =
            Quaternion { w, x, y, z }.rotation().unwrap_or_else(|_| Rotation3::identity());
        let shift = Matrix4::new_translation(&Vector3::from(self.translation.unwrap_or_default()));
        let scale = Matrix4::new_nonuniform_scaling(&Vector3::from(self.scale.unwrap_or([1.0; 3])));
        Ok(shift * rotation.to_homogeneous() * scale)
    }
}

impl Camera {
    /// The picture's size, where `extras` says it.
    fn size(&self) -> Option<[u32; 2]> {
        let side = |name: &str| {
            let value = self.extras.as_ref()?.get(name)?.as_u64()?;
            u32::try_from(value).ok().filter(|v| *v > 0)
        };
        Some([side("width")?, side("height")?])
    }

    fn interior(&self, size: [u32; 2]) -> Result<Interior, FieldError> {
        let [width, height] = size.map(f64::from);
        let principal_point = [0.5 * width, 0.5 * height];
        if let Some(Perspective { aspect_ratio, yfov }) = &self.perspective {
            let expected = "an angle between 0 and 3.141592653589793";
            let inside = |v| v > 0.0 && v < std::f64::consts::PI;
            in_range("perspective.yfov", *yfov, expected, inside)?;
            if let Some(aspect) = aspect_ratio {
                let expected = "the picture's width over its height, so that pixels are square";
                let near = |a: f64| (a * height - width).abs() <= 1.0;
                in_range("perspective.aspectRatio", *aspect, expected, near)?;
            }
            let principal_distance = [0.5 * height / (0.5 * yfov).tan(); 2];
            return Ok(Interior::Pinhole { principal_distance, principal_point, skew: 0.0 });
        }
        if let Some(Orthographic { xmag, ymag }) = &self.orthographic {
            for (field, value) in [("orthographic.xmag", xmag), ("orthographic.ymag", ymag)] {
                in_range(field, *value, "a number above 0", |v| v > 0.0)?;
            }
            let pixels_per_unit = [0.5 * width / xmag, 0.5 * height / ymag];
            return Ok(Interior::Orthographic { pixels_per_unit, principal_point });
        }
        let found = "neither perspective nor orthographic".into();
        let expected = "a camera of either kind is needed";
        Err(FieldError::new("type", FieldProblem::Unsupported { found, expected }))
    }
}

/// glTF's text of a scene with these cameras and nothing else, with depths from `near` to `far`, or without end.
///
/// # Errors
/// [`FieldProblem::OffTheMiddle`] for a principal point that glTF cannot say, [`FieldProblem::Unsupported`] for a lens, skew,
/// pixels that are not square, and a parallel projection without `far`.
pub fn to_text(
    photographs: &[(String, CameraFile)],
    near: f64,
    far: Option<f64>,
) -> Result<String, Error> {
    let (mut nodes, mut cameras) = (vec![], vec![]);
    for (name, file) in photographs {
        let (node, camera) = written(name, file, near, far).map_err(|e| match e.kind() {
            ErrorKind::Field(field) => Error::from(field.clone().under(name)),
            _ => e,
        })?;
        nodes.push(node(cameras.len()));
        cameras.push(camera);
    }
    let all: Vec<_> = (0..nodes.len()).collect();
    let scene = json!({
        "asset": { "version": "2.0", "generator": "collinear" },
        "scene": 0,
        "scenes": [{ "nodes": all }],
        "nodes": nodes,
        "cameras": cameras,
    });
    Ok(format!("{scene:#}\n"))
}

/// The node, by the number of its camera, and the camera.
fn written(
    name: &str,
    file: &CameraFile,
    near: f64,
    far: Option<f64>,
) -> Result<(impl FnOnce(usize) -> Value + use<>, Value), Error> {
    let unsupported = |field: &str, found: String, expected| {
        Error::from(FieldError::new(field, FieldProblem::Unsupported { found, expected }))
    };
    let [width, height] = [file.width, file.height].map(f64::from);
    let ideal = ideal(file)?;
    let (Ideal::Perspective(_, [cx, cy]) | Ideal::Orthographic(_, [cx, cy])) = ideal;
    let off = [cx - 0.5 * width, cy - 0.5 * height];
    if off.iter().any(|o| !(o.abs() <= OFF_THE_MIDDLE)) {
        let problem = FieldProblem::OffTheMiddle { off, program: "glTF" };
        return Err(FieldError::new("interior.principal_point", problem).into());
    }
    let mut depths = json!({ "znear": near });
    if let Some(far) = far {
        depths["zfar"] = far.into();
    }
    let (kind, mut body) = match ideal {
        Ideal::Perspective([fx, fy], _) => {
            if fx != fy {
                let expected = "glTF's pixels are square: one principal distance is needed";
                let found = format!("{fx}, {fy}");
                return Err(unsupported("interior.principal_distance", found, expected));
            }
            let yfov = 2.0 * (0.5 * height).atan2(fy);
            ("perspective", json!({ "aspectRatio": width / height, "yfov": yfov }))
        }
        Ideal::Orthographic([sx, sy], _) => {
            if far.is_none() {
                let expected = "glTF's parallel projection needs the depth of a far plane";
                return Err(unsupported("interior.model", "orthographic".into(), expected));
            }
            ("orthographic", json!({ "xmag": 0.5 * width / sx, "ymag": 0.5 * height / sy }))
        }
    };
    if let (Value::Object(body), Value::Object(depths)) = (&mut body, depths) {
        body.extend(depths);
    }
    let q = Quaternion::from_rotation(&world_from_eye(&file.exterior)?);
    let (owned, center) = (name.to_owned(), file.exterior.projection_center);
    let node = move |camera: usize| json!({ "name": owned, "camera": camera, "translation": center, "rotation": [q.x, q.y, q.z, q.w] });
    let extras = json!({ "width": file.width, "height": file.height });
    Ok((node, json!({ "name": name, "type": kind, kind: body, "extras": extras })))
}
