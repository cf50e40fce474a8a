//! Planar polygons and the rays that meet them.

use super::paint::Paint;
use super::vector::{V3, v3};

/// An origin in a plane and three orthonormal directions: `u` and `v` in the plane, `n = u × v` out of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) origin: V3,
    pub(crate) u: V3,
    pub(crate) v: V3,
    pub(crate) n: V3,
}

impl Frame {
    /// `u` along the first edge; `n` to the side from which the vertices go anticlockwise.
    pub(crate) fn of(vertices: &[V3]) -> Self {
        let origin = vertices[0];
        let u = (vertices[1] - origin).unit();
        let mut sum = V3::ZERO;
        for (i, a) in vertices.iter().enumerate() {
            let b = vertices[(i + 1) % vertices.len()];
            sum = sum + (*a - origin).cross(b - origin);
        }
        let n = sum.unit();
        Self { origin, u, v: n.cross(u), n }
    }

    pub(crate) fn coordinates(&self, p: V3) -> (f64, f64) {
        let d = p - self.origin;
        (self.u.dot(d), self.v.dot(d))
    }

    pub(crate) fn point(&self, s: f64, t: f64) -> V3 {
        self.origin + self.u * s + self.v * t
    }
}

#[derive(Debug)]
pub(crate) struct Polygon {
    pub(crate) name: String,
    pub(crate) vertices: Vec<V3>,
    pub(crate) frame: Frame,
    pub(crate) paint: Paint,
    /// Which light map the polygon shares with those of its plane.
    pub(crate) light: usize,
    outline: Vec<(f64, f64)>,
}

impl Polygon {
    pub(crate) fn new(
        name: String,
        vertices: Vec<V3>,
        frame: Frame,
        paint: Paint,
        light: usize,
    ) -> Self {
        let outline = vertices.iter().map(|p| frame.coordinates(*p)).collect();
        Self { name, vertices, frame, paint, light, outline }
    }

    /// Even-odd rule in the plane; an edge owns its lower end.
    pub(crate) fn contains(&self, s: f64, t: f64) -> bool {
        let mut inside = false;
        let mut a = self.outline[self.outline.len() - 1];
        for &b in &self.outline {
            if (a.1 > t) != (b.1 > t) {
                let cross = (b.0 - a.0) * (t - a.1) - (b.1 - a.1) * (s - a.0);
                if (cross > 0.0) == (b.1 > a.1) {
                    inside = !inside;
                }
            }
            a = b;
        }
        inside
    }

    /// Smallest and largest plane coordinates: (s, t), (s, t).
    pub(crate) fn extent(&self) -> ((f64, f64), (f64, f64)) {
        let big = f64::INFINITY;
        self.outline.iter().fold(((big, big), (-big, -big)), |(lo, hi), p| {
            ((lo.0.min(p.0), lo.1.min(p.1)), (hi.0.max(p.0), hi.1.max(p.1)))
        })
    }

    fn bounds(&self) -> (V3, V3) {
        let big = v3(f64::INFINITY, f64::INFINITY, f64::INFINITY);
        self.vertices.iter().fold((big, -big), |(lo, hi), p| (lo.min(*p), hi.max(*p)))
    }

    fn meet(&self, ray: &Ray) -> Option<Hit> {
        let along = self.frame.n.dot(ray.direction);
        let t = self.frame.n.dot(self.frame.origin - ray.origin) / along;
        if !(t > ray.from && t < ray.to) {
            return None;
        }
        let point = ray.origin + ray.direction * t;
        let (u, v) = self.frame.coordinates(point);
        self.contains(u, v).then_some(Hit { t, polygon: usize::MAX, point, s: (u, v) })
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin: V3,
    pub(crate) direction: V3,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f64,
    pub(crate) polygon: usize,
    pub(crate) point: V3,
    /// Coordinates in the polygon's frame.
    pub(crate) s: (f64, f64),
}

#[derive(Debug)]
struct Node {
    low: V3,
    high: V3,
    /// A leaf: first and number of its polygons in `order`. A branch: its two children.
    a: usize,
    b: usize,
    leaf: bool,
}

/// A tree of boxes over the polygons.
#[derive(Debug)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl Tree {
    pub(crate) fn new(polygons: &[Polygon]) -> Self {
        let boxes: Vec<_> = polygons.iter().map(Polygon::bounds).collect();
        let mut tree = Self { nodes: Vec::new(), order: (0..polygons.len()).collect() };
        tree.split(&boxes, 0, polygons.len());
        tree
    }

    fn split(&mut self, boxes: &[(V3, V3)], first: usize, count: usize) -> usize {
        let members = &mut self.order[first..first + count];
        let (low, high) = members
            .iter()
            .fold(boxes[members[0]], |(lo, hi), &i| (lo.min(boxes[i].0), hi.max(boxes[i].1)));
        let here = self.nodes.len();
        if count <= 2 {
            self.nodes.push(Node { low, high, a: first, b: count, leaf: true });
            return here;
        }
        let axis = (0..3)
            .max_by(|&i, &j| (high - low).array()[i].total_cmp(&(high - low).array()[j]))
            .unwrap_or(0);
        members.sort_by(|&i, &j| {
            let middle = |k: usize| (boxes[k].0 + boxes[k].1).array()[axis];
            middle(i).total_cmp(&middle(j))
        });
        self.nodes.push(Node { low, high, a: 0, b: 0, leaf: false });
        let half = count / 2;
        self.nodes[here].a = self.split(boxes, first, half);
        self.nodes[here].b = self.split(boxes, first + half, count - half);
        here
    }

    /// The first polygon along the ray.
    pub(crate) fn first(&self, polygons: &[Polygon], ray: Ray) -> Option<Hit> {
        self.walk(polygons, ray, |_| true, false)
    }

    /// Whether any polygon that `counts` stands in the ray's way.
    pub(crate) fn any(
        &self,
        polygons: &[Polygon],
        ray: Ray,
        counts: impl Fn(&Polygon) -> bool,
    ) -> bool {
        self.walk(polygons, ray, counts, true).is_some()
    }

    fn walk(
        &self,
        polygons: &[Polygon],
        mut ray: Ray,
        counts: impl Fn(&Polygon) -> bool,
        any: bool,
    ) -> Option<Hit> {
        let inverse = ray.direction.map(|d| 1.0 / d);
        let mut stack = [(0_usize, 0.0_f64); 48];
        let mut depth = 1;
        let mut best = None;
        while depth > 0 {
            depth -= 1;
            let (index, entry) = stack[depth];
            if entry > ray.to {
                continue;
            }
            let node = &self.nodes[index];
            if node.leaf {
                for &i in &self.order[node.a..node.a + node.b] {
                    if let Some(hit) = polygons[i].meet(&ray)
                        && counts(&polygons[i])
                    {
                        ray.to = hit.t;
                        best = Some(Hit { polygon: i, ..hit });
                        if any {
                            return best;
                        }
                    }
                }
                continue;
            }
            let (a, b) = (node.a, node.b);
            let (ta, tb) = (self.enter(a, &ray, inverse), self.enter(b, &ray, inverse));
            let (near, far) = if ta <= tb { ((a, ta), (b, tb)) } else { ((b, tb), (a, ta)) };
            for child in [far, near] {
                if child.1 < f64::INFINITY {
                    stack[depth] = child;
                    depth += 1;
                }
            }
        }
        best
    }

    /// Ray parameter at which the box is entered, or infinity.
    fn enter(&self, index: usize, ray: &Ray, inverse: V3) -> f64 {
        let node = &self.nodes[index];
        // A flat box would lose its rays to rounding.
        let pad = v3(1e-9, 1e-9, 1e-9);
        let a = (node.low - pad - ray.origin).times(inverse);
        let b = (node.high + pad - ray.origin).times(inverse);
        let (lo, hi) = (a.min(b), a.max(b));
        let enter = lo.x.max(lo.y).max(lo.z).max(ray.from);
        let leave = hi.x.min(hi.y).min(hi.z).min(ray.to);
        if enter <= leave { enter } else { f64::INFINITY }
    }
}
