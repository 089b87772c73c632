//! Work on several things at a time.

use crate::Control;
use cpu_time::ThreadTime;
use rayon::prelude::*;
use std::cmp::Reverse;

/// What `one` makes of each item, in their order, on the current rayon pool. `control` is told of the CPU time of the pool's threads.
pub fn map<T: Sync, R: Send>(items: &[T], control: &Control, one: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let clock = Clock::of(control);
    items.par_iter().with_max_len(1).map(|item| clock.time(|| one(item))).collect()
}

/// As [`map`], but threads take those that cost most first: one that takes long then does not keep all waiting in the end.
pub fn map_costly<T: Sync, R: Send>(
    items: &[T],
    control: &Control,
    cost: impl Fn(&T) -> usize,
    one: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let clock = Clock::of(control);
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|i| Reverse(cost(&items[*i])));
    let made = order.into_iter().par_bridge().map(|i| (i, clock.time(|| one(&items[i]))));
    let mut made: Vec<(usize, R)> = made.collect();
    made.sort_unstable_by_key(|(i, _)| *i);
    made.into_iter().map(|(_, made)| made).collect()
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
    use std::sync::Mutex;
    use std::time::{Duration, Instant};

    #[test]
    fn what_costs_most_comes_first_and_the_order_stays() {
        let begun = Mutex::new(Vec::new());
        let one = |item: &usize| {
            begun.lock().expect("whole").push(*item);
            item * 10
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        let made = pool.install(|| map_costly(&[2, 7, 1, 7, 5], &Control::default(), |item| *item, one));
        assert_eq!(made, [20, 70, 10, 70, 50]);
        assert_eq!(begun.into_inner().expect("whole"), [7, 7, 5, 2, 1]);
        assert!(map_costly(&[], &Control::default(), |item: &usize| *item, |item| *item).is_empty());
    }

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
