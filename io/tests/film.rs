//! Scanned photographs of film cameras.

use collinear::nalgebra::Point3;
use collinear_io::Document;
use collinear_io::camera::CameraFile;

/// A film scanned at 20 µm a pixel and a quarter turn to the right: film x runs down the scan, y to the right.
fn turned(fiducials: &str) -> String {
    format!(
        r#"{{ "collinear": "camera", "version": 1, "width": 11500, "height": 11500,
        "interior": {{ "model": "film", "principal_distance_mm": 153.24, "principal_point_mm": [0.1, -0.2],
        "fiducials": [{fiducials}] }},
        "exterior": {{ "projection_center": [0, 0, 1532.4], "omega_phi_kappa": [0, 0, 0] }} }}"#
    )
}

const MARKS: &str =
    "[-106, 0, 5750, 450], [106, 0, 5750, 11050], [0, 106, 11050, 5750], [0, -106, 450, 5750]";

#[test]
fn the_marks_say_where_the_film_is_on_the_scan() {
    let file = CameraFile::parse(&turned(MARKS)).unwrap();
    let camera = file.camera().unwrap();
    // From 1532.4 a point at X = 200, Y = 100 is at (20, 10) mm of the principal point: (20.1, 9.8) of the marks, and
    // 50 px/mm: 1005 down and 490 to the right of the middle.
    let p = camera.sensor().project(&Point3::new(200.0, 100.0, 0.0)).unwrap();
    assert!((p.x - 6240.0).abs() < 1e-9 && (p.y - 6755.0).abs() < 1e-9, "{p}");
    assert_eq!(CameraFile::parse(&file.to_json().unwrap()).unwrap(), file);
}

#[test]
fn marks_that_say_nothing_are_refused() {
    for (marks, message) in [
        ("[0, 0, 1, 1], [1, 0, 2, 1]", "interior.fiducials: is 2, expected 3 marks or more"),
        ("[0, 0, 1, 1], [1, 0, 2, 1], [0, 1, 1, 1e300]", "interior.fiducials[2][3]: is 1e300"),
        ("[0, 0, 1, 1], [1, 0, 2, 1], [0, 1, 1]", "interior.fiducials[2]"),
    ] {
        let error = CameraFile::parse(&turned(marks)).unwrap_err().to_string();
        assert!(error.contains(message), "{marks}: {error}");
    }
    let line = turned("[0, 0, 1, 1], [1, 1, 2, 2], [2, 2, 3, 3]");
    let error = CameraFile::parse(&line).unwrap().camera().unwrap_err().to_string();
    assert!(error.contains("interior.fiducials: affine fit: points on one line"), "{error}");
}
