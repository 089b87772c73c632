//! The sRGB transfer function (IEC 61966-2-1).

use crate::lanes::{Floats, Words};

/// Linear light in [0, 1] to the encoded value in [0, 1]. Values outside are clamped, NaN becomes 0.
pub fn encode(linear: f32) -> f32 {
    // `max` first: it turns NaN into 0.
    let x = linear.max(0.0).min(1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * five_twelfths(x) - 0.055 }
}

/// x^(1/2.4) of 0.003 to 1, to some 3e-7: the fourth root times the sixth one. A general power takes several times as long, and errors
/// of pictures are measured through this curve.
#[inline]
fn five_twelfths(x: f32) -> f32 {
    let root = x.sqrt();
    root.sqrt() * cube_root(root)
}

/// The cube root of a positive, normal number: a third of the exponent, then twice Halley's step, each of which has thrice as many
/// right digits.
#[inline]
fn cube_root(x: f32) -> f32 {
    let guess = f32::from_bits(x.to_bits() / 3 + 0x2a51_19f2);
    let step = |y: f32| {
        let cube = y * y * y;
        y * ((cube + 2.0 * x) / (2.0 * cube + x))
    };
    step(step(guess))
}

/// [`encode`] of sixteen numbers: the same bits.
#[inline(always)]
pub fn encode_lanes<F: Floats>(linear: F) -> F {
    let x = linear.max(linear.fill(0.0)).min(linear.fill(1.0));
    let root = x.sqrt();
    let curved = root.sqrt() * cube_root_lanes(root) * 1.055 - 0.055;
    F::select(x.le(x.fill(0.003_130_8)), x * 12.92, curved)
}

/// [`cube_root`] of sixteen numbers: the same bits.
#[inline(always)]
fn cube_root_lanes<F: Floats>(x: F) -> F {
    let guess = (third(x.to_bits()) + 0x2a51_19f2).from_bits();
    halley(halley(guess, x), x)
}

#[inline(always)]
fn halley<F: Floats>(y: F, x: F) -> F {
    let cube = y * y * y;
    y * ((cube + x * 2.0) / (cube * 2.0 + x))
}

/// n / 3, rounded down, of n < 2³¹ (Warren, Hacker's Delight, 2nd edition, 10-3).
#[inline(always)]
fn third<U: Words>(n: U) -> U {
    let mut quotient = n.shr::<2>() + n.shr::<4>();
    quotient = quotient + quotient.shr::<4>();
    quotient = quotient + quotient.shr::<8>();
    quotient = quotient + quotient.shr::<16>();
    let rest = n - quotient * 3;
    quotient + (rest * 11).shr::<5>()
}

/// The encoded value in [0, 1] to linear light in [0, 1]. Values outside are clamped, NaN becomes 0.
pub fn decode(encoded: f32) -> f32 {
    let x = encoded.max(0.0).min(1.0);
    if x <= 0.040_45 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

/// Encoded value to the nearest of `0..=levels`.
pub fn quantise(encoded: f32, levels: f32) -> u16 {
    // The cast of a value in [0, 65535.5) truncates.
    (encoded.max(0.0).min(1.0) * levels + 0.5) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // Computed in double precision from the standard's formula.
        for (linear, want) in [(0.0, 0.0), (0.002, 0.025_84), (0.18, 0.461_356_13), (0.5, 0.735_357), (1.0, 1.0)] {
            assert!((encode(linear) - want).abs() < 1e-6, "{linear}: {} for {want}", encode(linear));
        }
        assert_eq!(encode(f32::NAN), 0.0);
        assert_eq!((encode(-1.0), encode(7.0)), (encode(0.0), encode(1.0)));
    }

    #[test]
    fn the_curve_is_that_of_double_precision() {
        let mut worst = 0.0f64;
        for k in 0..200_000 {
            let x = libm::exp(f64::from(k) / 200_000.0 * libm::log(319.0)) / 319.0;
            let want = libm::pow(f64::from(x as f32), 1.0 / 2.4) * 1.055 - 0.055;
            worst = worst.max((f64::from(encode(x as f32)) - want).abs());
        }
        assert!(worst < 3.5e-7, "{worst}");
    }

    #[test]
    fn every_byte_survives_the_round_trip() {
        for byte in 0..=255u8 {
            assert_eq!(quantise(encode(decode(f32::from(byte) / 255.0)), 255.0), u16::from(byte));
        }
        for value in (0..=65535u16).step_by(7) {
            assert_eq!(quantise(encode(decode(f32::from(value) / 65535.0)), 65535.0), value);
        }
    }
}
