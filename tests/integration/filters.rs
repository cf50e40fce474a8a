//! Cubic and Lanczos filters against 30 digits, SciPy and OpenCV, and what they reproduce.

use collinear::nalgebra::Point2;
use collinear::resample::{Border, Cubic, Filter, ImageView, Sample, sample};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::numbers;

const NAMED: [(&str, Filter); 8] = [
    ("keys -0.75", Filter::Bicubic(Cubic::keys(-0.75))),
    ("keys -1", Filter::Bicubic(Cubic::keys(-1.0))),
    ("catmull_rom", Filter::Bicubic(Cubic::CATMULL_ROM)),
    ("mitchell", Filter::Bicubic(Cubic::MITCHELL)),
    ("b_spline", Filter::Bicubic(Cubic::B_SPLINE)),
    ("lanczos2", Filter::Lanczos2),
    ("lanczos3", Filter::Lanczos3),
    ("lanczos4", Filter::Lanczos4),
];

const BORDERS: [(&str, Border); 4] = [
    ("constant", Border::Constant([40.0; 4])),
    ("clamp", Border::Clamp),
    ("repeat", Border::Repeat),
    ("mirror", Border::Mirror),
];

#[test]
fn cubic_and_lanczos_filters_are_those_of_their_formulas_of_scipy_and_of_opencv() {
    // tests/data/oracles/filters.py: mpmath 1.4.1 with 30 digits, scipy 1.17.1, OpenCV 5.0.0.
    let oracle: Value = serde_json::from_str(include_str!("../data/oracles/filters.json")).unwrap();
    let (u, v) = (numbers(&oracle["u"]), numbers(&oracle["v"]));
    let samples = numbers(&oracle["samples"]);
    let width = oracle["width"].as_u64().unwrap() as usize;
    let height = samples.len() / width;
    let floats: Vec<f32> = samples.iter().map(|&s| s as f32).collect();
    let bytes: Vec<u8> = samples.iter().map(|&s| s as u8).collect();
    let words: Vec<u16> = samples.iter().map(|&s| s as u16).collect();
    let floats = ImageView::<f32, 1>::new(&floats, width, height).unwrap();
    let bytes = ImageView::<u8, 1>::new(&bytes, width, height).unwrap();
    let words = ImageView::<u16, 1>::new(&words, width, height).unwrap();
    let mut compared = [0; 3];
    for (name, filter) in NAMED {
        for (border_name, border) in BORDERS {
            for (k, (program, tolerance)) in
                [("exact", 1e-4), ("scipy", 1e-4), ("opencv", 2.5e-4)].into_iter().enumerate()
            {
                let values = &oracle["values"][format!("{program} {border_name} {name}")];
                if values.is_null() {
                    continue;
                }
                for ((u, v), expected) in u.iter().zip(&v).zip(numbers(values)) {
                    let position = Point2::new(*u, *v);
                    let what = format!("{program} {border_name} {name} {u} {v}");
                    let [value] = sample(floats, &position, filter, border).unwrap();
                    assert!(
                        (f64::from(value) - expected).abs() < tolerance,
                        "{what}: {value} {expected}"
                    );
                    // Integers are the value rounded, except where it lies at a half.
                    let rounded = (expected + 0.5).floor();
                    if (expected + 0.5 - rounded).abs().min((rounded + 0.5 - expected).abs())
                        > tolerance
                    {
                        let byte = sample(bytes, &position, filter, border).unwrap();
                        assert_eq!(byte, [rounded.clamp(0.0, 255.0) as u8], "{what}");
                        let word = sample(words, &position, filter, border).unwrap();
                        assert_eq!(word, [rounded.clamp(0.0, 65_535.0) as u16], "{what}");
                    }
                    compared[k] += 1;
                }
            }
        }
    }
    assert_eq!(compared, [8 * 4 * 76, 4 * 76, 2 * 4 * 76]);
}

/// A picture of 40 × 40 from a function of the texel's centre.
fn picture(f: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    (0..1600).map(|i| f((i % 40) as f64 + 0.5, (i / 40) as f64 + 0.5) as f32).collect()
}

proptest! {
    #[test]
    fn weights_sum_to_one(b in -1.0..2.0f64, c in -1.0..2.0f64, fraction in 0.0..=1.0f64) {
        let sum: f64 = Cubic { b, c }.weights(fraction).iter().sum();
        prop_assert!((sum - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_constant_picture_stays_constant(
        byte in any::<u8>(), u in -60.0..60.0f64, v in -60.0..60.0f64, k in 0..4usize,
    ) {
        let (_, border) = BORDERS[k];
        let bytes = [byte; 35];
        let floats = bytes.map(f32::from);
        let bytes = ImageView::<u8, 1>::new(&bytes, 7, 5).unwrap();
        let floats = ImageView::<f32, 1>::new(&floats, 7, 5).unwrap();
        let border = match border {
            Border::Constant(_) => Border::Constant([f32::from(byte); 4]),
            border => border,
        };
        for (name, filter) in NAMED {
            let position = Point2::new(u, v);
            prop_assert_eq!(sample(bytes, &position, filter, border), Some([byte]), "{}", name);
            let [value] = sample(floats, &position, filter, border).unwrap();
            prop_assert!((value - f32::from(byte)).abs() <= 1e-6 * f32::from(byte), "{}", name);
        }
    }

    #[test]
    fn interpolating_filters_reproduce_texels_and_cubics_ramps(
        a in -50.0..50.0f64, b in -3.0..3.0f64, c in -3.0..3.0f64, u in 4.0..36.0f64, v in 4.0..36.0f64,
    ) {
        let ramp = picture(|x, y| a + b * x + c * y);
        let ramp = ImageView::<f32, 1>::new(&ramp, 40, 40).unwrap();
        let at = |filter, u, v| sample(ramp, &Point2::new(u, v), filter, Border::Clamp).unwrap()[0];
        // B + 2C = 1.
        for cubic in [Cubic::CATMULL_ROM, Cubic::MITCHELL, Cubic::B_SPLINE, Cubic { b: -0.5, c: 0.75 }] {
            let value = f64::from(at(Filter::Bicubic(cubic), u, v));
            prop_assert!((value - (a + b * u + c * v)).abs() < 2e-4, "{:?}", cubic);
        }
        let (x, y) = (u.floor(), v.floor());
        let texel = ramp.pixel(x as usize, y as usize).unwrap()[0];
        for (name, filter) in NAMED {
            if !["mitchell", "b_spline"].contains(&name) {
                let value = at(filter, x + 0.5, y + 0.5);
                prop_assert!((value - texel).abs() <= 1e-6 * texel.abs(), "{name} {value} {texel}");
            }
        }
    }

    #[test]
    fn keys_cubic_of_minus_a_half_reproduces_parabolas_and_no_other_does(
        a in -2.0..2.0f64, b in -2.0..2.0f64, c in -2.0..2.0f64, u in 4.0..36.0f64, v in 4.0..36.0f64,
    ) {
        let f = |x: f64, y: f64| a * (x - 20.0).powi(2) + b * (x - 20.0) * (y - 20.0) + c * (y - 20.0).powi(2);
        let parabola = picture(f);
        let view = ImageView::<f32, 1>::new(&parabola, 40, 40).unwrap();
        let at = |cubic, u, v| {
            f64::from(sample(view, &Point2::new(u, v), Filter::Bicubic(cubic), Border::Clamp).unwrap()[0])
        };
        prop_assert!((at(Cubic::CATMULL_ROM, u, v) - f(u, v)).abs() < 1e-3);
        // Halfway between centres the weights are a/8 and 1/2 - a/8: of x² they make (a + 1/2)/2 too much.
        let off = at(Cubic::keys(-0.75), 21.0, 20.5) - f(21.0, 20.5);
        prop_assert!((off + 0.125 * a).abs() < 1e-3);
    }
}

#[test]
fn words_of_sixteen_bits_round_half_up_and_saturate() {
    for (value, word) in [
        (0.49, 0),
        (0.5, 1),
        (254.5, 255),
        (65_534.5, 65_535),
        (65_535.0, 65_535),
        (1e30, 65_535),
        (-0.6, 0),
        (f32::NEG_INFINITY, 0),
        (f32::INFINITY, 65_535),
        (f32::NAN, 0),
    ] {
        assert_eq!(u16::from_f32(value), word, "{value}");
    }
    assert_eq!(u16::to_f32(65_535), 65_535.0);
}
