//! The surface area heuristic: planes evenly over each axis, refined to exact reference edges in small cells and moved to an edge
//! that cuts few references in large ones.

use super::bounds::Reference;
use super::judge::{Judge, PLANES, Planes};
use super::snap;
use super::split::{BLOCK, COST_BLOCK, COST_VISIT, Candidate, Cell, Plane, blocks, leaf_cost};

/// Above this many references, a sample is binned: what the planes are chosen by hardly changes.
const SAMPLE_ABOVE: usize = 4096;
/// One reference in this many is in the sample.
const SAMPLE_STRIDE: usize = 8;
/// Up to this many references, planes are moved to the exact edges of references.
const REFINE_UP_TO: usize = 256;
/// Above this many triangles, a split may cost up to `LARGE_LEAF_SLACK` leaves: below it, better ones may turn up.
const LARGE_LEAF: usize = 128;
const LARGE_LEAF_SLACK: f32 = 1.3;

/// The cheapest plane whose duplicates the cell can afford, if it is worth it.
///
/// The same numbers come out whatever planes are judged with.
#[inline(always)]
pub fn choose(judge: impl Judge, refs: &[Reference], cell: &Cell) -> Option<Plane> {
    let n = refs.len();
    let stride = if n > SAMPLE_ABOVE { SAMPLE_STRIDE } else { 1 };
    let rows = if n > SAMPLE_ABOVE { 2 } else { 1 };
    let looked_at = n.div_ceil(stride);
    let mut best: Option<Candidate> = None;
    for axis in 0..3 {
        let (lo, hi) = (cell.bounds.lo(axis), cell.bounds.hi(axis));
        let step = (hi - lo) / (rows * PLANES + 1) as f32;
        for row in 0..rows {
            let at = std::array::from_fn(|k| lo + step * (row * PLANES + k + 1) as f32);
            let planes = Planes { axis, at };
            best = judge.judge(refs, stride, &planes).cheapest(&planes, cell, looked_at, best);
        }
    }
    let mut best = best?;
    let axis = best.plane.axis;
    let step = (cell.bounds.hi(axis) - cell.bounds.lo(axis)) / (rows * PLANES + 1) as f32;
    if n <= REFINE_UP_TO {
        best = refine(judge, refs, cell, best, step);
    } else {
        best.plane = snap::to_an_edge(refs, cell, best.plane, step);
    }
    let slack = if cell.triangles > LARGE_LEAF { LARGE_LEAF_SLACK } else { 1.0 };
    (best.cost < leaf_cost(cell.triangles) * cell.bounds.half_area() * slack).then_some(best.plane)
}

/// Moves a plane to the best edge of a reference within a step of it.
#[inline(always)]
fn refine(judge: impl Judge, refs: &[Reference], cell: &Cell, coarse: Candidate, step: f32) -> Candidate {
    let axis = coarse.plane.axis;
    let (from, to) = (coarse.plane.at - step, coarse.plane.at + step);
    let mut edges = [0.0f32; 2 * REFINE_UP_TO + PLANES];
    let mut len = 0;
    for reference in refs.iter().take(REFINE_UP_TO) {
        for x in [reference.lo(axis), reference.hi(axis)] {
            // Written in any case, kept if it is in: nobody could foretell the branch.
            edges[len] = x;
            len += usize::from((from < x) & (x < to));
        }
    }
    edges[len..len + PLANES].fill(coarse.plane.at);
    let mut best = Some(coarse);
    for first in (0..len).step_by(PLANES) {
        let planes = Planes { axis, at: std::array::from_fn(|k| edges[first + k]) };
        best = judge.judge(refs, 1, &planes).cheapest(&planes, cell, refs.len(), best);
    }
    best.unwrap_or(coarse)
}

/// The tree's expected cost of a ray that meets the root, by the blocks that it tests: what the builders minimise, but for room in
/// blocks.
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
