//! Many rays in flight: while one waits for memory, others go on.
//!
//! Each round takes every ray in flight one step further: first those that enter a node, then those that come to a leaf, then
//! those that are done. Which kind a ray's next step is of decides on a list, not on a branch, and what it needs is fetched a
//! round ahead.

use super::super::batch::RayBatch;
use super::super::instances::place::AsIs;
use super::WideTree;
use super::kernel::Kernel;
use super::node::{Child, is_leaf};
use super::stack::{Stack, Waiting};
use super::supply::Supply;
use super::traverse::Walk;
use crate::lanes::AnyLanes;
use crate::math::Hit;
use std::cell::Cell;

/// Rays in flight.
pub const FLIGHTS: usize = 16;

/// Stands where there is no ray.
const NO_RAY: usize = usize::MAX;

thread_local! {
    /// Stacks that nobody uses: they are too large to be made for each batch.
    static SPARE_STACKS: Cell<Vec<Stack>> = const { Cell::new(Vec::new()) };
}

/// So many stacks, all empty.
pub fn take_stacks(count: usize) -> Vec<Stack> {
    let mut stacks = SPARE_STACKS.take();
    if stacks.len() < count {
        stacks = Stack::several(count);
    }
    // Where a batch ended, rays left behind what lay beyond their hits.
    stacks[..count].iter_mut().for_each(|stack| stack.clear_if(true));
    stacks
}

/// Keeps stacks for the next batch.
pub fn keep_stacks(stacks: Vec<Stack>) {
    SPARE_STACKS.set(stacks);
}

/// Kinds of steps: into a node, into a leaf, and to the end of what there is.
pub const NODE: usize = 0;
/// See [`NODE`].
pub const LEAF: usize = 1;
/// See [`NODE`].
pub const LAST: usize = 2;

/// The kind of the step to what is next, which may lie beyond the nearest hit.
#[inline(always)]
pub fn kind(next: &Waiting, beyond: bool) -> usize {
    (usize::from(beyond) * LAST) | (usize::from(is_leaf(next.word) & !beyond) * LEAF)
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Flight<K: Kernel> {
    walk: Walk<K>,
    /// Its number in the batch.
    ray: usize,
    next: Waiting,
}

/// The steps of a round, as numbers of flights.
#[derive(Clone, Copy, Default)]
pub struct Steps {
    flights: [[u8; FLIGHTS]; 3],
    /// How many of each kind there are.
    pub len: [usize; 3],
}

impl Steps {
    /// Adds the step of a flight.
    #[inline(always)]
    pub fn add(&mut self, kind: usize, flight: u8) {
        self.flights[kind][self.len[kind] % FLIGHTS] = flight;
        self.len[kind] += 1;
    }

    /// The flights whose steps are of a kind.
    #[inline(always)]
    pub fn of(&self, kind: usize) -> &[u8] {
        &self.flights[kind][..self.len[kind]]
    }
}

/// Tells `found` for each ray of a batch the nearest hit that `stops` accepts, or with `ANY` whichever such hit is found first.
#[inline(always)]
pub fn trace<const ANY: bool, K: Kernel>(
    kernel: K,
    lanes: AnyLanes,
    tree: WideTree,
    rays: &RayBatch,
    mut stops: impl FnMut(usize, &Hit) -> bool,
    mut found: impl FnMut(usize, Option<Hit>),
) {
    let n = rays.len();
    let Some(root) = tree.nodes.first() else { return (0..n).for_each(|ray| found(ray, None)) };
    let mut stacks = take_stacks(FLIGHTS);
    let idle = Flight { walk: Walk::idle(kernel), ray: NO_RAY, next: stacks[0].top() };
    let mut flights = [idle; FLIGHTS];
    let mut now = Steps::default();
    // Flights begin as if they had just ended: without a ray, and nothing on the stack.
    (0..FLIGHTS.min(n)).for_each(|i| now.add(LAST, i as u8));
    let mut supply = Supply::new(lanes, root, rays);
    while now.len != [0; 3] {
        let mut later = Steps::default();
        for &i in now.of(NODE) {
            let (flight, stack) = (&mut flights[i as usize], &mut stacks[i as usize]);
            flight.walk.open(&tree.nodes[flight.next.word as usize], stack);
            later.add(flight.advance(tree, stack), i);
        }
        for &i in now.of(LEAF) {
            let (flight, stack) = (&mut flights[i as usize], &mut stacks[i as usize]);
            if let Child::Leaf(leaf) = tree.child(&flight.next) {
                for block in tree.leaves.blocks(leaf) {
                    let hit = flight.walk.test_block(block, &mut AsIs, &mut |hit| stops(flight.ray, hit));
                    stack.clear_if(ANY & hit);
                    if ANY && hit {
                        break;
                    }
                }
            }
            later.add(flight.advance(tree, stack), i);
        }
        for &i in now.of(LAST) {
            let (flight, stack) = (&mut flights[i as usize], &mut stacks[i as usize]);
            if flight.walk.is_last(tree, &flight.next) {
                if flight.ray != NO_RAY {
                    found(flight.ray, flight.walk.hit());
                }
                let Some(ready) = supply.next(&mut found) else { continue };
                stack.clear_if(true);
                flight.ray = ready.ray;
                flight.walk.begin_ready(&ready, &rays.ray(ready.ray), rays.barred(ready.ray));
                flight.walk.open(root, stack);
            }
            later.add(flight.advance(tree, stack), i);
        }
        now = later;
    }
    keep_stacks(stacks);
}

impl<K: Kernel> Flight<K> {
    /// Takes the next step from the stack and has fetched what it needs; the step's kind.
    #[inline(always)]
    fn advance(&mut self, tree: WideTree, stack: &mut Stack) -> usize {
        self.next = stack.pop();
        tree.prefetch(self.next);
        kind(&self.next, self.walk.is_beyond(&self.next))
    }
}
