use crate::support::{OBJ, code, files, folder, kiln, stderr};
use kiln::write::exr::decode;
use serde_json::Value;
use std::fs;
use std::path::Path;

const SMALL: [&str; 2] = ["--width", "24"];

/// Renders `a.obj` and gives the exit code with the manifest's line.
fn render(folder: &Path, arguments: &[&str]) -> (i32, Value) {
    let output = kiln(folder, &[&["render", "a.obj", "--json", "--quiet"], arguments, &SMALL].concat());
    let line = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stderr(&output)));
    (code(&output), line)
}

#[test]
fn an_error_asked_for_is_met_stated_and_repeatable() {
    let dir = folder(&[("a.obj", OBJ)]);
    let (code, line) = render(dir.path(), &["--error", "3", "--format", "png,exr"]);
    assert_eq!((code, &line["status"]), (0, &Value::from("ok")), "{line}");
    let output = &line["outputs"][0];
    let number = |key: &str| output[key].as_f64().unwrap_or_else(|| panic!("{key}: {line}"));
    assert_eq!(output["target_met"], true);
    assert!(0.0 < number("error") && number("error") < number("error_bound") && number("error_bound") <= 3.0);
    assert!(0.0 < number("relmse") && number("relmse") < number("relmse_bound"));
    let spp = number("spp") as u32;
    assert!(spp > 16 && spp.is_multiple_of(4), "{spp}");
    let text = String::from_utf8_lossy(&fs::read(dir.path().join("a.obj.png")).expect("read")).into_owned();
    assert!(text.contains("kiln:error_bound"));
    // The number of samples that it came to gives the same light.
    let (_, _) = render(dir.path(), &["--spp", &spp.to_string(), "-o", "again.exr"]);
    let picture = |name: &str| decode(&fs::read(dir.path().join(name)).expect("read"), 1 << 20).expect("our own file");
    assert_eq!(picture("a.obj.exr"), picture("again.exr"));
}

#[test]
fn a_deadline_gives_a_partial_picture_or_says_that_there_is_none() {
    let dir = folder(&[("a.obj", OBJ)]);
    let (code, line) = render(dir.path(), &["--time", "0.00001"]);
    assert_eq!((code, line["status"].as_str(), &line["outputs"]), (1, Some("failed"), &Value::Array(Vec::new())));
    assert_eq!(line["error_code"], "deadline-before-first-pass");
    assert_eq!(files(dir.path()), ["a.obj"]);
    let (code, line) = render(dir.path(), &["--time", "0.8", "--error", "0.001"]);
    assert_eq!((code, line["status"].as_str()), (3, Some("partial")), "{line}");
    assert_eq!(line["outputs"][0]["target_met"], false);
    assert!(line["seconds"]["total"].as_f64().is_some_and(|s| s < 0.9), "{}", line["seconds"]);
    assert_eq!(files(dir.path()), ["a.obj", "a.obj.png"]);
}

#[test]
fn what_is_met_first_ends_the_render() {
    let dir = folder(&[("a.obj", OBJ)]);
    let (code, line) = render(dir.path(), &["--time", "1000", "--error", "0.001", "--spp", "6"]);
    assert_eq!((code, line["status"].as_str(), line["outputs"][0]["spp"].as_u64()), (0, Some("warned"), Some(6)));
    assert_eq!(line["outputs"][0]["target_met"], false);
    assert_eq!(line["warnings"][0]["code"], "error-not-met");
    // By itself an error that is never met ends a render at last.
    let (_, line) = render(dir.path(), &["--error", "0.0001"]);
    assert_eq!(
        (line["outputs"][0]["spp"].as_u64(), &line["warnings"][0]["code"]),
        (Some(4096), &"error-not-met".into())
    );
    let (_, line) = render(dir.path(), &["--preset", "draft"]);
    assert_eq!(line["outputs"][0]["target_met"], true);
    assert!(line["outputs"][0]["error_bound"].as_f64().is_some_and(|b| b > 4.0 && b <= 8.0), "{line}");
    let (_, line) = render(dir.path(), &["--preset", "draft", "--spp", "2", "--error", "0.5"]);
    assert_eq!((&line["outputs"][0]["target_met"], line["outputs"][0]["spp"].as_u64()), (&Value::from(false), Some(2)));
    for wrong in [["--error", "0"], ["--time", "-1"], ["--clamp", "nan"], ["--preset", "best"]] {
        let output = kiln(dir.path(), &[&["render", "a.obj"], &wrong[..]].concat());
        assert_eq!(crate::support::code(&output), 2, "{wrong:?}: {}", stderr(&output));
    }
}

#[test]
fn clamping_is_never_silent() {
    let dir = folder(&[("a.obj", OBJ)]);
    let bias = |arguments: &[&str]| render(dir.path(), arguments).1["outputs"][0]["bias"].clone();
    assert_eq!(bias(&["--spp", "4"]), Value::Array(Vec::new()));
    let clamped = bias(&["--spp", "4", "--clamp", "0.25"]);
    assert!(clamped[0].as_str().is_some_and(|b| b.starts_with("clamp 0.25: removed ") && !b.contains(" 0.0000 %")));
}
