//! Memory that rays jump about in: begins at the border of a cache line, and large pieces ask for huge pages, since a
//! miss in the translation buffer costs as much as the work at a node.
#![allow(unsafe_code)]

/// A cache line in bytes.
const LINE: usize = 64;
/// A huge page in bytes.
const HUGE_PAGE: usize = 2 << 20;
/// A small page in bytes.
const PAGE: usize = 4096;

/// Words that begin at the border of a cache line, at first all zero.
#[derive(Debug, Default)]
pub struct AlignedWords {
    words: Vec<u32>,
    begin: usize,
    len: usize,
}

impl AlignedWords {
    /// `len` zeros.
    pub fn zeroed(len: usize) -> Self {
        let spare = LINE / size_of::<u32>();
        // Fresh zeroed memory is not touched, so that the advice comes in time.
        let words = vec![0u32; len + spare];
        advise(words.as_ptr().addr(), size_of_val(words.as_slice()));
        let begin = words.as_ptr().align_offset(LINE).min(spare);
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

/// The same items in memory that asks for huge pages.
pub fn settle<T: Clone>(items: &[T]) -> Vec<T> {
    let mut settled: Vec<T> = Vec::with_capacity(items.len());
    advise(settled.as_ptr().addr(), size_of_val(items));
    settled.extend_from_slice(items);
    settled
}

/// Asks the system to back memory with huge pages where there are whole ones; it may decline.
#[cfg(target_os = "linux")]
fn advise(begin: usize, bytes: usize) {
    use std::ffi::{c_int, c_void};
    const MADV_HUGEPAGE: c_int = 14;
    unsafe extern "C" {
        fn madvise(address: *mut c_void, length: usize, advice: c_int) -> c_int;
    }
    let first = begin.next_multiple_of(PAGE);
    let last = (begin + bytes) / PAGE * PAGE;
    if first < last && last - first >= 2 * HUGE_PAGE {
        // SAFETY: this advice never changes what memory holds, and the range is whole pages of one allocation.
        unsafe { madvise(first as *mut c_void, last - first, MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn advise(_begin: usize, _bytes: usize) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn begins_at_a_border_and_is_all_zero() {
        for len in [0, 1, 1000, 3 << 20] {
            let mut words = AlignedWords::zeroed(len);
            assert_eq!(words.as_slice().len(), len);
            assert!(words.as_slice().as_ptr().addr().is_multiple_of(LINE));
            assert!(words.as_slice().iter().all(|&w| w == 0));
            words.as_mut_slice().fill(7);
            assert!(settle(words.as_slice()).iter().all(|&w| w == 7));
        }
    }
}
