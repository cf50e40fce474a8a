//! Formulas that are one to one on a disc, and their inverse.

use nalgebra::{Matrix2, Point2, Vector2};

use super::Undistorted;
use crate::camera::collinearity::finite;
use crate::error::ProjectionError;
use crate::numeric::float;

/// Refuses a point at or beyond the fold.
#[inline]
fn within(ideal: &Point2<f64>, fold_radius: f64) -> Result<(), ProjectionError> {
    if ideal.coords.norm_squared() < fold_radius * fold_radius {
        return Ok(());
    }
    let value = length(&ideal.coords);
    Err(if value.is_nan() {
        ProjectionError::NotFinite
    } else {
        ProjectionError::OutsideDomain { value, limit: fold_radius }
    })
}

/// The length of a vector whose squares may leave the numbers.
#[inline]
fn length(v: &Vector2<f64>) -> f64 {
    let squared = v.norm_squared();
    if squared > 1e-280 && squared < f64::INFINITY {
        float::sqrt(squared)
    } else {
        float::hypot(v.x, v.y)
    }
}

/// Newton steps allowed: five are rarely needed, bisection to the last bit would take 52.
const MAX_STEPS: u32 = 100;
/// A start for the inverse may be thrown this many times farther than the point that is sought.
const MOST_SPREAD: f64 = 1e3;

/// A formula on the disc where it is one to one.
pub(super) trait OneToOne: Copy {
    /// The distorted point.
    fn value(&self, p: &Point2<f64>) -> Point2<f64>;
    /// ∂(x″, y″)/∂(x, y); its symmetric part is positive definite on the disc.
    fn jacobian(&self, p: &Point2<f64>) -> Matrix2<f64>;
    /// The radius of the disc; infinite for the whole plane.
    fn fold_radius(&self) -> f64;
    /// No point within a radius is thrown farther than this.
    fn reach(&self, radius: f64) -> f64;
    /// The radial part of the formula, r·f(r), and its slope.
    fn radial(&self, radius: f64) -> [f64; 2];
    /// Whether the formula is its radial part.
    fn is_radial(&self) -> bool;
    /// ∂(x″, y″)/∂ of each coefficient.
    fn columns(&self, p: &Point2<f64>, out: &mut [Vector2<f64>]);

    /// The distorted point of a point of the disc.
    ///
    /// # Errors
    /// [`ProjectionError::OutsideDomain`], [`ProjectionError::NotFinite`].
    #[inline]
    fn checked(&self, ideal: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        within(ideal, self.fold_radius())?;
        finite(self.value(ideal))
    }
}

/// The ideal point of a distorted one.
///
/// The radial part is inverted first, by Newton steps kept in a bracket; from there full steps of the plane, halved until
/// they stay inside the disc and come nearer. Inside the disc the Jacobian's symmetric part is positive definite, so the
/// map is one to one and a step that comes nearer always exists: the iteration can end only at the point, or pressed
/// against the rim when no point of the disc has this image.
pub(super) fn invert(
    lens: &impl OneToOne,
    distorted: &Point2<f64>,
) -> Result<Undistorted, ProjectionError> {
    finite(*distorted)?;
    let target = distorted.coords;
    let radius = length(&target);
    if radius.is_infinite() {
        return Err(ProjectionError::NotFinite);
    }
    let fold = lens.fold_radius();
    // The rounding floor of the residual: the formula's terms are summed with a few roundings.
    let floor = 4.0 * f64::EPSILON * radius;
    let mut point = start(lens, distorted, radius)?;
    let mut miss = lens.value(&point).coords - target;
    let mut residual = length(&miss);
    for iterations in 0..MAX_STEPS {
        if residual <= floor {
            return Ok(Undistorted { point, iterations, residual });
        }
        let Some(inverse) = lens.jacobian(&point).try_inverse() else { break };
        let step = inverse * miss;
        let mut fraction = 1.0;
        let (next, next_miss, next_residual) = loop {
            let candidate = point - step * fraction;
            if candidate.coords.norm_squared() < fold * fold {
                let miss = lens.value(&candidate).coords - target;
                let r = length(&miss);
                if r < residual {
                    break (candidate, miss, r);
                }
            }
            // A few roundings from zero a full step that comes no nearer has said enough, and this is the answer.
            if residual <= 4.0 * floor {
                return Ok(Undistorted { point, iterations, residual });
            }
            fraction *= 0.5;
            if fraction < 1e-12 {
                // No nearer point: the fold is in the way.
                return Err(no_preimage(lens, &point, radius, iterations, residual));
            }
        };
        (point, miss, residual) = (next, next_miss, next_residual);
    }
    if residual <= 4.0 * floor {
        return Ok(Undistorted { point, iterations: MAX_STEPS, residual });
    }
    Err(no_preimage(lens, &point, radius, MAX_STEPS, residual))
}

/// The point on the target's ray that the radial part alone would throw to the target's radius.
fn start(
    lens: &impl OneToOne,
    distorted: &Point2<f64>,
    radius: f64,
) -> Result<Point2<f64>, ProjectionError> {
    let fold = lens.fold_radius();
    if !lens.is_radial() && radius < 0.5 * fold && radius < 1.0 {
        let [value, slope] = lens.radial(radius);
        // Far from the fold a mild lens leaves the point near enough to itself that one step along the radius does; where the
        // steps in the plane are needed in any case, one more costs less than the search along the radius.
        if (value - radius).abs() < 0.3 * radius && slope > 0.3 {
            return Ok(*distorted * (1.0 - (value - radius) / (slope * radius)));
        }
    }
    if radius >= fold {
        let limit = lens.reach(fold);
        if radius > limit {
            return Err(ProjectionError::OutsideDomain { value: radius, limit });
        }
    }
    let scale = if radius > 0.0 { along_radius(lens, radius) / radius } else { 1.0 };
    Ok(distorted * scale)
}

/// The radius that the radial part alone throws to `radius`, or the nearest to it that the disc has; by Newton's steps, kept in
/// a bracket, to a relative 10⁻⁸.
pub(super) fn along_radius(lens: &impl OneToOne, radius: f64) -> f64 {
    let fold = lens.fold_radius();
    let mut high = radius;
    if fold.is_finite() {
        high = fold * (1.0 - 1e-9);
    } else {
        // Of a lens that spreads the picture a far start is thrown much farther, or out of the numbers; of one that
        // contracts it the point lies beyond its image.
        while high > 1.0 && !(lens.reach(high) <= MOST_SPREAD * radius) {
            high *= 0.5;
        }
        while high < 1e150 && lens.radial(high)[0] < radius {
            high *= 2.0;
        }
    }
    let (mut low, mut r) = (0.0, radius.min(0.5 * (radius + high)).min(high));
    for _ in 0..12 {
        let [value, slope] = lens.radial(r);
        if !(value < radius) {
            high = r;
        } else {
            low = r;
        }
        let next = r - (value - radius) / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        // Quadratic convergence: the next error is the square of this step's.
        let near = (next - r).abs() <= 1e-4 * r;
        r = next;
        if near {
            break;
        }
    }
    r
}

/// Why the search stopped: pressed against the fold, or out of steps.
fn no_preimage(
    lens: &impl OneToOne,
    stopped: &Point2<f64>,
    radius: f64,
    iterations: u32,
    residual: f64,
) -> ProjectionError {
    let (reached, fold) = (length(&stopped.coords), lens.fold_radius());
    if reached > 0.99 * fold {
        let rim = lens.value(&Point2::from(stopped.coords * (fold / reached)));
        let limit = length(&rim.coords);
        ProjectionError::OutsideDomain { value: radius, limit }
    } else {
        ProjectionError::NotConverged { iterations, residual }
    }
}
