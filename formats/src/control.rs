use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The work was stopped by its caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped")]
pub struct Stopped;

#[derive(Debug, Default)]
struct Shared {
    stop: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    helpers_ns: AtomicU64,
}

/// A handle on running work: the worker polls it and reports to it, others ask for a stop and read the progress.
///
/// Clones share one state. Long loops poll [`Control::check`] every 10 ms or so; with a deadline it reads the clock.
#[derive(Clone, Debug, Default)]
pub struct Control {
    shared: Arc<Shared>,
    parent: Option<Arc<Shared>>,
    deadline: Option<Instant>,
}

impl Control {
    /// A handle with a progress of its own that also stops when `self` is stopped.
    pub fn child(&self) -> Self {
        Self { shared: Arc::default(), parent: Some(self.shared.clone()), deadline: self.deadline }
    }

    /// The same handle for work that also stops at a moment, or at its own deadline if that is earlier.
    pub fn until(&self, deadline: Instant) -> Self {
        let deadline = self.deadline.map_or(deadline, |own| own.min(deadline));
        Self { deadline: Some(deadline), ..self.clone() }
    }

    /// When the work stops by itself.
    pub fn deadline(&self) -> Option<Instant> {
        self.deadline
    }

    /// Asks the work to stop.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Whether the work is to stop: somebody asked for it or the deadline has passed.
    pub fn is_stopped(&self) -> bool {
        self.was_asked_to_stop() || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }

    /// Whether somebody asked for a stop, whatever the deadline.
    pub fn was_asked_to_stop(&self) -> bool {
        let stopped = |s: &Shared| s.stop.load(Ordering::Relaxed);
        stopped(&self.shared) || self.parent.as_deref().is_some_and(stopped)
    }

    /// For `?` in the worker's loops.
    ///
    /// # Errors
    /// [`Stopped`] when a stop was asked for or the deadline has passed.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.is_stopped() { Err(Stopped) } else { Ok(()) }
    }

    /// Begins a stage of `total` steps.
    pub fn begin(&self, total: u64) {
        self.begin_at(0, total);
    }

    /// Goes on with a stage of `total` steps of which `done` are done.
    pub fn begin_at(&self, done: u64, total: u64) {
        self.shared.done.store(done, Ordering::Relaxed);
        self.shared.total.store(total, Ordering::Relaxed);
    }

    /// Reports `steps` more steps as done.
    pub fn advance(&self, steps: u64) {
        self.shared.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Adds CPU time that other threads than the caller's have spent on the work.
    pub fn add_helpers_cpu(&self, time: Duration) {
        self.shared.helpers_ns.fetch_add(u64::try_from(time.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    /// CPU time that other threads than the caller's have spent on the work so far.
    pub fn helpers_cpu(&self) -> Duration {
        Duration::from_nanos(self.shared.helpers_ns.load(Ordering::Relaxed))
    }

    /// Steps done and steps in all of the current stage.
    pub fn progress(&self) -> (u64, u64) {
        (self.shared.done.load(Ordering::Relaxed), self.shared.total.load(Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_stops_by_itself_and_is_inherited() {
        let control = Control::default();
        let now = Instant::now();
        let late = control.until(now);
        assert!(late.is_stopped() && !late.was_asked_to_stop() && !control.is_stopped());
        let later = now + Duration::from_secs(3600);
        assert_eq!(late.until(later).deadline(), Some(now), "the earlier one counts");
        assert!(late.child().is_stopped() && !control.until(later).is_stopped());
        late.begin_at(3, 7);
        assert_eq!(control.progress(), (3, 7), "one progress");
        control.stop();
        assert!(late.was_asked_to_stop() && control.child().is_stopped());
    }
}
