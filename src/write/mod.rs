//! From pictures to files: exposure, tone mapping, PNG and EXR, and files that are whole or absent.

pub mod animation;
pub mod atomic;
mod cryptomatte;
pub mod display;
pub mod exr;
mod layers;
mod metadata;
pub mod png;
pub mod srgb;
pub mod tonemap;

pub use metadata::{Metadata, StatedError};
