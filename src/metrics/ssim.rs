//! Structural similarity (Wang, Bovik, Sheikh & Simoncelli 2004).

use super::{Plane, Shown};

/// Standard deviation of the window, pixels.
const SIGMA: f64 = 1.5;
/// The window reaches this far: 11 × 11 pixels.
const RADIUS: usize = 5;
/// (K₁ L)² and (K₂ L)² for L = 255 levels.
const C1: f64 = 0.01 * 255.0 * (0.01 * 255.0);
const C2: f64 = 0.03 * 255.0 * (0.03 * 255.0);

/// Weighted means, variances and covariance of two pictures in a window.
#[derive(Clone, Copy, Debug)]
struct Moments {
    mean: [f64; 2],
    variance: [f64; 2],
    covariance: f64,
}

impl Moments {
    /// Wang's equation 13.
    fn index(&self, c1: f64, c2: f64) -> f64 {
        let [a, b] = self.mean;
        let luminance = (2.0 * a * b + c1) / (a * a + b * b + c1);
        luminance * (2.0 * self.covariance + c2) / (self.variance[0] + self.variance[1] + c2)
    }
}

/// Mean SSIM of the displayed luma (Rec. 601, 0–255) under a Gaussian window of 11 × 11 pixels, where all of the window
/// lies in the picture; in pictures smaller than that, everywhere. 1 for equal pictures, lower otherwise.
pub fn ssim(a: &Shown, b: &Shown) -> f64 {
    of_planes(&luma(a), &luma(b))
}

fn luma(shown: &Shown) -> Plane {
    let weigh = |&[r, g, b]: &[f32; 3]| 255.0 * (0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b));
    Plane { width: shown.width as usize, values: shown.displayed.iter().map(weigh).collect() }
}

fn of_planes(a: &Plane, b: &Plane) -> f64 {
    let at = |i: usize| i as f64 - RADIUS as f64;
    let kernel: Vec<f64> = (0..=2 * RADIUS).map(|i| libm::exp(-0.5 * at(i) * at(i) / (SIGMA * SIGMA))).collect();
    let sum: f64 = kernel.iter().sum();
    let kernel: Vec<f64> = kernel.iter().map(|w| w / sum).collect();
    let blur = |plane: &Plane| plane.filter(&kernel, &kernel);
    let product = |x: &Plane, y: &Plane| blur(&x.zip(y, |x, y| x * y));
    let (mean_a, mean_b) = (blur(a), blur(b));
    let (aa, bb, ab) = (product(a, a), product(b, b), product(a, b));
    let (width, height) = (a.width, a.height());
    let inner = |size: usize| if size > 2 * RADIUS { RADIUS..size - RADIUS } else { 0..size };
    let (mut total, mut count) = (0.0, 0u64);
    for y in inner(height) {
        for i in inner(width).map(|x| y * width + x) {
            let mean = [mean_a.values[i], mean_b.values[i]];
            // Rounding may leave a variance a little below 0.
            let variance = [aa.values[i] - mean[0] * mean[0], bb.values[i] - mean[1] * mean[1]].map(|v| v.max(0.0));
            let moments = Moments { mean, variance, covariance: ab.values[i] - mean[0] * mean[1] };
            total += moments.index(C1, C2);
            count += 1;
        }
    }
    total / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use image_compare::Algorithm;

    /// Two grey pictures by formula: waves, the second brighter, flatter and with a pattern of its own.
    fn waves(width: usize, height: usize) -> [Plane; 2] {
        let plane = |of: &dyn Fn(usize, usize) -> usize| Plane {
            width,
            values: (0..width * height).map(|i| of(i % width, i / width) as f64).collect(),
        };
        let first = plane(&|x, y| (x * x + 3 * y * y + 5 * x * y) % 251);
        let second = plane(&|x, y| ((x * x + 3 * y * y + 5 * x * y) % 251) * 3 / 4 + (7 * x + 13 * y) % 32);
        [first, second]
    }

    #[test]
    fn agrees_with_scikit_image() {
        // structural_similarity(a, b, data_range=255, gaussian_weights=True, sigma=1.5, use_sample_covariance=False),
        // scikit-image 0.26.
        for (width, height, expected) in [(64, 48, 0.939753406420136), (11, 29, 0.946391340918795)] {
            let [a, b] = waves(width, height);
            assert!((of_planes(&a, &b) - expected).abs() < 1e-9, "{} for {expected}", of_planes(&a, &b));
            assert!((of_planes(&b, &a) - expected).abs() < 1e-9);
            assert!((of_planes(&a, &a) - 1.0).abs() < 1e-12);
        }
    }

    /// image-compare takes plain windows of 8 × 8 pixels, and sums of squares where the definition has variances
    /// (version 0.5), which is the definition with a C2 that is 64 times smaller.
    #[test]
    fn the_index_agrees_with_image_compare() {
        let [a, b] = waves(64, 48);
        let (mut total, mut count) = (0.0, 0.0);
        for (left, top) in (0..48).step_by(8).flat_map(|top| (0..64).step_by(8).map(move |left| (left, top))) {
            let at = |i: usize| (top + i / 8) * 64 + left + i % 8;
            let mean_of = |of: &dyn Fn(usize) -> f64| (0..64).map(|i| of(at(i))).sum::<f64>() / 64.0;
            let mean = [mean_of(&|i| a.values[i]), mean_of(&|i| b.values[i])];
            let centred = |i: usize| [a.values[i] - mean[0], b.values[i] - mean[1]];
            let moments = Moments {
                mean,
                variance: std::array::from_fn(|k| mean_of(&|i| centred(i)[k] * centred(i)[k])),
                covariance: mean_of(&|i| centred(i)[0] * centred(i)[1]),
            };
            total += moments.index(C1, C2 / 64.0);
            count += 1.0;
        }
        let [first, second] = [a, b].map(|plane| {
            let bytes = plane.values.iter().map(|v| *v as u8).collect();
            image_compare::prelude::GrayImage::from_raw(64, 48, bytes).expect("the right size")
        });
        let other = image_compare::gray_similarity_structure(&Algorithm::MSSIMSimple, &first, &second);
        let expected = other.expect("one size").score;
        assert!((total / count - expected).abs() < 1e-12, "{} for {expected}", total / count);
    }

    #[test]
    fn tiny_and_flat_pictures_have_a_value() {
        let flat = |v: f64| Plane { width: 3, values: vec![v; 6] };
        assert!((of_planes(&flat(7.0), &flat(7.0)) - 1.0).abs() < 1e-12);
        // Without variance only the luminance term is left.
        let expected = (2.0 * 50.0 * 200.0 + C1) / (50.0 * 50.0 + 200.0 * 200.0 + C1);
        assert!((of_planes(&flat(50.0), &flat(200.0)) - expected).abs() < 1e-9);
    }
}
