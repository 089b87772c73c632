//! Every way of sampling converges to the same picture.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::everything::{at, everything};
use common::{add, lambert, shoot, square, view};
use glam::{DAffine3, DVec3};
use kiln::film::Estimate;
use kiln::formats::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Filter, Image, Layers, NormalMap, Pixels, ScalarInput, Surface,
    Texture, TextureRef, Wrap,
};
use kiln::integrate::Rendered;
use kiln::math::statistics;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{EffectSettings, PrepareSettings, RenderSettings, SamplerKind, Strategy};
use kiln::{Control, Scene};

/// Means of 8×8 blocks, all channels.
fn blocks(rendered: &Rendered) -> Vec<Estimate> {
    let (w, h) = (rendered.film.width as usize, rendered.film.height as usize);
    let corners = (0..h / 8).flat_map(|y| (0..w / 8).map(move |x| (x, y)));
    let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let pixels = |(x, y): (usize, usize)| (0..64).map(move |k| (y * 8 + k / 8) * w + x * 8 + k % 8);
    corners.flat_map(|corner| channels.map(|c| rendered.film.estimate(pixels(corner), c))).collect()
}

/// Compares block means by Welch's test, with a Šidák-corrected level over all blocks of one pair.
fn assert_agree(a: &Rendered, b: &Rendered, what: &str) {
    let (a, b) = (blocks(a), blocks(b));
    let level = statistics::sidak(1e-3, a.len());
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        let (t, degrees) = welch(a, b);
        let p = statistics::student_t_two_sided(t, degrees);
        assert!(p > level, "{what}: block {k}: {} and {}, t = {t} ({degrees} degrees)", a.mean, b.mean);
    }
    let whole = |all: &[Estimate]| Estimate::mean_of(all).expect("blocks");
    let (a, b) = (whole(&a), whole(&b));
    let (t, _) = welch(&a, &b);
    assert!(t.abs() < 4.0, "{what}: whole pictures: {} and {}, t = {t}", a.mean, b.mean);
}

/// Student's t of a difference, and its degrees of freedom.
fn welch(a: &Estimate, b: &Estimate) -> (f64, f64) {
    let share = |e: &Estimate| e.variance * e.variance / e.degrees;
    let variance = a.variance + b.variance;
    let degrees = variance * variance / (share(a) + share(b)).max(1e-300);
    ((a.mean - b.mean) / variance.sqrt().max(1e-9), degrees.clamp(1.0, 1e5))
}

/// Renders the scene with everything; with 0 light samples, as many as renders take unasked.
fn shoot_everything(
    spp: u32,
    max_depth: u32,
    strategy: Strategy,
    sampler: SamplerKind,
    light_samples: u32,
) -> Rendered {
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.2, -0.6), 70.0, 32);
    let light_samples = (light_samples > 0).then_some(light_samples);
    let settings = RenderSettings { spp, max_depth, strategy, sampler, light_samples, ..RenderSettings::default() };
    let world = EnvironmentSource::Constant([0.2; 3]);
    let rendered = shoot(&everything(), &world, &PrepareSettings::default(), &settings, &view);
    assert_eq!(rendered.nonfinite, 0);
    rendered
}

#[test]
fn strategies_that_sample_lights_or_lobes_agree_on_a_scene_with_everything() {
    let reference = shoot_everything(1024, 8, Strategy::Mis, SamplerKind::Sobol, 0);
    for (strategy, sampler, light_samples, spp) in [
        (Strategy::Mis, SamplerKind::Pcg, 3, 512),
        (Strategy::Light, SamplerKind::Lcg, 0, 1024),
        (Strategy::Bsdf, SamplerKind::Sobol, 1, 1024),
    ] {
        let other = shoot_everything(spp, 8, strategy, sampler, light_samples);
        assert_agree(&reference, &other, &format!("{strategy:?} {sampler:?} {light_samples}"));
    }
}

/// Two scatterings only: the weights of these strategies multiply along a path, and the few paths that carry most of
/// the light would be missed by a picture and by the estimate of its variance alike.
#[test]
fn strategies_that_ignore_the_material_agree_on_a_scene_with_everything() {
    let reference = shoot_everything(1024, 2, Strategy::Mis, SamplerKind::Sobol, 1);
    for (strategy, sampler, light_samples) in
        [(Strategy::Cosine, SamplerKind::Xorshift32, 1), (Strategy::Hemisphere, SamplerKind::Sobol, 2)]
    {
        let other = shoot_everything(2048, 2, strategy, sampler, light_samples);
        assert_agree(&reference, &other, &format!("{strategy:?} {sampler:?} {light_samples}"));
    }
}

/// The scene with everything, with much in it that has no effect: images of one colour, flat normal maps, alpha that is 1,
/// coats without strength.
fn dressed_up() -> Scene {
    let mut scene = everything();
    let mut texture = |texel: [u8; 4], color_space| {
        let (image, pixels) = (scene.images.len() as u32, Pixels::Rgba8([texel; 4].concat()));
        scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels });
        let (wrap, filter) = (Wrap::Repeat, Filter::Linear);
        scene.textures.push(Texture { image, wrap_u: wrap, wrap_v: wrap, filter, color_space });
        TextureRef::new(scene.textures.len() as u32 - 1)
    };
    let grey = texture([188, 180, 200, 255], ColorSpace::Srgb);
    let (half, black) = (texture([9, 128, 7, 5], ColorSpace::Linear), texture([0; 4], ColorSpace::Srgb));
    let flat = NormalMap { texture: texture([128, 127, 255, 255], ColorSpace::Linear), scale: 1.0 };
    for mesh in &mut scene.meshes {
        mesh.tangents = vec![[1.0, 0.0, 0.0, 1.0]; mesh.positions.len()];
        mesh.colors = vec![[1.0; 4]; mesh.positions.len()];
    }
    for material in &mut scene.materials {
        let Surface::MetalRough(m) = &mut material.surface else { continue };
        m.base_color.texture = Some(grey);
        m.roughness.texture = Some(half);
        m.roughness.channel = Channel::G;
        let clearcoat = ScalarInput { texture: Some(black), ..ScalarInput::constant(1.0) };
        m.layers = Some(Layers { clearcoat, ..Layers::default() });
        material.normal_map = Some(flat);
        if material.alpha.mode == AlphaMode::Opaque {
            let value = ScalarInput { texture: Some(grey), channel: Channel::A, ..ScalarInput::constant(1.0) };
            material.alpha = Alpha { mode: AlphaMode::Blend, value };
        }
        if material.emission.is_black() {
            material.emission = ColorInput { factor: [1.0; 3], texture: Some(black) };
        }
    }
    scene
}

/// Rounding changes, and with it single paths; not the light.
#[test]
fn leaving_away_what_has_no_effect_changes_no_picture() {
    let scene = dressed_up();
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.2, -0.6), 70.0, 32);
    let world = EnvironmentSource::Constant([0.2; 3]);
    let shoot = |raw, seed| {
        let effects = EffectSettings { raw, ..EffectSettings::default() };
        let settings = RenderSettings { spp: 512, seed, max_depth: 8, ..RenderSettings::default() };
        shoot(&scene, &world, &PrepareSettings { effects, ..PrepareSettings::default() }, &settings, &view)
    };
    assert_agree(&shoot(true, 1), &shoot(false, 2), "raw and rewritten");
    let prepared = prepare(scene.clone(), &world, &PrepareSettings::default(), &Control::default()).expect("prepared");
    let done = |what: &str| prepared.rewrites.iter().filter(|rewrite| rewrite.what.contains(what)).count();
    for what in ["one colour", "one value", "flat normal map", "without transparent", "layers without", "tangents"] {
        assert!(done(what) >= 4, "{what}: {:?}", prepared.rewrites);
    }
}

/// A floor under a wide triangle, close to it, and forty small lamps: near the triangle it is nearly all that light samples
/// choose, and half of the directions that scattering chooses find it, so that both ways need the right density of the
/// other one. The shares of the choice differ from place to place.
#[test]
fn strategies_agree_among_many_lamps() {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(0.8, 0.0), at(0.0, 0.0, 0.0, 2.0));
    let down = DAffine3::from_rotation_x(std::f64::consts::PI);
    let mut triangle = square();
    triangle.triangles.truncate(1);
    add(&mut scene, triangle, lambert(0.5, 1.0), at(-0.4, 0.0, 0.35, 0.6) * down);
    for i in 0..40 {
        let (x, y) = (f64::from(i % 8) * 0.45 - 1.6, f64::from(i / 8) * 0.7 - 1.4);
        let size = if i % 3 == 0 { 0.02 } else { 0.06 };
        let place = at(x, y, 0.5 + 0.02 * f64::from(i), size) * DAffine3::from_rotation_y(0.05 * f64::from(i)) * down;
        add(&mut scene, square(), lambert(0.1, 2.0 + f64::from(i % 5) as f32), place);
    }
    // From the side, below the panel.
    let view = view(DVec3::new(2.2, 0.1, 0.25), DVec3::new(-0.3, 0.0, 0.0), 40.0, 32);
    let shoot = |strategy, spp, light_samples| {
        let light_samples = Some(light_samples);
        let settings = RenderSettings { spp, max_depth: 2, strategy, light_samples, ..RenderSettings::default() };
        shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view)
    };
    let reference = shoot(Strategy::Mis, 1024, 1);
    assert_agree(&reference, &shoot(Strategy::Mis, 256, 4), "four light samples");
    assert_agree(&reference, &shoot(Strategy::Bsdf, 2048, 1), "bsdf");
    assert_agree(&reference, &shoot(Strategy::Light, 1024, 1), "light");
}
