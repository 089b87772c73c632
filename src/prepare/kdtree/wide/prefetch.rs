//! Hints to the cache.
#![allow(unsafe_code)]

/// Bytes of a cache line.
const LINE: usize = 64;

/// Has the cache line fetched in which something begins.
#[inline(always)]
pub fn line<T>(what: &T) {
    lines::<1, T>(what);
}

/// Has so many cache lines fetched, from the one in which something begins. It need not be that long.
#[inline(always)]
pub fn lines<const N: usize, T>(what: &T) {
    #[cfg(target_arch = "x86_64")]
    for k in 0..N {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let address = std::ptr::from_ref(what).cast::<i8>().wrapping_add(k * LINE);
        // SAFETY: a prefetch never faults, whatever the address, and SSE is in every x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(address) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (what, LINE);
}
