//! Whether a picture shows what is expected of it.

use super::file::{Expectation, Relation};
use crate::film::Film;
use crate::math::statistics::student_t_two_sided;

/// The probability that a correct renderer fails any of all checks by chance.
pub const SIGNIFICANCE: f64 = 1e-3;

/// What a comparison gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As expected.
    Pass,
    /// Not as expected.
    Fail,
    /// The standard error is too large to tell.
    Noisy,
    /// Fails, as the check's `known_failure` says.
    Known,
    /// Passes although the check's `known_failure` says that it cannot: the mark must go.
    Mended,
    /// The check could not be run.
    Error,
}

impl Verdict {
    /// Whether all is as the check's file says.
    pub fn is_good(self) -> bool {
        matches!(self, Self::Pass | Self::Known)
    }

    /// What the verdict is where a failure is known.
    pub(super) fn known(self) -> Self {
        match self {
            Self::Pass => Self::Mended,
            Self::Fail | Self::Noisy => Self::Known,
            other => other,
        }
    }
}

/// A comparison with the numbers of the channel (or pixel) that did worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Judgement {
    pub expected: f64,
    pub got: f64,
    pub standard_error: f64,
    pub verdict: Verdict,
}

/// Tests that [`judge`] makes of an expectation; all together are corrected for by Šidák's rule.
pub(super) fn tests(e: &Expectation) -> usize {
    if e.each_pixel { 0 } else { 3 }
}

/// Compares a part of a film with what is expected of it; `level` is the significance of a single test.
pub(super) fn judge(film: &Film, e: &Expectation, level: f64) -> Judgement {
    let [x0, y0, x1, y1] = e.region.unwrap_or([0, 0, film.width, film.height]);
    let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (y * film.width + x) as usize));
    let mut worst: Option<(f64, Judgement)> = None;
    let mut take = |badness: f64, judgement: Judgement| {
        if worst.is_none_or(|(w, _)| badness > w || badness.is_nan()) {
            worst = Some((badness, judgement));
        }
    };
    for (channel, expected) in e.value.rgb().into_iter().enumerate() {
        let tolerance = e.absolute + e.relative * expected;
        let beyond = |got: f64| {
            let off = match e.relation {
                Relation::Equal => (got - expected).abs(),
                Relation::AtMost => got - expected,
                Relation::AtLeast => expected - got,
            };
            // NaN is beyond everything.
            if off <= tolerance { 0.0 } else { (off - tolerance).abs().max(f64::MIN_POSITIVE) }
        };
        // Pixels that use each other's paths are exact together only.
        if e.each_pixel && !film.shares {
            for pixel in pixels.clone() {
                let got = film.pixels[pixel].mean()[channel];
                let verdict = if beyond(got) == 0.0 { Verdict::Pass } else { Verdict::Fail };
                take((got - expected).abs(), Judgement { expected, got, standard_error: 0.0, verdict });
            }
            continue;
        }
        let own = film.estimate(pixels.clone(), std::array::from_fn(|c| f64::from(u8::from(c == channel))));
        let (got, standard_error) = (own.mean, own.variance.sqrt());
        // Student's distribution is normal long before its formula loses digits.
        let degrees = own.degrees.min(1e5);
        let noise = standard_error > e.resolution * expected + e.absolute;
        let t = if beyond(got) == 0.0 { 0.0 } else { beyond(got) / standard_error };
        let verdict = if !(t == 0.0 || student_t_two_sided(t, degrees) > level) {
            Verdict::Fail
        } else if noise {
            Verdict::Noisy
        } else {
            Verdict::Pass
        };
        let badness = match verdict {
            Verdict::Fail => f64::MAX,
            Verdict::Noisy => 1e300,
            _ => (got - expected).abs() / standard_error.max(1e-9),
        };
        take(badness, Judgement { expected, got, standard_error, verdict });
    }
    worst.map_or(Judgement { expected: 0.0, got: 0.0, standard_error: 0.0, verdict: Verdict::Error }, |(_, j)| j)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::Level;
    use crate::film::PixelSums;

    /// A film of 16 pixels with samples `mean ± spread` that alternate between replicates.
    fn film(mean: f32, spread: f32) -> Film {
        let mut sums = PixelSums::default();
        (0..8).for_each(|s| sums.add(s, [mean + if s % 2 == 0 { spread } else { -spread }; 4]));
        Film { spp: 8, pixels: vec![sums; 16], ..Film::new(4, 4, true) }
    }

    fn expect(value: f64, relation: Relation) -> Expectation {
        Expectation {
            value: Level::Grey(value),
            region: None,
            relation,
            absolute: 0.0,
            relative: 1e-5,
            each_pixel: false,
            resolution: 0.02,
        }
    }

    #[test]
    fn differences_count_in_standard_errors_and_noise_is_no_excuse() {
        let verdict =
            |mean, spread, value, relation| judge(&film(mean, spread), &expect(value, relation), 1e-4).verdict;
        use Relation::{AtLeast, AtMost, Equal};
        // Standard error: spread / √16, with 16 degrees of freedom.
        assert_eq!(verdict(1.0, 0.05, 1.02, Equal), Verdict::Pass);
        assert_eq!(verdict(1.0, 0.05, 1.10, Equal), Verdict::Fail);
        assert_eq!(verdict(1.0, 0.05, 1.10, AtMost), Verdict::Pass);
        assert_eq!(verdict(1.0, 0.05, 1.10, AtLeast), Verdict::Fail);
        assert_eq!(verdict(1.0, 0.05, 0.90, AtMost), Verdict::Fail);
        assert_eq!(verdict(1.0, 1.0, 1.02, Equal), Verdict::Noisy);
        assert_eq!(verdict(1.0, 0.0, 1.0, Equal), Verdict::Pass);
        assert_eq!(verdict(1.0, 0.0, 1.0001, Equal), Verdict::Fail);
        assert_eq!(verdict(f32::NAN, 0.0, 1.0, AtMost), Verdict::Fail);
    }

    #[test]
    fn one_pixel_that_leaks_fails_where_the_mean_would_hide_it() {
        let mut film = film(1.0, 0.0);
        (0..8).for_each(|s| film.pixels[5].add(s, [0.001; 4]));
        let e = Expectation { each_pixel: true, ..expect(1.0, Relation::Equal) };
        let judgement = judge(&film, &e, 1e-4);
        assert_eq!(judgement.verdict, Verdict::Fail);
        assert!((judgement.got - 1.001).abs() < 1e-6);
        let elsewhere = Expectation { region: Some([2, 0, 4, 4]), ..e };
        assert_eq!(judge(&film, &elsewhere, 1e-4).verdict, Verdict::Pass);
    }
}
