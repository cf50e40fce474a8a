//! Agisoft Metashape: the calibration file and the exported cameras, XML.
//!
//! A camera's `<transform>` is the row-major 4 × 4 matrix from its axes, which are this crate's, to the chunk's frame; the
//! `<transform>` of its component or of the chunk goes on to the reference frame,
//!
//! ```text
//! X_chunk = R_c X_camera + C,   X_reference = s R X_chunk + t
//! ```
//!
//! and photographs are read in the reference frame: geocentric metres where the chunk has a geographic or a projected system, else
//! its local one. The scale moves centres only. Without such a transform they are in the chunk's frame. Pixels
//! count from the top-left corner, cx and cy from the middle of the picture. Equations (Agisoft, *Metashape User Manual*, appendix
//! *Camera models*):
//!
//! [`Lens::Metashape`], [`Lens::Fisheye`] and [`Lens::ThinPrismFisheye`] have p₁ and p₂ in the order of their own formulas.
//!
//! | type | equation | interior |
//! | --- | --- | --- |
//! | `frame` | [`Metashape`](collinear::camera::Metashape), f + b₁, f, b₂ | [`Interior::Brown`] where k₄, p₃ and p₄ are 0, else [`Lens::Metashape`] |
//! | `fisheye`, `equidistant_fisheye` | the same of (x, y) θ/r | [`Lens::Fisheye`], with p₁ and p₂ [`Lens::ThinPrismFisheye`] |
//! | `spherical`, `cylindrical` | w/2π for each radian | [`Interior::Panorama`] |

mod write;

use std::collections::BTreeMap;
use std::path::Path;

use collinear::camera::{InteriorOrientation, Panorama};
use collinear::nalgebra::{Matrix3, Vector3};
use roxmltree::Node;

pub use write::{to_text, write};

use crate::camera::{CameraFile, Exterior, FisheyeProjection, Interior, Lens, Rotation};
use crate::check::in_range;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::{Document, read_text};
use crate::xml;

/// The photographs of exported cameras, by their labels, or the one camera of a calibration file, at the origin. Cameras
/// without a pose are no photographs and are left out; disabled ones are read. What a rolling shutter adds to a pose is passed over.
///
/// # Errors
/// [`ErrorKind::Foreign`] for text that is no XML, [`ErrorKind::NotCameras`] for XML of something else, and
/// [`ErrorKind::Field`] with the sensor or the camera: [`FieldProblem::Unsupported`] for types that no model here expresses.
///
/// # Example
/// By hand: f = 500 on 640 × 480, cx = 4; (0.5, −0.25, 1) is at 320 + 4 + 250, 240 − 125.
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
///
/// let text = "<calibration><projection>frame</projection><width>640</width><height>480</height>\
///     <f>500</f><cx>4</cx></calibration>";
/// let (_, camera) = collinear_io::metashape::parse(text)?.remove(0);
/// let image = camera.camera()?.sensor().project(&Point3::new(0.5, -0.25, 1.0))?;
/// assert_eq!(image, Point2::new(574.0, 115.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse(text: &str) -> Result<Vec<(String, CameraFile)>, Error> {
    let document = xml::parse(text)
        .map_err(|e| ErrorKind::Foreign { program: "Metashape", reason: e.to_string() })?;
    let root = document.root_element();
    match root.tag_name().name() {
        "calibration" => {
            let kind = child(root, "projection").map_or("frame", content);
            let size = [pixels(root, "width")?, pixels(root, "height")?];
            let file = CameraFile {
                width: size[0],
                height: size[1],
                interior: interior(Some(root), kind, size)?,
                exterior: Exterior {
                    projection_center: [0.0; 3],
                    rotation: Rotation::QuaternionWxyz([1.0, 0.0, 0.0, 0.0]),
                },
            };
            file.check()?;
            Ok(vec![("camera".into(), file)])
        }
        "document" => {
            let chunks: Vec<_> = root.children().filter(|n| n.has_tag_name("chunk")).collect();
            match chunks[..] {
                [chunk] => exported(chunk),
                [] => Err(ErrorKind::NotCameras.into()),
                _ => {
                    let found = format!("{} chunks", chunks.len());
                    let expected = "each has a frame of its own: export one chunk";
                    Err(unsupported("chunk", found, expected).into())
                }
            }
        }
        _ => Err(ErrorKind::NotCameras.into()),
    }
}

/// As [`parse`], from a file.
///
/// # Errors
/// As [`parse`], and those of reading.
pub fn read(path: &Path) -> Result<Vec<(String, CameraFile)>, Error> {
    read_text(path).and_then(|text| parse(&text)).map_err(|e| e.in_file(path))
}

fn unsupported(field: &str, found: impl Into<String>, expected: &'static str) -> FieldError {
    FieldError::new(field, FieldProblem::Unsupported { found: found.into(), expected })
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(name))
}

fn content<'a>(node: Node<'a, '_>) -> &'a str {
    node.text().unwrap_or_default().trim()
}

/// The finite numbers of an element.
fn numbers<const N: usize>(node: Node<'_, '_>, field: &str) -> Result<[f64; N], FieldError> {
    let text = content(node);
    let all: Option<Vec<f64>> = text
        .split_whitespace()
        .map(|word| word.parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    all.and_then(|all| all.try_into().ok()).ok_or_else(|| {
        let expected = match N {
            1 => "a number is needed",
            3 => "three numbers are needed",
            9 => "nine numbers are needed",
            _ => "sixteen numbers are needed",
        };
        unsupported(field, text.chars().take(40).collect::<String>(), expected)
    })
}

/// A number, where it is there.
fn number(node: Option<Node<'_, '_>>, field: &str) -> Result<Option<f64>, FieldError> {
    let found = node.and_then(|n| child(n, field));
    found.map(|n| numbers::<1>(n, field).map(|[v]| v)).transpose()
}

/// A side of a picture, as an attribute or as an element.
fn pixels(node: Node<'_, '_>, field: &str) -> Result<u32, FieldError> {
    let text = node.attribute(field).or_else(|| child(node, field).map(content));
    let value = text.and_then(|t| t.parse::<f64>().ok()).unwrap_or(f64::NAN);
    let expected = "a whole number of pixels";
    in_range(field, value, expected, |v| {
        v.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&v)
    })?;
    // In range: checked above.
    Ok(value as u32)
}

/// The interior of a calibration; a panorama needs none.
fn interior(
    calibration: Option<Node<'_, '_>>,
    kind: &str,
    size: [u32; 2],
) -> Result<Interior, FieldError> {
    let get = |field: &str| Ok::<_, FieldError>(number(calibration, field)?.unwrap_or(0.0));
    for field in ["fx", "fy", "skew"] {
        if number(calibration, field)?.is_some() {
            let expected = "PhotoScan before 1.2 wrote it: save the calibration with a later one";
            return Err(unsupported(field, "there", expected));
        }
    }
    let f = number(calibration, "f")?;
    let c = [get("cx")?, get("cy")?];
    let k = [get("k1")?, get("k2")?, get("k3")?, get("k4")?];
    let p = [get("p1")?, get("p2")?, get("p3")?, get("p4")?];
    let b = [get("b1")?, get("b2")?];
    let [width, height] = size.map(f64::from);
    let fisheye = match kind {
        "frame" => false,
        "fisheye" | "equidistant_fisheye" => true,
        "spherical" | "cylindrical" => {
            let plain = k == [0.0; 4] && p == [0.0; 4] && b == [0.0; 2];
            if !plain {
                return Err(unsupported("k1", "a lens", "a panorama has none"));
            }
            let projection =
                if kind == "spherical" { Panorama::Equirectangular } else { Panorama::Cylindrical };
            return Ok(panorama(projection, f, c, [width, height]));
        }
        other => {
            let expected =
                "frame, fisheye, equidistant_fisheye, spherical and cylindrical are read";
            return Err(unsupported("type", other, expected));
        }
    };
    let f = f.unwrap_or(f64::NAN);
    in_range("f", f, "a number above 0", |v| v > 0.0)?;
    in_range("b1", b[0], "a number above −f", |v| f + v > 0.0)?;
    let interior = InteriorOrientation::from_metashape([width, height], f, c, b)
        .map_err(|_| unsupported("f", f.to_string(), "numbers of a camera are needed"))?;
    let principal_distance = interior.principal_distance();
    let principal_point = interior.principal_point().into();
    let skew = interior.skew();
    let lens =
        |lens| Interior::Lens { principal_distance, principal_point, skew, lens: Box::new(lens) };
    let [p1, p2, p3, p4] = p;
    Ok(match (fisheye, k, p) {
        (false, [k1, k2, k3, 0.0], [_, _, 0.0, 0.0]) => {
            // p₁ and p₂ have each other's places.
            let (k, p) = ([k1, k2, k3], [p2, p1]);
            if k == [0.0; 3] && p == [0.0; 2] {
                Interior::Pinhole { principal_distance, principal_point, skew }
            } else {
                Interior::Brown { principal_distance, principal_point, skew, k, p }
            }
        }
        (false, ..) => lens(Lens::Metashape { k, p }),
        (true, _, [0.0, 0.0, 0.0, 0.0]) => {
            lens(Lens::Fisheye { projection: FisheyeProjection::Equidistant, k })
        }
        (true, _, [_, _, 0.0, 0.0]) => lens(Lens::ThinPrismFisheye { k, p: [p2, p1], s: [0.0; 2] }),
        (true, ..) => {
            let found = format!("{p3}, {p4}");
            return Err(unsupported("p3", found, "p3 and p4 are read of frame cameras"));
        }
    })
}

/// A panorama, whose scale is w/2π where the file has none.
fn panorama(
    projection: Panorama,
    f: Option<f64>,
    c: [f64; 2],
    [width, height]: [f64; 2],
) -> Interior {
    let turn = width / std::f64::consts::TAU;
    // The file's has about seventeen digits.
    let f = f.filter(|f| (f - turn).abs() > 1e-12 * turn).unwrap_or(turn);
    let whole = projection.principal_distance(width, height) == [f; 2];
    Interior::Panorama {
        projection,
        principal_distance: (!whole).then_some([f; 2]),
        principal_point: (c != [0.0; 2]).then_some([0.5 * width + c[0], 0.5 * height + c[1]]),
    }
}

/// From a chunk's frame to the reference frame: s, R, t.
#[derive(Clone, Copy)]
struct Similarity {
    scale: f64,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

impl Similarity {
    const NONE: Self = Self {
        scale: 1.0,
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// That of a chunk or of a component, where it has one.
    fn of(node: Node<'_, '_>) -> Result<Option<Self>, FieldError> {
        let Some(transform) = child(node, "transform") else { return Ok(None) };
        if transform.children().any(|n| n.is_text() && !content(n).is_empty()) {
            let found: String = content(transform).chars().take(40).collect();
            let expected =
                "rotation, translation and scale are needed, as Metashape 1.5 and later write them";
            return Err(unsupported("transform", found, expected));
        }
        let mut found = Self::NONE;
        if let Some(node) = child(transform, "rotation") {
            found.rotation = Matrix3::from_row_slice(&numbers::<9>(node, "transform.rotation")?);
        }
        if let Some(node) = child(transform, "translation") {
            found.translation = Vector3::from(numbers::<3>(node, "transform.translation")?);
        }
        if let Some(node) = child(transform, "scale") {
            let [scale] = numbers(node, "transform.scale")?;
            in_range("transform.scale", scale, "a number above 0", |v| v > 0.0)?;
            found.scale = scale;
        }
        Ok(Some(found))
    }
}

/// The sensor's type, picture size and interior.
fn sensor(node: Node<'_, '_>) -> Result<([u32; 2], Interior), FieldError> {
    let of_class = |class: &str| {
        let is = |n: &Node<'_, '_>| {
            n.has_tag_name("calibration") && n.attribute("class").unwrap_or("adjusted") == class
        };
        node.children().find(is)
    };
    let calibration = of_class("adjusted").or_else(|| of_class("initial"));
    let resolution =
        calibration.and_then(|c| child(c, "resolution")).or_else(|| child(node, "resolution"));
    let resolution = resolution.unwrap_or(node);
    let size = [pixels(resolution, "width")?, pixels(resolution, "height")?];
    let kind = calibration.and_then(|c| c.attribute("type")).or_else(|| node.attribute("type"));
    Ok((size, interior(calibration, kind.unwrap_or("frame"), size)?))
}

/// The elements of a name anywhere below a list of the chunk's.
fn below<'a, 'i>(chunk: Node<'a, 'i>, list: &str, name: &str) -> Vec<Node<'a, 'i>> {
    let found = child(chunk, list).into_iter().flat_map(|n| n.descendants());
    found.filter(|n| n.has_tag_name(name)).collect()
}

fn exported<'a, 'i>(chunk: Node<'a, 'i>) -> Result<Vec<(String, CameraFile)>, Error> {
    // A document may have thousands of cameras, of a few sensors and components.
    let cameras = below(chunk, "cameras", "camera");
    let by_id = |list: &[Node<'a, 'i>]| -> BTreeMap<&'a str, Node<'a, 'i>> {
        list.iter().filter_map(|n| Some((n.attribute("id")?, *n))).collect()
    };
    let by_camera = by_id(&cameras);
    let by_sensor = by_id(&below(chunk, "sensors", "sensor"));
    let by_component = by_id(&below(chunk, "components", "component"));
    let whole = Similarity::of(chunk).map_err(|e| e.under("chunk"))?;
    let (mut sensors, mut components) = (BTreeMap::new(), BTreeMap::new());
    let mut photographs = Vec::new();
    for node in cameras {
        let label = node.attribute("label").or(node.attribute("id")).unwrap_or_default();
        let under = |e: FieldError| Error::from(e.under(&format!("cameras[{label:?}]")));
        let Some(transform) = child(node, "transform") else {
            let master = node.attribute("master_id").filter(|m| Some(*m) != node.attribute("id"));
            let posed =
                |m: &str| by_camera.get(m).is_some_and(|n| child(*n, "transform").is_some());
            if master.is_some_and(posed) {
                let expected =
                    "its pose is its master's and its sensor's together, which are not read";
                return Err(under(unsupported("master_id", master.unwrap_or_default(), expected)));
            }
            continue;
        };
        let id = node.attribute("sensor_id").unwrap_or_default();
        if !sensors.contains_key(id) {
            let found = by_sensor.get(id).ok_or_else(|| {
                let known = by_sensor.keys().map(|k| (*k).to_owned()).collect();
                let name = id.to_owned();
                let problem = FieldProblem::UnknownName { what: "a sensor", name, known };
                under(FieldError::new("sensor_id", problem))
            })?;
            let read = sensor(*found).map_err(|e| e.under(&format!("sensors[{id}]")))?;
            sensors.insert(id, read);
        }
        let Some(([width, height], interior)) = sensors.get(id) else { continue };
        let id = node.attribute("component_id").unwrap_or_default();
        if !components.contains_key(id) {
            let own = match by_component.get(id) {
                Some(n) => Similarity::of(*n).map_err(|e| e.under(&format!("components[{id}]")))?,
                None => None,
            };
            components.insert(id, own.or(whole).unwrap_or(Similarity::NONE));
        }
        let Some(Similarity { scale, rotation, translation }) = components.get(id) else {
            continue;
        };
        let m: [f64; 16] = numbers(transform, "transform").map_err(under)?;
        if m[12..] != [0.0, 0.0, 0.0, 1.0] {
            let expected = "0, 0, 0, 1 are needed in its last row";
            return Err(under(unsupported("transform", format!("{:?}", &m[12..]), expected)));
        }
        let [r0, r1, r2, c0, r3, r4, r5, c1, r6, r7, r8, c2, ..] = m;
        let world_from_camera = rotation * Matrix3::new(r0, r1, r2, r3, r4, r5, r6, r7, r8);
        let center = rotation * Vector3::new(c0, c1, c2) * *scale + translation;
        let file = CameraFile {
            width: *width,
            height: *height,
            interior: interior.clone(),
            exterior: Exterior {
                projection_center: center.into(),
                // Its rows are the columns of world_from_camera.
                rotation: Rotation::RotationMatrix(world_from_camera.into()),
            },
        };
        file.check().map_err(under)?;
        photographs.push((label.to_owned(), file));
    }
    Ok(photographs)
}
