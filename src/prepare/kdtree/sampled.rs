//! The semi-randomised builder: planes at the edges of randomly drawn references, judged on a random sample.
//!
//! Each cell draws [`PLANES`] planes and [`JUDGES`] references; the plane that the surface area heuristic likes best on
//! those few wins. The work per level is independent of the number of references but for the partition itself. The draws
//! are hashed from the seed and the cell's place in the tree, so that the tree is the same on any number of threads.

use super::bounds::Reference;
use super::split::{Cell, Plane, count_sides, mix, split_cost};

/// Planes drawn for a cell.
const PLANES: u64 = 24;
/// References that judge them.
const JUDGES: usize = 128;

/// The best of the drawn planes.
pub fn choose(refs: &[Reference], cell: &Cell, seed: u64) -> Option<Plane> {
    let mut draws = (0u64..).map(|k| mix(mix(seed ^ cell.path).wrapping_add(k.wrapping_mul(0x9e37_79b9_7f4a_7c15))));
    let mut draw = |n: usize| (draws.next().unwrap_or(0) % n as u64) as usize;
    let judges: Vec<Reference> =
        if refs.len() <= JUDGES { refs.to_vec() } else { (0..JUDGES).map(|_| refs[draw(refs.len())]).collect() };
    let weight = refs.len() as f32 / judges.len() as f32;
    let mut best: Option<(f32, Plane)> = None;
    for _ in 0..PLANES {
        let reference = &refs[draw(refs.len())];
        let axis = draw(3);
        let at = if draw(2) == 0 { reference.lo(axis) } else { reference.hi(axis) };
        let (lo, hi) = (cell.bounds.lo(axis), cell.bounds.hi(axis));
        if !(lo < at && at < hi) {
            continue;
        }
        let plane = Plane { axis, at };
        let (left, right, both) = count_sides(&judges, plane);
        if (both as f32 * weight) as usize > cell.budget {
            continue;
        }
        let (mut below, mut above) = (cell.bounds, cell.bounds);
        below.set_hi(axis, at);
        above.set_lo(axis, at);
        let scaled = |n: usize| (n as f32 * weight) as usize;
        let area = cell.bounds.half_area();
        let cost = split_cost(area, (below.half_area(), scaled(left)), (above.half_area(), scaled(right)));
        if best.is_none_or(|(cheapest, _)| cost < cheapest) {
            best = Some((cost, plane));
        }
    }
    best.map(|(_, plane)| plane)
}
