//! Which cells of the binary tree become the children of one wide node: the cheapest choice for the whole tree.
//!
//! A node that is filled from the top down (the largest child opened first) leaves nodes with few children at the bottom, where most
//! of them are. Here the least cost of each cell's subtree is found from below, for each number of slots that it may take of the
//! node above (Ylitie, Karras & Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017; leaves are
//! given here). A node costs the area of its box, which is how often rays enter it, and a little for being there.

use super::super::built::{Built, BuiltKind};
use super::node::WIDTH;

/// What a node costs for being there, relative to the mean area of a cell: memory, and cache that it takes from others.
const PRESENCE: f32 = 0.1;

/// The costs of a cell's subtree where it may take up to 1, 2, … slots of the node above.
type Costs = [f32; WIDTH];

/// How the slots of each cell go to its sides.
pub struct Grouping {
    /// For each cell: how many go to its left side where it is a node of its own; and where it may take 2, 3, … slots of the node
    /// above, 0 if it takes one, as one child.
    to_left: Vec<[u8; WIDTH]>,
}

impl Grouping {
    /// The cheapest one.
    pub fn new(built: &Built) -> Self {
        let mut to_left = vec![[0; WIDTH]; built.cells.len()];
        let area: f64 = built.cells.iter().map(|cell| f64::from(cell.bounds.half_area())).sum();
        let presence = PRESENCE * (area / built.cells.len().max(1) as f64) as f32;
        // Cells come in depth-first order: from behind, the sides of a cell are the two that are still to be joined.
        let mut done: Vec<Costs> = Vec::new();
        for (cell, choice) in built.cells.iter().zip(&mut to_left).rev() {
            if let BuiltKind::Leaf { .. } = cell.kind {
                done.push([0.0; WIDTH]);
            } else if let (Some(left), Some(right)) = (done.pop(), done.pop()) {
                let (mut costs, lefts) = join(&left, &right);
                let alone = costs[WIDTH - 1] + cell.bounds.half_area() + presence;
                *choice = lefts;
                for slots in 2..=WIDTH {
                    let one = alone <= costs[slots - 1];
                    costs[slots - 1] = if one { alone } else { costs[slots - 1] };
                    choice[slots - 1] = if one { 0 } else { lefts[slots - 1] };
                }
                (costs[0], choice[0]) = (alone, lefts[WIDTH - 1]);
                done.push(costs);
            }
        }
        Self { to_left }
    }

    /// How many of a node's slots go to the left side of its cell.
    pub fn of_node(&self, cell: usize) -> usize {
        // Where areas overflow no cost is the least one.
        usize::from(self.to_left[cell][0]).max(1)
    }

    /// How many slots go to the left side of a cell that may take so many of the node above; 0 where it becomes one child.
    pub fn of_part(&self, cell: usize, slots: usize) -> usize {
        if slots < 2 { 0 } else { usize::from(self.to_left[cell][slots - 1]) }
    }
}

/// The least costs of two sides together, and how many slots go to the left one. There is none for a single slot.
fn join(left: &Costs, right: &Costs) -> (Costs, [u8; WIDTH]) {
    let (mut costs, mut lefts) = ([f32::INFINITY; WIDTH], [0u8; WIDTH]);
    for to_left in 1..WIDTH {
        for slots in to_left + 1..=WIDTH {
            let cost = left[to_left - 1] + right[slots - to_left - 1];
            let better = cost < costs[slots - 1];
            costs[slots - 1] = if better { cost } else { costs[slots - 1] };
            lefts[slots - 1] = if better { to_left as u8 } else { lefts[slots - 1] };
        }
    }
    (costs, lefts)
}

#[cfg(test)]
mod tests {
    use super::super::super::bounds::Bounds;
    use super::super::super::built::BuiltCell;
    use super::super::super::split::Plane;
    use super::*;

    /// A subtree of 2ⁿ leaves, each cell half as large as the one above.
    fn full(built: &mut Built, area: f32, levels: u32) {
        let at = built.cells.len();
        let bounds = Bounds::new([0.0; 3], [area, 1.0, 0.0]);
        built.cells.push(BuiltCell { bounds, kind: BuiltKind::Leaf { count: 1 } });
        if levels > 0 {
            full(built, 0.5 * area, levels - 1);
            let right = (built.cells.len() - at) as u32;
            full(built, 0.5 * area, levels - 1);
            built.cells[at].kind = BuiltKind::Split { plane: Plane { axis: 0, at: 0.5 }, right };
        }
    }

    #[test]
    fn nodes_at_the_bottom_are_full() {
        // Of 2^5 leaves, sixteen children each of two leaves would make seventeen nodes. The cheapest are three.
        let mut built = Built::default();
        full(&mut built, 32.0, 5);
        let grouping = Grouping::new(&built);
        let mut nodes = vec![0usize];
        let mut at = 0;
        while at < nodes.len() {
            let mut open = vec![(nodes[at], None)];
            while let Some((cell, slots)) = open.pop() {
                let BuiltKind::Split { right, .. } = built.cells[cell].kind else { continue };
                let to_left = slots.map_or(grouping.of_node(cell), |slots| grouping.of_part(cell, slots));
                if to_left == 0 {
                    nodes.push(cell);
                    continue;
                }
                let all = slots.unwrap_or(WIDTH);
                open.extend([(cell + 1, Some(to_left)), (cell + right as usize, Some(all - to_left))]);
            }
            at += 1;
        }
        assert_eq!(nodes.len(), 3, "{nodes:?}");
    }

    #[test]
    fn costs_of_two_sides_are_the_least_of_all_ways_to_share() {
        let left: Costs = std::array::from_fn(|i| 100.0 / (1 + i) as f32);
        let right: Costs = std::array::from_fn(|i| 70.0 / (1 + i * i) as f32);
        let (costs, lefts) = join(&left, &right);
        assert_eq!(costs[0], f32::INFINITY);
        for slots in 2..=WIDTH {
            let ways = (1..slots).map(|k| left[k - 1] + right[slots - k - 1]);
            assert_eq!(costs[slots - 1], ways.fold(f32::INFINITY, f32::min));
            let k = usize::from(lefts[slots - 1]);
            assert_eq!(costs[slots - 1], left[k - 1] + right[slots - k - 1]);
        }
    }
}
