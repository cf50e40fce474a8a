//! Laws of the maps through control points piece by piece.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use collinear::mapping::Map;
use collinear::mapping::piecewise::{BilinearGrid, PiecewiseAffine, PiecewiseCubic};
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix2, Point2, Vector2};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{numbers, point2, points2};

fn oracles() -> Value {
    serde_json::from_str(include_str!("../data/oracles/piecewise.json")).unwrap()
}

#[test]
fn triangles_and_values_are_those_of_scipy() {
    let mut outside = 0;
    for case in oracles()["cases"].as_array().unwrap() {
        let (screen, texture) = (points2(&case["screen"]), points2(&case["texture"]));
        let affine = PiecewiseAffine::new(&screen, &texture).unwrap();
        let mut triangles = affine.triangles();
        triangles.iter_mut().for_each(|t| t.sort_unstable());
        triangles.sort_unstable();
        let expected: Vec<[usize; 3]> = serde_json::from_value(case["triangles"].clone()).unwrap();
        assert_eq!(triangles, expected);
        let cubic = PiecewiseCubic::new(&screen, &texture).unwrap();
        for (g, expected) in cubic.gradients().iter().zip(case["gradients"].as_array().unwrap()) {
            let e = numbers(expected);
            let difference = g - Matrix2::new(e[0], e[1], e[2], e[3]);
            assert!(difference.amax() < 1e-12, "{difference}");
        }
        for c in case["checks"].as_array().unwrap() {
            let p = point2(&c["screen"]);
            for (map, name) in [(&affine as &dyn Map, "affine"), (&cubic, "cubic")] {
                if c[name].is_null() {
                    outside += 1;
                    assert!(matches!(map.at(&p), Err(ProjectionError::OutsideDomain { .. })));
                } else {
                    let difference = map.at(&p).unwrap() - point2(&c[name]);
                    assert!(difference.norm() < 1e-10, "{name} {p} {difference}");
                }
            }
        }
    }
    assert!(outside > 10);
}

#[test]
fn a_grid_of_bilinears_is_that_of_scipy() {
    let case = &oracles()["grid"];
    let spacing = point2(&case["spacing"]).coords;
    let nodes = points2(&case["nodes"]);
    let grid = BilinearGrid::new(point2(&case["origin"]), spacing, 5, &nodes).unwrap();
    for c in case["checks"].as_array().unwrap() {
        let difference = grid.at(&point2(&c["screen"])).unwrap() - point2(&c["texture"]);
        assert!(difference.norm() < 1e-11, "{difference}");
    }
}

/// Pairs of control points in general position on a screen of 100 × 80.
fn pairs() -> impl Strategy<Value = (Vec<Point2<f64>>, Vec<Point2<f64>>)> {
    let pair = (0.0..100.0, 0.0..80.0, -50.0..50.0, -50.0..50.0);
    prop::collection::vec(pair, 4..40).prop_map(|all| {
        let screen = all.iter().map(|p| Point2::new(p.0, p.1)).collect();
        (screen, all.iter().map(|p| Point2::new(p.0 + p.2, p.1 + p.3)).collect())
    })
}

/// Points on a lattice: rows through corners, edges along rows, many points on the hull.
fn lattice() -> impl Strategy<Value = (Vec<Point2<f64>>, Vec<Point2<f64>>)> {
    prop::collection::btree_map((0..12i32, 0..9i32), (-50.0..50.0, -50.0..50.0), 3..60)
        .prop_map(|all| {
            let at = |c: i32| f64::from(c) + 0.5;
            let screen: Vec<Point2<f64>> =
                all.keys().map(|(x, y)| Point2::new(at(*x), at(*y))).collect();
            let texture: Vec<Point2<f64>> =
                all.values().map(|(u, v): &(f64, f64)| Point2::new(*u, *v)).collect();
            (screen, texture)
        })
        .prop_filter("on a line", |(screen, texture)| PiecewiseAffine::new(screen, texture).is_ok())
}

/// Whether a point lies in the convex hull: by half planes through every pair of points.
fn in_hull(points: &[Point2<f64>], p: &Point2<f64>, margin: f64) -> bool {
    !points.iter().any(|a| {
        points.iter().any(|b| {
            let (d, e) = (b - a, p - a);
            let side = |q: &Vector2<f64>| d.x * q.y - d.y * q.x;
            a != b && points.iter().all(|q| side(&(q - a)) >= 0.0) && side(&e) < margin * d.norm()
        })
    })
}

/// The pixels of a row and their coordinates.
fn row(map: &dyn Map, line: i32, samples: std::ops::Range<i32>) -> Vec<(i32, [f64; 2])> {
    let mut found = Vec::new();
    map.blocks(line, samples, &mut |x, u, v| {
        assert!(u.len() == v.len() && (1..=64).contains(&u.len()));
        found.extend(u.iter().zip(v).enumerate().map(|(i, (u, v))| (x + i as i32, [*u, *v])));
    });
    assert!(found.windows(2).all(|w| w[0].0 < w[1].0));
    found
}

/// Rows are what `at` says at the pixels' centres, wherever they are cut.
fn rows_equal_points(map: &dyn Map) {
    for line in -2..84 {
        let whole = row(map, line, -5..110);
        let expected: Vec<_> = (-5..110)
            .filter_map(|x| {
                let p = map.at(&Point2::new(f64::from(x) + 0.5, f64::from(line) + 0.5)).ok()?;
                Some((x, [p.x, p.y]))
            })
            .collect();
        assert_eq!(whole, expected, "row {line}");
        let mut cut = row(map, line, -5..37);
        cut.extend(row(map, line, 37..38));
        cut.extend(row(map, line, 38..110));
        assert_eq!(whole, cut);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn rows_of_piecewise_maps_are_their_points((screen, texture) in pairs()) {
        rows_equal_points(&PiecewiseAffine::new(&screen, &texture).unwrap());
        rows_equal_points(&PiecewiseCubic::new(&screen, &texture).unwrap());
    }

    #[test]
    fn rows_through_corners_and_along_edges_are_their_points((screen, texture) in lattice()) {
        let affine = PiecewiseAffine::new(&screen, &texture).unwrap();
        rows_equal_points(&affine);
        rows_equal_points(&PiecewiseCubic::new(&screen, &texture).unwrap());
        // All pixels of the hull, its border too, and no others.
        for y in -1..10 {
            for x in -1..13 {
                let p = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                if in_hull(&screen, &p, 1e-9) {
                    prop_assert!(affine.at(&p).is_ok(), "{p}");
                } else if !in_hull(&screen, &p, -1e-9) {
                    prop_assert!(affine.at(&p).is_err(), "{p}");
                }
            }
        }
    }

    #[test]
    fn piecewise_maps_pass_through_their_points((screen, texture) in pairs()) {
        let affine = PiecewiseAffine::new(&screen, &texture).unwrap();
        let cubic = PiecewiseCubic::new(&screen, &texture).unwrap();
        for (s, t) in screen.iter().zip(&texture) {
            prop_assert!((affine.at(s).unwrap() - t).norm() < 1e-9);
            prop_assert!((cubic.at(s).unwrap() - t).norm() < 1e-9);
        }
    }

    #[test]
    fn a_linear_map_is_reproduced((screen, _) in pairs()) {
        let linear = |p: &Point2<f64>| Point2::new(3.0 + 0.5 * p.x - p.y, 7.0 - 0.25 * p.x + 2.0 * p.y);
        let texture: Vec<_> = screen.iter().map(linear).collect();
        let affine = PiecewiseAffine::new(&screen, &texture).unwrap();
        let cubic = PiecewiseCubic::new(&screen, &texture).unwrap();
        for line in 0..80 {
            for (x, [u, v]) in row(&affine, line, 0..100).into_iter().chain(row(&cubic, line, 0..100)) {
                let expected = linear(&Point2::new(f64::from(x) + 0.5, f64::from(line) + 0.5));
                prop_assert!((Point2::new(u, v) - expected).norm() < 1e-8);
            }
        }
    }

    #[test]
    fn the_cubic_is_smooth_and_its_jacobian_is_its_slope((screen, texture) in pairs(), seed in 0..10_000i32) {
        let map = PiecewiseCubic::new(&screen, &texture).unwrap();
        let scale = map.gradients().iter().map(|g| g.amax()).fold(1.0, f64::max);
        // Across every edge of a well-shaped triangle, at some place of it, from both sides.
        let share = 0.05 + 0.9 * f64::from(seed) / 10_000.0;
        let triangles = PiecewiseAffine::new(&screen, &texture).unwrap().triangles();
        let shapely = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| screen[i]);
            let area = ((b - a).x * (c - a).y - (b - a).y * (c - a).x).abs();
            let longest = (b - a).norm().max((c - a).norm()).max((c - b).norm());
            (area > 0.05 * longest * longest).then_some(longest)
        };
        for t in &triangles {
            let Some(longest) = shapely(t) else { continue };
            let [a, b, c] = t.map(|i| screen[i]);
            let centroid = a + ((b - a) + (c - a)) / 3.0;
            let spokes = [(a, centroid), (b, centroid), (c, centroid)];
            let edges = [[0, 1], [1, 2], [2, 0]].map(|e| e.map(|k| t[k]));
            let edges = edges.iter().filter(|e| {
                triangles.iter().all(|t| !e.iter().all(|i| t.contains(i)) || shapely(t).is_some())
            });
            for (p, q) in edges.map(|e| (screen[e[0]], screen[e[1]])).chain(spokes) {
                let at = p + (q - p) * share;
                let across = Vector2::new(q.y - p.y, p.x - q.x).normalize() * 1e-6 * longest;
                // A slope that jumped would jump as much from ten times nearer.
                let jump = |share: f64| {
                    let sides = [1.0, -1.0].map(|side| map.jacobian(&(at + across * side * share)));
                    let [Ok(left), Ok(right)] = sides else { return None };
                    Some((left, (left - right).amax()))
                };
                let (Some((left, jump)), Some((_, nearer))) = (jump(1.0), jump(0.1)) else { continue };
                prop_assert!(nearer < 0.2 * jump + 1e-8 * scale, "{jump} {nearer}");
                let h = 5e-7 * longest;
                for k in 0..2 {
                    let mut step = Vector2::zeros();
                    step[k] = h;
                    let ends = [map.at(&(at + across + step)), map.at(&(at + across - step))];
                    let [Ok(up), Ok(down)] = ends else { continue };
                    let slope = (up - down) / (2.0 * h);
                    prop_assert!((slope - left.column(k)).amax() < 1e-3 * scale);
                }
            }
        }
    }
}

#[test]
fn slopes_of_triangles_by_hand() {
    let points = |c: [(f64, f64); 4]| c.map(|(x, y)| Point2::new(x, y));
    let screen = points([(0., 0.), (10., 0.), (12., 12.), (0., 10.)]);
    let texture = points([(0., 0.), (10., 0.), (14., 10.), (0., 10.)]);
    let map = PiecewiseAffine::new(&screen, &texture).unwrap();
    // Beyond the diagonal J (2, 12) = (4, 10) and J (−10, 10) = (−10, 10); before it nothing moves.
    let beyond = map.jacobian(&Point2::new(7.0, 8.0)).unwrap();
    assert!((beyond - Matrix2::new(8.0, 1.0, -1.0, 6.0) / 7.0).amax() < 1e-14, "{beyond}");
    let before = map.jacobian(&Point2::new(2.0, 3.0)).unwrap();
    assert!((before - Matrix2::identity()).amax() < 1e-14, "{before}");
}

#[test]
fn a_quadratic_with_its_gradients_is_reproduced() {
    let screen = points2(&oracles()["cases"][0]["screen"]);
    let f =
        |p: &Point2<f64>| Point2::new(1e-3 * p.x * p.y - p.y, 2e-3 * p.x * p.x + 1e-3 * p.y * p.y);
    let slope =
        |p: &Point2<f64>| Matrix2::new(1e-3 * p.y, 1e-3 * p.x - 1.0, 4e-3 * p.x, 2e-3 * p.y);
    let texture: Vec<_> = screen.iter().map(f).collect();
    let gradients: Vec<_> = screen.iter().map(slope).collect();
    let map = PiecewiseCubic::with_gradients(&screen, &texture, &gradients).unwrap();
    for (x, [u, v]) in row(&map, 240, 0..640) {
        let p = Point2::new(f64::from(x) + 0.5, 240.5);
        assert!((Point2::new(u, v) - f(&p)).norm() < 1e-10);
        assert!((map.jacobian(&p).unwrap() - slope(&p)).amax() < 1e-12);
    }
}

#[test]
fn far_coordinates_lose_nothing_but_their_own_digits() {
    let case = &oracles()["cases"][1];
    let (screen, texture) = (points2(&case["screen"]), points2(&case["texture"]));
    let shift = Vector2::new(2_097_152.0, 4_194_304.0);
    let far: Vec<_> = screen.iter().map(|p| p + shift).collect();
    for (near, far) in [
        (
            &PiecewiseAffine::new(&screen, &texture).unwrap() as &dyn Map,
            &PiecewiseAffine::new(&far, &texture).unwrap() as &dyn Map,
        ),
        (
            &PiecewiseCubic::new(&screen, &texture).unwrap(),
            &PiecewiseCubic::new(&far, &texture).unwrap(),
        ),
    ] {
        for (x, [u, v]) in row(near, 200, 100..500) {
            let p = Point2::new(f64::from(x) + 0.5, 200.5) + shift;
            // Coordinates of 4·10⁶ are exact to 5e-10.
            assert!((far.at(&p).unwrap() - Point2::new(u, v)).norm() < 2e-8);
        }
    }
}

#[test]
fn grids_are_refused_sampled_and_walked() {
    let node = Point2::new(1.0, 2.0);
    let (origin, spacing) = (Point2::origin(), Vector2::repeat(8.0));
    let grid = |columns, n: usize| BilinearGrid::new(origin, spacing, columns, &vec![node; n]);
    assert!(grid(2, 4).is_ok());
    assert!(matches!(grid(0, 4), Err(Error::TooFewPoints { .. })));
    assert!(matches!(grid(2, 2), Err(Error::TooFewPoints { .. })));
    assert!(matches!(grid(2, 5), Err(Error::LengthMismatch { .. })));
    let bad = BilinearGrid::new(origin, Vector2::new(1.0, 0.0), 2, &[node; 4]);
    assert!(matches!(bad, Err(Error::OutOfRange { .. })));
    let bad = BilinearGrid::new(origin, Vector2::new(1.0, f64::NAN), 2, &[node; 4]);
    assert!(matches!(bad, Err(Error::NotFinite { .. })));
    let bad = BilinearGrid::new(origin, spacing, 2, &[Point2::new(f64::INFINITY, 0.0); 4]);
    assert!(matches!(bad, Err(Error::NotFinite { .. })));
    let screen = points2(&oracles()["cases"][1]["screen"]);
    let texture = points2(&oracles()["cases"][1]["texture"]);
    let map = collinear::mapping::polynomial::Cubic::fit(&screen, &texture).unwrap().map;
    let grid = BilinearGrid::sampled(&map, 100, 80, 16).unwrap();
    rows_equal_points(&grid);
    for p in [Point2::new(32.0, 48.0), Point2::new(0.0, 80.0), Point2::new(112.0, 0.0)] {
        assert!((grid.at(&p).unwrap() - map.at(&p).unwrap()).norm() < 1e-12);
    }
    assert!(matches!(
        grid.at(&Point2::new(113.0, 0.0)),
        Err(ProjectionError::OutsideDomain { value, .. }) if (value - 1.0).abs() < 1e-12
    ));
    let p = Point2::new(50.3, 40.7);
    for k in 0..2 {
        let mut step = Vector2::zeros();
        step[k] = 1e-4;
        let slope = (grid.at(&(p + step)).unwrap() - grid.at(&(p - step)).unwrap()) / 2e-4;
        assert!((slope - grid.jacobian(&p).unwrap().column(k)).amax() < 1e-9);
    }
}

#[test]
fn bad_control_points_are_refused() {
    let p = |x: f64, y: f64| Point2::new(x, y);
    let square = [p(0., 0.), p(1., 0.), p(0., 1.), p(1., 1.)];
    let each = |screen: &[Point2<f64>], texture: &[Point2<f64>]| {
        let affine = PiecewiseAffine::new(screen, texture).map(|_| ()).unwrap_err();
        let cubic = PiecewiseCubic::new(screen, texture).map(|_| ()).unwrap_err();
        assert_eq!(affine, cubic);
        affine
    };
    assert!(matches!(each(&square, &square[1..]), Error::LengthMismatch { left: 4, right: 3, .. }));
    assert!(matches!(each(&[], &[]), Error::TooFewPoints { needed: 3, got: 0 }));
    assert!(matches!(each(&square[..2], &square[..2]), Error::TooFewPoints { got: 2, .. }));
    let line: Vec<_> = (0..5).map(|i| p(f64::from(i), 2.0 * f64::from(i))).collect();
    assert!(matches!(each(&line, &line), Error::Degenerate { .. }));
    let twice = [square[0], square[1], square[2], square[1]];
    assert!(matches!(each(&twice, &square), Error::Degenerate { .. }));
    assert!(matches!(each(&[square[0]; 4], &square), Error::Degenerate { .. }));
    for bad in [f64::NAN, f64::INFINITY] {
        let mut screen = square;
        screen[2].y = bad;
        assert!(matches!(each(&screen, &square), Error::NotFinite { .. }));
        assert!(matches!(each(&square, &screen), Error::NotFinite { .. }));
    }
    assert!(matches!(each(&square.map(|p| p * 1e200), &square), Error::OutOfRange { .. }));
    let affine = PiecewiseAffine::new(&square, &square).unwrap();
    assert_eq!(affine.at(&p(f64::NAN, 0.5)), Err(ProjectionError::NotFinite));
    assert_eq!(affine.jacobian(&p(0.5, f64::INFINITY)), Err(ProjectionError::NotFinite));
    // The border belongs to the map.
    for q in [p(0.0, 0.5), p(1.0, 0.5), p(0.5, 0.0), p(0.5, 1.0), p(1.0, 1.0)] {
        assert!((affine.at(&q).unwrap() - q).norm() < 1e-15, "{q}");
    }
    assert!(matches!(
        affine.at(&p(1.25, 0.5)),
        Err(ProjectionError::OutsideDomain { value: 0.25, limit: 0.0 })
    ));
    // Extremes of scale work.
    for scale in [1e-90, 1e90] {
        let map = PiecewiseCubic::new(&square.map(|p| p * scale), &square).unwrap();
        assert!((map.at(&p(0.25 * scale, 0.5 * scale)).unwrap() - p(0.25, 0.5)).norm() < 1e-12);
    }
    assert!(row(&affine, i32::MAX, 0..4).is_empty());
    assert!(row(&affine, 0, i32::MAX - 2..i32::MAX).is_empty());
}
