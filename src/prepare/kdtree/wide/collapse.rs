//! From the binary tree to wide nodes.

use super::super::aligned::settle;
use super::super::built::{Built, BuiltKind};
use super::super::leaves::Leaf;
use super::grouping::Grouping;
use super::node::{Child, WIDTH, WideNode};

/// Says where the leaves of the binary tree are to lie.
pub trait Places {
    /// From where the places of a node's leaves count, if they are dealt out next.
    fn base(&self) -> u32;

    /// A place for a leaf of a number and so many references.
    fn place(&mut self, number: u32, count: u32) -> Leaf;
}

/// A part of a treelet: a plane with its two sides, a child that stays, or nothing.
#[derive(Clone, Copy)]
enum Part {
    Split { axis: usize, left: usize, right: usize },
    Child { cell: usize },
}

/// The cells under one binary cell that become one wide node.
struct Treelet {
    parts: [Part; 2 * WIDTH],
    len: usize,
}

impl Treelet {
    /// The cells that are grouped under one.
    fn grow(built: &Built, grouping: &Grouping, cell: usize) -> Self {
        let mut treelet = Self { parts: [Part::Child { cell }; 2 * WIDTH], len: 1 };
        // Of each part: the slots that it may take.
        let mut slots = [WIDTH; 2 * WIDTH];
        let mut at = 0;
        while at < treelet.len {
            if let Part::Child { cell } = treelet.parts[at]
                && let BuiltKind::Split { plane, right } = built.cells[cell].kind
            {
                let to_left = if at == 0 { grouping.of_node(cell) } else { grouping.of_part(cell, slots[at]) };
                if to_left > 0 {
                    let (left, right_part) = (treelet.len, treelet.len + 1);
                    treelet.parts[left] = Part::Child { cell: cell + 1 };
                    treelet.parts[right_part] = Part::Child { cell: cell + right as usize };
                    (slots[left], slots[right_part]) = (to_left, slots[at] - to_left);
                    treelet.parts[at] = Part::Split { axis: plane.axis, left, right: right_part };
                    treelet.len += 2;
                }
            }
            at += 1;
        }
        treelet
    }

    /// The children in the order in which rays of an octant pass them.
    fn walk(&self, octant: usize, mut visit: impl FnMut(usize)) {
        let mut stack = [0usize; WIDTH + 1];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let at = stack[waiting];
            match self.parts[at] {
                Part::Child { .. } => visit(at),
                Part::Split { axis, left, right } => {
                    let negative = (octant >> axis) & 1 == 1;
                    let (near, far) = if negative { (right, left) } else { (left, right) };
                    stack[waiting] = far;
                    stack[waiting + 1] = near;
                    waiting += 2;
                }
            }
        }
    }
}

/// Collapses a binary tree to wide nodes, the root first; none when there are no triangles. The leaves of a node get places next
/// to each other.
pub fn collapse(built: &Built, grouping: &Grouping, places: &mut impl Places) -> Vec<WideNode> {
    let leaf_numbers = built.leaf_numbers();
    let mut nodes = Vec::new();
    let (mut small, mut large) = (Vec::new(), Vec::new());
    // Nodes to be made: place among the nodes, and the binary cell.
    let mut tasks = Vec::new();
    if !built.cells.is_empty() {
        nodes.push(WideNode::empty());
        tasks.push((0usize, 0usize));
    }
    while let Some((place, cell)) = tasks.pop() {
        let treelet = Treelet::grow(built, grouping, cell);
        let mut node = WideNode::empty();
        node.leaf_base = places.base();
        let mut slot_of_part = [0usize; 2 * WIDTH];
        // Slots are dealt in the order of the first octant.
        let first_task = tasks.len();
        treelet.walk(0, |part| {
            let Part::Child { cell } = treelet.parts[part] else { return };
            let slot = node.count as usize;
            slot_of_part[part] = slot;
            node.count += 1;
            let empty = matches!(built.cells[cell].kind, BuiltKind::Leaf { count: 0 });
            if !empty {
                node.set_bounds(slot, &built.cells[cell].bounds);
            }
            match built.cells[cell].kind {
                BuiltKind::Split { .. } => {
                    nodes.push(WideNode::empty());
                    tasks.push((nodes.len() - 1, cell));
                    node.children[slot] = Child::Node(nodes.len() as u32 - 1).encode(node.leaf_base);
                }
                BuiltKind::Leaf { count } if count as usize <= WIDTH => small.push((slot, cell, count)),
                BuiltKind::Leaf { count } => large.push((slot, cell, count)),
            }
        });
        // Small leaves first: their words have few bits for the place.
        for (slot, cell, count) in small.drain(..).chain(large.drain(..)) {
            let leaf = places.place(leaf_numbers[cell], count);
            node.children[slot] = Child::Leaf(leaf).encode(node.leaf_base);
        }
        tasks[first_task..].reverse();
        for octant in 0..4 {
            let mut place = 0;
            treelet.walk(octant, |part| {
                node.orders[octant] |= (slot_of_part[part] as u64) << (4 * place);
                place += 1;
            });
            // The free slots last, so that the order is a permutation.
            for slot in node.count as usize..WIDTH {
                node.orders[octant] |= (slot as u64) << (4 * slot);
            }
        }
        nodes[place] = node;
    }
    settle(&nodes)
}
