//! Vertices that were made one by one, and wait for light samples: those are chosen in lanes, and their rays traced with all
//! others. What scatters towards them is computed one by one.

use super::lights::Chosen;
use super::{Memory, SHADOWS, Wave, path, shadow};
use crate::integrate::cone::Cone;
use crate::integrate::direct::power_heuristic;
use crate::integrate::medium::Inside;
use crate::integrate::trace::{ShadowRay, rest};
use crate::integrate::vertex::Vertex;
use crate::integrate::walk::Walk;
use crate::lanes::{Floats, LANES, Lanes};
use crate::lighting::ReceiverLanes;
use crate::prepare::kdtree::NO_TRIANGLE;
use crate::sampling::{PathSamplers, Purpose};
use crate::settings::Strategy;
use glam::Vec3;

/// A vertex, and what its path brought there.
struct Waits {
    vertex: Vertex,
    throughput: Vec3,
    inside: Inside,
    cone: Cone,
}

/// Up to sixteen vertices, each in a lane of its own.
#[derive(Default)]
pub(super) struct Waiting {
    vertices: [Option<Waits>; LANES],
    /// Which there are.
    lanes: u32,
    both_sides: u32,
    /// Points and normals as receivers of light.
    receivers: [[[f32; LANES]; 3]; 2],
}

impl Waiting {
    /// Takes a path's vertex; the path has not gone on yet.
    pub fn put(&mut self, lane: usize, vertex: Vertex, walk: &Walk) {
        let receiver = vertex.receiver();
        for (rows, v) in self.receivers.iter_mut().zip([receiver.point, receiver.normal]) {
            for (row, x) in rows.iter_mut().zip(v.to_array()) {
                row[lane] = x;
            }
        }
        self.lanes |= 1 << lane;
        self.both_sides = self.both_sides & !(1 << lane) | u32::from(receiver.both_sides) << lane;
        self.vertices[lane] = Some(Waits { vertex, throughput: walk.throughput, inside: walk.inside, cone: walk.cone });
    }
}

impl Wave<'_, '_> {
    /// Takes light samples at the vertices that wait, which belong to the paths from `at` on.
    #[inline(always)]
    pub(super) fn light_waiting<L: Lanes>(&mut self, l: L, depth: u32, at: usize, waiting: &mut Waiting) {
        if waiting.lanes == 0 {
            return;
        }
        let course = self.course;
        let paths = &self.memory.paths;
        let words = [path::KEY, path::INDEX].map(|row| paths.load_words(l, row, at));
        if let Some(samplers) = PathSamplers::<L>::new(course.settings.sampler, words[0], words[1]) {
            let [point, normal] = &waiting.receivers;
            let one = l.splat(1.0);
            let side = L::F::select(l.mask(waiting.both_sides), -one, one);
            let receiver = ReceiverLanes::<L> { point: l.load_vector(point), normal: l.load_vector(normal), side };
            let of = (&course.prepared.scene, &course.prepared.geometry);
            let (lights, active) = (&course.prepared.lights, l.mask(waiting.lanes));
            for k in 0..course.light_samples(depth) {
                let samplers = samplers.split(k, course.light_samples(depth));
                let choice = samplers.get_1d(depth, Purpose::LightChoice);
                let u = samplers.get_2d(depth, Purpose::LightPoint);
                let room = &mut self.memory.lights;
                let chosen = lights.sample_lanes(l, of, &receiver, active, course.reach, choice, u, room);
                self.shadow_waiting(depth, k, at, &Chosen::of(&chosen), waiting);
            }
        }
        waiting.lanes = 0;
    }

    /// Lets light sample number `k` of each vertex wait to be traced.
    #[inline(never)]
    fn shadow_waiting(&mut self, depth: u32, k: u32, at: usize, chosen: &Chosen, waiting: &Waiting) {
        if self.memory.shadows.len + LANES > SHADOWS {
            self.trace_shadows(depth);
        }
        let (prepared, settings) = (self.course.prepared, self.course.settings);
        let count = self.course.light_samples(depth) as f32;
        for lane in (0..LANES).filter(|lane| (chosen.valid & waiting.lanes) >> lane & 1 != 0) {
            let Some(Waits { vertex, throughput, inside, cone }) = &waiting.vertices[lane] else { continue };
            let sample = chosen.get(lane);
            let Some(outgoing) = vertex.towards(sample.direction) else { continue };
            let (value, bsdf_pdf) = vertex.bsdf.eval(vertex.wo_local(), outgoing.local);
            if value == Vec3::ZERO {
                continue;
            }
            self.tile.tally.rays.shadow += 1;
            let Some(ShadowRay { ray, reaches }) = ShadowRay::new(vertex, &outgoing, &sample) else { continue };
            let inside = if outgoing.local.z < 0.0 { inside.crossed(prepared, &vertex.place) } else { *inside };
            let weight = match (sample.pdf, settings.strategy) {
                (Some(pdf), Strategy::Mis) => power_heuristic(pdf, bsdf_pdf / count),
                _ => 1.0,
            };
            let light = *throughput * (value * sample.weight * rest(prepared, inside, &ray) * weight / count);
            let slot = self.memory.paths.word(path::SLOT, at + lane);
            let Memory { shadows, cones, .. } = &mut *self.memory;
            let to = shadows.len;
            if prepared.asks.walls {
                let Cone { width, spread } = cone.scattered(Some(bsdf_pdf));
                cones.set_float(0, to, width);
                cones.set_float(1, to, spread);
            }
            shadows.set_vector(shadow::ORIGIN, to, ray.origin);
            shadows.set_vector(shadow::DIR, to, ray.dir);
            shadows.set_float(shadow::T_MAX, to, ray.t_max);
            shadows.set_vector(shadow::LIGHT, to, light);
            shadows.set_word(shadow::SLOT, to, slot);
            shadows.set_word(shadow::REACHES, to, reaches.unwrap_or(NO_TRIANGLE));
            shadows.set_word(shadow::DRAW, to, k + 1);
            shadows.set_word(shadow::LEAVES, to, NO_TRIANGLE);
            shadows.len += 1;
        }
    }
}
