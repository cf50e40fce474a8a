//! A wire frame drawn into its photograph.

use anyhow::{Result, anyhow};
use collinear_io::picture::Picture;
use tiny_skia::{IntSize, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use super::{CASING_OPACITY, CASING_WIDTH, Drawing, Overlay};
use crate::picture::drop_opacity;

impl Overlay {
    /// The photograph in colour with anti-aliased lines of `line_width` pixels over it, on a darker ground.
    ///
    /// # Errors
    /// A photograph of another size than the overlay's.
    pub fn draw_on(&self, photograph: &Picture, line_width: f64) -> Result<Picture> {
        let (width, height) = (photograph.width, photograph.height);
        let rgba = opaque(photograph);
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
        let stroke = |width: f64| Stroke {
            width: width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        let paths: Vec<_> = self.drawings.iter().map(|d| (d.color, path(d))).collect();
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        let mut lines = |color: [u8; 3], opacity: f64, path: &Path, stroke: &Stroke| {
            let [r, g, b] = color;
            paint.set_color_rgba8(r, g, b, (255.0 * opacity) as u8);
            pixmap.stroke_path(path, &paint, stroke, Transform::identity(), None);
        };
        let (casing, line) = (stroke(line_width * CASING_WIDTH), stroke(line_width));
        for path in paths.iter().filter_map(|(_, p)| p.as_ref()) {
            lines([0; 3], CASING_OPACITY, path, &casing);
        }
        for (color, path) in &paths {
            if let Some(path) = path {
                lines(*color, 1.0, path, &line);
            }
        }
        let mut data = pixmap.take();
        drop_opacity(&mut data);
        Ok(Picture { width, height, channels: 3, data, orientation: 1 })
    }
}

/// The photograph in colour, its own opacity passed over.
fn opaque(photograph: &Picture) -> Vec<u8> {
    let channels = usize::from(photograph.channels.max(1));
    let mut rgba = Vec::with_capacity(photograph.data.len() / channels * 4);
    for pixel in photograph.data.chunks_exact(channels) {
        match pixel {
            [r, g, b, ..] => rgba.extend([*r, *g, *b, u8::MAX]),
            [grey, ..] => rgba.extend([*grey, *grey, *grey, u8::MAX]),
            [] => {}
        }
    }
    rgba
}

fn path(drawing: &Drawing) -> Option<Path> {
    let mut path = PathBuilder::new();
    for line in &drawing.lines {
        for (i, p) in line.iter().enumerate() {
            let (x, y) = (p.x as f32, p.y as f32);
            if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
        }
    }
    path.finish()
}
