//! Where the triangles of leaves lie.
//!
//! A leaf of up to 16 references is one block, plain or pooled (see [`super::block`]); a larger one is a sequence of blocks behind a
//! grain that holds its count and how many of the blocks, the first ones, have pools: all with room for 32 corners, so that each
//! block's place is known. Blocks begin at multiples of 32 bytes.

use super::Triangles;
use super::aligned::AlignedWords;
use super::block::{self, Block, Indices, POOL, words_of};
use super::built::{Built, BuiltKind};
use super::split::BLOCK;
use super::wide::collapse::Places;
use crate::cpu_clock::CpuMeter;
use rayon::prelude::*;

/// Words of a grain, the unit in which places in the store are counted.
pub const GRAIN: usize = 8;
/// Words after the last block, so that sixteen-lane loads never leave the store.
const SLACK: usize = 64;
/// Leaves above which the store is filled in parallel.
const FORK_ABOVE: usize = 1024;

/// The leaves' triangles.
#[derive(Debug)]
pub struct LeafStore {
    words: AlignedWords,
}

/// Where a leaf lies in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Leaf {
    /// Its first grain.
    pub first: u32,
    /// Its references.
    pub count: u32,
    /// Corners in the pool of its block; 0 for a plain one, and for a leaf of more than 16 references.
    pub pool: u32,
}

#[inline(always)]
const fn grains_of(block: usize, pool: usize) -> usize {
    words_of(block, pool).div_ceil(GRAIN)
}

/// Grains that a leaf fills, whose block has so large a pool; or so many of whose blocks have pools, if it has more than one.
fn grains_of_leaf(count: u32, pool: u32) -> u32 {
    let (count, pool) = (count as usize, pool as usize);
    let grains = if count <= BLOCK {
        grains_of(count, pool)
    } else {
        let plain = count - pool * BLOCK;
        pool * grains_of(BLOCK, POOL) + plain / BLOCK * grains_of(BLOCK, 0) + grains_of(plain % BLOCK, 0)
    };
    grains as u32
}

/// The leaves of a built tree, before they have a place.
pub struct Contents<'a> {
    triangles: &'a [u32],
    /// Where each leaf's references begin in the list of all; one more than there are leaves.
    begins: Vec<usize>,
    /// The size of each leaf's pool, and where its triangles' corners are in it; of leaves of more than 16 references, how many of their
    /// blocks have pools.
    pub pools: Vec<(u32, Indices)>,
}

impl<'a> Contents<'a> {
    /// Looks into the leaves. Pools have so many corners at most.
    pub fn new<T: Triangles>(built: &'a Built, triangles: &T, most: usize, cpu: &CpuMeter) -> Self {
        let mut begins = vec![0];
        let mut end = 0;
        for cell in &built.cells {
            if let BuiltKind::Leaf { count } = cell.kind {
                end += count as usize;
                begins.push(end);
            }
        }
        let mut pools = vec![(0, [[0; BLOCK]; 3]); begins.len() - 1];
        pools.par_chunks_mut(FORK_ABOVE).enumerate().for_each(|(chunk, pools)| {
            cpu.measure(|| {
                for (i, pool) in pools.iter_mut().enumerate() {
                    let leaf = chunk * FORK_ABOVE + i;
                    let ids = &built.triangles[begins[leaf]..begins[leaf + 1]];
                    *pool = if ids.len() > BLOCK {
                        (pooled_blocks(ids, triangles, most) as u32, [[0; BLOCK]; 3])
                    } else {
                        let (len, indices) = block::pool(ids, triangles, most);
                        (len as u32, indices)
                    };
                }
            });
        });
        Self { triangles: &built.triangles, begins, pools }
    }

    fn ids(&self, leaf: u32) -> &'a [u32] {
        &self.triangles[self.begins[leaf as usize]..self.begins[leaf as usize + 1]]
    }
}

/// How many of a large leaf's blocks have pools: the first ones, up to the first whose triangles have too many corners.
fn pooled_blocks<T: Triangles>(ids: &[u32], triangles: &T, most: usize) -> usize {
    if most < POOL {
        return 0;
    }
    ids.chunks_exact(BLOCK).take_while(|block| block::pool(block, triangles, POOL).0 > 0).count()
}

/// Deals out places for leaves.
#[derive(Debug)]
pub struct Planner<'a> {
    pools: &'a [(u32, Indices)],
    leaves: Vec<Leaf>,
    /// The order in which leaves lie in the store, by their numbers.
    order: Vec<u32>,
    next: u32,
}

impl<'a> Planner<'a> {
    /// For leaves whose pools have these sizes.
    pub fn new(pools: &'a [(u32, Indices)]) -> Self {
        Self { pools, leaves: vec![Leaf { first: 0, count: 0, pool: 0 }; pools.len()], order: Vec::new(), next: 0 }
    }

    /// Where the leaves lie, in the order of their numbers.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }
}

impl Places for Planner<'_> {
    fn base(&self) -> u32 {
        self.next
    }

    fn place(&mut self, number: u32, count: u32) -> Leaf {
        let (pool, _) = self.pools[number as usize];
        let large = count as usize > BLOCK;
        let leaf = Leaf { first: self.next + u32::from(large), count, pool: if large { 0 } else { pool } };
        self.next = leaf.first + grains_of_leaf(count, pool);
        self.order.push(number);
        self.leaves[number as usize] = leaf;
        leaf
    }
}

impl LeafStore {
    /// Fills leaves that lie where the planner has put them.
    pub fn new<T: Triangles>(contents: &Contents, planner: &Planner, triangles: &T, cpu: &CpuMeter) -> Self {
        let leaves = planner.leaves();
        let mut store = AlignedWords::zeroed(planner.next as usize * GRAIN + SLACK);
        fill(
            store.as_mut_slice(),
            0,
            &planner.order,
            &|words, grain, number| {
                let leaf = leaves[number as usize];
                let ids = contents.ids(number);
                let (pool, indices) = &contents.pools[number as usize];
                let mut at = (leaf.first - grain) as usize * GRAIN;
                if ids.len() <= BLOCK {
                    let len = words_of(ids.len(), leaf.pool as usize);
                    return block::write(&mut words[at..at + len], ids, leaf.pool as usize, indices, triangles);
                }
                (words[at - GRAIN], words[at - GRAIN + 1]) = (leaf.count, *pool);
                for (k, ids) in ids.chunks(BLOCK).enumerate() {
                    let room = if k < *pool as usize { POOL } else { 0 };
                    let (_, indices) = if room > 0 { block::pool(ids, triangles, POOL) } else { (0, *indices) };
                    let len = words_of(ids.len(), room);
                    block::write(&mut words[at..at + len], ids, room, &indices, triangles);
                    at += grains_of(ids.len(), room) * GRAIN;
                }
            },
            &|number| {
                let leaf = leaves[number as usize];
                leaf.first + grains_of_leaf(leaf.count, contents.pools[number as usize].0)
            },
            cpu,
        );
        Self { words: store }
    }

    /// The blocks of a leaf.
    #[inline(always)]
    pub fn blocks(&self, leaf: Leaf) -> impl Iterator<Item = Block<'_>> {
        let first = leaf.first as usize * GRAIN;
        let words = &self.words.as_slice()[first..];
        let count = leaf.count as usize;
        // References in blocks with pools, where there are several blocks.
        let pooled = if count > BLOCK { BLOCK * self.words.as_slice()[first - GRAIN + 1] as usize } else { 0 };
        (0..count).step_by(BLOCK).map(move |begin| {
            let plain = begin >= pooled;
            let before = if plain { pooled } else { begin };
            Block {
                len: (count - begin).min(BLOCK),
                pool: if plain { leaf.pool as usize } else { POOL },
                words: &words[before / BLOCK * grains_of(BLOCK, POOL) * GRAIN + words_of(begin - before, 0)..],
            }
        })
    }

    /// The address of a grain, whether it exists or not.
    #[inline(always)]
    pub fn address(&self, grain: u32) -> usize {
        self.words.as_slice().as_ptr().addr().wrapping_add(grain as usize * GRAIN * size_of::<u32>())
    }

    /// A leaf of more than 16 references by its place.
    pub fn large(&self, first: u32) -> Leaf {
        Leaf { first, count: self.words.as_slice()[(first as usize - 1) * GRAIN], pool: 0 }
    }

    /// All words.
    pub fn words(&self) -> &[u32] {
        self.words.as_slice()
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice())
    }
}

/// Fills `words`, which begin at `grain`, with leaves that lie next to each other in this order.
fn fill(
    words: &mut [u32],
    grain: u32,
    order: &[u32],
    write: &(impl Fn(&mut [u32], u32, u32) + Sync),
    end: &(impl Fn(u32) -> u32 + Sync),
    cpu: &CpuMeter,
) {
    if order.len() <= FORK_ABOVE {
        return cpu.measure(|| order.iter().for_each(|&number| write(words, grain, number)));
    }
    let (first, second) = order.split_at(order.len() / 2);
    let middle = end(first[first.len() - 1]);
    let (left, right) = words.split_at_mut((middle - grain) as usize * GRAIN);
    rayon::join(|| fill(left, grain, first, write, end, cpu), || fill(right, middle, second, write, end, cpu));
}
