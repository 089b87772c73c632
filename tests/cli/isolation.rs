//! Bad assets cost themselves alone.

use crate::support::{OBJ, code, command, files, folder, kiln, manifest, statuses, stderr};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

const SMALL: [&str; 6] = ["--width", "16", "--spp", "1", "--format", "png"];

fn batch(folder: &Path, arguments: &[&str], fault: &str) -> Output {
    let arguments = [&["batch", "in", "--out", "out"], arguments, &SMALL].concat();
    command(folder, &arguments).env("KILN_FAULT", fault).output().expect("the program runs")
}

fn failures(lines: &[Value]) -> Vec<(&str, &str, &str)> {
    lines
        .iter()
        .filter(|l| l["status"] == "failed")
        .map(|l| {
            let word = |key: &str| l[key].as_str().unwrap_or_default();
            (word("input"), word("error_code"), word("error_message"))
        })
        .collect()
}

#[cfg(target_os = "linux")]
#[test]
fn crashes_hangs_and_greed_cost_one_asset_each() {
    let names: Vec<String> = (0..12).map(|i| format!("in/good{i:02}.obj")).collect();
    let mut all: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), OBJ)).collect();
    let bad = ["in/good03-abort.obj", "in/good04-greed.obj", "in/good05-loop.obj", "in/good06-deep.obj"];
    all.extend(bad.map(|name| (name, OBJ)));
    let dir = folder(&all);
    let faults = "good03-abort.obj=abort,good04-greed.obj=allocate,good05-loop.obj=loop,good06-deep.obj=overflow";
    let output = batch(dir.path(), &["--jobs", "2", "--memory", "300M", "--timeout", "2"], faults);
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    let ok = lines.iter().filter(|l| l["status"] == "ok").count();
    assert_eq!((lines.len(), ok), (16, 12), "{}", stderr(&output));
    let failed = failures(&lines);
    let codes: Vec<(&str, &str)> = failed.iter().map(|(input, code, _)| (*input, *code)).collect();
    let want = [
        ("good03-abort.obj", "crashed"),
        ("good04-greed.obj", "out-of-memory"),
        ("good05-loop.obj", "timeout"),
        ("good06-deep.obj", "stack-overflow"),
    ];
    assert_eq!(codes, want, "{failed:?}");
    assert!(failed[0].2.contains("SIGABRT"), "{failed:?}");
    assert!(failed[1].2.contains("300 MB"), "{failed:?}");
    assert!(failed[2].2.contains("2 s"), "{failed:?}");
    for (name, ..) in &failed {
        assert!(stderr(&output).contains(&format!("failed: {name}")), "{}", stderr(&output));
    }
    let pictures = files(&dir.path().join("out"));
    assert_eq!(pictures.len(), 14, "{pictures:?}");
    // A second run knows all that; higher limits are worth another try.
    let again = batch(dir.path(), &["--jobs", "2", "--memory", "300M", "--timeout", "2", "--dry-run"], "");
    assert!(stderr(&again).contains("0 assets to render, 16 up to date"), "{}", stderr(&again));
    let more = batch(dir.path(), &["--jobs", "2", "--memory", "400M", "--timeout", "2"], "");
    assert_eq!(code(&more), 3, "{}", stderr(&more));
    let lines = manifest(&dir.path().join("out"));
    let codes: Vec<&str> = failures(&lines).iter().map(|(_, code, _)| *code).collect();
    assert_eq!(codes, ["crashed", "stack-overflow"], "the others had a limit");
    let retried = batch(dir.path(), &["--retry-failed"], "");
    assert_eq!(code(&retried), 0, "{}", stderr(&retried));
}

#[test]
fn pictures_do_not_depend_on_jobs_or_on_processes() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ), ("in/c.obj", OBJ)]);
    for (out, how) in [("one", &["--jobs", "1"][..]), ("three", &["--jobs", "3"]), ("inside", &["--in-process"])] {
        let output = kiln(dir.path(), &[&["batch", "in", "--out", out], &SMALL[..], how].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    let read = |out: &str, name: &str| fs::read(dir.path().join(out).join(name)).expect("a picture");
    for name in ["a.obj.png", "b.obj.png", "c.obj.png"] {
        assert!(read("one", name) == read("three", name) && read("one", name) == read("inside", name));
    }
}

#[test]
fn limits_of_size_are_kept() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let output = batch(dir.path(), &["--max-triangles", "2"], "");
    assert_eq!(code(&output), 1);
    let lines = manifest(&dir.path().join("out"));
    assert_eq!(failures(&lines)[0].1, "too-large");
    assert_eq!(lines[0]["limits"]["max_triangles"], 2);
    assert_eq!(code(&batch(dir.path(), &["--max-triangles", "3"], "")), 0);
    for wrong in [&["--memory", "much"][..], &["--timeout", "0"], &["--memory", "1G", "--in-process"]] {
        assert_eq!(code(&batch(dir.path(), wrong, "")), 2, "{wrong:?}");
    }
}

#[test]
fn an_output_folder_has_one_run_at_a_time() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let arguments = [&["batch", "in", "--out", "out"], &SMALL[..]].concat();
    let mut first = command(dir.path(), &arguments)
        .env("KILN_FAULT", "a.obj=loop")
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program runs");
    let lock = dir.path().join("out/.kiln.lock");
    while fs::read_to_string(&lock).unwrap_or_default().is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let second = kiln(dir.path(), &arguments);
    first.kill().expect("a child");
    first.wait().expect("a child");
    assert_eq!(code(&second), 1);
    assert!(stderr(&second).contains("another run"), "{}", stderr(&second));
    // A lock ends with its owner, however that ends.
    let third = kiln(dir.path(), &arguments);
    assert_eq!(code(&third), 0, "{}", stderr(&third));
    assert_eq!(files(&dir.path().join("out")), ["a.obj.png", "index.html", "manifest.jsonl"]);
    assert_eq!(statuses(&manifest(&dir.path().join("out"))), [("a.obj", "ok")]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_batch_clearly_and_it_goes_on_later() {
    let names: Vec<String> = (0..30).map(|i| format!("in/{i:02}.obj")).collect();
    let dir = folder(&names.iter().map(|name| (name.as_str(), OBJ)).collect::<Vec<_>>());
    fs::create_dir(dir.path().join("out")).expect("folder");
    // A small disk of its own, which nobody else sees.
    let script = r#"
        mount -t tmpfs -o size=160k none out 2>/dev/null || exit 77
        kiln() { "$KILN" batch in --out out --format png --width 64 --spp 1; }
        kiln; echo "first $?"
        find out -name '*.tmp' | sed 's/^/left /'
        mount -o remount,size=64m out
        kiln; echo "second $?"
        find out -name '*.png' | wc -l; grep -c '"ok"' out/manifest.jsonl"#;
    let output = std::process::Command::new("unshare")
        .args(["--mount", "sh", "-c", script])
        .current_dir(dir.path())
        .env("KILN", env!("CARGO_BIN_EXE_kiln"))
        .output();
    let Some(output) = output.ok().filter(|o| ![Some(1), Some(77)].contains(&o.status.code())) else {
        eprintln!("skipped: no disk can be mounted here");
        return;
    };
    let said = stderr(&output);
    assert!(said.contains("No space left") && said.contains("nothing more can be written"), "{said}");
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(told.lines().collect::<Vec<_>>(), ["first 3", "second 0", "30", "30"], "{said}");
}
