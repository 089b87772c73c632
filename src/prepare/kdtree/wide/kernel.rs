//! What a tier of vector instructions has to bring.

use super::super::block::Block;
use super::super::slab::SlabRay;
use super::node::WideNode;
use super::stack::Stack;
use crate::math::triangle::ShearedRay;

/// The two inner loops.
pub trait Kernel: Copy {
    /// A ray as the box test wants it.
    type Ray: Copy;

    /// Prepares a ray.
    fn prepare(self, slab: &SlabRay) -> Self::Ray;

    /// Puts those children of a node on the stack that the ray enters up to `limit`: the first that it passes on top.
    fn open(self, ray: &Self::Ray, node: &WideNode, limit: f32, stack: &mut Stack);

    /// Which of a leaf block's triangles but the `barred` ones the ray may meet, the first in the lowest bit: at least all that
    /// it does. The block's words reach 64 words beyond its end.
    fn candidates(self, ray: &ShearedRay, block: &Block, barred: [u32; 2]) -> u32;
}
