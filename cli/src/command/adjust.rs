//! `collinear adjust`.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow, bail};
use clap::Args;
use collinear::numeric::robust_loss::RobustLoss;
use collinear_cli::adjust::{Options, run};
use collinear_cli::block::{Block, BlockFile};
use collinear_cli::given::Given;
use collinear_cli::resect::Estimated;
use collinear_io::observations::read_observations;
use collinear_io::observed::{read_attitudes, read_distances, read_places, read_positions};
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

    /// Control points (CSV): id, X, Y, Z and perhaps sigma_X, sigma_Y, sigma_Z; without these exact
    #[arg(long, value_name = "CONTROL.csv", requires = "clicks")]
    control: Option<PathBuf>,

    /// Check points (CSV): id, X, Y, Z, compared with the adjusted ones afterwards
    #[arg(long, value_name = "CHECK.csv", requires = "clicks")]
    check: Option<PathBuf>,

    /// Where photographs show the points of --control, --check and --distances (CSV): photo, id, x, y and perhaps sigma
    #[arg(long, value_name = "CLICKS.csv")]
    clicks: Option<PathBuf>,

    /// Positions of the photographs' antennas, as of GNSS (CSV): photo, X, Y, Z, sigma_X, sigma_Y, sigma_Z
    #[arg(long, value_name = "GNSS.csv")]
    positions: Option<PathBuf>,

    /// From the projection centre to the antenna in camera axes (x right, y down, z forward), world units, where the positions have no
    /// lever_x, lever_y, lever_z
    #[arg(long, value_name = "X,Y,Z", requires = "positions", value_parser = three, allow_hyphen_values = true)]
    lever_arm: Option<[f64; 3]>,

    /// Attitudes of the photographs, as of an inertial unit (CSV): photo, omega, phi, kappa, sigma_omega, sigma_phi, sigma_kappa,
    /// degrees
    #[arg(long, value_name = "IMU.csv")]
    attitudes: Option<PathBuf>,

    /// Distances of points (CSV): from, to, length, sigma
    #[arg(long, value_name = "DISTANCES.csv", requires = "clicks")]
    distances: Option<PathBuf>,

    /// The block is in the frame of the control points and positions already: it is not brought there before the adjustment
    #[arg(long)]
    placed: bool,

    /// Correct image points for refraction: world units are metres, Z is the height above the sea
    #[arg(long, requires = "control")]
    refraction: bool,

    /// Correct image points for the Earth's curvature, of a block in a map system: metres, Z the height above the sea
    #[arg(long, requires = "control")]
    earth_curvature: bool,

    /// Estimate the precision of each kind of observations, instead of one sigma 0
    #[arg(long, conflicts_with = "no_quality")]
    variances: bool,

    /// Iterations allowed
    #[arg(long, value_name = "NUMBER", default_value = "200", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
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

Control points (--control) with their images (--clicks), positions (--positions) and attitudes \
(--attitudes) of the photographs place the block in the world. Before the adjustment the block is laid onto them by a similarity, \
for which three control points clicked in two photographs each, or positions, are needed; with --placed it \
is there already. Photographs go by their names, with or without folder and extension. -o writes the block in that frame. Check points \
(--check) are clicked too but take no part. The files are described in docs/formats.md. --refraction and \
--earth-curvature correct image points before the adjustment by the approximate orientations: Z is up, the ground lies at the \
mean height of the control points, the Earth is a sphere of 6371 km, the map has its lengths at sea level.

The protocol on standard output has the cost (half the sum of squared residuals, or of losses), sigma 0 (1 where the \
stated precision was right), each camera and photograph with its standard deviations, in \
the frame of what was given or else those of a network without outside points, what was given with its residuals v, redundancy \
numbers r and tests w, and the observations whose test is beyond 3.29. Residuals and \
image coordinates are pixels, places are world units. docs/adjustment.md explains each figure.";

const AFTER: &str = "\
Examples:
  collinear adjust sparse/0 --estimate distance,k1 -o adjusted
  collinear adjust problem-49-7776-pre.txt.gz --formula --no-quality --json
  collinear adjust sparse/0 --control control.csv --clicks clicks.csv --check check.csv -o adjusted
  collinear adjust sparse/0 --positions gnss.csv --lever-arm 0.1,0,-0.3 --attitudes imu.csv --variances
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
        let given = self.given(&mut files)?;
        let file = BlockFile::read(&self.block, self.tracks.as_deref())?;
        let estimate = chosen.unwrap_or_else(|| file.usually_estimated());
        let block = file
            .block(&estimate, self.sigma, self.formula, &given)
            .map_err(|e| in_file(&self.block, e))?;
        for idle in &block.idle {
            let (name, count) = (&idle.name, idle.image_points);
            let text = "image points that can take part, of 3 needed";
            say(&format!("photograph {name} is left out: {count} {text}"));
        }
        for (name, why) in &block.known.left_out {
            say(&format!("point {name} is left out: {why}"));
        }
        let photo = self.photo.as_ref().map(|name| place_of(name, &block)).transpose()?;
        let options = Options {
            estimate,
            loss: self.loss.unwrap_or_default(),
            formula: self.formula,
            trust: self.trust,
            max_iterations: self.iterations,
            quality: !self.no_quality,
            variances: self.variances,
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

    /// What was observed besides the block's image points.
    fn given(&self, files: &mut Files) -> Result<Given> {
        for (role, path) in [
            ("the control points (--control)", &self.control),
            ("the check points (--check)", &self.check),
            ("the clicks (--clicks)", &self.clicks),
            ("the positions (--positions)", &self.positions),
            ("the attitudes (--attitudes)", &self.attitudes),
            ("the distances (--distances)", &self.distances),
        ] {
            if let Some(path) = path {
                files.input(role, path)?;
            }
        }
        if self.clicks.is_some()
            && [&self.control, &self.check, &self.distances].iter().all(|p| p.is_none())
        {
            let text = "--clicks: of which points? Give --control, --check or --distances";
            return Err(UsageError(text.to_owned()).into());
        }
        Ok(Given {
            control: table(self.control.as_deref(), read_places)?,
            check: table(self.check.as_deref(), read_places)?,
            clicks: table(self.clicks.as_deref(), read_observations)?,
            positions: table(self.positions.as_deref(), read_positions)?,
            lever_arm: self.lever_arm.unwrap_or_default(),
            attitudes: table(self.attitudes.as_deref(), read_attitudes)?,
            distances: table(self.distances.as_deref(), read_distances)?,
            in_place: self.placed,
            refraction: self.refraction,
            earth_curvature: self.earth_curvature,
        })
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

/// The rows of a table, none where it was not named.
fn table<R>(
    path: Option<&Path>,
    read: impl Fn(&Path) -> Result<Vec<R>, collinear_io::Error>,
) -> Result<Vec<R>> {
    let Some(path) = path else { return Ok(vec![]) };
    let rows = read(path)?;
    if rows.is_empty() {
        bail!("{}: has a header and no line after it", path.display());
    }
    Ok(rows)
}

/// Three finite numbers with commas between.
fn three(text: &str) -> Result<[f64; 3], String> {
    let list: Option<Vec<f64>> =
        text.split(',').map(|w| w.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect();
    let list: Option<[f64; 3]> = list.and_then(|l| l.try_into().ok());
    list.ok_or_else(|| "expected three finite numbers, as 0.1,-0.2,0".into())
}

fn place_of(name: &str, block: &Block) -> Result<usize> {
    block
        .photographs
        .iter()
        .position(|p| p == name)
        .ok_or_else(|| anyhow!("--photo: the block has no photograph `{name}`"))
}
