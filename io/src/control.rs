//! Lists of control points as CSV: places in the world, their measured images, and how good either is.
//!
//! A header names the columns: `X`, `Y`, `Z` (world) and `x`, `y` (image, pixels from the top-left corner of the top-left
//! pixel) must be there, `id` may be. Standard deviations may be: `sigma` of both image coordinates or `sigma_x` and `sigma_y`, in
//! pixels; `sigma_X`, `sigma_Y`, `sigma_Z` of the place, in world units, all three of them. Other columns are passed over. Without a
//! header a line has five numbers X, Y, Z, x, y, or a name before them. An empty standard deviation is one that is not
//! stated; a line without x and y is a point that was not measured. The rest is as in [`points`](crate::points).

use std::path::Path;

use crate::error::{Error, LineProblem};
use crate::fields::at;
use crate::json::read_text;
use crate::points::{Line, find, table};

/// A line of a list of control points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlRow {
    /// Its name.
    pub id: Option<String>,
    /// X, Y, Z in the world.
    pub world: [f64; 3],
    /// x, y in the picture, pixels; none where it was not measured.
    pub image: Option<[f64; 2]>,
    /// Standard deviations of x and y, pixels; none where they are not stated.
    pub image_sigma: Option<[f64; 2]>,
    /// Standard deviations of X, Y, Z, world units; none where the place is taken as free of error.
    pub world_sigma: Option<[f64; 3]>,
}

/// Reads a list of control points.
///
/// # Errors
/// [`ErrorKind::Line`](crate::ErrorKind::Line) with the line and the field in it,
/// [`ErrorKind::NoLines`](crate::ErrorKind::NoLines) where there is neither a header nor a point.
pub fn read_control(path: &Path) -> Result<Vec<ControlRow>, Error> {
    read_text(path).and_then(|text| parse_control(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_control`], from text.
///
/// ```
/// use collinear_io::control::parse_control;
///
/// let rows = parse_control("id,X,Y,Z,x,y,sigma,sigma_X,sigma_Y,sigma_Z\nchurch,1,2,3,10.5,20.5,0.3,,,\nwell,4,5,6,,,,1,1,2\n")?;
/// assert_eq!((rows[0].image, rows[0].image_sigma), (Some([10.5, 20.5]), Some([0.3, 0.3])));
/// assert_eq!((rows[1].image, rows[1].world_sigma), (None, Some([1.0, 1.0, 2.0])));
///
/// let error = parse_control("X,Y,Z,x,y,sigma\n1,2,3,4,5,-1\n").unwrap_err();
/// assert_eq!(error.to_string(), "line 2, field 6: sigma is -1, expected a number above 0");
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_control`].
pub fn parse_control(text: &str) -> Result<Vec<ControlRow>, Error> {
    table(text, Columns::without_header, Columns::named, Columns::row)
}

/// Where in a line each value stands, from 0.
struct Columns {
    count: usize,
    id: Option<usize>,
    world: [usize; 3],
    image: [usize; 2],
    image_sigma: Option<[(usize, &'static str); 2]>,
    world_sigma: Option<[(usize, &'static str); 3]>,
}

impl Columns {
    /// Five numbers, or a name and five numbers.
    fn without_header(fields: &[String]) -> Option<Self> {
        let start = fields.len().checked_sub(5).filter(|s| *s <= 1)?;
        let numbers = fields.iter().skip(start).all(|f| f.parse::<f64>().is_ok());
        numbers.then_some(Self {
            count: fields.len(),
            id: (start == 1).then_some(0),
            world: [start, start + 1, start + 2],
            image: [start + 3, start + 4],
            image_sigma: None,
            world_sigma: None,
        })
    }

    fn named(line: usize, header: &[String]) -> Result<Self, Error> {
        let bad =
            |expected| at(line, None, LineProblem::Header { header: header.join(" "), expected });
        let all = |names: &[&str]| -> Result<Vec<Option<usize>>, Error> {
            names.iter().map(|name| find(line, header, name)).collect()
        };
        let [Some(wx), Some(wy), Some(wz), Some(x), Some(y)] = all(&["X", "Y", "Z", "x", "y"])?[..]
        else {
            return Err(bad("X, Y, Z, x, y, and perhaps id, sigma, sigma_X, sigma_Y, sigma_Z"));
        };
        let image_sigma = image_sigmas(line, header)?;
        let world_sigma =
            all_or_none(line, header, SIGMAS, "all of sigma_X, sigma_Y, sigma_Z or none of them")?;
        let (world, image) = ([wx, wy, wz], [x, y]);
        let id = find(line, header, "id")?;
        Ok(Self { count: header.len(), id, world, image, image_sigma, world_sigma })
    }

    fn row(&self, number: usize, fields: &[String]) -> Result<ControlRow, Error> {
        let line = Line::new(number, fields, self.count)?;
        let [wx, wy, wz] = self.world;
        Ok(ControlRow {
            id: line.named(self.id),
            world: [line.value(wx, "X")?, line.value(wy, "Y")?, line.value(wz, "Z")?],
            image: line.image(self.image)?,
            image_sigma: sigmas(&line, number, self.image_sigma)?,
            world_sigma: sigmas(&line, number, self.world_sigma)?,
        })
    }
}

/// The columns of the standard deviations of a place.
pub(crate) const SIGMAS: [&str; 3] = ["sigma_X", "sigma_Y", "sigma_Z"];

/// Columns of which a table has all, with their names, or none.
pub(crate) fn all_or_none<const N: usize>(
    line: usize,
    header: &[String],
    names: [&'static str; N],
    expected: &'static str,
) -> Result<Option<[(usize, &'static str); N]>, Error> {
    let mut places = Vec::with_capacity(N);
    for name in names {
        places.extend(find(line, header, name)?.map(|place| (place, name)));
    }
    if places.is_empty() {
        return Ok(None);
    }
    let all = <[_; N]>::try_from(places).map(Some);
    all.map_err(|_| at(line, None, LineProblem::Header { header: header.join(" "), expected }))
}

/// The columns of an image point's standard deviations, where there are any.
pub(crate) fn image_sigmas(
    line: usize,
    header: &[String],
) -> Result<Option<[(usize, &'static str); 2]>, Error> {
    let column = |name| find(line, header, name);
    match (column("sigma")?, column("sigma_x")?, column("sigma_y")?) {
        (Some(both), None, None) => Ok(Some([(both, "sigma"), (both, "sigma")])),
        (None, Some(x), Some(y)) => Ok(Some([(x, "sigma_x"), (y, "sigma_y")])),
        (None, None, None) => Ok(None),
        _ => {
            let (header, expected) = (header.join(" "), "sigma alone, or sigma_x and sigma_y");
            Err(at(line, None, LineProblem::Header { header, expected }))
        }
    }
}

/// The standard deviations of a line: all, or none where all are empty.
pub(crate) fn sigmas<const N: usize>(
    line: &Line<'_>,
    number: usize,
    places: Option<[(usize, &'static str); N]>,
) -> Result<Option<[f64; N]>, Error> {
    let Some(places) = places else { return Ok(None) };
    if places.iter().all(|(place, _)| line.text(*place).is_empty()) {
        return Ok(None);
    }
    positives(line, number, places).map(Some)
}

/// Numbers above zero, of columns with their names.
pub(crate) fn positives<const N: usize>(
    line: &Line<'_>,
    number: usize,
    places: [(usize, &str); N],
) -> Result<[f64; N], Error> {
    let mut values = [0.0; N];
    for (value, (place, name)) in values.iter_mut().zip(places) {
        *value = line.value(place, name)?;
        if *value <= 0.0 {
            let problem =
                LineProblem::NotPositive { name: name.into(), text: line.text(place).into() };
            return Err(at(number, Some(place + 1), problem));
        }
    }
    Ok(values)
}
