//! Colour spaces of ꟻLIP, with its white point (that of the sRGB matrix: D65).

/// Linear Rec. 709 to XYZ, as the paper's implementation has it.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// Its inverse.
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];
/// XYZ of white.
const WHITE: [f64; 3] = [0.950_428_545, 1.0, 1.088_900_371];

fn transform(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn divide(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] / b[i])
}

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Encoded sRGB in [0, 1] to the opponent space YCxCz, linear in light.
pub(super) fn ycxcz(srgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = divide(transform(&TO_XYZ, srgb.map(decode)), WHITE);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// YCxCz, brought into the gamut, to CIELAB with chroma scaled by lightness: colours fade in the dark (Hunt's effect).
pub(super) fn hunt_adjusted_lab([luma, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (luma + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    let rgb = transform(&FROM_XYZ, std::array::from_fn(|i| relative[i] * WHITE[i])).map(|c| c.max(0.0).min(1.0));
    let [x, y, z] = divide(transform(&TO_XYZ, rgb), WHITE).map(|t| {
        let delta: f64 = 6.0 / 29.0;
        if t > delta * delta * delta { libm::cbrt(t) } else { t / (3.0 * delta * delta) + 4.0 / 29.0 }
    });
    let (lightness, a, b) = (116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z));
    [lightness, 0.01 * lightness * a, 0.01 * lightness * b]
}

/// Distance of colours that holds for large ones, too (Abasi, Amani Tehran & Fairchild 2019).
pub(super) fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + libm::hypot(a[1] - b[1], a[2] - b[2])
}
