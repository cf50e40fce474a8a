//! `transforms.json`, beside COLMAP's and Blender's cameras of the same photographs.

use collinear_io::camera::CameraFile;
use collinear_io::{Document, nerf, photographs};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::gltf::{json as read, oracle, sees};

/// The matrix from eye axes to the world's is Blender's `matrix_world`; its pixels are Blender 5.0.1's (`blender.py --record`).
#[test]
fn frames_see_what_blenders_cameras_do() {
    let cases = read("blender/cameras.json");
    let case = &cases["cases"][2];
    let camera = &case["camera"];
    // Horizontal fit: fx = lens W/sensor; the shift up of 0.25 W is 480 pixels.
    let f = 28.0 * 1920.0 / 23.5;
    let text = json!({ "w": 1920.0, "h": 1080.0, "fl_x": f, "cx": 960.0, "cy": 540.0 + 480.0,
        "frames": [{ "file_path": "c.png", "transform_matrix": camera["matrix_world"] }] });
    let (name, file) = photographs::parse(&text.to_string(), None).unwrap().remove(0);
    assert_eq!((name.as_str(), file.width, file.height), ("c.png", 1920, 1080));
    for pair in case["pixels"].as_array().unwrap() {
        sees(&file, &pair[0], &pair[1]);
    }
}

/// pycolmap 4.2.1's pixels (`tests/oracles/colmap.py`) of the cameras that both have.
#[test]
fn colmaps_cameras_survive() {
    let expected = read("colmap/expected.json");
    let mut count = 0;
    for (name, camera) in photographs::read(&oracle("colmap/text"), None).unwrap() {
        let Ok(text) = nerf::to_text(&[(name.clone(), camera.clone())]) else { continue };
        let (same, again) = photographs::parse(&text, None).unwrap().remove(0);
        assert_eq!(same, name);
        for pair in expected["images"][&name].as_array().unwrap() {
            sees(&again, &pair[0], &pair[1]);
        }
        count += 1;
    }
    assert!(count >= 2, "{count}");
}

fn photograph(interior: &str) -> (String, CameraFile) {
    let text = format!(
        r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior},
        "principal_distance": [500, 510], "principal_point": [322, 239] }},
        "exterior": {{ "projection_center": [1, 2, 3], "omega_phi_kappa": [0, 0, 0] }} }}"#
    );
    ("p.jpg".into(), CameraFile::parse(&text).unwrap())
}

/// A vertical photograph's eye axes are the world's.
#[test]
fn shared_numbers_stand_above_the_frames() {
    let brown = photograph(r#""model": "brown", "k": [0.1, 0.2, 0.3], "p": [0.4, 0.5]"#);
    let value = |photographs: &[_]| -> Value {
        serde_json::from_str(&nerf::to_text(photographs).unwrap()).unwrap()
    };
    let one = value(&[brown.clone(), brown.clone()]);
    let numbers = ["fl_x", "fl_y", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2", "w", "h"];
    let found: Vec<f64> = numbers.iter().map(|n| one[n].as_f64().unwrap()).collect();
    assert_eq!(found, [500.0, 510.0, 322.0, 239.0, 0.1, 0.2, 0.3, 0.0, 0.4, 0.5, 640.0, 480.0]);
    let matrix = json!([
        [1.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 2.0],
        [0.0, 0.0, 1.0, 3.0],
        [0.0, 0.0, 0.0, 1.0]
    ]);
    assert_eq!(
        (&one["camera_model"], &one["frames"][0]["transform_matrix"]),
        (&"OPENCV".into(), &matrix)
    );
    assert!(one["frames"][0]["fl_x"].is_null());
    let pinhole = photograph(r#""model": "pinhole""#);
    let two = value(&[brown.clone(), pinhole]);
    assert!(
        two["fl_x"].is_null()
            && two["frames"][0]["k1"] == json!(0.1)
            && two["frames"][1]["k1"] == json!(0.0)
    );
    assert_eq!(nerf::parse(&two.to_string(), None).unwrap()[0].1.interior, brown.1.interior);
    let fisheye = photograph(r#""model": "fisheye", "k": [0.1, 0.2, 0.3, 0.4]"#);
    let round = value(std::slice::from_ref(&fisheye));
    assert_eq!((&round["camera_model"], &round["k4"]), (&"OPENCV_FISHEYE".into(), &json!(0.4)));
    assert_eq!(nerf::parse(&round.to_string(), None).unwrap()[0].1.interior, fisheye.1.interior);
    let error = nerf::to_text(&[brown, fisheye]).unwrap_err().to_string();
    assert!(
        error.contains("p.jpg.interior.model: is `fisheye`: transforms.json has one"),
        "{error}"
    );
    let sphere = photograph(r#""model": "double_sphere", "xi": 0.1, "alpha": 0.5"#);
    let error = nerf::to_text(&[sphere]).unwrap_err().to_string();
    assert!(error.contains("p.jpg.interior.model: is `double_sphere`"), "{error}");
}

const GOOD: &str = r#"{ "camera_model": "OPENCV", "w": 640, "h": 480, "fl_x": 500, "k1": 0.1, "frames": [{ "file_path": "a",
    "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]] }] }"#;

#[test]
fn bad_files_are_refused_with_their_place() {
    let refuses = |from: &str, to: &str, expected: &str| {
        assert!(GOOD.contains(from));
        let error = photographs::parse(&GOOD.replace(from, to), None).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    refuses("OPENCV", "FLAT", "camera_model: is `FLAT`");
    refuses("\"w\": 640", "\"w\": 640.5", "frames[0].w: is 640.5, expected a whole number");
    refuses("\"w\": 640, ", "", "does not say how large");
    refuses("\"fl_x\": 500, ", "", "frames[0].fl_x: is `missing`");
    refuses("\"fl_x\": 500", "\"camera_angle_x\": 3.2", "frames[0].camera_angle_x: is 3.2");
    refuses("\"fl_x\": 500", "\"fl_x\": 0", "frames[0].interior.principal_distance[0]: is 0");
    refuses("\"k1\"", "\"k4\"", "frames[0].k4: is `0.1`");
    refuses("OPENCV\"", "OPENCV_FISHEYE\", \"p1\": 1", "frames[0].p1: is `1, 0`");
    refuses("[0, 0, 0, 1]", "[0, 0, 0, 2]", "frames[0].transform_matrix: is `4 rows`");
    refuses("[1, 0, 0, 0], ", "", "frames[0].transform_matrix");
    refuses("[1, 0, 0, 0]", "[1, 0, 0]", "frames");
    refuses("[1, 0, 0, 0]", "[-1, 0, 0, 0]", "frames[0].transform_matrix.rotation_matrix: mirrors");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damaged_files_are_refused_or_read(at in 0.0..1.0f64, byte in any::<u8>(), cut in any::<bool>()) {
        let mut bytes = GOOD.as_bytes().to_vec();
        let at = (at * bytes.len() as f64) as usize;
        if cut { bytes.truncate(at); } else { bytes[at] = byte; }
        let text = String::from_utf8_lossy(&bytes);
        for (_, camera) in nerf::parse(&text, None).unwrap_or_default() {
            prop_assert!(camera.camera().is_ok());
        }
    }
}
