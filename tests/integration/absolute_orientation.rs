//! Similarities from points.

use collinear::Error;
use collinear::adjust::{
    AbsoluteOrientation, AbsoluteOrientationOptions, PointPair, Precision, absolute_orientation,
};
use collinear::geometry::{Pose, Similarity};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use crate::support::{numbers, points3};

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/oracles/absolute_orientation.json")).unwrap()
}

fn pairs(case: &serde_json::Value) -> Vec<PointPair> {
    let precision = |i: usize| match case["sigmas"].as_array() {
        Some(s) => {
            let s = numbers(&s[i]);
            if s[0] == s[1] && s[1] == s[2] {
                Precision::Sigma(s[0])
            } else {
                Precision::Sigmas([s[0], s[1], s[2]])
            }
        }
        None => Precision::Covariance(Matrix3::from_row_slice(&numbers(&case["covariances"][i]))),
    };
    let ends = points3(&case["from"]).into_iter().zip(points3(&case["to"]));
    ends.enumerate().map(|(i, (f, t))| PointPair::new(f, t).with_precision(precision(i))).collect()
}

fn solve(case: &serde_json::Value) -> AbsoluteOrientation {
    let options = AbsoluteOrientationOptions { scale: case["held"].as_f64(), ..Default::default() };
    absolute_orientation(&pairs(case), &options).unwrap()
}

#[test]
fn minima_are_those_of_an_iteration_in_40_digits() {
    for case in oracle()["cases"].as_array().unwrap() {
        let (name, expected) = (case["name"].as_str().unwrap(), &case["solution"]);
        let found = solve(case);
        let map = &found.similarity;
        let scale = expected["scale"].as_f64().unwrap();
        assert!((map.scale() / scale - 1.0).abs() < 1e-12, "{name} {}", map.scale());
        let rotation = Matrix3::from_row_slice(&numbers(&expected["rotation"]));
        let turn = (map.rotation().matrix() - rotation).norm();
        assert!(turn < 2e-11, "{name} {turn:e}");
        let center = map.apply(&points3(&expected["center"])[0]);
        let to = points3(&expected["to"])[0];
        assert!((center - to).norm() < 1e-9, "{name} {center}");
        let vpv = expected["vpv"].as_f64().unwrap();
        let slack = if name.starts_with("mirrored") { 1e-6 } else { 1e-9 };
        assert!((found.report.weighted_sum / vpv - 1.0).abs() < slack, "{name}");
        assert!(found.report.convergence.converged);
        for extra in case["extra"].as_array().unwrap() {
            let [from, image] = [0, 1].map(|i| points3(&extra[i])[0]);
            assert!((map.apply(&from) - image).norm() < 1e-9, "{name}");
            assert!((map.apply_inverse(&image) - from).norm() < 1e-9, "{name}");
        }
        // The origin is far from the points; its place shows the turn's last digits.
        let origin = points3(&expected["origin"])[0];
        assert!((map.translation() - origin.coords).norm() < 1e-7, "{name}");
    }
}

#[test]
fn reports_are_those_of_the_same_jacobian() {
    for case in oracle()["cases"].as_array().unwrap() {
        let (name, expected) = (case["name"].as_str().unwrap(), &case["solution"]);
        let (found, pairs) = (solve(case), pairs(case));
        let (report, map) = (&found.report, &found.similarity);
        let held = case["held"].as_f64().is_some();
        assert_eq!(
            (report.observations, report.unknowns),
            (3 * pairs.len(), 7 - usize::from(held))
        );
        assert_eq!(report.redundancy, report.observations - report.unknowns);
        let sigma0 = expected["sigma0"].as_f64().unwrap();
        let slack = if name.starts_with("mirrored") { 1e-6 } else { 1e-9 };
        assert!((report.sigma0.unwrap() / sigma0 - 1.0).abs() < slack, "{name}");
        if let Some(cofactor) = expected["scale_cofactor"].as_f64() {
            let deviation = sigma0 * cofactor.sqrt();
            assert!((report.standard_deviation(0) / deviation - 1.0).abs() < slack, "{name}");
        }
        let cofactor = Matrix3::from_row_slice(&numbers(&expected["center_cofactor"]));
        let center = points3(&expected["center"])[0];
        let there = found.covariance_at(&center) / (sigma0 * sigma0);
        assert!((there - cofactor).norm() < 2.0 * slack * cofactor.norm(), "{name} {there}");
        let sum = report.redundancy_sum();
        assert!((sum - report.redundancy as f64).abs() < 1e-9, "{name} {sum}");
        for (pair, values) in pairs.iter().zip(report.values.chunks(3)) {
            let v = pair.to - map.apply(&pair.from);
            assert!((0..3).all(|i| values[i].residual == v[i]), "{name}");
        }
    }
}

#[test]
fn believed_precisions_scale_nothing() {
    let case = &oracle()["cases"][3];
    let options = AbsoluteOrientationOptions { estimate_sigma: false, ..Default::default() };
    let found = absolute_orientation(&pairs(case), &options).unwrap();
    let cofactor = case["solution"]["scale_cofactor"].as_f64().unwrap();
    assert!((found.report.covariance[(0, 0)] / cofactor - 1.0).abs() < 1e-9);
    assert_eq!(found.report.sigma, 1.0);
}

#[test]
fn exact_points_give_the_exact_map_wherever_they_lie() {
    let rotation = Rotation3::new(Vector3::new(1.0, -2.0, 0.5));
    for (scale, from, to) in [
        (1.0, Point3::origin(), Point3::origin()),
        (2000.0, Point3::new(0.1, 0.2, 0.3), Point3::new(3.5e6, 5.8e6, 400.0)),
        (1e-3, Point3::new(3.5e6, 5.8e6, 400.0), Point3::origin()),
    ] {
        let truth = Similarity::new(scale, rotation, from, to).unwrap();
        // Three points, the fewest; and a plane, whose mirror image fits as well but is no rotation.
        for offsets in [
            vec![(1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.5, -0.3, 0.2)],
            vec![(1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (-1.0, -1.0, 0.0), (3.0, 1.0, 0.0)],
        ] {
            let size = if scale == 1e-3 { 300.0 } else { 1.0 };
            let pairs: Vec<_> = offsets
                .into_iter()
                .map(|(x, y, z)| {
                    let place = from + Vector3::new(x, y, z) * size;
                    PointPair::new(place, truth.apply(&place))
                })
                .collect();
            let found =
                absolute_orientation(&pairs, &AbsoluteOrientationOptions::default()).unwrap();
            // What rounding of the ground's coordinates lets through.
            let rounding = 1e-15
                + f64::EPSILON * (to.coords.amax() / (scale * size) + from.coords.amax() / size);
            let turn = (found.similarity.rotation().matrix() - rotation.matrix()).norm();
            assert!(turn < 8.0 * rounding, "{turn:e} {rounding:e}");
            assert!((found.similarity.scale() / scale - 1.0).abs() < 8.0 * rounding);
            let shift = (found.similarity.apply(&from) - to).norm();
            assert!(shift < 16.0 * rounding * scale * size, "{shift:e}");
        }
    }
}

#[test]
fn a_similarity_and_its_inverse() {
    let quarter = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    let map =
        Similarity::new(2.0, quarter, Point3::new(1.0, 2.0, 3.0), Point3::new(10.0, 20.0, 30.0))
            .unwrap();
    // (2, 2, 3) is one to the east of A; two to the north of B.
    let p = map.apply(&Point3::new(2.0, 2.0, 3.0));
    assert!((p - Point3::new(10.0, 22.0, 30.0)).norm() < 1e-14);
    assert!((map.apply_inverse(&p) - Point3::new(2.0, 2.0, 3.0)).norm() < 1e-14);
    assert!((map.inverse().apply(&p) - Point3::new(2.0, 2.0, 3.0)).norm() < 1e-14);
    // The origin is (−1, −2, −3) from A: (4, −2, −6) from B.
    assert!((map.translation() - Vector3::new(14.0, 18.0, 24.0)).norm() < 1e-14);
    let h = map.to_matrix() * nalgebra::Vector4::new(2.0, 2.0, 3.0, 1.0);
    assert!((h.xyz() - p.coords).norm() < 1e-14 && h.w == 1.0);
    // A camera keeps its view.
    let camera = Pose::new(Rotation3::new(Vector3::new(0.3, 0.2, 0.1)), Point3::new(5.0, 6.0, 7.0));
    let x = Point3::new(-3.0, 2.0, 9.0);
    let (before, after) = (camera.apply(&x), map.apply_to_pose(&camera).apply(&map.apply(&x)));
    assert!((after - before * 2.0).norm() < 1e-13);
    for bad in [0.0, -1.0] {
        let error = Similarity::new(bad, quarter, Point3::origin(), Point3::origin()).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { value, .. } if value == bad));
    }
    let nan = Point3::new(f64::NAN, 0.0, 0.0);
    assert!(matches!(
        Similarity::new(1.0, quarter, nan, Point3::origin()),
        Err(Error::NotFinite { .. })
    ));
}

#[test]
fn bad_input_is_refused() {
    let good = pairs(&oracle()["cases"][0]);
    let options = AbsoluteOrientationOptions::default();
    let solve = |pairs: &[PointPair]| absolute_orientation(pairs, &options).unwrap_err();
    assert_eq!(solve(&good[..2]), Error::TooFewPoints { needed: 3, got: 2 });
    let mut bad = good.clone();
    bad[1].to.z = f64::INFINITY;
    assert_eq!(solve(&bad), Error::NotFinite { what: "point pair" });
    for precision in [
        Precision::Weight(f64::INFINITY),
        Precision::Weight(0.0),
        Precision::Sigmas([1.0, -1.0, 1.0]),
        Precision::Covariance(Matrix3::zeros()),
    ] {
        let mut bad = good.clone();
        bad[1].precision = precision;
        assert!(matches!(solve(&bad), Error::OutOfRange { .. }), "{precision:?}");
    }
    for scale in [0.0, -2.0, f64::NAN, f64::INFINITY] {
        let options = AbsoluteOrientationOptions { scale: Some(scale), ..options };
        let error = absolute_orientation(&good, &options).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { what: "held scale", .. }));
    }
    // On a line in the model, on a line on the ground, in one place.
    let degenerate = |pairs: &[PointPair]| match solve(pairs) {
        Error::Degenerate { measure, limit, .. } => assert!(measure <= limit),
        other => panic!("{other}"),
    };
    for offset in [0.0, 3e6] {
        let line: Vec<_> = (0..5)
            .map(|i| Point3::new(offset + f64::from(i), 2.0 * f64::from(i) - offset, offset))
            .collect();
        let from: Vec<_> =
            good.iter().zip(&line).map(|(p, x)| PointPair { from: *x, ..*p }).collect();
        let to: Vec<_> = good.iter().zip(&line).map(|(p, x)| PointPair { to: *x, ..*p }).collect();
        let both: Vec<_> = line.iter().map(|x| PointPair::new(*x, *x)).collect();
        for pairs in [from, to, both] {
            degenerate(&pairs);
        }
    }
    degenerate(&[PointPair::new(Point3::new(1.0, 2.0, 3.0), Point3::origin()); 4]);
    // A regular tetrahedron and its mirror image: three rotations are equally good.
    let corners = [(1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0)];
    let mirrored =
        corners.map(|(x, y, z)| PointPair::new(Point3::new(x, y, z), Point3::new(x, y, -z)));
    degenerate(&mirrored);
}
