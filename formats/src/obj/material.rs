//! What MTL statements mean as a metallic-roughness material.

use super::log::Log;
use super::map::Map;
use super::mtl::Mtl;
use super::textures::Textures;
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Layers, Material, MetalRough, NormalMap, ScalarInput, Surface,
    Volume,
};
use std::f32::consts::TAU;

/// Albedo where the file says nothing.
const GREY: [f32; 3] = [0.8; 3];

fn largest(color: [f32; 3]) -> f32 {
    color.into_iter().fold(0.0, f32::max)
}

fn times(color: [f32; 3], factor: f32) -> [f32; 3] {
    color.map(|x| x * factor)
}

/// The material of faces without a usable one.
pub(super) fn default(name: &str, base: [f32; 3]) -> Material {
    let surface = MetalRough {
        base_color: ColorInput::constant(base),
        specular: ScalarInput::constant(0.0),
        ..MetalRough::default()
    };
    Material { name: name.into(), surface: Surface::MetalRough(surface), ..Material::default() }
}

pub(super) fn default_grey(name: &str) -> Material {
    default(name, GREY)
}

/// Perceptual roughness for a Blinn–Phong exponent: α = √(2 / (n + 2)) (Walter et al. 2007), roughness = √α.
/// Exponents from 1000, the end of MTL's range, are perfectly smooth.
fn roughness_of(exponent: Option<f32>) -> f32 {
    match exponent {
        None => 1.0,
        Some(n) if n >= 1000.0 => 0.0,
        Some(n) => (2.0 / (n + 2.0)).sqrt().sqrt(),
    }
}

/// Makes the material.
pub(super) fn lower(mtl: &Mtl, textures: &mut Textures, log: &mut Log) -> Material {
    let diffuse_texture = mtl.diffuse_map.as_ref().and_then(|map| textures.texture(map, ColorSpace::Srgb));
    // A black factor in front of a texture is what exporters write that forget to say white.
    let no_color = mtl.diffuse.is_none_or(|kd| kd == [0.0; 3]);
    let diffuse = match (mtl.diffuse, diffuse_texture) {
        (_, Some(_)) if no_color => [1.0; 3],
        (Some(kd), _) => kd,
        (None, _) => GREY,
    };
    let base_color = ColorInput { factor: diffuse.map(|x| x.min(1.0)), texture: diffuse_texture };
    if largest(diffuse) > 1.0 {
        log.warn("out-of-range", &mtl.place, || format!("Kd of '{}' exceeds 1; taken as 1", mtl.name));
    }
    let opacity = opacity(mtl, log);
    let mut surface = MetalRough { base_color, ior: ior(mtl), ..MetalRough::default() };
    if mtl.roughness.or(mtl.metallic).is_some() || mtl.roughness_map.is_some() || mtl.metallic_map.is_some() {
        surface.roughness = scalar(textures, mtl.roughness_map.as_ref(), mtl.roughness, roughness_of(mtl.exponent));
        surface.metallic = scalar(textures, mtl.metallic_map.as_ref(), mtl.metallic, 0.0);
    } else {
        classic(mtl, textures, &mut surface);
    }
    surface.layers = layers(mtl, textures, surface.roughness);
    let glass = is_glass(mtl, opacity);
    if glass {
        transmit(mtl, opacity, &mut surface);
    }
    let alpha = if glass {
        Alpha { mode: AlphaMode::Opaque, value: ScalarInput::constant(1.0) }
    } else {
        alpha(mtl, opacity, textures)
    };
    let emission_texture = mtl.emission_map.as_ref().and_then(|map| textures.texture(map, ColorSpace::Srgb));
    let emission = match (mtl.emission, emission_texture) {
        (Some(factor), texture) => ColorInput { factor, texture },
        (None, Some(texture)) => ColorInput { factor: [1.0; 3], texture: Some(texture) },
        (None, None) => ColorInput::BLACK,
    };
    Material {
        name: mtl.name.clone(),
        surface: Surface::MetalRough(surface),
        emission,
        // Lights of OBJ scenes shine from the front alone.
        emission_two_sided: false,
        alpha,
        normal_map: normal_map(mtl, textures),
        double_sided: true,
    }
}

/// A factor with a texture; a texture without a factor counts in full.
fn scalar(textures: &mut Textures, map: Option<&Map>, factor: Option<f32>, default: f32) -> ScalarInput {
    let texture = map.and_then(|map| textures.texture(map, ColorSpace::Linear));
    let factor = factor.unwrap_or(if texture.is_some() { 1.0 } else { default }).min(1.0);
    let channel = map.and_then(|m| m.channel).unwrap_or(Channel::R);
    // `-mm base gain`: the texel counts as base + gain · texel.
    let [base, gain] = map.filter(|_| texture.is_some()).map_or([0.0, 1.0], |m| m.range.map(|x| x.max(0.0)));
    ScalarInput { factor: factor * gain, texture, channel, bias: factor * base }
}

/// The layers of the PBR fields, if one is in effect. Sheen has no roughness of its own there and takes the surface's.
fn layers(mtl: &Mtl, textures: &mut Textures, roughness: ScalarInput) -> Option<Layers> {
    let sheen = scalar(textures, mtl.sheen_map.as_ref(), mtl.sheen, 0.0);
    let layers = Layers {
        clearcoat: scalar(textures, mtl.clearcoat_map.as_ref(), mtl.clearcoat, 0.0),
        clearcoat_roughness: scalar(textures, mtl.clearcoat_roughness_map.as_ref(), mtl.clearcoat_roughness, 0.0),
        sheen_color: ColorInput { factor: [sheen.factor; 3], texture: sheen.texture },
        sheen_roughness: roughness,
        anisotropy: mtl.anisotropy.unwrap_or(0.0).min(1.0),
        anisotropy_rotation: mtl.anisotropy_rotation.filter(|r| r.is_finite()).unwrap_or(0.0) * TAU,
        ..Layers::default()
    };
    let in_effect = layers.clearcoat.factor > 0.0 || !layers.sheen_color.is_black() || layers.anisotropy > 0.0;
    in_effect.then_some(layers)
}

/// Specular reflection from Ks, Ns and illum.
fn classic(mtl: &Mtl, textures: &mut Textures, surface: &mut MetalRough) {
    let illumination = mtl.illumination.unwrap_or(2);
    let specular_texture = mtl.specular_map.as_ref().and_then(|map| textures.texture(map, ColorSpace::Srgb));
    let ks = mtl.specular.unwrap_or([if specular_texture.is_some() { 1.0 } else { 0.0 }; 3]);
    let strength = largest(ks);
    surface.roughness = ScalarInput::constant(roughness_of(mtl.exponent));
    if illumination < 2 || strength == 0.0 {
        // Exactly Lambert.
        surface.specular = ScalarInput::constant(0.0);
        return;
    }
    let tint = ColorInput { factor: ks.map(|x| x / strength), texture: specular_texture };
    surface.specular = ScalarInput::constant(strength.min(1.0));
    surface.specular_color = tint;
    // Reflective models (3 and up) of bodies with hardly any diffuse colour are mirrors.
    let mirror = matches!(illumination, 3 | 5 | 8) && strength > 0.5;
    if mirror && largest(surface.base_color.factor) < 0.1 * strength {
        surface.metallic = ScalarInput::constant(1.0);
        surface.base_color = ColorInput { factor: ks.map(|x| x.min(1.0)), texture: specular_texture };
        surface.specular = ScalarInput::constant(1.0);
        surface.specular_color = ColorInput::WHITE;
    }
}

/// Ni for those that mean it: 1 and below are what exporters write for "none".
fn ior(mtl: &Mtl) -> f32 {
    mtl.ior.filter(|ni| *ni > 1.001 && *ni < 100.0).unwrap_or(1.5)
}

/// d, or else 1 − Tr.
fn opacity(mtl: &Mtl, log: &mut Log) -> f32 {
    match (mtl.dissolve, mtl.transparency) {
        (Some(d), _) => d.min(1.0),
        // Old exporters take Tr for d; a material that nobody can see is none.
        (None, Some(tr)) if tr >= 1.0 && !refracts(mtl) => {
            log.warn("ambiguous-transparency", &mtl.place, || {
                format!("Tr 1 without d makes '{}' invisible; taken as opaque", mtl.name)
            });
            1.0
        }
        (None, Some(tr)) => (1.0 - tr).max(0.0),
        (None, None) => 1.0,
    }
}

/// The illumination models with "refraction".
fn refracts(mtl: &Mtl) -> bool {
    matches!(mtl.illumination, Some(6 | 7))
}

fn is_glass(mtl: &Mtl, opacity: f32) -> bool {
    let filter = mtl.filter.is_some_and(|tf| largest(tf) > 0.0);
    let bends = mtl.ior.is_some_and(|ni| ni > 1.001);
    match mtl.illumination {
        // Without d, the filter Tf decides.
        Some(6 | 7) => opacity < 1.0 || filter,
        // Maya writes illum 4, Tf 1 1 1 and Ni 1 for opaque bodies.
        Some(4 | 9) => opacity < 1.0 || (filter && bends),
        _ => opacity < 1.0 && filter && bends && mtl.filter != Some([1.0; 3]),
    }
}

/// The body lets through Tf (Kd without one) of the light that is not dissolved into the diffuse colour.
fn transmit(mtl: &Mtl, opacity: f32, surface: &mut MetalRough) {
    let kd = surface.base_color.factor;
    let fallback = if largest(kd) > 0.0 { kd } else { [1.0; 3] };
    let tint = mtl.filter.filter(|tf| largest(*tf) > 0.0).unwrap_or(fallback).map(|x| x.min(1.0));
    let (through, rest) = if opacity < 1.0 { (1.0 - opacity, opacity) } else { (1.0, 1.0) };
    let (transmitted, diffuse) = (times(tint, through), times(kd, rest));
    // One base colour serves both: base · t ≈ transmitted, base · (1 − t) ≈ diffuse.
    let both = largest(transmitted) + largest(diffuse);
    let share = if both > 0.0 { largest(transmitted) / both } else { 1.0 };
    let mut base = [0.0; 3];
    for (base, (t, d)) in base.iter_mut().zip(transmitted.iter().zip(diffuse)) {
        *base = (t + d).min(1.0);
    }
    surface.base_color.factor = base;
    surface.transmission = ScalarInput::constant(share);
    surface.ior = mtl.ior.filter(|ni| (1.0..100.0).contains(ni)).unwrap_or(1.5);
    surface.volume = Some(Volume { attenuation_color: [1.0; 3], attenuation_distance: f32::INFINITY });
    if surface.specular.factor == 0.0 && mtl.specular.is_none() {
        // Glass reflects as its index says, unless Ks is given.
        surface.specular = ScalarInput::constant(1.0);
    }
    if mtl.exponent.is_none() && mtl.roughness.is_none() {
        surface.roughness = ScalarInput::constant(0.0);
    }
}

fn alpha(mtl: &Mtl, opacity: f32, textures: &mut Textures) -> Alpha {
    let has_alpha = |textures: &Textures, map: &Map| textures.look(map).is_some_and(|look| look.has_alpha);
    if let Some(map) = &mtl.dissolve_map
        && textures.look(map).is_some()
    {
        let own = if has_alpha(textures, map) { Channel::A } else { Channel::R };
        let mut value = scalar(textures, Some(map), Some(opacity), 1.0);
        value.channel = map.channel.unwrap_or(own);
        return Alpha { mode: AlphaMode::Blend, value };
    }
    if let Some(map) = mtl.diffuse_map.as_ref().filter(|map| has_alpha(textures, map)) {
        let texture = textures.texture(map, ColorSpace::Srgb);
        return Alpha {
            mode: AlphaMode::Blend,
            value: ScalarInput { factor: opacity, texture, channel: Channel::A, bias: 0.0 },
        };
    }
    let mode = if opacity < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    Alpha { mode, value: ScalarInput::constant(opacity) }
}

fn normal_map(mtl: &Mtl, textures: &mut Textures) -> Option<NormalMap> {
    if let Some(map) = &mtl.normal_map
        && let Some(texture) = textures.texture(map, ColorSpace::Linear)
    {
        return Some(NormalMap { texture, scale: map.strength });
    }
    let map = mtl.bump_map.as_ref()?;
    if textures.look(map)?.is_normal_map {
        let texture = textures.texture(map, ColorSpace::Linear)?;
        return Some(NormalMap { texture, scale: map.strength });
    }
    Some(NormalMap { texture: textures.normals_of_heights(map)?, scale: map.strength })
}
