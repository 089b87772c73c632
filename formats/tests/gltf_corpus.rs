//! Runs the importer over folders of sound and of malformed files, which are not part of the repository.
//! `KILN_SHARED` names the place that holds them; without it these tests say so and do nothing, unless
//! `KILN_REQUIRE_SHARED` is set.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod shared;

use kiln_formats::{Control, ErrorCode, ImportError, ImportOptions, Imported, Place, import};
use shared::shared;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// All .gltf and .glb files below a folder, sorted.
fn assets(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
            if path.is_dir() {
                folders.push(path);
            } else if ending == "gltf" || ending == "glb" {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no assets below {}", folder.display());
    found
}

fn timed(path: &Path) -> (Result<Imported, ImportError>, Duration) {
    let start = Instant::now();
    (import(path, &ImportOptions::default(), &Control::default()), start.elapsed())
}

/// Why a sound asset may fail: a required extension that is not read yet, or nothing but points and lines.
fn fails_by_design(error: &ImportError) -> bool {
    const LACKING: [&str; 3] =
        ["KHR_materials_clearcoat", "KHR_materials_iridescence", "FAKE_materials_quantumRendering"];
    match error.code {
        ErrorCode::Unsupported => LACKING.iter().any(|name| error.message.contains(name)),
        ErrorCode::Empty => true,
        _ => false,
    }
}

#[test]
fn sound_assets_import() {
    let Some(folder) = shared("assets/gltf") else { return };
    let bench = shared("scenes/bench").map(|f| assets(&f)).unwrap_or_default();
    let mut bad = Vec::new();
    for path in assets(&folder).into_iter().chain(bench) {
        let (result, time) = timed(&path);
        let name = path.display();
        match &result {
            Ok(i) => {
                println!(
                    "{name}: {} triangles, {} instances, {time:?}",
                    i.scene.triangle_count(),
                    i.scene.instances.len()
                );
                i.warnings.iter().for_each(|w| println!("    {} {}: {}", w.code, w.place, w.message));
            }
            Err(error) => println!("{name}: {} {error}", error.code.as_str()),
        }
        if result.is_err_and(|e| !fails_by_design(&e)) || time > Duration::from_secs(5) {
            bad.push(path);
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

/// The corners of the box around everything, and the area of all triangles, in world space.
fn extent(scene: &kiln_formats::Scene) -> [f64; 7] {
    let (mut low, mut high, mut area) = (glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY, 0.0);
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let at = |i: u32| instance.transform.transform_point3(mesh.positions[i as usize].map(f64::from).into());
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(at)) {
            low = low.min(a).min(b).min(c);
            high = high.max(a).max(b).max(c);
            area += (b - a).cross(c - a).length() / 2.0;
        }
    }
    [low.x, low.y, low.z, high.x, high.y, high.z, area]
}

#[test]
fn compressed_models_are_where_their_uncompressed_twins_are() {
    let Some(folder) = shared("assets/gltf") else { return };
    for (compressed, plain) in [
        ("cesium-native/CesiumMilkTruck/CesiumMilkTruck.gltf", "khronos/CesiumMilkTruck.glb"),
        ("cesium-native/Duck-vp-12-vt-12-vn-12.glb", "khronos/Duck/glTF-Quantized/Duck.gltf"),
    ] {
        let read = |path| timed(&folder.join(path)).0.unwrap().scene;
        let (got, want) = (read(compressed), read(plain));
        assert_eq!(got.triangle_count(), want.triangle_count(), "{compressed}");
        let (got, want) = (extent(&got), extent(&want));
        println!("{compressed}: {got:?}, {want:?}");
        let size = want[3] - want[0];
        for (got, want) in got.iter().zip(&want) {
            assert!((got - want).abs() < 0.005 * size.max(want.abs()), "{got} for {want} in {compressed}");
        }
    }
}

/// Codes of the Khronos validator for flaws that leave nothing sure to read, in a file's structure or ranges.
const UNREADABLE: [&str; 14] = [
    "ACCESSOR_SMALL_BYTESTRIDE",
    "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
    "ACCESSOR_TOO_LONG",
    "BUFFER_BYTE_LENGTH_MISMATCH",
    "BUFFER_VIEW_TOO_LONG",
    "GLB_CHUNK_TOO_BIG",
    "GLB_INVALID_MAGIC",
    "GLB_LENGTH_MISMATCH",
    "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
    "GLB_UNEXPECTED_END_OF_CHUNK_HEADER",
    "GLB_UNEXPECTED_END_OF_HEADER",
    "NODE_LOOP",
    "NODE_PARENT_OVERRIDE",
    "UNKNOWN_ASSET_MAJOR_VERSION",
];

#[test]
fn what_the_validator_calls_unreadable_is_an_error_at_a_place() {
    let Some(folder) = shared("assets/malformed") else { return };
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.tsv")).unwrap();
    let mut seen = 0;
    for row in manifest.lines() {
        let columns: Vec<&str> = row.split('\t').collect();
        let [path, _, _, _, _, codes] = columns[..] else { continue };
        if !codes.split(',').any(|code| UNREADABLE.contains(&code)) {
            continue;
        }
        seen += 1;
        match timed(&folder.join(path)).0 {
            Err(e) => assert!(e.code != ErrorCode::Empty && e.place != Place::File, "{path}: {e} for {codes}"),
            Ok(_) => panic!("{path} was read in spite of {codes}"),
        }
    }
    assert!(seen > 15, "{seen} rows");
}

#[test]
fn malformed_assets_end_in_time_and_name_the_place() {
    let Some(folder) = shared("assets/malformed") else { return };
    let mut bad = Vec::new();
    for path in assets(&folder) {
        let (result, time) = timed(&path);
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        let sound = match &result {
            Ok(i) => {
                println!("{name}: ok, {} triangles", i.scene.triangle_count());
                i.warnings.iter().for_each(|w| println!("    {} {}: {}", w.code, w.place, w.message));
                true
            }
            Err(e) => {
                println!("{name}: {} {e}", e.code.as_str());
                match e.code {
                    ErrorCode::Internal => false,
                    ErrorCode::Empty => true,
                    _ => e.place != Place::File,
                }
            }
        };
        if !sound || time > Duration::from_secs(5) {
            bad.push(name);
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}
