//! Lanes in AVX-512: one register.
//!
//! Every method may use the instructions because its receiver, or the token, exists only on machines that have them: that
//! is the safety argument of each `unsafe` here, as the types cannot be made outside this file.
#![allow(unsafe_code)]

use super::operators::{mask_operator, operator};
use super::{Floats, LANES, Lanes, Mask, Words, Work};
use crate::math::simd::SimdTier;
use std::arch::x86_64::*;

/// Proof that the machine has AVX-512 F, BW, DQ and VL.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
pub struct Floats512(__m512);

/// Sixteen `u32`.
#[derive(Clone, Copy, Debug)]
pub struct Words512(__m512i);

/// Sixteen truths.
#[derive(Clone, Copy, Debug)]
pub struct Mask512(__mmask16);

impl Avx512 {
    /// The proof, on a machine that has it.
    pub fn new() -> Option<Self> {
        (SimdTier::detect() == SimdTier::Avx512).then_some(Self(()))
    }

    /// Does the work with the instructions switched on.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        // SAFETY: `self` is the proof that the machine has the features.
        unsafe { run_with_features(self, work) }
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt,lzcnt")]
fn run_with_features<W: Work>(lanes: Avx512, work: W) -> W::Output {
    work.run(lanes)
}

/// A result in vectors, by instructions that the receiver proves to be there.
macro_rules! floats {
    ($result:expr) => {
        // SAFETY: see the head of the file.
        Floats512(unsafe { $result })
    };
}
macro_rules! words {
    ($result:expr) => {
        // SAFETY: see the head of the file.
        Words512(unsafe { $result })
    };
}
macro_rules! truths {
    ($result:expr) => {
        // SAFETY: see the head of the file.
        Mask512(unsafe { $result })
    };
}

impl Lanes for Avx512 {
    type M = Mask512;
    type F = Floats512;
    type U = Words512;

    #[inline(always)]
    fn splat(self, x: f32) -> Floats512 {
        floats!(_mm512_set1_ps(x))
    }

    #[inline(always)]
    fn word(self, x: u32) -> Words512 {
        words!(_mm512_set1_epi32(x as i32))
    }

    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> Floats512 {
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        Floats512(unsafe { _mm512_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> Words512 {
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        Words512(unsafe { _mm512_loadu_epi32(from.as_ptr().cast()) })
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> Mask512 {
        Mask512(bits as u16)
    }

    #[inline(always)]
    fn gather(self, from: &[f32], at: Words512) -> Floats512 {
        if let Ok(table) = from.try_into() {
            return floats!(_mm512_permutexvar_ps(at.min(self.word(15)).0, self.load(table).0));
        }
        let Some(last) = from.len().checked_sub(1) else { return self.splat(0.0) };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32));
        // SAFETY: all places are below the length and fit a signed number; otherwise see the head of the file.
        Floats512(unsafe { _mm512_i32gather_ps::<4>(at.0, from.as_ptr()) })
    }

    #[inline(always)]
    fn gather_words(self, from: &[u32], at: Words512) -> Words512 {
        if let Ok(table) = from.try_into() {
            return words!(_mm512_permutexvar_epi32(at.min(self.word(15)).0, self.load_words(table).0));
        }
        let Some(last) = from.len().checked_sub(1) else { return self.word(0) };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32));
        // SAFETY: all places are below the length and fit a signed number; otherwise see the head of the file.
        Words512(unsafe { _mm512_i32gather_epi32::<4>(at.0, from.as_ptr().cast()) })
    }

    #[inline(always)]
    fn gather_four(self, from: &[f32], at: Words512) -> [Floats512; 4] {
        let Some(last) = from.len().checked_sub(4) else { return [self.splat(0.0); 4] };
        let at = at.min(self.word(last.min(i32::MAX as usize) as u32)).array();
        // SAFETY: from each place on there are four numbers; otherwise see the head of the file.
        unsafe {
            let four = |lane: usize| _mm_loadu_ps(from.as_ptr().add(at[lane] as usize));
            // Every fourth lane's numbers side by side.
            let each = |k: usize| {
                let low = _mm512_insertf32x4::<1>(_mm512_castps128_ps512(four(k)), four(k + 4));
                _mm512_insertf32x4::<3>(_mm512_insertf32x4::<2>(low, four(k + 8)), four(k + 12))
            };
            let (a, b, c, d) = (each(0), each(1), each(2), each(3));
            let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
            let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
            [
                Floats512(_mm512_shuffle_ps::<0x44>(ab, cd)),
                Floats512(_mm512_shuffle_ps::<0xEE>(ab, cd)),
                Floats512(_mm512_shuffle_ps::<0x44>(ab_high, cd_high)),
                Floats512(_mm512_shuffle_ps::<0xEE>(ab_high, cd_high)),
            ]
        }
    }
}

mask_operator!(Mask512, BitAnd, bitand, |a, b| Mask512(a.0 & b.0));
mask_operator!(Mask512, BitOr, bitor, |a, b| Mask512(a.0 | b.0));
mask_operator!(Mask512, BitXor, bitxor, |a, b| Mask512(a.0 ^ b.0));

impl std::ops::Not for Mask512 {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Mask for Mask512 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

operator!(Floats512, f32, Add, add, |a, b| floats!(_mm512_add_ps(a.0, b.0)));
operator!(Floats512, f32, Sub, sub, |a, b| floats!(_mm512_sub_ps(a.0, b.0)));
operator!(Floats512, f32, Mul, mul, |a, b| floats!(_mm512_mul_ps(a.0, b.0)));
operator!(Floats512, f32, Div, div, |a, b| floats!(_mm512_div_ps(a.0, b.0)));

impl std::ops::Neg for Floats512 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        floats!(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)))
    }
}

impl Floats for Floats512 {
    type Mask = Mask512;
    type Words = Words512;

    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        floats!(_mm512_set1_ps(x))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        floats!(_mm512_sqrt_ps(self.0))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        floats!(_mm512_min_ps(self.0, other.0))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        floats!(_mm512_max_ps(self.0, other.0))
    }

    #[inline(always)]
    fn estimate_mul_add(self, factor: Self, term: Self) -> Self {
        floats!(_mm512_fmadd_ps(self.0, factor.0, term.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        floats!(_mm512_abs_ps(self.0))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        floats!(_mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask512 {
        truths!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask512 {
        truths!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask512 {
        truths!(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn select(mask: Mask512, yes: Self, no: Self) -> Self {
        floats!(_mm512_mask_blend_ps(mask.0, no.0, yes.0))
    }

    #[inline(always)]
    fn to_bits(self) -> Words512 {
        words!(_mm512_castps_si512(self.0))
    }

    #[inline(always)]
    fn truncate(self) -> Words512 {
        words!(_mm512_cvttps_epi32(self.0))
    }

    #[inline(always)]
    fn compress(self, mask: Mask512) -> Self {
        floats!(_mm512_maskz_compress_ps(mask.0, self.0))
    }

    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        let mut all = [0.0; LANES];
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe { _mm512_storeu_ps(all.as_mut_ptr(), self.0) };
        all
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), self.0) };
    }
}

operator!(Words512, u32, Add, add, |a, b| words!(_mm512_add_epi32(a.0, b.0)));
operator!(Words512, u32, Sub, sub, |a, b| words!(_mm512_sub_epi32(a.0, b.0)));
operator!(Words512, u32, Mul, mul, |a, b| words!(_mm512_mullo_epi32(a.0, b.0)));
operator!(Words512, u32, BitAnd, bitand, |a, b| words!(_mm512_and_si512(a.0, b.0)));
operator!(Words512, u32, BitOr, bitor, |a, b| words!(_mm512_or_si512(a.0, b.0)));
operator!(Words512, u32, BitXor, bitxor, |a, b| words!(_mm512_xor_si512(a.0, b.0)));

impl Words for Words512 {
    type Mask = Mask512;
    type Floats = Floats512;

    #[inline(always)]
    fn fill(self, x: u32) -> Self {
        words!(_mm512_set1_epi32(x as i32))
    }

    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        words!(_mm512_slli_epi32::<N>(self.0))
    }

    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        words!(_mm512_srli_epi32::<N>(self.0))
    }

    #[inline(always)]
    fn shr_by(self, bits: Self) -> Self {
        words!(_mm512_srlv_epi32(self.0, _mm512_and_si512(bits.0, _mm512_set1_epi32(31))))
    }

    #[inline(always)]
    fn reverse_bits(self) -> Self {
        // Bytes into the opposite order, then half bytes by table.
        words!({
            let bytes = _mm512_broadcast_i32x4(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
            let table = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
            let high = _mm512_broadcast_i32x4(_mm_slli_epi32::<4>(table));
            let low = _mm512_broadcast_i32x4(table);
            let nibble = _mm512_set1_epi8(15);
            let x = _mm512_shuffle_epi8(self.0, bytes);
            let lower = _mm512_shuffle_epi8(high, _mm512_and_si512(x, nibble));
            let upper = _mm512_shuffle_epi8(low, _mm512_and_si512(_mm512_srli_epi32::<4>(x), nibble));
            _mm512_or_si512(lower, upper)
        })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        words!(_mm512_min_epu32(self.0, other.0))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask512 {
        truths!(_mm512_cmpeq_epi32_mask(self.0, other.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask512 {
        truths!(_mm512_cmplt_epu32_mask(self.0, other.0))
    }

    #[inline(always)]
    fn select(mask: Mask512, yes: Self, no: Self) -> Self {
        words!(_mm512_mask_blend_epi32(mask.0, no.0, yes.0))
    }

    #[inline(always)]
    fn from_bits(self) -> Floats512 {
        floats!(_mm512_castsi512_ps(self.0))
    }

    #[inline(always)]
    fn to_floats(self) -> Floats512 {
        floats!(_mm512_cvtepi32_ps(self.0))
    }

    #[inline(always)]
    fn compress(self, mask: Mask512) -> Self {
        words!(_mm512_maskz_compress_epi32(mask.0, self.0))
    }

    #[inline(always)]
    fn array(self) -> [u32; LANES] {
        let mut all = [0; LANES];
        self.store(&mut all);
        all
    }

    #[inline(always)]
    fn store(self, to: &mut [u32; LANES]) {
        // SAFETY: the array has sixteen numbers; otherwise see the head of the file.
        unsafe { _mm512_storeu_epi32(to.as_mut_ptr().cast(), self.0) };
    }
}
