use crate::film::Film;

/// Pixels to each side that count as surroundings.
const RADIUS: usize = 2;

/// What is known of a pixel, and summed up over its surroundings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Pixels that the asset covers.
    pub count: f64,
    /// Of what the pixels' own replicates say of their squared errors, displayed and relative.
    pub own: [f64; 2],
    /// Of linear, premultiplied red, green and blue, and the coverage.
    pub mean: [f64; 4],
    /// Of the squares of red, green and blue.
    pub squares: [f64; 3],
    /// Of the variances of red, green and blue, all three.
    pub noise: f64,
    /// Of the levels as displayed.
    pub levels: [f64; 3],
    /// Of their squares, all three.
    pub level_squares: f64,
}

impl std::ops::AddAssign<&Self> for Sums {
    fn add_assign(&mut self, other: &Self) {
        self.count += other.count;
        (0..2).for_each(|k| self.own[k] += other.own[k]);
        (0..4).for_each(|c| self.mean[c] += other.mean[c]);
        (0..3).for_each(|c| self.squares[c] += other.squares[c]);
        self.noise += other.noise;
        (0..3).for_each(|c| self.levels[c] += other.levels[c]);
        self.level_squares += other.level_squares;
    }
}

impl Sums {
    /// The share of noise in what differs between the pixels, in linear light: about 1 where they differ by noise alone, and more by
    /// chance.
    pub fn share_of_noise(&self) -> f64 {
        let n = self.count;
        let seen: f64 = (0..3).map(|c| self.squares[c] - self.mean[c] * self.mean[c] / n).sum::<f64>() / (n - 1.0);
        let share = self.noise / n / seen;
        if share.is_finite() { share.max(0.0) } else { 0.0 }
    }

    /// Mean of all pixels.
    pub fn center(&self) -> [f64; 4] {
        self.mean.map(|sum| sum / self.count)
    }

    /// Mean square distance of the displayed pixels from `shown`, what [`Self::center`] looks like; mean of the channels. Unbiased
    /// where only noise differs and the curve is straight.
    pub fn displayed_spread(&self, shown: [f64; 3]) -> f64 {
        let cross: f64 = (0..3).map(|c| shown[c] * (self.count * shown[c] - 2.0 * self.levels[c])).sum();
        (self.level_squares + cross).max(0.0) / 3.0 / (self.count - 1.0)
    }

    /// The same in linear light, relative to the square of [`Self::center`] and `epsilon`.
    pub fn relative_spread(&self, epsilon: f64) -> f64 {
        let center = self.center();
        let channel = |c: usize| {
            let square = self.squares[c] - self.mean[c] * center[c];
            square.max(0.0) / (center[c] * center[c] + epsilon)
        };
        (0..3).map(channel).sum::<f64>() / 3.0 / (self.count - 1.0)
    }
}

/// Every pixel of the rows `rows`, row by row: what is known of it, as `of` tells, and the sum over its surroundings, in an order
/// that does not depend on how a film is cut into rows.
pub(super) fn with_surroundings(
    film: &Film,
    rows: std::ops::Range<usize>,
    of: impl Fn(usize) -> Sums,
) -> Vec<(Sums, Sums)> {
    let (width, height) = (film.width as usize, film.height as usize);
    let around = |at: usize, size: usize| at.saturating_sub(RADIUS)..(at + RADIUS + 1).min(size);
    let outer = rows.start.saturating_sub(RADIUS)..(rows.end + RADIUS).min(height);
    let total = |sums: &mut dyn Iterator<Item = &Sums>| {
        let mut total = Sums::default();
        sums.for_each(|s| total += s);
        total
    };
    let pixels: Vec<Sums> = (outer.start * width..outer.end * width).map(of).collect();
    let mut across = Vec::with_capacity(pixels.len());
    for row in pixels.chunks(width.max(1)) {
        across.extend((0..width).map(|x| total(&mut row[around(x, width)].iter())));
    }
    let down = |x: usize, y: usize| around(y, height).map(move |v| (v - outer.start) * width + x);
    rows.flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| (pixels[(y - outer.start) * width + x], total(&mut down(x, y).map(|at| &across[at]))))
        .collect()
}
