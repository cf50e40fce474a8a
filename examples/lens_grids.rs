//! What each central model and each scanning camera does to a grid, as the figures of their pages.
//!
//! `cargo run --release --example lens_grids -- [FOLDER]` writes an SVG a model to FOLDER, or to `target/lenses`;
//! the documentation includes those in `docs/figures/lenses`.

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use collinear::camera::rpc::{Rpc, Rpc00b};
use collinear::camera::{
    Brown, CentralCamera, CentralProjection, Distortion, Division, DoubleSphere, EnhancedUnified,
    EvenRadial, ExteriorOrientation, FieldOfView, Fisheye, Frame, Fraser, Gnomonic,
    ImageMotionCompensation, InteriorOrientation, Metashape, NoDistortion, Orthographic, Panorama,
    PolynomialTrajectory, RadialTangentialThinPrism, Rational, ScanTime, Scanner, SensorModel,
    ThinPrism, UnifiedSphere,
};
use collinear::geometry::geodetic::EllipsoidalHeight;
use collinear::geometry::{Affine2, Dome};
use collinear::nalgebra::{Point2, Point3, Vector3};

type Failure = Box<dyn Error>;

/// The drawing's width and height, and its margin.
const SIZE: [f64; 2] = [360.0, 240.0];
const MARGIN: f64 = 8.0;

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map_or_else(|| "target/lenses".into(), PathBuf::from);
    fs::create_dir_all(&folder)?;
    let write = |name: &str, svg: String| fs::write(folder.join(name).with_extension("svg"), svg);

    // The lenses of the plane: a wall of squares, ideal and as the lens shows it. Coefficients are those of strong lenses.
    let (p, s) = ([8e-3, -5e-3], [6e-3, -3e-3, -5e-3, 2e-3]);
    write("brown", wall(&Brown::new([-0.28, 0.05, 0.0], p)?))?;
    let k = [-0.28, 0.07, 0.0, 0.02, -0.02, 0.0];
    write("rational", wall(&Rational::new(k, p, s, [0.1, -0.15])?))?;
    let k = [-0.25, 0.05, 0.0, 0.0];
    write("metashape", wall(&Metashape::new(k, [8e-3, -5e-3, 0.4, 0.0])?))?;
    write("fraser", wall(&Fraser::new([0.28, 0.0, 0.0], [-8e-3, 5e-3], [0.02, 0.03])?))?;
    write("even_radial", wall(&EvenRadial::new([-0.2, 0.03, 0.0, 0.0])?))?;
    write("thin_prism", wall(&ThinPrism::new(k, p, [0.03, -0.02])?))?;
    let k = [-0.25, 0.05, 0.0, 0.0, 0.0, 0.0];
    let prism = [0.03, 0.0, -0.02, 0.0];
    write("two_stage", wall(&RadialTangentialThinPrism::new(k, p, prism)?))?;

    // The projections: meridians and parallels about the y axis, every 15°.
    write("gnomonic", globe(&[("", &Gnomonic)], 60))?;
    let fisheyes: [(&str, &dyn CentralProjectionView); 4] = [
        ("equidistant", &Fisheye::Equidistant),
        ("stereographic", &Fisheye::Stereographic),
        ("equisolid", &Fisheye::Equisolid),
        ("orthographic", &Fisheye::Orthographic),
    ];
    write("fisheye", globe(&fisheyes, 90))?;
    write("field_of_view", globe(&[("", &FieldOfView::new(1.2)?)], 80))?;
    write("division", globe(&[("", &Division::new(-0.35)?)], 110))?;
    write("unified", globe(&[("", &UnifiedSphere::new(0.9)?)], 110))?;
    write("enhanced_unified", globe(&[("", &EnhancedUnified::new(0.6, 1.1)?)], 110))?;
    write("double_sphere", globe(&[("", &DoubleSphere::new(-0.2, 0.6)?)], 110))?;
    let panoramas: [(&str, &dyn CentralProjectionView); 2] =
        [("equirectangular", &Panorama::Equirectangular), ("cylindrical", &Panorama::Cylindrical)];
    write("panorama", globe(&panoramas, 180))?;

    // The scanning cameras: a field of squares, flown over upwards in the figure.
    write("scanning", scans()?)?;

    // Polynomials in place of a projection, and a projection without a centre.
    write("rpc", rational()?)?;
    write("parallel", parallel()?)?;

    // The display side: a dome's own grid, as it is drawn for the eye, and as a projector has to show it.
    write("output_models", domes()?)?;
    Ok(())
}

/// Azimuths and heights of a dome, every 15°: for an eye in its middle, for one beside it, and pre-warped for a projector below
/// the rim in front. The dashed lines are the projector's frame.
fn domes() -> Result<String, Failure> {
    let dome = Dome::new(Point3::origin(), 1.0, Vector3::z(), FRAC_PI_2)?;
    let up = |eye: Point3<f64>| ExteriorOrientation::look_at(eye, eye + Vector3::z(), Vector3::y());
    let interior = InteriorOrientation::from_dome_master(2.0, PI)?;
    let interior = InteriorOrientation::new(interior.principal_distance(), Point2::origin(), 0.0)?;
    let fisheye = CentralCamera::ideal(interior, Fisheye::Equidistant);
    let middle = Frame::new(up(Point3::origin())?, fisheye);
    let beside = Frame::new(up(Point3::new(0.45, 0.2, 0.1))?, fisheye);
    let place = Point3::new(0.0, -0.9, -0.15);
    let pose = ExteriorOrientation::look_at(place, Point3::new(0.0, 0.25, 1.0), Vector3::z())?;
    let lens = InteriorOrientation::new([1.0; 2], Point2::origin(), 0.0)?;
    let projector = Frame::new(pose, lens);
    // Half the frame: 16 to 10, as wide as the lens is long.
    let frame = [0.8, 0.5];
    let grid = |point: &dyn Fn(Point3<f64>) -> Option<Point2<f64>>| -> Vec<Line> {
        let at = |azimuth: f64, height: f64| {
            let ((s, c), (z, level)) = (azimuth.sin_cos(), height.sin_cos());
            point(Point3::new(level * s, level * c, z))
        };
        let rings = samples(0.0, 75.0, 5)
            .map(|h| samples(0.0, 360.0, 72).map(|a| at(a.to_radians(), h.to_radians())).collect());
        let rays = samples(0.0, 345.0, 23)
            .map(|a| samples(0.0, 75.0, 15).map(|h| at(a.to_radians(), h.to_radians())).collect());
        rings.chain(rays).collect()
    };
    let shown = |p: Point3<f64>| {
        let pixel = projector.project(&p).ok()?;
        // Only what the projector's light falls on first.
        let lit = projector.ground(&pixel, &dome).ok()?;
        let inside = (0..2).all(|i| pixel[i].abs() <= frame[i]);
        (inside && (lit - p).norm() < 1e-6).then_some(pixel)
    };
    let [w, h] = frame;
    let corners = [[-w, -h], [w, -h], [w, h], [-w, h], [-w, -h]];
    let edge = corners.map(|c| Some(Point2::from(c))).to_vec();
    let of = |caption, ideal, lines| Panel { caption, ideal, lines };
    Ok(drawing(&[
        of("dome master", vec![], grid(&|p| middle.project(&p).ok())),
        of("for an eye beside the middle", vec![], grid(&|p| beside.project(&p).ok())),
        of("pre-warped for a projector", vec![edge], grid(&shown)),
    ]))
}

/// From 1 above the origin, looking down, y of the picture along the flight: with a velocity along y and polynomials of the
/// attitude in the time from −1 to 1.
fn flight(
    velocity: f64,
    attitude: &[[f64; 3]],
) -> Result<PolynomialTrajectory<ExteriorOrientation>, Failure> {
    let above =
        ExteriorOrientation::look_at(Point3::new(0.0, 0.0, 1.0), Point3::origin(), -Vector3::y())?;
    let position = vec![Vector3::zeros(), Vector3::new(0.0, velocity, 0.0)];
    let attitude = attitude.iter().map(|w| Vector3::from(*w)).collect();
    Ok(PolynomialTrajectory::new(above, 0.0, 1.0, position, attitude)?)
}

/// Each scanning camera's picture of a field of squares.
fn scans() -> Result<String, Failure> {
    let unit = |f: f64, y: f64| InteriorOrientation::new([f; 2], Point2::new(0.0, y), 0.0);
    let lines = ScanTime::by_line(0.0, 1.0, [-3.0, 3.0])?;
    let still = [[0.0; 3]];
    // A roll and a turn that grow, as in a gust.
    let gust = [[0.0; 3], [0.0, 0.12, 0.1], [0.0; 3], [0.0, -0.2, 0.0]];
    let pushbroom = Scanner::line_scan(unit(1.0, 0.0)?, flight(1.0, &gust)?, 0.0, lines)?;
    let columns = ScanTime::by_column(0.0, 0.8, [-1.4, 1.4])?;
    let none = ImageMotionCompensation::default();
    let panorama = Scanner::panoramic(unit(1.0, 0.0)?, none, flight(0.0, &still)?, columns)?;
    let moving = flight(0.35, &still)?;
    let compensated =
        Scanner::panoramic(unit(1.0, 0.0)?, ImageMotionCompensation::new(0.28)?, moving, columns)?;
    let pixels = ScanTime::by_pixel(0.0, 0.02, 1.0, [[-1.4, 1.4], [-3.0, 3.0]])?;
    let whiskbroom = Scanner::whiskbroom(unit(1.0, 0.0)?, 0.0, flight(1.0, &still)?, pixels)?;
    let spin = [[0.0; 3], [0.05, 0.1, 0.25]];
    let shutter = Scanner::frame_scan(unit(1.0, 0.0)?, flight(0.3, &spin)?, lines)?;
    let of = |caption, sensor: &dyn SensorModel| {
        let point = |x: f64, y: f64| {
            sensor.project(&Point3::new(-x, y, 0.0)).ok().map(|p| Point2::new(p.x, -p.y))
        };
        Panel { caption, ideal: vec![], lines: field(&point) }
    };
    Ok(drawing(&[
        of("pushbroom in a gust", &pushbroom),
        of("panoramic", &panorama),
        of("moving, compensated", &compensated),
        of("whiskbroom", &whiskbroom),
        of("rolling shutter, turning", &shutter),
    ]))
}

/// A field of squares through a rational polynomial camera, at the lowest height (dashed) and the highest. Cubic terms are those of a strong
/// lens and a rough orbit.
fn rational() -> Result<String, Failure> {
    let polynomial = |terms: &[(usize, f64)]| {
        let mut coefficients = [0.0; 20];
        for (k, c) in terms {
            coefficients[*k] = *c;
        }
        coefficients
    };
    // L, P, H are terms 1 to 3; L³, P³, L²P and LP² are 11, 15, 14 and 12.
    let rpc = Rpc::from_rpc00b(&Rpc00b {
        line_offset: -0.5,
        sample_offset: -0.5,
        line_scale: 1.0,
        sample_scale: 1.0,
        latitude_offset_deg: 0.0,
        longitude_offset_deg: 0.0,
        height_offset: 0.0,
        latitude_scale_deg: 1.0,
        longitude_scale_deg: 1.0,
        height_scale: 1.0,
        line_numerator: polynomial(&[(1, 0.1), (2, -1.0), (3, 0.05), (15, 0.12), (14, 0.05)]),
        line_denominator: polynomial(&[(0, 1.0), (2, 0.06), (3, -0.03)]),
        sample_numerator: polynomial(&[(1, 1.0), (2, 0.12), (3, 0.12), (11, -0.06), (12, -0.05)]),
        sample_denominator: polynomial(&[(0, 1.0), (1, 0.04), (3, -0.03)]),
        error_bias: None,
        error_random: None,
    })?;
    let at = |height: f64| {
        let point = |x: f64, y: f64| {
            rpc.project_degrees(0.9 * y / 0.75, 0.9 * x / 1.5, EllipsoidalHeight(height)).ok()
        };
        field(&point)
    };
    Ok(drawing(&[Panel { caption: "", ideal: at(-0.9), lines: at(0.9) }]))
}

/// A field of squares and the block above it, seen without a centre: parallel lines stay parallel.
fn parallel() -> Result<String, Failure> {
    let pose =
        ExteriorOrientation::look_at(Point3::new(2.0, -3.0, 3.0), Point3::origin(), Vector3::z())?;
    let screen = Orthographic::new(pose, Affine2::identity())?;
    let at = |height: f64| {
        let point = |x: f64, y: f64| screen.project(&Point3::new(x, y, height)).ok();
        field(&point)
    };
    Ok(drawing(&[Panel { caption: "", ideal: at(0.5), lines: at(0.0) }]))
}

/// The lines of a field of squares, three wide and one and a half along the flight.
fn field(point: &dyn Fn(f64, f64) -> Option<Point2<f64>>) -> Vec<Line> {
    let across =
        samples(-1.5, 1.5, 12).map(|x| samples(-0.75, 0.75, 30).map(|y| point(x, y)).collect());
    let along =
        samples(-0.75, 0.75, 6).map(|y| samples(-1.5, 1.5, 60).map(|x| point(x, y)).collect());
    across.chain(along).collect()
}

/// The half of a projection that is drawn, as an object.
trait CentralProjectionView {
    fn point(&self, direction: &Vector3<f64>) -> Option<Point2<f64>>;
}

impl<P: CentralProjection> CentralProjectionView for P {
    fn point(&self, direction: &Vector3<f64>) -> Option<Point2<f64>> {
        self.plane(direction).ok()
    }
}

/// A line with gaps where there is no point.
type Line = Vec<Option<Point2<f64>>>;

fn samples(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| from + (to - from) * f64::from(i) / f64::from(count))
}

/// A wall of squares through a lens, over the same wall without it.
fn wall(lens: &impl Distortion) -> String {
    let through = |x: f64, y: f64| lens.distort(&Point2::new(x, y)).ok();
    let straight = |x: f64, y: f64| NoDistortion.distort(&Point2::new(x, y)).ok();
    let grid = |point: &dyn Fn(f64, f64) -> Option<Point2<f64>>, count| -> Vec<Line> {
        let columns = samples(-0.9, 0.9, 12)
            .map(|x| samples(-0.6, 0.6, count).map(|y| point(x, y)).collect());
        let rows =
            samples(-0.6, 0.6, 8).map(|y| samples(-0.9, 0.9, count).map(|x| point(x, y)).collect());
        columns.chain(rows).collect()
    };
    let panel = Panel { caption: "", ideal: grid(&straight, 1), lines: grid(&through, 24) };
    drawing(&[panel])
}

/// Meridians and parallels within an angle of the axis.
fn globe(projections: &[(&'static str, &dyn CentralProjectionView)], degrees: i32) -> String {
    let panels: Vec<Panel> = projections
        .iter()
        .map(|(caption, projection)| {
            let point = |longitude: f64, latitude: f64| {
                let ((s, c), (up, level)) = (longitude.sin_cos(), latitude.sin_cos());
                let direction = Vector3::new(level * s, up, level * c);
                let inside = direction.z >= f64::from(degrees).to_radians().cos() - 1e-9;
                projection.point(&direction).filter(|_| inside)
            };
            // Where a projection ends or tears, so do the lines.
            let (east, north) = (f64::from(degrees.min(179)), f64::from(degrees.min(75)));
            let (east, north) = (east.to_radians(), north.to_radians());
            let step = 15f64.to_radians();
            let lines_of = |most: f64| {
                (-12..=12)
                    .map(f64::from)
                    .map(move |i| i * step)
                    .filter(move |a| a.abs() <= most + 1e-9)
            };
            let meridians =
                lines_of(east).map(|l| samples(-north, north, 20).map(|b| point(l, b)).collect());
            let parallels =
                lines_of(north).map(|b| samples(-east, east, 40).map(|l| point(l, b)).collect());
            Panel { caption, ideal: vec![], lines: meridians.chain(parallels).collect() }
        })
        .collect();
    drawing(&panels)
}

struct Panel {
    caption: &'static str,
    ideal: Vec<Line>,
    lines: Vec<Line>,
}

/// The panels side by side, each scaled to its place.
fn drawing(panels: &[Panel]) -> String {
    let width = SIZE[0] * if panels.len() > 1 { 2.0 } else { 1.0 };
    let place = [width / panels.len() as f64, SIZE[1]];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {}\" width=\"{width}\" role=\"img\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"none\" stroke=\"currentColor\">\n",
        SIZE[1]
    );
    for (i, panel) in panels.iter().enumerate() {
        let all = || panel.ideal.iter().chain(&panel.lines).flatten().flatten();
        let reach = |axis: usize| all().map(|p| p[axis].abs()).fold(1e-9, f64::max);
        let room = |axis: usize| 0.5 * place[axis] - MARGIN - if axis == 1 { 8.0 } else { 0.0 };
        let scale = (room(0) / reach(0)).min(room(1) / reach(1));
        let middle = [place[0] * (i as f64 + 0.5), 0.5 * place[1] - 8.0];
        let path = |lines: &[Line]| {
            let mut d = String::new();
            for line in lines {
                let mut pen_down = false;
                for point in line {
                    if let Some(p) = point {
                        let at = [0, 1].map(|axis| middle[axis] + scale * p[axis]);
                        let command = if pen_down { 'L' } else { 'M' };
                        let _ = write!(d, "{command}{:.1} {:.1}", at[0], at[1]);
                    }
                    pen_down = point.is_some();
                }
            }
            d
        };
        if !panel.ideal.is_empty() {
            let _ = writeln!(
                svg,
                "<path stroke-opacity=\".35\" stroke-dasharray=\"3 3\" d=\"{}\"/>",
                path(&panel.ideal)
            );
        }
        let _ = writeln!(svg, "<path stroke=\"#48e\" d=\"{}\"/>", path(&panel.lines));
        if !panel.caption.is_empty() {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" stroke=\"none\" fill=\"currentColor\">{}</text>",
                middle[0],
                SIZE[1] - 6.0,
                panel.caption
            );
        }
    }
    svg.push_str("</svg>\n");
    svg
}
