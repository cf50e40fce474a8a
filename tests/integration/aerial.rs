//! Refraction and earth curvature in aerial photographs.

use std::f64::consts::FRAC_PI_2;

use collinear::camera::{
    BrownCamera, CentralModel, EarthCurvature, ExteriorOrientation, Frame, InteriorOrientation,
    Refraction,
};
use collinear::geometry::rotation::OmegaPhiKappa;
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix3, Point2, Point3, Rotation3, UnitVector3, Vector3};
use proptest::prelude::*;
use serde_json::Value;

fn oracle() -> Value {
    serde_json::from_str(include_str!("../data/oracles/aerial.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let one = |v: &Value| v.as_f64().unwrap_or_else(|| v.as_str().unwrap().parse().unwrap());
    value.as_array().unwrap().iter().map(one).collect()
}

fn number(case: &Value, name: &str) -> f64 {
    case[name].as_f64().unwrap()
}

/// The oracle's camera in the attitude of a case, its image point and the corrected one.
fn photograph(case: &Value) -> (Frame<InteriorOrientation>, Point2<f64>, Point2<f64>) {
    let rows = Matrix3::from_row_slice(&numbers(&case["rotation"]));
    let rotation = Rotation3::from_matrix_unchecked(rows);
    let camera = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 480.0), 0.0).unwrap();
    // Where the camera stands is nothing to the corrections.
    let exterior = ExteriorOrientation::new(Point3::new(4.5e5, 5.4e6, 3000.0), rotation);
    let (image, corrected) = (numbers(&case["image"]), numbers(&case["corrected"]));
    let point = |c: &[f64]| Point2::new(c[0], c[1]);
    (Frame::new(exterior, camera), point(&image), point(&corrected))
}

/// How far the image moves on a radian at this angle from the nadir, at most.
fn pixels_per_radian(frame: &Frame<InteriorOrientation>, image: &Point2<f64>) -> f64 {
    let cosine = frame.camera.direction(image).unwrap().z;
    1000.0 / (cosine * cosine)
}

/// A direction at an angle from the nadir, east of it, with the vertical up.
fn at(angle: f64) -> Vector3<f64> {
    Vector3::new(angle.sin(), 0.0, -angle.cos())
}

fn angle_of(direction: &Vector3<f64>) -> f64 {
    direction.x.hypot(direction.y).atan2(-direction.z)
}

#[test]
fn the_refraction_of_the_manual_of_photogrammetry() {
    // Manual of Photogrammetry, 4th edition (Slama 1980), p. 487: µrad at 45° over ground at sea level, H in km; as quoted in
    // test_Refraction.cpp of AeroPlygiant (Stellacore 2024).
    let table = [
        (0.5, 4.9),
        (1.0, 9.8),
        (1.5, 14.9),
        (2.0, 19.9),
        (2.5, 25.0),
        (3.0, 30.0),
        (3.5, 35.0),
        (4.0, 39.8),
        (4.5, 44.6),
        (5.0, 49.2),
        (5.5, 53.6),
        (6.0, 57.8),
        (6.5, 61.9),
        (7.0, 65.6),
        (7.5, 69.2),
        (8.0, 72.5),
        (8.5, 75.5),
        (9.0, 78.3),
        (9.5, 80.8),
        (10.0, 83.1),
    ];
    for (height, printed) in table {
        let refraction = Refraction::ardc(height * 1000.0, 0.0).unwrap();
        let seen = at(45f64.to_radians());
        let straight = refraction.straight(&seen, &Vector3::z_axis()).unwrap();
        let bending = (angle_of(&seen) - angle_of(&straight)) * 1e6;
        assert!((bending - printed).abs() < 0.06, "{height} km: {bending} and {printed}");
    }
    // Schmid, in the archives of ISPRS commission III (goobi.tib.eu 1662435576, p. 99): at most 27″ for a depression of 35° from 18 km.
    for make in [Refraction::ardc, Refraction::standard_atmosphere] {
        let seen = at(55f64.to_radians());
        let straight = make(18_000.0, 0.0).unwrap().straight(&seen, &Vector3::z_axis()).unwrap();
        let seconds = (angle_of(&seen) - angle_of(&straight)).to_degrees() * 3600.0;
        assert!((seconds - 27.0).abs() < 0.5, "{seconds}");
    }
}

#[test]
fn refraction_is_that_of_rays_traced_through_the_standard_atmosphere() {
    let oracle = oracle();
    let mut worst = [0.0f64; 2];
    for case in oracle["traces"].as_array().unwrap() {
        let (camera, ground) = (number(case, "camera"), number(case, "ground"));
        let refraction = Refraction::standard_atmosphere(camera, ground).unwrap();
        let flat = number(case, "flat");
        worst[0] = worst[0].max((refraction.constant() / flat - 1.0).abs());
        assert!((refraction.constant() / flat - 1.0).abs() < 0.003, "{camera} {ground}");
        for pair in case["bending"].as_array().unwrap() {
            let [degrees, traced] = numbers(pair)[..] else { panic!() };
            let seen = at(degrees.to_radians());
            let straight = refraction.straight(&seen, &Vector3::z_axis()).unwrap();
            let bending = angle_of(&seen) - angle_of(&straight);
            // The flat Earth's law, as its documentation says.
            let within = match degrees {
                ..=45.0 => 0.004,
                ..=60.0 => 0.005,
                _ => 0.02,
            };
            if camera <= 12_000.0 {
                assert!((bending / traced - 1.0).abs() < within, "{camera} {ground} {degrees}");
            }
        }
        if ground == 0.0 {
            let off = Refraction::ardc(camera, ground).unwrap().constant() - flat;
            worst[1] = worst[1].max(off.abs());
            assert!(off.abs() < 5e-6, "{camera}: {off}");
        }
    }
    // The statements are no better than they must be.
    assert!(worst[0] > 0.0015 && worst[1] > 4e-6, "{worst:?}");
    // Over high ground the textbooks' formula gives about (1 + h/H) times the refraction.
    let high = Refraction::ardc(5000.0, 2000.0).unwrap().constant();
    let true_one = Refraction::standard_atmosphere(5000.0, 2000.0).unwrap().constant();
    assert!((high / true_one - 1.4).abs() < 0.02, "{high} {true_one}");
}

#[test]
fn corrections_of_tilted_photographs_agree_with_fifty_digits() {
    let oracle = oracle();
    let up = Vector3::z_axis();
    let cases = oracle["refraction"].as_array().unwrap();
    assert!(cases.len() >= 30);
    for case in cases {
        let (frame, image, expected) = photograph(case);
        let refraction = Refraction::from_constant(number(case, "constant")).unwrap();
        let within = 4e-15 * pixels_per_radian(&frame, &image) + 1e-12;
        let corrected = refraction.corrected(&frame, &up, &image).unwrap();
        assert!((corrected - expected).norm() < within, "{corrected} {expected} {case}");
        let back = refraction.displaced(&frame, &up, &expected).unwrap();
        assert!((back - image).norm() < 2.0 * within, "{back} {image} {case}");
    }
    let cases = oracle["curvature"].as_array().unwrap();
    assert!(cases.len() >= 60);
    for case in cases {
        let (frame, image, expected) = photograph(case);
        let [radius, camera, ground, lengths] =
            ["radius", "camera", "ground", "lengths"].map(|name| number(case, name));
        let curvature = EarthCurvature::new(radius, camera, ground).unwrap();
        let curvature = curvature.with_lengths_at(lengths).unwrap();
        // Where the ray grazes the horizon, its meeting with the ground is known that much worse.
        let horizon = ((radius + ground) / (radius + camera)).asin();
        let grazing = (horizon / (horizon - number(case, "angle"))).sqrt();
        let within = 1e-14 * grazing * pixels_per_radian(&frame, &expected) + 1e-12;
        let corrected = curvature.corrected(&frame, &up, &image).unwrap();
        assert!((corrected - expected).norm() < within, "{corrected} {expected} {case}");
        let back = curvature.displaced(&frame, &up, &expected).unwrap();
        let within = 1e-14 * grazing * pixels_per_radian(&frame, &image) + 1e-12;
        assert!((back - image).norm() < within, "{back} {image} {case}");
    }
}

#[test]
fn the_photogrammetric_formula_is_the_first_term() {
    // r′ − r = (H − h) r³ / (2 R c²), by hand: c = 152, r = 40, 80, 120, 150 mm, H − h = 5 km, R = 6371 km.
    let curvature = EarthCurvature::new(6371e3, 5500.0, 500.0).unwrap();
    for (radius, printed) in [(40.0, 0.00109), (80.0, 0.00870), (120.0, 0.02935), (150.0, 0.05732)]
    {
        let direction = Vector3::new(radius / 152.0, 0.0, -1.0);
        let flat = curvature.flat(&direction, &Vector3::z_axis()).unwrap();
        let moved = 152.0 * (flat.x / -flat.z) - radius;
        assert!((moved - printed).abs() < 0.003 * printed + 5e-6, "{radius}: {moved}");
    }
    // Lengths at sea level are shorter by h/R: 500 m do as much as 0.0000785 of r.
    let sea = curvature.with_lengths_at(0.0).unwrap();
    let flat = sea.flat(&Vector3::new(0.5, 0.0, -1.0), &Vector3::z_axis()).unwrap();
    let map = curvature.flat(&Vector3::new(0.5, 0.0, -1.0), &Vector3::z_axis()).unwrap();
    let ratio = (flat.x / flat.z) / (map.x / map.z);
    assert!((1.0 - ratio - 500.0 / 6371.5e3).abs() < 1e-12, "{ratio}");
}

#[test]
fn heights_and_rays_without_a_correction_are_refused() {
    for make in [Refraction::ardc, Refraction::standard_atmosphere] {
        for (camera, ground) in [
            (100_001.0, 0.0),
            (1000.0, -501.0),
            (1000.0, 1000.0),
            (1000.0, 2000.0),
            (-600.0, -700.0),
        ] {
            let error = make(camera, ground).unwrap_err();
            assert!(matches!(error, Error::OutOfRange { .. }), "{camera} {ground}: {error}");
        }
        for (camera, ground) in [(f64::NAN, 0.0), (1000.0, f64::INFINITY)] {
            assert!(matches!(make(camera, ground), Err(Error::NotFinite { .. })));
        }
        assert!(make(100_000.0, -500.0).is_ok());
    }
    assert!(matches!(Refraction::ardc(-100.0, -400.0), Err(Error::OutOfRange { .. })));
    assert!(Refraction::standard_atmosphere(-100.0, -400.0).is_ok());
    // Hardly any air between a camera and the ground; 40 digits of mpmath 1.4.1, the formula put in.
    for (camera, ground, expected) in [
        (1000.05, 1000.0, 6.175_396_154_78e-10),
        (1000.2, 1000.0, 2.470_139_890_11e-9),
        (2000.001, 2000.0, 1.144_618_145_54e-11),
    ] {
        let found = Refraction::standard_atmosphere(camera, ground).unwrap().constant();
        assert!((found / expected - 1.0).abs() < 5e-6, "{camera}: {found}");
    }
    for ground in [0.0, 1000.0, 8000.0, 20_000.0] {
        for k in 1..9 {
            let camera = ground + 0.1_f64.powi(k) / 3.0;
            let near = Refraction::standard_atmosphere(camera, ground).unwrap();
            assert!(near.constant() < 1e-8, "{camera}: {near:?}");
        }
    }
    for constant in [-1e-9, 0.011, 1.0] {
        assert!(matches!(Refraction::from_constant(constant), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(Refraction::from_constant(f64::NAN), Err(Error::NotFinite { .. })));

    let up = Vector3::z_axis();
    let refraction = Refraction::from_constant(1e-4).unwrap();
    let outside = |r: Result<Vector3<f64>, ProjectionError>, limit: f64| match r {
        Err(ProjectionError::OutsideDomain { value, limit: stated }) => {
            assert!((stated - limit).abs() < 1e-9 && value >= stated - 1e-12, "{value} {stated}");
        }
        other => panic!("{other:?}"),
    };
    // The law folds at cos² α = K.
    let fold = 0.01f64.acos();
    for angle in [fold + 1e-9, FRAC_PI_2, FRAC_PI_2 + 0.5, 3.1] {
        outside(refraction.straight(&at(angle), &up), fold);
    }
    assert!(refraction.straight(&at(fold - 1e-6), &up).is_ok());
    let highest = fold - 1e-4 * fold.tan();
    outside(refraction.bent(&at(highest + 1e-9), &up), highest);
    assert!(refraction.bent(&at(highest - 1e-6), &up).is_ok());
    let none = Refraction::from_constant(0.0).unwrap();
    outside(none.straight(&at(FRAC_PI_2 + 1e-12), &up), FRAC_PI_2);
    assert!((none.bent(&at(1.5), &up).unwrap() - at(1.5)).norm() < 1e-15);

    let curvature = EarthCurvature::new(6371e3, 9000.0, 0.0).unwrap();
    let horizon = (6371.0f64 / 6380.0).asin();
    for angle in [horizon + 1e-9, FRAC_PI_2, 2.0, 3.1] {
        outside(curvature.flat(&at(angle), &up), horizon);
    }
    assert!(curvature.flat(&at(horizon - 1e-6), &up).is_ok());
    let farthest = (6371e3 * (6371.0f64 / 6380.0).acos() / 9000.0).atan();
    outside(curvature.curved(&at(farthest + 1e-6), &up), farthest);
    assert!(curvature.curved(&at(farthest - 1e-6), &up).is_ok());
    for (radius, camera, ground) in [
        (0.0, 1.0, 0.0),
        (-1.0, 1.0, 0.0),
        (1e300, 1.0, 0.0),
        (10.0, 5.0, -10.0),
        (10.0, 5.0, 5.0),
        (10.0, 1e200, 5.0),
    ] {
        let error = EarthCurvature::new(radius, camera, ground).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    assert!(matches!(EarthCurvature::new(f64::NAN, 1.0, 0.0), Err(Error::NotFinite { .. })));
    assert!(matches!(curvature.with_lengths_at(-7e6), Err(Error::OutOfRange { .. })));
    assert!(matches!(curvature.with_lengths_at(f64::NAN), Err(Error::NotFinite { .. })));

    for broken in [
        Vector3::zeros(),
        Vector3::new(f64::NAN, 0.0, -1.0),
        Vector3::new(0.0, 0.0, f64::NEG_INFINITY),
    ] {
        for result in [
            refraction.straight(&broken, &up),
            refraction.bent(&broken, &up),
            curvature.flat(&broken, &up),
            curvature.curved(&broken, &up),
        ] {
            assert_eq!(result, Err(ProjectionError::NotFinite), "{broken}");
        }
    }
    // Any length will do.
    for scale in [1e-300, 1e300] {
        let straight = refraction.straight(&(at(1.0) * scale), &up).unwrap();
        assert!((straight - refraction.straight(&at(1.0), &up).unwrap()).norm() < 1e-15);
    }
}

fn unit() -> impl Strategy<Value = UnitVector3<f64>> {
    (-1.0..1.0f64, -3.1..3.1f64).prop_map(|(z, a)| {
        let r = (1.0 - z * z).sqrt();
        UnitVector3::new_normalize(Vector3::new(r * a.cos(), r * a.sin(), z))
    })
}

proptest! {
    /// Refraction is taken away towards the nadir point and curvature away from it, along the line to it; the nadir point stays; each has its
    /// inverse. In the photograph of any attitude, about any vertical.
    #[test]
    fn corrections_point_to_and_from_the_nadir(
        up in unit(),
        (omega, phi, kappa) in (-0.6..0.6f64, -0.6..0.6f64, -3.0..3.0f64),
        (x, y) in (-0.6..0.6f64, -0.6..0.6f64),
        (camera_height, over) in (500.0..12_000.0f64, 0.1..0.9f64),
    ) {
        let camera = BrownCamera::new(
            InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 480.0), 0.0).unwrap(),
            collinear::camera::Brown::new([-0.05, 0.01, 0.0], [1e-4, -2e-4]).unwrap(),
        );
        // Level about the vertical, then tilted.
        let level = Rotation3::rotation_between(&up, &Vector3::z()).unwrap_or_else(Rotation3::identity);
        let tilt = ExteriorOrientation::from_omega_phi_kappa(Point3::origin(), &OmegaPhiKappa { omega, phi, kappa });
        let exterior = ExteriorOrientation::new(Point3::origin(), tilt.camera_from_world() * level);
        let frame = Frame::new(exterior, camera);
        let refraction = Refraction::standard_atmosphere(camera_height, camera_height * over).unwrap();
        let curvature = EarthCurvature::new(6.371e6, camera_height, camera_height * over).unwrap();

        let image = camera.project_direction(&Vector3::new(x, y, 1.0)).unwrap();
        let ray = exterior.camera_from_world().inverse_transform_vector(&camera.direction(&image).unwrap());
        prop_assume!(-ray.dot(&up) > 0.15);
        let without_air = refraction.corrected(&frame, &up, &image).unwrap();
        let on_map = curvature.corrected(&frame, &up, &image).unwrap();
        // The rays lie in the vertical plane of the measured one, each on its side.
        let side = |p: &Point2<f64>| {
            let other = exterior.camera_from_world().inverse_transform_vector(&camera.direction(p).unwrap());
            prop_assert!(other.dot(&ray.cross(&up)).abs() < 1e-13, "{}", other.dot(&ray.cross(&up)));
            Ok(-other.dot(&up) + ray.dot(&up))
        };
        let moved = ray.cross(&up).norm();
        prop_assume!(moved > 0.01);
        prop_assert!(side(&without_air)? > 0.0);
        prop_assert!(side(&on_map)? < 0.0);
        prop_assert!((refraction.displaced(&frame, &up, &without_air).unwrap() - image).norm() < 1e-9);
        prop_assert!((curvature.displaced(&frame, &up, &on_map).unwrap() - image).norm() < 1e-9);

        let down = exterior.camera_from_world().transform_vector(&-up.into_inner());
        let nadir = camera.project_direction(&down).unwrap();
        prop_assert!((refraction.corrected(&frame, &up, &nadir).unwrap() - nadir).norm() < 1e-10);
        prop_assert!((curvature.corrected(&frame, &up, &nadir).unwrap() - nadir).norm() < 1e-10);
    }
}
