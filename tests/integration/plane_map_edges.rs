//! The eight numbers where their signs decide, and a lens as a map, by hand.

use collinear::camera::{
    Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation, Orthographic,
};
use collinear::geometry::{Affine2, Plane};
use collinear::mapping::{CantrellPlane, DistortMap, FractionalLinear, Map, UndistortMap};
use collinear::nalgebra::{Matrix2, Point2, Point3, Vector3};
use collinear::{Error, ProjectionError};

/// u = S / w, v = L / w with the given R, and the given E.
fn shifted(r: [f64; 3], e: [f64; 3]) -> FractionalLinear {
    FractionalLinear::from_coefficients([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], r, e).unwrap()
}

#[test]
fn the_horizon_and_the_focal_plane_themselves_are_not_textured() {
    // w or E is S − 2½, zero at the centre of pixel 2.
    let (form, one) = ([-2.5, 1.0, 0.0], [1.0, 0.0, 0.0]);
    let edge = Point2::new(2.5, 7.0);
    let behind = shifted(form, one);
    assert_eq!(behind.at(&edge), Err(ProjectionError::BehindCamera { depth: 0.0 }));
    // The depth is w / E: −2 over 4.
    let behind_by_half = shifted(form, [4.0, 0.0, 0.0]);
    assert_eq!(
        behind_by_half.at(&Point2::new(0.5, 0.0)),
        Err(ProjectionError::BehindCamera { depth: -0.5 })
    );
    for r in [one, form, [-9.0, 0.0, 0.0]] {
        assert_eq!(shifted(r, form).at(&edge), Err(ProjectionError::BeyondHorizon { w: 0.0 }));
        let left = Point2::new(1.5, 0.0);
        assert_eq!(shifted(r, form).at(&left), Err(ProjectionError::BeyondHorizon { w: -1.0 }));
    }
    for map in [behind, shifted(one, form), shifted(form, form)] {
        assert_eq!(map.valid_samples(4, 0..9), 3..9);
        assert!(map.jacobian(&edge).is_err());
        assert!(map.at(&Point2::new(3.5, 4.5)).is_ok());
    }
    // The denominator 1/10⁻³⁰⁸ overflows one quotient alone.
    let steep =
        FractionalLinear::from_coefficients([1e10, 0.0, 0.0], [0.0; 3], [1e-305, 0.0, 0.0], one);
    assert_eq!(steep.unwrap().at(&edge), Err(ProjectionError::NotFinite));
    let steep =
        FractionalLinear::from_coefficients([0.0; 3], [1e10, 0.0, 0.0], [1e-305, 0.0, 0.0], one);
    assert_eq!(steep.unwrap().at(&edge), Err(ProjectionError::NotFinite));
}

#[test]
fn a_triangles_map_gives_its_vertices_and_their_inverse_depths() {
    // Homogeneous screen points (W S, W L, W) and texture points (w u, w v, w).
    let screen = [([2.0, 1.0], 1.0), ([10.0, 3.0], 2.0), ([4.0, 9.0], 4.0)];
    let texture = [([0.0, 0.0], 1.0), ([64.0, 0.0], 0.5), ([0.0, 32.0], 3.0)];
    let homogeneous =
        |points: [([f64; 2], f64); 3]| points.map(|([x, y], w)| Vector3::new(x * w, y * w, w));
    let map = FractionalLinear::from_triangle(&homogeneous(texture), &homogeneous(screen)).unwrap();
    let [e0, e1, e2] = map.eye_coefficients();
    let [_, _, [r0, r1, r2]] = map.coefficients();
    for (([s, l], depth), ([u, v], w)) in screen.into_iter().zip(texture) {
        let at = map.at(&Point2::new(s, l)).unwrap();
        assert!((at - Point2::new(u, v)).norm() < 1e-12, "{at}");
        assert!((e0 + e1 * s + e2 * l - 1.0 / depth).abs() < 1e-15);
        assert!((r0 + r1 * s + r2 * l - w / depth).abs() < 1e-14);
    }
    // Half-way in space from the first vertex to the second: depth 3/2, (W S, W L) = (11, 3.5), (w u, w v, w) = (16, 0, ¾).
    let middle = map.at(&Point2::new(11.0 / 1.5, 3.5 / 1.5)).unwrap();
    assert!((middle - Point2::new(16.0 / 0.75, 0.0)).norm() < 1e-12, "{middle}");
    for depth in [0.0, -0.0, f64::NAN] {
        let mut bad = homogeneous(screen);
        bad[1].z = depth;
        assert!(matches!(
            FractionalLinear::from_triangle(&homogeneous(texture), &bad),
            Err(Error::OutOfRange { what: "W of a triangle's vertex", .. })
        ));
    }
}

/// At a height over z = 0 and y = 0, looking along +y, c = 800 pixels, the origin of the image its principal point.
fn level(height: f64) -> Frame<InteriorOrientation> {
    let center = Point3::new(0.0, 0.0, height);
    Frame::new(
        ExteriorOrientation::look_at(center, center + Vector3::y(), Vector3::z()).unwrap(),
        InteriorOrientation::new([800.0; 2], Point2::origin(), 0.0).unwrap(),
    )
}

#[test]
fn a_point_on_a_focal_plane_is_no_control_point() {
    let (texture, screen) = (level(2.0).homogeneous(), level(3.0).homogeneous());
    let floor = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let flat = [floor(-1.0, 0.0), floor(1.0, 5.0), floor(1.0, 9.0), floor(-1.0, 9.0)];
    let refused = Err(Error::Projection(ProjectionError::BehindCamera { depth: 0.0 }));
    assert_eq!(FractionalLinear::from_four_points(&flat, &texture, &screen), refused);
    let [a, b, c, _] = flat;
    let triangle = FractionalLinear::from_triangle_and_centroid(&[a, b, c], &texture, &screen);
    assert_eq!(triangle, refused);
}

#[test]
fn a_constant_denominator_makes_a_map_affine() {
    let one = [1.0, 0.0, 0.0];
    assert!(shifted([2.0, 0.0, 0.0], one).is_affine());
    assert!(!shifted([2.0, 1e-9, 0.0], one).is_affine());
    assert!(!shifted([2.0, 0.0, 1e-9], one).is_affine());
    assert!(!shifted([0.0, 1e-9, 1e-9], one).is_affine());
}

#[test]
fn a_plane_is_too_near_an_eye_by_its_share_and_too_steep_for_a_parallel_view_by_its_sine() {
    // 10⁻⁸ below the eye: near enough to pass through it where the plane is anchored a million away, and not at one.
    let (eye, texture) = (level(0.0).homogeneous(), level(3.0).homogeneous());
    let anchored =
        |x: f64| Plane::from_point_and_normal(Point3::new(x, 0.0, -1e-8), Vector3::z()).unwrap();
    assert!(FractionalLinear::from_plane(&anchored(1.0), &texture, &eye).is_ok());
    assert!(matches!(
        FractionalLinear::from_plane(&anchored(1e6), &texture, &eye),
        Err(Error::Degenerate { what: "plane through the eye", measure: 1e-8, .. })
    ));
    // A parallel view straight down from far off: a plane that its lines meet at 10⁻⁹ still has a picture.
    let down =
        ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 1e6), Point3::origin(), Vector3::y());
    let above = Orthographic::new(down.unwrap(), Affine2::identity()).unwrap().homogeneous();
    let steep = |sine: f64| {
        Plane::from_point_and_normal(Point3::new(0.0, 20.0, 0.0), Vector3::new(0.0, -1.0, sine))
            .unwrap()
    };
    assert!(FractionalLinear::from_plane(&steep(1e-9), &texture, &above).is_ok());
    assert!(matches!(
        FractionalLinear::from_plane(&steep(1e-14), &texture, &above),
        Err(Error::Degenerate { what: "plane through the eye", .. })
    ));
}

#[test]
fn a_lens_stretches_along_the_radius_and_across_it_by_its_own_numbers() {
    // r″ = r + r³/4 about (500, 400), c = 100: r = 1 goes to 5/4; along the radius by 1 + 3/4, across it by 1 + 1/4.
    let interior = InteriorOrientation::new([100.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let camera = BrownCamera::new(interior, Brown::new([0.25, 0.0, 0.0], [0.0; 2]).unwrap());
    let (distort, undistort) = (DistortMap::new(camera), UndistortMap::new(camera));
    for (ideal, photograph, slope) in [
        ([600.0, 400.0], [625.0, 400.0], [1.75, 1.25]),
        ([500.0, 300.0], [500.0, 275.0], [1.25, 1.75]),
    ] {
        let (ideal, photograph) = (Point2::from(ideal), Point2::from(photograph));
        assert!((distort.at(&ideal).unwrap() - photograph).norm() < 1e-12);
        assert!((undistort.at(&photograph).unwrap() - ideal).norm() < 1e-12);
        let [x, y] = slope;
        let there = distort.jacobian(&ideal).unwrap();
        assert!((there - Matrix2::new(x, 0.0, 0.0, y)).norm() < 1e-14, "{there}");
        let back = undistort.jacobian(&photograph).unwrap();
        assert!((back - Matrix2::new(1.0 / x, 0.0, 0.0, 1.0 / y)).norm() < 1e-14, "{back}");
    }
}

#[test]
fn cantrells_plane_may_pass_close_to_the_eye() {
    // A floor h below the eye, v counted from z = 1: at z = 2, v = 1, it is seen h/2 · 100 below the centre.
    let floor = |h: f64| {
        CantrellPlane::from_texel(Point3::new(0.0, h, 1.0), Vector3::x(), Vector3::z())
            .unwrap()
            .fractional_linear(100.0)
    };
    for h in [1e-3, 1e-6, 1e-9] {
        let at = floor(h).unwrap().at(&Point2::new(0.0, 50.0 * h)).unwrap();
        assert!((at - Point2::new(0.0, 1.0)).norm() < 1e-12, "{h}: {at}");
    }
    assert!(matches!(
        floor(1e-14),
        Err(Error::Degenerate { what: "plane through the eye", measure: 1e-14, .. })
    ));
    let form = CantrellPlane::from_texel(Point3::new(0.0, 1.0, 1.0), Vector3::x(), Vector3::z());
    for d in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(form.unwrap().fractional_linear(d), Err(Error::OutOfRange { .. })));
    }
    // Texel edges whose sine is 10⁻¹⁵ are parallel, whatever their lengths.
    for size in [1e-6, 1.0, 1e6] {
        let edge = Vector3::new(size, 0.0, 0.0);
        let point = Point3::new(0.0, 1.0, 1.0);
        let along =
            |sine: f64| CantrellPlane::from_texel(point, edge, edge + Vector3::z() * size * sine);
        assert!(matches!(along(1e-15), Err(Error::Degenerate { what: "texel edges", .. })));
        assert!(along(1e-12).is_ok());
    }
}
