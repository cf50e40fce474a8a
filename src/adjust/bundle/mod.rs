//! Bundle adjustment: cameras, photographs and object points from all image points at once.
//!
//! ```text
//! minimise ½ Σ ρ(‖Wᵢⱼ (camera(Rᵢ (Xⱼ − Cᵢ)) − xᵢⱼ)‖²) + ½ Σ vᵀPv of what was observed besides
//! ```
//! (Brown 1958; Triggs, McLauchlan, Hartley & Fitzgibbon 2000, *Bundle adjustment – a modern synthesis*.)
//!
//! *In words.* Each photograph is a bundle of rays. All bundles are moved and turned, and all object points with them, until
//! rays meet in the points as well as they can. Besides image points, the coordinates of control points, the positions of GNSS
//! antennas, the attitudes of inertial units, the lengths of scale bars and the parameters of cameras may have been observed, each
//! with its precision; [`Bundle::estimate_variances`] finds the precisions of whole groups too.
//!
//! # Method
//! Levenberg–Marquardt on exact partial derivatives. Points are eliminated first; what is left is a system of the photographs and
//! cameras, which is factorised as a whole or, where most of its blocks are zero, by those that are not ([`Solver`]). Memory grows with the number of observations: one block of 3 × 6 numbers each, 3 × (6 + u) where cameras have
//! u unknowns. With the feature `rayon` the work is done on the threads of the caller's pool; the result is the same to
//! the last bit on any number of them.
//!
//! # Observations without an image
//! A point behind its camera, or beyond the fold of its lens, has no image there. With [`OutsideRule::Exclude`], the rule if nothing
//! else is said, an observation that has no image where the adjustment starts takes no part and is listed
//! ([`Adjusted::excluded`]), as does the one ray of a point that nothing else fixes; and no step may lead an observation
//! that takes part out of its camera's domain. [`OutsideRule::Formula`] keeps all of them, by the bare formula of the model:
//! the rule of programs that know no domain, and of the published costs of *Bundle Adjustment in the Large*.
//!
//! # Robust losses
//! Far from the minimum the steps are those of reweighted least squares, near it the loss's own curvature is in them (Triggs et
//! al. 2000, §4.3), so that they converge as fast as least squares does. Losses that are flat beyond their scale begin with Huber's.
//!
//! # Datum
//! Without control points or other outside observations, seven numbers (place, attitude, scale) are determined by nothing but the
//! approximate values: the result is one of many that differ by a similarity. [`Datum`] says what their covariances are relative to.
//!
//! # What is refused
//! Photographs with fewer than three image points; parts that no photographs tie together, where not each is placed by what was given
//! for it, as by three points that do not lie on a line; fewer observations than unknowns. That a part hangs on too few points of
//! the others is found by [`Bundle::report`], whose normal matrix is singular then.
//!
//! # Example
//! Two photographs from 10 m, c = 1000 px, one held and the other's position known; six points, from exact image points. The
//! second camera is found at (2, 0, 10) from 0.3 m beside, and a point at (1, 1, 0).
//!
//! ```
//! use collinear::adjust::Precision;
//! use collinear::adjust::bundle::{Bundle, BundleOptions};
//! use collinear::camera::{CentralCamera, Gnomonic};
//! use collinear::{ExteriorOrientation, InteriorOrientation};
//! use nalgebra::{Point2, Point3, Rotation3, Vector3};
//!
//! let interior = InteriorOrientation::new([1000.0; 2], Point2::origin(), 0.0)?;
//! let mut bundle = Bundle::new();
//! let camera = bundle.add_camera(CentralCamera::ideal(interior, Gnomonic), &[])?;
//! // Looking straight down, x to the east: a point (X, Y, Z) is at 1000 (X − Xc, Yc − Y)/(10 − Z).
//! let down = Rotation3::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
//! let left = bundle.add_image(ExteriorOrientation::new(Point3::new(0.0, 0.0, 10.0), down), camera)?;
//! let right = bundle.add_image(ExteriorOrientation::new(Point3::new(2.3, 0.0, 10.0), down), camera)?;
//! bundle.hold(left)?;
//! bundle.observe_position(right, Point3::new(2.0, 0.0, 10.0), Vector3::zeros(), Precision::Sigma(0.01))?;
//! let mut points = vec![];
//! for [x, y, z] in [[0., 0., 0.], [1., 1., 0.], [2., -1., 1.], [0., 2., 2.], [1., -2., 0.], [2., 2., 1.]] {
//!     let point = bundle.add_point(Point3::new(x + 0.1, y - 0.1, z + 0.2))?;
//!     for (image, xc) in [(left, 0.0), (right, 2.0)] {
//!         let at = Point2::new(1000.0 * (x - xc) / (10.0 - z), -1000.0 * y / (10.0 - z));
//!         bundle.observe(image, point, at, Precision::Sigma(1.0))?;
//!     }
//!     points.push(point);
//! }
//! let adjusted = bundle.adjust(&BundleOptions::default())?;
//! assert!(adjusted.convergence.converged);
//! assert!((adjusted.exterior(right).ok_or("there")?.projection_center() - Point3::new(2.0, 0.0, 10.0)).norm() < 1e-9);
//! assert!((adjusted.point(points[1]).ok_or("there")? - Point3::new(1.0, 1.0, 0.0)).norm() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod datum;
mod dense;
mod engine;
mod evaluate;
mod given;
mod iterative;
mod judge;
mod layout;
mod normal;
mod order;
mod parallel;
mod parts;
mod pattern;
mod problem;
mod quality;
mod schur;
mod solve;
mod sparse;
mod state;
mod variance;
mod width;

use alloc::vec::Vec;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Point2, Point3};

pub use check::CheckPoints;
pub use datum::Datum;
pub use problem::{Bundle, CameraId, ImageId, PointId};
pub use quality::{BundleReport, BundleReportOptions, Observation};
pub use variance::{VarianceComponent, VarianceEstimate};

use self::engine::Engine;
use self::layout::{Layout, Role};
use self::normal::Normal;
use self::problem::Kind;
use self::state::State;
use self::width::{Fixed, Runtime, Width};
use crate::camera::{Adjustable, CentralModel, ExteriorOrientation};
use crate::error::Error;
use crate::numeric::least_squares::{
    Convergence, LeastSquaresOptions, Problem, Progress, minimise_watched,
};
use crate::numeric::robust_loss::RobustLoss;

/// No camera has more groups of parameters.
const MOST_GROUPS: usize = 4;
/// No camera has more unknowns.
const MOST_OF_CAMERA: usize = 24;
/// Columns of a photograph with its camera.
const MOST_COLUMNS: usize = 6 + MOST_OF_CAMERA;

/// A step that lowers the cost by no more than this fraction is near the minimum.
const NEAR: f64 = 1e-3;

/// What becomes of an observation whose point has no image in its camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutsideRule {
    /// It takes no part and is listed.
    #[default]
    Exclude,
    /// Its residual is that of the model's bare formula.
    Formula,
}

/// Why an observation takes no part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Exclusion {
    /// The approximate point lies behind the approximate camera.
    BehindCamera,
    /// The approximate point lies outside the camera's domain, as beyond the fold of its lens.
    OutsideDomain,
    /// No other ray leads to the point, and nothing else is known of it.
    SingleRay,
}

/// How the reduced system of photographs and cameras is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// Dense for small blocks and those in which most photographs have points in common, sparse for the others; iterative where
    /// the factor would take more than 4 GB.
    #[default]
    Automatic,
    /// Cholesky's factorisation of the whole matrix: memory grows with the square of the number of photographs, time with
    /// its cube.
    Dense,
    /// Cholesky's factorisation of the blocks that are not zero, in an order of minimum degree: for blocks in which a photograph
    /// has points in common with a few others only, as in strips of aerial photographs. Time and memory then grow little faster than the
    /// number of photographs.
    Sparse,
    /// Conjugate gradients with the block diagonal as preconditioner, without forming the matrix: the least memory, and by far the
    /// most time.
    Iterative,
}

/// How to adjust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleOptions {
    /// When to stop.
    pub least_squares: LeastSquaresOptions,
    /// The loss of an image point's weighted residual, whose scale is in standard deviations. Tukey's and the truncated one,
    /// which see nothing beyond their scale, begin with steps of Huber's.
    pub loss: RobustLoss,
    /// What becomes of points behind their cameras.
    pub outside: OutsideRule,
    /// How the reduced system is solved.
    pub solver: Solver,
}

impl Default for BundleOptions {
    /// At most 200 linearisations, until a step promises less than 10⁻¹² of the cost; squared loss.
    fn default() -> Self {
        Self {
            least_squares: LeastSquaresOptions {
                max_iterations: 200,
                gradient_tolerance: 1e-12,
                step_tolerance: 1e-13,
                decrease_tolerance: 1e-12,
                initial_damping: 1e-4,
            },
            loss: RobustLoss::Squared,
            outside: OutsideRule::Exclude,
            solver: Solver::Automatic,
        }
    }
}

/// An adjusted block.
#[derive(Clone, Debug)]
pub struct Adjusted<C> {
    state: State<C>,
    /// The observations that took no part, by their numbers in the order in which they were added, with the reason.
    pub excluded: Vec<(usize, Exclusion)>,
    /// The points that keep their approximate coordinates, as fewer than two photographs that take part see them and nothing
    /// else is known of them; sorted.
    pub undetermined: Vec<PointId>,
    /// How the iteration ended; the cost is half the sum of losses and weighted squares.
    pub convergence: Convergence,
}

impl<C> Adjusted<C> {
    /// The exterior orientation of a photograph.
    #[must_use]
    pub fn exterior(&self, image: ImageId) -> Option<&ExteriorOrientation> {
        self.state.exteriors.get(image.number())
    }

    /// A camera.
    #[must_use]
    pub fn camera(&self, camera: CameraId) -> Option<&C> {
        self.state.cameras.get(camera.number())
    }

    /// An object point.
    #[must_use]
    pub fn point(&self, point: PointId) -> Option<&Point3<f64>> {
        self.state.points.get(point.number())
    }

    /// The exterior orientations, in the order of the photographs.
    #[must_use]
    pub fn exteriors(&self) -> &[ExteriorOrientation] {
        &self.state.exteriors
    }

    /// The cameras, in their order.
    #[must_use]
    pub fn cameras(&self) -> &[C] {
        &self.state.cameras
    }

    /// The object points, in their order.
    #[must_use]
    pub fn points(&self) -> &[Point3<f64>] {
        &self.state.points
    }
}

impl<C: CentralModel + Adjustable + Clone> Bundle<C> {
    /// Adjusts the block.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] for a photograph with fewer than three image points, an end of a distance with fewer than two
    /// rays, fewer observations than unknowns, or no observation at all; [`Error::OutOfRange`] for a block in parts that nothing ties together;
    /// [`Error::NotConverged`] where the cost at the start is no number.
    pub fn adjust(&self, options: &BundleOptions) -> Result<Adjusted<C>, Error> {
        self.adjust_watched(options, |_| ControlFlow::Continue(()))
    }

    /// [`adjust`](Self::adjust) with a watcher, which is told of each step and may end the work: the result is then the best met so far,
    /// and not converged.
    ///
    /// # Errors
    /// As [`adjust`](Self::adjust).
    pub fn adjust_watched(
        &self,
        options: &BundleOptions,
        mut watch: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Adjusted<C>, Error> {
        self.adjust_from(options, State::start(self), &mut watch)
    }

    /// From a state; what takes part is decided by the approximate values.
    fn adjust_from(
        &self,
        options: &BundleOptions,
        start: State<C>,
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Adjusted<C>, Error> {
        options.loss.check()?;
        let layout = Layout::new(self, &State::start(self), options.outside)?;
        let (six, nine) = (Fixed::<6>, Fixed::<9>);
        let (state, convergence) = match (layout.own, layout.total) {
            (6, 6) => self.minimise(&layout, start, options, (six, six), watch),
            (9, 9) => self.minimise(&layout, start, options, (nine, nine), watch),
            (6, total) => self.minimise(&layout, start, options, (six, Runtime(total)), watch),
            (own, total) => {
                let widths = (Runtime(own), Runtime(total));
                self.minimise(&layout, start, options, widths, watch)
            }
        };
        if !convergence.initial_cost.is_finite() {
            let cost = convergence.initial_cost;
            return Err(Error::NotConverged { iterations: 0, cost });
        }
        let excluded = layout.excluded.iter().map(|(i, e)| (*i as usize, *e)).collect();
        let loose = |i: &u32| {
            let i = *i as usize;
            layout.roles[i] == Role::Constant && self.points[i].kind == Kind::Pass
        };
        let undetermined = (0..self.points.len() as u32).filter(loose).map(PointId).collect();
        Ok(Adjusted { state, excluded, undetermined, convergence })
    }

    fn minimise<E: Width, K: Width>(
        &self,
        layout: &Layout,
        start: State<C>,
        options: &BundleOptions,
        (own, total): (E, K),
        watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> (State<C>, Convergence) {
        let (solver, plan) = solve::choose(self, layout, options.solver);
        let (outside, plan) = (options.outside, plan.as_ref());
        let engine = |loss| {
            let curved = AtomicBool::new(false);
            Engine { bundle: self, layout, loss, outside, solver, plan, curved, own, total }
        };
        let mut normal = Normal::default();
        let (mut state, mut before) = (start, None);
        if let Some(loss) = options.loss.monotone() {
            let initial_cost = engine(options.loss).cost(&state);
            let rough = LeastSquaresOptions { decrease_tolerance: NEAR, ..options.least_squares };
            let engine = engine(loss);
            let (nearer, end) =
                minimise_watched(&engine, state, &mut normal, &rough, |_, progress| {
                    watch(progress)
                });
            state = nearer;
            // Stopped by the watcher, or out of iterations.
            if !end.converged {
                let engine = Engine { loss: options.loss, ..engine };
                let end = Convergence { final_cost: engine.cost(&state), ..end };
                return (state, Convergence { initial_cost, ..end });
            }
            before = Some((initial_cost, end.iterations));
        }
        let engine = engine(options.loss);
        let iterations = before.map_or(0, |(_, iterations)| iterations);
        let mut rest = options.least_squares;
        rest.max_iterations = rest.max_iterations.saturating_sub(iterations);
        let mut last = f64::INFINITY;
        let (state, end) = minimise_watched(&engine, state, &mut normal, &rest, |_, progress| {
            // Far off the curvature of a loss leads to any minimum; near one it leads there in few steps.
            if last - progress.cost < NEAR * progress.cost {
                engine.curved.store(true, Ordering::Relaxed);
            }
            last = progress.cost;
            watch(&Progress { iterations: progress.iterations + iterations, ..*progress })
        });
        let initial_cost = before.map_or(end.initial_cost, |(cost, _)| cost);
        (state, Convergence { initial_cost, iterations: end.iterations + iterations, ..end })
    }

    /// The residual of an observation, by its number in the order in which they were added: observed minus computed, in
    /// pixels. By the bare formula where the rule asks for it.
    ///
    /// # Errors
    /// [`Error::Unknown`] past the last; [`Error::Projection`] where the point has no image; [`Error::LengthMismatch`] for the result of
    /// another block.
    pub fn residual(
        &self,
        adjusted: &Adjusted<C>,
        observation: usize,
        outside: OutsideRule,
    ) -> Result<[f64; 2], Error> {
        let seen = self.seen.get(observation).ok_or(Error::Unknown { what: "observation" })?;
        self.check_adjusted(adjusted)?;
        let image: Point2<f64> = evaluate::image_of(self, &adjusted.state, seen, outside)?;
        Ok([seen.at.x - image.x, seen.at.y - image.y])
    }
    /// Refuses the result of a block of another size.
    fn check_adjusted(&self, adjusted: &Adjusted<C>) -> Result<(), Error> {
        let state = &adjusted.state;
        for (what, left, right) in [
            ("photographs and their adjusted ones", self.images.len(), state.exteriors.len()),
            ("cameras and their adjusted ones", self.cameras.len(), state.cameras.len()),
            ("points and their adjusted ones", self.points.len(), state.points.len()),
        ] {
            if left != right {
                return Err(Error::LengthMismatch { what, left, right });
            }
        }
        Ok(())
    }
}
