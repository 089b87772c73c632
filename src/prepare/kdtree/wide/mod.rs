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
pub mod grouping;
pub mod kernel;
pub mod node;
pub mod packet;
pub mod packet_exact;
pub mod packet_kept;
mod packet_lanes;
mod packet_lines;
#[cfg(test)]
mod packet_lines_tests;
pub mod packet_table;
pub mod scalar;
pub mod stack;
pub mod stream;
mod supply;
pub mod traverse;
#[cfg(test)]
mod twin_tests;
pub mod validate;

use super::batch::RayBatch;
use super::leaves::LeafStore;
use crate::lanes::{AnyLanes, prefetch};
use crate::math::simd::SimdTier;
use crate::math::{Hit, Ray};
use kernel::Job;
use node::{Child, MAX_OFFSET, WideNode};
use stack::Waiting;

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
    /// What a waiting entry stands for.
    #[inline(always)]
    pub fn child(&self, waiting: &Waiting) -> Child {
        self.child_of(waiting.word, waiting.leaf_base)
    }

    /// What a word of a node stands for whose leaves' places count from `leaf_base`.
    #[inline(always)]
    pub fn child_of(&self, word: u32, leaf_base: u32) -> Child {
        Child::decode(word, leaf_base, |first| self.leaves.large(first))
    }

    /// Has something fetched that will probably be visited: a node, or a leaf but for its last lines. Without a branch, since
    /// nobody could foretell it.
    #[inline(always)]
    pub fn prefetch(&self, waiting: Waiting) {
        let node = self.nodes.as_ptr().addr().wrapping_add(waiting.word as usize * size_of::<WideNode>());
        let leaf = self.leaves.address(waiting.leaf_base.wrapping_add(waiting.word & MAX_OFFSET));
        prefetch::lines::<6>(if node::is_leaf(waiting.word) { leaf } else { node });
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

    /// Does a job with the kernel's instructions.
    #[inline]
    pub fn run<J: Job>(self, job: J) -> J::Output {
        match self {
            Self::Scalar(kernel) => job.run(kernel),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(kernel) => kernel.run(job),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(kernel) => kernel.run(job),
        }
    }

    /// [`AnyKernel::nearest`] for each ray of a batch: see [`stream::trace`]. The lanes are those of the same tier.
    pub fn trace<const ANY: bool>(
        self,
        lanes: AnyLanes,
        tree: WideTree,
        rays: &RayBatch,
        stops: impl FnMut(usize, &Hit) -> bool,
        found: impl FnMut(usize, Option<Hit>),
    ) {
        match self {
            Self::Scalar(kernel) => stream::trace::<ANY, _>(kernel, lanes, tree, rays, stops, found),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(kernel) => kernel.trace::<ANY>(lanes, tree, rays, stops, found),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(kernel) => kernel.trace::<ANY>(lanes, tree, rays, stops, found),
        }
    }
}
