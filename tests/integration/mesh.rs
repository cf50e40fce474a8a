//! Triangle meshes against every triangle tried one by one, with formulas of the test's own.

use collinear::camera::{ExteriorOrientation, Frame, InteriorOrientation, SensorModel};
use collinear::geometry::{Dome, HeightCurve, Locus, Ray, Sphere, Surface, TriangleMesh};
use collinear::mapping::{Map, SensorMap};
use collinear::nalgebra::{Matrix3, Point2, Point3, Vector2, Vector3};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

use crate::support;

/// The distance at which a ray meets a triangle, by solving o + t d = a + u (b − a) + v (c − a); with how clear of the edges it is.
fn solved(ray: &Ray, [a, b, c]: [Point3<f64>; 3]) -> Option<(f64, f64)> {
    let system = Matrix3::from_columns(&[-ray.direction.into_inner(), b - a, c - a]);
    let x = system.lu().solve(&(ray.origin - a))?;
    let clear = x.y.min(x.z).min(1.0 - x.y - x.z);
    x.iter().all(|e| e.is_finite()).then_some((x.x, clear))
}

/// The squared distance of a point from a triangle: of the foot on its plane where that is inside, else of the nearest edge.
fn squared_distance(p: &Point3<f64>, [a, b, c]: [Point3<f64>; 3]) -> f64 {
    let normal = (b - a).cross(&(c - a));
    let foot = p - normal * (normal.dot(&(p - a)) / normal.norm_squared());
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| (to - from).cross(&(foot - from)).dot(&normal) >= 0.0);
    if inside {
        return (p - foot).norm_squared();
    }
    let edge = |(from, to): (Point3<f64>, Point3<f64>)| {
        let along = to - from;
        let t = (along.dot(&(p - from)) / along.norm_squared()).clamp(0.0, 1.0);
        (p - (from + along * t)).norm_squared()
    };
    [(a, b), (b, c), (c, a)].map(edge).into_iter().fold(f64::INFINITY, f64::min)
}

/// A sphere of triangles: an octahedron whose faces are divided in four `depth` times.
fn ball(radius: f64, depth: u32) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let mut vertices =
        vec![Vector3::x(), Vector3::y(), Vector3::z(), -Vector3::x(), -Vector3::y(), -Vector3::z()];
    let mut triangles = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    for _ in 0..depth {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let sum = vertices[i as usize] + vertices[j as usize];
                    vertices.push(sum.normalize());
                    vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (vertices.into_iter().map(|v| Point3::from(v * radius)).collect(), triangles)
}

/// Triangles strewn about, small and large, some without area.
fn soup() -> impl Strategy<Value = (Vec<Point3<f64>>, Vec<[u32; 3]>)> {
    (3_usize..60).prop_flat_map(|count| {
        let vertices = prop::collection::vec(support::point(10.0), count);
        let number = 0..count as u32;
        let triangle = (number.clone(), number.clone(), number).prop_map(|(a, b, c)| [a, b, c]);
        (vertices, prop::collection::vec(triangle, 1..120))
    })
}

fn corners(mesh: &TriangleMesh, i: usize) -> [Point3<f64>; 3] {
    mesh.triangles()[i].map(|v| mesh.vertices()[v as usize])
}

proptest! {
    #[test]
    fn a_ray_meets_first_what_no_other_triangle_is_before(
        (vertices, triangles) in soup(), origin in support::point(15.0), towards in support::point(8.0),
    ) {
        let mesh = TriangleMesh::new(vertices, triangles).unwrap();
        let Ok(ray) = Ray::new(origin, towards - origin) else { return Ok(()) };
        let hits: Vec<_> = (0..mesh.triangles().len())
            .filter_map(|i| solved(&ray, corners(&mesh, i)).map(|(t, clear)| (i, t, clear)))
            .collect();
        let found = mesh.first_hit(&ray);
        // Those that are met with a margin are not passed over.
        for (i, t, _) in hits.iter().filter(|h| h.1 > 1e-9 && h.2 > 1e-9) {
            let found = found.expect("a triangle is met");
            prop_assert!(found.distance <= t + 1e-9, "{found:?}, {i} at {t}");
        }
        // And what is found is met.
        if let Some(found) = found {
            let own = hits.iter().find(|h| h.0 == found.triangle);
            let (_, t, clear) = *own.expect("it has an area");
            prop_assert!(clear > -1e-7, "{clear}");
            prop_assert!((t - found.distance).abs() < 1e-9 * (1.0 + t.abs()) || clear < 1e-7);
        }
    }

    #[test]
    fn the_nearest_point_is_as_near_as_any_triangle(
        (vertices, triangles) in soup(), p in support::point(14.0),
    ) {
        // An edge of no length has no nearest point by the test's own formula.
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| vertices[v as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let triangles: Vec<_> = triangles.into_iter().filter(|t| area(t) > 1e-3).collect();
        prop_assume!(!triangles.is_empty());
        let mesh = TriangleMesh::new(vertices, triangles).unwrap();
        let least = (0..mesh.triangles().len())
            .map(|i| squared_distance(&p, corners(&mesh, i)))
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        let (triangle, point) = mesh.nearest(&p).unwrap();
        prop_assert!(((point - p).norm() - least).abs() < 1e-9);
        prop_assert!(squared_distance(&point, corners(&mesh, triangle)).sqrt() < 1e-9);
        prop_assert!((mesh.height_above(&p).abs() - least).abs() < 1e-9);
    }
}

#[test]
fn no_ray_passes_between_triangles() {
    let (vertices, triangles) = ball(7.0, 3);
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let origins = [Point3::origin(), Point3::new(0.3, -1.7, 2.1), Point3::new(-4.0, 1e-3, 0.0)];
    let mut rays = 0;
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| mesh.vertices()[v as usize]);
        let middle = |p: Point3<f64>, q: Point3<f64>| halfway(&p, &q);
        // At vertices, and on edges at their middles and elsewhere.
        let targets = [a, b, c, middle(a, b), middle(b, c), a + (b - a) / 3.0, b + (c - b) * 0.9];
        for target in targets {
            for origin in origins {
                let hit = mesh.meet_ray(&Ray::new(origin, target - origin).unwrap()).unwrap();
                assert!((hit - target).norm() < 1e-13 * 70.0, "{hit} {target}");
                rays += 1;
            }
        }
    }
    assert_eq!(rays, 512 * 21);
}

fn halfway(p: &Point3<f64>, q: &Point3<f64>) -> Point3<f64> {
    p + (q - p) * 0.5
}

#[test]
fn heights_are_positive_on_the_front_and_normals_point_there() {
    let (vertices, triangles) = ball(2.0, 4);
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    for i in 0..400 {
        let turn = f64::from(i) * 2.399;
        let z = f64::from(2 * i + 1) / 400.0 - 1.0;
        let d =
            Vector3::new(turn.cos() * (1.0 - z * z).sqrt(), turn.sin() * (1.0 - z * z).sqrt(), z);
        for (length, sign) in [(2.5, 1.0), (1.7, -1.0)] {
            let height = mesh.height_above(&Point3::from(d * length));
            // The triangles stay 0.6 % within their sphere.
            assert!((height - (length - 2.0)).abs() < 0.013, "{height}");
            assert!(height * sign > 0.0);
        }
        let normal = mesh.normal(&Point3::from(d * 2.0)).unwrap();
        assert!(normal.dot(&d) > 0.995, "{normal:?} {d}");
    }
}

#[test]
fn a_roof_tells_its_sides_at_the_ridge_and_the_gutter() {
    // Two slopes that meet at y = 0 under a right angle.
    let vertices = [[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [2.0, -1.0, 0.0], [2.0, 1.0, 0.0]];
    let mesh =
        TriangleMesh::new(vertices.map(Point3::from).to_vec(), vec![[0, 2, 1], [0, 1, 3]]).unwrap();
    // Above the ridge, to either side of its plane of symmetry; and below it.
    for (y, z, expected) in [(0.1, 1.5, 0.26_f64.sqrt()), (-0.1, 1.5, 0.26_f64.sqrt())] {
        let height = mesh.height_above(&Point3::new(2.0, y, z));
        assert!((height - expected).abs() < 1e-15, "{height}");
    }
    // Half a unit under the ridge each slope is 0.5/√2 away.
    let height = mesh.height_above(&Point3::new(2.0, 0.0, 0.5));
    assert!((height + 0.125_f64.sqrt()).abs() < 1e-15, "{height}");
}

#[test]
fn a_curve_over_height_meets_a_mesh() {
    // A square of two triangles at z = 30, and the curve x = 3 + (z − 10)/4 + (z − 10)²/1000.
    let vertices = [[-9.0, -9.0], [50.0, -9.0], [50.0, 9.0], [-9.0, 9.0]];
    let vertices = vertices.map(|[x, y]| Point3::new(x, y, 30.0)).to_vec();
    let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let curve = HeightCurve {
        coefficients: [
            Vector3::new(3.0, 1.0, 10.0),
            Vector3::new(0.25, 0.0, 1.0),
            Vector3::new(1e-3, 0.0, 0.0),
            Vector3::zeros(),
        ],
        reference_height: 10.0,
        heights: [0.0, 100.0],
        error_bound: 0.0,
    };
    let hit = mesh.meet(&Locus::Curve(curve)).unwrap();
    assert!((hit - Point3::new(3.0 + 5.0 + 0.4, 1.0, 30.0)).norm() < 1e-12, "{hit}");
}

#[test]
fn a_dome_of_triangles_warps_as_the_dome_to_their_sagitta() {
    let (vertices, triangles) = ball(10.0, 6);
    let count = triangles.len();
    let mesh = TriangleMesh::new(vertices, triangles).unwrap();
    let camera = |place: [f64; 3], target: [f64; 3]| {
        let exterior =
            ExteriorOrientation::look_at(place.into(), target.into(), Vector3::new(0.1, 0.9, 0.2));
        let interior = InteriorOrientation::new([1200.0; 2], Point2::new(960.0, 540.0), 0.0);
        Frame::new(exterior.unwrap(), interior.unwrap())
    };
    let projector = camera([0.0, -6.0, -3.0], [0.0, 4.0, 8.0]);
    let view = camera([0.5, 0.3, 0.0], [0.5, 4.0, 8.0]);
    let sphere = Sphere::new(Point3::origin(), 10.0).unwrap();
    let by_mesh = SensorMap::new(projector, &mesh, view);
    let by_dome = SensorMap::new(projector, sphere, view);
    // An edge of an eighth of a turn/64 sinks 10 (1 − cos(π/256)) below the sphere, a face a little more; at ten from the eye a pixel
    // is 1/120, the parallax between projector and eye below one.
    let sagitta = 10.0 * (1.0 - (std::f64::consts::PI / 256.0).cos()) * 4.0;
    let mut compared = 0;
    for i in 0..32 {
        for j in 0..18 {
            let pixel = Point2::new(30.0 + 60.0 * f64::from(i), 30.0 + 60.0 * f64::from(j));
            let (Ok(a), Ok(b)) = (by_mesh.at(&pixel), by_dome.at(&pixel)) else { continue };
            assert!((a - b).norm() < 120.0 * 2.0 * sagitta, "{a} {b}");
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
    // The mesh's own slope: of its flat triangle, by a small step within it.
    let pixel = Point2::new(900.3, 500.2);
    let slopes = by_mesh.jacobian(&pixel).unwrap();
    let h = 1e-4;
    for k in 0..2 {
        let step = Vector2::ith(k, h);
        let d = (by_mesh.at(&(pixel + step)).unwrap() - by_mesh.at(&(pixel - step)).unwrap())
            / (2.0 * h);
        assert!((d - slopes.column(k)).norm() < 1e-6, "{d} {slopes}");
    }
    assert_eq!(count, 8 * 4096);
    assert!(projector.ground(&pixel, &mesh).is_ok());
    assert!(Dome::new(Point3::origin(), 10.0, Vector3::z(), 1.0).is_ok());
}

#[test]
fn rays_along_the_axes_in_the_planes_of_faces_and_boxes_do_not_slip_through() {
    // A cube of two triangles a side, met along its own sides' directions.
    let corner = |i: u32| {
        let bit = |k: u32| f64::from(i >> k & 1);
        Point3::new(bit(0), bit(1), bit(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap();
    for (x, y) in [(0.5, 0.5), (0.25, 0.75), (0.0, 0.5), (1.0, 0.5), (0.0, 0.0), (1.0, 1.0)] {
        for (origin, direction) in [
            (Point3::new(x, y, -2.0), Vector3::z()),
            (Point3::new(x, -2.0, y), Vector3::y()),
            (Point3::new(-2.0, x, y), Vector3::x()),
        ] {
            let hit = mesh.first_hit(&Ray::new(origin, direction).unwrap()).unwrap();
            assert_eq!(hit.distance, 2.0, "{origin}");
            let back = Ray::new(origin + direction * 5.0, -direction).unwrap();
            assert_eq!(mesh.first_hit(&back).unwrap().distance, 2.0, "{origin}");
            assert!(mesh.first_hit(&Ray::new(origin, -direction).unwrap()).is_none());
        }
    }
}

#[test]
fn of_triangles_at_one_distance_the_first_is_met() {
    let corners = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 4.0, 5.0]].map(Point3::from).to_vec();
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]; 40]).unwrap();
    let hit = mesh.first_hit(&Ray::new(Point3::new(1.0, 1.0, 0.0), Vector3::z()).unwrap()).unwrap();
    assert_eq!((hit.triangle, hit.distance), (0, 5.0));
}

#[test]
fn bad_meshes_are_refused_with_numbers() {
    let p = |x: f64| Point3::new(x, 0.0, 1.0);
    let bad = TriangleMesh::new(vec![p(0.0), p(1.0)], vec![[0, 1, 2]]).unwrap_err();
    assert_eq!(bad.to_string(), "number of a mesh vertex is 2, expected one of the vertices");
    let bad = TriangleMesh::new(vec![p(0.0), p(f64::NAN), p(1.0)], vec![[0, 1, 2]]).unwrap_err();
    assert_eq!(bad, Error::NotFinite { what: "mesh vertex" });
    assert_eq!(
        TriangleMesh::new(vec![p(1.0)], vec![]),
        Err(Error::TooFewPoints { needed: 3, got: 0 })
    );
    // Triangles without area are carried, and never met.
    let mesh = TriangleMesh::new(vec![p(0.0), p(1.0), p(2.0)], vec![[0, 1, 2], [1, 1, 1]]).unwrap();
    let ray = Ray::new(Point3::new(0.5, -1.0, 1.0), Vector3::y()).unwrap();
    assert_eq!(mesh.meet_ray(&ray), Err(ProjectionError::MissesSurface));
    assert_eq!(mesh.normal(&p(0.5)), Err(ProjectionError::NotFinite));
    assert!(mesh.height_above(&Point3::new(f64::NAN, 0.0, 0.0)).is_nan());
    // Huge coordinates stay numbers or errors.
    let far = [[-1e300, -1e300, 1e300], [1e300, -1e300, 1e300], [0.0, 1e300, 1e300]];
    let mesh = TriangleMesh::new(far.map(Point3::from).to_vec(), vec![[0, 1, 2]]).unwrap();
    let _ = mesh.meet_ray(&Ray::new(Point3::origin(), Vector3::z()).unwrap());
    let _ = (mesh.height_above(&Point3::origin()), mesh.normal(&Point3::origin()));
}
