//! Checks of the binary tree, by means of its own.

use super::binary::{Tree, View};
use super::bounds::Bounds;
use super::leaves::Leaf;
use super::split::MAX_DEPTH;
use super::{Triangles, clip};
use std::collections::BTreeMap;

/// A cell still to be looked at: its node, its box by the planes above, and the triangles that touch it.
struct Task {
    node: usize,
    cell: Bounds,
    touching: Vec<u32>,
    depth: u32,
}

/// The boxes of leaves in the wide nodes, by the leaves' places.
pub type LeafBoxes = BTreeMap<u32, Bounds>;

/// Walks the binary tree with the triangles that touch each cell.
///
/// Cells are disjoint and cover the root if each plane lies within its cell, and each node but the root has one parent.
pub fn check<T: Triangles>(tree: Tree, boxes: &LeafBoxes, triangles: &T) -> Result<(), String> {
    let n = triangles.len();
    if tree.nodes.is_empty() {
        return if n == 0 { Ok(()) } else { Err(format!("no node for {n} triangles")) };
    }
    let corners = |t: u32| triangles.vertices(t).map(|v| v.to_array());
    let all: Vec<u32> = (0..n as u32).collect();
    if let Some(t) = all.iter().find(|&&t| !tree.bounds.contains(&clip::whole(&corners(t)))) {
        return Err(format!("triangle {t} leaves the root's box"));
    }
    let mut referenced = vec![false; n];
    let mut visited = vec![false; tree.nodes.len()];
    let mut tasks = vec![Task { node: 0, cell: *tree.bounds, touching: all, depth: 0 }];
    while let Some(Task { node, cell, touching, depth }) = tasks.pop() {
        let seen = visited.get_mut(node).ok_or_else(|| format!("node {node} does not exist"))?;
        if std::mem::replace(seen, true) {
            return Err(format!("node {node} has two parents"));
        }
        if depth > MAX_DEPTH {
            return Err(format!("node {node} lies {depth} deep"));
        }
        match tree.nodes[node].view() {
            View::Split(plane, right) => {
                if !(cell.lo(plane.axis) <= plane.at && plane.at <= cell.hi(plane.axis)) {
                    return Err(format!("node {node}: plane {plane:?} lies outside its cell"));
                }
                let (mut below, mut above) = (cell, cell);
                below.set_hi(plane.axis, plane.at);
                above.set_lo(plane.axis, plane.at);
                let touched = |part: &Bounds| -> Vec<u32> {
                    touching.iter().copied().filter(|&t| clip::clipped(&corners(t), part).is_some()).collect()
                };
                let (left, right_touching) = (touched(&below), touched(&above));
                tasks.push(Task { node: node + 1, cell: below, touching: left, depth: depth + 1 });
                tasks.push(Task { node: right, cell: above, touching: right_touching, depth: depth + 1 });
            }
            View::Leaf(leaf) => {
                self::leaf(tree, leaf, &cell, &touching, triangles, boxes.get(&leaf.first), &mut referenced)
                    .map_err(|e| format!("node {node}: {e}"))?
            }
        }
    }
    if let Some(lost) = referenced.iter().position(|&r| !r) {
        return Err(format!("no leaf refers to triangle {lost}"));
    }
    match visited.iter().position(|&v| !v) {
        Some(orphan) => Err(format!("node {orphan} has no parent")),
        None => Ok(()),
    }
}

fn leaf<T: Triangles>(
    tree: Tree,
    leaf: Leaf,
    cell: &Bounds,
    touching: &[u32],
    triangles: &T,
    wide: Option<&Bounds>,
    referenced: &mut [bool],
) -> Result<(), String> {
    let mut held = Vec::new();
    for block in tree.leaves.blocks(leaf) {
        for i in 0..block.len {
            let t = block.triangle(i);
            if t as usize >= triangles.len() {
                return Err(format!("reference to triangle {t} that does not exist"));
            }
            if block.corners(i) != triangles.vertices(t).map(|v| v.to_array()) {
                return Err(format!("the corners of triangle {t} are not its own"));
            }
            let outside = |p: &[f64; 3]| {
                let thick = f64::from(clip::thickness(&block.corners(i))) * 0.99;
                let short =
                    |b: &Bounds, a: usize| p[a] - thick < f64::from(b.lo(a)) || p[a] + thick > f64::from(b.hi(a));
                let beyond = |b: &Bounds| (0..3).any(|a| short(b, a));
                wide.is_none_or(beyond)
            };
            if clip::part(&block.corners(i), cell).iter().any(outside) {
                return Err(format!("triangle {t} leaves the box of its leaf"));
            }
            referenced[t as usize] = true;
            held.push(t);
        }
    }
    held.sort_unstable();
    if held.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err("a triangle twice in a leaf".into());
    }
    let missing = |t: &&u32| {
        // What lies along the border within the triangle's thickness is the neighbour's business.
        let corners = triangles.vertices(**t).map(|v| v.to_array());
        let thick = clip::thickness(&corners);
        let inner = |part: Bounds| (0..3).all(|a| part.hi(a) > cell.lo(a) + thick && part.lo(a) < cell.hi(a) - thick);
        held.binary_search(t).is_err() && clip::clipped(&corners, cell).is_some_and(inner)
    };
    match touching.iter().find(missing) {
        Some(t) => Err(format!("triangle {t} touches the cell but is not in it")),
        None => Ok(()),
    }
}
