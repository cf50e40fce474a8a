//! `collinear warp`.

use collinear_io::picture::{Picture, write_picture};

use crate::support::{Folder, label, pixel};

/// Two pixels to the right and one down, at the same size.
const SHIFT: &str =
    r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [2, 1, 0], "b": [1, 0, 1]}"#;

fn with_shift() -> Folder {
    let folder = Folder::new();
    folder.draw("in.png", [40, 30], label);
    folder.write("map.json", SHIFT);
    folder
}

#[test]
fn a_map_leads_from_the_new_picture_into_the_old_one() {
    let folder = with_shift();
    for (filter, out) in [("nearest", "out.png"), ("lanczos4", "out.tif")] {
        let run = folder.succeed(&["warp", "in.png", out, "-m", "map.json", "-f", filter]);
        assert!(
            run.stderr.contains("40 × 30 pixels, 1102 of 1200 in the picture"),
            "{}",
            run.stderr
        );
        let picture = folder.picture(out);
        assert_eq!((picture.width, picture.height, picture.channels), (40, 30, 4));
        for y in 0..30 {
            for x in 0..40 {
                let expected = if x < 38 && y < 29 {
                    let [r, g, b] = label(x + 2, y + 1);
                    [r, g, b, 255]
                } else {
                    [0; 4]
                };
                assert_eq!(pixel(&picture, x, y), expected, "{filter} ({x}, {y})");
            }
        }
    }
}

#[test]
fn four_points_become_the_corners() {
    let folder = with_shift();
    let quad = ["--quad", "10,5 35,5 35,20 10,20", "--size", "25x15", "-f", "nearest"];
    folder.succeed(&[&["warp", "in.png", "out.png"][..], &quad].concat());
    let out = folder.picture("out.png");
    // No pixel looks beyond, so nothing is clear.
    assert_eq!((out.width, out.height, out.channels), (25, 15, 3));
    for y in 0..15 {
        for x in 0..25 {
            assert_eq!(out.data[(y as usize * 25 + x as usize) * 3..][..3], label(x + 10, y + 5));
        }
    }
}

#[test]
fn borders_are_as_asked_for_or_refused() {
    let folder = with_shift();
    let warp = |border: &[&'static str]| {
        [&["warp", "in.png", "out.png", "--map", "map.json", "-f", "nearest"][..], border].concat()
    };
    folder.succeed(&warp(&["--border", "constant:1,2,3"]));
    let out = folder.picture("out.png");
    assert_eq!(out.channels, 3);
    assert_eq!(out.data[39 * 3..][..3], [1, 2, 3]);
    folder.succeed(&warp(&["--border", "clamp"]));
    assert_eq!(folder.picture("out.png").data[39 * 3..][..3], label(39, 1));
    folder.succeed(&warp(&["--border", "repeat"]));
    assert_eq!(folder.picture("out.png").data[39 * 3..][..3], label(1, 1));
    let before = folder.picture("out.png");
    let run = folder.run(&warp(&["--border", "error"]));
    assert_eq!(run.code, 1);
    let text = "in.png: 98 of 1200 pixels look beyond it, the first in column 38 of row 0";
    assert!(run.stderr.contains(text), "{}", run.stderr);
    assert_eq!(folder.picture("out.png"), before);
    let within = ["--size", "38x29", "--border", "error"];
    folder.succeed(&warp(&within));
    let run = folder.run(&["warp", "in.png", "out.jpg", "--map", "map.json", "-b", "transparent"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
}

#[test]
fn a_checkerboard_made_smaller_is_grey_by_area_and_by_light() {
    let folder = Folder::new();
    folder.draw("board.png", [64, 64], |x, y| if (x + y) % 2 == 0 { [0; 3] } else { [200; 3] });
    let quad = "0,0 64,0 64,64 0,64";
    for filter in ["trilinear", "ewa", "ewa:4"] {
        let more = ["--quad", quad, "--size", "8x8", "--border", "clamp", "-f", filter];
        folder.succeed(&[&["warp", "board.png", "out.png"][..], &more].concat());
        assert_eq!(folder.picture("out.png").data, [100; 8 * 8 * 3], "{filter}");
        // Half of the light of sRGB's 200: 0.5776 / 2, whose sample is 146.3.
        folder.succeed(&[&["warp", "board.png", "out.png", "-l", "srgb"][..], &more].concat());
        assert_eq!(folder.picture("out.png").data, [146; 8 * 8 * 3], "{filter}");
    }
}

#[test]
fn what_cannot_be_seen_has_no_colour() {
    let folder = Folder::new();
    // A clear blue beside an opaque red, and the mean of both.
    let data = vec![255, 0, 0, 255, 0, 0, 255, 0];
    let picture = Picture { width: 2, height: 1, channels: 4, data, orientation: 1 };
    write_picture(&folder.path("in.png"), &picture).unwrap();
    let half =
        r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [0.5, 1, 0], "b": [0, 0, 1]}"#;
    folder.write("half.json", half);
    folder.succeed(&["warp", "in.png", "out.png", "-m", "half.json", "--size", "1x1"]);
    assert_eq!(pixel(&folder.picture("out.png"), 0, 0), [255, 0, 0, 128]);
    let grey =
        Picture { width: 2, height: 1, channels: 2, data: vec![9, 255, 90, 0], orientation: 1 };
    write_picture(&folder.path("in.png"), &grey).unwrap();
    folder.succeed(&["warp", "in.png", "out.png", "-m", "half.json", "--size", "1x1"]);
    let out = folder.picture("out.png");
    assert_eq!((out.channels, &out.data[..]), (2, &[9, 128][..]));
}

#[test]
fn threads_change_no_byte() {
    let folder = Folder::new();
    folder.draw("in.png", [150, 700], |x, y| [(x * y) as u8, (x + 3 * y) as u8, (y / 3) as u8]);
    let map = r#"{"collinear": "map", "version": 1, "kind": "quadratic",
        "a": [-3, 0.9, 0.1, 0.0002, 0.0001, 0], "b": [5, 0.02, 0.9, 0, 0, 0.0001]}"#;
    folder.write("map.json", map);
    for filter in ["bilinear", "ewa"] {
        let mut made = vec![];
        for threads in ["1", "2", "5"] {
            let more = ["-m", "map.json", "-f", filter, "--threads", threads];
            folder.succeed(&[&["warp", "in.png", "out.png"][..], &more].concat());
            made.push(folder.picture("out.png"));
        }
        assert!(made[0] == made[1] && made[0] == made[2], "{filter}");
    }
}

#[test]
fn maps_and_arguments_that_make_no_sense_are_refused() {
    let folder = with_shift();
    let far =
        r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [900, 1, 0], "b": [1, 0, 1]}"#;
    folder.write("far.json", far);
    for (arguments, code, text) in [
        (
            &["warp", "in.png", "out.png", "-m", "far.json"][..],
            1,
            "leads none of the 40 × 30 pixels",
        ),
        (&["warp", "in.png", "out.png"], 2, "--map"),
        (&["warp", "in.png", "out.png", "-m", "map.json", "-f", "sinc"], 2, "lanczos4"),
        (&["warp", "in.png", "out.png", "-m", "map.json", "-f", "keys:x"], 2, "keys:-0.75"),
        (&["warp", "in.png", "out.png", "-m", "map.json", "-f", "ewa:0"], 2, "from 1 to 64"),
        (&["warp", "in.png", "in.png", "-m", "map.json"], 2, "in.png"),
        (&["warp", "in.png", "out.bmp", "-m", "map.json"], 2, ".bmp"),
        (&["warp", "none.png", "out.png", "-m", "map.json"], 1, "none.png"),
        (&["warp", "in.png", "out.png", "-q", "0,0 1,1 2,2 3,3", "-s", "4x4"], 1, "--quad"),
        (&["warp", "in.png", "out.png", "-m", "map.json", "-t", "0"], 2, "0"),
        (&["warp", "in.png", "out.png", "-m", "map.json", "-s", "0x4"], 2, "0 × 4"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, code, "{arguments:?}: {}", run.stderr);
        assert!(run.stderr.contains(text), "{arguments:?}: {}", run.stderr);
        assert!(!folder.path("out.png").exists(), "{arguments:?}");
    }
}

#[test]
fn grey_becomes_colour_where_the_border_or_the_format_asks_for_it() {
    let folder = with_shift();
    let grey = Picture { width: 2, height: 1, channels: 1, data: vec![7, 9], orientation: 1 };
    write_picture(&folder.path("grey.png"), &grey).unwrap();
    let half = Picture { channels: 2, data: vec![7, 100, 9, 255], ..grey };
    write_picture(&folder.path("half.png"), &half).unwrap();
    let warp = |input: &'static str, out: &'static str, more: &[&'static str]| {
        [&["warp", input, out, "-m", "map.json", "-f", "nearest"][..], more].concat()
    };
    let one =
        r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [1, 1, 0], "b": [0, 0, 1]}"#;
    folder.write("map.json", one);
    for (input, out, border, expected) in [
        ("grey.png", "a.png", "constant:5,5,5", &[9, 5][..]),
        ("grey.png", "a.png", "constant:1,2,3", &[9, 9, 9, 1, 2, 3]),
        ("half.png", "a.png", "constant:5,5,5", &[9, 255, 5, 255]),
        ("half.png", "a.png", "constant:1,2,3", &[9, 9, 9, 255, 1, 2, 3, 255]),
        ("half.png", "a.tif", "repeat", &[9, 9, 9, 255, 7, 7, 7, 100]),
        ("grey.png", "a.tif", "transparent", &[9, 9, 9, 255, 0, 0, 0, 0]),
        ("grey.png", "a.png", "transparent", &[9, 255, 0, 0]),
    ] {
        folder.succeed(&warp(input, out, &["-b", border]));
        assert_eq!(folder.picture(out).data, expected, "{input} {out} {border}");
    }
    let run = folder.run(&warp("half.png", "a.jpg", &[]));
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("half.png: has opacity, which no JPEG has"), "{}", run.stderr);
    // One picture further on: nothing of it is seen but by repetition.
    let beyond =
        r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [2, 1, 0], "b": [0, 0, 1]}"#;
    folder.write("map.json", beyond);
    folder.succeed(&warp("grey.png", "a.png", &["-b", "repeat", "-s", "1x1"]));
    assert_eq!(folder.picture("a.png").data, [7]);
    // Less than positions are rounded to beyond the edge.
    let edge = r#"{"collinear": "map", "version": 1, "kind": "affine", "a": [-0.50000000000001, 1, 0], "b": [0, 0, 1]}"#;
    folder.write("map.json", edge);
    folder.succeed(&warp("grey.png", "a.png", &["-b", "error", "-s", "1x1"]));
    assert_eq!(folder.picture("a.png").data, [7]);
}
