//! Points a second through each central model: forward, back and with all partial derivatives; and many points through a
//! lens.

use std::hint::black_box;

use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralCamera, CentralModel, CentralProjection, Distortion,
    Division, DoubleSphere, EnhancedUnified, EvenRadial, FieldOfView, Fisheye, Fraser, Gnomonic,
    InteriorOrientation, Metashape, NoDistortion, Panorama, RadialTangentialThinPrism, Rational,
    ThinPrism, UnifiedSphere,
};
use collinear::nalgebra::{Point2, Point3, Vector3};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const POINTS: usize = 1000;
const MANY: usize = 1_000_000;

fn ok<T, E: std::fmt::Debug>(result: Result<T, E>) -> T {
    match result {
        Ok(value) => value,
        Err(e) => unreachable!("{e:?}"),
    }
}

fn interior() -> InteriorOrientation {
    ok(InteriorOrientation::new([1200.0; 2], Point2::new(640.0, 480.0), 0.0))
}

fn model<P: CentralProjection, D: Distortion>(c: &mut Criterion, name: &str, p: P, d: D) {
    let camera = CentralCamera::from_parts(interior(), p, d);
    let directions: Vec<Vector3<f64>> = (0..POINTS)
        .map(|i| {
            let (x, y) = ((i % 37) as f64 / 18.0 - 1.0, (i % 29) as f64 / 14.0 - 1.0);
            Vector3::new(0.5 * x, 0.4 * y, 1.0 + (i % 11) as f64 / 100.0)
        })
        .collect();
    let images: Vec<Point2<f64>> =
        directions.iter().filter_map(|d| camera.project_direction(d).ok()).collect();
    assert_eq!(images.len(), POINTS, "every point is in view");
    let mut group = c.benchmark_group(name);
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function("forward", |b| {
        b.iter(|| {
            let all = directions.iter();
            all.filter_map(|d| camera.project_direction(black_box(d)).ok())
                .map(|p| p.x)
                .sum::<f64>()
        });
    });
    group.bench_function("inverse", |b| {
        b.iter(|| {
            let all = images.iter();
            all.filter_map(|p| camera.direction(black_box(p)).ok()).map(|d| d.x).sum::<f64>()
        });
    });
    group.bench_function("partials", |b| {
        let (mut object, mut blocks) = ([0.0; 6], vec![]);
        while let Some(of) = camera.parameter_group(blocks.len()) {
            blocks.push(vec![0.0; 2 * of.len]);
        }
        let mut slices: Vec<&mut [f64]> = blocks.iter_mut().map(Vec::as_mut_slice).collect();
        b.iter(|| {
            let mut sum = 0.0;
            for d in &directions {
                let at = Point3::from(*black_box(d));
                if camera.partials(&at, &mut object, &mut slices).is_ok() {
                    sum += object[0] + slices[0][0];
                }
            }
            sum
        });
    });
    group.finish();
}

fn models(c: &mut Criterion) {
    let brown = ok(Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4]));
    let k = [0.031, -0.015, 0.0063, -0.0011];
    model(c, "pinhole", Gnomonic, NoDistortion);
    model(c, "brown", Gnomonic, brown);
    model(c, "rational", Gnomonic, rational());
    let metashape = ok(Metashape::new([-0.11, 0.04, -0.013, 0.002], [1.1e-3, -6e-4, 0.3, -0.1]));
    model(c, "metashape", Gnomonic, metashape);
    let fraser = ok(Fraser::new([0.11, -0.03, 0.004], [1e-3, -6e-4], [3e-3, -2e-3]));
    model(c, "fraser", Gnomonic, fraser);
    model(c, "equidistant", Fisheye::Equidistant, NoDistortion);
    model(c, "kannala_brandt", Fisheye::Equidistant, ok(EvenRadial::new(k)));
    let prism = ok(ThinPrism::new(k, [1.2e-3, -7e-4], [9e-4, -5e-4]));
    model(c, "thin_prism_fisheye", Fisheye::Equidistant, prism);
    let k = [0.031, -0.015, 0.0063, -0.0011, 4e-4, -6e-5];
    let (p, s) = ([1.2e-3, -7e-4], [9e-4, -5e-4, 3e-4, -2e-4]);
    let aria = ok(RadialTangentialThinPrism::new(k, p, s));
    model(c, "fisheye624", Fisheye::Equidistant, aria);
    model(c, "field_of_view", ok(FieldOfView::new(0.93)), NoDistortion);
    model(c, "division", ok(Division::new(-0.13)), NoDistortion);
    model(c, "unified", ok(UnifiedSphere::new(1.21)), brown);
    model(c, "enhanced_unified", ok(EnhancedUnified::new(0.57, 1.13)), NoDistortion);
    model(c, "double_sphere", ok(DoubleSphere::new(-0.18, 0.59)), NoDistortion);
    model(c, "equirectangular", Panorama::Equirectangular, NoDistortion);
    model(c, "cylindrical", Panorama::Cylindrical, NoDistortion);
}

fn rational() -> Rational {
    ok(Rational::from_opencv(&[-0.281, 0.0713, 1.1e-3, -6.2e-4, 0.0131, 0.0172, -0.0214, 0.0036]))
}

fn many(c: &mut Criterion) {
    let pixels: Vec<Point2<f64>> = (0..MANY)
        .map(|i| {
            // The golden ratio's multiples spread evenly.
            let (a, b) = (i as f64 * 0.754_877_666_246_693, i as f64 * 0.569_840_290_998_053_3);
            Point2::new(1280.0 * (a - a.floor()), 960.0 * (b - b.floor()))
        })
        .collect();
    let mut ideal = vec![Point2::origin(); MANY];
    let mut group = c.benchmark_group("undistort a million points");
    group.sample_size(20).throughput(Throughput::Elements(MANY as u64));
    let brown = ok(Brown::new([-0.28, 0.07, 0.002], [1e-3, -5e-4]));
    let brown = BrownCamera::new(interior(), brown);
    group.bench_function("Brown, five coefficients", |b| {
        b.iter(|| ok(brown.undistort_points(black_box(&pixels), &mut ideal)).converged);
    });
    let rational = CentralCamera::from_parts(interior(), Gnomonic, rational());
    group.bench_function("rational, eight coefficients", |b| {
        b.iter(|| ok(rational.undistort_points(black_box(&pixels), &mut ideal)).converged);
    });
    group.finish();
    for report in [
        ok(brown.undistort_points(&pixels, &mut ideal)),
        ok(rational.undistort_points(&pixels, &mut ideal)),
    ] {
        assert!(report.failed == 0 && report.largest_residual < 1e-14, "{report:?}");
    }
}

criterion_group!(benches, models, many);
criterion_main!(benches);
