//! Problems of *Bundle Adjustment in the Large*.

use std::path::{Path, PathBuf};

use collinear::CentralModel;
use collinear::nalgebra::Point2;
use collinear_io::bal::{Bal, Camera};
use collinear_io::{ErrorKind, FieldProblem, LineProblem};

use crate::shared_data;

fn oracle(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracles")).join(name)
}

/// Half the sum of squared residuals, by this crate's cameras; what lies behind its camera through its antipode.
fn cost(bal: &Bal) -> (f64, usize) {
    let cameras: Vec<_> =
        bal.cameras.iter().map(|c| (c.exterior().unwrap(), c.model().unwrap())).collect();
    let mut behind = 0;
    let cost = bal.observations.iter().map(|o| {
        let (exterior, camera) = &cameras[o.camera as usize];
        let point = bal.point(o.point as usize).unwrap();
        let mut direction = exterior.pose().apply(&point).coords;
        if direction.z < 0.0 {
            behind += 1;
            direction = -direction;
        }
        0.5 * (camera.project_direction(&direction).unwrap() - o.pixel()).norm_squared()
    });
    (cost.sum(), behind)
}

/// The image points of `oracles/bal.py` (scipy 1.x) are met to rounding.
#[test]
fn a_problem_projects_as_its_format_says() {
    let plain = Bal::read(&oracle("bal.txt")).unwrap();
    assert_eq!((plain.cameras.len(), plain.points.len(), plain.observations.len()), (2, 3, 6));
    assert!(cost(&plain).0 < 1e-23, "{}", cost(&plain).0);
    assert_eq!(Bal::read(&oracle("bal.txt.gz")).unwrap(), plain);
    // And back: text to the last bit, cameras to rounding.
    assert_eq!(Bal::parse(&plain.to_text()).unwrap(), plain);
    for camera in &plain.cameras {
        let (exterior, model) = (camera.exterior().unwrap(), camera.model().unwrap());
        let again = Camera::from_parts(&exterior, &model).unwrap();
        for (a, b) in again
            .rotation
            .iter()
            .chain(&again.translation)
            .zip(camera.rotation.iter().chain(&camera.translation))
        {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
        assert_eq!((again.focal, again.k), (camera.focal, camera.k));
    }
    let seen = &plain.observations[3];
    let again = collinear_io::bal::Observation::from_pixel(1, 1, &seen.pixel());
    assert_eq!(again, *seen);
    assert_eq!(seen.pixel(), Point2::new(seen.image[0], -seen.image[1]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("problem.txt");
    plain.write(&path).unwrap();
    assert_eq!(Bal::read(&path).unwrap(), plain);
}

/// The costs that Ceres Solver 2.1.0 starts from.
#[test]
fn the_shared_problems_start_at_their_costs() {
    for (name, expected, expected_behind) in [
        ("ladybug-49-7776-pre.txt.gz", 850_912.460_681, 31),
        ("trafalgar-21-11315-pre.txt.gz", 4_413_239.314_432, 0),
    ] {
        let Some(path) = shared_data(&format!("bal/{name}")) else { return };
        let (cost, behind) = cost(&Bal::read(&path).unwrap());
        assert!((cost - expected).abs() < 1e-6, "{name}: {cost}");
        assert_eq!(behind, expected_behind);
    }
}

#[test]
fn damage_is_named() {
    let text = std::fs::read_to_string(oracle("bal.txt")).unwrap();
    // Cut off anywhere, but within its last number.
    let last = text.trim_end().len() - 4;
    for end in (0..last).step_by(7) {
        assert!(Bal::parse(&text[..end]).is_err(), "{end}");
    }
    let line = |text: &str| match Bal::parse(text).unwrap_err().kind() {
        ErrorKind::Line { line, problem, .. } => (*line, problem.clone()),
        kind => panic!("{kind}"),
    };
    let not_a_number =
        |name: &str, text: &str| LineProblem::NotANumber { name: name.into(), text: text.into() };
    let ends = |name: &str| LineProblem::EndsEarly { name: name.into() };
    assert_eq!(line(""), (1, ends("number of cameras")));
    assert_eq!(line("1 -1 0"), (1, not_a_number("number of points", "-1")));
    assert_eq!(line("1 1 99999999999"), (1, not_a_number("number of observations", "99999999999")));
    // Counts of which nothing follows take no memory.
    assert_eq!(line("4000000000 4000000000 4000000000\n").0, 1);
    assert_eq!(
        line("1 1 1\n0 0 NaN 1\n"),
        (2, not_a_number("image point of observation 0 (of 1)", "NaN"))
    );
    assert_eq!(
        line("1 1 1\n0 0 1 1e999\n"),
        (2, not_a_number("image point of observation 0 (of 1)", "1e999"))
    );
    assert_eq!(line("0 1 0\n1 2\n"), (2, ends("coordinates of point 0 (of 1)")));
    assert_eq!(line("0 1 0\n1 2 3\n4\n"), (3, LineProblem::FieldCount { found: 1, expected: 0 }));
    for (text, what, name) in
        [("2 1 1\n2 0 1 1\n", "a camera", "2"), ("2 1 1\n1 1 1 1\n", "a point", "1")]
    {
        match Bal::parse(text).unwrap_err().kind() {
            ErrorKind::Field(e) => match &e.problem {
                FieldProblem::UnknownName { what: found, name: number, .. } => {
                    assert_eq!(
                        (*found, number.as_str(), e.field.as_str()),
                        (what, name, "observation in line 2")
                    );
                }
                problem => panic!("{problem}"),
            },
            kind => panic!("{kind}"),
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.gz");
    let packed = std::fs::read(oracle("bal.txt.gz")).unwrap();
    for end in [2, 12, packed.len() - 9] {
        std::fs::write(&path, &packed[..end]).unwrap();
        let error = Bal::read(&path).unwrap_err();
        assert!(matches!(error.kind(), ErrorKind::Foreign { program: "gzip", .. }), "{error}");
        assert_eq!(error.path(), Some(path.as_path()));
    }
}

#[test]
fn a_camera_of_another_kind_is_refused() {
    let camera = Camera { rotation: [0.0; 3], translation: [0.0; 3], focal: 500.0, k: [0.0; 2] };
    for focal in [0.0, -500.0, f64::NAN, f64::INFINITY] {
        let error = Camera { focal, ..camera }.model().unwrap_err();
        assert!(error.to_string().starts_with("camera.focal: is "), "{error}");
    }
    let error = Camera { k: [f64::NAN, 0.0], ..camera }.model().unwrap_err();
    assert!(error.to_string().starts_with("camera.k: "), "{error}");
    let error = Camera { translation: [0.0, f64::NAN, 0.0], ..camera }.exterior().unwrap_err();
    assert!(error.to_string().starts_with("camera.translation[1]: "), "{error}");
    let exterior = camera.exterior().unwrap();
    let interior = collinear::InteriorOrientation::new([500.0; 2], Point2::new(1.0, 0.0), 0.0);
    let lens = *camera.model().unwrap().distortion();
    let other = collinear_io::bal::BalCamera::from_parts(
        interior.unwrap(),
        collinear::camera::Gnomonic,
        lens,
    );
    assert!(Camera::from_parts(&exterior, &other).is_err());
}
