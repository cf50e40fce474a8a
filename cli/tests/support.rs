//! A folder of small files, and the program run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use collinear_io::picture::{Picture, read_picture, write_picture};
use tempfile::TempDir;

/// A temporary folder.
pub(crate) struct Folder(TempDir);

/// What a run of the program said.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), content).unwrap();
        self
    }

    pub(crate) fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// A colour picture of a function of the pixel.
    pub(crate) fn draw(
        &self,
        name: &str,
        [w, h]: [u32; 2],
        f: impl Fn(u32, u32) -> [u8; 3],
    ) -> &Self {
        let data = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).flat_map(|(x, y)| f(x, y));
        let picture =
            Picture { width: w, height: h, channels: 3, data: data.collect(), orientation: 1 };
        write_picture(&self.path(name), &picture).unwrap();
        self
    }

    pub(crate) fn picture(&self, name: &str) -> Picture {
        read_picture(&self.path(name)).unwrap()
    }

    /// Runs the program in this folder.
    pub(crate) fn run(&self, arguments: &[&str]) -> Run {
        self.run_at_width(arguments, 100)
    }

    /// Runs the program for a terminal of so many columns and expects it to succeed.
    pub(crate) fn succeed_at_width(&self, arguments: &[&str], columns: usize) -> Run {
        let run = self.run_at_width(arguments, columns);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
        run
    }

    fn run_at_width(&self, arguments: &[&str], columns: usize) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_collinear"))
            .args(arguments)
            .env("COLUMNS", columns.to_string())
            .current_dir(self.0.path())
            .output()
            .unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Run {
            code: output.status.code().unwrap(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Runs the program and expects it to succeed.
    pub(crate) fn succeed(&self, arguments: &[&str]) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, 0, "{arguments:?}: {}", run.stderr);
        run
    }

    /// The names of the files in it, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
        let mut names: Vec<_> =
            fs::read_dir(self.0.path()).unwrap().map(|e| name(&e.unwrap().path())).collect();
        names.sort();
        names
    }
}

/// The samples of a pixel.
pub(crate) fn pixel(picture: &Picture, x: u32, y: u32) -> &[u8] {
    let channels = usize::from(picture.channels);
    let at = (y * picture.width + x) as usize * channels;
    &picture.data[at..at + channels]
}

/// A different colour for each pixel of a small picture.
pub(crate) fn label(x: u32, y: u32) -> [u8; 3] {
    [(5 * x) as u8, (6 * y) as u8, (37 * x + 91 * y) as u8]
}

/// A camera 10 above the origin that looks straight down, north up, f = 100 pixels: a pixel is 0.1 on the ground, and the
/// picture of width × height shows ±width/20 × ±height/20.
pub(crate) fn vertical(width: u32, height: u32, lens: &str) -> String {
    let model = if lens.is_empty() { "pinhole" } else { "brown" };
    format!(
        r#""width": {width}, "height": {height},
        "interior": {{ "model": "{model}", "principal_distance": [100, 100],
            "principal_point": [{}, {}]{lens} }},
        "exterior": {{ "projection_center": [0, 0, 10], "rotation_matrix": [[1, 0, 0], [0, -1, 0], [0, 0, -1]] }}"#,
        f64::from(width) / 2.0,
        f64::from(height) / 2.0
    )
}

/// The camera of [`vertical`] with any interior orientation.
pub(crate) fn looking_down([width, height]: [u32; 2], interior: &str) -> String {
    format!(
        r#""width": {width}, "height": {height}, "interior": {{ {interior} }},
        "exterior": {{ "projection_center": [0, 0, 10], "rotation_matrix": [[1, 0, 0], [0, -1, 0], [0, 0, -1]] }}"#
    )
}

/// A parallel view straight down, north up, 10 pixels a unit, the origin in its middle.
pub(crate) fn map_view(width: u32, height: u32) -> String {
    format!(
        r#""width": {width}, "height": {height},
        "interior": {{ "model": "orthographic", "pixels_per_unit": [10, 10], "principal_point": [{}, {}] }},
        "exterior": {{ "projection_center": [0, 0, 100], "rotation_matrix": [[1, 0, 0], [0, -1, 0], [0, 0, -1]] }}"#,
        f64::from(width) / 2.0,
        f64::from(height) / 2.0
    )
}

/// A file of a kind.
pub(crate) fn document(kind: &str, fields: &str) -> String {
    format!(r#"{{ "collinear": "{kind}", "version": 1, {fields} }}"#)
}

/// The ground, z = 0, with a rectangle or without.
pub(crate) fn ground(rectangle: &str) -> String {
    document("plane", &format!(r#""point": [0, 0, 0], "normal": [0, 0, 1]{rectangle}"#))
}
