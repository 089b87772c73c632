//! Nothing lost, nothing half-done, nothing done twice.

use crate::support::{OBJ, code, command, files, folder, gltf, kiln, manifest, statuses, stderr};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

const SMALL: [&str; 4] = ["--width", "16", "--spp", "1"];

fn batch(folder: &Path, arguments: &[&str]) -> Output {
    let output = kiln(folder, &[&["batch", "in", "--out", "out"], arguments, &SMALL].concat());
    assert!(!stderr(&output).contains("panicked"), "{}", stderr(&output));
    output
}

/// What a dry run says of each asset that is due.
fn due(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let output = batch(folder, &[arguments, &["--dry-run"]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("text");
    text.lines().filter_map(|l| l.strip_prefix("render")).map(|l| l.trim().to_owned()).collect()
}

/// The pictures of a folder.
fn pictures(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let is_picture = |name: &String| name.ends_with(".png") || name.ends_with(".exr");
    files(out)
        .into_iter()
        .filter(is_picture)
        .map(|name| (name.clone(), fs::read(out.join(name)).expect("read")))
        .collect()
}

/// Manifest lines without what varies from run to run.
fn timeless(out: &Path) -> Vec<Value> {
    let mut lines = manifest(out);
    for line in lines.iter_mut().filter_map(Value::as_object_mut) {
        ["seconds", "cpu_seconds", "peak_bytes"].iter().for_each(|key| drop(line.remove(*key)));
    }
    lines
}

#[test]
fn what_is_up_to_date_is_not_done_again() {
    let mtl = "newmtl m\nmap_Kd wood.png\n";
    let textured = format!("mtllib m.mtl\nusemtl m\n{OBJ}");
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", &textured), ("in/m.mtl", mtl), ("in/c.obj", "f 1 2 3\n")]);
    let path = |name: &str| dir.path().join(name);
    let all = ["a.obj (new)", "b.obj (new)", "c.obj (new)"];
    assert_eq!(due(dir.path(), &[]), all);
    assert!(!path("out").exists(), "a dry run writes nothing");
    assert_eq!(code(&batch(dir.path(), &[])), 3);
    let first = fs::read(path("out/manifest.jsonl")).expect("a manifest");
    let output = batch(dir.path(), &[]);
    assert_eq!(code(&output), 3);
    assert!(stderr(&output).contains("(3 up to date)"), "{}", stderr(&output));
    assert!(fs::read(path("out/manifest.jsonl")).expect("a manifest") == first);

    assert_eq!(due(dir.path(), &["--seed", "1"]), all.map(|a| a.replace("new", "other settings")));
    assert_eq!(due(dir.path(), &["--force"]), all.map(|a| a.replace("new", "forced")));
    assert_eq!(due(dir.path(), &["--retry-failed"]), ["c.obj (failed)"]);
    // Whatever the time allowed: what was finished in it, is finished. The instruction set changes nothing, either.
    assert_eq!(due(dir.path(), &["--simd", "scalar", "--threads", "1"]), [""; 0]);

    fs::remove_file(path("out/a.obj.exr")).expect("remove");
    assert_eq!(due(dir.path(), &[]), ["a.obj (pictures are missing)"]);
    assert_eq!(code(&batch(dir.path(), &[])), 3);
    fs::write(path("out/a.obj.png"), "half").expect("write");
    assert_eq!(due(dir.path(), &[]), ["a.obj (pictures are missing)"]);
    assert_eq!(code(&batch(dir.path(), &[])), 3);

    // What an asset refers to is part of it: what changes, and what was missing and appears.
    fs::write(path("in/m.mtl"), format!("{mtl}Kd 1 0 0\n")).expect("write");
    assert_eq!(due(dir.path(), &[]), ["b.obj (the asset has changed)"]);
    assert_eq!(code(&batch(dir.path(), &[])), 3);
    fs::write(path("in/wood.png"), "no picture").expect("write");
    assert_eq!(due(dir.path(), &[]), ["b.obj (the asset has changed)"]);
    // A failure that is mended, and an asset that comes back to what it was.
    fs::write(path("in/c.obj"), OBJ).expect("write");
    assert_eq!(code(&batch(dir.path(), &[])), 0);
    assert_eq!(due(dir.path(), &[]), [""; 0]);
    let touched = fs::read(path("in/a.obj")).expect("read");
    fs::write(path("in/a.obj"), touched).expect("write");
    assert_eq!(due(dir.path(), &[]), [""; 0], "only bytes count");
}

#[test]
fn what_the_time_cut_short_is_done_again_with_more_time() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let timed = |time: &str, dry: &[&str]| {
        let arguments = [&["batch", "in", "--out", "out", "--width", "64", "--time", time], dry].concat();
        kiln(dir.path(), &arguments)
    };
    let output = timed("0.3", &[]);
    assert_eq!(statuses(&manifest(&dir.path().join("out"))), [("a.obj", "partial")], "{}", stderr(&output));
    let said = |time: &str| String::from_utf8(timed(time, &["--dry-run"]).stdout).expect("text");
    assert!(said("0.3").starts_with("up to date"), "{}", said("0.3"));
    assert!(said("0.2").starts_with("up to date"));
    assert!(said("5").contains("(cut short)"), "{}", said("5"));
}

#[test]
fn killed_at_any_moment_it_goes_on() {
    let names: Vec<String> = (0..24).map(|i| format!("in/{}/{i:02}.obj", i % 3)).collect();
    let mut all: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), OBJ)).collect();
    let gltf = gltf();
    all.extend([("in/1/a.gltf", gltf.as_str()), ("in/bad.glb", "no glb")]);
    let dir = folder(&all);
    let arguments =
        |out: &'static str| [&["batch", "in", "--out", out, "--jobs", "2", "--turntable", "2"], &SMALL[..]].concat();
    let begin = Instant::now();
    assert_eq!(code(&kiln(dir.path(), &arguments("undisturbed"))), 3);
    let usual = begin.elapsed();
    let out = dir.path().join("out");
    let mut cut = 0;
    for round in 1..=8u32 {
        let mut child = command(dir.path(), &arguments("out")).stderr(Stdio::null()).spawn().expect("the program runs");
        std::thread::sleep(usual.mul_f64(f64::from(round * 5 % 8) / 8.0 + 0.02));
        child.kill().expect("a child");
        cut += usize::from(child.wait().expect("a child").code().is_none());
        // Whatever is there is whole: lines but for the last, pictures by their size.
        let text = fs::read_to_string(out.join("manifest.jsonl")).unwrap_or_default();
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        for line in whole.lines().map(|l| serde_json::from_str::<Value>(l).expect("a whole line")) {
            for output in line["outputs"].as_array().expect("outputs") {
                let file = out.join(output["path"].as_str().expect("path"));
                assert_eq!(file.metadata().expect("a picture").len(), output["bytes"].as_u64().expect("bytes"));
            }
        }
        if round % 3 == 0 {
            // A new beginning.
            fs::remove_dir_all(&out).expect("remove");
        }
    }
    assert!(cut > 2, "only {cut} of the runs were killed in time");
    let output = kiln(dir.path(), &arguments("out"));
    assert_eq!(code(&output), 3, "{}", stderr(&output));
    let undisturbed = dir.path().join("undisturbed");
    assert_eq!(files(&out), files(&undisturbed), "and nothing else is left");
    assert!(pictures(&out) == pictures(&undisturbed));
    assert_eq!(timeless(&out), timeless(&undisturbed));
}

#[cfg(unix)]
#[test]
fn interrupted_pictures_are_kept_with_the_samples_so_far() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ)]);
    let arguments = ["batch", "in", "--out", "out", "--jobs", "1", "--width", "16", "--spp", "16000000"];
    let mut child = command(dir.path(), &arguments).stderr(Stdio::null()).spawn().expect("the program runs");
    let begin = Instant::now();
    while !dir.path().join("out/manifest.jsonl").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "it does not begin");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(1500));
    // Kubernetes, Slurm and people at a terminal: all the same.
    let sent = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    let out = dir.path().join("out");
    let lines = manifest(&out);
    assert_eq!(statuses(&lines), [("a.obj", "partial"), ("b.obj", "skipped")]);
    let spp = lines[0]["outputs"][0]["spp"].as_u64().expect("spp");
    assert!((64..16_000_000).contains(&spp) && lines[0]["outputs"][0]["error"].is_number(), "{spp}");
    assert_eq!(files(&out), ["a.obj.exr", "a.obj.png", "index.html", "manifest.jsonl"]);
    // It was somebody's wish, not the time that was over: it goes on.
    let dry = kiln(dir.path(), &[&arguments[..], &["--dry-run"]].concat());
    assert!(String::from_utf8_lossy(&dry.stdout).contains("a.obj (cut short)"));
}

#[cfg(unix)]
#[test]
fn twice_ends_at_once() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let arguments = [&["batch", "in", "--out", "out"], &SMALL[..]].concat();
    let mut child = command(dir.path(), &arguments)
        .env("KILN_FAULT", "a.obj=loop")
        .stderr(Stdio::null())
        .spawn()
        .expect("the program runs");
    let begin = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(300));
        let _ = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(begin.elapsed() < Duration::from_secs(30));
    }
    assert_eq!(child.wait().expect("a child").code(), Some(130));
}

#[cfg(target_os = "linux")]
#[test]
fn files_that_cannot_be_written_end_it_clearly() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ), ("in/c.obj", OBJ)]);
    // /dev/full is a disk that is full; as a folder it is not one at all.
    let output = kiln(dir.path(), &[&["batch", "in", "--out", "/dev/full/out"], &SMALL[..]].concat());
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("cannot be written to"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn names_in_every_script_and_in_none() {
    use std::os::unix::ffi::OsStrExt;
    let names = ["стул", "椅子", "كرسي", "ghế", "कुर्सी", "🪑", "a b'c\"d", "new\nline", "100%", "-o", "#x?y&z"];
    let listed: Vec<String> = names.iter().map(|n| format!("in/{n}/{n}.obj")).collect();
    let dir = folder(&listed.iter().map(|n| (n.as_str(), OBJ)).collect::<Vec<_>>());
    let raw = dir.path().join("in").join(std::ffi::OsStr::from_bytes(b"caf\xe9\xff.obj"));
    fs::write(raw, OBJ).expect("write");
    let output = batch(dir.path(), &["--format", "png"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let lines = manifest(&dir.path().join("out"));
    assert_eq!(lines.len(), names.len() + 1);
    for line in &lines {
        let path = line["outputs"][0]["path"].as_str().expect("path");
        assert!(dir.path().join("out").join(path).is_file(), "{path:?}");
    }
    assert!(dir.path().join("out/caf%E9%FF.obj.png").is_file());
    assert_eq!(due(dir.path(), &["--format", "png"]), [""; 0]);
}

#[test]
fn watching_renders_what_changes() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let arguments = [&["batch", "in", "--out", "out", "--watch", "0.1", "--format", "png"], &SMALL[..]].concat();
    let mut child = command(dir.path(), &arguments).stderr(Stdio::null()).spawn().expect("the program runs");
    let out = dir.path().join("out");
    let wait_for = |what: &str, there: &dyn Fn() -> bool| {
        let begin = Instant::now();
        while !there() {
            assert!(begin.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let content = |name: &str| {
        let text = fs::read_to_string(out.join("manifest.jsonl")).unwrap_or_default();
        let mut lines = text.lines().filter_map(|l| serde_json::from_str::<Value>(l).ok());
        lines.rfind(|l| l["input"] == name).map(|l| l["content"].to_string())
    };
    wait_for("the first picture", &|| content("a.obj").is_some());
    let first = content("a.obj");
    fs::write(dir.path().join("in/b.obj"), OBJ).expect("write");
    wait_for("a new asset", &|| content("b.obj").is_some());
    fs::write(dir.path().join("in/a.obj"), format!("{OBJ}f 2 3 5\n")).expect("write");
    wait_for("a changed asset", &|| content("a.obj") != first);
    child.kill().expect("a child");
    child.wait().expect("a child");
}
