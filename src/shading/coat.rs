//! A clear coat whose normal is not that of the surface below it (KHR_materials_clearcoat): the rough reflection in a
//! frame of its own.

use super::fresnel::{Schlick, schlick_weight};
use super::ggx_reflection;
use crate::math::Frame;
use glam::Vec3;

/// Reflectance of the coat, index 1.5, at normal incidence.
pub const F0: f32 = 0.04;

/// Reflectance of a coat of full strength.
pub fn fresnel(cos: f32) -> f32 {
    F0 + (1.0 - F0) * schlick_weight(cos)
}

/// f·|cos θi|, the cosine being that to the coat's normal, and the density of [`sample`], 1/sr. Light comes from above the
/// coat and from above the surface.
pub fn eval(alpha: f32, strength: f32, normal: Vec3, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
    if wi.z <= 0.0 {
        return (Vec3::ZERO, 0.0);
    }
    let frame = Frame::from_normal(normal);
    let (wo, wi) = (frame.to_local(wo), frame.to_local(wi));
    let fresnel = Schlick { f0: Vec3::splat(F0 * strength), f90: Vec3::splat(strength) };
    (ggx_reflection::eval(alpha, &fresnel, wo, wi), ggx_reflection::pdf(alpha, wo, wi))
}

/// A reflection by the coat; `None` when it goes below the coat or below the surface.
pub fn sample(alpha: f32, normal: Vec3, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let frame = Frame::from_normal(normal);
    let local = frame.to_local(wo);
    if local.z <= 0.0 {
        return None;
    }
    let wi = frame.to_world(ggx_reflection::sample(alpha, local, u)?).normalize();
    (wi.z > 0.0).then_some(wi)
}
