//! Damaged glTF documents end in a scene or an error; never in a panic, an endless loop or an invalid scene.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod gltf_common;

use gltf_common::{Builder, import_bytes, png};
use serde_json::json;

/// A document that uses most of what the importer knows.
fn rich() -> Builder {
    let mut b = Builder::new();
    let positions = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let normals = b.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let uvs = b.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let colors = b.accessor(json!({"type": "VEC3", "componentType": 5123, "count": 4, "normalized": true}), &[200; 24]);
    let joints = b.accessor(json!({"type": "VEC4", "componentType": 5121, "count": 4}), &[0, 1, 0, 0].repeat(4));
    let weights = b.floats("VEC4", &[0.5, 0.5, 0.0, 0.0].repeat(4));
    let mut identity = [0.0f32; 16];
    [0, 5, 10, 15].into_iter().for_each(|i| identity[i] = 1.0);
    let binds = b.floats("MAT4", &identity.repeat(2));
    let list = b.accessor(json!({"type": "SCALAR", "componentType": 5121, "count": 6}), &[0, 1, 2, 0, 2, 3]);
    let (indices, values) = (b.view(&[1, 0, 3, 0]), b.view(&Builder::bytes(&[0.5; 6])));
    let sparse = b.raw(json!({"type": "VEC3", "componentType": 5126, "count": 4, "sparse": {"count": 2,
        "indices": {"bufferView": indices, "componentType": 5123}, "values": {"bufferView": values}}}));
    let image = b.view(&png());
    b.doc["images"] = json!([{"bufferView": image, "mimeType": "image/png"}]);
    b.doc["samplers"] = json!([{"wrapS": 33071, "magFilter": 9728}]);
    b.doc["textures"] = json!([{"source": 0, "sampler": 0}]);
    b.doc["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0,
            "extensions": {"KHR_texture_transform": {"rotation": 0.5, "scale": [2, 2]}}}, "roughnessFactor": 0.5},
        "normalTexture": {"index": 0}, "alphaMode": "BLEND", "doubleSided": true,
        "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_volume": {"thicknessFactor": 1},
            "KHR_materials_transmission": {"transmissionFactor": 0.5}}
    }]);
    b.doc["meshes"] = json!([{"weights": [0.5], "primitives": [
        {"attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs, "COLOR_0": colors,
            "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": list, "material": 0, "targets": [{"POSITION": sparse}]}
    ]}, {"primitives": [{"attributes": {"POSITION": positions}, "mode": 5}]}]);
    b.doc["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    b.doc["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    b.doc["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"outerConeAngle": 1}}]}});
    b.doc["nodes"] = json!([
        {"mesh": 0, "skin": 0}, {"children": [2, 3], "rotation": [0, 0, 0, 1]}, {"mesh": 1, "translation": [1, 2, 3]},
        {"camera": 0, "mesh": 0, "scale": [1, -1, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    b.doc["scenes"] = json!([{"nodes": [0, 1]}]);
    b.doc["scene"] = json!(0);
    b
}

/// Marsaglia's xorshift64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

#[test]
fn the_document_is_sound_before_it_is_damaged() {
    let (scene, warnings) = rich().import().unwrap();
    assert_eq!(warnings, []);
    assert_eq!((scene.instances.len(), scene.cameras.len(), scene.lights.len()), (3, 1, 1));
}

#[test]
fn flipped_bytes_and_changed_numbers() {
    let sound = rich().glb();
    // Where the JSON ends: its length is at byte 12.
    let text = 20 + u32::from_le_bytes(sound[12..16].try_into().unwrap()) as usize;
    let mut random = Random(0x6b69_6c6e);
    let (mut shown, mut refused) = (0, 0);
    for round in 0..6000 {
        let mut bytes = sound.clone();
        for _ in 0..1 + random.below(3) {
            match round % 3 {
                // Any bit of the file.
                0 => {
                    let at = random.below(bytes.len());
                    bytes[at] ^= 1 << random.below(8);
                }
                // A digit of the JSON.
                1 => {
                    let at = random.below(text);
                    if let Some(d) = bytes[at..text].iter().position(u8::is_ascii_digit) {
                        bytes[at + d] = b'0' + random.below(10) as u8;
                    }
                }
                // A byte of the data, to a nasty one.
                _ => {
                    let at = text + random.below(bytes.len() - text);
                    bytes[at] = [0, 0x7f, 0x80, 0xff][random.below(4)];
                }
            }
        }
        match import_bytes(bytes) {
            Ok(_) => shown += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(shown > 500 && refused > 500, "{shown} shown, {refused} refused");
}

#[test]
fn values_of_wrong_types_and_sizes() {
    let mut b = rich();
    b.finish();
    let mut paths = Vec::new();
    collect(&b.doc, String::new(), &mut paths);
    let values = [
        json!(null),
        json!(-1),
        json!(1e30),
        json!(u64::MAX),
        json!("x"),
        json!([]),
        json!({}),
        json!([[1e300]]),
        json!(true),
    ];
    for path in &paths {
        for value in &values {
            let mut document = b.doc.clone();
            *document.pointer_mut(path).unwrap() = value.clone();
            // Whatever it is, it ends, and a scene that is given is valid.
            let _ = gltf_common::import_json(&document);
        }
    }
    assert!(paths.len() > 200, "{}", paths.len());
}

fn collect(value: &serde_json::Value, path: String, paths: &mut Vec<String>) {
    let children: Vec<(String, &serde_json::Value)> = match value {
        serde_json::Value::Object(m) => m.iter().map(|(k, v)| (format!("{path}/{k}"), v)).collect(),
        serde_json::Value::Array(a) => a.iter().enumerate().map(|(i, v)| (format!("{path}/{i}"), v)).collect(),
        _ => Vec::new(),
    };
    for (path, child) in children {
        paths.push(path.clone());
        collect(child, path, paths);
    }
}
