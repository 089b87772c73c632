//! A text put together of runs of another and of bytes of its own.

use std::ops::Range;

/// Statements in their order, those that are passed on as they stand being borrowed from the file's text: a large file is
/// not copied.
#[derive(Debug, Default)]
pub(super) struct Pieces<'t> {
    text: &'t [u8],
    own: Vec<u8>,
    /// How much of `own` is in a run.
    placed: usize,
    runs: Vec<Run>,
}

#[derive(Debug)]
struct Run {
    borrowed: bool,
    range: Range<usize>,
}

impl<'t> Pieces<'t> {
    /// Nothing yet, of this text.
    pub(super) fn of(text: &'t str) -> Self {
        Self { text: text.as_bytes(), ..Self::default() }
    }

    /// Appends a range of the text.
    pub(super) fn borrow(&mut self, range: Range<usize>) {
        if self.placed < self.own.len() {
            self.runs.push(Run { borrowed: false, range: self.placed..self.own.len() });
            self.placed = self.own.len();
        }
        match self.runs.last_mut() {
            Some(last) if last.borrowed && last.range.end == range.start => last.range.end = range.end,
            _ => self.runs.push(Run { borrowed: true, range }),
        }
    }

    /// Takes what is appended otherwise. Nothing but its end may be changed.
    pub(super) fn own(&mut self) -> &mut Vec<u8> {
        &mut self.own
    }

    /// The runs in order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u8]> {
        let source = |run: &Run| if run.borrowed { self.text } else { self.own.as_slice() };
        let runs = self.runs.iter().filter_map(move |run| source(run).get(run.range.clone()));
        runs.chain(self.own.get(self.placed..).filter(|tail| !tail.is_empty()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_and_keep_their_order() {
        let mut pieces = Pieces::of("one\ntwo\nthree\n");
        pieces.borrow(0..4);
        pieces.borrow(4..8);
        pieces.own().extend_from_slice("2½\n".as_bytes());
        pieces.own().extend_from_slice("2¾\n".as_bytes());
        pieces.borrow(8..14);
        pieces.own().extend_from_slice(b"four\n");
        assert_eq!(pieces.runs.len(), 3);
        assert_eq!(pieces.iter().collect::<Vec<_>>().concat(), "one\ntwo\n2½\n2¾\nthree\nfour\n".as_bytes());
    }
}
