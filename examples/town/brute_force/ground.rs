//! The ground: paved square, streets, gardens, river and fields, as one map of colours.

use super::ink::{SOFT, clouds, comb, hash, noise, ramp, rectangle, rgb, segment, smooth};
use super::vector::V3;

pub(crate) const FOUNTAIN: (f64, f64) = (4.0, -3.0);

type Place = (f64, f64);

/// Streets: ends and half width.
const STREETS: [(Place, Place, f64); 12] = [
    ((3.0, -300.0), (3.0, -24.0), 5.2),
    ((-8.5, 20.0), (-8.5, 36.0), 3.0),
    ((22.0, -14.8), (600.0, -60.0), 2.9),
    ((-22.0, 2.5), (-600.0, 30.0), 3.1),
    ((25.0, 22.5), (52.0, 40.0), 2.6),
    ((52.0, 40.0), (60.0, 106.0), 2.4),
    ((60.0, 106.0), (66.0, 240.0), 2.2),
    ((66.0, 240.0), (30.0, 900.0), 2.6),
    ((-25.0, 22.5), (-44.0, 36.0), 2.4),
    ((-44.0, 36.0), (-62.0, 104.0), 2.2),
    ((-58.0, -60.0), (62.0, -52.0), 2.6),
    ((58.0, -52.0), (54.0, 40.0), 2.4),
];

/// The river's middle line: northing at an easting.
fn river(x: f64) -> f64 {
    122.0 + 11.0 * (x / 62.0).sin() + 5.0 * (x / 27.0 + 1.0).sin()
}

/// Edge width for a boundary whose normal is (gx, gy): what a camera low over the town can resolve there.
fn reach(x: f64, y: f64, gx: f64, gy: f64) -> f64 {
    let away = x.hypot(y + 60.0);
    SOFT + (away - 110.0).max(0.0) * (0.0016 * gx.abs() + away / 9000.0 * gy.abs())
}

fn cover(d: f64, width: f64) -> f64 {
    smooth(-d / width)
}

pub(crate) fn albedo(x: f64, y: f64) -> V3 {
    let far = ramp(90.0, 135.0, y.max(x.abs() - 10.0).max(-y + 10.0));
    let mut c = grass(x, y);
    if far > 0.0 {
        c = c.mix(fields(x, y), far);
    }
    c = c.mix(rgb(0xA79A85), 0.75 * yard(x, y));
    if y > 90.0 {
        c = water(c, x, y);
    }
    let (d, along) = street(x, y);
    if d < 30.0 {
        let width = reach(x, y, 1.0 - 0.8 * along, along);
        c = c.mix(rgb(0xB9AE9B), cover(d - 0.55, width));
        c = c.mix(cobbles(x, y), cover(d, width));
    }
    let churchyard = rectangle(x + 8.0, y - 59.0, 17.5, 27.0);
    c = c.mix(lawn(x, y), cover(churchyard, SOFT));
    let walk = rectangle(x + 9.0, y - 56.0, 9.4, 22.0);
    c = c.mix(rgb(0xB8A88C) * (1.0 + 0.03 * noise(x, y, 33)), cover(walk, 0.3));
    let d = rectangle(x, y, 27.4, 26.0);
    c = c.mix(square(x, y), cover(d, SOFT));
    haze(c, x, y)
}

/// Signed distance to the nearest street's edge, and how much that street runs from west to east.
fn street(x: f64, y: f64) -> (f64, f64) {
    let mut nearest = (f64::INFINITY, 0.0);
    for &(a, b, half) in &STREETS {
        let d = segment((x, y), a, b) - half;
        if d < nearest.0 {
            nearest = (d, (b.0 - a.0).abs() / (b.0 - a.0).hypot(b.1 - a.1));
        }
    }
    nearest
}

fn grass(x: f64, y: f64) -> V3 {
    let m = clouds(x * 0.08, y * 0.08, 41) + 0.22 * noise(x * 0.5, y * 0.5, 44);
    rgb(0x71863F).mix(rgb(0x93984F), ramp(-1.1, 1.3, m))
}

fn lawn(x: f64, y: f64) -> V3 {
    grass(x, y).mix(rgb(0x6B8A3F), 0.5)
}

/// Beaten earth and gravel between the houses.
fn yard(x: f64, y: f64) -> f64 {
    let d = rectangle(x - 1.0, y + 2.0, 42.0, 41.0) + 5.0 * clouds(x * 0.09, y * 0.09, 51);
    ramp(5.0, -3.0, d)
}

fn cobbles(x: f64, y: f64) -> V3 {
    rgb(0x98907F) * (1.0 + 0.025 * clouds(x * 0.4, y * 0.4, 61))
}

fn square(x: f64, y: f64) -> V3 {
    let (dx, dy) = (x - FOUNTAIN.0, y - FOUNTAIN.1);
    let (r, angle) = (dx.hypot(dy), dy.atan2(dx));
    let (warm, cool, pale) = (rgb(0xB7A58A), rgb(0xA1937F), rgb(0xCFC3AC));
    // A chequer of four-metre fields with pale bands between, worn by traffic.
    let wave = |d: f64| smooth((comb(d, 8.0) - 2.0) / SOFT);
    let (a, b) = (wave(x), wave(y));
    let chequer = a * (1.0 - b) + b * (1.0 - a);
    let mut c = warm.mix(cool, 0.75 * chequer);
    let band = comb(x - 2.0, 4.0).min(comb(y - 2.0, 4.0)) - 0.2;
    c = c.mix(pale, 0.7 * cover(band, SOFT));
    // Round the fountain a rose of sixteen rays.
    let step = std::f64::consts::TAU / 16.0;
    let ray = (comb(angle, step) - 0.25 * step) * r;
    let rose = warm.mix(rgb(0x8A7F72), smooth(-ray / SOFT));
    c = c.mix(rose, cover(r - 11.0, SOFT));
    let ring = (r - 11.0).abs().min((r - 7.4).abs()) - 0.28;
    c = c.mix(pale, cover(ring, SOFT));
    let inner = cobbles(x, y).mix(cool, 0.5);
    c = c.mix(inner, cover(r - 7.12, SOFT));
    // A gutter and a flagged walk along the houses.
    let edge = rectangle(x, y, 24.0, 22.4);
    c = c.mix(rgb(0xBFB39D), cover(-edge, SOFT));
    let flags = comb(x, 1.5).min(comb(y, 1.5)) - 0.02;
    c = c * (1.0 - 0.035 * cover(flags, 0.16) * cover(-edge, SOFT));
    c = c.mix(rgb(0x857B6C), cover(edge.abs() - 0.16, SOFT));
    c * (1.0 + 0.02 * clouds(x * 0.2, y * 0.2, 71))
}

fn fields(x: f64, y: f64) -> V3 {
    const CROPS: [u32; 7] = [0xC9B566, 0x8A9A48, 0xA9B25C, 0x6F8A44, 0xD3C27B, 0x9C8A5E, 0x7F9450];
    let (sin, cos) = 0.16_f64.sin_cos();
    let turned = |x: f64, y: f64| (cos * x + sin * y, cos * y - sin * x);
    let (s, t) = turned(x, y);
    // Parcels: rows across the view grow deeper with distance.
    let level = t.hypot(90.0);
    let row = (level / 60.0).log2() * 2.6;
    let depth = level * level / t.abs().max(9.0) / 2.6 * std::f64::consts::LN_2;
    let crop = |i: f64, s: f64| {
        let breadth = 42.0 + 30.0 * hash(i as i64, 1, 81);
        let q = s / breadth + 5.0 * hash(i as i64, 2, 81);
        let j = q.floor();
        let pick = |j: f64| rgb(CROPS[(hash(i as i64, j as i64, 83) * 6.999) as usize]);
        let width = reach(x, y, cos, sin) / breadth;
        let lower = pick(j - 1.0).mix(pick(j), smooth((q - j) / width));
        lower.mix(pick(j + 1.0), smooth((q - j - 1.0) / width))
    };
    let i = row.floor();
    let width = reach(x, y, sin, cos) / depth;
    let c = crop(i - 1.0, s).mix(crop(i, s), smooth((row - i) / width));
    let c = c.mix(crop(i + 1.0, s), smooth((row - i - 1.0) / width));
    c * (1.0 + 0.04 * noise(x * 0.03, y * 0.012, 87))
}

fn water(c: V3, x: f64, y: f64) -> V3 {
    let d = (y - river(x)).abs();
    let width = reach(x, y, 0.2, 1.0);
    let c = c.mix(rgb(0xBFAF86), cover(d - 8.4, width + 0.6));
    let blue = rgb(0x5D8BA3).mix(rgb(0x84AEBE), ramp(-8.0, 8.0, y - river(x)));
    c.mix(blue, cover(d - 7.2, width))
}

/// The air between the town and the far country.
fn haze(c: V3, x: f64, y: f64) -> V3 {
    let away = x.hypot(y);
    c.mix(rgb(0xB9C3BE), 0.62 * ramp(120.0, 1100.0, away))
}
