//! Owen-scrambled, shuffled Sobol' points, padded from one and two dimensions
//! (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)).

use super::{Purpose, hash_combine, unit_float};

/// The first Sobol' dimension in bit-reversed form is the index itself; this is the second one, bit-reversed: the
/// product of the index with Pascal's triangle modulo 2, in five steps (its matrix is a Kronecker power).
fn sobol_second_reversed(mut x: u32) -> u32 {
    x ^= (x & 0xFFFF_0000) >> 16;
    x ^= (x & 0xFF00_FF00) >> 8;
    x ^= (x & 0xF0F0_F0F0) >> 4;
    x ^= (x & 0xCCCC_CCCC) >> 2;
    x ^= (x & 0xAAAA_AAAA) >> 1;
    x
}

/// Laine & Karras' permutation with Burley's improved constants (Vegdahl 2021): an Owen scramble of a number whose
/// lowest bit is the most significant one.
fn owen_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

fn shuffled(index: u32, seed: u32) -> u32 {
    owen_reversed(index.reverse_bits(), seed).reverse_bits()
}

/// Whether well-distributed points pay for a number. Beyond a path's second vertex so many numbers have gone into it that
/// independent ones are as good; but not for the choice of lobes and roulette, which alone decide where paths through glass
/// go and end.
pub(super) fn pays(vertex: u32, purpose: Purpose) -> bool {
    vertex < 2 || matches!(purpose, Purpose::Lobe | Purpose::Roulette)
}

pub(super) fn sample_1d(index: u32, seed: u32) -> f32 {
    let index = shuffled(index, seed);
    unit_float(owen_reversed(index, hash_combine(seed, 1)).reverse_bits())
}

pub(super) fn sample_2d(index: u32, seed: u32) -> [f32; 2] {
    let index = shuffled(index, seed);
    let x = owen_reversed(index, hash_combine(seed, 1)).reverse_bits();
    let y = owen_reversed(sobol_second_reversed(index), hash_combine(seed, 2)).reverse_bits();
    [unit_float(x), unit_float(y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Direction numbers of the second Sobol' dimension by the classic recurrence (Bratley & Fox): v_k = v_{k-1} ⊕ v_{k-1} >> 1.
    fn second_by_direction_numbers(index: u32) -> u32 {
        let (mut v, mut x) = (1u32 << 31, 0);
        for bit in 0..32 {
            if index >> bit & 1 == 1 {
                x ^= v;
            }
            v ^= v >> 1;
        }
        x
    }

    #[test]
    fn second_dimension_is_sobols() {
        for i in (0..2000).chain([u32::MAX, 0x8000_0001, 0x1234_5678]) {
            assert_eq!(sobol_second_reversed(i).reverse_bits(), second_by_direction_numbers(i), "index {i}");
        }
    }

    #[test]
    fn scrambled_points_are_a_net() {
        // (0, m, 2)-net: each elementary interval of area 2^-m holds exactly one of 2^m points.
        for seed in 0..50 {
            for m in 0..=8u32 {
                let points: Vec<_> = (0..1u32 << m).map(|i| sample_2d(i, seed * 7919)).collect();
                for a in 0..=m {
                    let (nx, ny) = (1usize << a, 1usize << (m - a));
                    let mut count = vec![0; nx * ny];
                    for [x, y] in &points {
                        count[(x * nx as f32) as usize * ny + (y * ny as f32) as usize] += 1;
                    }
                    assert!(count.iter().all(|c| *c == 1), "seed {seed}, m {m}, split {a}");
                }
            }
        }
    }
}
