//! Distribution functions for statistical tests and error bounds, in f64.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Terms after which series and continued fractions stop; they converge in about √(parameter) terms.
const MAX_TERMS: usize = 100_000;

/// Regularised lower and upper incomplete gamma functions (P(a, x), Q(a, x)) for a > 0, x ≥ 0 (DLMF 8.2.4): by the
/// series 8.7.1 below x = a + 1, by the continued fraction 8.9.2 (Lentz's method) above, so the smaller of the two
/// keeps its digits.
pub fn incomplete_gamma(a: f64, x: f64) -> (f64, f64) {
    let defined = a > 0.0 && x >= 0.0;
    if !defined {
        return (f64::NAN, f64::NAN);
    }
    if x == 0.0 {
        return (0.0, 1.0);
    }
    if x.is_infinite() {
        return (1.0, 0.0);
    }
    // x^a e^−x / Γ(a)
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..MAX_TERMS {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * 1e-17 {
                break;
            }
        }
        let p = (front * sum).min(1.0);
        (p, 1.0 - p)
    } else {
        let q = (front * lentz_gamma(a, x)).min(1.0);
        (1.0 - q, q)
    }
}

fn lentz_gamma(a: f64, x: f64) -> f64 {
    let tiny = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / tiny;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..MAX_TERMS {
        let i = i as f64;
        let an = -i * (i - a);
        b += 2.0;
        d = an * d + b;
        d = 1.0 / if d.abs() < tiny { tiny } else { d };
        c = b + an / c;
        c = if c.abs() < tiny { tiny } else { c };
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-16 {
            break;
        }
    }
    h
}

/// P(X ≥ `statistic`) for X chi-squared with `degrees` > 0 degrees of freedom: the p-value of a chi² test.
pub fn chi2_survival(statistic: f64, degrees: f64) -> f64 {
    incomplete_gamma(0.5 * degrees, 0.5 * statistic.max(0.0)).1
}

/// Regularised incomplete beta function I_x(a, b), 0 ≤ x ≤ 1, by the continued fraction DLMF 8.17.22.
pub fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    let defined = a > 0.0 && b > 0.0 && (0.0..=1.0).contains(&x);
    if !defined {
        return f64::NAN;
    }
    if x == 0.0 || x == 1.0 {
        return x;
    }
    let log_front = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log1p(-x);
    let front = libm::exp(log_front);
    // The fraction converges fast for x below the mean; above it, I_x(a, b) = 1 − I_{1−x}(b, a).
    if x < (a + 1.0) / (a + b + 2.0) {
        front * lentz_beta(a, b, x) / a
    } else {
        1.0 - front * lentz_beta(b, a, 1.0 - x) / b
    }
}

fn lentz_beta(a: f64, b: f64, x: f64) -> f64 {
    let tiny = 1e-300;
    let guard = |v: f64| if v.abs() < tiny { tiny } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / guard(1.0 - (a + b) * x / (a + 1.0));
    let mut h = d;
    for m in 1..MAX_TERMS {
        let m = m as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / guard(1.0 + even * d);
        c = guard(1.0 + even / c);
        h *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / guard(1.0 + odd * d);
        c = guard(1.0 + odd / c);
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-16 {
            break;
        }
    }
    h
}

/// P(T ≤ t) for Student's t with `degrees` > 0 degrees of freedom. Beyond 1e6 degrees log-gammas cancel: use
/// [`normal_cdf`], which then is the same to 1e-6.
pub fn student_t_cdf(t: f64, degrees: f64) -> f64 {
    let tail = 0.5 * incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t));
    if t < 0.0 { tail } else { 1.0 - tail }
}

/// P(|T| ≥ |t|): the p-value of a two-sided t-test, exact in the far tail.
pub fn student_t_two_sided(t: f64, degrees: f64) -> f64 {
    incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t))
}

/// P(X ≤ x) for Fisher's F with `d1` and `d2` > 0 degrees of freedom, x ≥ 0.
pub fn f_cdf(x: f64, d1: f64, d2: f64) -> f64 {
    incomplete_beta(0.5 * d1, 0.5 * d2, d1 * x / (d1 * x + d2))
}

/// The x with [`f_cdf`]`(x) = p`, 0 < p < 1, for Fisher's F with `d1` and `d2` > 0 degrees of freedom, to ten digits or so;
/// infinite where it is beyond 1e30. By bisection of the logarithm: the distribution is monotone, and nothing can go astray.
pub fn f_quantile(p: f64, d1: f64, d2: f64) -> f64 {
    let defined = p > 0.0 && p < 1.0 && d1 > 0.0 && d2 > 0.0;
    if !defined {
        return f64::NAN;
    }
    // More degrees of freedom than this change no digit that matters, but cost many terms.
    let (d1, d2) = (d1.min(1e7), d2.min(1e7));
    // P(X > x), which keeps its digits in the far tail.
    let survival = |ln_x: f64| incomplete_beta(0.5 * d2, 0.5 * d1, d2 / (d1 * libm::exp(ln_x) + d2));
    let mut range = (-70.0, 70.0);
    if survival(range.1) > 1.0 - p {
        return f64::INFINITY;
    }
    while range.1 - range.0 > 1e-11 {
        let middle = 0.5 * (range.0 + range.1);
        if survival(middle) > 1.0 - p {
            range.0 = middle;
        } else {
            range.1 = middle;
        }
    }
    libm::exp(0.5 * (range.0 + range.1))
}

/// P(Z ≤ z) for the standard normal.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// P(|Z| ≥ |z|): the p-value of a two-sided z-test, exact in the far tail.
pub fn normal_two_sided(z: f64) -> f64 {
    libm::erfc(z.abs() * FRAC_1_SQRT_2)
}

/// The z with [`normal_cdf`]`(z) = p`; ±∞ at 0 and 1, NaN outside.
///
/// A rational start (Abramowitz & Stegun 26.2.23, |error| < 4.5e-4), then Halley's steps.
pub fn normal_quantile(p: f64) -> f64 {
    if p == 0.0 || p == 1.0 {
        return if p == 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    let tail = p.min(1.0 - p);
    let t = libm::sqrt(-2.0 * libm::log(tail));
    let rational =
        (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let mut z = rational - t;
    for _ in 0..4 {
        // Newton's step e = (Φ(z) − p) / φ(z), and Halley's correction with φ'/φ = −z.
        let e = (normal_cdf(z) - tail) * libm::sqrt(2.0 * PI) * libm::exp(0.5 * z * z);
        z -= e / (1.0 + 0.5 * z * e);
    }
    if p <= 0.5 { z } else { -z }
}

/// The level for each of `tests` independent tests so that all together raise a false alarm with probability `level`:
/// Šidák 1967, 1 − (1 − level)^(1/tests).
pub fn sidak(level: f64, tests: usize) -> f64 {
    -libm::expm1(libm::log1p(-level) / tests.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values are mpmath's at 30 digits.
    fn close(name: &str, got: f64, expected: f64, relative: f64) {
        assert!((got - expected).abs() <= relative * expected.abs(), "{name}: {got} instead of {expected}");
    }

    #[test]
    fn chi2_survival_has_known_values() {
        for (x, k, p) in [
            (3.841_458_820_694_124, 1.0, 0.05),
            (18.307_038_053_275_146, 10.0, 0.05),
            (0.5, 3.0, 0.918_891_411_654_675_9),
            (1100.0, 1000.0, 0.014_614_408_126_295_19),
            (3300.0, 3000.0, 8.513_849_707_271_668e-5),
            (250.0, 40.0, 3.469_536_887_053_956e-32),
        ] {
            close(&format!("chi2_survival({x}, {k})"), chi2_survival(x, k), p, 1e-11);
        }
        assert_eq!(chi2_survival(0.0, 5.0), 1.0);
        assert_eq!(chi2_survival(f64::INFINITY, 5.0), 0.0);
        assert!(chi2_survival(1.0, 0.0).is_nan(), "0 degrees of freedom are no test");
    }

    #[test]
    fn lower_and_upper_incomplete_gamma_add_up() {
        for a in [0.1, 1.0, 7.5, 400.0] {
            for x in [0.01, 0.9, 7.0, 8.6, 390.0, 500.0] {
                let (p, q) = incomplete_gamma(a, x);
                assert!((p + q - 1.0).abs() < 1e-14 && p >= 0.0 && q >= 0.0, "a {a}, x {x}: {p} + {q}");
            }
        }
        close("1 − e^−x", incomplete_gamma(1.0, 0.7).0, 1.0 - libm::exp(-0.7), 1e-14);
    }

    #[test]
    fn student_t_has_known_values() {
        for (t, n, p) in [
            (1.0, 1.0, 0.75),
            (2.228_138_851_964_939, 10.0, 0.974_999_999_999_095_7),
            (-3.5, 4.0, 0.012_448_081_730_111_38),
            (1.2, 2.5, 0.834_280_581_167_061_2),
            (0.01, 200.0, 0.503_984_372_423_359_4),
            (-10.0, 30.0, 2.287_625_704_114_807e-11),
        ] {
            close(&format!("student_t_cdf({t}, {n})"), student_t_cdf(t, n), p, 1e-11);
            close("two-sided", student_t_two_sided(t, n), 2.0 * p.min(1.0 - p), 1e-10);
        }
        close("many degrees are normal", student_t_cdf(1.5, 1e6), normal_cdf(1.5), 3e-7);
    }

    #[test]
    fn incomplete_beta_has_known_values() {
        close("I_0.4(2.5, 3.5)", incomplete_beta(2.5, 3.5, 0.4), 0.486_904_191_526_117_6, 1e-13);
        close("I_0.99(50, 0.5)", incomplete_beta(50.0, 0.5, 0.99), 0.317_304_397_874_197_4, 1e-12);
        assert_eq!((incomplete_beta(2.0, 3.0, 0.0), incomplete_beta(2.0, 3.0, 1.0)), (0.0, 1.0));
        assert!(incomplete_beta(2.0, 3.0, 1.5).is_nan());
    }

    #[test]
    fn f_quantiles_have_known_values() {
        // F₀.₉₅(d, ∞) is χ²₀.₉₅(d) / d; F₀.₉₅(1, d) is t₀.₉₇₅(d)²; the others from tables.
        for (d1, d2, x) in [
            (1.0, 10.0, 2.228_138_851_964_939 * 2.228_138_851_964_939),
            (10.0, 1e7, 1.830_703_8),
            (2.0, 3.0, 9.552_094_495_921_155),
            (100.0, 100.0, 1.391_719_552_6),
        ] {
            close(&format!("f_quantile(0.95, {d1}, {d2})"), f_quantile(0.95, d1, d2), x, 2e-6);
        }
        close("f_cdf of its quantile", f_cdf(f_quantile(0.99, 1.7, 5.1), 1.7, 5.1), 0.99, 1e-9);
        // ln F is normal with variance 2 / d1 + 2 / d2 then; more than 1e7 degrees count as 1e7.
        close("many degrees", f_quantile(0.95, 1e9, 3e9), libm::exp(1.644_853_627 * libm::sqrt(4e-7)), 1e-8);
        assert!(f_quantile(0.95, 0.0, 5.0).is_nan());
        assert_eq!(f_quantile(0.95, 1e-3, 1e-3), f64::INFINITY);
    }

    #[test]
    fn normal_has_known_values_far_into_the_tail() {
        for (z, p) in [
            (0.0, 0.5),
            (1.959_963_984_540_054, 0.975),
            (-5.0, 2.866_515_718_791_939e-7),
            (-8.5, 9.479_534_822_203_318e-18),
            (-20.0, 2.753_624_118_606_234e-89),
        ] {
            close(&format!("normal_cdf({z})"), normal_cdf(z), p, 1e-12);
        }
        close("two-sided", normal_two_sided(-9.0), 2.257_176_811_907_681e-19, 1e-12);
    }

    #[test]
    fn normal_quantile_undoes_the_cdf() {
        for (p, z) in [
            (0.975, 1.959_963_984_540_054),
            (0.3, -0.524_400_512_708_040_8),
            (1e-10, -6.361_340_902_404_056),
            (1e-100, -21.273_453_560_965_32),
            (0.999_999_9, 5.199_337_582_192_817),
        ] {
            close(&format!("normal_quantile({p})"), normal_quantile(p), z, 1e-9);
        }
        assert!(normal_quantile(0.5).abs() < 1e-15);
        assert_eq!(normal_quantile(0.0), f64::NEG_INFINITY);
        assert!(normal_quantile(-0.1).is_nan());
    }

    #[test]
    fn sidak_keeps_the_familywise_level() {
        close("10 tests", sidak(0.05, 10), 0.005_116_196_891_823_701, 1e-13);
        close("1000 tests", sidak(0.01, 1000), 1.005_028_534_904_525e-5, 1e-13);
        close("one test", sidak(0.05, 1), 0.05, 1e-15);
    }
}
