//! Edges of the world as curves of a picture, through any model with one projection centre.

use std::f64::consts::PI;

use collinear::camera::CentralModel;
use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear::{camera::Frame, geometry::Pose};
use collinear_io::camera::CameraFile;
use collinear_io::convert::Central;

use super::lines::{MARGIN, STEPS, TOLERANCE, distance};
use crate::rectify::border;

/// Visible parts of an edge are looked for at this part of the picture's field, and at every degree.
const PART_OF_FIELD: f64 = 1.0 / 32.0;

/// A piece of a line, before it is halved, goes over so many of these places at most.
const PIECE: u32 = 16;

/// A piece is halved at most so often: down to the 4096th part of the way between two places.
const DEPTH: u32 = 16;

/// At most so many places of an edge are looked at for that.
const MOST_PLACES: f64 = 4096.0;

/// Pixels between neighbouring points of a curve that are no jump, as over a panorama's seam. Where a picture is smooth they
/// are a thousand times nearer.
const JUMP: f64 = 1.0;

/// A middle of a piece may lie so far from half way, as a part of the piece.
const UNEVEN: f64 = 0.25;

/// What turns edges into curves.
///
/// A camera with one centre sees of an edge its directions alone: an arc of a great circle, which is followed by its angle.
#[derive(Debug)]
pub(super) struct Curves {
    camera: Central,
    pose: Pose,
    width: f64,
    height: f64,
    /// The angle at which visible parts are looked for.
    step: f64,
}

/// An arc: its start, the direction a quarter turn on, and its angle.
struct Arc {
    start: Vector3<f64>,
    quarter: Vector3<f64>,
    angle: f64,
}

impl Arc {
    fn at(&self, angle: f64) -> Vector3<f64> {
        let (sine, cosine) = angle.sin_cos();
        self.start * cosine + self.quarter * sine
    }
}

/// Lines while they are drawn.
#[derive(Default)]
struct Pen {
    done: Vec<Vec<Point2<f64>>>,
    line: Vec<Point2<f64>>,
}

impl Pen {
    /// Begins a line.
    fn begin(&mut self, p: Point2<f64>) {
        self.lift();
        self.line.push(p);
    }

    /// Ends the line. A single point is none.
    fn lift(&mut self) {
        let line = std::mem::take(&mut self.line);
        if line.len() > 1 {
            self.done.push(line);
        }
    }
}

impl Curves {
    pub(super) fn new(file: &CameraFile, frame: &Frame<Central>) -> Self {
        let camera = frame.camera.clone();
        let (width, height) = (f64::from(file.width), f64::from(file.height));
        let degree = 1.0_f64.to_radians();
        let step = match camera.direction(&Point2::new(0.5 * width, 0.5 * height)) {
            Ok(middle) => {
                let angle = |p: Point2<f64>| camera.direction(&p).ok().map(|d| middle.angle(&d));
                let field = border([file.width, file.height]).filter_map(angle).fold(0.0, f64::max);
                let part = field * PART_OF_FIELD;
                if part > 0.0 { part.min(degree) } else { degree }
            }
            Err(_) => degree,
        };
        Self { camera, pose: *frame.exterior.pose(), width, height, step }
    }

    /// The visible parts of an edge.
    pub(super) fn trace(&self, edge: &[Point3<f64>; 2]) -> Vec<Vec<Point2<f64>>> {
        let [a, b] = edge.map(|p| self.pose.apply(&p).coords);
        let mut pen = Pen::default();
        let Some(arc) = arc(&a, &b) else {
            // It points at the camera: a dot.
            let ends = [a, b].map(|d| self.image(&d).map(|p| vec![p, p]));
            return ends.into_iter().flatten().take(1).collect();
        };
        let count = (arc.angle / self.step).ceil().clamp(1.0, MOST_PLACES);
        let place = |i: u32| {
            let angle = arc.angle * (f64::from(i) / count);
            (angle, self.image(&arc.at(angle)))
        };
        let mut last = place(0);
        // Where the pen is, and what is not drawn since.
        let mut from = last.1.map(|p| (last.0, p));
        from.into_iter().for_each(|(_, p)| pen.begin(p));
        for i in 1..=count as u32 {
            let next = place(i);
            match (from, last.1, next.1) {
                (Some((s, p)), _, Some(q)) if i % PIECE == 0 || f64::from(i) >= count => {
                    self.piece(&arc, [s, next.0], [p, q], DEPTH, &mut pen);
                    from = Some((next.0, q));
                }
                (Some((s, p)), Some(seen), None) => {
                    let (end, q) = self.end(&arc, (last.0, seen), next.0);
                    self.piece(&arc, [s, end], [p, q], DEPTH, &mut pen);
                    pen.lift();
                    from = None;
                }
                (None, _, Some(q)) => {
                    let (start, p) = self.end(&arc, (next.0, q), last.0);
                    pen.begin(p);
                    self.piece(&arc, [start, next.0], [p, q], DEPTH, &mut pen);
                    from = Some((next.0, q));
                }
                _ => {}
            }
            last = next;
        }
        pen.lift();
        pen.done
    }

    /// The image of a direction, in the picture or its margin.
    fn image(&self, direction: &Vector3<f64>) -> Option<Point2<f64>> {
        let p = self.camera.project_direction(direction).ok()?;
        let within = |c: f64, size: f64| (-MARGIN * size..=(1.0 + MARGIN) * size).contains(&c);
        (within(p.x, self.width) && within(p.y, self.height)).then_some(p)
    }

    /// The last visible place from one that is visible towards one that is not.
    fn end(&self, arc: &Arc, inside: (f64, Point2<f64>), outside: f64) -> (f64, Point2<f64>) {
        let (mut inside, mut outside) = (inside, outside);
        for _ in 0..STEPS {
            let middle = 0.5 * (inside.0 + outside);
            match self.image(&arc.at(middle)) {
                Some(p) => inside = (middle, p),
                None => outside = middle,
            }
        }
        inside
    }

    /// Draws from p, where the pen is, to q.
    fn piece(
        &self,
        arc: &Arc,
        [s, t]: [f64; 2],
        [p, q]: [Point2<f64>; 2],
        depth: u32,
        pen: &mut Pen,
    ) {
        let probe = |part: f64| self.image(&arc.at(s + (t - s) * part));
        let [early, middle, late] = [0.25, 0.5, 0.75].map(probe);
        if let (Some(early), Some(middle), Some(late)) = (early, middle, late) {
            let length = (q - p).norm();
            let uneven = (middle - (p + (q - p) * 0.5)).norm();
            let on = [early, middle, late].iter().all(|m| distance(m, &p, &q) <= TOLERANCE);
            if on && uneven <= UNEVEN * length + TOLERANCE {
                return pen.line.push(q);
            }
            if depth == 0 {
                return if length > JUMP { pen.begin(q) } else { pen.line.push(q) };
            }
        } else if depth == 0 {
            return pen.begin(q);
        }
        let half = s + (t - s) * 0.5;
        match middle {
            Some(m) => {
                self.piece(arc, [s, half], [p, m], depth - 1, pen);
                self.piece(arc, [half, t], [m, q], depth - 1, pen);
            }
            None => {
                let (end, m) = self.end(arc, (s, p), half);
                self.piece(arc, [s, end], [p, m], depth - 1, pen);
                let (start, m) = self.end(arc, (t, q), half);
                pen.begin(m);
                self.piece(arc, [start, t], [m, q], depth - 1, pen);
            }
        }
    }
}

/// The arc between two directions; none where they lie on one line.
fn arc(a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Arc> {
    let (start, end) = (a.try_normalize(0.0)?, b.try_normalize(0.0)?);
    let angle = start.cross(&end).norm().atan2(start.dot(&end));
    let quarter = (end - start * start.dot(&end)).try_normalize(f64::EPSILON)?;
    (angle < PI).then_some(Arc { start, quarter, angle })
}
