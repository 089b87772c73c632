use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicU64, Ordering};

/// CPU time of work that is spread over threads: each piece measures itself, so that waits, and the work of others that
/// a waiting thread takes on, do not count.
#[derive(Debug, Default)]
pub struct CpuMeter(AtomicU64);

impl CpuMeter {
    /// Does a piece of work, in which no thread waits for another, and counts its CPU time.
    pub fn measure<R>(&self, work: impl FnOnce() -> R) -> R {
        let clock = ThreadTime::now();
        let result = work();
        self.0.fetch_add(clock.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    /// CPU seconds so far.
    pub fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}
