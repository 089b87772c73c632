//! Bytes of any encoding to lines of text.

use crate::{ErrorCode, ImportError};

/// The text of a file in UTF-8 (bytes that are none count as Latin-1) or UTF-16 (with a byte order mark, or told by
/// its zeros), with `\n` at the ends of all its lines, or `\r\n`.
pub(super) fn decode(bytes: Vec<u8>) -> Result<String, ImportError> {
    let utf16 = match bytes.as_slice() {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        [a, 0, b, 0, ..] if *a != 0 && *b != 0 => Some(u16::from_le_bytes as fn([u8; 2]) -> u16),
        [0, a, 0, b, ..] if *a != 0 && *b != 0 => Some(u16::from_be_bytes as fn([u8; 2]) -> u16),
        _ => None,
    };
    let mut text = match utf16 {
        Some(unit) => {
            let units = bytes.chunks_exact(2).filter_map(|pair| Some(unit(pair.try_into().ok()?)));
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
        }
        None => String::from_utf8(bytes).unwrap_or_else(|e| latin1_where_invalid(e.as_bytes())),
    };
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    let head = text.as_bytes().get(..64 << 10).unwrap_or(text.as_bytes());
    let control = head.iter().filter(|b| b.is_ascii_control() && !(b'\t'..=b'\r').contains(*b)).count();
    if control * 50 > head.len() {
        return Err(ImportError::new(ErrorCode::Syntax, "is binary data, not the text of an OBJ file"));
    }
    // The lines of classic Mac OS.
    if !text.contains('\n') && text.contains('\r') {
        text = text.replace('\r', "\n");
    }
    // So that the last statement is as good as any other.
    if !text.is_empty() && !text.ends_with('\n') {
        text.reserve_exact(1);
        text.push('\n');
    }
    Ok(text)
}

fn latin1_where_invalid(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|b| char::from(*b)));
    }
    text
}

/// Gives the lines with their numbers from 1, those that end in `\` joined with the next.
pub(super) struct Lines<'a> {
    rest: &'a str,
    number: u32,
    joined: String,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text, number: 0, joined: String::new() }
    }

    /// What is not yet given.
    pub(super) fn rest(&self) -> &'a str {
        self.rest
    }

    /// Passes over the next physical line, which has `length` bytes with its end.
    pub(super) fn skip_line(&mut self, length: usize) {
        self.number = self.number.saturating_add(1);
        self.rest = self.rest.get(length..).unwrap_or_default();
    }

    fn physical(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        self.number = self.number.saturating_add(1);
        let end = memchr::memchr(b'\n', self.rest.as_bytes()).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at_checked(end)?;
        self.rest = rest.get(1..).unwrap_or_default();
        Some(line)
    }

    /// The next statement's line, with the number of its first physical line.
    pub(super) fn next(&mut self) -> Option<(u32, &str)> {
        let line = self.physical()?;
        let number = self.number;
        // A comment may end in a Windows folder: `# C:\models\`.
        let Some(mut part) = continued(line).filter(|l| !l.trim_start().starts_with('#')) else {
            return Some((number, line));
        };
        self.joined.clear();
        loop {
            self.joined.push_str(part);
            self.joined.push(' ');
            let Some(line) = self.physical() else { break };
            match continued(line) {
                Some(more) => part = more,
                None => {
                    self.joined.push_str(line);
                    break;
                }
            }
        }
        Some((number, &self.joined))
    }
}

/// The line without the `\` that continues it.
fn continued(line: &str) -> Option<&str> {
    line.strip_suffix('\\').or_else(|| line.strip_suffix("\\\r"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorCode;

    fn all(text: &str) -> Vec<(u32, String)> {
        let mut lines = Lines::new(text);
        std::iter::from_fn(|| lines.next().map(|(n, l)| (n, l.trim_end().to_owned()))).collect()
    }

    #[test]
    fn encodings() {
        let utf16 = |swap: bool, bom: &[u8]| {
            let unit = |u: u16| if swap { u.to_be_bytes() } else { u.to_le_bytes() };
            [bom.to_vec(), "v ü\n".encode_utf16().flat_map(unit).collect()].concat()
        };
        let cases = [
            "v ü\n".as_bytes().to_vec(),
            [b"\xef\xbb\xbf", "v ü\n".as_bytes()].concat(),
            b"v \xfc\n".to_vec(),
            utf16(false, b"\xff\xfe"),
            utf16(true, b"\xfe\xff"),
            utf16(false, b""),
            utf16(true, b""),
        ];
        for bytes in cases {
            assert_eq!(decode(bytes.clone()).unwrap(), "v ü\n", "{bytes:?}");
        }
    }

    #[test]
    fn binary_data_is_no_text() {
        let noise: Vec<u8> = (0..4096_u32).map(|i| (i.wrapping_mul(2654435761) >> 13) as u8).collect();
        assert_eq!(decode(noise).unwrap_err().code, ErrorCode::Syntax);
        assert_eq!(decode(vec![0; 100]).unwrap_err().code, ErrorCode::Syntax);
        assert!(decode(Vec::new()).unwrap().is_empty());
    }

    #[test]
    fn line_ends_and_continuations() {
        let want = [(1, "v 1".to_owned()), (2, "f 1  2  3".into()), (5, "# C:\\".into()), (6, "o x".into())];
        assert_eq!(all("v 1\nf 1 \\\n2 \\\n3\n# C:\\\no x"), want);
        assert_eq!(all("v 1\r\nf 1 \\\r\n2 \\\r\n3\r\n# C:\\\r\no x\r\n"), want);
        assert_eq!(all("f 1\\"), [(1, "f 1".to_owned())]);
        let mac = decode(b"v 1\rf 2".to_vec()).unwrap();
        assert_eq!(all(&mac), [(1, "v 1".to_owned()), (2, "f 2".into())]);
    }
}
