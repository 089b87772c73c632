//! Checks wide nodes against the binary tree that they were made from.

use super::super::binary;
use super::super::leaves::Leaf;
use super::super::validate::LeafBoxes;
use super::WideTree;
use super::node::{Child, WIDTH};
use std::collections::BTreeSet;

/// Whether the wide nodes form one tree over exactly the leaves of the binary tree, each child's box inside its parent's.
///
/// Gives the boxes of the leaves; whether they hold what the cells hold of the triangles, `kdtree::validate` looks at.
pub fn check(tree: WideTree, binary: binary::Tree) -> Result<LeafBoxes, String> {
    let expected: BTreeSet<Leaf> = binary
        .nodes
        .iter()
        .filter_map(|node| match node.view() {
            binary::View::Leaf(leaf) if leaf.count > 0 => Some(leaf),
            _ => None,
        })
        .collect();
    let mut found = BTreeSet::new();
    let mut boxes = LeafBoxes::new();
    let mut parents = vec![0u32; tree.nodes.len()];
    for (at, node) in tree.nodes.iter().enumerate() {
        for order in node.orders {
            let slots: BTreeSet<u64> = (0..WIDTH).map(|i| (order >> (4 * i)) & 15).collect();
            if slots.len() != WIDTH {
                return Err(format!("wide node {at}: {order:x} is no order"));
            }
        }
        for slot in 0..node.count as usize {
            if node.bounds(slot).is_empty() {
                continue;
            }
            let leaf = match Child::decode(node.children[slot], node.leaf_base, |first| tree.leaves.large(first)) {
                Child::Node(child) => {
                    let below = tree.nodes.get(child as usize).ok_or("a wide child does not exist")?;
                    parents[child as usize] += 1;
                    let outside = |s: &usize| {
                        let part = below.bounds(*s);
                        !part.is_empty() && !node.bounds(slot).contains(&part)
                    };
                    if let Some(s) = (0..below.count as usize).find(outside) {
                        return Err(format!("wide node {child}: slot {s} leaves its parent's box"));
                    }
                    continue;
                }
                Child::Leaf(leaf) => leaf,
            };
            boxes.insert(leaf.first, node.bounds(slot));
            if !found.insert(leaf) {
                return Err(format!("leaf {leaf:?} is in two wide nodes"));
            }
        }
    }
    if found != expected {
        return Err("the leaves of the wide nodes are not those of the binary tree".into());
    }
    match parents.iter().skip(1).position(|&n| n != 1) {
        Some(i) => Err(format!("wide node {} has not one parent", i + 1)),
        None => Ok(boxes),
    }
}
