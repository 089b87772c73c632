//! CPU time of work that several threads share.

use cpu_time::ThreadTime;
use std::sync::atomic::{AtomicU64, Ordering};

/// CPU time of the thread that began it, and of the threads of a pool that help.
#[derive(Debug)]
pub struct CpuClock {
    caller: Option<ThreadTime>,
    /// Those that help.
    pub helpers: Helpers,
}

/// The threads of a pool that help somebody, and their CPU time.
#[derive(Debug)]
pub struct Helpers {
    /// Called from a thread of the pool, that thread helps as well, and what it does is counted already.
    outside: bool,
    meter: CpuMeter,
}

/// CPU time of work that is spread over threads: each piece measures itself, so that waits, and the work of others that
/// a waiting thread takes on, do not count.
#[derive(Debug, Default)]
pub struct CpuMeter(AtomicU64);

impl CpuClock {
    /// Begins on the calling thread.
    pub fn begin() -> Self {
        let outside = rayon::current_thread_index().is_none();
        let helpers = Helpers { outside, meter: CpuMeter::default() };
        Self { caller: ThreadTime::try_now().ok(), helpers }
    }

    /// CPU seconds of all threads so far. Call it on the thread that began.
    pub fn seconds(&self) -> f64 {
        let own = self.caller.and_then(|clock| clock.try_elapsed().ok()).map_or(0.0, |time| time.as_secs_f64());
        own + self.helpers.meter.seconds()
    }
}

impl Helpers {
    /// Does a part of the work on a thread of the pool.
    pub fn help<R>(&self, part: impl FnOnce() -> R) -> R {
        if self.outside { self.meter.measure(part) } else { part() }
    }
}

impl CpuMeter {
    /// Does a piece of work, in which no thread waits for another, and counts its CPU time.
    pub fn measure<R>(&self, work: impl FnOnce() -> R) -> R {
        let clock = ThreadTime::try_now().ok();
        let result = work();
        if let Some(time) = clock.and_then(|clock| clock.try_elapsed().ok()) {
            self.0.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
        }
        result
    }

    /// CPU seconds so far.
    pub fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::hint::black_box;
    use std::time::Duration;

    /// Takes so much CPU time of this thread, however long that takes on a busy machine.
    fn busy(milliseconds: u64) {
        let begin = ThreadTime::now();
        while begin.elapsed() < Duration::from_millis(milliseconds) {
            black_box(begin);
        }
    }

    #[test]
    fn what_the_caller_does_counts_and_what_helpers_do_but_nothing_twice() {
        let share = |helpers: &Helpers| (0..2).into_par_iter().for_each(|_| helpers.help(|| busy(40)));
        let whole = CpuClock::begin();
        busy(40);
        share(&whole.helpers);
        assert!((0.12..0.15).contains(&whole.seconds()), "{}", whole.seconds());
        let inside = rayon::scope(|_| {
            let clock = CpuClock::begin();
            clock.helpers.help(|| busy(40));
            clock.seconds()
        });
        assert!((0.04..0.07).contains(&inside), "{inside}");
    }
}
