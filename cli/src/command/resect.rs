//! `collinear resect`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use collinear_cli::resect::{Estimated, Options, run};
use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::control::read_control;
use collinear_io::write_together;

use super::residuals::Residuals;
use super::{Files, UsageError, between, in_file, positive, print};

/// Find where a photograph was taken, from points whose places are known
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The control points (CSV): columns X, Y, Z, x, y and perhaps id, sigma, sigma_X, sigma_Y, sigma_Z
    #[arg(value_name = "CONTROL.csv")]
    control: PathBuf,

    /// The camera (JSON); its exterior orientation may be missing and is not looked at
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: PathBuf,

    /// The camera file to write, with the exterior orientation found
    #[arg(short, long, value_name = "OUT.json")]
    output: Option<PathBuf>,

    /// Estimated beside the pose: distance, point, k1, k2, k3, p
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = estimated)]
    estimate: Vec<Estimated>,

    /// Standard deviation of image coordinates for which the list states none, in pixels
    #[arg(long, value_name = "PIXELS", default_value = "1", value_parser = positive, allow_negative_numbers = true)]
    sigma: f64,

    /// Believe the stated precisions, instead of sigma 0 from the residuals
    #[arg(long)]
    trust: bool,

    /// Search for wrong points first; a point with a residual of more standard deviations is left out
    #[arg(long, value_name = "SIGMAS", num_args = 0..=1, default_missing_value = "3", value_parser = sigmas, allow_negative_numbers = true)]
    robust: Option<f64>,

    /// Start of the random sequence of --robust
    #[arg(
        long,
        value_name = "NUMBER",
        default_value = "0",
        requires = "robust",
        allow_negative_numbers = true
    )]
    seed: u64,

    #[command(flatten)]
    residuals: Residuals,

    /// The protocol as JSON
    #[arg(long)]
    json: bool,
}

/// Beyond these a point is either always or never wrong.
fn sigmas(text: &str) -> Result<f64, String> {
    between(text, 0.1, 1000.0)
}

/// Refuses a list that chooses something twice, and says what.
pub(super) fn once(list: &[Estimated]) -> Result<(), UsageError> {
    match Estimated::twice(list) {
        Some(twice) => Err(UsageError(format!("--estimate: `{}` is chosen twice", twice.word()))),
        None => Ok(()),
    }
}

pub(super) fn estimated(text: &str) -> Result<Estimated, String> {
    Ok(match text.trim() {
        "distance" => Estimated::PrincipalDistance,
        "point" => Estimated::PrincipalPoint,
        "k1" => Estimated::Radial(0),
        "k2" => Estimated::Radial(1),
        "k3" => Estimated::Radial(2),
        "p" => Estimated::Decentering,
        other => return Err(format!("`{other}` is none of distance, point, k1, k2, k3, p")),
    })
}

const LONG: &str = "\
Find where a photograph was taken, from points whose places are known: space resection by least \
squares, without initial values. Four points are enough, more control each other.

x, y are pixels from the top-left corner of the top-left pixel, as measured, through the lens. A \
standard deviation of an image point is in the column sigma (or sigma_x, sigma_y), in pixels; those of \
a place, if it is not free of error, in sigma_X, sigma_Y, sigma_Z.

The protocol on standard output says how good the result is. sigma 0 is 1 where the stated precisions \
were right. Each unknown has its standard deviation. For each coordinate of each point there are the \
residual v; the redundancy number r, which part of an error would show in v, from 0 (nothing would) to \
1; the test w, v in its own standard deviations, suspect beyond 3.29; and the smallest blunder that \
this test finds with a probability of 80 %. Angles are omega, phi, kappa in degrees, from the world to \
x right, y up, z backwards. docs/adjustment.md explains each figure.";

const AFTER: &str = "\
Examples:
  collinear resect control.csv --camera camera.json -o south.json
  collinear resect control.csv --camera camera.json --estimate distance,k1 --svg residuals.svg
  collinear resect matches.csv --camera camera.json --robust --json

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        once(&self.estimate)?;
        let mut files = Files::default();
        if let Some(path) = &self.output {
            files.output("the camera to write (-o)", path)?;
        }
        self.residuals.name(&mut files)?;
        files.input("the control points", &self.control)?;
        files.input("the camera", &self.camera)?;
        let rows = read_control(&self.control)?;
        let camera = CameraFile::read_without_exterior(&self.camera)?;
        let options = Options {
            sigma: self.sigma,
            estimate: self.estimate.clone(),
            robust: self.robust,
            seed: self.seed,
            trust: self.trust,
        };
        let outcome = run(&camera, &rows, &options).map_err(|e| in_file(&self.control, e))?;
        let text = if self.json { outcome.to_json()? + "\n" } else { outcome.to_text() };
        let mut outputs = Vec::new();
        if let Some(path) = &self.output {
            let camera = outcome.camera.to_json().map_err(|e| e.in_file(path))?;
            outputs.push((path.clone(), camera.into_bytes()));
        }
        let size = [outcome.camera.width, outcome.camera.height];
        outputs.extend(self.residuals.draw(Some(size), || outcome.vectors()));
        write_together(&outputs)?;
        print(&text)
    }
}
