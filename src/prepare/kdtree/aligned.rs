//! Zeroed memory that begins at a page border, without unsafe code.

/// Words that begin at a multiple of the alignment; large ones at the border of a 2 MB page, so that the system may back
/// them with huge pages.
#[derive(Debug, Default)]
pub struct AlignedWords {
    words: Vec<u32>,
    begin: usize,
    len: usize,
}

/// A cache line.
const LINE: usize = 64;
/// A huge page.
const HUGE_PAGE: usize = 2 << 20;

impl AlignedWords {
    /// `len` zeros.
    pub fn zeroed(len: usize) -> Self {
        let alignment = if len * size_of::<u32>() >= 2 * HUGE_PAGE { HUGE_PAGE } else { LINE };
        let words = vec![0u32; len + alignment / size_of::<u32>()];
        let begin = words.as_ptr().align_offset(alignment).min(alignment / size_of::<u32>());
        Self { words, begin, len }
    }

    /// The words.
    #[inline(always)]
    pub fn as_slice(&self) -> &[u32] {
        &self.words[self.begin..self.begin + self.len]
    }

    /// The words, to be written.
    pub fn as_mut_slice(&mut self) -> &mut [u32] {
        &mut self.words[self.begin..self.begin + self.len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_at_a_border_and_is_all_zero() {
        for len in [0, 1, 1000, 3 << 20] {
            let words = AlignedWords::zeroed(len);
            assert_eq!(words.as_slice().len(), len);
            assert!(words.as_slice().as_ptr().addr().is_multiple_of(LINE));
            assert!(words.as_slice().iter().all(|&w| w == 0));
        }
    }
}
