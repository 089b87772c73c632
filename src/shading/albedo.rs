//! Directional albedo of the GGX reflection lobe, from a small table.

use super::fresnel::{Schlick, schlick_weight};
use super::microfacet as mf;
use glam::Vec3;
use std::sync::OnceLock;

/// Nodes along each axis of the table.
const NODES: usize = 32;
/// Quasi-Monte-Carlo points per node.
const POINTS: u32 = 128;

/// Scale and offset of F0 and F90: the albedo is F0·a + F90·b (the split sum of Karis 2013).
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    a: f32,
    b: f32,
}

static TABLE: OnceLock<Vec<Entry>> = OnceLock::new();

/// Share of the light from all directions that a white furnace would send to the viewer by the GGX lobe: what the
/// lobe reflects in total, E(cos θo). Good to about 0.002; made at first use.
pub fn ggx(fresnel: &Schlick, cos_o: f32, alpha: f32) -> Vec3 {
    let entry = lookup(TABLE.get_or_init(make_table), cos_o, alpha);
    fresnel.f0 * entry.a + fresnel.f90 * entry.b
}

/// cos θo and α of a node. Albedos bend most at grazing angles, so nodes lie on √cos and, as in files, on √α.
fn node(i: usize, j: usize) -> (f32, f32) {
    let at = |k: usize| k as f32 / (NODES - 1) as f32;
    ((at(i) * at(i)).max(1e-4), (at(j) * at(j)).max(1e-4))
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

/// The integrals a and b with `points` points of the Hammersley set.
fn integrate(cos_o: f32, alpha: f32, points: u32) -> Entry {
    let wo = Vec3::new((1.0 - cos_o * cos_o).max(0.0).sqrt(), 0.0, cos_o);
    let (mut a, mut b) = (0f64, 0f64);
    for k in 0..points {
        let u = [(k as f32 + 0.5) / points as f32, radical_inverse(k)];
        let h = mf::sample_visible_normal(alpha, wo, u);
        let wi = mf::reflect(wo, h);
        if wi.z <= 0.0 {
            continue;
        }
        // f cos / pdf = F · G2(wo, wi) / G1(wo)
        let g = mf::shadowing_over_cosines(alpha, wo, wi) * wi.z / mf::masking_over_cos(alpha, wo);
        let w = schlick_weight(wo.dot(h));
        a += f64::from(g * (1.0 - w));
        b += f64::from(g * w);
    }
    Entry { a: (a / f64::from(points)) as f32, b: (b / f64::from(points)) as f32 }
}

/// Van der Corput's sequence in base 2, moved to the middle of its cells.
fn radical_inverse(k: u32) -> f32 {
    (k.reverse_bits() >> 8) as f32 / 16_777_216.0
}

fn lookup(table: &[Entry], cos_o: f32, alpha: f32) -> Entry {
    let axis = |x: f32| {
        let position = x.max(0.0).min(1.0).sqrt() * (NODES - 1) as f32;
        let cell = (position as usize).min(NODES - 2);
        (cell, position - cell as f32)
    };
    let ((i, s), (j, t)) = (axis(cos_o), axis(alpha));
    let mix = |x: Entry, y: Entry, t: f32| Entry { a: x.a + (y.a - x.a) * t, b: x.b + (y.b - x.b) * t };
    let at = |i: usize, j: usize| table[j * NODES + i];
    mix(mix(at(i, j), at(i + 1, j), s), mix(at(i, j + 1), at(i + 1, j + 1), s), t)
}
