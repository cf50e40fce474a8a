//! Lookup tables and approximated maps.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::ops::Range;

use collinear::camera::{Brown, BrownCamera, InteriorOrientation};
use collinear::geometry::Affine2;
use collinear::mapping::piecewise::PiecewiseAffine;
use collinear::mapping::polynomial::Bilinear;
use collinear::mapping::{
    Approximated, DistortMap, FractionalLinear, LookupTable, Map, TextureOrigin, UndistortMap,
};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut, warp};
use collinear::{Error, ProjectionError};
use nalgebra::{Matrix2, Point2, Vector2};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::numbers;

fn oracles() -> Value {
    serde_json::from_str(include_str!("../data/oracles/lookup_table.json")).unwrap()
}

fn floats(v: &Value) -> Vec<f32> {
    numbers(v).into_iter().map(|c| c as f32).collect()
}

fn camera(oracles: &Value) -> BrownCamera {
    let (c, l) = (numbers(&oracles["camera"]), numbers(&oracles["lens"]));
    let interior = InteriorOrientation::from_opencv(c[0], c[0], c[1], c[2]).unwrap();
    BrownCamera::new(interior, Brown::new([l[0], l[1], l[4]], [l[2], l[3]]).unwrap())
}

/// The coordinates of a row's pixels, `None` where they show nothing.
fn row(map: &dyn Map, line: i32, samples: Range<i32>) -> Vec<Option<[f64; 2]>> {
    let mut found = vec![None; samples.len()];
    let mut next = samples.start;
    map.blocks(line, samples.clone(), &mut |x, u, v| {
        assert!(x >= next && u.len() == v.len() && (1..=64).contains(&u.len()));
        next = x + u.len() as i32;
        for (i, (u, v)) in u.iter().zip(v).enumerate() {
            found[(x - samples.start) as usize + i] = Some([*u, *v]);
        }
    });
    found
}

#[test]
fn a_lookup_table_of_a_lens_is_opencvs() {
    let oracles = oracles();
    let map = DistortMap::new(camera(&oracles));
    let table = LookupTable::from_map(&map, 160, 120).unwrap();
    assert_eq!(table.size(), [160, 120]);
    let (x, y) = table.opencv_maps();
    let mut equal = 0;
    let cases = oracles["maps"].as_array().unwrap();
    for case in cases {
        let c = numbers(case);
        let i = c[1] as usize * 160 + c[0] as usize;
        // One unit in the last place of 160.
        let far = (f64::from(x[i]) - c[2]).abs().max((f64::from(y[i]) - c[3]).abs());
        assert!(far <= 2.0f64.powi(-16), "{case} {} {}", x[i], y[i]);
        equal += usize::from(far == 0.0);
    }
    assert!(equal * 10 > cases.len() * 9, "{equal} of {}", cases.len());
}

#[test]
fn a_picture_through_opencvs_maps_is_opencvs() {
    let case = &oracles()["remap"];
    let (x, y, image) = (floats(&case["x"]), floats(&case["y"]), floats(&case["image"]));
    let table = LookupTable::from_opencv(11, 9, &x, &y).unwrap();
    let source = ImageView::<f32, 1>::new(&image, 16, 12).unwrap();
    let mut out = vec![0.0f32; 99];
    let mut target = ImageViewMut::<f32, 1>::new(&mut out, 11, 9).unwrap();
    warp(source, &table, Filter::Bilinear, Border::Clamp, &mut target);
    for (ours, theirs) in out.iter().zip(floats(&case["out"])) {
        assert!((ours - theirs).abs() < 1e-3, "{ours} {theirs}");
    }
    assert_eq!(table.opencv_maps(), (&x[..], &y[..]));
}

#[test]
fn an_approximated_undistortion_keeps_its_tolerance_to_thirty_digits() {
    let oracles = oracles();
    let map = UndistortMap::new(camera(&oracles));
    for tolerance in [0.05, 1e-3, 1e-6, 1e-9] {
        let quick = Approximated::new(map, 0..160, 0..120, tolerance).unwrap();
        let mut worst = 0.0f64;
        for case in oracles["undistort"].as_array().unwrap() {
            let c = numbers(case);
            let x = c[0] as i32;
            let [u, v] = row(&quick, c[1] as i32, x..x + 1)[0].unwrap();
            worst = worst.max(f64::hypot(u - 0.5 - c[2], v - 0.5 - c[3]));
        }
        assert!(worst <= tolerance + 1e-11, "{tolerance} {worst}");
        let report = *quick.report();
        assert!(report.largest <= tolerance);
        assert_eq!(report.approximated_pixels + report.exact_pixels, 160 * 120);
        if tolerance >= 1e-3 {
            assert_eq!(report.exact_pixels, 0, "{report:?}");
        }
    }
}

/// Waves, a hole in the shape of a disc, and columns of NaN and of infinities.
#[derive(Clone, Copy, Debug)]
struct Waves {
    amplitude: f64,
    length: f64,
    hole: [f64; 3],
}

impl Map for Waves {
    fn at(&self, p: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let [x, y, radius] = self.hole;
        let far = f64::hypot(p.x - x, p.y - y);
        if far < radius {
            return Err(ProjectionError::OutsideDomain { value: radius - far, limit: 0.0 });
        }
        let bad = match p.x {
            150.5 => f64::NAN,
            190.5 => f64::INFINITY,
            _ => 0.0,
        };
        let wave = self.amplitude * (p.x / self.length).sin() * (p.y / self.length).cos();
        Ok(Point2::new(p.x + wave + bad, 0.5 * p.y - wave))
    }

    fn jacobian(&self, _: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Err(ProjectionError::NotFinite)
    }
}

/// Every pixel within the tolerance of the map's, the same pixels without value, however the row is cut.
fn keeps(map: &dyn Map, x: Range<i32>, y: Range<i32>, tolerance: f64, cut: i32) {
    let quick = Approximated::new(map, x, y, tolerance).unwrap();
    let mut worst = 0.0f64;
    for line in -3..100 {
        let (exact, found) = (row(map, line, -20..260), row(&quick, line, -20..260));
        for (e, f) in exact.iter().zip(&found) {
            match (e, f) {
                (Some(e), Some(f)) if e.iter().all(|c| c.is_finite()) => {
                    worst = worst.max(f64::hypot(e[0] - f[0], e[1] - f[1]));
                }
                (Some(e), Some(f)) => assert_eq!(e.map(f64::to_bits), f.map(f64::to_bits)),
                (None, None) => {}
                (e, f) => panic!("{e:?} {f:?}"),
            }
        }
        let mut parts = row(&quick, line, -20..cut);
        parts.extend(row(&quick, line, cut..260));
        let bits = |all: &[Option<[f64; 2]>]| -> Vec<_> {
            all.iter().map(|p| p.map(|c| c.map(f64::to_bits))).collect()
        };
        assert_eq!(bits(&found), bits(&parts));
    }
    // The square root of a sum may round otherwise than `hypot`.
    let rounded = 1.0 - 1e-15;
    assert!(worst * rounded <= tolerance, "{worst} {tolerance}");
    assert!(worst * rounded <= quick.report().largest, "{worst} {:?}", quick.report());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn an_approximation_keeps_its_tolerance_at_every_pixel_and_its_holes(
        amplitude in 0.0..40.0, length in 2.0..200.0, hole in (0.0..240.0, 0.0..90.0, 0.0..30.0),
        x in (-10..30i32, 1..230i32), y in (-3..9i32, 1..90i32), exponent in -9.0..1.0f64, cut in -20..260i32,
    ) {
        let map = Waves { amplitude, length, hole: [hole.0, hole.1, hole.2] };
        keeps(&map, x.0..x.0 + x.1, y.0..y.0 + y.1, 10.0f64.powf(exponent), cut);
    }

    #[test]
    fn an_approximation_keeps_its_tolerance_beside_horizons_and_kinks(
        r in -0.02..0.02, corner in (-40.0..40.0, -40.0..40.0), exponent in -6.0..0.0f64, cut in -20..260i32,
    ) {
        let tolerance = 10.0f64.powf(exponent);
        let horizon = FractionalLinear::from_coefficients(
            [1.0, 2.0, 0.0], [4.0, 0.0, 3.0], [1.0, r, 0.005], [1.0, 0.0, 0.0],
        ).unwrap();
        keeps(&horizon, 0..240, 0..97, tolerance, cut);
        let screen = [(0., 0.), (230., 5.), (120., 50.), (10., 92.), (240., 80.)].map(|(x, y)| Point2::new(x, y));
        let mut texture = screen;
        texture[2] += Vector2::new(corner.0, corner.1);
        keeps(&PiecewiseAffine::new(&screen, &texture).unwrap(), 0..240, 0..97, tolerance, cut);
    }

    #[test]
    fn tables_keep_what_they_are_given(width in 1..70u32, height in 1..6u32, seed in 0..1000u32, holes in 0.0..0.4) {
        let mut next = crate::support::uniform(u64::from(seed));
        let mut value = || { let (a, b) = (next(), next()); if a < holes { f32::NAN } else { (b * 3000.0) as f32 } };
        let n = (width * height) as usize;
        let (x, y): (Vec<f32>, Vec<f32>) = (0..n).map(|_| (value(), value())).unzip();
        let table = LookupTable::from_opencv(width, height, &x, &y).unwrap();
        for line in 0..height as i32 {
            for (i, p) in row(&table, line, -3..width as i32 + 3).into_iter().enumerate() {
                let centre = Point2::new(i as f64 - 2.5, f64::from(line) + 0.5);
                prop_assert_eq!(p, table.at(&centre).ok().map(|p| [p.x, p.y]));
                let column = i as i32 - 3;
                let inside = (0..width as i32).contains(&column);
                let k = (line * width as i32 + column.clamp(0, width as i32 - 1)) as usize;
                let shown = inside && !x[k].is_nan() && !y[k].is_nan();
                prop_assert_eq!(p, shown.then(|| [f64::from(x[k]) + 0.5, f64::from(y[k]) + 0.5]));
            }
        }
        for origin in [TextureOrigin::TopLeft, TextureOrigin::BottomLeft] {
            let shares = table.texture_coordinates([4096, 2048], origin).unwrap();
            let back = LookupTable::from_texture_coordinates(width, height, &shares, [4096, 2048], origin).unwrap();
            let pairs = table.opencv_maps().0.iter().zip(back.opencv_maps().0);
            for (a, b) in pairs.chain(table.opencv_maps().1.iter().zip(back.opencv_maps().1)) {
                // Half a unit of [½, 1) times 4096, and half a unit of [2048, 4096).
                prop_assert!(a.is_nan() && b.is_nan() || (a - b).abs() <= 2.0f32.powi(-12), "{a} {b}");
            }
        }
    }
}

#[test]
fn the_loss_of_single_precision_is_what_is_said() {
    let mut next = crate::support::uniform(5);
    let mut worst = [0.0f64; 2];
    for _ in 0..20_000 {
        let u = 32_768.0 + 32_767.0 * next();
        let map = Affine2::from_coefficients([u, 0.0, 0.0], [u, 0.0, 0.0]);
        let table = LookupTable::from_map(&map, 1, 1).unwrap();
        let found = table.at(&Point2::new(0.5, 0.5)).unwrap();
        worst[0] = worst[0].max((found.x - u).abs());
        let share =
            table.texture_coordinates([65_535, 65_535], TextureOrigin::TopLeft).unwrap()[0][0];
        worst[1] = worst[1].max((f64::from(share) * 65_535.0 - u).abs());
    }
    let half = 1.0 / 512.0;
    assert!(worst[0] <= half && worst[0] > 0.99 * half, "{worst:?}");
    assert!(worst[1] <= 2.0 * half && worst[1] > 1.2 * half, "{worst:?}");
}

#[test]
fn texture_coordinates_begin_in_the_corner_that_is_named() {
    // One pixel that shows the upper left texel of 8 × 4, by its centre: (½, ½) of (8, 4).
    let table = LookupTable::from_opencv(1, 1, &[0.0], &[0.0]).unwrap();
    assert_eq!(
        table.texture_coordinates([8, 4], TextureOrigin::TopLeft).unwrap(),
        [[0.0625, 0.125]]
    );
    assert_eq!(
        table.texture_coordinates([8, 4], TextureOrigin::BottomLeft).unwrap(),
        [[0.0625, 0.875]]
    );
}

#[test]
fn bad_tables_and_approximations_are_refused() {
    let none: [f32; 0] = [];
    let table = LookupTable::from_opencv(0, 0, &none, &none).unwrap();
    assert!(row(&table, 0, 0..4).iter().all(Option::is_none));
    assert!(table.at(&Point2::new(0.5, 0.5)).is_err());
    assert!(matches!(
        LookupTable::from_opencv(2, 1, &[0.0; 2], &[0.0; 3]),
        Err(Error::LengthMismatch { left: 2, right: 3, .. })
    ));
    assert!(matches!(
        LookupTable::from_opencv(u32::MAX, u32::MAX, &none, &none),
        Err(Error::LengthMismatch { .. })
    ));
    assert!(matches!(
        LookupTable::from_map(&Affine2::identity(), u32::MAX, u32::MAX),
        Err(Error::OutOfRange { .. })
    ));
    let one = LookupTable::from_opencv(1, 1, &[1.0], &[f32::INFINITY]).unwrap();
    assert!(one.opencv_maps().0[0].is_nan());
    assert!(matches!(
        one.texture_coordinates([0, 4], TextureOrigin::TopLeft),
        Err(Error::OutOfRange { .. })
    ));
    let two = LookupTable::from_opencv(2, 2, &[0.0, 2.0, 1.0, 5.0], &[0.0, 1.0, 3.0, 4.0]).unwrap();
    let p = Point2::new(1.25, 0.75);
    // Weights ¼ and ¾ along x, ¾ and ¼ along y: (2.125, 1.5) of OpenCV.
    assert_eq!(two.at(&p), Ok(Point2::new(2.625, 2.0)));
    for k in 0..2 {
        let mut step = Vector2::zeros();
        step[k] = 0.125;
        let slope = (two.at(&(p + step)).unwrap() - two.at(&(p - step)).unwrap()) / 0.25;
        assert_eq!(slope, two.jacobian(&p).unwrap().column(k));
    }
    assert_eq!(two.at(&Point2::new(f64::NAN, 1.0)), Err(ProjectionError::NotFinite));
    assert!(matches!(
        two.at(&Point2::new(1.0, 2.0)),
        Err(ProjectionError::OutsideDomain { value: 0.5, .. })
    ));

    let map = Affine2::identity();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let made = Approximated::new(map, 0..4, 0..4, tolerance);
        assert!(matches!(made, Err(Error::OutOfRange { .. })));
    }
    #[allow(clippy::reversed_empty_ranges, reason = "it is what is refused")]
    for (x, y) in [(0..0, 0..4), (0..4, 5..3), (i32::MIN..i32::MAX, 0..1)] {
        assert!(matches!(Approximated::new(map, x, y, 0.1), Err(Error::OutOfRange { .. })));
    }
    // A map without spans, which end at 2²⁵.
    let map = Bilinear::from_coefficients([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]).unwrap();
    let last =
        Approximated::new(map, i32::MAX - 70..i32::MAX, i32::MIN..i32::MIN + 3, 0.1).unwrap();
    assert_eq!(row(&last, i32::MIN, i32::MAX - 80..i32::MAX).iter().flatten().count(), 80);
    assert_eq!(last.at(&Point2::new(1.0, 2.0)), Ok(Point2::new(1.0, 2.0)));
    assert_eq!(last.jacobian(&Point2::new(1.0, 2.0)), Ok(Matrix2::identity()));
    assert_eq!(*last.exact(), map);
}
