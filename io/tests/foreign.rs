//! Files of COLMAP's and OpenCV's, read and written, beside what those programs compute; and matrices for a GPU.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use collinear::geometry::projection::ClipConvention;
use collinear::nalgebra::{Matrix4, Point2, Point3, Vector2, Vector4};
use collinear_io::bundler::Bundle;
use collinear_io::camera::CameraFile;
use collinear_io::colmap::{Encoding, Reconstruction};
use collinear_io::gpu::GpuCamera;
use collinear_io::opencv::Form;
use collinear_io::{Document, opencv, photographs, pix4d};
use proptest::prelude::*;
use serde_json::Value;

fn oracle(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles")).join(path)
}

fn json(path: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(oracle(path)).unwrap()).unwrap()
}

fn three(v: &Value) -> [f64; 3] {
    serde_json::from_value(v.clone()).unwrap()
}

fn two(v: &Value) -> [f64; 2] {
    serde_json::from_value(v.clone()).unwrap()
}

fn sees(camera: &CameraFile, world: [f64; 3], image: [f64; 2]) {
    let found = camera.camera().unwrap().sensor().project(&Point3::from(world)).unwrap();
    let off = (found - Point2::from(image)).norm();
    assert!(off < 1e-9, "{found} for {image:?}");
}

/// pycolmap 4.2.1 (`tests/oracles/colmap.py`), both forms; `rigs` and `frames` lie beside and are passed over.
#[test]
fn colmaps_folders_project_as_colmap_does() {
    let expected = json("colmap/expected.json");
    for form in ["text", "binary"] {
        let cameras: BTreeMap<_, _> =
            photographs::read(&oracle("colmap").join(form), None).unwrap().into_iter().collect();
        let images = expected["images"].as_object().unwrap();
        assert_eq!(cameras.len(), 6);
        for (name, pairs) in images {
            for pair in pairs.as_array().unwrap() {
                sees(&cameras[name], three(&pair[0]), two(&pair[1]));
            }
        }
    }
}

/// The 48 bytes that pycolmap 4.2.1 writes for one panorama of 2000 × 1000 pixels, camera 1.
#[test]
fn a_folder_of_panoramas_alone_is_read() {
    let mut bytes = 1u64.to_le_bytes().to_vec();
    [1u32, 17].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    [2000u64, 1000].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    [2000.0f64, 1000.0].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    let none = 0u64.to_le_bytes();
    let model = Reconstruction::parse_binary(&bytes, &none, &none).unwrap();
    assert_eq!(model.cameras[&1].model, "EQUIRECTANGULAR");
    assert_eq!(model.cameras[&1].parameters, [2000.0, 1000.0]);
    assert_eq!(model.encode(Encoding::Binary).unwrap()[0], bytes);
}

#[test]
fn colmaps_files_are_written_as_colmap_writes_them() {
    let text = Reconstruction::read(&oracle("colmap/text")).unwrap();
    let binary = Reconstruction::read(&oracle("colmap/binary")).unwrap();
    assert_eq!(text, binary);
    assert_eq!((text.cameras.len(), text.images.len(), text.points.len()), (6, 6, 3));
    // pycolmap counts from 1; what it wrote: 10 k, 20, 255 and four images a point.
    assert_eq!(text.points[&2].color, [10, 20, 255]);
    assert_eq!(text.points[&2].track, [(4, 1), (5, 1), (6, 1), (7, 1)]);
    assert_eq!(text.images[&5].observations[2].point, Some(3));
    assert_eq!(text.images[&5].observations[3].point, None);
    let names = ["cameras.bin", "images.bin", "points3D.bin"];
    for (bytes, name) in binary.encode(Encoding::Binary).unwrap().iter().zip(names) {
        assert_eq!(*bytes, fs::read(oracle("colmap/binary").join(name)).unwrap(), "{name}");
    }
    let folder = tempfile::tempdir().unwrap();
    for encoding in [Encoding::Text, Encoding::Binary] {
        let path = folder.path().join(format!("{encoding:?}/deep"));
        text.write(&path, encoding).unwrap();
        assert_eq!(Reconstruction::read(&path).unwrap(), text);
    }
}

/// pycolmap 4.2.1 takes the binary form of a folder before the text, and the poses of `frames` before those of `images`.
#[test]
fn a_folder_that_colmap_would_read_otherwise_is_not_written_into() {
    let model = Reconstruction::read(&oracle("colmap/text")).unwrap();
    for (there, encoding) in [
        ("cameras.bin", Encoding::Text),
        ("rigs.txt", Encoding::Text),
        ("frames.bin", Encoding::Binary),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(there), "").unwrap();
        let error = model.write(folder.path(), encoding).unwrap_err().to_string();
        assert!(error.contains(&format!("holds {there}, which COLMAP")), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
    let folder = tempfile::tempdir().unwrap();
    for encoding in [Encoding::Text, Encoding::Binary, Encoding::Binary] {
        model.write(folder.path(), encoding).unwrap();
    }
}

/// pycolmap 4.2.1 reads `photo 1.jpg` of `images.txt` as `photo`; out of `images.bin` as it is.
#[test]
fn names_with_spaces_are_for_the_binary_form() {
    let mut model = Reconstruction::read(&oracle("colmap/text")).unwrap();
    model.images.get_mut(&5).unwrap().name = "front gate.jpg".into();
    let error = model.encode(Encoding::Text).unwrap_err().to_string();
    assert!(error.starts_with("image 5.name: is `front gate.jpg`: COLMAP cannot"), "{error}");
    let [c, i, p] = model.encode(Encoding::Binary).unwrap();
    assert_eq!(Reconstruction::parse_binary(&c, &i, &p).unwrap(), model);
    for name in ["", " a", "a\nb", "a\0b"] {
        model.images.get_mut(&5).unwrap().name = name.into();
        assert!(model.encode(Encoding::Binary).is_err(), "{name:?}");
    }
}

/// Out of COLMAP's files and into them again: the same pixels, the models by names of our own.
#[test]
fn photographs_survive_colmap() {
    let before = photographs::read(&oracle("colmap/text"), None).unwrap();
    let model = Reconstruction::from_photographs(&before).unwrap();
    let after = model.photographs().unwrap();
    let expected = json("colmap/expected.json");
    for ((name, camera), (same, _)) in after.iter().zip(&before) {
        assert_eq!(name, same);
        for pair in expected["images"][name].as_array().unwrap() {
            sees(camera, three(&pair[0]), two(&pair[1]));
        }
    }
    // Two photographs of one camera share it.
    let twice: Vec<_> = ["a", "b"].iter().map(|n| ((*n).to_owned(), before[1].1.clone())).collect();
    assert_eq!(Reconstruction::from_photographs(&twice).unwrap().cameras.len(), 1);
}

/// OpenCV 5.0.0 (`tests/oracles/opencv.py`): its first pixel's centre is (0, 0).
#[test]
fn opencvs_calibrations_project_as_opencv_does() {
    let expected = json("opencv/expected.json");
    let world: Vec<_> = expected["world"].as_array().unwrap().iter().map(three).collect();
    for (name, views) in expected["images"].as_object().unwrap() {
        let cameras = photographs::read(&oracle("opencv").join(name), None).unwrap();
        assert_eq!(cameras.len(), 2);
        for ((view, camera), images) in cameras.iter().zip(views.as_array().unwrap()) {
            // Written by us in every form, and read again, too.
            let forms = [Form::Yaml, Form::Json, Form::Xml];
            let written = forms.map(|form| {
                let text = opencv::to_text(camera, form).unwrap();
                photographs::parse(&text, None).unwrap().remove(0).1
            });
            for camera in std::iter::once(camera).chain(&written) {
                for (world, image) in world.iter().zip(images.as_array().unwrap()) {
                    let [x, y] = two(image);
                    sees(camera, *world, [x + 0.5, y + 0.5]);
                }
            }
            assert!(view == "view_0" || view == "view_1");
        }
    }
}

#[test]
fn ros_camera_info_is_read() {
    let text = "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix:\n  rows: 3\n  cols: 3\n  \
        data: [1000, 0, 319.5, 0, 1000, 239.5, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  \
        rows: 1\n  cols: 5\n  data: [-0.28, 0.07, 0.001, -0.0005, 0.002]\n";
    let (_, camera) = photographs::parse(text, None).unwrap().remove(0);
    // OpenCV 5.0.0, projectPoints, and half a pixel.
    sees(&camera, [0.31, -0.22, 1.0], [617.607_622_086_597_5, 28.887_816_583_705_02]);
    let fisheye = text.replace("plumb_bob", "equidistant").replace(", 0.002]", "]");
    assert_eq!(photographs::parse(&fisheye, None).unwrap()[0].1.interior.model(), "fisheye");
}

/// f = 500, the world's axes turned a quarter about z: P = (−Y, X, Z) + t.
const BUNDLE: &str = "# Bundle file v0.3\n2 1\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n500 -0.1 0.02\n0 -1 0\n1 0 0\n0 0 1\n\
    1 2 -3\n4 5 -7\n1 2 3\n1 1 9 -198 297\n";

#[test]
fn bundlers_cameras_look_along_minus_z_with_y_up() {
    let bundle = Bundle::parse(BUNDLE).unwrap();
    let cameras = photographs::parse(BUNDLE, Some([640, 480])).unwrap();
    let [(name, camera)] = &cameras[..] else { panic!() };
    assert_eq!(name, "camera_1");
    // P = (−4, 6, −10), p = (−0.4, 0.6), r² = 0.52: 1 − 0.052 + 0.005408 = 0.953408.
    let (x, y) = (-200.0 * 0.953_408, 300.0 * 0.953_408);
    sees(camera, [4.0, 5.0, -7.0], [320.0 + x, 240.0 - y]);
    assert_eq!(bundle.points[0].views[0].pixel([640, 480]), [122.0, -57.0]);
    assert_eq!(Bundle::parse(&bundle.to_text()).unwrap(), bundle);
    let again = Bundle::from_photographs(&cameras).unwrap();
    assert_eq!(again.cameras, bundle.cameras[1..]);
    let refuses = |text: &str, expected: &str| refuses_of(text, Some([640, 480]), expected);
    refuses(&BUNDLE.replace("v0.3", "v0.4"), "line 1: says `# Bundle file v0.4`");
    refuses(&BUNDLE.replace("1 1 9", "1 2 9"), "view in line 15: names a camera `2`");
    refuses(
        &BUNDLE.replace("-198 297", "-198"),
        "line 15: the file ends, expected the image point of point 0 (of 1)",
    );
    refuses(
        &BUNDLE.replace("2 1\n0", "99999999999 1\n0"),
        "the file ends, expected the R of camera 2",
    );
    refuses(
        &BUNDLE.replace("0 -1 0", "0 -2 0"),
        "camera_1.exterior.rotation_matrix: is no rotation",
    );
    refuses(&BUNDLE.replace("500", "nan"), "line 8: f, k1, k2 of camera 1 (of 2) is `nan`");
    let error = photographs::parse(BUNDLE, None).unwrap_err().to_string();
    assert!(error.contains("does not say how large its pictures are"), "{error}");
    let off = CameraFile { width: 641, ..camera.clone() };
    assert!(Bundle::from_photographs(&[("a".into(), off)]).is_err());
}

/// A published bundle: its points fall where they were measured, to a fraction of a pixel.
#[test]
fn a_published_bundle_meets_its_measurements() {
    let Some(path) = crate::shared_data("bal/Balbianello.out") else { return };
    let bundle = Bundle::read(&path).unwrap();
    assert_eq!((bundle.cameras.len(), bundle.points.len()), (5, 544));
    let size = [640, 480];
    let cameras: Vec<_> =
        bundle.photographs(size).unwrap().iter().map(|(_, c)| c.camera().unwrap()).collect();
    let (mut sum, mut count) = (0.0_f64, 0.0_f64);
    for point in &bundle.points {
        for view in &point.views {
            let image = cameras[view.camera].sensor().project(&Point3::from(point.world)).unwrap();
            sum += (image - Point2::from(view.pixel(size))).norm_squared();
            count += 1.0;
        }
    }
    let rms: f64 = (sum / count).sqrt();
    assert!(count > 1000.0 && rms < 1.0, "{rms} of {count}");
    assert_eq!(Bundle::parse(&bundle.to_text()).unwrap(), bundle);
}

fn refuses(text: &str, expected: &str) {
    refuses_of(text, None, expected);
}

fn refuses_of(text: &str, size: Option<[u32; 2]>, expected: &str) {
    let error = photographs::parse(text, size).unwrap_err().to_string();
    assert!(error.contains(expected), "{error}\n{expected}");
}

#[test]
fn bad_calibrations_are_refused_with_the_field() {
    let good = fs::read_to_string(oracle("opencv/brown.yml")).unwrap();
    refuses(&good.replace("image_width: 1280\n", ""), "image_width: is `missing`");
    refuses(&good.replace("1280", "-3"), "image_width: is `-3`");
    refuses(&good.replace("0., 0., 1. ]", "0., 0. ]"), "camera_matrix: is `8 numbers`");
    refuses(
        &good.replace("0., 0., 1. ]", "0., 0.5, 1. ]"),
        "camera_matrix: is `0, 0, 0.5, 1 below`",
    );
    refuses(&good.replace("1203.5", "\"wide\""), "camera_matrix: is `");
    refuses(
        &good.replace("0.013100000000000001 ]", "1, 2, 3 ]"),
        "distortion_coefficients: is `7 numbers`",
    );
    refuses(
        &good.replace("fisheye_model: 0", "fisheye_model: 1"),
        "a fisheye has four coefficients",
    );
    refuses(
        &good.replace("fisheye_model: 0", "distortion_model: spline"),
        "distortion_model: is `spline`",
    );
    refuses(&good.replace("fisheye_model: 0", "xi: 0.9"), "omnidir has one xi and four");
    refuses(&good[..good.len() / 2], "");
    refuses("%YAML:1.0\n---\n- 1\n- 2\n", "is no file of OpenCV's");
    refuses("camera_matrix: [", "is no file of OpenCV's");
    refuses("", "holds no cameras");
    refuses("nothing of the kind", "holds no cameras");
    refuses("{\"cameras\": 3}", "holds no cameras");
}

#[test]
fn bad_colmap_files_are_refused_with_their_place() {
    let cameras = "1 PINHOLE 640 480 500 500 320 240\n";
    let images = "1 1 0 0 0 0 0 0 1 a.jpg\n10 20 -1\n";
    let points = "1 0 0 5 1 2 3 0.5 1 0\n";
    let says = |c: &str, i: &str, p: &str, expected: &str| {
        let error = Reconstruction::parse_text(c, i, p).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    Reconstruction::parse_text(cameras, images, points).unwrap();
    says("1 PINHOLE 640\n", images, points, "line 1: has 3 fields, expected 5");
    says("1 TRIOPTAR 640 480 3\n", images, points, "line 1, field 2: says `TRIOPTAR`");
    says(
        "1 PINHOLE 640 480 500 500 320\n",
        images,
        points,
        "camera 1.parameters: has 3 entries, 4",
    );
    says("1 PINHOLE 640 480 500 500 320 x\n", images, points, "line 1, field 8: PARAMS is `x`");
    says("1 PINHOLE 640 480 0 500 320 240\n", images, points, "camera 1.parameters[0]: is 0");
    says(&cameras.repeat(2), images, points, "is `1` like an earlier one");
    says(
        cameras,
        &images.replace("1 a.jpg", "2 a.jpg"),
        points,
        "image 1.camera_id: names a camera `2`",
    );
    says(cameras, &images.replace("10 20 -1", "10 20"), points, "line 2: has 2 fields, expected 3");
    says(
        cameras,
        &images.replace("1 1 0 0 0", "1 2 0 0 0"),
        points,
        "image 1.quaternion: has length 2",
    );
    says(cameras, &images.replace(" a.jpg", ""), points, "line 1: has 9 fields, expected 10");
    says(cameras, images, "1 0 0 5 1 2 300 0.5\n", "line 1, field 7: B is `300`");
    says(cameras, images, "1 0 0 inf 1 2 3 0.5\n", "line 1, field 4: Z is `inf`");
    says(cameras, images, "1 0 0 5 1 2 3 0.5 1\n", "line 1: has 9 fields, expected 10");

    let read = |name| fs::read(oracle("colmap/binary").join(name)).unwrap();
    let [c, i, p] = ["cameras.bin", "images.bin", "points3D.bin"].map(read);
    let says = |c: &[u8], i: &[u8], p: &[u8], expected: &str| {
        let error = Reconstruction::parse_binary(c, i, p).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    Reconstruction::parse_binary(&c, &i, &p).unwrap();
    says(&c[..100], &i, &p, "is damaged: the number of cameras at byte 0 is 6");
    says(&c[..c.len() - 1], &i, &p, "is cut off: the camera's parameters at byte");
    says(&[&c[..], &[0]].concat(), &i, &p, "has 1 bytes more than its counts say");
    let huge = [&u64::MAX.to_le_bytes()[..], &c[8..]].concat();
    says(&huge, &i, &p, "the number of cameras at byte 0 is 18446744073709551615");
    let mut model = c.clone();
    model[12] = 99;
    says(&model, &i, &p, "the camera's model at byte 12 is 99");
    let mut nan = i.clone();
    nan[12..20].copy_from_slice(&f64::NAN.to_le_bytes());
    says(&c, &nan, &p, "the image's quaternion at byte 12 is NaN or infinite");
    says(&c, &i, &p[..20], "the number of points at byte 0 is 3");
}

/// What other programs do not have is refused, and says so.
#[test]
fn a_camera_that_a_program_does_not_have_is_refused() {
    let camera = |interior: &str| {
        CameraFile::parse(&format!(
            r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior},
            "principal_distance": [500, 500], "principal_point": [320, 240] }},
            "exterior": {{ "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }} }}"#
        ))
        .unwrap()
    };
    let colmap = |c: &CameraFile| Reconstruction::from_photographs(&[("p".into(), c.clone())]);
    let tilted = camera(r#""model": "rational", "tau": [0.1, 0]"#);
    assert!(colmap(&tilted).unwrap_err().to_string().contains("p.interior.model: is `rational`"));
    assert!(opencv::to_text(&tilted, Form::Yaml).is_ok());
    let sphere = camera(r#""model": "double_sphere", "xi": 0.1, "alpha": 0.5"#);
    for error in [
        colmap(&sphere).unwrap_err(),
        opencv::to_text(&sphere, Form::Json).unwrap_err(),
        GpuCamera::new(&sphere, ClipConvention::OpenGl, 0.1, None).unwrap_err(),
    ] {
        assert!(error.to_string().contains("interior.model: is `double_sphere`"), "{error}");
    }
    let skewed = camera(r#""model": "pinhole", "skew": 2"#);
    assert!(
        colmap(&skewed).is_err()
            && GpuCamera::new(&skewed, ClipConvention::Wgpu, 0.1, None).is_err()
    );
    // OpenCV 5.0.0, projectPoints of (0.31, -0.22, 1) with 200 at the skew's place: as with 0 there.
    let fisheye = camera(r#""model": "fisheye", "skew": 2"#);
    for camera in [&skewed, &fisheye] {
        let error = opencv::to_text(camera, Form::Yaml).unwrap_err().to_string();
        assert!(error.contains("interior.skew: is `2`: OpenCV has no skew"), "{error}");
    }
    let omnidir = camera(r#""model": "unified", "xi": 0.9, "skew": 2"#);
    let text = opencv::to_text(&omnidir, Form::Yaml).unwrap();
    assert!(text.contains("data: [ 500.0, 2.0, 319.5,"), "{text}");
    let pinhole = camera(r#""model": "pinhole""#);
    assert!(GpuCamera::new(&pinhole, ClipConvention::Wgpu, 0.0, None).is_err());
    assert!(GpuCamera::new(&pinhole, ClipConvention::Wgpu, 1.0, Some(0.5)).is_err());
}

/// A pixel of the photograph is the pixel of the viewport, in every clip volume: by the specifications' own formulas.
#[test]
fn matrices_put_points_on_the_photographs_pixels() {
    let text = r#"{ "collinear": "camera", "version": 1, "width": 3264, "height": 2448,
        "interior": { "model": "pinhole", "principal_distance": [2838.6, 2840.1], "principal_point": [1700, 1100] },
        "exterior": { "projection_center": [12.5, -30, 1.7], "omega_phi_kappa": [1.52, 0.06, -0.01] } }"#;
    let camera = CameraFile::parse(text).unwrap();
    let sensor = camera.camera().unwrap();
    for (convention, name) in [
        (ClipConvention::OpenGl, "opengl"),
        (ClipConvention::Direct3d, "direct3d"),
        (ClipConvention::Vulkan, "vulkan"),
        (ClipConvention::Wgpu, "wgpu"),
    ] {
        for far in [None, Some(500.0)] {
            let gpu = GpuCamera::new(&camera, convention, 0.5, far).unwrap();
            assert_eq!(gpu.clip, name);
            let [view, projection] =
                [gpu.view, gpu.projection].map(|m| Matrix4::from_column_slice(&m));
            for world in [[11.0, 10.0, 4.0], [20.0, 5.0, 0.0], [0.0, 60.0, 30.0]] {
                let eye = view * Vector4::new(world[0], world[1], world[2], 1.0);
                assert!(eye.z < 0.0 && (eye.w - 1.0).abs() < 1e-15, "{eye}");
                let clip = projection * eye;
                let ndc = Vector2::new(clip.x, clip.y) / clip.w;
                // y of the device points down in Vulkan alone, that of the picture in all.
                let down = if name == "vulkan" { ndc.y } else { -ndc.y };
                let pixel = Point2::new(1632.0 * (ndc.x + 1.0), 1224.0 * (down + 1.0));
                let image = sensor.sensor().project(&Point3::from(world)).unwrap();
                assert!((pixel - image).norm() < 1e-9, "{name}: {pixel} {image}");
                let depth = clip.z / clip.w;
                let least = if name == "opengl" { -1.0 } else { 0.0 };
                assert!(depth > least && depth < 1.0, "{depth}");
            }
            let again: Value = serde_json::from_str(&gpu.to_json().unwrap()).unwrap();
            assert_eq!(again["view"][12].as_f64().unwrap(), gpu.view[12]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    /// Damaged files are refused or read, without a panic.
    #[test]
    fn damaged_files_of_others_are_refused_or_read(at in 0.0..1.0f64, byte in any::<u8>(), cut in any::<bool>()) {
        for name in ["opencv/tilted.yml", "opencv/rational.json", "opencv/tilted.xml", "metashape/cameras.xml", "metashape/calibration.xml", "colmap/text/images.txt", "colmap/binary/images.bin", "colmap/binary/cameras.bin", "colmap/binary/points3D.bin"] {
            let mut bytes = fs::read(oracle(name)).unwrap();
            let at = (at * bytes.len() as f64) as usize;
            if cut { bytes.truncate(at); } else { bytes[at] = byte; }
            let text = String::from_utf8_lossy(&bytes);
            let _ = photographs::parse(&text, None);
            let cameras = "1 PINHOLE 640 480 500 500 320 240\n";
            let _ = Reconstruction::parse_text(cameras, &text, "");
            let _ = Reconstruction::parse_text(&text, "", "");
            let _ = Reconstruction::parse_text("", "", &text);
            let _ = Reconstruction::parse_binary(&bytes, &bytes, &bytes);
            let _ = Reconstruction::parse_binary(&0u64.to_le_bytes(), &bytes, &[]);
            let _ = Reconstruction::parse_binary(&0u64.to_le_bytes(), &0u64.to_le_bytes(), &bytes);
        }
    }
}

/// Terms that are zero are no reason to refuse a camera: by hand, r² = 0.05 at (0.2, −0.1), radial 1 − 0.1 · 0.05 + 0.02 · 0.0025 = 0.99505,
/// 2 · 1e-3 · x y = −4e-5 and −5e-4 (r² + 2 x²) = −6.5e-5 in x, 1e-3 (r² + 2 y²) = 7e-5 and 2 · −5e-4 · x y = 2e-5 in y.
#[test]
fn lenses_whose_other_terms_are_zero_are_browns() {
    let exterior =
        r#""exterior": { "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }"#;
    let file = |lens: &str| {
        let start = r#""collinear": "camera", "version": 1, "width": 1000, "height": 800"#;
        let interior = r#""principal_distance": [1000, 1000], "principal_point": [500, 400]"#;
        let text = format!("{{ {start}, \"interior\": {{ {lens}, {interior} }}, {exterior} }}");
        vec![("a".to_owned(), CameraFile::parse(&text).unwrap())]
    };
    let image = Point2::new(
        500.0 + 1000.0 * (0.2 * 0.99505 - 4e-5 - 6.5e-5),
        400.0 + 1000.0 * (-0.1 * 0.99505 + 7e-5 + 2e-5),
    );
    for lens in [
        r#""model": "metashape", "k": [-0.1, 0.02, 0, 0], "p": [-5e-4, 1e-3, 0, 0]"#,
        r#""model": "rational", "k": [-0.1, 0.02, 0, 0, 0, 0], "p": [1e-3, -5e-4]"#,
    ] {
        let written = pix4d::to_text(&file(lens)).unwrap();
        let (_, camera) = pix4d::parse(&written).unwrap().remove(0);
        let found = camera.camera().unwrap().sensor().project(&Point3::new(0.2, -0.1, 1.0));
        assert!((found.unwrap() - image).norm() < 1e-9, "{lens}");
    }
    // A fisheye's too: r = θ (1 + 0.03 θ²).
    for lens in [
        r#""model": "thin_prism_fisheye", "k": [0.03, 0, 0, 0], "p": [0, 0], "s": [0, 0]"#,
        r#""model": "fisheye624", "k": [0.03, 0, 0, 0, 0, 0], "p": [0, 0], "s": [0, 0, 0, 0]"#,
    ] {
        let written = opencv::to_text(&file(lens)[0].1, Form::Yaml).unwrap();
        let (_, camera) = opencv::parse(&written).unwrap().remove(0);
        let found = camera.camera().unwrap().sensor().project(&Point3::new(1.0, 0.0, 1.0)).unwrap();
        let angle = std::f64::consts::FRAC_PI_4;
        let exact = Point2::new(500.0 + 1000.0 * angle * (1.0 + 0.03 * angle * angle), 400.0);
        assert!((found - exact).norm() < 1e-9, "{lens}: {found}");
    }
    // And a lens that does nothing is a matrix.
    let none = file(r#""model": "brown", "k": [0, 0, 0], "p": [0, 0]"#);
    assert!(GpuCamera::new(&none[0].1, ClipConvention::Vulkan, 0.1, None).is_ok());
}
