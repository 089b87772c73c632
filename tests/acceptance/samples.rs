//! The sample folder gives the same bytes however it is rendered.

use crate::support::{code, files, kiln, stderr};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn samples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/samples")
}

/// Renders a folder and gives a hash of every picture, by name.
fn hashes(dir: &Path, input: &Path, arguments: &[&str]) -> BTreeMap<String, blake3::Hash> {
    let out = dir.join("out");
    let fixed = ["--out", "out", "--width", "24", "--height", "24", "--spp", "3", "--quiet"];
    let output = kiln(dir, &[&["batch", &input.to_string_lossy()], &fixed[..], arguments].concat());
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    let mut names = files(&out);
    names.retain(|name| name.ends_with(".png") || name.ends_with(".exr"));
    let hash = |name: &String| blake3::hash(&fs::read(out.join(name)).expect("a picture"));
    let hashes = names.iter().map(|name| (name.clone(), hash(name))).collect();
    fs::remove_dir_all(&out).expect("our own folder");
    hashes
}

#[test]
fn bytes_do_not_depend_on_threads_jobs_or_instruction_set() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let render = |arguments: &[&str]| hashes(dir.path(), &samples(), arguments);
    let one = render(&["--threads", "1", "--jobs", "1"]);
    assert!(one.len() >= 2 * 8, "PNG and EXR of at least eight samples: {:?}", one.keys());
    for arguments in [
        &["--threads", "1", "--jobs", "1"][..],
        &["--threads", "2", "--jobs", "1"],
        &["--threads", "16", "--jobs", "2"],
        &["--simd", "scalar"],
        &["--simd", "avx2"],
        &["--simd", "avx512"],
    ] {
        assert!(one == render(arguments), "{arguments:?} gives other bytes than one thread");
    }
    let seed = render(&["--seed", "5"]);
    assert!(one.iter().all(|(name, hash)| seed[name] != *hash), "another seed is another picture");
}

/// Copies assets under names that turn their order around, each into a folder of its own with the files that it
/// refers to.
#[test]
fn bytes_of_exr_files_do_not_depend_on_order_or_names() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let plain = hashes(dir.path(), &samples(), &["--format", "exr"]);
    let turned = dir.path().join("turned");
    let copy = |folder: &Path| {
        fs::create_dir_all(folder).expect("folder");
        for name in files(&samples()) {
            let to = folder.join(&name);
            fs::create_dir_all(to.parent().expect("below")).expect("folder");
            fs::copy(samples().join(&name), to).expect("copy");
        }
    };
    // Every asset once, renamed so that the last comes first, with all other files beside it.
    let inputs: Vec<&str> = plain.keys().map(|name| name.strip_suffix(".exr").expect("EXR")).collect();
    let mut renamed = BTreeMap::new();
    copy(&turned);
    for (k, input) in inputs.iter().rev().enumerate() {
        let name = format!("{k:02}_{input}");
        fs::rename(turned.join(input), turned.join(&name)).expect("rename");
        renamed.insert(format!("{name}.exr"), plain[&format!("{input}.exr")]);
    }
    let other = hashes(dir.path(), &turned, &["--format", "exr", "--threads", "2", "--jobs", "2"]);
    assert!(other == renamed, "other bytes in another order");
}
