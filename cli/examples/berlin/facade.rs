//! The façade rectified face-on, from planes and cameras.

use std::path::Path;

use anyhow::Result;
use collinear::resample::{Border, Filter};
use collinear_cli::rectify::{Rectification, size_at};
use collinear_io::Document;
use collinear_io::picture::{Picture, write_picture};
use collinear_io::plane::PlaneFile;

use crate::site::{Site, plane_file};

/// World units in a pixel of a rectified picture: a centimetre of the reconstruction.
const GROUND_SAMPLE: f64 = 0.01;

/// The planes to rectify, by a depth near theirs.
const PLANES: [(&str, f64); 3] = [("portal", 29.16), ("columns", 21.17), ("wall", 22.51)];

/// Writes plane and camera files and the rectified pictures, and prints how well these agree.
pub(crate) fn rectify(site: &Site, out: &Path) -> Result<()> {
    for photograph in &site.photographs {
        photograph.camera.write(&out.join(format!("camera_{}.json", photograph.name)))?;
    }
    for (name, depth) in PLANES {
        let found = site.sheet(depth)?;
        let file = plane_file(found, *site.axes.up, &site.origin)?;
        file.write(&out.join(format!("plane_{name}.json")))?;
        let pictures = one_plane(site, name, &file, out)?;
        for (i, a) in pictures.iter().enumerate() {
            for (j, b) in pictures.iter().enumerate().skip(i + 1) {
                let names = [i, j].map(|k| site.photographs[k].name.as_str());
                report(name, names, a, b);
            }
        }
    }
    Ok(())
}

fn one_plane(site: &Site, name: &str, file: &PlaneFile, out: &Path) -> Result<Vec<Picture>> {
    let Some(rectangle) = file.rectangle else { return Ok(Vec::new()) };
    let (rectangle, width, height) = size_at(&rectangle, GROUND_SAMPLE)?;
    let mut pictures = Vec::new();
    for photograph in &site.photographs {
        let sensor = photograph.camera.clone().into();
        let r = Rectification::of_plane(file, &rectangle, &sensor, width, height)?;
        let border = Border::Transparent;
        let picture = r.apply(&photograph.picture, Filter::Bilinear, border, &|_, _| ())?.picture;
        write_picture(&out.join(format!("facade_{name}_{}.png", photograph.name)), &picture)?;
        pictures.push(picture);
    }
    Ok(pictures)
}

/// Grey values, NaN where the photograph shows nothing.
fn grey(picture: &Picture) -> Vec<f64> {
    let value = |p: &[u8]| match *p {
        [r, g, b, a] if a > 0 => 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b),
        _ => f64::NAN,
    };
    picture.data.chunks_exact(usize::from(picture.channels)).map(value).collect()
}

/// Prints the mean difference of two rectified pictures, as they are and with the second brought to the exposure of the
/// first, and the shift of whole pixels at which they agree best.
fn report(plane: &str, names: [&str; 2], a: &Picture, b: &Picture) {
    let (width, height) = (a.width as i32, a.height as i32);
    let (a, b) = (grey(a), grey(b));
    let at = |v: &[f64], x: i32, y: i32| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        if inside { v.get((y * width + x) as usize).copied().unwrap_or(f64::NAN) } else { f64::NAN }
    };
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for (&p, &q) in a.iter().zip(&b) {
        if p.is_finite() && q.is_finite() {
            pairs.push([p, q]);
        }
    }
    if pairs.is_empty() {
        println!(
            "  {plane}: photographs {} and {} show no part of it in common",
            names[0], names[1]
        );
        return;
    }
    let n = pairs.len() as f64;
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(f).sum::<f64>() / n;
    let (ma, mb) = (mean(&|p| p[0]), mean(&|p| p[1]));
    let covariance = mean(&|p| (p[0] - ma) * (p[1] - mb));
    let (va, vb) = (mean(&|p| (p[0] - ma).powi(2)), mean(&|p| (p[1] - mb).powi(2)));
    let gain = (va / vb).sqrt();
    let raw = mean(&|p| (p[0] - p[1]).abs());
    let matched = mean(&|p| (p[0] - ma - gain * (p[1] - mb)).abs());
    let mut best = (f64::INFINITY, [0, 0]);
    for dy in -12..=12 {
        for dx in -12..=12 {
            let (mut sum, mut count) = (0.0, 0.0);
            for y in (0..height).step_by(3) {
                for x in (0..width).step_by(3) {
                    let d = at(&a, x, y) - ma - gain * (at(&b, x + dx, y + dy) - mb);
                    if d.is_finite() {
                        sum += d.abs();
                        count += 1.0;
                    }
                }
            }
            if sum / count < best.0 {
                best = (sum / count, [dx, dy]);
            }
        }
    }
    println!(
        "  {plane}: {} and {} over {:.2} Mpixel: mean |Δgrey| {raw:.2}, with the same exposure {matched:.2} \
         (correlation {:.3}); best at a shift of ({}, {}) pixels: {:.2}",
        names[0],
        names[1],
        n / 1e6,
        covariance / (va * vb).sqrt(),
        best.1[0],
        best.1[1],
        best.0
    );
}
