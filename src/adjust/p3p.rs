//! The pose of a camera from three points: every root.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::roots::Roots;
use crate::error::Error;
use crate::geometry::Pose;
use crate::numeric::polynomial::outer_cubic_root;

/// Up to four poses, camera_from_world.
pub type PoseRoots = Roots<4>;

/// All poses from which three known points are seen along three given directions.
///
/// *Model.* Points Xᵢ at the distances dᵢ > 0 along the unit directions bᵢ, in camera axes (x right, y down, z forward):
///
/// ```text
/// R (Xᵢ − C) = dᵢ bᵢ ,    |dᵢ bᵢ − dⱼ bⱼ|² = (dᵢ − dⱼ)² + |bᵢ − bⱼ|² dᵢ dⱼ = |Xᵢ − Xⱼ|²        (Grunert 1841)
/// ```
///
/// The right-hand sides taken out of the three equations leave two conics in d₁ : d₂ : d₃. One degenerate conic of their
/// pencil, at a root of a cubic, is two lines, and on each line a quadratic gives two points (Persson & Nordberg 2018,
/// Lambda Twist; Ding, Yang, Larsson, Olsson & Åström 2023, Revisiting the P3P problem). Here the unknowns are θ d₁, d₂ − d₁ and
/// d₃ − d₁, where θ is the largest |bᵢ − bⱼ|: their equations stay regular down to the parallel projection that a long
/// lens approaches. The root of the cubic is the one farthest from the other two, simple where roots of the problem
/// coincide. Each root is refined by Newton steps on the three equations.
///
/// *Roots.* Up to four, each with all three points at a positive distance along its direction; none where no such pose exists.
/// Every pose fulfils the three equations within 10⁻¹¹ of each squared distance, or to rounding (32 ε of the largest). On the
/// danger cylinder two roots coincide, and rounding parts them by about √ε or makes them complex: a pair that
/// fulfils the equations so closely at its real part is returned as one root or two, never as none.
///
/// *Frames and units.* Directions may have any positive length. World units are the caller's; everything is relative to the
/// first point inside, so that coordinates of 10⁶ are as good as any.
///
/// # Errors
/// [`Error::NotFinite`]; [`Error::Degenerate`] where the object points lie on a line (the measure is twice the triangle's
/// area over its longest side squared), where two directions are the same (the measure is the distance of the unit
/// vectors), and for a direction of length zero.
///
/// # Example
/// Fischler & Bolles 1981: an equilateral triangle of side 2√3 whose points are seen 51.3° (cos = 5/8) apart from each other.
/// Their four solutions have the distances (4, 4, 4), (1, 4, 4), (4, 1, 4) and (4, 4, 1): 16 + 1 − 2 · 4 · 5/8 = 12.
/// ```
/// use collinear::adjust::p3p;
/// use collinear::nalgebra::{Point3, Vector3};
///
/// let third = |k: i32| (f64::from(k) * std::f64::consts::TAU / 3.0).sin_cos();
/// let object = [0, 1, 2].map(third).map(|(y, x)| Point3::new(2.0 * x, 2.0 * y, 0.0));
/// // From (0, 0, −√12) the three distances are √(4 + 12) = 4.
/// let directions = [0, 1, 2].map(third).map(|(y, x)| Vector3::new(2.0 * x, 2.0 * y, 12f64.sqrt()));
/// let mut distances: Vec<_> = p3p(&object, &directions)?
///     .into_iter()
///     .map(|pose| object.map(|x| (x - pose.origin).norm().round() as i32))
///     .collect();
/// distances.sort();
/// assert_eq!(distances, [[1, 4, 4], [4, 1, 4], [4, 4, 1], [4, 4, 4]]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[doc(alias("solveP3P", "perspective-three-point", "lambda twist", "spatial resection"))]
pub fn p3p(object: &[Point3<f64>; 3], directions: &[Vector3<f64>; 3]) -> Result<PoseRoots, Error> {
    let scene = Scene::new(object, directions)?;
    let mut found = Found { distances: [[0.0; 3]; 4], len: 0 };
    scene.intersect_conics(&mut found);
    let mut roots = PoseRoots::none();
    for unknowns in &found.distances[..found.len] {
        roots.push(scene.pose(unknowns));
    }
    Ok(roots)
}

/// Roots (θ d₁, d₂ − d₁, d₃ − d₁), refined.
struct Found {
    distances: [[f64; 3]; 4],
    len: usize,
}

impl Found {
    fn push(&mut self, x: [f64; 3]) {
        // One root met on both lines, where they cross on the conic.
        let same =
            |y: &[f64; 3]| (0..3).all(|i| (x[i] - y[i]).abs() <= 1e-9 * (x[i].abs() + x[0].abs()));
        if self.distances[..self.len].iter().any(same) {
            return;
        }
        if let Some(place) = self.distances.get_mut(self.len) {
            *place = x;
            self.len += 1;
        }
    }
}

/// A quadratic form in (θ d₁, d₂ − d₁, d₃ − d₁).
type Conic = Matrix3<f64>;

struct Scene {
    /// The first object point and, in units of the longest edge, the other two about it.
    first: Point3<f64>,
    edges: [Vector3<f64>; 2],
    /// The length of the longest edge.
    unit: f64,
    directions: [Vector3<f64>; 3],
    /// b₂ − b₁, b₃ − b₁.
    turns: [Vector3<f64>; 2],
    theta: f64,
    /// |bᵢ − bⱼ|²/θ² of the pairs 12, 13, 23.
    angles: [f64; 3],
    /// The squared edges of these pairs, the largest being one.
    squares: [f64; 3],
}

/// A unit vector along a finite one.
pub(super) fn unit_vector(v: &Vector3<f64>) -> Result<Vector3<f64>, Error> {
    if !v.iter().all(|c| c.is_finite()) {
        return Err(Error::NotFinite { what: "direction" });
    }
    let squared = v.norm_squared();
    if squared > 1e-250 && squared < 1e250 {
        return Ok(v / squared.sqrt());
    }
    let largest = v.amax();
    if largest == 0.0 {
        return Err(Error::Degenerate {
            what: "direction of length zero",
            measure: 0.0,
            limit: 0.0,
        });
    }
    Ok((v / largest).normalize())
}

impl Scene {
    fn new(object: &[Point3<f64>; 3], directions: &[Vector3<f64>; 3]) -> Result<Self, Error> {
        let [first, second, third] = object;
        let (u, v) = (second - first, third - first);
        let extent = u.amax().max(v.amax());
        if !(object.iter().all(|p| p.iter().all(|c| c.is_finite())) && extent.is_finite()) {
            return Err(Error::NotFinite { what: "object point" });
        }
        let what = "object points on a line";
        if extent == 0.0 {
            return Err(Error::Degenerate { what, measure: 0.0, limit: 4.0 * f64::EPSILON });
        }
        let (u, v) = (u / extent, v / extent);
        let squares = [u.norm_squared(), v.norm_squared(), (v - u).norm_squared()];
        let longest = squares[0].max(squares[1]).max(squares[2]);
        let measure = u.cross(&v).norm() / longest;
        // What rounding the coordinates alone does to the measure.
        let largest = object.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let limit = f64::EPSILON * (4.0 + 2.0 * (largest / extent));
        if !(measure > limit) {
            return Err(Error::Degenerate { what, measure, limit });
        }
        let length = longest.sqrt();
        let [b1, b2, b3] = directions;
        let b = [unit_vector(b1)?, unit_vector(b2)?, unit_vector(b3)?];
        let turns = [b[1] - b[0], b[2] - b[0]];
        let angles = [turns[0], turns[1], b[2] - b[1]].map(|t| t.norm_squared());
        let least = angles[0].min(angles[1]).min(angles[2]).sqrt();
        let limit = 4.0 * f64::EPSILON;
        if !(least > limit) {
            let what = "directions that are the same";
            return Err(Error::Degenerate { what, measure: least, limit });
        }
        let largest = angles[0].max(angles[1]).max(angles[2]);
        Ok(Self {
            first: *first,
            edges: [u / length, v / length],
            unit: extent * length,
            directions: b,
            turns,
            theta: largest.sqrt(),
            angles: angles.map(|e| e / largest),
            squares: squares.map(|a| a / longest),
        })
    }

    /// The squared distances of the pairs 12, 13, 23 as quadratic forms.
    fn forms(&self) -> [Conic; 3] {
        let [e12, e13, e23] = self.angles;
        let half = 0.5 * self.theta;
        let symmetric = |uu: f64, vv: f64, ww: f64, uv: f64, uw: f64, vw: f64| {
            Matrix3::new(uu, uv, uw, uv, vv, vw, uw, vw, ww)
        };
        [
            symmetric(e12, 1.0, 0.0, e12 * half, 0.0, 0.0),
            symmetric(e13, 0.0, 1.0, 0.0, e13 * half, 0.0),
            symmetric(e23, 1.0, 1.0, e23 * half, e23 * half, e23 * half * self.theta - 1.0),
        ]
    }

    /// The intersections of the two conics, refined, with positive distances.
    fn intersect_conics(&self, found: &mut Found) {
        let [f12, f13, f23] = self.forms();
        let [a12, a13, a23] = self.squares;
        // The equation of the longest edge, whose square is one, takes the right-hand sides out of the others.
        let (mut q1, mut q2) = if a12 == 1.0 {
            (f13 - f12 * a13, f23 - f12 * a23)
        } else if a13 == 1.0 {
            (f12 - f13 * a12, f23 - f13 * a23)
        } else {
            (f12 - f23 * a12, f13 - f23 * a13)
        };
        let mut cubic = pencil(&q1, &q2);
        let [c0, c1, c2, c3] = cubic.map(f64::abs);
        if c0.max(c3) < 0.03 * c1.max(c2) {
            // Roots near zero and infinity: another basis of the pencil has them elsewhere.
            (q1, q2) = (q1 + q2, q1 - q2);
            cubic = pencil(&q1, &q2);
        }
        if cubic[3].abs() < cubic[0].abs() {
            (q1, q2) = (q2, q1);
            cubic.reverse();
        }
        if cubic[3] == 0.0 {
            return;
        }
        let lambda = outer_cubic_root(cubic);
        let Some(lines) = lines(&(q1 + q2 * lambda)) else { return };
        let conic = if lambda.abs() * q2.amax() <= q1.amax() { q2 } else { q1 };
        for line in lines {
            self.intersect_line(&line, &conic, found);
        }
    }

    /// The points of a conic on a line, refined, with positive distances.
    fn intersect_line(&self, line: &Vector3<f64>, conic: &Conic, found: &mut Found) {
        let k = line.icamax();
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (alpha, beta) = (-line[i] / line[k], -line[j] / line[k]);
        let q = |r: usize, c: usize| conic[(r, c)];
        let a = q(i, i) + alpha * (2.0 * q(i, k) + q(k, k) * alpha);
        let b = q(i, j) + q(i, k) * beta + alpha * (q(j, k) + q(k, k) * beta);
        let c = q(j, j) + beta * (2.0 * q(j, k) + q(k, k) * beta);
        // a x² + 2 b x y + c y² = 0. A little below zero the discriminant is that of a double root with rounding.
        let (square, product) = (b * b, a * c);
        let discriminant = square - product;
        if !(discriminant >= -1e-8 * (square + product.abs())) {
            return;
        }
        let r = -(b + discriminant.max(0.0).sqrt().copysign(b));
        for (x, y) in [(r, a), (c, r)] {
            let mut unknowns = [0.0; 3];
            unknowns[i] = x;
            unknowns[j] = y;
            unknowns[k] = alpha * x + beta * y;
            if let Some(root) = self.refine(unknowns) {
                found.push(root);
            }
        }
    }

    /// The distances d₁, d₂, d₃ in units of the longest edge.
    fn distances(&self, [u, v, w]: [f64; 3]) -> [f64; 3] {
        let d1 = u / self.theta;
        [d1, d1 + v, d1 + w]
    }

    /// Squared distances of the pairs minus the squared edges.
    fn residuals(&self, [u, v, w]: [f64; 3]) -> [f64; 3] {
        let ([e12, e13, e23], t) = (self.angles, self.theta);
        let [a12, a13, a23] = self.squares;
        [
            v * v + e12 * u * (u + t * v) - a12,
            w * w + e13 * u * (u + t * w) - a13,
            (v - w) * (v - w) + e23 * (u + t * v) * (u + t * w) - a23,
        ]
    }

    /// One Newton step on the three equations.
    fn step(&self, [u, v, w]: [f64; 3], [r12, r13, r23]: [f64; 3]) -> [f64; 3] {
        let ([e12, e13, e23], t) = (self.angles, self.theta);
        // Rows (a b 0), (c 0 d), (e f g).
        let (a, b) = (e12 * (2.0 * u + t * v), 2.0 * v + e12 * t * u);
        let (c, d) = (e13 * (2.0 * u + t * w), 2.0 * w + e13 * t * u);
        let e = e23 * (2.0 * u + t * (v + w));
        let f = 2.0 * (v - w) + e23 * t * (u + t * w);
        let g = 2.0 * (w - v) + e23 * t * (u + t * v);
        let determinant = -(a * d * f + b * c * g - b * d * e);
        let scale = 1.0 / determinant;
        [
            u - scale * (b * d * r23 - d * f * r12 - b * g * r13),
            v - scale * (a * g * r13 - a * d * r23 + d * e * r12 - c * g * r12),
            w - scale * (c * f * r12 - b * c * r23 + b * e * r13 - a * f * r13),
        ]
    }

    /// An intersection of the conics scaled to the edges and refined; `None` where it is none, or a distance is not positive.
    fn refine(&self, x: [f64; 3]) -> Option<[f64; 3]> {
        let [d1, d2, d3] = self.distances(x);
        let sum = d1 + d2 + d3;
        let sign = 1f64.copysign(sum);
        // Mixed signs leave early, but not those that refining could still turn.
        let least = (sign * d1).min(sign * d2).min(sign * d3);
        if !(least > -1e-3 * sum.abs()) {
            return None;
        }
        let squares: f64 = self.squares.iter().sum();
        let residuals: f64 = self.residuals(x).iter().sum();
        let scale = sign * (squares / (residuals + squares)).sqrt();
        let mut x = x.map(|c| c * scale);
        let mut r = self.residuals(x);
        let size = |r: &[f64; 3]| r[0].abs() + r[1].abs() + r[2].abs();
        for _ in 0..6 {
            if size(&r) <= f64::EPSILON {
                break;
            }
            let next = self.step(x, r);
            let after = self.residuals(next);
            if !(size(&after) < size(&r)) {
                break;
            }
            (x, r) = (next, after);
        }
        let fulfilled = (0..3).all(|k| r[k].abs() <= 1e-11 * self.squares[k] + 32.0 * f64::EPSILON);
        (fulfilled && self.distances(x).iter().all(|d| *d > 0.0)).then_some(x)
    }

    /// The pose that brings the object's triangle onto the directions at these distances.
    fn pose(&self, x: &[f64; 3]) -> Pose {
        let [_, v, w] = *x;
        let [d1, d2, d3] = self.distances(*x);
        let b1 = self.directions[0];
        // d₂ b₂ − d₁ b₁ without the difference of two long vectors.
        let seen = [b1 * v + self.turns[0] * d2, b1 * w + self.turns[1] * d3];
        let along = usize::from(self.squares[1] > self.squares[0]);
        let rotation = axes(&seen, along) * axes(&self.edges, along).transpose();
        let center_in_camera = b1 * d1 + (seen[0] + seen[1]) / 3.0;
        let centroid = (self.edges[0] + self.edges[1]) / 3.0;
        let origin = self.first + (centroid - rotation.tr_mul(&center_in_camera)) * self.unit;
        Pose::new(Rotation3::from_matrix_unchecked(rotation), origin)
    }
}

/// The right-handed axes of a triangle, the first along the given one of its two edges, the third normal to it.
fn axes(edges: &[Vector3<f64>; 2], along: usize) -> Matrix3<f64> {
    let first = edges[along].normalize();
    let normal = edges[0].cross(&edges[1]).normalize();
    Matrix3::from_columns(&[first, normal.cross(&first), normal])
}

/// The coefficients, constant first, of det(Q₁ + λ Q₂).
fn pencil(q1: &Conic, q2: &Conic) -> [f64; 4] {
    let (b1, b2) = (adjugate(q1), adjugate(q2));
    let row = |b: &Conic, q: &Conic| {
        b[(0, 0)] * q[(0, 0)] + b[(0, 1)] * q[(0, 1)] + b[(0, 2)] * q[(0, 2)]
    };
    [row(&b1, q1), b1.dot(q2), b2.dot(q1), row(&b2, q2)]
}

/// The adjugate of a symmetric matrix.
fn adjugate(m: &Conic) -> Conic {
    let (uu, vv, ww) = (m[(0, 0)], m[(1, 1)], m[(2, 2)]);
    let (uv, uw, vw) = (m[(0, 1)], m[(0, 2)], m[(1, 2)]);
    let (a, b, c) = (vv * ww - vw * vw, uw * vw - uv * ww, uv * vw - uw * vv);
    let (d, e, f) = (uu * ww - uw * uw, uv * uw - uu * vw, uu * vv - uv * uv);
    Matrix3::new(a, b, c, b, d, e, c, e, f)
}

/// The two lines l, m of a degenerate conic l mᵀ + m lᵀ; `None` where they are not real.
///
/// Its adjugate is −p pᵀ with p = l × m, where the lines meet, and l mᵀ + m lᵀ + [p]× = 2 m lᵀ.
fn lines(conic: &Conic) -> Option<[Vector3<f64>; 2]> {
    let adjugate = adjugate(conic);
    let k = adjugate.diagonal().icamax();
    let largest = adjugate[(k, k)];
    let mut p = Vector3::zeros();
    if largest < 0.0 {
        p = adjugate.column(k) / (-largest).sqrt();
    } else if largest > 1e-10 * conic.norm_squared() {
        return None;
    }
    let product = conic + p.cross_matrix();
    let (i, j) = product.iamax_full();
    Some([product.row(i).transpose(), product.column(j).into_owned()])
}
