//! One asset as a function: whatever goes wrong is in the outcome.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use kiln::Control;
use kiln::batch::{Desk, Job, MemorySink, Outcome, Output, Sink, Stage, Status, run_asset, run_asset_with};
use kiln::formats::Limits;
use kiln::settings::{RenderSettings, Settings, ViewSettings};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A job for a small turntable of four frames, eight files.
fn job(folder: &Path) -> Job {
    let input = folder.join("a.obj");
    std::fs::write(&input, OBJ).expect("write");
    let mut settings = Settings {
        views: ViewSettings { width: 8, height: 8, turntable: Some(4), ..ViewSettings::default() },
        render: RenderSettings { spp: 1, ..RenderSettings::default() },
        ..Settings::default()
    };
    settings.render.seed = u64::MAX;
    let output = Output { folder: folder.join("out"), stem: PathBuf::from("a.obj"), ending: None };
    Job { input, name: "a.obj".into(), root: None, limits: Limits::default(), output, settings }
}

fn run(job: &Job, control: &Control, sink: &dyn Sink) -> Outcome {
    run_asset_with(job, control, &Desk { sink, on_stage: &|_| (), environment: None })
}

/// Calls a function before each file.
struct Hook<F>(F, MemorySink);

impl<F: Fn() -> io::Result<()> + Sync> Sink for Hook<F> {
    fn put(&self, path: &Path, bytes: Vec<u8>) -> io::Result<()> {
        (self.0)()?;
        self.1.put(path, bytes)
    }
}

#[test]
fn jobs_and_outcomes_survive_json_and_run_the_same() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let job = job(folder.path());
    let text = serde_json::to_string(&job).expect("JSON");
    let read: Job = serde_json::from_str(&text).expect("our own JSON");
    assert_eq!(read, job);
    let first = run_asset(&job, &Control::default());
    assert_eq!((first.status, first.outputs.len()), (Status::Ok, 8), "{:?}", first.error_message);
    let line = first.to_line().expect("finite numbers");
    assert_eq!(serde_json::from_str::<Outcome>(&line).expect("our own JSON"), first);
    let files = |out: &str| -> Vec<Vec<u8>> {
        let read = |o: &kiln::batch::OutputRecord| std::fs::read(folder.path().join(out).join(&o.path)).expect("read");
        first.outputs.iter().map(read).collect()
    };
    let again = Job { output: Output { folder: folder.path().join("again"), ..read.output.clone() }, ..read };
    assert_eq!(run_asset(&again, &Control::default()).status, Status::Ok);
    assert!(files("out") == files("again"));
}

#[test]
fn a_panic_is_an_outcome() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let sink = Hook(|| panic!("the sky is falling"), MemorySink::default());
    let outcome = run(&job(folder.path()), &Control::default(), &sink);
    assert_eq!((outcome.status, outcome.error_code.as_deref()), (Status::Failed, Some("internal")));
    assert!(outcome.error_message.is_some_and(|m| m.contains("the sky is falling")));
}

#[test]
fn a_stop_keeps_what_is_whole() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let control = Control::default();
    let sink = Hook(
        || {
            control.stop();
            Ok(())
        },
        MemorySink::default(),
    );
    let outcome = run(&job(folder.path()), &control, &sink);
    assert_eq!((outcome.status, outcome.error_code.as_deref()), (Status::Partial, Some("stopped")));
    // Both files of the first frame: it was finished already.
    let names: Vec<_> = sink.1.into_files().into_iter().map(|(path, _)| path).collect();
    assert_eq!(names, [Path::new("a.obj.000.png"), Path::new("a.obj.000.exr")]);
    assert_eq!(outcome.outputs.len(), 2);
    let outcome = run(&job(folder.path()), &control, &MemorySink::default());
    assert_eq!((outcome.status, outcome.outputs.len()), (Status::Skipped, 0));
}

#[test]
fn a_full_disk_is_an_outcome() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let left = Mutex::new(3);
    let full = || {
        let mut left = left.lock().expect("no panic");
        *left -= 1;
        if *left < 0 { Err(io::Error::from(io::ErrorKind::StorageFull)) } else { Ok(()) }
    };
    let outcome = run(&job(folder.path()), &Control::default(), &Hook(full, MemorySink::default()));
    assert_eq!((outcome.status, outcome.error_code.as_deref()), (Status::Failed, Some("disk-full")));
    assert_eq!(outcome.outputs.len(), 3);
    assert!(outcome.error_message.is_some_and(|m| m.contains("a.obj.001.exr")));
}

#[test]
fn stages_are_told_in_order() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let stages = Mutex::new(Vec::new());
    let on_stage = |stage: Stage| stages.lock().expect("no panic").push(stage.word());
    let sink = MemorySink::default();
    let outcome = run_asset_with(
        &job(folder.path()),
        &Control::default(),
        &Desk { sink: &sink, on_stage: &on_stage, environment: None },
    );
    assert_eq!(outcome.status, Status::Ok);
    let stages = stages.into_inner().expect("no panic");
    assert_eq!(stages[..2], ["import", "prepare"]);
    assert_eq!(stages[2..], ["render", "write"].repeat(4));
}
