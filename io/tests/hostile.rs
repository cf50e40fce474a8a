//! Readers and bytes that no writer wrote: an error, never a panic.

use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::gtx::parse_gtx;
use collinear_io::map::MapFile;
use collinear_io::opensfm::{parse_reconstruction, parse_tracks};
use collinear_io::picture::{Limits, decode_picture};
use collinear_io::plane::PlaneFile;
use collinear_io::points::parse_points;
use collinear_io::scene::SceneFile;
use proptest::prelude::*;

const SMALL: Limits = Limits { pixels: 1 << 16, file_bytes: 1 << 20 };

/// Every reader of text, and what a caller would ask of its result.
fn read_text(text: &str) {
    if let Ok(camera) = CameraFile::parse(text) {
        assert_eq!(CameraFile::parse(&camera.to_json().unwrap()).unwrap(), camera);
    }
    if let Ok(plane) = PlaneFile::parse(text) {
        plane.world_from_plane(1.0, 2.0).unwrap();
        assert_eq!(PlaneFile::parse(&plane.to_json().unwrap()).unwrap(), plane);
    }
    if let Ok(map) = MapFile::parse(text) {
        assert_eq!(MapFile::parse(&map.to_json().unwrap()).unwrap(), map);
    }
    if let Ok(scene) = SceneFile::parse(text) {
        assert_eq!(SceneFile::parse(&scene.to_json().unwrap()).unwrap(), scene);
        let near = scene.near_distance(&[0.0; 3]);
        assert!(near > 0.0 && near.is_finite());
    }
    if let Ok(reconstruction) = parse_reconstruction(text, 0) {
        for shot in reconstruction.shots.keys() {
            if let Ok(camera) = reconstruction.camera(shot) {
                camera.check().unwrap();
            }
        }
    }
    for seen in parse_tracks(text).unwrap_or_default() {
        assert!(seen.pixel(1, 1).iter().all(|c| !c.is_nan()));
    }
    for row in parse_points(text).unwrap_or_default() {
        assert!(row.world.iter().all(|c| c.is_finite()));
    }
}

fn samples() -> Vec<String> {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md"))
        .unwrap();
    let mut samples: Vec<String> = page
        .split("```")
        .skip(1)
        .step_by(2)
        .filter_map(|b| b.split_once('\n'))
        .map(|(_, text)| text.to_owned())
        .collect();
    samples.push(r#"[{"cameras": {"c": {"width": 4, "height": 3, "focal": 0.9}}, "shots": {"a": {"camera": "c", "rotation": [0, 1, 2], "translation": [0, 0, 5]}}, "points": {"1": {"coordinates": [1, 2, 3], "color": [1, 2, 3]}}}]"#.into());
    samples.push(
        "OPENSFM_TRACKS_VERSION_v2\na.jpg\t7\t12\t0.25\t-0.125\t0.001\t1\t2\t3\t-1\t-1\n".into(),
    );
    samples.push("id;X;Y;Z;x;y;note\n\"a;b\";1;2;3;4;5;6\n".into());
    samples
}

/// What a value may be replaced by.
const VALUES: [&str; 13] = [
    "0", "-1", "1e200", "-1e-200", "1e308", "null", "true", "[]", "{}", "\"\"", "[[]]", "NaN", ",",
];

proptest! {
    #[test]
    fn random_text_is_refused_by_every_reader(text in "\\PC{0,60}") {
        read_text(&text);
    }

    #[test]
    fn damaged_files_are_refused_or_read(
        sample in any::<prop::sample::Index>(), end in any::<prop::sample::Index>(), cut in any::<bool>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..VALUES.len()), 0..4),
    ) {
        let samples = samples();
        let mut text = samples[sample.index(samples.len())].clone();
        for (place, value) in edits {
            // Numbers are what most of these files are made of: one of them becomes something else.
            let starts: Vec<usize> = text
                .char_indices()
                .zip(text.chars().skip(1))
                .filter(|((_, before), c)| !before.is_alphanumeric() && *before != '.' && c.is_ascii_digit())
                .map(|((i, before), _)| i + before.len_utf8())
                .collect();
            if starts.is_empty() { break; }
            let start = starts[place.index(starts.len())];
            let length = text[start..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len() - start);
            text.replace_range(start..start + length, VALUES[value]);
        }
        if cut {
            let mut end = end.index(text.len() + 1);
            while !text.is_char_boundary(end) { end -= 1; }
            text.truncate(end);
        }
        read_text(&text);
    }

    #[test]
    fn random_bytes_are_refused_by_every_reader(
        mut bytes in prop::collection::vec(any::<u8>(), 0..200), start in 0..4usize,
    ) {
        let magic: [&[u8]; 4] = [b"", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", b"\xff\xd8\xff", b"\xff\xd8\xff\xc0\0\x11\x08\0\x10\0\x10\x03\x01\x22\0\x02\x11\x01\x03\x11\x01\xff\xda\0\x0c\x03\x01\0\x02\x11\x03\x11\0\x3f\0"];
        bytes.splice(0..0, magic[start].iter().copied());
        if start > 1 {
            bytes.extend([0xff, 0xd9]);
        }
        prop_assert!(decode_picture(&bytes, SMALL).is_err() || start > 1);
        prop_assert!(parse_gtx(&bytes).is_err());
    }
}
