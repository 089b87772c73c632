use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The work was stopped by its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped")]
pub struct Stopped;

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
}

/// A handle on running work: the worker polls it and reports to it, others ask for a stop and read the progress.
///
/// Clones share one state. Long loops poll [`Control::check`] every 10 ms or so.
#[derive(Clone, Debug, Default)]
pub struct Control {
    shared: Arc<Shared>,
    parent: Option<Arc<Shared>>,
}

impl Control {
    /// A handle with a progress of its own that also stops when `self` is stopped.
    pub fn child(&self) -> Self {
        Self { shared: Arc::default(), parent: Some(self.shared.clone()) }
    }

    /// Asks the work to stop.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Whether a stop was asked for.
    pub fn is_stopped(&self) -> bool {
        let stopped = |s: &Shared| s.stop.load(Ordering::Relaxed);
        stopped(&self.shared) || self.parent.as_deref().is_some_and(stopped)
    }

    /// For `?` in the worker's loops.
    ///
    /// # Errors
    /// [`Stopped`] when a stop was asked for.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.is_stopped() { Err(Stopped) } else { Ok(()) }
    }

    /// Begins a stage of `total` steps.
    pub fn begin(&self, total: u64) {
        self.shared.done.store(0, Ordering::Relaxed);
        self.shared.total.store(total, Ordering::Relaxed);
    }

    /// Reports `steps` more steps as done.
    pub fn advance(&self, steps: u64) {
        self.shared.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Steps done and steps in all of the current stage.
    pub fn progress(&self) -> (u64, u64) {
        (self.shared.done.load(Ordering::Relaxed), self.shared.total.load(Ordering::Relaxed))
    }
}
