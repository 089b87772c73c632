//! Clean-up that several importers share.

pub mod heights;
pub mod shapes;
pub mod tangents;
pub mod triangulate;
