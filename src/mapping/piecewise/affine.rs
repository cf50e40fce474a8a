//! Triangles, an affine map in each.

use alloc::vec::Vec;
use core::ops::{ControlFlow, Range};

use nalgebra::{Matrix2, Point2};

use super::triangulation::{Crossing, Triangulation, barycentric_gradients, between};
use crate::error::{Error, ProjectionError};
use crate::mapping::blocks::{Gather, centre, first_beyond, first_from};
use crate::mapping::{BlockSink, Map, control};

/// The piecewise affine map through control points (Goshtasby 1986): in each Delaunay triangle of the screen points the
/// affine map of its corners.
///
/// ```text
/// u(p) = Σ λₖ uₖ,   p = Σ λₖ pₖ,   Σ λₖ = 1                    k = 1 … 3, the corners of p's triangle
/// ```
///
/// It passes through all control points and is continuous; its derivatives jump at the edges.
///
/// *Domain.* The convex hull of the screen points, its border included to rounding. *Cost.* A row follows its triangles
/// from the one to the next; one addition and one product a pixel and coordinate. [`at`](Map::at) follows its row as
/// well: about √n triangles of n. *Accuracy.* A few rounding errors of the texture
/// coordinates; in triangles thinner than the rounding of their corners, somewhere between the corners' values.
///
/// # Example
/// A square pulled at one corner. Delaunay's diagonal is that from (10, 0) to (0, 10); (6, 6) lies beyond it with the
/// weights 3/7, 1/7 and 3/7 of the triangle (10, 0), (12, 12), (0, 10):
///
/// ```
/// use collinear::mapping::{Map, piecewise::PiecewiseAffine};
/// use nalgebra::Point2;
///
/// let points = |c: [(f64, f64); 4]| c.map(|(x, y)| Point2::new(x, y));
/// let screen = points([(0., 0.), (10., 0.), (12., 12.), (0., 10.)]);
/// let texture = points([(0., 0.), (10., 0.), (14., 10.), (0., 10.)]);
/// let map = PiecewiseAffine::new(&screen, &texture)?;
/// assert!((map.at(&Point2::new(6.0, 6.0))? - Point2::new(44.0 / 7.0, 40.0 / 7.0)).norm() < 1e-14);
/// assert!(map.at(&Point2::new(12.0, 6.0)).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[doc(alias("PiecewiseAffineTransform", "LinearNDInterpolator", "rubber sheet"))]
pub struct PiecewiseAffine {
    triangles: Triangulation,
    texture: Vec<Point2<f64>>,
}

impl PiecewiseAffine {
    /// The map that takes each screen point to its texture point.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`], [`Error::TooFewPoints`] below three, [`Error::NotFinite`], [`Error::OutOfRange`] for
    /// coordinates over 1e100, and [`Error::Degenerate`] where the screen points lie on one line to rounding (the measure is
    /// twice the area of their triangles over the square of their extent) or coincide (the measure is how many are corners).
    pub fn new(screen: &[Point2<f64>], texture: &[Point2<f64>]) -> Result<Self, Error> {
        control::check(screen, texture, 3)?;
        Ok(Self { triangles: Triangulation::new(screen)?, texture: texture.to_vec() })
    }

    /// The triangles, by the indices of their control points.
    #[must_use]
    pub fn triangles(&self) -> Vec<[usize; 3]> {
        self.triangles.corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
    }

    /// The texture point where a row meets an edge: the same in both triangles of the edge.
    fn value(&self, crossing: &Crossing<usize>) -> [f64; 2] {
        let [p, q] = crossing.ends.map(|i| self.texture[i]);
        [between(p.x, q.x, crossing.share), between(p.y, q.y, crossing.share)]
    }
}

/// A stretch of a row on which coordinates are linear.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    x: f64,
    start: [f64; 2],
    slope: [f64; 2],
}

impl Stretch {
    pub(super) fn new(left: f64, start: [f64; 2], right: f64, end: [f64; 2]) -> Self {
        let width = right - left;
        let slope = |k: usize| if width > 0.0 { (end[k] - start[k]) / width } else { 0.0 };
        Self { x: left, start, slope: [slope(0), slope(1)] }
    }

    #[inline(always)]
    pub(super) fn at(&self, x: f64) -> [f64; 2] {
        core::array::from_fn(|k| self.start[k] + self.slope[k] * (x - self.x))
    }

    #[inline(always)]
    pub(super) fn fill(&self, first: i32, u: &mut [f64], v: &mut [f64]) {
        for (i, (u, v)) in u.iter_mut().zip(v).enumerate() {
            [*u, *v] = self.at(centre(first + i as i32));
        }
    }
}

impl Map for PiecewiseAffine {
    /// [`ProjectionError::OutsideDomain`] outside the hull, with how far the hull is along the row (or the column, where the row
    /// misses it) and the limit zero.
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [left, right] =
            self.triangles.locate(screen)?.map(|h| self.triangles.crossing(screen.y, h));
        let stretch = Stretch::new(left.x, self.value(&left), right.x, self.value(&right));
        Ok(stretch.at(screen.x).into())
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        let t = self.triangles.locate(screen)?[0] / 3;
        let gradients = barycentric_gradients(&self.triangles.triangle(t))?;
        let origin = self.texture[self.triangles.corners[3 * t]];
        let mut jacobian = Matrix2::zeros();
        for k in 1..3 {
            let d = self.texture[self.triangles.corners[3 * t + k]] - origin;
            jacobian += d * gradients[k].transpose();
        }
        Ok(jacobian)
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        let y = centre(line);
        let mut row = Gather::new(emit);
        let mut rest = samples;
        let mut left: Option<(Crossing<usize>, [f64; 2])> = None;
        // A row that misses the hull has no pixels.
        let _ = self.triangles.walk(y, |entry, exit| {
            let (start, from) = left.unwrap_or_else(|| {
                let crossing = self.triangles.crossing(y, entry);
                rest.start = first_from(crossing.x, &rest);
                (crossing, self.value(&crossing))
            });
            let end = self.triangles.crossing(y, exit);
            let to = self.value(&end);
            left = Some((end, to));
            let last = self.triangles.ends(exit);
            let stop = if last { first_beyond(end.x, &rest) } else { first_from(end.x, &rest) };
            let stretch = Stretch::new(start.x, from, end.x, to);
            row.run(rest.start..stop, |x, u, v| stretch.fill(x, u, v));
            rest.start = stop;
            if rest.is_empty() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        row.flush();
    }
}
