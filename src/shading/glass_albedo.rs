//! What a rough interface between two dielectrics gives back after one encounter with a microfacet, from a table.

use super::albedo::to_axis;
use super::colour::unit;
use super::metal_rough::SMALLEST_ALPHA;
use std::sync::LazyLock;

/// Nodes over cos θo, α and the relative index.
const NODES: [usize; 3] = [24, 24, 32];
/// Relative indices beyond this, or below its inverse, count as this.
const LARGEST_ETA: f32 = 3.0;
/// Added to the table so that what is divided by it is not too small between nodes.
const MARGIN: f32 = 0.008;

/// 16-bit shares, little-endian, cos θo innermost; made and checked by the tests below.
static BYTES: &[u8; 2 * NODES[0] * NODES[1] * NODES[2]] = include_bytes!("glass_albedo.bin");

static TABLE: LazyLock<Vec<f32>> =
    LazyLock::new(|| BYTES.as_chunks().0.iter().map(|b| f32::from(u16::from_le_bytes(*b)) / 65535.0).collect());

/// Share of the light, reflected and refracted, that a clear rough interface of relative index `eta` (far over near
/// side) sends on at the first encounter; the rest would meet the surface again. Dividing the lobe by it makes up for
/// that (as Cycles does). Up to 0.05 too high, never more than 0.005 too low.
pub fn at(cos_o: f32, alpha: f32, eta: f32) -> f32 {
    let cell = |x: f32, n: usize| {
        let position = unit(x) * (n - 1) as f32;
        let cell = (position as usize).min(n - 2);
        (cell, position - cell as f32)
    };
    let (i, s) = cell(to_axis(cos_o), NODES[0]);
    let first = to_axis(SMALLEST_ALPHA);
    let (j, t) = cell((to_axis(alpha) - first) / (1.0 - first), NODES[1]);
    let (k, r) = cell(eta_axis(eta), NODES[2]);
    let table = &*TABLE;
    let row = |j: usize, k: usize| {
        let at = (k * NODES[1] + j) * NODES[0] + i;
        table[at] + (table[at + 1] - table[at]) * s
    };
    let plane = |k: usize| row(j, k) + (row(j + 1, k) - row(j, k)) * t;
    (plane(k) + (plane(k + 1) - plane(k)) * r + MARGIN).min(1.0)
}

/// Position of a relative index on its axis: by the root of Fresnel's amplitude (η − 1)/(η + 1), since the albedo has a
/// cusp at η = 1.
fn eta_axis(eta: f32) -> f32 {
    let most = (LARGEST_ETA - 1.0) / (LARGEST_ETA + 1.0);
    let x = ((eta - 1.0) / (eta + 1.0) / most).clamp(-1.0, 1.0);
    0.5 + 0.5 * x.abs().sqrt().copysign(x)
}

#[cfg(test)]
mod tests {
    use super::super::albedo::from_axis;
    use super::super::fresnel::dielectric;
    use super::super::microfacet as mf;
    use super::*;
    use glam::Vec3;

    fn integrate(cos_o: f32, alpha: f32, eta: f32, points: u32) -> f32 {
        let cos_o = cos_o.max(1e-5);
        let wo = Vec3::new((1.0 - cos_o * cos_o).max(0.0).sqrt(), 0.0, cos_o);
        let mut sum = 0f64;
        for k in 0..points {
            let from_rim = 1.0 - (k as f32 + 0.5) / points as f32;
            let turn = 0.5 * ((k.reverse_bits() >> 8) as f32 / 16_777_216.0 + 0.5 / points as f32);
            let h = mf::sample_visible_normal(alpha, wo, [1.0 - from_rim * from_rim, turn]);
            let cos = wo.dot(h).clamp(0.0, 1.0);
            let (f, cos_t) = dielectric(cos, eta).unwrap_or((1.0, 0.0));
            let up = mf::reflect(wo, h);
            let mut share = 0.0;
            if up.z > 0.0 {
                share += f * mf::shadowing_over_cosines(alpha, wo, up) * up.z / mf::masking_over_cos(alpha, wo);
            }
            let down = h * (cos / eta - cos_t) - wo / eta;
            if f < 1.0 && down.z < 0.0 {
                share += (1.0 - f) * -down.z * mf::masking_over_cos(alpha, down.normalize());
            }
            sum += f64::from(share * 2.0 * from_rim);
        }
        (sum / f64::from(points)) as f32
    }

    fn node(i: usize, j: usize, k: usize) -> [f32; 3] {
        let at = |i: usize, n: usize| i as f32 / (n - 1) as f32;
        let y = 2.0 * at(k, NODES[2]) - 1.0;
        let x = y * y.abs() * (LARGEST_ETA - 1.0) / (LARGEST_ETA + 1.0);
        let first = to_axis(SMALLEST_ALPHA);
        let alpha = from_axis(first + (1.0 - first) * at(j, NODES[1]));
        [from_axis(at(i, NODES[0])), alpha, (1.0 + x) / (1.0 - x)]
    }

    fn bytes(points: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        for k in 0..NODES[2] {
            for j in 0..NODES[1] {
                for i in 0..NODES[0] {
                    let [cos_o, alpha, eta] = node(i, j, k);
                    let share = integrate(cos_o, alpha, eta, points).min(1.0);
                    bytes.extend(((share * 65535.0) as u16).to_le_bytes());
                }
            }
        }
        bytes
    }

    #[test]
    #[ignore = "writes the table: cargo test --release glass_albedo -- --ignored"]
    fn write_the_table() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/shading/glass_albedo.bin");
        std::fs::write(path, bytes(4096)).expect("can be written");
    }

    #[test]
    fn the_table_holds_the_integral_at_its_nodes() {
        for (k, j, i) in [(0, 3, 5), (7, 23, 0), (15, 8, 8), (16, 18, 23), (23, 15, 2), (31, 1, 1)] {
            let [cos_o, alpha, eta] = node(i, j, k);
            let off = at(cos_o, alpha, eta) - (integrate(cos_o, alpha, eta, 4096) + MARGIN).min(1.0);
            assert!(off.abs() < 2e-3, "η {eta}, α {alpha}, cos {cos_o}: off by {off}");
        }
    }

    #[test]
    fn the_table_is_seldom_below_the_integral() {
        let (mut most, mut least) = (0f32, 0f32);
        for eta in [1.1, 1.33, 1.5, 2.4, 1.0 / 1.1, 1.0 / 1.33, 1.0 / 1.5, 1.0 / 2.4] {
            for i in 0..12 {
                for j in 0..8 {
                    let cos_o = (i as f32 + 0.5) / 12.0;
                    let alpha = libm::powf(10.0, -2.0 * (j as f32 + 0.5) / 8.0);
                    let off = at(cos_o, alpha, eta) / integrate(cos_o, alpha, eta, 1024) - 1.0;
                    (most, least) = (most.max(off), least.min(off));
                    assert!((-0.005..0.05).contains(&off), "η {eta}, α {alpha}, cos {cos_o}: off by {off}");
                }
            }
        }
        println!("off by {least} to {most}");
    }
}
