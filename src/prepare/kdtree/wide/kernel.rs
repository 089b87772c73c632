//! What a tier of vector instructions has to bring.

use super::super::block::Block;
use super::super::slab::SlabRay;
use super::node::{WIDTH, WideNode};
use crate::math::triangle::ShearedRay;

/// Distances at which the children of a node are entered, in the ray's order.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Enters(pub [f32; WIDTH]);

/// The two inner loops. Each result is a set of lanes, the first in the lowest bit.
pub trait Kernel: Copy {
    /// A ray as the box test wants it.
    type Ray: Copy;

    /// Prepares a ray.
    fn prepare(self, slab: &SlabRay) -> Self::Ray;

    /// Which children of a node the ray enters up to `limit`, and where: in the order in which the ray passes them.
    fn enter(self, ray: &Self::Ray, node: &WideNode, limit: f32, enters: &mut Enters) -> u32;

    /// Which of a leaf block's triangles the ray's line may meet: at least all that it does. The block's words reach 64
    /// words beyond its end.
    fn candidates(self, ray: &ShearedRay, block: &Block) -> u32;
}
