//! Check points: how far an adjusted block is from places that took no part in it.

use alloc::vec::Vec;

use nalgebra::{Point3, Vector3};

use super::Adjusted;
use super::problem::PointId;
use crate::error::Error;

/// Adjusted points beside coordinates that are known otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckPoints {
    /// Adjusted minus known, world units, of each point that was determined.
    pub differences: Vec<(PointId, Vector3<f64>)>,
    /// The points that the block does not determine, as too few photographs see them.
    pub undetermined: Vec<PointId>,
    /// The mean difference: a shift of the block. NaN where no point is determined, as the others.
    pub mean: Vector3<f64>,
    /// The root mean square difference in X, Y and Z: what accuracy standards ask for (ASPRS 2014).
    #[doc(alias("RMSE"))]
    pub rms: Vector3<f64>,
    /// The largest distance of a point from where it is known to be.
    pub largest: f64,
}

impl<C> Adjusted<C> {
    /// Compares adjusted points with known coordinates, which were not told to the adjustment: pass points, whose place its
    /// datum gives.
    ///
    /// # Errors
    /// [`Error::Unknown`] for a point of another block, [`Error::NotFinite`], [`Error::TooFewPoints`] for none.
    #[doc(alias("ICP", "independent check point"))]
    pub fn check(&self, known: &[(PointId, Point3<f64>)]) -> Result<CheckPoints, Error> {
        if known.is_empty() {
            return Err(Error::TooFewPoints { needed: 1, got: 0 });
        }
        let (mut differences, mut undetermined) = (Vec::new(), Vec::new());
        for (id, known) in known {
            let point = self.point(*id).ok_or(Error::Unknown { what: "check point" })?;
            if !known.iter().all(|c| c.is_finite()) {
                return Err(Error::NotFinite { what: "check point" });
            }
            if self.undetermined.binary_search(id).is_ok() {
                undetermined.push(*id);
            } else {
                differences.push((*id, point - known));
            }
        }
        let n = differences.len() as f64;
        let sum = |f: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
            differences.iter().fold(Vector3::zeros(), |s, (_, d)| s + f(d)) / n
        };
        let (mean, squares) = (sum(&|d| *d), sum(&|d| d.component_mul(d)));
        let largest = differences.iter().map(|(_, d)| d.norm()).reduce(f64::max);
        Ok(CheckPoints {
            mean,
            rms: squares.map(f64::sqrt),
            largest: largest.unwrap_or(f64::NAN),
            differences,
            undetermined,
        })
    }
}
