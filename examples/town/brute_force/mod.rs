//! A town of planar polygons, its photographs and new views of it, by brute force.
//!
//! It shares no code with the library: its pictures are what the library's are compared with. Colours are display
//! values throughout, so that resampling a picture and shading a surface commute.

#![allow(dead_code, reason = "the example and the tests each use a part")]

pub(crate) mod backdrop;
pub(crate) mod build;
pub(crate) mod camera;
pub(crate) mod caster;
pub(crate) mod church;
pub(crate) mod facade;
pub(crate) mod ground;
pub(crate) mod house;
pub(crate) mod houses;
pub(crate) mod ink;
pub(crate) mod light;
pub(crate) mod paint;
pub(crate) mod photographs;
pub(crate) mod picture;
pub(crate) mod polygon;
pub(crate) mod rows;
pub(crate) mod scene;
pub(crate) mod scene_file;
pub(crate) mod tiles;
pub(crate) mod vector;
