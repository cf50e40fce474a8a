//! Pictures as the texturer takes them.

use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use collinear::resample::ImageView;
use collinear_io::camera::CameraFile;
use collinear_io::picture::{Picture, read_picture};

/// The longest side of an output, in pixels.
pub const LARGEST_SIDE: u32 = 70_000;

/// The most pixels of an output; as many are read back.
pub const LARGEST_AREA: u64 = 1 << 28;

/// Refuses a size that no output has.
///
/// # Errors
/// A side of 0 or over [`LARGEST_SIDE`], more than [`LARGEST_AREA`] pixels.
pub fn check_size(width: u32, height: u32) -> Result<()> {
    for side in [width, height] {
        ensure!(
            (1..=LARGEST_SIDE).contains(&side),
            "a picture of {width} × {height} pixels: a side must be from 1 to {LARGEST_SIDE}"
        );
    }
    let area = u64::from(width) * u64::from(height);
    ensure!(
        area <= LARGEST_AREA,
        "a picture of {width} × {height} pixels: {area} pixels are more than {LARGEST_AREA}"
    );
    Ok(())
}

/// A picture in red, green and blue.
#[derive(Clone, Debug)]
pub(crate) struct Rgb {
    pub(crate) width: u32,
    pub(crate) height: u32,
    data: Vec<u8>,
}

impl Rgb {
    /// Reads a picture. Grey becomes colour, opacity is passed over.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        Ok(Self::from(read_picture(path)?))
    }

    /// Reads a photograph and refuses it where its camera belongs to another size.
    pub(crate) fn read_sized(path: &Path, camera: &CameraFile) -> Result<Self> {
        let picture = Self::read(path)?;
        camera
            .check_picture_size(picture.width, picture.height)
            .map_err(|e| anyhow!("{}: {e}", path.display()))?;
        Ok(picture)
    }

    pub(crate) fn data(&self) -> &[u8] {
        &self.data
    }

    pub(crate) fn view(&self) -> Result<ImageView<'_, u8, 3>, collinear::Error> {
        ImageView::new(&self.data, self.width as usize, self.height as usize)
    }
}

impl From<Picture> for Rgb {
    fn from(picture: Picture) -> Self {
        let Picture { width, height, channels, data, .. } = picture;
        let data = match channels {
            1 => data.iter().flat_map(|g| [*g; 3]).collect(),
            2 => data.chunks_exact(2).filter_map(<[u8]>::first).flat_map(|g| [*g; 3]).collect(),
            4 => data.chunks_exact(4).flat_map(|p| p.iter().take(3)).copied().collect(),
            _ => data,
        };
        Self { width, height, data }
    }
}
