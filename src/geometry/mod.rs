//! Surfaces in the rays' frame, and what their materials and textures say at a point.

mod coverage;
pub mod emission;
mod pyramid;
pub mod textures;
mod triangles;
mod world;

pub use coverage::coverage;
pub use pyramid::Pyramids;
pub use triangles::{Attributes, Geometry, Part};
pub use world::{WorldFrame, world_bounds};
