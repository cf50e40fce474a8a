//! A wire frame as SVG.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{CASING_OPACITY, CASING_WIDTH, Overlay};

/// How an SVG file holds its photograph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Photograph<'a> {
    /// The bytes of a PNG or JPEG file, in the SVG itself.
    Embedded(&'a [u8]),
    /// A link: the path or address as the SVG is to have it.
    Linked(&'a str),
}

/// The size of names, as a part of the picture's longer side.
const TEXT: f64 = 1.0 / 60.0;

impl Overlay {
    /// The SVG document: the photograph, lines of `line_width` pixels, and names as text where `names` says so. Its user
    /// units are the photograph's pixels. The photograph is shown in its file's own rows and columns.
    #[must_use]
    pub fn to_svg(&self, photograph: Photograph<'_>, line_width: f64, names: bool) -> String {
        let Self { width, height, .. } = self;
        let mut svg = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">"
        );
        let _ = write!(
            svg,
            "<image width=\"{width}\" height=\"{height}\" style=\"image-orientation:none\" href=\""
        );
        match photograph {
            Photograph::Embedded(bytes) => {
                let kind = if bytes.starts_with(b"\x89PNG") { "png" } else { "jpeg" };
                let _ = write!(svg, "data:image/{kind};base64,");
                STANDARD.encode_string(bytes, &mut svg);
            }
            Photograph::Linked(address) => svg.push_str(&escaped(address)),
        }
        svg.push_str("\"/>\n");
        self.write_lines(&mut svg, line_width);
        if names {
            self.write_names(&mut svg);
        }
        svg.push_str("</svg>\n");
        svg
    }

    /// The lines twice: dark and wide, then coloured, so that they are seen on any ground.
    fn write_lines(&self, svg: &mut String, line_width: f64) {
        svg.push_str("<defs>\n");
        for (i, drawing) in self.drawings.iter().enumerate() {
            let _ = write!(svg, "<path id=\"f{i}\" d=\"");
            for line in &drawing.lines {
                for (k, p) in line.iter().enumerate() {
                    let command = if k == 0 { 'M' } else { 'L' };
                    let _ = write!(svg, "{command}{:.3} {:.3}", p.x, p.y);
                }
            }
            svg.push_str("\"/>\n");
        }
        let style = "fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\"";
        let _ = writeln!(
            svg,
            "</defs>\n<g {style} stroke=\"#000\" stroke-opacity=\"{CASING_OPACITY}\" stroke-width=\"{}\">",
            line_width * CASING_WIDTH
        );
        for i in 0..self.drawings.len() {
            let _ = writeln!(svg, "<use href=\"#f{i}\"/>");
        }
        let _ = writeln!(svg, "</g>\n<g {style} stroke-width=\"{line_width}\">");
        for (i, drawing) in self.drawings.iter().enumerate() {
            let _ = write!(svg, "<use href=\"#f{i}\" stroke=\"{}\">", hex(drawing.color));
            if let Some(name) = &drawing.name {
                let _ = write!(svg, "<title>{}</title>", escaped(name));
            }
            svg.push_str("</use>\n");
        }
        svg.push_str("</g>\n");
    }

    fn write_names(&self, svg: &mut String) {
        let size = TEXT * f64::from(self.width.max(self.height));
        let _ = writeln!(
            svg,
            "<g font-family=\"sans-serif\" font-size=\"{size:.1}\" text-anchor=\"middle\" \
             stroke=\"#000\" stroke-width=\"{:.1}\" paint-order=\"stroke\">",
            size / 5.0
        );
        for drawing in self.drawings.iter().filter(|d| !d.lines.is_empty()) {
            if let (Some(name), Some(p)) = (&drawing.name, drawing.label) {
                let _ = writeln!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{}\">{}</text>",
                    p.x,
                    p.y,
                    hex(drawing.color),
                    escaped(name)
                );
            }
        }
        svg.push_str("</g>\n");
    }
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A text as XML has it; characters that XML 1.0 cannot have become U+FFFD.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
