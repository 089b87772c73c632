//! Sixteen rays side by side through the same nodes: for scenes of few triangles, and for rays that go like ways.
//!
//! A packet goes where any of its rays goes. Each box and each triangle is tested against all rays at once; what a ray may meet is
//! then tested one by one, exactly, as everywhere.

use super::super::batch::{NO_TRIANGLE, RayBatch};
use super::super::block::Block;
use super::super::slab::{GROWTH, is_plain};
use super::super::split::MAX_DEPTH;
use super::node::{Child, WIDTH, WideNode};
use super::{AnyKernel, WideTree};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Work};
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};
use glam::Vec3;

/// See `avx512::candidates`: what is left out lies certainly behind a ray's origin or beyond its nearest hit.
const ERROR: f32 = 8.0 / 16_777_216.0;
/// A little for what underflow takes away.
const UNDERFLOW: f32 = 1e-30;

/// The rays of a batch in packets; with `ANY`, whichever hit is found first.
pub struct Packets<'a, const ANY: bool, Stops, Found> {
    /// For rays that are parallel to an axis or of unusual length: they go alone.
    pub kernel: AnyKernel,
    /// What is traversed.
    pub tree: WideTree<'a>,
    /// The batch.
    pub rays: &'a RayBatch<'a>,
    /// Which hits count.
    pub stops: Stops,
    /// Is told what each ray found.
    pub found: Found,
}

/// A node on the way: the next of its children, in the packet's order, and the rays that enter it.
#[derive(Clone, Copy, Default)]
struct Visit {
    node: u32,
    place: u32,
    rays: u32,
}

/// Rays in lanes.
struct Packet<L: Lanes> {
    origin: V3<L::F>,
    inv: V3<L::F>,
    negative: [L::M; 3],
    /// Along which axes the directions are longest: x, y.
    along: [L::M; 2],
    shear: [L::F; 2],
    dir_z: L::F,
    /// Nearest hits so far, or where rays end.
    t: [f32; LANES],
}

impl<const ANY: bool, Stops, Found> Work for Packets<'_, ANY, Stops, Found>
where
    Stops: FnMut(usize, &Hit) -> bool,
    Found: FnMut(usize, Option<Hit>),
{
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        for first in (0..self.rays.len()).step_by(LANES) {
            self.packet(l, first);
        }
    }
}

impl<const ANY: bool, Stops, Found> Packets<'_, ANY, Stops, Found>
where
    Stops: FnMut(usize, &Hit) -> bool,
    Found: FnMut(usize, Option<Hit>),
{
    #[inline(always)]
    fn packet<L: Lanes>(&mut self, l: L, first: usize) {
        let count = LANES.min(self.rays.len() - first);
        let rays: [Ray; LANES] = std::array::from_fn(|i| self.rays.ray(first + i.min(count - 1)));
        let mut alive = 0u32;
        for (i, ray) in rays[..count].iter().enumerate() {
            alive |= u32::from(is_plain(ray)) << i;
        }
        let odd = !alive & ((1 << count) - 1);
        for i in (0..count).filter(|i| odd >> i & 1 == 1) {
            let barred = self.rays.barred(first + i);
            let stops = &mut self.stops;
            let accept = |hit: &Hit| !barred.contains(&hit.triangle) && stops(first + i, hit);
            let hit = self.kernel.nearest::<ANY>(self.tree, &rays[i], accept);
            (self.found)(first + i, hit);
        }
        let mut packet = Packet::new(l, &rays);
        let sheared: [ShearedRay; LANES] = std::array::from_fn(|i| ShearedRay::new(&rays[i]));
        let mut nearest: [Nearest; LANES] = std::array::from_fn(|i| Nearest::new(&rays[i]));
        let members = alive;
        let octant = octant(rays[members.trailing_zeros() as usize % LANES].dir);
        let mut visits = [Visit::default(); MAX_DEPTH as usize + 2];
        visits[0] = Visit { node: 0, place: 0, rays: members };
        let mut depth = usize::from(!self.tree.nodes.is_empty());
        while depth > 0 && alive != 0 {
            let visit = &mut visits[depth - 1];
            let node = &self.tree.nodes[visit.node as usize];
            if visit.place >= WIDTH as u32 {
                depth -= 1;
                continue;
            }
            let slot = node.slot(octant, visit.place as usize);
            visit.place += 1;
            let entering = packet.enter(l, node, slot) & visit.rays & alive;
            if entering == 0 {
                continue;
            }
            match Child::decode(node.children[slot], node.leaf_base, |place| self.tree.leaves.large(place)) {
                Child::Node(child) => {
                    visits[depth] = Visit { node: child, place: 0, rays: entering };
                    depth += 1;
                }
                Child::Leaf(leaf) => {
                    for block in self.tree.leaves.blocks(leaf) {
                        alive &= !self.test(l, &mut packet, &block, entering & alive, first, &sheared, &mut nearest);
                    }
                }
            }
        }
        for i in (0..count).filter(|i| members >> i & 1 == 1) {
            (self.found)(first + i, nearest[i].hit);
        }
    }

    /// Tests a block; with `ANY`, the rays that met something.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the parts of one loop")]
    fn test<L: Lanes>(
        &mut self,
        l: L,
        packet: &mut Packet<L>,
        block: &Block,
        rays: u32,
        first: usize,
        sheared: &[ShearedRay; LANES],
        nearest: &mut [Nearest; LANES],
    ) -> u32 {
        let mut ended = 0;
        for i in 0..block.len {
            let corners = block.corners(i).map(|corner| packet.sheared(l, corner));
            let mut candidates = packet.candidates(l, &corners) & rays & !ended;
            if candidates == 0 {
                continue;
            }
            let corners = corners.map(|corner| corner.map(L::F::array));
            while candidates != 0 {
                let lane = candidates.trailing_zeros() as usize;
                candidates &= candidates - 1;
                let triangle = block.triangle(i);
                if self.rays.barred(first + lane).contains(&triangle) && triangle != NO_TRIANGLE {
                    continue;
                }
                let corners = corners.each_ref().map(|corner| corner.each_ref().map(|row| row[lane]));
                if let Some(hit) = sheared[lane].meet_sheared(corners, triangle)
                    && nearest[lane].improves(&hit)
                    && (self.stops)(first + lane, &hit)
                {
                    nearest[lane].take(hit);
                    packet.t[lane] = hit.t;
                    ended |= u32::from(ANY) << lane;
                }
            }
        }
        ended
    }
}

impl<L: Lanes> Packet<L> {
    #[inline(always)]
    fn new(l: L, rays: &[Ray; LANES]) -> Self {
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
    fn enter(&self, l: L, node: &WideNode, slot: usize) -> u32 {
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
    fn candidates(&self, l: L, corners: &[[L::F; 3]; 3]) -> u32 {
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
    fn sheared(&self, l: L, corner: [f32; 3]) -> [L::F; 3] {
        let at = V3::new(
            l.splat(corner[0]) - self.origin.x,
            l.splat(corner[1]) - self.origin.y,
            l.splat(corner[2]) - self.origin.z,
        );
        let [x, y, z] = turn::<L>(self.along, at);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// Components in the order of [`ShearedRay::axes`].
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

/// The octant of a direction: bits for negative x, y, z.
fn octant(dir: Vec3) -> usize {
    usize::from(dir.x < 0.0) | usize::from(dir.y < 0.0) << 1 | usize::from(dir.z < 0.0) << 2
}
