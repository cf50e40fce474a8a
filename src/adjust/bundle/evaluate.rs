//! Residuals of image points and their partial derivatives.
//!
//! ```text
//! r = W (camera(R (X − C)) − x),   P = WᵀW
//! ∂r/∂X = W J R,   ∂r/∂C = −W J R,   ∂r/∂δ = W (X′ × j₁, X′ × j₂)ᵀ
//! ```
//! with X′ = R (X − C), J of rows j₁ and j₂ the partials of the camera, and δ the left rotation vector.

use nalgebra::{Matrix3, Point2, Point3, Vector3};

use super::problem::{Bundle, Seen};
use super::state::State;
use super::{MOST_GROUPS, OutsideRule};
use crate::adjust::unknowns::Columns;
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation};
use crate::error::ProjectionError;

/// The image of a point where a state has it.
pub(super) fn image_of<C: CentralModel + Adjustable + Clone>(
    bundle: &Bundle<C>,
    state: &State<C>,
    seen: &Seen,
    outside: OutsideRule,
) -> Result<Point2<f64>, ProjectionError> {
    let camera = &state.cameras[bundle.images[seen.image as usize].camera as usize];
    let pose = state.exteriors[seen.image as usize];
    project(camera, &pose, &state.points[seen.point as usize], outside)
}

#[inline]
fn project<C: CentralModel + Adjustable>(
    camera: &C,
    exterior: &ExteriorOrientation,
    point: &Point3<f64>,
    outside: OutsideRule,
) -> Result<Point2<f64>, ProjectionError> {
    let in_camera = exterior.pose().apply(point);
    match outside {
        OutsideRule::Exclude => camera.project_direction(&in_camera.coords),
        OutsideRule::Formula => camera.formula_partials(&in_camera, &mut [0.0; 6], &mut []),
    }
}

/// The weighted residual.
#[inline]
pub(super) fn whitened([w11, w12, w22]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    [w11 * x, w12 * x + w22 * y]
}

/// The weighted residual of an observation.
#[inline]
pub(super) fn residual<C: CentralModel + Adjustable + Clone>(
    bundle: &Bundle<C>,
    state: &State<C>,
    seen: &Seen,
    outside: OutsideRule,
) -> Result<[f64; 2], ProjectionError> {
    let off = image_of(bundle, state, seen, outside)? - seen.at;
    Ok(whitened(bundle.precisions[seen.precision as usize], [off.x, off.y]))
}

/// Where the partial derivatives of one observation are written: two rows of the photograph's columns, two rows of three for the
/// point; and room for those of the camera's groups.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub(super) by_image: [[f64; super::MOST_COLUMNS]; 2],
    pub(super) by_point: [[f64; 3]; 2],
    pub(super) residual: [f64; 2],
    groups: [f64; GROUPS_LEN],
}

/// Two rows for every parameter of every group.
const GROUPS_LEN: usize = 2 * 16 * MOST_GROUPS;

impl Default for Rows {
    fn default() -> Self {
        Self {
            by_image: [[0.0; super::MOST_COLUMNS]; 2],
            by_point: [[0.0; 3]; 2],
            residual: [0.0; 2],
            groups: [0.0; GROUPS_LEN],
        }
    }
}

impl Rows {
    /// The rows of an observation. `total` is the number of the photograph's columns; those that its camera does not have
    /// are zero, as are the six of a held exterior orientation.
    #[inline]
    pub(super) fn fill<C: CentralModel + Adjustable + Clone>(
        &mut self,
        bundle: &Bundle<C>,
        state: &State<C>,
        seen: &Seen,
        outside: OutsideRule,
        total: usize,
    ) -> Result<(), ProjectionError> {
        let image = &bundle.images[seen.image as usize];
        let camera = &state.cameras[image.camera as usize];
        let columns = &bundle.cameras[image.camera as usize].columns;
        let pose = state.exteriors[seen.image as usize];
        let in_camera = pose.pose().apply(&state.points[seen.point as usize]);
        let mut by_direction = [0.0; 6];
        let found = {
            let mut groups: [&mut [f64]; MOST_GROUPS] = Default::default();
            let mut room = &mut self.groups[..];
            let count = columns.lengths.len();
            for (g, len) in columns.lengths.iter().enumerate() {
                if columns.uses(g) {
                    groups[g] = super::parallel::take(&mut room, 2 * len);
                }
            }
            match outside {
                OutsideRule::Exclude => {
                    camera.partials(&in_camera, &mut by_direction, &mut groups[..count])?
                }
                OutsideRule::Formula => {
                    camera.formula_partials(&in_camera, &mut by_direction, &mut groups[..count])?
                }
            }
        };
        let rotation = pose.pose().rotation;
        let w = bundle.precisions[seen.precision as usize];
        self.residual = whitened(w, [found.x - seen.at.x, found.y - seen.at.y]);
        self.write_pose(&by_direction, rotation.matrix(), &in_camera.coords, w, image.held);
        self.write_camera(columns, w, total);
        Ok(())
    }

    #[inline]
    fn write_pose(
        &mut self,
        by_direction: &[f64; 6],
        rotation: &Matrix3<f64>,
        in_camera: &Vector3<f64>,
        w: [f64; 3],
        held: bool,
    ) {
        let [a, b, c, d, e, f] = *by_direction;
        let [w11, w12, w22] = w;
        let rows = [
            Vector3::new(a, b, c) * w11,
            Vector3::new(a, b, c) * w12 + Vector3::new(d, e, f) * w22,
        ];
        for (i, row) in rows.iter().enumerate() {
            let by_point = rotation.tr_mul(row);
            self.by_point[i] = [by_point.x, by_point.y, by_point.z];
            let turn = in_camera.cross(row);
            let own = [-by_point.x, -by_point.y, -by_point.z, turn.x, turn.y, turn.z];
            self.by_image[i][..6].copy_from_slice(&if held { [0.0; 6] } else { own });
        }
    }

    #[inline]
    fn write_camera(&mut self, columns: &Columns, [w11, w12, w22]: [f64; 3], total: usize) {
        // The groups lie one after the other, as `fill` handed them out.
        let mut begins = [0; MOST_GROUPS];
        let mut begin = 0;
        for (g, len) in columns.lengths.iter().enumerate() {
            begins[g] = begin;
            if columns.uses(g) {
                begin += 2 * len;
            }
        }
        for k in 0..total - 6 {
            let [mut x, mut y] = [0.0; 2];
            if let Some(column) = columns.list.get(k) {
                let partials = &self.groups[begins[column.group]..];
                x = columns.derivative(k, 0, partials);
                y = columns.derivative(k, 1, partials);
            }
            self.by_image[0][6 + k] = w11 * x;
            self.by_image[1][6 + k] = w12 * x + w22 * y;
        }
    }

    /// By a robust loss, of weight ρ′ and curvature c = 2ρ″s/ρ′ at s = ‖r‖²: rows A and residual r that have the loss's
    /// gradient and Hessian but for the curvature of the residual itself.
    ///
    /// ```text
    /// A ← √ρ′ (I − α r rᵀ/s) A     r ← √ρ′/(1 − α) r     (1 − α)² = 1 + c
    /// ```
    /// (Triggs et al. 2000, §4.3.) A loss turned so far that 1 + c would not be positive is taken as nearly flat along r.
    pub(super) fn reweigh(&mut self, weight: f64, curvature: f64, total: usize) {
        let root = weight.sqrt();
        let [x, y] = self.residual;
        let squared = x * x + y * y;
        let left = (1.0 + curvature).max(LEAST_CURVATURE).sqrt();
        let along = if squared > 0.0 { (1.0 - left) / squared } else { 0.0 };
        let turned = |a: &mut f64, b: &mut f64| {
            let share = along * (x * *a + y * *b);
            (*a, *b) = (root * (*a - share * x), root * (*b - share * y));
        };
        let [first, second] = &mut self.by_image;
        first[..total].iter_mut().zip(&mut second[..total]).for_each(|(a, b)| turned(a, b));
        let [first, second] = &mut self.by_point;
        first.iter_mut().zip(second).for_each(|(a, b)| turned(a, b));
        self.residual.iter_mut().for_each(|v| *v *= root / left);
    }
}

/// What is left of a loss's curvature along the residual, where it is none or negative: points that no ray holds across would
/// have a singular block.
const LEAST_CURVATURE: f64 = 0.01;
