//! A polygon on its way to the screen: projected, clipped, snapped.

use alloc::vec::Vec;

use nalgebra::{Point2, Point3, Vector3};

use super::outline;
use super::scan::{self, PixelSpan, SUBPIXELS, Snapped};
use crate::camera::HomogeneousCamera;
use crate::error::Error;
use crate::numeric::float;

/// Which side of a polygon is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Facing {
    /// Both sides.
    #[default]
    Both,
    /// Only polygons whose vertices turn counter-clockwise as seen on the screen: their front.
    Front,
    /// Only polygons whose vertices turn clockwise as seen on the screen.
    #[doc(alias = "front-face culling")]
    Back,
}

/// A polygon of the world as the screen sees it.
///
/// The polygon has three or more vertices, convex or concave, in one plane. What lies nearer than the near plane, and what
/// lies outside ±2²⁰ pixels, is cut off in homogeneous coordinates before the division, so no vertex behind the eye is ever
/// divided. Two polygons that share an edge are cut at the same points of it.
///
/// *Accuracy.* Coverage is exact for the vertices rounded to 1/256 pixel: no floating-point number decides which pixels
/// are covered.
///
/// # Example
/// The triangle (0, 0), (4, 0), (0, 4) contains the six centres with x + y < 4. Those on its long side, a right edge, are
/// its neighbour's:
///
/// ```
/// use collinear::camera::{ExteriorOrientation, Orthographic};
/// use collinear::geometry::Affine2;
/// use collinear::texturer::ScreenPolygon;
/// use nalgebra::{Point3, Rotation3};
///
/// let flat = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
/// let screen = Orthographic::new(flat, Affine2::identity())?.homogeneous();
/// let triangle = [(0.0, 0.0), (4.0, 0.0), (0.0, 4.0)].map(|(x, y)| Point3::new(x, y, 1.0));
/// let mut rows = Vec::new();
/// ScreenPolygon::project(&triangle, &screen, 0.1)?.spans(100, 100, |span| rows.push((span.y, span.x)));
/// assert_eq!(rows, [(0, 0..3), (1, 0..2), (2, 0..1)]);
/// # Ok::<(), collinear::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ScreenPolygon {
    vertices: Vec<Point2<f64>>,
    snapped: Vec<Snapped>,
}

/// The screen is cut at ±2²⁰ pixels, so that edge crossings are exact in 64-bit integers.
const GUARD_BAND: f64 = 1_048_576.0;

/// The largest homogeneous coordinate of a vertex: products with the guard band stay far from overflow.
const LARGEST_COORDINATE: f64 = 1e150;

/// A bound at which a homogeneous polygon is cut.
#[derive(Clone, Copy)]
enum Cut {
    /// w = near.
    Near(f64),
    /// x or y (0 or 1) = ±2²⁰ w.
    Side(usize, f64),
}

impl Cut {
    /// Not negative on the side that stays.
    fn inside(self, v: &Vector3<f64>) -> f64 {
        match self {
            Self::Near(near) => v.z - near,
            Self::Side(axis, sign) => GUARD_BAND * v.z - sign * v[axis],
        }
    }

    /// The point of an edge on the bound, from the inner end p and the outer end q.
    ///
    /// Weights instead of a step from p: of coordinates of 10¹⁰⁰ a step leaves nothing of the small ones. The bound's own
    /// coordinate is set, for the same reason.
    fn meet(self, p: &Vector3<f64>, q: &Vector3<f64>) -> Vector3<f64> {
        let (fp, fq) = (self.inside(p), self.inside(q));
        let mut v = p * (-fq / (fp - fq)) + q * (fp / (fp - fq));
        match self {
            Self::Near(near) => v.z = near,
            Self::Side(axis, sign) => v[axis] = sign * GUARD_BAND * v.z,
        }
        v
    }
}

/// Cuts a homogeneous polygon (Sutherland & Hodgman 1974).
///
/// A concave polygon may come out with edges that run back along the cut; they enclose no area and cover no pixel.
fn clip(polygon: &[Vector3<f64>], cut: Cut) -> Vec<Vector3<f64>> {
    let mut out = Vec::with_capacity(polygon.len() + 2);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (a_stays, b_stays) = (cut.inside(a) >= 0.0, cut.inside(b) >= 0.0);
        if a_stays {
            out.push(*a);
        }
        if a_stays != b_stays {
            // Always from the inner to the outer end: the neighbour across this edge computes the same point.
            let (p, q) = if a_stays { (a, b) } else { (b, a) };
            out.push(cut.meet(p, q));
        }
    }
    out
}

impl ScreenPolygon {
    /// Projects a polygon. `near` is the depth, in world units, before which nothing is drawn; a parallel screen ignores
    /// it. The result may be empty.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for fewer than three vertices, [`Error::NotFinite`], and [`Error::OutOfRange`] for a near
    /// distance that is not positive or a homogeneous coordinate beyond 10¹⁵⁰.
    pub fn project(
        world: &[Point3<f64>],
        screen: &HomogeneousCamera,
        near: f64,
    ) -> Result<Self, Error> {
        if world.len() < 3 {
            return Err(Error::TooFewPoints { needed: 3, got: world.len() });
        }
        if !(near > 0.0 && near.is_finite()) {
            return Err(Error::OutOfRange {
                what: "near plane",
                value: near,
                expected: "more than 0",
            });
        }
        let homogeneous: Vec<Vector3<f64>> = world
            .iter()
            .map(|p| screen.image_from_world() * (p - screen.origin()).push(1.0))
            .collect();
        for value in homogeneous.iter().flatten().copied() {
            if !value.is_finite() {
                return Err(Error::NotFinite { what: "polygon vertex" });
            }
            if value.abs() > LARGEST_COORDINATE {
                return Err(Error::OutOfRange {
                    what: "homogeneous coordinate of a polygon vertex",
                    value,
                    expected: "at most 1e150 in magnitude",
                });
            }
        }
        // A parallel screen has w = 1 everywhere.
        let near = if screen.is_parallel() { 0.5 } else { near };
        let mut clipped = clip(&homogeneous, Cut::Near(near));
        for axis in 0..2 {
            for sign in [1.0, -1.0] {
                clipped = clip(&clipped, Cut::Side(axis, sign));
            }
        }
        let vertices: Vec<Point2<f64>> =
            clipped.iter().map(|v| Point2::new(v.x / v.z, v.y / v.z)).collect();
        let snap = |c: f64| float::round(c * SUBPIXELS as f64) as i32;
        let snapped = vertices.iter().map(|p| [snap(p.x), snap(p.y)]).collect();
        Ok(Self { vertices, snapped })
    }

    /// The outline in pixels, after clipping and before snapping.
    #[must_use]
    pub fn vertices(&self) -> &[Point2<f64>] {
        &self.vertices
    }

    /// The polygon of some of this one's vertices, in the order given.
    pub(super) fn piece(&self, indices: &[usize]) -> Option<Self> {
        Some(Self {
            vertices: indices
                .iter()
                .map(|&i| self.vertices.get(i).copied())
                .collect::<Option<_>>()?,
            snapped: indices
                .iter()
                .map(|&i| self.snapped.get(i).copied())
                .collect::<Option<_>>()?,
        })
    }

    /// Triangles that cover the polygon, as indices of its vertices, by cutting off ears (Meisters 1975). Exact on the
    /// snapped vertices; an outline that crosses itself is cut as far as it goes.
    pub(super) fn triangles(&self) -> Vec<[usize; 3]> {
        outline::triangles(&self.snapped, self.doubled_area().signum() as i64)
    }

    /// Whether edges that are no neighbours have a point in common. Exact on the snapped vertices.
    pub(super) fn crosses_itself(&self) -> bool {
        outline::crosses_itself(&self.snapped)
    }

    /// Whether nothing is left to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.snapped.len() < 3
    }

    /// Twice the area in 1/256² pixel, positive where the vertices turn counter-clockwise as seen (y down).
    pub(super) fn doubled_area(&self) -> i128 {
        let v = &self.snapped;
        v.iter()
            .zip(v.iter().cycle().skip(1))
            .map(|(a, b)| i128::from(a[1]) * i128::from(b[0]) - i128::from(a[0]) * i128::from(b[1]))
            .sum()
    }

    /// Whether this side of the polygon is to be drawn.
    #[must_use]
    pub fn shows(&self, facing: Facing) -> bool {
        match facing {
            Facing::Both => true,
            Facing::Front => self.doubled_area() > 0,
            Facing::Back => self.doubled_area() < 0,
        }
    }

    /// Visits the polygon's pixels inside a picture, row by row: a pixel belongs to it if its centre does, by the top-left
    /// rule on edges.
    pub fn spans(&self, width: usize, height: usize, visit: impl FnMut(PixelSpan)) {
        scan::scan(&self.snapped, width, height, visit);
    }
}
