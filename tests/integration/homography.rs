//! Homographies: the laws, the numbers of other programs, and what is refused.

use collinear::geometry::Homography;
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix3, Point2};
use num_rational::BigRational;
use proptest::prelude::*;

type Quad = [Point2<f64>; 4];

const UNIT: Quad =
    [Point2::new(0.0, 0.0), Point2::new(1.0, 0.0), Point2::new(1.0, 1.0), Point2::new(0.0, 1.0)];

fn quad(c: [(f64, f64); 4]) -> Quad {
    c.map(|(x, y)| Point2::new(x, y))
}

/// The componentwise backward error of a map at its corners, in units of ε, by exact rational arithmetic.
fn backward_error(h: &Homography, source: &Quad, target: &Quad) -> f64 {
    let exact = |v: f64| BigRational::from_float(v).unwrap();
    let magnitude = |v: &BigRational| if *v < exact(0.0) { -v.clone() } else { v.clone() };
    let m = h.matrix().map(exact);
    let mut worst = 0.0f64;
    for (s, t) in source.iter().zip(target) {
        let s = [exact(s.x), exact(s.y), exact(1.0)];
        let row = |i: usize| -> (BigRational, BigRational) {
            let terms: Vec<_> = (0..3).map(|j| &m[(i, j)] * &s[j]).collect();
            (
                terms.iter().fold(exact(0.0), |a, b| a + b),
                terms.iter().fold(exact(0.0), |a, b| a + magnitude(b)),
            )
        };
        let (w, w_sum) = row(2);
        for (i, t) in [(0, t.x), (1, t.y)] {
            let (u, u_sum) = row(i);
            let residual = magnitude(&(u - exact(t) * &w));
            let size = u_sum + magnitude(&exact(t)) * &w_sum;
            if residual > exact(0.0) {
                let ratio = residual / size / exact(f64::EPSILON);
                worst = worst.max(num_to_f64(&ratio));
            }
        }
    }
    worst
}

fn num_to_f64(r: &BigRational) -> f64 {
    // Rounded up to 2⁻²⁰, which is enough to compare with 16.
    let scaled = (r * BigRational::from_float(1_048_576.0).unwrap()).ceil().to_integer();
    scaled.to_string().parse::<f64>().unwrap() / 1_048_576.0
}

/// A convex quad of extent about one: a square with moved corners, one of which may come near the diagonal beside it.
fn shaped() -> impl Strategy<Value = Quad> {
    let moves = proptest::array::uniform8(-0.3..0.3f64);
    (moves, prop::option::of((0usize..4, 0.0..1.0f64, -14.0..-1.0f64)), any::<bool>()).prop_map(
        |(m, flat, mirrored)| {
            let mut q = UNIT;
            for (i, p) in q.iter_mut().enumerate() {
                p.x += m[2 * i];
                p.y += m[2 * i + 1];
            }
            if let Some((i, t, exponent)) = flat {
                let (before, after) = (q[(i + 3) % 4], q[(i + 1) % 4]);
                let along = before + (after - before) * t;
                q[i] = along + (q[i] - along) * 10f64.powf(exponent);
            }
            if mirrored {
                q.swap(1, 3);
            }
            q
        },
    )
}

/// Quads that lie and measure anything: turned, stretched to 1 : 1e6, moved by 1e6 extents, of sizes 1e-150 to 1e150.
fn hard() -> impl Strategy<Value = Quad> {
    let offset = || prop_oneof![Just(0.0), -2.0..2.0f64, -1e6..1e6f64];
    let size = || prop_oneof![Just(0.0), -3.0..3.0f64, -150.0..150.0f64];
    (shaped(), -6.0..6.0f64, any::<bool>(), 0.0..6.3f64, offset(), offset(), size()).prop_map(
        |(q, aspect, stretched, angle, x, y, size)| {
            let (sin, cos) = angle.sin_cos();
            let scale = 10f64.powf(size);
            q.map(|p| {
                let (a, b) = (p.x, if stretched { p.y * 10f64.powf(aspect) } else { p.y });
                Point2::new((cos * a - sin * b + x) * scale, (sin * a + cos * b + y) * scale)
            })
        },
    )
}

#[test]
fn explore() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let (mut worst, mut worst2, mut worst3, mut ok, mut ok2, mut all) = (0.0f64, 0.0f64, 0.0f64, 0, 0, 0);
    let mut errs = std::collections::BTreeMap::new();
    for _ in 0..20000 {
        let a = hard().new_tree(&mut runner).unwrap().current();
        let b = hard().new_tree(&mut runner).unwrap().current();
        all += 1;
        match Homography::from_unit_square(&a) {
            Ok(h) => {
                ok += 1;
                worst = worst.max(backward_error(&h, &UNIT, &a));
            }
            Err(e) => *errs.entry(format!("S {e:?}")[..30].to_string()).or_insert(0) += 1,
        }
        match Homography::from_quads(&a, &b) {
            Ok(h) => {
                ok2 += 1;
                worst2 = worst2.max(backward_error(&h, &a, &b));
            }
            Err(e) => {
                let s = format!("Q {e:?}");
                if s.contains("infinity") { println!("{a:?} {b:?} {e:?}"); }
                *errs.entry(s[..30.min(s.len())].to_string()).or_insert(0) += 1
            }
        }
        if let Ok(h) = Homography::to_unit_square(&a) {
            worst3 = worst3.max(backward_error(&h, &a, &UNIT));
        }
    }
    println!("{worst} {worst2} {worst3} {ok} {ok2} {all} {errs:#?}");
}
