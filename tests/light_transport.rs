//! Closed forms: pictures whose exact value is known.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::{add, cube, lambert, mean_and_error, shoot, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{Extent, Falloff, Light, LightKind, Mesh};
use kiln::prepare::EnvironmentSource;
use kiln::settings::{PrepareSettings, RenderSettings, SamplerKind, Strategy};

const STRATEGIES: [Strategy; 5] =
    [Strategy::Hemisphere, Strategy::Cosine, Strategy::Bsdf, Strategy::Light, Strategy::Mis];

/// A white body in a white world cannot be seen: every pixel is exactly 1, with flat faces and with smooth normals.
#[test]
fn furnace_is_exact() {
    for mesh in [Mesh { normals: Vec::new(), ..sphere(3) }, sphere(3), sphere(1)] {
        furnace_is_exact_with(mesh);
    }
}

fn furnace_is_exact_with(mesh: Mesh) {
    let mut scene = Scene::default();
    add(&mut scene, mesh, lambert(1.0, 0.0), DAffine3::IDENTITY);
    let view = view(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0, 32);
    let world = EnvironmentSource::Constant([1.0; 3]);
    let settings = RenderSettings { spp: 16, max_depth: 8, ..RenderSettings::default() };
    let rendered = shoot(&scene, &world, &PrepareSettings::default(), &settings, &view);
    for pixel in &rendered.picture.pixels {
        assert!((pixel[0] - 1.0).abs() < 1e-4, "{pixel:?}");
    }
}

/// Inside a closed box that emits Le everywhere and reflects with albedo a, all light is Le / (1 − a), or the sum of
/// the first d + 1 terms of that series when paths end after d scatterings.
#[test]
fn glowing_box_is_a_geometric_series() {
    for albedo in [0.0f32, 0.5, 0.9] {
        let mut scene = Scene::default();
        add(&mut scene, cube(true), lambert(albedo, 0.7), DAffine3::IDENTITY);
        let view = view(DVec3::new(0.3, -0.2, 0.5), DVec3::new(-1.0, 0.4, -0.8), 70.0, 16);
        for strategy in STRATEGIES {
            let settings = RenderSettings { spp: 64, max_depth: 12, strategy, ..RenderSettings::default() };
            let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
            let (mean, error) = mean_and_error(&rendered);
            let a = f64::from(albedo);
            let expected = 0.7 * (1.0 - a.powi(13)) / (1.0 - a);
            let z = (mean - expected) / error.max(1e-6 * expected);
            assert!(z.abs() < 4.0, "albedo {albedo}, {strategy:?}: {mean} ± {error}, expected {expected}");
        }
    }
}

/// The radiance that a Lambert floor reflects under a point light at height h: ρ/π · I · cos / d².
#[test]
fn point_light_follows_its_closed_form() {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(0.6, 0.0), DAffine3::from_scale(DVec3::splat(1000.0)));
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point { falloff: Falloff::InverseSquare { range: None }, extent: Extent::Point },
        color: [50.0; 3],
        position: DVec3::new(100.0, 0.0, 40.0),
        direction: DVec3::NEG_Z,
        through_glass: false,
    });
    let view = view(DVec3::new(130.0, 0.0, 20.0), DVec3::new(130.0, 0.0, 0.0), 0.001, 4);
    for strategy in STRATEGIES {
        let settings = RenderSettings { spp: 4, strategy, ..RenderSettings::default() };
        let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
        let expected = 0.6 / std::f64::consts::PI * 50.0 * (40.0 / 50.0) / 2500.0;
        let got = f64::from(rendered.picture.pixels[5][0]);
        assert!((got / expected - 1.0).abs() < 1e-4, "{strategy:?}: {got}, expected {expected}");
    }
}

/// A square light of side 2 at distance 1 over a parallel floor: radiance ρ·L·F, F the form factor from a point
/// below the centre: 4 · (2/π)·(1/√2)·atan(1/√2)/2 (Howell's catalogue, B-4).
#[test]
fn square_light_has_the_form_factor_of_the_catalogue() {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(0.5, 0.0), DAffine3::from_scale(DVec3::splat(50.0)));
    let down = DAffine3::from_translation(DVec3::Z) * DAffine3::from_rotation_x(std::f64::consts::PI);
    add(&mut scene, square(), lambert(0.0, 3.0), down);
    // Between floor and light, looking straight down at the point under the light's centre.
    let view = view(DVec3::new(0.0, 0.0, 0.5), DVec3::ZERO, 0.001, 8);
    let corner = std::f64::consts::FRAC_1_SQRT_2;
    let form_factor = 4.0 * (2.0 * corner * corner.atan()) / (2.0 * std::f64::consts::PI);
    let expected = 0.5 * 3.0 * form_factor;
    for strategy in STRATEGIES {
        for light_samples in [None, Some(1), Some(3)] {
            for sampler in [SamplerKind::Sobol, SamplerKind::Pcg, SamplerKind::Lcg, SamplerKind::Xorshift32] {
                let settings =
                    RenderSettings { spp: 256, strategy, light_samples, sampler, ..RenderSettings::default() };
                let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
                let (mean, error) = mean_and_error(&rendered);
                let z = (mean - expected) / error;
                assert!(z.abs() < 4.5, "{strategy:?} {sampler:?}: {mean} ± {error}, expected {expected}");
            }
        }
    }
}

/// The same asset at 2ᵏ times its size gives the same bytes, and far from the origin nearly the same picture.
#[test]
fn pictures_do_not_depend_on_scale_or_place() {
    let picture = |scale: f64, offset: DVec3| {
        let mut scene = Scene::default();
        let place = DAffine3::from_translation(offset) * DAffine3::from_scale(DVec3::splat(scale));
        add(&mut scene, cube(true), lambert(0.7, 0.0), place);
        add(&mut scene, sphere(3), lambert(0.5, 0.0), place * DAffine3::from_scale(DVec3::splat(0.4)));
        let lamp = DAffine3::from_translation(DVec3::Y * 0.99) * DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
        add(&mut scene, square(), lambert(0.0, 5.0), place * lamp * DAffine3::from_scale(DVec3::splat(0.3)));
        let at = |p: DVec3| offset + p * scale;
        let view = view(at(DVec3::new(0.1, 0.2, 0.9)), at(DVec3::ZERO), 60.0, 24);
        let settings = RenderSettings { spp: 8, ..RenderSettings::default() };
        shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view)
    };
    let reference = picture(1.0, DVec3::ZERO);
    assert!(mean_and_error(&reference).0 > 0.1);
    for k in [-20, -1, 1, 20] {
        assert!(picture(2f64.powi(k), DVec3::ZERO).picture == reference.picture, "scale 2^{k}");
    }
    for (scale, offset) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e6), (3.0, -1e5)] {
        let other = picture(scale, DVec3::new(offset, -offset, offset));
        let (a, b) = (mean_and_error(&reference), mean_and_error(&other));
        let z = (a.0 - b.0) / (a.1.powi(2) + b.1.powi(2)).sqrt();
        assert!(z.abs() < 3.0, "scale {scale}, offset {offset}: {a:?} {b:?}");
    }
}
