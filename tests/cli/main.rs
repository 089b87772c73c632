//! The real binary on small folders.

mod batch;
mod determinism;
mod inspect;
mod interrupt;
mod render;
mod support;
mod views;
