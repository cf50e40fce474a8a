//! The central models against OpenCV and COLMAP, and the laws that each of them keeps.

use std::f64::consts::{PI, TAU};

use crate::support::numbers;

use collinear::camera::{
    Adjustable, Brown, BrownCamera, COLMAP_MODELS, CentralCamera, CentralModel, CentralProjection,
    Distortion, Division, DoubleSphere, EnhancedUnified, EvenRadial, ExteriorOrientation,
    FieldOfView, Fisheye, Frame, Fraser, Gnomonic, InteriorOrientation, Metashape, NoDistortion,
    Orthographic, Panorama, RadialTangentialThinPrism, Rational, SensorModel, ThinPrism,
    UnifiedSphere, from_colmap,
};
use collinear::geometry::{Affine2, Plane};
use collinear::mapping::{CentralMap, CentralPhotographMap, Map, PhotographMap};
use collinear::nalgebra::{Point2, Point3, Vector2, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;
use serde_json::Value;

/// A model, its parameters, and directions with their images.
type Case = (String, Vec<f64>, Vec<(Vector3<f64>, Point2<f64>)>);

fn cases(program: &str) -> Vec<Case> {
    let all: Value =
        serde_json::from_str(include_str!("../data/oracles/central_models.json")).unwrap();
    let of_program = |c: &&Value| c["program"] == program;
    let case = |c: &Value| {
        let points = c["directions"].as_array().unwrap().iter().zip(c["image"].as_array().unwrap());
        let points =
            points.map(|(d, p)| (Vector3::from_vec(numbers(d)), Point2::from_slice(&numbers(p))));
        (c["model"].as_str().unwrap().to_owned(), numbers(&c["parameters"]), points.collect())
    };
    all["cases"].as_array().unwrap().iter().filter(of_program).map(case).collect()
}

fn agrees(
    name: &str,
    camera: &dyn CentralModel,
    points: &[(Vector3<f64>, Point2<f64>)],
    shift: f64,
) {
    assert!(points.len() >= 10, "{name}");
    for (direction, image) in points {
        let ours = camera.project_direction(direction).unwrap();
        let off = (ours - Vector2::repeat(shift) - image).norm();
        assert!(off < 1e-9, "{name}: {ours} for {image} at {direction}");
        let back = camera.direction(&ours).unwrap();
        assert!((back - direction.normalize()).norm() < 1e-12, "{name}: {back} for {direction}");
    }
}

#[test]
fn colmaps_eighteen_models_project_as_colmap_does() {
    let cases = cases("pycolmap");
    assert_eq!(cases.len(), 18);
    for (model, parameters, points) in cases {
        agrees(&model, &*from_colmap(&model, &parameters).unwrap(), &points, 0.0);
        assert!(from_colmap(&model, &parameters[1..]).is_err());
    }
    assert!(from_colmap("OPENCV2", &[1.0; 8]).is_err());
}

/// OpenCV's pixel (0, 0) is the centre of the first pixel.
#[test]
fn opencvs_models_project_as_opencv_does() {
    let cases = cases("OpenCV");
    assert_eq!(cases.len(), 6);
    for (model, parameters, points) in cases {
        let (k, coefficients) = parameters.split_at(4);
        let interior = InteriorOrientation::from_opencv(k[0], k[1], k[2], k[3]).unwrap();
        if model == "fisheye" {
            let lens = EvenRadial::new(coefficients.try_into().unwrap()).unwrap();
            let camera = CentralCamera::from_parts(interior, Fisheye::Equidistant, lens);
            agrees(&model, &camera, &points, 0.5);
        } else {
            let lens = Rational::from_opencv(coefficients).unwrap();
            assert_eq!(lens.to_opencv()[..coefficients.len()], *coefficients);
            agrees(&model, &CentralCamera::from_parts(interior, Gnomonic, lens), &points, 0.5);
        }
    }
}

#[test]
fn the_page_of_models_names_every_figure_and_every_model_of_colmap() {
    let page = include_str!("../../docs/models.md");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut figures = 0;
    for entry in std::fs::read_dir(root.join("docs/figures/lenses")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(page.contains(&format!("| `{name}` |")), "{name}");
        figures += 1;
    }
    assert_eq!(page.matches(".svg`").count(), figures);
    for (name, _) in COLMAP_MODELS {
        assert!(page.contains(&format!("`{name}`")), "{name}");
    }
}

/// The largest angle from the axis, at most `widest`, at which a direction has an image, for a direction around the axis.
fn edge(camera: &dyn CentralModel, around: f64, widest: f64) -> f64 {
    let sees = |angle: f64| camera.project_direction(&at(angle, around)).is_ok();
    if sees(widest) {
        return widest;
    }
    let (mut inside, mut outside) = (0.0, widest);
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        if sees(middle) { inside = middle } else { outside = middle }
    }
    inside
}

fn at(angle: f64, around: f64) -> Vector3<f64> {
    let ((s, c), (sa, ca)) = (angle.sin_cos(), around.sin_cos());
    Vector3::new(s * ca, s * sa, c)
}

/// What every central model keeps, out to the edge of its domain.
fn check_model<P: CentralProjection, D: Distortion>(projection: P, distortion: D, degrees: f64) {
    let interior =
        InteriorOrientation::new([611.3, 598.7], Point2::new(513.4, 391.9), 0.7).unwrap();
    let camera = CentralCamera::from_parts(interior, projection, distortion);
    let mut groups = Vec::new();
    while let Some(group) = camera.parameter_group(groups.len()) {
        groups.push(group.len);
    }
    let mut influence: Vec<Vec<f64>> = groups.iter().map(|len| vec![0.0; *len]).collect();
    for step in 0..24 {
        let around = TAU * (f64::from(step) + 0.37) / 24.0;
        let rim = edge(&camera, around, degrees.to_radians().min(PI - 1e-3));
        assert!(rim > 0.3, "{camera:?} sees {rim}");
        for share in [0.0, 1e-6, 0.1, 0.35, 0.6, 0.8, 0.95, 0.999] {
            let direction = at(rim * share, around);
            let image = camera.project_direction(&direction).unwrap();
            let longer = camera.project_direction(&(direction * 37.0)).unwrap();
            // Nanopixels, relative where a lens throws its edge far beyond a picture.
            let size = 1.0 + image.coords.norm() / 1e4;
            let alone = (longer - image).norm();
            assert!(alone < 1e-9 * size, "{camera:?} is not of the direction alone");

            // Back and forth: in the image always, in direction as its slope allows.
            let back = camera.direction(&image).unwrap();
            assert!((back.norm() - 1.0).abs() < 1e-14, "{camera:?}");
            let again = camera.project_direction(&back).unwrap();
            let off = (again - image).norm();
            assert!(off < 1e-9 * size, "{camera:?} {share}: {again} for {image}");
            let (_, slopes) = camera.project_direction_jacobian(&direction).unwrap();
            let weakest = slopes.svd(false, false).singular_values[1] / 600.0;
            let tolerance = 1e-13 * (1.0 + 1.0 / weakest);
            assert!((back - direction).norm() < tolerance, "{camera:?} {share}: {weakest}");

            check_slopes(&camera, &direction, &groups, &mut influence);
        }
        if rim < degrees.to_radians().min(PI - 1e-3) {
            let beyond = camera.project_direction(&at(rim + 1e-3, around));
            assert!(beyond.is_err(), "{camera:?}: the edge comes back");
        }
    }
    for (group, parameters) in influence.iter().enumerate() {
        for (i, largest) in parameters.iter().enumerate() {
            assert!(*largest > 1e-3, "{camera:?}: parameter {i} of group {group} changes nothing");
        }
    }

    // From anywhere in the plane of the image: what has a direction is the image of that direction, and not of another branch.
    for step in 0..400 {
        let (radius, around) = (0.01 * f64::from(step) * 1.02f64.powi(step % 97), f64::from(step));
        let plane = Point2::new(radius * around.cos(), radius * around.sin());
        let image = camera.interior().pixel_from_normalised(&plane);
        if let Ok(direction) = camera.direction(&image) {
            assert!((direction.norm() - 1.0).abs() < 1e-14, "{camera:?} {plane}: {direction}");
            // Within rounding of straight back a direction may not tell itself apart from it.
            let again = camera.project_direction(&direction).unwrap_or(image);
            let off = (again - image).norm();
            assert!(off < 1e-6 * (1.0 + radius * radius), "{camera:?} {plane}: {off}");
        }
    }

    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for i in 0..3 {
            let mut direction = Vector3::new(0.1, 0.2, 1.0);
            direction[i] = bad;
            if let Ok(p) = camera.project_direction(&direction) {
                assert!(i == 2 && p.x.is_finite() && p.y.is_finite(), "{camera:?} {direction}");
            }
        }
        assert!(camera.direction(&Point2::new(bad, 100.0)).is_err());
        assert!(camera.direction(&Point2::new(100.0, bad)).is_err());
    }
    assert!(camera.project_direction(&Vector3::zeros()).is_err());
    assert!(camera.project_direction_jacobian(&Vector3::zeros()).is_err());
    for far in [1e6, 1e100, 1e300] {
        if let Ok(d) = camera.direction(&Point2::new(far, -far)) {
            assert!((d.norm() - 1.0).abs() < 1e-14, "{d} {camera:?}");
            // Of the directions of an infinite radius none is beyond, but some round to it.
            assert!(far > 1e6 || camera.project_direction(&d).is_ok(), "{d} {camera:?}");
        }
    }
}

/// The partial derivatives against differences of the projection itself.
fn check_slopes<P: CentralProjection, D: Distortion>(
    camera: &CentralCamera<P, D>,
    direction: &Vector3<f64>,
    groups: &[usize],
    influence: &mut [Vec<f64>],
) {
    let mut by_object = [0.0; 6];
    let mut storage: Vec<Vec<f64>> = groups.iter().map(|len| vec![0.0; 2 * len]).collect();
    let mut slices: Vec<&mut [f64]> = storage.iter_mut().map(Vec::as_mut_slice).collect();
    let object = Point3::from(*direction);
    let image = camera.partials(&object, &mut by_object, &mut slices).unwrap();
    assert_eq!(image, camera.project_direction(direction).unwrap());
    let close = |slope: Vector2<f64>, analytic: Vector2<f64>, what: &str| {
        let scale = 2e-5 * (1000.0 + slope.norm());
        assert!((slope - analytic).norm() < scale, "{what} {slope:?} {analytic:?} {camera:?}");
    };
    let h = 1e-6;
    for i in 0..3 {
        let mut step = Vector3::zeros();
        step[i] = h;
        let moved = [1.0, -1.0].map(|s| camera.project_direction(&(direction + step * s)));
        let [Ok(a), Ok(b)] = moved else { continue };
        // Not across the seam of a panorama.
        if (a - b).norm() < 100.0 {
            let analytic = Vector2::new(by_object[i], by_object[3 + i]);
            close((a - b) / (2.0 * h), analytic, "by direction");
        }
    }
    for (group, block) in storage.iter().enumerate() {
        let len = groups[group];
        for i in 0..len {
            let analytic = Vector2::new(block[i], block[len + i]);
            influence[group][i] = influence[group][i].max(analytic.norm());
            let moved = [1.0, -1.0].map(|sign| {
                let (mut copy, mut step) = (*camera, vec![0.0; len]);
                step[i] = sign * h;
                copy.adjust(group, &step).ok()?;
                copy.project_direction(direction).ok()
            });
            if let [Some(a), Some(b)] = moved {
                close((a - b) / (2.0 * h), analytic, "by parameter");
            }
        }
    }
}

#[test]
fn project_after_direction_is_the_identity_out_to_the_edge_of_every_domain() {
    let brown = Brown::new([-0.28, 0.01, 0.001], [1.1e-3, -6e-4]).unwrap();
    check_model(Gnomonic, NoDistortion, 89.0);
    check_model(Gnomonic, brown, 89.0);
    let k = [-0.281, 0.0713, 0.0131, 0.0172, -0.0214, 0.0036];
    let (p, s, tilt) = ([1.1e-3, -6.2e-4], [8.3e-4, -4.1e-4, -7.7e-4, 2.9e-4], [0.031, -0.047]);
    check_model(Gnomonic, Rational::new(k, p, s, tilt).unwrap(), 60.0);
    let k = [-0.11, 0.04, -0.013, 0.002];
    check_model(Gnomonic, Metashape::new(k, [1.1e-3, -6e-4, 0.3, -0.1]).unwrap(), 60.0);
    let b = [3e-3, -2e-3];
    check_model(Gnomonic, Fraser::new([0.11, -0.03, 0.004], [1e-3, -6e-4], b).unwrap(), 80.0);
    let k = [0.031, -0.015, 0.0063, -0.0011];
    check_model(Fisheye::Equidistant, EvenRadial::new(k).unwrap(), 179.0);
    let prism = ThinPrism::new(k, [1.2e-3, -7e-4], [9e-4, -5e-4]).unwrap();
    check_model(Fisheye::Equidistant, prism, 179.0);
    let k = [0.031, -0.015, 0.0063, -0.0011, 4e-4, -6e-5];
    let (p, s) = ([1.2e-3, -7e-4], [9e-4, -5e-4, 3e-4, -2e-4]);
    let aria = RadialTangentialThinPrism::new(k, p, s).unwrap();
    check_model(Fisheye::Equidistant, aria, 179.0);
    check_model(Fisheye::Equidistant, NoDistortion, 179.0);
    check_model(Fisheye::Stereographic, NoDistortion, 150.0);
    check_model(Fisheye::Equisolid, NoDistortion, 179.0);
    check_model(Fisheye::Orthographic, NoDistortion, 89.9);
    check_model(FieldOfView::new(0.93).unwrap(), NoDistortion, 89.0);
    check_model(Division::new(-0.13).unwrap(), NoDistortion, 140.0);
    check_model(Division::new(0.09).unwrap(), NoDistortion, 89.0);
    check_model(UnifiedSphere::new(0.73).unwrap(), brown, 120.0);
    check_model(UnifiedSphere::new(1.21).unwrap(), brown, 179.0);
    check_model(EnhancedUnified::new(0.57, 1.13).unwrap(), NoDistortion, 179.0);
    check_model(EnhancedUnified::new(0.31, 0.8).unwrap(), NoDistortion, 110.0);
    check_model(DoubleSphere::new(-0.18, 0.59).unwrap(), NoDistortion, 179.0);
    check_model(DoubleSphere::new(0.3, 0.4).unwrap(), NoDistortion, 120.0);
    check_model(Panorama::Equirectangular, NoDistortion, 179.0);
    check_model(Panorama::Cylindrical, NoDistortion, 85.0);
}

/// Points all over the picture and beyond it, among them some that no ideal point has for its image.
#[test]
fn many_points_are_undistorted_as_one_by_one() {
    let interior =
        InteriorOrientation::new([611.3, 598.7], Point2::new(513.4, 391.9), 0.7).unwrap();
    let rational = Rational::from_opencv(&[
        -0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036, 8.3e-4, -4.1e-4, -7.7e-4,
        2.9e-4, 0.031, -0.047,
    ]);
    let brown = Brown::new([-0.28, 0.01, 0.001], [1.1e-3, -6e-4]);
    let metashape = Metashape::new([-0.11, 0.04, -0.013, 0.002], [1.1e-3, -6e-4, 0.3, -0.1]);
    let fraser = Fraser::new([0.11, -0.03, 0.004], [1e-3, -6e-4], [3e-3, -2e-3]);
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, rational.unwrap()), 0);
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, brown.unwrap()), 100);
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, metashape.unwrap()), 0);
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, fraser.unwrap()), 0);
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, NoDistortion), 0);
}

/// Decentering so strong that the first steps of many points do not reach the floor, and prisms and denominators with it.
#[test]
fn many_points_through_strong_lenses_are_undistorted_as_one_by_one() {
    let interior =
        InteriorOrientation::new([611.3, 598.7], Point2::new(513.4, 391.9), 0.7).unwrap();
    let brown = Brown::new([-0.28, 0.07, 0.002], [1e-2, -2e-2]).unwrap();
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, brown), 0);
    let (k, p, s) = ([0.2, -0.1, 0.05, 0.4, 0.1, 0.02], [0.02, 0.01], [0.03, -0.02, 0.01, 0.02]);
    let rational = Rational::new(k, p, s, [0.0; 2]).unwrap();
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, rational), 0);
    let metashape = Metashape::new([0.3, -0.1, 0.05, 0.0], [0.02, 0.01, -0.5, 0.3]).unwrap();
    one_by_one(CentralCamera::from_parts(interior, Gnomonic, metashape), 0);
}

/// Past their fold these polynomials rise again: a target beyond the rim has a point out there, and Newton's steps find it.
#[test]
fn what_lies_beyond_the_rim_has_no_ideal_point_alone_or_among_many() {
    // 1 − 1.5 s + 0.4 s² = 0 at s = (1.5 − √0.65)/0.8; the rim is there r (1 − 0.5 s + 0.08 s²).
    let s = (1.5 - 0.65f64.sqrt()) / 0.8;
    let rim = s.sqrt() * (1.0 - 0.5 * s + 0.08 * s * s);
    beyond(&Brown::new([-0.5, 0.08, 0.0], [0.0; 2]).unwrap(), rim);
    beyond(&Metashape::new([-0.5, 0.08, 0.0, 0.0], [0.0; 4]).unwrap(), rim);
    beyond(&EvenRadial::new([-0.5, 0.08, 0.0, 0.0]).unwrap(), rim);
    beyond(&ThinPrism::new([-0.5, 0.08, 0.0, 0.0], [0.0; 2], [0.0; 2]).unwrap(), rim);
    let rational = Rational::from_opencv(&[-0.5, 0.08, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
    beyond(&rational, rim);
}

fn beyond(lens: &impl Distortion, rim: f64) {
    for turn in [0.0_f64, 0.9, 2.4, 4.4] {
        let ray = Vector2::new(turn.cos(), turn.sin());
        for step in 0..400 {
            // Half of the points lie within the rim, so that the others find a start.
            let outside = Point2::from(ray * (rim * (1.0 + 1e-6 + f64::from(step) * 2e-3)));
            assert!(lens.undistort(&outside).is_err(), "{lens:?} {outside}");
            let inside = |i: i32| Point2::from(ray * (rim * f64::from(i) / 33.0));
            let mut many: Vec<_> = (0..32).map(inside).chain([outside; 32]).collect();
            let given = many.clone();
            let report = lens.undistort_many(&mut many);
            assert_eq!((report.converged, report.failed), (32, 32), "{lens:?} {outside}");
            for (found, given) in many[..32].iter().zip(&given) {
                let off = (lens.distort(found).unwrap() - given).norm();
                assert!(off <= report.largest_residual + 1e-16, "{off} {report:?}");
            }
            assert!(many[32..].iter().all(|p| p.x.is_nan() && p.y.is_nan()), "{lens:?}");
        }
    }
}

fn one_by_one<D: Distortion>(camera: CentralCamera<Gnomonic, D>, fewest_failures: usize) {
    for count in [0, 1, 5, 31, 64, 65, 3001] {
        let pixels: Vec<Point2<f64>> = (0..count)
            .map(|i| {
                let (a, b) = (f64::from(i) * 0.754_877_666, f64::from(i) * 0.569_840_291);
                Point2::new(1500.0 * a.fract() - 250.0, 1300.0 * b.fract() - 250.0)
            })
            .chain([Point2::new(f64::NAN, 3.0)])
            .collect();
        let mut ideal = vec![Point2::origin(); pixels.len()];
        let report = camera.undistort_points(&pixels, &mut ideal).unwrap();
        assert_eq!(report.converged + report.failed, pixels.len());
        assert!(report.failed > 0 && report.largest_residual < 4e-15 * 2.0, "{report:?}");
        assert!(count < 3000 || report.failed > fewest_failures, "{report:?}");
        let mut failed = 0;
        let mut largest = 0.0_f64;
        for (pixel, point) in pixels.iter().zip(&ideal) {
            let distorted = camera.interior().normalised_from_pixel(pixel);
            match camera.distortion().undistort(&distorted) {
                Ok(alone) => {
                    let thrown = camera.distortion().distort(point).unwrap();
                    largest = largest.max((thrown - distorted).norm());
                    // Both are at the floor of the residual; near the fold that floor is wide.
                    let share = alone.point.coords.norm() / camera.distortion().fold_radius();
                    let off = (point - alone.point).norm();
                    assert!(off < 1e-14 / (1.0 - share).max(1e-3), "{off} {share} {camera:?}");
                }
                Err(_) => {
                    failed += 1;
                    assert!(point.x.is_nan() && point.y.is_nan(), "{pixel}: {point}");
                }
            }
        }
        assert_eq!(failed, report.failed);
        // The report is of this very run: what it says was measured, to a few roundings of the formula.
        assert!((largest - report.largest_residual).abs() < 2e-15, "{largest} {report:?}");
    }
    assert!(camera.undistort_points(&[Point2::origin()], &mut []).is_err());
}

/// One ray, 60° from the axis to the right (and 30° down for panoramas), through each projection, by the formula in decimals.
#[test]
fn projections_of_one_ray_by_hand() {
    let ray = Vector3::new(3f64.sqrt(), 0.0, 1.0);
    let right = |p: &dyn Fn(&Vector3<f64>) -> Point2<f64>, expected: f64| {
        let at = p(&ray);
        assert!((at - Point2::new(expected, 0.0)).norm() < 1e-14, "{at} for {expected}");
    };
    right(&|d| Gnomonic.plane(d).unwrap(), 1.732_050_807_568_877_2);
    right(&|d| Fisheye::Equidistant.plane(d).unwrap(), 1.047_197_551_196_597_6);
    right(&|d| Fisheye::Stereographic.plane(d).unwrap(), 1.154_700_538_379_251_7);
    right(&|d| Fisheye::Equisolid.plane(d).unwrap(), 1.0);
    right(&|d| Fisheye::Orthographic.plane(d).unwrap(), 0.866_025_403_784_438_6);
    // sin 60°/(cos 60° + 0.9) = 0.8660254/1.4
    right(&|d| UnifiedSphere::new(0.9).unwrap().plane(d).unwrap(), 0.618_589_574_131_741_8);
    // w = ½ − ⅕ = 0.3, √(¾ + 0.09) = √0.84: 0.8660254/(0.6 √0.84 + 0.4 · 0.3)
    let double = DoubleSphere::new(-0.2, 0.6).unwrap();
    let expected = 0.75f64.sqrt() / (0.6 * 0.84f64.sqrt() + 0.12);
    right(&|d| double.plane(d).unwrap(), expected);

    // A full turn wide; half a turn high or with square pixels.
    let size = |panorama: Panorama| panorama.principal_distance(TAU * 100.0, PI * 70.0);
    assert_eq!(size(Panorama::Equirectangular), [100.0, 70.0]);
    assert_eq!(size(Panorama::Cylindrical), [100.0, 100.0]);
    // Straight up, whatever the signs of the zeros.
    for zeros in [[0.0, 0.0], [-0.0, -0.0], [0.0, -0.0]] {
        let up = Panorama::Equirectangular.plane(&Vector3::new(zeros[0], -3.0, zeros[1])).unwrap();
        assert_eq!(up, Point2::new(0.0, -0.5 * PI));
    }
    let below = Vector3::new(1.0, 2.0, -1.0);
    let at = Panorama::Equirectangular.plane(&below).unwrap();
    // 135° to the right; tan φ = 2/√2
    assert!((at - Point2::new(2.356_194_490_192_345, 0.955_316_618_124_509_3)).norm() < 1e-15);
    let at = Panorama::Cylindrical.plane(&below).unwrap();
    assert!((at - Point2::new(2.356_194_490_192_345, 2f64.sqrt())).norm() < 1e-15);
}

/// At (x̄, ȳ) = (0.3, −0.4): r² = ¼, r⁴ = 1/16, r⁶ = 1/64, r⁸ = 1/256.
#[test]
fn metashapes_and_frasers_lenses_by_their_formulas() {
    let ideal = Point2::new(0.3, -0.4);
    let lens = Metashape::new([0.4, -0.16, 0.64, -0.256], [0.01, 0.02, 0.4, -0.8]).unwrap();
    // 1 + 0.1 − 0.01 + 0.01 − 0.001 = 1.099; m = 1 + 0.1 − 0.05 = 1.05
    // P₁ (¼ + 0.18) + 2 P₂ (−0.12) = 0.0043 − 0.0048; P₂ (¼ + 0.32) + 2 P₁ (−0.12) = 0.0114 − 0.0024
    let expected = Point2::new(0.3 * 1.099 - 0.0005 * 1.05, -0.4 * 1.099 + 0.009 * 1.05);
    assert!((lens.distort(&ideal).unwrap() - expected).norm() < 1e-15);

    // u = w/2 + cx + x′ (f + b₁) + y′ b₂, v = h/2 + cy + y′ f
    let interior =
        InteriorOrientation::from_metashape([4000.0, 3000.0], 3500.0, [12.0, -7.0], [5.0, -2.0]);
    let pixel = interior.unwrap().pixel_from_normalised(&Point2::new(0.1, -0.2));
    assert!((pixel - Point2::new(2012.0 + 350.5 + 0.4, 1493.0 - 700.0)).norm() < 1e-12);

    // y up: (x̄, ȳ) = (0.3, 0.4) in units of c. 1 + 0.1 − 0.01 + 0.01 = 1.1 of K.
    let c = 20.0_f64;
    let k = [0.4 / c / c, -0.16 / c.powi(4), 0.64 / c.powi(6)];
    let lens = Fraser::from_millimetres(c, k, [0.01 / c, 0.02 / c], [0.03, -0.05]).unwrap();
    // P₁ (¼ + 0.18) + 2 P₂ · 0.12 = 0.0043 + 0.0048, b₁x̄ + b₂ȳ = 0.009 − 0.02
    // P₂ (¼ + 0.32) + 2 P₁ · 0.12 = 0.0114 + 0.0024
    let expected = Point2::new(0.33 + 0.0091 - 0.011, -(0.44 + 0.0138));
    let found = lens.undistort(&ideal).unwrap();
    assert!((found.point - expected).norm() < 1e-15, "{}", found.point);
    assert!((lens.distort(&expected).unwrap() - ideal).norm() < 1e-15);
}

/// Where the slope along a line through the axis vanishes, by hand.
#[test]
fn folds_of_rational_and_corrected_lenses_by_hand() {
    // r/(1 + r²) is largest at r = 1.
    let lens = Rational::new([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0; 2], [0.0; 4], [0.0; 2]).unwrap();
    assert!((lens.fold_radius() - 1.0).abs() < 1e-15);
    assert!(lens.distort(&Point2::new(0.8, 0.61)).is_err());
    // r (1 − r²/10)/(1 + r²): (1 − 3r²/10)(1 + r²) = 2r² (1 − r²/10), so r⁴ + 13 r² = 10.
    let lens =
        Rational::new([-0.1, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0; 2], [0.0; 4], [0.0; 2]).unwrap();
    let expected = (0.5 * (209f64.sqrt() - 13.0)).sqrt();
    assert!((lens.fold_radius() - expected).abs() < 1e-15, "{}", lens.fold_radius());
    // A pole: 1/(1 − r²).
    let pole = Rational::new([0.0, 0.0, 0.0, -1.0, 0.0, 0.0], [0.0; 2], [0.0; 4], [0.0; 2]);
    assert!((pole.unwrap().fold_radius() - 1.0).abs() < 1e-15);
    // A pincushion, whose slope across the radius, 1 + r²/2, is the smaller: 1 + r²/2 = 6 · 0.3 r.
    let lens = Brown::new([0.5, 0.0, 0.0], [0.18, 0.24]).unwrap();
    assert!((lens.fold_radius() - (1.8 - 1.24f64.sqrt())).abs() < 1e-15);
    // x + s₁r² has the slope 1 − 2 s₁r at (−r, 0); |(0.3, 0.4)| = ½.
    let lens = ThinPrism::new([0.0; 4], [0.0; 2], [0.3, 0.4]).unwrap();
    assert!((lens.fold_radius() - 1.0).abs() < 1e-15);
    // x + s₂r⁴ has the slope 1 − 4 s₂r³.
    let s = [0.0, 0.03, 0.0, -0.04];
    let lens = Rational::new([0.0; 6], [0.0; 2], s, [0.0; 2]).unwrap();
    assert!((lens.fold_radius() - 5f64.cbrt()).abs() < 1e-14);
    // Of |p| (3 r² + 3|q₁| r⁴ + 3|q₂| r⁶) the slope is at most |p| (6 r + 12 |q₁| r³ + 18 |q₂| r⁵).
    let lens = Metashape::new([0.0; 4], [0.03, 0.04, -0.5, 0.25]).unwrap();
    let r = lens.fold_radius();
    assert!((0.05 * (6.0 * r + 6.0 * r.powi(3) + 4.5 * r.powi(5)) - 1.0).abs() < 1e-14, "{r}");
    // ∂x̂/∂x̄ = 1 − 3x̄² − 0.19 on the x axis.
    let lens = Fraser::new([-1.0, 0.0, 0.0], [0.0; 2], [-0.19, 0.0]).unwrap();
    assert!((lens.fold_radius() - 0.27f64.sqrt()).abs() < 1e-15);
}

/// Where decentering or a prism throws a point outwards, its image lies beyond the fold radius, and beyond what the radial part
/// alone reaches.
#[test]
fn strong_lenses_come_back_from_their_rim_on_every_side() {
    fn around(lens: &impl Distortion) {
        for i in 0..40 {
            let turn = f64::from(i) * TAU / 40.0;
            let ideal = Point2::new(turn.cos(), turn.sin()) * (0.97 * lens.fold_radius().min(3.0));
            let thrown = lens.distort(&ideal).unwrap();
            let back = lens.undistort(&thrown).unwrap();
            assert!((back.point - ideal).norm() < 1e-12, "{lens:?} {ideal}");
            // What is said of the end is so.
            let off = (lens.distort(&back.point).unwrap() - thrown).norm();
            assert!((off - back.residual).abs() < 4e-15 && back.residual < 2e-14, "{back:?} {off}");
        }
    }
    around(&Brown::new([0.0; 3], [0.06, 0.08]).unwrap());
    around(&Brown::new([0.3, -0.02, 0.0], [0.06, 0.08]).unwrap());
    around(&ThinPrism::new([0.0; 4], [0.0; 2], [0.3, 0.4]).unwrap());
    around(&Rational::new([0.0; 6], [0.0; 2], [0.0, 0.03, 0.0, -0.04], [0.0; 2]).unwrap());
    around(&Metashape::new([0.0; 4], [0.03, 0.04, 0.5, 0.25]).unwrap());
    // A corrected lens starts from its measured points.
    let lens = Fraser::new([-0.02, 0.0, 0.0], [0.02, 0.01], [0.4, -0.1]).unwrap();
    for i in 0..40 {
        let turn = f64::from(i) * TAU / 40.0;
        let measured = Point2::new(turn.cos(), turn.sin()) * (0.97 * lens.fold_radius());
        let back = lens.distort(&lens.undistort(&measured).unwrap().point).unwrap();
        assert!((back - measured).norm() < 1e-12, "{measured} {back}");
    }
    let k = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0];
    around(&RadialTangentialThinPrism::new(k, [0.05, 0.02], [0.1, 0.0, -0.2, 0.0]).unwrap());
}

/// A sensor turned by −1 about y: w = cos 1 − x′ sin 1 is 0 at x′ = cot 1 = 0.642; from beyond it the homography would lead to
/// the other side of the picture.
#[test]
fn a_tilted_sensor_ends_at_its_horizon() {
    let lens = Rational::new([0.0; 6], [0.0; 2], [0.0; 4], [0.0, -1.0]).unwrap();
    let at = lens.distort(&Point2::new(0.6, 0.0)).unwrap();
    assert!((at.x - 0.6 / (1f64.cos() - 0.6 * 1f64.sin())).abs() < 1e-13, "{at}");
    assert!(lens.distort(&Point2::new(0.65, 0.0)).is_err());
    // The image that x′ = 1 would have.
    let ghost = Point2::new(1.0 / (1f64.cos() - 1f64.sin()), 0.0);
    assert!(lens.undistort(&ghost).is_err());
    let mut many = [ghost; 40];
    assert_eq!(lens.undistort_many(&mut many).failed, 40);
    for tilt in [[0.0, 1.6], [-1.6, 0.0], [f64::NAN, 0.0]] {
        assert!(Rational::new([0.0; 6], [0.0; 2], [0.0; 4], tilt).is_err());
    }
}

/// The second stage, p alone, ends at 1/(6|p|) = 1; the radial image reaches it at 0.8 (1 + 0.390625 · 0.64) = 1. With k₀ = −⅓ the
/// radial stage folds first, at 1, where its image is ⅔.
#[test]
fn two_stages_end_where_the_first_of_them_does() {
    let lens = |k0, p0| {
        let k = [k0, 0.0, 0.0, 0.0, 0.0, 0.0];
        RadialTangentialThinPrism::new(k, [p0, 0.0], [0.0; 4]).unwrap()
    };
    let second = lens(0.390_625, 1.0 / 6.0);
    assert!((second.fold_radius() - 0.8).abs() < 1e-14, "{}", second.fold_radius());
    assert!(second.distort(&Point2::new(0.0, 0.799)).is_ok());
    assert!(second.distort(&Point2::new(0.0, 0.801)).is_err());
    let first = lens(-1.0 / 3.0, 1.0 / 6.0);
    assert!((first.fold_radius() - 1.0).abs() < 1e-14, "{}", first.fold_radius());
    // A radial fold that lies behind the rim of the second stage: 1.2 (1 − 0.144) = 1.0272.
    let rim = lens(-0.1, 1.0 / (6.0 * 1.0272));
    assert!((rim.fold_radius() - 1.2).abs() < 1e-14, "{}", rim.fold_radius());
    // So weak that the numbers hold its fold and the search does not: it is cut off.
    assert_eq!(Brown::new([-1e-34, 0.0, 0.0], [0.0; 2]).unwrap().fold_radius(), 1e16);
}

/// Where the edges lie, by the equations of the domains.
#[test]
fn projections_end_where_their_equations_say() {
    for (xi, alpha) in [(-0.18, 0.59), (0.3, 0.4), (0.6, 0.7), (-0.5, 0.3), (0.0, 0.5)] {
        let lens = DoubleSphere::new(xi, alpha).unwrap();
        let w1: f64 = if alpha <= 0.5 { alpha / (1.0 - alpha) } else { (1.0 - alpha) / alpha };
        for i in 1..2000 {
            let angle = f64::from(i) * PI / 2000.0;
            let (rho, z) = angle.sin_cos();
            let w = xi + z;
            let margin = w + w1 * rho.hypot(w);
            if margin.abs() > 1e-6 {
                let seen = lens.plane(&at(angle, 0.3)).is_ok();
                assert_eq!(seen, margin > 0.0, "{lens:?} {angle} {margin}");
            }
        }
    }
    // λ = ¼: Z = 2 √λ ρ = ρ.
    let lens = Division::new(0.25).unwrap();
    let outside = lens.plane(&Vector3::new(1.2, 0.0, 1.0));
    assert_eq!(outside, Err(ProjectionError::OutsideDomain { value: 1.2, limit: 1.0 }));
    assert!(lens.direction(&Point2::new(1.999, 0.0)).is_ok());
    assert!(lens.direction(&Point2::new(2.001, 0.0)).is_err());
}

#[test]
fn steps_of_another_length_or_past_zero_leave_a_camera_as_it_was() {
    let interior = InteriorOrientation::new([600.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let mut camera = BrownCamera::new(interior, Brown::new([-0.1, 0.0, 0.0], [0.0; 2]).unwrap());
    let before = camera;
    for (group, step) in [(0, &[0.0; 4][..]), (0, &[0.0; 6]), (1, &[0.0; 4]), (1, &[0.0; 6])] {
        assert!(matches!(camera.adjust(group, step), Err(Error::LengthMismatch { .. })));
    }
    for step in [[-601.0, 0.0, 0.0, 0.0, 0.0], [0.0, -601.0, 0.0, 0.0, 0.0]] {
        assert!(matches!(camera.adjust(0, &step), Err(Error::OutOfRange { .. })));
    }
    assert!(camera.adjust(2, &[]).is_err());
    assert_eq!(camera, before);
}

#[test]
fn coefficients_whose_products_leave_the_numbers_are_named() {
    let refused = Brown::new([0.0, 0.0, 1e31], [0.0; 2]);
    let what = "distortion coefficient";
    assert!(matches!(refused, Err(Error::OutOfRange { what: w, .. }) if w == what), "{refused:?}");
}

/// A map of a sloping plane in map coordinates, by the chain written out: the point of the screen on the plane, its direction
/// in camera axes, the camera.
fn maps_as_seen<C: CentralModel + Clone>(
    camera: &C,
    other: impl Fn(&Frame<C>) -> Option<Box<dyn Map>>,
) {
    let origin = Point3::new(389_400.0, 5_819_700.0, 40.0);
    let plane = Plane::from_point_and_normal(origin, Vector3::new(0.2, -0.1, 1.0)).unwrap();
    let center = origin + Vector3::new(30.0, 20.0, 100.0);
    let exterior =
        ExteriorOrientation::look_at(center, origin + Vector3::new(60.0, 5.0, 0.0), Vector3::y())
            .unwrap();
    let photograph = Frame::new(exterior, camera.clone());
    let above =
        ExteriorOrientation::look_at(origin + Vector3::z() * 50.0, origin, Vector3::y()).unwrap();
    let screen = Orthographic::new(above, Affine2::identity()).unwrap();
    let map = CentralPhotographMap::from_plane(&plane, &photograph, &screen.homogeneous()).unwrap();
    let other = other(&photograph);
    let rows = exterior.camera_from_world();
    let mut seen = 0;
    for i in 0..400 {
        let (s, l) = (f64::from(i % 20) * 20.0 - 190.0, f64::from(i / 20) * 20.0 - 190.0);
        let pixel = Point2::new(s, l);
        // East is right and north is up; the plane rises as its normal says.
        let world = origin + Vector3::new(s, -l, -(0.2 * s + 0.1 * l));
        let d = rows * (world - center);
        let Ok(at) = map.at(&pixel) else {
            assert!(camera.project_direction(&d).is_err(), "{camera:?} {pixel}");
            continue;
        };
        let expected = camera.project_direction(&d).unwrap();
        // Next to its horizon a plane is seen far beyond any picture.
        if expected.coords.norm() > 1e5 {
            continue;
        }
        seen += 1;
        assert!((at - expected).norm() < 1e-5, "{camera:?} {pixel}: {at} for {expected}");
        assert!((at - photograph.project(&world).unwrap()).norm() < 1e-5);
        let back = map.outer.plane_point(&at).unwrap();
        let plane_point = map.inner.at(&pixel).unwrap();
        assert!(
            (back - plane_point).norm() < 1e-6 * (1.0 + back.coords.norm()),
            "{camera:?} {pixel}"
        );
        if let Some(other) = &other {
            assert!((other.at(&pixel).unwrap() - at).norm() < 1e-5);
        }
        let slope = map.jacobian(&pixel).unwrap();
        for (column, h) in [Vector2::x(), Vector2::y()].into_iter().enumerate() {
            let moved = [1e-3, -1e-3].map(|t| map.at(&(pixel + h * t)));
            if let [Ok(a), Ok(b)] = moved {
                let off = ((a - b) / 2e-3 - slope.column(column)).norm();
                assert!(off < 1e-4 * (1.0 + slope.norm()), "{camera:?} {pixel} {off}");
            }
        }
    }
    assert!(seen > 100, "{camera:?}: {seen}");
    // A plane through the eye is a line.
    let edge_on = Plane::from_point_and_normal(center, Vector3::new(0.2, -0.1, 1.0)).unwrap();
    assert!(
        CentralPhotographMap::from_plane(&edge_on, &photograph, &screen.homogeneous()).is_err()
    );
}

#[test]
fn a_plane_is_mapped_into_a_photograph_of_every_kind() {
    let interior =
        InteriorOrientation::new([611.3, 598.7], Point2::new(513.4, 391.9), 0.7).unwrap();
    let screen = |photograph: &Frame<BrownCamera>| {
        let origin = Point3::new(389_400.0, 5_819_700.0, 40.0);
        let plane = Plane::from_point_and_normal(origin, Vector3::new(0.2, -0.1, 1.0)).unwrap();
        let above =
            ExteriorOrientation::look_at(origin + Vector3::z() * 50.0, origin, Vector3::y())
                .unwrap();
        let screen = Orthographic::new(above, Affine2::identity()).unwrap().homogeneous();
        let map = PhotographMap::from_plane(&plane, photograph, &screen).unwrap();
        Some(Box::new(map) as Box<dyn Map>)
    };
    let brown = Brown::new([0.11, -0.01, 0.001], [1.1e-3, -6e-4]).unwrap();
    maps_as_seen(&BrownCamera::new(interior, brown), screen);
    let fisheye = EvenRadial::new([0.031, -0.015, 0.0063, -0.0011]).unwrap();
    maps_as_seen(&CentralCamera::from_parts(interior, Fisheye::Equidistant, fisheye), |_| None);
    maps_as_seen(&CentralCamera::ideal(interior, Panorama::Equirectangular), |_| None);
    let double = DoubleSphere::new(-0.18, 0.59).unwrap();
    maps_as_seen(&CentralCamera::ideal(interior, double), |_| None);

    // The plane one ahead, there and back; behind the camera there is none of it.
    let map = CentralMap::ahead(CentralCamera::ideal(interior, Fisheye::Equidistant));
    for (x, y) in [(0.3, -0.2), (-4.0, 0.5), (0.0, 0.0), (7.0, -9.0)] {
        let plane = Point2::new(x, y);
        let back = map.plane_point(&map.at(&plane).unwrap()).unwrap();
        assert!((back - plane).norm() < 1e-12 * (1.0 + plane.coords.norm_squared()), "{back}");
    }
    assert!(map.plane_point(&Point2::new(513.4 + 611.3 * 1.6, 391.9)).is_err());
}

/// A model of any numbers through any numbers: an answer or an error, and what it answers is a number.
fn any_model<P: CentralProjection, D: Distortion>(projection: P, distortion: D, v: [f64; 3]) {
    let interior = InteriorOrientation::new([600.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let camera = CentralCamera::from_parts(interior, projection, distortion);
    let finite = |p: &Point2<f64>| p.x.is_finite() && p.y.is_finite();
    let direction = Vector3::from(v);
    if let Ok(p) = camera.project_direction(&direction) {
        assert!(finite(&p), "{camera:?} {direction}");
    }
    if let Ok((p, slopes)) = camera.project_direction_jacobian(&direction) {
        assert!(finite(&p) && !slopes.iter().any(|s| s.is_nan()), "{camera:?} {direction}");
    }
    if let Ok(d) = camera.direction(&Point2::new(v[0], v[1])) {
        assert!((d.norm() - 1.0).abs() < 1e-9, "{camera:?} {v:?} {d}");
    }
    let (mut object, mut groups) = ([0.0; 6], vec![vec![0.0; 10]; 3]);
    for (group, block) in groups.iter_mut().enumerate() {
        *block = vec![0.0; camera.parameter_group(group).map_or(0, |g| 2 * g.len)];
    }
    let mut slices: Vec<&mut [f64]> = groups.iter_mut().map(Vec::as_mut_slice).collect();
    let _ = camera.partials(&Point3::from(v), &mut object, &mut slices);
    let mut many = [Point2::new(v[0], v[1]); 40];
    let report = camera.distortion().undistort_many(&mut many);
    assert_eq!(report.converged + report.failed, 40);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn any_numbers_make_a_model_or_an_error(
        c in prop::array::uniform14(prop_oneof![any::<f64>(), -1.0..1.0f64]),
        v in prop::array::uniform3(prop_oneof![any::<f64>(), -3.0..3.0f64]),
    ) {
        let [a, b, d, e, f, g, h, i, ..] = c;
        if let Ok(lens) = Brown::new([a, b, d], [e, f]) { any_model(Gnomonic, lens, v); }
        if let Ok(lens) = Rational::from_opencv(&c) { any_model(Gnomonic, lens, v); }
        if let Ok(lens) = Rational::from_opencv(&c[..8]) { any_model(Gnomonic, lens, v); }
        if let Ok(lens) = Metashape::new([a, b, d, e], [f, g, h, i]) { any_model(Gnomonic, lens, v); }
        if let Ok(lens) = Fraser::new([a, b, d], [e, f], [g, h]) { any_model(Gnomonic, lens, v); }
        let fisheye = Fisheye::Equidistant;
        if let Ok(lens) = EvenRadial::new([a, b, d, e]) { any_model(fisheye, lens, v); }
        if let Ok(lens) = ThinPrism::new([a, b, d, e], [f, g], [h, i]) { any_model(fisheye, lens, v); }
        let (k, p, s) = ([a, b, d, e, f, g], [h, i], [c[8], c[9], c[10], c[11]]);
        if let Ok(lens) = RadialTangentialThinPrism::new(k, p, s) { any_model(fisheye, lens, v); }
        for ideal in [fisheye, Fisheye::Stereographic, Fisheye::Equisolid, Fisheye::Orthographic] {
            any_model(ideal, NoDistortion, v);
        }
        if let Ok(lens) = FieldOfView::new(a) { any_model(lens, NoDistortion, v); }
        if let Ok(lens) = Division::new(a) { any_model(lens, NoDistortion, v); }
        if let Ok(lens) = UnifiedSphere::new(a) { any_model(lens, NoDistortion, v); }
        if let Ok(lens) = EnhancedUnified::new(a, b) { any_model(lens, NoDistortion, v); }
        if let Ok(lens) = DoubleSphere::new(a, b) { any_model(lens, NoDistortion, v); }
        any_model(Panorama::Equirectangular, NoDistortion, v);
        any_model(Panorama::Cylindrical, NoDistortion, v);
    }
}
