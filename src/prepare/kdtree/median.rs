//! The plainest builder: halves the references along the longest axis.

use super::bounds::Reference;
use super::split::{Cell, Plane};

/// The plane at the median of the references' centres on the cell's longest axis, or in the middle of the cell where
/// that plane would lie on the cell's border.
pub fn choose(refs: &[Reference], cell: &Cell) -> Option<Plane> {
    let axis = cell.bounds.longest_axis();
    let (lo, hi) = (cell.bounds.lo(axis), cell.bounds.hi(axis));
    let mut centres: Vec<f32> = refs.iter().map(|r| 0.5 * r.lo(axis) + 0.5 * r.hi(axis)).collect();
    let middle = centres.len() / 2;
    let (_, median, _) = centres.select_nth_unstable_by(middle, f32::total_cmp);
    let inside = |x: f32| lo < x && x < hi;
    [*median, 0.5 * lo + 0.5 * hi].into_iter().find(|&at| inside(at)).map(|at| Plane { axis, at })
}
