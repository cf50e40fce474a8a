//! `collinear adjust`.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::Args;
use collinear::numeric::robust_loss::RobustLoss;
use collinear_cli::adjust::{Options, run};
use collinear_cli::block::{Block, BlockFile};
use collinear_cli::resect::Estimated;
use collinear_io::write_together;

use super::resect::{estimated, once};
use super::residuals::Residuals;
use super::{Files, UsageError, in_file, positive, print, say, with_bar};

/// Adjust a block of photographs: cameras, poses and points from all image points at once
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The block: COLMAP's folder, OpenSfM's reconstruction, Bundler's bundle.out, or a problem of BAL
    #[arg(value_name = "BLOCK")]
    block: PathBuf,

    /// With OpenSfM's reconstruction: its tracks (CSV)
    #[arg(long, value_name = "TRACKS.csv")]
    tracks: Option<PathBuf>,

    /// Estimated beside poses and points: distance, point, k1, k2, k3, p; `none` for nothing
    #[arg(long, value_name = "WHAT")]
    estimate: Option<String>,

    /// Standard deviation of image coordinates, in pixels
    #[arg(long, value_name = "PIXELS", default_value = "1", value_parser = positive, allow_negative_numbers = true)]
    sigma: f64,

    /// Give far image points less say: huber, cauchy, tukey or truncated, with its scale in standard deviations
    #[arg(long, value_name = "LOSS:SCALE", value_parser = loss)]
    loss: Option<RobustLoss>,

    /// Keep a residual for points behind their cameras, by the bare formula, as BAL's published costs do
    #[arg(long)]
    formula: bool,

    /// Believe the stated precision, instead of sigma 0 from the residuals
    #[arg(long)]
    trust: bool,

    /// Leave out standard deviations and tests, whose time grows with the cube of the number of photographs
    #[arg(long)]
    no_quality: bool,

    /// Iterations allowed
    #[arg(long, value_name = "NUMBER", default_value = "200", allow_negative_numbers = true)]
    iterations: u32,

    /// The adjusted block to write, in the format it came in (COLMAP: a folder)
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,

    #[command(flatten)]
    residuals: Residuals,

    /// With --svg: the photograph whose residuals are drawn; without it those of the first camera's photographs
    #[arg(long, value_name = "NAME", requires = "svg")]
    photo: Option<String>,

    /// The protocol as JSON
    #[arg(long)]
    json: bool,
}

const LONG: &str = "\
Adjust a block of photographs: cameras, poses and points from all image points at once, by least \
squares.

What is estimated beside poses and points is said by --estimate; without it the principal distance, k1 \
and k2 of BAL's and Bundler's cameras, nothing of COLMAP's and OpenSfM's. Photographs that share a \
camera there share it here. Image points behind their cameras and points with a single ray take no \
part and are counted. A photograph with fewer than three image points that can take part is left out \
and stays as it is.

The protocol on standard output has the cost (half the sum of squared residuals, or of losses), sigma 0 (1 where the \
stated precision was right), each camera and photograph with its standard deviations, those of a \
network without outside points, and the image points whose test w is beyond 3.29. Residuals and \
image coordinates are pixels, places are world units. docs/adjustment.md explains each figure.";

const AFTER: &str = "\
Examples:
  collinear adjust sparse/0 --estimate distance,k1 -o adjusted
  collinear adjust problem-49-7776-pre.txt.gz --formula --no-quality --json
  collinear adjust reconstruction.json --tracks tracks.csv --loss huber:2 --svg residuals.svg

Exit codes: 0 done, an adjustment that ran out of iterations among them, which the protocol says; 1 \
failed (an old OUT is left as it was); 2 wrong usage, as an output that is an input too.";

fn loss(text: &str) -> Result<RobustLoss, String> {
    let (name, scale) = text.split_once(':').ok_or("expected a name and a scale, as huber:2")?;
    let scale = positive(scale)?;
    Ok(match name {
        "huber" => RobustLoss::Huber { scale },
        "cauchy" => RobustLoss::Cauchy { scale },
        "tukey" => RobustLoss::Tukey { scale },
        "truncated" => RobustLoss::Truncated { scale },
        other => return Err(format!("`{other}` is none of huber, cauchy, tukey, truncated")),
    })
}

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let chosen = self.chosen()?;
        let mut files = Files::default();
        if let Some(path) = &self.output {
            files.output("the adjusted block (-o)", path)?;
        }
        self.residuals.name(&mut files)?;
        files.input_folder("the block", &self.block)?;
        if let Some(path) = &self.tracks {
            files.input("the tracks", path)?;
        }
        let file = BlockFile::read(&self.block, self.tracks.as_deref())?;
        let estimate = chosen.unwrap_or_else(|| file.usually_estimated());
        let block =
            file.block(&estimate, self.sigma, self.formula).map_err(|e| in_file(&self.block, e))?;
        for idle in &block.idle {
            let (name, count) = (&idle.name, idle.image_points);
            let text = "image points that can take part, of 3 needed";
            say(&format!("photograph {name} is left out: {count} {text}"));
        }
        let photo = self.photo.as_ref().map(|name| place_of(name, &block)).transpose()?;
        let options = Options {
            estimate,
            loss: self.loss.unwrap_or_default(),
            formula: self.formula,
            trust: self.trust,
            max_iterations: self.iterations,
            quality: !self.no_quality,
        };
        let outcome = with_bar("adjusting", |progress| run(&block, &options, progress))
            .map_err(|e| in_file(&self.block, e))?;
        let camera = photo.map_or(0, |p| block.images[p].1.number());
        let size = block.sizes.get(camera).copied().flatten();
        let text =
            if self.json { outcome.to_json(&block)? + "\n" } else { outcome.to_text(&block) };
        let mut outputs = Vec::new();
        if let Some(path) = &self.output {
            outputs = file.adjusted(&block, &outcome.adjusted, path)?;
        }
        outputs.extend(self.residuals.draw(size, || outcome.vectors(&block, photo, camera)));
        write_together(&outputs)?;
        print(&text)
    }

    fn chosen(&self) -> Result<Option<Vec<Estimated>>> {
        let Some(text) = &self.estimate else { return Ok(None) };
        if text.trim() == "none" {
            return Ok(Some(vec![]));
        }
        let list = text.split(',').map(estimated).collect::<Result<Vec<_>, _>>();
        let list = list.map_err(|e| UsageError(format!("--estimate: {e}")))?;
        once(&list)?;
        Ok(Some(list))
    }
}

fn place_of(name: &str, block: &Block) -> Result<usize> {
    block
        .photographs
        .iter()
        .position(|p| p == name)
        .ok_or_else(|| anyhow!("--photo: the block has no photograph `{name}`"))
}
