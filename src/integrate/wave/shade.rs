//! One scattering of all paths in flight.

use super::aim::Aim;
use super::kernels::SurfaceEffects;
use super::lights::Carried;
use super::look::{Asked, Look};
use super::smooth::{mapped_normal, reflecting_normal, stays, visible_normal};
use super::sort::Sorted;
use super::surface::{Fetch, Surface};
use super::waiting::Waiting;
use super::{Wave, hit, path};
use crate::integrate::cone::OPENING;
use crate::integrate::direct::power_heuristic_lanes;
use crate::integrate::walk::{MOST_SURVIVAL, SURVIVAL};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words, Work};
use crate::prepare::kdtree::NO_TRIANGLE;
use crate::sampling::{PathSamplers, Purpose};
use crate::settings::Strategy;
use crate::shading::{RoughLanes, RoughSample};
use glam::Vec3;
use std::marker::PhantomData;

/// Shades where the rays of all paths have ended, lets light samples wait, and sends the paths on; for surfaces with these effects.
pub(super) struct Shade<'a, 'b, 'c, E> {
    wave: &'a mut Wave<'b, 'c>,
    /// Scattering events so far.
    depth: u32,
    effects: PhantomData<E>,
}

impl<'a, 'b, 'c, E> Shade<'a, 'b, 'c, E> {
    /// The paths of a wavefront, after so many scattering events.
    pub fn new(wave: &'a mut Wave<'b, 'c>, depth: u32) -> Self {
        Self { wave, depth, effects: PhantomData }
    }
}

impl<E: SurfaceEffects> Work for Shade<'_, '_, '_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { wave, depth, .. } = self;
        let count = wave.memory.paths.len;
        let (mut fetch, mut waiting) = (Fetch::new(), Waiting::default());
        // Paths move up within the same rows: entries are written only when they have been read.
        let mut kept = 0;
        for at in (0..count).step_by(LANES) {
            wave.miss(l, depth, at, LANES.min(count - at));
            let sorted = wave.sort::<E>(depth, at, LANES.min(count - at), &mut fetch, &mut waiting).of::<E>();
            if E::ANY {
                wave.light_waiting(l, depth, at, &mut waiting);
            }
            kept += wave.scatter(l, depth, at, &sorted, &fetch, kept);
        }
        wave.memory.paths.len = kept;
    }
}

impl Wave<'_, '_> {
    /// Light from beyond the scene, for those of sixteen paths that have left it.
    #[inline(always)]
    fn miss<L: Lanes>(&mut self, l: L, depth: u32, at: usize, count: usize) {
        let course = self.course;
        let lights = &course.prepared.lights;
        if lights.environment.is_none() || depth == 0 && !course.show_environment {
            return;
        }
        let gone = self.memory.hits.load_words(l, hit::TRIANGLE, at).eq(l.word(NO_TRIANGLE)) & l.first(count);
        if gone.none() {
            return;
        }
        let paths = &self.memory.paths;
        let dir = paths.load_vector(l, path::DIR, at);
        let (mut light, light_pdf) = lights.environment_lanes(l, dir, course.reach);
        let (pdf, zero) = (paths.load(l, path::PDF, at), l.splat(0.0));
        match course.settings.strategy {
            Strategy::Hemisphere | Strategy::Cosine | Strategy::Bsdf => {}
            Strategy::Light => light = light.only(pdf.eq(zero)),
            Strategy::Mis => {
                let shared = pdf.gt(zero) & light_pdf.gt(zero);
                light = light * L::F::select(shared, power_heuristic_lanes(pdf, light_pdf), l.splat(1.0));
            }
        }
        let light = paths.load_vector(l, path::THROUGHPUT, at).times(light).arrays();
        let gone = gone.bits();
        for lane in (0..count).filter(|lane| gone >> lane & 1 != 0) {
            self.slot(at + lane).radiance += Vec3::new(light[0][lane], light[1][lane], light[2][lane]);
        }
    }

    pub(super) fn slot(&mut self, i: usize) -> &mut super::Slot {
        &mut self.memory.slots[self.memory.paths.word(path::SLOT, i) as usize]
    }

    /// Has paths count as not finite: roulette would end them, and nobody would know.
    #[cold]
    fn lose(&mut self, at: usize, lanes: u32) {
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 != 0) {
            self.slot(at + lane).radiance = Vec3::NAN;
        }
    }

    /// Light that surfaces emit, of whom it was asked; `towards` is negative where fronts are seen.
    #[inline(always)]
    fn add_emitted<L: Lanes>(&mut self, l: L, at: usize, lanes: u32, look: &Look<L>, towards: L::F) {
        let seen = look.both_sides | towards.lt(l.splat(0.0));
        let bright = (seen & look.emitted.is_not_zero()).bits() & lanes;
        if bright == 0 {
            return;
        }
        let light = self.memory.paths.load_vector(l, path::THROUGHPUT, at).times(look.emitted).arrays();
        for lane in (0..LANES).filter(|lane| bright >> lane & 1 != 0) {
            self.slot(at + lane).radiance += Vec3::new(light[0][lane], light[1][lane], light[2][lane]);
        }
    }

    /// The surfaces that were fetched, and how they scatter. Adds the light that they emit, where that was left to this.
    #[inline(always)]
    fn surfaces<L: Lanes>(
        &mut self,
        l: L,
        at: usize,
        sorted: &Sorted,
        fetch: &Fetch,
        width: L::F,
    ) -> (Surface<L>, RoughLanes<L::F>) {
        let (paths, hits) = (&self.memory.paths, &self.memory.hits);
        let dir = paths.load_vector(l, path::DIR, at);
        let b = [hits.load(l, hit::B1, at), hits.load(l, hit::B2, at)];
        let (mut surface, mut normal) = fetch.surface(l, dir, b, l.mask(sorted.smooth));
        let albedo = fetch.albedo(l);
        let (rough, glass) = (l.mask(sorted.rough), l.mask(sorted.glass));
        if sorted.rough | sorted.glass == 0 {
            surface.turn(surface.normal, dir);
            return (surface, RoughLanes::lambert(albedo));
        }
        let textured = l.mask(sorted.textured);
        let asked = Asked { active: rough, textured, glowing: l.mask(sorted.glowing), coated: sorted.coated != 0 };
        let mut look = if rough.any() { Some(Look::new(l, self.course.prepared, fetch, width, asked)) } else { None };
        if let Some(look) = &look
            && sorted.glowing != 0
        {
            self.add_emitted(l, at, sorted.glowing, look, dir.dot(fetch.outward(l)));
        }
        let (mut bends, unmapped) = (glass, normal);
        if let Some(look) = &look {
            if look.mapped.any() {
                let mapped = mapped_normal(normal, fetch.tangent(l), look.texel);
                normal = V3::select(look.mapped, mapped, normal);
            }
            bends = bends | look.bends;
        }
        let visible = visible_normal(normal, surface.normal, -dir);
        surface.steady = stays(normal, surface.normal, -dir);
        let bends = bends & surface.is_flat();
        let shading = reflecting_normal(bends, visible, surface.normal, -dir);
        surface.turn(V3::select(rough | glass, shading, surface.normal), dir);
        let diffuse = l.mask(sorted.lanes) & !(rough | glass);
        if let Some(coat) = look.as_mut().and_then(|look| look.coat.as_mut()) {
            let mapped = V3::select(coat.mapped, mapped_normal(unmapped, fetch.tangent(l), coat.texel), unmapped);
            let own = surface.frame.to_local(visible_normal(mapped, surface.normal, -dir)).normalized();
            coat.params.normal = V3::select(coat.params.own, own, coat.params.normal);
            let turned = !(own.x.eq(l.splat(0.0)) & own.y.eq(l.splat(0.0)) & own.z.eq(l.splat(1.0)));
            coat.params.own = coat.params.own & turned;
        }
        let lobes = match &look {
            Some(Look { params, coat, .. }) => {
                let coat = coat.as_ref().map(|coat| &coat.params);
                params.lobes(l, surface.wo, rough, coat).or_lambert(diffuse, albedo)
            }
            None => RoughLanes::lambert(albedo).only(diffuse),
        };
        surface.lower(lobes.transmits_smoothly());
        (surface, lobes)
    }

    /// Scatters the paths whose surfaces were fetched, and moves all that go on up to `kept`; how many they are.
    #[inline(always)]
    fn scatter<L: Lanes>(&mut self, l: L, depth: u32, at: usize, sorted: &Sorted, fetch: &Fetch, kept: usize) -> usize {
        if sorted.lanes | sorted.visited == 0 {
            return 0;
        }
        let (mut floats, mut words) = self.memory.paths.load_all(l, at);
        let mut goes_on = l.mask(sorted.visited);
        let kind = self.course.settings.sampler;
        if sorted.lanes != 0
            && let Some(samplers) = PathSamplers::<L>::new(kind, words[path::KEY], words[path::INDEX])
        {
            let zero = l.splat(0.0);
            let width = floats[path::WIDTH] + floats[path::SPREAD] * self.memory.hits.load(l, hit::T, at);
            let (surface, lobes) = self.surfaces(l, at, sorted, fetch, width);
            let glass = l.mask(sorted.glass);
            let active = l.mask(sorted.lanes) & (lobes.scatters() | glass);
            let mut throughput = vector::<L>(&floats, path::THROUGHPUT);
            if self.memory.reuse.is_some() {
                let lit = active & lobes.has_smooth() & !(glass | lobes.coated());
                match depth {
                    0 => self.keep_first(l, at, lit, &surface, &lobes, throughput),
                    1 => throughput = self.keep_second(l, at, lit, &surface, &lobes, throughput),
                    _ => {}
                }
            }
            let both_sides = lobes.transmits_smoothly();
            let lit = active & lobes.has_smooth() & !glass;
            // Rays that begin above their triangle may meet it.
            let triangle = self.memory.hits.load_words(l, hit::TRIANGLE, at);
            let leaves = L::U::select(surface.lifted, l.word(NO_TRIANGLE), triangle);
            let (slot, cone) = (words[path::SLOT], [width, floats[path::SPREAD]]);
            let carried = Carried { throughput, slot, leaves, cone, samplers, lobes, both_sides };
            if self.course.prepared.lights.any(self.course.reach) && lit.any() {
                self.sample_lights(l, depth, lit, &surface, &carried);
            }
            let mut u = samplers.get_2d(depth, Purpose::Direction);
            let share = lobes.shares[0].only(active & !glass);
            let aim = Aim::new(l, self.course, depth, &surface, share, &mut u);
            let chosen = lobes.chooses() | glass.any();
            let u_lobe = if chosen { samplers.get_1d(depth, Purpose::Lobe) } else { zero };
            let RoughSample { wi: mut local, mut weight, mut pdf, mut delta, straight } =
                lobes.sample(surface.wo, u_lobe, u);
            let mut through = glass & !glass;
            if glass.any() {
                let s = fetch.glass(l).sample(surface.wo, u_lobe);
                local = V3::select(glass, s.wi, local);
                weight = V3::select(glass, s.weight, weight);
                pdf = L::F::select(glass, s.probability, pdf);
                delta = delta | glass;
                through = glass & s.transmitted;
                let scale = floats[path::ETA_SCALE];
                floats[path::ETA_SCALE] = L::F::select(glass, scale * s.eta_scale, scale);
            }
            let mut sample = RoughSample { wi: local, weight, pdf, delta, straight };
            let mut wi = surface.frame.to_world(local);
            if let Some(aim) = &aim {
                let ratio;
                (sample, wi, ratio) = aim.mixed(l, &surface, &lobes, sample);
                floats[path::ETA_SCALE] = floats[path::ETA_SCALE] * ratio;
            }
            let RoughSample { wi: local, weight, pdf, delta, straight } = sample;
            let mut throughput = throughput.times(weight);
            let out = surface.outgoing(wi, local.z);
            // What is not a number is not absorbed either.
            let broken = active & !(pdf.is_finite() & local.is_finite());
            let mut on = broken | active & pdf.gt(zero) & weight.is_not_zero() & out.open;
            let lost = broken | on & !throughput.is_finite();
            if lost.any() {
                self.lose(at, lost.bits());
                on = on & !lost;
            }
            if depth + 1 >= self.course.settings.roulette_after {
                let carried = throughput.max_element() / floats[path::ETA_SCALE];
                let survival = (carried * SURVIVAL).min(l.splat(MOST_SURVIVAL));
                on = on & samplers.get_1d(depth, Purpose::Roulette).lt(survival);
                throughput = throughput * (l.splat(1.0) / survival);
            }
            // Light samples pass smooth walls, too: who went straight on is still sent by the vertex before.
            let sent = active & !(straight & !glass);
            for (row, of, v) in [
                (path::ORIGIN, active, out.origin),
                (path::DIR, active, wi),
                (path::THROUGHPUT, active, throughput),
                (path::POINT, sent, surface.point),
                (path::NORMAL, sent, surface.frame.z),
            ] {
                for (k, x) in v.components().into_iter().enumerate() {
                    floats[row + k] = L::F::select(of, x, floats[row + k]);
                }
            }
            let spread = floats[path::SPREAD];
            let competes = (pdf * (1.0 / self.course.light_samples(depth) as f32)).only(!delta);
            floats[path::PDF] = L::F::select(sent, competes, floats[path::PDF]);
            floats[path::WIDTH] = L::F::select(active, width, floats[path::WIDTH]);
            let wider = spread + (l.splat(OPENING) / pdf.sqrt()).only(!delta);
            floats[path::SPREAD] = L::F::select(active, wider, spread);
            let mut flags = L::U::select(both_sides, l.word(path::BOTH_SIDES), l.word(0));
            let in_glass = on & glass;
            if in_glass.any() {
                let own = self.cross_glass(at, in_glass.bits(), (through & on).bits(), fetch);
                flags = L::U::select(in_glass, l.load_words(&own), flags);
            }
            words[path::FLAGS] = L::U::select(sent, flags, words[path::FLAGS]);
            words[path::LEAVES] = L::U::select(active, leaves, words[path::LEAVES]);
            self.tile.tally.rays.bounce += on.count() as u64;
            goes_on = goes_on | on;
        }
        self.memory.paths.store::<L>(kept, goes_on, floats, words);
        goes_on.count()
    }
}

#[inline(always)]
fn vector<L: Lanes>(floats: &[L::F; path::FLOATS], row: usize) -> V3<L::F> {
    V3::new(floats[row], floats[row + 1], floats[row + 2])
}
