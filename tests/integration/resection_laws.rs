//! What space resection keeps for every scene, each law by its name.

use std::f64::consts::PI;

use collinear::adjust::{ControlPoint, Precision, Resection, ResectionOptions, resect};
use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation};
use collinear::geometry::rotation::RotationVector;
use nalgebra::{Point2, Point3, Rotation3, Unit, Vector2, Vector3};
use proptest::prelude::*;

use crate::support::{PlainCamera, exterior, interior, point};

/// A camera, points within its view that are not near a line, and errors of their images.
#[derive(Clone, Debug)]
struct Scene {
    exterior: ExteriorOrientation,
    interior: InteriorOrientation,
    objects: Vec<Point3<f64>>,
    images: Vec<Point2<f64>>,
    noise: Vec<Vector2<f64>>,
}

impl Scene {
    fn control(&self, noise: f64) -> Vec<ControlPoint> {
        let places = self.objects.iter().zip(&self.images).zip(&self.noise);
        places.map(|((x, p), n)| ControlPoint::new(*x, p + n * noise)).collect()
    }
}

/// The images are the test's own: the collinearity equations written out.
fn scene(points: std::ops::Range<usize>) -> impl Strategy<Value = Scene> {
    let noise = (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y)| Vector2::new(x, y));
    let placed = prop::collection::vec((point(2.0), noise), points);
    (exterior(), interior(), placed).prop_filter_map(
        "not in view",
        |(exterior, interior, placed)| {
            let plain = PlainCamera::new(&exterior, &interior);
            let (objects, noise): (Vec<_>, Vec<_>) = placed.into_iter().unzip();
            let mut images = Vec::new();
            for x in &objects {
                let [u, v, depth] = plain.project([x.x, x.y, x.z]);
                if depth < 1.0 {
                    return None;
                }
                images.push(Point2::new(u, v));
            }
            Some(Scene { exterior, interior, objects, images, noise })
        },
    )
}

/// The stated precisions believed, so that the standard deviations are those for σ = 1 pixel.
fn believing() -> ResectionOptions {
    ResectionOptions { estimate_sigma: false, ..ResectionOptions::default() }
}

fn solve(scene: &Scene, control: &[ControlPoint]) -> Resection<Frame<InteriorOrientation>> {
    resect(&scene.interior, control, &believing()).unwrap()
}

/// How far two poses are from each other, in standard deviations of the first.
fn distance(from: &Resection<Frame<InteriorOrientation>>, to: &ExteriorOrientation) -> f64 {
    let here = from.sensor.exterior;
    let turn = to.camera_from_world() * here.camera_from_world().inverse();
    let turn = RotationVector::from_rotation(&turn).vector();
    let moved = to.projection_center() - here.projection_center();
    let parts = [moved.x, moved.y, moved.z, turn.x, turn.y, turn.z];
    let shares = parts.iter().enumerate();
    shares.map(|(i, d)| d.abs() / from.report.standard_deviation(i)).fold(0.0, f64::max)
}

/// Half the sum of squares, written out.
fn cost(scene: &Scene, exterior: &ExteriorOrientation, control: &[ControlPoint]) -> f64 {
    let plain = PlainCamera::new(exterior, &scene.interior);
    let squares = control.iter().map(|c| {
        let [x, y, _] = plain.project([c.object.x, c.object.y, c.object.z]);
        (c.image.x - x).powi(2) + (c.image.y - y).powi(2)
    });
    0.5 * squares.sum::<f64>()
}

fn stepped(exterior: &ExteriorOrientation, k: usize, by: f64) -> ExteriorOrientation {
    let mut step = [0.0; 6];
    step[k] = by;
    let [x, y, z, a, b, c] = step;
    ExteriorOrientation::new(
        exterior.projection_center() + Vector3::new(x, y, z),
        Rotation3::new(Vector3::new(a, b, c)) * exterior.camera_from_world(),
    )
}

/// Of a difference, in standard deviations.
const STEP: f64 = 0.005;

/// The slope of the cost along each unknown for one standard deviation of it: zero at a minimum. Differences of
/// fourth order.
fn gradient(scene: &Scene, found: &ExteriorOrientation, sd: [f64; 6], c: &[ControlPoint]) -> f64 {
    let slope = |k: usize| {
        let h = STEP * sd[k];
        let side = |s: f64| {
            cost(scene, &stepped(found, k, s * h), c) - cost(scene, &stepped(found, k, -s * h), c)
        };
        (8.0 * side(1.0) - side(2.0)) / (12.0 * STEP)
    };
    (0..6).map(slope).fold(0.0, |a: f64, b| a.max(b.abs()))
}

/// How far, in standard deviations, a pose may be from the optimum: half of its square is the excess of the cost, which is
/// less than 10⁻¹² of it; and rounding.
fn allowed(found: &Resection<Frame<InteriorOrientation>>) -> f64 {
    1e-6 * (2.0 * found.report.convergence.final_cost).sqrt() + 1e-8
}

fn deviations(found: &Resection<Frame<InteriorOrientation>>) -> [f64; 6] {
    std::array::from_fn(|i| found.report.standard_deviation(i))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn resection_returns_the_exact_camera_from_exact_data(scene in scene(5..14)) {
        let found = solve(&scene, &scene.control(0.0));
        // As if measured to 10⁻⁹ pixels, the rounding of the images being 10⁻¹³.
        let off = distance(&found, &scene.exterior);
        prop_assert!(off < 1e-9, "{off}");
        prop_assert!(found.report.sigma0.unwrap() < 1e-9);
    }

    #[test]
    fn with_noise_the_gradient_of_a_resection_is_zero(scene in scene(4..14)) {
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let slope = gradient(&scene, &found.sensor.exterior, deviations(&found), &control);
        prop_assert!(slope < allowed(&found), "{slope}");
        let stated = found.report.convergence.final_cost;
        let here = cost(&scene, &found.sensor.exterior, &control);
        prop_assert!((here - stated).abs() <= 1e-9 * (1.0 + stated), "{here} {stated}");
    }

    #[test]
    fn no_camera_that_made_the_images_fits_better_than_the_resection(scene in scene(4..14)) {
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let truth = cost(&scene, &scene.exterior, &control);
        prop_assert!(found.report.convergence.final_cost <= truth * (1.0 + 1e-12));
        if let Some(other) = found.other {
            prop_assert!(found.report.convergence.final_cost <= other.cost);
            let there = cost(&scene, &other.exterior, &control);
            prop_assert!((there - other.cost).abs() <= 1e-9 * (1.0 + there));
        }
    }

    #[test]
    fn a_resection_commutes_with_a_similarity_of_the_world(
        scene in scene(5..14),
        turn in point(3.0),
        shift in point(1e5),
        log_scale in -4.0..4.0f64,
    ) {
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let (scale, turn) = (log_scale.exp(), Rotation3::new(turn.coords));
        let moved: Vec<ControlPoint> = control
            .iter()
            .map(|c| ControlPoint { object: turn * (c.object * scale) + shift.coords, ..*c })
            .collect();
        let there = solve(&scene, &moved);
        let exterior = there.sensor.exterior;
        let back = ExteriorOrientation::new(
            turn.inverse() * (exterior.projection_center() - shift.coords) / scale,
            exterior.camera_from_world() * turn,
        );
        // Coordinates of 10⁵ are rounded to 10⁻¹¹, of the points and of the centre.
        let sd = deviations(&found)[..3].iter().fold(1e-3, |a: f64, b| a.min(*b));
        let allowed = allowed(&found) + 1e-10 / (scale * sd);
        let off = distance(&found, &back);
        prop_assert!(off < allowed, "{off} {allowed}");
        let (a, b) = (found.report.sigma0.unwrap(), there.report.sigma0.unwrap());
        prop_assert!((a - b).abs() < 1e-7 * (1.0 + 1.0 / scale), "{a} {b}");
        // Lengths grow with the scale, angles do not.
        let spread = |r: &Resection<Frame<InteriorOrientation>>| {
            (0..3).map(|i| r.report.standard_deviation(i).powi(2)).sum::<f64>().sqrt()
        };
        prop_assert!((spread(&there) / spread(&found) / scale - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_order_of_points_does_not_matter_to_a_resection(scene in scene(4..14), by in 1usize..13) {
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let mut other = control;
        let n = other.len();
        other.rotate_left(by % n);
        other.swap(0, n - 1);
        let off = distance(&found, &solve(&scene, &other).sensor.exterior);
        prop_assert!(off < allowed(&found), "{off}");
    }

    #[test]
    fn a_wrong_start_changes_nothing(
        scene in scene(4..14),
        axis in point(1.0),
        degrees in prop_oneof![0.0..120.0f64, Just(180.0)],
    ) {
        let Some(axis) = Unit::try_new(axis.coords, 0.1) else { return Ok(()) };
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let turn = Rotation3::from_axis_angle(&axis, degrees * PI / 180.0);
        // About the origin, near which the points are.
        let start = ExteriorOrientation::new(
            turn * scene.exterior.projection_center(),
            scene.exterior.camera_from_world() * turn.inverse(),
        );
        let options = ResectionOptions { start: Some(start), ..believing() };
        let started = resect(&scene.interior, &control, &options).unwrap();
        let off = distance(&found, &started.sensor.exterior);
        prop_assert!(off < allowed(&found), "{off}");
    }

    #[test]
    fn a_point_with_a_larger_weight_is_met_more_closely_and_weights_scale_nothing(
        scene in scene(5..14),
        factor in 1e-6..1e6f64,
    ) {
        let control = scene.control(1.0);
        let found = solve(&scene, &control);
        let weighted: Vec<ControlPoint> =
            control.iter().map(|c| c.with_precision(Precision::Weight(factor))).collect();
        let there = solve(&scene, &weighted);
        let off = distance(&found, &there.sensor.exterior);
        prop_assert!(off < allowed(&found), "{off}");
        let (a, b) = (found.report.sigma0.unwrap(), there.report.sigma0.unwrap());
        prop_assert!((b / a / factor.sqrt() - 1.0).abs() < 1e-8);
        let mut first = control;
        first[0] = first[0].with_precision(Precision::Sigma(1e-3));
        let close = solve(&scene, &first).image_report(0).unwrap();
        prop_assert!(close.iter().all(|v| v.residual.abs() < 0.02), "{close:?}");
    }
}
