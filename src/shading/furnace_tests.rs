//! Energy: what comes out of a white furnace is never brighter than the furnace.

use super::fresnel::Interface;
use super::lobe::Lobe;
use super::test_support::*;
use super::*;
use crate::math::statistics::{normal_quantile, sidak};

/// Mean and standard error per channel of what a furnace of radiance 1 (η² inside bodies) sends to the viewer.
fn furnace(samples: u32, mut sample: impl FnMut(&mut Random) -> Option<BsdfSample>) -> ([f64; 3], [f64; 3]) {
    let mut random = Random(3);
    let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
    for _ in 0..samples {
        let Some(s) = sample(&mut random) else { continue };
        let weight = (s.weight / s.eta_scale).to_array().map(f64::from);
        for c in 0..3 {
            sum[c] += weight[c];
            squares[c] += weight[c] * weight[c];
        }
    }
    let n = f64::from(samples);
    let mean = sum.map(|s| s / n);
    let error = [0, 1, 2].map(|c| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / (n - 1.0)).sqrt());
    (mean, error)
}

fn by_bsdf(bsdf: &Bsdf, wo: Vec3, samples: u32) -> ([f64; 3], [f64; 3]) {
    furnace(samples, |r| {
        let u_lobe = r.next();
        bsdf.sample(wo, u_lobe, r.square())
    })
}

/// Standard errors that 10 000 means exceed together with probability 0.01.
fn most_errors() -> f64 {
    normal_quantile(1.0 - 0.5 * sidak(0.01, 10_000))
}

const COSINES: [f32; 6] = [1e-5, 0.01, 0.1, 0.3, 0.7, 1.0];
const ROUGHNESSES: [f32; 7] = [0.0, 0.04, 0.15, 0.3, 0.5, 0.8, 1.0];
/// By how much the albedo table may be too low: a white plastic sends E(true) + 1 − E(table).
const TABLE_ERROR: f64 = 0.005;

#[test]
fn no_material_sends_more_than_it_gets() {
    let mut brightest = (0.0, String::new());
    for cos_o in COSINES {
        for roughness in ROUGHNESSES {
            for metallic in [0.0, 0.5] {
                for transmission in [0.0, 0.6, 1.0] {
                    for (specular, ior) in [(1.0, 1.5), (1.0, 2.4), (0.5, 1.5), (1.0, 1.0), (1.0, 0.0), (0.0, 1.33)] {
                        for (thin_walled, entering) in [(true, true), (false, true), (false, false)] {
                            let p = MetalRoughParams {
                                roughness,
                                metallic,
                                transmission,
                                specular,
                                ior,
                                thin_walled,
                                entering,
                                ..plastic()
                            };
                            let bsdf = Bsdf::metal_rough(&p, cos_o);
                            let (mean, error) = by_bsdf(&bsdf, direction(cos_o, 0.3), 3000);
                            let most = mean[0] - most_errors() * error[0];
                            if mean[0] > brightest.0 && error[0] < 1e-3 {
                                brightest = (mean[0], format!("cos {cos_o}, {p:?}"));
                            }
                            assert!(most < 1.0 + TABLE_ERROR, "cos {cos_o}: {} ± {} by {p:?}", mean[0], error[0]);
                        }
                    }
                }
            }
        }
    }
    println!("the brightest: {} at {}", brightest.0, brightest.1);
}

#[test]
fn ray_materials_conserve_energy_whatever_their_terms_add_up_to() {
    for cos_o in COSINES {
        for exponent in [0.0, 1.0, 20.0, 1e5, 1e8] {
            for (transmission, entering) in [(0.0, true), (0.5, true), (0.5, false)] {
                let p = PhongParams {
                    diffuse: Vec3::new(1.0, 1.0, 0.5),
                    specular: Vec3::new(0.15, 1.0, 10.0),
                    exponent,
                    mirror: Vec3::new(0.0, 0.4, 1.0),
                    transmission: Vec3::splat(transmission),
                    entering,
                    ..black_phong()
                };
                let (mean, error) = by_bsdf(&Bsdf::phong(&p, cos_o), direction(cos_o, 0.3), 20_000);
                for c in 0..3 {
                    assert!(mean[c] - most_errors() * error[c] < 1.0 + 1e-5, "cos {cos_o}: {mean:?} by {p:?}");
                }
            }
        }
    }
}

#[test]
fn terms_that_fit_are_not_scaled() {
    let p = PhongParams { diffuse: Vec3::splat(0.5), mirror: Vec3::splat(0.3), ..black_phong() };
    let (mean, error) = by_bsdf(&Bsdf::phong(&p, 0.5), direction(0.5, 0.3), 20_000);
    assert!((mean[0] - 0.8).abs() < 1e-5 + most_errors() * error[0], "{mean:?} ± {error:?}");
}

#[test]
fn smooth_lobes_of_a_white_material_lose_only_what_single_scattering_loses() {
    for (alpha, least) in [(0.01f32, 0.995), (0.1, 0.95), (0.3, 0.8), (1.0, 0.35)] {
        for (name, lobe) in smooth_lobes(alpha) {
            let (mean, error) = by_bsdf(&only(lobe), direction(0.7, 0.3), 20_000);
            assert!(mean[0] <= 1.0 + 1e-5 + most_errors() * error[0], "{name}: {mean:?}");
            assert!(mean[0] > least, "{name}: {mean:?}");
        }
    }
}

#[test]
fn smooth_glass_splits_light_without_loss() {
    for eta in [1.5, 1.0 / 1.5, 2.4, 1.0 + 1e-7, 1.0 - 1e-7, 1.0, 1.0 + 1e-5, 1.001, 0.3, 50.0] {
        let bsdf = only(Lobe::Dielectric { interface: Interface::clear(eta) });
        for cos_o in [1e-5, 0.01, 0.3, 0.7, 1.0] {
            let wo = direction(cos_o, 0.3);
            let mut total = 0.0;
            let mut seen = [false; 2];
            for k in 0..4096 {
                let Some(s) = bsdf.sample(wo, (k as f32 + 0.5) / 4096.0, [0.5; 2]) else { panic!("glass absorbs") };
                if !std::mem::replace(&mut seen[usize::from(s.transmitted)], true) {
                    total += s.weight.x / s.eta_scale * s.pdf;
                }
            }
            // A share below 1/4096 may not have been seen.
            assert!((total - 1.0).abs() < 3e-4, "η {eta}, cos {cos_o}: {total}");
        }
    }
}

#[test]
fn reflection_loses_exactly_what_single_scattering_loses() {
    // 1 − ln 2 follows from D, G2 and μ at α = 1 seen from above; the others are the integral of F D G2 / (4 cos θo)
    // by the midpoint rule over 400 × 400 cells, D in the textbook form.
    for (alpha, cos_o, albedo) in
        [(1.0, 1.0, 1.0 - std::f64::consts::LN_2), (0.3, 0.7, 0.844_53), (1.0, 0.7, 0.378_89), (0.1, 0.7, 0.981_42)]
    {
        let bsdf = only(smooth_lobes(alpha)[1].1);
        let (mean, error) = by_bsdf(&bsdf, direction(cos_o, 0.3), 400_000);
        assert!((mean[0] - albedo).abs() < 5.0 * error[0] + 2e-5, "α {alpha}, cos {cos_o}: {} not {albedo}", mean[0]);
    }
}

#[test]
fn every_strategy_finds_the_same_albedo() {
    for cos_o in [0.9, 0.3] {
        let wo = direction(cos_o, 0.3);
        for (name, bsdf) in mixed_materials(cos_o) {
            let (a, error_a) = by_bsdf(&bsdf, wo, 200_000);
            for baseline in [Baseline::Uniform, Baseline::Cosine] {
                let (b, error_b) = furnace(200_000, |r| {
                    let u_lobe = r.next();
                    bsdf.sample_baseline(wo, u_lobe, r.square(), baseline)
                });
                for c in 0..3 {
                    let z = (a[c] - b[c]).abs() / (1e-12 + error_a[c] * error_a[c] + error_b[c] * error_b[c]).sqrt();
                    assert!(z < most_errors(), "{name}, {baseline:?}, cos {cos_o}: {a:?} against {b:?}, z = {z}");
                }
            }
        }
    }
}
