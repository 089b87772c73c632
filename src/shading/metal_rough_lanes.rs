//! glTF's metal-rough model at sixteen surface points: twin of [`super::metal_rough`] for surfaces that bound no solid.

use super::albedo::GgxAlbedoLanes;
use super::coat_lanes::ClearCoatLanes;
use super::lanes::RoughLanes;
use super::metal_rough::SMALLEST_ALPHA;
use crate::lanes::{Floats, Lanes, Mask, V3};

/// [`super::MetalRoughParams`] in lanes; all are walls without inside.
#[derive(Clone, Copy, Debug)]
pub struct MetalRoughLanes<F> {
    /// Albedo of the dielectric part, F0 of the metallic part.
    pub base_color: V3<F>,
    /// 0 dielectric … 1 metal.
    pub metallic: F,
    /// Perceptual roughness.
    pub roughness: F,
    /// Strength of the dielectric reflection.
    pub specular: F,
    /// Tints F0 of the dielectric.
    pub specular_color: V3<F>,
    /// Index of refraction; 0: everything is reflected.
    pub ior: F,
    /// Share of the diffuse part that is transmitted instead.
    pub transmission: F,
}

/// A Fresnel term: reflectances at normal and at grazing incidence.
#[derive(Clone, Copy)]
struct Term<F> {
    f0: V3<F>,
    f90: V3<F>,
}

impl<F: Floats> MetalRoughLanes<F> {
    /// The lobes seen from `wo` in the shading frames, where `active`; as [`super::Bsdf::metal_rough`], and below a clear coat as
    /// [`super::Bsdf::layered`].
    #[inline(always)]
    pub fn lobes<L: Lanes<F = F, M = F::Mask, U = F::Words>>(
        &self,
        l: L,
        wo: V3<F>,
        active: L::M,
        coat: Option<&ClearCoatLanes<F>>,
    ) -> RoughLanes<F> {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let cos_o = unit(wo.z);
        let roughness = unit(self.roughness);
        let alpha = roughness * roughness;
        let smooth = alpha.ge(l.splat(SMALLEST_ALPHA));
        let (specular, metallic, transmission) = (unit(self.specular), unit(self.metallic), unit(self.transmission));
        let not_metal = one - metallic;
        let known = self.ior.is_finite() & self.ior.gt(zero);
        let ior = self.ior.max(l.splat(1e-2)).min(l.splat(1e2)).only(known);
        let colour = unit_colour(self.base_color);
        let r = (ior - 1.0) / (ior + 1.0);
        let f0 = unit_colour(self.specular_color * (r * r)) * specular;
        let albedo = GgxAlbedoLanes::at(l, cos_o, alpha);
        let rise = schlick_weight(cos_o);
        let (dielectric, below) = compensated(&albedo, Term { f0, f90: V3::splat(specular) }, smooth, rise);
        let (metal, own) = compensated(&albedo, Term { f0: colour, f90: V3::splat(one) }, smooth, rise);
        let f0 = dielectric.f0 * not_metal + metal.f0 * metallic;
        let f90 = dielectric.f90 * not_metal + metal.f90 * metallic;
        let seen = below * not_metal + own * metallic;
        let left = (one - below.max_element()).max(zero);
        let mut diffuse = colour * (not_metal * (one - transmission) * left);
        let mut tint = colour * (not_metal * transmission * left);
        let (mut f0, mut f90, mut seen, mut above) = (f0, f90, seen, None);
        if let Some(coat) = coat {
            let (lobe, below) = coat.lobes(l, wo, active);
            (f0, f90, seen) = (f0 * below, f90 * below, seen * below);
            (diffuse, tint, above) = (diffuse * below, tint * below, Some(lobe));
        }

        let largest = V3::new(f0.x.max(f90.x), f0.y.max(f90.y), f0.z.max(f90.z));
        let reflection = luminance(seen).max(luminance(largest) * 0.01);
        let (diffuse_share, wall_share) = (luminance(diffuse), luminance(tint));
        let diffuse_share = diffuse_share.only(active & diffuse_share.gt(zero));
        let reflection = reflection.only(active & reflection.gt(zero));
        let wall_share = wall_share.only(active & wall_share.gt(zero));
        let mut total = diffuse_share + reflection + wall_share;
        if let Some(coat) = &above {
            total = total + coat.share;
        }
        let scatters = total.gt(zero);
        let total = L::F::select(scatters, total, one);
        let shares = [diffuse_share / total, reflection / total, wall_share / total];
        if let Some(coat) = &mut above {
            coat.share = coat.share / total;
        }
        let tint = V3::select(smooth, tint * (one / (albedo.a + albedo.b)), tint);
        RoughLanes {
            albedo: diffuse,
            alpha,
            f0,
            f90,
            tint,
            shares,
            rough: smooth,
            reflects: shares[1].gt(zero).any(),
            transmits: shares[2].gt(zero).any(),
            peaks: (scatters & !smooth & !(shares[1] + shares[2]).eq(zero)).any(),
            coat: above,
        }
    }
}

/// As [`super::metal_rough::Base::compensated`].
#[inline(always)]
fn compensated<F: Floats>(albedo: &GgxAlbedoLanes<F>, term: Term<F>, smooth: F::Mask, rise: F) -> (Term<F>, V3<F>) {
    let one = rise.fill(1.0);
    let white = albedo.a + albedo.b;
    let single = term.f0 * albedo.a + term.f90 * albedo.b;
    let missing = (one - white).max(one.fill(0.0)) / white;
    let f = unit_colour(single * (one / white));
    let scale = V3::new(
        multiple(f.x, albedo.mean, missing),
        multiple(f.y, albedo.mean, missing),
        multiple(f.z, albedo.mean, missing),
    );
    let scaled = Term { f0: term.f0.times(scale), f90: term.f90.times(scale) };
    let peak = term.f0 + (term.f90 - term.f0) * rise;
    let seen = scaled.f0 * albedo.a + scaled.f90 * albedo.b;
    let scaled = Term { f0: V3::select(smooth, scaled.f0, term.f0), f90: V3::select(smooth, scaled.f90, term.f90) };
    (scaled, V3::select(smooth, seen, peak))
}

/// One channel of [`super::albedo::GgxAlbedo::compensation`].
#[inline(always)]
pub(super) fn multiple<F: Floats>(f: F, mean: F, missing: F) -> F {
    let one = f.fill(1.0);
    f * mean / (one - f * (one - mean)) * missing + 1.0
}

/// As [`super::colour::unit`].
#[inline(always)]
pub(super) fn unit<F: Floats>(x: F) -> F {
    x.max(x.fill(0.0)).min(x.fill(1.0))
}

#[inline(always)]
fn unit_colour<F: Floats>(c: V3<F>) -> V3<F> {
    V3::new(unit(c.x), unit(c.y), unit(c.z))
}

#[inline(always)]
fn luminance<F: Floats>(c: V3<F>) -> F {
    c.x * 0.2126 + c.y * 0.7152 + c.z * 0.0722
}

/// As [`super::fresnel::schlick_weight`].
#[inline(always)]
pub(super) fn schlick_weight<F: Floats>(cos: F) -> F {
    let one = cos.fill(1.0);
    let m = (one - cos).max(one.fill(0.0)).min(one);
    let m2 = m * m;
    m2 * m2 * m
}
