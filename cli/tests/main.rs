//! The program, run on small data whose results are known by hand.

mod failures;
mod overlay;
mod project;
mod rectify;
mod render;
mod support;
mod town;
