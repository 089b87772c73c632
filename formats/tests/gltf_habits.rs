//! What files of the wild do though they should not, and what is meant by it.

mod gltf_common;

use gltf_common::*;
use kiln_formats::scene::Surface;
use kiln_formats::{ErrorCode, Limits, Place, Resources};
use serde_json::{Value, json};
use std::fs;

/// Where the URI of the one buffer is changed by `rewrite`.
fn with_uri(rewrite: impl Fn(&str) -> String) -> Outcome {
    let mut b = triangle();
    b.finish();
    let uri = b.doc["buffers"][0]["uri"].as_str().map(rewrite).unwrap();
    b.doc["buffers"][0]["uri"] = json!(uri);
    import_json(&b.doc)
}

#[test]
fn data_uris_are_read_as_people_write_them() {
    let head = "data:application/octet-stream;base64,";
    for (what, outcome) in [
        ("charset", with_uri(|uri| uri.replace(head, "data:application/gltf-buffer;charset=utf-8;base64,"))),
        ("lines", with_uri(|uri| format!("{}\n  {}", &uri[..head.len() + 9], &uri[head.len() + 9..]))),
        ("percent", with_uri(|uri| uri.replace('A', "%41").replace('=', "%3D"))),
        ("for URLs", with_uri(|uri| format!("{head}{}", uri[head.len()..].replace('+', "-").replace('/', "_")))),
        ("no type", with_uri(|uri| uri.replace(head, "DATA:;base64,"))),
    ] {
        assert_eq!(outcome.unwrap().0.meshes[0].positions, TRIANGLE, "{what}");
    }
    assert_eq!(with_uri(|uri| uri.replace('A', "!")).unwrap_err().code, ErrorCode::Invalid);
}

#[test]
fn files_are_found_by_their_last_name_beside_the_asset() {
    let folder = tempfile::tempdir().unwrap();
    let asset = folder.path().join("asset");
    fs::create_dir(&asset).unwrap();
    fs::write(asset.join("wood.png"), png()).unwrap();
    fs::write(folder.path().join("secret.png"), png()).unwrap();
    let textures = |uri: &str, root: &std::path::Path| {
        let mut b = triangle();
        b.doc["images"] = json!([{"uri": uri}]);
        b.doc["textures"] = json!([{"source": 0}]);
        b.doc["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
        b.finish();
        let path = asset.join("a.gltf");
        let mut resources = Resources::new(&path, Some(root), Limits::default()).unwrap();
        let (mut warnings, mut contents) = (Vec::new(), Default::default());
        let bytes = b.doc.to_string().into_bytes();
        let show = Default::default();
        let control = Default::default();
        let scene =
            kiln_formats::gltf::import(bytes, &mut resources, &show, &mut contents, &mut warnings, &control).unwrap();
        (scene.images.len(), warnings)
    };
    for uri in [
        "wood.png?v=3",
        "C:\\Users\\me\\maps\\wood.png",
        "file:///home/me/wood.png",
        "lost%20folder/WOOD.png",
        "https://example.org/wood.png#x",
    ] {
        assert_eq!(textures(uri, &asset), (1, Vec::new()), "{uri}");
    }
    for uri in ["../secret.png", "../../etc/secret.png", "gone.png"] {
        let (images, warnings) = textures(uri, &asset);
        assert!(images == 0 && warned(&warnings, "missing-texture"), "{uri}");
    }
}

#[test]
fn attributes_of_wrong_kinds_are_taken_for_what_they_mean() {
    let mut b = triangle();
    let colors = b.accessor(json!({"type": "VEC4", "componentType": 5121, "count": 3}), &[255; 12]);
    b.doc["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(scene.meshes[0].colors, [[1.0; 4]; 3]);
    assert_eq!(warnings[0].place, "/accessors/1/normalized");
    for kind in [5120, 5126] {
        let mut b = triangle();
        let bytes = if kind == 5126 { Builder::bytes(&[1.0, 0.0, 0.0, 0.0].repeat(3)) } else { [1, 0, 0, 0].repeat(3) };
        let joints = b.accessor(json!({"type": "VEC4", "componentType": kind, "count": 3}), &bytes);
        let weights = b.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
        let attributes = &mut b.doc["meshes"][0]["primitives"][0]["attributes"];
        (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
        b.doc["skins"] = json!([{"joints": [1, 2]}]);
        b.doc["nodes"] = json!([{"mesh": 0, "skin": 0}, {}, {"translation": [0, 5, 0]}]);
        let (scene, _) = b.import().unwrap();
        let place = scene.instances[0].transform.translation.y + f64::from(scene.meshes[0].positions[1][1]);
        assert_eq!(place, 5.0, "{kind}");
    }
}

#[test]
fn strips_begin_anew_at_the_largest_index() {
    let mut b = triangle();
    let indices = b.accessor(json!({"type": "SCALAR", "componentType": 5121, "count": 7}), &[0, 1, 2, 255, 2, 1, 0]);
    b.doc["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    b.doc["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 0]]);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn a_bad_property_costs_itself() {
    let mut b = triangle();
    b.doc["materials"] = json!([{
        "emissiveFactor": null,
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0], "metallicFactor": "none", "roughnessFactor": 0.5},
    }]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (scene, warnings) = b.import().unwrap();
    let Surface::MetalRough(m) = &scene.materials[0].surface else { panic!() };
    assert_eq!((m.base_color.factor, m.roughness.factor), ([0.5, 0.25, 0.0], 0.5));
    let places: Vec<_> = warnings.iter().map(|w| (w.code.as_str(), w.place.as_str())).collect();
    assert_eq!(places, [("invalid-object", "/materials/0/pbrMetallicRoughness/metallicFactor")]);
}

#[test]
fn versions_and_scenes_are_taken_for_what_they_mean() {
    for version in [json!("2"), json!(2), json!(2.0)] {
        let mut b = triangle();
        b.doc["asset"]["version"] = version.clone();
        assert!(b.import().is_ok(), "{version}");
    }
    for version in [json!("1"), json!(1), json!("two"), json!(-2)] {
        let mut b = triangle();
        b.doc["asset"]["version"] = version.clone();
        let error = b.import().unwrap_err();
        assert!(error.place.to_string().starts_with("/asset"), "{version}: {error}");
    }
    let mut b = triangle();
    b.doc["scenes"] = json!([{}, {"nodes": [0]}]);
    assert_eq!(b.import().unwrap().0.instances.len(), 1, "the first scene that has anything in it");
    b.doc["scene"] = json!(0);
    assert_eq!(b.import().unwrap_err().code, ErrorCode::Empty);
}

#[test]
fn extensions_are_honoured_harmless_named_or_refused() {
    let requiring = |name: &str| {
        let mut b = triangle();
        (b.doc["extensionsUsed"], b.doc["extensionsRequired"]) = (json!([name]), json!([name]));
        b.import()
    };
    for name in ["KHR_node_selectability", "EXT_mesh_features", "EXT_structural_metadata", "VRMC_vrm"] {
        assert_eq!(requiring(name).unwrap().1, [], "{name}");
    }
    for name in ["KHR_materials_volume_scatter", "EXT_texture_avif", "EXT_lights_image_based", "MSFT_lod"] {
        let warnings = requiring(name).unwrap().1;
        assert!(warned(&warnings, "unsupported-extension") && warnings[0].message.contains(": "), "{warnings:?}");
    }
    for name in ["KHR_accessor_float64", "VENDOR_points"] {
        let error = requiring(name).unwrap_err();
        assert_eq!((error.code, error.place), (ErrorCode::Unsupported, Place::Json("/extensionsRequired/0".into())));
    }
}

#[test]
fn images_that_are_not_read_are_named_by_their_format() {
    let textured = |image: Value, texture: Value| {
        let mut b = triangle();
        b.doc["images"] = json!([image]);
        b.doc["textures"] = json!([texture]);
        b.doc["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
        b.import().unwrap().1
    };
    let avif = json!({"extensions": {"EXT_texture_avif": {"source": 0}}});
    let warnings = textured(json!({"uri": "a.avif"}), avif);
    assert!(warned(&warnings, "unsupported-texture") && warnings[0].message.contains("AVIF"), "{warnings:?}");
    let warnings = textured(json!({"uri": "data:,no%20picture"}), json!({"source": 0}));
    assert!(warned(&warnings, "unsupported-texture"), "{warnings:?}");
}

#[test]
fn morphed_colours_are_named() {
    let mut b = triangle();
    let deltas = b.floats("VEC4", &[0.1; 12]);
    b.doc["meshes"][0]["primitives"][0]["targets"] = json!([{"COLOR_0": deltas}]);
    let (_, warnings) = b.import().unwrap();
    assert_eq!(warnings[0].place, "/meshes/0/primitives/0/targets/0/COLOR_0");
    assert!(warned(&warnings, "morph-ignored"));
}
