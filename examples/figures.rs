//! The subjects of the sources' figures, drawn by the crate itself.
//!
//! `cargo run --release --example figures -- [FOLDER]` writes them to FOLDER, or to `target/figures`.
//!
//! | file | source | subject |
//! | --- | --- | --- |
//! | `texture_mapping_geometry.svg` | Weinhaus & Devarajan 1997, figure 1 | texture, object and screen space |
//! | `original.png`, `linear.png`, `bilinear.png`, `perspective.png` | the same, figure 2 | three ways to fill a quadrilateral |
//! | `projected_texture.svg` | Segal et al. 1992, figure 1 | a slide on a surface, seen from elsewhere |
//! | `light_and_clip.svg` | the same, figure 2 | a segment in the light's and the viewer's coordinates |

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use collinear::camera::{
    ExteriorOrientation, Frame, InteriorOrientation, Orthographic, SensorModel,
};
use collinear::geometry::projection::texture::{light_from_clip, texture_from_light};
use collinear::geometry::projection::{ClipConvention, DepthRange, Projection, Viewport};
use collinear::geometry::{Affine2, Locus, Plane};
use collinear::mapping::Map;
use collinear::mapping::span::{Span, SpanEnd};
use collinear::nalgebra::{Point2, Point3, Rotation3, Vector2, Vector3, Vector4};
use collinear::resample::{Border, Filter, ImageView, ImageViewMut};
use collinear::texturer::{
    Canvas, Paint, ScreenPolygon, bilinear_quad, from_vertices, linear_triangles,
};

type Failure = Box<dyn Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map_or_else(|| "target/figures".into(), PathBuf::from);
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("texture_mapping_geometry.svg"), texture_mapping_geometry()?)?;
    fs::write(folder.join("projected_texture.svg"), projected_texture()?)?;
    fs::write(folder.join("light_and_clip.svg"), light_and_clip()?)?;
    ways_to_fill_a_quadrilateral(&folder)
}

const DARK: &str = "#222";
const RED: &str = "#d33";
const BLUE: &str = "#26c";
const GREEN: &str = "#183";

/// An SVG document that grows element by element.
struct Drawing(String);

impl Drawing {
    fn new(width: u32, height: u32, title: &str) -> Self {
        Self(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             font-family=\"sans-serif\" font-size=\"13\">\n<title>{title}</title>\n\
             <path d=\"M0 0h{width}v{height}H0z\" fill=\"#fff\"/>\n"
        ))
    }

    fn path(&mut self, points: &[Point2<f64>], end: &str, style: &str) {
        let line: Vec<String> = points.iter().map(|p| format!("{:.1} {:.1}", p.x, p.y)).collect();
        let _ = writeln!(self.0, "<path d=\"M{}{end}\" {style}/>", line.join("L"));
    }

    fn polygon(&mut self, corners: &[Point2<f64>], color: &str, opacity: f64) {
        let style = format!("stroke=\"{color}\" fill=\"{color}\" fill-opacity=\"{opacity}\"");
        self.path(corners, "z", &style);
    }

    fn line(&mut self, a: Point2<f64>, b: Point2<f64>, color: &str, dashes: &str) {
        let style = format!("stroke=\"{color}\" fill=\"none\" stroke-dasharray=\"{dashes}\"");
        self.path(&[a, b], "", &style);
    }

    fn arrow(&mut self, a: Point2<f64>, b: Point2<f64>, color: &str) {
        self.line(a, b, color, "none");
        let back = (a - b).normalize() * 8.0;
        let side = Vector2::new(-back.y, back.x) * 0.4;
        let style = format!("fill=\"{color}\"");
        self.path(&[b, b + back + side, b + back - side], "z", &style);
    }

    fn dot(&mut self, p: Point2<f64>, color: &str) {
        let _ = writeln!(
            self.0,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"{color}\"/>",
            p.x, p.y
        );
    }

    fn text(&mut self, p: Point2<f64>, (dx, dy): (f64, f64), text: &str, color: &str) {
        let (x, y) = (p.x + dx, p.y + dy);
        let _ = writeln!(self.0, "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{color}\">{text}</text>");
    }

    fn finish(self) -> String {
        self.0 + "</svg>\n"
    }
}

/// A parallel view of space, as textbooks draw it: `scale` pixels a unit, `target` at `at`.
fn oblique(
    from: Vector3<f64>,
    target: Point3<f64>,
    scale: f64,
    at: [f64; 2],
) -> Result<Orthographic, Failure> {
    let exterior = ExteriorOrientation::look_at(target - from * 10.0, target, Vector3::z())?;
    let affine = Affine2::from_coefficients([at[0], scale, 0.0], [at[1], 0.0, scale]);
    Ok(Orthographic::new(exterior, affine)?)
}

/// The point of a camera's line of sight at a depth before it: where its picture stands in space.
fn in_picture(
    camera: &Frame<InteriorOrientation>,
    image: Point2<f64>,
    depth: f64,
) -> Result<Point3<f64>, Failure> {
    let axis = camera.exterior.camera_from_world().inverse() * Vector3::z();
    match camera.locus(&image)? {
        Locus::Ray(ray) => Ok(ray.at(depth / ray.direction.dot(&axis))),
        _ => Err("a frame camera has rays".into()),
    }
}

fn look_at(
    from: [f64; 3],
    to: [f64; 3],
    distance: f64,
    size: [f64; 2],
) -> Result<Frame<InteriorOrientation>, Failure> {
    let exterior = ExteriorOrientation::look_at(from.into(), to.into(), Vector3::z())?;
    let middle = Point2::new(0.5 * size[0], 0.5 * size[1]);
    Ok(Frame::new(exterior, InteriorOrientation::new([distance; 2], middle, 0.0)?))
}

fn rectangle(size: [f64; 2]) -> [Point2<f64>; 4] {
    let [w, h] = size;
    [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(Point2::from)
}

/// The lines of a grid of `n` by `m` cells on a rectangle, as pairs of ends.
fn grid([w, h]: [f64; 2], n: u32, m: u32) -> Vec<[Point2<f64>; 2]> {
    let column = |i| {
        let x = w * f64::from(i) / f64::from(n);
        [Point2::new(x, 0.0), Point2::new(x, h)]
    };
    let row = |j| {
        let y = h * f64::from(j) / f64::from(m);
        [Point2::new(0.0, y), Point2::new(w, y)]
    };
    (1..n).map(column).chain((1..m).map(row)).collect()
}

fn all<T, U>(items: &[T], f: impl Fn(&T) -> Result<U, Failure>) -> Result<Vec<U>, Failure> {
    items.iter().map(f).collect()
}

/// [WD] figure 1: from the texture to the object and from the object to the screen.
fn texture_mapping_geometry() -> Result<String, Failure> {
    let (texture_size, screen_size) = ([160.0, 120.0], [200.0, 160.0]);
    // A wall over the x axis, the texture laid on it: u along x, v down.
    let wall = |t: &Point2<f64>| Point3::new(t.x / 40.0, 0.0, 3.0 - t.y / 40.0);
    let eye = look_at([7.5, -6.0, 2.2], [2.2, 0.0, 1.5], 240.0, screen_size)?;
    let corners = rectangle(texture_size).map(|c| wall(&c));
    let coordinates = rectangle(texture_size).map(|c| Vector3::new(c.x, c.y, 1.0));
    let map = from_vertices(&corners, &coordinates, &eye.homogeneous())?;

    let mut d = Drawing::new(860, 330, "Texture-mapping geometry");
    let view =
        oblique(Vector3::new(0.5, 1.0, -0.55), Point3::new(3.0, -2.0, 1.0), 37.0, [400.0, 190.0])?;
    let space = |p: &Point3<f64>| Ok::<_, Failure>(view.project(p)?);
    let left = Vector2::new(24.0, 70.0);
    let right = Vector2::new(636.0, 50.0);
    // Texture space.
    d.polygon(&rectangle(texture_size).map(|p| p + left), BLUE, 0.1);
    // The screen, and its place before the eye.
    d.polygon(&rectangle(screen_size).map(|p| p + right), RED, 0.04);
    let depth = 3.2;
    let placed = all(&rectangle(screen_size), |p| space(&in_picture(&eye, *p, depth)?))?;
    d.polygon(&all(&corners, space)?, BLUE, 0.1);
    let seen = all(&corners, |c| Ok(eye.project(c)?))?;
    d.polygon(&seen.iter().map(|p| p + right).collect::<Vec<_>>(), BLUE, 0.1);
    for [a, b] in grid(texture_size, 8, 6)
        .into_iter()
        .chain([rectangle(texture_size)].iter().map(|[a, _, c, _]| [*a, *c]))
    {
        let diagonal = a.x != b.x && a.y != b.y;
        let color = if diagonal { RED } else { BLUE };
        d.line(a + left, b + left, color, "none");
        d.line(space(&wall(&a))?, space(&wall(&b))?, color, "none");
        let ends = [eye.project(&wall(&a))?, eye.project(&wall(&b))?];
        d.line(ends[0] + right, ends[1] + right, color, "none");
        // Equation 1 takes the screen's points back to the texture's.
        if (map.at(&ends[0])? - a).norm() > 1e-9 || (map.at(&ends[1])? - b).norm() > 1e-9 {
            return Err("equation 1 does not return to the texture".into());
        }
    }
    for c in &corners {
        let image = in_picture(&eye, eye.project(c)?, depth)?;
        d.line(space(&eye.exterior.projection_center())?, space(c)?, "#999", "3 3");
        d.dot(space(&image)?, RED);
    }
    d.polygon(&placed, RED, 0.12);
    let eye_at = space(&eye.exterior.projection_center())?;
    d.dot(eye_at, DARK);
    d.text(eye_at, (-10.0, 20.0), "eye", DARK);
    let origin = space(&Point3::origin())?;
    for (axis, name, by) in [
        (Vector3::x(), "X", (4.0, 14.0)),
        (Vector3::y(), "Y", (-10.0, -4.0)),
        (Vector3::z() * 4.0, "Z", (5.0, 6.0)),
    ] {
        let length = if axis.x > 0.0 {
            5.2
        } else if axis.y > 0.0 {
            1.6
        } else {
            1.0
        };
        let tip = space(&(Point3::origin() + axis * length))?;
        d.arrow(origin, tip, DARK);
        d.text(tip, by, name, DARK);
    }
    let at = Point2::new;
    d.arrow(at(24.0, 70.0), at(204.0, 70.0), DARK);
    d.text(at(206.0, 66.0), (0.0, 0.0), "u", DARK);
    d.arrow(at(24.0, 70.0), at(24.0, 212.0), DARK);
    d.text(at(10.0, 214.0), (0.0, 0.0), "v", DARK);
    d.arrow(at(636.0, 50.0), at(852.0, 50.0), DARK);
    d.text(at(846.0, 42.0), (0.0, 0.0), "S", DARK);
    d.arrow(at(636.0, 50.0), at(636.0, 226.0), DARK);
    d.text(at(622.0, 226.0), (0.0, 0.0), "L", DARK);
    d.text(at(24.0, 34.0), (0.0, 0.0), "texture (input) space", DARK);
    d.text(at(300.0, 34.0), (0.0, 0.0), "object space", DARK);
    d.text(at(636.0, 34.0), (0.0, 0.0), "screen (output) space", DARK);
    d.arrow(at(196.0, 262.0), at(318.0, 262.0), BLUE);
    d.arrow(at(318.0, 262.0), at(196.0, 262.0), BLUE);
    d.text(at(196.0, 282.0), (0.0, 0.0), "object–texture: affine", BLUE);
    d.arrow(at(520.0, 262.0), at(642.0, 262.0), RED);
    d.arrow(at(642.0, 262.0), at(520.0, 262.0), RED);
    d.text(at(500.0, 282.0), (0.0, 0.0), "object–screen: perspective", RED);
    let [p, q, r] = map.coefficients();
    let form = |[a, b, c]: [f64; 3]| {
        let term = |v: f64| format!("{} {:.5}", if v < 0.0 { '−' } else { '+' }, v.abs());
        format!("{:.3} {} S {} L", a / r[0], term(b / r[0]), term(c / r[0]))
    };
    let equation = format!("concatenated: u = ({}) / ({})", form(p), form(r));
    d.text(at(24.0, 304.0), (0.0, 0.0), &equation.replace('-', "−"), DARK);
    let equation = format!("v = ({}) / ({})", form(q), form(r));
    d.text(at(111.0, 322.0), (0.0, 0.0), &equation.replace('-', "−"), DARK);
    Ok(d.finish())
}

/// [S] figure 1: a slide is projected onto a floor; the eye sees the floor on its screen.
fn projected_texture() -> Result<String, Failure> {
    let (slide_size, screen_size) = ([40.0, 30.0], [160.0, 120.0]);
    let light = look_at([-1.2, 2.4, 4.0], [1.1, 2.0, 0.0], 44.0, slide_size)?;
    let eye = look_at([8.6, -4.4, 3.4], [1.6, 2.0, 0.0], 190.0, screen_size)?;
    let floor = Plane::from_point_and_normal(Point3::origin(), Vector3::z())?;

    let mut d = Drawing::new(570, 400, "Viewing a projected texture");
    let view =
        oblique(Vector3::new(-0.45, 1.0, -0.6), Point3::new(2.4, 0.6, 1.6), 48.0, [290.0, 210.0])?;
    let space = |p: &Point3<f64>| Ok::<_, Failure>(view.project(p)?);
    let (slide_depth, screen_depth) = (1.2, 3.4);
    let ground = [(-1.6, -0.2), (4.6, -0.2), (4.6, 4.4), (-1.6, 4.4)];
    d.polygon(&all(&ground, |(x, y)| space(&Point3::new(*x, *y, 0.0)))?, "#777", 0.1);
    let lit = all(&rectangle(slide_size), |c| Ok(light.ground(c, &floor)?))?;
    d.polygon(&all(&lit, space)?, GREEN, 0.2);
    let (light_at, eye_at) =
        (space(&light.exterior.projection_center())?, space(&eye.exterior.projection_center())?);
    for (corner, point) in rectangle(slide_size).iter().zip(&lit) {
        d.line(light_at, space(&in_picture(&light, *corner, slide_depth)?)?, GREEN, "none");
        d.line(light_at, space(point)?, GREEN, "4 4");
        d.line(space(point)?, eye_at, RED, "4 4");
    }
    let on_screen = all(&lit, |p| Ok(eye.project(p)?))?;
    let placed = |p: &Point2<f64>| space(&in_picture(&eye, *p, screen_depth)?);
    d.polygon(&all(&rectangle(screen_size), placed)?, RED, 0.08);
    d.polygon(&all(&on_screen, placed)?, GREEN, 0.25);
    let slide = |p: &Point2<f64>| space(&in_picture(&light, *p, slide_depth)?);
    d.polygon(&all(&rectangle(slide_size), slide)?, GREEN, 0.2);
    for [a, b] in grid(slide_size, 4, 3) {
        let ends = [light.ground(&a, &floor)?, light.ground(&b, &floor)?];
        d.line(slide(&a)?, slide(&b)?, GREEN, "none");
        d.line(space(&ends[0])?, space(&ends[1])?, GREEN, "none");
        d.line(placed(&eye.project(&ends[0])?)?, placed(&eye.project(&ends[1])?)?, GREEN, "none");
    }
    d.dot(light_at, DARK);
    d.text(light_at, (-38.0, 4.0), "light", DARK);
    d.dot(eye_at, DARK);
    d.text(eye_at, (8.0, 4.0), "eye", DARK);
    d.text(slide(&Point2::new(slide_size[0], 0.0))?, (14.0, -4.0), "slide: the texture", GREEN);
    d.text(space(&Point3::new(-1.6, 4.4, 0.0))?, (4.0, -6.0), "surface", DARK);
    d.text(placed(&Point2::new(0.0, screen_size[1]))?, (-14.0, 18.0), "screen", RED);
    Ok(d.finish())
}

/// [S] figure 2: the middle of a segment on the screen is not its middle in space.
fn light_and_clip() -> Result<String, Failure> {
    let convention = ClipConvention::OpenGl;
    let depth = DepthRange::new(0.5, 20.0)?;
    // Everything in the plane y = 0 of the eye's camera axes.
    let eye = Projection::from_field_of_view(84f64.to_radians(), 1.0, depth)?;
    let light = Projection::from_field_of_view(60f64.to_radians(), 1.0, depth)?;
    let place = ExteriorOrientation::look_at(
        Point3::new(4.9, 0.0, 1.5),
        Point3::new(0.5, 0.0, 4.5),
        -Vector3::y(),
    )?;
    let clip_from_world = eye.clip_from_camera(convention);
    let light_from_world = light.clip_from_camera(convention) * place.pose().to_matrix();
    let m = light_from_clip(&light_from_world, &clip_from_world)?; // equation 5
    let ends = [Point3::new(-1.7, 0.0, 2.6), Point3::new(2.3, 0.0, 5.7)];
    let clip = ends.map(|q| clip_from_world * q.to_homogeneous());
    let in_light = clip.map(|q| m * q);
    let window = Viewport::new(0.0, 0.0, 640.0, 640.0)?;
    let pixels = [
        window.window_from_clip(convention, &clip[0])?.x,
        window.window_from_clip(convention, &clip[1])?.x,
    ];
    let end = |i: usize| SpanEnd::light(pixels[i], clip[i].w, [in_light[i].x], in_light[i].w);
    let span = Span::between(&end(0), &end(1))?;
    // The pixel nearest to the middle of the segment on the screen, tˢ, and t by A = a w₂, B = b w₁.
    let x = (0.5 * (pixels[0] + pixels[1])) as i32;
    let ts = (f64::from(x) + 0.5 - pixels[0]) / (pixels[1] - pixels[0]);
    let (big_a, big_b) = ((1.0 - ts) * clip[1].w, ts * clip[0].w);
    let t = big_b / (big_a + big_b);
    let q: Vector4<f64> = clip[0] * (1.0 - t) + clip[1] * t;
    let world = ends[0] + (ends[1] - ends[0]) * t;
    let [texture] = span.at(x)?; // equation 7
    if (texture - texture_from_light(&(m * q))?.x).abs() > 1e-12 {
        return Err("equation 7 is not equation 6".into());
    }
    let xt = in_light.map(|q| q.x / q.w);
    let linear = xt[0] + ts * (xt[1] - xt[0]);

    let mut d = Drawing::new(560, 420, "Object geometry in the light and clip coordinate systems");
    let plan = |p: &Point3<f64>| Point2::new(160.0 + 66.0 * p.x, 390.0 - 62.0 * p.z);
    let (screen_depth, slide_depth) = (1.7, 2.0);
    let on_screen =
        |s: f64| Point3::new(s * 42f64.to_radians().tan() * screen_depth, 0.0, screen_depth);
    let on_slide = |s: f64| {
        let offset = s * 30f64.to_radians().tan() * slide_depth;
        place.pose().apply_inverse(&Point3::new(offset, 0.0, slide_depth))
    };
    let (eye_at, light_at) = (Point3::origin(), place.projection_center());
    d.line(plan(&on_screen(-1.0)), plan(&on_screen(1.0)), RED, "none");
    d.line(plan(&on_slide(-1.0)), plan(&on_slide(1.0)), GREEN, "none");
    let screen_x = |pixel: f64| pixel / 320.0 - 1.0;
    let marks = [
        (ends[0], pixels[0], xt[0], "1"),
        (ends[1], pixels[1], xt[1], "2"),
        (world, f64::from(x) + 0.5, texture, ""),
    ];
    for (point, pixel, slide, index) in marks {
        let (s, l) = (plan(&on_screen(screen_x(pixel))), plan(&on_slide(slide)));
        d.line(plan(&eye_at), plan(&point), RED, "4 4");
        d.line(plan(&light_at), plan(&point), GREEN, "4 4");
        d.dot(s, RED);
        d.dot(l, GREEN);
        let sub = format!("<tspan font-size=\"9\" dy=\"3\">{index}</tspan>");
        let sup = |n: &str| {
            format!(
                "Q{sub}<tspan font-size=\"9\" dy=\"{}\">{n}</tspan>",
                if index.is_empty() { -8 } else { -9 }
            )
        };
        d.text(s, (-24.0, -6.0), &sup("s"), RED);
        d.text(l, (-30.0, -4.0), &sup("t"), GREEN);
        d.text(plan(&point), (-10.0, -9.0), &format!("Q{sub}"), DARK);
    }
    d.line(plan(&ends[0]), plan(&ends[1]), DARK, "none");
    for point in [ends[0], ends[1], world] {
        d.dot(plan(&point), DARK);
    }
    let _ = writeln!(
        d.0,
        "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\" fill=\"none\" stroke=\"{BLUE}\"/>",
        plan(&on_slide(linear)).x,
        plan(&on_slide(linear)).y
    );
    d.dot(plan(&eye_at), DARK);
    d.text(plan(&eye_at), (8.0, 8.0), "viewpoint, origin of clip coordinates", DARK);
    d.dot(plan(&light_at), DARK);
    d.text(plan(&light_at), (8.0, 14.0), "light", DARK);
    d.text(plan(&on_screen(1.0)), (8.0, 4.0), "screen", RED);
    d.text(plan(&on_slide(1.0)), (8.0, 6.0), "texture", GREEN);
    let at = Point2::new;
    let numbers = format!("tˢ = {ts:.3},  t = {t:.3}");
    d.text(at(16.0, 24.0), (0.0, 0.0), &numbers, DARK);
    let numbers = format!("xᵗ = (xˡ/w) / (wˡ/w) = {texture:.3}").replace('-', "−");
    d.text(at(16.0, 44.0), (0.0, 0.0), &numbers, GREEN);
    let numbers = format!("○ linear in tˢ: {linear:.3}").replace('-', "−");
    d.text(at(16.0, 64.0), (0.0, 0.0), &numbers, BLUE);
    Ok(d.finish())
}

const SIDE: usize = 960;
/// Samples a pixel along each axis.
const FINE: usize = 3;
const PANEL: [usize; 2] = [360, 230];

/// Rows of the letters A to D, five bits each.
const LETTERS: [[u8; 7]; 4] = [
    [0x0e, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11],
    [0x1e, 0x11, 0x11, 0x1e, 0x11, 0x11, 0x1e],
    [0x0e, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0e],
    [0x1e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x1e],
];

/// A grid of eight by eight cells with a letter in each quarter and both diagonals.
fn texture() -> Vec<u8> {
    let color = |x: usize, y: usize| -> [u8; 3] {
        let near = |a: usize, b: usize, width: usize| a.abs_diff(b) < width;
        if near(x, y, 7) {
            return [210, 50, 50];
        }
        if near(x + y, SIDE - 1, 7) {
            return [40, 100, 210];
        }
        let cell = SIDE / 8;
        let rim = 10..SIDE - 10;
        let line = |v: usize| !(4..cell - 4).contains(&(v % cell)) || !rim.contains(&v);
        if line(x) || line(y) {
            return [60, 60, 60];
        }
        let half = SIDE / 2;
        let (column, row) = ((x % half) * 8 / half, (y % half) * 10 / half);
        let letter = LETTERS.get(2 * (y / half) + x / half);
        let bits = row.checked_sub(1).and_then(|r| letter?.get(r)).copied().unwrap_or(0);
        let inked = (1..6).contains(&column) && bits >> (5 - column) & 1 == 1;
        if inked { [190, 205, 190] } else { [252, 250, 244] }
    };
    (0..SIDE * SIDE).flat_map(|i| color(i % SIDE, i / SIDE)).collect()
}

/// A polygon on the screen and where it looks in its texture.
type Piece<'a> = (&'a ScreenPolygon, &'a dyn Map);

/// [WD] figure 2: linearly over two triangles, bilinearly, in perspective.
fn ways_to_fill_a_quadrilateral(folder: &Path) -> Result<(), Failure> {
    let pixels = texture();
    let image = ImageView::<u8, 3>::new(&pixels, SIDE, SIDE)?;
    let [width, height] = PANEL.map(|side| side * FINE);
    let eye = look_at([-0.9, -2.4, 3.2], [-0.02, 2.2, 0.0], 1080.0, [width as f64, height as f64])?;
    let screen = eye.homogeneous();
    // On the ground, the texture's first line farthest away.
    let world =
        [(-2.0, 5.0), (2.0, 5.0), (2.0, 0.5), (-2.0, 0.5)].map(|(x, y)| Point3::new(x, y, 0.0));
    let side = SIDE as f64;
    let coordinates = rectangle([side; 2]).map(|c| Vector3::new(c.x, c.y, 1.0));
    let exact = from_vertices(&world, &coordinates, &screen)?;
    let polygon = ScreenPolygon::project(&world, &screen, 0.1)?;
    let nearness = screen.nearness(&Plane::fit(&world)?.plane)?;

    let small = Affine2::from_coefficients(
        [0.0, side / height as f64, 0.0],
        [0.0, 0.0, side / height as f64],
    );
    let square = rectangle([height as f64; 2]).map(|c| Point3::new(c.x, c.y, 0.0));
    let flat = Orthographic::new(
        ExteriorOrientation::new(Point3::origin(), Rotation3::identity()),
        Affine2::identity(),
    )?;
    let whole = ScreenPolygon::project(&square, &flat.homogeneous(), 0.1)?;
    let triangles = linear_triangles(&polygon, &exact)?;
    let bilinear = bilinear_quad(&polygon, &exact)?;
    let linear: Vec<Piece> =
        triangles.iter().map(|(piece, map)| (piece, map as &dyn Map)).collect();
    let panels: [(&str, &[Piece]); 4] = [
        ("original.png", &[(&whole, &small)]),
        ("linear.png", &linear),
        ("bilinear.png", &[(&polygon, &bilinear)]),
        ("perspective.png", &[(&polygon, &exact)]),
    ];
    for (name, pieces) in panels {
        let mut fine = vec![255; width * height * 3];
        let mut canvas = Canvas::new(ImageViewMut::<u8, 3>::new(&mut fine, width, height)?);
        for (piece, map) in pieces {
            let (filter, border) = (Filter::Bilinear, Border::Clamp);
            let paint = Paint::Texture { image, map: *map, filter, border };
            canvas.draw(piece, nearness, &paint)?;
        }
        let shown = if name == "original.png" { [PANEL[1]; 2] } else { PANEL };
        write_png(&folder.join(name), shown, &averaged(&fine, shown))?;
    }
    Ok(())
}

/// The means of blocks of `FINE` by `FINE` samples.
fn averaged(fine: &[u8], [width, height]: [usize; 2]) -> Vec<u8> {
    let row = PANEL[0] * FINE * 3;
    let mean = |x: usize, y: usize, c: usize| {
        let samples =
            (0..FINE * FINE).map(|k| (y * FINE + k / FINE) * row + (x * FINE + k % FINE) * 3 + c);
        let sum: usize = samples.filter_map(|i| fine.get(i)).map(|s| usize::from(*s)).sum();
        (sum / (FINE * FINE)) as u8
    };
    (0..width * height * 3).map(|i| mean(i / 3 % width, i / 3 / width, i % 3)).collect()
}

fn write_png(path: &Path, [width, height]: [usize; 2], pixels: &[u8]) -> Result<(), Failure> {
    let file = BufWriter::new(fs::File::create(path)?);
    let mut encoder = png::Encoder::new(file, u32::try_from(width)?, u32::try_from(height)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(())
}
