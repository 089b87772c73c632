//! The surface area heuristic: 32 bins on each axis, refined to exact reference edges in small cells.

use super::bounds::{Bounds, Reference};
use super::split::{BLOCK, COST_BLOCK, COST_VISIT, Candidate, Cell, Plane, blocks, leaf_cost, split_cost};

/// Bins on an axis.
const BINS: usize = 32;
/// Above this many references, a sample is binned: what the planes are chosen by hardly changes.
const SAMPLE_ABOVE: usize = 4096;
/// One reference in this many is in the sample.
const SAMPLE_STRIDE: usize = 8;
/// Up to this many references, planes are moved to the exact edges of references.
const REFINE_UP_TO: usize = 256;
/// Above this many references, a split may cost up to `LARGE_LEAF_SLACK` leaves: below it, better ones may turn up.
const LARGE_LEAF: usize = 128;
const LARGE_LEAF_SLACK: f32 = 1.3;

/// The cheapest plane whose duplicates the cell can afford, if it is worth it.
pub fn choose(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    let stride = if refs.len() > SAMPLE_ABOVE { SAMPLE_STRIDE } else { 1 };
    let mut best = Bins::fill(refs, cell, stride).cheapest(refs.len(), cell, stride)?;
    if refs.len() <= REFINE_UP_TO {
        best = refine(refs, cell, best);
    }
    let slack = if refs.len() > LARGE_LEAF { LARGE_LEAF_SLACK } else { 1.0 };
    (best.cost < leaf_cost(refs.len()) * cell.bounds.half_area() * slack).then_some(best.plane)
}

/// Counts and boxes of the references by the bin in which they begin and by the bin in which they end.
struct Bins {
    origin: [f32; 3],
    width: [f32; 3],
    begin: [[Bounds; BINS]; 3],
    end: [[Bounds; BINS]; 3],
    begun: [[u32; BINS]; 3],
    ended: [[u32; BINS]; 3],
}

impl Bins {
    fn fill(refs: &[Reference], cell: &Cell, stride: usize) -> Self {
        let origin = [0, 1, 2].map(|axis| cell.bounds.lo(axis));
        let extent = [0, 1, 2].map(|axis| cell.bounds.hi(axis) - cell.bounds.lo(axis));
        let mut bins = Self {
            origin,
            width: extent.map(|x| x / BINS as f32),
            begin: [[Bounds::EMPTY; BINS]; 3],
            end: [[Bounds::EMPTY; BINS]; 3],
            begun: [[0; BINS]; 3],
            ended: [[0; BINS]; 3],
        };
        let scale = extent.map(|x| if x > 0.0 { BINS as f32 / x } else { 0.0 });
        for reference in refs.iter().step_by(stride) {
            for axis in 0..3 {
                // The cast saturates, and sends NaN (0 × ∞ in a cell without extent) to 0.
                let bin = |x: f32| (((x - origin[axis]) * scale[axis]) as usize).min(BINS - 1);
                let first = bin(reference.lo(axis));
                let last = bin(reference.hi(axis));
                bins.begin[axis][first].merge(reference);
                bins.end[axis][last].merge(reference);
                bins.begun[axis][first] += 1;
                bins.ended[axis][last] += 1;
            }
        }
        bins
    }

    fn cheapest(&self, n: usize, cell: &Cell, stride: usize) -> Option<Candidate> {
        let area = cell.bounds.half_area();
        let sampled: u32 = self.begun[0].iter().sum();
        let weight = n as f32 / sampled.max(1) as f32;
        let scaled = |count: u32| if stride == 1 { count as usize } else { (count as f32 * weight) as usize };
        let mut best: Option<Candidate> = None;
        for axis in 0..3 {
            let plane_at = |k: usize| self.origin[axis] + self.width[axis] * k as f32;
            // What lies right of each plane, from the right; then what lies left, from the left.
            let mut right = [(0.0f32, 0u32); BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for k in (1..BINS).rev() {
                bounds.merge(&self.end[axis][k]);
                count += self.ended[axis][k];
                let mut cut = bounds;
                cut.set_lo(axis, cut.lo(axis).max(plane_at(k)));
                right[k] = (cut.half_area(), count);
            }
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for (k, &(area_right, count_right)) in right.iter().enumerate().skip(1) {
                bounds.merge(&self.begin[axis][k - 1]);
                count += self.begun[axis][k - 1];
                let at = plane_at(k);
                let both = (count + count_right).saturating_sub(sampled);
                let inside = cell.bounds.lo(axis) < at && at < cell.bounds.hi(axis);
                if count == 0 || count_right == 0 || !inside || scaled(both) > cell.budget {
                    continue;
                }
                let mut cut = bounds;
                cut.set_hi(axis, cut.hi(axis).min(at));
                let cost = split_cost(area, (cut.half_area(), scaled(count)), (area_right, scaled(count_right)));
                if best.is_none_or(|b| cost < b.cost) {
                    best = Some(Candidate { plane: Plane { axis, at }, cost });
                }
            }
        }
        best
    }
}

/// Moves a plane to the best edge of a reference within a bin of it.
fn refine(refs: &[Reference], cell: &Cell, coarse: Candidate) -> Candidate {
    let axis = coarse.plane.axis;
    let width = (cell.bounds.hi(axis) - cell.bounds.lo(axis)) / BINS as f32;
    let window = (coarse.plane.at - width, coarse.plane.at + width);
    let area = cell.bounds.half_area();
    // Most references lie on one side of all candidates: they are merged once.
    let (mut left_of_all, mut right_of_all) = (Bounds::EMPTY, Bounds::EMPTY);
    let (mut left_count, mut right_count) = (0usize, 0usize);
    let mut between = [0u16; REFINE_UP_TO];
    let mut edges = [0.0f32; 2 * REFINE_UP_TO];
    let (mut between_len, mut edges_len) = (0, 0);
    for (i, reference) in refs.iter().enumerate().take(REFINE_UP_TO) {
        let (lo, hi) = (reference.lo(axis), reference.hi(axis));
        if hi <= window.0 {
            left_of_all.merge(reference);
            left_count += 1;
        } else if lo >= window.1 {
            right_of_all.merge(reference);
            right_count += 1;
        } else {
            between[between_len] = i as u16;
            between_len += 1;
        }
        for x in [lo, hi] {
            if window.0 < x && x < window.1 && cell.bounds.lo(axis) < x && x < cell.bounds.hi(axis) {
                edges[edges_len] = x;
                edges_len += 1;
            }
        }
    }
    let mut best = coarse;
    let mut previous = f32::NAN;
    edges[..edges_len].sort_unstable_by(f32::total_cmp);
    for &at in &edges[..edges_len] {
        if at == previous {
            continue;
        }
        previous = at;
        let (mut left, mut right) = (left_of_all, right_of_all);
        let (mut n_left, mut n_right) = (left_count, right_count);
        for &i in &between[..between_len] {
            let reference = &refs[usize::from(i)];
            if reference.lo(axis) < at {
                left.merge(reference);
                n_left += 1;
            }
            if reference.hi(axis) > at {
                right.merge(reference);
                n_right += 1;
            }
        }
        if n_left == 0 || n_right == 0 || (n_left + n_right).saturating_sub(refs.len()) > cell.budget {
            continue;
        }
        left.set_hi(axis, left.hi(axis).min(at));
        right.set_lo(axis, right.lo(axis).max(at));
        let cost = split_cost(area, (left.half_area(), n_left), (right.half_area(), n_right));
        if cost < best.cost {
            best = Candidate { plane: Plane { axis, at }, cost };
        }
    }
    best
}

/// The tree's expected cost of a ray that meets the root: what the builders minimise.
///
/// `cells` yields the half area of each cell's box, and the number of references if it is a leaf.
pub fn tree_cost(root_area: f32, cells: impl Iterator<Item = (f32, Option<usize>)>) -> f64 {
    let cost = |n: Option<usize>| n.map_or(COST_VISIT, |n| COST_BLOCK * blocks(n));
    let sum: f64 = cells.map(|(area, n)| f64::from(area) * f64::from(cost(n))).sum();
    if root_area > 0.0 { sum / f64::from(root_area) } else { 0.0 }
}

/// Whether a cell is small enough that no plane can be worth it.
pub fn is_small(n: usize) -> bool {
    n <= BLOCK
}
