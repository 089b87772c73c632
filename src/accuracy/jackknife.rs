use crate::film::{PixelSums, replicate_samples};
use crate::lanes::LANES;
use crate::sampling::REPLICATES;

/// One number for each of sixteen pixels.
pub(super) type Each = [f64; LANES];

/// The code below tells two replicates apart.
const _: () = assert!(REPLICATES == 2);

/// Sixteen pixels: their means, and what they would be without one replicate or the other.
pub(super) struct LeaveOneOut {
    /// 1 where the asset covers the pixel, else 0; then nothing else here need be a number.
    pub covered: Each,
    /// Means of all samples: linear, premultiplied red, green, blue and the asset's coverage.
    pub mean: [Each; 4],
    /// Without the first replicate, and without the second one.
    pub without: [[Each; 4]; 2],
    /// Sum of the variances of red, green and blue, as [`PixelSums::variance`] has them.
    pub noise: Each,
    weights: [Each; 2],
    /// The share of a single bright sample in how the replicates differ, 0 to 1.
    spiked: Each,
}

impl LeaveOneOut {
    /// Of up to sixteen pixels with two samples or more; those with fewer count as not covered.
    #[inline(always)]
    pub fn of(pixels: &[PixelSums]) -> Self {
        let mut sums = [[[0.0; LANES]; 4]; 2];
        let (mut samples, mut spike) = ([[1.0; LANES]; 2], [0.0; LANES]);
        for (i, pixel) in pixels.iter().enumerate().take(LANES) {
            for (r, replicate) in pixel.replicate_sums().iter().enumerate() {
                samples[r][i] = f64::from(replicate_samples(pixel.samples(), r as u32).max(1));
                for c in 0..4 {
                    sums[r][c][i] = replicate[c];
                }
            }
            spike[i] = pixel.spike();
            if pixel.samples() < REPLICATES {
                (sums[0][3][i], sums[1][3][i]) = (0.0, 0.0);
            }
        }
        Self::of_sums(&sums, &samples, &spike)
    }

    #[inline(always)]
    fn of_sums(sums: &[[Each; 4]; 2], samples: &[Each; 2], spike: &Each) -> Self {
        let zero = [0.0; LANES];
        let mut all = Self {
            covered: zero,
            mean: [zero; 4],
            without: [[zero; 4]; 2],
            noise: zero,
            weights: [zero; 2],
            spiked: zero,
        };
        for i in 0..LANES {
            let n = samples[0][i] + samples[1][i];
            for (c, (first, second)) in sums[0].iter().zip(&sums[1]).enumerate() {
                let mean = (first[i] + second[i]) / n;
                all.mean[c][i] = mean;
                all.without[0][c][i] = second[i] / samples[1][i];
                all.without[1][c][i] = first[i] / samples[0][i];
                if c < 3 {
                    let off = [all.without[1][c][i] - mean, all.without[0][c][i] - mean];
                    all.noise[i] += (samples[0][i] * off[0] * off[0] + samples[1][i] * off[1] * off[1]) / n;
                }
            }
            all.covered[i] = if all.mean[3][i] > 0.0 { 1.0 } else { 0.0 };
            // The jackknife of groups of unequal size (Busing, Meijer & van der Leeden 1999), about the whole picture instead
            // of the mean of the parts: so it has the curve's bias in it.
            all.weights[0][i] = (n / samples[0][i] - 1.0) / 2.0;
            all.weights[1][i] = (n / samples[1][i] - 1.0) / 2.0;
            let share = spike[i] / (0.5 * (all.brightness(0, i) - all.brightness(1, i)).abs());
            all.spiked[i] = if share < 1.0 { share } else { 1.0 };
        }
        all
    }

    /// Red, green and blue without a replicate, all three.
    #[inline(always)]
    fn brightness(&self, replicate: usize, i: usize) -> f64 {
        let [r, g, b, _] = &self.without[replicate];
        r[i] + g[i] + b[i]
    }

    /// Σ weight · squares without a replicate: the estimate of the expected square of (picture − converged) where the squares are
    /// those of (picture without a replicate − picture).
    #[inline(always)]
    pub fn sum(&self, squares: &[Each; 2]) -> Each {
        let mut sum = [0.0; LANES];
        for i in 0..LANES {
            sum[i] = self.weights[0][i] * squares[0][i] + self.weights[1][i] * squares[1][i];
        }
        sum
    }

    /// The same where the squares are bent. Where one bright sample (a firefly) is all the difference between two replicates, the converged
    /// pixel is near the darker of them, and how far the brighter one is counts for nothing: on a screen both it and the whole may be
    /// white.
    #[inline(always)]
    pub fn sum_beyond_fireflies(&self, squares: &[Each; 2]) -> Each {
        let mut sum = self.sum(squares);
        for i in 0..LANES {
            let second_is_darker = self.brightness(1, i) <= self.brightness(0, i);
            let towards_darker = if second_is_darker { squares[1][i] } else { squares[0][i] };
            sum[i] += self.spiked[i] * self.spiked[i] * (towards_darker - sum[i]);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_replicates_say_what_the_pixel_would_be_without_the_other() {
        let mut pixel = PixelSums::default();
        [1.0, 5.0, 3.0].iter().enumerate().for_each(|(s, x)| pixel.add(s as u32, [*x, 0.0, 2.0 * *x, 1.0]));
        let lone = PixelSums::default();
        let parts = LeaveOneOut::of(&[lone, pixel]);
        assert_eq!((parts.covered[0], parts.covered[1], parts.covered[2]), (0.0, 1.0, 0.0));
        assert_eq!((parts.mean[0][1], parts.without[0][0][1], parts.without[1][2][1]), (3.0, 5.0, 4.0));
        let of_film: f64 = pixel.variance().iter().sum();
        assert!((parts.noise[1] - of_film).abs() < 1e-12 * of_film, "{} {of_film}", parts.noise[1]);
        // Squares 4 and 1 about the mean: weighted (3/2 − 1)/2 and (3 − 1)/2, they say what the variance of the mean is.
        let sum = parts.sum(&[[4.0; LANES], [1.0; LANES]])[1];
        assert!((sum - pixel.variance()[0]).abs() < 1e-12, "{sum}");
    }
}
