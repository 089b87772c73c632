//! When a ray is inside a box: bounds that lose no hit.
//!
//! Let a ray o + t·d be reported to hit a triangle of largest extent D at the (rounded) distance t, and let u = 2⁻²⁴.
//! On each axis i, the watertight test (`math::triangle`) shears each corner with an error of at most
//! `u·(2·|v_i − o_i| + 4·|d_i/d_z·(v_z − o_z)|)`; its signs are exact for the sheared corners, and its weights good to
//! f64. So there is a point q of the true triangle with `|q_i − (o_i + t·d_i)| ≤ 8u·t·|d_i| + 7u·D`: an error relative
//! to the way along *that axis*, plus one relative to the triangle's size.
//!
//! The second part is in the boxes: that of a leaf holds what its cell sees of each triangle, widened by more than 7u·D
//! (see `clip`), and those above hold those below; or, in the traversal by planes, it is added to the planes. The first part
//! is here. The distance to a plane p is `(p − o)·(1/d)`, all of whose roundings are relative to the distance: 3u and a
//! little. Both errors together, of the two distances that are compared, stay below [`GROWTH`], by which distances where
//! something ends are made longer: where a box is left, and the nearest hit. Hence, for the cell that holds the point q,
//! `enter ≤ t ≤ leave` on every axis and at every ancestor; a traversal that skips only boxes with
//! `enter > nearest hit` or `enter > leave` finds what brute force finds.

use crate::math::Ray;
use glam::{DVec3, Vec3};

/// 20 u: what a triangle is thickened by, relative to its size; more than the 7u above.
pub const RELATIVE_ERROR: f32 = 20.0 / 16_777_216.0;
/// One and 48 u: see above.
pub const GROWTH: f32 = 1.0 + 48.0 / 16_777_216.0;

/// Directions below this (after scaling) count as parallel to the planes of their axis.
pub const PARALLEL: f32 = 1e-24;
/// Reciprocal of a direction that counts as parallel. Its product with any coordinate is finite.
const HUGE: f32 = 1e25;
/// Planes within this distance of a ray that is parallel to them are on both sides of it, or within some ulps of its place. Times
/// `HUGE` that is beyond any distance.
const BESIDE: f32 = 2e-11;

/// Directions whose longest component lies between these need no scaling: all products stay within f32's range.
pub const PLAIN: [f32; 2] = [1e-6, 1e6];

/// Rays that begin so far away have no boxes that they pass by, when they are seen from other coordinates.
const FAR: f32 = 1e18;

/// Makes the shortest of directions normal numbers.
const DENORMAL_SCALE: f32 = 16_777_216.0;

/// Whether a ray is of usual length and parallel to no axis, so that its direction can be taken as it is.
#[inline(always)]
pub fn is_plain(ray: &Ray) -> bool {
    let length = ray.dir.abs();
    let (longest, shortest) = (length.max_element(), length.min_element());
    (PLAIN[0]..=PLAIN[1]).contains(&longest) && shortest >= PARALLEL
}

/// A ray as the slab test wants it. Where the direction's length is unusual or an axis is parallel to it, distances are scaled
/// by a power of two so that its largest component lies in [1, 2); that keeps all of them in f32's range.
#[derive(Clone, Copy, Debug, Default)]
pub struct SlabRay {
    /// Where distances to planes where boxes are entered count from: the ray's origin.
    pub enter_from: [f32; 3],
    /// Where distances to planes where boxes are left count from: the ray's origin.
    pub leave_from: [f32; 3],
    /// Reciprocals of the direction.
    pub inv: [f32; 3],
    /// On which axes the direction is negative, a bit each from x: there, boxes are entered at their upper end.
    pub octant: usize,
    /// See [`SlabRay::stop`].
    stop_factor: f32,
    scale: f32,
}

impl SlabRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        if is_plain(ray) {
            return Self::scaled_by(ray, ray.dir, 1.0);
        }
        // Number by number: who takes it whole from memory keeps all rays there.
        let Self { enter_from: [a, b, c], leave_from: [d, e, f], inv: [x, y, z], octant, stop_factor, scale } =
            Self::with_care(ray);
        Self { enter_from: [a, b, c], leave_from: [d, e, f], inv: [x, y, z], octant, stop_factor, scale }
    }

    /// By value: what is passed by reference stays in memory, where others wait for it.
    #[cold]
    #[inline(never)]
    fn with_care(ray: &Ray) -> Self {
        let mut slab = Self::default();
        slab.set_with_care(ray);
        slab
    }

    #[inline(always)]
    fn scaled_by(ray: &Ray, d: Vec3, scale: f32) -> Self {
        let mut slab = Self::default();
        slab.set_scaled(ray, d, scale);
        slab
    }

    /// Prepares a ray in place, number by number: to move all that was just written costs more than to write it.
    #[inline(always)]
    pub fn set(&mut self, ray: &Ray) {
        if is_plain(ray) {
            self.set_scaled(ray, ray.dir, 1.0);
        } else {
            self.set_with_care(ray);
        }
    }

    /// A direction of unusual length, or one that is parallel to an axis.
    #[cold]
    #[inline(never)]
    fn set_with_care(&mut self, ray: &Ray) {
        let (mut dir, mut longer) = (ray.dir, 1.0);
        if dir.abs().max_element() < f32::MIN_POSITIVE {
            (dir, longer) = (dir * DENORMAL_SCALE, DENORMAL_SCALE);
        }
        // Powers of two by their exponents: products with them are exact.
        let exponent = (dir.abs().max_element().to_bits() >> 23) & 0xff;
        let scale = f32::from_bits(exponent << 23);
        let shrink = if exponent < 254 { f32::from_bits((254 - exponent) << 23) } else { 0.5 * f32::MIN_POSITIVE };
        let d = dir * shrink;
        self.set_scaled(ray, d, scale / longer);
        // Along some axes the ray may not move: it is inside for ever or never, and within a plane it is on both sides.
        for axis in 0..3 {
            if d[axis].abs() < PARALLEL {
                let from = ray.origin[axis];
                let beside = BESIDE.max(from.abs() * (4.0 * f32::EPSILON));
                self.inv[axis] = HUGE;
                self.enter_from[axis] = from + beside;
                self.leave_from[axis] = from - beside;
                self.octant &= !(1 << axis);
                self.stop_factor = f32::INFINITY;
            }
        }
    }

    /// With the direction `d`, which is the ray's divided by `scale`.
    #[inline(always)]
    fn set_scaled(&mut self, ray: &Ray, d: Vec3, scale: f32) {
        let octant = usize::from(d.x < 0.0) | usize::from(d.y < 0.0) << 1 | usize::from(d.z < 0.0) << 2;
        self.set_plain(ray.origin, d.recip().to_array(), octant);
        self.scale = scale;
    }

    /// A ray that [`is_plain`], by the reciprocals of its direction and its octant.
    #[inline(always)]
    pub fn set_plain(&mut self, origin: Vec3, inv: [f32; 3], octant: usize) {
        for axis in 0..3 {
            self.enter_from[axis] = origin[axis];
            self.leave_from[axis] = origin[axis];
            self.inv[axis] = inv[axis];
        }
        self.octant = octant;
        self.stop_factor = 1.0 + 8.0 * RELATIVE_ERROR;
        self.scale = 1.0;
    }

    /// Prepares a ray in other coordinates than those that it was given in, where each of its points may lie beside the computed one
    /// by `blur` on each axis: boxes are entered sooner and left later.
    #[inline(always)]
    pub fn set_blurred(&mut self, origin: [f64; 3], dir: [f64; 3], blur: [f32; 3]) {
        let ray = Ray { origin: DVec3::from(origin).as_vec3(), dir: DVec3::from(dir).as_vec3(), t_max: f32::INFINITY };
        if is_plain(&ray) && ray.origin.abs().max_element() < FAR {
            self.set_scaled(&ray, ray.dir, 1.0);
        } else {
            self.set_blurred_with_care(ray.origin, dir);
        }
        for axis in 0..3 {
            let blur = if self.is_negative(axis) { -blur[axis] } else { blur[axis] };
            self.enter_from[axis] += blur;
            self.leave_from[axis] -= blur;
        }
    }

    /// A direction that f32 may not be able to tell, one that is parallel to an axis, or an origin in the far distance.
    #[cold]
    #[inline(never)]
    fn set_blurred_with_care(&mut self, origin: Vec3, dir: [f64; 3]) {
        let exponent = libm::ilogb(DVec3::from(dir).abs().max_element());
        let dir = dir.map(|d| libm::ldexp(d, -exponent) as f32);
        self.set(&Ray { origin, dir: dir.into(), t_max: f32::INFINITY });
        // Beyond f32's range, distances have no end, or end later than they do.
        let scale = f64::from(self.scale) * libm::ldexp(1.0, exponent);
        self.scale = (scale as f32).max(f32::MIN_POSITIVE);
        let near = origin.abs().max_element() < FAR;
        if !near {
            // Everything is entered at once.
            (self.enter_from, self.leave_from, self.inv) = ([FAR; 3], [-FAR; 3], [1.0; 3]);
            self.octant = 0;
        }
    }

    /// Whether the direction is negative on an axis.
    #[inline(always)]
    pub fn is_negative(&self, axis: usize) -> bool {
        (self.octant >> axis) & 1 == 1
    }

    /// A distance on the ray as a scaled distance, never too small.
    #[inline(always)]
    pub fn scaled(&self, t: f32) -> f32 {
        t * self.scale * GROWTH + f32::MIN_POSITIVE
    }

    /// With cells in the order in which the ray passes them: the factor and the term that make of the limit a distance such
    /// that, when a box is entered beyond it, all later ones are entered beyond the limit. The margin covers rounding, boxes
    /// that the ray only seems to meet, and boxes that reach into each other by twice `thickness`. Infinite for a ray that is
    /// parallel to an axis: it may run within a plane between two cells, where there is no order.
    #[inline(always)]
    pub fn stop(&self, thickness: f32) -> (f32, f32) {
        let [x, y, z] = self.inv.map(f32::abs);
        let steepest = if x > y { x } else { y };
        let steepest = if z > steepest { z } else { steepest };
        (self.stop_factor, 4.0 * thickness * steepest)
    }

    /// The scaled distance at which a plane is reached at the earliest.
    #[inline(always)]
    pub fn enter(&self, axis: usize, plane: f32) -> f32 {
        (plane - self.enter_from[axis]) * self.inv[axis]
    }

    /// The scaled distance at which a plane is left at the latest.
    #[inline(always)]
    pub fn leave(&self, axis: usize, plane: f32) -> f32 {
        (plane - self.leave_from[axis]) * self.inv[axis] * GROWTH
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
