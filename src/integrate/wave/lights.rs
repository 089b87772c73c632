//! Light samples at sixteen surfaces.

use super::surface::Surface;
use super::{SHADOWS, Wave, shadow};
use crate::integrate::cone::OPENING;
use crate::integrate::direct::power_heuristic_lanes;
use crate::integrate::wave::lanes::offset_point;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::lighting::{LightSample, LightSampleLanes, Receiver, ReceiverLanes, Target};
use crate::prepare::kdtree::NO_TRIANGLE;
use crate::sampling::{PathSamplers, Purpose};
use crate::settings::Strategy;
use crate::shading::RoughLanes;
use glam::Vec3;

/// Light samples lane by lane: direction, weight, target, its error and its normal, density.
#[repr(align(64))]
pub(super) struct Chosen {
    vectors: [[[f32; LANES]; 3]; 5],
    pdf: [f32; LANES],
    triangle: [u32; LANES],
    pub valid: u32,
    infinite: u32,
}

impl Chosen {
    #[inline(always)]
    pub fn of<L: Lanes>(s: &LightSampleLanes<L>) -> Self {
        Self {
            vectors: [s.direction.arrays(), s.weight.arrays(), s.target.arrays(), s.error.arrays(), s.normal.arrays()],
            pdf: s.pdf.array(),
            triangle: s.triangle.array(),
            valid: s.valid.bits(),
            infinite: s.infinite.bits(),
        }
    }

    /// The sample of a lane.
    pub fn get(&self, lane: usize) -> LightSample {
        let [direction, weight, target, error, normal] =
            self.vectors.each_ref().map(|v| Vec3::new(v[0][lane], v[1][lane], v[2][lane]));
        let target = match self.triangle[lane] {
            _ if self.infinite >> lane & 1 != 0 => Target::Infinity,
            NO_TRIANGLE => Target::Point(target),
            triangle => Target::Triangle { triangle, point: target, error, normal },
        };
        let pdf = (self.pdf[lane] > 0.0).then_some(self.pdf[lane]);
        LightSample { direction, weight, pdf, target, through_glass: false }
    }

    fn put(&mut self, row: usize, lane: usize, v: Vec3) {
        for (k, x) in v.to_array().into_iter().enumerate() {
            self.vectors[row][k][lane] = x;
        }
    }

    #[inline(always)]
    fn lanes<L: Lanes>(&self, l: L) -> LightSampleLanes<L> {
        let [direction, weight, target, error, normal] = &self.vectors;
        LightSampleLanes {
            valid: l.mask(self.valid),
            direction: l.load_vector(direction),
            weight: l.load_vector(weight),
            pdf: l.load(&self.pdf),
            target: l.load_vector(target),
            error: l.load_vector(error),
            normal: l.load_vector(normal),
            triangle: l.load_words(&self.triangle),
            infinite: l.mask(self.infinite),
        }
    }
}

/// What a path brings to a vertex and takes from it.
pub(super) struct Carried<L: Lanes> {
    pub throughput: V3<L::F>,
    pub slot: L::U,
    /// The triangle that its rays leave, where that is behind them.
    pub leaves: L::U,
    /// Width and spread of its cone.
    pub cone: [L::F; 2],
    pub samplers: PathSamplers<L>,
    /// How the vertex scatters.
    pub lobes: RoughLanes<L::F>,
    /// Where it scatters smoothly to both sides.
    pub both_sides: L::M,
}

impl Wave<'_, '_> {
    /// Takes light samples at the surfaces where `active` is true, and lets them wait.
    #[inline(always)]
    pub(super) fn sample_lights<L: Lanes>(
        &mut self,
        l: L,
        depth: u32,
        active: L::M,
        surface: &Surface<L>,
        carried: &Carried<L>,
    ) {
        let settings = self.course.settings;
        let count = self.course.light_samples(depth);
        for k in 0..count {
            if self.memory.shadows.len + LANES > SHADOWS {
                self.trace_shadows(depth);
            }
            let samplers = carried.samplers.split(k, count);
            let choice = samplers.get_1d(depth, Purpose::LightChoice);
            let u = samplers.get_2d(depth, Purpose::LightPoint);
            let (zero, one) = (l.splat(0.0), l.splat(1.0));
            let side = L::F::select(carried.both_sides, -one, one);
            let receiver = ReceiverLanes::<L> { point: surface.point, normal: surface.frame.z, side };
            let prepared = self.course.prepared;
            let (lights, of) = (&prepared.lights, (&prepared.scene, &prepared.geometry));
            let chosen = if lights.lanes_can() {
                lights.sample_lanes(l, of, &receiver, active, self.course.reach, choice, u, &mut self.memory.lights)
            } else {
                let places = [receiver.point.arrays(), receiver.normal.arrays()];
                let both_sides = carried.both_sides.bits();
                self.choose(active.bits(), both_sides, &places, &[choice.array(), u[0].array(), u[1].array()]).lanes(l)
            };
            if chosen.valid.none() {
                continue;
            }
            let direction = chosen.direction;
            let local = surface.frame.to_local(direction);
            let mut out = surface.outgoing(direction, local.z);
            let (value, bsdf_pdf) = carried.lobes.eval(surface.wo, local);
            let mut open = chosen.valid & out.open & value.is_not_zero();
            self.tile.tally.rays.shadow += open.count() as u64;
            let (target, infinite) = (chosen.target, chosen.infinite);
            let none = l.word(NO_TRIANGLE);
            let points = chosen.triangle.eq(none) & !infinite;
            if points.any() {
                // Points of a disc may lie below the horizon though its centre, which shades, does not.
                let to = target - surface.point;
                let to_z = to.dot(surface.frame.z);
                let own = surface.outgoing(to, to_z);
                let other_side = to_z.gt(zero) ^ local.z.gt(zero);
                open = open & (!points | own.open & !other_side);
                out.origin = V3::select(points, own.origin, out.origin);
            }
            let on_triangle = !(points | infinite);
            let moved = offset_point(target, chosen.error, chosen.normal, out.origin - target);
            let end = V3::select(on_triangle, moved, target);
            let dir = V3::select(infinite, direction, end - out.origin);
            open = open & dir.is_not_zero();
            let pdf = chosen.pdf;
            let mut light = carried.throughput.times(value).times(chosen.weight);
            if settings.strategy == Strategy::Mis {
                let shared = power_heuristic_lanes(pdf, bsdf_pdf * (1.0 / count as f32));
                light = light * L::F::select(pdf.gt(zero), shared, one);
            }
            if count > 1 {
                light = light * l.splat(1.0 / count as f32);
            }
            let t_max = L::F::select(infinite, l.splat(f32::INFINITY), one);
            let [o, d, e] = [out.origin.components(), dir.components(), light.components()];
            let floats = [o[0], o[1], o[2], d[0], d[1], d[2], t_max, e[0], e[1], e[2]];
            let words = [carried.slot, chosen.triangle, l.word(k + 1), carried.leaves];
            const { assert!(shadow::LIGHT == 7 && shadow::DRAW == 2 && shadow::LEAVES == 3) };
            if prepared.asks.walls {
                let spread = carried.cone[1] + l.splat(OPENING) / bsdf_pdf.sqrt();
                self.memory.cones.store::<L>(self.memory.shadows.len, open, [carried.cone[0], spread], []);
            }
            let shadows = &mut self.memory.shadows;
            shadows.store::<L>(shadows.len, open, floats, words);
            shadows.len += open.count();
        }
    }

    /// Chooses a light sample for each active receiver, one after the other: where lights are of kinds that lanes cannot do.
    /// `receivers` are points and normals, `numbers` the choice's and the point's.
    #[inline(never)]
    fn choose(
        &self,
        active: u32,
        both_sides: u32,
        receivers: &[[[f32; LANES]; 3]; 2],
        numbers: &[[f32; LANES]; 3],
    ) -> Chosen {
        let prepared = self.course.prepared;
        let mut chosen = Chosen {
            vectors: [[[0.0; LANES]; 3]; 5],
            pdf: [0.0; LANES],
            triangle: [NO_TRIANGLE; LANES],
            valid: 0,
            infinite: 0,
        };
        for lane in (0..LANES).filter(|lane| active >> lane & 1 != 0) {
            let vector = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let [point, normal] = receivers.each_ref().map(vector);
            let receiver = Receiver { point, normal, both_sides: both_sides >> lane & 1 != 0 };
            let [choice, u, v] = numbers.each_ref().map(|row| row[lane]);
            let (scene, geometry) = (&prepared.scene, &prepared.geometry);
            let Some(light) = prepared.lights.sample(scene, geometry, &receiver, self.course.reach, choice, [u, v])
            else {
                continue;
            };
            chosen.valid |= 1 << lane;
            chosen.put(0, lane, light.direction);
            chosen.put(1, lane, light.weight);
            chosen.pdf[lane] = light.pdf.unwrap_or(0.0);
            match light.target {
                Target::Infinity => chosen.infinite |= 1 << lane,
                Target::Point(point) => chosen.put(2, lane, point),
                Target::Triangle { triangle, point, error, normal } => {
                    chosen.triangle[lane] = triangle;
                    chosen.put(2, lane, point);
                    chosen.put(3, lane, error);
                    chosen.put(4, lane, normal);
                }
            }
        }
        chosen
    }
}
