//! The binary tree as it comes out of a builder.

use super::bounds::Bounds;
use super::sah;
use super::split::{Cell, Plane};

/// A cell of the built tree. Cells come in depth-first order: the left child follows its parent.
#[derive(Clone, Copy, Debug)]
pub struct BuiltCell {
    /// The box around what the cell sees of its triangles, widened by their thickness.
    pub bounds: Bounds,
    /// What the cell is.
    pub kind: BuiltKind,
}

/// What a cell of the built tree is.
#[derive(Clone, Copy, Debug)]
pub enum BuiltKind {
    /// Split by a plane.
    Split {
        /// The plane.
        plane: Plane,
        /// Distance from this cell to its right child in the order of cells.
        right: u32,
    },
    /// Not split.
    Leaf {
        /// Its references are the next so many of the list.
        count: u32,
    },
}

/// The binary tree as it comes out of a builder.
#[derive(Clone, Debug, Default)]
pub struct Built {
    /// Cells, depth first. Empty when there are no triangles.
    pub cells: Vec<BuiltCell>,
    /// The triangles of all leaves, in the order of the leaves.
    pub triangles: Vec<u32>,
    /// The largest thickness of a triangle.
    pub thickness: f32,
}

impl Built {
    /// Begins a split cell; its left side is to follow.
    pub fn begin_split(&mut self, cell: &Cell, plane: Plane) -> usize {
        self.cells.push(BuiltCell { bounds: cell.bounds, kind: BuiltKind::Split { plane, right: 0 } });
        self.cells.len() - 1
    }

    /// Says of a split cell that its right side is to follow.
    pub fn begin_right(&mut self, split: usize) {
        let distance = (self.cells.len() - split) as u32;
        if let Some(BuiltKind::Split { right, .. }) = self.cells.get_mut(split).map(|cell| &mut cell.kind) {
            *right = distance;
        }
    }

    /// Makes the box of each split cell that around its sides' boxes, which are widened at the leaves.
    pub fn widen(&mut self) {
        for at in (0..self.cells.len()).rev() {
            if let BuiltKind::Split { right, .. } = self.cells[at].kind {
                self.cells[at].bounds =
                    Bounds::around([&self.cells[at + 1].bounds, &self.cells[at + right as usize].bounds]);
            }
        }
    }

    /// For each cell that is a leaf, its number among the leaves.
    pub fn leaf_numbers(&self) -> Vec<u32> {
        let number = |next: &mut u32, cell: &BuiltCell| {
            let mine = *next;
            *next += u32::from(matches!(cell.kind, BuiltKind::Leaf { .. }));
            Some(mine)
        };
        self.cells.iter().scan(0, number).collect()
    }

    /// Planes above the deepest leaf.
    pub fn depth(&self) -> u32 {
        // Depth first, a leaf ends the most recent left side whose right one is still to come.
        let mut open: Vec<u32> = vec![0];
        let mut deepest = 0;
        for cell in &self.cells {
            let depth = open.pop().unwrap_or(0);
            deepest = deepest.max(depth);
            if matches!(cell.kind, BuiltKind::Split { .. }) {
                open.extend([depth + 1, depth + 1]);
            }
        }
        deepest
    }

    /// The expected cost of a ray that meets the root.
    pub fn cost(&self) -> f64 {
        let root_area = self.cells.first().map_or(0.0, |root| root.bounds.half_area());
        let cells = self.cells.iter().map(|cell| match cell.kind {
            BuiltKind::Split { .. } => (cell.bounds.half_area(), None),
            BuiltKind::Leaf { count } => (cell.bounds.half_area(), Some(count as usize)),
        });
        sah::tree_cost(root_area, cells)
    }
}
