//! Every way of sampling converges to the same picture.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::{add, cube, lambert, shoot, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Extent, Falloff, Filter, Image, Light, LightKind, Material,
    MetalRough, Phong, Pixels, ScalarInput, Surface, Texture, TextureRef, Volume, Wrap,
};
use kiln::integrate::Rendered;
use kiln::math::statistics;
use kiln::prepare::EnvironmentSource;
use kiln::settings::{PrepareSettings, RenderSettings, SamplerKind, Strategy};

fn at(x: f64, y: f64, z: f64, scale: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z)) * DAffine3::from_scale(DVec3::splat(scale))
}

fn metal_rough(m: MetalRough) -> Material {
    Material { surface: Surface::MetalRough(m), ..Material::default() }
}

/// A little of everything: rough metal, plastic, rough and smooth glass with absorption, a `.ray` body, a leaf with
/// holes, a see-through sheet, a textured lamp, a spot and a soft point light.
fn everything() -> Scene {
    let mut scene = Scene::default();
    let checks = [255u8, 255, 255, 255, 60, 20, 10, 0, 60, 20, 10, 0, 255, 200, 90, 255];
    scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels: Pixels::Rgba8(checks.to_vec()) });
    for filter in [Filter::Nearest, Filter::Linear] {
        let wrap = Wrap::Repeat;
        scene.textures.push(Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter, color_space: ColorSpace::Srgb });
    }
    let uvs = [vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], Vec::new()];
    add(&mut scene, cube(true), lambert(0.6, 0.0), at(0.0, 0.0, 0.0, 1.0));
    let gold = MetalRough {
        base_color: ColorInput::constant([0.9, 0.7, 0.3]),
        metallic: ScalarInput::constant(1.0),
        roughness: ScalarInput::constant(0.5),
        ..MetalRough::default()
    };
    add(&mut scene, sphere(3), metal_rough(gold), at(-0.5, -0.6, -0.4, 0.35));
    let plastic = MetalRough {
        base_color: ColorInput::constant([0.2, 0.4, 0.8]),
        roughness: ScalarInput::constant(0.4),
        ..MetalRough::default()
    };
    add(&mut scene, cube(false), metal_rough(plastic), at(0.5, -0.8, -0.5, 0.2));
    let glass = |roughness| MetalRough {
        roughness: ScalarInput::constant(roughness),
        transmission: ScalarInput::constant(1.0),
        volume: Some(Volume { attenuation_color: [0.5, 0.9, 0.6], attenuation_distance: 0.4 }),
        ..MetalRough::default()
    };
    add(&mut scene, sphere(3), metal_rough(glass(0.6)), at(0.45, -0.3, -0.5, 0.25));
    let phong = Phong {
        diffuse: ColorInput::constant([0.5, 0.2, 0.2]),
        specular: ColorInput::constant([0.8; 3]),
        exponent: ScalarInput::constant(8.0),
        mirror: ColorInput::constant([0.2; 3]),
        ..Phong::default()
    };
    add(
        &mut scene,
        cube(false),
        Material { surface: Surface::Phong(phong), ..Material::default() },
        at(0.0, -0.85, 0.1, 0.15),
    );
    let textured = |mode, filter| Material {
        alpha: Alpha {
            mode,
            value: ScalarInput { factor: 0.9, texture: Some(TextureRef::new(filter)), channel: Channel::A },
        },
        ..lambert(0.7, 0.0)
    };
    let leaf = kiln::formats::scene::Mesh { uvs: uvs.clone(), ..square() };
    add(&mut scene, leaf.clone(), textured(AlphaMode::Mask { cutoff: 0.5 }, 0), at(-0.4, 0.1, -0.7, 0.3));
    add(&mut scene, leaf.clone(), textured(AlphaMode::Blend, 1), at(0.3, 0.3, -0.8, 0.3));
    let lamp = Material {
        emission: ColorInput { factor: [6.0, 5.0, 4.0], texture: Some(TextureRef::new(1)) },
        emission_two_sided: true,
        ..lambert(0.1, 0.0)
    };
    let tilted = at(-0.1, 0.75, -0.2, 0.35) * DAffine3::from_rotation_x(1.3);
    add(&mut scene, leaf, lamp, tilted);
    let light = |kind, color, position| Light {
        name: String::new(),
        kind,
        color: [color; 3],
        position,
        direction: DVec3::new(-0.6, -0.8, 0.0),
        through_glass: true,
    };
    let falloff = Falloff::InverseSquare { range: None };
    scene.lights.push(light(LightKind::Spot { falloff, inner: 0.3, outer: 0.8 }, 0.8, DVec3::new(0.8, 0.8, 0.3)));
    let soft = LightKind::Point {
        falloff: Falloff::Clamped { constant: 0.3, linear: 0.0, quadratic: 1.0 },
        extent: Extent::Disc { radius: 0.1 },
    };
    scene.lights.push(light(soft, 0.4, DVec3::new(-0.8, 0.5, 0.4)));
    scene
}

/// Means of 8×8 blocks and their variances, all channels.
fn blocks(rendered: &Rendered) -> Vec<(f64, f64)> {
    let (w, h) = (rendered.film.width as usize, rendered.film.height as usize);
    let mut all = Vec::new();
    for by in 0..h / 8 {
        for bx in 0..w / 8 {
            for channel in 0..3 {
                let (mut mean, mut variance) = (0.0, 0.0);
                for k in 0..64 {
                    let pixel = &rendered.film.pixels[(by * 8 + k / 8) * w + bx * 8 + k % 8];
                    let values: Vec<f64> = pixel.replicate_means(rendered.spp).map(|m| m[channel]).collect();
                    let n = values.len() as f64;
                    let own = values.iter().sum::<f64>() / n;
                    mean += own / 64.0;
                    variance += values.iter().map(|x| (x - own).powi(2)).sum::<f64>() / (n - 1.0) / n / 64.0 / 64.0;
                }
                all.push((mean, variance));
            }
        }
    }
    all
}

/// Compares block means by z, with a Šidák-corrected level over all blocks of one pair.
fn assert_agree(a: &Rendered, b: &Rendered, what: &str) {
    let (a, b) = (blocks(a), blocks(b));
    let limit = statistics::normal_quantile(1.0 - statistics::sidak(1e-3, a.len()) / 2.0);
    let (mut sum_a, mut sum_b, mut variance) = (0.0, 0.0, 0.0);
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        let z = (a.0 - b.0) / (a.1 + b.1).sqrt().max(1e-9);
        assert!(z.abs() < limit, "{what}: block {k}: {} and {}, z = {z}, limit {limit}", a.0, b.0);
        (sum_a, sum_b, variance) = (sum_a + a.0, sum_b + b.0, variance + a.1 + b.1);
    }
    let z = (sum_a - sum_b) / variance.sqrt();
    assert!(z.abs() < 4.0, "{what}: whole pictures: {sum_a} and {sum_b}, z = {z}");
}

/// Renders the scene with everything.
fn shoot_everything(
    spp: u32,
    max_depth: u32,
    strategy: Strategy,
    sampler: SamplerKind,
    light_samples: u32,
) -> Rendered {
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.2, -0.6), 70.0, 32);
    let settings = RenderSettings { spp, max_depth, strategy, sampler, light_samples, ..RenderSettings::default() };
    let world = EnvironmentSource::Constant([0.2; 3]);
    let rendered = shoot(&everything(), &world, &PrepareSettings::default(), &settings, &view);
    assert_eq!(rendered.nonfinite, 0);
    rendered
}

#[test]
fn strategies_that_sample_lights_or_lobes_agree_on_a_scene_with_everything() {
    let reference = shoot_everything(1024, 8, Strategy::Mis, SamplerKind::Sobol, 1);
    for (strategy, sampler, light_samples, spp) in [
        (Strategy::Mis, SamplerKind::Pcg, 3, 512),
        (Strategy::Light, SamplerKind::Lcg, 1, 1024),
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
