//! The motion between two cameras by least squares.

use collinear::adjust::{
    ImagePair, Precision, RelativeOrientationOptions, relative_orientation,
    relative_orientation_robust,
};
use collinear::camera::{Brown, BrownCamera, CentralModel};
use collinear::geometry::Pose;
use collinear::numeric::consensus::ConsensusOptions;
use collinear::{Error, InteriorOrientation};
use nalgebra::{Matrix2, Matrix3x2, Point2, Point3, Rotation3, Vector3};

use crate::support::{matrix3, numbers, signed};

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/oracles/relative_orientation.json")).unwrap()
}

fn cameras(case: &serde_json::Value) -> [InteriorOrientation; 2] {
    [0, 1].map(|i| {
        let c = numbers(&case["cameras"][i]);
        InteriorOrientation::new([c[0], c[1]], Point2::new(c[2], c[3]), 0.0).unwrap()
    })
}

fn pairs(case: &serde_json::Value) -> Vec<ImagePair> {
    let points = |key: &str| -> Vec<Point2<f64>> {
        numbers(&case[key]).chunks(2).map(Point2::from_slice).collect()
    };
    let covariances: Vec<_> = numbers(&case["covariances"])
        .chunks(4)
        .map(|c| Precision::Covariance(Matrix2::from_row_slice(c)))
        .collect();
    points("first")
        .into_iter()
        .zip(points("second"))
        .zip(covariances.chunks(2))
        .map(|((f, s), c)| ImagePair { precisions: [c[0], c[1]], ..ImagePair::new(f, s) })
        .collect()
}

#[test]
fn it_is_the_adjustment_with_model_points_in_30_digits() {
    for (number, case) in oracle()["cases"].as_array().unwrap().iter().enumerate() {
        let ([first, second], pairs) = (cameras(case), pairs(case));
        let solution = &case["solution"];
        let found =
            relative_orientation(&first, &second, &pairs, &RelativeOrientationOptions::default())
                .unwrap();
        let base = Vector3::from_vec(numbers(&solution["base"]));
        let b = found.pose.origin.coords;
        assert!((b.norm() - 1.0).abs() < 1e-14);
        assert!((b - base).norm() < 1e-10, "{number} {}", (b - base).norm());
        let turn = found.pose.rotation.matrix() - matrix3(&solution["rotation"]);
        assert!(turn.norm() < 1e-10, "{number} {}", turn.norm());
        let report = &found.report;
        let n = pairs.len();
        assert_eq!((report.observations, report.unknowns), (4 * n, 5 + 3 * n));
        assert_eq!(report.redundancy, n - 5);
        let exact = number == 4;
        let sigma0 = solution["sigma0"].as_f64().unwrap();
        let ratio = report.sigma0.unwrap() / sigma0 - 1.0;
        assert!(exact && report.sigma0.unwrap() < 1e-9 || ratio.abs() < 1e-10, "{number} {ratio}");
        for (x, p) in numbers(&solution["points"]).chunks(3).zip(&found.model) {
            let shift = (p.unwrap() - Point3::from_slice(x)).norm();
            assert!(shift < 1e-8 * p.unwrap().coords.norm(), "{number} {shift:e}");
        }
        assert!((report.redundancy_sum() - (n - 5) as f64).abs() < 1e-9);
        assert!(report.convergence.converged);
        // Cofactors, the base's as those of its three coordinates.
        let unit = report.sigma * report.sigma;
        let c = &report.covariance;
        let across = Matrix3x2::from_columns(&found.across);
        assert!(
            (found.across[0].dot(&b)).abs() < 1e-14
                && found.across[0].dot(&found.across[1]).abs() < 1e-14
        );
        let qb = across * c.fixed_view::<2, 2>(0, 0) * across.transpose() / unit;
        let qd = c.fixed_view::<3, 3>(2, 2) / unit;
        let mixed = across * c.fixed_view::<2, 3>(0, 2) / unit;
        for (name, q) in [("base", qb), ("turn", qd), ("mixed", mixed)] {
            let expected = matrix3(&solution[format!("{name}_cofactor").as_str()]);
            let error = (q - expected).norm() / expected.norm();
            let limit = 1e-8;
            assert!(error < limit, "{number} {name} {error:e}");
        }
    }
}

/// Wuhan university's stereo pair, with the result printed by the program AP-Project (φ, ω, κ and by/bx, bz/bx of the second photo, least squares of
/// the parallaxes q in the first photo's system).
#[test]
fn a_published_relative_orientation() {
    let case = &oracle()["cases"][1];
    let ([first, second], pairs) = (cameras(case), pairs(case));
    let found =
        relative_orientation(&first, &second, &pairs, &RelativeOrientationOptions::default())
            .unwrap();
    let b = found.pose.origin;
    assert!((-b.y / b.x - 0.005_018_6).abs() < 2e-5, "{}", -b.y / b.x);
    assert!((-b.z / b.x + 0.013_151_3).abs() < 2e-5, "{}", -b.z / b.x);
    let photo = collinear::geometry::rotation::camera_from_photo();
    let turned = photo.inverse() * found.pose.rotation * photo;
    let angles = collinear::geometry::rotation::PhiOmegaKappa::from_photo_from_world(&turned);
    assert!((angles.phi - 0.000_515_573).abs() < 2e-5, "{angles:?}");
    assert!((angles.omega + 0.003_294_59).abs() < 2e-5, "{angles:?}");
    assert!((angles.kappa - 0.000_466_548).abs() < 2e-5, "{angles:?}");
}

fn lens() -> BrownCamera {
    let interior =
        InteriorOrientation::new([1000.0, 1005.0], Point2::new(640.0, 480.0), 0.0).unwrap();
    let lens = Brown::new([-0.1, 0.0, 0.0], [1e-3, -5e-4]).unwrap();
    BrownCamera::new(interior, lens)
}

/// Pairs of n points seen through two lenses, with noise of half a width `noise`; every `wrong`-th pair is anywhere.
fn scene(seed: u64, n: usize, noise: f64, wrong: usize) -> (Pose, Vec<ImagePair>) {
    let mut next = signed(seed);
    let rotation = Rotation3::new(Vector3::new(0.2 * next(), 0.2 * next(), next()));
    let base = Vector3::new(next(), next(), 0.5 * next()).normalize();
    let camera = lens();
    let mut pairs = Vec::new();
    while pairs.len() < n {
        let x = Vector3::new(2.0 * next(), 1.5 * next(), 5.0 + 1.5 * next());
        let seen = [x, rotation * (x - base)].map(|d| camera.project_direction(&d).unwrap());
        let mut moved = seen.map(|p| Point2::new(p.x + noise * next(), p.y + noise * next()));
        if wrong > 0 && pairs.len() % wrong == 0 {
            moved[1] = Point2::new(640.0 + 600.0 * next(), 480.0 + 450.0 * next());
        }
        pairs.push(ImagePair::new(moved[0], moved[1]));
    }
    (Pose::new(rotation, Point3::from(base)), pairs)
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    (a.origin - b.origin).norm() + (a.rotation.matrix() - b.rotation.matrix()).norm()
}

#[test]
fn exact_pairs_give_the_exact_motion_through_any_lens() {
    for seed in 0..40 {
        let (truth, pairs) = scene(seed, 6 + seed as usize, 0.0, 0);
        let found =
            relative_orientation(&lens(), &lens(), &pairs, &RelativeOrientationOptions::default())
                .unwrap();
        let error = distance(&found.pose, &truth);
        assert!(error < 1e-9, "{seed} {error:e}");
        assert!(found.model.iter().all(Option::is_some), "{seed}");
    }
}

#[test]
fn a_start_saves_the_search_and_five_pairs_are_then_enough() {
    let (truth, pairs) = scene(3, 12, 0.5, 0);
    let options = RelativeOrientationOptions::default();
    let searched = relative_orientation(&lens(), &lens(), &pairs, &options).unwrap();
    // Any base: only its direction counts.
    let near = Pose::new(
        Rotation3::new(Vector3::new(0.02, -0.03, 0.01)) * truth.rotation,
        Point3::from((truth.origin.coords + Vector3::new(0.02, 0.05, -0.03)) * 7.0),
    );
    let started = RelativeOrientationOptions { start: Some(near), ..options };
    let found = relative_orientation(&lens(), &lens(), &pairs, &started).unwrap();
    assert!(distance(&found.pose, &searched.pose) < 1e-10);
    let (_, exact) = scene(3, 5, 0.0, 0);
    let five = relative_orientation(&lens(), &lens(), &exact, &started).unwrap();
    assert!(distance(&five.pose, &truth) < 1e-9, "{}", distance(&five.pose, &truth));
    assert_eq!((five.report.redundancy, five.report.sigma0), (0, None));
}

#[test]
fn the_best_of_the_minima_is_kept() {
    let options = RelativeOrientationOptions::default();
    let mut same = 0;
    for seed in 0..60 {
        let (truth, pairs) = scene(500 + seed, 8, 1.0, 0);
        let found = relative_orientation(&lens(), &lens(), &pairs, &options).unwrap();
        let started = RelativeOrientationOptions { start: Some(truth), ..options };
        let near = relative_orientation(&lens(), &lens(), &pairs, &started).unwrap();
        let [cost, least] = [&found, &near].map(|o| o.report.convergence.final_cost);
        // Few noisy pairs may have a better minimum far from the truth, but none worse is taken with all points in front.
        let front = near.model.iter().all(Option::is_some);
        assert!(cost <= least * (1.0 + 1e-9) || !front, "{seed} {cost} {least}");
        same += u32::from(distance(&found.pose, &near.pose) < 1e-6);
    }
    assert!(same > 40, "{same}");
}

#[test]
fn noise_moves_the_motion_as_the_covariance_says() {
    // Uniform noise of ±1 px: σ² = 1/3. Over 200 scenes the squared error of the rotation over its variance has the mean 3.
    let (mut sum, mut sigma) = (0.0, 0.0);
    for seed in 0..200 {
        let (truth, pairs) = scene(1000 + seed, 30, 1.0, 0);
        let options = RelativeOrientationOptions { estimate_sigma: false, ..Default::default() };
        let pairs: Vec<_> = pairs
            .iter()
            .map(|p| p.with_precision(Precision::Sigma((1.0f64 / 3.0).sqrt())))
            .collect();
        let found = relative_orientation(&lens(), &lens(), &pairs, &options).unwrap();
        assert_eq!(found.report.sigma, 1.0);
        let turn = (truth.rotation * found.pose.rotation.inverse()).scaled_axis();
        let covariance = found.report.covariance.fixed_view::<3, 3>(2, 2).into_owned();
        sum += turn.dot(&(covariance.try_inverse().unwrap() * turn));
        sigma += found.report.sigma0.unwrap().powi(2);
    }
    // The standard deviation of the mean of 200 values of χ²₃ is √(6/200) = 0.17.
    assert!((sum / 200.0 - 3.0).abs() < 0.7, "{}", sum / 200.0);
    // And of σ₀² with 25 degrees of freedom √(2/25/200) = 0.02.
    assert!((sigma / 200.0 - 1.0).abs() < 0.06, "{}", sigma / 200.0);
}

#[test]
fn wrong_pairs_are_found_with_any_seed() {
    for seed in 0..30 {
        let (truth, pairs) = scene(seed, 90, 0.5, 3);
        let consensus = ConsensusOptions { threshold: 1.5, seed, ..Default::default() };
        let found = relative_orientation_robust(
            &lens(),
            &lens(),
            &pairs,
            &consensus,
            &RelativeOrientationOptions::default(),
        )
        .unwrap();
        assert!((60..=66).contains(&found.inlier_count), "{seed} {}", found.inlier_count);
        assert!((0..90).all(|i| i % 3 == 0 || found.inliers[i]), "{seed}");
        let error = distance(&found.orientation.pose, &truth);
        assert!(error < 0.02, "{seed} {error}");
        assert!(found.log10_false_alarms < -20.0, "{seed} {}", found.log10_false_alarms);
        assert_eq!(found.orientation.model.len(), found.inlier_count);
    }
}

#[test]
fn pairs_without_any_motion_are_no_consensus() {
    for seed in 0..5 {
        let (_, pairs) = scene(seed, 40, 0.5, 1);
        let consensus =
            ConsensusOptions { threshold: 1.0, max_trials: 300, seed, ..Default::default() };
        let found = relative_orientation_robust(
            &lens(),
            &lens(),
            &pairs,
            &consensus,
            &RelativeOrientationOptions::default(),
        );
        assert!(matches!(found, Err(Error::NoConsensus { .. })), "{seed} {found:?}");
    }
}

#[test]
fn what_determines_no_motion_is_refused() {
    let (_, pairs) = scene(1, 10, 0.0, 0);
    let options = RelativeOrientationOptions::default();
    let solve = |pairs: &[ImagePair], options: &RelativeOrientationOptions| {
        relative_orientation(&lens(), &lens(), pairs, options).unwrap_err()
    };
    assert_eq!(solve(&pairs[..5], &options), Error::TooFewPoints { needed: 6, got: 5 });
    let start = RelativeOrientationOptions { start: Some(Pose::identity()), ..options };
    assert_eq!(solve(&pairs[..4], &start), Error::TooFewPoints { needed: 5, got: 4 });
    assert!(matches!(solve(&pairs, &start), Error::Degenerate { measure: 0.0, .. }));
    let nan = Pose::new(Rotation3::identity(), Point3::new(f64::NAN, 0.0, 1.0));
    let start = RelativeOrientationOptions { start: Some(nan), ..options };
    assert!(matches!(solve(&pairs, &start), Error::NotFinite { .. }));
    let mut bad = pairs.clone();
    bad[3].second.x = f64::INFINITY;
    assert_eq!(solve(&bad, &options), Error::NotFinite { what: "image pair" });
    let mut bad = pairs.clone();
    bad[3].precisions[1] = Precision::Weight(f64::INFINITY);
    assert!(matches!(solve(&bad, &options), Error::OutOfRange { .. }));
    // Far beyond the lens's fold.
    let mut bad = pairs.clone();
    bad[3].first = Point2::new(1e5, 1e5);
    assert!(matches!(solve(&bad, &options), Error::Projection(_)));
    // One pair many times; pictures from one place.
    assert!(matches!(solve(&[pairs[0]; 8], &options), Error::Degenerate { .. }));
    let turned: Vec<_> = pairs
        .iter()
        .map(|p| {
            let d = lens().direction(&p.first).unwrap();
            let turn = Rotation3::new(Vector3::new(0.1, 0.05, -0.3));
            ImagePair::new(p.first, lens().project_direction(&(turn * d)).unwrap())
        })
        .collect();
    let error = solve(&turned, &options);
    assert!(matches!(error, Error::Degenerate { .. }), "{error}");
    let near = Pose::new(Rotation3::new(Vector3::new(0.1, 0.05, -0.3)), Point3::new(1.0, 0.0, 0.0));
    let start = RelativeOrientationOptions { start: Some(near), ..options };
    let error = solve(&turned, &start);
    assert!(matches!(error, Error::Degenerate { .. }), "{error}");
}
