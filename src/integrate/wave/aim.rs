//! [`crate::integrate::aim`] for sixteen paths at once.

use super::surface::Surface;
use crate::integrate::walk::Course;
use crate::lanes::{Floats, Lanes, Mask, V3};
use crate::lighting::ConesLanes;
use crate::shading::{RoughLanes, RoughSample};

/// Which of sixteen directions are aimed.
pub(super) struct Aim<L: Lanes> {
    cones: ConesLanes<L>,
    /// Where part of the directions are aimed, and where this one is.
    there: L::M,
    chosen: L::M,
    aimed: V3<L::F>,
}

impl<L: Lanes> Aim<L> {
    /// At a path's vertex number `depth`, where the diffuse lobe is chosen with the probability `share`, by numbers `u` in [0, 1), which become
    /// those that the BSDF's own directions are made of. `None`: all are the BSDF's.
    #[inline(always)]
    pub fn new(
        l: L,
        course: &Course,
        depth: u32,
        surface: &Surface<L>,
        share: L::F,
        u: &mut [L::F; 2],
    ) -> Option<Self> {
        let cones = course.casters(depth)?.seen_lanes(l, surface.point, surface.frame.z, share);
        let there = cones.there(l);
        if there.none() {
            return None;
        }
        let (chosen, aimed, own) = cones.sample(l, *u);
        *u = own;
        Some(Self { cones, there, chosen, aimed })
    }

    /// The samples with those that are aimed among them, their directions in the world, and what weights have been multiplied by.
    #[inline(always)]
    pub fn mixed(
        &self,
        l: L,
        surface: &Surface<L>,
        lobes: &RoughLanes<L::F>,
        mut sample: RoughSample<L::F>,
    ) -> (RoughSample<L::F>, V3<L::F>, L::F) {
        let (zero, one): (L::F, L::F) = (l.splat(0.0), l.splat(1.0));
        let Self { cones, there, chosen, aimed } = *self;
        let local = surface.frame.to_local(aimed);
        let (value, density) = lobes.eval(surface.wo, local);
        let wi = V3::select(chosen, aimed, surface.frame.to_world(sample.wi));
        sample.wi = V3::select(chosen, local, sample.wi);
        sample.weight = V3::select(chosen, value * (one / density), sample.weight);
        sample.pdf = L::F::select(chosen, density, sample.pdf);
        sample.delta = sample.delta & !chosen;
        sample.straight = sample.straight & !chosen;
        let ratio = L::F::select(sample.delta, cones.whole(), cones.ratio(l, wi, sample.pdf));
        // Where nothing is aimed the weights stay as they are to the bit.
        let ratio = L::F::select(there & sample.pdf.gt(zero), ratio, one);
        sample.weight = sample.weight * ratio;
        (sample, wi, ratio)
    }
}
