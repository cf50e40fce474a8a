//! PNG pictures: 8-bit RGB without loss.

use std::error::Error;
use std::io::BufReader;
use std::path::Path;

use super::camera::Camera;

#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Red, green, blue, row by row.
    pub(crate) data: Vec<u8>,
}

impl Image {
    pub(crate) fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        let decoder = png::Decoder::new(BufReader::new(std::fs::File::open(path)?));
        let mut reader = decoder.read_info()?;
        let mut data = vec![0; reader.output_buffer_size().ok_or("too large")?];
        let info = reader.next_frame(&mut data)?;
        Ok(Self { width: info.width as usize, height: info.height as usize, data })
    }

    /// Between the four nearest pixel centres; the border repeats.
    pub(crate) fn bilinear(&self, (x, y): (f64, f64)) -> [f64; 3] {
        let (x, y) = (x - 0.5, y - 0.5);
        let (u, v) = (x - x.floor(), y - y.floor());
        let pixel = |dx: f64, dy: f64, c: usize| {
            let i = (x.floor() + dx).clamp(0.0, self.width as f64 - 1.0) as usize;
            let j = (y.floor() + dy).clamp(0.0, self.height as f64 - 1.0) as usize;
            f64::from(self.data[3 * (j * self.width + i) + c])
        };
        [0, 1, 2].map(|c| {
            let top = pixel(0.0, 0.0, c) * (1.0 - u) + pixel(1.0, 0.0, c) * u;
            let low = pixel(0.0, 1.0, c) * (1.0 - u) + pixel(1.0, 1.0, c) * u;
            top * (1.0 - v) + low * v
        })
    }
}

/// Writes 8-bit RGB with whichever row filter packs best; the file's size in bytes.
pub(crate) fn write_png(
    path: &Path,
    camera: &Camera,
    pixels: &[[f64; 3]],
) -> Result<usize, Box<dyn Error>> {
    let bytes: Vec<u8> = pixels.iter().flatten().map(|v| (v + 0.5) as u8).collect();
    let mut smallest: Option<Vec<u8>> = None;
    for filter in [
        png::Filter::Adaptive,
        png::Filter::MinEntropy,
        png::Filter::Paeth,
        png::Filter::Sub,
        png::Filter::Up,
    ] {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, camera.width as u32, camera.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_filter(filter);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        if smallest.as_ref().is_none_or(|s| file.len() < s.len()) {
            smallest = Some(file);
        }
    }
    let file = smallest.unwrap_or_default();
    std::fs::write(path, &file)?;
    Ok(file.len())
}
