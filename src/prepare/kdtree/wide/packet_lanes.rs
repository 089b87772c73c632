//! Sixteen rays in lanes, and what they make of a box and of a triangle.

use super::super::batch::{NO_TRIANGLE, RayBatch};
use super::super::slab::{self, GROWTH};
use super::node::WideNode;
use super::packet_exact::Met;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};

/// See `avx512::candidates`: what is left out lies certainly behind a ray's origin or beyond its nearest hit.
const ERROR: f32 = 8.0 / 16_777_216.0;
/// A little for what underflow takes away.
const UNDERFLOW: f32 = 1e-30;
/// What is surely before a ray's origin: its distance is a positive number in f32 for any direction of usual length.
const SURELY_BEFORE: f32 = 1e-20;

/// Rays in lanes.
pub struct Packet<L: Lanes> {
    origin: V3<L::F>,
    inv: V3<L::F>,
    negative: [L::M; 3],
    /// Along which axes the directions are longest: x, y.
    along: [L::M; 2],
    shear: [L::F; 2],
    dir_z: L::F,
    /// Reciprocals of `dir_z`.
    pub inv_dir_z: [f64; LANES],
    /// Rays of usual length, parallel to no axis; the others mean nothing.
    pub plain: u32,
    /// What a ray leaves and what it reaches.
    barred: L::U,
    /// The nearest triangles so far, with their corners, sheared; or [`NO_TRIANGLE`].
    triangle: L::U,
    corners: [[L::F; 3]; 3],
    /// Bounds on the distance of that hit, or where the ray ends.
    low: L::F,
    high: L::F,
}

/// What f32 says of sixteen rays and a triangle.
pub struct Seen<L: Lanes> {
    /// May meet it, nearer than what they met so far: at least all that do.
    pub possible: L::M,
    /// Meet it nearer, for certain.
    pub sure: L::M,
    /// Bounds on numerator and denominator of the distance.
    numerator: [L::F; 2],
    denominator: [L::F; 2],
}

impl<L: Lanes> Packet<L> {
    /// Prepares sixteen rays of a batch, or those that are left of it and the last one again.
    #[inline(always)]
    pub fn new(l: L, rays: &RayBatch, first: usize) -> Self {
        let [ox, oy, oz] = rays.origin;
        let [dx, dy, dz] = rays.dir;
        let origin = V3::new(column(l, ox, first), column(l, oy, first), column(l, oz, first));
        let dir = V3::new(column(l, dx, first), column(l, dy, first), column(l, dz, first));
        let t_max = column(l, rays.t_max, first);
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (a, b, c) = (dir.x.abs(), dir.y.abs(), dir.z.abs());
        let (longest, shortest) = (a.max(b).max(c), a.min(b).min(c));
        let [least, most] = slab::PLAIN;
        let plain = longest.ge(l.splat(least)) & longest.le(l.splat(most)) & shortest.ge(l.splat(slab::PARALLEL));
        let along_x = b.le(a) & c.le(a);
        let along = [along_x, !along_x & c.le(b)];
        let [x, y, z] = turn::<L>(along, dir);
        let (long, mut inv_dir_z) = (z.array(), [0.0; LANES]);
        for i in 0..LANES {
            inv_dir_z[i] = 1.0 / f64::from(long[i]);
        }
        Self {
            origin,
            inv: V3::new(one / dir.x, one / dir.y, one / dir.z),
            negative: [dir.x.lt(zero), dir.y.lt(zero), dir.z.lt(zero)],
            along,
            shear: [x / z, y / z],
            dir_z: z,
            inv_dir_z,
            plain: plain.bits(),
            barred: words(l, rays.reaches, first),
            triangle: l.word(NO_TRIANGLE),
            corners: [[zero; 3]; 3],
            low: t_max,
            high: t_max,
        }
    }

    /// The octant of a ray's direction: bits for negative x, y, z.
    #[inline(always)]
    pub fn octant(&self, lane: u32) -> usize {
        let [x, y, z] = self.negative;
        let bit = |m: L::M| (m.bits() >> (lane % LANES as u32) & 1) as usize;
        bit(x) | bit(y) << 1 | bit(z) << 2
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
        let limit = self.high * GROWTH + f32::MIN_POSITIVE;
        (enter.le(leave * GROWTH) & enter.le(limit)).bits()
    }

    /// Which rays a triangle does not count for.
    #[inline(always)]
    pub fn bars(&self, triangle: L::U) -> L::M {
        triangle.eq(self.barred)
    }

    /// What can be said of a triangle of these sheared corners; `None` if no ray meets it.
    ///
    /// An edge function that is not zero in f32 has the right sign. The bounds on the distance are those of
    /// `avx512::candidates`, on both sides.
    #[inline(always)]
    pub fn candidates(&self, l: L, corners: &[[L::F; 3]; 3]) -> Option<Seen<L>> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = *corners;
        let (u, u_size) = edge(cx, cy, bx, by);
        let (v, v_size) = edge(ax, ay, cx, cy);
        let (w, w_size) = edge(bx, by, ax, ay);
        let zero = l.splat(0.0);
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        let missed = least.lt(zero) & most.gt(zero);
        if missed.all() {
            return None;
        }
        let within = least.gt(zero) | most.lt(zero);
        let along = u * az + v * bz + w * cz;
        let size = (u_size * az.abs() + v_size * bz.abs() + w_size * cz.abs()) * ERROR + UNDERFLOW;
        let det = u + v + w;
        let det_error = (u_size + v_size + w_size) * ERROR;
        // The distance's sign: that of z along the ray, of the numerator and of the denominator.
        let behind = det.lt(zero) ^ self.dir_z.lt(zero);
        let forward = L::F::select(behind, -along, along);
        let numerator = [forward - size, forward + size];
        let denominator = [(det.abs() - det_error) * self.dir_z.abs(), (det.abs() + det_error) * self.dir_z.abs()];
        let out = missed | numerator[1].lt(zero) | (self.high * (1.0 + ERROR) * denominator[1]).lt(numerator[0]);
        let nearer = numerator[1].lt(self.low * (1.0 - ERROR) * denominator[0]);
        let sure = within & numerator[0].gt(l.splat(SURELY_BEFORE)) & nearer;
        Some(Seen { possible: !out, sure: sure & !out, numerator, denominator })
    }

    /// Keeps a triangle as the nearest of the rays that surely meet it.
    #[inline(always)]
    pub fn take_sure<const ANY: bool>(
        &mut self,
        l: L,
        rays: L::M,
        corners: &[[L::F; 3]; 3],
        triangle: L::U,
        seen: &Seen<L>,
    ) {
        if !ANY {
            let low = seen.numerator[0] / seen.denominator[1] * (1.0 - ERROR);
            let high = seen.numerator[1] / seen.denominator[0] * (1.0 + ERROR);
            self.low = L::F::select(rays, low, self.low);
            self.high = L::F::select(rays, high, self.high);
        }
        self.keep(l, rays, corners, triangle);
    }

    /// Of some rays those that meet a triangle before what they met so far, or at the same distance and the triangle has a
    /// lower number: [`Nearest::improves`](crate::math::triangle::Nearest::improves).
    #[inline(always)]
    pub fn better(&mut self, l: L, rays: L::M, met: &Met) -> L::M {
        let known = !self.triangle.eq(l.word(NO_TRIANGLE));
        if (rays & known & !self.low.eq(self.high)).any() {
            let before = l.load(&Met::new(l, &self.corners, &self.inv_dir_z, self.triangle).t);
            self.low = L::F::select(known, before, self.low);
            self.high = L::F::select(known, before, self.high);
        }
        let t = l.load(&met.t);
        let equal = t.eq(self.high) & known & l.load_words(&met.triangle).lt(self.triangle);
        rays & met.any(l) & t.gt(l.splat(0.0)) & (t.lt(self.high) | equal)
    }

    /// Keeps a triangle as the nearest of rays by their hits.
    #[inline(always)]
    pub fn take(&mut self, l: L, rays: L::M, corners: &[[L::F; 3]; 3], triangle: L::U, met: &Met) {
        let t = l.load(&met.t);
        self.low = L::F::select(rays, t, self.low);
        self.high = L::F::select(rays, t, self.high);
        self.keep(l, rays, corners, triangle);
    }

    #[inline(always)]
    fn keep(&mut self, l: L, rays: L::M, corners: &[[L::F; 3]; 3], triangle: L::U) {
        let _ = l;
        self.triangle = L::U::select(rays, triangle, self.triangle);
        for (own, new) in self.corners.iter_mut().zip(corners) {
            for (own, new) in own.iter_mut().zip(new) {
                *own = L::F::select(rays, *new, *own);
            }
        }
    }

    /// Where the rays meet the nearest triangles.
    #[inline(always)]
    pub fn met(&self, l: L) -> Met {
        Met::new(l, &self.corners, &self.inv_dir_z, self.triangle)
    }

    /// The triangles alone, for rays that only ask for one.
    #[inline(always)]
    pub fn met_somewhere(&self) -> Met {
        let none = [0.0; LANES];
        Met { t: none, b1: none, b2: none, triangle: self.triangle.array() }
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

/// Sixteen numbers of a row, the last one again where it ends.
#[inline(always)]
fn column<L: Lanes>(l: L, row: &[f32], first: usize) -> L::F {
    if row.len() >= first + LANES {
        return l.load_at(row, first);
    }
    let mut all = [0.0; LANES];
    for (i, x) in all.iter_mut().enumerate() {
        *x = row[(first + i).min(row.len() - 1)];
    }
    l.load(&all)
}

/// Sixteen triangles of a row, which may be empty or end before.
#[inline(always)]
fn words<L: Lanes>(l: L, row: &[u32], first: usize) -> L::U {
    if row.len() >= first + LANES {
        return l.load_words_at(row, first);
    }
    let mut all = [NO_TRIANGLE; LANES];
    for (i, x) in all.iter_mut().enumerate().take(row.len().saturating_sub(first)) {
        *x = row[first + i];
    }
    l.load_words(&all)
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
