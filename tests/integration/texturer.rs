//! The texturer against counted pixels and rays cast by hand.

use collinear::camera::{
    ExteriorOrientation, Frame, HomogeneousCamera, InteriorOrientation, Orthographic,
};
use collinear::geometry::{Affine2, Plane};
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut};
use collinear::texturer::{
    Canvas, Facing, Paint, ScreenPolygon, bilinear_quad, from_vertices, linear_triangles,
};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

use crate::support::{PlainCamera, cast};

/// A screen whose pixels are world units seen from above: x right, y up in the world, line 0 at y = 0 downwards.
fn flat_screen() -> HomogeneousCamera {
    let down =
        Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
    let exterior = ExteriorOrientation::new(Point3::new(0.0, 0.0, 10.0), down);
    Orthographic::new(exterior, Affine2::identity()).unwrap().homogeneous()
}

/// A point that the flat screen shows at (x, y).
fn at(x: f64, y: f64) -> Point3<f64> {
    Point3::new(x, -y, 0.0)
}

fn flat_polygon(outline: &[[f64; 2]]) -> ScreenPolygon {
    let world: Vec<_> = outline.iter().map(|p| at(p[0], p[1])).collect();
    ScreenPolygon::project(&world, &flat_screen(), 1.0).unwrap()
}

fn count(counts: &mut [u32], width: usize, height: usize, polygon: &ScreenPolygon) {
    polygon.spans(width, height, |span| {
        for x in span.x {
            counts[span.y as usize * width + x as usize] += 1;
        }
    });
}

proptest! {
    #[test]
    fn polygons_that_share_an_edge_cover_every_pixel_once(
        jitter in prop::collection::vec((-0.24..0.24f64, -0.24..0.24f64), 49),
        diagonals in prop::collection::vec(any::<bool>(), 36),
        step in 1.0..9.0f64, snap in any::<bool>(),
    ) {
        // A 6 × 6 patch of quadrilaterals, each cut along one diagonal or the other, at any sub-pixel position or with
        // vertices exactly on pixel centres.
        let vertex = |i: usize, j: usize| {
            let (dx, dy) = jitter[j * 7 + i];
            let p = [(i as f64 + dx) * step + 3.0, (j as f64 + dy) * step + 3.0];
            if snap { p.map(|c| c.floor() + 0.5) } else { p }
        };
        let (width, height) = (70, 70);
        let mut counts = vec![0; width * height];
        for j in 0..6 {
            for i in 0..6 {
                let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                let pieces = if diagonals[j * 6 + i] { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                for piece in pieces {
                    count(&mut counts, width, height, &flat_polygon(&piece));
                }
            }
        }
        let mut outline: Vec<[f64; 2]> = (0..6).map(|i| vertex(i, 0)).collect();
        outline.extend((0..6).map(|j| vertex(6, j)));
        outline.extend((0..6).map(|i| vertex(6 - i, 6)));
        outline.extend((0..6).map(|j| vertex(0, 6 - j)));
        let mut whole = vec![0; width * height];
        count(&mut whole, width, height, &flat_polygon(&outline));
        // Jitter below a quarter keeps every quadrilateral convex; on pixel centres they may fold, and nothing may panic.
        if !snap {
            prop_assert!(counts == whole, "some pixel is covered twice or not at all");
        }
    }

    #[test]
    fn coverage_is_the_crossing_number_of_the_pixel_centre(
        outline in prop::collection::vec((-5.0..40.0f64, -5.0..40.0f64), 3..9), halves in any::<bool>(),
    ) {
        // Any outline, concave or crossing itself, or with its vertices on corners and centres of pixels; the oracle counts
        // crossings of a ray to the left in exact integers.
        let place = |c: f64| if halves { (2.0 * c).round() / 2.0 } else { c };
        let points: Vec<[f64; 2]> = outline.iter().map(|p| [place(p.0), place(p.1)]).collect();
        let snapped: Vec<[i64; 2]> =
            points.iter().map(|p| [(p[0] * 256.0).round() as i64, (p[1] * 256.0).round() as i64]).collect();
        let (width, height) = (36, 36);
        let mut counts = vec![0; width * height];
        count(&mut counts, width, height, &flat_polygon(&points));
        for y in 0..height {
            for x in 0..width {
                let (cx, cy) = (256 * x as i64 + 128, 256 * y as i64 + 128);
                let mut crossings = 0;
                for (a, b) in snapped.iter().zip(snapped.iter().cycle().skip(1)) {
                    // Half-open in y: an edge's upper end belongs to it, its lower end does not.
                    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                    if a[1] <= cy && cy < b[1] {
                        // On the edge or right of it.
                        let side = (cx - a[0]) * (b[1] - a[1]) - (cy - a[1]) * (b[0] - a[0]);
                        crossings += u32::from(side >= 0);
                    }
                }
                prop_assert_eq!(counts[y * width + x], crossings % 2, "{} {}", x, y);
            }
        }
    }

    #[test]
    fn cutting_a_polygon_along_any_chord_changes_no_pixel_where_linear_interpolation_does(
        ends in (0.1..0.9f64, 0.1..0.9f64), tilt in -0.8..0.8f64,
    ) {
        let screen = eye();
        let corners = [[-4.0, 0.0], [4.0, 0.0], [4.0, 6.0], [-4.0, 6.0]]
            .map(|[x, z]| Point3::new(x, 12.0 + tilt * x + 0.3 * z, z));
        let plane = Plane::fit(&corners).unwrap().plane;
        let texture = Frame::new(
            ExteriorOrientation::look_at(Point3::new(-8.0, 2.0, 5.0), Point3::new(0.0, 12.0, 3.0), Vector3::z()).unwrap(),
            InteriorOrientation::new([300.0, 300.0], Point2::new(160.0, 120.0), 0.0).unwrap(),
        );
        let image = noise(320, 240);
        let view = ImageView::<u8, 1>::new(&image, 320, 240).unwrap();
        let map = FractionalLinear::from_plane(&plane, &texture.homogeneous(), &screen).unwrap();
        let (lower, upper) = (
            corners[0] + (corners[1] - corners[0]) * ends.0,
            corners[3] + (corners[2] - corners[3]) * ends.1,
        );
        let pieces = [
            vec![corners[0], lower, upper, corners[3]],
            vec![lower, corners[1], corners[2], upper],
        ];
        let whole = [corners.to_vec()];
        let exact = |outlines: &[Vec<Point3<f64>>]| {
            draw(outlines, &screen, &plane, |_| vec![&map as &dyn Map], view)
        };
        // Snapping moves a vertex by at most √2/512 pixel, the chord's ends too: a centre that changes sides lies that
        // near to the outline. Every pixel that both draw is the same to the bit.
        let (one, two) = (exact(&whole), exact(&pieces));
        let seen = corners.map(|p| {
            let [x, y, _] = plain_eye().project([p.x, p.y, p.z]);
            Point2::new(x, y)
        });
        for i in (0..one.len()).filter(|&i| (one[i] == 0) != (two[i] == 0)) {
            let centre = Point2::new((i % 200) as f64 + 0.5, (i / 200) as f64 + 0.5);
            let distance = (0..4)
                .map(|k| distance_to_segment(&centre, &seen[k], &seen[(k + 1) % 4]))
                .fold(f64::INFINITY, f64::min);
            prop_assert!(distance < 2f64.sqrt() / 512.0 + 1e-9, "{centre}: {distance} px from the outline");
        }
        let inner = one.iter().zip(&two).filter(|(a, b)| **a != 0 && **b != 0 && a != b).count();
        prop_assert_eq!(inner, 0);
        let linear = |outlines: &[Vec<Point3<f64>>]| {
            let mut pixels = vec![0u8; 200 * 160];
            let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 200, 160).unwrap());
            for outline in outlines {
                let polygon = ScreenPolygon::project(outline, &screen, 0.1).unwrap();
                for (piece, map) in linear_triangles(&polygon, &map).unwrap() {
                    let paint = Paint::Texture { image: view, map: &map, filter: Filter::Nearest, border: Border::Clamp };
                    canvas.draw(&piece, screen.nearness(&plane).unwrap(), &paint).unwrap();
                }
            }
            drop(canvas);
            pixels
        };
        let (a, b) = (linear(&whole), linear(&pieces));
        let changed = a.iter().zip(&b).filter(|(a, b)| a != b).count();
        prop_assert!(changed > 50, "{changed} pixels");
    }

    #[test]
    fn what_is_drawn_is_what_the_ray_meets_first(seed in 0..1000u64) {
        // Three random quadrilaterals that may pierce each other and pass behind the eye; every pixel by hand.
        let mut state = seed;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31)
        };
        let screen = eye();
        let near = 0.5;
        let mut quads = Vec::new();
        while quads.len() < 3 {
            let c = Point3::new(8.0 * random() - 4.0, 12.0 * random() - 2.0, 6.0 * random() - 1.0);
            let u = Vector3::new(random() - 0.5, random() - 0.5, random() - 0.5) * 14.0;
            let v = Vector3::new(random() - 0.5, random() - 0.5, random() - 0.5) * 14.0;
            let corners = [c - u - v, c + u - v, c + u + v, c - u + v];
            let Ok(plane) = Plane::through(&corners[0], &corners[1], &corners[2]) else { continue };
            // Seen at a grazing angle the oracle's own rounding decides; keep clear of it.
            if plane.signed_distance(&Point3::new(0.0, 0.0, 2.0)).abs() > 0.3 && u.cross(&v).norm() > 1.0 {
                quads.push((c, u, v, plane));
            }
        }
        let mut pixels = vec![0u8; 200 * 160];
        let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 200, 160).unwrap());
        for (k, (c, u, v, plane)) in quads.iter().enumerate() {
            let corners = [c - u - v, c + u - v, c + u + v, c - u + v];
            let polygon = ScreenPolygon::project(&corners, &screen, near).unwrap();
            canvas.draw(&polygon, screen.nearness(plane).unwrap(), &Paint::Flat([k as u8 + 1])).unwrap();
        }
        drop(canvas);
        let camera = plain_eye();
        let mut differing = 0;
        for y in (0..160).step_by(3) {
            for x in (0..200).step_by(3) {
                // Coverage is decided at a twentieth of a pixel round the centre, or left open.
                let answer = |dx: f64, dy: f64| {
                    let ray = camera.ray([f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy]);
                    let mut best = (f64::INFINITY, 0u8);
                    for (k, (c, u, v, plane)) in quads.iter().enumerate() {
                        let (hit, t) = cast(camera.center, ray, &plane.point(), &plane.normal());
                        let d = Vector3::from(hit) - c.coords;
                        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
                        let det = uu * vv - uv * uv;
                        let (du, dv) = (d.dot(u), d.dot(v));
                        let (a, b) = ((vv * du - uv * dv) / det, (uu * dv - uv * du) / det);
                        if t > near && a.abs() <= 1.0 && b.abs() <= 1.0 && t < best.0 {
                            best = (t, k as u8 + 1);
                        }
                    }
                    best.1
                };
                let around = [[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]].map(|[a, b]| answer(a, b));
                let open = around.iter().any(|a| *a != around[0]);
                if !open && pixels[y as usize * 200 + x as usize] != around[0] {
                    differing += 1;
                }
            }
        }
        prop_assert_eq!(differing, 0);
    }
}

fn distance_to_segment(p: &Point2<f64>, a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    let side = b - a;
    let share = ((p - a).dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
    (p - (a + side * share)).norm()
}

/// An eye at (0, 0, 2) looking along +y, 200 × 160 pixels.
fn eye_frame() -> Frame<InteriorOrientation> {
    Frame::new(
        ExteriorOrientation::look_at(
            Point3::new(0.0, 0.0, 2.0),
            Point3::new(0.0, 10.0, 2.5),
            Vector3::z(),
        )
        .unwrap(),
        InteriorOrientation::new([150.0, 150.0], Point2::new(100.0, 80.0), 0.0).unwrap(),
    )
}

fn eye() -> HomogeneousCamera {
    eye_frame().homogeneous()
}

fn plain_eye() -> PlainCamera {
    let frame = eye_frame();
    PlainCamera::new(&frame.exterior, &frame.camera)
}

/// Grey values, none of them zero, that hardly two neighbours share.
fn noise(width: usize, height: usize) -> Vec<u8> {
    (0..width * height).map(|i| ((i * 7919 % 251) as u8 ^ ((i / width) * 37) as u8) | 1).collect()
}

fn draw<'m>(
    outlines: &[Vec<Point3<f64>>],
    screen: &HomogeneousCamera,
    plane: &Plane,
    maps: impl Fn(&ScreenPolygon) -> Vec<&'m dyn Map>,
    view: ImageView<'_, u8, 1>,
) -> Vec<u8> {
    let mut pixels = vec![0u8; 200 * 160];
    let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 200, 160).unwrap());
    for outline in outlines {
        let polygon = ScreenPolygon::project(outline, screen, 0.1).unwrap();
        for map in maps(&polygon) {
            let paint =
                Paint::Texture { image: view, map, filter: Filter::Nearest, border: Border::Clamp };
            canvas.draw(&polygon, screen.nearness(plane).unwrap(), &paint).unwrap();
        }
    }
    drop(canvas);
    pixels
}

#[test]
fn coordinates_at_vertices_are_laid_on_the_plane() {
    // A square of 4 × 4 world units carries 40 × 40 texels; the texel under a pixel follows from the ray by hand.
    let screen = eye();
    let (o, u, v) =
        (Point3::new(-2.0, 6.0, 1.0), Vector3::new(4.0, 1.0, 0.0), Vector3::new(0.0, 2.0, 3.0));
    let world = [o, o + u, o + u + v, o + v, o + v * 0.5 - u * 0.25];
    let uv = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0], [-10.0, 20.0]]
        .map(|[a, b]| Vector3::new(a, b, 1.0));
    let plane = Plane::fit(&world[..3]).unwrap().plane;
    let map = from_vertices(&world, &uv, &screen).unwrap();
    let triangle = from_vertices(&world[..3], &uv[..3], &screen).unwrap();
    let camera = plain_eye();
    for pixel in [[100.5, 60.5], [80.5, 90.5], [120.5, 70.5]] {
        let (hit, _) = cast(camera.center, camera.ray(pixel), &plane.point(), &plane.normal());
        let d = Vector3::from(hit) - o.coords;
        let (uu, uv, vv) = (u.dot(&u), u.dot(&v), v.dot(&v));
        let det = uu * vv - uv * uv;
        let (du, dv) = (d.dot(&u), d.dot(&v));
        let expected = Point2::new((vv * du - uv * dv) / det, (uu * dv - uv * du) / det) * 40.0;
        for map in [&map, &triangle] {
            let found = map.at(&Point2::from(pixel)).unwrap();
            assert!((found - expected).norm() < 1e-10, "{found} {expected}");
        }
    }
    // A rectangle given a trapezium of texture: the projective map of its plane, corners exact.
    let trapezium =
        [[0.0, 0.0], [40.0, 5.0], [40.0, 35.0], [0.0, 40.0]].map(|[a, b]| Vector3::new(a, b, 1.0));
    let map = from_vertices(&world[..4], &trapezium, &screen).unwrap();
    for (w, t) in world.iter().zip(trapezium) {
        let [x, y, _] = camera.project([w.x, w.y, w.z]);
        assert!((map.at(&Point2::new(x, y)).unwrap() - t.xy().into_point()).norm() < 1e-9);
    }
    // Five vertices that no projective map serves.
    let mut wrong = uv;
    wrong[4].x += 3.0;
    assert!(matches!(from_vertices(&world, &wrong, &screen), Err(Error::Inconsistent { .. })));
    let behind = [Vector3::new(0.0, 0.0, -1.0), uv[1], uv[2]];
    assert!(matches!(from_vertices(&world[..3], &behind, &screen), Err(Error::OutOfRange { .. })));
    assert!(matches!(from_vertices(&world, &uv[..3], &screen), Err(Error::LengthMismatch { .. })));
}

/// Vectors as points, for comparisons.
trait IntoPoint {
    fn into_point(self) -> Point2<f64>;
}

impl IntoPoint for collinear::nalgebra::Vector2<f64> {
    fn into_point(self) -> Point2<f64> {
        Point2::from(self)
    }
}

#[test]
fn projected_coordinates_with_w_are_a_texture_camera() {
    // Vertices that store (u, v, w) of a projector give the projector's own map ([S] eq. 5 and 7).
    let screen = eye();
    let projector = Frame::new(
        ExteriorOrientation::look_at(
            Point3::new(-6.0, 1.0, 4.0),
            Point3::new(0.0, 9.0, 2.0),
            Vector3::z(),
        )
        .unwrap(),
        InteriorOrientation::new([300.0, 300.0], Point2::new(160.0, 120.0), 0.0).unwrap(),
    );
    let plain = PlainCamera::new(&projector.exterior, &projector.camera);
    let world =
        [[-2.0, 8.0, 0.5], [2.0, 10.0, 0.5], [2.0, 10.0, 4.0], [-2.0, 8.0, 4.0]].map(Point3::from);
    let uvw = world.map(|p| Vector3::from(plain.project([p.x, p.y, p.z])));
    let plane = Plane::fit(&world).unwrap().plane;
    let stored = from_vertices(&world, &uvw, &screen).unwrap();
    let direct = FractionalLinear::from_plane(&plane, &projector.homogeneous(), &screen).unwrap();
    for p in [[90.0, 70.0], [110.0, 60.0]] {
        let p = Point2::from(p);
        assert!((stored.at(&p).unwrap() - direct.at(&p).unwrap()).norm() < 1e-9);
    }
}

#[test]
fn the_three_interpolations_of_figure_2() {
    // A square that stands obliquely, a 64 × 64 texture on it.
    let screen = eye();
    let world =
        [[-3.0, 5.0, 4.0], [3.0, 14.0, 4.0], [3.0, 14.0, 0.0], [-3.0, 5.0, 0.0]].map(Point3::from);
    let uv =
        [[0.0, 0.0], [64.0, 0.0], [64.0, 64.0], [0.0, 64.0]].map(|[a, b]| Vector3::new(a, b, 1.0));
    let exact = from_vertices(&world, &uv, &screen).unwrap();
    let polygon = ScreenPolygon::project(&world, &screen, 0.1).unwrap();
    let corners: Vec<_> = polygon.vertices().to_vec();
    // All agree at the corners.
    let bilinear = bilinear_quad(&polygon, &exact).unwrap();
    let linear = linear_triangles(&polygon, &exact).unwrap();
    assert_eq!(linear.len(), 2);
    for (corner, uv) in corners.iter().zip(uv) {
        assert!((bilinear.at(corner).unwrap().coords - uv.xy()).norm() < 1e-9);
        assert!((exact.at(corner).unwrap().coords - uv.xy()).norm() < 1e-9);
        let touching: Vec<_> =
            linear.iter().filter(|(piece, _)| piece.vertices().contains(corner)).collect();
        assert!(!touching.is_empty());
        for (_, map) in touching {
            assert!((map.at(corner).unwrap().coords - uv.xy()).norm() < 1e-9);
        }
    }
    // The texture's centre: in perspective where the diagonals cross; bilinearly at the mean of the corners; linearly on the
    // middle of the diagonal that was cut.
    let cross = {
        let [a, b, c, d] = [corners[0], corners[1], corners[2], corners[3]];
        let (p, q) = (c - a, d - b);
        a + p * ((b - a).perp(&q) / p.perp(&q))
    };
    let centre = Point2::new(32.0, 32.0);
    assert!((exact.at(&cross).unwrap() - centre).norm() < 1e-9);
    let mean = Point2::from(
        corners.iter().map(|c| c.coords).sum::<collinear::nalgebra::Vector2<f64>>() / 4.0,
    );
    assert!((bilinear.at(&mean).unwrap() - centre).norm() < 1e-9);
    let middle = collinear::nalgebra::center(&corners[0], &corners[2]);
    let other = collinear::nalgebra::center(&corners[1], &corners[3]);
    let on_cut = linear
        .iter()
        .any(|(_, m)| [middle, other].iter().any(|p| (m.at(p).unwrap() - centre).norm() < 1e-9));
    assert!(on_cut && (exact.at(&middle).unwrap() - centre).norm() > 4.0);
}

#[test]
fn sides_are_told_by_their_turn_on_the_screen() {
    let outline = [[2.0, 2.0], [2.0, 9.0], [9.0, 9.0]];
    // Down, then right, in a picture whose y runs down: counter-clockwise as seen.
    let polygon = flat_polygon(&outline);
    assert!(
        polygon.shows(Facing::Front) && !polygon.shows(Facing::Back) && polygon.shows(Facing::Both)
    );
    let reversed = flat_polygon(&[outline[2], outline[1], outline[0]]);
    assert!(!reversed.shows(Facing::Front) && reversed.shows(Facing::Back));
    // A plane's front is the side from which its points turn counter-clockwise.
    let world = outline.map(|p| at(p[0], p[1]));
    let plane = Plane::through(&world[0], &world[1], &world[2]).unwrap();
    assert!(plane.signed_distance(&Point3::new(0.0, 0.0, 10.0)) > 0.0);
}

#[test]
fn hostile_polygons_and_canvases() {
    let screen = eye();
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    assert!(matches!(
        ScreenPolygon::project(&[p(0.0, 1.0, 0.0); 2], &screen, 0.1),
        Err(Error::TooFewPoints { needed: 3, got: 2 })
    ));
    assert!(matches!(
        ScreenPolygon::project(&[p(f64::NAN, 1.0, 0.0); 3], &screen, 0.1),
        Err(Error::NotFinite { .. })
    ));
    assert!(matches!(
        ScreenPolygon::project(&[p(0.0, 1.0, 0.0); 3], &screen, -1.0),
        Err(Error::OutOfRange { .. })
    ));
    // Wholly behind the eye.
    let behind = ScreenPolygon::project(
        &[p(-1.0, -5.0, 0.0), p(1.0, -5.0, 0.0), p(0.0, -5.0, 3.0)],
        &screen,
        0.1,
    );
    assert!(behind.unwrap().is_empty());
    // Reaching from far behind the eye to the horizon, in a picture 70,000 pixels wide.
    let floor = [p(-1e9, -1e9, 0.0), p(1e9, -1e9, 0.0), p(1e9, 1e9, 0.0), p(-1e9, 1e9, 0.0)];
    let polygon = ScreenPolygon::project(&floor, &screen, 0.1).unwrap();
    let (mut pixels, mut rows) = (0u64, 0);
    // The horizon lies at row 80 + 150 · 0.05 = 87.5; below it every pixel shows the floor.
    polygon.spans(70_000, 100, |span| {
        if span.y >= 88 {
            pixels += (span.x.end - span.x.start) as u64;
            rows += 1;
        }
    });
    assert_eq!((pixels, rows), (70_000 * 12, 12));
    // No pixels at all.
    let mut none: [u8; 0] = [];
    let mut canvas = Canvas::new(ImageViewMut::<u8, 3>::new(&mut none, 0, 0).unwrap());
    canvas.draw(&polygon, [0.0, 0.0, 0.0], &Paint::Flat([1, 2, 3])).unwrap();
    assert_eq!(canvas.nearness(0, 0), None);
    assert!(canvas.draw(&polygon, [f64::NAN, 0.0, 0.0], &Paint::Flat([1, 2, 3])).is_err());
    // An empty texture paints nothing, nor does a map with no value.
    let mut pixels = [7u8; 16];
    let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 4, 4).unwrap());
    let empty = ImageView::<u8, 1>::new(&[], 0, 0).unwrap();
    let map = Affine2::identity();
    let paint = Paint::Texture {
        image: empty,
        map: &map,
        filter: Filter::Bilinear,
        border: Border::Repeat,
    };
    let square = flat_polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
    canvas.draw(&square, [1.0, 0.0, 0.0], &paint).unwrap();
    assert_eq!(canvas.nearness(1, 1), None);
    drop(canvas);
    assert_eq!(pixels, [7; 16]);
    // A lens or a horizon that leaves a vertex without coordinates is said.
    let exact =
        FractionalLinear::from_coefficients([0.0; 3], [0.0; 3], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0])
            .unwrap();
    assert!(matches!(
        linear_triangles(&square, &exact),
        Err(Error::Projection(ProjectionError::BehindCamera { .. }))
    ));
}
