//! Tables of exterior orientations, whose interior orientation comes from elsewhere.
//!
//! ω, φ, κ are those of [`OmegaPhiKappa`]: M = R₃(κ) R₂(φ) R₁(ω) turns the world to x right, y up, z backwards; PATB's, Pix4D's and
//! Metashape's. A file of angles does not say their unit unless its header does.
//!
//! # The table
//! A photograph a line: its name, X, Y, Z of the projection centre, ω, φ, κ. Fields are separated by blanks, tabs, commas or
//! semicolons; empty lines are passed over, and lines that start with `#`, but for a header. A header names the columns, in any order
//! and case and with others between them: `Omega`, `Phi`, `Kappa`, `X`, `Y`, `Z` (`X0`, `Easting`, `X/Easting` …) and
//! `imageName`, `name`, `image`, `photo`, `PhotoID`, `label` or `id`. Angles may say their unit, `omega_gon`, `omega(rad)`,
//! `omega[deg]`; Pix4D's header `imageName X Y Z Omega Phi Kappa` says degrees. Without a header a line has seven fields in this
//! order, or eight with a number before the name.
//!
//! # PATB
//! Three lines a photograph, FORTRAN's formats `I16,16X,3F16.5`, `5F16.12` and `4F16.12` (PCI, *Using Pat-B in OrthoEngine*): name
//! and projection centre, then a₁₁ a₁₂ a₁₃ a₂₁ a₂₂ and a₂₃ a₃₁ a₃₂ a₃₃, the rows of `world_from_photo` = Mᵀ. Blanks separate the fields when
//! read; the matrix may be broken over other lines, and a line `-99` ends the file.

use std::f64::consts::PI;
use std::fmt::Write as _;

use collinear::geometry::rotation::OmegaPhiKappa;

use crate::camera::{CameraFile, Exterior, Rotation};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};
use crate::fields::{Fields, at, plain_name};
use crate::json::Document;
use crate::points::Separator;

/// A unit of angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(alias("grad", "grade"))]
pub enum AngleUnit {
    /// A full turn has 360.
    Degrees,
    /// A full turn has 400.
    Gon,
    /// A full turn has 2 π.
    Radians,
}

impl AngleUnit {
    fn half_turn(self) -> f64 {
        match self {
            Self::Degrees => 180.0,
            Self::Gon => 200.0,
            Self::Radians => PI,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Degrees => "deg",
            Self::Gon => "gon",
            Self::Radians => "rad",
        }
    }

    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "deg" | "degree" | "degrees" | "°" => Self::Degrees,
            "gon" | "grad" | "grads" | "g" => Self::Gon,
            "rad" | "radian" | "radians" => Self::Radians,
            _ => return None,
        })
    }

    /// An angle in this unit, in radians.
    ///
    /// ```
    /// use collinear_io::orientation::AngleUnit;
    ///
    /// assert_eq!(AngleUnit::Gon.to_radians(100.0), AngleUnit::Degrees.to_radians(90.0));
    /// ```
    #[must_use]
    pub fn to_radians(self, angle: f64) -> f64 {
        if self == Self::Radians { angle } else { angle / self.half_turn() * PI }
    }

    /// An angle in radians, in this unit.
    #[must_use]
    pub fn from_radians(self, angle: f64) -> f64 {
        if self == Self::Radians { angle } else { angle / PI * self.half_turn() }
    }
}

/// A photograph's exterior orientation.
#[derive(Clone, Debug, PartialEq)]
pub struct Orientation {
    /// The photograph's name.
    pub name: String,
    /// Where it was taken from, and how it was turned.
    pub exterior: Exterior,
}

/// The photographs of these orientations, taken with one camera, whose own orientation counts for nothing.
#[must_use]
pub fn photographs(
    orientations: Vec<Orientation>,
    camera: &CameraFile,
) -> Vec<(String, CameraFile)> {
    let with = |o: Orientation| (o.name, CameraFile { exterior: o.exterior, ..camera.clone() });
    orientations.into_iter().map(with).collect()
}

/// Where in a line each value stands, from 0.
struct Columns {
    count: usize,
    name: usize,
    center: [usize; 3],
    angles: [usize; 3],
    unit: Option<AngleUnit>,
}

/// The unit that a column's name says after the angle's; none where it is no column of this angle.
pub(crate) fn angle_column(word: &str, names: [&str; 2]) -> Option<Option<AngleUnit>> {
    let rest = names.iter().find_map(|n| word.strip_prefix(n))?;
    let unit = rest.trim_matches(|c: char| "_ [](){}".contains(c));
    if unit.is_empty() { Some(None) } else { AngleUnit::named(unit).map(Some) }
}

impl Columns {
    /// Of a header; none where the line is none.
    fn named(line: usize, header: &str) -> Result<Option<Self>, Error> {
        let mut words: Vec<String> = Vec::new();
        for word in Separator::of(header).split(line, header)? {
            // `Omega [deg]` between blanks.
            match words.last_mut() {
                Some(last) if word.starts_with(['[', '(']) => last.push_str(&word),
                _ => words.push(word),
            }
        }
        let lower: Vec<String> = words.iter().map(|w| w.to_lowercase()).collect();
        let angle = |names: [&str; 2]| {
            let mut all = lower.iter().enumerate();
            all.find_map(|(i, w)| angle_column(w, names).map(|unit| (i, unit)))
        };
        let (Some(omega), Some(phi), Some(kappa)) =
            (angle(["omega", "ω"]), angle(["phi", "φ"]), angle(["kappa", "κ"]))
        else {
            return Ok(None);
        };
        let refused = || {
            let expected = "a name, X, Y, Z, omega, phi, kappa, the angles in one unit";
            at(
                line,
                None,
                LineProblem::Header { header: header.chars().take(80).collect(), expected },
            )
        };
        let place = |names: &[&str]| {
            lower.iter().position(|w| names.contains(&w.as_str())).ok_or_else(refused)
        };
        let name = place(&[
            "imagename",
            "name",
            "image",
            "photo",
            "photoid",
            "photo_id",
            "label",
            "filename",
            "id",
        ])?;
        let center = [
            place(&["x", "x0", "xc", "xl", "easting", "x/easting", "e"])?,
            place(&["y", "y0", "yc", "yl", "northing", "y/northing", "n"])?,
            place(&["z", "z0", "zc", "zl", "altitude", "z/altitude", "height", "h"])?,
        ];
        if omega.1 != phi.1 || phi.1 != kappa.1 {
            return Err(refused());
        }
        let pix4d = words.get(name).is_some_and(|w| w == "imageName");
        let unit = omega.1.or(pix4d.then_some(AngleUnit::Degrees));
        let angles = [omega.0, phi.0, kappa.0];
        Ok(Some(Self { count: words.len(), name, center, angles, unit }))
    }

    fn without_header(fields: &Fields<'_>) -> Result<Self, Error> {
        // With a number before the name.
        let name = usize::from(fields.len() == 8);
        fields.count(7 + name)?;
        let [center, angles] = [name + 1, name + 4].map(|s| [s, s + 1, s + 2]);
        Ok(Self { count: 7 + name, name, center, angles, unit: None })
    }
}

/// Whether text has the header of a table of orientations.
pub(crate) fn has_header(text: &str) -> bool {
    let some = text.lines().map(str::trim).filter(|l| !l.is_empty()).take(20);
    some.map(|l| l.trim_start_matches('#').trim())
        .any(|l| !matches!(Columns::named(1, l), Ok(None)))
}

/// Whether text is PATB's: its first line is a name and three numbers.
fn is_patb(text: &str) -> bool {
    let mut some = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.starts_with('#'));
    let words: Vec<_> = some.next().unwrap_or_default().split_whitespace().collect();
    words.len() == 4 && words[1..].iter().all(|w| w.parse::<f64>().is_ok())
}

/// The orientations of a table or of PATB's file, whichever it is. The unit is that of angles whose header has none.
///
/// # Errors
/// As [`parse_table`] and [`parse_patb`].
pub fn parse(text: &str, unit: Option<AngleUnit>) -> Result<Vec<Orientation>, Error> {
    if is_patb(text) { parse_patb(text) } else { parse_table(text, unit) }
}

/// The orientations of a table.
///
/// # Errors
/// [`ErrorKind::Line`] with line and field; [`ErrorKind::NoAngleUnit`] where neither header nor caller has one, and
/// [`FieldProblem::Unsupported`] where they differ; [`ErrorKind::NoLines`] where there is no photograph.
///
/// # Example
/// κ = 100 gon: the photograph's x axis is the world's y axis, its y axis the world's −x axis.
///
/// ```
/// use collinear::nalgebra::Point3;
/// use collinear_io::orientation::{AngleUnit, parse_table};
///
/// let table = "photo;X;Y;Z;omega_gon;phi_gon;kappa_gon\n1024;10;20;500;0;0;100\n";
/// let orientation = &parse_table(table, None)?[0];
/// let camera = orientation.exterior.orientation()?.pose().apply(&Point3::new(10.0, 27.0, 0.0));
/// assert!((camera - Point3::new(7.0, 0.0, 500.0)).norm() < 1e-13);
/// assert_eq!(orientation.name, "1024");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn parse_table(text: &str, unit: Option<AngleUnit>) -> Result<Vec<Orientation>, Error> {
    let mut columns: Option<(Columns, AngleUnit)> = None;
    let mut orientations = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        let body = line.trim_start_matches('#').trim();
        if body.is_empty() {
            continue;
        }
        if columns.is_none()
            && let Some(found) = Columns::named(number, body)?
        {
            let unit = of_one_unit(found.unit, unit)?;
            columns = Some((found, unit));
            continue;
        }
        if line.starts_with('#') {
            continue;
        }
        let split = Separator::of(line).split(number, line)?;
        let fields = Fields::new(number, split.iter().map(String::as_str).collect());
        let (columns, unit) = match &columns {
            Some((columns, unit)) => (columns, *unit),
            None => {
                let found = Columns::without_header(&fields)?;
                let unit = of_one_unit(None, unit)?;
                let (columns, unit) = columns.insert((found, unit));
                (&*columns, *unit)
            }
        };
        fields.count(columns.count)?;
        let three = |places: [usize; 3], names: [&str; 3]| -> Result<[f64; 3], Error> {
            let mut values = [0.0; 3];
            for ((value, place), name) in values.iter_mut().zip(places).zip(names) {
                *value = fields.number(place, name)?;
            }
            Ok(values)
        };
        let projection_center = three(columns.center, ["X", "Y", "Z"])?;
        let angles = three(columns.angles, ["omega", "phi", "kappa"])?;
        let rotation = Rotation::OmegaPhiKappa(angles.map(|a| unit.to_radians(a)));
        let exterior = Exterior { projection_center, rotation };
        orientations.push(Orientation { name: fields.text(columns.name).to_owned(), exterior });
    }
    if orientations.is_empty() {
        return Err(ErrorKind::NoLines.into());
    }
    Ok(orientations)
}

/// The unit that one of both says.
fn of_one_unit(header: Option<AngleUnit>, given: Option<AngleUnit>) -> Result<AngleUnit, Error> {
    match (header, given) {
        (Some(header), Some(given)) if header != given => {
            let expected = "the header says another unit of its angles: leave this one out";
            let problem = FieldProblem::Unsupported { found: given.name().into(), expected };
            Err(FieldError::new("angles", problem).into())
        }
        (header, given) => Ok(header.or(given).ok_or(ErrorKind::NoAngleUnit)?),
    }
}

/// The orientations of PATB's file.
///
/// # Errors
/// [`ErrorKind::Line`] with line and field, [`ErrorKind::Field`] for a matrix that is no rotation,
/// [`ErrorKind::NoLines`] where there is no photograph.
pub fn parse_patb(text: &str) -> Result<Vec<Orientation>, Error> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, l)| Fields::words(i + 1, l))
        .filter(|f| f.len() > 0 && !f.text(0).starts_with('#'));
    let mut orientations = Vec::new();
    while let Some(first) = lines.next() {
        if first.len() == 1 && first.text(0) == "-99" {
            break;
        }
        first.count(4)?;
        let (name, projection_center) = (first.text(0), first.numbers(1, ["X", "Y", "Z"])?);
        let mut a: Vec<f64> = Vec::with_capacity(9);
        let mut last = first;
        while a.len() < 9 {
            let Some(fields) = lines.next() else {
                let (found, expected) = (a.len(), 9);
                return Err(at(last.line(), None, LineProblem::FieldCount { found, expected }));
            };
            if a.len() + fields.len() > 9 {
                fields.count(9 - a.len())?;
            }
            for place in 0..fields.len() {
                a.push(fields.number(place, "rotation matrix")?);
            }
            last = fields;
        }
        // camera_from_world = diag(1, −1, −1) (world_from_photo)ᵀ.
        let row = |i: usize, sign: f64| [0, 1, 2].map(|j| sign * a[3 * j + i]);
        let rotation = Rotation::RotationMatrix([row(0, 1.0), row(1, -1.0), row(2, -1.0)]);
        let exterior = Exterior { projection_center, rotation };
        exterior.check().map_err(|e| e.under(name))?;
        orientations.push(Orientation { name: name.to_owned(), exterior });
    }
    if orientations.is_empty() {
        return Err(ErrorKind::NoLines.into());
    }
    Ok(orientations)
}

fn angles(camera: &CameraFile) -> Result<OmegaPhiKappa, Error> {
    Ok(camera.exterior.orientation()?.omega_phi_kappa())
}

/// The table of photographs' orientations, separated by blanks. In degrees its header is Pix4D's, else the columns of the
/// angles are `Omega_gon` or `Omega_rad` and so on. Interior orientations are not in it.
///
/// # Errors
/// [`FieldProblem::Unsupported`] for a name with a separator in it, and those of [`CameraFile::check`](Document::check).
pub fn to_table(photographs: &[(String, CameraFile)], unit: AngleUnit) -> Result<String, Error> {
    let end = if unit == AngleUnit::Degrees { String::new() } else { format!("_{}", unit.name()) };
    let mut text = format!("imageName X Y Z Omega{end} Phi{end} Kappa{end}\n");
    for (name, camera) in photographs {
        camera.check().map_err(|e| e.under(name))?;
        plain_name(name, usize::MAX, "a table's names have no blanks and separators: rename it")?;
        let [x, y, z] = camera.exterior.projection_center;
        let OmegaPhiKappa { omega, phi, kappa } = angles(camera)?;
        let [omega, phi, kappa] = [omega, phi, kappa].map(|a| unit.from_radians(a));
        let _ = writeln!(text, "{name} {x} {y} {z} {omega} {phi} {kappa}");
    }
    Ok(text)
}

/// PATB's file of photographs' orientations, in its columns: centres are rounded to 10⁻⁵, the matrix to 10⁻¹².
///
/// # Errors
/// [`FieldProblem::Unsupported`] for a name of more than 16 characters or with a blank; [`FieldProblem::OutOfRange`] for a
/// coordinate that its column does not hold; those of [`CameraFile::check`](Document::check).
pub fn to_patb(photographs: &[(String, CameraFile)]) -> Result<String, Error> {
    let mut text = String::new();
    for (name, camera) in photographs {
        camera.check().map_err(|e| e.under(name))?;
        plain_name(name, 16, "PATB's names have 1 to 16 characters and no blanks: rename it")?;
        let _ = write!(text, "{name:>16}{:16}", "");
        for value in camera.exterior.projection_center {
            if !(value.abs() < 1e9) {
                let expected = "a number below 1e9, which PATB's columns hold";
                let problem = FieldProblem::OutOfRange { value, expected };
                return Err(FieldError::new(format!("{name}.projection_center"), problem).into());
            }
            let _ = write!(text, "{value:16.5}");
        }
        let m = angles(camera)?.photo_from_world();
        // Row after row of world_from_photo.
        for place in 0..9 {
            if place == 0 || place == 5 {
                text.push('\n');
            }
            let _ = write!(text, "{:16.12}", m[(place % 3, place / 3)]);
        }
        text.push('\n');
    }
    Ok(text)
}
