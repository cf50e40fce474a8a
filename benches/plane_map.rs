//! Plane coefficients, rows of coordinates, and polygons filled.

use std::hint::black_box;

use collinear::camera::{Brown, BrownCamera, ExteriorOrientation, Frame, InteriorOrientation};
use collinear::geometry::Plane;
use collinear::mapping::{FractionalLinear, Map, PhotographMap, RowCoords};
use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut, warp};
use collinear::texturer::{Canvas, Paint, ScreenPolygon};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const WIDTH: usize = 1920;
const HEIGHT: usize = 1080;

fn frame(center: [f64; 3], target: [f64; 3]) -> Frame<InteriorOrientation> {
    let exterior =
        ExteriorOrientation::look_at(Point3::from(center), Point3::from(target), Vector3::z());
    let interior = InteriorOrientation::new([1500.0, 1500.0], Point2::new(960.0, 540.0), 0.0);
    match (exterior, interior) {
        (Ok(e), Ok(i)) => Frame::new(e, i),
        other => unreachable!("{other:?}"),
    }
}

fn bench(c: &mut Criterion) {
    // A wall seen obliquely that fills the screen.
    let corners = [[-60.0, -10.0], [60.0, -10.0], [60.0, 60.0], [-60.0, 60.0]]
        .map(|[x, z]| Point3::new(x, 30.0 + 0.3 * x, z));
    let (Ok(plane), screen, photograph) = (
        Plane::through(&corners[0], &corners[1], &corners[2]),
        frame([0.0, 0.0, 5.0], [0.0, 30.0, 6.0]),
        frame([-8.0, -4.0, 9.0], [2.0, 30.0, 5.0]),
    ) else {
        unreachable!("a plane")
    };
    let (eye, texture) = (screen.homogeneous(), photograph.homogeneous());
    let lens = Brown::new([0.05, -0.02, 0.0], [1e-4, 1e-4]);
    let (Ok(map), Ok(nearness), Ok(polygon), Ok(lens)) = (
        FractionalLinear::from_plane(&plane, &texture, &eye),
        eye.nearness(&plane),
        ScreenPolygon::project(&corners, &eye, 0.1),
        lens,
    ) else {
        unreachable!("all in view")
    };
    let through_lens = PhotographMap::from_plane(
        &plane,
        &Frame::new(photograph.exterior, BrownCamera::new(photograph.camera, lens)),
        &eye,
    );
    let Ok(through_lens) = through_lens else { unreachable!("as without the lens") };

    c.bench_function("plane coefficients, closed form", |b| {
        b.iter(|| {
            FractionalLinear::from_plane(black_box(&plane), black_box(&texture), black_box(&eye))
        });
    });
    let four = [[-5.0, 2.0], [5.0, 2.0], [5.0, 9.0], [-5.0, 9.0]]
        .map(|[x, z]| Point3::new(x, 30.0 + 0.3 * x, z));
    c.bench_function("plane coefficients, four points", |b| {
        b.iter(|| {
            FractionalLinear::from_four_points(
                black_box(&four),
                black_box(&texture),
                black_box(&eye),
            )
        });
    });

    let mut group = c.benchmark_group("frame 1920x1080");
    group.throughput(Throughput::Elements((WIDTH * HEIGHT) as u64));
    group.sample_size(20);
    let mut coords = RowCoords::new();
    for (name, map) in
        [("fractional-linear", &map as &dyn Map), ("through the lens", &through_lens)]
    {
        group.bench_function(format!("rows of coordinates, {name}"), |b| {
            b.iter(|| {
                for line in 0..HEIGHT as i32 {
                    map.row(line, 0..WIDTH as i32, &mut coords);
                }
                coords.runs().len()
            });
        });
    }
    let source: Vec<u8> = (0..WIDTH * HEIGHT * 4).map(|i| (i % 251) as u8).collect();
    let mut pixels = vec![0u8; WIDTH * HEIGHT * 4];
    for (name, filter) in [("nearest", Filter::Nearest), ("bilinear", Filter::Bilinear)] {
        group.bench_function(format!("polygon with depth, RGBA8, {name}"), |b| {
            let Ok(image) = ImageView::<u8, 4>::new(&source, WIDTH, HEIGHT) else { unreachable!() };
            b.iter(|| {
                let Ok(view) = ImageViewMut::<u8, 4>::new(&mut pixels, WIDTH, HEIGHT) else {
                    unreachable!()
                };
                let mut canvas = Canvas::new(view);
                let paint = Paint::Texture { image, map: &map, filter, border: Border::Clamp };
                canvas.draw(&polygon, nearness, &paint)
            });
        });
        group.bench_function(format!("warp, Gray8, {name}"), |b| {
            let Ok(image) = ImageView::<u8, 1>::new(&source, WIDTH, HEIGHT) else { unreachable!() };
            b.iter(|| {
                let Ok(mut view) = ImageViewMut::<u8, 1>::new(&mut pixels, WIDTH, HEIGHT) else {
                    unreachable!()
                };
                warp(image, &map, filter, Border::Clamp, &mut view);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
