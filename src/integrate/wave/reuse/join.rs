//! The rays between paths, and what comes of them.

use super::super::lanes::offset_point;
use super::super::{Start, Wave};
use super::first::First;
use super::{Joined, PAIRS, Shared, pair, second};
use crate::film::group_in_square;
use crate::integrate::bend::LEAST_COSINE;
use crate::integrate::trace::{Asker, stops};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Work};
use crate::prepare::kdtree::{Coherence, RayBatch};
use glam::Vec3;

/// Joins all paths to the first vertices of their groups.
pub(in super::super) struct Join<'a, 'b, 'c, 'd> {
    pub wave: &'a mut Wave<'b, 'd>,
    pub starts: &'c [Start],
}

impl Work for Join<'_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { wave, starts } = self;
        let Some(mut shared) = wave.memory.reuse.take() else { return };
        shared.part(&mut wave.memory.slots);
        let (mut begin, mut next) = (0, 0);
        for together in
            starts.chunk_by(|a, b| a.sample == b.sample && group_in_square(a.pixel) == group_in_square(b.pixel))
        {
            let end = begin + together.len();
            let first = First::load(l, &shared.first, begin, together.len());
            while next < shared.second.len && (shared.second.word(second::SLOT, next) as usize) < end {
                if shared.pairs.len + LANES > PAIRS {
                    wave.trace_pairs(&mut shared);
                }
                wave.join(l, &mut shared, next, begin, &first);
                next += 1;
            }
            begin = end;
        }
        wave.trace_pairs(&mut shared);
        wave.memory.reuse = Some(shared);
    }
}

impl Wave<'_, '_> {
    /// Lets rays from a group's first vertices, in the slots from `begin` on, to second vertex number `at` wait to be traced.
    #[inline(always)]
    fn join<L: Lanes>(&mut self, l: L, shared: &mut Shared, at: usize, begin: usize, first: &First<L>) {
        let (rows, light) = (&shared.second, shared.light[at]);
        let slot = rows.word(second::SLOT, at);
        if light == Vec3::ZERO {
            return;
        }
        if !light.is_finite() {
            self.memory.slots[slot as usize].radiance = light;
            return;
        }
        let vector = |row: usize| l.splat_vector(rows.vector(row, at).to_array());
        let (place, normal, shading) = (vector(second::PLACE), vector(second::NORMAL), vector(second::SHADING));
        let seen = first.see(l, place, self.course.settings.roulette_after <= 1);
        let (zero, lane) = (l.splat(0.0), slot as usize - begin);
        let cosine = -seen.dir.dot(normal);
        // On the side that the path sees, and from where the shading normal is the same.
        let least = l.splat(LEAST_COSINE).min(cosine);
        let same = cosine.gt(zero) & (-seen.dir.dot(shading)).ge(least);
        let geometry = cosine / seen.distance2;
        // The path's own direction is known better than from its ends.
        let own = l.mask(1 << lane);
        let own_pdf = l.splat(rows.float(second::PDF, at));
        let density = L::F::select(own, own_pdf, seen.pdf) * seen.survival * geometry;
        let value = V3::select(own, vector(second::THROUGHPUT) * density, seen.value * geometry);
        let brought = value.times(l.splat_vector(light.to_array()));
        let end = offset_point(place, vector(second::ERROR), normal, seen.out.origin - place);
        let dir = end - seen.out.origin;
        let sound = density.gt(zero) & density.is_finite() & brought.is_finite();
        let there = first.takes_part & same & seen.out.open & seen.value.is_not_zero() & dir.is_not_zero() & sound;
        let own_light = Vec3::from(brought.lane(lane));
        if (sound & own).none() {
            // So near that it cannot be said how near.
            let light = rows.vector(second::THROUGHPUT, at) * light;
            // After what the slot is given by paths before this one, whenever these are traced.
            shared.joined.push(Joined { slot, light, density: 1.0, end: shared.pairs.len });
            return;
        }
        let others = there & !own;
        let triangle = l.word(rows.word(second::TRIANGLE, at));
        let [o, d, b] = [seen.out.origin.components(), dir.components(), brought.components()];
        let floats = [o[0], o[1], o[2], d[0], d[1], d[2], b[0], b[1], b[2], density];
        const { assert!(pair::LIGHT == 6 && pair::DENSITY == 9) };
        let slots = l.lane_numbers() + begin as u32;
        shared.pairs.store::<L>(shared.pairs.len, others, floats, [slots, triangle]);
        shared.pairs.len += others.count();
        let density = density.array()[lane];
        shared.joined.push(Joined { slot, light: own_light, density, end: shared.pairs.len });
    }

    /// Who asks for the rays of the path in a slot from its first vertex on.
    fn asker(&self, slot: usize) -> Asker {
        Asker { sampler: self.memory.states[slot].sampler, vertex: 1, draw: 0, eye: false }
    }

    /// Traces the rays that wait, and gives the pixels what is theirs of each path's light.
    #[inline(never)]
    fn trace_pairs(&mut self, shared: &mut Shared) {
        let prepared = self.course.prepared;
        let Shared { pairs, blocked, joined, ones, .. } = shared;
        let rays = RayBatch {
            origin: pairs.vectors(pair::ORIGIN),
            dir: pairs.vectors(pair::DIR),
            t_max: &ones[..pairs.len],
            reaches: pairs.words(pair::REACHES),
            leaves: &[],
        };
        let slot = pairs.words(pair::SLOT);
        let blocked = &mut blocked[..pairs.len];
        if prepared.asks.covers {
            prepared.tree.occluded_batch_where(&rays, Coherence::Lamps, blocked, |i, hit| {
                stops(prepared, &self.asker(slot[i] as usize), hit, pairs.vector(pair::DIR, i))
            });
        } else {
            prepared.tree.occluded_batch(&rays, Coherence::Lamps, blocked);
        }
        self.tile.tally.rays.shadow += pairs.len as u64;
        let slots = &mut self.memory.slots;
        let mut begin = 0;
        for Joined { slot: own, light, density, end } in joined.drain(..) {
            let open = (begin..end).filter(|i| !blocked[*i]);
            let all = open.clone().fold(density, |sum, i| sum + pairs.float(pair::DENSITY, i));
            slots[own as usize].radiance += light / all;
            for i in open {
                slots[slot[i] as usize].radiance += pairs.vector(pair::LIGHT, i) / all;
            }
            begin = end;
        }
        pairs.len = 0;
    }
}
