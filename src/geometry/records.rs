//! All that shading asks of a triangle in one line of the cache, for scenes where that is little memory.

use glam::Vec3;

/// Scenes with more triangles have none: 64 MiB.
pub(super) const MOST: usize = 1 << 20;

/// A triangle.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Its corners in the rays' frame.
    pub corners: [Vec3; 3],
    /// Unit normal on its front.
    pub normal: Vec3,
    /// Index of its placement.
    pub part: u32,
    /// Its vertices in the mesh.
    pub vertices: [u32; 3],
}

const _: () = assert!(size_of::<Record>() == 64);
