//! Space resection against textbooks and against optima in 50 digits, whose script shares nothing with the crate.

use collinear::adjust::{
    CRITICAL_VALUE, ControlPoint, NONCENTRALITY, ObservationReport, OtherPose, Precision,
    Resection, ResectionOptions, Unknown, resect, resect_from,
};
use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralCamera, CentralModel, ExteriorOrientation, Fisheye,
    Frame, InteriorOrientation, Panorama,
};
use collinear::geometry::Affine2;
use collinear::geometry::rotation::{PhiOmegaKappa, RotationVector, camera_from_photo};
use collinear::numeric::robust_loss::RobustLoss;
use nalgebra::{DMatrix, DVector, Matrix3, Point2, Point3, Rotation3, SMatrix, Vector3};
use serde_json::Value;

use crate::support::numbers;

fn lists(v: &Value) -> Vec<Vec<f64>> {
    v.as_array().unwrap().iter().map(numbers).collect()
}

/// A scene of the oracle.
#[derive(Clone)]
struct Scene {
    name: String,
    camera: Value,
    control: Vec<ControlPoint>,
    options: ResectionOptions,
    best: Value,
    other: Value,
}

fn read(list: &str) -> Vec<Scene> {
    let all: Value = serde_json::from_str(include_str!("../data/oracles/resection.json")).unwrap();
    all[list].as_array().unwrap().iter().map(scene).collect()
}

fn named(list: &str, name: &str) -> Scene {
    read(list).into_iter().find(|s| s.name == name).unwrap()
}

fn scene(v: &Value) -> Scene {
    let (objects, images) = (lists(&v["objects"]), lists(&v["images"]));
    let control = objects.iter().zip(&images).enumerate().map(|(i, (x, p))| {
        let mut point = ControlPoint::new(Point3::from_slice(x), Point2::from_slice(p));
        if let Some(c) = v["cov"].get(i) {
            point = point.with_precision(covariance(&numbers(c)));
        }
        if let Some(c) = v["ocov"].get(i).filter(|c| !c.is_null()) {
            point = point.with_object_precision(covariance(&numbers(c)));
        }
        point
    });
    let mut options = ResectionOptions::default();
    for unknown in v["unknowns"].as_array().into_iter().flatten() {
        let chosen = match unknown[0].as_str().unwrap() {
            "f" => Unknown::together(1, &[0, 1]),
            _ => Unknown::parameter(2, 0),
        };
        let sigma = unknown[2].as_f64();
        options.unknowns.push(sigma.map_or_else(|| chosen.clone(), |s| chosen.clone().observed(s)));
    }
    if let Some(kind) = v["loss"][0].as_str() {
        let scale = v["loss"][1].as_f64().unwrap();
        options.loss = match kind {
            "huber" => RobustLoss::Huber { scale },
            _ => RobustLoss::Cauchy { scale },
        };
    }
    options.estimate_sigma = v["believe"] != true;
    Scene {
        name: v["name"].as_str().unwrap().to_owned(),
        camera: v["camera"].clone(),
        control: control.collect(),
        options,
        best: v["best"].clone(),
        other: v["other"].clone(),
    }
}

/// The simplest way to say it, so that each kind of precision is met.
fn covariance<const N: usize>(c: &[f64]) -> Precision<N> {
    let c = SMatrix::<f64, N, N>::from_row_slice(c);
    if c != SMatrix::from_diagonal(&c.diagonal()) {
        return Precision::Covariance(c);
    }
    if c.diagonal().iter().all(|v| *v == c[(0, 0)] && *v != 1.0) {
        return Precision::Weight(1.0 / c[(0, 0)]);
    }
    Precision::Sigmas(c.diagonal().map(f64::sqrt).into())
}

fn pose(v: &Value) -> ExteriorOrientation {
    let rotation = Matrix3::from_row_slice(&numbers(&v["rotation"]));
    ExteriorOrientation::new(
        Point3::from_slice(&numbers(&v["center"])),
        Rotation3::from_matrix_unchecked(rotation),
    )
}

/// Centre and left rotation vector of a pose as seen from another.
fn deviation(found: &ExteriorOrientation, from: &ExteriorOrientation) -> [f64; 6] {
    let turn = RotationVector::from_rotation(
        &(found.camera_from_world() * from.camera_from_world().inverse()),
    );
    let (c, r) = (found.projection_center() - from.projection_center(), turn.vector());
    [c.x, c.y, c.z, r.x, r.y, r.z]
}

/// The largest errors of a scene, each as a part of what is allowed.
#[derive(Default)]
struct Worst(Vec<(String, f64)>);

impl Worst {
    fn see(&mut self, what: &str, error: f64, allowed: f64) {
        let share = error.abs() / allowed;
        match self.0.iter_mut().find(|w| w.0 == what) {
            Some(w) if w.1 >= share => {}
            Some(w) => w.1 = share,
            None => self.0.push((what.to_owned(), share)),
        }
    }

    /// Panics where an error is not below what is allowed.
    fn judge(&self, name: &str) {
        println!("{name}: {:?}", self.0);
        let wrong: Vec<_> = self.0.iter().filter(|w| !(w.1 <= 1.0)).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:?}");
    }
}

/// Everything that a resection says, beside the oracle.
fn check<C: CentralModel + Adjustable + Clone>(
    scene: &Scene,
    found: &Resection<Frame<C>>,
    extra: &[f64],
) {
    let (best, report) = (&scene.best, &found.report);
    let mut worst = Worst::default();
    let of = |key: &str| best[key].as_f64().unwrap();
    let (cost, condition) = (of("cost"), of("condition"));
    let sd = numbers(&best["sd"]);
    let u = sd.len();
    let mut off: Vec<f64> = deviation(&found.sensor.exterior, &pose(best)).into();
    off.extend(extra.iter().zip(numbers(&best["extra"])).map(|(a, b)| a - b));
    assert_eq!((off.len(), report.covariance.nrows()), (u, u), "{}", scene.name);

    // The excess of the cost over the optimum, by the oracle's own curvature there.
    let corr = numbers(&best["corr"]);
    let correlation = |i: usize, j: usize| match i.cmp(&j) {
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => corr[i * (i - 1) / 2 + j],
        std::cmp::Ordering::Less => corr[j * (j - 1) / 2 + i],
    };
    let sigma = if scene.options.estimate_sigma { of("sigma0") } else { 1.0 };
    let unit = DVector::from_fn(u, |i, _| off[i] / (sd[i] / sigma));
    let curvature = DMatrix::from_fn(u, u, correlation).try_inverse().unwrap();
    let excess = 0.5 * unit.dot(&(&curvature * &unit));
    let floor = 2.0 * scene.control.len() as f64 * (f64::EPSILON * 1280.0).powi(2);
    worst.see("excess", excess, 1e-12 * cost + floor);
    for (d, s) in off.iter().zip(&sd) {
        // What the same excess allows to one unknown.
        worst.see("pose", *d, s / sigma * (2e-12 * cost + 2.0 * floor).sqrt());
    }

    // Q at a pose that is as far off, where an unknown of a large deviation bends it, from normal equations of this condition.
    let bent = sd.iter().fold(1e-2, |a: f64, b| a.max(*b)).min(1.0);
    let relative = 1e-6 * bent + 4.0 * condition * f64::EPSILON;
    // Residuals are rounded to some 10⁻¹³ of their standard deviation, whatever their size.
    let rounded = 1e-11 + 1e-12 / of("sigma0");
    worst.see("cost", report.convergence.final_cost / cost - 1.0, rounded);
    // The weighted sum is not what a loss minimises: it moves with the pose, as the weights do.
    let robust = scene.options.loss != RobustLoss::Squared;
    let (relative, rounded) = if robust { (1e-6, 1e-7) } else { (relative, rounded) };
    worst.see("vPv", report.weighted_sum / of("squares") - 1.0, rounded);
    worst.see("sigma0", report.sigma0.unwrap() / of("sigma0") - 1.0, rounded);
    worst.see("sigma", report.sigma / sigma - 1.0, rounded);
    worst.see("condition", report.condition / condition - 1.0, 10.0 * relative);
    for i in 0..u {
        worst.see("sd", report.standard_deviation(i) / sd[i] - 1.0, relative + rounded);
        for j in 0..u {
            worst.see("correlation", report.correlation(i, j) - correlation(i, j), relative);
        }
    }
    if best["angles"].is_array() {
        let angles = numbers(&best["angles"]);
        let here = found.sensor.exterior.omega_phi_kappa();
        let covariance = found.omega_phi_kappa_covariance().unwrap();
        for (i, angle) in [here.omega, here.phi, here.kappa].into_iter().enumerate() {
            worst.see("angle", angle - angles[2 * i], 1e-7 * angles[2 * i + 1]);
            let sd = covariance[(i, i)].sqrt();
            worst.see("sd of angle", sd / angles[2 * i + 1] - 1.0, relative + rounded);
        }
    }
    let redundancy = best["redundancy"].as_u64().unwrap() as usize;
    assert_eq!(report.redundancy, redundancy, "{}", scene.name);
    assert_eq!(report.observations - report.unknowns, redundancy, "{}", scene.name);
    worst.see("sum of r", report.redundancy_sum() - redundancy as f64, 1e-9);
    let squares: f64 = report.values.iter().map(|v| v.weighted_square).sum();
    worst.see("sum of squares", squares - report.weighted_sum, 1e-9 * report.weighted_sum + 1e-12);

    let values = lists(&best["values"]);
    for (i, (value, v)) in report.values.iter().zip(&values).enumerate() {
        let ObservationReport { residual, redundancy, w, detectable, influence, .. } = *value;
        let v: [f64; 5] = v.as_slice().try_into().unwrap();
        // A residual that the others hardly control is known as its redundancy number is.
        let relative = relative * (1.0 + 1.0 / v[1]);
        worst.see("residual", residual - v[0], 1e-6 * (sigma + v[0].abs()));
        worst.see("redundancy", redundancy - v[1], relative * v[1].max(1e-3));
        let of_residual = 1e-8 / v[1].sqrt();
        worst.see("w", w - v[2], of_residual + (relative + rounded) * (10.0 + v[2].abs()));
        worst.see("detectable", detectable / v[3] - 1.0, relative + rounded);
        worst.see("influence", influence - v[4], relative * (10.0 + v[4]));
        assert!(w.is_finite(), "{} {i}", scene.name);
    }
    if !values.is_empty() {
        assert_eq!(report.values.len(), values.len(), "{}", scene.name);
        assert_eq!(report.observations, values.len(), "{}", scene.name);
        let suspect =
            (0..values.len()).max_by(|a, b| values[*a][2].abs().total_cmp(&values[*b][2].abs()));
        assert_eq!(report.most_suspect(), suspect, "{}", scene.name);
        let mut next = 0;
        for (i, control) in scene.control.iter().enumerate() {
            let image = found.image_report(i).unwrap();
            assert_eq!(image[..], report.values[next..next + 2], "{} {i}", scene.name);
            next += 2;
            let object = found.object_report(i);
            assert_eq!(object.is_some(), control.object_precision.is_some(), "{}", scene.name);
            if let Some(object) = object {
                assert_eq!(object[..], report.values[next..next + 3], "{} {i}", scene.name);
                next += 3;
            }
        }
        assert_eq!(found.image_report(scene.control.len()), None);
        assert_eq!(found.object_report(scene.control.len()), None);
    }
    worst.judge(&scene.name);
}

fn interior(camera: &Value) -> InteriorOrientation {
    let of = |key: &str| camera[key].as_f64().unwrap();
    let (f, fy, principal) = (of("f"), of("fy"), Point2::new(of("x0"), of("y0")));
    if fy < 0.0 {
        return InteriorOrientation::from_photogrammetric(f, principal, &Affine2::identity())
            .unwrap();
    }
    InteriorOrientation::new([f, fy], principal, 0.0).unwrap()
}

fn solve_and_check(scene: &Scene) -> (ExteriorOrientation, Option<OtherPose>) {
    fn solve<C: CentralModel + Adjustable + Clone>(
        scene: &Scene,
        camera: &C,
        extra: impl Fn(&C) -> Vec<f64>,
    ) -> (ExteriorOrientation, Option<OtherPose>) {
        let found = resect(camera, &scene.control, &scene.options).unwrap();
        check(scene, &found, &extra(&found.sensor.camera));
        // From near by the same, whatever the camera.
        if scene.options.unknowns.len() == 1 {
            let moved = ExteriorOrientation::new(
                found.sensor.exterior.projection_center() + Vector3::new(1e-3, -2e-3, 1e-3),
                Rotation3::new(Vector3::new(1e-4, 2e-4, -1e-4))
                    * found.sensor.exterior.camera_from_world(),
            );
            let start = Frame::new(moved, camera.clone());
            let again = resect_from(&start, &scene.control, &scene.options).unwrap();
            check(scene, &again, &[]);
            assert_eq!(again.other, None);
        }
        (found.sensor.exterior, found.other)
    }
    let interior = interior(&scene.camera);
    match scene.camera["kind"].as_str().unwrap() {
        "brown" => {
            let k1 = scene.camera["k1"].as_f64().unwrap();
            let camera = BrownCamera::new(interior, Brown::new([k1, 0.0, 0.0], [0.0; 2]).unwrap());
            solve(scene, &camera, |c| {
                let mut lens = [0.0; 5];
                c.parameters(1, &mut lens);
                let [fx, fy] = c.interior().principal_distance();
                assert!((fy / fx - 0.99).abs() < 1e-15 && lens[1..] == [0.0; 4]);
                vec![fx, lens[0]]
            })
        }
        "fisheye" => {
            let camera = CentralCamera::ideal(interior, Fisheye::Equidistant);
            solve(scene, &camera, |_| Vec::new())
        }
        "panorama" => {
            let camera = CentralCamera::ideal(interior, Panorama::Equirectangular);
            solve(scene, &camera, |_| Vec::new())
        }
        _ => solve(scene, &interior, |_| Vec::new()),
    }
}

#[test]
fn every_scene_is_at_its_optimum_in_50_digits_with_its_whole_report() {
    let scenes = read("scenes");
    assert_eq!(scenes.len(), 32);
    for scene in scenes {
        solve_and_check(&scene);
    }
}

#[test]
fn textbook_cases_are_at_their_optimum_in_raw_and_in_shifted_coordinates() {
    for scene in read("textbook") {
        let (found, _) = solve_and_check(&scene);
        let best = pose(&scene.best).projection_center();
        let off = (found.projection_center() - best).amax();
        assert!(off < 1e-6, "{}: {off}", scene.name);
        let shift = Vector3::new(1e6, -3e6, 2e6);
        let mut moved = scene.clone();
        for point in &mut moved.control {
            point.object += shift;
        }
        let found = resect(&interior(&scene.camera), &moved.control, &scene.options).unwrap();
        let off = (found.sensor.exterior.projection_center() - shift - best).amax();
        println!("{} shifted: {off:e}", scene.name);
        assert!(off < 1e-6, "{} shifted: {off}", scene.name);
    }
}

/// Wuhan University's Photogrammetry (Yuan Xiuxiao's course, parts 28 to 30; the repository richardhyy/SpaceResection): φ, ω, κ,
/// the centre to a centimetre and σ₀.
#[test]
fn the_four_points_of_wuhan_give_the_printed_orientation() {
    let scene = named("textbook", "Wuhan");
    let found = resect(&interior(&scene.camera), &scene.control, &scene.options).unwrap();
    let exterior = found.sensor.exterior;
    let off = exterior.projection_center() - Point3::new(39795.45, 27476.46, 7572.69);
    assert!(off.amax() <= 0.005, "{off}");
    let photo = camera_from_photo().inverse() * exterior.camera_from_world();
    let PhiOmegaKappa { phi, omega, kappa } = PhiOmegaKappa::from_photo_from_world(&photo);
    for (angle, printed) in [(phi, -0.003_986_9), (omega, 0.002_113_9), (kappa, -0.067_578_0)] {
        assert!((angle - printed).abs() < 1e-7, "{angle} for {printed}");
    }
    assert!((found.report.sigma0.unwrap() - 0.007_26).abs() < 5e-6);
}

/// Mikhail, Bethel & McGlone 2001, Introduction to Modern Photogrammetry: five points in state-plane coordinates, as in the
/// repository jeffwalton/photogrammetry-resection, whose notebook prints scipy's solutions and the sum of squares.
#[test]
fn the_five_points_of_mikhail_give_the_printed_orientation() {
    let scene = named("textbook", "Mikhail");
    let found = resect(&interior(&scene.camera), &scene.control, &scene.options).unwrap();
    let exterior = found.sensor.exterior;
    let printed = Point3::new(914_260.421_862_754_2, 575_441.835_551_956_3, 839.130_437_234_130_8);
    let off = (exterior.projection_center() - printed).amax();
    assert!(off < 1e-6, "{off}");
    let angles = exterior.omega_phi_kappa();
    for (angle, printed) in [
        (angles.omega, -0.006_507_481_143_624_354),
        (angles.phi, -0.008_521_803_654_879_007),
        (angles.kappa, -1.575_322_123_689_650_9),
    ] {
        assert!((angle - printed).abs() < 1e-9, "{angle} for {printed}");
    }
    assert!((found.report.weighted_sum - 0.000_751_104_878_973_308).abs() < 1e-15);
}

/// Pope 1976; and the constants by the error function in 50 digits, √2 erf⁻¹(0.999) and √2 erf⁻¹(0.6) more.
#[test]
fn popes_tau_does_not_exceed_the_root_of_the_redundancy() {
    for scene in read("scenes").into_iter().filter(|s| s.camera["kind"] == "frame") {
        let found = resect(&interior(&scene.camera), &scene.control, &scene.options).unwrap();
        if scene.options.estimate_sigma {
            let limit = (found.report.redundancy as f64).sqrt() * (1.0 + 1e-6);
            assert!(found.report.values.iter().all(|v| v.w.abs() <= limit), "{}", scene.name);
        }
        for (i, v) in found.report.values.iter().enumerate() {
            // The blunder that is found moves w by δ₀: its own share rᵢ of it, over σ √rᵢ, where nothing is correlated.
            let sigma = found.report.sigma;
            if let Some(Precision::Sigmas([a, _])) = scene.control.get(i / 2).map(|c| c.precision)
                && scene.control.iter().all(|c| c.object_precision.is_none())
            {
                let moved = v.detectable * v.redundancy / (sigma * a * v.redundancy.sqrt());
                assert!((moved - 4.132_147_965_064_809).abs() < 1e-9, "{} {moved}", scene.name);
            }
        }
    }
    assert!((CRITICAL_VALUE - 3.290_526_731_491_895).abs() < 1e-15);
    assert!((NONCENTRALITY - 4.132_147_965_064_809).abs() < 1e-15);
}

#[test]
fn both_solutions_of_the_planar_ambiguity_are_minima_and_other_is_the_second() {
    let scenes: Vec<Scene> = read("scenes").into_iter().filter(|s| !s.other.is_null()).collect();
    assert_eq!(scenes.len(), 3);
    for scene in scenes {
        let camera = interior(&scene.camera);
        let found = resect(&camera, &scene.control, &scene.options).unwrap();
        let other = found.other.unwrap();
        let cost = scene.other["cost"].as_f64().unwrap();
        assert!((other.cost / cost - 1.0).abs() < 1e-11, "{} {}", scene.name, other.cost);
        assert!(other.cost > found.report.convergence.final_cost);
        // Of a distance of 16, where the standard deviations are some tenths.
        let off = deviation(&other.exterior, &pose(&scene.other));
        assert!(off.iter().all(|d| d.abs() < 1e-7), "{}: {off:?}", scene.name);
        // Another start there stays there.
        let start = Frame::new(other.exterior, camera);
        let stays = resect_from(&start, &scene.control, &scene.options).unwrap();
        let off = deviation(&stays.sensor.exterior, &pose(&scene.other));
        assert!(off.iter().all(|d| d.abs() < 1e-7), "{}: {off:?}", scene.name);
    }
}
