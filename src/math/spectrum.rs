//! Wavelengths that stand for linear RGB: for what a surface does to each colour of light differently.

use std::sync::LazyLock;

/// The visible range, nanometres.
const FIRST: f64 = 380.0;
/// Width of a bin, nanometres.
const WIDTH: f64 = 5.0;
const BINS: usize = 68;

/// A wavelength with what a path that carries it alone has to be multiplied by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength {
    /// In nanometres.
    pub nanometres: f32,
    /// Linear RGB. Its mean over all numbers is (1, 1, 1), and it is never negative nor above 3.
    pub weight: [f32; 3],
}

struct Bin {
    /// Up to the end of this bin, from 0 to 1.
    cumulative: f64,
    weight: [f32; 3],
}

static TABLE: LazyLock<Vec<Bin>> = LazyLock::new(table);

/// The wavelength for a number in [0, 1), as often as it counts for the three channels together.
pub fn wavelength(u: f32) -> Wavelength {
    let u = f64::from(u);
    let table = &*TABLE;
    let bin = table.partition_point(|bin| bin.cumulative <= u).min(BINS - 1);
    let below = if bin == 0 { 0.0 } else { table[bin - 1].cumulative };
    let within = ((u - below) / (table[bin].cumulative - below)).clamp(0.0, 1.0);
    Wavelength { nanometres: (FIRST + WIDTH * (bin as f64 + within)) as f32, weight: table[bin].weight }
}

fn table() -> Vec<Bin> {
    let rgb: Vec<[f64; 3]> = (0..BINS).map(|k| linear_srgb(FIRST + WIDTH * (k as f64 + 0.5))).collect();
    let total: [f64; 3] = std::array::from_fn(|c| rgb.iter().map(|x| x[c]).sum());
    let mut cumulative = 0.0;
    let bins = rgb.into_iter().map(|x| {
        // Each channel's share of its own light, and the bin's share of all.
        let share: [f64; 3] = std::array::from_fn(|c| x[c] / total[c]);
        let probability = share.iter().sum::<f64>() / 3.0;
        cumulative += probability;
        Bin { cumulative, weight: share.map(|s| (s / probability) as f32) }
    });
    bins.collect()
}

/// What a wavelength looks like, out-of-gamut parts cut off.
fn linear_srgb(nanometres: f64) -> [f64; 3] {
    let [x, y, z] = cie_xyz(nanometres);
    // IEC 61966-2-1. A trace of light keeps the probability of every bin above 0.
    [3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z, 0.0557 * x - 0.2040 * y + 1.0570 * z]
        .map(|c| c.max(1e-6))
}

/// CIE 1931 colour matching functions, the fit of Wyman, Sloan & Shirley 2013 (JCGT 2(2), equation 4).
fn cie_xyz(nanometres: f64) -> [f64; 3] {
    let lobe = |mean: f64, below: f64, above: f64| {
        let t = (nanometres - mean) * if nanometres < mean { below } else { above };
        libm::exp(-0.5 * t * t)
    };
    [
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323) - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_and_no_weight_is_large() {
        let n = 100_000;
        let mut mean = [0.0f64; 3];
        let mut last = 0.0;
        for k in 0..n {
            let Wavelength { nanometres, weight } = wavelength((k as f32 + 0.5) / n as f32);
            assert!(nanometres >= last && (380.0..=720.0).contains(&nanometres));
            last = nanometres;
            for (mean, weight) in mean.iter_mut().zip(weight) {
                assert!((0.0..=3.0).contains(&weight));
                *mean += f64::from(weight) / f64::from(n);
            }
        }
        for mean in mean {
            assert!((mean - 1.0).abs() < 1e-4, "{mean}");
        }
        assert_eq!(wavelength(0.999_999_94).weight, wavelength(1.0).weight);
    }

    #[test]
    fn colours_come_in_the_order_of_the_rainbow() {
        let centre = |channel: usize| {
            let n = 10_000;
            let all = (0..n).map(|k| wavelength((k as f32 + 0.5) / n as f32));
            all.map(|w| f64::from(w.nanometres) * f64::from(w.weight[channel])).sum::<f64>() / f64::from(n)
        };
        let [red, green, blue] = [0, 1, 2].map(centre);
        // Where the primaries of sRGB lie: 611, 549 and 464 nm are their dominant wavelengths.
        assert!((590.0..620.0).contains(&red) && (530.0..560.0).contains(&green) && (440.0..470.0).contains(&blue));
    }
}
