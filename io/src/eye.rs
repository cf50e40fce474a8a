//! Cameras of graphics programs: eye axes x right, y up, looking along −z, and no lens.

use collinear::geometry::rotation::camera_from_photo;
use collinear::nalgebra::{Matrix4, Rotation3};

use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::error::{Error, FieldError, FieldProblem};
use crate::json::Document;

/// A camera without a lens.
pub(crate) enum Ideal {
    /// fx and fy, and the principal point.
    Perspective([f64; 2], [f64; 2]),
    /// Pixels for each world unit, and the image of the projection centre.
    Orthographic([f64; 2], [f64; 2]),
}

/// The camera without its model's name; refuses lenses and skew.
pub(crate) fn ideal(camera: &CameraFile) -> Result<Ideal, Error> {
    camera.check()?;
    let plain = camera.interior.plain([camera.width, camera.height]);
    let refused = |expected| {
        let problem = FieldProblem::Unsupported { found: plain.model().into(), expected };
        Err(FieldError::new("interior.model", problem).into())
    };
    match plain {
        Interior::Pinhole { principal_distance, principal_point, skew: 0.0 } => {
            Ok(Ideal::Perspective(principal_distance, principal_point))
        }
        Interior::Pinhole { .. } => refused("a renderer's camera has no skew: rectify first"),
        Interior::Orthographic { pixels_per_unit, principal_point } => {
            Ok(Ideal::Orthographic(pixels_per_unit, principal_point))
        }
        _ => refused("a renderer's camera has no lens: rectify the photograph first"),
    }
}

/// The rotation from eye axes to the world's.
pub(crate) fn world_from_eye(exterior: &Exterior) -> Result<Rotation3<f64>, Error> {
    let camera_from_world = exterior.orientation()?.camera_from_world();
    Ok((camera_from_photo() * camera_from_world).inverse())
}

/// The exterior orientation of a matrix from eye axes to the world's, which may scale, in all directions alike.
pub(crate) fn exterior(world_from_eye: &Matrix4<f64>) -> Result<Exterior, FieldError> {
    let m = world_from_eye.fixed_view::<3, 3>(0, 0);
    let scale = m.determinant().abs().cbrt();
    let m = m / scale;
    // The rows of diag(1, −1, −1) Mᵀ.
    let row = |i: usize, sign: f64| [0, 1, 2].map(|j| sign * m[(j, i)]);
    let exterior = Exterior {
        projection_center: [0, 1, 2].map(|i| world_from_eye[(i, 3)]),
        rotation: Rotation::RotationMatrix([row(0, 1.0), row(1, -1.0), row(2, -1.0)]),
    };
    exterior.check()?;
    Ok(exterior)
}
