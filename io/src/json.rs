//! Documents of the program's own formats: a header, then a body of known fields.

mod formatter;
mod header;
mod message;
pub(crate) mod object;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::atomic::write_atomically;
use crate::error::{Error, ErrorKind, FieldError};

pub(crate) use formatter::to_text;
pub(crate) use header::kind_of;
use header::{Body, Headed};

/// The longest text that is read: a gibibyte, past any camera or scene and most reconstructions.
pub(crate) const MAX_TEXT_BYTES: u64 = 1 << 30;

/// A file of one of the program's own formats (`docs/formats.md`).
///
/// Reading refuses unknown fields and versions, and values outside their domain; writing refuses the same values, so
/// that what was written can be read. Numbers survive the round trip to the last bit.
pub trait Document: Serialize + DeserializeOwned {
    /// The kind, as the header says it.
    const KIND: &'static str;
    /// The version that is read and written.
    const VERSION: u64;

    /// Refuses values that have the right shape and make no sense.
    ///
    /// # Errors
    /// The first bad field and what is wrong with it.
    fn check(&self) -> Result<(), FieldError>;

    /// From text.
    ///
    /// # Errors
    /// [`ErrorKind::Json`], [`ErrorKind::NotOurs`], [`ErrorKind::WrongKind`], [`ErrorKind::Version`] or
    /// [`ErrorKind::Field`].
    fn parse(text: &str) -> Result<Self, Error> {
        header::check(text, Self::KIND, Self::VERSION)?;
        let Body(document) = from_text::<Body<Self>>(text)?;
        document.check()?;
        Ok(document)
    }

    /// From a file.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and [`ErrorKind::Read`], [`ErrorKind::TooLong`], [`ErrorKind::NotText`].
    fn read(path: &Path) -> Result<Self, Error> {
        read_text(path).and_then(|text| Self::parse(&text)).map_err(|e| e.in_file(path))
    }

    /// To text.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] where [`check`](Self::check) refuses a value.
    fn to_json(&self) -> Result<String, Error> {
        self.check()?;
        to_text(&Headed { collinear: Self::KIND, version: Self::VERSION, body: self })
    }

    /// To a file, atomically.
    ///
    /// # Errors
    /// As [`to_json`](Self::to_json) and [`write_atomically`].
    fn write(&self, path: &Path) -> Result<(), Error> {
        let text = self.to_json().map_err(|e| e.in_file(path))?;
        write_atomically(path, |w| w.write_all(text.as_bytes()))
    }
}

/// A text file, without a byte order mark.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    text_of(read_bytes(path, MAX_TEXT_BYTES)?)
}

/// The text of a file's bytes, without a byte order mark.
pub(crate) fn text_of(bytes: Vec<u8>) -> Result<String, Error> {
    let mut text = String::from_utf8(bytes)
        .map_err(|e| ErrorKind::NotText { valid_up_to: e.utf8_error().valid_up_to() })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// A file of limited length.
pub(crate) fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    read_rest(&mut File::open(path).map_err(ErrorKind::Read)?, vec![], limit)
}

/// What follows the bytes that were read of an open file; with them not longer than the limit.
pub(crate) fn read_rest(file: &mut File, start: Vec<u8>, limit: u64) -> Result<Vec<u8>, Error> {
    let length = file.metadata().map_err(ErrorKind::Read)?.len();
    if length > limit {
        return Err(ErrorKind::TooLong { bytes: length, limit }.into());
    }
    // A pipe or a device does not say how long it is.
    let mut bytes = start;
    let most = (limit + 1).saturating_sub(bytes.len() as u64);
    file.take(most).read_to_end(&mut bytes).map_err(ErrorKind::Read)?;
    match bytes.len() as u64 {
        bytes if bytes > limit => Err(ErrorKind::TooLong { bytes, limit }.into()),
        _ => Ok(bytes),
    }
}

/// Any JSON, its errors with the path to the bad field.
pub(crate) fn from_text<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    let mut json = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut json)
        .map_err(|e| message::explain(&message::path(e.path()), e.inner()))?;
    json.end().map_err(|e| message::explain("", &e))?;
    Ok(value)
}
