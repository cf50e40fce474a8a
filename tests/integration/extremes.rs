//! Numbers at the ends of their range: an answer, an error or nothing, but never a panic, a hang or a plausible number.

use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralModel, Distortion, ExteriorOrientation, Frame,
    InteriorOrientation,
};
use collinear::error::{Error, ProjectionError};
use collinear::geometry::homography::decompose::decompose;
use collinear::geometry::{Affine2, Homography, Plane};
use collinear::mapping::span::{ConstantDepthLines, Span};
use collinear::mapping::{FractionalLinear, Map, RowCoords};
use collinear::nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector3};
use collinear::resample::ImageViewMut;
use collinear::texturer::{Canvas, Paint, ScreenPolygon};

fn interior() -> InteriorOrientation {
    InteriorOrientation::new([1000.0; 2], Point2::new(500.0, 400.0), 0.0).unwrap()
}

fn at_origin() -> ExteriorOrientation {
    ExteriorOrientation::new(Point3::origin(), Rotation3::identity())
}

#[test]
fn a_step_of_any_size_leaves_a_rotation() {
    for size in [1e-300, 1.0, 1e16, 1e155, 1e300] {
        let mut frame = Frame::new(at_origin(), interior());
        frame.adjust(0, &[0.0, 0.0, 0.0, size, -size, size]).unwrap();
        let r = *frame.exterior.camera_from_world().matrix();
        assert!((r * r.transpose() - Matrix3::identity()).amax() < 1e-14);
    }
    let mut frame = Frame::new(at_origin(), interior());
    let too_far = frame.adjust(0, &[f64::MAX, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(too_far.is_ok());
    let beyond = frame.adjust(0, &[f64::MAX, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(matches!(beyond, Err(Error::NotFinite { .. })), "{beyond:?}");
}

#[test]
fn a_group_past_the_last_is_refused_and_nothing_moves() {
    let lens = Brown::new([-0.1, 0.0, 0.0], [0.0; 2]).unwrap();
    let mut camera = BrownCamera::new(interior(), lens);
    let mut pinhole = interior();
    for group in [2, 7, usize::MAX] {
        let refused = camera.adjust(group, &[0.1, 0.0, 0.0, 0.0, 0.0]);
        assert!(matches!(refused, Err(Error::OutOfRange { .. })), "{refused:?}");
        let refused = pinhole.adjust(group, &[0.1, 0.0, 0.0, 0.0, 0.0]);
        assert!(matches!(refused, Err(Error::OutOfRange { .. })), "{refused:?}");
        let mut values = [7.0; 5];
        camera.parameters(group, &mut values);
        pinhole.parameters(group, &mut values);
        assert_eq!(values, [7.0; 5]);
    }
    assert_eq!((camera, pinhole), (BrownCamera::new(interior(), lens), interior()));
}

/// 1 + 3 k r² = 0 for a single k₁: r = √(1/(3·10⁻⁹)) = 18257.418583505537; there r (1 + k r²) = ⅔ r.
#[test]
fn a_fold_far_from_the_axis_is_found() {
    let lens = Brown::new([-1e-9, 0.0, 0.0], [0.0; 2]).unwrap();
    assert!((lens.fold_radius() - 18_257.418_583_505_537).abs() < 1e-9);
    for x in [18_258.0, 30_000.0, 40_000.0] {
        let beyond = lens.distort(&Point2::new(x, 0.0));
        assert!(matches!(beyond, Err(ProjectionError::OutsideDomain { .. })), "{beyond:?}");
    }
    let near = lens.undistort(&Point2::new(12_000.0, 0.0)).unwrap();
    assert!(near.point.x < lens.fold_radius() && near.point.y == 0.0);
    let unseen = lens.undistort(&Point2::new(12_172.0, 0.0));
    assert!(matches!(unseen, Err(ProjectionError::OutsideDomain { .. })), "{unseen:?}");
    // 1 + 7 k₃ r⁶ = 0 at 10²⁰: past every radius that is searched, cut off and not forgotten.
    let faint = Brown::new([0.0, 0.0, -1e-120 / 7.0], [0.0; 2]).unwrap();
    assert_eq!(faint.fold_radius(), 1e16);
}

/// With k₁ = 0.1 the cubic 0.1 r³ + r = R has the root (10 R)^⅓ (1 + o(1)): for R = √2 · 10¹⁰⁰ each coordinate is
/// (10 √2 · 10¹⁰⁰)^⅓ / √2 = 3.684031498640387 · 10³³ (mpmath 1.3.0).
#[test]
fn the_lens_is_inverted_at_any_distance_or_says_that_it_is_not() {
    let widening = Brown::new([0.1, 0.0, 0.0], [0.0; 2]).unwrap();
    let found = widening.undistort(&Point2::new(1e100, 1e100)).unwrap().point;
    assert!((found.x / 3.684_031_498_640_387e33 - 1.0).abs() < 1e-14 && found.x == found.y);
    let folding = Brown::new([-0.1, 0.0, 0.0], [0.0; 2]).unwrap();
    for x in [3.0, 1e50, 1e153, 1e155, 1e300] {
        let outside = folding.undistort(&Point2::new(x, x));
        assert!(matches!(outside, Err(ProjectionError::OutsideDomain { .. })), "{x}: {outside:?}");
    }
    for lens in [Brown::none(), widening, folding] {
        for x in [1e155, 1e300, f64::MAX] {
            if let Ok(found) = lens.undistort(&Point2::new(x, -x)) {
                assert!(found.residual <= 1e-14 * x, "{lens:?} {x} {found:?}");
            }
        }
    }
}

#[test]
fn a_pixel_of_any_size_has_a_direction() {
    let half = 0.5f64.sqrt();
    for (pixel, expected) in [
        ((1e155, 0.0), Vector3::x()),
        ((-1e300, 1e300), Vector3::new(-half, half, 0.0)),
        ((0.0, 1e308), Vector3::y()),
    ] {
        let d = interior().direction(&Point2::new(pixel.0, pixel.1)).unwrap();
        assert!((d - expected).norm() < 1e-15, "{d:?}");
    }
}

#[test]
fn a_row_ends_where_the_numbers_of_its_pixels_end() {
    let mut row = RowCoords::new();
    row.push(i32::MAX - 1, 1.0, 1.0);
    row.push(i32::MAX, 2.0, 1.0);
    assert_eq!(row.runs().len(), 1);
    assert_eq!(row.runs()[0].pixels(), i32::MAX - 1..i32::MAX);
    row.clear();
    row.push_block(i32::MAX - 2, &[0.0, 500.0, 1000.0, 1500.0], &[0.0; 4]);
    let pixels: Vec<_> = row.runs().iter().map(|r| r.pixels().start).collect();
    assert_eq!(pixels, [i32::MAX - 2, i32::MAX - 1]);
    row.clear();
    row.push_block(i32::MAX - 2, &[1.0; 4], &[1.0; 4]);
    assert_eq!(row.runs()[0].pixels(), i32::MAX - 2..i32::MAX);

    let span = Span::<1>::new([[1.0, 1.0]], [1.0, 0.0]).unwrap();
    assert_eq!(span.walk_bound(i32::MAX - 10..i32::MAX), [0.0]);
    assert_eq!(span.walk_bound(i32::MIN..i32::MIN + 10), [0.0]);
    span.walk(i32::MAX - 10..i32::MAX, |_, _| panic!("nothing is valid there"));

    let lines = ConstantDepthLines::<1>::new([[0.0, 1.0, 0.0]], [1.0, 1e-3, 2e-3]).unwrap();
    for (x, y) in [(i32::MIN, i32::MAX), (i32::MAX, i32::MIN), (i32::MIN, i32::MIN)] {
        let _ = lines.line_of(x, y);
    }
}

/// u = S, v = 1 + 10⁻²⁵⁰ S: a coefficient smaller than a span takes.
#[test]
fn a_row_shows_what_its_pixels_show_with_coefficients_of_any_size() {
    for (q, r) in [([1.0, 1e-250, 0.0], [1.0, 0.0, 0.0]), ([1.0, 0.0, 0.0], [1.0, 1e-250, 0.0])] {
        let map =
            FractionalLinear::from_coefficients([0.0, 1.0, 0.0], q, r, [1.0, 0.0, 0.0]).unwrap();
        assert_eq!(map.at(&Point2::new(0.5, 0.5)).unwrap(), Point2::new(0.5, 1.0));
        assert_eq!(map.valid_samples(0, 0..10), 0..10);
        let mut row = RowCoords::new();
        map.row(0, 0..10, &mut row);
        assert_eq!(row.runs().iter().map(|r| r.len()).sum::<usize>(), 10);
    }
}

#[test]
fn a_square_of_any_size_around_the_axis_covers_the_picture() {
    let camera = Frame::new(at_origin(), interior()).homogeneous();
    let square = |s: f64| {
        let corners = [(-s, -s), (s, -s), (s, s), (-s, s)];
        ScreenPolygon::project(&corners.map(|(x, y)| Point3::new(x, y, 5.0)), &camera, 0.1)
    };
    for s in [1e1, 1e9, 1e16, 1e60, 1e100, 1e146] {
        let mut pixels = 0;
        square(s).unwrap().spans(1000, 800, |span| pixels += span.x.len());
        assert_eq!(pixels, 800_000, "{s}");
    }
    assert!(matches!(square(1e148), Err(Error::OutOfRange { .. })));
    // A floor that reaches 10¹⁰⁰ beyond the horizon's line, seen from 1 above it: the lower half.
    for far in [1e3, 1e18, 1e100] {
        let floor = [(-far, -1.0), (far, -1.0), (far, far), (-far, far)];
        let floor = floor.map(|(x, z)| Point3::new(x, 1.0, z));
        let mut pixels = 0;
        let polygon = ScreenPolygon::project(&floor, &camera, 1e-3).unwrap();
        polygon.spans(1000, 800, |span| pixels += span.x.len());
        // y = 1000/z + 400 leaves the row of centres 400.5 at z = 2000.
        let horizon = if far > 2000.0 { 400_000 } else { 399_000 };
        assert_eq!(pixels, horizon, "{far}");
    }
}

#[test]
fn pictures_wider_than_the_numbers_of_pixels_are_scanned() {
    let camera = Frame::new(at_origin(), interior()).homogeneous();
    let corners = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)];
    let corners = corners.map(|(x, y)| Point3::new(x, y, 5.0));
    let polygon = ScreenPolygon::project(&corners, &camera, 0.1).unwrap();
    let count = |width, height| {
        let mut pixels = 0;
        polygon.spans(width, height, |span| pixels += span.x.len());
        pixels
    };
    let all = count(10_000, 10_000);
    assert!(all > 70_000);
    for side in [1 << 31, (1 << 32) + 2, usize::MAX] {
        assert_eq!(count(side, side), all);
    }

    let mut pixels = [0_u8; 4];
    let mut canvas = Canvas::new(ImageViewMut::<u8, 1>::new(&mut pixels, 2, 2).unwrap());
    let all_over = corners.map(|p| Point3::from(p.coords * 100.0));
    let all_over = ScreenPolygon::project(&all_over, &camera, 0.1).unwrap();
    canvas.draw(&all_over, [1.0, 0.0, 0.0], &Paint::Flat([9])).unwrap();
    for (x, y) in [(0, 2), (0, 1 << 63), (2, 0), (usize::MAX, usize::MAX)] {
        assert_eq!(canvas.nearness(x, y), None);
    }
}

#[test]
fn an_affine_map_without_a_finite_inverse_has_none() {
    for (a, b) in [
        ([f64::NAN, 1.0, 0.0], [0.0, 0.0, 1.0]),
        ([1e300, 1e-10, 0.0], [0.0, 0.0, 1.0]),
        ([0.0, 1e308, 0.0], [0.0, 0.0, 1e308]),
    ] {
        let inverse = Affine2::from_coefficients(a, b).inverse();
        assert!(matches!(inverse, Err(Error::NotFinite { .. })), "{inverse:?}");
    }
}

/// R + t nᵀ with |t| up to ten million distances of the plane: digits of R are lost, its being a rotation is not.
#[test]
fn motions_are_rotations_however_far() {
    let turn = Rotation3::from_euler_angles(0.1, -0.2, 0.3);
    let normal = Vector3::new(0.1, -0.2, 1.0).normalize();
    let k = Matrix3::identity();
    for far in [1.0, 1e4, 1e7] {
        let t = Vector3::new(0.6, 0.5, -0.3) * far;
        let h = Homography::from_matrix(turn.matrix() + t * normal.transpose()).unwrap();
        for motion in decompose(&h, &k, &k).unwrap() {
            let r = motion.rotation.matrix();
            assert!((r * r.transpose() - k).amax() < 1e-14);
        }
    }
}

/// A triangle of ten metres in map coordinates: the centroid's map is the plane's within 10⁻⁸ px.
#[test]
fn the_centroid_keeps_its_digits_in_map_coordinates() {
    let ground = Point3::new(389_397.0, 5_819_660.0, 51.0);
    let corners = [(0.0, 0.0, 0.0), (10.0, 1.0, 0.3), (2.0, 9.0, -0.4)];
    let corners = corners.map(|(x, y, z)| ground + Vector3::new(x, y, z));
    let camera = |x: f64, y: f64| {
        let eye = ground + Vector3::new(x, y, 40.0);
        let exterior = ExteriorOrientation::look_at(eye, ground, Vector3::y()).unwrap();
        Frame::new(exterior, interior()).homogeneous()
    };
    let (texture, screen) = (camera(3.0, -7.0), camera(-5.0, 2.0));
    let plane = Plane::through(&corners[0], &corners[1], &corners[2]).unwrap();
    let closed = FractionalLinear::from_plane(&plane, &texture, &screen).unwrap();
    let centroid =
        FractionalLinear::from_triangle_and_centroid(&corners, &texture, &screen).unwrap();
    for (x, y) in [(500.5, 400.5), (700.5, 300.5), (450.5, 250.5)] {
        let p = Point2::new(x, y);
        let off = (closed.at(&p).unwrap() - centroid.at(&p).unwrap()).norm();
        assert!(off < 1e-8, "{off}");
    }
}
