//! All integration tests of the library: one binary, a file for each subject.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    unreachable_pub,
    reason = "a test fails by panicking and says what it skips; helpers are shared within one binary"
)]

mod camera;
mod contracts;
mod geodetic;
mod homography;
mod layers;
mod plane_map;
mod polynomial;
mod projection;
mod rotation;
mod sources;
mod span;
mod support;
mod texture_matrices;
mod texturer;
