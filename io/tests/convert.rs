//! Files as the library's cameras and planes.

use collinear::camera::SensorModel;
use collinear::geometry::{Affine2, Homography};
use collinear::mapping::polynomial::Cubic;
use collinear::nalgebra::{Matrix3, Point2, Point3};
use collinear_io::camera::{CameraFile, Exterior, Interior, Rotation};
use collinear_io::convert::Camera;
use collinear_io::map::MapFile;
use collinear_io::plane::PlaneFile;
use collinear_io::{ErrorKind, FieldProblem};
use proptest::prelude::*;

fn exterior(rotation: Rotation) -> Exterior {
    Exterior { projection_center: [10.0, 20.0, 30.0], rotation }
}

fn matrix(rotation: Rotation) -> Matrix3<f64> {
    exterior(rotation).orientation().unwrap().camera_from_world().into_inner()
}

/// One rotation in three forms, as the R package `RSpincalc` 1.0.2 prints them (`demo/testRSpincalc.R` and Q2DCM's page):
/// `photo_from_world`, whose second and third row change sign for camera axes.
#[test]
fn the_forms_of_a_printed_rotation_are_one_rotation() {
    let printed = [
        [0.1423907, 0.3610947, -0.9215940],
        [0.7244189, -0.6724915, -0.1515663],
        [-0.6744939, -0.6460385, -0.3573404],
    ];
    let camera = Matrix3::from_fn(|i, j| if i == 0 { printed[i][j] } else { -printed[i][j] });
    let angles = matrix(Rotation::OmegaPhiKappa([2.07603606, -0.7402790, -1.376712]));
    assert!((angles - camera).amax() < 5e-7, "{angles}");
    let rows =
        matrix(Rotation::RotationMatrix([0, 1, 2].map(|i| [0, 1, 2].map(|j| camera[(i, j)]))));
    assert!((rows - camera).amax() < 5e-7, "{rows}");
    assert!((rows * rows.transpose() - Matrix3::identity()).amax() < 1e-15);
    // Printed for vectors that stay while the axes turn: the conjugate turns the vector.
    let photo = matrix(Rotation::QuaternionWxyz([-0.1677489, 0.7369231, 0.3682588, -0.5414703]));
    let printed = Matrix3::from_fn(|i, j| printed[i][j]);
    assert!((photo - printed).amax() < 5e-7, "{photo}");
}

#[test]
fn every_model_becomes_its_camera() {
    let file = |interior| CameraFile {
        width: 640,
        height: 480,
        interior,
        exterior: exterior(Rotation::OmegaPhiKappa([0.0; 3])),
    };
    // 10 below the camera, 1 to the east, 2 to the south.
    let world = Point3::new(11.0, 18.0, 20.0);
    let see = |file: &CameraFile| file.camera().unwrap().sensor().project(&world).unwrap();
    let (principal_distance, principal_point) = ([500.0, 400.0], [320.5, 240.0]);

    let pinhole = file(Interior::Pinhole { principal_distance, principal_point, skew: 5.0 });
    assert!((see(&pinhole) - Point2::new(320.5 + 50.0 + 1.0, 240.0 + 80.0)).norm() < 1e-12);
    assert!((pinhole.frame().unwrap().project(&world).unwrap() - see(&pinhole)).norm() < 1e-12);

    // r² = 0.05; radial 1 + 0.1 · 0.05; tangential 2 · 0.01 · 0.02 + 0.02 · (0.05 + 0.02) and 0.01 · 0.13 + 2 · 0.02 · 0.02.
    let (k, p) = ([0.1, 0.0, 0.0], [0.01, 0.02]);
    let brown = file(Interior::Brown { principal_distance, principal_point, skew: 0.0, k, p });
    let expected = Point2::new(
        320.5 + 500.0 * (0.1005 + 0.0004 + 0.0014),
        240.0 + 400.0 * (0.201 + 0.0013 + 0.0008),
    );
    assert!((see(&brown) - expected).norm() < 1e-12);

    let parallel = file(Interior::Orthographic { pixels_per_unit: [20.0, 10.0], principal_point });
    assert!(matches!(parallel.camera().unwrap(), Camera::Orthographic(_)));
    assert!((see(&parallel) - Point2::new(340.5, 260.0)).norm() < 1e-12);
    let error = parallel.frame().unwrap_err();
    assert!(
        matches!(error.kind(), ErrorKind::Field(e) if matches!(e.problem, FieldProblem::Unsupported { .. }))
    );
}

#[test]
fn a_plane_file_becomes_a_plane() {
    let file =
        PlaneFile { point: [1.0, 2.0, 3.0], normal: [0.0, 0.0, 4.0], up: None, rectangle: None };
    let plane = file.plane().unwrap();
    assert_eq!(plane.signed_distance(&Point3::new(7.0, 8.0, 5.0)), 2.0);
    assert!(PlaneFile { normal: [0.0; 3], ..file }.plane().is_err());
}

#[test]
fn every_kind_of_map_becomes_its_map_and_a_file_again() {
    // At (X, Y) = (2, 3) the terms of table 2 are 1, 2, 3, 6, 4, 9, 12, 18, 8, 27.
    let a = [0.5, 1.0, 2.0, 0.25, 0.125, 0.0625, 0.01, -0.02, 0.03, -0.04];
    let b = [-0.5, 2.0, 1.0, -0.25, 0.5, 0.25, 0.02, 0.01, -0.03, 0.04];
    let h = [[1.0, 2.0, 3.0], [0.0, 1.0, 5.0], [0.5, 0.0, 1.0]];
    let (three, four, six) = (
        ([a[0], a[1], a[2]], [b[0], b[1], b[2]]),
        ([a[0], a[1], a[2], a[3]], [b[0], b[1], b[2], b[3]]),
        ([a[0], a[1], a[2], a[3], a[4], a[5]], [b[0], b[1], b[2], b[3], b[4], b[5]]),
    );
    for (file, x, y) in [
        (MapFile::Homography { matrix: h }, 11.0 / 2.0, 8.0 / 2.0),
        (MapFile::Affine { a: three.0, b: three.1 }, 8.5, 6.5),
        (MapFile::Bilinear { a: four.0, b: four.1 }, 10.0, 5.0),
        (MapFile::Quadratic { a: six.0, b: six.1 }, 11.0625, 9.25),
        (
            MapFile::Cubic { a, b },
            11.0625 + 0.12 - 0.36 + 0.24 - 1.08,
            9.25 + 0.24 + 0.18 - 0.24 + 1.08,
        ),
    ] {
        let got = file.map().unwrap().at(&Point2::new(2.0, 3.0)).unwrap();
        assert!((got - Point2::new(x, y)).norm() < 1e-13, "{file:?}: {got}");
    }
    assert_eq!(
        MapFile::from(&Affine2::from_coefficients(three.0, three.1)),
        MapFile::Affine { a: three.0, b: three.1 }
    );
    let homography = Homography::from_matrix(Matrix3::from_fn(|i, j| h[i][j])).unwrap();
    assert_eq!(MapFile::from(&homography), MapFile::Homography { matrix: h });
    let MapFile::Cubic { a: again, .. } = MapFile::from(&Cubic::from_coefficients(a, b).unwrap())
    else {
        panic!("cubic")
    };
    for (got, expected) in again.iter().zip(a) {
        assert!((got - expected).abs() < 1e-15);
    }
    let behind = MapFile::Homography { matrix: h.map(|r| r.map(|v: f64| -v)) };
    assert!(
        behind.map().unwrap().at(&Point2::new(2.0, 3.0)).is_err(),
        "w < 0 is beyond the horizon"
    );
}

proptest! {
    #[test]
    fn a_camera_that_became_a_file_is_the_same_camera(
        angles in prop::array::uniform3(-3.0..3.0), center in prop::array::uniform3(-1e6..1e6),
        ahead in 1.0..100.0, k in prop::array::uniform3(-0.01..0.01), x in -0.5..0.5, y in -0.5..0.5,
    ) {
        let interior = Interior::Brown {
            principal_distance: [3000.0, 3010.0], principal_point: [1000.0, 800.0], skew: 0.5, k, p: [1e-3, -2e-3],
        };
        let exterior = Exterior { projection_center: center, rotation: Rotation::OmegaPhiKappa(angles) };
        let frame = CameraFile { width: 2000, height: 1600, interior, exterior }.frame().unwrap();
        let again = CameraFile::from_frame(&frame, 2000, 1600).frame().unwrap();
        let world = frame.exterior.pose().apply_inverse(&Point3::new(x * ahead, y * ahead, ahead));
        let (a, b) = (frame.project(&world).unwrap(), again.project(&world).unwrap());
        // Rounding of a quaternion and back: a few ε of 3,000 pixels.
        prop_assert!((a - b).norm() < 1e-11, "{}", (a - b).norm());
    }
}
