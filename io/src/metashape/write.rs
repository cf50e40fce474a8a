//! Exported cameras, written.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use collinear::camera::Panorama;

use super::unsupported;
use crate::atomic::write_atomically;
use crate::camera::{CameraFile, FisheyeProjection, Interior, Lens};
use crate::check::finite;
use crate::error::{Error, FieldError};
use crate::json::Document;
use crate::xml::escaped;

/// A document of exported cameras, as Metashape 1.5 and later read it. The world is the chunk's frame. Photographs with one
/// camera share a sensor.
///
/// # Errors
/// [`FieldProblem::Unsupported`](crate::FieldProblem::Unsupported) with the photograph's name for a camera that Metashape does not
/// have, and those of [`CameraFile::check`](Document::check).
///
/// # Example
/// fx = 501 and fy = 500 are f = 500 and b₁ = 1; the principal point (324, 240) of 640 × 480 is cx = 4.
///
/// ```
/// use collinear_io::Document;
/// use collinear_io::camera::CameraFile;
///
/// let file = CameraFile::parse(
///     r#"{ "collinear": "camera", "version": 1, "width": 640, "height": 480,
///     "interior": { "model": "pinhole", "principal_distance": [501, 500], "principal_point": [324, 240] },
///     "exterior": { "projection_center": [1, 2, 3], "quaternion_wxyz": [1, 0, 0, 0] } }"#,
/// )?;
/// let text = collinear_io::metashape::to_text(&[("a.jpg".into(), file)])?;
/// assert!(text.contains("<f>500</f><cx>4</cx><cy>0</cy><b1>1</b1>"));
/// assert!(text.contains("<transform>1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1</transform>"));
/// # Ok::<(), collinear_io::Error>(())
/// ```
pub fn to_text(photographs: &[(String, CameraFile)]) -> Result<String, Error> {
    let mut sensors: Vec<([u32; 2], Calibration)> = Vec::new();
    let mut cameras = String::new();
    for (id, (name, file)) in photographs.iter().enumerate() {
        let under = |e: FieldError| Error::from(e.under(name));
        file.check().map_err(under)?;
        let size = [file.width, file.height];
        let sensor = (size, Calibration::of(&file.interior.plain(size), size).map_err(under)?);
        let number = sensors.iter().position(|s| *s == sensor).unwrap_or_else(|| {
            sensors.push(sensor);
            sensors.len() - 1
        });
        let exterior = file.exterior.orientation()?;
        let turn = exterior.camera_from_world().inverse();
        let (r, c) = (turn.matrix(), exterior.projection_center());
        let rows: Vec<String> =
            (0..3).map(|i| format!("{} {} {} {}", r[(i, 0)], r[(i, 1)], r[(i, 2)], c[i])).collect();
        let label = escaped(name);
        let _ = writeln!(
            cameras,
            "      <camera id=\"{id}\" sensor_id=\"{number}\" label=\"{label}\" enabled=\"true\">\n        \
             <transform>{} 0 0 0 1</transform>\n      </camera>",
            rows.join(" ")
        );
    }
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"1.5.0\">\n  \
         <chunk label=\"Chunk 1\" enabled=\"true\">\n",
    );
    let _ = writeln!(text, "    <sensors next_id=\"{}\">", sensors.len());
    for (id, ([width, height], Calibration { kind, fields })) in sensors.iter().enumerate() {
        let mut values = String::new();
        for (name, value) in fields {
            let _ = write!(values, "<{name}>{value}</{name}>");
        }
        let resolution = format!("<resolution width=\"{width}\" height=\"{height}\"/>");
        let _ = writeln!(
            text,
            "      <sensor id=\"{id}\" label=\"camera {}\" type=\"{kind}\">\n        {resolution}\n        \
             <calibration type=\"{kind}\" class=\"adjusted\">\n          {resolution}\n          {values}\n        \
             </calibration>\n      </sensor>",
            id + 1
        );
    }
    let next = photographs.len();
    let _ = write!(
        text,
        "    </sensors>\n    <cameras next_id=\"{next}\" next_group_id=\"0\">\n{cameras}    </cameras>\n  \
         </chunk>\n</document>\n"
    );
    Ok(text)
}

/// To a file, atomically.
///
/// # Errors
/// As [`to_text`] and [`write_atomically`].
pub fn write(photographs: &[(String, CameraFile)], path: &Path) -> Result<(), Error> {
    let text = to_text(photographs).map_err(|e| e.in_file(path))?;
    write_atomically(path, |w| w.write_all(text.as_bytes()))
}

/// What a sensor has of its own.
#[derive(PartialEq)]
struct Calibration {
    kind: &'static str,
    fields: Vec<(&'static str, f64)>,
}

impl Calibration {
    fn of(plain: &Interior, size: [u32; 2]) -> Result<Self, FieldError> {
        let [w, h] = size.map(f64::from);
        let refused = |expected| Err(unsupported("interior.model", plain.model(), expected));
        let none = "Metashape has no such model";
        let (kind, f, c, skew, k, p) = match plain {
            Interior::Pinhole { principal_distance: f, principal_point: c, skew } => {
                ("frame", f, c, skew, [0.0; 4], [0.0; 4])
            }
            // p₁ and p₂ have each other's places.
            Interior::Brown { principal_distance: f, principal_point: c, skew, k, p } => {
                ("frame", f, c, skew, [k[0], k[1], k[2], 0.0], [p[1], p[0], 0.0, 0.0])
            }
            Interior::Lens { principal_distance: f, principal_point: c, skew, lens } => {
                match &**lens {
                    Lens::Metashape { k, p } => ("frame", f, c, skew, *k, *p),
                    Lens::Fisheye { projection: FisheyeProjection::Equidistant, k } => {
                        ("fisheye", f, c, skew, *k, [0.0; 4])
                    }
                    Lens::ThinPrismFisheye { k, p, s: [0.0, 0.0] } => {
                        ("fisheye", f, c, skew, *k, [p[1], p[0], 0.0, 0.0])
                    }
                    Lens::ThinPrismFisheye { .. } => return refused("Metashape has no thin prism"),
                    _ => return refused(none),
                }
            }
            Interior::Panorama { projection, principal_distance, principal_point } => {
                let f = principal_distance.unwrap_or_else(|| projection.principal_distance(w, h));
                let middle = principal_point.is_none_or(|c| c == [0.5 * w, 0.5 * h]);
                if f != [w / TAU; 2] || !middle {
                    return refused("Metashape's panoramas are a full turn wide, with one scale");
                }
                let kind = match projection {
                    Panorama::Equirectangular => "spherical",
                    Panorama::Cylindrical => "cylindrical",
                };
                return Ok(Self { kind, fields: vec![("f", f[0])] });
            }
            _ => return refused(none),
        };
        let b1 = f[0] - f[1];
        finite("interior.principal_distance", &[b1])?;
        let mut fields = vec![("f", f[1]), ("cx", c[0] - 0.5 * w), ("cy", c[1] - 0.5 * h)];
        let rest = [
            ("b1", b1),
            ("b2", *skew),
            ("k1", k[0]),
            ("k2", k[1]),
            ("k3", k[2]),
            ("k4", k[3]),
            ("p1", p[0]),
            ("p2", p[1]),
            ("p3", p[2]),
            ("p4", p[3]),
        ];
        // As Metashape does with what it has not adjusted.
        fields.extend(rest.into_iter().filter(|(_, v)| *v != 0.0));
        Ok(Self { kind, fields })
    }
}
