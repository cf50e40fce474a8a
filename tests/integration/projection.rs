//! Projection matrices, clip volumes and viewports against the manuals' formulas and another program's numbers.

use collinear::geometry::projection::{
    ClipConvention, DepthRange, Outcode, Projection, Viewport, survey,
};
use collinear::{Error, ProjectionError};
use glam::dcamera::rh::proj;
use nalgebra::{Matrix4, Point2, Point3, Vector4};
use proptest::prelude::*;

use ClipConvention::{Direct3d, OpenGl, Vulkan, Wgpu};
const ALL: [ClipConvention; 4] = [OpenGl, Direct3d, Vulkan, Wgpu];

// Element by element, relative to the largest of its row.
fn same(got: &Matrix4<f64>, expected: &Matrix4<f64>, tolerance: f64) {
    for i in 0..4 {
        let scale = expected.row(i).amax();
        for j in 0..4 {
            let d = (got[(i, j)] - expected[(i, j)]).abs();
            assert!(d <= tolerance * scale, "({i}, {j}) of {got} against {expected}");
        }
    }
}

fn glam(m: glam::DMat4) -> Matrix4<f64> {
    Matrix4::from_column_slice(&m.to_cols_array())
}

// OpenGL 2.1 reference pages, glFrustum: A = (r + l)/(r − l), B = (t + b)/(t − b), C = −(f + n)/(f − n),
// D = −2fn/(f − n).
#[test]
fn glfrustum_and_its_corners() {
    let [l, r, b, t, n, f] = [-1.0, 3.0, -2.0, 1.0, 1.5, 20.0];
    let view =
        Projection::from_window_at_near([l, r, b, t], DepthRange::new(n, f).unwrap()).unwrap();
    // 3/4, 2/4, 3/3, −1/3, −21.5/18.5, −60/18.5.
    #[rustfmt::skip]
    let manual = Matrix4::new(
        0.75, 0.0, 0.5, 0.0,
        0.0, 1.0, -1.0 / 3.0, 0.0,
        0.0, 0.0, -43.0 / 37.0, -120.0 / 37.0,
        0.0, 0.0, -1.0, 0.0,
    );
    same(&view.clip_from_eye(OpenGl), &manual, 4e-16);

    // (l, b, −n) and (r, t, −n) are the opposite corners of the near face in the same manual.
    for convention in ALL {
        let [z_near, z_far] = convention.ndc_depth();
        let up = if convention.y_down() { -1.0 } else { 1.0 };
        let k = f / n;
        for (eye, ndc) in [
            ([l, b, -n], [-1.0, -up, z_near]),
            ([r, t, -n], [1.0, up, z_near]),
            ([l * k, t * k, -f], [-1.0, up, z_far]),
        ] {
            let clip = view.clip_from_eye(convention) * Vector4::new(eye[0], eye[1], eye[2], 1.0);
            assert!((clip.w + eye[2]).abs() < 1e-15);
            for i in 0..3 {
                assert!((clip[i] / clip.w - ndc[i]).abs() < 4e-15, "{convention:?} {clip}");
            }
            // The same point in camera axes.
            let camera = Vector4::new(eye[0], -eye[1], -eye[2], 1.0);
            assert_eq!(view.clip_from_camera(convention) * camera, clip);
        }
    }
}

// Microsoft, D3DXMatrixPerspectiveOffCenterRH, row vectors: 2zn/(r−l) …; (l+r)/(r−l), (t+b)/(t−b), zf/(zn−zf), −1;
// 0, 0, zn·zf/(zn−zf), 0.
#[test]
fn d3dx_perspective_off_center_rh() {
    let depth = DepthRange::new(1.5, 20.0).unwrap();
    let view = Projection::from_window_at_near([-1.0, 3.0, -2.0, 1.0], depth).unwrap();
    #[rustfmt::skip]
    let manual = Matrix4::new(
        0.75, 0.0, 0.0, 0.0,
        0.0, 1.0, 0.0, 0.0,
        0.5, -1.0 / 3.0, -40.0 / 37.0, -1.0,
        0.0, 0.0, -60.0 / 37.0, 0.0,
    );
    same(&view.clip_from_eye(Direct3d), &manual.transpose(), 4e-16);
    assert_eq!(view.clip_from_eye(Wgpu), view.clip_from_eye(Direct3d));
}

// OpenGL 2.1 reference pages, glOrtho.
#[test]
fn glortho_and_its_corners() {
    let depth = DepthRange::new(-50.0, 75.0).unwrap();
    let view = Projection::orthographic([100.0, 740.0, -30.0, 450.0], depth).unwrap();
    #[rustfmt::skip]
    let manual = Matrix4::new(
        2.0 / 640.0, 0.0, 0.0, -840.0 / 640.0,
        0.0, 2.0 / 480.0, 0.0, -420.0 / 480.0,
        0.0, 0.0, -2.0 / 125.0, -25.0 / 125.0,
        0.0, 0.0, 0.0, 1.0,
    );
    same(&view.clip_from_eye(OpenGl), &manual, 4e-16);
    let corner = view.clip_from_camera(Vulkan) * Vector4::new(740.0, -450.0, 75.0, 1.0);
    assert!((corner - Vector4::new(1.0, -1.0, 1.0, 1.0)).amax() < 1e-15);
}

// gluPerspective(17, 16/9, 2, 5000) and D3DXMatrixPerspectiveFovRH of the same: mpmath 1.3.0, 30 digits.
#[test]
fn glu_perspective_of_a_long_lens() {
    let depth = DepthRange::new(2.0, 5000.0).unwrap();
    let view = Projection::from_field_of_view(17f64.to_radians(), 16.0 / 9.0, depth).unwrap();
    let m = view.clip_from_eye(OpenGl);
    let expected = [3.763775384053543, 6.69115623831741, -1.000800320128051, -4.001600640256102];
    for (got, expected) in [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(2, 3)]].into_iter().zip(expected) {
        assert!((got / expected - 1.0).abs() < 4e-16);
    }
    let m = view.clip_from_eye(Direct3d);
    assert!((m[(2, 2)] / -1.0004001600640256 - 1.0).abs() < 4e-16);
    assert!((m[(2, 3)] / -2.000800320128051 - 1.0).abs() < 4e-16);
}

// An infinite far plane puts infinity, and a reversed range the near plane, at the end of the depth buffer.
#[test]
fn infinite_and_reversed_depth() {
    let depth = DepthRange::infinite(0.25).unwrap().reversed();
    let view = Projection::from_field_of_view(1.0, 1.5, depth).unwrap();
    let m = view.clip_from_camera(Wgpu);
    let ndc = |z: f64| {
        let clip = m * Vector4::new(0.0, 0.0, z, 1.0);
        clip.z / clip.w
    };
    assert_eq!(ndc(0.25), 1.0);
    assert_eq!(ndc(1.0), 0.25);
    assert_eq!(ndc(1e6), 0.25e-6);
    assert_eq!(view.depth_from_ndc(Wgpu, 0.25e-6), Ok(1e6));
    assert_eq!(
        view.depth_from_ndc(Wgpu, 0.0),
        Err(ProjectionError::OutsideDomain { value: 0.0, limit: 0.0 })
    );
    assert!(view.depth_from_ndc(Wgpu, -0.5).is_err());
    assert!(view.depth_from_ndc(Wgpu, f64::NAN).is_err());
    // Beyond infinity nothing is inside; z stays positive.
    assert!(Wgpu.contains(&(m * Vector4::new(0.0, 0.0, 1e12, 1.0))));
    assert!(!Wgpu.contains(&(m * Vector4::new(0.0, 0.0, 0.2, 1.0))));
}

// Vulkan specification, Primitive Clipping: −w ≤ x ≤ w, −w ≤ y ≤ w, z_m ≤ z ≤ w, z_m = 0.
#[test]
fn the_planes_bound_the_volume() {
    assert!(!OpenGl.contains(&Vector4::zeros()));
    assert!(!OpenGl.contains(&Vector4::new(0.0, 0.0, 0.0, -1.0)));
    assert!(Vulkan.contains(&Vector4::new(2.0, -2.0, 0.0, 2.0)));
    assert_eq!(Vulkan.outcode(&Vector4::new(2.5, -2.5, -0.1, 2.0)).bits(), 0b01_0110);
    assert_eq!(OpenGl.outcode(&Vector4::new(0.0, 0.0, -0.1, 2.0)), Outcode::default());
    assert_eq!(Wgpu.outcode(&Vector4::new(0.0, 0.0, -0.1, 2.0)), Outcode::Z_LOW);
    let nan = Direct3d.outcode(&Vector4::new(0.0, f64::NAN, 0.5, 1.0));
    assert_eq!(nan, Outcode::Y_LOW.either(Outcode::Y_HIGH));
    assert!(!Direct3d.contains(&Vector4::new(0.0, 0.0, 0.5, f64::NAN)));
}

// glViewport(10, 20, 640, 480) in a window 600 high; D3D: X = (x + 1) width/2 + left, Y = (1 − y) height/2 + top; Vulkan:
// x_f = (p_x/2) x_d + o_x, y_f = (p_y/2) y_d + o_y, z_f = p_z z_d + o_z with o = corner + size/2, o_z = minDepth.
#[test]
fn viewports_of_the_manuals() {
    let ndc = Point3::new(-0.25, 0.5, 0.75);
    let window = Viewport::from_lower_left([10.0, 20.0], [640.0, 480.0], 600.0).unwrap();
    // x_w = 0.75 · 320 + 10 = 250, y_w = 1.5 · 240 + 20 = 380 from below, z_w = 1.75/2.
    assert_eq!(window.window_from_ndc(OpenGl, &ndc), Point3::new(250.0, 220.0, 0.875));

    let window =
        Viewport::new(10.0, 20.0, 640.0, 480.0).unwrap().with_depth_range(0.2, 0.6).unwrap();
    let expected = Point3::new(250.0, 0.5 * 240.0 + 20.0, 0.2 + 0.75 * 0.4);
    assert!((window.window_from_ndc(Direct3d, &ndc) - expected).amax() < 1e-15);
    assert!((window.window_from_ndc(Wgpu, &ndc) - expected).amax() < 1e-15);
    let expected = Point3::new(250.0, 240.0 * 0.5 + 260.0, 0.5);
    assert!((window.window_from_ndc(Vulkan, &ndc) - expected).amax() < 1e-15);
    // glDepthRange(0.2, 0.6): (f − n)/2 z + (n + f)/2.
    assert!((window.window_from_ndc(OpenGl, &ndc).z - (0.2 * 0.75 + 0.4)).abs() < 1e-15);
}

#[test]
fn degenerate_views_are_refused_with_their_number() {
    let depth = DepthRange::new(1.0, 10.0).unwrap();
    for fov in [0.0, -1.0, std::f64::consts::PI, 4.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Projection::from_field_of_view(fov, 1.0, depth),
            Err(Error::OutOfRange { what: "vertical field of view", .. })
        ));
    }
    for aspect in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Projection::from_field_of_view(1.0, aspect, depth).is_err());
    }
    assert_eq!(
        DepthRange::new(5.0, 5.0),
        Err(Error::OutOfRange {
            what: "near depth",
            value: 5.0,
            expected: "less than the far depth"
        })
    );
    assert!(DepthRange::new(2.0, 1.0).is_err());
    assert!(DepthRange::new(f64::NAN, 1.0).is_err());
    assert!(DepthRange::new(1.0, f64::INFINITY).is_err());
    for near in [0.0, -1.0] {
        let depth = DepthRange::new(near, 10.0).unwrap();
        assert!(Projection::from_field_of_view(1.0, 1.0, depth).is_err());
        assert!(Projection::orthographic([0.0, 1.0, 0.0, 1.0], depth).is_ok());
    }
    let endless = DepthRange::infinite(1.0).unwrap();
    assert!(Projection::orthographic([0.0, 1.0, 0.0, 1.0], endless).is_err());
    for window in [[1.0, 1.0, 0.0, 1.0], [0.0, 1.0, 2.0, 2.0], [f64::NAN, 1.0, 0.0, 1.0]] {
        assert!(Projection::from_window_at_near(window, depth).is_err());
        assert!(Projection::orthographic(window, depth).is_err());
    }
    let centre = Point2::new(1.0, 1.0);
    for (c, size) in
        [([0.0, 1.0], [2.0, 2.0]), ([1.0, 1.0], [2.0, 0.0]), ([1.0, f64::NAN], [2.0; 2])]
    {
        assert!(Projection::from_principal_distance(c, centre, size, depth).is_err());
    }
    let nowhere = Point2::new(f64::NAN, 1.0);
    assert!(Projection::from_principal_distance([1.0; 2], nowhere, [2.0; 2], depth).is_err());
    assert!(Viewport::new(0.0, 0.0, 0.0, 1.0).is_err());
    assert!(Viewport::new(f64::NAN, 0.0, 1.0, 1.0).is_err());
    assert!(Viewport::from_lower_left([0.0; 2], [1.0; 2], f64::NAN).is_err());
    let window = Viewport::new(0.0, 0.0, 2.0, 2.0).unwrap();
    assert!(window.with_depth_range(0.5, 0.5).is_err());
    for (w, expected) in [
        (0.0, ProjectionError::BehindCamera { depth: 0.0 }),
        (-2.0, ProjectionError::BehindCamera { depth: -2.0 }),
        (f64::NAN, ProjectionError::NotFinite),
    ] {
        let clip = Vector4::new(0.1, 0.2, 0.3, w);
        assert_eq!(window.window_from_clip(Wgpu, &clip), Err(expected));
    }
    let far = Vector4::new(1e200, 0.0, 0.0, 1e-200);
    assert_eq!(window.window_from_clip(Wgpu, &far), Err(ProjectionError::NotFinite));
    assert!(survey::projection(f64::NAN).is_err());
    assert!(survey::survey_from_camera(0.0).is_err());
    assert!(survey::image(f64::INFINITY, &Point3::new(1.0, 1.0, 0.0)).is_err());
}

// [WD] table 2: w = 1 + z/f. From the eye the same camera is x = f X/Z, and 1/f → 0 is the orthographic view.
#[test]
fn the_surveys_matrix_is_perspective_and_orthographic() {
    let f = 152.4;
    let p = survey::projection(1.0 / f).unwrap() * survey::survey_from_camera(f).unwrap();
    let camera = Vector4::new(30.0, -20.0, 900.0, 1.0);
    let h = p * camera;
    assert!((h.w - 900.0 / f).abs() < 1e-15);
    assert!((h.x / h.w - f * 30.0 / 900.0).abs() < 1e-14);
    assert!((h.y / h.w + f * 20.0 / 900.0).abs() < 1e-14);

    let point = Point3::new(3.0, 4.0, 7.0);
    assert_eq!(survey::projection(0.0).unwrap(), Matrix4::identity());
    assert_eq!(survey::image(0.0, &point), Ok(Point2::new(3.0, 4.0)));
    let mut last = f64::INFINITY;
    for f in [1e2, 1e4, 1e6, 1e8] {
        let off = (survey::image(1.0 / f, &point).unwrap() - Point2::new(3.0, 4.0)).norm();
        // 5 · 7/f to first order.
        assert!((off * f - 35.0).abs() < 300.0 / f + 1e-7 && off < last);
        last = off;
    }
    // The photogrammetric sign: the eye at z = +c looks along −z.
    assert_eq!(survey::image(-0.1, &Point3::new(1.0, 0.0, 5.0)), Ok(Point2::new(2.0, 0.0)));
    assert_eq!(
        survey::image(-0.1, &Point3::new(1.0, 0.0, 20.0)),
        Err(ProjectionError::BehindCamera { depth: -1.0 })
    );
}

fn edge() -> impl Strategy<Value = (f64, f64)> {
    (-5.0..5.0f64, 0.01..5.0f64, any::<bool>())
        .prop_map(|(a, size, flip)| if flip { (a + size, a) } else { (a, a + size) })
}

proptest! {
    // glam 0.34 (`dcamera::rh::proj`) is the other program: eye axes with y up, looking along −z.
    #[test]
    fn every_matrix_is_glams(
        (l, r) in edge(), (b, t) in edge(), near in 0.01..10.0f64, length in 0.1..1e4f64,
        fov in 0.05..3.0f64, aspect in 0.2..5.0f64,
    ) {
        let far = near + length;
        let depth = DepthRange::new(near, far).unwrap();
        // An edge near zero makes r + l cancel; both programs then round alike, to the rounding of the edges.
        let tolerance = 1e-14;

        let view = Projection::from_window_at_near([l, r, b, t], depth).unwrap();
        same(&view.clip_from_eye(OpenGl), &glam(proj::opengl::frustum(l, r, b, t, near, far)), tolerance);
        same(&view.clip_from_eye(Direct3d), &glam(proj::directx::frustum(l, r, b, t, near, far)), tolerance);
        same(&view.clip_from_eye(Wgpu), &glam(proj::directx::frustum(l, r, b, t, near, far)), tolerance);
        same(&view.clip_from_eye(Vulkan), &glam(proj::vulkan::frustum(l, r, b, t, near, far)), tolerance);

        let view = Projection::orthographic([l, r, b, t], depth).unwrap();
        same(&view.clip_from_eye(OpenGl), &glam(proj::opengl::orthographic(l, r, b, t, near, far)), tolerance);
        same(&view.clip_from_eye(Direct3d), &glam(proj::directx::orthographic(l, r, b, t, near, far)), tolerance);
        same(&view.clip_from_eye(Vulkan), &glam(proj::vulkan::orthographic(l, r, b, t, near, far)), tolerance);

        let view = Projection::from_field_of_view(fov, aspect, depth).unwrap();
        same(&view.clip_from_eye(OpenGl), &glam(proj::opengl::perspective(fov, aspect, near, far)), tolerance);
        same(&view.clip_from_eye(Wgpu), &glam(proj::directx::perspective(fov, aspect, near, far)), tolerance);
        same(&view.clip_from_eye(Vulkan), &glam(proj::vulkan::perspective(fov, aspect, near, far)), tolerance);

        let endless = DepthRange::infinite(near).unwrap();
        let view = Projection::from_field_of_view(fov, aspect, endless).unwrap();
        same(&view.clip_from_eye(Direct3d), &glam(proj::directx::perspective_infinite(fov, aspect, near)), tolerance);
        same(&view.clip_from_eye(Vulkan), &glam(proj::vulkan::perspective_infinite(fov, aspect, near)), tolerance);
        let view = Projection::from_field_of_view(fov, aspect, endless.reversed()).unwrap();
        same(&view.clip_from_eye(Wgpu), &glam(proj::directx::perspective_infinite_reverse(fov, aspect, near)), tolerance);
        same(&view.clip_from_eye(Vulkan), &glam(proj::vulkan::perspective_infinite_reverse(fov, aspect, near)), tolerance);
    }

    #[test]
    fn a_point_lands_on_the_pixel_it_images_at(
        x in -2.0..2.0f64, y in -2.0..2.0f64, z in 0.1..1e3f64, cx in 100.0..5000.0f64, ratio in 0.5..2.0f64,
        px in -500.0..5000.0f64, py in -500.0..5000.0f64, width in 16u32..65_535, height in 16u32..65_535,
        corner_x in 0.0..100.0f64, corner_y in 0.0..100.0f64, reversed in any::<bool>(),
    ) {
        let size = [f64::from(width), f64::from(height)];
        let mut depth = DepthRange::new(0.1, 1e4).unwrap();
        if reversed {
            depth = depth.reversed();
        }
        let cy = cx * ratio;
        let view = Projection::from_principal_distance([cx, cy], Point2::new(px, py), size, depth).unwrap();
        let window = Viewport::new(corner_x, corner_y, size[0], size[1]).unwrap();
        // The collinearity equations in pixels.
        let (px, py) = (cx * x + px + corner_x, cy * y + py + corner_y);
        let camera = Vector4::new(x * z, y * z, z, 1.0);
        for convention in ALL {
            let clip = view.clip_from_camera(convention) * camera;
            let got = window.window_from_clip(convention, &clip).unwrap();
            let scale = size[0] + size[1] + px.abs() + py.abs() + 2.0 * (cx + cy);
            prop_assert!((got.x - px).abs() <= 4.0 * f64::EPSILON * scale, "{} {}", got.x, px);
            prop_assert!((got.y - py).abs() <= 4.0 * f64::EPSILON * scale, "{} {}", got.y, py);
            let eye = Vector4::new(camera.x, -camera.y, -camera.z, 1.0);
            prop_assert_eq!(view.clip_from_eye(convention) * eye, clip);
            // And back, through the window's depth.
            let ndc = window.ndc_from_window(convention, &got);
            let back = view.depth_from_ndc(convention, ndc.z).unwrap();
            prop_assert!((back / z - 1.0).abs() < 64.0 * f64::EPSILON * (z / 0.1));
            let h = window.window_from_clip_matrix(convention) * clip;
            prop_assert!((h.x / h.w - got.x).abs() <= 4.0 * f64::EPSILON * scale);
            prop_assert_eq!(h.w, clip.w);
        }
    }

    #[test]
    fn the_clip_volume_is_the_view_volume(
        x in -3.0..3.0f64, y in -3.0..3.0f64, z in -5.0..30.0f64, reversed in any::<bool>(), parallel in any::<bool>(),
    ) {
        let mut depth = DepthRange::new(1.0, 20.0).unwrap();
        if reversed {
            depth = depth.reversed();
        }
        // At depth 1: x from −1 to 0.5, y (down) from −0.25 to 0.75.
        let edges = [-1.0, 0.5, -0.75, 0.25];
        let view = if parallel { Projection::orthographic(edges, depth) } else { Projection::from_window_at_near(edges, depth) }.unwrap();
        let k = if parallel { 1.0 } else { z };
        let slack = [x + k, 0.5 * k - x, y + 0.25 * k, 0.75 * k - y, z - 1.0, 20.0 - z];
        prop_assume!(slack.iter().all(|s| s.abs() > 1e-9));
        let inside = slack.iter().all(|s| *s > 0.0);
        for convention in ALL {
            let clip = view.clip_from_camera(convention) * Vector4::new(x, y, z, 1.0);
            prop_assert_eq!(convention.contains(&clip), inside, "{:?}", convention);
            let planes = convention.planes();
            for (bit, plane) in planes.iter().enumerate() {
                let outside = convention.outcode(&clip).bits() >> bit & 1 == 1;
                prop_assert_eq!(plane.dot(&clip) < 0.0, outside);
            }
        }
    }

    #[test]
    fn any_number_makes_a_view_or_an_error(
        a in any::<f64>(), b in any::<f64>(), c in any::<f64>(), d in any::<f64>(), n in any::<f64>(), f in any::<f64>(),
    ) {
        let views = [DepthRange::new(n, f), DepthRange::infinite(n)].into_iter().flatten().flat_map(|depth| [
            Projection::from_window_at_near([a, b, c, d], depth),
            Projection::orthographic([a, b, c, d], depth.reversed()),
            Projection::from_field_of_view(a, b, depth),
            Projection::from_principal_distance([a, b], Point2::new(c, d), [b, a], depth),
        ]).flatten();
        for view in views {
            for convention in ALL {
                prop_assert!(view.clip_from_camera(convention).iter().all(|e| e.is_finite()));
                let _ = view.depth_from_ndc(convention, a);
            }
        }
        if let Ok(window) = Viewport::new(a, b, c, d) {
            let _ = window.window_from_clip(Vulkan, &Vector4::new(n, f, a, b));
        }
        let _ = survey::image(a, &Point3::new(b, c, d));
    }
}
