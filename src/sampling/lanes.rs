//! The addressed random numbers of sixteen paths: bit for bit those of [`super::PathSampler`].

use super::hash::pcg;
use super::{Purpose, REPLICATES, key_words, seed_key, sobol};
use crate::lanes::{LANES, Lanes, Words};
use crate::settings::SamplerKind;

/// The random numbers of sixteen camera paths.
#[derive(Clone, Copy, Debug)]
pub struct PathSamplers<L: Lanes> {
    points: bool,
    key: L::U,
    index: L::U,
}

/// [`super::hash_combine`] with the same word in all lanes.
#[inline(always)]
fn combine<U: Words>(key: U, word: u32) -> U {
    combine_hashed(key, key.fill(pcg(word)))
}

#[inline(always)]
fn combine_hashed<U: Words>(key: U, hashed: U) -> U {
    pcg_lanes((hashed + key.rotl::<5, 27>()) ^ key)
}

#[inline(always)]
fn pcg_lanes<U: Words>(x: U) -> U {
    let state = x * 747_796_405 + 2_891_336_453;
    let word = (state.shr_by(state.shr::<28>() + 4) ^ state) * 277_803_737;
    word.shr::<22>() ^ word
}

#[inline(always)]
fn unit<U: Words>(bits: U) -> U::Floats {
    bits.shr::<8>().to_floats() * (1.0 / 16_777_216.0)
}

impl<L: Lanes> PathSamplers<L> {
    /// The numbers of samples (over all replicates) of sixteen pixels (x, y), as [`super::PathSampler::new`].
    #[inline(always)]
    pub fn of_pixels(l: L, kind: SamplerKind, seed: u64, [x, y]: [L::U; 2], sample: &[u32; LANES]) -> Option<Self> {
        let replicate = l.load_words(&std::array::from_fn(|i| sample[i] % REPLICATES));
        let index = l.load_words(&std::array::from_fn(|i| sample[i] / REPLICATES));
        let mut key = l.word(seed_key(seed));
        for word in [x, y, replicate] {
            key = combine_hashed(key, pcg_lanes(word));
        }
        Self::new(kind, key, index)
    }

    /// What names (seed, pixel, replicate), and the number of the point of the sequence.
    #[inline(always)]
    pub fn words(&self) -> [L::U; 2] {
        [self.key, self.index]
    }

    /// From the paths' keys and point numbers; `None` for samplers that are not addressed.
    #[inline(always)]
    pub fn new(kind: SamplerKind, key: L::U, index: L::U) -> Option<Self> {
        match kind {
            SamplerKind::Sobol => Some(Self { points: true, key, index }),
            SamplerKind::Pcg => Some(Self { points: false, key, index }),
            SamplerKind::Lcg | SamplerKind::Xorshift32 => None,
        }
    }

    /// See [`super::PathSampler::split`].
    #[inline(always)]
    pub fn split(&self, k: u32, count: u32) -> Self {
        Self { index: self.index * count + k, ..*self }
    }

    #[inline(always)]
    fn key_of(&self, vertex: u32, purpose: Purpose) -> L::U {
        let [first, second] = key_words(vertex, purpose);
        combine(combine(self.key, first), second)
    }

    #[inline(always)]
    fn independent(&self, vertex: u32, purpose: Purpose) -> L::U {
        combine_hashed(self.key_of(vertex, purpose), pcg_lanes(self.index))
    }

    /// One number in [0, 1).
    #[inline(always)]
    pub fn get_1d(&self, vertex: u32, purpose: Purpose) -> L::F {
        if self.points && sobol::pays(vertex, purpose) {
            let seed = self.key_of(vertex, purpose);
            let index = owen_reversed(self.index.reverse_bits(), seed).reverse_bits();
            return unit(owen_reversed(index, combine(seed, 1)).reverse_bits());
        }
        unit(self.independent(vertex, purpose))
    }

    /// Two numbers in [0, 1), well distributed together.
    #[inline(always)]
    pub fn get_2d(&self, vertex: u32, purpose: Purpose) -> [L::F; 2] {
        if self.points && sobol::pays(vertex, purpose) {
            let seed = self.key_of(vertex, purpose);
            let index = owen_reversed(self.index.reverse_bits(), seed).reverse_bits();
            let x = owen_reversed(index, combine(seed, 1)).reverse_bits();
            let y = owen_reversed(second_reversed(index), combine(seed, 2)).reverse_bits();
            return [unit(x), unit(y)];
        }
        let first = self.independent(vertex, purpose);
        [unit(first), unit(combine(first, 1))]
    }
}

/// See [`sobol`].
#[inline(always)]
fn second_reversed<U: Words>(x: U) -> U {
    let x = x ^ (x & 0xFFFF_0000).shr::<16>();
    let x = x ^ (x & 0xFF00_FF00).shr::<8>();
    let x = x ^ (x & 0xF0F0_F0F0).shr::<4>();
    let x = x ^ (x & 0xCCCC_CCCC).shr::<2>();
    x ^ (x & 0xAAAA_AAAA).shr::<1>()
}

/// See [`sobol`].
#[inline(always)]
fn owen_reversed<U: Words>(x: U, seed: U) -> U {
    let x = x ^ (x * 0x3d20_adea);
    let x = (x + seed) * (seed.shr::<16>() | 1);
    let x = x ^ (x * 0x0552_6c56);
    x ^ (x * 0x53a2_2864)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, Floats, Work};
    use crate::math::simd::SimdTier;
    use crate::sampling::PathSampler;

    struct Numbers<'a>(SamplerKind, &'a [PathSampler; LANES], u32, Purpose);

    impl Work for Numbers<'_> {
        type Output = [[f32; LANES]; 3];

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let key = l.load_words(&self.1.map(|s| s.key()));
            let index = l.load_words(&self.1.map(|s| s.index()));
            let samplers = PathSamplers::<L>::new(self.0, key, index).expect("addressed");
            let [x, y] = samplers.get_2d(self.2, self.3);
            [samplers.split(2, 3).get_1d(self.2, self.3).array(), x.array(), y.array()]
        }
    }

    /// Keys and numbers of points of sixteen pixels' samples.
    struct Begin(SamplerKind, u32);

    impl Work for Begin {
        type Output = [[u32; LANES]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let x = l.lane_numbers() + 5;
            let sample = std::array::from_fn(|i| self.1 + i as u32 / 3);
            let samplers =
                PathSamplers::<L>::of_pixels(l, self.0, 1 << 40 | 9, [x, x * 3], &sample).expect("addressed");
            samplers.words().map(|w| w.array())
        }
    }

    #[test]
    fn lanes_begin_as_the_paths_do() {
        for sample in 0..9 {
            let [key, index] = AnyLanes::new(SimdTier::detect()).run(Begin(SamplerKind::Pcg, sample));
            for lane in 0..LANES as u32 {
                let path =
                    PathSampler::new(SamplerKind::Pcg, 1 << 40 | 9, [lane + 5, (lane + 5) * 3], sample + lane / 3);
                assert_eq!((key[lane as usize], index[lane as usize]), (path.key(), path.index()));
            }
        }
    }

    #[test]
    fn lanes_give_the_numbers_of_the_paths() {
        for kind in [SamplerKind::Sobol, SamplerKind::Pcg] {
            for round in 0..20 {
                let path = |i: usize| PathSampler::new(kind, 3, [i as u32, round], round * 7 + i as u32 % 5);
                let mut paths: [PathSampler; LANES] = std::array::from_fn(path);
                for purpose in [Purpose::Lobe, Purpose::Direction, Purpose::LightPoint] {
                    for tier in SimdTier::ALL {
                        let [one, x, y] = AnyLanes::new(tier).run(Numbers(kind, &paths, round % 4, purpose));
                        for (i, path) in paths.iter_mut().enumerate() {
                            assert_eq!(one[i], path.split(2, 3).get_1d(round % 4, purpose));
                            assert_eq!([x[i], y[i]], path.get_2d(round % 4, purpose));
                        }
                    }
                }
            }
        }
    }
}
