//! Laws of spans: hyperbolic interpolation, its approximations, lines of constant depth.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use collinear::mapping::span::{Approximation, ConstantDepthLines, Degree, Span, SpanEnd};
use collinear::{Error, ProjectionError};
use proptest::prelude::*;

const U: f64 = 0.5 * f64::EPSILON;

/// A span with integer coefficients, whose values are ratios of 128-bit integers.
#[derive(Clone, Copy, Debug)]
struct Integers {
    numerator: [i128; 2],
    denominator: [i128; 2],
}

impl Integers {
    fn span(&self) -> Span<1> {
        let float = |c: [i128; 2]| c.map(|v| v as f64);
        Span::new([float(self.numerator)], float(self.denominator)).unwrap()
    }

    fn at(&self, x: i32) -> (i128, i128) {
        let form = |[a, b]: [i128; 2]| a + b * i128::from(x);
        (form(self.numerator), form(self.denominator))
    }

    /// (value − n/d) · d / ulp(value) as an exact fraction of d, in ulps; value is not zero.
    fn ulps(&self, x: i32, value: f64) -> f64 {
        let (n, d) = self.at(x);
        if value == 0.0 || n == 0 {
            return if n == 0 && value == 0.0 { 0.0 } else { f64::INFINITY };
        }
        let bits = value.to_bits();
        let exponent = ((bits >> 52) & 0x7ff) as i32 - 1075;
        let mut mantissa = i128::from((bits & ((1 << 52) - 1)) | (1 << 52));
        if value < 0.0 {
            mantissa = -mantissa;
        }
        // value = mantissa · 2^exponent; the product with d and n scaled alike stay below 2¹²⁷.
        let (left, right) = if exponent <= 0 {
            (mantissa * d, n.checked_shl(exponent.unsigned_abs()).unwrap())
        } else {
            ((mantissa * d) << exponent, n)
        };
        let unit = if exponent > 0 { 1i128 << exponent } else { 1 };
        (left - right).abs() as f64 / (d.abs() as f64 * unit as f64)
    }

    /// |value − n/d| as a float; the difference is formed exactly.
    fn error(&self, x: i32, value: f64) -> f64 {
        let unit =
            f64::from_bits((value.abs().to_bits() & (0x7ff << 52)).max(53 << 52)) * f64::EPSILON;
        if value == 0.0 {
            self.at(x).0.abs() as f64 / self.at(x).1.abs() as f64
        } else {
            self.ulps(x, value) * unit
        }
    }
}

/// Coefficients with full mantissas and with heavy cancellation near one pixel.
fn integers() -> impl Strategy<Value = Integers> {
    let coefficient = || prop_oneof![-(1i64 << 51)..(1i64 << 51), -5_000_000_000i64..5_000_000_000];
    let offset = prop_oneof![-(1i64 << 52)..(1i64 << 52), -1000i64..1000];
    (coefficient(), coefficient(), 0..70_000i64, 0..70_000i64, offset.clone(), offset).prop_map(
        |(b, d, xn, xd, on, od)| {
            // The forms vanish near the pixels xn and xd: a = −b xn + on. Bits beyond 53 are cut off.
            let fit = |v: i128| (v as f64) as i128;
            Integers {
                numerator: [fit(-i128::from(b) * i128::from(xn) + i128::from(on)), i128::from(b)],
                denominator: [fit(-i128::from(d) * i128::from(xd) + i128::from(od)), i128::from(d)],
            }
        },
    )
}

fn collect<const N: usize>(
    run: impl FnOnce(&mut dyn FnMut(i32, [&[f64]; N])),
) -> Vec<(i32, [f64; N])> {
    let mut all = Vec::new();
    run(&mut |x, values| {
        assert!((1..=64).contains(&values[0].len()));
        for i in 0..values[0].len() {
            all.push((x + i as i32, values.map(|v| v[i])));
        }
    });
    assert!(all.windows(2).all(|w| w[0].0 + 1 == w[1].0));
    all
}

fn exact<const N: usize>(span: &Span<N>, range: std::ops::Range<i32>) -> Vec<(i32, [f64; N])> {
    collect(|emit| span.exact(range, emit))
}

fn walked<const N: usize>(span: &Span<N>, range: std::ops::Range<i32>) -> Vec<(i32, [f64; N])> {
    collect(|emit| span.walk(range, emit))
}

proptest! {
    #[test]
    fn a_hyperbolic_span_equals_the_exact_rational_value_at_every_pixel_within_4_ulp(
        c in integers(),
        start in 0..69_000i32,
    ) {
        prop_assume!(c.denominator != [0, 0]);
        let span = c.span();
        for (x, [u]) in exact(&span, start..start + 300) {
            prop_assert!(c.ulps(x, u) <= 4.0, "{} ulp at {x}", c.ulps(x, u));
            prop_assert_eq!(span.at(x), Ok([u]));
        }
    }

    #[test]
    fn the_valid_interval_is_where_the_exact_denominator_is_positive(
        c in integers(),
        start in -100..70_000i32,
        length in 0..400i32,
    ) {
        prop_assume!(c.denominator != [0, 0]);
        let span = c.span();
        // Around the horizon too, where the test is hardest.
        let horizon = (-c.denominator[0] as f64 / c.denominator[1] as f64) as i32;
        for range in [start..start + length, horizon.saturating_sub(5).clamp(-90_000, 90_000)..horizon.saturating_add(5).clamp(-90_000, 90_000)] {
            let valid = span.valid_interval(range.clone());
            for x in range {
                let positive = c.at(x).1 > 0;
                prop_assert_eq!(valid.contains(&x), positive, "{}", x);
                match span.at(x) {
                    Ok(_) => prop_assert!(positive),
                    Err(ProjectionError::BehindCamera { depth }) => prop_assert!(!positive && depth <= 0.0),
                    Err(other) => prop_assert!(false, "{:?}", other),
                }
            }
        }
    }

    #[test]
    fn walked_values_stay_within_the_bound(c in integers(), start in 0..69_000i32, length in 1..600i32) {
        prop_assume!(c.denominator != [0, 0]);
        let span = c.span();
        let range = start..start + length;
        let [bound] = span.walk_bound(range.clone());
        for (x, [u]) in walked(&span, range) {
            prop_assert!(c.error(x, u) <= bound, "{} > {bound} at {x}", c.error(x, u));
        }
        // Up to the horizon itself: blocks in which w changes much are not walked.
        prop_assert!(bound.is_finite());
    }

    #[test]
    fn cutting_a_span_anywhere_changes_no_bit(c in integers(), start in 0..69_000i32, cut in 1..299i32, run in 1..100u32) {
        prop_assume!(c.denominator != [0, 0]);
        let span = c.span();
        let (left, right) = (start..start + cut, start + cut..start + 300);
        let whole = start..start + 300;
        let pieces = |f: &dyn Fn(std::ops::Range<i32>) -> Vec<(i32, [f64; 1])>| {
            let mut both = f(left.clone());
            both.extend(f(right.clone()));
            (f(whole.clone()), both)
        };
        let bits = |v: Vec<(i32, [f64; 1])>| v.into_iter().map(|(x, [u])| (x, u.to_bits())).collect::<Vec<_>>();
        let (a, b) = pieces(&|r| walked(&span, r));
        prop_assert_eq!(bits(a), bits(b));
        let (a, b) = pieces(&|r| exact(&span, r));
        prop_assert_eq!(bits(a), bits(b));
        for degree in [Degree::Affine, Degree::Quadratic, Degree::Cubic] {
            let approximation = Approximation::new(degree, run).unwrap();
            let (a, b) = pieces(&|r| collect(|emit| approximation.walk(&span, r, emit)));
            prop_assert_eq!(bits(a), bits(b));
        }
    }

    #[test]
    fn a_tolerance_in_texels_is_kept(
        w0 in 0.5..20.0f64, w1 in 0.5..20.0f64, u0 in -3000.0..3000.0f64, u1 in -3000.0..3000.0f64,
        start in 0..60_000i32, length in 2..700i32, tolerance in 1e-4..1.0f64,
    ) {
        let (x0, x1) = (f64::from(start), f64::from(start + length));
        let span = Span::between(
            &SpanEnd::attributes(x0, w0, [u0]),
            &SpanEnd::attributes(x1, w1, [u1]),
        ).unwrap();
        let range = start..start + length;
        let truth = exact(&span, range.clone());
        for degree in [Degree::Affine, Degree::Quadratic, Degree::Cubic] {
            let a = Approximation::for_tolerance(&span, range.clone(), tolerance, degree);
            let [bound] = a.error_bound(&span, range.clone());
            let approximate = collect(|emit| a.walk(&span, range.clone(), emit));
            prop_assert_eq!(approximate.len(), truth.len());
            for ((x, [u]), (_, [t])) in approximate.iter().zip(&truth) {
                prop_assert!((u - t).abs() <= bound + 1e-12, "{degree:?} at {x}: {} > {bound}", (u - t).abs());
            }
            prop_assert!(bound <= tolerance || a.run() == 1);
            // The next longer run would not do.
            if a.run() < Approximation::MAX_RUN {
                let longer = Approximation::new(degree, 2 * a.run()).unwrap();
                let ends = [start, start + length - 1].map(|x| {
                    let run = 2 * a.run() as i32;
                    let first = x.div_euclid(run) * run;
                    span.at(first).is_ok() && span.at(first + run).is_ok()
                });
                let [error] = longer.error_bound(&span, range.clone());
                prop_assert!(error > tolerance || ends != [true; 2]);
            }
        }
    }

    #[test]
    fn no_coefficients_make_it_panic(
        c in proptest::array::uniform4(prop_oneof![
            Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(1e200), Just(-1e200), Just(1e-200), Just(1e300),
            Just(5e-324), -10.0..10.0f64, proptest::num::f64::ANY,
        ]),
        x in proptest::num::i32::ANY,
        length in -10..200i32,
    ) {
        let range = x..x.saturating_add(length);
        if let Ok(span) = Span::new([[c[0], c[1]]], [c[2], c[3]]) {
            let valid = span.valid_interval(range.clone());
            prop_assert!(valid.start <= valid.end);
            let _ = (span.at(x), span.walk_bound(range.clone()), span.drift_bound(range.clone(), 7));
            let count = exact(&span, range.clone()).len();
            prop_assert_eq!(count, valid.len());
            prop_assert_eq!(walked(&span, range.clone()).len(), count);
            let a = Approximation::for_tolerance(&span, range.clone(), c[0], Degree::Cubic);
            prop_assert_eq!(collect(|emit| a.walk(&span, range.clone(), emit)).len(), count);
        } else {
            prop_assert!(c.iter().any(|v| !v.is_finite() || v.abs() > 1e240 || (*v != 0.0 && v.abs() < 1e-240)) || c[2..] == [0.0; 2]);
        }
        let _ = Span::between(&SpanEnd::light(c[0], c[1], [c[2]], c[3]), &SpanEnd::attributes(c[3], c[2], [c[1]]));
        if let Ok(lines) = ConstantDepthLines::new([[c[0], c[1], c[2]]], [c[3], c[0], c[1]]) {
            let rows = -3..x.clamp(-3, 20);
            lines.walk(rows.clone(), range.start..range.start.saturating_add(length.min(20)), |_, _, _| ());
            let _ = lines.error_bound(rows, range);
        }
    }

    #[test]
    fn lines_of_constant_depth_visit_every_pixel_in_front_once_within_the_bound(
        r in proptest::array::uniform3(-2.0..2.0f64),
        p in proptest::array::uniform3(-50.0..50.0f64),
        x0 in -500..70_000i32, y0 in -500..70_000i32, width in 1..60i32, height in 1..60i32,
    ) {
        // The denominator is 40 at the rectangle's middle.
        let (xm, ym) = (f64::from(x0 + width / 2), f64::from(y0 + height / 2));
        let denominator = [40.0 + r[0] - r[1] * xm - r[2] * ym, r[1], r[2]];
        let numerator = [p[0] - p[1] * xm - p[2] * ym, p[1], p[2]];
        let lines = ConstantDepthLines::new([numerator], denominator).unwrap();
        let (columns, rows) = (x0..x0 + width, y0..y0 + height);
        let mut seen = vec![0; (width * height) as usize];
        let [bound] = lines.error_bound(columns.clone(), rows.clone());
        let mut worst = 0.0f64;
        let mut line = None;
        let mut lines_seen = std::collections::HashSet::new();
        lines.walk(columns, rows.clone(), |x, y, [u]| {
            seen[((y - y0) * width + x - x0) as usize] += 1;
            if line != Some(lines.line_of(x, y)) {
                line = Some(lines.line_of(x, y));
                assert!(lines_seen.insert(lines.line_of(x, y)), "line after line");
            }
            let row = Span::on_line([numerator], denominator, y).unwrap();
            if let Ok([t]) = row.at(x) {
                worst = worst.max((u - t).abs());
            }
        });
        for y in rows {
            let row = Span::on_line([numerator], denominator, y).unwrap();
            for x in x0..x0 + width {
                let count = seen[((y - y0) * width + x - x0) as usize];
                prop_assert_eq!(count, i32::from(row.at(x).is_ok()), "pixel {} {}", x, y);
            }
        }
        prop_assert!(worst <= bound, "{worst} > {bound}");
    }

    #[test]
    fn segal_equation_7_with_constant_light_w_is_equation_8(
        x in proptest::array::uniform2(0.0..70_000.0f64), w in proptest::array::uniform2(0.01..100.0f64),
        s in proptest::array::uniform2(-1000.0..1000.0f64), light_w in 0.1..10.0f64, pixel in -100..70_000i32,
    ) {
        prop_assume!(x[0] != x[1]);
        let seven = Span::between(
            &SpanEnd::light(x[0], w[0], [s[0] * light_w], light_w),
            &SpanEnd::light(x[1], w[1], [s[1] * light_w], light_w),
        ).unwrap();
        let eight = Span::between(
            &SpanEnd::attributes(x[0], w[0], [s[0]]),
            &SpanEnd::attributes(x[1], w[1], [s[1]]),
        ).unwrap();
        prop_assert_eq!(seven.at(pixel).is_ok(), eight.at(pixel).is_ok());
        if let (Ok([a]), Ok([b])) = (seven.at(pixel), eight.at(pixel)) {
            // Rounding of the four coefficients, weighed by how much they cancel at this pixel.
            let dx = f64::from(pixel - eight.origin()).abs();
            let [c, d] = eight.denominator();
            let [[n, m]] = eight.numerators();
            let depth = c + d * f64::from(pixel - eight.origin());
            let condition = (n.abs() + m.abs() * dx + b.abs() * (c.abs() + d.abs() * dx)) / depth.abs();
            prop_assert!((a - b).abs() <= 16.0 * f64::EPSILON * condition, "{a} {b}");
        }
    }
}

#[test]
fn light_coordinates_follow_segal_equation_7() {
    // A segment from Q1 (w = 2) to Q2 (w = 5) with light coordinates (1, −2, 4), wˡ = 3 and (7, 5, 2), wˡ = −1. With
    // tˢ = (x + ½ − 10.5) / 32, A = (1 − tˢ) w2, B = tˢ w1 the point is (A Q1ˡ + B Q2ˡ) / (A w1ˡ + B w2ˡ), eq. 4 to 6.
    let span = Span::between(
        &SpanEnd::light(10.5, 2.0, [1.0, -2.0, 4.0], 3.0),
        &SpanEnd::light(42.5, 5.0, [7.0, 5.0, 2.0], -1.0),
    )
    .unwrap();
    // At pixel 26, ts = ½: A = 2.5, B = 1: (9.5, 0, 12) / 6.5.
    let expected = [9.5 / 6.5, 0.0, 12.0 / 6.5];
    for (value, e) in span.at(26).unwrap().iter().zip(expected) {
        assert!((value - e).abs() <= 4.0 * f64::EPSILON, "{value} {e}");
    }
    // The light's w is 15 (1 − ts) − 2 ts in scale: zero at ts = 15/17, x = 10 + 28.23.
    assert_eq!(span.valid_interval(0..100), 0..39);
    assert!(matches!(span.at(39), Err(ProjectionError::BehindCamera { depth }) if depth < 0.0));
}

#[test]
fn ends_behind_the_eye_are_refused() {
    let good = SpanEnd::attributes(0.5, 1.0, [1.0]);
    for w in [0.0, -1.0] {
        let refused = Span::between(&good, &SpanEnd::attributes(9.5, w, [2.0])).unwrap_err();
        assert!(matches!(refused, Error::OutOfRange { what: "w of a span end", .. }), "{refused}");
    }
    let same = Span::between(&good, &SpanEnd::attributes(0.5, 2.0, [2.0])).unwrap_err();
    assert!(matches!(same, Error::Degenerate { .. }));
    // In either order of the ends.
    let other = SpanEnd::attributes(9.5, 3.0, [2.0]);
    assert_eq!(Span::between(&good, &other), Span::between(&other, &good));
}

#[test]
fn linear_interpolation_between_cut_ends_moves_texels_where_the_span_does_not() {
    // A floor from w = 1 to w = 9 over 256 pixels, 1000 texels long. Cut at pixel 100.
    let span = Span::between(
        &SpanEnd::attributes(0.5, 1.0, [0.0]),
        &SpanEnd::attributes(256.5, 9.0, [1000.0]),
    )
    .unwrap();
    let linear = |from: i32, to: i32, x: i32| {
        let [a] = span.at(from).unwrap();
        let [b] = span.at(to).unwrap();
        a + (b - a) * f64::from(x - from) / f64::from(to - from)
    };
    let worst = (0..100).map(|x| (linear(0, 256, x) - linear(0, 100, x)).abs()).fold(0.0, f64::max);
    assert!(worst > 100.0, "the cut moves linear interpolation by {worst} texels");
    let (whole, mut pieces) = (walked(&span, 0..256), walked(&span, 0..100));
    pieces.extend(walked(&span, 100..256));
    assert_eq!(whole, pieces);
}

#[test]
fn a_cut_span_from_new_ends_is_the_same_curve() {
    // New vertices on the chord carry their own w and attributes (linear in space); the coefficients round anew.
    let (s, w) = ([100.0, 900.0], [2.0, 7.0]);
    let whole = Span::between(
        &SpanEnd::attributes(69_000.25, w[0], [s[0]]),
        &SpanEnd::attributes(69_400.75, w[1], [s[1]]),
    )
    .unwrap();
    let t = 0.375;
    let at = |v: [f64; 2]| v[0] + t * (v[1] - v[0]);
    // The screen position of the point at t: weights A = a w2, B = b w1 of [S] eq. 4 turned round.
    let share = t * w[1] / ((1.0 - t) * w[0] + t * w[1]);
    let x = 69_000.25 + share * 400.5;
    let piece = Span::between(
        &SpanEnd::attributes(x, at(w), [at(s)]),
        &SpanEnd::attributes(69_400.75, w[1], [s[1]]),
    )
    .unwrap();
    for pixel in x as i32..69_400 {
        let ([a], [b]) = (whole.at(pixel).unwrap(), piece.at(pixel).unwrap());
        assert!((a - b).abs() < 1e-10, "{pixel}: {}", a - b);
    }
}

#[test]
fn drift_over_16384_pixels_obeys_the_bound_and_anchors_take_it_away() {
    // Full-mantissa coefficients, so that every addition rounds.
    let c = Integers {
        numerator: [1_234_567_890_123_457, 3_002_399_751_580_331],
        denominator: [4_503_599_627_370_497, 1_501_199_875_791],
    };
    let span = c.span();
    let range = 1000..1000 + 16_384;
    let free = collect(|emit| span.walk_unanchored(range.clone(), emit));
    assert_eq!(free.len(), 16_384);
    let worst =
        |row: &[(i32, [f64; 1])]| row.iter().map(|(x, [u])| c.error(*x, *u)).fold(0.0, f64::max);
    let drifted = worst(&free);
    let [bound] = span.drift_bound(range.clone(), 16_383);
    assert!(drifted <= bound, "{drifted} {bound}");
    // At every pixel, with as many additions as led there.
    for (i, (x, [u])) in free.iter().enumerate() {
        let [b] = span.drift_bound(range.start..x + 1, i as u32);
        assert!(c.error(*x, *u) <= b, "{x}");
    }
    let anchored = worst(&walked(&span, range.clone()));
    assert!(anchored <= span.walk_bound(range)[0]);
    assert!(anchored * 50.0 < drifted, "anchored {anchored:e}, free {drifted:e}, bound {bound:e}");
    println!("free {drifted:e} of {bound:e}; anchored {anchored:e}");
}

/// The largest |p − u| over all pixels of whole runs, and the bound.
fn share_of_bound(degree: Degree, run: u32, c: &Integers, range: std::ops::Range<i32>) -> f64 {
    let span = c.span();
    let a = Approximation::new(degree, run).unwrap();
    let [bound] = a.error_bound(&span, range.clone());
    let worst = collect(|emit| a.walk(&span, range, emit))
        .iter()
        .map(|(x, [u])| c.error(*x, *u))
        .fold(0.0, f64::max);
    assert!(worst <= bound, "{degree:?}: {worst} > {bound}");
    worst / bound
}

#[test]
fn the_error_of_runs_reaches_the_stated_share_of_its_bound() {
    // w from 2000 to 976 over 1024 pixels; β = D/d large, so rounding does not show.
    let c = Integers { numerator: [5, 3_000_001], denominator: [2000, -1] };
    // The affine maximum is exact between pixels; the nearest pixel of 128 misses it by less than 1e-3.
    for run in [64, 128, 256, 512] {
        let share = share_of_bound(Degree::Affine, run, &c, 0..1024);
        assert!(share > 0.999 && share <= 1.0, "{run}: {share}");
    }
    for run in [64, 128, 256, 512] {
        let w = (976.0, 976.0 + f64::from(run));
        let ratio = w.1 / w.0;
        for (degree, lies) in [(Degree::Quadratic, 0.2114), (Degree::Cubic, 0.1274)] {
            let share = share_of_bound(degree, run, &c, 0..1024);
            let stated = 1.0 / (1.0 + lies * (ratio - 1.0));
            // 0.995: the maximum lies between two pixels.
            assert!(share > 0.995 * stated, "{degree:?} {run}: {share} < {stated}");
        }
    }
    // A rising denominator, and runs that are not powers of two.
    let c = Integers { numerator: [70_000_001, -30_001], denominator: [300, 1] };
    for run in [30, 90, 300] {
        assert!(share_of_bound(Degree::Affine, run, &c, 0..900) > 0.99);
        assert!(share_of_bound(Degree::Quadratic, run, &c, 0..900) > 0.8);
        assert!(share_of_bound(Degree::Cubic, run, &c, 0..900) > 0.85);
    }
}

#[test]
fn runs_at_the_horizon_are_exact() {
    // The horizon at pixel 100: the run from 96 cannot be interpolated.
    let c = Integers { numerator: [3, 7], denominator: [-100, 1] };
    let span = c.span();
    let a = Approximation::new(Degree::Cubic, 16).unwrap();
    let row = collect(|emit| a.walk(&span, 0..200, emit));
    assert_eq!(row[0].0, 101);
    for (x, [u]) in &row[..11] {
        assert_eq!(span.at(*x), Ok([*u]));
    }
    // A long run would be exact all along, and slow: that is not an approximation within the tolerance.
    assert_eq!(Approximation::for_tolerance(&span, 0..200, 0.1, Degree::Cubic).run(), 1);
}

#[test]
fn blocks_that_come_near_the_horizon_are_not_walked() {
    // w = 1 at pixel 64 and 63 001 at pixel 127; 64 001 to 127 001 in the next block.
    let c = Integers {
        numerator: [1_234_567_890_123_457, 3_002_399_751_580_331],
        denominator: [-63_999, 1000],
    };
    let span = c.span();
    assert_eq!(walked(&span, 0..128), exact(&span, 0..128));
    assert_ne!(walked(&span, 128..192), exact(&span, 128..192));
}

#[test]
fn a_bound_of_constant_depth_lines_is_reached() {
    // A tilted horizon; the error in one pixel row reaches half a pixel times the slope of u.
    let (numerator, denominator) = ([0.0, 10.0, 300.0], [500.0, 0.3, 0.7]);
    let lines = ConstantDepthLines::new([numerator], denominator).unwrap();
    assert!(lines.is_along_rows());
    let (columns, rows) = (0..200, 0..3);
    let [bound] = lines.error_bound(columns.clone(), rows.clone());
    let mut worst = 0.0f64;
    lines.walk(columns, rows, |x, y, [u]| {
        let [t] = Span::on_line([numerator], denominator, y).unwrap().at(x).unwrap();
        worst = worst.max((u - t).abs());
    });
    assert!(worst <= bound && worst > 0.85 * bound, "{worst} of {bound}");
    // A horizon along an axis: exact.
    for denominator in [[500.0, 0.0, 0.7], [500.0, 0.7, 0.0], [500.0, 0.0, 0.0]] {
        let lines = ConstantDepthLines::new([numerator], denominator).unwrap();
        lines.walk(0..50, 0..50, |x, y, [u]| {
            let [t] = Span::on_line([numerator], denominator, y).unwrap().at(x).unwrap();
            assert!((u - t).abs() <= 8.0 * U * (t.abs() + 40.0), "{x} {y}: {u} {t}");
        });
    }
}

#[test]
fn far_pixels_keep_their_digits() {
    // A 65,536-pixel panorama at x near 70,000: the exact rational value, where naive evaluation of the same
    // coefficients loses eight digits next to the numerator's zero.
    let c = Integers {
        numerator: [-70_000 * 100_000_000_003 + 1, 100_000_000_003],
        denominator: [7_777_777, 3],
    };
    let span = c.span();
    let [u] = span.at(70_000).unwrap();
    assert!(c.ulps(70_000, u) <= 4.0);
    assert_eq!(c.at(70_000).0, 1);
}
