//! Rough lobes and smooth glass in f32 against the same formulas in f64, for random and extreme parameters. Each bound is what
//! rounding the given inputs can do: u = 2⁻²⁴ times how badly the half vector, the cosines and Snell's root are conditioned.

use super::fresnel::{Interface, Schlick};
use super::test_support::{Random, direction};
use super::{dielectric, ggx_reflection, rough_dielectric};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

const U: f64 = 1.0 / 16_777_216.0;
const CASES: usize = 200_000;

/// D G2 / (4 cos θo cos θi) or Walter's equation 21 without Fresnel's share, times |cos θi|, with the cosines at the half vector.
struct Exact {
    value: f64,
    oh: f64,
    ih: f64,
    h: DVec3,
    length: f64,
    d: f64,
}

fn exact(alpha: f64, eta: f64, wo: DVec3, wi: DVec3) -> Exact {
    let up = wi.z > 0.0;
    let sum = if up { wo + wi } else { wo + wi * eta };
    let length = sum.length();
    let h = sum / length * 1f64.copysign(sum.z);
    let a2 = alpha * alpha;
    let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    let distribution = a2 / (PI * d * d);
    let stretched = |w: DVec3| (w.z * w.z + a2 * (w.x * w.x + w.y * w.y)).sqrt();
    let (oh, ih) = (wo.dot(h), wi.dot(h));
    let value = if up {
        0.25 * distribution * 2.0 * wi.z / (wo.z * stretched(wi) + wi.z * stretched(wo))
    } else {
        let g = 4.0 / ((wo.z + stretched(wo)) * (-wi.z + stretched(wi)));
        distribution * g * -wi.z * -ih * oh / (length * length)
    };
    Exact { value, oh, ih, h, length, d }
}

fn reflectance(cosine: f64, eta: f64) -> f64 {
    let cosine_t2 = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if cosine_t2 <= 0.0 {
        return 1.0;
    }
    let cosine_t = cosine_t2.sqrt();
    let s = (cosine - eta * cosine_t) / (cosine + eta * cosine_t);
    let p = (eta * cosine - cosine_t) / (eta * cosine + cosine_t);
    0.5 * (s * s + p * p)
}

fn alpha(random: &mut Random) -> f32 {
    [1e-3, 1.0, 1e-3 + random.next(), libm::powf(10.0, -3.0 * random.next())][(random.next() * 4.0) as usize].min(1.0)
}

fn index(random: &mut Random) -> f32 {
    let step = libm::powf(10.0, -2.9 * random.next());
    let eta = 1.0 + 1.5 * step;
    if random.next() < 0.5 { eta } else { 1.0 / eta }
}

/// A direction, at grazing angles half of the time.
fn viewer(random: &mut Random) -> Vec3 {
    let cosine = if random.next() < 0.5 { random.next() } else { libm::powf(10.0, -5.0 * random.next()) };
    direction(cosine.max(1e-5), std::f32::consts::TAU * random.next()).normalize()
}

/// A light's direction: anywhere, or near where a facet's normal near the surface's sends the viewer's.
fn light(random: &mut Random, alpha: f32, eta: f32, wo: Vec3) -> Vec3 {
    let sign = if random.next() < 0.5 { 1.0 } else { -1.0 };
    if random.next() < 0.3 {
        let w = viewer(random);
        return Vec3::new(w.x, w.y, w.z * sign);
    }
    let tilt = alpha * random.next() * 3.0;
    let turn = std::f32::consts::TAU * random.next();
    let h = Vec3::new(tilt * libm::cosf(turn), tilt * libm::sinf(turn), 1.0).normalize();
    let cosine = wo.dot(h);
    let mirrored = (h * (2.0 * cosine) - wo).normalize();
    let root = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    if sign > 0.0 || root <= 0.0 { mirrored } else { (h * (cosine / eta - root.sqrt()) - wo / eta).normalize() }
}

#[test]
fn rough_metal_is_what_double_precision_says() {
    let mut random = Random(1);
    let fresnel = Schlick::constant(Vec3::ONE);
    let mut compared = 0;
    for _ in 0..CASES {
        let (alpha, wo) = (alpha(&mut random), viewer(&mut random));
        let wi = light(&mut random, alpha, 1.0, wo);
        if wi.z <= 0.0 {
            continue;
        }
        let wanted = exact(f64::from(alpha), 1.0, wo.as_dvec3(), wi.as_dvec3()).value;
        let got = f64::from(ggx_reflection::eval(alpha, &fresnel, wo, wi).x);
        assert!((got - wanted).abs() <= 64.0 * U * wanted + 1e-30, "α {alpha}, {wo} {wi}: {got}, in f64 {wanted}");
        compared += 1;
    }
    assert!(compared > CASES / 3);
}

#[test]
fn rough_glass_is_what_double_precision_says() {
    let mut random = Random(2);
    let (mut compared, mut sharp) = (0, 0);
    for _ in 0..CASES {
        let (alpha, eta, wo) = (alpha(&mut random), index(&mut random), viewer(&mut random));
        let wi = light(&mut random, alpha, eta, wo);
        let interface = Interface::clear(eta);
        let eta = f64::from(eta);
        let e = exact(f64::from(alpha), eta, wo.as_dvec3(), wi.as_dvec3());
        let up = wi.z > 0.0;
        // Facets that are seen edge-on, or whose side rounding decides.
        if e.oh < 1e-4 || (!up && -e.ih < 1e-4) || e.h.z < 1e-4 || wi.z.abs() < 1e-6 {
            continue;
        }
        let share = reflectance(e.oh, eta);
        let wanted = e.value * if up { share } else { 1.0 - share };
        let got = f64::from(rough_dielectric::eval(alpha, &interface, wo, wi).x);
        // How much a rounding of the sum moves the half vector; for reflections it is relative to each component.
        let moved = if up { 1.0 } else { (1.0 + eta) / e.length };
        let tilt = if up { 1.0 } else { (e.h.x * e.h.x + e.h.y * e.h.y).sqrt() / e.d };
        let snell = 1.0 - (1.0 - e.oh * e.oh) / (eta * eta);
        let root = if snell > 0.0 { 1.0 / (snell * eta * eta) } else { 1.0 / -snell };
        let fresnel = e.oh.max(U) * root + 1.0 / e.oh;
        // Where the share is small its absolute error counts: F near index 1, 1 − F near total reflection.
        let small = 1.0 / if up { share } else { 1.0 - share }.max(U);
        let bound = U
            * 32.0
            * moved
            * (1.0 + tilt + fresnel * if up { small.min(1e3) } else { 1.0 } + if up { 0.0 } else { 1.0 / -e.ih });
        if snell.abs() * eta * eta < 1e-4 || bound > 0.1 {
            continue;
        }
        compared += 1;
        sharp += usize::from(bound < 1e-3);
        assert!(
            (got - wanted).abs() <= bound * wanted + 1e-30,
            "α {alpha}, η {eta}, {wo} {wi}: {got}, in f64 {wanted}, bound {bound}"
        );
    }
    assert!(compared > CASES / 2 && sharp > CASES / 3, "{compared} compared, {sharp} sharply");
}

#[test]
fn refraction_follows_snell_as_double_precision_has_it() {
    let mut random = Random(3);
    let mut compared = 0;
    for _ in 0..CASES {
        let (eta, wo) = (index(&mut random), viewer(&mut random));
        let interface = Interface::clear(eta);
        if interface.is_straight() {
            continue;
        }
        let (eta, o) = (f64::from(eta), wo.as_dvec3());
        let root = 1.0 - (1.0 - o.z * o.z) / (eta * eta);
        let share = reflectance(o.z, eta);
        let Some(delta) = dielectric::sample(&interface, wo, 1.0 - f32::EPSILON) else { continue };
        // Whether it is total reflection is rounding's choice within some ulps of the critical angle.
        if root.abs() < 16.0 * U / (eta * eta) {
            continue;
        }
        assert_eq!(delta.wi.z < 0.0, root > 0.0 && delta.probability > 0.0, "η {eta}, {wo}");
        if root > 0.0 {
            let wanted = DVec3::new(-o.x / eta, -o.y / eta, -root.sqrt()).normalize();
            let bound = 8.0 * U * (1.0 + 1.0 / (eta * eta * root.sqrt()));
            let off = (delta.wi.as_dvec3() - wanted).length();
            assert!(off <= bound, "η {eta}, {wo}: off by {off}, bound {bound}");
            let value = f64::from(delta.value.x) * eta * eta;
            let bound = 16.0 * U * (1.0 + 1.0 / (eta * eta * root) + 1.0 / o.z);
            assert!(
                (value - (1.0 - share)).abs() <= bound * (1.0 - share),
                "η {eta}, {wo}: {value}, in f64 {}",
                1.0 - share
            );
            compared += 1;
        }
    }
    assert!(compared > CASES / 2);
}
