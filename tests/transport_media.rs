//! Known answers for light inside bodies: absorption, Fresnel slabs, coloured shadows.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod common;

use common::{add, cube, lambert, mean_and_error, shoot, square, view};
use glam::{DAffine3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{
    ColorInput, Extent, Falloff, Light, LightKind, Material, MetalRough, Phong, ScalarInput, Surface, Volume,
};
use kiln::integrate::Rendered;
use kiln::prepare::EnvironmentSource;
use kiln::settings::{PrepareSettings, RenderSettings, Strategy};
use std::f64::consts::PI;

const ALBEDO: f64 = 0.6;

fn phong_glass(k_t: f64, ior: f32) -> Material {
    let phong = Phong {
        transmission: ColorInput::constant([k_t as f32; 3]),
        ior: ScalarInput::constant(ior),
        ..Phong::default()
    };
    Material { surface: Surface::Phong(phong), ..Material::default() }
}

/// Glass that lets `k_t` through per unit of length.
fn gltf_glass(k_t: f64, ior: f32) -> Material {
    let surface = Surface::MetalRough(MetalRough {
        roughness: ScalarInput::constant(0.0),
        transmission: ScalarInput::constant(1.0),
        ior,
        volume: Some(Volume { attenuation_color: [(k_t * k_t) as f32; 3], attenuation_distance: 2.0 }),
        ..MetalRough::default()
    });
    Material { surface, ..Material::default() }
}

/// A box of 2 half × 2 half × 2 half.z around a point.
fn block(center: DVec3, half: DVec3) -> DAffine3 {
    DAffine3::from_translation(center) * DAffine3::from_scale(half)
}

fn point_light(position: DVec3, through_glass: bool) -> Light {
    Light {
        name: String::new(),
        kind: LightKind::Point { falloff: Falloff::InverseSquare { range: None }, extent: Extent::Point },
        color: [10.0; 3],
        position,
        direction: DVec3::NEG_Z,
        through_glass,
    }
}

/// Straight down from z = 5 on the point (x, 0, 0).
fn look_down(scene: &Scene, x: f64, strategy: Strategy, spp: u32, max_depth: u32) -> Rendered {
    let view = view(DVec3::new(x, 0.0, 5.0), DVec3::X * x, 0.001, 8);
    let settings = RenderSettings { spp, strategy, max_depth, ..RenderSettings::default() };
    let rendered = shoot(scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
    assert_eq!(rendered.nonfinite, 0);
    rendered
}

fn assert_mean(rendered: &Rendered, expected: f64, what: &str) {
    let (mean, error) = mean_and_error(rendered);
    let tolerance = 4.0 * error.max(2e-4 * expected);
    assert!((mean - expected).abs() <= tolerance, "{what}: {mean} ± {error}, expected {expected}");
}

/// Light that goes through a slab straight on: T = (1 − F)² a / (1 − F² a²), a = k_t^d.
#[test]
fn a_slab_transmits_by_fresnel_and_beer() {
    let (k_t, thickness) = (0.7f64, 1.3f64);
    for (material, ior, name) in [
        (phong_glass(k_t, 1.0), 1.0, "phong"),
        (phong_glass(k_t, 1.5), 1.5, "phong"),
        (gltf_glass(k_t, 1.0), 1.0, "glTF"),
        (gltf_glass(k_t, 1.5), 1.5, "glTF"),
    ] {
        let mut scene = Scene::default();
        add(&mut scene, cube(false), material, block(DVec3::Z, DVec3::new(3.0, 3.0, 0.5 * thickness)));
        add(&mut scene, square(), lambert(0.0, 1.0), block(DVec3::NEG_Z, DVec3::splat(3.0)));
        let f = ((ior - 1.0f64) / (ior + 1.0)).powi(2);
        let a = k_t.powf(thickness);
        let expected = (1.0 - f).powi(2) * a / (1.0 - (f * a).powi(2));
        assert_mean(&look_down(&scene, 0.1, Strategy::Mis, 256, 32), expected, &format!("{name}, index {ior}"));
    }
}

/// Shadow rays of `.ray` lights go straight through bodies and lose k_t^length, slant and all; others are blocked.
#[test]
fn shadows_of_glass_are_coloured_where_the_light_says_so() {
    let k_t = 0.4f64;
    for through_glass in [true, false] {
        let mut scene = Scene::default();
        add(&mut scene, square(), lambert(ALBEDO as f32, 0.0), block(DVec3::ZERO, DVec3::splat(5.0)));
        let glass = block(DVec3::new(-2.0, 0.0, 1.0), DVec3::new(1.5, 1.0, 0.15));
        add(&mut scene, cube(false), phong_glass(k_t, 1.5), glass);
        scene.lights.push(point_light(DVec3::new(-3.0, 0.0, 2.0), through_glass));
        // Seen beside the glass at x = 0; halfway to the light the ray is in the glass at x = −1.5.
        let d = 13f64.sqrt();
        let inside = k_t.powf(0.3 * d / 2.0);
        let expected = if through_glass { ALBEDO / PI * 10.0 * 2.0 / d.powi(3) * inside } else { 0.0 };
        assert_mean(&look_down(&scene, 0.0, Strategy::Mis, 4, 1), expected, &format!("through glass: {through_glass}"));
    }
}

/// A body within a body: each stretch is absorbed by the innermost.
#[test]
fn straight_shadows_know_nested_bodies() {
    let (outer, inner) = (0.5f64, 0.8f64);
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(ALBEDO as f32, 0.0), block(DVec3::ZERO, DVec3::splat(5.0)));
    let center = DVec3::new(-1.5, 0.0, 1.0);
    add(&mut scene, cube(false), phong_glass(outer, 1.2), block(center, DVec3::new(1.3, 1.0, 0.5)));
    add(&mut scene, cube(false), phong_glass(inner, 1.4), block(center, DVec3::new(1.0, 0.8, 0.2)));
    scene.lights.push(point_light(DVec3::new(-3.0, 0.0, 2.0), true));
    let d = 13f64.sqrt();
    let per_height = d / 2.0;
    let absorbed = outer.powf(0.6 * per_height) * inner.powf(0.4 * per_height);
    let expected = ALBEDO / PI * 10.0 * 2.0 / d.powi(3) * absorbed;
    assert_mean(&look_down(&scene, 0.0, Strategy::Mis, 4, 1), expected, "nested");
}

/// A floor and a light both within one body of index 1: the light's way is absorbed as well as the viewer's.
#[test]
fn light_samples_inside_a_body_are_absorbed() {
    let k_t = 0.5f64;
    for through_glass in [true, false] {
        let mut scene = Scene::default();
        add(&mut scene, cube(false), phong_glass(k_t, 1.0), block(DVec3::Z, DVec3::new(3.0, 3.0, 2.0)));
        add(&mut scene, square(), lambert(ALBEDO as f32, 0.0), block(DVec3::ZERO, DVec3::splat(1.0)));
        scene.lights.push(point_light(DVec3::new(0.0, 0.0, 1.5), through_glass));
        let expected = k_t.powi(3) * ALBEDO / PI * 10.0 / 2.25 * k_t.powf(1.5);
        let rendered = look_down(&scene, 0.0, Strategy::Mis, 4, 32);
        assert_mean(&rendered, expected, &format!("point light, through glass: {through_glass}"));
    }
}

/// The same with a surface that emits: finding it and sampling it must agree.
#[test]
fn strategies_agree_on_a_lamp_inside_a_body() {
    for material in [phong_glass(0.3, 1.0), gltf_glass(0.3, 1.0)] {
        let mut scene = Scene::default();
        add(&mut scene, cube(false), material, block(DVec3::Z, DVec3::new(3.0, 3.0, 2.0)));
        add(&mut scene, square(), lambert(ALBEDO as f32, 0.0), block(DVec3::ZERO, DVec3::splat(2.0)));
        let down = block(DVec3::new(1.0, 0.0, 1.5), DVec3::splat(0.7)) * DAffine3::from_rotation_x(PI);
        add(&mut scene, square(), lambert(0.0, 5.0), down);
        let shot = |strategy| mean_and_error(&look_down(&scene, 0.0, strategy, 1024, 32));
        let (reference, others) = (shot(Strategy::Cosine), [shot(Strategy::Light), shot(Strategy::Mis)]);
        for other in others {
            let z = (other.0 - reference.0) / (other.1.powi(2) + reference.1.powi(2)).sqrt();
            assert!(z.abs() < 4.0, "{reference:?} and {other:?}");
        }
    }
}
