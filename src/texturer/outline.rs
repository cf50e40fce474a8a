//! Outlines on the grid of snapped vertices: whether one crosses itself, and triangles that cover it. No floating-point number decides.

use alloc::collections::BTreeSet;
use alloc::vec;
use alloc::vec::Vec;
use core::cmp::Ordering;
use core::ops::Bound::{Excluded, Unbounded};

use super::scan::Snapped;
use crate::numeric::float;

/// Twice the area of a, b, c, positive from x to y. Coordinates up to 2²⁹ leave it exact.
fn side(a: Snapped, b: Snapped, c: Snapped) -> i64 {
    let d = |p: Snapped, k: usize| i64::from(p[k]) - i64::from(a[k]);
    d(b, 0) * d(c, 1) - d(b, 1) * d(c, 0)
}

/// An edge, from its end with the smaller x; of a vertical one, with the smaller y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Edge {
    left: Snapped,
    right: Snapped,
    number: usize,
}

impl Ord for Edge {
    /// By y where both are. Edges without a common point have one order wherever both are.
    fn cmp(&self, other: &Self) -> Ordering {
        if self.number == other.number {
            return Ordering::Equal;
        }
        let (first, second) = if self.left <= other.left { (self, other) } else { (other, self) };
        let above = match side(first.left, first.right, second.left) {
            0 => side(first.left, first.right, second.right),
            side => side,
        };
        let order = 0.cmp(&above).then(first.number.cmp(&second.number));
        if first.number == self.number { order } else { order.reverse() }
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Edge {
    fn holds(&self, p: Snapped) -> bool {
        side(self.left, self.right, p) == 0
            && (0..2).all(|k| {
                let [a, b] = [self.left[k], self.right[k]];
                (a.min(b)..=a.max(b)).contains(&p[k])
            })
    }

    /// Whether two edges of an outline of n have more in common than neighbours have, their vertex.
    fn touches(&self, other: &Self, n: usize) -> bool {
        let apart = self.number.abs_diff(other.number);
        if apart == 1 || apart + 1 == n {
            // Neighbours that run back over each other: an end of one is on the other, besides the vertex.
            let ends = [self.left, self.right];
            let outer = |e: &Self| [e.left, e.right].into_iter().find(|p| !ends.contains(p));
            let own = ends.into_iter().find(|p| ![other.left, other.right].contains(p));
            return match (own, outer(other)) {
                (Some(own), Some(outer)) => self.holds(outer) || other.holds(own),
                _ => true,
            };
        }
        let of = |e: &Self, f: &Self| [f.left, f.right].map(|p| side(e.left, e.right, p).signum());
        let ([a, b], [c, d]) = (of(self, other), of(other, self));
        // Each edge's ends on two sides of the other; or an end of one on the other.
        (a * b < 0 && c * d < 0)
            || self.holds(other.left)
            || self.holds(other.right)
            || other.holds(self.left)
            || other.holds(self.right)
    }
}

/// Whether edges that are no neighbours have a point in common (Shamos & Hoey 1976): a line sweeps over the edges, and of those on
/// it two that come to lie side by side are looked at.
pub(super) fn crosses_itself(vertices: &[Snapped]) -> bool {
    let n = vertices.len();
    if n < 4 {
        return false;
    }
    let mut edges = Vec::with_capacity(n);
    let next = vertices.iter().cycle().skip(1);
    for (number, (a, b)) in vertices.iter().zip(next).enumerate() {
        match a.cmp(b) {
            // The edges before and after it meet.
            Ordering::Equal => return true,
            Ordering::Less => edges.push(Edge { left: *a, right: *b, number }),
            Ordering::Greater => edges.push(Edge { left: *b, right: *a, number }),
        }
    }
    // At one point edges begin before others end.
    let mut events: Vec<(Snapped, bool, Edge)> =
        edges.iter().flat_map(|e| [(e.left, false, *e), (e.right, true, *e)]).collect();
    events.sort_unstable_by_key(|(at, ends, edge)| (*at, *ends, edge.number));
    let mut active: BTreeSet<Edge> = BTreeSet::new();
    for (_, ends, edge) in events {
        let below = active.range(..edge).next_back();
        let above = active.range((Excluded(edge), Unbounded)).next();
        let touch =
            |a: Option<&Edge>, b: Option<&Edge>| a.zip(b).is_some_and(|(a, b)| a.touches(b, n));
        if if ends {
            touch(below, above)
        } else {
            touch(below, Some(&edge)) || touch(Some(&edge), above)
        } {
            return true;
        }
        if ends {
            active.remove(&edge);
        } else {
            active.insert(edge);
        }
    }
    false
}

/// Triangles that cover an outline, as indices of its vertices, by cutting off ears (Meisters 1975), that of the lowest number first;
/// an outline that crosses itself is cut as far as it goes. `turn` is 1 where the vertices turn from y to x, −1 where they turn from x
/// to y.
pub(super) fn triangles(vertices: &[Snapped], turn: i64) -> Vec<[usize; 3]> {
    let n = vertices.len();
    if n < 3 || turn == 0 {
        return Vec::new();
    }
    let at = |i: usize| vertices.get(i).copied().unwrap_or_default();
    let cross = |[a, b, c]: [usize; 3]| -turn * side(at(a), at(b), at(c));
    let mut ring = Ring::new(n);
    // A convex vertex in a triangle of neighbours has one that is not convex in there with it, unless the outline crosses itself.
    let all = crosses_itself(vertices);
    let mut grid = Grid::new(vertices, |i| all || cross(ring.corner(i)) <= 0);
    let mut triangles = Vec::with_capacity(n - 2);
    // Vertices that may be ears, and for each vertex those that are none while it is there.
    let mut open: BTreeSet<usize> = (0..n).collect();
    let mut waiting: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut lowest = 0;
    for _ in 2..n {
        let ear = loop {
            let Some(vertex) = open.pop_first() else { break None };
            let corner = ring.corner(vertex);
            if !ring.is_in(vertex) || cross(corner) <= 0 {
                continue;
            }
            let [a, b, c] = corner.map(at);
            let inside = |p: Snapped| {
                ![a, b, c].contains(&p)
                    && [(a, b), (b, c), (c, a)].iter().all(|(q, r)| -turn * side(*q, *r, p) >= 0)
            };
            match grid.find([a, b, c], |i| inside(at(i))).and_then(|i| waiting.get_mut(i)) {
                Some(waiting) => waiting.push(vertex),
                None => break Some(vertex),
            }
        };
        while !ring.is_in(lowest) {
            lowest += 1;
        }
        // Without an ear only slivers are left; taking a vertex off loses no pixel of a simple outline.
        let gone = ear.unwrap_or(lowest);
        let corner = ring.corner(gone);
        if ear.is_some() {
            triangles.push(corner);
        }
        ring.take(gone);
        grid.take(gone, at(gone));
        for neighbour in [corner[0], corner[2]] {
            open.insert(neighbour);
            if !all && cross(ring.corner(neighbour)) > 0 {
                grid.take(neighbour, at(neighbour));
            }
        }
        if let Some(waiting) = waiting.get_mut(gone) {
            open.extend(waiting.drain(..));
        }
    }
    triangles
}

/// Vertices that are left, each between its neighbours.
struct Ring {
    /// The one before and the one after; of one that was taken off, itself.
    neighbours: Vec<[usize; 2]>,
}

impl Ring {
    fn new(n: usize) -> Self {
        Self { neighbours: (0..n).map(|i| [(i + n - 1) % n, (i + 1) % n]).collect() }
    }

    fn is_in(&self, i: usize) -> bool {
        self.neighbours.get(i).is_none_or(|[before, _]| *before != i)
    }

    /// A vertex between its neighbours.
    fn corner(&self, i: usize) -> [usize; 3] {
        let [before, after] = self.neighbours.get(i).copied().unwrap_or([i; 2]);
        [before, i, after]
    }

    fn take(&mut self, i: usize) {
        let [before, _, after] = self.corner(i);
        if let Some(neighbours) = self.neighbours.get_mut(before) {
            neighbours[1] = after;
        }
        if let Some(neighbours) = self.neighbours.get_mut(after) {
            neighbours[0] = before;
        }
        if let Some(neighbours) = self.neighbours.get_mut(i) {
            *neighbours = [i; 2];
        }
    }
}

/// Vertices in cells, about as many cells as vertices.
struct Grid {
    low: Snapped,
    /// Width and height of a cell, at least 1.
    cell: [i64; 2],
    /// Cells along each axis.
    count: usize,
    cells: Vec<Vec<usize>>,
}

impl Grid {
    fn new(vertices: &[Snapped], mut wanted: impl FnMut(usize) -> bool) -> Self {
        let end = |k: usize, pick: fn(i32, i32) -> i32| {
            vertices.iter().map(|v| v[k]).reduce(pick).unwrap_or_default()
        };
        let low = [end(0, i32::min), end(1, i32::min)];
        let high = [end(0, i32::max), end(1, i32::max)];
        let numbers: Vec<usize> = (0..vertices.len()).filter(|i| wanted(*i)).collect();
        let count = (float::sqrt(numbers.len() as f64) as usize).clamp(1, 1024);
        let size = |k: usize| (i64::from(high[k]) - i64::from(low[k])) / count as i64 + 1;
        let mut grid =
            Self { low, cell: [size(0), size(1)], count, cells: vec![Vec::new(); count * count] };
        for i in numbers {
            let place = grid.place(vertices.get(i).copied().unwrap_or_default());
            if let Some(cell) = grid.cells.get_mut(place) {
                cell.push(i);
            }
        }
        grid
    }

    /// The column or the row of a coordinate.
    fn along(&self, k: usize, c: i64) -> usize {
        let from_low = (c - i64::from(self.low[k])) / self.cell[k];
        from_low.clamp(0, self.count as i64 - 1) as usize
    }

    fn place(&self, p: Snapped) -> usize {
        self.along(1, p[1].into()) * self.count + self.along(0, p[0].into())
    }

    fn take(&mut self, i: usize, at: Snapped) {
        let place = self.place(at);
        if let Some(cell) = self.cells.get_mut(place) {
            cell.retain(|other| *other != i);
        }
    }

    /// A vertex of those in the cells that a triangle touches.
    fn find(&self, triangle: [Snapped; 3], wanted: impl Fn(usize) -> bool) -> Option<usize> {
        let ys = triangle.map(|p| i64::from(p[1]));
        let (lowest, highest) = (ys.into_iter().min()?, ys.into_iter().max()?);
        (self.along(1, lowest)..=self.along(1, highest)).find_map(|row| {
            let bottom = i64::from(self.low[1]) + row as i64 * self.cell[1];
            let [left, right] = reach(&triangle, [bottom, bottom + self.cell[1]])?;
            let first = row * self.count;
            let (from, to) = (first + self.along(0, left), first + self.along(0, right));
            self.cells.get(from..=to)?.iter().flatten().copied().find(|i| wanted(*i))
        })
    }
}

/// From where to where in x a triangle is between two heights, rounded outwards.
fn reach(triangle: &[Snapped; 3], [bottom, top]: [i64; 2]) -> Option<[i64; 2]> {
    let corners = triangle.map(|p| p.map(i64::from));
    let mut xs: Option<[i64; 2]> = None;
    let mut add = |low: i64, high: i64| {
        xs = Some(xs.map_or([low, high], |[l, h]| [l.min(low), h.max(high)]));
    };
    for (p, q) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        if (bottom..=top).contains(&p[1]) {
            add(p[0], p[0]);
        }
        for y in [bottom, top] {
            if (p[1] < y) != (q[1] < y) {
                let x = p[0] + ((q[0] - p[0]) * (y - p[1])).div_euclid(q[1] - p[1]);
                add(x - 1, x + 1);
            }
        }
    }
    xs
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::{Snapped, crosses_itself, side, triangles};

    /// Whether any two edges that are no neighbours have a point in common, each with each.
    fn each_with_each(v: &[Snapped]) -> bool {
        let n = v.len();
        let edge = |i: usize| (v[i], v[(i + 1) % n]);
        let on = |(a, b): (Snapped, Snapped), p: Snapped| {
            let along = |k: usize| (p[k] - a[k]) * (p[k] - b[k]) <= 0;
            side(a, b, p) == 0 && along(0) && along(1)
        };
        let meet = |e: (Snapped, Snapped), f: (Snapped, Snapped)| {
            let apart = |(a, b), (c, d)| side(a, b, c).signum() * side(a, b, d).signum() < 0;
            let touch = |e, (c, d)| on(e, c) || on(e, d);
            (apart(e, f) && apart(f, e)) || touch(e, f) || touch(f, e)
        };
        (0..n).any(|i| (i + 2..if i == 0 { n - 1 } else { n }).any(|j| meet(edge(i), edge(j))))
    }

    /// The sum of the vertices' products, which is twice the area.
    fn doubled_area(v: &[Snapped]) -> i64 {
        (1..v.len().saturating_sub(1)).map(|i| side(v[0], v[i], v[i + 1])).sum()
    }

    #[test]
    fn outlines_on_a_small_grid_are_judged_as_each_edge_with_each_does_and_covered_once() {
        let mut state = 1_u64;
        let mut random = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        let mut simple = 0;
        for round in 0..40_000 {
            let (n, size) = (3 + random(8) as usize, 3 + random(12));
            let outline: Vec<Snapped> =
                (0..n).map(|_| [random(size) as i32, random(size) as i32]).collect();
            let expected = n > 3 && each_with_each(&outline);
            assert_eq!(crosses_itself(&outline), expected, "{round}: {outline:?}");
            let area = doubled_area(&outline);
            let cut = triangles(&outline, -area.signum());
            if expected || area == 0 {
                continue;
            }
            simple += 1;
            // As many as there are, each turned as the outline is, of the same area together: no two overlap.
            let areas = cut.iter().map(|t| side(outline[t[0]], outline[t[1]], outline[t[2]]));
            assert!(areas.clone().all(|a| a * area > 0), "{round}: {outline:?}");
            assert_eq!(areas.sum::<i64>(), area, "{round}: {outline:?}");
        }
        assert!(simple > 4000, "{simple}");
    }
}
