//! The church: tower with a broached spire, nave, choir.

use super::build::{Builder, Site};
use super::facade::{Opening, Row, Style, Wall};
use super::ink::rgb;
use super::paint::Paint;

const STONE: u32 = 0xCBBB9C;
const TRIM: u32 = 0xE6DBC2;
const COPPER: u32 = 0x7FA894;
const TILES: u32 = 0x9A5F47;

fn wall(width: f64, eave: f64, rows: Vec<Row>, bands: &[f64], seed: u32) -> Paint {
    Paint::Wall(Box::new(Wall {
        width,
        eave,
        peak: eave,
        style: Style::Stone,
        color: rgb(STONE),
        trim: rgb(TRIM),
        plinth: 0.0,
        bands: bands.to_vec(),
        rows,
        seed,
    }))
}

fn row(sill: f64, width: f64, height: f64, count: i32, pitch: f64, opening: Opening) -> Row {
    Row { sill, width, height, count, pitch, opening }
}

pub(crate) fn build(b: &mut Builder) {
    tower(b);
    nave(b);
}

fn tower(b: &mut Builder) {
    const SIZE: f64 = 7.6;
    const TOP: f64 = 25.0;
    let site = Site::new(-12.8, 42.0, 0.0);
    let corners = [(0.0, 0.0), (SIZE, 0.0), (SIZE, SIZE), (0.0, SIZE)];
    for i in 0..4 {
        let mut rows = vec![
            row(18.6, 1.3, 3.6, 2, 2.7, Opening::Louvre),
            row(13.4, 3.0, 3.0, 1, 3.0, Opening::Clock),
            row(7.6, 0.9, 3.0, 1, 3.0, Opening::Arched),
        ];
        if i == 0 {
            rows.push(row(0.0, 2.2, 3.9, 1, 3.0, Opening::Door(rgb(0x5E4331))));
        }
        let (p, q) = (corners[i], corners[(i + 1) % 4]);
        let face = vec![
            site.at(p.0, p.1, 0.0),
            site.at(q.0, q.1, 0.0),
            site.at(q.0, q.1, TOP),
            site.at(p.0, p.1, TOP),
        ];
        let name = format!("tower {}", ["south", "east", "north", "west"][i]);
        b.face(&name, face, wall(SIZE, TOP, rows, &[5.6, 12.2, 17.6, 24.6], 160 + i as u32));
    }
    // A low skirt turns the square into the octagon of the spire.
    let middle = Site::new(-12.8 + 0.5 * SIZE, 42.0 + 0.5 * SIZE, 0.0);
    let half = 0.5 * SIZE + 0.3;
    let (skirt, neck) = (27.6, 1.0 / (std::f64::consts::PI / 8.0).cos());
    let apothem = 2.55;
    let spire = Paint::roof(COPPER, 0.9, 99.0, 170);
    b.turned("spire", middle, 8, &[(apothem * neck, skirt), (0.0, 42.5)], |_, _| spire.clone());
    let corner = |k: usize| {
        let angle = std::f64::consts::FRAC_PI_4 * (2.0 * k as f64 + 1.0);
        (half * angle.cos().signum(), half * angle.sin().signum())
    };
    let eighth = |k: usize| {
        let angle = std::f64::consts::FRAC_PI_4 * (k as f64 + 0.5);
        (apothem * neck * angle.cos(), apothem * neck * angle.sin())
    };
    let low = TOP - 0.15;
    for k in 0..4 {
        let (c, d) = (corner((k + 3) % 4), corner(k));
        let (e, f) = (eighth((2 * k + 7) % 8), eighth(2 * k));
        let side = vec![
            middle.at(c.0, c.1, low),
            middle.at(d.0, d.1, low),
            middle.at(f.0, f.1, skirt),
            middle.at(e.0, e.1, skirt),
        ];
        b.face(&format!("spire skirt {k}"), side, spire.clone());
        let g = eighth(2 * k + 1);
        let broach =
            vec![middle.at(d.0, d.1, low), middle.at(g.0, g.1, skirt), middle.at(f.0, f.1, skirt)];
        b.face(&format!("spire broach {k}"), broach, spire.clone());
    }
    let gold = Paint::Plain(rgb(0xC9A24A));
    b.turned("spire ball", middle, 6, &[(0.0, 42.1), (0.4, 42.5), (0.0, 42.9)], |_, _| {
        gold.clone()
    });
}

fn nave(b: &mut Builder) {
    const WIDTH: f64 = 13.0;
    const LENGTH: f64 = 22.0;
    const EAVE: f64 = 9.5;
    const RIDGE: f64 = 17.5;
    let site = Site::new(-15.5, 49.6, 0.0);
    let at = |x: f64, y: f64, z: f64| site.at(x, y, z);
    let lancets = |count: i32, pitch: f64| vec![row(2.6, 1.4, 5.2, count, pitch, Opening::Arched)];
    let bands = [1.6, 9.2];
    let front = vec![
        at(0.0, 0.0, 0.0),
        at(WIDTH, 0.0, 0.0),
        at(WIDTH, 0.0, EAVE),
        at(0.5 * WIDTH, 0.0, RIDGE),
        at(0.0, 0.0, EAVE),
    ];
    b.face("nave south", front, wall(WIDTH, EAVE, Vec::new(), &bands, 171));
    let east = vec![
        at(WIDTH, 0.0, 0.0),
        at(WIDTH, LENGTH, 0.0),
        at(WIDTH, LENGTH, EAVE),
        at(WIDTH, 0.0, EAVE),
    ];
    b.face("nave east", east, wall(LENGTH, EAVE, lancets(5, 4.2), &bands, 172));
    let west =
        vec![at(0.0, LENGTH, 0.0), at(0.0, 0.0, 0.0), at(0.0, 0.0, EAVE), at(0.0, LENGTH, EAVE)];
    b.face("nave west", west, wall(LENGTH, EAVE, lancets(5, 4.2), &bands, 173));
    let back = vec![
        at(WIDTH, LENGTH, 0.0),
        at(0.0, LENGTH, 0.0),
        at(0.0, LENGTH, EAVE),
        at(0.5 * WIDTH, LENGTH, RIDGE),
        at(WIDTH, LENGTH, EAVE),
    ];
    let rose = vec![row(10.4, 3.2, 3.2, 1, 4.0, Opening::Rose)];
    b.face("nave north", back, wall(WIDTH, EAVE, rose, &bands, 174));
    let slope = (RIDGE - EAVE) / (0.5 * WIDTH);
    let (out, low) = (0.25, EAVE - 0.25 * slope);
    let length = (0.5 * WIDTH + out).hypot(RIDGE - low);
    let tiles = Paint::roof(TILES, 0.7, length, 175);
    let (a, z) = (at(0.5 * WIDTH, -0.1, RIDGE), at(0.5 * WIDTH, LENGTH + 0.1, RIDGE));
    let left = vec![at(-out, LENGTH + 0.1, low), at(-out, -0.1, low), a, z];
    let right = vec![at(WIDTH + out, -0.1, low), at(WIDTH + out, LENGTH + 0.1, low), z, a];
    b.face("nave roof west", left, tiles.clone());
    b.face("nave roof east", right, tiles.clone());
    // The choir: three sides of an octagon under a half pyramid.
    let y = LENGTH;
    let (half, mid) = (4.6, 0.5 * WIDTH);
    let plan = [
        (mid + half, y),
        (mid + half, y + 2.5),
        (mid + 1.9, y + 5.2),
        (mid - 1.9, y + 5.2),
        (mid - half, y + 2.5),
        (mid - half, y),
    ];
    let top = at(mid, y, 12.6);
    for (i, pair) in plan.windows(2).enumerate() {
        let (p, q) = (pair[0], pair[1]);
        let width = (q.0 - p.0).hypot(q.1 - p.1);
        let face = vec![at(p.0, p.1, 0.0), at(q.0, q.1, 0.0), at(q.0, q.1, 7.6), at(p.0, p.1, 7.6)];
        b.face(&format!("choir {i}"), face, wall(width, 7.6, lancets(1, 3.0), &[7.3], 176));
        let slope = vec![at(p.0, p.1, 7.6), at(q.0, q.1, 7.6), top];
        b.face(&format!("choir roof {i}"), slope, tiles.clone());
    }
}
