//! Compressed geometry, compressed textures and instanced nodes, from streams encoded here.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod gltf_common;

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, MeshEncoder, PointAttribute, PointIndex,
};
use glam::DVec3;
use gltf_common::{Builder, import_json, triangle, warned};
use kiln_formats::scene::Pixels;
use kiln_formats::{ErrorCode, Limits, Place};
use serde_json::{Value, json};

const SIDE: u32 = 12;

/// Positions and triangles of a wavy grid.
fn grid() -> (Vec<[f32; 3]>, Vec<u32>) {
    let vertices = (0..=SIDE).flat_map(|y| (0..=SIDE).map(move |x| (x as f32, y as f32)));
    let positions = vertices.map(|(x, y)| [x * 0.25, y * 0.25, libm::sinf(x + 0.3 * y)]).collect();
    let quads = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| y * (SIDE + 1) + x));
    let indices = quads.flat_map(|a| [a, a + 1, a + SIDE + 2, a, a + SIDE + 2, a + SIDE + 1]).collect();
    (positions, indices)
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

    /// A copy with a few bytes changed, and every fourth time cut short.
    fn damage(&mut self, sound: &[u8]) -> Vec<u8> {
        let mut bytes = sound.to_vec();
        for _ in 0..1 + self.below(4) {
            let at = self.below(bytes.len());
            bytes[at] = [self.below(256) as u8, 0, 0x7f, 0xff][self.below(4)];
        }
        if self.below(4) == 0 {
            bytes.truncate(self.below(bytes.len()));
        }
        bytes
    }
}

struct Stream<'a> {
    bytes: &'a [u8],
    count: usize,
    stride: usize,
    mode: &'a str,
    filter: &'a str,
}

/// A document of one primitive whose positions, normals and indices are compressed views of a buffer without data.
fn meshopt_document(name: &str, positions: &Stream, normals: Option<&Stream>, indices: &Stream) -> Value {
    let mut b = Builder::new();
    let mut offset = 0;
    let mut view = |b: &mut Builder, s: &Stream| {
        let source = b.view(s.bytes);
        let at = b.doc["bufferViews"][source]["byteOffset"].clone();
        let stated = s.count * s.stride;
        b.doc["bufferViews"][source] = json!({"buffer": 1, "byteOffset": offset, "byteLength": stated, "extensions": {
            name: {"buffer": 0, "byteOffset": at, "byteLength": s.bytes.len(), "byteStride": s.stride,
                "count": s.count, "mode": s.mode, "filter": s.filter}}});
        if s.mode == "ATTRIBUTES" {
            b.doc["bufferViews"][source]["byteStride"] = json!(s.stride);
        }
        offset += stated;
        source
    };
    let (p, i) = (view(&mut b, positions), view(&mut b, indices));
    let n = normals.map(|n| view(&mut b, n));
    let p = b.raw(json!({"bufferView": p, "type": "VEC3", "componentType": 5126, "count": positions.count}));
    let i = b.raw(json!({"bufferView": i, "type": "SCALAR", "componentType": 5125, "count": indices.count}));
    let mut attributes = json!({"POSITION": p});
    if let (Some(n), Some(stream)) = (n, normals) {
        let accessor = json!({"bufferView": n, "type": "VEC3", "componentType": 5120, "normalized": true,
            "count": stream.count});
        attributes["NORMAL"] = json!(b.raw(accessor));
    }
    b.doc["extensionsRequired"] = json!([name]);
    b.doc["meshes"] = json!([{"primitives": [{"attributes": attributes, "indices": i}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    b.finish();
    let placeholder = json!({"byteLength": offset, "extensions": {name: {"fallback": true}}});
    b.doc["buffers"].as_array_mut().unwrap().push(placeholder);
    b.doc
}

#[test]
fn meshopt_streams_give_what_was_encoded() {
    let (positions, indices) = grid();
    let encoded = meshopt::encode_vertex_buffer(&positions).unwrap();
    let corners = meshopt::encode_index_buffer(&indices, positions.len()).unwrap();
    let sequence = meshopt::encode_index_sequence(&indices, positions.len()).unwrap();
    let slanted = [0.6, 0.0, 0.8, 0.0];
    let octahedral: Vec<[i8; 4]> = meshopt::encode_filter_oct(&vec![slanted; positions.len()], 8);
    let normals = meshopt::encode_vertex_buffer(&octahedral).unwrap();
    let exponents = meshopt::encode_filter_exp(&positions, 15, meshopt::EncodeExpMode::Separate);
    let exponential = meshopt::encode_vertex_buffer(&exponents).unwrap();
    let n = Stream { bytes: &normals, count: positions.len(), stride: 4, mode: "ATTRIBUTES", filter: "OCTAHEDRAL" };
    let plain = Stream { bytes: &encoded, count: positions.len(), stride: 12, mode: "ATTRIBUTES", filter: "NONE" };
    let filtered = Stream { bytes: &exponential, filter: "EXPONENTIAL", ..plain };
    let list = Stream { bytes: &corners, count: indices.len(), stride: 4, mode: "TRIANGLES", filter: "NONE" };
    let row = Stream { bytes: &sequence, mode: "INDICES", ..list };
    for (name, p, i, error) in [
        ("EXT_meshopt_compression", &plain, &list, 0.0),
        ("KHR_meshopt_compression", &plain, &row, 0.0),
        ("KHR_meshopt_compression", &filtered, &row, 1e-3),
    ] {
        let (scene, warnings) = import_json(&meshopt_document(name, p, Some(&n), i)).unwrap();
        assert_eq!(warnings, []);
        let mesh = &scene.meshes[0];
        assert_eq!(mesh.triangles.len(), indices.len() / 3);
        // Triangles may be turned about their corners; which corner is which vertex stays.
        for (got, want) in mesh.triangles.iter().zip(indices.chunks(3)) {
            let [mut got, mut want] = [*got, [want[0], want[1], want[2]]];
            got.sort_unstable();
            want.sort_unstable();
            assert_eq!(got, want);
        }
        for (got, want) in mesh.positions.as_flattened().iter().zip(positions.as_flattened()) {
            assert!((got - want).abs() <= error, "{got} for {want}");
        }
        for normal in &mesh.normals {
            assert!(normal.iter().zip(slanted).all(|(a, b)| (a - b).abs() < 0.02), "{normal:?}");
        }
    }
}

#[test]
fn meshopt_claims_that_nothing_bears_out_are_refused_at_once() {
    let (positions, indices) = grid();
    let encoded = meshopt::encode_vertex_buffer(&positions).unwrap();
    let corners = meshopt::encode_index_buffer(&indices, positions.len()).unwrap();
    let p = Stream { bytes: &encoded, count: positions.len(), stride: 12, mode: "ATTRIBUTES", filter: "NONE" };
    let i = Stream { bytes: &corners, count: indices.len(), stride: 4, mode: "TRIANGLES", filter: "NONE" };
    let refuse = |p: &Stream, i: &Stream| {
        let error = import_json(&meshopt_document("EXT_meshopt_compression", p, None, i)).unwrap_err();
        let Place::Json(pointer) = &error.place else { panic!("{error}") };
        assert!(pointer.ends_with("/extensions/EXT_meshopt_compression"), "{error}");
        error.code
    };
    assert_eq!(refuse(&Stream { count: 300_000_000, ..p }, &i), ErrorCode::TooLarge);
    assert_eq!(refuse(&p, &Stream { count: 30_000_000, ..i }), ErrorCode::Invalid);
    assert_eq!(refuse(&Stream { stride: 6, ..p }, &i), ErrorCode::Invalid);
    assert_eq!(refuse(&Stream { stride: 260, ..p }, &i), ErrorCode::Invalid);
    assert_eq!(refuse(&Stream { filter: "QUATERNION", ..p }, &i), ErrorCode::Invalid);
    assert_eq!(refuse(&p, &Stream { count: indices.len() + 1, ..i }), ErrorCode::Invalid);
    assert_eq!(refuse(&p, &Stream { mode: "STRIPES", ..i }), ErrorCode::Invalid);
    assert_eq!(refuse(&Stream { bytes: &encoded[..40], ..p }, &i), ErrorCode::Invalid);
}

fn draco_stream() -> Vec<u8> {
    let (positions, indices) = grid();
    let attribute = |kind, components: u8, values: &[f32]| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, values.len() / usize::from(components));
        attribute.buffer_mut().write(0, &Builder::bytes(values));
        attribute
    };
    let uvs: Vec<f32> = positions.iter().flat_map(|[x, y, _]| [*x, *y]).collect();
    let mut mesh = draco_core::Mesh::new();
    mesh.add_attribute(attribute(GeometryAttributeType::Position, 3, positions.as_flattened()));
    mesh.add_attribute(attribute(GeometryAttributeType::TexCoord, 2, &uvs));
    mesh.set_num_faces(indices.len() / 3);
    for (f, corners) in indices.chunks(3).enumerate() {
        mesh.set_face(FaceIndex(f as u32), [corners[0], corners[1], corners[2]].map(PointIndex));
    }
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut out = EncoderBuffer::new();
    encoder.encode(&EncoderOptions::new(), &mut out).unwrap();
    out.data().to_vec()
}

fn draco_document(stream: &[u8]) -> Builder {
    let (positions, indices) = grid();
    let mut b = Builder::new();
    let view = b.view(stream);
    let p = b.raw(json!({"type": "VEC3", "componentType": 5126, "count": positions.len()}));
    let uv = b.raw(json!({"type": "VEC2", "componentType": 5126, "count": positions.len()}));
    let i = b.raw(json!({"type": "SCALAR", "componentType": 5125, "count": indices.len()}));
    b.doc["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    b.doc["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": p, "TEXCOORD_0": uv}, "indices": i,
        "extensions": {"KHR_draco_mesh_compression":
            {"bufferView": view, "attributes": {"POSITION": 0, "TEXCOORD_0": 1}}}}]}]);
    b.doc["nodes"] = json!([{"mesh": 0}]);
    b
}

#[test]
fn draco_streams_give_what_was_encoded() {
    let (scene, warnings) = draco_document(&draco_stream()).import().unwrap();
    assert_eq!(warnings, []);
    let mesh = &scene.meshes[0];
    let (positions, indices) = grid();
    let centres = |positions: &[[f32; 3]], corners: &[u32]| {
        let centre = |t: &[u32]| t.iter().map(|i| DVec3::from(positions[*i as usize].map(f64::from))).sum::<DVec3>();
        let mut centres: Vec<DVec3> = corners.chunks(3).map(centre).collect();
        // The encoder orders triangles anew; x and y are distinct and quantised far finer than their spacing.
        centres.sort_by_key(|c| ((c.x * 10.0).round() as i64, (c.y * 10.0).round() as i64));
        centres
    };
    let got = centres(&mesh.positions, mesh.triangles.as_flattened());
    let want = centres(&positions, &indices);
    assert_eq!(got.len(), want.len());
    assert!(got.iter().zip(&want).all(|(a, b)| a.distance(*b) < 0.01));
    assert_eq!(mesh.uvs[0].len(), mesh.positions.len());
    for (uv, p) in mesh.uvs[0].iter().zip(&mesh.positions) {
        assert!((uv[0] - p[0]).abs() < 0.01 && (uv[1] - p[1]).abs() < 0.01, "{uv:?} at {p:?}");
    }
}

#[test]
fn draco_flaws_name_their_place_and_limits_hold() {
    let stream = draco_stream();
    let limits = Limits { max_triangles: 100, ..Limits::default() };
    assert_eq!(draco_document(&stream).import_with(limits).unwrap_err().code, ErrorCode::TooLarge);
    let mut b = draco_document(&stream);
    const EXTENSION: &str = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    *b.doc.pointer_mut(&format!("{EXTENSION}/attributes/POSITION")).unwrap() = json!(7);
    let error = b.import().unwrap_err();
    assert_eq!(
        (error.code, error.place),
        (ErrorCode::Invalid, Place::Json(format!("{EXTENSION}/attributes/POSITION")))
    );
    let error = draco_document(b"DRACO and no more").import().unwrap_err();
    assert_eq!((error.code, error.place), (ErrorCode::Invalid, Place::Json(EXTENSION.into())));
    // A fallback takes the place of a broken stream.
    let mut b = draco_document(b"DRACO and no more");
    let (positions, indices) = grid();
    let list: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    let (p, i) = (b.view(&Builder::bytes(positions.as_flattened())), b.view(&list));
    (b.doc["accessors"][0]["bufferView"], b.doc["accessors"][2]["bufferView"]) = (json!(p), json!(i));
    b.doc["accessors"][1] = b.doc["accessors"][0].clone();
    b.doc["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    let (scene, warnings) = b.import().unwrap();
    assert!(warned(&warnings, "fallback-used") && scene.meshes[0].positions == positions);
}

/// A KTX2 file of one level of UASTC blocks, each of one colour, stored or in a Zstandard frame.
fn ktx2(width: u32, height: u32, colors: &[[u8; 4]], zstd: bool) -> Vec<u8> {
    let block = |[r, g, b, a]: [u8; 4]| {
        // Mode 8, one colour: the code 10111 and four bytes, from the lowest bit on.
        let bits = 0x17 | (u128::from(u32::from_le_bytes([r, g, b, a])) << 5);
        bits.to_le_bytes()
    };
    let blocks: Vec<u8> = colors.iter().flat_map(|c| block(*c)).collect();
    let mut data = blocks.clone();
    if zstd {
        // RFC 8878: magic number, single segment with a content size of one byte, one raw block that is the last.
        data = vec![0x28, 0xb5, 0x2f, 0xfd, 0x20, blocks.len() as u8];
        data.extend(&((blocks.len() as u32) << 3 | 1).to_le_bytes()[..3]);
        data.extend(&blocks);
    }
    let (dfd, level) = (80 + 24, 80 + 24 + 44);
    let mut file = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    let words = [0, 1, width, height, 0, 0, 1, 1, if zstd { 2 } else { 0 }, dfd, 44, 0, 0, 0, 0, 0, 0];
    file.extend(words.iter().flat_map(|w: &u32| w.to_le_bytes()));
    for long in [level as u64, data.len() as u64, blocks.len() as u64] {
        file.extend(long.to_le_bytes());
    }
    // Khronos Data Format 1.3: total size, block header (version 2, 40 bytes), UASTC (166) in BT.709 and sRGB,
    // 4 × 4 texels in 16 bytes, one RGBA sample of 128 bits.
    let descriptor = [44, 0, 2 | 40 << 16, 166 | 1 << 8 | 2 << 16, 0x0303, 16, 0, 127 << 16 | 3 << 24, 0, 0, u32::MAX];
    file.extend(descriptor.iter().flat_map(|w: &u32| w.to_le_bytes()));
    file.extend(&data);
    file
}

fn textured(image: &[u8]) -> Builder {
    let mut b = triangle();
    let uvs = b.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let image = b.view(image);
    b.doc["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    b.doc["images"] = json!([{"bufferView": image, "mimeType": "image/ktx2"}]);
    b.doc["textures"] = json!([{"extensions": {"KHR_texture_basisu": {"source": 0}}}]);
    b.doc["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    b.doc["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    b
}

#[test]
fn basis_textures_give_their_texels() {
    let (red, blue) = ([250, 10, 20, 255], [5, 15, 240, 128]);
    for zstd in [false, true] {
        // The second block lies half outside.
        let (scene, warnings) = textured(&ktx2(6, 4, &[red, blue], zstd)).import().unwrap();
        assert_eq!(warnings, [], "{zstd}");
        let image = &scene.images[0];
        let Pixels::Rgba8(pixels) = &image.pixels else { panic!("{image:?}") };
        assert_eq!((image.width, image.height), (6, 4));
        let row: Vec<u8> = [red, red, red, red, blue, blue].concat();
        assert_eq!(*pixels, row.repeat(4));
    }
}

#[test]
fn other_textures_in_that_container_are_named_by_their_format() {
    let mut plain = ktx2(4, 4, &[[1; 4]], false);
    plain[12..16].copy_from_slice(&37u32.to_le_bytes());
    plain[116] = 1;
    let (scene, warnings) = textured(&plain).import().unwrap();
    assert!(scene.images.is_empty());
    assert_eq!(warnings[0].code, "unsupported-texture");
    assert!(warnings[0].message.contains("R8G8B8A8_UNORM"), "{warnings:?}");
}

#[test]
fn basis_textures_that_claim_too_much_are_left_out_or_refused() {
    let mut claim = ktx2(4, 4, &[[1; 4]], true);
    claim[20..24].copy_from_slice(&60_000u32.to_le_bytes());
    claim[24..28].copy_from_slice(&10_000u32.to_le_bytes());
    let (scene, warnings) = textured(&claim).import().unwrap();
    assert!(warned(&warnings, "broken-texture") && scene.images.is_empty(), "{warnings:?}");
    claim[24..28].copy_from_slice(&60_000u32.to_le_bytes());
    assert_eq!(textured(&claim).import().unwrap_err().code, ErrorCode::TooLarge);
    // 4 GiB of blocks by the level's own account.
    let mut claim = ktx2(4, 4, &[[1; 4]], true);
    claim[96..104].copy_from_slice(&(4u64 << 30).to_le_bytes());
    assert!(warned(&textured(&claim).import().unwrap().1, "broken-texture"));
}

#[test]
fn damaged_streams_end_in_a_scene_or_an_error() {
    let (positions, indices) = grid();
    let encoded = meshopt::encode_vertex_buffer(&positions).unwrap();
    let corners = meshopt::encode_index_buffer(&indices, positions.len()).unwrap();
    let (stream, texture) = (draco_stream(), ktx2(6, 4, &[[9; 4], [200; 4]], true));
    let mut random = Random(0x6b69_6c6e);
    let mut refused = [0; 3];
    for _ in 0..1500 {
        let (p, i) = (random.damage(&encoded), random.damage(&corners));
        let p = Stream { bytes: &p, count: positions.len(), stride: 12, mode: "ATTRIBUTES", filter: "NONE" };
        let i = Stream { bytes: &i, count: indices.len(), stride: 4, mode: "TRIANGLES", filter: "NONE" };
        let results = [
            import_json(&meshopt_document("EXT_meshopt_compression", &p, None, &i)),
            draco_document(&random.damage(&stream)).import(),
            textured(&random.damage(&texture)).import(),
        ];
        for (result, refused) in results.iter().zip(&mut refused) {
            match result {
                Err(error) => {
                    assert!(error.code != ErrorCode::Internal && error.place != Place::File, "{error}");
                    *refused += 1;
                }
                Ok((_, warnings)) => *refused += usize::from(warned(warnings, "broken-texture")),
            }
        }
    }
    println!("refused: {refused:?}");
    assert!(refused.iter().all(|n| (100..1500).contains(n)), "{refused:?}");
}

#[test]
fn instances_multiply_a_node() {
    let mut b = triangle();
    let t = b.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    // A quarter turn about z, as normalised 16-bit integers, for all.
    let quarter: Vec<u8> = [0i16, 0, 23170, 23170].repeat(3).iter().flat_map(|x| x.to_le_bytes()).collect();
    let r = b.accessor(json!({"type": "VEC4", "componentType": 5122, "normalized": true, "count": 3}), &quarter);
    let s = b.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
    let attributes = json!({"TRANSLATION": t, "ROTATION": r, "SCALE": s});
    b.doc["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    b.doc["nodes"][0] = json!({"mesh": 0, "translation": [0, 5, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}});
    let (scene, warnings) = b.import().unwrap();
    assert_eq!((warnings.len(), scene.meshes.len(), scene.instances.len()), (0, 1, 3));
    for (k, instance) in scene.instances.iter().enumerate() {
        // Scaled, then turned, then moved, then by the node.
        let got = instance.transform.transform_point3(DVec3::X);
        let want = DVec3::new(k as f64, 5.0 + (k + 1) as f64, 0.0);
        assert!(got.distance(want) < 1e-9, "{got} for {want}");
    }
    let limits = Limits { max_triangles: 2, ..Limits::default() };
    assert_eq!(b.import_with(limits).unwrap_err().code, ErrorCode::TooLarge);
    b.doc["accessors"][s]["count"] = json!(2);
    let error = b.import().unwrap_err();
    let place = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE";
    assert_eq!((error.code, error.place), (ErrorCode::Invalid, Place::Json(place.into())));
}
