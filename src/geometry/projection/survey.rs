//! The survey's projection matrix, in which the orthographic view is the limit of the perspective one.
//!
//! ```text
//!     ⎛ 1  0   0   0 ⎞
//! P = ⎜ 0  1   0   0 ⎟      (Weinhaus & Devarajan 1997, table 2)
//!     ⎜ 0  0   1   0 ⎟
//!     ⎝ 0  0  1/f  1 ⎠
//! ```
//!
//! The eye stands at z = −f and looks along +z; w = 1 + z/f, and the plane z = 0 is imaged at its own scale. With 1/f = 0 the
//! eye is at infinity and w = 1: the orthographic view by the same matrix. A camera whose origin is its eye comes here by
//! [`survey_from_camera`], a translation by (0, 0, −f); the limit exists only in the survey's own origin.

use nalgebra::{Matrix4, Point2, Point3, Translation3, Vector3};

use super::viewport::divided;
use crate::error::{Error, ProjectionError};

/// P for 1/f, the inverse of the principal distance in world units; 0 is orthographic.
///
/// A negative 1/f has the eye at z = |f| and looks along −z, the photogrammetric way: w = 1 − z/c.
///
/// # Errors
/// [`Error::NotFinite`].
pub fn projection(inverse_principal_distance: f64) -> Result<Matrix4<f64>, Error> {
    if !inverse_principal_distance.is_finite() {
        return Err(Error::NotFinite { what: "inverse principal distance" });
    }
    let mut p = Matrix4::identity();
    p[(3, 2)] = inverse_principal_distance;
    Ok(p)
}

/// The translation by (0, 0, −f) from camera axes with the eye as origin to the survey's, where the eye is at z = −f.
///
/// # Errors
/// [`Error::OutOfRange`] unless the principal distance f is positive and finite.
pub fn survey_from_camera(principal_distance: f64) -> Result<Matrix4<f64>, Error> {
    if !(principal_distance > 0.0 && principal_distance < f64::INFINITY) {
        return Err(Error::OutOfRange {
            what: "principal distance",
            value: principal_distance,
            expected: "positive and finite",
        });
    }
    Ok(Translation3::from(Vector3::new(0.0, 0.0, -principal_distance)).to_homogeneous())
}

/// (x/w, y/w) of a point in the survey's axes.
///
/// # Errors
/// [`ProjectionError::BehindCamera`] where w ≤ 0, with w; [`ProjectionError::NotFinite`].
///
/// # Example
/// The survey's matrix and the pinhole x = f X/Z: from the eye (2, 1, 10) is (2, 1, 5) for f = 5, w = 1 + 5/5 = 2.
/// ```
/// use collinear::geometry::projection::survey;
/// use collinear::nalgebra::{Point2, Point3};
///
/// assert_eq!(survey::image(0.2, &Point3::new(2.0, 1.0, 5.0))?, Point2::new(1.0, 0.5));
/// // Orthographic by the same formula.
/// assert_eq!(survey::image(0.0, &Point3::new(2.0, 1.0, 5.0))?, Point2::new(2.0, 1.0));
/// # Ok::<(), collinear::ProjectionError>(())
/// ```
pub fn image(
    inverse_principal_distance: f64,
    survey: &Point3<f64>,
) -> Result<Point2<f64>, ProjectionError> {
    let w = 1.0 + survey.z * inverse_principal_distance;
    Ok(divided(&survey.coords.push(w))?.xy())
}
