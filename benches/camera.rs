//! Points a second through a camera: forward, back, and with partial derivatives.

use std::hint::black_box;

use collinear::camera::{
    Adjustable, Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation, Orthographic,
    SensorModel,
};
use collinear::geometry::{Affine2, Locus, Plane};
use collinear::nalgebra::{Point2, Point3, Vector3};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const POINTS: usize = 1000;

fn camera() -> Frame<BrownCamera> {
    let exterior = ExteriorOrientation::look_at(
        Point3::new(389_400.0, 5_819_700.0, 900.0),
        Point3::new(389_450.0, 5_819_720.0, 40.0),
        Vector3::y(),
    );
    let interior = InteriorOrientation::new([2839.0, 2839.0], Point2::new(1632.0, 1224.0), 0.0);
    let lens = Brown::new([0.0885, -0.2324, 0.01], [3e-4, -2e-4]);
    match (exterior, interior, lens) {
        (Ok(e), Ok(i), Ok(l)) => Frame::new(e, BrownCamera::new(i, l)),
        other => unreachable!("{other:?}"),
    }
}

fn bench(c: &mut Criterion) {
    let frame = camera();
    let ideal = frame.ideal();
    let world: Vec<Point3<f64>> = (0..POINTS)
        .map(|i| {
            let (a, b) = ((i % 37) as f64 - 18.0, (i % 29) as f64 - 14.0);
            Point3::new(389_450.0 + 12.0 * a, 5_819_720.0 + 10.0 * b, 40.0 + (i % 11) as f64)
        })
        .collect();
    let images: Vec<Point2<f64>> = world.iter().filter_map(|w| frame.project(w).ok()).collect();
    assert_eq!(images.len(), POINTS, "every point is in view");
    let ground =
        Plane::from_point_and_normal(Point3::new(389_450.0, 5_819_720.0, 40.0), Vector3::z());
    let Ok(ground) = ground else { unreachable!("a level plane") };

    let mut group = c.benchmark_group("collinearity");
    group.throughput(Throughput::Elements(POINTS as u64));
    group.bench_function("forward, pinhole", |b| {
        b.iter(|| {
            world.iter().filter_map(|w| ideal.project(black_box(w)).ok()).map(|p| p.x).sum::<f64>()
        });
    });
    group.bench_function("forward, Brown", |b| {
        b.iter(|| {
            world.iter().filter_map(|w| frame.project(black_box(w)).ok()).map(|p| p.x).sum::<f64>()
        });
    });
    group.bench_function("forward with partials by object, exterior and interior, Brown", |b| {
        let (mut object, mut exterior, mut interior, mut lens) =
            ([0.0; 6], [0.0; 12], [0.0; 10], [0.0; 10]);
        b.iter(|| {
            let mut sum = 0.0;
            for w in &world {
                let mut groups = [&mut exterior[..], &mut interior[..], &mut lens[..]];
                if frame.partials(black_box(w), &mut object, &mut groups).is_ok() {
                    sum += object[0] + groups[0][3] + groups[2][0];
                }
            }
            sum
        });
    });
    group.bench_function("inverse to a ray, Brown", |b| {
        b.iter(|| {
            let rays = images.iter().filter_map(|p| frame.locus(black_box(p)).ok());
            rays.map(|l| if let Locus::Ray(r) = l { r.direction.x } else { 0.0 }).sum::<f64>()
        });
    });
    group.bench_function("inverse to a plane, Brown", |b| {
        b.iter(|| {
            images
                .iter()
                .filter_map(|p| frame.ground(black_box(p), &ground).ok())
                .map(|p| p.x)
                .sum::<f64>()
        });
    });
    // The same place as a map: 20 px a unit.
    let above = ExteriorOrientation::look_at(
        Point3::new(389_450.0, 5_819_720.0, 900.0),
        Point3::new(389_450.0, 5_819_720.0, 40.0),
        Vector3::y(),
    );
    let scale = Affine2::from_coefficients([500.0, 20.0, 0.0], [400.0, 0.0, 20.0]);
    let Ok(map) = above.and_then(|pose| Orthographic::new(pose, scale)) else {
        unreachable!("a view from above")
    };
    let images: Vec<Point2<f64>> = world.iter().filter_map(|w| map.project(w).ok()).collect();
    group.bench_function("forward, parallel", |b| {
        b.iter(|| {
            world.iter().filter_map(|w| map.project(black_box(w)).ok()).map(|p| p.x).sum::<f64>()
        });
    });
    group.bench_function("forward with partials by object, pose and pixels, parallel", |b| {
        let (mut object, mut pose, mut pixels) = ([0.0; 6], [0.0; 12], [0.0; 12]);
        b.iter(|| {
            let mut sum = 0.0;
            for w in &world {
                let mut groups = [&mut pose[..], &mut pixels[..]];
                if map.partials(black_box(w), &mut object, &mut groups).is_ok() {
                    sum += object[0] + groups[0][3] + groups[1][0];
                }
            }
            sum
        });
    });
    group.bench_function("inverse to a plane, parallel", |b| {
        b.iter(|| {
            let hits = images.iter().filter_map(|p| map.ground(black_box(p), &ground).ok());
            hits.map(|p| p.x).sum::<f64>()
        });
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
