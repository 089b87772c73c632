//! The surface area heuristic: up to 32 bins on each axis, refined to exact reference edges in small cells and moved to an edge
//! that cuts few references in large ones.

use super::bounds::{Bounds, Reference};
use super::snap;
use super::split::{BLOCK, COST_BLOCK, COST_VISIT, Candidate, Cell, Plane, blocks, leaf_cost, split_cost};

/// Above this many references, a sample is binned: what the planes are chosen by hardly changes.
const SAMPLE_ABOVE: usize = 4096;
/// One reference in this many is in the sample.
const SAMPLE_STRIDE: usize = 8;
/// Up to this many references, planes are moved to the exact edges of references.
const REFINE_UP_TO: usize = 256;
/// Above this many references, a split may cost up to `LARGE_LEAF_SLACK` leaves: below it, better ones may turn up.
const LARGE_LEAF: usize = 128;
const LARGE_LEAF_SLACK: f32 = 1.3;

/// The cheapest plane whose duplicates the cell can afford, if it is worth it. Small cells get fewer bins: their planes
/// are refined anyway.
///
/// The same numbers come out whatever instructions this is compiled to.
#[inline(always)]
pub fn choose(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    match refs.len() {
        ..=64 => choose_among::<8>(refs, cell),
        65..=256 => choose_among::<16>(refs, cell),
        _ => choose_among::<32>(refs, cell),
    }
}

#[inline(always)]
fn choose_among<const BINS: usize>(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    let stride = if refs.len() > SAMPLE_ABOVE { SAMPLE_STRIDE } else { 1 };
    let mut best = Bins::<BINS>::fill(refs, cell, stride).cheapest(refs.len(), cell, stride)?;
    if refs.len() <= REFINE_UP_TO {
        let width = (cell.bounds.hi(best.plane.axis) - cell.bounds.lo(best.plane.axis)) / BINS as f32;
        best = refine(refs, cell, best, width);
    } else {
        let width = (cell.bounds.hi(best.plane.axis) - cell.bounds.lo(best.plane.axis)) / BINS as f32;
        best.plane = snap::to_an_edge(refs, cell, best.plane, width);
    }
    let slack = if refs.len() > LARGE_LEAF { LARGE_LEAF_SLACK } else { 1.0 };
    (best.cost < leaf_cost(refs.len()) * cell.bounds.half_area() * slack).then_some(best.plane)
}

/// Counts and boxes of the references by the bin in which they begin and by the bin in which they end, for each axis.
struct Bins<const BINS: usize> {
    begin: [[Bounds; BINS]; 3],
    end: [[Bounds; BINS]; 3],
    begun: [[u32; BINS]; 3],
    ended: [[u32; BINS]; 3],
}

impl<const BINS: usize> Bins<BINS> {
    #[inline(always)]
    fn fill(refs: &[Reference], cell: &Cell, stride: usize) -> Self {
        let mut bins = Self {
            begin: [[Bounds::EMPTY; BINS]; 3],
            end: [[Bounds::EMPTY; BINS]; 3],
            begun: [[0; BINS]; 3],
            ended: [[0; BINS]; 3],
        };
        // A bin's number is a linear function of a reference's eight numbers, the negated upper ends included.
        let (mut factor, mut offset) = ([0.0f32; 8], [0.0f32; 8]);
        for axis in 0..3 {
            let (lo, hi) = (cell.bounds.lo(axis), cell.bounds.hi(axis));
            let scale = if hi > lo { BINS as f32 / (hi - lo) } else { 0.0 };
            let scale = if scale.is_finite() { scale } else { 0.0 };
            factor[axis] = scale;
            factor[axis + 4] = -scale;
            offset[axis] = -lo * scale - 0.5;
            offset[axis + 4] = offset[axis];
        }
        for reference in refs.iter().step_by(stride) {
            // Rounds to a whole number by pushing the fraction out of the mantissa; cheaper than a checked cast.
            let bin: [u32; 8] = std::array::from_fn(|k| {
                let x = reference.0[k] * factor[k] + offset[k];
                let x = if x > 0.0 { x } else { 0.0 };
                (x + 8_388_608.0).to_bits() & 0xff
            });
            let bin = bin.map(|b| if b < BINS as u32 { b as usize } else { BINS - 1 });
            for axis in 0..3 {
                let (first, last) = (bin[axis], bin[axis + 4]);
                bins.begin[axis][first].merge(reference);
                bins.end[axis][last].merge(reference);
                bins.begun[axis][first] += 1;
                bins.ended[axis][last] += 1;
            }
        }
        bins
    }

    #[inline(always)]
    fn cheapest(&self, n: usize, cell: &Cell, stride: usize) -> Option<Candidate> {
        let area = cell.bounds.half_area();
        let sampled: u32 = self.begun[0].iter().sum();
        let weight = n as f32 / sampled.max(1) as f32;
        let scaled = |count: u32| if stride == 1 { count as usize } else { (count as f32 * weight) as usize };
        let mut best: Option<Candidate> = None;
        for axis in 0..3 {
            let (lo, hi) = (cell.bounds.lo(axis), cell.bounds.hi(axis));
            let width = (hi - lo) / BINS as f32;
            let plane_at = |k: usize| lo + width * k as f32;
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
                let inside = lo < at && at < hi;
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
#[inline(always)]
fn refine(refs: &[Reference], cell: &Cell, coarse: Candidate, width: f32) -> Candidate {
    let axis = coarse.plane.axis;
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
