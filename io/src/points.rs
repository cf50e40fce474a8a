//! Lists of points as CSV: world coordinates, perhaps with a name and the image coordinates.
//!
//! With a header, columns go by name: `X`, `Y`, `Z` (world) must be there; `id`, `x`, `y` (image, pixels from the
//! top-left corner) and `note` may be; others are passed over. A header with `x`, `y`, `z` and no capitals means the
//! world. Without a header a line has three numbers X, Y, Z, or a name before them. Fields are parted by commas,
//! semicolons, tabs or spaces, whichever the first line has, in that order of preference: tab, semicolon, comma, space.
//! Empty lines and lines that start with `#` are passed over. A header alone is a list without points; a text without any
//! line is an error, since it is more often a file that was never filled.

use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::{Error, ErrorKind, FieldError, LineProblem};
use crate::fields::at;
use crate::json::read_text;

/// A line of a list of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointRow {
    /// Its name.
    pub id: Option<String>,
    /// X, Y, Z in the world.
    pub world: [f64; 3],
    /// x, y in the picture, pixels; none where it was not measured or has no image.
    pub image: Option<[f64; 2]>,
    /// Anything to say about it, as why it has no image.
    pub note: Option<String>,
}

/// Reads a list of points.
///
/// # Errors
/// [`ErrorKind::Line`] with the line and the field in it, [`ErrorKind::NoLines`] where there is neither a header nor a point.
pub fn read_points(path: &Path) -> Result<Vec<PointRow>, Error> {
    read_text(path).and_then(|text| parse_points(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_points`], from text.
///
/// ```
/// use collinear_io::points::parse_points;
///
/// let rows = parse_points("id,X,Y,Z,x,y\nchurch,1,2,3,10.5,20.5\nwell,4,5,6,,\n")?;
/// assert_eq!(rows[0].image, Some([10.5, 20.5]));
/// assert_eq!(rows[1].image, None);
///
/// let error = parse_points("X,Y,Z\n1,2,3\n1,2,three\n").unwrap_err();
/// assert_eq!(error.to_string(), "line 3, field 3: Z is `three`, expected a finite number");
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_points`].
pub fn parse_points(text: &str) -> Result<Vec<PointRow>, Error> {
    table(text, Columns::without_header, Columns::named, Columns::row)
}

/// A place on the Earth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeographicRow {
    /// Its name.
    pub id: Option<String>,
    /// Longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// Height, metres; from what it counts is not in the list.
    pub height: f64,
}

/// Reads a list of places: the columns `lon`, `lat`, `h` and perhaps `id` by name, or without a header longitude,
/// latitude and height in this order, or a name and these.
///
/// # Errors
/// As [`read_points`].
pub fn read_geographic(path: &Path) -> Result<Vec<GeographicRow>, Error> {
    read_text(path).and_then(|text| parse_geographic(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_geographic`], from text.
///
/// ```
/// use collinear_io::points::parse_geographic;
///
/// let rows = parse_geographic("id,lat,lon,h\nsummit,44.174,5.278,1909\n")?;
/// assert_eq!((rows[0].longitude_deg, rows[0].latitude_deg, rows[0].height), (5.278, 44.174, 1909.0));
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_points`].
pub fn parse_geographic(text: &str) -> Result<Vec<GeographicRow>, Error> {
    let named = |line: usize, header: &[String]| {
        let find = |name: &str| find(line, header, name);
        match (find("lon")?, find("lat")?, find("h")?) {
            (Some(lon), Some(lat), Some(h)) => Ok(Columns {
                count: header.len(),
                id: find("id")?,
                world: [lon, lat, h],
                image: None,
                note: None,
            }),
            _ => {
                let (header, expected) = (header.join(" "), "lon, lat, h, and perhaps id");
                Err(at(line, None, LineProblem::Header { header, expected }))
            }
        }
    };
    let row = |columns: &Columns, number: usize, fields: &[String]| {
        let line = Line::new(number, fields, columns.count)?;
        let [lon, lat, h] = columns.world;
        Ok(GeographicRow {
            id: line.named(columns.id),
            longitude_deg: line.value(lon, "lon")?,
            latitude_deg: line.value(lat, "lat")?,
            height: line.value(h, "h")?,
        })
    };
    table(text, Columns::without_header, named, row)
}

/// A measured point of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImagePointRow {
    /// Its name.
    pub id: Option<String>,
    /// x, y in the picture, pixels.
    pub image: [f64; 2],
}

/// Reads a list of image points: the columns `x`, `y` and perhaps `id` by name, or without a header x and y, or a name
/// and these. Lines without x and y are passed over, as those of points that have no image.
///
/// # Errors
/// As [`read_points`].
pub fn read_image_points(path: &Path) -> Result<Vec<ImagePointRow>, Error> {
    read_text(path).and_then(|text| parse_image_points(&text)).map_err(|e| e.in_file(path))
}

/// As [`read_image_points`], from text.
///
/// ```
/// use collinear_io::points::parse_image_points;
///
/// let rows = parse_image_points("id,X,Y,Z,x,y\nchurch,1,2,3,10.5,20.5\nwell,4,5,6,,\n")?;
/// assert_eq!(rows.len(), 1);
/// assert_eq!(rows[0].image, [10.5, 20.5]);
/// # Ok::<(), collinear_io::Error>(())
/// ```
///
/// # Errors
/// As [`read_points`].
pub fn parse_image_points(text: &str) -> Result<Vec<ImagePointRow>, Error> {
    let rows = table(text, ImageColumns::without_header, ImageColumns::named, ImageColumns::row)?;
    Ok(rows.into_iter().flatten().collect())
}

/// Reads a table whose columns are known by their header, or by the fields of its first line.
pub(crate) fn table<C, R>(
    text: &str,
    without_header: impl Fn(&[String]) -> Option<C>,
    named: impl Fn(usize, &[String]) -> Result<C, Error>,
    row: impl Fn(&C, usize, &[String]) -> Result<R, Error>,
) -> Result<Vec<R>, Error> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
        .peekable();
    let (number, first) = lines.peek().copied().ok_or(ErrorKind::NoLines)?;
    let separator = Separator::of(first);
    let fields = separator.split(number, first)?;
    let columns = match without_header(&fields) {
        Some(columns) => columns,
        None => {
            lines.next();
            named(number, &fields)?
        }
    };
    lines.map(|(number, line)| row(&columns, number, &separator.split(number, line)?)).collect()
}

/// Writes a list of points with a header, atomically. The columns `id`, `x` and `y`, and `note` are there where a row
/// has something in them. Numbers are written so that reading gives the same bits.
///
/// # Errors
/// [`ErrorKind::Field`] for a number that is NaN or infinite, and as [`write_atomically`].
pub fn write_points(path: &Path, rows: &[PointRow]) -> Result<(), Error> {
    let text = format_points(rows).map_err(|e| e.in_file(path))?;
    write_atomically(path, |w| w.write_all(text.as_bytes()))
}

/// As [`write_points`], to text.
///
/// # Errors
/// [`ErrorKind::Field`] for a number that is NaN or infinite.
pub fn format_points(rows: &[PointRow]) -> Result<String, Error> {
    let has_id = rows.iter().any(|r| r.id.is_some());
    let has_image = rows.iter().any(|r| r.image.is_some() || r.note.is_some());
    let has_note = rows.iter().any(|r| r.note.is_some());
    let mut header = Vec::new();
    header.extend(has_id.then_some("id"));
    header.extend(["X", "Y", "Z"]);
    if has_image {
        header.extend(["x", "y"]);
    }
    header.extend(has_note.then_some("note"));
    let mut text = header.join(",");
    text.push('\n');
    for (i, row) in rows.iter().enumerate() {
        finite(i, "world", &row.world)?;
        let mut fields = Vec::new();
        if has_id {
            fields.push(quoted(row.id.as_deref().unwrap_or_default()));
        }
        fields.extend(row.world.iter().map(|v| format!("{v:?}")));
        if has_image {
            match row.image {
                Some(image) => {
                    finite(i, "image", &image)?;
                    fields.extend(image.iter().map(|v| format!("{v:?}")));
                }
                None => fields.extend([String::new(), String::new()]),
            }
        }
        if has_note {
            fields.push(quoted(row.note.as_deref().unwrap_or_default()));
        }
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    Ok(text)
}

fn finite(row: usize, field: &str, values: &[f64]) -> Result<(), FieldError> {
    crate::check::finite(&format!("[{row}].{field}"), values)
}

/// A text as a field of a CSV line. A line break inside would end the line for this reader, so it becomes a space.
#[must_use]
pub fn quoted(text: &str) -> String {
    let line = text.replace(['\n', '\r'], " ");
    let plain =
        !line.contains([',', ';', '\t', '"']) && line.trim() == line && !line.starts_with('#');
    if plain { line } else { format!("\"{}\"", line.replace('"', "\"\"")) }
}

/// What stands between the fields of a line.
pub(crate) enum Separator {
    Character(char),
    Spaces,
}

impl Separator {
    /// The first of tab, semicolon and comma that is in the line, else blanks.
    pub(crate) fn of(line: &str) -> Self {
        ['\t', ';', ',']
            .into_iter()
            .find(|c| line.contains(*c))
            .map_or(Self::Spaces, Self::Character)
    }

    pub(crate) fn split(&self, number: usize, line: &str) -> Result<Vec<String>, Error> {
        match self {
            Self::Spaces => Ok(line.split_whitespace().map(Into::into).collect()),
            Self::Character(separator) => split_quoted(line, *separator)
                .ok_or_else(|| at(number, None, LineProblem::UnclosedQuote)),
        }
    }
}

/// Fields of one line; a field in quotation marks may hold the separator, and a doubled mark in it is one.
fn split_quoted(line: &str, separator: char) -> Option<Vec<String>> {
    let mut fields = Vec::new();
    let (mut field, mut in_quotes, mut was_quoted) = (String::new(), false, false);
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if in_quotes && characters.next_if_eq(&'"').is_some() => field.push('"'),
            '"' if in_quotes => in_quotes = false,
            '"' if field.trim().is_empty() && !was_quoted => {
                field.clear();
                (in_quotes, was_quoted) = (true, true);
            }
            c if c == separator && !in_quotes => {
                fields.push(finish(&mut field, &mut was_quoted));
            }
            // Blanks between a closing mark and the separator.
            c if was_quoted && !in_quotes && c.is_whitespace() => {}
            c => field.push(c),
        }
    }
    fields.push(finish(&mut field, &mut was_quoted));
    (!in_quotes).then_some(fields)
}

fn finish(field: &mut String, was_quoted: &mut bool) -> String {
    let text = std::mem::take(field);
    if std::mem::take(was_quoted) { text } else { text.trim().to_owned() }
}

/// Where in a line each value stands, from 0.
struct Columns {
    count: usize,
    id: Option<usize>,
    world: [usize; 3],
    image: Option<[usize; 2]>,
    note: Option<usize>,
}

impl Columns {
    /// Three numbers, or a name and three numbers.
    fn without_header(fields: &[String]) -> Option<Self> {
        let start = fields.len().checked_sub(3).filter(|s| *s <= 1)?;
        let numbers = fields.iter().skip(start).all(|f| f.parse::<f64>().is_ok());
        numbers.then_some(Self {
            count: fields.len(),
            id: (start == 1).then_some(0),
            world: [start, start + 1, start + 2],
            image: None,
            note: None,
        })
    }

    fn named(line: usize, header: &[String]) -> Result<Self, Error> {
        let find = |name: &str| find(line, header, name);
        let (x, y) = (find("x")?, find("y")?);
        let (world, image) = match (find("X")?, find("Y")?, find("Z")?) {
            (Some(wx), Some(wy), Some(wz)) => match (x, y) {
                (Some(x), Some(y)) => ([wx, wy, wz], Some([x, y])),
                (None, None) => ([wx, wy, wz], None),
                _ => return Err(at(line, None, LineProblem::HalfAnImagePoint)),
            },
            (None, None, None) => match (x, y, find("z")?) {
                (Some(x), Some(y), Some(z)) => ([x, y, z], None),
                _ => return Err(bad_header(line, header)),
            },
            _ => return Err(bad_header(line, header)),
        };
        Ok(Self { count: header.len(), id: find("id")?, world, image, note: find("note")? })
    }

    fn row(&self, line: usize, fields: &[String]) -> Result<PointRow, Error> {
        let line = Line::new(line, fields, self.count)?;
        let [wx, wy, wz] = self.world;
        let image = match self.image {
            Some(places) => line.image(places)?,
            None => None,
        };
        Ok(PointRow {
            id: line.named(self.id),
            world: [line.value(wx, "X")?, line.value(wy, "Y")?, line.value(wz, "Z")?],
            image,
            note: line.named(self.note),
        })
    }
}

/// Where in a line of image points each value stands, from 0.
struct ImageColumns {
    count: usize,
    id: Option<usize>,
    image: [usize; 2],
}

impl ImageColumns {
    /// Two numbers, or a name and two numbers.
    fn without_header(fields: &[String]) -> Option<Self> {
        let start = fields.len().checked_sub(2).filter(|s| *s <= 1)?;
        let numbers = fields.iter().skip(start).all(|f| f.parse::<f64>().is_ok());
        numbers.then_some(Self {
            count: fields.len(),
            id: (start == 1).then_some(0),
            image: [start, start + 1],
        })
    }

    fn named(line: usize, header: &[String]) -> Result<Self, Error> {
        match (find(line, header, "x")?, find(line, header, "y")?) {
            (Some(x), Some(y)) => {
                Ok(Self { count: header.len(), id: find(line, header, "id")?, image: [x, y] })
            }
            _ => {
                let (header, expected) = (header.join(" "), "x, y, and perhaps id");
                Err(at(line, None, LineProblem::Header { header, expected }))
            }
        }
    }

    fn row(&self, line: usize, fields: &[String]) -> Result<Option<ImagePointRow>, Error> {
        let line = Line::new(line, fields, self.count)?;
        let image = line.image(self.image)?;
        Ok(image.map(|image| ImagePointRow { id: line.named(self.id), image }))
    }
}

/// The place of a column in the header, from 0.
pub(crate) fn find(line: usize, header: &[String], name: &str) -> Result<Option<usize>, Error> {
    let mut places = header.iter().enumerate().filter(|(_, h)| *h == name).map(|(i, _)| i);
    let place = places.next();
    match places.next() {
        Some(twice) => {
            Err(at(line, Some(twice + 1), LineProblem::DuplicateColumn { name: name.into() }))
        }
        None => Ok(place),
    }
}

/// A line's fields and its number.
pub(crate) struct Line<'a> {
    number: usize,
    fields: &'a [String],
}

impl<'a> Line<'a> {
    pub(crate) fn new(number: usize, fields: &'a [String], expected: usize) -> Result<Self, Error> {
        let found = fields.len();
        if found == expected {
            Ok(Self { number, fields })
        } else {
            Err(at(number, None, LineProblem::FieldCount { found, expected }))
        }
    }

    pub(crate) fn text(&self, place: usize) -> &'a str {
        self.fields.get(place).map_or("", String::as_str)
    }

    pub(crate) fn named(&self, place: Option<usize>) -> Option<String> {
        place.map(|p| self.text(p)).filter(|t| !t.is_empty()).map(ToOwned::to_owned)
    }

    pub(crate) fn value(&self, place: usize, name: &str) -> Result<f64, Error> {
        let text = self.text(place);
        match text.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => {
                let problem = LineProblem::NotANumber { name: name.into(), text: text.to_owned() };
                Err(at(self.number, Some(place + 1), problem))
            }
        }
    }

    /// Both coordinates, or neither.
    pub(crate) fn image(&self, [x, y]: [usize; 2]) -> Result<Option<[f64; 2]>, Error> {
        match (self.text(x).is_empty(), self.text(y).is_empty()) {
            (true, true) => Ok(None),
            (false, false) => Ok(Some([self.value(x, "x")?, self.value(y, "y")?])),
            _ => Err(at(self.number, None, LineProblem::HalfAnImagePoint)),
        }
    }
}

fn bad_header(line: usize, header: &[String]) -> Error {
    let expected = "X, Y, Z, and perhaps id, x, y, note";
    at(line, None, LineProblem::Header { header: header.join(" "), expected })
}
