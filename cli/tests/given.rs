//! `collinear adjust` with control points, check points, positions, attitudes and distances.

use std::path::PathBuf;

use serde_json::Value;

use crate::support::Folder;

/// The files of oracles/given.py: a block in a frame of its own, what was given in map coordinates, and what numpy found.
const FILES: [&str; 7] = [
    "block.txt",
    "control.csv",
    "check.csv",
    "clicks.csv",
    "positions.csv",
    "attitudes.csv",
    "distances.csv",
];

fn data(name: &str) -> String {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "tests", "data", "given", name].iter().collect();
    std::fs::read_to_string(path).unwrap()
}

fn folder() -> Folder {
    let folder = Folder::new();
    for name in FILES {
        folder.write(name, data(name));
    }
    folder
}

const START: [&str; 6] = ["adjust", "block.txt", "--estimate", "none", "--sigma", "0.5"];
const CONTROL: [&str; 4] = ["--control", "control.csv", "--clicks", "clicks.csv"];
const ORIENTED: [&str; 6] =
    ["--positions", "positions.csv", "--lever-arm", "0.3,-0.2,0.9", "--attitudes", "attitudes.csv"];

/// Three numbers a row, each as near to the expected one as said.
fn near(found: &Value, expected: &Value, limit: f64, what: &str) {
    match (found, expected) {
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{what}");
            found.iter().zip(expected).for_each(|(f, e)| near(f, e, limit, what));
        }
        _ => {
            let (found, expected) = (found.as_f64().unwrap(), expected.as_f64().unwrap());
            assert!((found - expected).abs() < limit, "{what}: {found}, expected {expected}");
        }
    }
}

fn all(rows: &Value, field: &str) -> Value {
    rows.as_array().unwrap().iter().map(|row| row[field].clone()).collect()
}

#[test]
fn a_block_of_all_kinds_is_that_of_numpy() {
    let folder = folder();
    let rest = ["--check", "check.csv", "--distances", "distances.csv", "--trust", "--json"];
    let run = folder.succeed(&[&START[..], &CONTROL, &ORIENTED, &rest].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let expected: Value = serde_json::from_str(&data("expected.json")).unwrap();
    for field in ["observations", "unknowns"] {
        assert_eq!(found[field], expected[field], "{field}");
    }
    assert_eq!((found["datum"].as_str(), found["conditions"].as_u64()), (Some("given"), Some(0)));
    near(&found["final_cost"], &expected["cost"], 1e-5, "cost");
    let centers = all(&found["photographs"], "projection_center");
    near(&centers, &expected["centers"], 2e-6, "centres");
    for (list, field, name, limit) in [
        ("control_points", "residual", "control_residual", 2e-6),
        ("control_points", "redundancy", "control_redundancy", 1e-5),
        ("positions", "residual", "position_residual", 2e-6),
        ("attitudes", "residual_deg", "attitude_residual_deg", 2e-6),
    ] {
        near(&all(&found[list], field), &expected[name], limit, name);
    }
    near(&found["distances"][0]["residual"][0], &expected["distance_residual"], 1e-6, "distance");
    let differences = all(&found["check_points"]["differences"], "difference");
    near(&differences, &expected["check"], 2e-6, "check points");
    // The root of the mean square of two heights' differences.
    let z = |i: usize| expected["check"][i][2].as_f64().unwrap();
    let rms = ((z(0).powi(2) + z(1).powi(2)) / 2.0).sqrt();
    near(&found["check_points"]["rms"][2], &rms.into(), 2e-6, "rms");
    for (list, group) in [("control_points", 2), ("positions", 3), ("attitudes", 4)] {
        let sum: f64 = (all(&found[list], "redundancy").as_array().unwrap().iter())
            .flat_map(|r| r.as_array().unwrap())
            .map(|r| r.as_f64().unwrap())
            .sum();
        near(&sum.into(), &expected["redundancies"][group], 1e-4, list);
    }
}

#[test]
fn precisions_are_those_of_numpy() {
    let folder = folder();
    let start =
        [&START[..], &CONTROL, &ORIENTED, &["--check", "check.csv", "--variances"]].concat();
    let run = folder.succeed(&[&start[..], &["--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let expected: Value = serde_json::from_str(&data("expected.json")).unwrap();
    let components = &found["variance_components"];
    let names = ["image_points", "clicks", "control_points", "positions", "attitudes"];
    assert_eq!(all(components, "group"), serde_json::json!(names));
    near(&all(components, "sigma"), &expected["factors"], 1e-4, "sigma");
    let run = folder.succeed(&start);
    assert!(run.stdout.contains("precisions found"), "{}", run.stdout);
    assert!(run.stdout.contains("with them the cost is"), "{}", run.stdout);
    assert!(found["precisions"]["adjustments"].as_u64() > Some(1), "{found}");
    // Three control points: too few to tell how good they are.
    let few = data("control.csv").lines().take(4).collect::<Vec<_>>().join("\n");
    folder.write("control.csv", few + "\n");
    let run = folder.run(&[&START[..], &CONTROL, &["--variances"]].concat());
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("the control points agree with the rest"), "{}", run.stderr);
}

#[test]
fn the_protocol_names_what_was_given() {
    let folder = folder();
    let run = folder.succeed(&[&START[..], &["--check", "check.csv"], &CONTROL[2..]].concat());
    assert!(run.stdout.contains("in the block's own frame"), "{}", run.stdout);
    let more = "c9,389400,5819700,40,1,1,1\n";
    folder.write("control.csv", data("control.csv") + more);
    folder.write("clicks.csv", data("clicks.csv") + "1,x9,1,2,1\n");
    let rest = ["--check", "check.csv", "--distances", "distances.csv"];
    let run = folder.succeed(&[&START[..], &CONTROL, &ORIENTED, &rest].concat());
    for line in [
        "left out         point c9: clicked in no photograph",
        "placed by        5 control points, 6 positions: scale 20.2",
        "standard deviations in the frame of what was given",
        "control points (v: given minus adjusted",
        "positions (v: given minus adjusted",
        "attitudes (v: given minus adjusted",
        "c0 – k1",
        "check points (adjusted minus known",
        "other observations with a test beyond 3.29: 0 of 52",
    ] {
        assert!(run.stdout.contains(line), "{line}: {}", run.stdout);
    }
    assert!(
        run.stderr.contains("point x9 is left out: clicked, but in none of --control"),
        "{}",
        run.stderr
    );
    assert!(
        run.stderr.contains("point c9 is left out: clicked in no photograph"),
        "{}",
        run.stderr
    );
    // A height that is 3 m wrong is the first suspect, in the frame of the adjustment before.
    let wrong = data("control.csv").lines().map(str::to_owned).collect::<Vec<_>>();
    let cells: Vec<&str> = wrong[2].split(',').collect();
    let z = cells[3].parse::<f64>().unwrap() + 3.0;
    let line =
        [cells[0], cells[1], cells[2], &z.to_string(), cells[4], cells[5], cells[6]].join(",");
    folder.write("control.csv", data("control.csv").replace(&wrong[2], &line));
    let run = folder.succeed(&[&START[..], &CONTROL, &["--trust", "--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let first = &found["given_suspects"][0];
    assert_eq!((first["name"].as_str(), first["component"].as_str()), (Some("c1"), Some("Z")));
}

/// The town's photographs in COLMAP's folder: the cameras' places are those of the scene.
#[test]
fn the_towns_corners_place_its_photographs() {
    let town: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", "examples", "town"].iter().collect();
    let folder = Folder::new();
    let read = |name: &str| std::fs::read_to_string(town.join(name)).unwrap();
    let lines = |name: &str| {
        let lines = read(name);
        lines
            .lines()
            .filter(|l| !l.contains("spire"))
            .map(|l| l.to_owned() + "\n")
            .collect::<String>()
    };
    let control: String = lines("control.csv")
        .lines()
        .filter(|l| !l.contains("east 1") && !l.contains("choir"))
        .map(|l| l.to_owned() + "\n")
        .collect();
    folder.write("control.csv", control).write("clicks.csv", lines("clicks.csv"));
    let block = town.join("block");
    let arguments = ["adjust", block.to_str().unwrap(), "--sigma", "0.15"];
    let run = folder.succeed(&[&arguments[..], &CONTROL, &["--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    for photograph in found["photographs"].as_array().unwrap() {
        let name = photograph["name"].as_str().unwrap().replace(".png", ".camera.json");
        let truth: Value = serde_json::from_str(&read(&name)).unwrap();
        // Corners to a quarter of a pixel from 100 m with 1100 pixels: centimetres.
        near(
            &photograph["projection_center"],
            &truth["exterior"]["projection_center"],
            0.15,
            &name,
        );
    }
}

#[test]
fn what_is_wrong_with_what_is_given_is_said() {
    let replace =
        |name: &'static str, from: &str, to: &str| (name, data(name).replacen(from, to, 1));
    let add = |name: &'static str, line: &str| (name, data(name) + line + "\n");
    let keep = |name: &'static str, count: usize| {
        let kept: Vec<String> = data(name).lines().take(count).map(str::to_owned).collect();
        (name, kept.join("\n"))
    };
    let control_row = data("control.csv").lines().nth(1).unwrap().to_owned();
    let click = data("clicks.csv").lines().nth(1).unwrap().to_owned();
    for ((name, text), message) in [
        (add("control.csv", &control_row), "--control: point `c0` is there twice"),
        (add("clicks.csv", &click), "--clicks: point `c0` is there twice in photograph `0`"),
        (
            add("clicks.csv", "17,c0,1,2,1"),
            "--clicks: the block has no photograph `17`: there are 0, 1, 2, 3, 4, …",
        ),
        (add("check.csv", "c1,1,2,3"), "point `c1` is in --control and in --check"),
        (add("positions.csv", "1,1,2,3,1,1,1"), "--positions: photograph `1` is there twice"),
        (add("attitudes.csv", "99,1,2,3,1,1,1"), "--attitudes: the block has no photograph `99`"),
        (add("distances.csv", "c0,zz,1,1"), "--distances: point `zz` is clicked in no photograph"),
        (
            add("distances.csv", "c0,c0,1,1"),
            "--distances: from c0 to c0: distance of a point from itself",
        ),
        (replace("control.csv", "id,X", "name,X"), "control.csv: line 1: the header is `name X Y"),
        (
            replace("control.csv", "0.02", "-0.02"),
            "control.csv: line 2, field 5: sigma_X is -0.02, expected a number above 0",
        ),
        (replace("clicks.csv", "x,y", "x,z"), "clicks.csv: line 1: the header is"),
        (add("positions.csv", "0,nan,2,3,1,1,1"), "positions.csv: line 8, field 2: X is `nan`"),
        (add("attitudes.csv", ",1,2,3,1,1,1"), "attitudes.csv: line 8, field 1: photo is empty"),
        (replace("attitudes.csv", "kappa", "kappa_gon"), "attitudes.csv: line 1: the header is"),
    ] {
        let folder = folder();
        folder.write(name, text);
        let rest = ["--check", "check.csv", "--distances", "distances.csv"];
        let run = folder.run(&[&START[..], &CONTROL, &ORIENTED, &rest].concat());
        assert_eq!(run.code, 1, "{message} {run:?}");
        assert!(run.stderr.contains(message), "{message}: {}", run.stderr);
    }
    let folder = folder();
    let (name, text) = keep("control.csv", 3);
    folder.write(name, text);
    folder.write(
        "clicks.csv",
        data("clicks.csv")
            .lines()
            .filter(|l| {
                !l.contains(",c2") && !l.contains(",c3") && !l.contains(",c4") && !l.contains(",k")
            })
            .map(|l| l.to_owned() + "\n")
            .collect::<String>(),
    );
    for (arguments, code, message) in [
        (&CONTROL[..], 1, "2 control points clicked in two photographs and 0 positions, 3 needed"),
        (&["--attitudes", "attitudes.csv"], 1, "--attitudes alone place no block"),
        (&["--clicks", "clicks.csv"], 2, "--clicks: of which points?"),
        (&["--control", "control.csv"], 2, "--clicks <CLICKS.csv>"),
        (
            &["--positions", "positions.csv", "--lever-arm", "1,2"],
            2,
            "expected three finite numbers",
        ),
        (&["--variances", "--no-quality"], 2, "cannot be used with"),
    ] {
        let run = folder.run(&[&START[..], arguments].concat());
        assert_eq!(run.code, code, "{arguments:?} {run:?}");
        assert!(run.stderr.contains(message), "{arguments:?}: {}", run.stderr);
    }
}

/// Two photographs straight down from 5 km over ground at 2 km, the Earth a sphere and the air of the standard atmosphere, whose K is
/// 29.3 millionths by a ray traced in Python: each image by the geometry of a sphere about the photograph's own vertical.
/// A photograph without image points is left out, and its position with it.
#[test]
fn the_position_of_an_idle_photograph_places_nothing() {
    let folder = folder();
    let arguments = [&START[..], &["--positions", "positions.csv", "--json"]].concat();
    let cost = |folder: &Folder| {
        let run = folder.succeed(&arguments);
        let found: Value = serde_json::from_str(&run.stdout).unwrap();
        (found["final_cost"].as_f64().unwrap(), run.stderr)
    };
    let (expected, _) = cost(&folder);
    let text = data("block.txt");
    let numbers: Vec<&str> = text.split_whitespace().collect();
    let [cameras, points, observations] = [0, 1, 2].map(|i| numbers[i].parse::<usize>().unwrap());
    let mut numbers: Vec<String> = numbers.into_iter().map(str::to_owned).collect();
    let end = numbers.len() - 3 * points;
    assert_eq!(end, 3 + 4 * observations + 9 * cameras);
    let idle = ["0", "0", "0", "0", "0", "0", "1000", "0", "0"].map(str::to_owned);
    numbers.splice(end..end, idle);
    numbers[0] = (cameras + 1).to_string();
    let row = format!("{cameras},380000,5800000,1000,0.04,0.05,0.06\n");
    folder
        .write("block.txt", numbers.join("\n") + "\n")
        .write("positions.csv", data("positions.csv") + &row);
    let (found, said) = cost(&folder);
    assert!(said.contains(&format!("photograph {cameras} is left out")), "{said}");
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
}

#[test]
fn a_table_of_a_header_alone_is_refused() {
    let folder = folder();
    folder.write("positions.csv", "photo,X,Y,Z,sigma_X,sigma_Y,sigma_Z\n");
    let run = folder.run(&[&START[..], &["--positions", "positions.csv"]].concat());
    assert_eq!(run.code, 1, "{run:?}");
    let message = "positions.csv: has a header and no line after it";
    assert!(run.stderr.contains(message), "{}", run.stderr);
}

#[test]
fn air_and_the_earths_shape_are_corrected() {
    let (earth, height, focal, bend) = (6_371_000.0_f64, 5000.0_f64, 10_000.0, 29.3e-6_f64);
    let centers = [[389_000.0, 5_819_000.0], [390_200.0, 5_819_000.0]];
    let points: Vec<[f64; 3]> = (0..20)
        .map(|i| {
            let (x, y) = (f64::from(i % 5) * 700.0 - 800.0, f64::from(i / 5) * 900.0 - 1350.0);
            [389_000.0 + x, 5_819_000.0 + y, 2000.0 + f64::from(i * 7 % 5 - 2) * 10.0]
        })
        .collect();
    let image = |[xc, yc]: [f64; 2], [x, y, z]: [f64; 3]| {
        let (dx, dy) = (x - xc, y - yc);
        let theta = dx.hypot(dy) / earth;
        let down = earth + height - (earth + z) * theta.cos();
        let alpha = ((earth + z) * theta.sin() / down).atan();
        let r = focal * (alpha + bend * alpha.tan()).tan();
        [r * dx / dx.hypot(dy), r * dy / dx.hypot(dy)]
    };
    let mut text = format!("2 {} {}\n", points.len(), 2 * points.len());
    let (mut control, mut clicks) = ("id,X,Y,Z\n".to_owned(), "photo,id,x,y\n".to_owned());
    for (i, point) in points.iter().enumerate() {
        for (camera, center) in centers.iter().enumerate() {
            let [x, y] = image(*center, *point);
            text += &format!("{camera} {i} {x} {y}\n");
            if i % 3 == 0 {
                clicks += &format!("{camera},p{i},{x},{}\n", -y);
            }
        }
        if i % 3 == 0 {
            control += &format!("p{i},{},{},{}\n", point[0], point[1], point[2]);
        }
    }
    for [x, y] in centers {
        text += &format!("0 0 0 {} {} {} {focal} 0 0\n", 5.0 - x, 7.0 - y, -height);
    }
    for [x, y, z] in &points {
        text += &format!("{x} {y} {z}\n");
    }
    let folder = Folder::new();
    folder.write("block.txt", text).write("control.csv", control).write("clicks.csv", clicks);
    let off = |more: &[&str]| {
        let start = ["adjust", "block.txt", "--estimate", "none", "--placed", "--json"];
        let run = folder.succeed(&[&start[..], &CONTROL, more].concat());
        let found: Value = serde_json::from_str(&run.stdout).unwrap();
        let center = &found["photographs"][0]["projection_center"];
        let off = |k: usize, truth: f64| (center[k].as_f64().unwrap() - truth).abs();
        let largest = off(0, centers[0][0]).max(off(1, centers[0][1])).max(off(2, height));
        (largest, found["rms"].as_f64().unwrap())
    };
    let both = off(&["--refraction", "--earth-curvature"]);
    assert!(both.0 < 0.03 && both.1 < 0.005, "{both:?}");
    for only in ["--refraction", "--earth-curvature"] {
        let one = off(&[only]);
        assert!(one.0 > 0.08, "{only} {one:?}, both {both:?}");
    }
}
