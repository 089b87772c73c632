//! The two generators of 2018, as baselines: in sequence, seeded per (pixel, replicate, sample).

use super::unit_float;

/// A state that is never zero (where xorshift would stick).
pub(super) fn initial_state(hash: u32) -> u32 {
    if hash == 0 { 0x9E37_79B9 } else { hash }
}

/// Marsaglia 2003, shifts 13, 17, 5 (2018's 13, 17, 15 has a shorter period).
pub(super) fn xorshift32(state: &mut u32) -> f32 {
    let mut x = *state;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    *state = x;
    unit_float(x)
}

/// x ← 1664525·x + 1013904223 (Numerical Recipes); its upper bits are used.
pub(super) fn lcg(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    unit_float(*state)
}
