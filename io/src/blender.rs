//! Blender's cameras.
//!
//! Blender has a lens and a sensor in millimetres, a shift in parts of the sensor, and a picture with pixels of any aspect. With
//! W × H pixels, ρ = aspect y / aspect x, s the sensor's size and v the picture's along the direction that the sensor fits,
//!
//! ```text
//! horizontal:  s = sensor width,   v = W          vertical:  s = sensor height,   v = ρ H
//! auto:        s = sensor width,   v = W where W ≥ ρ H, else ρ H
//! fx = lens v/s,   fy = fx/ρ,   cx = W/2 − shift x · v,   cy = H/2 + shift y · v/ρ
//! ```
//! (`BKE_camera_params_compute_viewplane` in Blender's source). So a positive shift moves the picture's frame right and up, and
//! the principal point in it left and down. Axes are x right, y up, looking along −z; `matrix_world` goes from them to the world.
//! A parallel projection has `ortho_scale` world units along v instead.
//!
//! Blender computes with single precision: coordinates of maps do not fit, so take an offset off them before.

use std::fmt::Write as _;

use collinear::nalgebra::Matrix4;
use serde::{Deserialize, Serialize};

use crate::camera::{CameraFile, Interior};
use crate::check::{all_in_range, finite, in_range};
use crate::error::{Error, ErrorKind};
use crate::eye::{Ideal, exterior, ideal, world_from_eye};
use crate::json::Document;

/// The width of Blender's own new sensors.
const SENSOR_WIDTH_MM: f64 = 36.0;

/// The direction along which a sensor has its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum SensorFit {
    /// The picture's longer one; the size is the sensor's width.
    Auto,
    /// The width.
    Horizontal,
    /// The height.
    Vertical,
}

/// A lens of Blender's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BlenderLens {
    /// A perspective: its focal length in millimetres.
    LensMm(f64),
    /// A parallel projection: world units along the picture.
    OrthoScale(f64),
}

/// A camera with the settings of its scene that its picture depends on, by Blender's names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlenderCamera {
    /// Focal length, or scale of a parallel projection.
    #[serde(flatten)]
    pub lens: BlenderLens,
    /// Width of the sensor.
    pub sensor_width_mm: f64,
    /// Height of the sensor, which counts where the fit is vertical.
    pub sensor_height_mm: f64,
    /// Which of both counts.
    pub sensor_fit: SensorFit,
    /// Shift right and up.
    pub shift: [f64; 2],
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Width and height of a pixel, of which the ratio counts.
    pub pixel_aspect: [f64; 2],
    /// The rows of the matrix from the camera's axes to the world's.
    pub matrix_world: [[f64; 4]; 4],
}

impl BlenderCamera {
    /// ρ, s and v of the module's equations.
    fn fit(&self) -> (f64, f64, f64) {
        let [width, height] = self.resolution.map(f64::from);
        let ratio = self.pixel_aspect[1] / self.pixel_aspect[0];
        let tall = ratio * height;
        match self.sensor_fit {
            SensorFit::Vertical => (ratio, self.sensor_height_mm, tall),
            SensorFit::Auto if width < tall => (ratio, self.sensor_width_mm, tall),
            SensorFit::Auto | SensorFit::Horizontal => (ratio, self.sensor_width_mm, width),
        }
    }

    /// The photograph's camera.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for a value out of its domain.
    ///
    /// # Example
    /// 50 mm before 36 mm on 1920 × 1080: f = 2666.67. A shift of 0.1 to the right is 192 pixels.
    ///
    /// ```
    /// use collinear::nalgebra::{Point2, Point3};
    /// use collinear_io::blender::{BlenderCamera, BlenderLens, SensorFit};
    ///
    /// let blender = BlenderCamera {
    ///     lens: BlenderLens::LensMm(50.0),
    ///     sensor_width_mm: 36.0,
    ///     sensor_height_mm: 24.0,
    ///     sensor_fit: SensorFit::Auto,
    ///     shift: [0.1, 0.0],
    ///     resolution: [1920, 1080],
    ///     pixel_aspect: [1.0, 1.0],
    ///     matrix_world: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 5.0], [0.0, 0.0, 0.0, 1.0]],
    /// };
    /// let image = blender.camera()?.camera()?.sensor().project(&Point3::new(0.0, 0.3, 0.0))?;
    /// assert!((image - Point2::new(960.0 - 192.0, 540.0 - 160.0)).norm() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn camera(&self) -> Result<CameraFile, Error> {
        let expected = "a number from 1e-6 to 1e9";
        let inside = |v| (1e-6..=1e9).contains(&v);
        in_range("sensor_width_mm", self.sensor_width_mm, expected, inside)?;
        in_range("sensor_height_mm", self.sensor_height_mm, expected, inside)?;
        all_in_range("pixel_aspect", &self.pixel_aspect, expected, inside)?;
        finite("shift", &self.shift)?;
        let (ratio, sensor, along) = self.fit();
        let [width, height] = self.resolution.map(f64::from);
        let principal_point =
            [0.5 * width - self.shift[0] * along, 0.5 * height + self.shift[1] * along / ratio];
        let interior = match self.lens {
            BlenderLens::LensMm(lens) => {
                let f = lens * along / sensor;
                Interior::Pinhole { principal_distance: [f, f / ratio], principal_point, skew: 0.0 }
            }
            BlenderLens::OrthoScale(scale) => {
                let s = along / scale;
                Interior::Orthographic { pixels_per_unit: [s, s / ratio], principal_point }
            }
        };
        let rows = &self.matrix_world;
        let matrix = Matrix4::from_fn(|i, j| rows[i][j]);
        let exterior = exterior(&matrix).map_err(|e| e.under("matrix_world"))?;
        let [width, height] = self.resolution;
        let camera = CameraFile { width, height, interior, exterior };
        camera.check()?;
        Ok(camera)
    }

    /// Blender's camera of a photograph without a lens: the sensor fits horizontally and is 36 mm wide, or as wide as keeps the
    /// lens at 1 mm, Blender's shortest.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`](crate::FieldProblem::Unsupported) for a lens or skew, and those of
    /// [`CameraFile::check`](Document::check).
    pub fn from_camera(camera: &CameraFile) -> Result<Self, Error> {
        let ideal = ideal(camera)?;
        let (Ideal::Perspective(scales, [cx, cy]) | Ideal::Orthographic(scales, [cx, cy])) = ideal;
        let [width, height] = [camera.width, camera.height].map(f64::from);
        let ratio = scales[0] / scales[1];
        // Blender takes no aspect below 1.
        let pixel_aspect = if ratio >= 1.0 { [1.0, ratio] } else { [1.0 / ratio, 1.0] };
        let (lens, sensor_width_mm) = match ideal {
            Ideal::Perspective([f, _], _) => {
                let lens = f * SENSOR_WIDTH_MM / width;
                if lens >= 1.0 { (lens, SENSOR_WIDTH_MM) } else { (1.0, width / f) }
            }
            Ideal::Orthographic([s, _], _) => (width / s, SENSOR_WIDTH_MM),
        };
        let turn = world_from_eye(&camera.exterior)?;
        let center = camera.exterior.projection_center;
        let row = |i: usize| [turn[(i, 0)], turn[(i, 1)], turn[(i, 2)], center[i]];
        Ok(Self {
            lens: match ideal {
                Ideal::Perspective(..) => BlenderLens::LensMm(lens),
                Ideal::Orthographic(..) => BlenderLens::OrthoScale(lens),
            },
            sensor_width_mm,
            sensor_height_mm: sensor_width_mm * height / width,
            sensor_fit: SensorFit::Horizontal,
            shift: [(0.5 * width - cx) / width, (cy - 0.5 * height) * ratio / width],
            resolution: [camera.width, camera.height],
            pixel_aspect,
            matrix_world: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        })
    }
}

/// What the script does with its cameras.
const SCRIPT: &str = r#"]

# Size and aspect of pixels belong to a scene: cameras of others get a scene of their own with the same objects.
home = bpy.context.scene
children, objects = list(home.collection.children), list(home.collection.objects)
scenes = {}
for data in CAMERAS:
    key = (*data["resolution"], *data["pixel_aspect"])
    if key not in scenes:
        scene = home
        if scenes:
            scene = bpy.data.scenes.new("{} x {}".format(*key))
            scene.world = home.world
            for child in children:
                scene.collection.children.link(child)
            for thing in objects:
                scene.collection.objects.link(thing)
        scenes[key] = scene
        render = scene.render
        render.resolution_x, render.resolution_y, render.pixel_aspect_x, render.pixel_aspect_y = key
        render.resolution_percentage = 100
        scene.camera = None
    scene = scenes[key]
    camera = bpy.data.cameras.new(data["name"])
    if "lens_mm" in data:
        camera.lens = data["lens_mm"]
    else:
        camera.type = "ORTHO"
        camera.ortho_scale = data["ortho_scale"]
    camera.sensor_width = data["sensor_width_mm"]
    camera.sensor_height = data["sensor_height_mm"]
    camera.sensor_fit = data["sensor_fit"]
    camera.shift_x, camera.shift_y = data["shift"]
    thing = bpy.data.objects.new(data["name"], camera)
    thing.matrix_world = Matrix(data["matrix_world"])
    scene.collection.objects.link(thing)
    scene.camera = scene.camera or thing
"#;

/// A Python script that makes these cameras in Blender: `blender --python cameras.py`, or out of its text editor. It sets
/// the scene's resolution to the photographs'.
///
/// # Errors
/// As [`BlenderCamera::from_camera`].
pub fn to_script(photographs: &[(String, CameraFile)]) -> Result<String, Error> {
    #[derive(Serialize)]
    struct Named<'a> {
        name: &'a str,
        #[serde(flatten)]
        camera: BlenderCamera,
    }
    let mut text = String::from(
        "# Cameras for Blender: blender --python THIS_FILE\nimport json\n\nimport bpy\nfrom mathutils import Matrix\n\nCAMERAS = [\n",
    );
    for (name, file) in photographs {
        let camera = BlenderCamera::from_camera(file).map_err(|e| match e.kind() {
            ErrorKind::Field(field) => Error::from(field.clone().under(name)),
            _ => e,
        })?;
        let foreign = |e: serde_json::Error| {
            Error::from(ErrorKind::Foreign { program: "Blender", reason: e.to_string() })
        };
        let object = serde_json::to_string(&Named { name, camera }).map_err(foreign)?;
        // A string of JSON's is one of Python's.
        let literal = serde_json::to_string(&object).map_err(foreign)?;
        let _ = writeln!(text, "    json.loads({literal}),");
    }
    text.push_str(SCRIPT);
    Ok(text)
}
