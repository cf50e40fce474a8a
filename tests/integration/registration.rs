//! Registration by control points, and what it predicts.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use collinear::Error;
use collinear::mapping::Map;
use collinear::mapping::registration::{Folds, MapModel, compare, cross_validate};
use nalgebra::{Point2, Vector2};
use serde_json::Value;

use crate::support::{point2, points2};

const MODELS: [MapModel; 9] = [
    MapModel::Affine,
    MapModel::Projective,
    MapModel::Bilinear,
    MapModel::Quadratic,
    MapModel::Cubic,
    MapModel::PiecewiseAffine,
    MapModel::PiecewiseCubic,
    MapModel::ThinPlate { smoothing: 0.0 },
    MapModel::ThinPlate { smoothing: 20_000.0 },
];

fn oracles() -> Value {
    serde_json::from_str(include_str!("../data/oracles/registration.json")).unwrap()
}

#[test]
fn residuals_and_predictions_are_those_of_numpy_and_scipy() {
    let oracles = oracles();
    let (screen, texture) = (points2(&oracles["screen"]), points2(&oracles["texture"]));
    for model in MODELS {
        let case = &oracles["models"][model.to_string()];
        // The general optimiser stops at about the square root of rounding.
        let tolerance = if model == MapModel::Projective { 1e-5 } else { 1e-8 };
        let near = |found: Option<Vector2<f64>>, expected: &Value, what: &str| {
            let expected = (!expected.is_null()).then(|| point2(expected).coords);
            match (found, expected) {
                (Some(f), Some(e)) => assert!((f - e).norm() < tolerance, "{model} {what} {f} {e}"),
                (f, e) => assert_eq!(f.is_some(), e.is_some(), "{model} {what}"),
            }
        };
        let fit = model.fit(&screen, &texture).unwrap();
        let mut square = 0.0;
        for (i, (r, e)) in fit.residuals.iter().zip(case["fit"].as_array().unwrap()).enumerate() {
            // Qhull's triangles may leave out a corner of the hull itself by rounding.
            if !e.is_null() {
                near(Some(*r), e, "fit");
            }
            square += r.norm_squared();
            assert!((texture[i] - fit.map.at(&screen[i]).unwrap() - r).norm() < 1e-12);
        }
        assert!((fit.rms - (square / 24.0).sqrt()).abs() < 1e-12);
        for (folds, name) in [(Folds::LeaveOneOut, "leave_one_out"), (Folds::Every(5), "five")] {
            let cross = cross_validate(model, &screen, &texture, folds).unwrap();
            let expected = case[name].as_array().unwrap();
            for (r, e) in cross.residuals.iter().zip(expected) {
                near(*r, e, name);
            }
            let known: Vec<f64> =
                expected.iter().filter(|e| !e.is_null()).map(|e| point2(e).coords.norm()).collect();
            let rms = (known.iter().map(|r| r * r).sum::<f64>() / known.len() as f64).sqrt();
            assert!((cross.rms - rms).abs() < tolerance && cross.predicted == known.len());
            let largest = known.iter().copied().fold(0.0, f64::max);
            assert!((cross.largest - largest).abs() < tolerance);
        }
    }
}

#[test]
fn models_are_sorted_by_what_they_predict_at_common_points() {
    let oracles = oracles();
    let (screen, texture) = (points2(&oracles["screen"]), points2(&oracles["texture"]));
    let table = compare(&MODELS, &screen, &texture, Folds::LeaveOneOut).unwrap();
    let rms: Vec<f64> = table.candidates.iter().map(|c| c.common_rms).collect();
    assert!(rms.is_sorted(), "{rms:?}");
    assert!(table.common.len() > 10 && table.common.len() < 24);
    for c in &table.candidates {
        let all = &oracles["models"][c.model.to_string()]["leave_one_out"];
        let sum: f64 = table.common.iter().map(|&i| point2(&all[i]).coords.norm_squared()).sum();
        let expected = (sum / table.common.len() as f64).sqrt();
        assert!((c.common_rms - expected).abs() < 1e-5, "{}", c.model);
    }
    // Of a perspective with waves of 3 pixels and noise of 0.5, smoothing predicts better than passing through.
    let place = |m: MapModel| table.candidates.iter().position(|c| c.model == m).unwrap();
    assert!(place(MapModel::Projective) < place(MapModel::Affine));
    let text = table.to_string();
    assert_eq!(text.lines().count(), 10);
    assert!(text.contains("thin plate, λ = 20000") && text.contains("common rms"), "{text}");
}

#[test]
fn a_map_of_the_models_own_kind_is_predicted_exactly() {
    let screen = points2(&oracles()["screen"]);
    let texture: Vec<_> = screen
        .iter()
        .map(|p| {
            let w = 1.0 + 3e-4 * p.x;
            Point2::new((5.0 + p.x - 0.2 * p.y) / w, (0.3 * p.x + p.y) / w)
        })
        .collect();
    let table = compare(&MapModel::ALL, &screen, &texture, Folds::Every(4)).unwrap();
    assert_eq!(table.candidates[0].model, MapModel::Projective);
    assert!(table.candidates[0].cross_validation.rms < 1e-9);
    assert_eq!(table.candidates[0].cross_validation.predicted, 24);
    // Rows of what was fitted are those of the map inside.
    let map = &table.candidates[0].registration.as_ref().unwrap().map;
    assert!(map.span(3, 0..50).is_some());
    let mut count = 0;
    map.blocks(3, 0..50, &mut |x, u, v| {
        for (i, (u, v)) in u.iter().zip(v).enumerate() {
            let p = map.at(&Point2::new(f64::from(x) + i as f64 + 0.5, 3.5)).unwrap();
            assert!((p - Point2::new(*u, *v)).norm() < 1e-10);
            count += 1;
        }
    });
    assert_eq!(count, 50);
}

#[test]
fn what_cannot_be_validated_says_so() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let square = [p(0., 0.), p(1., 0.), p(0., 1.), p(1., 1.)];
    let validate = |screen: &[Point2<f64>], texture: &[Point2<f64>], folds| {
        cross_validate(MapModel::Affine, screen, texture, folds)
    };
    let one = Folds::LeaveOneOut;
    assert!(matches!(
        validate(&square[..3], &square[..3], one),
        Err(Error::TooFewPoints { needed: 4, got: 3 })
    ));
    assert!(matches!(validate(&square, &square[..3], one), Err(Error::LengthMismatch { .. })));
    for k in [0, 1, 5] {
        let error = validate(&square, &square, Folds::Every(k));
        assert!(matches!(error, Err(Error::OutOfRange { .. })), "{k}");
    }
    let mut bad = square;
    bad[1].x = f64::NAN;
    assert!(matches!(validate(&square, &bad, one), Err(Error::NotFinite { .. })));
    assert!(matches!(MapModel::Affine.fit(&bad, &square), Err(Error::NotFinite { .. })));
    // Four points less one do not determine a projective map.
    let cross = cross_validate(MapModel::Projective, &square, &square, one).unwrap();
    assert!(cross.predicted == 0 && cross.rms.is_nan() && cross.largest == 0.0);
    let table = compare(&[MapModel::Cubic, MapModel::Affine], &square, &square, one).unwrap();
    assert_eq!(table.candidates[0].model, MapModel::Affine);
    assert_eq!(table.common, [0, 1, 2, 3]);
    assert!(matches!(
        table.candidates[1].registration,
        Err(Error::TooFewPoints { needed: 10, got: 4 })
    ));
    assert!(table.to_string().contains("none"));
}
