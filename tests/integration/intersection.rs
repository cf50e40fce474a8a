//! Points from rays and pictures.

use collinear::adjust::{
    ImageObservation, IntersectionOptions, Precision, intersect, nearest_point,
};
use collinear::camera::{CentralModel, Orthographic, SensorModel};
use collinear::geometry::rotation::{PhiOmegaKappa, camera_from_photo};
use collinear::geometry::{Affine2, HeightCurve, Locus, Ray};
use collinear::numeric::robust_loss::RobustLoss;
use collinear::{Error, ExteriorOrientation, Frame, InteriorOrientation, ProjectionError};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Point2, Point3, Rotation3, Vector3};

use crate::support::{numbers, points3};

fn oracle() -> serde_json::Value {
    serde_json::from_str(include_str!("../data/oracles/intersection.json")).unwrap()
}

fn camera(value: &serde_json::Value) -> Frame<InteriorOrientation> {
    let rotation = Matrix3::from_row_slice(&numbers(&value["rotation"]));
    let exterior = ExteriorOrientation::new(
        points3(&value["center"])[0],
        Rotation3::from_matrix_unchecked(rotation),
    );
    let i = numbers(&value["interior"]);
    let interior = InteriorOrientation::new([i[0], i[1]], Point2::new(i[3], i[4]), i[2]).unwrap();
    Frame::new(exterior, interior)
}

#[test]
fn minima_and_covariances_are_those_of_40_digits() {
    for (number, case) in oracle()["cases"].as_array().unwrap().iter().enumerate() {
        let cameras: Vec<_> = case["cameras"].as_array().unwrap().iter().map(camera).collect();
        let observations: Vec<_> = cameras
            .iter()
            .zip(case["images"].as_array().unwrap())
            .zip(case["covariances"].as_array().unwrap())
            .map(|((camera, image), covariance)| {
                let precision =
                    Precision::Covariance(Matrix2::from_row_slice(&numbers(covariance)));
                ImageObservation::new(camera, Point2::from_slice(&numbers(image)))
                    .with_precision(precision)
            })
            .collect();
        let found = intersect(&observations, &IntersectionOptions::default()).unwrap();
        let (report, solution) = (&found.report, &case["solution"]);
        let cofactor = Matrix3::from_row_slice(&numbers(&solution["cofactor"]));
        let expected = points3(&solution["point"])[0];
        // Rounding in units of the point's own standard deviation for unit weight.
        let shift = found.point - expected;
        let (scale, largest) = (cofactor.trace().sqrt(), expected.coords.amax());
        assert!(shift.norm() < 1e-9 * scale + 4.0 * f64::EPSILON * largest, "{number} {shift}");
        let sigma0 = solution["sigma0"].as_f64().unwrap();
        let ratio = report.sigma0.unwrap() / sigma0 - 1.0;
        assert!(ratio.abs() < 1e-8 || sigma0 < 1e-3 && ratio.abs() < 1e-4, "{number} {ratio:e}");
        let covariance = Matrix3::from_fn(|i, j| report.covariance[(i, j)]);
        let q = covariance / report.sigma.powi(2);
        assert!((q - cofactor).norm() < 1e-7 * cofactor.norm(), "{number} {q}");
        assert_eq!((report.observations, report.unknowns), (2 * cameras.len(), 3));
        assert_eq!(report.redundancy, 2 * cameras.len() - 3);
        let sum = report.redundancy_sum();
        assert!((sum - report.redundancy as f64).abs() < 1e-9, "{number} {sum}");
        assert!(report.convergence.converged);
        for (o, values) in observations.iter().zip(report.values.chunks(2)) {
            let v = o.image - o.sensor.project(&found.point).unwrap();
            assert!(values[0].residual == v.x && values[1].residual == v.y);
        }
        let believed = IntersectionOptions { estimate_sigma: false, ..Default::default() };
        let again = intersect(&observations, &believed).unwrap();
        assert_eq!((again.report.sigma, again.point), (1.0, found.point));
    }
}

#[test]
fn the_nearest_point_to_weighted_rays_is_that_of_40_digits() {
    for case in oracle()["rays"].as_array().unwrap() {
        let rays: Vec<_> = points3(&case["origins"])
            .into_iter()
            .zip(points3(&case["directions"]))
            .map(|(origin, direction)| Ray::new(origin, direction.coords).unwrap())
            .collect();
        let weights = numbers(&case["weights"]);
        let found = nearest_point(&rays, Some(&weights)).unwrap();
        let expected = points3(&case["point"])[0];
        let measure = case["measure"].as_f64().unwrap();
        assert!((found.measure / measure - 1.0).abs() < 1e-8, "{} {measure}", found.measure);
        let range = (expected - rays[0].origin).norm();
        let shift = (found.point - expected).norm() / range;
        let rounding = f64::EPSILON * (1.0 + expected.coords.amax() / range);
        assert!(shift < 16.0 * rounding / measure, "{shift:e} {measure:e}");
        for (ray, (along, off)) in rays.iter().zip(found.along.iter().zip(&found.off)) {
            let foot = ray.at(*along);
            assert!(((foot - found.point).norm() - off).abs() < 1e-8 * range.max(1.0));
        }
    }
}

/// Five points of a stereo pair (Wuhan university's exercise; data and result of the method of projection coefficients as printed by
/// the program AP-Project on GitHub): f = 153.84 mm, angles φ, ω, κ in degrees.
#[test]
fn a_published_stereo_pair() {
    let interior =
        InteriorOrientation::from_photogrammetric(153.84, Point2::origin(), &Affine2::identity())
            .unwrap();
    let camera = |x: f64, y: f64, z: f64, angles: [f64; 3]| {
        let [phi, omega, kappa] = angles.map(f64::to_radians);
        let photo = PhiOmegaKappa { phi, omega, kappa }.photo_from_world();
        let exterior = ExteriorOrientation::new(Point3::new(x, y, z), camera_from_photo() * photo);
        Frame::new(exterior, interior)
    };
    let left = camera(446_257.098, 4_504_892.286, 395.243, [0.1411, -0.2008, -0.3064]);
    let right = camera(446_030.551, 4_504_892.329, 399.197, [0.3450, -0.2117, -0.3381]);
    for (l, r, printed) in [
        (
            (-83.370_16, 5.260_08),
            (5.455_97, 5.119_48),
            (446_046.982_02, 4_504_904.639_62, 5.047_54),
        ),
        (
            (-93.508_81, -81.369_58),
            (-3.527_25, -80.963_30),
            (446_022.744_90, 4_504_687.078_01, 10.049_08),
        ),
        (
            (5.469_40, -89.778_44),
            (94.202_60, -89.326_10),
            (446_270.524_86, 4_504_664.578_06, 11.216_26),
        ),
        (
            (2.854_09, 73.649_57),
            (91.470_99, 72.921_13),
            (446_266.180_49, 4_505_074.958_81, 9.424_98),
        ),
        (
            (-94.220_80, 73.014_47),
            (-4.531_84, 72.224_26),
            (446_022.481_45, 4_505_074.935_52, 7.784_02),
        ),
    ] {
        let image = |p: (f64, f64)| Point2::new(p.0, p.1);
        let printed = Point3::new(printed.0, printed.1, printed.2);
        let found = intersect(
            &[ImageObservation::new(&left, image(l)), ImageObservation::new(&right, image(r))],
            &IntersectionOptions::default(),
        )
        .unwrap();
        // The orientations are poor: rays pass each other by 0.7 to 3.4 in Y, which the printed method halves on the ground.
        assert!((found.point - printed).norm() < 0.1, "{} {printed}", found.point);
    }
}

/// A camera whose lines of sight are given as curves over height, as an RPC gives them.
#[derive(Debug)]
struct Curved(Frame<InteriorOrientation>);

impl SensorModel for Curved {
    fn project(&self, world: &Point3<f64>) -> Result<Point2<f64>, ProjectionError> {
        self.0.project(world)
    }
    fn project_jacobian(
        &self,
        world: &Point3<f64>,
    ) -> Result<(Point2<f64>, Matrix2x3<f64>), ProjectionError> {
        self.0.project_jacobian(world)
    }
    fn locus(&self, image: &Point2<f64>) -> Result<Locus, ProjectionError> {
        let direction = self.0.camera.direction(image)?;
        let down = self.0.exterior.camera_from_world().inverse() * direction;
        let center = self.0.exterior.projection_center();
        let slope = down / down.z;
        Ok(Locus::Curve(HeightCurve {
            coefficients: [
                center.coords + slope * (50.0 - center.z),
                slope,
                Vector3::new(1e-4, 0.0, 0.0),
                Vector3::zeros(),
            ],
            reference_height: 50.0,
            heights: [0.0, 100.0],
            error_bound: 0.3,
        }))
    }
}

fn above(x: f64, y: f64) -> Frame<InteriorOrientation> {
    let interior = InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap();
    let center = Point3::new(x, y, 500.0);
    let exterior =
        ExteriorOrientation::look_at(center, Point3::new(0.0, 0.0, 20.0), Vector3::y()).unwrap();
    Frame::new(exterior, interior)
}

#[test]
fn sensors_of_any_kind_intersect() {
    let truth = Point3::new(12.0, -7.0, 33.0);
    let (frame, curved) = (above(-200.0, 10.0), Curved(above(250.0, -30.0)));
    let oblique = ExteriorOrientation::look_at(
        Point3::new(0.0, -300.0, 300.0),
        Point3::origin(),
        Vector3::z(),
    )
    .unwrap();
    let parallel =
        Orthographic::new(oblique, Affine2::from_coefficients([100.0, 2.0, 0.0], [50.0, 0.0, 2.0]))
            .unwrap();
    let sensors: [&dyn SensorModel; 3] = [&frame, &curved, &parallel];
    let seen: Vec<_> =
        sensors.iter().map(|s| ImageObservation::new(*s, s.project(&truth).unwrap())).collect();
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let found = intersect(&[seen[i], seen[j]], &IntersectionOptions::default()).unwrap();
        assert!((found.point - truth).norm() < 1e-9, "{i} {j} {}", found.point);
    }
    let found = intersect(&seen, &IntersectionOptions::default()).unwrap();
    assert!((found.point - truth).norm() < 1e-9, "{}", found.point);
}

#[test]
fn a_loss_leaves_a_wrong_match_out() {
    let truth = Point3::new(12.0, -7.0, 33.0);
    let cameras: Vec<_> = (0..6)
        .map(|i| above(f64::from(i) * 80.0 - 200.0, f64::from(i % 3) * 60.0 - 50.0))
        .collect();
    let mut seen: Vec<_> =
        cameras.iter().map(|c| ImageObservation::new(c, c.project(&truth).unwrap())).collect();
    seen[2].image.x += 8.0;
    let plain = intersect(&seen, &IntersectionOptions::default()).unwrap();
    assert!((plain.point - truth).norm() > 0.3);
    assert_eq!(plain.report.most_suspect(), Some(4));
    let robust =
        IntersectionOptions { loss: RobustLoss::Cauchy { scale: 0.1 }, ..Default::default() };
    let found = intersect(&seen, &robust).unwrap();
    assert!((found.point - truth).norm() < 0.01, "{}", found.point);
    // Weights of the loss are variances to the report: the redundancy numbers still add up.
    assert!((found.report.redundancy_sum() - 9.0).abs() < 1e-9);
    assert!(found.report.values[4].redundancy > 0.99);
}

#[test]
fn what_has_no_point_is_refused() {
    let ray = |o: [f64; 3], d: [f64; 3]| Ray::new(Point3::from(o), Vector3::from(d)).unwrap();
    let degenerate = |rays: &[Ray], words: &str| match nearest_point(rays, None) {
        Err(Error::Degenerate { what, measure, limit }) => {
            assert!(what.contains(words) && measure <= limit, "{what} {measure}");
        }
        other => panic!("{words} {other:?}"),
    };
    let up = [0.1, 0.2, 1.0];
    degenerate(
        &[ray([0.0; 3], up), ray([1.0, 0.0, 0.0], up), ray([5.0, 1.0, 2.0], up)],
        "parallel",
    );
    degenerate(&[ray([0.0; 3], up), ray([1.0, 0.0, 0.0], [-0.1, -0.2, -1.0])], "parallel");
    let far = [4e6, 5e6, 100.0];
    let beside = [4e6 + 1.0, 5e6, 100.0];
    degenerate(&[ray(far, up), ray(beside, [0.1, 0.2, 1.0 + 1e-10])], "parallel");
    degenerate(&[ray([1.0; 3], up), ray([1.0; 3], [1.0, 0.0, 0.0])], "one place");
    // The second ray diverges from the first: they would meet 10 behind, √(100 + 1) along the second.
    let error = nearest_point(
        &[ray([0.0; 3], [0.0, 0.0, 1.0]), ray([1.0, 0.0, 0.0], [0.1, 0.0, 1.0])],
        None,
    );
    match error {
        Err(Error::Projection(ProjectionError::BehindCamera { depth })) => {
            assert!((depth + 10.0).abs() < 1e-12, "{depth}");
        }
        other => panic!("{other:?}"),
    }
    let two = [ray([0.0; 3], up), ray([1.0, 0.0, 0.0], [-0.1, 0.2, 1.0])];
    assert_eq!(
        nearest_point(&two[..1], None).unwrap_err(),
        Error::TooFewPoints { needed: 2, got: 1 }
    );
    assert_eq!(
        nearest_point(&two, Some(&[1.0])).unwrap_err(),
        Error::LengthMismatch { what: "rays and weights", left: 2, right: 1 }
    );
    for bad in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(matches!(
            nearest_point(&two, Some(&[1.0, bad])),
            Err(Error::OutOfRange { what: "weight of a ray", .. })
        ));
    }

    let (a, b) = (above(-100.0, 0.0), above(100.0, 0.0));
    let options = IntersectionOptions::default();
    let at = |camera, x: f64, y: f64| ImageObservation::new(camera, Point2::new(x, y));
    assert_eq!(
        intersect(&[at(&a, 1.0, 2.0)], &options).unwrap_err(),
        Error::TooFewPoints { needed: 2, got: 1 }
    );
    assert_eq!(
        intersect(&[at(&a, 1.0, 2.0), at(&b, f64::NAN, 2.0)], &options).unwrap_err(),
        Error::NotFinite { what: "image point" }
    );
    let bad = at(&b, 1.0, 2.0).with_precision(Precision::Sigma(0.0));
    assert!(matches!(intersect(&[at(&a, 1.0, 2.0), bad], &options), Err(Error::OutOfRange { .. })));
    // The same picture twice.
    let twice = [at(&a, 1.0, 2.0), at(&a, 1.5, 2.0)];
    assert!(matches!(intersect(&twice, &options), Err(Error::Degenerate { .. })));
    // A star.
    let star = Vector3::new(0.1, 0.2, 1.0);
    let pixel = |c: &Frame<InteriorOrientation>| {
        c.camera.project_direction(&(c.exterior.camera_from_world() * -star)).unwrap()
    };
    let stars = [ImageObservation::new(&a, pixel(&a)), ImageObservation::new(&b, pixel(&b))];
    match intersect(&stars, &options) {
        // Rounded pixels may also let the rays meet very far away, on either side.
        Err(Error::Degenerate { .. } | Error::Projection(_)) => {}
        Ok(found) => assert!(found.point.coords.norm() > 1e12, "{}", found.point),
        other => panic!("{other:?}"),
    }
    // Lines of sight that run apart meet behind the cameras.
    let apart = [at(&a, 100.0, 400.0), at(&b, 900.0, 400.0)];
    match intersect(&apart, &options) {
        Err(Error::Projection(ProjectionError::BehindCamera { depth })) => assert!(depth < 0.0),
        other => panic!("{other:?}"),
    }
}
