use crate::Warning;
use std::collections::BTreeMap;
use std::fmt::Display;

/// How many warnings of one kind are told one by one.
const TOLD: u64 = 8;

/// Collects warnings and keeps a file with a million faults from giving a million of them.
pub(super) struct Log<'a> {
    warnings: &'a mut Vec<Warning>,
    counts: BTreeMap<&'static str, u64>,
}

impl<'a> Log<'a> {
    pub(super) fn new(warnings: &'a mut Vec<Warning>) -> Self {
        Self { warnings, counts: BTreeMap::new() }
    }

    pub(super) fn warn(&mut self, code: &'static str, place: impl Display, message: impl FnOnce() -> String) {
        let count = self.counts.entry(code).or_default();
        *count += 1;
        if *count <= TOLD {
            self.warnings.push(Warning::new(code, place, message()));
        }
    }

    /// Adds how many of each kind were left out.
    pub(super) fn finish(self) {
        for (code, count) in self.counts {
            if count > TOLD {
                self.warnings.push(Warning::new(code, "", format!("and {} more of this kind", count - TOLD)));
            }
        }
    }
}
