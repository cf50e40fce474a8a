//! Pix4D: the files of its folder `params`.
//!
//! ```text
//! X' = R (X − t),   x = X'.x/X'.z,   y = X'.y/X'.z,   r² = x² + y²
//! x_d = x (1 + R₁r² + R₂r⁴ + R₃r⁶) + 2 T₁ x y + T₂ (r² + 2x²)
//! y_d = y (1 + R₁r² + R₂r⁴ + R₃r⁶) + 2 T₂ x y + T₁ (r² + 2y²)
//! pixel = (f x_d + cx, f y_d + cy)
//! ```
//! (Pix4D, *How are the internal and external camera parameters defined*; the terms of T₁ and T₂ as in Pix4D/pyopf). R turns the
//! world to x right, y down, z forward, pixels count from the top-left corner of the top-left pixel (Pix4D/opf-spec): this crate's
//! own conventions, and OpenCV's names of the coefficients, p₁ = T₁ and p₂ = T₂.
//!
//! | file | what it says | here |
//! | --- | --- | --- |
//! | `_calibrated_camera_parameters.txt` | size, K, R₁ … R₃, T₁, T₂, t and R of each photograph | [`parse`] |
//! | `_calibrated_external_camera_parameters.txt` | X, Y, Z and ω, φ, κ in degrees, without an interior orientation | [`crate::orientation`] |
//! | `_calibrated_internal_camera_parameters.cam` | f, principal point and distortion in millimetres, for Inpho | [`parse_cam`] |
//! | `_pix4d_calibrated_internal_camera_parameters.cam` | the same in Pix4D's own way | [`parse_cam`] |
//! | `_pmatrix.txt` | P = K (R \| −R t) of each photograph without its distortion | [`parse_pmatrix`] |
//! | `_offset.xyz` | what t and P leave out of the world's coordinates | [`parse_offset`] |
//!
//! `_calibrated_external_camera_parameters.txt` is in the world's coordinates, the camera parameters and the P are not: add the
//! offset to their places.

use std::fmt::Write as _;

use collinear::Frame;
use collinear::nalgebra::{Matrix3x4, Point3};

use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};
use crate::fields::{Fields, at, plain_name};
use crate::json::Document;

/// The lines that say what a photograph's block consists of.
const HEADER: [&str; 7] = [
    "fileName imageWidth imageHeight",
    "camera matrix K [3x3]",
    "radial distortion [3x1]",
    "tangential distortion [2x1]",
    "camera position t [3x1]",
    "camera rotation R [3x3]",
    "camera model m = K [R|-Rt] X",
];

/// Whether text is a list of calibrated camera parameters.
pub(crate) fn is_like(text: &str) -> bool {
    text.trim_start().starts_with("fileName imageWidth imageHeight")
}

/// Whether text is a `.cam` of either kind.
pub(crate) fn is_cam(text: &str) -> bool {
    let start = text.trim_start();
    start.starts_with("camera_calibration_file") || start.starts_with("Pix4D camera calibration")
}

/// Whether text is a list of P.
pub(crate) fn is_pmatrix(text: &str) -> bool {
    let first = text.lines().map(str::trim).find(|l| !l.is_empty()).unwrap_or_default();
    let words: Vec<_> = first.split_whitespace().collect();
    matches!(&words[..], [_, numbers @ ..]
        if numbers.len() == 12 && numbers.iter().all(|w| w.parse::<f64>().is_ok()))
}

fn unsupported(field: String, found: impl Into<String>, expected: &'static str) -> FieldError {
    FieldError::new(field, FieldProblem::Unsupported { found: found.into(), expected })
}

/// The photographs of `_calibrated_camera_parameters.txt`. Their places lack the [offset](parse_offset).
///
/// # Errors
/// [`ErrorKind::Line`] with the line, [`ErrorKind::Field`] for a camera out of its domain. A header of other lines, as a
/// fisheye's, is an error.
///
/// # Example
/// Pix4Dmapper's line of a photograph in `_pmatrix.txt` (test files of EasyIDP) images a point without distortion;
/// its block of parameters, with the distortion taken off, agrees.
///
/// ```
/// use collinear::nalgebra::{Point2, Point3};
///
/// let text = "fileName imageWidth imageHeight\ncamera matrix K [3x3]\nradial distortion [3x1]\n\
///     tangential distortion [2x1]\ncamera position t [3x1]\ncamera rotation R [3x3]\n\
///     camera model m = K [R|-Rt] X\n\nDJI_0954.JPG 4608 3456\n\
///     3952.81247514184087776812 0 2233.46124792750424603582\n0 3952.81247514184087776812 1667.92521335858214115433\n0 0 1\n\
///     0 0 0\n0 0\n21.54872206687879199194 -29.58734160676452162875 30.85702810138878149360\n\
///     0.78389904231994589345 -0.62058396220897726892 -0.01943803742353054573\n\
///     -0.62086105345046738169 -0.78318706257080084043 -0.03390541741516269608\n\
///     0.00581753884797473961 0.03864674463298682638 -0.99923600083815289352\n";
/// let (name, camera) = collinear_io::pix4d::parse(text)?.remove(0);
/// let image = camera.camera()?.sensor().project(&Point3::new(20.0, -25.0, 0.0))?;
/// // (3111.599161 · 20 + 2366.736021 · 25 − 65840.192261)/31.001732, and so on.
/// assert!((image - Point2::new(1792.164, 1465.835)).norm() < 5e-3, "{image}");
/// assert_eq!(name, "DJI_0954.JPG");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse(text: &str) -> Result<Vec<(String, CameraFile)>, Error> {
    let mut lines = Lines::new(text);
    for expected in HEADER {
        let (line, found) = lines.next(1)?;
        if found != expected {
            let found = found.chars().take(40).collect();
            return Err(at(line, None, LineProblem::Version { found, expected }));
        }
    }
    let mut photographs = Vec::new();
    while !lines.is_at_end() {
        let (line, first) = lines.next(3)?;
        let mut words = first.rsplitn(3, char::is_whitespace);
        let (height, width) = (words.next(), words.next());
        let Some(name) = words.next().map(str::trim) else {
            let found = first.split_whitespace().count();
            return Err(at(line, None, LineProblem::FieldCount { found, expected: 3 }));
        };
        let size = |name: &str, text: Option<&str>| -> Result<u32, Error> {
            let text = text.unwrap_or_default();
            text.parse().map_err(|_| {
                let text = text.chars().take(40).collect();
                at(line, None, LineProblem::NotANumber { name: name.into(), text })
            })
        };
        let (width, height) = (size("imageWidth", width)?, size("imageHeight", height)?);
        let k: [[f64; 3]; 3] = lines.rows("K")?;
        let [r1, r2, r3] = lines.numbers("radial distortion")?;
        let [t1, t2] = lines.numbers("tangential distortion")?;
        let projection_center = lines.numbers("t")?;
        let rotation = Rotation::RotationMatrix(lines.rows("R")?);
        let [[fx, skew, cx], [zero, fy, cy], last] = k;
        if zero != 0.0 || last != [0.0, 0.0, 1.0] {
            let found = format!("{zero}, {last:?} below");
            let expected = "the rows (fx, s, cx), (0, fy, cy), (0, 0, 1) are needed";
            return Err(unsupported(format!("{name}.K"), found, expected).into());
        }
        let interior = interior([fx, fy], [cx, cy], skew, [r1, r2, r3], [t1, t2]);
        let exterior = Exterior { projection_center, rotation };
        let camera = CameraFile { width, height, interior, exterior };
        camera.check().map_err(|e| e.under(name))?;
        photographs.push((name.to_owned(), camera));
    }
    Ok(photographs)
}

/// A pinhole where there is no distortion, so that it can become a matrix.
fn interior(
    principal_distance: [f64; 2],
    principal_point: [f64; 2],
    skew: f64,
    k: [f64; 3],
    p: [f64; 2],
) -> Interior {
    if k == [0.0; 3] && p == [0.0; 2] {
        Interior::Pinhole { principal_distance, principal_point, skew }
    } else {
        Interior::Brown { principal_distance, principal_point, skew, k, p }
    }
}

/// The lines of a text that have something in them.
struct Lines<'a> {
    rest: std::iter::Peekable<Box<dyn Iterator<Item = (usize, &'a str)> + 'a>>,
    last: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim()));
        let some: Box<dyn Iterator<Item = _>> = Box::new(lines.filter(|(_, l)| !l.is_empty()));
        Self { rest: some.peekable(), last: 0 }
    }

    fn is_at_end(&mut self) -> bool {
        self.rest.peek().is_none()
    }

    /// The next line, or that the one after the last has not what is expected.
    fn next(&mut self, expected: usize) -> Result<(usize, &'a str), Error> {
        let (line, text) = self.rest.next().ok_or_else(|| {
            at(self.last + 1, None, LineProblem::FieldCount { found: 0, expected })
        })?;
        self.last = line;
        Ok((line, text))
    }

    fn numbers<const N: usize>(&mut self, name: &str) -> Result<[f64; N], Error> {
        let (line, text) = self.next(N)?;
        let fields = Fields::words(line, text);
        fields.count(N)?;
        fields.numbers(0, [name; N])
    }

    fn rows(&mut self, name: &str) -> Result<[[f64; 3]; 3], Error> {
        Ok([self.numbers(name)?, self.numbers(name)?, self.numbers(name)?])
    }
}

/// `_calibrated_camera_parameters.txt` of photographs.
///
/// # Errors
/// [`FieldProblem::Unsupported`] for a camera that is not of Pix4D's perspective model (one principal distance, no skew,
/// Brown's lens or none), and for a name with a space in it, at which readers would end it.
pub fn to_text(photographs: &[(String, CameraFile)]) -> Result<String, Error> {
    let mut text = HEADER.join("\n") + "\n\n";
    for (name, camera) in photographs {
        camera.check().map_err(|e| e.under(name))?;
        plain_name(name, usize::MAX, "Pix4D's names have no blanks and separators: rename it")?;
        let refused = |expected| {
            let found = camera.interior.model();
            Error::from(unsupported(format!("{name}.interior"), found, expected))
        };
        let expected =
            "Pix4D's perspective camera has one focal length, no skew, and Brown's lens or none";
        let (f, [cx, cy], k, p) = match camera.interior.plain([camera.width, camera.height]) {
            Interior::Pinhole { principal_distance: [f, g], principal_point, skew: 0.0 }
                if f == g =>
            {
                (f, principal_point, [0.0; 3], [0.0; 2])
            }
            Interior::Brown { principal_distance: [f, g], principal_point, skew: 0.0, k, p }
                if f == g =>
            {
                (f, principal_point, k, p)
            }
            _ => return Err(refused(expected)),
        };
        let exterior = camera.exterior.orientation()?;
        let r = exterior.camera_from_world();
        let [t, row0, row1, row2] = [
            exterior.projection_center().into(),
            [r[(0, 0)], r[(0, 1)], r[(0, 2)]],
            [r[(1, 0)], r[(1, 1)], r[(1, 2)]],
            [r[(2, 0)], r[(2, 1)], r[(2, 2)]],
        ];
        let _ = writeln!(text, "{name} {} {}", camera.width, camera.height);
        for row in
            [&[f, 0.0, cx][..], &[0.0, f, cy], &[0.0, 0.0, 1.0], &k, &p, &t, &row0, &row1, &row2]
        {
            let list: Vec<_> = row.iter().map(f64::to_string).collect();
            let _ = writeln!(text, "{}", list.join(" "));
        }
    }
    Ok(text)
}

/// What a `.cam` says, as it says it.
#[derive(Default)]
struct Cam {
    name: String,
    sensor_width_mm: Option<f64>,
    size: Option<[f64; 2]>,
    focal_mm: Option<f64>,
    /// The principal point: from the middle in pixels, (W/2 − cx, H/2 − cy).
    offset_px: [Option<f64>; 2],
    /// In millimetres from the middle, x right, y up.
    offset_inpho: [Option<f64>; 2],
    /// In millimetres from the corner.
    corner_mm: [Option<f64>; 2],
    /// K₀ … K₃ of millimetres, and p₁, p₂, p₃.
    sym: [f64; 4],
    dec: [f64; 3],
    k: [f64; 3],
    p: [f64; 2],
}

/// The cameras of a `.cam`, at the origin: what counts is their interior orientation. Each is named by its heading.
///
/// Inpho's kind has K₁ = R₁/f³, K₂ = R₂/f⁵, K₃ = R₃/f⁷ and p₁ = T₁/f², p₂ = T₂/f² with f in millimetres: polynomials of
/// millimetres whose value is in units of the focal length. Both files of one project of Pix4Dmapper agree in this to twelve
/// digits. Pix4D's own kind does not say how large the pictures are: `size` does.
///
/// # Errors
/// [`ErrorKind::NoPictureSize`]; [`ErrorKind::Line`] for what is no number; [`ErrorKind::Field`] for a number that is
/// missing or out of its domain, and for K₀ or p₃ other than 0.
pub fn parse_cam(text: &str, size: Option<[u32; 2]>) -> Result<Vec<(String, CameraFile)>, Error> {
    let mut cameras: Vec<Cam> = Vec::new();
    // What the last comment was about.
    let mut comment = "";
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if line.starts_with("camera_calibration_file") || line.starts_with("Pix4D camera cal") {
            let last = line.split_whitespace().next_back().unwrap_or_default();
            cameras.push(Cam { name: format!("camera {last}"), ..Cam::default() });
            continue;
        }
        let Some(cam) = cameras.last_mut() else {
            if line.is_empty() {
                continue;
            }
            let found = line.chars().take(40).collect();
            let expected = "camera_calibration_file or Pix4D camera calibration file";
            return Err(at(number, None, LineProblem::Version { found, expected }));
        };
        if let Some(about) = line.strip_prefix('#') {
            comment = about;
            let pair = |text: &str| -> Result<[f64; 2], Error> {
                let sides = text.trim().trim_end_matches("mm").trim_end_matches("pixel").trim();
                let [w, h] = sides.split_once('x').map_or([sides, ""], |(w, h)| [w, h]);
                let fields = Fields::new(number, vec![w, h]);
                fields.numbers(0, ["width", "height"])
            };
            if let Some((_, sides)) = about.split_once("sensor width of") {
                cam.sensor_width_mm = Some(pair(sides)?[0]);
            } else if let Some(sides) = about.trim().strip_prefix("Image size") {
                cam.size = Some(pair(sides)?);
            }
            continue;
        }
        let fields = Fields::words(number, line);
        let name = fields.text(0);
        let value = || fields.number(1, name).map(Some);
        match name {
            "FOCAL" | "F" => cam.focal_mm = value()?,
            "XPOFF" | "YPOFF" => {
                let axis = usize::from(name == "YPOFF");
                if comment.contains("pixel") {
                    cam.offset_px[axis] = value()?;
                } else if comment.contains("Inpho") {
                    cam.offset_inpho[axis] = value()?;
                }
            }
            "Px" => cam.corner_mm[0] = value()?,
            "Py" => cam.corner_mm[1] = value()?,
            "SYM_DIST" => cam.sym = fields.numbers(1, [name; 4])?,
            "DEC_DIST" => cam.dec = fields.numbers(1, [name; 3])?,
            "K1" => cam.k[0] = fields.number(1, name)?,
            "K2" => cam.k[1] = fields.number(1, name)?,
            "K3" => cam.k[2] = fields.number(1, name)?,
            "T1" => cam.p[0] = fields.number(1, name)?,
            "T2" => cam.p[1] = fields.number(1, name)?,
            _ => {}
        }
    }
    cameras.into_iter().map(|cam| Ok((cam.name.clone(), cam.camera(size)?))).collect()
}

impl Cam {
    fn camera(&self, given: Option<[u32; 2]>) -> Result<CameraFile, Error> {
        let missing = |field: &str| {
            unsupported(format!("{}.{field}", self.name), "missing", "a number is needed")
        };
        let [width, height] = match (given, self.size) {
            (Some(size), _) => size,
            (None, Some(size)) => {
                if size.iter().any(|s| s.fract() != 0.0 || !(1.0..=4e9).contains(s)) {
                    let found = format!("{} × {}", size[0], size[1]);
                    let expected = "whole numbers of pixels are needed";
                    return Err(
                        unsupported(format!("{}.Image size", self.name), found, expected).into()
                    );
                }
                size.map(|s| s as u32)
            }
            (None, None) => return Err(ErrorKind::NoPictureSize.into()),
        };
        let focal_mm = self.focal_mm.ok_or_else(|| missing("FOCAL"))?;
        let sensor_mm = self.sensor_width_mm.ok_or_else(|| missing("sensor width"))?;
        let pitch = sensor_mm / f64::from(width);
        let middle = [0.5 * f64::from(width), 0.5 * f64::from(height)];
        let principal_point = match (self.offset_px, self.offset_inpho, self.corner_mm) {
            ([Some(x), Some(y)], _, _) => [middle[0] - x, middle[1] - y],
            (_, [Some(x), Some(y)], _) => [middle[0] + x / pitch, middle[1] - y / pitch],
            (_, _, [Some(x), Some(y)]) => [x / pitch, y / pitch],
            _ => return Err(missing("principal point").into()),
        };
        let ([k0, ref sym @ ..], [p1, p2, p3]) = (self.sym, self.dec);
        if k0 != 0.0 || p3 != 0.0 {
            let found = format!("K0 {k0}, p3 {p3}");
            let expected = "Pix4D's perspective camera has K0 = 0 and p3 = 0";
            return Err(unsupported(format!("{}.SYM_DIST", self.name), found, expected).into());
        }
        let f2 = focal_mm * focal_mm;
        let f3 = f2 * focal_mm;
        let k = [
            self.k[0] + sym[0] * f3,
            self.k[1] + sym[1] * f3 * f2,
            self.k[2] + sym[2] * f3 * f2 * f2,
        ];
        let p = [self.p[0] + p1 * f2, self.p[1] + p2 * f2];
        let camera = CameraFile {
            width,
            height,
            interior: interior([focal_mm / pitch; 2], principal_point, 0.0, k, p),
            exterior: Exterior {
                projection_center: [0.0; 3],
                rotation: Rotation::QuaternionWxyz([1.0, 0.0, 0.0, 0.0]),
            },
        };
        camera.check().map_err(|e| e.under(&self.name))?;
        Ok(camera)
    }
}

/// The photographs of `_pmatrix.txt`, for pictures of this size without distortion: P = K (R | −R t) taken apart. Its six
/// decimals let pixels be off by some hundredths.
///
/// # Errors
/// [`ErrorKind::Line`] with the line, and [`ErrorKind::Field`] for a P that is no camera's.
pub fn parse_pmatrix(text: &str, size: [u32; 2]) -> Result<Vec<(String, CameraFile)>, Error> {
    let mut photographs = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty()) {
        let fields = Fields::words(i + 1, line);
        fields.count(13)?;
        let v: [f64; 12] = fields.numbers(1, ["P"; 12])?;
        let name = fields.text(0);
        let camera = taken_apart(&v, size).ok_or_else(|| {
            let expected = "K (R | −R t) is needed, with R and K of full rank";
            unsupported(format!("{name}.P"), "no camera", expected)
        })?;
        camera.check().map_err(|e| e.under(name))?;
        photographs.push((name.to_owned(), camera));
    }
    Ok(photographs)
}

/// P = K (R | −R t) taken apart.
fn taken_apart(p: &[f64; 12], [width, height]: [u32; 2]) -> Option<CameraFile> {
    let matrix = Matrix3x4::from_row_slice(p);
    let Frame { exterior, camera } =
        Frame::from_projection_matrix(&matrix, &Point3::origin()).ok()?;
    let (center, rotation) = (exterior.projection_center(), exterior.camera_from_world());
    Some(CameraFile {
        width,
        height,
        interior: Interior::Pinhole {
            principal_distance: camera.principal_distance(),
            principal_point: camera.principal_point().into(),
            // Pixels of x for each unit of y, as in K.
            skew: camera.skew(),
        },
        exterior: Exterior {
            projection_center: center.into(),
            rotation: Rotation::RotationMatrix(rotation.matrix().transpose().into()),
        },
    })
}

/// The three numbers of `_offset.xyz`: world = local + offset.
///
/// ```
/// assert_eq!(collinear_io::pix4d::parse_offset("368009.000 3955854.000 97.000")?, [368009.0, 3955854.0, 97.0]);
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// [`ErrorKind::Line`].
pub fn parse_offset(text: &str) -> Result<[f64; 3], Error> {
    let words: Vec<_> =
        text.split([',', ';', ' ', '\t', '\r', '\n']).filter(|w| !w.is_empty()).collect();
    let fields = Fields::new(1, words);
    fields.count(3)?;
    fields.numbers(0, ["X", "Y", "Z"])
}
