use crate::math::statistics::{normal_quantile, student_t_cdf};
use serde::Serialize;

/// How far the mean brightness of a way's pictures is from the reference's: what more samples would not mend.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// Difference of the mean luminance, over the reference's.
    pub relative: f64,
    /// Half the width of its 95 % confidence interval.
    pub half_width: f64,
    /// Student's t of it: differences over their standard error.
    pub t: f64,
    /// Degrees of freedom of `t`.
    pub degrees: f64,
}

impl Bias {
    /// From the mean luminances of independent pictures (replicates) and of the reference's replicates, by Welch's test.
    /// `None` when there are fewer than two of either, or nothing is lit.
    pub fn of(pictures: &[f64], reference: &[f64]) -> Option<Self> {
        let (mean, variance) = mean_and_its_variance(pictures)?;
        let (expected, own) = mean_and_its_variance(reference)?;
        if !(expected > 0.0) {
            return None;
        }
        let both = variance + own;
        let share = |v: f64, n: usize| v * v / (n as f64 - 1.0);
        let degrees = both * both / (share(variance, pictures.len()) + share(own, reference.len()));
        // Without any spread (a scene without noise) the difference is rounding.
        let degrees = if degrees.is_finite() { degrees } else { 1e6 };
        let error = both.sqrt();
        let t = if error > 0.0 { (mean - expected) / error } else { 0.0 };
        Some(Self {
            relative: (mean - expected) / expected,
            half_width: student_t_quantile(0.975, degrees) * error / expected,
            t,
            degrees,
        })
    }

    /// Whether the difference is significant at a level (two-sided).
    pub fn is_significant(&self, level: f64) -> bool {
        crate::math::statistics::student_t_two_sided(self.t, self.degrees) < level
    }
}

fn mean_and_its_variance(values: &[f64]) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (values.len() > 1).then(|| (mean, squares / (n - 1.0) / n))
}

/// The t below which Student's distribution has the share `p` ≥ 1/2, by bisection.
fn student_t_quantile(p: f64, degrees: f64) -> f64 {
    if degrees >= 1e5 {
        return normal_quantile(p);
    }
    let (mut low, mut high) = (0.0, 1e4);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if student_t_cdf(middle, degrees) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn welch_of_a_textbook() {
        // t(0.975) for 10 degrees and the interval of two samples with known moments (mpmath).
        assert!((student_t_quantile(0.975, 10.0) - 2.228_138_851_964_939).abs() < 1e-9);
        let bias = Bias::of(&[1.1, 0.9, 1.0, 1.2], &[1.0, 1.02, 0.98, 1.0]).expect("enough");
        assert!((bias.relative - 0.05).abs() < 1e-12);
        assert!(!bias.is_significant(0.05) && bias.half_width > 0.05);
        let dark = Bias::of(&[0.5, 0.51, 0.49, 0.5], &[1.0, 1.02, 0.98, 1.0]).expect("enough");
        assert!(dark.is_significant(1e-4) && (dark.relative + 0.5).abs() < 1e-12);
        assert_eq!(Bias::of(&[1.0], &[1.0, 1.0]), None);
        assert_eq!(Bias::of(&[0.0, 0.0], &[0.0, 0.0]), None);
    }
}
