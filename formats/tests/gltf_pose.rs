//! Rest poses and tangent spaces of imported glTF.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod gltf_common;

use gltf_common::{Builder, png, warned};
use kiln_formats::repair::tangents;
use kiln_formats::scene::{Mesh, UvTransform};
use serde_json::json;

const QUAD: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];

fn quad() -> (Builder, usize) {
    let mut b = Builder::new();
    let positions = b.floats("VEC3", &QUAD);
    let indices = b.accessor(json!({"type": "SCALAR", "componentType": 5121, "count": 6}), &[0, 1, 2, 0, 2, 3]);
    b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    (b, positions)
}

fn translation(x: f32, y: f32, z: f32) -> [f32; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
}

/// World positions of an instance's vertices.
fn world(scene: &kiln_formats::Scene, instance: usize) -> Vec<[f64; 3]> {
    let i = &scene.instances[instance];
    let point = |p: &[f32; 3]| i.transform.transform_point3(glam::DVec3::from(p.map(f64::from))).to_array();
    scene.meshes[i.mesh as usize].positions.iter().map(point).collect()
}

#[test]
fn skinned_vertices_follow_their_joints_and_not_their_node() {
    let (mut b, _) = quad();
    // The lower edge follows joint 0, the upper one half of joint 1 and half of joint 0.
    let joints = b.accessor(
        json!({"type": "VEC4", "componentType": 5121, "count": 4}),
        &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
    );
    let weights = b.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
    let normals = b.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let binds = b.floats("MAT4", &[translation(0.0, 0.0, 0.0), translation(0.0, -1.0, 0.0)].concat());
    let attributes = &mut b.doc["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["NORMAL"] = json!(normals);
    b.doc["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": binds}]);
    b.doc["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 100, 100]},
        {"translation": [1e6, 0, 0], "children": [2]},
        {"translation": [0, 3, 0]}
    ]);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(warnings, []);
    // Joint 1 was bound at y = 1 and is at y = 3: it lifts by 2, half of it by 1.
    let x = 1e6;
    let expected = [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 2.0, 0.0], [x, 2.0, 0.0]];
    assert_eq!(world(&scene, 0), expected);
    assert_eq!(scene.meshes[0].normals, [[0.0, 0.0, 1.0]; 4]);

    b.doc["skins"] = json!([{"joints": [1, 77]}]);
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "skin-ignored"));
    assert_eq!(world(&scene, 0)[0], [100.0; 3]);
}

#[test]
fn morph_targets_apply_by_their_initial_weights() {
    let (mut b, positions) = quad();
    let lift = b.floats("VEC3", &[0.0, 0.0, 2.0].repeat(4));
    b.doc["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}, {"POSITION": positions}]);
    b.doc["meshes"][0]["weights"] = json!([0.5, 0]);
    b.doc["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 1]}, {"mesh": 0, "translation": [0, 0, 1]}]);
    let (scene, warnings) = b.import().unwrap();
    assert_eq!(warnings, []);
    assert_eq!(scene.meshes.len(), 2, "nodes of equal weights share a mesh");
    assert_eq!(world(&scene, 0)[2], [1.0, 1.0, 1.0]);
    assert_eq!(world(&scene, 1)[2], [2.0, 2.0, 0.0]);
    assert_eq!(world(&scene, 2)[2], [1.0, 1.0, 2.0]);
}

/// The quad with normals, upright texture coordinates (v down) and a normal map.
fn mapped_quad() -> Builder {
    let (mut b, _) = quad();
    let normals = b.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let uvs = b.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let view = b.view(&png());
    b.doc["images"] = json!([{"bufferView": view}]);
    b.doc["textures"] = json!([{"source": 0}]);
    b.doc["materials"] = json!([{"normalTexture": {"index": 0, "scale": 0.5}}]);
    let primitive = &mut b.doc["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["attributes"]["NORMAL"] = json!(normals);
    primitive["attributes"]["TEXCOORD_0"] = json!(uvs);
    b
}

#[test]
fn tangents_are_made_for_normal_maps() {
    let (scene, _) = mapped_quad().import().unwrap();
    // u grows along +x; the bitangent cross(n, t)·w points up, against v: w = 1.
    assert_eq!(scene.meshes[0].tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
    assert_eq!(scene.materials[0].normal_map.unwrap().scale, 0.5);

    let mut b = mapped_quad();
    let given = b.floats("VEC4", &[0.0, 1.0, 0.0, -1.0].repeat(4));
    b.doc["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(given);
    let (scene, _) = b.import().unwrap();
    assert_eq!(scene.meshes[0].tangents, [[0.0, 1.0, 0.0, -1.0]; 4]);
}

#[test]
fn a_primitive_that_cannot_have_tangents_loses_its_normal_map_alone() {
    let mut b = mapped_quad();
    let mapped = b.doc["meshes"][0]["primitives"][0].clone();
    let mut bare = mapped.clone();
    bare["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
    b.doc["meshes"][0]["primitives"] = json!([bare, mapped]);
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "normal-map-ignored"));
    let map = |m: usize| scene.materials[scene.meshes[m].material as usize].normal_map;
    assert!(map(0).is_none() && map(1).is_some());
}

#[test]
fn mirrored_seams_double_their_vertices() {
    // Two quads side by side share an edge; the right one's texture is mirrored.
    let mut mesh = Mesh {
        positions: [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]]
            .map(|[x, y]| [x, y, 0.0])
            .to_vec(),
        normals: vec![[0.0, 0.0, 1.0]; 6],
        triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
        ..Mesh::default()
    };
    mesh.uvs[1] = vec![[0.0, 1.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 0.0]];
    let before: Vec<_> = mesh.triangles.as_flattened().iter().map(|i| mesh.positions[*i as usize]).collect();
    tangents::generate(&mut mesh, 1, &UvTransform::IDENTITY).unwrap();
    assert_eq!(mesh.positions.len(), 8);
    assert_eq!(mesh.uvs[1].len(), 8);
    let after: Vec<_> = mesh.triangles.as_flattened().iter().map(|i| mesh.positions[*i as usize]).collect();
    assert_eq!(before, after);
    for (t, expected) in mesh.triangles.iter().zip([[1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [-1.0, -1.0]]) {
        for i in t {
            let [x, y, z, w] = mesh.tangents[*i as usize];
            assert_eq!([x, w], expected);
            assert_eq!([y, z], [0.0, 0.0]);
        }
    }
}

#[test]
fn hostile_meshes_get_tangents_or_a_reason() {
    let mut mesh = Mesh { positions: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    assert_eq!(tangents::generate(&mut mesh, 0, &UvTransform::IDENTITY), Err(tangents::NoTangents::TextureCoordinates));
    mesh.normals = vec![[0.0, 0.0, 1.0]; 2];
    mesh.uvs[0] = vec![[0.5, 0.5]; 3];
    assert_eq!(tangents::generate(&mut mesh, 0, &UvTransform::IDENTITY), Err(tangents::NoTangents::Normals));
    mesh.normals = vec![[0.0, 0.0, 1.0]; 3];
    // Degenerate positions and texture coordinates still give unit tangents across the normal.
    mesh.uvs[0] = vec![[0.5, 0.5]; 3];
    tangents::generate(&mut mesh, 0, &UvTransform::IDENTITY).unwrap();
    for [x, y, z, w] in &mesh.tangents {
        assert!((x * x + y * y - 1.0).abs() < 1e-6 && *z == 0.0 && w.abs() == 1.0);
    }
    // A fan of 100 000 triangles around one vertex would overflow the stack of a recursive generator.
    let rim = 100_000u32;
    let at = |k: u32| {
        let (sin, cos) = (k as f32 * std::f32::consts::TAU / rim as f32).sin_cos();
        [cos, sin, 0.0]
    };
    let mut fan = Mesh {
        positions: std::iter::once([0.0; 3]).chain((0..rim).map(at)).collect(),
        normals: vec![[0.0, 0.0, 1.0]; rim as usize + 1],
        triangles: (1..rim).map(|k| [0, k, k + 1]).collect(),
        ..Mesh::default()
    };
    fan.uvs[0] = fan.positions.iter().map(|[x, y, _]| [*x, -*y]).collect();
    let error = tangents::generate(&mut fan, 0, &UvTransform::IDENTITY);
    assert_eq!(error, Err(tangents::NoTangents::Fan));
    assert_eq!(fan.positions.len(), rim as usize + 1);
    // Under the limit it works, in a small stack too.
    fan.triangles.truncate(2048);
    std::thread::Builder::new()
        .stack_size(64 << 10)
        .spawn(move || tangents::generate(&mut fan, 0, &UvTransform::IDENTITY).unwrap())
        .unwrap()
        .join()
        .unwrap();
}
