//! `collinear resect` and `collinear intersect`.

use serde_json::Value;

use crate::support::Folder;

/// A film scanned at 20 µm a pixel, its middle at pixel (5750, 5750); no exterior orientation.
const CAMERA: &str = r#"{ "collinear": "camera", "version": 1, "width": 11500, "height": 11500,
  "interior": { "model": "pinhole", "principal_distance": [7662, 7662], "principal_point": [5750, 5750] } }"#;

/// The four points of Wuhan University's textbook: photo millimetres x right, y up, and the ground.
const WUHAN: [([f64; 2], [f64; 3]); 4] = [
    ([-86.15, -68.99], [36589.41, 25273.32, 2195.17]),
    ([-53.40, 82.21], [37631.08, 31324.51, 728.69]),
    ([-14.78, -76.63], [39100.97, 24934.98, 2386.50]),
    ([10.46, 64.43], [40426.54, 30319.81, 757.31]),
];

fn folder() -> Folder {
    let folder = Folder::new();
    let mut control = String::from("id,X,Y,Z,x,y\n");
    for (i, ([x, y], [e, n, h])) in WUHAN.into_iter().enumerate() {
        control += &format!("p{},{e},{n},{h},{},{}\n", i + 1, 5750.0 + 50.0 * x, 5750.0 - 50.0 * y);
    }
    control += "unseen,36000,25000,1000,,\n";
    folder.write("camera.json", CAMERA).write("control.csv", control);
    folder
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_textbook_photograph_is_resected() {
    let folder = folder();
    let run = folder.succeed(&[
        "resect",
        "control.csv",
        "--camera",
        "camera.json",
        "-o",
        "out.json",
        "--svg",
        "r.svg",
        "--json",
    ]);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    // Published: 39795.45, 27476.46, 7572.69; φ −0.0039869 about Y first, σ₀ 7.26 µm: 0.363 of a pixel of 20 µm.
    let values: Vec<f64> =
        report["unknowns"].as_array().unwrap().iter().map(|u| number(&u["value"])).collect();
    for (value, published) in values.iter().zip([39795.45, 27476.46, 7572.69]) {
        assert!((value - published).abs() < 0.005, "{value}");
    }
    assert!((number(&report["sigma0"]) - 0.363).abs() < 5e-4);
    assert_eq!((number(&report["redundancy"]), number(&report["observations"])), (2.0, 8.0));
    let sum: f64 = report["points"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|p| p["tests"].as_array().unwrap())
        .map(|t| number(&t["redundancy"]))
        .sum();
    assert!((sum - 2.0).abs() < 1e-9, "{sum}");
    // The camera written stands there, and projects the points to where they were measured.
    let run = folder.succeed(&["project", "--camera", "out.json", "control.csv"]);
    let second: Vec<&str> = run.stdout.lines().nth(2).unwrap().split(',').collect();
    let x: f64 = second[4].parse().unwrap();
    assert!((x - 3080.0).abs() < 1.0, "{x}");
    let svg = folder.text("r.svg");
    assert_eq!(svg.matches("<circle").count(), 4);
    assert!(svg.contains("times as long") && svg.contains(">p4<"), "{svg}");
}

#[test]
fn the_protocol_is_a_table() {
    let folder = folder();
    let text = folder.succeed(&["resect", "control.csv", "--camera", "camera.json"]).stdout;
    for line in [
        "control points   4, 1 without an image",
        "observations     8, unknowns 6, redundancy 2",
        "sigma 0          0.3630 (1 if the stated precisions are right)",
        // Standard deviations by the computation of tests/data/oracles/resection.py, of σ₀ from the residuals.
        "  X        39795.45      1.11",
        "  Y        27476.46      1.25",
        "  Z        7572.686     0.488",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let folder = folder();
    folder
        .write("one.csv", "0,0,0,1,1\n")
        .write("three.csv", "0,0,0,1,1\n1,0,0,2,1\n0,1,0,1,2\n")
        .write("line.csv", "0,0,0,1,1\n1,1,1,2,2\n2,2,2,3,3\n3,3,3,4,4\n5,5,5,6,6\n")
        .write("twice.csv", "X,Y,Z,x,y,x\n")
        .write("half.csv", "X,Y,Z,x,y,sigma_X\n")
        .write("weight.csv", "X,Y,Z,x,y,sigma\n1,2,3,4,5,0\n")
        .write(
            "parallel.json",
            CAMERA.replace(
                r#""model": "pinhole", "principal_distance": [7662, 7662]"#,
                r#""model": "orthographic", "pixels_per_unit": [2, 2]"#,
            ),
        );
    for (arguments, code, message) in [
        (&["three.csv", "-c", "camera.json"][..], 1, "three.csv: 3 points given, 4 needed"),
        (
            &["line.csv", "-c", "camera.json"],
            1,
            "line.csv: degenerate: control points on a line (measure ",
        ),
        (
            &["twice.csv", "-c", "camera.json"],
            1,
            "twice.csv: line 1, field 6: the column `x` stands there twice",
        ),
        (
            &["half.csv", "-c", "camera.json"],
            1,
            "expected the columns all of sigma_X, sigma_Y, sigma_Z",
        ),
        (
            &["weight.csv", "-c", "camera.json"],
            1,
            "line 2, field 6: sigma is 0, expected a number above 0",
        ),
        (
            &["control.csv", "-c", "parallel.json"],
            1,
            "a parallel projection has no projection centre",
        ),
        (&["control.csv", "-c", "camera.json", "--estimate", "k7"], 2, "`k7` is none of distance"),
        (
            &["control.csv", "-c", "camera.json", "--estimate", "distance,point,k1,k2"],
            1,
            "control.csv: 4 points given, 6 needed",
        ),
        (
            &["control.csv", "-c", "camera.json", "--estimate", "k1,p,k1"],
            2,
            "--estimate: `k1` is chosen twice",
        ),
        (
            &["control.csv", "-c", "camera.json", "--sigma", "-1"],
            2,
            "'--sigma <PIXELS>': expected a finite number above 0",
        ),
        (
            &["control.csv", "-c", "camera.json", "--robust", "1e9"],
            2,
            "'--robust [<SIGMAS>]': expected a number from 0.1 to 1000",
        ),
        (
            &["control.csv", "-c", "camera.json", "--robust", "-3"],
            2,
            "'--robust [<SIGMAS>]': expected a number from 0.1 to 1000",
        ),
        (
            &["control.csv", "-c", "camera.json", "--robust", "1000", "--sigma", "10"],
            1,
            "within 10000 px, 1000 standard deviations, points agree by chance",
        ),
        (&["one.csv", "-c", "camera.json"], 1, "one.csv: 1 point given, 4 needed"),
        (&["control.csv", "-c", "camera.json", "-o", "camera.json"], 2, "camera.json"),
        (&["none.csv", "-c", "camera.json"], 1, "none.csv: cannot be read"),
    ] {
        let run = folder.run(&[&["resect"], arguments].concat());
        assert_eq!(run.code, code, "{arguments:?} {run:?}");
        assert!(run.stderr.contains(message), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
}

#[test]
fn outputs_are_all_new_or_all_old() {
    let folder = folder();
    folder.write("out.json", "old");
    std::fs::create_dir(folder.path("r.svg")).unwrap();
    let run = folder.run(&[
        "resect",
        "control.csv",
        "-c",
        "camera.json",
        "-o",
        "out.json",
        "--svg",
        "r.svg",
    ]);
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("r.svg") && run.stdout.is_empty(), "{run:?}");
    assert_eq!(folder.text("out.json"), "old");
}

/// Two cameras that look down from 500, 100 apart: c = 1000, the normal case of stereo photogrammetry.
fn stereo() -> Folder {
    let folder = Folder::new();
    for (name, x) in [("left.camera.json", 0), ("right.json", 100)] {
        let camera = format!(
            r#"{{ "collinear": "camera", "version": 1, "width": 1000, "height": 1000,
            "interior": {{ "model": "pinhole", "principal_distance": [1000, 1000], "principal_point": [500, 500] }},
            "exterior": {{ "projection_center": [{x}, 0, 500], "omega_phi_kappa": [0, 0, 0] }} }}"#
        );
        folder.write(name, camera);
    }
    folder
}

#[test]
fn the_normal_case_of_stereo_is_intersected() {
    let folder = stereo();
    // x 200 and −50 about the principal point: parallax 250, depth 1000 · 100/250 = 400, X = 200 · 0.4; half a pixel of y
    // parallax either way. The second point is seen once, the third at infinity.
    folder.write(
        "images.csv",
        "photo,id,x,y,sigma\nleft,roof,700,500.5,1\nright,roof,450,499.5,1\nleft,once,500,500,\n\
         left,star,600,500,\nright,star,600,500,\n",
    );
    let run = folder.succeed(&[
        "intersect",
        "images.csv",
        "--cameras",
        "left.camera.json",
        "right.json",
        "-o",
        "points.csv",
    ]);
    let text = folder.text("points.csv");
    let lines: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    let value = |i: usize| lines[1][i].parse::<f64>().unwrap();
    for (i, expected) in [(1, 80.0), (2, 0.0), (3, 100.0)] {
        assert!((value(i) - expected).abs() < 1e-9, "{}", text);
    }
    // σ₀² = 2 · 0.5²/1. Depth Z = cB/p: σ_Z = Z²/(cB) √2 σ₀ = 1.6 · √2 · √½ = 1.6; σ_Y = (Z/c) σ₀/√2 = 0.4/2.
    assert!((value(6) - 1.6).abs() < 1e-9 && (value(5) - 0.2).abs() < 1e-9, "{text}");
    assert!((value(8) - 0.5f64.sqrt()).abs() < 1e-12);
    assert!(text.contains("once,,,,,,,1,,\"2 points") || text.contains("once,,,,,,,1,,"), "{text}");
    assert!(
        lines[3][0] == "star" && lines[3][1].is_empty() && text.contains("degenerate"),
        "{text}"
    );
    assert!(run.stdout.contains("points           1, 2 not found"), "{}", run.stdout);
    let run = folder.run(&["intersect", "images.csv", "--cameras", "left.camera.json"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stderr.contains("no photograph is called `right`: there are left"),
        "{}",
        run.stderr
    );
}
