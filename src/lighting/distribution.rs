//! Piecewise constant distributions, sampled by inversion (pbrt 4ed, A.4.7), which keeps stratified numbers stratified.

/// A discrete distribution.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    /// `cumulative[i]` is the sum of the first `i` weights.
    cumulative: Vec<f64>,
    /// `guide[k]` is the first item whose share ends beyond k / count of the total, so that a search has few items to
    /// look at (Chen & Asau 1974, "On Generating Random Variates from an Empirical Distribution").
    guide: Vec<u32>,
    /// Entries of the guide per unit of weight.
    guides_per_weight: f64,
}

impl Discrete {
    /// From weights ≥ 0, fewer than 2³².
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut cumulative = vec![0.0];
        let mut sum = 0.0;
        for w in weights {
            sum += w;
            cumulative.push(sum);
        }
        let count = cumulative.len() - 1;
        let mut item = 0;
        let entry = |k: usize| {
            let x = sum * (k as f64 / count as f64);
            while item < count && cumulative[item + 1] <= x {
                item += 1;
            }
            item as u32
        };
        let guides_per_weight = count as f64 / sum;
        // Without a guide where all weights are zero, or their sum is at the end of what numbers can say.
        let guide = if guides_per_weight.is_normal() { (0..count).map(entry).collect() } else { Vec::new() };
        Self { cumulative, guide, guides_per_weight }
    }

    /// The first item of the first `count` whose share ends beyond `x`, or the last.
    fn find(&self, x: f64, count: usize) -> usize {
        // One entry to each side covers the rounding of the place.
        let place = ((x * self.guides_per_weight) as usize).min(self.guide.len());
        let at = |k: usize| self.guide.get(k).map_or(count, |item| (*item as usize).min(count));
        let first = if self.guide.is_empty() { 0 } else { at(place.saturating_sub(1)) };
        let end = at(place + 2);
        let shares = &self.cumulative[1 + first..=end];
        (first + shares.partition_point(|c| *c <= x)).min(count - 1)
    }

    /// Sum of all weights.
    pub fn total(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Whether any of the first `count` items can be chosen.
    pub fn any(&self, count: usize) -> bool {
        self.cumulative[count] > 0.0
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
        let mut i = self.find(x, count);
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

    /// The guided search finds what a search through all items finds, whatever the weights and the prefix.
    #[test]
    fn the_guide_changes_nothing() {
        for n in 1..60u32 {
            for style in 0..5 {
                let weight = |i: u32| match style {
                    0 => 1.0,
                    1 => libm::exp2(-f64::from(i)),
                    2 => f64::from((i * 71 + n).wrapping_mul(2_654_435_761) >> 29),
                    3 => f64::from(u32::from(i % 7 == 3)) * 1e30,
                    _ => f64::from(i) * 1e-322,
                };
                let d = Discrete::new((0..n).map(weight));
                for count in [1, n as usize / 2, n as usize].into_iter().filter(|c| *c > 0) {
                    let total = d.cumulative[count];
                    for k in 0..200 {
                        let x = total * f64::from(k) / 200.0;
                        let all = d.cumulative[1..=count].partition_point(|c| *c <= x).min(count - 1);
                        assert_eq!(d.find(x, count), all, "{n} items, style {style}, first {count}, x {x}");
                    }
                    for i in 0..count {
                        let x = d.cumulative[i];
                        let all = d.cumulative[1..=count].partition_point(|c| *c <= x).min(count - 1);
                        assert_eq!(d.find(x, count), all, "{n} items, style {style}, first {count}, edge {i}");
                    }
                }
            }
        }
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
