//! Scenes that nobody would make: generated files rendered, paths against double precision, closed meshes of the wild.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

#[path = "../common/mod.rs"]
mod common;

mod closed_meshes;
mod double;
mod double_lobes;
mod furnaces;
mod generated;
mod twin;
