//! The cost of finding cameras from points.

#![allow(clippy::expect_used, reason = "a bench stops where its data are wrong")]

use std::hint::black_box;

use collinear::adjust::p3p;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point3, Rotation3, Vector3};

/// A fixed sequence in (−1, 1).
fn uniform() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Three points before a camera at a random place.
fn triples() -> Vec<([Point3<f64>; 3], [Vector3<f64>; 3])> {
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

criterion_group!(benches, minimal);
criterion_main!(benches);
