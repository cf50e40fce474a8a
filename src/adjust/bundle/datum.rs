//! What places a block in the world.
//!
//! A similarity of the world, X ← X + t + ω × (X − m) + s (X − m), changes no image point. Its seven directions in the
//! space of the unknowns are the columns of G:
//!
//! ```text
//! point, centre   (I, −[X − m]×, X − m)          attitude   (0, −R, 0)
//! ```
//! (R ← R exp(−\[ω\]×) = exp(−\[Rω\]×) R). A free network has them as its null space; inner constraints Bᵀ δ = 0, with B the
//! rows of G that belong to the datum points, choose the solution nearest to the approximate values there, and the
//! covariance of smallest trace (Meissl 1969). Any cofactors Q are brought there by
//!
//! ```text
//! Q ← S Q Sᵀ,   S = I − G (BᵀG)⁻¹ Bᵀ                                        (Baarda 1973)
//! ```

use alloc::vec;
use alloc::vec::Vec;

use nalgebra::{DMatrix, Point3, SMatrix, Vector3};

use super::layout::{Layout, Role};
use super::problem::{Bundle, Kind, PointId};
use super::state::State;
use crate::camera::ExteriorOrientation;
use crate::error::Error;

/// What places the block, for its covariances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Datum<'a> {
    /// What was observed or held: control points, positions, held photographs.
    #[default]
    Given,
    /// Nothing: inner constraints over all object points. Their covariances are the smallest in sum that any datum gives, and
    /// describe the block's shape alone.
    #[doc(alias("free network", "inner constraints", "gauge"))]
    Free,
    /// Inner constraints over these object points, three or more that do not lie on a line: the block is placed by them, and
    /// the covariances of the others are relative to them. Of a block that nothing places, as [`Free`](Self::Free).
    #[doc(alias("minimal constraints", "partial trace minimisation"))]
    Points(&'a [PointId]),
}

/// The directions of G, at most seven.
pub(super) struct Similarity {
    middle: Point3<f64>,
    scale: f64,
    pub(super) count: usize,
    /// The points that place the block, sorted; all where there are none.
    placing: Vec<u32>,
}

fn places_by(placing: &[u32], point: usize) -> bool {
    placing.is_empty() || placing.binary_search(&(point as u32)).is_ok()
}

/// Up to seven columns of three rows.
pub(super) type ThreeRows = SMatrix<f64, 3, 7>;

impl Similarity {
    /// About the middle of some places, in units of their spread.
    pub(super) fn about(places: impl Iterator<Item = Point3<f64>> + Clone) -> Self {
        let n = places.clone().count().max(1) as f64;
        let middle: Point3<f64> =
            places.clone().fold(Vector3::zeros(), |m, p| m + p.coords / n).into();
        let squares = places.map(|p| (p - middle).norm_squared() / n).sum::<f64>();
        let spread = squares.sqrt();
        let scale = if spread > 0.0 && spread.is_finite() { spread } else { 1.0 };
        Self { middle, scale, count: 7, placing: Vec::new() }
    }

    /// That of a datum; `None` where the block is placed by what was given.
    pub(super) fn of_datum<C>(
        datum: Datum<'_>,
        bundle: &Bundle<C>,
        layout: &Layout,
        state: &State<C>,
    ) -> Result<Option<Self>, Error> {
        let mut placing: Vec<u32> = match datum {
            Datum::Given => return Ok(None),
            Datum::Free => Vec::new(),
            Datum::Points(points) => points.iter().map(|p| p.0).collect(),
        };
        let fixed = bundle.points.iter().any(|p| p.kind != Kind::Pass)
            || bundle.images.iter().any(|i| i.held || i.observed_numbers() > 0);
        if fixed {
            return Err(Error::OutOfRange {
                what: "number of given places in a block of free datum",
                value: 1.0,
                expected: "0: no control point, position, attitude or held photograph",
            });
        }
        placing.sort_unstable();
        placing.dedup();
        if placing.last().is_some_and(|p| *p as usize >= bundle.points.len()) {
            return Err(Error::Unknown { what: "datum point" });
        }
        if datum != Datum::Free && placing.len() < 3 {
            return Err(Error::TooFewPoints { needed: 3, got: placing.len() });
        }
        let places = (0..state.points.len())
            .filter(|i| layout.roles[*i] != Role::Constant && places_by(&placing, *i))
            .map(|i| state.points[i]);
        let about = Self::about(places);
        // A distance gives the scale.
        let count = if bundle.distances.is_empty() { 7 } else { 6 };
        Ok(Some(Self { placing, count, ..about }))
    }

    /// What lengths are told in: the spread of the places.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// Whether a point places the block.
    pub(super) fn places_by(&self, point: usize) -> bool {
        places_by(&self.placing, point)
    }

    /// G of a point or a centre, in units of the block's extent.
    pub(super) fn of_point(&self, point: &Point3<f64>) -> ThreeRows {
        let d = (point - self.middle) / self.scale;
        let mut g = ThreeRows::zeros();
        g.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        g.fixed_view_mut::<3, 3>(0, 3).copy_from(&-d.cross_matrix());
        if self.count > 6 {
            g.set_column(6, &d);
        }
        g
    }

    /// G of the six unknowns of a photograph.
    pub(super) fn of_image(&self, exterior: &ExteriorOrientation) -> SMatrix<f64, 6, 7> {
        let mut g = SMatrix::<f64, 6, 7>::zeros();
        g.fixed_view_mut::<3, 7>(0, 0).copy_from(&self.of_point(&exterior.projection_center()));
        let turn = -exterior.camera_from_world().matrix() / self.scale;
        g.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        g
    }

    /// G of the reduced system's unknowns, one row each.
    pub(super) fn of_reduced<C>(
        &self,
        bundle: &Bundle<C>,
        layout: &Layout,
        state: &State<C>,
    ) -> DMatrix<f64> {
        let mut g = DMatrix::zeros(layout.reduced(bundle), self.count);
        for (i, exterior) in state.exteriors.iter().enumerate() {
            let own = self.of_image(exterior);
            let rows = own.columns(0, self.count);
            g.view_mut((i * layout.own, 0), (6, self.count)).copy_from(&rows);
        }
        for (place, point) in layout.kept.iter().enumerate() {
            let rows = self.of_point(&state.points[*point as usize]);
            let at = layout.kept_column(bundle, place);
            for c in 0..self.count {
                for r in 0..3 {
                    g[(at + r, c)] = rows[(r, c)];
                }
            }
        }
        g
    }
}

/// The matrix plus Q Qᵀ for an orthonormal basis Q of the columns of D^½ G: no longer singular along G, and the same
/// elsewhere.
pub(super) fn add_null_space(matrix: &mut [f64], scale: &[f64], g: &DMatrix<f64>) {
    let n = scale.len();
    let mut basis = g.clone();
    for (r, s) in scale.iter().enumerate() {
        basis.row_mut(r).iter_mut().for_each(|v| *v /= s);
    }
    let q = basis.qr().q();
    for r in 0..n {
        for s in r..n {
            let sum: f64 = (0..q.ncols()).map(|c| q[(r, c)] * q[(s, c)]).sum();
            matrix[r * n + s] += sum;
        }
    }
}

/// The S-transformation, as what it subtracts from blocks of cofactors.
pub(super) struct Transformation {
    /// Z = Q B of the reduced unknowns and of the points.
    reduced: DMatrix<f64>,
    points: Vec<ThreeRows>,
    /// T = G (BᵀG)⁻¹.
    reduced_turned: DMatrix<f64>,
    points_turned: Vec<ThreeRows>,
    /// Bᵀ Q B.
    middle: DMatrix<f64>,
}

impl Transformation {
    /// From G of all unknowns, its rows B of the datum points, and Z = Q B.
    pub(super) fn new(
        g: (DMatrix<f64>, Vec<ThreeRows>),
        b: &[ThreeRows],
        z: (DMatrix<f64>, Vec<ThreeRows>),
        count: usize,
    ) -> Result<Self, Error> {
        let (mut gram, mut middle) = (SMatrix::<f64, 7, 7>::zeros(), SMatrix::<f64, 7, 7>::zeros());
        for (b, z) in b.iter().zip(&z.1) {
            gram += b.transpose() * b;
            middle += b.transpose() * z;
        }
        let part = |m: &SMatrix<f64, 7, 7>| DMatrix::from_fn(count, count, |r, c| m[(r, c)]);
        let values = part(&gram).symmetric_eigenvalues();
        let (measure, limit) = (values.min() / values.max(), LEAST_SPREAD);
        let on_a_line =
            Error::Degenerate { what: "datum: the points lie on a line", measure, limit };
        if !(measure > limit) {
            return Err(on_a_line);
        }
        let inverse = part(&gram).cholesky().ok_or(on_a_line)?.inverse();
        let reduced_turned = &g.0 * &inverse;
        let wide =
            SMatrix::<f64, 7, 7>::from_fn(|r, c| inverse.get((r, c)).copied().unwrap_or(0.0));
        let points_turned = g.1.iter().map(|g| g * wide).collect();
        Ok(Self { reduced: z.0, points: z.1, reduced_turned, points_turned, middle: part(&middle) })
    }

    /// Brings a square block of the reduced unknowns, whose places are given, to the datum.
    pub(super) fn reduced(&self, block: &mut DMatrix<f64>, places: &[usize]) {
        let count = self.middle.nrows();
        let rows =
            |m: &DMatrix<f64>| DMatrix::from_fn(places.len(), count, |r, c| m[(places[r], c)]);
        let (z, t) = (rows(&self.reduced), rows(&self.reduced_turned));
        let crossed = &z * t.transpose();
        *block += &t * &self.middle * t.transpose() - &crossed - crossed.transpose();
    }

    /// Brings the block of a point to the datum.
    pub(super) fn point(&self, block: &mut nalgebra::Matrix3<f64>, point: usize) {
        let (z, t) = (&self.points[point], &self.points_turned[point]);
        let middle =
            SMatrix::<f64, 7, 7>::from_fn(|r, c| self.middle.get((r, c)).copied().unwrap_or(0.0));
        let crossed = z * t.transpose();
        *block += t * middle * t.transpose() - crossed - crossed.transpose();
    }
}

/// The least square of the datum points' spread across a line, along it being 1.
pub(super) const LEAST_SPREAD: f64 = 1e-10;

/// No rows.
pub(super) fn no_rows(points: usize) -> Vec<ThreeRows> {
    vec![ThreeRows::zeros(); points]
}
