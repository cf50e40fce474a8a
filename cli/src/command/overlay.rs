//! `collinear overlay`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::{ArgGroup, Args};
use collinear_cli::overlay::{
    Figure, Overlay, Photograph, mesh_figures, plane_figure, scene_figures,
};
use collinear_io::Document;
use collinear_io::picture::{Limits, PictureFormat, decode_picture, write_picture};
use collinear_io::plane::PlaneFile;
use collinear_io::sensor::SensorFile;
use collinear_io::write_atomically;

use super::{Files, in_file, open_scene, positive, say};

/// Draw planes, polygons or a mesh as wire frames over a photograph
#[derive(Debug, Args)]
#[command(
    long_about = LONG,
    after_help = AFTER,
    group(ArgGroup::new("what").required(true).args(["scene", "plane", "mesh"]))
)]
pub(crate) struct Arguments {
    /// The photograph: PNG, JPEG or TIFF
    photo: PathBuf,

    /// The photograph's camera or scanner (JSON)
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: PathBuf,

    /// The polygons of a scene (JSON)
    #[arg(long, value_name = "SCENE.json")]
    scene: Option<PathBuf>,

    /// The `rectangle` of a plane (JSON)
    #[arg(short, long, value_name = "PLANE.json")]
    plane: Option<PathBuf>,

    /// The faces and lines of a mesh (Wavefront OBJ), a colour for each object or group
    #[arg(long, value_name = "MESH.obj")]
    mesh: Option<PathBuf>,

    /// The picture to write: .svg, .png, .jpg, .jpeg, .tif or .tiff
    #[arg(short, long, value_name = "OUT", value_parser = overlay_path)]
    output: PathBuf,

    /// The width of lines, pixels; without it 1/800 of the photograph's longer side, at least 1.5
    #[arg(long, value_name = "PIXELS", value_parser = positive, allow_negative_numbers = true)]
    line_width: Option<f64>,

    /// With --plane: cells along each side of the rectangle
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    #[arg(conflicts_with_all = ["scene", "mesh"])]
    grid: u32,

    /// In an SVG, name the photograph's file instead of holding its bytes
    #[arg(long)]
    link: bool,

    /// In an SVG, leave names out
    #[arg(long)]
    no_names: bool,
}

const LONG: &str = "\
Draw planes, polygons or a mesh as wire frames over a photograph: the first check that camera, world \
and photograph belong together.

Vertices are world coordinates in the camera's unit. Edges go through the lens, bent to within 0.1 \
pixel; they end before the camera and where the lens folds back. Each edge is drawn once, in the \
colour of the first polygon that has it; nothing hides anything.

An SVG holds the photograph, its units are the photograph's pixels, and names stand in it as text.";

const AFTER: &str = "\
Example:
  collinear overlay south.jpg --camera south.json --scene town.json -o check.svg

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

/// The line width, as a part of the picture's longer side, and at least so many pixels.
const LINE_WIDTH: (f64, f64) = (1.0 / 800.0, 1.5);

fn is_svg(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

fn overlay_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if is_svg(&path) || PictureFormat::from_path(&path).is_ok() {
        return Ok(path);
    }
    Err("name the output .svg, .png, .jpg, .jpeg, .tif or .tiff".into())
}

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.output("the output (-o)", &self.output)?;
        files.input("the photograph", &self.photo)?;
        files.input("the camera", &self.camera)?;
        let camera = SensorFile::read(&self.camera)?;
        let figures = self.figures(&mut files)?;
        let bytes = fs::read(&self.photo)
            .map_err(|e| in_file(&self.photo, anyhow!("cannot be read: {e}")))?;
        let photograph =
            decode_picture(&bytes, Limits::default()).map_err(|e| in_file(&self.photo, e))?;
        camera
            .check_picture_size(photograph.width, photograph.height)
            .map_err(|e| in_file(&self.photo, e))?;
        let overlay = Overlay::trace(&figures, &camera).map_err(|e| in_file(&self.camera, e))?;
        let longer = f64::from(overlay.width.max(overlay.height));
        let width = self.line_width.unwrap_or_else(|| (LINE_WIDTH.0 * longer).max(LINE_WIDTH.1));
        if is_svg(&self.output) {
            if !self.link && (bytes.starts_with(b"II*\0") || bytes.starts_with(b"MM\0*")) {
                let reason = "a TIFF in an SVG is shown by no browser: give a PNG or JPEG, or write a picture";
                return Err(in_file(&self.photo, reason));
            }
            let link = self.link_address();
            let source =
                if self.link { Photograph::Linked(&link) } else { Photograph::Embedded(&bytes) };
            let svg = overlay.to_svg(source, width, !self.no_names);
            write_atomically(&self.output, |w| w.write_all(svg.as_bytes()))?;
        } else {
            write_picture(&self.output, &overlay.draw_on(&photograph, width)?)?;
        }
        let edges: usize = figures.iter().map(|f| f.edges.len()).sum();
        if overlay.line_count() == 0 {
            say(&format!(
                "warning: {}: none of the {edges} edges is in view of the camera",
                self.output.display()
            ));
        }
        say(&format!(
            "{}: {} lines drawn, of {edges} edges in {} figures",
            self.output.display(),
            overlay.line_count(),
            figures.len()
        ));
        Ok(())
    }

    fn figures(&self, files: &mut Files) -> Result<Vec<Figure>> {
        if let Some(path) = &self.scene {
            files.input("the scene", path)?;
            let scene = open_scene(path, files)?;
            if scene.polygons.is_empty() {
                return Err(in_file(path, "polygons: there are none, nothing to draw"));
            }
            Ok(scene_figures(&scene))
        } else if let Some(path) = &self.plane {
            files.input("the plane", path)?;
            let plane = PlaneFile::read(path)?;
            Ok(vec![plane_figure(&plane, self.grid).map_err(|e| in_file(path, e))?])
        } else if let Some(path) = &self.mesh {
            files.input("the mesh", path)?;
            mesh_figures(path)
        } else {
            Err(anyhow!("one of --scene, --plane and --mesh is needed"))
        }
    }

    /// The photograph as seen from the folder of the output.
    fn link_address(&self) -> String {
        let folder = |p: &Path| p.parent().map(Path::to_path_buf).unwrap_or_default();
        let (from, to) = (folder(&self.output), folder(&self.photo));
        let name = self.photo.file_name().map(PathBuf::from).unwrap_or_default();
        let absolute = || fs::canonicalize(&self.photo).unwrap_or_else(|_| self.photo.clone());
        let path = if from == to { name } else { absolute() };
        percent_encoded(&path.to_string_lossy())
    }
}

/// A path as an address: all but the characters that stand for themselves in a path (RFC 3986, 3.3).
fn percent_encoded(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' => out.push(char::from(byte)),
            b'-' | b'.' | b'_' | b'~' | b'/' => out.push(char::from(byte)),
            other => out.push_str(&format!("%{other:02X}")),
        }
    }
    out
}
