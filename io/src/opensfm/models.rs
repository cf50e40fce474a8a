//! OpenSfM's camera types as this crate's interiors, and back.

use std::f64::consts::TAU;

use collinear::camera::Panorama;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::Camera;
use crate::camera::{FisheyeProjection, Interior, Lens};
use crate::check::in_range;
use crate::error::{FieldError, FieldProblem};

/// A camera as the file has it; which fields count is the type's matter, and the others pass.
#[derive(Deserialize)]
pub(super) struct RawCamera {
    // Files from before there were other types have none.
    projection_type: Option<String>,
    width: u32,
    height: u32,
    focal: Option<f64>,
    focal_x: Option<f64>,
    focal_y: Option<f64>,
    transition: Option<f64>,
    #[serde(default)]
    c_x: f64,
    #[serde(default)]
    c_y: f64,
    #[serde(default)]
    k1: f64,
    #[serde(default)]
    k2: f64,
    #[serde(default)]
    k3: f64,
    #[serde(default)]
    k4: f64,
    #[serde(default)]
    k5: f64,
    #[serde(default)]
    k6: f64,
    #[serde(default)]
    p1: f64,
    #[serde(default)]
    p2: f64,
    #[serde(default)]
    s0: f64,
    #[serde(default)]
    s1: f64,
    #[serde(default)]
    s2: f64,
    #[serde(default)]
    s3: f64,
}

fn unsupported(
    field: &'static str,
    found: impl Into<String>,
    expected: &'static str,
) -> FieldError {
    FieldError::new(field, FieldProblem::Unsupported { found: found.into(), expected })
}

/// The longer side and the middle of a picture, in pixels.
fn frame(width: u32, height: u32) -> (f64, [f64; 2]) {
    (f64::from(width.max(height)), [f64::from(width) / 2.0, f64::from(height) / 2.0])
}

impl RawCamera {
    pub(super) fn check(&self) -> Result<Camera, FieldError> {
        for (field, size) in [("width", self.width), ("height", self.height)] {
            in_range(field, size.into(), "at least 1 pixel", |v| v >= 1.0)?;
        }
        let (width, height) = (self.width, self.height);
        Ok(Camera { width, height, interior: self.interior()? })
    }

    fn interior(&self) -> Result<Interior, FieldError> {
        let (longer, middle) = frame(self.width, self.height);
        let distance = |field: &str, focal: Option<f64>| {
            let focal = focal.unwrap_or(f64::NAN);
            in_range(field, focal, "a finite number above 0", |v| v > 0.0)?;
            Ok(focal * longer)
        };
        // One focal length and the middle, or two and a principal point.
        let centred = || Ok(([distance("focal", self.focal)?; 2], middle));
        let free = || {
            let f = [distance("focal_x", self.focal_x)?, distance("focal_y", self.focal_y)?];
            Ok((f, [middle[0] + self.c_x * longer, middle[1] + self.c_y * longer]))
        };
        let Self { k1, k2, k3, k4, k5, k6, p1, p2, s0, s1, s2, s3, .. } = *self;
        let (k, p) = ([k1, k2, k3], [p1, p2]);
        let fisheye = |k| Lens::Fisheye { projection: FisheyeProjection::Equidistant, k };
        let two = [k1, k2, 0.0, 0.0];
        Ok(match self.projection_type.as_deref().unwrap_or("perspective") {
            "perspective" => brown(centred()?, [k1, k2, 0.0], [0.0; 2]),
            "simple_radial" => brown(free()?, [k1, 0.0, 0.0], [0.0; 2]),
            "radial" => brown(free()?, [k1, k2, 0.0], [0.0; 2]),
            "brown" => brown(free()?, k, p),
            "fisheye" => through(centred()?, fisheye(two)),
            "fisheye_opencv" => through(free()?, fisheye([k1, k2, k3, k4])),
            kind @ ("fisheye62" | "fisheye624") => {
                let s = if kind == "fisheye624" { [s0, s1, s2, s3] } else { [0.0; 4] };
                let lens = one_stage([k1, k2, k3, k4, k5, k6], p, s).ok_or_else(|| {
                    let expected = "its k5, k6, s1 and s3 are read where p and s, or all k, are 0";
                    unsupported("projection_type", kind, expected)
                })?;
                through(free()?, lens)
            }
            "dual" => match self.transition {
                Some(1.0) => brown(centred()?, [k1, k2, 0.0], [0.0; 2]),
                Some(0.0) => through(centred()?, fisheye(two)),
                other => {
                    let found = other.unwrap_or(0.5).to_string();
                    let expected =
                        "a dual camera is read where it is a perspective, 1, or a fisheye, 0";
                    return Err(unsupported("transition", found, expected));
                }
            },
            "spherical" | "equirectangular" => {
                // One scale for both axes: half as high as wide the picture is a whole panorama.
                let whole = self.width == self.height.saturating_mul(2);
                Interior::Panorama {
                    projection: Panorama::Equirectangular,
                    principal_distance: (!whole).then_some([longer / TAU; 2]),
                    principal_point: None,
                }
            }
            other => {
                let expected = "OpenSfM's perspective, simple_radial, radial, brown, fisheye, fisheye_opencv, fisheye62, fisheye624, dual and spherical are read";
                return Err(unsupported("projection_type", other, expected));
            }
        })
    }
}

/// Principal distances and principal point.
type Axes = ([f64; 2], [f64; 2]);

fn brown((principal_distance, principal_point): Axes, k: [f64; 3], p: [f64; 2]) -> Interior {
    Interior::Brown { principal_distance, principal_point, skew: 0.0, k, p }
}

fn through((principal_distance, principal_point): Axes, lens: Lens) -> Interior {
    Interior::Lens { principal_distance, principal_point, skew: 0.0, lens: Box::new(lens) }
}

/// OpenSfM's fisheye of radial, decentring and thin-prism distortion, all three of the undistorted point, where a lens
/// here is the same. [`Lens::Fisheye624`] takes the second and third of the radially distorted point, and so is the same
/// only where there is no radial part or nothing else.
fn one_stage(k: [f64; 6], p: [f64; 2], s: [f64; 4]) -> Option<Lens> {
    let radial = p == [0.0; 2] && s == [0.0; 4];
    match (k, s) {
        ([k1, k2, k3, k4, 0.0, 0.0], _) if radial => {
            let projection = FisheyeProjection::Equidistant;
            Some(Lens::Fisheye { projection, k: [k1, k2, k3, k4] })
        }
        ([k1, k2, k3, k4, 0.0, 0.0], [s0, 0.0, s2, 0.0]) => {
            Some(Lens::ThinPrismFisheye { k: [k1, k2, k3, k4], p, s: [s0, s2] })
        }
        _ if radial || k == [0.0; 6] => Some(Lens::Fisheye624 { k, p: [p[1], p[0]], s }),
        _ => None,
    }
}

/// The fields of a camera, or why OpenSfM has none such.
pub(super) fn fields(camera: &Camera) -> Result<Map<String, Value>, FieldError> {
    let Camera { width, height, interior } = camera;
    let (longer, middle) = frame(*width, *height);
    let plain = interior.plain([*width, *height]);
    let refused = |expected| Err(unsupported("interior.model", plain.model(), expected));
    let none = "OpenSfM has no such model";
    let names = |letter: &str, first: usize, values: &[f64]| -> Vec<(String, f64)> {
        values.iter().enumerate().map(|(i, v)| (format!("{letter}{}", i + first), *v)).collect()
    };
    let radial = |k: &[f64]| names("k", 1, k);
    let decentred = |k: &[f64], p: &[f64; 2]| [radial(k), names("p", 1, p)].concat();
    let centred = |f: &[f64; 2], c: &[f64; 2]| f[0] == f[1] && *c == middle;
    let (kind, axes, lens) = match &plain {
        Interior::Pinhole { skew, .. }
        | Interior::Brown { skew, .. }
        | Interior::Lens { skew, .. }
            if *skew != 0.0 =>
        {
            return refused("OpenSfM's cameras have no skew");
        }
        Interior::Pinhole { principal_distance: f, principal_point: c, .. } => {
            if centred(f, c) {
                ("perspective", Some((f, c)), radial(&[0.0; 2]))
            } else {
                ("brown", Some((f, c)), decentred(&[0.0; 3], &[0.0; 2]))
            }
        }
        Interior::Brown { principal_distance: f, principal_point: c, k, p, .. } => {
            if centred(f, c) && k[2] == 0.0 && *p == [0.0; 2] {
                ("perspective", Some((f, c)), radial(&k[..2]))
            } else {
                ("brown", Some((f, c)), decentred(k, p))
            }
        }
        Interior::Lens { principal_distance: f, principal_point: c, lens, .. } => match &**lens {
            Lens::Fisheye { projection: FisheyeProjection::Equidistant, k } => {
                if centred(f, c) && k[2..] == [0.0; 2] {
                    ("fisheye", Some((f, c)), radial(&k[..2]))
                } else {
                    ("fisheye_opencv", Some((f, c)), radial(k))
                }
            }
            Lens::ThinPrismFisheye { k: [k1, k2, k3, k4], p, s: [s0, s2] } => {
                let lens = decentred(&[*k1, *k2, *k3, *k4, 0.0, 0.0], p);
                if [*s0, *s2] == [0.0; 2] {
                    ("fisheye62", Some((f, c)), lens)
                } else {
                    let prism = names("s", 0, &[*s0, 0.0, *s2, 0.0]);
                    ("fisheye624", Some((f, c)), [lens, prism].concat())
                }
            }
            Lens::Fisheye624 { k, p, s } => {
                let radial = *p == [0.0; 2] && *s == [0.0; 4];
                let lens = decentred(k, &[p[1], p[0]]);
                if radial {
                    ("fisheye62", Some((f, c)), lens)
                } else if *k == [0.0; 6] {
                    ("fisheye624", Some((f, c)), [lens, names("s", 0, s)].concat())
                } else {
                    return refused("OpenSfM's has no second stage: p and s, or all k, must be 0");
                }
            }
            _ => return refused(none),
        },
        Interior::Panorama {
            projection: projection @ Panorama::Equirectangular,
            principal_distance,
            principal_point,
        } => {
            let [w, h] = [*width, *height].map(f64::from);
            let f = principal_distance.unwrap_or_else(|| projection.principal_distance(w, h));
            if f != [longer / TAU; 2] || principal_point.is_some_and(|c| c != middle) {
                return refused(
                    "OpenSfM's panorama turns once over its longer side, with one scale",
                );
            }
            ("spherical", None, vec![])
        }
        _ => return refused(none),
    };
    let mut object = Map::new();
    object.insert("projection_type".into(), kind.into());
    object.insert("width".into(), (*width).into());
    object.insert("height".into(), (*height).into());
    match axes {
        Some((f, _)) if ["perspective", "fisheye"].contains(&kind) => {
            object.insert("focal".into(), (f[0] / longer).into());
        }
        Some((f, c)) => {
            object.insert("focal_x".into(), (f[0] / longer).into());
            object.insert("focal_y".into(), (f[1] / longer).into());
            object.insert("c_x".into(), ((c[0] - middle[0]) / longer).into());
            object.insert("c_y".into(), ((c[1] - middle[1]) / longer).into());
        }
        None => {}
    }
    object.extend(lens.into_iter().map(|(name, value)| (name, value.into())));
    Ok(object)
}
