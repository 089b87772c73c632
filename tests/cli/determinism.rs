use crate::support::{OBJ, code, folder, gltf, kiln, stderr};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const SETTINGS: [&str; 4] = ["--width", "40", "--spp", "5"];

/// Renders the folder `input` below `dir` and gives the bytes of these pictures.
fn pictures(dir: &Path, input: &str, out: &str, arguments: &[&str], names: &[&str]) -> Vec<Vec<u8>> {
    let output = kiln(dir, &[&["batch", input, "--out", out], arguments, &SETTINGS].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    names.iter().map(|name| fs::read(dir.join(out).join(name)).expect("a picture")).collect()
}

#[test]
fn bytes_do_not_depend_on_threads_jobs_order_or_names() {
    let gltf = gltf();
    let dir = folder(&[
        ("in/a.obj", OBJ),
        ("in/m.gltf", &gltf),
        ("in/z.obj", &OBJ.replace("0.5", "0.7")),
        // The same three under other names, so that they come in another order.
        ("turned/z.obj", OBJ),
        ("turned/b.gltf", &gltf),
        ("turned/a.obj", &OBJ.replace("0.5", "0.7")),
    ]);
    let names = ["a.obj.exr", "m.gltf.exr", "z.obj.exr", "a.obj.png", "m.gltf.png", "z.obj.png"];
    let one = pictures(dir.path(), "in", "one", &["--threads", "1", "--jobs", "1"], &names);
    assert_eq!(one.iter().collect::<BTreeSet<_>>().len(), names.len(), "six different pictures");
    for (threads, jobs) in [("2", "2"), ("16", "3"), ("16", "1")] {
        let out = format!("out-{threads}-{jobs}");
        let other = pictures(dir.path(), "in", &out, &["--threads", threads, "--jobs", jobs], &names);
        assert!(one == other, "{threads} threads and {jobs} jobs give other bytes than one");
    }
    let turned = pictures(dir.path(), "turned", "out-turned", &[], &["z.obj.exr", "b.gltf.exr", "a.obj.exr"]);
    assert!(one[..3] == turned, "the EXR files do not know names");
}

#[test]
fn seeds_and_auto_exposure_repeat() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let run = |out: &str, arguments: &[&str]| pictures(dir.path(), "in", out, arguments, &["a.obj.png", "a.obj.exr"]);
    let auto = ["--exposure", "auto", "--seed", "3"];
    let first = run("1", &auto);
    assert_eq!(first, run("2", &[&auto[..], &["--threads", "1"]].concat()));
    assert_ne!(first[1], run("3", &["--exposure", "auto", "--seed", "4"])[1]);
}
