//! Inversion of a polynomial map by damped Newton steps.

use nalgebra::{Point2, Vector2};

use super::{EXPONENTS, Polynomial, powers};
use crate::error::ProjectionError;

/// An object point found by iteration, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inversion {
    /// The object point.
    pub point: Point2<f64>,
    /// Newton steps taken.
    pub iterations: u32,
    /// How far the point's image is from the one asked for, in image units.
    pub residual: f64,
}

const MAX_ITERATIONS: u32 = 60;
/// Halvings of one step before it counts as leading nowhere.
const MAX_HALVINGS: u32 = 30;

impl<const N: usize> Polynomial<N> {
    /// What rounding leaves of the residual at a point of the frame.
    fn rounding(&self, x: f64, y: f64, target: &Vector2<f64>) -> f64 {
        let (px, py) = (powers(x.abs()), powers(y.abs()));
        let mut sum = target.x.abs() + target.y.abs() + self.offset[0].abs() + self.offset[1].abs();
        for k in 0..N {
            let (i, j) = EXPONENTS[k];
            sum += (self.a[k].abs() + self.b[k].abs()) * px[i] * py[j];
        }
        4.0 * f64::EPSILON * sum
    }

    pub(super) fn inverse(
        &self,
        image: &Point2<f64>,
        start: Option<&Point2<f64>>,
    ) -> Result<Inversion, ProjectionError> {
        let target = Vector2::new(image.x - self.offset[0], image.y - self.offset[1]);
        let start = start.map_or(self.domain.centre, |p| [p.x, p.y]);
        let [mut x, mut y] = self.frame.normalise(start);
        if ![target.x, target.y, x, y].iter().all(|c| c.is_finite()) {
            return Err(ProjectionError::NotFinite);
        }
        let miss = |x: f64, y: f64| {
            let [u, v] = self.value(x, y);
            Vector2::new(u - target.x, v - target.y)
        };
        let mut residual = miss(x, y);
        let mut iterations = 0;
        let failed = |iterations, residual: Vector2<f64>| {
            Err(ProjectionError::NotConverged { iterations, residual: residual.norm() })
        };
        loop {
            let length = residual.norm();
            let rounding = self.rounding(x, y, &target);
            let jacobian = self.frame_jacobian(x, y);
            let determinant = jacobian.determinant();
            let [a, b] = [jacobian.column(1), jacobian.column(0)];
            // Cramer's rule: J (dx, dy) = residual.
            let step = Vector2::new(
                (residual.x * a.y - a.x * residual.y) / determinant,
                (b.x * residual.y - residual.x * b.y) / determinant,
            );
            let stepped = step.x.is_finite() && step.y.is_finite() && iterations < MAX_ITERATIONS;
            let mut share = 1.0;
            let mut better = None;
            for _ in 0..if stepped { MAX_HALVINGS } else { 0 } {
                let (nx, ny) = (x - share * step.x, y - share * step.y);
                let next = miss(nx, ny);
                if next.norm() < length {
                    better = Some((nx, ny, next));
                    break;
                }
                if length <= rounding {
                    break;
                }
                share *= 0.5;
            }
            match better {
                Some((nx, ny, next)) => {
                    (x, y, residual) = (nx, ny, next);
                    iterations += 1;
                }
                // No step makes it smaller: at the floor of rounding, or stuck.
                None if length <= rounding => {
                    let point = Point2::new(
                        self.frame.centre[0] + self.frame.half[0] * x,
                        self.frame.centre[1] + self.frame.half[1] * y,
                    );
                    return Ok(Inversion { point, iterations, residual: length });
                }
                None => return failed(iterations, residual),
            }
        }
    }
}
