//! Triangles, three cubics in each, smooth across all edges.

use alloc::vec::Vec;
use core::ops::{ControlFlow, Range};

use nalgebra::{Matrix2, Point2, Vector2};

use super::gradients::least_curvature;
use super::triangulation::{Crossing, Triangulation, barycentric_gradients};
use crate::error::{Error, ProjectionError};
use crate::mapping::blocks::{Gather, centre, first_beyond, first_from};
use crate::mapping::{BlockSink, Map, control};

/// The smooth piecewise cubic map through control points (Goshtasby 1987): in each Delaunay triangle of the screen points
/// the element of Clough & Tocher (1965).
///
/// The centroid splits a triangle into three; in each of them a coordinate is a cubic in Bernstein form,
///
/// ```text
/// u = Σ 3!/(i! j! k!) bᵢⱼₖ λ₁ⁱ λ₂ʲ λ₃ᵏ,   i + j + k = 3
/// ```
///
/// whose ordinates follow from the values and gradients at the corners, from one derivative on each edge, and from
/// smoothness inside. On an edge the derivative in the direction from one centroid to the other varies linearly (Farin
/// 1986), on the hull that from the centroid to the edge's middle: both stay the same under affine maps of the screen.
///
/// *Gradients* not given are those for which the curves over all edges bend least (Nielson 1983).
///
/// *Domain.* The convex hull of the screen points. *Smoothness.* C¹; a linear map is reproduced, and a quadratic one whose
/// gradients are given. *Cost.* About 150 products where a row enters a third of a triangle; three products and additions a
/// pixel and coordinate. *Accuracy.* A few rounding errors; the gradients are found to 1e-13 of the largest.
///
/// # Example
/// u = S² and v = L with their gradients, at the centroid of a triangle:
///
/// ```
/// use collinear::mapping::{Map, piecewise::PiecewiseCubic};
/// use nalgebra::{Matrix2, Point2};
///
/// let screen = [(0., 0.), (6., 0.), (0., 9.)].map(|(x, y)| Point2::new(x, y));
/// let texture = screen.map(|p| Point2::new(p.x * p.x, p.y));
/// let gradients = screen.map(|p| Matrix2::new(2.0 * p.x, 0.0, 0.0, 1.0));
/// let map = PiecewiseCubic::with_gradients(&screen, &texture, &gradients)?;
/// assert!((map.at(&Point2::new(2.0, 3.0))? - Point2::new(4.0, 3.0)).norm() < 1e-14);
/// assert!((map.jacobian(&Point2::new(1.0, 1.0))? - Matrix2::new(2.0, 0.0, 0.0, 1.0)).norm() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("CloughTocher2DInterpolator", "HCT"))]
pub struct PiecewiseCubic {
    triangles: Triangulation,
    texture: Vec<Point2<f64>>,
    gradients: Vec<Matrix2<f64>>,
    elements: Vec<Element>,
}

/// The ordinates of one triangle that are no control points. Indices are corners, o the centroid.
#[derive(Clone, Copy, Debug)]
struct Element {
    /// The centroid's place.
    place: Point2<f64>,
    /// On the edge from i to i + 1, nearer to i and nearer to i + 1.
    edge: [[Vector2<f64>; 2]; 3],
    /// b_iio.
    spoke: [Vector2<f64>; 3],
    /// b_ijo beside the edge from i to i + 1.
    wing: [Vector2<f64>; 3],
    /// b_ioo.
    inner: [Vector2<f64>; 3],
    /// b_ooo.
    centroid: Vector2<f64>,
}

/// The ten ordinates of a third of a triangle, by their exponents (i, j, k).
#[derive(Clone, Copy, Debug)]
struct Cubic {
    b300: Vector2<f64>,
    b210: Vector2<f64>,
    b120: Vector2<f64>,
    b030: Vector2<f64>,
    b201: Vector2<f64>,
    b111: Vector2<f64>,
    b021: Vector2<f64>,
    b102: Vector2<f64>,
    b012: Vector2<f64>,
    b003: Vector2<f64>,
}

/// Σ λₖ cₖ.
#[inline(always)]
fn mix(l: &[f64; 3], a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>) -> Vector2<f64> {
    a * l[0] + b * l[1] + c * l[2]
}

impl Cubic {
    /// One step of de Casteljau: the quadratic's ordinates 200, 110, 020, 101, 011, 002.
    fn quadratic(&self, l: &[f64; 3]) -> [Vector2<f64>; 6] {
        [
            mix(l, self.b300, self.b210, self.b201),
            mix(l, self.b210, self.b120, self.b111),
            mix(l, self.b120, self.b030, self.b021),
            mix(l, self.b201, self.b111, self.b102),
            mix(l, self.b111, self.b021, self.b012),
            mix(l, self.b102, self.b012, self.b003),
        ]
    }
}

/// Another step: the linear function's ordinates 100, 010, 001.
fn linear(q: &[Vector2<f64>; 6], l: &[f64; 3]) -> [Vector2<f64>; 3] {
    [mix(l, q[0], q[1], q[3]), mix(l, q[1], q[2], q[4]), mix(l, q[3], q[4], q[5])]
}

/// A stretch of a row within a third of a triangle.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    /// Where it begins, and one over its width.
    x: f64,
    scale: f64,
    /// The coordinates as polynomials in the share of the way, from the constant up.
    u: [f64; 4],
    v: [f64; 4],
}

impl Stretch {
    /// On the way from the point `a` to the point `b`, both in barycentric coordinates.
    fn new(cubic: &Cubic, left: f64, a: &[f64; 3], right: f64, b: &[f64; 3]) -> Self {
        let (qa, qb) = (cubic.quadratic(a), cubic.quadratic(b));
        let (aa, ab, bb) = (linear(&qa, a), linear(&qa, b), linear(&qb, b));
        let blossom = |c: &[Vector2<f64>; 3], l: &[f64; 3]| mix(l, c[0], c[1], c[2]);
        let [c0, c1, c2, c3] = [blossom(&aa, a), blossom(&ab, a), blossom(&ab, b), blossom(&bb, b)];
        let second = c2 - c1 * 2.0 + c0;
        let powers = [c0, (c1 - c0) * 3.0, second * 3.0, (c3 - c0) - (c2 - c1) * 3.0];
        let width = right - left;
        Self {
            x: left,
            scale: if width > 0.0 { 1.0 / width } else { 0.0 },
            u: powers.map(|c| c.x),
            v: powers.map(|c| c.y),
        }
    }

    #[inline(always)]
    fn share(&self, x: f64) -> f64 {
        (x - self.x) * self.scale
    }

    #[inline(always)]
    fn at(&self, x: f64) -> [f64; 2] {
        let t = self.share(x);
        [&self.u, &self.v].map(|c| c[0] + t * (c[1] + t * (c[2] + t * c[3])))
    }

    fn fill(&self, first: i32, u: &mut [f64], v: &mut [f64]) {
        for (i, (u, v)) in u.iter_mut().zip(v).enumerate() {
            [*u, *v] = self.at(centre(first + i as i32));
        }
    }
}

/// A third of a triangle and the stretch of a row in it: the barycentric coordinates of both ends.
struct Part {
    third: usize,
    left: f64,
    a: [f64; 3],
    right: f64,
    b: [f64; 3],
    /// Whether the row leaves the triangle at its end.
    last: bool,
}

impl PiecewiseCubic {
    /// The map that takes each screen point to its texture point, with gradients estimated.
    ///
    /// # Errors
    /// As [`PiecewiseAffine::new`](super::PiecewiseAffine::new), and [`Error::NotConverged`] with the share by which
    /// gradients still moved.
    pub fn new(screen: &[Point2<f64>], texture: &[Point2<f64>]) -> Result<Self, Error> {
        control::check(screen, texture, 3)?;
        let triangles = Triangulation::new(screen)?;
        let gradients = least_curvature(&triangles, texture)?;
        Ok(Self::build(triangles, texture, gradients))
    }

    /// The map with given gradients: ∂(u, v)/∂(S, L) at each point.
    ///
    /// # Errors
    /// As [`PiecewiseAffine::new`](super::PiecewiseAffine::new).
    pub fn with_gradients(
        screen: &[Point2<f64>],
        texture: &[Point2<f64>],
        gradients: &[Matrix2<f64>],
    ) -> Result<Self, Error> {
        control::check(screen, texture, 3)?;
        if gradients.len() != screen.len() {
            return Err(Error::LengthMismatch {
                what: "screen points and gradients",
                left: screen.len(),
                right: gradients.len(),
            });
        }
        if !gradients.iter().all(|g| g.iter().all(|c| c.is_finite())) {
            return Err(Error::NotFinite { what: "gradient at a control point" });
        }
        Ok(Self::build(Triangulation::new(screen)?, texture, gradients.to_vec()))
    }

    fn build(
        triangles: Triangulation,
        texture: &[Point2<f64>],
        gradients: Vec<Matrix2<f64>>,
    ) -> Self {
        let elements = (0..triangles.len())
            .map(|t| Element::new(&triangles, texture, &gradients, t))
            .collect();
        Self { triangles, texture: texture.to_vec(), gradients, elements }
    }

    /// ∂(u, v)/∂(S, L) at the control points.
    #[must_use]
    pub fn gradients(&self) -> &[Matrix2<f64>] {
        &self.gradients
    }

    /// The cubic beside the edge from corner i to the next one.
    fn cubic(&self, t: usize, i: usize) -> Cubic {
        let j = (i + 1) % 3;
        let e = &self.elements[t];
        let corner = |k: usize| self.texture[self.triangles.corners[3 * t + k]].coords;
        Cubic {
            b300: corner(i),
            b210: e.edge[i][0],
            b120: e.edge[i][1],
            b030: corner(j),
            b201: e.spoke[i],
            b111: e.wing[i],
            b021: e.spoke[j],
            b102: e.inner[i],
            b012: e.inner[j],
            b003: e.centroid,
        }
    }

    /// The thirds that the line y meets between two half-edges of one triangle, left to right.
    fn parts(
        &self,
        y: f64,
        entry: usize,
        exit: usize,
        mut visit: impl FnMut(&Part) -> ControlFlow<()>,
    ) {
        let t = entry / 3;
        let side = self.triangles.side(y);
        let places = self.triangles.triangle(t);
        let place = |k: usize| if k < 3 { places[k] } else { self.elements[t].place };
        let beyond = |k: usize| side.beyond(&place(k));
        // Corners are 0, 1, 2 and the centroid 3; a crossing lies between two of them.
        let crossing = |a: usize, b: usize| Crossing::new(y, (a, place(a)), (b, place(b)));
        let weights = |c: &Crossing<usize>, third: usize| {
            let mut weights = [0.0; 3];
            for (corner, weight) in c.ends.into_iter().zip([1.0 - c.share, c.share]) {
                let k = if corner == 3 { 2 } else { usize::from(corner != third) };
                weights[k] = weight;
            }
            weights
        };
        let mut third = entry % 3;
        let mut from = crossing(third, (third + 1) % 3);
        // At most three thirds: those of the entry, of the exit and the one between.
        for _ in 0..3 {
            let next = (third + 1) % 3;
            let came_by_edge = !from.ends.contains(&3);
            // Through the edge itself, if it is the exit and the line crosses it here; else through a spoke.
            let leaves = !came_by_edge && beyond(third) != beyond(next);
            let (to, neighbour) = if leaves {
                (crossing(third, next), None)
            } else if came_by_edge {
                // The spoke whose corner lies on the other side than the centroid.
                let corner = if beyond(3) == beyond(third) { next } else { third };
                (crossing(corner, 3), Some((third + if corner == next { 1 } else { 2 }) % 3))
            } else {
                // Both corners on one side, the centroid on the other: the other spoke.
                let corner = if from.ends.contains(&third) { next } else { third };
                (crossing(corner, 3), Some((third + if corner == next { 1 } else { 2 }) % 3))
            };
            let part = Part {
                third,
                left: from.x,
                a: weights(&from, third),
                right: to.x,
                b: weights(&to, third),
                last: neighbour.is_none(),
            };
            if visit(&part).is_break() {
                return;
            }
            let Some(neighbour) = neighbour else { return };
            (third, from) = (neighbour, to);
        }
        debug_assert!(third == exit % 3, "the line leaves where it should");
    }

    /// The part of its row in which a point of a triangle lies.
    fn part_at(&self, p: &Point2<f64>) -> Result<(usize, Part), ProjectionError> {
        let [entry, exit] = self.triangles.locate(p)?;
        let mut found = None;
        self.parts(p.y, entry, exit, |part| {
            let inside = p.x < part.right;
            found = Some(Part { ..*part });
            if inside { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.map(|part| (entry / 3, part)).ok_or(ProjectionError::NotFinite)
    }

    fn stretch(&self, t: usize, part: &Part) -> Stretch {
        Stretch::new(&self.cubic(t, part.third), part.left, &part.a, part.right, &part.b)
    }
}

impl Element {
    fn new(
        triangles: &Triangulation,
        texture: &[Point2<f64>],
        gradients: &[Matrix2<f64>],
        t: usize,
    ) -> Self {
        let corner = |k: usize| triangles.corners[3 * t + k % 3];
        let value = |k: usize| texture[corner(k)].coords;
        let centroid = |t: usize| {
            let [a, b, c] = triangles.triangle(t);
            a + ((b - a) + (c - a)) / 3.0
        };
        let place = centroid(t);
        let edge: [[Vector2<f64>; 2]; 3] = core::array::from_fn(|i| {
            let along = triangles.along(3 * t + i) / 3.0;
            [
                value(i) + gradients[corner(i)] * along,
                value(i + 1) - gradients[corner(i + 1)] * along,
            ]
        });
        let spoke: [Vector2<f64>; 3] =
            core::array::from_fn(|i| (value(i) + edge[i][0] + edge[(i + 2) % 3][1]) / 3.0);
        let wing: [Vector2<f64>; 3] = core::array::from_fn(|i| {
            let j = (i + 1) % 3;
            // The direction of the derivative in barycentric coordinates, per unit away from the centroid.
            let along = match triangles.neighbour(3 * t + i) {
                Some(other) => direction(triangles, t, i, &place, &centroid(other)),
                None => 0.5,
            };
            let (first, second) = (along, 1.0 - along);
            // Its ordinates at the ends, then the middle one, which makes it linear.
            let slope = |near: Vector2<f64>, far: Vector2<f64>, inner: Vector2<f64>| {
                near * first + far * second - inner
            };
            let start = slope(value(i), edge[i][0], spoke[i]);
            let end = slope(edge[i][1], value(j), spoke[j]);
            edge[i][0] * first + edge[i][1] * second - (start + end) * 0.5
        });
        let inner: [Vector2<f64>; 3] =
            core::array::from_fn(|i| (spoke[i] + wing[i] + wing[(i + 2) % 3]) / 3.0);
        let middle = (inner[0] + inner[1] + inner[2]) / 3.0;
        Self { place, edge, spoke, wing, inner, centroid: middle }
    }
}

/// The share of corner i where the line between the centroids of two triangles meets the line of their edge.
fn direction(
    triangles: &Triangulation,
    t: usize,
    i: usize,
    from: &Point2<f64>,
    to: &Point2<f64>,
) -> f64 {
    let [a, b] = [i, (i + 1) % 3].map(|k| triangles.points[triangles.corners[3 * t + k]]);
    let d = to - from;
    // Areas of the triangles that the line cuts off, twice: those of a and of b.
    let area = |p: Point2<f64>| {
        let r = p - from;
        d.x * r.y - d.y * r.x
    };
    let (left, right) = (area(a), area(b));
    let share = right / (right - left);
    if share.is_finite() { share } else { 0.5 }
}

impl Map for PiecewiseCubic {
    /// [`ProjectionError::OutsideDomain`] outside the hull, with how far the hull is along the row (or the column, where the row
    /// misses it) and the limit zero.
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let (t, part) = self.part_at(screen)?;
        Ok(self.stretch(t, &part).at(screen.x).into())
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let (t, part) = self.part_at(screen)?;
        let [a, b, c] = self.triangles.triangle(t);
        let corner = [a, b, c];
        let third = [corner[part.third], corner[(part.third + 1) % 3], self.elements[t].place];
        let gradients = barycentric_gradients(&third)?;
        let share = self.stretch(t, &part).share(screen.x);
        let at: [f64; 3] = core::array::from_fn(|k| part.a[k] + share * (part.b[k] - part.a[k]));
        let plane = linear(&self.cubic(t, part.third).quadratic(&at), &at);
        let mut jacobian = Matrix2::zeros();
        for k in 0..2 {
            // The gradients sum to zero.
            jacobian += (plane[k] - plane[2]) * gradients[k].transpose() * 3.0;
        }
        Ok(jacobian)
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let y = centre(line);
        let mut row = Gather::new(emit);
        let mut rest = samples;
        let mut begun = false;
        // A row that misses the hull has no pixels.
        let _ = self.triangles.walk(y, |entry, exit| {
            if !begun {
                begun = true;
                rest.start = first_from(self.triangles.crossing(y, entry).x, &rest);
            }
            let end = self.triangles.crossing(y, exit).x;
            let last = self.triangles.ends(exit);
            let stop = if last { first_beyond(end, &rest) } else { first_from(end, &rest) };
            // Parts of a row that hold no pixel need no ordinates.
            if rest.start < stop {
                let mut inside = rest.start..stop;
                self.parts(y, entry, exit, |part| {
                    let until = if part.last { stop } else { first_from(part.right, &inside) };
                    if inside.start < until {
                        let stretch = self.stretch(entry / 3, part);
                        row.run(inside.start..until, |x, u, v| stretch.fill(x, u, v));
                        inside.start = until;
                    }
                    ControlFlow::Continue(())
                });
            }
            rest.start = stop;
            if rest.is_empty() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        row.flush();
    }
}
