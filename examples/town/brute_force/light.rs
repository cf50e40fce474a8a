//! Sun and sky on the surfaces: cast shadows and openness, kept in maps that fill as they are asked.
//!
//! A texel depends on its own place only, so the maps are the same in whatever order they fill.

use std::sync::atomic::{AtomicU32, Ordering};

use super::paint::Paint;
use super::polygon::{Frame, Polygon, Ray, Tree};
use super::vector::{V3, v3};

const SUNLIGHT: V3 = v3(1.20, 1.01, 0.745);
const SKYLIGHT: V3 = v3(0.455, 0.485, 0.55);
const BOUNCE: V3 = v3(0.17, 0.14, 0.10);
/// Sine of the sun's radius: four times the real one, so that no shadow is sharper than a pixel.
const SUN_RADIUS: f64 = 0.018;
const OPENNESS_REACH: f64 = 9.0;

/// Towards the sun: late afternoon, in the south-west.
pub(crate) fn sun() -> V3 {
    let (azimuth, height) = (238.0_f64.to_radians(), 33.0_f64.to_radians());
    v3(azimuth.sin() * height.cos(), azimuth.cos() * height.cos(), height.sin())
}

/// A grid of values over part of a plane, smoothed by a quadratic B-spline.
#[derive(Debug)]
struct Grid {
    low: (f64, f64),
    texel: f64,
    size: (usize, usize),
    cells: Vec<AtomicU32>,
}

impl Grid {
    fn new(low: (f64, f64), high: (f64, f64), texel: f64) -> Self {
        let count = |a: f64, b: f64| ((b - a) / texel).ceil() as usize + 3;
        let size = (count(low.0, high.0), count(low.1, high.1));
        let unset = f32::NAN.to_bits();
        Self {
            low: (low.0 - 1.5 * texel, low.1 - 1.5 * texel),
            texel,
            size,
            cells: (0..size.0 * size.1).map(|_| AtomicU32::new(unset)).collect(),
        }
    }

    fn at(&self, s: f64, t: f64, make: impl Fn(f64, f64) -> f64) -> f64 {
        let axis = |x: f64, low: f64, n: usize| {
            let g = (x - low) / self.texel - 0.5;
            let i = g.round().clamp(1.0, n as f64 - 2.0);
            let f = (g - i).clamp(-0.5, 0.5);
            let weights = [0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)];
            (i as usize - 1, weights)
        };
        let (i, across) = axis(s, self.low.0, self.size.0);
        let (j, up) = axis(t, self.low.1, self.size.1);
        let mut sum = 0.0;
        for (dj, wj) in up.iter().enumerate() {
            for (di, wi) in across.iter().enumerate() {
                sum += wi * wj * self.cell(i + di, j + dj, &make);
            }
        }
        sum
    }

    fn cell(&self, i: usize, j: usize, make: &impl Fn(f64, f64) -> f64) -> f64 {
        let cell = &self.cells[j * self.size.0 + i];
        let known = f32::from_bits(cell.load(Ordering::Relaxed));
        if !known.is_nan() {
            return f64::from(known);
        }
        let place = |k: usize, low: f64| low + (k as f64 + 0.5) * self.texel;
        let value = make(place(i, self.low.0), place(j, self.low.1)) as f32;
        cell.store(value.to_bits(), Ordering::Relaxed);
        f64::from(value)
    }
}

#[derive(Debug)]
pub(crate) struct LightMap {
    frame: Frame,
    low: (f64, f64),
    high: (f64, f64),
    sun: Grid,
    sky: Grid,
}

impl LightMap {
    pub(crate) fn new(frame: Frame, low: (f64, f64), high: (f64, f64), texel: f64) -> Self {
        Self {
            frame,
            low,
            high,
            sun: Grid::new(low, high, texel),
            sky: Grid::new(low, high, 4.0 * texel),
        }
    }

    /// Sun seen and sky seen, 0…1, at plane coordinates; open beyond the map.
    fn at(&self, (s, t): (f64, f64), polygon: &Polygon, world: &World) -> (f64, f64) {
        if s < self.low.0 || t < self.low.1 || s > self.high.0 || t > self.high.1 {
            return (1.0, 1.0);
        }
        let texel = self.sun.texel;
        let sun = self.sun.at(s, t, |s, t| world.sun_seen(&self.frame, s, t, texel, polygon));
        let sky = self.sky.at(s, t, |s, t| world.openness(self.frame.point(s, t), self.frame.n));
        (sun, sky)
    }
}

/// What stands in the light's way.
pub(crate) struct World<'a> {
    pub(crate) polygons: &'a [Polygon],
    pub(crate) tree: &'a Tree,
}

fn stands(polygon: &Polygon) -> bool {
    !matches!(polygon.paint, Paint::Backdrop)
}

/// The i-th of a low-discrepancy sequence in the unit square.
fn spread(i: usize) -> (f64, f64) {
    let i = i as f64 + 0.5;
    ((i * 0.754_877_666_246_692_8).fract(), (i * 0.569_840_290_998_053_2).fract())
}

impl World<'_> {
    /// Share of the sun's disc seen from a texel, averaged over the texel.
    fn sun_seen(&self, frame: &Frame, s: f64, t: f64, texel: f64, polygon: &Polygon) -> f64 {
        let leaves = matches!(polygon.paint, Paint::Leaves { .. });
        let to_sun = sun();
        if frame.n.dot(to_sun) <= 0.0 && !leaves {
            return 0.0;
        }
        let across = to_sun.cross(v3(0.0, 0.0, 1.0)).unit();
        let up = across.cross(to_sun);
        let own = |q: &Polygon| match (&q.paint, &polygon.paint) {
            (Paint::Leaves { center: a, .. }, Paint::Leaves { center: b, .. }) => a == b,
            _ => false,
        };
        let lit = |i: usize| {
            let (a, b) = spread(i);
            let (c, d) = spread(7 * i + 3);
            let (radius, angle) = (SUN_RADIUS * c.sqrt(), d * std::f64::consts::TAU);
            let from = frame.point(s + (a - 0.5) * texel, t + (b - 0.5) * texel);
            let ray = Ray {
                origin: from + frame.n * 0.02,
                direction: to_sun + across * (radius * angle.cos()) + up * (radius * angle.sin()),
                from: 0.0,
                to: 150.0,
            };
            !self.tree.any(self.polygons, ray, |q| stands(q) && !own(q))
        };
        let first = (0..16).filter(|&i| lit(i)).count();
        if first == 0 || first == 16 {
            return first as f64 / 16.0;
        }
        (first + (16..64).filter(|&i| lit(i)).count()) as f64 / 64.0
    }

    /// How much of the hemisphere over a point is open nearby, weighted by the cosine.
    fn openness(&self, point: V3, n: V3) -> f64 {
        const RAYS: usize = 40;
        let side = if n.z.abs() < 0.9 { v3(0.0, 0.0, 1.0) } else { v3(1.0, 0.0, 0.0) };
        let a = n.cross(side).unit();
        let b = n.cross(a);
        let mut closed = 0.0;
        for i in 0..RAYS {
            let (p, q) = spread(i);
            let (radius, angle) = (p.sqrt(), q * std::f64::consts::TAU);
            let direction = a * (radius * angle.cos())
                + b * (radius * angle.sin())
                + n * (1.0 - p).max(0.0).sqrt();
            let ray = Ray { origin: point + n * 0.02, direction, from: 0.0, to: OPENNESS_REACH };
            if let Some(hit) = self.tree.first(self.polygons, ray) {
                let near = 1.0 - hit.t / OPENNESS_REACH;
                closed += near * near;
            }
        }
        1.0 - closed / RAYS as f64
    }

    /// Display colour, 0…1, of a polygon's point.
    pub(crate) fn color(&self, lights: &[LightMap], index: usize, p: V3, at: (f64, f64)) -> V3 {
        let polygon = &self.polygons[index];
        let albedo = polygon.paint.albedo(at.0, at.1, p);
        if !stands(polygon) {
            return albedo;
        }
        let (sun_seen, sky_seen) = lights[polygon.light].at(at, polygon, self);
        let n = match polygon.paint {
            Paint::Leaves { center, .. } => (p - center).unit(),
            _ => polygon.frame.n,
        };
        let light = SUNLIGHT * (n.dot(sun()).max(0.0) * sun_seen)
            + SKYLIGHT * ((0.68 + 0.32 * n.z) * sky_seen)
            + BOUNCE * (0.5 - 0.5 * n.z);
        albedo.times(light).map(shoulder)
    }
}

/// Keeps highlights below 1 without a kink.
fn shoulder(x: f64) -> f64 {
    const KNEE: f64 = 0.75;
    if x < KNEE { x } else { KNEE + (1.0 - KNEE) * (1.0 - (-(x - KNEE) / (1.0 - KNEE)).exp()) }
}
