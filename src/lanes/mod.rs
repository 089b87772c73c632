//! Sixteen numbers at a time: one source for AVX-512 (one register), AVX2 (two) and plain arrays, with the same bits.
//!
//! [`Lanes`] is a token that proves that the machine has the instructions; numbers come from it and from each other, so
//! that code in lanes is safe code. Operations are those that IEEE 754 rounds exactly (+ − × ÷ √, comparisons, truncation
//! to integers) and whole-number ones; nothing is fused, and what else is needed is made of polynomials
//! ([`functions`]). So all tiers give the same bits, which `tests` check. The one exception bears it in its name:
//! [`Floats::estimate_mul_add`].
//!
//! Code in lanes is generic over [`Lanes`], every function `#[inline(always)]`, and entered through [`AnyLanes::run`]: only
//! there the instructions are switched on, and what is not inlined into it would be compiled without them: slow code, every
//! instruction a call. Closures cannot be marked; they must be small, or be functions.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod frame;
pub mod functions;
mod operators;
mod plain;
pub mod prefetch;
mod vector;

#[cfg(test)]
mod tests;

use crate::math::simd::SimdTier;
pub use frame::FrameLanes;
use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};
pub use vector::V3;

/// Numbers in a vector, in every tier.
pub const LANES: usize = 16;

/// A truth for each lane.
pub trait Mask:
    Copy + Debug + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// The truths as bits, lane 0 in the lowest one; the upper 16 bits are 0.
    fn bits(self) -> u32;

    /// Whether it is true anywhere.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// Whether it is true nowhere.
    #[inline(always)]
    fn none(self) -> bool {
        self.bits() == 0
    }

    /// Whether it is true everywhere.
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == 0xFFFF
    }

    /// In how many lanes it is true.
    #[inline(always)]
    fn count(self) -> usize {
        self.bits().count_ones() as usize
    }
}

/// Sixteen `f32`. Arithmetic with a plain `f32` on the right means that number in every lane.
pub trait Floats:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
    + Div<f32, Output = Self>
{
    /// Truths that belong to them.
    type Mask: Mask;
    /// Whole numbers that belong to them.
    type Words: Words<Mask = Self::Mask, Floats = Self>;

    /// The number in every lane (the receiver only proves that the instructions are there).
    fn fill(self, x: f32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `self < other ? self : other`: the other one if either is not a number.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`: the other one if either is not a number.
    fn max(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// About `self * factor + term`: rounded once or twice, as it is fastest. **Not the same bits in all tiers**: for estimates
    /// whose error is bounded and which nothing that is kept depends on.
    fn estimate_mul_add(self, factor: Self, term: Self) -> Self;
    /// The largest whole number that is not greater.
    fn floor(self) -> Self;
    /// `self < other`; false for what is not a number, like all comparisons.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// Lane by lane `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The numbers' bits.
    fn to_bits(self) -> Self::Words;
    /// Rounded towards zero, as a signed number's bits; 2³¹ for what does not fit.
    fn truncate(self) -> Self::Words;
    /// The lanes where the mask is true, moved to the front, and zeros.
    fn compress(self, mask: Self::Mask) -> Self;
    /// As an array.
    fn array(self) -> [f32; LANES];

    /// Stores all lanes.
    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        *to = self.array();
    }

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// The number where the mask is true, else 0.
    #[inline(always)]
    fn only(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, self.fill(0.0))
    }

    /// Its square.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    /// Which are neither infinite nor not a number.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().lt(self.fill(f32::INFINITY))
    }

    /// This magnitude with the sign of `other`.
    #[inline(always)]
    fn copysign(self, other: Self) -> Self {
        ((self.to_bits() & 0x7FFF_FFFF) | (other.to_bits() & 0x8000_0000)).from_bits()
    }
}

/// Sixteen `u32`; arithmetic wraps. A plain `u32` on the right means that number in every lane.
pub trait Words:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Add<u32, Output = Self>
    + Sub<u32, Output = Self>
    + Mul<u32, Output = Self>
    + BitAnd<u32, Output = Self>
    + BitOr<u32, Output = Self>
    + BitXor<u32, Output = Self>
{
    /// Truths that belong to them.
    type Mask: Mask;
    /// Numbers that belong to them.
    type Floats: Floats<Mask = Self::Mask, Words = Self>;

    /// The number in every lane (the receiver only proves that the instructions are there).
    fn fill(self, x: u32) -> Self;
    /// Shifted up by `N` < 32 bits.
    fn shl<const N: u32>(self) -> Self;
    /// Shifted down by `N` < 32 bits.
    fn shr<const N: u32>(self) -> Self;
    /// Shifted down by as many bits (< 32) as the other lane says.
    fn shr_by(self, bits: Self) -> Self;
    /// All bits in the opposite order.
    fn reverse_bits(self) -> Self;
    /// The smaller one.
    fn min(self, other: Self) -> Self;
    /// `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Lane by lane `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// As a float with these bits.
    #[expect(clippy::wrong_self_convention, reason = "the type is what it comes from")]
    fn from_bits(self) -> Self::Floats;
    /// As the nearest float, taken as a signed number.
    fn to_floats(self) -> Self::Floats;
    /// The lanes where the mask is true, moved to the front, and zeros.
    fn compress(self, mask: Self::Mask) -> Self;
    /// As an array.
    fn array(self) -> [u32; LANES];

    /// Stores all lanes.
    #[inline(always)]
    fn store(self, to: &mut [u32; LANES]) {
        *to = self.array();
    }

    /// Turned up by `N` bits, 0 < N < 32, with `M` = 32 − N.
    #[inline(always)]
    fn rotl<const N: u32, const M: u32>(self) -> Self {
        const { assert!(N + M == 32 && N > 0 && M > 0) };
        self.shl::<N>() | self.shr::<M>()
    }
}

/// A set of instructions that the machine has: where numbers come from.
pub trait Lanes: Copy + Debug + Send + Sync + 'static {
    /// Truths.
    type M: Mask;
    /// Numbers.
    type F: Floats<Mask = Self::M, Words = Self::U>;
    /// Whole numbers.
    type U: Words<Mask = Self::M, Floats = Self::F>;

    /// The number in every lane.
    fn splat(self, x: f32) -> Self::F;
    /// The whole number in every lane.
    fn word(self, x: u32) -> Self::U;
    /// One number for each lane.
    fn load(self, from: &[f32; LANES]) -> Self::F;
    /// One whole number for each lane.
    fn load_words(self, from: &[u32; LANES]) -> Self::U;
    /// Truths from the lower sixteen bits, lane 0 in the lowest.
    fn mask(self, bits: u32) -> Self::M;
    /// The numbers at these places; places beyond the end read the last one, and an empty slice reads zeros. From slices of
    /// sixteen it is fastest.
    fn gather(self, from: &[f32], at: Self::U) -> Self::F;
    /// The whole numbers at these places; places beyond the end read the last one, and an empty slice reads zeros.
    fn gather_words(self, from: &[u32], at: Self::U) -> Self::U;

    /// The four numbers in a row from each of these places on; places with fewer than four to come read the last four, and a
    /// slice of less than four reads zeros. Faster than one number after the other.
    fn gather_four(self, from: &[f32], at: Self::U) -> [Self::F; 4];

    /// The same vector in every lane.
    #[inline(always)]
    fn splat_vector(self, [x, y, z]: [f32; 3]) -> V3<Self::F> {
        V3::new(self.splat(x), self.splat(y), self.splat(z))
    }

    /// Sixteen vectors.
    #[inline(always)]
    fn load_vector(self, from: &[[f32; LANES]; 3]) -> V3<Self::F> {
        V3::new(self.load(&from[0]), self.load(&from[1]), self.load(&from[2]))
    }

    /// Sixteen numbers from `at` on.
    #[inline(always)]
    fn load_at(self, from: &[f32], at: usize) -> Self::F {
        self.load(from[at..at + LANES].try_into().expect("sixteen"))
    }

    /// Sixteen whole numbers from `at` on.
    #[inline(always)]
    fn load_words_at(self, from: &[u32], at: usize) -> Self::U {
        self.load_words(from[at..at + LANES].try_into().expect("sixteen"))
    }

    /// True in the first `n` lanes.
    #[inline(always)]
    fn first(self, n: usize) -> Self::M {
        self.mask(if n >= LANES { 0xFFFF } else { (1 << n) - 1 })
    }

    /// Each lane's number, 0 to 15.
    #[inline(always)]
    fn lane_numbers(self) -> Self::U {
        self.load_words(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15])
    }
}

/// Work that is done in lanes. `run` must be `#[inline(always)]`, and so must all be that it calls with lanes.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// The lanes of a tier.
#[derive(Clone, Copy, Debug)]
pub enum AnyLanes {
    /// Arrays.
    Plain(plain::Plain),
    /// Two registers.
    #[cfg(target_arch = "x86_64")]
    Avx2(avx2::Avx2),
    /// One register.
    #[cfg(target_arch = "x86_64")]
    Avx512(avx512::Avx512),
}

impl AnyLanes {
    /// The lanes of a tier, or the best that the machine has below it.
    pub fn new(tier: SimdTier) -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if tier == SimdTier::Avx512
                && let Some(lanes) = avx512::Avx512::new()
            {
                return Self::Avx512(lanes);
            }
            if tier >= SimdTier::Avx2
                && let Some(lanes) = avx2::Avx2::new()
            {
                return Self::Avx2(lanes);
            }
        }
        let _ = tier;
        Self::Plain(plain::Plain)
    }

    /// Does the work with the instructions of the tier.
    #[inline]
    pub fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            Self::Plain(lanes) => work.run(lanes),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(lanes) => lanes.run(work),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(lanes) => lanes.run(work),
        }
    }
}
