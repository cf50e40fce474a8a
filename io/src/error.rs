//! What can be wrong with a file, and where in it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use collinear::error::Brief;

/// Why a file could not be read or written.
///
/// Its text starts with the file, where there is one, and goes on with the field, line or column. A file that another one
/// names comes after that one and the field: `town.json: photographs[0].camera: south.json: cannot be read: …`.
#[derive(Debug)]
pub struct Error(Box<Inner>);

#[derive(Debug)]
struct Inner {
    path: Option<PathBuf>,
    kind: ErrorKind,
    reference: Option<Reference>,
}

/// The field that names a file, and the file that has it.
#[derive(Debug)]
struct Reference {
    path: Option<PathBuf>,
    field: String,
}

impl Error {
    pub(crate) fn new(kind: impl Into<ErrorKind>) -> Self {
        Self(Box::new(Inner { path: None, kind: kind.into(), reference: None }))
    }

    /// Adds the file, unless it is known. Where an inner file and the [field](Self::field) that names it are, as the one that
    /// has the field.
    #[must_use]
    pub fn in_file(mut self, path: &Path) -> Self {
        let known = match &mut self.0.reference {
            Some(reference) => &mut reference.path,
            None => &mut self.0.path,
        };
        known.get_or_insert_with(|| path.to_owned());
        self
    }

    /// Adds the field, of a file that [`in_file`](Self::in_file) may add, which names the error's file.
    pub(crate) fn named_by(mut self, field: impl Into<String>) -> Self {
        self.0.reference.get_or_insert_with(|| Reference { path: None, field: field.into() });
        self
    }

    /// The file, where the input was one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.0.path.as_deref()
    }

    /// The field that names the file, where another file does, as `photographs[0].camera`.
    #[must_use]
    pub fn field(&self) -> Option<&str> {
        self.0.reference.as_ref().map(|r| r.field.as_str())
    }

    /// What is wrong.
    #[must_use]
    pub fn kind(&self) -> &ErrorKind {
        &self.0.kind
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Reference { path, field }) = &self.0.reference {
            if let Some(path) = path {
                write!(f, "{}: ", path.display())?;
            }
            write!(f, "{field}: ")?;
        }
        match &self.0.path {
            Some(path) => write!(f, "{}: {}", path.display(), self.0.kind),
            None => self.0.kind.fmt(f),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        std::error::Error::source(&self.0.kind)
    }
}

impl<K: Into<ErrorKind>> From<K> for Error {
    fn from(kind: K) -> Self {
        Self::new(kind)
    }
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The operating system could not read it.
    #[error("cannot be read: {0}")]
    Read(#[source] io::Error),
    /// The operating system could not write it, or the encoder gave up. What stood there before still stands there.
    #[error("cannot be written: {0}")]
    Write(#[source] io::Error),
    /// The output's folder is not there and cannot be made.
    #[error("its folder {} cannot be made: {source}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// The output is a directory, or is written as one.
    #[error("is a folder: name a file in it")]
    IsAFolder,
    /// The output exists and is a device or a pipe.
    #[error("is not a regular file: it cannot be replaced by one, name another output")]
    NotAFile,
    /// The output is a symbolic link that leads to no file.
    #[error("is a link that leads to no file: remove it, or name another output ({0})")]
    BrokenLink(#[source] io::Error),
    /// The output exists and is write-protected.
    #[error("is write-protected: change its permissions or name another output")]
    ReadOnly,
    /// The file is longer than its reader takes.
    #[error("is {bytes} bytes long, the limit is {limit}")]
    TooLong {
        /// Its length.
        bytes: u64,
        /// The longest that is read.
        limit: u64,
    },
    /// A text file is not UTF-8.
    #[error("is not UTF-8 text from byte {valid_up_to} on")]
    NotText {
        /// Bytes before the first that is not.
        valid_up_to: usize,
    },
    /// JSON that is malformed, or does not have the documented shape.
    #[error("{}{message} (line {line}, column {column})", prefix(field))]
    Json {
        /// The path to the bad field, as `polygons[3].vertices[1][2]`; empty at the top.
        field: String,
        /// What was expected and what was found.
        message: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1, where the reader noticed: the end of the bad value.
        column: usize,
    },
    /// JSON, but no document of this program.
    #[error(
        "is not a collinear {expected} file: such a file starts {{\"collinear\": \"{expected}\", \"version\": {version}, … (docs/formats.md)"
    )]
    NotOurs {
        /// The kind of document wanted.
        expected: &'static str,
        /// The version that this program reads.
        version: u64,
    },
    /// A document of another kind.
    #[error("is a collinear {found} file, a {expected} file is needed here")]
    WrongKind {
        /// The kind of document wanted.
        expected: &'static str,
        /// The kind that it says it is.
        found: String,
    },
    /// A version of a format that this program does not know.
    #[error(
        "has version {found} of the {kind} format, this program reads version {supported}: update collinear, or write the file in version {supported} (docs/formats.md)"
    )]
    Version {
        /// The kind of document.
        kind: &'static str,
        /// The version that the file states.
        found: u64,
        /// The version that is read.
        supported: u64,
    },
    /// A field has the right shape and a wrong value.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A table without a line: neither a header nor a point.
    #[error("is empty: neither a header nor a point is in it")]
    NoLines,
    /// A line of a table is wrong.
    #[error("line {line}{}: {problem}", column_suffix(*column))]
    Line {
        /// Line, from 1.
        line: usize,
        /// The field in the line, from 1, where one is to blame.
        column: Option<usize>,
        /// What is wrong with it.
        problem: LineProblem,
    },
    /// A picture cannot be decoded or encoded.
    #[error(transparent)]
    Picture(#[from] PictureProblem),
    /// A geoid grid cannot be read.
    #[error(transparent)]
    Grid(#[from] GridProblem),
    /// A file without cameras, or of a kind that is not known.
    #[error(
        "holds no cameras that are read here: a camera file, an OpenSfM reconstruction, a folder of COLMAP's, Bundler's bundle.out, an OpenCV calibration, Metashape's XML, Pix4D's parameters, a table of orientations, glTF or transforms.json (docs/coming-from.md)"
    )]
    NotCameras,
    /// A format without the size of its pictures, and none was given.
    #[error("does not say how large its pictures are: give their width and height")]
    NoPictureSize,
    /// A folder that holds a file which COLMAP would read in place of what is to be written, or beside it.
    #[error("holds {file}, which COLMAP would read too: name another folder, or remove that file")]
    FolderTaken {
        /// The file's name.
        file: String,
    },
    /// Orientations without an interior orientation, and none was given.
    #[error(
        "is a table of exterior orientations: give the camera, which has the interior orientation"
    )]
    NoInterior,
    /// An interior orientation was given for a file that has its own.
    #[error("has interior orientations of its own: leave the other camera out")]
    OwnInterior,
    /// A file that should give one interior orientation has several.
    #[error("has cameras of {count} different interior orientations, one is needed here")]
    SeveralInteriors {
        /// How many there are.
        count: usize,
    },
    /// Angles without a unit, and none was given.
    #[error("does not say the unit of its angles: give degrees, gon or radians")]
    NoAngleUnit,
    /// A text of another program is not in its format.
    #[error("is no file of {program}'s: {reason}")]
    Foreign {
        /// The program.
        program: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A binary file of another program cannot be read.
    #[error(transparent)]
    Binary(#[from] BinaryProblem),
    /// A rational polynomial camera cannot be read.
    #[error(transparent)]
    Rpc(#[from] RpcProblem),
    /// The extension of an output names no format that is written.
    #[error("has {}: name the output {expected}", extension(found.as_deref()))]
    Extension {
        /// The extension, without its dot.
        found: Option<String>,
        /// The ones that are known, in words.
        expected: &'static str,
    },
    /// A picture does not have the size that its camera states.
    #[error(
        "is {} × {} pixels, its camera says {} × {}: a camera belongs to one picture size, scale either",
        picture[0], picture[1], camera[0], camera[1]
    )]
    PictureSize {
        /// Width and height of the picture.
        picture: [u32; 2],
        /// Width and height in the camera file.
        camera: [u32; 2],
    },
    /// A reconstruction that a file does not hold.
    #[error("holds {count} reconstructions, number {index} (from 0) is not among them")]
    NoReconstruction {
        /// The number asked for, from 0.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The library refuses the values.
    #[error("{}{source}", prefix(field))]
    Library {
        /// The path to the field that holds them.
        field: String,
        /// Its reason.
        source: collinear::Error,
    },
}

/// A field and what is wrong with its value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{problem}", prefix(field))]
pub struct FieldError {
    /// The path to the field, as `polygons[3].coordinates`.
    pub field: String,
    /// What is wrong.
    pub problem: FieldProblem,
}

impl FieldError {
    pub(crate) fn new(field: impl Into<String>, problem: FieldProblem) -> Self {
        Self { field: field.into(), problem }
    }

    /// The same error seen from the object that holds the field's object under `outer`.
    pub(crate) fn under(self, outer: &str) -> Self {
        let dot = if self.field.is_empty() || self.field.starts_with('[') { "" } else { "." };
        Self { field: format!("{outer}{dot}{}", self.field), problem: self.problem }
    }
}

/// What is wrong with a value of the right shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldProblem {
    /// A number outside its domain.
    #[error("is {}, expected {expected}", Brief(*value))]
    OutOfRange {
        /// The number.
        value: f64,
        /// The domain, in words.
        expected: &'static str,
    },
    /// A field that may be left out elsewhere.
    #[error("is not given, and is needed where the camera stands in a world")]
    NotGiven,
    /// A vector that must have a direction, or a length of one, has not.
    #[error("has length {}, expected {expected}", Brief(*norm))]
    Length {
        /// Its length.
        norm: f64,
        /// The length it must have, in words.
        expected: &'static str,
    },
    /// A matrix that is no rotation.
    #[error(
        "is no rotation: rows of unit length at right angles are needed, R Rᵀ is off by {}",
        Brief(*deviation)
    )]
    NotARotation {
        /// The largest entry of R Rᵀ − 1.
        deviation: f64,
    },
    /// A matrix that mirrors.
    #[error("mirrors: its determinant is −1, exchange an axis or its sign")]
    Mirrors,
    /// A matrix that has no inverse.
    #[error(
        "has no inverse: its determinant is {} after scaling to entries of one",
        Brief(*determinant)
    )]
    Singular {
        /// The determinant after division by the largest entry.
        determinant: f64,
    },
    /// The direction given as up is the normal itself.
    #[error("is parallel to the normal: give a direction that lies more along the plane")]
    ParallelToNormal,
    /// A list with too few entries.
    #[error("has {found} entries, at least {needed} are needed")]
    TooFew {
        /// How many there are.
        found: usize,
        /// How many there must be.
        needed: usize,
    },
    /// A list whose length belongs to another's.
    #[error("has {found} entries, {expected} are needed: one for each of {of}")]
    Count {
        /// How many there are.
        found: usize,
        /// How many there must be.
        expected: usize,
        /// What they are counted by.
        of: &'static str,
    },
    /// A name that refers to nothing.
    #[error("names {what} `{name}`, which is not there: {}", list(known))]
    UnknownName {
        /// What it should name.
        what: &'static str,
        /// The name.
        name: String,
        /// The names that are there.
        known: Vec<String>,
    },
    /// A name given twice.
    #[error("is `{name}` like {first}: names must differ")]
    DuplicateName {
        /// The name.
        name: String,
        /// The path to its first use.
        first: String,
    },
    /// A principal point that a format without one cannot say.
    #[error(
        "lies {} right of and {} below the picture's middle, in pixels, and {program} has it there: rectify the photograph about its principal point, or use a matrix",
        Brief(off[0]), Brief(off[1])
    )]
    OffTheMiddle {
        /// By how many pixels, right and down.
        off: [f64; 2],
        /// The format.
        program: &'static str,
    },
    /// A model that cannot be used here.
    #[error("is `{found}`: {expected}")]
    Unsupported {
        /// The model found.
        found: String,
        /// What is supported, and what to do.
        expected: &'static str,
    },
}

/// What is wrong with a line of a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineProblem {
    /// A field that should be a number.
    #[error("{name} is `{text}`, expected a finite number{}", decimal_comma(text))]
    NotANumber {
        /// The column's name.
        name: String,
        /// What stands there.
        text: String,
    },
    /// The last line of a file that should have more.
    #[error("the file ends, expected the {name}")]
    EndsEarly {
        /// What should come next.
        name: String,
    },
    /// A number that should be above zero.
    #[error("{name} is {text}, expected a number above 0")]
    NotPositive {
        /// The column's name.
        name: String,
        /// What stands there.
        text: String,
    },
    /// A name that is empty.
    #[error("{name} is empty, expected a name")]
    NoName {
        /// The column's name.
        name: String,
    },
    /// A line with more or fewer fields than the table has columns.
    #[error("has {found} fields, expected {expected}")]
    FieldCount {
        /// The number found.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A header without the columns that are needed.
    #[error("the header is `{header}`, expected the columns {expected}")]
    Header {
        /// The header.
        header: String,
        /// The columns that are needed, in words.
        expected: &'static str,
    },
    /// A header that names a column twice.
    #[error("the column `{name}` stands there twice")]
    DuplicateColumn {
        /// The column's name.
        name: String,
    },
    /// One of the two image coordinates without the other.
    #[error("has one of x and y without the other")]
    HalfAnImagePoint,
    /// A quotation mark without its partner.
    #[error("a quotation mark is not closed in this line")]
    UnclosedQuote,
    /// A version of a table that is not known.
    #[error("says `{found}`, expected {expected}")]
    Version {
        /// What the file says.
        found: String,
        /// What is read.
        expected: &'static str,
    },
}

/// Why a picture cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureProblem {
    /// Neither PNG, JPEG nor TIFF, whatever its extension says.
    #[error("is neither PNG, JPEG nor TIFF: it starts with {start}")]
    NotAPicture {
        /// The first bytes, in hexadecimal.
        start: String,
    },
    /// Its header says that it has no pixels.
    #[error("is {width} × {height} pixels: a picture needs at least one")]
    Empty {
        /// Width.
        width: u32,
        /// Height.
        height: u32,
    },
    /// More pixels than its reader or its format takes.
    #[error("is {width} × {height} pixels, the limit is {limit}")]
    TooLarge {
        /// Width.
        width: u32,
        /// Height.
        height: u32,
        /// The limit, in words.
        limit: String,
    },
    /// The file ends before the picture does.
    #[error("is cut off after {bytes} bytes, before the end of the picture")]
    Truncated {
        /// Bytes that are there.
        bytes: usize,
    },
    /// The decoder cannot make sense of it.
    #[error("is damaged, or of a kind that is not supported: {reason}")]
    Damaged {
        /// The decoder's reason.
        reason: String,
    },
    /// A number of channels that the format cannot hold.
    #[error("has {channels} channels, {format} takes {allowed}")]
    Channels {
        /// The number of channels.
        channels: u8,
        /// The format.
        format: &'static str,
        /// What it takes, in words.
        allowed: &'static str,
    },
    /// The samples do not fill the picture.
    #[error("has {found} samples, its size needs {expected}")]
    SampleCount {
        /// Samples there are.
        found: usize,
        /// Samples there should be.
        expected: u64,
    },
}

/// Why a binary file of another program cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BinaryProblem {
    /// The file ends too early.
    #[error("is cut off: the {what} at byte {offset} is not there")]
    CutOff {
        /// What should stand there.
        what: &'static str,
        /// Where.
        offset: u64,
    },
    /// A number that makes no sense.
    #[error("is damaged: the {what} at byte {offset} is {found}")]
    Value {
        /// What stands there.
        what: &'static str,
        /// Where.
        offset: u64,
        /// The number.
        found: u64,
    },
    /// A number that is NaN or infinite.
    #[error("the {what} at byte {offset} is NaN or infinite")]
    NotFinite {
        /// What stands there.
        what: &'static str,
        /// Where.
        offset: u64,
    },
    /// Text that is not UTF-8.
    #[error("the {what} at byte {offset} is not UTF-8 text")]
    NotText {
        /// What stands there.
        what: &'static str,
        /// Where.
        offset: u64,
    },
    /// Bytes after the end.
    #[error("has {bytes} bytes more than its counts say, from byte {offset} on")]
    Extra {
        /// How many.
        bytes: u64,
        /// Where.
        offset: u64,
    },
}

/// Why a geoid grid cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridProblem {
    /// The file's length is not that of its header and grid.
    #[error("is {bytes} bytes long, a grid of {rows} rows and {columns} columns needs {expected}")]
    FileLength {
        /// Its length.
        bytes: u64,
        /// Rows in the header.
        rows: i32,
        /// Columns in the header.
        columns: i32,
        /// The length that follows.
        expected: u64,
    },
    /// Too short for a header.
    #[error("is {bytes} bytes long, the header alone has 40")]
    NoHeader {
        /// Its length.
        bytes: usize,
    },
    /// A header field that no geoid grid has.
    #[error("{what} is {}, expected {expected}: this is no GTX file", Brief(*value))]
    Header {
        /// Which field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its domain, in words.
        expected: &'static str,
    },
}

/// Why a rational polynomial camera cannot be read from a file of its vendor.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RpcProblem {
    /// None of the formats that are read.
    #[error(
        "holds no rational polynomial camera: RPB, _RPC.TXT, DIMAP XML, GDAL's VRT and .aux.xml, OSSIM .geom, GeoTIFF with tag 50844 and collinear's JSON are read"
    )]
    NotAnRpc,
    /// A number that the file does not have.
    #[error("has no {field}")]
    Missing {
        /// The field, as this format names it.
        field: String,
    },
    /// A field that stands in the file twice.
    #[error("line {line}: {field} stands there a second time")]
    Duplicate {
        /// Line, from 1.
        line: usize,
        /// The field.
        field: String,
    },
    /// A field that should be a number.
    #[error("line {line}: {field} is `{text}`, expected a finite number")]
    NotANumber {
        /// Line, from 1.
        line: usize,
        /// The field.
        field: String,
        /// What stands there, at most its first 40 characters.
        text: String,
    },
    /// A list of coefficients of another length.
    #[error("line {line}: {field} has {found} coefficients, expected 20")]
    Coefficients {
        /// Line, from 1.
        line: usize,
        /// The field.
        field: String,
        /// How many there are.
        found: usize,
    },
    /// A line that is no statement of its format.
    #[error("line {line}: `{text}` is no statement: expected {expected}")]
    Statement {
        /// Line, from 1.
        line: usize,
        /// What stands there, at most its first 40 characters.
        text: String,
        /// What should stand there.
        expected: &'static str,
    },
    /// A convention that is not read.
    #[error("line {line}: {field} is `{found}`, expected {expected}")]
    Convention {
        /// Line, from 1.
        line: usize,
        /// The field.
        field: String,
        /// What the file says, at most its first 40 characters.
        found: String,
        /// What is read.
        expected: &'static str,
    },
    /// XML that is not well-formed.
    #[error("is no well-formed XML: {reason}")]
    Xml {
        /// The parser's reason, with line and column.
        reason: String,
    },
    /// A TIFF file whose directory makes no sense, or has no camera.
    #[error("is a TIFF file whose {what} is {found}, expected {expected}")]
    Tiff {
        /// Which part.
        what: &'static str,
        /// What it is.
        found: u64,
        /// What it should be.
        expected: &'static str,
    },
    /// A TIFF file that ends too early.
    #[error("is a TIFF file that is cut off: its {what} at byte {offset} is not there")]
    TiffCutOff {
        /// Which part.
        what: &'static str,
        /// Where it should be.
        offset: u64,
    },
}

fn prefix(field: &str) -> String {
    if field.is_empty() { String::new() } else { format!("{field}: ") }
}

fn column_suffix(column: Option<usize>) -> String {
    column.map_or_else(String::new, |c| format!(", field {c}"))
}

fn extension(found: Option<&str>) -> String {
    found.map_or_else(|| "no extension".into(), |e| format!("the unknown extension `.{e}`"))
}

fn decimal_comma(text: &str) -> &'static str {
    if text.contains(',') { " (with a decimal point)" } else { "" }
}

fn list(known: &[String]) -> String {
    const SHOWN: usize = 8;
    if known.is_empty() {
        return "there are none".into();
    }
    let shown: Vec<String> = known.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    let more = known.len().saturating_sub(SHOWN);
    let rest = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("there are {}{rest}", shown.join(", "))
}
