//! Filters, borders, strides and channels against SciPy and against tables by hand.

use collinear::Error;
use collinear::geometry::Affine2;
use collinear::mapping::{FractionalLinear, Map};
use collinear::nalgebra::Point2;
use collinear::resample::{Border, Filter, ImageView, ImageViewMut, Sample, sample, warp};
use proptest::prelude::*;
use serde_json::Value;

use crate::support::{BORDERS, numbers};

const FILTERS: [Filter; 2] = [Filter::Nearest, Filter::Bilinear];

fn at(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x, y)
}

/// u = x + a, v = y + b.
fn shift(a: f64, b: f64) -> Affine2 {
    Affine2::from_coefficients([a, 1.0, 0.0], [b, 0.0, 1.0])
}

#[test]
fn every_border_and_filter_is_scipys() {
    // tests/data/oracles/resample.py: scipy 1.17.1, ndimage.map_coordinates. All weights are multiples of 1/8, so both
    // programs are exact.
    let oracle: Value =
        serde_json::from_str(include_str!("../data/oracles/resample.json")).unwrap();
    let (u, v) = (numbers(&oracle["u"]), numbers(&oracle["v"]));
    let mut compared = 0;
    for picture in oracle["pictures"].as_array().unwrap() {
        let samples: Vec<f32> = numbers(&picture["samples"]).iter().map(|&s| s as f32).collect();
        let bytes: Vec<u8> = samples.iter().map(|&s| s as u8).collect();
        let width = picture["width"].as_u64().unwrap() as usize;
        let height = samples.len() / width;
        let floats = ImageView::<f32, 1>::new(&samples, width, height).unwrap();
        let bytes = ImageView::<u8, 1>::new(&bytes, width, height).unwrap();
        let expect =
            |border: &str, filter: &str| numbers(&picture["values"][format!("{border} {filter}")]);
        for (filter, filter_name) in [(Filter::Nearest, "nearest"), (Filter::Bilinear, "bilinear")]
        {
            for (border, name) in [
                (BORDERS[1], "constant"),
                (Border::Clamp, "clamp"),
                (Border::Repeat, "repeat"),
                (Border::Mirror, "mirror"),
                (Border::Transparent, "clamp"),
            ] {
                for ((&u, &v), e) in u.iter().zip(&v).zip(expect(name, filter_name)) {
                    let inside = u >= 0.0 && u < width as f64 && v >= 0.0 && v < height as f64;
                    let expected = (border != Border::Transparent || inside).then_some(e);
                    let got = sample(floats, &at(u, v), filter, border);
                    assert_eq!(got, expected.map(|e| [e as f32]), "{name} {filter_name} {u} {v}");
                    let got = sample(bytes, &at(u, v), filter, border);
                    let rounded = expected.map(|e| [(e + 0.5).floor() as u8]);
                    assert_eq!(got, rounded, "{name} {filter_name} {u} {v}");
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, 3 * 2 * 5 * 20);
}

#[test]
fn borders_by_hand() {
    // One row of three: which texel is read at i = −7 … 6.
    let row = [1.0f32, 2.0, 3.0];
    let view = ImageView::<f32, 1>::new(&row, 3, 1).unwrap();
    let tables: [(Border, [f32; 14]); 4] = [
        (BORDERS[1], [40., 40., 40., 40., 40., 40., 40., 1., 2., 3., 40., 40., 40., 40.]),
        (Border::Clamp, [1., 1., 1., 1., 1., 1., 1., 1., 2., 3., 3., 3., 3., 3.]),
        (Border::Repeat, [3., 1., 2., 3., 1., 2., 3., 1., 2., 3., 1., 2., 3., 1.]),
        (Border::Mirror, [1., 1., 2., 3., 3., 2., 1., 1., 2., 3., 3., 2., 1., 1.]),
    ];
    for (border, table) in tables {
        for (k, e) in table.into_iter().enumerate() {
            let x = k as f64 - 7.0;
            for (filter, inset) in
                [(Filter::Nearest, 0.0), (Filter::Nearest, 0.984_375), (Filter::Bilinear, 0.5)]
            {
                let got = sample(view, &at(x + inset, 0.5), filter, border);
                assert_eq!(got, Some([e]), "{border:?} {filter:?} {x}");
            }
        }
    }
    // Halfway between two centres stands their mean, with the border's value beyond the edge.
    for (border, before, after) in [
        (BORDERS[1], 20.5, 21.5),
        (Border::Clamp, 1.0, 3.0),
        (Border::Repeat, 2.0, 2.0),
        (Border::Mirror, 1.0, 3.0),
        (Border::Transparent, 1.0, 3.0),
    ] {
        assert_eq!(sample(view, &at(0.0, 0.5), Filter::Bilinear, border), Some([before]));
        let end = sample(view, &at(3.0, 0.5), Filter::Bilinear, border);
        assert_eq!(end, (border != Border::Transparent).then_some([after]), "{border:?}");
    }
}

#[test]
fn nothing_is_found_at_no_number_and_in_no_picture() {
    let empty = ImageView::<u8, 3>::new(&[], 0, 0).unwrap();
    let flat = ImageView::<u8, 3>::new(&[], 5, 0).unwrap();
    let one = ImageView::<u8, 3>::new(&[1, 2, 3], 1, 1).unwrap();
    for border in BORDERS {
        for filter in FILTERS {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, -1e200, 1_073_741_825.0]
            {
                assert_eq!(sample(one, &at(bad, 0.5), filter, border), None);
                assert_eq!(sample(one, &at(0.5, bad), filter, border), None);
            }
            assert_eq!(sample(empty, &at(0.5, 0.5), filter, border), None);
            assert_eq!(sample(flat, &at(0.5, 0.5), filter, border), None);
            assert_eq!(sample(one, &at(0.5, 0.5), filter, border), Some([1, 2, 3]));
            assert!(sample(one, &at(1e-200, 1e-200), filter, border).is_some());
        }
    }
}

#[test]
fn far_positions_are_read_as_near_ones() {
    // Repeated every 3 × 2 texels, mirrored every 6 × 4: shifts by multiples of those, up to the largest coordinate.
    let texels = [10.0f32, 90.0, 200.0, 250.0, 0.0, 33.0];
    let view = ImageView::<f32, 1>::new(&texels, 3, 2).unwrap();
    for filter in FILTERS {
        for (u, v) in [(0.25, 0.5), (2.875, 1.75), (1.5, 1.0), (0.0, 0.0)] {
            for k in [1.0, -1.0, 1000.0, -1001.0, 178_956_969.0, -178_956_969.0] {
                for (border, periods) in
                    [(Border::Repeat, [3.0, 2.0]), (Border::Mirror, [6.0, 4.0])]
                {
                    let near = sample(view, &at(u, v), filter, border);
                    let far =
                        sample(view, &at(u + k * periods[0], v - k * periods[1]), filter, border);
                    assert_eq!(near, far, "{border:?} {filter:?} {u} {v} {k}");
                }
            }
        }
        let limit = 1_073_741_824.0;
        assert_eq!(sample(view, &at(limit, limit), filter, Border::Clamp), Some([33.0]));
        assert_eq!(sample(view, &at(-limit, -limit), filter, Border::Clamp), Some([10.0]));
        assert_eq!(sample(view, &at(-limit, limit), filter, Border::Transparent), None);
    }
}

/// Texel (x, y), channel k, of a picture where every sample is another number.
fn code<T: Sample>(x: usize, y: usize, k: usize) -> T {
    T::from_f32((1 + k + 4 * x + 30 * y) as f32)
}

fn strides<T: Sample, const C: usize>(hole: T) {
    let (width, height) = (5, 4);
    for padding in [0, 1, 7] {
        let stride = width * C + padding;
        // The last row needs no padding behind it.
        let mut data = vec![hole; stride * (height - 1) + width * C];
        for y in 0..height {
            for x in 0..width {
                for k in 0..C {
                    data[y * stride + x * C + k] = code(x, y, k);
                }
            }
        }
        let view = ImageView::<T, C>::with_stride(&data, width, height, stride).unwrap();
        assert_eq!((view.width(), view.height()), (width, height));
        let expected = |x: usize, y: usize| core::array::from_fn(|k| code(x, y, k));
        for filter in FILTERS {
            for y in 0..height {
                for x in 0..width {
                    let position = at(x as f64 + 0.5, y as f64 + 0.5);
                    assert_eq!(
                        sample(view, &position, filter, Border::Transparent),
                        Some(expected(x, y))
                    );
                }
            }
        }
        assert_eq!(view.pixel(width - 1, height - 1), Some(expected(width - 1, height - 1)));
        assert_eq!(view.pixel(width, 0), None);
        assert_eq!(view.pixel(0, height), None);
        // Bilinear on a ramp in both directions: each channel by itself.
        let between = sample(view, &at(2.25, 1.75), Filter::Bilinear, Border::Clamp).unwrap();
        for (k, value) in between.into_iter().enumerate() {
            // x = 1.75, y = 1.25 counted between centres: 4 · 1.75 + 30 · 1.25 = 44.5, and u8 rounds half up.
            let exact = 1.0 + k as f32 + 44.5;
            assert_eq!(value, T::from_f32(exact));
        }
        // Into a padded target: the padding stays as it was.
        let mut target = vec![hole; stride * height];
        {
            let mut out =
                ImageViewMut::<T, C>::with_stride(&mut target, width, height, stride).unwrap();
            assert_eq!((out.width(), out.height()), (width, height));
            warp(view, &shift(1.0, -1.0), Filter::Nearest, Border::Clamp, &mut out);
            assert_eq!(out.as_view().pixel(0, 1), Some(expected(1, 0)));
            assert_eq!(out.row_mut(height).len(), 0);
            assert_eq!(out.row_mut(0).len(), width * C);
        }
        for y in 0..height {
            for x in 0..width {
                let start = y * stride + x * C;
                assert_eq!(
                    target[start..start + C],
                    expected((x + 1).min(width - 1), y.max(1) - 1),
                    "{x} {y}"
                );
            }
            assert!(target[y * stride + width * C..(y + 1) * stride].iter().all(|v| *v == hole));
        }
        // One sample short, or a stride shorter than a row.
        let short = data.len() - 1;
        assert_eq!(
            ImageView::<T, C>::with_stride(&data[..short], width, height, stride).err(),
            Some(Error::LengthMismatch {
                what: "samples and picture",
                left: short,
                right: data.len()
            })
        );
        assert!(matches!(
            ImageView::<T, C>::with_stride(&data, width, height, width * C - 1),
            Err(Error::LengthMismatch { .. })
        ));
    }
}

#[test]
fn strides_and_channels_keep_their_place() {
    strides::<u8, 1>(255);
    strides::<u8, 2>(255);
    strides::<u8, 3>(255);
    strides::<u8, 4>(255);
    strides::<f32, 1>(f32::NAN.min(-7.0));
    strides::<f32, 2>(-7.0);
    strides::<f32, 3>(-7.0);
    strides::<f32, 4>(-7.0);
}

#[test]
fn pictures_that_are_none_are_refused() {
    let data = [0u8; 64];
    assert!(matches!(ImageView::<u8, 0>::new(&data, 1, 1), Err(Error::OutOfRange { .. })));
    assert!(matches!(ImageView::<u8, 5>::new(&data, 1, 1), Err(Error::OutOfRange { .. })));
    let side = (1 << 30) + 1;
    assert!(matches!(ImageView::<u8, 1>::new(&data, side, 0), Err(Error::OutOfRange { .. })));
    assert!(matches!(ImageView::<u8, 1>::new(&data, 0, side), Err(Error::OutOfRange { .. })));
    for (width, height) in [(usize::MAX, 1), (1 << 30, 1 << 30), (65, 1), (1, 65)] {
        assert!(ImageView::<u8, 4>::new(&data, width, height).is_err());
        assert!(ImageView::<u8, 1>::with_stride(&data, width, height, usize::MAX).is_err());
    }
    assert!(ImageView::<u8, 1>::new(&data, 8, 8).is_ok());
    assert!(ImageView::<u8, 4>::new(&data, 4, 4).is_ok());
    assert!(ImageView::<u8, 4>::new(&data, 17, 1).is_err());
}

#[test]
fn a_picture_ends_at_its_sides_though_its_samples_go_on() {
    // 2 × 2 of 3 × 4 samples.
    let mut data: Vec<u8> = (1..=12).collect();
    let view = ImageView::<u8, 1>::with_stride(&data, 2, 2, 3).unwrap();
    assert_eq!((view.pixel(1, 1), view.pixel(2, 1), view.pixel(1, 2)), (Some([5]), None, None));
    for filter in FILTERS {
        assert_eq!(sample(view, &at(1.5, 2.5), filter, Border::Clamp), Some([5]));
        assert_eq!(sample(view, &at(1.5, 2.5), filter, Border::Transparent), None);
        assert_eq!(sample(view, &at(1.5, 2.5), filter, Border::Constant([77.0; 4])), Some([77]));
    }
    let mut view = ImageViewMut::<u8, 1>::with_stride(&mut data, 2, 2, 3).unwrap();
    assert_eq!((view.row_mut(1).to_vec(), view.row_mut(2).len()), (vec![4, 5], 0));
    // The longest side itself is one.
    assert_eq!(ImageView::<u8, 1>::new(&[], 1 << 30, 0).unwrap().width(), 1 << 30);
    assert_eq!(ImageViewMut::<f32, 4>::new(&mut [], 0, 1 << 30).unwrap().height(), 1 << 30);
}

#[test]
fn bytes_round_half_up_and_saturate() {
    for (value, byte) in [
        (0.0, 0),
        (0.25, 0),
        (0.5, 1),
        (1.5, 2),
        (2.5, 3),
        (254.25, 254),
        (254.5, 255),
        (255.0, 255),
        (300.0, 255),
        (1e30, 255),
        (f32::INFINITY, 255),
        (-0.25, 0),
        (-7.0, 0),
        (f32::NEG_INFINITY, 0),
        (f32::NAN, 0),
    ] {
        assert_eq!(u8::from_f32(value), byte, "{value}");
    }
    assert_eq!(f32::from_f32(-7.25), -7.25);
    assert_eq!(u8::to_f32(200), 200.0);
    // A constant border rounds as samples do and takes the first channels.
    let view = ImageView::<u8, 2>::new(&[0, 0], 1, 1).unwrap();
    let border = Border::Constant([12.5, -3.0, 99.0, 99.0]);
    assert_eq!(sample(view, &at(9.0, 9.0), Filter::Nearest, border), Some([13, 0]));
}

#[test]
fn a_warp_paints_what_its_map_finds() {
    let source = [10u8, 20, 30, 40, 50, 60];
    let view = ImageView::<u8, 1>::new(&source, 3, 2).unwrap();
    let warped = |map: &dyn Map, filter, border| {
        let mut pixels = [7u8; 12];
        warp(
            view,
            map,
            filter,
            border,
            &mut ImageViewMut::<u8, 1>::new(&mut pixels, 4, 3).unwrap(),
        );
        pixels
    };
    let black = Border::Constant([0.0; 4]);
    for filter in FILTERS {
        let same = warped(&shift(0.0, 0.0), filter, Border::Transparent);
        assert_eq!(same, [10, 20, 30, 7, 40, 50, 60, 7, 7, 7, 7, 7]);
        let same = warped(&shift(0.0, 0.0), filter, black);
        assert_eq!(same, [10, 20, 30, 0, 40, 50, 60, 0, 0, 0, 0, 0]);
        // The picture moves against the shift of its coordinates.
        let moved = warped(&shift(-1.0, -1.0), filter, Border::Transparent);
        assert_eq!(moved, [7, 7, 7, 7, 7, 10, 20, 30, 7, 40, 50, 60]);
    }
    // Half a texel to the right and down: means of two and of four.
    let means = warped(&shift(0.5, 0.0), Filter::Bilinear, Border::Clamp);
    assert_eq!(means, [15, 25, 30, 30, 45, 55, 60, 60, 45, 55, 60, 60]);
    let means = warped(&shift(0.5, 0.5), Filter::Bilinear, black);
    assert_eq!(means, [30, 40, 23, 0, 23, 28, 15, 0, 0, 0, 0, 0]);
    // A map that is valid only left of S = 2 (w = 2 − S, u and v as the shift's): the rest has no value.
    let partial = FractionalLinear::from_coefficients(
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [2.0, -1.0, 0.0],
    )
    .unwrap();
    let expected = [10, 20, 0, 0, 40, 50, 0, 0, 0, 0, 0, 0];
    assert_eq!(warped(&partial, Filter::Nearest, black), expected);
    let expected = [10, 20, 7, 7, 40, 50, 7, 7, 40, 50, 7, 7];
    assert_eq!(warped(&partial, Filter::Nearest, Border::Clamp), expected);
    // From a picture without pixels nothing comes, whatever the border; into one nothing goes.
    let empty = [(0, 0), (5, 0), (0, 5)].map(|(w, h)| ImageView::<u8, 1>::new(&[], w, h).unwrap());
    for border in BORDERS {
        for filter in FILTERS {
            for empty in empty {
                let mut pixels = [7u8; 6];
                let mut target = ImageViewMut::<u8, 1>::new(&mut pixels, 3, 2).unwrap();
                warp(empty, &shift(0.0, 0.0), filter, border, &mut target);
                assert_eq!(pixels, [7; 6], "{border:?}");
            }
            warp(
                view,
                &shift(0.0, 0.0),
                filter,
                border,
                &mut ImageViewMut::<u8, 1>::new(&mut [], 0, 0).unwrap(),
            );
        }
    }
}

proptest! {
    #[test]
    fn filters_sum_to_one_and_a_constant_picture_stays_constant(
        value in -1e6..1e6f32, byte in any::<u8>(), width in 1..9usize, height in 1..9usize,
        u in -1e4..1e4f64, v in -1e4..1e4f64,
    ) {
        let (floats, bytes) = (vec![value; width * height], vec![byte; width * height]);
        let floats = ImageView::<f32, 1>::new(&floats, width, height).unwrap();
        let bytes = ImageView::<u8, 1>::new(&bytes, width, height).unwrap();
        for filter in FILTERS {
            for border in [Border::Clamp, Border::Repeat, Border::Mirror, Border::Constant([value; 4])] {
                prop_assert_eq!(sample(floats, &at(u, v), filter, border), Some([value]));
                if !matches!(border, Border::Constant(_)) {
                    prop_assert_eq!(sample(bytes, &at(u, v), filter, border), Some([byte]));
                }
            }
            let inside = at(u.rem_euclid(width as f64), v.rem_euclid(height as f64));
            prop_assert_eq!(sample(floats, &inside, filter, Border::Transparent), Some([value]));
        }
    }

    #[test]
    fn bilinear_reproduces_a_ramp(
        a in -50.0..50.0f64, b in -3.0..3.0f64, c in -3.0..3.0f64, s in 0.0..=1.0f64, t in 0.0..=1.0f64,
        width in 2..40usize, height in 2..40usize,
    ) {
        // Coefficients in 1/64, so that every texel is exact.
        let [a, b, c] = [a, b, c].map(|k| (k * 64.0).round() / 64.0);
        let texels: Vec<f32> = (0..width * height)
            .map(|i| (a + b * ((i % width) as f64 + 0.5) + c * ((i / width) as f64 + 0.5)) as f32)
            .collect();
        let view = ImageView::<f32, 1>::new(&texels, width, height).unwrap();
        // Anywhere between the outermost centres.
        let position = at(0.5 + s * (width - 1) as f64, 0.5 + t * (height - 1) as f64);
        for border in BORDERS {
            let [value] = sample(view, &position, Filter::Bilinear, border).unwrap();
            let exact = a + b * position.x + c * position.y;
            prop_assert!((f64::from(value) - exact).abs() < 1e-4, "{border:?} {value} {exact}");
        }
        // Nearest gives the texel that contains the position.
        let (x, y) = (position.x.floor() as usize, position.y.floor() as usize);
        let nearest = sample(view, &position, Filter::Nearest, Border::Transparent);
        prop_assert_eq!(nearest, view.pixel(x, y));
    }

    #[test]
    fn any_position_has_a_value_or_none(u in any::<f64>(), v in any::<f64>(), k in 0..5usize) {
        let texels: Vec<u8> = (0..36).collect();
        let view = ImageView::<u8, 3>::new(&texels, 4, 3).unwrap();
        for filter in FILTERS {
            let value = sample(view, &at(u, v), filter, BORDERS[k]);
            if !(u.is_finite() && v.is_finite()) {
                prop_assert_eq!(value, None);
            }
        }
    }
}
