//! Perfectly diffuse reflection.

use crate::math::warp;
use glam::Vec3;

/// f·|cos θi| with f = albedo/π, for wo above the surface.
#[inline]
pub fn eval(albedo: Vec3, wi: Vec3) -> Vec3 {
    albedo * pdf(wi)
}

/// Density of [`sample`], 1/sr.
#[inline]
pub fn pdf(wi: Vec3) -> f32 {
    warp::cosine_hemisphere_pdf(wi.z)
}

/// A direction by the cosine.
#[inline]
pub fn sample(u: [f32; 2]) -> Vec3 {
    warp::cosine_hemisphere(u)
}
