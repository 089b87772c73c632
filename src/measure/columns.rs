//! Rays side by side, as a wavefront of paths has them.

use crate::math::Ray;
use crate::prepare::kdtree::{Coherence, HitBatch, KdTree, NO_TRIANGLE, RayBatch};
use std::ops::Range;

/// Rays of a batch.
const BATCH: usize = 1024;

/// Rays side by side.
pub struct Columns {
    origin: [Vec<f32>; 3],
    dir: [Vec<f32>; 3],
    t_max: Vec<f32>,
}

impl Columns {
    /// Turns rays into columns.
    pub fn new(rays: &[Ray]) -> Self {
        Self {
            origin: [0, 1, 2].map(|axis| rays.iter().map(|r| r.origin[axis]).collect()),
            dir: [0, 1, 2].map(|axis| rays.iter().map(|r| r.dir[axis]).collect()),
            t_max: rays.iter().map(|r| r.t_max).collect(),
        }
    }

    /// Traces some rays in batches: hits, and the sum of their distances, to each of which `before` is added (by the number
    /// within the range).
    pub fn trace(
        &self,
        tree: &KdTree,
        range: Range<usize>,
        before: impl Fn(usize) -> f32,
        any_hit: bool,
    ) -> (u64, f64) {
        let (mut t, mut b1, mut b2, mut triangle) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH], [0; BATCH]);
        let mut blocked = [false; BATCH];
        let (mut hits, mut sum) = (0, 0.0);
        for first in range.clone().step_by(BATCH) {
            let rows = first..(first + BATCH).min(range.end);
            let n = rows.len();
            let batch = RayBatch {
                origin: [0, 1, 2].map(|axis| &self.origin[axis][rows.clone()]),
                dir: [0, 1, 2].map(|axis| &self.dir[axis][rows.clone()]),
                t_max: &self.t_max[rows],
                reaches: &[],
                leaves: &[],
            };
            if any_hit {
                tree.occluded_batch(&batch, Coherence::Scattered, &mut blocked[..n]);
                hits += blocked[..n].iter().filter(|b| **b).count() as u64;
                continue;
            }
            let mut found =
                HitBatch { t: &mut t[..n], b1: &mut b1[..n], b2: &mut b2[..n], triangle: &mut triangle[..n] };
            tree.closest_batch(&batch, Coherence::Scattered, &mut found);
            for i in (0..n).filter(|&i| triangle[i] != NO_TRIANGLE) {
                hits += 1;
                sum += f64::from(t[i] + before(first - range.start + i));
            }
        }
        (hits, sum)
    }
}
