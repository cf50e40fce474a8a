//! Ellipsoid, geoid and local frames.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::PathBuf;

use collinear::Error;
use collinear::ProjectionError;
use collinear::geometry::geodetic::{
    Ellipsoid, EllipsoidalHeight, Geodetic, GeoidGrid, GeoidInterpolation, GeoidLayout, LocalFrame,
    OrthometricHeight,
};
use collinear::geometry::{Ray, Surface};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use serde_json::Value;

const WGS84: Ellipsoid = Ellipsoid::WGS84;

fn oracle() -> Value {
    serde_json::from_str(include_str!("../data/oracles/geodetic.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let one = |v: &Value| v.as_f64().unwrap_or_else(|| v.as_str().unwrap().parse().unwrap());
    value.as_array().unwrap().iter().map(one).collect()
}

fn geodetic(latitude: f64, longitude: f64, height: f64) -> Geodetic {
    Geodetic::new(latitude, longitude, EllipsoidalHeight(height)).unwrap()
}

fn point(c: &[f64]) -> Point3<f64> {
    Point3::new(c[0], c[1], c[2])
}

/// The distance between neighbouring floats.
fn ulp(x: f64) -> f64 {
    x.abs().next_up() - x.abs()
}

fn unit_vector() -> impl Strategy<Value = Vector3<f64>> {
    (-1.0..1.0f64, -PI..PI).prop_map(|(z, angle)| {
        let r = (1.0 - z * z).sqrt();
        Vector3::new(r * angle.cos(), r * angle.sin(), z)
    })
}

#[test]
fn the_constants_have_the_published_semi_minor_axes() {
    // Geo::Ellipsoids (CPAN), example-list.pl; WGS 84: NIMA TR 8350.2, table 3.3.
    for (ellipsoid, b, within) in [
        (Ellipsoid::WGS84, 6_356_752.314_2, 5e-5),
        (Ellipsoid::GRS80, 6_356_752.314_140_35, 1e-8),
        (Ellipsoid::AIRY_1830, 6_356_256.909_237_29, 1e-8),
        (Ellipsoid::BESSEL_1841, 6_356_078.962_818_19, 1e-8),
        (Ellipsoid::CLARKE_1866, 6_356_583.8, 1e-8),
        (Ellipsoid::INTERNATIONAL_1924, 6_356_911.946_127_95, 1e-8),
        (Ellipsoid::KRASSOWSKY_1940, 6_356_863.018_773_0, 1e-6),
    ] {
        assert!((ellipsoid.semi_minor_axis() - b).abs() < within, "{ellipsoid:?}");
    }
    // NIMA TR 8350.2, table 3.3: first and second eccentricity squared.
    assert!((WGS84.eccentricity_squared() - 6.694_379_990_14e-3).abs() < 5e-15);
    assert!((WGS84.second_eccentricity_squared() - 6.739_496_742_28e-3).abs() < 5e-15);
}

#[test]
fn the_meridian_radius_integrates_to_the_quadrant() {
    let quadrant: f64 = oracle()["quadrant"].as_str().unwrap().parse().unwrap();
    // Simpson's rule on 200 intervals; the integrand is smooth and even at both ends.
    let n = 200;
    let h = FRAC_PI_2 / f64::from(n);
    let sum: f64 = (0..=n)
        .map(|i| {
            let weight = if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            weight * WGS84.meridian_radius(f64::from(i) * h)
        })
        .sum();
    assert!((sum * h / 3.0 - quadrant).abs() < 1e-7);
    // At the pole both radii are a²/b, on the equator N is a and M is b²/a.
    let (a, b) = (WGS84.semi_major_axis(), WGS84.semi_minor_axis());
    for (value, expected) in [
        (WGS84.prime_vertical_radius(0.0), a),
        (WGS84.meridian_radius(0.0), b * b / a),
        (WGS84.prime_vertical_radius(FRAC_PI_2), a * a / b),
        (WGS84.meridian_radius(-FRAC_PI_2), a * a / b),
    ] {
        assert!((value - expected).abs() < 4e-9, "{value} {expected}");
    }
}

#[test]
fn geodetic_and_geocentric_agree_with_sixty_digits() {
    let (mut forward, mut angle, mut height) = (0.0f64, 0.0f64, 0.0f64);
    let cases = oracle()["cases"].as_array().unwrap().clone();
    assert!(cases.len() > 100);
    for case in cases {
        let g = numbers(&case["geodetic"]);
        let exact = numbers(&case["exact"]);
        let found = WGS84.geocentric_from_geodetic(&geodetic(g[0], g[1], g[2]));
        let error = (found - point(&exact)).amax();
        let scale = g[2].abs() + WGS84.semi_major_axis();
        forward = forward.max(error / scale);

        let xyz = point(&numbers(&case["geocentric"]));
        let back = numbers(&case["back"]);
        let found = WGS84.geodetic_from_geocentric(&xyz).unwrap();
        let turn = (found.longitude() - back[1]).abs();
        // At the pole itself the longitude is lost where the float of the distance from the axis is.
        let turn = turn.min(2.0 * PI - turn);
        angle = angle.max((found.latitude() - back[0]).abs()).max(turn);
        let h = (found.height().0 - back[2]).abs();
        height = height.max(h / ulp(back[2]).max(1e-9));
    }
    println!(
        "forward {forward:e} of the distance from the centre, angles {angle:e} rad, height {height:e}"
    );
    assert!(forward < 4e-16, "forward {forward:e} of the distance from the centre");
    assert!(angle <= 1e-15, "angles {angle:e} rad");
    assert!(height <= 1.0, "height {height:e} of 1 nm or one unit in the last place");
}

#[test]
fn the_published_example_of_the_guidance_note() {
    // IOGP Publication 373-7-2 (EPSG Guidance Note 7-2), methods 9602, 9836 and 9837.
    let degrees = [53.0 + 48.0 / 60.0 + 33.82 / 3600.0, 2.0 + 7.0 / 60.0 + 46.38 / 3600.0];
    let place = Geodetic::from_degrees(degrees[0], degrees[1], EllipsoidalHeight(73.0)).unwrap();
    let xyz = Point3::new(3_771_793.968, 140_253.342, 5_124_304.349);
    assert!((WGS84.geocentric_from_geodetic(&place) - xyz).amax() < 1e-3);
    let origin = Geodetic::from_degrees(55.0, 5.0, EllipsoidalHeight(200.0)).unwrap();
    let frame = LocalFrame::east_north_up(WGS84, origin);
    let o = Point3::new(3_652_755.305_8, 319_574.679_9, 5_201_547.353_6);
    assert!((frame.pose().origin - o).amax() < 1e-4);
    let uvw = Point3::new(-189_013.869, -128_642.040, -4_220.171);
    assert!((frame.local_from_geocentric(&xyz) - uvw).amax() < 1e-3);
    assert!((frame.geocentric_from_local(&uvw) - xyz).amax() < 1e-3);
    let back = frame.geodetic_from_local(&uvw).unwrap();
    assert!((back.height().0 - 73.0).abs() < 1e-3);
    let down = LocalFrame::north_east_down(WGS84, origin).local_from_geocentric(&xyz);
    assert!((down - Point3::new(uvw.y, uvw.x, -uvw.z)).amax() < 1e-3);
}

#[test]
fn the_published_examples_of_other_programs() {
    // README of the npm package ecef-projector, printed to the last digit.
    let place =
        Geodetic::from_degrees(37.804_372_2, -122.270_802_6, EllipsoidalHeight(0.0)).unwrap();
    let xyz = Point3::new(-2_694_044.411_156_540_3, -4_266_368.805_493_665, 3_888_310.602_276_871);
    assert!((WGS84.geocentric_from_geodetic(&place) - xyz).amax() < 2e-9);
    // MathWorks Mapping Toolbox, ecef2enu; kilometres there.
    let origin = Geodetic::from_degrees(45.9132, 36.7484, EllipsoidalHeight(1_877_753.2)).unwrap();
    let point = Point3::new(5_507_528.9, 4_556_224.1, 6_012_820.8);
    let enu = LocalFrame::east_north_up(WGS84, origin).local_from_geocentric(&point);
    assert!((enu - Point3::new(355_601.3, -923_083.2, 1_041_000.0)).xy().amax() < 0.1);
    assert!((enu.z - 1_041_000.0).abs() < 50.0); // printed as 1041.0 km
}

#[test]
fn neighbours_keep_their_nanometres_in_a_local_frame() {
    let frame = LocalFrame::east_north_up(WGS84, geodetic(0.8, 2.0, 500.0));
    let near = frame.pose().origin + Vector3::new(3.0, -4.0, 12.0);
    assert!((frame.local_from_geocentric(&near).coords.norm() - 13.0).abs() < 2e-15 * 13.0);
}

#[test]
fn the_nearest_foot_is_found_at_the_centre_the_axis_and_the_equator() {
    let b = WGS84.semi_minor_axis();
    let at = |x, y, z| WGS84.geodetic_from_geocentric(&Point3::new(x, y, z)).unwrap();
    for (found, latitude, height) in [
        (at(0.0, 0.0, 0.0), FRAC_PI_2, -b),
        (at(0.0, 0.0, b + 10.0), FRAC_PI_2, 10.0),
        (at(0.0, 0.0, -b - 10.0), -FRAC_PI_2, 10.0),
        (at(0.0, 0.0, -1e-200), -FRAC_PI_2, -b),
        (at(6_378_237.0, 0.0, 0.0), 0.0, 100.0),
        (at(0.0, -60_000.0, 0.0), 0.0, 60_000.0 - 6_378_137.0),
    ] {
        assert!((found.latitude() - latitude).abs() < 1e-15, "{found:?}");
        assert!((found.height().0 - height).abs() < 1e-9, "{found:?}");
    }
    assert_eq!(at(0.0, 0.0, 5.0).longitude(), 0.0);
    // Both feet at the distance that the parametric form gives: p = a e² cos t, t = 60°.
    let (a, e2) = (WGS84.semi_major_axis(), WGS84.eccentricity_squared());
    let found = at(0.5 * a * e2, 0.0, 0.0);
    let foot = Vector3::new(0.5 * a, 0.0, b * 0.75f64.sqrt());
    let distance = (foot - Vector3::new(0.5 * a * e2, 0.0, 0.0)).norm();
    assert!((found.height().0 + distance).abs() < 2e-9 && found.latitude() > 0.0);
    // On a sphere the centre is as good as any point of the axis.
    let sphere = Ellipsoid::new(10.0, 0.0).unwrap();
    let centre = sphere.geodetic_from_geocentric(&Point3::origin()).unwrap();
    assert_eq!((centre.latitude(), centre.height().0), (FRAC_PI_2, -10.0));
}

#[test]
fn bad_input_is_an_error() {
    let height = EllipsoidalHeight(0.0);
    assert!(matches!(Geodetic::new(f64::NAN, 0.0, height), Err(Error::NotFinite { .. })));
    assert!(matches!(Geodetic::new(1.6, 0.0, height), Err(Error::OutOfRange { .. })));
    assert!(matches!(Geodetic::from_degrees(0.0, 361.0, height), Err(Error::OutOfRange { .. })));
    let infinite = EllipsoidalHeight(f64::INFINITY);
    assert!(matches!(Geodetic::new(0.0, 0.0, infinite), Err(Error::NotFinite { .. })));
    for (a, f) in [(f64::NAN, 0.0), (0.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -0.1), (1e301, 0.1)]
    {
        assert!(Ellipsoid::new(a, f).is_err(), "{a} {f}");
    }
    let b = WGS84.semi_minor_axis();
    for h in [f64::NAN, -b, -1e9, 1e20] {
        assert!(WGS84.at_height(EllipsoidalHeight(h)).is_err(), "{h}");
    }
    assert!(WGS84.at_height(EllipsoidalHeight(0.001 - b)).is_ok());
    let nan = Point3::new(0.0, f64::NAN, 0.0);
    assert_eq!(WGS84.geodetic_from_geocentric(&nan), Err(ProjectionError::NotFinite));
    let surface = WGS84.at_height(EllipsoidalHeight(0.0)).unwrap();
    assert!(surface.height_above(&nan).is_nan());
    let far = Ray::new(Point3::new(1e200, 0.0, 0.0), Vector3::new(-1.0, 0.0, 0.0)).unwrap();
    assert!(matches!(surface.meet_ray(&far), Err(ProjectionError::OutsideDomain { .. })));
}

#[test]
fn a_ray_meets_the_constant_height_where_sixty_digits_say() {
    for case in oracle()["rays"].as_array().unwrap() {
        let (o, d) = (numbers(&case["origin"]), numbers(&case["direction"]));
        let h = case["height"].as_f64().unwrap();
        let distance: f64 = case["distance"].as_str().unwrap().parse().unwrap();
        let ray = Ray::new(point(&o), Vector3::from_row_slice(&d)).unwrap();
        let surface = WGS84.at_height(EllipsoidalHeight(h)).unwrap();
        let hit = surface.meet_ray(&ray).unwrap();
        assert!((hit - ray.at(distance)).norm() < 4e-9, "{hit} {}", ray.at(distance));
    }
    // The quadric with semi-axes a + h and b + h is another surface: mpmath has it 14.0768 mm lower at 45° and 10 km.
    let (a, b) = (WGS84.semi_major_axis() + 1e4, WGS84.semi_minor_axis() + 1e4);
    let t = (b / a).atan();
    let on_quadric = Point3::new(a * t.cos(), 0.0, b * t.sin());
    let surface = WGS84.at_height(EllipsoidalHeight(1e4)).unwrap();
    let gap = surface.height_above(&on_quadric);
    assert!((gap + 0.014_076_8).abs() < 1e-6, "{gap}");
}

#[test]
fn a_grazing_ray_meets_and_a_higher_one_misses() {
    let surface = WGS84.at_height(EllipsoidalHeight(250.0)).unwrap();
    let place = geodetic(0.7, 0.3, 250.0);
    let (touch, up) = (WGS84.geocentric_from_geodetic(&place), Ellipsoid::normal(0.7, 0.3));
    let along = up.cross(&Vector3::z()).normalize();
    for (lift, meets) in [(-1.0, true), (-1e-6, true), (1e-6, false), (1.0, false)] {
        let start = touch - along * 2e6 + up.into_inner() * lift;
        let hit = surface.meet_ray(&Ray::new(start, along).unwrap());
        assert_eq!(hit.is_ok(), meets, "{lift} {hit:?}");
        if let Ok(hit) = hit {
            // The chord that is `lift` below a circle of the local radius begins √(2 R |lift|) before the touch.
            let chord = (2.0 * 6.39e6 * f64::abs(lift)).sqrt();
            assert!(((touch - hit).norm() / chord - 1.0).abs() < 0.02, "{lift} {hit}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn geodetic_to_geocentric_and_back_is_the_identity(
        sine in -1.0..1.0f64,
        longitude in -PI..PI,
        h in prop_oneof![-6.0e6..1e5, -1e4..1e4, 0.0..1e9],
    ) {
        let g = geodetic(f64::asin(sine), longitude, h);
        let back = WGS84.geodetic_from_geocentric(&WGS84.geocentric_from_geodetic(&g)).unwrap();
        let scale = WGS84.semi_major_axis() + h.abs();
        // The rounding of the coordinates between moves the point, and turns it by that over its distance.
        let moved = 3.5e-16 * scale;
        let turned = moved / (6.335e6 + h);
        prop_assert!((back.height().0 - h).abs() <= moved + ulp(h), "{g:?} {back:?}");
        prop_assert!((back.latitude() - g.latitude()).abs() <= turned + 3e-16, "{g:?} {back:?}");
        let east = (back.longitude() - longitude).abs().min(2.0 * PI - (back.longitude() - longitude).abs());
        prop_assert!(east * g.latitude().cos() <= turned + 5e-16, "{g:?} {back:?}");
    }

    #[test]
    fn geocentric_to_geodetic_and_back_is_the_identity_even_at_the_centre(
        direction in unit_vector(),
        exponent in -3.0..9.0f64,
        f in prop_oneof![Just(1.0 / 298.257_223_563), 0.0..0.9f64, Just(0.0)],
    ) {
        let ellipsoid = Ellipsoid::new(6_378_137.0, f).unwrap();
        let p = Point3::from(direction * 10f64.powf(exponent));
        let g = ellipsoid.geodetic_from_geocentric(&p).unwrap();
        let back = ellipsoid.geocentric_from_geodetic(&g);
        // One unit in the last place of the latitude moves the foot by that times the largest radius, a²/b.
        let scale = p.coords.norm() + 6.4e6 / (1.0 - f);
        prop_assert!((back - p).norm() <= 4e-16 * scale, "{g:?} {}", (back - p).norm());
    }

    #[test]
    fn the_foot_is_nearer_than_any_other_point_of_the_ellipsoid(
        direction in unit_vector(),
        distance in 0.0..2.0f64,
        f in 0.0..0.9f64,
        other in -1.0..1.0f64,
    ) {
        let ellipsoid = Ellipsoid::new(1.0, f).unwrap();
        let p = direction * distance;
        let height = ellipsoid.geodetic_from_geocentric(&Point3::from(p)).unwrap().height().0;
        // The nearest point has the longitude of p; `other` is the sine of a reduced latitude.
        let q = (p.xy().norm() - (1.0 - other * other).sqrt()).hypot(p.z - (1.0 - f) * other);
        prop_assert!(height.abs() <= q + 1e-15);
    }

    #[test]
    fn any_floats_give_a_position_or_an_error(
        x in any::<f64>(), y in any::<f64>(), z in any::<f64>(),
        a in prop_oneof![Just(6_378_137.0), Just(1e-200), Just(1e200), Just(f64::MIN_POSITIVE)],
        f in prop_oneof![Just(0.0), Just(1e-200), Just(0.0033), Just(0.999_999)],
    ) {
        let ellipsoid = Ellipsoid::new(a, f).unwrap();
        match ellipsoid.geodetic_from_geocentric(&Point3::new(x, y, z)) {
            Ok(g) => {
                let again = Geodetic::new(g.latitude(), g.longitude(), g.height());
                prop_assert_eq!(again, Ok(g));
                let size = x.abs().max(y.abs()).max(z.abs()).max(a);
                prop_assert!(g.height().0.abs() <= 2.0 * size, "{:?}", g);
            }
            Err(e) => prop_assert_eq!(e, ProjectionError::NotFinite),
        }
    }

    #[test]
    fn a_ray_meets_the_constant_height_first_and_there(
        place in (-1.5..1.5f64, -PI..PI),
        eye in prop_oneof![-2e4..2e4f64, 1e5..4e7f64],
        direction in unit_vector(),
        h in prop_oneof![-1e4..1e4f64, Just(0.0), -3e6..5e6f64],
    ) {
        let surface = WGS84.at_height(EllipsoidalHeight(h)).unwrap();
        let origin = WGS84.geocentric_from_geodetic(&geodetic(place.0, place.1, eye));
        let ray = Ray::new(origin, direction).unwrap();
        let resolution = 4.5e-16 * (origin.coords.norm() + 6.4e6 + h.abs());
        // Sampled: the height above the surface at 400 distances, to 2 radii past the eye's own distance.
        let reach = 2.0 * (origin.coords.norm() + 1.4e7);
        let above = |t: f64| surface.height_above(&ray.at(t));
        let start = above(0.0);
        match surface.meet_ray(&ray) {
            Ok(hit) => {
                prop_assert!(surface.height_above(&hit).abs() <= resolution, "{}", surface.height_above(&hit));
                let t = (hit - origin).dot(&direction);
                prop_assert!((ray.at(t) - hit).norm() <= 2.0 * resolution && t >= 0.0);
                for k in 1..400 {
                    let value = above(t * f64::from(k) / 400.0);
                    prop_assert!(value * start >= 0.0 || value.abs() <= resolution, "earlier crossing {k}");
                }
            }
            Err(e) => {
                prop_assert_eq!(e, ProjectionError::MissesSurface);
                for k in 0..400 {
                    prop_assert!(above(reach * f64::from(k) / 400.0) > 0.0, "missed at {k}");
                }
            }
        }
    }
}

fn layout(south: f64, west: f64, step: f64, rows: usize, columns: usize) -> GeoidLayout {
    GeoidLayout {
        south_deg: south,
        west_deg: west,
        latitude_step_deg: step,
        longitude_step_deg: step,
        rows,
        columns,
    }
}

fn sampled(layout: GeoidLayout, f: impl Fn(f64, f64) -> f64) -> GeoidGrid {
    let mut values = Vec::new();
    for i in 0..layout.rows {
        for j in 0..layout.columns {
            let latitude = layout.south_deg + layout.latitude_step_deg * i as f64;
            let longitude = layout.west_deg + layout.longitude_step_deg * j as f64;
            values.push(f(latitude, longitude) as f32);
        }
    }
    GeoidGrid::new(layout, values).unwrap()
}

fn at(grid: &GeoidGrid, latitude: f64, longitude: f64) -> Result<f64, Error> {
    grid.undulation(latitude.to_radians(), longitude.to_radians())
}

#[test]
fn bilinear_reproduces_a_bilinear_geoid_and_bicubic_a_bicubic_one() {
    // Small integer coefficients: every node is exact in f32.
    let two = |la: f64, lo: f64| 3.0 - 2.0 * la + lo + 0.5 * la * lo;
    let four = |la: f64, lo: f64| (la * la - 3.0) * la + (lo * lo - lo) * lo * (la - 2.0) * la;
    let region = layout(-3.0, -4.0, 1.0, 8, 9);
    let linear = sampled(region, two).with_interpolation(GeoidInterpolation::Bilinear);
    let cubic = sampled(region, four);
    for k in 0..=70 {
        for l in 0..=80 {
            let (la, lo) = (-3.0 + 0.1 * f64::from(k), -4.0 + 0.1 * f64::from(l));
            assert!((at(&linear, la, lo).unwrap() - two(la, lo)).abs() < 1e-12, "{la} {lo}");
            assert!((at(&cubic, la, lo).unwrap() - four(la, lo)).abs() < 1e-10, "{la} {lo}");
        }
    }
    // Two rows and three columns: lines one way, parabolas the other.
    let small = sampled(layout(10.0, 20.0, 1.0, 2, 3), |la, lo| la * (lo - 20.0) * (lo - 21.0));
    assert!((at(&small, 10.25, 21.5).unwrap() - 10.25 * 0.75).abs() < 1e-12);
}

#[test]
fn bicubic_is_within_the_remainder_of_centred_cubics() {
    // The remainder of a cubic through nodes at −1, 0, 1, 2 steps is at most 9/16 h⁴/4! max |f⁗| between 0 and 1; it
    // would be 15/16 in a neighbouring interval.
    let grid = sampled(layout(-90.0, 0.0, 10.0, 19, 36), |_, lo| lo.to_radians().sin());
    let worst = (0..3600)
        .map(|k| f64::from(k) / 10.0)
        .map(|lo| (at(&grid, 3.0, lo).unwrap() - lo.to_radians().sin()).abs())
        .fold(0.0, f64::max);
    let bound = 9.0 / 16.0 * 10f64.to_radians().powi(4) / 24.0;
    assert!(worst <= bound + 1e-7 && worst > 0.9 * bound, "{worst:e} {bound:e}");
}

#[test]
fn longitudes_wrap_where_the_columns_span_a_turn() {
    let wave = |la: f64, lo: f64| 10.0 * lo.to_radians().sin() + la / 10.0;
    for columns in [360, 361] {
        let grid = sampled(layout(-90.0, -180.0, 1.0, 181, columns), wave);
        for lo in [
            -720.0f64, -360.0, -180.0, -179.7, -0.3, 0.0, 90.0, 179.3, 179.999, 180.0, 181.2, 539.7,
        ] {
            for la in [-90.0, -89.5, 0.0, 89.9, 90.0] {
                let found = at(&grid, la, lo).unwrap();
                assert!((found - wave(la, lo)).abs() < 2e-6, "{columns} {la} {lo} {found}");
            }
        }
    }
}

#[test]
fn outside_the_grid_and_at_voids_there_is_no_undulation() {
    let mut values = vec![7.0; 30];
    values[2 * 6 + 3] = f32::NAN; // row 2, column 3
    let grid = GeoidGrid::new(layout(40.0, 358.0, 1.0, 5, 6), values).unwrap();
    let bilinear = grid.clone().with_interpolation(GeoidInterpolation::Bilinear);
    let near = |x: Result<f64, Error>| (x.unwrap() - 7.0).abs() < 1e-12;
    // Both ways of counting longitudes, and the edges themselves.
    assert!(near(at(&bilinear, 40.0, -2.0)) && near(at(&bilinear, 44.0, 363.0)));
    assert!(near(at(&bilinear, 40.5, 3.0)));
    for (la, lo) in [(39.999, 0.0), (44.001, 0.0), (41.0, 3.001), (41.0, 357.9), (41.0, 180.0)] {
        assert!(matches!(at(&grid, la, lo), Err(Error::OutOfRange { .. })), "{la} {lo}");
    }
    let void = Err(Error::NoData { what: "the geoid grid", row: 2, column: 3 });
    for (la, lo) in [(41.5, 0.5), (42.0, 1.0), (42.5, 1.9)] {
        assert_eq!(at(&bilinear, la, lo), void, "{la} {lo}");
    }
    assert_eq!(at(&grid, 40.2, -0.9), void); // 4 × 4 reaches farther
    assert!(near(at(&bilinear, 40.2, -0.9)));
    assert!(matches!(grid.undulation(f64::NAN, 0.0), Err(Error::NotFinite { .. })));
    assert!(matches!(grid.undulation(0.7, f64::INFINITY), Err(Error::NotFinite { .. })));
    assert!(matches!(grid.undulation(1e200, 1e200), Err(Error::OutOfRange { .. })));
}

#[test]
fn a_bad_layout_is_refused() {
    let with = |rows, columns, south, step| {
        GeoidGrid::new(layout(south, 0.0, step, rows, columns), vec![0.0; 4])
    };
    assert!(with(2, 2, 0.0, 1.0).is_ok());
    assert!(matches!(with(2, 3, 0.0, 1.0), Err(Error::LengthMismatch { .. })));
    assert!(matches!(with(usize::MAX, 2, 0.0, 1.0), Err(Error::LengthMismatch { .. })));
    assert!(matches!(with(1, 4, 0.0, 1.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(with(2, 2, 0.0, -1.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(with(2, 2, 0.0, f64::NAN), Err(Error::NotFinite { .. })));
    assert!(matches!(with(2, 2, 89.5, 1.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(with(2, 2, -90.5, 1.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(with(2, 2, 0.0, 1e200), Err(Error::OutOfRange { .. })));
    assert!(with(2, 2, 0.0, 1e-200).is_ok());
}

proptest! {
    #[test]
    fn heights_go_to_the_geoid_and_back(la in -80.0..80.0f64, lo in -360.0..360.0f64, h in -1e4..1e4f64) {
        let grid = sampled(layout(-90.0, 0.0, 10.0, 19, 36), |la, lo| 50.0 * (la + lo).to_radians().sin());
        let g = grid.geodetic(la.to_radians(), lo.to_radians(), OrthometricHeight(h)).unwrap();
        prop_assert!((g.height().0 - h - at(&grid, la, lo).unwrap()).abs() < 1e-11);
        prop_assert!((grid.orthometric(&g).unwrap().0 - h).abs() < 1e-11);
    }

    #[test]
    fn any_layout_and_place_give_a_number_or_an_error(
        numbers in prop::array::uniform4(prop_oneof![any::<f64>(), -90.0..90.0f64]),
        la in any::<f64>(), lo in any::<f64>(),
        shape in prop_oneof![Just((2, 6)), Just((3, 4)), Just((12, 1)), Just((4, 3))],
    ) {
        let layout = GeoidLayout {
            south_deg: numbers[0],
            west_deg: numbers[1],
            latitude_step_deg: numbers[2],
            longitude_step_deg: numbers[3],
            rows: shape.0,
            columns: shape.1,
        };
        if let Ok(grid) = GeoidGrid::new(layout, vec![1.0; 12]) {
            for g in [grid.clone(), grid.with_interpolation(GeoidInterpolation::Bilinear)] {
                for (la, lo) in [(la, lo), (numbers[0].to_radians(), numbers[1].to_radians())] {
                    if let Ok(n) = g.undulation(la, lo) {
                        prop_assert!((n - 1.0).abs() < 1e-6, "{}", n);
                    }
                }
            }
        }
    }
}

/// NGA's test points for EGM96: latitude, longitude, undulation from the 15′ grid by its own spline (OUTINTPT.DAT).
const EGM96: [[f64; 3]; 6] = [
    [38.628_155_0, 269.779_155_0, -31.628],
    [-14.621_217_0, 305.021_114_0, -2.969],
    [46.874_319_0, 102.448_729_0, -43.575],
    [-23.617_446_0, 133.874_712_0, 15.871],
    [38.625_473_0, 359.999_500_0, 50.066],
    [-0.466_744_0, 0.002_300_0, 17.329],
];

#[test]
fn egm96_agrees_with_the_published_test_points() {
    let folder = std::env::var_os("COLLINEAR_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared")),
        PathBuf::from,
    );
    let Ok(bytes) = std::fs::read(folder.join("data/terrain/egm96_15.gtx")) else {
        println!("skipped: no {}", folder.join("data/terrain/egm96_15.gtx").display());
        return;
    };
    // GTX: four f64 (south, west, steps) and two i32 (rows, columns), big-endian, then f32 row by row from the south.
    let f64_at = |i: usize| f64::from_be_bytes(bytes[8 * i..8 * i + 8].try_into().unwrap());
    let i32_at = |i: usize| i32::from_be_bytes(bytes[i..i + 4].try_into().unwrap());
    let layout = GeoidLayout {
        south_deg: f64_at(0),
        west_deg: f64_at(1),
        latitude_step_deg: f64_at(2),
        longitude_step_deg: f64_at(3),
        rows: usize::try_from(i32_at(32)).unwrap(),
        columns: usize::try_from(i32_at(36)).unwrap(),
    };
    let values =
        bytes[40..].chunks_exact(4).map(|c| f32::from_be_bytes(c.try_into().unwrap())).collect();
    let bicubic = GeoidGrid::new(layout, values).unwrap();
    let bilinear = bicubic.clone().with_interpolation(GeoidInterpolation::Bilinear);
    let worst = |grid: &GeoidGrid| {
        let errors = EGM96.iter().map(|[la, lo, n]| (at(grid, *la, *lo).unwrap() - n).abs());
        errors.fold(0.0, f64::max)
    };
    let (cubic, linear) = (worst(&bicubic), worst(&bilinear));
    println!("EGM96 test points: bicubic within {cubic:.4} m, bilinear within {linear:.4} m");
    assert!(cubic < 0.009 && linear < 0.0565);
    // The pole has one undulation, whatever the longitude.
    let pole = |lo: f64| at(&bicubic, 90.0, lo).unwrap();
    assert!((pole(0.0) - pole(137.1)).abs() < 1e-5);
}
