//! Cameras of glTF, beside what Blender exports and imports.

use std::fs;
use std::path::{Path, PathBuf};

use collinear::nalgebra::{Point2, Point3};
use collinear_io::Document;
use collinear_io::camera::{CameraFile, Interior};
use collinear_io::{gltf, photographs};
use proptest::prelude::*;
use serde_json::Value;

pub(crate) fn oracle(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles")).join(path)
}

pub(crate) fn json(path: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(oracle(path)).unwrap()).unwrap()
}

/// A world point's pixel, to what single precision leaves of it.
pub(crate) fn sees(camera: &CameraFile, world: &Value, image: &Value) {
    let world: [f64; 3] = serde_json::from_value(world.clone()).unwrap();
    let image: [f64; 2] = serde_json::from_value(image.clone()).unwrap();
    let found = camera.camera().unwrap().sensor().project(&Point3::from(world)).unwrap();
    assert!((found - Point2::from(image)).norm() < 5e-3, "{found} for {image:?}");
}

/// Blender 5.0.1 (`tests/oracles/blender.py --record`): a camera in a scaled hierarchy, one beside it, a parallel one.
#[test]
fn exported_cameras_see_what_blenders_do() {
    let expected = json("blender/exported.json");
    for name in ["exported.gltf", "exported.glb"] {
        let path = oracle("blender").join(name);
        let cameras = photographs::read(&path, Some([1600, 900])).unwrap();
        assert_eq!(cameras.len(), 3, "{name}");
        for (name, camera) in cameras {
            let pairs = expected["cameras"][&name].as_array().unwrap();
            assert_eq!(pairs.len(), 4);
            for pair in pairs {
                sees(&camera, &pair[0], &pair[1]);
            }
        }
        let error = photographs::read(&path, None).unwrap_err().to_string();
        assert!(error.contains("does not say how large its pictures are"), "{error}");
        let error = photographs::read(&path, Some([900, 900])).unwrap_err().to_string();
        assert!(error.contains("cameras[0].perspective.aspectRatio: is 1.77"), "{error}");
    }
}

/// Blender 5.0.1 (`--import`) sees the points of the file that is written from these photographs at the same pixels.
#[test]
fn written_cameras_see_the_same_in_blender() {
    let cameras = photographs::read(&oracle("gltf/sparse"), None).unwrap();
    let text = gltf::to_text(&cameras, 0.5, Some(100.0)).unwrap();
    let golden = fs::read_to_string(oracle("gltf/written.gltf")).unwrap();
    let (new, old): (Value, Value) =
        (serde_json::from_str(&text).unwrap(), serde_json::from_str(&golden).unwrap());
    assert_eq!(new, old);
    let imported = json("gltf/imported.json");
    for (name, camera) in cameras.iter().chain(&gltf::parse(&golden, None).unwrap()) {
        assert_eq!((camera.width, camera.height), (1280, 960));
        let pixels = imported[name]["pixels"].as_array().unwrap();
        for (world, image) in imported["points"].as_array().unwrap().iter().zip(pixels) {
            sees(camera, world, image);
        }
    }
}

fn scene(nodes: &str, camera: &str) -> String {
    format!(r#"{{ "asset": {{ "version": "2.0" }}, "nodes": [{nodes}], "cameras": [{camera}] }}"#)
}

const CAMERA: &str = r#"{ "name": "c", "type": "perspective", "perspective": { "yfov": 1.2, "znear": 1 }, "extras": { "width": 640, "height": 480 } }"#;

#[test]
fn a_matrix_is_column_after_column_and_extras_say_the_size() {
    // A quarter turn about y: the eye's −z is the world's −x.
    let node = r#"{ "camera": 0, "matrix": [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 5, 6, 7, 1] }"#;
    let (name, camera) = photographs::parse(&scene(node, CAMERA), None).unwrap().remove(0);
    assert_eq!((name.as_str(), camera.width, camera.height), ("c", 640, 480));
    assert_eq!(camera.exterior.projection_center, [5.0, 6.0, 7.0]);
    // 240/tan 0.6 = 350.8070273; 2 up, 1 to the world's +z, which is left, at depth 10.
    let image = camera.camera().unwrap().sensor().project(&Point3::new(-5.0, 8.0, 8.0)).unwrap();
    let f = 350.807_027_298_744_5;
    assert!((image - Point2::new(320.0 - 0.1 * f, 240.0 - 0.2 * f)).norm() < 1e-6, "{image}");
    let other = photographs::parse(&scene(node, CAMERA), Some([64, 48])).unwrap().remove(0).1;
    assert_eq!(other.width, 64);
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let refuses = |nodes: &str, camera: &str, expected: &str| {
        let error = photographs::parse(&scene(nodes, camera), None).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    let plain = r#"{ "camera": 0 }"#;
    refuses(r#"{ "camera": 3 }"#, CAMERA, "nodes[0].camera: names a camera `3`");
    refuses(r#"{ "children": [7] }"#, CAMERA, "nodes[0].children[0]: names a node `7`");
    refuses(
        r#"{ "children": [1, 1] }, {}"#,
        CAMERA,
        "nodes[0].children[1]: is `1`: a node has one parent",
    );
    refuses(
        r#"{ "children": [1], "camera": 0 }, { "children": [0] }"#,
        CAMERA,
        "node 0 is among its own",
    );
    refuses("{}", CAMERA, "no node of it has a camera");
    refuses(
        r#"{ "camera": 0, "scale": [1, 2, 1] }"#,
        CAMERA,
        "nodes[0].rotation_matrix: is no rotation",
    );
    refuses(r#"{ "camera": 0, "scale": [1, -1, 1] }"#, CAMERA, "nodes[0].rotation_matrix: mirrors");
    refuses(r#"{ "camera": 0, "scale": [0, 0, 0] }"#, CAMERA, "nodes[0].rotation_matrix[0]");
    refuses(
        r#"{ "camera": 0, "rotation": [0, 0, 0, 2] }"#,
        CAMERA,
        "nodes[0].rotation: has length 2",
    );
    refuses(r#"{ "camera": 0, "translation": [0, 0] }"#, CAMERA, "nodes[0].translation");
    refuses(r#"{ "camera": -1 }"#, CAMERA, "nodes[0].camera");
    refuses(plain, &CAMERA.replace("1.2", "3.2"), "cameras[0].perspective.yfov: is 3.2");
    refuses(plain, &CAMERA.replace("1.2", "0"), "cameras[0].perspective.yfov: is 0");
    refuses(
        plain,
        &CAMERA.replace("\"perspective\": {", "\"other\": {"),
        "cameras[0].type: is `neither",
    );
    refuses(plain, &CAMERA.replace("640", "-1"), "does not say how large");
    let flat = r#"{ "type": "orthographic", "orthographic": { "xmag": 0, "ymag": 1 }, "extras": { "width": 4, "height": 4 } }"#;
    refuses(plain, flat, "cameras[0].orthographic.xmag: is 0, expected a number above 0");
    let old = scene(plain, CAMERA).replace("2.0", "1.0");
    let error = photographs::parse(&old, None).unwrap_err().to_string();
    assert!(error.contains("it has version 1.0, 2.0 is read"), "{error}");
    let glb = fs::read(oracle("blender/exported.glb")).unwrap();
    let says = |bytes: &[u8], expected: &str| {
        let error = gltf::json_of_glb(bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    says(&glb[..18], "it is cut off at byte 16");
    says(&glb[..100], "is cut off");
    says(b"glTX", "it does not start with glTF");
    says(&[&glb[..4], &[1, 0, 0, 0], &glb[8..]].concat(), "it has version 1 of GLB");
    says(&[&glb[..16], b"BIN\0", &glb[20..]].concat(), "its first chunk is 0x4e4942, not JSON");
    says(&[&glb[..24], &[255], &glb[25..]].concat(), "is not UTF-8 text from byte 24 on");
}

fn photograph(interior: &str) -> Vec<(String, CameraFile)> {
    let text = format!(
        r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior} }},
        "exterior": {{ "projection_center": [1, 2, 3], "omega_phi_kappa": [0.1, 0.2, 0.3] }} }}"#
    );
    vec![("p".into(), CameraFile::parse(&text).unwrap())]
}

#[test]
fn what_gltf_does_not_have_is_not_written() {
    let refuses = |interior: &str, expected: &str| {
        let error = gltf::to_text(&photograph(interior), 0.1, None).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    let pinhole = |f: &str, c: &str| {
        format!(r#""model": "pinhole", "principal_distance": [{f}], "principal_point": [{c}]"#)
    };
    refuses(
        &pinhole("500, 500", "322.5, 239"),
        "p.interior.principal_point: lies 2.5 right of and -1 below the picture's middle, in pixels, and glTF",
    );
    refuses(
        &pinhole("500, 501", "320, 240"),
        "p.interior.principal_distance: is `500, 501`: glTF's pixels",
    );
    refuses(
        r#""model": "brown", "principal_distance": [500, 500], "principal_point": [320, 240], "k": [0.1, 0, 0]"#,
        "p.interior.model: is `brown`: a renderer's camera has no lens",
    );
    let skewed = pinhole("500, 500", "320, 240") + r#", "skew": 1"#;
    refuses(&skewed, "p.interior.model: is `pinhole`: a renderer's camera has no skew");
    let flat =
        r#""model": "orthographic", "pixels_per_unit": [80, 60], "principal_point": [320, 240]"#;
    refuses(flat, "p.interior.model: is `orthographic`: glTF's parallel projection needs");
    let text = gltf::to_text(&photograph(flat), 0.1, Some(9.0)).unwrap();
    // 640/(2 · 80) and 480/(2 · 60).
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (
            &value["cameras"][0]["orthographic"]["xmag"],
            &value["cameras"][0]["orthographic"]["ymag"]
        ),
        (&4.0.into(), &4.0.into())
    );
    let again = &gltf::parse(&text, None).unwrap()[0].1;
    assert!(matches!(again.interior, Interior::Orthographic { pixels_per_unit: [80.0, 60.0], .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damaged_files_are_refused_or_read(at in 0.0..1.0f64, byte in any::<u8>(), cut in any::<bool>()) {
        for name in ["exported.gltf", "exported.glb"] {
            let mut bytes = fs::read(oracle("blender").join(name)).unwrap();
            let at = (at * bytes.len() as f64) as usize;
            if cut { bytes.truncate(at); } else { bytes[at] = byte; }
            let text = match gltf::json_of_glb(&bytes) {
                Ok(text) => text.to_owned(),
                Err(_) => String::from_utf8_lossy(&bytes).into_owned(),
            };
            for (_, camera) in photographs::parse(&text, Some([1600, 900])).unwrap_or_default() {
                prop_assert!(camera.camera().is_ok());
            }
        }
    }
}
