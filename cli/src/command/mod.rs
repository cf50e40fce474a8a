//! The commands: their arguments, their messages, their outputs.

pub(crate) mod adjust;
pub(crate) mod convert;
mod files;
pub(crate) mod intersect;
pub(crate) mod overlay;
pub(crate) mod project;
pub(crate) mod rectify;
pub(crate) mod render;
pub(crate) mod reproject;
pub(crate) mod resect;
mod residuals;
pub(crate) mod warp;

use std::fmt::{self, Display};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::ValueEnum;
use collinear::nalgebra::Point2;
use collinear::resample::{Border, Filter};
use collinear_cli::check_size;
use collinear_io::Document;
use collinear_io::picture::PictureFormat;
use collinear_io::scene::SceneFile;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

pub(crate) use files::Files;

/// A message for people.
pub(crate) fn say(message: &str) {
    // Nobody is left to tell that stderr is closed.
    drop(writeln!(std::io::stderr().lock(), "collinear: {message}"));
}

/// A result to standard output.
pub(crate) fn print(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        // A reader that went away has what it wanted.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(in_file(Path::new("standard output"), anyhow!("cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

/// A bar on a terminal, nothing elsewhere.
fn progress_bar(what: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.with_message(what)
}

/// Does some work with a bar that shows how much of it is done.
pub(crate) fn with_bar<T>(what: &'static str, work: impl FnOnce(&dyn Fn(usize, usize)) -> T) -> T {
    let bar = progress_bar(what);
    let result = work(&|done, total| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    result
}

/// The path of a picture to write, refused here where its extension names no format.
pub(crate) fn picture_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    PictureFormat::from_path(&path).map_err(|e| e.to_string())?;
    Ok(path)
}

/// An error of the command line that its parser cannot see.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// An error with the file that it is about.
pub(crate) fn in_file(path: &Path, error: impl Display) -> anyhow::Error {
    anyhow!("{}: {error}", path.display())
}

/// A scene with its cameras, after the files that it names have been told apart from the outputs.
pub(crate) fn open_scene(path: &Path, files: &mut Files) -> Result<SceneFile> {
    let scene = SceneFile::read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for (field, file) in scene.files(folder) {
        files.input(format!("{field} of {}", path.display()), &file)?;
    }
    Ok(scene.resolved(folder).map_err(|e| e.in_file(path))?)
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() && v > 0.0 => Ok(v),
        _ => Err("expected a finite number above 0".into()),
    }
}

/// A number from `least` to `most`.
pub(crate) fn between(text: &str, least: f64, most: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(v) if (least..=most).contains(&v) => Ok(v),
        _ => Err(format!("expected a number from {least} to {most}")),
    }
}

/// The size of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Size {
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (w, h) = text
            .split_once(['x', 'X', '×'])
            .ok_or("expected width and height in pixels, as 800x600")?;
        let side = |t: &str| {
            t.trim().parse::<u32>().map_err(|_| format!("`{t}` is not a whole number of pixels"))
        };
        let (width, height) = (side(w)?, side(h)?);
        check_size(width, height).map_err(|e| e.to_string())?;
        Ok(Self { width, height })
    }
}

/// Four points.
pub(crate) type Quad = [Point2<f64>; 4];

/// Four points x,y parted by spaces.
pub(crate) fn quad(text: &str) -> Result<Quad, String> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    let point = |t: &str| {
        let (x, y) = t.split_once(',')?;
        Some(Point2::new(number(x)?, number(y)?))
    };
    let points: Option<Vec<_>> = text.split_whitespace().map(point).collect();
    points.and_then(|p| Quad::try_from(p).ok()).ok_or_else(|| {
        "expected four points x,y parted by spaces, as \"120,80 900,40 910,700 100,650\"".into()
    })
}

/// A colour between pixels.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum FilterChoice {
    Nearest,
    #[default]
    Bilinear,
}

impl From<FilterChoice> for Filter {
    fn from(choice: FilterChoice) -> Self {
        match choice {
            FilterChoice::Nearest => Self::Nearest,
            FilterChoice::Bilinear => Self::Bilinear,
        }
    }
}

/// What lies beyond a photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BorderChoice(Border);

impl BorderChoice {
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let color = |t: &str| {
            let parts: Vec<_> = t.split(',').map(|p| p.trim().parse::<u8>()).collect();
            match parts.as_slice() {
                [Ok(r), Ok(g), Ok(b)] => {
                    Ok(Border::Constant([f32::from(*r), f32::from(*g), f32::from(*b), 255.0]))
                }
                _ => Err(format!("`{t}` is no colour: three numbers from 0 to 255, as 255,128,0")),
            }
        };
        Ok(Self(match text.split_once([':', '=', ' ']) {
            Some(("constant", rest)) => color(rest)?,
            None if text == "transparent" => Border::Transparent,
            None if text == "clamp" => Border::Clamp,
            None if text == "repeat" => Border::Repeat,
            None if text == "mirror" => Border::Mirror,
            _ => return Err("expected transparent, constant:R,G,B, clamp, repeat or mirror".into()),
        }))
    }

    /// The border of a picture to write: without a choice black in a JPEG and transparent elsewhere. A transparent one is refused where
    /// the output cannot be.
    pub(crate) fn of(choice: Option<Self>, output: &Path) -> Result<Border> {
        let jpeg = PictureFormat::from_path(output)? == PictureFormat::Jpeg;
        match choice {
            Some(Self(Border::Transparent)) if jpeg => {
                let reason = "a JPEG has no opacity: write a PNG or TIFF, or give another --border";
                Err(UsageError(reason.into()).into())
            }
            Some(Self(border)) => Ok(border),
            None if jpeg => Ok(Border::Constant([0.0; 4])),
            None => Ok(Border::Transparent),
        }
    }
}
