//! The fields of a line of a table.

use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};

/// An error of a line, and perhaps of a field in it, both from 1.
pub(crate) fn at(line: usize, column: Option<usize>, problem: LineProblem) -> Error {
    ErrorKind::Line { line, column, problem }.into()
}

/// The fields of a line with its number, from 1.
pub(crate) struct Fields<'a> {
    line: usize,
    fields: Vec<&'a str>,
}

impl<'a> Fields<'a> {
    pub(crate) fn new(line: usize, fields: Vec<&'a str>) -> Self {
        Self { line, fields }
    }

    /// The words of a text between blanks.
    pub(crate) fn words(line: usize, text: &'a str) -> Self {
        Self::new(line, text.split_whitespace().collect())
    }

    /// The line's number.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    pub(crate) fn len(&self) -> usize {
        self.fields.len()
    }

    /// Refuses another number of fields.
    pub(crate) fn count(&self, expected: usize) -> Result<(), Error> {
        let found = self.fields.len();
        if found == expected {
            return Ok(());
        }
        Err(at(self.line, None, LineProblem::FieldCount { found, expected }))
    }

    /// A field, empty where there is none.
    pub(crate) fn text(&self, place: usize) -> &'a str {
        self.fields.get(place).copied().unwrap_or_default()
    }

    /// A field that is a finite number.
    pub(crate) fn number(&self, place: usize, name: &str) -> Result<f64, Error> {
        let text = self.text(place);
        text.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
            let text = text.chars().take(40).collect();
            let problem = LineProblem::NotANumber { name: name.into(), text };
            at(self.line, Some(place + 1), problem)
        })
    }

    /// Fields from a place on that are finite numbers.
    pub(crate) fn numbers<const N: usize>(
        &self,
        start: usize,
        names: [&str; N],
    ) -> Result<[f64; N], Error> {
        let mut values = [0.0; N];
        for (i, (value, name)) in values.iter_mut().zip(names).enumerate() {
            *value = self.number(start + i, name)?;
        }
        Ok(values)
    }
}

/// Refuses a photograph's name that a table of words cannot hold: one with a separator in it, or longer than `longest`.
pub(crate) fn plain_name(
    name: &str,
    longest: usize,
    expected: &'static str,
) -> Result<(), FieldError> {
    let separated = |c: char| c.is_whitespace() || c.is_control() || [',', ';', '"'].contains(&c);
    let fits = (1..=longest).contains(&name.chars().count()) && !name.starts_with('#');
    if fits && !name.contains(separated) {
        return Ok(());
    }
    Err(FieldError::new("name", FieldProblem::Unsupported { found: name.into(), expected }))
}
