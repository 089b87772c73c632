//! Clean-up that several importers share.

pub mod triangulate;
