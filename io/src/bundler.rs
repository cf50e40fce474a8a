//! Bundler: `bundle.out`, version 0.3.
//!
//! Bundler's camera looks along −z with y up, and its image coordinates count from the middle of the picture, x right, y up:
//!
//! ```text
//! P = R X + t,   p = −P/P.z,   image = f (1 + k₁|p|² + k₂|p|⁴) p
//! ```
//! (Snavely 2008, *Bundler v0.3 user's manual*). So camera axes are turned half about x, and a pixel is (W/2 + x, H/2 − y). The file
//! has no picture sizes: they come from outside.

use std::fmt::Write as _;
use std::path::Path;
use std::str::{FromStr, SplitWhitespace};

use collinear::geometry::rotation::camera_from_photo;
use collinear::nalgebra::{Matrix3, Vector3};

use crate::camera::{CameraFile, Exterior, Interior, Rotation};
use crate::check::finite;
use crate::error::{Error, ErrorKind, FieldError, FieldProblem, LineProblem};
use crate::json::{Document, read_text};

/// What the file starts with.
const HEADER: &str = "# Bundle file v0.3";

/// No list is made longer than this before its entries were read.
const MOST_AHEAD: usize = 1 << 16;

/// A reconstruction as Bundler has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bundle {
    /// One a photograph; those that were not registered have a focal length of 0.
    pub cameras: Vec<Camera>,
    /// The points with what was measured of them.
    pub points: Vec<Point>,
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// f in pixels; 0 where the photograph was not registered.
    pub focal: f64,
    /// k₁ and k₂.
    pub k: [f64; 2],
    /// The rows of R, into axes x right, y up, looking along −z.
    pub rotation: [[f64; 3]; 3],
    /// t, world units.
    pub translation: [f64; 3],
}

/// A point.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// World coordinates.
    pub world: [f64; 3],
    /// Red, green, blue.
    pub color: [u8; 3],
    /// Where it was seen.
    pub views: Vec<View>,
}

/// A point seen in a photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The number of its camera, from 0.
    pub camera: usize,
    /// The number of the feature there.
    pub key: u32,
    /// Pixels from the middle of the picture, x right, y up.
    pub image: [f64; 2],
}

impl View {
    /// Pixels from the top-left corner of a picture of this size.
    #[must_use]
    pub fn pixel(&self, [width, height]: [u32; 2]) -> [f64; 2] {
        [0.5 * f64::from(width) + self.image[0], 0.5 * f64::from(height) - self.image[1]]
    }
}

/// The words of a text with the numbers of their lines.
pub(crate) struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    words: SplitWhitespace<'a>,
    line: usize,
    /// What the words belong to: its kind, its number and how many there are.
    entry: Option<(&'static str, usize, usize)>,
}

impl<'a> Words<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self { lines: text.lines().enumerate(), words: "".split_whitespace(), line: 1, entry: None }
    }

    /// What the next words belong to: entry `number`, from 0, of `count`.
    pub(crate) fn enter(&mut self, kind: &'static str, number: usize, count: usize) {
        self.entry = Some((kind, number, count));
    }

    /// A word's name with what it belongs to.
    fn named(&self, name: &str) -> String {
        match self.entry {
            Some((kind, number, count)) => format!("{name} of {kind} {number} (of {count})"),
            None => name.to_owned(),
        }
    }

    /// The line of the last word, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The next word, where there is one.
    pub(crate) fn rest(&mut self) -> Option<&'a str> {
        self.next("").ok()
    }

    fn next(&mut self, name: &str) -> Result<&'a str, Error> {
        loop {
            if let Some(word) = self.words.next() {
                return Ok(word);
            }
            match self.lines.next() {
                Some((line, text)) => (self.line, self.words) = (line + 1, text.split_whitespace()),
                None => {
                    let problem = LineProblem::EndsEarly { name: self.named(name) };
                    return Err(ErrorKind::Line { line: self.line, column: None, problem }.into());
                }
            }
        }
    }

    fn not_a_number(&self, name: &str, text: &str) -> Error {
        let text = text.chars().take(40).collect();
        let problem = LineProblem::NotANumber { name: self.named(name), text };
        ErrorKind::Line { line: self.line, column: None, problem }.into()
    }

    pub(crate) fn parsed<T: FromStr>(&mut self, name: &str) -> Result<T, Error> {
        let word = self.next(name)?;
        word.parse().map_err(|_| self.not_a_number(name, word))
    }

    fn number(&mut self, name: &str) -> Result<f64, Error> {
        let word = self.next(name)?;
        let value = word.parse().ok().filter(|v: &f64| v.is_finite());
        value.ok_or_else(|| self.not_a_number(name, word))
    }

    pub(crate) fn numbers<const N: usize>(&mut self, name: &str) -> Result<[f64; N], Error> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number(name)?;
        }
        Ok(values)
    }
}

/// Refuses the number of something that is not there.
pub(crate) fn known(
    entry: &str,
    what: &'static str,
    number: usize,
    count: usize,
    line: usize,
) -> Result<(), Error> {
    if number < count {
        return Ok(());
    }
    let known = match count {
        0 => vec![],
        _ => vec![format!("0 to {}", count - 1)],
    };
    let problem = FieldProblem::UnknownName { what, name: number.to_string(), known };
    Err(FieldError::new(format!("{entry} in line {line}"), problem).into())
}

impl Bundle {
    /// From a file.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and those of reading.
    pub fn read(path: &Path) -> Result<Self, Error> {
        read_text(path).and_then(|text| Self::parse(&text)).map_err(|e| e.in_file(path))
    }

    /// From text.
    ///
    /// # Errors
    /// [`ErrorKind::Line`] with the line, [`ErrorKind::Field`] for a view of a camera that is not there.
    ///
    /// # Example
    /// f = 500, 2 right and 1 up at depth 10: (100, 50) from the middle, y up.
    ///
    /// ```
    /// use collinear::nalgebra::{Point2, Point3};
    /// use collinear_io::bundler::Bundle;
    ///
    /// let text = "# Bundle file v0.3\n1 1\n500 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n2 1 -10\n255 0 0\n1 0 7 100 50\n";
    /// let bundle = Bundle::parse(text)?;
    /// let (_, camera) = &bundle.photographs([640, 480])?[0];
    /// let image = camera.camera()?.sensor().project(&Point3::new(2.0, 1.0, -10.0))?;
    /// assert_eq!(image, Point2::new(420.0, 190.0));
    /// assert_eq!(bundle.points[0].views[0].pixel([640, 480]), [420.0, 190.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, Error> {
        let first = text.lines().next().unwrap_or_default();
        if first.trim_end() != HEADER {
            let found = first.chars().take(40).collect();
            let problem = LineProblem::Version { found, expected: "`# Bundle file v0.3`" };
            return Err(ErrorKind::Line { line: 1, column: None, problem }.into());
        }
        let mut words = Words::new(text);
        words.lines.next();
        let cameras: usize = words.parsed("number of cameras")?;
        let points: usize = words.parsed("number of points")?;
        let mut bundle = Self {
            cameras: Vec::with_capacity(cameras.min(MOST_AHEAD)),
            points: Vec::with_capacity(points.min(MOST_AHEAD)),
        };
        for i in 0..cameras {
            words.enter("camera", i, cameras);
            let [focal, k1, k2] = words.numbers("f, k1, k2")?;
            let rotation = [words.numbers("R")?, words.numbers("R")?, words.numbers("R")?];
            let translation = words.numbers("t")?;
            bundle.cameras.push(Camera { focal, k: [k1, k2], rotation, translation });
        }
        for i in 0..points {
            words.enter("point", i, points);
            let world = words.numbers("coordinates")?;
            let color = [words.parsed("colour")?, words.parsed("colour")?, words.parsed("colour")?];
            let count: usize = words.parsed("number of views")?;
            let mut views = Vec::with_capacity(count.min(MOST_AHEAD));
            for _ in 0..count {
                let camera: usize = words.parsed("camera of a view")?;
                known("view", "a camera", camera, cameras, words.line)?;
                let key = words.parsed("key of a view")?;
                views.push(View { camera, key, image: words.numbers("image point")? });
            }
            bundle.points.push(Point { world, color, views });
        }
        Ok(bundle)
    }

    /// The file's text.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = format!("{HEADER}\n{} {}\n", self.cameras.len(), self.points.len());
        let row = |text: &mut String, values: &[f64]| {
            let list: Vec<_> = values.iter().map(f64::to_string).collect();
            let _ = writeln!(text, "{}", list.join(" "));
        };
        for Camera { focal, k: [k1, k2], rotation, translation } in &self.cameras {
            row(&mut text, &[*focal, *k1, *k2]);
            rotation.iter().for_each(|r| row(&mut text, r));
            row(&mut text, translation);
        }
        for Point { world, color: [r, g, b], views } in &self.points {
            row(&mut text, world);
            let _ = write!(text, "{r} {g} {b}\n{}", views.len());
            for View { camera, key, image: [x, y] } in views {
                let _ = write!(text, " {camera} {key} {x} {y}");
            }
            text.push('\n');
        }
        text
    }

    /// The registered photographs' cameras, for pictures of this size; named by their numbers from 0, as `camera_3`.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] for a camera out of its domain, as with an R that is no rotation.
    pub fn photographs(&self, size: [u32; 2]) -> Result<Vec<(String, CameraFile)>, Error> {
        let mut photographs = Vec::new();
        for (i, camera) in self.cameras.iter().enumerate().filter(|(_, c)| c.focal != 0.0) {
            let name = format!("camera_{i}");
            let file = camera.file(size);
            file.check().map_err(|e| Error::from(e.under(&name)))?;
            photographs.push((name, file));
        }
        Ok(photographs)
    }

    /// A reconstruction without points, of photographs with their cameras, in their order.
    ///
    /// # Errors
    /// [`FieldProblem::Unsupported`] for a camera that is not of Bundler's one model: the principal point in the middle,
    /// one principal distance, k₁ and k₂.
    pub fn from_photographs(photographs: &[(String, CameraFile)]) -> Result<Self, Error> {
        let mut cameras = Vec::with_capacity(photographs.len());
        for (name, file) in photographs {
            let under = |e: FieldError| Error::from(e.under(name));
            file.check().map_err(under)?;
            cameras.push(Camera::of(file)?.ok_or_else(|| {
                let found = file.interior.model().into();
                let expected = "Bundler has f, k1 and k2, and the principal point in the middle";
                under(FieldError::new("interior", FieldProblem::Unsupported { found, expected }))
            })?);
        }
        Ok(Self { cameras, points: vec![] })
    }
}

impl Camera {
    fn file(&self, size: [u32; 2]) -> CameraFile {
        let turn = camera_from_photo();
        let given = Matrix3::from_fn(|i, j| self.rotation[i][j]);
        let rotation = turn.matrix() * given;
        let translation = turn * Vector3::from(self.translation);
        let center = -(rotation.transpose() * translation);
        CameraFile {
            width: size[0],
            height: size[1],
            interior: Interior::Brown {
                principal_distance: [self.focal; 2],
                principal_point: size.map(|s| 0.5 * f64::from(s)),
                skew: 0.0,
                k: [self.k[0], self.k[1], 0.0],
                p: [0.0; 2],
            },
            exterior: Exterior {
                projection_center: center.into(),
                rotation: Rotation::RotationMatrix(
                    [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)])),
                ),
            },
        }
    }

    /// Bundler's camera of a file, where it is one.
    fn of(file: &CameraFile) -> Result<Option<Self>, Error> {
        let size = [file.width, file.height];
        let (f, c, k) = match file.interior.plain(size) {
            Interior::Pinhole { principal_distance, principal_point, skew: 0.0 } => {
                (principal_distance, principal_point, [0.0; 2])
            }
            Interior::Brown {
                principal_distance,
                principal_point,
                skew: 0.0,
                k: [k1, k2, 0.0],
                p: [0.0, 0.0],
            } => (principal_distance, principal_point, [k1, k2]),
            _ => return Ok(None),
        };
        if f[0] != f[1] || c != size.map(|s| 0.5 * f64::from(s)) {
            return Ok(None);
        }
        let exterior = file.exterior.orientation()?;
        let turn = camera_from_photo().inverse();
        let rotation = (turn * exterior.camera_from_world()).into_inner();
        let translation: [f64; 3] = (turn * exterior.pose().translation()).into();
        finite("exterior", &translation)?;
        let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)]));
        Ok(Some(Self { focal: f[0], k, rotation, translation }))
    }
}
