//! Rational polynomial cameras: 60-digit numbers and GDAL's, the laws of a sensor, corrections, fits, refusals.

use collinear::camera::rpc::{
    ControlPoint, CorrectionModel, Denominators, FitGrid, FitOptions, ImageCorrection, Rpc, Rpc00b,
    RpcSensor,
};
use collinear::camera::{
    Adjustable, Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation, SensorModel,
};
use collinear::geometry::geodetic::{
    EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic, GeoidGrid, GeoidLayout, LocalFrame,
    OrthometricHeight,
};
use collinear::geometry::{Locus, Plane, Surface};
use collinear::nalgebra::{Matrix2, Point2, Point3, Vector2, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;
use serde_json::Value;

fn oracle() -> Value {
    serde_json::from_str(include_str!("../data/oracles/rpc.json")).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no {key}"))
}

fn list<const N: usize>(value: &Value) -> [f64; N] {
    let all = value.as_array().unwrap();
    assert_eq!(all.len(), N);
    core::array::from_fn(|i| all[i].as_f64().unwrap())
}

fn record() -> Rpc00b {
    let oracle = oracle();
    let m = &oracle["model"];
    Rpc00b {
        line_offset: number(m, "line_offset"),
        sample_offset: number(m, "sample_offset"),
        latitude_offset_deg: number(m, "latitude_offset_deg"),
        longitude_offset_deg: number(m, "longitude_offset_deg"),
        height_offset: number(m, "height_offset"),
        line_scale: number(m, "line_scale"),
        sample_scale: number(m, "sample_scale"),
        latitude_scale_deg: number(m, "latitude_scale_deg"),
        longitude_scale_deg: number(m, "longitude_scale_deg"),
        height_scale: number(m, "height_scale"),
        line_numerator: list(&m["line_numerator"]),
        line_denominator: list(&m["line_denominator"]),
        sample_numerator: list(&m["sample_numerator"]),
        sample_denominator: list(&m["sample_denominator"]),
        error_bias: Some(number(m, "error_bias")),
        error_random: Some(number(m, "error_random")),
    }
}

fn rpc() -> Rpc {
    Rpc::from_rpc00b(&record()).unwrap()
}

fn place(latitude_deg: f64, longitude_deg: f64, height: f64) -> Geodetic {
    Geodetic::from_degrees(latitude_deg, longitude_deg, EllipsoidalHeight(height)).unwrap()
}

fn ground_of(point: &Value) -> Geodetic {
    place(number(point, "latitude_deg"), number(point, "longitude_deg"), number(point, "height"))
}

/// A place of the model's cube, by its normalised coordinates.
fn inside(l: f64, p: f64, h: f64) -> Geodetic {
    let r = record();
    place(
        r.latitude_offset_deg + p * r.latitude_scale_deg,
        r.longitude_offset_deg + l * r.longitude_scale_deg,
        r.height_offset + h * r.height_scale,
    )
}

fn correction() -> ImageCorrection {
    let linear = Matrix2::new(2e-4, -3e-4, 1e-4, 5e-4);
    ImageCorrection::new(Point2::new(6000.0, 4000.0), Vector2::new(3.5, -7.25), linear).unwrap()
}

fn local() -> EarthFrame {
    EarthFrame::Local(LocalFrame::east_north_up(Ellipsoid::WGS84, place(44.1, 5.2, 300.0)))
}

fn geocentric() -> EarthFrame {
    EarthFrame::Geocentric(Ellipsoid::WGS84)
}

/// A geoid of waves 30 m high, about 50 m.
fn geoid() -> GeoidGrid {
    let layout = GeoidLayout {
        south_deg: 43.0,
        west_deg: 4.0,
        latitude_step_deg: 0.1,
        longitude_step_deg: 0.1,
        rows: 24,
        columns: 27,
    };
    let node = |i: usize| {
        let (row, column) = ((i / 27) as f32, (i % 27) as f32);
        50.0 + 30.0 * (0.7 * row).sin() * (0.5 * column).cos()
    };
    GeoidGrid::new(layout, (0..24 * 27).map(node).collect()).unwrap()
}

#[test]
fn all_eighty_coefficients_agree_with_sixty_digits_and_gdal() {
    let rpc = rpc();
    let points = oracle()["points"].as_array().unwrap().clone();
    assert_eq!(points.len(), 40);
    for point in &points {
        let p = rpc.project(&ground_of(point)).unwrap();
        let height = EllipsoidalHeight(number(point, "height"));
        let (latitude, longitude) = (number(point, "latitude_deg"), number(point, "longitude_deg"));
        let exact = rpc.project_degrees(latitude, longitude, height).unwrap();
        for by in ["image", "gdal"] {
            let [x, y] = list::<2>(&point[by]);
            assert!((p - Point2::new(x, y)).amax() < 1e-9, "{by}: {}", p - Point2::new(x, y));
            let off = (exact - Point2::new(x, y)).amax();
            assert!(off < 2e-11, "{by}, degrees: {off:e}");
        }
    }
}

#[test]
fn partials_of_a_rational_camera_agree_with_sixty_digits() {
    for point in oracle()["points"].as_array().unwrap() {
        let (_, slopes) = rpc().project_jacobian(&ground_of(point)).unwrap();
        for (j, key) in ["by_latitude", "by_longitude", "by_height"].iter().enumerate() {
            let expected = Vector2::from(list::<2>(&point[*key]));
            let off = (slopes.column(j) - expected).norm();
            assert!(off < 1e-13 * slopes.column(j).norm().max(1.0), "{key}: {off:e}");
        }
    }
}

#[test]
fn the_half_pixel_is_crossed_once() {
    // At the centre of a model whose constants are zero, line and sample are the offsets: of a pixel's centre.
    let mut r = record();
    (r.line_numerator[0], r.sample_numerator[0]) = (0.0, 0.0);
    (r.line_offset, r.sample_offset) = (7.0, 11.0);
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    let p = rpc.project(&inside(0.0, 0.0, 0.0)).unwrap();
    assert!((p - Point2::new(11.5, 7.5)).norm() < 1e-9);
    assert_eq!(rpc.image_centre(), Point2::new(11.5, 7.5));
    assert_eq!(rpc.to_rpc00b(), r);
}

#[test]
fn every_number_of_the_model_moves_the_image() {
    let ground = inside(0.71, -0.57, 0.83);
    let before = rpc().project(&ground).unwrap();
    let differs = |name: &str, change: &dyn Fn(&mut Rpc00b)| {
        let mut r = record();
        change(&mut r);
        let after = Rpc::from_rpc00b(&r).unwrap().project(&ground).unwrap();
        assert!((after - before).norm() > 1e-4, "{name}");
    };
    for k in 0..20 {
        differs(&format!("line numerator {k}"), &|r| r.line_numerator[k] += 1e-5);
        differs(&format!("line denominator {k}"), &|r| r.line_denominator[k] += 1e-5);
        differs(&format!("sample numerator {k}"), &|r| r.sample_numerator[k] += 1e-5);
        differs(&format!("sample denominator {k}"), &|r| r.sample_denominator[k] += 1e-5);
    }
    differs("line offset", &|r| r.line_offset += 0.01);
    differs("sample offset", &|r| r.sample_offset += 0.01);
    differs("latitude offset", &|r| r.latitude_offset_deg += 1e-6);
    differs("longitude offset", &|r| r.longitude_offset_deg += 1e-6);
    differs("height offset", &|r| r.height_offset += 0.1);
    differs("line scale", &|r| r.line_scale += 0.01);
    differs("sample scale", &|r| r.sample_scale += 0.01);
    differs("latitude scale", &|r| r.latitude_scale_deg += 1e-6);
    differs("longitude scale", &|r| r.longitude_scale_deg += 1e-6);
    differs("height scale", &|r| r.height_scale += 0.1);
}

#[test]
fn a_picture_may_lie_across_the_date_line() {
    let mut r = record();
    r.longitude_offset_deg = 179.98;
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    let (east, west) = (place(44.1, 180.05, 900.0), place(44.1, -179.95, 900.0));
    let (p, q) = (rpc.project(&east).unwrap(), rpc.project(&west).unwrap());
    assert!((p - q).norm() < 1e-7);
    let degrees = |l| rpc.project_degrees(44.1, l, EllipsoidalHeight(900.0)).unwrap();
    assert!((degrees(180.05) - degrees(-179.95)).norm() < 1e-7);
    let back = rpc.at_height(&p, EllipsoidalHeight(900.0)).unwrap();
    assert!((back.longitude().to_degrees() + 179.95).abs() < 1e-12);
    r.longitude_offset_deg = -179.98;
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    let q = rpc.project(&place(44.1, 179.96, 900.0)).unwrap();
    let back = rpc.at_height(&q, EllipsoidalHeight(900.0)).unwrap();
    assert!((back.longitude().to_degrees() - 179.96).abs() < 1e-12);
}

proptest! {
    #[test]
    fn the_image_of_a_place_leads_back_to_it(
        l in -1.4..1.4f64, p in -1.4..1.4f64, h in -1.4..1.4f64, corrected in any::<bool>(),
    ) {
        let rpc = if corrected { rpc().with_correction(correction()) } else { rpc() };
        let ground = inside(l, p, h);
        let image = rpc.project(&ground).unwrap();
        let back = rpc.at_height(&image, ground.height()).unwrap();
        // 10⁻¹⁴ rad are 64 nm.
        prop_assert!((back.latitude() - ground.latitude()).abs() < 1e-14);
        prop_assert!((back.longitude() - ground.longitude()).abs() < 1e-14);
        prop_assert_eq!(back.height(), ground.height());
        prop_assert!((rpc.project(&back).unwrap() - image).norm() < 1e-9);
    }

    #[test]
    fn a_height_above_the_geoid_is_met_and_projected(l in -0.9..0.9f64, p in -0.9..0.9f64, height in 200.0..1900.0f64) {
        let (rpc, geoid) = (rpc(), geoid());
        let image = rpc.project(&inside(l, p, 0.0)).unwrap();
        let height = OrthometricHeight(height);
        let found = rpc.at_orthometric_height(&image, height, &geoid).unwrap();
        let undulation = geoid.undulation(found.latitude(), found.longitude()).unwrap();
        prop_assert!((found.height().0 - undulation - height.0).abs() < 1e-8);
        prop_assert!((rpc.project(&found).unwrap() - image).norm() < 1e-9);
        let again = rpc.project_orthometric(found.latitude(), found.longitude(), height, &geoid).unwrap();
        // 10⁻⁸ m of height are 2·10⁻⁹ px.
        prop_assert!((again - image).norm() < 1e-8);
    }

    #[test]
    fn project_after_ground_is_the_identity_of_a_rational_camera(
        l in -0.8..0.8f64, p in -0.8..0.8f64, h in -0.9..0.9f64, lean in -0.5..0.5f64, turn in -3.0..3.0f64,
        in_local in any::<bool>(), corrected in any::<bool>(),
    ) {
        let model = if corrected { rpc().with_correction(correction()) } else { rpc() };
        let frame = if in_local { local() } else { geocentric() };
        let sensor = RpcSensor::new(model, frame);
        let image = model.project(&inside(l, p, 0.0)).unwrap();
        let height = 1075.0 + 885.0 * h;
        // A plane through a point of the locus, leaning from the vertical there.
        let on = frame.world_from_geodetic(&model.at_height(&image, EllipsoidalHeight(height)).unwrap());
        let above = frame.world_from_geodetic(&model.at_height(&image, EllipsoidalHeight(height + 10.0)).unwrap());
        let up = (above - on).normalize();
        let side = up.cross(&Vector3::new(turn.cos(), turn.sin(), 0.3)).normalize();
        let plane = Plane::from_point_and_normal(on, up + side * lean).unwrap();
        let constant = frame.at_height(EllipsoidalHeight(height)).unwrap();
        let geoid = frame.above_geoid(geoid(), OrthometricHeight(height - 50.0)).unwrap();
        let surfaces: [&dyn Surface; 3] = [&plane, &constant, &geoid];
        for (i, surface) in surfaces.into_iter().enumerate() {
            let hit = sensor.ground(&image, surface).unwrap();
            prop_assert!(surface.height_above(&hit).abs() < 1e-8, "{} {}", i, surface.height_above(&hit));
            let again = sensor.project(&hit).unwrap();
            // Two units in the last place of geocentric coordinates are 4·10⁻⁹ px.
            prop_assert!((again - image).norm() < 1e-8, "{} {:e}", i, (again - image).norm());
        }
        let hit = sensor.ground(&image, &plane).unwrap();
        prop_assert!((hit - on).norm() < 1e-7);
        let hit = frame.geodetic_from_world(&sensor.ground(&image, &constant).unwrap()).unwrap();
        prop_assert!((hit.height().0 - height).abs() < 1e-8);
    }

    #[test]
    fn a_locus_stays_within_its_bound_and_uses_it(l in -1.0..1.0f64, p in -1.0..1.0f64) {
        let frame = local();
        let sensor = RpcSensor::new(rpc(), frame);
        let image = rpc().project(&inside(l, p, 0.0)).unwrap();
        let Locus::Curve(curve) = sensor.locus(&image).unwrap() else { panic!("a curve") };
        prop_assert_eq!(curve.heights, [190.0, 1960.0]);
        let mut largest = 0.0_f64;
        for k in 0..=100 {
            let height = 190.0 + 17.7 * f64::from(k);
            let exact = rpc().at_height(&image, EllipsoidalHeight(height)).unwrap();
            let off = (curve.at(height) - frame.world_from_geodetic(&exact)).norm();
            largest = largest.max(off);
        }
        prop_assert!(largest <= curve.error_bound, "{} {}", largest, curve.error_bound);
        // It is twice the error, not a margin for anything. The third-order terms are large here.
        prop_assert!(largest > 0.45 * curve.error_bound && curve.error_bound < 0.05, "{} {}", largest, curve.error_bound);
    }

    #[test]
    fn partials_by_the_world_are_differences(l in -1.0..1.0f64, p in -1.0..1.0f64, h in -1.0..1.0f64, in_local in any::<bool>()) {
        let frame = if in_local { local() } else { geocentric() };
        let sensor = RpcSensor::new(rpc().with_correction(correction()), frame);
        let world = frame.world_from_geodetic(&inside(l, p, h));
        let (image, slopes) = sensor.project_jacobian(&world).unwrap();
        prop_assert_eq!(image, sensor.project(&world).unwrap());
        for i in 0..3 {
            let mut step = Vector3::zeros();
            step[i] = 2.0;
            let ahead = sensor.project(&(world + step)).unwrap();
            let behind = sensor.project(&(world - step)).unwrap();
            let by_difference = (ahead - behind) / 4.0;
            prop_assert!((slopes.column(i) - by_difference).norm() < 2e-8, "{}: {}", i, slopes.column(i) - by_difference);
        }
    }

    #[test]
    fn a_correction_is_inverted_exactly(x in -1e4..5e4f64, y in -1e4..5e4f64) {
        let (c, p) = (correction(), Point2::new(x, y));
        prop_assert!((c.remove(&c.apply(&p)).unwrap() - p).norm() < 4e-11);
    }
}

#[test]
fn the_highest_crossing_is_taken_even_beyond_the_fitted_heights() {
    let frame = local();
    let sensor = RpcSensor::new(rpc(), frame);
    let image = rpc().project(&inside(0.1, 0.2, 0.0)).unwrap();
    // The sea, 190 m below the lowest height of the fit; and no deeper than the domain.
    let sea = frame.at_height(EllipsoidalHeight(0.0)).unwrap();
    let hit = sensor.ground(&image, &sea).unwrap();
    assert!((sensor.project(&hit).unwrap() - image).norm() < 1e-8);
    assert!(frame.geodetic_from_world(&hit).unwrap().height().0.abs() < 1e-8);
    let deep = frame.at_height(EllipsoidalHeight(-800.0)).unwrap();
    assert_eq!(sensor.ground(&image, &deep), Err(ProjectionError::MissesSurface));

    // Terraces: the locus comes through all three, the highest is what the sensor sees.
    #[derive(Debug)]
    struct Terraces(EarthFrame);
    impl Surface for Terraces {
        fn height_above(&self, world: &Point3<f64>) -> f64 {
            let h = self.0.geodetic_from_world(world).unwrap().height().0;
            (h - 400.0) * (h - 900.0) * (h - 1500.0) / 1e6
        }
        fn meet_ray(&self, _: &collinear::geometry::Ray) -> Result<Point3<f64>, ProjectionError> {
            Err(ProjectionError::MissesSurface)
        }
    }
    let hit = sensor.ground(&image, &Terraces(frame)).unwrap();
    assert!((frame.geodetic_from_world(&hit).unwrap().height().0 - 1500.0).abs() < 1e-6);
}

#[test]
fn corrections_by_control_points_agree_with_sixty_digits() {
    let oracle = oracle();
    let points = &oracle["points"].as_array().unwrap()[..9];
    let control: Vec<ControlPoint> = (0..9)
        .map(|i| ControlPoint {
            ground: ground_of(&points[i]),
            image: Point2::from(list::<2>(&oracle["measured"][i])),
            sigma: list(&oracle["sigma"][i]),
        })
        .collect();
    for (name, model, unknowns) in [
        ("shift", CorrectionModel::Shift, 1),
        ("shift_and_drift", CorrectionModel::ShiftAndDrift, 2),
        ("affine", CorrectionModel::Affine, 3),
    ] {
        let expected = &oracle["corrections"][name];
        // An old correction must leave no trace.
        let report = rpc().with_correction(correction()).correct(&control, model).unwrap();
        let c = report.rpc.correction();
        let found = [
            [c.shift().x, c.linear().m12, c.linear().m11],
            [c.shift().y, c.linear().m22, c.linear().m21],
        ];
        assert_eq!(model.parameters(), unknowns);
        assert_eq!(report.redundancy, 18 - 2 * unknowns);
        let sigma0 = number(expected, "sigma0");
        assert!((report.sigma0.unwrap() - sigma0).abs() < 1e-8 * sigma0);
        for (k, axis) in ["x", "y"].iter().enumerate() {
            let values = expected[*axis].as_array().unwrap();
            for i in 0..3 {
                let value = values.get(i).map_or(0.0, |v| v.as_f64().unwrap());
                let within = [1e-9, 1e-12, 1e-12][i];
                assert!((found[k][i] - value).abs() < within, "{name} {axis} {i}");
            }
            let residuals = expected[format!("residuals_{axis}")].as_array().unwrap();
            for (v, e) in report.residuals.iter().zip(residuals) {
                assert!((v[k] - e.as_f64().unwrap()).abs() < 1e-8);
            }
            let covariance = expected[format!("covariance_{axis}")].as_array().unwrap();
            for i in 0..3 {
                for j in 0..3 {
                    let e = if i < unknowns && j < unknowns {
                        covariance[unknowns * i + j].as_f64().unwrap()
                    } else {
                        0.0
                    };
                    let c = &report.covariance;
                    let scale = (c[(2 * i + k, 2 * i + k)] * c[(2 * j + k, 2 * j + k)]).sqrt();
                    assert!(
                        (c[(2 * i + k, 2 * j + k)] - e).abs() <= 1e-8 * scale,
                        "{name} {i} {j}"
                    );
                    assert_eq!(c[(2 * i + k, 2 * j + 1 - k)], 0.0);
                }
            }
        }
    }
}

#[test]
fn control_points_that_do_not_determine_a_correction_are_refused() {
    let rpc = rpc();
    let at = |image: Point2<f64>| ControlPoint {
        ground: rpc.at_height(&image, EllipsoidalHeight(900.0)).unwrap(),
        image,
        sigma: [0.5; 2],
    };
    let one = [at(Point2::new(5000.0, 3000.0))];
    for (model, needed) in [(CorrectionModel::ShiftAndDrift, 2), (CorrectionModel::Affine, 3)] {
        let error = rpc.correct(&one, model).unwrap_err();
        assert_eq!(error, Error::TooFewPoints { needed, got: 1 });
    }
    let error = rpc.correct(&[], CorrectionModel::Shift).unwrap_err();
    assert_eq!(error, Error::TooFewPoints { needed: 1, got: 0 });
    // One point: no redundancy, the covariance of the measurement itself.
    let report = rpc.correct(&one, CorrectionModel::Shift).unwrap();
    assert!(report.sigma0.is_none() && report.redundancy == 0);
    assert!((report.covariance[(0, 0)] - 0.25).abs() < 1e-15);
    assert_eq!(report.covariance[(0, 1)], 0.0);

    let line: Vec<_> =
        (0..5).map(|i| at(Point2::new(1000.0 + 900.0 * f64::from(i), 3000.0))).collect();
    let error = rpc.correct(&line, CorrectionModel::ShiftAndDrift).unwrap_err();
    assert!(
        matches!(error, Error::Degenerate { measure, limit: 1e-6, .. } if measure < 1e-9),
        "{error}"
    );
    let slope: Vec<_> = (0..5)
        .map(f64::from)
        .map(|t| at(Point2::new(1000.0 + 900.0 * t, 500.0 + 700.0 * t)))
        .collect();
    let error = rpc.correct(&slope, CorrectionModel::Affine).unwrap_err();
    assert!(matches!(error, Error::Degenerate { measure, .. } if measure < 1e-9), "{error}");
    assert!(rpc.correct(&slope, CorrectionModel::ShiftAndDrift).is_ok());

    let mut bad = one;
    for sigma in [1e-320, 1e300, f64::NAN] {
        bad[0].sigma[1] = sigma;
        let error = rpc.correct(&bad, CorrectionModel::Shift).unwrap_err();
        assert!(matches!(error, Error::OutOfRange { .. }), "{error}");
    }
    bad[0].sigma[1] = 0.0;
    let error = rpc.correct(&bad, CorrectionModel::Shift).unwrap_err();
    assert!(matches!(error, Error::OutOfRange { value: 0.0, .. }), "{error}");
    bad[0].image.x = f64::NAN;
    let error = rpc.correct(&bad, CorrectionModel::Shift).unwrap_err();
    assert_eq!(error, Error::NotFinite { what: "control point" });
    let mut far = one;
    far[0].ground = place(50.0, 5.2, 900.0);
    let error = rpc.correct(&far, CorrectionModel::Shift).unwrap_err();
    assert!(matches!(error, Error::Projection(ProjectionError::OutsideDomain { .. })), "{error}");
}

#[test]
fn the_groups_of_a_corrected_camera_are_adjusted() {
    let frame = local();
    for start in [ImageCorrection::none(), correction()] {
        let sensor = RpcSensor::new(rpc().with_correction(start), frame);
        let world = frame.world_from_geodetic(&inside(0.4, -0.3, 0.2));
        let (mut by_object, mut groups) = ([0.0; 6], [[0.0; 4]; 3]);
        let [a, b, c] = &mut groups;
        let image = sensor.partials(&world, &mut by_object, &mut [a, b, c]).unwrap();
        let (same, slopes) = sensor.project_jacobian(&world).unwrap();
        assert_eq!(image, same);
        for (i, slope) in by_object.iter().enumerate() {
            assert_eq!(*slope, slopes[(i / 3, i % 3)]);
        }
        for group in 0..3 {
            assert_eq!(sensor.parameter_group(group).unwrap().len, 2);
            for k in 0..2 {
                // The image is linear in the correction.
                let step = if group == 0 { 1.0 } else { 1e-4 };
                let mut moved = sensor;
                let mut change = [0.0; 2];
                change[k] = step;
                moved.adjust(group, &change).unwrap();
                let (mut before, mut after) = ([0.0; 2], [0.0; 2]);
                sensor.parameters(group, &mut before);
                moved.parameters(group, &mut after);
                assert!((after[k] - before[k] - step).abs() < 1e-15);
                assert_eq!(after[1 - k], before[1 - k]);
                let by = (moved.project(&world).unwrap() - image) / step;
                let expected = Vector2::new(groups[group][k], groups[group][2 + k]);
                assert!((by - expected).norm() < 1e-6, "{group} {k}: {by} {expected}");
            }
        }
        assert!(sensor.parameter_group(3).is_none());
        let mut moved = sensor;
        assert!(matches!(moved.adjust(3, &[0.0; 2]), Err(Error::OutOfRange { .. })));
        assert!(matches!(moved.adjust(0, &[0.0; 3]), Err(Error::LengthMismatch { .. })));
        assert!(matches!(moved.adjust(1, &[f64::NAN; 2]), Err(Error::NotFinite { .. })));
        assert!(matches!(moved.adjust(2, &[-2.0, 0.0]), Err(Error::Degenerate { .. })));
        assert_eq!(moved, sensor);
    }
}

/// A lens camera 5 km above the ground, looking down or 30° ahead.
fn aerial(forward: f64) -> Frame<BrownCamera> {
    let pose = ExteriorOrientation::look_at(
        Point3::new(0.0, 0.0, 5000.0),
        Point3::new(0.0, forward, 0.0),
        Vector3::y(),
    )
    .unwrap();
    let interior = InteriorOrientation::new([8000.0; 2], Point2::new(2000.0, 1500.0), 0.0).unwrap();
    let lens = Brown::new([-0.05, 0.02, 0.0], [1e-4, -2e-4]).unwrap();
    Frame::new(pose, BrownCamera::new(interior, lens))
}

fn aerial_grid() -> FitGrid {
    FitGrid {
        corners: [Point2::new(0.0, 0.0), Point2::new(4000.0, 3000.0)],
        heights: [EllipsoidalHeight(300.0), EllipsoidalHeight(1100.0)],
        nodes: [11, 11, 5],
    }
}

#[test]
fn a_frame_camera_is_fitted_within_a_thousandth_of_a_pixel() {
    // The worst point of the check grid reaches half of each limit and more. What is left of a lens are its terms of
    // the fifth order; one denominator for both is what a central projection has.
    for (lens, forward, denominators, limit) in [
        (false, 0.0, Denominators::Separate, 6e-9),
        (false, 3000.0, Denominators::Separate, 6e-9),
        (false, 3000.0, Denominators::Shared, 6e-9),
        (true, 0.0, Denominators::Separate, 1e-3),
        (true, 3000.0, Denominators::Separate, 1e-3),
        (true, 0.0, Denominators::Shared, 3e-3),
        (true, 3000.0, Denominators::Shared, 3e-3),
        (false, 0.0, Denominators::One, 0.6),
    ] {
        let options = FitOptions { denominators, ..FitOptions::default() };
        let (with_lens, without) = (aerial(forward), aerial(forward).ideal());
        let camera: &dyn SensorModel = if lens { &with_lens } else { &without };
        let fit = Rpc::fit_sensor(camera, &local(), &aerial_grid(), &options).unwrap();
        assert_eq!((fit.fit.points, fit.check.points), (11 * 11 * 5, 10 * 10 * 4));
        let max = fit.check.max;
        assert!(max < limit && max > 0.2 * limit, "{lens} {forward} {denominators:?}: {max:e}");
        assert!(fit.fit.rms <= fit.fit.max && fit.check.rms <= fit.check.max);
        let r = fit.rpc.to_rpc00b();
        assert_eq!(fit.rpc.image_centre(), Point2::new(2000.0, 1500.0));
        assert_eq!((r.line_scale, r.sample_scale), (1500.0, 2000.0));
        assert_eq!((r.height_offset, r.height_scale), (700.0, 400.0));
        match denominators {
            Denominators::Shared => assert_eq!(r.line_denominator, r.sample_denominator),
            Denominators::One => assert_eq!(r.line_denominator[1..], [0.0; 19]),
            _ => assert_ne!(r.line_denominator, r.sample_denominator),
        }
        // What the report says is so: a point of its check grid through both.
        let frame = local();
        let surface = frame.at_height(EllipsoidalHeight(600.0)).unwrap();
        let image = Point2::new(1234.0, 2345.0);
        let world = camera.ground(&image, &surface).unwrap();
        let off = RpcSensor::new(fit.rpc, frame).project(&world).unwrap() - image;
        assert!(off.norm() <= 2.0 * max, "{off}");
    }
}

#[test]
fn a_rational_camera_is_fitted_to_itself() {
    let grid = FitGrid {
        corners: [Point2::new(500.0, 500.0), Point2::new(11_500.0, 8000.0)],
        heights: [EllipsoidalHeight(250.0), EllipsoidalHeight(1900.0)],
        nodes: [9, 9, 5],
    };
    let rpc = rpc();
    let ground = |p: &Point2<f64>, h| rpc.at_height(p, h);
    let fit = Rpc::fit(&ground, &grid, &FitOptions::default()).unwrap();
    assert!(fit.check.max < 1e-9, "{:?}", fit.check);
}

#[test]
fn grids_that_cannot_be_fitted_are_refused() {
    let rpc = rpc();
    let ground = |p: &Point2<f64>, h| rpc.at_height(p, h);
    let good = FitGrid {
        corners: [Point2::new(500.0, 500.0), Point2::new(11_500.0, 8000.0)],
        heights: [EllipsoidalHeight(250.0), EllipsoidalHeight(1900.0)],
        nodes: [6, 6, 3],
    };
    let options = FitOptions::default();
    let refused = |change: &dyn Fn(&mut FitGrid)| {
        let mut grid = good;
        change(&mut grid);
        Rpc::fit(&ground, &grid, &options).unwrap_err()
    };
    assert!(Rpc::fit(&ground, &good, &options).is_ok());
    assert!(matches!(
        refused(&|g| g.nodes = [3, 3, 3]),
        Error::TooFewPoints { needed: 39, got: 27 }
    ));
    assert!(matches!(refused(&|g| g.nodes[2] = 1), Error::OutOfRange { .. }));
    assert!(matches!(refused(&|g| g.nodes = [usize::MAX, 2, 2]), Error::OutOfRange { .. }));
    assert!(matches!(refused(&|g| g.corners[1].x = 500.0), Error::OutOfRange { .. }));
    assert!(matches!(refused(&|g| g.heights[0].0 = f64::NAN), Error::NotFinite { .. }));
    assert!(matches!(
        refused(&|g| g.corners[1].x = 1e6),
        Error::Projection(
            ProjectionError::OutsideDomain { .. } | ProjectionError::NotConverged { .. }
        )
    ));
    for bad in [
        FitOptions { regularisation: -1.0, ..options },
        FitOptions { regularisation: f64::NAN, ..options },
        FitOptions { max_iterations: 0, ..options },
    ] {
        assert!(matches!(Rpc::fit(&ground, &good, &bad), Err(Error::OutOfRange { .. })), "{bad:?}");
    }
    let many = FitOptions { max_iterations: 2000, ..options };
    let error = Rpc::fit(&ground, &good, &many).unwrap_err().to_string();
    assert_eq!(error, "rounds of a fit is 2000, expected from 1 to 1000");
    // Nothing but one place: no extent on the ground.
    let nowhere = |_: &Point2<f64>, h| {
        Geodetic::from_degrees(44.0, 5.0, h).map_err(|_| ProjectionError::NotFinite)
    };
    assert!(Rpc::fit(&nowhere, &good, &options).is_err());
}

#[test]
fn what_lies_outside_the_model_is_an_error() {
    let rpc = rpc();
    for (l, p, h) in [(2.01, 0.0, 0.0), (0.0, -2.01, 0.0), (0.0, 0.0, 2.01), (-2.01, 0.0, 0.0)] {
        let error = rpc.project(&inside(l, p, h)).unwrap_err();
        let ProjectionError::OutsideDomain { value, limit } = error else { panic!("{error}") };
        assert!((value - 2.01).abs() < 1e-9 && limit == 2.0);
    }
    assert!(rpc.project(&inside(1.99, -1.99, 1.99)).is_ok());
    let nan = rpc.project_degrees(f64::NAN, 5.2, EllipsoidalHeight(900.0));
    assert_eq!(nan, Err(ProjectionError::NotFinite));
    // A picture at the pole sees no place beyond it.
    let mut r = record();
    r.latitude_offset_deg = 89.99;
    let polar = Rpc::from_rpc00b(&r).unwrap();
    let at = |latitude| polar.project_degrees(latitude, 5.2, EllipsoidalHeight(900.0));
    assert!(at(90.0).is_ok());
    assert_eq!(at(90.001), Err(ProjectionError::OutsideDomain { value: 90.001, limit: 90.0 }));
    let wide = rpc.with_domain(3.0).unwrap();
    assert!(wide.project(&inside(2.01, 0.0, 0.0)).is_ok() && wide.domain() == 3.0);
    assert!(rpc.with_domain(0.5).is_err() && rpc.with_domain(f64::NAN).is_err());

    let at = |x, y, h| rpc.at_height(&Point2::new(x, y), EllipsoidalHeight(h)).unwrap_err();
    let is_outside = |e| matches!(e, ProjectionError::OutsideDomain { .. });
    assert!(is_outside(at(6000.0, 4000.0, 1075.0 + 885.0 * 2.01)));
    assert!(is_outside(at(6000.0 + 6199.5 * 2.5, 4000.0, 1075.0)));
    assert!(is_outside(at(6000.0, 4000.0 - 4250.0 * 2.5, 1075.0)));
    let far = at(1e9, 1e9, 1075.0);
    assert!(
        matches!(far, ProjectionError::NotConverged { residual, .. } if residual > 1e3),
        "{far}"
    );
    for (x, y, h) in [(f64::NAN, 0.0, 0.0), (0.0, f64::INFINITY, 0.0), (0.0, 0.0, f64::NAN)] {
        assert_eq!(at(x, y, h), ProjectionError::NotFinite);
    }
    let sensor = RpcSensor::geocentric(rpc);
    for world in [Point3::origin(), Point3::new(f64::NAN, 0.0, 0.0), Point3::new(7e6, 0.0, 0.0)] {
        assert!(sensor.project(&world).is_err() && sensor.project_jacobian(&world).is_err());
    }
    assert!(sensor.locus(&Point2::new(f64::NAN, 0.0)).is_err());
}

#[test]
fn a_denominator_that_vanishes_is_no_image() {
    let mut r = record();
    r.line_denominator = [0.0; 20];
    // 1 − 0.8 L: zero at L = 1.25, inside the domain.
    (r.line_denominator[0], r.line_denominator[1]) = (1.0, -0.8);
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    assert!(rpc.project(&inside(1.2, 0.0, 0.0)).is_ok());
    for l in [1.25, 1.3, 1.9] {
        let error = rpc.project(&inside(l, 0.3, 0.0)).unwrap_err();
        let ProjectionError::OutsideDomain { value, limit } = error else { panic!("{error}") };
        assert!((value - (0.8 * l - 1.0)).abs() < 1e-9 && limit == -1e-3, "{error}");
        assert!(rpc.project_jacobian(&inside(l, 0.3, 0.0)).is_err());
    }
    // With both signs turned the model is the same.
    let mut turned = r;
    turned.line_denominator = r.line_denominator.map(|c| -c);
    turned.line_numerator = r.line_numerator.map(|c| -c);
    let ground = inside(0.4, 0.3, 0.2);
    let same = Rpc::from_rpc00b(&turned).unwrap().project(&ground).unwrap();
    assert!((same - rpc.project(&ground).unwrap()).norm() < 1e-9);
}

#[test]
fn a_fold_of_the_polynomials_is_not_crossed() {
    // sample = L − L²/2 has its largest value at L = 1; what images beyond is behind the fold.
    let mut r = record();
    let one = core::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 });
    (r.line_numerator, r.sample_numerator) = ([0.0; 20], [0.0; 20]);
    (r.line_denominator, r.sample_denominator) = (one, one);
    r.line_numerator[2] = -1.0;
    (r.sample_numerator[1], r.sample_numerator[7]) = (1.0, -0.5);
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    for l in [-1.5, -0.4, 0.9, 0.999] {
        let image = rpc.project(&inside(l, 0.3, 0.0)).unwrap();
        let back = rpc.at_height(&image, EllipsoidalHeight(1075.0)).unwrap();
        let expected = inside(l, 0.3, 0.0).longitude();
        assert!((back.longitude() - expected).abs() < 1e-11, "{l}");
    }
    // L = 1.6 has the image of L = 0.4, and that is what is found.
    let image = rpc.project(&inside(1.6, 0.3, 0.0)).unwrap();
    let back = rpc.at_height(&image, EllipsoidalHeight(1075.0)).unwrap();
    assert!((back.longitude() - inside(0.4, 0.3, 0.0).longitude()).abs() < 1e-13);
    // A first step of Newton's that lands behind a fold, nearer to the image than the start: 0.2 L + L² − 0.6 L³ turns
    // back at L = 1.2, the linear terms lead to L = 2.46 and half of that.
    let mut steep = r;
    (steep.sample_numerator[1], steep.sample_numerator[7]) = (0.2, 1.0);
    steep.sample_numerator[11] = -0.6;
    let curved = Rpc::from_rpc00b(&steep).unwrap();
    let ground = inside(0.8, 0.3, 0.0);
    let image = curved.project(&ground).unwrap();
    let back = curved.at_height(&image, EllipsoidalHeight(1075.0)).unwrap();
    assert!((back.longitude() - ground.longitude()).abs() < 1e-13);
    // No ground at all beyond the fold: half a size past the middle is the edge.
    let beyond = Point2::new(r.sample_offset + 0.5 + 0.6 * r.sample_scale, r.line_offset);
    let error = rpc.at_height(&beyond, EllipsoidalHeight(1075.0)).unwrap_err();
    let ProjectionError::NotConverged { residual, .. } = error else { panic!("{error}") };
    assert!((residual - 0.1 * r.sample_scale).abs() < 2.0, "{residual}");
}

#[test]
fn records_that_no_picture_has_are_refused() {
    let refused = |change: &dyn Fn(&mut Rpc00b)| {
        let mut r = record();
        change(&mut r);
        Rpc::from_rpc00b(&r).unwrap_err()
    };
    assert!(matches!(
        refused(&|r| r.line_scale = 0.0),
        Error::OutOfRange { what: "line scale", value: 0.0, .. }
    ));
    assert!(matches!(refused(&|r| r.height_scale = -1.0), Error::OutOfRange { .. }));
    assert!(matches!(refused(&|r| r.latitude_offset_deg = 91.0), Error::OutOfRange { .. }));
    assert!(matches!(refused(&|r| r.sample_offset = 1e300), Error::OutOfRange { .. }));
    assert!(matches!(
        refused(&|r| r.longitude_scale_deg = f64::NAN),
        Error::NotFinite { what: "longitude scale" }
    ));
    assert!(matches!(
        refused(&|r| r.sample_numerator[19] = f64::INFINITY),
        Error::NotFinite { what: "sample numerator" }
    ));
    assert!(matches!(refused(&|r| r.line_numerator[3] = 1e200), Error::OutOfRange { .. }));
    assert!(matches!(
        refused(&|r| r.sample_denominator[0] = 0.0),
        Error::Degenerate { what: "sample denominator", .. }
    ));
    assert!(matches!(refused(&|r| r.error_bias = Some(f64::NAN)), Error::NotFinite { .. }));
    // Line and sample the same function of the ground.
    let error = refused(&|r| {
        r.line_numerator = r.sample_numerator;
        r.line_denominator = r.sample_denominator;
    });
    assert!(matches!(error, Error::Degenerate { limit: 1e-9, .. }), "{error}");
    let error = refused(&|r| r.line_numerator = [0.0; 20]);
    assert!(matches!(error, Error::Degenerate { .. }), "{error}");

    let linear = Matrix2::new(-1.0, 0.0, 0.0, 0.0);
    let error = ImageCorrection::new(Point2::origin(), Vector2::zeros(), linear).unwrap_err();
    assert!(matches!(error, Error::Degenerate { measure: 0.0, .. }));
    let nan = Vector2::new(f64::NAN, 0.0);
    assert!(ImageCorrection::new(Point2::origin(), nan, Matrix2::zeros()).is_err());
}

#[test]
fn the_older_order_of_terms_is_brought_to_the_newer() {
    // With L, P, H = 2, 3, 5 each term is told by its factors: RPC00A as STDI-0002 prints it, then RPC00B.
    let older = [1, 2, 3, 5, 6, 10, 15, 30, 4, 9, 25, 8, 12, 20, 18, 27, 45, 50, 75, 125];
    let newer = [1, 2, 3, 5, 6, 10, 15, 4, 9, 25, 30, 8, 18, 50, 12, 27, 75, 20, 45, 125];
    assert_eq!(Rpc00b::from_rpc00a_order(&older.map(f64::from)), newer.map(f64::from));
}

#[test]
fn reweighting_brings_a_fit_nearer() {
    let camera = aerial(3000.0);
    let fit = |max_iterations| {
        let options = FitOptions { max_iterations, ..FitOptions::default() };
        Rpc::fit_sensor(&camera, &local(), &aerial_grid(), &options).unwrap()
    };
    let (one, many) = (fit(1), fit(10));
    assert_eq!(one.iterations, 1);
    assert!(many.fit.rms < 0.99 * one.fit.rms, "{:?} {:?}", many.fit, one.fit);
}

#[test]
fn a_fit_may_lie_across_the_date_line() {
    let mut r = record();
    r.longitude_offset_deg = 179.98;
    let rpc = Rpc::from_rpc00b(&r).unwrap();
    let grid = FitGrid {
        corners: [Point2::new(500.0, 500.0), Point2::new(11_500.0, 8000.0)],
        heights: [EllipsoidalHeight(250.0), EllipsoidalHeight(1900.0)],
        nodes: [7, 7, 4],
    };
    let ground = |p: &Point2<f64>, h| rpc.at_height(p, h);
    let fit = Rpc::fit(&ground, &grid, &FitOptions::default()).unwrap();
    // Angles near 180° are themselves exact to 3·10⁻⁹ px.
    assert!(fit.check.max < 1e-7, "{:?}", fit.check);
    assert!(fit.rpc.to_rpc00b().longitude_scale_deg < 0.2);
}

#[test]
fn a_frame_camera_meets_a_height_above_the_geoid() {
    let (camera, frame, geoid) = (aerial(3000.0), local(), geoid());
    let surface = frame.above_geoid(geoid.clone(), OrthometricHeight(650.0)).unwrap();
    assert_eq!(surface.surface().height(), OrthometricHeight(650.0));
    for image in [Point2::new(10.0, 20.0), Point2::new(2000.0, 1500.0), Point2::new(3990.0, 2990.0)]
    {
        let hit = camera.ground(&image, &surface).unwrap();
        assert!((camera.project(&hit).unwrap() - image).norm() < 1e-8);
        assert!(surface.height_above(&hit).abs() < 1e-8);
        let place = frame.geodetic_from_world(&hit).unwrap();
        let OrthometricHeight(height) = geoid.orthometric(&place).unwrap();
        assert!((height - 650.0).abs() < 1e-8, "{height}");
    }
    // Beyond the grid's edge there is no geoid.
    let away = LocalFrame::east_north_up(Ellipsoid::WGS84, place(10.0, 5.0, 0.0));
    let nowhere = EarthFrame::Local(away).above_geoid(geoid, OrthometricHeight(0.0)).unwrap();
    assert!(camera.ground(&Point2::new(2000.0, 1500.0), &nowhere).is_err());
    assert!(nowhere.height_above(&Point3::origin()).is_nan());
}

#[test]
fn surfaces_of_constant_height_have_their_normals() {
    // Up at the origin of a local frame, and along the axes of the geocentric one.
    let up = local().at_height(EllipsoidalHeight(500.0)).unwrap();
    let normal = up.normal(&Point3::new(0.0, 0.0, 200.0)).unwrap();
    assert!((normal.into_inner() - Vector3::z()).norm() < 1e-15, "{normal:?}");
    let level = geocentric().at_height(EllipsoidalHeight(0.0)).unwrap();
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        let normal = level.normal(&Point3::from(axis * 6_378_137.0)).unwrap();
        assert!((normal.into_inner() - axis).norm() < 1e-15, "{normal:?}");
    }
    // 100 km to the east the normal leans by the distance over the prime vertical's radius, 6 388 476 m at 44.1°.
    let place = Point3::new(1e5, 0.0, -782.6);
    let normal = up.normal(&place).unwrap();
    assert!((normal.x.asin() - 1e5 / 6_388_476.0).abs() < 1e-6, "{}", normal.x);
    // By differences it is the same to nine digits.
    let step = 40.0;
    let slope = |axis: Vector3<f64>| {
        up.height_above(&(place + axis * step)) - up.height_above(&(place - axis * step))
    };
    let gradient = Vector3::new(slope(Vector3::x()), slope(Vector3::y()), slope(Vector3::z()));
    assert!((gradient.normalize() - normal.into_inner()).norm() < 1e-9);
}
