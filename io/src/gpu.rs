//! A photograph as the matrices of a graphics interface: a real camera as an off-axis projection.
//!
//! ```text
//! clip = projection · view · (X, Y, Z, 1)ᵀ
//! ```
//! A point that images at pixel (x, y) of the photograph lands on (x, y) of a viewport of the photograph's size: pixels meet
//! exactly, whatever the principal point. The view's axes are those of OpenGL, x right, y up, looking along −z; so renderers
//! take them as they are.

use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
use collinear::geometry::rotation::camera_from_photo;
use collinear::nalgebra::{Matrix4, Point2};
use serde::Serialize;

use crate::camera::{CameraFile, Interior};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::Document;

/// The matrices of a photograph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GpuCamera {
    /// `"opengl"`, `"direct3d"`, `"vulkan"` or `"wgpu"`: the clip volume.
    pub clip: &'static str,
    /// Width of the viewport, pixels.
    pub width: u32,
    /// Height of the viewport, pixels.
    pub height: u32,
    /// What comes before the near plane, as a depth in world units.
    pub near: f64,
    /// The far plane's depth; none where there is no end.
    pub far: Option<f64>,
    /// Eye from world, column after column.
    pub view: [f64; 16],
    /// Clip from eye, column after column.
    pub projection: [f64; 16],
    /// The eye, world units. Map coordinates do not fit `f32`: subtract it before, and use the view's rotation alone.
    pub projection_center: [f64; 3],
}

fn columns(m: &Matrix4<f64>) -> [f64; 16] {
    let mut all = [0.0; 16];
    all.copy_from_slice(m.as_slice());
    all
}

impl GpuCamera {
    /// Of a photograph without a lens, with depths from `near` to `far` or without end.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] for a lens, which no matrix is: rectify the photograph first; and
    /// [`ErrorKind::Library`] for depths that are none.
    ///
    /// # Example
    /// c = 500 px, 2 right and 1 down at depth 10: pixel (320 + 100, 240 + 50), so x is 2 · 420/640 − 1 of the clip volume.
    ///
    /// ```
    /// use collinear::geometry::projection::ClipConvention;
    /// use collinear::nalgebra::{Matrix4, Vector4};
    /// use collinear_io::{Document, camera::CameraFile, gpu::GpuCamera};
    ///
    /// let file = CameraFile::parse(
    ///     r#"{ "collinear": "camera", "version": 1, "width": 640, "height": 480,
    ///     "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 240] },
    ///     "exterior": { "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] } }"#,
    /// )?;
    /// let camera = GpuCamera::new(&file, ClipConvention::Wgpu, 0.1, None)?;
    /// let matrix = |m: &[f64; 16]| Matrix4::from_column_slice(m);
    /// let clip = matrix(&camera.projection) * matrix(&camera.view) * Vector4::new(2.0, 1.0, 10.0, 1.0);
    /// assert!((clip.x / clip.w - 0.3125).abs() < 1e-15 && (clip.y / clip.w + 0.20833333333333334).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias("off-axis", "projection matrix", "view matrix"))]
    pub fn new(
        camera: &CameraFile,
        convention: ClipConvention,
        near: f64,
        far: Option<f64>,
    ) -> Result<Self, Error> {
        camera.check()?;
        let plain = camera.interior.plain([camera.width, camera.height]);
        let refused = |expected| {
            let problem = FieldProblem::Unsupported { found: plain.model().into(), expected };
            Error::from(FieldError::new("interior.model", problem))
        };
        let Interior::Pinhole { principal_distance, principal_point, skew } = &plain else {
            return Err(refused("a matrix has no lens: rectify the photograph first"));
        };
        if *skew != 0.0 {
            return Err(refused("a projection has no skew: rectify the photograph first"));
        }
        let library = |field: &str| {
            let field = field.to_owned();
            move |source| Error::from(ErrorKind::Library { field, source })
        };
        let depth = match far {
            Some(far) => DepthRange::new(near, far),
            None => DepthRange::infinite(near),
        };
        let size = [camera.width, camera.height].map(f64::from);
        let projection = Projection::from_principal_distance(
            *principal_distance,
            Point2::from(*principal_point),
            size,
            depth.map_err(library("near"))?,
        )
        .map_err(library("near"))?;
        let exterior = camera.exterior.orientation()?;
        let view = camera_from_photo().inverse().to_homogeneous() * exterior.pose().to_matrix();
        Ok(Self {
            clip: match convention {
                ClipConvention::OpenGl => "opengl",
                ClipConvention::Direct3d => "direct3d",
                ClipConvention::Vulkan => "vulkan",
                ClipConvention::Wgpu => "wgpu",
            },
            width: camera.width,
            height: camera.height,
            near,
            far,
            view: columns(&view),
            projection: columns(&projection.clip_from_eye(convention)),
            projection_center: exterior.projection_center().into(),
        })
    }

    /// As JSON.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where a number is not finite.
    pub fn to_json(&self) -> Result<String, Error> {
        crate::check::finite("view", &self.view)?;
        crate::check::finite("projection", &self.projection)?;
        let text = serde_json::to_string_pretty(self)
            .map_err(|e| ErrorKind::Foreign { program: "collinear", reason: e.to_string() })?;
        Ok(text + "\n")
    }
}
