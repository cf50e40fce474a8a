//! `collinear render`.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use collinear_cli::render::render_scene;
use collinear_io::picture::write_picture;
use collinear_io::scene::SensorSource;
use collinear_io::sensor::SensorFile;

use super::{Files, open_scene, picture_path, say, with_bar};

/// Draw the view of a scene: polygons textured by photographs, textures or colours
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The scene file (JSON); paths in it start from its folder
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,

    /// The camera or scanner (JSON) of the picture, instead of the scene's `view`
    #[arg(long, value_name = "VIEW.json")]
    view: Option<PathBuf>,

    /// The picture to write: .png, .jpg, .jpeg, .tif or .tiff
    #[arg(short, long, value_name = "OUT", value_parser = picture_path)]
    output: PathBuf,

    /// Fail where a polygon cannot be drawn, instead of leaving it out with a warning
    #[arg(long)]
    strict: bool,
}

const LONG: &str = "\
Draw the view of a scene: polygons textured by photographs, textures or colours.

Each polygon's pixels are looked up in its photograph through the map that the polygon's plane, the \
photograph's camera (with its lens) and the view share; nothing is resampled twice. What lies \
outside the photograph stays undrawn. The nearest polygon wins. Photographs are not tested for what \
stands in their way.

Vertices are world coordinates in any one unit of length; the picture has the size of the scene's \
view, in pixels. A view of any model is drawn, a fisheye, a panorama or a scanner by the line of sight \
of each pixel. docs/formats.md describes the scene file.";

const AFTER: &str = "\
Examples:
  collinear render town.json -o view.png
  collinear render town.json --view dome.camera.json -o dome.png

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.output("the output (-o)", &self.output)?;
        files.input("the scene", &self.scene)?;
        if let Some(path) = &self.view {
            files.input("the view", path)?;
        }
        let mut scene = open_scene(&self.scene, &mut files)?;
        if let Some(path) = &self.view {
            scene.view = SensorSource::Inline(SensorFile::read(path)?);
        }
        let result =
            with_bar("rendering", |progress| render_scene(&scene, Path::new(""), progress));
        let name = self.scene.display();
        let rendered = result.map_err(|e| anyhow::anyhow!("{name}: {e}"))?;
        let report = &rendered.report;
        if self.strict
            && let Some(first) = report.refused.first()
        {
            bail!("{name}: {first}");
        }
        for remark in &report.refused {
            say(&format!("warning: {name}: {remark}; it is left out"));
        }
        for remark in &report.notes {
            say(&format!("warning: {name}: {remark}"));
        }
        if let Some(first) = report.nearer.first() {
            let others = match report.nearer.len() {
                1 => String::new(),
                2 => ", like 1 other".into(),
                n => format!(", like {} others", n - 1),
            };
            say(&format!("warning: {name}: {first}, and is not drawn{others}"));
        }
        write_picture(&self.output, &rendered.picture)?;
        say(&format!(
            "{}: {} polygons drawn, {} culled, {} out of view, {} left out",
            self.output.display(),
            report.drawn,
            report.culled,
            report.outside,
            report.refused.len()
        ));
        Ok(())
    }
}
