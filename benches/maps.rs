//! Rows of maps through control points, of approximations and of lookup tables.

use std::hint::black_box;

use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
use collinear::mapping::piecewise::{BilinearGrid, PiecewiseAffine, PiecewiseCubic};
use collinear::mapping::{Approximated, DistortMap, LookupTable, Map, ThinPlate, UndistortMap};
use collinear::nalgebra::Point2;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const WIDTH: i32 = 1920;
const HEIGHT: i32 = 1080;

/// Points scattered over the frame, its corners among them; always the same.
fn scattered(n: usize) -> Vec<Point2<f64>> {
    let (w, h) = (f64::from(WIDTH), f64::from(HEIGHT));
    let mut state = 12_345u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)].map(|(x, y)| Point2::new(x, y));
    corners.into_iter().chain((4..n).map(|_| Point2::new(next() * w, next() * h))).collect()
}

fn bench(c: &mut Criterion) {
    let interior = InteriorOrientation::new([1000.0; 2], Point2::new(960.0, 540.0), 0.0);
    let lens = Brown::new([-0.12, 0.02, -0.002], [1e-3, -5e-4]);
    let (Ok(interior), Ok(lens)) = (interior, lens) else { unreachable!("a camera") };
    let camera = BrownCamera::new(interior, lens);
    let (distort, undistort) = (DistortMap::new(camera), UndistortMap::new(camera));

    let mut fits = c.benchmark_group("fit");
    let pairs = |n: usize| {
        let screen = scattered(n);
        let texture = screen.iter().filter_map(|p| distort.at(p).ok()).collect();
        (screen, texture)
    };
    for n in [20, 200, 2000] {
        let (screen, texture): (Vec<Point2<f64>>, Vec<Point2<f64>>) = pairs(n);
        fits.bench_function(format!("piecewise affine, {n}"), |b| {
            b.iter(|| PiecewiseAffine::new(black_box(&screen), &texture));
        });
        fits.bench_function(format!("piecewise cubic, {n}"), |b| {
            b.iter(|| PiecewiseCubic::new(black_box(&screen), &texture));
        });
        if n < 2000 {
            fits.bench_function(format!("thin plate, {n}"), |b| {
                b.iter(|| ThinPlate::fit(black_box(&screen), &texture, 0.0));
            });
        }
    }
    fits.sample_size(10);
    fits.bench_function("approximated undistortion, 1920x1080, 0.01", |b| {
        b.iter(|| Approximated::new(undistort, 0..WIDTH, 0..HEIGHT, 0.01));
    });
    fits.finish();

    let mut maps: Vec<(String, Box<dyn Map>)> = vec![
        ("distortion".to_owned(), Box::new(distort)),
        ("undistortion".to_owned(), Box::new(undistort)),
    ];
    if let Ok(map) = Approximated::new(undistort, 0..WIDTH, 0..HEIGHT, 0.01) {
        maps.push(("undistortion approximated to 0.01".to_owned(), Box::new(map)));
    }
    if let Ok(map) = BilinearGrid::sampled(&distort, WIDTH as u32, HEIGHT as u32, 16) {
        maps.push(("grid of bilinears, 16".to_owned(), Box::new(map)));
    }
    if let Ok(map) = LookupTable::from_map(&distort, WIDTH as u32, HEIGHT as u32) {
        maps.push(("lookup table".to_owned(), Box::new(map)));
    }
    for n in [20, 200, 2000] {
        let (screen, texture) = pairs(n);
        if let Ok(map) = PiecewiseAffine::new(&screen, &texture) {
            maps.push((format!("piecewise affine, {n}"), Box::new(map)));
        }
        if let Ok(map) = PiecewiseCubic::new(&screen, &texture) {
            maps.push((format!("piecewise cubic, {n}"), Box::new(map)));
        }
        if let (true, Ok(map)) = (n < 2000, ThinPlate::fit(&screen, &texture, 0.0)) {
            maps.push((format!("thin plate, {n}"), Box::new(map)));
        }
    }
    let mut rows = c.benchmark_group("rows 1920x1080");
    rows.throughput(Throughput::Elements((WIDTH * HEIGHT) as u64));
    rows.sample_size(10);
    for (name, map) in &maps {
        rows.bench_function(name, |b| {
            b.iter(|| {
                let mut sum = 0.0;
                for line in 0..HEIGHT {
                    map.blocks(line, 0..WIDTH, &mut |_, u, v| sum += u[0] + v[v.len() - 1]);
                }
                sum
            });
        });
    }
    rows.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
