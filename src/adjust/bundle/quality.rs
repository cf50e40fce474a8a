//! How good an adjusted block is.

use alloc::vec::Vec;
use core::sync::atomic::AtomicBool;

use nalgebra::{DMatrix, Matrix3};

use super::datum::Datum;
use super::engine::Engine;
use super::layout::Layout;
use super::problem::{Bundle, CameraId, ImageId, PointId};
use super::state::State;
use super::width::Runtime;
use super::{Adjusted, BundleOptions, Solver};
use crate::adjust::ObservationReport;
use crate::camera::{Adjustable, CentralModel};
use crate::error::Error;

/// What an adjusted block found out about itself: the figures of [`Report`](crate::adjust::Report), with the covariances of
/// photographs, cameras and points.
///
/// ```text
/// σ₀² = vᵀPv / r,   r = n − u + d,   Σ = s² Q
/// ```
#[derive(Clone, Debug)]
pub struct BundleReport {
    /// n: observed numbers, two for an image point that takes part, three for a control point, a position and an attitude, one
    /// for a distance and an observed parameter.
    pub observations: usize,
    /// u: unknowns.
    pub unknowns: usize,
    /// d: conditions of the datum, 7 of a free block, 6 of one with a distance.
    pub conditions: usize,
    /// r: how many observations more than needed.
    pub redundancy: usize,
    /// vᵀPv, without dimension.
    pub weighted_sum: f64,
    /// σ₀ = √(vᵀPv / r); `None` where nothing is redundant.
    pub sigma0: Option<f64>,
    /// s, by which covariances are scaled and observations tested: σ₀ where it was to be estimated, there is redundancy and the residuals
    /// are not all zero, else 1.
    pub sigma: f64,
    /// For each image point, in the order in which they were added, of x and y; all NaN where it took no part.
    pub image_points: Vec<[ObservationReport; 2]>,
    /// For each control point, in their order.
    pub control_points: Vec<(PointId, [ObservationReport; 3])>,
    /// For each observed position, in the order of the photographs.
    pub positions: Vec<(ImageId, [ObservationReport; 3])>,
    /// For each observed attitude, in the order of the photographs: of a turn about each of the camera's axes, radians.
    pub attitudes: Vec<(ImageId, [ObservationReport; 3])>,
    /// For each distance, in their order.
    pub distances: Vec<ObservationReport>,
    /// For each observed parameter of a camera: the camera, its unknown, the report.
    pub parameters: Vec<(CameraId, usize, ObservationReport)>,
    pub(super) cofactors: Cofactors,
}

/// How an adjusted block is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleReportOptions<'a> {
    /// What places the block.
    pub datum: Datum<'a>,
    /// Whether covariances are scaled by σ₀, or the stated precisions believed.
    pub estimate_sigma: bool,
}

impl Default for BundleReportOptions<'_> {
    fn default() -> Self {
        Self { datum: Datum::Given, estimate_sigma: true }
    }
}

/// Q of the reduced unknowns and of each point, before the datum's transformation.
#[derive(Clone, Debug)]
pub(super) struct Cofactors {
    /// By rows, both halves.
    pub(super) reduced: Vec<f64>,
    pub(super) size: usize,
    /// For each photograph the places of its unknowns, its camera's last; for each camera those of its unknowns.
    pub(super) image_places: Vec<Vec<usize>>,
    pub(super) camera_places: Vec<Vec<usize>>,
    pub(super) points: Vec<Matrix3<f64>>,
}

impl BundleReport {
    /// Σ of a photograph: its centre (world units), its left rotation vector (radians), then the unknowns of its camera. Zero
    /// for what was held.
    #[must_use]
    pub fn image_covariance(&self, image: ImageId) -> Option<DMatrix<f64>> {
        self.block(self.cofactors.image_places.get(image.number())?)
    }

    /// Σ of a camera's unknowns, in their order; empty of a camera without a photograph.
    #[must_use]
    pub fn camera_covariance(&self, camera: CameraId) -> Option<DMatrix<f64>> {
        self.block(self.cofactors.camera_places.get(camera.number())?)
    }

    /// Σ of an object point, world units². Zero where it is no unknown.
    #[must_use]
    pub fn point_covariance(&self, point: PointId) -> Option<Matrix3<f64>> {
        let q = self.cofactors.points.get(point.number())?;
        Some(q * (self.sigma * self.sigma))
    }

    fn block(&self, places: &[usize]) -> Option<DMatrix<f64>> {
        let q = &self.cofactors;
        let s2 = self.sigma * self.sigma;
        Some(DMatrix::from_fn(places.len(), places.len(), |r, c| {
            s2 * q.reduced[places[r] * q.size + places[c]]
        }))
    }

    /// Every observed number that took part, by what it is of.
    pub fn numbers(&self) -> impl Iterator<Item = (Observation, &ObservationReport)> {
        let image = (self.image_points.iter().enumerate())
            .flat_map(|(i, v)| v.iter().map(move |v| (Observation::ImagePoint(i), v)))
            .filter(|(_, v)| !v.redundancy.is_nan());
        let control = (self.control_points.iter())
            .flat_map(|(i, v)| v.iter().map(|v| (Observation::ControlPoint(*i), v)));
        let positions = (self.positions.iter())
            .flat_map(|(i, v)| v.iter().map(|v| (Observation::Position(*i), v)));
        let attitudes = (self.attitudes.iter())
            .flat_map(|(i, v)| v.iter().map(|v| (Observation::Attitude(*i), v)));
        let distances =
            self.distances.iter().enumerate().map(|(i, v)| (Observation::Distance(i), v));
        let parameters =
            self.parameters.iter().map(|(c, k, v)| (Observation::Parameter(*c, *k), v));
        image.chain(control).chain(positions).chain(attitudes).chain(distances).chain(parameters)
    }

    /// Σ rᵢ over all observed numbers: the redundancy again, by another way.
    #[must_use]
    pub fn redundancy_sum(&self) -> f64 {
        self.numbers().map(|(_, v)| v.redundancy).sum()
    }
}

/// What an observed number of a block is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum Observation {
    /// An image point, by its number in the order in which they were added.
    ImagePoint(usize),
    /// The coordinates of a control point.
    ControlPoint(PointId),
    /// The position of a photograph's antenna.
    Position(ImageId),
    /// The attitude of a photograph.
    Attitude(ImageId),
    /// A distance, by its number in the order in which they were added.
    Distance(usize),
    /// An unknown of a camera, whose start value was observed.
    Parameter(CameraId, usize),
}

impl<C: CentralModel + Adjustable + Clone> Bundle<C> {
    /// Judges an adjusted block: σ₀, covariances, and for each observation its residual, redundancy number, Baarda's w and
    /// detectable blunder. `options` are those of the adjustment.
    ///
    /// Time grows with the cube of the number of photographs, memory with its square.
    ///
    /// # Errors
    /// [`Error::Degenerate`] where the observations and the datum do not determine the unknowns: the measure is the pivot of the
    /// normal matrix of unit diagonal that vanished; [`Error::OutOfRange`] for a free datum where places are given, or a
    /// reduced system of more than 12,000 unknowns; [`Error::LengthMismatch`] for the result of another block.
    #[doc(alias("covariance", "reliability"))]
    pub fn report(
        &self,
        adjusted: &Adjusted<C>,
        options: &BundleOptions,
        how: &BundleReportOptions<'_>,
    ) -> Result<BundleReport, Error> {
        let state = &adjusted.state;
        self.check_adjusted(adjusted)?;
        // What took part was decided at the start.
        let layout = Layout::new(self, &State::start(self), options.outside)?;
        let engine = Engine {
            bundle: self,
            layout: &layout,
            loss: options.loss,
            outside: options.outside,
            solver: Solver::Dense,
            curved: AtomicBool::new(false),
            plan: None,
            own: Runtime(layout.own),
            total: Runtime(layout.total),
        };
        engine.report(state, how)
    }
}
