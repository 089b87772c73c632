#![cfg(unix)]

use crate::support::{OBJ, command, files, folder, manifest, statuses};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn ctrl_c_stops_in_order() {
    let dir = folder(&[("in/a.obj", OBJ), ("in/b.obj", OBJ), ("in/c.obj", OBJ)]);
    // Work for hours: nobody waits for it.
    let arguments = ["batch", "in", "--out", "out", "--jobs", "1", "--width", "1024", "--spp", "1000000"];
    let mut child = command(dir.path(), &arguments).stderr(Stdio::null()).spawn().expect("the program runs");
    let begin = Instant::now();
    while !dir.path().join("out/manifest.jsonl").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "it does not begin");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let asked = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status;
        }
        if asked.elapsed() > Duration::from_secs(60) {
            child.kill().expect("a child");
            panic!("it does not stop");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(status.code(), Some(130));
    let out = dir.path().join("out");
    let lines = manifest(&out);
    let told = statuses(&lines);
    assert_eq!(told[1..], [("b.obj", "skipped"), ("c.obj", "skipped")]);
    // How far the first came is the machine's speed: a picture with a sample for every pixel is kept, whole, and no
    // other.
    let mut expected = vec!["index.html", "manifest.jsonl"];
    if told[0] == ("a.obj", "partial") {
        expected.splice(0..0, ["a.obj.exr", "a.obj.png"]);
        assert!(lines[0]["outputs"][0]["spp"].as_u64().is_some_and(|spp| spp > 0), "{}", lines[0]);
    } else {
        assert_eq!(told[0], ("a.obj", "skipped"));
    }
    assert_eq!(files(&out), expected, "no half-done file");
}
