//! The cost of making and applying homographies.

#![allow(clippy::expect_used, reason = "a bench stops where its data are wrong")]

use std::hint::black_box;

use collinear::geometry::Homography;
use collinear::geometry::homography::FitOptions;
use collinear::numeric::consensus::ConsensusOptions;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};

/// A fixed sequence in [0, 1).
fn uniform() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Quads of a 4000 × 3000 picture.
fn quads() -> Vec<[Point2<f64>; 4]> {
    let mut next = uniform();
    (0..64)
        .map(|_| {
            [(500.0, 400.0), (3500.0, 400.0), (3500.0, 2600.0), (500.0, 2600.0)]
                .map(|(x, y)| Point2::new(x + 600.0 * next() - 300.0, y + 600.0 * next() - 300.0))
        })
        .collect()
}

fn closed_forms(c: &mut Criterion) {
    let quads = quads();
    let mut group = c.benchmark_group("homography");
    let mut i = 0;
    let mut pair = || {
        i = (i + 1) & 63;
        (black_box(&quads[i]), black_box(&quads[(i + 7) & 63]))
    };
    group.bench_function("unit square to quad", |b| {
        b.iter(|| Homography::from_unit_square(pair().0));
    });
    group.bench_function("quad to unit square", |b| {
        b.iter(|| Homography::to_unit_square(pair().0));
    });
    group.bench_function("quad to quad", |b| {
        b.iter(|| {
            let (s, t) = pair();
            Homography::from_quads(s, t)
        });
    });
    group.bench_function("equation 2", |b| {
        b.iter(|| {
            let (s, t) = pair();
            Homography::from_four_points_linear(s, t)
        });
    });
    let map = Homography::from_unit_square(&quads[0]).expect("a convex quad");
    let p = Point2::new(0.3, 0.6);
    group.bench_function("apply", |b| b.iter(|| black_box(&map).apply(black_box(&p))));
    group.bench_function("inverse", |b| b.iter(|| black_box(&map).inverse()));
    group.finish();
}

fn fits(c: &mut Criterion) {
    let corners = [(400.0, 300.0), (3500.0, 500.0), (3300.0, 2700.0), (200.0, 2400.0)];
    let truth = Homography::from_unit_square(&corners.map(|(x, y)| Point2::new(x, y)))
        .expect("a convex quad");
    let mut group = c.benchmark_group("homography fit");
    for n in [4, 20, 100, 1000] {
        let mut next = uniform();
        let object: Vec<_> = (0..n).map(|_| Point2::new(next(), next())).collect();
        let image: Vec<_> = object
            .iter()
            .map(|p| truth.apply(p).expect("in front") + Vector2::new(next() - 0.5, next() - 0.5))
            .collect();
        group.bench_function(format!("{n} points"), |b| {
            b.iter(|| {
                Homography::fit(black_box(&object), black_box(&image), &FitOptions::default())
            });
        });
        if n > 4 {
            let mut wrong = image.clone();
            for p in wrong.iter_mut().step_by(2) {
                *p = Point2::new(4000.0 * next(), 3000.0 * next());
            }
            group.bench_function(format!("{n} points, half of them wrong"), |b| {
                b.iter(|| {
                    let options = ConsensusOptions::default();
                    Homography::fit_robust(black_box(&object), black_box(&wrong), &options)
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, closed_forms, fits);
criterion_main!(benches);
