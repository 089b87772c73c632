//! Clean-up that several importers share.

pub mod shapes;
pub mod tangents;
pub mod triangulate;
