//! All integration tests of the library: one binary, a file for each subject.

mod camera;
mod contracts;
mod geodetic;
mod homography;
mod orthophoto;
mod plane_map;
mod polynomial;
mod projection;
mod rotation;
mod span;
mod support;
mod texture_matrices;
mod texturer;
