//! Clear coats at sixteen surface points: what [`super::layered`] makes of them, rough or mirrors, with normals of their own or not.

use super::albedo::GgxAlbedoLanes;
use super::coat::F0;
use super::lanes::{microfacets, visible_normal};
use super::metal_rough::SMALLEST_ALPHA;
use super::metal_rough_lanes::{multiple, schlick_weight, unit};
use crate::lanes::{Floats, FrameLanes, Lanes, V3};

/// Clear coats, textures already looked up.
#[derive(Clone, Copy, Debug)]
pub struct ClearCoatLanes<F: Floats> {
    /// In [0, 1]; 0 where there is none.
    pub strength: F,
    /// Perceptual roughness.
    pub roughness: F,
    /// Unit normals in the shading frames, on the viewer's side.
    pub normal: V3<F>,
    /// Where the normal is the coat's own: such coats are never mirrors.
    pub own: F::Mask,
    /// Where the material has layers, whether or not they have any strength here: the order of the lobes goes by that.
    pub layered: F::Mask,
}

/// The lobes of clear coats.
#[derive(Clone, Copy, Debug)]
pub struct CoatLanes<F: Floats> {
    alpha: F,
    /// Reflectance at normal and at grazing incidence.
    f0: F,
    f90: F,
    frame: FrameLanes<F>,
    /// Where the coat is rough; elsewhere it is a mirror.
    pub(super) rough: F::Mask,
    pub(super) layered: F::Mask,
    /// Probability of the lobe, 0 where there is none; at first its importance.
    pub(super) share: F,
}

impl<F: Floats> ClearCoatLanes<F> {
    /// The lobes seen from `wo` where `active`, their shares still importances; and what is left of light below.
    #[inline(always)]
    pub(super) fn lobes<L: Lanes<F = F, M = F::Mask, U = F::Words>>(
        &self,
        l: L,
        wo: V3<F>,
        active: L::M,
    ) -> (CoatLanes<F>, F) {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (strength, roughness) = (unit(self.strength), unit(self.roughness));
        let cos = wo.dot(self.normal);
        let there = active & strength.gt(zero) & cos.gt(zero);
        let alpha = roughness * roughness;
        let smallest = l.splat(SMALLEST_ALPHA);
        let alpha = F::select(self.own, alpha.max(smallest), alpha);
        let rough = alpha.ge(smallest);
        let (f0, f90) = (strength * F0, strength);
        let table = GgxAlbedoLanes::at(l, cos, alpha);
        let white = table.a + table.b;
        let single = f0 * table.a + f90 * table.b;
        let missing = (one - white).max(zero) / white;
        let scale = F::select(rough, multiple(unit(single / white), table.mean, missing), one);
        let albedo = F::select(rough, single * scale, f0 + (f90 - f0) * schlick_weight(cos));
        let (f0, f90) = (f0 * scale, f90 * scale);
        let share = albedo.max(f0.max(f90) * 0.01).only(there);
        let left = F::select(there, (one - albedo).max(zero), one);
        let (frame, layered) = (FrameLanes::from_normal(self.normal), self.layered);
        (CoatLanes { alpha, f0, f90, frame, rough, layered, share }, left)
    }
}

impl<F: Floats> CoatLanes<F> {
    /// Where there is a coat.
    #[inline(always)]
    pub fn there(&self) -> F::Mask {
        self.share.gt(self.share.fill(0.0))
    }

    /// f·|cos θi| and the density, the choice of the lobe included, of those that are no mirrors.
    #[inline(always)]
    pub fn eval(&self, wo: V3<F>, wi: V3<F>) -> (F, F) {
        let zero = wo.z.fill(0.0);
        let (out, into) = (self.frame.to_local(wo), self.frame.to_local(wi));
        let lit = self.there() & self.rough & wi.z.gt(zero) & into.z.gt(zero);
        let (scalar, rise, pdf) = microfacets(self.alpha, out, into);
        let value = (self.f0 + (self.f90 - self.f0) * rise) * scalar;
        (value.only(lit), (self.share * pdf).only(lit))
    }

    /// Directions for `u` in [0, 1), and where the light is absorbed.
    #[inline(always)]
    pub fn sample(&self, wo: V3<F>, u: [F; 2]) -> (V3<F>, F::Mask) {
        let zero = wo.z.fill(0.0);
        let out = self.frame.to_local(wo);
        let h = visible_normal(self.alpha, out, u);
        let into = (h * (out.dot(h) * 2.0) - out).normalized();
        let wi = self.frame.to_world(into).normalized();
        (wi, into.z.le(zero) | wi.z.le(zero))
    }

    /// What mirrors reflect of light along the normal's side of `wo`.
    #[inline(always)]
    pub fn mirrored(&self, wo: V3<F>) -> F {
        self.f0 + (self.f90 - self.f0) * schlick_weight(wo.z)
    }
}
