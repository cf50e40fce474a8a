//! Cameras at the edge of their domain, and parallel ones, against numbers by hand.

use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralModel, Distortion, ExteriorOrientation, Frame,
    InteriorOrientation, Orthographic, SensorModel,
};
use collinear::geometry::geodetic::{Ellipsoid, EllipsoidalHeight};
use collinear::geometry::{Affine2, Locus, Plane};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::{Error, ProjectionError};

fn interior() -> InteriorOrientation {
    InteriorOrientation::new([1000.0, 1100.0], Point2::new(500.0, 400.0), 2.0).unwrap()
}

/// Camera axes x right, y down, z forward, seen from above: x east, y south, z down.
fn down() -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)))
}

#[test]
fn the_focal_plane_itself_has_no_image() {
    let camera = BrownCamera::new(interior(), Brown::none());
    let models: [&dyn CentralModel; 2] = [&interior(), &camera];
    for model in models {
        for flat in [Vector3::new(1.0, 2.0, 0.0), Vector3::zeros()] {
            let refused = ProjectionError::BehindCamera { depth: 0.0 };
            assert_eq!(model.project_direction(&flat), Err(refused));
            assert_eq!(model.project_direction_jacobian(&flat), Err(refused));
        }
        // What is no number is said to be none, wherever the rest points.
        for i in 0..3 {
            for depth in [1.0, 0.0, -1.0] {
                let mut direction = Vector3::new(0.5, 0.25, depth);
                direction[i] = f64::NAN;
                assert_eq!(model.project_direction(&direction), Err(ProjectionError::NotFinite));
            }
        }
    }
    // One coordinate that overflows is enough.
    for (f, direction) in [([1e150, 1.0], [1e200, 0.5, 1.0]), ([1.0, 1e150], [0.5, 1e200, 1.0])] {
        let wide = InteriorOrientation::new(f, Point2::new(0.0, 0.0), 0.0).unwrap();
        let direction = Vector3::from(direction);
        assert_eq!(wide.project_direction(&direction), Err(ProjectionError::NotFinite));
        assert_eq!(wide.direction(&Point2::new(f64::NAN, 0.0)), Err(ProjectionError::NotFinite));
        assert_eq!(wide.direction(&Point2::new(0.0, f64::NAN)), Err(ProjectionError::NotFinite));
    }
}

#[test]
fn directions_have_unit_length() {
    // (3, 4, 12) / 13.
    let plain = InteriorOrientation::new([1200.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let camera = BrownCamera::new(plain, Brown::none());
    let models: [&dyn CentralModel; 2] = [&plain, &camera];
    for model in models {
        let direction = model.direction(&Point2::new(800.0, 800.0)).unwrap();
        assert!((direction - Vector3::new(3.0, 4.0, 12.0) / 13.0).norm() < 1e-15, "{direction}");
    }
}

#[test]
fn a_lens_is_inverted_where_it_enlarges_beyond_its_fold() {
    // r″ = r (1 + r² − r⁴/2): 1 + 3 r² − 5/2 r⁴ = 0 at r² = (3 + √19)/5, and r = 1 goes to 3/2, farther out than the fold.
    let lens = Brown::new([1.0, -0.5, 0.0], [0.0; 2]).unwrap();
    let fold = ((3.0 + 19f64.sqrt()) / 5.0).sqrt();
    assert!((lens.fold_radius() - fold).abs() < 1e-14 && fold < 1.5);
    for (ideal, distorted) in [([1.0, 0.0], [1.5, 0.0]), ([-0.6, 0.8], [-0.9, 1.2])] {
        let found = lens.undistort(&Point2::from(distorted)).unwrap();
        assert!((found.point - Point2::from(ideal)).norm() < 1e-14, "{found:?}");
        assert!(found.residual < 2e-15);
    }
}

#[test]
fn the_rim_of_a_lens_is_its_fold() {
    // r″ = r − r³/12 turns at r = 2, where it is 4/3.
    let lens = Brown::new([-1.0 / 12.0, 0.0, 0.0], [0.0; 2]).unwrap();
    let fold = lens.fold_radius();
    assert!((fold - 2.0).abs() < 1e-14);
    for at in [Point2::new(fold, 0.0), Point2::new(0.0, -fold)] {
        assert_eq!(
            lens.distort(&at),
            Err(ProjectionError::OutsideDomain { value: fold, limit: fold })
        );
    }
    assert!(lens.distort(&Point2::new(fold * (1.0 - 1e-15), 0.0)).is_ok());
    match lens.undistort(&Point2::new(0.0, 1.5)) {
        Err(ProjectionError::OutsideDomain { value, limit }) => {
            assert_eq!(value, 1.5);
            assert!((limit - 4.0 / 3.0).abs() < 1e-14, "{limit}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn parameters_are_given_and_moved_in_their_order() {
    let lens = Brown::new([-0.1, 0.02, -0.001], [3e-4, -2e-4]).unwrap();
    let exterior = ExteriorOrientation::new(Point3::new(7.0, 8.0, 9.0), down());
    let mut frame = Frame::new(exterior, BrownCamera::new(interior(), lens));
    let values = |frame: &Frame<BrownCamera>, group: usize| {
        let mut values = vec![f64::NAN; frame.parameter_group(group).unwrap().len];
        frame.parameters(group, &mut values);
        values
    };
    assert_eq!(values(&frame, 0), [7.0, 8.0, 9.0, 0.0, 0.0, 0.0]);
    assert_eq!(values(&frame, 1), [1000.0, 1100.0, 500.0, 400.0, 2.0]);
    assert_eq!(values(&frame, 2), [-0.1, 0.02, -0.001, 3e-4, -2e-4]);
    assert_eq!(frame.parameter_group(3), None);
    frame.adjust(0, &[0.5, -1.0, 2.0, 0.0, 0.0, 0.0]).unwrap();
    frame.adjust(1, &[10.0, -20.0, 3.0, -4.0, 0.5]).unwrap();
    frame.adjust(2, &[0.5, 0.25, 0.125, 0.0625, -0.5]).unwrap();
    assert_eq!(values(&frame, 0), [7.5, 7.0, 11.0, 0.0, 0.0, 0.0]);
    assert_eq!(values(&frame, 1), [1010.0, 1080.0, 503.0, 396.0, 2.5]);
    let expected = [-0.1 + 0.5, 0.02 + 0.25, -0.001 + 0.125, 3e-4 + 0.0625, -2e-4 - 0.5];
    assert_eq!(values(&frame, 2), expected);
}

#[test]
fn a_step_does_not_turn_the_picture_over() {
    for step in [[-1000.5, 0.0, 0.0, 0.0, 0.0], [0.0, -1100.5, 0.0, 0.0, 0.0]] {
        let mut camera = interior();
        assert!(matches!(
            camera.adjust(0, &step),
            Err(Error::OutOfRange { what: "principal distance", value: -0.5, .. })
        ));
        assert_eq!(camera, interior());
    }
}

#[test]
fn a_rotation_stays_one_through_many_steps() {
    let exterior = ExteriorOrientation::new(Point3::origin(), down());
    let mut frame = Frame::new(exterior, interior());
    for _ in 0..20_000 {
        frame.adjust(0, &[0.0, 0.0, 0.0, 0.013, -0.007, 0.011]).unwrap();
    }
    let r = *frame.exterior.camera_from_world().matrix();
    let drift = (r * r.transpose() - Matrix3::identity()).norm();
    assert!(drift < 4e-15, "{drift}");
}

#[test]
fn a_camera_may_look_almost_along_its_up_direction() {
    // From 10 above the origin, straight down but for 10⁻⁸ northwards: north is up in the picture, east to the right.
    let tilt = 1e-7;
    let e = ExteriorOrientation::look_at(
        Point3::new(0.0, 0.0, 10.0),
        Point3::new(0.0, tilt, 0.0),
        Vector3::z(),
    )
    .unwrap();
    let p = e.pose().apply(&Point3::new(2.0, 3.0, 4.0));
    assert!((p - Point3::new(2.0, -3.0, 6.0)).norm() < 1e-7, "{p}");
}

#[test]
fn a_parallel_line_of_sight_meets_what_lies_on_either_side() {
    // Straight down from z = 10, half a unit a pixel: (100, 60) shows (50, −30).
    let exterior = ExteriorOrientation::new(Point3::new(0.0, 0.0, 10.0), down());
    let half = Affine2::from_coefficients([0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    let screen = Orthographic::new(exterior, half).unwrap();
    for height in [3.0, 10.0, 25.0] {
        let level =
            Plane::from_point_and_normal(Point3::new(0.0, 0.0, height), Vector3::z()).unwrap();
        let ground = screen.ground(&Point2::new(100.0, 60.0), &level).unwrap();
        assert!((ground - Point3::new(50.0, -30.0, height)).norm() < 1e-13, "{ground}");
    }
    // The line itself runs down from the plane Z′ = 0, and inside a ball of radius 3 about O meets its lower half.
    let Locus::Ray(ray) = screen.locus(&Point2::new(100.0, 60.0)).unwrap() else { panic!() };
    assert!((ray.origin - Point3::new(50.0, -30.0, 10.0)).norm() < 1e-13);
    assert_eq!(ray.direction.into_inner(), -Vector3::z());
    let inside = ExteriorOrientation::new(Point3::origin(), down());
    let inside = Orthographic::new(inside, half).unwrap();
    let ball = Ellipsoid::new(3.0, 0.0).unwrap().at_height(EllipsoidalHeight(0.0)).unwrap();
    let ground = inside.ground(&Point2::new(0.0, 0.0), &ball).unwrap();
    assert!((ground - Point3::new(0.0, 0.0, -3.0)).norm() < 1e-12, "{ground}");
    let upright = Plane::from_point_and_normal(Point3::origin(), Vector3::x()).unwrap();
    assert_eq!(
        screen.ground(&Point2::new(100.0, 60.0), &upright),
        Err(ProjectionError::MissesSurface)
    );
    let (image, by_world) = screen.project_jacobian(&Point3::new(50.0, -30.0, 77.0)).unwrap();
    assert!((image - Point2::new(100.0, 60.0)).norm() < 1e-13);
    let expected = collinear::nalgebra::Matrix2x3::new(2.0, 0.0, 0.0, 0.0, -2.0, 0.0);
    assert!((by_world - expected).norm() < 1e-15);
}

#[test]
fn in_a_parallel_view_what_lies_higher_is_nearer() {
    // The depth below z = 10 is Z′ = 10 − z, and nearness −Z′. z = 3 + x/2 − y/4 at (S, −L) is 3 + S/2 + L/4.
    let exterior = ExteriorOrientation::new(Point3::new(0.0, 0.0, 10.0), down());
    let screen = Orthographic::new(exterior, Affine2::identity()).unwrap().homogeneous();
    let plane = Plane::from_coefficients([0.5, -0.25, -1.0, 3.0]).unwrap();
    for plane in [plane, plane.flipped()] {
        let nearness = screen.nearness(&plane).unwrap();
        for (n, e) in nearness.iter().zip([-7.0, 0.5, 0.25]) {
            assert!((n - e).abs() < 1e-14, "{nearness:?}");
        }
    }
}
