use crate::Warning;
use std::collections::BTreeMap;

/// How many warnings of one kind are listed; more are counted.
const LISTED_PER_CODE: usize = 16;

/// Gathers warnings, so that a file with a million equal flaws gives a short list.
pub(super) struct Report<'a> {
    warnings: &'a mut Vec<Warning>,
    seen: Seen,
}

/// How many warnings of each kind there have been.
pub(super) type Seen = BTreeMap<&'static str, usize>;

impl<'a> Report<'a> {
    pub(super) fn new(warnings: &'a mut Vec<Warning>) -> Self {
        Self::go_on(warnings, Seen::new())
    }

    /// Goes on with a report that has been interrupted.
    pub(super) fn go_on(warnings: &'a mut Vec<Warning>, seen: Seen) -> Self {
        Self { warnings, seen }
    }

    /// Interrupts the report.
    pub(super) fn interrupt(self) -> Seen {
        self.seen
    }

    /// Lists a warning at a JSON pointer.
    pub(super) fn warn(&mut self, code: &'static str, place: impl Into<String>, message: impl Into<String>) {
        let count = self.seen.entry(code).or_default();
        *count += 1;
        if *count <= LISTED_PER_CODE {
            self.warnings.push(Warning::new(code, place.into(), message));
        }
    }

    /// Lists a warning unless there is one of its kind already.
    pub(super) fn once(&mut self, code: &'static str, place: impl Into<String>, message: impl Into<String>) {
        if !self.seen.contains_key(code) {
            self.warn(code, place, message);
        }
    }

    /// Says how many warnings were only counted.
    pub(super) fn finish(self) {
        for (code, count) in self.seen {
            if count > LISTED_PER_CODE {
                let more = count - LISTED_PER_CODE;
                self.warnings.push(Warning::new(code, "", format!("and {more} more of this kind")));
            }
        }
    }
}
