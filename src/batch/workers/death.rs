use super::Isolation;
use crate::batch::{Job, Outcome, Status, digest};
use kiln_formats::Control;
use std::process::ExitStatus;
use std::time::Duration;

/// How a worker ended that should have gone on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Death {
    /// It was killed, for its asset took too long.
    Timeout(Duration),
    /// It was killed, for its asset did not get on.
    Stalled(Duration),
    /// It was killed, for it did not stop when asked to.
    Stopped,
    /// It had no memory left.
    OutOfMemory,
    /// It had no stack left.
    StackOverflow,
    /// It ended otherwise.
    Crashed(String),
    /// It could not be started or spoken to.
    Unreachable(String),
}

impl Death {
    /// Of a process that ended by itself, with the last that it said on its standard error.
    pub fn of(status: ExitStatus, complaints: &str) -> Self {
        let said = |words: &[&str]| words.iter().any(|word| complaints.contains(word));
        if said(&["memory allocation of", "bad_alloc", "out of memory"]) {
            return Self::OutOfMemory;
        }
        if said(&["has overflowed its stack"]) {
            return Self::StackOverflow;
        }
        let last = complaints.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or_default();
        let last = if last.is_empty() { String::new() } else { format!(": {last}") };
        Self::Crashed(format!("{}{last}", how(status)))
    }

    /// Stable word for the manifest.
    pub fn code(&self) -> &'static str {
        match self {
            Self::Timeout(_) => "timeout",
            Self::Stalled(_) => "stalled",
            Self::Stopped => "stopped",
            Self::OutOfMemory => "out-of-memory",
            Self::StackOverflow => "stack-overflow",
            Self::Crashed(_) => "crashed",
            Self::Unreachable(_) => "no-worker",
        }
    }

    fn message(&self, memory: Option<u64>) -> String {
        match self {
            Self::Timeout(limit) => format!("killed after {} s (--timeout)", limit.as_secs_f64()),
            Self::Stalled(patience) => format!("killed: nothing moved for {} s", patience.as_secs_f64()),
            Self::Stopped => "interrupted, and killed because it did not stop".into(),
            Self::OutOfMemory => match memory {
                Some(bytes) => format!("needs more than the {} MB of memory that it may take (--memory)", bytes >> 20),
                None => "needs more memory than there is".into(),
            },
            Self::StackOverflow => "a stack overflow in Kiln or a library, please report it".into(),
            Self::Crashed(how) => format!("Kiln or a library crashed on it, please report it: {how}"),
            Self::Unreachable(why) => format!("no worker process: {why}"),
        }
    }

    /// The outcome of the asset that the worker died of.
    pub fn outcome(&self, job: &Job, seconds: f64, isolation: &Isolation, settings: Option<String>) -> Outcome {
        let mut outcome = Outcome::of(job);
        outcome.status = if *self == Self::Stopped { Status::Skipped } else { Status::Failed };
        outcome.error_code = Some(self.code().into());
        outcome.error_message = Some(self.message(isolation.memory));
        outcome.settings = settings;
        outcome.seconds.total = seconds;
        // What it refers to died with the worker.
        if job.input.metadata().is_ok_and(|m| m.is_file() && m.len() <= job.limits.max_file_bytes) {
            outcome.content = digest::of_files(std::slice::from_ref(&job.input), &Control::default()).ok();
            outcome.files =
                job.input.file_name().map(|name| crate::settings::PathText(name.into())).into_iter().collect();
        }
        outcome
    }
}

#[cfg(unix)]
fn how(status: ExitStatus) -> String {
    use nix::sys::signal::Signal;
    use std::os::unix::process::ExitStatusExt;
    match status.signal().map(|number| (number, Signal::try_from(number))) {
        Some((_, Ok(Signal::SIGKILL))) => {
            "killed from outside by SIGKILL, perhaps by the system for want of memory".into()
        }
        Some((_, Ok(signal))) => signal.as_str().into(),
        Some((number, Err(_))) => format!("signal {number}"),
        None => status.to_string(),
    }
}

#[cfg(not(unix))]
fn how(status: ExitStatus) -> String {
    status.to_string()
}
