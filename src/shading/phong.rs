//! The material of `.ray` files as energy-conserving lobes.

use super::Bsdf;
use super::colour::unit_colour;
use super::fresnel::{Interface, Schlick, dielectric_f0};
use super::lobe::Lobe;
use super::metal_rough::reflection_lobe;
use glam::Vec3;

/// `.ray` terms at a point, textures already looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongParams {
    /// k_d, albedo of the Lambert lobe.
    pub diffuse: Vec3,
    /// k_s of the highlight k_s · cosⁿ.
    pub specular: Vec3,
    /// n, the Phong exponent.
    pub exponent: f32,
    /// k_r, weight of a perfect mirror.
    pub mirror: Vec3,
    /// k_t; not black makes the surface that of a refracting body (the absorption inside is not done here).
    pub transmission: Vec3,
    /// What the surface itself lets through of what enters or leaves the body; white where k_t counts lengths.
    pub through: Vec3,
    /// Index of refraction inside; what is not positive counts as 1.
    pub ior: f32,
    /// Whether wo is on the outside (the geometric front).
    pub entering: bool,
}

impl Bsdf {
    /// The `.ray` model.
    ///
    /// The highlight k_s·cosⁿ (without cosine or normalisation) reflects 2 k_s/(n+1) of what its light sends, which
    /// becomes the albedo of a GGX lobe of α = √(2/(n+2)) (the width of the Phong lobe: Walter et al. 2007, section
    /// 5.2). A body with k_t has a smooth interface with Fresnel's reflectance; k_r gives the hue of what it reflects
    /// on the outside, not the strength. Where the terms together would give more light than they get, all are scaled.
    pub fn phong(p: &PhongParams, cos_o: f32) -> Self {
        let n = p.exponent.max(0.0);
        let k_d = p.diffuse.max(Vec3::ZERO);
        let k_r = p.mirror.max(Vec3::ZERO);
        let highlight = unit_colour(p.specular * (2.0 / (n + 1.0)));
        let is_body = p.transmission.max_element() > 0.0;

        let body = if is_body { Vec3::ONE } else { Vec3::ZERO };
        let mirror = if is_body { Vec3::ZERO } else { k_r };
        let total = k_d + highlight + mirror + body;
        let scale = Vec3::ONE / total.max(Vec3::ONE);

        let mut bsdf = Self::BLACK;
        bsdf.push(Lobe::Lambert { albedo: unit_colour(k_d * scale) }, cos_o);
        let alpha = (2.0 / (n + 2.0)).sqrt();
        bsdf.push(reflection_lobe(alpha, Schlick::constant(highlight * scale)), cos_o);
        bsdf.push(Lobe::Mirror { fresnel: Schlick::constant(unit_colour(mirror * scale)) }, cos_o);
        if is_body {
            let ior = if p.ior.is_finite() && p.ior > 0.0 { p.ior.clamp(1e-2, 1e2) } else { 1.0 };
            let eta = if p.entering { ior } else { 1.0 / ior };
            let strongest = k_r.max_element();
            let hue = if p.entering && strongest > 0.0 { unit_colour(k_r / strongest) } else { Vec3::ONE };
            let through = unit_colour(p.through);
            let interface = Interface {
                eta,
                f0: Vec3::splat(dielectric_f0(eta)),
                f90: 1.0,
                reflect: scale * hue,
                transmit: scale * through,
            };
            bsdf.push(Lobe::Dielectric { interface }, cos_o);
        }
        bsdf.normalised()
    }
}
