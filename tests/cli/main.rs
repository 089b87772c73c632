//! The real binary on small folders.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod batch;
mod compare;
mod config;
#[cfg(unix)]
mod denoise;
mod determinism;
mod gallery;
#[cfg(unix)]
mod hostile;
mod inspect;
mod interrupt;
mod isolation;
mod layers;
mod looks;
mod plan;
mod quality;
mod render;
mod resume;
mod shards;
mod study;
mod support;
mod views;
