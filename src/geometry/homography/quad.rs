//! Homographies from four points: the closed forms and the linear system.

use core::ops::{Add, Mul, Sub};

use nalgebra::{Matrix3, Point2, SMatrix, SVector};

use super::{Homography, unit_power};
use crate::error::Error;
use crate::numeric::twofold::{Twofold, determinant};

/// The corners that [`Homography::from_unit_square`] maps from, in order.
const UNIT_SQUARE: [Point2<f64>; 4] =
    [Point2::new(0.0, 0.0), Point2::new(1.0, 0.0), Point2::new(1.0, 1.0), Point2::new(0.0, 1.0)];

/// (3 + 16 u) u, u = 2⁻⁵³: a 2×2 determinant of rounded differences smaller than this times the sum of its products'
/// magnitudes has no certain sign (Shewchuk 1997, the first stage of ORIENT2D).
const ORIENTATION: f64 = (3.0 + 8.0 * f64::EPSILON) * (0.5 * f64::EPSILON);

/// The backward error up to which a map is accepted. Its evaluation in floats may be wrong by 2.5 ε, so the true one is
/// below 16 ε.
const ACCEPTED: f64 = 13.0 * f64::EPSILON;

impl Homography {
    /// The unit square onto a quad: (0, 0), (1, 0), (1, 1), (0, 1) onto the corners in this order, which may turn either
    /// way.
    ///
    /// ```text
    /// wᵢ = the area of the triangle of the other three corners,   w₀ q̃₀ − w₁ q̃₁ + w₂ q̃₂ − w₃ q̃₃ = 0
    /// H = ( w₁ q̃₁ − w₀ q̃₀ | w₃ q̃₃ − w₀ q̃₀ | w₀ q̃₀ ),   q̃ = (x, y, 1)
    /// ```
    ///
    /// This is the square-to-quadrilateral map of Heckbert (1989), Fundamentals of Texture Mapping and Image Warping,
    /// §2.2.3, without its division. A parallelogram gives an affine map exactly.
    ///
    /// *Accuracy.* Each corner is the exact image of its own under a matrix whose entries differ from H's by at most 16 ε
    /// of their size (the componentwise backward error of Oettli & Prager 1964), for extents from 1e-150 to 1e150.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Degenerate`] where three corners lie on a line to rounding (the measure is the
    /// triangle's area over the sum of the products that make it up) or where one lies so far off that its denominator
    /// is lost beside the others'; [`Error::FoldedQuad`] for a concave or self-crossing quad.
    #[inline]
    #[doc(alias("square_to_quad", "square to quadrilateral"))]
    pub fn from_unit_square(quad: &[Point2<f64>; 4]) -> Result<Self, Error> {
        let [q0, q1, q2, q3] = quad;
        let areas = Areas::new(quad);
        if !areas.convex() {
            return Err(refuse(quad, "quad: three corners on a line"));
        }
        let (u, v) = (q1 - q0, q3 - q0);
        if u == q2 - q3 {
            let matrix = Matrix3::new(u.x, v.x, q0.x, u.y, v.y, q0.y, 0.0, 0.0, 1.0);
            return Ok(Self { matrix });
        }
        // Backward error. Corners 0, 1 and 3 are met whatever the areas are, to the rounding of the entries. Corner 2 asks
        // for w₀ d₀ = w₁ d₁ + w₃ d₃ with dᵢ = qᵢ − q₂, which holds exactly for the areas of the rounded differences (1 u
        // each). Areas wrong by δ leave (δ + u) Σ wᵢ|dᵢ|, and Σ wᵢ|qᵢ| ≤ 3 |H|·(1, 1, 1): with δ ≤ 5 u that is 18 u, with
        // 6 u for the entries 24 u = 12 ε at most.
        let areas = if areas.rounds_well() { areas } else { Areas::compensated(quad) };
        let [w0, w1, _, w3] = areas.area.map(f64::abs);
        let column = |w: f64, q: &Point2<f64>| [w * q.x - w0 * q0.x, w * q.y - w0 * q0.y, w - w0];
        let (a, b, c) = (column(w1, q1), column(w3, q3), [w0 * q0.x, w0 * q0.y, w0]);
        let far = a[2] + b[2] + c[2];
        if !(far > 0.0 && (a[0] + b[0] + c[0]).is_finite() && (a[1] + b[1] + c[1]).is_finite()) {
            return Err(lost(far / w0));
        }
        Ok(Self { matrix: Matrix3::new(a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]) })
    }

    /// A quad onto the unit square, its corners onto (0, 0), (1, 0), (1, 1), (0, 1) in this order.
    ///
    /// Accuracy and errors as [`from_quads`](Self::from_quads).
    ///
    /// # Errors
    /// As [`from_unit_square`](Self::from_unit_square).
    #[doc(alias("quad_to_square", "quadrilateral to square"))]
    pub fn to_unit_square(quad: &[Point2<f64>; 4]) -> Result<Self, Error> {
        let areas = Areas::new(quad);
        if !areas.convex() {
            return Err(refuse(quad, "quad: three corners on a line"));
        }
        from_areas(quad, &areas, &UNIT_SQUARE, &Areas::new(&UNIT_SQUARE))
    }

    /// One quad onto another, corner onto corner. Each may turn either way.
    ///
    /// ```text
    /// H = Σ (wᵢ/ωᵢ) q̃ᵢ (p̃ⱼ × p̃ₖ)ᵀ,   i, j, k = 0, 1, 3 in turn
    /// ```
    ///
    /// where p are the source's corners with their areas ω, q the target's with w (see
    /// [`from_unit_square`](Self::from_unit_square)).
    ///
    /// *Accuracy.* The componentwise backward error at every corner is at most 16 ε:
    ///
    /// ```text
    /// |P·p̃ − u R·p̃| ≤ 16 ε (|P|·|p̃| + |u| |R|·|p̃|)
    /// ```
    ///
    /// It is tested before the map is returned; where plain floats miss it, the form is evaluated again in twofold
    /// precision.
    ///
    /// # Errors
    /// As [`from_unit_square`](Self::from_unit_square), for either quad.
    ///
    /// # Example
    /// With the numbers of `PerspectiveTransformTestCase` of zxing (Owen), computed there in single precision:
    /// ```
    /// use collinear::geometry::Homography;
    /// use nalgebra::Point2;
    ///
    /// let points = |c: [(f64, f64); 4]| c.map(|(x, y)| Point2::new(x, y));
    /// let map = Homography::from_quads(
    ///     &points([(2.0, 3.0), (10.0, 4.0), (16.0, 15.0), (4.0, 9.0)]),
    ///     &points([(103.0, 110.0), (300.0, 120.0), (290.0, 270.0), (150.0, 280.0)]),
    /// )?;
    /// let image = map.apply_unoriented(&Point2::new(50.0, 50.0))?;
    /// assert!((image - Point2::new(328.09116, 334.16385)).norm() < 1e-4);
    /// # Ok::<(), collinear::Error>(())
    /// ```
    #[doc(alias("getPerspectiveTransform", "quad_to_quad"))]
    pub fn from_quads(source: &[Point2<f64>; 4], target: &[Point2<f64>; 4]) -> Result<Self, Error> {
        let (from, to) = (Areas::new(source), Areas::new(target));
        if !from.convex() {
            return Err(refuse(source, "source quad: three corners on a line"));
        }
        if !to.convex() {
            return Err(refuse(target, "target quad: three corners on a line"));
        }
        from_areas(source, &from, target, &to)
    }

    /// The map that takes four points to four others, in any order, no three on a line. With
    /// [`from_quads`](Self::from_quads) the points are corners in turn; here they may be as in a random sample.
    ///
    /// # Errors
    /// As [`from_quads`](Self::from_quads), with [`Error::FoldedQuad`] where no map keeps all four points on one side of
    /// its horizon; its weights are then the products of the corresponding areas of source and target.
    pub fn from_four_points(
        source: &[Point2<f64>; 4],
        target: &[Point2<f64>; 4],
    ) -> Result<Self, Error> {
        let (from, to) = (Areas::new(source), Areas::new(target));
        if !from.certain() {
            return Err(refuse(source, "source points: three on a line"));
        }
        if !to.certain() {
            return Err(refuse(target, "target points: three on a line"));
        }
        let products: [f64; 4] = core::array::from_fn(|i| from.area[i] * to.area[i]);
        if products.iter().any(|p| (*p > 0.0) != (products[0] > 0.0)) {
            return Err(Error::FoldedQuad { weights: products });
        }
        from_areas(source, &from, target, &to)
    }

    /// The eight linear equations of \[WD\] eq. 2 with R₀ = 1, by elimination with partial pivoting: the textbook solver,
    /// kept for comparison. [`from_quads`](Self::from_quads) is faster, more exact, and has no excluded maps.
    ///
    /// ```text
    /// P₀ + S P₁ + L P₂ − S u R₁ − L u R₂ = u
    /// Q₀ + S Q₁ + L Q₂ − S v R₁ − L v R₂ = v            Weinhaus & Devarajan 1997, eq. 2
    /// ```
    ///
    /// # Errors
    /// As [`from_four_points`](Self::from_four_points), and [`Error::Degenerate`] where the map sends the origin to
    /// infinity, so that R₀ vanishes and cannot be one. The measure is then R₀ over the largest |R₀| + |R₁ S| + |R₂ L|.
    pub fn from_four_points_linear(
        source: &[Point2<f64>; 4],
        target: &[Point2<f64>; 4],
    ) -> Result<Self, Error> {
        const LIMIT: f64 = 64.0 * f64::EPSILON;
        for points in [source, target] {
            if !Areas::new(points).certain() {
                return Err(refuse(points, "equation 2: three points on a line"));
            }
        }
        let mut a = SMatrix::<f64, 8, 8>::zeros();
        let mut b = SVector::<f64, 8>::zeros();
        for (i, (s, t)) in source.iter().zip(target).enumerate() {
            for (axis, u) in [t.x, t.y].into_iter().enumerate() {
                let row = 2 * i + axis;
                let block = 3 * axis;
                a[(row, block)] = 1.0;
                a[(row, block + 1)] = s.x;
                a[(row, block + 2)] = s.y;
                a[(row, 6)] = -s.x * u;
                a[(row, 7)] = -s.y * u;
                b[row] = u;
            }
        }
        let vanishing = |measure| Error::Degenerate {
            what: "R0 in equation 2 (the map sends the origin to infinity: use from_quads)",
            measure,
            limit: LIMIT,
        };
        let x = a.lu().solve(&b).ok_or(vanishing(0.0))?;
        let largest = source
            .iter()
            .map(|s| 1.0 + (x[6] * s.x).abs() + (x[7] * s.y).abs())
            .fold(0.0, f64::max);
        if largest.is_nan() || 1.0 / largest <= LIMIT {
            return Err(vanishing(if largest.is_finite() { 1.0 / largest } else { 0.0 }));
        }
        let matrix = Matrix3::new(x[1], x[2], x[0], x[4], x[5], x[3], x[6], x[7], 1.0);
        let w = source.map(|s| x[6] * s.x + x[7] * s.y + 1.0);
        if w.iter().all(|w| *w > 0.0) {
            Self::from_matrix(matrix)
        } else if w.iter().all(|w| *w < 0.0) {
            Self::from_matrix(-matrix)
        } else {
            Err(Error::FoldedQuad { weights: w })
        }
    }
}

/// Twice the signed areas of the four triangles that leave out one corner each, in units of `unit`, and the sums of the
/// magnitudes of the products that make them up.
struct Areas {
    area: [f64; 4],
    permanent: [f64; 4],
    unit: [f64; 2],
}

impl Areas {
    /// In plain floats: each to 5 u of itself where [`rounds_well`](Self::rounds_well), u = 2⁻⁵³.
    #[inline]
    fn new(quad: &[Point2<f64>; 4]) -> Self {
        Self::with(quad, |a, b, c, d| a * d - b * c)
    }

    /// However far they cancel, each to 2 u of what the rounded differences of the corners give.
    #[cold]
    fn compensated(quad: &[Point2<f64>; 4]) -> Self {
        Self::with(quad, determinant)
    }

    #[inline(always)]
    fn with(
        [q0, q1, q2, q3]: &[Point2<f64>; 4],
        determinant: impl Fn(f64, f64, f64, f64) -> f64,
    ) -> Self {
        let (d0, d1, d3) = (q0 - q2, q1 - q2, q3 - q2);
        let (u, v) = (q1 - q0, q3 - q0);
        // Powers of two that bring each axis near one: only ratios of areas matter, and no product may underflow.
        let unit = [0, 1].map(|k| unit_power(d0[k].abs().max(d1[k].abs()).max(d3[k].abs())));
        let [d0, d1, d3, u, v] = [d0, d1, d3, u, v].map(|d| [d.x * unit[0], d.y * unit[1]]);
        let pairs = [(d3, d1), (d3, d0), (u, v), (d0, d1)];
        Self {
            area: pairs.map(|(a, b)| determinant(a[0], a[1], b[0], b[1])),
            permanent: pairs.map(|(a, b)| (a[0] * b[1]).abs() + (a[1] * b[0]).abs()),
            unit,
        }
    }

    /// Whether no area is a small difference of large products.
    #[inline]
    fn rounds_well(&self) -> bool {
        (0..4).all(|i| 4.0 * self.area[i].abs() >= self.permanent[i])
    }

    /// Whether every area's sign is certain; NaN is not.
    #[inline]
    fn certain(&self) -> bool {
        (0..4).all(|i| self.area[i].abs() > ORIENTATION * self.permanent[i])
    }

    /// Whether the corners go once around a convex quad.
    #[inline]
    fn convex(&self) -> bool {
        let sign = 1.0f64.copysign(self.area[0]);
        (0..4).all(|i| self.area[i] * sign > ORIENTATION * self.permanent[i])
    }
}

/// Why these corners make no quad.
#[cold]
fn refuse(quad: &[Point2<f64>; 4], line: &'static str) -> Error {
    let areas = Areas::new(quad);
    if !quad.iter().all(|q| q.x.is_finite() && q.y.is_finite()) {
        return Error::NotFinite { what: "quad corner" };
    }
    if !areas.permanent.iter().all(|p| p.is_finite()) {
        return Error::NotFinite { what: "quad extent" };
    }
    for (area, permanent) in areas.area.iter().zip(areas.permanent) {
        if area.abs() <= ORIENTATION * permanent {
            let measure = if permanent > 0.0 { area.abs() / permanent } else { 0.0 };
            return Error::Degenerate { what: line, measure, limit: ORIENTATION };
        }
    }
    // The triangle that leaves out a corner stands at the one opposite.
    let [w0, w1, w2, w3] = areas.area.map(|a| a / areas.unit[0] / areas.unit[1]);
    Error::FoldedQuad { weights: [w2, w3, w0, w1] }
}

/// A corner beside whose neighbours' denominators its own is rounding.
#[cold]
fn lost(measure: f64) -> Error {
    let measure = if measure.is_finite() { measure } else { 0.0 };
    Error::Degenerate { what: "quad: a corner near infinity", measure, limit: ACCEPTED }
}

/// The map between four points and four, whose areas are known to agree in sign.
#[inline(always)]
fn from_areas(
    source: &[Point2<f64>; 4],
    from: &Areas,
    target: &[Point2<f64>; 4],
    to: &Areas,
) -> Result<Homography, Error> {
    let (s, t) = (Frame::new(source), Frame::new(target));
    let matrix = compose(&s, &s.points(source), from.area, &t, &t.points(target), to.area);
    if takes(&matrix, source, target) {
        return Ok(Homography { matrix });
    }
    in_twofold(source, &s, target, &t)
}

#[cold]
fn in_twofold(
    source: &[Point2<f64>; 4],
    s: &Frame,
    target: &[Point2<f64>; 4],
    t: &Frame,
) -> Result<Homography, Error> {
    let (from, to): ([[Twofold; 2]; 4], [[Twofold; 2]; 4]) = (s.points(source), t.points(target));
    let matrix = compose(s, &from, exact_areas(&from), t, &to, exact_areas(&to));
    if takes(&matrix, source, target) {
        return Ok(Homography { matrix });
    }
    let w = source.map(|p| Homography { matrix }.w(&p));
    let largest = w.iter().fold(0.0, |l: f64, w| l.max(w.abs()));
    Err(lost(w.iter().fold(f64::INFINITY, |l: f64, w| l.min(*w)) / largest))
}

/// What the closed form is evaluated in: plain floats, or twofold precision.
trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn exact(value: f64) -> Self;
    fn difference(a: f64, b: f64) -> Self;
    fn times_power(self, power: f64) -> Self;
    fn nearest(self) -> f64;
}

impl Real for f64 {
    fn exact(value: f64) -> Self {
        value
    }
    fn difference(a: f64, b: f64) -> Self {
        a - b
    }
    fn times_power(self, power: f64) -> Self {
        self * power
    }
    fn nearest(self) -> f64 {
        self
    }
}

impl Real for Twofold {
    fn exact(value: f64) -> Self {
        Self::new(value)
    }
    fn difference(a: f64, b: f64) -> Self {
        Self::difference(a, b)
    }
    fn times_power(self, power: f64) -> Self {
        self.scale(power)
    }
    fn nearest(self) -> f64 {
        self.round()
    }
}

/// Where four points are brought near the origin and to size one: x ↦ (x − anchor) · power on each axis.
///
/// The anchor is the coordinate of least magnitude. Then no difference exceeds twice the coordinate it came from, and
/// undoing the shift costs a backward error of a few roundings of the points themselves.
struct Frame {
    anchor: [f64; 2],
    power: [f64; 2],
}

impl Frame {
    #[inline(always)]
    fn new(points: &[Point2<f64>; 4]) -> Self {
        let axis = |c: [f64; 4]| {
            let anchor = c.iter().fold(c[0], |a, b| if b.abs() < a.abs() { *b } else { a });
            let extent = c.iter().fold(0.0, |e: f64, b| e.max((b - anchor).abs()));
            (anchor, unit_power(extent))
        };
        let (x, y) = (axis(points.map(|p| p.x)), axis(points.map(|p| p.y)));
        Self { anchor: [x.0, y.0], power: [x.1, y.1] }
    }

    #[inline(always)]
    fn points<T: Real>(&self, points: &[Point2<f64>; 4]) -> [[T; 2]; 4] {
        points
            .map(|p| [0, 1].map(|k| T::difference(p[k], self.anchor[k]).times_power(self.power[k])))
    }
}

fn exact_areas(q: &[[Twofold; 2]; 4]) -> [Twofold; 4] {
    let edge = |i: usize, j: usize| [q[i][0] - q[j][0], q[i][1] - q[j][1]];
    let cross = |a: [Twofold; 2], b: [Twofold; 2]| a[0] * b[1] - a[1] * b[0];
    let (d0, d1, d3) = (edge(0, 2), edge(1, 2), edge(3, 2));
    [cross(d3, d1), cross(d3, d0), cross(edge(1, 0), edge(3, 0)), cross(d0, d1)]
}

/// H = Σ (wᵢ/ωᵢ) q̃ᵢ (p̃ⱼ × p̃ₖ)ᵀ in the frames, multiplied by all ω, and brought back to the points' own coordinates.
#[inline(always)]
fn compose<T: Real>(
    s: &Frame,
    p: &[[T; 2]; 4],
    omega: [T; 4],
    t: &Frame,
    q: &[[T; 2]; 4],
    w: [T; 4],
) -> Matrix3<f64> {
    const BASE: [usize; 3] = [0, 1, 3];
    let one = T::exact(1.0);
    // At corner i the denominator is (wᵢ/ωᵢ) Πω: positive.
    let front = w[0].nearest() * omega[1].nearest() * omega[2].nearest() * omega[3].nearest();
    let sign = T::exact(1.0f64.copysign(front));
    let mut h = [[T::exact(0.0); 3]; 3];
    for n in 0..3 {
        let [i, j, k] = [BASE[n], BASE[(n + 1) % 3], BASE[(n + 2) % 3]];
        let factor = sign * w[i] * omega[j] * omega[k];
        let line = [p[j][1] - p[k][1], p[k][0] - p[j][0], p[j][0] * p[k][1] - p[k][0] * p[j][1]];
        for (row, coordinate) in h.iter_mut().zip([q[i][0], q[i][1], one]) {
            let weighted = factor * coordinate;
            for (entry, l) in row.iter_mut().zip(line) {
                *entry = *entry + weighted * l;
            }
        }
    }
    for row in &mut h {
        for (entry, power) in row.iter_mut().zip(s.power) {
            *entry = entry.times_power(power);
        }
        row[2] = row[2] - row[0] * T::exact(s.anchor[0]) - row[1] * T::exact(s.anchor[1]);
    }
    let [u, v, w] = h;
    let back = |row: [T; 3], axis: usize| -> [f64; 3] {
        let (unit, anchor) = (1.0 / t.power[axis], T::exact(t.anchor[axis]));
        core::array::from_fn(|l| (row[l].times_power(unit) + anchor * w[l]).nearest())
    };
    let (u, v, w) = (back(u, 0), back(v, 1), w.map(T::nearest));
    Matrix3::new(u[0], u[1], u[2], v[0], v[1], v[2], w[0], w[1], w[2])
}

/// Whether the matrix takes every source point, in front of its horizon, to its target within the accepted backward
/// error. Four points at a time and without a branch, which compiles to vectors.
#[inline(always)]
fn takes(m: &Matrix3<f64>, source: &[Point2<f64>; 4], target: &[Point2<f64>; 4]) -> bool {
    let row = |i: usize| {
        let (a, b, c) = (m[(i, 0)], m[(i, 1)], m[(i, 2)]);
        let terms = source.map(|s| (a * s.x, b * s.y));
        (terms.map(|(x, y)| x + y + c), terms.map(|(x, y)| x.abs() + y.abs() + c.abs()))
    };
    let ((u, u_sum), (v, v_sum), (w, w_sum)) = (row(0), row(1), row(2));
    let mut good = true;
    for i in 0..4 {
        let (x, y) = (target[i].x, target[i].y);
        good &= w[i] > 0.0;
        good &= (u[i] - x * w[i]).abs() <= ACCEPTED * (u_sum[i] + x.abs() * w_sum[i]);
        good &= (v[i] - y * w[i]).abs() <= ACCEPTED * (v_sum[i] + y.abs() * w_sum[i]);
        good &= u_sum[i] + v_sum[i] + w_sum[i] < f64::INFINITY;
    }
    good
}
