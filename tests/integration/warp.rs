//! Whole pictures through maps: pixel by pixel the same as lookups one by one, whatever the samples, borders, filters and maps.

use std::ops::Range;

use collinear::ProjectionError;
use collinear::geometry::Affine2;
use collinear::mapping::span::Span;
use collinear::mapping::{BlockSink, FractionalLinear, Map};
use collinear::nalgebra::{Matrix2, Point2};
use collinear::resample::{Border, Cubic, Filter, ImageView, ImageViewMut, Sample, sample, warp};
use proptest::prelude::*;

use crate::support::{BORDERS, noise, same_as_lookups};

const FILTERS: [Filter; 7] = [
    Filter::Nearest,
    Filter::Bilinear,
    Filter::Bicubic(Cubic::keys(-0.75)),
    Filter::Bicubic(Cubic::MITCHELL),
    Filter::Lanczos2,
    Filter::Lanczos3,
    Filter::Lanczos4,
];

/// A map that is no span: waves, with holes and with coordinates that are no numbers.
#[derive(Debug)]
struct Waves(Affine2);

impl Map for Waves {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        let p = self.0.at(screen)?;
        let pixel = screen.x.floor() as i64 + 7 * screen.y.floor() as i64;
        match pixel.rem_euclid(41) {
            0 => Err(ProjectionError::NotFinite),
            1 => Ok(Point2::new(f64::NAN, p.y)),
            2 => Ok(Point2::new(p.x, f64::INFINITY)),
            3 => Ok(Point2::new(-1e12, p.y)),
            _ => Ok(Point2::new(p.x + 2.0 * p.y.sin(), p.y + 2.0 * (0.3 * p.x).sin())),
        }
    }

    fn jacobian(&self, _: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Err(ProjectionError::NotFinite)
    }
}

/// What a test draws at random.
#[derive(Clone, Debug)]
struct Case {
    size: [usize; 2],
    padding: usize,
    spare: usize,
    target: [usize; 2],
    seed: u32,
    coefficients: [f64; 8],
    border: usize,
}

fn cases() -> impl Strategy<Value = Case> {
    let unit = -1.0..1.0f64;
    let sizes = ([1..90usize, 1..40usize], 0..5usize, 0..9usize, [1..900usize, 1..3usize]);
    (sizes, any::<u32>(), proptest::array::uniform8(unit), 0..5usize).prop_map(
        |((size, padding, spare, target), seed, coefficients, border)| Case {
            size,
            padding,
            spare,
            target,
            seed,
            coefficients,
            border,
        },
    )
}

/// Maps onto the picture and around it: affine, with a horizon, and no span at all.
fn maps(case: &Case) -> [Box<dyn Map>; 3] {
    let [a, b, c, d, e, f, g, h] = case.coefficients;
    let [w, height] = case.size.map(|n| n as f64);
    let [tw, th] = case.target.map(|n| n as f64);
    // From well over the picture's width across the target to nearly nothing.
    let affine = Affine2::from_coefficients(
        [w * (0.5 + 0.6 * a), w / tw * 1.5 * b, 3.0 * c],
        [height * (0.5 + 0.6 * d), height / tw * e, height / th * f],
    );
    let horizon = FractionalLinear::from_coefficients(
        [w * (0.5 + 0.3 * a), w / tw * b, c],
        [height * (0.5 + 0.3 * d), height / tw * e, f],
        [1.0, 1.5 * g / tw, 0.2 * h],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    [Box::new(affine), Box::new(horizon), Box::new(Waves(affine))]
}

fn agree<T: Sample, const C: usize>(case: &Case, of: impl Fn(u32) -> T) {
    let [width, height] = case.size;
    let stride = width * C + case.padding;
    let mut next = noise(case.seed, of);
    let samples: Vec<T> =
        (0..stride * (height - 1) + width * C + case.spare).map(|_| next()).collect();
    let view = ImageView::<T, C>::with_stride(&samples, width, height, stride).unwrap();
    let border = BORDERS[case.border];
    let [tw, th] = case.target;
    for (number, map) in maps(case).iter().enumerate() {
        for filter in FILTERS {
            let before: Vec<T> = (0..tw * th * C).map(|_| next()).collect();
            same_as_lookups::<T, C>(
                &format!("map {number}, {filter:?}"),
                case.target,
                before,
                border,
                |target| warp(view, map.as_ref(), filter, border, target),
                |y, found| {
                    map.blocks(y, 0..tw as i32, &mut |x, u, v| {
                        for ((found, u), v) in found[x as usize..].iter_mut().zip(u).zip(v) {
                            *found = sample(view, &Point2::new(*u, *v), filter, border);
                        }
                    });
                },
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// The lookups one by one are compiled without vectors, the warp with them where the feature `simd` is on: so this also
    /// compares the processor's widest vectors with plain code.
    #[test]
    fn a_warp_is_its_lookups_one_by_one(case in cases()) {
        let byte = |n: u32| (n >> 9) as u8;
        let word = |n: u32| (n >> 9) as u16;
        let float = |n: u32| (n >> 9) as f32 / 16384.0 - 200.0;
        agree::<u8, 1>(&case, byte);
        agree::<u8, 3>(&case, byte);
        agree::<u8, 4>(&case, byte);
        agree::<u16, 2>(&case, word);
        agree::<u16, 3>(&case, word);
        agree::<f32, 1>(&case, float);
        agree::<f32, 3>(&case, float);
    }

    #[test]
    fn a_span_has_the_pixels_of_the_points(case in cases()) {
        for map in &maps(&case)[..2] {
            let (span, valid) = map.span(3, -50..500).unwrap();
            for x in -50..500 {
                let point = map.at(&Point2::new(f64::from(x) + 0.5, 3.5));
                prop_assert_eq!(valid.contains(&x), point.is_ok(), "{}", x);
                if let (Ok(p), Ok([u, v])) = (point, span.at(x)) {
                    let scale = 1e-9 * (1.0 + p.coords.norm());
                    prop_assert!((p - Point2::new(u, v)).norm() < scale, "{} {} {}", p, u, v);
                }
            }
        }
    }
}

#[test]
fn texels_far_out_are_as_exact_as_near_ones() {
    // One row of 65,535 texels and one of 600,000, whose value is their number, fractions of a texel read by every filter:
    // a ramp has u − ½ at u.
    for width in [65_535usize, 600_000] {
        let samples: Vec<f32> = (0..width).map(|i| (i % 4096) as f32).collect();
        let view = ImageView::<f32, 1>::new(&samples, width, 1).unwrap();
        let first = width - 1500;
        let map = Affine2::from_coefficients([first as f64 + 0.25, 0.5, 0.0], [0.5, 0.0, 0.0]);
        for filter in [Filter::Bilinear, Filter::Bicubic(Cubic::CATMULL_ROM)] {
            let mut pixels = vec![0.0; 2000];
            let mut target = ImageViewMut::<f32, 1>::new(&mut pixels, 2000, 1).unwrap();
            warp(view, &map, filter, Border::Clamp, &mut target);
            for (x, value) in pixels.iter().enumerate() {
                // u = first + ¼ + ½ (x + ½).
                let u = first as f64 + 0.5 + 0.5 * x as f64;
                let (place, whole) = (u - 0.5, (u - 0.5).floor());
                let wraps = (whole % 4096.0) > 4092.0 || (whole % 4096.0) < 2.0;
                if !wraps {
                    assert_eq!(f64::from(*value), place % 4096.0, "{filter:?} {width} {x}");
                }
            }
        }
    }
}

#[test]
fn nearest_is_exact_at_the_edges_of_texels() {
    // u = x + ½ + 1/2, x + 1: on the left edge of texel x + 1, which it belongs to.
    let samples: Vec<u16> = (0..3000).collect();
    let view = ImageView::<u16, 1>::new(&samples, 3000, 1).unwrap();
    let map = Affine2::from_coefficients([0.5, 1.0, 0.0], [0.5, 0.0, 0.0]);
    let mut pixels = vec![9u16; 2999];
    let mut target = ImageViewMut::<u16, 1>::new(&mut pixels, 2999, 1).unwrap();
    warp(view, &map, Filter::Nearest, Border::Transparent, &mut target);
    assert!(pixels.iter().enumerate().all(|(x, value)| usize::from(*value) == x + 1));
    // Below it by a little more than the rounding to 2⁻³² texel it is texel x.
    let map = Affine2::from_coefficients([0.5 - 2e-10, 1.0, 0.0], [0.5, 0.0, 0.0]);
    let mut target = ImageViewMut::<u16, 1>::new(&mut pixels, 2999, 1).unwrap();
    warp(view, &map, Filter::Nearest, Border::Transparent, &mut target);
    assert!(pixels.iter().enumerate().all(|(x, value)| usize::from(*value) == x));
}

#[test]
fn what_lies_behind_the_horizon_is_border() {
    // w = 1 − L/4: the rows from L = 4 on lie beyond the horizon, where dividing would mirror the picture.
    let map = FractionalLinear::from_coefficients(
        [8.0, 0.0, -2.0],
        [8.0, 0.0, -2.0],
        [1.0, 0.0, -0.25],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    let samples = [200u8; 256];
    let view = ImageView::<u8, 1>::new(&samples, 16, 16).unwrap();
    for filter in FILTERS {
        let mut pixels = [7u8; 100];
        let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 10, 10).unwrap();
        warp(view, &map, filter, Border::Constant([0.0; 4]), &mut target);
        for (y, row) in pixels.chunks(10).enumerate() {
            assert!(
                row.iter().all(|v| *v == if y < 4 { 200 } else { 0 }),
                "{filter:?} {y} {row:?}"
            );
        }
    }
}

/// A map that says impossible things of its rows.
#[derive(Debug)]
struct Liar(Vec<i32>);

impl Map for Liar {
    fn at(&self, screen: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        Ok(*screen)
    }

    fn jacobian(&self, _: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Ok(Matrix2::identity())
    }

    fn blocks(&self, _: i32, _: Range<i32>, emit: &mut BlockSink<'_>) {
        for &x in &self.0 {
            emit(x, &[1.5; 3], &[0.5; 3]);
            emit(x, &[2.5; 2], &[0.5; 1]);
            emit(x, &[], &[]);
        }
    }

    fn span(&self, line: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        let (span, _) = Affine2::identity().span(line, samples)?;
        let [from, to] = *self.0.first_chunk()?;
        (from != to).then_some((span, from..to))
    }
}

#[test]
fn a_map_that_lies_about_its_rows_paints_no_other_pixels() {
    let view = ImageView::<u8, 1>::new(&[10, 20, 30, 40], 4, 1).unwrap();
    let warped = |numbers: &[i32]| {
        let mut pixels = [7u8; 6];
        let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 6, 1).unwrap();
        warp(
            view,
            &Liar(numbers.to_vec()),
            Filter::Nearest,
            Border::Constant([0.0; 4]),
            &mut target,
        );
        pixels
    };
    // Spans from before the row to behind it, and from right to left.
    assert_eq!(warped(&[-3, 900]), [10, 20, 30, 40, 0, 0]);
    assert_eq!(warped(&[i32::MAX, i32::MIN]), [0; 6]);
    assert_eq!(warped(&[i32::MIN, i32::MAX]), [10, 20, 30, 40, 0, 0]);
    assert_eq!(warped(&[2, 3]), [0, 0, 30, 0, 0, 0]);
    // Blocks before the row, behind it, and one on another.
    assert_eq!(warped(&[-1]), [0; 6]);
    assert_eq!(warped(&[1, 1, 0, 4, 3]), [0, 20, 20, 20, 30, 0]);
    assert_eq!(warped(&[i32::MIN, i32::MIN, i32::MAX]), [0; 6]);
}

/// A row along each edge of a picture, many times: it is looked up in a strip that is filled up with the border.
#[test]
fn rows_along_an_edge_are_their_lookups_one_by_one() {
    let (width, height) = (150, 40);
    let samples: Vec<u8> = (0..width * height * 3).map(|i| (i * i % 253) as u8).collect();
    let view = ImageView::<u8, 3>::new(&samples, width, height).unwrap();
    let floats: Vec<f32> = samples.iter().map(|&s| f32::from(s) - 60.0).collect();
    let floats = ImageView::<f32, 3>::new(&floats, width, height).unwrap();
    let [w, h] = [width as f64, height as f64];
    // From six texels beyond an edge to four within it, one row a ninth of a texel from the next.
    let along = |u: [f64; 3], v: [f64; 3]| Affine2::from_coefficients(u, v);
    let maps = [
        along([-4.0, 0.39, 0.01], [-6.0, 0.003, 0.11]),
        along([w + 4.0, -0.39, 0.01], [h - 4.0, 0.003, 0.11]),
        along([-6.0, -0.002, 0.11], [-4.0, 0.12, 0.01]),
        along([w - 4.0, -0.002, 0.11], [h + 4.0, -0.12, 0.01]),
    ];
    fn check<T: Sample>(view: ImageView<'_, T, 3>, map: &Affine2, filter: Filter, border: Border) {
        let (tw, th) = (400, 90);
        let before = vec![T::from_f32(77.0); tw * th * 3];
        same_as_lookups::<T, 3>(
            &format!("{filter:?}"),
            [tw, th],
            before,
            border,
            |target| warp(view, map, filter, border, target),
            |y, found| {
                map.blocks(y, 0..tw as i32, &mut |x, u, v| {
                    for ((found, u), v) in found[x as usize..].iter_mut().zip(u).zip(v) {
                        *found = sample(view, &Point2::new(*u, *v), filter, border);
                    }
                });
            },
        );
    }
    for map in &maps {
        for filter in FILTERS {
            for border in BORDERS {
                check(view, map, filter, border);
                check(floats, map, filter, border);
            }
        }
    }
}

/// Rows that run down a picture of so many rows that they are painted in strips: from the numbers in the texels alone.
#[test]
fn rows_that_run_across_many_pages_of_memory_have_the_same_pixels() {
    let (width, height) = (1100, 4400);
    let texel = |x: usize, y: usize| [x as u16, y as u16, (x ^ y) as u16];
    let samples: Vec<u16> = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
    let view = ImageView::<u16, 3>::new(&samples, width, height).unwrap();
    // u = L + 20, v = 4420 − S: from 20 rows beyond the last one to the first one.
    let turn = FractionalLinear::from_coefficients(
        [20.0, 0.0, 1.0],
        [4420.0, -1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    let (tw, th) = (4420, 70);
    let mut pixels = vec![7; tw * th * 3];
    let mut target = ImageViewMut::<u16, 3>::new(&mut pixels, tw, th).unwrap();
    warp(view, &turn, Filter::Nearest, Border::Transparent, &mut target);
    for (i, pixel) in pixels.chunks_exact(3).enumerate() {
        let (x, y) = (i % tw, i / tw);
        let expected = if x < 20 { [7; 3] } else { texel(y + 20, 4419 - x) };
        assert_eq!(pixel, expected, "{x} {y}");
    }
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_paints_the_same_bytes() {
    let samples: Vec<u8> = (0..90 * 70 * 3).map(|i| (i * i % 251) as u8).collect();
    let view = ImageView::<u8, 3>::new(&samples, 90, 70).unwrap();
    let map = FractionalLinear::from_coefficients(
        [-20.0, 0.4, 0.1],
        [-30.0, -0.05, 0.5],
        [1.0, 2e-4, -1e-3],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    let painted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut pixels = vec![9; 301 * 200 * 3];
        let mut target =
            ImageViewMut::<u8, 3>::with_stride(&mut pixels, 299, 199, 301 * 3).unwrap();
        pool.install(|| {
            warp(view, &map, Filter::Lanczos3, Border::Constant([1.0; 4]), &mut target);
        });
        pixels
    };
    let one = painted(1);
    assert!(one.iter().any(|&p| p > 100) && one.contains(&1));
    // What lies between the rows is left alone.
    assert_eq!(one[299 * 3..301 * 3], [9; 6]);
    for threads in [2, 3, 8] {
        assert!(painted(threads) == one, "{threads} threads");
    }
}

/// A single row may be stated with any stride.
#[test]
fn a_row_with_an_absurd_stride_is_a_row() {
    let samples = [10u8, 20, 30, 40];
    let view = ImageView::<u8, 1>::with_stride(&samples, 4, 1, usize::MAX / 2).unwrap();
    for filter in FILTERS {
        let mut pixels = [0u8; 4];
        let mut target = ImageViewMut::<u8, 1>::with_stride(&mut pixels, 4, 1, usize::MAX).unwrap();
        let same = Affine2::from_coefficients([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        warp(view, &same, filter, Border::Clamp, &mut target);
        if filter != Filter::Bicubic(Cubic::MITCHELL) {
            assert_eq!(pixels, samples, "{filter:?}");
        }
    }
}

/// Spans end at 2²⁵ pixels, rows do not.
#[test]
fn pixels_beyond_the_reach_of_spans_are_painted() {
    let n = (1 << 25) + 100;
    let view = ImageView::<u8, 1>::new(&[7, 8], 2, 1).unwrap();
    let mut pixels = vec![0u8; n];
    let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, n, 1).unwrap();
    let same = Affine2::from_coefficients([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    warp(view, &same, Filter::Nearest, Border::Clamp, &mut target);
    assert_eq!(pixels[0], 7);
    assert!(pixels[1..].iter().all(|p| *p == 8));
}

/// A map that says its rows are valid beyond their horizon.
#[derive(Debug)]
struct Boastful;

impl Map for Boastful {
    fn at(&self, _: &Point2<f64>) -> Result<Point2<f64>, ProjectionError> {
        Err(ProjectionError::NotFinite)
    }

    fn jacobian(&self, _: &Point2<f64>) -> Result<Matrix2<f64>, ProjectionError> {
        Err(ProjectionError::NotFinite)
    }

    fn span(&self, _: i32, samples: Range<i32>) -> Option<(Span<2>, Range<i32>)> {
        // d = 1 − x/10 is positive to pixel 9.
        let span = Span::new([[0.5, 0.0], [0.5, 0.0]], [1.0, -0.1]).ok()?;
        Some((span, samples))
    }
}

#[test]
fn a_map_that_boasts_paints_no_ghosts() {
    let view = ImageView::<u8, 1>::new(&[7; 16], 4, 4).unwrap();
    let mut pixels = [1u8; 100];
    let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 100, 1).unwrap();
    warp(view, &Boastful, Filter::Bilinear, Border::Clamp, &mut target);
    assert_eq!(pixels[..10], [7; 10]);
    assert_eq!(pixels[10..], [1; 90]);
}
