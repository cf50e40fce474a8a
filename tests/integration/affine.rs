//! Affine maps against numpy and by hand.

use collinear::Error;
use collinear::geometry::Affine2;
use collinear::mapping::Map;
use collinear::nalgebra::{Matrix2, Matrix3, Point2};
use proptest::prelude::*;

fn points<const N: usize>(c: [[f64; 2]; N]) -> [Point2<f64>; N] {
    c.map(Point2::from)
}

#[test]
fn table_2s_coefficients_by_hand() {
    // x = 10 + 2X − 3Y, y = −20 + 5X + 7Y at (4, 6): 10 + 8 − 18 and −20 + 20 + 42.
    let map = Affine2::from_coefficients([10.0, 2.0, -3.0], [-20.0, 5.0, 7.0]);
    assert_eq!(map.apply(&Point2::new(4.0, 6.0)), Point2::new(0.0, 42.0));
    assert_eq!(map.at(&Point2::new(4.0, 6.0)), Ok(Point2::new(0.0, 42.0)));
    let matrix = Matrix3::new(2.0, -3.0, 10.0, 5.0, 7.0, -20.0, 0.0, 0.0, 1.0);
    assert_eq!(map.to_matrix(), matrix);
    // The determinant is 29: back from (0, 42), (7 · (0 − 10) + 3 · (42 + 20)) / 29 = 116 / 29.
    let back = map.inverse().unwrap().apply(&Point2::new(0.0, 42.0));
    assert!((back - Point2::new(4.0, 6.0)).norm() < 1e-14);
    // First (X, Y) ↦ (1 + Y, 2X), then the map: x = 10 + 2(1 + Y) − 6X, y = −20 + 5(1 + Y) + 14X.
    let first = Affine2::from_coefficients([1.0, 0.0, 1.0], [0.0, 2.0, 0.0]);
    let both = Affine2::from_coefficients([12.0, -6.0, 2.0], [-15.0, 14.0, 5.0]);
    assert_eq!(map.after(&first), both);
    assert_eq!(map.after(&Affine2::identity()), map);
    assert!(map.at(&Point2::new(f64::NAN, 0.0)).is_err());
}

#[test]
fn a_fit_is_numpys_least_squares() {
    // numpy 2.4.6: np.linalg.lstsq([1, X, Y], image); sigma0 = √(Σ v² / 4).
    let object = points([[1.0, 2.0], [5.0, 1.0], [6.0, 7.0], [2.0, 8.0], [4.0, 4.0]]);
    let image = points([[10.2, 3.1], [18.0, 5.2], [16.1, 18.3], [7.9, 16.2], [13.3, 10.1]]);
    let fit = Affine2::fit(&object, &image).unwrap();
    let expected = Affine2::from_coefficients(
        [9.412346842601313, 1.8115928369462768, -0.6441093308199808],
        [-1.9697455230914274, 1.0253534401508007, 2.013289349670123],
    );
    assert!((fit.map.to_matrix() - expected.to_matrix()).norm() < 1e-13);
    for (residual, e) in fit.residuals[4].iter().zip([-0.7822808671064969, -0.08482563619226724]) {
        assert!((residual - e).abs() < 1e-13, "{residual} {e}");
    }
    assert!((fit.sigma0.unwrap() - 0.45505848864372417).abs() < 1e-14);
    // Three points leave nothing over.
    let exact = Affine2::fit(&object[..3], &image[..3]).unwrap();
    assert_eq!(exact.sigma0, None);
    assert!(exact.residuals.iter().all(|v| v.norm() < 1e-14));
    assert!((exact.map.apply(&object[1]) - image[1]).norm() < 1e-13);
}

#[test]
fn map_coordinates_cost_no_digits() {
    // A quarter turn and a scale of 2, about (500 000, 5 400 000): x = 7 − 2ΔY, y = 9 + 2ΔX, exact in dyadic numbers.
    let offsets = [[-512.0, 64.0], [256.25, -128.5], [1024.0, 2048.0], [-3.0, -777.0]];
    let object = offsets.map(|[x, y]| Point2::new(500_000.0 + x, 5_400_000.0 + y));
    let image = offsets.map(|[x, y]| Point2::new(7.0 - 2.0 * y, 9.0 + 2.0 * x));
    let fit = Affine2::fit(&object, &image).unwrap();
    for (i, e) in fit.map.linear.iter().zip([0.0, 2.0, -2.0, 0.0]) {
        assert!((i - e).abs() < 1e-14, "{i} {e}");
    }
    assert!(fit.residuals.iter().all(|v| v.norm() < 1e-11), "{:?}", fit.residuals);
    assert!(fit.sigma0.unwrap() < 1e-11);
}

#[test]
fn thin_maps_and_thin_figures_still_have_their_answers() {
    // Columns (1, 1) and (1, 1 + 2⁻³⁰): the determinant is 2⁻³⁰, and the inverse (2³⁰ + 1, −2³⁰; −2³⁰, 2³⁰).
    let (small, large) = (f64::from(1 << 30).recip(), f64::from(1 << 30));
    let thin = Affine2::from_coefficients([0.0, 1.0, 1.0], [0.0, 1.0, 1.0 + small]);
    let inverse = thin.inverse().unwrap();
    let expected = Matrix2::new(large + 1.0, -large, -large, large);
    assert!((inverse.linear - expected).norm() < 1e-6 * large, "{}", inverse.linear);
    // Control points 2⁻³⁰ off a line, u = 3 X, v = 2³⁰ Y.
    let object = points([[0.0, 0.0], [1.0, 0.0], [2.0, small], [3.0, 0.0]]);
    let image = points([[0.0, 0.0], [3.0, 0.0], [6.0, 1.0], [9.0, 0.0]]);
    let fit = Affine2::fit(&object, &image).unwrap();
    let expected = Matrix2::new(3.0, 0.0, 0.0, large);
    assert!((fit.map.linear - expected).norm() < 1e-6 * large, "{}", fit.map.linear);
    // Figures of any size: u = 2 X + Y, v = X − Y.
    for size in [1e-100, 1e-20, 1e20, 1e100] {
        let object = points([[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]]);
        let image = points([[0.0, 0.0], [2.0 * size, size], [3.0 * size, 0.0], [size, -size]]);
        let fit = Affine2::fit(&object, &image).unwrap();
        assert!((fit.map.linear - Matrix2::new(2.0, 1.0, 1.0, -1.0)).norm() < 1e-14, "{size}");
        let line = points([[0.0, 0.0], [size, size], [3.0 * size, 3.0 * size], [-size, -size]]);
        assert!(matches!(Affine2::fit(&line, &image), Err(Error::Degenerate { .. })), "{size}");
    }
    // One in 10¹⁵ is rounding, and no figure.
    let line = points([[0.0, 0.0], [1.0, 0.0], [2.0, 1e-15], [3.0, 0.0]]);
    assert!(matches!(Affine2::fit(&line, &image), Err(Error::Degenerate { .. })));
}

#[test]
fn fits_that_are_none_are_refused() {
    let line = points([[0.0, 0.0], [1.0, 2.0], [2.0, 4.0], [3.0, 6.0]]);
    let square = points([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert!(matches!(Affine2::fit(&line, &square), Err(Error::Degenerate { .. })));
    assert!(matches!(Affine2::fit(&[square[0]; 4], &square), Err(Error::Degenerate { .. })));
    // A picture that collapses to a line is a fit, though it has no way back.
    let flat = Affine2::fit(&square, &line).unwrap();
    assert!(matches!(flat.map.inverse(), Err(Error::Degenerate { .. })));
    assert_eq!(
        Affine2::fit(&square[..2], &square[..2]),
        Err(Error::TooFewPoints { needed: 3, got: 2 })
    );
    assert!(matches!(
        Affine2::fit(&square, &square[..3]),
        Err(Error::LengthMismatch { left: 4, right: 3, .. })
    ));
    let mut bad = square;
    bad[2].y = f64::NAN;
    assert!(matches!(Affine2::fit(&bad, &square), Err(Error::NotFinite { .. })));
    assert!(matches!(Affine2::fit(&square, &bad), Err(Error::NotFinite { .. })));
    for c in [[0.0; 3], [1.0, 2.0, 4.0]] {
        let singular = Affine2::from_coefficients(c, [5.0, c[1] * 3.0, c[2] * 3.0]);
        assert!(matches!(singular.inverse(), Err(Error::Degenerate { .. })));
    }
}

proptest! {
    #[test]
    fn affine_maps_compose_invert_and_are_found_again(
        c in prop::array::uniform6(-10.0..10.0f64), d in prop::array::uniform6(-10.0..10.0f64),
        q in prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 4..12),
    ) {
        let map = Affine2::from_coefficients([c[0], c[1], c[2]], [c[3], c[4], c[5]]);
        let other = Affine2::from_coefficients([d[0], d[1], d[2]], [d[3], d[4], d[5]]);
        let object: Vec<_> = q.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        for p in &object {
            let both = other.after(&map).apply(p);
            prop_assert!((both - other.apply(&map.apply(p))).norm() < 1e-10);
        }
        prop_assume!((c[1] * c[5] - c[2] * c[4]).abs() > 1e-2);
        let inverse = map.inverse().unwrap();
        for p in &object {
            prop_assert!((inverse.apply(&map.apply(p)) - p).norm() < 1e-7);
        }
        let image: Vec<_> = object.iter().map(|p| map.apply(p)).collect();
        let [a, b, e] = [object[0], object[1], object[2]];
        let area = (b - a).perp(&(e - a));
        prop_assume!(area.abs() > 1.0);
        let fit = Affine2::fit(&object, &image).unwrap();
        prop_assert!((fit.map.to_matrix() - map.to_matrix()).norm() < 1e-7);
    }
}
