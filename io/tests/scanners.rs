//! Scanner files: the sensors of the library's oracle, and what is refused.

use collinear::nalgebra::{Point2, Point3};
use collinear_io::Document;
use collinear_io::scanner::ScannerFile;
use collinear_io::sensor::SensorFile;
use serde_json::{Value, json};

/// What mpmath computes; `tests/data/oracles/scanning.py` of the library.
fn cases() -> Vec<Value> {
    let text = include_str!("../../tests/data/oracles/scanning.json");
    let all: Value = serde_json::from_str(text).unwrap();
    all["cases"].as_array().unwrap().clone()
}

/// The oracle's case as a file.
fn file(case: &Value, kind: &str) -> Value {
    let (parameters, trajectory) = (&case["parameters"], &case["trajectory"]);
    let threes = |v: &Value| -> Vec<Vec<Value>> {
        v.as_array().unwrap().chunks(3).map(<[Value]>::to_vec).collect()
    };
    let nodes = |v: &Value| v.as_u64().map_or(Value::Null, |n| json!(n));
    let without_null = |mut v: Value| {
        v.as_object_mut().unwrap().retain(|_, v| !v.is_null());
        v
    };
    let base = &trajectory["base"];
    let mut path = json!({
        "reference_time": trajectory["origin"],
        "time_unit": trajectory["unit"],
        "position_polynomial": threes(&parameters["position"]),
        "attitude_polynomial": threes(&parameters["attitude"]),
    });
    if base["center"].is_array() {
        path["exterior"] =
            json!({ "projection_center": base["center"], "quaternion_wxyz": base["quaternion"] });
    } else {
        path["ephemeris"] = without_null(json!({
            "position_times": base["position_times"],
            "positions": base["positions"],
            "position_nodes": nodes(&base["positions_between"]),
            "attitude_times": base["attitude_times"],
            "quaternions_wxyz": base["attitudes"],
            "attitude_nodes": nodes(&base["attitudes_between"]),
        }));
    }
    let (i, lens) = (&parameters["interior"], &parameters["lens"]);
    let mut scan = json!({ "kind": kind, "start": case["start"] });
    for (field, kinds) in [
        ("row", &["pushbroom", "strip", "whiskbroom"][..]),
        ("per_line", &["pushbroom", "strip", "whiskbroom", "rolling_shutter"]),
        ("per_column", &["whiskbroom", "panoramic"]),
    ] {
        if kinds.contains(&kind) {
            scan[field] = case[field].clone();
        }
    }
    let interior = if case["camera"] == "brown" {
        json!({
            "model": "brown",
            "principal_distance": [i[0], i[1]], "principal_point": [i[2], i[3]], "skew": i[4],
            "k": [lens[0], lens[1], lens[2]], "p": [lens[3], lens[4]],
        })
    } else {
        json!({
            "model": "cylindrical",
            "principal_distance": [i[0], i[1]], "principal_point": [i[2], i[3]],
        })
    };
    if kind == "panoramic" {
        scan["compensation"] = lens[0].clone();
    }
    json!({
        "collinear": "scanner", "version": 1,
        "width": case["extent"][0][1], "height": case["extent"][1][1],
        "scan": scan, "interior": interior, "trajectory": path,
    })
}

const KINDS: [&str; 7] =
    ["pushbroom", "strip", "pushbroom", "pushbroom", "panoramic", "whiskbroom", "rolling_shutter"];

#[test]
fn scanner_files_project_as_sixty_digits_do() {
    let cases = cases();
    assert_eq!(cases.len(), KINDS.len());
    for (case, kind) in cases.iter().zip(KINDS) {
        let mut case = case.clone();
        if kind == "whiskbroom" {
            // A panorama's file has no skew, which is 0.2 here: 0.2 y at the row, 6 of 2000, that is 0.0006 px.
            case["parameters"]["interior"][2] = json!(1500.0 + 0.2 * 6.0 / 2000.0);
        }
        let text = file(&case, kind).to_string();
        let parsed = ScannerFile::parse(&text).unwrap_or_else(|e| panic!("{kind}: {e}"));
        let again = ScannerFile::parse(&parsed.to_json().unwrap()).unwrap();
        assert_eq!(again, parsed);
        let SensorFile::Scanner(read) = SensorFile::parse(&text).unwrap() else { panic!() };
        assert_eq!(*read, parsed);
        let sensor = again.sensor().unwrap();
        for point in case["points"].as_array().unwrap() {
            let world: [f64; 3] = serde_json::from_value(point["world"].clone()).unwrap();
            let image: [f64; 2] = serde_json::from_value(point["image"].clone()).unwrap();
            let found = sensor.project(&Point3::from(world)).unwrap();
            let off = (found - Point2::from(image)).norm();
            assert!(off < 1e-9, "{kind}: {found} for {image:?}");
        }
    }
}

#[test]
fn scanner_files_are_refused_with_the_field() {
    let cases = cases();
    let good = file(&cases[0], "pushbroom");
    let says = |value: &Value, expected: &str| {
        let error = ScannerFile::parse(&value.to_string())
            .and_then(|f| f.sensor().map(|_| ()))
            .expect_err(expected)
            .to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    let with = |path: &[&str], value: Value| {
        let mut changed = good.clone();
        let (last, before) = path.split_last().unwrap();
        let mut at = &mut changed;
        for key in before {
            at = &mut at[*key];
        }
        at[*last] = value;
        changed
    };
    let without = |path: &[&str]| {
        let mut changed = good.clone();
        let (last, before) = path.split_last().unwrap();
        let mut at = &mut changed;
        for key in before {
            at = &mut at[*key];
        }
        at.as_object_mut().unwrap().remove(*last);
        changed
    };
    says(&with(&["width"], json!(0)), "width: ");
    says(&with(&["scan", "kind"], json!("sonar")), "scan.kind: expected one of `pushbroom`");
    says(&with(&["scan", "per_line"], json!(0)), "scan.per_line: ");
    says(&with(&["scan", "per_line"], json!(1e-30)), "scan: scan time is 0, expected an interval");
    says(&with(&["scan", "start"], json!(1.4e9)), "scan: spacing of floats in lines");
    says(&with(&["scan", "per_column"], json!(1)), "a scan `pushbroom` has no `per_column`");
    says(&with(&["scan", "margin"], json!(-1)), "scan.margin: ");
    says(&with(&["scan", "rows"], json!(3)), "scan.rows: unknown field, did you mean `row`?");
    says(&without(&["scan", "row"]), "a scan `pushbroom` needs `row`");
    says(&with(&["interior", "model"], json!("orthographic")), "the model `orthographic` has no");
    says(&without(&["trajectory", "exterior"]), "a trajectory needs `exterior` or `ephemeris`");
    says(&with(&["trajectory", "time_unit"], json!(0)), "trajectory.time_unit: ");
    says(
        &with(&["trajectory", "exterior", "quaternion_wxyz"], json!([1, 1, 0, 0])),
        "trajectory.exterior.quaternion_wxyz: ",
    );
    says(
        &with(&["trajectory", "position_polynomial"], json!([[0, 0]])),
        "trajectory.position_polynomial[0]: ",
    );
    says(&with(&["trajectory"], json!([1, 2])), "trajectory: ");
    let panoramic = with(&["scan"], json!({ "kind": "panoramic", "per_column": 1e-3 }));
    says(&panoramic, "interior.model: ");

    let table = file(&cases[3], "pushbroom");
    let with = |field: &str, value: Value| {
        let mut changed = table.clone();
        changed["trajectory"]["ephemeris"][field] = value;
        changed
    };
    says(&with("positions", json!([[0, 0, 0]])), "trajectory.ephemeris.positions: ");
    says(&with("position_nodes", json!(5)), "trajectory.ephemeris: nodes of an interpolation is 5");
    says(&with("attitude_nodes", json!(4_000_000_000_u32)), "nodes of an interpolation is 4e9");
    says(&with("attitude_nodes", json!(-1)), "trajectory.ephemeris.attitude_nodes");
    let mut both = table.clone();
    both["trajectory"]["exterior"] = good["trajectory"]["exterior"].clone();
    says(&both, "a trajectory has one of `exterior` and `ephemeris`, found both");
    let mut long = table.clone();
    long["height"] = json!(100_000);
    says(&long, "scan: time of the scan is 200");
    let mut backwards = table;
    backwards["trajectory"]["ephemeris"]["position_times"][7] = json!(9.0);
    says(&backwards, "trajectory.ephemeris: times of positions is");
}
