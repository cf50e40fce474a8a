//! The ray caster: a colour for every ray, a mean of many rays for every pixel.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::camera::Camera;
use super::light::{LightMap, World};
use super::photographs::{self, Photograph};
use super::polygon::{Hit, Polygon, Ray, Tree};
use super::scene;
use super::vector::{V3, v3};

/// Colour where no polygon is, 0…255.
pub(crate) const BACKGROUND: [u8; 3] = [190, 208, 222];

#[derive(Debug)]
pub(crate) struct Town {
    pub(crate) polygons: Vec<Polygon>,
    pub(crate) photographs: Vec<Photograph>,
    pub(crate) view: Camera,
    /// For each polygon the index of its photograph.
    pub(crate) assigned: Vec<usize>,
    tree: Tree,
    lights: Vec<LightMap>,
}

/// What a pixel of a picture shows, and whether the polygon's photograph shows the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    Background,
    /// The photograph sees something else there, or its frame ends before.
    Hidden,
    /// Seen at the pixel's centre, but an edge is within the margin in the view or in the photograph.
    NearEdge,
    /// Seen, with the margin, in both.
    Unoccluded,
}

/// Distance in pixels that an unoccluded pixel keeps from every edge.
pub(crate) const MARGIN: f64 = 1.5;

impl Town {
    pub(crate) fn new() -> Self {
        let (polygons, lights) = scene::build();
        let tree = Tree::new(&polygons);
        let mut town = Self {
            polygons,
            photographs: photographs::all(),
            view: photographs::view(),
            assigned: Vec::new(),
            tree,
            lights,
        };
        town.assigned = photographs::assign(&town);
        town
    }

    /// What a camera sees at a pixel position.
    pub(crate) fn look(&self, camera: &Camera, pixel: (f64, f64)) -> Option<Hit> {
        let direction = camera.direction(pixel);
        let ray = Ray { origin: camera.center, direction, from: 0.0, to: f64::INFINITY };
        self.tree.first(&self.polygons, ray)
    }

    /// Pixel position at which a camera sees point `p` of polygon `index`, if nothing hides it.
    pub(crate) fn sees(&self, camera: &Camera, index: usize, p: V3) -> Option<(f64, f64)> {
        let pixel = camera.project(p)?;
        let d = p - camera.center;
        let ray = Ray { origin: camera.center, direction: d, from: 0.0, to: 1.0 - 1e-7 };
        let own = |q: &Polygon| std::ptr::eq(q, &self.polygons[index]);
        (!self.tree.any(&self.polygons, ray, |q| !own(q))).then_some(pixel)
    }

    fn color(&self, hit: Option<Hit>) -> V3 {
        let Some(hit) = hit else {
            return v3(
                f64::from(BACKGROUND[0]) / 255.0,
                f64::from(BACKGROUND[1]) / 255.0,
                f64::from(BACKGROUND[2]) / 255.0,
            );
        };
        let world = World { polygons: &self.polygons, tree: &self.tree };
        world.color(&self.lights, hit.polygon, hit.point, hit.s)
    }

    /// Mean colour over the square of pixel (x, y), 0…255: 16 rays, 64 where several polygons meet.
    pub(crate) fn pixel(&self, camera: &Camera, x: usize, y: usize) -> [f64; 3] {
        let (mean, one) = self.mean(camera, x, y, 4);
        let mean = if one { mean } else { self.mean(camera, x, y, 8).0 };
        (mean * 255.0).array()
    }

    fn mean(&self, camera: &Camera, x: usize, y: usize, n: usize) -> (V3, bool) {
        let mut sum = V3::ZERO;
        let mut seen: Option<Option<usize>> = None;
        let mut one = true;
        for j in 0..n {
            for i in 0..n {
                let part = |k: usize| (k as f64 + 0.5) / n as f64;
                let hit = self.look(camera, (x as f64 + part(i), y as f64 + part(j)));
                let polygon = hit.map(|h| h.polygon);
                one &= *seen.get_or_insert(polygon) == polygon;
                sum = sum + self.color(hit);
            }
        }
        (sum * (1.0 / (n * n) as f64), one)
    }

    /// Whether pixel (x, y) of a picture can be textured truly from the polygon's photograph.
    pub(crate) fn sight(&self, camera: &Camera, x: usize, y: usize) -> Sight {
        let center = (x as f64 + 0.5, y as f64 + 0.5);
        let Some(hit) = self.look(camera, center) else {
            return Sight::Background;
        };
        let photograph = &self.photographs[self.assigned[hit.polygon]].camera;
        let Some(place) = self.sees(photograph, hit.polygon, hit.point) else {
            return Sight::Hidden;
        };
        let (width, height) = (photograph.width as f64, photograph.height as f64);
        let framed = place.0 >= MARGIN
            && place.1 >= MARGIN
            && place.0 <= width - MARGIN
            && place.1 <= height - MARGIN;
        // Tiles of one plane that share a photograph have no edge between them.
        let surface = |i: usize| (self.polygons[i].light, self.assigned[i]);
        let clear = |camera: &Camera, at: (f64, f64)| {
            ring(at).all(|p| {
                self.look(camera, p).is_some_and(|h| surface(h.polygon) == surface(hit.polygon))
            })
        };
        if framed && clear(camera, center) && clear(photograph, place) {
            Sight::Unoccluded
        } else {
            Sight::NearEdge
        }
    }

    /// Every pixel of a camera's picture, row by row.
    pub(crate) fn picture(&self, camera: &Camera) -> Vec<[f64; 3]> {
        let rows = in_parallel(camera.height, |y| {
            (0..camera.width).map(|x| self.pixel(camera, x, y)).collect::<Vec<_>>()
        });
        rows.concat()
    }
}

/// Eight positions half the margin away and sixteen at the margin.
fn ring(at: (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let step = 0.5 * MARGIN;
    (0..25).map(move |k| {
        let (i, j) = (f64::from(k % 5) - 2.0, f64::from(k / 5) - 2.0);
        (at.0 + step * i, at.1 + step * j)
    })
}

/// `work` of 0, 1, … `count` − 1 on all processors, the results in order.
pub(crate) fn in_parallel<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut done: Vec<(usize, T)> = std::thread::scope(|scope| {
        let run = || {
            let mut mine = Vec::new();
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                if i >= count {
                    return mine;
                }
                mine.push((i, work(i)));
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(run)).collect();
        workers.into_iter().flat_map(|w| w.join().unwrap_or_default()).collect()
    });
    done.sort_by_key(|d| d.0);
    done.into_iter().map(|d| d.1).collect()
}
