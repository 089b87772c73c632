//! The compiled form of the kd-tree: nodes with up to 16 children, each with the box around what its cell holds.
//!
//! A wide node is a treelet of the binary tree whose inner planes have become an order: for each octant of directions,
//! the order in which a ray passes the children's cells. The cells are disjoint, so that the first hit beyond which the
//! next cell in order begins is the nearest one, and nothing needs sorting. [`collapse`] makes the nodes,
//! [`traverse`] walks them with a [`Kernel`](kernel::Kernel) of the machine's tier; all kernels find the hits of the binary tree.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod collapse;
mod kernel;
pub mod node;
mod prefetch;
mod scalar;
mod stack;
mod traverse;
#[cfg(test)]
mod twin_tests;
pub mod validate;

use super::leaves::{Leaf, LeafStore};
use crate::math::simd::SimdTier;
use crate::math::{Hit, Ray};
use node::{Child, WideNode};

/// What is to be traversed.
#[derive(Clone, Copy, Debug)]
pub struct WideTree<'a> {
    /// Nodes, the root first.
    pub nodes: &'a [WideNode],
    /// The leaves' triangles.
    pub leaves: &'a LeafStore,
    /// How far boxes reach beyond their cells, and so into each other, at most.
    pub thickness: f32,
}

impl WideTree<'_> {
    /// Has a child of a node fetched that will probably be visited.
    #[inline(always)]
    fn prefetch(&self, parent: &WideNode, child: u32) {
        match Child::decode(child) {
            Child::Node(at) => {
                if let Some(node) = self.nodes.get(at as usize) {
                    prefetch::lines::<7, _>(node);
                }
            }
            Child::Leaf(Leaf { first: offset, .. }) | Child::Large(offset) => {
                if let Some(words) = self.leaves.begin(parent.leaf_base + offset) {
                    prefetch::lines::<4, _>(words);
                }
            }
        }
    }
}

/// A kernel that the machine has.
#[derive(Clone, Copy, Debug)]
pub enum AnyKernel {
    /// Plain code.
    Scalar(scalar::Scalar),
    /// Eight lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    /// Sixteen lanes.
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl AnyKernel {
    /// The kernel of a tier, or the best that the machine has below it.
    pub fn new(tier: SimdTier) -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if tier == SimdTier::Avx512
                && let Some(kernel) = avx512::Avx512::new()
            {
                return Self::Avx512(kernel);
            }
            if tier >= SimdTier::Avx2
                && let Some(kernel) = avx2::Avx2::new()
            {
                return Self::Avx2(kernel);
            }
        }
        let _ = tier;
        Self::Scalar(scalar::Scalar)
    }

    /// The nearest accepted hit, or with `ANY` whichever accepted hit is found first.
    #[inline]
    pub fn nearest<const ANY: bool>(self, tree: WideTree, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        match self {
            Self::Scalar(kernel) => traverse::nearest::<ANY, _>(kernel, tree, ray, accept),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(kernel) => kernel.nearest::<ANY>(tree, ray, accept),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(kernel) => kernel.nearest::<ANY>(tree, ray, accept),
        }
    }
}
