//! Poses and principal distances from four points.

use collinear::Error;
use collinear::adjust::p4pf;
use nalgebra::{Matrix3, Point2, Point3, Vector3};

use crate::support::{numbers, signed};

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/oracles/p4pf.json")).unwrap()
}

fn object(case: &serde_json::Value) -> [Point3<f64>; 4] {
    let v = numbers(&case["object"]);
    [0, 3, 6, 9].map(|i| Point3::from_slice(&v[i..i + 3]))
}

fn image(case: &serde_json::Value) -> [Point2<f64>; 4] {
    let v = numbers(&case["image"]);
    [0, 2, 4, 6].map(|i| Point2::from_slice(&v[i..i + 2]))
}

#[test]
fn cameras_made_and_found_elsewhere_are_found() {
    for (number, case) in oracle()["cases"].as_array().unwrap().iter().enumerate() {
        let (x, t) = (object(case), image(case));
        let principal = Point2::from_slice(&numbers(&case["principal_point"]));
        let f = case["f"].as_f64().unwrap();
        let residual = case["residual"].as_f64().unwrap();
        let rotation = Matrix3::from_row_slice(&numbers(&case["rotation"]));
        let center = Point3::from_slice(&numbers(&case["center"]));
        let range = (center - x[0]).norm();
        for order in [[0, 1, 2, 3], [3, 1, 0, 2]] {
            let found = p4pf(&order.map(|i| x[i]), &order.map(|i| t[i]), &principal).unwrap();
            let root = found[0];
            // Four points are a weak figure: rounding of an image coordinate by 10⁻¹³ shows in f.
            let limit = if residual == 0.0 { 1e-8 } else { 1e-5 };
            assert!((root.principal_distance / f - 1.0).abs() < limit, "{number} {root:?} {f}");
            assert!((root.pose.rotation.matrix() - rotation).norm() < limit, "{number}");
            assert!((root.pose.origin - center).norm() < limit * range, "{number}");
            assert!(
                (root.residual - residual).abs() < 1e-7,
                "{number} {} {residual}",
                root.residual
            );
            assert!(found.windows(2).all(|w| w[0].residual <= w[1].residual));
            for root in &found {
                // The residual is that of the pose, and no small change of f lessens it with the pose held.
                let rms = |f: f64| {
                    let squares: f64 = x
                        .iter()
                        .zip(&t)
                        .map(|(x, t)| {
                            let d = root.pose.rotation * (x - root.pose.origin);
                            assert!(d.z > 0.0);
                            (d.xy() * (f / d.z) + principal.coords - t.coords).norm_squared()
                        })
                        .sum();
                    (squares / 8.0).sqrt()
                };
                let here = rms(root.principal_distance);
                assert!((here - root.residual).abs() < 1e-6, "{number} {here}");
                assert!(rms(root.principal_distance * 1.001) >= here - 1e-9);
                assert!(rms(root.principal_distance * 0.999) >= here - 1e-9);
            }
        }
    }
}

/// How many of so many exact scenes are missed: no root with the true f.
fn missed(count: u32, seed: u64) -> u32 {
    let mut next = signed(seed);
    let mut missed = 0;
    for _ in 0..count {
        let f = 1500.0 * (1.5 * next()).exp();
        let depth = 2.0 + f / 800.0;
        let turn = nalgebra::Rotation3::new(Vector3::new(next(), next(), next()) * 3.0);
        let center = Point3::new(next(), next(), next()) * 5.0;
        let seen = [0; 4].map(|_| Vector3::new(next(), next(), depth + next()));
        let object = seen.map(|s| center + turn.inverse() * s);
        let image = seen.map(|s| Point2::new(f * s.x / s.z, f * s.y / s.z));
        let right = p4pf(&object, &image, &Point2::origin()).is_ok_and(|found| {
            found.iter().any(|r| {
                (r.principal_distance / f - 1.0).abs() < 1e-3
                    && (r.pose.origin - center).norm() < 1e-3 * depth
            })
        });
        missed += u32::from(!right);
    }
    missed
}

#[test]
fn no_camera_of_300_exact_scenes_is_missed() {
    assert_eq!(missed(300, 1), 0);
}

#[test]
#[ignore = "seconds when optimised, minutes when not"]
fn few_cameras_of_20_000_exact_scenes_are_missed() {
    // One, whose image points lie nearly on a line.
    assert!(missed(20_000, 2) <= 2);
}

#[test]
fn what_leaves_the_camera_open_is_refused() {
    let case = &oracle()["cases"][0];
    let (x, t) = (object(case), image(case));
    let middle = Point2::new(960.0, 540.0);
    let degenerate =
        |x: &[Point3<f64>; 4], t: &[Point2<f64>; 4], words: &str| match p4pf(x, t, &middle) {
            Err(Error::Degenerate { what, measure, limit }) => {
                assert!(what.contains(words) && measure <= limit, "{what} {measure} {limit}");
            }
            other => panic!("{words} {other:?}"),
        };
    let line = [0.0, 1.0, 2.5, 4.0].map(|k| x[0] + (x[1] - x[0]) * k);
    degenerate(&line, &t, "object points on a line");
    degenerate(&[x[0]; 4], &t, "object points on a line");
    let row = [0.0, 1.0, 2.5, 4.0].map(|k| t[0] + (t[1] - t[0]) * k);
    degenerate(&x, &row, "image points on a line");
    degenerate(&x, &[t[0]; 4], "image points on a line");
    // A square seen squarely: a longer lens from farther away sees the same.
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let flat = square.map(|(x, y)| Point3::new(x, y, 0.0));
    let seen = square.map(|(x, y)| Point2::new(960.0 + 100.0 * x, 540.0 + 100.0 * y));
    degenerate(&flat, &seen, "open");
    for bad in [f64::NAN, f64::INFINITY] {
        let mut p = x;
        p[2].x = bad;
        assert_eq!(p4pf(&p, &t, &middle).unwrap_err(), Error::NotFinite { what: "object point" });
        let mut q = t;
        q[3].y = bad;
        assert_eq!(p4pf(&x, &q, &middle).unwrap_err(), Error::NotFinite { what: "image point" });
        let off = Point2::new(bad, 0.0);
        assert_eq!(p4pf(&x, &t, &off).unwrap_err(), Error::NotFinite { what: "image point" });
    }
}
