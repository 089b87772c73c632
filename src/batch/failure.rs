use crate::settings::Goal;
use kiln_formats::{ErrorCode, ImportError, Stopped};
use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The error code of assets whose deadline came before the first picture.
pub(super) const TOO_LATE: &str = "deadline-before-first-pass";

/// The error code of assets that could not be written because nothing more can be.
pub(super) const DISK_FULL: &str = "disk-full";

/// Why an asset's pictures are not all there.
pub(super) struct Failure {
    /// Stable word.
    pub code: String,
    /// A sentence.
    pub message: String,
    /// Whether somebody, or the deadline, stopped the work.
    pub stopped: bool,
}

impl Failure {
    /// For a stable word and a sentence.
    pub fn new(code: &str, message: impl Into<String>) -> Self {
        Self { code: code.into(), message: message.into(), stopped: false }
    }

    /// A picture cannot be written.
    pub fn unwritable(path: &str, error: &io::Error) -> Self {
        use io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        let full = matches!(error.kind(), StorageFull | QuotaExceeded | ReadOnlyFilesystem);
        Self::new(if full { DISK_FULL } else { "unwritable" }, format!("{path} cannot be written: {error}"))
    }

    /// The time is up.
    pub fn late(goal: &Goal, nothing: bool) -> Self {
        let time = goal.time.unwrap_or_default();
        let code = if nothing { TOO_LATE } else { "deadline" };
        let what = if nothing { "not one pass was done" } else { "not all views were begun" };
        Self { code: code.into(), message: format!("after {time} s {what}"), stopped: true }
    }

    /// Of what a thread panicked with.
    pub fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<&str>().map(|s| s.to_string());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        Self::new(ErrorCode::Internal.as_str(), format!("a defect in Kiln, please report it: {text}"))
    }
}

impl From<Stopped> for Failure {
    fn from(_: Stopped) -> Self {
        Self { code: ErrorCode::Stopped.as_str().into(), message: "interrupted".into(), stopped: true }
    }
}

impl From<ImportError> for Failure {
    fn from(error: ImportError) -> Self {
        if error.code == ErrorCode::Stopped {
            Stopped.into()
        } else {
            Self::new(error.code.as_str(), error.to_string())
        }
    }
}

/// A panic is a failure of the asset.
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| Failure::of_panic(&*panic))
}
