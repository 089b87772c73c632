//! One scattering of all paths in flight.

use super::lights::Carried;
use super::surface::{Fetch, Surface};
use super::{Wave, hit, path};
use crate::geometry::emission;
use crate::integrate::cone::OPENING;
use crate::integrate::direct::{emission_weight, power_heuristic_lanes};
use crate::integrate::material::Scattering;
use crate::integrate::vertex::{Place, Vertex, scattering};
use crate::integrate::walk::{Company, MOST_SURVIVAL};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words, Work};
use crate::math::Hit;
use crate::prepare::Way;
use crate::prepare::kdtree::NO_TRIANGLE;
use crate::sampling::{PathSamplers, Purpose};
use crate::settings::Strategy;
use glam::Vec3;

/// Shades where the rays of all paths have ended, lets light samples wait, and sends the paths on.
pub(super) struct Shade<'a, 'b> {
    pub wave: &'a mut Wave<'b>,
    /// Scattering events so far.
    pub depth: u32,
}

/// What becomes of sixteen paths, as sets of lanes.
struct Sorted {
    /// Their surfaces are shaded in lanes.
    lanes: u32,
    /// Those among them whose triangles have normals at their corners, and lobes that are still to be found.
    smooth: u32,
    /// Those among them whose surfaces were made one by one.
    made: u32,
    /// They have been visited, and go on.
    visited: u32,
}

impl Work for Shade<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { wave, depth } = self;
        let count = wave.memory.paths.len;
        let mut fetch = Fetch::new();
        // Paths move up within the same rows: entries are written only when they have been read.
        let mut kept = 0;
        for at in (0..count).step_by(LANES) {
            wave.miss(l, depth, at, LANES.min(count - at));
            let mut sorted = wave.sort(depth, at, LANES.min(count - at), &mut fetch);
            kept += wave.scatter(l, depth, at, &mut sorted, &mut fetch, kept);
        }
        wave.memory.paths.len = kept;
    }
}

impl Wave<'_> {
    /// Adds the light that sixteen paths meet, visits those that lanes cannot, and fetches the surfaces of the others.
    #[inline(never)]
    fn sort(&mut self, depth: u32, at: usize, count: usize, fetch: &mut Fetch) -> Sorted {
        let course = self.course;
        let prepared = course.prepared;
        let lanes_can = course.lanes_can();
        let mut sorted = Sorted { lanes: 0, smooth: 0, made: 0, visited: 0 };
        for lane in 0..count {
            let i = at + lane;
            let triangle = self.memory.hits.word(hit::TRIANGLE, i);
            if triangle == NO_TRIANGLE {
                continue;
            }
            let part = &prepared.ways[prepared.geometry.part_index(triangle) as usize];
            let inside = self.memory.paths.word(path::FLAGS, i) & path::INSIDE != 0;
            if part.way == Way::Any || inside || !lanes_can {
                sorted.visited |= u32::from(self.visit(depth, i)) << lane;
                continue;
            }
            let width = self.memory.widen(i);
            if part.emits {
                self.add_emission(i);
            }
            if depth == course.settings.max_depth {
                continue;
            }
            match part.way {
                Way::Diffuse(Vec3::ZERO) => {}
                Way::Diffuse(albedo) => {
                    fetch.put_triangle(lane, prepared, triangle);
                    fetch.put_albedo(lane, albedo);
                    sorted.lanes |= 1 << lane;
                }
                Way::Smooth => {
                    fetch.put_triangle(lane, prepared, triangle);
                    fetch.put_normals(lane, prepared, triangle);
                    sorted.lanes |= 1 << lane;
                    sorted.smooth |= 1 << lane;
                }
                _ => {
                    let (hit, dir) = (self.hit(i), self.memory.paths.vector(path::DIR, i));
                    let Some(place) = Place::new(prepared, &hit, dir) else { continue };
                    let vertex = Vertex::new(prepared, &hit, place, dir, 1.0, width);
                    if vertex.bsdf.is_black() {
                        continue;
                    }
                    match vertex.rough() {
                        Some(rough) => {
                            fetch.put_vertex(lane, &rough);
                            sorted.lanes |= 1 << lane;
                            sorted.made |= 1 << lane;
                        }
                        None => sorted.visited |= u32::from(self.scatter_one(depth, i, &vertex)) << lane,
                    }
                }
            }
        }
        sorted
    }

    /// Finds the lobes of smooth surfaces, seen at these cosines. Paths whose surfaces scatter in ways that lanes do not know
    /// are visited; those whose surfaces scatter nothing end.
    #[inline(never)]
    fn find_lobes(&mut self, depth: u32, at: usize, cosines: &[f32; LANES], sorted: &mut Sorted, fetch: &mut Fetch) {
        let prepared = self.course.prepared;
        for lane in (0..LANES).filter(|lane| sorted.smooth >> lane & 1 != 0) {
            let i = at + lane;
            let (hit, width) = (self.hit(i), self.memory.paths.float(path::WIDTH, i));
            match scattering(prepared, &hit, cosines[lane], width) {
                Scattering::Rough(lobes) => {
                    fetch.put_lobes(lane, &lobes);
                    continue;
                }
                Scattering::Nothing => {}
                Scattering::Other => {
                    let dir = self.memory.paths.vector(path::DIR, i);
                    if let Some(place) = Place::new(prepared, &hit, dir) {
                        let vertex = Vertex::new(prepared, &hit, place, dir, 1.0, width);
                        let goes_on = !vertex.bsdf.is_black() && self.scatter_one(depth, i, &vertex);
                        sorted.visited |= u32::from(goes_on) << lane;
                    }
                }
            }
            sorted.lanes &= !(1 << lane);
        }
    }

    fn hit(&self, i: usize) -> Hit {
        let hits = &self.memory.hits;
        let [t, b1, b2] = [hit::T, hit::B1, hit::B2].map(|row| hits.float(row, i));
        Hit { t, triangle: hits.word(hit::TRIANGLE, i), b1, b2 }
    }

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
        let light_pdf = light_pdf * course.settings.light_samples.max(1) as f32;
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

    /// Light that a surface emits.
    fn add_emission(&mut self, i: usize) {
        let course = self.course;
        let prepared = course.prepared;
        let (hit, walk) = (self.hit(i), self.memory.walk(i));
        let Some(place) = Place::new(prepared, &hit, walk.dir) else { return };
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let emitted = emission::emitted(&prepared.scene, &prepared.geometry, hit.triangle, b, place.front);
        if emitted != Vec3::ZERO {
            let weight = emission_weight(prepared, course.settings, course.reach, &walk.sent, &place);
            self.slot(i).radiance += walk.throughput * emitted * weight;
        }
    }

    fn slot(&mut self, i: usize) -> &mut super::Slot {
        &mut self.memory.slots[self.memory.paths.word(path::SLOT, i) as usize]
    }

    /// Does everything for a path as the plain integrator does; whether it goes on.
    fn visit(&mut self, depth: u32, i: usize) -> bool {
        let (hit, mut walk) = (self.hit(i), self.memory.walk(i));
        let course = self.course;
        let slot = &mut self.memory.slots[self.memory.paths.word(path::SLOT, i) as usize];
        let rays = &mut self.tile.tally.rays;
        let super::Slot { sampler, radiance, .. } = slot;
        let mut with = Company { sampler, radiance, rays, recorder: &mut () };
        let goes_on = course.visit(depth, &mut walk, Some(hit), &mut with);
        if goes_on {
            self.memory.put(i, &walk);
        }
        goes_on
    }

    /// Scatters a path as the plain integrator does, its emission having been added.
    fn scatter_one(&mut self, depth: u32, i: usize, vertex: &Vertex) -> bool {
        let mut walk = self.memory.walk(i);
        let course = self.course;
        let slot = &mut self.memory.slots[self.memory.paths.word(path::SLOT, i) as usize];
        let rays = &mut self.tile.tally.rays;
        let super::Slot { sampler, radiance, .. } = slot;
        let mut with = Company { sampler, radiance, rays, recorder: &mut () };
        let goes_on = course.scatter(depth, &mut walk, vertex, &mut with);
        if goes_on {
            self.memory.put(i, &walk);
        }
        goes_on
    }

    /// Has paths count as not finite: roulette would end them, and nobody would know.
    #[cold]
    fn lose(&mut self, at: usize, lanes: u32) {
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 != 0) {
            self.slot(at + lane).radiance = Vec3::NAN;
        }
    }

    /// Scatters the paths whose surfaces were fetched, and moves all that go on up to `kept`; how many they are.
    #[inline(always)]
    fn scatter<L: Lanes>(
        &mut self,
        l: L,
        depth: u32,
        at: usize,
        sorted: &mut Sorted,
        fetch: &mut Fetch,
        kept: usize,
    ) -> usize {
        if sorted.lanes | sorted.visited == 0 {
            return 0;
        }
        let mut surface = None;
        if sorted.lanes != 0 {
            let (paths, hits) = (&self.memory.paths, &self.memory.hits);
            let dir = paths.load_vector(l, path::DIR, at);
            let b = [hits.load(l, hit::B1, at), hits.load(l, hit::B2, at)];
            let own: Surface<L> = fetch.surface(l, dir, b, [l.mask(sorted.smooth), l.mask(sorted.made)]);
            if sorted.smooth != 0 {
                self.find_lobes(depth, at, &own.wo.z.array(), sorted, fetch);
            }
            surface = Some(own);
        }
        let active = l.mask(sorted.lanes);
        let (mut floats, mut words) = self.memory.paths.load_all(l, at);
        let mut goes_on = l.mask(sorted.visited);
        let kind = self.course.settings.sampler;
        if active.any()
            && let Some(surface) = surface
            && let Some(samplers) = PathSamplers::<L>::new(kind, words[path::KEY], words[path::INDEX])
        {
            let lobes = fetch.lobes(l, active);
            let throughput = vector::<L>(&floats, path::THROUGHPUT);
            let carried = Carried { throughput, slot: words[path::SLOT], samplers, lobes };
            if self.course.prepared.lights.any(self.course.reach) {
                self.sample_lights(l, depth, active, &surface, &carried);
            }
            let u = samplers.get_2d(depth, Purpose::Direction);
            let chosen = lobes.reflects;
            let u_lobe = if chosen { samplers.get_1d(depth, Purpose::Lobe) } else { l.splat(0.0) };
            let local = lobes.sample(surface.wo, u_lobe, u);
            let (value, pdf) = lobes.eval(surface.wo, local);
            let weight = value * (l.splat(1.0) / pdf);
            let mut throughput = throughput.times(weight);
            let wi = surface.frame.to_world(local);
            let out = surface.outgoing(wi);
            // What is not a number is not absorbed either.
            let broken = active & !(pdf.is_finite() & local.is_finite());
            let mut on = broken | active & pdf.gt(l.splat(0.0)) & value.is_not_zero() & out.open;
            let lost = broken | on & !throughput.is_finite();
            if lost.any() {
                self.lose(at, lost.bits());
                on = on & !lost;
            }
            if depth + 1 >= self.course.settings.roulette_after {
                let survival = (throughput.max_element() / floats[path::ETA_SCALE]).min(l.splat(MOST_SURVIVAL));
                on = on & samplers.get_1d(depth, Purpose::Roulette).lt(survival);
                throughput = throughput * (l.splat(1.0) / survival);
            }
            for (row, v) in [
                (path::ORIGIN, out.origin),
                (path::DIR, wi),
                (path::THROUGHPUT, throughput),
                (path::POINT, surface.point),
                (path::NORMAL, surface.frame.z),
            ] {
                for (k, x) in v.components().into_iter().enumerate() {
                    floats[row + k] = L::F::select(active, x, floats[row + k]);
                }
            }
            floats[path::PDF] = L::F::select(active, pdf, floats[path::PDF]);
            let spread = floats[path::SPREAD];
            floats[path::SPREAD] = L::F::select(active, spread + l.splat(OPENING) / pdf.sqrt(), spread);
            words[path::FLAGS] = L::U::select(active, l.word(0), words[path::FLAGS]);
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
