//! How long threads of this process have waited for a processor while they could have run: other work on the machine, and now and then each
//! other (Linux: `/proc/self/task/*/schedstat`).

use std::collections::BTreeMap;
use std::fs;

/// Nanoseconds on a processor, and of waiting for one, of each thread so far.
#[derive(Clone, Debug, Default)]
pub struct Waiting(BTreeMap<String, [u64; 2]>);

impl Waiting {
    /// Up to now; `None` where the system does not tell.
    pub fn now() -> Option<Self> {
        let mut threads = BTreeMap::new();
        for entry in fs::read_dir("/proc/self/task").ok()?.flatten() {
            // A thread may have ended meanwhile.
            let Ok(text) = fs::read_to_string(entry.path().join("schedstat")) else { continue };
            if let Some(times) = parse(&text) {
                threads.insert(entry.file_name().to_string_lossy().into_owned(), times);
            }
        }
        (!threads.is_empty()).then_some(Self(threads))
    }

    /// Seconds of waiting for each second on a processor since then. Threads that have ended do not count.
    pub fn per_second_since(&self, earlier: &Self) -> Option<f64> {
        let mut sums = [0, 0];
        for (thread, times) in &self.0 {
            let before = earlier.0.get(thread).copied().unwrap_or([0, 0]);
            (0..2).for_each(|k| sums[k] += times[k].saturating_sub(before[k]));
        }
        (sums[0] > 0).then(|| sums[1] as f64 / sums[0] as f64)
    }
}

fn parse(text: &str) -> Option<[u64; 2]> {
    let mut words = text.split_whitespace().map(|word| word.parse().ok());
    Some([words.next()??, words.next()??])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(threads: &[(&str, [u64; 2])]) -> Waiting {
        Waiting(threads.iter().map(|(name, times)| ((*name).to_owned(), *times)).collect())
    }

    #[test]
    fn what_threads_waited_is_told_by_what_they_ran() {
        let before = at(&[("1", [1000, 50]), ("2", [500, 0]), ("gone", [9, 9])]);
        let after = at(&[("1", [3000, 550]), ("2", [1500, 500]), ("new", [1000, 1000])]);
        assert_eq!(after.per_second_since(&before), Some(0.5));
        assert_eq!(before.per_second_since(&before), None);
        assert_eq!(parse("12 34 5\n"), Some([12, 34]));
        assert_eq!((parse(""), parse("12"), parse("a b")), (None, None, None));
    }
}
