//! Points a second through a rational polynomial camera: forward, with partials, back at a height, on a surface.

use std::hint::black_box;

use collinear::camera::SensorModel;
use collinear::camera::rpc::{Rpc, Rpc00b, RpcSensor};
use collinear::geometry::geodetic::{
    EarthFrame, Ellipsoid, EllipsoidalHeight, Geodetic, LocalFrame,
};
use collinear::nalgebra::{Point2, Point3};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const POINTS: usize = 1000;

fn ok<T, E: std::fmt::Debug>(result: Result<T, E>) -> T {
    match result {
        Ok(value) => value,
        Err(e) => unreachable!("{e:?}"),
    }
}

/// A polynomial with all of its coefficients, of the sizes that a satellite's have.
fn polynomial(first: [f64; 4], sign: f64) -> [f64; 20] {
    core::array::from_fn(|k| match k {
        0..4 => first[k],
        4..10 => sign * 1e-4 / (k as f64),
        _ => sign * 1e-6 / (k as f64),
    })
}

fn camera() -> Rpc {
    ok(Rpc::from_rpc00b(&Rpc00b {
        line_offset: 21_109.5,
        sample_offset: 19_207.5,
        latitude_offset_deg: 44.137,
        longitude_offset_deg: 5.285,
        height_offset: 1075.0,
        line_scale: 21_137.5,
        sample_scale: 19_999.5,
        latitude_scale_deg: 0.0989,
        longitude_scale_deg: 0.1287,
        height_scale: 885.0,
        line_numerator: polynomial([1e-4, 0.06, -1.02, 0.017], 1.0),
        line_denominator: polynomial([1.0, 3e-4, 1e-4, -3e-5], -1.0),
        sample_numerator: polynomial([4e-3, 1.01, 0.08, -0.03], -1.0),
        sample_denominator: polynomial([1.0, -2e-4, 4e-4, 1e-4], 1.0),
        error_bias: None,
        error_random: None,
    }))
}

fn rpc(c: &mut Criterion) {
    let camera = camera();
    let places: Vec<Geodetic> = (0..POINTS)
        .map(|i| {
            let part = |n: usize| (i % n) as f64 / (n as f64 - 1.0) * 2.0 - 1.0;
            let height = EllipsoidalHeight(1075.0 + 700.0 * part(29));
            ok(Geodetic::from_degrees(44.137 + 0.09 * part(37), 5.285 + 0.12 * part(31), height))
        })
        .collect();
    let images: Vec<Point2<f64>> = places.iter().map(|p| ok(camera.project(p))).collect();
    let origin = ok(Geodetic::from_degrees(44.137, 5.285, EllipsoidalHeight(0.0)));
    let frame = EarthFrame::Local(LocalFrame::east_north_up(Ellipsoid::WGS84, origin));
    let sensor = RpcSensor::new(camera, frame);
    let world: Vec<Point3<f64>> = places.iter().map(|p| frame.world_from_geodetic(p)).collect();
    let surface = ok(frame.at_height(EllipsoidalHeight(900.0)));

    let mut group = c.benchmark_group("rpc");
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function("forward", |b| {
        b.iter(|| places.iter().map(|p| ok(camera.project(black_box(p))).x).sum::<f64>());
    });
    group.bench_function("forward with partials", |b| {
        b.iter(|| {
            places.iter().map(|p| ok(camera.project_jacobian(black_box(p))).1.m11).sum::<f64>()
        });
    });
    group.bench_function("inverse at a height", |b| {
        b.iter(|| {
            let all = images.iter().zip(&places);
            all.map(|(i, p)| ok(camera.at_height(black_box(i), p.height())).latitude()).sum::<f64>()
        });
    });
    group.bench_function("forward from local coordinates", |b| {
        b.iter(|| world.iter().map(|p| ok(sensor.project(black_box(p))).x).sum::<f64>());
    });
    group.bench_function("ground at a constant height, local coordinates", |b| {
        b.iter(|| images.iter().map(|i| ok(sensor.ground(black_box(i), &surface)).x).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, rpc);
criterion_main!(benches);
