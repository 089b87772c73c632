//! A scene with a little of everything.

use super::{add, cube, lambert, sphere, square};
use glam::{DAffine3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Extent, Falloff, Filter, Image, Light, LightKind, Material,
    MetalRough, Phong, Pixels, ScalarInput, Surface, Texture, TextureRef, Volume, Wrap,
};

/// Moved to (x, y, z) and scaled.
pub fn at(x: f64, y: f64, z: f64, scale: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z)) * DAffine3::from_scale(DVec3::splat(scale))
}

fn metal_rough(m: MetalRough) -> Material {
    Material { surface: Surface::MetalRough(m), ..Material::default() }
}

/// A little of everything: rough metal, plastic, rough and smooth glass with absorption, a `.ray` body, a leaf with
/// holes, a see-through sheet, a textured lamp, a spot and a soft point light.
pub fn everything() -> Scene {
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
            value: ScalarInput { factor: 0.9, texture: Some(TextureRef::new(filter)), channel: Channel::A, bias: 0.0 },
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
