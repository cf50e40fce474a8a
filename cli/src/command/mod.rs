//! The commands: their arguments, their messages, their outputs.

pub(crate) mod render;

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use collinear_io::picture::PictureFormat;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A message for people.
pub(crate) fn say(message: &str) {
    // Nobody is left to tell that stderr is closed.
    drop(writeln!(std::io::stderr().lock(), "collinear: {message}"));
}

/// A bar on a terminal, nothing elsewhere.
pub(crate) fn progress_bar(what: &'static str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.with_message(what)
}

/// The path of a picture to write, refused here where its extension names no format.
pub(crate) fn picture_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    PictureFormat::from_path(&path).map_err(|e| e.to_string())?;
    Ok(path)
}
