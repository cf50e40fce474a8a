//! COLMAP: a reconstruction's `cameras`, `images` and `points3D`, as text or binary.
//!
//! COLMAP's image coordinates are this crate's: pixels from the top-left corner of the top-left pixel, whose centre is (0.5,
//! 0.5). Its camera axes are too: x right, y down, z forward. Its pose is cam_from_world, x = R X + t, with a quaternion
//! w, x, y, z. Format: <https://colmap.github.io/format.html>; `rigs` and `frames` of newer versions are passed over, since
//! `images` has every pose.

mod binary;
pub(crate) mod models;
mod text;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use collinear::camera::{COLMAP_MODELS, ExteriorOrientation};
use collinear::geometry::rotation::Quaternion;
use collinear::nalgebra::Vector3;

use crate::atomic::write_together;
use crate::camera::{CameraFile, Exterior, Interior, check_quaternion};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem};
use crate::json::{Document, MAX_TEXT_BYTES, read_bytes, read_text};

/// Text or binary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// `cameras.txt`, `images.txt`, `points3D.txt`.
    Text,
    /// `cameras.bin`, `images.bin`, `points3D.bin`, little-endian.
    Binary,
}

/// A reconstruction as COLMAP has it.
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
/// use collinear_io::colmap::Reconstruction;
///
/// let cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n7 SIMPLE_RADIAL 1024 768 611.3 513.4 391.9 -0.11\n";
/// let images = "3 1 0 0 0 0 0 0 7 front gate.jpg\n\n";
/// let model = Reconstruction::parse_text(cameras, images, "")?;
/// let (name, camera) = &model.photographs()?[0];
/// // pycolmap 4.2.1, img_from_cam of (0.31, -0.22, 1).
/// let p = camera.camera()?.sensor().project(&Point3::new(0.31, -0.22, 1.0))?;
/// assert_eq!(name, "front gate.jpg");
/// assert!((p - Point2::new(699.8908498149999, 259.55165496999996)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reconstruction {
    /// The cameras by their identifiers.
    pub cameras: BTreeMap<u32, Camera>,
    /// The images by their identifiers.
    pub images: BTreeMap<u32, Image>,
    /// The points by their identifiers.
    pub points: BTreeMap<u64, Point>,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// COLMAP's name of the model, one of [`COLMAP_MODELS`].
    pub model: &'static str,
    /// Width of its pictures, pixels.
    pub width: u32,
    /// Height of its pictures, pixels.
    pub height: u32,
    /// In COLMAP's order.
    pub parameters: Vec<f64>,
}

/// A photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Its file.
    pub name: String,
    /// Its camera's identifier.
    pub camera: u32,
    /// w, x, y, z of cam_from_world.
    pub quaternion_wxyz: [f64; 4],
    /// t of cam_from_world.
    pub translation: [f64; 3],
    /// What was measured in it.
    pub observations: Vec<Observation>,
}

/// A measured image point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Pixels.
    pub image: [f64; 2],
    /// The point that it shows, where it was reconstructed.
    pub point: Option<u64>,
}

/// A reconstructed point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// World coordinates.
    pub world: [f64; 3],
    /// Red, green, blue.
    pub color: [u8; 3],
    /// The mean reprojection error in pixels; −1 where there is none.
    pub error: f64,
    /// The images that show it, and which of their observations does.
    pub track: Vec<(u32, u32)>,
}

/// The names of the three files without their extension.
const FILES: [&str; 3] = ["cameras", "images", "points3D"];

/// The three files of a folder: `cameras`, `images` and `points3D`.
///
/// ```
/// use collinear_io::colmap::{Encoding, files};
/// use std::path::Path;
///
/// assert_eq!(files(Path::new("sparse"), Encoding::Text)[0], Path::new("sparse/cameras.txt"));
/// ```
#[must_use]
pub fn files(folder: &Path, encoding: Encoding) -> [PathBuf; 3] {
    FILES.map(|name| folder.join(name).with_extension(encoding.extension()))
}

/// Adds what one of the files holds, as text.
type ParseText = fn(&str, &mut Reconstruction) -> Result<(), Error>;
/// As bytes.
type ParseBytes = fn(&[u8], &mut Reconstruction) -> Result<(), Error>;

impl Encoding {
    fn extension(self) -> &'static str {
        match self {
            Self::Text => "txt",
            Self::Binary => "bin",
        }
    }
}

impl Reconstruction {
    /// From a folder with `cameras`, `images` and perhaps `points3D`: binary where it has `cameras.bin`, as COLMAP reads it.
    ///
    /// # Errors
    /// [`ErrorKind::Line`] and [`ErrorKind::Binary`] with the place, [`ErrorKind::Field`] for values out of their domain,
    /// and those of reading.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let has = |name: &str| folder.join(name).is_file();
        let encoding = if has("cameras.bin") { Encoding::Binary } else { Encoding::Text };
        let as_text: [ParseText; 3] = [text::cameras, text::images, text::points];
        let as_bytes: [ParseBytes; 3] = [binary::cameras, binary::images, binary::points];
        let mut model = Self::default();
        for ((name, text), bytes) in FILES.into_iter().zip(as_text).zip(as_bytes) {
            let path = folder.join(name).with_extension(encoding.extension());
            if name == "points3D" && !path.is_file() {
                continue;
            }
            let read = match encoding {
                Encoding::Text => read_text(&path).and_then(|t| text(&t, &mut model)),
                Encoding::Binary => {
                    read_bytes(&path, MAX_TEXT_BYTES).and_then(|b| bytes(&b, &mut model))
                }
            };
            read.map_err(|e| e.in_file(&path))?;
        }
        model.check().map_err(|e| Error::from(e).in_file(folder))?;
        Ok(model)
    }

    /// From the texts of `cameras.txt`, `images.txt` and `points3D.txt`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse_text(cameras: &str, images: &str, points: &str) -> Result<Self, Error> {
        let mut model = Self::default();
        text::cameras(cameras, &mut model)?;
        text::images(images, &mut model)?;
        text::points(points, &mut model)?;
        model.check()?;
        Ok(model)
    }

    /// From the bytes of `cameras.bin`, `images.bin` and `points3D.bin`.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse_binary(cameras: &[u8], images: &[u8], points: &[u8]) -> Result<Self, Error> {
        let mut model = Self::default();
        binary::cameras(cameras, &mut model)?;
        binary::images(images, &mut model)?;
        binary::points(points, &mut model)?;
        model.check()?;
        Ok(model)
    }

    /// The contents of the three files.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for values that could not be read again. COLMAP 4 ends a name at its first space when it reads
    /// text, so names with spaces are for the binary form alone.
    pub fn encode(&self, encoding: Encoding) -> Result<[Vec<u8>; 3], Error> {
        self.check()?;
        if encoding == Encoding::Text {
            for (id, image) in &self.images {
                if image.name.contains(char::is_whitespace) {
                    let found = image.name.clone();
                    let expected =
                        "COLMAP cannot read names with spaces from text: write the binary form";
                    let problem = FieldProblem::Unsupported { found, expected };
                    return Err(FieldError::new(format!("image {id}.name"), problem).into());
                }
            }
        }
        Ok(match encoding {
            Encoding::Text => text::write(self).map(String::into_bytes),
            Encoding::Binary => binary::write(self),
        })
    }

    /// The three files of a folder, not yet written: their paths and contents.
    ///
    /// # Errors
    /// As [`encode`](Self::encode); [`ErrorKind::FolderTaken`] where the folder has `rigs` and `frames`, whose poses COLMAP takes
    /// before those of `images`, or `cameras.bin`, before any text.
    pub fn files(
        &self,
        folder: &Path,
        encoding: Encoding,
    ) -> Result<Vec<(PathBuf, Vec<u8>)>, Error> {
        let contents = self.encode(encoding).map_err(|e| e.in_file(folder))?;
        let first: &[&str] = match encoding {
            Encoding::Text => &["cameras.bin", "rigs.txt", "frames.txt"],
            Encoding::Binary => &["rigs.bin", "frames.bin"],
        };
        if let Some(file) = first.iter().find(|file| folder.join(file).exists()) {
            let taken = ErrorKind::FolderTaken { file: (*file).to_owned() };
            return Err(Error::from(taken).in_file(folder));
        }
        Ok(files(folder, encoding).into_iter().zip(contents).collect())
    }

    /// To three files in a folder, which is made: all of them, or none.
    ///
    /// # Errors
    /// As [`files`](Self::files) and [`write_together`].
    pub fn write(&self, folder: &Path, encoding: Encoding) -> Result<(), Error> {
        let files = self.files(folder, encoding)?;
        fs::create_dir_all(folder).map_err(|e| Error::from(ErrorKind::Write(e)).in_file(folder))?;
        write_together(&files)
    }

    /// Refuses values out of their domain and references to nothing.
    fn check(&self) -> Result<(), FieldError> {
        for (id, camera) in &self.cameras {
            camera.interior().check().map_err(|e| e.under(&format!("camera {id}")))?;
        }
        for (id, image) in &self.images {
            let under = |e: FieldError| e.under(&format!("image {id}"));
            if !self.cameras.contains_key(&image.camera) {
                return Err(under(missing("camera_id", "a camera", image.camera)));
            }
            check_quaternion("quaternion", &image.quaternion_wxyz).map_err(under)?;
            crate::check::finite("translation", &image.translation).map_err(under)?;
            let name = &image.name;
            if name.is_empty() || name.contains(['\n', '\r', '\0']) || name.trim() != name {
                let found = name.clone();
                let expected = "a name of one line, without spaces at its ends, is needed";
                let problem = FieldProblem::Unsupported { found, expected };
                return Err(under(FieldError::new("name", problem)));
            }
        }
        Ok(())
    }

    /// Each photograph's name and camera, in the order of the identifiers.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for a photograph whose camera is not there.
    pub fn photographs(&self) -> Result<Vec<(String, CameraFile)>, Error> {
        let of = |(id, image): (&u32, &Image)| {
            let Some(camera) = self.cameras.get(&image.camera) else {
                let error = missing("camera_id", "a camera", image.camera);
                return Err(Error::from(error.under(&format!("image {id}"))));
            };
            let file = CameraFile {
                width: camera.width,
                height: camera.height,
                interior: camera.interior(),
                exterior: image.exterior()?,
            };
            Ok((image.name.clone(), file))
        };
        self.images.iter().map(of).collect()
    }

    /// A reconstruction without points, of photographs with their cameras. Photographs of one interior orientation and
    /// size share a camera. Identifiers count from 1.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] for an interior that none of COLMAP's models is, and those of [`CameraFile::check`](Document::check).
    pub fn from_photographs(photographs: &[(String, CameraFile)]) -> Result<Self, Error> {
        let mut model = Self::default();
        for ((name, file), id) in photographs.iter().zip(1..) {
            let under = |e: FieldError| Error::from(e.under(name));
            file.check().map_err(under)?;
            let camera = Camera::from_file(file).map_err(under)?;
            let known = model.cameras.iter().find(|(_, c)| **c == camera).map(|(id, _)| *id);
            let number = known.unwrap_or(model.cameras.len() as u32 + 1);
            model.cameras.insert(number, camera);
            let exterior = file.exterior.orientation()?;
            let q = Quaternion::from_rotation(&exterior.camera_from_world());
            let image = Image {
                name: name.clone(),
                camera: number,
                quaternion_wxyz: [q.w, q.x, q.y, q.z],
                translation: exterior.pose().translation().into(),
                observations: vec![],
            };
            model.images.insert(id, image);
        }
        model.check()?;
        Ok(model)
    }
}

fn missing(field: &str, what: &'static str, id: u32) -> FieldError {
    let problem = FieldProblem::UnknownName { what, name: id.to_string(), known: vec![] };
    FieldError::new(field, problem)
}

/// The static name of a model.
fn model_name(name: &str) -> Option<&'static str> {
    COLMAP_MODELS.iter().map(|(known, _)| *known).find(|known| *known == name)
}

impl Image {
    fn exterior(&self) -> Result<Exterior, Error> {
        let [w, x, y, z] = self.quaternion_wxyz;
        let refused = |source| {
            let field = "quaternion".to_owned();
            Error::from(ErrorKind::Library { field, source })
        };
        let rotation = Quaternion { w, x, y, z }.rotation().map_err(refused)?;
        let translation = Vector3::from(self.translation);
        let exterior = ExteriorOrientation::from_rotation_translation(rotation, translation);
        Ok(Exterior::from_orientation(&exterior))
    }
}

impl Camera {
    fn interior(&self) -> Interior {
        Interior::Colmap { model: self.model.to_owned(), parameters: self.parameters.clone() }
    }
}
