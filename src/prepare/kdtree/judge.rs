//! How sixteen planes of a cell divide its references: counts, and how far the sides reach.
//!
//! The lanes are planes, and each reference is held against all of them: no bins that wait for what was written to them a
//! moment ago, no branches. References are counted, by [`super::split::sides`]; triangles and what duplicates take are reckoned from that by what
//! a reference of the cell stands for in the mean (pairs stand for two).

use super::bounds::Reference;
use super::split::{COST_BLOCK, COST_VISIT, Candidate, Cell, Plane, full_blocks, sides};

/// Planes that are judged at once.
pub const PLANES: usize = 16;

/// Planes across one axis.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Where they lie on it.
    pub at: [f32; PLANES],
}

impl Planes {
    /// Of a reference's eight numbers, those that tell how far the sides reach: the upper end (left side) and the lower end (right
    /// side) on the axis, then both ends on the other two.
    #[inline(always)]
    pub fn numbers(axis: usize) -> ([usize; 2], [usize; 4]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        ([4 + axis, axis], [u, 4 + u, v, 4 + v])
    }
}

/// What lies on the sides of planes. Ends are the least over the side's references, upper ends negated, as in [`super::bounds::Bounds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// References that lie on the right alone.
    pub beyond: [u32; PLANES],
    /// References on the right, those that reach over included.
    pub right: [u32; PLANES],
    /// How far the left and the right side reach towards the plane.
    pub inner: [[f32; PLANES]; 2],
    /// Ends of the left side on the other axes.
    pub left_ends: [[f32; PLANES]; 4],
    /// Ends of the right side on the other axes.
    pub right_ends: [[f32; PLANES]; 4],
}

/// Instructions to judge planes with: all find the same.
pub trait Judge: Copy {
    /// Looks at one reference in `stride`.
    fn judge(self, refs: &[Reference], stride: usize, planes: &Planes) -> Judged;
}

/// Plain code.
#[derive(Clone, Copy, Debug)]
pub struct Plainly;

impl Judge for Plainly {
    fn judge(self, refs: &[Reference], stride: usize, planes: &Planes) -> Judged {
        let mut out = Judged::default();
        let (inner, outer) = Planes::numbers(planes.axis);
        let least = |least: &mut f32, x: f32| *least = if x < *least { x } else { *least };
        for reference in refs.iter().step_by(stride) {
            for (k, &at) in planes.at.iter().enumerate() {
                let (left, right) = sides(reference, Plane { axis: planes.axis, at });
                if left {
                    least(&mut out.inner[0][k], reference.0[inner[0]]);
                    outer.iter().zip(&mut out.left_ends).for_each(|(&end, ends)| least(&mut ends[k], reference.0[end]));
                } else {
                    out.beyond[k] += 1;
                }
                if right {
                    out.right[k] += 1;
                    least(&mut out.inner[1][k], reference.0[inner[1]]);
                    outer
                        .iter()
                        .zip(&mut out.right_ends)
                        .for_each(|(&end, ends)| least(&mut ends[k], reference.0[end]));
                }
            }
        }
        out
    }
}

impl Default for Judged {
    /// Of no references.
    fn default() -> Self {
        let (none, far) = ([0; PLANES], [f32::INFINITY; PLANES]);
        Self { beyond: none, right: none, inner: [far; 2], left_ends: [far; 4], right_ends: [far; 4] }
    }
}

impl Judged {
    /// The cheapest of the planes that divide the cell and whose duplicates it can afford, if it is cheaper than `best`. So many
    /// of the cell's references were looked at.
    #[inline(always)]
    pub fn cheapest(
        &self,
        planes: &Planes,
        cell: &Cell,
        looked_at: usize,
        best: Option<Candidate>,
    ) -> Option<Candidate> {
        let (lo, hi) = (cell.bounds.lo(planes.axis), cell.bounds.hi(planes.axis));
        let visit = COST_VISIT * cell.bounds.half_area();
        // Triangles that a reference stands for.
        let weight = cell.triangles as f32 / looked_at as f32;
        let budget = cell.budget as f32;
        let looked_at = looked_at as i32;
        let mut costs = [f32::INFINITY; PLANES];
        for (k, cost) in costs.iter_mut().enumerate() {
            let at = planes.at[k];
            let (left, right) = (looked_at - self.beyond[k] as i32, self.right[k] as i32);
            let both = (left + right - looked_at) as f32 * weight;
            let area = |along: f32, ends: &[[f32; PLANES]; 4]| {
                let (u, v) = (-ends[1][k] - ends[0][k], -ends[3][k] - ends[2][k]);
                along * (u + v) + u * v
            };
            let up_to = -self.inner[0][k];
            let from = self.inner[1][k];
            let left_area = area((if up_to < at { up_to } else { at }) - lo, &self.left_ends);
            let right_area = area(hi - (if from > at { from } else { at }), &self.right_ends);
            let sum = left_area * full_blocks(left as f32 * weight) + right_area * full_blocks(right as f32 * weight);
            let divides = (left > 0) & (right > 0) & (lo < at) & (at < hi) & (both <= budget);
            *cost = if divides { visit + COST_BLOCK * sum } else { f32::INFINITY };
        }
        let mut best = best;
        for (&cost, &at) in costs.iter().zip(&planes.at) {
            if cost < best.map_or(f32::INFINITY, |best| best.cost) {
                best = Some(Candidate { plane: Plane { axis: planes.axis, at }, cost });
            }
        }
        best
    }
}
