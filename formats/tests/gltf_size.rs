//! A large glTF file imports fast and in little memory.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod gltf_common;

use gltf_common::import_bytes;
use serde_json::json;
use std::time::{Duration, Instant};

/// A GLB of a grid of `side` × `side` quads with normals and texture coordinates.
fn grid(side: u32) -> Vec<u8> {
    let mut b = gltf_common::Builder::new();
    let vertices = || (0..=side).flat_map(|y| (0..=side).map(move |x| (x as f32, y as f32)));
    let positions: Vec<f32> = vertices().flat_map(|(x, y)| [x, y, libm::sinf(x * 0.1)]).collect();
    let normals: Vec<f32> = vertices().flat_map(|_| [0.0, 0.0, 1.0]).collect();
    let uvs: Vec<f32> = vertices().flat_map(|(x, y)| [x, y]).collect();
    let corner = |x: u32, y: u32| y * (side + 1) + x;
    let quads = (0..side).flat_map(|y| (0..side).map(move |x| (x, y)));
    let indices: Vec<u8> = quads
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            [a, b, c, a, c, d]
        })
        .flat_map(u32::to_le_bytes)
        .collect();
    let (p, n, uv) = (b.floats("VEC3", &positions), b.floats("VEC3", &normals), b.floats("VEC2", &uvs));
    let list = json!({"type": "SCALAR", "componentType": 5125, "count": indices.len() / 4});
    let list = b.accessor(list, &indices);
    b.doc["meshes"] = json!([{"primitives": [
        {"attributes": {"POSITION": p, "NORMAL": n, "TEXCOORD_0": uv}, "indices": list}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    b.glb()
}

#[test]
fn a_million_triangles_take_well_under_a_second() {
    let file = grid(708);
    let bytes = file.len();
    let start = Instant::now();
    let (scene, _) = import_bytes(file).unwrap();
    let time = start.elapsed();
    assert_eq!(scene.triangle_count(), 2 * 708 * 708);
    println!("{} triangles, {bytes} bytes, {time:?} with validation", scene.triangle_count());
    // Measured at about 0.05 s; the bound leaves room for a busy machine and still catches anything quadratic.
    assert!(time < Duration::from_secs(1), "{time:?}");
}

#[test]
fn time_does_not_grow_with_the_square_of_the_nodes() {
    let time = |n: usize| {
        let mut b = gltf_common::Builder::new();
        let p = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": p}}]}]);
        let children: Vec<_> = (1..n).collect();
        let mut nodes = vec![json!({"children": children})];
        nodes.extend((1..n).map(|_| json!({"mesh": 0})));
        b.doc["nodes"] = json!(nodes);
        let file = b.glb();
        let start = Instant::now();
        let (scene, _) = import_bytes(file).unwrap();
        assert_eq!(scene.instances.len(), n - 1);
        start.elapsed()
    };
    let took = time(200_000);
    println!("200 000 nodes: {took:?}");
    assert!(took < Duration::from_secs(3), "{took:?}");
}
