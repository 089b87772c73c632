//! A rough interface between two dielectrics of GGX microfacets: Walter et al. 2007, with visible normals.

use super::colour::luminance;
use super::fresnel::{Interface, Split};
use super::microfacet as mf;
use glam::Vec3;

/// The microfacet normal that takes `wo` (z > 0) to `wi`, and |wo + η wi| where it is refracted.
#[inline]
fn half_vector(eta: f32, wo: Vec3, wi: Vec3) -> Option<(Vec3, f32)> {
    if wi.z > 0.0 {
        return Some((mf::reflection_half(wo, wi), 0.0));
    }
    let sum = wo + wi * eta;
    let length = sum.length();
    if length == 0.0 {
        return None;
    }
    let h = sum * (1f32.copysign(sum.z) / length);
    // Facets seen from behind neither shadow nor refract (Walter et al. 2007, section 5.1).
    (wo.dot(h) > 0.0 && wi.dot(h) < 0.0).then_some((h, length))
}

/// Probability of choosing the reflection.
#[inline]
fn reflect_probability(split: &Split) -> f32 {
    let (r, t) = (luminance(split.reflected), luminance(split.transmitted));
    if r + t > 0.0 { r / (r + t) } else { 1.0 }
}

/// f·|cos θi|, on both sides; the refracted part carries the (η_i/η_t)² of radiance.
#[inline]
pub fn eval(alpha: f32, interface: &Interface, wo: Vec3, wi: Vec3) -> Vec3 {
    let Some((h, length)) = half_vector(interface.eta, wo, wi) else { return Vec3::ZERO };
    let split = interface.split(wo.dot(h));
    let d = mf::distribution(alpha, h);
    if wi.z > 0.0 {
        return split.reflected * (0.25 * d * mf::shadowing_over_cosines(alpha, wo, wi) * wi.z);
    }
    // Equation 21: |wi·h| |wo·h| η_t² D G T / (cos θo (η_i wo·h + η_t wi·h)²), less the η_t²/η_i² of radiance.
    let g = mf::transmission_shadowing_over_cosines(alpha, wo, wi) * -wi.z;
    split.transmitted * (d * g * -wi.dot(h) * wo.dot(h) / (length * length))
}

/// Density of [`sample`], 1/sr.
#[inline]
pub fn pdf(alpha: f32, interface: &Interface, wo: Vec3, wi: Vec3) -> f32 {
    let Some((h, length)) = half_vector(interface.eta, wo, wi) else { return 0.0 };
    let reflect = reflect_probability(&interface.split(wo.dot(h)));
    if wi.z > 0.0 {
        return reflect * 0.25 * mf::distribution(alpha, h) * mf::masking_over_cos(alpha, wo);
    }
    // Equation 17: dω_h/dω_i = η_t² |wi·h| / (η_i wo·h + η_t wi·h)².
    let eta = interface.eta;
    let jacobian = eta * eta * -wi.dot(h) / (length * length);
    (1.0 - reflect) * mf::visible_normal_pdf(alpha, wo, h) * jacobian
}

/// Reflects or refracts at a visible normal; `None` when the direction ends on the wrong side.
#[inline]
pub fn sample(alpha: f32, interface: &Interface, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Vec3> {
    let h = mf::sample_visible_normal(alpha, wo, u);
    let cos = wo.dot(h);
    let split = interface.split(cos);
    if u_choice < reflect_probability(&split) {
        let wi = mf::reflect(wo, h);
        return (wi.z > 0.0).then_some(wi);
    }
    let inverse_eta = 1.0 / interface.eta;
    let wi = (h * (cos * inverse_eta - split.cos_t) - wo * inverse_eta).normalize();
    (wi.z < 0.0).then_some(wi)
}
