//! `collinear adjust`.

use serde_json::Value;

use crate::support::Folder;

const POINTS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 1.0, 0.5],
    [2.0, -1.0, 1.0],
    [0.0, 2.0, 2.0],
    [1.0, -2.0, 0.0],
    [2.0, 2.0, 1.5],
    [-1.0, 1.0, 1.0],
    [3.0, 0.5, 0.0],
];

/// Two photographs from (0, 0, 10) and (2, 0, 10), f = 1000, over eight points, measured exactly: X is right, Y up, the
/// cameras look along −z as BAL's do, so that a point is at f (X − Xc)/(10 − Z), f Y/(10 − Z). The second starts 0.05 beside.
fn problem() -> String {
    of_points(&POINTS)
}

fn of_points(points: &[[f64; 3]]) -> String {
    let mut text = format!("2 {} {}\n", points.len(), 2 * points.len());
    for (i, [x, y, z]) in points.iter().enumerate() {
        for (camera, xc) in [(0, 0.0), (1, 2.0)] {
            let depth = 10.0 - z;
            text += &format!("{camera} {i} {} {}\n", 1000.0 * (x - xc) / depth, 1000.0 * y / depth);
        }
    }
    // P = R X + t with R = I: t = −C.
    text += "0 0 0 0 0 -10 1000 0 0\n0.001 0 0 -2.05 0.02 -10 1000 0 0\n";
    for [x, y, z] in points {
        text += &format!("{} {} {}\n", x + 0.01, y - 0.01, z + 0.02);
    }
    text
}

#[test]
fn a_block_of_exact_measurements_has_no_residual_left() {
    let folder = Folder::new();
    folder.write("block.txt", problem());
    let run = folder.succeed(&[
        "adjust",
        "block.txt",
        "--estimate",
        "none",
        "--json",
        "-o",
        "out.txt",
        "--svg",
        "r.svg",
    ]);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(report["final_cost"].as_f64().unwrap() < 1e-15, "{}", run.stdout);
    assert_eq!(report["image_points"], 16);
    // 32 numbers, 12 of the poses and 24 of the points, 7 conditions of the datum.
    assert_eq!(
        (report["observations"].clone(), report["unknowns"].clone()),
        (32.into(), 36.into())
    );
    assert_eq!(report["redundancy"], 3);
    // The base is as the measurements say over the points' extent: unchanged by a similarity. Its ratio to the distance of two
    // points, |(2, 0, 10) − (0, 0, 10)| / |(3, ½, 0) − (0, 0, 0)|.
    let numbers: Vec<f64> = folder
        .text("out.txt")
        .lines()
        .skip(17)
        .flat_map(|l| l.split_whitespace().map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>())
        .collect();
    let (cameras, points) = numbers.split_at(18);
    let center = |c: &[f64]| {
        use collinear::nalgebra::{Rotation3, Vector3};
        let r = Rotation3::from_scaled_axis(Vector3::new(c[0], c[1], c[2]));
        -(r.inverse() * Vector3::new(c[3], c[4], c[5]))
    };
    let base = (center(&cameras[9..]) - center(cameras)).norm();
    let far: f64 = (0..3).map(|i| (points[21 + i] - points[i]).powi(2)).sum::<f64>().sqrt();
    assert!((base / far - 2.0 / 9.25f64.sqrt()).abs() < 1e-9, "{base} {far}");
    assert!(folder.text("r.svg").contains("times as long"));
    // A second adjustment starts at the end of the first.
    let again = folder.succeed(&["adjust", "out.txt", "--estimate", "none", "--json"]);
    let again: Value = serde_json::from_str(&again.stdout).unwrap();
    assert!(again["initial_cost"].as_f64().unwrap() < 1e-12);
}

#[test]
fn a_blunder_is_the_first_suspect() {
    let folder = Folder::new();
    // Thirty points; four of the lines are off by a tenth of a pixel or so, one by 8.
    let points: Vec<[f64; 3]> = (0..30)
        .map(|i| {
            [
                f64::from(i * 7 % 11) * 0.4 - 1.0,
                f64::from(i * 5 % 9) * 0.5 - 2.0,
                f64::from(i * 3 % 7) * 0.3,
            ]
        })
        .collect();
    let mut lines: Vec<String> = of_points(&points).lines().map(str::to_owned).collect();
    for (line, dx, dy) in [(3, 0.1, -0.05), (6, -0.1, 0.08), (9, 0.05, 0.1), (14, 0.0, 8.0)] {
        let words: Vec<f64> = lines[line].split(' ').map(|w| w.parse().unwrap()).collect();
        lines[line] = format!("{} {} {} {}", words[0], words[1], words[2] + dx, words[3] + dy);
    }
    folder.write("block.txt", lines.join("\n"));
    let arguments = ["adjust", "block.txt", "--estimate", "none", "--sigma", "0.2", "--trust"];
    let text = folder.succeed(&arguments).stdout;
    let suspects = text.split("with a test beyond 3.29").nth(1).unwrap();
    let first: Vec<&str> = suspects.lines().nth(2).unwrap().split_whitespace().collect();
    // Line 14 is observation 13: camera 1, point 6. Both rays of a point show the same y parallax.
    assert_eq!(first[1], "6", "{text}");
    let robust = folder.succeed(&[&arguments[..], &["--loss", "cauchy:2"]].concat()).stdout;
    assert!(robust.contains("converged"), "{robust}");
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new();
    let good = problem();
    folder
        .write("block.txt", &good)
        .write("cut.txt", &good[..good.len() / 2])
        .write("end.txt", good.replacen("2 8 16", "2 9 16", 1))
        .write("few.txt", "1 1 1\n0 0 1 1\n0 0 0 0 0 -10 1000 0 0\n0 0 0\n")
        .write("nan.txt", good.replacen("1000 0 0", "NaN 0 0", 1))
        .write("zero.txt", good.replacen("1000 0 0", "0 0 0", 1))
        .write("rec.json", "[]");
    for (arguments, code, message) in [
        (&["none.txt"][..], 1, "none.txt: cannot be read"),
        (
            &["cut.txt"],
            1,
            "cut.txt: line 13: the file ends, expected the camera of observation 12 (of 16)",
        ),
        (
            &["end.txt"],
            1,
            "end.txt: line 27: the file ends, expected the coordinates of point 8 (of 9)",
        ),
        (
            &["few.txt"],
            1,
            "few.txt: no photograph has 3 image points of points that another shows too; photograph 0 has most, 0",
        ),
        (&["nan.txt"], 1, "nan.txt: line 18: f, k1, k2 of camera 0 (of 2) is `NaN`"),
        (&["zero.txt"], 1, "zero.txt: camera 0: principal distance is 0, expected more than 0"),
        (&["rec.json"], 1, "rec.json: is OpenSfM's: give its tracks (--tracks)"),
        (&["block.txt", "--estimate", "k9"], 2, "--estimate: `k9` is none of distance"),
        (&["block.txt", "--loss", "huber"], 2, "expected a name and a scale, as huber:2"),
        (&["block.txt", "--loss", "hubert:2"], 2, "`hubert` is none of huber"),
        (&["block.txt", "--estimate", "k1,distance,k1"], 2, "--estimate: `k1` is chosen twice"),
        (
            &["block.txt", "--sigma", "-1"],
            2,
            "'--sigma <PIXELS>': expected a finite number above 0",
        ),
        (&["block.txt", "--iterations", "0"], 2, "invalid value '0' for '--iterations"),
        (&["block.txt", "--iterations", "-1"], 2, "invalid value '-1' for '--iterations"),
        (
            &["block.txt", "--svg", "r.svg", "--exaggeration", "1e9"],
            2,
            "expected a number from 0.001 to 1000000",
        ),
        (&["block.txt", "-o", "block.txt"], 2, "block.txt"),
        (
            &["block.txt", "--svg", "r.svg", "--photo", "7"],
            1,
            "--photo: the block has no photograph `7`",
        ),
    ] {
        let run = folder.run(&[&["adjust"], arguments].concat());
        assert_eq!(run.code, code, "{arguments:?} {run:?}");
        assert!(run.stderr.contains(message), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
    assert_eq!(folder.text("block.txt"), good);
}

#[test]
fn a_file_of_an_input_folder_is_no_output() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("model")).unwrap();
    for (name, text) in
        [("cameras.txt", "# 1\n"), ("images.txt", "# 2\n"), ("points3D.txt", "# 3\n")]
    {
        folder.write(&format!("model/{name}"), text);
    }
    folder.write("images.csv", "left,a,1,2\n");
    for arguments in [
        &["adjust", "model", "--svg", "model/cameras.txt"][..],
        &["adjust", "model", "-o", "model/points3D.txt"],
        &["intersect", "images.csv", "-c", "model", "-o", "model/images.txt"],
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, 2, "{arguments:?} {run:?}");
        assert!(run.stderr.contains("is a file of model"), "{}", run.stderr);
    }
    assert_eq!(folder.text("model/cameras.txt"), "# 1\n");
}

#[test]
fn outputs_are_all_new_or_all_old() {
    let folder = Folder::new();
    folder.write("block.txt", problem()).write("out.txt", "old");
    std::fs::create_dir(folder.path("r.svg")).unwrap();
    let arguments = ["adjust", "block.txt", "--estimate", "none", "-o", "out.txt"];
    let run = folder.run(&[&arguments[..], &["--svg", "r.svg"]].concat());
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("r.svg") && run.stdout.is_empty(), "{run:?}");
    assert_eq!(folder.text("out.txt"), "old");
    // Nothing is left beside them.
    assert_eq!(std::fs::read_dir(folder.path(".")).unwrap().count(), 3);
    // A picture by the name of one of the files that the block is written to.
    let town = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/town/block");
    let run = folder.run(&["adjust", town, "-o", "new", "--svg", "new/../new/cameras.txt"]);
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.stderr.contains("two outputs have this path"), "{run:?}");
    assert_eq!(std::fs::read_dir(folder.path("new")).unwrap().count(), 0);
}

#[test]
fn photographs_with_too_few_image_points_are_left_out_by_name() {
    let folder = Folder::new();
    // A third photograph without any image point, a fourth with two, of which one is of a point that nothing else shows.
    let good = problem();
    let mut lines: Vec<String> = good.lines().map(str::to_owned).collect();
    lines[0] = "4 9 18".into();
    let idle = ["0 0 0 5 0 -10 1000 0 0", "0 0 0 -1 0 -10 1000 0 0"].map(str::to_owned);
    lines.splice(17..17, ["3 0 -100 0".to_owned(), "3 8 0 0".to_owned()]);
    lines.splice(21..21, idle);
    lines.push("1 0 0".into());
    folder.write("block.txt", lines.join("\n") + "\n");
    let arguments = ["adjust", "block.txt", "--estimate", "none", "-o", "out.txt"];
    let run = folder.succeed(&arguments);
    for line in [
        "left out         photograph 2: 0 image points that can take part, 3 needed",
        "left out         photograph 3: 1 image points that can take part, 3 needed",
        "photographs      2, cameras 2, points 9, image points 16",
    ] {
        assert!(run.stdout.contains(line), "{}", run.stdout);
    }
    assert!(run.stderr.contains("photograph 3 is left out"), "{}", run.stderr);
    let written = folder.text("out.txt");
    let written: Vec<&str> = written.lines().collect();
    // After 18 observations nine lines for each camera: those left out are as they were.
    let camera = |i: usize| written[19 + 9 * i..28 + 9 * i].join(" ");
    assert_eq!(camera(2), "0 0 0 5 0 -10 1000 0 0");
    assert_eq!(camera(3), "0 0 0 -1 0 -10 1000 0 0");
    assert_ne!(camera(1), "0.001 0 0 -2.05 0.02 -10 1000 0 0");

    let json = folder.succeed(&[&arguments[..], &["--json"]].concat()).stdout;
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        json["left_out_photographs"],
        serde_json::json!([
            { "name": "2", "image_points": 0 }, { "name": "3", "image_points": 1 }
        ])
    );
    assert_eq!(json["conditions"], 7);
    assert!(json["final_cost"].as_f64().unwrap() < 1e-15);
}

#[test]
fn image_points_that_take_no_part_have_their_reason() {
    let folder = Folder::new();
    // Point 8 has one ray; point 9 lies behind both cameras.
    let mut lines: Vec<String> = problem().lines().map(str::to_owned).collect();
    lines[0] = "2 10 19".into();
    let more = ["0 8 10 20", "0 9 0 0", "1 9 0 0"].map(str::to_owned);
    lines.splice(17..17, more);
    lines.extend(["1 0 0".to_owned(), "0 0 20".to_owned()]);
    folder.write("block.txt", lines.join("\n"));
    let run = folder.succeed(&["adjust", "block.txt", "--estimate", "none", "--json"]);
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["left_out"], 3);
    let reasons: Vec<(&str, &str, &str)> = json["left_out_image_points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| {
            let text = |name: &str| e[name].as_str().unwrap();
            (text("photograph"), text("point"), text("reason"))
        })
        .collect();
    assert_eq!(
        reasons,
        [("0", "8", "single_ray"), ("0", "9", "behind_camera"), ("1", "9", "behind_camera")]
    );
    // y is down in the pixels of this program.
    assert_eq!(json["left_out_image_points"][0]["image"], serde_json::json!([10.0, -20.0]));
}

/// The same block as COLMAP's folder: y down, principal point (500, 400); the cameras of the model look along +z from z = −10.
fn colmap(folder: &Folder, name: &str, camera: &str) {
    std::fs::create_dir(folder.path(name)).unwrap();
    let mut images = String::new();
    let mut list = String::new();
    for (number, (xc, start)) in [(0.0, 0.0), (2.0, -2.05)].into_iter().enumerate() {
        images += &format!("{} 1 0 0 0 {start} 0 10 1 view{number}.jpg\n", number + 1);
        for (i, [x, y, z]) in POINTS.iter().enumerate() {
            let depth = 10.0 + z;
            images += &format!(
                "{} {} {} ",
                500.0 + 1000.0 * (x - xc) / depth,
                400.0 + 1000.0 * y / depth,
                i + 1
            );
        }
        images += "\n";
    }
    for (i, [x, y, z]) in POINTS.iter().enumerate() {
        list += &format!("{} {x} {y} {z} 1 2 3 0.1 1 {i} 2 {i}\n", i + 1);
    }
    folder
        .write(&format!("{name}/cameras.txt"), camera)
        .write(&format!("{name}/images.txt"), images)
        .write(&format!("{name}/points3D.txt"), list);
}

#[test]
fn colmaps_cameras_keep_their_model() {
    let folder = Folder::new();
    for (number, (parameters, estimate, model)) in [
        ("SIMPLE_PINHOLE 1000 800 1000 500 400", "none", "SIMPLE_PINHOLE"),
        ("PINHOLE 1000 800 1000 1000 500 400", "none", "PINHOLE"),
        ("SIMPLE_RADIAL 1000 800 1000 500 400 0.001", "distance,k1", "SIMPLE_RADIAL"),
        ("RADIAL 1000 800 1000 500 400 0.001 0", "k1", "RADIAL"),
        ("OPENCV 1000 800 1000 1000 500 400 0 0 0 0", "k1", "OPENCV"),
        // Where the model has not what was estimated, one that has.
        ("SIMPLE_PINHOLE 1000 800 1000 500 400", "k1", "OPENCV"),
    ]
    .into_iter()
    .enumerate()
    {
        let (from, to) = (format!("in{number}"), format!("out{number}"));
        colmap(&folder, &from, &format!("1 {parameters}\n"));
        folder.succeed(&["adjust", &from, "--estimate", estimate, "--no-quality", "-o", &to]);
        let text = folder.text(&format!("{to}/cameras.txt"));
        let line = text.lines().find(|l| !l.starts_with('#')).unwrap();
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[1], model, "{text}");
        let before = parameters.split_whitespace().count();
        assert!(words.len() == before + 1 || model != words[1] || model == "OPENCV", "{text}");
    }
    // Exact measurements: the distortion that they start with is found away.
    let text = folder.text("out3/cameras.txt");
    let line = text.lines().find(|l| !l.starts_with('#')).unwrap();
    let k1: f64 = line.split_whitespace().nth(7).unwrap().parse().unwrap();
    assert!(k1.abs() < 1e-7, "{text}");
}
