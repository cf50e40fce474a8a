//! Summed-area tables, repeated integrals, volumes and many lookups a pixel against NumPy and SciPy.

use collinear::Error;
use collinear::geometry::Affine2;
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::{Matrix2, Point2, Point3};
use collinear::resample::{
    Border, Filter, Footprint, ImageView, ImageViewMut, RepeatedIntegral, SummedAreaTable,
    Supersampling, TableFilter, VolumePyramid, sample_area, warp_area, warp_supersampled,
};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{BORDERS, numbers};

fn oracle() -> Value {
    // tests/data/oracles/area_tables.py: numpy 2.4.6, scipy 1.17.1.
    serde_json::from_str(include_str!("../data/oracles/area_tables.json")).unwrap()
}

fn border(case: &Value) -> Border {
    match case["border"].as_str().unwrap() {
        "constant" => Border::Constant([40.0; 4]),
        "clamp" => Border::Clamp,
        "repeat" => Border::Repeat,
        _ => Border::Mirror,
    }
}

#[test]
fn means_over_rectangles_and_under_repeated_boxes_are_numpys() {
    let oracle = oracle();
    let samples: Vec<f32> = numbers(&oracle["samples"]).iter().map(|&s| s as f32).collect();
    let width = oracle["width"].as_u64().unwrap() as usize;
    let view = ImageView::<f32, 1>::new(&samples, width, samples.len() / width).unwrap();
    // The same picture in samples that are no whole numbers.
    let halves: Vec<f32> = samples.iter().map(|s| s * 0.001).collect();
    let halves = ImageView::<f32, 1>::new(&halves, width, samples.len() / width).unwrap();
    let table = SummedAreaTable::new(view).unwrap();
    let integrals = [1, 2, 3].map(|order| RepeatedIntegral::new(view, order).unwrap());
    let fraction = RepeatedIntegral::new(halves, 3).unwrap();
    let cases = oracle["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 120);
    for case in cases {
        let pixel = Footprint {
            position: Point2::new(case["u"].as_f64().unwrap(), case["v"].as_f64().unwrap()),
            jacobian: Matrix2::from_row_slice(&numbers(&case["j"])),
        };
        let border = border(case);
        let close = |value: Option<[f32; 1]>, expected: f64, what: &str| {
            let [value] = value.unwrap();
            assert!(
                (f64::from(value) - expected).abs() < 1e-4,
                "{what}: {value} {expected} {case}"
            );
        };
        let rectangle = sample_area(&table, &pixel, TableFilter::Rectangle, border);
        close(rectangle, case["rectangle"].as_f64().unwrap(), "rectangle");
        let strips = TableFilter::Strips(case["most"].as_u64().unwrap() as u8);
        close(
            sample_area(&table, &pixel, strips, border),
            case["strips"].as_f64().unwrap(),
            "strips",
        );
        for (integral, expected) in integrals.iter().zip(numbers(&case["repeated"])) {
            close(sample_area(integral, &pixel, (), border), expected, "repeated");
        }
        if !matches!(border, Border::Constant(_)) {
            let [value] = sample_area(&fraction, &pixel, (), border).unwrap();
            let expected = 0.001 * numbers(&case["repeated"])[2];
            assert!((f64::from(value) - expected).abs() < 1e-7, "{value} {expected}");
        }
    }
}

#[test]
fn volumes_between_their_levels_are_scipys() {
    let volume = &oracle()["volume"];
    let samples: Vec<f32> = numbers(&volume["samples"]).iter().map(|&s| s as f32).collect();
    let size = numbers(&volume["size"]);
    let pyramid =
        VolumePyramid::<f32, 1>::new(&samples, [0, 1, 2].map(|k| size[k] as usize)).unwrap();
    assert_eq!(pyramid.levels(), 4);
    for case in volume["cases"].as_array().unwrap() {
        let at = Point3::from_slice(&numbers(&case["at"]));
        let [value] = pyramid.sample(&at, case["size"].as_f64().unwrap(), border(case)).unwrap();
        assert!(
            (f64::from(value) - case["value"].as_f64().unwrap()).abs() < 1e-3,
            "{value} {case}"
        );
    }
    assert_eq!(pyramid.sample(&Point3::new(-0.1, 1.0, 1.0), 1.0, Border::Transparent), None);
    assert_eq!(pyramid.sample(&Point3::new(f64::NAN, 1.0, 1.0), 1.0, Border::Clamp), None);
    for size in [f64::NAN, f64::INFINITY, -1.0, 1e300] {
        assert!(pyramid.sample(&Point3::new(1.0, 1.0, 1.0), size, Border::Clamp).is_some());
    }
    let refused = VolumePyramid::<f32, 1>::new(&samples, [9, 6, 4]).unwrap_err();
    assert!(matches!(refused, Error::LengthMismatch { left: 270, right: 216, .. }));
    assert!(VolumePyramid::<f32, 1>::new(&samples, [usize::MAX, 2, 2]).is_err());
    let empty = VolumePyramid::<f32, 1>::new(&[], [0, 6, 4]).unwrap();
    assert_eq!(empty.sample(&Point3::new(1.0, 1.0, 1.0), 1.0, Border::Clamp), None);
}

#[test]
fn repeated_integrals_of_large_pictures_lose_no_digit() {
    // Threefold sums reach 10²⁰ here; beside the far corner they differ by single levels.
    let side = 1500;
    let bytes: Vec<u8> =
        (0..side * side).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let side = side as usize;
    let view = ImageView::<u8, 1>::new(&bytes, side, side).unwrap();
    let integral = RepeatedIntegral::new(view, 3).unwrap();
    for (x, y) in [(3, 5), (side - 4, side - 9), (700, 1400)] {
        let texel = Footprint {
            position: Point2::new(x as f64 + 0.5, y as f64 + 0.5),
            jacobian: Matrix2::identity(),
        };
        assert_eq!(sample_area(&integral, &texel, (), Border::Clamp), view.pixel(x, y));
    }
}

#[test]
fn lookups_in_a_pixel_lie_where_they_are_said_to() {
    // A map whose value is its place: one lookup in the middle, four at quarters.
    let ramp: Vec<f32> = (0..64).map(|i| i as f32).collect();
    let view = ImageView::<f32, 1>::new(&ramp, 64, 1).unwrap();
    let row = |map: &dyn Map, places, border| {
        let mut pixels = [-1.0f32; 4];
        let mut target = ImageViewMut::<f32, 1>::new(&mut pixels, 4, 1).unwrap();
        warp_supersampled(view, map, places, Filter::Bilinear, border, &mut target);
        pixels
    };
    let wide = Affine2::from_coefficients([8.0, 8.0, 0.0], [0.5, 0.0, 0.0]);
    for places in [
        Supersampling::Grid(1),
        Supersampling::Grid(5),
        Supersampling::Adaptive { depth: 1, tolerance: 0.0 },
        Supersampling::Adaptive { depth: 3, tolerance: 0.0 },
    ] {
        let pixels = row(&wide, places, Border::Clamp);
        for (x, pixel) in pixels.into_iter().enumerate() {
            assert!(
                (pixel - (8.0 + 8.0 * (x as f32 + 0.5) - 0.5)).abs() < 1e-5,
                "{places:?} {pixel}"
            );
        }
    }
    // Jittered lookups differ by the seed, repeat with it, and have the same mean: 8 texels / √12 / √16 apart.
    let jittered = |seed| row(&wide, Supersampling::Jittered { side: 4, seed }, Border::Clamp);
    assert_eq!(jittered(7), jittered(7));
    assert_ne!(jittered(7), jittered(8));
    let mean: f32 = (0..200).map(|seed| jittered(seed)[1]).sum::<f32>() / 200.0;
    assert!((mean - 19.5).abs() < 0.06, "{mean}");
    // u = 64/S has a horizon at the left edge of pixel 0; and u = 2 S − 2 leaves half of pixel 1 outside.
    let half = FractionalLinear::from_coefficients(
        [-1.0, 1.0, 0.0],
        [0.5, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
    )
    .unwrap();
    let moved = Affine2::from_coefficients([-1.5, 1.0, 0.0], [0.5, 0.0, 0.0]);
    let grid = Supersampling::Grid(2);
    assert_eq!(row(&half, grid, Border::Transparent)[0], -1.0);
    // Two of four lookups at u = −0.25 are the constant 100, those at 0.25 read texel 0 and half a texel of the constant's.
    assert_eq!(row(&moved, grid, Border::Constant([100.0; 4]))[0], 100.0);
    assert_eq!(row(&moved, grid, Border::Transparent)[1], 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn tables_keep_constants_and_ramps_and_survive_anything(
        byte in any::<u8>(), u in -50.0..80.0f64, v in -50.0..80.0f64,
        j in proptest::array::uniform4(-40.0..40.0f64), k in 0..5usize, hostile in 0..6usize,
    ) {
        let bytes = [byte; 20 * 17];
        let view = ImageView::<u8, 1>::new(&bytes, 20, 17).unwrap();
        let table = SummedAreaTable::new(view).unwrap();
        let ramp: Vec<f32> = (0..900).map(|i| (i % 30) as f32 - 2.0 * (i / 30) as f32).collect();
        let ramp = ImageView::<f32, 1>::new(&ramp, 30, 30).unwrap();
        let of_ramp = SummedAreaTable::new(ramp).unwrap();
        let border = match BORDERS[k] {
            Border::Constant(_) => Border::Constant([f32::from(byte); 4]),
            Border::Transparent => Border::Clamp,
            border => border,
        };
        let pixel = Footprint { position: Point2::new(u, v), jacobian: Matrix2::from_row_slice(&j) };
        for filter in [TableFilter::Rectangle, TableFilter::Strips(8)] {
            prop_assert_eq!(sample_area(&table, &pixel, filter, border), Some([byte]));
            let small = Footprint { position: Point2::new(15.0 + u / 40.0, 15.0 + v / 40.0), jacobian: Matrix2::from_row_slice(&j) / 10.0 };
            let [value] = sample_area(&of_ramp, &small, filter, border).unwrap();
            let expected = small.position.x - 0.5 - 2.0 * (small.position.y - 0.5);
            // Texels are squares of one value: parts of them are off by up to an eighth, along both axes.
            prop_assert!((f64::from(value) - expected).abs() < 3.0 / 8.0, "{} {}", value, expected);
            let whole = Footprint { jacobian: Matrix2::new(j[0] / 4.0, 0.0, 0.0, j[3] / 4.0).map(f64::ceil), ..small };
            let [value] = sample_area(&of_ramp, &whole, filter, border).unwrap();
            prop_assert!((f64::from(value) - expected).abs() < 1e-4, "{} {}", value, expected);
        }
        for order in 1..=3 {
            let integral = RepeatedIntegral::new(view, order).unwrap();
            prop_assert_eq!(sample_area(&integral, &pixel, (), border), Some([byte]));
            let small = Footprint { position: Point2::new(15.0 + u / 40.0, 15.0 + v / 40.0), jacobian: Matrix2::from_row_slice(&j) / 10.0 };
            let [value] = sample_area(&RepeatedIntegral::new(ramp, order).unwrap(), &small, (), border).unwrap();
            let expected = small.position.x - 0.5 - 2.0 * (small.position.y - 0.5);
            prop_assert!((f64::from(value) - expected).abs() < 1e-4, "{} {}", value, expected);
        }
        let number = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 0.0, -1e-300][hostile];
        let bad = Footprint { position: Point2::new(u, v), jacobian: Matrix2::new(number, j[0], j[1], number) };
        for border in BORDERS {
            let inside = (0.0..20.0).contains(&u) && (0.0..17.0).contains(&v);
            let some = inside || border != Border::Transparent;
            prop_assert_eq!(sample_area(&table, &bad, TableFilter::Strips(255), border).is_some(), some);
            let integral = RepeatedIntegral::new(view, 2).unwrap();
            prop_assert_eq!(sample_area(&integral, &bad, (), border).is_some(), some);
        }
    }
}

#[test]
fn tables_of_odd_pictures_and_what_is_refused() {
    let empty = ImageView::<u8, 1>::new(&[], 0, 3).unwrap();
    let one = ImageView::<u8, 1>::new(&[9], 1, 1).unwrap();
    let pixel = Footprint { position: Point2::new(0.5, 0.5), jacobian: Matrix2::identity() * 9.0 };
    let (none, single) = (SummedAreaTable::new(empty).unwrap(), SummedAreaTable::new(one).unwrap());
    assert_eq!(sample_area(&none, &pixel, TableFilter::Rectangle, Border::Clamp), None);
    assert_eq!(sample_area(&single, &pixel, TableFilter::Rectangle, Border::Mirror), Some([9]));
    for order in 1..=3 {
        let (none, single) = (
            RepeatedIntegral::new(empty, order).unwrap(),
            RepeatedIntegral::new(one, order).unwrap(),
        );
        assert_eq!(sample_area(&none, &pixel, (), Border::Clamp), None);
        assert_eq!(sample_area(&single, &pixel, (), Border::Repeat), Some([9]));
    }
    for order in [0, 4] {
        assert!(matches!(RepeatedIntegral::new(one, order), Err(Error::OutOfRange { .. })));
    }
    let nan = ImageView::<f32, 1>::new(&[f32::NAN], 1, 1).unwrap();
    assert!(matches!(RepeatedIntegral::new(nan, 1), Err(Error::NotFinite { .. })));
    // Rows of a target are painted by the same lookups, what has none by the border's constant.
    let table = SummedAreaTable::new(one).unwrap();
    let mut pixels = [0; 6];
    let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 3, 2).unwrap();
    let map = FractionalLinear::from_coefficients(
        [0.5, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0],
    )
    .unwrap();
    warp_area(&table, &map, TableFilter::Rectangle, Border::Constant([3.0; 4]), &mut target);
    assert_eq!(pixels, [3, 9, 9, 3, 9, 9]);
}
