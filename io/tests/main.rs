//! The tests of the files, in one binary.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod atomic;
mod bal;
mod berlin;
mod blender;
mod cameras;
mod control;
mod convert;
mod documents;
mod film;
mod foreign;
mod formats_page;
mod gltf;
mod gtx;
mod hostile;
mod jaicov;
mod metashape;
mod nerf;
mod opensfm;
mod opensfm_types;
mod orders;
mod orientation;
mod pictures;
mod pix4d;
mod points;
mod rpc;
mod scanners;
mod scene;

use std::path::PathBuf;

/// The shared test data, which is not part of the repository: `COLLINEAR_DATA`, or `../shared/data` beside it.
fn shared_data(what: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let folder =
        std::env::var_os("COLLINEAR_DATA").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    let path = folder.join(what);
    if path.exists() {
        return Some(path);
    }
    #[allow(clippy::print_stderr, reason = "a test that tests nothing must say so")]
    {
        eprintln!("skipped: {} is not there (COLLINEAR_DATA names its folder)", path.display());
    }
    None
}
