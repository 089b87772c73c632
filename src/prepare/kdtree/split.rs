//! What builders have in common: a node to be split, a plane, and the cost model.

use super::bounds::{Bounds, Reference};

/// References that one leaf block holds; the kernels test a block at once.
pub const BLOCK: usize = 16;
/// Cost of visiting a node. The unit is arbitrary; the ratios are measured.
pub const COST_VISIT: f32 = 0.1;
/// Cost of testing a full leaf block.
pub const COST_BLOCK: f32 = 1.2;
/// The share of it that a block has however few references it holds. The rest is memory, and cache that is taken from others.
const FIXED_SHARE: f32 = 0.4;
/// No cell lies deeper than this, so that stacks have a fixed size.
pub const MAX_DEPTH: u32 = 60;

/// A cell that may be split.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// The box around its references.
    pub bounds: Bounds,
    /// The triangles in it: of its references, pairs count twice.
    pub triangles: usize,
    /// Planes above it.
    pub depth: u32,
    /// References to triangles that planes below may still add by cutting them.
    pub budget: usize,
    /// Names the way from the root: what random numbers are addressed by.
    pub path: u64,
}

/// An axis-aligned plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Its coordinate on that axis.
    pub at: f32,
}

/// How many triangles a plane puts where, and what that costs.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// The plane.
    pub plane: Plane,
    /// Expected cost of the split, relative to the cell's area.
    pub cost: f32,
}

/// Blocks that `n` references fill.
#[inline(always)]
pub fn blocks(n: usize) -> f32 {
    n.div_ceil(BLOCK) as f32
}

/// Full blocks that cost as much as those that so many references fill: less where the last one has room.
#[inline(always)]
pub fn full_blocks(references: f32) -> f32 {
    let filled = references / BLOCK as f32;
    FIXED_SHARE * filled.ceil() + (1.0 - FIXED_SHARE) * filled
}

/// Cost of a leaf.
pub fn leaf_cost(n: usize) -> f32 {
    COST_BLOCK * full_blocks(n as f32)
}

/// Cost of a split by the surface area heuristic (Goldsmith & Salmon 1987; MacDonald & Booth 1990), times the cell's area.
#[inline(always)]
pub fn split_cost(area: f32, left: (f32, usize), right: (f32, usize)) -> f32 {
    COST_VISIT * area + COST_BLOCK * (left.0 * blocks(left.1) + right.0 * blocks(right.1))
}

/// Where a reference lies: left, right, or both.
#[inline(always)]
pub fn sides(reference: &Reference, plane: Plane) -> (bool, bool) {
    let right = reference.hi(plane.axis) > plane.at;
    ((reference.lo(plane.axis) < plane.at) | !right, right)
}

/// Triangles on the left, on the right, and on both sides.
pub fn count_sides(refs: &[Reference], plane: Plane) -> (usize, usize, usize) {
    let (mut left, mut right, mut all) = (0, 0, 0);
    for reference in refs {
        let (l, r) = sides(reference, plane);
        let weight = reference.weight() as usize;
        left += usize::from(l) * weight;
        right += usize::from(r) * weight;
        all += weight;
    }
    (left, right, left + right - all)
}

/// A 64-bit hash (the finaliser of MurmurHash3, Stafford's variant 13).
pub fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
