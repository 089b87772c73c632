/// Mixes a word into a key: the PCG output function over an LCG step of their combination
/// (after Jarzynski & Olano 2020, "Hash Functions for GPU Rendering"), applied twice for avalanche in both inputs.
pub fn hash_combine(key: u32, word: u32) -> u32 {
    pcg(pcg(word).wrapping_add(key.rotate_left(5)) ^ key)
}

pub(super) fn pcg(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// The upper 24 bits as a number in [0, 1).
pub fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}
