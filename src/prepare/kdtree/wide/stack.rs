//! The stack of a walk: memory that is not cleared for each ray.
#![allow(unsafe_code)]

use super::super::split::MAX_DEPTH;
use super::kernel::Enters;
use super::node::WideNode;
use std::mem::MaybeUninit;

/// Children of a node that wait: where they are entered, and which.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Waiting {
    /// Where each child is entered, in the ray's order.
    pub enters: Enters,
    /// The children that wait, a bit each, in the ray's order; never 0 for an entry on the stack.
    pub rest: u32,
}

/// One entry for a level of the tree at most, and one to work with.
const CAPACITY: usize = MAX_DEPTH as usize + 2;

/// Entries from the root down, and above them a free one.
pub struct Stack<'a> {
    entries: [MaybeUninit<Waiting>; CAPACITY],
    nodes: [MaybeUninit<&'a WideNode>; CAPACITY],
    len: usize,
}

impl<'a> Stack<'a> {
    /// An empty stack.
    #[inline(always)]
    pub fn new() -> Self {
        Self { entries: [MaybeUninit::uninit(); CAPACITY], nodes: [MaybeUninit::uninit(); CAPACITY], len: 0 }
    }

    /// The free entry above the last one.
    #[inline(always)]
    pub fn top(&mut self) -> &mut Waiting {
        assert!(self.len < CAPACITY);
        // SAFETY: within bounds by the assertion. `Waiting` is plain numbers, for which any initialised bytes would do,
        // but these may be uninitialised: callers only get a place to write to, which `push` declares written; reading it
        // before is prevented by initialising it here (the optimiser drops the stores that are overwritten).
        unsafe { self.entries.get_unchecked_mut(self.len).write(Waiting { enters: Enters([0.0; 16]), rest: 0 }) }
    }

    /// Keeps the free entry, which belongs to `node`.
    #[inline(always)]
    pub fn push(&mut self, node: &'a WideNode) {
        assert!(self.len < CAPACITY);
        self.nodes[self.len].write(node);
        self.len += 1;
    }

    /// The last entry.
    #[inline(always)]
    pub fn last(&mut self) -> Option<(&mut Waiting, &'a WideNode)> {
        let last = self.len.checked_sub(1)?;
        // SAFETY: below `len`, entries were written by `top` and nodes by `push`; `len` never exceeds the capacity.
        unsafe {
            Some((self.entries.get_unchecked_mut(last).assume_init_mut(), self.nodes.get_unchecked(last).assume_init()))
        }
    }

    /// Drops the last entry.
    #[inline(always)]
    pub fn pop(&mut self) {
        self.len -= 1;
    }
}
