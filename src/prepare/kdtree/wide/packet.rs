//! Sixteen rays side by side through the same nodes: for scenes of few triangles, and for rays that go like ways.
//!
//! A packet goes where any of its rays goes. Each box and each triangle is tested against all rays at once; what a ray may meet is
//! then tested one by one, exactly, as everywhere.

use super::super::batch::{NO_TRIANGLE, RayBatch};
use super::super::block::Block;
use super::super::slab::is_plain;
use super::super::split::MAX_DEPTH;
use super::node::{Child, WIDTH};
use super::packet_lanes::Packet;
use super::{AnyKernel, WideTree};
use crate::lanes::{Floats, LANES, Lanes, Work};
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Ray};
use glam::Vec3;

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

/// The octant of a direction: bits for negative x, y, z.
fn octant(dir: Vec3) -> usize {
    usize::from(dir.x < 0.0) | usize::from(dir.y < 0.0) << 1 | usize::from(dir.z < 0.0) << 2
}
