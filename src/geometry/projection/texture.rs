//! Texture matrices: a photograph, a slide or a shadow map projected onto the scene.
//!
//! An old camera took the photograph; a new one looks at the scene. Each vertex needs homogeneous texture coordinates
//! (s, t, r, q) in the old image, and every function here is a way to them from another space:
//!
//! | Function                      | from               | matrix                                   | Source |
//! |-------------------------------|--------------------|------------------------------------------|--------|
//! | [`eye_linear`]                | new camera's axes  | `T_old V_old V_new⁻¹`                    | \[H\] method 1 |
//! | [`object_linear`]             | object = world     | `T_old V_old`                            | \[H\] method 2 |
//! | [`object_linear_with_model`]  | object             | `T_old V_old world_from_object`          | \[H\] method 3 |
//! | [`missing_q`]                 | old image and old w | –                                       | \[H\] |
//! | [`light_from_clip`]           | new clip           | `light_from_world clip_from_world⁻¹`     | \[S\] eq. 5 |
//!
//! `T_old` is [`bias`] or [`texture_from_clip`] times `P_old`, the old camera's projection. \[H\] Hoff, *Understanding Projective Textures* (1998); \[S\]
//! Segal, Korobkin, van Widenfelt, Foran & Haeberli, *Fast Shadows and Lighting Effects Using Texture Mapping* (1992).
//!
//! The coordinates are linear over a triangle in space, so (s, t, r, q)/w is linear on the new screen, and the texture is read
//! at (s/q, t/q). Plain (s, t) with q = 1 is not: the photograph has divided by its own w already. Where q ≤ 0 the point is
//! behind the projector, and s/q a plausible number without meaning; [`texture_from_light`] refuses it.

use nalgebra::{Matrix4, Point2, Point3, Vector3, Vector4};

use super::clip::ClipConvention;
use super::viewport::divided;
use crate::error::{Error, ProjectionError};
use crate::geometry::Pose;

/// Below this pivot, relative to the largest one, a matrix with its rows and columns scaled to one counts as singular.
const SINGULAR: f64 = 8.0 * f64::EPSILON;

/// The ½ matrix of \[H\]: glTranslate(½, ½, 0) glScale(½, ½, 1).
///
/// ```text
/// s = (x + w)/2,    t = (y + w)/2,    r = z,    q = w
/// ```
///
/// t grows with clip y: for OpenGL's clip coordinates and a texture whose first row is the lowest.
#[must_use]
pub fn bias() -> Matrix4<f64> {
    #[rustfmt::skip]
    let matrix = Matrix4::new(
        0.5, 0.0, 0.0, 0.5,
        0.0, 0.5, 0.0, 0.5,
        0.0, 0.0, 1.0, 0.0,
        0.0, 0.0, 0.0, 1.0,
    );
    matrix
}

/// The ½ matrix for a texture whose first row is the top one, as images in memory are: (0, 0) is the top-left corner of
/// the clip volume, (1, 1) the bottom-right, and r runs from 0 to 1.
///
/// (s/q · width, t/q · height) are image coordinates in pixels.
#[must_use]
pub fn texture_from_clip(convention: ClipConvention) -> Matrix4<f64> {
    let [lowest, highest] = convention.ndc_depth();
    let length = highest - lowest;
    #[rustfmt::skip]
    let matrix = Matrix4::new(
        0.5, 0.0, 0.0, 0.5,
        0.0, -0.5 * convention.y_sign(), 0.0, 0.5,
        0.0, 0.0, 1.0 / length, -lowest / length,
        0.0, 0.0, 0.0, 1.0,
    );
    matrix
}

/// \[H\]'s method 1: texture coordinates from the new camera's axes (eye-linear).
///
/// ```text
/// texture_from_new_camera = texture_from_old_camera · V_old · V_new⁻¹
/// ```
///
/// Only the new *view* is undone, not the new projection: eye-linear coordinates are taken before it. The model matrix is in
/// them already. The two poses are combined before anything is multiplied, so that world coordinates of 10⁶ m
/// cost no digits.
#[must_use]
#[doc(alias("GL_EYE_LINEAR", "texgen"))]
pub fn eye_linear(
    texture_from_old_camera: &Matrix4<f64>,
    old_camera_from_world: &Pose,
    new_camera_from_world: &Pose,
) -> Matrix4<f64> {
    let (old, new) = (old_camera_from_world, new_camera_from_world);
    let old_from_new = Pose::new(old.rotation * new.rotation.inverse(), new.apply(&old.origin));
    texture_from_old_camera * old_from_new.to_matrix()
}

/// \[H\]'s method 2: texture coordinates from the vertices as they are (object-linear).
///
/// ```text
/// texture_from_world = texture_from_old_camera · V_old
/// ```
///
/// Right only where the vertices are in world coordinates, that is, where the model matrix is the identity.
///
/// # Example
/// An old camera at the origin with a field of view of 90°: the point (1, 0, 2) is half way to the right edge of its
/// picture, at s = ¾, t = ½.
///
/// ```
/// use collinear::geometry::Pose;
/// use collinear::geometry::projection::texture::{object_linear, texture_from_clip, texture_from_light};
/// use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
/// use collinear::nalgebra::Vector4;
///
/// let convention = ClipConvention::OpenGl;
/// let view = Projection::from_field_of_view(90f64.to_radians(), 1.0, DepthRange::new(0.1, 100.0)?)?;
/// let old = texture_from_clip(convention) * view.clip_from_camera(convention);
/// let p = texture_from_light(&(object_linear(&old, &Pose::identity()) * Vector4::new(1.0, 0.0, 2.0, 1.0)))?;
/// assert!((p.x - 0.75).abs() < 1e-15 && (p.y - 0.5).abs() < 1e-15);
/// // Behind the old camera there is no texture.
/// assert!(texture_from_light(&(old * Vector4::new(1.0, 0.0, -2.0, 1.0))).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
#[doc(alias("GL_OBJECT_LINEAR", "texgen"))]
pub fn object_linear(
    texture_from_old_camera: &Matrix4<f64>,
    old_camera_from_world: &Pose,
) -> Matrix4<f64> {
    texture_from_old_camera * old_camera_from_world.to_matrix()
}

/// \[H\]'s method 3: texture coordinates from the vertices, with the model matrix.
///
/// ```text
/// texture_from_object = texture_from_old_camera · V_old · world_from_object
/// ```
///
/// The same coordinates as [`eye_linear`], without anything of the new view.
#[must_use]
#[doc(alias("GL_OBJECT_LINEAR", "texgen"))]
pub fn object_linear_with_model(
    texture_from_old_camera: &Matrix4<f64>,
    old_camera_from_world: &Pose,
    world_from_object: &Matrix4<f64>,
) -> Matrix4<f64> {
    object_linear(texture_from_old_camera, old_camera_from_world) * world_from_object
}

/// The homogeneous coordinates (s w, t w, w) of a vertex whose place (s, t) in the old image is known together with the old
/// camera's w there.
///
/// q is w itself. (\[H\] names 1/w, which is what is left of a q of one after the division by the *new* w.)
///
/// # Errors
/// [`ProjectionError::BehindCamera`] where w ≤ 0, and [`ProjectionError::NotFinite`].
///
/// # Example
/// ```
/// use collinear::geometry::projection::texture::missing_q;
/// use collinear::nalgebra::{Point2, Vector3};
///
/// // Ends of an edge at depths 1 and 3 of the old camera, with s = 0 and 1. The middle of the edge in space has x = 3/2 at
/// // depth 2: s = 3/4.
/// let (a, b) = (missing_q(&Point2::new(0.0, 0.0), 1.0)?, missing_q(&Point2::new(1.0, 0.0), 3.0)?);
/// let middle: Vector3<f64> = (a + b) / 2.0;
/// assert_eq!(middle.x / middle.z, 0.75);
/// # Ok::<(), collinear::ProjectionError>(())
/// ```
pub fn missing_q(texture: &Point2<f64>, w: f64) -> Result<Vector3<f64>, ProjectionError> {
    let coordinates = Vector3::new(texture.x * w, texture.y * w, w);
    if !coordinates.iter().all(|c| c.is_finite()) {
        return Err(ProjectionError::NotFinite);
    }
    if w <= 0.0 {
        return Err(ProjectionError::BehindCamera { depth: w });
    }
    Ok(coordinates)
}

/// The matrix M of \[S\] equation 5, from the viewer's clip coordinates to the light's.
///
/// ```text
/// Qˡ = M Q,    M = M_l M_c⁻¹        M_l = light_from_world, M_c = clip_from_world
/// ```
///
/// `M_l` takes the world to the light's homogeneous coordinates, the slide's perspective included, so that xᵗ = xˡ/wˡ. M is
/// projective in general: its last row need not be (0, 0, 0, 1), and wˡ may change sign where w does not.
///
/// *Accuracy*: the relative error of M is ε times the condition of `M_c`, about far/near, and times (distance of the origin)/(near)
/// where the world's origin is far away. Move the origin near the scene first.
///
/// # Errors
/// [`Error::NotFinite`], and [`Error::Degenerate`] where `M_c` is singular; the measure is its smallest pivot over the largest, rows
/// and columns scaled to one.
///
/// # Example
/// A light at the eye with the eye's own projection sees what the eye sees: M is the identity.
///
/// ```
/// use collinear::geometry::projection::texture::light_from_clip;
/// use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
/// use collinear::nalgebra::Matrix4;
///
/// let view = Projection::from_field_of_view(1.0, 1.5, DepthRange::new(0.1, 100.0)?)?;
/// let clip_from_world = view.clip_from_camera(ClipConvention::OpenGl);
/// let m = light_from_clip(&clip_from_world, &clip_from_world)?;
/// assert!((m - Matrix4::identity()).amax() < 1e-12);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("shadow map", "slide projector"))]
pub fn light_from_clip(
    light_from_world: &Matrix4<f64>,
    clip_from_world: &Matrix4<f64>,
) -> Result<Matrix4<f64>, Error> {
    if !light_from_world.iter().chain(clip_from_world.iter()).all(|e| e.is_finite()) {
        return Err(Error::NotFinite { what: "projection matrix" });
    }
    let what = "clip_from_world";
    let singular = |measure| Error::Degenerate { what, measure, limit: SINGULAR };
    // M_c = D S E with the largest element of every row and column of S near one: M = M_l E⁻¹ S⁻¹ D⁻¹.
    let mut scaled = *clip_from_world;
    let (mut rows, mut columns) = (Vector4::zeros(), Vector4::zeros());
    for i in 0..4 {
        rows[i] = scaled.row(i).amax();
        scaled.row_mut(i).iter_mut().for_each(|e| *e /= rows[i]);
    }
    for j in 0..4 {
        columns[j] = scaled.column(j).amax();
        scaled.column_mut(j).iter_mut().for_each(|e| *e /= columns[j]);
    }
    if !(rows.min() > 0.0 && columns.min() > 0.0) {
        return Err(singular(0.0));
    }
    let lu = scaled.transpose().full_piv_lu();
    let pivots = lu.u().diagonal().abs();
    let measure = pivots.min() / pivots.max();
    let mut right = light_from_world.transpose();
    for j in 0..4 {
        right.row_mut(j).iter_mut().for_each(|e| *e /= columns[j]);
    }
    match lu.solve(&right) {
        Some(mut solution) if measure > SINGULAR => {
            for i in 0..4 {
                solution.row_mut(i).iter_mut().for_each(|e| *e /= rows[i]);
            }
            if solution.iter().all(|e| e.is_finite()) {
                Ok(solution.transpose())
            } else {
                Err(Error::NotFinite { what: "light_from_clip" })
            }
        }
        _ => Err(singular(measure)),
    }
}

/// Texture coordinates from light coordinates, \[S\] section 2: (xᵗ, yᵗ, zᵗ) = (xˡ, yˡ, zˡ) / wˡ; the same division takes (s, t, r, q) to
/// the texture.
///
/// # Errors
/// [`ProjectionError::BehindCamera`] where wˡ ≤ 0 (behind the projector, unlit), and [`ProjectionError::NotFinite`].
pub fn texture_from_light(light: &Vector4<f64>) -> Result<Point3<f64>, ProjectionError> {
    divided(light)
}
