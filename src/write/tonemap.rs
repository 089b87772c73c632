//! Tone mapping: unbounded linear Rec. 709 radiance to displayable linear Rec. 709 in [0, 1].

use crate::lanes::{Floats, Lanes, V3};
use crate::settings::ToneMap;

/// Maps one colour. Negative and non-finite channels count as 0 and the largest float; the result is in [0, 1].
pub fn apply(operator: ToneMap, color: [f32; 3]) -> [f32; 3] {
    let color = color.map(|c| c.max(0.0).min(f32::MAX));
    let mapped = match operator {
        ToneMap::Neutral => neutral(color),
        ToneMap::Aces => aces(color),
        ToneMap::Agx => agx(color),
        ToneMap::None | ToneMap::Course => color,
    };
    mapped.map(|c| c.max(0.0).min(1.0))
}

/// [`apply`] to sixteen colours: the same bits. (ACES and AgX one after the other.)
#[inline(always)]
pub fn apply_lanes<L: Lanes>(lanes: L, operator: ToneMap, color: V3<L::F>) -> V3<L::F> {
    let color = V3::new(clamp(color.x, f32::MAX), clamp(color.y, f32::MAX), clamp(color.z, f32::MAX));
    let mapped = match operator {
        ToneMap::Neutral => neutral_lanes(color),
        ToneMap::None | ToneMap::Course => color,
        ToneMap::Aces | ToneMap::Agx => one_by_one(lanes, operator, color),
    };
    V3::new(clamp(mapped.x, 1.0), clamp(mapped.y, 1.0), clamp(mapped.z, 1.0))
}

/// From 0 to `most`; 0 for what is not a number.
#[inline(always)]
fn clamp<F: Floats>(c: F, most: f32) -> F {
    c.max(c.fill(0.0)).min(c.fill(most))
}

#[inline(always)]
fn one_by_one<L: Lanes>(lanes: L, operator: ToneMap, color: V3<L::F>) -> V3<L::F> {
    let mut channels = color.arrays();
    let [red, green, blue] = &mut channels;
    for ((r, g), b) in red.iter_mut().zip(green).zip(blue) {
        [*r, *g, *b] = apply(operator, [*r, *g, *b]);
    }
    lanes.load_vector(&channels)
}

const START_COMPRESSION: f32 = 0.8 - 0.04;
const DESATURATION: f32 = 0.15;

/// [`neutral`] of sixteen colours.
#[inline(always)]
fn neutral_lanes<F: Floats>(color: V3<F>) -> V3<F> {
    let least = color.x.min(color.y).min(color.z);
    let offset = F::select(least.lt(least.fill(0.08)), least - least * 6.25 * least, least.fill(0.04));
    let color = V3::new(color.x - offset, color.y - offset, color.z - offset);
    let peak = color.x.max(color.y).max(color.z);
    let d = 1.0 - START_COMPRESSION;
    let one = peak.fill(1.0);
    let new_peak = one - peak.fill(d * d) / (peak + d - START_COMPRESSION);
    let g = one - one / ((peak - new_peak) * DESATURATION + 1.0);
    let peaks = [peak, new_peak, g];
    V3::new(compressed(color.x, peaks), compressed(color.y, peaks), compressed(color.z, peaks))
}

#[inline(always)]
fn compressed<F: Floats>(c: F, [peak, new_peak, g]: [F; 3]) -> F {
    let compressed = c / peak * new_peak;
    F::select(peak.lt(peak.fill(START_COMPRESSION)), c, compressed + g * (new_peak - compressed))
}

/// Khronos PBR Neutral (Khronos 3D Commerce, 2024; specification "Khronos PBR Neutral Tone Mapper").
fn neutral(color: [f32; 3]) -> [f32; 3] {
    // Takes off what a dielectric with F0 = 0.04 reflects beside its base colour.
    let x = color[0].min(color[1]).min(color[2]);
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let color = color.map(|c| c - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < START_COMPRESSION {
        return color;
    }
    let d = 1.0 - START_COMPRESSION;
    let new_peak = 1.0 - d * d / (peak + d - START_COMPRESSION);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|c| {
        let compressed = c / peak * new_peak;
        compressed + g * (new_peak - compressed)
    })
}

/// Column-vector product of a row-major matrix.
fn transform(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Stephen Hill's fit of the ACES 1.0 reference rendering and sRGB output transforms (BakingLab, 2016),
/// with its matrices that go in and out of a space near ACEScg.
fn aces(color: [f32; 3]) -> [f32; 3] {
    const INPUT: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUTPUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let fitted = transform(&INPUT, color).map(|v| {
        // Beyond this the quotient is at its limit; the squares below would overflow.
        let v = v.min(1e15);
        (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081)
    });
    transform(&OUTPUT, fitted)
}

/// AgX (Troy Sobotka, 2022) in the polynomial fit of Benjamin Wrensch ("Minimal AgX implementation", 2023), base look.
fn agx(color: [f32; 3]) -> [f32; 3] {
    const MIN_EV: f32 = -12.473_93;
    const MAX_EV: f32 = 4.026_069;
    const INSET: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_635, -0.098_043_45, 1.151_073_7],
    ];
    let curved = transform(&INSET, color.map(|c| c.min(1e30))).map(|v| {
        let ev = libm::log2f(v.max(f32::MIN_POSITIVE)).max(MIN_EV).min(MAX_EV);
        let x = (ev - MIN_EV) / (MAX_EV - MIN_EV);
        let x2 = x * x;
        let x4 = x2 * x2;
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.429_8 * x2 + 0.119_1 * x - 0.002_32
    });
    // The curve gives display values of a pure power of 2.2; undo it.
    transform(&OUTSET, curved).map(|v| libm::powf(v.max(0.0), 2.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(operator: ToneMap, color: [f32; 3], want: [f32; 3]) {
        let got = apply(operator, color);
        for (g, w) in got.iter().zip(want) {
            assert!((g - w).abs() < 2e-5, "{operator:?} {color:?}: {got:?} instead of {want:?}");
        }
    }

    #[test]
    fn neutral_takes_off_the_reflection_and_keeps_hue_below_the_shoulder() {
        // By hand from the specification: x − 6.25x² in the toe, 0.04 above it.
        assert_near(ToneMap::Neutral, [0.04, 0.04, 0.04], [0.01, 0.01, 0.01]);
        assert_near(ToneMap::Neutral, [0.5, 0.2, 0.08], [0.46, 0.16, 0.04]);
        assert_near(ToneMap::Neutral, [0.75, 0.3, 0.0], [0.75, 0.3, 0.0]);
    }

    #[test]
    fn known_values_of_the_reference_shaders() {
        // The published GLSL, evaluated in double precision.
        let table: [([f32; 3], [[f32; 3]; 3]); 4] = [
            ([0.18; 3], [[0.14; 3], [0.105_591, 0.105_591, 0.105_590], [0.214_467, 0.214_533, 0.214_537]]),
            (
                [1.0, 0.5, 0.25],
                [
                    [0.869_091, 0.422_529, 0.199_248],
                    [0.634_990, 0.384_600, 0.203_160],
                    [0.610_114, 0.431_149, 0.291_676],
                ],
            ),
            (
                [4.0, 0.1, 0.02],
                [[0.983_365, 0.319_172, 0.305_547], [1.0, 0.240_216, 0.056_709], [0.995_127, 0.266_473, 0.202_920]],
            ),
            (
                [0.02, 0.3, 0.9],
                [[0.007_559, 0.272_777, 0.841_103], [0.0, 0.211_924, 0.567_051], [0.104_766, 0.330_365, 0.594_634]],
            ),
        ];
        for (color, [neutral, aces, agx]) in table {
            assert_near(ToneMap::Neutral, color, neutral);
            assert_near(ToneMap::Aces, color, aces);
            assert_near(ToneMap::Agx, color, agx);
        }
        assert_near(ToneMap::None, [0.25, 1.5, -1.0], [0.25, 1.0, 0.0]);
    }

    #[test]
    fn every_operator_is_monotone_on_greys_and_stays_in_range() {
        for operator in [ToneMap::Neutral, ToneMap::Aces, ToneMap::Agx, ToneMap::None] {
            let mut last = -1.0;
            for step in 0..4000 {
                let x = libm::powf(2.0, -10.0 + step as f32 * 0.005);
                let [r, g, b] = apply(operator, [x; 3]);
                assert!((0.0..=1.0).contains(&r) && r >= last - 2e-4, "{operator:?} at {x}: {r} after {last}");
                assert!((r - g).abs() < 2e-3 && (g - b).abs() < 2e-3, "{operator:?} keeps greys grey: {r} {g} {b}");
                last = r;
            }
            assert!(last > 0.95, "{operator:?} reaches white: {last}");
        }
    }

    #[test]
    fn extremes_are_survived() {
        for operator in [ToneMap::Neutral, ToneMap::Aces, ToneMap::Agx, ToneMap::None] {
            for color in [[f32::NAN, 1.0, -1.0], [f32::INFINITY; 3], [f32::MAX, 0.0, 0.0], [0.0; 3], [1e-40; 3]] {
                let mapped = apply(operator, color);
                assert!(mapped.iter().all(|c| (0.0..=1.0).contains(c)), "{operator:?} {color:?}: {mapped:?}");
            }
        }
    }
}
