//! Surfaces in the rays' frame, and what their materials and textures say at a point.

mod attributes;
mod coverage;
mod cutouts;
pub mod emission;
mod known;
mod marks;
mod parts;
mod pyramid;
mod records;
mod shapes;
mod shrink;
pub mod textures;
mod textures_lanes;
mod triangles;
mod world;

pub use attributes::{Attributes, Texturing};
pub use coverage::coverage;
pub use cutouts::bleed;
pub use parts::Part;
pub use pyramid::Pyramids;
pub use records::Record;
pub use shapes::{Shape, Sharing};
pub use textures_lanes::TexturesLanes;
pub use triangles::Geometry;
pub use world::{WorldFrame, world_bounds};
