//! Functions made of exactly rounded operations, with the polynomials of S. Moshier's Cephes library (sinf.c, cosf.c,
//! atanf.c): within two units in the last place on the stated ranges, and the same bits in every tier.

use super::{Floats, Words};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Sine and cosine of angles within ±π/4 (radians).
#[inline(always)]
pub fn sin_cos_small<F: Floats>(x: F) -> (F, F) {
    let z = x * x;
    let sin = ((z * -1.951_529_6e-4 + 8.332_161e-3) * z - 1.666_665_5e-1) * z * x + x;
    let cos = ((z * 2.443_315_7e-5 - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - z * 0.5 + 1.0;
    (sin, cos)
}

/// Sine and cosine of 2π·`turns`, for `turns` within ±2²⁰.
#[inline(always)]
pub fn sin_cos_turns<F: Floats>(turns: F) -> (F, F) {
    // To the nearest quarter; the difference is exact.
    let quarters = (turns * 4.0 + 0.5).floor();
    let (sin, cos) = sin_cos_small((turns - quarters * 0.25) * TAU);
    let quarter = quarters.truncate();
    let odd = (quarter & 1).eq(quarter.fill(1));
    (flipped(F::select(odd, cos, sin), quarter), flipped(F::select(odd, sin, cos), quarter + 1))
}

/// With the sign that bit 1 of `bits` turns.
#[inline(always)]
fn flipped<F: Floats>(x: F, bits: F::Words) -> F {
    (x.to_bits() ^ (bits & 2).shl::<30>()).from_bits()
}

/// The angle of (x, y) in (−π, π]; 0 for (0, 0).
#[inline(always)]
pub fn atan2<F: Floats>(y: F, x: F) -> F {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay.gt(ax);
    let (low, high) = (F::select(steep, ax, ay), F::select(steep, ay, ax));
    let zero = x.fill(0.0);
    let ratio = F::select(high.eq(zero), zero, low / high);
    // Beyond tan(π/8) relative to the diagonal.
    let beyond = ratio.gt(x.fill(0.414_213_57));
    let r = F::select(beyond, (ratio - 1.0) / (ratio + 1.0), ratio);
    let z = r * r;
    let atan = (((z * 8.053_744_5e-2 - 1.387_768_6e-1) * z + 1.997_771_1e-1) * z - 3.333_295e-1) * z * r + r;
    let atan = F::select(beyond, atan + FRAC_PI_4, atan);
    let atan = F::select(steep, x.fill(FRAC_PI_2) - atan, atan);
    let atan = F::select(x.lt(zero), x.fill(PI) - atan, atan);
    atan.copysign(y)
}
