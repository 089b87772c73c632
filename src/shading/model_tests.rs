//! What the lobes and the models promise, direction by direction.

use super::fresnel::{Interface, Schlick, dielectric, dielectric_f0};
use super::lobe::Lobe;
use super::test_support::*;
use super::*;
use std::f32::consts::FRAC_1_PI;

fn sphere(random: &mut Random) -> Vec3 {
    warp::uniform_sphere(random.square())
}

fn upper(random: &mut Random) -> Vec3 {
    let w = sphere(random);
    Vec3::new(w.x, w.y, w.z.abs().max(1e-3)).normalize()
}

#[test]
fn without_specular_a_dielectric_is_exactly_lambert() {
    let base = Vec3::new(0.8, 0.4, 0.1);
    for roughness in [0.0, 0.3, 1.0] {
        for cos_o in [1e-3, 0.3, 1.0] {
            let p = MetalRoughParams { base_color: base, specular: 0.0, roughness, ..plastic() };
            let bsdf = Bsdf::metal_rough(&p, cos_o);
            for cos_i in [0.01f32, 0.5, 1.0] {
                let (f, pdf) = bsdf.eval(direction(cos_o, 0.3), direction(cos_i, 2.0));
                assert_eq!(f, base * (cos_i * FRAC_1_PI), "roughness {roughness}, cos {cos_o}");
                assert_eq!(pdf, cos_i * FRAC_1_PI);
            }
            let s = bsdf.sample(direction(cos_o, 0.3), 0.5, [0.3, 0.6]).expect("white reflects");
            assert!((s.weight - base).abs().max_element() < 1e-7, "{} is not the albedo", s.weight);
        }
    }
}

#[test]
fn weights_are_value_over_density() {
    let mut random = Random(11);
    for cos_o in [1.0, 0.4, 0.01] {
        let wo = direction(cos_o, 0.7);
        for (name, bsdf) in mixed_materials(cos_o) {
            for _ in 0..2000 {
                let u_lobe = random.next();
                let Some(s) = bsdf.sample(wo, u_lobe, random.square()) else { continue };
                assert_eq!(s.transmitted, s.wi.z < 0.0, "{name}");
                assert!((s.wi.length() - 1.0).abs() < 1e-6, "{name}: {} is not of unit length", s.wi);
                if s.delta {
                    assert!(!s.straight || s.wi == -wo, "{name}: {} for {wo}", s.wi);
                    continue;
                }
                let (value, pdf) = bsdf.eval(wo, s.wi);
                assert!((pdf - s.pdf).abs() <= 1e-6 * pdf, "{name}: pdf {} and {pdf}", s.pdf);
                assert!((s.weight * pdf - value).abs().max_element() <= 1e-5 * value.max_element(), "{name}");
            }
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    let mut random = Random(5);
    for alpha in [1e-3, 0.05, 0.4, 1.0] {
        for (name, lobe) in smooth_lobes(alpha).into_iter().take(4) {
            let bsdf = only(lobe);
            for _ in 0..2000 {
                let (wo, wi) = (upper(&mut random), upper(&mut random));
                let forward = bsdf.eval(wo, wi).0 / wi.z;
                let backward = bsdf.eval(wi, wo).0 / wo.z;
                assert!((forward - backward).abs().max_element() <= 1e-3 * forward.max_element(), "{name}: {wo} {wi}");
            }
        }
    }
}

#[test]
fn refraction_is_reciprocal_but_for_the_squared_index() {
    let mut random = Random(6);
    let eta = 1.5;
    let (mut sum, mut compared) = (0.0, 0u32);
    for alpha in [0.05, 0.4, 1.0] {
        let enter = only(Lobe::RoughDielectric { alpha, interface: Interface::clear(eta) });
        let leave = only(Lobe::RoughDielectric { alpha, interface: Interface::clear(1.0 / eta) });
        for _ in 0..20_000 {
            let (wo, below) = (upper(&mut random), upper(&mut random));
            let forward = enter.eval(wo, Vec3::new(below.x, below.y, -below.z)).0.x / below.z * (eta * eta);
            let backward = leave.eval(below, Vec3::new(wo.x, wo.y, -wo.z)).0.x / wo.z;
            if forward > 1e-4 {
                // Next to the critical angle 1 − sin² cancels, so single pairs keep two digits.
                let off = (forward - backward).abs() / forward;
                assert!(off < 0.03, "α {alpha}: {forward} and {backward}");
                sum += f64::from(off);
                compared += 1;
            } else {
                assert!(backward < 1.1e-4, "α {alpha}: {forward} and {backward}");
            }
        }
    }
    assert!(sum / f64::from(compared) < 2e-4, "off by {} on average", sum / f64::from(compared));
    assert!(compared > 10_000, "only {compared} pairs refract");
}

#[test]
fn reflection_lobes_are_black_below_the_surface() {
    let wo = direction(0.5, 0.3);
    for material in [plastic(), MetalRoughParams { metallic: 1.0, ..plastic() }] {
        let bsdf = Bsdf::metal_rough(&material, 0.5);
        for cos_i in [-1.0, -0.5, -1e-4, 0.0] {
            assert_eq!(bsdf.eval(wo, direction(cos_i, 1.0)), (Vec3::ZERO, 0.0));
        }
    }
    for (name, bsdf) in mixed_materials(0.5) {
        let below = direction(-0.5, 0.3);
        assert_eq!(bsdf.eval(below, wo), (Vec3::ZERO, 0.0), "{name} scatters to a viewer below");
        assert!(bsdf.sample(below, 0.5, [0.5; 2]).is_none(), "{name} scatters to a viewer below");
    }
}

#[test]
fn fresnel_has_known_values() {
    let (f, cos_t) = dielectric(1.0, 1.5).expect("no total reflection from outside");
    assert!((f - 0.04).abs() < 1e-7 && (cos_t - 1.0).abs() < 1e-7);
    // 60° onto n = 1.5: r_s = −0.420 20, r_p = −0.042 45 by Fresnel's equations.
    let (f, _) = dielectric(0.5, 1.5).expect("no total reflection from outside");
    assert!((f - 0.5 * (0.420_20 * 0.420_20 + 0.042_45 * 0.042_45)).abs() < 1e-5, "{f}");
    // Brewster's angle, tan θ = 1.5: r_p = 0, r_s = (1 − n²)/(1 + n²).
    let brewster = 1.0 / (1.0f32 + 1.5 * 1.5).sqrt();
    let (f, _) = dielectric(brewster, 1.5).expect("no total reflection from outside");
    assert!((f - 0.5 * (1.25f32 / 3.25) * (1.25 / 3.25)).abs() < 1e-6, "{f}");
    assert!(dielectric(1e-6, 1.5).is_some_and(|(f, _)| f > 0.999_9), "everything is reflected at grazing");
    assert_eq!(dielectric(0.0, 1.0), Some((0.0, 0.0)));
    assert!((dielectric_f0(0.0) - 1.0).abs() < 1e-7 && dielectric_f0(1.0) == 0.0);
}

#[test]
fn smooth_glass_refracts_by_snell_and_reflects_totally_beyond_the_critical_angle() {
    for (entering, relative) in [(true, 1.5f32), (false, 1.0 / 1.5)] {
        let p = MetalRoughParams { transmission: 1.0, roughness: 0.0, entering, ..plastic() };
        for k in 1..100u8 {
            let cos_o = f32::from(k) / 100.0;
            let wo = direction(cos_o, 0.8);
            let bsdf = Bsdf::metal_rough(&p, cos_o);
            assert!(!bsdf.has_smooth());
            let s = bsdf.sample(wo, 0.999_999, [0.5; 2]).expect("glass absorbs nothing");
            let sin_o = (1.0 - cos_o * cos_o).sqrt();
            if sin_o >= relative {
                assert!(!s.transmitted && s.pdf == 1.0 && s.weight == Vec3::ONE, "cos {cos_o}: {s:?}");
                assert_eq!(s.wi, Vec3::new(-wo.x, -wo.y, wo.z));
                continue;
            }
            assert!(s.transmitted && s.delta && !s.straight, "cos {cos_o}: {s:?}");
            let sin_i = (s.wi.x * s.wi.x + s.wi.y * s.wi.y).sqrt();
            assert!((sin_i * relative - sin_o).abs() < 1e-6, "cos {cos_o}");
            assert!(wo.x * s.wi.y - wo.y * s.wi.x < 1e-6 && wo.x * s.wi.x + wo.y * s.wi.y < 0.0, "out of plane");
            // Radiance shrinks by the squared index on entering and gets it back on leaving.
            assert!((s.weight.x * relative * relative - 1.0).abs() < 1e-5, "cos {cos_o}: {s:?}");
            assert!((s.eta_scale * relative * relative - 1.0).abs() < 1e-6);
        }
    }
}

#[test]
fn walls_and_index_one_let_light_pass_straight_on() {
    let tint = Vec3::new(0.9, 0.5, 0.2);
    let wall = MetalRoughParams { base_color: tint, transmission: 1.0, roughness: 0.0, ..plastic() };
    let thin = MetalRoughParams { thin_walled: true, specular: 0.0, ..wall };
    for p in [thin, MetalRoughParams { ior: 1.0, ..wall }, MetalRoughParams { ior: 1.0, roughness: 0.7, ..wall }] {
        for cos_o in [1e-3, 0.4, 1.0] {
            let wo = direction(cos_o, 2.0);
            let s = Bsdf::metal_rough(&p, cos_o).sample(wo, 0.3, [0.1, 0.9]).expect("passes");
            assert!(s.straight && s.transmitted && s.delta && s.wi == -wo, "{s:?} by {p:?}");
            assert!((s.weight - tint).abs().max_element() < 1e-6 && s.pdf == 1.0, "{s:?} by {p:?}");
        }
    }
    let body = PhongParams { transmission: Vec3::splat(0.5), ior: 1.0, ..black_phong() };
    let s = Bsdf::phong(&body, 0.5).sample(direction(0.5, 0.0), 0.3, [0.1, 0.9]).expect("passes");
    assert!(s.straight && s.weight == Vec3::ONE, "{s:?}");
}

#[test]
fn index_zero_reflects_everything() {
    let p = MetalRoughParams { ior: 0.0, roughness: 0.0, transmission: 1.0, ..plastic() };
    for cos_o in [0.1, 1.0] {
        let s = Bsdf::metal_rough(&p, cos_o).sample(direction(cos_o, 1.0), 0.5, [0.5; 2]).expect("reflects");
        assert!(s.delta && !s.transmitted && (s.weight.x * 1.0 - 1.0).abs() < 1e-6, "{s:?}");
    }
}

#[test]
fn a_ray_body_keeps_fresnel_and_takes_the_hue_of_its_mirror_term() {
    let p = PhongParams { transmission: Vec3::ONE, mirror: Vec3::new(0.5, 0.25, 0.0), ..black_phong() };
    let at = |p: &PhongParams| {
        let s = Bsdf::phong(p, 1.0).sample(Vec3::Z, 0.0, [0.5; 2]).expect("reflects");
        assert!(!s.transmitted);
        s.weight * s.pdf
    };
    assert!((at(&p) - Vec3::new(0.04, 0.02, 0.0)).abs().max_element() < 1e-6, "{}", at(&p));
    let plain = PhongParams { mirror: Vec3::ZERO, ..p };
    assert!((at(&plain) - Vec3::splat(0.04)).abs().max_element() < 1e-6, "{}", at(&plain));
}

#[test]
fn materials_without_terms_are_black() {
    assert!(Bsdf::phong(&black_phong(), 0.5).is_black());
    let p = MetalRoughParams { base_color: Vec3::ZERO, specular: 0.0, ..plastic() };
    let bsdf = Bsdf::metal_rough(&p, 0.5);
    assert!(bsdf.is_black() && !bsdf.has_smooth());
    assert!(bsdf.sample(Vec3::Z, 0.5, [0.5; 2]).is_none());
    let mirror = PhongParams { mirror: Vec3::splat(0.5), ..black_phong() };
    let mirror = Bsdf::phong(&mirror, 0.5);
    assert!(!mirror.is_black() && !mirror.has_smooth());
}

#[test]
fn weights_that_are_no_numbers_are_not_taken_for_absorption() {
    for broken in [f32::NAN, f32::INFINITY] {
        let mut bsdf = Bsdf::BLACK;
        bsdf.push_known(Lobe::Lambert { albedo: Vec3::splat(broken) }, 1.0);
        let sample = bsdf.sample(Vec3::Z, 0.5, [0.5; 2]).expect("goes on, to be counted");
        assert!(!sample.weight.is_finite());
        let mut bsdf = Bsdf::BLACK;
        bsdf.push_known(Lobe::Mirror { fresnel: Schlick::constant(Vec3::splat(broken)) }, 1.0);
        let sample = bsdf.sample(Vec3::Z, 0.5, [0.5; 2]).expect("goes on, to be counted");
        assert!(sample.delta && !sample.weight.is_finite());
    }
}
