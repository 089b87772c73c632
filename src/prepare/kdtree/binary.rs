//! The binary kd-tree and its traversal by planes, in plain code: the definition of what the tree finds.

use super::bounds::Bounds;
use super::built::{Built, BuiltKind};
use super::instances::place::{AsIs, Place};
use super::leaves::{Leaf, LeafStore};
use super::slab::SlabRay;
use super::split::{MAX_DEPTH, Plane};
use super::wide::scalar::Scalar;
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};

/// What a node is, in the two lowest bits of its word: an axis, or this.
const LEAF: u32 = 3;

/// Eight bytes. A split keeps its plane, its axis and the place of its right child; the left one follows it. A leaf keeps
/// where its references lie, how many they are, and the size of their pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    plane_or_count: u32,
    word: u32,
}

/// What a node says.
#[derive(Clone, Copy, Debug)]
pub enum View {
    /// A plane, and the right child.
    Split(Plane, usize),
    /// A leaf.
    Leaf(Leaf),
}

impl Node {
    /// Reads a node.
    #[inline(always)]
    pub fn view(&self) -> View {
        let (axis, rest) = (self.word & 3, self.word >> 2);
        if axis == LEAF {
            View::Leaf(Leaf { first: rest, count: self.plane_or_count >> 6, pool: self.plane_or_count & 63 })
        } else {
            View::Split(Plane { axis: axis as usize, at: f32::from_bits(self.plane_or_count) }, rest as usize)
        }
    }
}

/// Compiles the built cells to nodes; `leaves` are the leaves in their order.
pub fn compile(built: &Built, leaves: &[Leaf]) -> Vec<Node> {
    let mut leaves = leaves.iter();
    let node = |(i, cell): (usize, &super::built::BuiltCell)| match cell.kind {
        BuiltKind::Split { plane, right } => {
            Node { plane_or_count: plane.at.to_bits(), word: (i as u32 + right) << 2 | plane.axis as u32 }
        }
        BuiltKind::Leaf { .. } => {
            let leaf = leaves.next().copied().unwrap_or(Leaf { first: 0, count: 0, pool: 0 });
            Node { plane_or_count: leaf.count << 6 | leaf.pool, word: leaf.first << 2 | LEAF }
        }
    };
    built.cells.iter().enumerate().map(node).collect()
}

/// What is to be traversed.
#[derive(Clone, Copy, Debug)]
pub struct Tree<'a> {
    /// Nodes, the root first.
    pub nodes: &'a [Node],
    /// The box around everything.
    pub bounds: &'a Bounds,
    /// How far from a triangle, and so from the cells that hold it, its hits may lie.
    pub thickness: f32,
    /// The leaves' triangles.
    pub leaves: &'a LeafStore,
}

/// The nearest accepted hit, or with `any` whichever accepted hit is found first.
pub fn nearest(tree: Tree, ray: &Ray, any: bool, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
    let mut nearest = Nearest::new(ray);
    walk(tree, &ShearedRay::new(ray), &SlabRay::new(ray), &mut nearest, any, &mut AsIs, accept);
    nearest.hit
}

/// Improves the nearest hit by what the tree holds. `slab` is the ray in the coordinates of the tree, `sheared` in those of
/// the triangles as `place` gives them. With `any`, whether an accepted hit was found.
///
/// Cells come in the order in which the ray passes them. A cell is left out when the ray passes it by, or enters it
/// beyond the nearest hit; one that is entered *at* the nearest hit may hold a triangle of lower number.
pub fn walk(
    tree: Tree,
    sheared: &ShearedRay,
    slab: &SlabRay,
    nearest: &mut Nearest,
    any: bool,
    place: &mut impl Place,
    mut accept: impl FnMut(&Hit) -> bool,
) -> bool {
    let mut limit = slab.scaled(nearest.t);
    let (enter, leave) = slab.interval(tree.bounds);
    let mut stack = [(0usize, 0.0f32, 0.0f32); MAX_DEPTH as usize + 2];
    stack[0] = (0, enter, leave);
    let mut waiting = usize::from(!tree.nodes.is_empty());
    while waiting > 0 {
        waiting -= 1;
        let (mut at, mut enter, mut leave) = stack[waiting];
        // Walk down to a leaf, leaving the farther cells on the stack.
        while enter <= leave && enter <= limit {
            match tree.nodes[at].view() {
                View::Split(plane, right) => {
                    let (near, far) = if slab.is_negative(plane.axis) { (right, at + 1) } else { (at + 1, right) };
                    let margin = if slab.is_negative(plane.axis) { tree.thickness } else { -tree.thickness };
                    let far_enter = slab.enter(plane.axis, plane.at + margin).max(enter);
                    let near_leave = slab.leave(plane.axis, plane.at - margin).min(leave);
                    if enter > near_leave {
                        (at, enter) = (far, far_enter);
                        continue;
                    }
                    if far_enter <= leave {
                        stack[waiting] = (far, far_enter, leave);
                        waiting += 1;
                    }
                    (at, leave) = (near, near_leave);
                }
                View::Leaf(leaf) => {
                    for block in tree.leaves.blocks(leaf) {
                        let len = block.len;
                        let block = place.place(Scalar, block);
                        for i in 0..len {
                            let Some(hit) = sheared.meet_along(block.corners_along(i, sheared.axes), block.triangle(i))
                            else {
                                continue;
                            };
                            if nearest.improves(&hit) && accept(&hit) {
                                nearest.take(hit);
                                limit = slab.scaled(hit.t);
                                if any {
                                    return true;
                                }
                            }
                        }
                    }
                    break;
                }
            }
        }
    }
    false
}
