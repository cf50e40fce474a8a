//! Which files a run reads and writes, so that none is lost.

use std::path::{Component, Path, PathBuf};

use super::UsageError;

/// The files of a run. An output that is an input too, or another output, is refused when the second of them is named: it
/// would replace what the user still needs.
#[derive(Debug, Default)]
pub(crate) struct Files {
    inputs: Vec<Named>,
    outputs: Vec<Named>,
}

/// A file and its part in the run.
#[derive(Debug)]
struct Named {
    role: String,
    path: PathBuf,
    settled: PathBuf,
    inode: Option<[u64; 2]>,
}

impl Files {
    /// Adds a file that will be read. Two inputs may be one file.
    pub(crate) fn input(&mut self, role: impl Into<String>, path: &Path) -> Result<(), UsageError> {
        let file = Named::new(role.into(), path);
        file.differs_from(&self.outputs)?;
        self.inputs.push(file);
        Ok(())
    }

    /// Adds a file or a folder whose files will be read; the outputs have been named before.
    pub(crate) fn input_folder(
        &mut self,
        role: impl Into<String>,
        path: &Path,
    ) -> Result<(), UsageError> {
        let file = Named::new(role.into(), path);
        self.outputs.iter().try_for_each(|output| output.spares(&file))?;
        self.input(file.role, path)
    }

    /// Adds a file that will be written.
    pub(crate) fn output(
        &mut self,
        role: impl Into<String>,
        path: &Path,
    ) -> Result<(), UsageError> {
        let file = Named::new(role.into(), path);
        file.differs_from(&self.outputs)?;
        file.differs_from(&self.inputs)?;
        self.outputs.push(file);
        Ok(())
    }
}

impl Named {
    fn new(role: String, path: &Path) -> Self {
        Self { role, path: path.to_owned(), settled: settled(path), inode: inode(path) }
    }

    fn differs_from(&self, others: &[Self]) -> Result<(), UsageError> {
        match others.iter().find(|o| self.is(o)) {
            None => Ok(()),
            Some(other) if other.path == self.path => Err(UsageError(format!(
                "{} is both {} and {}: name another output",
                self.path.display(),
                other.role,
                self.role
            ))),
            Some(other) => Err(UsageError(format!(
                "{}, {}, and {}, {}, are the same file: name another output",
                other.path.display(),
                other.role,
                self.path.display(),
                self.role
            ))),
        }
    }

    /// Refuses an output that would replace a file in an input's folder, as one of COLMAP's three.
    fn spares(&self, input: &Self) -> Result<(), UsageError> {
        let within = self.settled != input.settled && self.settled.starts_with(&input.settled);
        if !(within && self.settled.is_file()) {
            return Ok(());
        }
        Err(UsageError(format!(
            "{}, {}, is a file of {}, {}: name another output",
            self.path.display(),
            self.role,
            input.path.display(),
            input.role
        )))
    }

    fn is(&self, other: &Self) -> bool {
        self.settled == other.settled || (self.inode.is_some() && self.inode == other.inode)
    }
}

/// The one path of a file: absolute, without links, `.` and `..`. Of a file that is not there yet, the folders that are.
fn settled(path: &Path) -> PathBuf {
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for folder in path.ancestors().skip(1) {
        if let (Ok(mut known), Ok(rest)) = (folder.canonicalize(), path.strip_prefix(folder)) {
            for part in rest.components() {
                match part {
                    Component::ParentDir => drop(known.pop()),
                    Component::Normal(name) => known.push(name),
                    _ => {}
                }
            }
            return known;
        }
    }
    path
}

/// What hard links to one file share.
#[cfg(unix)]
fn inode(path: &Path) -> Option<[u64; 2]> {
    use std::os::unix::fs::MetadataExt;

    std::fs::metadata(path).ok().map(|m| [m.dev(), m.ino()])
}

#[cfg(not(unix))]
fn inode(_: &Path) -> Option<[u64; 2]> {
    None
}
