//! What a surface looks like before light falls on it: a colour for each point of its plane.

use super::facade::Wall;
use super::ink::{clouds, comb, hash, ink, noise, ramp, rgb};
use super::vector::{V3, v3};
use super::{backdrop, ground};

#[derive(Clone, Debug)]
pub(crate) enum Paint {
    Wall(Box<Wall>),
    /// Courses of tiles; s along the eaves, t up the slope, `ridge` the slope's length.
    Roof {
        color: V3,
        course: f64,
        ridge: f64,
        seed: u32,
    },
    Ground,
    /// Sky and hills: it needs no light.
    Backdrop,
    /// Foliage round a centre, lit as if the crown were round.
    Leaves {
        center: V3,
        color: V3,
        seed: u32,
    },
    Water,
    Plain(V3),
    /// Stripes across s.
    Stripes {
        colors: [V3; 2],
        period: f64,
    },
    /// Coloured heaps on a market table.
    Goods(u32),
    /// Clothes: legs, coat, head, by height.
    Figure {
        coat: V3,
        legs: V3,
    },
}

impl Paint {
    pub(crate) fn roof(hex: u32, course: f64, ridge: f64, seed: u32) -> Self {
        Self::Roof { color: rgb(hex), course, ridge, seed }
    }

    /// Colour at plane coordinates (s, t), which are the world point `p`.
    pub(crate) fn albedo(&self, s: f64, t: f64, p: V3) -> V3 {
        match self {
            Self::Wall(wall) => wall.albedo(s, t),
            Self::Roof { color, course, ridge, seed } => {
                tiles(*color, *course, *ridge, *seed, s, t)
            }
            Self::Ground => ground::albedo(p.x, p.y),
            Self::Backdrop => backdrop::color(p.x, p.z),
            Self::Leaves { center, color, seed } => {
                let d = p - *center;
                let around = d.y.atan2(d.x) * 2.2;
                let clump = noise(around * 1.6 + d.z, d.z * 1.5 - around, *seed)
                    + 0.6 * noise(d.x * 1.9 + d.z, d.y * 1.9 - d.z, seed + 1);
                let warm = color.mix(v3(0.62, 0.64, 0.25), 0.28);
                color.mix(warm, ramp(-0.9, 1.3, clump)) * (0.97 + 0.1 * clump)
            }
            Self::Water => rgb(0x5E93A4) * (1.0 + 0.07 * noise(s * 1.4, t * 1.4, 91)),
            Self::Plain(color) => *color,
            Self::Stripes { colors, period } => {
                let d = comb(s - 0.25 * period, *period) - 0.25 * period;
                colors[0].mix(colors[1], ink(d))
            }
            Self::Goods(seed) => {
                const HEAPS: [u32; 5] = [0xC8553D, 0xE0A93B, 0x6E9A45, 0xD98E4A, 0x9C4A6B];
                let i = (s / 0.8).round();
                let pick = (hash(i as i64, 0, *seed) * 4.999) as usize;
                let heap = ink((s - 0.8 * i).abs() - 0.3) * ink((t - 0.75).abs() - 0.48);
                rgb(0x8A6A48).mix(rgb(HEAPS[pick]), heap)
            }
            Self::Figure { coat, legs } => {
                let head = v3(0.78, 0.6, 0.47);
                legs.mix(*coat, ramp(0.72, 0.92, p.z)).mix(head, ramp(1.38, 1.52, p.z))
            }
        }
    }
}

fn tiles(color: V3, course: f64, ridge: f64, seed: u32, s: f64, t: f64) -> V3 {
    let weather = clouds(s * 0.35, t * 0.22, seed);
    let row = (t / course).floor();
    let within = t / course - row;
    // A course darkens towards its lower edge, over a third of its height.
    let lap = 1.0 - 0.072 * (ramp(0.38, 0.0, within) + ramp(0.8, 1.0, within));
    let patch = noise(s * 0.9, row * 0.77, seed + 5);
    let aged = color * (lap * (1.0 + 0.05 * weather + 0.02 * patch));
    let moss = ramp(0.25, 0.75, clouds(s * 0.22 + 9.0, t * 0.3, seed + 11)) * ramp(4.0, 0.0, t);
    let mossy = aged.mix(v3(0.44, 0.44, 0.33), 0.3 * moss);
    mossy.mix(color * 0.8, 0.8 * ink((t - ridge).abs() - 0.16))
}
