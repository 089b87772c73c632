//! Words and numbers, checked without being converted.

/// Largest magnitude of a coordinate: sums and differences of a few stay finite in `f32`.
pub(super) const LARGEST: f64 = 1e30;

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\r' | 0x0b | 0x0c)
}

/// Splits a line at blanks; a word that begins with `#` ends it.
pub(super) struct Words<'a> {
    line: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(line: &'a str) -> Self {
        Self { line: line.as_bytes(), at: 0 }
    }

    /// Where the last word ended, in bytes.
    pub(super) fn end(&self) -> usize {
        self.at
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.line.get(self.at..)?;
        let start = rest.iter().position(|b| !is_blank(*b))?;
        let word = rest.get(start..)?;
        if word.first() == Some(&b'#') {
            return None;
        }
        let length = word.iter().position(|b| is_blank(*b)).unwrap_or(word.len());
        self.at += start + length;
        word.get(..length)
    }
}

/// What a word is that is a decimal number within ±[`LARGEST`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimal {
    Zero,
    NotZero,
}

/// Checks that a word is a decimal number, in the grammar of Rust's `f64` without its words for infinities and NaN.
pub(super) fn decimal(word: &[u8]) -> Option<Decimal> {
    let digits = match word {
        [b'+' | b'-', rest @ ..] => rest,
        _ => word,
    };
    let (mut count, mut points, mut not_zero, mut exponent) = (0_usize, 0, false, None);
    for (i, byte) in digits.iter().enumerate() {
        match byte {
            b'0' => count += 1,
            b'1'..=b'9' => (count, not_zero) = (count + 1, true),
            b'.' => points += 1,
            b'e' | b'E' => {
                exponent = Some(digits.get(i + 1..)?);
                break;
            }
            _ => return None,
        }
    }
    if count == 0 || points > 1 {
        return None;
    }
    if let Some(exponent) = exponent {
        let digits = match exponent {
            [b'+' | b'-', rest @ ..] => rest,
            _ => exponent,
        };
        if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
    }
    // Only these can be out of range.
    if exponent.is_some() || count > 30 {
        let value = convert(word)?;
        return (value.abs() <= LARGEST).then_some(if value == 0.0 { Decimal::Zero } else { Decimal::NotZero });
    }
    Some(if not_zero { Decimal::NotZero } else { Decimal::Zero })
}

fn convert(word: &[u8]) -> Option<f64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The value of a decimal number.
pub(super) fn value(word: &[u8]) -> Option<f64> {
    decimal(word)?;
    convert(word)
}

/// The value of an index with an optional sign; those that no file can mean are `i64::MIN`.
pub(super) fn index(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for digit in digits {
        let digit = i64::from(digit.wrapping_sub(b'0'));
        if digit > 9 {
            return None;
        }
        // Nothing of 2⁴⁸ can exist; beyond, the value need not be right, just large.
        value = if value < 1 << 48 { value * 10 + digit } else { value };
    }
    Some(match (value, negative) {
        (0, _) => i64::MIN,
        (value, true) => -value,
        (value, false) => value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_those_of_rust_without_words() {
        let good = [
            "0",
            "1",
            "-1",
            "+1",
            "1.",
            ".5",
            "-.5e1",
            "1e5",
            "1E+5",
            "1e-5",
            "007",
            "1e-400",
            "123456789012345678901234567890.5",
        ];
        for word in good {
            assert!(word.parse::<f64>().is_ok() && decimal(word.as_bytes()).is_some(), "{word}");
        }
        let bad = [
            "", ".", "-", "e5", "1e", "1e+", "1.2.3", "1,5", "nan", "-inf", "infinity", "1.#IND", "0x10", "1e31",
            "1e999", "--1", "1-2", "3.1+e2",
        ];
        for word in bad {
            assert_eq!(decimal(word.as_bytes()), None, "{word}");
        }
        assert_eq!(decimal(b"-0.000"), Some(Decimal::Zero));
        assert_eq!(decimal(b"0e5"), Some(Decimal::Zero));
        assert_eq!(decimal(b"0.001"), Some(Decimal::NotZero));
        assert_eq!(decimal(&[b'9'; 400]), None);
    }

    #[test]
    fn indices() {
        assert_eq!(index(b"12"), Some(12));
        assert_eq!(index(b"-3"), Some(-3));
        assert_eq!(index(b"+3"), Some(3));
        assert_eq!(index(b"0"), Some(i64::MIN));
        assert_eq!(index(b"-0"), Some(i64::MIN));
        assert_eq!(index(b""), None);
        assert_eq!(index(b"1.5"), None);
        assert!(index(&[b'9'; 100]).unwrap() > 1 << 40);
    }

    #[test]
    fn words_end_at_a_comment() {
        let line = "\t1  2\r#3 4";
        let mut words = Words::new(line);
        assert_eq!(words.by_ref().collect::<Vec<_>>(), [b"1".as_slice(), b"2"]);
        assert_eq!(&line[..words.end()], "\t1  2");
    }
}
