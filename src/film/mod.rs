//! Where samples are gathered.

use crate::sampling::REPLICATES;

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
            let n = spp / REPLICATES + u32::from(r < spp % REPLICATES);
            (n > 0).then(|| self.sums[r as usize].map(|s| s / f64::from(n)))
        })
    }
}

/// All pixels' sums, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// `width · height` sums.
    pub pixels: Vec<PixelSums>,
}

impl Film {
    /// The mean of all samples.
    pub fn picture(&self) -> Picture {
        let pixels = self.pixels.iter().map(|p| p.mean(self.spp).map(|x| x as f32)).collect();
        Picture { width: self.width, height: self.height, pixels }
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
    }
}
