//! Which pixels use each other's paths.

use super::{Film, PixelSums, SQUARE};
use std::collections::BTreeMap;

/// Pixels of a group are so far apart, to each side: further than any window looks that compares a pixel with those around it
/// (three pixels), to which they are as independent as ever. So groups show as fine grain, and not as blocks.
const APART: u32 = 4;

/// Groups of pixels in a square of [`SQUARE`] × [`SQUARE`], and pixels in a group.
pub const GROUPS: u32 = APART * APART;

/// The group of a pixel within its square, below [`GROUPS`].
pub fn group_in_square([x, y]: [u32; 2]) -> u32 {
    y % APART * APART + x % APART
}

impl Film {
    /// The group of a pixel in the film.
    pub(crate) fn group_of(&self, pixel: usize) -> usize {
        let (x, y) = (pixel as u32 % self.width, pixel as u32 / self.width);
        let square = y / SQUARE * self.width.div_ceil(SQUARE) + x / SQUARE;
        (square * GROUPS + group_in_square([x, y])) as usize
    }

    /// The sums of pixels, whose errors have nothing to do with each other: where pixels use each other's paths, those of a group are one.
    pub(super) fn independent(&self, pixels: impl Iterator<Item = usize>) -> Vec<PixelSums> {
        if !self.shares {
            return pixels.map(|p| self.pixels[p]).collect();
        }
        let mut groups: BTreeMap<usize, PixelSums> = BTreeMap::new();
        for pixel in pixels {
            let group = groups.entry(self.group_of(pixel)).or_default();
            group.join(&self.pixels[pixel]);
        }
        groups.into_values().collect()
    }
}

impl PixelSums {
    /// Adds the sums of another pixel, with as many samples: the mean becomes the sum of the means.
    fn join(&mut self, other: &Self) {
        debug_assert!(self.samples == 0 || self.samples == other.samples);
        self.samples = other.samples;
        for (own, more) in self.sums.iter_mut().zip(&other.sums) {
            (0..4).for_each(|c| own[c] += more[c]);
        }
        self.brightest += other.brightest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Estimate;

    #[test]
    fn groups_are_sixteen_pixels_of_a_square() {
        let film = Film::new(40, 35, false);
        let mut sizes: BTreeMap<usize, usize> = BTreeMap::new();
        for pixel in 0..film.pixels.len() {
            *sizes.entry(film.group_of(pixel)).or_default() += 1;
        }
        let whole = sizes.values().filter(|n| **n == 16).count();
        assert_eq!((whole, sizes.values().sum::<usize>()), (4 * 16, 40 * 35));
        assert_eq!(film.group_of(0), film.group_of(4 * 40 + 8));
        assert!(
            (1..4).all(|off| film.group_of(0) != film.group_of(off) && film.group_of(0) != film.group_of(40 * off))
        );
    }

    #[test]
    fn what_a_group_has_in_common_is_not_averaged_away() {
        // All pixels of a group have the same two samples, ±1 about 5: nothing else is known of the group than of one pixel.
        let mut film = Film { spp: 2, shares: true, ..Film::new(16, 16, false) };
        for pixel in &mut film.pixels {
            pixel.add(0, [4.0, 0.0, 0.0, 1.0]);
            pixel.add(1, [6.0, 0.0, 0.0, 1.0]);
        }
        let common = film.estimate(0..256, [1.0, 0.0, 0.0]);
        assert_eq!(common, Estimate { mean: 5.0, variance: 1.0 / 16.0, degrees: 16.0 });
        let alone = Film { shares: false, ..film }.estimate(0..256, [1.0, 0.0, 0.0]);
        assert_eq!(alone, Estimate { mean: 5.0, variance: 1.0 / 256.0, degrees: 256.0 });
    }
}
