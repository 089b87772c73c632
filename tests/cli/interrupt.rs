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
    let lines = manifest(&dir.path().join("out"));
    assert_eq!(statuses(&lines), [("a.obj", "skipped"), ("b.obj", "skipped"), ("c.obj", "skipped")]);
    assert_eq!(files(&dir.path().join("out")), ["index.html", "manifest.jsonl"], "no half-done file");
}
