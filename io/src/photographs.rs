//! Photographs with their cameras, out of any file that has some.

use std::path::Path;

use crate::camera::CameraFile;
use crate::error::{Error, ErrorKind};
use crate::json::{Document, MAX_TEXT_BYTES, kind_of, read_bytes, text_of};
use crate::orientation::AngleUnit;
use crate::{bundler, colmap, gltf, metashape, nerf, opencv, opensfm, orientation, pix4d};

/// What the name of a photograph is whose file has none.
const UNNAMED: &str = "camera";

/// What a file does not say and comes from elsewhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Given {
    /// Width and height of the pictures: Bundler's file, Pix4D's `_pmatrix.txt` and its own `.cam`, and
    /// most glTF do not say them.
    pub size: Option<[u32; 2]>,
    /// The camera of a table of orientations, whose own pose counts for nothing.
    pub interior: Option<CameraFile>,
    /// The unit of a table's angles, where its header has none.
    pub angle_unit: Option<AngleUnit>,
    /// What is added to the projection centres, world units: Pix4D's `_offset.xyz`.
    pub offset: [f64; 3],
}

/// Reads photographs' names and cameras: a camera file, an OpenSfM reconstruction (its first), a COLMAP folder, Bundler's
/// `bundle.out`, a calibration of OpenCV's, cameras or a calibration of Metashape's, Pix4D's parameters, glTF or GLB, nerfstudio's
/// `transforms.json`. The content says which. Bundler's file does not say how large the pictures are: `size`, which most others do not
/// need, does.
///
/// # Errors
/// [`ErrorKind::NotCameras`] for a file that is none of these, [`ErrorKind::NoPictureSize`], and those of the format it is.
pub fn read(path: &Path, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    read_with(path, &Given { size, ..Given::default() })
}

/// As [`read`], with more of what a file may not say; tables of orientations too.
///
/// # Errors
/// As [`read`]; [`ErrorKind::NoInterior`] and [`ErrorKind::NoAngleUnit`] for tables of orientations,
/// [`ErrorKind::OwnInterior`] for other files where an interior orientation is given.
pub fn read_with(path: &Path, given: &Given) -> Result<Vec<(String, CameraFile)>, Error> {
    if path.is_dir() {
        let photographs = colmap::Reconstruction::read(path)?.photographs()?;
        return finished(photographs, given).map_err(|e| e.in_file(path));
    }
    let of_file = || {
        let bytes = read_bytes(path, MAX_TEXT_BYTES)?;
        if bytes.starts_with(b"glTF") {
            return parse_with(gltf::json_of_glb(&bytes)?, given);
        }
        parse_with(&text_of(bytes)?, given)
    };
    of_file().map_err(|e| e.in_file(path))
}

/// The camera of a file whose photographs have one interior orientation, as [`Given::interior`] needs it.
///
/// # Errors
/// As [`read`], and [`ErrorKind::SeveralInteriors`].
pub fn read_interior(path: &Path, size: Option<[u32; 2]>) -> Result<CameraFile, Error> {
    let mut photographs = read(path, size)?.into_iter().map(|(_, camera)| camera);
    let first =
        photographs.next().ok_or_else(|| Error::from(ErrorKind::NotCameras).in_file(path))?;
    let same = |c: &CameraFile| {
        (c.width, c.height, &c.interior) == (first.width, first.height, &first.interior)
    };
    match photographs.filter(|c| !same(c)).count() {
        0 => Ok(first),
        others => {
            let kind = ErrorKind::SeveralInteriors { count: others + 1 };
            Err(Error::from(kind).in_file(path))
        }
    }
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
    parse_with(text, &Given { size, ..Given::default() })
}

/// As [`read_with`], from the text of a file.
///
/// # Errors
/// As [`read_with`].
pub fn parse_with(text: &str, given: &Given) -> Result<Vec<(String, CameraFile)>, Error> {
    let size = || given.size.ok_or(ErrorKind::NoPictureSize);
    let start = text.trim_start();
    let photographs = if start.starts_with('[') {
        let model = opensfm::parse_reconstruction(text, 0)?;
        let of = |name: &String| Ok((name.clone(), model.camera(name)?));
        model.shots.keys().map(of).collect::<Result<_, Error>>()?
    } else if start.starts_with('{') && kind_of(text)?.is_some() {
        vec![(UNNAMED.into(), CameraFile::parse(text)?)]
    } else if start.starts_with("# Bundle file") {
        bundler::Bundle::parse(start)?.photographs(size()?)?
    } else if gltf::is_like(start) {
        gltf::parse(text, given.size)?
    } else if nerf::is_like(start) {
        nerf::parse(text, given.size)?
    } else if start.starts_with('<') && !opencv::is_storage(start) {
        metashape::parse(text)?
    } else if start.starts_with('<') || opencv::is_like(text) {
        opencv::parse(text)?
    } else if pix4d::is_like(text) {
        pix4d::parse(text)?
    } else if pix4d::is_cam(text) {
        pix4d::parse_cam(text, given.size)?
    } else if pix4d::is_pmatrix(text) {
        pix4d::parse_pmatrix(text, size()?)?
    } else if let Some(camera) = &given.interior {
        let orientations = orientation::parse(text, given.angle_unit)?;
        let taken = Given { interior: None, ..given.clone() };
        return finished(orientation::photographs(orientations, camera), &taken);
    } else if orientation::has_header(text) {
        return Err(ErrorKind::NoInterior.into());
    } else {
        return Err(ErrorKind::NotCameras.into());
    };
    finished(photographs, given)
}

/// With the offset; an interior orientation that is still there was not needed.
fn finished(
    mut photographs: Vec<(String, CameraFile)>,
    given: &Given,
) -> Result<Vec<(String, CameraFile)>, Error> {
    if given.interior.is_some() {
        return Err(ErrorKind::OwnInterior.into());
    }
    if given.offset != [0.0; 3] {
        for (name, camera) in &mut photographs {
            let center = &mut camera.exterior.projection_center;
            center.iter_mut().zip(given.offset).for_each(|(c, o)| *c += o);
            camera.check().map_err(|e| e.under(name))?;
        }
    }
    // What is read can be used: numbers that no model takes are refused here, and not when a point is asked for.
    for (name, camera) in &photographs {
        camera.camera().map_err(|e| e.named_by(name.clone()))?;
    }
    Ok(photographs)
}
