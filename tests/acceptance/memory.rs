//! A mesh of a million triangles keeps to its share of memory.

use crate::support::{code, kiln, stderr};
use serde_json::{Value, json};
use std::path::Path;

/// Cells along the two sides of the terrain: 2 · 1024 · 512 triangles.
const CELLS: [usize; 2] = [1024, 512];

/// Hash of a lattice point, in [0, 1].
fn lattice(x: i64, z: i64) -> f64 {
    let mut h = (x as u32).wrapping_mul(374_761_393).wrapping_add((z as u32).wrapping_mul(668_265_263));
    h = (h ^ (h >> 13)).wrapping_mul(1_274_126_177);
    f64::from(h ^ (h >> 16)) / f64::from(u32::MAX)
}

fn noise(x: f64, z: f64) -> f64 {
    let (i, k) = (x.floor() as i64, z.floor() as i64);
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (smooth(x - x.floor()), smooth(z - z.floor()));
    let row = |k| lattice(i, k) * (1.0 - u) + lattice(i + 1, k) * u;
    row(k) * (1.0 - v) + row(k + 1) * v
}

/// Writes a rugged indexed terrain as binary glTF; gives its triangles.
fn write_terrain(path: &Path) -> u64 {
    let [columns, rows] = CELLS;
    let mut binary = Vec::new();
    for i in 0..=columns {
        for k in 0..=rows {
            let (x, z) = (20.0 * i as f64 / columns as f64 - 10.0, 10.0 * k as f64 / rows as f64 - 5.0);
            let octave = |o: i32| 1.2 * 0.5f64.powi(o) * noise(0.35 * x * 2f64.powi(o), 0.35 * z * 2f64.powi(o) + 17.3);
            let y: f64 = (0..8).map(octave).sum();
            binary.extend([x, y, z].iter().flat_map(|c| (*c as f32).to_le_bytes()));
        }
    }
    let vertices = (columns + 1) * (rows + 1);
    for i in 0..columns {
        for k in 0..rows {
            let a = i * (rows + 1) + k;
            let (b, c, d) = (a + 1, a + rows + 2, a + rows + 1);
            binary.extend([a, b, c, a, c, d].iter().flat_map(|v| (*v as u32).to_le_bytes()));
        }
    }
    let (start, end) = (12 * vertices, binary.len());
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3",
             "min": [-10, -1, -5], "max": [10, 3, 5]},
            {"bufferView": 1, "componentType": 5125, "count": (end - start) / 4, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": start}, {"buffer": 0, "byteOffset": start, "byteLength": end - start},
        ],
        "buffers": [{"byteLength": end}],
    });
    let mut text = document.to_string();
    text.push_str(&" ".repeat(text.len().next_multiple_of(4) - text.len()));
    let mut file = b"glTF".to_vec();
    let word = |file: &mut Vec<u8>, n: usize| file.extend((n as u32).to_le_bytes());
    word(&mut file, 2);
    word(&mut file, 12 + 8 + text.len() + 8 + binary.len());
    word(&mut file, text.len());
    file.extend(b"JSON");
    file.extend(text.as_bytes());
    word(&mut file, binary.len());
    file.extend(b"BIN\0");
    file.extend(binary);
    std::fs::write(path, file).expect("write");
    (end - start) as u64 / 12
}

#[test]
fn a_million_triangles_take_less_than_400_bytes_each() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let triangles = write_terrain(&dir.path().join("terrain.glb"));
    let size = ["--width", "256", "--height", "256", "--spp", "16", "--threads", "2"];
    let output = kiln(dir.path(), &[&["render", "terrain.glb", "--json", "--quiet"], &size[..]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let line: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(line["scene"]["triangles"], triangles);
    for stage in ["import", "kdtree", "render"] {
        assert!(line["seconds"][stage].as_f64().is_some_and(|s| s > 0.001), "{stage}: {}", line["seconds"]);
    }
    let peak = line["peak_bytes"].as_u64().expect("Linux tells");
    let each = peak as f64 / triangles as f64;
    println!("{triangles} triangles, {each:.0} bytes each at peak, {}", line["seconds"]);
    assert!(each < 400.0, "{each:.0} bytes a triangle");
}
