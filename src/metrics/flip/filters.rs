//! What the eye makes of a picture: contrast sensitivity, edges and points.

use super::Plane;
use std::f64::consts::PI;

/// b of the widest Gaussian among the contrast sensitivity functions, degrees².
const WIDEST: f64 = 0.04;
/// w: width of the detectors of edges and points, degrees.
const DETECTOR_WIDTH: f64 = 0.082;

/// Kernels of contrast sensitivity: details finer than the eye resolves are blurred, in colour sooner than in luminance.
pub(super) struct Sensitivity {
    luma: Vec<f64>,
    red_green: Vec<f64>,
    /// The blue-yellow one is a sum of two Gaussians, so it takes two passes.
    blue_yellow: [Vec<f64>; 2],
}

impl Sensitivity {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let gaussian = |scale: f64, b: f64| -> Vec<f64> {
            let at = |i: i32| f64::from(i) / pixels_per_degree;
            (-radius..=radius).map(|i| scale * libm::exp(-PI * PI * at(i) * at(i) / b)).collect()
        };
        let normalised = |kernel: Vec<f64>, sum: f64| -> Vec<f64> { kernel.iter().map(|w| w / sum).collect() };
        let single = |b: f64| {
            let kernel = gaussian(1.0, b);
            let sum = kernel.iter().sum();
            normalised(kernel, sum)
        };
        // a √(π/b) e^(−π² x² / b) in two dimensions is the square of its root in one.
        let part = |a: f64, b: f64| gaussian((a * (PI / b).sqrt()).sqrt(), b);
        let parts = [part(34.1, WIDEST), part(13.5, 0.025)];
        let sum = libm::hypot(parts[0].iter().sum(), parts[1].iter().sum());
        Self { luma: single(0.0047), red_green: single(0.0053), blue_yellow: parts.map(|k| normalised(k, sum)) }
    }

    /// The picture (Y, Cx, Cz) as it is seen.
    pub(super) fn seen(&self, [luma, red_green, blue_yellow]: &[Plane; 3]) -> [Plane; 3] {
        let [wide, narrow] = self.blue_yellow.each_ref().map(|kernel| blue_yellow.filter(kernel, kernel));
        [
            luma.filter(&self.luma, &self.luma),
            red_green.filter(&self.red_green, &self.red_green),
            wide.zip(&narrow, |a, b| a + b),
        ]
    }
}

/// Detectors of edges and points: first and second derivatives of a Gaussian.
pub(super) struct Features {
    gaussian: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
}

/// How strong edges and points are.
pub(super) struct Detected {
    pub edges: Plane,
    pub points: Plane,
}

impl Features {
    pub(super) fn new(pixels_per_degree: f64) -> Self {
        let deviation = 0.5 * DETECTOR_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let kernel = |of: &dyn Fn(f64) -> f64| -> Vec<f64> {
            let values: Vec<f64> = (-radius..=radius)
                .map(f64::from)
                .map(|x| of(x) * libm::exp(-0.5 * x * x / (deviation * deviation)))
                .collect();
            // Weights of each sign add up to 1.
            let positive: f64 = values.iter().filter(|v| **v > 0.0).sum();
            let negative: f64 = -values.iter().filter(|v| **v <= 0.0).sum::<f64>();
            values.iter().map(|v| if *v > 0.0 { v / positive } else { v / negative.max(f64::MIN_POSITIVE) }).collect()
        };
        Self {
            gaussian: kernel(&|_| 1.0),
            first: kernel(&|x| -x),
            second: kernel(&|x| x * x / (deviation * deviation) - 1.0),
        }
    }

    pub(super) fn of(&self, luma: &Plane) -> Detected {
        let normalised = Plane { width: luma.width, values: luma.values.iter().map(|y| (y + 16.0) / 116.0).collect() };
        let [smooth, slope, bend] =
            [&self.gaussian, &self.first, &self.second].map(|kernel| normalised.filter_across(kernel));
        let length = |across: Plane, down: Plane| across.zip(&down, libm::hypot);
        Detected {
            edges: length(slope.filter_down(&self.gaussian), smooth.filter_down(&self.first)),
            points: length(bend.filter_down(&self.gaussian), smooth.filter_down(&self.second)),
        }
    }
}
