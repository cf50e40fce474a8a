//! A wire frame drawn into its photograph.

use anyhow::{Result, anyhow};
use collinear_io::picture::Picture;
use tiny_skia::{IntSize, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};

use super::Overlay;
use crate::picture::Rgb;

impl Overlay {
    /// The photograph in colour with anti-aliased lines of `line_width` pixels over it.
    ///
    /// # Errors
    /// A photograph of another size than the overlay's.
    pub fn draw_on(&self, photograph: &Picture, line_width: f64) -> Result<Picture> {
        let (width, height) = (photograph.width, photograph.height);
        let rgba = Rgb::from(photograph.clone())
            .data()
            .chunks_exact(3)
            .flat_map(|p| p.iter().copied().chain([u8::MAX]))
            .collect();
        let mut pixmap = IntSize::from_wh(width, height)
            .filter(|_| (width, height) == (self.width, self.height))
            .and_then(|size| Pixmap::from_vec(rgba, size))
            .ok_or_else(|| {
                anyhow!(
                    "the photograph is {width} × {height} pixels, the overlay {} × {}",
                    self.width,
                    self.height
                )
            })?;
        let stroke = Stroke {
            width: line_width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        for drawing in &self.drawings {
            let mut paint = Paint { anti_alias: true, ..Paint::default() };
            let [r, g, b] = drawing.color;
            paint.set_color_rgba8(r, g, b, u8::MAX);
            let mut path = PathBuilder::new();
            for line in &drawing.lines {
                for (i, p) in line.iter().enumerate() {
                    let (x, y) = (p.x as f32, p.y as f32);
                    if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
                }
            }
            if let Some(path) = path.finish() {
                pixmap.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
            }
        }
        let data = pixmap.data().chunks_exact(4).flat_map(|p| p.iter().take(3)).copied().collect();
        Ok(Picture { width, height, channels: 3, data, orientation: 1 })
    }
}
