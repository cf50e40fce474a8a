//! Laws of the thin-plate spline.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use collinear::geometry::Affine2;
use collinear::mapping::{Map, ThinPlate};
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix2, Point2, Vector2};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{numbers, point2, points2};

fn oracles() -> Value {
    serde_json::from_str(include_str!("../data/oracles/thin_plate.json")).unwrap()
}

#[test]
fn a_thin_plate_is_that_of_forty_digits_and_of_scipy() {
    for case in oracles()["cases"].as_array().unwrap() {
        let (screen, texture) = (points2(&case["screen"]), points2(&case["texture"]));
        let map = ThinPlate::fit(&screen, &texture, case["smoothing"].as_f64().unwrap()).unwrap();
        let far = screen[0].coords.amax() > 1e6;
        for c in case["checks"].as_array().unwrap() {
            let p = point2(&c["screen"]);
            let difference = map.at(&p).unwrap() - point2(&c["texture"]);
            assert!(difference.norm() < if far { 1e-8 } else { 1e-10 }, "{difference}");
            assert!((map.at(&p).unwrap() - point2(&c["scipy"])).norm() < 1e-8);
            let j = numbers(&c["jacobian"]);
            let difference = map.jacobian(&p).unwrap() - Matrix2::new(j[0], j[1], j[2], j[3]);
            assert!(difference.amax() < if far { 1e-10 } else { 1e-12 }, "{difference}");
        }
    }
}

fn pairs() -> impl Strategy<Value = (Vec<Point2<f64>>, Vec<Point2<f64>>)> {
    // One point in each cell of a lattice: none too near to another.
    let within = (0.2..0.8, 0.2..0.8).prop_map(|(x, y)| Vector2::new(x, y));
    let texture = (0.0..90.0, 0.0..90.0).prop_map(|(u, v)| Point2::new(u, v));
    prop::collection::btree_map((0..8i32, 0..6i32), (within, texture), 5..30).prop_map(|all| {
        let cell = |k: (i32, i32)| Point2::new(f64::from(k.0), f64::from(k.1));
        all.into_iter().map(|(k, (w, t))| ((cell(k) + w) * 10.0, t)).unzip()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_thin_plate_passes_through_its_points((screen, texture) in pairs()) {
        let Ok(map) = ThinPlate::fit(&screen, &texture, 0.0) else { return Ok(()) };
        for (s, t) in screen.iter().zip(&texture) {
            prop_assert!((map.at(s).unwrap() - t).norm() < 1e-9);
        }
    }

    #[test]
    fn a_stiff_thin_plate_is_the_affine_map_of_least_squares((screen, texture) in pairs()) {
        let Ok(map) = ThinPlate::fit(&screen, &texture, 1e14) else { return Ok(()) };
        let affine = Affine2::fit(&screen, &texture).unwrap().map;
        for s in &screen {
            prop_assert!((map.at(s).unwrap() - affine.apply(s)).norm() < 1e-6);
        }
        prop_assert!((map.affine().linear - affine.linear).amax() < 1e-7);
        prop_assert!((map.affine().apply(&screen[0]) - affine.apply(&screen[0])).norm() < 1e-6);
    }

    #[test]
    fn a_thin_plate_moves_with_its_points((screen, texture) in pairs(), turn in 0.0..6.0f64, size in 0.1..10.0f64) {
        let Ok(map) = ThinPlate::fit(&screen, &texture, 0.0) else { return Ok(()) };
        let (s, c) = f64::sin_cos(turn);
        let similar = Affine2::from_coefficients([300.0, size * c, -size * s], [-70.0, size * s, size * c]);
        let moved: Vec<_> = screen.iter().map(|p| similar.apply(p)).collect();
        let other = ThinPlate::fit(&moved, &texture, 0.0).unwrap();
        for p in [Point2::new(3.0, 4.0), Point2::new(40.0, 25.0), Point2::new(100.0, 90.0)] {
            prop_assert!((other.at(&similar.apply(&p)).unwrap() - map.at(&p).unwrap()).norm() < 1e-8);
        }
    }
}

#[test]
fn bad_plates_are_refused() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let square = [p(0., 0.), p(1., 0.), p(0., 1.), p(1., 1.)];
    let fit = |screen: &[Point2<f64>], smoothing| {
        ThinPlate::fit(screen, &square[..screen.len().min(4)], smoothing).map(|_| ())
    };
    assert_eq!(fit(&square, 0.0), Ok(()));
    assert_eq!(fit(&square[..3], 0.0), Ok(()));
    assert!(matches!(fit(&square[..2], 0.0), Err(Error::TooFewPoints { needed: 3, got: 2 })));
    for smoothing in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(fit(&square, smoothing), Err(Error::OutOfRange { .. })));
    }
    let twice = [square[0], square[1], square[2], square[1]];
    assert!(matches!(fit(&twice, 0.0), Err(Error::Degenerate { .. })));
    assert_eq!(fit(&twice, 1e-3), Ok(()));
    let line = [p(0., 0.), p(1., 2.), p(2., 4.), p(4., 8.)];
    assert!(matches!(fit(&line, 1.0), Err(Error::Degenerate { .. })));
    assert!(matches!(fit(&[square[0]; 4], 1.0), Err(Error::Degenerate { .. })));
    assert!(matches!(fit(&square.map(|p| p * f64::NAN), 0.0), Err(Error::NotFinite { .. })));
    for size in [1e-300, 1e-90, 1e90, 1e300] {
        let map = ThinPlate::fit(&square.map(|p| p * size), &square, 0.0).unwrap();
        assert!((map.at(&p(0.5 * size, 0.5 * size)).unwrap() - p(0.5, 0.5)).norm() < 1e-12);
    }
    let map = ThinPlate::fit(&square, &square, 0.0).unwrap();
    assert_eq!(map.at(&p(f64::NAN, 0.0)), Err(ProjectionError::NotFinite));
    assert_eq!(map.at(&p(1e300, 0.0)), Err(ProjectionError::NotFinite));
    assert_eq!(map.jacobian(&p(f64::INFINITY, 0.0)), Err(ProjectionError::NotFinite));
}
