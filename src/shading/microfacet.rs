//! The isotropic GGX (Trowbridge–Reitz) distribution of microfacet normals and Smith's masking.

use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// D(h), 1/sr. Written with sin²θ = x² + y², not with 1 − z² or α² − 1, so that small α keep their digits (Walter et
/// al. 2007, equation 33).
#[inline]
pub fn distribution(alpha: f32, h: Vec3) -> f32 {
    if h.z <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    a2 * FRAC_1_PI / (d * d)
}

/// √(cos² + α² sin²) of a direction: the stretched length from which Smith's terms are made.
#[inline]
pub fn stretched(alpha: f32, w: Vec3) -> f32 {
    (w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y)).sqrt()
}

/// Smith's masking over the cosine, G1(w)/|cos θ|, which stays finite at grazing angles.
#[inline]
pub fn masking_over_cos(alpha: f32, w: Vec3) -> f32 {
    2.0 / (w.z.abs() + stretched(alpha, w))
}

/// Height-correlated masking and shadowing over both cosines, G2(wo, wi)/(|cos θo| |cos θi|), for directions on the
/// same side (Heitz 2014, equation 99).
#[inline]
pub fn shadowing_over_cosines(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    let (co, ci) = (wo.z.abs(), wi.z.abs());
    2.0 / (co * stretched(alpha, wi) + ci * stretched(alpha, wo))
}

/// Masking and shadowing over both cosines for directions on opposite sides: G1(wo)·G1(wi) (the height-correlated form
/// for transmission is a beta function, Heitz 2014 section 5.3; Walter et al. 2007 use the product).
#[inline]
pub fn transmission_shadowing_over_cosines(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    masking_over_cos(alpha, wo) * masking_over_cos(alpha, wi)
}

/// Density over solid angle of the normals visible from `wo` (z > 0), D(h) G1(wo) (wo·h) / cos θo.
#[inline]
pub fn visible_normal_pdf(alpha: f32, wo: Vec3, h: Vec3) -> f32 {
    distribution(alpha, h) * masking_over_cos(alpha, wo) * wo.dot(h).max(0.0)
}

/// A normal visible from `wo` (z > 0): Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
#[inline]
pub fn sample_visible_normal(alpha: f32, wo: Vec3, u: [f32; 2]) -> Vec3 {
    let std = Vec3::new(wo.x * alpha, wo.y * alpha, wo.z).normalize();
    // Uniform over the cap of the sphere above z = −std.z.
    let z = (1.0 - u[0]) * (1.0 + std.z) - std.z;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let (sin_phi, cos_phi) = libm::sincosf(TAU * u[1]);
    let cap = Vec3::new(sin * cos_phi, sin * sin_phi, z);
    let h = cap + std;
    // Rounding may leave h.z slightly below 0, or h zero at the cap's rim.
    Vec3::new(h.x * alpha, h.y * alpha, h.z.max(1e-7)).normalize()
}

/// The unit half vector of a reflection from `wo` to `wi`, both with z > 0.
#[inline]
pub fn reflection_half(wo: Vec3, wi: Vec3) -> Vec3 {
    (wo + wi).normalize()
}

/// Mirrors `wo` about the unit vector `h`.
#[inline]
pub fn reflect(wo: Vec3, h: Vec3) -> Vec3 {
    (h * (2.0 * wo.dot(h)) - wo).normalize()
}
