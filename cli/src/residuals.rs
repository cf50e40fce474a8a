//! Residuals of a picture as vectors, enlarged, as SVG.

use std::fmt::Write;

use crate::overlay::escaped;
use crate::resect::PointResult;

/// The SVG of a picture's frame with each point's residual as a vector from where the point was measured towards where it was
/// computed, `exaggeration` times as long. Its user units are pixels. A line of known length tells the scale.
#[must_use]
pub fn to_svg(points: &[PointResult], [width, height]: [u32; 2], exaggeration: f64) -> String {
    let longer = f64::from(width.max(height));
    let (stroke, text) = (longer / 800.0, longer / 45.0);
    let margin = 3.0 * text;
    let [across, down] = [f64::from(width) + 2.0 * margin, f64::from(height) + 2.5 * margin];
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{:.1} {:.1} {across:.1} {down:.1}\" \
         width=\"900\" height=\"{:.0}\">",
        -margin,
        -margin,
        900.0 * down / across,
    );
    let _ = writeln!(
        svg,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#f7f7f4\" stroke=\"#555\" stroke-width=\"{stroke:.2}\"/>",
        -margin, -margin,
    );
    let _ = writeln!(
        svg,
        "<defs><marker id=\"head\" viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"5\" \
         markerHeight=\"5\" orient=\"auto\"><path d=\"M0 0 8 4 0 8z\" fill=\"#c0392b\"/></marker></defs>\n\
         <g font-family=\"sans-serif\" font-size=\"{text:.1}\" fill=\"#333\">"
    );
    for point in points {
        let [x, y] = point.image;
        let color = if point.used { "#2c6fbb" } else { "#999" };
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{:.2}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{:.2}\"/>",
            4.0 * stroke,
            1.5 * stroke,
        );
        let end = [x - exaggeration * point.residual[0], y - exaggeration * point.residual[1]];
        if point.used && end.iter().all(|c| c.is_finite()) {
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.2}\" y1=\"{y:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"#c0392b\" \
                 stroke-width=\"{:.2}\" marker-end=\"url(#head)\"/>",
                end[0],
                end[1],
                2.0 * stroke,
            );
        }
        if points.len() <= NAMED {
            // On the side where the vector is not, and within the picture.
            let (aside, anchor) = match x > 0.75 * f64::from(width) {
                true => (-6.0 * stroke, "end"),
                false => (6.0 * stroke, "start"),
            };
            let above = if end[1] < y { 6.0 * stroke + 0.7 * text } else { -6.0 * stroke };
            let _ = writeln!(
                svg,
                "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"{anchor}\">{}</text>",
                x + aside,
                y + above,
                escaped(&point.id),
            );
        }
    }
    let bar = round(longer / 6.0 / exaggeration);
    let (left, below) = (0.0, f64::from(height) + 1.6 * text);
    let _ = writeln!(
        svg,
        "<line x1=\"{left}\" y1=\"{below:.1}\" x2=\"{:.2}\" y2=\"{below:.1}\" stroke=\"#c0392b\" stroke-width=\"{:.2}\"/>\n\
         <text x=\"{left}\" y=\"{:.1}\">{bar} px of residual, drawn {} times as long; from measured to computed</text>\n</g>\n</svg>",
        left + bar * exaggeration,
        2.0 * stroke,
        below + 1.4 * text,
        exaggeration,
    );
    svg
}

/// More points than these are drawn without their names.
const NAMED: usize = 60;

/// The exaggeration that draws the longest residual a tenth of the picture long: a round number.
#[must_use]
pub fn fitting_exaggeration(points: &[PointResult], [width, height]: [u32; 2]) -> f64 {
    let used = points.iter().filter(|p| p.used);
    let longest = used.map(|p| p.residual[0].hypot(p.residual[1])).fold(0.0, f64::max);
    let wanted = 0.1 * f64::from(width.max(height)) / longest;
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
