//! `collinear rectify`.

use crate::support::{Folder, document, ground, label, looking_down, map_view, pixel, vertical};
use collinear::nalgebra::Point2;
use collinear_cli::rectify::Rectification;
use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::picture::{Picture, write_picture};
use collinear_io::plane::{PlaneFile, Rectangle};

fn with_photograph(size: [u32; 2], lens: &str) -> Folder {
    let folder = Folder::new();
    folder.draw("photo.png", size, label);
    folder.write("camera.json", document("camera", &vertical(size[0], size[1], lens)));
    folder
}

const CAMERA: [&str; 4] = ["--camera", "camera.json", "--plane", "plane.json"];

fn rectify<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["rectify", "photo.png"], more].concat()
}

#[test]
fn a_rectangle_of_the_ground_is_cut_out_of_a_vertical_photograph() {
    let folder = with_photograph([40, 30], "");
    // 0.1 a pixel: x from −1 to 1.5 is columns 10 to 35; y from −0.5 to 1, which is up, rows 5 to 20.
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -1, "bottom": -0.5, "right": 1.5, "top": 1 }"#),
    );
    for scale in [["--size", "25x15"], ["--gsd", "0.1"]] {
        let more = ["--filter", "nearest", "-o", "out.png"];
        let run = folder.succeed(&[&rectify(&CAMERA)[..], &scale, &more].concat());
        assert!(run.stderr.contains("25 × 15 pixels from -1, -0.5 to 1.5, 1"), "{}", run.stderr);
        let out = folder.picture("out.png");
        assert_eq!((out.width, out.height, out.channels), (25, 15, 4));
        for y in 0..15 {
            for x in 0..25 {
                let [r, g, b] = label(x + 10, y + 5);
                assert_eq!(pixel(&out, x, y), [r, g, b, 255], "({x}, {y})");
            }
        }
    }
}

#[test]
fn up_and_the_normal_turn_the_picture() {
    let folder = with_photograph([40, 30], "");
    // East up: right is south. The top left pixel shows the photograph's top right corner's... north-east: (1, 1).
    folder.write(
        "plane.json",
        ground(
            r#", "up": [1, 0, 0], "rectangle": { "left": -1, "bottom": -1, "right": 1, "top": 1 }"#,
        ),
    );
    let more = ["--size", "20x20", "--filter", "nearest", "-o", "out.png"];
    folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    let out = folder.picture("out.png");
    let [r, g, b] = label(29, 5);
    assert_eq!(pixel(&out, 0, 0), [r, g, b, 255]);
    let [r, g, b] = label(10, 24);
    assert_eq!(pixel(&out, 19, 19), [r, g, b, 255]);
    // From below, the picture is mirrored, and that is told: the camera is above.
    folder.write(
        "plane.json",
        document(
            "plane",
            r#""point": [0, 0, 0], "normal": [0, 0, -1],
            "rectangle": { "left": -1, "bottom": -1, "right": 1, "top": 1 }"#,
        ),
    );
    let run = folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    assert!(run.stderr.contains("left and right are exchanged"), "{}", run.stderr);
    // Up is +Y, right is −X: the top left pixel shows (0.95, 0.95).
    let [r, g, b] = label(29, 5);
    assert_eq!(pixel(&folder.picture("out.png"), 0, 0), [r, g, b, 255]);
}

#[test]
fn without_a_rectangle_all_that_the_photograph_shows_is_drawn() {
    let folder = with_photograph([40, 90], "");
    folder.write("plane.json", ground(""));
    let more =
        ["--gsd", "0.1", "--filter", "nearest", "--border", "constant:0,0,0", "-o", "out.png"];
    let run = folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    assert!(run.stderr.contains("40 × 90 pixels from -2, -4.5 to 2, 4.5"), "{}", run.stderr);
    assert_eq!(folder.picture("out.png"), folder.picture("photo.png"));
}

#[test]
fn a_horizon_in_view_asks_for_a_rectangle() {
    let folder = with_photograph([40, 30], "");
    // A level camera, one above the ground, that looks north.
    let level = r#""width": 40, "height": 30,
        "interior": { "model": "pinhole", "principal_distance": [30, 30], "principal_point": [20, 15] },
        "exterior": { "projection_center": [0, 0, 1], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }"#;
    folder.write("camera.json", document("camera", level)).write("plane.json", ground(""));
    folder.write("out.png", "old");
    let more = ["--size", "20x20", "-o", "out.png"];
    let run = folder.run(&[&rectify(&CAMERA)[..], &more].concat());
    assert_eq!(run.code, 1);
    assert!(run.stderr.starts_with("collinear: error: plane.json: the plane's horizon is in view"));
    assert!(run.stderr.contains("the plane file needs a `rectangle`"), "{}", run.stderr);
    assert_eq!(folder.text("out.png"), "old");
}

#[test]
fn the_lens_is_taken_out() {
    let folder = Folder::new();
    folder.draw("photo.png", [100, 80], |x, y| [(2 * x) as u8, (3 * y) as u8, 0]);
    let lens = r#", "k": [0.4, -0.1, 0], "p": [0.02, -0.01]"#;
    folder.write("camera.json", document("camera", &vertical(100, 80, lens)));
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -3, "bottom": -2, "right": 3, "top": 2 }"#),
    );
    let more = ["--size", "60x40", "-o", "out.png"];
    folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    let out = folder.picture("out.png");
    for (i, j) in [(0, 0), (59, 0), (30, 20), (0, 39), (59, 39), (10, 33)] {
        let (x, y) = ((f64::from(i) + 0.5 - 30.0) / 100.0, (f64::from(j) + 0.5 - 20.0) / 100.0);
        let r2 = x * x + y * y;
        let radial = 1.0 + 0.4 * r2 - 0.1 * r2 * r2;
        let u = x * radial + 2.0 * 0.02 * x * y - 0.01 * (r2 + 2.0 * x * x);
        let v = y * radial + 0.02 * (r2 + 2.0 * y * y) - 2.0 * 0.01 * x * y;
        let expected = [2.0 * (50.0 + 100.0 * u - 0.5), 3.0 * (40.0 + 100.0 * v - 0.5)];
        let found = pixel(&out, i, j);
        for (f, e) in found.iter().zip(expected) {
            assert!((f64::from(*f) - e).abs() <= 0.51, "({i}, {j}): {found:?}, {expected:?}");
        }
    }
}

#[test]
fn a_quadrilateral_becomes_the_picture() {
    let folder = with_photograph([40, 30], "");
    // Columns 10 to 35, rows 5 to 20 of the photograph.
    let more = ["--quad", "10,5 35,5 35,20 10,20", "--size", "25x15", "--filter", "nearest"];
    let outputs = ["-o", "out.png", "--map-out", "map.json"];
    folder.succeed(&[&rectify(&more)[..], &outputs].concat());
    let out = folder.picture("out.png");
    for y in 0..15 {
        for x in 0..25 {
            let [r, g, b] = label(x + 10, y + 5);
            assert_eq!(pixel(&out, x, y), [r, g, b, 255], "({x}, {y})");
        }
    }
    let map: serde_json::Value = serde_json::from_str(&folder.text("map.json")).unwrap();
    assert_eq!((&map["collinear"], &map["kind"]), (&"map".into(), &"homography".into()));
    let m = |i: usize, j: usize| {
        map["matrix"][i][j].as_f64().unwrap() / map["matrix"][2][2].as_f64().unwrap()
    };
    // A shift by (10, 5).
    let expected = [[1.0, 0.0, 10.0], [0.0, 1.0, 5.0], [0.0, 0.0, 1.0]];
    for (i, row) in expected.iter().enumerate() {
        for (j, e) in row.iter().enumerate() {
            assert!((m(i, j) - e).abs() < 1e-13, "{map}");
        }
    }
}

#[test]
fn a_trapezium_is_rectified_in_perspective() {
    let folder = Folder::new();
    folder.draw("photo.png", [200, 200], |x, y| [x as u8, y as u8, 0]);
    // The diagonals of (60,20) (140,20) (180,180) (20,180) cross where x = 100 and, from (60,20) towards (180,180), at
    // 1/3 of the way: y = 20 + 160/3 = 73.33. That is the middle of the rectangle.
    let more = ["--quad", "60,20 140,20 180,180 20,180", "--size", "101x101", "-o", "out.png"];
    folder.succeed(&rectify(&more));
    let out = folder.picture("out.png");
    assert_eq!(pixel(&out, 50, 50), [100, 73, 0, 255]);
    // Counter-clockwise corners mirror.
    let more = ["--quad", "140,20 60,20 20,180 180,180", "--size", "101x101", "-o", "out.png"];
    let run = folder.succeed(&rectify(&more));
    assert!(run.stderr.contains("the corners go counter-clockwise"), "{}", run.stderr);
}

#[test]
fn corners_go_through_the_lens_of_a_camera_given_with_them() {
    let folder = Folder::new();
    folder.draw("photo.png", [100, 80], |x, _| [(2 * x) as u8, 0, 0]);
    folder.write("camera.json", document("camera", &vertical(100, 80, r#", "k": [0.5, 0, 0]"#)));
    // The ideal point (0.3, 0.2) has its image at 0.3 (1 + 0.5 · 0.13) = 0.3195, 0.2 · 1.065 = 0.213.
    let quad = "18.05,18.7 81.95,18.7 81.95,61.3 18.05,61.3";
    let more = ["--camera", "camera.json", "--quad", quad, "--size", "60x40", "-o", "out.png"];
    folder.succeed(&rectify(&more));
    let out = folder.picture("out.png");
    // So pixel (45, 20) is the ideal point (0.155, 0.005): 0.155 (1 + 0.5 · 0.02405) = 0.15686, red 2 · (65.686 − ½).
    assert_eq!(pixel(&out, 45, 20), [130, 0, 0, 255]);
}

#[test]
fn a_picture_of_nothing_is_an_error_with_numbers() {
    let folder = with_photograph([40, 30], "");
    folder.write("out.png", "old");
    let rectangle = |left: i32, normal: &str| {
        let right = left + 2;
        let fields = format!(
            r#"{normal}, "rectangle": {{ "left": {left}, "bottom": -1, "right": {right}, "top": 1 }}"#
        );
        document("plane", &fields)
    };
    let ground = r#""point": [0, 0, 0], "normal": [0, 0, 1]"#;
    let cases = [
        // Behind the camera, which is at height 10 and looks down.
        (
            rectangle(-1, r#""point": [0, 0, 15], "normal": [0, 0, 1]"#),
            "photo.png: none of the 20 × 20 pixels lies in the photograph: the point lies behind the camera",
        ),
        // Ten pixels a unit about (20, 15).
        (
            rectangle(50, ground),
            "photo.png: none of the 20 × 20 pixels lies in the photograph: they lie at x from 520 to 540, \
             y from 5 to 25, and the photograph has 40 × 30 pixels",
        ),
    ];
    for (plane, reason) in cases {
        folder.write("plane.json", plane);
        for border in ["transparent", "constant:1,2,3", "clamp", "repeat", "mirror"] {
            let more =
                ["--size", "20x20", "--border", border, "-o", "out.png", "--map-out", "m.json"];
            let run = folder.run(&[&rectify(&CAMERA)[..], &more].concat());
            assert_eq!(run.code, 1, "{border}: {}", run.stderr);
            assert!(
                run.stderr.starts_with(&format!("collinear: error: {reason}")),
                "{}",
                run.stderr
            );
            assert_eq!(folder.text("out.png"), "old");
            assert!(!folder.files().contains(&"m.json".to_owned()));
        }
    }
    // What lies partly in the photograph says how much of it does: here the left two of four columns of five pixels.
    folder.write("plane.json", rectangle(1, ground));
    let run =
        folder.succeed(&[&rectify(&CAMERA)[..], &["--size", "20x20", "-o", "out.png"]].concat());
    assert!(run.stderr.contains(", 200 of 400 in the photograph"), "{}", run.stderr);
    // A quadrilateral beyond the photograph.
    let quad = ["--quad", "100,0 110,0 110,10 100,10", "--size", "9x9", "-o", "out.png"];
    let run = folder.run(&rectify(&quad));
    assert_eq!(run.code, 1);
    assert!(run.stderr.contains("they lie at x from 100 to 110, y from 0 to 10"), "{}", run.stderr);
}

#[test]
fn any_number_of_channels_is_looked_up_as_it_is() {
    let folder = Folder::new();
    for channels in 1..=4u8 {
        let data = (0..40 * 30 * u32::from(channels)).map(|i| (i * 11 % 251) as u8).collect();
        let picture = Picture { width: 40, height: 30, channels, data, orientation: 1 };
        write_picture(&folder.path("photo.png"), &picture).unwrap();
        // Longer than one band of rows, shifted by half the photograph: part of it lies beyond.
        let quad = ["--quad", "20,15 60,15 60,45 20,45", "--filter", "nearest"];
        for (border, colors, opacity) in [
            ("transparent", if channels > 2 { 3 } else { 1 }, true),
            ("constant:7,7,7", if channels > 2 { 3 } else { 1 }, false),
            ("constant:7,8,9", 3, false),
        ] {
            let more = ["--size", "160x120", "--border", border, "-o", "out.png"];
            folder.succeed(&[&rectify(&quad)[..], &more].concat());
            let out = folder.picture("out.png");
            assert_eq!(out.channels, colors + u8::from(opacity), "{channels} {border}");
            for (x, y) in [(0, 0), (79, 59), (5, 58), (80, 59), (79, 60), (159, 119), (3, 100)] {
                let (u, v) = (20 + x / 4, 15 + y / 4);
                let mut expected: Vec<u8> = if u < 40 && v < 30 {
                    let p = pixel(&picture, u, v);
                    (0..colors).map(|k| p[if channels > 2 { k.into() } else { 0 }]).collect()
                } else if opacity {
                    vec![0; colors.into()]
                } else {
                    let b: Vec<u8> = border[9..].split(',').map(|c| c.parse().unwrap()).collect();
                    b[..colors.into()].to_vec()
                };
                if opacity {
                    expected.push(if u < 40 && v < 30 { 255 } else { 0 });
                }
                assert_eq!(pixel(&out, x, y), expected, "{channels} {border} ({x}, {y})");
            }
        }
    }
}

#[test]
fn the_border_is_as_asked_for() {
    let folder = with_photograph([40, 30], "");
    // One unit, ten pixels, beyond the photograph on the left and none elsewhere.
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -3, "bottom": -1.5, "right": 2, "top": 1.5 }"#),
    );
    let [r, g, b] = label(0, 9);
    let cases: [(&str, &str, &[u8]); 6] = [
        ("transparent", "out.png", &[0, 0, 0, 0]),
        ("constant:10,20,30", "out.png", &[10, 20, 30]),
        ("constant 10,20,30", "out.png", &[10, 20, 30]),
        ("clamp", "out.png", &[r, g, b]),
        ("mirror", "out.png", &label(5, 9)),
        ("repeat", "out.png", &label(34, 9)),
    ];
    for (border, name, expected) in cases {
        let more = ["--size", "50x30", "--filter", "nearest", "--border", border, "-o", name];
        folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
        assert_eq!(pixel(&folder.picture(name), 4, 9), expected, "{border}");
    }
    // A JPEG has no opacity.
    let more = ["--size", "50x30", "-o", "out.jpg"];
    folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    let dark = folder.picture("out.jpg");
    assert!(pixel(&dark, 2, 9).iter().all(|c| *c < 12), "{:?}", pixel(&dark, 2, 9));
    let more = ["--size", "50x30", "--border", "transparent", "-o", "out.jpg"];
    let run = folder.run(&[&rectify(&CAMERA)[..], &more].concat());
    assert_eq!(run.code, 2, "{}", run.stderr);
}

#[test]
fn grey_stays_grey_unless_the_border_has_a_colour() {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &vertical(2, 1, "")));
    // Pixels of 0.1: one beyond the photograph on each side.
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -0.2, "bottom": -0.05, "right": 0.2, "top": 0.05 }"#),
    );
    let scale = ["--size", "4x1", "--filter", "nearest", "-o", "out.png"];
    for (channels, data) in [(1, vec![10, 20]), (2, vec![10, 7, 20, 7])] {
        let grey = Picture { width: 2, height: 1, channels, data, orientation: 1 };
        write_picture(&folder.path("photo.png"), &grey).unwrap();
        let cases: [(&[&str], u8, &[u8]); 3] = [
            (&[], 2, &[0, 0, 10, 255, 20, 255, 0, 0]),
            (&["--border", "constant:5,5,5"], 1, &[5, 10, 20, 5]),
            (&["--border", "constant:5,6,5"], 3, &[5, 6, 5, 10, 10, 10, 20, 20, 20, 5, 6, 5]),
        ];
        for (border, channels, expected) in cases {
            folder.succeed(&[&rectify(&CAMERA)[..], &scale, border].concat());
            let out = folder.picture("out.png");
            assert_eq!((out.channels, out.data.as_slice()), (channels, expected), "{border:?}");
        }
    }
}

#[test]
fn a_map_is_a_photograph_too() {
    let folder = with_photograph([40, 30], "");
    folder.write("camera.json", document("camera", &map_view(40, 30)));
    // Ten units up, which a parallel projection does not see: 0.1 a pixel all the same.
    let plane = |normal: i32| {
        let rectangle = r#""rectangle": { "left": -1, "bottom": -1, "right": 1, "top": 1 }"#;
        let normal = format!(r#""point": [0, 0, 10], "normal": [0, 0, {normal}], {rectangle}"#);
        document("plane", &normal)
    };
    let more = ["--size", "20x20", "--filter", "nearest", "-o", "out.png"];
    folder.write("plane.json", plane(1));
    let run = folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    assert!(!run.stderr.contains("exchanged"), "{}", run.stderr);
    let [r, g, b] = label(10, 5);
    assert_eq!(pixel(&folder.picture("out.png"), 0, 0), [r, g, b, 255]);
    folder.write("plane.json", plane(-1));
    let run = folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    assert!(run.stderr.contains("left and right are exchanged"), "{}", run.stderr);
}

const FISHEYE: &str =
    r#""model": "fisheye", "principal_distance": [100, 100], "principal_point": [150, 120]"#;

/// Squares of 4 units, black and white.
fn checkered(x: f64, y: f64) -> u8 {
    if ((x / 4.0).floor() + (y / 4.0).floor()).rem_euclid(2.0) < 0.5 { 255 } else { 0 }
}

/// The ground of [`checkered`] as an equidistant fisheye 10 above it sees it, with f = 100; sky is grey.
fn checkerboard(px: u32, py: u32) -> [u8; 3] {
    let (x, y) = (f64::from(px) + 0.5 - 150.0, f64::from(py) + 0.5 - 120.0);
    let r = x.hypot(y);
    let angle = r / 100.0;
    if angle >= std::f64::consts::FRAC_PI_2 {
        return [128; 3];
    }
    let far = 10.0 * angle.tan() / r;
    [checkered(x * far, -y * far); 3]
}

#[test]
fn a_checkerboard_seen_by_a_fisheye_is_rectified_to_squares() {
    let folder = Folder::new();
    folder.draw("photo.png", [300, 240], checkerboard);
    folder.write("camera.json", document("camera", &looking_down([300, 240], FISHEYE)));
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -14, "bottom": -10, "right": 14, "top": 10 }"#),
    );
    let more = ["--size", "280x200", "--filter", "nearest", "-o", "out.png"];
    folder.succeed(&[&rectify(&CAMERA)[..], &more].concat());
    let out = folder.picture("out.png");
    let mut compared = 0;
    for y in 0..200 {
        for x in 0..280 {
            // A pixel of the photograph covers at most 10 (1 + tan²) / 100 = 0.4 units there, half of that about its centre.
            let (a, b) = (f64::from(x) / 10.0 - 13.95, 9.95 - f64::from(y) / 10.0);
            let from_edge = |c: f64| (c - 4.0 * (c / 4.0).round()).abs();
            if from_edge(a) > 0.3 && from_edge(b) > 0.3 {
                let c = checkered(a, b);
                assert_eq!(pixel(&out, x, y), [c, c, c, 255], "({x}, {y})");
                compared += 1;
            }
        }
    }
    assert!(compared > 35_000, "{compared}");
}

/// OpenCV 5.0.0, `fisheye.distortPoints` of (x/z, y/z) with K = (100.5, 99.25, 149.75, 119.5), whose pixel centres are
/// integers, and D = (0.0312, −0.0147, 0.0063, −0.0011).
const DISTORTED: [([f64; 2], [f64; 2]); 5] = [
    ([-3.0, 2.0], [37.522238925432276, 193.3879289330073]),
    ([1.25, -0.75], [235.0329806021271, 68.96665179247097]),
    ([0.01, 0.02], [150.75484821670722, 121.48470020911822]),
    ([2.5, 2.5], [244.73430692750964, 213.3029100751774]),
    ([-0.4, -1.9], [126.51100880798654, 10.487742188210518]),
];

#[test]
fn a_ground_is_looked_up_through_a_fisheye_where_opencv_says() {
    let interior = r#""model": "fisheye", "principal_distance": [100.5, 99.25],
        "principal_point": [150.25, 120], "k": [0.0312, -0.0147, 0.0063, -0.0011]"#;
    let camera =
        CameraFile::parse(&document("camera", &looking_down([300, 240], interior))).unwrap();
    let plane = PlaneFile::parse(&ground("")).unwrap();
    // 20 pixels a unit from (−40, 40): (x/z, y/z) is a twentieth of the way.
    let rectangle = Rectangle { left: -40.0, bottom: -40.0, right: 40.0, top: 40.0 };
    let made = Rectification::of_plane(&plane, &rectangle, &camera.into(), 1600, 1600).unwrap();
    assert!(made.through_lens() && made.homography().is_none() && !made.is_mirrored());
    for ([x, y], [u, v]) in DISTORTED {
        let screen = Point2::new(20.0 * (10.0 * x + 40.0), 20.0 * (10.0 * y + 40.0));
        let found = made.map().at(&screen).unwrap();
        assert!((found - Point2::new(u + 0.5, v + 0.5)).norm() < 1e-10, "{found} for ({x}, {y})");
        // The slopes are those of its differences.
        let slopes = made.map().jacobian(&screen).unwrap();
        for (k, step) in [Point2::new(1e-3, 0.0), Point2::new(0.0, 1e-3)].iter().enumerate() {
            let (a, b) = (screen + step.coords, screen - step.coords);
            let difference = (made.map().at(&a).unwrap() - made.map().at(&b).unwrap()) / 2e-3;
            assert!((slopes.column(k) - difference).norm() < 1e-7, "({x}, {y}): {slopes}");
        }
    }
}

#[test]
fn a_ground_far_from_the_origin_is_looked_up_to_the_last_digits() {
    let file = |[x, y]: [f64; 2]| {
        let camera = format!(
            r#""width": 300, "height": 240, "interior": {{ {FISHEYE} }},
            "exterior": {{ "projection_center": [{x:?}, {y:?}, 10], "omega_phi_kappa": [0.5, -0.25, 2] }}"#
        );
        let plane =
            document("plane", &format!(r#""point": [{x:?}, {y:?}, 0], "normal": [1, 2, 8]"#));
        let camera = CameraFile::parse(&document("camera", &camera)).unwrap();
        let rectangle = Rectangle { left: -5.0, bottom: -5.0, right: 5.0, top: 5.0 };
        let plane = PlaneFile::parse(&plane).unwrap();
        Rectification::of_plane(&plane, &rectangle, &camera.clone().into(), 100, 100).unwrap()
    };
    let (near, far) = (file([0.0, 0.0]), file([691_234.0, 5_334_321.0]));
    for p in [[0.0, 0.0], [99.5, 3.25], [50.0, 50.0], [20.0, 100.0]].map(Point2::from) {
        let (near, far) = (near.map().at(&p).unwrap(), far.map().at(&p).unwrap());
        assert!((near - far).norm() < 1e-7, "{near} {far}");
    }
}

#[test]
fn a_quadrilateral_of_a_fisheye_becomes_the_picture() {
    let folder = Folder::new();
    folder.draw("photo.png", [300, 240], checkerboard);
    folder.write("camera.json", document("camera", &looking_down([300, 240], FISHEYE)));
    // The corners of the ground's square from −8 to 8: 100 atan(0.8 √2) / √2 = 59.8477… pixels from the middle each way.
    let d = 100.0 * (0.8 * 2.0_f64.sqrt()).atan() / 2.0_f64.sqrt();
    let (l, r, t, b) = (150.0 - d, 150.0 + d, 120.0 - d, 120.0 + d);
    let quad = format!("{l},{t} {r},{t} {r},{b} {l},{b}");
    let more = ["--quad", &quad, "--camera", "camera.json", "--size", "160x160"];
    let more = [&more[..], &["--filter", "nearest", "-o", "out.png"]].concat();
    folder.succeed(&rectify(&more));
    let out = folder.picture("out.png");
    for (i, j) in [(0, 0), (1, 0), (3, 2), (2, 1), (3, 3), (0, 2)] {
        // The middles of the 4 × 4 squares.
        let c = checkered(4.0 * f64::from(i) - 6.0, 6.0 - 4.0 * f64::from(j));
        assert_eq!(pixel(&out, 40 * i + 20, 40 * j + 20), [c, c, c, 255], "({i}, {j})");
    }
    // No homography leads into a fisheye.
    let run = folder.run(&rectify(&[&more[..], &["--map-out", "map.json"]].concat()));
    let told = "collinear: error: camera.json: interior.model: no homography is part of `fisheye`";
    assert!(run.code == 1 && run.stderr.starts_with(told), "{}", run.stderr);
    // A corner behind the camera is no corner of a plane before it.
    folder.write(
        "camera.json",
        document("camera", &looking_down([300, 240], r#""model": "equirectangular""#)),
    );
    let more = ["--quad", "10,20 290,20 290,200 10,200", "--camera", "camera.json"];
    let run = folder.run(&rectify(&[&more[..], &["--size", "16x16", "-o", "out.png"]].concat()));
    let told = "collinear: error: --quad: corner (10, 20): the point lies behind the camera";
    assert!(run.code == 1 && run.stderr.starts_with(told), "{}", run.stderr);
}

#[test]
fn a_fisheye_in_the_plane_sees_it_as_a_line() {
    let folder = Folder::new();
    folder.draw("photo.png", [300, 240], checkerboard);
    folder.write("camera.json", document("camera", &looking_down([300, 240], FISHEYE)));
    folder.write("plane.json", document("plane", r#""point": [0, 0, 10], "normal": [1, 0, 0]"#));
    let more = ["--size", "28x20", "-o", "out.png"];
    let run = folder.run(&[&rectify(&CAMERA)[..], &more].concat());
    let told = "plane.json: the camera lies in the plane and sees it as a line";
    assert!(run.code == 1 && run.stderr.contains(told), "{}", run.stderr);
    // Its edge sees the horizon.
    folder.write("plane.json", ground(""));
    let run = folder.run(&[&rectify(&CAMERA)[..], &more].concat());
    let told = "plane.json: the plane's horizon is in view of the photograph";
    assert!(run.code == 1 && run.stderr.contains(told), "{}", run.stderr);
}
