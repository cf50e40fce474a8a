//! Poses to start from, found from the points alone.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Point3, Vector3};

use super::object_space::{LEAST_SPREAD, ObjectSpace};
use super::solve::Observed;
use crate::adjust::p3p;
use crate::camera::{CentralModel, ExteriorOrientation};
use crate::error::Error;
use crate::geometry::rotation::orthonormalised;
use crate::numeric::float;
use crate::numeric::triangular::Triangular;

/// All lines of sight are one; the measure is their mean squared sine from the middle one, about.
pub(super) fn no_sight(measure: f64) -> Error {
    let what = "resection: directions of the image points";
    Error::Degenerate { what, measure, limit: LEAST_SPREAD }
}

/// Three points leave up to four poses, a fourth tells which.
const LEAST_POINTS: usize = 4;

/// Refuses fewer than four different object points.
pub(super) fn check_distinct(points: &[Observed]) -> Result<(), Error> {
    let mut different: Vec<Point3<f64>> = Vec::with_capacity(LEAST_POINTS);
    for point in points {
        if !different.contains(&point.object) {
            different.push(point.object);
            if different.len() == LEAST_POINTS {
                return Ok(());
            }
        }
    }
    Err(Error::TooFewPoints { needed: LEAST_POINTS, got: different.len() })
}

/// Poses to start from, some of them with points behind the camera.
pub(super) struct Starts {
    /// Every minimum of the object-space error, least error first: one at least.
    pub(super) minima: Vec<ExteriorOrientation>,
    /// What else to try, in no order.
    pub(super) others: Vec<ExteriorOrientation>,
    /// Whether the points are near a plane, which has two solutions, however much worse the second.
    pub(super) flat: bool,
}

/// Points are flat where their extent across a plane is below this part of that along it.
const FLAT: f64 = 0.01;

/// The poses that the points give by themselves.
pub(super) fn poses<C: CentralModel>(camera: &C, points: &[Observed]) -> Result<Starts, Error> {
    let Extent { center, size, flat } = extent(points)?;
    let mut sights = Vec::with_capacity(points.len());
    for point in points {
        let direction = camera.direction(&point.image)?;
        sights.push(((point.object - center) / size, direction, point.single_weight()));
    }
    // The heaviest point has weight one, so that no weight leaves the numbers.
    let most = sights.iter().map(|s| s.2).fold(0.0, f64::max);
    let scaled = sights.iter().map(|(x, f, w)| (*x, *f, w / most));
    let space = ObjectSpace::new(scaled).map_err(no_sight)?;
    let (mut minima, mut others) = (Vec::new(), Vec::new());
    for minimum in space.minima() {
        let rotation = orthonormalised(&minimum.rotation)?;
        let translation = space.translation(rotation.matrix()) * size;
        minima.push(ExteriorOrientation::new(center - rotation.inverse() * translation, rotation));
    }
    if points.len() <= FEW {
        others.extend(from_triples(points, &sights));
    }
    Ok(Starts { minima, others, flat })
}

/// Up to so many points the poses of their triples are tried too: minima lie close together then.
const FEW: usize = 5;

/// Every pose from three of the points, for each three neighbours in a ring: every point is left out at least once.
fn from_triples(
    points: &[Observed],
    sights: &[(Vector3<f64>, Vector3<f64>, f64)],
) -> impl Iterator<Item = ExteriorOrientation> {
    let n = points.len();
    (0..n).flat_map(move |i| {
        let three = [i, (i + 1) % n, (i + 2) % n];
        let roots = p3p(&three.map(|k| points[k].object), &three.map(|k| sights[k].1));
        let poses = roots.into_iter().flatten();
        poses.map(|pose| ExteriorOrientation::new(pose.origin, pose.rotation))
    })
}

/// Where the object points are.
struct Extent {
    center: Point3<f64>,
    /// Their root mean square distance from it.
    size: f64,
    flat: bool,
}

/// Refuses points on a line.
fn extent(points: &[Observed]) -> Result<Extent, Error> {
    let n = points.len() as f64;
    let first = points.first().map_or(Point3::origin(), |p| p.object);
    let mean = points.iter().fold(Vector3::zeros(), |s, p| s + (p.object - first)) / n;
    let center = first + mean;
    let mut scatter = Matrix3::zeros();
    let mut largest: f64 = 0.0;
    for point in points {
        let d = point.object - center;
        scatter += d * d.transpose();
        largest = largest.max(point.object.coords.amax());
    }
    let size = float::sqrt(scatter.trace() / n);
    if !(size.is_finite() && size > 0.0) {
        return Err(Error::NotFinite { what: "extent of the control points" });
    }
    // Across over along: the roots of eigenvalues are good to 10⁻⁸, singular values beyond that.
    let second = {
        let (a, b) =
            (scatter.trace(), 0.5 * (scatter.trace().powi(2) - (scatter * scatter).trace()));
        // λ₁λ₂ + λ₁λ₃ + λ₂λ₃ of the sum squared: at most the ratio λ₂/λ₁.
        b / (a * a)
    };
    // λ₃/λ₁, and less where the second is small too.
    let third = scatter.determinant() / (scatter.trace().powi(3) * second);
    let extent = Extent { center, size, flat: third < FLAT * FLAT };
    if second > 1e-10 {
        return Ok(extent);
    }
    let mut rows = Triangular::<3>::new();
    for point in points {
        let d = (point.object - center) / size;
        rows.add_row([d.x, d.y, d.z]);
    }
    let (along, _) = rows.singular();
    // Map coordinates of 10⁶ are rounded to 10⁻¹⁰: points nearer to a line than that are on it.
    let limit = 1e-12 + 8.0 * f64::EPSILON * largest / size;
    let measure = along[1] / along[0];
    if measure > limit {
        return Ok(extent);
    }
    Err(Error::Degenerate { what: "resection: control points on a line", measure, limit })
}
