//! Lists of points as CSV: world coordinates, perhaps with a name and the image coordinates.
//!
//! With a header, columns go by name: `X`, `Y`, `Z` (world) must be there; `id`, `x`, `y` (image, pixels from the
//! top-left corner) and `note` may be; others are passed over. A header with `x`, `y`, `z` and no capitals means the
//! world. Without a header a line has three numbers X, Y, Z, or a name before them. Fields are parted by commas,
//! semicolons, tabs or spaces, whichever the first line has, in that order of preference: tab, semicolon, comma, space.
//! Empty lines and lines that start with `#` are passed over.

use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::{Error, ErrorKind, FieldError, LineProblem};
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
/// [`ErrorKind::Line`] with the line and the field in it.
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
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'))
        .peekable();
    let Some((number, first)) = lines.peek().copied() else { return Ok(Vec::new()) };
    let separator = Separator::of(first);
    let fields = separator.split(number, first)?;
    let columns = match Columns::without_header(&fields) {
        Some(columns) => columns,
        None => {
            lines.next();
            Columns::named(number, &fields)?
        }
    };
    lines.map(|(number, line)| columns.row(number, &separator.split(number, line)?)).collect()
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

/// A field as CSV has it. A line break inside would end the line for this reader, so it becomes a space.
fn quoted(text: &str) -> String {
    let line = text.replace(['\n', '\r'], " ");
    let plain =
        !line.contains([',', ';', '\t', '"']) && line.trim() == line && !line.starts_with('#');
    if plain { line } else { format!("\"{}\"", line.replace('"', "\"\"")) }
}

enum Separator {
    Character(char),
    Spaces,
}

impl Separator {
    fn of(line: &str) -> Self {
        ['\t', ';', ',']
            .into_iter()
            .find(|c| line.contains(*c))
            .map_or(Self::Spaces, Self::Character)
    }

    fn split(&self, number: usize, line: &str) -> Result<Vec<String>, Error> {
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
        let find = |name: &str| -> Result<Option<usize>, Error> {
            let mut places = header.iter().enumerate().filter(|(_, h)| *h == name).map(|(i, _)| i);
            let place = places.next();
            match places.next() {
                Some(twice) => Err(at(
                    line,
                    Some(twice + 1),
                    LineProblem::DuplicateColumn { name: name.into() },
                )),
                None => Ok(place),
            }
        };
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
        if fields.len() != self.count {
            let problem = LineProblem::FieldCount { found: fields.len(), expected: self.count };
            return Err(at(line, None, problem));
        }
        let text = |place: usize| fields.get(place).map_or("", String::as_str);
        let number = |place: usize, name: &str| match text(place).parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => {
                let problem =
                    LineProblem::NotANumber { name: name.into(), text: text(place).to_owned() };
                Err(at(line, Some(place + 1), problem))
            }
        };
        let named =
            |place: Option<usize>| place.map(text).filter(|t| !t.is_empty()).map(ToOwned::to_owned);
        let [wx, wy, wz] = self.world;
        let image = match self.image {
            Some([x, y]) => match (text(x).is_empty(), text(y).is_empty()) {
                (true, true) => None,
                (false, false) => Some([number(x, "x")?, number(y, "y")?]),
                _ => return Err(at(line, None, LineProblem::HalfAnImagePoint)),
            },
            None => None,
        };
        Ok(PointRow {
            id: named(self.id),
            world: [number(wx, "X")?, number(wy, "Y")?, number(wz, "Z")?],
            image,
            note: named(self.note),
        })
    }
}

fn bad_header(line: usize, header: &[String]) -> Error {
    at(line, None, LineProblem::Header { header: header.join(" ") })
}

fn at(line: usize, column: Option<usize>, problem: LineProblem) -> Error {
    ErrorKind::Line { line, column, problem }.into()
}
