//! The lines of blocks that were visited lately: packets of one tile come by the same ones again and again.

use super::super::block::Block;
use super::node::WideNode;
use super::packet_lines::{Lines, Midst};
use crate::lanes::Lanes;
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Blocks whose lines a thread keeps, a power of two: a quarter of a megabyte. Eight took 7 % of studio_lambert's time to make
/// lines (scripts/runs/2026-11-24-kept-lines.md).
const KEPT: usize = 128;

/// Tells trees apart: where a tree was, another may be later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeNumber(u64);

impl TreeNumber {
    /// One that no other tree of the process has.
    pub fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Lines of blocks of one tree, each in the only place where it may be.
pub struct KeptLines {
    lines: Vec<Lines>,
    /// Addresses of the blocks; 0 for none.
    blocks: [usize; KEPT],
    small: Option<Midst>,
    tree: TreeNumber,
}

thread_local! {
    static LAST: Cell<Option<Box<KeptLines>>> = const { Cell::new(None) };
}

impl KeptLines {
    /// None yet, for a tree of these nodes.
    pub fn new(tree: TreeNumber, nodes: &[WideNode]) -> Self {
        Self { lines: vec![Lines::NONE; KEPT], blocks: [0; KEPT], small: Midst::of_small(nodes), tree }
    }

    /// What this thread kept when it last had to do with the tree of these nodes, if it has seen no other one since.
    #[inline(never)]
    pub fn take(tree: TreeNumber, nodes: &[WideNode]) -> Box<Self> {
        match LAST.take() {
            Some(last) if last.tree == tree => last,
            _ => Box::new(Self::new(tree, nodes)),
        }
    }

    /// Leaves it to the thread's next packets.
    #[inline(never)]
    pub fn leave(self: Box<Self>) {
        LAST.set(Some(self));
    }

    /// Those of a block of the tree.
    #[inline(always)]
    pub fn of<L: Lanes>(&mut self, l: L, block: &Block) -> &Lines {
        let address = block.words.as_ptr().addr();
        let at = place(address);
        if self.blocks[at] != address {
            self.lines[at].set(l, block, self.small);
            self.blocks[at] = address;
        }
        &self.lines[at]
    }
}

/// Where the lines of a block at an address may be: by the golden section, so that neighbours are far apart.
#[inline(always)]
fn place(address: usize) -> usize {
    let spread = (address as u64 >> 2).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    (spread >> (u64::BITS - KEPT.ilog2())) as usize % KEPT
}
