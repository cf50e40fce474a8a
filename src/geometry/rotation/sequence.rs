//! Three turns about coordinate axes, one after the other: the formula behind every triple of angles.

use core::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::numeric::float;
use crate::numeric::scalar::Scalar;

/// Below this cosine of the second angle the first and the third turn about one axis, and only their sum is known.
const LOCK: f64 = f64::EPSILON;

/// The three axes of a sequence, 0 = x, 1 = y, 2 = z, in the order in which they turn.
pub(super) type Axes = [usize; 3];

/// `M = R_c(θ₃) R_b(θ₂) R_a(θ₁)`, each R a turn of the axes: R₁(θ) = (1 0 0; 0 cos sin; 0 −sin cos) and cyclic.
/// The turns come as (sine, cosine).
pub(super) fn matrix<S: Scalar>(axes: Axes, turns: [(S, S); 3]) -> [[S; 3]; 3] {
    let unit = |i, j| S::constant(if i == j { 1.0 } else { 0.0 });
    let mut m = core::array::from_fn(|i| core::array::from_fn(|j| unit(i, j)));
    for (axis, (sine, cosine)) in axes.into_iter().zip(turns) {
        let (j, l): (usize, usize) = ((axis + 1) % 3, (axis + 2) % 3);
        let (a, b): ([S; 3], [S; 3]) = (m[j], m[l]);
        m[j] = core::array::from_fn(|k| cosine * a[k] + sine * b[k]);
        m[l] = core::array::from_fn(|k| cosine * b[k] - sine * a[k]);
    }
    m
}

pub(super) fn to_matrix3(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// The columns δθ/δθ₁, δθ/δθ₂, δθ/δθ₃ of δM = \[δθ\]× M. A turn of the axes by θ is exp(−[θ e]×), hence the signs.
pub(super) fn left(axes: Axes, turns: [(f64, f64); 3]) -> Matrix3<f64> {
    let still = (0.0, 1.0);
    let [_, second, third] = turns;
    let after_first = to_matrix3(matrix(axes, [still, second, third]));
    let after_second = to_matrix3(matrix(axes, [still, still, third]));
    let unit = |axis: usize| Vector3::ith(axis, 1.0);
    let [a, b, c] = axes;
    -Matrix3::from_columns(&[after_first * unit(a), after_second * unit(b), unit(c)])
}

/// The angles of `M = R_c(θ₃) R_b(θ₂) R_a(θ₁)` for three different axes, θ₂ in [−π/2, π/2].
///
/// θ₃ is read from M with the first turn undone, not from M itself: near gimbal lock θ₁ is known badly, and θ₃ then
/// makes good what θ₁ got wrong. In lock θ₁ is zero. NaN where an element is NaN or infinite.
pub(super) fn angles([a, b, c]: Axes, m: &Matrix3<f64>) -> [f64; 3] {
    if !m.iter().all(|e| e.is_finite()) {
        return [f64::NAN; 3];
    }
    let sign = if b == (a + 1) % 3 { 1.0 } else { -1.0 };
    let cosine = float::hypot(m[(c, b)], m[(c, c)]);
    let second = atan2(sign * m[(c, a)], cosine);
    let first = if cosine > LOCK { atan2(-sign * m[(c, b)], m[(c, c)]) } else { 0.0 };
    let (s, k) = float::sin_cos(first);
    let undone = |i| k * m[(i, b)] + sign * s * m[(i, c)];
    [first, second, atan2(sign * undone(a), undone(b))]
}

/// Azimuth, tilt and swing of M = R₃(s − π) R₁(t) R₃(−α), t in [0, π], by the same rules: s from M with the azimuth
/// undone, α zero where the tilt is.
pub(super) fn angles_azimuth_tilt_swing(m: &Matrix3<f64>) -> [f64; 3] {
    if !m.iter().all(|e| e.is_finite()) {
        return [f64::NAN; 3];
    }
    let sine = float::hypot(m[(2, 0)], m[(2, 1)]);
    let tilt = float::atan2(sine, m[(2, 2)]);
    let azimuth = if sine > LOCK { atan2(-m[(2, 0)], -m[(2, 1)]) } else { 0.0 };
    let (s, k) = float::sin_cos(azimuth);
    let undone = |i| k * m[(i, 0)] - s * m[(i, 1)];
    [azimuth, tilt, atan2(undone(1), -undone(0))]
}

/// −θ for θ in (−π, π], in the same interval.
pub(super) fn opposite(angle: f64) -> f64 {
    if angle == PI { PI } else { 0.0 - angle }
}

/// The angle of (x, y) in (−π, π]; −π, from a sine of −0 or by rounding, becomes π.
fn atan2(y: f64, x: f64) -> f64 {
    let angle = float::atan2(y, x);
    if angle == -PI { PI } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::scalar::Dual;

    /// δM = \[δθ\]× M column by column, against the dual numbers of `matrix`.
    fn check(axes: Axes, values: [f64; 3]) {
        let turns = values.map(float::sin_cos);
        let m = to_matrix3(matrix(axes, turns));
        let left = left(axes, turns);
        let dual =
            matrix(axes, [0, 1, 2].map(|i| Dual::<3>::variable(values[i], i)).map(Scalar::sin_cos));
        for k in 0..3 {
            let column: Vector3<f64> = left.column(k).into_owned();
            let expected = column.cross_matrix() * m;
            for i in 0..3 {
                for j in 0..3 {
                    assert!((dual[i][j].gradient[k] - expected[(i, j)]).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn left_rotation_vectors_are_the_derivatives() {
        for axes in [[0, 1, 2], [1, 0, 2], [2, 1, 0], [2, 0, 2]] {
            check(axes, [0.3, -0.7, 2.5]);
            check(axes, [-2.9, 1.2, 0.4]);
        }
    }
}
