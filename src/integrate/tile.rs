use super::{Cause, Dropped, DroppedSample, RayCounts};
use crate::film::{Film, PixelSums, SQUARE};
use glam::Vec3;
use std::ops::Range;

/// Side of the square tiles that threads take in turn.
pub(super) const SIDE: u32 = SQUARE;

/// What a ray after a scattering costs, in camera rays or shadow rays: those go together where it goes alone. Measured on the bench scenes
/// (scripts/runs/2026-11-23-adaptive-from-eight.md).
const SCATTERED: u64 = 3;

/// How many samples the pixels of a film are to have.
#[derive(Clone, Copy, Debug)]
pub enum Aim<'a> {
    /// All of them so many.
    All(u32),
    /// Each as many as stands here, row by row from the top; those that have more keep them.
    Each(&'a [u32]),
}

impl Aim<'_> {
    fn at(&self, pixel: usize) -> u32 {
        match self {
            Self::All(samples) => *samples,
            Self::Each(samples) => samples[pixel],
        }
    }
}

/// What a pass cost and came across.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassTally {
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples dropped because they were not finite.
    pub nonfinite: u64,
    /// Why, and where to look.
    pub dropped: Dropped,
    /// Radiance that clamping took off, summed over samples and channels.
    pub clamped: f64,
    /// CPU seconds over all threads.
    pub cpu_seconds: f64,
}

impl std::ops::AddAssign for PassTally {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nonfinite += other.nonfinite;
        self.dropped += other.dropped;
        self.clamped += other.clamped;
        self.cpu_seconds += other.cpu_seconds;
    }
}

/// A square of pixels that a thread works on: a copy of the film's sums there, which goes back when the whole pass is
/// done, so that a pass that is stopped leaves the film as it was.
pub(super) struct Tile {
    /// The left upper corner in the picture.
    pub x: u32,
    pub y: u32,
    /// Smaller than [`SIDE`] at the right and the lower edge of the picture.
    pub width: u32,
    pub height: u32,
    pixels: Vec<PixelSums>,
    /// Samples that each of them is to have.
    aims: Vec<u32>,
    /// What it cost.
    pub tally: PassTally,
    /// Pixel and sample of what was not finite.
    nonfinite: Vec<(usize, u32)>,
    clamp: f32,
}

impl Tile {
    /// The left upper corners of the tiles of a film.
    pub fn corners(film: &Film) -> Vec<(u32, u32)> {
        let across = |size: u32| 0..size.div_ceil(SIDE);
        across(film.height).flat_map(|y| across(film.width).map(move |x| (x * SIDE, y * SIDE))).collect()
    }

    /// The tile at a corner, to be filled up to `aim`. Channels of samples above `clamp` are cut off there.
    pub fn of(film: &Film, (x, y): (u32, u32), clamp: Option<f32>, aim: Aim) -> Self {
        let (width, height) = (SIDE.min(film.width - x), SIDE.min(film.height - y));
        let mut pixels = Vec::with_capacity((width * height) as usize);
        let mut aims = Vec::with_capacity(pixels.capacity());
        for row in y..y + height {
            let start = row as usize * film.width as usize + x as usize;
            pixels.extend_from_slice(&film.pixels[start..start + width as usize]);
            aims.extend((start..start + width as usize).map(|pixel| aim.at(pixel)));
        }
        let clamp = clamp.unwrap_or(f32::INFINITY);
        Self { x, y, width, height, pixels, aims, tally: PassTally::default(), nonfinite: Vec::new(), clamp }
    }

    /// The samples that a pixel of the tile (row by row) lacks.
    pub fn wanted(&self, pixel: usize) -> Range<u32> {
        self.pixels[pixel].samples()..self.aims[pixel]
    }

    /// Counts the samples that a pixel of the tile lacks as camera rays that meet nothing, before nothing.
    pub fn pass_over(&mut self, pixel: usize) {
        let wanted = self.wanted(pixel);
        self.tally.rays.camera += wanted.len() as u64;
        if let Some(last) = wanted.last() {
            self.pixels[pixel].drop_sample(last);
        }
    }

    /// Adds a sample to the tile's pixel number `pixel` (row by row). Those of a pixel come in ascending order; the order
    /// between pixels is free. A sample that is not finite is counted and dropped.
    pub fn add(&mut self, pixel: usize, sample: u32, radiance: Vec3, covered: bool) {
        if !radiance.is_finite() {
            self.nonfinite.push((pixel, sample));
            self.pixels[pixel].drop_sample(sample);
            return;
        }
        let kept = if radiance.max_element() > self.clamp { self.cut(radiance) } else { radiance };
        self.pixels[pixel].add(sample, kept.extend(f32::from(u8::from(covered))).to_array());
    }

    /// Has the dropped samples of this pass explained: `cause_of` follows the path of a sample again.
    pub fn explain(&mut self, cause_of: impl Fn([u32; 2], u32) -> Option<Cause>) {
        for (pixel, sample) in std::mem::take(&mut self.nonfinite) {
            let pixel = [self.x + pixel as u32 % self.width, self.y + pixel as u32 / self.width];
            // A path that comes out finite when it is followed alone was brought too much by others (`--reuse`); without them it would be a
            // defect of the batched tracer.
            let cause = cause_of(pixel, sample).unwrap_or(Cause::Overflow);
            self.tally.nonfinite += 1;
            self.tally.dropped.add(DroppedSample { pixel, sample, cause });
        }
    }

    #[cold]
    fn cut(&mut self, radiance: Vec3) -> Vec3 {
        let kept = radiance.min(Vec3::splat(self.clamp));
        self.tally.clamped += f64::from((radiance - kept).element_sum());
        kept
    }

    /// Puts the sums back and gives the tally.
    pub fn store(self, film: &mut Film) -> PassTally {
        for (row, pixels) in self.pixels.chunks(self.width as usize).enumerate() {
            let start = (self.y as usize + row) * film.width as usize + self.x as usize;
            film.pixels[start..start + pixels.len()].copy_from_slice(pixels);
        }
        let square = self.y / SIDE * film.width.div_ceil(SIDE) + self.x / SIDE;
        let RayCounts { camera, bounce, shadow } = self.tally.rays;
        film.work[square as usize] += camera + SCATTERED * bounce + shadow;
        self.tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once_and_keep_what_is_there() {
        let mut film = Film::new(37, 18, false);
        for pass in 0..2 {
            for corner in Tile::corners(&film) {
                let mut tile = Tile::of(&film, corner, None, Aim::All(pass + 1));
                (0..tile.width * tile.height).for_each(|k| tile.add(k as usize, pass, Vec3::ONE, true));
                tile.store(&mut film);
            }
            film.spp += 1;
        }
        assert!(film.pixels.iter().all(|p| p.mean() == [1.0; 4]));
    }

    #[test]
    fn what_clamping_takes_is_told() {
        let film = Film::new(1, 1, false);
        let mut tile = Tile::of(&film, (0, 0), Some(2.0), Aim::All(2));
        tile.add(0, 0, Vec3::new(5.0, 2.0, 1.0), true);
        tile.add(0, 1, Vec3::new(f32::NAN, 2.0, 1.0), true);
        assert_eq!(tile.pixels[0].mean(), [1.0, 1.0, 0.5, 0.5]);
        tile.explain(|pixel, sample| (pixel == [0, 0] && sample == 1).then_some(Cause::Scattering));
        assert_eq!((tile.tally.clamped, tile.tally.nonfinite), (3.0, 1));
        assert_eq!(tile.tally.dropped.by_cause().collect::<Vec<_>>(), [(Cause::Scattering, 1)]);
    }
}
