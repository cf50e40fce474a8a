//! Photographs with their cameras, out of any file that has some.

use std::path::Path;

use crate::camera::CameraFile;
use crate::error::{Error, ErrorKind};
use crate::json::{Document, kind_of, read_text};
use crate::{bundler, colmap, metashape, opencv, opensfm};

/// What the name of a photograph is whose file has none.
const UNNAMED: &str = "camera";

/// Reads photographs' names and cameras: a camera file, an OpenSfM reconstruction (its first), a COLMAP folder, Bundler's
/// `bundle.out`, a calibration of OpenCV's, cameras or a calibration of Metashape's. The content says which. Bundler's file does not say how large the pictures are:
/// `size`, which the others do not need, does.
///
/// # Errors
/// [`ErrorKind::NotCameras`] for a file that is none of these, [`ErrorKind::NoPictureSize`], and those of the format it is.
pub fn read(path: &Path, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    if path.is_dir() {
        return colmap::Reconstruction::read(path)?.photographs();
    }
    read_text(path).and_then(|text| parse(&text, size)).map_err(|e| e.in_file(path))
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
/// let (name, camera) = collinear_io::photographs::parse(text, None)?.remove(0);
/// assert_eq!((name.as_str(), camera.exterior.projection_center), ("1.jpg", [0.0, 0.0, -5.0]));
/// # Ok::<(), collinear_io::Error>(())
/// ```
pub fn parse(text: &str, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    let start = text.trim_start();
    if start.starts_with('[') {
        let model = opensfm::parse_reconstruction(text, 0)?;
        let of = |name: &String| Ok((name.clone(), model.camera(name)?));
        return model.shots.keys().map(of).collect();
    }
    if start.starts_with('{') && kind_of(text)?.is_some() {
        return Ok(vec![(UNNAMED.into(), CameraFile::parse(text)?)]);
    }
    if start.starts_with("# Bundle file") {
        let bundle = bundler::Bundle::parse(start)?;
        return bundle.photographs(size.ok_or(ErrorKind::NoPictureSize)?);
    }
    if start.starts_with('<') && !opencv::is_storage(start) {
        return metashape::parse(text);
    }
    if start.starts_with('<') || opencv::is_like(text) {
        return opencv::parse(text);
    }
    Err(ErrorKind::NotCameras.into())
}
