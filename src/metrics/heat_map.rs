use super::Plane;

/// Every fifth of the 256 colours of the map "magma" (van der Walt & Smith 2015, CC0), sRGB.
#[rustfmt::skip]
const MAGMA: [[u8; 3]; 52] = [
    [0, 0, 4], [2, 2, 11], [5, 4, 22], [9, 7, 32], [14, 11, 43],
    [20, 14, 54], [26, 16, 66], [33, 17, 78], [41, 17, 90], [49, 17, 101],
    [57, 15, 110], [66, 15, 117], [74, 16, 121], [82, 19, 124], [90, 22, 126],
    [98, 25, 128], [106, 28, 129], [114, 31, 129], [121, 34, 130], [129, 37, 129],
    [137, 40, 129], [145, 43, 129], [153, 45, 128], [161, 48, 126], [170, 51, 125],
    [178, 53, 123], [186, 56, 120], [194, 59, 117], [202, 62, 114], [210, 66, 111],
    [217, 70, 107], [224, 76, 103], [231, 82, 99], [236, 88, 96], [241, 96, 93],
    [244, 105, 92], [247, 114, 92], [249, 123, 93], [251, 133, 96], [252, 142, 100],
    [253, 152, 105], [254, 161, 110], [254, 170, 116], [254, 180, 123], [254, 189, 130],
    [254, 198, 138], [254, 207, 146], [254, 216, 154], [253, 226, 163], [253, 235, 172],
    [252, 244, 182], [252, 253, 191],
];

/// Values from 0 (black) by purple and orange to 1 (pale yellow) as 8-bit sRGB, row by row; NaN is black.
pub fn heat_map(map: &Plane) -> Vec<[u8; 3]> {
    map.values.iter().map(|v| magma(*v)).collect()
}

fn magma(value: f64) -> [u8; 3] {
    let at = value.max(0.0).min(1.0) * (MAGMA.len() - 1) as f64;
    let below = (at as usize).min(MAGMA.len() - 2);
    let share = at - below as f64;
    let mix = |c: usize| {
        let (a, b) = (f64::from(MAGMA[below][c]), f64::from(MAGMA[below + 1][c]));
        (a + (b - a) * share + 0.5) as u8
    };
    [mix(0), mix(1), mix(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_near_those_of_the_full_map() {
        let full = nv_flip::magma_lut().to_vec();
        for (i, expected) in full.chunks_exact(3).enumerate() {
            let got = magma(i as f64 / 255.0);
            let near = got.iter().zip(expected).all(|(g, e)| g.abs_diff(*e) <= 2);
            assert!(near, "{i}: {got:?} for {expected:?}");
        }
        assert_eq!((magma(f64::NAN), magma(-1.0), magma(7.0)), (MAGMA[0], MAGMA[0], MAGMA[51]));
    }
}
