//! OpenSfM's camera types, read and written, beside OpenSfM's own equations.

use std::fs;
use std::path::{Path, PathBuf};

use collinear::nalgebra::{Point2, Point3};
use collinear_io::camera::{CameraFile, Interior};
use collinear_io::opensfm::{Reconstruction, Reference, ScenePoint, parse_reconstruction};
use collinear_io::{Document, photographs};
use serde_json::{Value, json};

fn oracle(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles/opensfm")).join(name)
}

/// Every photograph images the world points where `tests/oracles/opensfm.py` (mpmath, OpenSfM's equations) says.
fn images_as_opensfm_does(photographs: &[(String, CameraFile)]) {
    let expected: Value =
        serde_json::from_str(&fs::read_to_string(oracle("expected.json")).unwrap()).unwrap();
    assert_eq!(photographs.len(), 15);
    for (name, camera) in photographs {
        let camera = camera.camera().unwrap();
        for (world, image) in expected["world"]
            .as_array()
            .unwrap()
            .iter()
            .zip(expected["images"][name].as_array().unwrap())
        {
            let world: [f64; 3] = serde_json::from_value(world.clone()).unwrap();
            let image: [f64; 2] = serde_json::from_value(image.clone()).unwrap();
            let found = camera.sensor().project(&Point3::from(world)).unwrap();
            assert!((found - Point2::from(image)).norm() < 1e-9, "{name}: {found} {image:?}");
        }
    }
}

#[test]
fn every_type_images_as_opensfm_does() {
    let read = photographs::read(&oracle("reconstruction.json"), None).unwrap();
    images_as_opensfm_does(&read);
    let models = |name: &str| {
        let found = read.iter().find(|(n, _)| n == name).unwrap();
        found.1.interior.model()
    };
    // Twice as wide as high: a whole panorama, which needs no scale.
    let whole = |name: &str| {
        let found = read.iter().find(|(n, _)| n == name).unwrap();
        matches!(found.1.interior, Interior::Panorama { principal_distance: None, .. })
    };
    assert!(whole("spherical.jpg") && !whole("cut.jpg"));
    // The plainest model that is the same camera, so that other programs may have it too.
    for (name, model) in [
        ("perspective.jpg", "brown"),
        ("opencv.jpg", "fisheye"),
        ("62.jpg", "thin_prism_fisheye"),
        ("62 radial.jpg", "fisheye624"),
        ("624 prism.jpg", "fisheye624"),
        ("dual 0.jpg", "fisheye"),
        ("spherical.jpg", "equirectangular"),
    ] {
        assert_eq!(models(name), model, "{name}");
    }
}

/// What is written is read as the same cameras; `opensfm.py --read` of the file prints the same images.
#[test]
fn every_type_is_written() {
    let read = photographs::read(&oracle("reconstruction.json"), None).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reconstruction.json");
    Reconstruction::from_photographs(&read).unwrap().write(&path).unwrap();
    images_as_opensfm_does(&photographs::read(&path, None).unwrap());
    let written: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    let kind = |name: &str| {
        let camera = written[0]["shots"][name]["camera"].as_str().unwrap();
        written[0]["cameras"][camera]["projection_type"].as_str().unwrap()
    };
    for (name, expected) in [
        ("perspective.jpg", "perspective"),
        ("tall.jpg", "perspective"),
        ("radial.jpg", "brown"),
        ("brown.jpg", "brown"),
        ("fisheye.jpg", "fisheye"),
        ("opencv.jpg", "fisheye_opencv"),
        ("62.jpg", "fisheye62"),
        ("62 radial.jpg", "fisheye62"),
        ("624.jpg", "fisheye624"),
        ("624 prism.jpg", "fisheye624"),
        ("dual 1.jpg", "perspective"),
        ("dual 0.jpg", "fisheye"),
        ("spherical.jpg", "spherical"),
        ("cut.jpg", "spherical"),
    ] {
        assert_eq!(kind(name), expected, "{name}");
    }
    // `dual` with 1 and with 0 are the perspective and the fisheye: 15 photographs of 13 cameras.
    assert_eq!(written[0]["cameras"].as_object().unwrap().len(), 13);
}

#[test]
fn points_and_the_reference_are_written() {
    let read = photographs::read(&oracle("reconstruction.json"), None).unwrap();
    let mut model = Reconstruction::from_photographs(&read[..1]).unwrap();
    let point = ScenePoint { coordinates: [1.5, -2.5, 3.0], color: [1, 20, 255] };
    model.points.insert("7".into(), point);
    let reference = Reference { latitude_deg: 52.5, longitude_deg: 13.25, altitude_m: 34.0 };
    model.reference = Some(reference);
    let text = model.to_json().unwrap();
    let again = parse_reconstruction(&text, 0).unwrap();
    assert_eq!(again.points["7"], point);
    assert_eq!(again.reference, Some(reference));
    let value: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value[0]["points"]["7"]["color"], json!([1.0, 20.0, 255.0]));
    assert_eq!(value[0]["reference_lla"]["longitude"], json!(13.25));
    model.points.insert("8".into(), ScenePoint { coordinates: [f64::NAN, 0.0, 0.0], ..point });
    let error = model.to_json().unwrap_err().to_string();
    assert_eq!(error, "points[\"8\"].coordinates[0]: is NaN, expected a finite number");
}

#[test]
fn a_camera_of_no_type_is_refused_with_its_name() {
    let text = fs::read_to_string(oracle("reconstruction.json")).unwrap();
    let with = |camera: &str, field: &str, value: Value| {
        let mut all: Value = serde_json::from_str(&text).unwrap();
        let fields = all[0]["cameras"][camera].as_object_mut().unwrap();
        if value.is_null() {
            fields.remove(field)
        } else {
            fields.insert(field.into(), value)
        };
        photographs::parse(&all.to_string(), None).unwrap_err().to_string()
    };
    for (camera, field, value, expected) in [
        ("dual 1", "transition", json!(0.5), "transition: is `0.5`: a dual camera is read where"),
        ("dual 1", "transition", Value::Null, "transition: is `0.5`"),
        ("62", "k5", json!(1e-4), "projection_type: is `fisheye62`: its k5, k6, s1 and s3"),
        ("62", "k6", json!(1e-4), "projection_type: is `fisheye62`"),
        ("624", "s1", json!(1e-4), "projection_type: is `fisheye624`"),
        ("624", "s3", json!(1e-4), "projection_type: is `fisheye624`"),
        (
            "brown",
            "projection_type",
            json!("cylindrical"),
            "is `cylindrical`: OpenSfM's perspective",
        ),
        ("brown", "focal_x", Value::Null, "focal_x: is NaN, expected a finite number above 0"),
        ("brown", "focal_y", json!(0), "focal_y: is 0, expected a finite number above 0"),
        ("fisheye", "focal", json!(-1), "focal: is -1, expected"),
        ("spherical", "height", json!(0), "height: is 0, expected at least 1 pixel"),
        ("brown", "p1", json!("many"), "p1: expected a number, found"),
    ] {
        let error = with(camera, field, value);
        assert!(error.contains("[0].cameras") && error.contains(expected), "{error}\n{expected}");
    }
}

#[test]
fn what_opensfm_does_not_have_is_refused_with_the_photograph() {
    let camera = |interior: &str| {
        CameraFile::parse(&format!(
            r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior} }},
            "exterior": {{ "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }} }}"#
        ))
        .unwrap()
    };
    let f = r#""principal_distance": [500, 500], "principal_point": [320, 240]"#;
    let write = |c: &CameraFile| Reconstruction::from_photographs(&[("p.jpg".into(), c.clone())]);
    for (interior, expected) in [
        (
            format!(r#""model": "pinhole", {f}, "skew": 1"#),
            "`pinhole`: OpenSfM's cameras have no skew",
        ),
        (
            format!(r#""model": "rational", {f}, "tau": [0.1, 0]"#),
            "`rational`: OpenSfM has no such",
        ),
        (
            format!(r#""model": "fisheye", "projection": "stereographic", {f}"#),
            "`fisheye`: OpenSfM has no such",
        ),
        (
            format!(r#""model": "fisheye624", "k": [0.1, 0, 0, 0, 0, 0], "p": [0.1, 0], {f}"#),
            "`fisheye624`: OpenSfM's has no second stage",
        ),
        (
            r#""model": "equirectangular", "principal_distance": [100, 101]"#.into(),
            "`equirectangular`: OpenSfM's panorama turns once",
        ),
        (
            r#""model": "equirectangular", "principal_point": [320, 241]"#.into(),
            "`equirectangular`: OpenSfM's panorama turns once",
        ),
        (r#""model": "cylindrical""#.into(), "`cylindrical`: OpenSfM has no such"),
    ] {
        let error = write(&camera(&interior)).unwrap_err().to_string();
        assert!(error.starts_with("p.jpg.interior.model: is "), "{error}");
        assert!(error.contains(expected), "{error}\n{expected}");
    }
    // A principal point off the middle, or two principal distances, are Brown's.
    for interior in [
        format!(r#""model": "pinhole", {f}"#).replace("[500, 500]", "[500, 501]"),
        r#""model": "colmap", "colmap_model": "PINHOLE", "parameters": [500, 500, 321, 240]"#
            .to_owned(),
    ] {
        let text = write(&camera(&interior)).unwrap().to_json().unwrap();
        assert!(text.contains(r#""projection_type": "brown""#), "{text}");
    }
    let pinhole = camera(&format!(r#""model": "pinhole", {f}"#));
    let twice = [("a".to_owned(), pinhole.clone()), ("a".to_owned(), pinhole.clone())];
    let error = Reconstruction::from_photographs(&twice).unwrap_err().to_string();
    assert!(error.contains("is `a` like an earlier photograph's"), "{error}");
    let mut model = write(&pinhole).unwrap();
    let Some(camera) = model.cameras.get_mut("camera 1") else { panic!() };
    camera.interior =
        Interior::Orthographic { pixels_per_unit: [1.0; 2], principal_point: [0.0; 2] };
    let error = model.to_json().unwrap_err().to_string();
    assert!(
        error.starts_with("cameras[\"camera 1\"].interior.model: is `orthographic`"),
        "{error}"
    );
}
