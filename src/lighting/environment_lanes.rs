//! The environment's picture for sixteen directions at a time.

use crate::lanes::{Floats, Lanes, Mask, V3, Words, functions};
use glam::Vec3;
use kiln_formats::scene::UpAxis;
use std::f32::consts::{FRAC_1_PI, PI};

/// Tables that lanes read: the picture, and distributions over its sampling grid. They are kept small and together, since
/// what they cost is fetching them.
#[derive(Debug, Default)]
pub(super) struct MapTable {
    /// Columns and rows of the picture.
    size: [u32; 2],
    /// Red, green and blue of its pixels, row by row, and room to read four from anywhere.
    pixels: Vec<f32>,
    /// Columns and rows of the sampling grid.
    grid: [u32; 2],
    rows: Shares,
    /// Over the columns of each row.
    columns: Shares,
    /// Of each cell, with respect to the unit square.
    densities: Vec<f32>,
    rotation_turns: f32,
    up: Option<UpAxis>,
}

/// Lists of shares, all of one length.
#[derive(Debug, Default)]
struct Shares {
    /// Items of a list.
    count: u32,
    /// For each list the running sums of the shares before its items, from 0 on, and 1. At the end of all there is room to read four
    /// from anywhere.
    sums: Vec<f32>,
    /// Parts of [0, 1), a power of two.
    parts: u32,
    /// For each part the first item that reaches into it, and above 16 bits that of the next part.
    guide: Vec<u32>,
}

impl Shares {
    /// Lists of `count` items, fewer than 2¹⁶, with these weights ≥ 0.
    fn new(count: usize, weights: &[f64]) -> Self {
        let parts = (count / 2).next_power_of_two();
        let mut sums = Vec::with_capacity(weights.len() / count * (count + 1) + 2);
        let mut guide = Vec::with_capacity(weights.len() / count * parts);
        for weights in weights.chunks_exact(count) {
            let total: f64 = weights.iter().sum();
            let unit = if total > 0.0 { 1.0 / total } else { 0.0 };
            let mut sum = 0.0;
            let running = weights.iter().map(|w| {
                sum += w;
                (sum * unit) as f32
            });
            let mut running: Vec<f32> = running.collect();
            // Numbers below 1 must find an item that has weight.
            let last = running.iter().rposition(|s| *s < 1.0).map_or(0, |k| k + 1);
            running[last..].fill(1.0);
            let first = |part: usize| running.partition_point(|s| *s <= part as f32 / parts as f32).min(count - 1);
            guide.extend((0..parts).map(|part| (first(part) | first(part + 1) << 16) as u32));
            sums.push(0.0);
            sums.extend(running);
        }
        sums.extend([1.0; 2]);
        Self { count: count as u32, sums, parts: parts as u32, guide }
    }

    /// The items that hold numbers in [0, 1), each in a list of its own, and the places within them.
    #[inline(always)]
    fn invert<L: Lanes>(&self, l: L, list: L::U, u: L::F) -> (L::U, L::F) {
        let part = l.gather_words(&self.guide, list * self.parts + (u * self.parts as f32).truncate());
        let (mut low, mut high) = (part & 0xFFFF, part.shr::<16>());
        let first = list * (self.count + 1);
        while low.lt(high).any() {
            let middle = (low + high).shr::<1>();
            let beyond = l.gather(&self.sums, first + middle + 1).le(u);
            low = L::U::select(beyond, middle + 1, low);
            high = L::U::select(beyond, high, middle);
        }
        let [before, end, ..] = l.gather_four(&self.sums, first + low);
        (low, ((u - before) / (end - before)).max(l.splat(0.0)).min(l.splat(1.0 - f32::EPSILON)))
    }
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
        let weights: Vec<f64> = weights.iter().map(|w| f64::from(*w)).collect();
        let sums: Vec<f64> = weights.chunks_exact(grid[0]).map(|row| row.iter().sum()).collect();
        let total: f64 = sums.iter().sum();
        let cells = weights.len() as f64;
        Self {
            size: size.map(|x| x as u32),
            pixels: pixels.iter().flat_map(|p| p.to_array()).chain([0.0]).collect(),
            grid: grid.map(|x| x as u32),
            rows: Shares::new(grid[1], &sums),
            columns: Shares::new(grid[0], &weights),
            densities: weights.iter().map(|w| (w / total * cells) as f32).collect(),
            rotation_turns: rotation * (0.5 * FRAC_1_PI),
            up: Some(up),
        }
    }

    /// A pixel, by its number.
    pub fn pixel(&self, at: usize) -> Vec3 {
        Vec3::from_slice(&self.pixels[3 * at..])
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
        let (left, right) = (left.truncate(), right.truncate());
        let (top, bottom) = (top.truncate() * width, bottom.truncate() * width);
        let one = l.splat(1.0);
        let above = self.pixels_at(l, top + left) * (one - fx) + self.pixels_at(l, top + right) * fx;
        let below = self.pixels_at(l, bottom + left) * (one - fx) + self.pixels_at(l, bottom + right) * fx;
        above * (one - fy) + below * fy
    }

    #[inline(always)]
    fn pixels_at<L: Lanes>(&self, l: L, at: L::U) -> V3<L::F> {
        let [red, green, blue, _] = l.gather_four(&self.pixels, at * 3);
        V3::new(red, green, blue)
    }

    /// Solid angle density at places of the picture.
    #[inline(always)]
    pub fn pdf<L: Lanes>(&self, l: L, [u, v]: [L::F; 2]) -> L::F {
        let [width, height] = self.grid;
        let density = l.gather(&self.densities, cell(l, v, height) * width + cell(l, u, width));
        let (sine, _) = functions::sin_cos_turns(v * 0.5);
        let found = sine.gt(l.splat(0.0));
        (density / (sine * (2.0 * PI * PI))).only(found)
    }

    /// Unit directions, chosen by the picture's luminance, and their places.
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, u: [L::F; 2]) -> (V3<L::F>, [L::F; 2]) {
        let [width, height] = self.grid;
        let (row, v) = self.rows.invert(l, l.word(0), u[1]);
        let (column, across) = self.columns.invert(l, row, u[0]);
        let turns = (column.to_floats() + across) / width as f32 - 0.5 - self.rotation_turns;
        let (sin_phi, cos_phi) = functions::sin_cos_turns(turns);
        let (sine, cosine) = functions::sin_cos_turns((row.to_floats() + v) / (2.0 * height as f32));
        let d = V3::new(sine * cos_phi, cosine, sine * sin_phi);
        let dir = if self.z_up() { V3::new(d.x, -d.z, d.y) } else { d };
        // Where the direction really is: rounding may carry it over a cell's border, and `pdf` must agree.
        (dir, self.locate(l, dir))
    }
}

/// The cell of `count` that a place in [0, 1] lies in.
#[inline(always)]
fn cell<L: Lanes>(l: L, x: L::F, count: u32) -> L::U {
    (x * count as f32).min(l.splat(count as f32 - 1.0)).truncate()
}
