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

/// Has items fetched whose first bytes tell most, if there are any.
#[inline(always)]
pub fn items<T, const N: usize>(items: &[T], numbers: [usize; N]) {
    if !items.is_empty() {
        for number in numbers {
            lines::<1>(items.as_ptr().addr().wrapping_add(number.wrapping_mul(size_of::<T>())));
        }
    }
}
