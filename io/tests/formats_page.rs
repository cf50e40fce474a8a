//! Every example of docs/formats.md is a file that is read, and reads the same after it was written.

use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::control::parse_control;
use collinear_io::dome::DomeFile;
use collinear_io::map::MapFile;
use collinear_io::observations::parse_observations;
use collinear_io::observed::{parse_attitudes, parse_distances, parse_places, parse_positions};
use collinear_io::plane::PlaneFile;
use collinear_io::points::parse_points;
use collinear_io::rpc::RpcFile;
use collinear_io::scanner::ScannerFile;
use collinear_io::scene::SceneFile;
use collinear_io::sensor::SensorFile;

fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    page.split(&format!("```{language}\n")).skip(1).filter_map(|b| b.split("```").next()).collect()
}

fn survives<D: Document + PartialEq + std::fmt::Debug>(text: &str) {
    let document = D::parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(D::parse(&document.to_json().unwrap()).unwrap(), document);
}

/// The cells of the table's rows under a header.
fn rows<'a>(page: &'a str, header: &str) -> Vec<Vec<&'a str>> {
    let table = page.split_once(header).unwrap().1.lines().skip(2);
    let cells = |line: &'a str| line.trim_matches('|').split('|').map(str::trim).collect();
    table.take_while(|line| line.starts_with('|')).map(cells).collect()
}

/// The names in `code` of a text.
fn code(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_tables_of_interiors_have_every_model_and_field() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md"))
        .unwrap();
    let file = |fields: &str| {
        let exterior = r#"{ "projection_center": [0, 0, 0], "omega_phi_kappa": [0, 0, 0] }"#;
        let start = r#"{ "collinear": "camera", "version": 1, "width": 1024, "height": 768,"#;
        format!(r#"{start} "interior": {{ {fields} }}, "exterior": {exterior} }}"#)
    };
    let fields = rows(&page, "| field | models | meaning |");
    let names: Vec<&str> = fields.iter().map(|row| code(row[0])[0]).collect();
    let models = rows(&page, "| `model` | projection |");
    for row in &models {
        let model = code(row[0])[0];
        let own = code(row[3]).first().copied().unwrap_or_default();
        let mut all = vec![format!(r#""model": "{model}""#)];
        all.extend((!own.is_empty()).then(|| own.to_owned()));
        for (name, value, without) in [
            ("principal_distance", "[611.3, 598.7]", &["film", "colmap", "orthographic"][..]),
            ("principal_point", "[513.4, 391.9]", &["film", "colmap"]),
            ("skew", "0.7", &["equirectangular", "cylindrical", "film", "colmap", "orthographic"]),
        ] {
            all.extend((!without.contains(&model)).then(|| format!("\"{name}\": {value}")));
        }
        let text = file(&all.join(", "));
        survives::<CameraFile>(&text);
        let camera = CameraFile::parse(&text).unwrap();
        assert_eq!(camera.interior.model(), model);
        camera.camera().unwrap_or_else(|e| panic!("{model}: {e}"));
        // No field of the page is missing in the example, and none of another model is taken.
        for name in &names {
            let given = all.iter().any(|f| f.contains(&format!("\"{name}\":")));
            let value = match *name {
                "principal_distance" | "principal_point" | "principal_point_mm"
                | "pixels_per_unit" => "[1, 1]",
                "fiducials" => "[[1, 1, 1, 1]]",
                "projection" => "\"equisolid\"",
                "colmap_model" => "\"PINHOLE\"",
                "k" | "p" | "s" | "tau" | "b" | "parameters" => "[0]",
                _ => "0.5",
            };
            let more = file(&format!(r#"{}, "{name}": {value}"#, all.join(", ")));
            let error = CameraFile::parse(&more).unwrap_err().to_string();
            let expected = match given {
                true => format!("duplicate field `{name}`"),
                false => format!("the model `{model}` has no `{name}`"),
            };
            assert!(error.contains(&expected), "{model}, {name}: {error}");
        }
    }
    let error = CameraFile::parse(&file(r#""model": "none""#)).unwrap_err().to_string();
    let known = error.split(", found").next().unwrap();
    assert_eq!(code(known), models.iter().map(|r| code(r[0])[0]).collect::<Vec<_>>());
    let error = CameraFile::parse(&file(r#""model": "pinhole", "xyzzy": 1"#)).unwrap_err();
    let error = error.to_string();
    let mut known = code(error.split("fields here are").nth(1).unwrap());
    known.retain(|name| *name != "model");
    known.sort_unstable();
    let mut names = names;
    names.sort_unstable();
    assert_eq!(known, names);
}

#[test]
fn the_examples_of_the_formats_page_are_files() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md"))
        .unwrap();
    let mut kinds = Vec::new();
    for text in blocks(&page, "json") {
        let kind = text.split('"').nth(3).unwrap();
        kinds.push(kind);
        match kind {
            "camera" => survives::<CameraFile>(text),
            "scanner" => {
                survives::<ScannerFile>(text);
                ScannerFile::parse(text)
                    .unwrap()
                    .sensor()
                    .unwrap_or_else(|e| panic!("{e}\n{text}"));
            }
            "plane" => survives::<PlaneFile>(text),
            "dome" => {
                survives::<DomeFile>(text);
                DomeFile::parse(text).unwrap().dome().unwrap();
            }
            "map" => survives::<MapFile>(text),
            "rpc" => {
                survives::<RpcFile>(text);
                RpcFile::parse(text).unwrap().rpc().unwrap();
                SensorFile::parse(text).unwrap().sensor().unwrap();
            }
            "scene" => survives::<SceneFile>(text),
            other => panic!("an example of an unknown kind {other}"),
        }
    }
    kinds.dedup();
    assert_eq!(kinds, ["camera", "scanner", "plane", "dome", "map", "rpc", "scene"]);
    let [points, control, observations, positions, attitudes, distances] = blocks(&page, "csv")[..]
    else {
        panic!("six tables")
    };
    assert_eq!(parse_points(points).unwrap().len(), 2);
    let rows = parse_control(control).unwrap();
    assert_eq!((rows[0].image_sigma, rows[0].world_sigma), (Some([0.3; 2]), None));
    assert_eq!(rows[1].world_sigma, Some([0.02, 0.02, 0.05]));
    assert_eq!(parse_observations(observations).unwrap().len(), 2);
    assert_eq!(parse_positions(positions).unwrap()[0].lever_arm, Some([0.1, 0.0, -0.35]));
    assert_eq!(parse_attitudes(attitudes).unwrap().len(), 1);
    assert_eq!(parse_distances(distances).unwrap()[0].ends, ["church", "well"]);
    assert_eq!(parse_places(control).unwrap()[1].sigma, Some([0.02, 0.02, 0.05]));
}

#[test]
fn the_table_of_rational_cameras_has_every_field() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md"))
        .unwrap();
    let mut names: Vec<&str> = rows(page.split_once("## rpc").unwrap().1, "| field | meaning |")
        .iter()
        .flat_map(|row| code(row[0]))
        .collect();
    let example = blocks(&page, "json").into_iter().find(|t| t.contains("\"rpc\"")).unwrap();
    let error = RpcFile::parse(&example.replacen("\"line_offset\"", "\"xyzzy\"", 1)).unwrap_err();
    let error = error.to_string();
    let mut known = code(error.split("fields here are").nth(1).unwrap());
    known.sort_unstable();
    names.sort_unstable();
    assert_eq!(known, names, "{error}");
}
