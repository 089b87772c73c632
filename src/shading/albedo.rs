//! Directional albedo of the GGX reflection lobe from a small table, and what multiple scattering adds to it.

use super::colour::unit;
use super::fresnel::{Schlick, schlick_weight};
use super::metal_rough::SMALLEST_ALPHA;
use super::microfacet as mf;
use crate::lanes::{Floats, Lanes, Words};
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

struct Table {
    /// By α (outer) and cos θo (inner), `a` and `b` of each.
    entries: Vec<f32>,
    /// ∫ (a + b) cos θ dω / π, by α, and room to read four from each.
    mean: Vec<f32>,
}

static TABLE: OnceLock<Table> = OnceLock::new();

/// [`GgxAlbedo`] in lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct GgxAlbedoLanes<F> {
    /// Coefficient of F0.
    pub a: F,
    /// Coefficient of F90.
    pub b: F,
    /// As in [`GgxAlbedo`].
    pub mean: F,
}

impl<F: Floats> GgxAlbedoLanes<F> {
    /// As [`GgxAlbedo::at`].
    #[inline(always)]
    pub fn at<L: Lanes<F = F, U = F::Words>>(l: L, cos_o: F, alpha: F) -> Self {
        let table = TABLE.get_or_init(Table::new);
        let (i, s) = cell_lanes(to_axis_lanes(cos_o));
        let first = to_axis(SMALLEST_ALPHA);
        let along = (to_axis_lanes(alpha.max(alpha.fill(SMALLEST_ALPHA))) - first) / (1.0 - first);
        let (j, t) = cell_lanes(along);
        let node = j * NODES as u32 + i;
        let lower = l.gather_four(&table.entries, node.shl::<1>());
        let upper = l.gather_four(&table.entries, (node + NODES as u32).shl::<1>());
        let [mean, next, ..] = l.gather_four(&table.mean, j);
        let ([a, b, a1, b1], [c, d, c1, d1]) = (lower, upper);
        Self {
            a: mix(mix(a, a1, s), mix(c, c1, s), t),
            b: mix(mix(b, b1, s), mix(d, d1, s), t),
            mean: mix(mean, next, t),
        }
    }
}

#[inline(always)]
fn mix<F: Floats>(x: F, y: F, t: F) -> F {
    x + (y - x) * t
}

#[inline(always)]
fn to_axis_lanes<F: Floats>(x: F) -> F {
    x.max(x.fill(0.0)).min(x.fill(1.0)).sqrt().sqrt()
}

/// As [`cell`].
#[inline(always)]
fn cell_lanes<F: Floats>(x: F) -> (F::Words, F) {
    let position = x * (NODES - 1) as f32;
    let cell = position.truncate();
    let cell = cell.min(cell.fill(NODES as u32 - 2));
    (cell, position - cell.to_floats())
}

/// What a rough surface reflects to a viewer in one direction of the light that comes from all: a property of (cos θo,
/// α) that only has to be multiplied by a Fresnel term. At most 0.005 too low and 0.01 too high; the table is made at
/// first use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxAlbedo {
    /// Coefficient of F0.
    a: f32,
    /// Coefficient of F90.
    b: f32,
    /// Mean over all directions, weighted by the cosine, of what a white surface reflects after one bounce.
    mean: f32,
}

impl GgxAlbedo {
    /// Seen at `cos_o`, for the lobe of `alpha`.
    pub fn at(cos_o: f32, alpha: f32) -> Self {
        let table = TABLE.get_or_init(Table::new);
        let (entry, mean) = table.lookup(cos_o, alpha);
        Self { a: entry.a, b: entry.b, mean }
    }

    /// Share of the light from all directions that the viewer receives after one bounce.
    pub fn single(&self, fresnel: &Schlick) -> Vec3 {
        fresnel.f0 * self.a + fresnel.f90 * self.b
    }

    /// By how much the lobe has to be scaled to make up for light that bounces among the microfacets more than once.
    ///
    /// Of what is lost after one bounce, 1 − E, each further bounce keeps F and lets the mean albedo Ē out, a geometric
    /// series: 1 + F Ē/(1 − F(1 − Ē)) · (1 − E)/E (the energy of Kulla and Conty 2017, put into the shape of the single
    /// bounce as Turquin 2019 does). Exactly 1/E for F = 1, hardly more than 1 for a dielectric. It depends on the
    /// viewer's direction alone, so the lobe is no longer reciprocal; paths start at the camera only.
    pub fn compensation(&self, fresnel: &Schlick) -> Vec3 {
        let white = self.a + self.b;
        let f = (self.single(fresnel) / white).clamp(Vec3::ZERO, Vec3::ONE);
        let multiple = f * self.mean / (Vec3::ONE - f * (1.0 - self.mean));
        Vec3::ONE + multiple * ((1.0 - white).max(0.0) / white)
    }

    /// The mean of two.
    pub fn between(&self, other: &Self) -> Self {
        let mean = |x: f32, y: f32| 0.5 * (x + y);
        Self { a: mean(self.a, other.a), b: mean(self.b, other.b), mean: mean(self.mean, other.mean) }
    }

    /// What a white surface reflects after one bounce.
    pub fn white(&self) -> f32 {
        self.a + self.b
    }
}

/// Share of the light from all directions that a white furnace would send to the viewer by the GGX lobe with single
/// scattering.
pub fn ggx(fresnel: &Schlick, cos_o: f32, alpha: f32) -> Vec3 {
    if fresnel.f0 == Vec3::ZERO && fresnel.f90 == Vec3::ZERO {
        return Vec3::ZERO;
    }
    GgxAlbedo::at(cos_o, alpha).single(fresnel)
}

/// Position on an axis of the table: fourth roots, as albedos bend where cos θo is about α, at every scale of α.
pub(super) fn to_axis(x: f32) -> f32 {
    unit(x).sqrt().sqrt()
}

/// Where [`to_axis`] gives `position`.
pub(super) fn from_axis(position: f32) -> f32 {
    let square = position * position;
    square * square
}

/// cos θo and α of a node.
fn node(i: usize, j: usize) -> (f32, f32) {
    let at = |k: usize| k as f32 / (NODES - 1) as f32;
    let first = to_axis(SMALLEST_ALPHA);
    (from_axis(at(i)), from_axis(first + (1.0 - first) * at(j)))
}

impl Table {
    fn new() -> Self {
        let mut table = Self { entries: Vec::with_capacity(2 * NODES * NODES), mean: Vec::with_capacity(NODES) };
        for j in 0..NODES {
            for i in 0..NODES {
                let (cos_o, alpha) = node(i, j);
                let Entry { a, b } = integrate(cos_o, alpha, POINTS);
                table.entries.extend([a, b]);
            }
        }
        // The midpoint rule over cos² θ, which has the cosine in it.
        const STEPS: u32 = 64;
        for j in 0..NODES {
            let (_, alpha) = node(0, j);
            let at = |k: u32| table.entry(((k as f32 + 0.5) / STEPS as f32).sqrt(), alpha);
            let sum: f32 = (0..STEPS).map(|k| at(k).a + at(k).b).sum();
            table.mean.push(sum / STEPS as f32);
        }
        table.mean.extend([0.0; 2]);
        table
    }

    fn entry(&self, cos_o: f32, alpha: f32) -> Entry {
        let ((i, s), (j, t)) = (cell(to_axis(cos_o)), alpha_cell(alpha));
        let mix = |x: Entry, y: Entry, t: f32| Entry { a: x.a + (y.a - x.a) * t, b: x.b + (y.b - x.b) * t };
        let at = |i: usize, j: usize| {
            let node = 2 * (j * NODES + i);
            Entry { a: self.entries[node], b: self.entries[node + 1] }
        };
        mix(mix(at(i, j), at(i + 1, j), s), mix(at(i, j + 1), at(i + 1, j + 1), s), t)
    }

    fn lookup(&self, cos_o: f32, alpha: f32) -> (Entry, f32) {
        let (j, t) = alpha_cell(alpha);
        (self.entry(cos_o, alpha), self.mean[j] + (self.mean[j + 1] - self.mean[j]) * t)
    }
}

/// Node below a position in [0, 1] on an axis, and how far towards the next.
fn cell(x: f32) -> (usize, f32) {
    let position = x * (NODES - 1) as f32;
    let cell = (position as usize).min(NODES - 2);
    (cell, position - cell as f32)
}

fn alpha_cell(alpha: f32) -> (usize, f32) {
    let first = to_axis(SMALLEST_ALPHA);
    cell((to_axis(alpha.max(SMALLEST_ALPHA)) - first) / (1.0 - first))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Too much (a + b) takes light from what lies below the coat, too little gives energy away.
    #[test]
    fn the_table_is_near_the_integral_and_seldom_below() {
        let table = Table::new();
        let (mut most, mut least) = ((0f32, 0.0, 0.0), (0f32, 0.0, 0.0));
        for i in 0..60 {
            for j in 0..40 {
                let cos_o = libm::powf(10.0, -6.0 * (i as f32 + 0.5) / 60.0);
                let alpha = libm::powf(10.0, -3.0 * (j as f32 + 0.5) / 40.0);
                let (true_one, tabled) = (integrate(cos_o, alpha, 4096), table.entry(cos_o, alpha));
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

    #[test]
    fn compensation_is_one_over_e_for_white_and_next_to_nothing_for_a_dielectric() {
        for (cos_o, alpha) in [(0.1, 0.2), (0.7, 0.5), (1.0, 1.0)] {
            let albedo = GgxAlbedo::at(cos_o, alpha);
            let white = albedo.compensation(&Schlick::constant(Vec3::ONE)).x;
            assert!((white * albedo.white() - 1.0).abs() < 1e-5, "{white}");
            let glass = albedo.compensation(&Schlick { f0: Vec3::splat(0.04), f90: Vec3::ONE }).x;
            assert!((1.0..1.2).contains(&glass), "{glass}");
            assert_eq!(albedo.compensation(&Schlick::constant(Vec3::ZERO)), Vec3::ONE);
        }
        // ∫ E(μ) 2μ dμ at α = 1 by the same integrals, without the table.
        let n = 200;
        let sum: f32 =
            (0..n).map(|k| integrate(((k as f32 + 0.5) / n as f32).sqrt(), 1.0, 1024)).map(|e| e.a + e.b).sum();
        assert!((GgxAlbedo::at(0.5, 1.0).mean - sum / n as f32).abs() < 0.003, "{sum}");
    }
}
