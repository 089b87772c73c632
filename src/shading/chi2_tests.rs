//! Directions that lobes sample, against the densities that they claim.

use super::test_support::*;
use super::*;
use crate::math::chi2::chi2_test;
use crate::math::statistics::sidak;
use std::f64::consts::{PI, TAU};

/// Cells over cos θ and over φ.
const ROWS: usize = 40;
const COLUMNS: usize = 40;
const SAMPLES: usize = 1_000_000;
/// Chance of a false alarm for this whole file.
const LEVEL: f64 = 0.01;
/// An upper bound of the calls of [`assert_density`].
const TESTS: usize = 200;

/// Nodes and weights of the 4-point Gauss–Legendre rule on [0, 1].
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// A rectangle of cos θ × φ.
type Cell = [f64; 4];

fn gauss(pdf: &impl Fn(Vec3) -> f32, [z0, z1, p0, p1]: Cell) -> f64 {
    let mut sum = 0.0;
    for (s, weight_s) in GAUSS {
        for (t, weight_t) in GAUSS {
            let (z, phi) = (z0 + (z1 - z0) * s, p0 + (p1 - p0) * t);
            sum += weight_s * weight_t * f64::from(pdf(direction(z as f32, phi as f32)));
        }
    }
    sum * (z1 - z0) * (p1 - p0)
}

/// Integrates over solid angle, halving cells in both directions until that changes nothing.
fn integrate(pdf: &impl Fn(Vec3) -> f32, cell: Cell, whole: f64, depth: u32) -> f64 {
    let [z0, z1, p0, p1] = cell;
    let (zm, pm) = (0.5 * (z0 + z1), 0.5 * (p0 + p1));
    let parts = [[z0, zm, p0, pm], [zm, z1, p0, pm], [z0, zm, pm, p1], [zm, z1, pm, p1]];
    let values = parts.map(|part| gauss(pdf, part));
    let sum: f64 = values.iter().sum();
    if depth == 0 || (sum - whole).abs() < 1e-8 + 1e-5 * sum {
        return sum;
    }
    parts.iter().zip(values).map(|(part, value)| integrate(pdf, *part, value, depth - 1)).sum()
}

/// Tests that `sample` makes directions with density `pdf` and otherwise `None`.
fn assert_density(name: &str, pdf: impl Fn(Vec3) -> f32, mut sample: impl FnMut(&mut Random) -> Option<Vec3>) {
    let mut expected = vec![0.0; ROWS * COLUMNS + 1];
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let z = |r: usize| -1.0 + 2.0 * r as f64 / ROWS as f64;
            let phi = |c: usize| -PI + TAU * c as f64 / COLUMNS as f64;
            let cell = [z(row), z(row + 1), phi(column), phi(column + 1)];
            expected[row * COLUMNS + column] = SAMPLES as f64 * integrate(&pdf, cell, gauss(&pdf, cell), 8);
        }
    }
    let total: f64 = expected.iter().sum::<f64>() / SAMPLES as f64;
    assert!(total < 1.0 + 1e-4, "{name}: the density integrates to {total}");
    expected[ROWS * COLUMNS] = SAMPLES as f64 * (1.0 - total);

    let mut observed = vec![0.0; ROWS * COLUMNS + 1];
    let mut random = Random(7);
    for _ in 0..SAMPLES {
        let cell = sample(&mut random).map_or(ROWS * COLUMNS, |wi| {
            let row = (f64::from(wi.z) + 1.0) * 0.5 * ROWS as f64;
            let column = (libm::atan2(f64::from(wi.y), f64::from(wi.x)) + PI) / TAU * COLUMNS as f64;
            (row as usize).min(ROWS - 1) * COLUMNS + (column as usize).min(COLUMNS - 1)
        });
        observed[cell] += 1.0;
    }
    let test = chi2_test(&observed, &expected);
    assert!(test.p_value > sidak(LEVEL, TESTS), "{name}: density integrates to {total}, {test:?}");
}

/// The directions of a BSDF's smooth lobes.
fn assert_bsdf(name: &str, bsdf: &Bsdf, wo: Vec3) {
    assert_density(
        name,
        |wi| bsdf.eval(wo, wi).1,
        |r| {
            let u_lobe = r.next();
            bsdf.sample(wo, u_lobe, r.square()).filter(|s| !s.delta).map(|s| s.wi)
        },
    );
}

/// From straight above to nearly along the surface.
const COSINES: [f32; 4] = [1.0, 0.7, 0.3, 0.03];

#[test]
fn lobes_sample_what_they_claim() {
    assert_bsdf("lambert", &only(smooth_lobes(0.5)[0].1), direction(0.5, 1.0));
    for alpha in [0.05, 0.3, 1.0] {
        for cos_o in COSINES {
            for (name, lobe) in &smooth_lobes(alpha)[1..] {
                assert_bsdf(&format!("{name}, cos {cos_o}"), &only(*lobe), direction(cos_o, 0.4));
            }
        }
    }
}

#[test]
fn lobes_of_layers_sample_what_they_claim() {
    for (name, lobe) in layer_lobes() {
        for cos_o in [0.8, 0.15] {
            assert_bsdf(&format!("{name}, cos {cos_o}"), &only(lobe), direction(cos_o, 0.4));
        }
    }
    let (name, p, layers) = layered_materials().pop().expect("there are some");
    let wo = direction(0.6, 0.4);
    assert_bsdf(name, &Bsdf::layered(&p, &layers, wo), wo);
}

#[test]
fn mixes_sample_what_they_claim() {
    for cos_o in [0.9, 0.1] {
        for (name, bsdf) in mixed_materials(cos_o) {
            if bsdf.has_smooth() {
                assert_bsdf(&format!("{name}, cos {cos_o}"), &bsdf, direction(cos_o, -2.0));
            }
        }
    }
}

#[test]
fn baselines_sample_what_they_claim() {
    // White everywhere on both sides, so that no sample is dropped for being black.
    let lobes = smooth_lobes(1.0);
    let mut both = Bsdf::BLACK;
    both.push(lobes[0].1, 0.5);
    both.push(lobes[3].1, 0.5);
    let both = both.normalised();
    let wo = direction(0.5, 1.0);
    for baseline in [Baseline::Uniform, Baseline::Cosine] {
        for (name, bsdf) in [("lambert", only(lobes[0].1)), ("both sides", both)] {
            let visible =
                |wi: Vec3| if bsdf.eval(wo, wi).0 == Vec3::ZERO { 0.0 } else { bsdf.baseline_pdf(wi, baseline) };
            assert_density(&format!("{baseline:?} for {name}"), visible, |r| {
                let u_lobe = r.next();
                bsdf.sample_baseline(wo, u_lobe, r.square(), baseline).map(|s| s.wi)
            });
        }
    }
}
