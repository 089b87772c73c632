//! Many rays in flight through a tree of instances: the rounds of `wide::stream`, in which each ray may be in a tree of its own.

use super::super::batch::RayBatch;
use super::super::wide::WideTree;
use super::super::wide::kernel::{Job, Kernel};
use super::super::wide::node::Child;
use super::super::wide::stack::{Stack, Waiting};
use super::super::wide::stream::{FLIGHTS, LAST, LEAF, NODE, Steps, keep_stacks, kind, take_stacks};
use super::super::wide::traverse::Walk;
use super::Instances;
use super::place::Placing;
use super::walk::{Outside, enter};
use crate::math::Hit;

/// Stands where there is no ray.
const NO_RAY: usize = usize::MAX;

/// Tells `found` for each ray of a batch the nearest hit that `stops` accepts, or with `ANY` whichever such hit is found first.
pub struct Stream<'a, const ANY: bool, Stops, Found> {
    /// What is traversed; not empty.
    pub all: &'a Instances,
    /// The rays.
    pub rays: &'a RayBatch<'a>,
    /// Which hits count.
    pub stops: Stops,
    /// Is told what each ray found.
    pub found: Found,
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Flight<'a, K: Kernel> {
    walk: Walk<K>,
    outside: Outside,
    /// Its number in the batch.
    ray: usize,
    /// The instance that it is in.
    instance: usize,
    /// The instance's tree.
    tree: WideTree<'a>,
    next: Waiting,
}

impl<K: Kernel> Flight<'_, K> {
    /// Takes the next step from the stack and has fetched what it needs; the step's kind.
    #[inline(always)]
    fn advance(&mut self, inner: &mut Stack) -> usize {
        self.next = inner.pop();
        self.tree.prefetch(self.next);
        kind(&self.next, self.walk.is_beyond(&self.next))
    }
}

impl<const ANY: bool, Stops, Found> Job for Stream<'_, ANY, Stops, Found>
where
    Stops: FnMut(usize, &Hit) -> bool,
    Found: FnMut(usize, Option<Hit>),
{
    type Output = ();

    #[inline(always)]
    fn run<K: Kernel>(mut self, kernel: K) {
        let mut stacks = take_stacks(2 * FLIGHTS);
        let (outer, inner) = stacks.split_at_mut(FLIGHTS);
        self.fly(kernel, outer, inner);
        keep_stacks(stacks);
    }
}

impl<'a, const ANY: bool, Stops, Found> Stream<'a, ANY, Stops, Found>
where
    Stops: FnMut(usize, &Hit) -> bool,
    Found: FnMut(usize, Option<Hit>),
{
    #[inline(always)]
    fn fly<K: Kernel>(&mut self, kernel: K, outer: &mut [Stack], inner: &mut [Stack]) {
        let (n, all) = (self.rays.len(), self.all);
        let idle = Flight {
            walk: Walk::idle(kernel),
            outside: Outside::default(),
            ray: NO_RAY,
            instance: 0,
            tree: all.trees[0].wide(),
            next: inner[0].top(),
        };
        let mut flights = [idle; FLIGHTS];
        let mut placing = Placing::new();
        let mut now = Steps::default();
        // Flights begin as if they had just ended: without a ray, and nothing on the stacks.
        (0..FLIGHTS.min(n)).for_each(|i| now.add(LAST, i as u8));
        let mut waiting = 0;
        while now.len != [0; 3] {
            let mut later = Steps::default();
            for &i in now.of(NODE) {
                let (flight, inner) = (&mut flights[i as usize], &mut inner[i as usize]);
                flight.walk.open(&flight.tree.nodes[flight.next.word as usize], inner);
                later.add(flight.advance(inner), i);
            }
            for &i in now.of(LEAF) {
                let (flight, inner) = (&mut flights[i as usize], &mut inner[i as usize]);
                let member = &all.members[flight.instance];
                placing.set(member.placement(), member.first);
                if let Child::Leaf(leaf) = flight.tree.child(&flight.next) {
                    for block in flight.tree.leaves.blocks(leaf) {
                        let ray = flight.ray;
                        let hit = flight.walk.test_block(block, &mut placing, &mut |hit| (self.stops)(ray, hit));
                        inner.clear_if(ANY & hit);
                        outer[i as usize].clear_if(ANY & hit);
                        if ANY && hit {
                            break;
                        }
                    }
                }
                later.add(flight.advance(inner), i);
            }
            for &i in now.of(LAST) {
                let (flight, outer, inner) = (&mut flights[i as usize], &mut outer[i as usize], &mut inner[i as usize]);
                if flight.walk.is_last(flight.tree, &flight.next) {
                    inner.clear_if(true);
                    if !self.depart(kernel, flight, outer, &mut waiting) {
                        continue;
                    }
                    if let Some(root) = flight.tree.nodes.first() {
                        flight.walk.open(root, inner);
                    }
                }
                later.add(flight.advance(inner), i);
            }
            now = later;
        }
    }

    /// Takes a flight that has left an instance to the next one: of its ray, or of one that waits. False where there is none.
    #[inline(always)]
    fn depart<K: Kernel>(
        &mut self,
        kernel: K,
        flight: &mut Flight<'a, K>,
        outer: &mut Stack,
        waiting: &mut usize,
    ) -> bool {
        loop {
            if flight.ray != NO_RAY {
                if let Some(instance) = flight.outside.next(kernel, self.all, flight.walk.end(), outer) {
                    flight.instance = instance;
                    flight.tree = enter(&mut flight.walk, self.all, instance, &self.rays.ray(flight.ray));
                    return true;
                }
                (self.found)(flight.ray, flight.walk.hit());
                flight.ray = NO_RAY;
            }
            if *waiting == self.rays.len() {
                return false;
            }
            outer.clear_if(true);
            let ray = self.rays.ray(*waiting);
            flight.walk.begin_outside(&ray, self.rays.barred(*waiting));
            flight.outside.begin(kernel, self.all, &ray, outer);
            flight.ray = *waiting;
            *waiting += 1;
        }
    }
}
