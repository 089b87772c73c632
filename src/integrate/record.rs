//! What happened on a path, for replay; and why a sample was not finite.

use glam::{DVec3, Vec3};
use serde::Serialize;

/// Takes notes on a path. `()` takes none, at no cost.
pub(super) trait Recorder {
    /// Takes a note.
    fn note(&mut self, event: impl FnOnce() -> PathEvent);
}

impl Recorder for () {
    #[inline(always)]
    fn note(&mut self, _: impl FnOnce() -> PathEvent) {}
}

impl Recorder for Vec<PathEvent> {
    fn note(&mut self, event: impl FnOnce() -> PathEvent) {
        self.push(event());
    }
}

/// A step of a path. Points and distances in world units, directions of unit length, radiance linear RGB.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
#[allow(missing_docs, reason = "the fields say what they are; those of each event are explained with it")]
pub enum PathEvent {
    /// A ray sets out, from the camera (depth 0) or from vertex number `depth`.
    Ray { depth: u32, origin: DVec3, direction: Vec3 },
    /// It meets a surface: triangle number `triangle` of a mesh, from its front or back, under this shading normal.
    Hit { distance: f64, point: DVec3, mesh: String, triangle: u32, material: String, front: bool },
    /// A body took its share on the way.
    Absorbed { transmittance: Vec3, throughput: Vec3 },
    /// The body met disperses light: the path goes on with one wavelength.
    Dispersed { nanometres: f32, weight: Vec3, throughput: Vec3 },
    /// The surface shines by itself; `weight` is what multiple importance sampling gives this way of finding it.
    Emission { radiance: Vec3, weight: f32, contribution: Vec3 },
    /// The path leaves the scene.
    Environment { light: Vec3, contribution: Vec3 },
    /// How the surface scatters: lobes with the probability of each.
    Surface { shading_normal: Vec3, lobes: Vec<(&'static str, f32)> },
    /// A light sample, of which `visible` arrives. `contribution` is without the path's throughput.
    LightSample {
        direction: Vec3,
        pdf: Option<f32>,
        bsdf: Vec3,
        bsdf_pdf: f32,
        visible: Vec3,
        weight: f32,
        contribution: Vec3,
    },
    /// All light samples of the vertex together.
    DirectLight { radiance: Vec3, contribution: Vec3 },
    /// The surface sends the path on.
    Scattered { direction: Vec3, pdf: f32, delta: bool, transmitted: bool, weight: Vec3, throughput: Vec3 },
    /// Russian roulette.
    Roulette { survival: f32, throughput: Vec3 },
    /// The path ends.
    End { why: &'static str },
}

/// Where a sample stopped being a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// A ray or the point that it met.
    Geometry,
    /// Absorption in a body.
    Absorption,
    /// The emission of a surface or its weight.
    Emission,
    /// The environment or its weight.
    Environment,
    /// A light sample.
    LightSample,
    /// The BSDF's sample.
    Scattering,
    /// Each number was finite, but not the sum.
    Overflow,
}

impl Cause {
    /// All of them, in order.
    pub const ALL: [Self; 7] = [
        Self::Geometry,
        Self::Absorption,
        Self::Emission,
        Self::Environment,
        Self::LightSample,
        Self::Scattering,
        Self::Overflow,
    ];
}

impl PathEvent {
    /// The cause, when this is where numbers stop being finite.
    fn cause(&self) -> Option<Cause> {
        let (numbers, cause): (Vec<Vec3>, Cause) = match self {
            Self::Ray { origin, direction, .. } => (vec![origin.as_vec3(), *direction], Cause::Geometry),
            Self::Hit { point, .. } => (vec![point.as_vec3()], Cause::Geometry),
            Self::Absorbed { transmittance, throughput } => (vec![*transmittance, *throughput], Cause::Absorption),
            Self::Dispersed { weight, throughput, .. } => (vec![*weight, *throughput], Cause::Absorption),
            Self::Emission { radiance, weight, contribution } => {
                (vec![*radiance, Vec3::splat(*weight), *contribution], Cause::Emission)
            }
            Self::Environment { light, contribution } => (vec![*light, *contribution], Cause::Environment),
            Self::LightSample { bsdf, bsdf_pdf, visible, weight, contribution, .. } => {
                (vec![*bsdf, *visible, Vec3::new(*bsdf_pdf, *weight, 0.0), *contribution], Cause::LightSample)
            }
            Self::DirectLight { radiance, contribution } => (vec![*radiance, *contribution], Cause::LightSample),
            Self::Surface { shading_normal, .. } => (vec![*shading_normal], Cause::Geometry),
            Self::Scattered { weight, throughput, .. } => (vec![*weight, *throughput], Cause::Scattering),
            Self::Roulette { survival, throughput } => (vec![Vec3::splat(*survival), *throughput], Cause::Scattering),
            Self::End { .. } => return None,
        };
        numbers.iter().any(|n| !n.is_finite()).then_some(cause)
    }
}

/// Why the path of these events has no finite radiance.
pub(super) fn cause_of(events: &[PathEvent]) -> Cause {
    events.iter().find_map(PathEvent::cause).unwrap_or(Cause::Overflow)
}
