//! The texturer where two answers meet: pixel centres on edges, equal nearness, polygons far beyond the screen.

use collinear::Error;
use collinear::camera::{
    ExteriorOrientation, Frame, HomogeneousCamera, InteriorOrientation, Orthographic,
};
use collinear::geometry::Affine2;
use collinear::mapping::Map;
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::resample::ImageViewMut;
use collinear::texturer::{Canvas, Facing, Paint, ScreenPolygon, from_vertices, linear_triangles};
use proptest::prelude::*;

/// A perspective screen at the origin, looking along z with c = 100 pixels.
fn eye() -> HomogeneousCamera {
    let exterior = ExteriorOrientation::new(Point3::origin(), Rotation3::identity());
    let interior = InteriorOrientation::new([100.0; 2], Point2::origin(), 0.0).unwrap();
    Frame::new(exterior, interior).homogeneous()
}

/// A screen whose pixels are world units seen from above.
fn flat_screen() -> HomogeneousCamera {
    let down =
        Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
    let exterior = ExteriorOrientation::new(Point3::new(0.0, 0.0, 10.0), down);
    Orthographic::new(exterior, Affine2::identity()).unwrap().homogeneous()
}

/// The polygon that the flat screen shows with these vertices.
fn polygon(outline: &[[f64; 2]]) -> ScreenPolygon {
    let world: Vec<_> = outline.iter().map(|p| Point3::new(p[0], -p[1], 0.0)).collect();
    ScreenPolygon::project(&world, &flat_screen(), 1.0).unwrap()
}

fn rows(polygon: &ScreenPolygon, width: usize, height: usize) -> Vec<(i32, std::ops::Range<i32>)> {
    let mut rows = Vec::new();
    polygon.spans(width, height, |span| rows.push((span.y, span.x)));
    rows
}

#[test]
fn a_centre_on_a_left_or_upper_edge_is_covered_and_on_a_right_or_lower_one_is_not() {
    // A square through the centres of pixels (1, 1) and (4, 4).
    let square = polygon(&[[1.5, 1.5], [4.5, 1.5], [4.5, 4.5], [1.5, 4.5]]);
    assert_eq!(rows(&square, 9, 9), [(1, 1..4), (2, 1..4), (3, 1..4)]);
    // A diamond about (4½, 4½), its corners on centres 2 away: the upper corner is on two upper edges.
    let diamond = polygon(&[[4.5, 2.5], [6.5, 4.5], [4.5, 6.5], [2.5, 4.5]]);
    assert_eq!(rows(&diamond, 9, 9), [(3, 3..5), (4, 2..6), (5, 3..5)]);
    // 1/256 pixel less or more decides; half of that rounds away from zero.
    let strip = |left: f64, right: f64| {
        rows(&polygon(&[[left, 0.0], [right, 0.0], [right, 1.0], [left, 1.0]]), 9, 9)
    };
    let step = 1.0 / 256.0;
    assert_eq!(strip(1.5 + step, 4.5 + step), [(0, 2..5)]);
    assert_eq!(strip(1.5 - step, 4.5 - step), [(0, 1..4)]);
    assert_eq!(strip(1.5 + 0.5 * step, 4.5 + 0.5 * step), [(0, 2..5)]);
    assert_eq!(strip(1.5 - 0.75 * step, 4.5 - 0.75 * step), [(0, 1..4)]);
    assert_eq!(strip(1.5 + 0.25 * step, 4.5 - 0.25 * step), [(0, 1..4)]);
}

#[test]
fn a_screen_cuts_spans_at_its_sides() {
    let square = polygon(&[[-7.0, -5.0], [20.0, -5.0], [20.0, 30.0], [-7.0, 30.0]]);
    assert_eq!(rows(&square, 3, 2), [(0, 0..3), (1, 0..3)]);
    assert_eq!(rows(&square, 30, 1), [(0, 0..20)]);
    assert_eq!(rows(&square, 0, 5), []);
    for beside in [[-9.0, 0.0], [9.0, 0.0], [0.0, -9.0], [0.0, 9.0]] {
        let [x, y] = beside;
        let square = polygon(&[[x, y], [x + 4.0, y], [x + 4.0, y + 4.0], [x, y + 4.0]]);
        assert_eq!(rows(&square, 5, 5), [], "{beside:?}");
    }
}

#[test]
fn bands_that_reach_far_beyond_the_screen_keep_their_slope() {
    // Between x = y/10 + 2 and y/10 + 6, for 10⁹ pixels either way; then the same with x and y exchanged.
    let far = 1e9;
    let band = [
        [-0.1 * far + 2.0, -far],
        [-0.1 * far + 6.0, -far],
        [0.1 * far + 6.0, far],
        [0.1 * far + 2.0, far],
    ];
    for row in rows(&polygon(&band), 100, 100) {
        let (y, x) = row;
        // The first centre at or right of the edge: x + ½ ≥ (y + ½)/10 + 2, never nearer to it than 1/20.
        let first = (0.1 * f64::from(y) + 1.55).ceil() as i32;
        assert_eq!(x, first..first + 4, "row {y}");
    }
    assert_eq!(rows(&polygon(&band), 100, 100).len(), 100);
    let lying = rows(&polygon(&band.map(|[x, y]| [y, x])), 100, 100);
    for x in 0..100 {
        let first = (0.1 * f64::from(x) + 1.55).ceil() as i32;
        let covered: Vec<i32> = lying.iter().filter(|r| r.1.contains(&x)).map(|r| r.0).collect();
        assert_eq!(covered, (first..first + 4).collect::<Vec<_>>(), "column {x}");
    }
}

proptest! {
    #[test]
    fn the_triangles_of_a_star_cover_its_pixels_once(
        radii in prop::collection::vec(2.0..15.0f64, 4..12), turned in any::<bool>(),
    ) {
        // Vertices at equal angles about (16.3, 16.1): concave as a rule, and never crossing itself.
        let n = radii.len() as f64;
        let mut outline: Vec<[f64; 2]> = radii
            .iter()
            .enumerate()
            .map(|(k, r)| {
                let (sine, cosine) = (std::f64::consts::TAU * k as f64 / n).sin_cos();
                [16.3 + r * cosine, 16.1 + r * sine]
            })
            .collect();
        if turned {
            outline.reverse();
        }
        let star = polygon(&outline);
        let triangles = linear_triangles(&star, &Affine2::identity()).unwrap();
        let count = |pieces: &[&ScreenPolygon]| {
            let mut counts = vec![0u8; 32 * 32];
            for piece in pieces {
                for (y, x) in rows(piece, 32, 32) {
                    for x in x {
                        counts[y as usize * 32 + x as usize] += 1;
                    }
                }
            }
            counts
        };
        let pieces: Vec<_> = triangles.iter().map(|(piece, _)| piece).collect();
        prop_assert_eq!(pieces.len(), outline.len() - 2);
        prop_assert!(count(&pieces) == count(&[&star]));
    }
}

#[test]
fn a_polygon_without_area_shows_no_side() {
    let line = polygon(&[[1.0, 1.0], [5.0, 5.0], [3.0, 3.0]]);
    assert!(!line.is_empty() && line.shows(Facing::Both));
    assert!(!line.shows(Facing::Front) && !line.shows(Facing::Back));
    assert_eq!(rows(&line, 9, 9), []);
}

#[test]
fn of_two_equally_near_polygons_the_first_stays() {
    let square = polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]);
    let mut pixels = [0u8; 12];
    // The picture is 4 wide, and its right column stays as it was.
    let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 4, 3).unwrap());
    assert_eq!((canvas.width(), canvas.height()), (4, 3));
    // 2 + x + 4 y at the centres: at (1, 2) it is 2 + 1½ + 10.
    for value in [1, 2] {
        canvas.draw(&square, [2.0, 1.0, 4.0], &Paint::Flat([value])).unwrap();
    }
    assert_eq!(canvas.nearness(1, 2), Some(13.5));
    assert_eq!(canvas.nearness(0, 0), Some(4.5));
    for (x, y) in [(3, 0), (4, 0), (0, 3), (4, 3), (usize::MAX, 0)] {
        assert_eq!(canvas.nearness(x, y), None, "{x} {y}");
    }
    // Nearer in the left column alone: 10 − 4 x against x at row 0, where both have the same rest.
    canvas.draw(&square, [12.0, -4.0, 4.0], &Paint::Flat([3])).unwrap();
    drop(canvas);
    assert_eq!(pixels, [3, 3, 1, 0, 3, 3, 1, 0, 3, 3, 1, 0]);
}

#[test]
fn coordinates_within_a_tenth_of_a_texel_are_taken_and_others_refused() {
    // Six vertices of an affine texture, 10 texels a unit; one is moved out of its place.
    let outline = [[0.0, 0.0], [8.0, 0.0], [9.0, 4.0], [8.0, 8.0], [0.0, 8.0], [-1.0, 4.0]];
    let world = outline.map(|[x, y]| Point3::new(x, -y, 0.0));
    let textured = |moved: f64| {
        let mut uv = outline.map(|[x, y]| Vector3::new(10.0 * x, 10.0 * y, 1.0));
        uv[0].x += moved;
        from_vertices(&world, &uv, &flat_screen())
    };
    assert!(textured(0.0).is_ok() && textured(0.1).is_ok());
    // No projective map of the plane takes up a whole texel at one of six vertices.
    match textured(1.0) {
        Err(Error::Inconsistent { what: "texture coordinates", residual, limit }) => {
            assert!(limit == 0.1 && residual > 0.1 && residual < 1.0, "{residual}");
        }
        other => panic!("{other:?}"),
    }
    for w in [0.0, -0.0, -1.0, f64::NAN] {
        let mut uv = outline.map(|[x, y]| Vector3::new(x, y, 1.0));
        uv[3].z = w;
        assert!(matches!(
            from_vertices(&world, &uv, &flat_screen()),
            Err(Error::OutOfRange { what: "texture w", .. })
        ));
    }
}

#[test]
fn four_vertices_are_affine_to_a_tenth_of_a_texel_and_projective_beyond() {
    // One corner of a parallelogram moved by m: the least-squares affine map leaves m/4 at every corner, with the signs of a
    // checkerboard.
    let outline = [[0.0, 0.0], [8.0, 0.0], [10.0, 6.0], [2.0, 6.0]];
    let world = outline.map(|[x, y]| Point3::new(x, -y, 0.0));
    for (moved, left) in [(0.0, 0.0), (0.36, 0.09), (0.44, 0.0), (3.0, 0.0)] {
        let mut uv = outline.map(|[x, y]| Vector3::new(10.0 * x, 10.0 * y, 1.0));
        uv[1].y += moved;
        let map = from_vertices(&world, &uv, &flat_screen()).unwrap();
        for ((corner, t), sign) in outline.into_iter().zip(uv).zip([1.0, -1.0, 1.0, -1.0]) {
            let at = map.at(&Point2::from(corner)).unwrap();
            let expected = Point2::new(t.x, t.y + sign * left);
            assert!((at - expected).norm() < 1e-9, "{moved}: {at} {expected}");
        }
    }
}

#[test]
fn a_triangle_with_w_is_textured_in_perspective_of_its_own() {
    // (w u, w v, w) is affine in the plane: half-way from (0, 0, 1) to (12, 24, 3) it is (18, 36, 2), so u = 9, v = 18.
    let world = [[0.0, 0.0], [8.0, 0.0], [0.0, 4.0]].map(|[x, y]| Point3::new(x, -y, 0.0));
    let uvw =
        [Vector3::new(0.0, 0.0, 1.0), Vector3::new(12.0, 24.0, 3.0), Vector3::new(6.0, 10.0, 2.0)];
    let map = from_vertices(&world, &uvw, &flat_screen()).unwrap();
    for (pixel, texture) in [
        ([0.0, 0.0], [0.0, 0.0]),
        ([8.0, 0.0], [12.0, 24.0]),
        ([0.0, 4.0], [6.0, 10.0]),
        ([4.0, 0.0], [9.0, 18.0]),
        // Of the last two: (36 + 12, 72 + 20, 3 + 2) / 2, and so (48, 92) / 5.
        ([4.0, 2.0], [9.6, 18.4]),
    ] {
        let at = map.at(&Point2::from(pixel)).unwrap();
        assert!((at - Point2::from(texture)).norm() < 1e-12, "{at} {texture:?}");
    }
}

#[test]
fn walls_that_face_any_axis_and_of_any_size_are_textured_alike() {
    // A square of 2 × 2 about a point of the plane, with 10 texels a unit: u along its first edge, v along its second. The
    // ray through the square's middle shows (10, 10), and through a quarter of both edges (5, 5).
    let frames = [
        // Seen from the origin: a wall across x, one across y, one across z, and one across (1, 1, 1).
        (Vector3::new(4.0, 0.0, 9.0), Vector3::y(), Vector3::z()),
        (Vector3::new(0.0, 4.0, 9.0), Vector3::z(), Vector3::x()),
        (Vector3::new(0.0, 0.0, 9.0), Vector3::x(), Vector3::y()),
        (Vector3::new(1.0, 2.0, 9.0), Vector3::new(1.0, -1.0, 0.0), Vector3::new(1.0, 1.0, -2.0)),
    ];
    for (middle, u, v) in frames {
        for size in [1e-12, 1.0, 1e20] {
            let world = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(a, b)| Point3::from((middle + u * a + v * b) * size));
            let uv = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]]
                .map(|[a, b]| Vector3::new(a, b, 1.0));
            let map = from_vertices(&world, &uv, &eye()).unwrap();
            for (share, texel) in [(0.0, 10.0), (-0.5, 5.0)] {
                let p = middle + (u + v) * share;
                let at = map.at(&Point2::new(100.0 * p.x / p.z, 100.0 * p.y / p.z)).unwrap();
                assert!((at - Point2::new(texel, texel)).norm() < 1e-10, "{size}: {at}");
            }
        }
    }
}

#[test]
fn vertices_on_the_near_plane_stay() {
    let near = 1.0;
    let seen = |world: &[[f64; 3]]| {
        let world: Vec<_> = world.iter().map(|p| Point3::from(*p)).collect();
        let mut vertices: Vec<[f64; 2]> = Vec::new();
        for v in ScreenPolygon::project(&world, &eye(), near).unwrap().vertices() {
            // A vertex on the plane may be given twice.
            if vertices.last() != Some(&[v.x, v.y]) {
                vertices.push([v.x, v.y]);
            }
        }
        if vertices.len() > 1 && vertices.first() == vertices.last() {
            vertices.pop();
        }
        vertices
    };
    // One vertex on the plane and two behind it; then two on it.
    let triangle = seen(&[[0.5, 0.25, 1.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]]);
    assert_eq!(triangle, [[50.0, 25.0], [100.0, 0.0], [0.0, 100.0]]);
    let triangle = seen(&[[0.5, 0.25, 1.0], [0.75, 0.0, 1.0], [0.0, 2.0, 2.0]]);
    assert_eq!(triangle, [[50.0, 25.0], [75.0, 0.0], [0.0, 100.0]]);
    // One before the plane: its edges are cut at z = 1, half-way.
    let cut = seen(&[[4.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 2.0]]);
    assert_eq!(cut, [[300.0, 0.0], [100.0, 0.0], [0.0, 100.0], [200.0, 100.0]]);
}

#[test]
fn neighbours_are_cut_at_the_same_points_of_their_edge() {
    // Two triangles over one edge that passes the near plane, with awkward numbers and either sense of turn.
    let (a, b) = (Point3::new(0.1, 0.2, 0.3), Point3::new(1.7, -1.1, 3.9));
    let sides = [Point3::new(-2.3, -0.7, 2.9), Point3::new(2.9, 1.3, 3.1)];
    for near in [0.35, 1.0 / 3.0, 0.7, 1.9, 3.3] {
        let cut = |outline: [Point3<f64>; 3]| {
            let polygon = ScreenPolygon::project(&outline, &eye(), near).unwrap();
            polygon.vertices().iter().map(|v| [v.x.to_bits(), v.y.to_bits()]).collect::<Vec<_>>()
        };
        let (left, right) = (cut([a, b, sides[0]]), cut([b, a, sides[1]]));
        // b itself and the cut of ab, to the bit.
        let shared = left.iter().filter(|v| right.contains(v)).count();
        assert_eq!(shared, 2, "{near}");
    }
}
