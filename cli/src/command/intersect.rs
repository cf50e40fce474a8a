//! `collinear intersect`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use collinear_cli::intersect::{Photograph, run, to_csv, to_json, to_text};
use collinear_io::convert::Camera;
use collinear_io::observations::read_observations;
use collinear_io::sensor::SensorFile;
use collinear_io::{photographs, write_atomically};

use super::{Files, in_file, positive, print, with_bar};

/// Find points from the photographs that show them
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The measured images (CSV): columns photo, id, x, y and perhaps sigma
    #[arg(value_name = "IMAGES.csv")]
    images: PathBuf,

    /// The photographs with their cameras: files of single cameras, scanners or RPC, or files and folders of many
    #[arg(short, long, value_name = "CAMERAS", required = true, num_args = 1..)]
    cameras: Vec<PathBuf>,

    /// Standard deviation of image coordinates for which the list states none, in pixels
    #[arg(long, value_name = "PIXELS", default_value = "1", value_parser = positive, allow_negative_numbers = true)]
    sigma: f64,

    /// Believe the stated precisions, instead of sigma 0 from the residuals
    #[arg(long)]
    trust: bool,

    /// The points to write (CSV)
    #[arg(short, long, value_name = "POINTS.csv")]
    output: Option<PathBuf>,

    /// The protocol as JSON
    #[arg(long)]
    json: bool,
}

const LONG: &str = "\
Find points from the photographs that show them: space intersection by least squares, the \
orientations taken as free of error.

x, y are pixels from the top-left corner of the top-left pixel, as measured, through the lens. photo \
is a photograph's name: that which a file of many gives it, or the name of its own file without \
`.json` or `.camera.json`. Files of many are those that `convert` reads: COLMAP's folder, OpenSfM's \
reconstruction, Metashape's XML and others.

The protocol on standard output has for each point its coordinates and their standard deviations, \
sigma 0 (1 where the stated precisions were right), and the observation with the largest test w, \
suspect beyond 3.29. A point that cannot be found, as one whose lines of sight are parallel, has the \
reason.";

const AFTER: &str = "\
Examples:
  collinear intersect clicks.csv --cameras south.camera.json east.camera.json -o points.csv
  collinear intersect tracks.csv --cameras sparse/0 --sigma 0.5 --json

Exit codes: 0 done, points that were not found among them; 1 failed (an old POINTS is left as it \
was); 2 wrong usage, as an output that is an input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        if let Some(path) = &self.output {
            files.output("the points to write (-o)", path)?;
        }
        files.input("the measured images", &self.images)?;
        let mut list = Vec::new();
        for path in &self.cameras {
            files.input_folder("the cameras", path)?;
            open(path, &mut list)?;
        }
        let rows = read_observations(&self.images)?;
        let points = with_bar("intersecting", |progress| {
            run(&list, &rows, self.sigma, self.trust, progress)
        })
        .map_err(|e| in_file(&self.images, e))?;
        let protocol = if self.json { to_json(&points)? + "\n" } else { to_text(&points) };
        if let Some(path) = &self.output {
            let text = to_csv(&points);
            write_atomically(path, |w| w.write_all(text.as_bytes()))?;
        }
        print(&protocol)
    }
}

/// The photographs of a file.
fn open(path: &Path, list: &mut Vec<Photograph>) -> Result<()> {
    if let Some(file) = SensorFile::read_if_ours(path)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let name = name.split('.').next().unwrap_or_default().to_owned();
        let sensor = file.sensor().map_err(|e| e.in_file(path))?;
        list.push(Photograph { name, sensor });
        return Ok(());
    }
    for (name, file) in photographs::read(path, None)? {
        let sensor = file.camera().map(Camera::into_sensor).map_err(|e| e.in_file(path))?;
        list.push(Photograph { name, sensor });
    }
    Ok(())
}
