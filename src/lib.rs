//! Kiln turns folders of 3D assets into path-traced pictures.
//!
//! Data flows one way: `formats` reads bytes into a [`Scene`], [`prepare`] makes it a [`prepare::PreparedScene`],
//! [`integrate`] fills a [`film::Film`] pass by pass, [`accuracy`] says when that is enough, [`write`](mod@write) makes files of
//! it, and [`batch`] drives all this for a folder.

pub mod accuracy;
pub mod batch;
pub mod checks;
pub mod cpu_clock;
pub mod denoise;
pub mod effects;
pub mod film;
pub mod gallery;
pub mod geometry;
pub mod integrate;
pub mod lab;
pub mod lanes;
pub mod lighting;
pub mod math;
pub mod measure;
pub mod metrics;
pub mod plan;
pub mod prepare;
pub mod sampling;
pub mod settings;
pub mod shading;
pub mod write;

pub use kiln_formats as formats;
pub use kiln_formats::{Control, Scene, Stopped};
