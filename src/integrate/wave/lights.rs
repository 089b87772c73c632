//! Light samples at sixteen surfaces.

use super::surface::Surface;
use super::{SHADOWS, Wave, shadow};
use crate::integrate::direct::power_heuristic_lanes;
use crate::integrate::wave::lanes::offset_point;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::lighting::{Receiver, Target};
use crate::prepare::kdtree::NO_TRIANGLE;
use crate::sampling::{PathSamplers, Purpose};
use crate::settings::Strategy;
use glam::Vec3;

/// Light samples chosen one by one: direction, weight, target, its error and its normal, density.
#[repr(align(64))]
struct Chosen {
    vectors: [[[f32; LANES]; 3]; 5],
    pdf: [f32; LANES],
    triangle: [u32; LANES],
    valid: u32,
    points: u32,
    infinite: u32,
}

impl Chosen {
    fn put(&mut self, row: usize, lane: usize, v: Vec3) {
        for (k, x) in v.to_array().into_iter().enumerate() {
            self.vectors[row][k][lane] = x;
        }
    }

    #[inline(always)]
    fn vector<L: Lanes>(&self, l: L, row: usize) -> V3<L::F> {
        let [x, y, z] = &self.vectors[row];
        V3::new(l.load(x), l.load(y), l.load(z))
    }
}

/// What a path brings to a vertex and takes from it.
pub(super) struct Carried<L: Lanes> {
    pub throughput: V3<L::F>,
    pub slot: L::U,
    pub triangle: L::U,
    pub samplers: PathSamplers<L>,
}

impl Wave<'_> {
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
        let count = settings.light_samples.max(1);
        for k in 0..count {
            if self.memory.shadows.len + LANES > SHADOWS {
                self.trace_shadows(depth);
            }
            let choice = carried.samplers.get_1d(depth, Purpose::LightChoice(k)).array();
            let u = carried.samplers.get_2d(depth, Purpose::LightPoint(k)).map(|u| u.array());
            let [point, normal] = [surface.point, surface.frame.z].map(|v| v.components().map(|x| x.array()));
            let chosen = self.choose(active.bits(), &point, &normal, &choice, &u);
            let valid = l.mask(chosen.valid);
            if valid.none() {
                continue;
            }
            let direction = chosen.vector(l, 0);
            let local = surface.frame.to_local(direction);
            let mut out = surface.outgoing(direction);
            let (value, bsdf_pdf) = surface.lobes.eval(surface.wo, local);
            let mut open = valid & out.open & value.is_not_zero();
            self.tile.tally.rays.shadow += open.count() as u64;
            let target = chosen.vector(l, 2);
            let (points, infinite) = (l.mask(chosen.points), l.mask(chosen.infinite));
            if points.any() {
                // Points of a disc may lie below the horizon though its centre, which shades, does not.
                let to = target - surface.point;
                let own = surface.outgoing(to);
                open = open & (!points | own.open & to.dot(surface.frame.z).gt(l.splat(0.0)));
                out.origin = V3::select(points, own.origin, out.origin);
                out.above = (points & own.above) | (!points & out.above);
            }
            let on_triangle = !(points | infinite);
            let moved = offset_point(target, chosen.vector(l, 3), chosen.vector(l, 4), out.origin - target);
            let end = V3::select(on_triangle, moved, target);
            let dir = V3::select(infinite, direction, end - out.origin);
            open = open & dir.is_not_zero();
            let pdf = l.load(&chosen.pdf);
            let mut light = carried.throughput.times(value).times(chosen.vector(l, 1));
            if settings.strategy == Strategy::Mis {
                let shared = power_heuristic_lanes(pdf * count as f32, bsdf_pdf);
                light = light * L::F::select(pdf.gt(l.splat(0.0)), shared, l.splat(1.0));
            }
            if count > 1 {
                light = light * l.splat(1.0 / count as f32);
            }
            let t_max = L::F::select(infinite, l.splat(f32::INFINITY), l.splat(1.0));
            let none = l.word(NO_TRIANGLE);
            let [o, d, e] = [out.origin.components(), dir.components(), light.components()];
            let floats = [o[0], o[1], o[2], d[0], d[1], d[2], t_max, e[0], e[1], e[2]];
            let leaves = L::U::select(out.above, carried.triangle, none);
            let words = [carried.slot, leaves, l.load_words(&chosen.triangle), l.word(k + 1)];
            const { assert!(shadow::LIGHT == 7 && shadow::DRAW == 3) };
            let shadows = &mut self.memory.shadows;
            shadows.store::<L>(shadows.len, open, floats, words);
            shadows.len += open.count();
        }
    }

    /// Chooses a light sample for each active receiver.
    #[inline(never)]
    fn choose(
        &self,
        active: u32,
        point: &[[f32; LANES]; 3],
        normal: &[[f32; LANES]; 3],
        choice: &[f32; LANES],
        u: &[[f32; LANES]; 2],
    ) -> Chosen {
        let prepared = self.course.prepared;
        let mut chosen = Chosen {
            vectors: [[[0.0; LANES]; 3]; 5],
            pdf: [0.0; LANES],
            triangle: [NO_TRIANGLE; LANES],
            valid: 0,
            points: 0,
            infinite: 0,
        };
        for lane in (0..LANES).filter(|lane| active >> lane & 1 != 0) {
            let vector = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let receiver = Receiver { point: vector(point), normal: vector(normal), both_sides: false };
            let (choice, u) = (choice[lane], [u[0][lane], u[1][lane]]);
            let (scene, geometry) = (&prepared.scene, &prepared.geometry);
            let Some(light) = prepared.lights.sample(scene, geometry, &receiver, self.course.reach, choice, u) else {
                continue;
            };
            chosen.valid |= 1 << lane;
            chosen.put(0, lane, light.direction);
            chosen.put(1, lane, light.weight);
            chosen.pdf[lane] = light.pdf.unwrap_or(0.0);
            match light.target {
                Target::Infinity => chosen.infinite |= 1 << lane,
                Target::Point(point) => {
                    chosen.points |= 1 << lane;
                    chosen.put(2, lane, point);
                }
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
