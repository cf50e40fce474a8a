//! The town: where everything stands. Metres; x east, y north, z up, from the middle of the square.

use super::backdrop;
use super::build::{Builder, Site};
use super::church;
use super::facade::{Opening, Row, Style};
use super::ground::FOUNTAIN;
use super::house::{House, Shape};
use super::ink::{hash, rgb};
use super::light::LightMap;
use super::paint::Paint;
use super::polygon::{Frame, Polygon};
use super::vector::v3;

/// Map coordinates of the local origin.
pub(crate) const MAP: [f64; 3] = [389_400.0, 5_819_700.0, 34.0];

const SHUTTER_GREEN: u32 = 0x4F6B57;
const SHUTTER_BLUE: u32 = 0x5B7488;
const SHUTTER_RED: u32 = 0x8B4A3D;
const OAK: u32 = 0x6B4A33;

fn row(sill: f64, count: i32, pitch: f64, opening: Opening) -> Row {
    Row { sill, width: 0.95, height: 1.5, count, pitch, opening }
}

fn sized(sill: f64, size: (f64, f64), count: i32, pitch: f64, opening: Opening) -> Row {
    Row { sill, width: size.0, height: size.1, count, pitch, opening }
}

fn shutters(hex: u32) -> Opening {
    Opening::Shuttered(rgb(hex))
}

fn shop(hex: u32) -> Row {
    sized(0.6, (3.0, 1.9), 1, 4.0, Opening::Shop(rgb(hex)))
}

fn door(hex: u32) -> Row {
    sized(0.0, (1.35, 2.7), 1, 4.0, Opening::Door(rgb(hex)))
}

/// Two things side by side on the ground floor.
fn pair(mut a: Row, gap: f64) -> Row {
    a.count = 2;
    a.pitch = gap;
    a
}

#[derive(Clone, Copy)]
struct Body {
    site: (f64, f64, f64),
    size: (f64, f64),
    height: (f64, f64),
    shape: Shape,
    style: Style,
    /// Wall, trim, roof.
    colors: [u32; 3],
    dormers: usize,
}

fn house(name: &'static str, body: Body, rows: Vec<Row>, bands: &[f64], seed: u32) -> House {
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

const RED: u32 = 0xB5603F;
const RUST: u32 = 0xA65A3E;
const BROWN: u32 = 0x94583F;
const SLATE: u32 = 0x6E7580;

fn north_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Stepped};
    use Style::{Brick, Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 0.0),
        size: (width, 11.5),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "north 1",
            body(-25.5, 24.3, 7.5, (8.4, 13.2), Gable, Plaster, [0xD9A75B, 0xEADFC6, RED], 0),
            vec![
                door(OAK),
                row(3.8, 3, 2.2, shutters(SHUTTER_GREEN)),
                row(6.4, 3, 2.2, shutters(SHUTTER_GREEN)),
                row(9.4, 1, 2.0, Opening::Window),
            ],
            &[3.2, 8.6],
            101,
        ),
        house(
            "north 2",
            body(-18.0, 24.8, 6.6, (7.2, 11.4), Eaves, Timber { from: 3.1 }, [0xE6D9BC, 0xCDBFA2, BROWN], 2),
            vec![shop(0x5C6B52), row(4.2, 3, 1.75, Opening::Window)],
            &[],
            102,
        ),
        house(
            "town hall",
            body(-4.5, 22.9, 15.5, (10.6, 18.6), Stepped(5), Brick, [0xB06A50, 0xDCCBA6, SLATE], 0),
            vec![
                sized(0.0, (2.1, 3.7), 5, 2.9, Opening::Arcade),
                sized(5.2, (1.15, 2.7), 5, 2.9, Opening::Arched),
                sized(9.3, (1.1, 2.0), 5, 2.15, Opening::Arched),
                sized(13.0, (2.6, 2.6), 1, 3.0, Opening::Clock),
                sized(12.9, (0.9, 1.7), 2, 5.2, Opening::Arched),
                sized(16.6, (0.9, 1.6), 1, 3.0, Opening::Arched),
            ],
            &[4.6, 8.6, 12.2],
            103,
        ),
        house(
            "north 4",
            body(11.0, 24.5, 7.0, (7.9, 13.4), Gable, Timber { from: 3.0 }, [0xEBDDBF, 0xC9B894, RED], 0),
            vec![
                shop(0x7A4A3C),
                row(4.1, 3, 1.9, Opening::Window),
                row(6.8, 3, 1.9, Opening::Window),
                row(9.5, 1, 1.8, Opening::Window),
            ],
            &[],
            104,
        ),
        house(
            "north 5",
            body(18.0, 24.0, 7.6, (8.6, 12.6), Eaves, Plaster, [0xB9C4BD, 0xECE6D6, RUST], 2),
            vec![
                pair(sized(0.8, (1.5, 1.8), 2, 3.6, Opening::Shop(rgb(0x3F5B66))), 3.8),
                row(3.9, 3, 2.3, Opening::Window),
                row(6.4, 3, 2.3, Opening::Window),
            ],
            &[3.3],
            105,
        ),
    ]
}

fn east_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Hip, Stepped};
    use Style::{Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 270.0),
        size: (width, 11.0),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "east 1",
            body(27.6, 19.5, 7.5, (8.2, 13.8), Stepped(4), Plaster, [0xE3C9A1, 0xF0E6D0, RED], 0),
            vec![
                shop(0x4A5E4A),
                row(3.9, 3, 2.1, Opening::Window),
                row(6.5, 3, 2.1, Opening::Window),
                row(9.6, 2, 1.9, Opening::Window),
            ],
            &[3.3, 8.9],
            111,
        ),
        house(
            "east 2",
            body(27.2, 12.0, 8.0, (7.6, 11.8), Eaves, Plaster, [0xC98F78, 0xEBDCC4, BROWN], 3),
            vec![
                door(0x3F5546),
                row(3.8, 4, 1.95, shutters(SHUTTER_BLUE)),
                row(5.9, 4, 1.95, shutters(SHUTTER_BLUE)),
            ],
            &[3.2],
            112,
        ),
        house(
            "east 3",
            body(27.9, 4.0, 7.4, (8.3, 14.0), Gable, Timber { from: 3.1 }, [0xE8D8B4, 0xC8B48E, RUST], 0),
            vec![
                pair(sized(0.6, (1.9, 1.9), 2, 3.2, Opening::Shop(rgb(0x75523A))), 3.3),
                row(4.2, 3, 2.1, Opening::Window),
                row(6.9, 3, 2.1, Opening::Window),
                row(9.9, 1, 1.8, Opening::Window),
            ],
            &[],
            113,
        ),
        house(
            "east 4",
            body(27.4, -3.4, 8.2, (9.0, 12.8), Hip, Plaster, [0xD8CDB4, 0xF2EADA, RED], 0),
            vec![
                shop(0x8B3F37),
                row(3.9, 4, 1.95, shutters(SHUTTER_RED)),
                row(6.6, 4, 1.95, shutters(SHUTTER_RED)),
            ],
            &[3.3, 6.1],
            114,
        ),
        house(
            "east 5",
            body(27.5, -18.0, 8.0, (7.4, 12.2), Gable, Plaster, [0xA9B79B, 0xE9E2CC, BROWN], 0),
            vec![
                door(0x6B3A30),
                row(3.7, 3, 2.2, Opening::Window),
                row(5.9, 3, 2.2, Opening::Window),
                row(8.6, 1, 2.0, Opening::Window),
            ],
            &[3.1],
            115,
        ),
    ]
}

fn west_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Stepped};
    use Style::{Brick, Plaster, Timber};
    let body = |x: f64, y: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, y, 90.0),
        size: (width, 11.0),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    vec![
        house(
            "west 1",
            body(-27.4, -26.0, 8.4, (7.6, 11.6), Eaves, Plaster, [0xE2D3AE, 0xF0E8D4, RUST], 2),
            vec![shop(0x4E5F6B), row(3.7, 4, 1.95, shutters(SHUTTER_GREEN)), row(5.8, 4, 1.95, Opening::Window)],
            &[3.2],
            121,
        ),
        house(
            "west 2",
            body(-27.8, -17.6, 7.6, (8.5, 13.6), Gable, Plaster, [0xB8695A, 0xEAD9BE, RED], 0),
            vec![door(OAK), row(3.9, 3, 2.2, Opening::Window), row(6.6, 3, 2.2, Opening::Window), row(9.6, 1, 2.0, Opening::Window)],
            &[3.3, 8.7],
            122,
        ),
        house(
            "west 3",
            body(-27.3, -10.0, 8.6, (7.3, 12.0), Eaves, Timber { from: 3.0 }, [0xE9DEC2, 0xCDBB96, BROWN], 2),
            vec![pair(sized(0.6, (2.1, 1.9), 2, 3.8, Opening::Shop(rgb(0x5A6A4A))), 3.9), row(4.1, 4, 2.0, Opening::Window)],
            &[],
            123,
        ),
        house(
            "west 4",
            body(-27.6, 6.4, 7.2, (8.2, 13.6), Stepped(4), Brick, [0xA4604A, 0xD8C8A6, RUST], 0),
            vec![shop(0x3F4F5C), row(3.9, 3, 2.0, Opening::Window), row(6.5, 3, 2.0, Opening::Window), row(9.5, 1, 2.0, Opening::Window)],
            &[3.3, 8.8],
            124,
        ),
        house(
            "west 5",
            body(-27.2, 13.6, 7.4, (7.5, 12.4), Gable, Plaster, [0xCFC6B6, 0xEDE6D8, RED], 0),
            vec![door(0x40566A), row(3.7, 3, 2.1, shutters(SHUTTER_BLUE)), row(6.0, 3, 2.1, shutters(SHUTTER_BLUE)), row(8.9, 1, 2.0, Opening::Window)],
            &[3.2],
            125,
        ),
    ]
}

fn south_row() -> Vec<House> {
    use Shape::{Eaves, Gable, Hip};
    use Style::{Plaster, Timber};
    let body = |x: f64, width: f64, height, shape, style, colors, dormers| Body {
        site: (x, -26.6, 180.0),
        size: (width, 10.5),
        height,
        shape,
        style,
        colors,
        dormers,
    };
    let plain = |n: i32, pitch: f64| {
        vec![door(OAK), row(3.7, n, pitch, Opening::Window), row(5.9, n, pitch, shutters(SHUTTER_GREEN))]
    };
    vec![
        house(
            "south 1",
            body(26.8, 8.4, (7.6, 11.8), Eaves, Plaster, [0xD6B98C, 0xEFE5CF, RED], 2),
            plain(3, 2.3),
            &[3.2],
            131,
        ),
        house(
            "south 2",
            body(18.4, 7.8, (7.2, 12.2), Gable, Timber { from: 3.0 }, [0xE8DBBD, 0xCBB995, BROWN], 0),
            vec![shop(0x5B4A3A), row(4.1, 3, 2.0, Opening::Window)],
            &[],
            132,
        ),
        house(
            "south 3",
            body(-4.4, 7.6, (7.4, 11.4), Hip, Plaster, [0xC7CBB8, 0xEFE9D8, RUST], 0),
            plain(3, 2.2),
            &[3.2],
            133,
        ),
        house(
            "south 4",
            body(-12.0, 8.0, (7.9, 12.8), Gable, Plaster, [0xD9A98A, 0xF0E2CC, RED], 0),
            plain(3, 2.3),
            &[3.2],
            134,
        ),
    ]
}

/// Small houses behind the rows: footprint corner, direction, size, heights, colours.
fn outskirts() -> Vec<House> {
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
        (31.0, 47.0, 20.0),
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
    const ROOFS: [u32; 4] = [RED, RUST, BROWN, 0xAD6647];
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
                style: if luck(6) < 0.3 { Style::Timber { from: 2.7 } } else { Style::Plaster },
                colors: [WALLS[i % 6], 0xE6DCC6, ROOFS[(i + i / 4) % 4]],
                dormers: 0,
            };
            let rows = vec![door(OAK), row(3.2, 3, 2.4, Opening::Window)];
            house(name, body, rows, &[], 140 + i as u32)
        })
        .collect()
}

fn fountain(b: &mut Builder) {
    let site = Site::new(FOUNTAIN.0, FOUNTAIN.1, 0.0);
    let stone = |_: usize, _: usize| Paint::Plain(rgb(0xC9BDA5));
    let step = |_: usize, _: usize| Paint::Plain(rgb(0xB5AA95));
    b.turned("fountain step", site, 8, &[(5.0, 0.0), (5.0, 0.2), (4.1, 0.2)], step);
    let basin = [(4.1, 0.2), (4.2, 1.0), (3.75, 1.0), (3.75, 0.7)];
    b.turned("fountain basin", site, 8, &basin, stone);
    b.disc("fountain water", site, 8, 3.75, 0.7, Paint::Water);
    let column = [(0.75, 0.7), (0.55, 1.3), (0.45, 2.2), (1.5, 2.75), (1.5, 2.9), (1.3, 2.9)];
    b.turned("fountain column", site, 8, &column, stone);
    b.disc("fountain bowl", site, 8, 1.3, 2.88, Paint::Water);
    let finial = [(0.35, 2.88), (0.25, 3.7), (0.5, 4.0), (0.42, 4.3), (0.0, 5.2)];
    b.turned("fountain finial", site, 8, &finial, stone);
}

fn market(b: &mut Builder) {
    const CLOTHS: [(u32, u32); 4] = [
        (0xC65B45, 0xEFE6D3),
        (0x5B7F8F, 0xEFE6D3),
        (0xD9A441, 0xF0E8D6),
        (0x6F8F56, 0xEFE6D3),
    ];
    const STALLS: [(f64, f64, f64); 5] = [
        (13.5, 12.5, 8.0),
        (18.8, 8.0, 82.0),
        (12.8, 5.0, 4.0),
        (18.9, 1.0, 95.0),
        (7.0, 12.0, -6.0),
    ];
    for (i, &(x, y, turn)) in STALLS.iter().enumerate() {
        let site = Site::new(x, y, turn);
        let (name, cloth) = (format!("stall {i}"), CLOTHS[i % 4]);
        let goods = Paint::Goods(300 + i as u32);
        let wood = Paint::Plain(rgb(0x8A6A48));
        b.block(&format!("{name} table"), site, (-1.6, 1.6), (-0.75, 0.75), (0.0, 0.95), &wood, &goods);
        let awning = |flip: f64| {
            vec![
                site.at(-1.9 * flip, -1.25 * flip, 2.25),
                site.at(1.9 * flip, -1.25 * flip, 2.25),
                site.at(1.9 * flip, 0.0, 3.0),
                site.at(-1.9 * flip, 0.0, 3.0),
            ]
        };
        let stripes = Paint::Stripes { colors: [rgb(cloth.0), rgb(cloth.1)], period: 0.95 };
        b.face(&format!("{name} awning front"), awning(1.0), stripes.clone());
        b.face(&format!("{name} awning back"), awning(-1.0), stripes);
    }
    const PARASOLS: [(f64, f64, u32); 6] = [
        (-17.5, -16.5, 0xE8DCC2),
        (-14.0, -14.0, 0xC4644C),
        (-18.0, -12.0, 0xE8DCC2),
        (-14.5, -18.6, 0xC4644C),
        (14.8, -17.5, 0xE3CF9E),
        (18.6, -15.2, 0xE3CF9E),
    ];
    for (i, &(x, y, color)) in PARASOLS.iter().enumerate() {
        let site = Site::new(x, y, 11.0 * i as f64);
        let cloth = Paint::Plain(rgb(color));
        b.turned(&format!("parasol {i}"), site, 8, &[(1.65, 2.2), (0.0, 2.95)], |_, _| cloth.clone());
        let table = Paint::Plain(rgb(0xD6CBB5));
        b.disc(&format!("parasol table {i}"), site, 8, 0.55, 0.75, table);
    }
    const COATS: [u32; 6] = [0xA8433A, 0x3F5E7D, 0xD7B24C, 0xE0DACB, 0x4E6B4A, 0x7A5273];
    const LEGS: [u32; 3] = [0x34383F, 0x5A4D42, 0x2F3B4C];
    const PEOPLE: [(f64, f64); 20] = [
        (9.9, 10.6),
        (11.4, 9.8),
        (16.3, 6.2),
        (16.9, 9.7),
        (10.3, 2.6),
        (16.4, 2.6),
        (-2.0, -8.0),
        (-2.8, -7.4),
        (0.4, 3.6),
        (9.6, -7.5),
        (3.2, -16.0),
        (4.1, -16.4),
        (-8.0, 6.0),
        (-6.2, 14.8),
        (2.4, 18.6),
        (-12.0, -3.0),
        (-11.4, -2.4),
        (14.6, -8.6),
        (1.6, -29.0),
        (20.6, -11.0),
    ];
    for (i, &(x, y)) in PEOPLE.iter().enumerate() {
        b.figure(&format!("figure {i}"), x, y, COATS[(i * 5 + i / 6) % 6], LEGS[i % 3]);
    }
}

fn trees(b: &mut Builder) {
    const LIMES: [(f64, f64, f64); 24] = [
        (-19.0, -3.5, 6.2),
        (-19.4, 2.6, 6.6),
        (-19.0, 9.0, 6.0),
        (-18.8, 15.4, 6.4),
        (43.0, -18.0, 8.0),
        (50.0, -12.0, 7.4),
        (41.5, 9.5, 6.5),
        (52.0, 17.0, 8.5),
        (46.0, 34.0, 8.0),
        (22.0, 41.0, 6.8),
        (8.5, 56.0, 8.4),
        (10.0, 76.0, 9.0),
        (24.0, 88.0, 8.2),
        (-30.0, 60.0, 8.6),
        (-28.0, 46.0, 7.0),
        (-38.0, 76.0, 9.0),
        (-52.0, 28.0, 8.0),
        (-56.0, 4.0, 7.4),
        (-48.0, -24.0, 8.2),
        (-20.0, -44.0, 7.0),
        (17.0, -46.0, 7.4),
        (30.0, -44.0, 6.6),
        (44.0, 82.0, 9.2),
        (-66.0, 70.0, 9.0),
    ];
    for (i, &(x, y, height)) in LIMES.iter().enumerate() {
        b.round_tree(&format!("lime {i}"), x, y, height, 400 + 7 * i as u32);
    }
    for i in 0..16_u32 {
        let x = -120.0 + 16.5 * f64::from(i) + 5.0 * hash(i64::from(i), 0, 500);
        let y = 106.0 + 11.0 * (x / 62.0).sin() + 5.0 * (x / 27.0 + 1.0).sin();
        if (x - 62.0).abs() > 6.0 {
            let height = 11.0 + 4.0 * hash(i64::from(i), 1, 500);
            b.poplar(&format!("poplar {i}"), x, y, height, 510 + i);
        }
    }
    for (i, &(x, y)) in [(-23.5, 40.0), (7.0, 44.0), (-24.0, 82.0), (6.0, 84.0)].iter().enumerate() {
        b.poplar(&format!("cypress {i}"), x, y, 8.5 + i as f64 * 0.6, 540 + i as u32);
    }
}

pub(crate) fn build() -> (Vec<Polygon>, Vec<LightMap>) {
    let mut b = Builder::default();
    super::tiles::ground(&mut b);
    for h in [north_row(), east_row(), west_row(), south_row(), outskirts()].concat() {
        h.build(&mut b);
    }
    church::build(&mut b);
    fountain(&mut b);
    market(&mut b);
    trees(&mut b);
    let wall = |x: f64, z: f64| v3(x, backdrop::NORTH, z);
    let (side, top) = (backdrop::SIDE, backdrop::TOP);
    let sky = vec![wall(-side, -10.0), wall(side, -10.0), wall(side, top), wall(-side, top)];
    let frame = Frame::of(&sky);
    b.polygons.push(Polygon::new("sky".to_owned(), sky, frame, Paint::Backdrop, 0));
    (b.polygons, b.lights)
}
