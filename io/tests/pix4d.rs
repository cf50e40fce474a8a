//! Pix4D's files, beside what Pix4Dmapper wrote of the same photographs and what OpenCV makes of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use collinear::nalgebra::{Point2, Point3};
use collinear_io::camera::{CameraFile, Interior};
use collinear_io::orientation::AngleUnit;
use collinear_io::photographs::{self, Given};
use collinear_io::pix4d;
use proptest::prelude::*;
use serde_json::Value;

fn oracle(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles/pix4d")).join(name)
}

fn text(name: &str) -> String {
    fs::read_to_string(oracle(name)).unwrap()
}

fn expected() -> Value {
    serde_json::from_str(&text("expected.json")).unwrap()
}

/// Pairs of a world point and its pixel.
fn pairs(value: &Value) -> Vec<([f64; 3], [f64; 2])> {
    serde_json::from_value(value.clone()).unwrap()
}

fn sees(camera: &CameraFile, pairs: &[([f64; 3], [f64; 2])], add: [f64; 3], tolerance: f64) {
    assert!(!pairs.is_empty());
    for (world, image) in pairs {
        let world = Point3::from(*world) + collinear::nalgebra::Vector3::from(add);
        let found = camera.camera().unwrap().sensor().project(&world).unwrap();
        assert!((found - Point2::from(*image)).norm() < tolerance, "{found} for {image:?}");
    }
}

const CALIBRATED: &str = "calibrated_camera_parameters.txt";

/// OpenCV 5.0.0 and pyopf's formulas (`tests/oracles/pix4d.py`); no half pixel between them.
#[test]
fn calibrated_cameras_project_as_pix4d_says() {
    let expected = expected();
    let cameras = photographs::read(&oracle(CALIBRATED), None).unwrap();
    assert_eq!(cameras.len(), 3);
    let written = pix4d::to_text(&cameras).unwrap();
    let again: BTreeMap<_, _> = pix4d::parse(&written).unwrap().into_iter().collect();
    for (name, camera) in &cameras {
        for camera in [camera, &again[name]] {
            sees(camera, &pairs(&expected["images"][name]), [0.0; 3], 1e-8);
        }
    }
    assert_eq!((cameras[0].1.width, cameras[0].1.height), (7360, 4912));
}

/// The block of DSC_0157 that we write is Pix4D's, number after number.
#[test]
fn what_is_written_is_what_pix4d_wrote() {
    let before = text(CALIBRATED);
    let after = pix4d::to_text(&pix4d::parse(&before).unwrap()).unwrap();
    let (old, new): (Vec<_>, Vec<_>) =
        (before.split_whitespace().collect(), after.split_whitespace().collect());
    assert_eq!(old.len(), new.len());
    for (old, new) in old.iter().zip(new) {
        match old.parse::<f64>() {
            Ok(old) => {
                let new: f64 = new.parse().unwrap();
                assert!((old - new).abs() < 1e-14 * old.abs().max(1.0), "{old} {new}");
            }
            Err(_) => assert_eq!(*old, new),
        }
    }
}

/// Two files of Pix4Dmapper's: the angles of one are the matrix of the other, its place that one's and the offset. Angles with
/// six decimals are 10⁻⁸ radians: 10⁻⁴ pixels.
#[test]
fn the_external_parameters_agree_with_the_calibrated_ones() {
    let expected = expected();
    let offset: [f64; 3] = serde_json::from_value(expected["dsc_offset"].clone()).unwrap();
    let interior = photographs::read(&oracle(CALIBRATED), None).unwrap().remove(0).1;
    let given = Given { interior: Some(interior), ..Given::default() };
    let path = oracle("calibrated_external_camera_parameters.txt");
    let cameras = photographs::read_with(&path, &given).unwrap();
    let [(name, camera)] = &cameras[..] else { panic!() };
    assert_eq!(name, "DSC_0157.JPG");
    let pairs = pairs(&expected["images"][name]);
    sees(camera, &pairs, offset, 5e-4);
    let local = Given { offset: offset.map(|o| -o), ..given };
    sees(&photographs::read_with(&path, &local).unwrap()[0].1, &pairs, [0.0; 3], 5e-4);
    let error = photographs::read(&path, None).unwrap_err().to_string();
    assert!(error.contains("is a table of exterior orientations: give the camera"), "{error}");
    let gon = Given { angle_unit: Some(AngleUnit::Gon), ..local.clone() };
    let error = photographs::read_with(&path, &gon).unwrap_err().to_string();
    assert!(error.contains("angles: is `gon`: the header says another unit"), "{error}");
    let error = photographs::read_with(&oracle(CALIBRATED), &local).unwrap_err().to_string();
    assert!(error.contains("has interior orientations of its own"), "{error}");
}

/// Inpho's millimetres and Pix4D's own say what the calibrated parameters of the same projects do.
#[test]
fn millimetres_are_the_pixels_of_the_same_project() {
    let cameras: BTreeMap<_, _> =
        photographs::read(&oracle(CALIBRATED), None).unwrap().into_iter().collect();
    let inpho = oracle("calibrated_internal_camera_parameters.cam");
    let own = oracle("pix4d_calibrated_internal_camera_parameters.cam");
    for (path, size, name) in
        [(&inpho, None, "DJI_0172.JPG"), (&own, Some([4608, 3456]), "DJI_0954.JPG")]
    {
        let camera = photographs::read_interior(path, size).unwrap();
        let of = &cameras[name];
        assert_eq!((camera.width, camera.height), (of.width, of.height));
        let (
            Interior::Brown { principal_distance: f, principal_point: c, k, p, .. },
            Interior::Brown { principal_distance: f0, principal_point: c0, k: k0, p: p0, .. },
        ) = (&camera.interior, &of.interior)
        else {
            panic!()
        };
        for (found, expected) in [(f, f0), (c, c0)].iter().flat_map(|(a, b)| a.iter().zip(*b)) {
            assert!((found - expected).abs() < 1e-8, "{found} {expected}");
        }
        for (found, expected) in k.iter().chain(p).zip(k0.iter().chain(p0)) {
            assert!((found - expected).abs() < 1e-11, "{found} {expected}");
        }
    }
    let error = photographs::read(&own, None).unwrap_err().to_string();
    assert!(error.contains("does not say how large its pictures are"), "{error}");
    // The Inpho offsets alone, x right and y up, are the same principal point.
    let all = text("calibrated_internal_camera_parameters.cam");
    let whole = pix4d::parse_cam(&all, None).unwrap().remove(0).1;
    let without = all.replace("in pixel", "in furlongs").replace("-70.80399", "0.0");
    let from_mm = pix4d::parse_cam(&without, None).unwrap().remove(0).1;
    let point = |c: &CameraFile| match c.interior {
        Interior::Brown { principal_point, .. } => Point2::from(principal_point),
        _ => panic!(),
    };
    assert!((point(&whole) - point(&from_mm)).norm() < 1e-9);
}

#[test]
fn the_matrices_of_the_same_photograph_are_taken_apart() {
    let expected = expected();
    let size = Some([4608, 3456]);
    let (name, camera) = photographs::read(&oracle("pmatrix.txt"), size).unwrap().remove(0);
    assert_eq!(name, "DJI_0954.JPG");
    sees(&camera, &pairs(&expected["pmatrix"]), [0.0; 3], 1e-5);
    let whole = photographs::read(&oracle(CALIBRATED), None).unwrap().remove(2).1;
    let [center, of] = [&camera, &whole].map(|c| Point3::from(c.exterior.projection_center));
    assert!((center - of).norm() < 1e-3, "{center} {of}");
    // The sign of P has no meaning.
    let turned: String = text("pmatrix.txt")
        .split_whitespace()
        .map(|w| w.parse::<f64>().map_or(format!("{w} "), |v| format!("{} ", -v)))
        .collect();
    let again = photographs::parse(&turned, size).unwrap().remove(0).1;
    sees(&again, &pairs(&expected["pmatrix"]), [0.0; 3], 1e-5);
    let offset = pix4d::parse_offset(&text("offset.xyz")).unwrap();
    // Pix4D's `_calibrated_images_position.txt` of the photograph.
    let place = Point3::new(368_030.548_722, 3_955_824.412_658, 127.857_028);
    let given = Given { offset, ..Given::default() };
    let moved = photographs::read_with(&oracle(CALIBRATED), &given).unwrap().remove(2).1;
    assert!((Point3::from(moved.exterior.projection_center) - place).norm() < 1e-6);
}

/// Photographs without distortion are pinholes, which can become matrices.
#[test]
fn no_distortion_is_a_pinhole() {
    let mut blank = text(CALIBRATED);
    let first = "-0.09005921067656787182 0.10773972435740564180 -0.01257054987797603419\n-0.00029570539858373248 -0.00027422056492206067";
    assert!(blank.contains(first));
    blank = blank.replace(first, "0 0 0\n0 0");
    assert_eq!(pix4d::parse(&blank).unwrap()[0].1.interior.model(), "pinhole");
}

fn refuses(text: &str, expected: &str) {
    let error = photographs::parse(text, Some([4608, 3456])).unwrap_err().to_string();
    assert!(error.contains(expected), "{error}\n{expected}");
}

#[test]
fn bad_files_are_refused_with_their_place() {
    let good = text(CALIBRATED);
    refuses(
        &good.replace("radial distortion [3x1]", "fisheye affine matrix"),
        "line 3: says `fisheye",
    );
    refuses(&good.replacen("7360 4912", "7360", 1), "line 9: has 2 fields, expected 3");
    refuses(&good.replacen("7360", "wide", 1), "line 9: imageWidth is `wide`");
    refuses(&good.replacen("7360 4912", "0 4912", 1), "DSC_0157.JPG.width: is 0");
    refuses(&good.replacen("0 0 1\n", "0 1\n", 1), "line 12: has 2 fields, expected 3");
    refuses(
        &good.replacen("0 0 1\n", "0 0 2\n", 1),
        "DSC_0157.JPG.K: is `0, [0.0, 0.0, 2.0] below`",
    );
    refuses(&good.replacen("7363.5185", "nan 7363.5185", 1), "line 10: has 4 fields");
    refuses(&good.replacen("7363.51850023951465118444", "inf", 1), "line 10, field 1: K is `inf`");
    refuses(
        &good.replacen("-0.49632901575943477734", "0.49632901575943477734", 1),
        "DSC_0157.JPG.exterior.rotation_matrix: is no rotation",
    );
    let cut: String = good.lines().take(17).map(|l| format!("{l}\n")).collect();
    refuses(&cut, "line 18: has 0 fields, expected 3");
    let cam = text("calibrated_internal_camera_parameters.cam");
    refuses(&cam.replace("FOCAL ", "LOCAL "), "camera 0.FOCAL: is `missing`");
    refuses(&cam.replace("FOCAL 10", "FOCAL x10"), "line 4, field 2: FOCAL is `x10");
    refuses(&cam.replace("FOCAL 10.", "FOCAL -10."), "camera 0.interior.principal_distance[0]: is");
    refuses(&cam.replace("SYM_DIST 0 ", "SYM_DIST 1e-3 "), "camera 0.SYM_DIST: is `K0 0.001");
    refuses(&cam.replace("sensor width", "sensor"), "camera 0.sensor width: is `missing`");
    refuses(&cam.replace("XPOFF", "X"), "camera 0.principal point: is `missing`");
    let odd = cam.replace("#Image size 5472.00000000000000000000x", "#Image size 5472.5x");
    let error = photographs::parse(&odd, None).unwrap_err().to_string();
    assert!(error.contains("camera 0.Image size: is `5472.5 × 3648`"), "{error}");
    let p = text("pmatrix.txt");
    refuses(&p.replace("31.851547", "x"), "holds no cameras");
    refuses(&format!("{p}b 1 2\n"), "line 2: has 3 fields, expected 13");
    refuses("a 0 0 0 0 0 0 0 0 0 0 0 0", "a.P: is `no camera`");
    let error = photographs::parse(&p, None).unwrap_err().to_string();
    assert!(error.contains("does not say how large"), "{error}");
    for bad in ["", "1 2", "1 2 3 4", "1,2,x"] {
        assert!(pix4d::parse_offset(bad).is_err(), "{bad}");
    }
    assert_eq!(pix4d::parse_offset("1, -2; 3e2\n").unwrap(), [1.0, -2.0, 300.0]);
    let given = Given { offset: [1.7e308, 0.0, 0.0], ..Given::default() };
    let far = good.replacen("114.12600004808672338186", "1.7e308", 1);
    let error = photographs::parse_with(&far, &given).unwrap_err().to_string();
    assert!(error.contains("DSC_0157.JPG.exterior.projection_center[0]: is inf"), "{error}");
}

#[test]
fn what_pix4d_does_not_have_is_not_written() {
    let mut cameras = photographs::read(&oracle(CALIBRATED), None).unwrap();
    let refused = |cameras: &[(String, CameraFile)], expected: &str| {
        let error = pix4d::to_text(cameras).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    cameras[0].0 = "front gate.jpg".into();
    refused(&cameras, "name: is `front gate.jpg`: Pix4D's names have no blanks");
    cameras[0].0 = "a.jpg".into();
    let Interior::Brown { principal_distance, .. } = &mut cameras[0].1.interior else { panic!() };
    principal_distance[1] += 1.0;
    refused(
        &cameras,
        "a.jpg.interior: is `brown`: Pix4D's perspective camera has one focal length",
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damaged_files_are_refused_or_read(at in 0.0..1.0f64, byte in any::<u8>(), cut in any::<bool>()) {
        for name in [CALIBRATED, "calibrated_internal_camera_parameters.cam", "pmatrix.txt", "pix4d_calibrated_internal_camera_parameters.cam"] {
            let mut bytes = fs::read(oracle(name)).unwrap();
            let at = (at * bytes.len() as f64) as usize;
            if cut { bytes.truncate(at); } else { bytes[at] = byte; }
            let text = String::from_utf8_lossy(&bytes);
            for (name, camera) in photographs::parse(&text, Some([4608, 3456])).unwrap_or_default() {
                let built = camera.camera();
                prop_assert!(built.is_ok(), "{name}: {built:?} of {camera:?}");
            }
        }
    }
}
