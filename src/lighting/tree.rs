//! A binary tree over emitters by the surface area orientation heuristic
//! (Conty Estevez & Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting"), flattened into wide
//! nodes: the first one has up to [`ROOT`] children, so that few emitters are all looked at one by one.

use super::bounds::EmitterBounds;
use glam::Vec3;

/// Children of the first node at most.
pub(super) const ROOT: usize = 128;
/// Children of the other nodes at most.
pub(super) const WIDE: usize = 16;
/// Below this depth cells are halved by count, so that the recursion ends soon.
const MOST_UNEVEN: u32 = 24;
const BUCKETS: usize = 12;

/// What a child of a wide node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    Node(u32),
    Emitter(u32),
}

/// Wide nodes; the first one is the root. Each is a list of children with their bounds.
pub(super) fn wide_nodes(emitters: &[EmitterBounds]) -> Vec<Vec<(EmitterBounds, Child)>> {
    if emitters.is_empty() {
        return Vec::new();
    }
    let mut binary = Vec::with_capacity(2 * emitters.len());
    let mut items: Vec<u32> = (0..emitters.len() as u32).collect();
    build(&mut binary, emitters, &mut items, 0);
    let mut wide = vec![Vec::new()];
    // Pairs of a wide node and the binary one that it is made of.
    let mut open = vec![(0, 0)];
    while let Some((at, top)) = open.pop() {
        let most = if at == 0 { ROOT } else { WIDE };
        for k in cut(&binary, top, most) {
            let node = &binary[k];
            let child = match node.kind {
                Kind::Emitter(emitter) => Child::Emitter(emitter),
                Kind::Inner { .. } => {
                    wide.push(Vec::new());
                    open.push((wide.len() - 1, k));
                    Child::Node(wide.len() as u32 - 1)
                }
            };
            wide[at].push((node.bounds, child));
        }
    }
    wide
}

/// The binary nodes that stand for `top`: what costs most is replaced by its children as long as there is room.
fn cut(binary: &[Node], top: usize, most: usize) -> Vec<usize> {
    let mut chosen = vec![top];
    while chosen.len() < most {
        let cost = |k: &usize| match binary[*k].kind {
            Kind::Emitter(_) => -1.0,
            Kind::Inner { .. } => binary[*k].bounds.cost(),
        };
        let costs = chosen.iter().map(cost).enumerate();
        let Some((at, worst)) = costs.reduce(|a, b| if b.1 > a.1 { b } else { a }) else { break };
        if worst < 0.0 {
            break;
        }
        let Kind::Inner { second } = binary[chosen[at]].kind else { break };
        let first = chosen[at] + 1;
        // In place of the parent, so that neighbours stay neighbours.
        chosen.splice(at..=at, [first, second]);
    }
    chosen
}

struct Node {
    bounds: EmitterBounds,
    kind: Kind,
}

enum Kind {
    /// The first child follows its parent.
    Inner {
        second: usize,
    },
    Emitter(u32),
}

fn build(nodes: &mut Vec<Node>, emitters: &[EmitterBounds], items: &mut [u32], depth: u32) {
    if let [only] = items {
        nodes.push(Node { bounds: emitters[*only as usize], kind: Kind::Emitter(*only) });
        return;
    }
    let at = nodes.len();
    let bounds = items.iter().map(|i| emitters[*i as usize]).reduce(|a, b| a.union(&b)).unwrap_or_default();
    nodes.push(Node { bounds, kind: Kind::Inner { second: 0 } });
    let middle = split(emitters, items, depth);
    let (left, right) = items.split_at_mut(middle);
    build(nodes, emitters, left, depth + 1);
    nodes[at].kind = Kind::Inner { second: nodes.len() };
    build(nodes, emitters, right, depth + 1);
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
