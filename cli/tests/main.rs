//! The program, run on small data whose results are known by hand.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test panics to fail")]

mod adjust;
mod berlin;
mod convert;
mod failures;
mod files;
mod given;
mod overlay;
mod project;
mod readme;
mod rectify;
mod render;
mod reproject;
mod resect;
mod support;
mod town;
mod warp;
