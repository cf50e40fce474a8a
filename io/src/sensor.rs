//! Files of any sensor.

use std::path::Path;

use collinear::camera::SensorModel;

use crate::camera::CameraFile;
use crate::check::one_size;
use crate::convert::Camera;
use crate::error::{Error, ErrorKind};
use crate::json::{Document, kind_of, read_text};
use crate::rpc::RpcFile;
use crate::scanner::ScannerFile;

/// A sensor's file, of whichever kind.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorFile {
    /// One exposure.
    Camera(CameraFile),
    /// A scan.
    Scanner(Box<ScannerFile>),
    /// A rational polynomial camera in its world.
    Rpc(Box<RpcFile>),
}

impl From<CameraFile> for SensorFile {
    fn from(camera: CameraFile) -> Self {
        Self::Camera(camera)
    }
}

impl SensorFile {
    /// From text that says what it is.
    ///
    /// # Errors
    /// As [`Document::parse`], and [`RpcFile::sensor`].
    pub fn parse(text: &str) -> Result<Self, Error> {
        match kind_of(text)? {
            Some(kind) if kind == ScannerFile::KIND => {
                ScannerFile::parse(text).map(Box::new).map(Self::Scanner)
            }
            Some(kind) if kind == RpcFile::KIND => {
                let file = RpcFile::parse(text)?;
                file.sensor()?;
                Ok(Self::Rpc(Box::new(file)))
            }
            Some(found) if found != CameraFile::KIND => {
                Err(ErrorKind::WrongKind { expected: "camera or scanner", found }.into())
            }
            _ => CameraFile::parse(text).map(Self::Camera),
        }
    }

    /// From a file.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        read_text(path).and_then(|text| Self::parse(&text)).map_err(|e| e.in_file(path))
    }

    /// As [`read`](Self::read), or `None` for a folder and a file that is none of ours, as one of another program's.
    ///
    /// # Errors
    /// As [`Document::read`], for a file that says it is ours.
    pub fn read_if_ours(path: &Path) -> Result<Option<Self>, Error> {
        if path.is_dir() {
            return Ok(None);
        }
        let text = match read_text(path) {
            Ok(text) => text,
            Err(e) if matches!(e.kind(), ErrorKind::NotText { .. }) => return Ok(None),
            Err(e) => return Err(e.in_file(path)),
        };
        let ours = text.trim_start().starts_with('{')
            && kind_of(&text).map_err(|e| e.in_file(path))?.is_some();
        if ours { Self::parse(&text).map(Some).map_err(|e| e.in_file(path)) } else { Ok(None) }
    }

    /// Width and height of the picture, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        match self {
            Self::Camera(camera) => [camera.width, camera.height],
            Self::Scanner(scanner) => [scanner.width, scanner.height],
            // One without a size is refused where it is read.
            Self::Rpc(file) => file.size().unwrap_or_default(),
        }
    }

    /// Refuses a picture of another size than the sensor's.
    ///
    /// # Errors
    /// [`ErrorKind::PictureSize`].
    pub fn check_picture_size(&self, width: u32, height: u32) -> Result<(), Error> {
        one_size([width, height], self.size())
    }

    /// The library's sensor.
    ///
    /// # Errors
    /// As [`CameraFile::camera`], [`ScannerFile::sensor`] and [`RpcFile::sensor`].
    pub fn sensor(&self) -> Result<Box<dyn SensorModel>, Error> {
        match self {
            Self::Camera(camera) => camera.camera().map(Camera::into_sensor),
            Self::Scanner(scanner) => scanner.sensor(),
            Self::Rpc(file) => Ok(Box::new(file.sensor()?)),
        }
    }
}
