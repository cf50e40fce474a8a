//! Pictures as the texturer takes them.

use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use collinear::resample::ImageView;
use collinear_io::picture::{Picture, read_picture};
use collinear_io::sensor::SensorFile;

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
    pub(crate) fn read_sized(path: &Path, camera: &SensorFile) -> Result<Self> {
        let picture = Self::read(path)?;
        camera
            .check_picture_size(picture.width, picture.height)
            .map_err(|e| anyhow!("{}: {e}", path.display()))?;
        Ok(picture)
    }

    pub(crate) fn view(&self) -> Result<ImageView<'_, u8, 3>, collinear::Error> {
        ImageView::new(&self.data, self.width as usize, self.height as usize)
    }
}

impl From<Picture> for Rgb {
    fn from(picture: Picture) -> Self {
        let Picture { width, height, channels, mut data, .. } = picture;
        match channels {
            1 | 2 => spread_grey(&mut data, channels.into()),
            4 => drop_opacity(&mut data),
            _ => {}
        }
        Self { width, height, data }
    }
}

/// Grey pixels, of `channels` samples, as three equal ones. In place: a photograph may fill half of the memory.
fn spread_grey(data: &mut Vec<u8>, channels: usize) {
    let pixels = data.len() / channels;
    data.reserve_exact((3 * pixels).saturating_sub(data.len()));
    data.resize(3 * pixels, 0);
    // From the end, so that no pixel is overwritten before it is read.
    for i in (0..pixels).rev() {
        let grey = data.get(channels * i).copied().unwrap_or_default();
        if let Some(pixel) = data.get_mut(3 * i..3 * i + 3) {
            pixel.fill(grey);
        }
    }
}

/// Pixels of four samples without their last. In place.
pub(crate) fn drop_opacity(data: &mut Vec<u8>) {
    let pixels = data.len() / 4;
    for i in 1..pixels {
        data.copy_within(4 * i..4 * i + 3, 3 * i);
    }
    data.truncate(3 * pixels);
    data.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::{Picture, Rgb};

    #[test]
    fn every_number_of_channels_becomes_three() {
        for (channels, data, expected) in [
            (1, vec![1, 2, 3], [1, 1, 1, 2, 2, 2, 3, 3, 3]),
            (2, vec![1, 9, 2, 8, 3, 7], [1, 1, 1, 2, 2, 2, 3, 3, 3]),
            (3, vec![1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 3, 4, 5, 6, 7, 8, 9]),
            (4, vec![1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0], [1, 2, 3, 4, 5, 6, 7, 8, 9]),
        ] {
            let picture = Picture { width: 3, height: 1, channels, data, orientation: 1 };
            assert_eq!(Rgb::from(picture).data, expected, "{channels}");
        }
    }
}
