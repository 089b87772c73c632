use super::{Cause, Dropped, DroppedSample, RayCounts};
use crate::film::{PixelSums, SQUARE};
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

/// A square of pixels that a thread works on, in place. What it has before the pass is kept aside, so that a pass that is stopped leaves
/// the film as it was.
pub(super) struct Tile<'a> {
    /// The left upper corner in the picture.
    pub x: u32,
    pub y: u32,
    /// Smaller than [`SIDE`] at the right and the lower edge of the picture.
    pub width: u32,
    pub height: u32,
    /// Its rows in the film.
    rows: Vec<&'a mut [PixelSums]>,
    /// Of a film that has samples: the sums before the pass, once it has begun.
    before: Vec<PixelSums>,
    aim: Aim<'a>,
    /// Pixels across the film.
    across: usize,
    /// What it cost.
    pub tally: PassTally,
    /// Pixel and sample of what was not finite.
    nonfinite: Vec<([u32; 2], u32)>,
    clamp: f32,
}

impl<'a> Tile<'a> {
    /// The tiles of a film so many pixels wide, row by row, to be filled up to `aim`. Channels of samples above `clamp` are cut off there.
    pub fn all(pixels: &'a mut [PixelSums], across: u32, clamp: Option<f32>, aim: Aim<'a>) -> Vec<Self> {
        let (across, side) = (across as usize, SIDE as usize);
        let clamp = clamp.unwrap_or(f32::INFINITY);
        let mut tiles = Vec::new();
        for (k, band) in pixels.chunks_mut(across * side).enumerate() {
            let (first, height) = (tiles.len(), band.len() / across);
            tiles.extend((0..across).step_by(side).map(|x| Self {
                x: x as u32,
                y: k as u32 * SIDE,
                width: side.min(across - x) as u32,
                height: height as u32,
                rows: Vec::with_capacity(height),
                before: Vec::new(),
                aim,
                across,
                tally: PassTally::default(),
                nonfinite: Vec::new(),
                clamp,
            }));
            for row in band.chunks_mut(across) {
                tiles[first..].iter_mut().zip(row.chunks_mut(side)).for_each(|(tile, part)| tile.rows.push(part));
            }
        }
        tiles
    }

    /// Its pixels, row by row, counted from its corner.
    pub fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let width = self.width;
        (0..width * self.height).map(move |k| [k % width, k / width])
    }

    /// Whether sums were kept.
    pub fn is_begun(&self) -> bool {
        !self.before.is_empty()
    }

    /// To be called before a sample is added to a film that has some.
    pub fn keep(&mut self) {
        self.before.reserve_exact((self.width * self.height) as usize);
        self.rows.iter().for_each(|row| self.before.extend_from_slice(row));
    }

    /// Makes all sums what they were: those that were kept, or none.
    pub fn undo(&mut self) {
        let mut before = self.before.drain(..);
        self.rows.iter_mut().flat_map(|row| row.iter_mut()).for_each(|sums| *sums = before.next().unwrap_or_default());
    }

    /// The sums of a pixel of the tile.
    fn sums(&mut self, [x, y]: [u32; 2]) -> &mut PixelSums {
        &mut self.rows[y as usize][x as usize]
    }

    /// The samples that a pixel of the tile lacks.
    pub fn wanted(&self, [x, y]: [u32; 2]) -> Range<u32> {
        let place = (self.y + y) as usize * self.across + (self.x + x) as usize;
        self.rows[y as usize][x as usize].samples()..self.aim.at(place)
    }

    /// Counts the samples that a pixel of the tile lacks as camera rays that meet nothing, before nothing.
    pub fn pass_over(&mut self, pixel: [u32; 2]) {
        let wanted = self.wanted(pixel);
        self.tally.rays.camera += wanted.len() as u64;
        if let Some(last) = wanted.last() {
            self.sums(pixel).drop_sample(last);
        }
    }

    /// Adds a sample to a pixel of the tile. Those of a pixel come in ascending order; the order
    /// between pixels is free. A sample that is not finite is counted and dropped.
    pub fn add(&mut self, pixel: [u32; 2], sample: u32, radiance: Vec3, covered: bool) {
        if !radiance.is_finite() {
            self.nonfinite.push((pixel, sample));
            self.sums(pixel).drop_sample(sample);
            return;
        }
        let kept = if radiance.max_element() > self.clamp { self.cut(radiance) } else { radiance };
        self.sums(pixel).add(sample, kept.extend(f32::from(u8::from(covered))).to_array());
    }

    /// Has the dropped samples of this pass explained: `cause_of` follows the path of a sample again.
    pub fn explain(&mut self, cause_of: impl Fn([u32; 2], u32) -> Option<Cause>) {
        for ([x, y], sample) in std::mem::take(&mut self.nonfinite) {
            let pixel = [self.x + x, self.y + y];
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

    /// What its rays cost, in camera rays.
    pub fn work(&self) -> u64 {
        let RayCounts { camera, bounce, shadow } = self.tally.rays;
        camera + SCATTERED * bounce + shadow
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Film;

    #[test]
    fn tiles_cover_each_pixel_once_and_keep_what_is_there() {
        let mut film = Film::new(37, 18, false);
        for pass in 0..2 {
            for tile in &mut Tile::all(&mut film.pixels, 37, None, Aim::All(pass + 1)) {
                for pixel in tile.pixels() {
                    assert_eq!(tile.wanted(pixel), pass..pass + 1);
                    tile.add(pixel, pass, Vec3::ONE, true);
                }
            }
        }
        assert!(film.pixels.iter().all(|p| p.mean() == [1.0; 4] && p.samples() == 2));
    }

    #[test]
    fn what_is_undone_was_never_there() {
        let mut film = Film::new(20, 17, false);
        for begun in [false, true] {
            let before = film.clone();
            let mut tiles = Tile::all(&mut film.pixels, 20, None, Aim::All(9));
            // One of them has not begun.
            for tile in &mut tiles[1..] {
                if begun {
                    tile.keep();
                }
                tile.add([3, 0], 4, Vec3::ONE, true);
            }
            tiles.iter_mut().skip(usize::from(begun)).for_each(Tile::undo);
            assert!(film == before);
            film.pixels.iter_mut().enumerate().for_each(|(k, sums)| sums.add(3, [k as f32; 4]));
        }
    }

    #[test]
    fn each_pixel_has_its_own_aim() {
        let aims: Vec<u32> = (0..37 * 18).collect();
        let mut film = Film::new(37, 18, false);
        let tiles = Tile::all(&mut film.pixels, 37, None, Aim::Each(&aims));
        let corners: Vec<_> = tiles.iter().map(|t| (t.x, t.y, t.width, t.height)).collect();
        let expected =
            [(0, 0, 16, 16), (16, 0, 16, 16), (32, 0, 5, 16), (0, 16, 16, 2), (16, 16, 16, 2), (32, 16, 5, 2)];
        assert_eq!((corners, tiles[5].wanted([4, 1])), (expected.to_vec(), 0..37 * 18 - 1));
    }

    #[test]
    fn what_clamping_takes_is_told() {
        let mut film = Film::new(1, 1, false);
        let mut tiles = Tile::all(&mut film.pixels, 1, Some(2.0), Aim::All(2));
        let tile = &mut tiles[0];
        tile.add([0, 0], 0, Vec3::new(5.0, 2.0, 1.0), true);
        tile.add([0, 0], 1, Vec3::new(f32::NAN, 2.0, 1.0), true);
        tile.explain(|pixel, sample| (pixel == [0, 0] && sample == 1).then_some(Cause::Scattering));
        assert_eq!((tile.tally.clamped, tile.tally.nonfinite), (3.0, 1));
        assert_eq!(tile.tally.dropped.by_cause().collect::<Vec<_>>(), [(Cause::Scattering, 1)]);
        assert_eq!(film.pixels[0].mean(), [1.0, 1.0, 0.5, 0.5]);
    }
}
