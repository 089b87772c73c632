use crate::film::Estimate;
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
    /// From the mean luminances of independent pictures and of the reference, by Welch's test. `None` when there is no picture,
    /// or nothing is lit.
    pub fn of(pictures: &[Estimate], reference: &Estimate) -> Option<Self> {
        let own = Estimate::mean_of(pictures)?;
        if !(reference.mean > 0.0) {
            return None;
        }
        let variance = own.variance + reference.variance;
        let share = |e: &Estimate| e.variance * e.variance / e.degrees;
        let degrees = variance * variance / (share(&own) + share(reference));
        // Without any spread (a scene without noise) the difference is rounding.
        let degrees = if degrees.is_finite() { degrees.min(1e5) } else { 1e5 };
        let (error, difference) = (variance.sqrt(), own.mean - reference.mean);
        Some(Self {
            relative: difference / reference.mean,
            half_width: student_t_quantile(0.975, degrees) * error / reference.mean,
            t: if error > 0.0 { difference / error } else { 0.0 },
            degrees,
        })
    }

    /// Whether the difference is significant at a level (two-sided).
    pub fn is_significant(&self, level: f64) -> bool {
        crate::math::statistics::student_t_two_sided(self.t, self.degrees) < level
    }
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
        // Four values 1.1, 0.9, 1.0, 1.2 against 1.0, 1.02, 0.98, 1.0 (mpmath).
        let four = |mean: f64, squares: f64| Estimate { mean, variance: squares / 12.0, degrees: 3.0 };
        let reference = four(1.0, 0.0008);
        let bias = Bias::of(&[four(1.05, 0.05)], &reference).expect("enough");
        assert!((bias.relative - 0.05).abs() < 1e-12);
        assert!(!bias.is_significant(0.05) && bias.half_width > 0.05 && bias.degrees < 3.2);
        // Two pictures of half the variance say as much as one.
        let half = Estimate { degrees: 1.5, ..four(1.05, 0.1) };
        let halves = Bias::of(&[half, half], &reference).expect("enough");
        assert!((halves.t - bias.t).abs() < 1e-12 && (halves.degrees - bias.degrees).abs() < 1e-9);
        let dark = Bias::of(&[four(0.5, 0.0002)], &reference).expect("enough");
        assert!(dark.is_significant(1e-4) && (dark.relative + 0.5).abs() < 1e-12);
        assert_eq!(Bias::of(&[], &reference), None);
        assert_eq!(Bias::of(&[reference], &four(0.0, 0.0)), None);
    }
}
