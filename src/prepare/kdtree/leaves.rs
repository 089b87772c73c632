//! The triangles of leaves, laid out for kernels that test a block at once.
//!
//! A leaf of n references is a sequence of blocks of up to 16; a block of m is ten arrays of m words, one after the
//! other: x, y, z of the first corners, of the second, of the third, and the triangles' numbers. Blocks begin at
//! multiples of 32 bytes. So a reference takes 40 bytes, and a kernel reads an array with one masked load.

use super::Triangles;
use super::aligned::AlignedWords;
use super::build::Built;
use super::split::BLOCK;

/// Words of a grain, the unit in which places in the store are counted.
const GRAIN: usize = 8;
/// Words of a reference in a block.
const ARRAYS: usize = 10;
/// Words after the last block, so that sixteen-lane loads never leave the store.
const SLACK: usize = 32;

/// The leaves' triangles.
#[derive(Debug)]
pub struct LeafStore {
    words: AlignedWords,
}

/// Where a leaf lies in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Its first grain.
    pub first: u32,
    /// Its references.
    pub count: u32,
}

/// A block of up to 16 references: ten arrays of `len` words.
#[derive(Clone, Copy, Debug)]
pub struct Block<'a> {
    /// References in it.
    pub len: usize,
    /// Its words, and whatever follows.
    pub words: &'a [u32],
}

fn grains_of(block: usize) -> usize {
    (block * ARRAYS).div_ceil(GRAIN)
}

/// Grains that a leaf fills.
fn grains_of_leaf(count: usize) -> usize {
    (count / BLOCK) * grains_of(BLOCK) + grains_of(count % BLOCK)
}

/// The order in which leaves lie in the store.
#[derive(Debug, Default)]
pub struct Layout {
    /// Leaves by their numbers.
    pub order: Vec<u32>,
    /// Grains that they fill.
    pub grains: u32,
}

/// Leaves above which the store is filled in parallel.
const FORK_ABOVE: usize = 1024;

/// What the store is filled from.
struct Filler<'a, T> {
    built: &'a Built,
    leaves: &'a [Leaf],
    /// Where each leaf's references begin in the list of all.
    begins: &'a [usize],
    triangles: &'a T,
}

impl<T: Triangles> Filler<'_, T> {
    /// Fills `words`, which begin at a grain, with leaves that lie next to each other.
    fn fill(&self, words: &mut [u32], grain: u32, order: &[u32]) {
        if order.len() > FORK_ABOVE {
            let (first, second) = order.split_at(order.len() / 2);
            // A large leaf's count lies before it: the cut is behind the last leaf of the first half.
            let last = self.leaves[first[first.len() - 1] as usize];
            let middle = last.first + grains_of_leaf(last.count as usize) as u32;
            let (left, right) = words.split_at_mut((middle - grain) as usize * GRAIN);
            rayon::join(|| self.fill(left, grain, first), || self.fill(right, middle, second));
            return;
        }
        for &number in order {
            let leaf = self.leaves[number as usize];
            let begin = self.begins[number as usize];
            let ids = &self.built.triangles[begin..begin + leaf.count as usize];
            let mut at = (leaf.first - grain) as usize * GRAIN;
            if ids.len() > BLOCK {
                words[at - GRAIN] = leaf.count;
            }
            for block in ids.chunks(BLOCK) {
                fill(&mut words[at..at + block.len() * ARRAYS], block, self.triangles);
                at += grains_of(block.len()) * GRAIN;
            }
        }
    }
}

/// Deals out places for leaves.
#[derive(Debug, Default)]
pub struct Planner {
    next: u32,
}

impl Planner {
    /// The place of the next leaf of up to 16 references.
    pub fn next(&self) -> u32 {
        self.next
    }

    /// A place for a leaf. Before a leaf of more than one block lies a grain with its count.
    pub fn place(&mut self, count: u32) -> Leaf {
        let first = self.next + u32::from(count as usize > BLOCK);
        self.next = first + grains_of_leaf(count as usize) as u32;
        Leaf { first, count }
    }
}

impl LeafStore {
    /// Fills the leaves of a built tree, which lie at `leaves` (in their order).
    pub fn new<T: Triangles>(built: &Built, leaves: &[Leaf], layout: &Layout, triangles: &T) -> Self {
        let mut store = AlignedWords::zeroed(layout.grains as usize * GRAIN + SLACK);
        let begin = |sum: &mut usize, leaf: &Leaf| {
            let mine = *sum;
            *sum += leaf.count as usize;
            Some(mine)
        };
        let begins: Vec<usize> = leaves.iter().scan(0, begin).collect();
        let filler = Filler { built, leaves, begins: &begins, triangles };
        filler.fill(store.as_mut_slice(), 0, &layout.order);
        Self { words: store }
    }

    /// The first word of a leaf.
    #[inline(always)]
    pub fn begin(&self, first: u32) -> Option<&u32> {
        self.words.as_slice().get(first as usize * GRAIN)
    }

    /// The count of a leaf of more than 16 references.
    pub fn count_before(&self, first: u32) -> u32 {
        self.words.as_slice()[(first as usize - 1) * GRAIN]
    }

    /// The blocks of a leaf of `count` references that begins at the grain `first`.
    #[inline(always)]
    pub fn blocks(&self, first: u32, count: usize) -> impl Iterator<Item = Block<'_>> {
        let words = &self.words.as_slice()[first as usize * GRAIN..];
        (0..count)
            .step_by(BLOCK)
            .map(move |begin| Block { len: (count - begin).min(BLOCK), words: &words[begin * ARRAYS..] })
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

fn fill<T: Triangles>(words: &mut [u32], ids: &[u32], triangles: &T) {
    let n = ids.len();
    for (i, &id) in ids.iter().enumerate() {
        let coordinates = triangles.vertices(id).map(|v| v.to_array());
        for (k, x) in coordinates.as_flattened().iter().enumerate() {
            words[k * n + i] = x.to_bits();
        }
        words[9 * n + i] = id;
    }
}

impl Block<'_> {
    /// The corners of a reference's triangle.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> [[f32; 3]; 3] {
        let at = |k: usize| f32::from_bits(self.words[k * self.len + i]);
        [[at(0), at(1), at(2)], [at(3), at(4), at(5)], [at(6), at(7), at(8)]]
    }

    /// The number of a reference's triangle.
    #[inline(always)]
    pub fn triangle(&self, i: usize) -> u32 {
        self.words[9 * self.len + i]
    }
}
