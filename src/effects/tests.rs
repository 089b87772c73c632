use super::*;
use crate::settings::{Effect, EffectSet};
use glam::{DAffine3, DVec3};
use kiln_formats::Scene;
use kiln_formats::scene::*;

/// A texture of 2 × 2 texels.
fn texture(scene: &mut Scene, texels: [[u8; 4]; 4], color_space: ColorSpace) -> TextureRef {
    let image = scene.images.len() as u32;
    let pixels = Pixels::Rgba8(texels.concat());
    scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels });
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Clamp, filter: Filter::Linear, color_space };
    scene.textures.push(texture);
    TextureRef::new(scene.textures.len() as u32 - 1)
}

/// One triangle with every attribute.
fn scene_with(material: impl FnOnce(&mut Scene) -> Material) -> Scene {
    let mut scene = Scene::default();
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        tangents: vec![[1.0, 0.0, 0.0, 1.0]; 3],
        uvs: [vec![[0.0; 2]; 3], vec![[0.0; 2]; 3]],
        colors: vec![[1.0; 4]; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    scene.meshes.push(mesh);
    scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
    let material = material(&mut scene);
    scene.materials.push(material);
    scene.validate().expect("a valid scene");
    scene
}

fn metal_rough(scene: &Scene) -> &MetalRough {
    match &scene.materials[0].surface {
        Surface::MetalRough(m) => m,
        other => panic!("{other:?}"),
    }
}

fn effects_of(scene: &Scene) -> Vec<Effect> {
    called_for(scene, &[1.0]).iter().map(|called| called.effect).collect()
}

#[test]
fn a_texture_of_one_colour_is_a_factor() {
    let mut scene = scene_with(|scene| {
        let red = texture(scene, [[255, 0, 0, 7], [255, 0, 0, 9], [255, 0, 0, 7], [255, 0, 0, 7]], ColorSpace::Srgb);
        let m = MetalRough {
            base_color: ColorInput { factor: [0.5, 0.5, 0.25], texture: Some(red) },
            roughness: ScalarInput { factor: 0.5, texture: Some(red), channel: Channel::R, bias: 0.25 },
            ..MetalRough::default()
        };
        Material { surface: Surface::MetalRough(m), ..Material::default() }
    });
    let done = normalise(&mut scene);
    let m = metal_rough(&scene);
    assert_eq!(m.base_color, ColorInput::constant([0.5, 0.0, 0.0]));
    assert_eq!((m.roughness.factor, m.roughness.bias, m.roughness.texture), (0.5, 0.25, None));
    // What nobody reads is not kept.
    let mesh = &scene.meshes[0];
    assert!(mesh.uvs[0].is_empty() && mesh.uvs[1].is_empty() && mesh.tangents.is_empty() && mesh.colors.is_empty());
    assert!(!mesh.normals.is_empty());
    assert_eq!(scene.images[0].width, 1);
    assert!(done.iter().any(|r| r.what.contains("one colour")), "{done:?}");
    scene.validate().expect("still valid");
    assert_eq!(effects_of(&scene), [Effect::SmoothNormals, Effect::Specular]);
}

#[test]
fn textures_with_something_in_them_stay() {
    let material = |scene: &mut Scene| {
        let mixed =
            texture(scene, [[255, 0, 0, 255], [255, 1, 0, 255], [255, 0, 0, 254], [9, 0, 0, 255]], ColorSpace::Linear);
        let map = texture(
            scene,
            [[128, 128, 255, 0], [128, 127, 254, 0], [128, 128, 255, 0], [129, 128, 255, 0]],
            ColorSpace::Linear,
        );
        let m =
            MetalRough { base_color: ColorInput { factor: [1.0; 3], texture: Some(mixed) }, ..MetalRough::default() };
        Material {
            surface: Surface::MetalRough(m),
            emission: ColorInput { factor: [1.0; 3], texture: Some(mixed) },
            alpha: Alpha {
                mode: AlphaMode::Blend,
                value: ScalarInput { factor: 1.0, texture: Some(mixed), channel: Channel::A, bias: 0.0 },
            },
            normal_map: Some(NormalMap { texture: map, scale: 1.0 }),
            double_sided: false,
            ..Material::default()
        }
    };
    let mut scene = scene_with(material);
    let before = scene.materials.clone();
    normalise(&mut scene);
    assert_eq!(scene.materials, before);
    assert!(!scene.meshes[0].tangents.is_empty() && !scene.meshes[0].uvs[0].is_empty());
    assert!(scene.meshes[0].uvs[1].is_empty(), "no texture reads the second set");
    use Effect::*;
    let expected = [Textures, NormalMaps, SmoothNormals, AlphaBlending, Culling, Specular, Emission];
    assert_eq!(effects_of(&scene), expected);
}

#[test]
fn flat_maps_black_emission_opaque_alpha_and_idle_layers_go() {
    let mut scene = scene_with(|scene| {
        let flat = texture(
            scene,
            [[128, 127, 255, 3], [127, 128, 254, 0], [128, 128, 255, 0], [127, 127, 255, 0]],
            ColorSpace::Linear,
        );
        let black = texture(scene, [[0, 0, 0, 1], [0, 0, 0, 2], [0, 0, 0, 3], [0, 0, 0, 4]], ColorSpace::Srgb);
        let whole = texture(scene, [[1, 2, 3, 200], [4, 5, 6, 128], [7, 8, 9, 255], [1, 1, 1, 130]], ColorSpace::Srgb);
        let layers = Layers {
            clearcoat: ScalarInput { factor: 1.0, texture: Some(black), channel: Channel::R, bias: 0.0 },
            clearcoat_roughness: ScalarInput::constant(0.3),
            clearcoat_normal_map: Some(NormalMap { texture: flat, scale: 1.0 }),
            ..Layers::default()
        };
        Material {
            surface: Surface::MetalRough(MetalRough { layers: Some(layers), ..MetalRough::default() }),
            emission: ColorInput { factor: [3.0; 3], texture: Some(black) },
            alpha: Alpha {
                mode: AlphaMode::Mask { cutoff: 0.5 },
                value: ScalarInput { factor: 1.0, texture: Some(whole), channel: Channel::A, bias: 0.0 },
            },
            normal_map: Some(NormalMap { texture: flat, scale: 1.0 }),
            ..Material::default()
        }
    });
    assert!(effects_of(&scene).contains(&Effect::Clearcoat));
    normalise(&mut scene);
    let material = &scene.materials[0];
    assert_eq!(metal_rough(&scene).layers, None);
    assert_eq!((material.alpha.mode, material.normal_map), (AlphaMode::Opaque, None));
    assert!(material.emission.is_black() && material.textures().is_empty());
    assert_eq!(effects_of(&scene), [Effect::SmoothNormals, Effect::Specular]);
}

#[test]
fn alpha_of_vertices_counts() {
    let mut scene = scene_with(|scene| {
        scene.meshes[0].colors[1][3] = 0.4;
        let alpha = Alpha { mode: AlphaMode::Mask { cutoff: 0.5 }, value: ScalarInput::constant(1.0) };
        Material { alpha, ..Material::default() }
    });
    normalise(&mut scene);
    assert!(effects_of(&scene).contains(&Effect::AlphaCutouts));
    scene.meshes[0].colors[1][3] = 0.5;
    normalise(&mut scene);
    assert!(!effects_of(&scene).contains(&Effect::AlphaCutouts));
}

/// Every effect has a scene that calls for it, and leaving it out leaves no call.
#[test]
fn what_is_left_out_is_not_called_for() {
    let everything = |scene: &mut Scene| {
        scene.meshes[0].colors[0] = [0.5; 4];
        let mixed =
            texture(scene, [[255, 0, 0, 0], [9, 1, 0, 255], [255, 0, 0, 254], [9, 0, 9, 255]], ColorSpace::Linear);
        let one = ScalarInput::constant(1.0);
        let layers = Layers {
            clearcoat: one,
            sheen_color: ColorInput::WHITE,
            iridescence: one,
            anisotropy: 1.0,
            diffuse_transmission: one,
            diffuse_roughness: one,
            ..Layers::default()
        };
        let volume = Volume { attenuation_color: [0.5; 3], attenuation_distance: 1.0 };
        let m = MetalRough {
            base_color: ColorInput { factor: [1.0; 3], texture: Some(mixed) },
            metallic: ScalarInput::constant(0.5),
            transmission: one,
            volume: Some(volume),
            dispersion: 1.0,
            layers: Some(layers),
            ..MetalRough::default()
        };
        Material {
            surface: Surface::MetalRough(m),
            emission: ColorInput::WHITE,
            normal_map: Some(NormalMap { texture: mixed, scale: 1.0 }),
            alpha: Alpha { mode: AlphaMode::Blend, value: ScalarInput::constant(0.5) },
            double_sided: false,
            ..Material::default()
        }
    };
    let mut scene = scene_with(everything);
    let (masked, course, shown) = (scene.materials[0].clone(), Material::default(), Material::default());
    let mode = AlphaMode::Mask { cutoff: 0.5 };
    scene.materials.push(Material { alpha: Alpha { mode, ..masked.alpha }, ..masked });
    let phong = Phong { mirror: ColorInput::WHITE, transmission: ColorInput::constant([0.5; 3]), ..Phong::default() };
    scene.materials.push(Material { surface: Surface::Phong(phong), ..course });
    scene.materials.push(Material { surface: Surface::Unlit(ColorInput::WHITE), ..shown });
    for material in 1..4 {
        scene.meshes.push(Mesh { material, ..scene.meshes[0].clone() });
    }
    let falloff = Falloff::InverseSquare { range: None };
    for kind in [LightKind::Directional, LightKind::Point { falloff, extent: Extent::Disc { radius: 1.0 } }] {
        scene.lights.push(Light {
            name: String::new(),
            kind,
            color: [1.0; 3],
            position: DVec3::ZERO,
            direction: DVec3::X,
            through_glass: true,
        });
    }
    let calls = |scene: &Scene| -> EffectSet { called_for(scene, &[1.0; 4]).iter().map(|c| c.effect).collect() };
    for effect in Effect::ALL {
        let by_scene = effect != Effect::Environment;
        assert_eq!(calls(&scene).has(effect), by_scene, "{effect}");
        if by_scene && effect != Effect::Unlit {
            let mut without = scene.clone();
            leave_out(&mut without, [effect].into_iter().collect());
            without.validate().expect("still valid");
            assert!(!calls(&without).has(effect), "{effect} is still called for");
        }
    }
}

#[test]
fn reasons_name_materials_meshes_and_area() {
    let mut scene = scene_with(|_| Material {
        name: "Glass".into(),
        surface: Surface::MetalRough(MetalRough { transmission: ScalarInput::constant(1.0), ..MetalRough::default() }),
        ..Material::default()
    });
    scene.materials.push(Material::default());
    scene.meshes.push(Mesh { material: 1, ..scene.meshes[0].clone() });
    let called = called_for(&scene, &[1.0, 3.0]);
    let glass = called.iter().find(|c| c.effect == Effect::Transmission).expect("transmission");
    assert_eq!(glass.reason, "material 'Glass' on 1 mesh, 25.0 % of the area");
    assert_eq!(glass.area, Some(0.25));
}
