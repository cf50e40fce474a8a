//! Photographs with their cameras, out of any file that has some.

use std::path::Path;

use crate::camera::CameraFile;
use crate::error::{Error, ErrorKind};
use crate::json::{Document, kind_of, read_text};
use crate::{colmap, opencv, opensfm};

/// What the name of a photograph is whose file has none.
const UNNAMED: &str = "camera";

/// Reads photographs' names and cameras: a camera file, an OpenSfM reconstruction (its first), a COLMAP folder, a calibration of
/// OpenCV's. The content says which.
///
/// # Errors
/// [`ErrorKind::NotCameras`] for a file that is none of these, and those of the format it is.
pub fn read(path: &Path) -> Result<Vec<(String, CameraFile)>, Error> {
    if path.is_dir() {
        return colmap::Reconstruction::read(path)?.photographs();
    }
    read_text(path).and_then(|text| parse(&text)).map_err(|e| e.in_file(path))
}

/// As [`read`], from the text of a file.
///
/// # Errors
/// As [`read`].
///
/// ```
/// let text = r#"[{
///   "cameras": { "c": { "projection_type": "perspective", "width": 4000, "height": 3000, "focal": 0.9, "k1": 0, "k2": 0 } },
///   "shots": { "1.jpg": { "camera": "c", "rotation": [0, 0, 0], "translation": [0, 0, 5] } }
/// }]"#;
/// let (name, camera) = collinear_io::photographs::parse(text)?.remove(0);
/// assert_eq!((name.as_str(), camera.exterior.projection_center), ("1.jpg", [0.0, 0.0, -5.0]));
/// # Ok::<(), collinear_io::Error>(())
/// ```
pub fn parse(text: &str) -> Result<Vec<(String, CameraFile)>, Error> {
    let start = text.trim_start();
    if start.starts_with('[') {
        let model = opensfm::parse_reconstruction(text, 0)?;
        let of = |name: &String| Ok((name.clone(), model.camera(name)?));
        return model.shots.keys().map(of).collect();
    }
    if start.starts_with('{') && kind_of(text)?.is_some() {
        return Ok(vec![(UNNAMED.into(), CameraFile::parse(text)?)]);
    }
    if opencv::is_like(text) {
        return opencv::parse(text);
    }
    Err(ErrorKind::NotCameras.into())
}
