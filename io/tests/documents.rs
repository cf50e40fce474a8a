//! Cameras, planes and maps: what they refuse, in which words, and what they keep.

use collinear::camera::Panorama;
use collinear::nalgebra::Point3;
use collinear_io::camera::{CameraFile, Exterior, FisheyeProjection, Interior, Lens, Rotation};
use collinear_io::map::MapFile;
use collinear_io::plane::{PlaneFile, Rectangle};
use collinear_io::{Document, ErrorKind, FieldProblem};
use proptest::prelude::*;

const CAMERA: &str = r#"{
  "collinear": "camera", "version": 1, "width": 640, "height": 480,
  "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 240] },
  "exterior": { "projection_center": [1, 2, 3], "quaternion_wxyz": [1, 0, 0, 0] }
}"#;

fn camera_error(from: &str, to: &str) -> String {
    assert!(CAMERA.contains(from), "{from} is not in the template");
    CameraFile::parse(&CAMERA.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn an_error_names_the_field_and_what_was_expected_there() {
    for (from, to, expected) in [
        (
            "[500, 500]",
            "[500, \"x\"]",
            "interior.principal_distance[1]: expected a number, found the string \"x\" (line 3, column 67)",
        ),
        (
            "[500, 500]",
            "[500]",
            "interior.principal_distance: expected a list of 2, found 1 entries (line 3, column 63)",
        ),
        (
            "[500, 500]",
            "[500, 500, 500]",
            "interior.principal_distance: has more entries than expected (line 3, column 70)",
        ),
        (
            "[1, 2, 3]",
            "[1, null, 3]",
            "exterior.projection_center[1]: expected a number, found null (line 4, column 45)",
        ),
        ("640", "640.5", "width: expected a whole number from 0, found 640.5 (line 2, column 53)"),
        ("640", "1e300", "width: expected a whole number from 0, found 1e300 (line 2, column 53)"),
        ("640", "-1", "width: expected a whole number from 0, found -1 (line 2, column 50)"),
        ("\"height\": 480,", "", "missing field `height` (line 5, column 1)"),
        (
            "\"height\"",
            "\"hieght\"",
            "hieght: unknown field, did you mean `height`? (line 2, column 61)",
        ),
        (
            "\"height\"",
            "\"lens\"",
            "lens: unknown field, remove it: the fields here are `width`, `height`, `interior`, `exterior` (line 2, column 59)",
        ),
        ("\"height\"", "\"width\"", "duplicate field `width` (line 2, column 60)"),
        (
            "{ \"projection_center\": [1, 2, 3], \"quaternion_wxyz\": [1, 0, 0, 0] }",
            "[[1, 2, 3], [1, 0, 0, 0]]",
            "exterior: expected an object, found a list (line 4, column 14)",
        ),
        (
            "pinhole",
            "brwon",
            "interior.model: expected one of `pinhole`, `brown`, `rational`, `metashape`, `fraser`, `fisheye`, `thin_prism_fisheye`, `fisheye624`, `field_of_view`, `division`, `unified`, `enhanced_unified`, `double_sphere`, `equirectangular`, `cylindrical`, `film`, `colmap`, `orthographic`, found `brwon` (line 3, column 32)",
        ),
    ] {
        assert_eq!(camera_error(from, to), expected);
    }
}

#[test]
fn an_interior_has_the_fields_of_its_model_and_no_others() {
    for (from, to, expected) in [
        (
            "\"pinhole\",",
            "\"pinhole\", \"k\": [0, 0, 0],",
            "interior: the model `pinhole` has no `k`: remove it or change the model",
        ),
        (
            "\"pinhole\"",
            "\"orthographic\"",
            "interior: the model `orthographic` has no `principal_distance`",
        ),
        (
            "\"principal_distance\": [500, 500],",
            "",
            "interior: the model `pinhole` needs `principal_distance`",
        ),
        (
            "principal_distance",
            "pixels_per_unit",
            "interior: the model `pinhole` has no `pixels_per_unit`",
        ),
    ] {
        let error = camera_error(from, to);
        assert!(error.starts_with(expected), "{error}");
    }
}

#[test]
fn an_exterior_has_exactly_one_rotation() {
    let none = camera_error(", \"quaternion_wxyz\": [1, 0, 0, 0]", "");
    assert!(none.starts_with("exterior: has 0 rotations: give exactly one of"), "{none}");
    let two =
        camera_error("\"quaternion_wxyz\"", "\"omega_phi_kappa\": [0, 0, 0], \"quaternion_wxyz\"");
    assert!(two.starts_with("exterior: has 2 rotations: give exactly one of"), "{two}");
}

#[test]
fn values_outside_their_domain_are_refused_with_the_number() {
    for (from, to, expected) in [
        ("640", "0", "width: is 0, expected at least 1 pixel"),
        (
            "[500, 500]",
            "[500, 0]",
            "interior.principal_distance[1]: is 0, expected a number from 1e-6 to 1e9 (pixels)",
        ),
        (
            "[500, 500]",
            "[1e308, 1e308]",
            "interior.principal_distance[0]: is 1e308, expected a number from 1e-6 to 1e9 (pixels)",
        ),
        (
            "[500, 500]",
            "[500, 1e-7]",
            "interior.principal_distance[1]: is 1e-7, expected a number from 1e-6 to 1e9 (pixels)",
        ),
        (
            "[320, 240]",
            "[320, -1.5e9]",
            "interior.principal_point[1]: is -1.5e9, expected a number from -1e9 to 1e9 (pixels)",
        ),
        (
            "[320, 240]",
            "[320, 240], \"skew\": 1e300",
            "interior.skew: is 1e300, expected a number from -1e9 to 1e9",
        ),
        (
            "[1, 0, 0, 0]",
            "[1, 0, 0, 1]",
            "exterior.quaternion_wxyz: has length 1.41421, expected 1 within 0.001",
        ),
    ] {
        assert_eq!(camera_error(from, to), expected);
    }
    let matrix = |rows: &str| {
        camera_error("\"quaternion_wxyz\": [1, 0, 0, 0]", &format!("\"rotation_matrix\": {rows}"))
    };
    assert_eq!(
        matrix("[[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
        "exterior.rotation_matrix: mirrors: its determinant is −1, exchange an axis or its sign"
    );
    assert_eq!(
        matrix("[[1, 0, 0], [0, 1, 0], [0, 0.5, 1]]"),
        "exterior.rotation_matrix: is no rotation: rows of unit length at right angles are needed, R Rᵀ is off by 0.5"
    );
    assert!(
        matrix("[[1e200, 0, 0], [1e200, 1e200, 0], [-1e200, 1e200, 1]]").contains("is no rotation")
    );
    assert!(camera_error("[1, 2, 3]", "[1e999, 2, 3]").contains("number out of range"));
}

#[test]
fn a_file_of_another_kind_or_version_says_what_to_do() {
    assert_eq!(
        camera_error("\"version\": 1", "\"version\": 2"),
        "has version 2 of the camera format, this program reads version 1: update collinear, or write the file in version 1 (docs/formats.md)"
    );
    assert_eq!(
        camera_error("\"camera\"", "\"plane\""),
        "is a collinear plane file, a camera file is needed here"
    );
    assert!(camera_error("\"collinear\": \"camera\", ", "").starts_with("is not a collinear camera file: such a file starts {\"collinear\": \"camera\", \"version\": 1, "));
    assert!(camera_error("\"version\": 1,", "").starts_with("is not a collinear camera file"));
    assert!(
        CameraFile::parse("[]")
            .unwrap_err()
            .to_string()
            .starts_with("expected an object, found a list")
    );
    assert!(CameraFile::parse("").unwrap_err().to_string().starts_with("EOF while parsing"));
    assert!(
        CameraFile::parse(&format!("{CAMERA} x"))
            .unwrap_err()
            .to_string()
            .starts_with("trailing characters (line 5")
    );
}

#[test]
fn files_are_named_in_their_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.json");
    let missing = CameraFile::read(&path).unwrap_err();
    assert_eq!(missing.path(), Some(path.as_path()));
    assert!(matches!(missing.kind(), ErrorKind::Read(_)));
    assert!(missing.to_string().contains("c.json: cannot be read: "), "{missing}");
    std::fs::write(&path, b"{\"a\": \"\xff\"}").unwrap();
    let binary = CameraFile::read(&path).unwrap_err();
    assert!(matches!(binary.kind(), ErrorKind::NotText { valid_up_to: 7 }), "{binary}");
    std::fs::write(&path, format!("\u{feff}{CAMERA}")).unwrap();
    assert_eq!(CameraFile::read(&path).unwrap(), CameraFile::parse(CAMERA).unwrap());
    assert!(matches!(CameraFile::read(folder.path()).unwrap_err().kind(), ErrorKind::Read(_)));
}

#[test]
fn the_header_may_stand_anywhere_and_a_written_file_starts_with_it() {
    let camera = CameraFile::parse(CAMERA).unwrap();
    let moved = CAMERA.replacen("\"collinear\": \"camera\", \"version\": 1, ", "", 1).replacen(
        "\n}",
        ",\n\"version\": 1, \"collinear\": \"camera\"}",
        1,
    );
    assert_eq!(CameraFile::parse(&moved).unwrap(), camera);
    assert_eq!(
        camera.to_json().unwrap(),
        r#"{
  "collinear": "camera",
  "version": 1,
  "width": 640,
  "height": 480,
  "interior": {
    "model": "pinhole",
    "principal_distance": [500.0, 500.0],
    "principal_point": [320.0, 240.0]
  },
  "exterior": {
    "projection_center": [1.0, 2.0, 3.0],
    "quaternion_wxyz": [1.0, 0.0, 0.0, 0.0]
  }
}
"#
    );
}

#[test]
fn what_could_not_be_read_is_not_written() {
    let mut camera = CameraFile::parse(CAMERA).unwrap();
    camera.exterior.projection_center[2] = f64::NAN;
    let error = camera.to_json().unwrap_err();
    assert_eq!(
        error.to_string(),
        "exterior.projection_center[2]: is NaN, expected a finite number"
    );
}

#[test]
fn a_picture_of_another_size_is_refused() {
    let camera = CameraFile::parse(CAMERA).unwrap();
    camera.check_picture_size(640, 480).unwrap();
    let error = camera.check_picture_size(480, 640).unwrap_err();
    assert!(
        error.to_string().starts_with("is 480 × 640 pixels, its camera says 640 × 480"),
        "{error}"
    );
}

fn plane(fields: &str) -> Result<PlaneFile, collinear_io::Error> {
    PlaneFile::parse(&format!(
        r#"{{"collinear": "plane", "version": 1, "point": [1, 2, 3], {fields}}}"#
    ))
}

#[test]
fn up_on_a_plane_is_up_in_the_world_or_north_on_a_floor() {
    for (fields, right, up) in [
        // A wall facing south: east is right.
        (r#""normal": [0, -1, 0]"#, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
        // A wall facing west: south is right.
        (r#""normal": [-2, 0, 0]"#, [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]),
        // A roof at 45° facing south.
        (r#""normal": [0, -1, 1]"#, [1.0, 0.0, 0.0], [0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]),
        // A floor seen from above, a ceiling seen from below.
        (r#""normal": [0, 0, 5]"#, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        (r#""normal": [0, 0, -5]"#, [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        (r#""normal": [0, 0, 1], "up": [1, 0, 7]"#, [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        (r#""normal": [0, 1e200, 0], "up": [0, 0, 1e-200]"#, [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
    ] {
        let axes = plane(fields).unwrap().axes().unwrap();
        for (got, expected) in axes.right.iter().zip(right).chain(axes.up.iter().zip(up)) {
            assert!((got - expected).abs() < 1e-15, "{fields}: {axes:?}");
        }
    }
}

#[test]
fn a_plane_without_a_direction_is_refused() {
    for (fields, expected) in [
        (r#""normal": [0, 0, 0]"#, "normal: has length 0, expected a finite length above 0"),
        (
            r#""normal": [0, 1, 0], "up": [0, 0, 0]"#,
            "up: has length 0, expected a finite length above 0",
        ),
        (
            r#""normal": [0, 1, 0], "up": [0, -3, 1e-9]"#,
            "up: is parallel to the normal: give a direction that lies more along the plane",
        ),
        (
            r#""normal": [0, 1, 0], "rectangle": {"left": 1, "bottom": 0, "right": 1, "top": 2}"#,
            "rectangle.right: is 1, expected a finite number above left",
        ),
        (
            r#""normal": [0, 1, 0], "rectangle": {"left": 1, "bottom": 0, "right": 2, "top": -2}"#,
            "rectangle.top: is -2, expected a finite number above bottom",
        ),
    ] {
        assert_eq!(plane(fields).unwrap_err().to_string(), expected);
    }
}

#[test]
fn maps_have_as_many_coefficients_as_their_kind() {
    let map = |fields: &str| {
        MapFile::parse(&format!(r#"{{"collinear": "map", "version": 1, {fields}}}"#))
    };
    let homography =
        map(r#""kind": "homography", "matrix": [[0, 0, 1], [0, 1, 0], [1, 0, 0]]"#).unwrap();
    assert_eq!(
        homography,
        MapFile::Homography { matrix: [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] }
    );
    for (kind, n) in [("affine", 3), ("bilinear", 4), ("quadratic", 6), ("cubic", 10)] {
        let list = |n: usize| format!("{:?}", vec![0.5; n]);
        map(&format!(r#""kind": "{kind}", "a": {}, "b": {}"#, list(n), list(n))).unwrap();
        let error = map(&format!(r#""kind": "{kind}", "a": {}, "b": {}"#, list(n), list(n - 1)))
            .unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with(&format!("`b` has {} coefficients, this kind has {n}", n - 1)),
            "{error}"
        );
        assert!(map(&format!(r#""kind": "{kind}", "a": {}"#, list(n))).is_err());
    }
    for (fields, expected) in [
        (
            r#""kind": "homography", "matrix": [[1, 2, 3], [2, 4, 6], [0, 0, 1]]"#,
            "matrix: has no inverse: its determinant is 0 after scaling to entries of one",
        ),
        (
            r#""kind": "homography", "matrix": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]"#,
            "matrix: has no inverse: its determinant is 0 after scaling to entries of one",
        ),
    ] {
        assert_eq!(map(fields).unwrap_err().to_string(), expected);
    }
    assert!(map(r#""kind": "homography", "a": [1, 2, 3], "b": [1, 2, 3]"#).is_err());
    let error = map(r#""kind": "affine", "a": [1, 2, "3"], "b": [1, 2, 3]"#).unwrap_err();
    assert!(
        error.to_string().starts_with("a[2]: expected a number, found the string \"3\""),
        "{error}"
    );
}

/// Finite numbers of every size.
fn any_finite() -> impl Strategy<Value = f64> {
    prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO
}

fn interiors() -> impl Strategy<Value = Interior> {
    let distance = (-6.0..9.0).prop_map(|e| 10.0_f64.powf(e));
    let pixel = || -1e9..1e9;
    let numbers = (prop::array::uniform2(distance), prop::array::uniform2(pixel()), pixel());
    let lens = (prop::array::uniform3(any_finite()), prop::array::uniform2(any_finite()));
    (0..6, numbers, lens, lenses()).prop_map(
        |(model, (scale, principal_point, skew), (k, p), lens)| match model {
            0 => Interior::Pinhole { principal_distance: scale, principal_point, skew },
            1 => Interior::Brown { principal_distance: scale, principal_point, skew, k, p },
            2 => Interior::Panorama {
                projection: if skew > 0.0 {
                    Panorama::Equirectangular
                } else {
                    Panorama::Cylindrical
                },
                principal_distance: Some(scale).filter(|_| k[0] > 0.0),
                principal_point: Some(principal_point).filter(|_| k[1] > 0.0),
            },
            3 => Interior::Colmap {
                model: "RADIAL".into(),
                parameters: vec![scale[0], principal_point[0], principal_point[1], p[0], p[1]],
            },
            4 => Interior::Orthographic { pixels_per_unit: scale, principal_point },
            _ => Interior::Lens {
                principal_distance: scale,
                principal_point,
                skew,
                lens: Box::new(lens),
            },
        },
    )
}

fn lenses() -> impl Strategy<Value = Lens> {
    let projection = prop::sample::select(vec![
        FisheyeProjection::Equidistant,
        FisheyeProjection::Stereographic,
        FisheyeProjection::Equisolid,
        FisheyeProjection::Orthographic,
    ]);
    let millimetres = prop::option::of(1e-6..1e9);
    (0..11, prop::array::uniform16(any_finite()), projection, millimetres).prop_map(
        |(model, v, projection, principal_distance_mm)| {
            let ([xi, alpha, beta, ..], [omega, lambda, ..]) = (v, v);
            let k = [v[0], v[1], v[2]];
            let (k4, k6) = ([v[0], v[1], v[2], v[3]], [v[0], v[1], v[2], v[3], v[4], v[5]]);
            let (p, s, s2, tau) =
                ([v[6], v[7]], [v[8], v[9], v[10], v[11]], [v[8], v[9]], [v[12], v[13]]);
            match model {
                0 => Lens::Rational { k: k6, p, s, tau },
                1 => Lens::Metashape { k: k4, p: s },
                2 => Lens::Fraser { k, p, b: tau, principal_distance_mm },
                3 => Lens::Fisheye { projection, k: k4 },
                4 => Lens::ThinPrismFisheye { k: k4, p, s: s2 },
                5 => Lens::Fisheye624 { k: k6, p, s },
                6 => Lens::FieldOfView { omega },
                7 => Lens::Division { lambda },
                8 => Lens::Unified { xi, k, p },
                9 => Lens::EnhancedUnified { alpha, beta },
                _ => Lens::DoubleSphere { xi, alpha },
            }
        },
    )
}

fn rotations() -> impl Strategy<Value = Rotation> {
    (0..3, prop::array::uniform4(-1.0..1.0)).prop_filter_map("no direction", |(form, q)| {
        let n = q.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
        let q = q.map(|c| c / n);
        (n > 0.1).then(|| match form {
            0 => Rotation::QuaternionWxyz(q),
            1 => Rotation::OmegaPhiKappa([q[0], q[1], q[2]]),
            _ => {
                let (s, c) = (q[0] * 3.0).sin_cos();
                Rotation::RotationMatrix([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            }
        })
    })
}

proptest! {
    #[test]
    fn a_camera_survives_its_file_to_the_last_bit(
        width in 1..u32::MAX, height in 1..u32::MAX, interior in interiors(), rotation in rotations(),
        projection_center in prop::array::uniform3(any_finite()),
    ) {
        let camera = CameraFile { width, height, interior, exterior: Exterior { projection_center, rotation } };
        // What the library makes of it is its own matter, but it says so.
        drop(camera.camera().map(|c| c.sensor().project(&Point3::new(1.0, 2.0, 3.0))));
        prop_assert_eq!(CameraFile::parse(&camera.to_json().unwrap()).unwrap(), camera);
    }

    #[test]
    fn a_map_survives_its_file_to_the_last_bit(a in prop::array::uniform10(any_finite()), b in prop::array::uniform10(any_finite())) {
        let map = MapFile::Cubic { a, b };
        prop_assert_eq!(MapFile::parse(&map.to_json().unwrap()).unwrap(), map);
    }

    #[test]
    fn the_axes_of_a_plane_are_right_handed_and_orthonormal_and_up_never_points_down(
        normal in prop::array::uniform3(-1.0..1.0), up in prop::option::of(prop::array::uniform3(-1.0..1.0)),
        scale in -200..200, point in prop::array::uniform3(-1e6..1e6), a in -100.0..100.0, b in -100.0..100.0,
    ) {
        let scale = 10.0_f64.powi(scale);
        let rectangle = Some(Rectangle { left: -1.0, bottom: -1.0, right: 1.0, top: 1.0 });
        let plane = PlaneFile { point, normal: normal.map(|c: f64| c * scale), up, rectangle };
        match plane.axes() {
            Ok(axes) => {
                let dot = |u: &[f64; 3], v: &[f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
                for (u, v, expected) in [
                    (axes.right, axes.right, 1.0), (axes.up, axes.up, 1.0), (axes.normal, axes.normal, 1.0),
                    (axes.right, axes.up, 0.0), (axes.right, axes.normal, 0.0), (axes.up, axes.normal, 0.0),
                ] {
                    prop_assert!((dot(&u, &v) - expected).abs() < 1e-12);
                }
                let [r, u, n] = [axes.right, axes.up, axes.normal];
                let determinant = r[0] * (u[1] * n[2] - u[2] * n[1]) + r[1] * (u[2] * n[0] - u[0] * n[2]) + r[2] * (u[0] * n[1] - u[1] * n[0]);
                prop_assert!((determinant - 1.0).abs() < 1e-12);
                prop_assert!(dot(&axes.normal, &normal) > 0.0);
                let given = up.unwrap_or([0.0, if n[0].hypot(n[1]) < 0.0174 { 1.0 } else { 0.0 }, 1.0]);
                prop_assert!(dot(&axes.up, &given) > -1e-12);
                let world = plane.world_from_plane(a, b).unwrap();
                let [x, y] = plane.plane_from_world(&world).unwrap();
                prop_assert!((x - a).abs() < 1e-8 && (y - b).abs() < 1e-8);
                prop_assert_eq!(PlaneFile::parse(&plane.to_json().unwrap()).unwrap(), plane);
            }
            Err(e) => {
                let known = matches!(e.problem, FieldProblem::ParallelToNormal | FieldProblem::Length { .. });
                prop_assert!(known, "{}", e);
            }
        }
    }
}
