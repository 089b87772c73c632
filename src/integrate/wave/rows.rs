use crate::lanes::{Floats, LANES, Lanes, V3, Words};
use glam::Vec3;

/// Numbers of many paths side by side: rows of floats and rows of whole numbers, each with room for sixteen more than asked.
pub(super) struct Rows<const FLOATS: usize, const WORDS: usize> {
    floats: [Vec<f32>; FLOATS],
    words: [Vec<u32>; WORDS],
    /// Entries in use.
    pub len: usize,
}

impl<const FLOATS: usize, const WORDS: usize> Rows<FLOATS, WORDS> {
    /// Room for so many entries.
    pub fn new(capacity: usize) -> Self {
        let room = capacity.next_multiple_of(LANES) + LANES;
        Self { floats: std::array::from_fn(|_| vec![0.0; room]), words: std::array::from_fn(|_| vec![0; room]), len: 0 }
    }

    /// A row of floats: all that are in use.
    pub fn floats(&self, row: usize) -> &[f32] {
        &self.floats[row][..self.len]
    }

    /// A row of whole numbers: all that are in use.
    pub fn words(&self, row: usize) -> &[u32] {
        &self.words[row][..self.len]
    }

    /// Three rows, from `row` on.
    pub fn vectors(&self, row: usize) -> [&[f32]; 3] {
        [self.floats(row), self.floats(row + 1), self.floats(row + 2)]
    }

    /// All rows to be written, as far as they are in use.
    pub fn all_mut(&mut self) -> ([&mut [f32]; FLOATS], [&mut [u32]; WORDS]) {
        let len = self.len;
        (self.floats.each_mut().map(|row| &mut row[..len]), self.words.each_mut().map(|row| &mut row[..len]))
    }

    pub fn float(&self, row: usize, at: usize) -> f32 {
        self.floats[row][at]
    }

    pub fn word(&self, row: usize, at: usize) -> u32 {
        self.words[row][at]
    }

    pub fn vector(&self, row: usize, at: usize) -> Vec3 {
        Vec3::new(self.floats[row][at], self.floats[row + 1][at], self.floats[row + 2][at])
    }

    pub fn set_float(&mut self, row: usize, at: usize, x: f32) {
        self.floats[row][at] = x;
    }

    pub fn set_word(&mut self, row: usize, at: usize, x: u32) {
        self.words[row][at] = x;
    }

    pub fn set_vector(&mut self, row: usize, at: usize, v: Vec3) {
        (self.floats[row][at], self.floats[row + 1][at], self.floats[row + 2][at]) = v.into();
    }

    /// Sixteen floats from entry `at` on; there may be fewer in use.
    #[inline(always)]
    pub fn load<L: Lanes>(&self, l: L, row: usize, at: usize) -> L::F {
        l.load_at(&self.floats[row], at)
    }

    /// Sixteen vectors from entry `at` on.
    #[inline(always)]
    pub fn load_vector<L: Lanes>(&self, l: L, row: usize, at: usize) -> V3<L::F> {
        V3::new(self.load(l, row, at), self.load(l, row + 1, at), self.load(l, row + 2, at))
    }

    /// Sixteen whole numbers from entry `at` on.
    #[inline(always)]
    pub fn load_words<L: Lanes>(&self, l: L, row: usize, at: usize) -> L::U {
        l.load_words_at(&self.words[row], at)
    }

    /// All rows of sixteen entries.
    #[inline(always)]
    pub fn load_all<L: Lanes>(&self, l: L, at: usize) -> ([L::F; FLOATS], [L::U; WORDS]) {
        let (mut floats, mut words) = ([l.splat(0.0); FLOATS], [l.word(0); WORDS]);
        for (x, row) in floats.iter_mut().zip(&self.floats) {
            *x = l.load_at(row, at);
        }
        for (x, row) in words.iter_mut().zip(&self.words) {
            *x = l.load_words_at(row, at);
        }
        (floats, words)
    }

    /// Writes those of sixteen entries where the mask is true from entry `at` on, close together. Entries behind them are
    /// overwritten.
    #[inline(always)]
    pub fn store<L: Lanes>(&mut self, at: usize, mask: L::M, floats: [L::F; FLOATS], words: [L::U; WORDS]) {
        for (row, x) in self.floats.iter_mut().zip(floats) {
            x.compress(mask).store((&mut row[at..at + LANES]).try_into().expect("sixteen"));
        }
        for (row, x) in self.words.iter_mut().zip(words) {
            x.compress(mask).store((&mut row[at..at + LANES]).try_into().expect("sixteen"));
        }
    }

    /// Takes the entries of others, of which there is as much room, in this order; `order` has room for sixteen more numbers than it has.
    #[inline(always)]
    pub fn take<L: Lanes>(&mut self, l: L, from: &Self, order: &[u32]) {
        self.len = from.len;
        for at in (0..self.len).step_by(LANES) {
            let order = l.load_words_at(order, at);
            for (to, from) in self.floats.iter_mut().zip(&from.floats) {
                l.gather(from, order).store((&mut to[at..at + LANES]).try_into().expect("sixteen"));
            }
            for (to, from) in self.words.iter_mut().zip(&from.words) {
                l.gather_words(from, order).store((&mut to[at..at + LANES]).try_into().expect("sixteen"));
            }
        }
    }
}
