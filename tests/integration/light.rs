//! Warping by light and opacity against sRGB's formulas with 30 digits, and what must come back as it was.

use collinear::geometry::Affine2;
use collinear::resample::{
    Alpha, Border, Coding, Filter, ImageView, ImageViewMut, Light, Sample, warp, warp_by_light,
};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::numbers;

const CODINGS: [(Light, Alpha); 6] = [
    (Light::Linear, Alpha::None),
    (Light::Linear, Alpha::Straight),
    (Light::Linear, Alpha::Premultiplied),
    (Light::Srgb, Alpha::None),
    (Light::Srgb, Alpha::Straight),
    (Light::Srgb, Alpha::Premultiplied),
];

fn shifted(by: f64) -> Affine2 {
    Affine2::from_coefficients([by, 1.0, 0.0], [0.0, 0.0, 1.0])
}

/// The pixel at a fraction of the way between two.
fn between<T: Sample>(pixels: &[T], fraction: f64, coding: Coding) -> [T; 4] {
    let view = ImageView::<T, 4>::new(pixels, 2, 1).unwrap();
    let mut pixel = [T::default(); 4];
    let mut target = ImageViewMut::<T, 4>::new(&mut pixel, 1, 1).unwrap();
    warp_by_light(view, &shifted(fraction), Filter::Bilinear, Border::Clamp, coding, &mut target)
        .unwrap();
    pixel
}

#[test]
fn pixels_between_two_are_those_of_srgbs_formulas() {
    // tests/data/oracles/light.py: mpmath 1.4.1, 30 digits.
    let oracle: Value = serde_json::from_str(include_str!("../data/oracles/light.json")).unwrap();
    let mut rounded = 0;
    for case in oracle["cases"].as_array().unwrap() {
        let light = if case["srgb"].as_bool().unwrap() { Light::Srgb } else { Light::Linear };
        let alpha = match case["alpha"].as_str().unwrap() {
            "none" => Alpha::None,
            "straight" => Alpha::Straight,
            _ => Alpha::Premultiplied,
        };
        let coding = Coding { light, alpha };
        let full = case["full"].as_f64().unwrap();
        let samples: Vec<f64> =
            case["pixels"].as_array().unwrap().iter().flat_map(numbers).collect();
        let fraction = case["fraction"].as_f64().unwrap();
        let expected = numbers(&case["expected"]);
        let floats: Vec<f32> = samples.iter().map(|s| (s / full) as f32).collect();
        let value = between(&floats, fraction, coding);
        let made: [f64; 4] = if full == 255.0 {
            let bytes: Vec<u8> = samples.iter().map(|s| *s as u8).collect();
            between(&bytes, fraction, coding).map(f64::from)
        } else {
            let words: Vec<u16> = samples.iter().map(|s| *s as u16).collect();
            between(&words, fraction, coding).map(f64::from)
        };
        for k in 0..4 {
            // A dark sample of the curve is a hundredth of full light for a thousandth of it.
            assert!((f64::from(value[k]) - expected[k] / full).abs() < 1e-6, "{case} {value:?}");
            let tolerance = 0.03;
            let to_half = ((expected[k] - 0.5).rem_euclid(1.0) - 1.0).abs();
            let near_half = to_half.min(1.0 - to_half) < tolerance;
            if !near_half {
                assert_eq!(made[k], (expected[k] + 0.5).floor().min(full), "{case} {made:?}");
                rounded += 1;
            }
        }
    }
    assert!(rounded > 1700, "{rounded}");
}

#[test]
fn every_sample_comes_back_as_itself() {
    let bytes: Vec<u8> = (0..=255).collect();
    let words: Vec<u16> = (0..=65_535).collect();
    for light in [Light::Linear, Light::Srgb] {
        let coding = Coding { light, alpha: Alpha::None };
        let mut made = vec![9; 256];
        let mut target = ImageViewMut::<u8, 1>::new(&mut made, 256, 1).unwrap();
        let view = ImageView::<u8, 1>::new(&bytes, 256, 1).unwrap();
        let border = Border::Transparent;
        warp_by_light(view, &shifted(0.0), Filter::Lanczos3, border, coding, &mut target).unwrap();
        assert_eq!(made, bytes);
        let mut made = vec![9; 65_536];
        let mut target = ImageViewMut::<u16, 1>::new(&mut made, 65_536, 1).unwrap();
        let view = ImageView::<u16, 1>::new(&words, 65_536, 1).unwrap();
        warp_by_light(view, &shifted(0.0), Filter::Nearest, border, coding, &mut target).unwrap();
        assert_eq!(made, words);
    }
    // Of each opacity, colours that need not be there where nothing is opaque.
    let pixels: Vec<u8> =
        (1..=255).flat_map(|alpha| [200, 255, 1, alpha, 0, 77, 128, alpha]).collect();
    for light in [Light::Linear, Light::Srgb] {
        let coding = Coding { light, alpha: Alpha::Straight };
        let view = ImageView::<u8, 4>::new(&pixels, 510, 1).unwrap();
        let mut made = vec![9; pixels.len()];
        let mut target = ImageViewMut::<u8, 4>::new(&mut made, 510, 1).unwrap();
        let border = Border::Transparent;
        warp_by_light(view, &shifted(0.0), Filter::Bilinear, border, coding, &mut target).unwrap();
        assert_eq!(made, pixels);
    }
}

#[test]
fn what_is_not_painted_stays_and_constants_are_pixels_like_others() {
    let source = [10u8, 20, 30, 0, 40, 50, 60, 255];
    let view = ImageView::<u8, 4>::new(&source, 2, 1).unwrap();
    let coding = Coding { light: Light::Srgb, alpha: Alpha::Straight };
    let mut pixels = [1, 2, 3, 0, 5, 6, 7, 8, 9, 9, 9, 9];
    let mut target = ImageViewMut::<u8, 4>::new(&mut pixels, 3, 1).unwrap();
    let right = shifted(1.0);
    warp_by_light(view, &right, Filter::Nearest, Border::Transparent, coding, &mut target).unwrap();
    assert_eq!(pixels, [40, 50, 60, 255, 5, 6, 7, 8, 9, 9, 9, 9]);
    let mut target = ImageViewMut::<u8, 4>::new(&mut pixels, 3, 1).unwrap();
    let border = Border::Constant([90.0, 100.0, 110.0, 120.0]);
    warp_by_light(view, &right, Filter::Nearest, border, coding, &mut target).unwrap();
    assert_eq!(pixels, [40, 50, 60, 255, 90, 100, 110, 120, 90, 100, 110, 120]);
}

#[test]
fn opacity_needs_a_channel_of_its_own_and_empty_pictures_paint_nothing() {
    let coding = Coding { light: Light::Linear, alpha: Alpha::Straight };
    let view = ImageView::<u8, 3>::new(&[1, 2, 3], 1, 1).unwrap();
    let mut pixel = [7; 3];
    let mut target = ImageViewMut::<u8, 3>::new(&mut pixel, 1, 1).unwrap();
    let error =
        warp_by_light(view, &shifted(0.0), Filter::Nearest, Border::Clamp, coding, &mut target)
            .unwrap_err();
    assert_eq!(error.to_string(), "channels of a picture with opacity is 3, expected 2 or 4");
    let empty = ImageView::<u8, 2>::new(&[], 0, 0).unwrap();
    let mut pixel = [7; 2];
    let mut target = ImageViewMut::<u8, 2>::new(&mut pixel, 1, 1).unwrap();
    let border = Border::Constant([0.0; 4]);
    warp_by_light(empty, &shifted(0.0), Filter::Nearest, border, coding, &mut target).unwrap();
    assert_eq!(pixel, [7; 2]);
    let mut nothing = ImageViewMut::<u8, 2>::new(&mut [], 0, 0).unwrap();
    let view = ImageView::<u8, 2>::new(&[1, 2], 1, 1).unwrap();
    warp_by_light(view, &shifted(0.0), Filter::Nearest, border, coding, &mut nothing).unwrap();
}

proptest! {
    #[test]
    fn plain_samples_are_warped_as_they_stand(
        source in proptest::collection::vec(any::<u8>(), 6 * 5 * 2), by in -4.0..4.0f64, k in 0..6usize,
    ) {
        let (light, alpha) = CODINGS[k];
        let coding = Coding { light, alpha };
        let view = ImageView::<u8, 2>::new(&source, 6, 5).unwrap();
        let painted = |f: &dyn Fn(&mut ImageViewMut<'_, u8, 2>)| {
            let mut pixels = vec![5; 7 * 5 * 2];
            f(&mut ImageViewMut::<u8, 2>::new(&mut pixels, 7, 5).unwrap());
            pixels
        };
        let border = Border::Transparent;
        let plain = painted(&|t| warp(view, &shifted(by), Filter::Bilinear, border, t));
        let by_light = painted(&|t| {
            warp_by_light(view, &shifted(by), Filter::Bilinear, border, coding, t).unwrap();
        });
        for (p, l) in plain.chunks(2).zip(by_light.chunks(2)) {
            // Opacity has no curve and is weighed as it stands.
            if alpha != Alpha::None {
                prop_assert!(p[1].abs_diff(l[1]) <= 1);
            }
            if light == Light::Linear && alpha != Alpha::Straight {
                prop_assert_eq!(p, l);
            }
        }
    }
}
