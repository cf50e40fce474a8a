//! `collinear convert`.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::{Args, ValueEnum};
use collinear::camera::rpc::FitResiduals;
use collinear::geometry::projection::ClipConvention;
use collinear_cli::convert::{Target, outputs, write};
use collinear_cli::rpc;
use collinear_io::Document;
use collinear_io::camera::CameraFile;
use collinear_io::colmap::{self, Encoding};
use collinear_io::opencv::Form;
use collinear_io::orientation::AngleUnit;
use collinear_io::photographs::{self, Given};
use collinear_io::pix4d::parse_offset;
use collinear_io::rpc::{RpcFile, World, read_if_rpc};
use collinear_io::sensor::SensorFile;

use super::{Files, Size, UsageError, in_file, positive, say};

/// Convert cameras between the files of photogrammetric and computer-vision programs
#[derive(Debug, Args)]
#[command(long_about = LONG, after_help = AFTER)]
pub(crate) struct Arguments {
    /// The cameras: a camera file, an OpenSfM reconstruction, COLMAP's folder, Bundler's bundle.out, an
    /// OpenCV calibration, Metashape's exported cameras or calibration, Pix4D's parameters, glTF or GLB,
    /// nerfstudio's transforms.json, a table of orientations or PATB's (with --interior); or a file with an
    /// RPC
    #[arg(value_name = "CAMERAS")]
    input: PathBuf,

    /// What to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,

    /// Only this photograph, by its name in CAMERAS; may be given again
    #[arg(long, value_name = "NAME")]
    photograph: Vec<String>,

    /// Width and height of the pictures, where CAMERAS does not say: bundle.out, Pix4D's
    /// pmatrix.txt, glTF
    #[arg(long, value_name = "WxH", value_parser = Size::parse)]
    size: Option<Size>,

    /// For tables of orientations: any file of the camera that took the photographs, as Pix4D's .cam
    #[arg(long, value_name = "FILE")]
    interior: Option<PathBuf>,

    /// The unit of the angles in a table of orientations, read where its header has none, or written
    /// (degrees without it)
    #[arg(long, value_name = "UNIT")]
    angles: Option<Angles>,

    /// Add this to the projection centres: a file with three numbers, as Pix4D's offset.xyz, or X,Y,Z
    #[arg(long, value_name = "FILE|X,Y,Z", allow_hyphen_values = true)]
    offset: Option<String>,

    /// For matrices and glTF: the depth of the near plane, world units
    #[arg(long, value_name = "DEPTH", default_value = "0.1", value_parser = positive, allow_negative_numbers = true)]
    near: f64,

    /// For matrices and glTF: the depth of the far plane; without it depths have no end
    #[arg(long, value_name = "DEPTH", value_parser = positive, allow_negative_numbers = true)]
    far: Option<f64>,

    /// For RPC: the Cartesian world of a camera or scanner, `geocentric` on WGS84, or LAT,LON,H of the place
    /// (degrees, metres) from which x leads east, y north, z up. Of an RPC the world that it is to stand in
    #[arg(long, value_name = "WORLD", value_parser = world, allow_hyphen_values = true)]
    world: Option<World>,

    /// For an RPC that is fitted to a camera or scanner: the lowest and the highest ground, metres above
    /// the ellipsoid
    #[arg(long, value_name = "MIN,MAX", value_parser = heights, allow_hyphen_values = true)]
    between: Option<[f64; 2]>,

    /// The file of a single photograph, or the folder of several and of COLMAP's files
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Angles {
    /// Degrees
    Deg,
    /// Gon, 400 to a turn
    Gon,
    /// Radians
    Rad,
}

impl Angles {
    fn unit(self) -> AngleUnit {
        match self {
            Self::Deg => AngleUnit::Degrees,
            Self::Gon => AngleUnit::Gon,
            Self::Rad => AngleUnit::Radians,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Format {
    /// Camera files, docs/formats.md
    Camera,
    /// COLMAP's cameras.txt, images.txt, points3D.txt
    Colmap,
    /// COLMAP's cameras.bin, images.bin, points3D.bin
    ColmapBinary,
    /// Bundler's bundle.out, version 0.3
    Bundler,
    /// OpenSfM's and ODM's reconstruction.json
    Opensfm,
    /// OpenCV's FileStorage, YAML
    Opencv,
    /// OpenCV's FileStorage, JSON
    OpencvJson,
    /// OpenCV's FileStorage, XML
    OpencvXml,
    /// Agisoft Metashape's exported cameras, XML
    Metashape,
    /// Pix4D's calibrated_camera_parameters.txt
    Pix4d,
    /// Exterior orientations alone: a table of name, X, Y, Z, omega, phi, kappa
    Opk,
    /// Exterior orientations alone: PATB's three lines a photograph
    Patb,
    /// glTF 2.0 with cameras alone; the world's coordinates stay as they are
    Gltf,
    /// A Python script that makes the cameras in Blender: blender --python OUT
    Blender,
    /// transforms.json of nerfstudio and instant-ngp
    Nerf,
    /// A rational polynomial camera, docs/formats.md
    Rpc,
    /// A rational polynomial camera as RPB
    Rpb,
    /// A rational polynomial camera as _RPC.TXT
    RpcTxt,
    /// View and projection matrices for OpenGL and WebGL
    Opengl,
    /// View and projection matrices for Direct3D and Metal
    Direct3d,
    /// View and projection matrices for Vulkan
    Vulkan,
    /// View and projection matrices for wgpu and WebGPU
    Wgpu,
}

/// A fit that is farther off than this between its nodes, in pixels, is worth a warning.
const LARGE_RESIDUAL: f64 = 0.1;

/// What a format is a format of.
enum Output {
    /// Of photographs' cameras.
    Photographs(Target),
    /// Of a rational polynomial camera.
    Rational(fn(&RpcFile, &Path) -> Result<(), collinear_io::Error>),
}

const LONG: &str = "\
Convert cameras between the files of photogrammetric and computer-vision programs.

Pixel origins, axes and the order of parameters are those of each program: docs/coming-from.md says \
which. A camera that the other program cannot have exactly, as a lens in a matrix, is an error and \
nothing is written. Several photographs become files in the folder OUT, named like them.";

/// A world by name or place.
fn world(text: &str) -> Result<World, String> {
    if text == "geocentric" {
        return Ok(World::Geocentric {});
    }
    match numbers(text)[..] {
        [latitude_deg, longitude_deg, height] if latitude_deg.abs() <= 90.0 => {
            Ok(World::EastNorthUp { latitude_deg, longitude_deg, height })
        }
        _ => Err("expected `geocentric`, or a latitude from −90 to 90, a longitude and a height, as 44.1,5.2,0".into()),
    }
}

/// The lowest and the highest ground.
fn heights(text: &str) -> Result<[f64; 2], String> {
    match numbers(text)[..] {
        [low, high] if low < high => Ok([low, high]),
        _ => Err("expected two heights in metres, the lower first, as 0,800".into()),
    }
}

/// Finite numbers parted by commas; none where one of them is not.
fn numbers(text: &str) -> Vec<f64> {
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    text.split(',').map(number).collect::<Option<_>>().unwrap_or_default()
}

const AFTER: &str = "\
Examples:
  collinear convert sparse/0 --to camera -o cameras/
  collinear convert reconstruction.json --photograph 01.jpg --to opencv -o 01.yml
  collinear convert south.json --to wgpu --near 1 -o south.matrices.json
  collinear convert table.txt --interior camera.json --angles gon --to colmap -o sparse/
  collinear convert image.tif --to rpb -o image.RPB
  collinear convert strip.json --to rpc --world 44.1,5.2,0 --between 200,900 -o strip.rpc.json

Exit codes: 0 done; 1 failed (old files are left as they were); 2 wrong usage, as an output that is \
the input.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.input("the cameras", &self.input)?;
        if self.input.is_dir() {
            for encoding in [Encoding::Text, Encoding::Binary] {
                for path in colmap::files(&self.input, encoding) {
                    files.input("the cameras", &path)?;
                }
            }
        }
        files.output("the output (-o)", &self.output)?;
        let rational = if self.input.is_file() { read_if_rpc(&self.input)? } else { None };
        let target = match (self.to_what()?, rational) {
            (Output::Rational(write), file) => {
                let file = self.in_world(match file {
                    Some(_) if !self.photograph.is_empty() => {
                        return Err(in_file(&self.input, "is one camera: leave --photograph out"));
                    }
                    Some(file) => file,
                    None => self.fitted(&mut files)?,
                });
                return Ok(write(&file, &self.output)?);
            }
            (Output::Photographs(_), Some(_)) => {
                let why = "is a rational polynomial camera: convert it --to rpc, rpb or rpc-txt";
                return Err(in_file(&self.input, why));
            }
            (Output::Photographs(target), None) => target,
        };
        let cameras = self.photographs(&mut files)?;
        for path in outputs(&cameras, target, &self.output).map_err(|e| in_file(&self.input, e))? {
            if path != self.output {
                files.output("an output", &path)?;
            }
        }
        if let Target::Colmap(encoding) = target {
            for path in colmap::files(&self.output, encoding) {
                files.output("an output", &path)?;
            }
        }
        let paths = write(&cameras, target, &self.output).map_err(|e| in_file(&self.input, e))?;
        if let [_, _, ..] = &paths[..] {
            say(&format!("{} files in {}", paths.len(), self.output.display()));
        }
        Ok(())
    }

    /// The photographs that are asked for.
    fn photographs(&self, files: &mut Files) -> Result<Vec<(String, CameraFile)>> {
        let mut cameras = photographs::read_with(&self.input, &self.given(files)?)?;
        if !self.photograph.is_empty() {
            for name in &self.photograph {
                if !cameras.iter().any(|(n, _)| n == name) {
                    let known: Vec<_> = cameras.iter().map(|(n, _)| n.as_str()).take(10).collect();
                    let more = if cameras.len() > 10 { ", …" } else { "" };
                    return Err(in_file(
                        &self.input,
                        anyhow!("has no photograph `{name}`: {}{more}", known.join(", ")),
                    ));
                }
            }
            cameras.retain(|(n, _)| self.photograph.contains(n));
        }
        Ok(cameras)
    }

    /// The RPC with the size and the world that were given.
    fn in_world(&self, mut file: RpcFile) -> RpcFile {
        if let Some(Size { width, height }) = self.size {
            (file.width, file.height) = (Some(width), Some(height));
        }
        file.world = self.world.or(file.world);
        file
    }

    /// A rational polynomial camera in place of a camera or a scanner.
    fn fitted(&self, files: &mut Files) -> Result<RpcFile> {
        let (Some(world), Some(between)) = (self.world, self.between) else {
            let why = "holds no rational polynomial camera: to fit one to its camera give --world and --between";
            return Err(in_file(&self.input, why));
        };
        let sensor = match SensorFile::read(&self.input) {
            Ok(scanner @ SensorFile::Scanner(_)) => scanner,
            _ => match &self.photographs(files)?[..] {
                [(_, camera)] => camera.clone().into(),
                others => {
                    let count = others.len();
                    let why = anyhow!("has {count} photographs: choose one with --photograph");
                    return Err(in_file(&self.input, why));
                }
            },
        };
        let (file, report) =
            rpc::fit(&sensor, world, between).map_err(|e| in_file(&self.input, e))?;
        let brief = |r: &FitResiduals| format!("{:.2e} px rms, {:.2e} at most", r.rms, r.max);
        say(&format!(
            "{}: off at the {} nodes {}; at the {} between them {}",
            self.output.display(),
            report.fit.points,
            brief(&report.fit),
            report.check.points,
            brief(&report.check)
        ));
        if report.check.max > LARGE_RESIDUAL {
            say(&format!(
                "warning: {}: between the nodes the fit is off by up to {:.2} px: polynomials do not suit this camera or these heights",
                self.output.display(),
                report.check.max
            ));
        }
        Ok(file)
    }

    /// What the input may not say.
    fn given(&self, files: &mut Files) -> Result<Given> {
        let size = self.size.map(|s| [s.width, s.height]);
        let interior = match &self.interior {
            Some(path) => {
                files.input("the camera (--interior)", path)?;
                Some(photographs::read_interior(path, size)?)
            }
            None => None,
        };
        let offset = match &self.offset {
            Some(given) => {
                let path = Path::new(given);
                if path.is_file() {
                    files.input("the offset (--offset)", path)?;
                    let text = std::fs::read_to_string(path).map_err(|e| in_file(path, e))?;
                    parse_offset(&text).map_err(|e| in_file(path, e))?
                } else {
                    parse_offset(given).map_err(|_| {
                        UsageError(format!("--offset {given}: no such file, nor three numbers"))
                    })?
                }
            }
            None => [0.0; 3],
        };
        Ok(Given { size, interior, angle_unit: self.angles.map(Angles::unit), offset })
    }

    /// What is to be written.
    fn to_what(&self) -> Result<Output, UsageError> {
        let depths = || match self.far {
            Some(far) if far <= self.near => {
                Err(UsageError("--far is not beyond --near: give a greater depth".into()))
            }
            far => Ok((self.near, far)),
        };
        let matrices = |convention| depths().map(|(near, far)| Target::Gpu(convention, near, far));
        Ok(Output::Photographs(match self.to {
            Format::Rpc => return Ok(Output::Rational(RpcFile::write)),
            Format::Rpb => return Ok(Output::Rational(RpcFile::write_rpb)),
            Format::RpcTxt => return Ok(Output::Rational(RpcFile::write_rpc_txt)),
            Format::Camera => Target::Camera,
            Format::Colmap => Target::Colmap(Encoding::Text),
            Format::ColmapBinary => Target::Colmap(Encoding::Binary),
            Format::Bundler => Target::Bundler,
            Format::Opensfm => Target::OpenSfm,
            Format::Opencv => Target::OpenCv(Form::Yaml),
            Format::OpencvJson => Target::OpenCv(Form::Json),
            Format::OpencvXml => Target::OpenCv(Form::Xml),
            Format::Metashape => Target::Metashape,
            Format::Pix4d => Target::Pix4d,
            Format::Patb => Target::Patb,
            Format::Opk => Target::Opk(self.angles.map_or(AngleUnit::Degrees, Angles::unit)),
            Format::Gltf => depths().map(|(near, far)| Target::Gltf(near, far))?,
            Format::Blender => Target::Blender,
            Format::Nerf => Target::Nerf,
            Format::Opengl => matrices(ClipConvention::OpenGl)?,
            Format::Direct3d => matrices(ClipConvention::Direct3d)?,
            Format::Vulkan => matrices(ClipConvention::Vulkan)?,
            Format::Wgpu => matrices(ClipConvention::Wgpu)?,
        }))
    }
}
