//! The walk through wide nodes, for any kernel.

use super::super::block::Block;
use super::super::leaves::Leaf;
use super::super::slab::SlabRay;
use super::WideTree;
use super::kernel::Kernel;
use super::node::Child;
use super::prefetch;
use super::stack::Stack;
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};

/// What a walk knows of its ray.
struct Walk<K> {
    kernel: K,
    sheared: ShearedRay,
    slab: SlabRay,
    nearest: Nearest,
    /// The nearest hit so far as a scaled distance.
    limit: f32,
}

/// The nearest accepted hit, or with `ANY` whichever accepted hit is found first.
///
/// Children are visited in the order in which the ray passes their cells. The cells are disjoint: when the next child on
/// the stack begins beyond the nearest hit, so do all others. (With a margin for rounding; and not for rays that are
/// parallel to an axis, which may run within a plane between two cells, both at the same time.)
#[inline(always)]
pub fn nearest<const ANY: bool, K: Kernel>(
    kernel: K,
    tree: WideTree,
    ray: &Ray,
    mut accept: impl FnMut(&Hit) -> bool,
) -> Option<Hit> {
    let slab = SlabRay::new(ray);
    let mut walk =
        Walk { kernel, sheared: ShearedRay::new(ray), slab, nearest: Nearest::new(ray), limit: slab.scaled(ray.t_max) };
    let prepared = kernel.prepare(&slab);
    let octant = slab.octant;
    let mut stack = Stack::new();
    let (stop_factor, stop_add) = slab.stop(tree.thickness);
    let mut node = tree.nodes.first()?;
    loop {
        // The children's words come last in the node and are needed last: have them fetched meanwhile.
        prefetch::line(&node.children);
        let top = stack.top();
        let entered = kernel.enter(&prepared, node, walk.limit, &mut top.enters);
        let mut next = None;
        if entered != 0 {
            let place = entered.trailing_zeros() as usize;
            next = Some(node.children[node.slot(octant, place)]);
            let rest = entered & (entered - 1);
            if rest != 0 {
                top.rest = rest;
                let second = node.children[node.slot(octant, rest.trailing_zeros() as usize & 15)];
                tree.prefetch(node, second);
                stack.push(node);
            }
        }
        let mut owner = node;
        // Test leaves until there is a node to enter.
        loop {
            if let Some(word) = next {
                let leaf = match Child::decode(word) {
                    Child::Node(at) => {
                        node = &tree.nodes[at as usize];
                        break;
                    }
                    Child::Leaf(leaf) => Leaf { first: owner.leaf_base + leaf.first, ..leaf },
                    Child::Large(offset) => tree.leaves.large(owner.leaf_base + offset),
                };
                for block in tree.leaves.blocks(leaf) {
                    if walk.test_block(block, &mut accept) && ANY {
                        return walk.nearest.hit;
                    }
                }
            }
            let Some((top, from)) = stack.last() else { return walk.nearest.hit };
            let place = top.rest.trailing_zeros() as usize;
            let enter = top.enters.0[place & 15];
            top.rest &= top.rest - 1;
            let emptied = top.rest == 0;
            owner = from;
            if emptied {
                stack.pop();
            }
            if enter > walk.limit {
                if enter > walk.limit * stop_factor + stop_add {
                    return walk.nearest.hit;
                }
                next = None;
                continue;
            }
            next = Some(owner.children[owner.slot(octant, place)]);
        }
    }
}

impl<K: Kernel> Walk<K> {
    /// Tests a block; whether a hit was accepted.
    #[inline(always)]
    fn test_block(&mut self, block: Block, accept: &mut impl FnMut(&Hit) -> bool) -> bool {
        let mut candidates = self.kernel.candidates(&self.sheared, &block);
        let mut found = false;
        while candidates != 0 {
            let i = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            if let Some(hit) = self.sheared.meet(block.corners(i), block.triangle(i))
                && self.nearest.improves(&hit)
                && accept(&hit)
            {
                self.nearest.take(hit);
                self.limit = self.slab.scaled(hit.t);
                found = true;
            }
        }
        found
    }
}
