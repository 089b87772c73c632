use crate::math::statistics::f_quantile;
use crate::sampling::REPLICATES;

/// Squared errors of pixels, as their replicates estimate them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Pixels.
    pub count: f64,
    /// Σ of the best estimates of the pixels' expected squared errors.
    pub sum: f64,
    /// Σ v over the pixels' own estimates v of the same.
    pub own: f64,
    /// Σ v²; where some pixels have to do with each other, of what they say together.
    pub own_squares: f64,
}

impl Spread {
    /// Adds a pixel with the best estimate of its expected squared error, and that by its own replicates alone.
    pub fn add(&mut self, estimate: f64, own: f64) {
        self.count += 1.0;
        self.sum += estimate;
        self.own += own;
        self.own_squares += own * own;
    }

    /// The mean squared error, and what the picture's true one lies under with probability `confidence`.
    ///
    /// The true squared error of this very picture is Σ σ² χ²₁ over its pixels, and the estimate Σ σ² χ²₍g−1₎ / (g − 1) for g
    /// replicates. Both are taken as one χ² of the same mean and variance (Satterthwaite 1946): with the effective number
    /// of pixels ν = (Σ σ²)² / Σ σ⁴ their quotient has Fisher's F distribution with ν and (g − 1) ν degrees of freedom.
    /// Where a few pixels carry the error (fireflies), ν is small and the bound far away. v² is (g + 1) / (g − 1) σ⁴ on
    /// average.
    pub fn mean_and_bound(&self, confidence: f64) -> (f64, f64) {
        if !(self.sum > 0.0 && self.own > 0.0) {
            return (0.0, 0.0);
        }
        let mean = self.sum / self.count;
        let g = f64::from(REPLICATES);
        let nu = self.own * self.own / (self.own_squares * (g - 1.0) / (g + 1.0));
        (mean, mean * f_quantile(confidence, nu, (g - 1.0) * nu))
    }
}

impl std::ops::AddAssign for Spread {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.sum += other.sum;
        self.own += other.own;
        self.own_squares += other.own_squares;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(estimates: &[f64]) -> f64 {
        let mut spread = Spread::default();
        estimates.iter().for_each(|v| spread.add(*v, *v));
        let (mean, bound) = spread.mean_and_bound(0.95);
        (bound / mean).sqrt()
    }

    #[test]
    fn the_bound_is_near_where_many_pixels_agree_and_far_where_one_has_it_all() {
        let even = ratio(&[2.0; 10_000]);
        assert!(even > 1.005 && even < 1.02, "{even}");
        let mut firefly = vec![1e-6; 10_000];
        firefly[17] = 5.0;
        let alone = ratio(&firefly);
        assert!(alone > 2.0, "{alone}");
        assert_eq!(Spread::default().mean_and_bound(0.95), (0.0, 0.0));
    }
}
