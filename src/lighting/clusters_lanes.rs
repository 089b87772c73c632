//! [`Clusters`] for sixteen receivers at a time. The same estimates, sums and choices as for one.

use super::clusters::{BELOW_ONE, Clusters, EMITTER, LEAST_DISTANCE2};
use super::tree::ROOT;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};

/// Sixteen places where light is wanted, on the side of their normals.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverLanes<L: Lanes> {
    /// The points, in the rays' frame.
    pub point: V3<L::F>,
    /// Unit shading normals on the viewer's side.
    pub normal: V3<L::F>,
}

/// Emitters that were chosen.
pub(super) struct ChosenLanes<L: Lanes> {
    pub emitter: L::U,
    /// 0 where none can contribute.
    pub probability: L::F,
    pub again: L::F,
    /// Sum of the importance of the root's children, wherever asked for.
    pub total: L::F,
}

/// What a slot holds, for each lane its own or for all the same one.
struct Slot<F> {
    center: V3<F>,
    radius: F,
    axis: V3<F>,
    spread: F,
    fold: F,
    strength: F,
}

impl Clusters {
    #[inline(always)]
    fn splat<L: Lanes>(&self, l: L, slot: usize) -> Slot<L::F> {
        let at = |values: &[f32]| l.splat(values[slot]);
        Slot {
            center: V3::from_fn(|k| at(&self.center[k])),
            radius: at(&self.radius),
            axis: V3::from_fn(|k| at(&self.axis[k])),
            spread: at(&self.spread),
            fold: at(&self.fold),
            strength: at(&self.strength),
        }
    }

    #[inline(always)]
    fn gather<L: Lanes>(&self, l: L, slot: L::U) -> Slot<L::F> {
        let at = |values: &[f32]| l.gather(values, slot);
        Slot {
            center: V3::from_fn(|k| at(&self.center[k])),
            radius: at(&self.radius),
            axis: V3::from_fn(|k| at(&self.axis[k])),
            spread: at(&self.spread),
            fold: at(&self.fold),
            strength: at(&self.strength),
        }
    }

    /// Running sums over the root's children; those of `active` lanes count.
    #[inline(always)]
    fn root_sums<L: Lanes>(&self, l: L, receiver: &ReceiverLanes<L>, room: &mut [[f32; LANES]; ROOT]) -> L::F {
        let mut sum = l.splat(0.0);
        for (slot, to) in room.iter_mut().enumerate().take(self.first[1] as usize) {
            sum = sum + importance(l, &self.splat(l, slot), receiver);
            sum.store(to);
        }
        sum
    }

    /// Running sums over the children of each lane's node; zero beyond its last one. Gives them and the most children.
    #[inline(always)]
    fn node_sums<L: Lanes>(
        &self,
        l: L,
        first: L::U,
        count: L::U,
        receiver: &ReceiverLanes<L>,
        room: &mut [[f32; LANES]; ROOT],
    ) -> (L::F, usize) {
        let mut sum = l.splat(0.0);
        let most = count.array().into_iter().max().unwrap_or(0) as usize;
        for (k, to) in room.iter_mut().enumerate().take(most) {
            let k = l.word(k as u32);
            sum = sum + importance(l, &self.gather(l, first + k), receiver).only(k.lt(count));
            sum.store(to);
        }
        (sum, most)
    }

    /// As [`Clusters::sample`].
    #[inline(always)]
    pub fn sample_lanes<L: Lanes>(
        &self,
        l: L,
        receiver: &ReceiverLanes<L>,
        active: L::M,
        mut u: L::F,
    ) -> ChosenLanes<L> {
        let zero = l.splat(0.0);
        let mut chosen = ChosenLanes { emitter: l.word(0), probability: zero, again: u, total: zero };
        if self.is_empty() {
            return chosen;
        }
        let mut room = [[0.0; LANES]; ROOT];
        let mut probability = l.splat(1.0);
        let (mut first, mut many) = (l.word(0), self.first[1] as usize);
        let mut total = self.root_sums(l, receiver, &mut room);
        chosen.total = total;
        let mut searching = active;
        loop {
            searching = searching & total.gt(zero);
            let x = u * (total * BELOW_ONE);
            let sums = room[..many].as_flattened();
            // Lanes without light would read beyond their sums; what they find is not used.
            let k = place(l, sums, many, x).min(l.word(many as u32 - 1));
            let at = |k: L::U| l.gather(sums, k.shl::<4>() + l.lane_numbers());
            let before = L::F::select(k.eq(l.word(0)), zero, at(k - L::U::select(k.eq(l.word(0)), k, l.word(1))));
            let own = at(k) - before;
            u = L::F::select(searching, ((x - before) / own).min(l.splat(BELOW_ONE)), u);
            probability = probability * (own / total);
            let link = l.gather_words(&self.link, first + k);
            let found = searching & !link.lt(l.word(EMITTER));
            chosen.emitter = L::U::select(found, link & !EMITTER, chosen.emitter);
            chosen.probability = L::F::select(found, probability, chosen.probability);
            chosen.again = L::F::select(found, u, chosen.again);
            searching = searching & !found;
            if searching.none() {
                return chosen;
            }
            first = l.gather_words(&self.first, link);
            let count = L::U::select(searching, l.gather_words(&self.first, link + 1) - first, l.word(0));
            (total, many) = self.node_sums(l, first, count, receiver, &mut room);
        }
    }

    /// As [`Clusters::probability`]. `total` is what the choice gave for the receiver; where it is 0 it is computed.
    #[inline(always)]
    pub fn probability_lanes<L: Lanes>(
        &self,
        l: L,
        receiver: &ReceiverLanes<L>,
        active: L::M,
        emitter: L::U,
        total: L::F,
    ) -> L::F {
        let zero = l.splat(0.0);
        let mut room = [[0.0; LANES]; ROOT];
        let mut slot = l.gather_words(&self.slot_of_emitter, emitter);
        let mut probability = l.splat(1.0);
        let mut result = zero;
        let mut climbing = active;
        // Below the root a node's sums are few; the root's are known but for the slot's own share.
        loop {
            let node = l.gather_words(&self.node_of, slot);
            let at_root = climbing & node.eq(l.word(0));
            if at_root.any() {
                let known = total.gt(zero);
                let total = if (at_root & !known).any() {
                    L::F::select(known, total, self.root_sums(l, receiver, &mut room))
                } else {
                    total
                };
                let own = importance(l, &self.gather(l, slot), receiver);
                let p = probability * (own / total);
                result = L::F::select(at_root & own.gt(zero), p, result);
                climbing = climbing & !at_root;
            }
            if climbing.none() {
                return result;
            }
            let first = l.gather_words(&self.first, node);
            let count = L::U::select(climbing, l.gather_words(&self.first, node + 1) - first, l.word(0));
            let (sum, _) = self.node_sums(l, first, count, receiver, &mut room);
            let own = importance(l, &self.gather(l, slot), receiver);
            climbing = climbing & own.gt(zero);
            probability = probability * (own / sum);
            slot = L::U::select(climbing, l.gather_words(&self.slot_of, node), slot);
        }
    }
}

/// For each lane how many of its running sums are at most `x`: sum `k` of lane `i` is at 16·k + i.
#[inline(always)]
fn place<L: Lanes>(l: L, sums: &[f32], many: usize, x: L::F) -> L::U {
    let mut below = l.word(0);
    let mut step = many.next_power_of_two() as u32;
    // The number of sums at most x, by its bits from the highest on.
    while step > 0 {
        let tried = below + step;
        // The last sum of those tried; beyond the end nothing is at most x.
        let last = l.gather(sums, (tried - l.word(1)).shl::<4>() + l.lane_numbers());
        let taken = last.le(x) & tried.lt(l.word(many as u32 + 1));
        below = L::U::select(taken, tried, below);
        step /= 2;
    }
    below
}

#[inline(always)]
fn importance<L: Lanes>(l: L, slot: &Slot<L::F>, receiver: &ReceiverLanes<L>) -> L::F {
    let zero = l.splat(0.0);
    let to = slot.center - receiver.point;
    let distance2 = to.length_squared().max(slot.radius * slot.radius).max(l.splat(LEAST_DISTANCE2));
    let estimate = (l.word(0x5f37_59df) - distance2.to_bits().shr::<1>()).from_bits();
    let inverse = estimate * (l.splat(1.5) - distance2 * 0.5 * estimate * estimate);
    let here = receiver.normal.dot(to);
    let there = -slot.axis.dot(to);
    let there = there.max(there * slot.fold);
    let here = (here + slot.radius).max(zero) * inverse;
    let there = (there + slot.spread * (distance2 * inverse) + slot.radius).max(zero) * inverse;
    slot.strength * here * there * (inverse * inverse)
}
