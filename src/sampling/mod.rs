//! Random numbers by address: (seed, pixel, replicate, sample, path vertex, purpose) → number.
//!
//! Nothing here is the n-th draw of a stream (but for the two sequential baselines), so that batching, compaction or
//! leaving out an effect shifts no number. **Replicates** are independent randomisations of the same low-discrepancy
//! points: sample `i` of a pixel is point `i / REPLICATES` of replicate `i % REPLICATES`, and the spread between
//! replicates is an honest measure of a pixel's error.

mod hash;
mod lanes;
mod sequential;
mod sobol;

use crate::settings::SamplerKind;
pub use hash::{hash_combine, unit_float};
pub use lanes::PathSamplers;

/// Independent randomisations per pixel: the fewest that differ. Each further one takes away some of what the points' distribution
/// gains (`scripts/runs/2026-11-22-replicates.md`), and pictures have pixels enough to average what two say.
pub const REPLICATES: u32 = 2;

/// What a random number is for. Numbers for different purposes at one vertex are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Point in the pixel.
    Pixel,
    /// Which lobe scatters.
    Lobe,
    /// Direction of scattering.
    Direction,
    /// Which light.
    LightChoice,
    /// Point on the light.
    LightPoint,
    /// Russian roulette.
    Roulette,
    /// Coverage of a surface; the number is the triangle.
    Coverage(u32),
    /// The wavelength of a path that is dispersed; always asked of vertex 0.
    Wavelength,
}

impl Purpose {
    fn code(self) -> (u32, u32) {
        match self {
            Self::Pixel => (1, 0),
            Self::Lobe => (2, 0),
            Self::Direction => (3, 0),
            Self::LightChoice => (4, 0),
            Self::LightPoint => (5, 0),
            Self::Roulette => (6, 0),
            Self::Coverage(triangle) => (7, triangle),
            Self::Wavelength => (0, 0),
        }
    }
}

fn seed_key(seed: u64) -> u32 {
    hash_combine(seed as u32, (seed >> 32) as u32)
}

/// What is hashed for an address within a path.
fn key_words(vertex: u32, purpose: Purpose) -> [u32; 2] {
    let (what, which) = purpose.code();
    [vertex.wrapping_mul(8).wrapping_add(what), which]
}

/// The random numbers of one camera path.
#[derive(Clone, Copy, Debug)]
pub struct PathSampler {
    kind: SamplerKind,
    /// Names (seed, pixel, replicate).
    key: u32,
    /// Point of the sequence.
    index: u32,
    state: u32,
}

impl PathSampler {
    /// The numbers of sample `sample` (over all replicates) of `pixel` = (x, y).
    pub fn new(kind: SamplerKind, seed: u64, pixel: [u32; 2], sample: u32) -> Self {
        let (replicate, index) = (sample % REPLICATES, sample / REPLICATES);
        let mut key = seed_key(seed);
        for word in [pixel[0], pixel[1], replicate] {
            key = hash_combine(key, word);
        }
        let state = sequential::initial_state(hash_combine(key, index));
        Self { kind, key, index, state }
    }

    /// Names (seed, pixel, replicate), for [`PathSamplers`].
    pub fn key(&self) -> u32 {
        self.key
    }

    /// Number of the point of the sequence, for [`PathSamplers`].
    pub fn index(&self) -> u32 {
        self.index
    }

    /// From a path's key and number of the point, for the samplers that are addressed.
    pub fn addressed(kind: SamplerKind, key: u32, index: u32) -> Self {
        Self { kind, key, index, state: 0 }
    }

    /// Where a path takes `count` samples of a kind at each vertex, the numbers of its `k`-th: all paths' samples together are points of
    /// one sequence, well distributed among themselves.
    pub fn split(&self, k: u32, count: u32) -> Self {
        Self { index: self.index.wrapping_mul(count).wrapping_add(k), ..*self }
    }

    /// Goes on where a split one has come to: for samplers that draw in sequence.
    pub fn follow(&mut self, split: &Self) {
        self.state = split.state;
    }

    fn key_of(&self, vertex: u32, purpose: Purpose) -> u32 {
        let [first, second] = key_words(vertex, purpose);
        hash_combine(hash_combine(self.key, first), second)
    }

    fn independent(&self, vertex: u32, purpose: Purpose) -> u32 {
        hash_combine(self.key_of(vertex, purpose), self.index)
    }

    /// One number in [0, 1).
    pub fn get_1d(&mut self, vertex: u32, purpose: Purpose) -> f32 {
        match self.kind {
            SamplerKind::Sobol if sobol::pays(vertex, purpose) => {
                sobol::sample_1d(self.index, self.key_of(vertex, purpose))
            }
            SamplerKind::Sobol | SamplerKind::Pcg => unit_float(self.independent(vertex, purpose)),
            SamplerKind::Lcg => sequential::lcg(&mut self.state),
            SamplerKind::Xorshift32 => sequential::xorshift32(&mut self.state),
        }
    }

    /// Two numbers in [0, 1), well distributed together.
    pub fn get_2d(&mut self, vertex: u32, purpose: Purpose) -> [f32; 2] {
        match self.kind {
            SamplerKind::Sobol if sobol::pays(vertex, purpose) => {
                sobol::sample_2d(self.index, self.key_of(vertex, purpose))
            }
            SamplerKind::Sobol | SamplerKind::Pcg => {
                let first = self.independent(vertex, purpose);
                [unit_float(first), unit_float(hash_combine(first, 1))]
            }
            SamplerKind::Lcg => [sequential::lcg(&mut self.state), sequential::lcg(&mut self.state)],
            SamplerKind::Xorshift32 => {
                [sequential::xorshift32(&mut self.state), sequential::xorshift32(&mut self.state)]
            }
        }
    }

    /// One independent number in [0, 1), whatever the sampler: asking twice gives the same number, so it can be used
    /// inside a traversal that meets a triangle in several cells.
    pub fn fixed(&self, vertex: u32, purpose: Purpose) -> f32 {
        unit_float(self.independent(vertex, purpose))
    }
}

#[cfg(test)]
mod tests;
