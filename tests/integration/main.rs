//! All integration tests of the library: one binary, a file for each subject.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::inconsistent_digit_grouping,
    unreachable_pub,
    unused_qualifications,
    reason = "a test fails by panicking and says what it skips; helpers are shared within one binary; digits are as printed"
)]

mod absolute_orientation;
mod aerial;
mod affine;
mod area;
mod area_tables;
mod bundle;
mod bundle_blocks;
mod camera;
mod camera_edges;
mod central_models;
mod consensus;
mod contracts;
mod dlt;
mod extremes;
mod filters;
mod five_point;
mod geodetic;
mod homography;
mod intersection;
mod layers;
mod least_squares;
mod light;
mod lookup_table;
mod mesh;
mod orthophoto;
mod output_models;
mod p3p;
mod p4pf;
mod piecewise;
mod plane;
mod plane_map;
mod plane_map_edges;
mod polynomial;
mod pose;
mod projection;
mod rays;
mod registration;
mod relative_orientation;
mod resample;
mod resection;
mod resection_edges;
mod resection_laws;
mod resection_robust;
mod rotation;
mod rows;
mod rpc;
mod scanning;
mod scanning_edges;
mod shader;
mod sources;
mod span;
mod support;
mod texture_matrices;
mod texturer;
mod texturer_edges;
mod thin_plate;
mod town;
mod warp;
