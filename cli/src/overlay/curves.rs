//! Edges of the world as curves of a picture, through any sensor.

use std::f64::consts::PI;

use std::sync::Arc;

use collinear::camera::{CentralModel, Frame, SensorModel};
use collinear::nalgebra::{Point2, Point3, Vector3};
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

/// Visible parts of an edge are looked for at so many places of it where the sensor has no one centre.
const PLACES: f64 = 256.0;

/// What turns edges into curves.
#[derive(Debug)]
pub(super) struct Curves {
    eye: Eye,
    width: f64,
    height: f64,
    /// How far along an edge visible parts are looked for: an angle, or a part of the edge.
    step: f64,
}

/// What sees an edge.
#[derive(Debug)]
enum Eye {
    /// A camera with one centre sees directions alone: an arc of a great circle, which is followed by its angle.
    Central(Frame<Central>),
    /// Any other sensor sees points.
    Sensor(Arc<dyn SensorModel>),
}

/// The way from one end of an edge to the other.
enum Way {
    /// An arc: its start, the direction a quarter turn on, and its angle.
    Turn { start: Vector3<f64>, quarter: Vector3<f64>, angle: f64 },
    /// A straight line, whose length is 1.
    Straight { start: Vector3<f64>, along: Vector3<f64> },
}

impl Way {
    fn length(&self) -> f64 {
        match self {
            Self::Turn { angle, .. } => *angle,
            Self::Straight { .. } => 1.0,
        }
    }

    /// A direction in camera axes, or a point of the world.
    fn at(&self, s: f64) -> Vector3<f64> {
        match self {
            Self::Turn { start, quarter, .. } => {
                let (sine, cosine) = s.sin_cos();
                start * cosine + quarter * sine
            }
            Self::Straight { start, along } => start + along * s,
        }
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
    /// Of a camera with one centre.
    pub(super) fn of_central(frame: &Frame<Central>, size: [u32; 2]) -> Self {
        let camera = &frame.camera;
        let [width, height] = size.map(f64::from);
        let degree = 1.0_f64.to_radians();
        let step = match camera.direction(&Point2::new(0.5 * width, 0.5 * height)) {
            Ok(middle) => {
                let angle = |p: Point2<f64>| camera.direction(&p).ok().map(|d| middle.angle(&d));
                let field = border(size).filter_map(angle).fold(0.0, f64::max);
                let part = field * PART_OF_FIELD;
                if part > 0.0 { part.min(degree) } else { degree }
            }
            Err(_) => degree,
        };
        Self { eye: Eye::Central(frame.clone()), width, height, step }
    }

    /// Of any sensor.
    pub(super) fn of_sensor(sensor: Arc<dyn SensorModel>, size: [u32; 2]) -> Self {
        let [width, height] = size.map(f64::from);
        Self { eye: Eye::Sensor(sensor), width, height, step: 1.0 / PLACES }
    }

    /// The visible parts of an edge.
    pub(super) fn trace(&self, edge: &[Point3<f64>; 2]) -> Vec<Vec<Point2<f64>>> {
        let ends = match &self.eye {
            Eye::Central(frame) => edge.map(|p| frame.exterior.pose().apply(&p).coords),
            Eye::Sensor(_) => edge.map(|p| p.coords),
        };
        let mut pen = Pen::default();
        let way = match &self.eye {
            Eye::Central(_) => turn(&ends[0], &ends[1]),
            Eye::Sensor(_) => Some(Way::Straight { start: ends[0], along: ends[1] - ends[0] }),
        };
        let Some(way) = way else {
            // It points at the camera: a dot.
            let ends = ends.map(|d| self.image(&d).map(|p| vec![p, p]));
            return ends.into_iter().flatten().take(1).collect();
        };
        let count = (way.length() / self.step).ceil().clamp(1.0, MOST_PLACES);
        let place = |i: u32| {
            let s = way.length() * (f64::from(i) / count);
            (s, self.image(&way.at(s)))
        };
        let mut last = place(0);
        // Where the pen is, and what is not drawn since.
        let mut from = last.1.map(|p| (last.0, p));
        from.into_iter().for_each(|(_, p)| pen.begin(p));
        for i in 1..=count as u32 {
            let next = place(i);
            match (from, last.1, next.1) {
                (Some((s, p)), _, Some(q)) if i % PIECE == 0 || f64::from(i) >= count => {
                    self.piece(&way, [s, next.0], [p, q], DEPTH, &mut pen);
                    from = Some((next.0, q));
                }
                (Some((s, p)), Some(seen), None) => {
                    let (end, q) = self.end(&way, (last.0, seen), next.0);
                    self.piece(&way, [s, end], [p, q], DEPTH, &mut pen);
                    pen.lift();
                    from = None;
                }
                (None, _, Some(q)) => {
                    let (start, p) = self.end(&way, (next.0, q), last.0);
                    pen.begin(p);
                    self.piece(&way, [start, next.0], [p, q], DEPTH, &mut pen);
                    from = Some((next.0, q));
                }
                _ => {}
            }
            last = next;
        }
        pen.lift();
        pen.done
    }

    /// The image of a place of a way, in the picture or its margin.
    fn image(&self, place: &Vector3<f64>) -> Option<Point2<f64>> {
        let p = match &self.eye {
            Eye::Central(frame) => frame.camera.project_direction(place),
            Eye::Sensor(sensor) => sensor.project(&Point3::from(*place)),
        }
        .ok()?;
        let within = |c: f64, size: f64| (-MARGIN * size..=(1.0 + MARGIN) * size).contains(&c);
        (within(p.x, self.width) && within(p.y, self.height)).then_some(p)
    }

    /// The last visible place from one that is visible towards one that is not.
    fn end(&self, way: &Way, inside: (f64, Point2<f64>), outside: f64) -> (f64, Point2<f64>) {
        let (mut inside, mut outside) = (inside, outside);
        for _ in 0..STEPS {
            let middle = 0.5 * (inside.0 + outside);
            match self.image(&way.at(middle)) {
                Some(p) => inside = (middle, p),
                None => outside = middle,
            }
        }
        inside
    }

    /// Draws from p, where the pen is, to q.
    fn piece(
        &self,
        way: &Way,
        [s, t]: [f64; 2],
        [p, q]: [Point2<f64>; 2],
        depth: u32,
        pen: &mut Pen,
    ) {
        let probe = |part: f64| self.image(&way.at(s + (t - s) * part));
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
                self.piece(way, [s, half], [p, m], depth - 1, pen);
                self.piece(way, [half, t], [m, q], depth - 1, pen);
            }
            None => {
                let (end, m) = self.end(way, (s, p), half);
                self.piece(way, [s, end], [p, m], depth - 1, pen);
                let (start, m) = self.end(way, (t, q), half);
                pen.begin(m);
                self.piece(way, [start, t], [m, q], depth - 1, pen);
            }
        }
    }
}

/// The arc between two directions; none where they lie on one line.
fn turn(a: &Vector3<f64>, b: &Vector3<f64>) -> Option<Way> {
    let (start, end) = (a.try_normalize(0.0)?, b.try_normalize(0.0)?);
    let angle = start.cross(&end).norm().atan2(start.dot(&end));
    let quarter = (end - start * start.dot(&end)).try_normalize(f64::EPSILON)?;
    (angle < PI).then_some(Way::Turn { start, quarter, angle })
}
