//! What samples say of the noise of their pixels, and of those around.

use super::jackknife::LeaveOneOut;
use super::{Display, displayed, relmse};
use crate::cpu_clock::Helpers;
use crate::film::{Film, PixelSums};
use crate::lanes::{AnyLanes, LANES, Lanes, Work};
use crate::math::simd::SimdTier;
use rayon::prelude::*;
use std::ops::Range;

/// Pixels to each side whose noise says how many samples a pixel gets.
const RADIUS: usize = 3;
/// The share of the whole picture's σ² that every pixel is reckoned to have beside its own: what is known of its own is little, and a
/// light that few paths meet may not have shown yet. Measured: scripts/runs/2026-11-22-adaptive-sampling.md.
const COMMON: f64 = 0.25;

/// What a pixel's samples say.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Said {
    /// 1 where the asset covers the pixel.
    pub covered: f64,
    /// Deviations of a single sample: as displayed, and for relMSE.
    pub deviations: [f64; 2],
}

impl Said {
    /// Both deviations in one, each measured by that of all pixels.
    pub fn relative_to(&self, whole: &Self) -> f64 {
        let share = |k: usize| self.deviations[k] / self.covered / (whole.deviations[k] / whole.covered);
        let known = |k: usize| self.covered > 0.0 && whole.deviations[k] > 0.0;
        let square = |k: usize| if known(k) { share(k) * share(k) } else { 0.0 };
        (square(0) + square(1) + 2.0 * COMMON).sqrt()
    }
}

impl std::ops::AddAssign for Said {
    fn add_assign(&mut self, other: Self) {
        self.covered += other.covered;
        (0..2).for_each(|k| self.deviations[k] += other.deviations[k]);
    }
}

/// Pixels that a thread works on at a time.
const PIECE: usize = 4096;

/// What `some` makes of all pixels, piece by piece, on the current rayon pool.
pub(super) fn in_pieces<T: Send>(
    pixels: usize,
    helpers: &Helpers,
    some: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let piece = |k: usize| helpers.help(|| some(k * PIECE..((k + 1) * PIECE).min(pixels)));
    let pieces: Vec<Vec<T>> = (0..pixels.div_ceil(PIECE)).into_par_iter().with_max_len(1).map(piece).collect();
    pieces.into_iter().flatten().collect()
}

/// What the samples of each pixel say.
pub(super) fn said(film: &Film, display: &Display, helpers: &Helpers) -> Vec<Said> {
    let lanes = AnyLanes::new(SimdTier::detect());
    in_pieces(film.pixels.len(), helpers, |piece| lanes.run(Say { pixels: &film.pixels[piece], film, display }))
}

struct Say<'a> {
    pixels: &'a [PixelSums],
    film: &'a Film,
    display: &'a Display,
}

impl Work for Say<'_> {
    type Output = Vec<Said>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Vec<Said> {
        let mut all = Vec::with_capacity(self.pixels.len());
        for sixteen in self.pixels.chunks(LANES) {
            let parts = LeaveOneOut::of(sixteen);
            let squares = [
                displayed::square_difference(lanes, &parts, self.display, self.film.opaque),
                relmse::square_difference(&parts),
            ];
            for (i, pixel) in sixteen.iter().enumerate() {
                let mut said = Said { covered: parts.covered[i], deviations: [0.0; 2] };
                for (deviation, square) in said.deviations.iter_mut().zip(&squares) {
                    let of_one = (square[i] * f64::from(pixel.samples())).sqrt();
                    *deviation = if parts.covered[i] > 0.0 && of_one.is_finite() { of_one } else { 0.0 };
                }
                all.push(said);
            }
        }
        all
    }
}

/// What all pixels say, and sums of it over rows of seven.
pub(super) struct Around<'a> {
    said: &'a [Said],
    across: Vec<Said>,
    width: usize,
    height: usize,
}

impl<'a> Around<'a> {
    pub fn of(said: &'a [Said], width: usize, helpers: &Helpers) -> Self {
        let width = width.max(1);
        let sum = |pixel: usize| {
            let (x, row) = (pixel % width, pixel / width * width);
            sum(&said[row..row + width][near(x, width)])
        };
        let across = in_pieces(said.len(), helpers, |piece| piece.map(sum).collect());
        Self { said, across, width, height: said.len() / width }
    }

    /// The sum over the pixels around a pixel without itself.
    pub fn without(&self, pixel: usize) -> Said {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let row = &self.said[y * self.width..(y + 1) * self.width];
        let near_x = near(x, self.width);
        let mut total = sum(&row[near_x.start..x]);
        total += sum(&row[x + 1..near_x.end]);
        near(y, self.height).filter(|other| *other != y).for_each(|other| total += self.across[other * self.width + x]);
        total
    }
}

/// The places up to [`RADIUS`] beside one of `size`.
fn near(at: usize, size: usize) -> Range<usize> {
    at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(size)
}

fn sum(all: &[Said]) -> Said {
    let mut total = Said::default();
    all.iter().for_each(|s| total += *s);
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu_clock::CpuClock;

    #[test]
    fn what_a_pixel_says_counts_for_its_neighbours_and_not_for_itself() {
        let quiet = vec![Said { covered: 1.0, deviations: [1.0, 0.5] }; 20 * 20];
        let mut spiked = quiet.clone();
        let place = 7 * 20 + 9;
        spiked[place].deviations = [1e6, 1e9];
        let around = |said: &[Said]| -> Vec<Said> {
            let around = Around::of(said, 20, &CpuClock::begin().helpers);
            (0..20 * 20).map(|pixel| around.without(pixel)).collect()
        };
        let (before, after) = (around(&quiet), around(&spiked));
        assert_eq!((after[place].covered, after[place].deviations), (48.0, before[place].deviations));
        for (k, (a, b)) in after.iter().zip(&before).enumerate().filter(|(k, _)| *k != place) {
            let near = (k % 20).abs_diff(9) <= RADIUS && (k / 20).abs_diff(7) <= RADIUS;
            assert_eq!(near, a.deviations != b.deviations, "{k}");
        }
    }
}
