//! `kiln batch` over folders of other people's assets: sound ones, and ones made to break importers.

use crate::common::shared;
use crate::support::{command, manifest};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SIZE: u32 = 48;
/// Far beyond what these folders take (some 15 s), so that only a hang gets there.
const PATIENCE: Duration = Duration::from_secs(600);

/// A finished batch.
struct Batch {
    out: TempDir,
    lines: Vec<Value>,
}

/// Runs a batch over a folder below `KILN_SHARED` and checks what holds of every batch: it ends in time with the code
/// for a batch done in part, without a panic; each asset has one line in the manifest; each picture is there; each
/// failure says why.
fn batch(folder: &Path, least: usize) -> Batch {
    let out = tempfile::tempdir().expect("temporary folder");
    let told = out.path().join("stderr.txt");
    let size = SIZE.to_string();
    let (input, pictures) = (folder.to_string_lossy(), out.path().join("pictures"));
    let arguments = ["batch", &input, "--out", "pictures", "--width", &size, "--height", &size];
    let mut child = command(out.path(), &arguments)
        .args(["--spp", "2", "--format", "png"])
        .stderr(File::create(&told).expect("a file"))
        .spawn()
        .expect("the program runs");
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if begin.elapsed() > PATIENCE {
            child.kill().expect("a child");
            panic!("it does not end");
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let told = fs::read_to_string(told).expect("text");
    assert_eq!(status.code(), Some(3), "{told}");
    assert!(!told.contains("panicked"), "{told}");
    let lines = manifest(&pictures);
    let inputs: Vec<&str> = lines.iter().map(|l| text(l, "input")).collect();
    let found = assets(folder);
    assert!(found.len() >= least, "only {} assets", found.len());
    assert_eq!(inputs.iter().map(|i| (*i).to_owned()).collect::<BTreeSet<_>>(), found);
    assert_eq!(inputs.len(), found.len(), "one line an asset");
    for line in &lines {
        assert_eq!(line["nonfinite"], 0, "{line}");
        assert_ne!(line["error_code"], "internal", "{line}");
        match text(line, "status") {
            "ok" | "warned" => assert!(line["error_message"].is_null() && !line["outputs"][0].is_null(), "{line}"),
            "failed" => assert!(tells_why(line), "{line}"),
            _ => panic!("neither done nor failed: {line}"),
        }
    }
    let count = |word| lines.iter().filter(|l| l["status"] == word).count();
    println!("{input}: {} ok, {} warned, {} failed", count("ok"), count("warned"), count("failed"));
    Batch { out, lines }
}

fn text<'a>(line: &'a Value, key: &str) -> &'a str {
    line[key].as_str().unwrap_or_else(|| panic!("no {key} in {line}"))
}

/// Paths of all assets below a folder, with `/`.
fn assets(folder: &Path) -> BTreeSet<String> {
    let ours = |path: &Path| {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        ["gltf", "glb", "obj", "ray"].contains(&ending.as_str())
    };
    let mut found = BTreeSet::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if ours(&path) {
                found.insert(path.strip_prefix(folder).expect("below").to_string_lossy().into_owned());
            }
        }
    }
    found
}

/// Whether a failure names a place (a JSON pointer, a line, a byte, a file), or says that there is nothing to draw.
fn tells_why(line: &Value) -> bool {
    let message = text(line, "error_message");
    let place = message.split(": ").next().unwrap_or_default();
    let numbered = place.split(':').all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()));
    let named = place.contains('/') || place.starts_with("byte ") || numbered;
    let whole = ["is JSON, but no glTF object", "has no triangle to draw", "has no faces", "none of its"];
    (named && message.len() > place.len() + 2) || whole.iter().any(|w| message.contains(w))
}

/// The colours (8 bit, straight alpha) of a picture.
fn read_png(path: &Path) -> Vec<[u8; 4]> {
    let decoder = png::Decoder::new(std::io::BufReader::new(File::open(path).expect("a picture")));
    let mut reader = decoder.read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG file");
    assert_eq!((info.width, info.height, info.color_type), (SIZE, SIZE, png::ColorType::Rgba), "{}", path.display());
    bytes.as_chunks::<4>().0.to_vec()
}

impl Batch {
    /// The pictures of an asset that is done.
    fn pictures(&self, line: &Value) -> Vec<Vec<[u8; 4]>> {
        let path = |o: &Value| -> PathBuf { self.out.path().join("pictures").join(text(o, "path")) };
        line["outputs"].as_array().expect("outputs").iter().map(|o| read_png(&path(o))).collect()
    }

    /// Assets that failed, with code and message.
    fn failed(&self) -> BTreeMap<&str, (&str, &str)> {
        let failed = self.lines.iter().filter(|l| l["status"] == "failed");
        failed.map(|l| (text(l, "input"), (text(l, "error_code"), text(l, "error_message")))).collect()
    }

    /// Asserts that each picture shows something, but for the assets named, which have a cause not to.
    fn assert_shown(&self, empty_for_a_cause: &[&str]) {
        let blank = |p: &Vec<[u8; 4]>| p.iter().all(|c| c[3] == 0 || c[..3] == [0; 3]);
        let mut found = Vec::new();
        for line in &self.lines {
            if self.pictures(line).iter().any(blank) {
                found.push(text(line, "input"));
            }
        }
        println!("black or empty: {found:?}");
        found.retain(|input| !empty_for_a_cause.contains(input));
        assert!(found.is_empty(), "black or empty pictures: {found:?}");
    }
}

/// Extensions that a sound asset may fail for, when it requires them.
const LACKING: [&str; 3] = ["FAKE_materials_quantumRendering", "KHR_materials_clearcoat", "KHR_materials_iridescence"];

#[test]
fn gltf_assets_are_shown_or_fail_by_design() {
    let Some(shared) = shared("the glTF collection") else { return };
    let batch = batch(&shared.join("assets/gltf"), 100);
    for (input, (code, message)) in batch.failed() {
        match code {
            "unsupported" => assert!(LACKING.iter().any(|e| message.ends_with(e)), "{input}: {message}"),
            "empty" => assert!(message.contains("only points or lines"), "{input}: {message}"),
            _ => panic!("{input}: {message}"),
        }
    }
    batch.assert_shown(&[
        // One triangle, seen from behind, of a single-sided material.
        "draco/one_face_123_mirror/one_face_123_mirror.gltf",
    ]);
}

#[test]
fn obj_assets_are_shown_or_have_no_face() {
    let Some(shared) = shared("the OBJ collection") else { return };
    let batch = batch(&shared.join("assets/obj"), 80);
    for (input, (code, message)) in batch.failed() {
        match code {
            // One of them lists positions on a line, to try notations of numbers.
            "empty" => assert!(message.contains("has no faces") || input.ends_with("number_formats.obj"), "{message}"),
            "invalid" => assert!(message.contains("no face is sound"), "{input}: {message}"),
            _ => panic!("{input}: {message}"),
        }
    }
    batch.assert_shown(&[
        // Fully transparent: d 0.
        "obj2gltf/box-transparent/box-transparent.obj",
        // Black materials: Kd and Ks are 0.
        "tinyobj/leading-decimal-dot-issue-201.obj",
        "tinyobj/leading-zero-in-exponent-notation-issue-210.obj",
        "tinyobj/mtllib-multiple-files-issue-112.obj",
        "tinyobj/norm-texopt.obj",
        "tinyobj/texture-options-issue-85.obj",
        "tinyobj/tr-and-d-issue-43.obj",
    ]);
}

#[test]
fn ray_scenes_are_shown_or_speak_another_dialect() {
    let Some(shared) = shared("the .ray collection") else { return };
    let batch = batch(&shared.join("scenes/ray"), 89);
    for (input, (code, message)) in batch.failed() {
        match code {
            "unsupported" => assert!(message.contains("belongs to another dialect"), "{input}: {message}"),
            _ => assert!(input.starts_with("malformed/"), "{input}: {message}"),
        }
    }
    batch.assert_shown(&[
        // The ambient term alone, which is no light.
        "ut/simple/cyl_ambient.ray",
    ]);
}

#[test]
fn malformed_assets_end_with_a_reason() {
    let Some(shared) = shared("the malformed collection") else { return };
    let batch = batch(&shared.join("assets/malformed"), 300);
    // What was read in spite of its flaws has a whole picture, be it empty.
    for line in &batch.lines {
        batch.pictures(line);
    }
    assert!(batch.failed().len() > 200);
}
