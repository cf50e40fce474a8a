//! Motions from five pairs of directions.

use collinear::Error;
use collinear::adjust::five_point;
use collinear::geometry::Pose;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use crate::support::{numbers, signed};

fn distance(a: &Pose, b: &Pose) -> f64 {
    (a.origin - b.origin).norm() + (a.rotation.matrix() - b.rotation.matrix()).norm()
}

/// The largest triple product of base and unit rays, and how far from one and orthonormal base and rotation are; infinite
/// where rays do not meet in front.
fn residual(pose: &Pose, first: &[Vector3<f64>; 5], second: &[Vector3<f64>; 5]) -> f64 {
    let r = pose.rotation.matrix();
    let mut worst = (r * r.transpose() - Matrix3::identity()).amax();
    worst = worst.max((pose.origin.coords.norm() - 1.0).abs());
    for (d, e) in first.iter().zip(second) {
        let (d, e) = (d.normalize(), r.transpose() * e.normalize());
        worst = worst.max(pose.origin.coords.dot(&d.cross(&e)).abs());
        // d λ = b + e μ by least squares.
        let a = nalgebra::Matrix3x2::from_columns(&[d, -e]);
        let Some(inverse) = (a.transpose() * a).try_inverse() else { return f64::INFINITY };
        let lengths = inverse * a.transpose() * pose.origin.coords;
        if !(lengths.x > 0.0 && lengths.y > 0.0) {
            return f64::INFINITY;
        }
    }
    worst
}

fn scene(next: &mut impl FnMut() -> f64) -> (Pose, [Vector3<f64>; 5], [Vector3<f64>; 5]) {
    let mut vector = || Vector3::new(next(), next(), next());
    let rotation = Rotation3::new(vector());
    let base = vector().normalize();
    let first = [0; 5].map(|_| vector() * 2.0 + Vector3::new(0.0, 0.0, 4.5));
    let second = first.map(|x| rotation * (x - base));
    (Pose::new(rotation, Point3::from(base)), first, second)
}

fn exact_scenes(count: u32, seed: u64) -> (u32, f64) {
    let mut next = signed(seed);
    let (mut missed, mut worst) = (0, 0.0f64);
    for _ in 0..count {
        let (truth, first, second) = scene(&mut next);
        let Ok(found) = five_point(&first, &second) else {
            missed += 1;
            continue;
        };
        let nearest = found.iter().map(|p| distance(p, &truth)).fold(f64::INFINITY, f64::min);
        missed += u32::from(!(nearest < 1e-5));
        worst = found.iter().map(|p| residual(p, &first, &second)).fold(worst, f64::max);
    }
    (missed, worst)
}

#[test]
fn no_motion_of_1000_exact_scenes_is_missed() {
    let (missed, worst) = exact_scenes(1000, 4);
    assert!(missed == 0 && worst < 1e-12, "{missed} {worst:e}");
}

#[test]
#[ignore = "seconds when optimised, minutes when not"]
fn no_motion_of_100_000_exact_scenes_is_missed() {
    let (missed, worst) = exact_scenes(100_000, 5);
    assert!(missed == 0 && worst < 1e-12, "{missed} {worst:e}");
}

#[test]
fn every_motion_found_in_40_digits_is_found_and_no_other() {
    let oracle: serde_json::Value =
        serde_json::from_str(include_str!("../data/oracles/five_point.json")).unwrap();
    let mut total = 0;
    for (number, case) in oracle["cases"].as_array().unwrap().iter().enumerate() {
        let five = |key: &str| -> [Vector3<f64>; 5] {
            let v = numbers(&case[key]);
            [0, 3, 6, 9, 12].map(|i| Vector3::new(v[i], v[i + 1], v[i + 2]))
        };
        let (first, second) = (five("first"), five("second"));
        let expected = case["poses"].as_array().unwrap();
        total += expected.len();
        for order in [[0, 1, 2, 3, 4], [4, 2, 0, 3, 1]] {
            let found = five_point(&order.map(|i| first[i] * 3.0), &order.map(|i| second[i] * 0.1))
                .unwrap();
            assert_eq!(found.len(), expected.len(), "{number}");
            for pose in expected {
                let rotation = Matrix3::from_row_slice(&numbers(&pose["rotation"]));
                let truth = Pose::new(
                    Rotation3::from_matrix_unchecked(rotation),
                    Point3::from_slice(&numbers(&pose["base"])),
                );
                let nearest =
                    found.iter().map(|p| distance(p, &truth)).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9, "{number} {nearest:e}");
            }
            for pose in found {
                assert!(residual(&pose, &first, &second) < 1e-12, "{number}");
            }
        }
    }
    assert!(total > 40, "{total}");
}

#[test]
fn what_determines_no_motion_is_refused() {
    let (_, first, second) = scene(&mut signed(1));
    let degenerate = |f: [usize; 5]| match five_point(&f.map(|i| first[i]), &f.map(|i| second[i])) {
        Err(Error::Degenerate { measure, limit, .. }) => assert!(measure <= limit),
        other => panic!("{other:?}"),
    };
    degenerate([0, 1, 2, 3, 3]);
    degenerate([2; 5]);
    // Without a base every base fits.
    let turn = Rotation3::new(Vector3::new(0.1, -0.2, 0.3));
    match five_point(&first, &first.map(|d| turn * d)) {
        Err(Error::Degenerate { .. }) => {}
        Ok(found) => assert!(found.is_empty(), "{found:?}"),
        Err(other) => panic!("{other}"),
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let mut f = first;
        f[2].x = bad;
        let error = Error::NotFinite { what: "direction" };
        assert_eq!(five_point(&f, &second).unwrap_err(), error);
        assert_eq!(five_point(&second, &f).unwrap_err(), error);
    }
    let mut f = first;
    f[4] = Vector3::zeros();
    assert!(matches!(five_point(&f, &second), Err(Error::Degenerate { measure: 0.0, .. })));
}
