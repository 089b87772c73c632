//! Work on several things at a time.

use crate::Control;
use cpu_time::ThreadTime;
use rayon::prelude::*;

/// What `one` makes of each item, in their order, on the current rayon pool. `control` is told of the CPU time of the pool's threads.
pub fn map<T: Sync, R: Send>(items: &[T], control: &Control, one: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let clock = Clock::of(control);
    items.par_iter().with_max_len(1).map(|item| clock.time(|| one(item))).collect()
}

/// As [`map`], of items that are changed.
pub fn map_mut<T: Send, R: Send>(items: &mut [T], control: &Control, one: impl Fn(&mut T) -> R + Sync) -> Vec<R> {
    let clock = Clock::of(control);
    items.par_iter_mut().with_max_len(1).map(|item| clock.time(|| one(item))).collect()
}

struct Clock<'a> {
    control: &'a Control,
    /// Called from a thread of the pool, that thread works too, and whoever takes its time has it already.
    outside: bool,
}

impl<'a> Clock<'a> {
    fn of(control: &'a Control) -> Self {
        Self { control, outside: rayon::current_thread_index().is_none() }
    }

    fn time<R>(&self, one: impl FnOnce() -> R) -> R {
        let clock = ThreadTime::try_now().ok().filter(|_| self.outside);
        let made = one();
        if let Some(time) = clock.and_then(|clock| clock.try_elapsed().ok()) {
            self.control.add_helpers_cpu(time);
        }
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::hint::black_box;
    use std::time::{Duration, Instant};

    #[test]
    fn the_time_of_helpers_is_told() {
        let busy = |item: &u64| {
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(20) {
                black_box(item);
            }
            2 * item
        };
        let control = Control::default();
        assert_eq!(map(&[1, 2, 3], &control, busy), [2, 4, 6]);
        let told = control.helpers_cpu();
        assert!(told > Duration::ZERO && told < Duration::from_millis(200), "{told:?}");
        let inside = Control::default();
        rayon::scope(|_| drop(map(&[1, 2], &inside, busy)));
        assert_eq!(inside.helpers_cpu(), Duration::ZERO, "its caller's own");
    }
}
