//! Leaf blocks of shared trees, placed where an instance has them.
//!
//! Traversal of a shared tree looks for cells in the mesh's coordinates and meets triangles in the common ones: corners are
//! placed as [`Placement`] does it everywhere, so that a hit on an instance is the hit on a copy of it, bit for bit.

use super::super::block::{Block, POOL, words_of};
use super::super::split::BLOCK;
use super::super::wide::kernel::Kernel;
use crate::math::Placement;

/// Gives blocks of a tree the corners and numbers that rays meet.
pub trait Place {
    /// Whether blocks come out longer than they are, with triangles behind the last that mean nothing.
    const PADS: bool;

    /// A block as rays meet it.
    fn place<'a, K: Kernel>(&'a mut self, kernel: K, block: Block<'a>) -> Block<'a>;
}

/// Leaves blocks as they are.
pub struct AsIs;

impl Place for AsIs {
    const PADS: bool = false;

    #[inline(always)]
    fn place<'a, K: Kernel>(&'a mut self, _: K, block: Block<'a>) -> Block<'a> {
        block
    }
}

/// Words of a padded plain block, and as many behind it as kernels may read.
const WORDS: usize = words_of(BLOCK, 0) + 4 * BLOCK;

/// Places blocks by an instance's placement, or leaves them as they are.
#[repr(align(64))]
pub struct Placing<'p> {
    words: [u32; WORDS],
    placement: Option<&'p Placement>,
    /// What is added to the numbers of triangles.
    first: u32,
}

impl<'p> Placing<'p> {
    /// Leaves blocks as they are.
    #[inline(always)]
    pub fn new() -> Self {
        Self { words: [0; WORDS], placement: None, first: 0 }
    }

    /// From now on, blocks are placed like this.
    #[inline(always)]
    pub fn set(&mut self, placement: Option<&'p Placement>, first: u32) {
        (self.placement, self.first) = (placement, first);
    }
}

impl Place for Placing<'_> {
    const PADS: bool = true;

    #[inline(always)]
    fn place<'a, K: Kernel>(&'a mut self, kernel: K, block: Block<'a>) -> Block<'a> {
        let Some(placement) = self.placement else { return block };
        let (len, pool) = (block.len, block.pool);
        let ids = words_of(len, pool) - len;
        // Whole rows of sixteen, whatever their lengths: so all vectors are stored and loaded alike.
        if pool > BLOCK {
            let mut half = [0; 3 * BLOCK];
            for begin in [0, BLOCK] {
                kernel.place(placement, &block.words[begin..], pool, &mut half);
                for axis in 0..3 {
                    *sixteen_mut(&mut self.words, axis * POOL + begin) = *sixteen(&half, axis * BLOCK);
                }
            }
            *sixteen_mut(&mut self.words, 3 * POOL) = *sixteen(block.words, 3 * pool);
            number(&mut self.words, words_of(0, POOL), sixteen(block.words, ids), self.first);
            return Block { len, pool: POOL, words: &self.words };
        }
        if pool > 0 {
            kernel.place(placement, block.words, pool, rows(&mut self.words, 0));
            *sixteen_mut(&mut self.words, 3 * BLOCK) = *sixteen(block.words, 3 * pool);
            number(&mut self.words, words_of(0, BLOCK), sixteen(block.words, ids), self.first);
            return Block { len, pool: BLOCK, words: &self.words };
        }
        for corner in 0..3 {
            kernel.place(placement, &block.words[3 * corner * len..], len, rows(&mut self.words, 3 * corner * BLOCK));
        }
        number(&mut self.words, words_of(BLOCK, 0) - BLOCK, sixteen(block.words, ids), self.first);
        Block { len: BLOCK, pool: 0, words: &self.words }
    }
}

/// Sixteen words from a place on.
#[inline(always)]
fn sixteen(words: &[u32], at: usize) -> &[u32; BLOCK] {
    words[at..].first_chunk().unwrap_or(&[0; BLOCK])
}

/// Sixteen words from a place on; the first that there are if these are fewer.
#[inline(always)]
fn sixteen_mut(words: &mut [u32; WORDS], at: usize) -> &mut [u32; BLOCK] {
    let at = at.min(WORDS - BLOCK);
    words[at..].first_chunk_mut().unwrap_or_else(|| unreachable!("as many follow"))
}

/// Three rows of sixteen words from a place on.
#[inline(always)]
fn rows(words: &mut [u32; WORDS], at: usize) -> &mut [u32; 3 * BLOCK] {
    let at = at.min(WORDS - 3 * BLOCK);
    words[at..].first_chunk_mut().unwrap_or_else(|| unreachable!("as many follow"))
}

/// Sixteen numbers of triangles, counted from `first`.
#[inline(always)]
fn number(words: &mut [u32; WORDS], at: usize, from: &[u32; BLOCK], first: u32) {
    for (to, from) in sixteen_mut(words, at).iter_mut().zip(from) {
        *to = from.wrapping_add(first);
    }
}
