//! Planes, rays and curves against numbers by hand and by numpy.

use collinear::geometry::{HeightCurve, Locus, Plane, Ray, Surface};
use collinear::nalgebra::{Point3, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

use crate::support::point;

fn p(x: f64, y: f64, z: f64) -> Point3<f64> {
    Point3::new(x, y, z)
}

/// 2x + 3y + 6z = 49 touches the sphere of radius 7 about the origin at (2, 3, 6).
fn sevens() -> Plane {
    Plane::from_coefficients([2.0, 3.0, 6.0, -49.0]).unwrap()
}

#[test]
fn three_points_that_turn_counter_clockwise_face_the_viewer() {
    let plane = Plane::through(&p(5.0, 5.0, 3.0), &p(6.0, 5.0, 3.0), &p(5.0, 6.0, 3.0)).unwrap();
    assert_eq!(plane.coefficients(), [0.0, 0.0, 1.0, -3.0]);
    assert_eq!(plane.signed_distance(&p(-8.0, 2.0, 4.5)), 1.5);
    assert_eq!(plane.flipped().signed_distance(&p(-8.0, 2.0, 4.5)), -1.5);
    assert_eq!(plane.flipped().coefficients(), [0.0, 0.0, -1.0, 3.0]);
    assert_eq!(plane.foot(&p(-8.0, 2.0, 4.5)), p(-8.0, 2.0, 3.0));
    assert_eq!(plane.height_above(&p(0.0, 0.0, 0.0)), -3.0);
    assert_eq!(plane.point(), p(5.0, 5.0, 3.0));
}

#[test]
fn coefficients_go_in_and_come_out() {
    let plane = sevens();
    assert!((plane.point() - p(2.0, 3.0, 6.0)).norm() < 1e-14);
    assert!((plane.signed_distance(&Point3::origin()) + 7.0).abs() < 1e-14);
    let expected = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0, -7.0];
    for (c, e) in plane.coefficients().iter().zip(expected) {
        assert!((c - e).abs() < 1e-14, "{c} {e}");
    }
    // The same plane, scaled beyond the square roots of the largest and the smallest float.
    for scale in [1e-200, 1e-160, 1e160, 1e200] {
        let scaled = [2.0, 3.0, 6.0, -49.0].map(|c| c * scale);
        let plane = Plane::from_coefficients(scaled).unwrap();
        assert!((plane.point() - p(2.0, 3.0, 6.0)).norm() < 1e-13, "{scale}: {}", plane.point());
    }
    // A plane farther off than the largest float is no plane.
    assert!(matches!(
        Plane::from_coefficients([1e-300, 0.0, 0.0, 1e300]),
        Err(Error::NotFinite { .. })
    ));
}

#[test]
fn distances_at_map_coordinates_keep_their_micrometres() {
    // n = (2, 3, 6)/7. All coordinates are dyadic, so each true distance is exact: 7 · 2⁻²⁰ m is 6.7 µm.
    let anchor = p(500_000.25, 5_400_000.5, 300.75);
    let plane = Plane::from_point_and_normal(anchor, Vector3::new(2.0, 3.0, 6.0)).unwrap();
    let step = f64::from(1 << 20).recip();
    let off = anchor + Vector3::new(2.0, 3.0, 6.0) * step;
    assert!((plane.signed_distance(&off) - 7.0 * step).abs() < 1e-20);
    // 1 km along the plane, across (3, −2, 0): still there to the product's rounding.
    let far = off + Vector3::new(3.0, -2.0, 0.0) * 1024.0;
    assert!((plane.signed_distance(&far) - 7.0 * step).abs() < 1e-12);
    // n · X + d of the same numbers has lost them: that is why the plane keeps a point.
    let [a, b, c, d] = plane.coefficients();
    let naive = a * off.x + b * off.y + c * off.z + d;
    assert!((naive - 7.0 * step).abs() < 2e-9);
    let through = Plane::through(
        &anchor,
        &(anchor + Vector3::new(3.0, -2.0, 0.0)),
        &(anchor + Vector3::new(0.0, 2.0, -1.0)),
    )
    .unwrap();
    assert!((through.signed_distance(&off) - 7.0 * step).abs() < 1e-20);
}

#[test]
fn a_fitted_plane_is_numpys() {
    // numpy 2.4.6: c = P.mean(0); n = svd(P − c)[2][2]; (P − c) @ n; the sign is that of Σ (Pᵢ − c) × (Pᵢ₊₁ − c).
    let points =
        [p(0.0, 0.0, 0.2), p(4.0, 0.5, 1.1), p(5.0, 3.0, 2.4), p(1.0, 4.0, 0.9), p(2.0, 2.0, 3.0)];
    let fit = Plane::fit(&points).unwrap();
    let normal = Vector3::new(-0.2891984216561099, -0.24770968175181496, 0.9246643642306268);
    assert!((fit.plane.normal().into_inner() - normal).norm() < 1e-15);
    assert!((fit.plane.point() - p(2.4, 1.9, 1.52)).norm() < 1e-15);
    assert!((fit.rms - 0.7623474410524179).abs() < 1e-15, "{}", fit.rms);
    assert!((fit.largest_residual - 1.4594116595485902).abs() < 1e-15, "{}", fit.largest_residual);
    // Read backwards they show the other side.
    let mut reversed = points;
    reversed.reverse();
    let back = Plane::fit(&reversed).unwrap();
    assert!((back.plane.normal().into_inner() + normal).norm() < 1e-15);
    assert!((back.largest_residual - fit.largest_residual).abs() < 1e-15);
    // The same points in map coordinates.
    let shift = Vector3::new(500_000.0, 5_400_000.0, 0.0);
    let moved = Plane::fit(&points.map(|q| q + shift)).unwrap();
    assert!((moved.plane.normal().into_inner() - normal).norm() < 1e-9);
    assert!((moved.plane.point() - shift - p(2.4, 1.9, 1.52)).norm() < 2e-9);
}

#[test]
fn points_that_do_not_go_around_give_the_normal_whose_largest_component_is_positive() {
    // A bow tie encloses as much clockwise as counter-clockwise.
    let bow = [p(0.0, 0.0, 0.0), p(1.0, 1.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0)];
    let mut orders = vec![bow];
    let mut reversed = bow;
    reversed.reverse();
    orders.push(reversed);
    for order in orders {
        let normal = Plane::fit(&order).unwrap().plane.normal();
        assert!((normal.into_inner() - Vector3::z()).norm() < 1e-15, "{normal:?}");
        // x and z exchanged, and z turned over: the largest component is −z no more.
        let across = order.map(|q| p(q.z, q.x, q.y));
        let normal = Plane::fit(&across).unwrap().plane.normal();
        assert!((normal.into_inner() - Vector3::x()).norm() < 1e-15, "{normal:?}");
    }
    // In planes with the normals (−1, 0, 2), (0, 2, −1) and (2, −1, 0): each its own largest component.
    let oblique = [
        (Vector3::new(2.0, 0.0, 1.0), Vector3::y(), Vector3::new(-1.0, 0.0, 2.0)),
        (Vector3::new(0.0, 1.0, 2.0), Vector3::x(), Vector3::new(0.0, 2.0, -1.0)),
        (Vector3::new(1.0, 2.0, 0.0), Vector3::z(), Vector3::new(2.0, -1.0, 0.0)),
    ];
    for (u, v, normal) in oblique {
        for order in [bow, reversed] {
            let points = order.map(|q| p(1.0, 2.0, 3.0) + u * q.x + v * q.y);
            let found = Plane::fit(&points).unwrap().plane.normal();
            assert!((found.into_inner() - normal.normalize()).norm() < 1e-14, "{found:?}");
        }
    }
}

#[test]
fn planes_that_are_none_are_refused() {
    let line = [p(0.0, 0.0, 0.0), p(1.0, 2.0, 3.0), p(2.0, 4.0, 6.0), p(-1.0, -2.0, -3.0)];
    assert!(matches!(Plane::fit(&line), Err(Error::Degenerate { .. })));
    assert!(matches!(
        Plane::through(&line[0], &line[1], &line[2]),
        Err(Error::Degenerate { measure, .. }) if measure < 1e-14
    ));
    assert!(matches!(
        Plane::fit(&[Point3::origin(); 5]),
        Err(Error::Degenerate { measure: 0.0, .. })
    ));
    assert!(matches!(
        Plane::through(&line[1], &line[1], &line[3]),
        Err(Error::Degenerate { measure: 0.0, .. })
    ));
    assert_eq!(Plane::fit(&line[..2]), Err(Error::TooFewPoints { needed: 3, got: 2 }));
    assert_eq!(Plane::fit(&[]), Err(Error::TooFewPoints { needed: 3, got: 0 }));
    assert!(matches!(
        Plane::from_coefficients([0.0, 0.0, 0.0, 1.0]),
        Err(Error::Degenerate { .. })
    ));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..4 {
            let mut c = [2.0, 3.0, 6.0, -49.0];
            c[i] = bad;
            assert!(matches!(Plane::from_coefficients(c), Err(Error::NotFinite { .. })));
        }
        let points = [p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, bad, 0.0)];
        assert!(matches!(Plane::fit(&points), Err(Error::NotFinite { .. })));
        let [a, b, c] = &points;
        assert!(matches!(Plane::through(a, b, c), Err(Error::NotFinite { .. })));
    }
    // An angle of 10⁻¹³ still makes a plane, 10⁻¹⁵ none.
    let corner = |y: f64| Plane::through(&Point3::origin(), &p(1.0, 0.0, 0.0), &p(1.0, y, 0.0));
    assert!(corner(1e-13).is_ok());
    assert!(matches!(corner(1e-15), Err(Error::Degenerate { limit: 1e-14, .. })));
}

#[test]
fn planes_of_any_size_are_found() {
    for scale in [1e-200, 1e-160, 1e160, 1e200] {
        let corner = |x: f64, y: f64, z: f64| p(x * scale, y * scale, z * scale);
        // x/2 + y/3 + z/6 = 1 has the normal (3, 2, 1)/√14.
        let [a, b, c] = [corner(2.0, 0.0, 0.0), corner(0.0, 3.0, 0.0), corner(0.0, 0.0, 6.0)];
        let normal = Vector3::new(3.0, 2.0, 1.0) / 14f64.sqrt();
        let through = Plane::through(&a, &b, &c).unwrap();
        assert!((through.normal().into_inner() - normal).norm() < 1e-15, "{scale}");
        let fit = Plane::fit(&[a, b, c]).unwrap();
        assert!((fit.plane.normal().into_inner() - normal).norm() < 1e-14, "{scale}");
        assert!(fit.rms < 1e-14 * scale, "{scale}: {}", fit.rms);
    }
}

#[test]
fn rays_meet_a_plane_from_either_side_and_only_forwards() {
    let plane = sevens();
    // Along x from the origin: 2x = 49.
    let ray = |origin, direction| Ray::new(origin, direction).unwrap();
    let hit = plane.meet_ray(&ray(Point3::origin(), Vector3::new(3.0, 0.0, 0.0))).unwrap();
    assert!((hit - p(24.5, 0.0, 0.0)).norm() < 1e-13);
    // From the front, at (10, 10, 10) where 2x + 3y + 6z = 110, down along z: 6z = −1.
    let hit = plane.meet_ray(&ray(p(10.0, 10.0, 10.0), Vector3::new(0.0, 0.0, -1.0))).unwrap();
    assert!((hit - p(10.0, 10.0, -1.0 / 6.0)).norm() < 1e-13);
    for away in [
        ray(Point3::origin(), Vector3::new(-3.0, 0.0, 0.0)),
        ray(p(10.0, 10.0, 10.0), Vector3::z()),
        // 1/8 beyond the plane along its normal, and 10⁻¹² before it.
        ray(p(2.25, 3.375, 6.75), Vector3::new(2.0, 3.0, 6.0)),
        ray(p(2.0, 3.0, 6.0 - 1e-12), Vector3::new(-2.0, -3.0, -6.0)),
    ] {
        assert_eq!(plane.meet_ray(&away), Err(ProjectionError::MissesSurface));
    }
    // A ray that starts on the plane meets it there, whichever way it goes.
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    for direction in [Vector3::z(), -Vector3::z(), Vector3::x()] {
        assert_eq!(ground.meet_ray(&ray(p(4.0, 5.0, 0.0), direction)), Ok(p(4.0, 5.0, 0.0)));
    }
    let along = ray(p(4.0, 5.0, 1.0), Vector3::new(3.0, -2.0, 0.0));
    assert_eq!(ground.meet_ray(&along), Err(ProjectionError::MissesSurface));
    let blind = Ray {
        origin: p(f64::NAN, 0.0, 1.0),
        direction: ray(p(0.0, 0.0, 0.0), Vector3::x()).direction,
    };
    assert_eq!(ground.meet_ray(&blind), Err(ProjectionError::NotFinite));
}

#[test]
fn rays_have_unit_length_at_any_scale() {
    for scale in [1e-300, 1.0, 1e300] {
        let ray = Ray::new(p(1.0, 1.0, 1.0), Vector3::new(2.0, -3.0, 6.0) * scale).unwrap();
        assert!((ray.at(14.0) - p(5.0, -5.0, 13.0)).norm() < 1e-14, "{scale}");
    }
    assert!(matches!(Ray::new(Point3::origin(), Vector3::zeros()), Err(Error::Degenerate { .. })));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(Ray::new(p(0.0, bad, 0.0), Vector3::x()), Err(Error::NotFinite { .. })));
        assert!(matches!(
            Ray::new(Point3::origin(), Vector3::new(0.0, 1.0, bad)),
            Err(Error::NotFinite { .. })
        ));
    }
}

/// z = s³ − s over s = h − 10, which is zero at h = 9, 10 and 11; x = 1 + 2s, y = 3 − s².
fn wave(heights: [f64; 2]) -> HeightCurve {
    HeightCurve {
        coefficients: [
            Vector3::new(1.0, 3.0, 0.0),
            Vector3::new(2.0, 0.0, -1.0),
            Vector3::new(0.0, -1.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ],
        reference_height: 10.0,
        heights,
        error_bound: 0.0,
    }
}

#[test]
fn a_curve_meets_a_surface_at_its_highest_crossing() {
    let curve = wave([8.0, 12.0]);
    assert_eq!(curve.at(12.0), p(5.0, -1.0, 6.0));
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    // Each crossing in turn, as the interval's top comes down, whichever way the plane faces: at h = 10 the curve comes
    // up through the plane.
    let crossings = [
        ([8.0, 12.0], p(3.0, 2.0, 0.0)),
        ([8.0, 10.9], p(1.0, 3.0, 0.0)),
        ([8.0, 9.9], p(-1.0, 2.0, 0.0)),
        ([11.0, 12.0], p(3.0, 2.0, 0.0)),
        ([10.5, 11.0], p(3.0, 2.0, 0.0)),
        // Searched in 64 steps of half a unit, which tell the three crossings apart.
        ([7.5, 39.5], p(3.0, 2.0, 0.0)),
    ];
    for surface in [ground, ground.flipped()] {
        for (heights, expected) in crossings {
            let hit = surface.meet(&Locus::Curve(wave(heights))).unwrap();
            assert!((hit - expected).norm() < 1e-14, "{heights:?}: {hit}");
        }
        for none in
            [[11.125, 12.0], [10.25, 10.75], [8.0, 8.875], [f64::NAN, 1.0], [0.0, f64::INFINITY]]
        {
            assert_eq!(
                surface.meet_curve(&wave(none)),
                Err(ProjectionError::MissesSurface),
                "{none:?}"
            );
        }
    }
}

proptest! {
    #[test]
    fn a_foot_lies_in_the_plane_at_the_signed_distance(
        a in point(100.0), b in point(100.0), c in point(100.0), q in point(100.0), t in -50.0..50.0f64,
    ) {
        let Ok(plane) = Plane::through(&a, &b, &c) else { return Ok(()) };
        let sine = (b - a).cross(&(c - a)).norm() / ((b - a).norm() * (c - a).norm());
        prop_assume!(sine > 1e-3);
        let n = plane.normal().into_inner();
        // The determinant is the oracle: six times the volume over twice the area.
        let volume = (b - a).cross(&(c - a)).dot(&(q - a)) / (b - a).cross(&(c - a)).norm();
        prop_assert!((plane.signed_distance(&q) - volume).abs() < 1e-9);
        let foot = plane.foot(&q);
        prop_assert!(plane.signed_distance(&foot).abs() < 1e-11);
        prop_assert!(((q - foot) - n * volume).norm() < 1e-9);
        prop_assert!((plane.signed_distance(&(foot + n * t)) - t).abs() < 1e-11);
        let fit = Plane::fit(&[a, b, c]).unwrap().plane;
        prop_assert!((fit.normal().into_inner() - n).norm() < 1e-9);
        // From the point back along the normal a ray meets the foot.
        let towards = if volume > 0.0 { -n } else { n };
        let hit = plane.meet_ray(&Ray::new(q, towards).unwrap()).unwrap();
        prop_assert!((hit - foot).norm() < 1e-10);
    }

    #[test]
    fn any_numbers_give_a_plane_or_a_reason(c in prop::array::uniform9(any::<f64>()), d in any::<f64>()) {
        let [a, b, e] = [0, 3, 6].map(|i| p(c[i], c[i + 1], c[i + 2]));
        let planes = [
            Plane::through(&a, &b, &e),
            Plane::fit(&[a, b, e]).map(|f| f.plane),
            Plane::from_coefficients([c[0], c[1], c[2], d]),
            Plane::from_point_and_normal(a, b.coords),
        ];
        for plane in planes.into_iter().flatten() {
            prop_assert!(plane.point().coords.iter().all(|v| v.is_finite()));
            prop_assert!((plane.normal().norm() - 1.0).abs() < 1e-14);
        }
    }
}
