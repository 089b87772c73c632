//! Scenes whose light is known: a check is a TOML file beside a small scene, with the value to expect and why.
//!
//! `scenes/checks/README.md` describes the format. [`load`] reads a folder of checks, [`run()`] renders and judges them.

mod file;
mod judge;
mod run;

pub use file::{CameraSpec, Check, EnvironmentSpec, Expectation, KnownFailure, Level, Relation, RenderSpec, load};
pub use judge::{SIGNIFICANCE, Verdict};
pub use run::{Row, run};
