//! `collinear project`.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use clap::Args;
use collinear_cli::project::{ground, project, to_csv};
use collinear_io::Document;
use collinear_io::plane::PlaneFile;
use collinear_io::points::{read_image_points, read_points};
use collinear_io::sensor::SensorFile;
use collinear_io::write_atomically;

use super::{Files, in_file, say};

/// Compute the pixels of world points, or with --inverse the ground points of pixels
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The points (CSV): columns X, Y, Z and perhaps id; with --inverse x, y and perhaps id
    #[arg(value_name = "POINTS.csv")]
    points: PathBuf,

    /// The camera or scanner (JSON)
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: PathBuf,

    /// From pixels to the plane instead of from the world to pixels
    #[arg(long, requires = "plane")]
    inverse: bool,

    /// With --inverse: the plane (JSON) on which the points lie
    #[arg(short, long, value_name = "PLANE.json", requires = "inverse")]
    plane: Option<PathBuf>,

    /// The table to write; without it, standard output
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

const LONG: &str = "\
Compute the pixels of world points, or with --inverse the ground points of pixels.

X, Y, Z are world coordinates in the camera's unit; x, y are pixels from the top-left corner of the \
top-left pixel, through the lens. The table has the columns id, X, Y, Z, x, y, status. The status is \
`ok`, `outside the picture` (x and y are given all the same), or the reason why there are none: the \
point lies behind the camera or beyond the radius where the lens folds back, the line of sight does \
not meet the plane, no time of the scan sees the point. Numbers are written with as many digits as bring back the same 64 bits. A list \
with a header and no points gives a table without lines, an empty file is an error.";

const AFTER: &str = "\
Examples:
  collinear project --camera south.json control.csv -o images.csv
  collinear project --camera south.json --inverse --plane ground.json clicks.csv

Exit codes: 0 done, points without an image among them; 1 failed (an old OUT is left as it was); \
2 wrong usage, as an output that is an input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        if let Some(path) = &self.output {
            files.output("the output (-o)", path)?;
        }
        files.input("the points", &self.points)?;
        files.input("the camera", &self.camera)?;
        if let Some(path) = &self.plane {
            files.input("the plane", path)?;
        }
        let camera = SensorFile::read(&self.camera)?;
        let rows = if self.inverse {
            let path = self.plane.as_ref().context("--inverse needs --plane")?;
            let plane = PlaneFile::read(path)?;
            ground(&camera, &plane, &read_image_points(&self.points)?)
        } else {
            project(&camera, &read_points(&self.points)?)
        };
        let rows = rows.map_err(|e| in_file(&self.camera, e))?;
        if rows.is_empty() {
            let what = if self.inverse { "no point with x and y" } else { "no point" };
            say(&format!("warning: {}: {what} is in it", self.points.display()));
        }
        let text = to_csv(&rows);
        match &self.output {
            Some(path) => Ok(write_atomically(path, |w| w.write_all(text.as_bytes()))?),
            None => match io::stdout().lock().write_all(text.as_bytes()) {
                // A reader that went away has what it wanted.
                Err(e) if e.kind() != ErrorKind::BrokenPipe => {
                    Err(in_file(Path::new("standard output"), anyhow!("cannot be written: {e}")))
                }
                _ => Ok(()),
            },
        }
    }
}
