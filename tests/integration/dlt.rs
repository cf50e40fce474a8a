//! Cameras from linear equations.

use collinear::adjust::dlt;
use collinear::camera::{Frame, SensorModel};
use collinear::{Error, ExteriorOrientation, InteriorOrientation, ProjectionError};
use nalgebra::{Matrix3x4, Point2, Point3, Vector3};

use crate::support::{matrix3, numbers, points3};

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/oracles/dlt.json")).unwrap()
}

fn points2(value: &serde_json::Value) -> Vec<Point2<f64>> {
    numbers(value).chunks(2).map(Point2::from_slice).collect()
}

#[test]
fn exact_pictures_give_the_camera_that_made_them() {
    let mut seen = 0;
    for case in oracle()["cases"].as_array().unwrap().iter().filter(|c| !c["k"].is_null()) {
        let (object, image) = (points3(&case["object"]), points2(&case["image"]));
        let found = dlt(&object, &image).unwrap();
        let k = matrix3(&case["k"]);
        let center = points3(&case["center"])[0];
        let range = (center - object[0]).norm();
        // The first two are of fair shape; the others are flat, and one has map coordinates that a picture cannot hold to 10⁻¹⁰.
        let slack = if seen < 2 { 1e-11 } else { 1e-6 };
        assert!((found.frame.camera.matrix() - k).norm() < slack * k.norm(), "{seen}");
        let turned = found.frame.exterior.camera_from_world();
        assert!((turned.matrix() - matrix3(&case["rotation"])).norm() < slack, "{seen}");
        let shift = (found.frame.exterior.projection_center() - center).norm();
        assert!(shift < slack * range, "{seen} {shift:e}");
        assert!(found.sigma0 < 1e-7 && found.residuals.len() == object.len(), "{}", found.sigma0);
        seen += 1;
    }
    assert_eq!(seen, 4);
}

#[test]
fn noisy_pictures_give_the_minimum_that_lapack_finds() {
    let mut seen = 0;
    for case in oracle()["cases"].as_array().unwrap().iter().filter(|c| c["k"].is_null()) {
        let (object, image) = (points3(&case["object"]), points2(&case["image"]));
        let found = dlt(&object, &image).unwrap();
        let expected = case["condition"].as_f64().unwrap();
        assert!((found.condition / expected - 1.0).abs() < 1e-12, "{}", found.condition);
        let mut sum = 0.0;
        for ((x, t), (p, v)) in
            object.iter().zip(&image).zip(points2(&case["predicted"]).iter().zip(&found.residuals))
        {
            let predicted = found.frame.project(x).unwrap();
            assert!((predicted - p).norm() < 1e-9, "{}", (predicted - p).norm());
            assert!((t - p - v).norm() < 1e-9);
            sum += (t - p).norm_squared();
        }
        let sigma0 = (sum / (2 * object.len() - 11) as f64).sqrt();
        assert!((found.sigma0 / sigma0 - 1.0).abs() < 1e-9);
        seen += 1;
    }
    assert_eq!(seen, 3);
}

#[test]
fn the_eleven_coefficients_project() {
    for case in oracle()["cases"].as_array().unwrap() {
        let (object, image) = (points3(&case["object"]), points2(&case["image"]));
        let found = dlt(&object, &image).unwrap();
        let origin = object[0];
        let l = found.coefficients(&origin).unwrap();
        for x in &object {
            let [x, y, z]: [f64; 3] = (x - origin).into();
            let w = l[8] * x + l[9] * y + l[10] * z + 1.0;
            let p = Point2::new(
                (l[0] * x + l[1] * y + l[2] * z + l[3]) / w,
                (l[4] * x + l[5] * y + l[6] * z + l[7]) / w,
            );
            let q = found.frame.project(&(origin + Vector3::new(x, y, z))).unwrap();
            assert!((p - q).norm() < 1e-8, "{}", (p - q).norm());
        }
        // A point of the focal plane is no origin.
        let frame = &found.frame.exterior;
        let beside = frame.projection_center();
        assert!(found.coefficients(&beside).is_none());
    }
}

#[test]
fn projection_matrices_are_taken_apart_as_by_opencv() {
    for case in oracle()["matrices"].as_array().unwrap() {
        let p = Matrix3x4::from_row_slice(&numbers(&case["p"]));
        for origin in [Point3::origin(), Point3::new(3.0, -4.0, 5.0)] {
            let mut about = p;
            let moved = p.column(3) + p.fixed_columns::<3>(0) * origin.coords;
            about.set_column(3, &moved);
            let frame = Frame::from_projection_matrix(&about, &origin).unwrap();
            let k = matrix3(&case["k"]);
            assert!((frame.camera.matrix() - k).norm() < 1e-12 * k.norm());
            let turned = frame.exterior.camera_from_world();
            assert!((turned.matrix() - matrix3(&case["rotation"])).norm() < 1e-12);
            let center = points3(&case["center"])[0];
            assert!((frame.exterior.projection_center() - center).norm() < 1e-11);
        }
    }
}

fn camera() -> Frame<InteriorOrientation> {
    let interior =
        InteriorOrientation::new([1000.0, 1010.0], Point2::new(500.0, 400.0), 0.0).unwrap();
    let center = Point3::new(3.0, 9.0, 27.0);
    let exterior =
        ExteriorOrientation::look_at(center, Point3::new(0.1, 0.2, -0.3), Vector3::y()).unwrap();
    Frame::new(exterior, interior)
}

fn scattered() -> Vec<Point3<f64>> {
    (0..12)
        .map(|i| {
            let i = f64::from(i);
            Point3::new((1.7 * i).sin(), (2.9 * i).cos(), (4.1 * i + 1.0).sin())
        })
        .collect()
}

fn image(object: &[Point3<f64>]) -> Vec<Point2<f64>> {
    object.iter().map(|x| camera().project(x).unwrap()).collect()
}

fn degenerate(object: &[Point3<f64>], image: &[Point2<f64>], words: &str) {
    match dlt(object, image) {
        Err(Error::Degenerate { what, measure, limit }) => {
            assert!(what.contains(words) && measure <= limit, "{what} {measure} {limit}");
        }
        other => panic!("{words}: {other:?}"),
    }
}

#[test]
fn what_leaves_the_camera_open_is_refused() {
    let plane: Vec<_> =
        scattered().iter().map(|p| Point3::new(p.x, p.y, 0.3 * p.x - 0.1 * p.y)).collect();
    degenerate(&plane, &image(&plane), "in a plane");
    let far: Vec<_> = plane.iter().map(|p| p + Vector3::new(3e6, 5e6, 0.0)).collect();
    degenerate(&far, &image(&plane), "in a plane");
    let line: Vec<_> = (0..8).map(|i| Point3::new(f64::from(i), 2.0, 1.0)).collect();
    degenerate(&line, &image(&line), "in a plane");
    degenerate(&[Point3::new(1.0, 2.0, 3.0); 7], &[Point2::origin(); 7], "in a plane");
    // The twisted cubic (t, t², t³) through the centre at t = 3.
    let cubic: Vec<_> = (0..10)
        .map(|i| {
            let t = f64::from(i) * 0.3 - 1.5;
            Point3::new(t, t * t, t * t * t)
        })
        .collect();
    degenerate(&cubic, &image(&cubic), "open");
    // All but one in a plane.
    let mut one = plane.clone();
    one[4].z += 0.5;
    degenerate(&one, &image(&one), "open");
    degenerate(&scattered(), &[Point2::new(100.0, 50.0); 12], "coincide");
}

#[test]
fn bad_input_is_refused() {
    let object = scattered();
    let seen = image(&object);
    assert_eq!(
        dlt(&object[..5], &seen[..5]).unwrap_err(),
        Error::TooFewPoints { needed: 6, got: 5 }
    );
    assert_eq!(
        dlt(&object, &seen[..7]).unwrap_err(),
        Error::LengthMismatch { what: "object and image points", left: 12, right: 7 }
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let mut points = object.clone();
        points[3].z = bad;
        let error = dlt(&points, &seen).unwrap_err();
        assert_eq!(error, Error::NotFinite { what: "object point" });
        let mut t = seen.clone();
        t[11].y = bad;
        assert_eq!(dlt(&object, &t).unwrap_err(), Error::NotFinite { what: "image point" });
    }
    // Read off a mirror.
    let mirrored: Vec<_> = seen.iter().map(|p| Point2::new(-p.x, p.y)).collect();
    assert!(matches!(dlt(&object, &mirrored), Err(Error::OutOfRange { value, .. }) if value < 0.0));
    // The images of points behind the camera, as the division gives them.
    let camera = camera();
    let mut both = object;
    both[0] = Point3::new(4.0, 13.0, 40.0);
    let by_division = |x: &Point3<f64>| {
        let d = camera.exterior.pose().apply(x);
        Point2::new(500.0 + 1000.0 * d.x / d.z, 400.0 + 1010.0 * d.y / d.z)
    };
    let seen: Vec<_> = both.iter().map(by_division).collect();
    assert!(matches!(
        dlt(&both, &seen),
        Err(Error::Projection(ProjectionError::BehindCamera { depth })) if depth < 0.0
    ));
    let parallel = Matrix3x4::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    assert!(matches!(
        Frame::from_projection_matrix(&parallel, &Point3::origin()),
        Err(Error::Degenerate { .. })
    ));
    let nan = parallel * f64::NAN;
    assert_eq!(
        Frame::from_projection_matrix(&nan, &Point3::origin()).unwrap_err(),
        Error::NotFinite { what: "projection matrix" }
    );
}
