//! Points on emissive triangles.

use super::emitter::{Emitter, NearPoint};
use super::sample::Target;
use crate::geometry::{Geometry, emission};
use crate::math::float_error::gamma;
use glam::{DVec3, Vec3};
use kiln_formats::Scene;

/// Area of a triangle.
pub(super) fn of(geometry: &Geometry, triangle: u32) -> f64 {
    0.5 * geometry.front_normal(triangle).length()
}

/// The unit normal on the front of a triangle; any for one that has no area.
pub(super) fn normal(geometry: &Geometry, triangle: u32) -> Vec3 {
    geometry.front_normal(triangle).normalize_or(DVec3::Z).as_vec3()
}

/// How many of its longest edges a triangle may be away for its solid angle to be sampled, squared. Further away, sampling
/// its area makes hardly more noise, and costs less.
const NEAR2: f32 = 1.0;

/// The square of the distance from its middle within which a triangle is near.
pub(super) fn near2([a, b, c]: [Vec3; 3]) -> f32 {
    NEAR2 * (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared())
}

/// Uniform barycentric weights (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
pub(super) fn uniform(u: [f32; 2]) -> [f32; 3] {
    let [mut b0, mut b1] = u;
    if b1 > b0 {
        b0 *= 0.5;
        b1 -= b0;
    } else {
        b1 *= 0.5;
        b0 -= b1;
    }
    [b0, b1, 1.0 - b0 - b1]
}

/// Direction, radiance, solid angle density and place of a point on an emitter, uniform over its solid angle or, from further
/// away, its area.
pub(super) fn sample(
    scene: &Scene,
    geometry: &Geometry,
    emitter: &Emitter,
    point: Vec3,
    u: [f32; 2],
) -> Option<(Vec3, Vec3, f32, Target)> {
    let (half, weights, near_pdf) = match emitter.sample_near(geometry, point, u) {
        Some(near) => near.map(|NearPoint { half, weights, pdf }| (half, weights, Some(pdf)))?,
        None => {
            let (half, weights) = emitter.sample_area(u);
            (half, weights, None)
        }
    };
    let half = &emitter.halves[half];
    let (triangle, [a, b, c]) = (half.triangle, half.corners(geometry));
    let on_light = a * weights[0] + b * weights[1] + c * weights[2];
    let cross = geometry.front_normal(triangle);
    let normal = cross.try_normalize()?.as_vec3();
    let to = on_light - point;
    let distance2 = to.length_squared();
    let distance = distance2.sqrt();
    let direction = to / distance;
    let cosine = -direction.dot(normal);
    let mut own_weights = weights;
    own_weights.rotate_right(usize::from(half.apex));
    let radiance = emission::radiance(scene, geometry, triangle, own_weights, cosine > 0.0);
    if radiance == Vec3::ZERO || cosine == 0.0 || !direction.is_finite() {
        return None;
    }
    let area_pdf = || distance2 * emitter.share() / (cosine.abs() * (0.5 * cross.length()) as f32);
    let pdf = near_pdf.unwrap_or_else(area_pdf);
    let error = ((a * weights[0]).abs() + (b * weights[1]).abs() + (c * weights[2]).abs()) * gamma(7);
    Some((direction, radiance, pdf, Target::Triangle { triangle, point: on_light, error, normal }))
}

/// The solid angle density with which [`sample`] makes the direction from `point` to `on_light` on a triangle of the emitter.
pub(super) fn pdf(geometry: &Geometry, emitter: &Emitter, triangle: u32, point: Vec3, on_light: Vec3) -> f32 {
    if let Some(pdf) = emitter.near_pdf(geometry, point) {
        return pdf;
    }
    let to = on_light - point;
    let distance2 = to.length_squared();
    // cos·A·d = |n·d| / 2 with n the cross product: no square root of the area, no unit normal.
    let cos_area = (0.5 * geometry.front_normal(triangle).dot(to.as_dvec3()).abs()) as f32;
    distance2 * distance2.sqrt() * emitter.share() / cos_area
}
