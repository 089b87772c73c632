//! Sixteen rays side by side through the same nodes: for scenes of few triangles, and for rays that go like ways.
//!
//! A packet goes where any of its rays goes. Each box and each triangle is tested against all rays at once, in f32 with bounds
//! on the error ([`super::packet_lines`]): what is certain by them needs nothing else, and the rest is decided exactly, as
//! everywhere ([`super::packet_exact`]). So is, in the end, where the nearest triangle is met.

use super::super::batch::{Found, RayBatch};
use super::super::split::{BLOCK, MAX_DEPTH};
use super::node::{Child, WIDTH};
use super::packet_exact::Met;
use super::packet_kept::{KeptLines, TreeNumber};
use super::packet_lanes::Packet;
use super::packet_lines::Lines;
use super::packet_table::LinesTable;
use super::{AnyKernel, WideTree};
use crate::lanes::{LANES, Lanes, Mask, Work};
use crate::math::Hit;

/// What is known of the lines of a tree's blocks.
#[derive(Debug)]
pub enum BlockLines {
    /// All of them.
    All(LinesTable),
    /// Those that a thread has visited lately, of the tree that has this number.
    Lately(TreeNumber),
}

/// The rays of a batch in packets; with `ANY`, whichever hit is found first; with `ALL`, every hit counts.
pub struct Packets<'a, const ANY: bool, const ALL: bool, Stops, To> {
    /// For rays that are parallel to an axis or of unusual length: they go alone.
    pub kernel: AnyKernel,
    /// What is traversed.
    pub tree: WideTree<'a>,
    /// The lines of its blocks.
    pub lines: &'a BlockLines,
    /// The batch.
    pub rays: &'a RayBatch<'a>,
    /// Which hits count; not asked if all do.
    pub stops: Stops,
    /// Is told what each ray found.
    pub found: To,
}

/// A node on the way: the next of its children, in the packet's order, and the rays that enter it.
#[derive(Clone, Copy, Default)]
struct Visit {
    node: u32,
    place: u32,
    rays: u32,
}

impl<const ANY: bool, const ALL: bool, Stops, To> Work for Packets<'_, ANY, ALL, Stops, To>
where
    Stops: FnMut(usize, &Hit) -> bool,
    To: Found,
{
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, l: L) {
        let mut kept = match self.lines {
            BlockLines::All(_) => None,
            BlockLines::Lately(number) => Some(KeptLines::take(*number, self.tree.nodes)),
        };
        for first in (0..self.rays.len()).step_by(LANES) {
            self.packet(l, kept.as_deref_mut(), first);
        }
        if let Some(kept) = kept {
            kept.leave();
        }
    }
}

impl<const ANY: bool, const ALL: bool, Stops, To> Packets<'_, ANY, ALL, Stops, To>
where
    Stops: FnMut(usize, &Hit) -> bool,
    To: Found,
{
    #[inline(always)]
    fn packet<L: Lanes>(&mut self, l: L, mut kept: Option<&mut KeptLines>, first: usize) {
        let count = LANES.min(self.rays.len() - first);
        let mut packet = Packet::new(l, self.rays, first);
        let members = packet.plain & ((1 << count) - 1);
        for i in (0..count).filter(|i| members >> i & 1 == 0) {
            self.alone(first + i);
        }
        let mut alive = members;
        let octant = packet.octant(members.trailing_zeros());
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
            // Beyond them nothing is entered.
            if slot >= node.count as usize {
                continue;
            }
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
                    let mut blocks = self.tree.leaves.blocks(leaf);
                    for k in 0..(leaf.count as usize).div_ceil(BLOCK) {
                        let lines = match (self.lines, &mut kept) {
                            (BlockLines::All(table), _) => table.of(leaf, k),
                            (_, Some(kept)) => match blocks.next() {
                                Some(block) => kept.of(l, &block),
                                None => break,
                            },
                            (_, None) => break,
                        };
                        packet.turn_to(l, lines);
                        let ended = self.test(l, &mut packet, lines, entering & alive, first);
                        alive &= !ended;
                    }
                }
            }
        }
        let met = if ANY { packet.met_somewhere() } else { packet.met(l) };
        if members == 0xFFFF {
            return self.found.sixteen(first, &met);
        }
        for i in (0..count).filter(|i| members >> i & 1 == 1) {
            self.found.one(first + i, met.hit(i));
        }
    }

    /// A ray that goes alone.
    #[cold]
    fn alone(&mut self, i: usize) {
        let (ray, barred) = (self.rays.ray(i), self.rays.barred(i));
        let stops = &mut self.stops;
        let accept = |hit: &Hit| hit.triangle != barred && (ALL || stops(i, hit));
        let hit = self.kernel.nearest::<ANY>(self.tree, &ray, accept);
        self.found.one(i, hit);
    }

    /// Tests a block; with `ANY`, gives the rays that met something.
    #[inline(always)]
    fn test<L: Lanes>(&mut self, l: L, packet: &mut Packet<L>, lines: &Lines, rays: u32, first: usize) -> u32 {
        let mut going = l.mask(rays);
        let between = packet.between(l, lines, rays);
        let mut triangles = between.triangles;
        while triangles != 0 {
            let i = triangles.trailing_zeros() as usize % LANES;
            triangles &= triangles - 1;
            let [sure, open] = packet.meet::<ANY, ALL>(l, going, &between, (lines, i));
            let mut better = l.mask(0);
            if open.any() {
                let met = packet.meet_exactly(l, lines, i);
                better = packet.better(l, open, &met);
                if !ALL {
                    better = l.mask(self.stopping(better.bits(), first, &met));
                }
                packet.take::<ANY>(l, better, &met, lines, i);
            }
            if ANY {
                going = going & !(sure | better);
                if going.none() {
                    return rays;
                }
            }
        }
        rays & !going.bits()
    }

    /// Which of the hits count.
    #[inline(never)]
    fn stopping(&mut self, lanes: u32, first: usize, met: &Met) -> u32 {
        let counts = |i: &usize| lanes >> i & 1 == 1 && met.hit(*i).is_some_and(|hit| (self.stops)(first + i, &hit));
        (0..LANES).filter(counts).map(|i| 1 << i).sum()
    }
}
