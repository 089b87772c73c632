//! Sixteen rays in lanes, and what they make of a box and of a triangle.

use super::super::slab::GROWTH;
use super::node::WideNode;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3};
use crate::math::Ray;

/// See `avx512::candidates`: what is left out lies certainly behind a ray's origin or beyond its nearest hit.
const ERROR: f32 = 8.0 / 16_777_216.0;
/// A little for what underflow takes away.
const UNDERFLOW: f32 = 1e-30;

/// Rays in lanes.
pub struct Packet<L: Lanes> {
    origin: V3<L::F>,
    inv: V3<L::F>,
    negative: [L::M; 3],
    /// Along which axes the directions are longest: x, y.
    along: [L::M; 2],
    shear: [L::F; 2],
    dir_z: L::F,
    /// Nearest hits so far, or where rays end.
    pub t: [f32; LANES],
}

impl<L: Lanes> Packet<L> {
    /// Prepares sixteen rays.
    #[inline(always)]
    pub fn new(l: L, rays: &[Ray; LANES]) -> Self {
        let column = |number: fn(&Ray) -> f32| l.load(&std::array::from_fn(|i| number(&rays[i])));
        let origin = V3::new(column(|r| r.origin.x), column(|r| r.origin.y), column(|r| r.origin.z));
        let dir = V3::new(column(|r| r.dir.x), column(|r| r.dir.y), column(|r| r.dir.z));
        let zero = l.splat(0.0);
        let (a, b, c) = (dir.x.abs(), dir.y.abs(), dir.z.abs());
        let along_x = b.le(a) & c.le(a);
        let along = [along_x, !along_x & c.le(b)];
        let [x, y, z] = turn::<L>(along, dir);
        Self {
            origin,
            inv: V3::new(l.splat(1.0) / dir.x, l.splat(1.0) / dir.y, l.splat(1.0) / dir.z),
            negative: [dir.x.lt(zero), dir.y.lt(zero), dir.z.lt(zero)],
            along,
            shear: [x / z, y / z],
            dir_z: z,
            t: std::array::from_fn(|i| rays[i].t_max),
        }
    }

    /// Which rays enter a box before their nearest hits.
    #[inline(always)]
    pub fn enter(&self, l: L, node: &WideNode, slot: usize) -> u32 {
        let (mut enter, mut leave) = (l.splat(0.0), l.splat(f32::INFINITY));
        let rows = [self.origin.x, self.origin.y, self.origin.z];
        let inv = [self.inv.x, self.inv.y, self.inv.z];
        for axis in 0..3 {
            let (lo, hi) = (l.splat(node.planes[axis][slot]), l.splat(node.planes[axis + 3][slot]));
            let near = L::F::select(self.negative[axis], hi, lo);
            let far = L::F::select(self.negative[axis], lo, hi);
            enter = ((near - rows[axis]) * inv[axis]).max(enter);
            leave = ((far - rows[axis]) * inv[axis]).min(leave);
        }
        let limit = l.load(&self.t) * GROWTH + f32::MIN_POSITIVE;
        (enter.le(leave * GROWTH) & enter.le(limit)).bits()
    }

    /// Which rays may meet a triangle of these sheared corners nearer than what they met: at least all that do.
    #[inline(always)]
    pub fn candidates(&self, l: L, corners: &[[L::F; 3]; 3]) -> u32 {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = *corners;
        let (u, u_size) = edge(cx, cy, bx, by);
        let (v, v_size) = edge(ax, ay, cx, cy);
        let (w, w_size) = edge(bx, by, ax, ay);
        let zero = l.splat(0.0);
        let negative = u.lt(zero) | v.lt(zero) | w.lt(zero);
        let positive = zero.lt(u) | zero.lt(v) | zero.lt(w);
        let missed = negative & positive;
        if missed.all() {
            return 0;
        }
        let along = u * az + v * bz + w * cz;
        let size = (u_size * az.abs() + v_size * bz.abs() + w_size * cz.abs()) * ERROR + UNDERFLOW;
        let det = u + v + w;
        let det_size = u_size + v_size + w_size;
        // The distance's sign: that of z along the ray, of the numerator and of the denominator.
        let behind = det.lt(zero) ^ self.dir_z.lt(zero);
        let forward = L::F::select(behind, -along, along);
        let reach = l.load(&self.t) * self.dir_z.abs() * (1.0 + ERROR);
        let end = reach * (det.abs() + det_size * ERROR);
        let out = missed | (forward + size).lt(zero) | end.lt(forward - size);
        (!out).bits()
    }

    /// What shearing makes of a corner.
    #[inline(always)]
    pub fn sheared(&self, l: L, corner: [f32; 3]) -> [L::F; 3] {
        let at = V3::new(
            l.splat(corner[0]) - self.origin.x,
            l.splat(corner[1]) - self.origin.y,
            l.splat(corner[2]) - self.origin.z,
        );
        let [x, y, z] = turn::<L>(self.along, at);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// Components in the order of `ShearedRay::axes`.
#[inline(always)]
fn turn<L: Lanes>([along_x, along_y]: [L::M; 2], v: V3<L::F>) -> [L::F; 3] {
    let [x, y, z] = [v.x, v.y, v.z];
    // Often all agree.
    if along_x.all() {
        return [y, z, x];
    }
    if along_x.none() && along_y.all() {
        return [z, x, y];
    }
    if along_x.none() && along_y.none() {
        return [x, y, z];
    }
    [
        L::F::select(along_x, y, L::F::select(along_y, z, x)),
        L::F::select(along_x, z, L::F::select(along_y, x, y)),
        L::F::select(along_x, x, L::F::select(along_y, y, z)),
    ]
}

/// An edge function, and the sum of its two products' magnitudes.
#[inline(always)]
fn edge<F: Floats>(px: F, py: F, qx: F, qy: F) -> (F, F) {
    let (one, other) = (px * qy, py * qx);
    (one - other, one.abs() + other.abs())
}
