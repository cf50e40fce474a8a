//! `collinear warp`.

use std::num::NonZero;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::{ArgGroup, Args, ValueEnum};
use collinear::resample::{AreaFilter, Cubic, Filter, Light};
use collinear_cli::check_size;
use collinear_cli::warp::{AnyFilter, Beyond, Job, map_of, map_of_quad};
use collinear_io::Document;
use collinear_io::map::MapFile;
use collinear_io::picture::{PictureFormat, read_picture, write_picture};

use super::{
    BorderChoice, Files, Quad, Size, UsageError, in_file, picture_path, quad, say, with_bar,
};

/// A picture through a map: any filter, any border
#[derive(Debug, Args)]
#[command(
    long_about = LONG,
    after_help = AFTER,
    group(ArgGroup::new("where").required(true).args(["map", "quad"]))
)]
pub(crate) struct Arguments {
    /// The picture: PNG, JPEG or TIFF
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The picture to write: .png, .jpg, .jpeg, .tif or .tiff
    #[arg(value_name = "OUT", value_parser = picture_path)]
    output: PathBuf,

    /// The map (JSON), from a point of the new picture to the point of the old one that it shows
    #[arg(short, long, value_name = "MAP.json")]
    map: Option<PathBuf>,

    /// Four points of the old picture that become the corners of the new one, pixels, clockwise from the top
    /// left
    #[arg(short, long, value_name = "X1,Y1 X2,Y2 X3,Y3 X4,Y4", value_parser = quad, allow_hyphen_values = true, requires = "size")]
    quad: Option<Quad>,

    /// The size of the new picture, pixels; with --map without it that of the old one
    #[arg(short, long, value_name = "WIDTHxHEIGHT", value_parser = Size::parse)]
    size: Option<Size>,

    /// What a pixel is made of: nearest, bilinear, catmull-rom, mitchell, b-spline, keys:A, lanczos2, lanczos3,
    /// lanczos4; or of all texels it covers: trilinear, ewa, ewa:ANISOTROPY
    #[arg(short, long, value_name = "FILTER", value_parser = filter, default_value = "bilinear", allow_hyphen_values = true)]
    filter: AnyFilter,

    /// What lies beyond the picture: `transparent`, `constant:R,G,B`, `clamp`, `repeat`, `mirror`, or `error`,
    /// which refuses a map that looks there. Without it black in a JPEG and transparent elsewhere
    #[arg(short, long, value_name = "BORDER", value_parser = beyond)]
    border: Option<Border>,

    /// What is weighed: samples as they stand, or the light that they stand for by sRGB's curve
    #[arg(short, long, value_enum, default_value_t)]
    light: LightChoice,

    /// Threads; without it as many as there are processors. They change no byte
    #[arg(short, long, value_name = "NUMBER", value_parser = threads)]
    threads: Option<NonZero<u16>>,
}

const LONG: &str = "\
A picture through a map: any filter, any border.

The map leads from each pixel of the new picture to the place in the old one that is looked up; map files \
are described in docs/formats.md, `collinear rectify --map-out` writes them. With --quad four points \
become the corners. Places are pixels from the top-left corner of the top-left pixel, whose centre is \
(0.5, 0.5).

Filters of single places (nearest to lanczos4) alias where the map makes the picture smaller: then take \
trilinear, or ewa, which is sharper where it is made smaller in one direction more than in the other. \
docs/filters.md shows them all.

Grey, colour and opacity stay as they are; colours are weighed by their opacity. A transparent border \
adds it where the picture has none and the map looks beyond. Samples of 16 bits become 8. Pixels \
beyond a horizon, or that look further away than 2^30 pixels, look nowhere: they are clear, the \
constant, or black.";

const AFTER: &str = "\
Examples:
  collinear warp in.jpg out.png --map map.json --filter lanczos3
  collinear warp floor.png small.png --quad \"0,400 800,400 2000,900 -900,900\" --size 400x300 --filter ewa
  collinear warp in.png out.png --map map.json --border error --light srgb --threads 2

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

/// A border, or the refusal of one.
#[derive(Clone, Copy, Debug)]
enum Border {
    Choice(BorderChoice),
    Error,
}

fn beyond(text: &str) -> Result<Border, String> {
    if text == "error" {
        return Ok(Border::Error);
    }
    BorderChoice::parse(text)
        .map(Border::Choice)
        .map_err(|e| e.replace(" or mirror", ", mirror or error"))
}

fn filter(text: &str) -> Result<AnyFilter, String> {
    let (name, value) = text.split_once([':', '=']).map_or((text, None), |(n, v)| (n, Some(v)));
    let point = |filter| Ok(AnyFilter::Point(filter));
    match (name, value) {
        ("nearest", None) => point(Filter::Nearest),
        ("bilinear", None) => point(Filter::Bilinear),
        ("catmull-rom" | "bicubic", None) => point(Filter::Bicubic(Cubic::CATMULL_ROM)),
        ("mitchell", None) => point(Filter::Bicubic(Cubic::MITCHELL)),
        ("b-spline", None) => point(Filter::Bicubic(Cubic::B_SPLINE)),
        ("keys", Some(a)) => match a.parse::<f64>() {
            Ok(a) if (-4.0..=4.0).contains(&a) => point(Filter::Bicubic(Cubic::keys(a))),
            _ => Err(format!("`{a}` is no number from -4 to 4, as keys:-0.75")),
        },
        ("lanczos2", None) => point(Filter::Lanczos2),
        ("lanczos3", None) => point(Filter::Lanczos3),
        ("lanczos4", None) => point(Filter::Lanczos4),
        ("trilinear", None) => Ok(AnyFilter::Area(AreaFilter::Trilinear)),
        ("ewa", None) => Ok(AnyFilter::Area(AreaFilter::Ewa { anisotropy: 16 })),
        ("ewa", Some(n)) => match n.parse::<u8>() {
            Ok(anisotropy @ 1..=64) => Ok(AnyFilter::Area(AreaFilter::Ewa { anisotropy })),
            _ => Err(format!("`{n}` is no whole number from 1 to 64, as ewa:16")),
        },
        _ => Err("expected nearest, bilinear, catmull-rom, mitchell, b-spline, keys:A, lanczos2, \
                  lanczos3, lanczos4, trilinear, ewa or ewa:ANISOTROPY"
            .into()),
    }
}

fn threads(text: &str) -> Result<NonZero<u16>, String> {
    match text.parse() {
        Ok(threads @ 1..=1024) => NonZero::new(threads).ok_or_else(String::new),
        _ => Err("expected a whole number from 1 to 1024".into()),
    }
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum LightChoice {
    /// Samples as they stand
    #[default]
    Samples,
    /// The light of sRGB's samples
    Srgb,
}

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.output("the output (OUT)", &self.output)?;
        files.input("the picture (IN)", &self.input)?;
        if let Some(path) = &self.map {
            files.input("the map (--map)", path)?;
        }
        let beyond = match self.border {
            Some(Border::Error) => Beyond::Refused,
            Some(Border::Choice(choice)) => {
                Beyond::Border(BorderChoice::of(Some(choice), &self.output)?)
            }
            None => Beyond::Border(BorderChoice::of(None, &self.output)?),
        };
        let file = self.map.as_deref().map(MapFile::read).transpose()?;
        let picture = read_picture(&self.input)?;
        let size = self.size.unwrap_or(Size { width: picture.width, height: picture.height });
        check_size(size.width, size.height)?;
        let map = match (&file, &self.map, &self.quad) {
            (Some(file), Some(path), _) => map_of(file).map_err(|e| in_file(path, e))?,
            (_, _, Some(corners)) => {
                map_of_quad(corners, size.width, size.height).map_err(|e| anyhow!("--quad: {e}"))?
            }
            _ => return Err(UsageError("one of --map and --quad is needed".into()).into()),
        };
        let light = match self.light {
            LightChoice::Samples => Light::Linear,
            LightChoice::Srgb => Light::Srgb,
        };
        let (width, height) = (size.width, size.height);
        let format = PictureFormat::from_path(&self.output)?;
        let job = Job { width, height, filter: self.filter, beyond, light, format };
        let threads = self.threads.map_or(0, |n| n.get().into());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let painted =
            with_bar("warping", |progress| job.paint(&pool, &picture, map.as_ref(), progress));
        let (made, seen) = painted.map_err(|e| in_file(&self.input, e))?;
        drop(picture);
        write_picture(&self.output, &made)?;
        let all = u64::from(width) * u64::from(height);
        let part =
            if seen < all { format!(", {seen} of {all} in the picture") } else { String::new() };
        say(&format!("{}: {width} × {height} pixels{part}", self.output.display()));
        Ok(())
    }
}
