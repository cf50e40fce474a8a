//! The cost of making and applying homographies.

#![allow(clippy::expect_used, reason = "a bench stops where its data are wrong")]

use std::hint::black_box;

use collinear::geometry::Homography;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point2;

fn quads() -> Vec<[Point2<f64>; 4]> {
    // Quads of a 4000 × 3000 picture, each corner moved by a fixed sequence.
    let mut state = 1u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
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

criterion_group!(benches, closed_forms);
criterion_main!(benches);
