//! Residuals of a picture as vectors, enlarged, as SVG.

use std::fmt::Write;

use crate::overlay::escaped;

/// A residual at its place in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Vector {
    /// The point's name.
    pub name: String,
    /// Where it was measured, pixels.
    pub at: [f64; 2],
    /// Observed minus computed, pixels; none where the point took no part.
    pub residual: Option<[f64; 2]>,
}

/// The frame of a drawing: its top-left corner and its size, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    corner: [f64; 2],
    size: [f64; 2],
}

impl Sheet {
    /// A whole picture.
    #[must_use]
    pub fn of_picture([width, height]: [u32; 2]) -> Self {
        Self { corner: [0.0; 2], size: [f64::from(width), f64::from(height)] }
    }

    /// What holds the points of a picture whose size is not known.
    #[must_use]
    pub fn around(points: &[Vector]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for i in 0..2 {
                low[i] = low[i].min(point.at[i]);
                high[i] = high[i].max(point.at[i]);
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        if size.iter().all(|s| *s > 0.0 && s.is_finite()) {
            Self { corner: low, size }
        } else {
            Self { corner: [0.0; 2], size: [1.0; 2] }
        }
    }

    fn longer(&self) -> f64 {
        self.size[0].max(self.size[1])
    }

    /// The width of a thin line.
    fn stroke(&self) -> f64 {
        self.longer() / 800.0
    }

    /// The size of letters.
    fn text(&self) -> f64 {
        self.longer() / 45.0
    }
}

/// The SVG of a picture's frame with each point's residual as a vector from where the point was measured towards where it was
/// computed, `exaggeration` times as long. Its user units are pixels. A line of known length tells the scale.
#[must_use]
pub fn to_svg(points: &[Vector], sheet: &Sheet, exaggeration: f64) -> String {
    let Sheet { corner: [left, top], size: [width, height] } = *sheet;
    let (stroke, text) = (sheet.stroke(), sheet.text());
    let margin = 3.0 * text;
    let [from, above] = [left - margin, top - margin];
    let [across, down] = [width + 2.0 * margin, height + 2.5 * margin];
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{from:.1} {above:.1} {across:.1} {down:.1}\" \
         width=\"900\" height=\"{:.0}\">\n\
         <rect x=\"{from:.1}\" y=\"{above:.1}\" width=\"{across:.1}\" height=\"{down:.1}\" fill=\"#fff\"/>\n\
         <rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"#f7f7f4\" stroke=\"#555\" \
         stroke-width=\"{stroke:.2}\"/>\n\
         <defs><marker id=\"head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"5\" \
         markerHeight=\"5\" orient=\"auto\"><path d=\"M0 0 8 4 0 8z\" fill=\"#c0392b\"/></marker></defs>\n\
         <g font-family=\"sans-serif\" font-size=\"{text:.1}\" fill=\"#333\">",
        900.0 * down / across,
    );
    let mut labels = Vec::new();
    for point in points {
        let [x, y] = point.at;
        let color = if point.residual.is_some() { "#2c6fbb" } else { "#999" };
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{:.2}\"/>",
            if points.len() <= NAMED { 4.0 * stroke } else { 1.5 * stroke },
            if points.len() <= NAMED { 1.5 * stroke } else { 0.7 * stroke },
        );
        let [vx, vy] = point.residual.unwrap_or_default();
        let end = [x - exaggeration * vx, y - exaggeration * vy];
        if end != point.at && end.iter().all(|c| c.is_finite()) {
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.2}\" y1=\"{y:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"#c0392b\" \
                 stroke-width=\"{:.2}\" marker-end=\"url(#head)\"/>",
                end[0],
                end[1],
                if points.len() <= NAMED { 2.0 * stroke } else { stroke },
            );
        }
        if points.len() <= NAMED {
            let label = Label::beside(point, end, sheet, points, &labels);
            let _ = writeln!(
                svg,
                "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"{}\">{}</text>",
                label.x,
                label.y,
                label.anchor,
                escaped(&point.name),
            );
            labels.push(label);
        }
    }
    let bar = round(sheet.longer() / 6.0 / exaggeration);
    let below = top + height + 1.6 * text;
    let _ = writeln!(
        svg,
        "<line x1=\"{left}\" y1=\"{below:.1}\" x2=\"{:.2}\" y2=\"{below:.1}\" stroke=\"#c0392b\" stroke-width=\"{:.2}\"/>\n\
         <text x=\"{left}\" y=\"{:.1}\">{bar} px of residual, drawn {exaggeration} times as long; from measured to computed</text>\n\
         </g>\n</svg>",
        left + bar * exaggeration,
        2.0 * stroke,
        below + 1.4 * text,
    );
    svg
}

/// A name at its place.
struct Label {
    x: f64,
    y: f64,
    anchor: &'static str,
    /// What it covers: left, top, right, bottom.
    covers: [f64; 4],
}

impl Label {
    /// The place for a point's name: of the four corners about the point the one that covers least of the names before it,
    /// of the points and of what lies beyond the picture; the side where the vector is not goes first.
    fn beside(
        point: &Vector,
        end: [f64; 2],
        sheet: &Sheet,
        points: &[Vector],
        before: &[Self],
    ) -> Self {
        let (gap, text) = (6.0 * sheet.stroke(), sheet.text());
        // The mean advance of a sans-serif letter is about 0.55 of its size.
        let width = 0.55 * text * point.name.chars().count() as f64;
        let [x, y] = point.at;
        let (under, over) = (y + gap + 0.7 * text, y - gap);
        let [first, second] = if end[1] < y { [under, over] } else { [over, under] };
        let mut best: Option<(f64, Self)> = None;
        for (right, y) in [(true, first), (false, first), (true, second), (false, second)] {
            let (x, anchor, from) =
                if right { (x + gap, "start", x + gap) } else { (x - gap, "end", x - gap - width) };
            let covers = [from, y - 0.8 * text, from + width, y + 0.2 * text];
            let [left, top] = sheet.corner;
            let inside = overlap(&covers, &[left, top, left + sheet.size[0], top + sheet.size[1]]);
            let mark = |p: &Vector| [p.at[0] - gap, p.at[1] - gap, p.at[0] + gap, p.at[1] + gap];
            let cost = (text * width - inside)
                + before.iter().map(|l| overlap(&covers, &l.covers)).sum::<f64>()
                + points.iter().map(|p| overlap(&covers, &mark(p))).sum::<f64>();
            if best.as_ref().is_none_or(|(least, _)| cost < least - 1e-9 * text * text) {
                best = Some((cost, Self { x, y, anchor, covers }));
            }
        }
        best.map_or(Self { x, y: first, anchor: "start", covers: [0.0; 4] }, |(_, label)| label)
    }
}

/// The area that two rectangles share.
fn overlap(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    let side = |i: usize| (a[i + 2].min(b[i + 2]) - a[i].max(b[i])).max(0.0);
    side(0) * side(1)
}

/// More points than these are drawn small and without their names.
const NAMED: usize = 60;

/// The exaggeration that draws the longest residual a tenth of the picture long: a round number.
#[must_use]
pub fn fitting_exaggeration(points: &[Vector], sheet: &Sheet) -> f64 {
    let lengths = points.iter().filter_map(|p| p.residual).map(|[x, y]| x.hypot(y));
    let wanted = 0.1 * sheet.longer() / lengths.fold(0.0, f64::max);
    if wanted.is_finite() && wanted > 1.0 { round(wanted.min(1e6)) } else { 1.0 }
}

/// 1, 2 or 5 times a power of ten, not above the value.
fn round(value: f64) -> f64 {
    let exponent = value.log10().floor() as i32;
    // A negative power by division: 0.1 and not 0.1 + ε.
    let times = |m: f64| match exponent {
        0.. => m * 10f64.powi(exponent),
        _ => m / 10f64.powi(-exponent),
    };
    [5.0, 2.0].into_iter().map(times).find(|v| *v <= value).unwrap_or_else(|| times(1.0))
}
