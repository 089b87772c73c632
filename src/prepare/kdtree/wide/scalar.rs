//! The kernel in plain code.

use super::super::block::Block;
use super::super::slab::SlabRay;
use super::kernel::Kernel;
use super::node::{WIDTH, WideNode};
use super::stack::Stack;
use crate::math::triangle::ShearedRay;

/// Plain code, for any machine; what the other kernels are compared with.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

impl Kernel for Scalar {
    type Ray = SlabRay;

    fn prepare(self, slab: &SlabRay) -> SlabRay {
        *slab
    }

    #[inline]
    fn open(self, slab: &Self::Ray, node: &WideNode, limit: f32, stack: &mut Stack) {
        let (mut enter, mut leave) = ([0.0f32; WIDTH], [limit; WIDTH]);
        for axis in 0..3 {
            let (lo, hi) = (&node.planes[axis], &node.planes[axis + 3]);
            let (first, last) = if slab.is_negative(axis) { (hi, lo) } else { (lo, hi) };
            for i in 0..WIDTH {
                let (a, b) = (slab.enter(axis, first[i]), slab.leave(axis, last[i]));
                enter[i] = if a > enter[i] { a } else { enter[i] };
                leave[i] = if b < leave[i] { b } else { leave[i] };
            }
        }
        for i in (0..WIDTH).rev() {
            let slot = node.slot(slab.octant, i);
            if enter[slot] <= leave[slot] {
                stack.push(enter[slot], node.children[slot], node.leaf_base);
            }
        }
    }

    #[inline]
    fn candidates(self, ray: &ShearedRay, block: &Block, barred: [u32; 2]) -> u32 {
        let meets = |i: usize| {
            !barred.contains(&block.triangle(i)) && ray.meet(block.corners(i), 0).is_some_and(|hit| 0.0 < hit.t)
        };
        (0..block.len).map(|i| u32::from(meets(i)) << i).sum()
    }
}
