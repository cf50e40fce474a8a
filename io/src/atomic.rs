//! Output that is whole or not there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::{Error, ErrorKind};

/// Writes a file so that it is either the old one or the whole new one, never a part.
///
/// The bytes go to a temporary file in the same folder, which is flushed to the disk and then takes the target's name.
/// After any error, and after a panic of `write`, the target is as it was and the temporary is gone. A folder that is not
/// there is made, with those above it. A symbolic link is followed, and an existing file's permissions are kept.
///
/// ```
/// use collinear_io::write_atomically;
/// use std::io::Write;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("note.txt");
/// write_atomically(&path, |w| w.write_all(b"first"))?;
/// let failed = write_atomically(&path, |w| {
///     w.write_all(b"sec")?;
///     Err(std::io::Error::other("the power is gone"))
/// });
/// assert!(failed.unwrap_err().to_string().ends_with("note.txt: cannot be written: the power is gone"));
/// assert_eq!(std::fs::read(&path)?, b"first");
/// assert_eq!(std::fs::read_dir(folder.path())?.count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ErrorKind::Folder`], [`ErrorKind::IsAFolder`], [`ErrorKind::NotAFile`], [`ErrorKind::BrokenLink`] and
/// [`ErrorKind::ReadOnly`] before `write` is called; [`ErrorKind::Write`] with the operating system's reason, or with that
/// of `write`.
pub fn write_atomically<F>(path: &Path, write: F) -> Result<(), Error>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    replace(path, write).map_err(|error| error.in_file(path))
}

/// Writes several files so that all of them are new, or none.
///
/// Each is written whole beside its place, as by [`write_atomically`]; only then do they take their names, in this order. What is wrong with
/// a path, and a disk that is full, leaves all of them as they were.
///
/// ```
/// use collinear_io::write_together;
///
/// let folder = tempfile::tempdir()?;
/// let [first, second] = ["a.txt", "b.txt"].map(|name| folder.path().join(name));
/// std::fs::create_dir(&second)?;
/// let failed = write_together(&[(first.clone(), b"1".to_vec()), (second, b"2".to_vec())]);
/// assert!(failed.is_err() && !first.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`write_atomically`], of the first file that cannot be written; [`ErrorKind::Write`] for two of one path.
pub fn write_together(files: &[(PathBuf, Vec<u8>)]) -> Result<(), Error> {
    let mut ready: Vec<(&PathBuf, Prepared)> = Vec::new();
    let mut places = Vec::new();
    for (path, bytes) in files {
        let prepared = prepare(path, |w| w.write_all(bytes)).map_err(|e| e.in_file(path))?;
        let place = prepared.place();
        if places.contains(&place) {
            let twice = io::Error::new(io::ErrorKind::InvalidInput, "two outputs have this path");
            return Err(Error::from(ErrorKind::Write(twice)).in_file(path));
        }
        places.push(place);
        ready.push((path, prepared));
    }
    ready.into_iter().try_for_each(|(path, file)| file.put().map_err(|e| e.in_file(path)))
}

fn replace<F>(path: &Path, write: F) -> Result<(), Error>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    prepare(path, write)?.put()
}

/// A file that is whole and on the disk, but not yet in its place.
#[derive(Debug)]
struct Prepared {
    temporary: Temporary,
    target: PathBuf,
}

impl Prepared {
    /// The target by one name, however its folder is called.
    fn place(&self) -> PathBuf {
        let folder = self.target.parent().filter(|f| !f.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize();
        match (folder, self.target.file_name()) {
            (Ok(folder), Some(name)) => folder.join(name),
            _ => self.target.clone(),
        }
    }

    fn put(self) -> Result<(), Error> {
        self.temporary.rename_to(&self.target).map_err(ErrorKind::Write)?;
        sync_folder(&self.target);
        Ok(())
    }
}

fn prepare<F>(path: &Path, write: F) -> Result<Prepared, Error>
where
    F: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let (target, permissions) = settle(path)?;
    make_folder(&target)?;
    let (file, temporary) = create_beside(&target).map_err(ErrorKind::Write)?;
    let mut buffered = BufWriter::with_capacity(1 << 16, file);
    write(&mut buffered).map_err(ErrorKind::Write)?;
    let file = buffered.into_inner().map_err(|e| ErrorKind::Write(e.into_error()))?;
    if let Some(permissions) = permissions {
        file.set_permissions(permissions).map_err(ErrorKind::Write)?;
    }
    file.sync_all().map_err(ErrorKind::Write)?;
    Ok(Prepared { temporary, target })
}

/// The file behind any links, and its permissions if it exists.
fn settle(path: &Path) -> Result<(PathBuf, Option<fs::Permissions>), Error> {
    // A path drops the separator at its end, and the system would not.
    if path
        .as_os_str()
        .as_encoded_bytes()
        .last()
        .is_some_and(|b| std::path::is_separator(*b as char))
    {
        return Err(ErrorKind::IsAFolder.into());
    }
    let is_link = fs::symlink_metadata(path).is_ok_and(|m| m.file_type().is_symlink());
    // A link that leads nowhere fails here: what it should point to is not for this function to create.
    let target =
        if is_link { path.canonicalize().map_err(ErrorKind::BrokenLink)? } else { path.to_owned() };
    match fs::metadata(&target) {
        Ok(old) if old.is_dir() => Err(ErrorKind::IsAFolder.into()),
        Ok(old) if !old.is_file() => Err(ErrorKind::NotAFile.into()),
        Ok(old) if old.permissions().readonly() => Err(ErrorKind::ReadOnly.into()),
        Ok(old) => Ok((target, Some(old.permissions()))),
        // Below a file there is nothing either; making the folder says why.
        Err(e) if is_absence(e.kind()) && target.file_name().is_some() => Ok((target, None)),
        Err(e) => Err(ErrorKind::Write(e).into()),
    }
}

fn is_absence(kind: io::ErrorKind) -> bool {
    matches!(kind, io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

fn make_folder(target: &Path) -> Result<(), ErrorKind> {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => fs::create_dir_all(folder)
            .map_err(|source| ErrorKind::Folder { folder: folder.to_owned(), source }),
        _ => Ok(()),
    }
}

/// Removes its file unless that was renamed.
#[derive(Debug)]
struct Temporary(Option<PathBuf>);

impl Temporary {
    fn rename_to(mut self, target: &Path) -> io::Result<()> {
        if let Some(path) = &self.0 {
            fs::rename(path, target)?;
        }
        self.0 = None;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = self.0.take() {
            // Nothing more can be done about it, and the first error is the one to tell.
            drop(fs::remove_file(path));
        }
    }
}

fn create_beside(target: &Path) -> io::Result<(File, Temporary)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    // A name can only be taken by what another run left behind, so few attempts are needed.
    const ATTEMPTS: u32 = 100;
    let mut result = Err(io::Error::from(io::ErrorKind::AlreadyExists));
    for _ in 0..ATTEMPTS {
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = target.with_file_name(format!(".collinear-{}-{n}.part", process::id()));
        result = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&path)
            .map(|file| (file, Temporary(Some(path))));
        match &result {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            _ => break,
        }
    }
    result
}

/// Asks for the new name to reach the disk. Not every system can, and the file is whole either way.
fn sync_folder(target: &Path) {
    if cfg!(unix)
        && let Some(folder) = target.parent()
    {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        drop(File::open(folder).and_then(|f| f.sync_all()));
    }
}
