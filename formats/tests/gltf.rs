//! Geometry, hierarchy and structure of imported glTF.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod gltf_common;

use gltf_common::{Builder, TRIANGLE, import_bytes, import_json, triangle, warned};
use kiln_formats::{ErrorCode, Place};
use serde_json::json;

#[test]
fn a_plain_triangle_keeps_its_names_and_stays_flat() {
    let (scene, warnings) = triangle().import().unwrap();
    assert_eq!(scene.meshes[0].positions, TRIANGLE);
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert!(scene.meshes[0].normals.is_empty());
    assert_eq!((scene.meshes[0].name.as_str(), scene.instances[0].name.as_str()), ("m", "n"));
    assert_eq!(warnings, []);
}

#[test]
fn a_glb_gives_the_same_scene() {
    let (text, _) = triangle().import().unwrap();
    let (binary, _) = import_bytes(triangle().glb()).unwrap();
    assert_eq!(text.meshes[0].positions, binary.meshes[0].positions);
}

#[test]
fn lengths_that_lie_in_a_glb_are_errors() {
    let sound = triangle().glb();
    for (offset, value, at) in [(8, u32::MAX, 8), (12, 1 << 30, 12), (12, u32::MAX, 12)] {
        let mut bytes = sound.clone();
        bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        let error = import_bytes(bytes).unwrap_err();
        assert_eq!((error.code, error.place), (ErrorCode::Syntax, Place::Byte(at)));
    }
    for len in 4..sound.len() {
        assert!(import_bytes(sound[..len].to_vec()).is_err(), "cut to {len} bytes");
    }
}

#[test]
fn indices_of_every_type_and_strips_name_the_same_triangles() {
    for (component, bytes) in [
        (5121, vec![0u8, 1, 2, 2, 1, 3]),
        (5123, [0u16, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
        (5125, [0u32, 1, 2, 2, 1, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
    ] {
        let mut b = Builder::new();
        let quad = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
        let positions = b.floats("VEC3", &quad);
        let list = b.accessor(json!({"type": "SCALAR", "componentType": component, "count": 6}), &bytes);
        b.doc["meshes"] = json!([{"primitives": [
            {"attributes": {"POSITION": positions}, "indices": list},
            {"attributes": {"POSITION": positions}, "mode": 5},
        ]}]);
        b.doc["nodes"] = json!([{"mesh": 0}]);
        let (scene, _) = b.import().unwrap();
        assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [2, 1, 3]]);
        // The second triangle of a strip turns round, so that both face the same way.
        assert_eq!(scene.meshes[1].triangles, [[0, 1, 2], [1, 3, 2]]);
    }
}

#[test]
fn sparse_values_replace_zeros_and_stored_values() {
    let mut b = Builder::new();
    let indices = b.view(&[1u8, 2]);
    let values = b.view(&Builder::bytes(&TRIANGLE.as_flattened()[3..]));
    let sparse = json!({"count": 2, "indices": {"bufferView": indices, "componentType": 5121}, "values": {"bufferView": values}});
    let blank = b.raw(json!({"type": "VEC3", "componentType": 5126, "count": 3, "sparse": sparse}));
    let under = b.view(&Builder::bytes(&[9.0; 9]));
    let stored =
        b.raw(json!({"type": "VEC3", "componentType": 5126, "count": 3, "bufferView": under, "sparse": sparse}));
    b.doc["meshes"] =
        json!([{"primitives": [{"attributes": {"POSITION": blank}}, {"attributes": {"POSITION": stored}}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    let (scene, _) = b.import().unwrap();
    assert_eq!(scene.meshes[0].positions, TRIANGLE);
    assert_eq!(scene.meshes[1].positions, [[9.0; 3], TRIANGLE[1], TRIANGLE[2]]);
}

#[test]
fn normalised_interleaved_and_quantised_attributes() {
    let mut b = Builder::new();
    // Per vertex: three i16 (position, not normalised), 2 bytes padding, four u8 (colour, normalised), two i8 (uv).
    let mut bytes = Vec::new();
    for p in [[0i16, 0, 0], [300, 0, 0], [0, -300, 0]] {
        p.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0, 0, 255, 0, 51, 255, 127, 0x80, 0, 0]);
    }
    let view = b.strided_view(&bytes, 16);
    let mut part = |kind: &str, component: u32, offset: u32, normalized: bool| {
        b.raw(json!({"bufferView": view, "byteOffset": offset, "type": kind, "componentType": component, "count": 3,
            "normalized": normalized}))
    };
    let (p, c, uv) = (part("VEC3", 5122, 0, false), part("VEC4", 5121, 8, true), part("VEC2", 5120, 12, true));
    b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": p, "COLOR_0": c, "TEXCOORD_0": uv}}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    b.doc["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let (scene, _) = b.import().unwrap();
    assert_eq!(scene.meshes[0].positions, [[0.0; 3], [300.0, 0.0, 0.0], [0.0, -300.0, 0.0]]);
    assert_eq!(scene.meshes[0].colors[1], [1.0, 0.0, 0.2, 1.0]);
    assert_eq!(scene.meshes[0].uvs[0][2], [1.0, -1.0]);
}

#[test]
fn transforms_are_composed_in_double_precision_and_may_mirror() {
    let mut b = triangle();
    b.doc["nodes"] = json!([
        {"translation": [1e7, 0, 0], "scale": [-1, 1, 1], "children": [1]},
        {"translation": [0.125, 0, 0.1], "mesh": 0},
        {"rotation": [0, 0, std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2], "mesh": 0},
    ]);
    let (scene, _) = b.import().unwrap();
    assert_eq!(scene.meshes.len(), 1, "both nodes share the geometry");
    let mirrored = scene.instances[0].transform;
    assert_eq!(mirrored.translation.to_array(), [1e7 - 0.125, 0.0, 0.1]);
    assert!(mirrored.matrix3.determinant() < 0.0);
    let turned = scene.instances[1].transform.transform_point3(glam::DVec3::X);
    assert!(turned.distance(glam::DVec3::Y) < 1e-15);
}

#[test]
fn wrong_hierarchies_and_indices_name_their_place() {
    let cases = [
        ("/nodes/0/children", json!([1]), "/nodes/0"),
        ("/nodes/2/children", json!([0]), "/nodes/2/children/0"),
        ("/nodes/2/children", json!([3]), "/nodes/2/children/0"),
        ("/nodes/2/mesh", json!(7), "/nodes/2/mesh"),
        ("/scene", json!(4), "/scene"),
        ("/accessors/0/bufferView", json!(9), "/accessors/0/bufferView"),
        ("/accessors/0/bufferView", json!(4294967296u64), "/accessors/0"),
        ("/accessors/0/count", json!(4), "/accessors/0/bufferView"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "/accessors/0/bufferView"),
        ("/accessors/0/type", json!("VEC2"), "/accessors/0/type"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "/bufferViews/0"),
        ("/bufferViews/0/byteStride", json!(4), "/bufferViews/0/byteStride"),
        ("/bufferViews/0/buffer", json!(1), "/bufferViews/0/buffer"),
        ("/buffers/0/byteLength", json!(1000), "/buffers/0/byteLength"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(5), "/meshes/0/primitives/0/attributes/POSITION"),
    ];
    for (path, value, place) in cases {
        let mut b = triangle();
        b.doc["nodes"] = json!([{}, {"children": [0]}, {"mesh": 0}]);
        b.finish();
        let (parent, key) = path.rsplit_once('/').unwrap();
        b.doc.pointer_mut(parent).unwrap()[key] = value;
        let error = import_json(&b.doc).unwrap_err();
        assert_eq!(error.code, ErrorCode::Invalid, "{path}: {error}");
        assert_eq!(error.place, Place::Json(place.into()), "{path}: {error}");
    }
}

#[test]
fn bad_vertex_indices_cost_their_triangles_alone() {
    let with_indices = |indices: &[u8]| {
        let mut b = triangle();
        let index = b.accessor(json!({"type": "SCALAR", "componentType": 5121, "count": indices.len()}), indices);
        b.doc["meshes"][0]["primitives"][0]["indices"] = json!(index);
        b.import()
    };
    let (scene, warnings) = with_indices(&[0, 1, 2, 0, 1, 200]).unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert!(warned(&warnings, "index-out-of-range"));
    let error = with_indices(&[0, 1, 200]).unwrap_err();
    assert_eq!(error.place, Place::Json("/meshes/0/primitives/0/indices".into()));
}

#[test]
fn positions_that_are_not_finite_cost_their_triangles_alone() {
    let mut b = Builder::new();
    let mut values = [TRIANGLE, TRIANGLE].concat();
    values[4][1] = f32::NAN;
    let positions = b.floats("VEC3", values.as_flattened());
    b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert!(warned(&warnings, "not-finite"));
}

#[test]
fn a_small_part_of_a_large_vertex_array_is_read_alone() {
    let mut b = Builder::new();
    let many: Vec<f32> = (0..3000).map(|i| i as f32).collect();
    let positions = b.floats("VEC3", &many);
    let index = b.accessor(json!({"type": "SCALAR", "componentType": 5121, "count": 3}), &[200, 7, 90]);
    b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}, "indices": index}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    let (scene, _) = b.import().unwrap();
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 3);
    let corners = mesh.triangles[0].map(|i| mesh.positions[i as usize][0]);
    assert_eq!(corners, [600.0, 21.0, 270.0]);
}

#[test]
fn required_extensions_and_versions_are_honoured() {
    let mut b = triangle();
    b.doc["extensionsUsed"] = json!(["VENDOR_materials_felt", "KHR_materials_ior", "VENDOR_materials_felt"]);
    let (_, warnings) = b.import().unwrap();
    let places: Vec<_> = warnings.iter().map(|w| (w.code.as_str(), w.place.as_str())).collect();
    assert_eq!(places, [("unsupported-extension", "/extensionsUsed/0")]);
    b.doc["extensionsRequired"] = json!(["KHR_materials_ior", "VENDOR_materials_varnish"]);
    let error = b.import().unwrap_err();
    assert_eq!(error.code, ErrorCode::Unsupported);
    assert_eq!(error.place, Place::Json("/extensionsRequired/1".into()));
    assert!(error.message.contains("VENDOR_materials_varnish"));
    for (asset, code) in [
        (json!({"version": "1.0"}), ErrorCode::Unsupported),
        (json!({"version": "2.1", "minVersion": "2.1"}), ErrorCode::Unsupported),
        (json!({}), ErrorCode::Invalid),
    ] {
        let mut b = triangle();
        b.doc["asset"] = asset;
        assert_eq!(b.import().unwrap_err().code, code);
    }
}

#[test]
fn scenes_are_chosen_and_hidden_nodes_left_out() {
    let mut b = triangle();
    b.doc["nodes"] =
        json!([{"mesh": 0, "name": "a"}, {"mesh": 0, "name": "b", "children": [2]}, {"mesh": 0, "name": "c"}]);
    b.doc["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    let names =
        |b: &Builder| b.clone().import().unwrap().0.instances.iter().map(|i| i.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&b), ["a"]);
    b.doc["scene"] = json!(1);
    assert_eq!(names(&b), ["b", "c"]);
    b.doc["nodes"][2]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    assert_eq!(names(&b), ["b"]);
    b.doc["scenes"] = json!([{"nodes": [0]}, {"nodes": []}]);
    assert_eq!(b.import().unwrap_err().code, ErrorCode::Empty);
}

#[test]
fn points_and_lines_are_counted() {
    let mut b = triangle();
    let position = b.doc["meshes"][0]["primitives"][0].clone();
    let with_mode = |mode: u32| {
        let mut p = position.clone();
        p["mode"] = json!(mode);
        p
    };
    b.doc["meshes"][0]["primitives"] = json!([with_mode(0), position, with_mode(3)]);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(scene.triangle_count(), 1);
    let warning = warnings.iter().find(|w| w.code == "points-or-lines-not-drawn").unwrap();
    assert_eq!(warning.place, "/meshes/0/primitives/0");
    assert!(warning.message.starts_with("2 "));
}

#[test]
fn too_many_triangles_are_refused_before_they_are_read() {
    let mut b = triangle();
    let nodes: Vec<_> = (0..1000).map(|_| json!({"mesh": 0})).collect();
    b.doc["nodes"] = json!(nodes);
    let limits = kiln_formats::Limits { max_triangles: 999, ..Default::default() };
    assert_eq!(b.import_with(limits).unwrap_err().code, ErrorCode::TooLarge);
    // A few bytes that claim four billion vertices.
    let blank = b.raw(json!({"type": "VEC3", "componentType": 5126, "count": u32::MAX, "sparse": {
        "count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}}}));
    b.doc["nodes"] = json!([{"mesh": 0}]);
    b.doc["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(blank);
    let limits = kiln_formats::Limits { max_triangles: u64::MAX, ..Default::default() };
    assert_eq!(b.import_with(limits).unwrap_err().code, ErrorCode::Invalid);
}

#[test]
fn deep_hierarchies_and_deep_json_end_in_errors() {
    let mut b = triangle();
    let mut nodes: Vec<_> = (1..5000).map(|i| json!({"children": [i]})).collect();
    nodes.push(json!({"mesh": 0}));
    b.doc["nodes"] = json!(nodes);
    assert_eq!(b.import().unwrap_err().code, ErrorCode::TooLarge);
    let deep = format!("{}{}", "[".repeat(1 << 20), "]".repeat(1 << 20));
    assert_eq!(import_bytes(deep.into_bytes()).unwrap_err().code, ErrorCode::Syntax);
}
