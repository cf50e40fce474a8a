//! `collinear rectify`.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use clap::{ArgGroup, Args};
use collinear_cli::lookup::Drawn;
use collinear_cli::rectify::{Rectification, footprint, size_at};
use collinear_io::Document;
use collinear_io::map::MapFile;
use collinear_io::picture::{Picture, read_picture, write_picture};
use collinear_io::plane::{PlaneFile, Rectangle};
use collinear_io::sensor::SensorFile;
use collinear_io::write_atomically;

use super::{
    BorderChoice, Files, FilterChoice, Quad, Size, in_file, picture_path, positive, quad, say,
    with_bar,
};

/// Turn a plane of the world, as a façade, face-on
#[derive(Debug, Args)]
#[command(
    long_about = LONG,
    after_help = AFTER,
    group(ArgGroup::new("what").required(true).args(["plane", "quad"])),
    group(ArgGroup::new("scale").required(true).args(["size", "gsd"]))
)]
pub(crate) struct Arguments {
    /// The photograph: PNG, JPEG or TIFF
    photo: PathBuf,

    /// The photograph's camera or scanner (JSON); its lens is taken into account
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: Option<PathBuf>,

    /// The plane (JSON), looked at from the side to which its normal points, its up upwards. Without a
    /// `rectangle` in it all that the photograph shows of it
    #[arg(short, long, value_name = "PLANE.json", requires = "camera")]
    plane: Option<PathBuf>,

    /// Four points of the photograph instead of a plane, pixels, clockwise from the top left corner of
    /// what is to be a rectangle
    #[arg(short, long, value_name = "X1,Y1 X2,Y2 X3,Y3 X4,Y4", value_parser = quad, allow_hyphen_values = true)]
    quad: Option<Quad>,

    /// The size of the picture to write, pixels: its edges are the rectangle's
    #[arg(short, long, value_name = "WIDTHxHEIGHT", value_parser = Size::parse)]
    size: Option<Size>,

    /// Units of the world for each pixel, instead of a size; the rectangle is grown to the right and
    /// downwards to whole pixels
    #[arg(
        long, value_name = "UNITS", value_parser = positive, allow_negative_numbers = true, conflicts_with = "quad",
        alias = "units-per-pixel"
    )]
    gsd: Option<f64>,

    /// The picture to write: .png, .jpg, .jpeg, .tif or .tiff
    #[arg(short, long, value_name = "OUT", value_parser = picture_path)]
    output: PathBuf,

    /// A colour between pixels of the photograph: that of the pixel it lies in, or of the four around it
    #[arg(long, value_enum, default_value_t)]
    filter: FilterChoice,

    /// What lies beyond the photograph: `transparent`, `constant:R,G,B`, `clamp`, `repeat` or `mirror`.
    /// Without it black in a JPEG and transparent elsewhere
    #[arg(long, value_name = "BORDER", value_parser = BorderChoice::parse)]
    border: Option<BorderChoice>,

    /// Write the homography used, photograph from picture, as a map file (JSON). With a lens `brown`
    /// it leads into the photograph without its lens errors, other models than `pinhole`, `brown` and
    /// `orthographic` have none
    #[arg(long, value_name = "MAP.json")]
    map_out: Option<PathBuf>,
}

const LONG: &str = "\
Turn a plane of the world, as a façade, face-on.

With --camera and --plane no corners are picked: each pixel of the new picture is a point of the \
plane, and that point is looked up in the photograph through its camera and lens. With --quad four \
points of the photograph become the corners of the new picture; a camera given too takes its lens \
errors away.

The plane's point and rectangle are in world units, the corners in pixels of the photograph from the \
top-left corner of its top-left pixel. docs/formats.md describes the files.";

const AFTER: &str = "\
Examples:
  collinear rectify south.jpg --camera south.json --plane facade.json --gsd 0.01 -o facade.png
  collinear rectify south.jpg --quad \"120,80 900,40 910,700 100,650\" --size 800x600 -o facade.png

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.output("the output (-o)", &self.output)?;
        if let Some(path) = &self.map_out {
            files.output("the map (--map-out)", path)?;
        }
        files.input("the photograph", &self.photo)?;
        for (role, path) in [("the camera", &self.camera), ("the plane", &self.plane)] {
            if let Some(path) = path {
                files.input(role, path)?;
            }
        }
        let border = BorderChoice::of(self.border, &self.output)?;
        let camera = self.camera.as_deref().map(SensorFile::read).transpose()?;
        let (rectification, rectangle) = match (&self.plane, &camera, &self.quad) {
            (Some(path), Some(camera), _) => {
                let plane = PlaneFile::read(path)?;
                let (made, rectangle) =
                    self.of_plane(&plane, camera).map_err(|e| in_file(path, e))?;
                (made, Some(rectangle))
            }
            (_, camera, Some(corners)) => {
                let Size { width, height } = self.size.context("--quad needs --size")?;
                let made = Rectification::of_quad(corners, camera.as_ref(), width, height)
                    .map_err(|e| anyhow!("--quad: {e}"))?;
                (made, None)
            }
            _ => return Err(anyhow!("one of --plane (with --camera) and --quad is needed")),
        };
        if let (Some(_), Some(file), Some(camera), None) =
            (&self.map_out, &self.camera, &camera, rectification.homography())
        {
            let model = match camera {
                SensorFile::Camera(camera) => camera.interior.model(),
                SensorFile::Scanner(_) => "scanner",
                SensorFile::Rpc(_) => "rpc",
            };
            return Err(in_file(
                file,
                anyhow!("interior.model: no homography is part of `{model}`, leave out --map-out"),
            ));
        }
        let photograph = self.photograph(camera.as_ref())?;
        let rectified = with_bar("rectifying", |progress| {
            rectification.apply(&photograph, self.filter.into(), border, progress)
        });
        drop(photograph);
        let Drawn { picture, seen } = rectified.map_err(|e| in_file(&self.photo, e))?;
        if rectification.is_mirrored() {
            say(&format!(
                "warning: {}: left and right are exchanged: {}",
                self.output.display(),
                if self.quad.is_some() {
                    "the corners go counter-clockwise"
                } else {
                    "the photograph sees the plane from behind, reverse its normal"
                }
            ));
        }
        if let (Some(path), Some(homography)) = (&self.map_out, rectification.homography()) {
            let m = homography.matrix();
            let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[(i, j)]));
            let text = MapFile::Homography { matrix: rows }.to_json()?;
            write_atomically(path, |w| w.write_all(text.as_bytes()))?;
            if rectification.through_lens() {
                say(&format!(
                    "warning: {}: the homography leads into the photograph without its lens errors",
                    path.display()
                ));
            }
        }
        write_picture(&self.output, &picture)?;
        let place = rectangle.map(|r| format!(" {}", corners(&r))).unwrap_or_default();
        let all = u64::from(picture.width) * u64::from(picture.height);
        let part =
            if seen < all { format!(", {seen} of {all} in the photograph") } else { String::new() };
        say(&format!(
            "{}: {} × {} pixels{place}{part}",
            self.output.display(),
            picture.width,
            picture.height
        ));
        Ok(())
    }

    fn photograph(&self, camera: Option<&SensorFile>) -> Result<Picture> {
        let photograph = read_picture(&self.photo)?;
        if let Some(camera) = camera {
            camera
                .check_picture_size(photograph.width, photograph.height)
                .map_err(|e| in_file(&self.photo, e))?;
        }
        Ok(photograph)
    }

    fn of_plane(
        &self,
        plane: &PlaneFile,
        camera: &SensorFile,
    ) -> Result<(Rectification, Rectangle)> {
        let rectangle = match plane.rectangle {
            Some(rectangle) => rectangle,
            None => footprint(plane, camera)?,
        };
        let (rectangle, width, height) = match (self.gsd, self.size) {
            (Some(gsd), _) => size_at(&rectangle, gsd)?,
            (None, Some(Size { width, height })) => (rectangle, width, height),
            (None, None) => return Err(anyhow!("one of --size and --gsd is needed")),
        };
        let made = Rectification::of_plane(plane, &rectangle, camera, width, height)?;
        Ok((made, rectangle))
    }
}

/// A rectangle's corners, to a millionth of its size.
fn corners(r: &Rectangle) -> String {
    let size = (r.right - r.left).max(r.top - r.bottom);
    let digits = (6.0 - size.log10()).ceil().clamp(0.0, 300.0) as usize;
    let short = |v: f64| {
        // Adding zero makes −0 into 0.
        let rounded = format!("{v:.digits$}").parse().unwrap_or(v) + 0.0;
        let plain = rounded == 0.0 || (1e-4..1e15).contains(&rounded.abs());
        if plain { rounded.to_string() } else { format!("{rounded:e}") }
    };
    let [left, bottom, right, top] = [r.left, r.bottom, r.right, r.top].map(short);
    format!("from {left}, {bottom} to {right}, {top}")
}
