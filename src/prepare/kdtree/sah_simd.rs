//! [`sah::choose`] compiled for the machine's vector instructions: the same code, the same numbers, sooner.
#![allow(unsafe_code)]

use super::bounds::Reference;
use super::sah;
use super::split::{Cell, Plane};
use crate::math::simd::SimdTier;

/// See [`sah::choose`]. `tier` may be above what the machine has.
pub fn choose(refs: &[Reference], cell: &Cell, tier: SimdTier) -> Option<Plane> {
    #[cfg(target_arch = "x86_64")]
    if tier.available() >= SimdTier::Avx2 {
        // SAFETY: `available` has looked that the machine has AVX2.
        return unsafe { choose_avx2(refs, cell) };
    }
    let _ = tier;
    choose_plainly(refs, cell)
}

fn choose_plainly(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    sah::choose(refs, cell)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn choose_avx2(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    sah::choose(refs, cell)
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;

    #[test]
    fn every_tier_chooses_the_same_planes() {
        let coordinate = |i: u32| ((i.wrapping_mul(2_654_435_761) >> 8) as f32) / 16_777_216.0;
        for n in [17u32, 40, 100, 300, 3000, 9000] {
            let reference = |i: u32| {
                let lo = [0, 1, 2].map(|axis| coordinate(3 * i + axis));
                let size = 0.1 * coordinate(i + 77);
                Bounds::new(lo, lo.map(|x| x + size)).of_triangle(i, 0.0)
            };
            let refs: Vec<Reference> = (0..n).map(reference).collect();
            let cell = Cell { bounds: Bounds::around(&refs), depth: 0, budget: 10_000, path: 1 };
            let plain = choose(&refs, &cell, SimdTier::Scalar);
            assert!(plain.is_some());
            assert_eq!(plain, choose(&refs, &cell, SimdTier::Avx512));
        }
    }
}
