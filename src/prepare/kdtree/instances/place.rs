//! Leaf blocks of shared trees, placed where an instance has them.
//!
//! Traversal of a shared tree looks for cells in the mesh's coordinates and meets triangles in the common ones: corners are
//! placed as [`Placement`] does it everywhere, so that a hit on an instance is the hit on a copy of it, bit for bit.

use super::super::block::{Block, words_of};
use super::super::split::BLOCK;
use crate::math::Placement;

/// Gives blocks of a tree the corners and numbers that rays meet.
pub trait Place {
    /// Whether blocks come out longer than they are, with triangles behind the last that mean nothing.
    const PADS: bool;

    /// A block as rays meet it.
    fn place<'a>(&'a mut self, block: Block<'a>) -> Block<'a>;
}

/// Leaves blocks as they are.
pub struct AsIs;

impl Place for AsIs {
    const PADS: bool = false;

    #[inline(always)]
    fn place<'a>(&'a mut self, block: Block<'a>) -> Block<'a> {
        block
    }
}

/// Words of a padded plain block, and as many behind it as kernels may read.
const WORDS: usize = words_of(BLOCK, 0) + 4 * BLOCK;

/// Places blocks by an instance's placement, or leaves them as they are.
#[repr(align(64))]
pub struct Placing {
    words: [u32; WORDS],
    placement: Option<Placement>,
    /// What is added to the numbers of triangles.
    first: u32,
}

impl Placing {
    /// Leaves blocks as they are.
    #[inline(always)]
    pub fn new() -> Self {
        Self { words: [0; WORDS], placement: None, first: 0 }
    }

    /// From now on, blocks are placed like this.
    #[inline(always)]
    pub fn set(&mut self, placement: Option<&Placement>, first: u32) {
        (self.placement, self.first) = (placement.copied(), first);
    }
}

impl Place for Placing {
    const PADS: bool = true;

    #[inline(always)]
    fn place<'a>(&'a mut self, block: Block<'a>) -> Block<'a> {
        let Some(placement) = &self.placement else { return block };
        let (len, pool) = (block.len, block.pool);
        let ids = words_of(len, pool) - len;
        // Whole rows of sixteen, whatever their lengths: so all vectors are stored and loaded alike.
        if pool > 0 {
            rows(placement, block.words, pool, &mut self.words);
            let indices = &mut self.words[3 * BLOCK..];
            indices[..12].copy_from_slice(&block.words[3 * pool..3 * pool + 12]);
            number(&mut self.words[words_of(0, BLOCK)..], &block.words[ids..], self.first);
            return Block { len, pool: BLOCK, words: &self.words };
        }
        for corner in 0..3 {
            rows(placement, &block.words[3 * corner * len..], len, &mut self.words[3 * corner * BLOCK..]);
        }
        number(&mut self.words[words_of(BLOCK, 0) - BLOCK..], &block.words[ids..], self.first);
        Block { len: BLOCK, pool: 0, words: &self.words }
    }
}

/// Sixteen words from a place on.
#[inline(always)]
fn sixteen(words: &[u32], at: usize) -> &[u32; BLOCK] {
    words[at..].first_chunk().unwrap_or(&[0; BLOCK])
}

/// Places sixteen points whose coordinates lie `stride` words apart.
#[inline(always)]
fn rows(placement: &Placement, from: &[u32], stride: usize, to: &mut [u32]) {
    let (x, y, z) = (sixteen(from, 0), sixteen(from, stride), sixteen(from, 2 * stride));
    for (axis, row) in placement.rows.iter().enumerate() {
        let Some(to) = to[axis * BLOCK..].first_chunk_mut::<BLOCK>() else { return };
        for i in 0..BLOCK {
            let at = Placement::coordinate(row, f32::from_bits(x[i]), f32::from_bits(y[i]), f32::from_bits(z[i]));
            to[i] = at.to_bits();
        }
    }
}

/// Sixteen numbers of triangles, counted from `first`.
#[inline(always)]
fn number(to: &mut [u32], from: &[u32], first: u32) {
    let from = sixteen(from, 0);
    let Some(to) = to.first_chunk_mut::<BLOCK>() else { return };
    for i in 0..BLOCK {
        to[i] = from[i].wrapping_add(first);
    }
}
