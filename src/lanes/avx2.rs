//! Lanes in AVX2: two registers.
//!
//! Every method may use the instructions because its receiver, or the token, exists only on machines that have them: that
//! is the safety argument of each `unsafe` here, as the types cannot be made outside this file.
#![allow(unsafe_code)]

use super::operators::{mask_operator, operator};
use super::{Floats, LANES, Lanes, Mask, Words, Work};
use crate::math::simd::SimdTier;
use std::arch::x86_64::*;

/// Proof that the machine has AVX2 and BMI.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Floats256(__m256, __m256);

/// Sixteen `u32`.
#[derive(Clone, Copy, Debug)]
pub struct Words256(__m256i, __m256i);

/// Sixteen truths: all bits of a lane or none.
#[derive(Clone, Copy, Debug)]
pub struct Mask256(__m256, __m256);

impl Avx2 {
    /// The proof, on a machine that has it.
    pub fn new() -> Option<Self> {
        (SimdTier::detect() >= SimdTier::Avx2).then_some(Self(()))
    }

    /// Does the work with the instructions switched on.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { run_with_features(self, work) }
    }
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_with_features<W: Work>(lanes: Avx2, work: W) -> W::Output {
    work.run(lanes)
}

/// Both halves by the same instruction, which the receiver proves to be there.
macro_rules! both {
    ($type:ident, || $result:expr) => {
        // SAFETY: see the head of the file.
        unsafe { $type($result, $result) }
    };
    ($type:ident, |$($name:ident = $value:ident),*| $result:expr) => {
        // SAFETY: see the head of the file.
        unsafe {
            $type({ $(let $name = $value.0;)* $result }, { $(let $name = $value.1;)* $result })
        }
    };
}

impl Lanes for Avx2 {
    type M = Mask256;
    type F = Floats256;
    type U = Words256;

    #[inline(always)]
    fn splat(self, x: f32) -> Floats256 {
        both!(Floats256, || _mm256_set1_ps(x))
    }

    #[inline(always)]
    fn word(self, x: u32) -> Words256 {
        both!(Words256, || _mm256_set1_epi32(x as i32))
    }

    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Floats256 {
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe { Floats256(_mm256_loadu_ps(from.as_ptr()), _mm256_loadu_ps(from.as_ptr().add(8))) }
    }

    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Words256 {
        let p = from.as_ptr().cast::<__m256i>();
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe { Words256(_mm256_loadu_si256(p), _mm256_loadu_si256(p.add(1))) }
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> Mask256 {
        let bit = self.load_words(&std::array::from_fn(|i| 1 << i));
        let set = both!(Words256, |b = bit| _mm256_and_si256(b, _mm256_set1_epi32(bits as i32)));
        set.eq(bit)
    }

    #[inline(always)]
    fn gather(self, from: &[f32], at: Words256) -> Floats256 {
        let Some(last) = from.len().checked_sub(1) else { return self.splat(0.0) };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32));
        // SAFETY: all places are below the length and fit a signed number; otherwise see the head of the file.
        both!(Floats256, |a = at| _mm256_i32gather_ps::<4>(from.as_ptr(), a))
    }

    #[inline(always)]
    fn gather_words(self, from: &[u32], at: Words256) -> Words256 {
        let Some(last) = from.len().checked_sub(1) else { return self.word(0) };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32));
        // SAFETY: all places are below the length and fit a signed number; otherwise see the head of the file.
        both!(Words256, |a = at| _mm256_i32gather_epi32::<4>(from.as_ptr().cast(), a))
    }

    #[inline(always)]
    fn gather_four(self, from: &[f32], at: Words256) -> [Floats256; 4] {
        let Some(last) = from.len().checked_sub(4) else { return [self.splat(0.0); 4] };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32)).array();
        // SAFETY: from each place on there are four numbers; otherwise see the head of the file.
        let [low, high] = [0, 8].map(|first| unsafe { four_of_eight(from, &at, first) });
        std::array::from_fn(|k| Floats256(low[k], high[k]))
    }
}

/// Four numbers in a row from each of eight places, `at[first]` and its followers.
///
/// # Safety
/// `from` has them all.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
unsafe fn four_of_eight(from: &[f32], at: &[u32; LANES], first: usize) -> [__m256; 4] {
    // SAFETY: the caller says so.
    let four = |lane: usize| unsafe { _mm_loadu_ps(from.as_ptr().add(at[first + lane] as usize)) };
    // Every fourth lane's numbers side by side.
    let each = |k: usize| _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(four(k)), four(k + 4));
    let (a, b, c, d) = (each(0), each(1), each(2), each(3));
    let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
    let (ab_high, cd_high) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
    [
        _mm256_shuffle_ps::<0x44>(ab, cd),
        _mm256_shuffle_ps::<0xEE>(ab, cd),
        _mm256_shuffle_ps::<0x44>(ab_high, cd_high),
        _mm256_shuffle_ps::<0xEE>(ab_high, cd_high),
    ]
}

mask_operator!(Mask256, BitAnd, bitand, |a, b| both!(Mask256, |a = a, b = b| _mm256_and_ps(a, b)));
mask_operator!(Mask256, BitOr, bitor, |a, b| both!(Mask256, |a = a, b = b| _mm256_or_ps(a, b)));
mask_operator!(Mask256, BitXor, bitxor, |a, b| both!(Mask256, |a = a, b = b| _mm256_xor_ps(a, b)));

impl std::ops::Not for Mask256 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        both!(Mask256, |a = self| _mm256_xor_ps(a, _mm256_castsi256_ps(_mm256_set1_epi32(-1))))
    }
}

impl Mask for Mask256 {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: see the head of the file.
        unsafe { _mm256_movemask_ps(self.0) as u32 | (_mm256_movemask_ps(self.1) as u32) << 8 }
    }
}

operator!(Floats256, f32, Add, add, |a, b| both!(Floats256, |a = a, b = b| _mm256_add_ps(a, b)));
operator!(Floats256, f32, Sub, sub, |a, b| both!(Floats256, |a = a, b = b| _mm256_sub_ps(a, b)));
operator!(Floats256, f32, Mul, mul, |a, b| both!(Floats256, |a = a, b = b| _mm256_mul_ps(a, b)));
operator!(Floats256, f32, Div, div, |a, b| both!(Floats256, |a = a, b = b| _mm256_div_ps(a, b)));

impl std::ops::Neg for Floats256 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        both!(Floats256, |a = self| _mm256_xor_ps(a, _mm256_set1_ps(-0.0)))
    }
}

impl Floats for Floats256 {
    type Mask = Mask256;
    type Words = Words256;

    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        both!(Floats256, || _mm256_set1_ps(x))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        both!(Floats256, |a = self| _mm256_sqrt_ps(a))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        both!(Floats256, |a = self, b = other| _mm256_min_ps(a, b))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        both!(Floats256, |a = self, b = other| _mm256_max_ps(a, b))
    }

    #[inline(always)]
    fn estimate_mul_add(self, factor: Self, term: Self) -> Self {
        both!(Floats256, |a = self, b = factor, c = term| _mm256_fmadd_ps(a, b, c))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        both!(Floats256, |a = self| _mm256_andnot_ps(_mm256_set1_ps(-0.0), a))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        both!(Floats256, |a = self| _mm256_floor_ps(a))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask256 {
        both!(Mask256, |a = self, b = other| _mm256_cmp_ps::<_CMP_LT_OQ>(a, b))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask256 {
        both!(Mask256, |a = self, b = other| _mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask256 {
        both!(Mask256, |a = self, b = other| _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b))
    }

    #[inline(always)]
    fn select(mask: Mask256, yes: Self, no: Self) -> Self {
        both!(Floats256, |m = mask, a = yes, b = no| _mm256_blendv_ps(b, a, m))
    }

    #[inline(always)]
    fn to_bits(self) -> Words256 {
        both!(Words256, |a = self| _mm256_castps_si256(a))
    }

    #[inline(always)]
    fn truncate(self) -> Words256 {
        both!(Words256, |a = self| _mm256_cvttps_epi32(a))
    }

    #[inline(always)]
    fn compress(self, mask: Mask256) -> Self {
        self.to_bits().compress(mask).from_bits()
    }

    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        let mut all = [0.0; LANES];
        self.store(&mut all);
        all
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        let p = to.as_mut_ptr();
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe {
            _mm256_storeu_ps(p, self.0);
            _mm256_storeu_ps(p.add(8), self.1);
        }
    }
}

operator!(Words256, u32, Add, add, |a, b| both!(Words256, |a = a, b = b| _mm256_add_epi32(a, b)));
operator!(Words256, u32, Sub, sub, |a, b| both!(Words256, |a = a, b = b| _mm256_sub_epi32(a, b)));
operator!(Words256, u32, Mul, mul, |a, b| both!(Words256, |a = a, b = b| _mm256_mullo_epi32(a, b)));
operator!(Words256, u32, BitAnd, bitand, |a, b| both!(Words256, |a = a, b = b| _mm256_and_si256(a, b)));
operator!(Words256, u32, BitOr, bitor, |a, b| both!(Words256, |a = a, b = b| _mm256_or_si256(a, b)));
operator!(Words256, u32, BitXor, bitxor, |a, b| both!(Words256, |a = a, b = b| _mm256_xor_si256(a, b)));

impl Words for Words256 {
    type Mask = Mask256;
    type Floats = Floats256;

    #[inline(always)]
    fn fill(self, x: u32) -> Self {
        both!(Words256, || _mm256_set1_epi32(x as i32))
    }

    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        both!(Words256, |a = self| _mm256_sll_epi32(a, _mm_cvtsi32_si128(N as i32)))
    }

    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        both!(Words256, |a = self| _mm256_srl_epi32(a, _mm_cvtsi32_si128(N as i32)))
    }

    #[inline(always)]
    fn shr_by(self, bits: Self) -> Self {
        both!(Words256, |a = self, b = bits| _mm256_srlv_epi32(a, _mm256_and_si256(b, _mm256_set1_epi32(31))))
    }

    #[inline(always)]
    fn reverse_bits(self) -> Self {
        // Bytes into the opposite order, then half bytes by table.
        both!(Words256, |a = self| {
            let bytes = _mm256_broadcastsi128_si256(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
            let table = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
            let high = _mm256_broadcastsi128_si256(_mm_slli_epi32::<4>(table));
            let low = _mm256_broadcastsi128_si256(table);
            let nibble = _mm256_set1_epi8(15);
            let x = _mm256_shuffle_epi8(a, bytes);
            let lower = _mm256_shuffle_epi8(high, _mm256_and_si256(x, nibble));
            let upper = _mm256_shuffle_epi8(low, _mm256_and_si256(_mm256_srli_epi32::<4>(x), nibble));
            _mm256_or_si256(lower, upper)
        })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        both!(Words256, |a = self, b = other| _mm256_min_epu32(a, b))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask256 {
        both!(Mask256, |a = self, b = other| _mm256_castsi256_ps(_mm256_cmpeq_epi32(a, b)))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask256 {
        // There is only a signed comparison.
        let (a, b) = (self ^ 0x8000_0000, other ^ 0x8000_0000);
        both!(Mask256, |a = a, b = b| _mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a)))
    }

    #[inline(always)]
    fn select(mask: Mask256, yes: Self, no: Self) -> Self {
        both!(Words256, |m = mask, a = yes, b = no| _mm256_castps_si256(_mm256_blendv_ps(
            _mm256_castsi256_ps(b),
            _mm256_castsi256_ps(a),
            m
        )))
    }

    #[inline(always)]
    fn from_bits(self) -> Floats256 {
        both!(Floats256, |a = self| _mm256_castsi256_ps(a))
    }

    #[inline(always)]
    fn to_floats(self) -> Floats256 {
        both!(Floats256, |a = self| _mm256_cvtepi32_ps(a))
    }

    #[inline(always)]
    fn compress(self, mask: Mask256) -> Self {
        let bits = mask.bits() as usize;
        let (first, second) = (bits & 0xFF, bits >> 8);
        let mut all = [0u32; LANES + 8];
        // SAFETY: the first eight go to the front and the next eight behind at most eight of them: all within the array.
        // Otherwise see the head of the file.
        unsafe {
            let order = |bits: usize| _mm256_cvtepu8_epi32(_mm_loadl_epi64(FRONT[bits].as_ptr().cast()));
            let p = all.as_mut_ptr();
            let kept = |x: __m256i, bits: usize| {
                let moved = _mm256_permutevar8x32_epi32(x, order(bits));
                let kept = _mm256_cmpgt_epi32(
                    _mm256_set1_epi32(bits.count_ones() as i32),
                    _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7),
                );
                _mm256_and_si256(moved, kept)
            };
            _mm256_storeu_si256(p.cast(), kept(self.0, first));
            _mm256_storeu_si256(p.add(first.count_ones() as usize).cast(), kept(self.1, second));
            Self(_mm256_loadu_si256(p.cast()), _mm256_loadu_si256(p.add(8).cast()))
        }
    }

    #[inline(always)]
    fn array(self) -> [u32; LANES] {
        let mut all = [0; LANES];
        self.store(&mut all);
        all
    }

    #[inline(always)]
    fn store(self, to: &mut [u32; LANES]) {
        let p = to.as_mut_ptr().cast::<__m256i>();
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe {
            _mm256_storeu_si256(p, self.0);
            _mm256_storeu_si256(p.add(1), self.1);
        }
    }
}

/// For each set of eight lanes, the lanes that are in it and then any.
static FRONT: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut n, mut lane) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                table[bits][n] = lane as u8;
                n += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};
