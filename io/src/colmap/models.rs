//! COLMAP's camera models as this crate's, and back.

use collinear::camera::{COLMAP_MODELS, Panorama};

use super::{Camera, model_name};
use crate::camera::{CameraFile, FisheyeProjection, Interior, Lens};
use crate::error::{FieldError, FieldProblem};

/// One of COLMAP's models as one with a name of its own, where there is one.
pub(crate) fn named(model: &str, parameters: &[f64], size: [u32; 2]) -> Option<Interior> {
    // One principal distance or two, by the model's own names.
    let (_, names) = COLMAP_MODELS.iter().find(|(name, _)| *name == model)?;
    let (principal_distance, principal_point, rest) = match (names.first()?, parameters) {
        (&"f", [f, cx, cy, rest @ ..]) => ([*f, *f], [*cx, *cy], rest),
        (&"fx", [fx, fy, cx, cy, rest @ ..]) => ([*fx, *fy], [*cx, *cy], rest),
        (&"w", [w, h]) => {
            let whole = [*w, *h] == size.map(f64::from);
            return whole.then_some(Interior::Panorama {
                projection: Panorama::Equirectangular,
                principal_distance: None,
                principal_point: None,
            });
        }
        _ => return None,
    };
    let skew = 0.0;
    let brown =
        |k: [f64; 3], p| Some(Interior::Brown { principal_distance, principal_point, skew, k, p });
    let lens = |lens| {
        let lens = Box::new(lens);
        Some(Interior::Lens { principal_distance, principal_point, skew, lens })
    };
    let fisheye = |k| lens(Lens::Fisheye { projection: FisheyeProjection::Equidistant, k });
    match (model, rest) {
        ("SIMPLE_PINHOLE" | "PINHOLE", []) => {
            Some(Interior::Pinhole { principal_distance, principal_point, skew })
        }
        ("SIMPLE_RADIAL", [k]) => brown([*k, 0.0, 0.0], [0.0; 2]),
        ("RADIAL", [k1, k2]) => brown([*k1, *k2, 0.0], [0.0; 2]),
        ("OPENCV", [k1, k2, p1, p2]) => brown([*k1, *k2, 0.0], [*p1, *p2]),
        ("FULL_OPENCV", [k1, k2, p1, p2, k3, k4, k5, k6]) => {
            let (k, p) = ([*k1, *k2, *k3, *k4, *k5, *k6], [*p1, *p2]);
            lens(Lens::Rational { k, p, s: [0.0; 4], tau: [0.0; 2] })
        }
        ("SIMPLE_FISHEYE" | "FISHEYE", []) => fisheye([0.0; 4]),
        ("SIMPLE_RADIAL_FISHEYE", [k]) => fisheye([*k, 0.0, 0.0, 0.0]),
        ("RADIAL_FISHEYE", [k1, k2]) => fisheye([*k1, *k2, 0.0, 0.0]),
        ("OPENCV_FISHEYE", [k1, k2, k3, k4]) => fisheye([*k1, *k2, *k3, *k4]),
        ("THIN_PRISM_FISHEYE", [k1, k2, p1, p2, k3, k4, s1, s2]) => {
            lens(Lens::ThinPrismFisheye { k: [*k1, *k2, *k3, *k4], p: [*p1, *p2], s: [*s1, *s2] })
        }
        ("RAD_TAN_THIN_PRISM_FISHEYE", [k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3]) => {
            lens(Lens::Fisheye624 {
                k: [*k0, *k1, *k2, *k3, *k4, *k5],
                p: [*p0, *p1],
                s: [*s0, *s1, *s2, *s3],
            })
        }
        ("FOV", [omega]) => lens(Lens::FieldOfView { omega: *omega }),
        ("SIMPLE_DIVISION" | "DIVISION", [lambda]) => lens(Lens::Division { lambda: *lambda }),
        ("EUCM", [alpha, beta]) => lens(Lens::EnhancedUnified { alpha: *alpha, beta: *beta }),
        _ => None,
    }
}

/// The models that are perspectives: each has those of the parameters below that its own names say.
const PERSPECTIVES: [&str; 6] =
    ["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV"];
const PARAMETERS: [&str; 12] =
    ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"];

/// A perspective's parameter by its model's name: where it stands among [`PARAMETERS`]; f is both principal distances.
fn places(name: &str) -> Vec<usize> {
    let names: &[&str] = match name {
        "f" => &["fx", "fy"],
        "k" => &["k1"],
        name => &[name],
    };
    names.iter().filter_map(|n| PARAMETERS.iter().position(|p| p == n)).collect()
}

impl Camera {
    /// The same camera by another of COLMAP's perspective models, where that has all of its parameters.
    ///
    /// ```
    /// use collinear_io::colmap::Camera;
    ///
    /// let parameters = vec![611.0, 611.0, 512.0, 384.0, -0.1, 0.0, 0.0, 0.0];
    /// let camera = Camera { model: "OPENCV", width: 1024, height: 768, parameters };
    /// let simple = camera.in_model("SIMPLE_RADIAL").ok_or("there")?;
    /// assert_eq!((simple.model, simple.parameters), ("SIMPLE_RADIAL", vec![611.0, 512.0, 384.0, -0.1]));
    /// assert_eq!(camera.in_model("PINHOLE"), None); // has no k1
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub fn in_model(&self, model: &str) -> Option<Self> {
        let known =
            |name: &str| COLMAP_MODELS.iter().find(|(n, _)| *n == name && PERSPECTIVES.contains(n));
        let ((_, from), (model, to)) = (known(self.model)?, known(model)?);
        let mut values = [0.0; PARAMETERS.len()];
        for (name, value) in from.iter().zip(&self.parameters) {
            for place in places(name) {
                values[place] = *value;
            }
        }
        let parameters: Option<Vec<f64>> =
            to.iter().map(|name| places(name).first().map(|place| values[*place])).collect();
        let there = Self { model, width: self.width, height: self.height, parameters: parameters? };
        // What the other model says again must be all that there was.
        let mut again = [0.0; PARAMETERS.len()];
        for (name, value) in to.iter().zip(&there.parameters) {
            for place in places(name) {
                again[place] = *value;
            }
        }
        (again == values).then_some(there)
    }

    /// The COLMAP model of a camera file.
    pub(super) fn from_file(file: &CameraFile) -> Result<Self, FieldError> {
        let refused = |expected| {
            let found = file.interior.model().into();
            let problem = FieldProblem::Unsupported { found, expected };
            Err(FieldError::new("interior.model", problem))
        };
        let none = "COLMAP has no such model";
        let skewed = "COLMAP's models have no skew";
        let of = |model: &'static str, f: &[f64; 2], c: &[f64; 2], rest: &[f64]| {
            let parameters = [&f[..], &c[..], rest].concat();
            Ok(Self { model, width: file.width, height: file.height, parameters })
        };
        let interior = match &file.interior {
            named @ Interior::Colmap { .. } => named.clone(),
            other => other.plain([file.width, file.height]),
        };
        match &interior {
            Interior::Colmap { model, parameters } => match model_name(model) {
                Some(model) => Ok(Self {
                    model,
                    width: file.width,
                    height: file.height,
                    parameters: parameters.clone(),
                }),
                None => refused(none),
            },
            Interior::Pinhole { skew, .. }
            | Interior::Brown { skew, .. }
            | Interior::Lens { skew, .. }
                if *skew != 0.0 =>
            {
                refused(skewed)
            }
            Interior::Pinhole { principal_distance: f, principal_point: c, .. } => {
                of("PINHOLE", f, c, &[])
            }
            Interior::Brown { principal_distance: f, principal_point: c, k, p, .. } => {
                let [k1, k2, k3] = *k;
                if k3 == 0.0 {
                    of("OPENCV", f, c, &[k1, k2, p[0], p[1]])
                } else {
                    of("FULL_OPENCV", f, c, &[k1, k2, p[0], p[1], k3, 0.0, 0.0, 0.0])
                }
            }
            Interior::Lens { principal_distance: f, principal_point: c, lens, .. } => match &**lens
            {
                Lens::Rational { k, p, s: [0.0, 0.0, 0.0, 0.0], tau: [0.0, 0.0] } => {
                    let [k1, k2, k3, k4, k5, k6] = *k;
                    of("FULL_OPENCV", f, c, &[k1, k2, p[0], p[1], k3, k4, k5, k6])
                }
                Lens::Rational { .. } => {
                    refused("COLMAP has no thin prism or tilted sensor of a perspective")
                }
                Lens::Fisheye { projection: FisheyeProjection::Equidistant, k } => {
                    of("OPENCV_FISHEYE", f, c, k)
                }
                Lens::ThinPrismFisheye { k, p, s } => {
                    let [k1, k2, k3, k4] = *k;
                    of("THIN_PRISM_FISHEYE", f, c, &[k1, k2, p[0], p[1], k3, k4, s[0], s[1]])
                }
                Lens::Fisheye624 { k, p, s } => {
                    of("RAD_TAN_THIN_PRISM_FISHEYE", f, c, &[&k[..], p, s].concat())
                }
                Lens::FieldOfView { omega } => of("FOV", f, c, &[*omega]),
                Lens::Division { lambda } => of("DIVISION", f, c, &[*lambda]),
                Lens::EnhancedUnified { alpha, beta } => of("EUCM", f, c, &[*alpha, *beta]),
                _ => refused(none),
            },
            Interior::Panorama {
                projection: Panorama::Equirectangular,
                principal_distance: None,
                principal_point: None,
            } => {
                let [w, h] = [file.width, file.height].map(f64::from);
                let parameters = vec![w, h];
                Ok(Self {
                    model: "EQUIRECTANGULAR",
                    width: file.width,
                    height: file.height,
                    parameters,
                })
            }
            Interior::Panorama { .. } | Interior::Film { .. } | Interior::Orthographic { .. } => {
                refused(none)
            }
        }
    }
}
