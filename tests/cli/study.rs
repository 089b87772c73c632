use crate::support::{OBJ, code, command, files, folder, gltf, kiln, stderr};
use serde_json::Value;
use std::fs;
use std::process::Stdio;

const SMALL: [&str; 9] =
    ["--width", "12", "--ways", "kiln,hemisphere,depth-1", "--budget", "0.6", "--spp", "16", "--quiet"];

fn study(folder: &std::path::Path, arguments: &[&str]) -> std::process::Output {
    kiln(folder, &[&["study"], arguments, &SMALL].concat())
}

#[test]
fn a_study_leaves_a_report_that_needs_nothing_else() {
    let dir = folder(&[("a.obj", OBJ), ("broken.obj", "f 1 2 3\n")]);
    let output = study(dir.path(), &["a.obj", "broken.obj", "--out", "out", "--reference-spp", "64"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let report = fs::read_to_string(dir.path().join("out/report.html")).expect("a report");
    assert!(report.contains("<title>What accuracy costs in time</title>") && report.contains("broken.obj"));
    for outside in ["http://", "https://", "src=\"/", "<link", "<script src", "@import", "url("] {
        let said = report.replace("http://www.w3.org/2000/svg", "");
        assert!(!said.contains(outside), "{outside}");
    }
    let json: Value =
        serde_json::from_slice(&fs::read(dir.path().join("out/study.json")).expect("JSON")).expect("JSON");
    let asset = &json["assets"][0];
    assert_eq!(asset["reference"]["spp"], 64);
    assert!(asset["verdict"]["text"].as_str().expect("a sentence").contains("levels"), "{}", asset["verdict"]);
    assert!(json["assets"][1]["error_message"].as_str().is_some());
    let cells = asset["cells"].as_array().expect("cells");
    let of = |way: &str, spp: u64| -> Vec<f64> {
        let mine = cells.iter().filter(|c| c["way"] == way && c["spp"] == spp);
        mine.map(|c| c["rmse"].as_f64().expect("rmse")).collect()
    };
    let (few, many) = (of("kiln", 1), of("kiln", 16));
    assert!(few.len() == 2 && many.len() == 2, "two seeds: {few:?} {many:?}");
    assert!(many.iter().all(|m| few.iter().all(|f| m < f)), "more samples, less error: {few:?} {many:?}");
    let csv = fs::read_to_string(dir.path().join("out/cells.csv")).expect("CSV");
    assert_eq!(csv.lines().count(), cells.len() + 1);
    let columns = |line: &str| line.split(',').count();
    assert!(csv.lines().all(|l| columns(l) == columns(csv.lines().next().expect("a head"))));
    let written = files(&dir.path().join("out"));
    for name in ["plots/a.obj.rmse.svg", "plots/a.obj.rmse.png", "strips/a.obj.samples.png", "references/a.obj.exr"] {
        assert!(written.iter().any(|f| f == name), "{name} is not among {written:?}");
    }
}

#[test]
fn effects_are_priced_and_all_of_them_give_the_same_picture() {
    let dir = folder(&[("a.gltf", &gltf()), ("broken.obj", "f 1 2 3\n")]);
    let output = study(dir.path(), &["a.gltf", "broken.obj", "--out", "out", "--effects", "--reference-spp", "16"]);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let json: Value =
        serde_json::from_slice(&fs::read(dir.path().join("out/study.json")).expect("JSON")).expect("JSON");
    let first = |way: &str| {
        let cells = json["assets"][0]["cells"].as_array().expect("cells");
        let cell =
            cells.iter().find(|c| c["way"] == way && c["spp"] == 1).unwrap_or_else(|| panic!("{way}: {cells:?}"));
        cell["rmse"].as_f64().expect("rmse")
    };
    assert_eq!(first("kiln"), first("all-effects"));
    assert!(first("no-metal") > 0.0);
}

#[test]
fn what_was_measured_is_not_measured_again() {
    let dir = folder(&[("a.obj", OBJ)]);
    let arguments = ["a.obj", "--out", "out", "--reference-spp", "16"];
    assert_eq!(code(&study(dir.path(), &arguments)), 0);
    let cells = dir.path().join("out/cells.jsonl");
    let before = fs::read_to_string(&cells).expect("cells");
    let reference = fs::read(dir.path().join("out/references/a.obj.json")).expect("reference");
    // The last line of a study that was killed may be cut off.
    let cut = before.trim_end().len() - 20;
    fs::write(&cells, &before[..cut]).expect("write");
    assert_eq!(code(&study(dir.path(), &arguments)), 0);
    let after = fs::read_to_string(&cells).expect("cells");
    assert!(after.starts_with(&before[..cut]), "what was there stays");
    let (lines, again) = (before.lines().count(), after.lines().count());
    assert!(
        again == lines + 1 && after.ends_with("}\n"),
        "the cell that was lost, and the line that was cut: {lines} {again}"
    );
    assert_eq!(fs::read(dir.path().join("out/references/a.obj.json")).expect("reference"), reference);
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_says_so_and_goes_on() {
    let dir = folder(&[("a.obj", OBJ)]);
    let arguments = ["study", "a.obj", "--out", "out", "--width", "64", "--budget", "60", "--ways", "strategies"];
    let child = command(dir.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let cells = dir.path().join("out/cells.jsonl");
    let begun = || fs::metadata(&cells).is_ok();
    let patience = std::time::Instant::now();
    while !begun() && patience.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let stopped = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(stopped.expect("kill").success());
    let output = child.wait_with_output().expect("ends");
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert!(fs::read_to_string(dir.path().join("out/report.html")).expect("a report").contains("interrupted"));
}

#[test]
fn wishes_that_make_no_sense_are_code_2() {
    let dir = folder(&[("a.obj", OBJ)]);
    for (arguments, told) in [
        (&["a.obj"][..], "--out"),
        (&["a.obj", "--out", "out", "--way", "kiln: sampler=pcg"], "a name of its own"),
        (&["a.obj", "--out", "out", "--way", "fast"], "is no way"),
        (&["a.obj", "--out", "out", "--budget=-1"], "greater than 0"),
    ] {
        let output = kiln(dir.path(), &[&["study"], arguments].concat());
        assert_eq!(code(&output), 2, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{arguments:?}: {}", stderr(&output));
    }
}
