//! Choice among many emitters by what each, or each cluster of them, can bring to a receiver.
//!
//! All children of the root are looked at, then all children of the chosen node, and so on: exact among up to
//! [`ROOT`] emitters, and never further from it than the bounds of clusters are from what they hold. The estimate is made of
//! multiplications only, so that it can be made for sixteen receivers at a time (`clusters_lanes`) with the same numbers.

use super::bounds::EmitterBounds;
use super::tree::{Child, ROOT, wide_nodes};
use glam::Vec3;
use std::f32::consts::PI;

/// Where light is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// The point, in the rays' frame.
    pub point: Vec3,
    /// Unit shading normal on the viewer's side.
    pub normal: Vec3,
    /// Whether light from behind counts as well.
    pub both_sides: bool,
}

/// An emitter that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chosen {
    pub emitter: u32,
    pub probability: f32,
    /// The random number of the choice, stretched for use again.
    pub again: f32,
}

/// Emitters and clusters of them in slots; the children of a node have consecutive ones.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    /// Middle of each one's box.
    pub center: [Vec<f32>; 3],
    /// Radius of the sphere around the box, a little more against rounding.
    pub radius: Vec<f32>,
    /// Middle of the normals; zero where light goes everywhere alike.
    pub axis: [Vec<f32>; 3],
    /// Sine of the angle around the axis that holds all normals, 1 from a right angle on.
    pub spread: Vec<f32>,
    /// −1 where backs emit as well, else 1.
    pub fold: Vec<f32>,
    /// Power over the integral of max(cosine + spread, 0): intensity along the axis.
    pub strength: Vec<f32>,
    /// All of these side by side, [`PACKED`] numbers a slot, for those who look at one slot here and one there.
    pub packed: Vec<f32>,
    /// A node, or [`EMITTER`] and the emitter.
    pub link: Vec<u32>,
    /// The node that each slot belongs to.
    pub node_of: Vec<u32>,
    /// First slot of each node, and one more.
    pub first: Vec<u32>,
    /// The slot that stands for each node in its parent; the root has none.
    pub slot_of: Vec<u32>,
    /// The slot of each emitter.
    pub slot_of_emitter: Vec<u32>,
}

/// Numbers of a slot in [`Clusters::packed`]: middle, radius, axis, spread, fold, strength, and nothing twice.
pub(super) const PACKED: u32 = 12;
/// Marks a link to an emitter.
pub(super) const EMITTER: u32 = 1 << 31;
/// The least square of a distance: what is nearer counts as this near, and nothing overflows.
pub(super) const LEAST_DISTANCE2: f32 = 1e-18;
/// One step of Newton's method leaves the reciprocal square root up to this much too small.
const SHORT: f32 = 1.002;

impl Clusters {
    /// Over emitters in the order of their numbers. Bounds without power are never chosen.
    pub fn new(emitters: &[EmitterBounds]) -> Self {
        let mut all = Self { slot_of_emitter: vec![0; emitters.len()], ..Self::default() };
        let wide = wide_nodes(emitters);
        all.slot_of = vec![0; wide.len()];
        for (node, children) in wide.iter().enumerate() {
            all.first.push(all.link.len() as u32);
            for (bounds, child) in children {
                let slot = all.link.len() as u32;
                all.node_of.push(node as u32);
                all.link.push(match *child {
                    Child::Node(below) => {
                        all.slot_of[below as usize] = slot;
                        below
                    }
                    Child::Emitter(emitter) => {
                        all.slot_of_emitter[emitter as usize] = slot;
                        EMITTER | emitter
                    }
                });
                all.push(bounds);
            }
        }
        all.first.push(all.link.len() as u32);
        all
    }

    fn push(&mut self, bounds: &EmitterBounds) {
        let everywhere = bounds.cos_spread <= -1.0;
        let axis = if everywhere { Vec3::ZERO } else { bounds.axis };
        let spread = if bounds.cos_spread > 0.0 { (1.0 - bounds.cos_spread * bounds.cos_spread).sqrt() } else { 1.0 };
        let integral =
            if bounds.two_sided { 2.0 * PI * (1.0 + 2.0 * spread) } else { PI * (1.0 + spread) * (1.0 + spread) };
        let center = bounds.center();
        for k in 0..3 {
            self.center[k].push(center[k]);
            self.axis[k].push(axis[k]);
        }
        let radius = 0.5 * (bounds.hi - bounds.lo).length();
        // Room for the rounding of places, which lie in a frame of size 1.
        let radius = if radius > 0.0 { radius * 1.0001 + 1e-7 } else { 0.0 };
        let (spread, fold, strength) =
            (spread * SHORT, if bounds.two_sided { -1.0 } else { 1.0 }, bounds.power / integral);
        self.radius.push(radius);
        self.spread.push(spread);
        self.fold.push(fold);
        self.strength.push(strength);
        let ([x, y, z], [u, v, w]) = (center.to_array(), axis.to_array());
        let packed: [f32; PACKED as usize] = [x, y, z, radius, u, v, w, spread, fold, strength, 0.0, 0.0];
        self.packed.extend(packed);
    }

    /// Whether there is nothing to choose.
    pub fn is_empty(&self) -> bool {
        self.link.is_empty()
    }

    /// Running sums over a node's children of what the emitters of each can bring to the receiver: strength · cosine there ·
    /// cosine here / distance², the cosines being the largest of any two points of the bounds. Zero is added only for what
    /// cannot contribute.
    fn sums<'a>(&'a self, node: usize, receiver: &Receiver, room: &'a mut [f32; ROOT]) -> &'a [f32] {
        let slots = self.first[node] as usize..self.first[node + 1] as usize;
        let room = &mut room[..slots.len()];
        // Slices of one length each: the loop below works on several children at a time.
        let all = |values: &'a Vec<f32>| &values[slots.clone()][..room.len()];
        let ([cx, cy, cz], [ax, ay, az]) = (self.center.each_ref().map(all), self.axis.each_ref().map(all));
        let [radius, spread, fold, strength] = [&self.radius, &self.spread, &self.fold, &self.strength].map(all);
        let (p, n) = (receiver.point, receiver.normal);
        let side = if receiver.both_sides { -1.0 } else { 1.0 };
        for (k, importance) in room.iter_mut().enumerate() {
            let (x, y, z) = (cx[k] - p.x, cy[k] - p.y, cz[k] - p.z);
            let distance2 = larger(larger(x * x + y * y + z * z, radius[k] * radius[k]), LEAST_DISTANCE2);
            let inverse = inverse_sqrt(distance2);
            let here = n.x * x + n.y * y + n.z * z;
            let there = -(ax[k] * x + ay[k] * y + az[k] * z);
            let (here, there) = (larger(here, here * side), larger(there, there * fold[k]));
            let here = larger(here + radius[k], 0.0) * inverse;
            let there = larger(there + spread[k] * (distance2 * inverse) + radius[k], 0.0) * inverse;
            *importance = strength[k] * here * there * (inverse * inverse);
        }
        let mut sum = 0.0;
        for importance in room.iter_mut() {
            sum += *importance;
            *importance = sum;
        }
        room
    }

    /// Chooses an emitter with `u` in [0, 1). `None`: none can contribute.
    pub fn sample(&self, receiver: &Receiver, mut u: f32) -> Option<Chosen> {
        let mut room = [0.0; ROOT];
        let (mut node, mut probability) = (0, 1.0);
        if self.is_empty() {
            return None;
        }
        loop {
            let sums = self.sums(node, receiver, &mut room);
            let total = sums[sums.len() - 1];
            if !(total > 0.0) {
                return None;
            }
            // Below the total, whatever the rounding.
            let x = u * (total * BELOW_ONE);
            let k = sums.partition_point(|sum| *sum <= x);
            let before = if k == 0 { 0.0 } else { sums[k - 1] };
            let own = sums[k] - before;
            u = ((x - before) / own).min(BELOW_ONE);
            probability *= own / total;
            let link = self.link[self.first[node] as usize + k];
            if link & EMITTER != 0 {
                return Some(Chosen { emitter: link & !EMITTER, probability, again: u });
            }
            node = link as usize;
        }
    }

    /// The probability with which [`Clusters::sample`] chooses an emitter.
    pub fn probability(&self, receiver: &Receiver, emitter: u32) -> f32 {
        let mut room = [0.0; ROOT];
        let mut slot = self.slot_of_emitter[emitter as usize] as usize;
        let mut probability = 1.0;
        loop {
            let node = self.node_of[slot] as usize;
            let sums = self.sums(node, receiver, &mut room);
            let k = slot - self.first[node] as usize;
            let total = sums[sums.len() - 1];
            let own = sums[k] - if k == 0 { 0.0 } else { sums[k - 1] };
            if !(own > 0.0) {
                return 0.0;
            }
            probability *= own / total;
            if node == 0 {
                return probability;
            }
            slot = self.slot_of[node] as usize;
        }
    }
}

/// Just below 1: two units in the last place.
pub(super) const BELOW_ONE: f32 = 1.0 - f32::EPSILON;

/// The larger one, the second should either not be a number: an instruction of its own, unlike `f32::max`.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// About 1/√x from below, for normal x > 0: an estimate from the bits and one step of Newton's method (Lomont 2003, "Fast
/// Inverse Square Root"). Within 0.18 %; the same number on every machine.
#[inline(always)]
fn inverse_sqrt(x: f32) -> f32 {
    let estimate = f32::from_bits(0x5f37_59df - (x.to_bits() >> 1));
    estimate * (1.5 - 0.5 * x * estimate * estimate)
}

#[cfg(test)]
#[path = "clusters_tests.rs"]
mod tests;
