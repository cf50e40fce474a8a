//! `collinear reproject`: numbers taken by hand.

use crate::support::*;

/// A whole panorama about the origin that looks north: its middle is the horizon, east is to the right.
fn panorama(width: u32, height: u32) -> String {
    document(
        "camera",
        &format!(
            r#""width": {width}, "height": {height}, "interior": {{ "model": "equirectangular" }},
            "exterior": {{ "projection_center": [0, 0, 0], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }}"#
        ),
    )
}

#[test]
fn a_panorama_becomes_a_dome_master_and_a_view() {
    let folder = Folder::new();
    folder.draw("pano.png", [36, 18], label).write("pano.json", panorama(36, 18));
    // Ten degrees a pixel: of an upward fisheye with north on top, east is on the left.
    let scale = 18.0 / std::f64::consts::PI;
    let up = format!(
        r#""width": 18, "height": 18,
        "interior": {{ "model": "fisheye", "principal_distance": [{scale}, {scale}], "principal_point": [9, 9] }},
        "exterior": {{ "projection_center": [5, 5, 5], "rotation_matrix": [[-1, 0, 0], [0, -1, 0], [0, 0, 1]] }}"#
    );
    folder.write("up.json", document("camera", &up));
    let command = [
        "reproject",
        "pano.png",
        "--camera",
        "pano.json",
        "--screen",
        "up.json",
        "--far",
        "--filter",
        "nearest",
        "-o",
        "up.png",
    ];
    folder.succeed(&command);
    let master = folder.picture("up.png");
    // (9.5, 1.5) is atan(0.5/7.5) = 3.8° left of north as the master has it, which is west, and 75.2° from the zenith: row 7.5.
    for ((x, y), azimuth) in
        [((9, 1), -3.8), ((8, 1), 3.8), ((1, 9), 93.8), ((16, 8), -86.2), ((12, 12), -135.0)]
    {
        let from_middle = (f64::from(x) - 8.5).hypot(f64::from(y) - 8.5);
        let row = from_middle.floor() as u32;
        let column = ((180.0 + azimuth) / 10.0_f64).floor() as u32;
        assert_eq!(pixel(&master, x, y)[..3], label(column, row), "({x}, {y}) at {azimuth}");
    }
}

#[test]
fn a_projector_shows_what_the_eye_is_to_see_on_the_dome() {
    let folder = Folder::new();
    // The eye in the middle of a dome of radius 10; its picture a view upwards of 64 × 64 pixels.
    let eye = r#""width": 64, "height": 64,
        "interior": { "model": "pinhole", "principal_distance": [32, 32], "principal_point": [32, 32] },
        "exterior": { "projection_center": [0, 0, 0], "rotation_matrix": [[1, 0, 0], [0, -1, 0], [0, 0, -1]] }"#;
    // That camera looks down: the dome hangs below.
    folder.draw("eye.png", [64, 64], label).write("eye.json", document("camera", eye));
    let projector = eye
        .replace("[0, 0, 0]", "[0, 0, 6]")
        .replace("\"width\": 64, \"height\": 64", "\"width\": 32, \"height\": 32")
        .replace("\"principal_point\": [32, 32]", "\"principal_point\": [16, 16]");
    folder.write("projector.json", document("camera", &projector));
    folder.write(
        "dome.json",
        document("dome", r#""center": [0, 0, 0], "radius": 10, "axis": [0, 0, -2]"#),
    );
    let mut command = vec![
        "reproject",
        "eye.png",
        "--camera",
        "eye.json",
        "--screen",
        "projector.json",
        "--dome",
        "dome.json",
        "--filter",
        "nearest",
        "-o",
        "beam.png",
    ];
    let run = folder.succeed(&command);
    assert!(run.stderr.contains("beam.png: 32 × 32 pixels"), "{}", run.stderr);
    let beam = folder.picture("beam.png");
    for (x, y) in [(16_u32, 16_u32), (31, 16), (3, 9), (20, 30)] {
        // By hand: the line (0, 0, 6) + s (a, b, −1) meets x² + y² + z² = 100.
        let (a, b) = ((f64::from(x) + 0.5 - 16.0) / 32.0, (f64::from(y) + 0.5 - 16.0) / 32.0);
        let square = a * a + b * b + 1.0;
        let s = (6.0 + (36.0 + 64.0 * square).sqrt()) / square;
        let depth = s - 6.0;
        let (u, v) = (32.0 + 32.0 * s * a / depth, 32.0 + 32.0 * s * b / depth);
        let inside = (0.0..64.0).contains(&u) && (0.0..64.0).contains(&v);
        let expected = if inside { label(u as u32, v as u32).to_vec() } else { vec![] };
        let found = pixel(&beam, x, y);
        if inside {
            assert_eq!(found[..3], expected, "({x}, {y})");
        } else {
            assert_eq!(found[3], 0, "({x}, {y})");
        }
    }
    folder.write("line.obj", "v 0 0 -8\nv 1 0 -8\nv 2 0 -8\nf 1 2 3\nf 3 2 1\n");
    (command[6], command[7]) = ("--mesh", "line.obj");
    let run = folder.run(&command);
    let expected = "line.obj: none of its 2 faces has an area";
    assert!(run.code == 1 && run.stderr.contains(expected), "{}", run.stderr);
    // A box of faces instead of the dome: its lower side at −8 is met at s = 14 all over, so that 14/8 of the offset is seen.
    let mut cube = String::new();
    for (x, y, z) in [(-20, -20, -8), (20, -20, -8), (20, 20, -8), (-20, 20, -8)] {
        cube.push_str(&format!("v {x} {y} {z}\n"));
    }
    cube.push_str("f 1 2 3 4\nf 1 1 1\n");
    folder.write("floor.obj", cube);
    command[6] = "--mesh";
    command[7] = "floor.obj";
    let run = folder.succeed(&command);
    assert!(run.stderr.contains("floor.obj: 1 faces have no area"), "{}", run.stderr);
    let beam = folder.picture("beam.png");
    let at = |x: u32| (32.0 + (f64::from(x) - 15.5) * 14.0 / 8.0) as u32;
    for (x, y) in [(16, 16), (30, 16), (3, 9)] {
        assert_eq!(pixel(&beam, x, y)[..3], label(at(x), at(y)), "({x}, {y})");
    }
    // And a plane.
    folder.write("plane.json", document("plane", r#""point": [3, 4, -8], "normal": [0, 0, 1]"#));
    command[6] = "--plane";
    command[7] = "plane.json";
    folder.succeed(&command);
    let flat = folder.picture("beam.png");
    assert_eq!(flat, beam);
}

#[test]
fn what_cannot_be_reprojected_is_told() {
    let folder = Folder::new();
    folder.draw("pano.png", [36, 18], label).write("pano.json", panorama(36, 18));
    folder.draw("wide.png", [37, 18], label);
    folder.write("map.json", document("camera", &map_view(20, 20)));
    folder.write("dome.json", document("dome", r#""center": [0, 0, 0], "radius": 10"#));
    folder.write("flat.json", document("dome", r#""center": [0, 0, 0], "radius": 0"#));
    folder.write("lost.json", document("dome", r#""center": [900, 0, 0], "radius": 1"#));
    folder.write(
        "turned.json",
        document("dome", r#""center": [0, 0, 0], "radius": 1, "axis": [0, 0, 0]"#),
    );
    folder.write(
        "wide.json",
        document("dome", r#""center": [0, 0, 0], "radius": 1, "half_angle_deg": 181"#),
    );
    folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    folder.write("thin.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\n");
    let run = |screen: &str, scene: &[&str]| {
        let mut command =
            vec!["reproject", "pano.png", "--camera", "pano.json", "--screen", screen];
        command.extend(scene);
        command.extend(["-o", "out.png"]);
        let run = folder.run(&command);
        assert_eq!(run.code, 1, "{}", run.stderr);
        assert!(!folder.path("out.png").exists());
        run.stderr
    };
    let told = |text: String, part: &str| assert!(text.contains(part), "{text}");
    told(run("map.json", &["--far"]), "map.json: the new picture: has not one projection centre");
    told(
        run("pano.json", &["--dome", "flat.json"]),
        "flat.json: radius: is 0, expected a finite number above 0",
    );
    told(run("pano.json", &["--dome", "turned.json"]), "turned.json: axis: ");
    told(run("pano.json", &["--dome", "wide.json"]), "wide.json: half_angle_deg: is 181");
    told(
        run("pano.json", &["--dome", "pano.json"]),
        "pano.json: is a collinear camera file, a dome file is needed here",
    );
    told(
        run("map.json", &["--dome", "lost.json"]),
        "none of the 20 × 20 pixels lies in the photograph: the line of sight does not meet the surface",
    );
    told(run("pano.json", &["--mesh", "lines.obj"]), "lines.obj: there are no faces");
    told(run("pano.json", &["--mesh", "thin.obj"]), "thin.obj: ");
    told(run("gone.json", &["--dome", "dome.json"]), "gone.json: cannot be read");
    let wide = folder.run(&[
        "reproject",
        "wide.png",
        "--camera",
        "pano.json",
        "--screen",
        "map.json",
        "--dome",
        "dome.json",
        "-o",
        "out.png",
    ]);
    told(wide.stderr, "wide.png: is 37 × 18 pixels, its camera says 36 × 18");
    for usage in [
        &[
            "reproject",
            "pano.png",
            "--camera",
            "pano.json",
            "--screen",
            "map.json",
            "-o",
            "out.png",
        ][..],
        &[
            "reproject",
            "pano.png",
            "--camera",
            "pano.json",
            "--screen",
            "map.json",
            "--far",
            "--dome",
            "dome.json",
            "-o",
            "out.png",
        ],
        &[
            "reproject",
            "pano.png",
            "--camera",
            "pano.json",
            "--screen",
            "map.json",
            "--far",
            "-o",
            "pano.png",
        ],
    ] {
        assert_eq!(folder.run(usage).code, 2);
    }
}
