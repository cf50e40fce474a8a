//! Pixels a second of pictures whose screen is no plane: dome masters, pre-warped pictures, polygons by lines of sight.

use std::hint::black_box;

use collinear::camera::{
    CentralCamera, ExteriorOrientation, Fisheye, Frame, InteriorOrientation, Panorama,
};
use collinear::geometry::{Dome, TriangleMesh};
use collinear::mapping::{Map, RowCoords, SensorMap};
use collinear::nalgebra::{Point2, Point3, Vector3};
use collinear::resample::ImageViewMut;
use collinear::texturer::{Facets, Facing, RayCaster, RayPaint};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const SIDE: i32 = 256;

fn ok<T, E: std::fmt::Debug>(result: Result<T, E>) -> T {
    match result {
        Ok(value) => value,
        Err(e) => unreachable!("{e:?}"),
    }
}

fn looking(place: [f64; 3], target: [f64; 3]) -> ExteriorOrientation {
    ok(ExteriorOrientation::look_at(place.into(), target.into(), Vector3::new(0.1, 0.9, 0.3)))
}

/// A hemisphere of 10 about the origin in `side` × 4 `side` cells of two triangles.
fn dome_mesh(side: u32) -> TriangleMesh {
    let mut vertices = Vec::new();
    for i in 0..=side {
        for j in 0..4 * side {
            let height = std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(side);
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(4 * side);
            let ((z, level), (y, x)) = (height.sin_cos(), turn.sin_cos());
            vertices.push(Point3::new(10.0 * level * x, 10.0 * level * y, 10.0 * z));
        }
    }
    let at = |i: u32, j: u32| i * 4 * side + j % (4 * side);
    let cells = (0..side).flat_map(|i| (0..4 * side).map(move |j| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]]
    });
    ok(TriangleMesh::new(vertices, triangles.collect()))
}

fn rows(c: &mut Criterion, name: &str, map: &dyn Map) {
    let mut group = c.benchmark_group("output_models");
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    let mut row = RowCoords::new();
    group.bench_function(name, |b| {
        b.iter(|| {
            let mut pixels = 0;
            for line in 0..SIDE {
                map.row(line, black_box(0..SIDE), &mut row);
                pixels += row.runs().iter().map(|r| r.len()).sum::<usize>();
            }
            pixels
        });
    });
    group.finish();
}

fn output_models(c: &mut Criterion) {
    let side = f64::from(SIDE);
    let master = ok(InteriorOrientation::from_dome_master(side, std::f64::consts::PI));
    let master = CentralCamera::ideal(master, Fisheye::Equidistant);
    let panorama = ok(InteriorOrientation::from_whole_panorama(4096.0, 2048.0));
    let panorama = CentralCamera::ideal(panorama, Panorama::Equirectangular);
    let up = looking([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let level = looking([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let (master, panorama) = (Frame::new(up, master), Frame::new(level, panorama));
    rows(c, "dome master of a panorama", &SensorMap::distant(master, panorama));

    let lens = ok(InteriorOrientation::new([side; 2], Point2::new(0.5 * side, 0.5 * side), 0.0));
    let projector = Frame::new(looking([0.0, -8.0, -2.0], [0.0, 3.0, 9.0]), lens);
    let dome = ok(Dome::new(Point3::origin(), 10.0, Vector3::z(), std::f64::consts::FRAC_PI_2));
    rows(c, "projector over a dome", &SensorMap::new(projector, dome, master));
    let mesh = dome_mesh(64);
    rows(c, "projector over a mesh of 32,768 triangles", &SensorMap::new(projector, &mesh, master));

    // A street of 1,000 walls about the eye.
    let walls: Vec<Vec<Point3<f64>>> = (0..1000)
        .map(|k| {
            let (k, ring) = (f64::from(k % 100), f64::from(k / 100));
            let (s, c) = (k * 0.0628 + ring).sin_cos();
            let (across, place) =
                (Vector3::new(-s, c, 0.0), Point3::new(c, s, 0.0) * (10.0 + 9.0 * ring));
            let z = Vector3::z() * (2.0 + 0.5 * ring);
            vec![place - across - z, place + across - z, place + across + z, place - across + z]
        })
        .collect();
    let (facets, _) = ok(Facets::new(&walls));
    let paints: Vec<RayPaint<'_, u8, 1>> = (0..1000).map(|k| RayPaint::Flat([k as u8])).collect();
    let panorama = ok(InteriorOrientation::from_whole_panorama(2.0 * side, side));
    let screen = Frame::new(level, CentralCamera::ideal(panorama, Panorama::Equirectangular));
    let caster = RayCaster {
        screen: &screen,
        facets: &facets,
        paints: &paints,
        facing: Facing::Both,
        near: 0.1,
    };
    let (width, height) = (2 * SIDE as usize, SIDE as usize);
    let mut pixels = vec![0_u8; width * height];
    let mut group = c.benchmark_group("output_models");
    group.throughput(Throughput::Elements((width * height) as u64));
    group.bench_function("panorama of 1,000 polygons, lines of sight", |b| {
        b.iter(|| {
            let mut view = ok(ImageViewMut::<u8, 1>::new(&mut pixels, width, height));
            black_box(&caster).draw(&mut view);
        });
    });
    group.finish();
}

criterion_group!(benches, output_models);
criterion_main!(benches);
