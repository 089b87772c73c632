//! Hints to the cache.
#![allow(unsafe_code)]

/// Bytes of a cache line.
const LINE: usize = 64;

/// Has so many cache lines fetched from an address on. There need not be anything.
#[inline(always)]
pub fn lines<const N: usize>(address: usize) {
    #[cfg(target_arch = "x86_64")]
    for k in 0..N {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let line = std::ptr::without_provenance::<i8>(address.wrapping_add(k * LINE));
        // SAFETY: a prefetch never faults, whatever the address, and SSE is in every x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (address, LINE);
}
