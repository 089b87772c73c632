//! Parts of a batch, and how they are joined.

use crate::support::{OBJ, code, command, files, folder, kiln, manifest, stderr};
use std::fs;

const SMALL: [&str; 6] = ["--width", "8", "--spp", "1", "--format", "png"];

#[test]
fn parts_joined_are_the_whole() {
    let names: Vec<String> = (0..12).map(|i| format!("in/{}/{i:02}.obj", i % 3)).collect();
    let mut all: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), OBJ)).collect();
    all.push(("in/bad.glb", "no glb"));
    let dir = folder(&all);
    let run = |arguments: &[&str]| kiln(dir.path(), &[arguments, &SMALL[..]].concat());
    assert_eq!(code(&run(&["batch", "in", "--out", "whole"])), 3);
    for k in 1..=3 {
        let (part, out) = (format!("{k}/3"), format!("shards/{k}"));
        let output = run(&["batch", "in", "--out", &out, "--shard", "9/9", "--shard", &part]);
        assert!([0, 3].contains(&code(&output)), "{}", stderr(&output));
    }
    let merge = |folders: &[&str]| kiln(dir.path(), &[&["merge"], folders, &["--out", "merged"]].concat());
    let two = merge(&["shards/1", "shards/3"]);
    assert!(code(&two) == 3 && stderr(&two).contains("shards are missing: 2/3"), "{}", stderr(&two));
    let three = merge(&["shards/1", "shards/2", "shards/3"]);
    assert_eq!(code(&three), 3, "{}", stderr(&three));
    assert!(!stderr(&three).contains("missing") && stderr(&three).contains("12 ok, 1 failed"), "{}", stderr(&three));
    let (whole, merged) = (dir.path().join("whole"), dir.path().join("merged"));
    assert_eq!(files(&merged), files(&whole));
    for name in files(&whole).iter().filter(|name| name.ends_with(".png")) {
        assert!(fs::read(whole.join(name)).expect("read") == fs::read(merged.join(name)).expect("read"), "{name}");
    }
    let order = |out: &std::path::Path| manifest(out).iter().map(|l| l["input"].to_string()).collect::<Vec<_>>();
    assert_eq!(order(&merged), order(&whole));
    // What was merged is a batch like any other.
    let again = run(&["batch", "in", "--out", "merged", "--dry-run"]);
    assert!(stderr(&again).contains("0 assets to render, 13 up to date"), "{}", stderr(&again));
}

#[test]
fn engines_say_which_part_it_is() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ)]);
    let arguments = |more: &[&'static str]| [&["batch", "in", "--out", "out", "--dry-run"], more, &SMALL[..]].concat();
    let mut parts = Vec::new();
    for index in ["0", "1"] {
        let output =
            command(dir.path(), &arguments(&["--shard", "auto/2"])).env("JOB_COMPLETION_INDEX", index).output();
        parts.push(String::from_utf8(output.expect("the program runs").stdout).expect("text"));
    }
    let both = String::from_utf8(kiln(dir.path(), &arguments(&[])).stdout).expect("text");
    assert_eq!(parts.concat().lines().count(), 2, "{parts:?}");
    assert!(both.lines().all(|line| parts.concat().contains(line)));
    let output = kiln(dir.path(), &arguments(&["--shard", "auto"]));
    assert!(code(&output) == 2 && stderr(&output).contains("neither a Slurm array"), "{}", stderr(&output));
    // Arrays over folders are common: nothing is left out unasked.
    let mut array = command(dir.path(), &arguments(&[]));
    array.env("AWS_BATCH_JOB_ARRAY_INDEX", "1").env("AWS_BATCH_JOB_ARRAY_SIZE", "4");
    let output = array.output().expect("the program runs");
    assert!(stderr(&output).contains("--shard auto takes a part"), "{}", stderr(&output));
    assert_eq!(String::from_utf8(output.stdout).expect("text"), both);
}

#[test]
fn pictures_are_looked_at_and_the_end_says_what_to_do() {
    let away = format!("{OBJ}mtllib none.mtl\n");
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", &away)]);
    let output = kiln(dir.path(), &[&["batch", "in", "--out", "out", "--env", "none"], &SMALL[..]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    let codes = |line: &serde_json::Value| -> Vec<String> {
        let list = line["warnings"].as_array().expect("warnings").iter();
        list.map(|w| w["code"].as_str().expect("code").to_owned()).collect()
    };
    assert_eq!((codes(&lines[0]), lines[0]["status"].as_str()), (vec!["black-picture".to_owned()], Some("warned")));
    assert_eq!(codes(&lines[1]), ["missing-material-library", "black-picture"]);
    let said = stderr(&output);
    assert!(said.contains("black-picture: 2 assets") && said.contains("--env studio"), "{said}");
    assert!(said.contains("missing-material-library: 1 asset (b.obj)"), "{said}");
}
