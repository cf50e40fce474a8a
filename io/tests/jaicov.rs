//! A close-range block with the protocol of a commercial adjustment: the example of JAICOV, which is no part of this
//! repository.
//!
//! 115 photographs of one camera, 150 points, 9972 image points of σ = 0.5 µm and one scale bar; a free network with inner
//! constraints over the points. The protocol (AICON, *Bündelblockausgleichung* 1.10.10): 19,945 observations, 1147 unknowns,
//! 6 conditions, redundancy 18,804.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use collinear::adjust::bundle::{Bundle, BundleOptions, BundleReportOptions, Datum, PointId};
use collinear::adjust::{Precision, Unknown};
use collinear::geometry::rotation::camera_from_photo;
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::{Brown, BrownCamera, ExteriorOrientation, InteriorOrientation};

/// The numbers of each line that has only numbers, of a plain or a gzip file.
fn table(path: &Path) -> Vec<Vec<f64>> {
    let bytes = std::fs::read(path).unwrap();
    let mut text = String::new();
    if path.extension().is_some_and(|e| e == "gz") {
        flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text).unwrap();
    } else {
        text = String::from_utf8(bytes).unwrap();
    }
    let line = |l: &str| l.split_whitespace().map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
    text.lines().filter_map(line).filter(|l| !l.is_empty()).collect()
}

/// The protocol's standard deviations of the projection centres: lines of photograph, camera, X, Y, Z, their deviations, rays.
fn centre_deviations(path: &Path) -> Vec<(u32, [f64; 3])> {
    let mut bytes = Vec::new();
    let file = std::fs::read(path).unwrap();
    flate2::read::GzDecoder::new(&file[..]).read_to_end(&mut bytes).unwrap();
    let mut text = String::new();
    let mut in_tag = false;
    for c in bytes.into_iter().map(char::from) {
        match c {
            '<' => in_tag = true,
            '>' => (in_tag, text) = (false, text + " "),
            c if !in_tag => text.push(c),
            _ => {}
        }
    }
    let section = text.split("Objektpunkte ***").next().unwrap();
    let row = |l: &str| l.split_whitespace().map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>();
    let nine = section.lines().filter_map(row).filter(|r| r.len() == 9 && r[1] == 1.0);
    nine.map(|r| (r[0] as u32, [r[5], r[6], r[7]])).collect()
}

/// Radius of no radial distortion, mm.
const BALANCE: f64 = 13.488;
/// Affinity and shear, held.
const C1: f64 = -7.008_010e-5;
const C2: f64 = -3.126_270e-5;

/// (c, A₁, A₂) of f, k₁ and k₂: the protocol's lens is balanced, u (1 + A₁ (r² − r₀²) + A₂ (r⁴ − r₀⁴)) with u = c X/Z.
fn balanced([f, k1, k2]: [f64; 3]) -> [f64; 3] {
    let mut c = f;
    let mut a = [0.0; 2];
    for _ in 0..50 {
        let raised = f / c;
        a = [k1 * raised / (c * c), k2 * raised / c.powi(4)];
        c = f / (1.0 - a[0] * BALANCE.powi(2) - a[1] * BALANCE.powi(4));
    }
    [c, a[0], a[1]]
}

#[test]
fn a_protocol_is_reproduced() {
    let Some(folder) = crate::shared_data("bal/jaicov") else { return };
    let (c, x0, y0) = (28.785, 0.0173, 0.0567);
    let (a1, a2, b1, b2) = (-1.09e-4, 1.49e-7, 5.7e-6, -8.6e-6);
    let raised = 1.0 - a1 * BALANCE.powi(2) - a2 * BALANCE.powi(4);
    // y down: the signs of y₀, of the shear and of B₂ change.
    let axes = Matrix3::new(c * (raised + C1), -c * C2, x0, 0.0, c * raised, -y0, 0.0, 0.0, 1.0);
    let interior = InteriorOrientation::from_matrix(&axes).unwrap();
    let k = [a1 * c * c / raised, a2 * c.powi(4) / raised, 0.0];
    let lens = Brown::new(k, [-b2 * c / raised, b1 * c / raised]).unwrap();
    let mut bundle = Bundle::new();
    let unknowns = [
        Unknown::together(0, &[0, 1, 4]),
        Unknown::parameter(0, 2),
        Unknown::parameter(0, 3),
        Unknown::parameter(1, 0),
        Unknown::parameter(1, 1),
        Unknown::parameter(1, 3),
        Unknown::parameter(1, 4),
    ];
    let camera = bundle.add_camera(BrownCamera::new(interior, lens), &unknowns).unwrap();
    let mut images = BTreeMap::new();
    for row in table(&folder.join("example.eor")).iter().filter(|r| r.len() >= 8) {
        let [x, y, z, omega, phi, kappa] = [2, 3, 4, 5, 6, 7].map(|i| row[i]);
        let about = |axis: Vector3<f64>, angle: f64| Rotation3::from_scaled_axis(axis * angle);
        let world_from_photo =
            about(Vector3::x(), omega) * about(Vector3::y(), phi) * about(Vector3::z(), kappa);
        let rotation = camera_from_photo() * world_from_photo.inverse();
        let exterior = ExteriorOrientation::new(Point3::new(x, y, z), rotation);
        images.insert(row[0] as u32, bundle.add_image(exterior, camera).unwrap());
    }
    let mut points: BTreeMap<u32, (PointId, Vec<f64>)> = BTreeMap::new();
    for row in table(&folder.join("example.obc")).into_iter().filter(|r| r.len() >= 7) {
        let point = bundle.add_point(Point3::new(row[1], row[2], row[3])).unwrap();
        points.insert(row[0] as u32, (point, row));
    }
    for row in table(&folder.join("example.phc.gz")).iter().filter(|r| r[9] == 1.0) {
        let Some((point, _)) = points.get(&(row[1] as u32)) else { continue };
        let at = Point2::new(row[2], -row[3]);
        bundle.observe(images[&(row[0] as u32)], *point, at, Precision::Sigma(5e-4)).unwrap();
    }
    bundle.observe_distance([points[&506].0, points[&507].0], 1389.688, 0.01).unwrap();
    let options = BundleOptions::default();
    let adjusted = bundle.adjust(&options).unwrap();
    assert!(adjusted.convergence.converged, "{:?}", adjusted.convergence);
    let how = BundleReportOptions { datum: Datum::Free, estimate_sigma: true };
    let report = bundle.report(&adjusted, &options, &how).unwrap();
    let numbers = (report.observations, report.unknowns, report.conditions, report.redundancy);
    assert_eq!(numbers, (19_945, 1147, 6, 18_804));
    let sigma0 = 5e-4 * report.sigma0.unwrap();
    assert!((sigma0 - 0.000_405).abs() < 5e-7, "{sigma0}");
    // The camera.
    let model = &adjusted.cameras()[0];
    let [k1, k2, _] = model.distortion().radial();
    let found = [model.interior().principal_distance()[1], k1, k2];
    let covariance = report.camera_covariance(camera).unwrap();
    let [c, a1, a2] = balanced(found);
    // By f along y (the unknown is f along x), k₁ and k₂.
    let ratio = found[0] / model.interior().principal_distance()[0];
    let mut by = Matrix3::zeros();
    for i in 0..3 {
        let h = 1e-6 * found[i];
        let mut up = found;
        up[i] += h;
        let moved = balanced(up);
        for (r, (a, b)) in moved.iter().zip([c, a1, a2]).enumerate() {
            by[(r, i)] = (a - b) / h * if i == 0 { ratio } else { 1.0 };
        }
    }
    let places = [0, 3, 4];
    let block = Matrix3::from_fn(|r, c| covariance[(places[r], places[c])]);
    let of_lens = by * block * by.transpose();
    let sigma = |v: f64| v.sqrt();
    let principal = model.interior().principal_point();
    // B₁ = p₂ f/c², B₂ = −p₁ f/c².
    let (tangential, by_p) = (model.distortion().decentering(), found[0] / (c * c));
    let figures = [
        (c, sigma(of_lens.m11), 28.785_07, 2.513_178e-4),
        (principal.x, sigma(covariance[(1, 1)]), 1.734_892e-2, 3.441_658e-4),
        (-principal.y, sigma(covariance[(2, 2)]), 5.668_731e-2, 3.262_600e-4),
        (a1, sigma(of_lens.m22), -1.096_069e-4, 2.978_787e-8),
        (a2, sigma(of_lens.m33), 1.495_660e-7, 7.655_524e-11),
        (tangential[1] * by_p, by_p * sigma(covariance[(6, 6)]), 5.798_428e-6, 1.190_972e-7),
        (-tangential[0] * by_p, by_p * sigma(covariance[(5, 5)]), -8.644_540e-6, 1.043_919e-7),
    ];
    // Its iteration ended a tenth of a standard deviation from the minimum.
    for (value, sigma, expected, expected_sigma) in figures {
        assert!((value - expected).abs() < 0.2 * expected_sigma, "{value} {expected}");
        assert!((sigma / expected_sigma - 1.0).abs() < 0.002, "{sigma} {expected_sigma}");
    }
    // Four decimals are printed. Of photographs 48 and 54, with five rays each, the protocol has residuals whose squares sum to
    // more than the minimum's, some zero and some of 7 σ: it weighed them otherwise. They and their points differ, nothing else.
    let odd = [12, 27, 41, 46, 49, 60, 85];
    let (mut off, mut count, mut worst, mut worst_odd) = (0.0_f64, 0, 0.0_f64, 0.0_f64);
    for (number, (point, row)) in &points {
        let covariance = report.point_covariance(*point).unwrap();
        if row[7] == 0.0 || covariance.norm() == 0.0 {
            continue;
        }
        count += 1;
        let place = Point3::new(row[1], row[2], row[3]);
        off = off.max((adjusted.point(*point).unwrap() - place).norm());
        for axis in 0..3 {
            let apart = (covariance[(axis, axis)].sqrt() - row[4 + axis]).abs();
            let worst = if odd.contains(number) { &mut worst_odd } else { &mut worst };
            *worst = worst.max(apart);
        }
    }
    assert_eq!(count, 150);
    assert!(worst < 5.1e-5 && worst_odd < 3.2e-4, "{worst} {worst_odd}");
    let (mut count, mut apart) = (0, 0.0_f64);
    for (number, printed) in centre_deviations(&folder.join("example.htm.gz")) {
        let covariance = report.image_covariance(images[&number]).unwrap();
        for axis in 0..3 {
            let off = (covariance[(axis, axis)].sqrt() - printed[axis]).abs();
            if ![48, 54].contains(&number) {
                apart = apart.max(off / printed[axis]);
            }
        }
        count += 1;
    }
    assert!(count == 115 && apart < 0.005, "{count} {apart}");
    // The place of a free block is that it started from, to what its shape changed.
    assert!(off < 0.01, "{off}");
}
