//! Where samples are gathered.

mod groups;
mod surfaces;

use crate::sampling::REPLICATES;
pub use groups::{GROUPS, group_in_square};
use serde::{Deserialize, Serialize};
pub use surfaces::{Identity, RANKS, Surfaces};

/// A finished picture: linear, premultiplied RGBA, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels: linear Rec. 709 radiance, premultiplied by the coverage in the fourth channel.
    pub pixels: Vec<[f32; 4]>,
}

/// Sums of a pixel's samples, one per replicate, in double precision and in the order of the samples.
///
/// The fourth channel counts the samples that met the asset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelSums {
    sums: [[f64; 4]; REPLICATES as usize],
    samples: u32,
    /// Red, green and blue of the brightest sample, all three.
    brightest: f32,
}

impl PixelSums {
    /// Adds sample number `sample` (over all replicates), the one after the last one.
    pub fn add(&mut self, sample: u32, rgba: [f32; 4]) {
        self.samples = sample + 1;
        let sum = &mut self.sums[(sample % REPLICATES) as usize];
        (0..4).for_each(|c| sum[c] += f64::from(rgba[c]));
        self.brightest = self.brightest.max(rgba[0] + rgba[1] + rgba[2]);
    }

    /// How much of the mean the brightest sample makes, beyond what a sample makes on average: sum of red, green and blue.
    pub fn spike(&self) -> f64 {
        let [r, g, b, _] = self.mean();
        (f64::from(self.brightest) - (r + g + b)).max(0.0) / f64::from(self.samples.max(1))
    }

    /// Counts sample number `sample` as one that brought nothing.
    pub fn drop_sample(&mut self, sample: u32) {
        self.samples = sample + 1;
    }

    /// Samples so far, over all replicates.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Mean over all samples.
    pub fn mean(&self) -> [f64; 4] {
        let n = f64::from(self.samples.max(1));
        std::array::from_fn(|c| self.sums.iter().map(|s| s[c]).sum::<f64>() / n)
    }

    /// Means of the replicates; those without a sample are left out.
    pub fn replicate_means(&self) -> impl Iterator<Item = [f64; 4]> + '_ {
        (0..REPLICATES).filter_map(move |r| {
            let n = replicate_samples(self.samples, r);
            (n > 0).then(|| self.sums[r as usize].map(|s| s / f64::from(n)))
        })
    }

    /// Variance of [`Self::mean`]'s first three channels with two samples or more, from the spread of the replicates. Replicates
    /// with fewer samples weigh less.
    pub fn variance(&self) -> [f64; 3] {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|channel| self.variance_of(channel))
    }

    /// The same of a weighted sum of the first three channels.
    fn variance_of(&self, weights: [f64; 3]) -> f64 {
        let spp = self.samples;
        let of = |values: &[f64; 4]| weighted(weights, values);
        let (mean, filled) = (of(&self.mean()), spp.min(REPLICATES));
        let square = |r: u32| {
            let n = f64::from(replicate_samples(spp, r));
            let off = of(&self.sums[r as usize]) / n - mean;
            n * off * off
        };
        (0..filled).map(square).sum::<f64>() / (f64::from(filled) - 1.0) / f64::from(spp)
    }

    /// Sums of the replicates, all of them.
    pub fn replicate_sums(&self) -> &[[f64; 4]; REPLICATES as usize] {
        &self.sums
    }
}

fn weighted(weights: [f64; 3], values: &[f64; 4]) -> f64 {
    (0..3).map(|c| weights[c] * values[c]).sum()
}

/// How many of `spp` samples belong to replicate `replicate`.
pub fn replicate_samples(spp: u32, replicate: u32) -> u32 {
    spp / REPLICATES + u32::from(replicate < spp % REPLICATES)
}

/// A mean over pixels, and how far it can be off by what the replicates say.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its variance; not finite where one sample says nothing of it (`null` in JSON).
    #[serde(deserialize_with = "number_or_null")]
    pub variance: f64,
    /// Degrees of freedom of that.
    pub degrees: f64,
}

/// JSON knows no numbers that are not finite.
fn number_or_null<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

impl Estimate {
    /// The mean of independent estimates; `None` of none.
    pub fn mean_of(all: &[Self]) -> Option<Self> {
        let n = all.len() as f64;
        let sum = |of: fn(&Self) -> f64| all.iter().map(of).sum::<f64>();
        let variance = sum(|e| e.variance);
        let degrees = variance * variance / sum(|e| e.variance * e.variance / e.degrees);
        let degrees = if degrees.is_finite() { degrees } else { sum(|e| e.degrees) };
        (!all.is_empty()).then(|| Self { mean: sum(|e| e.mean) / n, variance: variance / n / n, degrees })
    }
}

/// All pixels' sums, row by row from the top. It grows by passes: [`crate::integrate::render_pass`].
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples per pixel so far: of every pixel, or about as many on average where noise decides ([`crate::accuracy::Allotment`]).
    pub spp: u32,
    /// Whether every pixel of the picture is opaque, because the environment shows where the asset is not. The sums
    /// know what the asset covers all the same.
    pub opaque: bool,
    /// Whether pixels of a group use each other's paths ([`group_in_square`]): then their errors have to do with each other.
    pub shares: bool,
    /// `width · height` sums.
    pub pixels: Vec<PixelSums>,
    /// What the rays cost that were traced for each square of [`SQUARE`] × [`SQUARE`] pixels, in camera rays; row by row from the top.
    pub work: Vec<u64>,
}

/// Side of the squares that [`Film::work`] counts by, pixels.
pub const SQUARE: u32 = 16;

impl Film {
    /// A film without samples.
    pub fn new(width: u32, height: u32, opaque: bool) -> Self {
        let pixels = vec![PixelSums::default(); width as usize * height as usize];
        let work = vec![0; (width.div_ceil(SQUARE) * height.div_ceil(SQUARE)) as usize];
        Self { width, height, spp: 0, opaque, shares: false, pixels, work }
    }

    /// Samples of all pixels together.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.samples())).sum()
    }

    /// What a sample of a pixel costs that meets the asset so often, in camera rays, about: its own one, and what follows in the pixel's
    /// square on average where it meets it.
    pub fn cost_of_sample(&self) -> impl Fn(usize, f64) -> f64 + '_ {
        let across = self.width.div_ceil(SQUARE);
        let square = move |pixel: usize| {
            let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
            (y / SQUARE * across + x / SQUARE) as usize
        };
        let mut paths = vec![(0.0, 0.0); self.work.len()];
        for (k, pixel) in self.pixels.iter().enumerate() {
            let (all, met) = &mut paths[square(k)];
            *all += f64::from(pixel.samples());
            *met += pixel.mean()[3] * f64::from(pixel.samples());
        }
        move |pixel, coverage| {
            let ((all, met), work) = (paths[square(pixel)], self.work[square(pixel)] as f64);
            if met > 0.0 { 1.0 + coverage * (work - all).max(0.0) / met } else { 1.0 }
        }
    }

    /// The mean of all samples.
    pub fn picture(&self) -> Picture {
        let alpha = |a: f64| if self.opaque { 1.0 } else { a };
        let pixel = |[r, g, b, a]: [f64; 4]| [r, g, b, alpha(a)].map(|x| x as f32);
        let pixels = self.pixels.iter().map(|p| pixel(p.mean())).collect();
        Picture { width: self.width, height: self.height, pixels }
    }
}

impl Film {
    /// The mean of a weighted sum of the first three channels over pixels, which are independent of each other, but for those that use
    /// each other's paths: they count as one. Its variance is only known with two samples per pixel or more.
    pub fn estimate(&self, pixels: impl Iterator<Item = usize>, weights: [f64; 3]) -> Estimate {
        let (mut sum, mut variance, mut squares) = (0.0, 0.0, 0.0);
        let mut count = 0.0;
        let all = self.independent(pixels.inspect(|_| count += 1.0));
        for sums in &all {
            let own = sums.variance_of(weights);
            sum += weighted(weights, &sums.mean());
            variance += own;
            squares += own * own;
        }
        let free = f64::from(self.spp.min(REPLICATES)) - 1.0;
        // Satterthwaite 1946.
        let degrees = variance * variance / squares * free;
        let degrees = if degrees.is_finite() { degrees } else { all.len() as f64 * free };
        Estimate { mean: sum / count, variance: variance / count / count, degrees }
    }
}

/// What the samples of each pixel say about its noise, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Variance of the pixel's linear, premultiplied red, green and blue, estimated from its replicates; `None` where there
    /// are not two replicates.
    pub variance: Option<Vec<[f32; 3]>>,
    /// Samples in each pixel.
    pub samples: Vec<u32>,
}

impl Film {
    /// The noise of [`Self::picture`].
    pub fn noise(&self) -> Noise {
        let variance = |p: &PixelSums| p.variance().map(|v| v as f32);
        let known = self.spp >= 2;
        Noise {
            variance: known.then(|| self.pixels.iter().map(variance).collect()),
            samples: self.pixels.iter().map(PixelSums::samples).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_replicates_agree_when_samples_do_not_divide_evenly() {
        let mut pixel = PixelSums::default();
        (0..5).for_each(|s| pixel.add(s, [s as f32, 1.0, 0.0, 1.0]));
        assert_eq!(pixel.mean(), [2.0, 1.0, 0.0, 1.0]);
        let means: Vec<f64> = pixel.replicate_means().map(|m| m[0]).collect();
        assert_eq!(means, [2.0, 2.0]);
        let mut first = PixelSums::default();
        first.add(0, [1.0; 4]);
        assert_eq!((first.replicate_means().count(), first.samples()), (1, 1));
        assert_eq!([0, 1].map(|r| replicate_samples(5, r)), [3, 2]);
    }

    #[test]
    fn variance_is_that_of_the_mean() {
        let mut pixel = PixelSums::default();
        (0..8).for_each(|s| pixel.add(s, [s as f32, 3.0, -(s as f32), 1.0]));
        // Replicate means 3 and 4: their variance is 1/2, that of the mean of both half of it.
        let [a, b, c] = pixel.variance();
        assert!((a - 0.25).abs() < 1e-12 && b == 0.0 && (c - a).abs() < 1e-12);
        let film = Film { spp: 1, pixels: vec![pixel], ..Film::new(1, 1, false) };
        assert_eq!(film.noise(), Noise { variance: None, samples: vec![8] });
    }

    #[test]
    fn estimates_pool_what_pixels_say() {
        // Replicate means 0 and 2 d in pixel d: variances d².
        let pixel = |d: f32| {
            let mut sums = PixelSums::default();
            sums.add(1, [2.0 * d, 0.0, 2.0 * d, 1.0]);
            sums
        };
        let film = |d: [f32; 4]| Film { spp: 2, pixels: d.map(pixel).to_vec(), ..Film::new(4, 1, false) };
        let even = film([3.0; 4]).estimate(0..4, [1.0, 0.0, 0.0]);
        assert_eq!(even, Estimate { mean: 3.0, variance: 9.0 / 4.0, degrees: 4.0 });
        let both = film([3.0; 4]).estimate(0..2, [0.5, 0.0, 0.5]);
        assert_eq!(both, Estimate { mean: 3.0, variance: 9.0 / 2.0, degrees: 2.0 });
        let one = film([0.0, 0.0, 0.0, 2.0]).estimate(0..4, [1.0; 3]);
        assert_eq!((one.mean, one.degrees), (1.0, 1.0));
        assert_eq!(film([0.0; 4]).estimate(1..4, [1.0; 3]), Estimate { mean: 0.0, variance: 0.0, degrees: 3.0 });
        let mean = Estimate::mean_of(&[even, even]).expect("two");
        assert_eq!(mean, Estimate { mean: 3.0, variance: 9.0 / 8.0, degrees: 8.0 });
        assert_eq!(Estimate::mean_of(&[]), None);
    }

    #[test]
    fn an_opaque_film_still_knows_what_the_asset_covers() {
        let mut film = Film::new(1, 1, true);
        film.pixels[0].add(0, [0.5, 0.5, 0.5, 0.0]);
        film.spp = 1;
        assert_eq!((film.pixels[0].mean()[3], film.picture().pixels[0]), (0.0, [0.5, 0.5, 0.5, 1.0]));
    }
}
