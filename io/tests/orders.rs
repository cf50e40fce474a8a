//! The order of parameters in other programs' files, written out by hand after their documentation.

use collinear::geometry::projection::ClipConvention;
use collinear_io::Document;
use collinear_io::camera::{CameraFile, Interior, Lens};
use collinear_io::colmap::Reconstruction;
use collinear_io::gpu::GpuCamera;
use collinear_io::opencv::{self, Form};
use collinear_io::{bundler, metashape, opensfm};

/// A camera of 640 × 480, f = (500, 510), c = (330, 250), at (1, 2, 3).
fn camera(interior: &str) -> CameraFile {
    CameraFile::parse(&format!(
        r#"{{ "collinear": "camera", "version": 1, "width": 640, "height": 480, "interior": {{ {interior} }},
        "exterior": {{ "projection_center": [1, 2, 3], "quaternion_wxyz": [0.5, 0.5, 0.5, 0.5] }} }}"#
    ))
    .unwrap()
}

const F_AND_C: &str = r#""principal_distance": [500, 510], "principal_point": [330, 250]"#;

/// The parameter lists of COLMAP's camera models (src/colmap/sensor/models.h: `params_info`).
#[test]
fn colmaps_parameters_are_in_its_order() {
    for (lens, expected) in [
        (r#""model": "pinhole""#, "PINHOLE 640 480 500 510 330 250"),
        (
            r#""model": "brown", "k": [0.1, 0.2, 0], "p": [0.01, 0.02]"#,
            "OPENCV 640 480 500 510 330 250 0.1 0.2 0.01 0.02",
        ),
        (
            r#""model": "brown", "k": [0.1, 0.2, 0.3], "p": [0.01, 0.02]"#,
            "FULL_OPENCV 640 480 500 510 330 250 0.1 0.2 0.01 0.02 0.3 0 0 0",
        ),
        (
            r#""model": "rational", "k": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "p": [0.01, 0.02]"#,
            "FULL_OPENCV 640 480 500 510 330 250 0.1 0.2 0.01 0.02 0.3 0.4 0.5 0.6",
        ),
        (
            r#""model": "metashape", "k": [0.1, 0.2, 0, 0], "p": [0.01, 0.02, 0, 0]"#,
            "OPENCV 640 480 500 510 330 250 0.1 0.2 0.02 0.01",
        ),
        (
            r#""model": "fisheye", "k": [0.1, 0.2, 0.3, 0.4]"#,
            "OPENCV_FISHEYE 640 480 500 510 330 250 0.1 0.2 0.3 0.4",
        ),
        (
            r#""model": "thin_prism_fisheye", "k": [0.1, 0.2, 0.3, 0.4], "p": [0.01, 0.02], "s": [0.001, 0.002]"#,
            "THIN_PRISM_FISHEYE 640 480 500 510 330 250 0.1 0.2 0.01 0.02 0.3 0.4 0.001 0.002",
        ),
        (
            r#""model": "fisheye624", "k": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "p": [0.01, 0.02], "s": [0.001, 0.002, 0.003, 0.004]"#,
            "RAD_TAN_THIN_PRISM_FISHEYE 640 480 500 510 330 250 0.1 0.2 0.3 0.4 0.5 0.6 0.01 0.02 0.001 0.002 0.003 0.004",
        ),
        (r#""model": "field_of_view", "omega": 0.9"#, "FOV 640 480 500 510 330 250 0.9"),
        (r#""model": "division", "lambda": -0.2"#, "DIVISION 640 480 500 510 330 250 -0.2"),
        (
            r#""model": "enhanced_unified", "alpha": 0.6, "beta": 1.1"#,
            "EUCM 640 480 500 510 330 250 0.6 1.1",
        ),
    ] {
        let photographs = [("a".to_owned(), camera(&format!("{lens}, {F_AND_C}")))];
        let model = Reconstruction::from_photographs(&photographs).unwrap();
        let folder = tempfile::tempdir().unwrap();
        model.write(folder.path(), collinear_io::colmap::Encoding::Text).unwrap();
        let text = std::fs::read_to_string(folder.path().join("cameras.txt")).unwrap();
        let line = text.lines().find(|l| !l.starts_with('#')).unwrap();
        assert_eq!(line.split_once(' ').unwrap().1, expected, "{lens}");
    }
    let photographs = [("a".to_owned(), camera(r#""model": "equirectangular""#))];
    let model = Reconstruction::from_photographs(&photographs).unwrap();
    let folder = tempfile::tempdir().unwrap();
    model.write(folder.path(), collinear_io::colmap::Encoding::Text).unwrap();
    let text = std::fs::read_to_string(folder.path().join("cameras.txt")).unwrap();
    assert!(text.contains("EQUIRECTANGULAR 640 480 640 480\n"), "{text}");
}

/// From COLMAP's lists to other programs' files.
#[test]
fn colmaps_parameters_are_taken_in_its_order() {
    let colmap = |model: &str, parameters: &str| {
        let interior = format!(
            r#""model": "colmap", "colmap_model": "{model}", "parameters": [{parameters}]"#
        );
        [("a".to_owned(), camera(&interior))]
    };
    let radial = bundler::Bundle::from_photographs(&colmap("RADIAL", "500, 320, 240, 0.1, 0.2"));
    assert_eq!(radial.unwrap().cameras[0].k, [0.1, 0.2]);
    let tagged = |photographs: &[(String, CameraFile)]| metashape::to_text(photographs).unwrap();
    let has = |text: &str, tags: &[&str]| {
        for tag in tags {
            assert!(text.contains(tag), "{tag} in {text}");
        }
    };
    // Metashape's p1 and p2 have each other's places.
    let text = tagged(&colmap("OPENCV", "500, 510, 330, 250, 0.1, 0.2, 0.01, 0.02"));
    has(
        &text,
        &[
            "<k1>0.1<",
            "<k2>0.2<",
            "<p1>0.02<",
            "<p2>0.01<",
            "<cx>10<",
            "<cy>10<",
            "<f>510<",
            "<b1>-10<",
        ],
    );
    let thin = "500, 510, 330, 250, 0.1, 0.2, 0.01, 0.02, 0.3, 0.4, 0, 0";
    let text = tagged(&colmap("THIN_PRISM_FISHEYE", thin));
    has(&text, &["<k1>0.1<", "<k2>0.2<", "<k3>0.3<", "<k4>0.4<", "<p1>0.02<", "<p2>0.01<"]);
    // A panorama of the picture's own size is a whole one.
    let spherical = |size: &str| {
        let mut panorama = colmap("EQUIRECTANGULAR", size);
        (panorama[0].1.width, panorama[0].1.height) = (1000, 500);
        opensfm::Reconstruction::from_photographs(&panorama)?.to_json()
    };
    has(&spherical("1000, 500").unwrap(), &["\"spherical\""]);
    assert!(spherical("1000, 480").is_err());
}

/// OpenCV's `omnidir`: ξ, and D = (k₁, k₂, p₁, p₂); `calib3d`: D = (k₁ k₂ p₁ p₂ k₃ k₄ k₅ k₆ s₁ s₂ s₃ s₄ τx τy). The camera matrix row after row.
#[test]
fn opencvs_coefficients_are_in_its_order() {
    let numbers = |text: &str, name: &str| -> Vec<f64> {
        let data = text.split(&format!("{name}:")).nth(1).unwrap().split("data: [").nth(1).unwrap();
        let data = data.split(']').next().unwrap();
        data.split(',').map(|n| n.trim().parse().unwrap()).collect()
    };
    let unified = format!(
        r#""model": "unified", "xi": 0.9, "k": [0.1, 0.2, 0], "p": [0.01, 0.02], "skew": 3, {F_AND_C}"#
    );
    let text = opencv::to_text(&camera(&unified), Form::Yaml).unwrap();
    assert_eq!(numbers(&text, "distortion_coefficients"), [0.1, 0.2, 0.01, 0.02]);
    let matrix = [500.0, 3.0, 329.5, 0.0, 510.0, 249.5, 0.0, 0.0, 1.0];
    assert_eq!(numbers(&text, "camera_matrix"), matrix);
    let (_, read) = opencv::parse(&text).unwrap().remove(0);
    let Interior::Lens { lens, skew, principal_distance, principal_point } = read.interior else {
        panic!("{read:?}")
    };
    assert_eq!((skew, principal_distance, principal_point), (3.0, [500.0, 510.0], [330.0, 250.0]));
    assert_eq!(*lens, Lens::Unified { xi: 0.9, k: [0.1, 0.2, 0.0], p: [0.01, 0.02] });
    // A tilt without a thin prism keeps the prism's places.
    let tilted = format!(
        r#""model": "rational", "k": [0.1, 0.2, 0.3, 0, 0, 0], "p": [0.01, 0.02], "tau": [0.03, 0.04], {F_AND_C}"#
    );
    let text = opencv::to_text(&camera(&tilted), Form::Yaml).unwrap();
    let all = [0.1, 0.2, 0.01, 0.02, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.03, 0.04];
    assert_eq!(numbers(&text, "distortion_coefficients"), all);
}

#[test]
fn matrices_come_with_the_projection_centre() {
    let pinhole = camera(&format!(r#""model": "pinhole", {F_AND_C}"#));
    let gpu = GpuCamera::new(&pinhole, ClipConvention::Wgpu, 0.1, None).unwrap();
    assert_eq!(gpu.projection_center, [1.0, 2.0, 3.0]);
}
