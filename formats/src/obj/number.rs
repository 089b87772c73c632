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

/// Numbers that need no second look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Plain {
    pub(super) count: u32,
    /// Whether any is not zero.
    pub(super) not_zero: bool,
}

/// Takes operands that are nothing but short decimal numbers without exponents, as nearly all are; `None` for any others,
/// sound ones included.
pub(super) fn plain_decimals(operands: &str) -> Option<Plain> {
    let bytes = operands.as_bytes();
    let mut plain = Plain::default();
    let mut at = 0;
    loop {
        while bytes.get(at).is_some_and(|b| is_blank(*b)) {
            at += 1;
        }
        if at == bytes.len() {
            return Some(plain);
        }
        if matches!(bytes.get(at), Some(b'-')) {
            at += 1;
        }
        let before = plain_digits(bytes, &mut at, &mut plain.not_zero);
        let mut after = 0;
        if bytes.get(at) == Some(&b'.') {
            at += 1;
            after = plain_digits(bytes, &mut at, &mut plain.not_zero);
        }
        let ends = bytes.get(at).is_none_or(|b| is_blank(*b));
        if !ends || !(1..=30).contains(&(before + after)) {
            return None;
        }
        plain.count += 1;
    }
}

#[inline]
fn plain_digits(bytes: &[u8], at: &mut usize, not_zero: &mut bool) -> usize {
    let start = *at;
    while let Some(digit @ b'0'..=b'9') = bytes.get(*at) {
        *not_zero |= *digit != b'0';
        *at += 1;
    }
    *at - start
}

/// A positive whole number of at most nine digits, after which `at` stands.
#[inline]
fn plain_index(bytes: &[u8], at: &mut usize) -> Option<u32> {
    let start = *at;
    let mut value = 0;
    while let Some(digit @ b'0'..=b'9') = bytes.get(*at) {
        if *at - start == 9 {
            return None;
        }
        value = value * 10 + u32::from(digit - b'0');
        *at += 1;
    }
    (value > 0).then_some(value)
}

/// Takes the corners of a face that are nothing but positive indices, as nearly all are: calls `corner` with each, 0 for an
/// index that it lacks. False for any others, sound ones included, or when `corner` says so.
pub(super) fn plain_corners(corners: &str, mut corner: impl FnMut([u32; 3]) -> bool) -> bool {
    let bytes = corners.as_bytes();
    let mut at = 0;
    loop {
        while bytes.get(at).is_some_and(|b| is_blank(*b)) {
            at += 1;
        }
        if at == bytes.len() {
            return true;
        }
        let Some(position) = plain_index(bytes, &mut at) else { return false };
        let mut indices = [position, 0, 0];
        if bytes.get(at) == Some(&b'/') {
            at += 1;
            if bytes.get(at) != Some(&b'/') {
                let Some(texcoord) = plain_index(bytes, &mut at) else { return false };
                indices[1] = texcoord;
            }
            if bytes.get(at) == Some(&b'/') {
                at += 1;
                let Some(normal) = plain_index(bytes, &mut at) else { return false };
                indices[2] = normal;
            }
        }
        if !bytes.get(at).is_none_or(|b| is_blank(*b)) || !corner(indices) {
            return false;
        }
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
    fn plain_numbers_are_some_of_the_sound_ones() {
        let plain = |count, not_zero| Some(Plain { count, not_zero });
        assert_eq!(plain_decimals(" 1 -2.5\t.5 7. \r"), plain(4, true));
        assert_eq!(plain_decimals(" 0 -0.0 000"), plain(3, false));
        assert_eq!(plain_decimals(""), plain(0, false));
        for other in ["1e5", "+1", "1 2 #3", "-", ".", "1.2.3", "1,5", "nan", "1 2x", "1234567890123456789012345678901"]
        {
            assert_eq!(plain_decimals(other), None, "{other}");
        }
        let all = |text: &str| {
            let mut seen = Vec::new();
            let plain = plain_corners(text, |corner| {
                seen.push(corner);
                true
            });
            plain.then_some(seen)
        };
        assert_eq!(all(" 1 2/3  4//5 6/7/8\r"), Some(vec![[1, 0, 0], [2, 3, 0], [4, 0, 5], [6, 7, 8]]));
        for other in ["1/", "1//", "0 1 2", "-1 -2 -3", "1/0/1", "1/2/3/4", "1 2 3 # end", "1234567890", "1/ /2", "+1"]
        {
            assert_eq!(all(other), None, "{other}");
        }
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
