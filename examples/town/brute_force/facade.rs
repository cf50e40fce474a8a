//! Walls: plaster, brick, dressed stone and half-timbering, with their windows and doors.

use super::ink::{arch, clouds, comb, hash, ink, noise, ramp, rectangle, rgb, segment};
use super::vector::{V3, v3};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Style {
    Plaster,
    Brick,
    Stone,
    /// Beams above this height.
    Timber {
        from: f64,
    },
}

/// `count` windows side by side, centred on the wall.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) sill: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) count: i32,
    pub(crate) pitch: f64,
    pub(crate) opening: Opening,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Opening {
    Window,
    Shuttered(V3),
    /// A round-headed window with tracery.
    Arched,
    /// An open arcade, dark inside.
    Arcade,
    Shop(V3),
    Door(V3),
    /// A slit or belfry louvre.
    Louvre,
    Clock,
    Rose,
}

#[derive(Clone, Debug)]
pub(crate) struct Wall {
    pub(crate) width: f64,
    /// Height of the eaves, and of the gable's top if it has one.
    pub(crate) eave: f64,
    pub(crate) peak: f64,
    pub(crate) style: Style,
    pub(crate) color: V3,
    pub(crate) trim: V3,
    pub(crate) plinth: f64,
    /// Heights of string courses.
    pub(crate) bands: Vec<f64>,
    pub(crate) rows: Vec<Row>,
    pub(crate) seed: u32,
}

impl Wall {
    /// Colour at s from the left, t above the ground.
    pub(crate) fn albedo(&self, s: f64, t: f64) -> V3 {
        let mut c = self.surface(s, t);
        for band in &self.bands {
            c = c.mix(self.trim, ink((t - band).abs() - 0.13));
        }
        if self.plinth > 0.0 {
            let stone = rgb(0x8F877B) * (1.0 + 0.05 * noise(s * 1.1, t * 1.6, self.seed + 3));
            c = c.mix(stone, ink(t - self.plinth));
        }
        for (i, row) in self.rows.iter().enumerate() {
            c = self.openings(c, row, i, s, t);
        }
        c
    }

    fn surface(&self, s: f64, t: f64) -> V3 {
        let mottle = clouds(s * 0.45, t * 0.35, self.seed);
        let damp = ramp(2.2, 0.2, t + 0.5 * mottle);
        let plain = self.color * (1.0 + 0.018 * mottle - 0.06 * damp);
        match self.style {
            Style::Plaster => {
                let quoin = s.min(self.width - s) - 0.32;
                plain.mix(self.trim, 0.6 * ink(quoin) * ink(t - self.eave))
            }
            Style::Brick => {
                let joint = ramp(0.16, 0.0, comb(t, 0.5));
                let shade = noise(s * 1.3, (t / 0.5).round() * 0.8, self.seed + 7);
                plain * (1.0 + 0.025 * shade - 0.045 * joint)
            }
            Style::Stone => {
                let course = (t / 0.8).floor();
                let shift = if course.rem_euclid(2.0) < 1.0 { 0.0 } else { 0.8 };
                let block = ((s + shift) / 1.6).floor();
                let shade = hash(block as i64, course as i64, self.seed) - 0.5;
                let edge = comb(t, 0.8).min(comb(s + shift, 1.6));
                let joint = ramp(0.16, 0.0, edge);
                plain * (1.0 + 0.05 * shade * (1.0 - joint) - 0.035 * joint)
            }
            Style::Timber { from } => {
                let wood = rgb(0x816852) * (1.0 + 0.08 * noise(s * 0.7, t * 2.0, self.seed + 9));
                plain.mix(wood, ink(self.beams(s, t, from)))
            }
        }
    }

    /// Signed distance to the timber frame: posts, rails, braces and the gable's rafters.
    fn beams(&self, s: f64, t: f64, from: f64) -> f64 {
        const FLOOR: f64 = 2.7;
        const HALF: f64 = 0.11;
        if t < from - 0.5 {
            return 1.0;
        }
        let above = t - from;
        let floor = (above / FLOOR).floor();
        let within = above - floor * FLOOR;
        let rails = within.min(FLOOR - within).min((within - 0.95).abs() + 0.02);
        let bays = (self.width / 1.7).round().max(2.0);
        let bay = self.width / bays;
        let posts = comb(s, bay).min((s - 0.1).abs()).min((self.width - 0.1 - s).abs());
        let mut d = rails.min(posts);
        // Saint Andrew's crosses below the window rails, braces in the end bays.
        let cell = (s / bay).floor();
        let x = s - cell * bay;
        if within < 0.95 && hash(cell as i64, floor as i64, self.seed) < 0.25 {
            let down = segment((x, within), (0.0, 0.0), (bay, 0.95));
            let up = segment((x, within), (0.0, 0.95), (bay, 0.0));
            d = d.min(down + 0.02).min(up + 0.02);
        }
        let end = if cell < 0.5 { x } else { bay - x };
        if within >= 0.95 && (cell < 0.5 || cell > bays - 1.5) {
            d = d.min(segment((end, within), (0.0, FLOOR), (bay, 0.95)));
        }
        if self.peak > self.eave {
            let slope = (self.peak - self.eave) / (0.5 * self.width);
            let under = self.peak - slope * (s - 0.5 * self.width).abs() - t;
            d = d.min((under / slope.hypot(1.0) - 0.12).abs());
        }
        (d - HALF).max(from - HALF - t)
    }

    fn openings(&self, c: V3, row: &Row, index: usize, s: f64, t: f64) -> V3 {
        let y = t - row.sill;
        if y < -0.8 || y > row.height + 0.9 || row.count < 1 {
            return c;
        }
        let first = 0.5 * self.width - 0.5 * f64::from(row.count - 1) * row.pitch;
        let i = ((s - first) / row.pitch).round().clamp(0.0, f64::from(row.count - 1));
        let x = s - first - i * row.pitch;
        let luck = hash(i as i64, index as i64, self.seed + 17);
        let (hw, h) = (0.5 * row.width, row.height);
        match row.opening {
            Opening::Window => self.window(c, x, y, hw, h, luck),
            Opening::Shuttered(color) => {
                let leaf = (x.abs() - 1.55 * hw - 0.1).abs();
                let shutter = rectangle(leaf, y - 0.5 * h, 0.5 * hw, 0.5 * h);
                let slats = color * (1.0 - 0.1 * ramp(0.1, 0.0, comb(y, 0.4)));
                self.window(c.mix(slats, ink(shutter)), x, y, hw, h, luck)
            }
            Opening::Arched => {
                let c = c.mix(self.trim, ink(arch(x, y + 0.14, hw + 0.16, h + 0.3)));
                let glass = glazing(y / h, luck) * 0.85;
                let c = c.mix(glass, ink(arch(x, y, hw, h)));
                let bar = comb(x, hw).min(comb(y, 1.1) + 0.02) - 0.055;
                let bars = bar.max(arch(x, y, hw, h));
                c.mix(self.trim * 0.8, 0.8 * ink(bars))
            }
            Opening::Arcade => {
                let c = c.mix(self.trim, ink(arch(x, y, hw + 0.3, h + 0.3)));
                let depth = rgb(0x3A322B).mix(rgb(0x75634F), ramp(2.6, 0.0, y));
                c.mix(depth, ink(arch(x, y, hw, h)))
            }
            Opening::Shop(color) => {
                let c =
                    c.mix(color, ink(rectangle(x, y - 0.5 * h - 0.15, hw + 0.2, 0.5 * h + 0.35)));
                let glass = rgb(0x3C474B).mix(rgb(0xC9A36B), 0.35 + 0.35 * luck);
                let pane = rectangle(comb(x, hw) - 0.5 * hw, y - 0.5 * h, 0.5 * hw - 0.09, 0.5 * h);
                let c = c.mix(glass, ink(pane.max(x.abs() - hw)));
                let sign = rectangle(x, y - h - 0.22, hw * 0.75, 0.09);
                c.mix(v3(0.88, 0.82, 0.66), 0.7 * ink(sign))
            }
            Opening::Door(color) => {
                let c = c.mix(self.trim, ink(arch(x, y, hw + 0.22, h + 0.22)));
                let plank = color * (1.0 - 0.12 * ramp(0.12, 0.0, comb(x, 0.5)));
                let fan = rgb(0x38434A);
                let leaf = plank.mix(fan, ink(h - hw + 0.12 - y));
                c.mix(leaf, ink(arch(x, y, hw, h)))
            }
            Opening::Louvre => {
                let c = c.mix(self.trim, ink(arch(x, y, hw + 0.2, h + 0.2)));
                let slats = rgb(0x3B3631) * (1.0 + 0.5 * ramp(0.22, 0.05, comb(y, 0.7)));
                c.mix(slats, ink(arch(x, y, hw, h)))
            }
            Opening::Clock => clock(c, x, y - 0.5 * h, 0.5 * h),
            Opening::Rose => {
                let (r, angle) = (x.hypot(y - 0.5 * h), (y - 0.5 * h).atan2(x));
                let radius = 0.5 * h;
                let c = c.mix(self.trim, ink(r - radius - 0.25));
                let petal = comb(angle, std::f64::consts::FRAC_PI_4) * r - 0.09;
                let lead = petal.min((r - 0.55 * radius).abs() - 0.08).min(r - 0.3);
                let glass = rgb(0x33486A).mix(rgb(0x7A3E4C), 0.6 * ramp(0.4, 0.7, r / radius));
                c.mix(glass.mix(self.trim * 0.9, ink(lead)), ink(r - radius))
            }
        }
    }

    fn window(&self, c: V3, x: f64, y: f64, hw: f64, h: f64, luck: f64) -> V3 {
        let v = y - 0.5 * h;
        let c = c.mix(self.trim, ink(rectangle(x, v, hw + 0.15, 0.5 * h + 0.15)));
        let sill = rectangle(x, y + 0.2, hw + 0.26, 0.09);
        let c = c.mix(self.trim * 1.06, ink(sill));
        let bars = x.abs().min((y - 0.64 * h).abs()) - 0.03;
        let frame = v3(0.8, 0.78, 0.72);
        let pane = glazing(y / h, luck).mix(frame, 0.6 * ink(bars));
        c.mix(pane, ink(rectangle(x, v, hw, 0.5 * h)))
    }
}

/// Glass: a bright sky above, the room's dark or a curtain below.
fn glazing(up: f64, luck: f64) -> V3 {
    let sky = rgb(0x7C909C).mix(rgb(0x4A555C), ramp(1.0, 0.1, up));
    let curtain = rgb(0xB9A98F);
    sky.mix(curtain, if luck > 0.72 { 0.55 } else { 0.12 * luck })
}

fn clock(c: V3, x: f64, y: f64, radius: f64) -> V3 {
    let r = x.hypot(y);
    let gold = rgb(0xC9A24A);
    let c = c.mix(gold, ink(r - radius));
    let c = c.mix(rgb(0x22303F), ink(r - radius + 0.2));
    let angle = y.atan2(x);
    let hour = comb(angle, std::f64::consts::PI / 6.0) * r - 0.07;
    let c = c.mix(gold, ink(hour.max((r - 0.72 * radius).abs() - 0.16)));
    // Twenty to six, as the sun stands.
    let hand =
        |to: f64, reach: f64| segment((x, y), (0.0, 0.0), (reach * to.sin(), reach * to.cos()));
    let minute = hand(std::f64::consts::TAU * 40.0 / 60.0, 0.66 * radius) - 0.05;
    let hours = hand(std::f64::consts::TAU * (5.0 + 40.0 / 60.0) / 12.0, 0.45 * radius) - 0.08;
    c.mix(v3(0.88, 0.84, 0.7), ink(minute.min(hours)))
}
