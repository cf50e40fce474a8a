//! Rotations: each convention against a published matrix, and the way back.

use collinear::Error;
use collinear::geometry::rotation::*;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn largest(m: Matrix3<f64>) -> f64 {
    m.amax()
}

fn close(got: &Rotation3<f64>, printed: [[f64; 3]; 3], tolerance: f64) {
    for i in 0..3 {
        for j in 0..3 {
            let d = (got[(i, j)] - printed[i][j]).abs();
            assert!(d <= tolerance, "({i}, {j}): {} against {}", got[(i, j)], printed[i][j]);
        }
    }
}

fn near(got: [f64; 3], printed: [f64; 3], tolerance: f64) {
    for (g, p) in got.into_iter().zip(printed) {
        let d = (g - p).abs();
        assert!(d.min((d - 2.0 * PI).abs()) <= tolerance, "{got:?} against {printed:?}");
    }
}

// One rotation in every convention: R package RSpincalc 1.0.2 (J. Gama; after J. Fuller's SpinCalc and P. de Leva's
// SpinConv), demo/testRSpincalc.R. Quaternion scalar first of the passive matrix; then the sequences xyz, yxz, zxz, zyx.
struct Set {
    quaternion: [f64; 4],
    xyz: [f64; 3],
    yxz: [f64; 3],
    zxz: [f64; 3],
    zyx: [f64; 3],
}

const SETS: [Set; 3] = [
    Set {
        quaternion: [-0.1677489, -0.7369231, -0.3682588, 0.5414703],
        xyz: [2.07603606, -0.7402790, -1.376712],
        yxz: [-2.0579912, 0.70238301, 2.6488233],
        zxz: [-0.8069433, 1.9362151, -1.733798],
        zyx: [1.1951869, 1.17216717, -2.7404413],
    },
    Set {
        quaternion: [-0.8735598, 0.1145235, -0.2093062, 0.4242270],
        xyz: [-0.02538478, 0.4812086, -0.897943],
        yxz: [0.4813408, -0.02250147, -0.9096943],
        zxz: [1.6193689, 0.4818253, -2.523541],
        zyx: [-0.9600165, 0.27185113, -0.4028824],
    },
    Set {
        quaternion: [0.4266817, -0.2028761, 0.4351581, -0.7664342],
        xyz: [0.74181498, 0.7509456, -2.429857],
        yxz: [0.9022582, 0.51658433, -1.8710396],
        zxz: [0.9442344, 1.0015975, -3.069866],
        zyx: [-2.1586537, 0.06040236, -1.0004280],
    },
];

#[test]
fn one_rotation_in_every_convention_is_one_matrix() {
    for set in &SETS {
        let [w, x, y, z] = set.quaternion;
        // The package turns axes: its matrix is the transpose.
        let m = Quaternion { w, x, y, z }.rotation().unwrap().inverse();
        let rows = |m: &Rotation3<f64>| [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]));

        let [omega, phi, kappa] = set.xyz;
        let opk = OmegaPhiKappa { omega, phi, kappa };
        close(&opk.photo_from_world(), rows(&m), 2e-7);
        let back = OmegaPhiKappa::from_photo_from_world(&m);
        near([back.omega, back.phi, back.kappa], set.xyz, 6e-7);

        let [opposite, omega, kappa] = set.yxz;
        let pok = PhiOmegaKappa { phi: -opposite, omega, kappa };
        close(&pok.photo_from_world(), rows(&m), 2e-7);
        let back = PhiOmegaKappa::from_photo_from_world(&m);
        near([-back.phi, back.omega, back.kappa], set.yxz, 6e-7);

        let [opposite, tilt, turned] = set.zxz;
        let ats = AzimuthTiltSwing { azimuth: -opposite, tilt, swing: turned + PI };
        close(&ats.photo_from_world(), rows(&m), 4e-7);
        let back = AzimuthTiltSwing::from_photo_from_world(&m);
        near([-back.azimuth, back.tilt, back.swing - PI], set.zxz, 6e-7);

        let [yaw, pitch, roll] = set.zyx;
        let ypr = YawPitchRoll { yaw, pitch, roll };
        close(&ypr.body_from_ned(), rows(&m), 2e-7);
        let back = YawPitchRoll::from_body_from_ned(&m);
        near([back.yaw, back.pitch, back.roll], set.zyx, 6e-7);

        let back = Quaternion::from_rotation(&m.inverse());
        let sign = 1f64.copysign(w);
        near([back.w, back.x, back.y], [sign * w, sign * x, sign * y], 1e-7);
        assert!((back.z - sign * z).abs() < 1e-7);
    }
}

// The same package: the same four numbers read scalar last, with the axis and the angle in degrees it prints for them.
#[test]
fn axis_and_angle_of_a_quaternion_read_scalar_last() {
    let cases = [
        (0, [-0.1995301, -0.8765382, -0.4380279], 114.4324),
        (1, [-0.9646669, 0.1264676, -0.2311356], 129.7965),
        (2, [0.6642793, -0.3158476, 0.6774757], 280.0695f64),
    ];
    for (index, axis, degrees) in cases {
        let [x, y, z, w] = SETS[index].quaternion;
        let r = Quaternion { w, x, y, z }.rotation().unwrap();
        let vector = RotationVector::new(Vector3::from(axis) * degrees.to_radians());
        assert!(largest(vector.rotation().matrix() - r.matrix()) < 2e-6);
        // More than half a turn comes back as less than half a turn about the opposite axis.
        let back = RotationVector::from_rotation(&r);
        let (sign, expected) =
            if degrees > 180.0 { (-1.0, 360.0 - degrees) } else { (1.0, degrees) };
        assert!((back.angle().to_degrees() - expected).abs() < 1e-4);
        assert!((back.vector().normalize() - Vector3::from(axis) * sign).amax() < 1e-6);
    }
    // The matrix it prints for set 1 turns axes: the transpose of ours.
    let [x, y, z, w] = SETS[0].quaternion;
    close(
        &Quaternion { w, x, y, z }.rotation().unwrap().inverse(),
        [
            [-0.3573404, -0.1515663, 0.9215940],
            [0.6460385, 0.6724915, 0.3610947],
            [-0.6744939, 0.7244189, -0.1423907],
        ],
        1e-7,
    );
}

// Unit test of the Python package pure_poser (poser/rotation_converter.py): world_from_photo to four decimals, degrees.
#[test]
fn omega_phi_kappa_of_a_printed_matrix() {
    let printed =
        Matrix3::new(-0.9447, 0.0256, -0.3270, -0.0967, -0.9743, 0.2032, -0.3134, 0.2236, 0.9229);
    let rotation = orthonormalised(&printed).unwrap().inverse();
    let back = OmegaPhiKappa::from_photo_from_world(&rotation);
    let degrees = [back.omega, back.phi, back.kappa].map(f64::to_degrees);
    near(degrees, [-12.4170, -19.0871, -178.4477], 5e-3);
    let [omega, phi, kappa] = [-12.4170f64, -19.0871, -178.4477].map(f64::to_radians);
    close(
        &OmegaPhiKappa { omega, phi, kappa }.photo_from_world().inverse(),
        [[-0.9447, 0.0256, -0.3270], [-0.0967, -0.9743, 0.2032], [-0.3134, 0.2236, 0.9229]],
        0.6e-4,
    );

    // Its gimbal lock: ω = 0, φ = 90°, κ = 19.9988°.
    let printed = Matrix3::new(0.0, 0.0, 1.0, 0.3420, 0.9397, 0.0, -0.9397, 0.3420, 0.0);
    let locked =
        OmegaPhiKappa::from_photo_from_world(&orthonormalised(&printed).unwrap().inverse());
    assert_eq!(locked.omega, 0.0);
    assert_eq!(locked.phi, FRAC_PI_2);
    assert!((locked.kappa.to_degrees() - 19.9988).abs() < 0.5e-4);
}

// The resection example of Wuhan University's textbook Photogrammetry: with its six computed values the collinearity
// equations return the measured coordinates (mm) of its four points; the largest residual of the adjustment is 6.5 µm.
#[test]
fn phi_omega_kappa_images_the_points_of_the_wuhan_resection() {
    let points = [
        ([-86.15, -68.99], [36589.41, 25273.32, 2195.17]),
        ([-53.40, 82.21], [37631.08, 31324.51, 728.69]),
        ([-14.78, -76.63], [39100.97, 24934.98, 2386.50]),
        ([10.46, 64.43], [40426.54, 30319.81, 757.31]),
    ];
    let m = PhiOmegaKappa { phi: -0.0039869, omega: 0.0021139, kappa: -0.0675780 };
    let centre = Point3::new(39795.45, 27476.46, 7572.69);
    for (image, world) in points {
        let d = m.photo_from_world() * (Point3::from(world) - centre);
        let [x, y] = [-153.24 * d.x / d.z, -153.24 * d.y / d.z];
        assert!((x - image[0]).abs() < 0.0075 && (y - image[1]).abs() < 0.0075, "{x} {y}");
    }
}

// MathWorks' pages: angle2dcm (Aerospace Toolbox), dcm2angle with 14 decimals, se3.eul (the transpose).
#[test]
fn yaw_pitch_roll_of_printed_matrices() {
    let m = YawPitchRoll { yaw: PI / 4.0, pitch: PI / 3.0, roll: PI / 8.0 }.body_from_ned();
    close(
        &m.inverse(),
        [[0.3536, -0.4189, 0.8364], [0.3536, 0.8876, 0.2952], [-0.8660, 0.1913, 0.4619]],
        0.5e-4,
    );
    let m = YawPitchRoll { yaw: 0.0, pitch: FRAC_PI_2, roll: 0.0 }.body_from_ned().inverse();
    close(&m, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]], 1e-16);
    // The sequence YXZ with (0.3, 0.1, 0.5) is φ = −0.3, ω = 0.1, κ = 0.5 of the Chinese form.
    let m = PhiOmegaKappa { phi: -0.3, omega: 0.1, kappa: 0.5 }.photo_from_world();
    close(
        &m,
        [
            [0.85253103550038, 0.47703040785184, -0.21361840626067],
            [-0.43212157513194, 0.87319830445628, 0.22537893734811],
            [0.29404383655186, -0.09983341664683, 0.95056378592206],
        ],
        1e-14,
    );
}

// MathWorks' dcm2quat: the matrix between ENU and NED axes is the quaternion (0, √½, √½, 0).
#[test]
fn quaternion_of_half_turns() {
    let q = Quaternion::from_rotation(&ned_from_enu());
    let half = 0.5f64.sqrt();
    assert!(q.w == 0.0 && (q.x - half).abs() < 2e-16 && (q.y - half).abs() < 2e-16 && q.z == 0.0);
    let q = Quaternion::from_rotation(&camera_from_photo());
    assert_eq!([q.w, q.x, q.y, q.z], [0.0, 1.0, 0.0, 0.0]);
    let r = Quaternion { w: 1.0, x: 0.0, y: 1.0, z: 0.0 }.rotation().unwrap().inverse();
    close(&r, [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], 4e-16);
}

// SciPy's documentation of Rotation.from_rotvec and from_quat (scalar last there).
#[test]
fn rotation_vectors_of_quarter_turns() {
    let r = RotationVector { x: 0.0, y: 0.0, z: FRAC_PI_2 }.rotation();
    close(&r, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], 3e-16);
    let r = RotationVector { x: FRAC_PI_2, y: 0.0, z: 0.0 }.rotation();
    close(&r, [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], 3e-16);
    let r = Quaternion { w: 0.0, x: 1.0, y: 1.0, z: 0.0 }.rotation().unwrap();
    close(&r, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], 3e-16);
}

// Pix4D, support article 202558969: yaw 0, 90, 270 with a nadir camera put north, east, west at the top of the image;
// at pitch 90 the camera looks forward.
#[test]
fn a_nadir_camera_follows_the_heading_of_its_aircraft() {
    let camera = |yaw: f64, pitch: f64| {
        let attitude = YawPitchRoll { yaw: yaw.to_radians(), pitch: pitch.to_radians(), roll: 0.0 };
        nadir_camera_from_body() * attitude.body_from_ned() * ned_from_enu()
    };
    let top = Vector3::new(0.0, -1.0, 0.0);
    for (yaw, east, north) in [(0.0, 0.0, 1.0), (90.0, 1.0, 0.0), (270.0, -1.0, 0.0)] {
        let towards = camera(yaw, 0.0).inverse() * top;
        assert!((towards - Vector3::new(east, north, 0.0)).amax() < 1e-15);
    }
    let axis = camera(0.0, 90.0).inverse() * Vector3::z();
    assert!((axis - Vector3::y()).amax() < 1e-15);
    // The forward mounting at pitch 0 is the nadir mounting at pitch 90, and both are proper rotations.
    let level = forward_camera_from_body()
        * YawPitchRoll { yaw: 0.4, pitch: 0.0, roll: 0.0 }.body_from_ned();
    let raised = nadir_camera_from_body()
        * YawPitchRoll { yaw: 0.4, pitch: FRAC_PI_2, roll: 0.0 }.body_from_ned();
    assert!(largest(level.matrix() - raised.matrix()) < 2e-16);
    for frame in
        [nadir_camera_from_body(), forward_camera_from_body(), ned_from_enu(), camera_from_photo()]
    {
        assert_eq!(frame.matrix().determinant(), 1.0);
    }
}

// CIRN's CIRNangles2R (Bruder & Brodie 2020): these elements, camera axes x left, y up, z forward, swing 0 upright.
#[test]
fn azimuth_tilt_swing_is_also_the_coastal_convention() {
    let (azimuth, tilt, swing) = (2.1f64, 1.3f64, 0.2f64);
    let (sa, ca) = azimuth.sin_cos();
    let (st, ct) = tilt.sin_cos();
    let (ss, cs) = swing.sin_cos();
    let cirn = Matrix3::new(
        -ca * cs - sa * ct * ss,
        cs * sa - ss * ct * ca,
        -ss * st,
        -ss * ca + cs * ct * sa,
        ss * sa + cs * ct * ca,
        cs * st,
        st * sa,
        st * ca,
        -ct,
    );
    let camera_from_cirn = Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
    let m = AzimuthTiltSwing { azimuth, tilt, swing: swing + PI }.photo_from_world();
    let camera_from_world = camera_from_photo() * m;
    assert!(largest(camera_from_world.matrix() - camera_from_cirn * cirn) < 1e-15);
    // Upright in both: the image's top points upwards in the world.
    let upright = AzimuthTiltSwing { azimuth, tilt, swing: PI }.photo_from_world();
    assert!((upright.inverse() * Vector3::y()).z > 0.9);
}

#[test]
fn at_the_lock_the_documented_angle_is_zero() {
    for sign in [1.0, -1.0] {
        for (a, b) in [(0.3, 0.9), (-2.0, 3.0)] {
            let m = OmegaPhiKappa { omega: a, phi: sign * FRAC_PI_2, kappa: b }.photo_from_world();
            let back = OmegaPhiKappa::from_photo_from_world(&m);
            assert_eq!(back.omega, 0.0);
            assert!(largest(back.photo_from_world().matrix() - m.matrix()) < 4.0 * f64::EPSILON);

            let m = PhiOmegaKappa { phi: a, omega: sign * FRAC_PI_2, kappa: b }.photo_from_world();
            let back = PhiOmegaKappa::from_photo_from_world(&m);
            assert_eq!(back.phi, 0.0);
            assert!(largest(back.photo_from_world().matrix() - m.matrix()) < 4.0 * f64::EPSILON);

            let tilt = if sign > 0.0 { 0.0 } else { PI };
            let m = AzimuthTiltSwing { azimuth: a, tilt, swing: b }.photo_from_world();
            let back = AzimuthTiltSwing::from_photo_from_world(&m);
            assert_eq!(back.azimuth, 0.0);
            assert!(largest(back.photo_from_world().matrix() - m.matrix()) < 4.0 * f64::EPSILON);

            let m = YawPitchRoll { yaw: a, pitch: sign * FRAC_PI_2, roll: b }.body_from_ned();
            let back = YawPitchRoll::from_body_from_ned(&m);
            assert_eq!(back.roll, 0.0);
            assert!(largest(back.body_from_ned().matrix() - m.matrix()) < 4.0 * f64::EPSILON);
        }
    }
    // A gimbal that looks straight down keeps its heading.
    let m = YawPitchRoll { yaw: 1.1, pitch: -FRAC_PI_2, roll: 0.0 }.body_from_ned();
    assert!((YawPitchRoll::from_body_from_ned(&m).yaw - 1.1).abs() < 1e-15);
}

#[test]
fn what_is_no_rotation_is_refused_with_its_number() {
    let zero = Quaternion { w: 0.0, x: 0.0, y: -0.0, z: 0.0 };
    assert!(matches!(zero.rotation(), Err(Error::Degenerate { .. })));
    let nan = Quaternion { w: f64::NAN, x: 1.0, y: 0.0, z: 0.0 };
    assert_eq!(nan.rotation(), Err(Error::NotFinite { what: "quaternion" }));
    for scale in [1e-300, 1e-200, 1e200, 1e300] {
        let q = Quaternion { w: scale, x: 0.5 * scale, y: 0.3 * scale, z: 0.1 * scale };
        let r = Quaternion { w: 1.0, x: 0.5, y: 0.3, z: 0.1 }.rotation().unwrap();
        assert!(largest(q.rotation().unwrap().matrix() - r.matrix()) < 4.0 * f64::EPSILON);
    }

    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    assert!(matches!(orthonormalised(&mirror), Err(Error::OutOfRange { value: -1.0, .. })));
    let scaled = Matrix3::identity() * 1.1;
    match orthonormalised(&scaled) {
        Err(Error::Inconsistent { residual, limit, .. }) => {
            assert!((residual - 0.21).abs() < 1e-15);
            assert_eq!(limit, 0.02);
        }
        other => panic!("{other:?}"),
    }
    for bad in [f64::NAN, f64::INFINITY, 1e200, 1e-200] {
        assert!(orthonormalised(&(Matrix3::identity() * bad)).is_err());
    }

    let nan = Rotation3::from_matrix_unchecked(Matrix3::new(
        f64::NAN,
        0.0,
        0.0,
        0.0,
        1.0,
        0.0,
        0.0,
        0.0,
        1.0,
    ));
    assert!(OmegaPhiKappa::from_photo_from_world(&nan).kappa.is_nan());
    assert!(AzimuthTiltSwing::from_photo_from_world(&nan).swing.is_nan());
    assert!(YawPitchRoll::from_body_from_ned(&nan).yaw.is_nan());
    assert!(RotationVector::from_rotation(&nan).x.is_nan());
    let vector = RotationVector { x: f64::NAN, y: 0.0, z: 0.0 };
    assert!(vector.rotation().matrix().iter().all(|e| e.is_nan()));
}

// The nearest rotation is the one a singular value decomposition gives (numpy 2.4.6: U Vᵀ of the printed matrix of
// pure_poser).
#[test]
fn orthonormalised_is_the_polar_factor() {
    let printed =
        Matrix3::new(-0.9447, 0.0256, -0.3270, -0.0967, -0.9743, 0.2032, -0.3134, 0.2236, 0.9229);
    let r = orthonormalised(&printed).unwrap();
    close(&r, POLAR, 4e-16);
    assert!(
        largest(r.matrix() * r.matrix().transpose() - Matrix3::identity()) < 4.0 * f64::EPSILON
    );
}

const POLAR: [[f64; 3]; 3] = [
    [-0.9446809316699213, 0.0255813823643076, -0.3269916363083017],
    [-0.09672401746997483, -0.9743458569045302, 0.20321076639155838],
    [-0.3134045337638204, 0.223597280862956, 0.9229202859440111],
];

// Near the lock as often as away from it.
fn angle() -> impl Strategy<Value = f64> {
    let exact = prop_oneof![Just(0.0), Just(FRAC_PI_2), Just(-FRAC_PI_2), Just(PI), Just(-PI)];
    let tiny = (-18i32..-1, -1.0..1.0f64).prop_map(|(e, m)| m * 10f64.powi(e));
    prop_oneof![-7.0..7.0f64, exact.clone(), (exact, tiny).prop_map(|(a, d)| a + d)]
}

proptest! {
    #[test]
    fn every_convention_gives_its_matrix_back(a in angle(), b in angle(), c in angle()) {
        let limit = 4.0 * f64::EPSILON;
        let m = OmegaPhiKappa { omega: a, phi: b, kappa: c }.photo_from_world();
        let sources = [
            m,
            PhiOmegaKappa { phi: a, omega: b, kappa: c }.photo_from_world(),
            AzimuthTiltSwing { azimuth: a, tilt: b, swing: c }.photo_from_world(),
            YawPitchRoll { yaw: a, pitch: b, roll: c }.body_from_ned(),
            RotationVector { x: a, y: b, z: c }.rotation(),
        ];
        for m in sources {
            let opk = OmegaPhiKappa::from_photo_from_world(&m);
            prop_assert!(opk.phi.abs() <= FRAC_PI_2 && opk.omega.abs() <= PI && opk.kappa > -PI);
            prop_assert!(largest(opk.photo_from_world().matrix() - m.matrix()) <= limit);
            let pok = PhiOmegaKappa::from_photo_from_world(&m);
            prop_assert!(pok.omega.abs() <= FRAC_PI_2 && pok.phi > -PI && pok.kappa > -PI);
            prop_assert!(largest(pok.photo_from_world().matrix() - m.matrix()) <= limit);
            let ats = AzimuthTiltSwing::from_photo_from_world(&m);
            prop_assert!(ats.tilt >= 0.0 && ats.azimuth > -PI && ats.swing > -PI);
            prop_assert!(largest(ats.photo_from_world().matrix() - m.matrix()) <= limit);
            let ypr = YawPitchRoll::from_body_from_ned(&m);
            prop_assert!(ypr.pitch.abs() <= FRAC_PI_2 && ypr.yaw > -PI && ypr.roll > -PI);
            prop_assert!(largest(ypr.body_from_ned().matrix() - m.matrix()) <= limit);
            let q = Quaternion::from_rotation(&m);
            prop_assert!(q.w >= 0.0);
            prop_assert!(largest(q.rotation().unwrap().matrix() - m.matrix()) <= limit);
            let r = RotationVector::from_rotation(&m);
            prop_assert!(r.angle() <= PI * (1.0 + f64::EPSILON));
            prop_assert!(largest(r.rotation().matrix() - m.matrix()) <= 1.5 * limit);
        }
    }

    #[test]
    fn left_rotation_vectors_turn_the_frame(a in -3.0..3.0f64, b in -1.5..1.5f64, c in -3.0..3.0f64) {
        // A step of each angle against the rotation by the left vector, of second order in the step.
        let step = 1e-5;
        let check = |left: Matrix3<f64>, m: Rotation3<f64>, moved: [Rotation3<f64>; 3]| {
            for (k, moved) in moved.into_iter().enumerate() {
                let turn = RotationVector::new(left.column(k) * step).rotation();
                assert!(largest((turn * m).matrix() - moved.matrix()) < 1e-9, "{k}");
            }
        };
        let opk = |a, b, c| OmegaPhiKappa { omega: a, phi: b, kappa: c };
        check(
            opk(a, b, c).left_from_angles(),
            opk(a, b, c).photo_from_world(),
            [opk(a + step, b, c), opk(a, b + step, c), opk(a, b, c + step)].map(|o| o.photo_from_world()),
        );
        let pok = |a, b, c| PhiOmegaKappa { phi: a, omega: b, kappa: c };
        check(
            pok(a, b, c).left_from_angles(),
            pok(a, b, c).photo_from_world(),
            [pok(a + step, b, c), pok(a, b + step, c), pok(a, b, c + step)].map(|o| o.photo_from_world()),
        );
        let ats = |a, b, c| AzimuthTiltSwing { azimuth: a, tilt: b, swing: c };
        check(
            ats(a, b, c).left_from_angles(),
            ats(a, b, c).photo_from_world(),
            [ats(a + step, b, c), ats(a, b + step, c), ats(a, b, c + step)].map(|o| o.photo_from_world()),
        );
        let ypr = |a, b, c| YawPitchRoll { yaw: a, pitch: b, roll: c };
        check(
            ypr(a, b, c).left_from_angles(),
            ypr(a, b, c).body_from_ned(),
            [ypr(a + step, b, c), ypr(a, b + step, c), ypr(a, b, c + step)].map(|o| o.body_from_ned()),
        );
    }

    #[test]
    fn printed_digits_cost_no_more_than_their_rounding(a in angle(), b in angle(), c in angle(), digits in 2i32..9) {
        let m = OmegaPhiKappa { omega: a, phi: b, kappa: c }.photo_from_world();
        let unit = 10f64.powi(digits);
        let printed = m.matrix().map(|e| (e * unit).round() / unit);
        let r = orthonormalised(&printed).unwrap();
        prop_assert!(largest(r.matrix() * r.matrix().transpose() - Matrix3::identity()) <= 4.0 * f64::EPSILON);
        prop_assert!((r.matrix() - m.matrix()).norm() <= 3.0 / unit);
    }

    #[test]
    fn no_number_makes_a_conversion_panic(a in any::<f64>(), b in any::<f64>(), c in any::<f64>(), d in any::<f64>()) {
        let m = OmegaPhiKappa { omega: a, phi: b, kappa: c }.photo_from_world();
        let _ = (OmegaPhiKappa::from_photo_from_world(&m), AzimuthTiltSwing::from_photo_from_world(&m));
        let _ = (YawPitchRoll::from_body_from_ned(&m), Quaternion::from_rotation(&m));
        let r = RotationVector { x: a, y: b, z: c };
        prop_assert!(r.rotation().matrix().iter().all(|e| e.abs() <= 1.0 + 1e-15 || e.is_nan()));
        let _ = r.left_from_vector();
        if let Ok(r) = (Quaternion { w: a, x: b, y: c, z: d }).rotation() {
            prop_assert!(largest(r.matrix() * r.matrix().transpose() - Matrix3::identity()) <= 6.0 * f64::EPSILON);
        }
        let raw = Matrix3::new(a, b, c, d, a, b, c, d, a);
        let _ = orthonormalised(&raw);
        let raw = Rotation3::from_matrix_unchecked(raw);
        let _ = (PhiOmegaKappa::from_photo_from_world(&raw), RotationVector::from_rotation(&raw));
    }
}
