//! What the rays of sixteen paths have met, and who shades it.

use super::kernels::SurfaceEffects;
use super::surface::Fetch;
use super::waiting::Waiting;
use super::{Wave, hit, path};
use crate::integrate::direct::{emission_found, emission_weight};
use crate::integrate::vertex::Place;
use crate::integrate::walk::Company;
use crate::lanes::LANES;
use crate::math::Hit;
use crate::prepare::Way;
use crate::prepare::kdtree::NO_TRIANGLE;
use glam::Vec3;

/// Fewer triangles are in the cache anyway.
const FAR_FROM_FEW: usize = 1 << 12;

/// What becomes of sixteen paths, as sets of lanes.
pub(super) struct Sorted {
    /// Their surfaces are shaded in lanes.
    pub lanes: u32,
    /// Those among them whose triangles have normals at their corners.
    pub smooth: u32,
    /// Those among the first whose lobes are still to be found.
    pub rough: u32,
    /// Those among these that have textures or colours.
    pub textured: u32,
    /// Those among these that may have a clear coat.
    pub coated: u32,
    /// Those among the textured ones whose light is looked up with the rest: nothing but the path finds it.
    pub glowing: u32,
    /// Those among the first that are smooth glass.
    pub glass: u32,
    /// They have been visited, and go on.
    pub visited: u32,
}

impl Sorted {
    /// The same, where these effects are all that there is: what is known before needs no question later.
    #[inline(always)]
    pub fn of<E: SurfaceEffects>(self) -> Self {
        let any = |lanes| if E::ANY { lanes } else { 0 };
        Self {
            lanes: self.lanes,
            smooth: any(self.smooth),
            rough: any(self.rough),
            textured: any(self.textured),
            coated: any(self.coated),
            glowing: any(self.glowing),
            glass: any(self.glass),
            visited: any(self.visited),
        }
    }
}

impl Wave<'_, '_> {
    /// Adds the light that sixteen paths meet, visits those that lanes cannot, and fetches the surfaces of the others.
    #[inline(never)]
    pub(super) fn sort<E: SurfaceEffects>(
        &mut self,
        depth: u32,
        at: usize,
        count: usize,
        fetch: &mut Fetch,
        waiting: &mut Waiting,
    ) -> Sorted {
        let course = self.course;
        let prepared = course.prepared;
        let lanes_can = !E::ANY || course.lanes_can();
        let mut sorted =
            Sorted { lanes: 0, smooth: 0, rough: 0, textured: 0, coated: 0, glowing: 0, glass: 0, visited: 0 };
        self.look_ahead::<E>(at);
        let mut parts = [0; LANES];
        for (part, triangle) in parts.iter_mut().zip(&self.memory.hits.words(hit::TRIANGLE)[at..at + count]) {
            if *triangle != NO_TRIANGLE {
                *part = prepared.geometry.part_index(*triangle);
            }
        }
        for (lane, part) in parts.into_iter().enumerate().take(count) {
            let i = at + lane;
            let triangle = self.memory.hits.word(hit::TRIANGLE, i);
            if triangle == NO_TRIANGLE {
                continue;
            }
            let part = &prepared.ways[part as usize];
            let inside = self.memory.paths.word(path::FLAGS, i) & path::INSIDE != 0;
            if E::ANY && (part.way == Way::Any || inside && part.way != Way::Glass || !lanes_can) {
                sorted.visited |= u32::from(self.visit(depth, i, (lane, waiting))) << lane;
                continue;
            }
            if E::ANY && part.way == Way::Glass {
                self.enter_glass(i, lane, fetch);
            }
            // What only the path can find is seen blurred, and bright beside the bright.
            let competes = self.memory.paths.float(path::PDF, i) > 0.0;
            if part.emits && !(competes && prepared.geometry.is_dark(triangle)) {
                // Lanes look it up with the other textures, where there is more to do than this.
                let in_lanes = E::ANY && part.way == Way::Rough && part.textured && depth < course.settings.max_depth;
                match part.glow {
                    Some(glow) if !competes => self.add_glow(i, glow),
                    None if !competes && in_lanes => sorted.glowing |= 1 << lane,
                    _ => self.add_emission(i),
                }
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
                _ if !E::ANY => {}
                way => {
                    let geometry = &prepared.geometry;
                    fetch.put_triangle(lane, prepared, triangle);
                    if part.smooth {
                        fetch.put_normals(lane, prepared, triangle);
                        sorted.smooth |= 1 << lane;
                    }
                    sorted.lanes |= 1 << lane;
                    if way == Way::Glass {
                        sorted.glass |= 1 << lane;
                        continue;
                    }
                    if part.textured {
                        let Hit { b1, b2, .. } = self.hit(i);
                        let b = [1.0 - b1 - b2, b1, b2];
                        fetch.put_look(lane, &geometry.texturing(&prepared.scene, triangle, b, part.mapped));
                        sorted.textured |= 1 << lane;
                    }
                    sorted.coated |= u32::from(part.coated) << lane;
                    fetch.material[lane] = geometry.material(&prepared.scene, triangle);
                    sorted.rough |= 1 << lane;
                }
            }
        }
        sorted
    }

    /// Has fetched what the paths behind sixteen will ask for: of the next sixteen what their triangles lead to, and of those after
    /// them the triangles. At the first of all, what was missed of both.
    #[inline(always)]
    fn look_ahead<E: SurfaceEffects>(&self, at: usize) {
        let prepared = self.course.prepared;
        if prepared.geometry.len() < FAR_FROM_FEW {
            return;
        }
        let triangles = self.memory.hits.words(hit::TRIANGLE);
        let some = |from: usize, to: usize| {
            let row = &triangles[from.min(triangles.len())..to.min(triangles.len())];
            row.iter().copied().filter(|triangle| *triangle != NO_TRIANGLE)
        };
        let early = if at == 0 { 2 * LANES } else { 0 };
        for triangle in some(at + 2 * LANES - early, at + 3 * LANES) {
            prepared.geometry.expect_triangle(triangle);
        }
        for triangle in some(at + LANES - early / 2, at + 2 * LANES) {
            prepared.geometry.expect_corners(triangle);
            if E::ANY && prepared.asks.vertices {
                let part = &prepared.ways[prepared.geometry.part_index(triangle) as usize];
                if part.smooth || part.textured {
                    prepared.geometry.expect(&prepared.scene, triangle, part.smooth, part.textured, part.mapped);
                }
            }
        }
    }

    pub(super) fn hit(&self, i: usize) -> Hit {
        let hits = &self.memory.hits;
        let [t, b1, b2] = [hit::T, hit::B1, hit::B2].map(|row| hits.float(row, i));
        Hit { t, triangle: hits.word(hit::TRIANGLE, i), b1, b2 }
    }

    /// Light that a surface emits from its front or back, where it is the same everywhere and nothing but the path finds it.
    fn add_glow(&mut self, i: usize, [front, back]: [Vec3; 2]) {
        let normal = self.course.prepared.geometry.unit_normal(self.memory.hits.word(hit::TRIANGLE, i));
        let emitted = if self.memory.paths.vector(path::DIR, i).dot(normal) < 0.0 { front } else { back };
        if emitted != Vec3::ZERO {
            let throughput = self.memory.paths.vector(path::THROUGHPUT, i);
            self.slot(i).radiance += throughput * emitted;
        }
    }

    /// Light that a surface emits.
    fn add_emission(&mut self, i: usize) {
        let course = self.course;
        let prepared = course.prepared;
        let (hit, walk) = (self.hit(i), self.memory.walk(i));
        let Some(place) = Place::new(prepared, &hit, walk.dir) else { return };
        let emitted = emission_found(prepared, &hit, place.front, &walk.sent, walk.cone.at(hit.t).width);
        if emitted != Vec3::ZERO {
            let weight = emission_weight(course, &walk.sent, &place);
            self.slot(i).radiance += walk.throughput * emitted * weight;
        }
    }

    /// Does everything for a path as the plain integrator does, but for light samples, which wait where lanes can choose them;
    /// whether it goes on.
    fn visit(&mut self, depth: u32, i: usize, (lane, waiting): (usize, &mut Waiting)) -> bool {
        let (hit, mut walk) = (self.hit(i), self.memory.walk(i));
        let course = self.course;
        let slot = self.memory.paths.word(path::SLOT, i) as usize;
        let rays = &mut self.tile.tally.rays;
        let (radiance, sampler) = (&mut self.memory.slots[slot].radiance, &mut self.memory.states[slot].sampler);
        let mut with = Company { sampler, radiance, rays, recorder: &mut () };
        let goes_on = if course.lanes_can() && course.prepared.lights.lanes_can() {
            let Some(vertex) = course.arrive(depth, &mut walk, Some(hit), &mut with) else { return false };
            if vertex.bsdf.has_smooth() && course.prepared.lights.any(course.reach) {
                waiting.put(lane, vertex, &walk);
            }
            course.scatter(depth, &mut walk, &vertex, &mut with)
        } else {
            course.visit(depth, &mut walk, Some(hit), &mut with)
        };
        if goes_on {
            self.memory.put(i, &walk);
        }
        goes_on
    }
}
