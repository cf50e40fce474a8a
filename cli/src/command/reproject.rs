//! `collinear reproject`.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::{ArgGroup, Args};
use collinear_cli::lookup::{Drawn, Lookup};
use collinear_cli::reproject::{Scene, photograph_from_screen, read_mesh};
use collinear_io::Document;
use collinear_io::dome::DomeFile;
use collinear_io::picture::{read_picture, write_picture};
use collinear_io::plane::PlaneFile;
use collinear_io::sensor::SensorFile;

use super::{BorderChoice, Files, FilterChoice, in_file, picture_path, say, with_bar};

/// Turn a picture into the one that another camera, projector or scanner would have
#[derive(Debug, Args)]
#[command(
    long_about = LONG,
    after_help = AFTER,
    group(ArgGroup::new("scene").required(true).args(["plane", "dome", "mesh", "far"]))
)]
pub(crate) struct Arguments {
    /// The picture: PNG, JPEG or TIFF
    photo: PathBuf,

    /// The picture's camera or scanner (JSON)
    #[arg(short, long, value_name = "CAMERA.json")]
    camera: PathBuf,

    /// The camera, scanner or projector (JSON) of the new picture
    #[arg(short, long, value_name = "SCREEN.json")]
    screen: PathBuf,

    /// Both look at this plane (JSON)
    #[arg(short, long, value_name = "PLANE.json")]
    plane: Option<PathBuf>,

    /// Both look at this dome (JSON), from inside or outside
    #[arg(long, value_name = "DOME.json")]
    dome: Option<PathBuf>,

    /// Both look at the faces of this mesh (Wavefront OBJ)
    #[arg(long, value_name = "MESH.obj")]
    mesh: Option<PathBuf>,

    /// Both stand at one place, or all is so far away that their places do not matter
    #[arg(long)]
    far: bool,

    /// The picture to write: .png, .jpg, .jpeg, .tif or .tiff
    #[arg(short, long, value_name = "OUT", value_parser = picture_path)]
    output: PathBuf,

    /// A colour between pixels of the picture: that of the pixel it lies in, or of the four around it
    #[arg(long, value_enum, default_value_t)]
    filter: FilterChoice,

    /// What lies beyond the picture: `transparent`, `constant:R,G,B`, `clamp`, `repeat` or `mirror`.
    /// Without it black in a JPEG and transparent elsewhere
    #[arg(long, value_name = "BORDER", value_parser = BorderChoice::parse)]
    border: Option<BorderChoice>,
}

const LONG: &str = "\
Turn a picture into the one that another camera, projector or scanner would have.

Each pixel of the new picture looks at the plane, the dome or the mesh along its own line of sight, and \
what it meets there is looked up in the picture through its camera. What the dome or the mesh itself \
hides from that camera is left out. With --far directions count alone: a panorama becomes a dome master, \
a cylinder or a view.

For a projector that shines on a dome, SCREEN is the projector as a camera, and CAMERA that of the \
picture for the audience, at the eye point: the new picture is pre-warped, so that from there it looks \
right.";

const AFTER: &str = "\
Examples:
  collinear reproject pano.jpg --camera pano.json --screen master.json --far -o master.png
  collinear reproject master.png --camera master.json --screen projector.json --dome dome.json -o beam.png

Exit codes: 0 done; 1 failed (an old OUT is left as it was); 2 wrong usage, as an output that is an \
input too.";

impl Arguments {
    pub(crate) fn run(&self) -> Result<()> {
        let mut files = Files::default();
        files.output("the output (-o)", &self.output)?;
        files.input("the picture", &self.photo)?;
        files.input("the camera", &self.camera)?;
        files.input("the screen", &self.screen)?;
        let scene = self.scene(&mut files)?;
        let border = BorderChoice::of(self.border, &self.output)?;
        let camera = SensorFile::read(&self.camera)?;
        let screen = SensorFile::read(&self.screen)?;
        let map = photograph_from_screen(&screen, &scene, &camera)
            .map_err(|e| in_file(&self.screen, e))?;
        let [width, height] = screen.size();
        let lookup = Lookup { width, height, map: map.as_ref() };
        let photograph = read_picture(&self.photo)?;
        camera
            .check_picture_size(photograph.width, photograph.height)
            .map_err(|e| in_file(&self.photo, e))?;
        let drawn = with_bar("reprojecting", |progress| {
            lookup.draw(&photograph, self.filter.into(), border, progress)
        });
        drop(photograph);
        let Drawn { picture, seen } = drawn.map_err(|e| in_file(&self.photo, e))?;
        write_picture(&self.output, &picture)?;
        let all = u64::from(picture.width) * u64::from(picture.height);
        let part =
            if seen < all { format!(", {seen} of {all} in the picture") } else { String::new() };
        say(&format!("{}: {width} × {height} pixels{part}", self.output.display()));
        Ok(())
    }

    fn scene(&self, files: &mut Files) -> Result<Scene> {
        if let Some(path) = &self.plane {
            files.input("the plane", path)?;
            let plane = PlaneFile::read(path)?.plane().map_err(|e| e.in_file(path))?;
            return Ok(Scene::Plane(plane));
        }
        if let Some(path) = &self.dome {
            files.input("the dome", path)?;
            return Ok(Scene::Dome(DomeFile::read(path)?.dome().map_err(|e| e.in_file(path))?));
        }
        if let Some(path) = &self.mesh {
            files.input("the mesh", path)?;
            let (mesh, none) = read_mesh(path)?;
            if none > 0 {
                let name = path.display();
                say(&format!("warning: {name}: {none} faces have no area and are left out"));
            }
            return Ok(mesh);
        }
        if self.far {
            Ok(Scene::FarAway)
        } else {
            Err(anyhow!("a plane, a dome or a mesh is needed"))
        }
    }
}
