//! COLMAP's camera models by their names.

use alloc::boxed::Box;

use nalgebra::Point2;

use super::{
    Brown, BrownCamera, CentralCamera, CentralModel, Division, EnhancedUnified, EvenRadial,
    FieldOfView, Fisheye, Gnomonic, InteriorOrientation, NoDistortion, Panorama,
    RadialTangentialThinPrism, Rational, ThinPrism,
};
use crate::error::Error;

/// COLMAP's camera models: name and parameters in its order, COLMAP 4.
///
/// Its pixels start at the top-left corner of the top-left pixel, as this crate's do; nothing is shifted.
pub const COLMAP_MODELS: [(&str, &[&str]); 18] = [
    ("SIMPLE_PINHOLE", &["f", "cx", "cy"]),
    ("PINHOLE", &["fx", "fy", "cx", "cy"]),
    ("SIMPLE_RADIAL", &["f", "cx", "cy", "k"]),
    ("RADIAL", &["f", "cx", "cy", "k1", "k2"]),
    ("OPENCV", &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]),
    ("OPENCV_FISHEYE", &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"]),
    ("FULL_OPENCV", &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
    ("FOV", &["fx", "fy", "cx", "cy", "omega"]),
    ("SIMPLE_RADIAL_FISHEYE", &["f", "cx", "cy", "k"]),
    ("RADIAL_FISHEYE", &["f", "cx", "cy", "k1", "k2"]),
    (
        "THIN_PRISM_FISHEYE",
        &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "sx1", "sy1"],
    ),
    (
        "RAD_TAN_THIN_PRISM_FISHEYE",
        &[
            "fx", "fy", "cx", "cy", "k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1",
            "s2", "s3",
        ],
    ),
    ("SIMPLE_DIVISION", &["f", "cx", "cy", "k"]),
    ("DIVISION", &["fx", "fy", "cx", "cy", "k"]),
    ("SIMPLE_FISHEYE", &["f", "cx", "cy"]),
    ("FISHEYE", &["fx", "fy", "cx", "cy"]),
    ("EUCM", &["fx", "fy", "cx", "cy", "alpha", "beta"]),
    ("EQUIRECTANGULAR", &["w", "h"]),
];

/// The camera of a COLMAP model.
///
/// # Errors
/// [`Error::Unknown`] for another name, [`Error::LengthMismatch`] for another number of parameters, and those of the model's
/// own constructors.
///
/// # Example
/// pycolmap 4.2.1, `img_from_cam` of (0.31, −0.22, 1):
///
/// ```
/// use collinear::camera::from_colmap;
/// use nalgebra::{Point2, Vector3};
///
/// let camera = from_colmap("SIMPLE_RADIAL", &[611.3, 513.4, 391.9, -0.11])?;
/// let p = camera.project_direction(&Vector3::new(0.31, -0.22, 1.0))?;
/// assert!((p - Point2::new(699.8908498149999, 259.55165496999996)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn from_colmap(model: &str, parameters: &[f64]) -> Result<Box<dyn CentralModel>, Error> {
    let Some((interior, rest)) = interior(model, parameters)? else {
        let [w, h] = super::parameters::read(parameters)?;
        let interior = InteriorOrientation::from_whole_panorama(w, h)?;
        return Ok(Box::new(CentralCamera::ideal(interior, Panorama::Equirectangular)));
    };
    let fisheye = Fisheye::Equidistant;
    let even = |k| -> Result<Box<dyn CentralModel>, Error> {
        Ok(Box::new(CentralCamera::from_parts(interior, fisheye, EvenRadial::new(k)?)))
    };
    Ok(match (model, rest) {
        (_, &[]) if model.ends_with("PINHOLE") => {
            Box::new(CentralCamera::from_parts(interior, Gnomonic, NoDistortion))
        }
        (_, &[]) => Box::new(CentralCamera::ideal(interior, fisheye)),
        ("FULL_OPENCV", &[k1, k2, p1, p2, k3, k4, k5, k6]) => {
            let lens = Rational::from_opencv(&[k1, k2, p1, p2, k3, k4, k5, k6])?;
            Box::new(CentralCamera::from_parts(interior, Gnomonic, lens))
        }
        ("SIMPLE_RADIAL_FISHEYE", &[k]) => even([k, 0.0, 0.0, 0.0])?,
        ("RADIAL_FISHEYE", &[k1, k2]) => even([k1, k2, 0.0, 0.0])?,
        ("OPENCV_FISHEYE", &[k1, k2, k3, k4]) => even([k1, k2, k3, k4])?,
        ("THIN_PRISM_FISHEYE", &[k1, k2, p1, p2, k3, k4, s1, s2]) => {
            let lens = ThinPrism::new([k1, k2, k3, k4], [p1, p2], [s1, s2])?;
            Box::new(CentralCamera::from_parts(interior, fisheye, lens))
        }
        ("RAD_TAN_THIN_PRISM_FISHEYE", &[k0, k1, k2, k3, k4, k5, p0, p1, s0, s1, s2, s3]) => {
            let k = [k0, k1, k2, k3, k4, k5];
            let lens = RadialTangentialThinPrism::new(k, [p0, p1], [s0, s1, s2, s3])?;
            Box::new(CentralCamera::from_parts(interior, fisheye, lens))
        }
        ("FOV", &[omega]) => Box::new(CentralCamera::ideal(interior, FieldOfView::new(omega)?)),
        ("SIMPLE_DIVISION" | "DIVISION", &[k]) => {
            Box::new(CentralCamera::ideal(interior, Division::new(k)?))
        }
        ("EUCM", &[alpha, beta]) => {
            Box::new(CentralCamera::ideal(interior, EnhancedUnified::new(alpha, beta)?))
        }
        _ => Box::new(brown(model, interior, rest)?.ok_or(UNKNOWN)?),
    })
}

/// The camera of a COLMAP model that is Brown's or has no lens: the pinholes, `SIMPLE_RADIAL`, `RADIAL` and `OPENCV`; `None` for
/// the others. Such a camera has a homography for every plane.
///
/// # Errors
/// As [`from_colmap`].
pub fn brown_from_colmap(model: &str, parameters: &[f64]) -> Result<Option<BrownCamera>, Error> {
    match interior(model, parameters)? {
        Some((interior, lens)) => brown(model, interior, lens),
        None => Ok(None),
    }
}

const UNKNOWN: Error = Error::Unknown { what: "COLMAP camera model" };

/// The interior orientation, with the lens parameters that follow it; `None` for a panorama. Refuses another name or number of
/// parameters.
fn interior<'a>(
    model: &str,
    parameters: &'a [f64],
) -> Result<Option<(InteriorOrientation, &'a [f64])>, Error> {
    let (_, names) = COLMAP_MODELS.iter().find(|(name, _)| *name == model).ok_or(UNKNOWN)?;
    if names.len() != parameters.len() {
        return Err(Error::LengthMismatch {
            what: "parameters of a COLMAP camera model",
            left: names.len(),
            right: parameters.len(),
        });
    }
    let ([fx, fy], [cx, cy], rest) = match *parameters {
        [f, cx, cy, ref rest @ ..] if names[0] == "f" => ([f, f], [cx, cy], rest),
        [fx, fy, cx, cy, ref rest @ ..] => ([fx, fy], [cx, cy], rest),
        _ => return Ok(None),
    };
    let interior = InteriorOrientation::new([fx, fy], Point2::new(cx, cy), 0.0)?;
    Ok(Some((interior, rest)))
}

/// Those of the models that are Brown's.
fn brown(
    model: &str,
    interior: InteriorOrientation,
    lens: &[f64],
) -> Result<Option<BrownCamera>, Error> {
    let (k, p) = match (model, lens) {
        ("SIMPLE_PINHOLE" | "PINHOLE", []) => ([0.0; 3], [0.0; 2]),
        ("SIMPLE_RADIAL", &[k]) => ([k, 0.0, 0.0], [0.0; 2]),
        ("RADIAL", &[k1, k2]) => ([k1, k2, 0.0], [0.0; 2]),
        ("OPENCV", &[k1, k2, p1, p2]) => ([k1, k2, 0.0], [p1, p2]),
        _ => return Ok(None),
    };
    Ok(Some(BrownCamera::new(interior, Brown::new(k, p)?)))
}
