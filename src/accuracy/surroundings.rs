use super::jackknife::Each;
use crate::lanes::LANES;

/// Pixels to each side that count as surroundings.
pub(super) const RADIUS: usize = 2;
/// Pixels across.
const ACROSS: usize = 2 * RADIUS + 1;

/// What is known of sixteen pixels, or summed up over the surroundings of each: a number for each of [`FIELDS`], zeros where the asset
/// does not cover a pixel.
pub(super) type Fields = [Each; FIELDS];

/// Pixels that the asset covers.
pub(super) const COUNT: usize = 0;
/// What the pixels' own replicates say of their squared errors, displayed and relative: two fields.
pub(super) const OWN: usize = 1;
/// Linear, premultiplied red, green and blue, and the coverage: four.
pub(super) const MEAN: usize = 3;
/// The squares of red, green and blue: three.
pub(super) const SQUARES: usize = 7;
/// The variances of red, green and blue, all three.
pub(super) const NOISE: usize = 10;
/// The levels as displayed: three.
pub(super) const LEVELS: usize = 11;
/// Their squares, all three.
pub(super) const LEVEL_SQUARES: usize = 14;
/// How many there are.
pub(super) const FIELDS: usize = 15;

/// Sums over the 5 × 5 pixels around each, row after row from the top, in an order that does not depend on where one begins.
pub(super) struct Surroundings {
    /// Numbers in a row of a field.
    stride: usize,
    /// The row that was told last, field by field, between zeros.
    told: Vec<f64>,
    /// The last five rows, each summed up across.
    across: [Vec<f64>; ACROSS],
    /// What was known of the pixels of the last three rows themselves, field by field up to [`MEAN`].
    own: [Vec<f64>; RADIUS + 1],
}

impl Surroundings {
    /// For rows of so many pixels. As if rows of zeros had been told.
    pub fn new(width: usize) -> Self {
        let stride = width.next_multiple_of(LANES);
        let across = std::array::from_fn(|_| vec![0.0; FIELDS * stride]);
        let own = std::array::from_fn(|_| vec![0.0; MEAN * stride]);
        Self { stride, told: vec![0.0; FIELDS * (stride + 2 * RADIUS)], across, own }
    }

    /// Sets what is known of sixteen pixels of the next row, from the `x`-th on.
    #[inline(always)]
    pub fn tell(&mut self, x: usize, fields: &Fields) {
        for (row, field) in self.told.chunks_exact_mut(self.stride + 2 * RADIUS).zip(fields) {
            row[RADIUS + x..RADIUS + x + LANES].copy_from_slice(field);
        }
    }

    /// Ends a row.
    #[inline(always)]
    pub fn next(&mut self) {
        self.across.rotate_left(1);
        self.own.rotate_left(1);
        let told = self.told.chunks_exact(self.stride + 2 * RADIUS);
        for (own, row) in self.own[RADIUS].chunks_exact_mut(self.stride).zip(told) {
            own.copy_from_slice(&row[RADIUS..RADIUS + self.stride]);
        }
        let rows = self.across[ACROSS - 1].chunks_exact_mut(self.stride);
        for (sums, row) in rows.zip(self.told.chunks_exact(self.stride + 2 * RADIUS)) {
            let n = sums.len();
            let (a, b, c, d, e) = (&row[..n], &row[1..n + 1], &row[2..n + 2], &row[3..n + 3], &row[4..n + 4]);
            for x in 0..n {
                sums[x] = a[x] + b[x] + c[x] + d[x] + e[x];
            }
        }
    }

    /// What was told of sixteen pixels of the third last row, from the `x`-th on: the fields up to [`MEAN`].
    #[inline(always)]
    pub fn own(&self, x: usize) -> [Each; MEAN] {
        let mut own = [[0.0; LANES]; MEAN];
        for (own, row) in own.iter_mut().zip(self.own[0].chunks_exact(self.stride)) {
            own.copy_from_slice(&row[x..x + LANES]);
        }
        own
    }

    /// The sums around sixteen pixels, from the `x`-th on, of the third last row.
    #[inline(always)]
    pub fn around(&self, x: usize) -> Fields {
        let mut sums = [[0.0; LANES]; FIELDS];
        for row in &self.across {
            for (sum, row) in sums.iter_mut().zip(row.chunks_exact(self.stride)) {
                let row = &row[x..x + LANES];
                for i in 0..LANES {
                    sum[i] += row[i];
                }
            }
        }
        sums
    }
}

/// The share of noise in what differs between the pixels around, in linear light: about 1 where they differ by noise alone, and more by
/// chance; 0 where there are not two.
#[inline(always)]
pub(super) fn share_of_noise(around: &Fields) -> Each {
    let mut seen = [0.0; LANES];
    for c in 0..3 {
        for i in 0..LANES {
            let (mean, n) = (around[MEAN + c][i], around[COUNT][i]);
            seen[i] += around[SQUARES + c][i] - mean * mean / n;
        }
    }
    let mut share = [0.0; LANES];
    for i in 0..LANES {
        let n = around[COUNT][i];
        let noise = around[NOISE][i] / n / (seen[i] / (n - 1.0));
        share[i] = if n > 1.0 && noise > 0.0 && noise < f64::INFINITY { noise } else { 0.0 };
    }
    share
}

/// Mean of all pixels around.
#[inline(always)]
pub(super) fn center(around: &Fields) -> [Each; 4] {
    let mut center = [[0.0; LANES]; 4];
    for c in 0..4 {
        for i in 0..LANES {
            center[c][i] = around[MEAN + c][i] / around[COUNT][i];
        }
    }
    center
}

/// Mean square distance of the displayed pixels around from `shown`, what [`center`] looks like; mean of the channels. Unbiased
/// where only noise differs and the curve is straight.
#[inline(always)]
pub(super) fn displayed_spread(around: &Fields, shown: &[Each; 3]) -> Each {
    let mut spread = around[LEVEL_SQUARES];
    for c in 0..3 {
        for i in 0..LANES {
            spread[i] += shown[c][i] * (around[COUNT][i] * shown[c][i] - 2.0 * around[LEVELS + c][i]);
        }
    }
    for i in 0..LANES {
        spread[i] = spread[i].max(0.0) / 3.0 / (around[COUNT][i] - 1.0);
    }
    spread
}

/// The same in linear light, relative to the square of [`center`] and `epsilon`.
#[inline(always)]
pub(super) fn relative_spread(around: &Fields, center: &[Each; 4], epsilon: f64) -> Each {
    let mut spread = [0.0; LANES];
    for c in 0..3 {
        for i in 0..LANES {
            let square = around[SQUARES + c][i] - around[MEAN + c][i] * center[c][i];
            spread[i] += square.max(0.0) / (center[c][i] * center[c][i] + epsilon);
        }
    }
    for i in 0..LANES {
        spread[i] = spread[i] / 3.0 / (around[COUNT][i] - 1.0);
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 21;
    const HEIGHT: usize = 7;

    /// Whole numbers, all different.
    fn number(field: usize, x: usize, y: usize) -> f64 {
        if x < WIDTH && y < HEIGHT { (1000 * field + 50 * y + x + 1) as f64 } else { 0.0 }
    }

    #[test]
    fn sums_are_those_of_the_five_by_five_pixels_around() {
        let mut around = Surroundings::new(WIDTH);
        for told in 0..HEIGHT + RADIUS {
            for first in (0..WIDTH).step_by(LANES) {
                let fields: Fields =
                    std::array::from_fn(|field| std::array::from_fn(|i| number(field, first + i, told)));
                around.tell(first, &fields);
            }
            around.next();
            let Some(y) = told.checked_sub(RADIUS) else { continue };
            for x in 0..WIDTH {
                let (first, i) = (x / LANES * LANES, x % LANES);
                let near = |at: usize| at.saturating_sub(RADIUS)..at + RADIUS + 1;
                for field in 0..FIELDS {
                    let sum: f64 = near(y).flat_map(|v| near(x).map(move |u| number(field, u, v))).sum();
                    assert_eq!(around.around(first)[field][i], sum, "field {field} at {x}, {y}");
                }
                assert_eq!(around.own(first)[OWN][i], number(OWN, x, y));
            }
        }
    }
}
