//! Bundle adjustment.

use std::ops::ControlFlow;

use crate::support::numbers;
#[cfg(feature = "rayon")]
use crate::support::same_on_any_number_of_threads;

use collinear::adjust::bundle::{
    Adjusted, Bundle, BundleOptions, BundleReport, BundleReportOptions, Datum, Exclusion, ImageId,
    Observation, OutsideRule, PointId, Solver,
};
use collinear::adjust::{Precision, Unknown};
use collinear::camera::{CentralCamera, EvenRadial, Gnomonic};
use collinear::numeric::robust_loss::RobustLoss;
use collinear::{CentralModel, Error, ExteriorOrientation, InteriorOrientation};
use nalgebra::{DMatrix, Matrix2, Matrix3, Point2, Point3, Rotation3, Vector3};
use serde_json::Value;

type Lens = CentralCamera<Gnomonic, EvenRadial>;

fn rows(v: &Value) -> Vec<Vec<f64>> {
    v.as_array().unwrap().iter().map(numbers).collect()
}

fn three(v: &[f64]) -> Point3<f64> {
    Point3::new(v[0], v[1], v[2])
}

fn cases() -> Vec<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/oracles/bundle.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn lens(f: f64, x0: f64, y0: f64, k1: f64, k2: f64) -> Lens {
    let interior = InteriorOrientation::new([f; 2], Point2::new(x0, y0), 0.0).unwrap();
    CentralCamera::from_parts(interior, Gnomonic, EvenRadial::new([k1, k2, 0.0, 0.0]).unwrap())
}

fn values(camera: &Lens) -> [f64; 5] {
    let (p, k) = (camera.interior().principal_point(), camera.distortion().coefficients());
    [camera.interior().principal_distance()[0], p.x, p.y, k[0], k[1]]
}

/// A case of the oracle as a block; the order in which points and observations are added may be turned around.
fn block(case: &Value, backwards: bool) -> (Bundle<Lens>, Vec<ImageId>, Vec<PointId>) {
    mapped_block(case, backwards, &|p| *p, &Rotation3::identity())
}

/// In a world that a similarity, with its rotation, has moved.
fn mapped_block(
    case: &Value,
    backwards: bool,
    map: &dyn Fn(&Point3<f64>) -> Point3<f64>,
    turn: &Rotation3<f64>,
) -> (Bundle<Lens>, Vec<ImageId>, Vec<PointId>) {
    let start = &case["start"];
    let prior = case["prior"].as_f64();
    let unknowns: Vec<Unknown> = numbers(&case["chosen"])
        .into_iter()
        .map(|k| match (k as usize, prior) {
            (0, Some(sigma)) => Unknown::together(0, &[0, 1]).observed(sigma),
            (0, None) => Unknown::together(0, &[0, 1]),
            (k @ 1..3, _) => Unknown::parameter(0, k + 1),
            (k, _) => Unknown::parameter(1, k - 3),
        })
        .collect();
    let mut bundle = Bundle::new();
    let cameras: Vec<_> = rows(&start["cameras"])
        .iter()
        .map(|c| bundle.add_camera(lens(c[0], c[1], c[2], c[3], c[4]), &unknowns).unwrap())
        .collect();
    let images: Vec<_> = rows(&start["centres"])
        .iter()
        .zip(rows(&start["rotations"]))
        .enumerate()
        .map(|(i, (c, r))| {
            let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&r));
            let camera = cameras[i % cameras.len()];
            let exterior = ExteriorOrientation::new(map(&three(c)), rotation * turn.inverse());
            bundle.add_image(exterior, camera).unwrap()
        })
        .collect();
    let fixed = numbers(&case["fixed"]);
    let control = rows(&case["control"]);
    let start_points = rows(&start["points"]);
    let mut points = vec![None; start_points.len()];
    let mut order: Vec<usize> = (0..points.len()).collect();
    if backwards {
        order.reverse();
    }
    for i in order {
        let at = map(&three(&start_points[i]));
        let given = control.iter().find(|c| c[0] as usize == i);
        points[i] = Some(if fixed.contains(&(i as f64)) {
            bundle.add_fixed(at).unwrap()
        } else if let Some(c) = given {
            let covariance = Matrix3::from_row_slice(&c[4..13]);
            bundle.add_control(three(&c[1..4]), Precision::Covariance(covariance)).unwrap()
        } else {
            bundle.add_point(at).unwrap()
        });
    }
    let points: Vec<PointId> = points.into_iter().flatten().collect();
    let mut observations = rows(&case["observations"]);
    if backwards {
        observations.reverse();
    }
    for o in observations {
        let precision = match o[5] {
            0.0 => Precision::Sigma(o[4].sqrt()),
            _ => Precision::Covariance(Matrix2::new(o[4], o[5], o[6], o[7])),
        };
        let (image, point) = (images[o[0] as usize], points[o[1] as usize]);
        bundle.observe(image, point, Point2::new(o[2], o[3]), precision).unwrap();
    }
    for p in rows(&case["positions"]) {
        let (given, lever) = (three(&p[1..4]), three(&p[4..7]).coords);
        let image = images[p[0] as usize];
        bundle.observe_position(image, given, lever, Precision::Sigma(p[7])).unwrap();
    }
    for a in rows(&case["attitudes"]) {
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&a[1..10]));
        let covariance = Matrix3::from_row_slice(&a[10..19]);
        let image = images[a[0] as usize];
        let precision = Precision::Covariance(covariance);
        bundle.observe_attitude(image, rotation * turn.inverse(), precision).unwrap();
    }
    for d in rows(&case["distances"]) {
        let ends = [points[d[0] as usize], points[d[1] as usize]];
        bundle.observe_distance(ends, d[2], d[3]).unwrap();
    }
    (bundle, images, points)
}

fn converged(bundle: &Bundle<Lens>, options: &BundleOptions) -> Adjusted<Lens> {
    let adjusted = bundle.adjust(options).unwrap();
    assert!(adjusted.convergence.converged, "{:?}", adjusted.convergence);
    assert!(adjusted.excluded.is_empty());
    adjusted
}

/// Equal to a fraction of the larger standard deviations.
fn agrees(found: &DMatrix<f64>, expected: &[f64], tolerance: f64, what: &str) {
    let n = found.nrows();
    let expected = DMatrix::from_row_slice(n, n, expected);
    for r in 0..n {
        for c in 0..n {
            let size = (expected[(r, r)] * expected[(c, c)]).sqrt();
            let off = (found[(r, c)] - expected[(r, c)]).abs();
            assert!(
                off <= tolerance * size,
                "{what} {r} {c}: {} {}",
                found[(r, c)],
                expected[(r, c)]
            );
        }
    }
}

/// `tests/data/oracles/bundle.py`: the same blocks with all unknowns in one matrix, complex steps, and inner constraints as a
/// bordered system.
#[test]
fn blocks_are_adjusted_and_judged_as_one_matrix_of_all_unknowns_would() {
    for case in cases() {
        let name = case["name"].as_str().unwrap();
        if !case["groups"].is_null() {
            continue;
        }
        let (bundle, images, points) = block(&case, false);
        let mut options = BundleOptions::default();
        // To the floor of rounding: the weakest unknowns are as good as the others then.
        options.least_squares.decrease_tolerance = 1e-18;
        let adjusted = converged(&bundle, &options);
        let expected = case["cost"].as_f64().unwrap();
        let cost = adjusted.convergence.final_cost;
        assert!((cost / expected - 1.0).abs() < 1e-11, "{name}: {cost} {expected}");
        let free = name.starts_with("free");
        let placing: Option<Vec<PointId>> = case["datum"]
            .as_array()
            .map(|list| list.iter().map(|i| points[i.as_u64().unwrap() as usize]).collect());
        let datum = match &placing {
            Some(placing) => Datum::Points(placing),
            None if free => Datum::Free,
            None => Datum::Given,
        };
        let how = BundleReportOptions { datum, ..BundleReportOptions::default() };
        let report = bundle.report(&adjusted, &options, &how).unwrap();
        let whole = |key: &str| case[key].as_u64().unwrap() as usize;
        assert_eq!(report.observations, whole("count"), "{name}");
        assert_eq!(report.unknowns, whole("unknowns"), "{name}");
        assert_eq!(report.redundancy, whole("redundancy"), "{name}");
        assert!((report.redundancy_sum() / report.redundancy as f64 - 1.0).abs() < 1e-9, "{name}");
        let sigma0 = report.sigma0.unwrap();
        assert!((sigma0 / case["sigma0"].as_f64().unwrap() - 1.0).abs() < 1e-10);
        // Redundancy numbers and w: of image points, control points, positions, distances, parameters.
        let image = report.image_points.iter().flatten();
        let control = report.control_points.iter().flat_map(|(_, v)| v);
        let positions = report.positions.iter().chain(&report.attitudes).flat_map(|(_, v)| v);
        let others = report.distances.iter().chain(report.parameters.iter().map(|(_, _, v)| v));
        let all: Vec<_> = image.chain(control).chain(positions).chain(others).collect();
        let in_order = report.numbers().zip(&all).all(|((_, a), b)| std::ptr::eq(a, *b));
        assert!(in_order && report.numbers().count() == all.len(), "{name}");
        let squares: f64 = all.iter().map(|v| v.weighted_square).sum();
        assert!((squares / (2.0 * expected) - 1.0).abs() < 1e-11, "{name}: {squares}");
        let (redundancy, w) = (numbers(&case["redundancy_numbers"]), numbers(&case["w"]));
        assert_eq!(all.len(), w.len());
        for (i, value) in all.iter().enumerate() {
            assert!(
                (value.redundancy - redundancy[i]).abs() < 1e-7,
                "{name} r {i}: {value:?} {}",
                redundancy[i]
            );
            // The one distance of a free block gives its scale: nothing controls it.
            let uncontrolled = value.w.is_nan() && redundancy[i].abs() < 1e-9;
            assert!(
                uncontrolled || (value.w - w[i]).abs() < 1e-5,
                "{name} w {i}: {value:?} {}",
                w[i]
            );
        }
        let tolerance = 1e-4;
        for (i, expected) in rows(&case["camera_covariances"]).iter().enumerate() {
            let found = report.camera_covariance(bundle_camera(&bundle, i)).unwrap();
            agrees(&found, expected, tolerance, name);
            for (a, b) in values(&adjusted.cameras()[i]).iter().zip(&rows(&case["cameras"])[i]) {
                assert!((a - b).abs() < 1e-4 * b.abs().max(0.1), "{name}: {a} {b}");
            }
        }
        let fixed = numbers(&case["fixed"]).len();
        let of_points = rows(&case["point_covariances"]);
        let of_images = rows(&case["image_covariances"]);
        let image = |i: usize| report.image_covariance(images[i]).unwrap();
        if free {
            let error = bundle.report(&adjusted, &options, &BundleReportOptions::default());
            assert!(matches!(error.unwrap_err(), Error::Degenerate { .. }), "{name}");
            // The place, the attitude and without a distance the scale of a free block are those it started from: only what
            // they do not change is compared.
            let spread = |p: &[Point3<f64>]| {
                let middle = p.iter().map(|x| x.coords).sum::<Vector3<f64>>() / p.len() as f64;
                p.iter().map(|p| (p.coords - middle).norm_squared()).sum::<f64>()
            };
            let there: Vec<_> = rows(&case["points"]).iter().map(|p| three(p)).collect();
            let scale = spread(adjusted.points()) / spread(&there);
            assert!(case["distances"][0].is_null() || (scale - 1.0).abs() < 1e-9, "{scale}");
            for (i, expected) in of_points.iter().enumerate() {
                let found = report.point_covariance(points[i]).unwrap().trace() / scale;
                let expected = expected[0] + expected[4] + expected[8];
                assert!(
                    (found / expected - 1.0).abs() < tolerance,
                    "{name} {i}: {found} {expected}"
                );
            }
            for (i, expected) in of_images.iter().enumerate() {
                let turn = |r: usize| expected[6 * (r + 3) + 3..6 * (r + 3) + 6].to_vec();
                let found = image(i).view((3, 3), (3, 3)).into_owned();
                agrees(&found, &[turn(0), turn(1), turn(2)].concat(), tolerance, name);
                let found = image(i).view((0, 0), (3, 3)).trace() / scale;
                let expected = expected[0] + expected[7] + expected[14];
                assert!(
                    (found / expected - 1.0).abs() < tolerance,
                    "{name} {i}: {found} {expected}"
                );
            }
        } else {
            for (point, expected) in adjusted.points().iter().zip(rows(&case["points"])) {
                assert!((point - three(&expected)).norm() < 1e-6, "{name}");
            }
            for (exterior, expected) in adjusted.exteriors().iter().zip(rows(&case["centres"])) {
                assert!((exterior.projection_center() - three(&expected)).norm() < 1e-5, "{name}");
            }
            for (i, expected) in of_points.iter().enumerate() {
                let found = report.point_covariance(points[fixed + i]).unwrap();
                let found = DMatrix::from_iterator(3, 3, found.iter().copied());
                agrees(&found, expected, tolerance, name);
            }
            for (i, expected) in of_images.iter().enumerate() {
                agrees(&image(i).view((0, 0), (6, 6)).into_owned(), expected, tolerance, name);
            }
            let how = BundleReportOptions { datum: Datum::Free, ..how };
            let error = bundle.report(&adjusted, &options, &how);
            assert!(matches!(error.unwrap_err(), Error::OutOfRange { .. }), "{name}");
        }
    }
}

/// The camera of a number: they are added first, and as many as the case has.
fn bundle_camera(bundle: &Bundle<Lens>, number: usize) -> collinear::adjust::bundle::CameraId {
    bundle.camera_ids().nth(number).unwrap()
}

#[test]
fn the_order_of_points_and_observations_does_not_matter() {
    for case in cases() {
        let options = BundleOptions::default();
        let (bundle, _, points) = block(&case, false);
        let (other, _, other_points) = block(&case, true);
        let (a, b) = (converged(&bundle, &options), converged(&other, &options));
        let ratio = a.convergence.final_cost / b.convergence.final_cost;
        assert!((ratio - 1.0).abs() < 1e-11, "{ratio}");
        for (p, q) in points.iter().zip(&other_points) {
            assert!((a.point(*p).unwrap() - b.point(*q).unwrap()).norm() < 1e-6);
        }
    }
}

#[test]
fn conjugate_gradients_lead_where_cholesky_leads() {
    for case in cases() {
        let (bundle, _, points) = block(&case, false);
        let dense =
            converged(&bundle, &BundleOptions { solver: Solver::Dense, ..Default::default() });
        let iterative =
            converged(&bundle, &BundleOptions { solver: Solver::Iterative, ..Default::default() });
        let (a, b) = (dense.convergence.final_cost, iterative.convergence.final_cost);
        assert!((a / b - 1.0).abs() < 1e-9, "{}: {a} {b}", case["name"]);
        if !case["name"].as_str().unwrap().starts_with("free") {
            for p in points {
                assert!((dense.point(p).unwrap() - iterative.point(p).unwrap()).norm() < 1e-4);
            }
        }
    }
}

/// Exact image points of a block, by the library's own cameras: a law, no oracle.
fn exact(case: &Value) -> (Bundle<Lens>, Vec<ExteriorOrientation>, Vec<Point3<f64>>, Lens) {
    let camera = lens(1000.0, 12.0, -7.0, -0.1, 0.02);
    let centres = rows(&case["centres"]);
    let rotations = rows(&case["start"]["rotations"]);
    let truth: Vec<_> = centres
        .iter()
        .zip(&rotations)
        .map(|(c, r)| {
            let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(r));
            ExteriorOrientation::new(three(c), rotation)
        })
        .collect();
    let points: Vec<_> = rows(&case["points"]).iter().map(|p| three(p)).collect();
    let mut bundle = Bundle::new();
    let start = lens(1010.0, 12.0, -7.0, -0.09, 0.02);
    let unknowns = [Unknown::together(0, &[0, 1]), Unknown::parameter(1, 0)];
    let id = bundle.add_camera(start, &unknowns).unwrap();
    let shifted = |i: usize| Vector3::new(0.03, -0.02, 0.01) * ((i % 5) as f64 - 2.0);
    let images: Vec<_> = truth
        .iter()
        .enumerate()
        .map(|(i, e)| {
            let turn = Rotation3::from_scaled_axis(shifted(i) * 0.2);
            let center = e.projection_center() + shifted(i + 1);
            bundle.add_image(ExteriorOrientation::new(center, turn * e.camera_from_world()), id)
        })
        .collect::<Result<_, _>>()
        .unwrap();
    for (j, point) in points.iter().enumerate() {
        let p = bundle.add_point(point + shifted(j)).unwrap();
        for (i, exterior) in truth.iter().enumerate() {
            let at = camera.project_direction(&exterior.pose().apply(point).coords).unwrap();
            bundle.observe(images[i], p, at, Precision::Sigma(0.5)).unwrap();
        }
    }
    (bundle, truth, points, camera)
}

#[test]
fn exact_image_points_give_the_exact_block_up_to_a_similarity() {
    let case = &cases()[0];
    let (bundle, truth, points, camera) = exact(case);
    let adjusted = bundle.adjust(&BundleOptions::default()).unwrap();
    assert!(adjusted.convergence.final_cost < 1e-18, "{:?}", adjusted.convergence);
    for (a, b) in values(&adjusted.cameras()[0]).iter().zip(values(&camera)) {
        assert!((a - b).abs() < 1e-7 * b.abs().max(1.0), "{a} {b}");
    }
    // Ratios of distances, and angles of rays, are the truth's.
    let found = adjusted.points();
    let ratio = (found[0] - found[1]).norm() / (points[0] - points[1]).norm();
    for j in 2..points.len() {
        let here = (found[j] - found[0]).norm() / (points[j] - points[0]).norm();
        assert!((here / ratio - 1.0).abs() < 1e-8, "{here} {ratio}");
    }
    for (e, t) in adjusted.exteriors().iter().zip(&truth) {
        let angle = |e: &ExteriorOrientation, p: &[Point3<f64>]| {
            let ray =
                |k: usize| (e.camera_from_world() * (p[k] - e.projection_center())).normalize();
            (ray(0) - ray(5)).norm() + ray(3).x
        };
        assert!((angle(e, found) - angle(t, &points)).abs() < 1e-9);
    }
}

/// With a loss the gradient vanishes where the iteration ends: no small step of a point or centre lowers the cost.
#[test]
fn wrong_image_points_do_not_rule_a_robust_block() {
    let case = &cases()[0];
    let (mut bundle, _, points, camera) = exact(case);
    // A point of its own with one wrong ray among six.
    let ids: Vec<_> = bundle.image_ids().collect();
    let extra = bundle.add_point(points[0]).unwrap();
    let (_, truth, ..) = exact(case);
    for (i, exterior) in truth.iter().enumerate() {
        let at = camera.project_direction(&exterior.pose().apply(&points[0]).coords).unwrap();
        let off = if i == 2 { 80.0 } else { 0.0 };
        bundle
            .observe(ids[i], extra, at + nalgebra::Vector2::new(off, 0.0), Precision::Sigma(0.5))
            .unwrap();
    }
    let plain = bundle.adjust(&BundleOptions::default()).unwrap();
    assert!((values(&plain.cameras()[0])[0] - 1000.0).abs() > 0.1);
    for loss in [RobustLoss::Truncated { scale: 20.0 }, RobustLoss::Cauchy { scale: 0.01 }] {
        let robust = bundle.adjust(&BundleOptions { loss, ..Default::default() }).unwrap();
        let f = values(&robust.cameras()[0])[0];
        assert!((f - 1000.0).abs() < 0.01, "{loss:?} {f}");
    }
}

#[test]
fn what_has_no_image_is_left_out_or_kept_by_the_formula() {
    let case = &cases()[0];
    let (mut bundle, truth, ..) = exact(case);
    let images: Vec<_> = bundle.image_ids().collect();
    // A point ten units behind the first two photographs' middle, observed where the formula has it in the first two.
    let centre = truth[0].projection_center();
    let axis = truth[0].camera_from_world().inverse() * Vector3::z();
    let point = bundle.add_point(centre - axis * 10.0).unwrap();
    bundle.observe(images[0], point, Point2::new(12.0, -7.0), Precision::Sigma(0.5)).unwrap();
    let outside = bundle.adjust(&BundleOptions::default()).unwrap();
    let last = bundle.observation_count() - 1;
    assert_eq!(outside.excluded, [(last, Exclusion::BehindCamera)]);
    let residual = bundle.residual(&outside, last, OutsideRule::Exclude);
    assert!(matches!(residual, Err(Error::Projection(_))));
    // On the axis behind the camera the formula is at the principal point, as its approximate pose has it to a few pixels.
    let kept = bundle.residual(&outside, last, OutsideRule::Formula).unwrap();
    assert!(kept[0].hypot(kept[1]) < 100.0, "{kept:?}");
    // By the formula it is the only ray of its point, and left out for that.
    let options = BundleOptions { outside: OutsideRule::Formula, ..Default::default() };
    assert_eq!(bundle.adjust(&options).unwrap().excluded, [(last, Exclusion::SingleRay)]);
    bundle.observe(images[3], point, Point2::new(0.0, 0.0), Precision::Sigma(0.5)).unwrap();
    let kept = bundle.adjust(&options).unwrap();
    assert!(kept.excluded.is_empty());
    // Its two residuals belong to the cost at the start.
    assert!(kept.convergence.initial_cost > outside.convergence.initial_cost + 1.0);
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    for case in cases() {
        let (bundle, ..) = block(&case, false);
        for solver in [Solver::Dense, Solver::Sparse, Solver::Iterative] {
            let options = BundleOptions { solver, ..Default::default() };
            same_on_any_number_of_threads(|| bundle.adjust(&options).unwrap());
        }
    }
}

#[test]
fn a_block_moved_and_scaled_is_adjusted_to_the_same_block() {
    let case = &cases()[2];
    let (bundle, ..) = block(case, false);
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.4, -1.1, 0.3));
    let (scale, shift) = (250.0, Vector3::new(512_000.0, -43_000.0, 812.0));
    let moved = |p: &Point3<f64>| Point3::from(turn * p.coords * scale + shift);
    let (other, ..) = mapped_block(case, false, &moved, &turn);
    let options = BundleOptions::default();
    let (a, b) = (converged(&bundle, &options), converged(&other, &options));
    let ratio = a.convergence.final_cost / b.convergence.final_cost;
    assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    let length = |p: &[Point3<f64>], i: usize| (p[i] - p[0]).norm() / (p[1] - p[0]).norm();
    for i in 2..a.points().len() {
        assert!((length(a.points(), i) - length(b.points(), i)).abs() < 1e-6);
    }
}

#[test]
fn a_watcher_is_told_and_may_end_the_work() {
    let (bundle, ..) = block(&cases()[0], false);
    let mut told = vec![];
    let stopped = bundle
        .adjust_watched(&BundleOptions::default(), |progress| {
            told.push(progress.cost);
            if told.len() < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
        .unwrap();
    assert_eq!((told.len(), stopped.convergence.converged), (2, false));
    assert_eq!(stopped.convergence.final_cost, told[1]);
    assert!(told[1] < told[0] && told[0] < stopped.convergence.initial_cost);
}

#[test]
fn bad_input_is_refused() {
    let camera = lens(1000.0, 0.0, 0.0, 0.0, 0.0);
    let pose = ExteriorOrientation::new(Point3::new(0.0, 0.0, -10.0), Rotation3::identity());
    let mut bundle = Bundle::new();
    for unknowns in [
        vec![Unknown::parameter(0, 5)],
        vec![Unknown::parameter(2, 0)],
        vec![Unknown::group(0), Unknown::parameter(0, 1)],
        vec![Unknown::parameter(0, 0).observed(0.0)],
    ] {
        assert!(matches!(bundle.add_camera(camera, &unknowns), Err(Error::OutOfRange { .. })));
    }
    let id = bundle.add_camera(camera, &[]).unwrap();
    let image = bundle.add_image(pose, id).unwrap();
    // What belongs to another block.
    let mut other = Bundle::new();
    let far = other.add_camera(camera, &[]).unwrap();
    let far = (0..9).map(|_| other.add_image(pose, far).unwrap()).last().unwrap();
    let lost = (0..9).map(|_| other.add_point(Point3::origin()).unwrap()).last().unwrap();
    let point = bundle.add_point(Point3::origin()).unwrap();
    let at = Point2::origin();
    let unknown = |e: Result<(), Error>| assert!(matches!(e, Err(Error::Unknown { .. })), "{e:?}");
    unknown(bundle.observe(far, point, at, Precision::default()));
    unknown(bundle.observe(image, lost, at, Precision::default()));
    unknown(bundle.hold(far));
    unknown(bundle.observe_position(far, Point3::origin(), Vector3::zeros(), Precision::default()));
    unknown(bundle.observe_attitude(far, Rotation3::identity(), Precision::default()));
    unknown(bundle.observe_distance([point, lost], 1.0, 1.0));
    // NaN, points at infinity, infinite weights.
    for bad in [f64::NAN, f64::INFINITY] {
        let not_finite =
            |e: Option<Error>| assert!(matches!(e, Some(Error::NotFinite { .. })), "{e:?}");
        not_finite(bundle.add_point(Point3::new(0.0, bad, 0.0)).err());
        not_finite(bundle.add_fixed(Point3::new(0.0, 0.0, bad)).err());
        not_finite(bundle.add_control(Point3::new(bad, 0.0, 0.0), Precision::default()).err());
        not_finite(bundle.observe(image, point, Point2::new(bad, 0.0), Precision::default()).err());
        let exterior = ExteriorOrientation::new(Point3::new(bad, 0.0, 0.0), Rotation3::identity());
        not_finite(bundle.add_image(exterior, id).err());
        let turn = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal_element(bad));
        not_finite(bundle.observe_attitude(image, turn, Precision::default()).err());
        let given = Point3::new(0.0, bad, 0.0);
        not_finite(
            bundle.observe_position(image, given, Vector3::zeros(), Precision::default()).err(),
        );
    }
    for weight in [f64::INFINITY, 0.0, -1.0] {
        let e = bundle.observe(image, point, at, Precision::Weight(weight));
        assert!(matches!(e, Err(Error::OutOfRange { .. })), "{weight}");
    }
    for (length, sigma) in [(0.0, 1.0), (-1.0, 1.0), (f64::INFINITY, 1.0), (1.0, 0.0)] {
        let second = bundle.add_point(Point3::origin()).unwrap();
        let e = bundle.observe_distance([point, second], length, sigma);
        assert!(matches!(e, Err(Error::OutOfRange { .. })), "{length} {sigma}");
    }
    assert!(bundle.observe_distance([point, point], 1.0, 1.0).is_err());
    // Nothing observed, too little observed.
    let too_few = |b: &Bundle<Lens>| match b.adjust(&BundleOptions::default()) {
        Err(Error::TooFewPoints { needed: 3, got }) => got,
        other => panic!("{other:?}"),
    };
    assert_eq!(too_few(&Bundle::new()), 0);
    assert_eq!(too_few(&bundle), 0);
    let known: Vec<_> =
        (0..2).map(|i| bundle.add_fixed(Point3::new(f64::from(i), 0.0, 0.0)).unwrap()).collect();
    for p in known {
        bundle.observe(image, p, at, Precision::default()).unwrap();
    }
    assert_eq!(too_few(&bundle), 2);
}

#[test]
fn a_block_in_parts_is_refused_unless_each_is_placed() {
    let two = |placed: usize, control: [i32; 3]| {
        let camera = lens(1000.0, 0.0, 0.0, 0.0, 0.0);
        let mut bundle = Bundle::new();
        let id = bundle.add_camera(camera, &[]).unwrap();
        for part in 0..2 {
            let images: Vec<_> = (0..3)
                .map(|i| {
                    let center = Point3::new(2.0 * f64::from(i), 0.0, -10.0);
                    let exterior = ExteriorOrientation::new(center, Rotation3::identity());
                    bundle.add_image(exterior, id).unwrap()
                })
                .collect();
            for j in 0..8 {
                let at = Point3::new(f64::from(j % 3), f64::from(j / 3), f64::from(j % 4));
                let point = if part < placed && control.contains(&j) {
                    bundle.add_control(at, Precision::Sigma(0.01)).unwrap()
                } else {
                    bundle.add_point(at).unwrap()
                };
                for (i, image) in images.iter().enumerate() {
                    let depth = at.z + 10.0;
                    let x = 1000.0 * (at.x - 2.0 * i as f64) / depth + 0.1 * f64::from(j);
                    let at = Point2::new(x, 1000.0 * at.y / depth);
                    bundle.observe(*image, point, at, Precision::default()).unwrap();
                }
            }
        }
        bundle.adjust(&BundleOptions::default())
    };
    for placed in [0, 1] {
        match two(placed, [0, 1, 3]) {
            Err(Error::OutOfRange { value, .. }) => assert_eq!(value, 2.0),
            other => panic!("{other:?}"),
        }
    }
    assert!(two(2, [0, 1, 3]).unwrap().convergence.converged);
    // Three points on a line leave a turn about it open.
    assert!(matches!(two(2, [0, 1, 2]), Err(Error::OutOfRange { value: 2.0, .. })));
}

/// Two photographs have five numbers of their own, each point one more image coordinate than unknowns: with five points they are
/// determined up to a similarity (Kruppa 1913), with four they are not.
#[test]
fn two_photographs_need_five_points() {
    let pair = |points: i32, distances: &[[usize; 2]]| {
        let (mut bundle, mut ids, mut places) = (Bundle::new(), vec![], vec![]);
        let id = bundle.add_camera(lens(1000.0, 0.0, 0.0, 0.0, 0.0), &[]).unwrap();
        let images = [0.0, 2.0].map(|x| {
            let pose = ExteriorOrientation::new(Point3::new(x, 0.0, -10.0), Rotation3::identity());
            bundle.add_image(pose, id).unwrap()
        });
        for j in 0..points {
            let at = Point3::new(f64::from(j % 3), f64::from(j * j % 4), f64::from(j % 2));
            let point = bundle.add_point(at + Vector3::new(0.0, 0.0, 0.1)).unwrap();
            ids.push(point);
            places.push(at);
            for (image, x) in images.iter().zip([0.0, 2.0]) {
                let at = Point2::new(at.x - x, at.y) * (1000.0 / (at.z + 10.0));
                bundle.observe(*image, point, at, Precision::default()).unwrap();
            }
        }
        for [a, b] in distances {
            let length = (places[*a] - places[*b]).norm();
            bundle.observe_distance([ids[*a], ids[*b]], length, 0.01).unwrap();
        }
        bundle.adjust(&BundleOptions::default())
    };
    assert!(pair(5, &[]).unwrap().convergence.converged);
    let error = pair(4, &[]).unwrap_err();
    assert!(matches!(error, Error::TooFewPoints { needed: 9, got: 8 }), "{error}");
    // The first distance gives the scale, the second what a point is short of.
    assert!(matches!(pair(4, &[[0, 1]]), Err(Error::TooFewPoints { .. })));
    assert!(pair(4, &[[0, 1], [2, 3]]).is_ok());
}

/// The same image point twice with σ√2 each says what it says once with σ.
#[test]
fn a_repeated_observation_counts_twice() {
    let case = &cases()[3];
    let (once, ..) = block(case, false);
    let mut doubled = case.clone();
    let list = doubled["observations"].as_array_mut().unwrap();
    for o in list.iter_mut() {
        for k in 4..8 {
            o[k] = Value::from(2.0 * o[k].as_f64().unwrap());
        }
    }
    let again = list.clone();
    list.extend(again);
    let (twice, ..) = block(&doubled, false);
    for solver in [Solver::Dense, Solver::Iterative] {
        let options = BundleOptions { solver, ..Default::default() };
        let (a, b) = (converged(&once, &options), converged(&twice, &options));
        for (p, q) in a.points().iter().zip(b.points()) {
            assert!((p - q).norm() < 1e-6, "{p} {q}");
        }
    }
    let options = BundleOptions::default();
    let how = BundleReportOptions { estimate_sigma: false, ..Default::default() };
    let (a, b) = (converged(&once, &options), converged(&twice, &options));
    let (a, b) =
        (once.report(&a, &options, &how).unwrap(), twice.report(&b, &options, &how).unwrap());
    assert_eq!(b.redundancy, a.redundancy + a.image_points.len() * 2);
    for point in once.point_ids() {
        let (p, q) = (a.point_covariance(point).unwrap(), b.point_covariance(point).unwrap());
        assert!((p - q).norm() <= 1e-6 * p.norm());
    }
}

/// `tests/data/oracles/bundle.py`: Helmert's components by scoring of the restricted likelihood, all unknowns in one matrix.
#[test]
fn variance_components_are_those_of_the_restricted_likelihood() {
    let all = cases();
    let case = all.iter().find(|c| !c["groups"].is_null()).unwrap();
    let (bundle, images, _) = block(case, false);
    let observations = rows(&case["observations"]);
    let group = |of: Observation| match of {
        Observation::ImagePoint(i) => {
            if observations[i][0] < 3.0 {
                0
            } else {
                5
            }
        }
        Observation::ControlPoint(_) => 1,
        Observation::Position(_) => 2,
        Observation::Attitude(_) => 3,
        _ => 4,
    };
    let (options, how) = (BundleOptions::default(), BundleReportOptions::default());
    let estimate = bundle.estimate_variances(&options, &how, group).unwrap();
    let expected = numbers(&case["factors"]);
    assert_eq!(estimate.factors.len(), 5);
    for (group, factor) in &estimate.factors {
        assert!(
            (factor / expected[*group] - 1.0).abs() < 1e-5,
            "{group}: {factor} {}",
            expected[*group]
        );
    }
    assert!((estimate.report.sigma0.unwrap() - 1.0).abs() < 1e-6);
    assert!(
        (estimate.adjusted.convergence.final_cost / case["cost"].as_f64().unwrap() - 1.0).abs()
            < 1e-5
    );
    // The block with these precisions says so itself; a photograph's deviations are the oracle's.
    let found = estimate.report.image_covariance(images[1]).unwrap();
    agrees(
        &found.view((0, 0), (6, 6)).into_owned(),
        &rows(&case["image_covariances"])[1],
        1e-3,
        "variances",
    );
    let components = estimate.report.variance_components(group);
    let redundancy: f64 = components.iter().map(|c| c.redundancy).sum();
    assert!((redundancy / estimate.report.redundancy as f64 - 1.0).abs() < 1e-9);
    for c in components {
        assert!((c.sigma.unwrap() - 1.0).abs() < 1e-6 && c.uncertainty() > 0.0, "{c:?}");
    }
    // One group: σ₀ itself.
    let adjusted = bundle.adjust(&options).unwrap();
    let report = bundle.report(&adjusted, &options, &how).unwrap();
    let [whole] = report.variance_components(|_| usize::MAX)[..] else { panic!() };
    assert!((whole.sigma.unwrap() / report.sigma0.unwrap() - 1.0).abs() < 1e-9);
    // All observations one group: the precisions become what σ₀ made of them, and no test changes.
    let (given, ..) = block(&all[0], false);
    let adjusted = given.adjust(&options).unwrap();
    let before = given.report(&adjusted, &options, &how).unwrap();
    let after = given.estimate_variances(&options, &how, |_| 7).unwrap();
    assert!((after.factors[0].1 / before.sigma0.unwrap() - 1.0).abs() < 1e-6);
    for ((of, a), (_, b)) in before.numbers().zip(after.report.numbers()) {
        assert!((a.w - b.w).abs() < 1e-5 && a.residual.abs() > 0.0, "{of:?}: {a:?} {b:?}");
    }
    // A distance that nothing else controls has no component.
    let (free, ..) = block(&all[1], false);
    let alone = |of| usize::from(matches!(of, Observation::Distance(_)));
    let how = BundleReportOptions { datum: Datum::Free, ..how };
    let error = free.estimate_variances(&options, &how, alone).unwrap_err();
    let Error::UnknownPrecision { group: 1, redundancy, factor } = error else { panic!("{error}") };
    assert!(redundancy.abs() < 1e-6 && factor == 1.0, "{error}");
}

/// A distance that agrees with the rest: the more precise, the better it is explained.
#[test]
fn a_variance_that_goes_to_zero_is_an_error_of_its_group() {
    let (bundle, ..) = block(&cases()[0], false);
    let options = BundleOptions::default();
    let adjusted = bundle.adjust(&options).unwrap();
    let ids: Vec<_> = bundle.point_ids().collect();
    let [from, to] = [ids[0], ids[7]].map(|id| adjusted.point(id).unwrap());
    let last = rows(&cases()[0]["distances"]).len();
    let group = |of| usize::from(of == Observation::Distance(last));
    for (off, least, most) in [(0.002, 1e-6, 0.01), (1e-9, 0.0, 1e-6)] {
        let mut bundle = bundle.clone();
        bundle.observe_distance([ids[0], ids[7]], (to - from).norm() + off, 0.01).unwrap();
        let how = BundleReportOptions::default();
        let error = bundle.estimate_variances(&options, &how, group).unwrap_err();
        let Error::UnknownPrecision { group: 1, factor, .. } = error else { panic!("{error}") };
        assert!(factor > least && factor < most, "{error}");
    }
}

/// Three points place a block as all do: its redundancy numbers stay.
#[test]
fn datum_points_that_cannot_place_a_block_are_refused() {
    let case = &cases()[2];
    let (bundle, _, points) = block(case, false);
    let options = BundleOptions::default();
    let adjusted = converged(&bundle, &options);
    let report = |datum| {
        bundle.report(&adjusted, &options, &BundleReportOptions { datum, ..Default::default() })
    };
    let free = report(Datum::Free).unwrap();
    let by_three = report(Datum::Points(&points[..3])).unwrap();
    for (a, b) in free.numbers().zip(by_three.numbers()) {
        assert!(a.0 == b.0 && (a.1.redundancy - b.1.redundancy).abs() < 1e-12);
    }
    // The smallest trace is that of all points.
    let trace = |r: &BundleReport| -> f64 {
        points.iter().map(|p| r.point_covariance(*p).unwrap().trace()).sum()
    };
    assert!(trace(&by_three) > 1.1 * trace(&free));
    let all = report(Datum::Points(&points)).unwrap();
    assert!((trace(&all) / trace(&free) - 1.0).abs() < 1e-9);
    let twice = [points[0], points[1], points[0]];
    assert!(matches!(report(Datum::Points(&twice)), Err(Error::TooFewPoints { got: 2, .. })));
    assert!(matches!(report(Datum::Points(&[])), Err(Error::TooFewPoints { got: 0, .. })));
    // On a line.
    let (mut other, images, _) = block(case, false);
    let line: Vec<PointId> = (0..4)
        .map(|i| {
            let at = Point3::new(f64::from(i), 0.5 * f64::from(i), 0.1);
            let id = other.add_point(at).unwrap();
            for image in &images {
                let pose = *adjusted.exterior(*image).unwrap();
                let image_point = adjusted.cameras()[0]
                    .project_direction(&pose.pose().apply(&at).coords)
                    .unwrap();
                other.observe(*image, id, image_point, Precision::Sigma(0.5)).unwrap();
            }
            id
        })
        .collect();
    let adjusted = converged(&other, &options);
    let how = BundleReportOptions { datum: Datum::Points(&line), ..Default::default() };
    let error = other.report(&adjusted, &options, &how).unwrap_err();
    assert!(matches!(error, Error::Degenerate { .. }), "{error}");
    let mut larger = other.clone();
    let beyond: Vec<_> = (0..9).map(|_| larger.add_point(Point3::origin()).unwrap()).collect();
    let how = BundleReportOptions { datum: Datum::Points(&beyond), ..Default::default() };
    let error = other.report(&adjusted, &options, &how).unwrap_err();
    assert!(matches!(error, Error::Unknown { .. }), "{error}");
}

#[test]
fn check_points_tell_how_far_the_block_is_off() {
    let case = &cases()[0];
    let (mut bundle, images, points) = block(case, false);
    let lonely = bundle.add_point(Point3::new(0.0, 0.0, 0.5)).unwrap();
    // One ray measured twice is one ray.
    for _ in 0..2 {
        bundle.observe(images[0], lonely, Point2::new(3.0, 4.0), Precision::default()).unwrap();
    }
    let adjusted = bundle.adjust(&BundleOptions::default()).unwrap();
    assert_eq!(adjusted.undetermined, [lonely]);
    assert_eq!(adjusted.excluded.len(), 2);
    let at = |i: usize| *adjusted.point(points[i]).unwrap();
    let known = [
        (points[8], at(8) - Vector3::new(0.1, 0.0, 0.0)),
        (lonely, Point3::origin()),
        (points[9], at(9) - Vector3::new(0.3, 0.0, -0.4)),
    ];
    let check = adjusted.check(&known).unwrap();
    assert_eq!(check.undetermined, [lonely]);
    assert!((check.mean - Vector3::new(0.2, 0.0, -0.2)).norm() < 1e-12);
    // √((0.01 + 0.09)/2), 0, √(0.16/2).
    let rms = Vector3::new(0.05_f64.sqrt(), 0.0, 0.08_f64.sqrt());
    assert!((check.rms - rms).norm() < 1e-12 && (check.largest - 0.5).abs() < 1e-12);
    assert!(matches!(adjusted.check(&[]), Err(Error::TooFewPoints { .. })));
    let bad = [(points[0], Point3::new(f64::NAN, 0.0, 0.0))];
    assert!(matches!(adjusted.check(&bad), Err(Error::NotFinite { .. })));
}

/// With the loss's own curvature in the steps, Newton's convergence takes the place of a linear one. The costs of the first case are those
/// that `tests/data/oracles/bundle.py` reaches by hundreds of reweighted steps.
#[test]
fn robust_losses_converge_in_few_steps() {
    let known = &cases()[0]["robust"];
    for (loss, expected, steps) in [
        (RobustLoss::Huber { scale: 1.0 }, known["huber"].as_f64(), 150),
        (RobustLoss::Cauchy { scale: 1.0 }, known["cauchy"].as_f64(), 310),
        (RobustLoss::Tukey { scale: 4.685 }, None, 230),
    ] {
        let mut sum = 0;
        for (i, case) in cases().iter().enumerate() {
            let (bundle, ..) = block(case, false);
            let adjusted = bundle.adjust(&BundleOptions { loss, ..Default::default() }).unwrap();
            let end = adjusted.convergence;
            assert!(end.converged, "{loss:?} {}: {end:?}", case["name"]);
            if let (0, Some(expected)) = (i, expected) {
                let off = end.final_cost / expected - 1.0;
                assert!(off.abs() < 1e-11, "{loss:?}: {end:?} {expected}");
            }
            sum += end.iterations;
        }
        // Reweighted steps alone take about three times as many.
        assert!(sum < steps, "{loss:?}: {sum}");
    }
}

/// Attitudes and a single position leave the scale open: a report that rounding alone decides is refused.
#[test]
fn what_places_a_block_in_part_is_no_datum() {
    let case = &cases()[2];
    let (plain, images, _) = block(case, false);
    let options = BundleOptions::default();
    let adjusted = converged(&plain, &options);
    let mut bundle = plain.clone();
    for (i, image) in images.iter().enumerate() {
        let pose = adjusted.exterior(*image).unwrap();
        let turn = pose.camera_from_world();
        bundle.observe_attitude(*image, turn, Precision::Sigma(1e-4)).unwrap();
        if i < 1 {
            let given = pose.projection_center();
            bundle
                .observe_position(*image, given, Vector3::zeros(), Precision::Sigma(0.01))
                .unwrap();
        }
    }
    let adjusted = bundle.adjust(&options).unwrap();
    let error = bundle.report(&adjusted, &options, &BundleReportOptions::default());
    assert!(matches!(error, Err(Error::Degenerate { .. })), "{error:?}");
    // What is no rotation is refused.
    let twice = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal_element(2.0));
    let error = bundle.observe_attitude(images[0], twice, Precision::default()).unwrap_err();
    assert!(matches!(error, Error::Inconsistent { .. }), "{error}");
}

#[test]
fn a_held_photograph_stays() {
    let case = &cases()[2];
    let (mut bundle, images, _) = block(case, false);
    let held = [images[0], images[3]];
    for image in held {
        bundle.hold(image).unwrap();
    }
    let adjusted = converged(&bundle, &BundleOptions::default());
    let report = bundle
        .report(&adjusted, &BundleOptions::default(), &BundleReportOptions::default())
        .unwrap();
    for image in held {
        let centre = rows(&case["start"]["centres"])[image.number()].clone();
        assert_eq!(adjusted.exterior(image).unwrap().projection_center(), three(&centre));
        assert_eq!(report.image_covariance(image).unwrap().norm(), 0.0);
    }
    // 12 numbers of the two are no unknowns; scale and place are given by them.
    assert_eq!(report.unknowns, 4 * 6 + 3 * adjusted.points().len());
    assert!((report.redundancy_sum() / report.redundancy as f64 - 1.0).abs() < 1e-9);
}
