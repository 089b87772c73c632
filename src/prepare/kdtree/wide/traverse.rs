//! The walk of one ray through wide nodes, for any kernel.

use super::super::batch::NO_TRIANGLE;
use super::super::block::Block;
use super::super::instances::place::{AsIs, Place};
use super::super::slab::SlabRay;
use super::WideTree;
use super::kernel::{BoxRay, Kernel};
use super::node::{Child, WideNode};
use super::stack::{Stack, Waiting};
use super::supply::ReadyRay;
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};
use std::mem::MaybeUninit;

/// What a walk knows of its ray.
#[derive(Clone, Copy)]
pub struct Walk<K: Kernel> {
    kernel: K,
    sheared: ShearedRay,
    slab: SlabRay,
    boxes: BoxRay,
    /// Triangles that the ray may not meet.
    barred: u32,
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
    let mut walk = Walk::new(kernel, ray);
    // Not in a closure: whether that is inlined where the instructions are, nobody knows.
    let mut place = MaybeUninit::uninit();
    walk.go::<ANY>(tree, Stack::begin(&mut place), &mut AsIs, &mut { accept });
    walk.hit()
}

impl<K: Kernel> Walk<K> {
    /// Walks a tree from its root on, until the nearest hit is known; or with `ANY` until any is, and says whether one is.
    #[inline(always)]
    pub fn go<const ANY: bool>(
        &mut self,
        tree: WideTree,
        stack: &mut Stack,
        place: &mut impl Place,
        accept: &mut impl FnMut(&Hit) -> bool,
    ) -> bool {
        if tree.nodes.is_empty() {
            return false;
        }
        let mut child = Child::Node(0);
        loop {
            match child {
                Child::Node(at) => {
                    let node = &tree.nodes[at as usize];
                    let first = if ANY {
                        self.kernel.open_any(&self.boxes, node, self.limit, stack)
                    } else {
                        self.kernel.open_first(&self.boxes, node, self.limit, stack)
                    };
                    if let Some(word) = first {
                        child = tree.child_of(word, node.leaf_base);
                        continue;
                    }
                }
                Child::Leaf(leaf) => {
                    for block in tree.leaves.blocks(leaf) {
                        if self.test_block(block, place, accept) && ANY {
                            return true;
                        }
                    }
                }
            }
            let next = loop {
                let next = stack.pop();
                if !self.is_beyond(&next) {
                    break next;
                }
                if ANY || self.is_last(tree, &next) {
                    return false;
                }
            };
            tree.prefetch(stack.top());
            child = tree.child(&next);
        }
    }

    /// Before the first node, with a ray.
    #[inline(always)]
    pub fn new(kernel: K, ray: &Ray) -> Self {
        let slab = SlabRay::new(ray);
        Self {
            kernel,
            sheared: ShearedRay::new(ray),
            boxes: BoxRay::new(&slab),
            barred: NO_TRIANGLE,
            nearest: Nearest::new(ray),
            limit: slab.scaled(ray.t_max),
            slab,
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
            barred: NO_TRIANGLE,
            nearest,
            limit: 0.0,
        }
    }

    /// Before the first node, with a ray.
    #[inline(always)]
    pub fn begin(&mut self, ray: &Ray, barred: u32) {
        self.slab.set(ray);
        self.boxes.set(&self.slab);
        self.begin_outside(ray, barred);
        self.limit = self.slab.scaled(ray.t_max);
    }

    /// [`Walk::begin`] with what is known of the ray already.
    #[inline(always)]
    pub fn begin_ready(&mut self, ready: &ReadyRay, ray: &Ray, barred: u32) {
        if !ready.plain {
            return self.begin(ray, barred);
        }
        self.slab.set_plain(ray.origin, ready.inv, ready.octant);
        self.boxes.set(&self.slab);
        self.sheared = ShearedRay::with(ray, ready.along, ready.shear);
        self.barred = barred;
        self.nearest = Nearest::new(ray);
        self.limit = self.slab.scaled(ray.t_max);
    }

    /// With a ray, but not yet in a tree.
    #[inline(always)]
    pub fn begin_outside(&mut self, ray: &Ray, barred: u32) {
        self.sheared = ShearedRay::new(ray);
        self.barred = barred;
        self.nearest = Nearest::new(ray);
    }

    /// The ray in the coordinates of the tree that is to be walked: to be set before [`Walk::begin_inside`].
    #[inline(always)]
    pub fn slab(&mut self) -> &mut SlabRay {
        &mut self.slab
    }

    /// Before the first node of the next tree of several.
    #[inline(always)]
    pub fn begin_inside(&mut self) {
        self.boxes.set(&self.slab);
        self.limit = self.slab.scaled(self.nearest.t);
    }

    /// Where the ray ends, or its nearest hit lies so far.
    #[inline(always)]
    pub fn end(&self) -> f32 {
        self.nearest.t
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
    pub fn test_block<P: Place>(&mut self, block: Block, place: &mut P, accept: &mut impl FnMut(&Hit) -> bool) -> bool {
        let real = if P::PADS { (1u32 << block.len) - 1 } else { u32::MAX };
        let block = place.place(self.kernel, block);
        let mut candidates = self.kernel.candidates(&self.sheared, &block, self.barred, self.nearest.t) & real;
        let mut found = false;
        while candidates != 0 {
            let i = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            if let Some(hit) = self.sheared.meet_along(block.corners_along(i, self.sheared.axes), block.triangle(i))
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
