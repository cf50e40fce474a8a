//! Texture matrices: Hoff's three methods, the missing q, and Segal's light coordinates.

use collinear::geometry::Pose;
use collinear::geometry::projection::texture::{
    bias, eye_linear, light_from_clip, missing_q, object_linear, object_linear_with_model,
    texture_from_clip, texture_from_light,
};
use collinear::geometry::projection::{ClipConvention, DepthRange, Projection};
use collinear::geometry::rotation::RotationVector;
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix4, Point2, Point3, Vector3, Vector4};
use proptest::prelude::*;

fn pose(r: [f64; 3], origin: [f64; 3]) -> Pose {
    let [x, y, z] = r;
    Pose::new(RotationVector { x, y, z }.rotation(), Point3::from(origin))
}

fn vector(range: f64) -> impl Strategy<Value = [f64; 3]> {
    [-range..range, -range..range, -range..range]
}

#[allow(clippy::unwrap_used, reason = "a helper of tests")]
fn texture_from_camera(fov: f64, aspect: f64) -> Matrix4<f64> {
    let depth = DepthRange::new(0.5, 100.0).unwrap();
    let view = Projection::from_field_of_view(fov, aspect, depth).unwrap();
    bias() * view.clip_from_camera(ClipConvention::OpenGl)
}

proptest! {
    #[test]
    fn hoffs_methods_1_and_3_agree_always_and_method_2_where_the_model_matrix_is_the_identity(
        fov in 0.2..2.5f64, aspect in 0.5..2.0f64,
        old in (vector(3.0), vector(20.0)), new in (vector(3.0), vector(20.0)), other in (vector(3.0), vector(20.0)),
        model in (vector(3.0), vector(10.0), vector(1.5)), shear in -0.5..0.5f64, vertex in vector(10.0),
    ) {
        let texture = texture_from_camera(fov, aspect);
        let (old, new, other) = (pose(old.0, old.1), pose(new.0, new.1), pose(other.0, other.1));
        let scale = Vector3::from(model.2).map(|s| s + 2.0 * 1f64.copysign(s));
        let mut world_from_object = pose(model.0, model.1).to_matrix() * Matrix4::new_nonuniform_scaling(&scale);
        world_from_object[(0, 1)] += shear;
        let object = Vector4::new(vertex[0], vertex[1], vertex[2], 1.0);
        let third = object_linear_with_model(&texture, &old, &world_from_object) * object;
        let size = texture.norm() * 100.0;

        // The eye coordinates of the vertex, as the modelview matrix makes them, from any new view.
        for view in [&new, &other] {
            let eye = view.to_matrix() * world_from_object * object;
            let first = eye_linear(&texture, &old, view) * eye;
            prop_assert!((first - third).amax() <= 64.0 * f64::EPSILON * size, "{first} {third}");
        }

        let second = object_linear(&texture, &old);
        prop_assert_eq!(object_linear_with_model(&texture, &old, &Matrix4::identity()), second);
        let eye = new.to_matrix() * object;
        let first = eye_linear(&texture, &old, &new) * eye;
        prop_assert!((first - second * object).amax() <= 64.0 * f64::EPSILON * size);
        // A model matrix that moves the vertex makes method 2 wrong by that much.
        let moved = world_from_object * object - object;
        prop_assert!((second * object + second * moved - third).amax() <= 64.0 * f64::EPSILON * size);
        prop_assume!(moved.norm() > 1.0);
        prop_assert!((second * object - third).norm() > 1e-3);
    }

    // [S] eq. 5 against both matrices applied to the world.
    #[test]
    fn light_coordinates_from_clip_are_those_from_the_world(
        viewer in (vector(3.0), vector(20.0)), light in (vector(3.0), vector(20.0)), fov in 0.3..2.5f64,
        world in vector(30.0), reversed in any::<bool>(), parallel in any::<bool>(),
    ) {
        let mut depth = DepthRange::new(0.5, 100.0).unwrap();
        if reversed {
            depth = depth.reversed();
        }
        let eye = Projection::from_field_of_view(fov, 1.5, depth).unwrap();
        let slide = if parallel {
            Projection::orthographic([-5.0, 5.0, -5.0, 5.0], depth).unwrap()
        } else {
            Projection::from_field_of_view(0.7, 1.0, depth).unwrap()
        };
        let clip_from_world = eye.clip_from_camera(ClipConvention::Wgpu) * pose(viewer.0, viewer.1).to_matrix();
        let light_from_world = slide.clip_from_camera(ClipConvention::Vulkan) * pose(light.0, light.1).to_matrix();
        let m = light_from_clip(&light_from_world, &clip_from_world).unwrap();
        let world = Point3::from(world).to_homogeneous();
        let (direct, by_clip) = (light_from_world * world, m * (clip_from_world * world));
        // far/near = 200 is what the inverse may cost.
        prop_assert!((direct - by_clip).amax() <= 200.0 * 64.0 * f64::EPSILON * 100.0, "{direct} {by_clip}");
        match texture_from_light(&by_clip) {
            Ok(texture) => {
                prop_assert!(by_clip.w > 0.0);
                prop_assert!((texture.x * by_clip.w - by_clip.x).abs() <= 1e-12 * by_clip.x.abs());
            }
            Err(error) => prop_assert_eq!(error, ProjectionError::BehindCamera { depth: by_clip.w }),
        }
    }

    #[test]
    fn any_number_makes_texture_coordinates_or_an_error(e in prop::array::uniform16(any::<f64>()), s in any::<f64>(), w in any::<f64>()) {
        let m = Matrix4::from_row_slice(&e);
        if let Ok(m) = light_from_clip(&Matrix4::identity(), &m) {
            prop_assert!(m.iter().all(|e| e.is_finite()));
        }
        if let Ok(q) = missing_q(&Point2::new(s, e[0]), w) {
            prop_assert!(q.z > 0.0 && q.iter().all(|c| c.is_finite()));
        }
        if let Ok(t) = texture_from_light(&m.column(0).into_owned()) {
            prop_assert!(t.coords.iter().all(|c| c.is_finite()));
        }
    }
}

// A wall seen by an old camera and by a new one. Screen points between two vertices of the wall are followed by hand: the ray
// from the new eye, where it meets the wall, and that point in the old image.
#[test]
fn interpolated_with_the_missing_q_a_photograph_follows_its_rays() {
    // Pinholes x = 500 X/Z, both with world axes; the old one at the origin, the new one at (4, −1, −2), turned about y so that
    // its axis has direction (−0.6, 0, 0.8).
    let wall = |x: f64| Vector3::new(x, 0.5 * x - 1.0, 8.0 + 1.5 * x);
    let (a, b) = (wall(-3.0), wall(4.0));
    let eye = Vector3::new(4.0, -1.0, -2.0);
    let (right, forward) = (Vector3::new(0.8, 0.0, 0.6), Vector3::new(-0.6, 0.0, 0.8));
    let new_image = |p: Vector3<f64>| {
        let d = p - eye;
        (500.0 * d.dot(&right) / d.dot(&forward), 500.0 * d.y / d.dot(&forward), d.dot(&forward))
    };
    let old_image = |p: Vector3<f64>| Point2::new(500.0 * p.x / p.z, 500.0 * p.y / p.z);

    let (xa, ya, wa) = new_image(a);
    let (xb, yb, wb) = new_image(b);
    let (ta, tb) = (old_image(a), old_image(b));
    let (qa, qb) = (missing_q(&ta, a.z).unwrap(), missing_q(&tb, b.z).unwrap());
    assert!((qa - Vector3::new(500.0 * a.x, 500.0 * a.y, a.z)).amax() < 1e-12);

    let (mut linear, mut without_q, mut with_q, mut inverse_q) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for k in 1..16 {
        let t = f64::from(k) / 16.0;
        let (x, y) = (xa + t * (xb - xa), ya + t * (yb - ya));
        // The ray meets the line a b in space: least squares of two lines that meet.
        let ray = right * (x / 500.0) + Vector3::y() * (y / 500.0) + forward;
        let along = b - a;
        let normal = along.cross(&ray);
        let s = (eye - a).cross(&ray).dot(&normal) / normal.norm_squared();
        let hit = a + along * s;
        assert!((hit - eye).cross(&ray).norm() < 1e-12 * (hit - eye).norm() * ray.norm() * 10.0);
        let truth = old_image(hit);

        let mix = |p: f64, q: f64| p + t * (q - p);
        let plain = Point2::new(mix(ta.x, tb.x), mix(ta.y, tb.y));
        linear = linear.max((plain - truth).norm());
        // Hyperbolic, by the new w alone: (s/w, t/w, 1/w).
        let one = mix(1.0 / wa, 1.0 / wb);
        let plain = Point2::new(mix(ta.x / wa, tb.x / wb) / one, mix(ta.y / wa, tb.y / wb) / one);
        without_q = without_q.max((plain - truth).norm());
        // (s q/w, t q/w, q/w).
        let full = qa / wa * (1.0 - t) + qb / wb * t;
        with_q = with_q.max((Point2::new(full.x / full.z, full.y / full.z) - truth).norm());
        // q = 1/w, the other reading.
        let wrong = Vector3::new(ta.x, ta.y, 1.0) / (a.z * wa) * (1.0 - t)
            + Vector3::new(tb.x, tb.y, 1.0) / (b.z * wb) * t;
        inverse_q =
            inverse_q.max((Point2::new(wrong.x / wrong.z, wrong.y / wrong.z) - truth).norm());
    }
    assert!(with_q < 1e-11, "{with_q}");
    assert!(linear > 5.0 && without_q > 5.0 && inverse_q > 5.0, "{linear} {without_q} {inverse_q}");
}

// The texture's corners are the view's: \[H\]'s with t up, the image's with t down, for every convention.
#[test]
fn the_half_matrices_cover_the_picture() {
    let depth = DepthRange::new(1.0, 9.0).unwrap();
    let view = Projection::from_principal_distance(
        [100.0, 100.0],
        Point2::new(30.0, 20.0),
        [80.0, 50.0],
        depth,
    )
    .unwrap();
    // Images at (30 + 10, 20 + 5) = (40, 25): the middle of both sides.
    let middle = Vector4::new(0.4, 0.2, 4.0, 1.0);
    // Images at (10, 45).
    let lower_left = Vector4::new(-0.8, 1.0, 4.0, 1.0);
    for convention in [
        ClipConvention::OpenGl,
        ClipConvention::Direct3d,
        ClipConvention::Vulkan,
        ClipConvention::Wgpu,
    ] {
        let m = texture_from_clip(convention) * view.clip_from_camera(convention);
        let t = texture_from_light(&(m * middle)).unwrap();
        assert!((t.x - 0.5).abs() < 1e-15 && (t.y - 0.5).abs() < 1e-15);
        let t = texture_from_light(&(m * lower_left)).unwrap();
        assert!((t.x - 10.0 / 80.0).abs() < 1e-15 && (t.y - 45.0 / 50.0).abs() < 1e-15);
        for (z, r) in [(1.0, 0.0), (9.0, 1.0)] {
            let t = texture_from_light(&(m * Vector4::new(0.0, 0.0, z, 1.0))).unwrap();
            assert!((t.z - r).abs() < 1e-15, "{convention:?}");
        }
    }
    let t =
        texture_from_light(&(bias() * view.clip_from_camera(ClipConvention::OpenGl) * lower_left))
            .unwrap();
    assert!((t.x - 10.0 / 80.0).abs() < 1e-15 && (t.y - (1.0 - 45.0 / 50.0)).abs() < 1e-15);
}

// In map coordinates of 10⁶ m method 1 keeps 10⁻⁹ of a picture's width, since the two poses are combined first.
#[test]
fn eye_linear_keeps_its_digits_in_map_coordinates() {
    let texture = texture_from_camera(1.0, 1.0);
    let far = [654_321.25, 5_123_456.5, 812.75];
    let near = [10.0, -20.0, 3.0];
    let (r_old, r_new) = ([0.1, 2.9, 0.2], [0.3, 2.7, -0.1]);
    let shift = |p: [f64; 3], q: [f64; 3]| [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
    let at = |origin: [f64; 3]| {
        let (old, new) = (pose(r_old, origin), pose(r_new, shift(origin, near)));
        let vertex = Point3::from(shift(origin, [3.0, 1.0, -40.0]));
        let eye = new.apply(&vertex);
        texture_from_light(&(eye_linear(&texture, &old, &new) * eye.to_homogeneous())).unwrap()
    };
    assert!((at(far) - at([0.0; 3])).amax() < 1e-14);
}

#[test]
fn what_has_no_texture_coordinates_is_refused() {
    let behind = Vector4::new(1.0, 1.0, 1.0, -0.5);
    assert_eq!(texture_from_light(&behind), Err(ProjectionError::BehindCamera { depth: -0.5 }));
    assert!(texture_from_light(&Vector4::zeros()).is_err());
    assert_eq!(
        missing_q(&Point2::new(0.5, 0.5), 0.0),
        Err(ProjectionError::BehindCamera { depth: 0.0 })
    );
    assert_eq!(missing_q(&Point2::new(f64::NAN, 0.5), 1.0), Err(ProjectionError::NotFinite));
    let flat = Matrix4::from_diagonal(&Vector4::new(1.0, 1.0, 0.0, 1.0));
    assert!(matches!(
        light_from_clip(&Matrix4::identity(), &flat),
        Err(Error::Degenerate { what: "clip_from_world", .. })
    ));
    let mut dependent = Matrix4::identity();
    dependent.set_row(3, &(dependent.row(0) + dependent.row(1)));
    match light_from_clip(&Matrix4::identity(), &dependent) {
        Err(Error::Degenerate { measure, limit, .. }) => assert!(measure <= limit),
        other => panic!("{other:?}"),
    }
    // Rows of very different size are no degeneracy.
    let scaled = Matrix4::from_diagonal(&Vector4::new(1e-100, 1.0, 1e100, 1e-50));
    let m = light_from_clip(&Matrix4::identity(), &scaled).unwrap();
    assert!((m[(0, 0)] / 1e100 - 1.0).abs() < 1e-15);
    assert!((m[(2, 2)] / 1e-100 - 1.0).abs() < 1e-15);
    let nan = Matrix4::from_element(f64::NAN);
    assert!(matches!(light_from_clip(&nan, &scaled), Err(Error::NotFinite { .. })));
}
