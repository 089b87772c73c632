//! Reflection from GGX microfacets that are rougher along one tangent than along the other (Heitz 2014, section 5.3), as
//! KHR_materials_anisotropy asks for. x is the direction of α.x.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// D(h), 1/sr.
#[inline]
pub fn distribution(alpha: Vec2, h: Vec3) -> f32 {
    if h.z <= 0.0 {
        return 0.0;
    }
    let (x, y) = (h.x / alpha.x, h.y / alpha.y);
    let d = x * x + y * y + h.z * h.z;
    FRAC_1_PI / (alpha.x * alpha.y * d * d)
}

/// √(cos² + α_x² x² + α_y² y²) of a direction.
#[inline]
fn stretched(alpha: Vec2, w: Vec3) -> f32 {
    let (x, y) = (alpha.x * w.x, alpha.y * w.y);
    (w.z * w.z + x * x + y * y).sqrt()
}

/// f·|cos θi| without the Fresnel term, D G2/(4 cos θo), and the cosine between direction and micronormal; `None` unless
/// both directions are above the surface.
#[inline]
pub fn eval(alpha: Vec2, wo: Vec3, wi: Vec3) -> Option<(f32, f32)> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    let h = (wo + wi).normalize();
    let g = 2.0 / (wo.z * stretched(alpha, wi) + wi.z * stretched(alpha, wo));
    Some((0.25 * distribution(alpha, h) * g * wi.z, wo.dot(h)))
}

/// Density of [`sample`], 1/sr: D(h) G1(wo) / (4 cos θo).
#[inline]
pub fn pdf(alpha: Vec2, wo: Vec3, wi: Vec3) -> f32 {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return 0.0;
    }
    0.5 * distribution(alpha, (wo + wi).normalize()) / (wo.z + stretched(alpha, wo))
}

/// A reflection about a visible normal (Dupuy & Benyoub 2023); `None` when it goes below the surface.
#[inline]
pub fn sample(alpha: Vec2, wo: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let std = Vec3::new(wo.x * alpha.x, wo.y * alpha.y, wo.z).normalize();
    let z = (1.0 - u[0]) * (1.0 + std.z) - std.z;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let (sin_phi, cos_phi) = libm::sincosf(TAU * u[1]);
    let h = Vec3::new(sin * cos_phi, sin * sin_phi, z) + std;
    let h = Vec3::new(h.x * alpha.x, h.y * alpha.y, h.z.max(1e-7)).normalize();
    let wi = (h * (2.0 * wo.dot(h)) - wo).normalize();
    (wi.z > 0.0).then_some(wi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::microfacet as mf;
    use crate::shading::test_support::direction;

    #[test]
    fn equal_roughnesses_are_the_isotropic_lobe() {
        for alpha in [0.01, 0.3, 1.0] {
            let both = Vec2::splat(alpha);
            for (cos_o, cos_i, phi) in [(0.9, 0.8, 3.0), (0.2, 0.7, 1.0), (0.5, 0.5, 0.4 + std::f32::consts::PI)] {
                let (wo, wi) = (direction(cos_o, 0.4), direction(cos_i, phi));
                let h = mf::reflection_half(wo, wi);
                let same = |a: f32, b: f32| assert!((a - b).abs() <= 2e-5 * b, "α {alpha}: {a} and {b}");
                same(distribution(both, h), mf::distribution(alpha, h));
                let f = 0.25 * mf::distribution(alpha, h) * mf::shadowing_over_cosines(alpha, wo, wi) * wi.z;
                same(eval(both, wo, wi).expect("above").0, f);
                same(pdf(both, wo, wi), 0.25 * mf::distribution(alpha, h) * mf::masking_over_cos(alpha, wo));
            }
        }
    }

    #[test]
    fn highlights_are_long_across_the_smooth_direction() {
        let alpha = Vec2::new(0.5, 0.05);
        let along = eval(alpha, Vec3::Z, direction(0.9, 0.0)).expect("above").0;
        let across = eval(alpha, Vec3::Z, direction(0.9, 0.5 * std::f32::consts::PI)).expect("above").0;
        assert!(along > 20.0 * across, "{along} and {across}");
    }
}
