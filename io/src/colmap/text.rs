//! The text form.

use std::fmt::Write as _;
use std::str::FromStr;

use super::{Camera, Image, Observation, Point, Reconstruction, model_name};
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};

/// The fields of a line.
struct Fields<'a> {
    line: usize,
    column: usize,
    rest: &'a str,
    expected: usize,
}

impl<'a> Fields<'a> {
    /// Of a line (from 1) that has `expected` fields at least.
    fn new(line: usize, text: &'a str, expected: usize) -> Self {
        Self { line, column: 0, rest: text.trim(), expected }
    }

    fn error(&self, column: Option<usize>, problem: LineProblem) -> Error {
        ErrorKind::Line { line: self.line, column, problem }.into()
    }

    /// The next field, where there is one.
    fn field(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        self.column += 1;
        let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
        let (field, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        Some(field)
    }

    fn needed(&mut self) -> Result<&'a str, Error> {
        let (found, expected) = (self.column, self.expected);
        let error = self.error(None, LineProblem::FieldCount { found, expected });
        self.field().ok_or(error)
    }

    fn parsed<T: FromStr>(&mut self, name: &str) -> Result<T, Error> {
        let text = self.needed()?;
        self.parse(text, name)
    }

    fn parse<T: FromStr>(&self, text: &str, name: &str) -> Result<T, Error> {
        text.parse().map_err(|_| {
            let problem = LineProblem::NotANumber { name: name.into(), text: text.into() };
            self.error(Some(self.column), problem)
        })
    }

    fn number(&mut self, name: &str) -> Result<f64, Error> {
        let text = self.needed()?;
        match self.parse::<f64>(text, name)? {
            v if v.is_finite() => Ok(v),
            _ => {
                let problem = LineProblem::NotANumber { name: name.into(), text: text.into() };
                Err(self.error(Some(self.column), problem))
            }
        }
    }

    fn numbers<const N: usize>(&mut self, names: [&str; N]) -> Result<[f64; N], Error> {
        let mut values = [0.0; N];
        for (value, name) in values.iter_mut().zip(names) {
            *value = self.number(name)?;
        }
        Ok(values)
    }
}

/// The lines that are no comments, with their numbers from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    (1..).zip(text.lines()).filter(|(_, line)| !line.trim_start().starts_with('#'))
}

fn twice(what: &str, id: impl ToString) -> Error {
    let (name, first) = (id.to_string(), "an earlier one".into());
    FieldError::new(what, FieldProblem::DuplicateName { name, first }).into()
}

pub(super) fn cameras(text: &str, model: &mut Reconstruction) -> Result<(), Error> {
    for (line, text) in lines(text).filter(|(_, line)| !line.trim().is_empty()) {
        let mut fields = Fields::new(line, text, 5);
        let id: u32 = fields.parsed("CAMERA_ID")?;
        let name = fields.needed()?;
        let Some(name) = model_name(name) else {
            let expected = "one of COLMAP's camera models";
            let problem = LineProblem::Version { found: name.into(), expected };
            return Err(fields.error(Some(2), problem));
        };
        let (width, height) = (fields.parsed("WIDTH")?, fields.parsed("HEIGHT")?);
        let mut parameters = Vec::new();
        while !fields.rest.is_empty() {
            parameters.push(fields.number("PARAMS")?);
        }
        let camera = Camera { model: name, width, height, parameters };
        if model.cameras.insert(id, camera).is_some() {
            return Err(twice("camera", id));
        }
    }
    Ok(())
}

/// Two lines an image, the second of which may be empty.
pub(super) fn images(text: &str, model: &mut Reconstruction) -> Result<(), Error> {
    let mut lines = lines(text);
    while let Some((line, text)) = lines.next() {
        if text.trim().is_empty() {
            continue;
        }
        let mut fields = Fields::new(line, text, 10);
        let id: u32 = fields.parsed("IMAGE_ID")?;
        let quaternion_wxyz = fields.numbers(["QW", "QX", "QY", "QZ"])?;
        let translation = fields.numbers(["TX", "TY", "TZ"])?;
        let camera = fields.parsed("CAMERA_ID")?;
        // A file's name may have spaces.
        let name = fields.rest.to_owned();
        fields.needed()?;
        let mut observations = Vec::new();
        let (line, text) = lines.next().unwrap_or((line + 1, ""));
        let mut fields = Fields::new(line, text, 3);
        while !fields.rest.is_empty() {
            fields.expected = fields.column + 3;
            let image = fields.numbers(["X", "Y"])?;
            let point: i64 = fields.parsed("POINT3D_ID")?;
            observations.push(Observation { image, point: u64::try_from(point).ok() });
        }
        let image = Image { name, camera, quaternion_wxyz, translation, observations };
        if model.images.insert(id, image).is_some() {
            return Err(twice("image", id));
        }
    }
    Ok(())
}

pub(super) fn points(text: &str, model: &mut Reconstruction) -> Result<(), Error> {
    for (line, text) in lines(text).filter(|(_, line)| !line.trim().is_empty()) {
        let mut fields = Fields::new(line, text, 8);
        let id: u64 = fields.parsed("POINT3D_ID")?;
        let world = fields.numbers(["X", "Y", "Z"])?;
        let color = [fields.parsed("R")?, fields.parsed("G")?, fields.parsed("B")?];
        let error = fields.number("ERROR")?;
        let mut track = Vec::new();
        while !fields.rest.is_empty() {
            fields.expected = fields.column + 2;
            track.push((fields.parsed("IMAGE_ID")?, fields.parsed("POINT2D_IDX")?));
        }
        if model.points.insert(id, Point { world, color, error, track }).is_some() {
            return Err(twice("point", id));
        }
    }
    Ok(())
}

/// The three texts; numbers with as many digits as bring back the same 64 bits.
pub(super) fn write(model: &Reconstruction) -> [String; 3] {
    let mut cameras = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for (id, c) in &model.cameras {
        let _ = write!(cameras, "{id} {} {} {}", c.model, c.width, c.height);
        c.parameters.iter().for_each(|p| {
            let _ = write!(cameras, " {p}");
        });
        cameras.push('\n');
    }
    let mut images = String::from(
        "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n",
    );
    for (id, image) in &model.images {
        let _ = write!(images, "{id}");
        for v in image.quaternion_wxyz.iter().chain(&image.translation) {
            let _ = write!(images, " {v}");
        }
        let _ = writeln!(images, " {} {}", image.camera, image.name);
        for (i, Observation { image: [x, y], point }) in image.observations.iter().enumerate() {
            let space = if i > 0 { " " } else { "" };
            let _ = match point {
                Some(point) => write!(images, "{space}{x} {y} {point}"),
                None => write!(images, "{space}{x} {y} -1"),
            };
        }
        images.push('\n');
    }
    let mut points =
        String::from("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n");
    for (id, Point { world: [x, y, z], color: [r, g, b], error, track }) in &model.points {
        let _ = write!(points, "{id} {x} {y} {z} {r} {g} {b} {error}");
        track.iter().for_each(|(image, index)| {
            let _ = write!(points, " {image} {index}");
        });
        points.push('\n');
    }
    [cameras, images, points]
}
