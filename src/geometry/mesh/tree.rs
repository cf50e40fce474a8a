//! A tree of boxes about triangles.

use alloc::vec::Vec;

use nalgebra::{Point3, Vector3};

use crate::geometry::ray::Ray;

/// Triangles of a box that is not divided further.
const FEW: usize = 4;

/// The deepest path of a tree whose boxes are halved: 2³¹ triangles and the few of a leaf.
const DEEPEST: usize = 40;

/// A binary tree of axis-parallel boxes, each cut at the median of its longest side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    /// The first is the root; the left child of an inner node is the next one.
    nodes: Vec<Node>,
    /// The triangles in the order of the leaves.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: Bounds,
    /// Of a leaf its first place in the order, of an inner node its right child.
    first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    count: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Bounds {
    const EMPTY: Self = Self {
        low: Vector3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Vector3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn with(self, point: &Vector3<f64>) -> Self {
        Self { low: self.low.inf(point), high: self.high.sup(point) }
    }

    /// From where on along the ray's line it is in the box, or +∞ where it never is before `limit`.
    fn entry(&self, ray: &Slabs, limit: f64) -> f64 {
        let (mut enter, mut leave) = (0.0_f64, limit);
        for i in 0..3 {
            let (low, high) = (self.low[i] - ray.origin[i], self.high[i] - ray.origin[i]);
            if ray.inverse[i].is_infinite() {
                // Along the sides: within them all the way, or never. 0 · ∞ would not say which.
                if low > 0.0 || high < 0.0 {
                    return f64::INFINITY;
                }
                continue;
            }
            let (a, b) = (low * ray.inverse[i], high * ray.inverse[i]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b) * ROUNDED_UP);
        }
        if enter <= leave { enter } else { f64::INFINITY }
    }

    /// The squared distance of a point from the box.
    fn squared_distance(&self, point: &Vector3<f64>) -> f64 {
        (self.low - point).sup(&(point - self.high)).sup(&Vector3::zeros()).norm_squared()
    }
}

/// What keeps a box's far side from being taken for nearer than its near side by rounding (Ize 2013, "Robust BVH ray traversal").
const ROUNDED_UP: f64 = 1.0 + 4.0 * f64::EPSILON;

/// A ray as a box sees it.
struct Slabs {
    origin: Vector3<f64>,
    inverse: Vector3<f64>,
}

impl Tree {
    /// Of triangles by their numbers.
    pub(super) fn new(count: usize, corners: impl Fn(usize) -> [Point3<f64>; 3]) -> Self {
        // Midpoints of the triangles' own boxes, halved first against overflow.
        let boxes: Vec<(Bounds, Vector3<f64>)> = (0..count)
            .map(|i| {
                let bounds = corners(i).iter().fold(Bounds::EMPTY, |b, p| b.with(&p.coords));
                (bounds, bounds.low * 0.5 + bounds.high * 0.5)
            })
            .collect();
        let mut order: Vec<u32> = (0..count as u32).collect();
        let mut nodes = Vec::new();
        build(&boxes, &mut order, 0, &mut nodes);
        Self { nodes, order }
    }

    /// Visits the triangles whose boxes the ray passes, nearer boxes first. `visit` gets a triangle and how far along the ray
    /// others matter, and returns how far they still do.
    pub(super) fn along(&self, ray: &Ray, visit: impl FnMut(usize, f64) -> f64) {
        let slabs = Slabs { origin: ray.origin.coords, inverse: ray.direction.map(|d| 1.0 / d) };
        self.walk(|bounds, limit| bounds.entry(&slabs, limit), visit);
    }

    /// Visits the triangles that may be nearest to a point, nearer boxes first. `visit` returns the squared distance within which
    /// others still matter.
    pub(super) fn near(&self, point: &Point3<f64>, mut visit: impl FnMut(usize) -> f64) {
        let squared = |bounds: &Bounds, _| bounds.squared_distance(&point.coords);
        self.walk(squared, |triangle, _| visit(triangle));
    }

    /// Visits the triangles of the boxes that are not farther than a limit, which each visit may lower; nearer boxes first. A box that is
    /// not met is infinitely far.
    fn walk(
        &self,
        distance: impl Fn(&Bounds, f64) -> f64,
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let mut limit = f64::INFINITY;
        let mut waiting = [(0_u32, 0.0_f64); DEEPEST];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (at, from) = waiting[depth];
            let Some(node) = self.nodes.get(at as usize) else { continue };
            if from > limit {
                continue;
            }
            if node.count > 0 {
                for triangle in self.leaf(node) {
                    limit = visit(*triangle as usize, limit);
                }
                continue;
            }
            let mut children = [at + 1, node.first].map(|child| {
                let bounds = self.nodes.get(child as usize).map(|n| &n.bounds);
                (child, bounds.map_or(f64::INFINITY, |b| distance(b, limit)))
            });
            // The nearer one is taken from the stack first.
            if children[0].1 < children[1].1 {
                children.swap(0, 1);
            }
            for child in children {
                if child.1.is_finite() && depth < DEEPEST {
                    waiting[depth] = child;
                    depth += 1;
                }
            }
        }
    }

    fn leaf(&self, node: &Node) -> &[u32] {
        let first = node.first as usize;
        self.order.get(first..first + node.count as usize).unwrap_or_default()
    }
}

/// Adds the node of these triangles and all below it.
fn build(boxes: &[(Bounds, Vector3<f64>)], order: &mut [u32], first: usize, nodes: &mut Vec<Node>) {
    let of = |i: &u32| &boxes[*i as usize];
    let mut bounds = Bounds::EMPTY;
    let mut middles = Bounds::EMPTY;
    for (triangle, middle) in order.iter().map(of) {
        bounds = bounds.with(&triangle.low).with(&triangle.high);
        middles = middles.with(middle);
    }
    let at = nodes.len();
    nodes.push(Node { bounds, first: first as u32, count: order.len() as u32 });
    if order.len() <= FEW {
        return;
    }
    let axis = (middles.high - middles.low).imax();
    let half = order.len() / 2;
    // By their numbers where they are equal, so that the tree is the same everywhere.
    order.select_nth_unstable_by(half, |a, b| {
        of(a).1[axis].total_cmp(&of(b).1[axis]).then(a.cmp(b))
    });
    let (left, right) = order.split_at_mut(half);
    build(boxes, left, first, nodes);
    let child = nodes.len() as u32;
    build(boxes, right, first + half, nodes);
    if let Some(node) = nodes.get_mut(at) {
        (node.first, node.count) = (child, 0);
    }
}
