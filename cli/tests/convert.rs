//! `collinear convert`.

use collinear_io::Document;
use collinear_io::camera::CameraFile;
use serde_json::Value;

use crate::support::{Folder, document, label, vertical};

const COLMAP: [(&str, &str); 3] = [
    ("sparse/cameras.txt", "1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n"),
    (
        "sparse/images.txt",
        "1 1 0 0 0 0 0 0 1 left/a.jpg\n\n2 0.7071067811865476 0 0 0.7071067811865476 1 2 3 1 right/a.jpg\n\n",
    ),
    ("sparse/points3D.txt", ""),
];

fn folder() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sparse")).unwrap();
    for (name, text) in COLMAP {
        folder.write(name, text);
    }
    folder
}

#[test]
fn many_photographs_become_files_and_one_becomes_one() {
    let folder = folder();
    let run = folder.succeed(&["convert", "sparse", "--to", "camera", "-o", "cameras"]);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", "collinear: 2 files in cameras\n"));
    let camera = CameraFile::parse(&folder.text("cameras/right_a.jpg.json")).unwrap();
    // A quarter turn about z: C = −Rᵀ (1, 2, 3) = (−2, 1, −3).
    for (found, expected) in camera.exterior.projection_center.iter().zip([-2.0, 1.0, -3.0]) {
        assert!((found - expected).abs() < 1e-15, "{camera:?}");
    }
    let one = ["convert", "sparse", "--to", "opencv", "--photograph", "left/a.jpg", "-o", "a.yml"];
    let run = folder.succeed(&one);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let text = folder.text("a.yml");
    assert!(
        text.contains("data: [ 500.0, 0.0, 319.5, 0.0, 500.0, 239.5, 0.0, 0.0, 1.0 ]"),
        "{text}"
    );
    assert!(text.contains("data: [ -0.1, 0.0, 0.0, 0.0, 0.0 ]"), "{text}");
    // And back into COLMAP's files, which need no points.
    folder.succeed(&["convert", "a.yml", "--to", "colmap-binary", "-o", "model"]);
    folder.succeed(&["convert", "model", "--to", "colmap", "-o", "again"]);
    assert!(
        folder.text("again/cameras.txt").ends_with("1 OPENCV 640 480 500 500 320 240 -0.1 0 0 0\n")
    );
}

#[test]
fn a_camera_becomes_matrices() {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &vertical(400, 300, "")));
    folder.succeed(&[
        "convert",
        "camera.json",
        "--to",
        "vulkan",
        "--near",
        "2",
        "--far",
        "10",
        "-o",
        "m.json",
    ]);
    let matrices: Value = serde_json::from_str(&folder.text("m.json")).unwrap();
    // f = 100 on 400 × 300; far/(far − near) = 1.25 of z = −1 in the eye.
    let p = &matrices["projection"];
    for (i, expected) in [(0, 0.5), (5, -2.0 / 3.0), (10, -1.25), (11, -1.0), (14, -2.5)] {
        assert!((p[i].as_f64().unwrap() - expected).abs() < 1e-15, "{i}: {p}");
    }
    let run = folder.run(&[
        "convert",
        "camera.json",
        "--to",
        "wgpu",
        "--near",
        "2",
        "--far",
        "1",
        "-o",
        "n.json",
    ]);
    assert_eq!(run.code, 2);
    folder.write("lens.json", document("camera", &vertical(400, 300, r#", "k": [-0.1, 0, 0]"#)));
    let run = folder.run(&["convert", "lens.json", "--to", "wgpu", "-o", "n.json"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stderr.contains("interior.model: is `brown`: a matrix has no lens"),
        "{}",
        run.stderr
    );
}

#[test]
fn what_cannot_be_converted_is_refused_and_nothing_is_written() {
    let folder = folder();
    let says = |arguments: &[&str], code: i32, expected: &str| {
        let run = folder.run(arguments);
        assert_eq!(run.code, code, "{}", run.stderr);
        assert!(run.stderr.contains(expected), "{}", run.stderr);
    };
    says(&["convert", "sparse", "--to", "camera", "-o", "sparse"], 2, "name another output");
    let before = folder.text("sparse/images.txt");
    for to in ["bundler", "camera"] {
        let over = ["convert", "sparse", "--to", to, "-o", "sparse/images.txt"];
        says(&over, 2, "sparse/images.txt is both the cameras and the output (-o)");
    }
    #[cfg(unix)]
    {
        std::fs::create_dir(folder.path("model")).unwrap();
        let link = folder.path("model/images.txt");
        std::os::unix::fs::symlink(folder.path("sparse/images.txt"), link).unwrap();
        says(&["convert", "sparse", "--to", "colmap", "-o", "model"], 2, "are the same file");
    }
    assert_eq!(folder.text("sparse/images.txt"), before);
    let other = ["convert", "sparse", "--to", "camera", "--photograph", "c.jpg", "-o", "out"];
    says(&other, 1, "sparse: has no photograph `c.jpg`: left/a.jpg, right/a.jpg");
    says(&["convert", "nowhere", "--to", "camera", "-o", "out"], 1, "nowhere: cannot be read");
    folder.write("points.csv", "X,Y,Z\n1,2,3\n");
    says(
        &["convert", "points.csv", "--to", "camera", "-o", "out"],
        1,
        "points.csv: holds no cameras",
    );
    folder.write("sparse/images.txt", "1 1 0 0 0 0 0 0 1 a/b.jpg\n\n2 1 0 0 0 0 0 0 1 a_b.jpg\n\n");
    says(
        &["convert", "sparse", "--to", "camera", "-o", "out"],
        1,
        "two photographs would be written as",
    );
    folder.write("sparse/images.txt", "1 1 0 0 0 0 0 0 1 ../../up.jpg\n\n2 1 0 0 0 0 0 0 1 b\n\n");
    folder.succeed(&["convert", "sparse", "--to", "opencv-json", "-o", "inside"]);
    assert!(folder.path("inside/_.._up.jpg.json").is_file());
    assert!(!folder.path("out").exists());
}

#[test]
fn bundlers_file_needs_the_size_of_the_pictures() {
    let folder = folder();
    folder.succeed(&["convert", "sparse", "--to", "bundler", "-o", "bundle.out"]);
    let text = folder.text("bundle.out");
    // R and t with y and z turned round.
    assert!(
        text.starts_with("# Bundle file v0.3\n2 0\n500 -0.1 0\n1 0 0\n0 -1 0\n0 0 -1\n"),
        "{text}"
    );
    let run = folder.run(&["convert", "bundle.out", "--to", "camera", "-o", "cameras"]);
    assert_eq!(run.code, 1);
    assert!(
        run.stderr.contains("bundle.out: does not say how large its pictures are"),
        "{}",
        run.stderr
    );
    // The names that photographs get here are for COLMAP's text, too.
    let back = ["convert", "bundle.out", "--size", "640x480", "--to", "colmap", "-o", "model"];
    folder.succeed(&back);
    folder.succeed(&[
        "convert",
        "model",
        "--photograph",
        "camera_1",
        "--to",
        "camera",
        "-o",
        "one.json",
    ]);
    let camera = CameraFile::parse(&folder.text("one.json")).unwrap();
    for (found, expected) in camera.exterior.projection_center.iter().zip([-2.0, 1.0, -3.0]) {
        assert!((found - expected).abs() < 1e-15, "{camera:?}");
    }
}

#[test]
fn photographs_become_a_reconstruction_of_opensfms() {
    let folder = folder();
    folder.succeed(&["convert", "sparse", "--to", "opensfm", "-o", "reconstruction.json"]);
    let all: Value = serde_json::from_str(&folder.text("reconstruction.json")).unwrap();
    // f = 500 of the longer side, 640; COLMAP's SIMPLE_RADIAL has its principal point in the middle here.
    let camera = &all[0]["cameras"]["camera 1"];
    assert_eq!(
        *camera,
        serde_json::json!({ "projection_type": "perspective", "width": 640, "height": 480, "focal": 0.78125, "k1": -0.1,
            "k2": 0.0 })
    );
    let shot = &all[0]["shots"]["right/a.jpg"];
    assert_eq!(shot["translation"], serde_json::json!([1.0, 2.0, 3.0]));
    let turn = shot["rotation"][2].as_f64().unwrap();
    assert!((turn - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{shot}");
    folder.succeed(&["convert", "reconstruction.json", "--to", "colmap", "-o", "again"]);
    let images = folder.text("again/images.txt");
    assert!(images.contains(" right/a.jpg"), "{images}");
}

#[test]
fn photographs_become_metashapes_and_opencvs_xml() {
    let folder = folder();
    folder.succeed(&["convert", "sparse", "--to", "metashape", "-o", "cameras.xml"]);
    let text = folder.text("cameras.xml");
    assert!(text.contains("<f>500</f><cx>0</cx><cy>0</cy><k1>-0.1</k1>"), "{text}");
    // C = −Rᵀ t, as above.
    assert!(text.contains("<transform>0 1 0 -2 -1 0 0 1 0 0 1 -3 0 0 0 1</transform>"), "{text}");
    let one = "right/a.jpg";
    folder.succeed(&[
        "convert",
        "cameras.xml",
        "--photograph",
        one,
        "--to",
        "opencv-xml",
        "-o",
        "a.xml",
    ]);
    let text = folder.text("a.xml");
    assert!(text.contains("500.0 0.0 319.5 0.0 500.0 239.5 0.0 0.0 1.0</data>"), "{text}");
    folder.succeed(&["convert", "a.xml", "--to", "camera", "-o", "a.json"]);
    let camera = CameraFile::parse(&folder.text("a.json")).unwrap();
    for (found, expected) in camera.exterior.projection_center.iter().zip([-2.0, 1.0, -3.0]) {
        assert!((found - expected).abs() < 1e-14, "{camera:?}");
    }
}

#[test]
fn a_rational_camera_goes_from_form_to_form() {
    let folder = folder();
    let zeros = |first: &str| format!("[{first}{}]", ", 0".repeat(20 - first.split(',').count()));
    let rpc = document(
        "rpc",
        &format!(
            r#""line_offset": 4999.5, "sample_offset": 4999.5, "latitude_offset_deg": 44, "longitude_offset_deg": 5,
            "height_offset": 500, "line_scale": 5000, "sample_scale": 5000, "latitude_scale_deg": 0.05,
            "longitude_scale_deg": 0.05, "height_scale": 500, "line_numerator": {}, "line_denominator": {one},
            "sample_numerator": {}, "sample_denominator": {one}"#,
            zeros("0, 0, -1"),
            zeros("0, 1, 0, 0.05"),
            one = zeros("1"),
        ),
    );
    folder.write("rpc.json", rpc);
    folder.succeed(&["convert", "rpc.json", "--to", "rpb", "-o", "a.RPB"]);
    folder.succeed(&["convert", "a.RPB", "--to", "rpc-txt", "-o", "a_RPC.TXT"]);
    folder.succeed(&["convert", "a_RPC.TXT", "--to", "rpc", "-o", "again.json"]);
    let read = |name: &str| serde_json::from_str::<Value>(&folder.text(name)).unwrap();
    let (before, after) = (read("rpc.json"), read("again.json"));
    for (field, value) in before.as_object().unwrap() {
        let numbers =
            |v: &Value| v.as_array().map(|l| l.iter().map(Value::as_f64).collect::<Vec<_>>());
        let same =
            numbers(value) == numbers(&after[field]) && value.as_f64() == after[field].as_f64();
        assert!(same, "{field}: {value} {}", after[field]);
    }
    let says = |arguments: &[&str], expected: &str| {
        let run = folder.run(arguments);
        assert!(run.code == 1 && run.stderr.contains(expected), "{}", run.stderr);
    };
    says(
        &["convert", "rpc.json", "--to", "colmap", "-o", "out"],
        "is a rational polynomial camera",
    );
    folder.write("camera.json", document("camera", &vertical(400, 300, "")));
    says(&["convert", "camera.json", "--to", "rpb", "-o", "out"], "holds no rational polynomial");
}

/// A table, the camera that took it, and what its places leave out.
#[test]
fn orientations_take_their_camera_from_another_file() {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &vertical(400, 300, "")));
    folder.write("table.txt", "a.jpg 1 2 30 0 0 100\nb.jpg 5 6 30 0 0 0\n");
    folder.write("offset.xyz", "1000 2000 0\n");
    let read = |name: &str| CameraFile::parse(&folder.text(name)).unwrap();
    let table = ["convert", "table.txt", "--interior", "camera.json", "--angles", "gon"];
    let with = |more: &[&'static str]| [&table[..], more].concat();
    folder.succeed(&with(&["--offset", "offset.xyz", "--to", "camera", "-o", "out"]));
    let camera = read("out/a.jpg.json");
    assert_eq!((camera.width, camera.height), (400, 300));
    assert_eq!(camera.exterior.projection_center, [1001.0, 2002.0, 30.0]);
    // κ = 100 gon: what lies to the north is to the right. f = 100 at depth 30.
    let image = camera.camera().unwrap().sensor().project(&[1001.0, 2005.0, 0.0].into()).unwrap();
    assert!((image.x - 210.0).abs() < 1e-9 && (image.y - 150.0).abs() < 1e-9, "{image}");
    let one = ["--photograph", "a.jpg", "--offset", "-1,-2,0", "--to", "patb", "-o", "a.ori"];
    folder.succeed(&with(&one));
    let text = folder.text("a.ori");
    assert!(text.contains("         0.00000         0.00000        30.00000\n"), "{text}");
    folder.succeed(&[
        "convert",
        "a.ori",
        "--interior",
        "camera.json",
        "--to",
        "opk",
        "-o",
        "a.txt",
    ]);
    let text = folder.text("a.txt");
    assert!(text.starts_with("imageName X Y Z Omega Phi Kappa\na.jpg 0 0 30 "), "{text}");
    folder.succeed(&with(&["--to", "pix4d", "-o", "pix4d.txt"]));
    folder.succeed(&["convert", "pix4d.txt", "--to", "colmap", "-o", "sparse"]);
    assert!(folder.text("sparse/cameras.txt").ends_with(" PINHOLE 400 300 100 100 200 150\n"));
    let says = |arguments: &[&str], code: i32, expected: &str| {
        let run = folder.run(arguments);
        assert!(run.code == code && run.stderr.contains(expected), "{}", run.stderr);
    };
    let bare = ["convert", "table.txt", "--interior", "camera.json", "--to", "opk", "-o", "x"];
    says(&bare, 1, "table.txt: does not say the unit of its angles");
    says(&with(&["--offset", "1,2", "--to", "opk", "-o", "x"]), 2, "--offset 1,2: no such file");
    let own = ["convert", "camera.json", "--interior", "camera.json", "--to", "opk", "-o", "x"];
    says(&own, 1, "camera.json: has interior orientations of its own");
    says(&with(&["--to", "opk", "-o", "camera.json"]), 2, "camera.json");
    let several = ["convert", "a.txt", "--interior", "sparse", "--to", "opk", "-o", "b.txt"];
    folder.succeed(&several);
}

#[test]
fn a_camera_goes_to_renderers() {
    let folder = Folder::new();
    folder.write("camera.json", document("camera", &vertical(400, 300, "")));
    folder.succeed(&["convert", "camera.json", "--to", "gltf", "--far", "9", "-o", "c.gltf"]);
    let scene: Value = serde_json::from_str(&folder.text("c.gltf")).unwrap();
    let perspective = &scene["cameras"][0]["perspective"];
    assert_eq!((&perspective["znear"], &perspective["zfar"]), (&0.1.into(), &9.0.into()));
    // 2 atan(150/100).
    assert!((perspective["yfov"].as_f64().unwrap() - 1.965_587_446_494_658).abs() < 1e-14);
    folder.succeed(&["convert", "c.gltf", "--to", "blender", "-o", "c.py"]);
    let script = folder.text("c.py");
    // 100 · 36/400.
    assert!(script.contains(r#"\"lens_mm\":9"#) && script.contains("import bpy"), "{script}");
    folder.succeed(&["convert", "c.gltf", "--to", "nerf", "-o", "transforms.json"]);
    folder.succeed(&["convert", "transforms.json", "--to", "colmap", "-o", "sparse"]);
    assert!(folder.text("sparse/cameras.txt").contains(" PINHOLE 400 300 "));
    let run = folder.run(&["convert", "c.gltf", "--to", "gltf", "--far", "0.05", "-o", "d.gltf"]);
    assert!(run.code == 2 && run.stderr.contains("--far is not beyond --near"), "{}", run.stderr);
}

/// A camera 5 km over 44° N, 5° E that looks down, north up, c = 8000: rational polynomials fitted to it take places to its pixels. The
/// places of two points are those of pyproj 3.7.2 (PROJ 9.5.1, topocentric inverse and cart inverse).
#[test]
fn an_rpc_is_fitted_to_a_camera_and_stands_in_its_world() {
    let folder = Folder::new();
    let camera = r#""width": 4000, "height": 3000,
        "interior": { "model": "pinhole", "principal_distance": [8000, 8000], "principal_point": [2000, 1500] },
        "exterior": { "projection_center": [0, 0, 5000], "rotation_matrix": [[1, 0, 0], [0, -1, 0], [0, 0, -1]] }"#;
    folder.write("camera.json", document("camera", camera));
    let command = [
        "convert",
        "camera.json",
        "--to",
        "rpc",
        "--world",
        "44,5,0",
        "--between",
        "0,800",
        "-o",
        "rpc.json",
    ];
    let run = folder.succeed(&command);
    assert!(run.stderr.contains("rpc.json: off at the 1575 nodes "), "{}", run.stderr);
    let by_hand = |x: f64, y: f64, z: f64| {
        let scale = 8000.0 / (5000.0 - z);
        [2000.0 + scale * x, 1500.0 - scale * y]
    };
    let pixels = |csv: &str| -> Vec<[f64; 2]> {
        csv.lines()
            .skip(1)
            .map(|line| {
                let cells: Vec<&str> = line.split(',').collect();
                assert_eq!(cells[6], "ok", "{line}");
                [cells[4].parse().unwrap(), cells[5].parse().unwrap()]
            })
            .collect()
    };
    let expected = [by_hand(300.0, -200.0, 450.0), by_hand(-900.0, 650.0, 100.0)];
    let near = |found: &[[f64; 2]], tolerance: f64| {
        for (f, e) in found.iter().zip(expected) {
            assert!((f[0] - e[0]).hypot(f[1] - e[1]) < tolerance, "{f:?} {e:?}");
        }
        assert_eq!(found.len(), 2);
    };
    // As places, and as points of the world.
    folder.write(
        "places.csv",
        "lon,lat,h\n5.00373998302984,43.99820008405269,450.0101847946644\n4.9887779945500315,44.005849294469506,100.09657670743763\n",
    );
    folder.write("world.csv", "X,Y,Z\n300,-200,450\n-900,650,100\n");
    let places = ["project", "--camera", "rpc.json", "--heights", "ellipsoid", "places.csv"];
    near(&pixels(&folder.succeed(&places).stdout), 1e-6);
    near(&pixels(&folder.succeed(&["project", "--camera", "rpc.json", "world.csv"]).stdout), 1e-6);
    // Back to a level of that world.
    folder.write("level.json", document("plane", r#""point": [0, 0, 450], "normal": [0, 0, 1]"#));
    folder.write("clicks.csv", format!("x,y\n{:?},{:?}\n", expected[0][0], expected[0][1]));
    let run = folder.succeed(&[
        "project",
        "--camera",
        "rpc.json",
        "--inverse",
        "--plane",
        "level.json",
        "clicks.csv",
    ]);
    let line = run.stdout.lines().nth(1).unwrap();
    let cells: Vec<f64> = line.split(',').skip(1).take(3).map(|c| c.parse().unwrap()).collect();
    for (found, expected) in cells.iter().zip([300.0, -200.0, 450.0]) {
        assert!((found - expected).abs() < 1e-6, "{line}");
    }
    // A picture of it is rectified as one of the camera is.
    folder.draw("photo.png", [4000, 3000], |x, y| label(x / 100, y / 100));
    folder.write(
        "square.json",
        document(
            "plane",
            r#""point": [0, 0, 450], "normal": [0, 0, 1], "rectangle": { "left": -1000, "bottom": -700, "right": 1000, "top": 700 }"#,
        ),
    );
    let rectified = |camera: &str, out: &str| {
        folder.succeed(&[
            "rectify",
            "photo.png",
            "--camera",
            camera,
            "--plane",
            "square.json",
            "--size",
            "40x28",
            "--filter",
            "nearest",
            "-o",
            out,
        ]);
        folder.picture(out)
    };
    assert_eq!(rectified("rpc.json", "a.png"), rectified("camera.json", "b.png"));

    // A vendor's file gets its size and its world.
    folder.succeed(&["convert", "rpc.json", "--to", "rpb", "-o", "plain.RPB"]);
    let run = folder.run(&[
        "rectify",
        "photo.png",
        "--camera",
        "plain.RPB",
        "--plane",
        "square.json",
        "--size",
        "40x28",
        "-o",
        "c.png",
    ]);
    assert_eq!(run.code, 1);
    folder.succeed(&[
        "convert",
        "plain.RPB",
        "--to",
        "rpc",
        "--world",
        "44,5,0",
        "--size",
        "4000x3000",
        "-o",
        "placed.json",
    ]);
    assert_eq!(rectified("placed.json", "c.png"), rectified("camera.json", "b.png"));
    folder.succeed(&[
        "convert",
        "plain.RPB",
        "--to",
        "rpc",
        "--world",
        "geocentric",
        "-o",
        "half.json",
    ]);
    for (arguments, code, told) in [
        (
            &[
                "rectify",
                "photo.png",
                "--camera",
                "half.json",
                "--plane",
                "square.json",
                "--size",
                "40x28",
                "-o",
                "d.png",
            ][..],
            1,
            "half.json: width: is not given",
        ),
        (
            &["convert", "camera.json", "--to", "rpb", "-o", "d.RPB"],
            1,
            "camera.json: holds no rational polynomial camera: to fit one",
        ),
        (
            &[
                "convert",
                "camera.json",
                "--to",
                "rpc",
                "--world",
                "91,5,0",
                "--between",
                "0,800",
                "-o",
                "d.json",
            ],
            2,
            "--world",
        ),
        (
            &[
                "convert",
                "camera.json",
                "--to",
                "rpc",
                "--world",
                "44,5,0",
                "--between",
                "800,0",
                "-o",
                "d.json",
            ],
            2,
            "--between",
        ),
        (
            &[
                "convert",
                "camera.json",
                "--to",
                "rpc",
                "--world",
                "44,5,0",
                "--between",
                "4990,5010",
                "-o",
                "d.json",
            ],
            1,
            "camera.json: ",
        ),
    ] {
        let run = folder.run(arguments);
        assert!(
            run.code == code && run.stderr.contains(told),
            "{arguments:?} {}: {}",
            run.code,
            run.stderr
        );
    }
}
