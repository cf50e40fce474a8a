//! The cost of finding cameras from points.

#![allow(clippy::expect_used, reason = "a bench stops where its data are wrong")]

use std::hint::black_box;

use collinear::InteriorOrientation;
use collinear::adjust::{ControlPoint, ResectionOptions, five_point, p3p, resect, resect_robust};
use collinear::numeric::consensus::ConsensusOptions;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point2, Point3, Rotation3, Vector3};

/// A fixed sequence in (−1, 1).
fn uniform() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Points and the directions in which they are seen.
type Triple = ([Point3<f64>; 3], [Vector3<f64>; 3]);
/// The directions of one camera and of another.
type Pairs = ([Vector3<f64>; 5], [Vector3<f64>; 5]);

/// Three points before a camera at a random place.
fn triples() -> Vec<Triple> {
    let mut next = uniform();
    (0..256)
        .map(|_| {
            let mut vector = || Vector3::new(next(), next(), next());
            let (turn, center) = (Rotation3::new(vector() * 3.0), vector() * 3.0);
            let seen = [0; 3].map(|_| 2.0 * vector() + Vector3::new(0.0, 0.0, 3.0));
            (seen.map(|s| Point3::from(center + turn.inverse() * s)), seen)
        })
        .collect()
}

fn minimal(c: &mut Criterion) {
    let triples = triples();
    let mut i = 0;
    c.bench_function("p3p", |b| {
        b.iter(|| {
            i = (i + 1) & 255;
            let (object, directions) = &triples[i];
            p3p(black_box(object), black_box(directions)).expect("a triangle")
        });
    });
}

/// Five points before two cameras, the second a unit away and turned.
fn fives() -> Vec<Pairs> {
    let mut next = uniform();
    (0..256)
        .map(|_| {
            let mut vector = || Vector3::new(next(), next(), next());
            let (turn, base) = (Rotation3::new(vector()), vector().normalize());
            let seen = [0; 5].map(|_| 2.0 * vector() + Vector3::new(0.0, 0.0, 4.5));
            (seen, seen.map(|s| turn * (s - base)))
        })
        .collect()
}

fn relative(c: &mut Criterion) {
    let fives = fives();
    let mut i = 0;
    c.bench_function("five points", |b| {
        b.iter(|| {
            i = (i + 1) & 255;
            let (first, second) = &fives[i];
            five_point(black_box(first), black_box(second)).expect("five pairs")
        });
    });
}

/// n points before a camera of 1000 px at a random place, measured with errors of half a pixel or so; the first `wrong` anywhere.
fn scenes(n: usize, wrong: usize) -> Vec<Vec<ControlPoint>> {
    let mut next = uniform();
    (0..64)
        .map(|_| {
            let mut vector = || Vector3::new(next(), next(), next());
            let (turn, center) = (Rotation3::new(vector() * 3.0), vector() * 3.0);
            (0..n)
                .map(|i| {
                    let (at, error) = (vector(), (vector() + vector() + vector()) * 0.5);
                    let depth = 6.0 + 2.0 * at.z;
                    let seen = Vector3::new(0.6 * at.x, 0.44 * at.y, 1.0) * depth;
                    let image = if i < wrong {
                        let anywhere = vector();
                        Point2::new(640.0 + 640.0 * anywhere.x, 480.0 + 480.0 * anywhere.y)
                    } else {
                        Point2::new(640.0 + 600.0 * at.x + error.x, 480.0 + 440.0 * at.y + error.y)
                    };
                    ControlPoint::new(Point3::from(center + turn.inverse() * seen), image)
                })
                .collect()
        })
        .collect()
}

fn resections(c: &mut Criterion) {
    let camera =
        InteriorOrientation::new([1000.0; 2], Point2::new(640.0, 480.0), 0.0).expect("a camera");
    let options = ResectionOptions::default();
    for n in [6, 20, 100, 1000] {
        let scenes = scenes(n, 0);
        let mut i = 0;
        c.bench_function(&format!("resect, {n} points"), |b| {
            b.iter(|| {
                i = (i + 1) & 63;
                resect(&camera, black_box(&scenes[i]), &options).expect("a pose")
            });
        });
    }
    for (wrong, threshold) in [(30, 3.0), (60, 3.0), (80, 3.0)] {
        let scenes = scenes(100, wrong);
        let consensus = ConsensusOptions { threshold, ..ConsensusOptions::default() };
        let mut i = 0;
        c.bench_function(&format!("resect, {wrong} of 100 points wrong"), |b| {
            b.iter(|| {
                i = (i + 1) & 63;
                resect_robust(&camera, black_box(&scenes[i]), &consensus, &options).expect("a pose")
            });
        });
    }
}

criterion_group!(benches, minimal, relative, resections);
criterion_main!(benches);
