use super::Plane;

/// Every 17th of the 256 colours of the map "magma" (van der Walt & Smith 2015, CC0), sRGB.
const MAGMA: [[u8; 3]; 16] = [
    [0, 0, 4],
    [11, 9, 36],
    [32, 17, 75],
    [59, 15, 112],
    [87, 21, 126],
    [114, 31, 129],
    [140, 41, 129],
    [168, 50, 125],
    [196, 60, 117],
    [222, 73, 104],
    [241, 96, 93],
    [250, 127, 94],
    [254, 159, 109],
    [254, 191, 132],
    [253, 222, 160],
    [252, 253, 191],
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
        assert_eq!((magma(f64::NAN), magma(-1.0), magma(7.0)), (MAGMA[0], MAGMA[0], MAGMA[15]));
    }
}
