//! The town: where everything stands. Metres; x east, y north, z up, from the middle of the square.

use super::backdrop;
use super::build::{Builder, Site};
use super::church;
use super::ground::FOUNTAIN;
use super::houses::outskirts;
use super::ink::{hash, rgb};
use super::light::LightMap;
use super::paint::Paint;
use super::polygon::{Frame, Polygon};
use super::rows::{east_row, north_row, south_row, west_row};
use super::vector::v3;

/// Map coordinates of the local origin.
pub(crate) const MAP: [f64; 3] = [389_400.0, 5_819_700.0, 34.0];

fn fountain(b: &mut Builder) {
    let site = Site::new(FOUNTAIN.0, FOUNTAIN.1, 0.0);
    let stone = |_: usize, _: usize| Paint::Plain(rgb(0xC9BDA5));
    let step = |_: usize, _: usize| Paint::Plain(rgb(0xB5AA95));
    b.turned("fountain step", site, 8, &[(5.0, 0.0), (5.0, 0.2), (4.1, 0.2)], step);
    let basin = [(4.1, 0.2), (4.2, 1.0), (3.75, 1.0), (3.75, 0.7)];
    b.turned("fountain basin", site, 8, &basin, stone);
    b.turned("fountain water", site, 8, &[(3.75, 0.7), (0.0, 0.7)], |_, _| Paint::Water);
    let column = [(0.75, 0.7), (0.55, 1.3), (0.45, 2.2), (1.5, 2.75), (1.5, 2.9), (1.3, 2.9)];
    b.turned("fountain column", site, 8, &column, stone);
    b.disc("fountain bowl", site, 8, 1.3, 2.88, Paint::Water);
    let finial = [(0.35, 2.88), (0.25, 3.7), (0.5, 4.0), (0.42, 4.3), (0.0, 5.2)];
    b.turned("fountain finial", site, 8, &finial, stone);
}

fn market(b: &mut Builder) {
    const CLOTHS: [(u32, u32); 4] =
        [(0xC65B45, 0xEFE6D3), (0x5B7F8F, 0xEFE6D3), (0xD9A441, 0xF0E8D6), (0x6F8F56, 0xEFE6D3)];
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
        let table = [(-1.6, 1.6), (-0.75, 0.75), (0.0, 0.95)];
        b.block(&format!("{name} table"), site, table, (&wood, &goods));
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
        b.turned(&format!("parasol {i}"), site, 8, &[(1.65, 2.2), (0.0, 2.95)], |_, _| {
            cloth.clone()
        });
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
        let x = -98.0 + 15.0 * f64::from(i) + 5.0 * hash(i64::from(i), 0, 500);
        let y = 106.0 + 11.0 * (x / 62.0).sin() + 5.0 * (x / 27.0 + 1.0).sin();
        if (x - 62.0).abs() > 6.0 {
            let height = 11.0 + 4.0 * hash(i64::from(i), 1, 500);
            b.poplar(&format!("poplar {i}"), x, y, height, 510 + i);
        }
    }
    for (i, &(x, y)) in [(-23.5, 40.0), (7.0, 44.0), (-24.0, 82.0), (6.0, 84.0)].iter().enumerate()
    {
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
    b.polygons.push(Polygon::new("sky".to_owned(), sky, frame, Paint::Backdrop, usize::MAX));
    (b.polygons, b.lights)
}
