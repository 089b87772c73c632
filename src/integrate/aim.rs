//! Where paths go on to: by the BSDF, or aimed at bodies that cast caustics.

use super::vertex::{Outgoing, Vertex};
use super::walk::{Course, shares_paths};
use crate::lighting::Receiver;
use crate::lighting::casters::{Casters, Cones};
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::{Caustics, RenderSettings, Strategy};
use crate::shading::{Baseline, BsdfSample};
use glam::Vec3;

/// What the paths of a picture are aimed at. None are where pixels use each other's paths, since those ask what density a path of another's
/// would have had as theirs.
pub(super) fn casters<'a>(prepared: &'a PreparedScene, settings: &RenderSettings) -> Option<&'a Casters> {
    let aimed = settings.caustics == Caustics::Aimed && settings.strategy == Strategy::Mis;
    let some = aimed && !prepared.casters.is_empty() && !shares_paths(prepared, settings);
    some.then_some(&prepared.casters)
}

impl<'a> Course<'a> {
    /// What directions from a path's vertex number `depth` are aimed at, if anything is: through a body the path comes by way of two more
    /// vertices.
    #[inline(always)]
    pub fn casters(&self, depth: u32) -> Option<&'a Casters> {
        self.casters.filter(|_| depth + 2 < self.settings.max_depth)
    }

    /// A direction out of the vertex, on the side of the surface that its lobe says.
    pub(super) fn direction(
        &self,
        sampler: &mut PathSampler,
        depth: u32,
        vertex: &Vertex,
    ) -> Option<(Vec3, Outgoing, BsdfSample)> {
        let (lobe, u) = (sampler.get_1d(depth, Purpose::Lobe), sampler.get_2d(depth, Purpose::Direction));
        let (bsdf, wo) = (&vertex.bsdf, vertex.wo_local());
        let cones = self.casters(depth).and_then(|casters| {
            let Receiver { point, normal, .. } = vertex.receiver();
            casters.seen(point, normal, bsdf.diffuse_share())
        });
        let u = match cones.map_or(Err(u), |cones| cones.sample(u)) {
            Ok(wi) => {
                let outgoing = vertex.towards(wi)?;
                let (value, pdf) = bsdf.eval(wo, outgoing.local);
                let sample = bsdf.smooth_sample(outgoing.local, value, pdf)?;
                return Some((wi, outgoing, in_mixture(sample, cones.as_ref(), wi)));
            }
            Err(own) => own,
        };
        let sample = match self.settings.strategy {
            Strategy::Hemisphere => bsdf.sample_baseline(wo, lobe, u, Baseline::Uniform),
            Strategy::Cosine => bsdf.sample_baseline(wo, lobe, u, Baseline::Cosine),
            Strategy::Bsdf | Strategy::Light | Strategy::Mis => bsdf.sample(wo, lobe, u),
        }?;
        let (wi, outgoing) = vertex.world_of(sample.wi)?;
        Some((wi, outgoing, in_mixture(sample, cones.as_ref(), wi)))
    }
}

/// A sample of the BSDF's with the weight that it has where part of the directions are aimed. Its density stays the BSDF's: light samples and
/// scattering share light by it, which they may by any density as long as both mean the same one. Roulette goes by the weight without.
fn in_mixture(mut sample: BsdfSample, cones: Option<&Cones>, direction: Vec3) -> BsdfSample {
    if let Some(cones) = cones {
        let ratio = if sample.delta { cones.whole() } else { cones.ratio(direction, sample.pdf) };
        sample.weight *= ratio;
        sample.eta_scale *= ratio;
    }
    sample
}
