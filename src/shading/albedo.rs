//! Directional albedo of the GGX reflection lobe, from a small table.

use super::colour::unit;
use super::fresnel::{Schlick, schlick_weight};
use super::metal_rough::SMALLEST_ALPHA;
use super::microfacet as mf;
use glam::Vec3;
use std::sync::OnceLock;

/// Nodes along each axis of the table.
const NODES: usize = 40;
/// Quasi-Monte-Carlo points per node.
const POINTS: u32 = 160;

/// Scale and offset of F0 and F90: the albedo is F0·a + F90·b (the split sum of Karis 2013).
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    a: f32,
    b: f32,
}

static TABLE: OnceLock<Vec<Entry>> = OnceLock::new();

/// Share of the light from all directions that a white furnace would send to the viewer by the GGX lobe: what the
/// lobe reflects in total, E(cos θo). At most 0.005 too low and 0.01 too high; the table is made at first use.
pub fn ggx(fresnel: &Schlick, cos_o: f32, alpha: f32) -> Vec3 {
    if fresnel.f0 == Vec3::ZERO && fresnel.f90 == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let entry = lookup(TABLE.get_or_init(make_table), cos_o, alpha);
    fresnel.f0 * entry.a + fresnel.f90 * entry.b
}

/// Position on an axis of the table: fourth roots, as albedos bend where cos θo is about α, at every scale of α.
fn to_axis(x: f32) -> f32 {
    unit(x).sqrt().sqrt()
}

/// Where [`to_axis`] gives `position`.
fn from_axis(position: f32) -> f32 {
    let square = position * position;
    square * square
}

/// cos θo and α of a node.
fn node(i: usize, j: usize) -> (f32, f32) {
    let at = |k: usize| k as f32 / (NODES - 1) as f32;
    let first = to_axis(SMALLEST_ALPHA);
    (from_axis(at(i)), from_axis(first + (1.0 - first) * at(j)))
}

fn make_table() -> Vec<Entry> {
    let mut table = Vec::with_capacity(NODES * NODES);
    for j in 0..NODES {
        for i in 0..NODES {
            let (cos_o, alpha) = node(i, j);
            table.push(integrate(cos_o, alpha, POINTS));
        }
    }
    table
}

/// The integrals a and b with `points` points of the Hammersley set, over half of the azimuths (the other half is its
/// mirror image).
fn integrate(cos_o: f32, alpha: f32, points: u32) -> Entry {
    let wo = Vec3::new((1.0 - cos_o * cos_o).max(0.0).sqrt(), 0.0, cos_o);
    let (mut a, mut b) = (0f64, 0f64);
    for k in 0..points {
        // Normals at the rim of the visible cap (u → 1) send light below the horizon: that edge decides how much is
        // lost, so points crowd there, u = 1 − (1 − v)².
        let from_rim = 1.0 - (k as f32 + 0.5) / points as f32;
        let u = [1.0 - from_rim * from_rim, 0.5 * radical_inverse(k)];
        let h = mf::sample_visible_normal(alpha, wo, u);
        let wi = mf::reflect(wo, h);
        if wi.z <= 0.0 {
            continue;
        }
        // f cos / pdf = F · G2(wo, wi) / G1(wo), times du/dv.
        let g = mf::shadowing_over_cosines(alpha, wo, wi) * wi.z / mf::masking_over_cos(alpha, wo);
        let share = g * 2.0 * from_rim;
        let w = schlick_weight(wo.dot(h));
        a += f64::from(share * (1.0 - w));
        b += f64::from(share * w);
    }
    Entry { a: (a / f64::from(points)) as f32, b: (b / f64::from(points)) as f32 }
}

/// Van der Corput's sequence in base 2, moved to the middle of its cells.
fn radical_inverse(k: u32) -> f32 {
    (k.reverse_bits() >> 8) as f32 / 16_777_216.0
}

fn lookup(table: &[Entry], cos_o: f32, alpha: f32) -> Entry {
    let cell = |x: f32| {
        let position = x * (NODES - 1) as f32;
        let cell = (position as usize).min(NODES - 2);
        (cell, position - cell as f32)
    };
    let first = to_axis(SMALLEST_ALPHA);
    let (i, s) = cell(to_axis(cos_o));
    let (j, t) = cell((to_axis(alpha.max(SMALLEST_ALPHA)) - first) / (1.0 - first));
    let mix = |x: Entry, y: Entry, t: f32| Entry { a: x.a + (y.a - x.a) * t, b: x.b + (y.b - x.b) * t };
    let at = |i: usize, j: usize| table[j * NODES + i];
    mix(mix(at(i, j), at(i + 1, j), s), mix(at(i, j + 1), at(i + 1, j + 1), s), t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Too much (a + b) takes light from what lies below the coat, too little gives energy away.
    #[test]
    fn the_table_is_near_the_integral_and_seldom_below() {
        let table = make_table();
        let (mut most, mut least) = ((0f32, 0.0, 0.0), (0f32, 0.0, 0.0));
        for i in 0..60 {
            for j in 0..40 {
                let cos_o = libm::powf(10.0, -6.0 * (i as f32 + 0.5) / 60.0);
                let alpha = libm::powf(10.0, -3.0 * (j as f32 + 0.5) / 40.0);
                let (true_one, tabled) = (integrate(cos_o, alpha, 4096), lookup(&table, cos_o, alpha));
                for off in [tabled.a + tabled.b - true_one.a - true_one.b, tabled.b - true_one.b] {
                    most = if off > most.0 { (off, cos_o, alpha) } else { most };
                    least = if off < least.0 { (off, cos_o, alpha) } else { least };
                }
            }
        }
        println!("(error, cos θo, α): {most:?} above, {least:?} below");
        assert!(most.0 < 0.01, "{most:?}");
        assert!(least.0 > -0.005, "{least:?}");
    }

    #[test]
    fn a_nearly_smooth_surface_has_the_albedo_of_a_mirror() {
        for cos_o in [0.1, 0.37, 0.8, 1.0] {
            let fresnel = Schlick { f0: Vec3::splat(0.04), f90: Vec3::ONE };
            let off = ggx(&fresnel, cos_o, 1e-3).x - fresnel.at(cos_o).x;
            assert!(off.abs() < 0.004, "cos {cos_o}: off by {off}");
        }
    }
}
