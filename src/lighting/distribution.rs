//! Piecewise constant distributions, sampled by inversion (pbrt 4ed, A.4.7), which keeps stratified numbers stratified.

/// A discrete distribution over `len` items.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// `cumulative[i]` is the sum of the first `i` weights.
    cumulative: Vec<f64>,
}

impl Discrete {
    /// From weights ≥ 0.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for w in weights {
            sum += w;
            cumulative.push(sum);
        }
        Self { cumulative }
    }

    /// Sum of all weights.
    pub fn total(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Probability of item `i` among the first `count` items.
    pub fn probability(&self, i: usize, count: usize) -> f32 {
        let total = self.cumulative[count];
        if total > 0.0 { ((self.cumulative[i + 1] - self.cumulative[i]) / total) as f32 } else { 0.0 }
    }

    /// Chooses among the first `count` items with `u` in [0, 1): the item, and `u` stretched over its share for
    /// use again. `None` when all their weights are zero.
    pub fn sample(&self, u: f32, count: usize) -> Option<(usize, f32)> {
        let total = self.cumulative[count];
        if total <= 0.0 {
            return None;
        }
        let x = f64::from(u) * total;
        let mut i = self.cumulative[1..=count].partition_point(|c| *c <= x).min(count - 1);
        // Rounding can end on an item of weight zero at the very end.
        while i > 0 && self.cumulative[i + 1] == self.cumulative[i] {
            i -= 1;
        }
        let (lo, hi) = (self.cumulative[i], self.cumulative[i + 1]);
        let again = if hi > lo { ((x - lo) / (hi - lo)) as f32 } else { 0.5 };
        Some((i, again.clamp(0.0, 1.0 - f32::EPSILON / 2.0)))
    }
}

/// A density over the unit square, constant in each cell of a grid.
#[derive(Clone, Debug)]
pub struct Grid {
    width: usize,
    rows: Vec<Discrete>,
    marginal: Discrete,
}

impl Grid {
    /// From `width · height` weights ≥ 0, row by row.
    pub fn new(weights: &[f32], width: usize) -> Self {
        let row = |w: &[f32]| Discrete::new(w.iter().map(|w| f64::from(*w)));
        let rows: Vec<_> = weights.chunks_exact(width).map(row).collect();
        let marginal = Discrete::new(rows.iter().map(Discrete::total));
        Self { width, rows, marginal }
    }

    /// Integral of the weights.
    pub fn total(&self) -> f64 {
        self.marginal.total()
    }

    /// A point and its density with respect to the unit square. `None` when all weights are zero.
    pub fn sample(&self, u: [f32; 2]) -> Option<([f32; 2], f32)> {
        let height = self.rows.len();
        let (y, fy) = self.marginal.sample(u[1], height)?;
        let (x, fx) = self.rows[y].sample(u[0], self.width)?;
        let point = [(x as f32 + fx) / self.width as f32, (y as f32 + fy) / height as f32];
        Some((point, self.density_of(x, y)))
    }

    /// The density at a point.
    pub fn density(&self, point: [f32; 2]) -> f32 {
        let height = self.rows.len();
        let x = ((point[0] * self.width as f32) as usize).min(self.width - 1);
        let y = ((point[1] * height as f32) as usize).min(height - 1);
        self.density_of(x, y)
    }

    fn density_of(&self, x: usize, y: usize) -> f32 {
        let height = self.rows.len();
        self.marginal.probability(y, height) * self.rows[y].probability(x, self.width) * (self.width * height) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_chosen_by_weight_and_never_with_weight_zero() {
        let d = Discrete::new([0.0, 1.0, 0.0, 3.0, 0.0]);
        let mut counts = [0; 5];
        for k in 0..4000 {
            counts[d.sample(k as f32 / 4000.0, 5).unwrap().0] += 1;
        }
        assert_eq!(counts, [0, 1000, 0, 3000, 0]);
        assert_eq!(d.sample(1.0 - f32::EPSILON / 2.0, 5).unwrap().0, 3);
        assert_eq!(d.sample(0.9, 3).unwrap().0, 1);
        assert!(d.sample(0.5, 1).is_none());
        assert_eq!(d.probability(3, 5), 0.75);
    }

    #[test]
    fn grid_density_integrates_to_one_and_matches_its_samples() {
        let weights = [0.0, 1.0, 2.0, 5.0, 0.0, 4.0];
        let grid = Grid::new(&weights, 3);
        let mean: f32 =
            (0..6).map(|k| grid.density([(k % 3) as f32 / 3.0 + 0.1, (k / 3) as f32 / 2.0 + 0.1])).sum::<f32>() / 6.0;
        assert!((mean - 1.0).abs() < 1e-6);
        for k in 0..64 {
            let u = [(k % 8) as f32 / 8.0, (k / 8) as f32 / 8.0];
            let (p, density) = grid.sample(u).unwrap();
            assert_eq!(density, grid.density(p));
            assert!(density > 0.0);
        }
    }
}
