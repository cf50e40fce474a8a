//! The texturer against counted pixels and brute force.
