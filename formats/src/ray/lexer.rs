use super::source::{Offset, Source};
use crate::{ErrorCode, ImportError};

/// What a token is. The text of words and strings stays in the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TokenKind {
    /// A letter or `_`, then letters, digits, `_` and `-`.
    Word,
    /// A string; the token's range lies between the quotes.
    Text,
    /// A finite number.
    Number(f64),
    /// One of `( ) { } , = ;`.
    Punct(u8),
    /// The end of the file.
    End,
}

/// A token and its range in the source.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token {
    pub kind: TokenKind,
    pub start: Offset,
    pub end: Offset,
}

/// Cuts the text into tokens, one at a time and without allocating.
#[derive(Debug)]
pub(super) struct Lexer<'a> {
    source: Source<'a>,
    position: Offset,
}

impl<'a> Lexer<'a> {
    /// Begins at the beginning, behind a byte order mark.
    pub fn new(source: Source<'a>) -> Self {
        let position = if source.bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
        Self { source, position }
    }

    fn peek(&self, ahead: usize) -> Option<u8> {
        self.source.bytes.get(self.position + ahead).copied()
    }

    /// Moves on while `keep` holds and gives the offset of the first byte where it does not.
    fn run(&mut self, keep: impl Fn(u8) -> bool) -> Offset {
        while self.peek(0).is_some_and(&keep) {
            self.position += 1;
        }
        self.position
    }

    /// Reads the next token.
    ///
    /// # Errors
    /// Unterminated strings and comments, malformed and infinite numbers, characters that begin no token.
    pub fn next(&mut self) -> Result<Token, ImportError> {
        self.skip_blanks()?;
        let start = self.position;
        let Some(first) = self.peek(0) else {
            return Ok(Token { kind: TokenKind::End, start, end: start });
        };
        match first {
            b'(' | b')' | b'{' | b'}' | b',' | b'=' | b';' => {
                self.position += 1;
                Ok(Token { kind: TokenKind::Punct(first), start, end: self.position })
            }
            b'0'..=b'9' | b'-' | b'+' | b'.' => self.number(start),
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                let end = self.run(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
                Ok(Token { kind: TokenKind::Word, start, end })
            }
            b'"' => self.text(start),
            _ => {
                let length = match first {
                    0xF0.. => 4,
                    0xE0.. => 3,
                    0xC0.. => 2,
                    _ => 1,
                };
                let character = self.source.excerpt(start, (start + length).min(self.source.bytes.len()));
                Err(self.source.error(ErrorCode::Syntax, start, format!("unexpected character `{character}`")))
            }
        }
    }

    fn skip_blanks(&mut self) -> Result<(), ImportError> {
        loop {
            // 11 is the vertical tab, which `is_ascii_whitespace` leaves out.
            self.run(|b| b.is_ascii_whitespace() || b == 11);
            match (self.peek(0), self.peek(1)) {
                (Some(b'/'), Some(b'/')) => {
                    self.run(|b| b != b'\n');
                }
                (Some(b'/'), Some(b'*')) => {
                    let start = self.position;
                    let body = self.source.bytes.get(start + 2..).unwrap_or_default();
                    let Some(length) = body.windows(2).position(|pair| pair == b"*/") else {
                        let message = "this comment is never closed by `*/`";
                        return Err(self.source.error(ErrorCode::Syntax, start, message));
                    };
                    self.position = start + 2 + length + 2;
                }
                _ => return Ok(()),
            }
        }
    }

    fn text(&mut self, quote: Offset) -> Result<Token, ImportError> {
        self.position += 1;
        let start = self.position;
        let end = self.run(|b| b != b'"' && b != b'\n');
        if self.peek(0) != Some(b'"') {
            let message = "this string is not closed by `\"` on its line";
            return Err(self.source.error(ErrorCode::Syntax, quote, message));
        }
        self.position += 1;
        Ok(Token { kind: TokenKind::Text, start, end })
    }

    /// The course's tokenizer hands whatever begins like a number to `atof`, which drops what it does not
    /// understand; here the whole run has to be one number.
    fn number(&mut self, start: Offset) -> Result<Token, ImportError> {
        let end = self.run(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'.' | b'+' | b'-'));
        let run = self.source.bytes.get(start..end).unwrap_or_default();
        let only_digits = run.iter().all(|b| matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-' | b'e' | b'E'));
        let value = std::str::from_utf8(run).ok().filter(|_| only_digits).and_then(|text| text.parse::<f64>().ok());
        let complaint = match value {
            Some(value) if value.is_finite() => return Ok(Token { kind: TokenKind::Number(value), start, end }),
            Some(_) => "is too large a number",
            None => "is not a number",
        };
        let message = format!("`{}` {complaint}", self.source.excerpt(start, end));
        Err(self.source.error(ErrorCode::Syntax, start, message))
    }
}
