//! The rays of a wavefront.

use super::passed::Passed;
use super::{Memory, State, Wave, hit, path, shadow};
use crate::integrate::cone::Cone;
use crate::integrate::trace::{Asker, Walls, covers, is_wall, most_triangles, through_walls};
use crate::prepare::kdtree::{Coherence, HitBatch, NO_TRIANGLE, RayBatch};

impl Wave<'_, '_> {
    /// The closest hits of all paths.
    pub(super) fn trace_paths(&mut self, depth: u32) {
        let prepared = self.course.prepared;
        let Memory { paths, hits, slots, states, endless, passed, .. } = &mut *self.memory;
        hits.len = paths.len;
        let ([t, b1, b2], [triangle]) = hits.all_mut();
        let mut found = HitBatch { t, b1, b2, triangle };
        let rays = RayBatch {
            origin: paths.vectors(path::ORIGIN),
            dir: paths.vectors(path::DIR),
            t_max: &endless[..paths.len],
            reaches: &[],
            leaves: if depth == 0 { &[] } else { paths.words(path::LEAVES) },
        };
        let eye = depth == 0;
        let coherence = if eye { self.course.camera } else { Coherence::Scattered };
        if prepared.asks.covers || (eye && prepared.asks.culls) {
            let slot = paths.words(path::SLOT);
            let passed = passed.get_or_insert_with(|| Box::new(Passed::new(prepared.questions.mostly())));
            passed.closest(&prepared.tree, &rays, coherence, &mut found, |i, hit| {
                if !prepared.questions.asks(hit.triangle, eye) {
                    return true;
                }
                let sampler = states[slot[i] as usize].sampler;
                covers(prepared, &Asker { sampler, vertex: depth, draw: 0, eye }, hit, paths.vector(path::DIR, i))
            });
        } else {
            prepared.tree.closest_batch(&rays, coherence, &mut found);
        }
        if depth == 0 {
            for (slot, triangle) in slots.iter_mut().zip(hits.words(hit::TRIANGLE)) {
                slot.covered = *triangle != NO_TRIANGLE;
            }
        }
    }

    /// Traces the light samples that wait, and adds what arrives to their paths.
    #[inline(never)]
    pub(super) fn trace_shadows(&mut self, depth: u32) {
        let prepared = self.course.prepared;
        let Memory { shadows, slots, states, blocked, walled, cones, .. } = &mut *self.memory;
        if shadows.len == 0 {
            return;
        }
        let rays = RayBatch {
            origin: shadows.vectors(shadow::ORIGIN),
            dir: shadows.vectors(shadow::DIR),
            t_max: shadows.floats(shadow::T_MAX),
            reaches: shadows.words(shadow::REACHES),
            leaves: shadows.words(shadow::LEAVES),
        };
        let slot = shadows.words(shadow::SLOT);
        let blocked = &mut blocked[..shadows.len];
        // Of many lamps neighbours choose different ones.
        let alike = depth == 0 && prepared.lights.are_few();
        let coherence = if alike { Coherence::Lamps } else { Coherence::Scattered };
        let draw = shadows.words(shadow::DRAW);
        let asker = |states: &[State], i: usize| {
            let sampler = states[slot[i] as usize].sampler;
            Asker { sampler, vertex: depth + 1, draw: draw[i], eye: false }
        };
        let most = self.course.settings.max_depth.saturating_sub(depth + 1);
        walled.begin(if prepared.asks.walls { blocked.len() } else { 0 });
        if prepared.asks.covers || prepared.asks.walls {
            prepared.tree.occluded_batch_where(&rays, coherence, blocked, |i, hit| {
                if prepared.questions.asks(hit.triangle, false)
                    && !covers(prepared, &asker(states, i), hit, shadows.vector(shadow::DIR, i))
                {
                    return false;
                }
                !(is_wall(prepared, hit) && walled.meet(i, hit, most_triangles(most)))
            });
        } else {
            prepared.tree.occluded_batch(&rays, coherence, blocked);
        }
        for (i, blocked) in blocked.iter().enumerate() {
            if *blocked {
                continue;
            }
            let mut light = shadows.vector(shadow::LIGHT, i);
            if prepared.asks.walls
                && let met = walled.of(i)
                && !met.is_empty()
            {
                let cone = Cone { width: cones.float(0, i), spread: cones.float(1, i) };
                let ray = [shadow::ORIGIN, shadow::DIR].map(|row| shadows.vector(row, i));
                light *= through_walls(prepared, ray.into(), met, Walls { cone, most });
            }
            slots[slot[i] as usize].radiance += light;
        }
        shadows.len = 0;
    }
}
