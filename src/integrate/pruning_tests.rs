//! What the analysis of effects lets a renderer leave out changes nothing, and the analysis of each effect matters: overlooked,
//! it changes the picture.

use super::{View, render};
use crate::prepare::{EnvironmentSource, Knowledge, prepare_knowing};
use crate::settings::{Effect, EffectSet, PrepareSettings, RenderSettings};
use glam::{DAffine3, DVec3};
use kiln_formats::scene::*;
use kiln_formats::{Control, Scene};

/// A square in the plane z = 0 with every attribute, facing up.
fn square() -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    Mesh {
        positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
        uvs: [corners.to_vec(), Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn matte(albedo: f32) -> MetalRough {
    MetalRough { base_color: ColorInput::constant([albedo; 3]), specular: NONE, ..MetalRough::default() }
}

const NONE: ScalarInput = ScalarInput::constant(0.0);
const ONE: ScalarInput = ScalarInput::constant(1.0);

fn surface(m: MetalRough) -> Material {
    Material { surface: Surface::MetalRough(m), double_sided: true, ..Material::default() }
}

/// A texture with something in every channel, alpha too.
fn texture(scene: &mut Scene) -> TextureRef {
    let texels = [[250, 90, 200, 255], [40, 200, 240, 10], [90, 20, 190, 90], [200, 160, 255, 200]];
    let pixels = Pixels::Rgba8(texels.concat());
    scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels });
    let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::Repeat);
    let color_space = ColorSpace::Linear;
    scene.textures.push(Texture { image: 0, wrap_u, wrap_v, filter: Filter::Linear, color_space });
    TextureRef::new(0)
}

/// A square whose only peculiarity is an effect, over another one, and lamps of two kinds.
fn calling_for(effect: Effect) -> Scene {
    let mut scene = Scene::default();
    let texture = texture(&mut scene);
    let mut mesh = square();
    let layered = |layers: Layers| surface(MetalRough { layers: Some(layers), ..matte(0.5) });
    let image = |channel| ScalarInput { factor: 1.0, texture: Some(texture), channel, bias: 0.0 };
    let glass = MetalRough { transmission: ONE, roughness: ScalarInput::constant(0.2), ..matte(0.8) };
    let material = match effect {
        Effect::Textures => {
            surface(MetalRough { base_color: ColorInput { factor: [1.0; 3], texture: Some(texture) }, ..matte(0.5) })
        }
        Effect::NormalMaps => {
            mesh.normals = vec![[0.0, 0.0, 1.0]; 4];
            mesh.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4];
            Material { normal_map: Some(NormalMap { texture, scale: 1.0 }), ..surface(matte(0.5)) }
        }
        Effect::VertexColors => {
            mesh.colors = vec![[0.2, 0.9, 0.4, 1.0]; 4];
            surface(matte(0.5))
        }
        Effect::SmoothNormals => {
            mesh.normals = vec![[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]];
            surface(matte(0.5))
        }
        Effect::AlphaCutouts | Effect::AlphaBlending => {
            let mode = if effect == Effect::AlphaBlending { AlphaMode::Blend } else { AlphaMode::Mask { cutoff: 0.5 } };
            Material { alpha: Alpha { mode, value: image(Channel::A) }, ..surface(matte(0.5)) }
        }
        Effect::Culling => {
            mesh.triangles.iter_mut().for_each(|triangle| triangle.reverse());
            Material { double_sided: false, ..surface(matte(0.5)) }
        }
        Effect::Specular => surface(MetalRough { specular: ONE, ..matte(0.5) }),
        Effect::Metal => surface(MetalRough { metallic: ScalarInput::constant(0.7), ..matte(0.5) }),
        Effect::Transmission => surface(glass),
        Effect::Refraction => surface(MetalRough { volume: Some(clear()), ..glass }),
        Effect::Absorption => {
            surface(MetalRough { volume: Some(Volume { attenuation_distance: 0.3, ..clear() }), ..glass })
        }
        Effect::Dispersion => surface(MetalRough { volume: Some(clear()), dispersion: 3.0, ..glass }),
        Effect::Clearcoat => layered(Layers { clearcoat: ONE, ..Layers::default() }),
        Effect::Sheen => layered(Layers { sheen_color: ColorInput::WHITE, ..Layers::default() }),
        Effect::Iridescence => layered(Layers { iridescence: ONE, ..Layers::default() }),
        Effect::Anisotropy => {
            mesh.normals = vec![[0.0, 0.0, 1.0]; 4];
            mesh.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 4];
            let layers = Some(Layers { anisotropy: 1.0, ..Layers::default() });
            surface(MetalRough { metallic: ONE, roughness: ScalarInput::constant(0.4), layers, ..matte(0.5) })
        }
        Effect::DiffuseTransmission => layered(Layers { diffuse_transmission: ONE, ..Layers::default() }),
        Effect::DiffuseRoughness => layered(Layers { diffuse_roughness: ONE, ..Layers::default() }),
        Effect::Unlit => Material { surface: Surface::Unlit(ColorInput::constant([0.3; 3])), ..surface(matte(0.5)) },
        Effect::Emission => {
            // One triangle is seen from behind, where it is dark.
            mesh.triangles[1].reverse();
            Material { emission: ColorInput::constant([3.0; 3]), ..surface(matte(0.5)) }
        }
        Effect::Mirror => phong(Phong { mirror: ColorInput::WHITE, ..Phong::default() }),
        Effect::TintedShadows => phong(Phong { transmission: ColorInput::constant([0.5; 3]), ..Phong::default() }),
        Effect::PointLights | Effect::DirectionalLights | Effect::SoftShadows | Effect::Environment => {
            surface(matte(0.5))
        }
    };
    let emits = !material.emission.is_black();
    scene.materials.extend([material, surface(matte(0.7)), surface(matte(0.3))]);
    scene.meshes.extend([mesh, Mesh { material: 1, ..square() }]);
    let placed = |mesh, z: f64, scale: f64| Instance {
        name: String::new(),
        mesh,
        transform: DAffine3::from_translation(DVec3::Z * z) * DAffine3::from_scale(DVec3::splat(scale)),
    };
    scene.instances.extend([placed(0, 0.0, 1.0), placed(1, -0.4, 4.0)]);
    if !emits {
        for kind in
            [LightKind::Directional, LightKind::Point { falloff: FALLOFF, extent: Extent::Disc { radius: 0.1 } }]
        {
            scene.lights.push(Light {
                name: String::new(),
                kind,
                color: [1.0; 3],
                position: DVec3::new(0.3, 0.2, 2.0),
                direction: DVec3::new(0.1, 0.2, -1.0).normalize(),
                through_glass: effect == Effect::TintedShadows,
            });
        }
    }
    scene.validate().expect("a valid scene");
    scene
}

const FALLOFF: Falloff = Falloff::InverseSquare { range: None };

fn clear() -> Volume {
    Volume { attenuation_color: [0.5, 0.9, 0.7], attenuation_distance: f32::INFINITY }
}

fn phong(own: Phong) -> Material {
    Material { surface: Surface::Phong(own), double_sided: true, ..Material::default() }
}

/// The bits of a small picture from above.
fn bits(scene: &Scene, know: Knowledge) -> Vec<[u64; 4]> {
    let control = Control::default();
    let world = EnvironmentSource::Constant([0.2, 0.3, 0.4]);
    let prepared =
        prepare_knowing(scene.clone(), &world, &PrepareSettings::default(), know, &control).expect("not stopped");
    let camera = Camera {
        name: String::new(),
        projection: Projection::Perspective,
        origin: DVec3::new(0.4, -1.5, 2.5),
        forward: DVec3::new(-0.4, 1.5, -2.5).normalize(),
        right: DVec3::X * 0.6,
        up: DVec3::new(0.0, 2.5, 1.5).normalize() * 0.6,
        aspect: None,
    };
    let view = View { camera, width: 12, height: 12, show_environment: true };
    let settings = RenderSettings { spp: 8, ..RenderSettings::default() };
    let film = render(&prepared, &view, &settings, &control).expect("not stopped").film;
    film.pixels.iter().map(|pixel| pixel.mean().map(f64::to_bits)).collect()
}

#[test]
fn the_full_renderer_gives_the_same_bits() {
    for effect in Effect::ALL {
        let scene = calling_for(effect);
        let full = Knowledge { forced: EffectSet::all(), ..Knowledge::default() };
        assert!(bits(&scene, Knowledge::default()) == bits(&scene, full), "{effect}: pruned and full differ");
    }
}

/// Effects by whose absence nothing is left out: what they need belongs to a model of scattering, a body or a list of lights,
/// which is there or not.
const NOTHING_PRUNED: [Effect; 9] = [
    Effect::Mirror,
    Effect::Refraction,
    Effect::Absorption,
    Effect::Dispersion,
    Effect::Unlit,
    Effect::PointLights,
    Effect::DirectionalLights,
    Effect::SoftShadows,
    Effect::Environment,
];

#[test]
fn an_effect_that_the_analysis_overlooks_is_missing() {
    let same = |effect: &Effect| {
        let scene = calling_for(*effect);
        let overlooking = Knowledge { overlooked: [*effect].into_iter().collect(), ..Knowledge::default() };
        bits(&scene, Knowledge::default()) == bits(&scene, overlooking)
    };
    let unseen: Vec<Effect> = Effect::ALL.into_iter().filter(same).collect();
    assert_eq!(unseen, NOTHING_PRUNED, "effects that can be overlooked unseen");
}
