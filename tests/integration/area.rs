//! Pyramids and averages over areas against NumPy, SciPy and OpenCV, and what they reproduce.

use collinear::Error;
use collinear::geometry::Affine2;
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::{Matrix2, Point2};
use collinear::resample::{
    AreaFilter, Border, Footprint, ImageView, ImageViewMut, Pyramid, Sample, sample_area, warp_area,
};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{BORDERS, noise, numbers, same_as_lookups};

const FILTERS: [AreaFilter; 4] = [
    AreaFilter::NearestLevel,
    AreaFilter::Trilinear,
    AreaFilter::Ewa { anisotropy: 16 },
    AreaFilter::Ewa { anisotropy: 2 },
];

fn oracle() -> Value {
    // tests/data/oracles/area.py: numpy 2.4.6, scipy 1.17.1, OpenCV 5.0.0.
    serde_json::from_str(include_str!("../data/oracles/area.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The oracle's picture.
fn picture(oracle: &Value) -> (Vec<f32>, usize, usize) {
    let samples: Vec<f32> = numbers(&oracle["samples"]).iter().map(|&s| s as f32).collect();
    let width = oracle["width"].as_u64().unwrap() as usize;
    let height = samples.len() / width;
    (samples, width, height)
}

fn footprint(case: &Value) -> Footprint {
    Footprint {
        position: Point2::new(number(&case["u"]), number(&case["v"])),
        jacobian: Matrix2::from_row_slice(&numbers(&case["j"])),
    }
}

#[test]
fn the_levels_of_a_pyramid_are_means_over_areas() {
    let oracle = oracle();
    let (samples, width, height) = picture(&oracle);
    let bytes: Vec<u8> = samples.iter().map(|&s| s as u8).collect();
    let mut compared = 0;
    for ratio in [2.0, 1.5, 1.12, 3.0] {
        let floats = ImageView::<f32, 1>::new(&samples, width, height).unwrap();
        let pyramid = Pyramid::with_ratio(floats, ratio).unwrap();
        let bytes = ImageView::<u8, 1>::new(&bytes, width, height).unwrap();
        let of_bytes = Pyramid::with_ratio(bytes, ratio).unwrap();
        let levels = oracle["levels"][format!("{ratio:?}")].as_array().unwrap();
        assert_eq!(pyramid.levels(), levels.len());
        for (k, level) in levels.iter().enumerate() {
            let view = pyramid.level(k).unwrap();
            assert_eq!(view.width() as u64, level["width"].as_u64().unwrap());
            for (i, expected) in numbers(&level["values"]).into_iter().enumerate() {
                let (x, y) = (i % view.width(), i / view.width());
                let [value] = view.pixel(x, y).unwrap();
                assert!(
                    (f64::from(value) - expected).abs() < 1e-4,
                    "{ratio} {k}: {value} {expected}"
                );
                if (expected.fract() - 0.5).abs() > 1e-3 {
                    let byte = of_bytes.level(k).unwrap().pixel(x, y);
                    assert_eq!(byte, Some([(expected + 0.5).floor() as u8]), "{ratio} {k}");
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 9000, "{compared}");
    let pyramid = Pyramid::new(ImageView::<f32, 1>::new(&samples, width, height).unwrap()).unwrap();
    let level = pyramid.level(1).unwrap();
    for (i, expected) in numbers(&oracle["opencv"]).into_iter().enumerate() {
        let [value] = level.pixel(i % level.width(), i / level.width()).unwrap();
        assert!((f64::from(value) - expected).abs() < 1e-3, "OpenCV {i}: {value} {expected}");
    }
}

#[test]
fn lookups_by_level_and_by_ellipse_are_scipys_and_numpys() {
    let oracle = oracle();
    let (samples, width, height) = picture(&oracle);
    let view = ImageView::<f32, 1>::new(&samples, width, height).unwrap();
    let of_ratio = |ratio| (ratio, Pyramid::with_ratio(view, ratio).unwrap());
    let pyramids = [of_ratio(2.0), of_ratio(1.5)];
    let mut worst = [0.0f64; 3];
    let cases = oracle["lookups"].as_array().unwrap();
    assert_eq!(cases.len(), 240);
    for case in cases {
        let ratio = number(&case["ratio"]);
        let (_, pyramid) = pyramids.iter().find(|(r, _)| *r == ratio).unwrap();
        let border = match case["border"].as_str().unwrap() {
            "constant" => Border::Constant([40.0; 4]),
            "clamp" => Border::Clamp,
            "repeat" => Border::Repeat,
            _ => Border::Mirror,
        };
        let anisotropy = case["anisotropy"].as_u64().unwrap() as u8;
        let filters = [
            ("trilinear", AreaFilter::Trilinear),
            ("nearest", AreaFilter::NearestLevel),
            ("ewa", AreaFilter::Ewa { anisotropy }),
        ];
        for (worst, (name, filter)) in worst.iter_mut().zip(filters) {
            let [value] = sample_area(pyramid, &footprint(case), filter, border).unwrap();
            *worst = worst.max((f64::from(value) - number(&case[name])).abs());
            assert!(*worst < 2e-3, "{name}: {value} {case}");
        }
    }
    println!("largest differences {worst:?}");
}

#[test]
fn an_ellipse_damps_a_wave_as_its_transform_says() {
    let waves = &oracle()["waves"];
    let side = waves["side"].as_u64().unwrap() as usize;
    for case in waves["cases"].as_array().unwrap() {
        let f = numbers(&case["f"]);
        let samples: Vec<f32> = (0..side * side)
            .map(|i| {
                let (x, y) = ((i % side) as f64 + 0.5, (i / side) as f64 + 0.5);
                let phase = core::f64::consts::TAU * (f[0] * x + f[1] * y);
                (60.0 + 50.0 * phase.cos()) as f32
            })
            .collect();
        let view = ImageView::<f32, 1>::new(&samples, side, side).unwrap();
        let pyramid = Pyramid::new(view).unwrap();
        let filter = AreaFilter::Ewa { anisotropy: 16 };
        let [value] = sample_area(&pyramid, &footprint(case), filter, Border::Clamp).unwrap();
        // A sum of texels stands for the integral.
        assert!((f64::from(value) - number(&case["mean"])).abs() < 0.3, "{value} {case}");
    }
}

/// What a test draws at random.
#[derive(Clone, Debug)]
struct Case {
    size: [usize; 2],
    target: [usize; 2],
    seed: u32,
    coefficients: [f64; 9],
    border: usize,
    ratio: f64,
}

fn cases() -> impl Strategy<Value = Case> {
    let unit = -1.0..1.0f64;
    let sizes = ([1..90usize, 1..70usize], [1..200usize, 1..4usize]);
    let ratio = prop_oneof![Just(2.0), 1.05..4.0f64];
    (sizes, any::<u32>(), proptest::array::uniform9(unit), 0..5usize, ratio).prop_map(
        |((size, target), seed, coefficients, border, ratio)| Case {
            size,
            target,
            seed,
            coefficients,
            border,
            ratio,
        },
    )
}

/// Maps that shrink to nearly nothing, turn, and have a horizon.
fn maps(case: &Case) -> [FractionalLinear; 2] {
    let [a, b, c, d, e, f, g, h, size] = case.coefficients;
    let [w, height] = case.size.map(|n| n as f64);
    let [tw, th] = case.target.map(|n| n as f64);
    let scale = 16f64.powf(size);
    let forms = |g, h| {
        FractionalLinear::from_coefficients(
            [w * (0.5 + 0.5 * a), scale * w / tw * b, scale * c],
            [height * (0.5 + 0.5 * d), scale * height / tw * e, scale * height / th * f],
            [1.0, 1.5 * g / tw, h],
            [1.0, 0.0, 0.0],
        )
    };
    [forms(0.0, 0.0).unwrap(), forms(g, 0.2 * h).unwrap()]
}

fn agree<T: Sample, const C: usize>(case: &Case, of: impl Fn(u32) -> T) {
    let [width, height] = case.size;
    let mut next = noise(case.seed, of);
    let samples: Vec<T> = (0..width * height * C).map(|_| next()).collect();
    let view = ImageView::<T, C>::new(&samples, width, height).unwrap();
    let pyramid = Pyramid::with_ratio(view, case.ratio).unwrap();
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
                |target| warp_area(&pyramid, map, filter, border, target),
                |y, found| {
                    map.footprints(y, 0..tw as i32, &mut |block| {
                        for i in 0..block.u.len() {
                            let [us, vs, ul, vl] = [
                                block.by_sample[0][i],
                                block.by_sample[1][i],
                                block.by_line[0][i],
                                block.by_line[1][i],
                            ];
                            let pixel = Footprint {
                                position: Point2::new(block.u[i], block.v[i]),
                                jacobian: Matrix2::new(us, ul, vs, vl),
                            };
                            found[block.x as usize + i] =
                                sample_area(&pyramid, &pixel, filter, border);
                        }
                    });
                },
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Single lookups are compiled without vectors, rows with them where the feature `simd` is on; and since a single lookup
    /// knows no row, rows may be cut anywhere.
    #[test]
    fn a_picture_through_a_map_is_its_pixels_looked_up_one_by_one(case in cases()) {
        agree::<u8, 1>(&case, |r| r as u8);
        agree::<u8, 3>(&case, |r| r as u8);
        agree::<u8, 4>(&case, |r| (r >> 8) as u8);
        agree::<u16, 2>(&case, |r| r as u16);
        agree::<u16, 3>(&case, |r| r as u16);
        agree::<f32, 1>(&case, |r| r as f32 * 1e-3);
        agree::<f32, 3>(&case, |r| r as f32 * 1e-7);
        agree::<f32, 4>(&case, |r| r as f32 * 1e-7);
    }

    #[test]
    fn a_constant_picture_stays_constant_at_every_size(case in cases(), byte in any::<u8>()) {
        let [width, height] = case.size;
        let bytes = vec![byte; width * height];
        let pyramid = Pyramid::with_ratio(ImageView::<u8, 1>::new(&bytes, width, height).unwrap(), case.ratio).unwrap();
        let border = match BORDERS[case.border] {
            Border::Constant(_) => Border::Constant([f32::from(byte); 4]),
            Border::Transparent => Border::Clamp,
            border => border,
        };
        for map in maps(&case) {
            for filter in FILTERS {
                let mut pixels = vec![byte; case.target[0] * case.target[1]];
                let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, case.target[0], case.target[1]).unwrap();
                warp_area(&pyramid, &map, filter, border, &mut target);
                prop_assert!(pixels.iter().all(|&p| p == byte), "{:?}", filter);
            }
        }
    }

    #[test]
    fn magnified_ramps_are_reproduced(
        a in -3.0..3.0f64, b in -3.0..3.0f64, u in 8.0..32.0f64, v in 8.0..32.0f64, s in 0.01..1.0f64, t in 0.0..6.3f64,
    ) {
        let ramp: Vec<f32> = (0..1600).map(|i| (a * ((i % 40) as f64 + 0.5) + b * ((i / 40) as f64 + 0.5)) as f32).collect();
        let pyramid = Pyramid::new(ImageView::<f32, 1>::new(&ramp, 40, 40).unwrap()).unwrap();
        let jacobian = Matrix2::new(t.cos(), -t.sin(), t.sin(), t.cos()) * s;
        let pixel = Footprint { position: Point2::new(u, v), jacobian };
        let of = |filter| f64::from(sample_area(&pyramid, &pixel, filter, Border::Clamp).unwrap()[0]);
        let expected = a * u + b * v;
        prop_assert!((of(AreaFilter::Trilinear) - expected).abs() < 1e-4);
        prop_assert!((of(AreaFilter::NearestLevel) - expected).abs() < 1e-4);
        // Weights of an ellipse sum to one, and their centre is off by less than 0.03 texel.
        let off = (of(AreaFilter::Ewa { anisotropy: 16 }) - expected).abs();
        prop_assert!(off < 0.03 * (a.abs() + b.abs()) + 1e-4, "{}", off);
    }

    #[test]
    fn rows_of_footprints_are_positions_and_jacobians(case in cases()) {
        for map in maps(&case) {
            let mut positions = Vec::new();
            map.blocks(1, -20..150, &mut |x, u, v| {
                positions.extend((x..).zip(u.iter().zip(v)).map(|(x, (u, v))| (x, *u, *v)));
            });
            let mut n = 0;
            map.footprints(1, -20..150, &mut |block| {
                for i in 0..block.u.len() {
                    let (x, u, v) = positions[n];
                    assert_eq!((block.x + i as i32, block.u[i].to_bits(), block.v[i].to_bits()), (x, u.to_bits(), v.to_bits()));
                    // Beside the horizon both round.
                    if let Ok(j) = map.jacobian(&Point2::new(f64::from(x) + 0.5, 1.5)) {
                        let [us, vs] = block.by_sample.map(|d| d[i]);
                        let [ul, vl] = block.by_line.map(|d| d[i]);
                        assert!((Matrix2::new(us, ul, vs, vl) - j).norm() <= 1e-9 * (1.0 + j.norm().powi(2)), "{j}");
                    }
                    n += 1;
                }
            });
            prop_assert_eq!(n, positions.len());
        }
    }
}

#[test]
fn maps_that_are_no_spans_have_footprints_too() {
    /// A map that knows nothing but points.
    #[derive(Debug)]
    struct Points(Affine2);
    impl Map for Points {
        fn at(&self, p: &Point2<f64>) -> Result<Point2<f64>, collinear::ProjectionError> {
            self.0.at(p)
        }
        fn jacobian(&self, p: &Point2<f64>) -> Result<Matrix2<f64>, collinear::ProjectionError> {
            self.0.jacobian(p)
        }
    }
    let affine = Affine2::from_coefficients([3.0, 2.0, -1.0], [5.0, 0.5, 3.0]);
    let samples: Vec<u8> = (0..64 * 64).map(|i| (i * i % 251) as u8).collect();
    let pyramid = Pyramid::new(ImageView::<u8, 1>::new(&samples, 64, 64).unwrap()).unwrap();
    for filter in FILTERS {
        let paint = |map: &dyn Map| {
            let mut pixels = vec![0; 150 * 5];
            let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 150, 5).unwrap();
            warp_area(&pyramid, map, filter, Border::Mirror, &mut target);
            pixels
        };
        assert_eq!(paint(&affine), paint(&Points(affine)));
    }
}

#[test]
fn hostile_pyramids_footprints_and_ratios() {
    let one = ImageView::<u8, 1>::new(&[7], 1, 1).unwrap();
    for ratio in [f64::NAN, 1.0, 0.5, -2.0, 17.0, f64::INFINITY] {
        let refused = Pyramid::with_ratio(one, ratio).unwrap_err();
        assert!(matches!(refused, Error::OutOfRange { what: "pyramid ratio", .. }));
    }
    let empty = Pyramid::new(ImageView::<u8, 1>::new(&[], 0, 5).unwrap()).unwrap();
    assert_eq!(empty.levels(), 0);
    let single = Pyramid::new(one).unwrap();
    assert_eq!(single.levels(), 1);
    let column: Vec<u8> = (0..200).collect();
    let column = Pyramid::new(ImageView::<u8, 1>::new(&column, 1, 200).unwrap()).unwrap();
    let numbers = [0.0, -0.0, 1e-300, 1.0, -3.0, 1e30, -1e300, f64::INFINITY, f64::NAN];
    for filter in FILTERS {
        for border in BORDERS {
            for a in numbers {
                for b in numbers {
                    for jacobian in [Matrix2::new(a, b, b, a), Matrix2::new(a, 0.0, 0.0, b)] {
                        let at = |x, y| Footprint { position: Point2::new(x, y), jacobian };
                        assert_eq!(sample_area(&empty, &at(0.5, 0.5), filter, border), None);
                        if !matches!(border, Border::Constant(_)) {
                            assert_eq!(
                                sample_area(&single, &at(0.5, 0.5), filter, border),
                                Some([7])
                            );
                        }
                        assert!(sample_area(&column, &at(0.5, 99.5), filter, border).is_some());
                        for x in [f64::NAN, f64::INFINITY, -1e300] {
                            assert_eq!(sample_area(&column, &at(x, 0.5), filter, border), None);
                        }
                    }
                }
            }
        }
    }
    let column = ImageView::<f32, 1>::new(&[f32::NAN, f32::INFINITY, 1.0, -1.0], 1, 4).unwrap();
    let pyramid = Pyramid::new(column).unwrap();
    let mut pixels = [0.0; 64];
    let mut target = ImageViewMut::<f32, 1>::new(&mut pixels, 8, 8).unwrap();
    let map = Affine2::from_coefficients([0.0, 1e18, 3.0], [0.0, f64::NAN, 1.0]);
    for filter in FILTERS {
        warp_area(&pyramid, &map, filter, Border::Clamp, &mut target);
        warp_area(&pyramid, &Affine2::identity(), filter, Border::Repeat, &mut target);
    }
}

#[test]
fn pictures_whose_texels_are_not_all_counted_in_blocks_are_painted_alike() {
    // A side of 2¹⁹ is beyond what positions are split for by addition.
    let long: Vec<u8> =
        (0..(1 << 19)).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let pyramid = Pyramid::new(ImageView::<u8, 1>::new(&long, 1 << 19, 1).unwrap()).unwrap();
    let shorter =
        Pyramid::new(ImageView::<u8, 1>::new(&long[1024..], (1 << 19) - 1024, 1).unwrap()).unwrap();
    for filter in FILTERS {
        let paint = |pyramid: &Pyramid<u8, 1>, offset| {
            let mut pixels = vec![0; 200];
            let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 200, 1).unwrap();
            let map = Affine2::from_coefficients([offset, 4.0, 0.0], [0.0, 0.0, 1.0]);
            warp_area(pyramid, &map, filter, Border::Clamp, &mut target);
            pixels
        };
        assert_eq!(paint(&pyramid, 300_000.0), paint(&shorter, 300_000.0 - 1024.0), "{filter:?}");
    }
}
