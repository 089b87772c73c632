//! Maps from the unit square [0, 1)² to where samples are wanted, with their densities.

use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// The largest f32 below 1.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A number moved into [0, 1): a remap such as `(u − a) / b` may round up to 1. NaN becomes 0.
#[inline]
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
pub fn into_unit(u: f32) -> f32 {
    u.max(0.0).min(ONE_MINUS_EPSILON)
}

/// A unit vector at `cos_theta` from +z.
#[inline]
fn at_polar(cos_theta: f32, turn: f32) -> Vec3 {
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (sin_phi, cos_phi) = libm::sincosf(TAU * turn);
    Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// A direction uniform over the sphere.
#[inline]
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    at_polar(1.0 - 2.0 * u[0], u[1])
}

/// Density of [`uniform_sphere`] over solid angle, 1/sr.
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// A direction uniform over the hemisphere z > 0.
#[inline]
pub fn uniform_hemisphere(u: [f32; 2]) -> Vec3 {
    at_polar(1.0 - u[0], u[1])
}

/// Density of [`uniform_hemisphere`] over solid angle, 1/sr, on z > 0.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// A point uniform over the unit disc by Shirley and Chiu's concentric map (1997), which keeps neighbours neighbours.
#[inline]
pub fn concentric_disc(u: [f32; 2]) -> [f32; 2] {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0, 0.0];
    }
    let (radius, theta) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    let (sin, cos) = libm::sincosf(theta);
    [radius * cos, radius * sin]
}

/// A point uniform over the unit disc, by radius and turn.
#[inline]
pub fn uniform_disc(u: [f32; 2]) -> [f32; 2] {
    let radius = u[0].sqrt();
    let (sin, cos) = libm::sincosf(TAU * u[1]);
    [radius * cos, radius * sin]
}

/// Density of [`concentric_disc`] and [`uniform_disc`] over area.
pub const UNIFORM_DISC_PDF: f32 = FRAC_1_PI;

/// A direction of the hemisphere z > 0 with density cos θ / π (Malley's method).
#[inline]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let [x, y] = concentric_disc(u);
    // 1 − x² − y² may cancel to 0 at the rim, where the density is 0 too.
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`] over solid angle, 1/sr.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    cos_theta.max(0.0) * FRAC_1_PI
}

/// Barycentric weights of the second and third corner, uniform over a triangle: Heitz 2019, "A Low-Distortion Map
/// Between Triangle and Square". The density over area is 1 / area.
#[inline]
pub fn uniform_triangle(u: [f32; 2]) -> [f32; 2] {
    if u[0] < u[1] {
        let b = 0.5 * u[0];
        [b, u[1] - b]
    } else {
        let b = 0.5 * u[1];
        [u[0] - b, b]
    }
}

/// A direction uniform over the cone of half angle θ around +z, where `one_minus_cos_max` = 1 − cos θ (the difference
/// itself, so that narrow cones keep their digits).
#[inline]
pub fn uniform_cone(u: [f32; 2], one_minus_cos_max: f32) -> Vec3 {
    let versine = u[0] * one_minus_cos_max;
    // sin² = 1 − (1 − v)² = v (2 − v), without cancellation.
    let sin_theta = (versine * (2.0 - versine)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = libm::sincosf(TAU * u[1]);
    Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - versine)
}

/// Density of [`uniform_cone`] over solid angle, 1/sr, inside the cone.
#[inline]
pub fn uniform_cone_pdf(one_minus_cos_max: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cos_max)
}
