//! One picture laid on another by control points: every kind of map, and which of them to trust.
//!
//! Residuals at the points that a map was fitted to say little: a map through all points has none. Leave points out,
//! predict them from the others, and the residuals say what the map is worth between the points (Stone 1974). That is
//! [`cross_validate`]; [`compare`] does it for several models and sorts them.
//!
//! | model | unknowns | points needed | follows |
//! | --- | --- | --- | --- |
//! | [`MapModel::Affine`] | 6 | 3 | scale, rotation, shear |
//! | [`MapModel::Projective`] | 8 | 4 | a plane in any perspective |
//! | [`MapModel::Bilinear`] | 8 | 4 | a stretched quad |
//! | [`MapModel::Quadratic`] | 12 | 6 | a slow bend |
//! | [`MapModel::Cubic`] | 20 | 10 | lens errors, attitude drift |
//! | [`MapModel::PiecewiseAffine`] | all | 3 | anything, if points are dense; hull only |
//! | [`MapModel::PiecewiseCubic`] | all | 3 | anything smooth; hull only |
//! | [`MapModel::ThinPlate`] | all | 3 | anything smooth, with measuring errors smoothed away |
//!
//! Prefer the model of fewest unknowns among those whose cross-validated residuals differ little.
//!
#![doc = include_str!("../../docs/figures/registration.svg")]

use alloc::vec::Vec;
use core::fmt;
use core::ops::Range;

use nalgebra::{Matrix2, Point2, Vector2};

use super::piecewise::{PiecewiseAffine, PiecewiseCubic};
use super::polynomial::{Bilinear, Cubic, Quadratic};
use super::span::Span;
use super::{BlockSink, FractionalLinear, Map, ThinPlate, control};
use crate::error::{Error, ProjectionError};
use crate::geometry::homography::FitOptions;
use crate::geometry::{Affine2, Homography};
use crate::numeric::float;

/// A kind of map that control points determine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum MapModel {
    /// [`Affine2`].
    Affine,
    /// [`FractionalLinear`], by [`Homography::fit`].
    Projective,
    /// [`Bilinear`].
    Bilinear,
    /// [`Quadratic`].
    Quadratic,
    /// [`Cubic`].
    Cubic,
    /// [`PiecewiseAffine`].
    PiecewiseAffine,
    /// [`PiecewiseCubic`].
    PiecewiseCubic,
    /// [`ThinPlate`].
    ThinPlate {
        /// λ, in squared pixels of the screen.
        smoothing: f64,
    },
}

impl MapModel {
    /// Every model, the thin plate without smoothing.
    pub const ALL: [Self; 8] = [
        Self::Affine,
        Self::Projective,
        Self::Bilinear,
        Self::Quadratic,
        Self::Cubic,
        Self::PiecewiseAffine,
        Self::PiecewiseCubic,
        Self::ThinPlate { smoothing: 0.0 },
    ];

    /// The map from screen to texture that fits the points best (least squares), or passes through them.
    ///
    /// # Errors
    /// Those of the model's own estimator, and [`Error::Projection`] where the map found has no value at a control point.
    pub fn fit(
        self,
        screen: &[Point2<f64>],
        texture: &[Point2<f64>],
    ) -> Result<Registration, Error> {
        control::check(screen, texture, 3)?;
        let map = self.map(screen, texture)?;
        let residuals = screen
            .iter()
            .zip(texture)
            .map(|(s, t)| Ok(t - map.at(s)?))
            .collect::<Result<Vec<Vector2<f64>>, ProjectionError>>()?;
        let rms = root_mean_square(residuals.iter());
        Ok(Registration { model: self, map, residuals, rms })
    }

    fn map(self, screen: &[Point2<f64>], texture: &[Point2<f64>]) -> Result<FittedMap, Error> {
        Ok(match self {
            Self::Affine => FittedMap::Affine(Affine2::fit(screen, texture)?.map),
            Self::Projective => {
                let fit = Homography::fit(screen, texture, &FitOptions::default())?;
                FittedMap::Projective(FractionalLinear::from_homography(&fit.homography))
            }
            Self::Bilinear => FittedMap::Bilinear(Bilinear::fit(screen, texture)?.map),
            Self::Quadratic => FittedMap::Quadratic(Quadratic::fit(screen, texture)?.map),
            Self::Cubic => FittedMap::Cubic(Cubic::fit(screen, texture)?.map),
            Self::PiecewiseAffine => {
                FittedMap::PiecewiseAffine(PiecewiseAffine::new(screen, texture)?)
            }
            Self::PiecewiseCubic => {
                FittedMap::PiecewiseCubic(PiecewiseCubic::new(screen, texture)?)
            }
            Self::ThinPlate { smoothing } => {
                FittedMap::ThinPlate(ThinPlate::fit(screen, texture, smoothing)?)
            }
        })
    }
}

impl fmt::Display for MapModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Affine => f.pad("affine"),
            Self::Projective => f.pad("projective"),
            Self::Bilinear => f.pad("bilinear"),
            Self::Quadratic => f.pad("quadratic"),
            Self::Cubic => f.pad("cubic"),
            Self::PiecewiseAffine => f.pad("piecewise affine"),
            Self::PiecewiseCubic => f.pad("piecewise cubic"),
            Self::ThinPlate { smoothing: 0.0 } => f.pad("thin plate"),
            Self::ThinPlate { smoothing } => {
                f.pad(&alloc::format!("thin plate, λ = {}", crate::error::Brief(*smoothing)))
            }
        }
    }
}

/// A map of any of the models.
#[derive(Clone, Debug)]
#[non_exhaustive]
#[allow(missing_docs, reason = "each is named as its model")]
pub enum FittedMap {
    Affine(Affine2),
    Projective(FractionalLinear),
    Bilinear(Bilinear),
    Quadratic(Quadratic),
    Cubic(Cubic),
    PiecewiseAffine(PiecewiseAffine),
    PiecewiseCubic(PiecewiseCubic),
    ThinPlate(ThinPlate),
}

impl FittedMap {
    fn inner(&self) -> &dyn Map {
        match self {
            Self::Affine(map) => map,
            Self::Projective(map) => map,
            Self::Bilinear(map) => map,
            Self::Quadratic(map) => map,
            Self::Cubic(map) => map,
            Self::PiecewiseAffine(map) => map,
            Self::PiecewiseCubic(map) => map,
            Self::ThinPlate(map) => map,
        }
    }
}

impl Map for FittedMap {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.inner().at(screen)
    }

    fn jacobian(&self, screen: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        self.inner().jacobian(screen)
    }

    fn blocks(&self, line: i32, samples: Range<i32>, emit: &mut BlockSink<'_>) {
        self.inner().blocks(line, samples, emit);
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        self.inner().span(line, samples)
    }
}

/// A map fitted to control points.
#[derive(Clone, Debug)]
pub struct Registration {
    /// Which kind of map.
    pub model: MapModel,
    /// The map, texture from screen.
    pub map: FittedMap,
    /// Texture point minus mapped screen point, for each pair.
    pub residuals: Vec<Vector2<f64>>,
    /// √(Σ‖v‖² / n), in texels.
    pub rms: f64,
}

/// Which points are left out together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Folds {
    /// Each point by itself: n fits to n − 1 points.
    LeaveOneOut,
    /// Point i with all points i mod k: k fits. For many points, of which a thin plate costs n³/3 a fit.
    Every(usize),
}

/// What a model predicts of points that it has not seen.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossValidation {
    /// Texture point minus prediction from the points of the other folds, for each pair; `None` where those do not
    /// determine the map or it does not reach so far, as piecewise maps do not beyond their hull.
    pub residuals: Vec<Option<Vector2<f64>>>,
    /// √(Σ‖v‖² / m) of the m points predicted; NaN if there are none.
    pub rms: f64,
    /// The greatest ‖v‖; zero if no point is predicted.
    pub largest: f64,
    /// How many points are predicted.
    pub predicted: usize,
}

fn root_mean_square<'a>(residuals: impl Iterator<Item = &'a Vector2<f64>>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for r in residuals {
        sum += r.norm_squared();
        count += 1.0;
    }
    float::sqrt(sum / count)
}

/// Leaves out each fold in turn and predicts it from the other points.
///
/// The rms of these residuals estimates the error of the map at a point like the control points. It is somewhat too large,
/// as each fit has fewer points than the final one, most of all at the outermost points.
///
/// # Errors
/// [`Error::LengthMismatch`], [`Error::TooFewPoints`] below four, [`Error::NotFinite`]; [`Error::OutOfRange`] for less than two
/// folds or more than points. A fold that cannot be predicted is no error but has no residuals.
///
/// # Example
/// u = S² at the corners of a square and in its middle, each predicted by the affine map of the other four:
///
/// ```
/// use collinear::mapping::registration::{Folds, MapModel, cross_validate};
/// use nalgebra::{Point2, Vector2};
///
/// let screen = [(0., 0.), (2., 0.), (0., 2.), (2., 2.), (1., 1.)].map(|(x, y)| Point2::new(x, y));
/// let texture = screen.map(|p| Point2::new(p.x * p.x, p.y));
/// let cross = cross_validate(MapModel::Affine, &screen, &texture, Folds::LeaveOneOut)?;
/// // The middle point: the plane through u = 0, 4, 0, 4 has 2 there, and u is 1.
/// assert!((cross.residuals[4].unwrap() - Vector2::new(-1.0, 0.0)).norm() < 1e-14);
/// assert_eq!(cross.predicted, 5);
/// # Ok::<(), collinear::Error>(())
/// ```
pub fn cross_validate(
    model: MapModel,
    screen: &[Point2<f64>],
    texture: &[Point2<f64>],
    folds: Folds,
) -> Result<CrossValidation, Error> {
    control::check(screen, texture, 4)?;
    let n = screen.len();
    let folds = match folds {
        Folds::LeaveOneOut => n,
        Folds::Every(k) => k,
    };
    if !(2..=n).contains(&folds) {
        return Err(Error::OutOfRange {
            what: "number of folds",
            value: folds as f64,
            expected: "two to the number of points",
        });
    }
    let mut residuals = alloc::vec![None; n];
    for fold in 0..folds {
        let kept = |points: &[Point2<f64>]| -> Vec<Point2<f64>> {
            points.iter().enumerate().filter(|(i, _)| i % folds != fold).map(|(_, p)| *p).collect()
        };
        let Ok(map) = model.map(&kept(screen), &kept(texture)) else { continue };
        for i in (fold..n).step_by(folds) {
            residuals[i] = map.at(&screen[i]).ok().map(|p| texture[i] - p);
        }
    }
    let all = || residuals.iter().flatten();
    let rms = root_mean_square(all());
    let largest = all().map(Vector2::norm).fold(0.0, f64::max);
    let predicted = all().count();
    Ok(CrossValidation { residuals, rms, largest, predicted })
}

/// One model of a comparison.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The model.
    pub model: MapModel,
    /// The map fitted to all points, or why there is none.
    pub registration: Result<Registration, Error>,
    /// What it predicts.
    pub cross_validation: CrossValidation,
    /// √(Σ‖v‖² / m) of the predictions of those m points that every candidate predicts: what the candidates are sorted by. NaN
    /// for a model that predicts no point.
    pub common_rms: f64,
}

/// Models compared at the same points, the best prediction first. Shown as a table.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The models, by [`Candidate::common_rms`]; those that predict nothing last.
    pub candidates: Vec<Candidate>,
    /// The points that every model predicts, of those models that predict any.
    pub common: Vec<usize>,
}

/// Fits and cross-validates models at the same points.
///
/// Piecewise maps do not reach points outside the hull of the others, which are the hardest to predict: so the models
/// are compared at the points that all of them predict.
///
/// # Errors
/// As [`cross_validate`]. A model that the points do not determine is listed last with its error.
///
/// # Example
/// Nine points of a quadratic map: the quadratic predicts them all, an affine map none.
///
/// ```
/// use collinear::mapping::registration::{Folds, MapModel, compare};
/// use nalgebra::Point2;
///
/// let screen: Vec<_> = (0..9).map(|i| Point2::new(f64::from(i % 3), f64::from(i / 3))).collect();
/// let texture: Vec<_> = screen.iter().map(|p| Point2::new(p.x * p.x + p.y, p.x * p.y)).collect();
/// let models = [MapModel::Affine, MapModel::Quadratic, MapModel::Cubic];
/// let table = compare(&models, &screen, &texture, Folds::LeaveOneOut)?;
/// assert_eq!(table.candidates[0].model, MapModel::Quadratic);
/// assert!(table.candidates[0].cross_validation.rms < 1e-12);
/// // Ten terms want ten points.
/// assert!(table.candidates[2].registration.is_err());
/// # Ok::<(), collinear::Error>(())
/// ```
pub fn compare(
    models: &[MapModel],
    screen: &[Point2<f64>],
    texture: &[Point2<f64>],
    folds: Folds,
) -> Result<Comparison, Error> {
    let mut candidates = Vec::new();
    for &model in models {
        candidates.push(Candidate {
            model,
            registration: model.fit(screen, texture),
            cross_validation: cross_validate(model, screen, texture, folds)?,
            common_rms: f64::NAN,
        });
    }
    let able = |c: &&Candidate| c.cross_validation.predicted > 0;
    let common: Vec<usize> = (0..screen.len())
        .filter(|&i| {
            candidates.iter().filter(able).all(|c| c.cross_validation.residuals[i].is_some())
        })
        .collect();
    for c in &mut candidates {
        let residuals = &c.cross_validation.residuals;
        c.common_rms = root_mean_square(common.iter().filter_map(|&i| residuals[i].as_ref()));
    }
    candidates.sort_by(|a, b| {
        // NaN, of whichever sign, last.
        let key = |c: &Candidate| if c.common_rms.is_nan() { f64::INFINITY } else { c.common_rms };
        key(a).total_cmp(&key(b))
    });
    Ok(Comparison { candidates, common })
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<24} {:>12} {:>12} {:>12} {:>12} {:>9}",
            "model", "fit rms", "cross rms", "common rms", "cross max", "predicted"
        )?;
        for c in &self.candidates {
            let cross = &c.cross_validation;
            write!(f, "{:<24} ", c.model)?;
            match &c.registration {
                Ok(fit) => write!(f, "{:>12.4}", fit.rms)?,
                Err(_) => write!(f, "{:>12}", "none")?,
            }
            writeln!(
                f,
                " {:>12.4} {:>12.4} {:>12.4} {:>9}",
                cross.rms, c.common_rms, cross.largest, cross.predicted
            )?;
        }
        Ok(())
    }
}
