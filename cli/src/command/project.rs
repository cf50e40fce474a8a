//! `collinear project`.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use clap::{Args, ValueEnum};
use collinear_cli::project::{ProjectedRow, ground, project, to_csv};
use collinear_cli::rpc::{self, Heights};
use collinear_io::Document;
use collinear_io::gtx::read_gtx;
use collinear_io::plane::PlaneFile;
use collinear_io::points::{read_geographic, read_image_points, read_points};
use collinear_io::rpc::{RpcFile, read_if_rpc};
use collinear_io::sensor::SensorFile;
use collinear_io::write_atomically;

use super::{Files, in_file, print, say};

/// Compute the pixels of world points, or with --inverse the ground points of pixels
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The points (CSV): columns X, Y, Z (RPC: lon, lat, h) and perhaps id; with --inverse x, y and perhaps id
    #[arg(value_name = "POINTS.csv")]
    points: PathBuf,

    /// The camera or scanner (JSON), or a file with an RPC
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: PathBuf,

    /// From pixels to the plane, or to a height, instead of from the world to pixels
    #[arg(long, requires = "surface")]
    inverse: bool,

    /// With --inverse: the plane (JSON) on which the points lie
    #[arg(short, long, value_name = "PLANE.json", requires = "inverse", group = "surface")]
    plane: Option<PathBuf>,

    /// With --inverse and an RPC: the height at which the points lie, in metres
    #[arg(
        long,
        value_name = "METRES",
        requires = "inverse",
        group = "surface",
        allow_negative_numbers = true
    )]
    height: Option<f64>,

    /// With an RPC: what heights count from
    #[arg(long, value_enum, requires_if("geoid", "geoid"))]
    heights: Option<HeightReference>,

    /// With --heights geoid: the heights of the geoid above the WGS84 ellipsoid (GTX)
    #[arg(long, value_name = "GEOID.gtx", requires = "heights")]
    geoid: Option<PathBuf>,

    /// The table to write; without it, standard output
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
}

/// What heights count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum HeightReference {
    /// The WGS84 ellipsoid, as those of satellite positioning; the default
    Ellipsoid,
    /// The geoid, as those of most maps and elevation models
    Geoid,
}

const LONG: &str = "\
Compute the pixels of world points, or with --inverse the ground points of pixels.

X, Y, Z are world coordinates in the camera's unit; x, y are pixels from the top-left corner of the \
top-left pixel, through the lens. The table has the columns id, X, Y, Z, x, y, status. The status is \
`ok`, `outside the picture` (x and y are given all the same), or the reason why there are none: the \
point lies behind the camera or beyond the radius where the lens folds back, the line of sight does \
not meet the plane, no time of the scan sees the point. Numbers are written with as many digits as bring back the same 64 bits. A list \
with a header and no points gives a table without lines, an empty file is an error.

A file with a rational polynomial camera (RPB, _RPC.TXT, DIMAP XML, GeoTIFF, OSSIM .geom, collinear's \
JSON) is taken as the camera too. Its points are longitude and latitude on WGS84 in degrees and a \
height in metres above the ellipsoid, or with --heights geoid above the geoid; the columns are lon, lat, \
h in place of X, Y, Z. Its picture's size is not known, no point is outside it. Collinear's own JSON may \
say the size and a Cartesian world: then the points are X, Y, Z there, unless --heights or --height is given.";

const AFTER: &str = "\
Examples:
  collinear project --camera south.json control.csv -o images.csv
  collinear project --camera south.json --inverse --plane ground.json clicks.csv
  collinear project --camera left_RPC.TXT --heights geoid --geoid egm96_15.gtx control.csv
  collinear project --camera left.RPB --inverse --height 300 clicks.csv

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
        if let Some(path) = &self.geoid {
            files.input("the geoid", path)?;
        }
        // An RPC that stands in a world is a camera like others, unless heights say that places are meant.
        let geographic =
            |f: &RpcFile| f.world.is_none() || self.height.is_some() || self.heights.is_some();
        if let Some(file) = read_if_rpc(&self.camera)?.filter(geographic) {
            let rows = self.through_rpc(&file)?;
            return self.write(&rows, &rpc::to_csv(&rows));
        }
        if self.height.is_some() || self.heights.is_some() {
            let why = "heights are of an RPC: with this camera give a --plane";
            return Err(in_file(&self.camera, anyhow!(why)));
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
        self.write(&rows, &to_csv(&rows))
    }

    /// Points through a rational polynomial camera.
    fn through_rpc(&self, file: &RpcFile) -> Result<Vec<ProjectedRow>> {
        let rpc = file.rpc().map_err(|e| e.in_file(&self.camera))?;
        let heights = match (self.heights, &self.geoid) {
            (Some(HeightReference::Geoid), Some(path)) => {
                Heights::Geoid(read_gtx(path)?.geoid_grid().map_err(|e| e.in_file(path))?)
            }
            (_, Some(path)) => {
                let why =
                    "is not used where heights count from the ellipsoid: give --heights geoid";
                return Err(in_file(path, anyhow!(why)));
            }
            _ => Heights::Ellipsoid,
        };
        if !self.inverse {
            return Ok(rpc::project(&rpc, &heights, &read_geographic(&self.points)?));
        }
        let why = "an RPC has no place for a plane: give the --height of its points";
        let height = self.height.ok_or_else(|| in_file(&self.camera, anyhow!(why)))?;
        Ok(rpc::ground(&rpc, &heights, height, &read_image_points(&self.points)?))
    }

    fn write(&self, rows: &[ProjectedRow], text: &str) -> Result<()> {
        if rows.is_empty() {
            let what = if self.inverse { "no point with x and y" } else { "no point" };
            say(&format!("warning: {}: {what} is in it", self.points.display()));
        }
        match &self.output {
            Some(path) => Ok(write_atomically(path, |w| w.write_all(text.as_bytes()))?),
            None => print(text),
        }
    }
}
