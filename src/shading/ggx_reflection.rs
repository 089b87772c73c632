//! Reflection from a rough surface of GGX microfacets, single scattering (Walter et al. 2007, equation 20).

use super::fresnel::Schlick;
use super::microfacet as mf;
use glam::Vec3;

/// f·|cos θi| = F D G2 / (4 cos θo); 0 unless both directions are above the surface.
#[inline]
pub fn eval(alpha: f32, fresnel: &Schlick, wo: Vec3, wi: Vec3) -> Vec3 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return Vec3::ZERO;
    }
    let h = mf::reflection_half(wo, wi);
    let scalar = 0.25 * mf::distribution(alpha, h) * mf::shadowing_over_cosines(alpha, wo, wi) * wi.z;
    fresnel.at(wo.dot(h)) * scalar
}

/// Density of [`sample`], 1/sr: D(h) G1(wo) / (4 cos θo).
#[inline]
pub fn pdf(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    let h = mf::reflection_half(wo, wi);
    0.25 * mf::distribution(alpha, h) * mf::masking_over_cos(alpha, wo)
}

/// A reflection about a visible normal; `None` when it goes below the surface (the light would bounce again among the
/// microfacets, which single scattering leaves out).
#[inline]
pub fn sample(alpha: f32, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let wi = mf::reflect(wo, mf::sample_visible_normal(alpha, wo, u));
    (wi.z > 0.0).then_some(wi)
}
