//! One camera path (Kajiya 1986; next-event estimation and BSDF sampling joined as in Veach 1997, section 9.2).

use super::RayCounts;
use super::medium::Inside;
use super::record::{PathEvent, Recorder};
use super::trace::{Asker, closest, visibility};
use super::vertex::{Outgoing, Place, Vertex};
use crate::geometry::emission;
use crate::lighting::{LightReach, Receiver};
use crate::math::Hit;
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::{RenderSettings, Strategy};
use crate::shading::{Baseline, BsdfSample};
use glam::Vec3;

/// Scattering events before Russian roulette begins.
const ROULETTE_AFTER: u32 = 5;
/// The most that roulette lets a path survive by. Less than 1 would make paths between nearly white walls heavier with
/// every bounce, without bound (and their variance infinite).
const MOST_SURVIVAL: f32 = 1.0;

/// Radiance along a camera ray, and whether it met the asset (its coverage).
pub(super) struct PathResult {
    pub radiance: Vec3,
    pub covered: bool,
}

/// How the last vertex sent the path on.
#[derive(Clone, Copy)]
struct Sent {
    /// The vertex as a receiver of light, and the solid angle density of the ray's direction; `None` for the camera and
    /// delta lobes, whose directions nothing else can sample.
    smooth: Option<(Receiver, f32)>,
}

/// Follows one path from `origin` along the unit vector `dir`. The radiance is not finite where the path's weight was not.
pub(super) fn trace_path(
    prepared: &PreparedScene,
    settings: &RenderSettings,
    sampler: &mut PathSampler,
    (mut origin, mut dir): (Vec3, Vec3),
    show_environment: bool,
    rays: &mut RayCounts,
    recorder: &mut impl Recorder,
) -> PathResult {
    let reach = reach(settings.strategy);
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // Without the (η_i/η_t)² of refraction, which comes back on leaving a body.
    let mut eta_scale = 1.0;
    let mut inside = Inside::default();
    let mut sent = Sent { smooth: None };
    let mut leaves = None;
    rays.camera += 1;
    for depth in 0..=settings.max_depth {
        recorder.note(|| PathEvent::Ray { depth, origin: prepared.frame.world_point(origin), direction: dir });
        let asker = Asker { sampler: *sampler, vertex: depth, draw: 0, leaves, eye: depth == 0 };
        let hit = closest(prepared, &asker, origin, dir);
        let Some((hit, place)) = hit.and_then(|hit| Some((hit, Place::new(prepared, &hit, dir)?))) else {
            if depth > 0 || show_environment {
                let light = environment(prepared, settings, reach, &sent, dir);
                radiance += throughput * light;
                recorder.note(|| PathEvent::Environment { light, contribution: throughput * light });
            }
            recorder.note(|| PathEvent::End { why: "left the scene" });
            return PathResult { radiance, covered: depth > 0 };
        };
        recorder.note(|| hit_event(prepared, &hit, &place));
        inside = inside.met(prepared, &place);
        let transmittance = inside.transmittance(prepared, hit.t);
        throughput *= transmittance;
        if transmittance != Vec3::ONE {
            recorder.note(|| PathEvent::Absorbed { transmittance, throughput });
        }
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let emitted = emission::emitted(&prepared.scene, &prepared.geometry, hit.triangle, b, place.front);
        if emitted != Vec3::ZERO {
            let weight = emission_weight(prepared, settings, reach, &sent, &place);
            radiance += throughput * emitted * weight;
            let contribution = throughput * emitted * weight;
            recorder.note(|| PathEvent::Emission { radiance: emitted, weight, contribution });
        }
        if depth == settings.max_depth {
            recorder.note(|| PathEvent::End { why: "as deep as paths may go" });
            break;
        }
        let index_around = inside.index_around(prepared, &place);
        let vertex = Vertex::new(prepared, &hit, place, dir, index_around);
        recorder.note(|| PathEvent::Surface { shading_normal: vertex.shading_normal(), lobes: vertex.bsdf.describe() });
        if vertex.bsdf.is_black() {
            recorder.note(|| PathEvent::End { why: "the surface scatters nothing" });
            break;
        }
        if vertex.bsdf.has_smooth() && prepared.lights.any(reach) {
            let light = direct(prepared, settings, reach, sampler, depth, &vertex, inside, rays, recorder);
            radiance += throughput * light;
            recorder.note(|| PathEvent::DirectLight { radiance: light, contribution: throughput * light });
        }
        let Some((wi, outgoing, sample)) = scatter(settings.strategy, sampler, depth, &vertex) else {
            recorder.note(|| PathEvent::End { why: "absorbed" });
            break;
        };
        throughput *= sample.weight;
        recorder.note(|| {
            let BsdfSample { pdf, delta, transmitted, weight, .. } = sample;
            PathEvent::Scattered { direction: wi, pdf, delta, transmitted, weight, throughput }
        });
        if !throughput.is_finite() {
            // Roulette would end the path here, and nobody would know.
            return PathResult { radiance: Vec3::NAN, covered: true };
        }
        eta_scale *= sample.eta_scale;
        if sample.transmitted {
            inside = inside.crossed(prepared, &place);
        }
        if depth + 1 >= ROULETTE_AFTER {
            let survival = (throughput.max_element() / eta_scale).min(MOST_SURVIVAL);
            // A survival of zero can only come with a throughput of zero.
            if !(sampler.get_1d(depth, Purpose::Roulette) < survival) {
                recorder.note(|| PathEvent::End { why: "Russian roulette" });
                break;
            }
            throughput /= survival;
            recorder.note(|| PathEvent::Roulette { survival, throughput });
        }
        sent = Sent { smooth: (!sample.delta).then(|| (vertex.receiver(), sample.pdf)) };
        origin = outgoing.origin;
        dir = wi;
        leaves = outgoing.leaves;
        rays.bounce += 1;
    }
    PathResult { radiance, covered: true }
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

fn reach(strategy: Strategy) -> LightReach {
    match strategy {
        Strategy::Hemisphere | Strategy::Cosine | Strategy::Bsdf => LightReach::Punctual,
        Strategy::Mis => LightReach::Mis,
        Strategy::Light => LightReach::All,
    }
}

/// A direction out of the vertex, on the side of the surface that its lobe says.
fn scatter(
    strategy: Strategy,
    sampler: &mut PathSampler,
    depth: u32,
    vertex: &Vertex,
) -> Option<(Vec3, Outgoing, BsdfSample)> {
    let (lobe, u) = (sampler.get_1d(depth, Purpose::Lobe), sampler.get_2d(depth, Purpose::Direction));
    let wo = vertex.wo_local();
    let sample = match strategy {
        Strategy::Hemisphere => vertex.bsdf.sample_baseline(wo, lobe, u, Baseline::Uniform),
        Strategy::Cosine => vertex.bsdf.sample_baseline(wo, lobe, u, Baseline::Cosine),
        Strategy::Bsdf | Strategy::Light | Strategy::Mis => vertex.bsdf.sample(wo, lobe, u),
    }?;
    let (wi, outgoing) = vertex.world_of(sample.wi)?;
    Some((wi, outgoing, sample))
}

/// Light from light samples at the path's vertex number `depth`.
#[expect(clippy::too_many_arguments, reason = "the state of a path")]
fn direct(
    prepared: &PreparedScene,
    settings: &RenderSettings,
    reach: LightReach,
    sampler: &mut PathSampler,
    depth: u32,
    vertex: &Vertex,
    inside: Inside,
    rays: &mut RayCounts,
    recorder: &mut impl Recorder,
) -> Vec3 {
    let count = settings.light_samples.max(1);
    let receiver = vertex.receiver();
    let mut sum = Vec3::ZERO;
    for k in 0..count {
        let choice = sampler.get_1d(depth, Purpose::LightChoice(k));
        let u = sampler.get_2d(depth, Purpose::LightPoint(k));
        let Some(light) = prepared.lights.sample(&prepared.scene, &prepared.geometry, &receiver, reach, choice, u)
        else {
            continue;
        };
        let Some(outgoing) = vertex.towards(light.direction) else { continue };
        let (value, bsdf_pdf) = vertex.bsdf.eval(vertex.wo_local(), outgoing.local);
        if value == Vec3::ZERO {
            continue;
        }
        rays.shadow += 1;
        let asker = Asker { sampler: *sampler, vertex: depth + 1, draw: k + 1, leaves: None, eye: false };
        let inside = if outgoing.local.z < 0.0 { inside.crossed(prepared, &vertex.place) } else { inside };
        let visible = visibility(prepared, &asker, vertex, &outgoing, inside, &light);
        let weight = match (light.pdf, settings.strategy) {
            (Some(pdf), Strategy::Mis) => balance(pdf * count as f32, bsdf_pdf),
            _ => 1.0,
        };
        let arriving = if visible == Vec3::ZERO { Vec3::ZERO } else { value * light.weight * visible * weight };
        sum += arriving;
        recorder.note(|| PathEvent::LightSample {
            direction: light.direction,
            pdf: light.pdf,
            bsdf: value,
            bsdf_pdf,
            visible,
            weight,
            contribution: arriving / count as f32,
        });
    }
    sum / count as f32
}

/// Veach's balance heuristic.
fn balance(pdf: f32, other: f32) -> f32 {
    // Neither overflows in the sum nor divides infinities, as long as one of them is finite.
    1.0 / (1.0 + other / pdf)
}

/// The share of emission found by scattering that light samples do not bring already.
fn found_weight(settings: &RenderSettings, sent: &Sent, light_pdf: impl FnOnce(&Receiver) -> f32) -> f32 {
    match (&sent.smooth, settings.strategy) {
        (None, _) | (_, Strategy::Hemisphere | Strategy::Cosine | Strategy::Bsdf) => 1.0,
        (Some(_), Strategy::Light) => 0.0,
        (Some((receiver, pdf)), Strategy::Mis) => {
            let light = light_pdf(receiver) * settings.light_samples.max(1) as f32;
            if light == 0.0 { 1.0 } else { balance(*pdf, light) }
        }
    }
}

fn emission_weight(
    prepared: &PreparedScene,
    settings: &RenderSettings,
    reach: LightReach,
    sent: &Sent,
    place: &Place,
) -> f32 {
    found_weight(settings, sent, |receiver| {
        prepared.lights.pdf_triangle(&prepared.geometry, place.triangle, receiver, place.point, reach)
    })
}

fn environment(prepared: &PreparedScene, settings: &RenderSettings, reach: LightReach, sent: &Sent, dir: Vec3) -> Vec3 {
    let Some(environment) = &prepared.lights.environment else { return Vec3::ZERO };
    let uv = environment.locate(dir);
    let weight = found_weight(settings, sent, |_| prepared.lights.pdf_environment(uv, reach));
    if weight == 0.0 { Vec3::ZERO } else { environment.radiance_at(uv) * weight }
}
