//! The layout of a wide node.

use super::super::bounds::Bounds;
use super::super::leaves::Leaf;
use super::kernel::BoxRay;

/// Children that a node may have.
pub const WIDTH: usize = 16;

/// Up to 16 children: their boxes axis by axis, what they are, and in which order rays pass them.
///
/// Slots without a child hold a box that no ray enters.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct WideNode {
    /// Lower ends of the boxes on the three axes, then upper ends.
    pub planes: [[f32; WIDTH]; 6],
    /// What is in each slot: see [`Child`].
    pub children: [u32; WIDTH],
    /// For directions with positive z and each sign of x (1: negative) and y (2: negative): the slots in the order in
    /// which rays pass them, four bits a slot, the first in the lowest. Directions with negative z of the opposite
    /// octant pass them in the opposite order.
    pub orders: [u64; 4],
    /// The grain of the leaf store from which the places of leaves in this node count.
    pub leaf_base: u32,
    /// Slots in use.
    pub count: u32,
    /// Fills the node up to 512 bytes.
    pub free: [u32; 6],
}

const LEAF: u32 = 1 << 31;
const LARGE: u32 = 1 << 30;
const COUNT_SHIFT: u32 = 26;
const POOL_SHIFT: u32 = 20;
/// Grains that a leaf of up to 16 references may lie behind its node's base; a node's leaves of that kind come first, and
/// take at most 16 times 20 grains.
pub const MAX_OFFSET: u32 = (1 << POOL_SHIFT) - 1;

/// What is in a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// Another node.
    Node(u32),
    /// A leaf.
    Leaf(Leaf),
}

impl Child {
    /// As a word in a node whose leaves' places count from `base`. A leaf of more than 16 references keeps its place
    /// alone: the grain before it holds their number.
    pub fn encode(self, base: u32) -> u32 {
        match self {
            Self::Node(at) => at,
            Self::Leaf(Leaf { first, count, pool }) if count as usize <= WIDTH => {
                LEAF | (count.wrapping_sub(1) & 15) << COUNT_SHIFT | pool << POOL_SHIFT | (first - base)
            }
            Self::Leaf(leaf) => LEAF | LARGE | (leaf.first - base),
        }
    }

    /// From a word; `large` finds a leaf of more than 16 references by its place.
    #[inline(always)]
    pub fn decode(word: u32, base: u32, large: impl FnOnce(u32) -> Leaf) -> Self {
        if word & LEAF == 0 {
            Self::Node(word)
        } else if word & LARGE == 0 {
            let count = ((word >> COUNT_SHIFT) & 15) + 1;
            Self::Leaf(Leaf { first: base + (word & MAX_OFFSET), count, pool: (word >> POOL_SHIFT) & 63 })
        } else {
            Self::Leaf(large(base + (word & (LARGE - 1))))
        }
    }
}

/// Whether a word stands for a leaf.
#[inline(always)]
pub fn is_leaf(word: u32) -> bool {
    word & LEAF != 0
}

/// The number of the instance that a leaf's word stands for, in a tree over instances.
#[inline(always)]
pub fn instance_of(word: u32) -> usize {
    (word & (LARGE - 1)) as usize
}

impl WideNode {
    /// A node without children.
    pub fn empty() -> Self {
        let mut planes = [[f32::INFINITY; WIDTH]; 6];
        planes[3..].fill([f32::NEG_INFINITY; WIDTH]);
        Self { planes, children: [0; WIDTH], orders: [0; 4], leaf_base: 0, count: 0, free: [0; 6] }
    }

    /// Sets the box of a slot.
    pub fn set_bounds(&mut self, slot: usize, bounds: &Bounds) {
        for axis in 0..3 {
            self.planes[axis][slot] = bounds.lo(axis);
            self.planes[axis + 3][slot] = bounds.hi(axis);
        }
    }

    /// The box of a slot.
    pub fn bounds(&self, slot: usize) -> Bounds {
        let at = |row: usize| self.planes[row][slot];
        Bounds::new([at(0), at(1), at(2)], [at(3), at(4), at(5)])
    }

    /// The word of the last child in a ray's order, farthest first, of those whose places in it are bits of `met`, which is not 0.
    #[inline(always)]
    pub fn last_of(&self, ray: &BoxRay, met: u32) -> u32 {
        let place = (u32::BITS - 1 - met.leading_zeros()) ^ (15 * (ray.backwards & 1));
        let slot = self.orders[(ray.order / 2) as usize & 3] >> (4 * (place & 15)) & 15;
        self.children[slot as usize]
    }

    /// The i-th slot that a ray of an octant passes (bits 0, 1, 2: negative x, y, z).
    pub fn slot(&self, octant: usize, i: usize) -> usize {
        let (order, place) = if octant < 4 { (octant, i) } else { (7 - octant, WIDTH - 1 - i) };
        (self.orders[order] >> (4 * place)) as usize & 15
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_fills_eight_cache_lines_and_words_round_trip() {
        assert_eq!(size_of::<WideNode>(), 512);
        let leaf = |first, count, pool| Child::Leaf(Leaf { first: 99 + first, count, pool });
        let children = [Child::Node(77), leaf(12345, 1, 0), leaf(MAX_OFFSET, 16, 32), leaf(0, 3, 5), leaf(5, 40, 0)];
        for child in children {
            let large = |first| Leaf { first, count: 40, pool: 0 };
            assert_eq!(Child::decode(child.encode(99), 99, large), child);
        }
    }
}
