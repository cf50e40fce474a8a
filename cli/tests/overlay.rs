//! `collinear overlay`.

use collinear::nalgebra::Point3;
use collinear_cli::overlay::{Figure, Overlay};
use collinear_io::Document;
use collinear_io::camera::CameraFile;

use crate::support::{Folder, document, ground, map_view, pixel, vertical};

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

#[test]
fn a_line_through_a_lens_is_right_to_a_tenth_of_a_pixel() {
    for lens in [
        r#", "k": [-0.2, 0.02, 0]"#,
        r#", "k": [0.3, 0.1, -0.02], "p": [0.03, 0.02]"#,
        r#", "k": [-0.25, 0, 0], "p": [0.01, 0]"#,
    ] {
        let file = CameraFile::parse(&document("camera", &vertical(400, 300, lens))).unwrap();
        let camera = file.camera().unwrap();
        let ends = [[-40.0, 13.0, 0.0], [25.0, -11.0, 3.0]].map(Point3::from);
        let figure = Figure { name: None, edges: vec![ends], middle: ends[0] };
        let overlay = Overlay::trace(&[figure], &file).unwrap();
        let [line] = &overlay.drawings[0].lines[..] else { panic!("{overlay:?}") };
        let line: Vec<[f64; 2]> = line.iter().map(|p| [p.x, p.y]).collect();
        let (mut worst, mut seen) = (0.0_f64, 0);
        for i in 0..=100_000 {
            let world = ends[0] + (ends[1] - ends[0]) * (f64::from(i) / 1e5);
            // The camera's own projection, point by point; it refuses what is past the fold.
            let Ok(p) = camera.sensor().project(&world) else { continue };
            if (0.0..400.0).contains(&p.x) && (0.0..300.0).contains(&p.y) {
                worst = worst.max(off(&line, [p.x, p.y]));
                seen += 1;
            }
        }
        assert!(seen > 10_000 && worst < 0.1, "{lens}: {worst} at {seen} points");
        assert!(line.len() < 60, "{} pieces", line.len());
    }
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
