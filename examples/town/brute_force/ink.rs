//! Soft drawing on a plane: edges as smooth steps, signed distances, repeatable noise.

use super::vector::{V3, v3};

/// Width in metres of every drawn edge: about two pixels of the photographs.
pub(crate) const SOFT: f64 = 0.18;

/// 0 below −½, 1 above ½, a cubic between.
pub(crate) fn smooth(x: f64) -> f64 {
    let x = (x + 0.5).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Smooth from 0 at `a` to 1 at `b`.
pub(crate) fn ramp(a: f64, b: f64, x: f64) -> f64 {
    smooth((x - a) / (b - a) - 0.5)
}

/// Cover of a shape at signed distance `d` (negative inside).
pub(crate) fn ink(d: f64) -> f64 {
    smooth(-d / SOFT)
}

pub(crate) fn rectangle(x: f64, y: f64, half_width: f64, half_height: f64) -> f64 {
    (x.abs() - half_width).max(y.abs() - half_height)
}

pub(crate) fn segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (px, py) = (p.0 - a.0, p.1 - a.1);
    let t = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (px - t * dx).hypot(py - t * dy)
}

/// A door or window with a round head: `height` to the crown, centred on x = 0, standing on y = 0.
pub(crate) fn arch(x: f64, y: f64, half_width: f64, height: f64) -> f64 {
    let spring = height - half_width;
    if y > spring { x.hypot(y - spring) - half_width } else { (x.abs() - half_width).max(-y) }
}

/// Distance to the nearest line of a family `period` apart.
pub(crate) fn comb(x: f64, period: f64) -> f64 {
    (x - period * (x / period).round()).abs()
}

pub(crate) fn hash(x: i64, y: i64, seed: u32) -> f64 {
    let mut h = (x as u32).wrapping_mul(0x9E37_79B1)
        ^ (y as u32).wrapping_mul(0x85EB_CA77).rotate_left(13)
        ^ seed.wrapping_mul(0xC2B2_AE3D);
    for _ in 0..2 {
        h ^= h >> 15;
        h = h.wrapping_mul(0x2C1B_3C6D);
        h ^= h >> 12;
        h = h.wrapping_mul(0x297A_2D39);
    }
    f64::from(h ^ (h >> 15)) / f64::from(u32::MAX)
}

/// Value noise in −1…1 with features about 1 apart.
pub(crate) fn noise(x: f64, y: f64, seed: u32) -> f64 {
    let (fx, fy) = (x.floor(), y.floor());
    let (i, j) = (fx as i64, fy as i64);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let (u, v) = (fade(x - fx), fade(y - fy));
    let top = hash(i, j, seed) * (1.0 - u) + hash(i + 1, j, seed) * u;
    let low = hash(i, j + 1, seed) * (1.0 - u) + hash(i + 1, j + 1, seed) * u;
    2.0 * (top * (1.0 - v) + low * v) - 1.0
}

/// Two octaves of [`noise`], in −1…1.
pub(crate) fn clouds(x: f64, y: f64, seed: u32) -> f64 {
    (noise(x, y, seed) + 0.5 * noise(2.03 * x + 7.1, 2.03 * y, seed + 1)) / 1.5
}

pub(crate) fn rgb(hex: u32) -> V3 {
    let part = |shift: u32| f64::from((hex >> shift) & 255) / 255.0;
    v3(part(16), part(8), part(0))
}
