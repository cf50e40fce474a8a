//! OpenSfM's reconstructions and tracks.

use std::collections::BTreeMap;

use collinear::camera::{BrownCamera, Frame, SensorModel};
use collinear::nalgebra::{Point2, Point3};
use collinear_io::camera::{CameraFile, Interior, Rotation};
use collinear_io::opensfm::{parse_reconstruction, parse_tracks, read_reconstruction, read_tracks};
use collinear_io::{ErrorKind, FieldProblem};

const TEXT: &str = r#"[{
"cameras": { "v2 phone": { "projection_type": "perspective", "width": 3000, "height": 4000, "focal": 0.8, "k1": 0.1, "k2": -0.2 } },
"shots": { "01.jpg": { "camera": "v2 phone", "rotation": [0, 0, 1.5707963267948966], "translation": [1, 2, 3], "gps_dop": 5.0 } },
"points": { "7": { "coordinates": [1, 2, 3], "color": [36.0, 254.6, 300.0] } },
"reference_lla": { "latitude": 52.5, "longitude": 13.4, "altitude": 0.0 }, "biases": {}
}]"#;

fn error(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "{from} is not in the template");
    parse_reconstruction(&TEXT.replacen(from, to, 1), 0).unwrap_err().to_string()
}

#[test]
fn a_reconstruction_gives_its_cameras_in_pixels() {
    let r = parse_reconstruction(TEXT, 0).unwrap();
    let camera = r.camera("01.jpg").unwrap();
    assert_eq!((camera.width, camera.height), (3000, 4000));
    // The longer side is the height here: 0.8 · 4000.
    assert_eq!(
        camera.interior,
        Interior::Brown {
            principal_distance: [3200.0; 2],
            principal_point: [1500.0, 2000.0],
            skew: 0.0,
            k: [0.1, -0.2, 0.0],
            p: [0.0; 2],
        }
    );
    // A quarter turn about z takes (x, y) to (−y, x); C = −Rᵀ t = −(2, −1, 3).
    let center = camera.exterior.projection_center;
    for (got, expected) in center.iter().zip([-2.0, 1.0, -3.0]) {
        assert!((got - expected).abs() < 1e-15, "{center:?}");
    }
    let Rotation::QuaternionWxyz(q) = camera.exterior.rotation else { panic!("a quaternion") };
    let half = 0.5_f64.sqrt();
    for (got, expected) in q.iter().zip([half, 0.0, 0.0, half]) {
        assert!((got - expected).abs() < 1e-15, "{q:?}");
    }
    assert_eq!(r.points["7"].color, [36, 255, 255]);
    assert_eq!(r.reference.unwrap().latitude_deg, 52.5);
}

#[test]
fn what_cannot_be_used_is_named() {
    assert_eq!(
        error("\"perspective\"", "\"cubic\""),
        "[0].cameras[\"v2 phone\"].projection_type: is `cubic`: OpenSfM's perspective, simple_radial, radial, brown, fisheye, fisheye_opencv, fisheye62, fisheye624, dual and spherical are read"
    );
    assert_eq!(
        error("\"camera\": \"v2 phone\"", "\"camera\": \"v1\""),
        "[0].shots[\"01.jpg\"].camera: names a camera `v1`, which is not there: there are `v2 phone`"
    );
    assert_eq!(
        error("0.8", "-0.8"),
        "[0].cameras[\"v2 phone\"].focal: is -0.8, expected a finite number above 0"
    );
    assert!(
        error("[1, 2, 3]", "[1, 2]").starts_with(
            "[0].shots[\"01.jpg\"].translation: expected a list of 3, found 2 entries"
        )
    );
    assert!(error("3000", "3e3").starts_with(
        "[0].cameras[\"v2 phone\"].width: expected a whole number from 0, found 3000.0"
    ));
    let none = parse_reconstruction(TEXT, 1).unwrap_err();
    assert_eq!(none.to_string(), "holds 1 reconstructions, number 1 (from 0) is not among them");
    let r = parse_reconstruction(TEXT, 0).unwrap();
    let unknown = r.camera("02.jpg").unwrap_err();
    assert!(
        matches!(unknown.kind(), ErrorKind::Field(e) if matches!(&e.problem, FieldProblem::UnknownName { .. }))
    );
    assert!(
        parse_reconstruction(&TEXT.replace("1.5707963267948966", "1e200"), 0)
            .unwrap()
            .camera("01.jpg")
            .is_err()
    );
}

#[test]
fn tracks_of_all_versions_are_read_and_later_ones_refused() {
    for text in [
        "a.jpg\t7\t12\t0.25\t-0.125\t1\t2\t3\n",
        "OPENSFM_TRACKS_VERSION_v1\na.jpg\t7\t12\t0.25\t-0.125\t0.001\t1\t2\t3\n",
        "OPENSFM_TRACKS_VERSION_v2\r\na.jpg\t7\t12\t0.25\t-0.125\t0.001\t1\t2\t3\t-1\t-1\r\n\r\n",
    ] {
        let all = parse_tracks(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(all.len(), 1);
        let seen = &all[0];
        assert_eq!(
            (seen.image.as_str(), seen.track.as_str(), seen.feature, seen.color),
            ("a.jpg", "7", 12, [1, 2, 3])
        );
        assert_eq!(seen.pixel(400, 300), [300.0, 100.0]);
        assert_eq!(seen.pixel(300, 400), [250.0, 150.0]);
    }
    for (text, expected) in [
        (
            "OPENSFM_TRACKS_VERSION_v3\n",
            "line 1: says `OPENSFM_TRACKS_VERSION_v3`, expected OPENSFM_TRACKS_VERSION_v1 or _v2: write the tracks with one of these",
        ),
        ("OPENSFM_TRACKS_VERSION_v2\na\t7\n", "line 2: has 2 fields, expected 11"),
        (
            "OPENSFM_TRACKS_VERSION_v1\na.jpg\t7\t12\t0.25\tx\t0.001\t1\t2\t3\n",
            "line 2, field 5: y is `x`, expected a finite number",
        ),
        (
            "a.jpg\t7\t12\t0.25\tnan\t1\t2\t3\n",
            "line 1, field 5: y is `nan`, expected a finite number",
        ),
    ] {
        assert_eq!(parse_tracks(text).unwrap_err().to_string(), expected);
    }
    assert!(parse_tracks("").unwrap().is_empty());
}

/// The reprojection of every observation whose point was reconstructed.
#[test]
fn the_residuals_of_the_berlin_reconstruction_are_its_own() {
    let Some(folder) = crate::shared_data("berlin") else { return };
    let reconstruction =
        read_reconstruction(&folder.join("reconstruction_example.json"), 0).unwrap();
    let tracks = read_tracks(&folder.join("tracks_example.csv")).unwrap();
    let cameras: BTreeMap<&str, (CameraFile, Frame<BrownCamera>)> = reconstruction
        .shots
        .keys()
        .map(|name| {
            let file = reconstruction.camera(name).unwrap();
            let frame = file.frame().unwrap();
            (name.as_str(), (file, frame))
        })
        .collect();
    let mut errors: Vec<f64> = tracks
        .iter()
        .filter_map(|seen| {
            let point = reconstruction.points.get(&seen.track)?;
            let (file, frame) = &cameras[seen.image.as_str()];
            let image = frame.project(&Point3::from(point.coordinates)).unwrap();
            Some((image - Point2::from(seen.pixel(file.width, file.height))).norm())
        })
        .collect();
    assert_eq!((tracks.len(), errors.len()), (3219, 3082));
    errors.sort_by(f64::total_cmp);
    let median = (errors[1540] + errors[1541]) / 2.0;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 3082.0).sqrt();
    // oracles/berlin_reprojection.py, from the two files alone: Python 3, numpy 2.4.6.
    for (got, expected) in
        [(median, 0.7964399410605569), (rms, 2.46476313951413), (errors[3081], 37.120236472732586)]
    {
        assert!((got - expected).abs() < 1e-9, "{got}, {expected}");
    }
}
