//! The eight numbers, against rays cast by hand.

use approx::assert_abs_diff_eq;
use collinear::camera::{
    Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation, Orthographic, SensorModel,
};
use collinear::geometry::{Affine2, Plane};
use collinear::mapping::{
    CantrellPlane, Composed, FractionalLinear, Map, PhotographMap, RowCoords, UndistortMap,
};
use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

use crate::support::{PlainCamera, cast, exterior, interior, point};

#[derive(Clone, Debug)]
struct Scene {
    plane: Plane,
    texture: Frame<InteriorOrientation>,
    screen: Frame<InteriorOrientation>,
}

fn scene() -> impl Strategy<Value = Scene> {
    (point(3.0), point(1.0), exterior(), interior(), exterior(), interior()).prop_filter_map(
        "plane through a camera",
        |(p, normal, te, ti, se, si)| {
            let plane = Plane::from_point_and_normal(p, normal.coords.try_normalize(0.05)?).ok()?;
            let clear =
                |e: &ExteriorOrientation| plane.signed_distance(&e.projection_center()).abs() > 0.5;
            (clear(&te) && clear(&se)).then(|| Scene {
                plane,
                texture: Frame::new(te, ti),
                screen: Frame::new(se, si),
            })
        },
    )
}

impl Scene {
    fn map(&self) -> FractionalLinear {
        FractionalLinear::from_plane(
            &self.plane,
            &self.texture.homogeneous(),
            &self.screen.homogeneous(),
        )
        .expect("clear of both cameras")
    }

    /// Cast the screen ray, hit the plane, project into the texture camera: the texture point, the parameter along the
    /// ray and the depth before the texture camera.
    fn by_hand(&self, pixel: [f64; 2]) -> ([f64; 2], f64, f64) {
        let screen = PlainCamera::new(&self.screen.exterior, &self.screen.camera);
        let texture = PlainCamera::new(&self.texture.exterior, &self.texture.camera);
        let n = self.plane.normal().into_inner();
        let (hit, t) = cast(screen.center, screen.ray(pixel), &self.plane.point(), &n);
        let [u, v, depth] = texture.project(hit);
        ([u, v], t, depth)
    }
}

fn pixel() -> impl Strategy<Value = [f64; 2]> {
    [-200.0..1200.0f64, -200.0..1000.0f64]
}

proptest! {
    #[test]
    fn the_map_from_a_plane_and_two_cameras_equals_cast_hit_project(s in scene(), p in pixel()) {
        let map = s.map();
        let ([u, v], t, depth) = s.by_hand(p);
        // Well within both half-spaces the two agree; the tolerance follows the steepness of the map.
        if t > 0.0 && t < 1e3 && depth > 0.05 {
            let screen = Point2::from(p);
            let at = map.at(&screen).expect("visible");
            let slope = map.jacobian(&screen).expect("visible").norm();
            let size = 1.0 + u.abs() + v.abs();
            prop_assert!((at - Point2::new(u, v)).norm() < 1e-9 * (slope + size), "{at} {u} {v} {slope}");
            // E is the inverse depth: the ray's parameter is the depth, its third camera component being one.
            let [e0, e1, e2] = map.eye_coefficients();
            let inverse_depth = e0 + e1 * p[0] + e2 * p[1];
            prop_assert!((inverse_depth * t - 1.0).abs() < 1e-9 * (1.0 + t));
        }
    }

    #[test]
    fn a_pixel_is_textured_only_if_its_ray_meets_the_plane_before_the_eye_and_before_the_texture_camera(
        s in scene(), p in pixel(),
    ) {
        let (_, t, depth) = s.by_hand(p);
        // Off the two boundaries by more than rounding.
        prop_assume!((1.0 / t).abs() > 1e-9 && depth.abs() > 1e-6);
        let at = s.map().at(&Point2::from(p));
        prop_assert_eq!(at.is_ok(), t > 0.0 && depth > 0.0, "t {} depth {} {:?}", t, depth, at);
        match at {
            Err(ProjectionError::BeyondHorizon { w }) => prop_assert!(t < 0.0 && w < 0.0),
            Err(ProjectionError::BehindCamera { depth: d }) => {
                prop_assert!(t > 0.0 && (d - depth).abs() < 1e-6 * depth.abs().max(1.0) * (1.0 + t));
            }
            _ => prop_assert!(at.is_ok()),
        }
    }

    #[test]
    fn the_closed_form_and_the_four_point_solution_agree(s in scene(), p in pixel()) {
        let map = s.map();
        // Four plane points about the spot that an inner pixel shows, if both cameras see them.
        let Ok(_) = map.at(&Point2::new(500.0, 400.0)) else { return Ok(()) };
        let mut corners = [Point3::origin(); 4];
        for (corner, c) in corners.iter_mut().zip([[400.0, 300.0], [600.0, 300.0], [600.0, 500.0], [400.0, 500.0]]) {
            let Ok(world) = s.screen.ground(&Point2::from(c), &s.plane) else { return Ok(()) };
            if s.texture.project(&world).is_err() {
                return Ok(());
            }
            *corner = world;
        }
        let (texture, screen) = (s.texture.homogeneous(), s.screen.homogeneous());
        let Ok(other) = FractionalLinear::from_four_points(&corners, &texture, &screen) else {
            // Only planes seen edge on may refuse.
            let slope = map.jacobian(&Point2::new(500.0, 400.0)).map(|j| j.determinant().abs());
            prop_assert!(slope.is_ok_and(|d| d < 1e-3));
            return Ok(());
        };
        let [a, b, c] = corners_of(&corners);
        let third = FractionalLinear::from_triangle_and_centroid(&[a, b, c], &texture, &screen);
        if let (Ok(x), Ok(y)) = (map.at(&Point2::from(p)), other.at(&Point2::from(p))) {
            let slope = map.jacobian(&Point2::from(p)).expect("visible").norm();
            let conditioning = 1e3 * (1.0 + slope) * (1.0 + x.coords.norm());
            prop_assert!((x - y).norm() < 1e-9 * conditioning, "{x} {y}");
            if let Ok(z) = third.and_then(|m| Ok(m.at(&Point2::from(p))?)) {
                prop_assert!((x - z).norm() < 1e-8 * conditioning, "{x} {z}");
            }
        }
    }

    #[test]
    fn the_denominator_is_proportional_to_inverse_depth_exactly_when_the_texture_w_is_constant(
        s in scene(), axes in (point(1.0), point(1.0)),
    ) {
        // Texture laid on the plane by an affine map: w′ = 1, and R is E times a constant.
        let (u, v) = (axes.0.coords, axes.1.coords);
        let laid_on = collinear::nalgebra::Matrix3x4::new(
            u.x, u.y, u.z, 3.0,
            v.x, v.y, v.z, 4.0,
            0.0, 0.0, 0.0, 1.0,
        );
        let map = FractionalLinear::from_plane_texture(&s.plane, &laid_on, &s.screen.homogeneous()).unwrap();
        let [_, _, r] = map.coefficients();
        prop_assert_eq!(r, map.eye_coefficients());
        // A perspective texture: R is proportional to E only where its image plane is parallel to the plane.
        let map = s.map();
        let ([_, _, r], e) = (map.coefficients(), map.eye_coefficients());
        let cross = Vector3::from(r).cross(&Vector3::from(e)).norm();
        let axis = s.texture.exterior.camera_from_world().inverse() * Vector3::z();
        let tilt = axis.cross(&s.plane.normal()).norm();
        if tilt > 0.05 {
            prop_assert!(cross > 1e-9 * Vector3::from(r).norm() * Vector3::from(e).norm());
        }
    }

    #[test]
    fn a_row_is_its_pixels_and_their_interval_is_exact(s in scene(), line in -300..1100i32, cut in -500..1500i32) {
        let map = s.map();
        let mut row = RowCoords::new();
        map.row(line, -500..1500, &mut row);
        let valid = map.valid_samples(line, -500..1500);
        let mut cut_row = RowCoords::new();
        map.row(line, cut..1500, &mut cut_row);
        let value = |row: &RowCoords, x: i32| {
            row.runs().iter().find(|r| r.pixels().contains(&x)).map(|r| {
                let (u, v) = row.offsets(r);
                let i = (x - r.x) as usize;
                (r.origin, u[i], v[i])
            })
        };
        for x in (-500..1500).step_by(7) {
            let at = map.at(&Point2::new(f64::from(x) + 0.5, f64::from(line) + 0.5));
            prop_assert_eq!(at.is_ok(), valid.contains(&x));
            let found = value(&row, x);
            let within = at.is_ok_and(|p| p.x.abs().max(p.y.abs()) <= RowCoords::COORDINATE_LIMIT);
            prop_assert_eq!(found.is_some(), within);
            if let (Ok(p), Some((origin, u, v))) = (at, found) {
                // 2⁻¹⁸ from the offset's 24 bits, and the rounding of `at`, whose forms cancel towards the horizon.
                let magnitude = |[c0, c1, c2]: [f64; 3]| {
                    c0.abs() + (c1 * (f64::from(x) + 0.5)).abs() + (c2 * (f64::from(line) + 0.5)).abs()
                };
                let [fu, fv, fw] = map.coefficients();
                let w = fw[0] + fw[1] * (f64::from(x) + 0.5) + fw[2] * (f64::from(line) + 0.5);
                for (found, exact, form) in [
                    (f64::from(origin[0]) + f64::from(u), p.x, fu),
                    (f64::from(origin[1]) + f64::from(v), p.y, fv),
                ] {
                    let rounding = f64::EPSILON * (magnitude(form) + exact.abs() * magnitude(fw)) / w;
                    prop_assert!((found - exact).abs() < 4e-6 + 4.0 * rounding, "{found} {exact} {rounding}");
                }
            }
            // Where the row was cut changes nothing, to the last bit.
            if x >= cut {
                prop_assert_eq!(found, value(&cut_row, x));
            }
        }
    }

    #[test]
    fn a_triangle_by_equation_3_is_the_map_of_its_plane(s in scene(), p in pixel()) {
        let map = s.map();
        let screen = PlainCamera::new(&s.screen.exterior, &s.screen.camera);
        let texture = PlainCamera::new(&s.texture.exterior, &s.texture.camera);
        let n = s.plane.normal().into_inner();
        let mut pairs = [(Vector3::zeros(), Vector3::zeros()); 3];
        for (pair, c) in pairs.iter_mut().zip([[300.0, 200.0], [700.0, 250.0], [450.0, 600.0]]) {
            let (hit, t) = cast(screen.center, screen.ray(c), &s.plane.point(), &n);
            if t <= 0.0 {
                return Ok(());
            }
            let [u, v, w] = texture.project(hit);
            let [x, y, z] = screen.project(hit);
            *pair = (Vector3::new(u * w, v * w, w), Vector3::new(x * z, y * z, z));
        }
        let triangle = FractionalLinear::from_triangle(&pairs.map(|q| q.0), &pairs.map(|q| q.1)).unwrap();
        let (a, b) = (map.at(&Point2::from(p)), triangle.at(&Point2::from(p)));
        if let (Ok(a), Ok(b)) = (a, b) {
            let slope = map.jacobian(&Point2::from(p)).unwrap().norm();
            prop_assert!((a - b).norm() < 1e-8 * (1.0 + slope) * (1.0 + a.coords.norm()), "{a} {b}");
        }
    }

    #[test]
    fn cantrells_form_is_the_same_map(s in scene(), p in pixel()) {
        // A texture laid on the plane, texel edges along two directions in it.
        let n = s.plane.normal().into_inner();
        let edge = n.cross(&Vector3::new(0.3, -0.5, 0.81)).normalize();
        let (a, b) = (edge * 0.01, (n.cross(&edge) + edge * 0.2) * 0.02);
        let origin = s.plane.point();
        let to_eye = s.screen.exterior.camera_from_world();
        let in_eye = s.screen.exterior.pose().apply(&origin);
        let form = CantrellPlane::from_texel(in_eye, to_eye * a, to_eye * b).unwrap();
        let f = s.screen.camera.principal_distance()[0];
        let screen = Frame::new(
            s.screen.exterior,
            InteriorOrientation::new([f, f], Point2::origin(), 0.0).unwrap(),
        );
        let map = form.fractional_linear(f).unwrap();
        let centred = Point2::new(p[0] - 500.0, p[1] - 400.0);
        let ray = PlainCamera::new(&screen.exterior, &screen.camera).ray([centred.x, centred.y]);
        let c = screen.exterior.projection_center();
        let (hit, t) = cast([c.x, c.y, c.z], ray, &origin, &n);
        prop_assume!((1.0 / t).abs() > 1e-9);
        let at = map.at(&centred);
        prop_assert_eq!(at.is_ok(), t > 0.0);
        prop_assert!((form.depth(&centred, f) - t).abs() <= 1e-9 * t.abs() * (1.0 + t.abs()));
        if let Ok(at) = at {
            // X − C = u a + v b solved by hand from the Gram matrix.
            let d = Vector3::from(hit) - origin.coords;
            let (aa, ab, bb) = (a.dot(&a), a.dot(&b), b.dot(&b));
            let det = aa * bb - ab * ab;
            let (da, db) = (d.dot(&a), d.dot(&b));
            let expected = Point2::new((bb * da - ab * db) / det, (aa * db - ab * da) / det);
            prop_assert!((at - expected).norm() < 1e-9 * (1.0 + expected.coords.norm()) * (1.0 + t), "{at} {expected}");
        }
    }

    #[test]
    fn a_photograph_is_looked_up_through_its_lens(s in scene(), p in pixel()) {
        let lens = Brown::new([-0.12, 0.03, -0.002], [8e-4, -5e-4]).unwrap();
        let camera = BrownCamera::new(s.texture.camera, lens);
        let photograph = Frame::new(s.texture.exterior, camera);
        let map = PhotographMap::from_plane(&s.plane, &photograph, &s.screen.homogeneous()).unwrap();
        let ([u, v], t, depth) = s.by_hand(p);
        if t > 0.0 && t < 1e3 && depth > 0.05 && (u - 500.0).hypot(v - 400.0) < 0.5 * s.texture.camera.principal_distance()[0] {
            let at = map.at(&Point2::from(p)).expect("visible");
            // OpenCV's formula written out on the ideal point.
            let n = s.texture.camera.normalised_from_pixel(&Point2::new(u, v));
            let (x, y) = (n.x, n.y);
            let r2 = x * x + y * y;
            let radial = 1.0 - 0.12 * r2 + 0.03 * r2 * r2 - 0.002 * r2 * r2 * r2;
            let d = Point2::new(
                x * radial + 2.0 * 8e-4 * x * y - 5e-4 * (r2 + 2.0 * x * x),
                y * radial + 8e-4 * (r2 + 2.0 * y * y) - 2.0 * 5e-4 * x * y,
            );
            let expected = s.texture.camera.pixel_from_normalised(&d);
            let slope = map.jacobian(&Point2::from(p)).unwrap();
            prop_assert!((at - expected).norm() < 1e-8 * (1.0 + slope.norm()) * (1.0 + u.abs() + v.abs()));
            // The Jacobian is the slope.
            for i in 0..2 {
                let mut h = [0.0; 2];
                h[i] = 1e-3;
                let ahead = map.at(&Point2::new(p[0] + h[0], p[1] + h[1]));
                let back = map.at(&Point2::new(p[0] - h[0], p[1] - h[1]));
                if let (Ok(a), Ok(b)) = (ahead, back) {
                    let difference = (a - b) / 2e-3;
                    prop_assert!((difference - slope.column(i)).norm() < 1e-3 * (1.0 + slope.norm()).powi(2));
                }
            }
            // Undone, it is the ideal map again.
            let undone = Composed { outer: UndistortMap::new(camera), inner: map };
            prop_assert!((undone.at(&Point2::from(p)).unwrap() - Point2::new(u, v)).norm() < 1e-8 * (1.0 + slope.norm()) * (1.0 + u.abs() + v.abs()));
        }
    }
}

/// Three of four corners.
fn corners_of(c: &[Point3<f64>; 4]) -> [Point3<f64>; 3] {
    [c[0], c[1], c[2]]
}

fn level_camera(height: f64) -> Frame<InteriorOrientation> {
    let exterior = ExteriorOrientation::look_at(
        Point3::new(0.0, 0.0, height),
        Point3::new(0.0, 1.0, height),
        Vector3::z(),
    );
    // The principal point is the origin of the image.
    Frame::new(
        exterior.unwrap(),
        InteriorOrientation::new([800.0, 800.0], Point2::origin(), 0.0).unwrap(),
    )
}

#[test]
fn r0_may_vanish() {
    // A level texture camera over a floor, its principal point the origin, seen by itself: R₀ = 0.
    let camera = level_camera(2.0).homogeneous();
    let floor = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    let map = FractionalLinear::from_plane(&floor, &camera, &camera).unwrap();
    let [_, _, r] = map.coefficients();
    assert_eq!(r[0], 1.0, "the identity keeps R constant");
    let from_above = Frame::new(
        ExteriorOrientation::look_at(
            Point3::new(0.0, 5.0, 30.0),
            Point3::new(0.0, 5.0, 0.0),
            Vector3::y(),
        )
        .unwrap(),
        InteriorOrientation::new([800.0, 800.0], Point2::origin(), 0.0).unwrap(),
    );
    // As texture: the level camera; its focal plane is y = 0, which the screen above sees in row 800·5/30.
    let map = FractionalLinear::from_plane(&floor, &camera, &from_above.homogeneous()).unwrap();
    let [_, _, r] = map.coefficients();
    assert_abs_diff_eq!(-r[0] / r[2], 800.0 * 5.0 / 30.0, epsilon = 1e-10);
    // Shifted so that row is the origin, R₀ vanishes and the map is the same map.
    let shifted = Frame::new(
        from_above.exterior,
        InteriorOrientation::new([800.0, 800.0], Point2::new(0.0, -800.0 * 5.0 / 30.0), 0.0)
            .unwrap(),
    );
    let map = FractionalLinear::from_plane(&floor, &camera, &shifted.homogeneous()).unwrap();
    let [_, _, r] = map.coefficients();
    assert!(r[0].abs() < 1e-15, "{r:?}");
    // 10 m ahead of the level camera at 2 m: 800 · 2 / 10 below its principal point. From above that spot lies
    // 800 · 5 / 30 above the picture's centre, in the shifted picture at −2 · 800 · 5 / 30.
    let at = map.at(&Point2::new(0.0, -800.0 * 10.0 / 30.0)).unwrap();
    assert_abs_diff_eq!(at, Point2::new(0.0, 160.0), epsilon = 1e-9);
}

#[test]
fn planes_through_a_camera_are_refused_with_their_distance() {
    let camera = level_camera(2.0).homogeneous();
    let other = level_camera(3.0).homogeneous();
    let through = Plane::from_point_and_normal(Point3::new(5.0, 7.0, 2.0), Vector3::z()).unwrap();
    for (texture, screen, what) in [
        (&camera, &other, "plane through the texture camera"),
        (&other, &camera, "plane through the eye"),
    ] {
        match FractionalLinear::from_plane(&through, texture, screen) {
            Err(Error::Degenerate { what: found, measure, .. }) => {
                assert_eq!(found, what);
                assert!(measure < 1e-15);
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn map_coordinates_of_a_million_lose_nothing() {
    let shift = Vector3::new(389_412.25, 5_819_774.5, 64.125);
    let moved = |f: &Frame<InteriorOrientation>| {
        Frame::new(
            ExteriorOrientation::new(
                f.exterior.projection_center() + shift,
                f.exterior.camera_from_world(),
            ),
            f.camera,
        )
    };
    let texture = Frame::new(
        ExteriorOrientation::look_at(
            Point3::new(3.0, -20.0, 12.0),
            Point3::new(0.0, 5.0, 1.0),
            Vector3::z(),
        )
        .unwrap(),
        InteriorOrientation::new([1500.0, 1500.0], Point2::new(800.0, 600.0), 0.0).unwrap(),
    );
    let screen = level_camera(3.0);
    let normal = Vector3::new(0.1, -1.0, 0.05);
    let plane = |o: Vector3<f64>| {
        Plane::from_point_and_normal(Point3::new(1.0, 10.0, 2.0) + o, normal).unwrap()
    };
    let near = FractionalLinear::from_plane(
        &plane(Vector3::zeros()),
        &texture.homogeneous(),
        &screen.homogeneous(),
    )
    .unwrap();
    let far = FractionalLinear::from_plane(
        &plane(shift),
        &moved(&texture).homogeneous(),
        &moved(&screen).homogeneous(),
    )
    .unwrap();
    for p in [[0.0, 0.0], [-300.0, 120.0], [250.0, -80.0]] {
        let p = Point2::from(p);
        // The centres themselves are stored to 1e-9 m; a pixel here is a centimetre.
        assert_abs_diff_eq!(near.at(&p).unwrap(), far.at(&p).unwrap(), epsilon = 1e-6);
    }
}

#[test]
fn parallel_projections_are_the_affine_case() {
    let down =
        ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 50.0), Point3::origin(), Vector3::y())
            .unwrap();
    let aside = ExteriorOrientation::look_at(
        Point3::new(10.0, -30.0, 40.0),
        Point3::origin(),
        Vector3::z(),
    )
    .unwrap();
    let scale = |s: f64| Affine2::from_coefficients([100.0, s, 0.0], [80.0, 0.0, s]);
    let screen = Orthographic::new(down, scale(10.0)).unwrap();
    let texture = Orthographic::new(aside, scale(12.0)).unwrap();
    let plane =
        Plane::from_point_and_normal(Point3::new(1.0, 2.0, 3.0), Vector3::new(0.2, -0.1, 1.0))
            .unwrap();
    let map = FractionalLinear::from_plane(&plane, &texture.homogeneous(), &screen.homogeneous())
        .unwrap();
    assert!(map.is_affine());
    for p in [[0.0, 0.0], [130.0, 60.0]] {
        let p = Point2::from(p);
        // By hand: the screen looks straight down, (x, y) = ((S − 100)/10, (80 − L)/10), z from the plane.
        let (x, y) = ((p.x - 100.0) / 10.0, (80.0 - p.y) / 10.0);
        let z = 3.0 - 0.2 * (x - 1.0) + 0.1 * (y - 2.0);
        let ground = screen.ground(&p, &plane).unwrap();
        assert_abs_diff_eq!(ground, Point3::new(x, y, z), epsilon = 1e-12);
        assert_abs_diff_eq!(
            map.at(&p).unwrap(),
            texture.project(&ground).unwrap(),
            epsilon = 1e-10
        );
    }
    // A perspective texture under a parallel screen is the orthophoto's map.
    let frame = Frame::new(
        aside,
        InteriorOrientation::new([900.0, 900.0], Point2::new(500.0, 400.0), 0.0).unwrap(),
    );
    let map =
        FractionalLinear::from_plane(&plane, &frame.homogeneous(), &screen.homogeneous()).unwrap();
    let p = Point2::new(95.0, 70.0);
    let ground = screen.ground(&p, &plane).unwrap();
    assert_abs_diff_eq!(map.at(&p).unwrap(), frame.project(&ground).unwrap(), epsilon = 1e-9);
}

#[test]
fn bad_input_is_refused() {
    let nan = f64::NAN;
    let e = [1.0, 0.0, 0.0];
    assert!(FractionalLinear::from_coefficients([nan, 0.0, 0.0], e, e, e).is_err());
    let flat =
        [Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 0.0, 1.0), Vector3::new(2.0, 0.0, 1.0)];
    assert!(matches!(FractionalLinear::from_triangle(&flat, &flat), Err(Error::Degenerate { .. })));
    let behind = [Vector3::new(0.0, 0.0, -1.0), flat[1], flat[2]];
    assert!(matches!(
        FractionalLinear::from_triangle(&flat, &behind),
        Err(Error::OutOfRange { .. })
    ));
    let map = FractionalLinear::from_coefficients([0.0, 1.0, 0.0], [0.0, 0.0, 1.0], e, e).unwrap();
    assert_eq!(map.at(&Point2::new(nan, 0.0)), Err(ProjectionError::NotFinite));
    let mut row = RowCoords::new();
    map.row(i32::MAX, i32::MAX - 3..i32::MAX, &mut row);
    assert!(row.runs().is_empty(), "beyond the coordinate limit");
    map.row(0, 5..5, &mut row);
    assert!(row.runs().is_empty());
}
