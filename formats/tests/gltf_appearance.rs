//! Materials, textures, cameras and lights of imported glTF.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod gltf_common;

use gltf_common::{triangle, warned};
use kiln_formats::scene::{
    AlphaMode, Camera, Channel, ColorSpace, Falloff, Filter, LightKind, Material, MetalRough, Projection, Surface, Wrap,
};
use serde_json::json;

fn metal_rough(material: &Material) -> MetalRough {
    match material.surface {
        Surface::MetalRough(m) => m,
        other => panic!("{other:?}"),
    }
}

#[test]
fn specular_glossiness_becomes_a_dielectric_of_that_reflectance() {
    let mut b = triangle();
    b.doc["materials"] = json!([{"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 0, 1], "specularFactor": [0.08, 0.04, 0], "glossinessFactor": 0.75}}}]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(warnings, []);
    let m = metal_rough(&scene.materials[0]);
    assert_eq!((m.base_color.factor, m.metallic.factor), ([0.5, 0.25, 0.0], 0.0));
    assert_eq!(m.roughness.bias + m.roughness.factor, 0.25);
    // F0 = 0.04 · specular colour at the index of refraction 1.5.
    assert_eq!((m.ior, m.specular_color.factor), (1.5, [2.0, 1.0, 0.0]));
}

#[test]
fn materials_carry_their_extensions() {
    let mut b = triangle();
    b.doc["materials"] = json!([{
        "name": "glass", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 0.75], "metallicFactor": 0, "roughnessFactor": 0.125},
        "extensions": {
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_ior": {"ior": 1.25},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [2, 1, 0]},
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationColor": [0.5, 1, 1], "attenuationDistance": 3},
            "KHR_materials_dispersion": {"dispersion": 0.5}
        }
    }]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(warnings, []);
    let material = &scene.materials[0];
    let m = metal_rough(material);
    assert_eq!(m.base_color.factor, [0.5, 0.25, 1.0]);
    assert_eq!((m.metallic.factor, m.roughness.factor, m.ior), (0.0, 0.125, 1.25));
    assert_eq!((m.specular.factor, m.specular_color.factor), (0.5, [2.0, 1.0, 0.0]));
    assert_eq!(m.dispersion, 0.5);
    let volume = m.volume.unwrap();
    assert_eq!((volume.attenuation_color, volume.attenuation_distance), ([0.5, 1.0, 1.0], 3.0));
    assert_eq!(material.emission.factor, [8.0, 4.0, 0.0]);
    assert!(material.emission_two_sided && material.double_sided);
    assert_eq!((material.alpha.mode, material.alpha.value.factor), (AlphaMode::Mask { cutoff: 0.25 }, 0.75));

    b.doc["materials"][0]["extensions"] = json!({"KHR_materials_volume": {"attenuationDistance": 3}});
    let (scene, _) = b.import().unwrap();
    assert!(metal_rough(&scene.materials[0]).volume.is_none(), "no thickness is a thin wall");
    b.doc["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}});
    let (scene, _) = b.import().unwrap();
    assert!(matches!(scene.materials[0].surface, Surface::Unlit(c) if c.factor == [0.5, 0.25, 1.0]));
    assert!(scene.materials[0].emission.is_black());
}

#[test]
fn layers_come_from_their_extensions() {
    let mut b = triangle();
    let png = b.view(&gltf_common::png());
    b.doc["images"] = json!([{"bufferView": png, "mimeType": "image/png"}]);
    b.doc["textures"] = json!([{"source": 0}]);
    b.doc["materials"] = json!([{"extensions": {
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.9, "clearcoatRoughnessTexture": {"index": 0}, "clearcoatRoughnessFactor": 0.2},
        "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 2], "sheenRoughnessFactor": 0.3},
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.8, "iridescenceIor": 0.5, "iridescenceThicknessMinimum": 50,
            "iridescenceThicknessTexture": {"index": 0, "texCoord": 1}
        },
        "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.4, "diffuseTransmissionTexture": {"index": 0}},
        "KHR_materials_diffuse_roughness": {"diffuseRoughnessFactor": 0.7}
    }}]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    let told: Vec<_> =
        warnings.iter().filter(|w| w.code == "factor-out-of-range").map(|w| w.place.to_string()).collect();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told.iter().any(|t| t.contains("/materials/0/extensions/KHR_materials_sheen/sheenColorFactor")),
        "{told:?}"
    );
    let l = scene.materials[0].layers().unwrap();
    assert_eq!((l.clearcoat.factor, l.clearcoat_roughness.factor), (0.9, 0.2));
    assert_eq!((l.clearcoat_roughness.channel, l.diffuse_transmission.channel), (Channel::G, Channel::A));
    assert!(l.clearcoat_roughness.texture.is_some() && l.clearcoat.texture.is_none());
    assert_eq!((l.sheen_color.factor, l.sheen_roughness.factor), ([0.1, 0.2, 1.0], 0.3));
    let thickness = l.iridescence_thickness;
    assert_eq!(
        (l.iridescence_ior, thickness.bias, thickness.factor, thickness.channel),
        (1.0, 50.0, 350.0, Channel::G)
    );
    assert_eq!(thickness.texture.unwrap().uv_set, 1);
    assert_eq!((l.diffuse_transmission.factor, l.diffuse_roughness.factor), (0.4, 0.7));
    assert_eq!(l.diffuse_transmission_color.factor, [1.0; 3]);
}

#[test]
fn glossiness_is_the_reverse_of_roughness() {
    let mut b = triangle();
    let png = b.view(&gltf_common::png());
    b.doc["images"] = json!([{"bufferView": png, "mimeType": "image/png"}]);
    b.doc["textures"] = json!([{"source": 0}]);
    b.doc["materials"] = json!([{"extensions": {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 1, 0.75], "specularFactor": [0.02, 0.04, 0.08], "glossinessFactor": 0.25,
        "specularGlossinessTexture": {"index": 0}
    }}}]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, _) = b.import().unwrap();
    let m = metal_rough(&scene.materials[0]);
    assert_eq!((m.base_color.factor, m.specular_color.factor), ([0.5, 0.25, 1.0], [0.5, 1.0, 2.0]));
    assert_eq!((m.roughness.bias, m.roughness.factor, m.roughness.channel), (1.0, -0.25, Channel::A));
    assert_eq!(m.roughness.texture, m.specular_color.texture);
}

#[test]
fn the_default_material_is_a_rough_metal() {
    let (scene, _) = triangle().import().unwrap();
    let m = metal_rough(&scene.materials[0]);
    assert_eq!((m.metallic.factor, m.roughness.factor), (1.0, 1.0));
    assert!(!scene.materials[0].double_sided);
}

#[test]
fn textures_are_shared_and_keep_their_samplers() {
    let mut b = triangle();
    let (png, copy) = (b.view(&gltf_common::png()), b.view(&gltf_common::png()));
    b.doc["images"] =
        json!([{"bufferView": png, "mimeType": "image/png"}, {"bufferView": copy, "mimeType": "image/png"}]);
    b.doc["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    b.doc["textures"] = json!([{"source": 0, "sampler": 0}, {"source": 1}]);
    let turn = json!({"rotation": std::f32::consts::FRAC_PI_2, "offset": [0.25, 0.5], "scale": [2, 4], "texCoord": 1});
    b.doc["materials"] = json!([{
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": turn}},
            "metallicRoughnessTexture": {"index": 0}
        },
        "emissiveTexture": {"index": 1}, "emissiveFactor": [1, 1, 1],
        "normalTexture": {"index": 99}
    }]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "missing-texture"));
    assert_eq!(scene.images.len(), 1, "both images are the same bytes");
    let m = metal_rough(&scene.materials[0]);
    let base = m.base_color.texture.unwrap();
    let texture = scene.textures[base.texture as usize];
    assert_eq!((texture.wrap_u, texture.wrap_v, texture.filter), (Wrap::Clamp, Wrap::Mirror, Filter::Nearest));
    assert_eq!(texture.color_space, ColorSpace::Srgb);
    let rough = m.roughness.texture.unwrap();
    assert_eq!(scene.textures[rough.texture as usize].color_space, ColorSpace::Linear);
    assert_eq!((m.roughness.channel, m.metallic.channel), (Channel::G, Channel::B));
    assert_eq!(base.uv_set, 1);
    // Scaled by (2, 4), turned by a quarter from +u to −v (v points down), moved.
    let [u, v] = base.transform.apply([1.0, 1.0]);
    assert!((u - 4.25).abs() < 1e-6 && (v + 1.5).abs() < 1e-6, "({u}, {v})");
}

#[test]
fn an_image_that_cannot_be_had_is_a_warning() {
    for (image, code) in [
        (json!({"uri": "nowhere.png"}), "missing-texture"),
        (json!({"uri": "../../../etc/passwd"}), "missing-texture"),
        (json!({"uri": "data:image/png;base64,AAAA"}), "unsupported-texture"),
        (json!({"uri": "data:image/png;base64,%%%"}), "missing-texture"),
        (json!({"uri": "%FF.png"}), "missing-texture"),
        (json!({"bufferView": 77}), "missing-texture"),
        (json!({}), "missing-texture"),
    ] {
        let mut b = triangle();
        b.doc["images"] = json!([image]);
        b.doc["textures"] = json!([{"source": 0}]);
        b.doc["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}}}]);
        b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
        let (scene, warnings) = b.import().unwrap();
        assert!(warned(&warnings, code), "{image}: {warnings:?}");
        let base = metal_rough(&scene.materials[0]).base_color;
        assert_eq!((base.factor, base.texture), ([0.5; 3], None));
        assert!(scene.textures.is_empty() && scene.images.is_empty());
    }
}

#[test]
fn cameras_lose_scale_and_keep_their_lens() {
    let mut b = triangle();
    b.doc["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": std::f64::consts::FRAC_PI_2, "znear": 0.1, "aspectRatio": 2}},
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}},
        {"type": "orthographic", "name": "plan", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0, "zfar": 9}},
        {"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}
    ]);
    b.doc["nodes"] = json!([
        {"mesh": 0, "scale": [2, 3, 4], "translation": [0, 0, 5], "children": [1, 2, 3, 4]},
        {"camera": 0, "name": "front"}, {"camera": 1}, {"camera": 2}, {"camera": 3}
    ]);
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "invalid-camera"));
    let [front, free, plan] = &scene.cameras[..] else { panic!("{}", scene.cameras.len()) };
    let close = |c: &Camera, f: [f64; 3], r: [f64; 3], u: [f64; 3]| {
        let pairs = [(c.forward, f), (c.right, r), (c.up, u)];
        pairs.iter().all(|(a, b)| a.distance((*b).into()) < 1e-6)
    };
    assert_eq!(front.origin.to_array(), [0.0, 0.0, 5.0]);
    assert!(close(front, [0.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]), "{front:?}");
    assert!(front.aspect.is_some() && free.aspect.is_none() && front.name == "front");
    assert_eq!((plan.projection, plan.name.as_str()), (Projection::Orthographic, "plan"));
    assert!(close(plan, [0.0, 0.0, -1.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]), "{plan:?}");
}

#[test]
fn lights_shine_along_minus_z() {
    let mut b = triangle();
    b.doc["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 3, "color": [1, 0.5, 0], "extras": {"a": 1}},
        {"type": "point", "range": 7},
        {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}},
        {"type": "spot", "spot": {"innerConeAngle": 2, "outerConeAngle": 2}},
        {"type": "candle"}
    ]}});
    let light = |i: u32| json!({"KHR_lights_punctual": {"light": i}});
    let half = std::f64::consts::FRAC_1_SQRT_2;
    b.doc["nodes"] = json!([
        {"mesh": 0}, {"extensions": light(0), "rotation": [-half, 0, 0, half]},
        {"extensions": light(1), "translation": [1, 2, 3], "scale": [5, 5, 5]}, {"extensions": light(2)},
        {"extensions": light(3)}, {"extensions": light(4)}, {"extensions": light(5)}
    ]);
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "invalid-light"));
    assert_eq!(scene.lights.len(), 4);
    let sun = &scene.lights[0];
    assert_eq!((sun.kind, sun.color), (LightKind::Directional, [3.0, 1.5, 0.0]));
    assert!(sun.direction.distance(glam::DVec3::NEG_Y) < 1e-12);
    assert_eq!(scene.lights[1].position.to_array(), [1.0, 2.0, 3.0]);
    let LightKind::Point { falloff, .. } = scene.lights[1].kind else { panic!() };
    assert_eq!(falloff, Falloff::InverseSquare { range: Some(7.0) });
    let LightKind::Spot { inner, outer, .. } = scene.lights[2].kind else { panic!() };
    assert_eq!((inner, outer), (0.25, 0.5));
}

#[test]
fn any_two_sets_of_texture_coordinates_can_be_read() {
    let mut b = triangle();
    let png = b.view(&gltf_common::png());
    b.doc["images"] = json!([{"bufferView": png, "mimeType": "image/png"}]);
    b.doc["textures"] = json!([{"source": 0}]);
    let texture = |set: u32| json!({"index": 0, "texCoord": set});
    let rough = json!({"baseColorTexture": texture(3), "metallicRoughnessTexture": texture(1)});
    b.doc["materials"] =
        json!([{"pbrMetallicRoughness": rough, "emissiveTexture": texture(4), "emissiveFactor": [1, 1, 1]}]);
    for set in [0, 1, 3, 4] {
        let uv = b.floats("VEC2", &[set as f32; 6]);
        b.doc["meshes"][0]["primitives"][0]["attributes"][format!("TEXCOORD_{set}")] = json!(uv);
    }
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    let m = metal_rough(&scene.materials[0]);
    let read = |texture: Option<kiln_formats::scene::TextureRef>| {
        texture.map(|t| scene.meshes[0].uvs[usize::from(t.uv_set)][0])
    };
    let all = [read(m.base_color.texture), read(m.roughness.texture), read(scene.materials[0].emission.texture)];
    // Which two of the three are read is the file's order; the third is named.
    let got = [Some([3.0; 2]), Some([1.0; 2]), Some([4.0; 2])];
    assert_eq!(all.iter().zip(got).filter(|(a, b)| **a == *b).count(), 2, "{all:?}");
    assert_eq!(all.iter().filter(|t| t.is_none()).count(), 1, "{all:?}");
    assert!(warned(&warnings, "texcoord-ignored"));
}

#[test]
fn an_empty_picture_is_explained_by_an_index_that_leads_nowhere() {
    let mut b = triangle();
    b.doc["nodes"][0] = json!({"camera": 7});
    let error = b.import().unwrap_err();
    assert_eq!((error.code.as_str(), error.place.to_string().as_str()), ("invalid", "/nodes/0/camera"));
}
