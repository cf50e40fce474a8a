//! Laws of the polynomial maps of table 2, and of the bilinear map seen in perspective.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use collinear::geometry::Affine2;
use collinear::mapping::Map;
use collinear::mapping::perspective_bilinear::PerspectiveBilinear;
use collinear::mapping::polynomial::{Bilinear, Cubic, PolynomialFit, Quadratic};
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix2, Matrix3, Point2, Vector3};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{numbers, point2, points2};

fn oracles() -> Value {
    serde_json::from_str(include_str!("../data/oracles/polynomial.json")).unwrap()
}

#[test]
fn fits_in_map_coordinates_of_a_million_metres_equal_a_50_digit_solution() {
    fn check<M: Map>(fit: &PolynomialFit<M>, case: &Value) {
        match case["sigma0"].as_f64() {
            Some(sigma0) => assert!((fit.sigma0.unwrap() / sigma0 - 1.0).abs() < 1e-9),
            None => {
                assert_eq!(fit.sigma0, None);
                assert!(fit.residuals.iter().all(|r| r.norm() < 1e-9));
            }
        }
        assert!(fit.condition > 1.0 && fit.condition < 100.0, "{}", fit.condition);
        for c in case["checks"].as_array().unwrap() {
            let difference = fit.map.at(&point2(&c["object"])).unwrap() - point2(&c["image"]);
            assert!(difference.norm() < 1e-9, "{difference}");
        }
    }
    for case in oracles()["fits"].as_array().unwrap() {
        let (object, image) = (points2(&case["object"]), points2(&case["image"]));
        match case["terms"].as_u64().unwrap() {
            4 => check(&Bilinear::fit(&object, &image).unwrap(), case),
            6 => check(&Quadratic::fit(&object, &image).unwrap(), case),
            _ => check(&Cubic::fit(&object, &image).unwrap(), case),
        }
    }
}

#[test]
fn residuals_are_image_minus_map() {
    let case = &oracles()["fits"][3];
    let (object, image) = (points2(&case["object"]), points2(&case["image"]));
    let fit = Cubic::fit(&object, &image).unwrap();
    for ((o, i), r) in object.iter().zip(&image).zip(&fit.residuals) {
        assert!((i - fit.map.at(o).unwrap() - r).norm() < 1e-12);
    }
    assert!(fit.residuals.iter().any(|r| r.norm() > 0.1));
}

#[test]
fn the_inverse_of_published_bilinear_elements() {
    // "Inverse quad mapping", a Catch2 test of a CUDA spectral-element code: reference square [−1, 1]², corners
    // (−1,−1), (1,−1), (1,1), (−1,1). Here ξ = 2s − 1.
    let quad =
        |c: [(f64, f64); 4]| Bilinear::from_quad(&c.map(|(x, y)| Point2::new(x, y))).unwrap();
    let trapezoid = quad([(1.0, 2.0), (0.0, 1.0), (0.0, 0.0), (1.0, -1.0)]);
    let parallelogram = quad([(0.0, 0.0), (1.0, 1.0), (1.0, 2.0), (0.0, 1.0)]);
    for (map, xi, eta, x, y) in [
        (&trapezoid, -0.5, -1.0, 0.75, 1.75),
        (&trapezoid, -1.0, -0.5, 1.0, 1.25),
        (&trapezoid, -0.5, -0.5, 0.75, 1.125),
        (&trapezoid, 0.5, -0.5, 0.25, 0.875),
        (&trapezoid, 0.0, 0.0, 0.5, 0.5),
        (&trapezoid, -0.5, 0.5, 0.75, -0.125),
        (&trapezoid, 0.5, 0.5, 0.25, 0.125),
        (&trapezoid, 0.0, 1.0, 0.5, -0.5),
        (&parallelogram, -0.5, -0.5, 0.25, 0.5),
        (&parallelogram, 0.5, 0.5, 0.75, 1.5),
        (&parallelogram, 0.5, -1.0, 0.75, 0.75),
    ] {
        let found = map.inverse(&Point2::new(x, y)).unwrap();
        let expected = Point2::new(0.5 * (xi + 1.0), 0.5 * (eta + 1.0));
        assert!((found - expected).norm() < 1e-15, "{found} {expected}");
    }
}

#[test]
fn folded_and_degenerate_quads_are_refused() {
    let quad = |c: [(f64, f64); 4]| Bilinear::from_quad(&c.map(|(x, y)| Point2::new(x, y)));
    // A concave quad: the third corner's triangle turns the other way, twice its area −0.4.
    let Err(Error::FoldedQuad { weights }) = quad([(0.0, 0.0), (1.0, 0.0), (0.3, 0.3), (0.0, 1.0)])
    else {
        panic!("concave")
    };
    assert!(weights[2] < 0.0 && weights[0] > 0.0, "{weights:?}");
    assert!((weights[2] + 0.4).abs() < 1e-15);
    assert!(matches!(
        quad([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]),
        Err(Error::FoldedQuad { .. })
    ));
    assert!(matches!(quad([(1.0, 1.0); 4]), Err(Error::FoldedQuad { .. })));
    assert!(matches!(quad([(f64::NAN, 1.0); 4]), Err(Error::NotFinite { .. })));
    let fold = Bilinear::from_coefficients([0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap();
    // x = X + Y, y = XY: X and Y are the roots of z² − x z + y; none real where y > x²/4.
    let [Some(a), Some(b)] = fold.roots(&Point2::new(3.0, 2.0)).unwrap() else { panic!("two") };
    let sorted = |p: Point2<f64>| (p.x.min(p.y), p.x.max(p.y));
    assert_eq!((sorted(a), sorted(b)), ((1.0, 2.0), (1.0, 2.0)));
    assert!(matches!(
        fold.inverse(&Point2::new(2.0, 1.5)),
        Err(ProjectionError::OutsideDomain { value, limit: 1.0 }) if (value - 1.5).abs() < 1e-15
    ));
    // The preferred root is the one in the domain.
    let right = fold.with_domain(&Point2::new(1.5, 0.0), &Point2::new(3.0, 1.6)).unwrap();
    assert!(
        (right.inverse(&Point2::new(3.0, 2.0)).unwrap() - Point2::new(2.0, 1.0)).norm() < 1e-15
    );
    let left = fold.with_domain(&Point2::new(0.0, 1.5), &Point2::new(1.6, 3.0)).unwrap();
    assert!((left.inverse(&Point2::new(3.0, 2.0)).unwrap() - Point2::new(1.0, 2.0)).norm() < 1e-15);
    // A map onto a line has no inverse.
    let line = Bilinear::from_coefficients([0.0, 1.0, 1.0, 1.0], [0.0; 4]).unwrap();
    assert!(line.inverse(&Point2::new(0.5, 0.0)).is_err());
}

#[test]
fn too_few_or_degenerate_control_points_are_refused() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let nine: Vec<_> = (0..9).map(|i| p(f64::from(i), f64::from(i * i % 7))).collect();
    assert_eq!(Cubic::fit(&nine, &nine), Err(Error::TooFewPoints { needed: 10, got: 9 }));
    assert!(matches!(Quadratic::fit(&nine, &nine[1..]), Err(Error::LengthMismatch { .. })));
    // Eight points on a circle: X² + Y² − 1 vanishes, so the quadratic terms are not determined, with σ_min/σ_max ~ 0.
    let circle: Vec<_> = (0..8).map(|i| p(f64::from(i).cos(), f64::from(i).sin())).collect();
    assert!(matches!(
        Quadratic::fit(&circle, &circle),
        Err(Error::Degenerate { measure, .. }) if measure < 1e-12
    ));
    assert!(Bilinear::fit(&circle, &circle).is_ok());
    let line: Vec<_> = (0..9).map(|i| p(f64::from(i), 1e6)).collect();
    assert!(matches!(Bilinear::fit(&line, &line), Err(Error::Degenerate { .. })));
    let wild = [p(f64::NAN, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
    assert!(matches!(Bilinear::fit(&wild, &wild), Err(Error::NotFinite { .. })));
}

fn coefficient() -> impl Strategy<Value = f64> {
    -2.0..2.0f64
}

proptest! {
    #[test]
    fn a_bilinear_map_keeps_axis_parallel_lines_straight_and_makes_parabolas_of_others(
        a in proptest::array::uniform4(coefficient()),
        b in proptest::array::uniform4(coefficient()),
        start in proptest::array::uniform2(-3.0..3.0f64),
        direction in proptest::array::uniform2(-1.0..1.0f64),
    ) {
        let map = Bilinear::from_coefficients(a, b).unwrap();
        let at = |d: [f64; 2], k: i32| {
            let t = f64::from(k);
            map.at(&Point2::new(start[0] + d[0] * t, start[1] + d[1] * t)).unwrap()
        };
        for d in [[direction[0], 0.0], [0.0, direction[1]], direction] {
            // Second differences along the line: constant, 2 (A₃, B₃) p q; zero along an axis. Third ones vanish.
            for k in -2..3 {
                let second = (at(d, k + 1) - at(d, k)) - (at(d, k) - at(d, k - 1));
                let expected = nalgebra::Vector2::new(a[3], b[3]) * (2.0 * d[0] * d[1]);
                prop_assert!((second - expected).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn the_inverse_of_a_bilinear_map_returns_the_point_of_the_square(
        corners in proptest::array::uniform8(-0.45..0.45f64),
        s in 0.0..1.0f64, t in 0.0..1.0f64, far in prop_oneof![Just(0.0), Just(5e6)], scale in 1.0..5000.0f64,
    ) {
        let base = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let quad: [Point2<f64>; 4] = std::array::from_fn(|i| {
            Point2::new(far + scale * (base[i].0 + corners[2 * i]), far + scale * (base[i].1 + corners[2 * i + 1]))
        });
        let Ok(map) = Bilinear::from_quad(&quad) else { return Ok(()) };
        let image = map.at(&Point2::new(s, t)).unwrap();
        let back = map.inverse(&image).unwrap();
        // Condition: rounding of the image through the inverse Jacobian.
        let jacobian = map.jacobian(&Point2::new(s, t)).unwrap();
        let growth = jacobian.try_inverse().unwrap().norm();
        let rounding = 16.0 * f64::EPSILON * (image.coords.norm() + scale);
        prop_assume!(growth * rounding < 1e-4 && growth * scale < 1e3);
        prop_assert!((back - Point2::new(s, t)).norm() < 8.0 * growth * rounding, "{back} {s} {t}");
        let again = map.at(&back).unwrap();
        prop_assert!((again - image).norm() <= rounding, "{}", (again - image).norm());
        // As a map of its own, with the inverse Jacobian.
        let inverted = map.inverted();
        prop_assert_eq!(inverted.at(&image), Ok(back));
        let product = inverted.jacobian(&image).unwrap() * map.jacobian(&back).unwrap();
        prop_assert!((product - Matrix2::identity()).norm() < 1e-9);
    }

    #[test]
    fn quadratic_and_cubic_maps_are_inverted_and_say_how(
        bend in proptest::array::uniform16(-0.04..0.04f64),
        x in 0.0..1.0f64, y in 0.0..1.0f64,
    ) {
        let a = [3.0, 1.0, 0.1, bend[0], bend[1], bend[2], bend[3], bend[4], bend[5], bend[6]];
        let b = [-2.0, -0.2, 0.9, bend[7], bend[8], bend[9], bend[10], bend[11], bend[12], bend[13]];
        let p = Point2::new(x, y);
        let cubic = Cubic::from_coefficients(a, b).unwrap();
        let found = cubic.inverse(&cubic.at(&p).unwrap()).unwrap();
        prop_assert!((found.point - p).norm() < 1e-13, "{:?}", found);
        prop_assert!(found.residual < 1e-13 && found.iterations <= 8);
        let quadratic = Quadratic::from_coefficients(
            std::array::from_fn(|k| a[k]), std::array::from_fn(|k| b[k]),
        ).unwrap();
        let found = quadratic.inverse(&quadratic.at(&p).unwrap()).unwrap();
        prop_assert!((found.point - p).norm() < 1e-13);
    }

    #[test]
    fn expanded_coefficients_are_the_same_map(
        xy in proptest::collection::vec((-5.0..5.0f64, -5.0..5.0f64, -9.0..9.0f64, -9.0..9.0f64), 12..20),
        p in (-5.0..5.0f64, -5.0..5.0f64),
    ) {
        let object: Vec<_> = xy.iter().map(|v| Point2::new(v.0, v.1)).collect();
        let image: Vec<_> = xy.iter().map(|v| Point2::new(v.2, v.3)).collect();
        let Ok(fit) = Cubic::fit(&object, &image) else { return Ok(()) };
        prop_assume!(fit.condition < 1e4);
        let [a, b] = fit.map.coefficients();
        let raw = Cubic::from_coefficients(a, b).unwrap();
        let p = Point2::new(p.0, p.1);
        prop_assert!((raw.at(&p).unwrap() - fit.map.at(&p).unwrap()).norm() < 1e-7 * fit.condition);
        // The gradient of the sum of squares vanishes: residuals are orthogonal to every term.
        for k in 0..10 {
            let exponents = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2), (3, 0), (0, 3)][k];
            let term = |o: &Point2<f64>| o.x.powi(exponents.0) * o.y.powi(exponents.1);
            let dot: f64 = object.iter().zip(&fit.residuals).map(|(o, r)| term(o) * r.x).sum();
            prop_assert!(dot.abs() < 1e-9 * fit.condition, "{k} {dot}");
        }
    }

    #[test]
    fn a_bilinear_patch_in_perspective_returns_its_texture_points(
        offsets in proptest::array::uniform12(-0.3..0.3f64),
        s in 0.0..1.0f64, t in 0.0..1.0f64, far in prop_oneof![Just(0.0), Just(65_000.0)],
    ) {
        let base = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let corners: [Vector3<f64>; 4] = std::array::from_fn(|i| {
            let w = 2.0 + 3.0 * offsets[8 + i];
            Vector3::new(
                (far + 400.0 * (base[i].0 + offsets[2 * i])) * w,
                (far + 400.0 * (base[i].1 + offsets[2 * i + 1])) * w,
                w,
            )
        });
        let map = PerspectiveBilinear::new(&corners, [512.0, 256.0]).unwrap();
        let texture = Point2::new(512.0 * s, 256.0 * t);
        let screen = map.screen_from_texture(&texture).unwrap();
        let seen = map.at(&screen).unwrap();
        // The patch may hide the point behind another of its own; what is seen projects to the same pixel.
        let again = map.screen_from_texture(&seen).unwrap();
        prop_assert!((again - screen).norm() < 1e-8, "{}", (again - screen).norm());
        let roots = map.roots(&screen).unwrap();
        let w = |p: &Point2<f64>| roots.iter().flatten().find(|r| (r.texture - p).norm() < 1e-3).map(|r| r.w);
        let growth = map.jacobian(&screen).map_or(f64::INFINITY, |j| j.norm());
        if (seen - texture).norm() > 1e-9 * (1.0 + growth) && growth < 1e3 {
            // Not the same point: the other one is nearer.
            prop_assert!(w(&seen).unwrap() <= w(&texture).unwrap());
        }
    }

    #[test]
    fn a_parallelogram_in_space_is_a_homography(
        a in proptest::array::uniform3(-1.0..1.0f64),
        b in proptest::array::uniform3(-1.0..1.0f64),
        c in proptest::array::uniform3(-1.0..1.0f64),
        s in 0.0..1.0f64, t in 0.0..1.0f64,
    ) {
        // A camera of 500 pixels at the origin, the parallelogram about 5 in front of it.
        let project = |p: [f64; 3]| {
            let (x, y, z) = (p[0], p[1], p[2] + 5.0);
            Vector3::new(500.0 * x + 320.0 * z, 500.0 * y + 240.0 * z, z)
        };
        let sum = |f: f64, g: f64| std::array::from_fn(|i| a[i] + f * b[i] + g * c[i]);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(f, g)| project(sum(f, g)));
        let homography = Matrix3::from_columns(&[corners[1] - corners[0], corners[3] - corners[0], corners[0]]);
        let Some(inverse) = homography.try_inverse() else { return Ok(()) };
        prop_assume!(homography.norm() * inverse.norm() < 1e5);
        let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
        let h = homography * Vector3::new(s, t, 1.0);
        let screen = Point2::new(h.x / h.z, h.y / h.z);
        prop_assert!((map.screen_from_texture(&Point2::new(s, t)).unwrap() - screen).norm() < 1e-9);
        let back = inverse * Vector3::new(screen.x, screen.y, 1.0);
        let back = Point2::new(back.x / back.z, back.y / back.z);
        prop_assert!((map.at(&screen).unwrap() - back).norm() < 1e-6);
    }

    #[test]
    fn no_coordinates_make_them_panic(
        v in proptest::array::uniform16(prop_oneof![
            Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(1e200), Just(-1e200), Just(1e-200), -2.0..2.0f64,
        ]),
    ) {
        let p = |i: usize| Point2::new(v[2 * i % 16], v[(2 * i + 1) % 16]);
        let some: Vec<_> = (0..12).map(|i| p(i) + nalgebra::Vector2::new(0.0, i as f64)).collect();
        let finite = |q: Point2<f64>| q.x.is_finite() && q.y.is_finite();
        for n in [3, 4, 6, 10, 12] {
            if let Ok(fit) = Bilinear::fit(&some[..n], &some[..n]) {
                let _ = (fit.map.inverse(&p(3)), fit.map.coefficients(), fit.map.jacobian(&p(2)));
            }
            if let Ok(fit) = Quadratic::fit(&some[..n], &some[..n]) {
                let _ = fit.map.inverse(&p(3));
            }
            if let Ok(fit) = Cubic::fit(&some[..n], &some[..n]) {
                let _ = fit.map.inverse(&p(3));
            }
        }
        if let Ok(map) = Bilinear::from_quad(&[p(0), p(1), p(2), p(3)]) {
            prop_assert!(map.inverse(&p(5)).map_or(true, finite));
        }
        if let Ok(map) = Cubic::from_coefficients(std::array::from_fn(|i| v[i]), std::array::from_fn(|i| v[i + 5])) {
            if let Ok(q) = map.inverse(&p(1)) { prop_assert!(finite(q.point)); }
            if let Ok(q) = map.at(&p(0)) { prop_assert!(finite(q)); }
        }
        let h: [Vector3<f64>; 4] = std::array::from_fn(|i| Vector3::new(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
        if let Ok(map) = PerspectiveBilinear::new(&h, [v[12], v[13]]) {
            if let Ok(q) = map.at(&p(0)) { prop_assert!(finite(q)); }
            let _ = (map.roots(&p(1)), map.jacobian(&p(2)), map.screen_from_texture(&p(3)));
        }
    }
}

#[test]
fn a_patch_in_perspective_equals_a_50_digit_solution() {
    for case in oracles()["patches"].as_array().unwrap() {
        let corners: Vec<_> = case["corners"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| Vector3::from_vec(numbers(c)))
            .collect();
        let size = numbers(&case["size"]);
        let map =
            PerspectiveBilinear::new(&corners.try_into().unwrap(), [size[0], size[1]]).unwrap();
        for c in case["checks"].as_array().unwrap() {
            let screen = point2(&c["screen"]);
            // The corners x w ~ 10⁵ round at 10⁻¹¹; the Jacobian is about 0.2 texels a pixel.
            let difference = map.at(&screen).unwrap() - point2(&c["texture"]);
            assert!(difference.norm() < 1e-10, "{difference}");
            let expected: Vec<_> =
                c["jacobian"].as_array().unwrap().iter().flat_map(numbers).collect();
            let jacobian = map.jacobian(&screen).unwrap();
            assert!((jacobian - Matrix2::from_row_slice(&expected)).norm() < 1e-11);
        }
    }
}

#[test]
fn of_two_points_on_one_ray_the_nearer_is_seen() {
    // A sheet bent so that it hides part of itself: the corner (1, 1) is folded over (0, 0) and lies nearer.
    let corners = [(0.0, 0.0, 4.0), (100.0, 0.0, 3.0), (10.0, 10.0, 2.0), (0.0, 100.0, 3.0)]
        .map(|(x, y, w)| Vector3::new(x * w, y * w, w));
    let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
    let screen = map.screen_from_texture(&Point2::new(0.3, 0.3)).unwrap();
    let [Some(near), Some(far)] = map.roots(&screen).unwrap() else { panic!("two roots") };
    assert!(near.w < far.w);
    assert!((far.texture - Point2::new(0.3, 0.3)).norm() < 1e-12, "{far:?}");
    assert!(near.texture.x > 0.5 && near.texture.x < 1.0);
    assert_eq!(map.at(&screen).unwrap(), near.texture);
    // Outside the quad, and behind the eye.
    assert!(matches!(
        map.at(&Point2::new(-50.0, -50.0)),
        Err(ProjectionError::OutsideDomain { .. })
    ));
    let behind = corners.map(|c| -c);
    assert!(matches!(PerspectiveBilinear::new(&behind, [1.0; 2]), Err(Error::OutOfRange { .. })));
    assert!(PerspectiveBilinear::new(&corners, [0.0, 1.0]).is_err());
}

#[test]
fn a_point_met_behind_the_eye_is_not_seen() {
    // The corner (1, 1) is behind the eye: the texture's far end never shows.
    let corners = [(0.0, 0.0, 2.0), (300.0, 0.0, 1.0), (300.0, 300.0, -1.0), (0.0, 300.0, 1.0)]
        .map(|(x, y, w): (f64, f64, f64)| Vector3::new(x * w, y * w, w));
    let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
    assert!(matches!(
        map.screen_from_texture(&Point2::new(0.95, 0.95)),
        Err(ProjectionError::BehindCamera { depth }) if depth < 0.0
    ));
    // What (0.95, 0.95) divides to is a plausible pixel; nothing of the texture shows there from behind.
    let h = |s: f64, t: f64| {
        corners[0] * ((1.0 - s) * (1.0 - t))
            + corners[1] * (s * (1.0 - t))
            + corners[2] * (s * t)
            + corners[3] * ((1.0 - s) * t)
    };
    let p = h(0.95, 0.95);
    let pixel = Point2::new(p.x / p.z, p.y / p.z);
    match map.at(&pixel) {
        Ok(q) => assert!(h(q.x, q.y).z > 0.0),
        Err(e) => assert!(matches!(e, ProjectionError::BehindCamera { .. }), "{e}"),
    }
}

#[test]
fn corners_on_the_focal_plane_are_allowed_and_points_on_it_are_not_seen() {
    // w falls from 1 over 0 to −1 down the texture; x w and y w are 40 s and 40 t.
    let corners = [(0.0, 0.0, 1.0), (40.0, 0.0, 1.0), (40.0, 40.0, -1.0), (0.0, 40.0, -1.0)];
    let map = PerspectiveBilinear::new(&corners.map(|(x, y, w)| Vector3::new(x, y, w)), [1.0, 1.0]);
    let map = map.unwrap();
    assert_eq!(
        map.screen_from_texture(&Point2::new(0.25, 0.5)),
        Err(ProjectionError::BehindCamera { depth: 0.0 })
    );
    let seen = map.screen_from_texture(&Point2::new(0.25, 0.25)).unwrap();
    assert!((seen - Point2::new(20.0, 20.0)).norm() < 1e-13, "{seen}");
    // Homogeneous coordinates of any size.
    for size in [1e-60, 1e60, 1e90] {
        let corners = corners.map(|(x, y, w)| Vector3::new(x, y, w) * size);
        let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
        assert!((map.screen_from_texture(&Point2::new(0.25, 0.25)).unwrap() - seen).norm() < 1e-13);
    }
    let corners = corners.map(|(x, y, w)| Vector3::new(x, y, w) * 1e101);
    assert!(matches!(
        PerspectiveBilinear::new(&corners, [1.0, 1.0]),
        Err(Error::OutOfRange { what: "quad corner or texture size", .. })
    ));
    // Two corners with w = 0 itself: w = 1 − t, and (s, ½) shows at (80 s, 40).
    let corners = [(0.0, 0.0, 1.0), (40.0, 0.0, 1.0), (40.0, 40.0, 0.0), (0.0, 40.0, 0.0)];
    let map = PerspectiveBilinear::new(&corners.map(|(x, y, w)| Vector3::new(x, y, w)), [1.0, 1.0]);
    let map = map.unwrap();
    let seen = map.screen_from_texture(&Point2::new(0.25, 0.5)).unwrap();
    assert!((seen - Point2::new(20.0, 40.0)).norm() < 1e-13, "{seen}");
    assert!((map.at(&seen).unwrap() - Point2::new(0.25, 0.5)).norm() < 1e-13);
    // A patch with no corner in front of the eye, not even on its focal plane.
    let flat = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0)];
    for w in [0.0, -1.0] {
        let corners = flat.map(|(x, y)| Vector3::new(x, y, w));
        assert!(matches!(
            PerspectiveBilinear::new(&corners, [1.0, 1.0]),
            Err(Error::OutOfRange { what: "w of every quad corner", value, .. }) if value == w
        ));
    }
}

#[test]
fn a_screen_point_beyond_the_largest_float_is_none() {
    // At t = ¼ w is 10⁻²⁵⁰/2 and one coordinate 10¹⁰⁰/4; the other stays at zero.
    let w = 1e-250;
    for axis in [Vector3::x(), Vector3::y()] {
        let near = Vector3::new(0.0, 0.0, w);
        let far = axis * 1e100 - near;
        let map = PerspectiveBilinear::new(&[near, near, far, far], [1.0, 1.0]).unwrap();
        let beyond = map.screen_from_texture(&Point2::new(0.5, 0.25));
        assert_eq!(beyond, Err(ProjectionError::NotFinite));
    }
}

#[test]
fn a_pixel_outside_says_how_far_its_nearer_root_is() {
    // x = s + s t, y = t + s t: at (6, 6) s = t and s² + s = 6, so s = 2 or −3; |2s − 1| is 3 or 7.
    let corners =
        [(0.0, 0.0), (1.0, 0.0), (2.0, 2.0), (0.0, 1.0)].map(|(x, y)| Vector3::new(x, y, 1.0));
    let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
    match map.at(&Point2::new(6.0, 6.0)) {
        Err(ProjectionError::OutsideDomain { value, limit }) => {
            assert!((value - 3.0).abs() < 1e-13 && limit == 1.0, "{value}");
        }
        other => panic!("{other:?}"),
    }
    let mut roots: Vec<_> =
        map.roots(&Point2::new(6.0, 6.0)).unwrap().iter().flatten().map(|r| r.texture.x).collect();
    roots.sort_by(f64::total_cmp);
    assert!((roots[0] + 3.0).abs() < 1e-13 && (roots[1] - 2.0).abs() < 1e-13, "{roots:?}");
}

#[test]
fn the_only_root_in_front_comes_first() {
    // x w = s + s t, y w = t + s t, w = 1 + s/2 + t: at (2, 2) s = t and s² − 2 s − 2 = 0, s = 1 ± √3 with
    // w = (5 ± 3√3)/2, one before the eye and one behind it.
    let w = |s: f64, t: f64| 1.0 + 0.5 * s + t;
    let corner = |s: f64, t: f64| Vector3::new(s + s * t, t + s * t, w(s, t));
    let square = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    // Mirrored about y = 0 and turned over, the quadratic's roots come in another order.
    let mirrored = square.map(|c| Vector3::new(c.x, -c.y, c.z));
    let swapped = [square[0], square[3], square[2], square[1]];
    let opposite = |h: [Vector3<f64>; 4]| [h[2], h[3], h[0], h[1]];
    let root = 1.0 + 3f64.sqrt();
    for (corners, pixel, texture) in [
        (square, [2.0, 2.0], [root, root]),
        (mirrored, [2.0, -2.0], [root, root]),
        (swapped, [2.0, 2.0], [root, root]),
        (opposite(square), [2.0, 2.0], [1.0 - root, 1.0 - root]),
        (opposite(mirrored), [2.0, -2.0], [1.0 - root, 1.0 - root]),
        (opposite(swapped), [2.0, 2.0], [1.0 - root, 1.0 - root]),
    ] {
        let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
        let [Some(first), None] = map.roots(&Point2::from(pixel)).unwrap() else {
            panic!("one root in front: {:?}", map.roots(&Point2::from(pixel)));
        };
        assert!((first.texture - Point2::from(texture)).norm() < 1e-12, "{first:?}");
        assert!((first.w - (5.0 + 27f64.sqrt()) / 2.0).abs() < 1e-12, "{first:?}");
    }
}

#[test]
fn a_patch_through_the_eye_is_not_seen_where_it_is_at_the_eye() {
    // The corners sum to zero: (½, ½) is the eye itself, which every line of sight meets.
    let corners = [(1.0, 0.0, 1.0), (0.0, 1.0, -1.0), (-1.0, 0.0, 1.0), (0.0, -1.0, -1.0)]
        .map(|(x, y, w)| Vector3::new(x, y, w));
    let map = PerspectiveBilinear::new(&corners, [1.0, 1.0]).unwrap();
    for pixel in [[0.5, 0.25], [0.25, 0.125], [-0.5, 0.25], [0.0, 0.0]] {
        let roots = map.roots(&Point2::from(pixel)).unwrap();
        assert!(roots.iter().flatten().all(|r| r.w > 0.0), "{roots:?}");
    }
}

#[test]
fn an_affine_map_is_a_map() {
    let map = Affine2::from_coefficients([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
    let map: &dyn Map = &map;
    assert_eq!(map.at(&Point2::new(10.0, 100.0)), Ok(Point2::new(321.0, 654.0)));
    assert_eq!(map.jacobian(&Point2::origin()), Ok(Matrix2::new(2.0, 3.0, 5.0, 6.0)));
    assert_eq!(map.at(&Point2::new(f64::NAN, 0.0)), Err(ProjectionError::NotFinite));
}

#[test]
fn an_inversion_that_meets_no_point_says_how_far_it_got() {
    // y = X² + Y² + 1 never reaches 0; the nearest it comes is 1.
    let map = Quadratic::from_coefficients(
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 1.0, 1.0],
    )
    .unwrap();
    match map.inverse(&Point2::new(0.0, 0.0)) {
        Err(ProjectionError::NotConverged { residual, .. }) => assert!(residual >= 1.0 - 1e-12),
        other => panic!("{other:?}"),
    }
}
