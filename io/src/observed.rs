//! What was observed in the world besides images, as CSV: places of points, positions and attitudes of photographs, distances.
//!
//! | table | columns | may be there |
//! | --- | --- | --- |
//! | places | `id`, `X`, `Y`, `Z` | `sigma_X`, `sigma_Y`, `sigma_Z` |
//! | positions | `photo`, `X`, `Y`, `Z`, `sigma_X`, `sigma_Y`, `sigma_Z` | `lever_x`, `lever_y`, `lever_z` |
//! | attitudes | `photo`, `omega`, `phi`, `kappa`, `sigma_omega`, `sigma_phi`, `sigma_kappa` | |
//! | distances | `from`, `to`, `length`, `sigma` | |
//!
//! Lengths are world units. Angles and their standard deviations are degrees, unless the columns say `omega_gon` or `omega_rad` and so
//! on; ω, φ, κ are those of [`orientation`](crate::orientation). Other columns are passed over. Places without a header are lines of a name, X,
//! Y, Z; the other tables need theirs. The rest is as in [`points`](crate::points).

use std::path::Path;

use collinear::geometry::rotation::OmegaPhiKappa;

use crate::control::{SIGMAS, all_or_none, positives, sigmas};
use crate::error::{Error, LineProblem};
use crate::fields::at;
use crate::json::read_text;
use crate::orientation::{AngleUnit, angle_column};
use crate::points::{Line, find, table};

/// A point whose place is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaceRow {
    /// Its name.
    pub id: String,
    /// X, Y, Z in the world.
    pub world: [f64; 3],
    /// Standard deviations of X, Y, Z, world units; none where the place is taken as free of error.
    pub sigma: Option<[f64; 3]>,
}

/// The observed position of a photograph's antenna.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PositionRow {
    /// The photograph's name.
    pub photo: String,
    /// X, Y, Z of the antenna in the world.
    pub world: [f64; 3],
    /// Their standard deviations, world units.
    pub sigma: [f64; 3],
    /// From the projection centre to the antenna in camera axes (x right, y down, z forward), world units; none where the table does
    /// not say it.
    pub lever_arm: Option<[f64; 3]>,
}

/// The observed attitude of a photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct AttitudeRow {
    /// The photograph's name.
    pub photo: String,
    /// ω, φ, κ, radians.
    pub angles: OmegaPhiKappa,
    /// Their standard deviations, radians.
    pub sigma: [f64; 3],
}

/// The observed distance of two points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistanceRow {
    /// Their names.
    pub ends: [String; 2],
    /// Their distance, world units.
    pub length: f64,
    /// Its standard deviation, world units.
    pub sigma: f64,
}

/// Reads a list of places.
///
/// # Errors
/// [`ErrorKind::Line`](crate::ErrorKind::Line) with the line and the field in it,
/// [`ErrorKind::NoLines`](crate::ErrorKind::NoLines) where there is neither a header nor a place.
pub fn read_places(path: &Path) -> Result<Vec<PlaceRow>, Error> {
    read_text(path).and_then(|text| parse_places(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_places`], from text.
///
/// ```
/// use collinear_io::observed::parse_places;
///
/// let rows = parse_places("id,X,Y,Z,sigma_X,sigma_Y,sigma_Z\nchurch,1,2,3,0.02,0.02,0.05\nwell,4,5,6,,,\n")?;
/// assert_eq!(rows[0].sigma, Some([0.02, 0.02, 0.05]));
/// assert_eq!((rows[1].world, rows[1].sigma), ([4.0, 5.0, 6.0], None));
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_places`].
pub fn parse_places(text: &str) -> Result<Vec<PlaceRow>, Error> {
    struct Columns {
        count: usize,
        id: usize,
        world: [usize; 3],
        sigma: Option<[(usize, &'static str); 3]>,
    }
    let without_header = |fields: &[String]| {
        let numbers = fields.len() == 4 && fields[1..].iter().all(|f| f.parse::<f64>().is_ok());
        numbers.then_some(Columns { count: 4, id: 0, world: [1, 2, 3], sigma: None })
    };
    let named = |line: usize, header: &[String]| {
        let [id, x, y, z] = needed(line, header, ["id", "X", "Y", "Z"], PLACES)?;
        let sigma = all_or_none(line, header, SIGMAS, PLACES)?;
        Ok(Columns { count: header.len(), id, world: [x, y, z], sigma })
    };
    table(text, without_header, named, |columns, number, fields| {
        let line = Line::new(number, fields, columns.count)?;
        Ok(PlaceRow {
            id: name(&line, number, columns.id, "id")?,
            world: values(&line, columns.world, ["X", "Y", "Z"])?,
            sigma: sigmas(&line, number, columns.sigma)?,
        })
    })
}

/// Reads a table of antenna positions.
///
/// # Errors
/// As [`read_places`].
pub fn read_positions(path: &Path) -> Result<Vec<PositionRow>, Error> {
    read_text(path).and_then(|text| parse_positions(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_positions`], from text.
///
/// ```
/// use collinear_io::observed::parse_positions;
///
/// let rows = parse_positions("photo,X,Y,Z,sigma_X,sigma_Y,sigma_Z\n1024,10,20,500,0.02,0.02,0.04\n")?;
/// assert_eq!((rows[0].photo.as_str(), rows[0].sigma, rows[0].lever_arm), ("1024", [0.02, 0.02, 0.04], None));
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_places`].
pub fn parse_positions(text: &str) -> Result<Vec<PositionRow>, Error> {
    const EXPECTED: &str =
        "photo, X, Y, Z, sigma_X, sigma_Y, sigma_Z, and perhaps all of lever_x, lever_y, lever_z";
    let named = |line: usize, header: &[String]| {
        let names = ["photo", "X", "Y", "Z", SIGMAS[0], SIGMAS[1], SIGMAS[2]];
        let places = needed(line, header, names, EXPECTED)?;
        let lever = all_or_none(line, header, LEVER, EXPECTED)?;
        Ok((header.len(), places, lever))
    };
    table(
        text,
        |_| None,
        named,
        |(count, places, lever), number, fields| {
            let line = Line::new(number, fields, *count)?;
            let [photo, x, y, z, sx, sy, sz] = *places;
            Ok(PositionRow {
                photo: name(&line, number, photo, "photo")?,
                world: values(&line, [x, y, z], ["X", "Y", "Z"])?,
                sigma: positives(
                    &line,
                    number,
                    [(sx, SIGMAS[0]), (sy, SIGMAS[1]), (sz, SIGMAS[2])],
                )?,
                lever_arm: lever
                    .map(|places| values(&line, places.map(|(place, _)| place), LEVER))
                    .transpose()?,
            })
        },
    )
}

/// Reads a table of attitudes.
///
/// # Errors
/// As [`read_places`].
pub fn read_attitudes(path: &Path) -> Result<Vec<AttitudeRow>, Error> {
    read_text(path).and_then(|text| parse_attitudes(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_attitudes`], from text.
///
/// ```
/// use collinear_io::observed::parse_attitudes;
///
/// let header = "photo,omega,phi,kappa,sigma_omega,sigma_phi,sigma_kappa";
/// let rows = parse_attitudes(&format!("{header}\n1024,0,0,90,0.01,0.01,0.02\n"))?;
/// assert_eq!(rows[0].angles.kappa, std::f64::consts::FRAC_PI_2);
/// assert!((rows[0].sigma[0] - 1.7453292519943295e-4).abs() < 1e-18);
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_places`].
pub fn parse_attitudes(text: &str) -> Result<Vec<AttitudeRow>, Error> {
    const EXPECTED: &str =
        "photo, omega, phi, kappa, sigma_omega, sigma_phi, sigma_kappa, the angles in one unit";
    let named = |line: usize, header: &[String]| {
        let [photo] = needed(line, header, ["photo"], EXPECTED)?;
        let (mut places, mut unit) = ([0; 6], None);
        for (k, place) in places.iter_mut().enumerate() {
            let name = ANGLES[k % 3];
            let of = |word: &str| {
                let word = if k < 3 { Some(word) } else { word.strip_prefix("sigma_") };
                word.and_then(|w| angle_column(w, [name, name]))
            };
            let mut all = header.iter().enumerate().filter_map(|(i, w)| Some((i, of(w)?)));
            let (i, own) = all.next().ok_or_else(|| refused(line, header, EXPECTED))?;
            let one = all.next().is_none() && *unit.get_or_insert(own) == own;
            if !one {
                return Err(refused(line, header, EXPECTED));
            }
            *place = i;
        }
        Ok((header.len(), photo, places, unit.flatten().unwrap_or(AngleUnit::Degrees)))
    };
    table(
        text,
        |_| None,
        named,
        |(count, photo, places, unit), number, fields| {
            let line = Line::new(number, fields, *count)?;
            let [omega, phi, kappa, so, sp, sk] = *places;
            let angles = values(&line, [omega, phi, kappa], ANGLES)?;
            let [omega, phi, kappa] = angles.map(|a| unit.to_radians(a));
            let sigmas = [(so, "sigma_omega"), (sp, "sigma_phi"), (sk, "sigma_kappa")];
            Ok(AttitudeRow {
                photo: name(&line, number, *photo, "photo")?,
                angles: OmegaPhiKappa { omega, phi, kappa },
                sigma: positives(&line, number, sigmas)?.map(|s| unit.to_radians(s)),
            })
        },
    )
}

/// Reads a table of distances.
///
/// # Errors
/// As [`read_places`].
pub fn read_distances(path: &Path) -> Result<Vec<DistanceRow>, Error> {
    read_text(path).and_then(|text| parse_distances(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_distances`], from text.
///
/// ```
/// use collinear_io::observed::parse_distances;
///
/// let rows = parse_distances("from,to,length,sigma\na,b,1.25,0.001\n")?;
/// assert_eq!((rows[0].ends[1].as_str(), rows[0].length, rows[0].sigma), ("b", 1.25, 0.001));
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_places`].
pub fn parse_distances(text: &str) -> Result<Vec<DistanceRow>, Error> {
    let named = |line: usize, header: &[String]| {
        let names = ["from", "to", "length", "sigma"];
        Ok((header.len(), needed(line, header, names, "from, to, length, sigma")?))
    };
    table(
        text,
        |_| None,
        named,
        |(count, places), number, fields| {
            let line = Line::new(number, fields, *count)?;
            let [from, to, length, sigma] = *places;
            let ends = [name(&line, number, from, "from")?, name(&line, number, to, "to")?];
            let [length, sigma] = positives(&line, number, [(length, "length"), (sigma, "sigma")])?;
            Ok(DistanceRow { ends, length, sigma })
        },
    )
}

const LEVER: [&str; 3] = ["lever_x", "lever_y", "lever_z"];
const ANGLES: [&str; 3] = ["omega", "phi", "kappa"];
const PLACES: &str = "id, X, Y, Z, and perhaps all of sigma_X, sigma_Y, sigma_Z";

fn refused(line: usize, header: &[String], expected: &'static str) -> Error {
    at(line, None, LineProblem::Header { header: header.join(" "), expected })
}

/// The places of columns that must be there.
fn needed<const N: usize>(
    line: usize,
    header: &[String],
    names: [&str; N],
    expected: &'static str,
) -> Result<[usize; N], Error> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = find(line, header, name)?.ok_or_else(|| refused(line, header, expected))?;
    }
    Ok(places)
}

/// A name, which cannot be empty.
fn name(line: &Line<'_>, number: usize, place: usize, column: &str) -> Result<String, Error> {
    line.named(Some(place))
        .ok_or_else(|| at(number, Some(place + 1), LineProblem::NoName { name: column.to_owned() }))
}

fn values<const N: usize>(
    line: &Line<'_>,
    places: [usize; N],
    names: [&str; N],
) -> Result<[f64; N], Error> {
    let mut values = [0.0; N];
    for ((value, place), name) in values.iter_mut().zip(places).zip(names) {
        *value = line.value(place, name)?;
    }
    Ok(values)
}
