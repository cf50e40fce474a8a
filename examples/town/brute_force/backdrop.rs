//! Sky and hills on a wall far behind the town.

use super::ink::{clouds, noise, ramp, rgb, smooth};
use super::vector::V3;

/// Northing of the wall, and how far it reaches to the sides, below and above.
pub(crate) const NORTH: f64 = 900.0;
pub(crate) const SIDE: f64 = 1100.0;
pub(crate) const TOP: f64 = 420.0;

/// Colour, light included, at easting x and height z.
pub(crate) fn color(x: f64, z: f64) -> V3 {
    let mut c = sky(x, z);
    let hills = [
        (34.0, 16.0, 210.0, 0xA9B9C2, 3_u32),
        (21.0, 11.0, 140.0, 0x94AAA9, 5),
        (10.0, 7.0, 90.0, 0x829B85, 8),
    ];
    for (base, swing, period, hex, seed) in hills {
        let crest = base
            + swing * noise(x / period, 0.5, seed)
            + 0.35 * swing * noise(x / (0.37 * period), 1.5, seed + 20)
            + 0.08 * swing * noise(x / 17.0, 2.5, seed + 40);
        let lit = rgb(hex) * (1.0 + 0.05 * noise(x / 60.0, z / 16.0, seed + 60));
        let misty = lit.mix(rgb(0xC6CDC8), 0.35 * ramp(crest, -5.0, z));
        c = c.mix(misty, smooth((crest - z) / 2.2));
    }
    c
}

fn sky(x: f64, z: f64) -> V3 {
    let low = rgb(0xEFE3CB).mix(rgb(0xBFD3DF), ramp(0.0, 130.0, z));
    let c = low.mix(rgb(0x7FA9CF), ramp(70.0, 380.0, z));
    // Flat-bottomed banks that thin out upwards.
    let billow = clouds(x / 120.0 + 0.6, z / 42.0, 101) + 0.25 * clouds(x / 33.0, z / 13.0, 105);
    let bank = ramp(0.08, 0.62, billow) * ramp(30.0, 75.0, z) * ramp(400.0, 150.0, z);
    let shine =
        rgb(0xF4E9D6).mix(rgb(0xDDDFE2), ramp(0.2, 0.9, clouds(x / 90.0, z / 30.0 + 0.4, 109)));
    c.mix(shine, 0.85 * bank)
}
