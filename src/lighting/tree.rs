//! Choice among many emitters by a tree of bounds on place, direction and power
//! (Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"; pbrt 4ed, 12.6.3).

use super::bounds::EmitterBounds;
use glam::Vec3;

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

#[derive(Clone, Debug)]
struct Node {
    bounds: EmitterBounds,
    /// The second child of an inner node (the first one follows its parent), or `LEAF | emitter`.
    link: u32,
}

const LEAF: u32 = 1 << 31;
/// Below this depth cells are halved by count, so that no branch is longer than the bits of a trail.
const MOST_UNEVEN: u32 = 24;
const BUCKETS: usize = 12;

/// A binary tree over emitters; a stochastic descent chooses one by its estimated contribution.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// For each emitter the way to its leaf: bit `k` says which child is taken at depth `k`.
    trails: Vec<u64>,
}

impl LightTree {
    /// Over emitters in the order of their numbers. Bounds without power are never chosen.
    pub fn new(emitters: &[EmitterBounds]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * emitters.len()), trails: vec![0; emitters.len()] };
        let mut items: Vec<u32> = (0..emitters.len() as u32).collect();
        if !items.is_empty() {
            tree.build(emitters, &mut items, 0, 0);
        }
        tree
    }

    fn build(&mut self, emitters: &[EmitterBounds], items: &mut [u32], depth: u32, trail: u64) {
        let at = self.nodes.len();
        if let [only] = items {
            self.trails[*only as usize] = trail;
            self.nodes.push(Node { bounds: emitters[*only as usize], link: LEAF | *only });
            return;
        }
        let bounds = items.iter().map(|i| emitters[*i as usize]).reduce(|a, b| a.union(&b)).unwrap_or_default();
        self.nodes.push(Node { bounds, link: 0 });
        let middle = split(emitters, items, depth);
        let (left, right) = items.split_at_mut(middle);
        self.build(emitters, left, depth + 1, trail);
        self.nodes[at].link = self.nodes.len() as u32;
        self.build(emitters, right, depth + 1, trail | 1 << depth);
    }

    /// Probability of the second child, when any of both can contribute.
    fn second_share(&self, at: usize, receiver: &Receiver) -> Option<f32> {
        let first = self.nodes[at + 1].bounds.importance(receiver);
        let second = self.nodes[self.nodes[at].link as usize].bounds.importance(receiver);
        let sum = first + second;
        (sum > 0.0 && sum.is_finite()).then(|| second / sum)
    }

    /// Chooses an emitter with `u` in [0, 1): its number and probability. `None`: none can contribute.
    pub fn sample(&self, receiver: &Receiver, u: f32) -> Option<(usize, f32)> {
        let (mut at, mut u, mut probability) = (0, f64::from(u), 1.0);
        if self.nodes.len() == 1 && self.nodes[0].bounds.importance(receiver) <= 0.0 {
            return None;
        }
        loop {
            let link = self.nodes.get(at)?.link;
            if link & LEAF != 0 {
                return Some(((link & !LEAF) as usize, probability));
            }
            let share = self.second_share(at, receiver)?;
            let first = 1.0 - f64::from(share);
            if u < first {
                at += 1;
                u /= first;
                probability *= 1.0 - share;
            } else {
                at = link as usize;
                u = (u - first) / f64::from(share);
                probability *= share;
            }
            u = u.min(1.0 - f64::EPSILON);
        }
    }

    /// The probability with which [`LightTree::sample`] chooses an emitter.
    pub fn probability(&self, receiver: &Receiver, emitter: usize) -> f32 {
        let (mut at, mut trail, mut probability) = (0, self.trails[emitter], 1.0);
        if self.nodes.len() == 1 {
            return if self.nodes[0].bounds.importance(receiver) > 0.0 { 1.0 } else { 0.0 };
        }
        loop {
            let link = self.nodes[at].link;
            if link & LEAF != 0 {
                return probability;
            }
            let Some(share) = self.second_share(at, receiver) else { return 0.0 };
            if trail & 1 == 0 {
                at += 1;
                probability *= 1.0 - share;
            } else {
                at = link as usize;
                probability *= share;
            }
            trail >>= 1;
        }
    }
}

/// Orders `items` so that the first part goes to the first child; gives its length, neither 0 nor all.
fn split(emitters: &[EmitterBounds], items: &mut [u32], depth: u32) -> usize {
    let half = items.len() / 2;
    let center = |i: &u32| emitters[*i as usize].center();
    let (lo, hi) =
        items.iter().map(center).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), c| (lo.min(c), hi.max(c)));
    let extent = hi - lo;
    if depth >= MOST_UNEVEN || !(extent.max_element() > 0.0) {
        return half;
    }
    let bucket = |axis: usize, i: &u32| {
        let x = (center(i)[axis] - lo[axis]) / extent[axis] * BUCKETS as f32;
        (x as usize).min(BUCKETS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|a| extent[*a] > 0.0) {
        let mut buckets = [EmitterBounds::default(); BUCKETS];
        for i in items.iter() {
            let b = bucket(axis, i);
            buckets[b] = buckets[b].union(&emitters[*i as usize]);
        }
        let merge = |part: &[EmitterBounds]| part.iter().fold(EmitterBounds::default(), |a, b| a.union(b));
        // Long cells across the axis are worth splitting first.
        let regular = extent.max_element() / extent[axis];
        for edge in 1..BUCKETS {
            let cost = regular * (merge(&buckets[..edge]).cost() + merge(&buckets[edge..]).cost());
            if cost.is_finite() && best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, edge));
            }
        }
    }
    let Some((_, axis, edge)) = best else { return half };
    // Stable, so that the tree depends on the order of emitters alone.
    items.sort_by_key(|i| bucket(axis, i) >= edge);
    let count = items.partition_point(|i| bucket(axis, i) < edge);
    if count == 0 || count == items.len() { half } else { count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash_combine, unit_float};

    fn emitters(n: u32) -> Vec<EmitterBounds> {
        let r = |i: u32, k: u32| unit_float(hash_combine(i, k)) * 2.0 - 1.0;
        let place = |i| Vec3::new(r(i, 0), r(i, 1), r(i, 2));
        let triangle = |i| {
            let p = place(i);
            let edge = |k| Vec3::new(r(i, k), r(i, k + 1), r(i, k + 2)) * 0.05;
            let corners = [p, p + edge(3), p + edge(6)];
            let axis = edge(3).cross(edge(6)).normalize();
            let power = libm::expf(4.0 * r(i, 9));
            EmitterBounds { power, ..EmitterBounds::triangle(corners, axis, i % 5 == 0) }
        };
        (0..n).map(|i| if i % 7 == 0 { EmitterBounds::point(place(i)) } else { triangle(i) }).collect()
    }

    #[test]
    fn stated_probabilities_are_those_of_the_choice() {
        for n in [1, 2, 3, 50, 400] {
            let all = emitters(n);
            let tree = LightTree::new(&all);
            for k in 0..20 {
                let r = |i: u32| unit_float(hash_combine(k, 100 + i)) * 3.0 - 1.5;
                let normal = Vec3::new(r(3), r(4), r(5)).normalize();
                let receiver = Receiver { point: Vec3::new(r(0), r(1), r(2)), normal, both_sides: k % 2 == 0 };
                let sum: f32 = (0..n as usize).map(|i| tree.probability(&receiver, i)).sum();
                // Bounds are generous, so a descent may end where nothing contributes: what is missing to 1.
                let (mut found, tries) = (0, 4096);
                for j in 0..tries {
                    let Some((chosen, p)) = tree.sample(&receiver, (j as f32 + 0.5) / tries as f32) else { continue };
                    found += 1;
                    assert!((p - tree.probability(&receiver, chosen)).abs() <= 1e-6 * p);
                }
                let share = found as f32 / tries as f32;
                assert!((share - sum).abs() < 0.02 && sum < 1.0 + 1e-4, "{n}: {share} and {sum}");
            }
        }
    }

    /// An emitter that can light the receiver must never have probability zero.
    #[test]
    fn nothing_that_contributes_is_left_out() {
        let all = emitters(300);
        let tree = LightTree::new(&all);
        let mut lit = 0;
        for k in 0..50 {
            let r = |i: u32| unit_float(hash_combine(k, 200 + i)) * 2.0 - 1.0;
            let normal = Vec3::new(r(3), r(4), r(5)).normalize();
            let receiver = Receiver { point: Vec3::new(r(0), r(1), r(2)), normal, both_sides: false };
            for (i, e) in all.iter().enumerate() {
                let to = e.center() - receiver.point;
                let emits = e.two_sided || e.cos_spread < 0.0 || e.axis.dot(to) < 0.0;
                if emits && to.dot(normal) > 0.0 {
                    lit += 1;
                    assert!(tree.probability(&receiver, i) > 0.0, "receiver {k}, emitter {i}");
                }
            }
        }
        assert!(lit > 1000);
    }

    #[test]
    fn many_identical_emitters_do_not_make_the_tree_deep() {
        let same = vec![EmitterBounds::point(Vec3::ONE); 5000];
        let tree = LightTree::new(&same);
        let receiver = Receiver { point: Vec3::ZERO, normal: Vec3::Z, both_sides: false };
        for i in [0, 17, 4999] {
            assert!((tree.probability(&receiver, i) * 5000.0 - 1.0).abs() < 0.01);
        }
    }
}
