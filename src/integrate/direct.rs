//! Light at a path's vertices, and how light samples and scattering share it (Veach 1997, section 9.2).

use super::cone::Cone;
use super::medium::Inside;
use super::record::{PathEvent, Recorder};
use super::trace::{Asker, Walls, visibility};
use super::vertex::{Place, Vertex, footprint};
use super::walk::{Company, Course, Sent};
use crate::geometry::emission;
use crate::lanes::Floats;
use crate::lighting::{LightReach, Receiver};
use crate::math::Hit;
use crate::prepare::PreparedScene;
use crate::sampling::Purpose;
use crate::settings::Strategy;
use glam::Vec3;

/// Which lights a strategy samples.
pub(super) fn reach(strategy: Strategy) -> LightReach {
    match strategy {
        Strategy::Hemisphere | Strategy::Cosine | Strategy::Bsdf => LightReach::Punctual,
        Strategy::Mis => LightReach::Mis,
        Strategy::Light => LightReach::All,
    }
}

/// Light from light samples at the path's vertex number `depth`.
pub(super) fn direct(
    course: &Course,
    depth: u32,
    vertex: &Vertex,
    (inside, cone): (Inside, Cone),
    with: &mut Company<impl Recorder>,
) -> Vec3 {
    let Course { prepared, settings, reach, .. } = *course;
    let count = course.light_samples(depth);
    let receiver = vertex.receiver();
    let mut sum = Vec3::ZERO;
    for k in 0..count {
        let mut sampler = with.sampler.split(k, count);
        let choice = sampler.get_1d(depth, Purpose::LightChoice);
        let u = sampler.get_2d(depth, Purpose::LightPoint);
        with.sampler.follow(&sampler);
        let Some(light) = prepared.lights.sample(&prepared.scene, &prepared.geometry, &receiver, reach, choice, u)
        else {
            continue;
        };
        let Some(outgoing) = vertex.towards(light.direction) else { continue };
        let (value, bsdf_pdf) = vertex.bsdf.eval(vertex.wo_local(), outgoing.local);
        if value == Vec3::ZERO {
            continue;
        }
        with.rays.shadow += 1;
        let asker = Asker { sampler: *with.sampler, vertex: depth + 1, draw: k + 1, eye: false };
        let inside = if outgoing.local.z < 0.0 { inside.crossed(prepared, &vertex.place) } else { inside };
        let walls = Walls { cone: cone.scattered(Some(bsdf_pdf)), most: settings.max_depth.saturating_sub(depth + 1) };
        let visible = visibility(prepared, &asker, vertex, &outgoing, inside, &light, walls);
        let weight = match (light.pdf, settings.strategy) {
            (Some(pdf), Strategy::Mis) => power_heuristic(pdf, bsdf_pdf / count as f32),
            _ => 1.0,
        };
        let arriving = if visible == Vec3::ZERO { Vec3::ZERO } else { value * light.weight * visible * weight };
        sum += arriving;
        with.recorder.note(|| PathEvent::LightSample {
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

/// Veach's power heuristic with the exponent 2 (1997, section 9.2.4): where one density is much the higher one, as towards a
/// small light, the other way of finding the light adds little noise.
pub(super) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // Neither overflows in the sum nor divides infinities, as long as one of them is finite.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// [`power_heuristic`] in lanes.
#[inline(always)]
pub(super) fn power_heuristic_lanes<F: Floats>(pdf: F, other: F) -> F {
    let ratio = other / pdf;
    pdf.fill(1.0) / (ratio * ratio + 1.0)
}

/// The share of light found by scattering that light samples do not bring already.
fn found_weight(course: &Course, sent: &Sent, light_pdf: impl FnOnce(&Receiver) -> f32) -> f32 {
    match (&sent.smooth, course.settings.strategy) {
        (None, _) | (_, Strategy::Hemisphere | Strategy::Cosine | Strategy::Bsdf) => 1.0,
        (Some(_), Strategy::Light) => 0.0,
        (Some((receiver, pdf)), Strategy::Mis) => {
            let light = light_pdf(receiver);
            if light == 0.0 { 1.0 } else { power_heuristic(*pdf, light) }
        }
    }
}

/// The share of the light that a path finds at a surface which counts.
pub(super) fn emission_weight(course: &Course, sent: &Sent, place: &Place) -> f32 {
    let Course { prepared, reach, .. } = *course;
    found_weight(course, sent, |receiver| {
        prepared.lights.pdf_triangle(&prepared.geometry, place.triangle, receiver, place.point, reach)
    })
}

/// Radiance that a path finds at its hit. What nothing but this path can find is seen as wide as the path is there; what light
/// samples bring as well is read from the full image, as they do: both have to tell of the same light.
pub(super) fn emission_found(prepared: &PreparedScene, hit: &Hit, front: bool, sent: &Sent, width: f32) -> Vec3 {
    let (scene, geometry) = (&prepared.scene, &prepared.geometry);
    let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
    match sent.smooth {
        Some(_) => emission::emitted(scene, geometry, hit.triangle, b, front),
        None => emission::seen(scene, geometry, &prepared.pyramids, (hit.triangle, b, front), || {
            footprint(prepared, hit.triangle, width)
        }),
    }
}

/// Light from beyond the scene that a path finds.
pub(super) fn environment(course: &Course, sent: &Sent, dir: Vec3) -> Vec3 {
    let Course { prepared, reach, .. } = *course;
    let Some(environment) = &prepared.lights.environment else { return Vec3::ZERO };
    let uv = environment.locate(dir);
    let weight = found_weight(course, sent, |_| prepared.lights.pdf_environment(uv, reach));
    if weight == 0.0 { Vec3::ZERO } else { environment.radiance_at(uv) * weight }
}
