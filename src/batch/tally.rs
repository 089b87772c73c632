use super::{Outcome, Status};
use std::collections::BTreeMap;

/// How many assets are remembered of those that took longest.
const SLOWEST: usize = 3;
/// How many failures are remembered by name.
const FAILURES: usize = 20;
/// How many assets are remembered for each kind of warning.
const EXAMPLES: usize = 3;

/// What became of a batch, in a size that does not grow with it.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    counts: BTreeMap<&'static str, usize>,
    /// Assets that were up to date.
    pub kept: usize,
    /// Picture files.
    pub files: usize,
    /// The assets that took longest, with their seconds, in descending order.
    pub slowest: Vec<(String, f64)>,
    /// The first assets that failed, with the cause.
    pub failures: Vec<(String, String)>,
    /// Warnings by code.
    pub warnings: BTreeMap<String, Warned>,
    /// Whether the disk was full.
    pub disk_full: bool,
}

/// Assets with a warning of one kind.
#[derive(Clone, Debug, Default)]
pub struct Warned {
    /// How many there are.
    pub assets: usize,
    /// The first of them.
    pub examples: Vec<String>,
}

impl Tally {
    /// Of these outcomes.
    pub fn of(outcomes: &[Outcome]) -> Self {
        let mut tally = Self::default();
        outcomes.iter().for_each(|outcome| tally.add(outcome, false));
        tally
    }

    /// Counts an asset; `kept`: it was up to date.
    pub fn add(&mut self, outcome: &Outcome, kept: bool) {
        *self.counts.entry(outcome.status.word()).or_default() += 1;
        self.kept += usize::from(kept);
        self.files += outcome.outputs.len();
        if outcome.status.is_done() && !kept {
            let place = self.slowest.partition_point(|(_, seconds)| *seconds >= outcome.seconds.total);
            if place < SLOWEST {
                self.slowest.insert(place, (outcome.input.clone(), outcome.seconds.total));
                self.slowest.truncate(SLOWEST);
            }
        }
        if outcome.status == Status::Failed && self.failures.len() < FAILURES {
            self.failures.push((outcome.input.clone(), outcome.error_message.clone().unwrap_or_default()));
        }
        self.disk_full |= outcome.error_code.as_deref() == Some(super::failure::DISK_FULL);
        let mut codes: Vec<&str> = outcome.warnings.iter().map(|w| w.code.as_str()).collect();
        codes.sort_unstable();
        codes.dedup();
        for code in codes {
            let warned = self.warnings.entry(code.to_owned()).or_default();
            warned.assets += 1;
            if warned.examples.len() < EXAMPLES {
                warned.examples.push(outcome.input.clone());
            }
        }
    }

    /// Counts assets that were not begun.
    pub fn skip(&mut self, count: usize) {
        if count > 0 {
            *self.counts.entry(Status::Skipped.word()).or_default() += count;
        }
    }

    /// How many fared so.
    pub fn count(&self, status: Status) -> usize {
        self.counts.get(status.word()).copied().unwrap_or(0)
    }

    /// How many there are.
    pub fn all(&self) -> usize {
        self.counts.values().sum()
    }

    /// How many have every picture that was asked for.
    pub fn done(&self) -> usize {
        self.count(Status::Ok) + self.count(Status::Warned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_are_kept_in_order() {
        let mut tally = Tally::default();
        for (name, seconds) in [("a", 1.0), ("b", 5.0), ("c", 3.0), ("d", 4.0), ("e", 0.5)] {
            let mut outcome = Outcome { status: Status::Ok, ..Outcome::skipped(name, 0) };
            outcome.seconds.total = seconds;
            tally.add(&outcome, false);
        }
        let names: Vec<&str> = tally.slowest.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!((names, tally.all(), tally.done()), (vec!["b", "d", "c"], 5, 5));
    }
}
