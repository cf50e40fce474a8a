//! Edges of the world as lines of a picture.

use std::sync::Arc;

use anyhow::{Result, anyhow};
use collinear::camera::Distortion;
use collinear::camera::{CentralModel, SensorModel};
use collinear::geometry::Pose;
use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear_io::convert::Camera;
use collinear_io::sensor::SensorFile;

use super::Figure;
use super::curves::Curves;
use crate::photograph::Photograph;
use crate::rectify::border;

/// A line may leave its curve by this much, in pixels; half of what is promised, since three places of it are measured.
pub(super) const TOLERANCE: f64 = 0.05;

/// A line is halved at most so often. Each time divides its error by four: one of ten thousand pixels needs nine.
const DEPTH: u32 = 12;

/// Lines are drawn as far as this part beyond the picture.
pub(super) const MARGIN: f64 = 0.1;

/// The near plane, as a part of the distance of the farthest vertex.
const NEAR: f64 = 1e-9;

/// Lines stop this part before the radius where the lens folds back.
const BEFORE_FOLD: f64 = 1e-9;

/// Steps of a search along an edge: enough for the last bit of its parameter.
pub(super) const STEPS: u32 = 128;

/// What turns edges into lines.
#[derive(Debug)]
pub(super) struct Tracer {
    camera: Photograph,
    /// Where it is neither a perspective with Brown's lens nor parallel.
    curves: Option<Curves>,
    width: f64,
    height: f64,
    /// The cone about the z axis in which edges are drawn: the tangent of its angle.
    reach: f64,
    near: f64,
}

impl Tracer {
    pub(super) fn new(file: &SensorFile, figures: &[Figure]) -> Result<Self> {
        let (camera, size) = (Photograph::new(file)?, file.size());
        let reach = match camera.camera() {
            Some(Camera::Pinhole(frame)) => reach(size, &frame.camera, f64::INFINITY)?,
            Some(Camera::Brown(frame)) => {
                reach(size, &frame.camera, frame.camera.distortion().fold_radius())?
            }
            _ => f64::INFINITY,
        };
        let curves = match &camera {
            Photograph::Other(sensor) => Some(Curves::of_sensor(Arc::clone(sensor), size)),
            Photograph::Camera(camera) => match camera.as_ref() {
                Camera::Central(frame) => Some(Curves::of_central(frame, size)),
                _ => None,
            },
        };
        // Of a camera only: other sensors have no near plane.
        let center = camera.eye(size).unwrap_or_else(Point3::origin);
        let distance = |p: &Point3<f64>| (p - center).norm();
        let farthest =
            figures.iter().flat_map(|f| f.edges.iter().flatten()).map(distance).fold(0.0, f64::max);
        let [width, height] = size.map(f64::from);
        Ok(Self { camera, curves, width, height, reach, near: NEAR * farthest })
    }

    /// The image of a point, if it is in the picture.
    pub(super) fn point(&self, world: &Point3<f64>) -> Option<Point2<f64>> {
        let p = self.camera.sensor().project(world).ok()?;
        let inside = (0.0..self.width).contains(&p.x) && (0.0..self.height).contains(&p.y);
        inside.then_some(p)
    }

    /// The visible parts of an edge.
    pub(super) fn trace(&self, edge: &[Point3<f64>; 2]) -> Vec<Vec<Point2<f64>>> {
        match &self.curves {
            Some(curves) => curves.trace(edge),
            None => self.trace_one(edge).into_iter().collect(),
        }
    }

    /// The visible part of an edge, of which there is no more than one.
    fn trace_one(&self, edge: &[Point3<f64>; 2]) -> Option<Vec<Point2<f64>>> {
        match self.camera.camera()? {
            Camera::Pinhole(frame) => {
                let [a, b] = self.ideal(frame.exterior.pose(), edge)?;
                Some(vec![image(&frame.camera, &a)?, image(&frame.camera, &b)?])
            }
            Camera::Brown(frame) => {
                let [a, b] = self.ideal(frame.exterior.pose(), edge)?;
                bend(&frame.camera, a, b)
            }
            Camera::Central(_) => None,
            Camera::Orthographic(camera) => {
                let [a, b] = edge.map(|p| camera.project(&p).ok());
                self.inside(a?, b?).map(Vec::from)
            }
        }
    }

    /// The ends of an edge's visible part as (X/Z, Y/Z): what of it lies in the cone and beyond the near plane.
    fn ideal(&self, pose: &Pose, edge: &[Point3<f64>; 2]) -> Option<[Point2<f64>; 2]> {
        let [a, b] = edge.map(|p| pose.apply(&p).coords);
        let at = |t: f64| a * (1.0 - t) + b * t;
        // Positive inside. A cone is convex, so this is concave along the edge: one maximum, one interval.
        let depth = |t: f64| {
            let p = at(t);
            (self.reach * p.z - p.xy().norm()).min(p.z - self.near)
        };
        let peak = peak(&depth)?;
        let ends = [end(&depth, peak, 0.0), end(&depth, peak, 1.0)];
        Some(ends.map(|t| {
            let p = at(t);
            Point2::from(p.xy() / p.z)
        }))
    }

    /// The part of a straight line within the picture and its margin (Liang & Barsky 1984).
    fn inside(&self, a: Point2<f64>, b: Point2<f64>) -> Option<[Point2<f64>; 2]> {
        let d = b - a;
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (start, slope, size) in [(a.x, d.x, self.width), (a.y, d.y, self.height)] {
            let (low, high) = (-MARGIN * size - start, (1.0 + MARGIN) * size - start);
            if slope == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
            } else {
                let (s, t) = (low / slope, high / slope);
                from = from.max(s.min(t));
                to = to.min(s.max(t));
            }
        }
        (from < to).then(|| [a + d * from, a + d * to])
    }
}

/// The tangent of the cone that holds the picture and its margin, within the fold.
fn reach(size: [u32; 2], camera: &dyn CentralModel, fold: f64) -> Result<f64> {
    let mut largest = 0.0_f64;
    for p in border(size) {
        // No ideal point has this image: the picture reaches beyond the fold.
        let Ok(d) = camera.direction(&p) else { return Ok(fold * (1.0 - BEFORE_FOLD)) };
        largest = largest.max(d.xy().norm() / d.z);
    }
    let reach = (largest * (1.0 + MARGIN)).min(fold * (1.0 - BEFORE_FOLD));
    if reach.is_finite() && reach > 0.0 {
        Ok(reach)
    } else {
        Err(anyhow!("the camera's field of view has no finite angle"))
    }
}

/// The image of an ideal point.
fn image(camera: &dyn CentralModel, ideal: &Point2<f64>) -> Option<Point2<f64>> {
    camera.project_direction(&Vector3::new(ideal.x, ideal.y, 1.0)).ok()
}

/// The curve that a lens makes of a straight line of the ideal picture.
fn bend(camera: &dyn CentralModel, a: Point2<f64>, b: Point2<f64>) -> Option<Vec<Point2<f64>>> {
    let at = |s: f64| image(camera, &Point2::from(a.coords * (1.0 - s) + b.coords * s));
    let (first, last) = (at(0.0)?, at(1.0)?);
    let mut line = vec![first];
    let mut open = vec![([0.0, 1.0], [first, last], DEPTH)];
    while let Some(([s, t], [p, q], depth)) = open.pop() {
        let probe = |part: f64| at(s + (t - s) * part);
        let [early, middle, late] = [probe(0.25)?, probe(0.5)?, probe(0.75)?];
        let off = [early, middle, late].map(|m| distance(&m, &p, &q));
        if off.iter().all(|d| *d <= TOLERANCE) || depth == 0 {
            line.push(q);
        } else {
            let half = s + (t - s) * 0.5;
            open.push(([half, t], [middle, q], depth - 1));
            open.push(([s, half], [p, middle], depth - 1));
        }
    }
    Some(line)
}

/// Distance of a point from a line segment.
pub(super) fn distance(p: &Point2<f64>, a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    let (d, r) = (b - a, p - a);
    let along = (d.dot(&r) / d.norm_squared()).clamp(0.0, 1.0);
    // A segment without length has no direction.
    if along.is_nan() { r.norm() } else { (r - d * along).norm() }
}

/// A parameter in [0, 1] at which a concave function is positive.
fn peak(f: &impl Fn(f64) -> f64) -> Option<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    for t in [0.0, 1.0, 0.5] {
        if f(t) > 0.0 {
            return Some(t);
        }
    }
    for _ in 0..STEPS {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        let (fa, fb) = (f(a), f(b));
        if fa > 0.0 {
            return Some(a);
        }
        if fb > 0.0 {
            return Some(b);
        }
        if fa < fb { low = a } else { high = b }
    }
    None
}

/// The last positive parameter from `inside` towards `outside`.
fn end(f: &impl Fn(f64) -> f64, inside: f64, outside: f64) -> f64 {
    if f(outside) > 0.0 {
        return outside;
    }
    let (mut inside, mut outside) = (inside, outside);
    for _ in 0..STEPS {
        let middle = 0.5 * (inside + outside);
        if f(middle) > 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    inside
}
