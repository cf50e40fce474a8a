//! Cameras against other programs, published numbers and the laws of projection.

use approx::assert_abs_diff_eq;
use collinear::camera::{
    Brown, BrownCamera, CentralModel, Distortion, ExteriorOrientation, Frame, InteriorOrientation,
    Orthographic, SensorModel,
};
use collinear::geometry::geodetic::{Ellipsoid, EllipsoidalHeight};
use collinear::geometry::rotation::OmegaPhiKappa;
use collinear::geometry::{Affine2, Locus, Plane, Surface};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{exterior, interior, numbers, point};

fn array<const N: usize>(v: &Value) -> [f64; N] {
    numbers(v).try_into().unwrap()
}

fn oracle() -> Value {
    serde_json::from_str(include_str!("../data/oracles/brown.json")).unwrap()
}

#[test]
fn opencv_projects_the_same_points() {
    for camera in oracle()["cameras"].as_array().unwrap() {
        let f = |name: &str| camera[name].as_f64().unwrap();
        let interior =
            InteriorOrientation::from_opencv(f("fx"), f("fy"), f("cx"), f("cy")).unwrap();
        let lens = Brown::new(array(&camera["k"]), array(&camera["p"])).unwrap();
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&numbers(
            &camera["rotation"],
        )));
        let exterior = ExteriorOrientation::from_rotation_translation(
            rotation,
            Vector3::from(array::<3>(&camera["translation"])),
        );
        let frame = Frame::new(exterior, BrownCamera::new(interior, lens));
        let world = camera["world"].as_array().unwrap();
        for (world, image) in world.iter().zip(camera["image"].as_array().unwrap()) {
            // OpenCV's pixel (0, 0) is the centre of the first pixel, ours its corner.
            let expected =
                Point2::from(array::<2>(image)) + collinear::nalgebra::Vector2::repeat(0.5);
            let at = frame.project(&Point3::from(array::<3>(world))).unwrap();
            assert_abs_diff_eq!(at, expected, epsilon = 1e-9);
        }
    }
}

#[test]
fn the_lens_is_inverted_out_to_its_fold() {
    for case in oracle()["folds"].as_array().unwrap() {
        let lens = Brown::new(array(&case["k"]), array(&case["p"])).unwrap();
        let fold = case["fold_radius"].as_f64().unwrap();
        assert_abs_diff_eq!(lens.fold_radius(), fold, epsilon = 1e-12 * fold);
        for point in case["points"].as_array().unwrap() {
            let [x, y, u, v] = array(point);
            let (ideal, distorted) = (Point2::new(x, y), Point2::new(u, v));
            assert_abs_diff_eq!(lens.distort(&ideal).unwrap(), distorted, epsilon = 1e-15);
            let found = lens.undistort(&distorted).unwrap();
            // Near the fold the smallest eigenvalue goes to zero with the distance to it.
            let conditioning = 1.0 / (1.0 - ideal.coords.norm() / fold);
            assert_abs_diff_eq!(found.point, ideal, epsilon = 1e-15 * conditioning.max(4.0));
            assert!(found.residual <= 1e-15 && found.iterations < 30, "{found:?}");
        }
        // At and past the fold: refused, and what lies past the rim of the picture too.
        let past = Point2::new(fold * 1.000_001, 0.0);
        assert!(matches!(lens.distort(&past), Err(ProjectionError::OutsideDomain { .. })));
        let rim = lens.distort(&Point2::new(0.999_999 * fold, 0.0)).unwrap().x;
        assert!(matches!(
            lens.undistort(&Point2::new(1.05 * rim, 0.0)),
            Err(ProjectionError::OutsideDomain { .. })
        ));
    }
}

/// M = Mκ Mφ Mω of Wolf & Dewitt, element by element.
fn omega_phi_kappa(degrees: [f64; 3]) -> Matrix3<f64> {
    let [(so, co), (sp, cp), (sk, ck)] = degrees.map(|a| a.to_radians().sin_cos());
    Matrix3::new(
        cp * ck,
        so * sp * ck + co * sk,
        -co * sp * ck + so * sk,
        -cp * sk,
        -so * sp * sk + co * ck,
        co * sp * sk + so * ck,
        sp,
        -so * cp,
        co * cp,
    )
}

/// A whole published chain: comparator pixels, fiducial affine, exterior orientations and residuals.
/// P. Santitamnont, pyBundleBlock (2022), github.com/phisan-chula/pyBundleBlock: Wild RC-30, f = 154.006 mm, photos 62 and
/// 63 of a block at Chulalongkorn University; the printed affine coefficients (AffineLSQ/Result.txt) and orientations
/// (README), and the printed residuals, computed minus measured, in mm.
#[test]
fn a_published_photogrammetric_chain_is_reproduced() {
    // col = a x + b y + c, row = d x + e y + f with the row axis upwards; our rows count down.
    let marks = [
        ([113.003, 0.006], [15088.50, -7560.65]),
        ([-112.987, 0.006], [34.73, -7560.74]),
        ([0.012, 113.023], [7561.87, -32.49]),
        ([0.012, -113.004], [7561.51, -15088.08]),
        ([113.007, 113.005], [15088.55, -33.53]),
        ([-112.989, -112.994], [34.50, -15088.00]),
        ([-112.998, 113.006], [33.71, -33.54]),
        ([112.999, -112.998], [15088.33, -15087.90]),
    ];
    let photo = marks.map(|m| Point2::from(m.0));
    let pixel = marks.map(|m| Point2::new(m.1[0], -m.1[1]));
    let fit = Affine2::fit(&photo, &pixel).unwrap();
    let printed = [
        [7560.971_230_898_715_5, 66.612_938_663_371_96, -0.000_211_417_132_635_054_18],
        [7561.032_576_056_914, -0.000_786_241_260_893_511_7, -66.611_241_341_508_94],
    ];
    for (i, [constant, x, y]) in printed.into_iter().enumerate() {
        assert_abs_diff_eq!(fit.map.translation[i], constant, epsilon = 1e-9);
        assert_abs_diff_eq!(fit.map.linear[(i, 0)], x, epsilon = 1e-11);
        assert_abs_diff_eq!(fit.map.linear[(i, 1)], y, epsilon = 1e-11);
    }
    let interior =
        InteriorOrientation::from_photogrammetric(154.006, Point2::origin(), &fit.map).unwrap();
    // Photo 62: angles in degrees, centre in metres, then ground point, measured pixel and printed residual in mm.
    let m = omega_phi_kappa([2.194102, -0.432875, -2.216435]);
    let camera_from_photo = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    let exterior = ExteriorOrientation::new(
        Point3::new(3708.724, 2100.812, 2258.521),
        Rotation3::from_matrix_unchecked(camera_from_photo * m),
    );
    let frame = Frame::new(exterior, interior);
    let control = [
        ([4213.013, 3182.528, 277.559], [9840.1, -2376.6], [-0.0033, 0.0017]),
        ([5027.192, 3214.013, 250.182], [13847.1, -2155.5], [0.0016, -0.0020]),
        ([3517.415, 1921.055, 228.798], [6563.1, -8907.7], [0.0002, 0.0015]),
        ([4228.470, 2082.750, 207.739], [10098.1, -7945.7], [0.0010, -0.0015]),
        ([3674.942, 1050.052, 206.364], [7534.0, -13325.9], [0.0001, -0.0005]),
        ([4182.090, 1053.451, 240.941], [10160.2, -13288.9], [0.0003, 0.0008]),
    ];
    for (ground, measured, residual) in control {
        let at = frame.project(&Point3::from(ground)).unwrap();
        let difference =
            fit.map.linear.try_inverse().unwrap() * (at - Point2::new(measured[0], -measured[1]));
        // The printed residuals have four decimals and belong to unrounded orientations.
        assert_abs_diff_eq!(difference.x, residual[0], epsilon = 1.5e-4);
        assert_abs_diff_eq!(difference.y, residual[1], epsilon = 1.5e-4);
    }
}

/// Wuhan University's single-photo resection (f = 153.24 mm, x₀ = y₀ = 0): the control points, and the image coordinates
/// in mm that the published solution Xs = 39795.45, Ys = 27476.46, Zs = 7572.69, φ = −0.0039869, ω = 0.0021139,
/// κ = −0.0675780 gives by its own formula x = −f (a₁ΔX + b₁ΔY + c₁ΔZ)/(a₃ΔX + b₃ΔY + c₃ΔZ), in Python's floats.
#[test]
fn the_wuhan_photo_is_projected_as_published() {
    // R, photo to ground, rows (a b c): from the angles by Rφ Rω Rκ, numpy 2.4.6.
    let (p, o, k) = (-0.003_986_9f64, 0.002_113_9f64, -0.067_578_0f64);
    let ((sp, cp), (so, co), (sk, ck)) = (p.sin_cos(), o.sin_cos(), k.sin_cos());
    let r = Matrix3::new(
        cp * ck - sp * so * sk,
        -cp * sk - sp * so * ck,
        -sp * co,
        co * sk,
        co * ck,
        -so,
        sp * ck + cp * so * sk,
        -sp * sk + cp * so * ck,
        cp * co,
    );
    assert_abs_diff_eq!(r.m11, 0.99771, epsilon = 5e-6);
    assert_abs_diff_eq!(r.m12, 0.06753, epsilon = 5e-6);
    let camera_from_photo = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
    let frame = Frame::new(
        ExteriorOrientation::new(
            Point3::new(39795.45, 27476.46, 7572.69),
            Rotation3::from_matrix_unchecked(camera_from_photo * r.transpose()),
        ),
        // One "pixel" a millimetre, y up: the photo system itself.
        InteriorOrientation::from_photogrammetric(153.24, Point2::origin(), &Affine2::identity())
            .unwrap(),
    );
    let expected = [
        ([36589.41, 25273.32, 2195.17], [-86.151_178_12, -68.986_530_65]),
        ([37631.08, 31324.51, 728.69], [-53.406_456_92, 82.207_331_37]),
        ([39100.97, 24934.98, 2386.50], [-14.778_525_60, -76.630_335_74]),
        ([40426.54, 30319.81, 757.31], [10.466_325_82, 64.429_043_06]),
    ];
    for (ground, photo) in expected {
        let at = frame.project(&Point3::from(ground)).unwrap();
        assert_abs_diff_eq!(at, Point2::from(photo), epsilon = 1e-8);
        // And back: the ray of the image point passes through the ground point ([WD] eq. 4b).
        let level = Plane::from_point_and_normal(Point3::from(ground), Vector3::z()).unwrap();
        assert_abs_diff_eq!(
            frame.ground(&at, &level).unwrap(),
            Point3::from(ground),
            epsilon = 1e-7
        );
    }
}

/// project ∘ ground on a plane and on a ball, for a sensor that is moved so that its line of sight goes through `aim`, at most
/// 1.8 from the origin, 10 before it.
fn comes_back<S: SensorModel>(
    sensor_at: impl Fn(Point3<f64>) -> S,
    image: &Point2<f64>,
    aim: &Point3<f64>,
    tilt: &Vector3<f64>,
    tolerance: f64,
) -> Result<(), TestCaseError> {
    let Locus::Ray(from_origin) = sensor_at(Point3::origin()).locus(image).unwrap() else {
        panic!("a ray")
    };
    let toward = from_origin.direction.into_inner();
    let sensor = sensor_at(aim - from_origin.origin.coords - toward * 10.0);
    // Within 60° of facing the sensor: its line of sight meets the plane, and the ball of radius 3.
    let plane = Plane::from_point_and_normal(*aim, tilt - toward).unwrap();
    let ball = Ellipsoid::new(3.0, 0.1).unwrap();
    let surfaces: [&dyn Surface; 2] = [&plane, &ball.at_height(EllipsoidalHeight(0.0)).unwrap()];
    for surface in surfaces {
        let ground = sensor.ground(image, surface).unwrap();
        prop_assert!(surface.height_above(&ground).abs() < 1e-12 * 20.0);
        let again = sensor.project(&ground).unwrap();
        prop_assert!((again - image).norm() < tolerance, "{again} for {image}");
    }
    Ok(())
}

/// Any camera with a lens whose five terms are all at work.
fn lens_camera() -> impl Strategy<Value = BrownCamera> {
    (interior(), [-0.3..0.1f64, -0.1..0.1, -0.02..0.02], [-3e-3..3e-3f64, -3e-3..3e-3])
        .prop_map(|(interior, k, p)| BrownCamera::new(interior, Brown::new(k, p).unwrap()))
}

proptest! {
    #[test]
    fn project_after_ground_is_the_identity_out_to_the_edge_of_the_domain(
        camera in lens_camera(), exterior in exterior(), share in 0.0..0.9999f64, angle in 0.0..std::f64::consts::TAU,
        aim in point(1.0), tilt in point(0.5),
    ) {
        let lens = camera.distortion();
        let radius = share * lens.fold_radius().min(1.5);
        let ideal = Point2::new(radius * angle.cos(), radius * angle.sin());
        let image = camera.interior().pixel_from_normalised(&lens.distort(&ideal).unwrap());
        // The share of the fold's neighbourhood that conditions the inverse.
        let conditioning = 1.0 / (1.0 - radius / lens.fold_radius());
        let f = camera.interior().principal_distance()[0];
        let turn = exterior.camera_from_world();
        let frame = |center| Frame::new(ExteriorOrientation::new(center, turn), camera);
        comes_back(frame, &image, &aim, &tilt.coords, 1e-13 * f * (10.0 + conditioning))?;
        let pixel = Affine2::from_coefficients([320.0, f, 0.1 * f], [240.0, -0.2 * f, 1.1 * f]);
        let parallel = |center| {
            Orthographic::new(ExteriorOrientation::new(center, turn), pixel).unwrap()
        };
        comes_back(parallel, &image, &aim, &tilt.coords, 1e-13 * (image.coords.norm() + 10.0 * f))?;
    }

    #[test]
    fn partial_derivatives_are_the_slopes(
        camera in lens_camera(), exterior in exterior(), p in point(1.0),
    ) {
        use collinear::camera::Adjustable;
        let frame = Frame::new(exterior, camera);
        prop_assume!(frame.project(&p).is_ok());
        let (mut e, mut i, mut d) = ([0.0; 12], [0.0; 10], [0.0; 10]);
        let mut by_object = [0.0; 6];
        frame.partials(&p, &mut by_object, &mut [&mut e, &mut i, &mut d]).unwrap();
        let steps = [1e-4, 1e-5, 1e-5];
        for (group, block) in [&e[..], &i, &d].into_iter().enumerate() {
            let len = block.len() / 2;
            for k in 0..len {
                let moved = |sign: f64| {
                    let mut copy = frame;
                    let mut step = vec![0.0; len];
                    step[k] = sign * steps[group];
                    copy.adjust(group, &step).ok()?;
                    copy.project(&p).ok()
                };
                let (Some(a), Some(b)) = (moved(1.0), moved(-1.0)) else { continue };
                let slope = (a - b) / (2.0 * steps[group]);
                let scale = 1e-6 * (1.0 + slope.norm());
                prop_assert!((slope.x - block[k]).abs() < scale, "{group} {k} {} {}", slope.x, block[k]);
                prop_assert!((slope.y - block[len + k]).abs() < scale, "{group} {k}");
            }
        }
    }

    #[test]
    fn partials_by_omega_phi_kappa_follow_by_a_chain(
        camera in interior(), center in point(1.0), ground in point(2.0), angles in [-0.5..0.5f64, -0.5..0.5, -3.0..3.0],
    ) {
        use collinear::camera::Adjustable;
        // The oracle: the collinearity equations in ω, φ, κ written out, differenced.
        let center = center + Vector3::new(0.0, 0.0, 20.0);
        let image = |a: [f64; 3]| {
            let v = omega_phi_kappa(a.map(f64::to_degrees)) * (ground - center);
            camera.pixel_from_normalised(&Point2::new(v.x / -v.z, v.y / v.z))
        };
        let [omega, phi, kappa] = angles;
        let frame = Frame::new(
            ExteriorOrientation::from_omega_phi_kappa(center, &OmegaPhiKappa { omega, phi, kappa }),
            camera,
        );
        let at = frame.project(&ground).unwrap();
        prop_assert!((at - image(angles)).norm() < 1e-9);
        let (mut exterior, mut by_object) = ([0.0; 12], [0.0; 6]);
        frame.partials(&ground, &mut by_object, &mut [&mut exterior]).unwrap();
        let by_rotation = collinear::nalgebra::Matrix2x3::new(
            exterior[3], exterior[4], exterior[5], exterior[9], exterior[10], exterior[11],
        );
        let by_angles = by_rotation * frame.exterior.rotation_from_omega_phi_kappa();
        for i in 0..3 {
            let mut step = [0.0; 3];
            step[i] = 1e-6;
            let ahead: [f64; 3] = core::array::from_fn(|k| angles[k] + step[k]);
            let back: [f64; 3] = core::array::from_fn(|k| angles[k] - step[k]);
            let slope = (image(ahead) - image(back)) / 2e-6;
            prop_assert!((slope - by_angles.column(i)).norm() < 1e-4 * (1.0 + slope.norm()));
        }
    }

    #[test]
    fn no_input_panics(x in any::<f64>(), y in any::<f64>(), z in any::<f64>(), camera in lens_camera()) {
        let frame = Frame::new(
            ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 5.0), Point3::origin(), Vector3::y()).unwrap(),
            camera,
        );
        if let Ok(p) = frame.project(&Point3::new(x, y, z)) {
            prop_assert!(p.x.is_finite() && p.y.is_finite() && z < 5.0);
        }
        let _ = frame.locus(&Point2::new(x, y));
        if let Ok(lens) = Brown::new([x, y, z], [y, x]) {
            prop_assert!(lens.fold_radius() > 0.0);
            let _ = lens.undistort(&Point2::new(0.3, -0.4));
        }
        let _ = InteriorOrientation::new([x, y], Point2::new(z, x), y);
    }
}

#[test]
fn what_is_behind_is_refused_with_its_depth() {
    let camera =
        InteriorOrientation::new([1000.0, 1000.0], Point2::new(500.0, 400.0), 0.0).unwrap();
    let frame = Frame::new(
        ExteriorOrientation::new(Point3::new(1.0, 2.0, 3.0), Rotation3::identity()),
        camera,
    );
    // OpenCV 5.0.0 projects such a point without a word.
    assert_eq!(
        frame.project(&Point3::new(1.5, 2.2, 0.0)),
        Err(ProjectionError::BehindCamera { depth: -3.0 })
    );
    assert_eq!(frame.project(&Point3::new(f64::NAN, 0.0, 9.0)), Err(ProjectionError::NotFinite));
    let up = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    assert_eq!(frame.ground(&Point2::new(500.0, 400.0), &up), Err(ProjectionError::MissesSurface));
}

#[test]
fn a_turned_film_keeps_its_four_affine_numbers() {
    // Film laid on the scanner turned by 90°: photo x runs down the scan, photo y to the right.
    let turned = Affine2::from_coefficients([5000.0, 0.0, 40.0], [5000.0, 40.0, 0.0]);
    let camera =
        InteriorOrientation::from_photogrammetric(100.0, Point2::new(0.5, -0.25), &turned).unwrap();
    // Photo (20.5, −0.25 + 10) mm lies at pixel (5000 + 40·9.75, 5000 + 40·20.5).
    let at = camera.project_direction(&Vector3::new(0.2, -0.1, 1.0)).unwrap();
    assert_abs_diff_eq!(at, Point2::new(5390.0, 5820.0), epsilon = 1e-10);
    let back = camera.direction(&at).unwrap();
    assert_abs_diff_eq!(back / back.z, Vector3::new(0.2, -0.1, 1.0), epsilon = 1e-14);
}

#[test]
fn constructors_say_what_is_wrong() {
    let pp = Point2::new(1.0, 1.0);
    assert!(matches!(
        InteriorOrientation::new([0.0, 1.0], pp, 0.0),
        Err(Error::OutOfRange { what: "principal distance", .. })
    ));
    assert!(matches!(
        InteriorOrientation::new([f64::NAN, 1.0], pp, 0.0),
        Err(Error::NotFinite { .. })
    ));
    assert!(matches!(
        InteriorOrientation::from_photogrammetric(-153.0, pp, &Affine2::identity()),
        Err(Error::OutOfRange { .. })
    ));
    assert!(matches!(
        InteriorOrientation::from_matrix(&Matrix3::identity().scale(2.0)),
        Err(Error::OutOfRange { what: "third row of K", .. })
    ));
    let here = Point3::new(1.0, 2.0, 3.0);
    assert!(matches!(
        ExteriorOrientation::look_at(here, here + Vector3::z(), Vector3::z()),
        Err(Error::Degenerate { .. })
    ));
    assert!(ExteriorOrientation::look_at(here, here, Vector3::z()).is_err());
    let flat = Affine2::from_coefficients([0.0, 1.0, 2.0], [0.0, 2.0, 4.0]);
    let exterior = ExteriorOrientation::new(here, Rotation3::identity());
    assert!(matches!(Orthographic::new(exterior, flat), Err(Error::Degenerate { .. })));
}

#[test]
fn a_parallel_projection_is_adjusted() {
    use collinear::camera::Adjustable;
    // Straight down from (10, 0, 10), 4 px a unit: (12, −3, 0) is 2 right, 3 down and 10 deep.
    let down = Rotation3::from_matrix_unchecked(Matrix3::new(
        1.0, 0.0, 0.0, //
        0.0, -1.0, 0.0, //
        0.0, 0.0, -1.0,
    ));
    let exterior = ExteriorOrientation::new(Point3::new(10.0, 0.0, 10.0), down);
    let scale = Affine2::from_coefficients([50.0, 4.0, 0.0], [60.0, 0.0, 4.0]);
    let mut camera = Orthographic::new(exterior, scale).unwrap();
    let names = [0, 1].map(|g| camera.parameter_group(g).unwrap());
    assert_eq!(
        names.map(|g| (g.name, g.len)),
        [("exterior orientation", 6), ("pixels from plane", 6)]
    );
    assert!(camera.parameter_group(2).is_none());
    let world = Point3::new(12.0, -3.0, 0.0);
    let (mut by_world, mut by_pose, mut by_pixels) = ([0.0; 6], [0.0; 12], [0.0; 12]);
    let image =
        camera.partials(&world, &mut by_world, &mut [&mut by_pose, &mut by_pixels]).unwrap();
    assert_eq!(image, Point2::new(58.0, 72.0));
    assert_eq!(by_world, [4.0, 0.0, 0.0, 0.0, -4.0, 0.0]);
    // By O the opposite; by δ the first two of 4 δ × (2, 3, 10).
    assert_eq!(by_pose[..6], [-4.0, 0.0, 0.0, 0.0, 40.0, -12.0]);
    assert_eq!(by_pose[6..], [0.0, 4.0, 0.0, -40.0, 0.0, 8.0]);
    assert_eq!(by_pixels[..6], [2.0, 3.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(by_pixels[6..], [0.0, 0.0, 2.0, 3.0, 0.0, 1.0]);
    // A step moves the image along its slope.
    camera.adjust(0, &[0.5, -0.25, 3.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!(camera.project(&world).unwrap(), Point2::new(58.0 - 2.0, 72.0 - 1.0));
    let mut values = [9.0; 6];
    camera.parameters(0, &mut values);
    assert_eq!(values, [10.5, -0.25, 13.0, 0.0, 0.0, 0.0]);
    camera.adjust(1, &[0.5, 0.0, 0.0, 0.0, 1.0, -2.0]).unwrap();
    camera.parameters(1, &mut values);
    assert_eq!(values, [4.5, 0.0, 0.0, 4.0, 51.0, 58.0]);
    let turned = camera;
    camera.adjust(0, &[0.0, 0.0, 0.0, 0.0, 1e-7, 0.0]).unwrap();
    let moved = camera.project(&world).unwrap() - turned.project(&world).unwrap();
    assert!((moved.x / 1e-7 - 4.5 * 13.0).abs() < 1e-5 && moved.y.abs() < 1e-12, "{moved}");
    for (group, step) in [(0, &[0.0; 5][..]), (1, &[0.0; 7]), (2, &[0.0; 6])] {
        assert!(camera.adjust(group, step).is_err());
    }
    // A map that is flat is refused, and the camera stays as it was.
    let before = camera;
    assert!(camera.adjust(1, &[-4.5, 0.0, 0.0, 0.0, 0.0, 0.0]).is_err());
    assert!(camera.adjust(0, &[f64::NAN; 6]).is_err());
    assert_eq!(camera, before);
}
