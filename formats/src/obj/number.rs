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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Plain {
    pub(super) count: usize,
    /// As many as `count` says.
    pub(super) values: [f64; 6],
}

/// Powers of ten that `f64` has exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Reads a line of up to six decimal numbers and nothing else, as nearly all are, from `at` on; gives where the next line begins. `None` for
/// any other, sound ones included, and for one that ends with the text.
#[inline]
pub(super) fn plain_decimals(bytes: &[u8], mut at: usize) -> Option<(Plain, usize)> {
    let mut plain = Plain::default();
    loop {
        let byte = *bytes.get(at)?;
        if is_blank(byte) {
            at += 1;
        } else if byte == b'\n' {
            return Some((plain, at + 1));
        } else {
            *plain.values.get_mut(plain.count)? = plain_decimal(bytes, &mut at)?;
            plain.count += 1;
        }
    }
}

#[inline]
fn plain_decimal(bytes: &[u8], at: &mut usize) -> Option<f64> {
    let start = *at;
    let negative = bytes.get(start) == Some(&b'-');
    *at += usize::from(negative);
    let mut mantissa = 0;
    let before = plain_digits(bytes, at, &mut mantissa);
    let mut after = 0;
    if bytes.get(*at) == Some(&b'.') {
        *at += 1;
        after = plain_digits(bytes, at, &mut mantissa);
    }
    let ends = bytes.get(*at).is_some_and(|b| is_blank(*b) || *b == b'\n');
    if !ends || !(1..=19).contains(&(before + after)) || mantissa >= 1 << 53 {
        return long_decimal(bytes, start, at);
    }
    // Both are exact, so the quotient is rounded once (Clinger 1990).
    let value = mantissa as f64 / POWERS.get(after)?;
    Some(if negative { -value } else { value })
}

/// A decimal number that is not short, after which `at` stands.
#[cold]
fn long_decimal(bytes: &[u8], start: usize, at: &mut usize) -> Option<f64> {
    let word = bytes.get(start..)?;
    let length = word.iter().position(|b| is_blank(*b) || *b == b'\n')?;
    *at = start + length;
    value(word.get(..length)?)
}

#[inline]
fn plain_digits(bytes: &[u8], at: &mut usize, mantissa: &mut u64) -> usize {
    let start = *at;
    while let Some(digit @ b'0'..=b'9') = bytes.get(*at) {
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
        *at += 1;
    }
    *at - start
}

/// A positive whole number of at most nine digits, after which `at` stands.
#[inline]
fn plain_index(bytes: &[u8], at: &mut usize) -> Option<u32> {
    let start = *at;
    let mut value = 0_u32;
    while let Some(digit @ b'0'..=b'9') = bytes.get(*at) {
        value = value.wrapping_mul(10).wrapping_add(u32::from(digit - b'0'));
        *at += 1;
    }
    (value > 0 && *at - start <= 9).then_some(value)
}

/// Reads a line of corners that are nothing but positive indices, as nearly all are, from `at` on: calls `corner` with each, 0 for an
/// index that it lacks, and gives where the next line begins. `None` for any other line, sound ones included, for one that ends with the
/// text, or when `corner` says so.
#[inline]
pub(super) fn plain_corners(bytes: &[u8], mut at: usize, mut corner: impl FnMut([u32; 3]) -> bool) -> Option<usize> {
    loop {
        let byte = *bytes.get(at)?;
        if is_blank(byte) {
            at += 1;
            continue;
        }
        if byte == b'\n' {
            return Some(at + 1);
        }
        let mut indices = [plain_index(bytes, &mut at)?, 0, 0];
        if bytes.get(at) == Some(&b'/') {
            at += 1;
            if bytes.get(at) != Some(&b'/') {
                indices[1] = plain_index(bytes, &mut at)?;
            }
            if bytes.get(at) == Some(&b'/') {
                at += 1;
                indices[2] = plain_index(bytes, &mut at)?;
            }
        }
        if !bytes.get(at).is_some_and(|b| is_blank(*b) || *b == b'\n') || !corner(indices) {
            return None;
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
        let read = |line: &str| {
            let (plain, end) = plain_decimals(line.as_bytes(), 0)?;
            Some((plain.values[..plain.count].to_vec(), end))
        };
        assert_eq!(read(" 1 -2.5\t.5 7. \r\nv 1"), Some((vec![1.0, -2.5, 0.5, 7.0], 16)));
        assert_eq!(read("\n"), Some((vec![], 1)));
        assert_eq!(read("-0\n").map(|(values, _)| values[0].to_bits()), Some((-0.0_f64).to_bits()));
        for other in ["1", "1 2 #3\n", "-\n", ".\n", "1.2.3\n", "1,5\n", "nan\n", "1 2x\n", "1 2 3 4 5 6 7\n", "1e31\n"]
        {
            assert_eq!(read(other), None, "{other}");
        }
        let all = |text: &str| {
            let mut seen = Vec::new();
            let end = plain_corners(text.as_bytes(), 0, |corner| {
                seen.push(corner);
                true
            });
            end.map(|end| (seen, end))
        };
        assert_eq!(all(" 1 2/3  4//5 6/7/8\r\nf"), Some((vec![[1, 0, 0], [2, 3, 0], [4, 0, 5], [6, 7, 8]], 20)));
        for other in ["1/", "1//", "0 1 2", "-1 -2 -3", "1/0/1", "1/2/3/4", "1 2 3 # end", "1234567890", "1/ /2", "+1"]
        {
            assert_eq!(all(&format!("{other}\n")), None, "{other}");
        }
    }

    #[test]
    fn plain_numbers_are_rounded_as_rust_rounds_them() {
        let mut state = 1_u64;
        for round in 0..200_000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let (digits, point) = (1 + (state >> 33) % 21, (state >> 45) % 22);
            let mut word: String = (0..digits).map(|k| char::from(b'0' + (state >> (k * 3) & 7) as u8)).collect();
            if (point as usize) < word.len() {
                word.insert(point as usize, '.');
            }
            if round % 2 == 0 {
                word.insert(0, '-');
            }
            let want: f64 = word.parse().unwrap();
            let (plain, _) = plain_decimals(format!("{word}\n").as_bytes(), 0).unwrap();
            assert_eq!(plain.values[0].to_bits(), want.to_bits(), "{word}");
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
