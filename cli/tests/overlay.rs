//! `collinear overlay`.

use collinear::nalgebra::{Point2, Point3};
use collinear_cli::overlay::{Figure, Overlay};
use collinear_io::Document;
use collinear_io::camera::CameraFile;

use crate::support::{Folder, document, ground, looking_down, map_view, pixel, vertical};

const GREY: [u8; 3] = [100, 100, 100];

fn folder(lens: &str) -> Folder {
    let folder = Folder::new();
    folder.draw("photo.png", [400, 300], |_, _| GREY);
    folder.write("camera.json", document("camera", &vertical(400, 300, lens)));
    folder.write(
        "plane.json",
        ground(r#", "rectangle": { "left": -5, "bottom": -2, "right": 5, "top": 4 }"#),
    );
    folder
}

fn overlay<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["overlay", "photo.png", "--camera", "camera.json"], more].concat()
}

/// The polylines of an SVG's paths, by path.
fn paths(svg: &str) -> Vec<Vec<Vec<[f64; 2]>>> {
    let number = |t: &str| t.parse::<f64>().unwrap();
    let point = |t: &str| {
        let (x, y) = t.split_once(' ').unwrap();
        [number(x), number(y)]
    };
    let path = |d: &str| d.split('M').skip(1).map(|l| l.split('L').map(point).collect()).collect();
    svg.split(" d=\"").skip(1).map(|rest| path(rest.split('"').next().unwrap())).collect()
}

#[test]
fn a_rectangle_is_drawn_where_it_is_seen() {
    let folder = folder("");
    let run = folder.succeed(&overlay(&["--plane", "plane.json", "-o", "out.svg"]));
    assert!(run.stderr.contains("4 lines drawn, of 4 edges"), "{}", run.stderr);
    let svg = folder.text("out.svg");
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"400\" height=\"300\" viewBox=\"0 0 400 300\">"));
    assert!(svg.contains("href=\"data:image/png;base64,iVBORw0KGgo"));
    // 10 pixels a unit about (200, 150): x 150 to 250, y 110 to 170.
    let mut lines = paths(&svg).concat();
    lines.iter_mut().for_each(|l| l.sort_by(|a, b| a.partial_cmp(b).unwrap()));
    lines.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(
        lines,
        [
            [[150.0, 110.0], [150.0, 170.0]],
            [[150.0, 110.0], [250.0, 110.0]],
            [[150.0, 170.0], [250.0, 170.0]],
            [[250.0, 110.0], [250.0, 170.0]],
        ]
    );
    // A grid of 3 × 3 cells has 8 lines.
    let run = folder.succeed(&overlay(&["--plane", "plane.json", "--grid", "3", "-o", "out.svg"]));
    assert!(run.stderr.contains("8 lines drawn, of 8 edges"), "{}", run.stderr);
}

#[test]
fn a_photograph_is_linked_where_asked_for() {
    let folder = folder("");
    folder.succeed(&overlay(&["--plane", "plane.json", "--link", "-o", "out.svg"]));
    assert!(folder.text("out.svg").contains("href=\"photo.png\""));
}

#[test]
fn lines_are_drawn_into_a_picture() {
    let folder = folder("");
    folder.succeed(&overlay(&["--plane", "plane.json", "--line-width", "3", "-o", "out.png"]));
    let out = folder.picture("out.png");
    assert_eq!((out.width, out.height, out.channels), (400, 300, 3));
    // A line of 3 pixels about x = 150 covers pixels 149 and 150 wholly, its casing of 6 also 147 and 152, half.
    for x in [149, 150] {
        assert_eq!(pixel(&out, x, 140), [240, 228, 66]);
    }
    for x in [147, 152] {
        assert!(
            pixel(&out, x, 140).iter().all(|c| (49..=51).contains(c)),
            "{:?}",
            pixel(&out, x, 140)
        );
    }
    assert_eq!(pixel(&out, 155, 140), GREY);
}

#[test]
fn a_shared_edge_is_drawn_once_and_names_are_text() {
    let folder = folder("");
    let scene = r#""polygons": [
        { "name": "a <&> b", "vertices": [[-5, 0, 0], [0, 0, 0], [0, 3, 0], [-5, 3, 0]], "color": [1, 2, 3] },
        { "vertices": [[0, 0, 0], [5, 0, 0], [5, 3, 0], [0, 3, 0]], "color": [1, 2, 3] },
        { "name": "above", "vertices": [[0, 0, 20], [5, 0, 20], [5, 3, 20]], "color": [1, 2, 3] } ],"#;
    let view = vertical(40, 30, "");
    folder.write("scene.json", document("scene", &format!("{scene} \"view\": {{ {view} }}")));
    let run = folder.succeed(&overlay(&["--scene", "scene.json", "-o", "out.svg"]));
    // Four edges and three; the triangle is behind the camera.
    assert!(run.stderr.contains("7 lines drawn, of 11 edges in 3 figures"), "{}", run.stderr);
    let svg = folder.text("out.svg");
    let counts: Vec<_> = paths(&svg).iter().map(Vec::len).collect();
    assert_eq!(counts, [4, 3, 0]);
    // In the middle of the first square, (−2.5, 1.5).
    assert!(
        svg.contains("<text x=\"175.0\" y=\"135.0\" fill=\"#f0e442\">a &lt;&amp;&gt; b</text>")
    );
    assert!(!svg.contains(">above</text>"));
    folder.succeed(&overlay(&["--scene", "scene.json", "--no-names", "-o", "out.svg"]));
    assert!(!folder.text("out.svg").contains("<text"));
}

#[test]
fn an_edge_ends_before_the_camera() {
    let folder = folder("");
    // A mast through the eye's height: from (1, 0, 0) to (1, 0, 20); the eye is at 10. It leaves the cone of the
    // picture's surroundings towards the right, far before it reaches the eye.
    folder.write("mesh.obj", "v 1 0 0\nv 1 0 20\nl 1 2\n");
    folder.succeed(&overlay(&["--mesh", "mesh.obj", "-o", "out.svg"]));
    let lines = paths(&folder.text("out.svg")).concat();
    assert_eq!(lines.len(), 1);
    let [a, b] = lines[0][..] else { panic!("{lines:?}") };
    assert_eq!(a, [210.0, 150.0]);
    // The corners are at 2.5 · 100 pixels from the middle; a tenth beyond is 275.
    assert!((b[0] - 475.0).abs() < 1e-3 && b[1] == 150.0, "{b:?}");
}

#[test]
fn a_frame_of_which_nothing_is_in_view_is_told() {
    let folder = folder("");
    folder.write("mesh.obj", "v 0 0 20\nv 1 0 20\nv 1 1 20\nf 1 2 3\n");
    let run = folder.succeed(&overlay(&["--mesh", "mesh.obj", "-o", "out.svg"]));
    let told = "warning: out.svg: none of the 3 edges is in view of the camera";
    assert!(run.stderr.contains(told), "{}", run.stderr);
}

#[test]
fn a_mesh_is_read_with_its_groups() {
    let folder = folder("");
    let mesh = "# a comment\nmtllib x.mtl\no roof\nv -1 -1 0\nv 1 -1 0\nv 1 1 0 1.0\nf 1/1/1 2/2/1 3/3/1\n\
                o wall\nv -1 1 0\nf -4//1 -2//1 -1//1\n";
    folder.write("mesh.obj", mesh);
    let run = folder.succeed(&overlay(&["--mesh", "mesh.obj", "-o", "out.svg"]));
    // Two triangles with a common edge.
    assert!(run.stderr.contains("5 lines drawn, of 6 edges in 2 figures"), "{}", run.stderr);
    let svg = folder.text("out.svg");
    assert!(svg.contains(">roof</text>") && svg.contains("<title>wall</title>"));
    for (mesh, reason) in [
        ("v 1 2\n", "mesh.obj: line 1: a vertex needs three finite numbers"),
        ("v 1 2 NaN\n", "mesh.obj: line 1: a vertex needs three finite numbers"),
        ("v 1 2 3\nf 1 2 1\n", "mesh.obj: line 2: `2` names no vertex, there are 1 so far"),
        ("v 1 2 3\nf 0 1 1\n", "mesh.obj: line 2: `0` names no vertex, there are 1 so far"),
        ("v 1 2 3\nf -2 1 1\n", "mesh.obj: line 2: `-2` names no vertex, there are 1 so far"),
    ] {
        folder.write("mesh.obj", mesh);
        let run = folder.run(&overlay(&["--mesh", "mesh.obj", "-o", "out.svg"]));
        assert_eq!((run.code, run.stderr), (1, format!("collinear: error: {reason}\n")));
    }
}

/// Distance from a polyline.
fn off(line: &[[f64; 2]], p: [f64; 2]) -> f64 {
    let piece = |a: [f64; 2], b: [f64; 2]| {
        let (d, r) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let t = ((d[0] * r[0] + d[1] * r[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        (r[0] - t * d[0]).hypot(r[1] - t * d[1])
    };
    line.windows(2).map(|w| piece(w[0], w[1])).fold(f64::INFINITY, f64::min)
}

/// Lines of an edge with every image of its points in the picture within a tenth of a pixel.
fn follows(file: &CameraFile, ends: [[f64; 3]; 2]) -> Vec<Vec<[f64; 2]>> {
    let camera = file.camera().unwrap();
    let ends = ends.map(Point3::from);
    let figure = Figure { name: None, edges: vec![ends], middle: ends[0] };
    let overlay = Overlay::trace(&[figure], &file.clone().into()).unwrap();
    let line = |l: &Vec<_>| l.iter().map(|p: &Point2<f64>| [p.x, p.y]).collect();
    let lines: Vec<Vec<[f64; 2]>> = overlay.drawings[0].lines.iter().map(line).collect();
    let (mut worst, mut seen) = (0.0_f64, 0);
    for i in 0..=100_000 {
        let world = ends[0] + (ends[1] - ends[0]) * (f64::from(i) / 1e5);
        // The camera's own projection, point by point; it refuses what is past the fold.
        let Ok(p) = camera.sensor().project(&world) else { continue };
        let (w, h) = (f64::from(file.width), f64::from(file.height));
        if (0.0..w).contains(&p.x) && (0.0..h).contains(&p.y) {
            let nearest = lines.iter().map(|l| off(l, [p.x, p.y])).fold(f64::INFINITY, f64::min);
            worst = worst.max(nearest);
            seen += 1;
        }
    }
    assert!(seen > 10_000 && worst < 0.1, "{:?}: {worst} at {seen} points", file.interior);
    // No line leaps over the picture.
    let pieces = lines.iter().flat_map(|l| l.windows(2));
    let longest = pieces.map(|w| (w[0][0] - w[1][0]).hypot(w[0][1] - w[1][1])).fold(0.0, f64::max);
    assert!(longest < 0.8 * f64::from(file.width), "{longest}");
    lines
}

#[test]
fn a_line_through_a_lens_is_right_to_a_tenth_of_a_pixel() {
    for lens in [
        r#", "k": [-0.2, 0.02, 0]"#,
        r#", "k": [0.3, 0.1, -0.02], "p": [0.03, 0.02]"#,
        r#", "k": [-0.25, 0, 0], "p": [0.01, 0]"#,
    ] {
        let file = CameraFile::parse(&document("camera", &vertical(400, 300, lens))).unwrap();
        let lines = follows(&file, [[-40.0, 13.0, 0.0], [25.0, -11.0, 3.0]]);
        assert!(lines.len() == 1 && lines[0].len() < 60, "{} pieces", lines[0].len());
    }
}

#[test]
fn a_line_through_any_central_model_is_right_to_a_tenth_of_a_pixel() {
    let pixels = r#""principal_distance": [100, 100], "principal_point": [200, 150]"#;
    for (model, lines) in [
        (r#""model": "rational", PIXELS, "k": [-0.2, 0.02, 0, 0.1], "tau": [0.1, 0]"#, 1),
        (r#""model": "metashape", PIXELS, "k": [0.1, 0, 0, 0]"#, 1),
        (r#""model": "fisheye", PIXELS"#, 1),
        (r#""model": "fisheye", PIXELS, "projection": "equisolid""#, 1),
        (r#""model": "double_sphere", PIXELS, "xi": -0.2, "alpha": 0.59"#, 1),
        (r#""model": "colmap", "colmap_model": "FOV", "parameters": [150, 150, 200, 150, 1]"#, 1),
        // The line passes below the camera from left to right, the seam is above its horizon to the rear.
        (r#""model": "equirectangular""#, 1),
    ] {
        let model = model
            .replace("PIXELS", pixels)
            .replace("[-0.2, 0.02, 0, 0.1]", "[-0.2, 0.02, 0, 0.1, 0, 0]");
        let file =
            CameraFile::parse(&document("camera", &looking_down([400, 300], &model))).unwrap();
        let found = follows(&file, [[-40.0, 13.0, 0.0], [25.0, -11.0, 3.0]]);
        assert_eq!(found.len(), lines, "{model}");
        assert!(found[0].len() < 60, "{model}: {} pieces", found[0].len());
    }
}

#[test]
fn a_line_over_the_seam_of_a_panorama_has_two_parts() {
    let level = r#""width": 720, "height": 360, "interior": { "model": "equirectangular" },
        "exterior": { "projection_center": [0, 0, 10], "rotation_matrix": [[1, 0, 0], [0, 0, -1], [0, 1, 0]] }"#;
    let file = CameraFile::parse(&document("camera", level)).unwrap();
    // Looking north; the line runs behind it, from south-west to south-east, level with the camera and a little below.
    for z in [10.0, 9.0] {
        let mut lines = follows(&file, [[-10.0, -10.0, z], [10.0, -10.0, z]]);
        lines.sort_by(|a, b| a[0].partial_cmp(&b[0]).unwrap());
        let [left, right] = &lines[..] else { panic!("{} lines", lines.len()) };
        // 135° to either side is 270 pixels from the middle; the seam is 360 from it.
        let ends = |l: &[[f64; 2]]| {
            let mut ends = [l[0][0], l[l.len() - 1][0]];
            ends.sort_by(f64::total_cmp);
            ends
        };
        for (found, expected) in [(ends(left), [0.0, 90.0]), (ends(right), [630.0, 720.0])] {
            for (f, e) in found.iter().zip(expected) {
                assert!((f - e).abs() < 1e-3, "{found:?}, {expected:?}");
            }
        }
    }
}

#[test]
fn a_line_that_leaves_a_fisheyes_picture_comes_back() {
    // The picture shows 115° to each side and 57° up and down; the line 76° up leaves it at the top.
    let fisheye =
        r#""model": "fisheye", "principal_distance": [100, 100], "principal_point": [200, 100]"#;
    let file = CameraFile::parse(&document("camera", &looking_down([400, 200], fisheye))).unwrap();
    let lines = follows(&file, [[-100.0, 40.0, 0.0], [100.0, 40.0, 0.0]]);
    assert_eq!(lines.len(), 2);
    // Both end a tenth above the picture.
    for line in lines {
        let top = line.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        assert!((top + 20.0).abs() < 1e-9, "{top}");
    }
    // An edge that points at the camera is a dot, as other cameras draw it.
    let ends = [[5.0, 0.0, 5.0], [7.0, 0.0, 3.0]].map(Point3::from);
    let figure = Figure { name: None, edges: vec![ends], middle: ends[0] };
    let overlay = Overlay::trace(&[figure], &file.into()).unwrap();
    assert_eq!(overlay.line_count(), 1);
    let p = overlay.drawings[0].lines[0][0];
    // 45° to the right.
    assert!((p - Point2::new(200.0 + 25.0 * std::f64::consts::PI, 100.0)).norm() < 1e-9, "{p}");
}

#[test]
fn lines_over_a_map_end_a_tenth_beyond_it() {
    let folder = folder("");
    folder.write("camera.json", document("camera", &map_view(400, 300)));
    // 10 pixels a unit about (200, 150). The second line passes above the map.
    let mesh =
        "v -100 1 0\nv 100 1 9\nl 1 2\nv -100 40 0\nv 100 40 0\nl 3 4\nv 1 1 0\nv 2 2 0\nl 5 6\n";
    folder.write("mesh.obj", mesh);
    folder.succeed(&overlay(&["--mesh", "mesh.obj", "-o", "out.svg"]));
    let lines = paths(&folder.text("out.svg")).concat();
    assert_eq!(lines, [[[-40.0, 140.0], [440.0, 140.0]], [[210.0, 140.0], [220.0, 130.0]]]);
}

/// A panoramic camera that turns about y, c = 100: along X at depth 10 and height 5 it draws y = 150 + 100 · ½ cos of the scan angle.
#[test]
fn edges_are_curves_of_a_scanners_picture() {
    let folder = folder("");
    let scanner = r#""width": 200, "height": 300,
        "scan": { "kind": "panoramic", "per_column": 1 },
        "interior": { "model": "cylindrical", "principal_distance": [100, 100], "principal_point": [100, 150] },
        "trajectory": { "exterior": { "projection_center": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0] } }"#;
    folder.write("scanner.json", document("scanner", scanner));
    folder.draw("strip.png", [200, 300], |_, _| [90, 90, 90]);
    folder.write("mesh.obj", "v -30 5 10\nv 30 5 10\nl 1 2\n");
    let run = folder.succeed(&[
        "overlay",
        "strip.png",
        "--camera",
        "scanner.json",
        "--mesh",
        "mesh.obj",
        "-o",
        "out.svg",
    ]);
    assert!(run.stderr.contains("1 lines drawn"), "{}", run.stderr);
    let lines = paths(&folder.text("out.svg")).concat();
    let [line] = &lines[..] else { panic!("{lines:?}") };
    // An SVG has three digits.
    let curve = |x: f64| 150.0 + 50.0 * ((x - 100.0) / 100.0).cos();
    for p in line {
        assert!((p[1] - curve(p[0])).abs() < 2e-3, "{p:?}");
    }
    for pair in line.windows(2) {
        let middle = [0, 1].map(|i| 0.5 * (pair[0][i] + pair[1][i]));
        assert!((middle[1] - curve(middle[0])).abs() < 0.1, "{pair:?}");
    }
    // The edge ends beyond the scan, which is drawn from its first column to its last.
    let ends = [line[0][0], line[line.len() - 1][0]];
    assert!(ends[0].abs() < 1e-3 && (ends[1] - 200.0).abs() < 1e-3, "{ends:?}");
}
