//! Points on emissive triangles.

use super::sample::Target;
use super::spherical::{self, SphericalTriangle};
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

/// The triangle as seen from `point`, where its solid angle is what to sample.
pub(super) fn spherical(corners: [Vec3; 3], point: Vec3) -> Option<SphericalTriangle> {
    let middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    let near = (middle - point).length_squared() < near2(corners);
    near.then(|| SphericalTriangle::new(corners, point)).flatten()
}

/// Uniform barycentric weights (Heitz 2019, "A Low-Distortion Map Between Triangle and Square").
fn uniform(u: [f32; 2]) -> [f32; 3] {
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

/// Direction, radiance, solid angle density and place of a point on a triangle, uniform over its solid angle or, from further
/// away, its area.
pub(super) fn sample(
    scene: &Scene,
    geometry: &Geometry,
    triangle: u32,
    point: Vec3,
    u: [f32; 2],
) -> Option<(Vec3, Vec3, f32, Target)> {
    let corners = geometry.corners(triangle);
    let spherical = spherical(corners, point);
    let weights = match &spherical {
        Some(seen) => spherical::weights(corners, point, seen.sample(u)?)?,
        None => uniform(u),
    };
    let [a, b, c] = corners;
    let on_light = a * weights[0] + b * weights[1] + c * weights[2];
    let cross = geometry.front_normal(triangle);
    let normal = cross.try_normalize()?.as_vec3();
    let to = on_light - point;
    let distance2 = to.length_squared();
    let distance = distance2.sqrt();
    let direction = to / distance;
    let cosine = -direction.dot(normal);
    let radiance = emission::radiance(scene, geometry, triangle, weights, cosine > 0.0);
    if radiance == Vec3::ZERO || cosine == 0.0 || !direction.is_finite() {
        return None;
    }
    let pdf = match spherical {
        Some(seen) => (1.0 / seen.solid_angle) as f32,
        None => distance2 / (cosine.abs() * (0.5 * cross.length()) as f32),
    };
    let error = ((a * weights[0]).abs() + (b * weights[1]).abs() + (c * weights[2]).abs()) * gamma(7);
    Some((direction, radiance, pdf, Target::Triangle { triangle, point: on_light, error, normal }))
}

/// The solid angle density with which [`sample`] makes the direction from `point` to `on_light`.
pub(super) fn pdf(geometry: &Geometry, triangle: u32, point: Vec3, on_light: Vec3) -> f32 {
    if let Some(seen) = spherical(geometry.corners(triangle), point) {
        return (1.0 / seen.solid_angle) as f32;
    }
    let to = on_light - point;
    let distance2 = to.length_squared();
    // cos·A·d = |n·d| / 2 with n the cross product: no square root of the area, no unit normal.
    let cos_area = (0.5 * geometry.front_normal(triangle).dot(to.as_dvec3()).abs()) as f32;
    distance2 * distance2.sqrt() / cos_area
}
