//! What space resection refuses, each with its error, and what it still does at the edges.

use collinear::adjust::{ControlPoint, Precision, ResectionOptions, Unknown, resect, resect_from};
use collinear::camera::{
    Brown, BrownCamera, CentralCamera, ExteriorOrientation, Fisheye, Frame, InteriorOrientation,
    Panorama,
};
use collinear::numeric::robust_loss::RobustLoss;
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix2, Matrix3, Point2, Point3, Rotation3, Vector2, Vector3};

/// c = 1000 px, principal point (500, 400).
fn camera() -> InteriorOrientation {
    InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap()
}

/// The camera at the origin that looks along Z: the images are x = 500 + 1000 X/Z, y = 400 + 1000 Y/Z.
fn seen(points: &[[f64; 3]]) -> Vec<ControlPoint> {
    let image = |p: &[f64; 3]| Point2::new(500.0 + 1e3 * p[0] / p[2], 400.0 + 1e3 * p[1] / p[2]);
    points.iter().map(|p| ControlPoint::new(Point3::from(*p), image(p))).collect()
}

const SIX: [[f64; 3]; 6] = [
    [-1.0, -1.0, 5.0],
    [1.0, -0.8, 6.0],
    [0.9, 1.0, 4.5],
    [-1.1, 0.7, 5.5],
    [0.2, 0.1, 7.0],
    [0.5, -0.3, 4.0],
];

fn error(control: &[ControlPoint]) -> Error {
    error_with(control, &ResectionOptions::default())
}

fn error_with(control: &[ControlPoint], options: &ResectionOptions) -> Error {
    let error = resect(&camera(), control, options).unwrap_err();
    assert!(!error.to_string().is_empty());
    error
}

/// The error of [`resect_from`] with the right camera as its start.
fn error_from(control: &[ControlPoint], options: &ResectionOptions) -> Error {
    resect_from(&level(camera()), control, options).unwrap_err()
}

fn level<C>(camera: C) -> Frame<C> {
    Frame::new(ExteriorOrientation::new(Point3::origin(), Rotation3::identity()), camera)
}

fn unknowns(list: &[Unknown]) -> ResectionOptions {
    ResectionOptions { unknowns: list.to_vec(), ..ResectionOptions::default() }
}

#[test]
fn six_points_are_enough_to_start_from() {
    let found = resect(&camera(), &seen(&SIX), &ResectionOptions::default()).unwrap();
    assert!(found.sensor.exterior.projection_center().coords.amax() < 1e-12);
    assert!(found.report.sigma0.unwrap() < 1e-11);
}

#[test]
fn too_few_points_are_counted() {
    for n in 0..4 {
        let error = error(&seen(&SIX[..n]));
        assert_eq!(error, Error::TooFewPoints { needed: 4, got: n });
    }
    // Duplicates count once.
    let mut control = seen(&SIX[..3]);
    control.extend(seen(&SIX[..3]));
    control.extend(seen(&SIX[..2]));
    assert_eq!(error(&control), Error::TooFewPoints { needed: 4, got: 3 });
    // With a start two observations a point are enough: three points for six unknowns.
    let three = seen(&SIX[..3]);
    let options = ResectionOptions::default();
    let found = resect_from(&level(camera()), &three, &options).unwrap();
    assert_eq!((found.report.redundancy, found.report.sigma0), (0, None));
    assert_eq!(found.report.sigma, 1.0);
    assert_eq!(found.report.most_suspect(), None);
    for value in &found.report.values {
        assert!(value.w.is_nan() && value.redundancy.abs() < 1e-9);
        assert!(value.detectable == f64::INFINITY && value.influence == f64::INFINITY);
    }
    assert_eq!(error_from(&three[..2], &options), Error::TooFewPoints { needed: 3, got: 2 });
    assert_eq!(error_from(&[], &options), Error::TooFewPoints { needed: 3, got: 0 });
    assert_eq!(error_from(&[], &unknowns(&[])), Error::TooFewPoints { needed: 1, got: 0 });
}

#[test]
fn more_unknowns_than_observations_are_refused() {
    let all = [Unknown::group(0), Unknown::group(1)];
    for n in [4, 5] {
        let error = error_with(&seen(&SIX[..n]), &unknowns(&all));
        assert_eq!(error, Error::TooFewPoints { needed: 6, got: n });
    }
    // An observed unknown brings an equation with it.
    let observed = [Unknown::group(0), Unknown::group(1).observed(0.1)];
    let control = seen(&SIX[..4]);
    let found = resect(&camera(), &control, &unknowns(&observed)).unwrap();
    assert_eq!((found.report.observations, found.report.unknowns), (13, 11));
    assert_eq!(found.report.redundancy, 2);
    // Enough equations, but a plane seen from straight above does not tell the distance from c.
    let flat: Vec<[f64; 3]> = SIX.iter().map(|p| [p[0], p[1], 5.0]).collect();
    let both = [Unknown::group(0), Unknown::together(1, &[0, 1])];
    match error_with(&seen(&flat), &unknowns(&both)) {
        Error::Degenerate { what, measure, limit } => {
            assert!(what.starts_with("normal equations") && measure <= limit, "{what} {measure}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn points_on_a_line_are_refused_in_small_and_in_raw_coordinates() {
    let line = |offset: Vector3<f64>, step: Vector3<f64>, n: i32| -> Vec<ControlPoint> {
        (0..n)
            .map(|i| {
                let object = Point3::from(offset + step * (f64::from(i) - 2.0));
                ControlPoint::new(object, Point2::new(400.0 + 50.0 * f64::from(i), 300.0))
            })
            .collect()
    };
    let steps = [Vector3::new(0.3, 0.1, 0.07), Vector3::x(), Vector3::new(0.0, 1e-3, 0.0)];
    for offset in [Vector3::zeros(), Vector3::new(1e6, 5e6, 300.0), Vector3::new(-3e-7, 0.0, 0.1)] {
        for step in steps {
            for n in [4, 9] {
                let mut control = line(offset, step * 100.0, n);
                for twice in [false, true] {
                    if twice {
                        control.push(control[1]);
                    }
                    match error(&control) {
                        Error::Degenerate { what, measure, limit } => {
                            assert_eq!(what, "resection: control points on a line");
                            assert!(measure <= limit && limit < 1e-7, "{measure} {limit}");
                        }
                        other => panic!("{other:?}"),
                    }
                }
            }
        }
    }
    // A bend of a part in 10⁶ is a bend: whatever comes of it, it is not called a line.
    let mut bent = line(Vector3::zeros(), Vector3::x() * 100.0, 6);
    bent[3].object.y += 1e-3;
    if let Err(Error::Degenerate { what, .. }) =
        resect(&camera(), &bent, &ResectionOptions::default())
    {
        assert!(!what.contains("on a line"));
    }
}

#[test]
fn precisions_that_are_none_are_refused() {
    let number = "a positive number";
    let out = |what, value| Error::OutOfRange { what, value, expected: number };
    let with = |precision| {
        let mut control = seen(&SIX);
        control[2] = control[2].with_precision(precision);
        error(&control)
    };
    assert_eq!(with(Precision::Weight(f64::INFINITY)), out("weight", f64::INFINITY));
    assert_eq!(with(Precision::Weight(0.0)), out("weight", 0.0));
    assert_eq!(with(Precision::Weight(-2.0)), out("weight", -2.0));
    assert_eq!(with(Precision::Weight(f64::NAN)), Error::NotFinite { what: "weight" });
    // 10⁻³¹⁰ is a number, one over it is not.
    assert_eq!(with(Precision::Weight(1e-310)), out("weight", f64::INFINITY));
    let sigma = "standard deviation";
    assert_eq!(with(Precision::Sigma(0.0)), out(sigma, 0.0));
    assert_eq!(with(Precision::Sigma(-1.0)), out(sigma, -1.0));
    assert_eq!(with(Precision::Sigma(f64::INFINITY)), out(sigma, f64::INFINITY));
    assert_eq!(with(Precision::Sigma(f64::NAN)), Error::NotFinite { what: sigma });
    assert_eq!(with(Precision::Sigmas([1.0, 0.0])), out(sigma, 0.0));
    for value in [1e-200, 1e200] {
        let expected = "a number whose square is a number";
        let error = Error::OutOfRange { what: sigma, value, expected };
        assert_eq!(with(Precision::Sigma(value)), error);
    }
    let matrix = |a, b, c, d| with(Precision::Covariance(Matrix2::new(a, b, c, d)));
    assert_eq!(matrix(1.0, 0.0, 0.0, 0.0), out("variance", 0.0));
    assert_eq!(matrix(-1.0, 0.0, 0.0, 1.0), out("variance", -1.0));
    let nan = Error::NotFinite { what: "covariance matrix" };
    assert_eq!(matrix(1.0, f64::NAN, 0.0, 1.0), nan);
    assert_eq!(matrix(f64::INFINITY, 0.0, 0.0, 1.0), nan);
    let halves = "halves of a covariance matrix";
    let asymmetric = Error::Inconsistent { what: halves, residual: 0.5, limit: 2e-9 };
    assert_eq!(matrix(1.0, 0.5, 1.0, 4.0), asymmetric);
    match matrix(1.0, 2.0, 2.0, 1.0) {
        Error::Degenerate { what: "covariance matrix", measure, limit } => {
            // The second pivot: 1 − 2².
            assert!(measure == -3.0 && limit == 16.0 * f64::EPSILON);
        }
        other => panic!("{other:?}"),
    }
    // Correlation one: the pivot is zero.
    assert!(matches!(matrix(4.0, 6.0, 6.0, 9.0), Error::Degenerate { measure: 0.0, .. }));

    // Of the object point too: positive definite by each plane, not in space.
    let object = |precision| {
        let mut control = seen(&SIX);
        control[5] = control[5].with_object_precision(precision);
        error(&control)
    };
    let c = Matrix3::new(1.0, -0.6, -0.6, -0.6, 1.0, -0.6, -0.6, -0.6, 1.0);
    match object(Precision::Covariance(c)) {
        // 1 − 0.36 − (0.6 + 0.36)² / 0.64
        Error::Degenerate { measure, .. } => assert!((measure + 0.8).abs() < 1e-15, "{measure}"),
        other => panic!("{other:?}"),
    }
    assert_eq!(object(Precision::Weight(0.0)), out("weight", 0.0));
    let error = error_with(&seen(&SIX), &unknowns(&[Unknown::group(0).observed(0.0)]));
    assert_eq!(error, out(sigma, 0.0));
    assert!(
        error_from(&seen(&SIX), &unknowns(&[Unknown::group(0).observed(f64::NAN)]))
            == Error::NotFinite { what: sigma }
    );
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..5 {
            let mut control = seen(&SIX);
            let what = if i < 3 {
                control[4].object[i] = bad;
                "control point"
            } else {
                control[4].image[i - 3] = bad;
                "image point"
            };
            assert_eq!(error(&control), Error::NotFinite { what });
            let options = ResectionOptions::default();
            assert_eq!(error_from(&control, &options), Error::NotFinite { what });
        }
    }
}

/// A start that is no pose is a start that leads nowhere: the others do.
#[test]
fn a_start_that_is_no_pose_does_no_harm() {
    let right = resect(&camera(), &seen(&SIX), &ResectionOptions::default()).unwrap();
    for center in [f64::NAN, f64::INFINITY, 1e300, 6.0] {
        let start = ExteriorOrientation::new(Point3::new(0.0, 0.0, center), Rotation3::identity());
        let options = ResectionOptions { start: Some(start), ..ResectionOptions::default() };
        let found = resect(&camera(), &seen(&SIX), &options).unwrap();
        let off =
            found.sensor.exterior.projection_center() - right.sensor.exterior.projection_center();
        assert!(off.amax() < 1e-12, "{center}: {off}");
    }
}

#[test]
fn points_at_infinity_are_refused() {
    let far = |value: f64| {
        let mut control = seen(&SIX);
        control[1].object.x = value;
        control
    };
    let extent = Error::NotFinite { what: "extent of the control points" };
    for value in [1e200, -1e300, f64::MAX] {
        assert_eq!(error(&far(value)), extent);
    }
    // From so far away the others are one point.
    for value in [1e20, 1e100, 1e150] {
        let error = error(&far(value));
        assert!(matches!(error, Error::Degenerate { .. }), "{value}: {error:?}");
    }
    let options = ResectionOptions::default();
    for value in [1e100, 1e200, f64::MAX] {
        let error = error_from(&far(value), &options);
        let told = matches!(
            error,
            Error::Degenerate { .. }
                | Error::NotConverged { .. }
                | Error::NotFinite { .. }
                | Error::Projection(_)
        );
        assert!(told, "{value}: {error:?}");
    }
}

/// Six of ten points are somewhere else and say so.
#[test]
fn points_of_little_weight_lead_no_start_astray() {
    let mut places = SIX[..4].to_vec();
    places.extend(SIX.map(|[x, y, z]| [1.3 * y, -0.9 * x, z + 0.5 * x]));
    let mut control = seen(&places);
    for (i, point) in control[4..].iter_mut().enumerate() {
        let turned = Vector2::new(1000.0 - point.image.x, 800.0 - point.image.y);
        point.image = Point2::from(turned * (1.0 + 0.1 * i as f64));
        *point = point.with_precision(Precision::Sigma(1e8));
    }
    let found = resect(&camera(), &control, &ResectionOptions::default()).unwrap();
    let center = found.sensor.exterior.projection_center();
    assert!(center.coords.amax() < 1e-8, "{center}");
    let turn = found.sensor.exterior.camera_from_world().matrix() - Matrix3::identity();
    assert!(turn.amax() < 1e-8, "{turn}");
}

#[test]
fn unknowns_that_the_model_has_not_are_refused() {
    let of = |list: &[Unknown]| {
        let (a, b) =
            (error_with(&seen(&SIX), &unknowns(list)), error_from(&seen(&SIX), &unknowns(list)));
        assert_eq!(a, b);
        a
    };
    let group = |value| Error::OutOfRange {
        what: "parameter group of an unknown",
        value,
        expected: "a group that the model has",
    };
    assert_eq!(of(&[Unknown::group(2)]), group(2.0));
    assert_eq!(of(&[Unknown::group(0), Unknown::parameter(7, 0)]), group(7.0));
    let parameter = |value| Error::OutOfRange {
        what: "parameter of an unknown",
        value,
        expected: "a parameter that the group has",
    };
    assert_eq!(of(&[Unknown::parameter(0, 6)]), parameter(6.0));
    assert_eq!(of(&[Unknown::together(1, &[0, 5])]), parameter(5.0));
    assert_eq!(of(&[Unknown::together(1, &[9, 0])]), parameter(9.0));
    assert_eq!(of(&[Unknown::together(1, &[])]), Error::TooFewPoints { needed: 1, got: 0 });
    let twice = |value| Error::OutOfRange {
        what: "parameter chosen twice",
        value,
        expected: "each parameter in one unknown",
    };
    assert_eq!(of(&[Unknown::group(0), Unknown::parameter(0, 4)]), twice(4.0));
    assert_eq!(of(&[Unknown::together(1, &[0, 1]), Unknown::parameter(1, 1)]), twice(1.0));
    assert_eq!(of(&[Unknown::together(1, &[3, 3])]), twice(3.0));
    // The same number in another group is another parameter.
    let apart = [Unknown::group(0), Unknown::parameter(1, 2)];
    assert!(resect(&camera(), &seen(&SIX), &unknowns(&apart)).is_ok());
    let apart = [Unknown::parameter(0, 2), Unknown::parameter(1, 2)];
    assert!(resect_from(&level(camera()), &seen(&SIX), &unknowns(&apart)).is_ok());
}

#[test]
fn no_unknown_at_all_leaves_the_camera_as_it_is() {
    let found = resect_from(&level(camera()), &seen(&SIX), &unknowns(&[])).unwrap();
    assert_eq!((found.report.unknowns, found.report.redundancy), (0, 12));
    assert_eq!(found.sensor, level(camera()));
}

#[test]
fn image_points_that_are_all_one_are_refused() {
    let mut control = seen(&SIX);
    for point in &mut control {
        point.image = Point2::new(312.0, 288.0);
    }
    match error(&control) {
        Error::Degenerate { what, measure, limit } => {
            assert_eq!(what, "resection: directions of the image points");
            assert!((0.0..=limit).contains(&measure) && limit < 1e-14, "{measure} {limit}");
        }
        other => panic!("{other:?}"),
    }
    // A picture of a thousandth of a pixel is a picture.
    for (i, point) in control.iter_mut().enumerate() {
        point.image.x += 1e-3 * SIX[i][0];
        point.image.y += 1e-3 * SIX[i][1];
    }
    assert!(resect(&camera(), &control, &ResectionOptions::default()).is_ok());
}

#[test]
fn points_behind_the_start_are_refused() {
    let mut start = level(camera());
    start.exterior = ExteriorOrientation::new(Point3::new(0.0, 0.0, 20.0), Rotation3::identity());
    let error = resect_from(&start, &seen(&SIX), &ResectionOptions::default()).unwrap_err();
    // The first point's depth is 5 − 20.
    assert_eq!(error, Error::Projection(ProjectionError::BehindCamera { depth: -15.0 }));
}

/// Images that fit one pose only, which has points behind it: there no camera has seen them.
#[test]
fn points_behind_every_pose_are_refused() {
    let mut places = SIX.to_vec();
    places.extend(SIX.map(|[x, y, z]| [y - x, x, -0.7 * z]));
    match error(&seen(&places)) {
        Error::Projection(ProjectionError::BehindCamera { depth }) => {
            assert!((depth + 3.5).abs() < 1e-9, "{depth}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn image_points_outside_the_lens_are_refused() {
    // k₁ = −0.5 folds at r = √(2/3), at 0.5443 in the image: 544 px from the principal point.
    let lens = Brown::new([-0.5, 0.0, 0.0], [0.0; 2]).unwrap();
    let folded = BrownCamera::new(camera(), lens);
    let mut control = seen(&SIX);
    control[3].image = Point2::new(500.0 + 700.0, 400.0);
    let error = resect(&folded, &control, &ResectionOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Projection(ProjectionError::OutsideDomain { .. })), "{error:?}");
    // A fisheye of 300 px a radian ends at half a turn, 942 px.
    let round = InteriorOrientation::new([300.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let fisheye = CentralCamera::ideal(round, Fisheye::Equidistant);
    control[3].image = Point2::new(500.0 + 1000.0, 400.0);
    let error = resect(&fisheye, &control, &ResectionOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Projection(_)), "{error:?}");
}

#[test]
fn losses_without_a_scale_are_refused() {
    for scale in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        for loss in [
            RobustLoss::Huber { scale },
            RobustLoss::Cauchy { scale },
            RobustLoss::Tukey { scale },
            RobustLoss::Truncated { scale },
        ] {
            let options = ResectionOptions { loss, ..ResectionOptions::default() };
            for error in [error_with(&seen(&SIX), &options), error_from(&seen(&SIX), &options)] {
                match error {
                    Error::NotFinite { what: "scale of a robust loss" } => assert!(scale.is_nan()),
                    Error::OutOfRange { what: "scale of a robust loss", value, expected } => {
                        assert_eq!((value, expected), (scale, "a positive number"));
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }
}

#[test]
fn an_iteration_that_may_not_end_says_how_far_it_came() {
    let mut options = ResectionOptions::default();
    options.least_squares.max_iterations = 1;
    let mut control = seen(&SIX);
    control[0].image += Vector2::new(30.0, -20.0);
    control[4].image += Vector2::new(-25.0, 20.0);
    match error_with(&control, &options) {
        Error::NotConverged { iterations: 1, cost } => assert!(cost > 0.0 && cost < 1e4, "{cost}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_full_panorama_resects_from_points_all_around() {
    let interior = InteriorOrientation::from_whole_panorama(6000.0, 3000.0).unwrap();
    let camera = CentralCamera::ideal(interior, Panorama::Equirectangular);
    // East, north (behind), west, ahead, up and down: λ = atan2(X, Z), φ = atan2(Y, ‖(X, Z)‖) at 6000/2π px a radian.
    let px = 6000.0 / std::f64::consts::TAU;
    let places =
        [[4.0, 0.0, 0.0], [1.0, 0.5, -3.0], [-4.0, 1.0, 0.5], [0.3, -0.2, 5.0], [0.5, -4.0, 0.5]];
    let control = places.map(|[x, y, z]: [f64; 3]| {
        let (longitude, latitude) = (x.atan2(z), y.atan2(x.hypot(z)));
        ControlPoint::new(
            Point3::new(x, y, z),
            Point2::new(3000.0 + px * longitude, 1500.0 + px * latitude),
        )
    });
    let found = resect(&camera, &control, &ResectionOptions::default()).unwrap();
    assert!(found.sensor.exterior.projection_center().coords.amax() < 1e-12);
}
