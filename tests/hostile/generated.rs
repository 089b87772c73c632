//! From a generated file to a picture: whatever it says, pixels are numbers, and soon.

use kiln::batch::plan_views;
use kiln::formats::{ImportOptions, import};
use kiln::integrate::render;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{PrepareSettings, RenderSettings, ViewSettings};
use kiln::{Control, Scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Far more than 64 pixels of 2 samples need, so that only a hang gets there.
const PATIENCE: Duration = Duration::from_secs(20);

/// A number between limits, both included and favoured.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![2 => 0f64..=1.0, 1 => prop::sample::select(vec![0.0, 1.0, 1e-9, 1e-3, 0.999_999_9])]
}

/// Any size over 24 orders of magnitude.
fn size() -> impl Strategy<Value = f64> {
    (-12f64..12.0).prop_map(|exponent| 10f64.powf(exponent))
}

fn material() -> impl Strategy<Value = Value> {
    let index = prop::sample::select(vec![0.0, 1.0, 1.000_000_1, 1.33, 1.5, 2.4, 50.0]);
    let distance = prop::sample::select(vec![1e-30, 1e-3, 1.0, 1e30]);
    let alpha = prop::sample::select(vec!["OPAQUE", "MASK", "BLEND"]);
    let emission = prop::sample::select(vec![0.0, 0.0, 0.0, 1e-6, 1.0, 1e6]);
    (
        [share(), share(), share(), share()],
        (share(), share(), share()),
        (index, distance, any::<bool>(), alpha, emission, any::<bool>()),
    )
        .prop_map(|(color, (metallic, roughness, transmission), rest)| {
            let (index, distance, solid, alpha, emission, both) = rest;
            let mut extensions = json!({
                "KHR_materials_ior": {"ior": index},
                "KHR_materials_transmission": {"transmissionFactor": transmission},
                "KHR_materials_emissive_strength": {"emissiveStrength": emission},
            });
            if solid {
                extensions["KHR_materials_volume"] = json!({"thicknessFactor": 1.0, "attenuationDistance": distance,
                    "attenuationColor": &color[..3]});
            }
            json!({
                "pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": metallic, "roughnessFactor": roughness},
                "emissiveFactor": [1, 1, 1], "doubleSided": both, "alphaMode": alpha, "extensions": extensions,
            })
        })
}

/// Rows of a transform: scales of any sign and two orders apart, shear, sometimes flat; placed within a few sizes.
fn matrix(size: f64) -> impl Strategy<Value = Vec<f64>> {
    let axis = prop_oneof![8 => 0.1f64..10.0, 4 => -10f64..-0.1, 1 => Just(0.0), 1 => Just(1e-9)];
    ([axis.clone(), axis.clone(), axis], [-1f64..1.0, -1f64..1.0, -1f64..1.0], [-3f64..3.0, -3f64..3.0, -3f64..3.0])
        .prop_map(move |(scale, shear, place)| {
            let [x, y, z] = scale.map(|s| s * size);
            let [sx, sy, sz] = shear.map(|s| s * size);
            let [px, py, pz] = place.map(|p| p * size * 4.0);
            vec![x, sx, 0.0, 0.0, 0.0, y, sy, 0.0, sz, 0.0, z, 0.0, px, py, pz, 1.0]
        })
}

fn light(size: f64) -> impl Strategy<Value = (Value, Vec<f64>)> {
    let kind = prop::sample::select(vec!["point", "spot", "directional"]);
    (kind, -6f64..6.0, [-9f64..9.0, -9f64..9.0, -9f64..9.0], any::<bool>()).prop_map(
        move |(kind, power, at, ranged)| {
            // Irradiance of about 10^power over the scene.
            let intensity = 10f64.powf(power) * if kind == "directional" { 1.0 } else { size * size };
            let mut light = json!({"type": kind, "intensity": intensity});
            if kind == "spot" {
                light["spot"] = json!({"innerConeAngle": 0.0, "outerConeAngle": 0.7});
            }
            if ranged && kind != "directional" {
                light["range"] = json!(size);
            }
            let [x, y, z] = at.map(|a| a * size);
            (light, vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, x, y, z, 1.0])
        },
    )
}

/// A glTF file of a few cubes, or shapes with wild normals, with any materials under any transforms, and lights.
fn document() -> impl Strategy<Value = Value> {
    let part = |size: f64| (matrix(size), material(), any::<bool>());
    let scene = move |size| (prop::collection::vec(part(size), 1..5), prop::collection::vec(light(size), 0..4));
    size().prop_flat_map(scene).prop_map(|(parts, lights)| {
        let positions: Vec<f32> = cube().into_iter().flatten().collect();
        let normals: Vec<f32> = positions.chunks(3).flat_map(|p| [p[1], -p[0], 0.3 * p[2] + 0.1]).collect();
        let bytes: Vec<u8> = positions.iter().chain(&normals).flat_map(|x| x.to_le_bytes()).collect();
        let (mut nodes, mut materials, mut meshes) = (vec![], vec![], vec![]);
        for (k, (matrix, material, smooth)) in parts.into_iter().enumerate() {
            let attributes = if smooth { json!({"POSITION": 0, "NORMAL": 1}) } else { json!({"POSITION": 0}) };
            meshes.push(json!({"primitives": [{"attributes": attributes, "material": k}]}));
            materials.push(material);
            nodes.push(json!({"mesh": k, "matrix": matrix}));
        }
        let shapes: Vec<&Value> = lights.iter().map(|(light, _)| light).collect();
        for (k, (_, matrix)) in lights.iter().enumerate() {
            nodes.push(json!({"matrix": matrix, "extensions": {"KHR_lights_punctual": {"light": k}}}));
        }
        let half = bytes.len() / 2;
        let accessor = |view| {
            json!({"bufferView": view, "componentType": 5126, "count": 36, "type": "VEC3",
            "min": [-1, -1, -1], "max": [1, 1, 1]})
        };
        let mut document = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
            "nodes": nodes, "meshes": meshes, "materials": materials, "accessors": [accessor(0), accessor(1)],
            "bufferViews": [{"buffer": 0, "byteLength": half}, {"buffer": 0, "byteOffset": half, "byteLength": half}],
            "buffers": [{"byteLength": bytes.len(), "uri": "cube.bin"}],
        });
        if !lights.is_empty() {
            document["extensions"] = json!({"KHR_lights_punctual": {"lights": shapes}});
        }
        document["bytes"] = json!(bytes);
        document
    })
}

/// Corners of a cube's twelve triangles.
fn cube() -> Vec<[f32; 3]> {
    let mesh = crate::common::cube(false);
    mesh.triangles.iter().flatten().map(|i| mesh.positions[*i as usize]).collect()
}

/// Writes the file and its buffer, and reads it as a scene.
fn scene_of(folder: &Path, mut document: Value) -> Scene {
    let bytes = document.as_object_mut().and_then(|d| d.remove("bytes")).expect("bytes");
    let bytes: Vec<u8> = bytes.as_array().expect("a list").iter().map(|b| b.as_u64().unwrap_or(0) as u8).collect();
    fs::write(folder.join("cube.bin"), bytes).expect("written");
    fs::write(folder.join("scene.gltf"), document.to_string()).expect("written");
    let imported = import(&folder.join("scene.gltf"), &ImportOptions::default(), &Control::default());
    imported.expect("a sound file").scene
}

fn config() -> ProptestConfig {
    ProptestConfig { cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn pictures_of_generated_files_are_numbers_and_come_soon(document in document(), world in 0u8..3, seed in any::<u64>()) {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = scene_of(folder.path(), document);
        let views = ViewSettings { width: 8, height: 8, ..ViewSettings::default() };
        let views = plan_views(&scene, &views, true);
        prop_assume!(views.is_ok());
        let world = match world {
            0 => EnvironmentSource::None,
            1 => EnvironmentSource::Constant([1.0; 3]),
            _ => EnvironmentSource::Studio,
        };
        let begin = Instant::now();
        let settings = RenderSettings { spp: 2, seed, max_depth: 12, ..RenderSettings::default() };
        let prepared = prepare(scene, &world, &PrepareSettings::default(), &Control::default()).expect("not stopped");
        let rendered = render(&prepared, &views.expect("planned")[0], &settings, &Control::default()).expect("not stopped");
        prop_assert_eq!(rendered.nonfinite, 0, "{:?}", rendered.dropped);
        prop_assert!(rendered.picture.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
        prop_assert!(begin.elapsed() < PATIENCE, "it took {:?}", begin.elapsed());
    }
}
