//! Scenes: references, counts, defaults, camera files beside them.

use collinear_io::camera::CameraFile;
use collinear_io::scene::{
    Border, Cull, Fill, Filter, Interpolation, SceneFile, SensorSource, TexturePoint,
};
use collinear_io::sensor::SensorFile;
use collinear_io::{Document, ErrorKind};

const CAMERA: &str = r#"{ "width": 640, "height": 480,
  "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 240] },
  "exterior": { "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] } }"#;

/// Where [`CAMERA`] stands.
const EYE: [f64; 3] = [0.0; 3];

const SCENE: &str = r#"{ "collinear": "scene", "version": 1,
"photographs": [
  { "name": "north", "image": "n.jpg", "camera": CAMERA },
  { "name": "south", "image": "pictures/s.jpg", "camera": CAMERA }
],
"textures": [ { "name": "brick", "image": "brick.png", "border": "repeat" } ],
"polygons": [
  { "name": "wall", "vertices": [[0, 0, 5], [3, 0, 5], [3, 4, 5]], "photograph": "south" },
  { "vertices": [[0, 0, 5], [3, 0, 5], [3, 4, 5]], "texture": "brick", "coordinates": [[0, 0], [8, 0], [8, 8, 2]] },
  { "vertices": [[0, 0, 5], [30, 0, 40], [3, 4, 5]], "color": [1, 2, 255] }
],
"view": CAMERA }"#;

fn parse(from: &str, to: &str) -> Result<SceneFile, collinear_io::Error> {
    assert!(from.is_empty() || SCENE.contains(from), "{from} is not in the template");
    SceneFile::parse(&SCENE.replacen(from, to, 1).replace("CAMERA", CAMERA))
}

fn error(from: &str, to: &str) -> String {
    parse(from, to).unwrap_err().to_string()
}

#[test]
fn a_scene_has_the_documented_defaults() {
    let scene = parse("", "").unwrap();
    assert_eq!(scene.background, [0, 0, 0]);
    assert_eq!(
        (scene.cull, scene.filter, scene.interpolation),
        (Cull::None, Filter::Bilinear, Interpolation::Perspective)
    );
    assert_eq!(scene.textures[0].border, Border::Repeat);
    // The farthest vertex is (30, 0, 40), 50 away.
    assert!((scene.near_distance(&EYE) - 5e-5).abs() < 1e-18);
    let Fill::Texture { coordinates, .. } = &scene.polygons[1].fill else { panic!("a texture") };
    assert_eq!(coordinates[1], TexturePoint { u: 8.0, v: 0.0, w: 1.0 });
    assert_eq!(coordinates[2], TexturePoint { u: 8.0, v: 8.0, w: 2.0 });
    assert_eq!(scene.polygons[2].fill, Fill::Color([1, 2, 255]));
    let bare = parse(
        r#""textures": [ { "name": "brick", "image": "brick.png", "border": "repeat" } ],"#,
        r#""textures": [ { "name": "brick", "image": "brick.png" } ], "near": 2.5,"#,
    )
    .unwrap();
    assert_eq!(bare.textures[0].border, Border::Clamp);
    assert_eq!(bare.near_distance(&EYE), 2.5);
}

#[test]
fn a_scene_survives_its_file() {
    for options in [
        "",
        r#""near": 0.25, "cull": "back", "filter": "nearest", "interpolation": "bilinear", "background": [9, 8, 7],"#,
    ] {
        let scene = parse(r#""polygons""#, &format!(r#"{options} "polygons""#)).unwrap();
        assert_eq!(SceneFile::parse(&scene.to_json().unwrap()).unwrap(), scene);
    }
}

#[test]
fn references_counts_and_names_are_checked_with_the_path_to_the_field() {
    for (from, to, expected) in [
        (
            r#""photograph": "south""#,
            r#""photograph": "west""#,
            "polygons[0].photograph: names a photograph `west`, which is not there: there are `north`, `south`",
        ),
        (
            r#""texture": "brick""#,
            r#""texture": "stone""#,
            "polygons[1].texture: names a texture `stone`, which is not there: there are `brick`",
        ),
        (
            r#""texture": "brick""#,
            r#""texture": "south""#,
            "polygons[1].texture: names a texture `south`, which is not there: there are `brick`",
        ),
        (
            ", [8, 8, 2]]",
            "]",
            "polygons[1].coordinates: has 2 entries, 3 are needed: one for each of the vertices",
        ),
        (
            "[8, 8, 2]",
            "[8, 8, 0]",
            "polygons[1].coordinates[2][2]: is 0, expected a weight above 0",
        ),
        (
            "[8, 8, 2]",
            "[8, 8, -2]",
            "polygons[1].coordinates[2][2]: is -2, expected a weight above 0",
        ),
        (", [3, 4, 5]]", "]", "polygons[0].vertices: has 2 entries, at least 3 are needed"),
        (
            r#""south", "image""#,
            r#""north", "image""#,
            "photographs[1].name: is `north` like photographs[0].name: names must differ",
        ),
        (
            r#"{ "vertices""#,
            r#"{ "name": "wall", "vertices""#,
            "polygons[1].name: is `wall` like polygons[0].name: names must differ",
        ),
        (r#""view""#, r#""near": 0, "view""#, "near: is 0, expected a finite number above 0"),
    ] {
        assert_eq!(error(from, to), expected);
    }
}

#[test]
fn shapes_are_checked_with_the_path_to_the_field() {
    for (from, to, expected) in [
        (
            "[3, 0, 5]",
            "[3, 0, \"5\"]",
            "polygons[0].vertices[1][2]: expected a number, found the string \"5\" (line 12, ",
        ),
        (
            "[3, 0, 5]",
            "[3, 0]",
            "polygons[0].vertices[1]: expected a list of 3, found 2 entries (line 12, ",
        ),
        (
            "[8, 0]",
            "[8]",
            "polygons[1].coordinates[1]: expected a list of 2 or 3, found 1 entries (line 13, ",
        ),
        (
            "[8, 0]",
            "[8, 0, 1, 1]",
            "polygons[1].coordinates[1]: has more entries than expected (line 13, ",
        ),
        (
            "[1, 2, 255]",
            "[1, 2, 256]",
            "polygons[2].color[2]: expected a whole number from 0 to 255, found 256 (line 14, ",
        ),
        (
            r#""photograph": "south""#,
            r#""photograph": "south", "color": [0, 0, 0]"#,
            "polygons[0]: give exactly one of `photograph`, `texture`, `color` (line ",
        ),
        (
            r#", "photograph": "south""#,
            "",
            "polygons[0]: give exactly one of `photograph`, `texture`, `color` (line ",
        ),
        (
            r#""photograph": "south""#,
            r#""photograph": "south", "coordinates": []"#,
            "polygons[0]: has `coordinates`, which only a `texture` uses (line ",
        ),
        (
            r#", "coordinates": [[0, 0], [8, 0], [8, 8, 2]]"#,
            "",
            "polygons[1]: has a `texture` and needs `coordinates`, one for each vertex (line ",
        ),
        (
            "\"repeat\"",
            "\"tile\"",
            "textures[0].border: expected one of `clamp`, `repeat`, `mirror`, `transparent`, found `tile` (line 10, ",
        ),
        (
            r#""view": CAMERA"#,
            r#""view": 3"#,
            "view: expected a camera or the path of a camera file, found 3 (line 16, ",
        ),
        (
            r#"{ "name": "brick", "image": "brick.png", "border": "repeat" }"#,
            r#"["brick", "brick.png", "repeat"]"#,
            "textures[0]: expected an object, found a list (line 10, ",
        ),
        (
            r#"{ "name": "wall""#,
            r#"[], { "name": "wall""#,
            "polygons[0]: expected an object, found a list (line 12, ",
        ),
        (r#""view""#, r#""veiw""#, "veiw: unknown field, did you mean `view`? (line 16, "),
    ] {
        let got = error(from, to);
        assert!(got.starts_with(expected), "{got}");
    }
    let inside = SCENE
        .replacen("CAMERA", &CAMERA.replace("[320, 240]", "[320, true]"), 1)
        .replace("CAMERA", CAMERA);
    let got = SceneFile::parse(&inside).unwrap_err().to_string();
    assert!(got.starts_with("photographs[0].camera.interior.principal_point[1]: expected a number, found true (line 4, "), "{got}");
    let inside = SCENE.replacen("CAMERA", &CAMERA.replace("640", "0"), 1).replace("CAMERA", CAMERA);
    assert_eq!(
        SceneFile::parse(&inside).unwrap_err().to_string(),
        "photographs[0].camera.width: is 0, expected at least 1 pixel"
    );
}

#[test]
fn a_view_and_a_photograph_may_be_of_any_model_and_of_a_scanner() {
    for model in [
        r#""model": "brown", "k": [0.1, 0, 0]"#,
        r#""model": "fisheye", "projection": "equidistant""#,
        r#""model": "cylindrical""#,
    ] {
        let camera = CAMERA.replace(r#""model": "pinhole""#, model);
        let scene = parse("\"view\": CAMERA", &format!("\"view\": {camera}")).unwrap();
        assert_eq!(SceneFile::parse(&scene.to_json().unwrap()).unwrap(), scene);
    }
    let scanner = r#"{ "width": 640, "height": 100,
        "scan": { "kind": "pushbroom", "row": 0.5, "per_line": 1 },
        "interior": { "model": "pinhole", "principal_distance": [500, 500], "principal_point": [320, 0.5] },
        "trajectory": { "exterior": { "projection_center": [0, 0, 9], "quaternion_wxyz": [0, 1, 0, 0] },
            "position_polynomial": [[0, 0, 0], [0, 0.2, 0]] } }"#;
    let inline = format!(r#"{{ "scanner": {scanner} }}"#);
    for key in ["\"view\": CAMERA", "\"camera\": CAMERA"] {
        let scene = parse(key, &key.replace("CAMERA", &inline)).unwrap();
        let source = if key.contains("view") { &scene.view } else { &scene.photographs[0].camera };
        let SensorSource::Inline(SensorFile::Scanner(file)) = source else { panic!("{source:?}") };
        assert_eq!((file.width, file.height), (640, 100));
        assert_eq!(SceneFile::parse(&scene.to_json().unwrap()).unwrap(), scene);
    }
    // Errors have the path of the bad field, behind the key and without it.
    let bad = inline.replace("\"width\": 640", "\"width\": true");
    let got = error("\"view\": CAMERA", &format!("\"view\": {bad}"));
    assert!(got.starts_with("view.scanner.width: expected a whole number"), "{got}");
    let got = error("\"view\": CAMERA", &format!("\"view\": {}", inline.replace("640", "0")));
    assert!(got.starts_with("view.scanner.width: is 0"), "{got}");
    let got = error("\"view\": CAMERA", "\"view\": {}");
    assert!(got.starts_with("view: missing field `width`"), "{got}");
    let more = inline.replacen("\"scanner\"", "\"width\": 3, \"scanner\"", 1);
    let got = error("\"view\": CAMERA", &format!("\"view\": {more}"));
    assert!(got.contains("scanner"), "{got}");
    let more = format!(r#"{{ "scanner": {scanner}, "width": 3 }}"#);
    let got = error("\"view\": CAMERA", &format!("\"view\": {more}"));
    assert!(got.starts_with("view: unknown field, remove it"), "{got}");
    // So may a rational polynomial camera, where it says its size and its world.
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md");
    let page = std::fs::read_to_string(page).unwrap();
    let rpc = page.split("## rpc").nth(1).unwrap().split("```json").nth(1).unwrap();
    let rpc =
        rpc.split("```").next().unwrap().replace("\"collinear\": \"rpc\", \"version\": 1,", "");
    let view = format!(r#""view": {{ "rpc": {rpc} }}"#);
    let scene = parse("\"view\": CAMERA", &view).unwrap();
    assert!(matches!(scene.view, SensorSource::Inline(SensorFile::Rpc(_))));
    assert_eq!(SceneFile::parse(&scene.to_json().unwrap()).unwrap(), scene);
    let got = error("\"view\": CAMERA", &view.replace("\"width\": 10000, ", ""));
    assert!(got.starts_with("view.rpc.width: is not given"), "{got}");
    // A file may be any.
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "strip.json",
        &scanner.replacen('{', "{ \"collinear\": \"scanner\", \"version\": 1, ", 1),
    );
    write(
        "scene.json",
        &SCENE.replace("\"view\": CAMERA", "\"view\": \"strip.json\"").replace("CAMERA", CAMERA),
    );
    let scene = SceneFile::open(&folder.path().join("scene.json")).unwrap();
    assert!(matches!(scene.view, SensorSource::Inline(SensorFile::Scanner(_))));
}

#[test]
fn camera_files_are_found_from_the_scene_and_named_in_its_errors() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write(
        "scene.json",
        &SCENE.replacen("CAMERA", "\"cameras/n.json\"", 1).replace("CAMERA", CAMERA),
    );
    let path = folder.path().join("scene.json");

    let scene = SceneFile::read(&path).unwrap();
    assert_eq!(scene.photographs[0].camera, SensorSource::File("cameras/n.json".into()));
    let missing = SceneFile::open(&path).unwrap_err();
    assert_eq!(missing.path(), Some(folder.path().join("cameras/n.json").as_path()));
    assert_eq!(missing.field(), Some("photographs[0].camera"));
    let start = format!("{}: photographs[0].camera: ", path.display());
    assert!(missing.to_string().starts_with(&start), "{missing}");
    let n = folder.path().join("cameras/n.json");
    assert!(
        missing.to_string()[start.len()..]
            .starts_with(&format!("{}: cannot be read: ", n.display())),
        "{missing}"
    );
    assert_eq!(
        scene.files("town".as_ref()),
        [
            ("photographs[0].image".to_owned(), "town/n.jpg".into()),
            ("photographs[0].camera".to_owned(), "town/cameras/n.json".into()),
            ("photographs[1].image".to_owned(), "town/pictures/s.jpg".into()),
            ("textures[0].image".to_owned(), "town/brick.png".into()),
        ]
    );

    std::fs::create_dir(folder.path().join("cameras")).unwrap();
    let file = CAMERA.replacen('{', "{ \"collinear\": \"camera\", \"version\": 1, ", 1);
    write("cameras/n.json", &file.replace("240", "-"));
    let broken = SceneFile::open(&path).unwrap_err();
    assert!(matches!(broken.kind(), ErrorKind::Json { .. }), "{broken}");
    assert_eq!(broken.path(), Some(folder.path().join("cameras/n.json").as_path()));

    write("cameras/n.json", &file);
    let open = SceneFile::open(&path).unwrap();
    assert_eq!(
        open.photographs[0].camera,
        SensorSource::Inline(CameraFile::parse(&file).unwrap().into())
    );
    assert_eq!(open.photographs[1].image, folder.path().join("pictures/s.jpg"));
}
