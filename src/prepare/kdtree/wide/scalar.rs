//! The kernel in plain code.

use super::super::block::Block;
use super::super::slab::GROWTH;
use super::kernel::{BoxRay, Kernel};
use super::node::{WIDTH, WideNode};
use super::stack::Stack;
use crate::math::Placement;
use crate::math::triangle::ShearedRay;

/// Plain code, for any machine; what the other kernels are compared with.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;

impl Kernel for Scalar {
    #[inline]
    fn open(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) {
        let (mut enter, mut leave) = ([0.0f32; WIDTH], [f32::INFINITY; WIDTH]);
        for axis in 0..3 {
            let (lo, hi) = (&node.planes[axis], &node.planes[axis + 3]);
            let (first, last) = if ray.upper[axis] > 0 { (hi, lo) } else { (lo, hi) };
            for i in 0..WIDTH {
                let a = (first[i] - ray.enter_from[axis]) * ray.inv[axis];
                let b = (last[i] - ray.leave_from[axis]) * ray.inv[axis];
                enter[i] = if a > enter[i] { a } else { enter[i] };
                leave[i] = if b < leave[i] { b } else { leave[i] };
            }
        }
        let order = node.orders[ray.order as usize / 2];
        for i in 0..WIDTH {
            let place = if ray.backwards == 1 { WIDTH - 1 - i } else { i };
            let slot = (order >> (4 * place)) as usize & 15;
            let left = leave[slot] * GROWTH;
            if enter[slot] <= left && enter[slot] <= limit {
                stack.push(enter[slot], node.children[slot], node.leaf_base);
            }
        }
    }

    #[inline]
    fn candidates(self, ray: &ShearedRay, block: &Block, barred: u32, end: f32) -> u32 {
        let meets = |i: usize| {
            let corners = block.corners_along(i, ray.axes);
            block.triangle(i) != barred && ray.meet_along(corners, 0).is_some_and(|hit| 0.0 < hit.t && hit.t <= end)
        };
        (0..block.len).map(|i| u32::from(meets(i)) << i).sum()
    }

    #[inline]
    fn place(self, placement: &Placement, from: &[u32], stride: usize, to: &mut [u32; 3 * WIDTH]) {
        for i in 0..WIDTH {
            let at = |axis: usize| f32::from_bits(from[axis * stride + i]);
            let point = placement.point([at(0), at(1), at(2)]);
            for axis in 0..3 {
                to[axis * WIDTH + i] = point[axis].to_bits();
            }
        }
    }
}
