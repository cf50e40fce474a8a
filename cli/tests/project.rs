//! `collinear project`.

use crate::support::{Folder, document, ground, looking_down, vertical};

fn folder(lens: &str) -> Folder {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &vertical(400, 300, lens)));
    folder.write("ground.json", ground(""));
    folder
}

#[test]
fn world_points_get_their_pixels_or_a_reason() {
    let folder = folder("");
    folder
        .write("points.csv", "id,X,Y,Z\nA,1,0,0\n\"church, old\",0,2,5\nhigh,0,0,10\nfar,30,0,0\n");
    let run = folder.succeed(&["project", "--camera", "camera.json", "points.csv"]);
    // f = 100 from 10 above: A is 10 pixels right, the church at depth 5 is 40 up, the third is the eye itself.
    assert_eq!(
        run.stdout,
        "id,X,Y,Z,x,y,status\n\
         A,1.0,0.0,0.0,210.0,150.0,ok\n\
         \"church, old\",0.0,2.0,5.0,200.0,110.0,ok\n\
         high,0.0,0.0,10.0,,,the point lies behind the camera: depth 0\n\
         far,30.0,0.0,0.0,500.0,150.0,outside the picture\n"
    );
    assert_eq!(run.stderr, "");
}

#[test]
fn a_list_without_points_gives_a_table_without_lines_and_says_so() {
    let folder = folder("");
    folder.write("points.csv", "id,X,Y,Z\n").write("clicks.csv", "X,Y,Z,x,y\n1,2,3,,\n");
    let run = folder.succeed(&["project", "--camera", "camera.json", "points.csv"]);
    assert_eq!(run.stdout, "id,X,Y,Z,x,y,status\n");
    assert_eq!(run.stderr, "collinear: warning: points.csv: no point is in it\n");
    let inverse = ["--inverse", "--plane", "ground.json", "clicks.csv"];
    let run = folder.succeed(&[&["project", "--camera", "camera.json"], &inverse[..]].concat());
    assert_eq!(run.stdout, "id,X,Y,Z,x,y,status\n");
    assert_eq!(run.stderr, "collinear: warning: clicks.csv: no point with x and y is in it\n");
}

#[test]
fn a_point_past_the_fold_has_a_reason() {
    // 1 − 3 · 0.5 r² = 0 at r = √(2/3) = 0.8165: 8.165 from the middle on the ground.
    let folder = folder(r#", "k": [-0.5, 0, 0]"#);
    folder.write("points.csv", "8,0,0\n8.2,0,0\n");
    let run = folder.succeed(&["project", "--camera", "camera.json", "points.csv"]);
    let lines: Vec<_> = run.stdout.lines().collect();
    // 0.8 (1 − 0.5 · 0.64) = 0.544.
    let x: f64 = lines[1].split(',').nth(4).unwrap().parse().unwrap();
    assert!((x - 254.4).abs() < 1e-12 && lines[1].ends_with(",150.0,ok"), "{}", lines[1]);
    assert!(lines[2].starts_with(",8.2,0.0,0.0,,,outside the model's domain: 0.8"), "{}", lines[2]);
}

#[test]
fn pixels_get_their_place_on_a_plane() {
    let folder = folder("");
    folder.write("clicks.csv", "id x y\na 210 150\nb 200 110\nc -100 150\n");
    let arguments =
        ["project", "--camera", "camera.json", "--inverse", "--plane", "ground.json", "clicks.csv"];
    let run = folder.succeed(&[&arguments[..], &["-o", "out.csv"]].concat());
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let text = folder.text("out.csv");
    let expected = [("a", [1.0, 0.0, 0.0]), ("b", [0.0, 4.0, 0.0]), ("c", [-30.0, 0.0, 0.0])];
    for (line, (id, world)) in text.lines().skip(1).zip(expected) {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields[0], id);
        for (field, w) in fields[1..4].iter().zip(world) {
            assert!((field.parse::<f64>().unwrap() - w).abs() < 1e-13, "{line}");
        }
        assert_eq!(fields[6], if id == "c" { "outside the picture" } else { "ok" });
    }
    // A plane above the camera is behind every pixel.
    folder.write("ground.json", document("plane", r#""point": [0, 0, 11], "normal": [0, 0, 1]"#));
    let run = folder.succeed(&arguments);
    assert_eq!(
        run.stdout.lines().nth(1),
        Some("a,,,,210.0,150.0,the line of sight does not meet the surface")
    );
}

#[test]
fn what_was_projected_comes_back_to_the_last_digits_in_map_coordinates() {
    let folder = Folder::new();
    let camera = r#""width": 8000, "height": 6000,
        "interior": { "model": "brown", "principal_distance": [9000, 9000], "principal_point": [4000, 3000],
            "k": [-0.05, 0.01, 0], "p": [0.0002, -0.0001] },
        "exterior": { "projection_center": [691234.5, 5334321.25, 1250.75], "omega_phi_kappa": [0.02, -0.03, 1.1] }"#;
    folder.write("camera.json", document("camera", camera));
    folder.write(
        "ground.json",
        document("plane", r#""point": [691000, 5334000, 510.125], "normal": [0.01, -0.02, 1]"#),
    );
    folder.write("clicks.csv", "100.25,200.5\n7900.125,5800\n4000,3000\n");
    folder.succeed(&[
        "project",
        "--camera",
        "camera.json",
        "--inverse",
        "--plane",
        "ground.json",
        "clicks.csv",
        "-o",
        "world.csv",
    ]);
    let run = folder.succeed(&["project", "--camera", "camera.json", "world.csv"]);
    // A coordinate of 5·10⁶ has a last bit of 9·10⁻¹⁰, which at this scale is 10⁻⁸ of a pixel.
    for (line, expected) in
        run.stdout.lines().skip(1).zip([[100.25, 200.5], [7900.125, 5800.0], [4000.0, 3000.0]])
    {
        let fields: Vec<_> = line.split(',').collect();
        for (field, e) in fields[4..6].iter().zip(expected) {
            assert!((field.parse::<f64>().unwrap() - e).abs() < 3e-8, "{line}");
        }
    }
}

/// What went through `--inverse` onto the plane through `point` and came back.
fn there_and_back(interior: &str, plane: &str, clicks: &[[f64; 2]]) -> Folder {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &looking_down([400, 300], interior)));
    folder.write("plane.json", document("plane", plane));
    let lines: String = clicks.iter().map(|[x, y]| format!("{x:?},{y:?}\n")).collect();
    folder.write("clicks.csv", lines);
    let inverse = ["--inverse", "--plane", "plane.json", "clicks.csv", "-o", "world.csv"];
    folder.succeed(&[&["project", "--camera", "camera.json"], &inverse[..]].concat());
    let run = folder.succeed(&["project", "--camera", "camera.json", "world.csv"]);
    for (line, expected) in run.stdout.lines().skip(1).zip(clicks) {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields[6], "ok", "{line}");
        for (field, e) in fields[4..6].iter().zip(expected) {
            assert!((field.parse::<f64>().unwrap() - e).abs() < 1e-10, "{line}");
        }
    }
    folder
}

#[test]
fn a_fisheye_projects_there_and_back_and_to_its_side() {
    // Equidistant: a quarter turn is 100 · π/2 pixels, so (300, 150) is one radian to the right: 10 tan 1 on the ground.
    let fisheye =
        r#""model": "fisheye", "principal_distance": [100, 100], "principal_point": [200, 150]"#;
    let ground = r#""point": [0, 0, 0], "normal": [0, 0, 1]"#;
    let folder = there_and_back(fisheye, ground, &[[300.0, 150.0], [120.0, 40.0], [200.0, 150.0]]);
    let world = folder.text("world.csv");
    let x: f64 = world.lines().nth(1).unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!((x - 15.574077246549023).abs() < 1e-12, "{world}");
    // A wall to the east, seen above the horizon too: (390, 150) is 1.9 radians from straight down.
    let lens = format!(r#"{fisheye}, "k": [0.0312, -0.0147, 0.0063, -0.0011]"#);
    let wall = r#""point": [5, 0, 0], "normal": [-1, 0, 0]"#;
    let folder = there_and_back(&lens, wall, &[[390.0, 150.0], [300.0, 200.0], [350.0, 60.0]]);
    let world = folder.text("world.csv");
    let z: f64 = world.lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
    assert!(z > 10.0, "{world}");
    // Straight down of the camera there is a wall of which nothing is seen: it runs along the line of sight.
    folder.write("clicks.csv", "200,150\n");
    let inverse = ["--inverse", "--plane", "plane.json", "clicks.csv"];
    let run = folder.succeed(&[&["project", "--camera", "camera.json"], &inverse[..]].concat());
    assert!(run.stdout.contains("the line of sight does not meet the surface"), "{}", run.stdout);
}

/// pycolmap 4.2.1, `img_from_cam` of (0.31, −0.22, 1), as in the library's `from_colmap`.
#[test]
fn a_line_of_colmap_projects_as_in_colmap() {
    let colmap = r#""model": "colmap", "colmap_model": "SIMPLE_RADIAL", "parameters": [250, 200, 150, -0.11]"#;
    let ground = r#""point": [0, 0, 0], "normal": [0, 0, 1]"#;
    let folder = there_and_back(colmap, ground, &[[10.0, 20.0], [390.5, 280.0], [200.0, 150.0]]);
    let colmap = r#""model": "colmap", "colmap_model": "SIMPLE_RADIAL", "parameters": [611.3, 513.4, 391.9, -0.11]"#;
    folder.write("camera.json", document("camera", &looking_down([1000, 800], colmap)));
    folder.write("points.csv", "3.1,2.2,0\n");
    let run = folder.succeed(&["project", "--camera", "camera.json", "points.csv"]);
    let fields: Vec<_> = run.stdout.lines().nth(1).unwrap().split(',').collect();
    for (field, e) in fields[4..6].iter().zip([699.8908498149999, 259.55165496999996]) {
        assert!((field.parse::<f64>().unwrap() - e).abs() < 1e-9, "{fields:?}");
    }
    folder.write(
        "camera.json",
        document("camera", &looking_down([9, 9], &colmap.replace(", -0.11", ""))),
    );
    let run = folder.run(&["project", "--camera", "camera.json", "points.csv"]);
    let told = "camera.json: interior.parameters: has 3 entries, 4 are needed";
    assert!(run.code == 1 && run.stderr.contains(told), "{}", run.stderr);
}

/// 100 up, a line each unit along y, c = 100: by hand.
#[test]
fn a_scanner_projects_and_says_what_no_time_sees() {
    let folder = Folder::new();
    let scanner = document(
        "scanner",
        r#""width": 200, "height": 50,
        "scan": { "kind": "pushbroom", "row": 0.5, "per_line": 1, "margin": 10 },
        "interior": { "model": "pinhole", "principal_distance": [100, 100], "principal_point": [100, 0.5] },
        "trajectory": {
            "exterior": { "projection_center": [0, 0, 100], "rotation_matrix": [[-1, 0, 0], [0, 1, 0], [0, 0, -1]] },
            "position_polynomial": [[0, 0, 0], [0, 1, 0]]
        }"#,
    );
    folder.write("scanner.json", scanner).write("ground.json", ground(""));
    folder.write("points.csv", "a,-5,20,0\nb,10,3,50\nc,0,57,0\nd,0,70,0\ne,0,20,120\n");
    let run = folder.succeed(&["project", "--camera", "scanner.json", "points.csv"]);
    let expected = [
        (Some([105.0, 20.0]), "ok"),
        (Some([80.0, 3.0]), "ok"),
        (Some([100.0, 57.0]), "outside the picture"),
        (None, "outside the scan: time 70 is not between -10 and 60"),
        (None, "the point lies behind the camera: depth -20"),
    ];
    let rows: Vec<_> = run.stdout.lines().skip(1).collect();
    assert_eq!(rows.len(), expected.len());
    for (row, (image, status)) in rows.iter().zip(expected) {
        let fields: Vec<_> = row.split(',').collect();
        assert_eq!(fields[6], status);
        for (axis, field) in fields[4..6].iter().enumerate() {
            let found: Option<f64> = field.parse().ok();
            match (found, image) {
                (Some(found), Some(image)) => assert!((found - image[axis]).abs() < 1e-12, "{row}"),
                (found, image) => assert_eq!(found.is_some(), image.is_some(), "{row}"),
            }
        }
    }
    folder.write("clicks.csv", "105 20\n80 3\n80 61\n");
    let inverse = ["--inverse", "--plane", "ground.json", "clicks.csv"];
    let run = folder.succeed(&[&["project", "--camera", "scanner.json"], &inverse[..]].concat());
    let lines: Vec<_> = run.stdout.lines().skip(1).collect();
    let expected = [[-5.0, 20.0, 0.0], [20.0, 3.0, 0.0]];
    for (line, world) in lines.iter().zip(expected) {
        for (field, w) in line.split(',').skip(1).zip(world) {
            assert!((field.parse::<f64>().unwrap() - w).abs() < 1e-12, "{line}");
        }
    }
    assert_eq!(lines[2], ",,,,80.0,61.0,outside the scan: time 61 is not between -10 and 60");
}

/// One sample for each 10⁻⁵°, 100 m of height move it by 50: by hand.
fn rational() -> String {
    let zeros = ["0"; 20].join(", ");
    let polynomial = |start: &str| format!("[{start}{}]", &zeros[start.matches(',').count() * 3..]);
    document(
        "rpc",
        &format!(
            r#""line_offset": 4999.5, "sample_offset": 4999.5, "latitude_offset_deg": 44, "longitude_offset_deg": 5,
            "height_offset": 500, "line_scale": 5000, "sample_scale": 5000, "latitude_scale_deg": 0.05,
            "longitude_scale_deg": 0.05, "height_scale": 500,
            "line_numerator": {}, "line_denominator": {one}, "sample_numerator": {}, "sample_denominator": {one}"#,
            polynomial("0, 0, -1, "),
            polynomial("0, 1, 0, 0.05, "),
            one = polynomial("1, "),
        ),
    )
}

/// A geoid 40 m above the ellipsoid from 43 to 45° north and 4 to 6° east.
fn geoid() -> Vec<u8> {
    let mut bytes = Vec::new();
    [43.0f64, 4.0, 1.0, 1.0].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    [3i32, 3].iter().for_each(|v| bytes.extend(v.to_be_bytes()));
    (0..9).for_each(|_| bytes.extend(40f32.to_be_bytes()));
    bytes
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').filter_map(|f| f.parse().ok()).collect()
}

#[test]
fn a_rational_camera_projects_places_on_the_earth() {
    let folder = Folder::new();
    folder.write("rpc.json", rational()).write("geoid.gtx", geoid());
    folder.write("places.csv", "id,lat,lon,h\na,44.01,5.02,600\nb,44.2,5,500\n");
    let run = folder.succeed(&["project", "--camera", "rpc.json", "places.csv"]);
    let lines: Vec<_> = run.stdout.lines().collect();
    assert_eq!(lines[0], "id,lon,lat,h,x,y,status");
    let off = |line: &str, expected: [f64; 5]| {
        let found = numbers(line);
        assert_eq!(found.len(), 5, "{line}");
        found.iter().zip(expected).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max)
    };
    assert!(off(lines[1], [5.02, 44.01, 600.0, 7050.0, 4000.0]) < 1e-7, "{}", lines[1]);
    assert!(lines[1].ends_with(",ok"));
    assert!(lines[2].ends_with(",,outside the model's domain: 4 is not below 2"), "{}", lines[2]);

    // 560 m above the geoid are 600 above the ellipsoid.
    folder.write("places.csv", "5.02 44.01 560\n7 44 560\n").write("clicks.csv", "7050 4000\n");
    let above = ["--heights", "geoid", "--geoid", "geoid.gtx"];
    let run =
        folder.succeed(&[&["project", "--camera", "rpc.json", "places.csv"], &above[..]].concat());
    let lines: Vec<_> = run.stdout.lines().collect();
    assert!(off(lines[1], [5.02, 44.01, 560.0, 7050.0, 4000.0]) < 1e-7, "{}", lines[1]);
    assert!(lines[2].contains("longitude is 7, expected a value inside the geoid grid"));

    let inverse = ["project", "--camera", "rpc.json", "--inverse", "clicks.csv", "--height"];
    let run = folder.succeed(&[&inverse[..], &["600"]].concat());
    let line = run.stdout.lines().nth(1).unwrap();
    assert!(off(line, [5.02, 44.01, 600.0, 7050.0, 4000.0]) < 1e-12, "{line}");
    let run = folder.succeed(&[&inverse[..], &["560"], &above[..]].concat());
    let line = run.stdout.lines().nth(1).unwrap();
    assert!(off(line, [5.02, 44.01, 560.0, 7050.0, 4000.0]) < 1e-12, "{line}");
}

#[test]
fn heights_and_planes_each_have_their_cameras() {
    let folder = folder("");
    folder.write("rpc.json", rational()).write("geoid.gtx", geoid());
    folder.write("clicks.csv", "7050 4000\n").write("places.csv", "5 44 600\n");
    folder.write("bad.json", rational().replace("\"line_scale\": 5000", "\"line_scale\": 0"));
    folder.write("bad.txt", "LINE_OFF: 1\n");
    for (arguments, code, told) in [
        (
            &["--camera", "rpc.json", "--inverse", "--plane", "ground.json", "clicks.csv"][..],
            1,
            "rpc.json: an RPC has no place for a plane",
        ),
        (
            &["--camera", "camera.json", "--inverse", "--height", "3", "clicks.csv"],
            1,
            "camera.json: heights are of an RPC",
        ),
        (
            &[
                "--camera",
                "rpc.json",
                "--heights",
                "ellipsoid",
                "--geoid",
                "geoid.gtx",
                "places.csv",
            ],
            1,
            "geoid.gtx: is not used",
        ),
        (&["--camera", "rpc.json", "--heights", "geoid", "places.csv"], 2, "--geoid"),
        (
            &["--camera", "bad.json", "places.csv"],
            1,
            "bad.json: line_scale: is 0, expected a finite number above 0",
        ),
        (&["--camera", "bad.txt", "places.csv"], 1, "bad.txt: has no SAMP_OFF"),
        (&["--camera", "rpc.json", "geoid.gtx"], 1, "geoid.gtx"),
    ] {
        let run = folder.run(&[&["project"], arguments].concat());
        assert!(
            run.code == code && run.stderr.contains(told),
            "{arguments:?} {}: {}",
            run.code,
            run.stderr
        );
    }
}
