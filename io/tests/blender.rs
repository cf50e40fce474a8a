//! Blender's cameras, beside what Blender computes.

use std::fs;

use collinear_io::blender::{BlenderCamera, BlenderLens, SensorFit, to_script};
use collinear_io::photographs;

use crate::gltf::{json, oracle, sees};

/// Blender 5.0.1 (`tests/oracles/blender.py --record`): every fit, shifts, wide pixels, parallel projections.
#[test]
fn cameras_of_every_fit_see_what_blenders_do() {
    let cases = json("blender/cameras.json");
    let cases = cases["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 10);
    for case in cases {
        let blender: BlenderCamera = serde_json::from_value(case["camera"].clone()).unwrap();
        let camera = blender.camera().unwrap();
        let again = BlenderCamera::from_camera(&camera).unwrap().camera().unwrap();
        for camera in [&camera, &again] {
            for pair in case["pixels"].as_array().unwrap() {
                sees(camera, &pair[0], &pair[1]);
            }
        }
    }
}

/// The script that Blender ran (`--script`) is the one that is written, and its cameras see the points where ours do.
#[test]
fn the_script_makes_cameras_that_see_the_same_in_blender() {
    let cameras = photographs::read(&oracle("blender/sparse"), None).unwrap();
    let script = to_script(&cameras).unwrap();
    assert_eq!(script, fs::read_to_string(oracle("blender/written.py")).unwrap());
    let run = json("blender/run.json");
    for (name, camera) in &cameras {
        let found = &run[name];
        assert_eq!(found["size"], serde_json::json!([camera.width, camera.height]));
        let pixels = found["pixels"].as_array().unwrap();
        assert_eq!(pixels.len(), 3);
        for (world, image) in run["points"].as_array().unwrap().iter().zip(pixels) {
            sees(camera, world, image);
        }
    }
    // 20 px on 1280 would be 0.5625 mm before 36: Blender's lenses start at 1.
    let wide = BlenderCamera::from_camera(&cameras[2].1).unwrap();
    assert_eq!((wide.lens, wide.sensor_width_mm), (BlenderLens::LensMm(1.0), 64.0));
}

#[test]
fn what_is_no_camera_is_refused() {
    let cases = json("blender/cameras.json");
    let good: BlenderCamera = serde_json::from_value(cases["cases"][0]["camera"].clone()).unwrap();
    let refuses = |change: &dyn Fn(&mut BlenderCamera), expected: &str| {
        let mut bad = good.clone();
        change(&mut bad);
        let error = bad.camera().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    refuses(&|c| c.sensor_width_mm = 0.0, "sensor_width_mm: is 0");
    refuses(&|c| c.sensor_height_mm = f64::NAN, "sensor_height_mm: is NaN");
    refuses(&|c| c.pixel_aspect[1] = -1.0, "pixel_aspect[1]: is -1");
    refuses(&|c| c.shift[0] = f64::INFINITY, "shift[0]: is inf");
    refuses(&|c| c.lens = BlenderLens::LensMm(0.0), "interior.principal_distance[0]: is 0");
    refuses(&|c| c.lens = BlenderLens::OrthoScale(0.0), "interior.pixels_per_unit[0]: is inf");
    refuses(&|c| c.resolution[0] = 0, "is 0");
    refuses(&|c| c.matrix_world[0] = [0.0; 4], "matrix_world.rotation_matrix");
    refuses(&|c| c.matrix_world[2][3] = f64::NAN, "matrix_world.projection_center[2]: is NaN");
    let mut lens = photographs::read(&oracle("colmap/text"), None).unwrap();
    lens.truncate(1);
    let error = to_script(&lens).unwrap_err().to_string();
    assert!(error.contains("interior.model: is `"), "{error}");
    assert_eq!(serde_json::to_string(&SensorFit::Auto).unwrap(), "\"AUTO\"");
}
