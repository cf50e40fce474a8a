//! All integration tests of the library: one binary, a file for each subject.

mod projection;
mod rotation;
mod texture_matrices;
