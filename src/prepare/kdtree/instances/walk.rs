//! The walk of one ray through a tree of instances, for any kernel.

use super::super::batch::NO_TRIANGLE;
use super::super::slab::SlabRay;
use super::super::wide::WideTree;
use super::super::wide::kernel::{BoxRay, Job, Kernel};
use super::super::wide::node::{instance_of, is_leaf};
use super::super::wide::stack::Stack;
use super::super::wide::traverse::Walk;
use super::Instances;
use super::place::Placing;
use crate::math::{Hit, Ray};
use std::mem::MaybeUninit;

/// A ray among the boxes of instances.
#[derive(Clone, Copy, Default)]
pub struct Outside {
    slab: SlabRay,
    boxes: BoxRay,
}

impl Outside {
    /// Puts what the ray meets first on an empty stack.
    #[inline(always)]
    pub fn begin<K: Kernel>(&mut self, kernel: K, all: &Instances, ray: &Ray, stack: &mut Stack) {
        self.slab.set(ray);
        self.boxes.set(&self.slab);
        kernel.open(&self.boxes, &all.top[0], self.slab.scaled(ray.t_max), stack);
    }

    /// The next instance whose box the ray enters before it ends.
    #[inline(always)]
    pub fn next<K: Kernel>(&self, kernel: K, all: &Instances, end: f32, stack: &mut Stack) -> Option<usize> {
        let limit = self.slab.scaled(end);
        loop {
            let next = stack.pop();
            if next.enter <= limit {
                if is_leaf(next.word) {
                    return Some(instance_of(next.word));
                }
                kernel.open(&self.boxes, &all.top[next.word as usize], limit, stack);
            } else if next.enter.is_nan() {
                return None;
            }
        }
    }
}

/// Sets out into the tree of an instance; gives the tree.
#[inline(always)]
pub fn enter<'a, K: Kernel>(walk: &mut Walk<K>, all: &'a Instances, instance: usize, ray: &Ray) -> WideTree<'a> {
    let member = &all.members[instance];
    let mut tree = all.trees[member.tree as usize].wide();
    match &member.space {
        Some(space) => tree.thickness += space.set(walk.slab(), ray),
        None => walk.slab().set(ray),
    }
    walk.begin_inside();
    tree
}

/// The nearest accepted hit of a ray, or with `ANY` whichever accepted hit is found first.
pub struct Single<'a, const ANY: bool, Accept> {
    /// What is traversed; not empty.
    pub all: &'a Instances,
    /// The ray.
    pub ray: &'a Ray,
    /// Which hits count.
    pub accept: Accept,
}

impl<const ANY: bool, Accept: FnMut(&Hit) -> bool> Job for Single<'_, ANY, Accept> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn run<K: Kernel>(mut self, kernel: K) -> Option<Hit> {
        let mut walk = Walk::idle(kernel);
        walk.begin_outside(self.ray, NO_TRIANGLE);
        let mut placing = Placing::new();
        let mut outside = Outside::default();
        // Without closures, which would not be compiled for the kernel's instructions.
        let (mut outer, mut inner) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let (outer, inner) = (Stack::begin(&mut outer), Stack::begin(&mut inner));
        outside.begin(kernel, self.all, self.ray, outer);
        while let Some(instance) = outside.next(kernel, self.all, walk.end(), outer) {
            let tree = enter(&mut walk, self.all, instance, self.ray);
            let member = &self.all.members[instance];
            placing.set(member.placement(), member.first);
            let found = walk.go::<ANY>(tree, inner, &mut placing, &mut self.accept);
            if ANY && found {
                break;
            }
            inner.clear_if(true);
        }
        walk.hit()
    }
}
