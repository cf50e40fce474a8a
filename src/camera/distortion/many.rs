//! Undistortion of many points.

use nalgebra::Point2;

use super::one_to_one::{OneToOne, along_radius, invert};
use super::planar::Planar;
use crate::numeric::float;

/// How the undistortion of many points went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UndistortedMany {
    /// Points whose residual reached its rounding floor.
    pub converged: usize,
    /// Points that no ideal point of the domain has for its image, or that are not numbers; they are written as NaN.
    pub failed: usize,
    /// The largest ‖distort(point) − given point‖ of the converged ones, in units of the principal distance.
    pub largest_residual: f64,
}

impl UndistortedMany {
    pub(crate) const NONE: Self = Self { converged: 0, failed: 0, largest_residual: 0.0 };

    fn add(&mut self, residual: f64) {
        self.converged += 1;
        self.largest_residual = self.largest_residual.max(residual);
    }

    /// Undistorts one point in place.
    pub(super) fn one(
        &mut self,
        point: &mut Point2<f64>,
        found: Result<super::Undistorted, crate::error::ProjectionError>,
    ) {
        match found {
            Ok(found) => {
                *point = found.point;
                self.add(found.residual);
            }
            Err(_) => {
                *point = Point2::new(f64::NAN, f64::NAN);
                self.failed += 1;
            }
        }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            converged: self.converged + other.converged,
            failed: self.failed + other.failed,
            largest_residual: self.largest_residual.max(other.largest_residual),
        }
    }
}

/// Fewer points are not worth a start of their own.
const FEW: usize = 32;
/// The start's polynomial reaches to this share of the fold radius.
const SHARE_OF_FOLD: f64 = 0.9;
/// Degree of the start's polynomial.
const DEGREE: usize = 7;
/// cos((2i + 1)π/16): Chebyshev's nodes.
const NODES: [f64; DEGREE + 1] = [
    0.980_785_280_403_230_4,
    0.831_469_612_302_545_2,
    0.555_570_233_019_602_2,
    0.195_090_322_016_128_28,
    -0.195_090_322_016_128_28,
    -0.555_570_233_019_602_2,
    -0.831_469_612_302_545_2,
    -0.980_785_280_403_230_4,
];

/// The start of the iteration for points within a radius: r_ideal/r″ as a polynomial in r″², interpolated between exact
/// inverses of the radial part (Newton's form).
struct Start {
    /// s ↦ 2 s/R² − 1
    scale: f64,
    differences: [f64; DEGREE + 1],
}

impl Start {
    fn new(lens: &impl OneToOne, squared_radius: f64) -> Self {
        let mut differences = [0.0; DEGREE + 1];
        for (value, node) in differences.iter_mut().zip(NODES) {
            let distorted = float::sqrt(0.5 * squared_radius * (1.0 + node));
            *value = along_radius(lens, distorted) / distorted;
        }
        for level in 1..=DEGREE {
            for i in (level..=DEGREE).rev() {
                let across = NODES[i] - NODES[i - level];
                differences[i] = (differences[i] - differences[i - 1]) / across;
            }
        }
        Self { scale: 2.0 / squared_radius, differences }
    }

    #[inline(always)]
    fn ratio(&self, squared: f64) -> f64 {
        let x = squared * self.scale - 1.0;
        let mut sum = self.differences[DEGREE];
        for i in (0..DEGREE).rev() {
            sum = sum * (x - NODES[i]) + self.differences[i];
        }
        sum
    }
}

/// Undistorts points in place.
///
/// A start by the radial polynomial, one Newton step, and one more with the same Jacobian; a point whose residual is then not
/// at its rounding floor goes the way of a single point. The points beside it shape the start, and with it at most a point's
/// last bits; the instruction set shapes nothing.
pub(super) fn undistort_many<const N: usize, const D: usize, const T: u8, const S: u8>(
    lens: &Planar<N, D, T, S>,
    points: &mut [Point2<f64>],
) -> UndistortedMany {
    let mut report = UndistortedMany::NONE;
    // What lies nearer to the fold than the start reaches, or beyond it, is found out by its residual and goes alone.
    let fold = lens.fold_radius();
    let rim = if fold.is_finite() { lens.radial(SHARE_OF_FOLD * fold)[0] } else { f64::INFINITY };
    let farthest = points.iter().map(|p| p.coords.norm_squared()).fold(0.0, f64::max);
    let farthest = farthest.min(rim * rim);
    if points.len() < FEW || !(farthest > 0.0 && farthest < 1e12) {
        for point in points {
            report.one(point, invert(lens, point));
        }
        return report;
    }
    let start = Start::new(lens, farthest);
    #[cfg(feature = "simd")]
    {
        let level = fearless_simd::Level::new();
        fearless_simd::dispatch!(level, _simd => blocks(lens, &start, points))
    }
    #[cfg(not(feature = "simd"))]
    blocks(lens, &start, points)
}

/// Points that are computed before any is judged: a loop without branches, which compilers turn into vector instructions.
const BLOCK: usize = 64;

#[inline(always)]
fn blocks<const N: usize, const D: usize, const T: u8, const S: u8>(
    lens: &Planar<N, D, T, S>,
    start: &Start,
    points: &mut [Point2<f64>],
) -> UndistortedMany {
    let mut report = UndistortedMany::NONE;
    let fold_squared = lens.fold_radius() * lens.fold_radius();
    let (mut x, mut y, mut squares) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
    for block in points.chunks_mut(BLOCK) {
        let places = x.iter_mut().zip(&mut y).zip(&mut squares);
        for (point, ((x, y), square)) in block.iter().zip(places) {
            let found = two_steps(lens, start, [point.x, point.y]);
            [*x, *y] = found.point;
            // A point outside the disc is no answer, and NaN fails every comparison.
            let inside = found.point[0] * found.point[0] + found.point[1] * found.point[1];
            let good = found.square <= found.floor && inside < fold_squared;
            *square = if good { found.square } else { f64::INFINITY };
        }
        let worst = largest(&squares[..block.len()]);
        if worst < f64::INFINITY {
            for (point, (x, y)) in block.iter_mut().zip(x.iter().zip(&y)) {
                *point = Point2::new(*x, *y);
            }
            report.converged += block.len();
            report.largest_residual = report.largest_residual.max(float::sqrt(worst));
            continue;
        }
        let places = x.iter().zip(&y).zip(&squares);
        for (point, ((x, y), square)) in block.iter_mut().zip(places) {
            if square.is_finite() {
                *point = Point2::new(*x, *y);
                report.add(float::sqrt(*square));
            } else {
                report.one(point, invert(lens, point));
            }
        }
    }
    report
}

/// The largest of numbers of which none is NaN, eight side by side.
#[inline(always)]
fn largest(values: &[f64]) -> f64 {
    let mut most = [0.0_f64; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        for (most, value) in most.iter_mut().zip(eight) {
            *most = if *value > *most { *value } else { *most };
        }
    }
    most.iter().chain(rest).fold(0.0, |most: f64, value| most.max(*value))
}

/// The residual's rounding floor over the point's radius, that of a single point.
const FLOOR: f64 = 16.0 * f64::EPSILON;

struct Found {
    point: [f64; 2],
    /// The squared residual, and the square it must not exceed.
    square: f64,
    floor: f64,
}

/// The start, a Newton step, and another with the same Jacobian.
#[inline(always)]
fn two_steps<const N: usize, const D: usize, const T: u8, const S: u8>(
    lens: &Planar<N, D, T, S>,
    start: &Start,
    target: [f64; 2],
) -> Found {
    let norm = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
    let squared = norm(target);
    let ratio = start.ratio(squared);
    let mut point = target.map(|c| c * ratio);
    if T > 0 || S > 0 {
        // The radial start throws the point off by what the other terms add there.
        let beside = lens.beside_radial(point);
        let radial = [target[0] - beside[0], target[1] - beside[1]];
        let ratio = start.ratio(norm(radial));
        point = radial.map(|c| c * ratio);
    }
    let [a, b, c, d] = lens.jacobian_of(point);
    let inverse = 1.0 / (a * d - b * c);
    let mut miss = lens.miss(point, target);
    for _ in 0..2 {
        let step = [(d * miss[0] - b * miss[1]) * inverse, (a * miss[1] - c * miss[0]) * inverse];
        point = [point[0] - step[0], point[1] - step[1]];
        miss = lens.miss(point, target);
    }
    Found { point, square: norm(miss), floor: FLOOR * FLOOR * squared }
}
