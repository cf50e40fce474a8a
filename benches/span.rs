//! Nanoseconds a pixel by form of span: two attributes over a row of 1,920 pixels.
#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark")]

use std::hint::black_box;

use collinear::mapping::span::{Approximation, ConstantDepthLines, Degree, Span};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const WIDTH: i32 = 1920;

fn sum(values: [&[f64]; 2], total: &mut [f64; 2]) {
    // The values must be in memory; reading the ends keeps the closure honest without costing a loop.
    for (t, v) in total.iter_mut().zip(values) {
        let v = black_box(v);
        *t += v[0] + v[v.len() - 1];
    }
}

fn spans(c: &mut Criterion) {
    let span = Span::new([[12.0, 3.25], [700.0, -0.125]], [1.0, 0.001_5]).unwrap();
    let mut group = c.benchmark_group("span");
    group.throughput(Throughput::Elements(WIDTH as u64));
    group.bench_function("at", |b| {
        b.iter(|| {
            let span = black_box(&span);
            (0..WIDTH).filter_map(|x| span.at(x).ok()).fold(0.0, |s, [u, v]| s + u + v)
        });
    });
    group.bench_function("exact", |b| {
        b.iter(|| {
            let mut total = [0.0; 2];
            black_box(&span).exact(0..WIDTH, |_, values| sum(values, &mut total));
            total
        });
    });
    group.bench_function("walk", |b| {
        b.iter(|| {
            let mut total = [0.0; 2];
            black_box(&span).walk(0..WIDTH, |_, values| sum(values, &mut total));
            total
        });
    });
    group.bench_function("walk_unanchored", |b| {
        b.iter(|| {
            let mut total = [0.0; 2];
            black_box(&span).walk_unanchored(0..WIDTH, |_, values| sum(values, &mut total));
            total
        });
    });
    for (name, degree, run) in [
        ("affine_16", Degree::Affine, 16),
        ("quadratic_16", Degree::Quadratic, 16),
        ("cubic_16", Degree::Cubic, 16),
        ("quadratic_64", Degree::Quadratic, 64),
        ("cubic_64", Degree::Cubic, 64),
    ] {
        let approximation = Approximation::new(degree, run).unwrap();
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut total = [0.0; 2];
                approximation.walk(black_box(&span), 0..WIDTH, |_, values| sum(values, &mut total));
                total
            });
        });
    }
    group.finish();
    let lines =
        ConstantDepthLines::new([[12.0, 3.25, 0.5], [700.0, -0.125, 2.0]], [1.0, 0.000_3, 0.001_5])
            .unwrap();
    let mut group = c.benchmark_group("rectangle");
    group.throughput(Throughput::Elements(WIDTH as u64 * 64));
    group.bench_function("constant_depth", |b| {
        b.iter(|| {
            let mut total = [0.0; 2];
            black_box(&lines).walk(0..WIDTH, 0..64, |_, _, [u, v]| {
                total[0] += u;
                total[1] += v;
            });
            total
        });
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30).measurement_time(std::time::Duration::from_secs(2));
    targets = spans
}
criterion_main!(benches);
