//! When a ray is inside a box: bounds that lose no hit.
//!
//! Let a ray o + t·d be reported to hit a triangle of largest extent D at the (rounded) distance t, and let u = 2⁻²⁴.
//! On each axis i, the watertight test (`math::triangle`) shears each corner with an error of at most
//! `u·(2·|v_i − o_i| + 4·|d_i/d_z·(v_z − o_z)|)`; its signs are exact for the sheared corners, and its weights good to
//! f64. So there is a point q of the true triangle with `|q_i − (o_i + t·d_i)| ≤ 8u·t·|d_i| + 7u·D`: an error relative
//! to the way along *that axis*, plus one relative to the triangle's size.
//!
//! The second part is in the boxes: that of a leaf holds what its cell sees of each triangle, widened by more than 7u·D
//! (see `clip`), and those above hold those below; or, in the traversal by planes, it is added to the planes. The first part is here: distances to planes are taken shorter or longer by [`RELATIVE_ERROR`], which
//! covers 8u and the roundings of the slab test that are relative to the distance. The distance to a plane p is
//! `p·(1/d) − o·(1/d)`, whose other roundings are relative to `o·(1/d)`: they are in the second term. Hence, for the cell that holds the point q,
//! `enter ≤ t ≤ leave` on every axis and at every ancestor; a traversal that skips only boxes with
//! `enter > nearest hit` or `enter > leave` finds what brute force finds.

use crate::math::Ray;
use glam::Vec3;

/// 20 u: see above.
pub const RELATIVE_ERROR: f32 = 20.0 / 16_777_216.0;
/// 16 u, more than the roundings of the term that only depends on the ray, and of products with planes.
const OFFSET_ERROR: f32 = 16.0 / 16_777_216.0;

/// Directions below this (after scaling) count as parallel to the planes of their axis.
const PARALLEL: f32 = 1e-24;
/// Reciprocal of a direction that counts as parallel. Its product with any coordinate is finite.
const HUGE: f32 = 1e25;
/// Beyond any distance, and beyond `HUGE` times the way across that a parallel ray may make within a scene.
const FAR: f32 = 2e14;

/// Makes the shortest of directions normal numbers.
const DENORMAL_SCALE: f32 = 16_777_216.0;

/// A ray as the slab test wants it. Its distances are scaled by a power of two so that the direction's largest
/// component lies in [1, 2); that keeps all of them in f32's range whatever the length of the direction.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// Reciprocal directions for the planes where a box is entered, a little too small.
    pub enter_inv: [f32; 3],
    /// What is added to the product with the plane: minus the origin's, a little too small.
    pub enter_add: [f32; 3],
    /// Reciprocal directions for the planes where a box is left, a little too large.
    pub leave_inv: [f32; 3],
    /// What is added to the product with the plane: minus the origin's, a little too large.
    pub leave_add: [f32; 3],
    /// On which axes the direction is negative, a bit each from x: there, boxes are entered at their upper end.
    pub octant: usize,
    /// See [`SlabRay::stop`].
    stop_factor: f32,
    stop_add: f32,
    scale: f32,
}

impl SlabRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let (mut dir, mut longer) = (ray.dir, 1.0);
        if dir.abs().max_element() < f32::MIN_POSITIVE {
            (dir, longer) = (dir * DENORMAL_SCALE, DENORMAL_SCALE);
        }
        // Powers of two by their exponents: products with them are exact.
        let exponent = (dir.abs().max_element().to_bits() >> 23) & 0xff;
        let scale = f32::from_bits(exponent << 23);
        let shrink = if exponent < 254 { f32::from_bits((254 - exponent) << 23) } else { 0.5 * f32::MIN_POSITIVE };
        let d = dir * shrink;
        let inv = d.recip();
        let (enter_inv, leave_inv) = (inv * (1.0 - RELATIVE_ERROR), inv * (1.0 + RELATIVE_ERROR));
        let (enter_from, leave_from) = (ray.origin * enter_inv, ray.origin * leave_inv);
        let slack = leave_from.abs() * OFFSET_ERROR;
        let mut slab = Self {
            enter_inv: enter_inv.to_array(),
            enter_add: (-enter_from - slack).to_array(),
            leave_inv: leave_inv.to_array(),
            leave_add: (slack - leave_from).to_array(),
            octant: usize::from(d.x < 0.0) | usize::from(d.y < 0.0) << 1 | usize::from(d.z < 0.0) << 2,
            stop_factor: 1.0 + 8.0 * RELATIVE_ERROR,
            stop_add: 4.0 * (slack.x + slack.y + slack.z),
            scale: scale / longer,
        };
        if d.x.abs() < PARALLEL || d.y.abs() < PARALLEL || d.z.abs() < PARALLEL {
            slab.mend_parallel(ray, d);
        }
        slab
    }

    /// Axes along which the ray does not move: it is inside for ever or never, and within a plane it is on both sides.
    #[cold]
    #[inline(never)]
    fn mend_parallel(&mut self, ray: &Ray, d: Vec3) {
        for axis in 0..3 {
            if d[axis].abs() < PARALLEL {
                let from = ray.origin[axis] * HUGE;
                let slack = FAR + from.abs() * OFFSET_ERROR;
                self.enter_inv[axis] = HUGE;
                self.leave_inv[axis] = HUGE;
                self.enter_add[axis] = -from - slack;
                self.leave_add[axis] = -from + slack;
                self.octant &= !(1 << axis);
            }
        }
        self.stop_factor = f32::INFINITY;
        self.stop_add = f32::INFINITY;
    }

    /// Whether the direction is negative on an axis.
    #[inline(always)]
    pub fn is_negative(&self, axis: usize) -> bool {
        (self.octant >> axis) & 1 == 1
    }

    /// A distance on the ray as a scaled distance, never too small.
    #[inline(always)]
    pub fn scaled(&self, t: f32) -> f32 {
        t * self.scale + f32::MIN_POSITIVE
    }

    /// With cells in the order in which the ray passes them: the factor and the term that make of the limit a distance such
    /// that, when a box is entered beyond it, all later ones are entered beyond the limit. The margin covers rounding, boxes
    /// that the ray only seems to meet, and boxes that reach into each other by twice `thickness`. Infinite for a ray that is
    /// parallel to an axis: it may run within a plane between two cells, where there is no order.
    #[inline(always)]
    pub fn stop(&self, thickness: f32) -> (f32, f32) {
        let [x, y, z] = self.leave_inv.map(f32::abs);
        let steepest = if x > y { x } else { y };
        let steepest = if z > steepest { z } else { steepest };
        (self.stop_factor, self.stop_add + 4.0 * thickness * steepest)
    }

    /// The scaled distance at which a plane is reached at the earliest.
    #[inline(always)]
    pub fn enter(&self, axis: usize, plane: f32) -> f32 {
        plane * self.enter_inv[axis] + self.enter_add[axis]
    }

    /// The scaled distance at which a plane is left at the latest.
    #[inline(always)]
    pub fn leave(&self, axis: usize, plane: f32) -> f32 {
        plane * self.leave_inv[axis] + self.leave_add[axis]
    }

    /// From where to where the ray may be inside a box, from 0 on: outside all along when the first exceeds the second.
    pub fn interval(&self, bounds: &super::bounds::Bounds) -> (f32, f32) {
        let (mut enter, mut leave) = (0.0f32, f32::INFINITY);
        for axis in 0..3 {
            let (lo, hi) = (bounds.lo(axis), bounds.hi(axis));
            let (first, last) = if self.is_negative(axis) { (hi, lo) } else { (lo, hi) };
            enter = enter.max(self.enter(axis, first));
            leave = leave.min(self.leave(axis, last));
        }
        (enter, leave)
    }
}
