//! The kd-tree against brute force, on meshes that are kind and on meshes that are not.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod against_brute_force;
mod batches;
mod builders;
mod hostile;
mod instances;
mod leaks;
mod meshes;
