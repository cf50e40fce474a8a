//! Scanning cameras against mpmath, and the laws that each of them keeps.

use std::sync::atomic::{AtomicUsize, Ordering};

use collinear::ProjectionError;
use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralCamera, Ephemeris, ExteriorOrientation, Frame,
    ImageMotionCompensation, InteriorOrientation, Interpolation, Panorama, PlatformState,
    PolynomialTrajectory, ScanTime, Scanner, SensorModel, Trajectory,
};
use collinear::geometry::rotation::Quaternion;
use collinear::geometry::{Plane, Surface};
use collinear::nalgebra::{DMatrix, DVector, Point2, Point3, Rotation3, Vector2, Vector3};
use proptest::prelude::*;
use serde_json::Value;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(number).collect()
}

fn vectors(v: &Value) -> Vec<Vector3<f64>> {
    numbers(v).chunks(3).map(Vector3::from_column_slice).collect()
}

fn points(v: &Value) -> Vec<Point3<f64>> {
    v.as_array().unwrap().iter().map(|p| Point3::from_slice(&numbers(p))).collect()
}

fn rotation(v: &Value) -> Rotation3<f64> {
    let q = numbers(v);
    Quaternion { w: q[0], x: q[1], y: q[2], z: q[3] }.rotation().unwrap()
}

fn between(v: &Value) -> Interpolation {
    v.as_u64()
        .map_or(Interpolation::Linear, |n| Interpolation::Lagrange(usize::try_from(n).unwrap()))
}

/// A sensor whose parameters can be estimated.
trait Sensor: SensorModel + Adjustable {}
impl<S: SensorModel + Adjustable> Sensor for S {}

fn with_trajectory<T: Trajectory + 'static>(case: &Value, base: T) -> Box<dyn Sensor> {
    let (parameters, trajectory) = (&case["parameters"], &case["trajectory"]);
    let (position, attitude) = (vectors(&parameters["position"]), vectors(&parameters["attitude"]));
    let (origin, unit) = (number(&trajectory["origin"]), number(&trajectory["unit"]));
    let trajectory = PolynomialTrajectory::new(base, origin, unit, position, attitude).unwrap();
    let i = numbers(&parameters["interior"]);
    let interior = InteriorOrientation::new([i[0], i[1]], Point2::new(i[2], i[3]), i[4]).unwrap();
    let extent = [0, 1].map(|k| numbers(&case["extent"][k]).try_into().unwrap());
    let (a, b) = (number(&case["per_column"]), number(&case["per_line"]));
    let timing = ScanTime::by_pixel(number(&case["start"]), a, b, extent).unwrap();
    let lens = numbers(&parameters["lens"]);
    match (case["camera"].as_str().unwrap(), case["row"].as_f64()) {
        ("brown", row) => {
            let lens = Brown::new([lens[0], lens[1], lens[2]], [lens[3], lens[4]]).unwrap();
            let camera = BrownCamera::new(interior, lens);
            match row {
                Some(row) => Box::new(Scanner::line_scan(camera, trajectory, row, timing).unwrap()),
                None => Box::new(Scanner::frame_scan(camera, trajectory, timing).unwrap()),
            }
        }
        (_, Some(row)) => Box::new(Scanner::whiskbroom(interior, row, trajectory, timing).unwrap()),
        _ => {
            let compensation = ImageMotionCompensation::new(lens[0]).unwrap();
            Box::new(Scanner::panoramic(interior, compensation, trajectory, timing).unwrap())
        }
    }
}

fn sensor(case: &Value) -> Box<dyn Sensor> {
    let base = &case["trajectory"]["base"];
    if base["center"].is_array() {
        let center = Point3::from_slice(&numbers(&base["center"]));
        return with_trajectory(
            case,
            ExteriorOrientation::new(center, rotation(&base["quaternion"])),
        );
    }
    let (times, positions) = (numbers(&base["position_times"]), points(&base["positions"]));
    let turns = numbers(&base["attitude_times"]);
    let attitudes: Vec<_> = base["attitudes"].as_array().unwrap().iter().map(rotation).collect();
    let table = Ephemeris::new(
        (&times, &positions, between(&base["positions_between"])),
        (&turns, &attitudes, between(&base["attitudes_between"])),
    );
    with_trajectory(case, table.unwrap())
}

fn cases() -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../data/oracles/scanning.json")).unwrap();
    all["cases"].as_array().unwrap().clone()
}

/// The groups of a sensor by the names of the oracle, in the order of the groups.
const GROUPS: [(&str, &str); 5] = [
    ("position polynomial", "position"),
    ("attitude polynomial", "attitude"),
    ("interior orientation", "interior"),
    ("lens distortion", "lens"),
    ("image motion compensation", "lens"),
];

fn groups(sensor: &dyn Sensor) -> Vec<(&'static str, usize)> {
    (0..).map_while(|g| sensor.parameter_group(g)).map(|g| (g.name, g.len)).collect()
}

#[test]
fn scanning_cameras_agree_with_sixty_digits() {
    let cases = cases();
    assert_eq!(cases.len(), 7);
    for case in &cases {
        let sensor = sensor(case);
        let groups = groups(&*sensor);
        for point in case["points"].as_array().unwrap() {
            let world = Point3::from_slice(&numbers(&point["world"]));
            let expected = Point2::from_slice(&numbers(&point["image"]));
            let image = sensor.project(&world).unwrap();
            let off = (image - expected).norm();
            assert!(off < 1e-9, "{}: {image} for {expected}: {off:e}", case["name"]);

            let (mut by_object, mut blocks) = ([0.0; 6], Vec::new());
            for (_, len) in &groups {
                blocks.push(vec![0.0; 2 * len]);
            }
            let mut slices: Vec<&mut [f64]> = blocks.iter_mut().map(Vec::as_mut_slice).collect();
            assert_eq!(sensor.partials(&world, &mut by_object, &mut slices).unwrap(), image);
            let (again, slopes) = sensor.project_jacobian(&world).unwrap();
            assert_eq!(again, image);
            let close = |found: Vector2<f64>, expected: &Value, size: f64, what: &str| {
                let expected = Vector2::from_vec(numbers(expected));
                let off = (found - expected).norm();
                assert!(
                    off <= 2e-9 * expected.norm() + 1e-12 * size,
                    "{} {what}: {found:?} for {expected:?}",
                    case["name"]
                );
            };
            for i in 0..3 {
                let column = slopes.column(i).into_owned();
                assert_eq!(column, Vector2::new(by_object[i], by_object[3 + i]));
                close(column, &point["by_world"][i], slopes.norm(), "by world");
            }
            for ((name, len), block) in groups.iter().zip(&blocks) {
                let key = GROUPS.iter().find(|(n, _)| n == name).map(|(_, key)| *key).unwrap();
                let expected = point["by"][key].as_array().unwrap();
                assert_eq!(expected.len(), *len, "{name}");
                for (i, expected) in expected.iter().enumerate() {
                    let column = Vector2::new(block[i], block[len + i]);
                    let size = DVector::from_column_slice(block).norm();
                    close(column, expected, size, &format!("by {name} {i}"));
                }
            }
        }
    }
}

/// A rectangle of pixels, its edges among them.
fn grid(case: &Value) -> Vec<Point2<f64>> {
    let [columns, lines] = [0, 1].map(|k| numbers(&case["extent"][k]));
    let shares = [0.0, 1e-9, 0.011, 0.25, 0.4999, 0.731, 0.993, 1.0];
    let along = |e: &[f64], s: f64| e[0] + s * (e[1] - e[0]);
    let row = |y: f64| shares.map(|s| Point2::new(along(&columns, s), along(&lines, y)));
    shares.into_iter().flat_map(row).collect()
}

/// A plane below the middle of the scan, at a distance and tilted.
fn ground_below(sensor: &dyn SensorModel, middle: &Point2<f64>, depth: f64) -> Plane {
    let collinear::geometry::Locus::Ray(ray) = sensor.locus(middle).unwrap() else { panic!() };
    let normal = -ray.direction.into_inner() + Vector3::new(0.02, -0.03, 0.01);
    Plane::from_point_and_normal(ray.at(depth), normal).unwrap()
}

/// To the edge of the scan, on a slope: pixel to ground to pixel.
#[test]
fn project_after_ground_is_the_identity_for_every_scan() {
    for case in &cases() {
        let sensor = sensor(case);
        let pixels = grid(case);
        let first = Point3::from_slice(&numbers(&case["points"][1]["world"]));
        let middle = Point2::from_slice(&numbers(&case["points"][1]["image"]));
        let collinear::geometry::Locus::Ray(ray) = sensor.locus(&middle).unwrap() else { panic!() };
        let plane = ground_below(&*sensor, &middle, (first - ray.origin).norm());
        for image in pixels {
            let ground = sensor.ground(&image, &plane).unwrap();
            assert!(plane.height_above(&ground).abs() < 1e-9 * (1.0 + ground.coords.norm()));
            let (again, slopes) = sensor.project_jacobian(&ground).unwrap();
            // The ground point and the projection centre are rounded to floats near them.
            let rounding = slopes.norm() * f64::EPSILON * ground.coords.norm();
            let off = (again - image).norm();
            assert!(off < 1e-9 + rounding, "{} {image}: {again}: {off:e}", case["name"]);
        }
    }
}

/// Every parameter, moved by a step, moves the image as its partial derivative says.
#[test]
fn a_step_of_each_parameter_moves_the_image_by_its_partial_derivative() {
    for case in &cases() {
        let shape = groups(&*sensor(case));
        let world = Point3::from_slice(&numbers(&case["points"][0]["world"]));
        for (group, (name, len)) in shape.iter().enumerate() {
            for i in 0..*len {
                let moved = |h: f64| {
                    let mut sensor = sensor(case);
                    let mut step = vec![0.0; *len];
                    step[i] = h;
                    sensor.adjust(group, &step).unwrap();
                    let mut values = vec![0.0; *len];
                    sensor.parameters(group, &mut values);
                    (sensor.project(&world).unwrap(), values[i])
                };
                let key = GROUPS.iter().find(|(n, _)| n == name).map(|(_, key)| *key).unwrap();
                let expected = Vector2::from_vec(numbers(&case["points"][0]["by"][key][i]));
                // A step that moves the image by a hundredth of a pixel.
                let h = 0.01 / expected.norm();
                assert!(h < 1e9, "{}: {name} {i} moves nothing", case["name"]);
                let ((ahead, value), (behind, before)) = (moved(h), moved(-h));
                assert!((value - before - 2.0 * h).abs() < 1e-12 * (1.0 + value.abs()));
                let slope = (ahead - behind) / (2.0 * h);
                let off = (slope - expected).norm() / expected.norm();
                assert!(off < 1e-5, "{} {name} {i}: {slope:?} {expected:?}", case["name"]);
            }
        }
    }
}

fn down(center: Point3<f64>) -> ExteriorOrientation {
    // y of the picture along the world's y.
    ExteriorOrientation::look_at(center, center - Vector3::z(), -Vector3::y()).unwrap()
}

/// A camera that stands still sees what one exposure sees.
#[test]
fn a_scan_without_motion_is_a_frame() {
    let exterior = down(Point3::new(10.0, 20.0, 300.0));
    let film = InteriorOrientation::new([600.0, 590.0], Point2::new(900.0, 200.0), 0.3).unwrap();
    let none = ImageMotionCompensation::default();
    let sweep = ScanTime::by_column(0.0, 1e-3, [0.0, 1800.0]).unwrap();
    let scanned = Scanner::panoramic(film, none, exterior, sweep).unwrap();
    let panorama = Frame::new(exterior, CentralCamera::ideal(film, Panorama::Cylindrical));

    let lens = Brown::new([-0.1, 0.02, 0.0], [1e-3, -5e-4]).unwrap();
    let camera = BrownCamera::new(film, lens);
    let readout = ScanTime::by_line(-3.0, -1e-5, [0.0, 400.0]).unwrap();
    let rolling = Scanner::frame_scan(camera, exterior, readout).unwrap();
    let photograph = Frame::new(exterior, camera);
    for (x, y) in [(0.0, 0.0), (40.0, -30.0), (-77.0, 55.5), (130.0, 3.0)] {
        let world = Point3::new(10.0 + x, 20.0 + y, 2.0);
        for (a, b) in [
            (scanned.project_jacobian(&world), panorama.project_jacobian(&world)),
            (rolling.project_jacobian(&world), photograph.project_jacobian(&world)),
        ] {
            let ((p, slopes), (q, expected)) = (a.unwrap(), b.unwrap());
            assert!((p - q).norm() < 1e-11, "{p} {q}");
            assert!((slopes - expected).norm() < 1e-12 * expected.norm());
        }
    }
    let p = Point2::new(1234.5, 100.25);
    assert_eq!(scanned.locus(&p).unwrap(), panorama.locus(&p).unwrap());
}

/// By hand: 800 up, 70 a second along y, 500 lines a second, c = 4000; the camera pitched by the angle whose tangent is ⅒, so that
/// it looks 80 ahead. A tower of 100 at y = 150 is seen when the platform is 70 before it.
#[test]
fn a_pushbroom_that_looks_ahead_by_hand() {
    let start = ExteriorOrientation::look_at(
        Point3::new(0.0, 0.0, 800.0),
        Point3::new(0.0, 80.0, 0.0),
        -Vector3::y(),
    );
    let velocity = Vector3::new(0.0, 70.0, 0.0);
    let flight =
        PolynomialTrajectory::constant_velocity(start.unwrap(), 0.0, velocity, Vector3::zeros());
    let camera = InteriorOrientation::new([4000.0; 2], Point2::new(1000.0, 0.5), 0.0).unwrap();
    let lines = ScanTime::by_line(0.0, 0.002, [0.0, 2000.0]).unwrap();
    let scanner = Scanner::line_scan(camera, flight.unwrap(), 0.5, lines).unwrap();
    let foot = scanner.project(&Point3::new(-8.0, 150.0, 0.0)).unwrap();
    let top = scanner.project(&Point3::new(-8.0, 150.0, 100.0)).unwrap();
    // At y = 70 and 80, that is after 500 and 571.43 lines; distances √(800² + 80²) and 7/8 of it.
    let distance = 646_400f64.sqrt();
    assert!((foot - Point2::new(1000.0 + 32000.0 / distance, 500.0)).norm() < 1e-10, "{foot}");
    let expected = Point2::new(1000.0 + 32000.0 / (0.875 * distance), 4000.0 / 7.0);
    assert!((top - expected).norm() < 1e-10, "{top}");
}

/// A trajectory that counts how often it is asked.
#[derive(Debug)]
struct Counting<T>(T, AtomicUsize);

impl<T: Trajectory> Trajectory for Counting<T> {
    fn span(&self) -> [f64; 2] {
        self.0.span()
    }

    fn state(&self, time: f64) -> Result<PlatformState, ProjectionError> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.state(time)
    }
}

/// Newton's steps, with the right derivatives, not bisection: both ends of the scan and a few poses between.
#[test]
fn a_point_is_found_with_few_poses() {
    let camera = InteriorOrientation::new([2000.0; 2], Point2::new(500.0, 500.0), 0.3).unwrap();
    let velocity = Vector3::new(3.0, 70.0, -2.0);
    let flight = || {
        let turn = Vector3::new(0.05, 0.1, -0.07);
        let start = down(Point3::new(0.0, 0.0, 800.0));
        let flight = PolynomialTrajectory::constant_velocity(start, 0.0, velocity, turn).unwrap();
        Counting(flight, AtomicUsize::new(0))
    };
    let times: Vec<f64> = (0..=40).map(|k| 0.1 * f64::from(k)).collect();
    let positions: Vec<_> =
        times.iter().map(|t| Point3::new(t.sin(), 70.0 * t, 800.0 + t.cos())).collect();
    let attitudes: Vec<_> = times
        .iter()
        .map(|t| {
            let level = down(Point3::origin()).camera_from_world();
            Rotation3::new(Vector3::new(0.02 * t.sin(), 0.03 * (2.0 * t).cos(), 0.01 * t)) * level
        })
        .collect();
    let table = |how| {
        let table = Ephemeris::new((&times, &positions, how), (&times, &attitudes, how)).unwrap();
        Counting(table, AtomicUsize::new(0))
    };
    let lines = ScanTime::by_line(0.0, 0.002, [0.0, 1000.0]).unwrap();
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    let count = |sensor: &dyn SensorModel, counter: &AtomicUsize| {
        let mut most = 0;
        for k in 0..1000 {
            let image = Point2::new(f64::from(k), (f64::from(k) * 0.618).fract() * 1000.0);
            let world = sensor.ground(&image, &ground).unwrap();
            let before = counter.load(Ordering::Relaxed);
            assert!((sensor.project(&world).unwrap() - image).norm() < 1e-9);
            most = most.max(counter.load(Ordering::Relaxed) - before);
        }
        most
    };
    let scanner = Scanner::line_scan(camera, flight(), 500.0, lines).unwrap();
    assert!(count(&scanner, &scanner.trajectory().1) <= 6);
    let shutter = Scanner::frame_scan(camera, flight(), lines).unwrap();
    assert!(count(&shutter, &shutter.trajectory().1) <= 7);
    let scanner = Scanner::line_scan(camera, table(Interpolation::Lagrange(8)), 500.0, lines);
    let scanner = scanner.unwrap();
    assert!(count(&scanner, &scanner.trajectory().1) <= 8);
    let scanner = Scanner::line_scan(camera, table(Interpolation::Linear), 500.0, lines).unwrap();
    assert!(count(&scanner, &scanner.trajectory().1) <= 12);
}

/// A platform that nods sees some points three times: each image is one, and the ground of it is the point.
#[test]
fn a_point_seen_more_than_once_has_one_of_its_images() {
    let nod = |t: f64| Rotation3::from_axis_angle(&Vector3::x_axis(), 0.02 * (3.0 * t).sin());
    let times: Vec<f64> = (0..=100).map(|k| 0.1 * f64::from(k)).collect();
    let level = down(Point3::origin()).camera_from_world();
    let attitudes: Vec<_> = times.iter().map(|t| nod(*t) * level).collect();
    let positions: Vec<_> = times.iter().map(|t| Point3::new(0.0, 20.0 * t, 1000.0)).collect();
    let table = Ephemeris::new(
        (&times, &positions, Interpolation::Linear),
        (&times, &attitudes, Interpolation::Lagrange(4)),
    );
    let camera = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 0.5), 0.0).unwrap();
    let lines = ScanTime::by_line(0.0, 0.001, [0.0, 10_000.0]).unwrap();
    let scanner = Scanner::line_scan(camera, table.unwrap(), 0.5, lines).unwrap();
    let (mut again, mut other) = (0, 0);
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    for k in 0..500 {
        let image = Point2::new(377.7, 20.0 * f64::from(k));
        let world = scanner.ground(&image, &ground).unwrap();
        let seen = scanner.project(&world).unwrap();
        let back = scanner.ground(&seen, &ground).unwrap();
        assert!((back - world).norm() < 1e-8, "{image} {seen}");
        assert_eq!(scanner.project(&world).unwrap(), seen);
        if (seen - image).norm() < 1e-6 { again += 1 } else { other += 1 }
    }
    assert!(again > 100 && other > 100, "{again} {other}");
}

/// The whole of it, as an adjustment would: the trajectory from 24 points, from a start that is off by 20 and 0.02.
#[test]
fn a_trajectory_is_found_from_points() {
    let all = cases();
    for case in all.iter().filter(|c| c["trajectory"]["base"]["center"].is_array()) {
        // What a constant velocity leaves open is not in the image: the powers that are zero stay.
        let truth = sensor(case);
        let plane_of = |depth: f64| {
            let middle = Point2::from_slice(&numbers(&case["points"][1]["image"]));
            ground_below(&*truth, &middle, depth)
        };
        let first = Point3::from_slice(&numbers(&case["points"][1]["world"]));
        let center = Point3::from_slice(&numbers(&case["trajectory"]["base"]["center"]));
        let depth = (first - center).norm();
        let mut control = Vec::new();
        for (i, image) in grid(case).into_iter().enumerate() {
            let height = [1.0, 0.8, 0.9][i % 3];
            let ground = truth.ground(&image, &plane_of(depth * height)).unwrap();
            control.push((ground, truth.project(&ground).unwrap()));
        }
        let mut found = sensor(case);
        let len: Vec<usize> = groups(&*found).iter().take(2).map(|g| g.1).collect();
        let off = |n: usize, size: f64| -> Vec<f64> {
            (0..n).map(|i| size * (1.7 * i as f64 + 0.3).sin()).collect()
        };
        found.adjust(0, &off(len[0], 2e-3 * depth)).unwrap();
        found.adjust(1, &off(len[1], 2e-3)).unwrap();
        for _ in 0..8 {
            let unknowns = len[0] + len[1];
            let mut rows: Vec<f64> = Vec::new();
            let mut right = Vec::new();
            for (world, image) in &control {
                let (mut object, mut p, mut a) =
                    ([0.0; 6], vec![0.0; 2 * len[0]], vec![0.0; 2 * len[1]]);
                let slices: &mut [&mut [f64]] = &mut [&mut p, &mut a];
                let Ok(at) = found.partials(world, &mut object, slices) else { continue };
                for r in 0..2 {
                    rows.extend(&p[r * len[0]..(r + 1) * len[0]]);
                    rows.extend(&a[r * len[1]..(r + 1) * len[1]]);
                    right.push(image[r] - at[r]);
                }
            }
            assert!(right.len() > 2 * unknowns, "{}", case["name"]);
            let a = DMatrix::from_row_slice(right.len(), unknowns, &rows);
            let scale = DVector::from_fn(unknowns, |i, _| 1.0 / a.column(i).norm());
            let scaled: DMatrix<f64> = &a * DMatrix::from_diagonal(&scale);
            let step = scaled.svd(true, true).solve(&DVector::from_vec(right), 1e-13).unwrap();
            let step = step.component_mul(&scale);
            found.adjust(0, &step.as_slice()[..len[0]]).unwrap();
            found.adjust(1, &step.as_slice()[len[0]..]).unwrap();
        }
        for (world, image) in &control {
            let off = (found.project(world).unwrap() - image).norm();
            assert!(off < 1e-7, "{}: {off:e}", case["name"]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]
    /// Any smooth flight, any lens, any row: pixel to ground to pixel.
    #[test]
    fn any_flight_brings_its_pixels_back(
        p in prop::array::uniform9(-1.0..1.0f64),
        w in prop::array::uniform9(-1.0..1.0f64),
        k in prop::array::uniform5(-1.0..1.0f64),
        row in -60.0..60.0f64,
        at in prop::array::uniform2(0.0..1.0f64),
        whisk in -0.5..0.5f64,
    ) {
        let position = vec![
            Vector3::new(p[0], p[1], p[2]) * 100.0,
            Vector3::new(30.0 * p[3], 300.0 + 30.0 * p[4], 30.0 * p[5]),
            Vector3::new(p[6], p[7], p[8]) * 20.0,
        ];
        let attitude = vec![
            Vector3::new(w[0], w[1], w[2]) * 0.1,
            Vector3::new(w[3], w[4], w[5]) * 0.02,
            Vector3::new(w[6], w[7], w[8]) * 0.02,
        ];
        let base = down(Point3::new(4e5, 5e6, 2000.0));
        let flight = PolynomialTrajectory::new(base, 5.0, 5.0, position, attitude).unwrap();
        let lens = Brown::new([0.05 * k[0], 0.02 * k[1], 0.0], [1e-3 * k[3], 1e-3 * k[4]]).unwrap();
        let interior = InteriorOrientation::new([2000.0, 2010.0], Point2::new(500.0, k[2]), 0.5);
        let camera = BrownCamera::new(interior.unwrap(), lens);
        let extent = [[0.0, 1000.0], [0.0, 2000.0]];
        let timing = ScanTime::by_pixel(0.0, 0.005 * whisk / 1000.0, 0.005, extent).unwrap();
        let scanner = Scanner::line_scan(camera, flight, row, timing).unwrap();
        let ground = Plane::from_point_and_normal(
            Point3::new(4e5, 5e6, 30.0),
            Vector3::new(0.1, -0.05, 1.0),
        ).unwrap();
        let image = Point2::new(1000.0 * at[0], 2000.0 * at[1]);
        let world = scanner.ground(&image, &ground).unwrap();
        let again = scanner.project(&world).unwrap();
        // Coordinates of 5 million are rounded to 10⁻⁹, of which a pixel is some 0.6.
        prop_assert!((again - image).norm() < 5e-9, "{again} {image}");
    }
}
