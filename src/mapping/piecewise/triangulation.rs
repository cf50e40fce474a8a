//! Delaunay triangles of the control points, and the way of a row through them.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use nalgebra::{Point2, Vector2};

use crate::error::{Error, ProjectionError};
use crate::mapping::polynomial::cross;
use crate::numeric::float::unit_power;

/// Largest coordinate or difference of screen points.
const LARGEST: f64 = 1e100;

/// Triangles over control points.
///
/// The half-edge h of the triangle h / 3 leads from its corner h % 3 to the next.
#[derive(Clone, Debug)]
pub(super) struct Triangulation {
    pub(super) points: Vec<Point2<f64>>,
    /// The corners of the triangles, three by three, all turning from +y to +x.
    pub(super) corners: Vec<usize>,
    /// The same edge as a half-edge of the neighbour.
    twins: Vec<Option<usize>>,
    /// The edges of the hull through which rows enter, those that lead towards +y: where they begin, ascending, and the
    /// half-edge.
    entries: Vec<(f64, usize)>,
    /// The least and the greatest y.
    lines: [f64; 2],
}

/// Where a row meets an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing<V> {
    /// Its x.
    pub(super) x: f64,
    /// The edge's end of smaller y, and the other one.
    pub(super) ends: [V; 2],
    /// The share of the way from the one to the other.
    pub(super) share: f64,
}

impl<V: Copy> Crossing<V> {
    /// Of the edge between two corners at different sides of the line y.
    ///
    /// It is reckoned from its nearer end, so that a row through a corner meets it exactly; and from the same end
    /// in both triangles of the edge.
    pub(super) fn new(y: f64, a: (V, Point2<f64>), b: (V, Point2<f64>)) -> Self {
        let ((low, p), (high, q)) = if a.1.y <= b.1.y { (a, b) } else { (b, a) };
        let share = (y - p.y) / (q.y - p.y);
        let x = between(p.x, q.x, share);
        Self { x, ends: [low, high], share }
    }
}

/// From a to b; exact at both ends.
#[inline(always)]
pub(super) fn between(a: f64, b: f64, share: f64) -> f64 {
    if share <= 0.5 { a + share * (b - a) } else { b - (1.0 - share) * (b - a) }
}

/// The half-edge after h in its triangle.
pub(super) fn next(h: usize) -> usize {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The half-edge before h in its triangle.
pub(super) fn previous(h: usize) -> usize {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// What lies on the far side of the line through a row: every corner has a side, none is on the line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    y: f64,
    /// On the last line of all, the corners on it count as beyond.
    last: bool,
}

impl Side {
    pub(super) fn beyond(self, p: &Point2<f64>) -> bool {
        p.y > self.y || (self.last && p.y >= self.y)
    }
}

impl Triangulation {
    /// The Delaunay triangulation.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for coordinates beyond 1e100; [`Error::Degenerate`] where the points lie on one line to rounding
    /// (the measure is twice the area of the triangles over the square of their extent), or where points coincide (it is how
    /// many are corners of triangles).
    pub(super) fn new(points: &[Point2<f64>]) -> Result<Self, Error> {
        if let Some(p) = points.iter().find(|p| p.coords.amax() > LARGEST) {
            return Err(Error::OutOfRange {
                what: "coordinate of a control point",
                value: p.coords.amax(),
                expected: "at most 1e100",
            });
        }
        // To an extent of about one, exactly: what `delaunator` takes for one point is a fixed length.
        let extent = points.iter().map(|p| (p - points[0]).amax()).fold(0.0, f64::max);
        let power = unit_power(extent);
        let plain = |p: &Point2<f64>| delaunator::Point { x: p.x * power, y: p.y * power };
        let found = delaunator::triangulate(&points.iter().map(plain).collect::<Vec<_>>());
        let mut used = alloc::vec![false; points.len()];
        for &corner in &found.triangles {
            used[corner] = true;
        }
        // How wide the points' hull is against its length, and what rounding the points makes of a line.
        let area = |t: &[usize]| {
            let [ab, ac] = [1, 2].map(|k| (points[t[k]] - points[t[0]]) / extent);
            cross([ab.x, ab.y], [ac.x, ac.y]).abs()
        };
        let measure = found.triangles.chunks_exact(3).map(area).fold(0.0, |sum, a| sum + a);
        let largest = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let coarseness = if extent > 0.0 { largest / extent } else { 0.0 };
        let limit = 4.0 * f64::EPSILON * (1.0 + coarseness);
        if !(measure > limit) {
            let what = "triangulation: control points on one line";
            return Err(Error::Degenerate { what, measure, limit });
        }
        let corners = used.iter().filter(|u| **u).count();
        if corners < points.len() {
            return Err(Error::Degenerate {
                what: "triangulation: control points that coincide",
                measure: corners as f64,
                limit: points.len() as f64,
            });
        }
        let (corners, points) = (found.triangles, points.to_vec());
        let twins: Vec<Option<usize>> =
            found.halfedges.into_iter().map(|h| (h != delaunator::EMPTY).then_some(h)).collect();
        let lines = points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| {
            [low.min(p.y), high.max(p.y)]
        });
        let y = |h: usize| points[corners[h]].y;
        let mut entries: Vec<(f64, usize)> = (0..corners.len())
            .filter(|&h| twins[h].is_none() && y(h) < y(next(h)))
            .map(|h| (y(h), h))
            .collect();
        entries.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { points, corners, twins, entries, lines })
    }

    /// The corners of a triangle.
    pub(super) fn triangle(&self, t: usize) -> [Point2<f64>; 3] {
        core::array::from_fn(|k| self.points[self.corners[3 * t + k]])
    }

    /// The number of triangles.
    pub(super) fn len(&self) -> usize {
        self.corners.len() / 3
    }

    /// The triangle at the other side of the half-edge.
    pub(super) fn neighbour(&self, h: usize) -> Option<usize> {
        self.twins[h].map(|twin| twin / 3)
    }

    /// Every edge once: its two ends.
    pub(super) fn edges(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.corners.len())
            .filter(|&h| self.twins[h].is_none_or(|twin| h < twin))
            .map(|h| [self.corners[h], self.corners[next(h)]])
    }

    /// Where the row meets the edge of a half-edge.
    pub(super) fn crossing(&self, y: f64, h: usize) -> Crossing<usize> {
        let end = |h: usize| (self.corners[h], self.points[self.corners[h]]);
        Crossing::new(y, end(h), end(next(h)))
    }

    pub(super) fn side(&self, y: f64) -> Side {
        Side { y, last: y == self.lines[1] }
    }

    /// Follows the line y through the triangles, left to right: `visit` is given the half-edges, of one triangle, through
    /// which the line comes and goes.
    ///
    /// The way is found by the sides on which the corners lie alone, without a tolerance, so that it is never lost.
    pub(super) fn walk(
        &self,
        y: f64,
        mut visit: impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<(), ProjectionError> {
        let [low, high] = self.lines;
        if !(y >= low && y <= high) {
            let far = (low - y).max(y - high);
            return Err(outside(far));
        }
        let side = self.side(y);
        let beyond = |h: usize| side.beyond(&self.points[self.corners[h]]);
        let after = self.entries.partition_point(|e| if side.last { e.0 < y } else { e.0 <= y });
        let Some(&(_, mut entry)) = after.checked_sub(1).and_then(|i| self.entries.get(i)) else {
            return Err(outside(0.0));
        };
        // No row meets a triangle twice.
        for _ in 0..self.len() {
            let (forward, back) = (next(entry), previous(entry));
            if beyond(entry) == beyond(forward) {
                return Err(outside(0.0));
            }
            let exit = if beyond(back) == beyond(entry) { forward } else { back };
            if visit(entry, exit).is_break() {
                break;
            }
            match self.twins[exit] {
                Some(twin) => entry = twin,
                None => break,
            }
        }
        Ok(())
    }

    /// The triangle in which a point lies, by the half-edges through which its line comes and goes.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`] with how far outside the hull the point is along its row or column, limit 0;
    /// [`ProjectionError::NotFinite`].
    pub(super) fn locate(&self, p: &Point2<f64>) -> Result<[usize; 2], ProjectionError> {
        if !(p.x.is_finite() && p.y.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let mut found = Err(outside(0.0));
        let mut begun = false;
        self.walk(p.y, |entry, exit| {
            if !begun {
                begun = true;
                let left = self.crossing(p.y, entry).x;
                if p.x < left {
                    found = Err(outside(left - p.x));
                    return ControlFlow::Break(());
                }
            }
            let right = self.crossing(p.y, exit).x;
            let inside = p.x < right || (p.x == right && self.twins[exit].is_none());
            found = if inside { Ok([entry, exit]) } else { Err(outside(p.x - right)) };
            if inside { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        found
    }

    /// Whether a row leaves the triangles through the half-edge.
    pub(super) fn ends(&self, exit: usize) -> bool {
        self.twins[exit].is_none()
    }

    /// The vector along a half-edge.
    pub(super) fn along(&self, h: usize) -> Vector2<f64> {
        self.points[self.corners[next(h)]] - self.points[self.corners[h]]
    }
}

fn outside(distance: f64) -> ProjectionError {
    ProjectionError::OutsideDomain { value: distance, limit: 0.0 }
}

/// The gradients of the three barycentric coordinates of a triangle.
///
/// # Errors
/// [`ProjectionError::NotFinite`] for a triangle without area.
pub(super) fn barycentric_gradients(
    corners: &[Point2<f64>; 3],
) -> Result<[Vector2<f64>; 3], ProjectionError> {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let area = cross([ab.x, ab.y], [ac.x, ac.y]);
    let gradients = [c - b, a - c, b - a].map(|e| Vector2::new(-e.y, e.x) / area);
    let finite = gradients.iter().all(|g| g.x.is_finite() && g.y.is_finite());
    if finite { Ok(gradients) } else { Err(ProjectionError::NotFinite) }
}
