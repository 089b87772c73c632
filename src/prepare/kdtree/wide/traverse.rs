//! The walk of one ray through wide nodes, for any kernel.

use super::super::batch::NO_TRIANGLE;
use super::super::block::Block;
use super::super::slab::SlabRay;
use super::WideTree;
use super::kernel::{BoxRay, Kernel};
use super::node::{Child, WideNode};
use super::stack::{Stack, Waiting};
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};

/// What a walk knows of its ray.
#[derive(Clone, Copy)]
pub struct Walk<K: Kernel> {
    kernel: K,
    sheared: ShearedRay,
    slab: SlabRay,
    boxes: BoxRay,
    /// Triangles that the ray may not meet.
    barred: [u32; 2],
    nearest: Nearest,
    /// The nearest hit so far as a scaled distance.
    limit: f32,
}

/// The nearest accepted hit, or with `ANY` whichever accepted hit is found first.
#[inline(always)]
pub fn nearest<const ANY: bool, K: Kernel>(
    kernel: K,
    tree: WideTree,
    ray: &Ray,
    accept: impl FnMut(&Hit) -> bool,
) -> Option<Hit> {
    let mut walk = Walk::idle(kernel);
    walk.begin(ray, [NO_TRIANGLE; 2]);
    Stack::with(|stack| walk.go::<ANY>(tree, stack, accept))
}

impl<K: Kernel> Walk<K> {
    #[inline(always)]
    fn go<const ANY: bool>(
        &mut self,
        tree: WideTree,
        stack: &mut Stack,
        mut accept: impl FnMut(&Hit) -> bool,
    ) -> Option<Hit> {
        tree.nodes.first()?;
        let mut child = Child::Node(0);
        loop {
            match child {
                Child::Node(at) => self.kernel.open(&self.boxes, &tree.nodes[at as usize], self.limit, stack),
                Child::Leaf(leaf) => {
                    for block in tree.leaves.blocks(leaf) {
                        if self.test_block(block, &mut accept) && ANY {
                            return self.nearest.hit;
                        }
                    }
                }
            }
            let next = loop {
                let next = stack.pop();
                if !self.is_beyond(&next) {
                    break next;
                }
                if self.is_last(tree, &next) {
                    return self.nearest.hit;
                }
            };
            tree.prefetch(stack.top());
            child = tree.child(&next);
        }
    }

    /// Without a ray.
    #[inline(always)]
    pub fn idle(kernel: K) -> Self {
        let sheared =
            ShearedRay { origin: [0.0; 3], axes: [0, 1, 2], shear_x: 0.0, shear_y: 0.0, dir_z: 1.0, inv_dir_z: 1.0 };
        let nearest = Nearest { t: 0.0, hit: None };
        Self {
            kernel,
            sheared,
            slab: SlabRay::default(),
            boxes: BoxRay::default(),
            barred: [NO_TRIANGLE; 2],
            nearest,
            limit: 0.0,
        }
    }

    /// Before the first node, with a ray.
    #[inline(always)]
    pub fn begin(&mut self, ray: &Ray, barred: [u32; 2]) {
        self.slab.set(ray);
        self.boxes.set(&self.slab);
        self.sheared = ShearedRay::new(ray);
        self.barred = barred;
        self.nearest = Nearest::new(ray);
        self.limit = self.slab.scaled(ray.t_max);
    }

    /// Puts those children of a node on the stack that the ray enters.
    #[inline(always)]
    pub fn open(&self, node: &WideNode, stack: &mut Stack) {
        self.kernel.open(&self.boxes, node, self.limit, stack);
    }

    /// What was found.
    #[inline(always)]
    pub fn hit(&self) -> Option<Hit> {
        self.nearest.hit
    }

    /// Whether a child is entered beyond the nearest hit, or is none at all.
    #[inline(always)]
    pub fn is_beyond(&self, next: &Waiting) -> bool {
        !(next.enter <= self.limit)
    }

    /// Of a child beyond the nearest hit: whether all others are too. Children wait in the order in which the ray passes their
    /// cells, and the cells are disjoint. (With a margin for rounding; and not for rays that are parallel to an axis, which may
    /// run within a plane between two cells, both at the same time.)
    #[inline(always)]
    pub fn is_last(&self, tree: WideTree, next: &Waiting) -> bool {
        let (factor, add) = self.slab.stop(tree.thickness);
        !(next.enter <= self.limit * factor + add)
    }

    /// Tests a block; whether a hit was accepted.
    #[inline(always)]
    pub fn test_block(&mut self, block: Block, accept: &mut impl FnMut(&Hit) -> bool) -> bool {
        let mut candidates = self.kernel.candidates(&self.sheared, &block, self.barred);
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
