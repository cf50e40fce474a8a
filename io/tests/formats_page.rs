//! Every example of docs/formats.md is a file that is read, and reads the same after it was written.

use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::map::MapFile;
use collinear_io::plane::PlaneFile;
use collinear_io::points::parse_points;
use collinear_io::scene::SceneFile;

fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    page.split(&format!("```{language}\n")).skip(1).filter_map(|b| b.split("```").next()).collect()
}

fn survives<D: Document + PartialEq + std::fmt::Debug>(text: &str) {
    let document = D::parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(D::parse(&document.to_json().unwrap()).unwrap(), document);
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
            "plane" => survives::<PlaneFile>(text),
            "map" => survives::<MapFile>(text),
            "scene" => survives::<SceneFile>(text),
            other => panic!("an example of an unknown kind {other}"),
        }
    }
    kinds.dedup();
    assert_eq!(kinds, ["camera", "plane", "map", "scene"]);
    for text in blocks(&page, "csv") {
        assert_eq!(parse_points(text).unwrap().len(), 2);
    }
}
