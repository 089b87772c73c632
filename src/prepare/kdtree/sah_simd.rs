//! [`sah::choose`] compiled for the machine's vector instructions, and planes judged with them: the same numbers, sooner.
#![allow(unsafe_code)]

use super::bounds::Reference;
use super::judge::Plainly;
#[cfg(target_arch = "x86_64")]
use super::judge::{Judge, Judged, PLANES, Planes};
use super::sah;
use super::split::{Cell, Plane};
use crate::math::simd::SimdTier;
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// See [`sah::choose`]. `tier` may be above what the machine has.
pub fn choose(refs: &[Reference], cell: &Cell, tier: SimdTier) -> Option<Plane> {
    match tier.available() {
        // SAFETY: `available` has looked that the machine has the features.
        #[cfg(target_arch = "x86_64")]
        SimdTier::Avx512 => unsafe { choose_avx512(refs, cell) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        SimdTier::Avx2 => unsafe { choose_avx2(refs, cell) },
        _ => sah::choose(Plainly, refs, cell),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2")]
fn choose_avx512(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    sah::choose(Avx512(()), refs, cell)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn choose_avx2(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    sah::choose(Avx2(()), refs, cell)
}

/// Sixteen lanes; made in functions with the features only.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Avx512(());

/// Eight lanes; made in functions with the feature only.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Judge for Avx512 {
    #[inline(always)]
    fn judge(self, refs: &[Reference], stride: usize, planes: &Planes) -> Judged {
        let (inner, outer) = Planes::numbers(planes.axis);
        // SAFETY: the machine has the features, since `self` exists; loads and stores are of whole arrays of sixteen.
        unsafe {
            let at = _mm512_loadu_ps(planes.at.as_ptr());
            let far = _mm512_set1_ps(f32::INFINITY);
            let one = _mm512_set1_epi32(1);
            let (mut beyond, mut right) = (_mm512_setzero_si512(), _mm512_setzero_si512());
            let (mut up_to, mut from) = (far, far);
            let (mut left_ends, mut right_ends) = ([far; 4], [far; 4]);
            for reference in refs.iter().step_by(stride) {
                let (upper, lower) = (_mm512_set1_ps(reference.0[inner[0]]), _mm512_set1_ps(reference.0[inner[1]]));
                let is_right = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(_mm512_set1_ps(-reference.0[inner[0]]), at);
                let is_beyond = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(is_right, lower, at);
                let is_left = !is_beyond;
                beyond = _mm512_mask_add_epi32(beyond, is_beyond, beyond, one);
                right = _mm512_mask_add_epi32(right, is_right, right, one);
                up_to = _mm512_mask_min_ps(up_to, is_left, upper, up_to);
                from = _mm512_mask_min_ps(from, is_right, lower, from);
                for k in 0..4 {
                    let end = _mm512_set1_ps(reference.0[outer[k]]);
                    left_ends[k] = _mm512_mask_min_ps(left_ends[k], is_left, end, left_ends[k]);
                    right_ends[k] = _mm512_mask_min_ps(right_ends[k], is_right, end, right_ends[k]);
                }
            }
            let mut out = Judged::default();
            _mm512_storeu_si512(out.beyond.as_mut_ptr().cast(), beyond);
            _mm512_storeu_si512(out.right.as_mut_ptr().cast(), right);
            _mm512_storeu_ps(out.inner[0].as_mut_ptr(), up_to);
            _mm512_storeu_ps(out.inner[1].as_mut_ptr(), from);
            for k in 0..4 {
                _mm512_storeu_ps(out.left_ends[k].as_mut_ptr(), left_ends[k]);
                _mm512_storeu_ps(out.right_ends[k].as_mut_ptr(), right_ends[k]);
            }
            out
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Judge for Avx2 {
    #[inline(always)]
    fn judge(self, refs: &[Reference], stride: usize, planes: &Planes) -> Judged {
        let (inner, outer) = Planes::numbers(planes.axis);
        let mut out = Judged::default();
        for half in [0, PLANES / 2] {
            // SAFETY: the machine has the features, since `self` exists; loads and stores are of half an array of sixteen,
            // from its beginning or its middle.
            unsafe {
                let at = _mm256_loadu_ps(planes.at.as_ptr().add(half));
                let far = _mm256_set1_ps(f32::INFINITY);
                let (mut beyond, mut right) = (_mm256_setzero_si256(), _mm256_setzero_si256());
                let (mut up_to, mut from) = (far, far);
                let (mut left_ends, mut right_ends) = ([far; 4], [far; 4]);
                for reference in refs.iter().step_by(stride) {
                    let (upper, lower) = (_mm256_set1_ps(reference.0[inner[0]]), _mm256_set1_ps(reference.0[inner[1]]));
                    let is_right = _mm256_cmp_ps::<_CMP_GT_OQ>(_mm256_set1_ps(-reference.0[inner[0]]), at);
                    let is_beyond = _mm256_and_ps(is_right, _mm256_cmp_ps::<_CMP_GE_OQ>(lower, at));
                    // Masks are -1 where they hold.
                    beyond = _mm256_sub_epi32(beyond, _mm256_castps_si256(is_beyond));
                    right = _mm256_sub_epi32(right, _mm256_castps_si256(is_right));
                    up_to = _mm256_min_ps(_mm256_blendv_ps(upper, far, is_beyond), up_to);
                    from = _mm256_min_ps(_mm256_blendv_ps(far, lower, is_right), from);
                    for k in 0..4 {
                        let end = _mm256_set1_ps(reference.0[outer[k]]);
                        left_ends[k] = _mm256_min_ps(_mm256_blendv_ps(end, far, is_beyond), left_ends[k]);
                        right_ends[k] = _mm256_min_ps(_mm256_blendv_ps(far, end, is_right), right_ends[k]);
                    }
                }
                _mm256_storeu_si256(out.beyond.as_mut_ptr().add(half).cast(), beyond);
                _mm256_storeu_si256(out.right.as_mut_ptr().add(half).cast(), right);
                _mm256_storeu_ps(out.inner[0].as_mut_ptr().add(half), up_to);
                _mm256_storeu_ps(out.inner[1].as_mut_ptr().add(half), from);
                for k in 0..4 {
                    _mm256_storeu_ps(out.left_ends[k].as_mut_ptr().add(half), left_ends[k]);
                    _mm256_storeu_ps(out.right_ends[k].as_mut_ptr().add(half), right_ends[k]);
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;

    #[test]
    fn every_tier_chooses_the_same_planes() {
        let coordinate = |i: u32| ((i.wrapping_mul(2_654_435_761) >> 8) as f32) / 16_777_216.0;
        for n in [17u32, 40, 100, 300, 3000, 9000] {
            // Some are flat and lie exactly on planes between the others.
            let reference = |i: u32| {
                let lo = [0, 1, 2].map(|axis| coordinate(3 * i + axis));
                let lo = if i.is_multiple_of(3) { lo.map(|x| (x * 16.0).floor() / 16.0) } else { lo };
                let size = if i.is_multiple_of(3) { 0.0 } else { 0.1 * coordinate(i + 77) };
                Bounds::new(lo, lo.map(|x| x + size)).of_triangle(i, 0.0)
            };
            let refs: Vec<Reference> = (0..n).map(reference).collect();
            let cell = Cell { bounds: Bounds::around(&refs), triangles: refs.len(), depth: 0, budget: 10_000, path: 1 };
            let plain = choose(&refs, &cell, SimdTier::Scalar);
            assert!(plain.is_some());
            assert_eq!(plain, choose(&refs, &cell, SimdTier::Avx2));
            assert_eq!(plain, choose(&refs, &cell, SimdTier::Avx512));
        }
    }
}
