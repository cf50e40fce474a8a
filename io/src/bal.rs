//! *Bundle Adjustment in the Large*: a bundle adjustment problem as text, plain or gzip.
//!
//! ```text
//! P = R X + t,   p = −P/P.z,   image = f (1 + k₁|p|² + k₂|p|⁴) p
//! ```
//! (Agarwal, Snavely, Seitz & Szeliski 2010, *Bundle adjustment in the large*.) The camera looks along −z with y up, as
//! [Bundler](crate::bundler)'s does. Turned half about x it has this crate's axes, and image coordinates become (x, −y), in pixels
//! from the principal point:
//!
//! ```text
//! camera_from_world = diag(1, −1, −1) R,   centre = −Rᵀ t,   pixel = (x, −y)
//! ```
//! Each camera is then a perspective with [`EvenRadial`] distortion, its principal point at (0, 0).
//!
//! The file is `cameras points observations`; an observation a line, as `camera point x y`; then, one number a line, nine for
//! each camera (a rotation vector, t, f, k₁, k₂) and three for each point.

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;

use collinear::InteriorOrientation;
use collinear::camera::{CentralCamera, EvenRadial, ExteriorOrientation, Gnomonic};
use collinear::geometry::rotation::camera_from_photo;
use collinear::nalgebra::{Point2, Point3, Rotation3, Vector3};

use crate::bundler::{Words, known};
use crate::check::{finite, in_range};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};
use crate::json::{read_bytes, text_of};
use crate::write_atomically;

/// The longest text that is read, unpacked: 5·10⁷ observations.
pub const MAX_BYTES: u64 = 4 << 30;

/// No list is made longer than this before its entries were read.
const MOST_AHEAD: usize = 1 << 16;

/// The camera of such a problem: a perspective, two terms of radial distortion.
pub type BalCamera = CentralCamera<Gnomonic, EvenRadial>;

/// A bundle adjustment problem, with the numbers as the file has them.
///
/// # Example
/// By hand: a camera at the origin with f = 500, k₁ = 0.1 sees (2, 1, −10), |p|² = 0.05, at 500 · 1.005 · (0.2, 0.1).
///
/// ```
/// use collinear::CentralModel;
/// use collinear::nalgebra::{Point2, Point3};
/// use collinear_io::bal::Bal;
///
/// let bal = Bal::parse("1 1 1\n0 0 100.5 50.25\n0 0 0\n0 0 0\n500 0.1 0\n2 1 -10\n")?;
/// let (exterior, camera) = (bal.cameras[0].exterior()?, bal.cameras[0].model()?);
/// let image = camera.project_direction(&exterior.pose().apply(&bal.point(0).ok_or("a point")?).coords)?;
/// assert!((image - Point2::new(100.5, -50.25)).norm() < 1e-13);
/// assert_eq!(bal.observations[0].pixel(), Point2::new(100.5, -50.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bal {
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// The points, world coordinates.
    pub points: Vec<[f64; 3]>,
    /// What was measured.
    pub observations: Vec<Observation>,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The rotation vector of R, radians: the axis times the angle.
    pub rotation: [f64; 3],
    /// t, world units.
    pub translation: [f64; 3],
    /// f in pixels.
    pub focal: f64,
    /// k₁ and k₂.
    pub k: [f64; 2],
}

/// A point measured in a photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// The number of its camera, from 0.
    pub camera: u32,
    /// The number of its point, from 0.
    pub point: u32,
    /// Pixels from the principal point, x right, y up.
    pub image: [f64; 2],
}

impl Observation {
    /// The image point in this crate's axes, pixels from the principal point, x right, y down.
    #[must_use]
    pub fn pixel(&self) -> Point2<f64> {
        Point2::new(self.image[0], -self.image[1])
    }

    /// The observation whose [`pixel`](Self::pixel) is given.
    #[must_use]
    pub fn from_pixel(camera: u32, point: u32, pixel: &Point2<f64>) -> Self {
        Self { camera, point, image: [pixel.x, -pixel.y] }
    }
}

impl Camera {
    /// The exterior orientation.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for NaN and infinity.
    pub fn exterior(&self) -> Result<ExteriorOrientation, Error> {
        finite("camera.rotation", &self.rotation)?;
        finite("camera.translation", &self.translation)?;
        let turn = camera_from_photo();
        let rotation = turn * Rotation3::from_scaled_axis(Vector3::from(self.rotation));
        let translation = turn * Vector3::from(self.translation);
        Ok(ExteriorOrientation::from_rotation_translation(rotation, translation))
    }

    /// The camera without its pose.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for a principal distance that is not positive; [`ErrorKind::Library`] for coefficients that no lens
    /// has.
    pub fn model(&self) -> Result<BalCamera, Error> {
        in_range("camera.focal", self.focal, "more than 0", |f| f > 0.0)?;
        let library = |source| Error::from(ErrorKind::Library { field: "camera.k".into(), source });
        let interior =
            InteriorOrientation::new([self.focal; 2], Point2::origin(), 0.0).map_err(library)?;
        let lens = EvenRadial::new([self.k[0], self.k[1], 0.0, 0.0]).map_err(library)?;
        Ok(CentralCamera::from_parts(interior, Gnomonic, lens))
    }

    /// The camera of a pose and a model.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] for a model with another interior orientation than one principal distance, or with k₃ or k₄.
    pub fn from_parts(exterior: &ExteriorOrientation, camera: &BalCamera) -> Result<Self, Error> {
        let interior = camera.interior();
        let [fx, fy] = interior.principal_distance();
        let [k1, k2, k3, k4] = camera.distortion().coefficients();
        let plain = interior.principal_point() == Point2::origin() && interior.skew() == 0.0;
        if !(fx == fy && plain && k3 == 0.0 && k4 == 0.0) {
            let problem = FieldProblem::Unsupported {
                found: "another".into(),
                expected: "BAL has f, k1 and k2, and the principal point at (0, 0)",
            };
            return Err(FieldError::new("interior", problem).into());
        }
        let turn = camera_from_photo().inverse();
        let rotation = (turn * exterior.camera_from_world()).scaled_axis();
        let translation = turn * exterior.pose().translation();
        Ok(Self {
            rotation: rotation.into(),
            translation: translation.into(),
            focal: fx,
            k: [k1, k2],
        })
    }
}

impl Bal {
    /// A point of the world.
    #[must_use]
    pub fn point(&self, number: usize) -> Option<Point3<f64>> {
        self.points.get(number).map(|p| Point3::from(*p))
    }

    /// From a file, plain or gzip, whatever it is named.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), those of reading, and [`ErrorKind::Foreign`] for damaged gzip.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = read_bytes(path, MAX_BYTES).and_then(unpacked).and_then(text_of);
        text.and_then(|text| Self::parse(&text)).map_err(|e| e.in_file(path))
    }

    /// From text.
    ///
    /// # Errors
    /// [`ErrorKind::Line`] where a number is missing, NaN or infinite, or more follows than the counts say;
    /// [`ErrorKind::Field`] for an observation of a camera or point that is not there, or more entries than 2³².
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mut words = Words::new(text);
        let mut counts = [0_u32; 3];
        for (count, name) in counts.iter_mut().zip([
            "number of cameras",
            "number of points",
            "number of observations",
        ]) {
            *count = words.parsed(name)?;
        }
        let [cameras, points, observations] = counts.map(|c| c as usize);
        let mut bal = Self {
            cameras: Vec::with_capacity(cameras.min(MOST_AHEAD)),
            points: Vec::with_capacity(points.min(MOST_AHEAD)),
            observations: Vec::with_capacity(observations.min(MOST_AHEAD)),
        };
        for i in 0..observations {
            words.enter("observation", i, observations);
            let camera: u32 = words.parsed("camera")?;
            known("observation", "a camera", camera as usize, cameras, words.line())?;
            let point: u32 = words.parsed("point")?;
            known("observation", "a point", point as usize, points, words.line())?;
            let image = words.numbers("image point")?;
            bal.observations.push(Observation { camera, point, image });
        }
        for i in 0..cameras {
            words.enter("camera", i, cameras);
            let rotation = words.numbers("rotation vector")?;
            let translation = words.numbers("t")?;
            let [focal, k1, k2] = words.numbers("f, k1, k2")?;
            bal.cameras.push(Camera { rotation, translation, focal, k: [k1, k2] });
        }
        for i in 0..points {
            words.enter("point", i, points);
            bal.points.push(words.numbers("coordinates")?);
        }
        if words.rest().is_some() {
            let problem = LineProblem::FieldCount { found: 1, expected: 0 };
            return Err(ErrorKind::Line { line: words.line(), column: None, problem }.into());
        }
        Ok(bal)
    }

    /// The file's text; numbers are read back as they were.
    #[must_use]
    pub fn to_text(&self) -> String {
        let [cameras, points] = [self.cameras.len(), self.points.len()];
        let mut text = format!("{cameras} {points} {}\n", self.observations.len());
        for Observation { camera, point, image: [x, y] } in &self.observations {
            let _ = writeln!(text, "{camera} {point} {x} {y}");
        }
        for Camera { rotation, translation, focal, k } in &self.cameras {
            for value in rotation.iter().chain(translation).chain([focal]).chain(k) {
                let _ = writeln!(text, "{value}");
            }
        }
        for value in self.points.iter().flatten() {
            let _ = writeln!(text, "{value}");
        }
        text
    }

    /// To a file, plain text, atomically.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_atomically(path, |w| w.write_all(self.to_text().as_bytes()))
    }
}

/// The bytes of a gzip file, or these.
fn unpacked(bytes: Vec<u8>) -> Result<Vec<u8>, Error> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let mut text = vec![];
    flate2::read::MultiGzDecoder::new(&bytes[..])
        .take(MAX_BYTES + 1)
        .read_to_end(&mut text)
        .map_err(|e| ErrorKind::Foreign { program: "gzip", reason: e.to_string() })?;
    match text.len() as u64 {
        bytes if bytes > MAX_BYTES => Err(ErrorKind::TooLong { bytes, limit: MAX_BYTES }.into()),
        _ => Ok(text),
    }
}
