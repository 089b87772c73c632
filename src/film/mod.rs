//! Where samples are gathered.

mod surfaces;

use crate::sampling::REPLICATES;
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
}

impl PixelSums {
    /// Adds sample number `sample` (over all replicates).
    pub fn add(&mut self, sample: u32, rgba: [f32; 4]) {
        let sum = &mut self.sums[(sample % REPLICATES) as usize];
        (0..4).for_each(|c| sum[c] += f64::from(rgba[c]));
    }

    /// Mean over all of `spp` samples.
    pub fn mean(&self, spp: u32) -> [f64; 4] {
        let n = f64::from(spp.max(1));
        std::array::from_fn(|c| self.sums.iter().map(|s| s[c]).sum::<f64>() / n)
    }

    /// Means of the replicates; those without a sample are left out.
    pub fn replicate_means(&self, spp: u32) -> impl Iterator<Item = [f64; 4]> + '_ {
        (0..REPLICATES).filter_map(move |r| {
            let n = replicate_samples(spp, r);
            (n > 0).then(|| self.sums[r as usize].map(|s| s / f64::from(n)))
        })
    }

    /// Variance of [`Self::mean`]'s first three channels with `spp` ≥ 2 samples, from the spread of the replicates. Replicates
    /// with fewer samples weigh less.
    pub fn variance(&self, spp: u32) -> [f64; 3] {
        let mean = self.mean(spp);
        let filled = spp.min(REPLICATES);
        let mut sums = [0.0; 3];
        for r in 0..filled {
            let n = f64::from(replicate_samples(spp, r));
            for c in 0..3 {
                let off = self.sums[r as usize][c] / n - mean[c];
                sums[c] += n * off * off;
            }
        }
        sums.map(|s| s / (f64::from(filled) - 1.0) / f64::from(spp))
    }

    /// Sums of the replicates, all of them.
    pub fn replicate_sums(&self) -> &[[f64; 4]; REPLICATES as usize] {
        &self.sums
    }
}

/// How many of `spp` samples belong to replicate `replicate`.
pub fn replicate_samples(spp: u32, replicate: u32) -> u32 {
    spp / REPLICATES + u32::from(replicate < spp % REPLICATES)
}

/// All pixels' sums, row by row from the top. It grows by passes: [`crate::integrate::render_pass`].
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples per pixel so far.
    pub spp: u32,
    /// Whether every pixel of the picture is opaque, because the environment shows where the asset is not. The sums
    /// know what the asset covers all the same.
    pub opaque: bool,
    /// `width · height` sums.
    pub pixels: Vec<PixelSums>,
}

impl Film {
    /// A film without samples.
    pub fn new(width: u32, height: u32, opaque: bool) -> Self {
        let pixels = vec![PixelSums::default(); width as usize * height as usize];
        Self { width, height, spp: 0, opaque, pixels }
    }

    /// The mean of all samples.
    pub fn picture(&self) -> Picture {
        let alpha = |a: f64| if self.opaque { 1.0 } else { a };
        let pixel = |[r, g, b, a]: [f64; 4]| [r, g, b, alpha(a)].map(|x| x as f32);
        let pixels = self.pixels.iter().map(|p| pixel(p.mean(self.spp))).collect();
        Picture { width: self.width, height: self.height, pixels }
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
        let variance = |p: &PixelSums| p.variance(self.spp).map(|v| v as f32);
        let known = self.spp >= 2;
        Noise {
            variance: known.then(|| self.pixels.iter().map(variance).collect()),
            samples: vec![self.spp; self.pixels.len()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_replicates_agree_when_samples_do_not_divide_evenly() {
        let mut pixel = PixelSums::default();
        (0..6).for_each(|s| pixel.add(s, [s as f32, 1.0, 0.0, 1.0]));
        assert_eq!(pixel.mean(6), [2.5, 1.0, 0.0, 1.0]);
        let means: Vec<f64> = pixel.replicate_means(6).map(|m| m[0]).collect();
        assert_eq!(means, [2.0, 3.0, 2.0, 3.0]);
        assert_eq!(pixel.replicate_means(2).count(), 2);
        assert_eq!([0, 1, 2, 3].map(|r| replicate_samples(6, r)), [2, 2, 1, 1]);
    }

    #[test]
    fn variance_is_that_of_the_mean() {
        let mut pixel = PixelSums::default();
        (0..8).for_each(|s| pixel.add(s, [s as f32, 3.0, -(s as f32), 1.0]));
        // Replicate means 2, 3, 4, 5: their variance is 5/3, that of the mean of four a quarter of it.
        let [a, b, c] = pixel.variance(8);
        assert!((a - 5.0 / 12.0).abs() < 1e-12 && b == 0.0 && (c - a).abs() < 1e-12);
        let film = Film { width: 1, height: 1, spp: 1, opaque: false, pixels: vec![pixel] };
        assert_eq!(film.noise(), Noise { variance: None, samples: vec![1] });
    }

    #[test]
    fn an_opaque_film_still_knows_what_the_asset_covers() {
        let mut film = Film::new(1, 1, true);
        film.pixels[0].add(0, [0.5, 0.5, 0.5, 0.0]);
        film.spp = 1;
        assert_eq!((film.pixels[0].mean(1)[3], film.picture().pixels[0]), (0.0, [0.5, 0.5, 0.5, 1.0]));
    }
}
