//! `collinear adjust`.

use serde_json::Value;

use crate::support::Folder;

/// Two photographs from (0, 0, 10) and (2, 0, 10), f = 1000, over eight points, measured exactly: X is right, Y up, the
/// cameras look along −z as BAL's do, so that a point is at f (X − Xc)/(10 − Z), f Y/(10 − Z). The second starts 0.05 beside.
fn problem() -> String {
    of_points(&[
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.5],
        [2.0, -1.0, 1.0],
        [0.0, 2.0, 2.0],
        [1.0, -2.0, 0.0],
        [2.0, 2.0, 1.5],
        [-1.0, 1.0, 1.0],
        [3.0, 0.5, 0.0],
    ])
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
        .write("few.txt", "1 1 1\n0 0 1 1\n0 0 0 0 0 -10 1000 0 0\n0 0 0\n")
        .write("nan.txt", good.replacen("1000 0 0", "NaN 0 0", 1))
        .write("zero.txt", good.replacen("1000 0 0", "0 0 0", 1))
        .write("rec.json", "[]");
    for (arguments, code, message) in [
        (&["none.txt"][..], 1, "none.txt: cannot be read"),
        (&["cut.txt"], 1, "cut.txt: "),
        (&["few.txt"], 1, "few.txt: "),
        (&["nan.txt"], 1, "nan.txt: "),
        (&["zero.txt"], 1, "zero.txt: principal distance is 0, expected more than 0"),
        (&["rec.json"], 1, "rec.json: is OpenSfM's: give its tracks (--tracks)"),
        (&["block.txt", "--estimate", "k9"], 2, "--estimate: `k9` is none of distance"),
        (&["block.txt", "--loss", "huber"], 2, "expected a name and a scale, as huber:2"),
        (&["block.txt", "--loss", "hubert:2"], 2, "`hubert` is none of huber"),
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
