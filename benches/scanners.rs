//! Points a second through each scanning camera: forward, back to a plane, and with all partial derivatives.

use std::hint::black_box;

use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralModel, Ephemeris, ExteriorOrientation,
    ImageMotionCompensation, InteriorOrientation, Interpolation, PolynomialTrajectory, ScanTime,
    Scanner, SensorModel, Trajectory,
};
use collinear::geometry::Plane;
use collinear::nalgebra::{Point2, Point3, Rotation3, Vector3};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const POINTS: usize = 1000;

fn ok<T, E: std::fmt::Debug>(result: Result<T, E>) -> T {
    match result {
        Ok(value) => value,
        Err(e) => unreachable!("{e:?}"),
    }
}

fn interior() -> InteriorOrientation {
    ok(InteriorOrientation::new([2000.0; 2], Point2::new(500.0, 250.0), 0.0))
}

fn down(center: Point3<f64>) -> ExteriorOrientation {
    ok(ExteriorOrientation::look_at(center, center - Vector3::z(), -Vector3::y()))
}

/// From 800 up with 70 a second along y and a slow turn.
fn flight() -> PolynomialTrajectory<ExteriorOrientation> {
    let start = down(Point3::new(500_000.0, 5_400_000.0, 800.0));
    let (velocity, turn) = (Vector3::new(3.0, 70.0, -2.0), Vector3::new(0.005, 0.01, -0.007));
    ok(PolynomialTrajectory::constant_velocity(start, 0.0, velocity, turn))
}

/// The same as a bumpy table with a node each 50 lines.
fn table(how: Interpolation) -> PolynomialTrajectory<Ephemeris> {
    let times: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    let flight = flight();
    let (mut positions, mut attitudes) = (vec![], vec![]);
    for t in &times {
        let state = ok(flight.state(*t));
        let bump = Vector3::new((7.0 * t).sin(), (5.0 * t).cos(), (3.0 * t).sin());
        positions.push(state.center + bump * 0.1);
        attitudes.push(Rotation3::new(bump * 0.002) * state.camera_from_world);
    }
    let table = ok(Ephemeris::new((&times, &positions, how), (&times, &attitudes, how)));
    let zero = vec![Vector3::zeros(); 2];
    ok(PolynomialTrajectory::new(table, 1.0, 1.0, zero.clone(), zero))
}

fn sensor<C: CentralModel + Adjustable, T: Trajectory>(
    c: &mut Criterion,
    name: &str,
    scanner: &Scanner<C, T>,
) {
    let ground = ok(Plane::from_point_and_normal(Point3::new(5e5, 5.4e6, 0.0), Vector3::z()));
    let images: Vec<Point2<f64>> = (0..POINTS)
        .map(|i| Point2::new((i * 37 % 1000) as f64, 500.0 * ((i * 29 % 997) as f64 / 997.0)))
        .collect();
    let points: Vec<Point3<f64>> = images.iter().map(|p| ok(scanner.ground(p, &ground))).collect();
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function("forward", |b| {
        b.iter(|| points.iter().map(|p| ok(scanner.project(black_box(p))).x).sum::<f64>());
    });
    group.bench_function("inverse", |b| {
        b.iter(|| images.iter().map(|p| ok(scanner.ground(black_box(p), &ground)).x).sum::<f64>());
    });
    group.bench_function("partials", |b| {
        let (mut object, mut blocks) = ([0.0; 6], vec![]);
        while let Some(of) = scanner.parameter_group(blocks.len()) {
            blocks.push(vec![0.0; 2 * of.len]);
        }
        let mut slices: Vec<&mut [f64]> = blocks.iter_mut().map(Vec::as_mut_slice).collect();
        b.iter(|| {
            let of = |p| ok(scanner.partials(black_box(p), &mut object, &mut slices)).x;
            points.iter().map(of).sum::<f64>()
        });
    });
    group.finish();
}

fn sensors(c: &mut Criterion) {
    let lens = ok(Brown::new([-0.1, 0.02, 0.0], [1e-3, -5e-4]));
    let camera = BrownCamera::new(interior(), lens);
    let lines = ok(ScanTime::by_line(0.0, 0.002, [0.0, 500.0]));
    let scanner = ok(Scanner::line_scan(camera, flight(), 250.0, lines));
    sensor(c, "pushbroom, constant velocity", &scanner);
    let scanner = ok(Scanner::line_scan(camera, table(Interpolation::Linear), 250.0, lines));
    sensor(c, "pushbroom, table, linear", &scanner);
    let scanner = ok(Scanner::line_scan(camera, table(Interpolation::Lagrange(8)), 250.0, lines));
    sensor(c, "pushbroom, table, eight nodes", &scanner);
    let pixels = ok(ScanTime::by_pixel(0.0, 1e-6, 0.002, [[0.0, 1000.0], [0.0, 500.0]]));
    let scanner = ok(Scanner::whiskbroom(interior(), 250.0, flight(), pixels));
    sensor(c, "whiskbroom", &scanner);
    let columns = ok(ScanTime::by_column(0.0, 0.001, [0.0, 1000.0]));
    let compensation = ok(ImageMotionCompensation::new(0.02));
    let scanner = ok(Scanner::panoramic(interior(), compensation, flight(), columns));
    sensor(c, "panoramic", &scanner);
    let readout = ok(ScanTime::by_line(0.0, 3e-5, [0.0, 500.0]));
    let scanner = ok(Scanner::frame_scan(camera, flight(), readout));
    sensor(c, "rolling shutter", &scanner);
}

criterion_group!(benches, sensors);
criterion_main!(benches);
