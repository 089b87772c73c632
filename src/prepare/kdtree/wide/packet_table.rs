//! The lines of all blocks of a small tree, made once: packets that go here and there need them again and again.

use super::super::leaves::{GRAIN, Leaf};
use super::WideTree;
use super::node::Child;
use super::packet_lines::{Lines, Midst};
use crate::lanes::{Lanes, Work};

/// Blocks up to which a tree has a table: about a megabyte, and trees of some thousand triangles.
const MOST_BLOCKS: usize = 512;
/// More grains are those of a larger tree for certain.
const MOST_GRAINS: usize = 32 * MOST_BLOCKS;

/// Lines of all blocks.
#[derive(Debug)]
pub struct LinesTable {
    lines: Vec<Lines>,
    /// The place of a leaf's first block in `lines`, by its grain.
    first: Vec<u16>,
}

/// Makes a table of a tree; `None` for a large one.
pub struct MakeTable<'a>(pub WideTree<'a>);

impl Work for MakeTable<'_> {
    type Output = Option<LinesTable>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let tree = self.0;
        // Every leaf begins at a grain of its own.
        let grains = tree.leaves.words().len() / GRAIN + 1;
        if grains > MOST_GRAINS {
            return None;
        }
        let mut table = LinesTable { lines: Vec::new(), first: vec![0; grains] };
        let small = Midst::of_small(tree.nodes);
        for node in tree.nodes {
            for word in &node.children[..node.count as usize] {
                let child = Child::decode(*word, node.leaf_base, |place| tree.leaves.large(place));
                let Child::Leaf(leaf) = child else { continue };
                table.first[leaf.first as usize] = table.lines.len() as u16;
                for block in tree.leaves.blocks(leaf) {
                    if table.lines.len() == MOST_BLOCKS {
                        return None;
                    }
                    table.lines.push(Lines::of_block(l, &block, small));
                }
            }
        }
        Some(table)
    }
}

impl LinesTable {
    /// Those of a leaf's k-th block.
    #[inline(always)]
    pub fn of(&self, leaf: Leaf, k: usize) -> &Lines {
        &self.lines[usize::from(self.first[leaf.first as usize]) + k]
    }
}
