//! The kd-tree against brute force, on meshes that are kind and on meshes that are not.

mod against_brute_force;
mod builders;
mod leaks;
mod meshes;
