//! Sheen: the "Charlie" microfibres of Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", with the
//! fitted shadowing that KHR_materials_sheen lays down.

use super::colour::unit;
use crate::math::warp;
use glam::Vec3;
use std::f32::consts::TAU;
use std::sync::LazyLock;

/// The least α: below it D is a spike at the horizon that nothing can sample.
const SMALLEST_ALPHA: f32 = 0.02;
/// Nodes over cos θo and over the roughness.
const NODES: usize = 24;
/// Steps over cos θi and over half of the azimuths.
const STEPS: u32 = 24;

/// The lobe of a roughness, what depends on it alone worked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charlie {
    inverse_alpha: f32,
    /// The five coefficients of the fit of Λ.
    fit: [f32; 5],
    /// 2 L(1/2).
    twice_middle: f32,
}

impl Charlie {
    /// For a perceptual roughness in [0, 1]; α is its square.
    pub fn new(roughness: f32) -> Self {
        let alpha = (unit(roughness) * unit(roughness)).max(SMALLEST_ALPHA);
        let t = (1.0 - alpha) * (1.0 - alpha);
        let mix = |rough: f32, smooth: f32| rough + (smooth - rough) * t;
        let fit = [
            mix(21.5473, 25.3245),
            mix(3.82987, 3.32435),
            mix(0.19823, 0.16801),
            mix(-1.97760, -1.27393),
            mix(-4.32054, -4.85967),
        ];
        let mut new = Self { inverse_alpha: 1.0 / alpha, fit, twice_middle: 0.0 };
        new.twice_middle = 2.0 * new.exponent(0.5);
        new
    }

    /// L(x) of the paper's equation 3.
    fn exponent(&self, x: f32) -> f32 {
        let [a, b, c, d, e] = self.fit;
        a / (1.0 + b * libm::powf(x, c)) + d * x + e
    }

    fn lambda(&self, cos: f32) -> f32 {
        if cos < 0.5 {
            libm::expf(self.exponent(cos))
        } else {
            libm::expf(self.twice_middle - self.exponent(1.0 - cos))
        }
    }

    /// f·|cos θi| of white sheen; 0 unless both directions are above the surface.
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let h = (wo + wi).normalize();
        let sin2 = (h.x * h.x + h.y * h.y).min(1.0);
        let d = (2.0 + self.inverse_alpha) * libm::powf(sin2, 0.5 * self.inverse_alpha) / TAU;
        let v = 1.0 / ((1.0 + self.lambda(wo.z) + self.lambda(wi.z)) * 4.0 * wo.z * wi.z);
        d * v.min(1.0) * wi.z
    }
}

/// Density of [`sample`], 1/sr.
pub fn pdf(wi: Vec3) -> f32 {
    if wi.z > 0.0 { warp::UNIFORM_HEMISPHERE_PDF } else { 0.0 }
}

/// Uniform over the hemisphere: the lobe is strong at the horizon, where a cosine would send hardly any samples.
pub fn sample(u: [f32; 2]) -> Vec3 {
    warp::uniform_hemisphere(u)
}

static ALBEDO: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let node = |i: usize| i as f32 / (NODES - 1) as f32;
    (0..NODES * NODES).map(|k| integrate(node(k % NODES), node(k / NODES), STEPS)).collect()
});

/// What white sheen reflects to a viewer at `cos_o` of light from everywhere, from a table of the integral. Off by at most
/// 0.01.
pub fn albedo(cos_o: f32, roughness: f32) -> f32 {
    let cell = |x: f32| {
        let position = unit(x) * (NODES - 1) as f32;
        let cell = (position as usize).min(NODES - 2);
        (cell, position - cell as f32)
    };
    let ((i, s), (j, t)) = (cell(cos_o.max(0.0).sqrt()), cell(roughness));
    let table = &*ALBEDO;
    let row = |j: usize| table[j * NODES + i] + (table[j * NODES + i + 1] - table[j * NODES + i]) * s;
    row(j) + (row(j + 1) - row(j)) * t
}

/// The midpoint rule over cos θi, with nodes crowded at the horizon, and φ.
fn integrate(root_cos_o: f32, roughness: f32, steps: u32) -> f32 {
    let cos_o = (root_cos_o * root_cos_o).max(1e-4);
    let wo = Vec3::new((1.0 - cos_o * cos_o).max(0.0).sqrt(), 0.0, cos_o);
    let lobe = Charlie::new(roughness);
    let mut sum = 0.0;
    for i in 0..steps {
        let v = (i as f32 + 0.5) / steps as f32;
        let (z, dz) = (v * v, 2.0 * v);
        let sin = (1.0 - z * z).max(0.0).sqrt();
        for j in 0..steps {
            let (y, x) = libm::sincosf(0.5 * TAU * (j as f32 + 0.5) / steps as f32);
            sum += dz * lobe.eval(wo, Vec3::new(sin * x, sin * y, z));
        }
    }
    sum * TAU / (steps * steps) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_near_the_integral() {
        let mut most = (0f32, 0.0, 0.0);
        for i in 0..15 {
            for j in 0..15 {
                let (cos_o, roughness) = ((i as f32 + 0.4) / 15.0, (j as f32 + 0.4) / 15.0);
                let off = albedo(cos_o, roughness) - integrate(cos_o.sqrt(), roughness, 200);
                most = if off.abs() > most.0 { (off.abs(), cos_o, roughness) } else { most };
            }
        }
        println!("off by {most:?}");
        assert!(most.0 < 0.01, "{most:?}");
    }

    #[test]
    fn sheen_reflects_no_more_than_it_gets_but_next_to_the_horizon_and_most_there() {
        for roughness in [0.0, 0.1, 0.3, 0.5, 0.8, 1.0] {
            for i in 4..=20 {
                let sent = integrate(i as f32 / 20.0, roughness, 100);
                assert!(sent <= 1.0, "roughness {roughness} at {i}: {sent}");
            }
        }
        assert!(albedo(0.1, 0.3) > 3.0 * albedo(1.0, 0.3));
    }
}
