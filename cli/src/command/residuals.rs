//! The picture of the residuals that several commands write.

use std::path::PathBuf;

use clap::Args;
use collinear_cli::residuals::{Sheet, Vector, fitting_exaggeration, to_svg};

use super::{Files, UsageError, between};

/// Whether and how the residuals are drawn.
#[derive(Debug, Args)]
pub(crate) struct Residuals {
    /// A picture of the residuals to write (SVG)
    #[arg(long, value_name = "RESIDUALS.svg")]
    svg: Option<PathBuf>,

    /// How many times as long the residuals are drawn; without it a round number that suits them
    #[arg(long, value_name = "TIMES", requires = "svg", value_parser = times, allow_negative_numbers = true)]
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

    /// The picture to write, where it is wanted; `size` is the photograph's, where it is known.
    pub(crate) fn draw(
        &self,
        size: Option<[u32; 2]>,
        vectors: impl FnOnce() -> Vec<Vector>,
    ) -> Option<(PathBuf, Vec<u8>)> {
        let path = self.svg.as_ref()?;
        let vectors = vectors();
        let sheet = size.map_or_else(|| Sheet::around(&vectors), Sheet::of_picture);
        let times = self.exaggeration.unwrap_or_else(|| fitting_exaggeration(&vectors, &sheet));
        Some((path.clone(), to_svg(&vectors, &sheet, times).into_bytes()))
    }
}

/// Longer or shorter vectors are not seen.
fn times(text: &str) -> Result<f64, String> {
    between(text, 0.001, 1e6)
}
