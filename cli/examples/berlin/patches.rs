//! Faces cut into patches, each with a photograph that sees all of it.

use anyhow::Result;
use collinear::geometry::Plane;
use collinear::nalgebra::{Point2, Point3, UnitVector3};
use collinear::resample::{Border, Filter, ImageView, sample};
use collinear_io::scene::{Fill, Polygon};

use crate::model::Face;
use crate::sight::{Sight, Target};
use crate::site::{Photograph, Site};

/// The side of the largest and the smallest patch, world units.
const LARGEST: f64 = 2.0;
const SMALLEST: f64 = 0.124;
/// The side of the largest patch that no photograph sees any of.
const UNSEEN: f64 = 0.5;
/// Points along each side of a patch at which visibility is asked.
const SAMPLES: usize = 5;
/// A face whose best photograph has fewer pixels a world unit is seen too flat to be placed, and counts as not seen.
const COARSE: f64 = 25.0;

/// A part of a face within a square of its plane.
struct Patch {
    outline: Vec<Point2<f64>>,
    middle: Point2<f64>,
    photograph: Option<usize>,
}

/// A face being cut.
struct Cutter<'a> {
    sight: &'a Sight,
    site: &'a Site,
    target: &'a Target,
    /// The photographs, best first.
    order: Vec<usize>,
    patches: Vec<Patch>,
}

impl Cutter<'_> {
    /// Keeps a square's part of the face, or cuts it in four until one photograph shows all of it.
    fn cut(&mut self, corner: Point2<f64>, side: f64) {
        let outline = clip(&self.target.outline, corner, side);
        if outline.len() < 3 {
            return;
        }
        let at = |i: usize| side * i as f64 / (SAMPLES - 1) as f64;
        let sum = outline.iter().fold(Point2::origin().coords, |s, p| s + p.coords);
        let middle = Point2::from(sum / outline.len() as f64);
        let points: Vec<Point3<f64>> = (0..SAMPLES * SAMPLES)
            .map(|k| Point2::new(corner.x + at(k % SAMPLES), corner.y + at(k / SAMPLES)))
            .filter(|p| self.target.holds(p))
            .chain(outline.iter().map(|p| p + (middle - p) * 1e-3))
            .map(|p| self.target.world(&p))
            .collect();
        let seen = |i: usize| {
            let photograph = &self.site.photographs[i];
            points.iter().filter(|p| self.sight.sees(photograph, p).is_some()).count()
        };
        let counts: Vec<(usize, usize)> = self.order.iter().map(|&i| (i, seen(i))).collect();
        let photograph = counts.iter().find(|(_, n)| *n == points.len()).map(|(i, _)| *i);
        let smallest = if counts.iter().any(|(_, n)| *n > 0) { SMALLEST } else { UNSEEN };
        if photograph.is_none() && side / 2.0 >= smallest {
            let half = side / 2.0;
            for (dx, dy) in [(0.0, 0.0), (half, 0.0), (0.0, half), (half, half)] {
                self.cut(Point2::new(corner.x + dx, corner.y + dy), half);
            }
            return;
        }
        self.patches.push(Patch { outline, middle, photograph });
    }
}

/// The part of an outline in a square (Sutherland & Hodgman 1974).
fn clip(outline: &[Point2<f64>], corner: Point2<f64>, side: f64) -> Vec<Point2<f64>> {
    let mut inside = outline.to_vec();
    for (axis, sign, limit) in [
        (0, 1.0, corner.x),
        (0, -1.0, -corner.x - side),
        (1, 1.0, corner.y),
        (1, -1.0, -corner.y - side),
    ] {
        let height = |p: &Point2<f64>| sign * p[axis] - limit;
        let mut out = Vec::new();
        for (a, b) in inside.iter().zip(inside.iter().cycle().skip(1)) {
            let (ha, hb) = (height(a), height(b));
            if ha >= 0.0 {
                out.push(*a);
            }
            if (ha >= 0.0) != (hb >= 0.0) {
                out.push(a + (b - a) * (ha / (ha - hb)));
            }
        }
        inside = out;
    }
    inside
}

/// The colour that a photograph has for a world point, at the exposure of the first.
fn color(photograph: &Photograph, gain: f64, world: &Point3<f64>) -> Option<[f64; 3]> {
    use collinear::camera::SensorModel;
    let p = &photograph.picture;
    let view = ImageView::<u8, 3>::new(&p.data, p.width as usize, p.height as usize).ok()?;
    let image = photograph.frame.project(world).ok()?;
    let value = sample(view, &image, Filter::Bilinear, Border::Transparent)?;
    Some(value.map(|v| f64::from(v) * gain))
}

fn mean(colors: impl Iterator<Item = [f64; 3]>) -> Option<[f64; 3]> {
    let (sum, n) = colors
        .fold(([0.0; 3], 0.0), |(s, n), c| ([s[0] + c[0], s[1] + c[1], s[2] + c[2]], n + 1.0));
    (n > 0.0).then(|| sum.map(|s| s / n))
}

/// A place whose colour is known.
struct Known {
    face: usize,
    place: Point3<f64>,
    color: [f64; 3],
}

/// The colour of a place that no photograph sees: the mean of the nearest known ones, those of its own face if it has any,
/// near in height above all, since a façade's courses are level.
fn guess(
    known: &[Known],
    face: usize,
    place: &Point3<f64>,
    up: &UnitVector3<f64>,
) -> Option<[u8; 3]> {
    const NEAREST: usize = 12;
    let far = |k: &Known| {
        let d = k.place - place;
        let height = up.dot(&d);
        (d.norm_squared() - height * height).max(0.0).sqrt() + 4.0 * height.abs()
    };
    let own = known.iter().any(|k| k.face == face);
    let candidates = known.iter().filter(|k| !own || k.face == face);
    let mut near: Vec<(f64, &Known)> = candidates.map(|k| (far(k), k)).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(NEAREST);
    let weight = |far: f64| 1.0 / (0.3 + far).powi(2);
    let total: f64 = near.iter().map(|(f, _)| weight(*f)).sum();
    let channel = |c: usize| near.iter().map(|(f, k)| weight(*f) * k.color[c]).sum::<f64>() / total;
    (!near.is_empty()).then(|| [0, 1, 2].map(|c| channel(c).round() as u8))
}

/// The faces as polygons of a scene.
pub(crate) fn polygons(
    site: &Site,
    faces: &[Face],
    sight: &Sight,
    gains: &[f64],
) -> Result<Vec<Polygon>> {
    let mut all = Vec::new();
    let mut known = Vec::new();
    for (i, target) in sight.targets().iter().enumerate() {
        let views = sight.views(i, &site.photographs);
        let seen_well = views.first().is_some_and(|v| v.pixels >= COARSE);
        let order =
            if seen_well { views.iter().map(|v| v.photograph).collect() } else { Vec::new() };
        let mut cutter = Cutter { sight, site, target, order, patches: Vec::new() };
        let [low, high] = target.bounds();
        let mut y = low.y;
        while y < high.y {
            let mut x = low.x;
            while x < high.x {
                cutter.cut(Point2::new(x, y), LARGEST);
                x += LARGEST;
            }
            y += LARGEST;
        }
        for patch in cutter.patches {
            if let Some(k) = patch.photograph {
                let corners = patch.outline.iter().map(|c| c + (patch.middle - c) * 0.3);
                let colors = corners
                    .filter_map(|c| color(&site.photographs[k], gains[k], &target.world(&c)));
                if let Some(color) = mean(colors) {
                    known.push(Known { face: i, place: target.world(&patch.middle), color });
                }
            }
            all.push((i, patch));
        }
    }
    let mut polygons = Vec::new();
    for (i, patch) in &all {
        let (Some(face), Some(target)) = (faces.get(*i), sight.targets().get(*i)) else { continue };
        let guessed = || guess(&known, *i, &target.world(&patch.middle), &site.axes.up);
        let fill = match patch.photograph {
            Some(k) => Fill::Photograph(site.photographs[k].name.clone()),
            None => match guessed() {
                Some(color) => Fill::Color(color),
                None => continue,
            },
        };
        let vertices: Vec<Point3<f64>> = patch.outline.iter().map(|p| target.world(p)).collect();
        // A sliver on the face's edge has no plane of its own, and no pixels.
        if Plane::fit(&vertices).is_err() {
            continue;
        }
        polygons.push(Polygon {
            name: Some(format!("{} {}", face.name, polygons.len())),
            vertices: vertices.iter().map(|p| (*p).into()).collect(),
            fill,
        });
    }
    Ok(polygons)
}
