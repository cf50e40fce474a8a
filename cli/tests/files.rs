//! Outputs: none replaces an input or another output, and their folders are made.

use std::fs;

use crate::support::{Folder, document, label, map_view, vertical};

const GROUND: &str = r#""point": [0, 0, 0], "normal": [0, 0, 1],
    "rectangle": { "left": -1, "bottom": -1, "right": 1, "top": 1 }"#;

/// A file of every kind that a command reads.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.draw("photo.png", [40, 30], label).draw("brick.png", [8, 8], label);
    folder.write("camera.json", document("camera", &vertical(40, 30, "")));
    folder.write("view.json", document("camera", &map_view(40, 30)));
    folder.write("plane.json", document("plane", GROUND));
    folder.write("points.csv", "0,0,0\n").write("mesh.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n");
    let scene = r#""photographs": [{ "name": "p", "image": "photo.png", "camera": "camera.json" }],
        "textures": [{ "name": "b", "image": "brick.png" }], "view": "view.json",
        "polygons": [{ "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0]], "photograph": "p" }]"#;
    fs::create_dir(folder.path("town")).unwrap();
    folder.write("scene.json", document("scene", scene));
    folder
}

/// Every file's bytes.
fn contents(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| fs::read(folder.path(&name)).ok().map(|bytes| (name, bytes));
    folder.files().into_iter().filter_map(read).collect()
}

fn refused(folder: &Folder, arguments: &[&str], reason: &str) {
    let before = contents(folder);
    let run = folder.run(arguments);
    assert_eq!(run.code, 2, "{arguments:?}: {}", run.stderr);
    let expected = format!("collinear: error: {reason}: name another output\n");
    assert_eq!(run.stderr, expected, "{arguments:?}");
    assert_eq!(run.stdout, "");
    assert_eq!(contents(folder), before, "{arguments:?}");
}

const RECTIFY: [&str; 8] =
    ["rectify", "photo.png", "--camera", "camera.json", "--plane", "plane.json", "--size", "8x8"];
const PROJECT: [&str; 4] = ["project", "--camera", "camera.json", "points.csv"];
const OVERLAY: [&str; 4] = ["overlay", "photo.png", "--camera", "camera.json"];

#[test]
fn an_output_that_is_an_input_is_refused() {
    let folder = folder();
    let with = |start: &[&'static str], more: &[&'static str]| [start, more].concat();
    let cases = [
        (
            with(&RECTIFY, &["-o", "photo.png"]),
            "photo.png is both the output (-o) and the photograph",
        ),
        (
            with(&RECTIFY, &["-o", "o.png", "--map-out", "photo.png"]),
            "photo.png is both the map (--map-out) and the photograph",
        ),
        (
            with(&RECTIFY, &["-o", "o.png", "--map-out", "plane.json"]),
            "plane.json is both the map (--map-out) and the plane",
        ),
        (
            with(&RECTIFY, &["-o", "o.png", "--map-out", "camera.json"]),
            "camera.json is both the map (--map-out) and the camera",
        ),
        (
            with(&RECTIFY, &["-o", "o.png", "--map-out", "o.png"]),
            "o.png is both the output (-o) and the map (--map-out)",
        ),
        (
            with(&RECTIFY, &["-o", "new/o.png", "--map-out", "new/a/.././o.png"]),
            "new/o.png, the output (-o), and new/a/.././o.png, the map (--map-out), are the same file",
        ),
        (
            with(&PROJECT, &["-o", "camera.json"]),
            "camera.json is both the output (-o) and the camera",
        ),
        (
            with(&PROJECT, &["-o", "points.csv"]),
            "points.csv is both the output (-o) and the points",
        ),
        (
            with(&PROJECT, &["--inverse", "--plane", "plane.json", "-o", "./plane.json"]),
            "./plane.json, the output (-o), and plane.json, the plane, are the same file",
        ),
        (
            with(&OVERLAY, &["--mesh", "mesh.obj", "-o", "town/../photo.png"]),
            "town/../photo.png, the output (-o), and photo.png, the photograph, are the same file",
        ),
        (
            vec!["render", "scene.json", "-o", "photo.png"],
            "photo.png is both the output (-o) and photographs[0].image of scene.json",
        ),
        (
            vec!["render", "scene.json", "-o", "brick.png"],
            "brick.png is both the output (-o) and textures[0].image of scene.json",
        ),
        (
            with(&OVERLAY, &["--scene", "scene.json", "-o", "brick.png"]),
            "brick.png is both the output (-o) and textures[0].image of scene.json",
        ),
    ];
    for (arguments, reason) in cases {
        refused(&folder, &arguments, reason);
    }
    // Text files under the names of pictures.
    let rename = |from: &str, to: &str| {
        fs::rename(folder.path(from), folder.path(to)).unwrap();
    };
    rename("camera.json", "camera.png");
    rename("view.json", "view.png");
    rename("mesh.obj", "mesh.svg");
    let scene = folder.text("scene.json").replace("camera.json", "camera.png");
    folder.write("scene.png", scene.replace("view.json", "view.png"));
    let overlay = ["overlay", "photo.png", "--camera", "camera.png"];
    for (arguments, reason) in [
        (
            vec!["render", "scene.png", "-o", "scene.png"],
            "scene.png is both the output (-o) and the scene",
        ),
        (
            vec!["render", "scene.png", "-o", "camera.png"],
            "camera.png is both the output (-o) and photographs[0].camera of scene.png",
        ),
        (
            vec!["render", "scene.png", "-o", "view.png"],
            "view.png is both the output (-o) and view of scene.png",
        ),
        (
            with(&overlay, &["--scene", "scene.png", "-o", "scene.png"]),
            "scene.png is both the output (-o) and the scene",
        ),
        (
            with(&overlay, &["--mesh", "mesh.svg", "-o", "mesh.svg"]),
            "mesh.svg is both the output (-o) and the mesh",
        ),
        (
            with(&overlay, &["--mesh", "mesh.svg", "-o", "camera.png"]),
            "camera.png is both the output (-o) and the camera",
        ),
    ] {
        refused(&folder, &arguments, reason);
    }
}

#[cfg(unix)]
#[test]
fn a_file_is_known_behind_its_links() {
    use std::os::unix::fs::symlink;

    let folder = folder();
    symlink("photo.png", folder.path("soft.png")).unwrap();
    symlink(".", folder.path("here")).unwrap();
    fs::hard_link(folder.path("photo.png"), folder.path("hard.png")).unwrap();
    for output in ["soft.png", "hard.png", "here/photo.png", "here/here/hard.png"] {
        let reason =
            format!("{output}, the output (-o), and photo.png, the photograph, are the same file");
        refused(&folder, &[&RECTIFY[..], &["-o", output]].concat(), &reason);
        let reason = format!(
            "{output}, the output (-o), and photo.png, photographs[0].image of scene.json, are the same file"
        );
        refused(&folder, &["render", "scene.json", "-o", output], &reason);
    }
    // An output that is not there yet, under two names.
    let outputs = ["-o", "new.png", "--map-out", "here/new.png"];
    refused(
        &folder,
        &[&RECTIFY[..], &outputs].concat(),
        "new.png, the output (-o), and here/new.png, the map (--map-out), are the same file",
    );
    // An output that another run wrote is no input.
    for _ in 0..2 {
        folder.succeed(&[&RECTIFY[..], &["-o", "new.png", "--map-out", "map.json"]].concat());
    }
}

#[test]
fn folders_of_outputs_are_made() {
    let folder = folder();
    let outputs = ["-o", "a/b/out.png", "--map-out", "a/c/map.json"];
    folder.succeed(&[&RECTIFY[..], &outputs].concat());
    folder.succeed(&[&PROJECT[..], &["-o", "d/out.csv"]].concat());
    folder.succeed(&[&OVERLAY[..], &["--mesh", "mesh.obj", "-o", "e/out.svg"]].concat());
    folder.succeed(&[&OVERLAY[..], &["--mesh", "mesh.obj", "-o", "e/f/out.jpg"]].concat());
    folder.succeed(&["render", "scene.json", "-o", "g/out.jpg"]);
    for name in
        ["a/b/out.png", "a/c/map.json", "d/out.csv", "e/out.svg", "e/f/out.jpg", "g/out.jpg"]
    {
        assert!(folder.path(name).is_file(), "{name}");
    }
    let run = folder.run(&["render", "scene.json", "-o", "photo.png/out.png"]);
    assert_eq!(run.code, 1);
    let start = "collinear: error: photo.png/out.png: its folder photo.png cannot be made: ";
    assert!(run.stderr.starts_with(start), "{}", run.stderr);
    fs::create_dir(folder.path("folder.png")).unwrap();
    let run = folder.run(&["render", "scene.json", "-o", "folder.png"]);
    let reason = "collinear: error: folder.png: is a folder: name a file in it\n";
    assert_eq!((run.code, run.stderr.as_str()), (1, reason));
}
