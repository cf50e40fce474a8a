//! What the programs of the comparisons share.

pub mod synthetic;
