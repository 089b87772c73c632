use crate::support::{OBJ, code, command, files, folder, gltf, kiln, manifest, statuses, stderr};
use serde_json::Value;
use std::fs;

const SMALL: [&str; 4] = ["--width", "16", "--spp", "1"];

fn batch(folder: &std::path::Path, arguments: &[&str]) -> std::process::Output {
    kiln(folder, &[&["batch"], arguments, &SMALL].concat())
}

#[test]
fn a_broken_file_among_good_ones_costs_itself_alone() {
    let gltf = gltf();
    let dir = folder(&[
        ("in/b/square.obj", OBJ),
        ("in/a.gltf", &gltf),
        ("in/C.GLTF", "{ no json"),
        ("in/d.obj", "f 1 2 3\n"),
        ("in/readme.txt", "no asset"),
    ]);
    let output = batch(dir.path(), &["in", "--out", "out"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    let want = [("C.GLTF", "failed"), ("a.gltf", "ok"), ("b/square.obj", "ok"), ("d.obj", "failed")];
    assert_eq!(statuses(&lines), want);
    let want = ["a.gltf.exr", "a.gltf.png", "b/square.obj.exr", "b/square.obj.png", "index.html", "manifest.jsonl"];
    assert_eq!(files(&dir.path().join("out")), want);
    for line in lines.iter().filter(|l| l["status"] == "failed") {
        assert!(line["error_message"].as_str().is_some_and(|m| !m.is_empty()), "{line}");
        assert_eq!(line["outputs"], Value::Array(Vec::new()));
    }
    let said = stderr(&output);
    assert!(said.contains("4 assets") && said.contains("2 failed") && said.contains("failed: C.GLTF"), "{said}");
}

#[test]
fn manifest_lines_say_what_was_done() {
    let dir = folder(&[("in/square.obj", OBJ)]);
    let output = batch(dir.path(), &["in", "--out", "out", "--seed", "7"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let line = &manifest(&dir.path().join("out"))[0];
    assert_eq!((line["kiln"].as_str(), line["seed"].as_u64()), (Some(env!("CARGO_PKG_VERSION")), Some(7)));
    for hash in ["content", "settings"] {
        let text = line[hash].as_str().expect("a hash");
        assert!(text.starts_with("blake3:") && text.len() == 7 + 64, "{text}");
    }
    assert_eq!(line["light"], "studio");
    assert_eq!(line["scene"]["triangles"], 3);
    assert_eq!(line["scene"]["instances"], 1);
    let outputs = line["outputs"].as_array().expect("outputs");
    let paths: Vec<_> = outputs.iter().map(|o| o["path"].as_str().expect("path")).collect();
    assert_eq!(paths, ["square.obj.png", "square.obj.exr"]);
    for output in outputs {
        assert_eq!((output["width"].as_u64(), output["height"].as_u64()), (Some(16), Some(16)));
        assert_eq!((output["spp"].as_u64(), output["samples"].as_u64()), (Some(1), Some(256)));
        // What is not measured is null, never a number.
        for unmeasured in ["error", "error_bound", "relmse", "target_met"] {
            assert_eq!(output[unmeasured], Value::Null);
        }
    }
    for stage in ["import", "prepare", "kdtree", "render", "write", "total"] {
        for times in ["seconds", "cpu_seconds"] {
            assert!(line[times][stage].as_f64().is_some_and(|s| (0.0..60.0).contains(&s)), "{times} {stage}: {line}");
        }
    }
    let sum: f64 =
        ["import", "prepare", "kdtree", "render", "write"].map(|s| line["seconds"][s].as_f64().unwrap()).iter().sum();
    assert!(sum <= line["seconds"]["total"].as_f64().unwrap() + 1e-9, "stages overlap: {line}");
    assert!(line["rays"]["camera"].as_u64().is_some_and(|n| n >= 256));
}

#[test]
fn nothing_to_do_is_a_failure_that_says_so() {
    let dir = folder(&[("in/readme.txt", "no asset")]);
    let output = batch(dir.path(), &["in", "--out", "out"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("no .gltf, .glb, .obj or .ray file below in"), "{}", stderr(&output));
    assert!(!dir.path().join("out").exists());
    let output = batch(dir.path(), &["nowhere", "--out", "out"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("nowhere cannot be searched"), "{}", stderr(&output));
}

#[test]
fn when_everything_fails_the_code_is_1() {
    let dir = folder(&[("in/a.obj", "f 1 2 3\n"), ("in/b.glb", "no glb")]);
    let output = batch(dir.path(), &["in", "--out", "out"]);
    assert_eq!(code(&output), 1);
    assert_eq!(files(&dir.path().join("out")), ["index.html", "manifest.jsonl"]);
}

#[test]
fn a_folder_that_cannot_be_searched_makes_it_a_part() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let output = batch(dir.path(), &["in", "nowhere", "--out", "out"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    assert_eq!(statuses(&manifest(&dir.path().join("out"))), [("in/a.obj", "ok")]);
}

#[test]
fn wrong_usage_is_code_2_and_explained() {
    let dir = folder(&[("in/a.obj", OBJ), ("view.json", "{}")]);
    let cases: [(&[&str], &str); 6] = [
        (&["in"], "--out"),
        (&["in", "--out", "out", "--turntable", "0"], "turntable"),
        (&["in", "--out", "out", "--view", "view.json"], "camera_to_world"),
        (&["in", "--out", "out", "--background", "blue"], "#rrggbb"),
        (&["in", "--out", "out", "--turntable", "4", "--camera", "auto"], "cannot be used"),
        (&["in", "--out", "out", "--env", "constant:1,2"], "R,G,B"),
    ];
    for (arguments, told) in cases {
        let output = batch(dir.path(), arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{arguments:?}: {}", stderr(&output));
    }
    assert!(!dir.path().join("out").exists());
}

#[test]
fn an_output_that_cannot_be_written_is_a_failure_with_its_cause() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ), ("taken", "a file")]);
    let output = batch(dir.path(), &["in", "--out", "taken/out"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("taken/out: cannot be written to"), "{}", stderr(&output));
    // One picture's name is taken by a folder that is not empty.
    fs::create_dir_all(dir.path().join("out/a.obj.png/inside")).expect("folder");
    let output = batch(dir.path(), &["in", "--out", "out"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    assert_eq!(statuses(&lines), [("a.obj", "failed"), ("b.obj", "ok")]);
    assert_eq!(lines[0]["error_code"], "unwritable");
    assert!(lines[0]["error_message"].as_str().expect("message").contains("a.obj.png"));
    // Nothing half-done is left.
    assert_eq!(files(&dir.path().join("out")), ["b.obj.exr", "b.obj.png", "index.html", "manifest.jsonl"]);
}

#[test]
fn globs_choose_and_the_output_folder_is_not_searched() {
    let dir = folder(&[("a.obj", OBJ), ("old/b.obj", OBJ), ("c/d.obj", OBJ), ("out/e.obj", OBJ)]);
    let arguments = [".", "--out", "out", "--include", "*.obj", "--exclude", "old/*", "--format", "png"];
    let output = batch(dir.path(), &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(statuses(&manifest(&dir.path().join("out"))), [("a.obj", "ok"), ("c/d.obj", "ok")]);
    assert_eq!(files(&dir.path().join("out")), ["a.obj.png", "c/d.obj.png", "e.obj", "index.html", "manifest.jsonl"]);
}

#[test]
fn several_folders_keep_their_outputs_apart() {
    let dir = folder(&[("x/chairs/oak.obj", OBJ), ("y/chairs/oak.obj", OBJ)]);
    let output = batch(dir.path(), &["x/chairs", "y/chairs", "--out", "out", "--format", "png"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let want = ["chairs/oak.obj.png", "chairs-2/oak.obj.png", "index.html", "manifest.jsonl"];
    assert_eq!(files(&dir.path().join("out")), want);
}

#[test]
fn files_may_stand_among_folders() {
    let dir = folder(&[("x/oak.obj", OBJ), ("y/oak.obj", OBJ), ("chairs/ash.obj", OBJ), ("notes.txt", "none")]);
    let output =
        batch(dir.path(), &["x/oak.obj", "y/oak.obj", "chairs", "notes.txt", "--out", "out", "--format", "png"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    let want = [("oak.obj", "ok"), ("oak-2.obj", "ok"), ("chairs/ash.obj", "ok"), ("notes.txt", "failed")];
    assert_eq!(statuses(&lines), want);
    assert_eq!(lines[3]["error_code"], "unknown-format");
}

#[test]
fn json_lines_on_stdout_are_the_manifest() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", "nothing"), ("in/c.obj", OBJ)]);
    let output = batch(dir.path(), &["in", "--out", "out", "--json", "--quiet"]);
    let mut lines: Vec<Value> = String::from_utf8(output.stdout.clone())
        .expect("text")
        .lines()
        .map(|l| serde_json::from_str(l).expect("JSON"))
        .collect();
    lines.sort_by_key(|l| l["input"].to_string());
    assert_eq!(lines, manifest(&dir.path().join("out")));
    // Quiet still tells failures, and only those.
    let said = stderr(&output);
    assert!(said.contains("b.obj") && !said.contains("a.obj"), "{said}");
}

#[test]
fn plain_lines_carry_no_escape_codes() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", "nothing")]);
    let output = batch(dir.path(), &["in", "--out", "out"]);
    let said = stderr(&output);
    assert!(!said.contains('\x1b'), "{said}");
    assert_eq!(said.lines().filter(|l| l.starts_with('[')).count(), 2, "{said}");
}

#[test]
fn a_view_of_a_missing_environment_is_told_before_anything_is_done() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let output = batch(dir.path(), &["in", "--out", "out", "--env", "nowhere.hdr"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("nowhere.hdr"), "{}", stderr(&output));
    assert!(!dir.path().join("out").exists());
}

#[test]
fn help_has_examples() {
    let dir = folder(&[]);
    for arguments in [&["--help"][..], &["batch", "--help"], &["render", "--help"], &["inspect", "--help"]] {
        let output = command(dir.path(), arguments).output().expect("the program runs");
        assert_eq!(code(&output), 0);
        assert!(String::from_utf8_lossy(&output.stdout).contains("Examples:"), "{arguments:?}");
    }
}
