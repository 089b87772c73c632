//! Pearson's chi² test of samples against expected counts.

use super::statistics::chi2_survival;

/// Cells are pooled until as many samples as this are expected in them (Cochran's rule).
const SMALLEST_EXPECTED: f64 = 5.0;

/// Cells are called empty when fewer samples than this are expected in them.
const EMPTY: f64 = 1e-4;

/// So many samples more than expected in all empty cells together have a probability below 1e-9 (Poisson), however
/// many cells there are; a pool that contains a full cell would hide them.
const MOST_STRAYS: f64 = 10.0;

/// What a chi² test found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chi2 {
    /// Σ (observed − expected)² / expected over pooled cells.
    pub statistic: f64,
    /// Pooled cells less 1.
    pub degrees: usize,
    /// Probability of a statistic at least as large when the expectation is right.
    pub p_value: f64,
}

/// Compares observed with expected counts, cell by cell; both should have the same total. Cells where few samples are
/// expected (or a rounding error less than none) are pooled, the emptiest first, so that samples where none belong
/// still count.
pub fn chi2_test(observed: &[f64], expected: &[f64]) -> Chi2 {
    let mut cells: Vec<(f64, f64)> = expected.iter().map(|e| e.max(0.0)).zip(observed.iter().copied()).collect();
    cells.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pools: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    for (expected, observed) in cells {
        open = (open.0 + expected, open.1 + observed);
        if open.0 >= SMALLEST_EXPECTED {
            pools.push(std::mem::take(&mut open));
        }
    }
    if let Some(last) = pools.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    let statistic = pools.iter().map(|(e, o)| (o - e) * (o - e) / e).sum();
    let degrees = pools.len().saturating_sub(1);
    let empty = expected.iter().zip(observed).filter(|(e, _)| **e < EMPTY);
    let strays: f64 = empty.map(|(e, o)| o - 2.0 * e.max(0.0)).sum();
    let p_value = if strays > MOST_STRAYS {
        0.0
    } else if degrees > 0 {
        chi2_survival(statistic, degrees as f64)
    } else {
        1.0
    };
    Chi2 { statistic, degrees, p_value }
}

#[cfg(test)]
mod tests {
    use super::chi2_test;

    #[test]
    fn statistic_and_degrees_follow_the_definition() {
        // (12−10)²/10 + (8−10)²/10 + (35−40)²/40 + (45−40)²/40 = 0.8 + 1.25
        let t = chi2_test(&[12.0, 8.0, 35.0, 45.0], &[10.0, 10.0, 40.0, 40.0]);
        assert!((t.statistic - 2.05).abs() < 1e-12);
        assert_eq!(t.degrees, 3);
        // Q(1.5, 1.025) by mpmath
        assert!((t.p_value - 0.562_094_137_0).abs() < 1e-9, "{}", t.p_value);
    }

    #[test]
    fn sparse_cells_are_pooled_and_none_is_lost() {
        let t = chi2_test(&[100.0, 2.0, 3.0, 1.0, 0.0], &[98.0, 2.0, 3.5, 1.5, 1.0]);
        // Pools: 1 + 1.5 + 2 + 3.5 = 8 (observed 6) and 98 (observed 100).
        assert_eq!(t.degrees, 1);
        assert!((t.statistic - (4.0 / 8.0 + 4.0 / 98.0)).abs() < 1e-12);
    }

    #[test]
    fn samples_where_none_are_expected_are_found() {
        let t = chi2_test(&[100_000.0, 100_000.0, 15.0], &[100_007.5, 100_007.5, 0.0]);
        assert_eq!(t.p_value, 0.0, "15 strays are nothing to their pool's statistic of {}", t.statistic);
        let t = chi2_test(&[100_000.0, 100_000.0, 2.0], &[100_001.0, 100_001.0, 0.0]);
        assert!(t.p_value > 0.5, "two samples off by rounding are no error");
    }
}
