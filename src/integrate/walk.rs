//! One step of a path, whoever follows it.

use super::aim;
use super::cone::Cone;
use super::direct::{direct, emission_found, emission_weight, environment, reach};
use super::medium::Inside;
use super::record::{PathEvent, Recorder};
use super::vertex::{Place, Vertex};
use super::{RayCounts, View};
use crate::lighting::casters::Casters;
use crate::lighting::{LightReach, Receiver};
use crate::math::Hit;
use crate::prepare::PreparedScene;
use crate::prepare::kdtree::Coherence;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::{RenderSettings, SamplerKind, Strategy};
use crate::shading::BsdfSample;
use glam::Vec3;

/// The most that roulette lets a path survive by. Less than 1 would make paths between nearly white walls heavier with
/// every bounce, without bound (and their variance infinite).
pub(super) const MOST_SURVIVAL: f32 = 1.0;

/// Paths survive roulette by this much of what they carry, so that it ends none that carries more than a quarter. What a path will find is
/// not known, and what is found rarely is the brighter for it: ended in proportion to what they carry (1), paths that find a lamp through glass
/// made specks of the rest. 4 against 1, from the third scattering against the fifth, takes 0.63 (glass and metal), 0.85 (many lamps), 0.89
/// (diffuse walls) and 1.00 (open air) of the time to a given error; 3 is within 0.03 of 4 (`scripts/runs/2026-11-23-roulette-casters.md`).
pub(super) const SURVIVAL: f32 = 4.0;

/// Light samples at a path's first vertex. They cost a ray each, and what they leave of their own noise is most of a picture's where light
/// comes from lamps and environments rather than from walls: to a given error, two took 0.71 to 0.92 of the time of one under soft
/// shadows, maps and many lights, 1.05 within a closed room, and a third gained nothing.
const FIRST_SAMPLES: u32 = 2;
/// The same where pixels use each other's paths, so that little noise is left but that of light samples: four take 0.67 of the time of
/// two under soft shadows, and 1.02 to 1.05 within a closed room; six and eight gain nothing more (`scripts/runs/2026-11-24-packets.md`).
const FIRST_SAMPLES_SHARED: u32 = 4;

/// What all paths of a picture share.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub prepared: &'a PreparedScene,
    pub settings: &'a RenderSettings,
    /// Which lights are sampled.
    pub reach: LightReach,
    /// Whether camera rays that hit nothing show the environment.
    pub show_environment: bool,
    /// Light samples at a path's first vertex, where nobody asks for more.
    first_samples: u32,
    /// How much its rays go like ways.
    pub camera: Coherence,
    /// What directions from diffuse surfaces are aimed at.
    pub(super) casters: Option<&'a Casters>,
}

/// What goes with a path, whoever follows it.
pub(super) struct Company<'a, R> {
    pub sampler: &'a mut PathSampler,
    /// Light gathered so far.
    pub radiance: &'a mut Vec3,
    pub rays: &'a mut RayCounts,
    pub recorder: &'a mut R,
}

/// How the last vertex sent the path on.
#[derive(Clone, Copy)]
pub(super) struct Sent {
    /// The vertex that scattered last as a receiver of light, and the solid angle density of the ray's direction over the number of light
    /// samples there. Smooth walls that let the path go straight on do not count: light samples pass them, too. `None` for the camera and
    /// delta lobes, whose directions nothing else can sample.
    pub smooth: Option<(Receiver, f32)>,
}

/// Where a path is on its way, and what it carries.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    /// Where its ray begins.
    pub origin: Vec3,
    /// Unit vector along the ray.
    pub dir: Vec3,
    /// Share of the light along the ray that reaches the camera.
    pub throughput: Vec3,
    /// What roulette leaves out of the throughput: the (η_i/η_t)² of refraction, which comes back on leaving a body, and what aiming has
    /// multiplied weights by (`in_mixture`).
    pub eta_scale: f32,
    /// How wide the path is.
    pub cone: Cone,
    pub inside: Inside,
    pub sent: Sent,
}

impl Walk {
    /// Begins at the camera.
    pub fn new(((origin, dir), cone): ((Vec3, Vec3), Cone)) -> Self {
        let (inside, sent) = (Inside::default(), Sent { smooth: None });
        Self { origin, dir, throughput: Vec3::ONE, eta_scale: 1.0, cone, inside, sent }
    }
}

impl<'a> Course<'a> {
    pub fn new(prepared: &'a PreparedScene, settings: &'a RenderSettings, view: &View) -> Self {
        let reach = reach(settings.strategy);
        Self {
            prepared,
            settings,
            reach,
            show_environment: view.show_environment,
            first_samples: match prepared.lights.varies(reach) {
                true if shares_paths(prepared, settings) => FIRST_SAMPLES_SHARED,
                true => FIRST_SAMPLES,
                false => 1,
            },
            camera: Coherence::Camera { pixels: u64::from(view.width) * u64::from(view.height) },
            casters: aim::casters(prepared, settings),
        }
    }

    /// Light samples at a path's vertex number `depth`.
    #[inline(always)]
    pub fn light_samples(&self, depth: u32) -> u32 {
        match self.settings.light_samples {
            Some(count) => count.max(1),
            None if depth == 0 => self.first_samples,
            None => 1,
        }
    }

    /// See [`lanes_can`].
    pub fn lanes_can(&self) -> bool {
        lanes_can(self.prepared, self.settings)
    }

    /// Whether lanes can follow all paths, and find nothing but flat surfaces of one diffuse colour each.
    pub fn is_diffuse(&self) -> bool {
        self.prepared.is_diffuse && self.lanes_can()
    }

    /// Whether anything that paths may meet asks for more of them than lanes carry: a random number at a surface that lets rays pass, or
    /// the bodies that they are in.
    pub fn needs_states(&self) -> bool {
        let asks = &self.prepared.asks;
        !self.is_diffuse() || asks.covers || asks.culls || asks.walls
    }

    /// See [`shares_paths`].
    pub fn shares(&self) -> bool {
        shares_paths(self.prepared, self.settings)
    }

    /// Adds the light that a path gathers at the end of its ray, which has hit something or nothing, and sends it on from
    /// there; false: it ends. `depth` counts scattering events. The radiance is not finite where the path's weight was not.
    pub fn visit(&self, depth: u32, walk: &mut Walk, hit: Option<Hit>, with: &mut Company<impl Recorder>) -> bool {
        let Some(vertex) = self.arrive(depth, walk, hit, with) else { return false };
        if vertex.bsdf.has_smooth() && self.prepared.lights.any(self.reach) {
            let light = direct(self, depth, &vertex, (walk.inside, walk.cone), with);
            let contribution = walk.throughput * light;
            *with.radiance += contribution;
            with.recorder.note(|| PathEvent::DirectLight { radiance: light, contribution });
        }
        self.scatter(depth, walk, &vertex, with)
    }

    /// Adds the light that a path finds at the end of its ray, and gives the vertex that it scatters at, if it does.
    pub fn arrive(
        &self,
        depth: u32,
        walk: &mut Walk,
        hit: Option<Hit>,
        with: &mut Company<impl Recorder>,
    ) -> Option<Vertex> {
        let Self { prepared, settings, .. } = *self;
        let Some((hit, place)) = hit.and_then(|hit| Some((hit, Place::new(prepared, &hit, walk.dir)?))) else {
            if depth > 0 || self.show_environment {
                let light = environment(self, &walk.sent, walk.dir);
                let contribution = walk.throughput * light;
                *with.radiance += contribution;
                with.recorder.note(|| PathEvent::Environment { light, contribution });
            }
            with.recorder.note(|| PathEvent::End { why: "left the scene" });
            return None;
        };
        with.recorder.note(|| hit_event(prepared, &hit, &place));
        walk.cone = walk.cone.at(hit.t);
        walk.inside = walk.inside.met(prepared, &place);
        let transmittance = walk.inside.transmittance(prepared, hit.t);
        walk.throughput *= transmittance;
        if transmittance != Vec3::ONE {
            with.recorder.note(|| PathEvent::Absorbed { transmittance, throughput: walk.throughput });
        }
        let emitted = emission_found(prepared, &hit, place.front, &walk.sent, walk.cone.width);
        if emitted != Vec3::ZERO {
            let weight = emission_weight(self, &walk.sent, &place);
            let contribution = walk.throughput * emitted * weight;
            *with.radiance += contribution;
            with.recorder.note(|| PathEvent::Emission { radiance: emitted, weight, contribution });
        }
        if depth == settings.max_depth {
            with.recorder.note(|| PathEvent::End { why: "as deep as paths may go" });
            return None;
        }
        let sampler = &mut *with.sampler;
        if let Some(one) = walk.inside.disperse(prepared, &place, || sampler.get_1d(0, Purpose::Wavelength)) {
            let weight = Vec3::from(one.weight);
            walk.throughput *= weight;
            let (nanometres, throughput) = (one.nanometres, walk.throughput);
            with.recorder.note(|| PathEvent::Dispersed { nanometres, weight, throughput });
        }
        let index_around = walk.inside.index_around(prepared, &place);
        let vertex = Vertex::new(prepared, &hit, place, walk.dir, index_around, walk.cone.width);
        with.recorder
            .note(|| PathEvent::Surface { shading_normal: vertex.shading_normal(), lobes: vertex.bsdf.describe() });
        if vertex.bsdf.is_black() {
            with.recorder.note(|| PathEvent::End { why: "the surface scatters nothing" });
            return None;
        }
        Some(vertex)
    }

    /// Sends a path on from a vertex whose BSDF is not black; false: it ends.
    pub fn scatter(&self, depth: u32, walk: &mut Walk, vertex: &Vertex, with: &mut Company<impl Recorder>) -> bool {
        let Self { prepared, settings, .. } = *self;
        let Some((wi, outgoing, sample)) = self.direction(with.sampler, depth, vertex) else {
            with.recorder.note(|| PathEvent::End { why: "absorbed" });
            return false;
        };
        walk.throughput *= sample.weight;
        with.recorder.note(|| {
            let BsdfSample { pdf, delta, transmitted, weight, .. } = sample;
            PathEvent::Scattered { direction: wi, pdf, delta, transmitted, weight, throughput: walk.throughput }
        });
        if !walk.throughput.is_finite() {
            // Roulette would end the path here, and nobody would know.
            *with.radiance = Vec3::NAN;
            return false;
        }
        walk.eta_scale *= sample.eta_scale;
        if sample.transmitted {
            walk.inside = walk.inside.crossed(prepared, &vertex.place);
        }
        if depth + 1 >= settings.roulette_after {
            let carried = walk.throughput.max_element() / walk.eta_scale;
            let survival = (carried * SURVIVAL).min(MOST_SURVIVAL);
            // A survival of zero can only come with a throughput of zero.
            if !(with.sampler.get_1d(depth, Purpose::Roulette) < survival) {
                with.recorder.note(|| PathEvent::End { why: "Russian roulette" });
                return false;
            }
            walk.throughput /= survival;
            with.recorder.note(|| PathEvent::Roulette { survival, throughput: walk.throughput });
        }
        walk.cone = walk.cone.scattered((!sample.delta).then_some(sample.pdf));
        if !(sample.straight && prepared.filters[vertex.place.material as usize].walls) {
            let pdf = sample.pdf / self.light_samples(depth) as f32;
            walk.sent = Sent { smooth: (!sample.delta).then(|| (vertex.receiver(), pdf)) };
        }
        walk.origin = outgoing.origin;
        walk.dir = wi;
        with.rays.bounce += 1;
        true
    }
}

#[cold]
fn hit_event(prepared: &PreparedScene, hit: &Hit, place: &Place) -> PathEvent {
    let (scene, geometry) = (&prepared.scene, &prepared.geometry);
    PathEvent::Hit {
        distance: f64::from(hit.t) / prepared.frame.scale(),
        point: prepared.frame.world_point(place.point),
        mesh: scene.meshes[geometry.part(hit.triangle).mesh as usize].name.clone(),
        triangle: geometry.number_in_mesh(hit.triangle),
        material: scene.materials[place.material as usize].name.clone(),
        front: place.front,
    }
}

/// Whether lanes have the random numbers and the strategy, and no light shines through bodies.
fn lanes_can(prepared: &PreparedScene, settings: &RenderSettings) -> bool {
    let sampler = matches!(settings.sampler, SamplerKind::Sobol | SamplerKind::Pcg);
    let strategy = matches!(settings.strategy, Strategy::Bsdf | Strategy::Light | Strategy::Mis);
    sampler && strategy && !prepared.asks.tints
}

/// Whether pixels use each other's paths: where that is asked for, lanes can do it, and there is a surface that sends the same light to
/// all who see it.
pub fn shares_paths(prepared: &PreparedScene, settings: &RenderSettings) -> bool {
    settings.shares() && lanes_can(prepared, settings) && prepared.has_diffuse
}
