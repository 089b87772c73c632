use crate::settings::{Effect, EffectSet};
use kiln_formats::Scene;
use kiln_formats::scene::{
    AlphaMode, ColorInput, Extent, LightKind, Material, MetalRough, Phong, ScalarInput, Surface,
};

/// Takes effects away from a scene: another picture, wherever the scene calls for them.
pub fn leave_out(scene: &mut Scene, effects: EffectSet) {
    for effect in effects.iter() {
        scene.materials.iter_mut().for_each(|material| from_material(material, effect));
        match effect {
            Effect::VertexColors => scene.meshes.iter_mut().for_each(|mesh| mesh.colors = Vec::new()),
            Effect::SmoothNormals => scene.meshes.iter_mut().for_each(|mesh| mesh.normals = Vec::new()),
            Effect::PointLights => scene.lights.retain(|light| light.kind == LightKind::Directional),
            Effect::DirectionalLights => scene.lights.retain(|light| light.kind != LightKind::Directional),
            Effect::TintedShadows => scene.lights.iter_mut().for_each(|light| light.through_glass = false),
            Effect::SoftShadows => scene.lights.iter_mut().for_each(|light| {
                if let LightKind::Point { extent, .. } = &mut light.kind {
                    *extent = Extent::Point;
                }
            }),
            _ => {}
        }
    }
}

fn from_material(material: &mut Material, effect: Effect) {
    let mode = &mut material.alpha.mode;
    match effect {
        Effect::Textures => without_textures(material),
        Effect::NormalMaps => {
            material.normal_map = None;
            if let Some(layers) = layers(material) {
                layers.clearcoat_normal_map = None;
            }
        }
        Effect::AlphaCutouts if matches!(mode, AlphaMode::Mask { .. }) => *mode = AlphaMode::Opaque,
        Effect::AlphaBlending if *mode == AlphaMode::Blend => *mode = AlphaMode::Opaque,
        Effect::Culling => material.double_sided = true,
        Effect::Emission => material.emission = ColorInput::BLACK,
        _ => match &mut material.surface {
            Surface::MetalRough(m) => from_metal_rough(m, effect),
            Surface::Phong(p) => from_phong(p, effect),
            Surface::Unlit(_) => {}
        },
    }
}

fn layers(material: &mut Material) -> Option<&mut kiln_formats::scene::Layers> {
    match &mut material.surface {
        Surface::MetalRough(m) => m.layers.as_mut(),
        Surface::Phong(_) | Surface::Unlit(_) => None,
    }
}

const NONE: ScalarInput = ScalarInput::constant(0.0);

fn from_metal_rough(m: &mut MetalRough, effect: Effect) {
    match effect {
        Effect::Specular => m.specular = NONE,
        Effect::Metal => m.metallic = NONE,
        Effect::Transmission => m.transmission = NONE,
        Effect::Refraction => m.volume = None,
        Effect::Dispersion => m.dispersion = 0.0,
        Effect::Absorption => {
            if let Some(volume) = &mut m.volume {
                volume.attenuation_distance = f32::INFINITY;
            }
        }
        _ => {
            let Some(layers) = &mut m.layers else { return };
            match effect {
                Effect::Clearcoat => layers.clearcoat = NONE,
                Effect::Sheen => layers.sheen_color = ColorInput::BLACK,
                Effect::Iridescence => layers.iridescence = NONE,
                Effect::Anisotropy => layers.anisotropy = 0.0,
                Effect::DiffuseTransmission => layers.diffuse_transmission = NONE,
                Effect::DiffuseRoughness => layers.diffuse_roughness = NONE,
                _ => {}
            }
        }
    }
}

fn from_phong(p: &mut Phong, effect: Effect) {
    match effect {
        Effect::Specular => p.specular = ColorInput::BLACK,
        Effect::Mirror => p.mirror = ColorInput::BLACK,
        Effect::Transmission => p.transmission = ColorInput::BLACK,
        Effect::Refraction => p.ior = ScalarInput::constant(1.0),
        // k_t of 1 lets everything through; what is black stays a body that nothing passes.
        Effect::Absorption if !p.transmission.is_black() => p.transmission = ColorInput::WHITE,
        _ => {}
    }
}

/// Factors stay what they are.
fn without_textures(material: &mut Material) {
    material.normal_map = None;
    let color = |c: &mut ColorInput| c.texture = None;
    let scalar = |s: &mut ScalarInput| s.texture = None;
    color(&mut material.emission);
    scalar(&mut material.alpha.value);
    match &mut material.surface {
        Surface::MetalRough(m) => {
            [&mut m.base_color, &mut m.specular_color].into_iter().for_each(color);
            [&mut m.metallic, &mut m.roughness, &mut m.specular, &mut m.transmission].into_iter().for_each(scalar);
            if let Some(layers) = &mut m.layers {
                layers.clearcoat_normal_map = None;
                layers.texture_slots().into_iter().for_each(|slot| *slot = None);
            }
        }
        Surface::Phong(p) => {
            [&mut p.ambient, &mut p.diffuse, &mut p.specular, &mut p.mirror, &mut p.transmission]
                .into_iter()
                .for_each(color);
            [&mut p.exponent, &mut p.ior].into_iter().for_each(scalar);
        }
        Surface::Unlit(shown) => color(shown),
    }
}
