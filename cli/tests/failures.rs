//! Help, wrong usage, and inputs that are refused.

use std::fs;

use crate::support::{Folder, document, ground, label, map_view, vertical};

#[test]
fn help_tells_what_a_command_does_and_in_which_units() {
    let folder = Folder::new();
    for (command, essentials) in [
        (
            "render",
            &[
                "SCENE.json",
                "world",
                "pixels",
                "Examples:",
                "--view",
                "collinear render",
                "--strict",
            ][..],
        ),
        (
            "rectify",
            &[
                "--camera",
                "--plane",
                "--quad",
                "--size",
                "--gsd",
                "--filter",
                "--border",
                "--map-out",
                "world units",
            ],
        ),
        (
            "reproject",
            &[
                "--screen",
                "--plane",
                "--dome",
                "--mesh",
                "--far",
                "--border",
                "projector",
                "line of sight",
            ],
        ),
        (
            "warp",
            &[
                "--map",
                "--quad",
                "--filter",
                "--border",
                "--light",
                "--threads",
                "(0.5, 0.5)",
                "ewa",
            ],
        ),
        ("project", &["POINTS.csv", "--inverse", "id, X, Y, Z, x, y, status", "behind", "pixels"]),
        (
            "resect",
            &[
                "CONTROL.csv",
                "without initial values",
                "sigma 0",
                "3.29",
                "80 %",
                "degrees",
                "--svg",
            ],
        ),
        (
            "intersect",
            &["IMAGES.csv", "photo, id, x, y", "free of error", "suspect", "COLMAP", "pixels"],
        ),
        (
            "adjust",
            &[
                "BLOCK",
                "COLMAP",
                "half the sum of squared residuals",
                "3.29",
                "pixels",
                "world units",
                "--loss",
                "--tracks",
            ],
        ),
        ("overlay", &["--scene", "--plane", "--mesh", "--line-width", "SVG", "0.1"]),
    ] {
        let run = folder.succeed(&[command, "--help"]);
        for essential in essentials.iter().chain(&["Exit codes: 0 done", "2 wrong usage"]) {
            assert!(
                joined(&run.stdout).contains(essential),
                "{command}: {essential}\n{}",
                run.stdout
            );
        }
    }
    let run = folder.succeed(&["--help"]);
    assert!(joined(&run.stdout).contains("2 wrong usage"), "{}", run.stdout);
    for essential in [
        "render",
        "rectify",
        "reproject",
        "resect",
        "intersect",
        "adjust",
        "project",
        "overlay",
        "convert",
        "(0.5, 0.5)",
        "formats.md",
    ] {
        assert!(run.stdout.contains(essential), "{essential}\n{}", run.stdout);
    }
    assert!(folder.succeed(&["--version"]).stdout.starts_with("collinear 0."));
}

/// A text with one space wherever it has any, as line breaks.
fn joined(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn help_has_no_line_that_broke_before_it_was_full() {
    let folder = Folder::new();
    for command in ["render", "rectify", "resect", "intersect", "adjust", "project", "overlay"] {
        for width in [100, 72] {
            let text = folder.succeed_at_width(&[command, "--help"], width).stdout;
            let (prose, _) = text.split_once("\nUsage:").unwrap();
            let lines: Vec<_> = prose.lines().collect();
            for pair in lines.windows(2) {
                let next = pair[1].split_whitespace().next().unwrap_or_default();
                let full = pair[0].is_empty() || next.is_empty() || {
                    pair[0].chars().count() + 1 + next.chars().count() > width
                };
                assert!(full && pair[0].chars().count() <= width, "{pair:?}\n{text}");
            }
        }
    }
}

#[test]
fn wrong_usage_is_one_line_and_code_2() {
    let folder = Folder::new();
    let rectify = |more: &[&'static str]| [&["rectify", "p.png", "-o", "o.png"], more].concat();
    let cases = [
        (vec!["render", "s.json"], "--output <OUT>"),
        (vec!["render", "s.json", "-o", "o.bmp"], "o.bmp: has the unknown extension `.bmp`"),
        (vec!["render", "s.json", "-o", "o"], "o: has no extension"),
        (vec!["draw"], "unrecognized subcommand 'draw'"),
        (
            vec!["overlay", "p.png", "--camera", "c", "--scene", "s", "-o", "o.pdf"],
            "name the output .svg, .png",
        ),
        (vec!["overlay", "p.png", "--camera", "c", "-o", "o.svg"], "--scene <SCENE.json>|--plane"),
        (
            vec!["overlay", "p.png", "--camera", "c", "--plane", "p", "--mesh", "m", "-o", "o.svg"],
            "cannot be used with",
        ),
        (rectify(&["--size", "10x10"]), "--plane <PLANE.json>|--quad"),
        (rectify(&["--plane", "p.json", "--size", "10x10"]), "--camera <CAMERA.json>"),
        (rectify(&["--quad", "0,0 1,0 1,1 0,1"]), "--size"),
        (rectify(&["--quad", "0,0 1,0 1,1", "--size", "9x9"]), "expected four points"),
        (rectify(&["--quad", "0,0 1,0 1,1 0,NaN", "--size", "9x9"]), "expected four points"),
        (
            rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "0x0"]),
            "a side must be from 1 to 70000",
        ),
        (
            rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "9x70001"]),
            "a side must be from 1 to 70000",
        ),
        (
            rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "70000x70000"]),
            "are more than 268435456",
        ),
        (rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "9"]), "as 800x600"),
        (rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "9x-9"]), "`-9` is not a whole number"),
        (rectify(&["--quad", "0,0 1,0 1,1 0,1", "--gsd", "1"]), "cannot be used with"),
        (
            rectify(&["--camera", "c", "--plane", "p", "--gsd", "0"]),
            "expected a finite number above 0",
        ),
        (
            rectify(&["--camera", "c", "--plane", "p", "--gsd", "nan"]),
            "expected a finite number above 0",
        ),
        (
            rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "9x9", "--border", "constant:1,2"]),
            "`1,2` is no colour",
        ),
        (
            rectify(&["--quad", "0,0 1,0 1,1 0,1", "--size", "9x9", "--border", "wrap"]),
            "expected transparent",
        ),
        (vec!["project", "--camera", "c", "--inverse", "p.csv"], "--plane"),
    ];
    for (arguments, reason) in cases {
        let run = folder.run(&arguments);
        assert_eq!(run.code, 2, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.starts_with("collinear: error: "), "{}", run.stderr);
        assert!(run.stderr.contains(reason), "{arguments:?}: {}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    }
    assert_eq!(folder.files(), Vec::<String>::new());
    let run = folder.run(&[]);
    assert!(run.code == 2 && run.stderr.contains("Usage: collinear <COMMAND>"), "{run:?}");
}

#[test]
fn a_bad_input_is_named_and_leaves_the_old_output_alone() {
    let folder = Folder::new();
    folder.draw("photo.png", [40, 30], label).draw("wide.png", [41, 30], label);
    let bytes = fs::read(folder.path("photo.png")).unwrap();
    folder.write("cut.png", &bytes[..bytes.len() / 2]).write("text.png", "no picture");
    folder.write("camera.json", document("camera", &vertical(40, 30, "")));
    folder
        .write("broken.json", document("camera", &vertical(40, 30, "").replace("100", "\"100\"")));
    folder.write("nan.json", document("camera", &vertical(40, 30, "").replace("100", "NaN")));
    folder.write("lens.json", document("camera", &vertical(40, 30, r#", "k": [0.1, 0, 0]"#)));
    folder.write("plane.json", ground(""));
    folder.write(
        "through.json",
        document("plane", r#""point": [0, 0, 9], "normal": [1, 0, 0]"#).replace(
            "[1, 0, 0]",
            r#"[1, 0, 0], "rectangle": { "left": 0, "bottom": 0, "right": 1, "top": 1 }"#,
        ),
    );
    folder.write(
        "upside.json",
        ground(r#", "rectangle": { "left": 1, "bottom": 0, "right": 0, "top": 1 }"#),
    );
    folder.write("edge.json", document("plane", r#""point": [0, 0, 9], "normal": [1, 0, 0]"#));
    folder.write("map.json", document("camera", &map_view(40, 30)));
    folder.write("long.json", document("camera", &vertical(40, 30, "").replace("100", "1e308")));
    folder.write("points.csv", "X,Y,Z\n1,2,3\n1,2,NaN\n");
    folder.write("empty.csv", "").write("comment.csv", "# later\n");
    folder.write("bare.obj", "v 1 2 3\nv 4 5 6\nf 1\n").write("empty.obj", "");
    let scene = |photographs: &str, polygons: &str, view: &str| {
        document("scene", &format!(r#"{photographs} "polygons": [{polygons}], "view": {view}"#))
    };
    let view = format!("{{ {} }}", map_view(20, 20));
    let photo = |image: &str, camera: &str| {
        format!(r#""photographs": [{{ "name": "p", "image": "{image}", "camera": "{camera}" }}],"#)
    };
    let shown = r#"{ "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "photograph": "p" }"#;
    folder.write("unknown.json", scene("", shown, &view));
    folder.write("missing.json", scene(&photo("gone.png", "camera.json"), shown, &view));
    folder.write("cut.json", scene(&photo("cut.png", "camera.json"), shown, &view));
    folder.write("size.json", scene(&photo("wide.png", "camera.json"), shown, &view));
    folder.write("view.json", scene("", "", "\"lens.json\", \"interpolation\": \"linear\""));
    folder.write("eye.json", scene("", "", "\"gone.json\""));
    folder.write("dot.json", scene(&photo("photo.png", "."), shown, &view));
    folder.write("void.json", scene("", "", &view));
    let brick = r#""textures": [{ "name": "b", "image": "gone.png" }],"#;
    let laid = r#"{ "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "texture": "b", "coordinates": [[0, 0], [1, 0], [0, 1]] }"#;
    folder.write("brick.json", scene(brick, laid, &view));
    folder
        .write("huge.json", scene("", "", &view.replace("\"width\": 20", "\"width\": 4000000000")));
    folder.write("vertex.json", scene("", &shown.replace("[1, 0, 0]", "[1, 0]"), &view));

    let rectify = |camera: &'static str, plane: &'static str, photo: &'static str| {
        vec![
            "rectify", photo, "--camera", camera, "--plane", plane, "--size", "8x8", "-o",
            "out.png",
        ]
    };
    let render = |scene: &'static str| vec!["render", scene, "-o", "out.png"];
    let overlay = |kind: &'static str, file: &'static str| {
        vec!["overlay", "photo.png", "--camera", "camera.json", kind, file, "-o", "out.png"]
    };
    let project =
        |points: &'static str| vec!["project", "--camera", "camera.json", points, "-o", "out.png"];
    let cases = [
        (render("none.json"), "none.json: cannot be read: "),
        (
            render("unknown.json"),
            "unknown.json: polygons[0].photograph: names a photograph `p`, which is not there",
        ),
        (render("missing.json"), "missing.json: photographs[0].image: gone.png: cannot be read: "),
        (render("cut.json"), "cut.json: photographs[0].image: cut.png: is cut off after "),
        (
            render("size.json"),
            "size.json: photographs[0].image: wide.png: is 41 × 30 pixels, its camera says 40 × 30",
        ),
        (render("dot.json"), "dot.json: photographs[0].camera: .: cannot be read: Is a directory"),
        (render("eye.json"), "eye.json: view: gone.json: cannot be read: "),
        (
            render("brick.json"),
            "brick.json: textures[0].image: gone.png: cannot be read: No such file",
        ),
        (
            render("view.json"),
            "view.json: interpolation: wrong ones are drawn in a view of the model `pinhole`",
        ),
        (
            render("huge.json"),
            "huge.json: view: a picture of 4000000000 × 20 pixels: a side must be",
        ),
        (render("vertex.json"), "vertex.json: polygons[0].vertices[1]"),
        (rectify("camera.json", "none.json", "photo.png"), "none.json: cannot be read: "),
        (rectify("none.json", "plane.json", "photo.png"), "none.json: cannot be read: "),
        (
            rectify("broken.json", "plane.json", "photo.png"),
            "broken.json: interior.principal_distance[0]: expected a number",
        ),
        (rectify("nan.json", "plane.json", "photo.png"), "nan.json: "),
        (
            rectify("camera.json", "upside.json", "photo.png"),
            "upside.json: rectangle.right: is 0, expected a finite number above left",
        ),
        (
            rectify("camera.json", "through.json", "photo.png"),
            "through.json: the camera lies in the plane and sees it as a line: its projection centre is 0 off it",
        ),
        (
            rectify("camera.json", "edge.json", "photo.png"),
            "edge.json: the camera lies in the plane and sees it as a line: its projection centre is 0 off it",
        ),
        (
            rectify("map.json", "edge.json", "photo.png"),
            "edge.json: the camera looks along the plane and sees it as a line: the sine of their angle is 0",
        ),
        (
            rectify("long.json", "plane.json", "photo.png"),
            "long.json: interior.principal_distance[0]: is 1e308, expected a number from 1e-6 to 1e9",
        ),
        (rectify("camera.json", "plane.json", "none.png"), "none.png: cannot be read: "),
        (rectify("camera.json", "plane.json", "cut.png"), "cut.png: is cut off after "),
        (
            rectify("camera.json", "plane.json", "text.png"),
            "text.png: is neither PNG, JPEG nor TIFF",
        ),
        (rectify("camera.json", "plane.json", "wide.png"), "wide.png: is 41 × 30 pixels"),
        (
            vec![
                "rectify",
                "photo.png",
                "--quad",
                "0,0 9,9 9,0 0,9",
                "--size",
                "8x8",
                "-o",
                "out.png",
            ],
            "--quad: the quad is folded or concave",
        ),
        (
            vec![
                "rectify",
                "photo.png",
                "--camera",
                "camera.json",
                "--plane",
                "plane.json",
                "--gsd",
                "1e-5",
                "-o",
                "out.png",
            ],
            "plane.json: at 1e-5 units a pixel the rectangle has 400000 × 300000 pixels",
        ),
        (
            vec!["project", "--camera", "camera.json", "points.csv", "-o", "out.png"],
            "points.csv: line 3, field 3: Z is `NaN`",
        ),
        (project("empty.csv"), "empty.csv: is empty: neither a header nor a point is in it"),
        (project("comment.csv"), "comment.csv: is empty: neither a header nor a point is in it"),
        (
            overlay("--mesh", "photo.png"),
            "photo.png: is no text: a Wavefront OBJ file is needed here",
        ),
        (overlay("--mesh", "bare.obj"), "bare.obj: there are no faces and no lines in it"),
        (overlay("--mesh", "empty.obj"), "empty.obj: there are no faces and no lines in it"),
        (overlay("--scene", "void.json"), "void.json: polygons: there are none, nothing to draw"),
        (
            vec![
                "overlay",
                "photo.png",
                "--camera",
                "camera.json",
                "--plane",
                "plane.json",
                "-o",
                "out.png",
            ],
            "plane.json: has no `rectangle`",
        ),
        (
            vec![
                "overlay",
                "cut.png",
                "--camera",
                "camera.json",
                "--plane",
                "upside.json",
                "-o",
                "out.png",
            ],
            "upside.json: rectangle.right",
        ),
        (
            vec![
                "overlay",
                "photo.png",
                "--camera",
                "camera.json",
                "--mesh",
                "none.obj",
                "-o",
                "out.png",
            ],
            "none.obj: cannot be read: ",
        ),
    ];
    folder.write("out.png", "old");
    let before = folder.files();
    for (arguments, reason) in cases {
        let run = folder.run(&arguments);
        assert_eq!(run.code, 1, "{arguments:?}: {}", run.stderr);
        assert!(
            run.stderr.starts_with(&format!("collinear: error: {reason}")),
            "{arguments:?}: {}",
            run.stderr
        );
        assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
        assert_eq!((run.stdout.as_str(), folder.text("out.png").as_str()), ("", "old"));
        assert_eq!(folder.files(), before, "{arguments:?}");
    }
}

#[test]
fn no_number_makes_a_command_panic() {
    let folder = Folder::new();
    folder.draw("photo.png", [40, 30], label);
    let numbers = ["1e300", "-1e300", "5e-324", "0"];
    let mut codes = [0, 0];
    let mut run = |arguments: &[&str]| {
        let run = folder.run(arguments);
        assert!((0..=1).contains(&run.code), "{arguments:?}: {} {}", run.code, run.stderr);
        codes[run.code as usize] += 1;
    };
    let polygon = r#"{ "vertices": [[-1, -1, 0], [1, -1, 0], [N, 1, 0], [-1, 1, 0]], "photograph": "p" },
        { "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, N]], "color": [1, 2, 3] }"#;
    for n in numbers {
        // A number in the camera, in the world, and in the plane.
        for (camera, rest) in [
            (vertical(40, 30, "").replace("[100, 100]", &format!("[{n}, {n}]")), "1"),
            (vertical(40, 30, "").replace("[0, 0, 10]", &format!("[{n}, 0, 10]")), "1"),
            (vertical(40, 30, &format!(r#", "k": [{n}, 0, {n}]"#)), "1"),
            (vertical(40, 30, r#", "k": [-0.2, 0, 0]"#), n),
        ] {
            folder.write("camera.json", document("camera", &camera));
            let photographs = r#""photographs": [{ "name": "p", "image": "photo.png", "camera": "camera.json" }]"#;
            let polygons = polygon.replace('N', rest);
            let view = if camera.contains("brown") { map_view(20, 20) } else { camera.clone() };
            let scene = format!(r#"{photographs}, "polygons": [{polygons}], "view": {{ {view} }}"#);
            folder.write("scene.json", document("scene", &scene));
            folder.write("mesh.obj", format!("v {rest} 0 0\nv 0 1 {rest}\nv -1 0 0\nf 1 2 3\n"));
            folder.write("points.csv", format!("{rest},0,0\n0,0,{rest}\n"));
            folder.write("clicks.csv", format!("{rest},0\n20,{rest}\n"));
            let rectangle = format!(
                r#", "rectangle": {{ "left": -1, "bottom": -1, "right": {rest}, "top": 1 }}"#
            );
            folder.write("plane.json", ground(&rectangle)).write("open.json", ground(""));
            let with_camera = ["--camera", "camera.json"];
            run(&["render", "scene.json", "-o", "out.png"]);
            run(&[
                &[
                    "rectify",
                    "photo.png",
                    "--plane",
                    "plane.json",
                    "--size",
                    "8x8",
                    "-o",
                    "out.png",
                ],
                &with_camera[..],
            ]
            .concat());
            run(&[
                &["rectify", "photo.png", "--plane", "open.json", "--gsd", "1", "-o", "out.png"],
                &with_camera[..],
            ]
            .concat());
            run(&[&["project", "points.csv"], &with_camera[..]].concat());
            run(&[
                &["project", "--inverse", "--plane", "open.json", "clicks.csv"],
                &with_camera[..],
            ]
            .concat());
            run(&[
                &["overlay", "photo.png", "--mesh", "mesh.obj", "-o", "out.png"],
                &with_camera[..],
            ]
            .concat());
            run(&[
                &["overlay", "photo.png", "--scene", "scene.json", "-o", "out.svg"],
                &with_camera[..],
            ]
            .concat());
        }
        let quad = format!("{n},0 30,1 29,20 2,{n}");
        run(&["rectify", "photo.png", "--quad", &quad, "--size", "8x8", "-o", "out.png"]);
    }
    assert!(codes.iter().all(|c| *c > 15), "{codes:?}");
}
