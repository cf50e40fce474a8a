//! How the town's houses are described, and the small ones along its lanes.

use super::build::Site;
use super::facade::{Opening, Row, Style};
use super::house::{House, Shape};
use super::ink::{hash, rgb};

pub(super) const SHUTTER_GREEN: u32 = 0x4F6B57;
pub(super) const SHUTTER_BLUE: u32 = 0x5B7488;
pub(super) const SHUTTER_RED: u32 = 0xA0604F;
pub(super) const OAK: u32 = 0x6B4A33;

pub(super) fn row(sill: f64, count: i32, pitch: f64, opening: Opening) -> Row {
    Row { sill, width: 0.95, height: 1.5, count, pitch, opening }
}

pub(super) fn sized(sill: f64, size: (f64, f64), count: i32, pitch: f64, opening: Opening) -> Row {
    Row { sill, width: size.0, height: size.1, count, pitch, opening }
}

pub(super) fn shutters(hex: u32) -> Opening {
    Opening::Shuttered(rgb(hex))
}

pub(super) fn shop(hex: u32) -> Row {
    sized(0.6, (3.0, 1.9), 1, 4.0, Opening::Shop(rgb(hex)))
}

pub(super) fn door(hex: u32) -> Row {
    sized(0.0, (1.35, 2.7), 1, 4.0, Opening::Door(rgb(hex)))
}

/// Two things side by side on the ground floor.
pub(super) fn pair(mut a: Row, gap: f64) -> Row {
    a.count = 2;
    a.pitch = gap;
    a
}

#[derive(Clone, Copy)]
pub(super) struct Body {
    pub(super) site: (f64, f64, f64),
    pub(super) size: (f64, f64),
    pub(super) height: (f64, f64),
    pub(super) shape: Shape,
    pub(super) style: Style,
    /// Wall, trim, roof.
    pub(super) colors: [u32; 3],
    pub(super) dormers: usize,
}

pub(super) fn house(
    name: &'static str,
    body: Body,
    rows: Vec<Row>,
    bands: &[f64],
    seed: u32,
) -> House {
    House {
        name,
        site: Site::new(body.site.0, body.site.1, body.site.2),
        width: body.size.0,
        depth: body.size.1,
        eave: body.height.0,
        ridge: body.height.1,
        shape: body.shape,
        style: body.style,
        color: body.colors[0],
        trim: body.colors[1],
        roof: body.colors[2],
        rows,
        bands: bands.to_vec(),
        dormers: body.dormers,
        seed,
    }
}

pub(super) const RED: u32 = 0xA96A50;
pub(super) const RUST: u32 = 0x9E6049;
pub(super) const BROWN: u32 = 0x8D604C;
pub(super) const SLATE: u32 = 0x6E7580;

/// Small houses behind the rows: footprint corner, direction, size, heights, colours.
pub(super) fn outskirts() -> Vec<House> {
    const NAMES: [&str; 16] = [
        "lane 1", "lane 2", "lane 3", "lane 4", "lane 5", "lane 6", "lane 7", "lane 8", "lane 9",
        "lane 10", "lane 11", "lane 12", "lane 13", "lane 14", "lane 15", "lane 16",
    ];
    const SITES: [(f64, f64, f64); 16] = [
        (44.0, -30.0, 275.0),
        (44.5, -2.0, 268.0),
        (43.0, 18.0, 300.0),
        (-44.0, -14.0, 85.0),
        (-46.0, 14.0, 92.0),
        (-43.0, -34.0, 80.0),
        (16.0, 50.0, 355.0),
        (58.0, 68.0, 20.0),
        (40.0, 58.0, 15.0),
        (14.0, 66.0, 340.0),
        (30.0, 74.0, 8.0),
        (-38.0, 46.0, 350.0),
        (-56.0, 44.0, 30.0),
        (-46.0, 66.0, 5.0),
        (-34.0, 86.0, 345.0),
        (63.0, 6.0, 280.0),
    ];
    const WALLS: [u32; 6] = [0xE4D6B8, 0xD8BE93, 0xC9CBBB, 0xDDB395, 0xE9E1CE, 0xCFAF87];
    const ROOFS: [u32; 4] = [RED, RUST, BROWN, 0xB07A5C];
    SITES
        .iter()
        .zip(NAMES)
        .enumerate()
        .map(|(i, (&site, name))| {
            let luck = |k: u32| hash(i as i64, 7, 200 + k);
            let body = Body {
                site,
                size: (8.5 + 3.0 * luck(1), 7.0 + 1.5 * luck(2)),
                height: (4.6 + 1.8 * luck(3), 9.2 + 1.8 * luck(4)),
                shape: if luck(5) < 0.25 { Shape::Hip } else { Shape::Eaves },
                style: if luck(6) < 0.16 { Style::Timber { from: 2.7 } } else { Style::Plaster },
                colors: [WALLS[i % 6], 0xE6DCC6, ROOFS[(i + i / 4) % 4]],
                dormers: 0,
            };
            let rows = vec![door(OAK), row(3.2, 3, 2.4, Opening::Window)];
            house(name, body, rows, &[], 140 + i as u32)
        })
        .collect()
}
