use super::{Job, LimitRecord, Outcome, Status, digest};
use kiln_formats::Control;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// What a run asks for, as far as it decides what is up to date.
#[derive(Clone, Debug, Default)]
pub struct Policy {
    /// Hash of the settings.
    pub settings: String,
    /// Everything is done again.
    pub force: bool,
    /// What failed, or was cut short by the time, is done again.
    pub retry_failed: bool,
    /// Bytes of memory that an asset may take, where that was asked for.
    pub memory: Option<u64>,
    /// Seconds after which an asset is killed, where that was asked for.
    pub timeout: Option<f64>,
}

/// Whether an asset has to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// No: this is what it gave, and would give again.
    Current(Box<Outcome>),
    /// Yes, for a reason.
    Due(Reason),
}

/// Why an asset has to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It has not been done.
    New,
    /// So it is wished.
    Forced,
    /// Another version of Kiln did it.
    Version,
    /// Other settings, or limits, are asked for.
    Settings,
    /// It, or a file that it refers to, is not what it was.
    Content,
    /// A picture is not there, or not whole.
    Pictures,
    /// It was interrupted, or may take more time now.
    Partial,
    /// It failed for a reason that may be gone.
    Failed,
}

impl Reason {
    /// A few words.
    pub fn words(self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Forced => "forced",
            Self::Version => "done by another version of kiln",
            Self::Settings => "other settings",
            Self::Content => "the asset has changed",
            Self::Pictures => "pictures are missing",
            Self::Partial => "cut short",
            Self::Failed => "failed",
        }
    }
}

/// A line of the manifest, in bytes with its line end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub at: u64,
    pub length: u64,
}

/// What earlier runs have written into a manifest: where the last line of each asset is. The lines stay on the disk.
#[derive(Debug, Default)]
pub struct Ledger {
    file: Option<Mutex<File>>,
    lines: HashMap<Box<str>, Span>,
    /// Where the last whole line ends.
    pub(super) end: u64,
}

#[derive(Deserialize)]
struct Head<'a> {
    #[serde(borrow)]
    input: Cow<'a, str>,
}

impl Ledger {
    /// Reads a manifest; what is no line of one (a run may have died while it wrote) is passed over.
    ///
    /// # Errors
    /// Those of the file system, but a missing file is an empty one.
    pub fn read(path: &Path) -> io::Result<Self> {
        let file = match File::open(path) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(error),
        };
        let mut reader = BufReader::with_capacity(1 << 18, &file);
        let (mut lines, mut at, mut line) = (HashMap::new(), 0, Vec::new());
        loop {
            line.clear();
            let length = reader.read_until(b'\n', &mut line)? as u64;
            if line.last() != Some(&b'\n') {
                break;
            }
            if let Ok(head) = serde_json::from_slice::<Head>(&line) {
                lines.insert(head.input.into(), Span { at, length });
            }
            at += length;
        }
        Ok(Self { file: Some(Mutex::new(file)), lines, end: at })
    }

    /// Where the line of an asset is.
    pub(super) fn span(&self, name: &str) -> Option<Span> {
        self.lines.get(name).copied()
    }

    fn line(&self, span: Span) -> Option<Outcome> {
        let mut bytes = vec![0; usize::try_from(span.length).ok()?];
        let mut file = self.file.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(span.at)).ok()?;
        file.read_exact(&mut bytes).ok()?;
        drop(file);
        serde_json::from_slice(&bytes).ok()
    }

    /// The last line of each asset, in the order of the file; what is no whole line is left out.
    pub fn outcomes(&self) -> impl Iterator<Item = Outcome> + '_ {
        let mut spans: Vec<Span> = self.lines.values().copied().collect();
        spans.sort_unstable_by_key(|span| span.at);
        spans.into_iter().filter_map(|span| self.line(span))
    }

    /// The files that an asset refers to or would, as seen from its folder.
    pub fn referred(&self, name: &str) -> Vec<PathBuf> {
        let old = self.span(name).and_then(|span| self.line(span));
        old.into_iter().flat_map(|old| old.files.into_iter().skip(1).chain(old.missing)).map(|file| file.0).collect()
    }

    /// Whether a job has to be done.
    pub fn verdict(&self, job: &Job, policy: &Policy, control: &Control) -> Verdict {
        if policy.force {
            return Verdict::Due(Reason::Forced);
        }
        let Some(old) = self.span(&job.name).and_then(|span| self.line(span)) else { return Verdict::Due(Reason::New) };
        match due(&old, job, policy, control) {
            Some(reason) => Verdict::Due(reason),
            None => Verdict::Current(Box::new(old)),
        }
    }
}

/// Why a job has to be done again, if it has to.
fn due(old: &Outcome, job: &Job, policy: &Policy, control: &Control) -> Option<Reason> {
    if old.kiln != env!("CARGO_PKG_VERSION") {
        return Some(Reason::Version);
    }
    if old.status == Status::Skipped {
        return Some(Reason::New);
    }
    if old.settings.as_deref() != Some(policy.settings.as_str()) {
        return Some(Reason::Settings);
    }
    // Who had as much time and did not make it, will not make it.
    let as_much_time = || old.time.zip(job.settings.goal.time).is_some_and(|(old, now)| now <= old);
    let code = old.error_code.as_deref();
    match old.status {
        Status::Partial if policy.retry_failed || code == Some("stopped") || !as_much_time() => {
            return Some(Reason::Partial);
        }
        Status::Failed if policy.retry_failed || !lasts(code) => return Some(Reason::Failed),
        Status::Failed if old.limits.is_some_and(|old| old != limits(job, policy)) => return Some(Reason::Settings),
        _ => (),
    }
    let whole = |o: &super::OutputRecord| {
        job.output.folder.join(&o.path).metadata().is_ok_and(|m| m.is_file() && m.len() == o.bytes)
    };
    if !old.outputs.iter().all(whole) {
        return Some(Reason::Pictures);
    }
    let folder = job.input.parent().unwrap_or(Path::new(""));
    let others = old.files.iter().skip(1).map(|file| folder.join(&file.0));
    let files: Vec<PathBuf> = std::iter::once(job.input.clone()).chain(others).collect();
    let same = || digest::of_files(&files, control).is_ok_and(|content| old.content.as_ref() == Some(&content));
    let changed = old.missing.iter().any(|file| folder.join(&file.0).exists()) || !same();
    changed.then_some(Reason::Content)
}

/// Whether a failure is the asset's own: it would fail again.
fn lasts(code: Option<&str>) -> bool {
    let passing = [
        "io",
        "unwritable",
        "disk-full",
        "stopped",
        "no-worker",
        "environment",
        "denoiser",
        "deadline-before-first-pass",
    ];
    code.is_some_and(|code| !passing.contains(&code))
}

/// What an asset is held to.
fn limits(job: &Job, policy: &Policy) -> LimitRecord {
    LimitRecord {
        memory: policy.memory,
        timeout: policy.timeout,
        max_triangles: job.limits.max_triangles,
        max_texels: job.limits.max_texels,
    }
}

/// Tells in the outcome of an asset that failed at a limit which they were.
pub(super) fn note_limits(outcome: &mut Outcome, job: &Job, policy: &Policy) {
    if let Some("too-large" | "out-of-memory" | "timeout" | "stalled") = outcome.error_code.as_deref() {
        outcome.limits = Some(limits(job, policy));
    }
}
