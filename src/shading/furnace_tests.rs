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
/// By how much the albedos of layers together may be too low.
const LAYERS_ERROR: f64 = 0.02;
/// By how much the albedo of an anisotropic lobe may be too low.
const GRAIN_ERROR: f64 = 0.055;

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

/// Metal, plastic, rough glass from both sides and rough thin walls, as white as can be, give back all light at every
/// roughness: what one bounce loses is made up for.
#[test]
fn white_materials_lose_nothing() {
    for cos_o in [0.1, 0.3, 0.7, 1.0] {
        for roughness in [0.1, 0.3, 0.5, 0.8, 1.0] {
            let base = MetalRoughParams { roughness, ..plastic() };
            let glass = MetalRoughParams { transmission: 1.0, ..base };
            let materials = [
                ("metal", MetalRoughParams { metallic: 1.0, ..base }),
                ("half metal", MetalRoughParams { metallic: 0.5, ..base }),
                ("plastic", base),
                ("wall", MetalRoughParams { thin_walled: true, ..glass }),
                ("glass", glass),
                ("glass from inside", MetalRoughParams { entering: false, ..glass }),
                ("half glass", MetalRoughParams { transmission: 0.5, ..base }),
            ];
            for (name, p) in materials {
                let (mean, error) = by_bsdf(&Bsdf::metal_rough(&p, cos_o), direction(cos_o, 0.3), 20_000);
                // The tables of glass err on the dark side by up to 0.05, the others by 0.01.
                let least = if name.contains("glass") { 0.95 } else { 0.99 };
                let spread = most_errors() * error[0];
                assert!(mean[0] + spread > least, "{name}, roughness {roughness}, cos {cos_o}: {mean:?} ± {error:?}");
                assert!(mean[0] - spread < 1.0 + TABLE_ERROR, "{name}, roughness {roughness}, cos {cos_o}: {mean:?}");
            }
        }
    }
}

/// Layers on white materials, and what they may lose: a coat and sheen that take the most that any channel loses from all,
/// films whose reflectance at the viewer's angle stands for all, coats whose normal points elsewhere.
#[test]
fn layers_make_no_light_and_lose_little() {
    let mut darkest = (2.0, String::new());
    for cos_o in [0.05, 0.2, 0.5, 0.8, 1.0] {
        for roughness in [0.0, 0.2, 0.5, 1.0] {
            for (name, p, layers) in layered_materials() {
                let wo = direction(cos_o, 0.3);
                let bsdf = Bsdf::layered(&MetalRoughParams { roughness, ..p }, &layers, wo);
                let (mean, error) = by_bsdf(&bsdf, wo, 10_000);
                let at = format!("{name}, roughness {roughness}, cos {cos_o}: {mean:?} ± {error:?}");
                for c in 0..3 {
                    let most = if name.contains("brushed") { GRAIN_ERROR } else { LAYERS_ERROR };
                    assert!(mean[c] - most_errors() * error[c] < 1.0 + most, "{at}");
                }
                if mean[0] < darkest.0
                    && !matches!(name, "everything" | "bent coat")
                    && !name.contains("film")
                    && !name.contains("brushed")
                {
                    darkest = (mean[0], at);
                }
            }
        }
    }
    println!("the darkest: {darkest:?}");
    assert!(darkest.0 > 0.9, "{darkest:?}");
}

#[test]
fn without_layers_the_layered_model_is_the_plain_one() {
    for p in [plastic(), MetalRoughParams { metallic: 0.3, transmission: 0.5, ..plastic() }] {
        for cos_o in [0.1, 0.9] {
            let wo = direction(cos_o, 0.3);
            let (plain, layered) = (Bsdf::metal_rough(&p, cos_o), Bsdf::layered(&p, &LayerParams::NONE, wo));
            for wi in [direction(0.3, 1.0), direction(0.9, 4.0), direction(-0.6, 3.0)] {
                let ((a, pdf_a), (b, pdf_b)) = (plain.eval(wo, wi), layered.eval(wo, wi));
                assert!((a - b).abs().max_element() <= 1e-6 && (pdf_a - pdf_b).abs() < 1e-5, "{a} {b} {pdf_a} {pdf_b}");
            }
        }
    }
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
