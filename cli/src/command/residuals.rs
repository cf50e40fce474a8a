//! The picture of the residuals that several commands write.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use collinear_cli::residuals::{Sheet, Vector, fitting_exaggeration, to_svg};
use collinear_io::write_atomically;

use super::{Files, UsageError, positive};

/// Whether and how the residuals are drawn.
#[derive(Debug, Args)]
pub(crate) struct Residuals {
    /// A picture of the residuals to write (SVG)
    #[arg(long, value_name = "RESIDUALS.svg")]
    svg: Option<PathBuf>,

    /// How many times as long the residuals are drawn; without it a round number that suits them
    #[arg(long, value_name = "TIMES", requires = "svg", value_parser = positive)]
    exaggeration: Option<f64>,
}

impl Residuals {
    /// Names the picture among the outputs.
    pub(crate) fn name(&self, files: &mut Files) -> Result<(), UsageError> {
        match &self.svg {
            Some(path) => files.output("the picture of the residuals (--svg)", path),
            None => Ok(()),
        }
    }

    /// Writes the picture, where it is wanted; `size` is the photograph's, where it is known.
    pub(crate) fn draw(
        &self,
        size: Option<[u32; 2]>,
        vectors: impl FnOnce() -> Vec<Vector>,
    ) -> Result<()> {
        let Some(path) = &self.svg else { return Ok(()) };
        let vectors = vectors();
        let sheet = size.map_or_else(|| Sheet::around(&vectors), Sheet::of_picture);
        let times = self.exaggeration.unwrap_or_else(|| fitting_exaggeration(&vectors, &sheet));
        let svg = to_svg(&vectors, &sheet, times);
        Ok(write_atomically(path, |w| w.write_all(svg.as_bytes()))?)
    }
}
