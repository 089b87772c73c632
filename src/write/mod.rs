//! From pictures to files: exposure, tone mapping, PNG and EXR, and files that are whole or absent.

pub mod atomic;
pub mod display;
pub mod exr;
mod metadata;
pub mod png;
pub mod srgb;
pub mod tonemap;

pub use metadata::{Metadata, StatedError};
