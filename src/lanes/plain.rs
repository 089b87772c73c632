//! Lanes as arrays, for any machine: what the other tiers are compared with.

use super::operators::{mask_operator, operator};
use super::{Floats, LANES, Lanes, Mask, Words};
use std::array::from_fn;

/// Plain code.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct PlainFloats([f32; LANES]);

/// Sixteen `u32`.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct PlainWords([u32; LANES]);

/// Sixteen truths: all bits of a lane, or none, which compilers turn into vector code best.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct PlainMask([u32; LANES]);

impl Lanes for Plain {
    type M = PlainMask;
    type F = PlainFloats;
    type U = PlainWords;

    #[inline(always)]
    fn splat(self, x: f32) -> PlainFloats {
        PlainFloats([x; LANES])
    }

    #[inline(always)]
    fn word(self, x: u32) -> PlainWords {
        PlainWords([x; LANES])
    }

    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> PlainFloats {
        PlainFloats(*from)
    }

    #[inline(always)]
    fn load_words(self, from: &[u32; LANES]) -> PlainWords {
        PlainWords(*from)
    }

    #[inline(always)]
    fn mask(self, bits: u32) -> PlainMask {
        PlainMask(from_fn(|i| 0u32.wrapping_sub(bits >> i & 1)))
    }

    #[inline(always)]
    fn gather(self, from: &[f32], at: PlainWords) -> PlainFloats {
        let last = from.len().wrapping_sub(1);
        PlainFloats(at.0.map(|i| from.get((i as usize).min(last)).copied().unwrap_or(0.0)))
    }

    #[inline(always)]
    fn gather_words(self, from: &[u32], at: PlainWords) -> PlainWords {
        let last = from.len().wrapping_sub(1);
        PlainWords(at.0.map(|i| from.get((i as usize).min(last)).copied().unwrap_or(0)))
    }

    #[inline(always)]
    fn gather_four(self, from: &[f32], at: PlainWords) -> [PlainFloats; 4] {
        let Some(last) = from.len().checked_sub(4) else { return [PlainFloats([0.0; LANES]); 4] };
        from_fn(|k| PlainFloats(at.0.map(|i| from[(i as usize).min(last) + k])))
    }
}

mask_operator!(PlainMask, BitAnd, bitand, |a, b| PlainMask(from_fn(|i| a.0[i] & b.0[i])));
mask_operator!(PlainMask, BitOr, bitor, |a, b| PlainMask(from_fn(|i| a.0[i] | b.0[i])));
mask_operator!(PlainMask, BitXor, bitxor, |a, b| PlainMask(from_fn(|i| a.0[i] ^ b.0[i])));

impl std::ops::Not for PlainMask {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|m| !m))
    }
}

impl Mask for PlainMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..LANES).fold(0, |bits, i| bits | (self.0[i] & 1) << i)
    }
}

operator!(PlainFloats, f32, Add, add, |a, b| PlainFloats(from_fn(|i| a.0[i] + b.0[i])));
operator!(PlainFloats, f32, Sub, sub, |a, b| PlainFloats(from_fn(|i| a.0[i] - b.0[i])));
operator!(PlainFloats, f32, Mul, mul, |a, b| PlainFloats(from_fn(|i| a.0[i] * b.0[i])));
operator!(PlainFloats, f32, Div, div, |a, b| PlainFloats(from_fn(|i| a.0[i] / b.0[i])));

impl std::ops::Neg for PlainFloats {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

fn truth(t: bool) -> u32 {
    0u32.wrapping_sub(u32::from(t))
}

impl Floats for PlainFloats {
    type Mask = PlainMask;
    type Words = PlainWords;

    #[inline(always)]
    fn fill(self, x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    #[inline(always)]
    fn estimate_mul_add(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.map(f32::floor))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> PlainMask {
        PlainMask(from_fn(|i| truth(self.0[i] < other.0[i])))
    }

    #[inline(always)]
    fn le(self, other: Self) -> PlainMask {
        PlainMask(from_fn(|i| truth(self.0[i] <= other.0[i])))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> PlainMask {
        PlainMask(from_fn(|i| truth(self.0[i] == other.0[i])))
    }

    #[inline(always)]
    fn select(mask: PlainMask, yes: Self, no: Self) -> Self {
        Self(from_fn(|i| f32::from_bits(yes.0[i].to_bits() & mask.0[i] | no.0[i].to_bits() & !mask.0[i])))
    }

    #[inline(always)]
    fn to_bits(self) -> PlainWords {
        PlainWords(self.0.map(f32::to_bits))
    }

    #[inline(always)]
    fn truncate(self) -> PlainWords {
        // As x86 does: one number stands for all that do not fit.
        let fits = |x: f32| (-2_147_483_648.0..2_147_483_648.0).contains(&x);
        PlainWords(self.0.map(|x| if fits(x) { x as i32 as u32 } else { 1 << 31 }))
    }

    #[inline(always)]
    fn compress(self, mask: PlainMask) -> Self {
        self.to_bits().compress(mask).from_bits()
    }

    #[inline(always)]
    fn array(self) -> [f32; LANES] {
        self.0
    }
}

operator!(PlainWords, u32, Add, add, |a, b| PlainWords(from_fn(|i| a.0[i].wrapping_add(b.0[i]))));
operator!(PlainWords, u32, Sub, sub, |a, b| PlainWords(from_fn(|i| a.0[i].wrapping_sub(b.0[i]))));
operator!(PlainWords, u32, Mul, mul, |a, b| PlainWords(from_fn(|i| a.0[i].wrapping_mul(b.0[i]))));
operator!(PlainWords, u32, BitAnd, bitand, |a, b| PlainWords(from_fn(|i| a.0[i] & b.0[i])));
operator!(PlainWords, u32, BitOr, bitor, |a, b| PlainWords(from_fn(|i| a.0[i] | b.0[i])));
operator!(PlainWords, u32, BitXor, bitxor, |a, b| PlainWords(from_fn(|i| a.0[i] ^ b.0[i])));

impl Words for PlainWords {
    type Mask = PlainMask;
    type Floats = PlainFloats;

    #[inline(always)]
    fn fill(self, x: u32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        Self(self.0.map(|x| x << N))
    }

    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        Self(self.0.map(|x| x >> N))
    }

    #[inline(always)]
    fn shr_by(self, bits: Self) -> Self {
        Self(from_fn(|i| self.0[i] >> (bits.0[i] & 31)))
    }

    #[inline(always)]
    fn reverse_bits(self) -> Self {
        Self(self.0.map(u32::reverse_bits))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(from_fn(|i| Ord::min(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> PlainMask {
        PlainMask(from_fn(|i| truth(self.0[i] == other.0[i])))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> PlainMask {
        PlainMask(from_fn(|i| truth(self.0[i] < other.0[i])))
    }

    #[inline(always)]
    fn select(mask: PlainMask, yes: Self, no: Self) -> Self {
        Self(from_fn(|i| yes.0[i] & mask.0[i] | no.0[i] & !mask.0[i]))
    }

    #[inline(always)]
    fn from_bits(self) -> PlainFloats {
        PlainFloats(self.0.map(f32::from_bits))
    }

    #[inline(always)]
    fn to_floats(self) -> PlainFloats {
        PlainFloats(self.0.map(|x| x as i32 as f32))
    }

    #[inline(always)]
    fn compress(self, mask: PlainMask) -> Self {
        let (mut out, mut n) = ([0; LANES], 0);
        for i in 0..LANES {
            // Written wherever it belongs, and kept if it counts: no branch to predict.
            out[n & (LANES - 1)] = self.0[i] & mask.0[i] | out[n & (LANES - 1)] & !mask.0[i];
            n += (mask.0[i] & 1) as usize;
        }
        Self(out)
    }

    #[inline(always)]
    fn array(self) -> [u32; LANES] {
        self.0
    }
}
