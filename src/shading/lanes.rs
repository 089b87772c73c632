//! The commonest lobes, diffuse, reflection and thin walls, for sixteen surface points at once. What it computes is that of the
//! lobes one by one ([`super::lambert`], [`super::ggx_reflection`], [`super::microfacet`]), to rounding.

use super::GRAZING;
use super::coat_lanes::CoatLanes;
use super::metal_rough_lanes::schlick_weight;
use crate::lanes::functions::{sin_cos_small, sin_cos_turns};
use crate::lanes::{Floats, V3};
use crate::math::warp::ONE_MINUS_EPSILON;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

/// The lobes of sixteen surface points: Lambert's, a reflection and a wall that lets light through, the latter two rough or
/// both smooth.
#[derive(Clone, Copy, Debug)]
pub struct RoughLanes<F: Floats> {
    /// Of the Lambert lobe.
    pub albedo: V3<F>,
    /// GGX α.
    pub alpha: F,
    /// Reflectance at normal incidence.
    pub f0: V3<F>,
    /// Reflectance at grazing incidence.
    pub f90: V3<F>,
    /// What the wall lets through.
    pub tint: V3<F>,
    /// Probabilities of the Lambert lobe, the reflection and the wall; all 0 where nothing scatters.
    pub shares: [F; 3],
    /// Where reflection and wall are rough; elsewhere they are delta distributions.
    pub rough: F::Mask,
    /// Whether any lane has the reflection at all.
    pub reflects: bool,
    /// Whether any lane has the wall.
    pub transmits: bool,
    /// Whether any lane has a delta distribution among these.
    pub peaks: bool,
    /// Above all of them, where materials may have one; chosen before the others.
    pub coat: Option<CoatLanes<F>>,
}

/// Directions of scattering.
#[derive(Clone, Copy, Debug)]
pub struct RoughSample<F: Floats> {
    /// Towards the light.
    pub wi: V3<F>,
    /// f·|cos θi| over the density.
    pub weight: V3<F>,
    /// Density over solid angle, with the choice of the lobe; for delta distributions the probability; 0 where the light is
    /// absorbed.
    pub pdf: F,
    /// Where a delta distribution made it.
    pub delta: F::Mask,
    /// Where it goes straight on through a smooth wall.
    pub straight: F::Mask,
}

impl<F: Floats> RoughLanes<F> {
    /// Lambert's lobe alone.
    #[inline(always)]
    pub fn lambert(albedo: V3<F>) -> Self {
        let (zero, one) = (albedo.x.fill(0.0), albedo.x.fill(1.0));
        Self {
            albedo,
            alpha: one,
            f0: V3::splat(zero),
            f90: V3::splat(zero),
            tint: V3::splat(zero),
            shares: [one, zero, zero],
            rough: one.gt(zero),
            reflects: false,
            transmits: false,
            peaks: false,
            coat: None,
        }
    }

    /// Nothing at all elsewhere.
    #[inline(always)]
    pub fn only(mut self, there: F::Mask) -> Self {
        if let Some(coat) = &mut self.coat {
            coat.share = coat.share.only(there);
        }
        let [diffuse, reflection, wall] = self.shares;
        self.shares = [diffuse.only(there), reflection.only(there), wall.only(there)];
        self
    }

    /// With Lambert's lobe alone at some points.
    #[inline(always)]
    pub fn or_lambert(mut self, there: F::Mask, albedo: V3<F>) -> Self {
        if let Some(coat) = &mut self.coat {
            coat.share = coat.share.only(!there);
        }
        let (zero, one) = (albedo.x.fill(0.0), albedo.x.fill(1.0));
        let [diffuse, reflection, wall] = self.shares;
        Self {
            albedo: V3::select(there, albedo, self.albedo),
            alpha: F::select(there, one, self.alpha),
            shares: [F::select(there, one, diffuse), F::select(there, zero, reflection), F::select(there, zero, wall)],
            rough: self.rough | there,
            ..self
        }
    }

    /// Where anything scatters.
    #[inline(always)]
    pub fn scatters(&self) -> F::Mask {
        let [diffuse, reflection, wall] = self.shares;
        (diffuse + reflection + wall).gt(diffuse.fill(0.0)) | self.coated()
    }

    /// Where there is a clear coat.
    #[inline(always)]
    pub fn coated(&self) -> F::Mask {
        match &self.coat {
            Some(coat) => coat.there(),
            None => self.alpha.lt(self.alpha),
        }
    }

    /// Whether there is more than Lambert's lobe to choose from anywhere.
    #[inline(always)]
    pub fn chooses(&self) -> bool {
        self.reflects | self.transmits | self.coat.is_some()
    }

    /// Where some lobe is no delta distribution, so that sampling lights makes sense.
    #[inline(always)]
    pub fn has_smooth(&self) -> F::Mask {
        let zero = self.alpha.fill(0.0);
        let [diffuse, reflection, wall] = self.shares;
        let below = diffuse.gt(zero) | self.rough & (reflection + wall).gt(zero);
        match &self.coat {
            Some(coat) => below | coat.rough & coat.there(),
            None => below,
        }
    }

    /// Where a lobe that is no delta distribution sends light through the surface.
    #[inline(always)]
    pub fn transmits_smoothly(&self) -> F::Mask {
        self.rough & self.shares[2].gt(self.alpha.fill(0.0))
    }

    /// f·|cos θi| of the lobes that are no delta distributions, and the density over solid angle with which
    /// [`Self::sample`] makes `wi` by them.
    #[inline(always)]
    pub fn eval(&self, wo: V3<F>, wi: V3<F>) -> (V3<F>, F) {
        let zero = wo.z.fill(0.0);
        let least = wo.z.fill(GRAZING);
        let seen = wo.z.ge(least) & wi.z.abs().ge(least);
        let lambert = wi.z.max(zero) * FRAC_1_PI;
        let (mut value, mut density) = (self.albedo * lambert, self.shares[0] * lambert);
        if self.reflects | self.transmits {
            // The wall is the reflection turned to the other side.
            let up = wi.z.gt(zero);
            let (ggx, rise, pdf) = microfacets(self.alpha, wo, V3::new(wi.x, wi.y, wi.z.abs()));
            let fresnel = self.f0 + (self.f90 - self.f0) * rise;
            let colour = if self.transmits { V3::select(up, fresnel, self.tint) } else { fresnel.only(up) };
            let share = F::select(up, self.shares[1], self.shares[2]);
            let has = self.rough & share.gt(zero);
            value = value + (colour * ggx).only(has);
            density = density + (share * pdf).only(has);
        }
        if let Some(coat) = &self.coat {
            let (own, pdf) = coat.eval(wo, wi);
            value = value + V3::splat(own);
            density = density + pdf;
        }
        (value.only(seen), density.only(seen))
    }

    /// Directions for `u_lobe` (which matters only if [`Self::chooses`]) and `u` in [0, 1).
    #[inline(always)]
    pub fn sample(&self, wo: V3<F>, u_lobe: F, u: [F; 2]) -> RoughSample<F> {
        let (zero, one) = (wo.z.fill(0.0), wo.z.fill(1.0));
        let mut wi = cosine_hemisphere(u);
        let never = one.lt(zero);
        let (mut peak, mut wall, mut absorbed, mut above) = (never, never, never, never);
        if self.reflects | self.transmits {
            let [diffuse, reflection, through] = self.shares;
            let mut other = !u_lobe.lt(diffuse) | !diffuse.gt(zero);
            wall = other & through.gt(zero) & (!u_lobe.lt(diffuse + reflection) | !reflection.gt(zero));
            if let Some(coat) = &self.coat {
                // Among layers the reflection comes first.
                let coated = coat.layered;
                let left = u_lobe - coat.share;
                let mirrors = left.lt(reflection) & reflection.gt(zero);
                let spreads = !mirrors & diffuse.gt(zero) & (left.lt(reflection + diffuse) | !through.gt(zero));
                other = coated & !spreads | other & !coated;
                wall = coated & !spreads & !mirrors & through.gt(zero) | wall & !coated;
            }
            let h = visible_normal(self.alpha, wo, u);
            let reflected = (h * (wo.dot(h) * 2.0) - wo).normalized();
            absorbed = other & self.rough & reflected.z.le(zero);
            let turned = V3::new(reflected.x, reflected.y, F::select(wall, -reflected.z, reflected.z));
            wi = V3::select(other, turned, wi);
            if self.peaks {
                peak = other & !self.rough;
                let mirrored = V3::new(-wo.x, -wo.y, F::select(wall, -wo.z, wo.z));
                wi = V3::select(peak, mirrored, wi);
            }
        }
        if let Some(coat) = &self.coat {
            let [diffuse, reflection, through] = self.shares;
            above = coat.there() & (u_lobe.lt(coat.share) | !(diffuse + reflection + through).gt(zero));
            let (own, lost) = coat.sample(wo, u);
            let mirror = above & !coat.rough;
            wi = V3::select(above, V3::select(mirror, V3::new(-wo.x, -wo.y, wo.z), own), wi);
            absorbed = above & !mirror & lost | absorbed & !above;
            peak = mirror | peak & !above;
        }
        let (value, pdf) = self.eval(wo, wi);
        let mut sample =
            RoughSample { wi, weight: value * (one / pdf), pdf, delta: peak, straight: peak & wall & !above };
        if self.peaks | self.coat.is_some() {
            let fresnel = self.f0 + (self.f90 - self.f0) * schlick_weight(wo.z);
            let mut share = F::select(wall, self.shares[2], self.shares[1]);
            let mut value = V3::select(wall, self.tint, fresnel);
            if let Some(coat) = &self.coat {
                share = F::select(above, coat.share, share);
                value = V3::select(above, V3::splat(coat.mirrored(wo)), value);
            }
            sample.pdf = F::select(peak, share.only(wo.z.ge(wo.z.fill(GRAZING))), pdf);
            sample.weight = V3::select(peak, value * (one / share), sample.weight);
        }
        sample.pdf = F::select(absorbed, zero, sample.pdf);
        sample
    }
}

/// D G2 / (4 cos θo), the share of Fresnel's term that rises, and the density of a rough reflection, both directions above the surface.
#[inline(always)]
pub(super) fn microfacets<F: Floats>(alpha: F, wo: V3<F>, wi: V3<F>) -> (F, F, F) {
    let one = wo.z.fill(1.0);
    let h = (wo + wi).normalized();
    let a2 = alpha * alpha;
    let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    let distribution = (a2 * FRAC_1_PI / (d * d)).only(h.z.gt(one.fill(0.0)));
    let (stretched_o, stretched_i) = (stretched(a2, wo), stretched(a2, wi));
    let shadowing = one.fill(2.0) / (wo.z * stretched_i + wi.z * stretched_o);
    let scalar = distribution * shadowing * wi.z * 0.25;
    let pdf = distribution * 0.5 / (wo.z + stretched_o);
    (scalar, schlick_weight(wo.dot(h)), pdf)
}

/// Dupuy & Benyoub 2023, as [`super::microfacet::sample_visible_normal`].
#[inline(always)]
pub(super) fn visible_normal<F: Floats>(alpha: F, wo: V3<F>, u: [F; 2]) -> V3<F> {
    let one = wo.z.fill(1.0);
    let std = V3::new(wo.x * alpha, wo.y * alpha, wo.z).normalized();
    let u0 = u[0].min(one.fill(ONE_MINUS_EPSILON));
    let z = (one - u0) * (std.z + 1.0) - std.z;
    let sin = (one - z * z).max(one.fill(0.0)).sqrt();
    let (sin_phi, cos_phi) = sin_cos_turns(u[1]);
    let h = V3::new(sin * cos_phi, sin * sin_phi, z) + std;
    V3::new(h.x * alpha, h.y * alpha, h.z.max(one.fill(1e-7))).normalized()
}

/// [`super::microfacet::stretched`], with α².
#[inline(always)]
fn stretched<F: Floats>(a2: F, w: V3<F>) -> F {
    (w.z * w.z + a2 * (w.x * w.x + w.y * w.y)).sqrt()
}

/// A direction by the cosine, by the concentric map: [`crate::math::warp::cosine_hemisphere`].
#[inline(always)]
fn cosine_hemisphere<F: Floats>(u: [F; 2]) -> V3<F> {
    let zero = u[0].fill(0.0);
    let (x, y) = (u[0] * 2.0 - 1.0, u[1] * 2.0 - 1.0);
    let flat = x.abs().gt(y.abs());
    let (long, short) = (F::select(flat, x, y), F::select(flat, y, x));
    let ratio = F::select(long.eq(zero), zero, short / long);
    let (sin, cos) = sin_cos_small(ratio * FRAC_PI_4);
    // cos(π/2 − θ) is sin θ.
    let px = long * F::select(flat, cos, sin);
    let py = long * F::select(flat, sin, cos);
    V3::new(px, py, (zero.fill(1.0) - px * px - py * py).max(zero).sqrt())
}

#[cfg(test)]
#[path = "lanes_tests.rs"]
mod tests;
