//! Things made of planar polygons: houses, boxes, trees, fountains.

use super::ink::rgb;
use super::light::LightMap;
use super::paint::Paint;
use super::polygon::{Frame, Polygon};
use super::vector::{V3, v3};

/// Width of a light texel on buildings and on everything else, in metres.
const FINE: f64 = 0.13;
const COARSE: f64 = 0.3;

#[derive(Debug, Default)]
pub(crate) struct Builder {
    pub(crate) polygons: Vec<Polygon>,
    pub(crate) lights: Vec<LightMap>,
}

/// A local system on the ground: a point, the direction of x in degrees from east, y to its left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Site {
    origin: V3,
    x: V3,
    y: V3,
}

impl Site {
    pub(crate) fn new(x: f64, y: f64, degrees: f64) -> Self {
        // Quarter turns are exact.
        let (sin, cos) = match degrees {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            _ => degrees.to_radians().sin_cos(),
        };
        Self { origin: v3(x, y, 0.0), x: v3(cos, sin, 0.0), y: v3(-sin, cos, 0.0) }
    }

    pub(crate) fn at(&self, a: f64, b: f64, z: f64) -> V3 {
        self.origin + self.x * a + self.y * b + v3(0.0, 0.0, z)
    }
}

impl Builder {
    /// A polygon with a light map of its own; vertices anticlockwise from outside, first edge along the paint's s.
    pub(crate) fn face(&mut self, name: &str, vertices: Vec<V3>, paint: Paint) {
        let texel = match paint {
            Paint::Leaves { .. } => COARSE,
            _ => FINE,
        };
        let frame = Frame::of(&vertices);
        let polygon = Polygon::new(name.to_owned(), vertices, frame, paint, self.lights.len());
        let (low, high) = polygon.extent();
        self.lights.push(LightMap::new(frame, low, high, texel));
        self.polygons.push(polygon);
    }

    /// Upright box: four sides and a top.
    pub(crate) fn block(
        &mut self,
        name: &str,
        site: Site,
        sides: [(f64, f64); 3],
        (paint, top): (&Paint, &Paint),
    ) {
        let [(x0, x1), (y0, y1), (z0, z1)] = sides;
        let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
        for (i, side) in ["front", "right", "back", "left"].iter().enumerate() {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            let face = vec![
                site.at(a.0, a.1, z0),
                site.at(b.0, b.1, z0),
                site.at(b.0, b.1, z1),
                site.at(a.0, a.1, z1),
            ];
            self.face(&format!("{name} {side}"), face, paint.clone());
        }
        let lid = corners.iter().map(|c| site.at(c.0, c.1, z1)).collect();
        self.face(&format!("{name} top"), lid, top.clone());
    }

    /// A solid of revolution with `sides` flat sides through (radius, height) pairs from bottom to top.
    pub(crate) fn turned(
        &mut self,
        name: &str,
        site: Site,
        sides: usize,
        profile: &[(f64, f64)],
        paint: impl Fn(usize, usize) -> Paint,
    ) {
        let point = |i: usize, (r, z): (f64, f64)| {
            let angle = std::f64::consts::TAU * (i as f64 + 0.5) / sides as f64;
            site.at(r * angle.cos(), r * angle.sin(), z)
        };
        for (band, pair) in profile.windows(2).enumerate() {
            for i in 0..sides {
                let (low, high) = (pair[0], pair[1]);
                let mut face = Vec::with_capacity(4);
                if low.0 > 0.0 {
                    face.extend([point(i, low), point(i + 1, low)]);
                } else {
                    face.push(point(i, low));
                }
                if high.0 > 0.0 {
                    face.extend([point(i + 1, high), point(i, high)]);
                } else {
                    face.push(point(i, high));
                }
                self.face(&format!("{name} {band}.{i}"), face, paint(band, i));
            }
        }
    }

    /// A flat polygon with `sides` corners.
    pub(crate) fn disc(
        &mut self,
        name: &str,
        site: Site,
        sides: usize,
        r: f64,
        z: f64,
        paint: Paint,
    ) {
        let corner = |i: usize| {
            let angle = std::f64::consts::TAU * (i as f64 + 0.5) / sides as f64;
            site.at(r * angle.cos(), r * angle.sin(), z)
        };
        self.face(name, (0..sides).map(corner).collect(), paint);
    }

    pub(crate) fn round_tree(&mut self, name: &str, x: f64, y: f64, height: f64, seed: u32) {
        const GREENS: [u32; 4] = [0x6B8440, 0x5F7B3C, 0x7C8C45, 0x557038];
        let site = Site::new(x, y, f64::from(seed % 45));
        let (radius, half) = (0.34 * height, 0.36 * height);
        let middle = height - half;
        let paint = Paint::Leaves {
            center: v3(x, y, middle - 0.1 * height),
            color: rgb(GREENS[seed as usize % 4]),
            seed,
        };
        let trunk = Paint::Plain(rgb(0x6A5743));
        self.turned(&format!("{name} trunk"), site, 5, &[(0.18, 0.0), (0.16, middle)], |_, _| {
            trunk.clone()
        });
        let ring = |r: f64, z: f64| (radius * r, middle + half * z);
        let profile = [
            ring(0.0, -0.95),
            ring(0.72, -0.72),
            ring(1.0, -0.1),
            ring(0.75, 0.62),
            ring(0.0, 1.0),
        ];
        self.turned(name, site, 9, &profile, |_, _| paint.clone());
    }

    pub(crate) fn poplar(&mut self, name: &str, x: f64, y: f64, height: f64, seed: u32) {
        let site = Site::new(x, y, f64::from(seed % 60));
        let paint = Paint::Leaves {
            center: v3(x, y, 0.35 * height),
            color: rgb(if seed.is_multiple_of(2) { 0x4F6B3B } else { 0x5A7440 }),
            seed,
        };
        let r = 0.13 * height;
        let profile = [
            (0.0, 0.04 * height),
            (0.75 * r, 0.1 * height),
            (r, 0.36 * height),
            (0.72 * r, 0.7 * height),
            (0.0, height),
        ];
        self.turned(name, site, 7, &profile, |_, _| paint.clone());
    }

    pub(crate) fn figure(&mut self, name: &str, x: f64, y: f64, coat: u32, legs: u32) {
        let site = Site::new(x, y, (x * 37.0).rem_euclid(60.0));
        let paint = Paint::Figure { coat: rgb(coat), legs: rgb(legs) };
        let profile =
            [(0.2, 0.0), (0.3, 0.85), (0.28, 1.3), (0.13, 1.45), (0.14, 1.7), (0.0, 1.78)];
        self.turned(name, site, 5, &profile, |_, _| paint.clone());
    }
}
