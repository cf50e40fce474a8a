//! Undistortion of many points.

use core::f64::consts::FRAC_PI_2;

use nalgebra::Point2;

use super::one_to_one::{OneToOne, along_radius, invert};
use super::planar::Planar;
use crate::numeric::float;
use crate::numeric::scalar::Scalar;
use crate::numeric::vectorised;

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
/// The start's polynomials reach to this share of the fold radius.
const SHARE_OF_FOLD: f64 = 0.9;
/// Degree of the start's polynomial: with one less some points of a common lens need a third step, with one more no fewer do.
const DEGREE: usize = 6;
/// Degree of the polynomial for what decentering and prism add, which is small and need not be exact.
const ROUGH: usize = 3;

/// r_ideal/r″ as a polynomial in r″², interpolated between exact inverses of the radial part at Chebyshev's nodes.
struct Ratio<const COEFFICIENTS: usize> {
    /// s ↦ 2 s/R² − 1
    scale: f32,
    coefficients: [f32; COEFFICIENTS],
}

impl<const COEFFICIENTS: usize> Ratio<COEFFICIENTS> {
    fn new(lens: &impl OneToOne, squared_radius: f64) -> Self {
        let count = COEFFICIENTS as f64;
        let nodes: [f64; COEFFICIENTS] =
            core::array::from_fn(|i| float::sin(FRAC_PI_2 * ((2 * i + 1) as f64 / count - 1.0)));
        let mut differences = nodes.map(|node| {
            let distorted = float::sqrt(0.5 * squared_radius * (1.0 + node));
            along_radius(lens, distorted) / distorted
        });
        for level in 1..COEFFICIENTS {
            for i in (level..COEFFICIENTS).rev() {
                let across = nodes[i] - nodes[i - level];
                differences[i] = (differences[i] - differences[i - 1]) / across;
            }
        }
        // Newton's form to powers: p ← p (x − node) + difference.
        let mut coefficients = [0.0; COEFFICIENTS];
        for (difference, node) in differences.iter().zip(nodes).rev() {
            for i in (1..COEFFICIENTS).rev() {
                coefficients[i] = coefficients[i - 1] - node * coefficients[i];
            }
            coefficients[0] = difference - node * coefficients[0];
        }
        Self { scale: (2.0 / squared_radius) as f32, coefficients: coefficients.map(|c| c as f32) }
    }

    #[inline(always)]
    fn at(&self, squared: f32) -> f32 {
        let x = squared * self.scale - 1.0;
        let Some((last, rest)) = self.coefficients.split_last() else { return 0.0 };
        rest.iter().rev().fold(*last, |sum, c| sum * x + c)
    }
}

/// Where the iteration begins, for points within a radius.
struct Start {
    ratio: Ratio<{ DEGREE + 1 }>,
    rough: Ratio<{ ROUGH + 1 }>,
}

impl Start {
    fn new(lens: &impl OneToOne, squared_radius: f64) -> Self {
        Self { ratio: Ratio::new(lens, squared_radius), rough: Ratio::new(lens, squared_radius) }
    }
}

#[inline(always)]
fn norm<V: Scalar>([x, y]: [V; 2]) -> V {
    x * x + y * y
}

/// Undistorts points in place.
///
/// A start by the radial polynomial, a Newton step and another with the same Jacobian, to the rounding floor of the residual. A
/// point that is not there takes a third step, then two with a new Jacobian, and at last goes the way of a single point. The
/// points beside it shape the start, and with it at most a point's last bits; the instruction set shapes nothing.
pub(super) fn undistort_many<const N: usize, const D: usize, const T: u8, const S: u8>(
    lens: &Planar<N, D, T, S>,
    points: &mut [Point2<f64>],
) -> UndistortedMany {
    let mut report = UndistortedMany::NONE;
    // What lies nearer to the fold than the start reaches, or beyond it, is found out by its residual and goes alone.
    let fold = lens.fold_radius();
    let rim = if fold.is_finite() { lens.radial(SHARE_OF_FOLD * fold)[0] } else { f64::INFINITY };
    let farthest = farthest(points).min(rim * rim);
    if points.len() < FEW || !(farthest > 0.0 && farthest < 1e12) {
        for point in points {
            report.one(point, invert(lens, point));
        }
        return report;
    }
    let start = Start::new(lens, farthest);
    vectorised(
        #[inline(always)]
        || blocks(lens, &start, points),
    )
}

/// The largest squared radius, eight points side by side; of a point that is no number there is none.
fn farthest(points: &[Point2<f64>]) -> f64 {
    let mut most = [0.0_f64; 8];
    for eight in points.chunks(8) {
        for (most, point) in most.iter_mut().zip(eight) {
            let squared = norm([point.x, point.y]);
            *most = if squared > *most { squared } else { *most };
        }
    }
    most.into_iter().fold(0.0, f64::max)
}

/// Points that are computed before any is judged: loops without branches over numbers of one kind, which compilers turn into
/// vector instructions.
const BLOCK: usize = 64;

/// Numbers of as many points.
type Block<V> = [V; BLOCK];

#[inline(always)]
fn blocks<const N: usize, const D: usize, const T: u8, const S: u8>(
    lens: &Planar<N, D, T, S>,
    start: &Start,
    points: &mut [Point2<f64>],
) -> UndistortedMany {
    let mut report = UndistortedMany::NONE;
    // A copy that nothing else can change: its numbers are read, and rounded to `f32`, once and not in every loop.
    let lens = &{ *lens };
    let mut stages = Stages::EMPTY;
    for block in points.chunks_mut(BLOCK) {
        for (i, point) in block.iter().enumerate() {
            [stages.target[0][i], stages.target[1][i]] = [point.x, point.y];
        }
        stages.start(lens, start);
        stages.slopes(lens);
        stages.step(lens);
        stages.step(lens);
        stages.judge(lens);
        let mut worst = largest(&stages.square[..block.len()]);
        for again in 0..2 {
            if worst < f64::INFINITY {
                break;
            }
            let (point, square) = (stages.point, stages.square);
            if again > 0 {
                stages.round();
                stages.slopes(lens);
                stages.step(lens);
            }
            stages.step(lens);
            stages.judge(lens);
            stages.keep_good((&point, &square));
            worst = largest(&stages.square[..block.len()]);
        }
        let found = block.iter_mut().zip(stages.point[0].iter().zip(&stages.point[1]));
        if worst < f64::INFINITY {
            for (point, (x, y)) in found {
                *point = Point2::new(*x, *y);
            }
            report.converged += block.len();
            report.largest_residual = report.largest_residual.max(float::sqrt(worst));
            continue;
        }
        for ((point, (x, y)), square) in found.zip(&stages.square) {
            if *square < f64::INFINITY {
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

/// Points of a block on their way. Each stage is a short loop of its own: of a long one, whose every step waits for the one
/// before, a processor's window holds too few points to fill the wait. What the steps make exact, their start and their
/// Jacobian, is computed in `f32`: a register holds twice as many.
struct Stages {
    target: [Block<f64>; 2],
    point: [Block<f64>; 2],
    /// The squared residual; infinite where it is not at its floor or the point is not in the disc.
    square: Block<f64>,
    rough_target: [Block<f32>; 2],
    rough_point: [Block<f32>; 2],
    /// The inverse of the Jacobian over D, by rows.
    inverse: [Block<f32>; 4],
}

impl Stages {
    const EMPTY: Self = Self {
        target: [[0.0; BLOCK]; 2],
        point: [[0.0; BLOCK]; 2],
        square: [0.0; BLOCK],
        rough_target: [[0.0; BLOCK]; 2],
        rough_point: [[0.0; BLOCK]; 2],
        inverse: [[0.0; BLOCK]; 4],
    };

    #[inline(always)]
    fn start<const N: usize, const D: usize, const T: u8, const S: u8>(
        &mut self,
        lens: &Planar<N, D, T, S>,
        start: &Start,
    ) {
        for (rough, target) in self.rough_target.iter_mut().zip(&self.target) {
            for i in 0..BLOCK {
                rough[i] = target[i] as f32;
            }
        }
        if T > 0 || S > 0 {
            for i in 0..BLOCK {
                let target = [self.rough_target[0][i], self.rough_target[1][i]];
                // The radial start throws the point off by what the other terms add there.
                let rough = start.rough.at(norm(target));
                let [x, y] = lens.beside_radial(target.map(|c| c * rough));
                [self.rough_target[0][i], self.rough_target[1][i]] = [target[0] - x, target[1] - y];
            }
        }
        for i in 0..BLOCK {
            let radial = [self.rough_target[0][i], self.rough_target[1][i]];
            let ratio = start.ratio.at(norm(radial));
            [self.rough_point[0][i], self.rough_point[1][i]] = radial.map(|c| c * ratio);
        }
        for (point, rough) in self.point.iter_mut().zip(&self.rough_point) {
            for i in 0..BLOCK {
                point[i] = f64::from(rough[i]);
            }
        }
    }

    /// The points in `f32`.
    #[inline(always)]
    fn round(&mut self) {
        for (rough, point) in self.rough_point.iter_mut().zip(&self.point) {
            for i in 0..BLOCK {
                rough[i] = point[i] as f32;
            }
        }
    }

    /// The Jacobian at the points.
    #[inline(always)]
    fn slopes<const N: usize, const D: usize, const T: u8, const S: u8>(
        &mut self,
        lens: &Planar<N, D, T, S>,
    ) {
        for i in 0..BLOCK {
            let point = [self.rough_point[0][i], self.rough_point[1][i]];
            let [a, b, c, d] = lens.jacobian_numerator(point);
            // Of a rational lens all is multiplied by its denominator, that of this point in the steps from here.
            let scale = lens.below(point) / (a * d - b * c);
            let inverse = [d * scale, -b * scale, -c * scale, a * scale];
            for (place, entry) in self.inverse.iter_mut().zip(inverse) {
                place[i] = entry;
            }
        }
    }

    /// A Newton step with the Jacobian of the last [`slopes`](Self::slopes).
    #[inline(always)]
    fn step<const N: usize, const D: usize, const T: u8, const S: u8>(
        &mut self,
        lens: &Planar<N, D, T, S>,
    ) {
        for i in 0..BLOCK {
            let point = [self.point[0][i], self.point[1][i]];
            let ([x, y], _) = lens.miss(point, [self.target[0][i], self.target[1][i]]);
            let [a, b] = [self.inverse[0][i], self.inverse[1][i]].map(f64::from);
            let [c, d] = [self.inverse[2][i], self.inverse[3][i]].map(f64::from);
            self.point[0][i] = point[0] - (a * x + b * y);
            self.point[1][i] = point[1] - (c * x + d * y);
        }
    }

    /// The squared residuals.
    #[inline(always)]
    fn judge<const N: usize, const D: usize, const T: u8, const S: u8>(
        &mut self,
        lens: &Planar<N, D, T, S>,
    ) {
        let fold_squared = lens.fold_radius() * lens.fold_radius();
        for i in 0..BLOCK {
            let target = [self.target[0][i], self.target[1][i]];
            let point = [self.point[0][i], self.point[1][i]];
            let (miss, below) = lens.miss(point, target);
            let square = norm(miss) / (below * below);
            // A point outside the disc is no answer, and NaN fails every comparison.
            let good = (square <= FLOOR * FLOOR * norm(target)) & (norm(point) < fold_squared);
            self.square[i] = if good { square } else { f64::INFINITY };
        }
    }

    /// Takes the points that were good before.
    #[inline(always)]
    fn keep_good(&mut self, before: (&[Block<f64>; 2], &Block<f64>)) {
        for i in 0..BLOCK {
            if before.1[i] < f64::INFINITY {
                self.square[i] = before.1[i];
                [self.point[0][i], self.point[1][i]] = [before.0[0][i], before.0[1][i]];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn spread<const N: usize, const D: usize, const T: u8, const S: u8>(
        lens: &Planar<N, D, T, S>,
    ) -> Stages {
        let mut stages = Stages::EMPTY;
        for i in 0..BLOCK {
            let ideal = Point2::new(0.5 * (i % 8) as f64 / 7.0, 0.4 * (i / 8) as f64 / 7.0);
            let thrown = lens.value(&ideal);
            [stages.target[0][i], stages.target[1][i]] = [thrown.x, thrown.y];
        }
        stages
    }

    fn residual<const N: usize, const D: usize, const T: u8, const S: u8>(
        lens: &Planar<N, D, T, S>,
        stages: &Stages,
        i: usize,
    ) -> f64 {
        let point = lens.value(&Point2::new(stages.point[0][i], stages.point[1][i]));
        (point - Point2::new(stages.target[0][i], stages.target[1][i])).norm()
    }

    fn two_steps_suffice<const N: usize, const D: usize, const T: u8, const S: u8>(
        lens: &Planar<N, D, T, S>,
    ) {
        let mut stages = spread(lens);
        let start = Start::new(lens, 0.5);
        stages.start(lens, &start);
        for i in 0..BLOCK {
            let off = residual(lens, &stages, i);
            assert!(off < 1e-4, "the start is {off} off");
        }
        stages.slopes(lens);
        stages.step(lens);
        stages.step(lens);
        stages.judge(lens);
        assert!(largest(&stages.square) < f64::INFINITY);
    }

    /// Whatever the stages do, the way of a single point mends it: only its time tells.
    #[test]
    fn common_lenses_are_inverted_by_a_start_and_two_steps() {
        let (zero, none) = ([0.0; 2], [0.0; 4]);
        let k = [-0.281, 0.0713, 0.0131];
        let p = [1.1e-3, -6.2e-4];
        two_steps_suffice(&Planar::<3, 0, 1, 0>::new(k, [], p, zero, none, 0.0).unwrap());
        let (d, s) = ([0.21, -0.1, 0.03], [8.3e-4, -4.1e-4, -7.7e-4, 2.9e-4]);
        two_steps_suffice(&Planar::<3, 3, 1, 2>::new(k, d, p, zero, s, 0.0).unwrap());
        let k = [-0.11, 0.04, -0.013, 0.002];
        two_steps_suffice(&Planar::<4, 0, 0, 0>::new(k, [], zero, zero, none, 0.0).unwrap());
        two_steps_suffice(&Planar::<4, 0, 2, 0>::new(k, [], p, [0.3, -0.1], none, 0.0).unwrap());
    }

    /// With D = 1 − 0.8 · 0.9 the residual is 3.6 times what the steps are computed with.
    #[test]
    fn the_residual_is_that_of_the_formula_and_not_of_its_numerator() {
        let lens =
            Planar::<1, 1, 0, 0>::new([-0.8], [-0.8], [0.0; 2], [0.0; 2], [0.0; 4], 0.0).unwrap();
        let mut stages = Stages::EMPTY;
        let r = 0.9f64.sqrt();
        stages.target = [[r; BLOCK], [0.0; BLOCK]];
        stages.point = [[r; BLOCK], [1.5e-15; BLOCK]];
        stages.judge(&lens);
        // N/D = 1, so that the residual is the 1.5e-15 by which the point is off.
        assert!((float::sqrt(stages.square[7]) - 1.5e-15).abs() < 3e-16, "{}", stages.square[7]);
        stages.point = [[r; BLOCK], [4e-15; BLOCK]];
        stages.judge(&lens);
        assert_eq!(stages.square[7], f64::INFINITY);
        let at_rest = Vector2::new(stages.point[0][0], stages.point[1][0]);
        assert!(at_rest.norm() < lens.fold_radius());
    }
}
