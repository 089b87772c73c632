use crate::film::{PixelSums, replicate_samples};
use crate::sampling::REPLICATES;

/// The most replicates.
const MOST: usize = REPLICATES as usize;

/// A pixel's mean, and what it would be without one replicate after the other.
pub(super) struct LeaveOneOut {
    /// Mean of all samples: linear, premultiplied RGB and the asset's coverage.
    pub mean: [f64; 4],
    without: [[f64; 4]; MOST],
    weights: [f64; MOST],
    count: usize,
    /// The share of a single bright sample in how the first two replicates differ, 0 to 1.
    spiked: f64,
}

impl LeaveOneOut {
    /// Of a pixel with two samples or more.
    pub fn of(pixel: &PixelSums) -> Self {
        let spp = pixel.samples();
        let sums = pixel.replicate_sums();
        let total: [f64; 4] = std::array::from_fn(|c| sums.iter().map(|s| s[c]).sum());
        let n = f64::from(spp);
        let mut result =
            Self { mean: total.map(|t| t / n), without: [[0.0; 4]; MOST], weights: [0.0; MOST], count: 0, spiked: 0.0 };
        let filled = spp.min(REPLICATES);
        for r in 0..filled {
            let own = f64::from(replicate_samples(spp, r));
            let k = r as usize;
            result.without[k] = std::array::from_fn(|c| (total[c] - sums[k][c]) / (n - own));
            // The jackknife of groups of unequal size (Busing, Meijer & van der Leeden 1999), about the whole picture instead
            // of the mean of the parts: so it has the curve's bias in it.
            result.weights[k] = (n / own - 1.0) / f64::from(filled);
        }
        result.count = filled as usize;
        if filled == 2 {
            let [a, b] = result.first_two().map(|[r, g, b, _]| r + g + b);
            result.spiked = (pixel.spike() / (0.5 * (a - b).abs())).min(1.0);
        }
        result
    }

    /// The pixel without its first replicate, and without its second one.
    pub fn first_two(&self) -> [[f64; 4]; 2] {
        [self.without[0], self.without[1]]
    }

    /// Σ weight · `square`(picture without a replicate): the estimate of the expected square of (picture − converged) where
    /// `square` measures (picture without a replicate − picture)².
    pub fn sum(&self, square: impl Fn(&[f64; 4]) -> f64) -> f64 {
        (0..self.count).map(|k| self.weights[k] * square(&self.without[k])).sum()
    }

    /// The same where `square` is bent. Where one bright sample (a firefly) is all the difference between two replicates, the converged
    /// pixel is near the darker of them, and how far the brighter one is counts for nothing: on a screen both it and the whole may be
    /// white.
    pub fn sum_beyond_fireflies(&self, square: impl Fn(&[f64; 4]) -> f64) -> f64 {
        let mean = self.sum(&square);
        if !(self.spiked > 0.0) {
            return mean;
        }
        let [a, b] = self.first_two().map(|[r, g, b, _]| r + g + b);
        let towards_darker = square(&self.without[usize::from(b <= a)]);
        mean + self.spiked * self.spiked * (towards_darker - mean)
    }
}
