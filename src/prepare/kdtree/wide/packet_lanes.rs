//! Sixteen rays in lanes, and what they make of a box and of a triangle.

use super::super::batch::{NO_TRIANGLE, RayBatch};
use super::super::slab::{self, GROWTH};
use super::node::WideNode;
use super::packet_exact::Met;
use super::packet_lines::{Between, Frame, Lines, surely_ahead};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};

/// Rays in lanes.
pub struct Packet<L: Lanes> {
    origin: V3<L::F>,
    dir: V3<L::F>,
    inv: V3<L::F>,
    negative: [L::M; 3],
    /// Along which axes the directions are longest: x, y.
    along: [L::M; 2],
    shear: [L::F; 2],
    /// Reciprocals of the directions' longest components.
    inv_dir_z: [f64; LANES],
    /// The rays as the lines of a block see them.
    frame: Frame<L>,
    /// Rays of usual length, parallel to no axis; the others mean nothing.
    pub plain: u32,
    /// What a ray reaches, and what it leaves.
    barred: [L::U; 2],
    /// The nearest triangles so far, with their corners; or [`NO_TRIANGLE`].
    triangle: L::U,
    corners: [V3<L::F>; 3],
    /// Bounds on the distance of that hit, or where the ray ends.
    low: L::F,
    high: L::F,
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
            dir,
            inv: V3::new(one / dir.x, one / dir.y, one / dir.z),
            negative: [dir.x.lt(zero), dir.y.lt(zero), dir.z.lt(zero)],
            along,
            shear: [x / z, y / z],
            inv_dir_z,
            frame: Frame::none(l),
            plain: plain.bits(),
            barred: [words(l, rays.reaches, first), words(l, rays.leaves, first)],
            triangle: l.word(NO_TRIANGLE),
            corners: [V3::splat(zero); 3],
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

    /// Makes the rays count from where the lines of a block do.
    #[inline(always)]
    pub fn turn_to(&mut self, l: L, lines: &Lines) {
        self.frame.turn_to(l, lines, self.origin, self.dir);
    }

    /// What the edges of triangles tell of some of the rays.
    #[inline(always)]
    pub fn between(&self, l: L, lines: &Lines, rays: u32) -> Between {
        self.frame.between(l, lines, rays)
    }

    /// Of some rays, by what the edges of the i-th triangle of these lines tell, those that may meet it nearer than what they
    /// met so far: at least all that do. With `ALL`, those of them that surely do are kept aside: they have met it.
    #[inline(always)]
    pub fn meet<const ANY: bool, const ALL: bool>(
        &mut self,
        l: L,
        rays: L::M,
        between: &Between,
        (lines, i): (&Lines, usize),
    ) -> [L::M; 2] {
        let triangle = l.word(lines.number(i));
        let barred = triangle.eq(self.barred[0]) | triangle.eq(self.barred[1]);
        let open = rays & l.mask(between.possible[i]) & !barred;
        // Rays pass through the triangles that they leave and reach; often nobody else does.
        if open.none() {
            return [open, open];
        }
        let ([low, high], certain) = self.frame.distance(l, lines, i);
        let behind = high.lt(l.splat(0.0)) | self.high.lt(low);
        let open = open & !(certain & behind);
        if !ALL {
            return [l.mask(0), open];
        }
        let ahead = surely_ahead(l, low) & high.lt(self.low);
        let sure = open & certain & l.mask(between.sure[i]) & ahead;
        if sure.any() {
            if !ANY {
                self.low = L::F::select(sure, low, self.low);
                self.high = L::F::select(sure, high, self.high);
            }
            self.keep::<ANY>(l, sure, lines, i);
        }
        [sure, open & !sure]
    }

    /// Where rays' lines meet the i-th triangle of these lines.
    #[inline(always)]
    pub fn meet_exactly(&self, l: L, lines: &Lines, i: usize) -> Met {
        self.exactly(l, lines.corners(l, i), l.word(lines.number(i)))
    }

    #[inline(always)]
    fn exactly(&self, l: L, corners: [V3<L::F>; 3], triangle: L::U) -> Met {
        let [a, b, c] = corners;
        Met::new(l, &[self.sheared(a), self.sheared(b), self.sheared(c)], &self.inv_dir_z, triangle)
    }

    /// Of some rays those that meet a triangle before what they met so far, or at the same distance and the triangle has a
    /// lower number: [`Nearest::improves`](crate::math::triangle::Nearest::improves).
    #[inline(always)]
    pub fn better(&mut self, l: L, rays: L::M, met: &Met) -> L::M {
        let known = !self.triangle.eq(l.word(NO_TRIANGLE));
        if (rays & known & !self.low.eq(self.high)).any() {
            let before = l.load(&self.met(l).t);
            self.low = L::F::select(known, before, self.low);
            self.high = L::F::select(known, before, self.high);
        }
        let t = l.load(&met.t);
        let equal = t.eq(self.high) & known & l.load_words(&met.triangle).lt(self.triangle);
        rays & met.any(l) & t.gt(l.splat(0.0)) & (t.lt(self.high) | equal)
    }

    /// Keeps the i-th triangle of these lines as the nearest of rays by their hits.
    #[inline(always)]
    pub fn take<const ANY: bool>(&mut self, l: L, rays: L::M, met: &Met, lines: &Lines, i: usize) {
        let t = l.load(&met.t);
        self.low = L::F::select(rays, t, self.low);
        self.high = L::F::select(rays, t, self.high);
        self.keep::<ANY>(l, rays, lines, i);
    }

    /// With `ANY`, nobody will ask for the corners.
    #[inline(always)]
    fn keep<const ANY: bool>(&mut self, l: L, rays: L::M, lines: &Lines, i: usize) {
        self.triangle = L::U::select(rays, l.word(lines.number(i)), self.triangle);
        if ANY {
            return;
        }
        for (own, corner) in self.corners.iter_mut().zip(lines.corners(l, i)) {
            *own = V3::select(rays, corner, *own);
        }
    }

    /// Where the rays meet the nearest triangles.
    #[inline(always)]
    pub fn met(&self, l: L) -> Met {
        self.exactly(l, self.corners, self.triangle)
    }

    /// The triangles alone, for rays that only ask for one.
    #[inline(always)]
    pub fn met_somewhere(&self) -> Met {
        let none = [0.0; LANES];
        Met { t: none, b1: none, b2: none, triangle: self.triangle.array() }
    }

    /// What shearing makes of corners.
    #[inline(always)]
    fn sheared(&self, corner: V3<L::F>) -> [L::F; 3] {
        let [x, y, z] = turn::<L>(self.along, corner - self.origin);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// Sixteen numbers of a row, the last one again where it ends.
#[inline(always)]
pub fn column<L: Lanes>(l: L, row: &[f32], first: usize) -> L::F {
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
