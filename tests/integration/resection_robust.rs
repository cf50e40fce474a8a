//! Space resection among wrong points, against the camera that the scenes were made with.

use collinear::adjust::{ControlPoint, ResectionOptions, resect, resect_robust};
use collinear::nalgebra::{Point2, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use collinear::numeric::consensus::ConsensusOptions;
use collinear::{Error, InteriorOrientation};

use crate::support::Random;

fn vector(random: &mut Random) -> Vector3<f64> {
    Vector3::new(random.normal(), random.normal(), random.normal())
}

fn camera() -> InteriorOrientation {
    InteriorOrientation::new([1000.0; 2], Point2::new(640.0, 480.0), 0.0).unwrap()
}

struct Scene {
    rotation: Rotation3<f64>,
    control: Vec<ControlPoint>,
}

/// n points of which the first `wrong` are measured anywhere in 1280 × 960, the others with σ = ½ pixel, written out by hand.
fn scene(seed: u64, n: usize, wrong: usize) -> Scene {
    let mut random = Random(seed);
    let rotation: Rotation3<f64> = quaternion(&mut random).to_rotation_matrix();
    let translation = vector(&mut random) * 3.0;
    let control = (0..n)
        .map(|i| {
            let (u, v) = (random.within(40.0, 1240.0), random.within(40.0, 920.0));
            let depth = random.within(4.0, 8.0);
            let seen = Vector3::new((u - 640.0) / 1000.0, (v - 480.0) / 1000.0, 1.0) * depth;
            let object = Point3::from(rotation.inverse() * (seen - translation));
            let image = if i < wrong {
                Point2::new(random.within(0.0, 1280.0), random.within(0.0, 960.0))
            } else {
                Point2::new(u + 0.5 * random.normal(), v + 0.5 * random.normal())
            };
            ControlPoint::new(object, image)
        })
        .collect();
    Scene { rotation, control }
}

fn quaternion(random: &mut Random) -> UnitQuaternion<f64> {
    let [w, x, y, z] = [0; 4].map(|_| random.normal());
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// The angle between two rotations, degrees, small ones too.
fn degrees(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    ((a.matrix() - b.matrix()).norm() / 8f64.sqrt()).asin().to_degrees() * 2.0
}

fn options(seed: u64) -> ConsensusOptions {
    ConsensusOptions { threshold: 3.0, seed, ..ConsensusOptions::default() }
}

#[test]
fn most_points_may_be_wrong_and_no_wrong_camera_is_returned() {
    for (wrong, trials) in [(30, 60), (60, 60), (80, 60)] {
        for seed in 0..trials {
            let scene = scene(seed, 100, wrong);
            let found = resect_robust(
                &camera(),
                &scene.control,
                &options(seed),
                &ResectionOptions::default(),
            )
            .unwrap();
            let off =
                degrees(&found.resection.sensor.exterior.camera_from_world(), &scene.rotation);
            // Half a pixel at c = 1000 and 20 points: 0.03° or so.
            assert!(off < 0.3, "{wrong} wrong, seed {seed}: {off}°");
            let good = found.inliers[wrong..].iter().filter(|i| **i).count();
            assert!(good >= (100 - wrong) * 9 / 10, "{wrong}, {seed}: {good}");
            assert_eq!(found.inliers.iter().filter(|i| **i).count(), found.inlier_count);
            assert!(found.log10_false_alarms < -6.0);
        }
    }
}

#[test]
fn the_camera_is_that_of_the_points_that_agree() {
    let scene = scene(5, 60, 20);
    let found = resect_robust(&camera(), &scene.control, &options(1), &ResectionOptions::default())
        .unwrap();
    let agreeing: Vec<ControlPoint> =
        scene.control.iter().zip(&found.inliers).filter(|(_, i)| **i).map(|(c, _)| *c).collect();
    let alone = resect(&camera(), &agreeing, &ResectionOptions::default()).unwrap();
    let [a, b] = [&found.resection, &alone].map(|r| r.sensor.exterior.projection_center());
    assert!((a - b).norm() < 1e-9, "{a} {b}");
    assert_eq!(found.resection.report.redundancy, 2 * agreeing.len() - 6);
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let scene = scene(9, 80, 50);
    let find = |seed| {
        let how = ResectionOptions::default();
        let found = resect_robust(&camera(), &scene.control, &options(seed), &how).unwrap();
        (found.resection.sensor.exterior, found.inliers, found.trials)
    };
    assert_eq!(find(3), find(3));
}

#[test]
fn chance_alone_is_an_error() {
    for seed in 0..30 {
        let scene = scene(seed, 60, 60);
        let error =
            resect_robust(&camera(), &scene.control, &options(seed), &ResectionOptions::default())
                .unwrap_err();
        assert!(matches!(error, Error::NoConsensus { .. }), "{error}");
    }
    // A threshold of 300 pixels: nearly half of all pixels agree with anything.
    let scene = scene(1, 40, 40);
    let wide = ConsensusOptions { threshold: 300.0, max_trials: 500, ..options(0) };
    let error =
        resect_robust(&camera(), &scene.control, &wide, &ResectionOptions::default()).unwrap_err();
    assert!(
        matches!(
            error,
            Error::NoConsensus { .. } | Error::Projection(_) | Error::NotConverged { .. }
        ),
        "{error}"
    );
}

#[test]
fn the_number_of_false_alarms_is_counted() {
    // Twelve exact points of twenty-four, the others far off: log₁₀ of 4 · 21 · C(24, 12) · C(12, 3) · p⁹, p = π 9/A.
    let scene = scene(4, 24, 12);
    let found = resect_robust(&camera(), &scene.control, &options(0), &ResectionOptions::default())
        .unwrap();
    assert_eq!(found.inlier_count, 12);
    let (xs, ys): (Vec<f64>, Vec<f64>) =
        scene.control.iter().map(|c| (c.image.x, c.image.y)).unzip();
    let range = |v: &[f64]| {
        v.iter().copied().fold(f64::MIN, f64::max) - v.iter().copied().fold(f64::MAX, f64::min)
    };
    let p = core::f64::consts::PI * 9.0 / ((range(&xs) + 6.0) * (range(&ys) + 6.0));
    let expected = (4.0 * 21.0 * 2_704_156.0 * 220.0 * p.powi(9)).log10();
    assert!((found.log10_false_alarms - expected).abs() < 1e-9, "{}", found.log10_false_alarms);
}

#[test]
fn an_exact_plane_has_two_solutions() {
    // A square seen obliquely from far, without any error: the mirrored tilt is a minimum too, though far worse.
    let tilt = Rotation3::from_scaled_axis(Vector3::new(0.6, 0.3, 0.1));
    let control: Vec<ControlPoint> =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (0.3, 0.6)]
            .into_iter()
            .map(|(x, y)| {
                let seen = tilt * Vector3::new(x, y, 0.0) + Vector3::new(0.2, -0.1, 12.0);
                let image =
                    Point2::new(640.0 + 1000.0 * seen.x / seen.z, 480.0 + 1000.0 * seen.y / seen.z);
                ControlPoint::new(Point3::new(x, y, 0.0), image)
            })
            .collect();
    let found = resect(&camera(), &control, &ResectionOptions::default()).unwrap();
    assert!(degrees(&found.sensor.exterior.camera_from_world(), &tilt) < 1e-9);
    let other = found.other.unwrap();
    assert!(other.cost > 1e-3 && degrees(&other.exterior.camera_from_world(), &tilt) > 20.0);
}
