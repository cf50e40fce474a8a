//! Bundle adjustment of blocks of many photographs: every way of solving them leads to the same place.
//!
//! Photographs in strips over a ground of hills, their image points by the formula of a perspective worked out here:
//! x = c (X − X₀)/(Z₀ − Z), y = c (Y₀ − Y)/(Z₀ − Z) for a camera that looks straight down. Without noise the block that fits is the
//! true one.

use collinear::adjust::bundle::{Adjusted, Bundle, BundleOptions, Solver};
use collinear::adjust::{Precision, Unknown};
use collinear::camera::{CentralCamera, EvenRadial, Gnomonic};
use collinear::{ExteriorOrientation, InteriorOrientation};
use nalgebra::{Point2, Point3, Rotation3, Vector3};

use crate::support::same_on_any_number_of_threads;

type Lens = CentralCamera<Gnomonic, EvenRadial>;

const C: f64 = 1000.0;
const HEIGHT: f64 = 100.0;

/// Which cameras the photographs have.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cameras {
    Own,
    /// One for every so many photographs.
    Shared(usize),
    Held,
}

/// Numbers between −1 and 1 without a pattern.
fn wave(k: usize) -> f64 {
    (k as f64 * 12.9898).sin() * 0.7 + (k as f64 * 4.1414).cos() * 0.3
}

fn truth(strips: usize, along: usize) -> (Vec<Point3<f64>>, Vec<Point3<f64>>) {
    let centres = (0..strips * along)
        .map(|i| Point3::new((i % along) as f64 * 48.0, (i / along) as f64 * 60.0, HEIGHT))
        .collect();
    let (columns, rows) = (along * 4 + 2, strips * 5 + 2);
    let points = (0..columns * rows)
        .map(|i| {
            let x = (i % columns) as f64 * 12.0 - 18.0 + wave(i);
            let y = (i / columns) as f64 * 12.0 - 36.0 + wave(i + 7);
            Point3::new(x, y, 10.0 * (x / 40.0).sin() * (y / 50.0).cos() + 4.0 * wave(3 * i))
        })
        .collect();
    (centres, points)
}

/// A block that starts beside the true one; `distances` are scale bars between neighbouring points. The numbers of the photographs are
/// stirred, so that their order says nothing.
fn block(
    (strips, along): (usize, usize),
    cameras: Cameras,
    distances: usize,
) -> (Bundle<Lens>, Vec<Point3<f64>>) {
    let (centres, points) = truth(strips, along);
    let lens = |c: f64| {
        let interior = InteriorOrientation::new([c; 2], Point2::origin(), 0.0).unwrap();
        CentralCamera::from_parts(interior, Gnomonic, EvenRadial::new([0.0; 4]).unwrap())
    };
    let start = if cameras == Cameras::Held { C } else { 1.002 * C };
    let chosen = [Unknown::together(0, &[0, 1]), Unknown::parameter(1, 0)];
    let chosen = if cameras == Cameras::Held { &[] } else { &chosen[..] };
    let mut bundle = Bundle::new();
    let mut ids = vec![];
    let mut images = vec![];
    let step = (3..).step_by(2).find(|s| centres.len() % s != 0).unwrap();
    let stirred: Vec<usize> = (0..centres.len()).map(|i| i * step % centres.len()).collect();
    for (number, i) in stirred.iter().enumerate() {
        let new = match cameras {
            Cameras::Shared(count) => number % count == 0,
            _ => true,
        };
        if new {
            ids.push(bundle.add_camera(lens(start), chosen).unwrap());
        }
        let down = Rotation3::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
        let turn = Rotation3::from_scaled_axis(Vector3::from_fn(|r, _| 2e-3 * wave(5 * i + r)));
        let centre = centres[*i] + Vector3::from_fn(|r, _| 0.2 * wave(9 * i + r));
        let exterior = ExteriorOrientation::new(centre, turn * down);
        images.push(bundle.add_image(exterior, *ids.last().unwrap()).unwrap());
    }
    let image_of = |i: usize, point: &Point3<f64>| {
        let s = C / (centres[i].z - point.z);
        let at = Point2::new(s * (point.x - centres[i].x), s * (centres[i].y - point.y));
        (at.x.abs() < 620.0 && at.y.abs() < 460.0).then_some(at)
    };
    let mut numbers = vec![];
    for (k, point) in points.iter().enumerate() {
        let rays = (0..centres.len()).filter(|i| image_of(*i, point).is_some()).count();
        numbers.push(if k % 17 == 0 {
            Some(bundle.add_control(*point, Precision::Sigma(0.01)).unwrap())
        } else {
            let beside = point + Vector3::from_fn(|r, _| 0.3 * wave(11 * k + r));
            (rays > 1).then(|| bundle.add_point(beside).unwrap())
        });
    }
    let seen = numbers.iter().zip(&points).filter(|(n, _)| n.is_some());
    let truth = seen.map(|(_, p)| *p).collect();
    for (image, i) in images.iter().zip(&stirred) {
        for (number, point) in numbers.iter().zip(&points) {
            if let (Some(number), Some(at)) = (number, image_of(*i, point)) {
                bundle.observe(*image, *number, at, Precision::Sigma(0.5)).unwrap();
            }
        }
    }
    let inner: Vec<usize> = (0..points.len() - 1)
        .filter(|k| numbers[*k].is_some() && numbers[k + 1].is_some())
        .filter(|k| (points[*k] - points[k + 1]).norm() < 20.0)
        .collect();
    for k in 0..distances {
        let ends = [0, 1].map(|one| inner[inner.len() / 3 + 20 * k] + one);
        let length = (points[ends[0]] - points[ends[1]]).norm();
        bundle.observe_distance(ends.map(|e| numbers[e].unwrap()), length, 0.01).unwrap();
    }
    (bundle, truth)
}

/// The largest distance of an adjusted point from the true one.
fn off(adjusted: &Adjusted<Lens>, truth: &[Point3<f64>]) -> f64 {
    adjusted.points().iter().zip(truth).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn every_solver_finds_the_true_block() {
    let kinds = [Cameras::Held, Cameras::Own, Cameras::Shared(1000), Cameras::Shared(5)];
    for (cameras, distances) in kinds.into_iter().flat_map(|c| [(c, 0), (c, 4)]) {
        let (bundle, points) = block((4, 8), cameras, distances);
        for solver in [Solver::Dense, Solver::Sparse, Solver::Automatic, Solver::Iterative] {
            if solver == Solver::Iterative && cameras != Cameras::Held {
                continue;
            }
            let options = BundleOptions { solver, ..Default::default() };
            let adjusted = bundle.adjust(&options).unwrap();
            assert!(adjusted.excluded.is_empty());
            let off = off(&adjusted, &points);
            assert!(off < 1e-6, "{cameras:?} {distances} {solver:?}: {off}");
            for camera in adjusted.cameras() {
                let c = camera.interior().principal_distance()[0];
                assert!((c - C).abs() < 1e-5, "{cameras:?} {solver:?} {c}");
            }
        }
    }
}

#[test]
fn a_sparse_step_is_the_dense_one() {
    for cameras in [Cameras::Held, Cameras::Own, Cameras::Shared(1000), Cameras::Shared(3)] {
        let (bundle, _) = block((5, 10), cameras, 3);
        let costs = |solver| {
            let mut costs = vec![];
            let mut options = BundleOptions { solver, ..Default::default() };
            options.least_squares.max_iterations = 3;
            let watched = bundle.adjust_watched(&options, |progress| {
                costs.push(progress.cost);
                std::ops::ControlFlow::Continue(())
            });
            watched.map(|_| costs).unwrap()
        };
        let (dense, sparse) = (costs(Solver::Dense), costs(Solver::Sparse));
        assert!(dense.len() >= 2 && dense.len() == sparse.len());
        // The first step is the same to rounding; later ones start from a cost that is only a rounding.
        assert!((sparse[0] / dense[0] - 1.0).abs() < 1e-7, "{cameras:?} {dense:?} {sparse:?}");
        assert!((sparse[1] - dense[1]).abs() < 1e-7 * dense[0], "{cameras:?} {dense:?} {sparse:?}");
    }
}

#[test]
fn a_sparse_factorisation_has_the_same_bytes_on_any_number_of_threads() {
    for cameras in [Cameras::Own, Cameras::Shared(1000)] {
        let (bundle, _) = block((6, 10), cameras, 2);
        let options = BundleOptions { solver: Solver::Sparse, ..Default::default() };
        same_on_any_number_of_threads(|| bundle.adjust(&options).unwrap());
    }
}
