//! Tables of exterior orientations and PATB's.

use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::orientation::{AngleUnit, Orientation, parse, parse_patb, to_patb, to_table};
use collinear_io::photographs::{self, Given};
use proptest::prelude::*;

/// pyopf's `project_point` (`examples/compute_reprojection_error.py` in Pix4D/pyopf), run with numpy by
/// `tests/oracles/orientation.py`: ω, φ, κ = 11°, −23°, 147°, C = (1000, 2000, 300), f = 1200, c = (650, 470).
#[derive(serde::Deserialize)]
struct Expected {
    /// World points and their pixels.
    seen: Vec<([f64; 3], [f64; 2])>,
    /// The rows of Rx(ω) Ry(φ) Rz(κ).
    matrix: [f64; 9],
}

fn expected() -> Expected {
    serde_json::from_str(include_str!("oracles/orientation.json")).unwrap()
}

const DEGREES: [f64; 3] = [11.0, -23.0, 147.0];

fn camera() -> CameraFile {
    CameraFile::parse(
        r#"{ "collinear": "camera", "version": 1, "width": 1280, "height": 960,
        "interior": { "model": "pinhole", "principal_distance": [1200, 1200], "principal_point": [650, 470] },
        "exterior": { "projection_center": [7, 7, 7], "quaternion_wxyz": [0, 1, 0, 0] } }"#,
    )
    .unwrap()
}

fn given(unit: Option<AngleUnit>) -> Given {
    Given { interior: Some(camera()), angle_unit: unit, ..Given::default() }
}

fn sees(text: &str, unit: Option<AngleUnit>, name: &str) {
    let photographs = photographs::parse_with(text, &given(unit)).unwrap();
    let (found, camera) = photographs.last().unwrap();
    assert_eq!(found, name, "{text}");
    for (world, image) in expected().seen {
        let found = camera.camera().unwrap().sensor().project(&Point3::from(world)).unwrap();
        assert!((found - Point2::from(image)).norm() < 1e-8, "{text}: {found} {image:?}");
    }
}

#[test]
fn tables_of_every_form_say_the_same_camera() {
    let [o, p, k] = DEGREES;
    let gon = DEGREES.map(|a| a / 0.9);
    let [ro, rp, rk] = DEGREES.map(|a| a * std::f64::consts::PI / 180.0);
    let deg = Some(AngleUnit::Degrees);
    sees(&format!("1.jpg 1000 2000 300 {o} {p} {k}\n"), deg, "1.jpg");
    sees(&format!("# by hand\n\n7 1.jpg 1000 2000 300 {o} {p} {k}\r\n"), deg, "1.jpg");
    sees(
        &format!("1.jpg\t1000\t2000\t300\t{}\t{}\t{}", gon[0], gon[1], gon[2]),
        Some(AngleUnit::Gon),
        "1.jpg",
    );
    sees(&format!("1.jpg, 1000, 2000, 300, {ro}, {rp}, {rk}"), Some(AngleUnit::Radians), "1.jpg");
    sees(
        &format!("imageName X Y Z Omega Phi Kappa\n1.jpg 1000 2000 300 {o} {p} {k}\n"),
        None,
        "1.jpg",
    );
    // Metashape: a header with commas behind a mark, tabs between the fields, the matrix after the angles.
    sees(
        &format!(
            "# CoordinateSystem: LOCAL_CS[]\n#PhotoID, X, Y, Z, Omega, Phi, Kappa, r11, r12\n1.jpg\t1000\t2000\t300\t{o}\t{p}\t{k}\t0\t0\n"
        ),
        deg,
        "1.jpg",
    );
    sees(
        &format!(
            "kappa (rad);phi (rad);omega (rad);sigma;Northing;Easting;H;Label\n{rk};{rp};{ro};9;2000;1000;300;\"front; gate\"\n"
        ),
        None,
        "front; gate",
    );
    sees(&format!("Id X0 Y0 Z0 ω [deg] φ [deg] κ [deg]\n5 1000 2000 300 {o} {p} {k}\n"), None, "5");
}

/// Fields of PATB's own columns.
fn patb() -> String {
    let [a, b, c, d, e, f, g, h, i] = expected().matrix;
    format!(
        "{:>16}{:16}{:16.5}{:16.5}{:16.5}\n{a:16.12}{b:16.12}{c:16.12}{d:16.12}{e:16.12}\n{f:16.12}{g:16.12}{h:16.12}{i:16.12}\n",
        "1024", "", 1000.0, 2000.0, 300.0
    )
}

#[test]
fn patbs_matrix_turns_the_photograph_into_the_world() {
    let text = patb();
    sees(&text, None, "1024");
    sees(&format!("{text}{text}            -99\nand more"), None, "1024");
    let [a, b, c, d, e, f, g, h, i] = expected().matrix;
    sees(&format!("7 1000 2000 300\n{a} {b} {c}\n{d} {e} {f}\n{g} {h} {i}\n"), None, "7");
    // Written in the same columns, digit after digit.
    let mut photographs = photographs::parse_with(&text, &given(None)).unwrap();
    assert_eq!(to_patb(&photographs).unwrap(), text);
    photographs[0].0 = "DSC_0157_and_more".into();
    let error = to_patb(&photographs).unwrap_err().to_string();
    assert!(error.contains("name: is `DSC_0157_and_more`: PATB's names have 1 to 16"), "{error}");
    photographs[0].0 = "1".into();
    photographs[0].1.exterior.projection_center[1] = -1e9;
    let error = to_patb(&photographs).unwrap_err().to_string();
    assert!(error.contains("1.projection_center: is -1e9, expected a number below 1e9"), "{error}");
}

#[test]
fn a_written_table_says_its_unit() {
    let photographs = photographs::parse_with(&patb(), &given(None)).unwrap();
    for (unit, header) in [
        (AngleUnit::Degrees, "imageName X Y Z Omega Phi Kappa"),
        (AngleUnit::Gon, "imageName X Y Z Omega_gon Phi_gon Kappa_gon"),
        (AngleUnit::Radians, "imageName X Y Z Omega_rad Phi_rad Kappa_rad"),
    ] {
        let text = to_table(&photographs, unit).unwrap();
        let (first, row) = text.split_once('\n').unwrap();
        assert_eq!(first, header);
        let per_degree = match unit {
            AngleUnit::Degrees => 1.0,
            AngleUnit::Gon => 1.0 / 0.9,
            AngleUnit::Radians => std::f64::consts::PI / 180.0,
        };
        let numbers: Vec<f64> =
            row.split_whitespace().skip(1).map(|w| w.parse().unwrap()).collect();
        assert_eq!(numbers[..3], [1000.0, 2000.0, 300.0]);
        for (found, degrees) in numbers[3..].iter().zip(DEGREES) {
            assert!((found - degrees * per_degree).abs() < 1e-9, "{text}");
        }
        sees(&text, None, "1024");
    }
    let named = vec![("a b".to_owned(), camera())];
    let error = to_table(&named, AngleUnit::Gon).unwrap_err().to_string();
    assert!(error.contains("name: is `a b`: a table's names have no blanks"), "{error}");
}

#[test]
fn bad_tables_are_refused_with_their_place() {
    let refuses = |text: &str, unit: Option<AngleUnit>, expected: &str| {
        let error = photographs::parse_with(text, &given(unit)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    };
    let gon = Some(AngleUnit::Gon);
    refuses("1 1 2 3 4 5 6\n", None, "does not say the unit of its angles");
    refuses("1 1 2 3 4 5 6\n2 1 2 3 4 x 6\n", gon, "line 2, field 6: phi is `x`");
    refuses("1 1 2 3 4 5 6\n2 1 2 3 4 5\n", gon, "line 2: has 6 fields, expected 7");
    refuses(
        "1;1;2;3;4;5;6,5\n",
        gon,
        "line 1, field 7: kappa is `6,5`, expected a finite number (with",
    );
    refuses("1 1 nan 3 4 5 6\n", gon, "line 1, field 3: Y is `nan`");
    refuses("1 2 3\n", gon, "line 1: has 3 fields, expected 7");
    refuses("# nothing\n", gon, "is empty");
    refuses("", gon, "is empty");
    refuses("name lat lon omega phi kappa\n", gon, "line 1: the header is `name lat lon omega");
    refuses("name X Y Z omega_gon phi_gon kappa_deg\n", None, "the angles in one unit");
    refuses(
        "name X Y Z omega_gon phi_gon kappa_gon\n",
        Some(AngleUnit::Degrees),
        "angles: is `deg`",
    );
    refuses("\"1;1;2;3;4;5;6\n", gon, "line 1: a quotation mark is not closed");
    let good = patb();
    let cut: String = good.lines().take(2).map(|l| format!("{l}\n")).collect();
    refuses(&cut, None, "line 2: has 5 fields, expected 9");
    refuses(&good.replace("300.00000", "300.00000 1"), gon, "line 1: has 5 fields, expected 7");
    refuses(&format!("{good}8 1 2\n"), None, "line 4: has 3 fields, expected 4");
    refuses(&good.replacen("-0.7", "-0.x", 1), None, "line 2, field 1: rotation matrix is `-0.x");
    refuses(
        &format!("{good}9 1 2 3\n1 0 0\n0 1 0\n0 0 2\n"),
        None,
        "9.rotation_matrix: is no rotation",
    );
    refuses("9 1 2 3\n1 0 0\n0 1 0\n0 0 -1\n", None, "9.rotation_matrix: mirrors");
    refuses(
        &format!("{good}9 1 2 3\n1 0 0 0 1\n0 0 0 1 7\n"),
        None,
        "line 6: has 5 fields, expected 4",
    );
    assert!(parse_patb("# nothing").is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damaged_tables_are_refused_or_read(at in 0.0..1.0f64, byte in any::<u8>(), cut in any::<bool>()) {
        for text in [patb(), "imageName,X,Y,Z,Omega,Phi,Kappa\n1.jpg,1,2,3,4,5,6\n2.jpg,1,2,3,4,5,6\n".into()] {
            let mut bytes = text.into_bytes();
            let at = (at * bytes.len() as f64) as usize;
            if cut { bytes.truncate(at); } else { bytes[at] = byte; }
            let text = String::from_utf8_lossy(&bytes);
            for Orientation { exterior, .. } in parse(&text, None).unwrap_or_default() {
                prop_assert!(exterior.orientation().is_ok());
            }
        }
    }

    /// A table of any camera is that camera again.
    #[test]
    fn orientations_survive_the_table_and_patb(angles in prop::array::uniform3(-3.1..3.1f64), center in prop::array::uniform3(-1e5..1e5f64)) {
        let text = format!("1 {} {} {} {} {} {}", center[0], center[1], center[2], angles[0], angles[1], angles[2]);
        let before = photographs::parse_with(&text, &given(Some(AngleUnit::Radians))).unwrap();
        let direction = |c: &CameraFile| c.exterior.orientation().unwrap().camera_from_world() * Vector3::new(0.6, -0.48, 0.64);
        let expected = direction(&before[0].1);
        for text in [to_table(&before, AngleUnit::Gon).unwrap(), to_patb(&before).unwrap()] {
            let after = photographs::parse_with(&text, &given(None)).unwrap();
            prop_assert!((direction(&after[0].1) - expected).norm() < 1e-11);
        }
    }
}
