//! Rough diffuse reflection: the energy-preserving Oren–Nayar model (EON) of Portsmouth, Kutz and Hill 2024, arXiv
//! 2410.18026. Reciprocal; at roughness 0 it is Lambert.

use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// 1/2 − 2/(3π).
const SINGLE: f32 = 0.5 - 2.0 / (3.0 * PI);
/// 2/3 − 28/(15π).
const MEAN: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// Directional albedo of the single-scattering part for a white surface (equation 21's polynomial, right to 0.001).
fn single_albedo(cos: f32, roughness: f32) -> f32 {
    let m = 1.0 - cos;
    let g = m * (0.057_108_53 + m * (0.491_881_87 + m * (-0.332_181_44 + m * 0.071_443)));
    (1.0 + roughness * g) / (1.0 + SINGLE * roughness)
}

/// f·|cos θi|; 0 unless both directions are above the surface. To be sampled by the cosine.
pub fn eval(albedo: Vec3, roughness: f32, wo: Vec3, wi: Vec3) -> Vec3 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let s = wo.x * wi.x + wo.y * wi.y;
    let s = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
    let scale = 1.0 / (1.0 + SINGLE * roughness);
    let single = albedo * (scale * (1.0 + roughness * s));
    let mean = scale * (1.0 + MEAN * roughness);
    let lost = |cos: f32| (1.0 - single_albedo(cos, roughness)).max(0.0);
    let colour = albedo * albedo * mean / (Vec3::ONE - albedo * (1.0 - mean));
    let multiple = colour * (lost(wo.z) * lost(wi.z) / (1.0 - mean).max(1e-7));
    (single + multiple) * (wi.z * FRAC_1_PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::lambert;
    use crate::shading::test_support::direction;

    #[test]
    fn roughness_zero_is_lambert() {
        let albedo = Vec3::new(0.8, 0.5, 0.1);
        for (cos_o, cos_i, phi) in [(1.0, 0.5, 0.0), (0.1, 0.9, 2.0), (0.4, 0.2, 3.0)] {
            let (wo, wi) = (direction(cos_o, 0.0), direction(cos_i, phi));
            let off = eval(albedo, 0.0, wo, wi) - lambert::eval(albedo, wi);
            assert!(off.abs().max_element() < 1e-6, "{off}");
        }
    }

    #[test]
    fn rough_surfaces_send_light_back_where_it_comes_from() {
        let (wo, back, forth) = (direction(0.4, 0.0), direction(0.4, 0.0), direction(0.4, PI));
        let f = |wi| eval(Vec3::splat(0.5), 1.0, wo, wi).x;
        assert!(f(back) > 1.5 * f(forth), "{} and {}", f(back), f(forth));
    }
}
