//! Output that is whole or not there.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use collinear_io::{ErrorKind, write_atomically};

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn an_error_or_a_panic_half_way_leaves_the_old_file_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.svg");
    fs::write(&path, "old").unwrap();
    // More than any buffer, so that bytes have reached the disk when the writer gives up.
    let half = vec![b'x'; 1 << 20];
    let error = write_atomically(&path, |w| {
        w.write_all(&half)?;
        assert_eq!(names(folder.path()).len(), 2, "the bytes are beside the target");
        Err(io::Error::other("no more"))
    })
    .unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::Write(e) if e.to_string() == "no more"));
    let panicked = std::panic::catch_unwind(|| {
        write_atomically(&path, |w| {
            w.write_all(&half)?;
            panic!("in the writer")
        })
    });
    assert!(panicked.is_err());
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["out.svg"]);
}

#[test]
fn the_target_is_the_old_file_until_the_new_one_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.svg");
    fs::write(&path, "old").unwrap();
    write_atomically(&path, |w| {
        w.write_all(b"new")?;
        w.flush()?;
        assert_eq!(fs::read_to_string(&path)?, "old");
        Ok(())
    })
    .unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(folder.path()), ["out.svg"]);
}

#[test]
fn what_is_no_file_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let untouched = |_: &mut dyn Write| -> io::Result<()> { panic!("must not be called") };
    let error = write_atomically(folder.path(), untouched).unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::IsAFolder), "{error}");
    assert!(error.to_string().ends_with(": is a folder: name a file in it"), "{error}");
    assert!(write_atomically(Path::new(""), untouched).is_err());
    let written_as_one = write_atomically(&folder.path().join("new/"), untouched).unwrap_err();
    assert!(matches!(written_as_one.kind(), ErrorKind::IsAFolder), "{written_as_one}");
    assert!(write_atomically(Path::new(".."), untouched).is_err());
    if cfg!(unix) {
        let device = write_atomically(Path::new("/dev/null"), untouched).unwrap_err();
        assert!(matches!(device.kind(), ErrorKind::NotAFile), "{device}");
    }
    assert!(names(folder.path()).is_empty());
}

#[test]
fn a_folder_that_is_not_there_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/b/../c/out.svg");
    write_atomically(&path, |w| w.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(folder.path().join("a/c/out.svg")).unwrap(), "new");
    // A file is no folder, and says so before any work is done.
    let file = folder.path().join("a/c/out.svg");
    for below in ["out.svg", "d/out.svg"] {
        let error = write_atomically(&file.join(below), |_| panic!("called")).unwrap_err();
        let ErrorKind::Folder { folder: made, .. } = error.kind() else { panic!("{error}") };
        assert!(made.starts_with(&file), "{error}");
        assert!(error.to_string().contains(": its folder "), "{error}");
        assert!(error.to_string().contains(" cannot be made: "), "{error}");
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "new");
}

#[test]
fn a_name_without_a_folder_is_in_the_working_folder() {
    let path = Path::new("collinear-io-test-output.txt");
    write_atomically(path, |w| w.write_all(b"here")).unwrap();
    assert_eq!(fs::read_to_string(path).unwrap(), "here");
    fs::remove_file(path).unwrap();
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};

    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real.txt"), folder.path().join("link.txt"));
    fs::write(&real, "old").unwrap();
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.txt", &link).unwrap();
    write_atomically(&link, |w| w.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&real).unwrap(), "new");
    assert!(fs::symlink_metadata(&link).unwrap().file_type().is_symlink());
    assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);

    fs::set_permissions(&real, fs::Permissions::from_mode(0o440)).unwrap();
    let error = write_atomically(&real, |w| w.write_all(b"newer")).unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::ReadOnly), "{error}");
    assert_eq!(fs::read_to_string(&real).unwrap(), "new");

    let dangling = folder.path().join("dangling.txt");
    symlink("nowhere.txt", &dangling).unwrap();
    let error = write_atomically(&dangling, |w| w.write_all(b"new")).unwrap_err();
    assert!(matches!(error.kind(), ErrorKind::BrokenLink(_)), "{error}");
    assert_eq!(names(folder.path()), ["dangling.txt", "link.txt", "real.txt"]);
}
