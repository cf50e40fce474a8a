//! Camera files of every central model.

use collinear::camera::{COLMAP_MODELS, SensorModel};
use collinear::geometry::Locus;
use collinear::nalgebra::{Point2, Point3, Vector2};
use collinear_io::Document;
use collinear_io::camera::CameraFile;
use serde_json::Value;

/// A camera at the origin whose axes are the world's.
fn file(interior: &str) -> String {
    format!(
        r#"{{ "collinear": "camera", "version": 1, "width": 1300, "height": 1000,
        "interior": {{ {interior} }},
        "exterior": {{ "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }} }}"#
    )
}

fn parse(interior: &str) -> CameraFile {
    CameraFile::parse(&file(interior)).unwrap_or_else(|e| panic!("{interior}: {e}"))
}

fn see(camera: &CameraFile, [x, y, z]: [f64; 3]) -> Point2<f64> {
    camera.camera().unwrap().sensor().project(&Point3::new(x, y, z)).unwrap()
}

struct Case {
    model: String,
    parameters: Vec<f64>,
    points: Vec<([f64; 3], Point2<f64>)>,
}

/// What OpenCV 5.0.0 and pycolmap 4.2.1 compute; `tests/data/oracles/central_models.py` of the library.
fn cases(program: &str) -> Vec<Case> {
    let text = include_str!("../../tests/data/oracles/central_models.json");
    let all: Value = serde_json::from_str(text).unwrap();
    let numbers = |v: &Value| -> Vec<f64> { serde_json::from_value(v.clone()).unwrap() };
    let case = |c: &Value| {
        let (from, to) = (c["directions"].as_array().unwrap(), c["image"].as_array().unwrap());
        let point = |(d, p): (&Value, &Value)| {
            (numbers(d).try_into().unwrap(), Point2::from_slice(&numbers(p)))
        };
        Case {
            model: c["model"].as_str().unwrap().into(),
            parameters: numbers(&c["parameters"]),
            points: from.iter().zip(to).map(point).collect(),
        }
    };
    all["cases"].as_array().unwrap().iter().filter(|c| c["program"] == program).map(case).collect()
}

/// The file, read and written and read, gives the program's pixels and their directions.
fn agrees(interior: &str, case: &Case, shift: f64) {
    let camera = parse(interior);
    let again = CameraFile::parse(&camera.to_json().unwrap()).unwrap();
    assert_eq!(again, camera);
    assert!(case.points.len() >= 4);
    for (direction, image) in &case.points {
        let ours = see(&again, *direction);
        let off = (ours - Vector2::repeat(shift) - image).norm();
        assert!(off < 1e-9, "{interior}: {ours} for {image}");
        let model = again.camera().unwrap();
        let locus = model.sensor().locus(&ours).unwrap();
        let Locus::Ray(ray) = locus else { panic!("{locus:?}") };
        let expected = Point3::from(*direction).coords.normalize();
        assert!((ray.direction.into_inner() - expected).norm() < 1e-12, "{interior}");
    }
}

/// The fields of an interior orientation with x₀, y₀ as the file has them.
fn pixels(model: &str, fx: f64, fy: f64, x: f64, y: f64) -> String {
    format!(
        r#""model": "{model}", "principal_distance": [{fx:?}, {fy:?}], "principal_point": [{x:?}, {y:?}]"#
    )
}

#[test]
fn files_of_opencvs_models_project_as_opencv_does() {
    let cases = cases("OpenCV");
    assert_eq!(cases.len(), 6);
    for case in &cases {
        let &[fx, fy, cx, cy, ref rest @ ..] = &case.parameters[..] else { panic!() };
        // OpenCV's pixel (0, 0) is the centre of the first pixel.
        let interior = |model| pixels(model, fx, fy, cx + 0.5, cy + 0.5);
        if case.model == "fisheye" {
            agrees(&format!(r#"{}, "k": {rest:?}"#, interior("fisheye")), case, 0.5);
            continue;
        }
        let mut c = [0.0; 14];
        c[..rest.len()].copy_from_slice(rest);
        let k = [c[0], c[1], c[4], c[5], c[6], c[7]];
        let lens = format!(r#""k": {k:?}, "p": {:?}"#, &c[2..4]);
        // What is zero may be left out.
        let prism = format!(r#", "s": {:?}"#, &c[8..12]);
        let tilt = format!(r#", "tau": {:?}"#, &c[12..]);
        let more = match rest.len() {
            12 => prism,
            14 => prism + &tilt,
            _ => String::new(),
        };
        agrees(&format!("{}, {lens}{more}", interior("rational")), case, 0.5);
    }
}

#[test]
fn files_with_colmaps_names_project_as_colmap_does() {
    let cases = cases("pycolmap");
    assert_eq!(cases.len(), COLMAP_MODELS.len());
    for case in &cases {
        let (model, parameters) = (&case.model, &case.parameters);
        let colmap = format!(
            r#""model": "colmap", "colmap_model": "{model}", "parameters": {parameters:?}"#
        );
        agrees(&colmap, case, 0.0);
    }
}

#[test]
fn files_of_our_own_names_project_as_colmap_does() {
    let cases = cases("pycolmap");
    let mut checked = 0;
    for case in &cases {
        let c = &case.parameters;
        let one = ["SIMPLE_PINHOLE", "SIMPLE_DIVISION", "SIMPLE_FISHEYE"];
        let simple = one.contains(&&*case.model) || case.model.contains("RADIAL");
        let (distance, point, rest) = match c[..] {
            [w, h] => ([w, h], [0.0; 2], &[][..]),
            [f, x, y, ref rest @ ..] if simple => ([f, f], [x, y], rest),
            [fx, fy, x, y, ref rest @ ..] => ([fx, fy], [x, y], rest),
            _ => panic!(),
        };
        let interior = |model| pixels(model, distance[0], distance[1], point[0], point[1]);
        let text = match (&*case.model, rest) {
            ("PINHOLE" | "SIMPLE_PINHOLE", _) => interior("pinhole"),
            ("SIMPLE_RADIAL", [k]) => format!(r#"{}, "k": [{k:?}, 0, 0]"#, interior("brown")),
            ("OPENCV", [k1, k2, p @ ..]) => {
                format!(r#"{}, "k": [{k1:?}, {k2:?}, 0], "p": {p:?}"#, interior("brown"))
            }
            ("FISHEYE", _) => format!(r#"{}, "projection": "equidistant""#, interior("fisheye")),
            ("OPENCV_FISHEYE", k) => format!(r#"{}, "k": {k:?}"#, interior("fisheye")),
            ("THIN_PRISM_FISHEYE", [k1, k2, p1, p2, k3, k4, s @ ..]) => format!(
                r#"{}, "k": {:?}, "p": {:?}, "s": {s:?}"#,
                interior("thin_prism_fisheye"),
                [k1, k2, k3, k4],
                [p1, p2]
            ),
            ("RAD_TAN_THIN_PRISM_FISHEYE", v) => format!(
                r#"{}, "k": {:?}, "p": {:?}, "s": {:?}"#,
                interior("fisheye624"),
                &v[..6],
                &v[6..8],
                &v[8..]
            ),
            ("FOV", [omega]) => format!(r#"{}, "omega": {omega:?}"#, interior("field_of_view")),
            ("DIVISION", [k]) => format!(r#"{}, "lambda": {k:?}"#, interior("division")),
            ("EUCM", [a, b]) => {
                format!(r#"{}, "alpha": {a:?}, "beta": {b:?}"#, interior("enhanced_unified"))
            }
            ("EQUIRECTANGULAR", _) => {
                let tau = std::f64::consts::TAU;
                let [w, h] = distance;
                pixels("equirectangular", w / tau, 2.0 * h / tau, w / 2.0, h / 2.0)
            }
            _ => continue,
        };
        agrees(&text, case, 0.0);
        checked += 1;
    }
    assert_eq!(checked, 12);
}

#[test]
fn files_of_the_other_models_project_as_their_papers_say() {
    let all: Value = serde_json::from_str(include_str!("oracles/camera_files.json")).unwrap();
    let cases = all.as_array().unwrap();
    assert_eq!(cases.len(), 10);
    for case in cases {
        let point = |p: &Value| {
            let pair = |v: &Value| serde_json::from_value::<Vec<f64>>(v.clone()).unwrap();
            (pair(&p["direction"]).try_into().unwrap(), Point2::from_slice(&pair(&p["image"])))
        };
        let points = case["points"].as_array().unwrap().iter().map(point).collect();
        let none = Case { model: String::new(), parameters: Vec::new(), points };
        agrees(case["interior"].as_str().unwrap(), &none, 0.0);
    }
}

#[test]
fn a_panorama_without_pixels_is_a_full_turn() {
    // A quarter turn to the right of the middle, and an eighth up; 1300 and 1000 pixels.
    let whole = parse(r#""model": "equirectangular""#);
    assert!((see(&whole, [2.0, 0.0, 0.0]) - Point2::new(975.0, 500.0)).norm() < 1e-12);
    assert!((see(&whole, [0.0, -3.0, 3.0]) - Point2::new(650.0, 250.0)).norm() < 1e-12);
    // Up by one radius is 1300/2π pixels.
    let cylinder = parse(r#""model": "cylindrical", "principal_point": [650, 700]"#);
    let expected = Point2::new(325.0, 700.0 - 206.90142601946397);
    assert!((see(&cylinder, [-3.0, -3.0, 0.0]) - expected).norm() < 1e-12);
    assert_eq!(CameraFile::parse(&cylinder.to_json().unwrap()).unwrap(), cylinder);
}

#[test]
fn a_model_has_its_own_fields_and_numbers_of_its_own_domain() {
    const PIXELS: &str = r#""principal_distance": [600, 600], "principal_point": [650, 500]"#;
    let read = |fields: &str| CameraFile::parse(&file(fields));
    let error = |fields: &str| match read(&fields.replace("PIXELS", PIXELS)) {
        Ok(camera) => camera.camera().unwrap_err().to_string(),
        Err(e) => e.to_string(),
    };
    for (fields, expected) in [
        (
            r#""model": "fisheye", PIXELS, "k": [0, 0, 0]"#,
            "interior: the model `fisheye` has a `k` of 4 numbers, found 3 (line 2, ",
        ),
        (
            r#""model": "brown", PIXELS, "k": [0, 0, 0, 0]"#,
            "interior: the model `brown` has a `k` of 3 numbers, found 4 (line 2, ",
        ),
        (
            r#""model": "rational", PIXELS, "k": [0, 0, 0, 0, "x", 0]"#,
            r#"interior.k[4]: expected a number, found the string "x" (line 2, "#,
        ),
        (
            r#""model": "fisheye", PIXELS, "p": [0, 0]"#,
            "interior: the model `fisheye` has no `p`: remove it or change the model",
        ),
        (
            r#""model": "fisheye", PIXELS, "projection": "gnomonic""#,
            "interior.projection: expected one of `equidistant`, `stereographic`, `equisolid`, `orthographic`",
        ),
        (
            r#""model": "double_sphere", PIXELS, "alpha": 0.5"#,
            "interior: the model `double_sphere` needs `xi`",
        ),
        (
            r#""model": "double_sphere", PIXELS, "alpha": 1.5, "xi": 0"#,
            "interior.alpha: alpha of the projection is 1.5, expected between 0 and 1",
        ),
        (
            r#""model": "unified", PIXELS, "k": [0, 0, 0], "xi": -1"#,
            "interior.xi: xi of the unified projection is -1, expected ",
        ),
        (
            r#""model": "rational", PIXELS, "tau": [0, 2]"#,
            "interior.tau: tilt of the sensor is 2, expected ",
        ),
        (
            r#""model": "fraser", PIXELS, "principal_distance_mm": 0"#,
            "interior.principal_distance_mm: is 0, expected a number from 1e-6 to 1e9",
        ),
        (
            r#""model": "fisheye", PIXELS, "k": [-1e308, 0, 0, 0]"#,
            "interior.k: distortion coefficient is -1e308, expected at most 1e30 in magnitude",
        ),
        (
            r#""model": "cylindrical", "principal_distance": [0, 1]"#,
            "interior.principal_distance[0]: is 0, expected a number from 1e-6 to 1e9 (pixels)",
        ),
        (
            r#""model": "equirectangular", "skew": 1"#,
            "interior: the model `equirectangular` has no `skew`",
        ),
        (
            r#""model": "colmap", "colmap_model": "PINHOLE""#,
            "interior: the model `colmap` needs `parameters`",
        ),
        (
            r#""model": "colmap", "colmap_model": "PINHOLE", "parameters": [1, 2, 3]"#,
            "interior.parameters: has 3 entries, 4 are needed: one for each of the COLMAP model's parameters",
        ),
        (
            r#""model": "colmap", "colmap_model": "PINHOLE", "parameters": [1, 0, 3, 4]"#,
            "interior.parameters[1]: is 0, expected a number from 1e-6 to 1e9 (pixels)",
        ),
        (
            r#""model": "colmap", "colmap_model": "pinhole", "parameters": []"#,
            "interior.colmap_model: names a COLMAP camera model `pinhole`, which is not there: there are `SIMPLE_PINHOLE`",
        ),
        (
            r#""model": "colmap", "colmap_model": "EUCM", "parameters": [1, 1, 0, 0, 2, 1], PIXELS"#,
            "interior: the model `colmap` has no `principal_distance`",
        ),
        (
            r#""model": "colmap", "colmap_model": "EUCM", "parameters": [1, 1, 0, 0, 2, 1]"#,
            "interior.parameters: alpha of the projection is 2",
        ),
        (
            r#""model": "pinhole", PIXELS, "omega": 1"#,
            "interior: the model `pinhole` has no `omega`",
        ),
    ] {
        let error = error(fields);
        assert!(error.starts_with(expected), "{fields}:\n{error}");
    }
}

#[test]
fn only_cameras_with_browns_lens_or_none_are_frames_of_it() {
    let error = parse(r#""model": "equirectangular""#).frame().unwrap_err().to_string();
    let told = "interior.model: is `equirectangular`: a camera `pinhole` or `brown` is needed";
    assert!(error.starts_with(told), "{error}");
    let mut frames = Vec::new();
    for Case { model, parameters, points } in cases("pycolmap") {
        let colmap = format!(
            r#""model": "colmap", "colmap_model": "{model}", "parameters": {parameters:?}"#
        );
        let Ok(frame) = parse(&colmap).frame() else { continue };
        for ([x, y, z], image) in points {
            let ours = frame.project(&Point3::new(x, y, z)).unwrap();
            assert!((ours - image).norm() < 1e-9, "{model}: {ours} for {image}");
        }
        frames.push(model);
    }
    assert_eq!(frames, ["SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV"]);
}
