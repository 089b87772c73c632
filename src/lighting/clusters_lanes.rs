//! [`Clusters`] for sixteen receivers at a time. The same estimates, sums and choices as for one.

use super::clusters::{BELOW_ONE, Clusters, EMITTER, LEAST_DISTANCE2, PACKED};
use super::tree::ROOT;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};

/// Sixteen places where light is wanted, on the side of their normals.
#[derive(Clone, Copy, Debug)]
pub struct ReceiverLanes<L: Lanes> {
    /// The points, in the rays' frame.
    pub point: V3<L::F>,
    /// Unit shading normals on the viewer's side.
    pub normal: V3<L::F>,
    /// −1 where light counts from both sides of the surface, else 1.
    pub side: L::F,
}

/// Room for running sums.
#[derive(Debug)]
pub struct LightRoom([[f32; LANES]; ROOT]);

impl Default for LightRoom {
    fn default() -> Self {
        Self([[0.0; LANES]; ROOT])
    }
}

/// Emitters that were chosen.
pub(super) struct ChosenLanes<L: Lanes> {
    pub emitter: L::U,
    /// 0 where none can contribute.
    pub probability: L::F,
    pub again: L::F,
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
        let ([cx, cy, cz], [ax, ay, az]) = (&self.center, &self.axis);
        Slot {
            center: l.splat_vector([cx[slot], cy[slot], cz[slot]]),
            radius: l.splat(self.radius[slot]),
            axis: l.splat_vector([ax[slot], ay[slot], az[slot]]),
            spread: l.splat(self.spread[slot]),
            fold: l.splat(self.fold[slot]),
            strength: l.splat(self.strength[slot]),
        }
    }

    #[inline(always)]
    fn gather<L: Lanes>(&self, l: L, slot: L::U) -> Slot<L::F> {
        let at = slot * PACKED;
        let [x, y, z, radius] = l.gather_four(&self.packed, at);
        let [u, v, w, spread] = l.gather_four(&self.packed, at + 4);
        let [fold, strength, ..] = l.gather_four(&self.packed, at + 8);
        Slot { center: V3::new(x, y, z), radius, axis: V3::new(u, v, w), spread, fold, strength }
    }

    /// Running sums over the root's children; those of `active` lanes count.
    #[inline(always)]
    fn root_sums<L: Lanes>(&self, l: L, receiver: &ReceiverLanes<L>, room: &mut LightRoom) -> L::F {
        let mut sum = l.splat(0.0);
        for (slot, to) in room.0.iter_mut().enumerate().take(self.first[1] as usize) {
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
        room: &mut LightRoom,
    ) -> (L::F, usize) {
        let mut sum = l.splat(0.0);
        let most = count.array().into_iter().max().unwrap_or(0) as usize;
        for (k, to) in room.0.iter_mut().enumerate().take(most) {
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
        room: &mut LightRoom,
    ) -> ChosenLanes<L> {
        let zero = l.splat(0.0);
        let mut chosen = ChosenLanes { emitter: l.word(0), probability: zero, again: u };
        if self.is_empty() {
            return chosen;
        }
        let mut probability = l.splat(1.0);
        let (mut first, mut many) = (l.word(0), self.first[1] as usize);
        let mut total = self.root_sums(l, receiver, room);
        let mut searching = active;
        loop {
            searching = searching & total.gt(zero);
            let x = u * (total * BELOW_ONE);
            let sums = room.0[..many].as_flattened();
            // Lanes without light would read beyond their sums; what they find is not used.
            let k = place(l, sums, many, x).min(l.word(many as u32 - 1));
            let at_first = k.eq(l.word(0));
            let before = own_lane(l, sums, k - L::U::select(at_first, k, l.word(1)));
            let before = L::F::select(at_first, zero, before);
            let own = own_lane(l, sums, k) - before;
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
            (total, many) = self.node_sums(l, first, count, receiver, room);
        }
    }
}

/// Each lane's entry of rows of sixteen.
#[inline(always)]
fn own_lane<L: Lanes>(l: L, rows: &[f32], row: L::U) -> L::F {
    l.gather(rows, row.shl::<4>() + l.lane_numbers())
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
        let last = own_lane(l, sums, tried - 1);
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
    let here = here.max(here * receiver.side);
    let there = -slot.axis.dot(to);
    let there = there.max(there * slot.fold);
    let here = (here + slot.radius).max(zero) * inverse;
    let there = (there + slot.spread * (distance2 * inverse) + slot.radius).max(zero) * inverse;
    slot.strength * here * there * (inverse * inverse)
}
