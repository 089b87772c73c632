//! The stack of a walk: memory that is not cleared for each ray.
#![allow(unsafe_code)]

use super::super::split::MAX_DEPTH;
use super::node::WIDTH;
use std::mem::MaybeUninit;

/// A child that waits to be visited.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// Where the ray enters it; not a number below the last child.
    pub enter: f32,
    /// What it is, as its node has it.
    pub word: u32,
    /// The place in the leaf store from which its node counts.
    pub leaf_base: u32,
}

/// A node leaves all but one of its children on the stack, at most so often; one entry lies below all, and there is room for
/// all lanes of a vector above.
const CAPACITY: usize = MAX_DEPTH as usize * (WIDTH - 1) + 1 + 2 * WIDTH;

/// Children that wait, the next one on top. Below them lies an entry whose distance is not a number.
pub struct Stack {
    enters: [MaybeUninit<f32>; CAPACITY],
    words: [MaybeUninit<u32>; CAPACITY],
    leaf_bases: [MaybeUninit<u32>; CAPACITY],
    /// Entries in use, all initialised; the lowest is always there.
    len: usize,
}

impl Stack {
    /// Does some work with an empty stack.
    #[cfg(test)]
    pub fn with<R>(work: impl FnOnce(&mut Self) -> R) -> R {
        let mut place = MaybeUninit::<Self>::uninit();
        work(Self::begin(&mut place))
    }

    /// Several empty stacks.
    pub fn several(count: usize) -> Vec<Self> {
        let mut stacks = Vec::with_capacity(count);
        stacks.spare_capacity_mut()[..count].iter_mut().for_each(|place| {
            Self::begin(place);
        });
        // SAFETY: so many were begun.
        unsafe { stacks.set_len(count) };
        stacks
    }

    /// Makes an empty stack in its place, since it is too large to be moved, without a touch of what may stay uninitialised.
    #[inline(always)]
    pub fn begin(place: &mut MaybeUninit<Self>) -> &mut Self {
        let stack = place.as_mut_ptr();
        // SAFETY: all writes go to fields of the place; what is not written need not be initialised by its type.
        unsafe {
            (&raw mut (*stack).enters[0]).write(MaybeUninit::new(f32::NAN));
            (&raw mut (*stack).words[0]).write(MaybeUninit::new(0));
            (&raw mut (*stack).leaf_bases[0]).write(MaybeUninit::new(0));
            (&raw mut (*stack).len).write(1);
            place.assume_init_mut()
        }
    }

    /// Drops all that wait, under a condition that nobody could foretell.
    #[inline(always)]
    pub fn clear_if(&mut self, condition: bool) {
        self.len = if condition { 1 } else { self.len };
    }

    /// Puts a child on top.
    #[inline(always)]
    pub fn push(&mut self, enter: f32, word: u32, leaf_base: u32) {
        self.enters[self.len].write(enter);
        self.words[self.len].write(word);
        self.leaf_bases[self.len].write(leaf_base);
        self.len += 1;
    }

    /// Where the next sixteen distances, words and leaf bases go: a kernel writes to all 48 and says with [`Stack::grow`]
    /// how many are to stay.
    #[inline(always)]
    pub fn room(&mut self) -> (*mut f32, *mut u32, *mut u32) {
        let room = self.len..self.len + WIDTH;
        (
            self.enters[room.clone()].as_mut_ptr().cast(),
            self.words[room.clone()].as_mut_ptr().cast(),
            self.leaf_bases[room].as_mut_ptr().cast(),
        )
    }

    /// Keeps `count` of the entries that were written to [`Stack::room`].
    ///
    /// # Safety
    /// All of them were written, and `count` is at most 16.
    #[inline(always)]
    pub unsafe fn grow(&mut self, count: usize) {
        self.len += count;
    }

    /// Entries, with the lowest one.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Takes the top. The lowest entry stays.
    #[inline(always)]
    pub fn pop(&mut self) -> Waiting {
        let top = self.len - 1;
        self.len = top + usize::from(top == 0);
        self.at(top)
    }

    /// What will be popped next.
    #[inline(always)]
    pub fn top(&self) -> Waiting {
        self.at(self.len - 1)
    }

    #[inline(always)]
    fn at(&self, i: usize) -> Waiting {
        // SAFETY: entries below `len`, which lies in 1..=CAPACITY and has only grown over initialised entries, are
        // initialised; all callers pass `len - 1`.
        unsafe {
            Waiting {
                enter: self.enters.get_unchecked(i).assume_init(),
                word: self.words.get_unchecked(i).assume_init(),
                leaf_base: self.leaf_bases.get_unchecked(i).assume_init(),
            }
        }
    }
}
