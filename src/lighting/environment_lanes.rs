//! The environment's picture for sixteen directions at a time.

use crate::lanes::{Floats, Lanes, Mask, V3, Words, functions};
use glam::Vec3;
use kiln_formats::scene::UpAxis;
use std::f32::consts::{FRAC_1_PI, PI};

/// Tables that lanes read: the picture by channels, and distributions over its sampling grid.
#[derive(Debug, Default)]
pub(super) struct MapTable {
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// The picture's channels, row by row.
    pub pixels: [Vec<f32>; 3],
    /// Columns and rows of the sampling grid.
    pub grid: [u32; 2],
    /// Running sums over rows, and over the columns of each row, both scaled to end in 1.
    pub rows: Vec<f32>,
    pub columns: Vec<f32>,
    /// Density of each cell with respect to the unit square.
    pub density: Vec<f32>,
    pub rotation_turns: f32,
    pub up: Option<UpAxis>,
}

impl MapTable {
    /// Of a picture and the weights of its sampling grid, row by row.
    pub fn new(
        pixels: &[Vec3],
        size: [usize; 2],
        weights: &[f32],
        grid: [usize; 2],
        rotation: f32,
        up: UpAxis,
    ) -> Self {
        let sums: Vec<f64> = weights.chunks_exact(grid[0]).map(|r| r.iter().map(|w| f64::from(*w)).sum()).collect();
        let total: f64 = sums.iter().sum();
        let running = |weights: &mut dyn Iterator<Item = f64>, total: f64| {
            let mut sum = 0.0;
            let unit = if total > 0.0 { 1.0 / total } else { 0.0 };
            let shares = weights.map(|w| {
                sum += w;
                (sum * unit) as f32
            });
            let mut shares: Vec<f32> = shares.collect();
            // Numbers below 1 must find a cell that has weight.
            let last = shares.iter().rposition(|s| *s < 1.0).map_or(0, |k| k + 1);
            shares[last..].fill(1.0);
            shares
        };
        let mut columns = Vec::with_capacity(weights.len());
        for (row, sum) in weights.chunks_exact(grid[0]).zip(&sums) {
            columns.extend(running(&mut row.iter().map(|w| f64::from(*w)), *sum));
        }
        let rows = running(&mut sums.iter().copied(), total);
        let cells = weights.len() as f64;
        Self {
            size: size.map(|x| x as u32),
            pixels: [0, 1, 2].map(|k| pixels.iter().map(|p| p[k]).collect()),
            grid: grid.map(|x| x as u32),
            rows,
            columns,
            density: weights.iter().map(|w| (f64::from(*w) / total * cells) as f32).collect(),
            rotation_turns: rotation * (0.5 * FRAC_1_PI),
            up: Some(up),
        }
    }

    fn z_up(&self) -> bool {
        self.up == Some(UpAxis::Z)
    }

    /// The place of unit vectors in the picture.
    #[inline(always)]
    pub fn locate<L: Lanes>(&self, l: L, dir: V3<L::F>) -> [L::F; 2] {
        let d = if self.z_up() { V3::new(dir.x, dir.z, -dir.y) } else { dir };
        let turns = functions::atan2(d.z, d.x) * (0.5 * FRAC_1_PI) + 0.5 + self.rotation_turns;
        let v = functions::atan2((d.x * d.x + d.z * d.z).sqrt(), d.y) * FRAC_1_PI;
        let _ = l;
        [turns - turns.floor(), v]
    }

    /// Radiance from places of the picture, by bilinear interpolation.
    #[inline(always)]
    pub fn radiance<L: Lanes>(&self, l: L, [u, v]: [L::F; 2]) -> V3<L::F> {
        let [width, height] = self.size;
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let zero = l.splat(0.0);
        let (last_x, last_y) = (l.splat(width as f32 - 1.0), l.splat(height as f32 - 1.0));
        let left = L::F::select(x0.lt(zero), last_x, x0.min(last_x));
        let right = L::F::select(left.lt(last_x), left + 1.0, zero);
        let (top, bottom) = (y0.max(zero).min(last_y), (y0 + 1.0).max(zero).min(last_y));
        let row = |y: L::F| y.truncate() * width;
        let (left, right, top, bottom) = (left.truncate(), right.truncate(), row(top), row(bottom));
        let one = l.splat(1.0);
        V3::from_fn(|k| {
            let at = |place: L::U| l.gather(&self.pixels[k], place);
            let above = at(top + left) * (one - fx) + at(top + right) * fx;
            let below = at(bottom + left) * (one - fx) + at(bottom + right) * fx;
            above * (one - fy) + below * fy
        })
    }

    /// Solid angle density at places of the picture.
    #[inline(always)]
    pub fn pdf<L: Lanes>(&self, l: L, [u, v]: [L::F; 2]) -> L::F {
        let [width, height] = self.grid;
        let cell = |x: L::F, count: u32| (x * count as f32).min(l.splat(count as f32 - 1.0)).truncate();
        let density = l.gather(&self.density, cell(v, height) * width + cell(u, width));
        let (sine, _) = functions::sin_cos_turns(v * 0.5);
        let found = sine.gt(l.splat(0.0));
        (density / (sine * (2.0 * PI * PI))).only(found)
    }

    /// Unit directions, chosen by the picture's luminance, and their places.
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, u: [L::F; 2]) -> (V3<L::F>, [L::F; 2]) {
        let [width, height] = self.grid;
        let (row, v) = invert(l, &self.rows, l.word(0), height, u[1]);
        let (column, across) = invert(l, &self.columns, row * width, width, u[0]);
        let turns = (column.to_floats() + across) / width as f32 - 0.5 - self.rotation_turns;
        let (sin_phi, cos_phi) = functions::sin_cos_turns(turns);
        let (sine, cosine) = functions::sin_cos_turns((row.to_floats() + v) / (2.0 * height as f32));
        let d = V3::new(sine * cos_phi, cosine, sine * sin_phi);
        let dir = if self.z_up() { V3::new(d.x, -d.z, d.y) } else { d };
        // Where the direction really is: rounding may carry it over a cell's border, and `pdf` must agree.
        (dir, self.locate(l, dir))
    }
}

/// The item of a list of running sums, `count` of them from `first` on, that holds each number, and the place within it.
#[inline(always)]
fn invert<L: Lanes>(l: L, sums: &[f32], first: L::U, count: u32, u: L::F) -> (L::U, L::F) {
    let mut below = l.word(0);
    let mut step = count.next_power_of_two();
    while step > 0 {
        let tried = below + step;
        let taken = l.gather(sums, first + tried - l.word(1)).le(u) & tried.lt(l.word(count));
        below = L::U::select(taken, tried, below);
        step /= 2;
    }
    let zero = l.splat(0.0);
    let at_start = below.eq(l.word(0));
    let before = l.gather(sums, first + below - L::U::select(at_start, l.word(0), l.word(1)));
    let before = L::F::select(at_start, zero, before);
    let own = l.gather(sums, first + below) - before;
    let within = ((u - before) / own).max(zero).min(l.splat(1.0 - f32::EPSILON));
    debug_assert!(!within.lt(zero).any());
    (below, within)
}
