use rayon::prelude::*;

/// One channel of a picture, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Width in pixels, ≥ 1.
    pub width: usize,
    /// `width · height` values.
    pub values: Vec<f64>,
}

impl Plane {
    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// The mean of all values.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// The value below which the share `p` in [0, 1] of all values lies (nearest rank); NaN sorts last.
    pub fn quantile(&self, p: f64) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = (p * sorted.len() as f64) as usize;
        sorted[rank.min(sorted.len() - 1)]
    }

    /// A value for each pair of values.
    pub(super) fn zip(&self, other: &Self, of: impl Fn(f64, f64) -> f64 + Sync) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| of(*a, *b)).collect();
        Self { width: self.width, values }
    }

    /// Correlates with `across` along the rows and `down` along the columns; kernels have odd lengths, and the picture
    /// goes on with its edge.
    pub(super) fn filter(&self, across: &[f64], down: &[f64]) -> Self {
        self.filter_across(across).filter_down(down)
    }

    pub(super) fn filter_across(&self, kernel: &[f64]) -> Self {
        let radius = kernel.len() / 2;
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_mut(self.width).zip(self.values.par_chunks(self.width)).for_each(|(out, row)| {
            let (first, last) = (row[0], row[row.len() - 1]);
            let mut padded = vec![first; radius];
            padded.extend_from_slice(row);
            padded.resize(row.len() + 2 * radius, last);
            for (shift, weight) in kernel.iter().enumerate() {
                out.iter_mut().zip(&padded[shift..]).for_each(|(sum, value)| *sum += weight * value);
            }
        });
        Self { width: self.width, values }
    }

    pub(super) fn filter_down(&self, kernel: &[f64]) -> Self {
        let (radius, last) = (kernel.len() / 2, self.height() - 1);
        let mut values = vec![0.0; self.values.len()];
        values.par_chunks_mut(self.width).enumerate().for_each(|(y, out)| {
            for (shift, weight) in kernel.iter().enumerate() {
                let from = (y + shift).saturating_sub(radius).min(last) * self.width;
                let row = &self.values[from..from + self.width];
                out.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
            }
        });
        Self { width: self.width, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_go_on_with_the_edge() {
        let plane = Plane { width: 3, values: vec![1.0, 2.0, 4.0, 10.0, 20.0, 40.0] };
        assert_eq!(plane.filter_across(&[1.0, 0.0, 0.5]).values, [2.0, 3.0, 4.0, 20.0, 30.0, 40.0]);
        assert_eq!(plane.filter_down(&[1.0, 0.0, 0.5]).values, [6.0, 12.0, 24.0, 6.0, 12.0, 24.0]);
        // Wider than the picture: weights still add up.
        let constant = Plane { width: 2, values: vec![3.0; 4] }.filter(&[0.2; 5], &[0.2; 5]);
        assert!(constant.values.iter().all(|v| (v - 3.0).abs() < 1e-12));
    }

    #[test]
    fn quantiles_are_ranks() {
        let plane = Plane { width: 4, values: vec![3.0, 1.0, 2.0, 0.0] };
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|p| plane.quantile(p)), [0.0, 2.0, 3.0, 3.0]);
        assert_eq!(plane.mean(), 1.5);
    }
}
