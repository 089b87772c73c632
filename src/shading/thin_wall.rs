//! Transmission through a wall without inside: light enters and leaves at once, so it is not bent.

use super::fresnel::Schlick;
use super::ggx_reflection;
use super::lobe::Delta;
use glam::Vec3;

/// Straight on through a smooth wall.
#[inline]
pub fn sample_straight(tint: Vec3, wo: Vec3) -> Delta {
    Delta { wi: -wo, value: tint, probability: 1.0, eta_scale: 1.0, straight: true }
}

/// f·|cos θi| of a rough wall: the reflection lobe turned to the other side, as KHR_materials_transmission has it.
#[inline]
pub fn eval(alpha: f32, tint: Vec3, wo: Vec3, wi: Vec3) -> Vec3 {
    ggx_reflection::eval(alpha, &Schlick::constant(tint), wo, flip(wi))
}

/// Density of [`sample`], 1/sr.
#[inline]
pub fn pdf(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    ggx_reflection::pdf(alpha, wo, flip(wi))
}

/// A direction below the surface.
#[inline]
pub fn sample(alpha: f32, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    ggx_reflection::sample(alpha, wo, u).map(flip)
}

/// The mirror image on the other side of the surface.
#[inline]
pub fn flip(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}
