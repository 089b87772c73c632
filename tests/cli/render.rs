use crate::support::{OBJ, code, files, folder, kiln, stderr};
use serde_json::Value;
use std::fs;

const SMALL: [&str; 4] = ["--width", "16", "--spp", "1"];

fn render(folder: &std::path::Path, arguments: &[&str]) -> std::process::Output {
    kiln(folder, &[&["render"], arguments, &SMALL].concat())
}

#[test]
fn names_follow_the_asset_or_the_wish() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    for arguments in [
        &["in/a.obj"][..],
        &["in/a.obj", "-o", "deep/b.exr"],
        &["in/a.obj", "-o", "c.PNG"],
        &["in/a.obj", "--format", "exr,png"],
        &["in/a.obj", "-o", "turn.png", "--turntable", "3"],
    ] {
        let output = render(dir.path(), arguments);
        assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    }
    let want =
        ["a.obj.exr", "a.obj.png", "c.PNG", "deep/b.exr", "in/a.obj", "turn.000.png", "turn.001.png", "turn.002.png"];
    assert_eq!(files(dir.path()), want);
    assert_eq!(fs::read(dir.path().join("c.PNG")).expect("read")[..4], *b"\x89PNG");
}

#[test]
fn a_dash_writes_the_same_png_to_stdout() {
    let dir = folder(&[("a.obj", OBJ)]);
    let output = render(dir.path(), &["a.obj", "-o", "-"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(files(dir.path()), ["a.obj"]);
    assert_eq!(code(&render(dir.path(), &["a.obj"])), 0);
    assert!(output.stdout == fs::read(dir.path().join("a.obj.png")).expect("read"));
}

#[test]
fn json_is_the_manifest_line() {
    let dir = folder(&[("a.obj", OBJ)]);
    let output = render(dir.path(), &["a.obj", "--json", "--quiet"]);
    assert_eq!((code(&output), stderr(&output).as_str()), (0, ""));
    let line: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!((line["input"].as_str(), line["status"].as_str()), (Some("a.obj"), Some("ok")));
    assert_eq!(line["outputs"][0]["path"], "a.obj.png");
    let absolute = dir.path().join("deep/b.png").display().to_string();
    for path in ["deep/b.png", &absolute] {
        let output = render(dir.path(), &["a.obj", "--json", "-o", path]);
        let line: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
        assert_eq!(line["outputs"][0]["path"], path);
    }
}

#[test]
fn failures_are_code_1_and_wishes_that_make_no_sense_code_2() {
    let dir = folder(&[("a.obj", OBJ), ("broken.obj", "f 1 2 3\n")]);
    for (arguments, want, told) in [
        (&["broken.obj"][..], 1, "broken.obj"),
        (&["nowhere.obj"], 1, "No such file"),
        (&["a.txt"], 1, "is not a .gltf, .glb, .obj or .ray file"),
        (&["a.obj", "--camera", "front"], 1, "there is no camera 'front'"),
        (&["a.obj", "-o", "a.jpg"], 2, ".png or .exr"),
        (&["a.obj", "-o", "-", "--json"], 2, "stdout"),
        (&["a.obj", "-o", "-", "--turntable", "2"], 2, "stdout"),
        (&["a.obj", "--spp", "0"], 2, "spp"),
        (&["a.obj", "-o", "a.png", "--format", "exr"], 2, "cannot be used"),
    ] {
        let output = kiln(dir.path(), &[&["render", "--width", "16"], arguments].concat());
        assert_eq!(code(&output), want, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{arguments:?}: {}", stderr(&output));
    }
    assert_eq!(files(dir.path()), ["a.obj", "broken.obj"]);
}

#[test]
fn an_output_below_a_file_is_a_failure() {
    let dir = folder(&[("a.obj", OBJ)]);
    let output = render(dir.path(), &["a.obj", "-o", "a.obj/picture.png"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("picture.png cannot be written"), "{}", stderr(&output));
}

#[test]
fn one_path_can_be_followed_again() {
    let dir = folder(&[("a.obj", OBJ)]);
    let output = render(dir.path(), &["a.obj", "--replay", "8,8,0"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(text.starts_with("pixel 8,8, sample 0, seed 0\n") && text.contains("radiance ("), "{text}");
    let output = render(dir.path(), &["a.obj", "--replay", "8,8,0", "--json"]);
    let trace: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!((&trace["events"][0]["event"], &trace["cause"]), (&Value::from("ray"), &Value::Null));
    assert_eq!(files(dir.path()), ["a.obj"], "no picture is written");
    for (wrong, says) in [("16,0,0", "not in a picture of 16×16"), ("0,0,0,1", "views"), ("1,2", "12,34,5")] {
        let output = render(dir.path(), &["a.obj", "--replay", wrong]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
    }
}

#[test]
fn the_record_says_what_was_not_finite_and_where() {
    let corner = "SBT-raytracer 1.0\n\
        camera { position = (2,2,2); viewdir = (-1,-1,-1); updir = (0,0,1); fov = 0.5; }\n\
        trimesh { points = ((0,0,0),(1,0,0),(0,1,0),(0,0,1)); faces = ((0,1,2),(0,2,3),(0,3,1));\n\
        material = { diffuse = (0.9,0.9,0.9); emissive = (3e38,3e38,3e38); } }\n";
    let dir = folder(&[("a.ray", corner)]);
    let output = render(dir.path(), &["a.ray", "--json", "--quiet", "--env", "none"]);
    let line: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let causes: u64 = line["nonfinite_causes"].as_object().expect("causes").values().filter_map(Value::as_u64).sum();
    assert!(causes > 0 && line["nonfinite"] == causes, "{line}");
    let place = &line["nonfinite_first"][0];
    let address = format!("{},{},{},{}", place["pixel"][0], place["pixel"][1], place["sample"], place["view"]);
    let output = render(dir.path(), &["a.ray", "--replay", &address, "--json", "--env", "none"]);
    let trace: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert_eq!(trace["cause"], place["cause"]);
}
