//! Houses: four walls under a gabled, hipped or step-gabled roof, with dormers and chimneys.

use super::build::{Builder, Site};
use super::facade::{Opening, Row, Style, Wall};
use super::ink::rgb;
use super::paint::Paint;
use super::vector::{V3, v3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// The gable stands to the street.
    Gable,
    /// The eaves stand to the street.
    Eaves,
    Hip,
    /// A gable with this many steps a side.
    Stepped(usize),
}

/// Site: front left corner, x along the front, y into the house.
#[derive(Clone, Debug)]
pub(crate) struct House {
    pub(crate) name: &'static str,
    pub(crate) site: Site,
    pub(crate) width: f64,
    pub(crate) depth: f64,
    pub(crate) eave: f64,
    pub(crate) ridge: f64,
    pub(crate) shape: Shape,
    pub(crate) style: Style,
    pub(crate) color: u32,
    pub(crate) trim: u32,
    pub(crate) roof: u32,
    pub(crate) rows: Vec<Row>,
    pub(crate) bands: Vec<f64>,
    pub(crate) dormers: usize,
    pub(crate) seed: u32,
}

const OVERHANG: f64 = 0.22;

impl House {
    fn wall(&self, width: f64, peak: f64, front: bool) -> Paint {
        let mut rows = self.rows.clone();
        if !front {
            // The other sides have plain windows, as many as fit.
            rows.retain(|r| matches!(r.opening, Opening::Window | Opening::Shuttered(_)));
            for row in &mut rows {
                row.count = row.count.min(((width - 1.2) / row.pitch) as i32);
                if row.sill > self.eave - 1.0 && peak <= self.eave {
                    row.count = 0;
                }
            }
        }
        Paint::Wall(Box::new(Wall {
            width,
            eave: self.eave,
            peak,
            style: self.style,
            color: rgb(self.color),
            trim: rgb(self.trim),
            plinth: if self.style == Style::Stone { 0.0 } else { 0.55 },
            bands: self.bands.clone(),
            rows,
            seed: self.seed,
        }))
    }

    pub(crate) fn build(&self, b: &mut Builder) {
        let (w, d, e, r) = (self.width, self.depth, self.eave, self.ridge);
        let at = |x: f64, y: f64, z: f64| self.site.at(x, y, z);
        let corners = [(0.0, 0.0), (w, 0.0), (w, d), (0.0, d)];
        let crosswise = match self.shape {
            Shape::Gable | Shape::Stepped(_) => true,
            Shape::Eaves => false,
            Shape::Hip => d > w,
        };
        for (i, side) in ["front", "right", "back", "left"].iter().enumerate() {
            let (a, c) = (corners[i], corners[(i + 1) % 4]);
            let mut face =
                vec![at(a.0, a.1, 0.0), at(c.0, c.1, 0.0), at(c.0, c.1, e), at(a.0, a.1, e)];
            let gable = self.shape != Shape::Hip && crosswise == (i % 2 == 0);
            if gable {
                if let (Shape::Stepped(steps), 0) = (self.shape, i) {
                    self.stepped(b, steps);
                    continue;
                }
                face.insert(3, at(0.5 * (a.0 + c.0), 0.5 * (a.1 + c.1), r));
            }
            let width = if i % 2 == 0 { w } else { d };
            let paint = self.wall(width, if gable { r } else { e }, i == 0);
            b.face(&format!("{} {side}", self.name), face, paint);
        }
        self.roof(b, crosswise);
        if self.shape != Shape::Hip {
            self.chimney(b, crosswise);
        }
        if self.dormers > 0 {
            self.dormer_row(b, crosswise);
        }
    }

    fn roof(&self, b: &mut Builder, crosswise: bool) {
        // In a system whose ridge runs along y, of breadth p and length q.
        let (p, q) = if crosswise { (self.width, self.depth) } else { (self.depth, self.width) };
        let at = |x: f64, y: f64, z: f64| {
            if crosswise { self.site.at(x, y, z) } else { self.site.at(self.width - y, x, z) }
        };
        let rise = self.ridge - self.eave;
        let slope = rise / (0.5 * p);
        let low = self.eave - OVERHANG * slope;
        let hip = if self.shape == Shape::Hip { 0.5 * p * 0.8 } else { -0.12 };
        let near = if matches!(self.shape, Shape::Stepped(_)) { 0.0 } else { hip };
        let ends = if self.shape == Shape::Hip { -OVERHANG } else { hip };
        let near_end = if matches!(self.shape, Shape::Stepped(_)) { 0.0 } else { ends };
        let length = (0.5 * p + OVERHANG).hypot(rise + OVERHANG * slope);
        let paint = Paint::roof(self.roof, 0.62, length, self.seed);
        let (top_a, top_b) = (at(0.5 * p, near, self.ridge), at(0.5 * p, q - hip, self.ridge));
        let left = vec![at(-OVERHANG, q - ends, low), at(-OVERHANG, near_end, low), top_a, top_b];
        let right =
            vec![at(p + OVERHANG, near_end, low), at(p + OVERHANG, q - ends, low), top_b, top_a];
        b.face(&format!("{} roof left", self.name), left, paint.clone());
        b.face(&format!("{} roof right", self.name), right, paint.clone());
        if self.shape == Shape::Hip {
            let front = vec![at(-OVERHANG, ends, low), at(p + OVERHANG, ends, low), top_a];
            let back = vec![at(p + OVERHANG, q - ends, low), at(-OVERHANG, q - ends, low), top_b];
            b.face(&format!("{} roof front", self.name), front, paint.clone());
            b.face(&format!("{} roof back", self.name), back, paint);
        }
    }

    /// A concave gable wall whose steps stand above the roof, half a metre thick.
    fn stepped(&self, b: &mut Builder, steps: usize) {
        const THICK: f64 = 0.5;
        let (w, e, r) = (self.width, self.eave, self.ridge);
        let n = steps as f64;
        let (run, rise) = (0.5 * w / (n + 0.5), (r - e) / n);
        // The inner corner of each step clears the roof.
        let above = (r - e) / (n + 0.5) + 0.25;
        // From the right eave to the left one, as (x, z).
        let mut edge = Vec::new();
        for i in 0..=steps {
            let (x, z) = (w - run * i as f64, e + rise * i as f64 + above);
            edge.push((x, z));
            if i < steps {
                edge.push((x - run, z));
            }
        }
        let other: Vec<_> = edge.iter().rev().map(|&(x, z)| (w - x, z)).collect();
        edge.extend(other);
        let outline = |y: f64| {
            let mut all = vec![self.site.at(0.0, y, 0.0), self.site.at(w, y, 0.0)];
            all.extend(edge.iter().map(|&(x, z)| self.site.at(x, y, z)));
            all
        };
        b.face(&format!("{} front", self.name), outline(0.0), self.wall(w, r, true));
        let mut rear = outline(THICK);
        rear[0] = self.site.at(0.0, THICK, e - 1.0);
        rear[1] = self.site.at(w, THICK, e - 1.0);
        rear.swap(0, 1);
        rear[2..].reverse();
        let stone = Paint::Plain(rgb(self.trim));
        b.face(&format!("{} parapet", self.name), rear, Paint::Plain(rgb(self.color)));
        for (i, pair) in edge.windows(2).enumerate() {
            let (p, q) = (pair[0], pair[1]);
            let face = vec![
                self.site.at(p.0, 0.0, p.1),
                self.site.at(p.0, THICK, p.1),
                self.site.at(q.0, THICK, q.1),
                self.site.at(q.0, 0.0, q.1),
            ];
            b.face(&format!("{} step {i}", self.name), face, stone.clone());
        }
    }

    fn chimney(&self, b: &mut Builder, crosswise: bool) {
        let brick = Paint::Plain(rgb(0x9A6A55));
        let soot = Paint::Plain(rgb(0x54473F));
        let along = if self.seed.is_multiple_of(2) { 0.3 } else { 0.72 };
        let (x, y) = if crosswise {
            (0.5 * self.width + 0.9, along * self.depth)
        } else {
            (along * self.width, 0.5 * self.depth + 0.9)
        };
        let z = (self.ridge - 2.5, self.ridge + 0.9);
        let name = format!("{} chimney", self.name);
        let sides = [(x - 0.4, x + 0.4), (y - 0.4, y + 0.4), z];
        b.block(&name, self.site, sides, (&brick, &soot));
    }

    /// Gabled dormers on the slope towards the street, or on both slopes of a gable house.
    fn dormer_row(&self, b: &mut Builder, crosswise: bool) {
        let (p, q) = if crosswise { (self.width, self.depth) } else { (self.depth, self.width) };
        let slope = (self.ridge - self.eave) / (0.5 * p);
        let sides: &[bool] = if crosswise { &[false, true] } else { &[false] };
        for &far in sides {
            for i in 0..self.dormers {
                let y = q * (i as f64 + 0.5) / self.dormers as f64;
                let at = |x: f64, dy: f64, z: f64| match (crosswise, far) {
                    (false, _) => self.site.at(y + dy, x, z),
                    (true, false) => self.site.at(x, y - dy, z),
                    (true, true) => self.site.at(self.width - x, y + dy, z),
                };
                let name = format!("{} dormer {i}{}", self.name, if far { "r" } else { "" });
                self.dormer(b, &name, slope, at);
            }
        }
    }

    /// `at(x, y, z)`: x up the slope from the eaves, y to the right seen from outside.
    fn dormer(&self, b: &mut Builder, name: &str, slope: f64, at: impl Fn(f64, f64, f64) -> V3) {
        const HALF: f64 = 0.85;
        let x0 = 0.9;
        let foot = self.eave + slope * x0;
        let (eave, ridge) = (foot + 1.35, foot + 2.1);
        let meets = |z: f64| (z - self.eave) / slope;
        let front = vec![
            at(x0, -HALF, foot),
            at(x0, HALF, foot),
            at(x0, HALF, eave),
            at(x0, 0.0, ridge),
            at(x0, -HALF, eave),
        ];
        let pane = Row {
            sill: 0.32,
            width: 0.78,
            height: 0.92,
            count: 1,
            pitch: 3.0,
            opening: Opening::Window,
        };
        let wall = |rows: Vec<Row>| {
            Paint::Wall(Box::new(Wall {
                width: 2.0 * HALF,
                eave: 9.0,
                peak: 9.0,
                style: Style::Plaster,
                color: rgb(self.color).mix(v3(0.8, 0.77, 0.7), 0.3),
                trim: rgb(self.trim),
                plinth: 0.0,
                bands: Vec::new(),
                rows,
                seed: self.seed,
            }))
        };
        b.face(&format!("{name} front"), front, wall(vec![pane]));
        let cheek = Paint::Plain(rgb(self.roof) * 0.92);
        let left = vec![at(x0, -HALF, foot), at(x0, -HALF, eave), at(meets(eave), -HALF, eave)];
        let right = vec![at(x0, HALF, foot), at(meets(eave), HALF, eave), at(x0, HALF, eave)];
        b.face(&format!("{name} left"), left, cheek.clone());
        b.face(&format!("{name} right"), right, cheek);
        let paint = Paint::roof(self.roof, 0.62, 1.2, self.seed + 1);
        let (x1, low) = (x0 - 0.2, eave - 0.1);
        let drop = (ridge - eave) / HALF;
        let wide = HALF + 0.1 / drop;
        let slope_left = vec![
            at(meets(low), -wide, low),
            at(x1, -wide, low),
            at(x1, 0.0, ridge),
            at(meets(ridge), 0.0, ridge),
        ];
        let slope_right = vec![
            at(x1, wide, low),
            at(meets(low), wide, low),
            at(meets(ridge), 0.0, ridge),
            at(x1, 0.0, ridge),
        ];
        b.face(&format!("{name} roof left"), slope_left, paint.clone());
        b.face(&format!("{name} roof right"), slope_right, paint);
    }
}
