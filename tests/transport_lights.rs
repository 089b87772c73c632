//! Known answers for lights: cones, fall-offs, soft shadows, the environment's directions, extreme scales.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod common;

use common::{add, cube, lambert, mean_and_error, shoot, sphere, square, view};
use glam::{DAffine3, DMat3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{
    Alpha, AlphaMode, ColorInput, Extent, Falloff, Image, Light, LightKind, Material, Mesh, Phong, Pixels, ScalarInput,
    Surface, UpAxis,
};
use kiln::integrate::Rendered;
use kiln::prepare::EnvironmentSource;
use kiln::settings::{PrepareSettings, RenderSettings, SamplerKind};
use std::f64::consts::PI;

const ALBEDO: f64 = 0.6;
const INVERSE_SQUARE: Falloff = Falloff::InverseSquare { range: None };

fn light(kind: LightKind, color: f32, position: DVec3, direction: DVec3) -> Light {
    Light { name: String::new(), kind, color: [color; 3], position, direction, through_glass: false }
}

/// A floor at z = 0 under a light.
fn floor_under(light: Light) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(ALBEDO as f32, 0.0), DAffine3::from_scale(DVec3::splat(50.0)));
    scene.lights.push(light);
    scene
}

/// The floor at `point`, seen straight down from near by.
fn look_at_floor(scene: &Scene, point: DVec3, settings: &RenderSettings) -> Rendered {
    let view = view(point + DVec3::Z * 0.05, point, 0.001, 4);
    shoot(scene, &EnvironmentSource::None, &PrepareSettings::default(), settings, &view)
}

fn radiance_at(scene: &Scene, point: DVec3) -> f64 {
    let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
    f64::from(look_at_floor(scene, point, &settings).picture.pixels[5][0])
}

fn assert_near(got: f64, expected: f64, what: &str) {
    assert!((got - expected).abs() <= 1e-3 * expected, "{what}: {got}, expected {expected}");
}

fn assert_within_error(rendered: &Rendered, expected: f64, what: &str) {
    let (mean, error) = mean_and_error(rendered);
    let z = (mean - expected) / error.max(1e-5 * expected);
    assert!(z.abs() < 4.0, "{what}: {mean} ± {error}, expected {expected}");
}

#[test]
fn spot_light_has_the_cone_of_khr_lights_punctual() {
    let (inner, outer, height) = (0.3f64, 0.6f64, 2.0);
    let kind = LightKind::Spot { falloff: INVERSE_SQUARE, inner, outer };
    let scene = floor_under(light(kind, 10.0, DVec3::Z * height, DVec3::NEG_Z));
    for angle in [0.0f64, 0.2, 0.45, 0.55] {
        let cone = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2);
        let d2 = (height / angle.cos()).powi(2);
        let expected = ALBEDO / PI * 10.0 * cone * angle.cos() / d2;
        assert_near(radiance_at(&scene, DVec3::X * (height * angle.tan())), expected, &format!("angle {angle}"));
    }
    assert_eq!(radiance_at(&scene, DVec3::X * (height * 0.61f64.tan())), 0.0);
}

/// A cone so narrow that both its cosines are the same number.
#[test]
fn the_narrowest_spot_is_finite() {
    let kind = LightKind::Spot { falloff: INVERSE_SQUARE, inner: 0.0, outer: 1e-9 };
    let scene = floor_under(light(kind, 10.0, DVec3::Z * 2.0, DVec3::NEG_Z));
    for x in [0.0, 1e-3, 1.0] {
        let rendered = look_at_floor(&scene, DVec3::X * x, &RenderSettings { spp: 4, ..RenderSettings::default() });
        assert_eq!(rendered.nonfinite, 0);
    }
}

#[test]
fn fall_offs_follow_their_formulas() {
    let cases = [
        (Falloff::InverseSquare { range: Some(3.0) }, 2.0, (1.0 - 16.0 / 81.0) / 4.0),
        (Falloff::InverseSquare { range: Some(3.0) }, 3.5, 0.0),
        (Falloff::Clamped { constant: 0.0, linear: 0.0, quadratic: 1.0 }, 0.5, 1.0),
        (Falloff::Clamped { constant: 0.0, linear: 0.0, quadratic: 1.0 }, 2.0, 0.25),
        (Falloff::Clamped { constant: 0.25, linear: 0.003_372_407, quadratic: 0.000_045_492 }, 20.0, 1.0),
        (Falloff::Clamped { constant: 0.5, linear: 0.5, quadratic: 0.25 }, 4.0, 1.0 / 6.5),
        (Falloff::Clamped { constant: 0.0, linear: 0.0, quadratic: 0.0 }, 4.0, 1.0),
    ];
    for (falloff, height, factor) in cases {
        let kind = LightKind::Point { falloff, extent: Extent::Point };
        let scene = floor_under(light(kind, 3.0, DVec3::Z * height, DVec3::NEG_Z));
        assert_near(radiance_at(&scene, DVec3::ZERO), ALBEDO / PI * 3.0 * factor, &format!("{falloff:?} at {height}"));
    }
}

#[test]
fn directional_light_gives_its_irradiance() {
    let direction = DVec3::new(0.6, 0.0, -0.8);
    let scene = floor_under(light(LightKind::Directional, 3.0, DVec3::ZERO, direction));
    assert_near(radiance_at(&scene, DVec3::ZERO), ALBEDO / PI * 3.0 * 0.8, "cosine 0.8");
}

fn disc(radius: f64, position: DVec3) -> Light {
    let kind = LightKind::Point { falloff: INVERSE_SQUARE, extent: Extent::Disc { radius } };
    light(kind, 10.0, position, DVec3::NEG_Z)
}

/// `area_light`: point shading times the visible fraction of the disc, here one half behind a screen's edge.
#[test]
fn half_covered_disc_gives_half_the_light() {
    let mut scene = floor_under(disc(0.5, DVec3::Z * 2.0));
    let screen = DAffine3::from_translation(DVec3::new(10.0, 0.0, 1.0)) * DAffine3::from_scale(DVec3::splat(10.0));
    add(&mut scene, square(), lambert(0.0, 0.0), screen);
    let rendered = look_at_floor(&scene, DVec3::ZERO, &RenderSettings { spp: 1024, ..RenderSettings::default() });
    assert_within_error(&rendered, 0.5 * ALBEDO / PI * 10.0 / 4.0, "half a disc");
}

/// A disc that hangs partly below the floor's horizon: that part is hidden by the floor itself.
#[test]
fn a_disc_is_cut_by_the_horizon() {
    let (position, radius) = (DVec3::new(2.0, 0.0, 0.2), 0.5f64);
    let scene = floor_under(disc(radius, position));
    // Height of the centre above the floor, measured in the disc's plane.
    let h = position.z * position.length() / position.x;
    let below = radius.powi(2) * (h / radius).acos() - h * (radius.powi(2) - h * h).sqrt();
    let visible = 1.0 - below / (PI * radius.powi(2));
    let expected = visible * ALBEDO / PI * 10.0 * position.z / position.length().powi(3);
    let rendered = look_at_floor(&scene, DVec3::ZERO, &RenderSettings { spp: 1024, ..RenderSettings::default() });
    assert_within_error(&rendered, expected, &format!("visible {visible}"));
}

/// Light samples are independent of each other, also in what half-covering surfaces let through.
#[test]
fn light_samples_average_coverage() {
    let point = LightKind::Point { falloff: INVERSE_SQUARE, extent: Extent::Point };
    let mut scene = floor_under(light(point, 10.0, DVec3::Z * 2.0, DVec3::NEG_Z));
    let half = Alpha { mode: AlphaMode::Blend, value: ScalarInput::constant(0.5) };
    let sheet = DAffine3::from_translation(DVec3::new(0.3, 0.1, 1.0));
    add(&mut scene, square(), Material { alpha: half, ..lambert(0.0, 0.0) }, sheet);
    let error = |light_samples| {
        let settings = RenderSettings {
            spp: 256,
            light_samples: Some(light_samples),
            sampler: SamplerKind::Pcg,
            ..RenderSettings::default()
        };
        let rendered = look_at_floor(&scene, DVec3::ZERO, &settings);
        assert_within_error(&rendered, 0.5 * ALBEDO / PI * 10.0 / 4.0, &format!("{light_samples} light samples"));
        mean_and_error(&rendered).1
    };
    let (one, sixteen) = (error(1), error(16));
    assert!(sixteen < 0.5 * one, "{sixteen} with 16 samples, {one} with one");
}

/// An environment that shows to each direction the direction itself.
fn compass(rotation_y: f32) -> EnvironmentSource {
    let (width, height) = (512u32, 256u32);
    let mut pixels = Vec::new();
    for y in 0..height {
        let (sin, cos) = ((f64::from(y) + 0.5) / f64::from(height) * PI).sin_cos();
        for x in 0..width {
            let phi = ((f64::from(x) + 0.5) / f64::from(width) - 0.5) * 2.0 * PI;
            let d = DVec3::new(sin * phi.cos(), cos, sin * phi.sin()) * 0.5 + 0.5;
            pixels.extend([d.x as f32, d.y as f32, d.z as f32, 1.0]);
        }
    }
    let image = Image { name: String::new(), width, height, pixels: Pixels::RgbaF32(pixels) };
    EnvironmentSource::Image { image, rotation_y, intensity: 1.0 }
}

#[test]
fn a_mirror_shows_the_environment_where_it_is() {
    let mirror = Phong { mirror: ColorInput::WHITE, ..Phong::default() };
    for up in [UpAxis::Y, UpAxis::Z] {
        for rotation in [0.0f64, 0.7, -2.0] {
            let mut scene = Scene { up, ..Scene::default() };
            let material = Material { surface: Surface::Phong(mirror), ..Material::default() };
            add(&mut scene, square(), material, DAffine3::IDENTITY);
            let eye = DVec3::new(1.0, 0.4, 0.8);
            let view = view(eye, DVec3::ZERO, 0.01, 2);
            let environment = compass(rotation as f32);
            let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
            let rendered = shoot(&scene, &environment, &PrepareSettings::default(), &settings, &view);
            let reflected = DVec3::new(-eye.x, -eye.y, eye.z).normalize();
            // The picture's up is +Y; turning it counter-clockwise about its up axis.
            let upright = if up == UpAxis::Z { DVec3::new(reflected.x, reflected.z, -reflected.y) } else { reflected };
            let expected = DMat3::from_rotation_y(-rotation) * upright * 0.5 + 0.5;
            let [r, g, b, _] = rendered.picture.pixels[0].map(f64::from);
            assert!((DVec3::new(r, g, b) - expected).length() < 0.01, "{up:?} {rotation}: {r} {g} {b}, {expected}");
        }
    }
}

/// Radiance has no scale: a lamp and the sun in a box give the same bytes at 2ᵏ times the size, however extreme.
#[test]
fn choice_among_lights_survives_extreme_scales() {
    let picture = |scale: f64| {
        let mut scene = Scene::default();
        let place = DAffine3::from_scale(DVec3::splat(scale));
        add(&mut scene, square(), lambert(0.7, 0.0), place);
        add(&mut scene, sphere(2), lambert(0.5, 0.0), place * DAffine3::from_scale(DVec3::splat(0.4)));
        let lamp = DAffine3::from_translation(DVec3::Z) * DAffine3::from_rotation_x(PI);
        add(&mut scene, square(), lambert(0.0, 5.0), place * lamp * DAffine3::from_scale(DVec3::splat(0.3)));
        scene.lights.push(light(LightKind::Directional, 1.0, DVec3::ZERO, DVec3::new(0.0, 0.6, -0.8)));
        let view = view(DVec3::new(0.1, -1.0, 0.9) * scale, DVec3::ZERO, 60.0, 16);
        let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
        let world = EnvironmentSource::Constant([0.1; 3]);
        let rendered = shoot(&scene, &world, &PrepareSettings::default(), &settings, &view);
        assert_eq!(rendered.nonfinite, 0, "scale {scale}");
        rendered.picture
    };
    let reference = picture(1.0);
    for k in [-90, -70, 70, 90] {
        assert!(picture(2f64.powi(k)) == reference, "scale 2^{k}");
    }
}

/// A lost vertex that no triangle uses must not decide the frame in which everything becomes f32.
#[test]
fn unused_vertices_do_not_matter() {
    let picture = |stray: &[[f32; 3]]| {
        let mut scene = Scene::default();
        let mut mesh: Mesh = cube(false);
        mesh.positions.extend(stray);
        add(&mut scene, mesh, lambert(0.5, 0.0), DAffine3::IDENTITY);
        let view = view(DVec3::new(2.0, 3.0, 4.0), DVec3::ZERO, 40.0, 16);
        let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
        let world = EnvironmentSource::Constant([1.0; 3]);
        shoot(&scene, &world, &PrepareSettings::default(), &settings, &view).picture
    };
    assert!(picture(&[[1e9, 1e9, -1e12]]) == picture(&[]));
}

/// Pixels and intensities near the end of f32 do not make numbers that are not finite.
#[test]
fn a_blinding_environment_stays_finite() {
    let pixels = [3e38f32, 1.0, 1.0, 1.0].repeat(8 * 4);
    let image = Image { name: String::new(), width: 8, height: 4, pixels: Pixels::RgbaF32(pixels) };
    let environment = EnvironmentSource::Image { image, rotation_y: 0.0, intensity: 100.0 };
    let mut scene = Scene::default();
    add(&mut scene, sphere(2), lambert(0.5, 0.0), DAffine3::IDENTITY);
    let view = view(DVec3::Z * 3.0, DVec3::ZERO, 40.0, 8);
    let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
    let rendered = shoot(&scene, &environment, &PrepareSettings::default(), &settings, &view);
    assert_eq!(rendered.nonfinite, 0);
}
