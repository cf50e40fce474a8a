//! `collinear render`.

use crate::support::{Folder, document, label, looking_down, map_view, pixel, vertical};

fn scene(photographs: &str, polygons: &str, view: &str, rest: &str) -> String {
    document(
        "scene",
        &format!(r#"{photographs} "polygons": [{polygons}], "view": {{ {view} }} {rest}"#),
    )
}

/// A horizontal square of half side `r` at height z, counter-clockwise from above.
fn square(r: f64, z: f64, fill: &str) -> String {
    format!(
        r#"{{ "vertices": [[-{r}, -{r}, {z}], [{r}, -{r}, {z}], [{r}, {r}, {z}], [-{r}, {r}, {z}]], {fill} }}"#
    )
}

const RED: &str = r#""color": [200, 0, 0]"#;
const BLUE: &str = r#""color": [0, 0, 200]"#;

#[test]
fn the_nearest_polygon_covers_its_pixels() {
    let folder = Folder::new();
    // 10 pixels a unit about (20, 15): the red square covers 10..30 × 5..25, the blue one above it 15..25 × 10..20.
    let polygons = [square(0.5, 1.0, BLUE), square(1.0, 0.0, RED)].join(",");
    let rest = r#", "background": [9, 8, 7]"#;
    folder.write("scene.json", scene("", &polygons, &map_view(40, 30), rest));
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    assert!(run.stderr.contains("2 polygons drawn, 0 culled, 0 out of view, 0 left out"));
    let view = folder.picture("view.png");
    assert_eq!((view.width, view.height, view.channels), (40, 30, 3));
    for y in 0..30 {
        for x in 0..40 {
            let expected: &[u8] = match (x, y) {
                (15..25, 10..20) => &[0, 0, 200],
                (10..30, 5..25) => &[200, 0, 0],
                _ => &[9, 8, 7],
            };
            assert_eq!(pixel(&view, x, y), expected, "({x}, {y})");
        }
    }
}

#[test]
fn a_photograph_comes_back_from_the_polygon_it_is_projected_on() {
    let folder = Folder::new();
    folder.draw("down.png", [40, 30], label);
    folder.write("down.json", document("camera", &vertical(40, 30, "")));
    let photographs =
        r#""photographs": [{ "name": "down", "image": "down.png", "camera": "down.json" }],"#;
    let ground = square(9.0, 0.0, r#""photograph": "down""#);
    // A map view of 50 × 40 pixels at the photograph's scale: 5 pixels of margin to each side.
    let rest = r#", "filter": "nearest", "background": [1, 2, 3]"#;
    folder.write("scene.json", scene(photographs, &ground, &map_view(50, 40), rest));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let view = folder.picture("view.png");
    for y in 0..40 {
        for x in 0..50 {
            let inside = (5..45).contains(&x) && (5..35).contains(&y);
            let expected = if inside { label(x - 5, y - 5) } else { [1, 2, 3] };
            assert_eq!(pixel(&view, x, y), expected, "({x}, {y})");
        }
    }
}

#[test]
fn a_photograph_is_looked_up_through_its_lens() {
    let folder = Folder::new();
    // Red is 2 x at the centre of pixel x, and bilinear interpolation reproduces the ramp: red = 2 (u − ½).
    folder.draw("down.png", [100, 80], |x, _| [(2 * x) as u8, 0, 0]);
    folder.write("down.json", document("camera", &vertical(100, 80, r#", "k": [-0.5, 0, 0]"#)));
    let photographs =
        r#""photographs": [{ "name": "down", "image": "down.png", "camera": "down.json" }],"#;
    let ground = square(9.0, 0.0, r#""photograph": "down""#);
    folder.write("scene.json", scene(photographs, &ground, &map_view(80, 60), ""));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let view = folder.picture("view.png");
    for (x, y) in [(0, 0), (79, 0), (40, 30), (79, 59), (20, 50)] {
        let (a, b) = ((f64::from(x) + 0.5 - 40.0) / 100.0, (f64::from(y) + 0.5 - 30.0) / 100.0);
        let u = 50.0 + 100.0 * a * (1.0 - 0.5 * (a * a + b * b));
        let red = f64::from(pixel(&view, x, y)[0]);
        assert!((red - 2.0 * (u - 0.5)).abs() <= 0.51, "({x}, {y}): {red} at {u}");
    }
    // The lens moves the corner by 4.8 pixels; without it red would be 2 · (−39.5 + 49.5) = 20.
    assert_eq!(pixel(&view, 0, 0)[0], 30);
}

#[test]
fn a_texture_lies_where_its_coordinates_say() {
    let folder = Folder::new();
    folder.draw("brick.png", [10, 10], label);
    // Half a texel a pixel, repeated: the square of 20 × 20 pixels shows texels 0..10, upside up.
    // The coordinates are homogeneous: (5, 15), (15, 15), (15, 5), (5, 5).
    let fill = r#""texture": "brick", "coordinates": [[10, 30, 2], [30, 30, 2], [30, 10, 2], [10, 10, 2]]"#;
    let textures =
        r#""textures": [{ "name": "brick", "image": "brick.png", "border": "repeat" }],"#;
    let rest = r#", "filter": "nearest""#;
    folder.write("scene.json", scene(textures, &square(1.0, 0.0, fill), &map_view(20, 20), rest));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let view = folder.picture("view.png");
    for y in 0..20 {
        for x in 0..20 {
            let expected = label((5 + x / 2) % 10, (5 + y / 2) % 10);
            assert_eq!(pixel(&view, x, y), expected, "({x}, {y})");
        }
    }
}

/// A floor from depth 1 to depth 3 before a level eye one above it, its texture's row v = 100 (depth − 1), red = v.
fn floor(folder: &Folder, vertices: &str, coordinates: &str, interpolation: &str) -> [u8; 3] {
    folder.draw("rows.png", [8, 200], |_, y| [y as u8, 0, 0]);
    let polygon = format!(
        r#"{{ "name": "floor", "vertices": {vertices}, "texture": "rows", "coordinates": {coordinates} }}"#
    );
    let view = r#""width": 300, "height": 400,
        "interior": { "model": "pinhole", "principal_distance": [300, 300], "principal_point": [150, 50] },
        "exterior": { "projection_center": [0, 0, 1], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }"#;
    let textures = r#""textures": [{ "name": "rows", "image": "rows.png" }],"#;
    let rest = format!(r#", "interpolation": "{interpolation}""#);
    folder.write("scene.json", scene(textures, &polygon, view, &rest));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    // The near edge is on line 350, the far one on 150: half way between is line 250, pixel 249 or 250.
    pixel(&folder.picture("view.png"), 150, 250).try_into().unwrap()
}

#[test]
fn interpolation_is_perspective_or_as_wrong_as_asked_for() {
    let folder = Folder::new();
    let quad = "[[-1, 1, 0], [1, 1, 0], [1, 3, 0], [-1, 3, 0]]";
    let rows = "[[0, 0], [8, 0], [8, 200], [0, 200]]";
    // Line 250.5 is depth 300/200.5, row 100 (300/200.5 − 1) = 49.6, whose centre is ½ further: red 49.1.
    assert_eq!(floor(&folder, quad, rows, "perspective"), [49, 0, 0]);
    // Half way on the screen is half way in the texture: 200 · (350 − 250.5)/200 − ½ = 99.
    assert_eq!(floor(&folder, quad, rows, "linear"), [99, 0, 0]);
    assert_eq!(floor(&folder, quad, rows, "bilinear"), [99, 0, 0]);
    // A triangle has no bilinear interpolation.
    let triangle = "[[-1, 1, 0], [1, 1, 0], [0, 3, 0]]";
    assert_eq!(floor(&folder, triangle, "[[0, 0], [8, 0], [4, 200]]", "bilinear"), [99, 0, 0]);
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    assert!(
        run.stderr.contains("polygons[0] `floor`: drawn linearly instead of bilinearly:"),
        "{}",
        run.stderr
    );
}

#[test]
fn the_side_that_turns_away_is_culled_where_the_scene_says_so() {
    let folder = Folder::new();
    let away =
        r#"{ "vertices": [[-1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0]], "color": [200, 0, 0] }"#;
    for (cull, red, said) in [
        ("none", [200, 0, 0], "1 polygons drawn, 0 culled"),
        ("back", [0; 3], "0 polygons drawn, 1 culled"),
    ] {
        let rest = format!(r#", "cull": "{cull}""#);
        folder.write("scene.json", scene("", away, &map_view(20, 20), &rest));
        let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
        assert!(run.stderr.contains(said), "{}", run.stderr);
        assert_eq!(pixel(&folder.picture("view.png"), 10, 10), red);
    }
}

#[test]
fn a_polygon_that_cannot_be_drawn_is_named_and_left_out_or_an_error_with_strict() {
    let folder = Folder::new();
    folder.draw("down.png", [40, 30], label);
    folder.write("down.json", document("camera", &vertical(40, 30, "")));
    let photographs =
        r#""photographs": [{ "name": "down", "image": "down.png", "camera": "down.json" }],"#;
    // x = z/100 seen from above: its plane, extended, passes through the photograph's camera at (0, 0, 10) with the
    // second vertices, x = (z − 10)/100.
    let slant = r#"{ "name": "slant", "vertices": [[-0.1, -1, 0], [0, -1, 10], [0, 1, 10], [-0.1, 1, 0]],
        "photograph": "down" }"#;
    let polygons = [slant.to_owned(), square(0.5, 0.0, RED)].join(",");
    folder.write("scene.json", scene(photographs, &polygons, &map_view(40, 30), ""));
    folder.write("view.png", "old");
    let strict = folder.run(&["render", "scene.json", "-o", "view.png", "--strict"]);
    assert_eq!(strict.code, 1);
    let reason = "scene.json: polygons[0] `slant`: photograph `down`: the camera lies in the plane and sees it as a line";
    assert!(strict.stderr.contains(reason), "{}", strict.stderr);
    assert_eq!(folder.text("view.png"), "old");
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    assert!(
        run.stderr.contains(reason) && run.stderr.contains("1 polygons drawn"),
        "{}",
        run.stderr
    );
    assert_eq!(pixel(&folder.picture("view.png"), 20, 17), [200, 0, 0]);
}

#[test]
fn a_wall_is_seen_however_far_the_ground_reaches() {
    let folder = Folder::new();
    // A level eye at height 1 that looks north. The wall is 20 away, the ground's end 50 km.
    let view = r#""width": 40, "height": 30,
        "interior": { "model": "pinhole", "principal_distance": [20, 20], "principal_point": [20, 15] },
        "exterior": { "projection_center": [0, 0, 1], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }"#;
    let wall = r#"{ "name": "wall", "vertices": [[-9, 20, 0], [9, 20, 0], [9, 20, 9], [-9, 20, 9]], "color": [200, 0, 0] }"#;
    let ground = r#"{ "vertices": [[-9, 5, 0], [9, 5, 0], [50000, 50000, 0], [-50000, 50000, 0]], "color": [0, 90, 0] }"#;
    let polygons = [wall, ground].join(",");
    folder.write("scene.json", scene("", &polygons, view, ""));
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    assert!(run.stderr.contains("2 polygons drawn, 0 culled, 0 out of view"), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    // 8 above the eye at 20 is 8 pixels up.
    assert_eq!(pixel(&folder.picture("view.png"), 20, 10), [200, 0, 0]);
    // What a larger near distance takes away is told; what lies behind the eye or beside the view is no news.
    let others = r#"{ "vertices": [[-9, -20, 0], [9, -20, 0], [9, -20, 9]], "color": [1, 2, 3] },
        { "vertices": [[80, 20, 0], [90, 20, 0], [90, 20, 9]], "color": [1, 2, 3] },
        { "vertices": [[-1, 10, 0], [1, 10, 0], [1, 10, 2]], "color": [1, 2, 3] }"#;
    let polygons = [wall, ground, others].join(",");
    folder.write("scene.json", scene("", &polygons, view, r#", "near": 50"#));
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let told = "warning: scene.json: polygons[0] `wall`: lies up to a depth of 20, nearer than `near`, 50, \
        and is not drawn, like 1 other";
    assert!(run.stderr.contains(told), "{}", run.stderr);
    assert!(run.stderr.contains("1 polygons drawn, 0 culled, 4 out of view"), "{}", run.stderr);
    assert_eq!(pixel(&folder.picture("view.png"), 20, 10), [0, 0, 0]);
}

#[test]
fn an_outline_that_crosses_itself_is_drawn_by_the_even_odd_rule() {
    let folder = Folder::new();
    // A bow tie: its two triangles are drawn. A pentagram: its points are drawn and its middle is not.
    let tie =
        r#"{ "vertices": [[-1, -1, 0], [1, 1, 0], [1, -1, 0], [-1, 1, 0]], "color": [200, 0, 0] }"#;
    folder.write("scene.json", scene("", tie, &map_view(20, 20), ""));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let view = folder.picture("view.png");
    for (x, y, red) in [(2, 10, 200), (17, 10, 200), (10, 2, 0), (10, 17, 0)] {
        assert_eq!(pixel(&view, x, y), [red, 0, 0], "({x}, {y})");
    }
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * (k as f64 / 5.0 + 0.25);
        format!("[{}, {}, 0]", angle.cos(), angle.sin())
    };
    let star = [0, 2, 4, 1, 3].map(corner).join(",");
    let star = format!(r#"{{ "vertices": [{star}], "color": [200, 0, 0] }}"#);
    folder.write("scene.json", scene("", &star, &map_view(20, 20), ""));
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let view = folder.picture("view.png");
    for (x, y, red) in [(10, 3, 200), (3, 7, 200), (16, 7, 200), (10, 10, 0), (9, 8, 0), (0, 0, 0)]
    {
        assert_eq!(pixel(&view, x, y), [red, 0, 0], "({x}, {y})");
    }
}

#[test]
fn vertices_off_their_plane_are_told() {
    let folder = Folder::new();
    let bent = r#"{ "vertices": [[-1, -1, 0], [1, -1, 0.2], [1, 1, 0], [-1, 1, 0.2]], "color": [0, 90, 0] }"#;
    folder.write("scene.json", scene("", bent, &map_view(20, 20), ""));
    let run = folder.succeed(&["render", "scene.json", "-o", "view.jpg"]);
    // Two corners raised by 0.2 and two not: the best plane is 0.1 from each.
    assert!(run.stderr.contains("vertices lie up to 1.000e-1 off it"), "{}", run.stderr);
}

#[test]
fn a_photograph_is_looked_up_through_any_central_model() {
    // Red is 2 x at the centre of pixel x, and bilinear interpolation reproduces the ramp: red = 2 (u − ½).
    let folder = Folder::new();
    folder.draw("down.png", [100, 80], |x, y| [(2 * x) as u8, (3 * y) as u8, 0]);
    let photographs =
        r#""photographs": [{ "name": "down", "image": "down.png", "camera": "down.json" }],"#;
    let ground = square(9.0, 0.0, r#""photograph": "down""#);
    folder.write("scene.json", scene(photographs, &ground, &map_view(80, 60), ""));
    let pixels = r#""principal_distance": [100, 100], "principal_point": [50, 40]"#;
    for (model, radius) in [
        (r#""model": "fisheye""#, f64::atan as fn(f64) -> f64),
        (r#""model": "fisheye", "projection": "stereographic""#, |t| 2.0 * (0.5 * t.atan()).tan()),
        // r_u = r/(1 + λ r²)
        (r#""model": "division", "lambda": -0.25"#, |t| (1.0 - (1.0 + t * t).sqrt()) / (-0.5 * t)),
        (r#""model": "rational", "k": [-0.5, 0, 0, 0, 0, 0]"#, |t| t * (1.0 - 0.5 * t * t)),
    ] {
        let camera = looking_down([100, 80], &format!("{model}, {pixels}"));
        folder.write("down.json", document("camera", &camera));
        folder.succeed(&["render", "scene.json", "-o", "view.png"]);
        let view = folder.picture("view.png");
        for (x, y) in [(0, 0), (79, 0), (40, 30), (79, 59), (20, 50)] {
            let (a, b) = ((f64::from(x) + 0.5 - 40.0) / 100.0, (f64::from(y) + 0.5 - 30.0) / 100.0);
            let scale = radius(a.hypot(b)) / a.hypot(b);
            let expected =
                [2.0 * (50.0 + 100.0 * a * scale - 0.5), 3.0 * (40.0 + 100.0 * b * scale - 0.5)];
            let found = pixel(&view, x, y);
            for (f, e) in found.iter().zip(expected) {
                assert!(
                    (f64::from(*f) - e).abs() <= 0.51,
                    "{model} ({x}, {y}): {found:?}, {expected:?}"
                );
            }
        }
    }
}

/// From 10 above, a pixel for each degree: the square's edge is at 45° along the axes, its corners at atan √2 = 54.7°.
#[test]
fn a_view_may_be_a_fisheye_a_panorama_or_a_scanner() {
    let folder = Folder::new();
    let degree = 180.0 / std::f64::consts::PI;
    let fisheye = looking_down(
        [160, 160],
        &format!(
            r#""model": "fisheye", "principal_distance": [{degree}, {degree}], "principal_point": [80, 80]"#
        ),
    );
    folder.write("scene.json", scene("", &square(10.0, 0.0, RED), &fisheye, ""));
    folder.succeed(&["render", "scene.json", "-o", "fisheye.png"]);
    let picture = folder.picture("fisheye.png");
    let red = |x: u32, y: u32| pixel(&picture, x, y) == [200, 0, 0];
    assert!(red(80 + 44, 80) && !red(80 + 45, 80) && red(80, 79 - 44) && !red(80, 79 - 45));
    // 38.5 pixels along both axes are 54.4°, 39.5 are 55.9°.
    assert!(red(80 + 38, 80 + 38) && !red(80 + 39, 80 + 39));

    // A whole panorama about a level camera that looks north sees the ground from atan(√2) below the horizon on at its corners.
    let level = r#""width": 360, "height": 180, "interior": { "model": "equirectangular" },
        "exterior": { "projection_center": [0, 0, 10], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }"#;
    folder.write("pano.json", document("camera", level));
    folder.succeed(&["render", "scene.json", "--view", "pano.json", "-o", "pano.png"]);
    let picture = folder.picture("pano.png");
    let red = |x: u32, y: u32| pixel(&picture, x, y) == [200, 0, 0];
    // North, at column 180, the edge is 45° down; to the north-east 90° − 54.7° = 35.3°.
    assert!(red(180, 135) && !red(180, 134) && red(225, 126) && !red(225, 124));
    // A polygon before the near distance is told.
    folder.write("near.json", scene("", &square(10.0, 0.0, RED), &fisheye, r#", "near": 30"#));
    let run = folder.succeed(&["render", "near.json", "-o", "near.png"]);
    let told = "polygons[0]: lies up to a distance of 17.3205, nearer than `near`, 30";
    assert!(run.stderr.contains(told), "{}", run.stderr);
    // Straight down on every column.
    assert!((0..360).all(|x| red(x, 179)));

    // A push broom that flies east at a tenth of a unit a line; a pixel is a tenth of a unit too.
    let scanner = r#""width": 100, "height": 300,
        "scan": { "kind": "pushbroom", "row": 0.5, "per_line": 1 },
        "interior": { "model": "pinhole", "principal_distance": [100, 100], "principal_point": [50, 0.5] },
        "trajectory": { "exterior": { "projection_center": [-15, 0, 10],
            "rotation_matrix": [[0, 1, 0], [1, 0, 0], [0, 0, -1]] },
            "position_polynomial": [[0, 0, 0], [0.1, 0, 0]] }"#;
    folder.write("strip.json", document("scanner", scanner));
    folder.write("small.json", scene("", &square(4.0, 0.0, RED), &fisheye, ""));
    folder.succeed(&["render", "small.json", "--view", "strip.json", "-o", "strip.png"]);
    let picture = folder.picture("strip.png");
    for (x, y) in [(10, 110), (89, 110), (10, 189), (89, 189), (50, 150)] {
        assert_eq!(pixel(&picture, x, y), [200, 0, 0], "({x}, {y})");
    }
    for (x, y) in [(9, 150), (90, 150), (50, 109), (50, 190)] {
        assert_eq!(pixel(&picture, x, y), [0, 0, 0], "({x}, {y})");
    }
}

/// The strip of a scanner is projected on the ground that it was taken of.
#[test]
fn a_photograph_may_be_a_scanners() {
    let folder = Folder::new();
    // A pixel is 0.1; line y is flown at X = −1 + 0.1 y, and pixel x sees Y = 0.1 (x − 10).
    let scanner = r#"{ "scanner": { "width": 20, "height": 20,
        "scan": { "kind": "pushbroom", "row": 0.5, "per_line": 1 },
        "interior": { "model": "pinhole", "principal_distance": [100, 100], "principal_point": [10, 0.5] },
        "trajectory": { "exterior": { "projection_center": [-1, 0, 10],
            "rotation_matrix": [[0, 1, 0], [1, 0, 0], [0, 0, -1]] },
            "position_polynomial": [[0, 0, 0], [0.1, 0, 0]] } } }"#;
    folder.draw("strip.png", [20, 20], label);
    let photographs = format!(
        r#""photographs": [{{ "name": "s", "image": "strip.png", "camera": {scanner} }}],"#
    );
    let fill = r#""photograph": "s""#;
    let view = map_view(20, 20);
    folder.write(
        "scene.json",
        scene(&photographs, &square(1.0, 0.0, fill), &view, r#", "filter": "nearest""#),
    );
    folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let picture = folder.picture("view.png");
    for (x, y) in [(0, 0), (19, 3), (7, 12), (10, 19)] {
        // The view's pixel is at X = 0.1 (x − 9.5), Y = −0.1 (y − 9.5): line x, pixel 19 − y.
        assert_eq!(pixel(&picture, x, y), label(19 - y, x), "({x}, {y})");
    }
}

#[test]
fn a_view_of_polygons_that_are_all_none_says_why_of_each() {
    let folder = Folder::new();
    let view = r#""width": 20, "height": 20,
        "interior": { "model": "fisheye", "principal_distance": [9, 9], "principal_point": [10, 10] },
        "exterior": { "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] }"#;
    let line = r#"{ "vertices": [[0, 0, 5], [1, 0, 5], [2, 0, 5]], "color": [9, 9, 9] }"#;
    folder.write("scene.json", scene("", line, view, ""));
    let run = folder.succeed(&["render", "scene.json", "-o", "view.png"]);
    let expected = "polygons[0]: its vertices lie on one line; it is left out";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}
