//! What scanning cameras refuse, and what they say.

use std::f64::consts::PI;

use collinear::camera::{
    Adjustable, Brown, BrownCamera, CentralCamera, CentralModel, Ephemeris, ExteriorOrientation,
    ImageMotionCompensation, InteriorOrientation, Interpolation, NoDistortion, Panorama,
    PlatformState, PolynomialTrajectory, ScanTime, Scanner, SensorModel, Trajectory,
};
use collinear::geometry::Plane;
use collinear::nalgebra::{Point2, Point3, Rotation3, Vector3};
use collinear::{Error, ProjectionError};

fn down(center: Point3<f64>) -> ExteriorOrientation {
    ExteriorOrientation::look_at(center, center - Vector3::z(), -Vector3::y()).unwrap()
}

fn interior(f: f64, x: f64, y: f64) -> InteriorOrientation {
    InteriorOrientation::new([f; 2], Point2::new(x, y), 0.0).unwrap()
}

type Flight = PolynomialTrajectory<ExteriorOrientation>;

/// From (0, 0, 100) with a unit a second along y; a line a second.
fn pushbroom() -> Scanner<InteriorOrientation, Flight> {
    let flight = PolynomialTrajectory::constant_velocity(
        down(Point3::new(0.0, 0.0, 100.0)),
        0.0,
        Vector3::y(),
        Vector3::zeros(),
    );
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 50.0]).unwrap();
    Scanner::line_scan(interior(1000.0, 100.0, 0.5), flight.unwrap(), 0.5, lines).unwrap()
}

#[test]
fn what_a_scan_does_not_see_says_when_it_would_be_seen() {
    let scanner = pushbroom();
    let outside = |y: f64| match scanner.project(&Point3::new(1.0, y, 3.0)) {
        Err(ProjectionError::OutsideScan { time, first, last }) => {
            assert_eq!((first, last), (0.0, 50.0));
            time
        }
        other => panic!("{other:?}"),
    };
    assert!((outside(-7.0) + 7.0).abs() < 1e-9);
    assert!((outside(61.5) - 61.5).abs() < 1e-9);
    // The first and the last line belong to it.
    for y in [0.0, 50.0] {
        assert!((scanner.project(&Point3::new(0.0, y, 0.0)).unwrap().y - y).abs() < 1e-9);
    }
    assert!(matches!(
        scanner.project(&Point3::new(0.0, 7.0, 200.0)),
        Err(ProjectionError::BehindCamera { depth }) if depth == -100.0
    ));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(scanner.project(&Point3::new(0.0, bad, 0.0)), Err(ProjectionError::NotFinite));
        assert!(scanner.project_jacobian(&Point3::new(bad, 0.0, 0.0)).is_err());
        assert_eq!(scanner.locus(&Point2::new(3.0, bad)), Err(ProjectionError::NotFinite));
        assert_eq!(scanner.locus(&Point2::new(bad, 3.0)), Err(ProjectionError::NotFinite));
    }
    for y in [-1e-3, 50.001, 1e300] {
        let found = scanner.locus(&Point2::new(5.0, y));
        assert_eq!(found, Err(ProjectionError::OutsideScan { time: y, first: 0.0, last: 50.0 }));
    }
    let message = scanner.locus(&Point2::new(5.0, -2.5)).unwrap_err().to_string();
    assert_eq!(message, "outside the scan: time -2.5 is not between 0 and 50");
}

/// A platform that turns back: what it never reaches is not said to be seen at a time of the scan.
#[test]
fn a_time_outside_the_scan_is_outside_the_scan() {
    let position = vec![Vector3::zeros(), Vector3::y(), Vector3::new(0.0, -0.01, 0.0)];
    let start = down(Point3::new(0.0, 0.0, 100.0));
    let flight = PolynomialTrajectory::new(start, 0.0, 1.0, position, vec![]).unwrap();
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 100.0]).unwrap();
    let scanner = Scanner::line_scan(interior(1000.0, 100.0, 0.5), flight, 0.5, lines).unwrap();
    // At t = 50 it is at y = 25, and at either end at 0.
    assert!(scanner.project(&Point3::new(1.0, 24.9, 0.0)).is_ok());
    for y in [25.1, 30.0, 70.0] {
        match scanner.project(&Point3::new(1.0, y, 0.0)) {
            Err(ProjectionError::OutsideScan { time, .. }) => assert!(time.is_nan(), "{time}"),
            other => panic!("{other:?}"),
        }
    }
    match scanner.project(&Point3::new(1.0, -1.0, 0.0)) {
        Err(ProjectionError::OutsideScan { time, .. }) => {
            assert!(!(0.0..=100.0).contains(&time), "{time}");
        }
        other => panic!("{other:?}"),
    }
}

/// A table that ends with the scan, its nodes closer than lines: the first and the last line are seen like any other, and what
/// `project` gives is a pixel that `locus` takes.
#[test]
fn a_table_that_ends_with_the_scan_sees_its_first_and_its_last_line() {
    for nodes in [1, 20, 100] {
        let times: Vec<f64> = (0..=50 * nodes).map(|k| f64::from(k) / f64::from(nodes)).collect();
        let positions: Vec<_> = times.iter().map(|t| Point3::new(0.0, 0.3 * t, 100.0)).collect();
        let turn = |t: &f64| Rotation3::from_axis_angle(&Vector3::x_axis(), 1e-4 * t);
        let level = down(Point3::origin()).camera_from_world();
        let attitudes: Vec<_> = times.iter().map(|t| turn(t) * level).collect();
        let linear = Interpolation::Linear;
        let table = Ephemeris::new((&times, &positions, linear), (&times, &attitudes, linear));
        let lines = ScanTime::by_line(0.0, 1.0, [0.0, 50.0]).unwrap();
        let camera = interior(1000.0, 100.0, 0.5);
        let scanner = Scanner::line_scan(camera, table.unwrap(), 0.5, lines).unwrap();
        let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
        for k in 0..=500 {
            let image = Point2::new(3.0, 0.1 * f64::from(k));
            let world = scanner.ground(&image, &ground).unwrap();
            let again = scanner.project(&world).unwrap();
            assert!((again - image).norm() < 1e-9, "{nodes} {image} {again}");
            assert!((scanner.ground(&again, &ground).unwrap() - world).norm() < 1e-9);
        }
    }
    // 3 · 0.1 is a rounding above 0.3, where this table ends.
    let (times, attitudes) = ([0.0, 0.3], [down(Point3::origin()).camera_from_world(); 2]);
    let positions = [Point3::new(0.0, 0.0, 100.0), Point3::new(0.0, 3.0, 100.0)];
    let linear = Interpolation::Linear;
    let table = Ephemeris::new((&times, &positions, linear), (&times, &attitudes, linear)).unwrap();
    let lines = ScanTime::by_line(0.0, 0.1, [0.0, 3.0]).unwrap();
    assert!(lines.interval()[1] > 0.3);
    let scanner = Scanner::line_scan(interior(1000.0, 100.0, 0.5), table, 0.5, lines).unwrap();
    assert!((scanner.project(&Point3::new(0.0, 3.0, 0.0)).unwrap().y - 3.0).abs() < 1e-9);
    assert!(scanner.locus(&Point2::new(1.0, 3.0)).is_ok());
}

/// A camera that turns by a radian a line: where the image runs off the picture a short step of time is no proof of a root. What
/// is given is the pixel whose ray meets the point.
#[test]
fn an_image_that_runs_away_is_not_taken_for_a_root() {
    let flight = PolynomialTrajectory::constant_velocity(
        down(Point3::new(0.0, 0.0, 500.0)),
        0.0,
        Vector3::y(),
        Vector3::new(1.0, 0.0, 1.0),
    )
    .unwrap();
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 100.0]).unwrap();
    let columns = ScanTime::by_column(0.0, 1.0, [0.0, 1000.0]).unwrap();
    let film = interior(1000.0, 500.0, 50.0);
    let none = ImageMotionCompensation::default();
    let rolling = Scanner::frame_scan(film, flight.clone(), lines).unwrap();
    let panoramic = Scanner::panoramic(film, none, flight, columns).unwrap();
    let far = Point3::new(-1e300, 0.0, 0.0);
    let beside_the_axis = Point3::new(0.0, 1e9, 0.0);
    for (sensor, world) in [(&rolling as &dyn SensorModel, far), (&panoramic, beside_the_axis)] {
        let Ok(p) = sensor.project(&world) else { continue };
        let collinear::geometry::Locus::Ray(ray) = sensor.locus(&p).unwrap() else { panic!() };
        let way = world - ray.origin;
        let along = (way / way.amax()).normalize().dot(&ray.direction);
        assert!(along > 1.0 - 1e-9, "{world} {p} {along}");
    }
}

/// A line camera close above a long road, its lens with a fold: the point is in the lens for a hundredth or a thousandth of the
/// scan, and found.
#[test]
fn a_point_that_is_before_the_lens_for_a_moment_is_found() {
    let lens = Brown::new([-0.15, 0.0, 0.0], [0.0; 2]).unwrap();
    let camera = BrownCamera::new(interior(4000.0, 4000.0, 0.5), lens);
    let start = down(Point3::new(0.0, 0.0, 5.0));
    let ground = Plane::from_point_and_normal(Point3::origin(), Vector3::z()).unwrap();
    for length in [100.0, 1_000.0, 4_000.0] {
        let velocity = Vector3::new(0.0, 1e-3, 0.0);
        let flight =
            PolynomialTrajectory::constant_velocity(start, 0.0, velocity, Vector3::zeros());
        let lines = ScanTime::by_line(0.0, 1.0, [0.0, 1e3 * length]).unwrap();
        let scanner = Scanner::line_scan(camera, flight.unwrap(), 0.5, lines).unwrap();
        for k in 0..=300 {
            let k = f64::from(k);
            let image = Point2::new(500.0 + 7000.0 * (0.618 * k).fract(), 1e3 * length * k / 300.0);
            let world = scanner.ground(&image, &ground).unwrap();
            let again = scanner.project(&world).unwrap();
            // The lines number millions, and a metre of the road is a thousand of them.
            assert!((again - image).norm() < 1e-7, "{length} {image} {again}");
        }
        // Beside the road, in front of the lens never.
        let beside = scanner.project(&Point3::new(40.0, 0.5 * length, 0.0));
        assert!(matches!(beside, Err(ProjectionError::OutsideDomain { .. })), "{beside:?}");
    }
}

/// A rolling shutter that spins by many radians a line: a pixel that is given is that of a ray through the point.
#[test]
fn a_frame_that_spins_between_its_lines_gives_rays_through_the_point_or_none() {
    let mut found = Vec::new();
    for spin in [1.0, 10.0, 100.0, 1000.0] {
        let start = down(Point3::new(0.0, 0.0, 500.0));
        let turn = Vector3::new(0.6, 0.0, 0.8) * spin;
        let flight =
            PolynomialTrajectory::constant_velocity(start, 0.0, Vector3::y(), turn).unwrap();
        let lines = ScanTime::by_line(0.0, 1.0, [0.0, 100.0]).unwrap();
        let scanner = Scanner::frame_scan(interior(1000.0, 500.0, 50.0), flight, lines).unwrap();
        let ray = |p: &Point2<f64>| match scanner.locus(p).unwrap() {
            collinear::geometry::Locus::Ray(ray) => ray,
            other => panic!("{other:?}"),
        };
        let mut seen = 0;
        for k in 0..200 {
            let k = f64::from(k);
            let image = Point2::new(1000.0 * (0.618 * k).fract(), 0.5 * k + 0.1);
            let world = ray(&image).at(300.0 + k);
            let Ok(again) = scanner.project(&world) else { continue };
            let ray = ray(&again);
            let off = (world - ray.origin).normalize().cross(&ray.direction).norm();
            assert!(off < 1e-8, "{spin} {image} {again} {off:e}");
            seen += 1;
        }
        found.push(seen);
    }
    assert!(found[0] > 150, "{found:?}");
}

/// Seen from a platform that hangs still every line is one: no line is that of a point beside it, and none of one below it can
/// be told from the others.
#[test]
fn a_platform_that_stands_still_images_no_point_on_a_line() {
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 50.0]).unwrap();
    let still = down(Point3::new(0.0, 0.0, 100.0));
    let scanner = Scanner::line_scan(interior(1000.0, 100.0, 0.5), still, 0.5, lines).unwrap();
    assert!(matches!(
        scanner.project(&Point3::new(1.0, 3.0, 0.0)),
        Err(ProjectionError::OutsideScan { time, .. }) if time.is_nan()
    ));
    // Of a point on the row every line is one.
    let on_the_row = scanner.project(&Point3::new(1.0, 0.0, 0.0)).unwrap_err();
    assert_eq!(
        on_the_row.to_string(),
        "outside the scan: no time between 0 and 50 is found at which the point is seen"
    );
    assert!(scanner.project_jacobian(&Point3::new(1.0, 0.0, 0.0)).is_err());
}

/// A platform that is set forward by a gap at t = 5.
#[derive(Debug)]
struct Jump(f64);

impl Trajectory for Jump {
    fn span(&self) -> [f64; 2] {
        [-1.0, 11.0]
    }

    fn state(&self, t: f64) -> Result<PlatformState, ProjectionError> {
        let y = if t < 5.0 { t } else { t + self.0 };
        let still = down(Point3::new(0.0, y, 100.0)).state(t)?;
        Ok(PlatformState { velocity: Vector3::y(), ..still })
    }
}

#[test]
fn a_point_between_two_lines_is_not_converged_rather_than_on_a_wrong_line() {
    for gap in [0.3, 3.0] {
        let lines = ScanTime::by_line(0.0, 1.0, [0.0, 10.0]).unwrap();
        let scanner =
            Scanner::line_scan(interior(1000.0, 100.0, 0.5), Jump(gap), 0.5, lines).unwrap();
        match scanner.project(&Point3::new(1.0, 5.0 + 0.25 * gap, 0.0)) {
            Err(ProjectionError::NotConverged { residual, .. }) => {
                // A quarter of the gap from one line, three quarters from the other.
                let off = residual / gap;
                assert!((off - 0.25).abs() < 1e-6 || (off - 0.75).abs() < 1e-6, "{residual}");
            }
            other => panic!("{gap}: {other:?}"),
        }
        for y in [0.5, 4.999, 5.001 + gap, 9.5 + gap] {
            let p = scanner.project(&Point3::new(1.0, y, 0.0)).unwrap();
            let line = if y < 5.0 { y } else { y - gap };
            assert!((p.y - line).abs() < 1e-9, "{p}");
        }
    }
}

/// A panorama of a whole turn: behind is the seam, and no root is found in it.
#[test]
fn the_seam_of_a_panorama_is_no_root() {
    let film = interior(100.0, 100.0 * PI, 50.0);
    let columns = [0.0, 200.0 * PI];
    let sweep = ScanTime::by_column(0.0, 0.01, columns).unwrap();
    let flight = PolynomialTrajectory::constant_velocity(
        down(Point3::new(0.0, 0.0, 100.0)),
        PI,
        Vector3::new(0.0, 2.0, 0.0),
        Vector3::new(0.0, 0.01, 0.0),
    );
    let camera =
        Scanner::panoramic(film, ImageMotionCompensation::default(), flight.unwrap(), sweep);
    let camera = camera.unwrap();
    let mut seen = 0;
    for k in 0..360 {
        let (s, c) = (f64::from(k) + 0.5).to_radians().sin_cos();
        let world = Point3::new(70.0 * s, 5.0, 100.0 + 70.0 * c);
        match camera.project(&world) {
            Ok(p) => {
                seen += 1;
                let collinear::geometry::Locus::Ray(ray) = camera.locus(&p).unwrap() else {
                    panic!()
                };
                let along = (world - ray.origin).dot(&ray.direction);
                assert!((ray.at(along) - world).norm() < 1e-9, "{p}");
            }
            // The turn of the platform, 0.01 a second, leaves a gap of some 4° behind.
            Err(e) => assert!(matches!(e, ProjectionError::OutsideScan { .. }), "{e} {k}"),
        }
    }
    assert!((354..360).contains(&seen), "{seen}");
}

#[test]
fn times_and_trajectories_are_refused_with_a_reason() {
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(ScanTime::by_line(bad, 1.0, [0.0, 9.0]), Err(Error::NotFinite { .. })));
        assert!(matches!(ScanTime::by_line(0.0, bad, [0.0, 9.0]), Err(Error::NotFinite { .. })));
        assert!(matches!(ScanTime::by_line(0.0, 1.0, [0.0, bad]), Err(Error::NotFinite { .. })));
        let position = vec![Vector3::new(0.0, bad, 0.0)];
        assert!(matches!(
            PolynomialTrajectory::new(down(Point3::origin()), 0.0, 1.0, position, vec![]),
            Err(Error::NotFinite { .. })
        ));
        assert!(ImageMotionCompensation::new(bad).is_err());
    }
    assert!(matches!(ScanTime::by_line(0.0, 0.0, [0.0, 9.0]), Err(Error::OutOfRange { .. })));
    assert!(matches!(ScanTime::by_line(0.0, 1.0, [9.0, 9.0]), Err(Error::OutOfRange { .. })));
    // Seconds since 1980 have no nanolines of 0.1 ms; since the start of the scan they have.
    match ScanTime::by_line(1.4e9, 1e-4, [0.0, 30_000.0]) {
        Err(Error::OutOfRange { what, value, .. }) => {
            assert_eq!(what, "spacing of floats in lines of the scan");
            assert!(value > 1e-3 && value < 1e-2, "{value}");
        }
        other => panic!("{other:?}"),
    }
    assert!(ScanTime::by_line(400.0, 1e-4, [0.0, 30_000.0]).is_ok());
    assert!(matches!(
        PolynomialTrajectory::new(down(Point3::origin()), 0.0, 0.0, vec![], vec![]),
        Err(Error::OutOfRange { .. })
    ));
    let still = down(Point3::new(0.0, 0.0, 100.0));
    let columns = ScanTime::by_column(0.0, 1.0, [0.0, 9.0]).unwrap();
    let camera = interior(100.0, 0.0, 0.0);
    assert!(matches!(
        Scanner::line_scan(camera, still, 0.0, columns),
        Err(Error::OutOfRange { what: "time of a line", .. })
    ));
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 9.0]).unwrap();
    assert!(matches!(
        Scanner::line_scan(camera, still, f64::NAN, lines),
        Err(Error::NotFinite { .. })
    ));
    let scanner = Scanner::whiskbroom(camera, 0.0, still, lines).unwrap();
    assert_eq!((scanner.row(), scanner.timing().interval()), (Some(0.0), [0.0, 9.0]));
}

#[test]
fn tables_are_refused_with_a_reason() {
    let times = [0.0, 1.0, 2.0, 3.0];
    let positions = [Point3::origin(); 4];
    let attitudes = [Rotation3::identity(); 4];
    let linear = Interpolation::Linear;
    let table = |t: &[f64], p: &[Point3<f64>], how, u: &[f64], a: &[Rotation3<f64>]| {
        Ephemeris::new((t, p, how), (u, a, linear))
    };
    let positions_only = |t: &[f64], p: &[Point3<f64>], how| table(t, p, how, &times, &attitudes);
    assert!(matches!(
        positions_only(&times[..3], &positions, linear),
        Err(Error::LengthMismatch { left: 3, right: 4, .. })
    ));
    assert!(matches!(
        positions_only(&times[..1], &positions[..1], linear),
        Err(Error::TooFewPoints { needed: 2, got: 1 })
    ));
    assert!(matches!(
        positions_only(&[], &[], linear),
        Err(Error::TooFewPoints { needed: 2, got: 0 })
    ));
    assert!(matches!(
        positions_only(&times, &positions, Interpolation::Lagrange(8)),
        Err(Error::TooFewPoints { needed: 8, got: 4 })
    ));
    for count in [0, 1, 3, 14, usize::MAX] {
        assert!(matches!(
            positions_only(&times, &positions, Interpolation::Lagrange(count)),
            Err(Error::OutOfRange { .. })
        ));
    }
    for bad in [[0.0, 1.0, 1.0, 2.0], [0.0, 2.0, 1.0, 3.0]] {
        assert!(matches!(positions_only(&bad, &positions, linear), Err(Error::OutOfRange { .. })));
    }
    let bad = [0.0, 1.0, f64::NAN, 3.0];
    assert!(matches!(positions_only(&bad, &positions, linear), Err(Error::NotFinite { .. })));
    let mut lost = positions;
    lost[2].y = f64::INFINITY;
    assert!(matches!(positions_only(&times, &lost, linear), Err(Error::NotFinite { .. })));
    let later = times.map(|t| t + 3.0);
    assert!(matches!(
        table(&times, &positions, linear, &later, &attitudes),
        Err(Error::OutOfRange { what: "time that positions and attitudes share", .. })
    ));
    let about = |a: f64| Rotation3::from_axis_angle(&Vector3::z_axis(), a);
    let turns = [about(0.0), about(0.4), about(3.2), about(3.4)];
    assert!(matches!(
        table(&times, &positions, linear, &times, &turns),
        Err(Error::OutOfRange { value, .. }) if (value - 2.8).abs() < 1e-12
    ));
    let broken = [about(0.0), about(f64::NAN), about(0.2), about(0.3)];
    assert!(matches!(
        table(&times, &positions, linear, &times, &broken),
        Err(Error::NotFinite { .. })
    ));
    let whole = table(&times, &positions, linear, &[0.5, 1.5, 2.0, 2.5], &attitudes).unwrap();
    assert_eq!(whole.span(), [0.5, 2.5]);
    for t in [0.4, 2.6, f64::NAN, f64::INFINITY] {
        assert!(matches!(whole.state(t), Err(ProjectionError::OutsideScan { .. })), "{t}");
    }
    // A scan that the table does not cover at its start, or at its end.
    for lines in [[0.0, 2.0], [1.0, 3.0]] {
        let lines = ScanTime::by_line(0.0, 1.0, lines).unwrap();
        assert!(matches!(
            Scanner::line_scan(interior(100.0, 0.0, 0.0), whole.clone(), 0.0, lines),
            Err(Error::OutOfRange { what: "time of the scan", value, .. }) if value == 0.0 || value == 3.0
        ));
    }
}

#[test]
fn groups_of_a_scanner_are_those_of_its_trajectory_and_its_camera() {
    let mut scanner = pushbroom();
    let names: Vec<_> =
        (0..).map_while(|g| scanner.parameter_group(g)).map(|g| (g.name, g.len)).collect();
    assert_eq!(
        names,
        [("position polynomial", 6), ("attitude polynomial", 6), ("interior orientation", 5)]
    );
    assert!(matches!(
        scanner.adjust(0, &[0.0; 5]),
        Err(Error::LengthMismatch { left: 6, right: 5, .. })
    ));
    assert!(matches!(scanner.adjust(1, &[f64::NAN; 6]), Err(Error::NotFinite { .. })));
    assert!(matches!(scanner.adjust(3, &[0.0]), Err(Error::OutOfRange { .. })));
    assert_eq!(scanner, pushbroom());
    let mut untouched = [7.0; 2];
    scanner.parameters(9, &mut untouched);
    assert_eq!(untouched, [7.0; 2]);
    // A trajectory without parameters: the camera's groups come first.
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 50.0]).unwrap();
    let mut still =
        Scanner::line_scan(interior(1000.0, 100.0, 0.5), down(Point3::origin()), 0.5, lines)
            .unwrap();
    assert_eq!(still.parameter_group(0).unwrap().name, "interior orientation");
    assert!(still.adjust(1, &[]).is_err());
    assert!(Trajectory::adjust(&mut down(Point3::origin()), 0, &[]).is_err());
    // Held groups cost nothing and are not written.
    let (mut object, mut attitude) = ([0.0; 6], [0.0; 12]);
    let world = Point3::new(3.0, 20.0, 1.0);
    let p = scanner.partials(&world, &mut object, &mut [&mut [], &mut attitude]).unwrap();
    assert_eq!(p, scanner.project(&world).unwrap());
    assert!(attitude.iter().any(|v| *v != 0.0));
    scanner.partials(&world, &mut object, &mut []).unwrap();
}

/// A mirror of one's own fits in the place of the cylinder.
#[test]
fn a_row_that_no_time_reaches_and_a_camera_that_sees_nothing() {
    let camera =
        CentralCamera::from_parts(interior(100.0, 0.0, 0.0), Panorama::Cylindrical, NoDistortion);
    assert!(camera.direction(&Point2::new(0.0, 1e308)).is_ok());
    let flight = PolynomialTrajectory::constant_velocity(
        down(Point3::new(0.0, 0.0, 100.0)),
        0.0,
        Vector3::y(),
        Vector3::zeros(),
    )
    .unwrap();
    let lines = ScanTime::by_line(0.0, 1.0, [0.0, 50.0]).unwrap();
    let scanner = Scanner::line_scan(camera, flight, 1e300, lines).unwrap();
    for z in [0.0, 99.0, 100.0, 300.0] {
        assert!(scanner.project(&Point3::new(0.0, 10.0, z)).is_err());
    }
}
