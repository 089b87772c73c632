//! The tree over instances: their boxes, which may overlap, collapsed to the same wide nodes as cells are.

use super::super::bounds::Bounds;
use super::super::built::{Built, BuiltKind};
use super::super::leaves::Leaf;
use super::super::split::{Cell, MAX_DEPTH, Plane};
use super::super::wide::collapse::{Places, collapse};
use super::super::wide::grouping::Grouping;
use super::super::wide::node::WideNode;

/// Below this depth, halves are equally large, so that the tree ends.
const BALANCED_BELOW: u32 = MAX_DEPTH / 2;

/// Leaves in the order of the binary tree, each of which is one instance.
struct Numbered<'a>(&'a [u32]);

impl Places for Numbered<'_> {
    fn base(&self) -> u32 {
        0
    }

    fn place(&mut self, number: u32, _: u32) -> Leaf {
        // As a leaf of many references, whose place has the most bits.
        Leaf { first: self.0[number as usize], count: u32::MAX, pool: 0 }
    }
}

/// Wide nodes over boxes; their leaves are numbers of boxes.
pub fn build(boxes: &[Bounds]) -> Vec<WideNode> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut built = Built::default();
    if !boxes.is_empty() {
        divide(boxes, &mut order, 0, &mut built);
        built.widen();
    }
    collapse(&built, &Grouping::new(&built), &mut Numbered(&order))
}

fn centre(bounds: &Bounds, axis: usize) -> f32 {
    0.5 * bounds.lo(axis) + 0.5 * bounds.hi(axis)
}

/// Divides boxes in two where the surface area heuristic says, down to single ones.
fn divide(boxes: &[Bounds], order: &mut [u32], depth: u32, built: &mut Built) {
    let bounds = Bounds::around(order.iter().map(|k| &boxes[*k as usize]));
    if order.len() == 1 {
        built.cells.push(super::super::built::BuiltCell { bounds, kind: BuiltKind::Leaf { count: 1 } });
        built.triangles.push(order[0]);
        return;
    }
    let mut best = (f32::INFINITY, 0, order.len() / 2);
    for axis in 0..3 {
        sort(boxes, order, axis);
        let at = if depth < BALANCED_BELOW { cheapest(boxes, order) } else { (0.0, order.len() / 2) };
        if at.0 < best.0 {
            best = (at.0, axis, at.1);
        }
    }
    let (_, axis, at) = best;
    sort(boxes, order, axis);
    let plane = Plane { axis, at: centre(&boxes[order[at] as usize], axis) };
    let split = built.begin_split(&Cell { bounds, triangles: 0, depth, budget: 0, path: 1 }, plane);
    let (left, right) = order.split_at_mut(at);
    divide(boxes, left, depth + 1, built);
    built.begin_right(split);
    divide(boxes, right, depth + 1, built);
}

/// By centres, and by numbers where these are the same.
fn sort(boxes: &[Bounds], order: &mut [u32], axis: usize) {
    let key = |k: &u32| (centre(&boxes[*k as usize], axis), *k);
    order.sort_unstable_by(|a, b| {
        let ((a, i), (b, k)) = (key(a), key(b));
        a.total_cmp(&b).then(i.cmp(&k))
    });
}

/// Where a row of boxes is divided best, and what that costs.
fn cheapest(boxes: &[Bounds], order: &[u32]) -> (f32, usize) {
    let mut bounds = Bounds::EMPTY;
    let mut right: Vec<f32> = order
        .iter()
        .rev()
        .map(|k| {
            bounds.merge(&boxes[*k as usize]);
            bounds.half_area()
        })
        .collect();
    right.reverse();
    let mut bounds = Bounds::EMPTY;
    let mut best = (f32::INFINITY, order.len() / 2);
    for (at, k) in order.iter().enumerate().take(order.len() - 1) {
        bounds.merge(&boxes[*k as usize]);
        let cost = bounds.half_area() * (at + 1) as f32 + right[at + 1] * (order.len() - at - 1) as f32;
        if cost < best.0 {
            best = (cost, at + 1);
        }
    }
    best
}
