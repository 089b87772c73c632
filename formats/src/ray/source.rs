use crate::{ErrorCode, ImportError, Place};

/// An offset in bytes from the beginning of the text. Lines are counted only when a message needs one.
pub(super) type Offset = usize;

/// A value with the place where it stands.
#[derive(Clone, Debug)]
pub(super) struct At<T> {
    pub at: Offset,
    pub value: T,
}

/// The text of a scene file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub bytes: &'a [u8],
}

impl Source<'_> {
    /// The line of an offset, from 1.
    pub fn line(&self, at: Offset) -> u32 {
        let before = &self.bytes[..at.min(self.bytes.len())];
        1 + u32::try_from(before.iter().filter(|b| **b == b'\n').count()).unwrap_or(u32::MAX - 1)
    }

    /// Line and column of an offset. Columns count characters: UTF-8's continuation bytes are skipped.
    pub fn place(&self, at: Offset) -> Place {
        let before = &self.bytes[..at.min(self.bytes.len())];
        let begin = before.iter().rposition(|b| *b == b'\n').map_or(0, |newline| newline + 1);
        let characters = before[begin..].iter().filter(|b| **b & 0xC0 != 0x80).count();
        Place::Text { line: self.line(at), column: 1 + u32::try_from(characters).unwrap_or(u32::MAX - 1) }
    }

    /// An error at an offset.
    pub fn error(&self, code: ErrorCode, at: Offset, message: impl Into<String>) -> ImportError {
        ImportError::new(code, message).at(self.place(at))
    }

    /// A piece of the text for a message, cut when it is long.
    pub fn excerpt(&self, start: Offset, end: Offset) -> String {
        const LONGEST: usize = 40;
        let piece = self.bytes.get(start..end).unwrap_or_default();
        let cut = &piece[..piece.len().min(LONGEST)];
        let dots = if cut.len() < piece.len() { "…" } else { "" };
        format!("{}{dots}", String::from_utf8_lossy(cut))
    }
}
