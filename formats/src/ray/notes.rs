use super::source::{Offset, Source};
use crate::Warning;

/// Warnings of one code that are spelled out; the rest is only counted.
const SPELLED_OUT: usize = 16;

/// Collects warnings with their lines, and keeps a file with thousands of the same kind from flooding the list.
#[derive(Debug)]
pub(super) struct Notes<'a> {
    source: Source<'a>,
    warnings: &'a mut Vec<Warning>,
    counts: Vec<(&'static str, usize)>,
}

impl<'a> Notes<'a> {
    pub fn new(source: Source<'a>, warnings: &'a mut Vec<Warning>) -> Self {
        Self { source, warnings, counts: Vec::new() }
    }

    /// Warns about something at an offset.
    pub fn warn(&mut self, code: &'static str, at: Offset, message: impl FnOnce() -> String) {
        let index = self.counts.iter().position(|(known, _)| *known == code).unwrap_or_else(|| {
            self.counts.push((code, 0));
            self.counts.len() - 1
        });
        let count = &mut self.counts[index].1;
        *count += 1;
        if *count <= SPELLED_OUT {
            self.warnings.push(Warning::new(code, self.source.place(at), message()));
        }
    }

    /// Adds one line for each code with more warnings than were spelled out.
    pub fn finish(self) {
        for (code, count) in self.counts.into_iter().filter(|(_, count)| *count > SPELLED_OUT) {
            self.warnings.push(Warning::new(code, "", format!("and {} more of this kind", count - SPELLED_OUT)));
        }
    }
}
