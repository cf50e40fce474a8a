//! Planes in a cloud of points: the largest ones, and those of a building.

use collinear::Error;
use collinear::geometry::Plane;
use collinear::nalgebra::{Point3, UnitVector3, Vector3};
use collinear::numeric::consensus::{ConsensusOptions, Estimator, search};

/// Planes through three points, refined by a least-squares fit.
struct Planes<'a> {
    points: &'a [Point3<f64>],
}

impl Estimator for Planes<'_> {
    type Model = Plane;
    const SAMPLE: usize = 3;

    fn len(&self) -> usize {
        self.points.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<Plane>) {
        if let [Some(a), Some(b), Some(c)] = [0, 1, 2].map(|i| self.points.get(*sample.get(i)?))
            && let Ok(plane) = Plane::through(a, b, c)
        {
            models.push(plane);
        }
    }

    fn squared_residual(&self, plane: &Plane, index: usize) -> f64 {
        self.points.get(index).map_or(f64::INFINITY, |p| plane.signed_distance(p).powi(2))
    }

    fn refine(&self, _: &Plane, inliers: &[bool]) -> Option<Plane> {
        Plane::fit(&select(self.points, inliers, true)).ok().map(|fit| fit.plane)
    }
}

/// Planes that contain one given direction and lie near another: lines, seen along the first, through two points.
struct Level<'a> {
    /// Moved along the first direction into one plane across it.
    flattened: &'a [Point3<f64>],
    along: UnitVector3<f64>,
    near: UnitVector3<f64>,
    cosine: f64,
}

impl Estimator for Level<'_> {
    type Model = Plane;
    const SAMPLE: usize = 2;

    fn len(&self) -> usize {
        self.flattened.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<Plane>) {
        if let [Some(a), Some(b)] = [0, 1].map(|i| self.flattened.get(*sample.get(i)?))
            && let Ok(plane) = Plane::through(a, b, &(b + *self.along))
            && plane.normal().dot(&self.near).abs() >= self.cosine
        {
            models.push(plane);
        }
    }

    fn squared_residual(&self, plane: &Plane, index: usize) -> f64 {
        self.flattened.get(index).map_or(f64::INFINITY, |p| plane.signed_distance(p).powi(2))
    }

    fn refine(&self, _: &Plane, inliers: &[bool]) -> Option<Plane> {
        // Each point on both sides, far enough away for the direction to be the plane's own.
        const FAR: f64 = 1e3;
        let on = select(self.flattened, inliers, true);
        let both: Vec<_> =
            on.iter().flat_map(|p| [p + *self.along * FAR, p - *self.along * FAR]).collect();
        Plane::fit(&both).ok().map(|fit| fit.plane)
    }
}

/// Planes of one given normal, one point each, refined by the mean of their offsets.
struct Sheets<'a> {
    offsets: &'a [f64],
}

impl Estimator for Sheets<'_> {
    type Model = f64;
    const SAMPLE: usize = 1;

    fn len(&self) -> usize {
        self.offsets.len()
    }

    fn minimal(&self, sample: &[usize], models: &mut Vec<f64>) {
        models.extend(sample.iter().filter_map(|&i| self.offsets.get(i)));
    }

    fn squared_residual(&self, offset: &f64, index: usize) -> f64 {
        self.offsets.get(index).map_or(f64::INFINITY, |o| (o - offset).powi(2))
    }

    fn refine(&self, _: &f64, inliers: &[bool]) -> Option<f64> {
        let chosen: Vec<f64> =
            self.offsets.iter().zip(inliers).filter(|(_, on)| **on).map(|(o, _)| *o).collect();
        (!chosen.is_empty()).then(|| chosen.iter().sum::<f64>() / chosen.len() as f64)
    }
}

/// A plane and the points that lie on it.
pub(crate) struct Found {
    /// The plane.
    pub(crate) plane: Plane,
    /// The points within the threshold of it.
    pub(crate) points: Vec<Point3<f64>>,
    /// Root mean square of their distances, world units.
    pub(crate) rms: f64,
}

impl Found {
    fn new(plane: Plane, points: Vec<Point3<f64>>) -> Self {
        let sum: f64 = points.iter().map(|p| plane.signed_distance(p).powi(2)).sum();
        let rms = (sum / points.len() as f64).sqrt();
        Self { plane, points, rms }
    }
}

/// How a search for planes goes.
#[derive(Clone, Copy)]
pub(crate) struct Search {
    /// The distance from a plane up to which a point lies on it, world units.
    pub(crate) threshold: f64,
    /// The points that a plane must have.
    pub(crate) least: usize,
}

fn select(points: &[Point3<f64>], chosen: &[bool], on: bool) -> Vec<Point3<f64>> {
    points.iter().zip(chosen).filter(|(_, c)| **c == on).map(|(p, _)| *p).collect()
}

fn options(search: Search, sample: usize) -> ConsensusOptions {
    ConsensusOptions {
        threshold: search.threshold,
        max_trials: 100_000,
        min_support: search.least.saturating_sub(sample),
        ..ConsensusOptions::default()
    }
}

/// Planes one after another, each the largest among the points that the ones before it have left.
pub(crate) fn one_after_another(points: &[Point3<f64>], how: Search, most: usize) -> Vec<Found> {
    let mut rest = points.to_vec();
    let mut planes = Vec::new();
    while planes.len() < most
        && let Ok(best) = search(&Planes { points: &rest }, &options(how, 3))
    {
        planes.push(Found::new(best.model, select(&rest, &best.inliers, true)));
        rest = select(&rest, &best.inliers, false);
    }
    planes
}

/// Planes of one normal, one after another; and the points off them all.
pub(crate) fn sheets(
    points: &[Point3<f64>],
    normal: UnitVector3<f64>,
    how: Search,
) -> (Vec<Found>, Vec<Point3<f64>>) {
    let mut rest = points.to_vec();
    let mut planes = Vec::new();
    loop {
        let offsets: Vec<f64> = rest.iter().map(|p| normal.dot(&p.coords)).collect();
        let Ok(best) = search(&Sheets { offsets: &offsets }, &options(how, 1)) else { break };
        let on = select(&rest, &best.inliers, true);
        let sum = on.iter().fold(Vector3::zeros(), |s, p| s + p.coords);
        let Ok(plane) = Plane::from_point_and_normal(Point3::from(sum / on.len() as f64), *normal)
        else {
            break;
        };
        planes.push(Found::new(plane, on));
        rest = select(&rest, &best.inliers, false);
    }
    (planes, rest)
}

/// How much the points crowd into sheets across a direction: the pairs whose offsets along it differ by less than a
/// width, weighted from one down to zero with the difference.
fn crowding(points: &[Point3<f64>], direction: &Vector3<f64>, width: f64) -> f64 {
    let mut offsets: Vec<f64> = points.iter().map(|p| direction.dot(&p.coords)).collect();
    offsets.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for (i, a) in offsets.iter().enumerate() {
        for b in offsets.iter().skip(i + 1) {
            if b - a >= width {
                break;
            }
            sum += 1.0 - (b - a) / width;
        }
    }
    sum
}

/// The direction with the highest score, near `start`: within `reach` radians on either of two axes.
fn best_direction(
    start: UnitVector3<f64>,
    reach: f64,
    score: impl Fn(&UnitVector3<f64>) -> f64,
) -> UnitVector3<f64> {
    const STEPS: i32 = 20;
    let (mut best, mut reach) = (start, reach);
    // Three rounds bring 15° to hundredths of a degree.
    for _ in 0..3 {
        let across = if best.z.abs() < 0.7 { Vector3::z() } else { Vector3::x() };
        let right = UnitVector3::new_normalize(across.cross(&best));
        let up = best.cross(&right);
        let step = reach / f64::from(STEPS);
        let candidates = (-STEPS..=STEPS).flat_map(|i| (-STEPS..=STEPS).map(move |j| (i, j)));
        let scored = candidates.map(|(i, j)| {
            let tilted = *best + *right * (f64::from(i) * step) + up * (f64::from(j) * step);
            let n = UnitVector3::new_normalize(tilted);
            (score(&n), n)
        });
        best = scored.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(best, |(_, n)| n);
        reach = 2.0 * step;
    }
    best
}

/// The axes of a building: unit vectors in world coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    /// To the right, for one who looks at the façade.
    pub(crate) right: UnitVector3<f64>,
    /// Horizontally into the façade.
    pub(crate) inward: UnitVector3<f64>,
    /// Up.
    pub(crate) up: UnitVector3<f64>,
}

/// The axes of a building, from points alone. They crowd across the direction into the façade, since its walls are
/// parallel; across the vertical, since cornices, capitals and steps have common heights; and across the third direction,
/// since doors and columns have common edges.
///
/// Ornament stands out farther at the head or the foot of a wall, so that sheets of points lean. The vertical therefore
/// comes from the heights and the edges, looked for within 5° of the walls' own, and the direction into the façade is
/// made horizontal.
pub(crate) fn axes(points: &[Point3<f64>], wall: &Plane, width: f64) -> Axes {
    let normal = best_direction(wall.normal(), 15_f64.to_radians(), |n| crowding(points, n, width));
    let upright = UnitVector3::new_normalize(Vector3::z() - *normal * normal.z);
    let up = best_direction(upright, 5_f64.to_radians(), |up| {
        let right = UnitVector3::new_normalize(normal.cross(up));
        crowding(points, up, 2.0 * width) + crowding(points, &right, 2.0 * width)
    });
    let inward = UnitVector3::new_normalize(*normal - *up * normal.dot(&up));
    Axes { right: UnitVector3::new_normalize(inward.cross(&up)), inward, up }
}

/// The plane with most points that contains the direction to the right and rises by `slope` (radians, within 6°) into the
/// façade.
pub(crate) fn rising(
    points: &[Point3<f64>],
    axes: &Axes,
    slope: f64,
    how: Search,
) -> Result<Found, Error> {
    let flattened: Vec<_> =
        points.iter().map(|p| p - *axes.right * axes.right.dot(&p.coords)).collect();
    let normal = *axes.up * slope.cos() - *axes.inward * slope.sin();
    let level = Level {
        flattened: &flattened,
        along: axes.right,
        near: UnitVector3::new_normalize(normal),
        cosine: 6_f64.to_radians().cos(),
    };
    let best = search(&level, &options(how, 2))?;
    let plane =
        if best.model.normal().dot(&axes.up) > 0.0 { best.model } else { best.model.flipped() };
    Ok(Found::new(plane, select(points, &best.inliers, true)))
}
