//! What a tier of vector instructions has to bring.

use super::super::block::Block;
use super::super::slab::SlabRay;
use super::node::{WIDTH, WideNode};
use super::stack::Stack;
use crate::math::Placement;
use crate::math::triangle::ShearedRay;

/// A ray as the test of a node's boxes wants it. Small, since many may be in flight: kernels spread its numbers as they load them.
#[derive(Clone, Copy, Debug, Default)]
pub struct BoxRay {
    /// See [`SlabRay::enter_from`].
    pub enter_from: [f32; 3],
    /// See [`SlabRay::leave_from`].
    pub leave_from: [f32; 3],
    /// See [`SlabRay::inv`].
    pub inv: [f32; 3],
    /// Among the rows of planes, counted in numbers: how far behind the row of an axis' lower ends that of the ends lies where
    /// boxes are entered; 0 or [`UPPER`].
    pub upper: [u32; 3],
    /// Among the words of a node's orders (two each), where the order against this octant begins, the farthest child first.
    pub order: u32,
    /// 1 where the order has to be read backwards, else 0.
    pub backwards: u32,
}

/// From a row of lower ends to that of upper ends, in numbers.
pub const UPPER: u32 = 3 * WIDTH as u32;

/// Error of the numerator of a distance in f32, relative to the magnitudes in it: see the AVX-512 kernel.
pub const BEHIND_ERROR: f32 = 8.0 / 16_777_216.0;
/// What underflow may take away from it.
pub const BEHIND_UNDERFLOW: f32 = 1e-30;
/// What underflow may take away from the denominator, and more.
pub const BEYOND_UNDERFLOW: f32 = 1e-36;
/// One, and what rounding may do to the comparison of a numerator with a denominator times the ray's end.
const BEYOND_GROWTH: f32 = 1.0 + 16.0 / 16_777_216.0;

/// How far a ray reaches along z up to `end`: never too small.
#[inline(always)]
pub fn reach(ray: &ShearedRay, end: f32) -> f32 {
    // Below the normal numbers, rounding is not relative.
    end * ray.dir_z.abs() * BEYOND_GROWTH + f32::MIN_POSITIVE
}

impl BoxRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(slab: &SlabRay) -> Self {
        let mut ray = Self::default();
        ray.set(slab);
        ray
    }

    /// Prepares a ray in place.
    #[inline(always)]
    pub fn set(&mut self, slab: &SlabRay) {
        let octant = slab.octant as u32;
        let ahead = u32::from(octant < 4);
        for axis in 0..3 {
            self.enter_from[axis] = slab.enter_from[axis];
            self.leave_from[axis] = slab.leave_from[axis];
            self.inv[axis] = slab.inv[axis];
            self.upper[axis] = (octant >> axis & 1) * UPPER;
        }
        self.order = 2 * if ahead == 1 { octant } else { 7 - octant };
        self.backwards = ahead;
    }
}

/// The two inner loops.
pub trait Kernel: Copy {
    /// Puts those children of a node on the stack that the ray enters up to `limit`: the first that it passes on top.
    fn open(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack);

    /// The same, but for the child that the ray passes first: that one's word is given back, if there is any, and not put on the stack.
    #[inline(always)]
    fn open_first(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> Option<u32> {
        let before = stack.len();
        self.open(ray, node, limit, stack);
        (stack.len() > before).then(|| stack.pop().word)
    }

    /// [`Kernel::open_first`] for who wants any hit: in any order.
    #[inline(always)]
    fn open_any(self, ray: &BoxRay, node: &WideNode, limit: f32, stack: &mut Stack) -> Option<u32> {
        self.open_first(ray, node, limit, stack)
    }

    /// Which of a leaf block's triangles but the `barred` one the ray may meet no farther than `end`, the first in the lowest bit: at
    /// least all that it does. The block's words reach 64 words beyond its end.
    fn candidates(self, ray: &ShearedRay, block: &Block, barred: u32, end: f32) -> u32;

    /// Places sixteen points, whose coordinates lie in `from` in rows `stride` words apart, as [`Placement::point`] does: bit for
    /// bit. Rows reach 16 words beyond the beginning of the last.
    fn place(self, placement: &Placement, from: &[u32], stride: usize, to: &mut [u32; 3 * WIDTH]);
}

/// Work that is compiled for the instructions of whatever kernel does it; for that, it has to be inlined for certain.
pub trait Job {
    /// What comes of it.
    type Output;

    /// Does it.
    fn run<K: Kernel>(self, kernel: K) -> Self::Output;
}
